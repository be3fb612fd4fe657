//! The models of `examples/`: checked without a warning, and run at reduced time, with all that a run leaves
//! behind.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;
use serde_json::Value;

/// Elements and spheres times steps of a reduced run.
const WORK: f64 = 3e5;

/// The models in two and in three dimensions, with different names.
fn examples() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let stem = |path: &PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    let plane = models(&folder).into_iter().map(|path| (stem(&path), path));
    let space =
        models(&folder.join("space")).into_iter().map(|path| (format!("space_{}", stem(&path)), path));
    plane.chain(space).collect()
}

fn models(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut models: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    models.sort();
    models
}

/// The standard output of the command.
fn fdem(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(assert_cmd::cargo::cargo_bin!("fdem"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "fdem {}\n{said}", arguments.join(" "));
    String::from_utf8(output.stdout).unwrap()
}

/// The model with another value of a key that has a separate line.
fn with(model: &str, key: &str, value: &str) -> String {
    let mut found = false;
    let lines = model.lines().map(|line| {
        if line.split('=').next().is_some_and(|word| word.trim() == key) {
            found = true;
            format!("{key} = {value}\n")
        } else {
            format!("{line}\n")
        }
    });
    let text = lines.collect();
    assert!(found, "the model does not say {key}");
    text
}

#[test]
fn every_example_runs_and_leaves_all_results() {
    let models = examples();
    assert!(models.len() >= 13, "{models:?}");
    let folder = tempfile::tempdir().unwrap();
    // Each run on one thread, as many at once as there are processors.
    models.into_par_iter().for_each(|(name, path)| {
        let (file, results) = (format!("{name}.toml"), folder.path().join(format!("{name}_results")));
        let model = fs::read_to_string(&path).unwrap();
        fs::write(folder.path().join(&file), &model).unwrap();
        let surface = path.with_extension("stl");
        if surface.exists() {
            fs::copy(&surface, folder.path().join(surface.file_name().unwrap())).unwrap();
        }
        let preflight: Value =
            serde_json::from_str(&fdem(folder.path(), &["check", &file, "--json"])).unwrap();
        // Two examples take seconds, because they are fast and coarse, which the check says.
        let fast = ["space_crushed_ball", "space_pillar"].contains(&name.as_str());
        for warning in preflight["warnings"].as_array().unwrap() {
            let said = warning.as_str().unwrap();
            let expected = ["a quarter of its fracture process zone", "process zone in shear", "by inertia"];
            let expected = expected.iter().any(|part| said.contains(part));
            assert!(fast && expected, "{name}: {said}");
        }

        let elements = preflight["quality"]["elements"].as_f64().unwrap();
        let spheres = preflight["spheres"].as_f64().unwrap_or(0.0);
        let steps = WORK / (elements + spheres);
        let end = preflight["step"].as_f64().unwrap() * steps.round();
        let shorter = with(&with(&model, "end_time", &format!("{end:e}")), "frames", "3");
        fs::write(folder.path().join(&file), shorter).unwrap();
        let said = fdem(folder.path(), &["run", &file, "--quiet", "--threads", "1"]);
        assert!(said.contains(&format!("results are in {name}_results")), "{name}: {said}");

        let run: Value =
            serde_json::from_str(&fs::read_to_string(results.join("run.json")).unwrap()).unwrap();
        assert_eq!(run["status"], "finished", "{name}");
        let error = run["energies"]["error"].as_f64().unwrap();
        assert!(error.abs() < 0.01, "{name}: the balance of energy is off by {error}");
        let mut expected: Vec<String> = [
            "model.toml",
            "checkpoint",
            "history.csv",
            "picture.png",
            "report.html",
            "run.log",
            "plots/energies.svg",
            "plots/energies.png",
            "plots/energy_error.svg",
        ]
        .map(str::to_owned)
        .to_vec();
        let mut series = Vec::new();
        if elements > 0.0 {
            series.extend([("results", ".vtu"), ("cracks", "_cracks.vtp")]);
            series.extend([("damaged_joints", "_damaged_joints.vtp"), ("contacts", "_contacts.vtp")]);
        }
        if model.contains("[[grains]]") {
            series.extend([("spheres", "_spheres.vtp"), ("sphere_contacts", "_sphere_contacts.vtp")]);
            series.push(("walls", "_walls.vtp"));
        }
        for (name, end) in series {
            expected.push(format!("{name}.pvd"));
            expected.extend((0..=3).map(|k| format!("frames/{k:05}{end}")));
        }
        if model.contains("animate = true") {
            expected.push("animation.gif".to_owned());
        }
        for file in expected {
            let length = fs::metadata(results.join(&file)).map_or(0, |file| file.len());
            assert!(length > 0, "{name} left no {file}");
        }
        let rows = fs::read_to_string(results.join("history.csv")).unwrap().lines().count();
        assert!(rows >= 2, "{name}: a history of {rows} lines");
    });
}
