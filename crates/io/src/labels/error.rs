//! The errors of reading a labelled image.

use std::io;

use thiserror::Error;

use crate::excerpt;
use crate::labels::kind::LabelKind;

/// The reason why a labelled image could not be read: the problem, its place, and the expected content.
///
/// The text does not contain the name of the file. The caller that opened the file prints `file: text`.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LabelError {
    /// The system could not read the file, or the data of an archive are damaged.
    #[error("{0}")]
    Read(#[source] io::Error),
    /// The file has no bytes.
    #[error("the file is empty: expected a labelled image")]
    Empty,
    /// The first bytes are those of no supported format.
    #[error(
        "not a labelled image: it starts with {start}, neither a NumPy array (.npy, .npz) nor a TIFF file"
    )]
    Unknown {
        /// The first bytes.
        start: String,
    },
    /// A member was named, but the file is not an archive.
    #[error("there is no member '{member}': the file is no archive (.npz)")]
    NoArchive {
        /// The requested name.
        member: String,
    },
    /// The archive cannot be read.
    #[error("NumPy archive: {problem}")]
    Archive {
        /// The problem.
        problem: String,
    },
    /// The archive has several arrays, none, or not the requested one.
    #[error(
        "NumPy archive: {}; its arrays are: {}",
        match wanted {
            Some(wanted) => format!("no array '{wanted}'"),
            None => format!("{}, say which", excerpt::count(present.len() as u64, "array")),
        },
        present.join(", ")
    )]
    Member {
        /// The requested name.
        wanted: Option<String>,
        /// The arrays of the archive.
        present: Vec<String>,
    },
    /// The header of an array cannot be read.
    #[error("NumPy header: {problem}")]
    Header {
        /// The problem.
        problem: String,
    },
    /// The array contains something other than labels.
    #[error(
        "the array of shape {shape} is {dtype}: labels are integers of at most 64 bits{}",
        if dtype.starts_with("|b") { ", one for each body: number the bodies first" } else { "" }
    )]
    Dtype {
        /// The dtype as written in the file.
        dtype: String,
        /// The shape in Python notation.
        shape: String,
    },
    /// The array is not an image.
    #[error("the array has shape {shape}: an image has two or three axes")]
    Shape {
        /// The shape in Python notation.
        shape: String,
    },
    /// The size stated in the header exceeds that of any file.
    #[error("the header claims an array of shape {shape}, {dtype}, which no file can hold: it is damaged")]
    Claim {
        /// The shape in Python notation.
        shape: String,
        /// The dtype as written in the file.
        dtype: String,
    },
    /// There are fewer bytes than the header states.
    #[error("the array should take {}, found {found}: the file is cut off or damaged", excerpt::count(*expected, "byte"))]
    CutOff {
        /// Number of bytes according to shape and dtype.
        expected: u64,
        /// Number of bytes after the header.
        found: u64,
    },
    /// There are more bytes than the header states.
    #[error("the file continues after the {} of the array, perhaps with another one, or is damaged", excerpt::count(*expected, "byte"))]
    Longer {
        /// Number of bytes according to shape and dtype.
        expected: u64,
    },
    /// A TIFF file, or a page of it, cannot be read.
    #[error("TIFF file, page {page}: {problem}")]
    Page {
        /// The page, counted from 1.
        page: usize,
        /// The problem.
        problem: String,
    },
    /// Labels were requested as numbers of another type.
    #[error("the labels are {found:?}, not {asked:?}")]
    Kind {
        /// The type of the labels.
        found: LabelKind,
        /// The requested type.
        asked: LabelKind,
    },
    /// The system has no memory left for a slab of labels.
    #[error("no memory for {bytes} bytes of labels")]
    NoMemory {
        /// Number of bytes requested.
        bytes: usize,
    },
}

impl LabelError {
    /// The error for a file that does not start with known magic bytes.
    pub(super) fn unknown(start: &[u8]) -> Self {
        if start.is_empty() { Self::Empty } else { Self::Unknown { start: start.escape_ascii().to_string() } }
    }
}
