//! Runs with mass scaling.

use crate::Bench;
use crate::stages::column;

/// A block with a sliver at its top, which is pulled slowly until it is at rest.
const SLIVER: &str = r#"
[model]
end_time = 8e-3
local_damping = 0.7
[[body]]
name = "block"
material = "rock"
polygon = { points = [[0, 0], [1, 0], [1, 0.5], [0.501, 0.5], [0.5, 0.5], [0, 0.5]] }
mesh_size = 0.1
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
[[boundary]]
name = "base"
side = "bottom"
fixed = "xy"
[[boundary]]
name = "top"
side = "top"
traction = [0, 1e6]
ramp = 3e-3
[[history]]
name = "base"
force = "base"
[[history]]
name = "corner"
node = [1, 0.5]
[output]
frames = 2
"#;

/// The model with this time step, s.
fn scaled(step: f64, more: &str) -> String {
    SLIVER.replace("[model]", &format!("[model]\nmass_scaling = {{ time_step = {step:e}{more} }}"))
}

#[test]
fn a_sliver_with_added_mass_takes_longer_steps_to_the_same_rest() {
    let bench = Bench::new();
    bench.write("own.toml", SLIVER);
    bench.run(&["run", "own.toml", "-o", "own", "-q"]).succeeds();
    let own = bench.json("own/run.json");
    let step = own["time_step"].as_f64().unwrap();
    assert!(own["mass_scaling"].is_null());

    bench.write("scaled.toml", scaled(2.0 * step, ""));
    let run = bench.run(&["run", "scaled.toml", "-o", "scaled", "--threads", "1"]).succeeds();
    assert_eq!(run.stderr.matches("mass scaling     ").count(), 2, "{}", run.stderr);
    assert!(run.stderr.contains("kinetic energy up to 0.0"), "{}", run.stderr);
    assert!(!run.stderr.contains("not quasi-static"), "{}", run.stderr);
    let json = bench.json("scaled/run.json");
    assert_eq!(json["time_step"].as_f64().unwrap(), 2.0 * step);
    let number = |key: &str| json["mass_scaling"][key].as_f64().unwrap();
    assert!(number("added_share") > 0.001 && number("added_share") < 0.05, "{json}");
    assert!((number("added_mass") / number("true_mass") - number("added_share")).abs() < 1e-15);
    assert_eq!(number("time_step_without"), step);
    assert_eq!(json["mass_scaling"]["kinetic_over_strain"]["rows_above"], 0);

    let [before, after] = ["own", "scaled"].map(|folder| bench.read(&format!("{folder}/history.csv")));
    for (name, expected) in [("base fy [N]", -1e6), ("corner uy [m]", 1.7e-5), ("strain", 8.2)] {
        let [one, other] = [&before, &after].map(|history| *column(history, name).last().unwrap());
        assert!((one / expected - 1.0).abs() < 0.02, "{name}: {one}");
        assert!((other / one - 1.0).abs() < 1e-5, "{name}: {one} {other}");
    }

    // A model without the added mass cannot take this step.
    let later = SLIVER.replace("end_time = 8e-3", "end_time = 9e-3");
    bench.write("later.toml", &later);
    bench
        .run(&["run", "later.toml", "--from", "scaled"])
        .refused_with(&["scaled has [model] mass_scaling", "the same mass_scaling"]);

    // Interrupted and resumed: the same bits.
    bench.write("short.toml", scaled(2.0 * step, "").replace("end_time = 8e-3", "end_time = 2.5e-3"));
    bench.run(&["run", "short.toml", "-o", "short", "--threads", "2", "-q"]).succeeds();
    bench.run(&["resume", "short", "--end-time", "8e-3", "-q"]).succeeds();
    assert_eq!(bench.json("short/run.json")["state_hash"], json["state_hash"]);
}

#[test]
fn a_run_that_is_not_quasi_static_says_so() {
    let bench = Bench::new();
    let quick = scaled(3e-6, "").replace("ramp = 3e-3\n", "").replace("local_damping = 0.7\n", "");
    bench.write("quick.toml", quick.replace("end_time = 8e-3", "end_time = 1e-3"));
    let run = bench.run(&["run", "quick.toml", "-o", "quick"]).succeeds();
    assert!(
        run.stderr.contains("warning: the run was not quasi-static: its kinetic energy was above 0.1 times")
    );
    let ratio = &bench.json("quick/run.json")["mass_scaling"]["kinetic_over_strain"];
    assert!(ratio["largest"].as_f64().unwrap() > 0.5 && ratio["rows_above"].as_u64().unwrap() > 100);
}

/// A part of the block vanishes: the rest continues with the same factors and the same step.
#[test]
fn stages_go_on_with_added_mass() {
    let bench = Bench::new();
    let stages = "[[stage]]\nname = \"all\"\nduration = 4e-3\n[[stage]]\nname = \"cut\"\nexcavate_boxes = [[0.3, 0.2, 0.7, 0.4]]\nrelease = 1e-3\n";
    for (name, text) in [("own", SLIVER.to_owned()), ("scaled", scaled(3e-6, ""))] {
        bench.write(&format!("{name}.toml"), text + stages);
        let run = bench.run(&["run", &format!("{name}.toml"), "-o", name, "--threads", "1"]).succeeds();
        assert!(run.stderr.contains("stage \"cut\" begins with"), "{}", run.stderr);
    }
    let history = |name: &str| bench.read(&format!("{name}/history.csv"));
    assert!(bench.json("own/run.json")["time_step"].as_f64().unwrap() < 2e-6);
    assert_eq!(bench.json("scaled/run.json")["time_step"], 3e-6);
    let [one, other] = ["own", "scaled"].map(|name| *column(&history(name), "corner uy [m]").last().unwrap());
    assert!((other / one - 1.0).abs() < 1e-3 && one < 1.4e-5, "{one} {other}");
}
