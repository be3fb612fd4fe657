//! Why polygons cannot be put into a surface.

use std::error::Error;
use std::fmt;

use crate::tetrahedra::error::MeshError;
use crate::tetrahedra::vector::Point;

/// Distance over mesh size up to which polygons are moved.
pub const SNAP: f64 = 0.35;

/// Length over mesh size below which an edge, or a gap beside one, is refused.
pub(super) const LEAST: f64 = 0.03;

/// Smallest angle between polygons and faces, and between edges in a plane, degrees.
pub(super) const SHARP: f64 = 3.0;

/// Most polygons.
pub(super) const MOST: usize = 20_000;

/// Why polygons cannot be put into a surface. Numbers of polygons count from 0.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PolygonError {
    /// The surface itself is wrong.
    Surface(MeshError),
    /// A corner is not finite.
    NotFinite {
        /// The polygon.
        polygon: usize,
    },
    /// A polygon has less than three corners, or they are in a line.
    NoArea {
        /// The polygon.
        polygon: usize,
    },
    /// The corners of a polygon are in no plane.
    NotFlat {
        /// The polygon.
        polygon: usize,
        /// Largest distance of a corner from the mean plane.
        distance: f64,
    },
    /// A polygon crosses itself.
    Crossed {
        /// The polygon.
        polygon: usize,
    },
    /// Polygons, or a polygon and the surface, are too close to each other.
    Close {
        /// The two polygons nearest to the place; once the same where there is only one.
        polygons: [usize; 2],
        /// The place.
        place: Point,
    },
    /// Polygons, or a polygon and the surface, meet at a small angle.
    Sharp {
        /// The two polygons nearest to the place; once the same where there is only one.
        polygons: [usize; 2],
        /// The angle, degrees.
        angle: f64,
        /// The place.
        place: Point,
    },
    /// There are too many polygons.
    TooMany {
        /// Number of polygons.
        polygons: usize,
    },
}

impl fmt::Display for PolygonError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let beside = |[a, b]: [usize; 2]| {
            if a == b { format!("polygon {a} and the surface") } else { format!("polygons {a} and {b}") }
        };
        match self {
            Self::Surface(error) => error.fmt(out),
            Self::NotFinite { polygon } => {
                write!(out, "polygon {polygon} has a coordinate that is not finite or above 1e60")
            }
            Self::NoArea { polygon } => write!(out, "polygon {polygon} has no area"),
            Self::NotFlat { polygon, distance } => {
                write!(
                    out,
                    "polygon {polygon} is not flat: a corner is {distance:.2e} beside the plane of the others"
                )
            }
            Self::Crossed { polygon } => write!(out, "polygon {polygon} crosses itself"),
            Self::Close { polygons, place } => {
                write!(
                    out,
                    "{} are too close to each other for the mesh size near {place:?}",
                    beside(*polygons)
                )
            }
            Self::Sharp { polygons, angle, place } => write!(
                out,
                "{} meet at an angle of {angle:.1} degrees near {place:?}, below {SHARP}",
                beside(*polygons)
            ),
            Self::TooMany { polygons } => write!(out, "{polygons} polygons are more than {MOST}"),
        }
    }
}

impl Error for PolygonError {}
