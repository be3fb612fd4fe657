//! What can be wrong with a mesh, or with the spheres that meet it.

use std::fmt;

use crate::error::Error;
use crate::narrow::{MAX_MAGNITUDE, MIN_MAGNITUDE, ShapeError};

/// Why a mesh, or a search over it, was refused: what is wrong, and where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DiscretisedError {
    /// A coordinate of a node is NaN or infinite, or its magnitude is neither 0 nor within the range in which predicates are exact.
    Coordinate {
        /// Zero-based number of the node.
        node: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending value.
        value: f64,
    },
    /// An element names a node that is not there.
    UnknownNode {
        /// Zero-based number of the element.
        element: usize,
        /// The node that it names.
        node: u32,
        /// Nodes of the mesh, numbered from 0.
        nodes: usize,
    },
    /// The bodies are not as many as the elements.
    Bodies {
        /// Number of elements.
        elements: usize,
        /// Number of bodies given.
        found: usize,
    },
    /// The radii are not as many as the spheres.
    Radii {
        /// Number of spheres.
        spheres: usize,
        /// Number of radii given.
        found: usize,
    },
    /// A sphere is not one.
    Sphere {
        /// Zero-based number of the sphere.
        index: usize,
        /// What is wrong with it.
        problem: ShapeError,
    },
    /// A contact names an element that the mesh does not have, or is not `i < j`.
    MalformedContact {
        /// Zero-based number of the contact.
        index: usize,
        /// Its first element.
        i: u32,
        /// Its second element.
        j: u32,
        /// Elements of the mesh, numbered from 0.
        elements: usize,
    },
    /// What the search over the bounding boxes refuses; the elements that it names are those of the mesh, or the spheres followed by these.
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
