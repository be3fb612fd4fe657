//! Writes tables of elements and of couples as a graph.

use std::io::{self, Write};

use crate::written::csv::write_text;
use crate::written::table::{CHUNK, Plain, Table, Values};

/// Writes elements and couples as an undirected GraphML graph.
///
/// # Shapes
/// The first column of `elements` holds their names, all different. The first two columns of `couples` hold
/// the names of two elements. All other columns become attributes of the nodes and of the edges.
///
/// # Cost
/// Time proportional to the values. Uses a buffer of 256 KiB. `out` is not flushed.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if there are fewer columns.
///
/// # Source
/// The GraphML specification, with GraphML-Attributes.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_graphml};
///
/// let elements = Table::new(2).with("id", Values::i64(|k| k as i64));
/// let couples = Table::new(1).with("i", Values::i64(|_| 0)).with("j", Values::i64(|_| 1));
/// let mut out = Vec::new();
/// write_graphml(&mut out, &elements, &couples)?; // networkx.read_graphml(.., node_type=int)
/// assert!(String::from_utf8_lossy(&out).contains("<edge source=\"0\" target=\"1\"/>"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_graphml<W: Write>(out: &mut W, elements: &Table<'_>, couples: &Table<'_>) -> io::Result<()> {
    let (nodes, edges) = (Plain::all(elements), Plain::all(couples));
    let ([id, of_nodes @ ..], [i, j, of_edges @ ..]) = (&nodes[..], &edges[..]) else {
        return Err(no_names());
    };
    let mut chunk = Vec::with_capacity(CHUNK + CHUNK / 16);
    chunk.extend_from_slice(
        b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n",
    );
    for (what, letter, columns) in [("node", 'n', of_nodes), ("edge", 'e', of_edges)] {
        for (k, column) in columns.iter().enumerate() {
            let of_type = match column.values {
                Values::I32(_) => "int",
                Values::I64(_) | Values::U64(_) => "long",
                Values::F64(_) => "double",
                Values::Text { .. } => "string",
            };
            writeln!(
                chunk,
                "<key id=\"{letter}{k}\" for=\"{what}\" attr.name=\"{}\" attr.type=\"{of_type}\"/>",
                column.name
            )?;
        }
    }
    chunk.extend_from_slice(b"<graph edgedefault=\"undirected\">\n");
    for row in 0..elements.rows() {
        chunk.extend_from_slice(b"<node id=\"");
        id.write(row, &mut chunk);
        write_data(of_nodes, b'n', row, b"node", &mut chunk);
        flush_full(out, &mut chunk)?;
    }
    for row in 0..couples.rows() {
        chunk.extend_from_slice(b"<edge source=\"");
        i.write(row, &mut chunk);
        chunk.extend_from_slice(b"\" target=\"");
        j.write(row, &mut chunk);
        write_data(of_edges, b'e', row, b"edge", &mut chunk);
        flush_full(out, &mut chunk)?;
    }
    chunk.extend_from_slice(b"</graph>\n</graphml>\n");
    out.write_all(&chunk)
}

/// The attributes of a node or an edge; its start tag lacks the last quote.
fn write_data(columns: &[Plain<'_>], letter: u8, row: usize, end: &[u8], chunk: &mut Vec<u8>) {
    if columns.is_empty() {
        return chunk.extend_from_slice(b"\"/>\n");
    }
    chunk.extend_from_slice(b"\">");
    for (k, column) in columns.iter().enumerate() {
        chunk.extend_from_slice(b"<data key=\"");
        chunk.push(letter);
        chunk.extend_from_slice(itoa::Buffer::new().format(k).as_bytes());
        chunk.extend_from_slice(b"\">");
        column.write(row, chunk);
        chunk.extend_from_slice(b"</data>");
    }
    chunk.extend_from_slice(b"</");
    chunk.extend_from_slice(end);
    chunk.extend_from_slice(b">\n");
}

/// Writes elements and couples as an undirected graph in JSON, in the node-link form of networkx and d3:
/// `nodes` with `id`, `edges` with `source` and `target`.
///
/// networkx from 3.4 on reads it with `node_link_graph(data, edges="edges")`.
///
/// # Shapes
/// See [`write_graphml`]. `multigraph`: whether two elements may have several couples, as in a periodic box.
///
/// # Cost
/// See [`write_graphml`].
///
/// # Errors
/// See [`write_graphml`]. A float that is not finite is written as `null`.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_node_link};
///
/// let elements = Table::new(2).with("id", Values::i64(|k| k as i64));
/// let couples = Table::new(1).with("i", Values::i64(|_| 0)).with("j", Values::i64(|_| 1));
/// let mut out = Vec::new();
/// write_node_link(&mut out, &elements, &couples, false)?;
/// assert!(String::from_utf8_lossy(&out).contains(r#"{"source":0,"target":1}"#));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_node_link<W: Write>(
    out: &mut W,
    elements: &Table<'_>,
    couples: &Table<'_>,
    multigraph: bool,
) -> io::Result<()> {
    let (nodes, edges) = (Plain::all(elements), Plain::all(couples));
    if nodes.is_empty() || edges.len() < 2 {
        return Err(no_names());
    }
    let mut chunk = Vec::with_capacity(CHUNK + CHUNK / 16);
    write!(chunk, "{{\"directed\":false,\"multigraph\":{multigraph},\"graph\":{{}},\"nodes\":[")?;
    write_objects(out, &nodes, &["id"], elements.rows(), &mut chunk)?;
    chunk.extend_from_slice(b"],\"edges\":[");
    write_objects(out, &edges, &["source", "target"], couples.rows(), &mut chunk)?;
    chunk.extend_from_slice(b"]}\n");
    out.write_all(&chunk)
}

/// Writes rows as objects; the first columns are renamed.
fn write_objects<W: Write>(
    out: &mut W,
    columns: &[Plain<'_>],
    first: &[&str],
    rows: usize,
    chunk: &mut Vec<u8>,
) -> io::Result<()> {
    let names: Vec<_> = columns
        .iter()
        .enumerate()
        .map(|(k, column)| {
            let start = if k == 0 { '{' } else { ',' };
            format!("{start}\"{}\":", first.get(k).unwrap_or(&column.name))
        })
        .collect();
    for row in 0..rows {
        chunk.extend_from_slice(if row == 0 { b"\n" } else { b",\n" });
        for (name, column) in names.iter().zip(columns) {
            chunk.extend_from_slice(name.as_bytes());
            match column.values {
                Values::F64(at) if !at(column.place(row)).is_finite() => chunk.extend_from_slice(b"null"),
                Values::Text { .. } => {
                    chunk.push(b'"');
                    column.write(row, chunk);
                    chunk.push(b'"');
                }
                _ => column.write(row, chunk),
            }
        }
        chunk.push(b'}');
        flush_full(out, chunk)?;
    }
    Ok(())
}

impl<'t> Plain<'t> {
    fn all(table: &'t Table<'_>) -> Vec<Self> {
        table.plain().collect()
    }

    fn write(&self, row: usize, chunk: &mut Vec<u8>) {
        write_text(self.values, self.place(row), chunk);
    }
}

fn flush_full<W: Write>(out: &mut W, chunk: &mut Vec<u8>) -> io::Result<()> {
    if chunk.len() >= CHUNK {
        out.write_all(chunk)?;
        chunk.clear();
    }
    Ok(())
}

fn no_names() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, "elements need a name, couples the names of two elements")
}
