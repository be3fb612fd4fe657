//! The errors of meshes, and of the spheres that touch them.

use std::fmt;

use crate::error::Error;
use crate::narrow::{MAX_MAGNITUDE, MIN_MAGNITUDE, ShapeError};

/// The reason why a mesh, or a search over it, was refused, and where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DiscretisedError {
    /// A coordinate of a node is NaN or infinite, or its magnitude is neither 0 nor within the range in which
    /// predicates are exact.
    Coordinate {
        /// Zero-based number of the node.
        node: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending value.
        value: f64,
    },
    /// An element names a node that does not exist.
    UnknownNode {
        /// Zero-based number of the element.
        element: usize,
        /// The node.
        node: u32,
        /// Number of nodes of the mesh; they are numbered from 0.
        nodes: usize,
    },
    /// The number of bodies differs from that of the elements.
    Bodies {
        /// Number of elements.
        elements: usize,
        /// Number of bodies given.
        found: usize,
    },
    /// The number of radii differs from that of the spheres.
    Radii {
        /// Number of spheres.
        spheres: usize,
        /// Number of radii given.
        found: usize,
    },
    /// A sphere is not valid.
    Sphere {
        /// Zero-based number of the sphere.
        index: usize,
        /// The problem.
        problem: ShapeError,
    },
    /// A contact names an element that the mesh does not have, or is not `i < j`.
    MalformedContact {
        /// Zero-based number of the contact.
        index: usize,
        /// The first element of the contact.
        i: u32,
        /// The second element of the contact.
        j: u32,
        /// Number of elements of the mesh; they are numbered from 0.
        elements: usize,
    },
    /// An error of the search over the bounding boxes. Its element numbers are those of the mesh, or spheres
    /// first, then elements.
    Search(Error),
}

impl fmt::Display for DiscretisedError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Coordinate { node, axis, value } => write!(
                out,
                "node {node}, axis {axis}: {value:?} is neither 0 nor of a magnitude between {MIN_MAGNITUDE:e} and {MAX_MAGNITUDE:e}"
            ),
            Self::UnknownNode { element, node, nodes } => {
                write!(out, "element {element} names node {node} of a mesh of {nodes} nodes")
            }
            Self::Bodies { elements, found } => write!(out, "{elements} elements but {found} bodies"),
            Self::Radii { spheres, found } => write!(out, "{spheres} spheres but {found} radii"),
            Self::Sphere { index, problem } => write!(out, "sphere {index}: {problem}"),
            Self::MalformedContact { index, i, j, elements } => write!(
                out,
                "contact {index} is of ({i}, {j}), not i < j < {elements}, the number of elements"
            ),
            Self::Search(error) => error.fmt(out),
        }
    }
}

impl std::error::Error for DiscretisedError {}

impl From<Error> for DiscretisedError {
    fn from(error: Error) -> Self {
        Self::Search(error)
    }
}
