//! Contacts of meshes, of their elements and of their bodies, written as text or as a NumPy array.

use std::io::{self, Write};

use crate::couples::CHUNK;
use crate::npy_header::header;

/// Two elements in contact, in `D` dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementContactRow<const D: usize> {
    /// Number of the first element, as its file has it.
    pub i: i64,
    /// Number of the second element.
    pub j: i64,
    /// The bodies of both.
    pub bodies: [u32; 2],
    /// What `measure` is: `depth`, `length`, `area` or `volume`; of six characters at most.
    pub kind: &'static str,
    /// How much they overlap.
    pub measure: f64,
    /// x, y and in 3D z.
    pub point: [f64; D],
    /// Unit vector from the first element to the second.
    pub normal: [f64; D],
}

/// Two bodies in contact, in `D` dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyContactRow<const D: usize> {
    /// The two bodies.
    pub bodies: [u32; 2],
    /// Couples of their elements.
    pub couples: u64,
    /// How much they overlap.
    pub overlap: f64,
    /// Length or area of the boundary that they share.
    pub shared: f64,
    /// x, y and in 3D z.
    pub point: [f64; D],
    /// Unit vector from the first body to the second, or zeros.
    pub normal: [f64; D],
}

/// A field of a row.
enum Value {
    Integer(i64),
    Float(f64),
    /// Of [`TEXT`] bytes at most.
    Text(&'static str),
}

/// Bytes of a text in an array.
const TEXT: usize = 6;

/// Rows as fields with names.
trait Row {
    /// Names with NumPy dtypes.
    fn names() -> Vec<(&'static str, &'static str)>;
    fn values(&self) -> impl Iterator<Item = Value>;
}

const POINT: [(&str, &str); 3] = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")];
const NORMAL: [(&str, &str); 3] = [("nx", "<f8"), ("ny", "<f8"), ("nz", "<f8")];

impl<const D: usize> Row for ElementContactRow<D> {
    fn names() -> Vec<(&'static str, &'static str)> {
        let first = [
            ("i", "<i8"),
            ("j", "<i8"),
            ("body_i", "<i8"),
            ("body_j", "<i8"),
            ("kind", "|S6"),
            ("measure", "<f8"),
        ];
        first.into_iter().chain(POINT.into_iter().take(D)).chain(NORMAL.into_iter().take(D)).collect()
    }

    fn values(&self) -> impl Iterator<Item = Value> {
        let [a, b] = self.bodies.map(i64::from);
        let integers = [self.i, self.j, a, b].map(Value::Integer);
        let floats = std::iter::once(self.measure).chain(self.point).chain(self.normal);
        integers.into_iter().chain([Value::Text(self.kind)]).chain(floats.map(Value::Float))
    }
}

impl<const D: usize> Row for BodyContactRow<D> {
    fn names() -> Vec<(&'static str, &'static str)> {
        let first = [("i", "<i8"), ("j", "<i8"), ("couples", "<i8"), ("overlap", "<f8"), ("shared", "<f8")];
        first.into_iter().chain(POINT.into_iter().take(D)).chain(NORMAL.into_iter().take(D)).collect()
    }

    fn values(&self) -> impl Iterator<Item = Value> {
        let [a, b] = self.bodies.map(i64::from);
        let integers = [a, b, self.couples.cast_signed()].map(Value::Integer);
        let floats = [self.overlap, self.shared].into_iter().chain(self.point).chain(self.normal);
        integers.into_iter().chain(floats.map(Value::Float))
    }
}

/// Writes contacts of elements as text under the header `i,j,body_i,body_j,kind,measure,x,y,z,nx,ny,nz`; in 2D without `z` and `nz`.
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
/// use fdem_io::{ElementContactRow, write_element_contacts_csv};
///
/// let (point, normal) = ([1.0, 0.5], [1.0, 0.0]);
/// let row = ElementContactRow { i: 3, j: 9, bodies: [0, 1], kind: "area", measure: 0.25, point, normal };
/// let mut out = Vec::new();
/// write_element_contacts_csv(&mut out, [row].into_iter())?;
/// assert_eq!(out, b"i,j,body_i,body_j,kind,measure,x,y,nx,ny\n3,9,0,1,area,0.25,1.0,0.5,1.0,0.0\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_element_contacts_csv<W: Write, const D: usize>(
    out: &mut W,
    rows: impl Iterator<Item = ElementContactRow<D>>,
) -> io::Result<()> {
    csv(out, rows)
}

/// Writes contacts of elements as a NumPy array with the columns of [`write_element_contacts_csv`] as fields: numbers `<i8`, the kind `|S6`, the others `<f8`.
///
/// # Shapes
/// `rows`: `m` contacts; `numpy.load` gives an array of shape `(m,)`. `D` is 2 or 3.
///
/// # Cost
/// As [`write_element_contacts_csv`].
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] if `rows` gives more or fewer contacts than its length says, since the header is written first.
///
/// # Source
/// NumPy Enhancement Proposal 1, version 1.0 of the format.
///
/// # Example
/// ```
/// let mut out = Vec::new();
/// fdem_io::write_element_contacts_npy(&mut out, std::iter::empty::<fdem_io::ElementContactRow<3>>())?;
/// assert!(out.starts_with(b"\x93NUMPY"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_element_contacts_npy<W: Write, const D: usize>(
    out: &mut W,
    rows: impl ExactSizeIterator<Item = ElementContactRow<D>>,
) -> io::Result<()> {
    npy(out, rows)
}

/// Writes contacts of bodies as text under the header `i,j,couples,overlap,shared,x,y,z,nx,ny,nz`; in 2D without `z` and `nz`.
///
/// As [`write_element_contacts_csv`] in all else.
///
/// # Errors
/// Those of `out`.
///
/// # Example
/// ```
/// use fdem_io::{BodyContactRow, write_body_contacts_csv};
///
/// let (point, normal) = ([1.0, 0.5], [1.0, 0.0]);
/// let row = BodyContactRow { bodies: [0, 1], couples: 4, overlap: 0.0, shared: 1.5, point, normal };
/// let mut out = Vec::new();
/// write_body_contacts_csv(&mut out, [row].into_iter())?;
/// assert_eq!(out, b"i,j,couples,overlap,shared,x,y,nx,ny\n0,1,4,0.0,1.5,1.0,0.5,1.0,0.0\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_body_contacts_csv<W: Write, const D: usize>(
    out: &mut W,
    rows: impl Iterator<Item = BodyContactRow<D>>,
) -> io::Result<()> {
    csv(out, rows)
}

/// Writes contacts of bodies as a NumPy array with the columns of [`write_body_contacts_csv`] as fields: numbers `<i8`, the others `<f8`.
///
/// # Errors
/// As [`write_element_contacts_npy`].
///
/// # Example
/// ```
/// let mut out = Vec::new();
/// fdem_io::write_body_contacts_npy(&mut out, std::iter::empty::<fdem_io::BodyContactRow<3>>())?;
/// assert!(out.starts_with(b"\x93NUMPY"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_body_contacts_npy<W: Write, const D: usize>(
    out: &mut W,
    rows: impl ExactSizeIterator<Item = BodyContactRow<D>>,
) -> io::Result<()> {
    npy(out, rows)
}

fn csv<W: Write, R: Row>(out: &mut W, rows: impl Iterator<Item = R>) -> io::Result<()> {
    let (mut integer, mut float) = (itoa::Buffer::new(), ryu::Buffer::new());
    let names: Vec<_> = R::names().into_iter().map(|(name, _)| name).collect();
    let mut chunk = (names.join(",") + "\n").into_bytes();
    for row in rows {
        for (place, value) in row.values().enumerate() {
            if place > 0 {
                chunk.push(b',');
            }
            let text = match value {
                Value::Integer(number) => integer.format(number),
                Value::Float(number) => float.format(number),
                Value::Text(text) => text,
            };
            chunk.extend_from_slice(text.as_bytes());
        }
        chunk.push(b'\n');
        if chunk.len() >= CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
    }
    out.write_all(&chunk)
}

fn npy<W: Write, R: Row>(out: &mut W, rows: impl ExactSizeIterator<Item = R>) -> io::Result<()> {
    let fields: Vec<_> = R::names().iter().map(|(name, dtype)| format!("('{name}', '{dtype}')")).collect();
    let expected = rows.len();
    let mut chunk = header(&format!("[{}]", fields.join(", ")), &format!("({expected},)"));
    let mut found = 0;
    for row in rows {
        for value in row.values() {
            match value {
                Value::Integer(number) => chunk.extend(number.to_le_bytes()),
                Value::Float(number) => chunk.extend(number.to_le_bytes()),
                Value::Text(text) => {
                    chunk.extend(text.bytes().chain(std::iter::repeat(0)).take(TEXT));
                }
            }
        }
        if chunk.len() >= CHUNK {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        found += 1;
    }
    if found != expected {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("expected {expected} contacts, found {found}"),
        ));
    }
    out.write_all(&chunk)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_arrays_have_the_size_that_the_header_says() {
        let row = ElementContactRow {
            i: 1,
            j: -2,
            bodies: [0, 3],
            kind: "length",
            measure: 0.5,
            point: [1.0; 3],
            normal: [0.0; 3],
        };
        let [mut none, mut two] = [Vec::new(), Vec::new()];
        write_element_contacts_npy(&mut none, std::iter::empty::<ElementContactRow<3>>()).unwrap();
        write_element_contacts_npy(&mut two, [row; 2].into_iter()).unwrap();
        assert_eq!((two.len() - none.len()) / 2, 4 * 8 + TEXT + 7 * 8);
        assert_eq!(&two[two.len() - 62..][..6], b"length");
    }
}
