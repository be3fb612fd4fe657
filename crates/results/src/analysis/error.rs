//! Reasons why a network cannot be analysed.

use std::fmt;

/// Why a network cannot be analysed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The network is neither 2D nor 3D.
    Dimensions {
        /// Number of dimensions of the network.
        dimensions: usize,
    },
    /// The inner region is empty, or its limits are not finite.
    Region {
        /// The axis.
        axis: usize,
        /// Limits of the region on the axis.
        limits: [f64; 2],
    },
    /// The box is sheared, but an inner region has faces at right angles to the axes.
    ShearedBox,
    /// The largest distance or the number of bins is invalid.
    Radial {
        /// Description of the problem.
        problem: String,
    },
    /// The search for the radial distribution was refused.
    Search(fdem_contact::Error),
}

impl fmt::Display for AnalysisError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dimensions { dimensions } => {
                write!(out, "a network in {dimensions}D cannot be analysed, only in 2D and 3D")
            }
            Self::Region { axis, limits: [min, max] } => {
                write!(out, "the inner region is empty along axis {axis}: from {min} to {max}")
            }
            Self::ShearedBox => out.write_str(
                "an inner region has edges along the axes and cannot be measured in a sheared box",
            ),
            Self::Radial { problem } => write!(out, "the radial distribution: {problem}"),
            Self::Search(error) => write!(out, "the radial distribution: {error}"),
        }
    }
}

impl std::error::Error for AnalysisError {}
