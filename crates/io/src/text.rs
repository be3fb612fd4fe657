//! Reads packings from delimited text.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::columns::{Columns, MOST_COLUMNS, Name, Role};
use crate::elements::Elements;
use crate::error::ReadError;
use crate::excerpt;
use crate::foreign::BYTE_ORDER_MARK;
use crate::lines::Lines;
use crate::mesh::cursor::words;
use crate::options::ReadOptions;
use crate::packing::{BadLine, Column, Delimiter, Format, Frame, Packing, SimulationBox, Source};
use crate::row::{RowReader, TORN, content, is_torn, slip, split, text};
use crate::table::UnassignedColumns;

/// Number of lines between two reports of progress: some microseconds of work.
const LINES_PER_REPORT: u64 = 1024;

/// Most bytes of a line before the first row: names of columns take less, and a file without line ends would
/// be copied several times.
const LONGEST: usize = 1 << 20;

/// Number of bytes at the start that show the kind of the file.
const HEAD: usize = 4096;
/// Up to this number, control characters are accidental. If there are more, and more than a tenth of the
/// start, the file is not text.
const STRAY: usize = 8;

pub(crate) fn read_text(
    bytes: &[u8],
    options: &ReadOptions,
    progress: &AtomicU64,
) -> Result<Packing, ReadError> {
    check_text(bytes)?;
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let (opening, mut lines) = Opening::read(bytes, options)?;

    // A row takes at least two bytes per column. A file of blank lines cannot inflate this bound.
    let rows = memchr::memchr_iter(b'\n', lines.rest()).count() + 1;
    let rows = rows.min(lines.rest().len() / (2 * opening.roles.len().max(1)) + 1);
    let mut elements = Elements::new(&opening.roles, rows)?;
    let mut cell = opening.cell;
    while let Some((number, line)) = lines.next() {
        if number % LINES_PER_REPORT == 0 {
            progress.store(lines.at as u64, Ordering::Relaxed);
        }
        let row = match opening.rows.read_clean(line) {
            Some(row) => Ok(Some(row)),
            None => opening.rows.read(line),
        };
        match row {
            Ok(Some(row)) => elements.push(&row, number),
            Ok(None) => cell = periodic(number, line)?.or(cell),
            Err(problem) => {
                let bad = BadLine { line: number, text: excerpt::line(line), problem };
                elements.bad_line(bad, options.skip_bad_lines)?;
            }
        }
    }
    elements.check(true)?;
    let packing = elements.into_packing(Frame::default(), |skipped| Source {
        format: Format::Text { delimiter: opening.delimiter },
        columns: opening.columns,
        unit: opening.unit,
        lines: lines.number,
        skipped,
    });
    Ok(Packing { cell, ..packing })
}

/// The periodic box in a comment `##PERIODIC:: X Y Z` with its edges, which YADE and Woo write and read back;
/// its corner is the origin. `None` for other lines.
fn periodic(number: u64, line: &[u8]) -> Result<Option<SimulationBox>, ReadError> {
    let Some(rest) = line.trim_ascii_start().strip_prefix(b"##PERIODIC::") else { return Ok(None) };
    let edge = |word| fast_float2::parse(word).ok().filter(|edge: &f64| edge.is_finite() && *edge > 0.0);
    let edges: Option<Vec<f64>> = words(rest).take(4).map(edge).collect();
    let Some(&[x, y, z]) = edges.as_deref() else {
        let problem = "expected three edges of a periodic box, all above 0, after ##PERIODIC::".to_owned();
        return Err(ReadError::Malformed { line: number, text: excerpt::line(line), problem });
    };
    Ok(Some(SimulationBox::orthogonal([0.0; 3], [x, y, z], [true; 3])))
}

/// Refuses bytes that do not occur in text files.
pub(crate) fn check_text(bytes: &[u8]) -> Result<(), ReadError> {
    let not_text = |offset: usize, found: String, advice: &'static str| ReadError::NotText {
        line: memchr::memchr_iter(b'\n', &bytes[..offset]).count() as u64 + 1,
        offset: offset as u64,
        found,
        advice,
    };
    let checked = std::str::from_utf8(bytes);
    let valid = checked.map_or_else(|error| error.valid_up_to(), str::len);
    if let Some(offset) = memchr::memchr(0, &bytes[..valid]) {
        return Err(not_text(offset, "a NUL byte".into(), ""));
    }
    if valid < bytes.len() {
        // Latin-1 text has no NUL; other formats do.
        let is_text = memchr::memchr(0, &bytes[valid..]).is_none();
        let advice = if is_text { ": if it is text in another encoding, save it as UTF-8" } else { "" };
        return Err(not_text(valid, format!("0x{:02X}, which is not UTF-8,", bytes[valid]), advice));
    }
    let head = &bytes[..bytes.len().min(HEAD)];
    let control = |byte: &u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    let controls = head.iter().filter(|byte| control(byte)).count();
    if controls > STRAY.max(head.len() / 10) {
        let offset = head.iter().position(control).unwrap_or(0);
        return Err(not_text(
            offset,
            format!("{controls} control characters in {} bytes, the first", head.len()),
            "",
        ));
    }
    // A carriage return without a line feed ends a line of an old Mac, or is an accident.
    let lone = |at: &usize| bytes.get(at + 1).is_some_and(|next| !b"\r\n".contains(next));
    let lone = memchr::memchr_iter(b'\r', bytes.trim_ascii()).filter(lone).count();
    if lone > 0 && lone > memchr::memchr_iter(b'\n', bytes).count() {
        return Err(ReadError::Foreign {
            format: "text with lone carriage returns as line ends",
            advice: "convert the line ends to LF or CRLF",
        });
    }
    Ok(())
}

/// Properties of a file that the lines up to the first row show.
#[derive(Debug)]
struct Opening {
    delimiter: Delimiter,
    roles: Vec<Option<Role>>,
    columns: Vec<Column>,
    unit: Option<String>,
    cell: Option<SimulationBox>,
    rows: RowReader,
}

impl Opening {
    /// Reads up to the first row, and returns the lines from there on.
    fn read<'a>(bytes: &'a [u8], options: &ReadOptions) -> Result<(Self, Lines<'a>), ReadError> {
        let mut lines = Lines::new(bytes);
        let (mut comment, mut format, mut cell) = (None, None, None);
        let mut separated = None;
        let (mut rows, number, first) = loop {
            let before = lines.clone();
            let Some((number, line)) = lines.next() else {
                return Err(ReadError::NoRows { lines: lines.number });
            };
            let malformed = |problem: String| {
                Err(ReadError::Malformed { line: number, text: excerpt::line(line), problem })
            };
            if is_torn(line) {
                return malformed(TORN.into());
            }
            let trimmed = content(line);
            if number == 1
                && let Some(separator) = separator_line(trimmed)
            {
                match separator {
                    Ok(delimiter) => separated = delimiter,
                    Err(problem) => return malformed(problem),
                }
                continue;
            }
            if !trimmed.is_empty() {
                break (before, number, trimmed);
            }
            let comments = line.trim_ascii_start();
            if comments.len() > LONGEST {
                continue;
            }
            if let Some(found) = periodic(number, comments)? {
                cell = Some(found);
            } else if comments.starts_with(b"#") || comments.starts_with(b"%") {
                let text = without_marks(comments);
                comment = Some((number, text));
                format = format.or_else(|| Some((number, text.trim_ascii().strip_prefix(b"format ")?)));
            }
        };
        let mut delimiter = separated.unwrap_or_else(|| delimiter_of(first));
        let fields = split(first, delimiter);
        if fields.len() > MOST_COLUMNS {
            return Err(ReadError::TooManyColumns { line: Some(number) });
        }
        if first.len() > LONGEST {
            let problem =
                format!("the line has {} bytes: expected names of columns, or numbers", first.len());
            return Err(ReadError::Malformed { line: number, text: excerpt::line(first), problem });
        }
        let choice = options.columns.as_ref();
        let mut shown = first;
        let (names, header, line) = if is_header(&fields, delimiter, choice) {
            rows = lines.clone();
            let row = lines.next_content();
            let (names, chosen) = header_names(first, delimiter, row.map(|(_, row)| row));
            delimiter = chosen;
            match row.map(|row| (row, split(row.1, delimiter).len())) {
                // A header with blanks in its names does not give the number of columns; a choice by place
                // needs no names.
                Some((row, columns)) if columns != names.len() && choice.is_some_and(Columns::by_number) => {
                    shown = row.1;
                    (numbered(columns), false, row.0)
                }
                _ => (names, true, number),
            }
        } else if let Some((names, line)) = yade_names(format, fields.len(), choice)
            .or_else(|| comment_names(comment, delimiter, fields.len(), choice))
        {
            (names, true, line)
        } else {
            if choice.is_none()
                && let Some((field, slip)) =
                    fields.iter().find_map(|field| Some((field, slip(field, delimiter)?)))
            {
                let problem = format!("'{}' {slip}", excerpt::field(field));
                return Err(ReadError::Malformed { line: number, text: excerpt::line(first), problem });
            }
            (numbered(fields.len()), false, number)
        };

        let table = UnassignedColumns { names: &names, header, line: Some(line), row: &excerpt::line(shown) };
        let roles = table.all_roles(options)?;
        let unit = table.unit(&roles)?;
        let label = |(name, role): (&Name, &Option<Role>)| match role {
            // Only a header or a choice can name the columns of bodies and types.
            Some(role) if !header && !matches!(role, Role::Body | Role::Type) => role.to_string(),
            _ => name.shown(),
        };
        let labels = names.iter().zip(&roles).map(label).collect();
        let columns = Column::all(&names, &roles, header);
        let rows_from = rows;
        let rows = RowReader::new(delimiter, &roles, labels);
        Ok((Self { delimiter, roles, columns, unit, cell, rows }, rows_from))
    }
}

/// Columns without names are named by their numbers, counted from 1.
fn numbered(columns: usize) -> Vec<Name> {
    (1..=columns).map(|place| Name::new(&place.to_string())).collect()
}

/// The delimiter stated by a first line such as `sep=;`, which Excel accepts and some programs write. `None`
/// for any other line; no delimiter if nothing follows.
fn separator_line(line: &[u8]) -> Option<Result<Option<Delimiter>, String>> {
    let line = line.strip_prefix(b"\"").map_or(line, |inside| inside.strip_suffix(b"\"").unwrap_or(inside));
    let (key, separator) = line.split_at_checked(4)?;
    if !key.eq_ignore_ascii_case(b"sep=") {
        return None;
    }
    let separator = text(separator);
    let mut characters = separator.chars();
    let first = characters.next();
    characters.next().is_none().then(|| match first {
        None => Ok(None),
        Some(',') => Ok(Some(Delimiter::Comma)),
        Some(';') => Ok(Some(Delimiter::Semicolon)),
        Some('\t') => Ok(Some(Delimiter::Tab)),
        Some(' ') => Ok(Some(Delimiter::Blank)),
        Some(_) => Err("this separator is not read: use commas, semicolons, tabs or blanks".into()),
    })
}

/// A semicolon if there is one, because `0,5;0,2` is not a pair of columns; otherwise a comma.
fn delimiter_of(line: &[u8]) -> Delimiter {
    let mut quoted = false;
    let mut found = Delimiter::Blank;
    for byte in line {
        quoted ^= *byte == b'"';
        match byte {
            b';' if !quoted => return Delimiter::Semicolon,
            b',' if !quoted => found = Delimiter::Comma,
            _ => {}
        }
    }
    found
}

/// Whether the first line names the columns, rather than being a row with a typing error.
fn is_header(fields: &[&[u8]], delimiter: Delimiter, choice: Option<&Columns>) -> bool {
    if let Some(columns) = choice.filter(|columns| columns.by_number()) {
        let mut chosen = fields.iter().enumerate().filter(|(place, _)| columns.takes(*place)).peekable();
        return chosen.peek().is_some() && !chosen.any(|(_, field)| looks_numeric(field));
    }
    if !fields.iter().any(|field| looks_numeric(field)) {
        return true;
    }
    fits(&names_of(fields, delimiter), choice)
}

/// Whether these names include every required column.
fn fits(names: &[Name], choice: Option<&Columns>) -> bool {
    match choice {
        Some(columns) if !columns.by_number() => {
            UnassignedColumns { names, header: true, line: None, row: "" }.roles(choice).is_ok()
        }
        _ => {
            [Role::X, Role::Y].iter().all(|role| names.iter().any(|name| name.role().as_ref() == Some(role)))
        }
    }
}

/// Whether a field is a number or was probably meant as one: `0,5`, `1.2.3`, `nan`, `0.5O`.
fn looks_numeric(field: &[u8]) -> bool {
    let digits = field.trim_ascii_start().iter().find(|byte| !b"+-.,".contains(byte));
    digits.is_some_and(u8::is_ascii_digit) || fast_float2::parse::<f64, _>(field).is_ok()
}

/// The names in a header line, and the delimiter with which their number agrees with the row below.
///
/// Names that contain blanks may be separated by tabs, and some programs write the header with other
/// delimiters than the rows. If single tabs separate both, only tabs are delimiters, so that an empty cell
/// between two tabs is kept.
fn header_names(line: &[u8], delimiter: Delimiter, row: Option<&[u8]>) -> (Vec<Name>, Delimiter) {
    let names = names_of(&split(line, delimiter), delimiter);
    let columns = |delimiter| row.map_or(names.len(), |row| split(row, delimiter).len());
    let by_tab = split(line, Delimiter::Tab);
    if delimiter == Delimiter::Blank && by_tab.len() > 1 && by_tab.len() == columns(Delimiter::Tab) {
        return (names_of(&by_tab, Delimiter::Tab), Delimiter::Tab);
    }
    if columns(delimiter) == names.len() {
        return (names, delimiter);
    }
    let others = [Delimiter::Semicolon, Delimiter::Comma, Delimiter::Blank];
    let agrees = others.into_iter().find(|other| columns(*other) == names.len());
    (names, agrees.unwrap_or(delimiter))
}

/// A comment without its leading marks.
fn without_marks(comment: &[u8]) -> &[u8] {
    let marks = comment.iter().take_while(|byte| b"#%".contains(byte)).count();
    &comment[marks..]
}

/// The names in a comment just above the first row, if their number fits.
fn comment_names(
    comment: Option<(u64, &[u8])>,
    delimiter: Delimiter,
    columns: usize,
    choice: Option<&Columns>,
) -> Option<(Vec<Name>, u64)> {
    let (number, line) = comment?;
    let line = line.trim_ascii_start();
    [delimiter, delimiter_of(line)].into_iter().find_map(|delimiter| {
        let names = names_of(&split(line, delimiter), delimiter);
        (names.len() == columns && fits(&names, choice)).then_some((names, number))
    })
}

/// The names after `#format` of YADE: `x_y_z_r_matId`. A last name `attrs` may stand for several columns.
fn yade_names(
    format: Option<(u64, &[u8])>,
    columns: usize,
    choice: Option<&Columns>,
) -> Option<(Vec<Name>, u64)> {
    let (number, line) = format?;
    let line = text(line.trim_ascii());
    let mut names: Vec<Name> = line.split('_').take(MOST_COLUMNS).map(Name::unsuffixed).collect();
    if names.last().is_some_and(|name| name.plain == "attrs") {
        names.resize_with(columns.max(names.len()), || Name::unsuffixed("attrs"));
    }
    (names.len() == columns && fits(&names, choice)).then_some((names, number))
}

/// In a line separated by blanks, a field that starts with a bracket belongs to the name before it, up to the
/// closing bracket.
fn names_of(fields: &[&[u8]], delimiter: Delimiter) -> Vec<Name> {
    let mut names: Vec<String> = Vec::new();
    let mut open = false;
    for field in fields {
        let field = text(field);
        let joins = delimiter == Delimiter::Blank && (open || field.starts_with(['(', '[']));
        match names.last_mut() {
            Some(name) if joins => {
                name.push(' ');
                name.push_str(&field);
            }
            _ => names.push(field.clone().into_owned()),
        }
        let bracket = field.rfind(['(', '[', ')', ']']).map(|at| field.as_bytes()[at]);
        open = bracket.map_or(open, |bracket| matches!(bracket, b'(' | b'['));
    }
    Name::all(names.iter().map(String::as_str))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(line: &str) -> Vec<String> {
        names_of(&split(line.as_bytes(), Delimiter::Blank), Delimiter::Blank)
            .into_iter()
            .map(|name| name.written)
            .collect()
    }

    #[test]
    fn brackets_join_the_name_before_them() {
        assert_eq!(names("Radius[m]\tPosX[m] PosY[m]"), ["Radius[m]", "PosX[m]", "PosY[m]"]);
        assert_eq!(names("X (mm) Y ( mm ) r"), ["X (mm)", "Y ( mm )", "r"]);
        assert_eq!(names("(a) b"), ["(a)", "b"]);
    }

    #[test]
    fn a_row_with_a_slip_is_no_header() {
        let header =
            |line: &str| is_header(&split(line.as_bytes(), Delimiter::Blank), Delimiter::Blank, None);
        assert!(header("x y z"));
        assert!(header("a b c"));
        assert!(header("x y 2ndradius"));
        for row in ["1 2 3", "1 2 O.5", "1 2 0.5O", "0,5 0,2", "nan nan nan", "-1 a b", "glass 1 2"] {
            assert!(!header(row), "{row}");
        }
    }

    #[test]
    fn chosen_places_decide_what_a_header_is() {
        let header = |line: &str, choice: &str| {
            is_header(
                &split(line.as_bytes(), Delimiter::Blank),
                Delimiter::Blank,
                choice.parse().ok().as_ref(),
            )
        };
        assert!(!header("glass 1 2", "_,x,y"), "text in a column that is skipped");
        assert!(header("1st a b", "_,x,y"));
        assert!(!header("1 2", "x=PosX,y=PosY"), "rows without names");
        assert!(header("1 PosX PosY", "x=PosX,y=PosY"));
    }
}
