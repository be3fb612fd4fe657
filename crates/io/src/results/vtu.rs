//! Writes a mesh of triangles or of tetrahedra for ParaView.

use std::io::{self, Write};

use super::appended::Appended;
use crate::written::table::{Table, TableColumn, Values};

/// The number of corners and the type, `VTK_TRIANGLE` and `VTK_TETRA`, of each kind of cell.
const KINDS: [(usize, u8); 2] = [(3, 5), (4, 10)];

/// Writes triangles, or tetrahedra, and the data of their corners and cells as a VTK file of an
/// `UnstructuredGrid`: binary, compressed.
///
/// # Shapes
/// The first column of `points` holds their positions: three components, floats. The first column of `cells`
/// holds the numbers of their corners, counted from 0: three components of 64 bits for triangles, four for
/// tetrahedra. All other columns become data arrays of the points and of the cells, with the names of their
/// components.
///
/// # Units
/// `time` is the `TimeValue` of the file, which ParaView shows. `named` are numbers that hold for the whole
/// file: each becomes an array of the field data, with its name. Units of the columns are information keys of
/// their arrays (`UNITS_LABEL`).
///
/// # Cost
/// Each array is compressed once; the compressed file is in memory until it is written. `out` is not flushed.
/// The bytes are a function of the arguments alone.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if a first column has the wrong form, or a column
/// contains text.
///
/// # Source
/// The VTK User's Guide, "VTK File Formats", XML formats, appended data.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_vtu};
///
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let points = Table::new(3).with_components("positions", &["x", "y", "z"], Values::f64(|k| corners[k / 3][k % 3]));
/// let triangles = Table::new(1)
///     .with_components("nodes", &["a", "b", "c"], Values::i64(|k| k as i64))
///     .with("damage", Values::f64(|_| 0.25));
/// let mut out = Vec::new();
/// write_vtu(&mut out, &points, &triangles, 0.5, &[("material: rock".to_owned(), vec![0])])?;
/// assert!(out.starts_with(b"<?xml"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_vtu<W: Write>(
    out: &mut W,
    points: &Table<'_>,
    cells: &Table<'_>,
    time: f64,
    named: &[(String, Vec<i64>)],
) -> io::Result<()> {
    let invalid = |problem: &str| io::Error::new(io::ErrorKind::InvalidInput, problem.to_owned());
    let (Some((positions, of_points)), Some((corners, of_cells))) =
        (points.columns().split_first(), cells.columns().split_first())
    else {
        return Err(invalid("points without positions, or cells without corners"));
    };
    let (3, Values::F64(place)) = (positions.width(), &positions.values) else {
        return Err(invalid("positions are three floats each"));
    };
    let kind = KINDS.iter().find(|(count, _)| *count == corners.width());
    let (Some(&(count, kind)), Values::I64(at)) = (kind, &corners.values) else {
        return Err(invalid("the corners of a cell are three or four whole numbers"));
    };
    // `at` numbers per cell, computed without an array of them.
    let connectivity = plain("connectivity", Values::i64(at));
    // The end of each cell in the list of corners.
    let end = |k: usize| (count * (k + 1)).cast_signed() as i64;
    let offsets = plain("offsets", Values::i64(end));
    let places =
        TableColumn { name: "Points", components: &["x", "y", "z"], unit: "", values: Values::f64(place) };

    let (n, m) = (points.rows(), cells.rows());
    let mut body = Appended::default();
    let mut head = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n\
         <UnstructuredGrid>\n",
    );
    head += &body.field_data(time, named)?;
    head = format!("{head}<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{m}\">\n<PointData>\n");
    for column in of_points {
        head += &body.column(column, n)?;
    }
    head += "</PointData>\n<CellData>\n";
    for column in of_cells {
        head += &body.column(column, m)?;
    }
    head += "</CellData>\n<Points>\n";
    head += &body.column(&places, n)?;
    head += "</Points>\n<Cells>\n";
    head += &body.column(&connectivity, count * m)?;
    head += &body.column(&offsets, m)?;
    head += &body.repeated("types", kind, m)?;
    head += "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    out.write_all(head.as_bytes())?;
    out.write_all(&body.bytes)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

fn plain<'a>(name: &'static str, values: Values<'a>) -> TableColumn<'a> {
    TableColumn { name, components: &[], unit: "", values }
}
