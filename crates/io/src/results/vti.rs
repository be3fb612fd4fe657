//! Writes values on a regular grid for ParaView.

use std::io::{self, Write};

use super::appended::Appended;
use crate::written::table::Table;

/// Writes the data of the points of a regular grid as a VTK file of an `ImageData`: binary, compressed.
///
/// # Shapes
/// `counts`: points along x, y and z. `points` has a row for each point, x first, then y, then z; all columns
/// become data arrays.
///
/// # Units
/// `origin`: the first point; `spacing`: the distance of neighbours. `time` is the `TimeValue` of the file.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if the rows are not those of the grid, or a column
/// contains text.
///
/// # Source
/// The VTK User's Guide, "VTK File Formats", XML formats, appended data.
///
/// # Example
/// ```
/// use fdem_io::{Table, Values, write_vti};
///
/// let points = Table::new(6).with("density", Values::f64(|k| k as f64));
/// let mut out = Vec::new();
/// write_vti(&mut out, [0.0; 3], 0.1, [3, 2, 1], &points, 0.5)?;
/// assert!(String::from_utf8_lossy(&out).contains("WholeExtent=\"0 2 0 1 0 0\""));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_vti<W: Write>(
    out: &mut W,
    origin: [f64; 3],
    spacing: f64,
    counts: [usize; 3],
    points: &Table<'_>,
    time: f64,
) -> io::Result<()> {
    let size = counts.iter().try_fold(1_usize, |size, &count| size.checked_mul(count));
    if size.is_none_or(|size| size == 0 || size != points.rows()) {
        let problem = "a grid has a row for each of its points, and at least one point";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let extent = counts.map(|count| format!("0 {}", count - 1)).join(" ");
    let [x, y, z] = origin;
    let mut body = Appended::default();
    let mut head = format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{x:e} {y:e} {z:e}\" Spacing=\"{spacing:e} {spacing:e} {spacing:e}\">\n"
    );
    head += &body.field_data(time, &[])?;
    head = format!("{head}<Piece Extent=\"{extent}\">\n<PointData>\n");
    for column in points.columns() {
        head += &body.column(column, points.rows())?;
    }
    head +=
        "</PointData>\n<CellData>\n</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
    out.write_all(head.as_bytes())?;
    out.write_all(&body.bytes)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}
