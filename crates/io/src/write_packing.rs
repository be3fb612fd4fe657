//! Writes packings as text or as a NumPy array.

use std::io::{self, Write};

use crate::npy_header::header;
use crate::packing::Centres;
use crate::written::table::CHUNK;

/// Upper bound on the bytes of a row: four floats of 24 characters and delimiters.
const LONGEST_ROW: usize = 160;

/// Writes a packing as text under the header `x,y[,z][,radius]`.
///
/// [`read`](crate::read) returns the same numbers, bit for bit.
///
/// # Shapes
/// `centres`: `n`. `radii`: `n` if given.
///
/// # Cost
/// Time proportional to `n`. Uses a buffer of 256 KiB, so `out` needs none. `out` is not flushed.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if `radii` is not as long as `centres`.
///
/// # Example
/// ```
/// let centres = fdem_io::Centres::Two(vec![[0.0, 0.5]]);
/// let mut out = Vec::new();
/// fdem_io::write_packing_csv(&mut out, &centres, Some(&[0.25]))?;
/// assert_eq!(out, b"x,y,radius\n0.0,0.5,0.25\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_packing_csv<W: Write>(out: &mut W, centres: &Centres, radii: Option<&[f64]>) -> io::Result<()> {
    let mut names = match centres {
        Centres::Two(_) => "x,y".to_owned(),
        Centres::Three(_) => "x,y,z".to_owned(),
    };
    names.push_str(if radii.is_some() { ",radius\n" } else { "\n" });
    let mut float = ryu::Buffer::new();
    write_rows(out, names.into_bytes(), centres, radii, |chunk, values| {
        for (place, value) in values.enumerate() {
            if place > 0 {
                chunk.push(b',');
            }
            chunk.extend_from_slice(float.format(value).as_bytes());
        }
        chunk.push(b'\n');
    })
}

/// Writes a packing as a NumPy array of `<f8` in C order, with the columns x, y, z, radius that exist.
///
/// A 2D packing with radii gets the named fields `x`, `y`, `radius` instead, because a plain array of three
/// columns would be read as x, y, z. [`read`](crate::read) returns the same numbers, bit for bit.
///
/// # Shapes
/// `centres`: `n`. `radii`: `n` if given. The array is `(n, 2)`, `(n, 3)` or `(n, 4)`; with fields, `(n,)`.
///
/// # Cost
/// Time proportional to `n`. Uses a buffer of 256 KiB, so `out` needs none. `out` is not flushed.
///
/// # Errors
/// The errors of `out`; [`io::ErrorKind::InvalidInput`] if `radii` is not as long as `centres`.
///
/// # Source
/// NumPy Enhancement Proposal 1, version 1.0 of the format.
pub fn write_packing_npy<W: Write>(out: &mut W, centres: &Centres, radii: Option<&[f64]>) -> io::Result<()> {
    let n = centres.len();
    let head = match (centres, radii) {
        (Centres::Two(_), None) => header("'<f8'", &format!("({n}, 2)")),
        (Centres::Two(_), Some(_)) => {
            header("[('x', '<f8'), ('y', '<f8'), ('radius', '<f8')]", &format!("({n},)"))
        }
        (Centres::Three(_), None) => header("'<f8'", &format!("({n}, 3)")),
        (Centres::Three(_), Some(_)) => header("'<f8'", &format!("({n}, 4)")),
    };
    write_rows(out, head, centres, radii, |chunk, values| {
        values.for_each(|value| chunk.extend_from_slice(&value.to_le_bytes()));
    })
}

/// The values of one element: its centre, followed by its radius if there is one.
type PackingValues<'a> =
    std::iter::Chain<std::iter::Copied<std::slice::Iter<'a, f64>>, std::option::IntoIter<f64>>;

fn write_rows<W: Write>(
    out: &mut W,
    head: Vec<u8>,
    centres: &Centres,
    radii: Option<&[f64]>,
    mut write: impl FnMut(&mut Vec<u8>, PackingValues<'_>),
) -> io::Result<()> {
    if let Some(radii) = radii.filter(|radii| radii.len() != centres.len()) {
        let problem = format!("expected as many radii as centres, {}, found {}", centres.len(), radii.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let mut chunk = head;
    for i in 0..centres.len() {
        if chunk.len() > CHUNK - LONGEST_ROW {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        let centre: &[f64] = match centres {
            Centres::Two(centres) => &centres[i],
            Centres::Three(centres) => &centres[i],
        };
        write(&mut chunk, centre.iter().copied().chain(radii.map(|radii| radii[i])));
    }
    out.write_all(&chunk)
}
