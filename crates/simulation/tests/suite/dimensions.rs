//! The crate is written once for two and three dimensions: only the module `simplex` knows how many there
//! are.

use std::fs;
use std::path::{Path, PathBuf};

/// Adds the files in `folder` and below it.
fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the sources are there") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, found);
        } else {
            found.push(path);
        }
    }
}

/// Whether a line compares `D`, the dimensions, or `N`, the corners of an element, with a number, or matches
/// on it.
fn asks(line: &str) -> bool {
    let code =
        line.split("//").next().unwrap_or("").replace("<=", "==").replace(">=", "==").replace("!=", "==");
    let words: Vec<&str> = code.split_whitespace().collect();
    let word = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric() && c != '_').to_owned();
    let is_number = |text: &str| word(text).parse::<usize>().is_ok();
    let is_dimension = |text: &str| ["D", "N"].contains(&word(text).as_str());
    let compared = words.windows(3).any(|three| {
        let [left, how, right] = three else { return false };
        ["==", "<", ">"].contains(how)
            && (is_dimension(left) && is_number(right) || is_number(left) && is_dimension(right))
    });
    let matched = words.windows(2).any(|two| two[0] == "match" && is_dimension(two[1]))
        || ["matches!(D,", "matches!(N,"].iter().any(|text| code.contains(text));
    compared || matched
}

#[test]
fn only_the_module_simplex_knows_whether_there_are_two_or_three_dimensions() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&root, &mut files);
    let is_simplex = |path: &PathBuf| {
        path.starts_with(root.join("simplex")) || path.file_name().is_some_and(|name| name == "simplex.rs")
    };
    let (simplex, others): (Vec<_>, Vec<_>) = files.into_iter().partition(is_simplex);
    assert!(simplex.len() > 2 && others.len() > 20, "all sources are found");
    let mut found = Vec::new();
    for path in others {
        let text = fs::read_to_string(&path).expect("a source is text");
        // Unit tests, at the foot of a file, may try both.
        let code = text.lines().take_while(|line| *line != "#[cfg(test)]");
        for (number, line) in code.enumerate().filter(|(_, line)| asks(line)) {
            found.push(format!("{}:{}: {}", path.display(), number + 1, line.trim()));
        }
    }
    assert!(
        found.is_empty(),
        "what differs between the dimensions belongs in simplex:\n{}",
        found.join("\n")
    );
}

#[test]
fn questions_about_the_dimensions_are_recognised() {
    for line in [
        "if D == 2 {",
        "pressed |= D > 2 && traction < 0.0;",
        "let last = if 3 <= D { 1 } else { 0 };",
        "if (N != 3) {",
        "match D {",
        "    if matches!(N, 3 | 4) {",
        "Plane::Stress if D == 2 => 1.0,",
    ] {
        assert!(asks(line), "{line}");
    }
    for line in [
        "for axis in 1..D {",
        "fn f<const D: usize, const N: usize>() {",
        "pub struct Model<const D: usize = 2, const N: usize = 3> {",
        "// if D == 2 {",
        "corner as usize % N == *at",
        "if axis < D {",
        "let a = k < 2 && b[D] > c;",
    ] {
        assert!(!asks(line), "{line}");
    }
}
