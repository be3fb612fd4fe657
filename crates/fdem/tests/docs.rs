//! The promises of the documents: paths exist, commands run, the version is the same everywhere.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use fdem::model::AnyPrepared;

#[path = "../examples/book_figures/main.rs"]
mod book_figures;
#[path = "docs/fields.rs"]
mod fields;
#[path = "docs/figures.rs"]
mod figures;
#[path = "docs/layers.rs"]
mod layers;
#[path = "docs/materials.rs"]
mod materials;
#[path = "docs/model_keys.rs"]
mod model_keys;
#[path = "docs/names.rs"]
mod names;
#[path = "docs/sources.rs"]
mod sources;
#[path = "docs/step.rs"]
mod step;
#[path = "docs/words.rs"]
mod words;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap()
}

/// The pages of the book, by their paths.
fn pages() -> Vec<String> {
    let summary = read("book/src/SUMMARY.md");
    let pages = summary.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    pages.map(|page| format!("book/src/{page}")).collect()
}

/// Every `path/like/this` in backticks and every link between our own files.
#[test]
fn every_path_that_a_document_names_exists() {
    let mut checked = 0;
    let pages = pages();
    let documents = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "book/src/SUMMARY.md"];
    for document in documents.into_iter().chain(pages.iter().map(String::as_str)) {
        let text = read(document);
        let folder = Path::new(document).parent().unwrap();
        let quoted = text.split('`').skip(1).step_by(2).filter(|quoted| is_path(quoted));
        let linked = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for link in quoted.chain(linked.filter(|link| !link.contains("://"))) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            // Paths in backticks are of the repository, links of the page that they are on.
            let linked = if path.is_empty() { document.into() } else { folder.join(path) };
            let path = if root().join(path).exists() && !path.is_empty() { path.into() } else { linked };
            assert!(root().join(&path).exists(), "{document} names {link}, which does not exist");
            if !heading.is_empty() {
                let headings = read(path.to_str().unwrap())
                    .lines()
                    .filter(|line| line.starts_with('#'))
                    .map(anchor)
                    .collect::<Vec<_>>();
                assert!(
                    headings.iter().any(|anchor| anchor == heading),
                    "{document} names {link}: {headings:?}"
                );
            }
            checked += 1;
        }
    }
    assert!(checked > 60, "only {checked} paths were found: has the format of the documents changed?");
}

/// Every `src/like/this.rs` on the front page of a crate, in the documentation at the head of its `lib.rs`,
/// and every path from the root.
#[test]
fn every_path_that_a_front_page_names_exists() {
    let mut checked = 0;
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let text = fs::read_to_string(folder.join("src/lib.rs")).unwrap();
        let page: Vec<&str> = text.lines().take_while(|line| line.starts_with("//!")).collect();
        for quoted in page.join("\n").split('`').skip(1).step_by(2) {
            let inside = ["src/", "tests/", "python/"].iter().any(|start| quoted.starts_with(start));
            if is_path(quoted) || inside {
                let path = if inside { folder.join(quoted) } else { root().join(quoted) };
                assert!(path.exists(), "the front page of {} names {quoted}", folder.display());
                checked += 1;
            }
        }
    }
    assert!(checked > 100, "only {checked} paths were found: has the format of the front pages changed?");
}

/// The name by which a link reaches a heading: lower case, hyphens for blanks, nothing else but letters and
/// digits.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
    text.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
}

fn is_path(quoted: &str) -> bool {
    let starts = ["crates/", "scenes/", "bench/", "book/", "examples/", "docs/", "fuzz/"];
    starts.iter().any(|start| quoted.starts_with(start)) && !quoted.contains(' ')
}

/// The commands of the README run as they are printed, one after the other, and print the lines below them.
#[test]
fn the_commands_of_the_readme_run() {
    let folder = folder_with_examples();
    let ran = run_commands("README.md", folder.path());
    assert!(ran >= 5, "only {ran} commands were found: has the format of the README changed?");
    assert_drawn(folder.path(), "packing.svg", "docs/packing.svg");
}

/// The commands of the page on pictures draw the picture that the page shows.
#[test]
fn the_picture_of_the_book_is_what_its_command_draws() {
    let folder = folder_with_examples();
    run_commands("book/src/pictures.md", folder.path());
    assert_drawn(folder.path(), "spheres.png", "book/src/figures/spheres.png");
}

/// Asserts that a command of a document drew in `folder` the picture that the document shows, and that the
/// picture is small.
fn assert_drawn(folder: &Path, drawn: &str, shown: &str) {
    let bytes = fs::read(root().join(shown)).unwrap();
    assert!(
        fs::read(folder.join(drawn)).unwrap() == bytes,
        "{shown} is not the picture that the command draws"
    );
    assert!(bytes.len() < 300_000, "{shown} is too large for a page that should open quickly");
}

/// The commands of the book run and print the lines below them, page by page.
#[test]
fn the_commands_of_the_book_run() {
    let ran: usize = pages().iter().map(|page| run_commands(page, folder_with_examples().path())).sum();
    assert!(ran >= 10, "only {ran} commands were found: has the format of the book changed?");
}

fn folder_with_examples() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for examples in ["examples", "examples/space"] {
        fs::create_dir(folder.path().join(examples)).unwrap();
        for example in fs::read_dir(root().join(examples)).unwrap().map(Result::unwrap) {
            if example.file_type().unwrap().is_file() {
                fs::copy(example.path(), folder.path().join(examples).join(example.file_name())).unwrap();
            }
        }
    }
    folder
}

/// Runs the commands of a document, and returns how many there are.
fn run_commands(document: &str, folder: &Path) -> usize {
    let mut ran = 0;
    for block in read(document).split("```console\n").skip(1).map(|rest| rest.split("```").next().unwrap()) {
        for command in block.split("$ ").skip(1) {
            let (line, printed) = command.split_once('\n').unwrap();
            let line = line.replace("cargo run --release --", "fdem");
            if line.starts_with("sed ") {
                // A change that a reader makes in an editor.
                let done = Command::new("sh").args(["-c", &line]).current_dir(folder).status().unwrap();
                assert!(done.success(), "{document}: {line}");
                continue;
            }
            let Some(arguments) = line.strip_prefix("fdem ") else { continue };
            let output = Command::new(assert_cmd::cargo::cargo_bin!("fdem"))
                .args(arguments.split_whitespace())
                .current_dir(folder)
                .output()
                .unwrap();
            let said = String::from_utf8([output.stderr, output.stdout].concat()).unwrap();
            assert!(output.status.success(), "{document}: {line}\n{said}");
            // Times and memory differ from run to run.
            let differ = ["time", "peak", "run time"];
            for printed in printed.lines().filter(|line| !differ.iter().any(|word| line.starts_with(word))) {
                assert!(said.contains(printed), "{document}: {line} does not say\n{printed}\nbut\n{said}");
            }
            ran += 1;
        }
    }
    ran
}

/// The figures of the book are those that the searches draw.
#[test]
fn the_figures_of_the_book_are_up_to_date() {
    for (name, svg) in book_figures::figures().unwrap() {
        assert_eq!(
            svg,
            read(&format!("book/src/figures/{name}")),
            "cargo run -p fdem --example book_figures -- book/src/figures"
        );
    }
}

/// The book's list of keys is the one of the schema; `BLESS=1` writes it.
#[test]
fn every_key_of_a_model_file_is_in_the_book() {
    assert_written("book/src/simulation/keys.md", &model_keys::page(&fdem::model::schema()));
}

/// The book's list of fields is the table from which results take them; `BLESS=1` writes it.
#[test]
fn every_field_of_the_results_is_in_the_book() {
    assert_written("book/src/simulation/fields.md", &fields::page());
}

/// The book's table of materials is the one of the library; `BLESS=1` writes it.
#[test]
fn every_material_of_the_library_is_in_the_book() {
    assert_written("book/src/simulation/materials.md", &materials::page());
}

#[track_caller]
fn assert_written(name: &str, page: &str) {
    if std::env::var_os("BLESS").is_some() {
        fs::write(root().join(name), page).unwrap();
    }
    assert!(page == read(name), "BLESS=1 cargo test -p fdem --test docs writes {name} anew");
}

/// Every whole model in the book passes `fdem check`.
#[test]
fn every_model_in_the_book_is_right() {
    let mut checked = 0;
    for page in pages() {
        let text = read(&page);
        let blocks = text.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap());
        for block in blocks.filter(|block| block.contains("[[body]]")) {
            let absent = &mut |file: &str| Err(format!("{file} is not there"));
            let warnings = match fdem::model::prepare_any(block, &page, absent, None) {
                Ok(AnyPrepared::Plane(prepared)) => prepared.warnings,
                Ok(AnyPrepared::Space(prepared)) => prepared.warnings,
                Err(errors) => vec![errors.to_string()],
            };
            assert_eq!(warnings, Vec::<String>::new(), "{page}:\n{block}");
            checked += 1;
        }
    }
    assert!(checked >= 1, "no model was found: has the format of the book changed?");
}

/// The walk-throughs for frequent additions name at most five files each.
#[test]
fn walk_throughs_name_few_files() {
    let text = read("CONTRIBUTING.md");
    let (_, walks) = text.split_once("\n## Walk-throughs\n").unwrap();
    let mut titles = Vec::new();
    for walk in walks.split("\n### ").skip(1) {
        let (title, body) = walk.split_once('\n').unwrap();
        let files: BTreeSet<&str> = body.split('`').skip(1).step_by(2).filter(|file| is_path(file)).collect();
        assert!(!files.is_empty() && files.len() <= 5, "\"{title}\" names {} files", files.len());
        titles.push(title);
    }
    for wanted in ["Add a law", "Add an action", "Add a field", "Add a case to the ladder"] {
        assert!(titles.iter().any(|title| title.starts_with(wanted)), "{wanted}: {titles:?}");
    }
}

/// The templates of `fdem new` that are called like an example are copies of it; `BLESS=1` writes them anew.
#[test]
fn every_template_is_its_example() {
    let templates = "crates/fdem/src/command/templates";
    let mut copies = 0;
    for entry in fs::read_dir(root().join(templates)).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        if Path::new(&file).extension().is_none_or(|end| end != "toml") {
            let [copy, original] =
                [templates, "examples/space"].map(|folder| fs::read(root().join(folder).join(&file)));
            assert!(copy.unwrap() == original.unwrap(), "{file} is not that of the example");
            continue;
        }
        let example = match file.strip_suffix("_3d.toml") {
            Some(name) => format!("examples/space/{name}.toml"),
            None => format!("examples/{file}"),
        };
        if root().join(&example).exists() {
            assert_written(&format!("{templates}/{file}"), &read(&example));
            copies += 1;
        }
    }
    assert!(copies >= 22, "only {copies} templates are examples");
}

/// Every model of `examples/` has its command and its picture in the book's gallery.
#[test]
fn every_example_is_in_the_gallery() {
    let gallery = read("book/src/simulation/examples.md");
    let (mut models, mut bytes) = (0, 0);
    for example in fs::read_dir(root().join("examples")).unwrap() {
        let file = example.unwrap().file_name().into_string().unwrap();
        let Some(name) = file.strip_suffix(".toml") else { continue };
        let picture = format!("figures/simulation/{name}.png");
        assert!(gallery.contains(&format!("fdem run examples/{file}")), "no command runs {file}");
        assert!(gallery.contains(&format!("(../{picture})")), "no picture shows {file}");
        let size = fs::metadata(root().join("book/src").join(&picture)).unwrap().len();
        assert!(size < 60_000, "{picture} has {size} bytes: the page should open quickly");
        bytes += size;
        models += 1;
    }
    assert!(models >= 8, "only {models} models");
    assert!(bytes < 40_000 * models, "all pictures have {bytes} bytes");
}

#[test]
fn the_version_is_the_same_everywhere() {
    let version = format!("version: {}\n", env!("CARGO_PKG_VERSION"));
    assert!(read("CITATION.cff").contains(&version), "CITATION.cff does not have {version}");
}
