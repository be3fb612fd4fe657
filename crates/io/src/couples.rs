//! Contact couples, written as text or as a NumPy array.

use std::io::{self, Write};

use crate::npy_header::header;

/// Bytes gathered before they are written: large enough that a file gets few writes, small enough for a cache.
pub(crate) const CHUNK: usize = 1 << 18;
/// No row is longer: two ids of 20 characters, four floats of 24 or two and three shifts of 11, delimiters.
pub(crate) const LONGEST_ROW: usize = 160;

/// One couple of elements in contact, in a box that repeats with the `S` numbers of its shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupleRow<const S: usize = 0> {
    /// Id or row number of the first element.
    pub i: i64,
    /// Id or row number of the second element.
    pub j: i64,
    /// Distance between the centres, in the length unit of the packing.
    pub distance: f64,
    /// Sum of the radii less the distance, in the length unit of the packing; negative across a gap.
    pub overlap: f64,
    /// Edges of the box by which the second element is displaced where it touches the first; nothing without such a box.
    pub shift: [i32; S],
}

/// Names of the shifts along the edges of a box.
const SHIFTS: [&str; 3] = ["sx", "sy", "sz"];

/// The names that a row with `S` shifts needs.
pub(crate) fn shifts<const S: usize>() -> &'static [&'static str] {
    const { assert!(S <= SHIFTS.len(), "a box has three edges at most") };
    &SHIFTS[..S]
}

/// Writes couples as text under the header `i,j,distance,overlap`, and `sx,sy,sz` if they have shifts.
///
/// Floats are the shortest text that reads back as the same `f64`. Rows come in the order of `rows`; the
/// bytes depend on nothing else.
///
/// # Shapes
/// `rows`: `m` couples. The result is `m`.
///
/// # Cost
/// Time proportional to `m`; one buffer of 256 KiB, so `out` needs none. `out` is not flushed.
///
/// # Errors
/// Those of `out`.
///
/// # Example
/// ```
/// let rows = [fdem_io::CoupleRow { i: 0, j: 7, distance: 0.1, overlap: 0.0, shift: [] }];
/// let mut out = Vec::new();
/// assert_eq!(fdem_io::write_csv(&mut out, rows.into_iter())?, 1);
/// assert_eq!(out, b"i,j,distance,overlap\n0,7,0.1,0.0\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_csv<W: Write, const S: usize>(
    out: &mut W,
    rows: impl Iterator<Item = CoupleRow<S>>,
) -> io::Result<u64> {
    let (mut integer, mut float) = (itoa::Buffer::new(), ryu::Buffer::new());
    let mut chunk = Vec::with_capacity(CHUNK);
    chunk.extend_from_slice(b"i,j,distance,overlap");
    for name in shifts::<S>() {
        chunk.push(b',');
        chunk.extend_from_slice(name.as_bytes());
    }
    chunk.push(b'\n');
    let mut count = 0;
    for row in rows {
        if chunk.len() > CHUNK - LONGEST_ROW {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        chunk.extend_from_slice(integer.format(row.i).as_bytes());
        chunk.push(b',');
        chunk.extend_from_slice(integer.format(row.j).as_bytes());
        chunk.push(b',');
        chunk.extend_from_slice(float.format(row.distance).as_bytes());
        chunk.push(b',');
        chunk.extend_from_slice(float.format(row.overlap).as_bytes());
        for shift in row.shift {
            chunk.push(b',');
            chunk.extend_from_slice(integer.format(shift).as_bytes());
        }
        chunk.push(b'\n');
        count += 1;
    }
    out.write_all(&chunk)?;
    Ok(count)
}

/// Writes couples as a NumPy array with the fields `i`, `j` (`<i8`), `distance` and `overlap` (`<f8`), and `sx`, `sy`, `sz` (`<i4`) if
/// they have shifts.
///
/// `numpy.load` gives an array of shape `(m,)`; `a["distance"]` is its third column.
///
/// # Shapes
/// `rows`: `m` couples, 32 bytes each in the file, and 4 for each shift.
///
/// # Cost
/// Time proportional to `m`; one buffer of 256 KiB, so `out` needs none. `out` is not flushed.
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] if `rows` gives more or fewer couples than its length
/// says, since the header is written first.
///
/// # Source
/// NumPy Enhancement Proposal 1, version 1.0 of the format.
///
/// # Example
/// ```
/// let rows = [fdem_io::CoupleRow { i: 0, j: 7, distance: 0.1, overlap: 0.0, shift: [] }];
/// let mut out = Vec::new();
/// fdem_io::write_npy(&mut out, rows.into_iter())?;
/// assert!(out.starts_with(b"\x93NUMPY"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_npy<W: Write, const S: usize>(
    out: &mut W,
    rows: impl ExactSizeIterator<Item = CoupleRow<S>>,
) -> io::Result<()> {
    let mut dtype = "[('i', '<i8'), ('j', '<i8'), ('distance', '<f8'), ('overlap', '<f8')".to_owned();
    for name in shifts::<S>() {
        dtype.extend([", ('", name, "', '<i4')"]);
    }
    dtype += "]";
    let expected = rows.len();
    let mut chunk = header(&dtype, &format!("({expected},)"));
    let mut found = 0;
    for row in rows {
        if chunk.len() > CHUNK - LONGEST_ROW {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        chunk.extend_from_slice(&row.i.to_le_bytes());
        chunk.extend_from_slice(&row.j.to_le_bytes());
        chunk.extend_from_slice(&row.distance.to_le_bytes());
        chunk.extend_from_slice(&row.overlap.to_le_bytes());
        for shift in row.shift {
            chunk.extend_from_slice(&shift.to_le_bytes());
        }
        found += 1;
    }
    if found != expected {
        let problem = format!("expected {expected} couples, found {found}");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    out.write_all(&chunk)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_row_fits_the_room_kept_for_it() {
        let row = CoupleRow {
            i: i64::MIN,
            j: i64::MIN,
            distance: -f64::MAX,
            overlap: -2.225_073_858_507_201_4e-308,
            shift: [i32::MIN; 3],
        };
        let mut out = Vec::new();
        write_csv(&mut out, std::iter::once(row)).unwrap();
        let header = b"i,j,distance,overlap,sx,sy,sz\n".len();
        assert!(out.len() - header <= LONGEST_ROW, "{}", out.len());
    }

    #[test]
    fn no_couples_give_a_header() {
        let mut out = Vec::new();
        assert_eq!(write_csv::<_, 0>(&mut out, std::iter::empty()).unwrap(), 0);
        assert_eq!(out, b"i,j,distance,overlap\n");
    }
}
