//! `.data` files of MercuryDPM.

use std::sync::atomic::AtomicU64;

use crate::columns::Name;
use crate::error::ReadError;
use crate::excerpt;
use crate::lines::Lines;
use crate::mesh::cursor::words;
use crate::options::ReadOptions;
use crate::packing::{Format, Frame, Packing, SimulationBox};
use crate::series::rows::{RowTable, at_end, broken, expect, number, whole};

/// Number of bytes that contain the first two lines of any such file.
const HEAD: usize = 1 << 12;
const COLUMNS_2D: &str = "x y vx vy radius angle omega info";
const COLUMNS_3D: &str = "x y z vx vy vz radius alpha beta gamma omegax omegay omegaz info";

/// Whether the content is such a file: a line of 8 numbers, or 6 in 2D, the first of which is the number of
/// following lines of 14, or 8, numbers.
pub(crate) fn is(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    let mut lines = Lines::new(head);
    let Some((_, first)) = lines.next_filled() else { return false };
    let Some(head) = MercuryHead::of(first) else { return false };
    match lines.next_filled() {
        Some((_, row)) if head.count > 0 => {
            words(row).count() == head.columns().split(' ').count() && words(row).all(is_number)
        }
        Some((_, next)) => MercuryHead::of(next).is_some_and(|next| next.dimensions == head.dimensions),
        None => false,
    }
}

fn is_number(word: &[u8]) -> bool {
    fast_float2::parse::<f64, _>(word).is_ok()
}

/// Skips a frame; returns false if it is damaged or followed by anything other than another frame.
pub(crate) fn pass(lines: &mut Lines<'_>) -> bool {
    let head = lines.next_filled().and_then(|(_, line)| MercuryHead::of(line));
    let passed = head.is_some_and(|head| lines.pass(head.count as u64));
    passed && lines.clone().next_filled().is_none_or(|(_, line)| MercuryHead::of(line).is_some())
}

pub(crate) fn read(
    mut lines: Lines<'_>,
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    const HEADER: &str = "number of particles, time, and the limits of the box: 8 numbers, or 6 in 2D";
    let before = lines.number;
    let (line, text) = expect(&mut lines, HEADER)?;
    let Some(head) = MercuryHead::of(text) else {
        return broken(line, format!("expected {HEADER}, found '{}'", excerpt::line(text)));
    };
    let names: Vec<Name> = head.columns().split(' ').map(Name::unsuffixed).collect();
    let table = RowTable::new(&names, line, text, options)?;
    let elements = table.read(&mut lines, head.count, options, progress)?;
    at_end(&mut lines, head.count, "the header of the next frame or the end of the file")?;
    let time = number(line, words(text).nth(1).unwrap_or_default(), "the time")?;
    // The limits of walls may be infinite; then there is no box.
    let limits: Vec<f64> =
        words(text).skip(2).map(|word| fast_float2::parse(word).unwrap_or(f64::NAN)).collect();
    let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
    for axis in 0..head.dimensions {
        low[axis] = limits[axis];
        high[axis] = limits[head.dimensions + axis];
    }
    let cell = SimulationBox::orthogonal(low, high, [false; 3]);
    let frame = Frame { index: 0, step: None, time: Some(time) };
    Ok(table.packing(
        elements,
        Format::Mercury,
        lines.number - before,
        Some(cell).filter(SimulationBox::is_finite),
        frame,
    ))
}

/// The first numbers of the line before the rows.
struct MercuryHead {
    count: usize,
    dimensions: usize,
}

impl MercuryHead {
    fn of(line: &[u8]) -> Option<Self> {
        let mut fields = words(line);
        let count = whole(fields.next()?)?;
        let dimensions = match fields.clone().count() {
            5 => 2,
            7 => 3,
            _ => return None,
        };
        fields.all(is_number).then_some(Self { count, dimensions })
    }

    fn columns(&self) -> &'static str {
        if self.dimensions == 2 { COLUMNS_2D } else { COLUMNS_3D }
    }
}
