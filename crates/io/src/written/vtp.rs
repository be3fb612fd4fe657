//! Writes points and lines for ParaView.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::written::table::{Table, TableColumn, Values};

/// Number of bytes compressed at a time: a multiple of the size of every value.
const BLOCK: usize = 1 << 20;

/// Writes points, lines between them, and the data of both as a VTK file of `PolyData`: binary, compressed.
///
/// # Shapes
/// The first column of `points` holds their positions: three components, floats. The first column of `lines`
/// holds the numbers of two points, counted from 0: two components of 64 bits. All other columns become data
/// arrays of the points and of the lines (cells).
///
/// # Cost
/// Each array is compressed twice, because its size precedes it: some 10 ns per byte. Memory: two blocks of 1
/// MiB. `out` is not flushed.
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
/// use fdem_io::{Table, Values, write_vtp};
///
/// let points = Table::new(2).with_components("positions", &["x", "y", "z"], Values::f64(|k| k as f64));
/// let lines = Table::new(1)
///     .with_components("ends", &["i", "j"], Values::i64(|k| k as i64))
///     .with("overlap", Values::f64(|_| 0.25));
/// let mut out = Vec::new();
/// write_vtp(&mut out, &points, &lines)?;
/// assert!(out.starts_with(b"<?xml"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_vtp<W: Write>(out: &mut W, points: &Table<'_>, lines: &Table<'_>) -> io::Result<()> {
    let invalid = |problem: &str| io::Error::new(io::ErrorKind::InvalidInput, problem.to_owned());
    let (Some((positions, of_points)), Some((ends, of_lines))) =
        (points.columns().split_first(), lines.columns().split_first())
    else {
        return Err(invalid("points without positions, or lines without ends"));
    };
    if positions.width() != 3 || !matches!(positions.values, Values::F64(_)) {
        return Err(invalid("positions are three floats each"));
    }
    let (2, Values::I64(at)) = (ends.width(), &ends.values) else {
        return Err(invalid("the ends of a line are two whole numbers"));
    };
    // Two numbers per line, computed without an array of pairs.
    let connectivity =
        TableColumn { name: "connectivity", components: &[], unit: "", values: Values::i64(at) };
    // The end of each line in the list of points.
    let offsets = TableColumn {
        name: "offsets",
        components: &[],
        unit: "",
        values: Values::i64(|k| 2 * (k.cast_signed() as i64 + 1)),
    };

    let (n, m) = (points.rows(), lines.rows());
    let mut body = Body { arrays: Vec::new(), at: 0, encoder: encoder(), block: Vec::new() };
    let mut head = format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n\
         <PolyData>\n<Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"0\" NumberOfLines=\"{m}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
    );
    head += "<PointData>\n";
    for column in of_points {
        head += &body.announce(column, plain_name(column), n)?;
    }
    head += "</PointData>\n<CellData>\n";
    for column in of_lines {
        head += &body.announce(column, plain_name(column), m)?;
    }
    head += "</CellData>\n<Points>\n";
    head += &body.announce(positions, "Points", n)?;
    head += "</Points>\n<Lines>\n";
    head += &body.announce(&connectivity, "connectivity", 2 * m)?;
    head += &body.announce(&offsets, "offsets", m)?;
    head += "</Lines>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    out.write_all(head.as_bytes())?;
    body.write(out)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

/// The name of an array: the name of its component if there is only one, otherwise the name of the column.
fn plain_name<'a>(column: &TableColumn<'a>) -> &'a str {
    match column.components {
        [name] => name,
        _ => column.name,
    }
}

fn encoder() -> ZlibEncoder<Vec<u8>> {
    ZlibEncoder::new(Vec::new(), Compression::fast())
}

/// The arrays after the header.
struct Body<'t> {
    arrays: Vec<VtpArray<'t>>,
    /// The offset of the next array.
    at: u64,
    encoder: ZlibEncoder<Vec<u8>>,
    block: Vec<u8>,
}

struct VtpArray<'t> {
    values: &'t Values<'t>,
    length: usize,
    /// Number of bytes of each compressed block.
    sizes: Vec<u64>,
}

impl<'t> Body<'t> {
    /// Adds an array of `rows` rows; returns the XML element that describes it.
    fn announce(&mut self, column: &'t TableColumn<'_>, name: &str, rows: usize) -> io::Result<String> {
        let of_type = column.vtk_type()?;
        let mut array = VtpArray { values: &column.values, length: rows * column.width(), sizes: Vec::new() };
        for start in (0..array.length).step_by(array.per_block()) {
            array.sizes.push(self.compress(&array, start)?.len() as u64);
        }
        let (components, offset) = (column.width(), self.at);
        self.at += 8 * (3 + array.sizes.len() as u64) + array.sizes.iter().sum::<u64>();
        self.arrays.push(array);
        Ok(format!(
            "<DataArray type=\"{of_type}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" offset=\"{offset}\"/>\n"
        ))
    }

    /// Compresses the block that starts with this value.
    fn compress(&mut self, array: &VtpArray<'_>, start: usize) -> io::Result<&[u8]> {
        self.block.clear();
        array.values.write_le(start..array.length.min(start + array.per_block()), &mut self.block);
        let mut room = std::mem::take(self.encoder.get_mut());
        room.clear();
        self.encoder.reset(room)?;
        self.encoder.write_all(&self.block)?;
        self.encoder.try_finish()?;
        Ok(self.encoder.get_ref())
    }

    fn write(&mut self, out: &mut impl Write) -> io::Result<()> {
        for array in std::mem::take(&mut self.arrays) {
            let partial = (array.length % array.per_block()) * array.values.size();
            let head = [array.sizes.len() as u64, BLOCK as u64, partial as u64];
            for number in head.iter().chain(&array.sizes) {
                out.write_all(&number.to_le_bytes())?;
            }
            for (start, size) in (0..array.length).step_by(array.per_block()).zip(&array.sizes) {
                let block = self.compress(&array, start)?;
                if block.len() as u64 != *size {
                    return Err(io::Error::other("a value changed while it was written"));
                }
                out.write_all(block)?;
            }
        }
        Ok(())
    }
}

impl VtpArray<'_> {
    /// Number of values per block.
    fn per_block(&self) -> usize {
        BLOCK / self.values.size()
    }
}
