//! The text of a model file as a tree with the place of every key and value.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::text::fault::Fault;
use crate::text::values::units::Dimension;

/// Errors of the parser that are looked at.
const MOST_ERRORS: usize = 50;

/// Largest number of lines with errors that are reported.
const MOST_LINES: usize = 5;

/// A parsed file.
pub(crate) struct Document<'a> {
    root: Spanned<DeTable<'a>>,
    /// Dimensions of values whose keys have no unit, by the place of the value.
    dimensions: BTreeMap<usize, Dimension>,
}

/// A table of the file by name, and which of several.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Table {
    pub(crate) name: &'static str,
    pub(crate) index: Option<usize>,
}

impl Table {
    /// `[name]`.
    pub(crate) fn one(name: &'static str) -> Self {
        Self { name, index: None }
    }

    /// `[[name]]` number `index`, from 0.
    pub(crate) fn of(name: &'static str, index: usize) -> Self {
        Self { name, index: Some(index) }
    }
}

impl<'a> Document<'a> {
    /// Reads the lines that are TOML: also returns an error for each of the first lines that are not.
    pub(crate) fn parse(text: &'a str) -> (Self, Vec<Fault>) {
        let (root, errors) = DeTable::parse_recoverable(text);
        let mut faults: Vec<(usize, Fault)> = Vec::new();
        for error in errors.iter().take(MOST_ERRORS) {
            let span = error.span().unwrap_or(0..0);
            let line = line_of(text, span.start);
            if faults.len() < MOST_LINES && faults.iter().all(|(other, _)| *other != line) {
                faults.push((line, syntax(text, &span, error.message())));
            }
        }
        (Self { root, dimensions: BTreeMap::new() }, faults.into_iter().map(|(_, fault)| fault).collect())
    }

    pub(crate) fn set_dimensions(&mut self, dimensions: BTreeMap<usize, Dimension>) {
        self.dimensions = dimensions;
    }

    /// The dimension of the text of a value, if its key has no unit; `None` for a plain number too.
    pub(crate) fn dimension(&self, value: &Range<usize>) -> Option<Dimension> {
        self.dimensions.get(&value.start).copied()
    }

    pub(crate) fn root(&self) -> &Spanned<DeTable<'a>> {
        &self.root
    }

    pub(crate) fn into_root(self) -> Spanned<DeTable<'a>> {
        self.root
    }

    pub(crate) fn root_mut(&mut self) -> &mut Spanned<DeTable<'a>> {
        &mut self.root
    }

    /// The file as its types have it.
    ///
    /// # Errors
    /// The first value that does not fit its type.
    pub(crate) fn read<T: DeserializeOwned>(&self) -> Result<T, toml::de::Error> {
        T::deserialize(toml::de::Deserializer::from(self.root.clone()))
    }

    /// Whether a key of a table is in the file.
    pub(crate) fn has(&self, table: Table, dotted: &str) -> bool {
        self.walk(table, dotted).is_some()
    }

    /// Returns the place of a key of a table: of the deepest part of `dotted.key` that is in the file, or of
    /// the table.
    pub(crate) fn key(&self, table: Table, dotted: &str) -> Range<usize> {
        self.find(table, dotted).0
    }

    /// Returns the place of the value of a key.
    pub(crate) fn value(&self, table: Table, dotted: &str) -> Range<usize> {
        self.find(table, dotted).1
    }

    /// Returns the place of the value of a key, or `None` if the key is missing.
    pub(crate) fn value_if_any(&self, table: Table, dotted: &str) -> Option<Range<usize>> {
        self.walk(table, dotted).map(Spanned::span)
    }

    /// The tables of a list `[[name]]`; `None` if it is no list.
    pub(crate) fn list(&self, table: Table) -> Option<&[Spanned<DeValue<'a>>]> {
        self.walk(table, "")?.get_ref().as_array().map(|list| &list[..])
    }

    /// Names of the keys of a table, sorted.
    pub(crate) fn keys(&self, table: Table) -> Vec<String> {
        let table = self.walk(table, "").and_then(|value| value.get_ref().as_table());
        table.into_iter().flatten().map(|(key, _)| key.get_ref().to_string()).collect()
    }

    /// Whether the value of a key is a table, or a list of tables.
    pub(crate) fn has_entries(&self, table: Table, dotted: &str) -> bool {
        self.walk(table, dotted).is_some_and(|value| match value.get_ref() {
            DeValue::Table(_) => true,
            DeValue::Array(list) => list.iter().any(|entry| entry.get_ref().is_table()),
            _ => false,
        })
    }

    /// Whether the value of a key is a list.
    pub(crate) fn is_list(&self, table: Table, dotted: &str) -> bool {
        self.walk(table, dotted).is_some_and(|value| value.get_ref().is_array())
    }

    /// Returns the place of an entry of the list that is the value of a key.
    pub(crate) fn entry(&self, table: Table, dotted: &str, index: usize) -> Range<usize> {
        let Some(spot) = self.walk(table, dotted).and_then(|value| value.get_ref().as_array()) else {
            return self.value(table, dotted);
        };
        spot.get(index).map_or_else(|| self.value(table, dotted), Spanned::span)
    }

    /// The part of the text from the first to the last key or value of a table.
    pub(crate) fn extent(&self, table: Table) -> Range<usize> {
        let mut extent = self.find(table, "").0;
        if let Some(value) = self.walk(table, "") {
            widen(&mut extent, value);
        }
        extent
    }

    /// Returns for each of the tables `[[name]]` whether it has faults.
    pub(crate) fn with_faults(&self, name: &'static str, count: usize, faults: &[Fault]) -> Vec<bool> {
        let has = |index| {
            let extent = self.extent(Table::of(name, index));
            let within = |span: &Range<usize>| extent.start <= span.start && span.end <= extent.end;
            faults.iter().any(|fault| fault.span.as_ref().is_some_and(within))
        };
        (0..count).map(has).collect()
    }

    fn walk(&self, table: Table, dotted: &str) -> Option<&Spanned<DeValue<'a>>> {
        let mut value = lookup(self.root.get_ref(), table.name)?.1;
        if let Some(index) = table.index {
            value = value.get_ref().as_array()?.get(index)?;
        }
        for key in dotted.split('.').filter(|key| !key.is_empty()) {
            value = inner(value, key)?.1;
        }
        Some(value)
    }

    fn find(&self, table: Table, dotted: &str) -> (Range<usize>, Range<usize>) {
        let nowhere = (0..0, 0..0);
        let Some((key, value)) = lookup(self.root.get_ref(), table.name) else { return nowhere };
        let mut found = (key.span(), value.span());
        let mut value = value;
        if let (Some(index), Some(list)) = (table.index, value.get_ref().as_array()) {
            let Some(item) = list.get(index) else { return found };
            value = item;
            found = (item.span(), item.span());
        }
        for key in dotted.split('.').filter(|key| !key.is_empty()) {
            let Some((key, inner)) = inner(value, key) else { break };
            found = (key, inner.span());
            value = inner;
        }
        found
    }
}

/// A text of TOML as a tree with the place of every key and value. Also returns the lines that are not TOML.
pub fn toml_tree(text: &str) -> (Spanned<DeTable<'_>>, Vec<Fault>) {
    let (document, faults) = Document::parse(text);
    (document.into_root(), faults)
}

/// The whole number that a value is, without rounding; `None` for one with a decimal point or an exponent.
pub fn whole(value: &DeValue<'_>) -> Option<i64> {
    let DeValue::Integer(number) = value else { return None };
    i64::from_str_radix(&number.as_str().replace('_', ""), number.radix()).ok()
}

/// The number that a value is.
pub fn number(value: &DeValue<'_>) -> Option<f64> {
    let found = match value {
        DeValue::Integer(_) => whole(value)? as f64,
        DeValue::Float(number) => number.as_str().replace('_', "").parse::<f64>().ok()?,
        _ => return None,
    };
    Some(found).filter(|number| number.is_finite())
}

/// Widens a part of the text by all that a value has.
fn widen(extent: &mut Range<usize>, value: &Spanned<DeValue<'_>>) {
    let include = |extent: &mut Range<usize>, span: Range<usize>| {
        *extent = extent.start.min(span.start)..extent.end.max(span.end);
    };
    include(extent, value.span());
    match value.get_ref() {
        DeValue::Table(table) => {
            for (key, value) in table {
                include(extent, key.span());
                widen(extent, value);
            }
        }
        DeValue::Array(list) => list.iter().for_each(|value| widen(extent, value)),
        _ => {}
    }
}

/// The line, from 0, of a place in a text.
pub(crate) fn line_of(text: &str, place: usize) -> usize {
    text.get(..place).unwrap_or(text).matches('\n').count()
}

/// An entry of a table by its key, or of a list by its number from 0, with the place of the key, or of the
/// entry.
fn inner<'t, 'a>(
    value: &'t Spanned<DeValue<'a>>,
    key: &str,
) -> Option<(Range<usize>, &'t Spanned<DeValue<'a>>)> {
    if let Some(list) = value.get_ref().as_array() {
        let entry = list.get(key.parse::<usize>().ok()?)?;
        return Some((entry.span(), entry));
    }
    let (key, value) = lookup(value.get_ref().as_table()?, key)?;
    Some((key.span(), value))
}

/// An entry of a table.
fn lookup<'t, 'a>(
    table: &'t DeTable<'a>,
    name: &str,
) -> Option<(&'t Spanned<std::borrow::Cow<'a, str>>, &'t Spanned<DeValue<'a>>)> {
    table.iter().find(|(key, _)| key.get_ref() == name)
}

/// Describes a syntax error.
fn syntax(text: &str, span: &Range<usize>, message: &str) -> Fault {
    let start = span.start.min(text.len());
    let begin = text.as_bytes()[..start].iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
    let end =
        text.as_bytes()[begin..].iter().position(|&byte| byte == b'\n').map_or(text.len(), |at| begin + at);
    // Fine where the spans of the parser are on borders of characters, which they are.
    let line = text.get(begin..end).unwrap_or("");
    if let Some(place) = decimal_comma(line) {
        let wrong = &line[place.clone()];
        let right = wrong.replace(',', ".");
        return Fault::at(begin + place.start..begin + place.end, format!("a decimal comma: {wrong}"))
            .label("comma")
            .help(format!("write {right}"));
    }
    let span = if span.is_empty() { start..(start + 1).min(text.len()) } else { span.clone() };
    let fault = Fault::at(span, format!("this is not TOML: {message}"));
    match line.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
        Some((key, "")) if !key.is_empty() => fault.help(format!("\"{key}\" has no value")),
        Some((key, value)) if is_word(value) => {
            fault.help(format!("text goes in quotes: {key} = \"{value}\""))
        }
        None if line.contains(':') => fault.help("a key and its value go with an equals sign: key = value"),
        _ => fault,
    }
}

fn is_word(value: &str) -> bool {
    value.starts_with(|c: char| c.is_alphabetic())
        && value.chars().all(|c| c.is_alphanumeric() || " _-./".contains(c))
        && value != "true"
        && value != "false"
}

/// Returns the place of the number in a line like `key = 0,25`.
fn decimal_comma(line: &str) -> Option<Range<usize>> {
    let equals = line.find('=')?;
    let value = line[equals + 1..].split('#').next().unwrap_or("");
    let trimmed = value.trim();
    let (whole, fraction) = trimmed.split_once(',')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let mantissa = fraction.split(['e', 'E']).next().unwrap_or("");
    let number = trimmed.replacen(',', ".", 1).parse::<f64>().is_ok();
    if !number || !digits(whole.trim_start_matches(['+', '-'])) || !digits(mantissa) {
        return None;
    }
    let start = equals + 1 + (value.len() - value.trim_start().len());
    Some(start..start + trimmed.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decimal_comma_is_seen_where_there_is_one() {
        let line = "poissons_ratio = 0,25 # measured";
        assert_eq!(decimal_comma(line).map(|place| &line[place]), Some("0,25"));
        assert!(decimal_comma("x = -1,5e3").is_some());
        for line in ["x = [0,25]", "x = 0.25", "x = a,b", "x = 1,", "no equals 0,25"] {
            assert_eq!(decimal_comma(line), None, "{line}");
        }
    }
}
