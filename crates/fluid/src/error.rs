//! Reasons why fluid cannot flow.

use std::fmt;

/// A network that is refused, or a step that cannot be taken. The network is unchanged then.
#[derive(Clone, Debug, PartialEq)]
pub enum FluidError {
    /// A quantity is out of its range, or not a number.
    OutOfRange {
        /// Owner of the quantity, such as "cell 7".
        place: String,
        /// The quantity.
        what: &'static str,
        /// The value.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// Two cells or two sources have the same key.
    SameKey {
        /// "cell" or "source".
        what: &'static str,
        /// The key.
        key: u64,
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
    /// Two corners of a cell are the same.
    Corners {
        /// Key of the cell.
        cell: u64,
        /// The corner.
        corner: u32,
    },
    /// The corners of a cell span no length or area.
    Flat {
        /// Key of the cell.
        cell: u64,
    },
    /// A source refers to a cell that does not exist.
    NoCell {
        /// Key of the source.
        source: u64,
        /// Key of the cell.
        cell: u64,
    },
    /// A source has neither a volume nor a cell: there is no cell at its place.
    NoPlace {
        /// Key of the source.
        source: u64,
    },
    /// A source without a volume injects, and none of its cells is wet.
    Unconnected {
        /// Key of the source.
        source: u64,
    },
    /// Two sources act on the same cell, such as a pressure and a rate.
    SharedCell {
        /// The cell.
        cell: u64,
        /// The sources.
        sources: [u64; 2],
    },
    /// Two boundaries prescribe the pressure of the same vertex of the pores.
    SharedVertex {
        /// The vertex.
        vertex: u32,
        /// The boundaries.
        sources: [u64; 2],
    },
    /// Two sources hold a pressure in the same cavity.
    SharedCavity {
        /// The sources.
        sources: [u64; 2],
    },
    /// A cell or a source with fluid is missing or is dry: its mass would be lost.
    MassLost {
        /// "cell" or "source".
        what: &'static str,
        /// Key of the cell or source.
        key: u64,
        /// The mass, kg.
        mass: f64,
    },
    /// The pressures of a step were not found.
    NotConverged {
        /// "cell" or "source".
        what: &'static str,
        /// Key of the one whose mass is farthest from its balance.
        key: u64,
        /// Distance of its mass from the balance, kg.
        mass: f64,
        /// The step, s.
        step: f64,
    },
    /// A pivot of the linear system is not positive, or not a number.
    Pivot {
        /// "cell", "source" or "vertex".
        what: &'static str,
        /// Key of the cell or source, or number of the vertex.
        key: u64,
    },
    /// A saved state is that of another network: the reason.
    State(String),
}

impl FluidError {
    /// The cells and sources that it names: "cell" or "source", and the key.
    pub fn places(&self) -> Vec<(&'static str, u64)> {
        match *self {
            Self::SameKey { what, key }
            | Self::MassLost { what, key, .. }
            | Self::NotConverged { what, key, .. }
            | Self::Pivot { what, key } => vec![(what, key)],
            Self::Corners { cell, .. } | Self::Flat { cell } => vec![("cell", cell)],
            Self::NoCell { source, cell } => vec![("source", source), ("cell", cell)],
            Self::NoPlace { source } | Self::Unconnected { source } => vec![("source", source)],
            Self::SharedCell { cell, sources: [a, b] } => vec![("cell", cell), ("source", a), ("source", b)],
            Self::SharedCavity { sources: [a, b] } => vec![("source", a), ("source", b)],
            Self::OutOfRange { .. } | Self::Length { .. } | Self::SharedVertex { .. } | Self::State(_) => {
                Vec::new()
            }
        }
    }
}

impl fmt::Display for FluidError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { place, what, value, range } => {
                write!(out, "{place}: {what} is {value:e}, and must be {range}")
            }
            Self::SameKey { what, key } => write!(out, "there are two of {what} {key}"),
            Self::Length { what, found, expected } => write!(out, "{found} {what} instead of {expected}"),
            Self::Corners { cell, corner } => write!(out, "cell {cell} has corner {corner} twice"),
            Self::Flat { cell } => write!(out, "the corners of cell {cell} span no length or area"),
            Self::NoCell { source, cell } => write!(out, "source {source}: there is no cell {cell}"),
            Self::NoPlace { source } => write!(out, "source {source} has neither cells nor a volume"),
            Self::Unconnected { source } => {
                write!(out, "source {source} injects where no cell is wet: give it a volume, or open a cell")
            }
            Self::SharedCell { cell, sources: [a, b] } => {
                write!(out, "sources {a} and {b} both act on cell {cell}")
            }
            Self::SharedVertex { vertex, sources: [a, b] } => {
                write!(
                    out,
                    "boundaries {a} and {b} both prescribe the pressure of vertex {vertex} of the pores"
                )
            }
            Self::SharedCavity { sources: [a, b] } => {
                write!(out, "sources {a} and {b} both hold a pressure in the same cavity")
            }
            Self::MassLost { what, key, mass } => {
                write!(out, "{what} {key} holds {mass:e} kg of fluid and is dry or missing: drain it before")
            }
            Self::NotConverged { what, key, mass, step } => write!(
                out,
                "no pressures were found for a step of {step:e} s: the mass of {what} {key} is off by {mass:e} kg; \
                 take a shorter step"
            ),
            Self::Pivot { what, key } => {
                write!(out, "the pressure at {what} {key} is not determined: its pivot is not positive")
            }
            Self::State(why) => out.write_str(why),
        }
    }
}

impl std::error::Error for FluidError {}

/// Returns an error that names the owner of a quantity, unless its value is in its range.
pub(crate) fn check(
    is_inside: bool,
    place: impl fmt::Display,
    what: &'static str,
    value: f64,
    range: &'static str,
) -> Result<(), FluidError> {
    if is_inside && value.is_finite() {
        return Ok(());
    }
    Err(FluidError::OutOfRange { place: place.to_string(), what, value, range })
}
