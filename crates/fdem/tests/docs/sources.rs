//! The source files of all crates, as the tests of layers and names read them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A module by its path in the crate: `["command", "run"]`; empty for the root.
pub(crate) type Module = Vec<String>;

/// The code of a crate: a library or a program.
#[derive(Debug)]
pub(crate) struct Crate {
    /// Its root file without `.rs`, from the root of the repository: `crates/io/src/lib`.
    pub(crate) name: String,
    /// The code of each file, without comments, texts and unit tests.
    pub(crate) files: BTreeMap<Module, String>,
}

/// All libraries and programs of the repository at `root`.
pub(crate) fn crates(root: &Path) -> Vec<Crate> {
    let mut folders: Vec<PathBuf> =
        fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.extend(["scenes", "bench", "fuzz"].map(|name| root.join(name)));
    folders.sort();
    let mut found = Vec::new();
    for folder in folders {
        let source = folder.join("src");
        let mut roots = vec![source.join("lib.rs")];
        for entry in fs::read_dir(source.join("bin")).into_iter().flatten() {
            let path = entry.unwrap().path();
            roots.push(if path.is_dir() { path.join("main.rs") } else { path });
        }
        for file in roots.into_iter().filter(|file| file.exists()) {
            let name = file.strip_prefix(root).unwrap().with_extension("");
            let name = name.to_str().unwrap().replace('\\', "/");
            let mut files = BTreeMap::new();
            files.insert(Module::new(), code(&fs::read_to_string(&file).unwrap()));
            if ["lib", "main"].contains(&file.file_stem().unwrap().to_str().unwrap()) {
                collect(file.parent().unwrap(), &Module::new(), &mut files);
            }
            found.push(Crate { name, files });
        }
    }
    found
}

/// Adds the files in a folder of a crate, and in the folders below it.
fn collect(folder: &Path, parent: &Module, found: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if parent.is_empty() && ["lib", "main", "bin"].contains(&stem.as_str()) {
            continue;
        }
        let module = [parent.clone(), vec![stem]].concat();
        if path.is_dir() {
            collect(&path, &module, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.insert(module, code(&fs::read_to_string(&path).unwrap()));
        }
    }
}

/// Code without comments, texts and unit tests.
fn code(text: &str) -> String {
    without_tests(&without_comments(text))
}

/// Code whose comments and texts are gone; of a text its quotes remain.
fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if next == '"' {
            code.push_str("\"\"");
            end_of_text(rest)
        } else if let Some(end) = end_of_raw_text(rest).filter(|_| !code.ends_with(is_of_name)) {
            code.push_str("\"\"");
            end
        } else if let Some(end) = end_of_character(rest) {
            code.push_str("' '");
            end
        } else {
            code.push(next);
            next.len_utf8()
        };
        rest = &rest[skipped..];
    }
    code
}

/// Where a text that starts here ends: its quotes may be escaped.
fn end_of_text(text: &str) -> usize {
    let mut escaped = false;
    for (at, next) in text.char_indices().skip(1) {
        match next {
            '"' if !escaped => return at + 1,
            _ => escaped = next == '\\' && !escaped,
        }
    }
    text.len()
}

/// Where a text like `r#"…"#` that starts here ends.
fn end_of_raw_text(text: &str) -> Option<usize> {
    let inside = text.strip_prefix("br").or_else(|| text.strip_prefix('r'))?;
    let hashes = inside.len() - inside.trim_start_matches('#').len();
    inside[hashes..].strip_prefix('"')?;
    let start = text.len() - inside.len() + hashes + 1;
    let end = format!("\"{}", "#".repeat(hashes));
    Some(text[start..].find(&end).map_or(text.len(), |at| start + at + end.len()))
}

/// Where a character like `'{'` that starts here ends. Lifetimes are not characters.
fn end_of_character(text: &str) -> Option<usize> {
    let inside = text.strip_prefix('\'')?;
    if inside.starts_with('\\') {
        return inside[2..].find('\'').map(|end| end + 4);
    }
    let first = inside.chars().next()?.len_utf8();
    inside[first..].starts_with('\'').then_some(first + 2)
}

/// Code without the items that are compiled for tests only.
fn without_tests(code: &str) -> String {
    let mut left = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(") {
        let end = at + rest[at..].find(")]").map_or(rest.len() - at, |end| end + 2);
        let is_of_tests = rest[at..end].split(|c: char| !is_of_name(c)).any(|word| word == "test")
            && !rest[at..end].contains("not(test)");
        left.push_str(&rest[..at]);
        if is_of_tests {
            let item = &rest[end..];
            let stop = item.find(['{', ';']).unwrap_or(item.len());
            rest = &item[if item[stop..].starts_with('{') { end_of_block(item, stop) } else { stop + 1 }..];
        } else {
            left.push_str(&rest[at..end]);
            rest = &rest[end..];
        }
    }
    left + rest
}

/// Where the block that starts at `start` ends.
fn end_of_block(code: &str, start: usize) -> usize {
    let mut depth = 0;
    for (at, next) in code[start..].char_indices() {
        match next {
            '{' => depth += 1,
            '}' if depth == 1 => return start + at + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    code.len()
}

/// Whether a character can be in a name.
pub(crate) fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}
