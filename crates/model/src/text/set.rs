//! Values of a model that are set from outside: its parameters, and keys by their path, such as
//! `material.rock.cohesion`.
//!
//! The text of the model is changed and nothing else, so that the changed model is a model file as any other,
//! with the same checks.

use std::fmt;

use toml::Spanned;
use toml::de::DeValue;

use crate::text::document::{Document, Table};
use crate::text::fault::suggestion;
use crate::text::file::ModelFile;
use crate::text::included::{Load, Sources};
use crate::text::values::{PARAMETERS, constant};

/// Whole numbers beyond this are not all floating-point numbers.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// A value that is set.
#[derive(Debug, Clone, PartialEq)]
pub enum Setting {
    /// A number in SI units.
    Number(f64),
    /// A number that is written without a decimal point, such as a seed. All of its digits count.
    Whole(i64),
    /// A word, or an expression such as `8 MPa`.
    Text(String),
    /// True or false.
    Flag(bool),
}

impl Setting {
    /// Parses a value of a command line or a table: a number, `true`, `false`, or else a text.
    pub fn parse(text: &str) -> Self {
        let text = text.trim();
        if let Ok(number) = text.parse() {
            return Self::Whole(number);
        }
        match (text.parse::<f64>(), text) {
            (Ok(number), _) if number.is_finite() => Self::Number(number),
            (_, "true") => Self::Flag(true),
            (_, "false") => Self::Flag(false),
            _ => Self::Text(text.to_owned()),
        }
    }

    /// The number in SI units, angles in degrees. `None` for words, and for expressions that name parameters.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Whole(number) => Some(*number as f64),
            Self::Text(text) => constant(text).ok().map(|(number, _)| number),
            Self::Flag(_) => None,
        }
    }

    /// The value as TOML.
    fn toml(&self) -> String {
        match self {
            // No integer is -0.
            Self::Number(number)
                if number.fract() == 0.0
                    && number.abs() < WHOLE
                    && (*number != 0.0 || number.is_sign_positive()) =>
            {
                format!("{number:.0}")
            }
            Self::Number(number) => format!("{number:?}"),
            Self::Whole(number) => number.to_string(),
            Self::Text(text) => toml::Value::from(text.as_str()).to_string(),
            Self::Flag(flag) => flag.to_string(),
        }
    }
}

/// The value as [`Setting::parse`] reads it.
impl fmt::Display for Setting {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(_) | Self::Whole(_) | Self::Flag(_) => out.write_str(&self.toml()),
            Self::Text(text) => out.write_str(text),
        }
    }
}

/// The same model file with other values. A name without a dot, or after `parameters.`, is a parameter; any
/// other is the path of a key: `model.end_time`, `material.rock.cohesion`, `body.disc.mesh_size`,
/// `initial.stress.0`. Tables that may come several times are found by their name, or by their number from 1.
///
/// # Errors
/// A name that the model does not have, or a key that cannot be set. A text that is no TOML comes back
/// unchanged: the checks of the model say why.
///
/// # Example
/// ```
/// use fdem_model::{Setting, with_values};
///
/// let text = "[parameters]\nstrength = \"8 MPa\"\n[[material]]\nname = \"rock\"\ndensity = 2700 # wet\n";
/// let sets = [("strength", "6 MPa"), ("material.rock.density", "2500"), ("material.rock.friction", "0.5")];
/// let sets = sets.map(|(name, value)| (name.to_owned(), Setting::parse(value)));
/// assert_eq!(
///     with_values(text, &mut |_| Err("no files".into()), &sets)?,
///     "[parameters]\nstrength = \"6 MPa\"\n[[material]]\nfriction = 0.5\nname = \"rock\"\ndensity = 2500 # wet\n"
/// );
/// # Ok::<(), String>(())
/// ```
pub fn with_values(text: &str, load: &mut Load<'_>, sets: &[(String, Setting)]) -> Result<String, String> {
    let mut text = text.to_owned();
    if !Document::parse(&text).1.is_empty() {
        return Ok(text);
    }
    for (name, value) in sets {
        text = match name.split_once('.') {
            None => with_parameter(&text, load, name, value)?,
            Some((PARAMETERS, name)) => with_parameter(&text, load, name, value)?,
            Some((table, path)) => with_key(&text, load, (table, path), value)?,
        };
    }
    Ok(text)
}

/// The same model file with another `end_time`, s; `None` if it has none. A model that includes files may
/// have it from one of them; then the model gets its own key, which wins.
///
/// # Example
/// ```
/// let text = "[model]\nend_time = 1e-3 # short";
/// assert_eq!(fdem_model::with_end_time(text, 0.25).as_deref(), Some("[model]\nend_time = 0.25 # short"));
/// ```
pub fn with_end_time(text: &str, seconds: f64) -> Option<String> {
    let (document, faults) = Document::parse(text);
    if !faults.is_empty() {
        return None;
    }
    let model = Table::one("model");
    // A TOML number with an exponent needs no point, and one without has it.
    let number = format!("{seconds:?}");
    if document.has(model, "end_time") {
        return replaced(text, &document, model, "end_time", &number);
    }
    document.has(Table::one("include"), "").then(|| inserted(text, &document, model, "end_time", &number))?
}

fn with_parameter(text: &str, load: &mut Load<'_>, name: &str, value: &Setting) -> Result<String, String> {
    let (document, _) = Document::parse(text);
    let table = Table::one(PARAMETERS);
    if let Some(text) = replaced(text, &document, table, name, &value.toml()) {
        return Ok(text);
    }
    let sources = Sources::gather(text, load);
    let (merged, _) = sources.parse();
    if !merged.has(table, name) {
        let names = merged.keys(table);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let help = suggestion(name, &names, "[parameters] table");
        return Err(format!("the model has no parameter \"{name}\": {help}"));
    }
    // A value of this file wins over that of an included one.
    inserted(text, &document, table, name, &value.toml())
        .ok_or_else(|| format!("the parameter \"{name}\" cannot be set: give [parameters] a line of its own"))
}

fn with_key(
    text: &str,
    load: &mut Load<'_>,
    (table, path): (&str, &str),
    value: &Setting,
) -> Result<String, String> {
    let whole = format!("{table}.{path}");
    let Some(table) = ModelFile::TABLES.into_iter().find(|known| *known == table) else {
        let help = suggestion(table, &ModelFile::TABLES, "table");
        return Err(format!("\"{whole}\" is no key of a model: there is no table \"{table}\"; {help}"));
    };
    let (document, _) = Document::parse(text);
    let (place, key) = match document.list(Table::one(table)) {
        None => (Table::one(table), path.to_owned()),
        Some(list) => {
            let (index, key) = entry(list, path).ok_or_else(|| {
                let names: Vec<&str> = list.iter().filter_map(name_of).collect();
                let help = suggestion(path.split('.').next().unwrap_or(path), &names, "named table");
                let hint = if is_included(text, load, table, path) {
                    "it is in an included file: use a parameter there, and set that".to_owned()
                } else {
                    help
                };
                format!("\"{whole}\" is no key of the model: no [[{table}]] has that name and a key; {hint}")
            })?;
            (Table::of(table, index), key.to_owned())
        }
    };
    if matches!(value, Setting::Text(list) if list.starts_with('[') && list.ends_with(']')) {
        let first = if document.is_list(place, &key) { "" } else { "write the list into the model, and " };
        return Err(format!(
            "\"{whole}\" cannot be set to a list: {first}set its entries one by one, as in {whole}.1=0"
        ));
    }
    if let Some(text) = replaced(text, &document, place, &key, &value.toml()) {
        return Ok(text);
    }
    if document.has(place, &key) {
        return Err(format!("\"{whole}\" is a table of the model: set one of its keys"));
    }
    if place.index.is_none() && is_included(text, load, table, path) && !document.has(place, "") {
        return Err(format!("\"{whole}\" is in an included file: use a parameter there, and set that"));
    }
    let added = if key.contains('.') { None } else { inserted(text, &document, place, &key, &value.toml()) };
    added.ok_or_else(|| format!("\"{whole}\" is not in the model: write it there first, with any value"))
}

/// Whether an included file has a table of a list, by the beginning of its path.
fn is_included(text: &str, load: &mut Load<'_>, table: &'static str, path: &str) -> bool {
    let sources = Sources::gather(text, load);
    let (merged, _) = sources.parse();
    merged.list(Table::one(table)).is_some_and(|list| entry(list, path).is_some())
}

fn name_of<'v>(value: &'v Spanned<DeValue<'_>>) -> Option<&'v str> {
    let (_, name) = value.get_ref().as_table()?.iter().find(|(key, _)| key.get_ref() == "name")?;
    name.get_ref().as_str()
}

/// The entry of a list that a path begins with, and the rest of the path. If several names match, the longest
/// counts.
fn entry<'p>(list: &[Spanned<DeValue<'_>>], path: &'p str) -> Option<(usize, &'p str)> {
    let rest = |name: &str| path.strip_prefix(name)?.strip_prefix('.').filter(|rest| !rest.is_empty());
    let named = list.iter().enumerate().filter_map(|(index, value)| {
        let name = name_of(value)?;
        Some((name.len(), index, rest(name)?))
    });
    if let Some((_, index, rest)) = named.max_by_key(|(length, index, _)| (*length, usize::MAX - index)) {
        return Some((index, rest));
    }
    let (number, rest) = path.split_once('.')?;
    let index = number.parse::<usize>().ok()?.checked_sub(1).filter(|index| *index < list.len())?;
    Some((index, rest)).filter(|(_, rest)| !rest.is_empty())
}

/// The text with another value of a key; `None` if it does not have the key.
fn replaced(text: &str, document: &Document<'_>, table: Table, key: &str, value: &str) -> Option<String> {
    let place = document.value_if_any(table, key)?;
    // The place of a table with a separate heading is that heading, which no value can replace.
    if document.has_entries(table, key) {
        return None;
    }
    Some(format!("{}{value}{}", &text[..place.start], &text[place.end..]))
}

/// The text with one more key of a table, below its heading. `None` if the table has none: its keys are in
/// braces or dotted, where a line cannot be added.
fn inserted(text: &str, document: &Document<'_>, table: Table, key: &str, value: &str) -> Option<String> {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let key = if !key.is_empty() && key.chars().all(is_bare) {
        key.to_owned()
    } else {
        toml::Value::from(key).to_string()
    };
    let Some(heading) = document.value_if_any(table, "") else {
        return Some(format!("{text}\n[{}]\n{key} = {value}\n", table.name));
    };
    let after = heading.end + text[heading.end..].find('\n').unwrap_or(text.len() - heading.end);
    let changed = format!("{}\n{key} = {value}{}", &text[..after], &text[after..]);
    text[heading].starts_with('[').then_some(changed)
}
