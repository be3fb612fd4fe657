//! The errors of shapes.

use std::fmt;

use super::exact::{MAX_MAGNITUDE, MIN_MAGNITUDE};

/// The reason why a shape was refused, and where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShapeError {
    /// A coordinate is NaN or infinite, or its magnitude is neither 0 nor within the range in which
    /// predicates are exact.
    Coordinate {
        /// Zero-based number of the vertex; 0 for a centre. For a plane, 1 is its normal; for an oriented
        /// box, 1 means its half edges.
        vertex: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending value.
        value: f64,
    },
    /// A radius is negative or NaN, or its magnitude is neither 0 nor within the range.
    Radius {
        /// The offending value.
        value: f64,
    },
    /// The normal of a plane is zero.
    NoNormal,
    /// A polygon has no vertices.
    NoVertices,
    /// A polygon turns the wrong way, folds back, or winds around more than once.
    NotConvex {
        /// Zero-based number of the first vertex where this happens.
        vertex: usize,
    },
    /// Half an edge of an oriented box is negative.
    NegativeEdge {
        /// Zero-based axis of the box.
        axis: usize,
        /// The offending value.
        value: f64,
    },
    /// The axes of an oriented box do not have length 1, or are not at right angles.
    NotOrthonormal {
        /// Two zero-based axes; the same one twice if its length is wrong.
        axes: [usize; 2],
        /// Dot product of the two axes.
        product: f64,
    },
    /// A triangle number that the mesh does not have.
    UnknownTriangle {
        /// The number.
        triangle: u32,
        /// Number of triangles of the mesh; they are numbered from 0.
        triangles: usize,
    },
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Coordinate { vertex, axis, value } => write!(
                f,
                "vertex {vertex}, axis {axis}: {value:?} is neither 0 nor of a magnitude between {MIN_MAGNITUDE:e} and {MAX_MAGNITUDE:e}"
            ),
            Self::Radius { value } => {
                write!(f, "radius {value:?} is neither 0 nor between {MIN_MAGNITUDE:e} and {MAX_MAGNITUDE:e}")
            }
            Self::NoNormal => write!(f, "the normal of the plane is zero"),
            Self::NoVertices => write!(f, "the polygon has no vertices"),
            Self::NotConvex { vertex } => write!(f, "the polygon is not convex at vertex {vertex}"),
            Self::NegativeEdge { axis, value } => {
                write!(f, "half of edge {axis} of the box is negative: {value}")
            }
            Self::NotOrthonormal { axes: [i, j], product } if i == j => {
                write!(f, "axis {i} of the box is not of length 1: its square is {product}")
            }
            Self::NotOrthonormal { axes: [i, j], product } => {
                write!(
                    f,
                    "axes {i} and {j} of the box are not at right angles: their dot product is {product}"
                )
            }
            Self::UnknownTriangle { triangle, triangles } => {
                write!(f, "triangle {triangle} of a mesh of {triangles} triangles")
            }
        }
    }
}

impl std::error::Error for ShapeError {}
