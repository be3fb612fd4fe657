//! Names of files and of types describe their contents.

use std::collections::{BTreeMap, BTreeSet};

use super::root;
use super::sources::{crates, is_of_name};

/// Words that name no thing: no file is called so.
const VAGUE_FILES: [&str; 9] = ["told", "begun", "lead", "facts", "near", "far", "kept", "shown", "scaled"];

/// Words that say of a type as little: only code in the same file uses such a type.
const VAGUE_TYPES: [&str; 10] =
    ["Found", "Given", "Kept", "Kind", "Known", "Near", "Part", "Parts", "Seen", "Told"];

/// Names that mean the same everywhere: the seal of a trait, a point of two or of three coordinates, and the
/// threads other than the caller's, of which there are none under Miri.
const STANDARD: [&str; 3] = ["Others", "Point", "Sealed"];

/// A type: its name, the file that defines it, and whether other files can use it.
struct Type {
    name: String,
    file: String,
    is_shared: bool,
}

/// The types of a file that are defined outside of functions.
fn types(code: &str, file: &str) -> Vec<Type> {
    let mut found = Vec::new();
    for line in code.lines() {
        let words: Vec<&str> = line.split(|c: char| !is_of_name(c)).filter(|word| !word.is_empty()).collect();
        let is_shared = line.starts_with("pub");
        let at = words.iter().position(|word| ["struct", "enum", "trait", "type", "union"].contains(word));
        // At the left margin, or with `pub` in a module inside the file.
        if let Some(at) = at.filter(|at| *at == 0 || words[0] == "pub" || words[0] == "unsafe")
            && (!line.starts_with(' ') || words[0] == "pub")
            && let Some(name) = words.get(at + 1)
        {
            found.push(Type { name: (*name).to_owned(), file: file.to_owned(), is_shared });
        }
    }
    found
}

#[test]
fn within_a_crate_a_name_stands_for_one_thing_and_says_of_what() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for of in &crates(&root()) {
        let files: BTreeMap<String, &String> =
            of.files.iter().map(|(module, code)| (module.join("/"), code)).collect();
        let mut faults = Vec::new();
        for file in files.keys() {
            if VAGUE_FILES.iter().any(|word| file.rsplit('/').next() == Some(*word)) {
                faults.push(format!("the file {file}"));
            }
        }
        let all: Vec<Type> = files.iter().flat_map(|(file, code)| types(code, file)).collect();
        let mut places: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for found in &all {
            count += 1;
            places.entry(&found.name).or_default().insert(&found.file);
            if found.is_shared && VAGUE_TYPES.contains(&found.name.as_str()) {
                faults.push(format!("{} in {}, which other files use", found.name, found.file));
            }
        }
        for (name, files) in places.iter().filter(|(name, files)| files.len() > 1 && !STANDARD.contains(name))
        {
            faults.push(format!("{name} in {}", files.iter().copied().collect::<Vec<_>>().join(", ")));
        }
        wrong.extend(faults.into_iter().map(|fault| format!("{}: {fault}", of.name)));
    }
    assert!(count > 800, "only {count} types were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
