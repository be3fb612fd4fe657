//! Parses one row of text: quickly if it is plain, otherwise carefully, with a message if something is wrong.

use std::borrow::Cow;
use std::fmt;

use crate::columns::{MOST_COLUMNS, Role};
use crate::excerpt;
use crate::packing::Delimiter;
use crate::types::TypeOfRow;

/// Up to this number, 2^53, every integer is an `f64`.
const WHOLE_FLOATS: f64 = 9_007_199_254_740_992.0;

/// The use of a field.
#[derive(Debug, Clone, Copy)]
enum Slot {
    Skip,
    Id,
    Body,
    Type,
    /// Index into [`Row::values`].
    Value(usize),
}

/// The values of one row.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Row<'a> {
    /// x, y, z, and radius or diameter; 0 for columns that the file does not have.
    pub(crate) values: [f64; 4],
    /// The id; 0 if the file has none.
    pub(crate) id: i64,
    /// The body; 0 if no column has bodies.
    pub(crate) body: i64,
    /// The type; any if no column has types.
    pub(crate) type_of: TypeOfRow<'a>,
}

impl Row<'_> {
    /// Sets the id, the body or the type to a whole number of an array.
    #[inline]
    pub(crate) fn set_whole(&mut self, role: Role, number: i64) {
        match role {
            Role::Id => self.id = number,
            Role::Body => self.body = number,
            _ => self.type_of = TypeOfRow::Number(number),
        }
    }
}

/// Index of radius or diameter in [`Row::values`].
pub(crate) const SIZE: usize = 3;

/// A parser for rows with the same columns.
#[derive(Debug)]
pub(crate) struct RowReader {
    delimiter: Delimiter,
    slots: Vec<Slot>,
    /// Names for messages: those of the header, or the roles without a header.
    labels: Vec<String>,
    /// Role of the column whose values must not be negative.
    size: Role,
}

impl RowReader {
    pub(crate) fn new(delimiter: Delimiter, roles: &[Option<Role>], labels: Vec<String>) -> Self {
        let slot = |role: &Option<Role>| match role {
            None => Slot::Skip,
            Some(Role::Id) => Slot::Id,
            Some(Role::Body) => Slot::Body,
            Some(Role::Type) => Slot::Type,
            Some(Role::X) => Slot::Value(0),
            Some(Role::Y) => Slot::Value(1),
            Some(Role::Z) => Slot::Value(2),
            Some(Role::Radius | Role::Diameter) => Slot::Value(SIZE),
        };
        let size = if roles.contains(&Some(Role::Diameter)) { Role::Diameter } else { Role::Radius };
        Self { delimiter, slots: roles.iter().map(slot).collect(), labels, size }
    }

    /// Parses the fields in one pass. `None` for anything other than plain numbers and delimiters: quotes,
    /// comments, ids such as `7.0`, mistakes. [`Self::read`] handles those.
    #[inline]
    pub(crate) fn read_clean<'a>(&self, line: &'a [u8]) -> Option<Row<'a>> {
        let mut row = Row::default();
        let mut at = 0;
        let separator = separator(self.delimiter);
        for (place, slot) in self.slots.iter().enumerate() {
            let between = at;
            at = self.after_blanks(line, at);
            if place > 0 {
                match separator {
                    None if at == between => return None,
                    None => {}
                    Some(separator) if line.get(at) == Some(&separator) => {
                        at = self.after_blanks(line, at + 1);
                    }
                    Some(_) => return None,
                }
            }
            let rest = &line[at..];
            match *slot {
                Slot::Value(index) => {
                    let (value, length) = fast_float2::parse_partial::<f64, _>(rest).ok()?;
                    row.values[index] = value;
                    at += length;
                }
                Slot::Id | Slot::Body => {
                    let (number, length) = leading_whole(rest)?;
                    *(if matches!(slot, Slot::Id) { &mut row.id } else { &mut row.body }) = number;
                    at += length;
                }
                Slot::Skip | Slot::Type => {
                    let ends = |byte: u8| Some(byte) == separator || self.is_blank(byte) || byte == b'\r';
                    let length = rest.iter().position(|&byte| ends(byte)).unwrap_or(rest.len());
                    let is_type = matches!(slot, Slot::Type);
                    if (length == 0 && (separator.is_none() || is_type))
                        || rest[..length].iter().any(|byte| matches!(byte, b'"' | b'#' | b'%'))
                    {
                        return None;
                    }
                    if is_type {
                        row.type_of = TypeOfRow::Name(&rest[..length]);
                    }
                    at += length;
                }
            }
        }
        let ended = line[at..].iter().all(|&byte| self.is_blank(byte) || byte == b'\r');
        let good = row.values.iter().all(|value| value.is_finite()) && row.values[SIZE] >= 0.0;
        (ended && good).then_some(row)
    }

    /// Parses a row with everything that a line may contain; `Ok(None)` for a blank line or a comment.
    pub(crate) fn read<'a>(&self, line: &'a [u8]) -> Result<Option<Row<'a>>, String> {
        if is_torn(line) {
            return Err(TORN.into());
        }
        let line = content(line);
        if line.is_empty() {
            return Ok(None);
        }
        let fields = split(line, self.delimiter);
        let row = if fields.len() == self.slots.len() {
            self.values(&fields)
        } else {
            Err(self.wrong_count(line, &fields))
        };
        row.map(Some).map_err(|problem| match self.other_delimiter(line) {
            Some(other) => format!("{problem} ({other})"),
            None => problem,
        })
    }

    fn values<'a>(&self, fields: &[&'a [u8]]) -> Result<Row<'a>, String> {
        let mut row = Row::default();
        for ((field, slot), label) in fields.iter().zip(&self.slots).zip(&self.labels) {
            match *slot {
                Slot::Value(index) => row.values[index] = self.value(field, label)?,
                Slot::Id => row.id = whole_number(Role::Id, field, label)?,
                Slot::Body => row.body = whole_number(Role::Body, field, label)?,
                Slot::Type if field.is_empty() => return Err(format!("column {label} is empty")),
                Slot::Type => row.type_of = TypeOfRow::Name(field),
                Slot::Skip => {}
            }
            if matches!(slot, Slot::Value(SIZE)) {
                check_size(row.values[SIZE], self.size, label)?;
            }
        }
        Ok(row)
    }

    fn wrong_count(&self, line: &[u8], split: &[&[u8]]) -> String {
        let (expected, found) = (self.slots.len(), fields(line, self.delimiter).count());
        let digits = |field: &&[u8]| {
            !field.is_empty() && field.iter().all(|byte| byte.is_ascii_digit() || *byte == b'-')
        };
        let halves = || found == 2 * expected && split.iter().all(digits);
        let decimal = self.delimiter == Delimiter::Comma
            && (halves()
                || [Delimiter::Semicolon, Delimiter::Blank].into_iter().any(|other| {
                    self.fits(line, other, has_decimal_comma) && !self.fits(line, other, |_, _| false)
                }));
        let hint = if decimal { format!(" ({})", Slip::Decimal) } else { String::new() };
        format!("expected {}, found {found}{hint}", excerpt::count(expected as u64, "field"))
    }

    /// A message if a row is bad only because its fields are separated differently from those of the rows
    /// before.
    fn other_delimiter(&self, line: &[u8]) -> Option<String> {
        // Next to commas, a number that contains a comma is two fields.
        let number = |field: &[u8], delimiter: Delimiter| {
            ![self.delimiter, delimiter].contains(&Delimiter::Comma) && has_decimal_comma(field, delimiter)
        };
        let mut others = [Delimiter::Semicolon, Delimiter::Comma, Delimiter::Blank].into_iter();
        let other = others.find(|&other| other != self.delimiter && self.fits(line, other, number))?;
        let has = |blank: u8| line.trim_ascii().contains(&blank);
        let plural = |delimiter| match delimiter {
            Delimiter::Blank => "blanks or tabs",
            Delimiter::Tab => "tabs",
            Delimiter::Comma => "commas",
            Delimiter::Semicolon => "semicolons",
        };
        let shown = match (other, has(b' '), has(b'\t')) {
            (Delimiter::Blank, false, _) => "tabs",
            (Delimiter::Blank, _, false) => "blanks",
            _ => plural(other),
        };
        Some(format!("separated by {shown}, the lines before by {}", plural(self.delimiter)))
    }

    /// Whether a row has the right columns with another delimiter; `number` decides which other texts count
    /// as numbers.
    fn fits(&self, line: &[u8], other: Delimiter, number: impl Fn(&[u8], Delimiter) -> bool) -> bool {
        let fields = split(line, other);
        fields.len() == self.slots.len()
            && fields.iter().zip(&self.slots).all(|(field, slot)| {
                matches!(slot, Slot::Skip | Slot::Type)
                    || fast_float2::parse::<f64, _>(field).is_ok()
                    || number(field, other)
            })
    }

    fn value(&self, field: &[u8], label: &str) -> Result<f64, String> {
        let shown = || excerpt::field(field);
        match fast_float2::parse::<f64, _>(field) {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) if field.iter().any(u8::is_ascii_digit) => {
                Err(format!("'{}' in column {label} is too large for a 64-bit float", shown()))
            }
            Ok(_) => Err(format!("'{}' in column {label} is not a finite number", shown())),
            Err(_) if field.is_empty() => Err(format!("column {label} is empty")),
            Err(_) => Err(match slip(field, self.delimiter) {
                Some(slip) => format!("'{}' in column {label} {slip}", shown()),
                None => format!("cannot read '{}' as a number in column {label}", shown()),
            }),
        }
    }

    fn is_blank(&self, byte: u8) -> bool {
        byte == b' ' || (byte == b'\t' && self.delimiter != Delimiter::Tab)
    }

    #[inline]
    fn after_blanks(&self, line: &[u8], mut at: usize) -> usize {
        while line.get(at).is_some_and(|&byte| self.is_blank(byte)) {
            at += 1;
        }
        at
    }
}

/// The probable intention of a field that is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slip {
    /// A decimal comma: `0,5`. In a comma-separated file `5 0`, the end of `0,5` and the start of `0,2`.
    Decimal,
    /// Separators of thousands: `1,000,000`; in a comma-separated file `1 000`.
    Thousands,
    /// Either: `1,000`.
    Either,
}

impl fmt::Display for Slip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Decimal => "looks like a decimal comma: use a point",
            Self::Thousands => "looks like a thousands separator: write the digits without it",
            Self::Either => {
                "looks like a decimal comma or thousands separator: use a point before decimals, and nothing \
                 between thousands"
            }
        })
    }
}

/// The probable slip in a field, if any.
pub(crate) fn slip(field: &[u8], delimiter: Delimiter) -> Option<Slip> {
    let beside_commas = delimiter == Delimiter::Comma;
    let is_mark = |byte: &u8| if beside_commas { matches!(byte, b' ' | b'\t') } else { *byte == b',' };
    let unsigned = |number: &'_ [u8]| usize::from(matches!(number, [b'+' | b'-', ..]));
    let field = &field[unsigned(field)..];
    // A run of blanks is one mark, but `1,,000` is not a number.
    let groups = field.split(is_mark).filter(|group| !(beside_commas && group.is_empty()));
    let groups: Vec<&[u8]> = groups.take(LONGEST_NUMBER).collect();
    let [first, rest @ .., last] = &groups[..] else { return None };

    let digits = |group: &[u8]| group.iter().all(u8::is_ascii_digit);
    let (whole, fraction) = last.split_at(last.iter().position(|byte| *byte == b'.').unwrap_or(last.len()));
    let grouped = |group: &[u8]| group.len() == 3 && digits(group);
    let thousands = (1..=3).contains(&first.len())
        && digits(first)
        && first[0] != b'0'
        && rest.iter().all(|group| grouped(group))
        && grouped(whole)
        && digits(fraction.strip_prefix(b".").unwrap_or_default());

    let after = if beside_commas { &last[unsigned(last)..] } else { last };
    let plain = |group: &[u8]| group.iter().all(|byte| byte.is_ascii_digit() || b"+-eE".contains(byte));
    // A number starts with `0` or `12`, not with `012`.
    let decimal = rest.is_empty()
        && first.last().is_some_and(u8::is_ascii_digit)
        && after.first().is_some_and(u8::is_ascii_digit)
        && plain(first)
        && plain(after)
        && !(beside_commas && after.len() > 1 && after[0] == b'0');
    match (decimal, thousands) {
        (true, true) => Some(Slip::Either),
        (true, false) => Some(Slip::Decimal),
        (false, true) => Some(Slip::Thousands),
        (false, false) => None,
    }
}

/// Largest number of groups examined in a number: the largest `f64` has 103 groups of three digits.
const LONGEST_NUMBER: usize = 128;

fn has_decimal_comma(field: &[u8], delimiter: Delimiter) -> bool {
    matches!(slip(field, delimiter), Some(Slip::Decimal | Slip::Either))
}

/// The message for a line that [`is_torn`].
pub(crate) const TORN: &str =
    "a carriage return without line feed inside the line: two lines may have run together";

/// Whether a carriage return occurs inside a line: `1 0\r1` is not `1 0 1`.
pub(crate) fn is_torn(line: &[u8]) -> bool {
    memchr::memchr(b'\r', line).is_some_and(|at| !line[at..].trim_ascii_start().is_empty())
}

/// An error if a radius or diameter is negative.
pub(crate) fn check_size(value: f64, role: Role, label: &str) -> Result<(), String> {
    if value < 0.0 {
        let column = if label == role.to_string() { String::new() } else { format!(" in column {label}") };
        return Err(format!("the {role} {value}{column} is negative"));
    }
    Ok(())
}

/// The integer equal to a float, if there is one and no other integer rounds to this float.
pub(crate) fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() <= WHOLE_FLOATS).then_some(value as i64)
}

/// An id or a body.
fn whole_number(role: Role, field: &[u8], label: &str) -> Result<i64, String> {
    let digits = field.strip_prefix(b"-").or(field.strip_prefix(b"+")).unwrap_or(field);
    let shown = || excerpt::field(field);
    if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) {
        let number = std::str::from_utf8(field).ok().and_then(|field| field.parse().ok());
        return number
            .ok_or_else(|| format!("the {role} {} in column {label} does not fit 64 bits", shown()));
    }
    match fast_float2::parse::<f64, _>(field) {
        Ok(value) if value.is_finite() && value.fract() == 0.0 => whole(value).ok_or_else(|| {
            format!(
                "the {role} {} in column {label} is beyond 2^53: write it without point and exponent",
                shown()
            )
        }),
        _ => Err(format!("the {role} '{}' in column {label} is not a whole number", shown())),
    }
}

/// A run of digits, perhaps with a minus, and its length; short enough not to overflow.
#[inline]
fn leading_whole(bytes: &[u8]) -> Option<(i64, usize)> {
    let sign = usize::from(bytes.first() == Some(&b'-'));
    let (mut number, mut length) = (0, sign);
    while let Some(digit) = bytes.get(length).filter(|byte| byte.is_ascii_digit()) {
        if length == 18 {
            return None;
        }
        number = number * 10 + i64::from(digit - b'0');
        length += 1;
    }
    (length > sign).then_some((if sign == 1 { -number } else { number }, length))
}

fn separator(delimiter: Delimiter) -> Option<u8> {
    match delimiter {
        Delimiter::Blank => None,
        Delimiter::Tab => Some(b'\t'),
        Delimiter::Comma => Some(b','),
        Delimiter::Semicolon => Some(b';'),
    }
}

/// The line without its comment: from `#` on, or all of it if it starts with `%`. Blanks and the line end are
/// removed too. Tabs are not, because they may separate empty fields.
pub(crate) fn content(line: &[u8]) -> &[u8] {
    if line.trim_ascii_start().starts_with(b"%") {
        return b"";
    }
    let mut quoted = false;
    let comment = |byte: &u8| {
        quoted ^= *byte == b'"';
        *byte == b'#' && !quoted
    };
    let end = match memchr::memchr(b'#', line) {
        Some(_) => line.iter().position(comment).unwrap_or(line.len()),
        None => line.len(),
    };
    let line = &line[..end];
    if line.trim_ascii().is_empty() { b"" } else { line.strip_suffix(b"\r").unwrap_or(line) }
}

/// The fields of a line, at most one more than any table has, so that a line of millions of fields takes
/// little memory.
pub(crate) fn split(line: &[u8], delimiter: Delimiter) -> Vec<&[u8]> {
    fields(line, delimiter).take(MOST_COLUMNS + 1).collect()
}

/// The fields of a line, trimmed and without quotes. Empty fields count, except in a line separated by
/// blanks.
fn fields(line: &[u8], delimiter: Delimiter) -> impl Iterator<Item = &[u8]> {
    let mut quoted = false;
    let separator = separator(delimiter);
    let fields = line.split(move |&byte| {
        quoted ^= byte == b'"';
        !quoted && separator.map_or(byte.is_ascii_whitespace(), |separator| byte == separator)
    });
    let fields = fields.map(|field| unquote(field.trim_ascii()));
    fields.filter(move |field| separator.is_some() || !field.is_empty())
}

fn unquote(field: &[u8]) -> &[u8] {
    match field {
        [b'"', inside @ .., b'"'] => inside.trim_ascii(),
        _ => field,
    }
}

/// Text for names. The input is valid UTF-8, so nothing is lost.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reader(delimiter: Delimiter, roles: &[Option<Role>]) -> RowReader {
        let labels = roles.iter().map(|role| role.map_or("other".into(), |role| role.to_string())).collect();
        RowReader::new(delimiter, roles, labels)
    }

    fn xyr(delimiter: Delimiter) -> RowReader {
        reader(delimiter, &[Some(Role::X), Some(Role::Y), Some(Role::Radius)])
    }

    #[test]
    fn clean_rows_take_the_fast_way() {
        let expected = Row { values: [1.0, -2.5, 0.0, 3.0], ..Row::default() };
        for (delimiter, line) in [
            (Delimiter::Blank, " 1 \t-2.5  3e0 \r"),
            (Delimiter::Comma, "1 ,\t-2.5,3"),
            (Delimiter::Semicolon, "1;-2.5; 3\r"),
            (Delimiter::Tab, "1\t -2.5 \t3"),
        ] {
            assert_eq!(xyr(delimiter).read_clean(line.as_bytes()), Some(expected), "{line:?}");
            assert_eq!(xyr(delimiter).read(line.as_bytes()), Ok(Some(expected)), "{line:?}");
        }
    }

    #[test]
    fn the_fast_way_refuses_what_needs_care() {
        for line in
            ["1,2", "1,2,3,", "1,2,3 4", "1,2,nan", "1,2,-3", "1,2,1e400", "1,2,3#", "\"1\",2,3", "1 2 3", ""]
        {
            assert_eq!(xyr(Delimiter::Comma).read_clean(line.as_bytes()), None, "{line:?}");
        }
        for line in ["1 2", "1 2 3 4", "1 2 3x", "1-2 3", "# 1 2 3"] {
            assert_eq!(xyr(Delimiter::Blank).read_clean(line.as_bytes()), None, "{line:?}");
        }
    }

    #[test]
    fn ids_are_whole_and_exact() {
        for (field, expected) in [
            ("7", 7),
            ("-7", -7),
            ("+7", 7),
            ("7.0", 7),
            ("7.000000e+00", 7),
            ("1e3", 1000),
            ("007", 7),
            ("9223372036854775807", i64::MAX),
            ("-9223372036854775808", i64::MIN),
            ("9007199254740993", 9_007_199_254_740_993),
            ("9007199254740992.0", 9_007_199_254_740_992),
        ] {
            assert_eq!(whole_number(Role::Id, field.as_bytes(), "id"), Ok(expected), "{field}");
        }
        for (field, problem) in [
            ("9223372036854775808", "does not fit"),
            ("1e16", "beyond 2^53"),
            ("7.5", "not a whole"),
            ("", "not a whole"),
            ("nan", "not a whole"),
            ("1e400", "not a whole"),
            ("x7", "not a whole"),
            ("-", "not a whole"),
        ] {
            let error = whole_number(Role::Id, field.as_bytes(), "id").unwrap_err();
            assert!(error.contains(problem), "{field}: {error}");
        }
        assert_eq!(leading_whole(b"-12 "), Some((-12, 3)));
        assert_eq!(leading_whole(b"999999999999999999999"), None, "left to the careful way");
        assert_eq!(leading_whole(b"-"), None);
    }

    #[test]
    fn quotes_hide_delimiters_and_comments() {
        assert_eq!(split(b"\"a,b\" , c", Delimiter::Comma), [b"a,b".as_slice(), b"c"]);
        assert_eq!(split(b" \"Pos X\"  b ", Delimiter::Blank), [b"Pos X".as_slice(), b"b"]);
        assert_eq!(split(b"1,,2,", Delimiter::Comma), [b"1".as_slice(), b"", b"2", b""]);
        assert_eq!(split(b"1\t\t2", Delimiter::Tab).len(), 3);
        assert_eq!(split(b"1\t\t2", Delimiter::Blank).len(), 2);
        assert_eq!(content(b"\"#\",1 # x\r"), b"\"#\",1 ");
        assert_eq!(content(b" \t # x"), b"");
        assert_eq!(content(b" 1\r"), b" 1");
    }

    #[test]
    fn decimal_commas_are_recognised_and_nothing_else_is() {
        assert!(has_decimal_comma(b"0,5", Delimiter::Blank));
        assert!(has_decimal_comma(b"-1,5e-3", Delimiter::Semicolon));
        assert!(has_decimal_comma(b"5 -0", Delimiter::Comma));
        for field in ["0.5", "a,b", "0,", ",5", "1,x", "5 0"] {
            assert!(!has_decimal_comma(field.as_bytes(), Delimiter::Blank), "{field}");
        }
        for field in ["5", "5 a", " 5", "0.5 0.2"] {
            assert!(!has_decimal_comma(field.as_bytes(), Delimiter::Comma), "{field}");
        }
    }

    #[test]
    fn thousands_are_told_from_decimals() {
        use Slip::{Decimal, Either, Thousands};
        for (field, expected) in [
            ("1,000", Some(Either)),
            ("-12,345", Some(Either)),
            ("0,125", Some(Decimal)),
            ("1,00", Some(Decimal)),
            ("1234,567", Some(Decimal)),
            ("1,000,000", Some(Thousands)),
            ("1,000.5", Some(Thousands)),
            ("1,0,1", None),
            ("1,,000", None),
            ("1", None),
            (",", None),
            ("", None),
        ] {
            assert_eq!(slip(field.as_bytes(), Delimiter::Semicolon), expected, "{field}");
            assert_eq!(slip(field.as_bytes(), Delimiter::Blank), expected, "{field}");
        }
        for (field, expected) in [
            ("1 000", Some(Thousands)),
            ("2 500", Some(Either)),
            ("1 000 000", Some(Thousands)),
            ("5 -0", Some(Decimal)),
            ("5e-3\t 0", Some(Decimal)),
            ("1 2 3", None),
            ("5 a", None),
        ] {
            assert_eq!(slip(field.as_bytes(), Delimiter::Comma), expected, "{field}");
        }
        assert_eq!(slip("1,000".repeat(1_000_000).as_bytes(), Delimiter::Blank), None);
    }

    #[test]
    fn a_torn_line_is_no_row() {
        assert!(is_torn(b"1 0\r1"));
        assert!(is_torn(b"# c\r1 0"), "a comment must not hide a row");
        assert!(!is_torn(b"1 0\r"));
        assert!(!is_torn(b"1 0 \r\r "));
        for line in [b"1 0\r1".as_slice(), b"# c\r1 0 1", b"1 0 1\r\r1"] {
            assert_eq!(xyr(Delimiter::Blank).read_clean(line), None);
            assert_eq!(xyr(Delimiter::Blank).read(line), Err(TORN.into()));
        }
    }

    #[test]
    fn a_percent_sign_starts_a_comment_at_the_start_only() {
        let skip = reader(Delimiter::Blank, &[None, Some(Role::X), Some(Role::Y)]);
        assert_eq!(skip.read_clean(b"% 1 2"), None);
        assert_eq!(skip.read(b" % 1 2"), Ok(None));
        assert_eq!(skip.read(b"5% 1 2"), Ok(Some(Row { values: [1.0, 2.0, 0.0, 0.0], ..Row::default() })));
    }
}
