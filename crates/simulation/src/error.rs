//! Errors of models, and reasons why a run stops.

use std::fmt;

use fdem_distributed::wire::Wire;
use fdem_fluid::FluidError;
use fdem_grains::GrainError;

/// Reason why a [`Model`](crate::Model) cannot be simulated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// The model has neither elements nor spheres.
    Empty,
    /// The spheres or walls cannot be simulated.
    Grains(
        /// The reason.
        GrainError,
    ),
    /// Spheres are not divided among ranks.
    GrainsOnRanks,
    /// The fluid cannot be simulated.
    Fluid(
        /// The reason.
        FluidError,
    ),
    /// Pores are where they cannot be: the reason.
    Pores(&'static str),
    /// A list does not have an entry for each node or element.
    Length {
        /// The list.
        what: &'static str,
        /// Length of the list.
        found: usize,
        /// Length that it should have.
        expected: usize,
    },
    /// A number refers to something that does not exist.
    Missing {
        /// Kind of thing that is referred to, such as a node or a material.
        what: &'static str,
        /// The number.
        index: u32,
        /// Place where the number was found.
        place: String,
    },
    /// A quantity is out of its range, or not a number.
    OutOfRange {
        /// Owner of the quantity, such as a material with its name.
        place: String,
        /// The quantity.
        what: &'static str,
        /// Value of the quantity.
        value: f64,
        /// Range in words.
        range: &'static str,
    },
    /// An element has no area, or its nodes are in clockwise order.
    Area {
        /// Number of the element.
        element: usize,
        /// Area of the element, m².
        area: f64,
    },
    /// A node belongs to no element.
    LooseNode {
        /// Number of the node.
        node: usize,
    },
    /// Two elements lie on the same side of their common edge.
    Folded {
        /// Numbers of the elements.
        elements: [u32; 2],
    },
    /// More than two elements have an edge in common.
    ManyOnEdge {
        /// Three of them.
        elements: [u32; 3],
    },
    /// Two elements of different bodies have a node in common, and it is not on a joint of a joint set.
    SharedNode {
        /// The node.
        node: u32,
        /// The bodies.
        bodies: [u32; 2],
    },
    /// A boundary acts on an edge that is not on the outline.
    NotOuter {
        /// The boundary.
        boundary: String,
        /// Nodes of the facet.
        facet: Vec<u32>,
    },
    /// A boundary has the wrong kind of target, or none.
    Target {
        /// The boundary.
        boundary: String,
        /// Kind of target that it needs.
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
    /// The supports of a rigid body contradict each other, or leave a rotation about another point than its
    /// centre of mass.
    RigidSupport {
        /// Number of the body.
        body: u32,
        /// The boundaries.
        boundaries: [String; 2],
        /// Whether they leave such a rotation.
        turns: bool,
    },
    /// A body cannot be rigid until it is overloaded.
    UntilOverloaded {
        /// Number of the body.
        body: u32,
        /// The reason.
        why: &'static str,
    },
    /// The fracture energy of a joint is less than the energy that it stores before it softens.
    FractureEnergy {
        /// The material.
        material: String,
        /// An element at such a joint.
        element: u32,
        /// Least fracture energy that is possible, J/m².
        least: f64,
        /// Whether it is the energy of sliding (mode II); otherwise that of opening (mode I).
        sliding: bool,
    },
    /// The fracture energy of a joint of a set is less than the energy that it stores before it softens.
    SetEnergy {
        /// The joint set.
        set: String,
        /// An element at such a joint.
        element: u32,
        /// Least fracture energy that is possible, J/m².
        least: f64,
        /// Whether it is the energy of sliding (mode II); otherwise that of opening (mode I).
        sliding: bool,
    },
    /// Threads could not be started.
    Threads {
        /// Message of the library.
        message: String,
    },
    /// Contact detection could not begin: of the surfaces that touch at the beginning, or with this buffer.
    Detection {
        /// Message of the detection.
        message: String,
    },
    /// A run cannot be put on a device.
    OnDevice {
        /// The reason.
        why: String,
    },
    /// A run cannot be divided among this number of ranks.
    Ranks {
        /// Number of ranks.
        ranks: usize,
        /// Number of elements of the model.
        elements: usize,
    },
    /// An absorbing boundary has no factor that could be set.
    NoFactor {
        /// Name of the boundary.
        boundary: String,
    },
    /// There are more corners of elements than can be numbered.
    TooLarge {
        /// Number of elements.
        elements: usize,
    },
}

/// A number as text. No number has hundreds of digits.
fn short(value: f64) -> String {
    let is_long = value.is_normal() && !(1e-5..1e16).contains(&value.abs());
    if is_long { format!("{value:e}") } else { value.to_string() }
}

impl fmt::Display for ModelError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => out.write_str("the model has no elements and no spheres"),
            Self::Grains(error) => write!(out, "grains: {error}"),
            Self::GrainsOnRanks => {
                out.write_str("spheres without bodies are not divided among ranks: run them on threads")
            }
            Self::Fluid(error) => write!(out, "fluid: {error}"),
            Self::Pores(why) => write!(out, "pores: {why}"),
            Self::Length { what, found, expected } => write!(out, "{found} {what} for {expected}"),
            Self::UntilOverloaded { body, why } => {
                write!(out, "body {body} cannot be rigid until it is overloaded: {why}")
            }
            Self::Missing { what, index, place } => write!(out, "{place}: there is no {what} {index}"),
            Self::OutOfRange { place, what, value, range } => {
                write!(out, "{place}: {what} is {}, it must be {range}", short(*value))
            }
            Self::Area { element, area } if !area.is_finite() => {
                write!(
                    out,
                    "element {element} has an area, or volume, beyond the largest number: its coordinates are too large"
                )
            }
            Self::Area { element, area } => {
                let rule = "its nodes are in the wrong order";
                write!(out, "element {element} has an area, or volume, of {area:e}: {rule}")
            }
            Self::LooseNode { node } => write!(out, "node {node} belongs to no element"),
            Self::Folded { elements: [a, b] } => {
                write!(out, "elements {a} and {b} lie on the same side of their common edge or face")
            }
            Self::ManyOnEdge { elements: [a, b, c] } => {
                write!(out, "elements {a}, {b} and {c} have one edge or face in common, two can")
            }
            Self::SharedNode { node, bodies: [a, b] } => {
                let rule = "bodies share no nodes, except on joints of joint sets";
                write!(out, "node {node} belongs to bodies {a} and {b}: {rule}")
            }
            Self::NotOuter { boundary, facet } => match facet[..] {
                [a, b] => {
                    write!(
                        out,
                        "boundary '{boundary}': no element has an outer edge from node {a} to node {b}"
                    )
                }
                _ => write!(
                    out,
                    "boundary '{boundary}': no element has an outer face with the nodes {facet:?}, counter-clockwise seen from outside"
                ),
            },
            Self::Target { boundary, needs } => write!(out, "boundary '{boundary}' needs {needs}"),
            Self::HeldTwice { node, axis, boundaries: [a, b] } => {
                let axis = ["x", "y", "z"][*axis];
                write!(out, "node {node} is moved along {axis} by boundaries '{a}' and '{b}'")
            }
            Self::RigidSupport { body, boundaries: [a, _], turns: true } => write!(
                out,
                "boundary '{a}' leaves the rigid body {body} a rotation about a point or a line that it holds: it can only \
                 hold its rotation altogether, or leave one about an axis of coordinates through the centre of mass; hold \
                 the whole body"
            ),
            Self::RigidSupport { body, boundaries: [a, b], turns: false } => {
                write!(
                    out,
                    "boundaries '{a}' and '{b}' move the rigid body {body} in different ways along one axis"
                )
            }
            Self::FractureEnergy { material, element, least, sliding } => {
                let ModeWords { of, numeral, .. } = ModeWords::new(*sliding);
                write!(
                    out,
                    "material '{material}': joints at element {element} store more than the fracture energy of {of} before they soften: \
                     fracture_energy_{numeral} must be above {} J/m², or the joint penalty larger, or joints adaptive",
                    rounded_up(*least)
                )
            }
            Self::SetEnergy { set, element, least, sliding } => {
                let ModeWords { of, numeral, strength, stiffness } = ModeWords::new(*sliding);
                write!(
                    out,
                    "joint set '{set}': joints at element {element} store more than the fracture energy of {of} before they soften: \
                     fracture_energy_{numeral} must be above {strength}²/(2 {stiffness}) = {} J/m², or {stiffness} larger",
                    rounded_up(*least)
                )
            }
            Self::Threads { message } => write!(out, "no threads: {message}"),
            Self::Detection { message } => write!(out, "contact detection: {message}"),
            Self::OnDevice { why } => write!(out, "{why}"),
            Self::Ranks { ranks: 0, .. } => write!(out, "a run on 0 ranks computes nothing"),
            Self::Ranks { ranks, elements } => {
                write!(out, "{ranks} ranks are more than the {elements} elements of the model")
            }
            Self::NoFactor { boundary } => {
                write!(out, "boundary '{boundary}' absorbs waves: it has no factor")
            }
            Self::TooLarge { elements } => write!(out, "{elements} elements are too many"),
        }
    }
}

impl std::error::Error for ModelError {}

impl From<FluidError> for ModelError {
    fn from(error: FluidError) -> Self {
        Self::Fluid(error)
    }
}

impl From<GrainError> for ModelError {
    fn from(error: GrainError) -> Self {
        Self::Grains(error)
    }
}

/// Words for a mode of fracture.
struct ModeWords {
    of: &'static str,
    numeral: &'static str,
    strength: &'static str,
    stiffness: &'static str,
}

impl ModeWords {
    fn new(sliding: bool) -> Self {
        if sliding {
            Self { of: "sliding", numeral: "ii", strength: "cohesion", stiffness: "shear_stiffness" }
        } else {
            Self { of: "opening", numeral: "i", strength: "tensile_strength", stiffness: "normal_stiffness" }
        }
    }
}

/// A positive number to four digits, rounded up unless the rest is an error of rounding.
fn rounded_up(number: f64) -> String {
    let digit = libm::pow(10.0, libm::floor(libm::log10(number)) - 3.0);
    let up = libm::ceil(number / digit - 1e-6) * digit;
    let up: f64 = format!("{up:.3e}").parse().unwrap_or(number);
    // No number has hundreds of digits, and some are too small for the logarithm.
    match up {
        _ if !up.is_finite() => format!("{number:.3e}"),
        _ if (1e-4..1e7).contains(&up) => up.to_string(),
        _ => format!("{up:e}"),
    }
}

/// Reason why a run stopped before its end.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Stop {
    /// An element has turned inside out, or its corners are not numbers.
    Inverted {
        /// The element.
        element: u32,
        /// The step.
        step: u64,
        /// Area of the element over its undeformed area.
        ratio: f64,
    },
    /// A node is faster than is physically possible.
    Runaway {
        /// An element of the node.
        element: u32,
        /// The step.
        step: u64,
        /// Speed, m/s; NaN if the force is NaN.
        speed: f64,
        /// Limit of the speed, m/s.
        limit: f64,
    },
    /// The error of the energy balance is beyond the bound.
    Energy {
        /// The element that holds most energy for its mass; `u32::MAX` in a run of spheres alone.
        element: u32,
        /// The step.
        step: u64,
        /// Error as a share of the energy exchanged.
        error: f64,
        /// The bound.
        bound: f64,
    },
    /// Kinetic energy exceeds all that could have become kinetic energy.
    Kinetic {
        /// The element that holds most energy for its mass; `u32::MAX` in a run of spheres alone.
        element: u32,
        /// The step.
        step: u64,
        /// Kinetic energy, J.
        kinetic: f64,
        /// Energy that was there at the beginning or was put in, J.
        available: f64,
    },
    /// Joints have given back energy that they had dissipated.
    Returned {
        /// The element that holds most energy for its mass; `u32::MAX` in a run of spheres alone.
        element: u32,
        /// The step.
        step: u64,
        /// Energy given back as a share of the energy exchanged.
        share: f64,
        /// The bound.
        bound: f64,
    },
    /// Contact detection failed.
    Detection(
        /// The error of the detection.
        fdem_contact::Error,
    ),
    /// The spheres cannot continue.
    Grains(
        /// The reason.
        GrainError,
    ),
    /// The fluid cannot continue, for this reason.
    Fluid(String),
    /// A run cannot continue with a body that was rigid until it was overloaded, for this reason.
    Released(String),
    /// A device has failed, for this reason.
    Device(String),
    /// A rank of a run of many cannot continue.
    OnRank {
        /// The rank.
        rank: usize,
        /// The reason of that rank.
        reason: String,
    },
}

impl Stop {
    /// The element that it names, or a number above those of all elements.
    pub(crate) fn element(&self) -> u32 {
        match *self {
            Self::Inverted { element, .. }
            | Self::Runaway { element, .. }
            | Self::Energy { element, .. }
            | Self::Kinetic { element, .. }
            | Self::Returned { element, .. } => element,
            Self::Detection(_)
            | Self::Grains(_)
            | Self::Fluid(_)
            | Self::Released(_)
            | Self::Device(_)
            | Self::OnRank { .. } => u32::MAX,
        }
    }

    /// The reason for other ranks: the same, or that of this rank.
    pub(crate) fn on_rank(self, rank: usize) -> Self {
        match self {
            Self::Detection(error) => Self::OnRank { rank, reason: error.to_string() },
            Self::Grains(error) => Self::OnRank { rank, reason: error.to_string() },
            Self::Fluid(reason) | Self::Released(reason) | Self::Device(reason) => {
                Self::OnRank { rank, reason }
            }
            stop => stop,
        }
    }
}

impl Wire for Stop {
    fn put(&self, out: &mut Vec<u8>) {
        match self {
            &Self::Inverted { element, step, ratio } => (0_u8, (element, (step, [ratio, 0.0]))).put(out),
            &Self::Runaway { element, step, speed, limit } => {
                (1_u8, (element, (step, [speed, limit]))).put(out);
            }
            &Self::Energy { element, step, error, bound } => {
                (2_u8, (element, (step, [error, bound]))).put(out);
            }
            &Self::Kinetic { element, step, kinetic, available } => {
                (3_u8, (element, (step, [kinetic, available]))).put(out);
            }
            &Self::Returned { element, step, share, bound } => {
                (4_u8, (element, (step, [share, bound]))).put(out);
            }
            Self::Detection(error) => (5_u8, (0_u64, error.to_string())).put(out),
            Self::Grains(error) => (5_u8, (0_u64, error.to_string())).put(out),
            Self::Fluid(reason) | Self::Released(reason) | Self::Device(reason) => {
                (5_u8, (0_u64, reason.clone())).put(out);
            }
            Self::OnRank { rank, reason } => (5_u8, (*rank as u64, reason.clone())).put(out),
        }
    }

    fn take(bytes: &mut &[u8]) -> Self {
        let kind = u8::take(bytes);
        if kind == 5 {
            let (rank, reason) = <(u64, String)>::take(bytes);
            return Self::OnRank { rank: rank as usize, reason };
        }
        let (element, (step, [one, other])) = <(u32, (u64, [f64; 2]))>::take(bytes);
        match kind {
            0 => Self::Inverted { element, step, ratio: one },
            1 => Self::Runaway { element, step, speed: one, limit: other },
            2 => Self::Energy { element, step, error: one, bound: other },
            3 => Self::Kinetic { element, step, kinetic: one, available: other },
            _ => Self::Returned { element, step, share: one, bound: other },
        }
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inverted { element, step, ratio } => {
                write!(
                    out,
                    "step {step}: element {element} is inverted: its area, or volume, is {ratio:.3e} times that at the start"
                )
            }
            Self::Runaway { element, step, speed, limit } => write!(
                out,
                "step {step}: element {element} has a node at {speed:.3e} m/s, beyond {limit:.3e}: the time step may be too long, or a load or a velocity too large"
            ),
            Self::Energy { element, step, error, bound } => write!(
                out,
                "step {step}: the energy balance is off by {} %, more than {} %{}",
                percent(*error),
                percent(*bound),
                hottest(*element)
            ),
            Self::Kinetic { element, step, kinetic, available } => write!(
                out,
                "step {step}: the kinetic energy is {kinetic:.4e} J, more than the {available:.4e} J that were there or put in{}",
                hottest(*element)
            ),
            Self::Returned { element, step, share, bound } => write!(
                out,
                "step {step}: joints have given back energy that they had dissipated, {} % of the energy exchanged, more than {} %{}",
                percent(*share),
                percent(*bound),
                hottest(*element)
            ),
            Self::Detection(error) => write!(out, "contact detection: {error}"),
            Self::Grains(error) => write!(out, "grains: {error}"),
            Self::Fluid(reason) => write!(out, "fluid: {reason}"),
            Self::Released(reason) => write!(out, "a body that was rigid until it was overloaded: {reason}"),
            Self::Device(reason) => write!(out, "the device has failed: {reason}"),
            Self::OnRank { rank, reason } => write!(out, "rank {rank}: {reason}"),
        }
    }
}

/// The element that holds most energy for its mass, in words; none in a run of spheres alone.
fn hottest(element: u32) -> String {
    if element == u32::MAX { String::new() } else { format!("; element {element} holds most for its mass") }
}

/// A share in percent, with digits that are not all 0.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || (0.01..1e6).contains(&percent.abs()) {
        format!("{percent:.2}")
    } else {
        format!("{percent:.1e}")
    }
}

impl std::error::Error for Stop {}

impl From<GrainError> for Stop {
    fn from(error: GrainError) -> Self {
        Self::Grains(error)
    }
}

impl From<fdem_contact::Error> for Stop {
    fn from(error: fdem_contact::Error) -> Self {
        Self::Detection(error)
    }
}
