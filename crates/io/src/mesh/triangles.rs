//! Tables of triangles: nine named columns, one triangle of three corners per line.

use crate::excerpt;
use crate::mesh::build::Draft;
use crate::mesh::cursor::{Cursor, float, words};
use crate::mesh::error::{Fault, malformed};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::mesh::stl::{Facet, weld};

/// The column names of the DEM round robin of 2024, without units in brackets, in lower case.
const COLUMNS: [&str; 9] = [
    "vertex1_x",
    "vertex1_y",
    "vertex1_z",
    "vertex2_x",
    "vertex2_y",
    "vertex2_z",
    "vertex3_x",
    "vertex3_y",
    "vertex3_z",
];

/// Whether a line contains these column names.
pub(crate) fn is_header(line: &[u8]) -> bool {
    let bare = |word: &[u8]| word.split(|&byte| byte == b'[').next().unwrap_or(word).to_ascii_lowercase();
    words(line).map(bare).eq(COLUMNS.iter().map(|column| column.as_bytes().to_vec()))
}

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut cursor = Cursor::new(bytes);
    cursor.filled_line();
    let mut facets: Vec<Facet> = Vec::new();
    while let Some((place, line)) = cursor.filled_line() {
        let values = words(line).map(float).collect::<Result<Vec<f64>, String>>();
        let values = values.map_err(|problem| (place, malformed(problem)))?;
        let ([a, b, c], []) = values.as_chunks::<3>() else {
            let found = excerpt::count(values.len() as u64, "number");
            return Err((place, malformed(format!("expected 9 numbers, found {found}"))));
        };
        facets.push(Facet { corners: [*a, *b, *c], place, solid: 0, number: facets.len() as u64 });
    }
    weld(&facets, vec![MeshBody { number: None, name: None }], BodiesFrom::File)
}
