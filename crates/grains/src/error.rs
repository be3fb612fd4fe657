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
    /// A sphere is so fast, or so far away, that its place is not known any more.
    Lost {
        /// The sphere.
        sphere: usize,
        /// The step.
        step: u64,
    },
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
            Self::Lost { sphere, step } => {
                write!(out, "sphere {sphere} has no place after step {step}: take a shorter step")
            }
            Self::Search(why) => write!(out, "search for contacts: {why}"),
        }
    }
}

impl std::error::Error for GrainError {}
