//! Writes tables as a NumPy array of records.

use std::io::{self, Write};

use crate::npy_header::header;
use crate::written::table::{CHUNK, Plain, Table};

/// Writes a table as a NumPy array with the columns of [`write_csv`](crate::write_csv) as fields: integers as
/// `<i4`, `<i8` or `<u8`, floats as `<f8`, texts as `|S` with their width.
///
/// `numpy.load` gives an array of shape `(rows,)`; `a["overlap"]` is a column of it.
///
/// # Cost
/// See [`write_csv`](crate::write_csv).
///
/// # Errors
/// The errors of `out`.
///
/// # Source
/// NumPy Enhancement Proposal 1, version 1.0 of the format.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_npy};
///
/// let mut out = Vec::new();
/// write_npy(&mut out, &Table::new(3).with("x", Values::f64(|k| k as f64)))?;
/// assert!(out.starts_with(b"\x93NUMPY"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_npy<W: Write>(out: &mut W, table: &Table<'_>) -> io::Result<()> {
    write_npy_header(out, table, table.rows() as u64)?;
    write_npy_rows(out, table)
}

/// Writes only the bytes before the rows, for a file of `rows` rows with the columns of a table.
///
/// # Errors
/// The errors of `out`.
pub fn write_npy_header<W: Write>(out: &mut W, table: &Table<'_>, rows: u64) -> io::Result<()> {
    let fields: Vec<_> =
        table.plain().map(|column| format!("('{}', '{}')", column.name, column.values.dtype())).collect();
    out.write_all(&header(&format!("[{}]", fields.join(", ")), &format!("({rows},)")))
}

/// Writes only the rows, each of [`Table::npy_row`] bytes, for a file whose header has been written.
///
/// # Errors
/// The errors of `out`.
pub fn write_npy_rows<W: Write>(out: &mut W, table: &Table<'_>) -> io::Result<()> {
    let columns: Vec<Plain<'_>> = table.plain().collect();
    let mut chunk = Vec::with_capacity(CHUNK + CHUNK / 16);
    for row in 0..table.rows() {
        for column in &columns {
            let place = column.place(row);
            column.values.write_le(place..place + 1, &mut chunk);
        }
        if chunk.len() >= CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
    }
    out.write_all(&chunk)
}
