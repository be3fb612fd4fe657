//! Counted rows of text whose column names are given elsewhere; fields are separated by blanks.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::columns::{MOST_COLUMNS, Name, Role};
use crate::elements::Elements;
use crate::error::ReadError;
use crate::excerpt;
use crate::lines::Lines;
use crate::mesh::cursor::words;
use crate::options::ReadOptions;
use crate::packing::{BadLine, Column, Delimiter, Format, Frame, Packing, SimulationBox, Source};
use crate::place::Place;
use crate::row::RowReader;
use crate::table::UnassignedColumns;
use crate::types::TypesOfRows;

/// Number of lines between two reports of progress.
const LINES_PER_REPORT: u64 = 1024;

/// The columns of rows whose number is known.
#[derive(Debug)]
pub(super) struct RowTable {
    pub(super) roles: Vec<Option<Role>>,
    columns: Vec<Column>,
    unit: Option<String>,
    reader: RowReader,
}

impl RowTable {
    /// Assigns roles to columns with these names. `line` is the line of the names, and messages show `shown`.
    pub(super) fn new(
        names: &[Name],
        line: u64,
        shown: &[u8],
        options: &ReadOptions,
    ) -> Result<Self, ReadError> {
        if names.len() > MOST_COLUMNS {
            return Err(ReadError::TooManyColumns { line: Some(line) });
        }
        let table = UnassignedColumns { names, header: true, line: Some(line), row: &excerpt::line(shown) };
        let roles = table.all_roles(options)?;
        let unit = table.unit(&roles)?;
        let reader = RowReader::new(Delimiter::Blank, &roles, names.iter().map(Name::shown).collect());
        Ok(Self { columns: Column::all(names, &roles, true), roles, unit, reader })
    }

    /// Reads the stated number of rows.
    pub(super) fn read(
        &self,
        lines: &mut Lines<'_>,
        count: usize,
        options: &ReadOptions,
        progress: &AtomicU64,
    ) -> Result<Elements, ReadError> {
        // A row takes at least two bytes per column, which bounds the memory whatever the count claims.
        let room = count.min(lines.rest().len() / (2 * self.roles.len().max(1)) + 1);
        let mut elements = Elements::new(&self.roles, room)?;
        for done in 0..count {
            let Some((number, line)) = lines.next() else {
                return broken(
                    lines.number,
                    format!("the file ends after {done} of {}", excerpt::count(count as u64, "row")),
                );
            };
            if number % LINES_PER_REPORT == 0 {
                progress.store(lines.at as u64, Ordering::Relaxed);
            }
            let row = match self.reader.read_clean(line) {
                Some(row) => Ok(Some(row)),
                None => self.reader.read(line),
            };
            let empty = || format!("expected row {} of {count}, found a blank line or a comment", done + 1);
            match row.and_then(|row| row.ok_or_else(empty)) {
                Ok(row) => elements.push(&row, number),
                Err(problem) => {
                    let bad = BadLine { line: number, text: excerpt::line(line), problem };
                    elements.bad_line(bad, options.skip_bad_lines)?;
                }
            }
        }
        elements.check(true)?;
        Ok(elements)
    }

    pub(super) fn packing(
        self,
        elements: Elements,
        format: Format,
        lines: u64,
        cell: Option<SimulationBox>,
        frame: Frame,
    ) -> Packing {
        Packing {
            centres: elements.centres,
            radii: elements.radii,
            ids: elements.ids,
            bodies: elements.bodies,
            types: elements.types.map(TypesOfRows::into_types),
            row_numbers: elements.row_numbers,
            cell,
            frame,
            source: Source {
                format,
                columns: self.columns,
                unit: self.unit,
                lines,
                skipped: elements.skipped,
            },
        }
    }
}

/// An error on a line.
pub(super) fn broken<T>(line: u64, problem: impl Into<String>) -> Result<T, ReadError> {
    Err(ReadError::Broken { place: Place::Line(line.max(1)), problem: problem.into() })
}

/// The next line that is not blank, or an error with the expected content.
pub(super) fn expect<'a>(lines: &mut Lines<'a>, what: &str) -> Result<(u64, &'a [u8]), ReadError> {
    match lines.next_filled() {
        Some(line) => Ok(line),
        None => broken(lines.number, format!("the file ends here: expected {what}")),
    }
}

/// Refuses anything that follows the rows of a frame.
pub(super) fn at_end(lines: &mut Lines<'_>, count: usize, expected: &str) -> Result<(), ReadError> {
    match lines.next_filled() {
        None => Ok(()),
        Some((line, text)) => broken(
            line,
            format!(
                "after {} expected {expected}, found '{}': are there more rows than the file says?",
                excerpt::count(count as u64, "row"),
                excerpt::field(text)
            ),
        ),
    }
}

/// Exactly `N` finite numbers on a line.
pub(super) fn numbers<const N: usize>(line: u64, text: &[u8], what: &str) -> Result<[f64; N], ReadError> {
    let mut found = [0.0; N];
    let mut fields = words(text);
    for value in &mut found {
        let Some(field) = fields.next() else {
            return broken(line, format!("expected {what}, found '{}'", excerpt::line(text)));
        };
        *value = number(line, field, what)?;
    }
    match fields.next() {
        Some(_) => broken(line, format!("expected {what}, found '{}'", excerpt::line(text))),
        None => Ok(found),
    }
}

/// A finite number.
pub(super) fn number(line: u64, field: &[u8], what: &str) -> Result<f64, ReadError> {
    match fast_float2::parse::<f64, _>(field) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => broken(line, format!("{what}: '{}' is not a finite number", excerpt::field(field))),
        Err(_) => broken(line, format!("{what}: cannot read '{}' as a number", excerpt::field(field))),
    }
}

/// A whole number, as text.
pub(super) fn whole<T: std::str::FromStr>(field: &[u8]) -> Option<T> {
    str::from_utf8(field).ok()?.parse().ok()
}
