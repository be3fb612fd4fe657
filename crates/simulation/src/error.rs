//! What can be wrong with a model, and what ends a run.

use std::fmt;

/// Why a [`Model`](crate::Model) cannot be simulated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// There are no elements.
    Empty,
    /// Lists that should have an entry for each node or element do not.
    Length {
        /// The list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: usize,
    },
    /// A number refers to nothing.
    Missing {
        /// What is referred to: a node, a material.
        what: &'static str,
        /// The number.
        index: u32,
        /// Where it was found.
        place: String,
    },
    /// A quantity is outside of what it may be, or not a number.
    OutOfRange {
        /// Of what: a material, say, and which.
        place: String,
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// An element without area, or whose nodes are in clockwise order.
    Area {
        /// Its number.
        element: usize,
        /// Its area, m².
        area: f64,
    },
    /// A node belongs to no element.
    LooseNode {
        /// Its number.
        node: usize,
    },
    /// Two elements lie on the same side of their common edge.
    Folded {
        /// Their numbers.
        elements: [u32; 2],
    },
    /// More than two elements have an edge in common.
    ManyOnEdge {
        /// Three of them.
        elements: [u32; 3],
    },
    /// Two elements of different bodies have a node in common.
    SharedNode {
        /// The node.
        node: u32,
        /// The bodies.
        bodies: [u32; 2],
    },
    /// A boundary acts on an edge that no element has as its outer edge.
    NotOuter {
        /// The boundary.
        boundary: String,
        /// The nodes of the edge.
        edge: [u32; 2],
    },
    /// A boundary acts on edges, or on nodes, that it cannot act on.
    Target {
        /// The boundary.
        boundary: String,
        /// What it acts on.
        needs: &'static str,
    },
    /// Two boundaries move one node.
    HeldTwice {
        /// The node.
        node: u32,
        /// The axis: 0 is x.
        axis: usize,
        /// The boundaries.
        boundaries: [String; 2],
    },
    /// The fracture energy of a joint is less than what it stores before it softens.
    FractureEnergy {
        /// The material.
        material: String,
        /// An element at such a joint.
        element: u32,
        /// Fracture energy that it would need at least, J/m².
        least: f64,
    },
    /// Threads cannot be had.
    Threads {
        /// In the words of the library.
        message: String,
    },
    /// More corners of elements than numbers have room for.
    TooLarge {
        /// Elements.
        elements: usize,
    },
}

impl fmt::Display for ModelError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => out.write_str("the mesh has no elements"),
            Self::Length { what, found, expected } => {
                write!(out, "{found} {what} for {expected}")
            }
            Self::Missing { what, index, place } => write!(out, "{place}: there is no {what} {index}"),
            Self::OutOfRange { place, what, value, range } => {
                write!(out, "{place}: {what} is {value}, it must be {range}")
            }
            Self::Area { element, area } => {
                write!(
                    out,
                    "element {element} has an area of {area:e} m²: its nodes must be counter-clockwise"
                )
            }
            Self::LooseNode { node } => write!(out, "node {node} belongs to no element"),
            Self::Folded { elements: [a, b] } => {
                write!(out, "elements {a} and {b} lie on the same side of their common edge")
            }
            Self::ManyOnEdge { elements: [a, b, c] } => {
                write!(out, "elements {a}, {b} and {c} have one edge in common, two can")
            }
            Self::SharedNode { node, bodies: [a, b] } => {
                write!(out, "node {node} belongs to bodies {a} and {b}: bodies share no nodes")
            }
            Self::NotOuter { boundary, edge: [a, b] } => {
                write!(out, "boundary '{boundary}': no element has an outer edge from node {a} to node {b}")
            }
            Self::Target { boundary, needs } => write!(out, "boundary '{boundary}' needs {needs}"),
            Self::HeldTwice { node, axis, boundaries: [a, b] } => {
                let axis = ["x", "y"][*axis];
                write!(out, "node {node} is moved along {axis} by boundaries '{a}' and '{b}'")
            }
            Self::FractureEnergy { material, element, least } => write!(
                out,
                "material '{material}': joints at element {element} store more than the fracture energy before they soften: \
                 it must be above {least:.3} J/m², or the joint penalty larger, or joints adaptive"
            ),
            Self::Threads { message } => write!(out, "no threads: {message}"),
            Self::TooLarge { elements } => write!(out, "{elements} elements are too many"),
        }
    }
}

impl std::error::Error for ModelError {}

/// Why a run ended before its time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Stop {
    /// An element has turned inside out, or its corners are not numbers.
    Inverted {
        /// The element.
        element: u32,
        /// The step.
        step: u64,
        /// Its area over the undeformed one.
        ratio: f64,
    },
    /// A node is faster than anything physical.
    Runaway {
        /// An element of the node.
        element: u32,
        /// The step.
        step: u64,
        /// m/s; not a number where the force was none.
        speed: f64,
        /// m/s.
        limit: f64,
    },
    /// Energy has appeared or vanished beyond the bound.
    Energy {
        /// The element that holds most energy for its mass.
        element: u32,
        /// The step.
        step: u64,
        /// Share of what has been in the system.
        error: f64,
        /// The bound.
        bound: f64,
    },
    /// Joints have given back more than they may: what is dissipated does not come back.
    Returned {
        /// The element that holds most energy for its mass.
        element: u32,
        /// The step.
        step: u64,
        /// Share of what has been in the system.
        share: f64,
        /// The bound.
        bound: f64,
    },
    /// Detection failed.
    Detection(
        /// Why.
        fdem_contact::Error,
    ),
}

impl fmt::Display for Stop {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inverted { element, step, ratio } => {
                write!(out, "step {step}: element {element} is inverted (area ratio {ratio:.3e})")
            }
            Self::Runaway { element, step, speed, limit } => write!(
                out,
                "step {step}: element {element} has a node at {speed:.3e} m/s, beyond {limit:.3e}: the time step may be too long"
            ),
            Self::Energy { element, step, error, bound } => write!(
                out,
                "step {step}: the energy balance is off by {:.2} %, more than {:.2} %; element {element} holds most for its mass",
                100.0 * error,
                100.0 * bound
            ),
            Self::Returned { element, step, share, bound } => write!(
                out,
                "step {step}: joints have given back {:.2} % of the energy, more than {:.2} %; element {element} holds most for its mass",
                100.0 * share,
                100.0 * bound
            ),
            Self::Detection(error) => write!(out, "contact detection: {error}"),
        }
    }
}

impl std::error::Error for Stop {}

impl From<fdem_contact::Error> for Stop {
    fn from(error: fdem_contact::Error) -> Self {
        Self::Detection(error)
    }
}
