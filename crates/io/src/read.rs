//! Reads tables of elements, text or NumPy.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::ReadError;
use crate::foreign::{BYTE_ORDER_MARK, foreign};
use crate::npy::read_npy;
use crate::options::ReadOptions;
use crate::packing::Packing;
use crate::text::read_text;

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
