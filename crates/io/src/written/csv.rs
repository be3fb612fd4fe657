//! Tables as comma-separated text.

use std::io::{self, Write};

use crate::written::table::{CHUNK, Plain, Table, Values};

/// Writes a table as text under a header with the names of its columns; components become separate columns.
///
/// A float is written as the shortest text that reads back as the same `f64`. The bytes are a function of the
/// table alone.
///
/// # Cost
/// Time proportional to the values. Uses a buffer of 256 KiB, so `out` needs none. `out` is not flushed.
///
/// # Errors
/// The errors of `out`.
///
/// # Example
/// See [`Table`].
pub fn write_csv<W: Write>(out: &mut W, table: &Table<'_>) -> io::Result<()> {
    write_csv_header(out, table)?;
    write_csv_rows(out, table)
}

/// Writes only the header, with the names of the columns.
///
/// # Errors
/// The errors of `out`.
pub fn write_csv_header<W: Write>(out: &mut W, table: &Table<'_>) -> io::Result<()> {
    let names: Vec<_> = table.plain().map(|column| column.name).collect();
    out.write_all((names.join(",") + "\n").as_bytes())
}

/// Writes only the rows, for a table with the same columns as one written before.
///
/// # Errors
/// The errors of `out`.
pub fn write_csv_rows<W: Write>(out: &mut W, table: &Table<'_>) -> io::Result<()> {
    let columns: Vec<Plain<'_>> = table.plain().collect();
    let mut chunk = Vec::with_capacity(CHUNK + CHUNK / 16);
    for row in 0..table.rows() {
        for (place, column) in columns.iter().enumerate() {
            if place > 0 {
                chunk.push(b',');
            }
            write_text(column.values, column.place(row), &mut chunk);
        }
        chunk.push(b'\n');
        if chunk.len() >= CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
    }
    out.write_all(&chunk)
}

/// Appends a value as text.
pub(crate) fn write_text(values: &Values<'_>, place: usize, chunk: &mut Vec<u8>) {
    let mut integer = itoa::Buffer::new();
    let text = match values {
        Values::I32(at) => integer.format(at(place)),
        Values::I64(at) => integer.format(at(place)),
        Values::U64(at) => integer.format(at(place)),
        Values::F64(at) => return chunk.extend_from_slice(ryu::Buffer::new().format(at(place)).as_bytes()),
        Values::Text { at, .. } => at(place),
    };
    chunk.extend_from_slice(text.as_bytes());
}
