//! Reads tables of elements, text or NumPy.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::columns::Columns;
use crate::error::ReadError;
use crate::npy::read_npy;
use crate::packing::Packing;
use crate::text::read_text;

/// Options for reading a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The roles of the columns; `None` derives them from the header, or from the number of columns.
    pub columns: Option<Columns>,
    /// Skips lines that cannot be read and lists them in [`Source::skipped`](crate::Source), instead of
    /// stopping at the first one. The elements keep the numbers of their rows in [`Packing::row_numbers`].
    pub skip_bad_lines: bool,
    /// Ignores the id column, so that elements are numbered by row.
    pub ignore_ids: bool,
    /// The column that holds the body of each element, for [`Packing::bodies`]: its name in the header, or
    /// its number counted from 1. It has no other role. In a file without names, the other columns keep the
    /// roles that they would have without it.
    pub bodies: Option<String>,
}

/// Reads a packing from a table: delimited text or a NumPy array. [`read_packing`](crate::read_packing) and
/// [`Series`](crate::Series) read these and all other formats.
///
/// The format is recognised by the content, never by a name. A file that starts with `\x93NUMPY` is a NumPy
/// array (floats of 32 or 64 bits, integers, either byte order, C or Fortran order, or a structured array
/// with named fields). Any other file must be text with one element per row:
///
/// - Fields are separated by commas, semicolons, or runs of blanks and tabs, as in the first line that is not
///   a comment, or as stated by a first line `sep=;`. `#` starts a comment, and so does `%` at the start of a
///   line. Blank lines, CRLF line ends and a byte order mark are accepted.
/// - A header line names the columns: `x`, `PosX[m]`, `X (mm)`, `x_mm`, `Points:0`; `radius`, `r`,
///   `diameter`, `d`, `id` and similar names, in any capitals. Other columns are ignored. A comment line just
///   above the first row also serves as header if it fits, and so does `#format x_y_z_r_matId` of YADE.
///   Without a header, 2 columns are x y, 3 are x y z, and 4 are x y z radius.
/// - Without z the packing is 2D. Diameters are halved.
///
/// # Shapes
/// `bytes`: a whole file. `progress`: updated from time to time with the number of bytes parsed so far, so
/// that another thread can display it; `bytes.len()` on success.
///
/// # Units
/// The units of the file; columns with different units are an error.
///
/// # Cost
/// Time proportional to the bytes, one thread. Memory: the packing, 8 bytes more per row while ids are read,
/// and 16 bytes per row if the ids are not increasing. Files of more than 10 000 columns are refused.
///
/// # Errors
/// [`ReadError`]: the file is not a table of elements, a column is missing or occurs twice, a line cannot be
/// read (unless [`ReadOptions::skip_bad_lines`]; if all lines are bad, it is an error even then), or ids
/// repeat.
///
/// # Example
/// ```
/// use std::sync::atomic::AtomicU64;
/// use fdem_io::{ReadError, ReadOptions, read};
///
/// let error = read(b"x,y\n0,0\n1,abc\n", &ReadOptions::default(), &AtomicU64::new(0)).unwrap_err();
/// assert_eq!(error.line(), Some(3));
/// assert_eq!(error.to_string(), "cannot read 'abc' as a number in column y: 1,abc");
/// ```
pub fn read(bytes: &[u8], options: &ReadOptions, progress: &AtomicU64) -> Result<Packing, ReadError> {
    progress.store(0, Ordering::Relaxed);
    if bytes.is_empty() || bytes == BYTE_ORDER_MARK {
        return Err(ReadError::Empty);
    }
    if let Some(error) = foreign(bytes) {
        return Err(error);
    }
    let packing = if bytes.starts_with(b"\x93NUMPY") {
        read_npy(bytes, options, progress)
    } else {
        read_text(bytes, options, progress)
    }?;
    progress.store(bytes.len() as u64, Ordering::Relaxed);
    Ok(packing)
}

/// The error for a file that starts like one of another format.
pub(crate) fn foreign(bytes: &[u8]) -> Option<ReadError> {
    let (_, format, advice) = FOREIGN.iter().find(|(magic, ..)| bytes.starts_with(magic))?;
    Some(ReadError::Foreign { format, advice })
}

/// The byte order mark that some programs write before text in UTF-8.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const UNPACK: &str = "unpack it first";
const AS_UTF_8: &str = "save it as UTF-8";
const AS_TABLE: &str = "export the elements as a CSV table with columns x, y, z and radius";

/// Other formats that users pass by mistake: first bytes, name, advice. The first match counts.
pub(crate) const FOREIGN: [(&[u8], &str, &str); 15] = [
    (b"\x1f\x8b", "gzip-compressed data", UNPACK),
    (b"\x28\xb5\x2f\xfd", "zstd-compressed data", UNPACK),
    (b"\xfd7zXZ\x00", "xz-compressed data", UNPACK),
    (b"BZh", "bzip2-compressed data", UNPACK),
    (
        b"PK\x03\x04",
        "a zip archive (perhaps .npz or .xlsx)",
        "save one array with numpy.save, or a CSV table",
    ),
    (b"%PDF", "a PDF document", AS_TABLE),
    (b"\x89HDF", "an HDF5 file", AS_TABLE),
    (b"# vtk DataFile", "a VTK file", AS_TABLE),
    (b"<VTKFile", "a VTK file", AS_TABLE),
    (b"<?xml", "an XML file", AS_TABLE),
    (
        b"ITEM: TIMESTEP",
        "a LAMMPS dump",
        "keep the rows of one time step, under a line with the column names",
    ),
    // Must come before UTF-16, because its mark starts with that of UTF-16.
    (b"\xff\xfe\x00\x00", "UTF-32 text", AS_UTF_8),
    (b"\xff\xfe", "UTF-16 text", AS_UTF_8),
    (b"\xfe\xff", "UTF-16 text", AS_UTF_8),
    (b"\x00\x00\xfe\xff", "UTF-32 text", AS_UTF_8),
];
