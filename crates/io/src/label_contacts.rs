//! Contacts of bodies in labelled images, written as text or as a NumPy array.

use std::io::{self, Write};

use crate::couples::CHUNK;
use crate::npy_header::header;

/// Two bodies in contact, in an image of `D` axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabelContactRow<const D: usize> {
    /// The smaller label.
    pub i: i128,
    /// The larger label.
    pub j: i128,
    /// Shared faces.
    pub faces: u64,
    /// Pairs of grid squares that share an edge and no face.
    pub edges: u64,
    /// Pairs of grid squares that share a vertex only.
    pub vertices: u64,
    /// Area of the shared faces; in 2D their length.
    pub area: f64,
    /// x, y and in 3D z.
    pub centroid: [f64; D],
    /// Unit vector from `i` to `j`, or zeros.
    pub normal: [f64; D],
}

/// Which columns the contacts of an image have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LabelColumns {
    /// Whether pairs that share an edge were counted.
    pub edges: bool,
    /// Whether pairs that share a vertex were counted.
    pub vertices: bool,
    /// Whether labels may be above `i64::MAX`; in NumPy arrays they are unsigned then.
    pub unsigned: bool,
}

impl LabelColumns {
    /// Names of the columns, with their NumPy dtypes.
    fn names<const D: usize>(self) -> Vec<(&'static str, &'static str)> {
        let label = if self.unsigned { "<u8" } else { "<i8" };
        let mut names = vec![("i", label), ("j", label), ("faces", "<u8")];
        names.extend(self.edges.then_some(("edges", "<u8")));
        names.extend(self.vertices.then_some(("vertices", "<u8")));
        names.push((if D == 2 { "length" } else { "area" }, "<f8"));
        names.extend([("x", "<f8"), ("y", "<f8"), ("z", "<f8")].iter().take(D));
        names.extend([("nx", "<f8"), ("ny", "<f8"), ("nz", "<f8")].iter().take(D));
        names
    }

    /// The counts that have columns.
    fn counts<const D: usize>(self, row: &LabelContactRow<D>) -> impl Iterator<Item = u64> {
        let edges = self.edges.then_some(row.edges);
        let vertices = self.vertices.then_some(row.vertices);
        [Some(row.faces), edges, vertices].into_iter().flatten()
    }
}

/// The floats of a row, in the order of the columns.
fn floats<const D: usize>(row: &LabelContactRow<D>) -> impl Iterator<Item = f64> {
    std::iter::once(row.area).chain(row.centroid).chain(row.normal)
}

/// Writes contacts as text under the header `i,j,faces,area,x,y,z,nx,ny,nz`, with `edges` and `vertices` behind `faces` if they were
/// counted; in 2D `length` in place of `area`, and no `z`.
///
/// Floats are the shortest text that reads back as the same `f64`. Rows come in the order of `rows`.
///
/// # Shapes
/// `rows`: `m` contacts. `D` is 2 or 3.
///
/// # Cost
/// Time proportional to `m`; one buffer of 256 KiB, so `out` needs none. `out` is not flushed.
///
/// # Errors
/// Those of `out`.
///
/// # Example
/// ```
/// use fdem_io::{LabelColumns, LabelContactRow, write_label_contacts_csv};
///
/// let (centroid, normal) = ([0.5, 0.0], [1.0, 0.0]);
/// let row = LabelContactRow { i: 1, j: 7, faces: 2, edges: 0, vertices: 0, area: 2.0, centroid, normal };
/// let mut out = Vec::new();
/// write_label_contacts_csv(&mut out, LabelColumns::default(), [row].into_iter())?;
/// assert_eq!(out, b"i,j,faces,length,x,y,nx,ny\n1,7,2,2.0,0.5,0.0,1.0,0.0\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_label_contacts_csv<W: Write, const D: usize>(
    out: &mut W,
    columns: LabelColumns,
    rows: impl Iterator<Item = LabelContactRow<D>>,
) -> io::Result<()> {
    let (mut integer, mut float) = (itoa::Buffer::new(), ryu::Buffer::new());
    let names: Vec<_> = columns.names::<D>().into_iter().map(|(name, _)| name).collect();
    let mut chunk = (names.join(",") + "\n").into_bytes();
    for row in rows {
        chunk.extend_from_slice(integer.format(row.i).as_bytes());
        chunk.push(b',');
        chunk.extend_from_slice(integer.format(row.j).as_bytes());
        for count in columns.counts(&row) {
            chunk.push(b',');
            chunk.extend_from_slice(integer.format(count).as_bytes());
        }
        for number in floats(&row) {
            chunk.push(b',');
            chunk.extend_from_slice(float.format(number).as_bytes());
        }
        chunk.push(b'\n');
        if chunk.len() >= CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
    }
    out.write_all(&chunk)
}

/// Writes contacts as a NumPy array with the columns of [`write_label_contacts_csv`] as fields: labels `<i8` (or `<u8`), counts `<u8`, the others
/// `<f8`.
///
/// # Shapes
/// `rows`: `m` contacts; `numpy.load` gives an array of shape `(m,)`. `D` is 2 or 3.
///
/// # Cost
/// As [`write_label_contacts_csv`].
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] if a label does not fit its 64 bits, or `rows` gives more or fewer contacts than its length
/// says, since the header is written first.
///
/// # Source
/// NumPy Enhancement Proposal 1, version 1.0 of the format.
///
/// # Example
/// ```
/// let mut out = Vec::new();
/// let none = std::iter::empty::<fdem_io::LabelContactRow<3>>();
/// fdem_io::write_label_contacts_npy(&mut out, fdem_io::LabelColumns::default(), none)?;
/// assert!(out.starts_with(b"\x93NUMPY"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_label_contacts_npy<W: Write, const D: usize>(
    out: &mut W,
    columns: LabelColumns,
    rows: impl ExactSizeIterator<Item = LabelContactRow<D>>,
) -> io::Result<()> {
    let invalid = |problem: String| io::Error::new(io::ErrorKind::InvalidInput, problem);
    let fields: Vec<_> =
        columns.names::<D>().iter().map(|(name, dtype)| format!("('{name}', '{dtype}')")).collect();
    let expected = rows.len();
    let mut chunk = header(&format!("[{}]", fields.join(", ")), &format!("({expected},)"));
    let mut found = 0;
    for row in rows {
        for label in [row.i, row.j] {
            let bytes = if columns.unsigned {
                u64::try_from(label).map(u64::to_le_bytes)
            } else {
                i64::try_from(label).map(i64::to_le_bytes)
            };
            chunk.extend(bytes.map_err(|_| invalid(format!("the label {label} does not fit its column")))?);
        }
        for count in columns.counts(&row) {
            chunk.extend(count.to_le_bytes());
        }
        for number in floats(&row) {
            chunk.extend(number.to_le_bytes());
        }
        if chunk.len() >= CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        found += 1;
    }
    if found != expected {
        return Err(invalid(format!("expected {expected} contacts, found {found}")));
    }
    out.write_all(&chunk)
}
