//! The JSON schema of model files, and a file checked against it.
//!
//! The schema is made from the types of [`file`](crate::text::file), so it always agrees with the reader. It
//! reports all errors of a file together, where a deserializer stops at the first.

use std::ops::Range;
use std::sync::OnceLock;

use fdem_io::numbers::exact;
use serde_json::{Map, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::text::fault::{Fault, nearest};
use crate::text::file::ModelFile;
use crate::text::library;

/// Largest magnitude of a number in SI units: beyond those of all solids and loads, and small enough to
/// compute with.
pub(crate) const LARGEST: f64 = 1e30;

/// The JSON schema of model files, for editors: keys with descriptions, types, ranges, units and defaults.
/// Where there is a number, there may be an expression.
pub fn schema() -> Value {
    let mut schema = evaluated().clone();
    allow_expressions(&mut schema);
    library::relax(&mut schema);
    schema
}

/// The schema of a file whose expressions have been replaced by their values.
pub(crate) fn evaluated() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| {
        let mut schema = schemars::schema_for!(ModelFile).to_value();
        if let Some(object) = schema.as_object_mut() {
            object.insert("title".into(), "Model of fdem".into());
        }
        schema
    })
}

/// Allows text wherever there is a number. Limits of numbers do not apply to text.
fn allow_expressions(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            let is_number = |kind: &Value| kind == "number" || kind == "integer";
            match object.get_mut("type") {
                Some(Value::Array(kinds)) if kinds.iter().any(is_number) => kinds.push("string".into()),
                Some(kind) if is_number(kind) => *kind = vec![kind.clone(), "string".into()].into(),
                _ => {}
            }
            object.values_mut().for_each(allow_expressions);
        }
        Value::Array(list) => list.iter_mut().for_each(allow_expressions),
        _ => {}
    }
}

/// Finds all unknown keys, all missing keys, and all values of a wrong type or out of range.
pub(crate) fn check(root: &Spanned<DeTable<'_>>) -> Vec<Fault> {
    let schema = evaluated();
    let mut checker = Checker { schema, faults: Vec::new() };
    // A missing table is reported at the end of the file.
    let end = root.span().end;
    checker.table(root.get_ref(), end..end, schema, "the file");
    checker.faults
}

struct Checker<'s> {
    schema: &'s Value,
    faults: Vec<Fault>,
}

impl<'s> Checker<'s> {
    /// Follows the references of a schema, and removes the `null` of optional keys, which TOML does not have.
    fn resolve(&self, schema: &'s Value) -> &'s Value {
        let mut schema = schema;
        loop {
            if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
                let found =
                    name.strip_prefix("#/$defs/").and_then(|name| self.schema.get("$defs")?.get(name));
                let Some(found) = found else { return schema };
                schema = found;
            } else if let Some([only]) = branches(schema).as_deref() {
                schema = only;
            } else {
                return schema;
            }
        }
    }

    fn table(&mut self, table: &DeTable<'_>, span: Range<usize>, schema: &'s Value, name: &str) {
        let properties = schema.get("properties").and_then(Value::as_object);
        let mut misspelt = Vec::new();
        for (key, value) in table {
            let word = key.get_ref().as_ref();
            if let Some(property) = properties.and_then(|properties| properties.get(word)) {
                self.value(value, property, word, name);
            } else if let Some(rest) = schema.get("additionalProperties").filter(|rest| rest.is_object()) {
                self.value(value, rest, word, name);
            } else {
                let siblings: Vec<&str> = table.iter().map(|(key, _)| key.get_ref().as_ref()).collect();
                misspelt.extend(self.unknown(word, key.span(), properties, (name, &siblings)));
            }
        }
        let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
        for key in required.filter_map(Value::as_str) {
            // A misspelt key is not reported as missing.
            if !misspelt.contains(&key) && !table.iter().any(|(known, _)| known.get_ref() == key) {
                let what = properties.and_then(|properties| self.description(properties.get(key)?));
                let what = what.map_or_else(String::new, |what| format!(" ({what})"));
                self.faults.push(
                    Fault::at(span.clone(), format!("{name} lacks the key \"{key}\"{what}"))
                        .label(format!("needs {key}")),
                );
            }
        }
    }

    /// Returns the first sentence of the description of a key.
    fn description(&self, property: &'s Value) -> Option<String> {
        let text =
            property.get("description").or_else(|| self.resolve(property).get("description"))?.as_str()?;
        let text = text.replace('\n', " ");
        Some(text.split(". ").next()?.trim_end_matches('.').to_owned())
    }

    /// Reports an unknown key of a table with a name and keys; returns the key that was probably meant.
    fn unknown(
        &mut self,
        word: &str,
        span: Range<usize>,
        properties: Option<&'s Map<String, Value>>,
        (name, siblings): (&str, &[&str]),
    ) -> Option<&'s str> {
        let keys: Vec<&'s str> =
            properties.map(|properties| properties.keys().map(String::as_str).collect()).unwrap_or_default();
        let fault = Fault::at(span, format!("{name} has no key \"{word}\"")).label("unknown key");
        let is_always_there = name.starts_with("[[grains]]") || name.starts_with("[[wall]]");
        if is_always_there && ["stage", "stages"].contains(&word) {
            self.faults.push(fault.help("spheres and walls are there in all stages"));
            return None;
        }
        if name.starts_with("[[insertion]]") && ["stage", "stages"].contains(&word) {
            self.faults.push(fault.help("spheres come in at a time of the run: write from = …, in seconds"));
            return None;
        }
        if name.starts_with("[[delete]]") && ["stage", "stages"].contains(&word) {
            self.faults
                .push(fault.help("write from = … and until = …, in seconds from the start of the run"));
            return None;
        }
        let is_box = keys == ["max", "min"] || keys == ["min", "max"];
        if is_box && ["disc", "cylinder", "ball", "surface", "box", "sphere"].contains(&word) {
            self.faults.push(fault.help("this region is a box: write { min = […], max = […] }"));
            return None;
        }
        if let Some(help) = properties.and_then(|properties| self.inner(word, properties, siblings)) {
            self.faults.push(fault.help(help));
            return None;
        }
        if let Some(meant) = nearest(word, keys.iter().copied()) {
            self.faults.push(fault.help(format!("did you mean \"{meant}\"?")));
            return Some(meant);
        }
        // A table inside of another: a key of [[body]], such as a shape, is not always a key of an outline.
        let is_inner = name.starts_with('"');
        let elsewhere = self.tables().into_iter().find(|(_, keys)| keys.iter().any(|key| key == word));
        self.faults.push(match elsewhere {
            Some((table, _)) if !is_inner => fault.help(format!("it is a key of {table}")),
            _ => fault.help(format!("its keys are {}", keys.join(", "))),
        });
        None
    }

    /// Advice on a key that belongs into a table inside of this one, such as `holes` beside the shape: into
    /// one that is there, if it can have the key.
    fn inner(&self, word: &str, properties: &'s Map<String, Value>, siblings: &[&str]) -> Option<String> {
        let has = |property: &'s Value| {
            let keys = self.resolve(property).get("properties").and_then(Value::as_object);
            keys.is_some_and(|keys| keys.contains_key(word))
        };
        let tables: Vec<&str> =
            properties.iter().filter(|(_, property)| has(property)).map(|(key, _)| key.as_str()).collect();
        if let Some(table) = tables.iter().find(|table| siblings.contains(*table)) {
            return Some(format!("it is a key of {table}: write {table} = {{ …, {word} = … }}"));
        }
        let first = tables.first()?;
        Some(format!("it is a key of {}: {first} = {{ {word} = …, … }}", tables.join(", ")))
    }

    /// The tables of the file as they are written, with their keys.
    fn tables(&self) -> Vec<(String, Vec<String>)> {
        let properties = self.schema.get("properties").and_then(Value::as_object);
        let tables = properties.into_iter().flatten().map(|(name, property)| {
            let inner = self.resolve(property);
            let (title, table) = match inner.get("items") {
                Some(items) => (format!("[[{name}]]"), self.resolve(items)),
                None => (format!("[{name}]"), inner),
            };
            let keys = table.get("properties").and_then(Value::as_object);
            (title, keys.map(|keys| keys.keys().cloned().collect()).unwrap_or_default())
        });
        tables.collect()
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, schema: &'s Value, key: &str, parent: &str) {
        // Limits are beside the reference or the type.
        let outer = schema;
        let schema = self.resolve(schema);
        if let Some(branches) = branches(schema) {
            self.alternatives(value, schema, &branches, key, parent);
            return;
        }
        if let Some(words) = words(schema) {
            self.word(value, &words, key);
            return;
        }
        let types = types(schema);
        let fits = |kind: &str| types.contains(&kind);
        match value.get_ref() {
            DeValue::Table(table) if fits("object") => {
                let name = if parent == "the file" { format!("[{key}]") } else { format!("\"{key}\"") };
                self.table(table, value.span(), schema, &name);
            }
            DeValue::Array(list) if fits("array") => self.list(list, value.span(), schema, key, parent),
            DeValue::String(text) if fits("string") => {
                if text.trim().is_empty() && outer.get("minLength").is_some() {
                    self.faults.push(Fault::at(value.span(), format!("\"{key}\" is empty")));
                }
            }
            DeValue::Boolean(_) if fits("boolean") => {}
            DeValue::Integer(number) if fits("number") || fits("integer") => {
                let digits = i64::from_str_radix(&number.as_str().replace('_', ""), number.radix());
                match digits {
                    Ok(digits) => self.range(digits as f64, value.span(), outer, key),
                    Err(_) => {
                        self.faults.push(Fault::at(value.span(), format!("\"{key}\" is too large a number")));
                    }
                }
            }
            DeValue::Float(number) if fits("number") => {
                match number.as_str().replace('_', "").parse::<f64>() {
                    Ok(number) if number.is_finite() => self.range(number, value.span(), outer, key),
                    _ => self.faults.push(
                        Fault::at(value.span(), format!("\"{key}\" is not a finite number"))
                            .label("not finite"),
                    ),
                }
            }
            found => {
                let message = format!("\"{key}\" is {}, not {}", kind(found), self.expected(schema));
                let fault =
                    Fault::at(value.span(), message).label(format!("expected {}", self.expected(schema)));
                self.faults.push(fault.maybe_help(hint(found, schema, key, parent)));
            }
        }
    }

    fn list(
        &mut self,
        list: &toml::de::DeArray<'_>,
        span: Range<usize>,
        schema: &'s Value,
        key: &str,
        parent: &str,
    ) {
        let least = schema.get("minItems").and_then(Value::as_u64).unwrap_or(0) as usize;
        let most = schema.get("maxItems").and_then(Value::as_u64).map_or(usize::MAX, |most| most as usize);
        if list.len() < least || list.len() > most {
            let count = list.len();
            let message = if most == usize::MAX {
                format!("\"{key}\" is a list of {count}: it has to have at least {least} entries")
            } else {
                format!("\"{key}\" is a list of {count}, not {}", self.expected(schema))
            };
            let mut fault = Fault::at(span.clone(), message).label(format!("{count} entries"));
            if key == "points" {
                fault = fault.help(if least == 4 {
                    "a polyhedron has four corners or more"
                } else {
                    "a polygon has three corners or more"
                });
            }
            if most < 10 && list.len() == 2 * most {
                fault = fault.help("numbers have a decimal point; a comma separates entries: [0.5, 1.0]");
            }
            self.faults.push(fault);
            return;
        }
        let Some(items) = schema.get("items") else { return };
        for item in list {
            match item.get_ref() {
                DeValue::Table(table) if parent == "the file" => {
                    let name = match table.iter().find(|(key, _)| key.get_ref() == "name") {
                        Some((_, name)) if name.get_ref().is_str() => {
                            format!("[[{key}]] \"{}\"", name.get_ref().as_str().unwrap_or(""))
                        }
                        _ => format!("[[{key}]]"),
                    };
                    let inner = self.resolve(items);
                    self.table(table, item.span(), inner, &name);
                }
                _ => self.value(item, items, key, "a list"),
            }
        }
    }

    /// Checks a value against alternatives. If none fits, the faults are those of the alternative with the
    /// type of the value.
    fn alternatives(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        schema: &'s Value,
        branches: &[&'s Value],
        key: &str,
        parent: &str,
    ) {
        let before = self.faults.len();
        let mut candidate = None;
        for branch in branches {
            self.value(value, branch, key, parent);
            let found = self.faults.split_off(before);
            if found.is_empty() {
                return;
            }
            let inner = self.resolve(branch);
            let kind = json_kind(value.get_ref());
            let alike = types(inner).contains(&kind)
                || kind == "integer" && types(inner).contains(&"number")
                || kind == "string" && words(inner).is_some();
            if alike && candidate.is_none() {
                candidate = Some(found);
            }
        }
        let expected = self.expected(schema);
        let known: Vec<&str> =
            branches.iter().filter_map(|branch| words(self.resolve(branch))).flatten().collect();
        if let (DeValue::String(text), false) = (value.get_ref(), known.is_empty()) {
            let near = nearest(text, known).map(|word| format!("did you mean \"{word}\"?"));
            self.faults.push(
                Fault::at(value.span(), format!("\"{key}\" cannot be \"{text}\": it is {expected}"))
                    .label("unknown word")
                    .maybe_help(near),
            );
            return;
        }
        if let Some(found) = candidate {
            self.faults.extend(found);
            return;
        }
        let message = format!("\"{key}\" is {}, not {expected}", kind(value.get_ref()));
        let hint =
            branches.iter().find_map(|branch| hint(value.get_ref(), self.resolve(branch), key, parent));
        self.faults
            .push(Fault::at(value.span(), message).label(format!("expected {expected}")).maybe_help(hint));
    }

    fn word(&mut self, value: &Spanned<DeValue<'_>>, words: &[&str], key: &str) {
        let list = quoted(words);
        match value.get_ref() {
            DeValue::String(text) if words.contains(&text.as_ref()) => {}
            DeValue::String(text) => {
                let near = if text == "extrinsic" && words.contains(&"adaptive") {
                    // Its name in the literature is near to that of its opposite.
                    Some("adaptive")
                } else {
                    nearest(text, words.iter().copied())
                };
                self.faults.push(
                    Fault::at(value.span(), format!("\"{key}\" cannot be \"{text}\": it is {list}"))
                        .label("unknown word")
                        .maybe_help(near.map(|word| format!("did you mean \"{word}\"?"))),
                );
            }
            found => self.faults.push(
                Fault::at(value.span(), format!("\"{key}\" is {}, not {list}", kind(found)))
                    .label(format!("expected {list}")),
            ),
        }
    }

    fn range(&mut self, number: f64, span: Range<usize>, schema: &Value, key: &str) {
        if number.abs() > LARGEST {
            let most = exact(LARGEST);
            let message =
                format!("\"{key}\" is {}: numbers are in SI units and from -{most} to {most}", exact(number));
            self.faults.push(Fault::at(span, message).label("out of range"));
            return;
        }
        let limit = |name: &str| schema.get(name).and_then(Value::as_f64);
        let wrong = [
            ("minimum", "at least", number < limit("minimum").unwrap_or(f64::NEG_INFINITY)),
            ("exclusiveMinimum", "above", limit("exclusiveMinimum").is_some_and(|least| number <= least)),
            ("maximum", "at most", number > limit("maximum").unwrap_or(f64::INFINITY)),
            ("exclusiveMaximum", "below", limit("exclusiveMaximum").is_some_and(|most| number >= most)),
        ];
        for (name, text, is_wrong) in wrong {
            if let (true, Some(limit)) = (is_wrong, limit(name)) {
                let message = format!("\"{key}\" is {}: it has to be {text} {}", exact(number), exact(limit));
                self.faults.push(Fault::at(span.clone(), message).label("out of range"));
            }
        }
    }

    /// Describes the values that a schema allows.
    fn expected(&self, schema: &'s Value) -> String {
        let schema = self.resolve(schema);
        if let Some(words) = words(schema) {
            return quoted(&words);
        }
        if let Some(branches) = branches(schema) {
            let all: Vec<String> = branches.iter().map(|branch| self.expected(branch)).collect();
            let is_long = all.iter().any(|branch| branch.contains(", "));
            return all.join(if is_long { ", or " } else { " or " });
        }
        match types(schema).first().copied() {
            Some("number") => "a number".to_owned(),
            Some("integer") => "a whole number".to_owned(),
            Some("string") => "text in quotes".to_owned(),
            Some("boolean") => "true or false".to_owned(),
            Some("object") => "a table { }".to_owned(),
            Some("array") => {
                let items =
                    schema.get("items").map_or_else(|| "a value".to_owned(), |items| self.expected(items));
                let [least, most] =
                    ["minItems", "maxItems"].map(|key| schema.get(key).and_then(Value::as_u64));
                match (least, most) {
                    (Some(least), Some(most)) if least != most => {
                        format!("a list of {least} or {most}, each {items}")
                    }
                    (_, Some(most)) => format!("a list of {most}, each {items}"),
                    (_, None) => format!("a list, each entry {items}"),
                }
            }
            _ => "something else".to_owned(),
        }
    }
}

/// The alternatives of a schema, without `null`.
pub(crate) fn branches(schema: &Value) -> Option<Vec<&Value>> {
    let list = schema.get("anyOf").and_then(Value::as_array)?;
    Some(list.iter().filter(|branch| branch.get("type").and_then(Value::as_str) != Some("null")).collect())
}

/// The words of an enumeration.
pub(crate) fn words(schema: &Value) -> Option<Vec<&str>> {
    if let Some(list) = schema.get("enum").and_then(Value::as_array) {
        return Some(list.iter().filter_map(Value::as_str).collect());
    }
    if let Some(list) = schema.get("oneOf").and_then(Value::as_array) {
        let words: Option<Vec<&str>> = list.iter().map(|branch| branch.get("const")?.as_str()).collect();
        return words;
    }
    schema.get("const").and_then(Value::as_str).map(|word| vec![word])
}

pub(crate) fn types(schema: &Value) -> Vec<&str> {
    match schema.get("type") {
        Some(Value::String(kind)) => vec![kind],
        Some(Value::Array(kinds)) => {
            kinds.iter().filter_map(Value::as_str).filter(|kind| *kind != "null").collect()
        }
        _ => Vec::new(),
    }
}

fn quoted(words: &[&str]) -> String {
    let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match &words[..] {
        [words @ .., last] if !words.is_empty() => format!("{} or {last}", words.join(", ")),
        words => words.concat(),
    }
}

/// Describes a value.
fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

fn json_kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "string",
        DeValue::Integer(_) => "integer",
        DeValue::Float(_) => "number",
        DeValue::Boolean(_) => "boolean",
        DeValue::Datetime(_) => "date",
        DeValue::Array(_) => "array",
        DeValue::Table(_) => "object",
    }
}

/// Advice on the usual mistakes. `parent`: the table or list of the value.
fn hint(found: &DeValue<'_>, schema: &Value, key: &str, parent: &str) -> Option<String> {
    let wants = |kind: &str| types(schema).contains(&kind);
    match found {
        DeValue::Table(_) if wants("array") && schema.get("maxItems").is_none() => {
            Some(if parent == "the file" {
                format!("a table that may come several times has two brackets: [[{key}]]")
            } else {
                format!("a list has brackets around its tables: {key} = [{{ … }}]")
            })
        }
        DeValue::Array(list) if wants("object") && list.iter().any(|entry| entry.get_ref().is_table()) => {
            Some(if parent == "the file" {
                format!("this table comes once: [{key}], with one bracket")
            } else {
                format!("this table comes once: {key} = {{ … }}, without a bracket")
            })
        }
        DeValue::String(file) if key == "table" => {
            Some(format!("a CSV file of times and factors beside the model is table_file = \"{file}\""))
        }
        _ if wants("object") => form(schema, key, parent),
        DeValue::Float(_) if wants("integer") => Some("without a decimal point".to_owned()),
        _ => None,
    }
}

/// Advice on the form of a table: the keys that it needs, or an empty table if it needs none.
fn form(schema: &Value, key: &str, parent: &str) -> Option<String> {
    let keys = schema.get("properties").and_then(Value::as_object)?;
    let start = match parent {
        "the file" => return None,
        "a list" => String::new(),
        _ => format!("{key} = "),
    };
    let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
    let stands_for = |inner: &str| {
        let is_list = keys.get(inner).is_some_and(|inner| types(inner).contains(&"array"));
        format!("{inner} = {}", if is_list { "[…]" } else { "…" })
    };
    let required: Vec<String> = required.filter_map(Value::as_str).map(stands_for).collect();
    if required.is_empty() {
        let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
        return Some(format!("{start}{{}} has the defaults of its keys: {}", keys.join(", ")));
    }
    Some(format!("write {start}{{ {} }}", required.join(", ")))
}
