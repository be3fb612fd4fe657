//! Comments and documents are in plain English: patterns that readers stumble over stay away.
//!
//! [`PATTERNS`] lists them with the number of places that are still allowed, which may only shrink. Comments
//! also keep to the width of the code.

use std::fs;
use std::path::{Path, PathBuf};

use super::root;

/// A pattern: its name with a remedy, its matches in a sentence, and the largest number in all texts.
type Pattern = (&'static str, fn(&Sentence) -> usize, usize);

const PATTERNS: &[Pattern] = &[
    ("\"tell\" or \"told\": write reports, prints or shows", |of| of.words(&TELLING), 0),
    ("\"go on\": write continue", |of| of.pairs(&GOING, "on"), 0),
    ("\"so many\": write the name of the parameter", |of| of.pairs(&["so"], "many"), 0),
    ("\"those of\" twice in a sentence: name the things", |of| usize::from(of.chained()), 0),
    ("a possessive as a whole comment: name the thing", |of| usize::from(of.is_possessive()), 0),
    ("\"what\": name the thing", |of| of.words(&["what"]), 2),
];

const TELLING: [&str; 6] = ["told", "tell", "tells", "telling", "foretell", "foretells"];
const GOING: [&str; 5] = ["go", "goes", "going", "gone", "went"];

/// Width of comments, in characters, as of the code.
const WIDTH: usize = 110;

/// A sentence, or a paragraph of one sentence.
struct Sentence {
    words: Vec<String>,
    /// Whether it is a whole comment for documentation.
    is_alone: bool,
}

impl Sentence {
    fn new(text: &str, is_alone: bool) -> Self {
        let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
        Self { words: text.split_whitespace().map(bare).collect(), is_alone }
    }

    fn words(&self, words: &[&str]) -> usize {
        self.words.iter().filter(|word| words.contains(&word.as_str())).count()
    }

    fn pairs(&self, first: &[&str], second: &str) -> usize {
        self.words.windows(2).filter(|pair| first.contains(&pair[0].as_str()) && pair[1] == second).count()
    }

    fn chained(&self) -> bool {
        self.pairs(&["those", "that"], "of") >= 2 && self.pairs(&["those"], "of") >= 1
    }

    fn is_possessive(&self) -> bool {
        let first = self.words.first().map_or("", String::as_str);
        self.is_alone && self.words.len() <= 7 && ["its", "their", "those", "theirs"].contains(&first)
    }
}

#[test]
fn comments_and_documents_are_plain_english() {
    let mut found = vec![Vec::new(); PATTERNS.len()];
    for path in texts() {
        let name = path.strip_prefix(root()).unwrap().display().to_string();
        for (line, paragraph, is_doc) in paragraphs(&fs::read_to_string(&path).unwrap(), is_code(&path)) {
            for sentence in sentences(&paragraph) {
                let is_alone = is_doc && sentence.trim() == paragraph.trim();
                let of = Sentence::new(&sentence, is_alone);
                for (places, (_, count, _)) in found.iter_mut().zip(PATTERNS) {
                    places.extend((0..count(&of)).map(|_| format!("{name}:{line}: {sentence}")));
                }
            }
        }
    }
    let mut wrong = Vec::new();
    for (places, (name, _, most)) in found.iter().zip(PATTERNS) {
        if places.len() > *most {
            wrong.push(format!("{} places, {most} allowed: {name}\n{}", places.len(), places.join("\n")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn each_pattern_is_found() {
    let count =
        |text: &str| PATTERNS.iter().map(|(_, count, _)| count(&Sentence::new(text, true))).sum::<usize>();
    for text in [
        "The summary tells the peak.",
        "A run goes on with 64 ranks.",
        "Takes so many steps.",
        "The forces are those of contacts and those of joints.",
        "Its limits.",
        "Removes what is outside.",
    ] {
        assert_eq!(count(text), 1, "{text}");
    }
    assert_eq!(count("The limits of the region along the axis, and the height of that of a body."), 0);
}

/// Comments of at most 110 columns; tables, code and single words such as links may be longer.
#[test]
fn comments_keep_to_the_width_of_the_code() {
    let mut long = Vec::new();
    for path in texts().into_iter().filter(|path| is_code(path)) {
        let mut is_example = false;
        for (k, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            let Some((_, comment)) = comment(line) else { continue };
            is_example ^= comment.starts_with("```");
            let may_be_long = is_example || comment.starts_with('|') || comment.split(' ').count() < 3;
            if line.chars().count() > WIDTH && !may_be_long {
                long.push(format!("{}:{}", path.display(), k + 1));
            }
        }
    }
    assert!(long.is_empty(), "comments of more than {WIDTH} columns:\n{}", long.join("\n"));
}

fn is_code(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "rs")
}

/// All files of code and all documents.
fn texts() -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"]
        .map(|name| root().join(name))
        .into();
    let mut folders: Vec<PathBuf> =
        ["crates", "scenes", "bench", "fuzz", "book/src"].map(|name| root().join(name)).into();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let is_text = path.extension().is_some_and(|extension| extension == "rs" || extension == "md");
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if is_text && !path.ends_with("docs/words.rs") {
                found.push(path);
            }
        }
    }
    assert!(found.len() > 500, "only {} texts were found", found.len());
    found.sort();
    found
}

/// The kind of a comment that fills a line, and its text.
fn comment(line: &str) -> Option<(&str, &str)> {
    let line = line.trim_start();
    let kind = ["///", "//!", "//"].into_iter().find(|kind| line.starts_with(kind))?;
    Some((kind, line[kind.len()..].trim_start()))
}

/// Paragraphs of a document or of the comments of a file, without examples: the line, the text, and whether it
/// is a comment for documentation.
fn paragraphs(text: &str, is_code: bool) -> Vec<(usize, String, bool)> {
    let mut found: Vec<(usize, String, bool)> = Vec::new();
    let (mut is_example, mut is_open, mut last) = (false, false, "");
    for (k, line) in text.lines().enumerate() {
        let (kind, part) = match comment(line) {
            _ if !is_code => ("", line.trim()),
            Some(comment) => comment,
            None => {
                (is_open, is_example) = (false, false);
                continue;
            }
        };
        if part.starts_with("```") {
            (is_example, is_open) = (!is_example, false);
            continue;
        }
        let begins = part.starts_with(['|', '#', '-', '*']) || kind != last || !is_open;
        last = kind;
        is_open = !part.is_empty() && !part.starts_with('#');
        if is_example || part.is_empty() {
            continue;
        }
        match found.last_mut() {
            Some((_, paragraph, _)) if !begins => *paragraph = format!("{paragraph} {part}"),
            _ => found.push((k + 1, part.to_owned(), kind == "///")),
        }
    }
    found
}

/// The sentences of a paragraph, without code and quotations.
fn sentences(paragraph: &str) -> Vec<String> {
    let without = |text: &str, mark: char| text.split(mark).step_by(2).collect::<Vec<_>>().join("_");
    let plain = without(&without(paragraph, '`'), '"');
    let ends = plain.replace(". ", ".\n").replace("? ", "?\n").replace("; ", ";\n");
    ends.lines().map(str::to_owned).collect()
}
