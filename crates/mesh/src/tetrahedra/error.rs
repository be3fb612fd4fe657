//! Why there is no mesh.

use std::error::Error;
use std::fmt;

use crate::mesh::MOST_ELEMENTS as MOST;
use crate::triangles::OutlineError;

/// Size over the mean thickness of a body that still gives good angles.
pub const THICK: f64 = 3.0;

/// Why a surface could not be made or meshed. Places are coordinates of the surface; numbers count from 0.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// There are no facets, points or corners.
    Empty,
    /// All points are in one plane.
    Flat,
    /// The arrays of a surface have different lengths.
    Lengths {
        /// Number of facets.
        facets: usize,
        /// Number of entries in `faces`.
        faces: usize,
        /// Number of entries in `sides`.
        sides: usize,
    },
    /// A coordinate is not finite, or above 1e60.
    NotFinite {
        /// The point.
        node: usize,
    },
    /// A length is not positive and finite.
    Length {
        /// The length.
        length: f64,
    },
    /// The size is not a positive number at a place.
    Size {
        /// The place.
        place: [f64; 3],
    },
    /// A facet has a node that does not exist.
    NoSuchNode {
        /// The facet.
        facet: usize,
    },
    /// The corners of a facet are in a line.
    Degenerate {
        /// The facet.
        facet: usize,
        /// First corner of the facet.
        place: [f64; 3],
    },
    /// A facet lacks a neighbour.
    Open {
        /// The facet.
        facet: usize,
        /// The middle of the edge where it does.
        place: [f64; 3],
    },
    /// A facet and its neighbour have different orientations.
    Orientation {
        /// The facet.
        facet: usize,
        /// The middle of their edge.
        place: [f64; 3],
    },
    /// The surface of a region is inside out.
    Inverted {
        /// The region.
        region: u32,
    },
    /// Two facets cross, or touch where they have no common node.
    Crossing {
        /// The facets.
        facets: [usize; 2],
        /// The middle of the first.
        place: [f64; 3],
    },
    /// Two facets have the same corners.
    Twice {
        /// The facets.
        facets: [usize; 2],
        /// First corner of the facets.
        place: [f64; 3],
    },
    /// Facets contradict each other about the regions at their sides.
    Sides {
        /// A place at one of the facets.
        place: [f64; 3],
    },
    /// A body that has to be convex is not.
    NotConvex {
        /// A facet with nodes before it.
        facet: usize,
    },
    /// An outline crosses or touches itself.
    Outline {
        /// A corner there.
        place: [f64; 2],
    },
    /// A hole of an outline is not inside it, or in another hole.
    Hole(OutlineError),
    /// There would be too many elements.
    TooMany {
        /// About how many.
        elements: f64,
    },
    /// A region is so thin beside the size that its elements would be flat.
    Thin {
        /// The region.
        region: u32,
        /// Mean thickness of the region.
        thickness: f64,
        /// The mean size at its surface.
        size: f64,
    },
    /// A round body or hole is so slender that its facets, which are not longer than wide, are too many.
    Slender {
        /// Radius of the body or hole.
        radius: f64,
        /// Length of the body or hole.
        length: f64,
        /// About how many elements it would take.
        elements: f64,
    },
    /// Facets are so near to each other, or angles so sharp, that the surface is not met after many splits.
    NotRecovered {
        /// Where.
        place: [f64; 3],
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the surface is empty"),
            Self::Flat => write!(f, "the body has no volume: all points are in one plane"),
            Self::Lengths { facets, faces, sides } => {
                write!(f, "{facets} facets, but {faces} numbers of faces and {sides} pairs of sides")
            }
            Self::NotFinite { node } => {
                write!(f, "point {node} has a coordinate that is not finite or above 1e60")
            }
            Self::Length { length } => write!(f, "a length is {length}, but has to be positive"),
            Self::Size { place } => write!(f, "the mesh size is not positive at {place:?}"),
            Self::NoSuchNode { facet } => write!(f, "facet {facet} has a node that does not exist"),
            Self::Degenerate { facet, place } => {
                write!(f, "facet {facet} has no area: its corners are in a line at {place:?}")
            }
            Self::Open { facet, place } => {
                write!(f, "the surface is not closed: facet {facet} lacks a neighbour at {place:?}")
            }
            Self::Orientation { facet, place } => {
                write!(f, "facet {facet} and its neighbour at {place:?} have different orientations")
            }
            Self::Inverted { region } => {
                write!(f, "the surface is inside out or encloses no volume")?;
                if *region > 0 { write!(f, " (that of its part {})", region + 1) } else { Ok(()) }
            }
            Self::Crossing { facets: [one, other], place } => {
                write!(f, "facets {one} and {other} cross or touch near {place:?}")
            }
            Self::Twice { facets: [one, other], place } => {
                write!(
                    f,
                    "facets {one} and {other} are the same, with a corner at {place:?}: one of them is too many"
                )
            }
            Self::Sides { place } => {
                write!(f, "facets near {place:?} contradict each other about which side is inside")
            }
            Self::NotConvex { facet } => write!(f, "the body is not convex at facet {facet}"),
            Self::Outline { place } => write!(f, "the outline crosses or touches itself near {place:?}"),
            Self::Hole(error) => error.fmt(f),
            Self::TooMany { elements } => {
                write!(f, "the mesh size is too small: about {elements:.0} elements, of at most {MOST}")
            }
            Self::Thin { thickness, size, .. } => write!(
                f,
                "the body is {thickness:.2e} thick in the mean, and a mesh size of {size:.2e} would make flat elements; take {:.2e} at most, or a thicker body",
                THICK * thickness
            ),
            Self::Slender { radius, length, elements } => write!(
                f,
                "a radius of {radius:.2e} along a length of {length:.2e} would take about {elements:.1e} elements, of at most {MOST}: elements are not longer than wide; take a larger radius"
            ),
            Self::NotRecovered { place } => {
                write!(
                    f,
                    "the surface cannot be meshed near {place:?}: parts are too near or angles too sharp"
                )
            }
        }
    }
}

impl Error for MeshError {}

impl MeshError {
    /// The same error with its places in other coordinates.
    pub(super) fn placed(self, outward: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        match self {
            Self::Size { place } => Self::Size { place: outward(place) },
            Self::Sides { place } => Self::Sides { place: outward(place) },
            Self::NotRecovered { place } => Self::NotRecovered { place: outward(place) },
            other => other,
        }
    }
}
