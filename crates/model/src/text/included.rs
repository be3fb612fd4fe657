//! Files that a model includes.
//!
//! [`Sources::gather`] reads the included files, which may include others, and puts all texts one after the
//! other, so that a place is a range of bytes as in one file. [`Sources::parse`] parses each text and merges
//! the trees: lists of tables come one after the other, included files first; in other tables the including
//! file wins.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use crate::text::document::Document;
use crate::text::fault::Fault;

/// Gives the bytes of a file that a model names, or says why it cannot.
pub type Load<'l> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'l;

/// The key whose value names files.
const INCLUDE: &str = "include";

/// Keys whose text is the path of a file, relative to the file that has the key.
const PATHS: [&str; 3] = ["mesh", "surface", "file"];

/// Most files that include each other in a chain.
const DEEPEST: usize = 20;

/// Most included files.
const MOST: usize = 200;

/// Most bytes of all files together.
const LARGEST: usize = 64 << 20;

/// A model file with the files that it includes.
pub(crate) struct Sources<'t> {
    /// All texts, each after a line break.
    pub(crate) text: Cow<'t, str>,
    /// The model file, then the included ones.
    files: Vec<IncludedFile>,
    /// Files that cannot be included.
    faults: Vec<Fault>,
}

struct IncludedFile {
    /// Path relative to the folder of the model; empty for the model file itself.
    path: String,
    place: Range<usize>,
    /// Numbers of the files that it includes, in their order.
    includes: Vec<usize>,
}

impl<'t> Sources<'t> {
    /// Reads all included files.
    pub(crate) fn gather(text: &'t str, load: &mut Load<'_>) -> Self {
        let main = IncludedFile { path: String::new(), place: 0..text.len(), includes: Vec::new() };
        let mut sources = Self { text: Cow::Borrowed(text), files: vec![main], faults: Vec::new() };
        if text.contains(INCLUDE) {
            sources.follow(&mut vec![0], load);
        }
        sources
    }

    /// The paths of the included files, and where their texts begin.
    pub(crate) fn included(&self) -> Vec<(String, usize)> {
        self.files[1..].iter().map(|file| (file.path.clone(), file.place.start)).collect()
    }

    /// Whether a place is in the model file itself.
    pub(crate) fn is_in_model(&self, span: &Range<usize>) -> bool {
        span.start <= self.files[0].place.end
    }

    /// The model as one document. Also returns the lines that are not TOML, and the files that cannot be
    /// included.
    pub(crate) fn parse(&self) -> (Document<'_>, Vec<Fault>) {
        let (mut document, mut faults) = Document::parse(&self.text[self.files[0].place.clone()]);
        faults.extend(self.faults.iter().cloned());
        if self.files.len() > 1 {
            let own = std::mem::take(document.root_mut().get_mut());
            let merged = self.merged(0, own, &mut faults);
            *document.root_mut().get_mut() = merged;
        }
        (document, faults)
    }

    /// A file merged with all that it includes.
    fn merged<'a>(&'a self, number: usize, own: DeTable<'a>, faults: &mut Vec<Fault>) -> DeTable<'a> {
        let mut merged = DeTable::new();
        for &number in &self.files[number].includes {
            let file = &self.files[number];
            let start = file.place.start;
            let (mut document, found) = Document::parse(&self.text[file.place.clone()]);
            faults.extend(found.into_iter().map(|fault| Fault {
                span: fault.span.map(|span| span.start + start..span.end + start),
                ..fault
            }));
            let root = std::mem::take(document.root_mut().get_mut());
            let root = moved_table(root, start, folder(&file.path));
            let root = self.merged(number, root, faults);
            merged = merge(merged, root, true, faults);
        }
        merge(merged, own, true, faults)
    }

    /// Reads the includes of the last file of a chain.
    fn follow(&mut self, chain: &mut Vec<usize>, load: &mut Load<'_>) {
        let Some(&number) = chain.last() else { return };
        let start = self.files[number].place.start;
        let text = self.text[self.files[number].place.clone()].to_owned();
        let (document, _) = Document::parse(&text);
        // The schema sees the value of the model file alone.
        if let Some(span) = no_names(&document).filter(|_| number > 0) {
            let fault = Fault::at(span.start + start..span.end + start, "\"include\" is no text in quotes");
            self.faults.push(fault.help("it is the path of a file, or a list of paths"));
        }
        for (name, span) in entries(&document) {
            let span = span.start + start..span.end + start;
            let path = joined(folder(&self.files[number].path), &name);
            if chain.iter().any(|&other| self.files[other].path == path) {
                self.circle(chain, &path, span);
                continue;
            }
            if self.files.iter().any(|file| file.path == path) {
                // It has been included by another file.
                continue;
            }
            let text = match self.load(&path, chain.len(), load) {
                Ok(text) => text,
                Err(why) => {
                    let message = format!("cannot include {name}: {why}");
                    self.faults.push(Fault::at(span, message).label("cannot be included"));
                    continue;
                }
            };
            // The model file itself has no path that an included file could name.
            if text == self.text[self.files[0].place.clone()] {
                self.circle(chain, &path, span);
                continue;
            }
            let all = self.text.to_mut();
            all.push('\n');
            let place = all.len()..all.len() + text.len();
            all.push_str(&text);
            let new = self.files.len();
            self.files.push(IncludedFile { path, place, includes: Vec::new() });
            self.files[number].includes.push(new);
            chain.push(new);
            self.follow(chain, load);
            chain.pop();
        }
    }

    fn load(&self, path: &str, depth: usize, load: &mut Load<'_>) -> Result<String, String> {
        if depth > DEEPEST {
            return Err(format!("more than {DEEPEST} files include each other in a chain"));
        }
        if self.files.len() > MOST {
            return Err(format!("the model includes more than {MOST} files"));
        }
        let bytes = load(path)?;
        if self.text.len() + bytes.len() > LARGEST {
            return Err("the model and the files that it includes are larger than 64 MiB".to_owned());
        }
        String::from_utf8(bytes).map_err(|_| "it is not UTF-8 text".to_owned())
    }

    /// Reports a file that includes itself.
    fn circle(&mut self, chain: &[usize], path: &str, span: Range<usize>) {
        let start = chain.iter().position(|&number| self.files[number].path == path).unwrap_or(0);
        let names = chain[start..].iter().map(|&number| self.files[number].path.as_str());
        let names = names.map(|name| if name.is_empty() { "the model" } else { name }).chain([path]);
        let names = names.collect::<Vec<_>>().join(" -> ");
        let message = format!("files include each other in a circle: {names}");
        self.faults.push(Fault::at(span, message).label("in a circle"));
    }
}

/// The files that a document includes, with the places of their names. The schema reports values that are not
/// text.
fn entries(document: &Document<'_>) -> Vec<(String, Range<usize>)> {
    let include = document.root().get_ref().iter().find(|(key, _)| key.get_ref() == INCLUDE);
    let Some((_, value)) = include else { return Vec::new() };
    let name = |value: &Spanned<DeValue<'_>>| Some((value.get_ref().as_str()?.to_owned(), value.span()));
    match value.get_ref() {
        DeValue::Array(list) => list.iter().filter_map(name).collect(),
        _ => name(value).into_iter().collect(),
    }
}

/// The place of a value of `include` that is neither a text nor a list of texts.
fn no_names(document: &Document<'_>) -> Option<Range<usize>> {
    let include = document.root().get_ref().iter().find(|(key, _)| key.get_ref() == INCLUDE);
    let (_, value) = include?;
    let fits = match value.get_ref() {
        DeValue::Array(list) => list.iter().all(|name| name.get_ref().is_str()),
        other => other.is_str(),
    };
    (!fits).then(|| value.span())
}

/// The folder of a path, with its last slash; empty if the path has none.
fn folder(path: &str) -> &str {
    &path[..path.rfind('/').map_or(0, |slash| slash + 1)]
}

/// A path relative to a folder, without `.`, and without `..` where that is possible.
fn joined(folder: &str, name: &str) -> String {
    if Path::new(name).is_absolute() {
        return name.to_owned();
    }
    let whole = format!("{folder}{name}");
    let mut parts: Vec<&str> = Vec::new();
    for part in whole.split('/') {
        match part {
            "." => {}
            ".." if parts.last().is_some_and(|last| !last.is_empty() && *last != "..") => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// A table whose text begins at `by`, with paths that are relative to the folder of the model.
fn moved_table<'a>(table: DeTable<'a>, by: usize, folder: &str) -> DeTable<'a> {
    let entries = table.into_iter().map(|(key, value)| {
        let is_path = PATHS.contains(&key.get_ref().as_ref());
        let span = key.span();
        let key = Spanned::new(span.start + by..span.end + by, key.into_inner());
        (key, moved(value, by, folder, is_path))
    });
    entries.collect()
}

fn moved<'a>(value: Spanned<DeValue<'a>>, by: usize, folder: &str, is_path: bool) -> Spanned<DeValue<'a>> {
    let span = value.span();
    let value = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(moved_table(table, by, folder)),
        DeValue::Array(list) => {
            let mut out = DeArray::new();
            list.into_iter().for_each(|value| out.push(moved(value, by, folder, false)));
            DeValue::Array(out)
        }
        DeValue::String(path) if is_path && !folder.is_empty() => {
            DeValue::String(Cow::Owned(joined(folder, &path)))
        }
        other => other,
    };
    Spanned::new(span.start + by..span.end + by, value)
}

/// Adds the entries of a table to another, and wins over them. At the top, lists are put together.
fn merge<'a>(into: DeTable<'a>, from: DeTable<'a>, is_top: bool, faults: &mut Vec<Fault>) -> DeTable<'a> {
    let mut entries: BTreeMap<String, _> =
        into.into_iter().map(|(key, value)| (key.get_ref().to_string(), (key, value))).collect();
    for (key, value) in from {
        let name = key.get_ref().to_string();
        let Some((old_key, old)) = entries.remove(&name) else {
            entries.insert(name, (key, value));
            continue;
        };
        let span = value.span();
        let is_list = is_top && name != INCLUDE;
        let value = match (old.into_inner(), value.into_inner()) {
            (DeValue::Table(old), DeValue::Table(new)) => DeValue::Table(merge(old, new, false, faults)),
            (DeValue::Array(mut old), DeValue::Array(new)) if is_list => {
                new.into_iter().for_each(|value| old.push(value));
                DeValue::Array(old)
            }
            (old, new) => {
                if is_list && !new.same_type(&old) {
                    let message = format!("\"{name}\" is a table in one file and a list in another");
                    let help = format!("a table that may come several times has two brackets: [[{name}]]");
                    let spans = [old_key.span(), key.span()];
                    faults.extend(spans.map(|span| Fault::at(span, message.clone()).help(&help[..])));
                }
                new
            }
        };
        entries.insert(name, (key, Spanned::new(span, value)));
    }
    entries.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_file_that_names_them() {
        for (folder, name, path) in [
            ("", "a.toml", "a.toml"),
            ("", "./a.toml", "a.toml"),
            ("", "../a.toml", "../a.toml"),
            ("lib/", "a.toml", "lib/a.toml"),
            ("lib/", "../a.toml", "a.toml"),
            ("../lib/", "../../a.toml", "../../a.toml"),
            ("lib/rock/", "../a/../b.toml", "lib/b.toml"),
        ] {
            assert_eq!(joined(folder, name), path, "{folder} {name}");
        }
    }
}
