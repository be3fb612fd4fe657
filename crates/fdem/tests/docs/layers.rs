//! The files of a crate import each other in layers: the front pages say so.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A module by its path in the crate: `["command", "run"]`; empty for the crate itself.
type Module = Vec<String>;

/// Adds the modules in a folder, with their code: without comments, and without the unit tests at the foot of
/// a file.
fn collect(folder: &Path, parent: &Module, found: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let mut module = parent.clone();
        module.push(path.file_stem().unwrap().to_str().unwrap().to_owned());
        if path.is_dir() {
            collect(&path, &module, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let code = text.lines().take_while(|line| !line.starts_with("#[cfg(") || !line.contains("test"));
            let code: Vec<&str> = code.map(|line| line.split("//").next().unwrap_or("")).collect();
            found.insert(module, code.join("\n"));
        }
    }
}

/// Adds the paths of `a::{b, c::d}`, which starts the text, to `found`, and returns the text behind it.
fn expand<'t>(mut text: &'t str, mut path: Module, found: &mut Vec<Module>) -> &'t str {
    loop {
        text = text.trim_start();
        if let Some(mut rest) = text.strip_prefix('{') {
            while let Some(next) =
                Some(rest.trim_start()).filter(|next| !next.starts_with('}') && !next.is_empty())
            {
                rest = expand(next, path.clone(), found).trim_start();
                rest = rest.find([',', '}']).map_or("", |end| rest[end..].trim_start_matches(','));
            }
            return rest.strip_prefix('}').unwrap_or(rest);
        }
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
        path.push(text[..end].to_owned());
        text = &text[end..];
        let Some(rest) = text.strip_prefix("::") else {
            found.push(path);
            return text;
        };
        text = rest;
    }
}

/// The paths in the crate that the code of a module names.
fn named(module: &Module, code: &str, modules: &BTreeMap<Module, String>) -> Vec<Module> {
    let parent = module[..module.len() - 1].to_vec();
    let children =
        modules.keys().filter(|child| child.len() == module.len() + 1 && child.starts_with(module));
    let mut starts = vec![("crate::".to_owned(), Vec::new()), ("super::".to_owned(), parent)];
    starts.extend(children.map(|child| (format!("{}::", child[module.len()]), child.clone())));
    let mut found = Vec::new();
    for (start, base) in starts {
        for (at, _) in code.match_indices(&start) {
            // The path of another crate, or of a longer name, that only ends so.
            let before = code[..at].chars().next_back();
            if !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                expand(&code[at + start.len()..], base.clone(), &mut found);
            }
        }
    }
    found
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let crates = [
        ("distributed", [10, 20]),
        ("fdem", [60, 200]),
        ("model", [60, 200]),
        ("simulation", [60, 300]),
        ("validate", [40, 100]),
    ];
    for (name, least) in crates {
        find_circles(name, least);
    }
}

/// Fails if files of the crate import each other in a circle. `least`: a crate has more files and imports than these.
fn find_circles(name: &str, least: [usize; 2]) {
    let mut modules = BTreeMap::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src");
    collect(&folder, &Vec::new(), &mut modules);
    let mut imports: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
    for (module, code) in &modules {
        for path in named(module, code, &modules) {
            let mut lengths = (1..=path.len()).rev();
            let of = lengths.find_map(|length| modules.get_key_value(&path[..length]));
            imports.entry(module).or_default().extend(of.map(|(of, _)| of).filter(|of| *of != module));
        }
    }
    let count: usize = imports.values().map(BTreeSet::len).sum();
    assert!(
        modules.len() > least[0] && count > least[1],
        "only {} files of {name} with {count} imports were found",
        modules.len()
    );
    // Takes out the files that import nothing that is left. The rest are circles, and the files above them.
    let mut left: BTreeSet<&Module> = modules.keys().collect();
    loop {
        let is_above = |module: &&Module| imports.get(*module).is_some_and(|of| !of.is_disjoint(&left));
        let next: BTreeSet<&Module> = left.iter().copied().filter(is_above).collect();
        if next.len() == left.len() {
            break;
        }
        left = next;
    }
    // Nor is it a circle if nothing that is left imports it.
    loop {
        let is_below = |module: &&Module| left.iter().any(|other| imports[other].contains(*module));
        let next: BTreeSet<&Module> = left.iter().copied().filter(is_below).collect();
        if next.len() == left.len() {
            break;
        }
        left = next;
    }
    let names: Vec<String> = left.iter().map(|module| module.join("/")).collect();
    assert!(names.is_empty(), "these import each other, or lie between circles: {}", names.join(", "));
}
