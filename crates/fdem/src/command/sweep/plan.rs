//! Sweep files: the model, the values, and the number of simultaneous runs.

use std::ops::Range;

use fdem_io::numbers::grouped;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::command::sweep::values::{self, Axis, Scale};
use crate::command::threads;
use fdem_model::{Fault, ModelErrors, Setting, constant, nearest, number, toml_tree, whole};

/// The keys of a sweep file.
const KEYS: [&str; 8] =
    ["model", "folder", "processes", "threads", "grid", "run", "table", "latin_hypercube"];

/// The keys that give the values of the runs, of which a sweep has one.
const KINDS: [&str; 4] = ["grid", "run", "table", "latin_hypercube"];

/// The keys of a range.
const RANGE: [&str; 4] = ["from", "to", "count", "scale"];

/// Most processes.
const MOST: f64 = 1024.0;

/// A sweep as its file has it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plan {
    /// The model file, relative to the folder of the sweep file.
    pub(crate) model: String,
    /// The folder of results, relative to the same folder; `None` for the default.
    pub(crate) folder: Option<String>,
    pub(crate) processes: Option<usize>,
    pub(crate) threads: Option<usize>,
    /// Names of the parameters.
    pub(crate) names: Vec<String>,
    /// Values of each run, in the order of the names.
    pub(crate) rows: Vec<Vec<Setting>>,
}

/// Reads the bytes of a file that a sweep names.
pub(crate) type Load<'l> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'l;

impl Plan {
    /// Reads a sweep file. `most`: largest number of runs.
    ///
    /// # Errors
    /// Everything that is wrong in the file, with its line.
    pub(crate) fn read(
        text: &str,
        name: &str,
        load: &mut Load<'_>,
        most: usize,
    ) -> Result<Self, ModelErrors> {
        let (document, faults) = toml_tree(text);
        let mut reader = Reader { faults, most };
        let plan = if reader.faults.is_empty() { reader.plan(&document, load) } else { None };
        match plan {
            Some(plan) if reader.faults.is_empty() => Ok(plan),
            _ => Err(ModelErrors::new(name, text, reader.faults)),
        }
    }
}

/// A key of a table, its place and its value.
type Entry<'t, 'a> = (&'t str, Range<usize>, &'t Spanned<DeValue<'a>>);

/// Like [`Entry`], with the whole path of a key.
type PathEntry<'t, 'a> = (String, Range<usize>, &'t Spanned<DeValue<'a>>);

/// Entries of a table in the order of the file.
fn ordered<'t, 'a>(table: &'t DeTable<'a>) -> Vec<Entry<'t, 'a>> {
    let mut entries: Vec<_> =
        table.iter().map(|(key, value)| (key.get_ref().as_ref(), key.span(), value)).collect();
    entries.sort_by_key(|(_, span, _)| span.start);
    entries
}

/// Adds a value, or those of a table that is a part of a path and no range.
fn flatten<'t, 'a>(
    name: String,
    span: Range<usize>,
    value: &'t Spanned<DeValue<'a>>,
    found: &mut Vec<PathEntry<'t, 'a>>,
) {
    let is_range = |table: &DeTable<'_>| {
        table.is_empty()
            || table
                .iter()
                .any(|(key, value)| RANGE.contains(&key.get_ref().as_ref()) && !value.get_ref().is_table())
    };
    match value.get_ref().as_table().filter(|table| !is_range(table)) {
        Some(table) => {
            for (key, span, value) in ordered(table) {
                flatten(format!("{name}.{key}"), span, value, found);
            }
        }
        None => found.push((name, span, value)),
    }
}

struct Reader {
    faults: Vec<Fault>,
    most: usize,
}

impl Reader {
    fn fault(&mut self, span: Range<usize>, message: impl Into<String>, help: Option<String>) {
        self.faults.push(Fault::at(span, message).maybe_help(help));
    }

    fn plan(&mut self, document: &Spanned<DeTable<'_>>, load: &mut Load<'_>) -> Option<Plan> {
        let entries = ordered(document.get_ref());
        for (key, span, _) in &entries {
            self.known(key, span.clone(), &KEYS, "a sweep file");
        }
        let end = document.span().end;
        let find =
            |wanted: &str| entries.iter().find(|(key, _, _)| *key == wanted).map(|(_, _, value)| *value);
        let model = find("model").and_then(|value| self.text("model", value));
        if find("model").is_none() {
            self.fault(
                end..end,
                "a sweep lacks the key \"model\" (the model file)",
                Some("model = \"disc.toml\"".into()),
            );
        }
        let folder = find("folder").and_then(|value| self.text("folder", value));
        let [processes, threads] =
            ["processes", "threads"].map(|key| self.count(key, find(key)?, 1.0).map(|count| count as usize));
        let kinds: Vec<_> = entries.iter().filter(|(key, _, _)| KINDS.contains(key)).collect();
        let before = self.faults.len();
        let (names, rows) = match &kinds[..] {
            [] => {
                let help = "it has one of [grid], [[run]], table = \"values.csv\" and [latin_hypercube]";
                self.fault(end..end, "a sweep has no values to run", Some(help.into()));
                return None;
            }
            [(key, span, value)] => match *key {
                "grid" => self.grid(value)?,
                "run" => self.runs(value)?,
                "table" => self.table(value, load)?,
                _ => self.hypercube(value, span.clone())?,
            },
            [_, others @ ..] => {
                for (key, span, _) in others {
                    let message = format!("\"{key}\" is a second kind of values: a sweep has one");
                    self.fault(span.clone(), message, Some(format!("it has one of {}", KINDS.join(", "))));
                }
                return None;
            }
        };
        let span = kinds.first().map_or(end..end, |(_, span, _)| span.clone());
        if rows.is_empty() {
            // Wrong values are reported already.
            if self.faults.len() == before {
                self.fault(span, "there is no run: the values are empty", None);
            }
            return None;
        }
        Some(Plan { model: model?, folder, processes, threads, names, rows })
    }

    /// Reports a key that does not exist.
    fn known(&mut self, key: &str, span: Range<usize>, keys: &[&str], what: &str) {
        if !keys.contains(&key) {
            let near = nearest(key, keys.iter().copied()).map(|near| format!("did you mean \"{near}\"?"));
            let help = near.unwrap_or_else(|| format!("its keys are {}", keys.join(", ")));
            self.faults.push(
                Fault::at(span, format!("{what} has no key \"{key}\"")).label("unknown key").help(help),
            );
        }
    }

    fn text(&mut self, key: &str, value: &Spanned<DeValue<'_>>) -> Option<String> {
        match value.get_ref().as_str() {
            Some(text) if !text.trim().is_empty() => Some(text.to_owned()),
            _ => {
                self.fault(
                    value.span(),
                    format!("\"{key}\" is the path of a file or a folder, in quotes"),
                    None,
                );
                None
            }
        }
    }

    /// A whole number from `least`.
    fn count(&mut self, key: &str, value: &Spanned<DeValue<'_>>, least: f64) -> Option<u64> {
        let most = if key == "seed" {
            9e15
        } else if key == "count" {
            1e9
        } else if key == "threads" {
            threads::most() as f64
        } else {
            MOST
        };
        let whole = number(value.get_ref()).filter(|whole| whole.fract() == 0.0);
        let fits = whole.filter(|whole| (least..=most).contains(whole));
        if fits.is_none() {
            let message = format!("\"{key}\" is a whole number from {least} to {most}");
            self.fault(value.span(), message, None);
        }
        fits.map(|whole| whole as u64)
    }

    fn entries<'t, 'a>(&mut self, key: &str, value: &'t Spanned<DeValue<'a>>) -> Option<Vec<Entry<'t, 'a>>> {
        let Some(table) = value.get_ref().as_table() else {
            self.fault(value.span(), format!("\"{key}\" is a table: [{key}]"), None);
            return None;
        };
        Some(ordered(table))
    }

    /// Names of parameters and paths of keys with their values. A path may be written with quotes or without
    /// them.
    fn named<'t, 'a>(
        &mut self,
        key: &str,
        value: &'t Spanned<DeValue<'a>>,
    ) -> Option<Vec<PathEntry<'t, 'a>>> {
        let mut found = Vec::new();
        for (name, span, value) in self.entries(key, value)? {
            flatten(name.to_owned(), span, value, &mut found);
        }
        found.sort_by_key(|(_, span, _)| span.start);
        for (name, span, _) in &found {
            if name.contains('=') || name.trim().is_empty() {
                let message = format!("\"{name}\" is no name of a parameter and no path of a key");
                self.fault(span.clone(), message, None);
            }
        }
        Some(found)
    }

    /// Reports more runs than are allowed.
    fn bounded(&mut self, span: Range<usize>, runs: f64) -> bool {
        if runs > self.most as f64 {
            let message = format!(
                "the sweep has {} runs, more than {}",
                if runs < 1e15 { grouped(runs as u64) } else { format!("{runs:.0e}") },
                grouped(self.most as u64)
            );
            self.fault(span, message, Some("--max-runs allows more".into()));
            return false;
        }
        true
    }

    /// All combinations. The last parameter of the file changes fastest.
    fn grid(&mut self, value: &Spanned<DeValue<'_>>) -> Option<(Vec<String>, Vec<Vec<Setting>>)> {
        let entries = self.named("grid", value)?;
        let mut names = Vec::new();
        let mut lists: Vec<Vec<Setting>> = Vec::new();
        let mut runs = 1.0;
        for (name, _, value) in entries {
            let name = name.as_str();
            names.push(name.to_owned());
            let list = match value.get_ref() {
                DeValue::Array(list) => {
                    if list.is_empty() {
                        self.fault(value.span(), format!("\"{name}\" has no values"), None);
                    }
                    list.iter().filter_map(|value| self.setting(name, value)).collect()
                }
                DeValue::Table(_) => self.spaced(name, value),
                _ => {
                    let help = "a list of values, or { from = 1, to = 2, count = 5 }";
                    self.fault(
                        value.span(),
                        format!("\"{name}\" is no list and no range"),
                        Some(help.into()),
                    );
                    Vec::new()
                }
            };
            runs *= list.len() as f64;
            lists.push(list);
        }
        if !self.bounded(value.span(), runs) {
            return None;
        }
        Some((names, values::product(&lists)))
    }

    /// The values of `{ from, to, count }`.
    fn spaced(&mut self, name: &str, value: &Spanned<DeValue<'_>>) -> Vec<Setting> {
        let Some((axis, entries)) = self.axis(name, value, &RANGE) else {
            return Vec::new();
        };
        let Some((_, _, count)) = entries.iter().find(|(key, _, _)| *key == "count") else {
            self.fault(value.span(), format!("\"{name}\" lacks \"count\" (the number of values)"), None);
            return Vec::new();
        };
        let Some(number) = self.count("count", count, 2.0) else { return Vec::new() };
        if !self.bounded(count.span(), number as f64) {
            return Vec::new();
        }
        axis.spaced(number).into_iter().map(Setting::Number).collect()
    }

    /// The range of `{ from, to, scale }`, and all its entries.
    fn axis<'t, 'a>(
        &mut self,
        name: &str,
        value: &'t Spanned<DeValue<'a>>,
        keys: &[&str],
    ) -> Option<(Axis, Vec<Entry<'t, 'a>>)> {
        let Some(table) = value.get_ref().as_table() else {
            let help = "a range is { from = 1, to = 2 }";
            self.fault(value.span(), format!("\"{name}\" is no range"), Some(help.into()));
            return None;
        };
        let entries = ordered(table);
        for (key, span, _) in &entries {
            self.known(key, span.clone(), keys, &format!("the range of \"{name}\""));
        }
        let find =
            |wanted: &str| entries.iter().find(|(key, _, _)| *key == wanted).map(|(_, _, value)| *value);
        let mut ends = Vec::new();
        for key in ["from", "to"] {
            let Some(end) = find(key) else {
                self.fault(value.span(), format!("the range of \"{name}\" lacks \"{key}\""), None);
                continue;
            };
            ends.push((self.end(name, end)?, end.span()));
        }
        let scale = match find("scale").map(|value| (value.get_ref().as_str(), value.span())) {
            None | Some((Some("linear"), _)) => Scale::Linear,
            Some((Some("log"), _)) => Scale::Logarithmic,
            Some((_, span)) => {
                self.fault(span, "\"scale\" is \"linear\" or \"log\"", None);
                return None;
            }
        };
        let [((from, of), _), ((to, other), span)] = &ends[..] else { return None };
        if of.is_some() && other.is_some() && of != other {
            self.fault(
                span.clone(),
                format!("\"{name}\" goes from {} to {}", said(of.as_deref()), said(other.as_deref())),
                None,
            );
            return None;
        }
        if from == to {
            self.fault(span.clone(), format!("the range of \"{name}\" is empty: both ends are {from}"), None);
            return None;
        }
        if scale == Scale::Logarithmic && (*from <= 0.0 || *to <= 0.0) {
            let message = format!("the range of \"{name}\" is logarithmic: both ends have to be above 0");
            self.fault(value.span(), message, None);
            return None;
        }
        Some((Axis { from: *from, to: *to, scale }, entries))
    }

    /// An end of a range: its number, and its dimension if it has a unit.
    fn end(&mut self, name: &str, value: &Spanned<DeValue<'_>>) -> Option<(f64, Option<String>)> {
        let found = match value.get_ref() {
            DeValue::String(text) => constant(text),
            other => number(other)
                .map(|found| (found, None))
                .ok_or_else(|| format!("the ends of the range of \"{name}\" are numbers")),
        };
        match found {
            Ok((number, dimension)) if number.is_finite() => Some((number, dimension)),
            Ok(_) => {
                self.fault(
                    value.span(),
                    format!("an end of the range of \"{name}\" is not a finite number"),
                    None,
                );
                None
            }
            Err(why) => {
                self.fault(value.span(), why, None);
                None
            }
        }
    }

    fn setting(&mut self, name: &str, value: &Spanned<DeValue<'_>>) -> Option<Setting> {
        let found = match value.get_ref() {
            // The same as on a command line, where the process of the run reads it.
            DeValue::String(text) => Some(Setting::parse(text)),
            DeValue::Boolean(flag) => Some(Setting::Flag(*flag)),
            whole_number @ DeValue::Integer(_) => whole(whole_number).map(Setting::Whole),
            other => number(other).map(Setting::Number),
        };
        if found.is_none() {
            let message = format!("a value of \"{name}\" is a finite number, a text, true or false");
            self.fault(value.span(), message, None);
        }
        found
    }

    /// The runs of `[[run]]`, which have the same names.
    fn runs(&mut self, value: &Spanned<DeValue<'_>>) -> Option<(Vec<String>, Vec<Vec<Setting>>)> {
        let list = value.get_ref().as_array().filter(|list| list.iter().all(|run| run.get_ref().is_table()));
        let Some(list) = list else {
            self.fault(value.span(), "\"run\" is a table with two brackets: [[run]]", None);
            return None;
        };
        if !self.bounded(value.span(), list.len() as f64) {
            return None;
        }
        let mut names: Vec<String> = Vec::new();
        let mut rows = Vec::new();
        for (number, run) in list.iter().enumerate() {
            let entries = self.named("run", run)?;
            if number == 0 {
                names = entries.iter().map(|(name, _, _)| name.clone()).collect();
            }
            for (name, span, _) in
                entries.iter().filter(|(name, _, _)| !names.iter().any(|known| known == name))
            {
                self.fault(
                    span.clone(),
                    format!("the first [[run]] has no \"{name}\": all have the same names"),
                    None,
                );
            }
            let mut row = Vec::new();
            for name in &names {
                match entries.iter().find(|(key, _, _)| key == name) {
                    Some((_, _, value)) => row.extend(self.setting(name, value)),
                    None => self.fault(
                        run.span(),
                        format!("[[run]] number {} lacks \"{name}\"", number + 1),
                        None,
                    ),
                }
            }
            rows.push(row);
        }
        if names.is_empty() {
            self.fault(value.span(), "[[run]] has no values", None);
            return None;
        }
        Some((names, rows))
    }

    /// The rows of a CSV file.
    fn table(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        load: &mut Load<'_>,
    ) -> Option<(Vec<String>, Vec<Vec<Setting>>)> {
        let file = self.text("table", value)?;
        let read = load(&file).and_then(|bytes| values::csv(&bytes, self.most));
        match read {
            Ok((names, rows)) => Some((names, rows)),
            Err(why) => {
                self.fault(value.span(), format!("{file}: {why}"), None);
                None
            }
        }
    }

    /// A Latin hypercube: `count`, `seed` and `ranges`.
    fn hypercube(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        heading: Range<usize>,
    ) -> Option<(Vec<String>, Vec<Vec<Setting>>)> {
        let entries = self.entries("latin_hypercube", value)?;
        for (key, span, _) in &entries {
            self.known(key, span.clone(), &["count", "seed", "ranges"], "[latin_hypercube]");
        }
        let find =
            |wanted: &str| entries.iter().find(|(key, _, _)| *key == wanted).map(|(_, _, value)| *value);
        let (Some(count), Some(ranges)) = (find("count"), find("ranges")) else {
            let help = "count = 20 and ranges = { strength = { from = 5e6, to = 9e6 } }";
            self.fault(heading, "[latin_hypercube] needs \"count\" and \"ranges\"", Some(help.into()));
            return None;
        };
        let points = self.count("count", count, 1.0)?;
        let seed = match find("seed") {
            Some(seed) => self.count("seed", seed, 0.0)?,
            None => 1,
        };
        if !self.bounded(count.span(), points as f64) {
            return None;
        }
        let mut axes = Vec::new();
        for (name, _, value) in self.named("ranges", ranges)? {
            let (axis, _) = self.axis(&name, value, &["from", "to", "scale"])?;
            axes.push((name, axis));
        }
        if axes.is_empty() {
            self.fault(ranges.span(), "\"ranges\" is empty", None);
            return None;
        }
        let rows = values::latin_hypercube(&axes, points, seed);
        Some((axes.into_iter().map(|(name, _)| name).collect(), rows))
    }
}

/// A dimension in words.
fn said(dimension: Option<&str>) -> &str {
    dimension.unwrap_or("a plain number")
}
