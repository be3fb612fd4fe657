//! Writes tables as an archive of NumPy arrays, one for each column.

use std::io::{self, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::npy_header::header;
use crate::written::table::Table;

/// Writes tables as an uncompressed archive of NumPy arrays, one for each column, like `numpy.savez`.
///
/// A column of several components is one array.
///
/// # Shapes
/// `(rows,)` for a plain column, `(rows, components)` for one with components; a column of one component is
/// plain. Names must be different.
///
/// # Cost
/// Time proportional to the values, which are written column by column. Uses a buffer of 256 KiB. `out` is
/// not flushed.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if a name occurs twice.
///
/// # Source
/// NumPy Enhancement Proposal 1; PKWARE, APPNOTE.TXT, with sizes of 64 bits.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_npz};
///
/// let points = Table::new(2).with_components("positions", &["x", "y"], Values::f64(|k| k as f64));
/// let mut out = Vec::new();
/// write_npz(&mut out, &[&points])?; // numpy.load(..)["positions"] is [[0, 1], [2, 3]]
/// assert!(out.starts_with(b"PK"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_npz<W: Write>(out: &mut W, tables: &[&Table<'_>]) -> io::Result<()> {
    let mut names: Vec<_> =
        tables.iter().flat_map(|table| table.columns()).map(|column| column.name).collect();
    names.sort_unstable();
    if let Some([name, ..]) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("two arrays are called {name}")));
    }
    let mut archive = ZipWriter::new_stream(out);
    // The sizes are unknown before the data are written, so 64-bit sizes are used.
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    for table in tables {
        let rows = table.rows();
        for column in table.columns() {
            archive.start_file(format!("{}.npy", column.name), options).map_err(io_error)?;
            let shape = match column.width() {
                1 => format!("({rows},)"),
                width => format!("({rows}, {width})"),
            };
            archive.write_all(&header(&format!("'{}'", column.values.dtype()), &shape))?;
            column.write_array(rows, &mut archive)?;
        }
    }
    archive.finish().map_err(io_error)?;
    Ok(())
}

fn io_error(error: zip::result::ZipError) -> io::Error {
    match error {
        zip::result::ZipError::Io(error) => error,
        other => io::Error::other(other),
    }
}
