//! The library of materials: `library = "granite"` in a `[[material]]` gives all keys that the table itself
//! does not give.
//!
//! [`resolve`] puts the keys into the document before expressions are evaluated, so that the rest of the
//! checks, the hash and the run do not depend on the library. The place of each key that it adds is that of
//! the name of the library's material.

use std::ops::Range;
use std::sync::OnceLock;

use serde::Serialize;
use serde_json::{Value, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::bodies::materials::STRENGTH;
use crate::text::document::{Document, number};
use crate::text::fault::nearest;

/// The figures.
const TEXT: &str = include_str!("library.toml");

/// The key of a `[[material]]` that names one of the library.
const KEY: &str = "library";

/// A material of the library.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LibraryMaterial {
    /// Name of the material in the library.
    pub name: String,
    /// Description in a few words.
    pub about: String,
    /// Where the figures come from.
    pub source: String,
    /// Keys of `[[material]]` with their values, in the order in which people write them.
    pub keys: Vec<(String, f64)>,
}

impl LibraryMaterial {
    /// The value of a key.
    pub fn value(&self, key: &str) -> Option<f64> {
        self.keys.iter().find(|(name, _)| name == key).map(|(_, value)| *value)
    }

    /// The material as a table of a model file, with its source as a comment.
    pub fn toml(&self) -> String {
        let keys = self.keys.iter().map(|(key, value)| format!("{key} = {value:?}\n"));
        format!(
            "# {}.\n# {}.\n[[material]]\nname = \"{}\"\n{}",
            self.about,
            self.source,
            self.name,
            keys.collect::<String>()
        )
    }
}

/// Keys that a `[[material]]` has from the library.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FromLibrary {
    /// Name of the material in the model.
    pub material: String,
    /// Name in the library.
    pub library: String,
    /// Keys that the library gives, sorted by name.
    pub keys: Vec<String>,
    /// Keys of the library that the model gives itself, sorted by name.
    pub own: Vec<String>,
}

impl FromLibrary {
    /// A line of `fdem check`.
    pub fn in_words(&self) -> String {
        let Self { material, library, keys, own } = self;
        match (&keys[..], &own[..]) {
            ([], _) => format!("\"{material}\" has nothing of {library}: all its keys are in the file"),
            (_, []) => format!("\"{material}\" is {library}: {}", keys.join(", ")),
            _ => {
                format!("\"{material}\" is {library}: {}; the file gives {}", keys.join(", "), own.join(", "))
            }
        }
    }
}

/// All materials of the library, in the order of its file.
///
/// # Example
/// ```
/// let granite = &fdem_model::library()[0];
/// assert_eq!((granite.name.as_str(), granite.value("density")), ("granite", Some(2650.0)));
/// ```
pub fn library() -> &'static [LibraryMaterial] {
    static LIBRARY: OnceLock<Vec<LibraryMaterial>> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let (document, _) = Document::parse(TEXT);
        let mut tables: Vec<_> = document.root().get_ref().iter().collect();
        tables.sort_by_key(|(name, _)| name.span().start);
        tables.into_iter().filter_map(|(name, table)| material(name.get_ref(), table.get_ref())).collect()
    })
}

fn material(name: &str, table: &DeValue<'_>) -> Option<LibraryMaterial> {
    let mut entries: Vec<_> = table.as_table()?.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let text = |wanted: &str| {
        let entry = entries.iter().find(|(key, _)| key.get_ref() == wanted);
        entry.and_then(|(_, value)| value.get_ref().as_str()).unwrap_or_default().to_owned()
    };
    let keys =
        entries.iter().filter_map(|(key, value)| Some((key.get_ref().to_string(), number(value.get_ref())?)));
    Some(LibraryMaterial {
        name: name.to_owned(),
        about: text("about"),
        source: text("source"),
        keys: keys.collect(),
    })
}

/// The schema of the key: the names of the library.
pub(crate) fn names(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let names: Vec<&str> = library().iter().map(|material| material.name.as_str()).collect();
    schemars::Schema::try_from(json!({ "type": "string", "enum": names })).unwrap_or_default()
}

/// In the schema for editors, a `[[material]]` with a `library` needs no keys of the library.
pub(crate) fn relax(schema: &mut Value) {
    let Some(material) = schema.pointer_mut("/$defs/Material").and_then(Value::as_object_mut) else { return };
    let required = material.get("required").and_then(Value::as_array).cloned().unwrap_or_default();
    let given =
        |key: &Value| library().iter().any(|one| key.as_str().is_some_and(|key| one.value(key).is_some()));
    let (given, always): (Vec<Value>, Vec<Value>) = required.into_iter().partition(given);
    material.insert("required".into(), always.into());
    material.insert("anyOf".into(), json!([{ "required": [KEY] }, { "required": given }]));
}

/// Adds the keys of the library to the materials that name one. The schema reports names that the library
/// does not have.
pub(crate) fn resolve(document: &mut Document<'_>) -> Vec<FromLibrary> {
    let tables = document.root_mut().get_mut();
    let list = tables.iter_mut().find(|(name, _)| name.get_ref() == "material");
    let Some(DeValue::Array(list)) = list.map(|(_, list)| list.get_mut()) else { return Vec::new() };
    let mut found = Vec::new();
    for table in list.iter_mut() {
        if let DeValue::Table(table) = table.get_mut() {
            found.extend(complete(table));
        }
    }
    found
}

/// The entries of a material of the library, as they are written.
fn entries(name: &str) -> Option<DeTable<'static>> {
    let (mut document, _) = Document::parse(TEXT);
    match document.root_mut().get_mut().remove(name)?.into_inner() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}

/// Adds the keys of the library to a material that names one.
fn complete(table: &mut DeTable<'_>) -> Option<FromLibrary> {
    let entry = |table: &DeTable<'_>, wanted: &str| -> Option<(Option<String>, Range<usize>)> {
        let (_, value) = table.iter().find(|(key, _)| key.get_ref() == wanted)?;
        Some((value.get_ref().as_str().map(str::to_owned), value.span()))
    };
    let (library, span) = entry(table, KEY)?;
    let library = library.unwrap_or_default();
    let known = self::library().iter().find(|material| material.name == library);
    // A material with a misspelt name has keys too, so that only the name is reported.
    let near = nearest(&library, self::library().iter().map(|material| material.name.as_str()));
    let likely = || self::library().iter().find(|material| near == Some(&material.name));
    let chosen = known.or_else(likely).or(self::library().first())?;
    let is_unbreakable = table
        .iter()
        .any(|(key, value)| key.get_ref() == "unbreakable" && value.get_ref().as_bool() == Some(true));
    let wanted = chosen.keys.iter().filter(|(key, _)| !is_unbreakable || !STRENGTH.contains(&&**key));
    let (own, missing): (Vec<_>, Vec<_>) = wanted.partition(|(key, _)| entry(table, key).is_some());
    for (key, value) in entries(&chosen.name).into_iter().flatten() {
        if missing.iter().any(|(missing, _)| *missing == *key.get_ref()) {
            let key = Spanned::new(span.clone(), key.into_inner());
            table.insert(key, Spanned::new(span.clone(), value.into_inner()));
        }
    }
    let sorted = |keys: Vec<&(String, f64)>| {
        let mut keys: Vec<String> = keys.into_iter().map(|(key, _)| key.clone()).collect();
        keys.sort();
        keys
    };
    let material = entry(table, "name").and_then(|(name, _)| name).unwrap_or_default();
    Some(FromLibrary { material, library, keys: sorted(missing), own: sorted(own) })
}
