//! Points, or lines or triangles between them, for ParaView.

use std::io::{self, Write};

use super::appended::Appended;
use crate::written::table::{Table, TableColumn, Values};

/// Writes points, and lines or triangles between them if there are `cells`, as a VTK file of `PolyData`:
/// binary, compressed. Without cells every point is a vertex.
///
/// [`write_vtp`](crate::write_vtp) writes larger files of lines, and keeps less in memory.
///
/// # Shapes
/// The first column of `points` is where they are: three components, floats. The first column of `cells` is
/// their corners, points by their number from 0: two components of 64 bits for lines, three for triangles.
/// All others become arrays of the points and of the cells, with the names of their components.
///
/// # Units
/// `time` is the `TimeValue` of the file. Units of the columns are information keys of their arrays
/// (`UNITS_LABEL`).
///
/// # Cost
/// Each array is compressed once; the compressed file is in memory until it is written. `out` is not flushed.
/// The bytes depend on the arguments alone.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if the first columns are not the required ones, or a
/// column is of text.
///
/// # Source
/// The VTK User's Guide, "VTK File Formats", XML formats, appended data.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_poly_vtp};
///
/// let points = Table::new(2)
///     .with_components("positions", &["x", "y", "z"], Values::f64(|k| k as f64))
///     .with_components("force", &["x", "y", "z"], Values::f64(|_| 1.0))
///     .in_unit("N");
/// let mut out = Vec::new();
/// write_poly_vtp(&mut out, &points, None, 0.5)?;
/// assert!(out.starts_with(b"<?xml"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_poly_vtp<W: Write>(
    out: &mut W,
    points: &Table<'_>,
    cells: Option<&Table<'_>>,
    time: f64,
) -> io::Result<()> {
    let invalid = |problem: &str| io::Error::new(io::ErrorKind::InvalidInput, problem.to_owned());
    let (positions, of_points) =
        points.columns().split_first().ok_or_else(|| invalid("points without positions"))?;
    let (3, Values::F64(place)) = (positions.width(), &positions.values) else {
        return Err(invalid("positions are three floats each"));
    };
    let places = plain("Points", &["x", "y", "z"], Values::f64(place));
    let n = points.rows();
    let none = Table::new(0);
    let table = cells.unwrap_or(&none);
    let (kind, cells, width, connectivity, of_cells) = match table.columns().split_first() {
        // Every point is a cell.
        None => (0, n, 1, Values::i64(whole), &[][..]),
        Some((corners, of_cells)) => {
            let (width @ 2..=3, Values::I64(at)) = (corners.width(), &corners.values) else {
                return Err(invalid("the corners of a cell are two or three whole numbers"));
            };
            (width - 1, table.rows(), width, Values::i64(at), of_cells)
        }
    };
    let [verts, edges, polys] = [0, 1, 2].map(|of| if of == kind { cells } else { 0 });
    let kind = ["Verts", "Lines", "Polys"][kind];

    let mut body = Appended::default();
    let mut head = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n\
         <PolyData>\n",
    );
    head += &body.field_data(time, &[])?;
    head = format!(
        "{head}<Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{verts}\" NumberOfLines=\"{edges}\" NumberOfStrips=\"0\" NumberOfPolys=\"{polys}\">\n<PointData>\n"
    );
    for column in of_points {
        head += &body.column(column, n)?;
    }
    head += "</PointData>\n<CellData>\n";
    for column in of_cells {
        head += &body.column(column, cells)?;
    }
    head += "</CellData>\n<Points>\n";
    head += &body.column(&places, n)?;
    head = format!("{head}</Points>\n<{kind}>\n");
    head += &body.column(&plain("connectivity", &[], connectivity), width * cells)?;
    let end = |k: usize| whole(width * (k + 1));
    head += &body.column(&plain("offsets", &[], Values::i64(end)), cells)?;
    head = format!("{head}</{kind}>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
    out.write_all(head.as_bytes())?;
    out.write_all(&body.bytes)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

fn whole(number: usize) -> i64 {
    number.cast_signed() as i64
}

fn plain<'a>(name: &'static str, components: &'static [&'static str], values: Values<'a>) -> TableColumn<'a> {
    TableColumn { name, components, unit: "", values }
}
