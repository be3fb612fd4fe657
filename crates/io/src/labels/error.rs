//! Everything that can be wrong with a labelled image.

use std::io;

use thiserror::Error;

use crate::excerpt;
use crate::labels::LabelKind;

/// Why a labelled image could not be read: what is wrong, where, and what would be right.
///
/// The text does not carry the file's name: who opened the file prints `file: text`.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LabelError {
    /// The system could not read, or the data of an archive are damaged.
    #[error("{0}")]
    Read(#[source] io::Error),
    /// The file has no bytes.
    #[error("the file is empty: expected a labelled image")]
    Empty,
    /// The first bytes are those of no format that is read.
    #[error(
        "not a labelled image: it starts with {start}, neither a NumPy array (.npy, .npz) nor a TIFF file"
    )]
    Unknown {
        /// The first bytes.
        start: String,
    },
    /// A member was named, but the file is no archive.
    #[error("there is no member '{member}': the file is no archive (.npz)")]
    NoArchive {
        /// The name asked for.
        member: String,
    },
    /// The archive cannot be read.
    #[error("NumPy archive: {problem}")]
    Archive {
        /// What is wrong with it.
        problem: String,
    },
    /// The archive has several arrays, none, or not the one that was asked for.
    #[error(
        "NumPy archive: {}; its arrays are: {}",
        match wanted {
            Some(wanted) => format!("no array '{wanted}'"),
            None => format!("{}, say which", excerpt::count(present.len() as u64, "array")),
        },
        present.join(", ")
    )]
    Member {
        /// The name asked for.
        wanted: Option<String>,
        /// The arrays that are there.
        present: Vec<String>,
    },
    /// The header of an array cannot be read.
    #[error("NumPy header: {problem}")]
    Header {
        /// What is wrong with it.
        problem: String,
    },
    /// The array holds something other than labels.
    #[error(
        "the array of shape {shape} is {dtype}: labels are integers of at most 64 bits{}",
        if dtype.starts_with("|b") { ", one for each body: number the bodies first" } else { "" }
    )]
    Dtype {
        /// The dtype as the file spells it.
        dtype: String,
        /// The shape as Python prints it.
        shape: String,
    },
    /// The array is no image.
    #[error("the array has shape {shape}: an image has two or three axes")]
    Shape {
        /// The shape as Python prints it.
        shape: String,
    },
    /// The size that the header claims is beyond any file.
    #[error("the header claims an array of shape {shape}, {dtype}, which no file can hold: it is damaged")]
    Claim {
        /// The shape as Python prints it.
        shape: String,
        /// The dtype as the file spells it.
        dtype: String,
    },
    /// There are fewer bytes than the header claims.
    #[error("the array should take {}, found {found}: the file is cut off or damaged", excerpt::count(*expected, "byte"))]
    CutOff {
        /// Bytes that shape and dtype ask for.
        expected: u64,
        /// Bytes after the header.
        found: u64,
    },
    /// There are more bytes than the header claims.
    #[error("the file goes on after the {} of the array, perhaps with another one, or is damaged", excerpt::count(*expected, "byte"))]
    Longer {
        /// Bytes that shape and dtype ask for.
        expected: u64,
    },
    /// A TIFF file, or a page of it, cannot be read.
    #[error("TIFF file, page {page}: {problem}")]
    Page {
        /// The page, counted from 1.
        page: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// Labels were asked for as numbers of another type.
    #[error("the labels are {found:?}, not {asked:?}")]
    Kind {
        /// What they are.
        found: LabelKind,
        /// What was asked for.
        asked: LabelKind,
    },
    /// The system has no memory left for a slab of labels.
    #[error("no memory for {bytes} bytes of labels")]
    NoMemory {
        /// Bytes that were asked for.
        bytes: usize,
    },
}

impl LabelError {
    /// A file that starts with no magic bytes.
    pub(super) fn unknown(start: &[u8]) -> Self {
        if start.is_empty() { Self::Empty } else { Self::Unknown { start: start.escape_ascii().to_string() } }
    }
}
