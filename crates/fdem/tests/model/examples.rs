//! The examples, the starter and the schema.

use std::fs;
use std::path::{Path, PathBuf};

use fdem::model::{Preflight, STARTER, prepare, schema};

use crate::right;

fn examples() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut models: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    models.sort();
    models
}

#[test]
fn every_example_is_right_small_and_gives_no_warning() {
    let models = examples();
    assert!(models.len() >= 9, "{models:?}");
    let mut wrong = Vec::new();
    for path in models {
        let name = path.file_name().unwrap().to_str().unwrap();
        let folder = path.parent().unwrap();
        let mut load = |file: &str| fs::read(folder.join(file)).map_err(|error| error.to_string());
        let prepared = prepare(&fs::read_to_string(&path).unwrap(), name, &mut load);
        let prepared = prepared.unwrap_or_else(|errors| panic!("{errors}"));
        let preflight = Preflight::of(&prepared).unwrap_or_else(|why| panic!("{name}: {why}"));
        println!("{name}\n{preflight}");
        let (elements, steps) = (preflight.quality.elements, preflight.steps);
        let work = elements as f64 * steps as f64;
        if !preflight.warnings.is_empty() || !(1_000..=6_500).contains(&elements) || work > 5e8 {
            wrong.push(format!(
                "{name}: {elements} elements, {work:e} element-steps, {:?}",
                preflight.warnings
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_starter_is_right_and_gives_no_warning() {
    let preflight = Preflight::of(&right(STARTER)).unwrap();
    assert_eq!(preflight.warnings, Vec::<String>::new());
}

/// Every key has a description for editors.
#[test]
fn every_key_of_the_schema_is_described() {
    let schema = schema();
    let mut tables = vec![("file".to_owned(), &schema)];
    tables.extend(schema["$defs"].as_object().unwrap().iter().map(|(name, table)| (name.clone(), table)));
    let mut keys = 0;
    for (name, table) in tables {
        for (key, property) in table["properties"].as_object().into_iter().flatten() {
            assert!(property["description"].is_string(), "{name}.{key} has no description");
            keys += 1;
        }
    }
    assert!(keys > 100, "only {keys} keys");
}
