//! The examples, the starter and the schema.

use std::fs;
use std::path::{Path, PathBuf};

use fdem_model::{AnyPrepared, Preflight, STARTER, STARTER_3D, prepare_any, schema};

use crate::right;

fn examples(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut models: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    models.sort();
    models
}

/// Examples that are loaded fast or are coarse, so that they take seconds, with parts of their warnings. The
/// book says so.
const WARNED: [(&str, &[&str]); 2] = [
    (
        "crushed_ball.toml",
        &[
            "process zone in shear",
            "a quarter of its fracture process zone (",
            "process zone in shear",
            "by inertia",
        ],
    ),
    ("pillar.toml", &["by inertia"]),
];

#[test]
fn every_example_is_right_and_small_and_gives_no_unexpected_warning() {
    let (plane, space) = (examples("examples"), examples("examples/space"));
    assert!(plane.len() >= 9 && space.len() >= 5, "{plane:?} {space:?}");
    let mut wrong = Vec::new();
    for path in plane.into_iter().chain(space) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let folder = path.parent().unwrap();
        let mut load = |file: &str| fs::read(folder.join(file)).map_err(|error| error.to_string());
        let prepared = prepare_any(&fs::read_to_string(&path).unwrap(), name, &mut load, None);
        let (preflight, most) = match prepared.unwrap_or_else(|errors| panic!("{errors}")) {
            AnyPrepared::Plane(prepared) => (Preflight::of(&prepared), 6_500),
            AnyPrepared::Space(prepared) => (Preflight::of(&prepared), 12_000),
        };
        let preflight = preflight.unwrap_or_else(|why| panic!("{name}: {why}"));
        println!("{name}\n{preflight}");
        let (elements, steps) = (preflight.quality.elements + preflight.spheres, preflight.steps);
        let work = elements as f64 * steps as f64;
        let expected = WARNED.iter().find(|(of, _)| *of == name).map_or(&[][..], |(_, parts)| parts);
        let as_expected = preflight.warnings.len() == expected.len()
            && preflight.warnings.iter().zip(expected).all(|(warning, part)| warning.contains(part));
        if !as_expected || !(500..=most).contains(&elements) || work > 5e8 {
            wrong.push(format!(
                "{name}: {elements} elements and spheres, {work:e} element-steps, {:?}",
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
    let prepared = prepare_any(STARTER_3D, "starter", &mut |_| Err("no files".to_owned()), None);
    let AnyPrepared::Space(prepared) = prepared.unwrap() else { panic!("it is in three dimensions") };
    assert_eq!(Preflight::of(&prepared).unwrap().warnings, Vec::<String>::new());
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
