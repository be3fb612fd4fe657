//! Data files of LAMMPS and LIGGGHTS, as `read_data` reads them.

use std::sync::atomic::AtomicU64;

use crate::columns::Name;
use crate::error::ReadError;
use crate::excerpt;
use crate::lines::Lines;
use crate::mesh::cursor::words;
use crate::options::ReadOptions;
use crate::packing::{Format, Frame, Packing, SimulationBox};
use crate::series::dump::{ascend, tilted};
use crate::series::rows::{RowTable, broken, number, whole};

/// Number of bytes searched for the line with the number of atoms: headers are short.
const HEAD: usize = 1 << 14;

/// The columns of the atom styles. Three image flags may follow them.
const STYLES: [(&str, &str); 24] = [
    ("angle", "id molecule type x y z"),
    ("atomic", "id type x y z"),
    ("body", "id type bodyflag mass x y z"),
    ("bond", "id molecule type x y z"),
    ("bpm/sphere", "id molecule type diameter density x y z"),
    ("charge", "id type q x y z"),
    ("dielectric", "id type q x y z mux muy muz area ed em epsilon curvature"),
    ("dipole", "id type q x y z mux muy muz"),
    ("dpd", "id type theta x y z"),
    ("edpd", "id type edpd_temp edpd_cv x y z"),
    ("electron", "id type q espin eradius x y z"),
    ("ellipsoid", "id type ellipsoidflag density x y z"),
    ("full", "id molecule type q x y z"),
    ("granular", "id type diameter density x y z"),
    ("line", "id molecule type lineflag density x y z"),
    ("mdpd", "id type rho x y z"),
    ("molecular", "id molecule type x y z"),
    ("peri", "id type volume density x y z"),
    ("rheo", "id type status rho x y z"),
    ("smd", "id type molecule volume mass kradius cradius x0 y0 z0 x y z"),
    ("sph", "id type rho esph cv x y z"),
    ("sphere", "id type diameter density x y z"),
    ("spin", "id type x y z spx spy spz sp"),
    ("tri", "id molecule type triangleflag density x y z"),
];
const IMAGES: [&str; 3] = ["nx", "ny", "nz"];

/// Whether the content is a data file: one of its first lines gives the number of atoms.
pub(crate) fn is(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.contains(&0) {
        return false;
    }
    let mut lines = head.split(|&byte| byte == b'\n').skip(1).map(bare);
    lines.any(|line| atoms(line).is_some())
}

/// A line without its comment.
fn bare(line: &[u8]) -> &[u8] {
    let end = memchr::memchr(b'#', line).unwrap_or(line.len());
    line[..end].trim_ascii()
}

/// The number in `100 atoms`.
fn atoms(line: &[u8]) -> Option<usize> {
    let mut words = words(line);
    let (count, word, end) = (words.next()?, words.next()?, words.next());
    if word == b"atoms" && end.is_none() { whole(count) } else { None }
}

pub(crate) fn read(
    mut lines: Lines<'_>,
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    let head = LammpsHead::read(&mut lines)?;
    let row = lines.clone().map(|(number, line)| (number, bare(line))).find(|(_, line)| !line.is_empty());
    // Blank lines separate the keyword from the rows.
    while lines.clone().next().is_some_and(|(_, line)| bare(line).is_empty()) && lines.more() {
        lines.next();
    }
    let columns = row.map(|(_, row)| words(row).take(crate::columns::MOST_COLUMNS + 1).count());
    let names = names(&head, columns, options)?;
    let (line, shown) = row.unwrap_or((head.line, b""));
    let table = RowTable::new(&names, line, shown, options)?;
    let elements = table.read(&mut lines, head.count, options, progress)?;
    let after = lines.clone().map(|(number, line)| (number, bare(line))).find(|(_, line)| !line.is_empty());
    if let Some((line, text)) = after.filter(|(_, text)| !text[0].is_ascii_alphabetic()) {
        let rows = excerpt::count(head.count as u64, "row");
        let text = excerpt::field(text);
        return broken(
            line,
            format!(
                "after {rows} expected another section, found '{text}': are there more rows than 'atoms' says?"
            ),
        );
    }
    // The rest is skipped, but its lines are counted.
    let count = lines.number + lines.count() as u64;
    let format = Format::LammpsData { style: head.style };
    Ok(table.packing(elements, format, count, Some(head.cell), Frame::default()))
}

/// Everything before the rows of atoms.
struct LammpsHead {
    count: usize,
    cell: SimulationBox,
    style: Option<String>,
    /// Line of `Atoms`.
    line: u64,
}

impl LammpsHead {
    fn read(lines: &mut Lines<'_>) -> Result<Self, ReadError> {
        let (mut count, mut limits, mut tilt, mut origin) = (None, [None; 3], [0.0; 3], None);
        let mut edges: [Option<[f64; 3]>; 3] = [None; 3];
        // The first line is a title, whatever it contains.
        lines.next();
        let (line, style) = loop {
            let Some((line, text)) = lines.next() else {
                return broken(lines.number, "the file ends here: expected a section 'Atoms'");
            };
            let fields: Vec<&[u8]> = words(bare(text)).take(8).collect();
            match fields[..] {
                [b"Atoms"] => break (line, style(text)),
                [found, b"atoms"] => match whole::<usize>(found) {
                    Some(found) => count = Some(found),
                    None => {
                        return broken(line, format!("'{}' is no number of atoms", excerpt::field(found)));
                    }
                },
                [low, high, first, second]
                    if limit(first, b"lo").is_some() && limit(first, b"lo") == limit(second, b"hi") =>
                {
                    let axis = limit(first, b"lo").unwrap_or(0);
                    let what = "a limit of the box";
                    let (low, high) = (number(line, low, what)?, number(line, high, what)?);
                    ascend(line, low, high)?;
                    limits[axis] = Some([low, high]);
                }
                [xy, xz, yz, b"xy", b"xz", b"yz"] => {
                    tilt = three(line, [xy, xz, yz], "a tilt of the box")?;
                }
                [x, y, z, b"avec"] => edges[0] = Some(three(line, [x, y, z], "an edge of the box")?),
                [x, y, z, b"bvec"] => edges[1] = Some(three(line, [x, y, z], "an edge of the box")?),
                [x, y, z, b"cvec"] => edges[2] = Some(three(line, [x, y, z], "an edge of the box")?),
                [x, y, z, b"abc", b"origin"] => {
                    origin = Some(three(line, [x, y, z], "the origin of the box")?);
                }
                _ => {}
            }
        };
        let Some(count) = count else {
            return broken(line, "no line such as '100 atoms' before the section 'Atoms'");
        };
        let cell = match (edges, limits) {
            ([Some(a), Some(b), Some(c)], _) => {
                SimulationBox { origin: origin.unwrap_or([0.0; 3]), edges: [a, b, c], repeats: [false; 3] }
            }
            (_, [Some(x), Some(y), Some(z)]) => {
                tilted([x[0], y[0], z[0]], [x[1], y[1], z[1]], tilt, [false; 3])
            }
            // The default of LAMMPS if no limits are given.
            (_, limits) if limits.iter().all(Option::is_none) => {
                tilted([-0.5; 3], [0.5; 3], tilt, [false; 3])
            }
            _ => return broken(line, "the box needs limits along all three axes, such as '0 10 xlo xhi'"),
        };
        if !cell.is_finite() {
            return broken(line, "the box is too large for 64-bit floats");
        }
        Ok(Self { count, cell, style, line })
    }
}

/// The axis of a word such as `xlo` or `yhi`.
fn limit(word: &[u8], end: &[u8]) -> Option<usize> {
    let (letter, rest) = word.split_first()?;
    let axis = b"xyz".iter().position(|axis| axis == letter)?;
    (rest == end).then_some(axis)
}

fn three(line: u64, fields: [&[u8]; 3], what: &str) -> Result<[f64; 3], ReadError> {
    let [x, y, z] = fields.map(|field| number(line, field, what));
    Ok([x?, y?, z?])
}

/// The comment after `Atoms`.
fn style(line: &[u8]) -> Option<String> {
    let at = memchr::memchr(b'#', line)?;
    let style = excerpt::field(&line[at + 1..]);
    (!style.is_empty()).then_some(style)
}

/// The columns of an atom style; `None` if it is not known.
///
/// `hybrid A B` has the columns of all atoms, then those that `A` and `B` add, each once.
///
/// # Source
/// LAMMPS documentation, `read_data`, "Atoms section".
fn columns_of(style: &str) -> Option<Vec<&'static str>> {
    let of = |style: &str| {
        let (_, names) = STYLES.iter().find(|(name, _)| *name == style)?;
        Some(names.split(' '))
    };
    let Some(parts) = style.strip_prefix("hybrid ") else { return of(style).map(Iterator::collect) };
    let mut names: Vec<_> = of("atomic")?.collect();
    for part in parts.split_whitespace() {
        for name in of(part)? {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    Some(names)
}

/// The columns, by the user's choice or by the style.
fn names(head: &LammpsHead, columns: Option<usize>, options: &ReadOptions) -> Result<Vec<Name>, ReadError> {
    let plain = |names: &mut dyn Iterator<Item = &str>| names.map(Name::unsuffixed).collect::<Vec<_>>();
    let known = head.style.as_deref().and_then(|style| Some((style, columns_of(style)?)));
    let Some((style, names)) = known else {
        if options.columns.is_some() {
            let numbers: Vec<String> = (1..=columns.unwrap_or(0)).map(|place| place.to_string()).collect();
            return Ok(plain(&mut numbers.iter().map(String::as_str)));
        }
        let said = match &head.style {
            Some(style) => format!("the columns of the atom style '{style}' are not known"),
            None => {
                "the meaning of the columns is not given: expected an atom style, such as in 'Atoms # sphere'"
                    .into()
            }
        };
        return broken(
            head.line,
            format!("{said}. Name them with --columns, for example --columns id,_,diameter,_,x,y,z"),
        );
    };
    let bare = names.len();
    match columns {
        Some(found) if found == bare + IMAGES.len() => Ok(plain(&mut names.into_iter().chain(IMAGES))),
        Some(found) if found != bare && options.columns.is_none() => broken(
            head.line,
            format!(
                "the atom style {style} has {bare} columns ({}), with image flags {}; the first row has {found}",
                names.join(" "),
                bare + IMAGES.len()
            ),
        ),
        Some(found) if found != bare => {
            let numbers: Vec<String> = (1..=found).map(|place| place.to_string()).collect();
            Ok(plain(&mut numbers.iter().map(String::as_str)))
        }
        _ => Ok(plain(&mut names.into_iter())),
    }
}
