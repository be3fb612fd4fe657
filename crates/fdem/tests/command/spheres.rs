//! Runs of spheres: their files.

use std::fs;

use super::*;

/// Spheres that fall on a floor, with a grid of a continuum.
const FALL: &str = r#"[model]
end_time = 0.02
gravity = [0, 0, -9.81]

[[grains]]
name = "sand"
material = "glass"
count = 60
radius = 0.01
within = { min = [0, 0, 0], max = [0.12, 0.12, 0.12] }

[[wall]]
name = "floor"
material = "glass"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }

[[material]]
name = "glass"
density = 2500
youngs_modulus = 1e7
poissons_ratio = 0.2
friction = 0.4
restitution = 0.6

[output]
frames = 2
coarse = { spacing = 0.02, width = 0.02, box = [0, 0, 0, 0.12, 0.12, 0.12] }
"#;

/// The names of the collections in a folder.
fn collections(bench: &Bench, folder: &str) -> Vec<String> {
    let entries = fs::read_dir(bench.path(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> =
        names.filter(|name| Path::new(name).extension().is_some_and(|end| end == "pvd")).collect();
    names.sort();
    names
}

#[test]
fn spheres_alone_have_their_own_files_and_no_others() {
    let bench = Bench::new();
    bench.write("fall.toml", FALL);
    bench.run(&["run", "fall.toml", "-q"]).succeeds();
    let all = ["coarse.pvd", "sphere_contacts.pvd", "spheres.pvd", "walls.pvd"];
    assert_eq!(collections(&bench, "fall_results"), all);
    bench.has_all_that_collections_name("fall_results");
    let grid = fs::read(bench.path("fall_results/frames/00002_coarse.vti")).unwrap();
    let head = String::from_utf8_lossy(&grid[..1500]).into_owned();
    for word in ["WholeExtent=\"0 6 0 6 0 6\"", "\"density\"", "\"stress\""] {
        assert!(head.contains(word), "{word}: {head}");
    }
    // The grid changes nothing in the run itself, and goes with it.
    let state = bench.json("fall_results/run.json")["state_hash"].clone();
    bench.write("plain.toml", FALL.replace("coarse", "# coarse"));
    bench.run(&["run", "plain.toml", "-q", "--force", "-o", "fall_results"]).succeeds();
    assert_eq!(bench.json("fall_results/run.json")["state_hash"], state);
    assert_eq!(collections(&bench, "fall_results"), all[1..]);
    assert!(!bench.path("fall_results/frames/00002_coarse.vti").exists());
}

/// A step that many contacts do not allow ends the run with a step that they allow.
#[test]
fn a_step_that_is_too_long_names_a_shorter_one() {
    let bench = Bench::new();
    let pressed = "[domain]\nbox = [0, 0, 0, 0.12, 0.12, 0.12]\nperiodic = [\"x\", \"y\", \"z\"]\n\
                   strain_rate = [-4, -4, -4]\n";
    let model = FALL.replace("end_time = 0.02", "end_time = 0.3\ntime_step = 2e-4");
    let model =
        model.replace("restitution = 0.6", "restitution = 0.1").replace("count = 60", "fraction = 0.5");
    let (begin, _) = model.split_once("[[wall]]").unwrap();
    let (_, rest) = model.split_once("[[material]]").unwrap();
    let rest = rest.split_once("coarse").unwrap().0;
    bench.write("pressed.toml", format!("{begin}{pressed}[[material]]{rest}"));
    let run = bench.run(&["run", "pressed.toml", "-q"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(
        run.stderr.contains("too long for sphere") && run.stderr.contains("take at most"),
        "{}",
        run.stderr
    );
}
