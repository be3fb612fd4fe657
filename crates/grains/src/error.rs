//! Reasons why spheres cannot be simulated.

use std::fmt;

/// A model of spheres that is refused, or a run that cannot continue.
#[derive(Clone, Debug, PartialEq)]
pub enum GrainError {
    /// A quantity is out of its range, or not a number.
    OutOfRange {
        /// Owner of the quantity, such as "sphere 7".
        place: String,
        /// The quantity.
        what: &'static str,
        /// The value.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// Two materials touch, and nothing is known of their surfaces.
    UnknownSurfaces {
        /// The materials.
        materials: [u32; 2],
    },
    /// A list has another length than it must have.
    Length {
        /// The list.
        what: &'static str,
        /// The length.
        found: usize,
        /// The length that it must have.
        expected: usize,
    },
    /// A number refers to a material that does not exist.
    Material {
        /// Owner of the number.
        place: String,
        /// The number.
        material: u32,
    },
    /// A clump cannot be simulated.
    Clump {
        /// Number of the clump.
        clump: usize,
        /// The reason.
        why: &'static str,
    },
    /// A number refers to a point that does not exist.
    Point {
        /// Owner of the number.
        place: String,
        /// The number.
        point: u32,
    },
    /// A sphere is so fast, or so far away, that its place is not known any more.
    Lost {
        /// The sphere.
        sphere: usize,
        /// The step.
        step: u64,
    },
    /// A sphere that is to come in overlaps another one, a wall or a body.
    NoRoom {
        /// Its place among those that are to come in.
        sphere: usize,
    },
    /// The step is too long for the springs and dashpots across the contacts of a sphere, which would turn to
    /// and fro ever faster.
    Unstable {
        /// The sphere.
        sphere: u32,
        /// The number of its contacts that do not slide.
        contacts: usize,
        /// The step, s.
        step: f64,
        /// A step that is stable, s.
        longest: f64,
    },
    /// A sphere has left the box along an axis that does not repeat.
    Outside {
        /// The sphere.
        sphere: u32,
        /// The step.
        step: u64,
    },
    /// A periodic box is so short that a sphere might touch two images of another one.
    Box {
        /// The axis: 0 for x.
        axis: usize,
        /// Length of the box along it, m.
        length: f64,
        /// The length that it must exceed, m.
        least: f64,
    },
    /// Spheres cannot continue with another model: the reason.
    Changed(String),
    /// A law of the caller failed, or its result is wrong.
    Law(String),
    /// The search for contacts failed.
    Search(String),
}

impl fmt::Display for GrainError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { place, what, value, range } => {
                write!(out, "{place}: {what} is {value:e}, and must be {range}")
            }
            Self::UnknownSurfaces { materials: [a, b] } => {
                write!(out, "materials {a} and {b} may touch, and have no surfaces in common")
            }
            Self::Length { what, found, expected } => write!(out, "{found} {what} instead of {expected}"),
            Self::Material { place, material } => write!(out, "{place}: there is no material {material}"),
            Self::Clump { clump, why } => write!(out, "clump {clump}: {why}"),
            Self::Point { place, point } => write!(out, "{place}: there is no point {point}"),
            Self::Lost { sphere, step } => {
                write!(out, "sphere {sphere} has no place after step {step}: take a shorter step")
            }
            Self::Unstable { sphere, contacts, step, longest } => write!(
                out,
                "the step of {step:.1e} s is too long for sphere {sphere}, which touches {contacts} others: take at \
                 most {longest:.1e} s"
            ),
            Self::NoRoom { sphere } => {
                write!(out, "sphere {sphere} of those to add overlaps another sphere, a wall or a body")
            }
            Self::Outside { sphere, step } => write!(out, "sphere {sphere} has left the box in step {step}"),
            Self::Box { axis, length, least } => write!(
                out,
                "the periodic box is {length:e} m long along {}, and must be longer than {least:e} m: twice the \
                 largest diameter and gap",
                ["x", "y", "z"][*axis]
            ),
            Self::Changed(why) => out.write_str(why),
            Self::Law(why) => write!(out, "law of the program: {why}"),
            Self::Search(why) => write!(out, "search for contacts: {why}"),
        }
    }
}

impl std::error::Error for GrainError {}
