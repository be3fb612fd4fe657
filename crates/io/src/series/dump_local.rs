//! Couples with their values in `dump local` files of LAMMPS and LIGGGHTS.

use std::str::FromStr;

use crate::columns::MOST_COLUMNS;
use crate::error::ReadError;
use crate::excerpt;
use crate::foreign::BYTE_ORDER_MARK;
use crate::lines::{Lines, Start};
use crate::mesh::cursor::words;
use crate::series::dump::{self, ITEM};
use crate::series::rows::{broken, expect, number, whole};
use crate::text::check_text;

/// Names of columns for the ids of the two elements of a couple, without capitals.
const ENDS: [[&str; 5]; 2] =
    [["i", "id1", "patom1", "batom1", "atom1"], ["j", "id2", "patom2", "batom2", "atom2"]];

/// Names that files of couples and elements give to their own columns.
const OWN: [&str; 22] = [
    "distance",
    "overlap",
    "sx",
    "sy",
    "sz",
    "shift",
    "frame",
    "step",
    "ends",
    "connectivity",
    "offsets",
    "positions",
    "radii",
    "ids",
    "edges",
    "origin",
    "periodic",
    "source",
    "target",
    "key",
    "image",
    "id",
];

/// Names of the columns of a file of couples, in place of those of the file.
///
/// There are two notations:
/// - by place, `i,j,_,fx,fy,fz`: one name for every column; `_` or `-` skips a column;
/// - by name, `i=c_id[1],j=c_id[2],fx=3`: the name of a column in the file, or its number counted from 1. The
///   other columns keep their names.
///
/// `i` and `j` are the ids of the elements, `fx`, `fy` and `fz` the force on `i` by `j`, `force` its part
/// along the line between the centres, positive if the elements repel each other. Other names are free.
///
/// # Example
/// ```
/// use fdem_io::CoupleColumns;
///
/// assert!("i,j,_,fx,fy,fz".parse::<CoupleColumns>().is_ok());
/// assert!("i=c_id[1],j=c_id[2]".parse::<CoupleColumns>().is_ok());
/// assert!("i,fx,fx".parse::<CoupleColumns>().unwrap_err().contains("fx is given twice"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoupleColumns(ColumnNaming);

#[derive(Debug, Clone, PartialEq, Eq)]
enum ColumnNaming {
    /// For each column a name, or none to skip it.
    Places(Vec<Option<String>>),
    /// New names, each with the name or number of its column.
    Names(Vec<(String, String)>),
}

impl FromStr for CoupleColumns {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let entries = || text.split(',').map(str::trim);
        let by_name = entries().next().is_some_and(|entry| entry.contains('='));
        let (mut places, mut names) = (Vec::new(), Vec::new());
        let mut given: Vec<&str> = Vec::new();
        for entry in entries() {
            let name = match entry.split_once('=').map(|(name, column)| (name.trim(), column.trim())) {
                Some((name, column)) if by_name => {
                    if column.is_empty() {
                        return Err(format!(
                            "'{entry}' names no column: expected {name}=NAME or {name}=NUMBER"
                        ));
                    }
                    if names.iter().any(|(_, earlier)| earlier == column) {
                        return Err(format!("column '{column}' is given twice"));
                    }
                    names.push((name.to_owned(), column.to_owned()));
                    name
                }
                None if !by_name => {
                    let skips = matches!(entry, "_" | "-");
                    places.push((!skips).then(|| entry.to_owned()));
                    if skips {
                        continue;
                    }
                    entry
                }
                _ => {
                    return Err(format!(
                        "'{entry}' does not fit the entries before it: use either i,j,... or i=NAME,j=NAME,..."
                    ));
                }
            };
            if name.is_empty() {
                return Err(format!("an entry of '{text}' is empty: _ skips a column"));
            }
            if given.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            given.push(name);
        }
        Ok(Self(if by_name { ColumnNaming::Names(names) } else { ColumnNaming::Places(places) }))
    }
}

/// Couples of a file, with their values, in the order of the file.
///
/// # Shapes
/// `ids`, `lines` and the values of each column: one for each couple.
///
/// # Units
/// The units of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileCouples {
    /// The number of the time step.
    pub step: i64,
    /// The ids of the two elements.
    pub ids: Vec<[i64; 2]>,
    /// The line of each couple in the file, counted from 1.
    pub lines: Vec<u64>,
    /// The other columns, with their names and finite values.
    pub columns: Vec<(String, Vec<f64>)>,
    /// The line with the names of the columns.
    pub header: u64,
}

/// Reads the couples of a time step from a `dump local` of LAMMPS or LIGGGHTS.
///
/// Columns named `i`, `id1`, `patom1`, `batom1` or `atom1`, and `j`, `id2`, `patom2`, `batom2` or `atom2`,
/// are the ids of the elements, unless `columns` gives other names. Without `step` the file must have one
/// time step.
///
/// # Errors
/// [`ReadError`]: bytes of another format, a damaged frame, no frame of this time step, ids whose columns are
/// not named, ids that are not whole numbers, values that are not finite.
///
/// # Cost
/// Time proportional to the bytes of the file. Memory: that of the couples.
///
/// # Source
/// LAMMPS documentation of `dump local`, `compute property/local`, `compute pair/local`.
///
/// # Example
/// ```
/// let text = b"ITEM: TIMESTEP\n7\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
///              ITEM: ENTRIES patom1 patom2 c_f[1]\n4 2 0.5\n";
/// let couples = fdem_io::read_couples(text, Some(&"i=1,j=2,force=3".parse().unwrap()), None)?;
/// assert_eq!((couples.step, &couples.ids), (7, &vec![[4, 2]]));
/// assert_eq!(couples.columns, [("force".to_owned(), vec![0.5])]);
/// # Ok::<(), fdem_io::ReadError>(())
/// ```
pub fn read_couples(
    bytes: &[u8],
    columns: Option<&CoupleColumns>,
    step: Option<i64>,
) -> Result<FileCouples, ReadError> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    if !dump::is(bytes) {
        return broken(
            1,
            "couples are read from a 'dump local' of LAMMPS or LIGGGHTS, which begins with 'ITEM:'",
        );
    }
    check_text(bytes)?;
    let mut lines = Lines::new(bytes);
    let mut found: Option<(Head<'_>, Start)> = None;
    let mut steps = Vec::new();
    while lines.more() {
        let head = Head::read(&mut lines)?;
        if step.is_none_or(|step| step == head.step) {
            if let Some((earlier, _)) = &found {
                let problem = match step {
                    Some(step) => format!("the time step {step} begins again, first on line {}", earlier.line),
                    None => "a second time step begins here, and the packing has none: give a file of one time step"
                        .to_owned(),
                };
                return broken(head.line, problem);
            }
            found = Some((head, lines.start()));
        }
        steps.push((head.step, head.step_line));
        for done in 0..head.count {
            if lines.next().is_none() {
                let rows = excerpt::count(head.count as u64, "row");
                return broken(lines.number, format!("the file ends after {done} of {rows}"));
            }
        }
    }
    match (found, step) {
        (Some((head, start)), _) => head.rows(Lines::of_frame(bytes, start), columns),
        (None, Some(step)) => {
            let line = steps.first().map_or(1, |(_, line)| *line);
            let shown: Vec<_> = steps.iter().take(5).map(|(step, _)| step.to_string()).collect();
            let more = if steps.len() > shown.len() { ", …" } else { "" };
            let shown = shown.join(", ");
            broken(
                line,
                format!("the packing is of the time step {step}, these couples are of {shown}{more}"),
            )
        }
        (None, None) => broken(lines.number, "there are no couples: expected 'ITEM: TIMESTEP'"),
    }
}

/// The lines before the rows of a frame.
#[derive(Clone, Copy)]
struct Head<'a> {
    step: i64,
    /// The line of the time step.
    step_line: u64,
    count: usize,
    /// The line with the names of the columns; below, its number.
    columns: &'a [u8],
    line: u64,
}

impl<'a> Head<'a> {
    fn read(lines: &mut Lines<'a>) -> Result<Self, ReadError> {
        let (mut step, mut count) = (None, None);
        loop {
            let (line, text) = expect(lines, "an item such as 'ITEM: TIMESTEP' or 'ITEM: ENTRIES'")?;
            let Some(item) = text.strip_prefix(ITEM).map(<[u8]>::trim_ascii) else {
                let found = excerpt::field(text);
                return broken(
                    line,
                    format!(
                        "expected a line 'ITEM: …', found '{found}': are there more rows than the file says?"
                    ),
                );
            };
            if item == b"UNITS" || item == b"TIME" {
                expect(lines, "a line after this item")?;
            } else if item == b"TIMESTEP" {
                step = Some((count_below(lines, "the time step")?, lines.number));
            } else if item == b"NUMBER OF ATOMS" {
                let problem = "this is a dump of atoms, not of couples: couples are in a 'dump local'";
                return broken(line, problem);
            } else if let Some(label) = item.strip_prefix(b"NUMBER OF ") {
                count = Some((label.trim_ascii(), count_below(lines, "the number of entries")?));
            } else if let Some(kinds) = item.strip_prefix(b"BOX BOUNDS") {
                dump::bounds(lines, line, kinds)?;
            } else {
                // `dump_modify label` gives the entries another name.
                let columns = count.and_then(|(label, count)| Some((item.strip_prefix(label)?, count)));
                return match (columns, step) {
                    (Some((columns, count)), Some((step, step_line))) => {
                        Ok(Self { step, step_line, count, columns: columns.trim_ascii(), line })
                    }
                    (Some(_), None) => broken(line, "the entries come before ITEM: TIMESTEP"),
                    (None, _) => {
                        let item = excerpt::field(item);
                        broken(
                            line,
                            format!("ITEM: {item} is not read, or comes before the number of entries"),
                        )
                    }
                };
            }
        }
    }

    /// The names of the columns; `None` for those that are skipped.
    fn names(&self, columns: Option<&CoupleColumns>) -> Result<Vec<Option<String>>, ReadError> {
        let written: Vec<String> = words(self.columns)
            .take(MOST_COLUMNS + 1)
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect();
        if written.len() > MOST_COLUMNS {
            return Err(ReadError::TooManyColumns { line: Some(self.line) });
        }
        let shown = || excerpt::line(self.columns);
        let names: Vec<Option<String>> = match columns {
            None => written.into_iter().map(Some).collect(),
            Some(CoupleColumns(ColumnNaming::Places(places))) => {
                if places.len() != written.len() {
                    let (given, found) = (places.len(), written.len());
                    return broken(
                        self.line,
                        format!("{given} names are given for {found} columns: {}. _ skips a column", shown()),
                    );
                }
                places.clone()
            }
            Some(CoupleColumns(ColumnNaming::Names(given))) => {
                let mut names: Vec<Option<String>> = written.iter().cloned().map(Some).collect();
                for (name, column) in given {
                    let number = || column.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
                    let place = written.iter().position(|written| written == column).or_else(number);
                    let Some(slot) = place.and_then(|place| names.get_mut(place)) else {
                        return broken(self.line, format!("no column '{column}' among {}", shown()));
                    };
                    *slot = Some(name.clone());
                }
                names
            }
        };
        for (place, name) in names.iter().enumerate() {
            let Some(name) = name else { continue };
            let is_plain =
                name.bytes().all(|letter| letter.is_ascii_alphanumeric() || b"_.-[]".contains(&letter));
            let why = if names[..place].iter().flatten().any(|earlier| earlier == name) {
                "is that of two columns"
            } else if OWN.contains(&name.to_ascii_lowercase().as_str()) {
                "is that of a column of fdem"
            } else if !is_plain {
                "has letters other than A to Z, a to z, digits and _ . - [ ]"
            } else {
                continue;
            };
            let name = excerpt::field(name.as_bytes());
            return broken(self.line, format!("the name {name} {why}: give another by --couple-columns"));
        }
        Ok(names)
    }

    /// The columns of the ids of the first and of the second element.
    fn ends(&self, names: &[Option<String>]) -> Result<[usize; 2], ReadError> {
        let mut ends = [0; 2];
        for (end, known) in ends.iter_mut().zip(ENDS) {
            let is = |name: &String| known.contains(&name.to_ascii_lowercase().as_str());
            let found: Vec<usize> =
                (0..names.len()).filter(|&place| names[place].as_ref().is_some_and(is)).collect();
            let [place] = found[..] else {
                let (count, role) =
                    (if found.is_empty() { "no column" } else { "more than one column" }, known[0]);
                return broken(
                    self.line,
                    format!(
                        "{count} is named as the ids {role} among {}: name the columns by --couple-columns, such as \
                         i=NAME,j=NAME,fx=NAME,fy=NAME,fz=NAME",
                        excerpt::line(self.columns)
                    ),
                );
            };
            *end = place;
        }
        Ok(ends)
    }

    fn rows(&self, mut lines: Lines<'_>, columns: Option<&CoupleColumns>) -> Result<FileCouples, ReadError> {
        let names = self.names(columns)?;
        let ends = self.ends(&names)?;
        let mut couples = FileCouples {
            step: self.step,
            ids: Vec::new(),
            lines: Vec::new(),
            columns: Vec::new(),
            header: self.line,
        };
        let kept = |place: &usize| names[*place].is_some() && !ends.contains(place);
        let places: Vec<usize> = (0..names.len()).filter(kept).collect();
        couples.columns =
            places.iter().map(|&place| (names[place].clone().unwrap_or_default(), Vec::new())).collect();
        for (line, text) in lines.by_ref().take(self.count) {
            let fields: Vec<&[u8]> = words(text).take(names.len() + 1).collect();
            if fields.len() != names.len() {
                let (expected, text) = (excerpt::count(names.len() as u64, "column"), excerpt::line(text));
                return broken(line, format!("expected {expected}, found '{text}'"));
            }
            let mut ids = [0; 2];
            for (id, place) in ids.iter_mut().zip(ends) {
                *id = whole(fields[place]).map_or_else(|| broken(line, lost_digits(fields[place])), Ok)?;
            }
            for (place, (name, values)) in places.iter().zip(&mut couples.columns) {
                values.push(number(line, fields[*place], name)?);
            }
            couples.ids.push(ids);
            couples.lines.push(line);
        }
        Ok(couples)
    }
}

/// A whole number on the next line.
fn count_below<T: FromStr>(lines: &mut Lines<'_>, what: &str) -> Result<T, ReadError> {
    let (line, text) = expect(lines, what)?;
    let problem = || format!("{what} '{}' is not a whole number", excerpt::field(text));
    whole(text).map_or_else(|| broken(line, problem()), Ok)
}

/// The problem of an id that is not a whole number.
fn lost_digits(field: &[u8]) -> String {
    let shown = excerpt::field(field);
    let advice = if field.iter().any(|letter| b"eE".contains(letter)) {
        ". Its digits may be lost: 'dump_modify format' of LAMMPS writes all of them"
    } else {
        ""
    };
    format!("the id '{shown}' is not a whole number{advice}")
}
