//! Reasons why a picture cannot be drawn.

use std::fmt;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PictureError {
    /// Only 2D and 3D can be drawn.
    Dimensions {
        /// Dimensions of the network.
        found: usize,
    },
    /// A coordinate or a radius is not finite.
    NotFinite {
        /// Index of the element, or of the node of a mesh.
        index: usize,
    },
    /// The width of the domain is not finite.
    TooWide,
    /// The width of a PNG is out of range.
    Width {
        /// Requested width, pixels.
        found: u32,
        /// Smallest width, pixels.
        least: u32,
        /// Largest width, pixels.
        most: u32,
    },
    /// There are too many elements, contacts or triangles: a browser could not open the file.
    TooMany {
        /// Name of the objects.
        what: &'static str,
        /// Number of the objects.
        found: usize,
        /// Largest number that can be shown.
        most: usize,
    },
    /// There is not enough memory for the drawing.
    OutOfMemory {
        /// Memory that it may take, bytes.
        bytes: usize,
    },
    /// The drawing could not be converted to a PNG file.
    Png {
        /// Message of the library that converts it.
        message: String,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dimensions { found } => {
                write!(out, "a network in {found}D cannot be drawn, only in 2D and 3D")
            }
            Self::NotFinite { index } => {
                write!(out, "element {index} has a coordinate or a radius that is not finite")
            }
            Self::TooWide => write!(out, "the domain is too wide to be drawn"),
            Self::Width { found, least, most } => {
                write!(out, "a PNG cannot be {found} pixels wide, only {least} to {most}")
            }
            Self::TooMany { what, found, most } => {
                write!(out, "{found} {what} are too many for a report, which shows up to {most}")
            }
            Self::OutOfMemory { bytes } => {
                write!(out, "no memory for {bytes} bytes, which the drawing may take")
            }
            Self::Png { message } => write!(out, "the picture cannot be converted to PNG: {message}"),
        }
    }
}

impl std::error::Error for PictureError {}
