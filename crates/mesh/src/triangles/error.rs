//! Why an outline has no mesh.

use std::error::Error;
use std::fmt;

use spade::InsertionError;

/// Why an outline could not be meshed or filled with grains. Holes count from 1; places are coordinates of
/// the outline.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum OutlineError {
    /// There would be too many elements.
    TooMany {
        /// About how many.
        elements: f64,
    },
    /// A hole is not inside the outline.
    HoleOutside {
        /// The hole.
        hole: usize,
        /// The corner that is outside.
        place: [f64; 2],
    },
    /// A hole is in another.
    HoleInHole {
        /// The hole.
        hole: usize,
        /// The one around it.
        around: usize,
    },
    /// Two corners are in one place.
    Twice {
        /// The place.
        place: [f64; 2],
    },
    /// The size is too small beside the outline.
    SizeTooSmall,
    /// Coordinates that cannot be triangulated.
    Coordinates {
        /// The part of the input with these coordinates.
        what: &'static str,
        /// The reason.
        why: &'static str,
    },
    /// Two points of the outline are in one place after it is cut.
    Coincide,
    /// The outline crosses or touches itself.
    Crossing {
        /// A point there.
        place: [f64; 2],
    },
    /// The outline has no area.
    NoArea,
    /// Too many grains for the edges of the outline.
    TooManyGrains {
        /// Number of grains.
        grains: usize,
        /// Number of edges.
        edges: usize,
    },
    /// The outline fills too little of its bounding box.
    TooThin,
    /// No random point is inside the outline.
    NoRoom,
}

impl OutlineError {
    /// Why points cannot be triangulated.
    pub(super) fn coordinates(what: &'static str, error: InsertionError) -> Self {
        let why = match error {
            InsertionError::TooSmall => "a number is nearly 0, but not 0",
            InsertionError::TooLarge => "a number is too large",
            InsertionError::NAN => "a number is not finite",
        };
        Self::Coordinates { what, why }
    }
}

impl fmt::Display for OutlineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooMany { elements } => {
                write!(
                    f,
                    "the mesh size is too small: about {elements:.0} elements, of at most {}",
                    crate::MOST_ELEMENTS
                )
            }
            Self::HoleOutside { hole, place } => {
                write!(f, "hole {hole} is not inside the outline: {place:?} is beyond")
            }
            Self::HoleInHole { hole, around } => write!(f, "hole {hole} is in hole {around}"),
            Self::Twice { place } => write!(f, "the outline comes to the point {place:?} twice"),
            Self::SizeTooSmall => write!(f, "the mesh size is too small for this outline"),
            Self::Coordinates { what, why } => write!(f, "coordinates of {what}: {why}"),
            Self::Coincide => write!(f, "two points of the outline coincide"),
            Self::Crossing { place } => write!(f, "the outline crosses or touches itself near {place:?}"),
            Self::NoArea => write!(f, "the outline has no area"),
            Self::TooManyGrains { grains, edges } => {
                write!(f, "{grains} grains in an outline of {edges} edges are too many")
            }
            Self::TooThin => {
                write!(f, "the outline is too thin for grains: it fills too little of its bounding box")
            }
            Self::NoRoom => write!(f, "the outline has no room for grains"),
        }
    }
}

impl Error for OutlineError {}
