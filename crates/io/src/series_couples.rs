//! Couples of several frames in one table.

use std::io::{self, Write};

use crate::couples::{CHUNK, CoupleRow, LONGEST_ROW, shifts};
use crate::npy_header::header;
use crate::packing::Frame;

/// The number written where a frame has no time step.
const NO_STEP: i64 = -1;

/// Writes the header of a table of several frames: `frame,step,i,j,distance,overlap`, and `sx,sy,sz` for `S` shifts.
///
/// # Errors
/// Those of `out`.
pub fn write_series_header_csv<const S: usize>(out: &mut dyn Write) -> io::Result<()> {
    let mut names = vec!["frame", "step", "i", "j", "distance", "overlap"];
    names.extend(shifts::<S>());
    writeln!(out, "{}", names.join(","))
}

/// Writes the couples of a frame under [`write_series_header_csv`]; the number of the frame is its [`Frame::index`], and the step is -1 where it has none.
///
/// # Cost
/// Time proportional to the couples; one buffer of 256 KiB.
///
/// # Errors
/// Those of `out`.
///
/// # Example
/// ```
/// use fdem_io::{CoupleRow, Frame, write_frame_csv};
///
/// let rows = [CoupleRow { i: 0, j: 7, distance: 0.1, overlap: 0.0, shift: [] }];
/// let mut out = Vec::new();
/// write_frame_csv(&mut out, Frame { index: 3, step: Some(500), time: None }, rows.into_iter())?;
/// assert_eq!(out, b"3,500,0,7,0.1,0.0\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_frame_csv<const S: usize>(
    out: &mut dyn Write,
    frame: Frame,
    rows: impl Iterator<Item = CoupleRow<S>>,
) -> io::Result<()> {
    let (mut integer, mut float) = (itoa::Buffer::new(), ryu::Buffer::new());
    let start = format!("{},{},", frame.index, frame.step.unwrap_or(NO_STEP));
    let mut chunk = Vec::with_capacity(CHUNK);
    for row in rows {
        if chunk.len() > CHUNK - LONGEST_ROW - start.len() {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        chunk.extend_from_slice(start.as_bytes());
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
    }
    out.write_all(&chunk)
}

/// Writes the header of a NumPy array of `rows` couples of several frames: the fields `frame`, `step`, `i`, `j` (`<i8`), `distance` and `overlap` (`<f8`), and
/// `sx`, `sy`, `sz` (`<i4`) for `S` shifts.
///
/// # Errors
/// Those of `out`.
pub fn write_series_header_npy<const S: usize>(out: &mut dyn Write, rows: u64) -> io::Result<()> {
    let mut dtype = "[('frame', '<i8'), ('step', '<i8'), ('i', '<i8'), ('j', '<i8'), ('distance', '<f8'), \
                     ('overlap', '<f8')"
        .to_owned();
    for name in shifts::<S>() {
        dtype.extend([", ('", name, "', '<i4')"]);
    }
    dtype += "]";
    out.write_all(&header(&dtype, &format!("({rows},)")))
}

/// Writes the couples of a frame as rows of the array of [`write_series_header_npy`], and says how many there were. The step is -1 where the frame has none.
///
/// # Cost
/// Time proportional to the couples; one buffer of 256 KiB.
///
/// # Errors
/// Those of `out`.
pub fn write_frame_npy<const S: usize>(
    out: &mut dyn Write,
    frame: Frame,
    rows: impl Iterator<Item = CoupleRow<S>>,
) -> io::Result<u64> {
    let mut chunk = Vec::with_capacity(CHUNK);
    let mut count = 0;
    for row in rows {
        if chunk.len() > CHUNK - LONGEST_ROW {
            out.write_all(&chunk)?;
            chunk.clear();
        }
        let whole = [(frame.index as u64).cast_signed(), frame.step.unwrap_or(NO_STEP), row.i, row.j];
        chunk.extend(whole.into_iter().flat_map(i64::to_le_bytes));
        chunk.extend([row.distance, row.overlap].into_iter().flat_map(f64::to_le_bytes));
        chunk.extend(row.shift.into_iter().flat_map(i32::to_le_bytes));
        count += 1;
    }
    out.write_all(&chunk)?;
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_all_frames_fit_one_table() {
        let row = |i| CoupleRow { i, j: i + 1, distance: 0.5, overlap: 0.25, shift: [0, -1] };
        let frames =
            [Frame { index: 0, step: Some(9), time: None }, Frame { index: 2, step: None, time: None }];
        let (mut csv, mut npy) = (Vec::new(), Vec::new());
        write_series_header_csv::<2>(&mut csv).unwrap();
        write_series_header_npy::<2>(&mut npy, 3).unwrap();
        let header = npy.len();
        for (frame, count) in frames.into_iter().zip([1, 2]) {
            write_frame_csv(&mut csv, frame, (0..count).map(row)).unwrap();
            assert_eq!(write_frame_npy(&mut npy, frame, (0..count).map(row)).unwrap(), count as u64);
        }
        let expected = "frame,step,i,j,distance,overlap,sx,sy\n0,9,0,1,0.5,0.25,0,-1\n2,-1,0,1,0.5,0.25,0,-1\n2,-1,1,2,0.5,0.25,0,-1\n";
        assert_eq!(String::from_utf8(csv).unwrap(), expected);
        assert_eq!(npy.len() - header, 3 * (6 * 8 + 2 * 4));
        assert!(String::from_utf8_lossy(&npy[..header]).contains("('frame', '<i8'), ('step', '<i8')"));
    }

    #[test]
    fn a_chunk_has_room_for_the_longest_row() {
        let row = CoupleRow {
            i: i64::MIN,
            j: i64::MIN,
            distance: -f64::MAX,
            overlap: -2.225_073_858_507_201_4e-308,
            shift: [i32::MIN; 3],
        };
        let frame = Frame { index: usize::MAX, step: Some(i64::MIN), time: None };
        let mut out = Vec::new();
        write_frame_csv(&mut out, frame, std::iter::once(row)).unwrap();
        assert!(out.len() <= LONGEST_ROW + 42, "{}", out.len());
    }
}
