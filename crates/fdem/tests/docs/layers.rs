//! The files of a crate import each other in layers: no files import each other in a circle.
//!
//! A file imports the files whose items it names. A name that another file only passes on, as `lib.rs` does
//! with `pub use`, is an import of the file that defines it. A file that passes a name on imports that file,
//! too.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::root;
use super::sources::{Crate, Module, crates, is_of_name};

/// A path that code names: the module in which the code is, the path, and the name that a `use` gives it.
struct Named {
    path: Module,
    name: Option<String>,
}

/// A file with the paths that it names, and with the modules inside it.
#[derive(Default)]
struct File {
    /// Paths in the crate, resolved as far as `crate`, `self`, `super` and modules of the file go.
    paths: Vec<Module>,
    /// The names that `use` brings into a module inside the file, and their paths; `*` for all names.
    uses: BTreeMap<Module, Vec<(String, Module)>>,
    /// The names of the items of each module inside the file.
    items: BTreeMap<Module, BTreeSet<String>>,
}

/// A crate as the test reads it.
struct Imports<'c> {
    of: &'c Crate,
    files: BTreeMap<&'c Module, File>,
}

/// The words before the name of an item.
const ITEMS: [&str; 9] = ["struct", "enum", "trait", "type", "fn", "const", "static", "union", "macro_rules"];

impl<'c> Imports<'c> {
    fn of(of: &'c Crate) -> Self {
        let files = of.files.iter().map(|(module, code)| (module, read(of, module, code))).collect();
        Self { of, files }
    }

    /// The file that a module is in: its own, or that of the module around it.
    fn file_of(&self, module: &[String]) -> &'c Module {
        let mut lengths = (0..=module.len()).rev();
        lengths.find_map(|length| self.of.files.get_key_value(&module[..length])).unwrap().0
    }

    fn is_module(&self, path: &[String]) -> bool {
        self.of.files.contains_key(path) || self.files[self.file_of(path)].items.contains_key(path)
    }

    /// The file that defines the name in a path of the crate. `depth`: how often names were passed on before.
    fn definer(&self, path: &[String], depth: usize) -> Option<&'c Module> {
        let mut module: Module = Vec::new();
        for (at, name) in path.iter().enumerate() {
            module.push(name.clone());
            if self.is_module(&module) {
                continue;
            }
            module.pop();
            let file = &self.files[self.file_of(&module)];
            if file.items.get(&module).is_some_and(|items| items.contains(name)) || depth > 10 {
                return Some(self.file_of(&module));
            }
            let uses = file.uses.get(&module).map_or(&[][..], Vec::as_slice);
            if let Some((_, target)) = uses.iter().find(|(used, _)| used == name) {
                // An empty path is that of another crate.
                let target = Some(target).filter(|target| !target.is_empty())?;
                return self.definer(&[target, &path[at + 1..]].concat(), depth + 1);
            }
            let of_all = uses.iter().filter(|(used, target)| used == "*" && !target.is_empty());
            return of_all
                .map(|(_, target)| [&target[..], &path[at..]].concat())
                .find_map(|path| self.defines(&path).then(|| self.definer(&path, depth + 1)).flatten())
                .or(Some(self.file_of(&module)));
        }
        Some(self.file_of(&module))
    }

    /// Whether the module of a path has its last name.
    fn defines(&self, path: &[String]) -> bool {
        let (name, module) = path.split_last().unwrap();
        let file = &self.files[self.file_of(module)];
        let uses = file.uses.get(module).map_or(&[][..], Vec::as_slice);
        self.is_module(path)
            || file.items.get(module).is_some_and(|items| items.contains(name))
            || uses.iter().any(|(used, _)| used == name)
    }

    /// The files that each file imports.
    fn edges(&self) -> BTreeMap<&'c Module, BTreeSet<&'c Module>> {
        let edges = self.files.iter().map(|(module, file)| {
            let of = file.paths.iter().filter_map(|path| self.definer(path, 0));
            (*module, of.filter(|of| of != module).collect())
        });
        edges.collect()
    }
}

/// Reads the paths, uses and items of a file.
fn read(of: &Crate, module: &Module, code: &str) -> File {
    let mut file = File::default();
    file.items.insert(module.clone(), BTreeSet::new());
    // The modules inside the file that are open, with the depth of their braces.
    let mut open: Vec<(usize, String)> = Vec::new();
    let (mut depth, mut at) = (0, 0);
    let mut last = "";
    while let Some(next) = code[at..].chars().next() {
        if !is_of_name(next) {
            match next {
                '{' => depth += 1,
                '}' => {
                    depth -= 1;
                    open.pop_if(|(inside, _)| depth < *inside);
                }
                _ => {}
            }
            at += next.len_utf8();
            continue;
        }
        let end = at + code[at..].find(|c| !is_of_name(c)).unwrap_or(code.len() - at);
        let word = &code[at..end];
        let here: Module = module.iter().chain(open.iter().map(|(_, name)| name)).cloned().collect();
        let is_top = depth == open.last().map_or(0, |(inside, _)| *inside);
        if word == "use" {
            let mut named = Vec::new();
            let rest = expand(&code[end..], Vec::new(), &mut named);
            at = code.len() - rest.len();
            for Named { path, name } in named {
                let path = absolute(of, &here, &path).unwrap_or_default();
                file.uses.entry(here.clone()).or_default().extend(name.map(|name| (name, path.clone())));
                file.paths.extend((!path.is_empty()).then_some(path));
            }
            last = "";
            continue;
        }
        if last == "mod" && code[end..].trim_start().starts_with('{') {
            open.push((depth + 1, word.to_owned()));
            file.items.entry([here.clone(), vec![word.to_owned()]].concat()).or_default();
        } else if ITEMS.contains(&last) && is_top {
            file.items.entry(here.clone()).or_default().insert(word.to_owned());
        }
        let follows = code[..at].ends_with("::") || code[..at].ends_with('.');
        if !follows && code[end..].starts_with("::") {
            let mut named = Vec::new();
            // A path in code has no groups.
            let stop = code[at..].find(|c: char| !is_of_name(c) && c != ':').unwrap_or(code.len() - at);
            expand(&code[at..at + stop], Vec::new(), &mut named);
            file.paths.extend(named.iter().filter_map(|named| absolute(of, &here, &named.path)));
        }
        last = word;
        at = end;
    }
    file
}

/// The path of the crate that code in a module means; `None` for the path of another crate.
fn absolute(of: &Crate, here: &Module, path: &[String]) -> Option<Module> {
    let mut from = here.clone();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => (from, rest) = (Vec::new(), &path[1..]),
        "self" | "super" => {
            while let Some(first) = rest.first().filter(|first| ["self", "super"].contains(&first.as_str())) {
                if first == "super" {
                    from.pop();
                }
                rest = &rest[1..];
            }
        }
        child => {
            from.push(child.to_owned());
            rest = of.files.contains_key(&from).then_some(&path[1..])?;
        }
    }
    from.extend_from_slice(rest);
    Some(from)
}

/// Adds the paths of `a::{b, c::d as e}`, which starts the text, to `found`, and returns the text behind it.
fn expand<'t>(mut text: &'t str, mut path: Module, found: &mut Vec<Named>) -> &'t str {
    loop {
        text = text.trim_start();
        if let Some(mut rest) = text.strip_prefix('{') {
            while let Some(next) =
                Some(rest.trim_start()).filter(|next| !next.starts_with('}') && !next.is_empty())
            {
                rest = expand(next, path.clone(), found).trim_start();
                rest = rest.find([',', '}']).map_or("", |end| rest[end..].trim_start_matches(','));
            }
            let rest = rest.trim_start();
            return rest.strip_prefix('}').unwrap_or(rest);
        }
        if let Some(rest) = text.strip_prefix('*') {
            found.push(Named { path, name: Some("*".to_owned()) });
            return rest;
        }
        let end = text.find(|c: char| !is_of_name(c)).unwrap_or(text.len());
        if text[..end] != *"self" || path.is_empty() {
            path.push(text[..end].to_owned());
        }
        text = &text[end..];
        if let Some(rest) = text.strip_prefix("::") {
            text = rest;
            continue;
        }
        let mut name = path.last().cloned();
        if let Some(rest) = text.trim_start().strip_prefix("as ") {
            let end = rest.find(|c: char| !is_of_name(c)).unwrap_or(rest.len());
            name = Some(rest[..end].to_owned());
            text = &rest[end..];
        }
        found.push(Named { path, name });
        return text;
    }
}

/// All files that a file imports, and those that they import.
fn reached<'m>(edges: &BTreeMap<&'m Module, BTreeSet<&'m Module>>, from: &'m Module) -> BTreeSet<&'m Module> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(next) = open.pop() {
        open.extend(edges[next].iter().filter(|of| found.insert(**of)));
    }
    found
}

/// The files that import themselves through others, each with the names that it imports of them.
fn circles(edges: &BTreeMap<&Module, BTreeSet<&Module>>) -> Vec<String> {
    let reach: BTreeMap<_, _> = edges.keys().map(|module| (*module, reached(edges, module))).collect();
    let inside = edges.iter().filter(|(module, _)| reach[*module].contains(*module));
    let lines = inside.map(|(module, imports)| {
        let back = imports.iter().filter(|of| reach[**of].contains(*module));
        let names: Vec<String> = back.map(|of| of.join("/")).collect();
        format!("    {} imports {}\n", module.join("/"), names.join(", "))
    });
    lines.collect()
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let (mut files, mut imports) = (0, 0);
    let mut wrong = Vec::new();
    for of in &crates(&root()) {
        let read = Imports::of(of);
        let edges = read.edges();
        files += edges.len();
        imports += edges.values().map(BTreeSet::len).sum::<usize>();
        let circles = circles(&edges);
        if !circles.is_empty() {
            wrong.push(format!("{}: {} files in circles\n", of.name, circles.len()));
            wrong.extend(circles);
        }
    }
    assert!(files > 500 && imports > 1500, "only {files} files with {imports} imports were found");
    assert!(wrong.is_empty(), "{}", wrong.concat());
}

#[test]
fn nor_do_files_of_the_python_package() {
    let mut imports: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for entry in fs::read_dir(root().join("crates/python/python/fdem")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "py") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().filter_map(|line| line.trim_start().strip_prefix("from ."));
        let of = lines.filter_map(|line| line.split_once(" import ")).flat_map(|(module, names)| {
            // `from . import _vtk` or `from ._vtk import plane`.
            let names = if module.is_empty() { names } else { module };
            names.split(',').map(|name| vec![name.trim().to_owned()])
        });
        imports.insert(vec![path.file_stem().unwrap().to_str().unwrap().to_owned()], of.collect());
    }
    let files: BTreeSet<&Module> = imports.keys().collect();
    let edges: BTreeMap<&Module, BTreeSet<&Module>> = imports
        .iter()
        .map(|(module, of)| (module, of.iter().filter(|of| files.contains(of)).collect()))
        .collect();
    let count: usize = edges.values().map(BTreeSet::len).sum();
    assert!(files.len() > 20 && count > 40, "only {} files with {count} imports", files.len());
    assert_eq!(circles(&edges).concat(), "");
}
