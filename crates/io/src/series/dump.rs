//! Text dumps of LAMMPS and LIGGGHTS.

use std::sync::atomic::AtomicU64;

use crate::columns::{Name, Role};
use crate::error::ReadError;
use crate::excerpt;
use crate::lines::Lines;
use crate::mesh::cursor::words;
use crate::options::ReadOptions;
use crate::packing::{Centres, Format, Frame, Packing, SimulationBox};
use crate::series::rows::{RowTable, at_end, broken, expect, number, numbers, whole};

pub(super) const ITEM: &[u8] = b"ITEM:";
/// Endings of coordinates: as they are, scaled, unwrapped, and both.
const KINDS: [&str; 4] = ["", "s", "u", "su"];

/// Whether the content is that of a dump.
pub(crate) fn is(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(ITEM)
}

/// Skips a frame; returns false if it is damaged or followed by anything other than another frame.
pub(crate) fn pass(lines: &mut Lines<'_>) -> bool {
    let passed = DumpHead::read(lines).is_ok_and(|head| lines.pass(head.count as u64));
    passed && lines.clone().next_filled().is_none_or(|(_, line)| line.starts_with(ITEM))
}

pub(crate) fn read(
    mut lines: Lines<'_>,
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    let before = lines.number;
    let head = DumpHead::read(&mut lines)?;
    let Some(cell) = head.cell else {
        return broken(head.line, "ITEM: ATOMS comes before ITEM: BOX BOUNDS");
    };
    let fields: Vec<&[u8]> = words(head.columns).take(crate::columns::MOST_COLUMNS + 1).collect();
    let names = names(&fields);
    let table = RowTable::new(&names, head.line, head.columns, options)?;
    let scaled = scaled(&names, &table.roles);
    let mut elements = table.read(&mut lines, head.count, options, progress)?;
    at_end(&mut lines, head.count, "'ITEM: TIMESTEP' or the end of the file")?;
    if let Err(problem) = unscale(&mut elements.centres, &cell, scaled) {
        return broken(head.line, problem);
    }
    let frame = Frame { index: 0, step: Some(head.step), time: head.time };
    Ok(table.packing(elements, Format::LammpsDump, lines.number - before, Some(cell), frame))
}

/// The lines before the rows of a frame.
struct DumpHead<'a> {
    step: i64,
    time: Option<f64>,
    count: usize,
    cell: Option<SimulationBox>,
    /// The line with the names of the columns; below, its number.
    columns: &'a [u8],
    line: u64,
}

impl<'a> DumpHead<'a> {
    fn read(lines: &mut Lines<'a>) -> Result<Self, ReadError> {
        let (mut step, mut time, mut count, mut cell) = (None, None, None, None);
        loop {
            let (line, text) = expect(lines, "an item such as 'ITEM: TIMESTEP' or 'ITEM: ATOMS'")?;
            let Some(item) = text.strip_prefix(ITEM).map(<[u8]>::trim_ascii) else {
                return broken(line, format!("expected a line 'ITEM: …', found '{}'", excerpt::field(text)));
            };
            let value = |lines: &mut Lines<'a>, what: &str| expect(lines, what);
            if item == b"UNITS" {
                value(lines, "the units")?;
            } else if item == b"TIME" {
                let (line, text) = value(lines, "the time")?;
                time = Some(number(line, text, "the time")?);
            } else if item == b"TIMESTEP" {
                let (line, text) = value(lines, "the time step")?;
                let Some(found) = whole(text) else {
                    return broken(
                        line,
                        format!("the time step '{}' is not a whole number", excerpt::field(text)),
                    );
                };
                step = Some(found);
            } else if item == b"NUMBER OF ATOMS" {
                let (line, text) = value(lines, "the number of atoms")?;
                let Some(found) = whole(text) else {
                    return broken(
                        line,
                        format!("the number of atoms '{}' is not a whole number", excerpt::field(text)),
                    );
                };
                count = Some(found);
            } else if let Some(kinds) = item.strip_prefix(b"BOX BOUNDS") {
                cell = Some(bounds(lines, line, kinds)?);
            } else if let Some(columns) = item.strip_prefix(b"ATOMS") {
                let (Some(step), Some(count)) = (step, count) else {
                    let missing = if step.is_none() { "TIMESTEP" } else { "NUMBER OF ATOMS" };
                    return broken(line, format!("ITEM: ATOMS comes before ITEM: {missing}"));
                };
                return Ok(Self { step, time, count, cell, columns: columns.trim_ascii(), line });
            } else if item == b"NUMBER OF ENTRIES" {
                let problem = "this is a 'dump local' of pairs or bonds: give a dump of the atoms, and this file with \
                               --couples";
                return broken(line, problem);
            } else {
                let item = excerpt::field(item);
                return broken(
                    line,
                    format!("ITEM: {item} is not read: dumps of atoms are, with ITEM: ATOMS"),
                );
            }
        }
    }
}

/// The box, given after its line in any of its three forms.
pub(super) fn bounds(lines: &mut Lines<'_>, line: u64, kinds: &[u8]) -> Result<SimulationBox, ReadError> {
    let kinds: Vec<&[u8]> = words(kinds).take(7).collect();
    let (form, flags) = match kinds[..] {
        [b"xy", b"xz", b"yz", ref flags @ ..] => (Form::Tilted, flags),
        [b"abc", b"origin", ref flags @ ..] => (Form::Edges, flags),
        ref flags => (Form::Straight, flags),
    };
    let mut repeats = [false; 3];
    match flags.len() {
        // Old dumps do not say which edges are periodic.
        0 => {}
        3 => {
            for (repeat, flag) in repeats.iter_mut().zip(flags) {
                let known = flag.len() == 2 && flag.iter().all(|letter| b"pfsm".contains(letter));
                *repeat = *flag == b"pp";
                if !known || (flag.contains(&b'p') && !*repeat) {
                    let flag = excerpt::field(flag);
                    return broken(
                        line,
                        format!("'{flag}' is no kind of boundary: expected two letters such as pp, ff or fs"),
                    );
                }
            }
        }
        _ => return broken(line, "expected three kinds of boundaries such as 'pp pp ff'"),
    }
    let mut rows = [[0.0; 4]; 3];
    for row in &mut rows {
        match form {
            Form::Straight => {
                let (line, text) = expect(lines, "the two limits of the box along an axis")?;
                row[..2].copy_from_slice(&numbers::<2>(line, text, "two limits of the box along an axis")?);
                ascend(line, row[0], row[1])?;
            }
            Form::Tilted => {
                let (line, text) = expect(lines, "two limits of the box and a tilt")?;
                row[..3].copy_from_slice(&numbers::<3>(line, text, "two limits of the box and a tilt")?);
                ascend(line, row[0], row[1])?;
            }
            Form::Edges => {
                let (line, text) = expect(lines, "an edge of the box and its origin")?;
                *row = numbers::<4>(line, text, "an edge of the box, three numbers, and its origin")?;
            }
        }
    }
    let [a, b, c] = rows;
    let cell = match form {
        Form::Straight => SimulationBox::orthogonal([a[0], b[0], c[0]], [a[1], b[1], c[1]], repeats),
        Form::Tilted => {
            let [xy, xz, yz] = [a[2], b[2], c[2]];
            let low = [xy, xz, xy + xz].into_iter().fold(0.0, f64::min);
            let high = [xy, xz, xy + xz].into_iter().fold(0.0, f64::max);
            let low = [a[0] - low, b[0] - yz.min(0.0), c[0]];
            let high = [a[1] - high, b[1] - yz.max(0.0), c[1]];
            ascend(line, low[0], high[0])?;
            ascend(line, low[1], high[1])?;
            tilted(low, high, [xy, xz, yz], repeats)
        }
        Form::Edges => SimulationBox {
            origin: [a[3], b[3], c[3]],
            edges: [a, b, c].map(|[x, y, z, _]| [x, y, z]),
            repeats,
        },
    };
    if cell.is_finite() { Ok(cell) } else { broken(line, "the box is too large for 64-bit floats") }
}

#[derive(Clone, Copy)]
enum Form {
    Straight,
    Tilted,
    Edges,
}

/// A box whose second edge has the component `xy` along x, and whose third edge has `xz` along x and `yz`
/// along y.
pub(super) fn tilted(
    low: [f64; 3],
    high: [f64; 3],
    [xy, xz, yz]: [f64; 3],
    repeats: [bool; 3],
) -> SimulationBox {
    let mut cell = SimulationBox::orthogonal(low, high, repeats);
    cell.edges[1][0] = xy;
    cell.edges[2][0] = xz;
    cell.edges[2][1] = yz;
    cell
}

pub(super) fn ascend(line: u64, low: f64, high: f64) -> Result<(), ReadError> {
    if low <= high {
        Ok(())
    } else {
        broken(line, format!("the limits of the box do not ascend: {low} and {high}"))
    }
}

/// The names of the columns; one of the four kinds of coordinates is chosen for each axis.
fn names(fields: &[&[u8]]) -> Vec<Name> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let has = |axis: &str, kind: &str| fields.contains(&[axis, kind].concat().as_bytes());
    // One kind for all axes that the dump has in any kind, or else the first kind of each axis.
    let given = |axis: &&str| KINDS.iter().any(|kind| has(axis, kind));
    let complete =
        KINDS.into_iter().find(|kind| AXES.iter().filter(|axis| given(axis)).all(|axis| has(axis, kind)));
    let chosen = AXES.map(|axis| {
        let kind = complete.or_else(|| KINDS.into_iter().find(|kind| has(axis, kind)));
        kind.map(|kind| [axis, kind].concat())
    });
    let name = |field: &&[u8]| {
        let text = String::from_utf8_lossy(field);
        let mut name = Name::unsuffixed(&text);
        let axis = AXES.into_iter().zip(&chosen).find(|(_, chosen)| chosen.as_deref() == Some(&text));
        let axis = axis.map(|(axis, _)| axis);
        match (axis, name.role()) {
            (Some(axis), _) => axis.clone_into(&mut name.plain),
            // `c_x` is a compute named `x`.
            (None, Some(Role::X | Role::Y | Role::Z)) => name.plain = format!("column {text}"),
            _ => {}
        }
        name
    };
    fields.iter().map(name).collect()
}

/// Which axes are given as fractions of the box.
fn scaled(names: &[Name], roles: &[Option<Role>]) -> [bool; 3] {
    [Role::X, Role::Y, Role::Z].map(|role| {
        let at = roles.iter().position(|found| *found == Some(role));
        at.is_some_and(|at| matches!(names[at].written.as_str(), "xs" | "ys" | "zs" | "xsu" | "ysu" | "zsu"))
    })
}

/// Converts fractions of the box into coordinates.
fn unscale(centres: &mut Centres, cell: &SimulationBox, scaled: [bool; 3]) -> Result<(), String> {
    match centres {
        Centres::Two(centres) => unscale_in(centres, cell, scaled),
        Centres::Three(centres) => unscale_in(centres, cell, scaled),
    }
}

fn unscale_in<const D: usize>(
    centres: &mut [[f64; D]],
    cell: &SimulationBox,
    scaled: [bool; 3],
) -> Result<(), String> {
    if !scaled.contains(&true) {
        return Ok(());
    }
    let straight = (0..3).all(|edge| (0..3).all(|axis| edge == axis || cell.edges[edge][axis] == 0.0));
    if !straight && (!scaled[..D].iter().all(|scaled| *scaled) || D < 3) {
        return Err("coordinates in a sheared box are scaled along all three axes or along none".into());
    }
    for centre in centres {
        let fractions = *centre;
        for axis in (0..D).filter(|&axis| scaled[axis]) {
            let edges = cell.edges.iter().take(D).zip(fractions);
            centre[axis] = edges.fold(cell.origin[axis], |sum, (edge, fraction)| {
                if edge[axis] == 0.0 { sum } else { sum + fraction * edge[axis] }
            });
            if !centre[axis].is_finite() {
                return Err(format!("the scaled coordinate {} is too large for its box", fractions[axis]));
            }
        }
    }
    Ok(())
}
