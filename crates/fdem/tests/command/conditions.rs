//! Runs and stages that end on a condition, and servos.

use serde_json::Value;

use crate::Bench;
use crate::stages::column;

/// A block on which a platen gets to a force of 200 kN, and then to half of it. It ends once it has moved
/// back.
const SERVO: &str = r#"
[model]
plane = "stress"
end_time = 6e-3
[[body]]
name = "block"
material = "rock"
rectangle = { min = [0, 0], max = [0.1, 0.1] }
mesh_size = 0.025
[[material]]
name = "rock"
density = 2600
youngs_modulus = 10e9
poissons_ratio = 0.25
[[boundary]]
name = "base"
side = "bottom"
fixed = "y"
[[boundary]]
name = "left"
side = "left"
fixed = "x"
[[boundary]]
name = "platen"
side = "top"
velocity = [0, -0.02]
servo = { column = "platen fy", target = "-200 kN" }
table = [[0, 0], [1e-3, 1], [3e-3, 1], [3.5e-3, 0.5]]
[[history]]
name = "platen"
force = "platen"
[output]
frames = 3
checkpoint_steps = 7
"#;

/// A bar that is torn apart. It is free from the middle of its pull on in the second of two stages.
const BAR: &str = r#"
[model]
plane = "stress"
end_time = 5e-3
until = { column = "top fy", share_of_peak = 0.2, least_peak = "10 kN" }
[[body]]
name = "bar"
material = "rock"
rectangle = { min = [0, 0], max = [0.05, 0.1] }
mesh_size = 0.012
[[material]]
name = "rock"
density = 2600
youngs_modulus = 10e9
poissons_ratio = 0.25
tensile_strength = 2e6
cohesion = 8e6
friction_angle = 40
fracture_energy_i = 20
fracture_energy_ii = 100
[[boundary]]
name = "bottom"
side = "bottom"
velocity = [0, -0.02]
ramp = 1e-3
[[boundary]]
name = "top"
side = "top"
velocity = [0, 0.02]
ramp = 1e-3
[[history]]
name = "top"
force = "top"
[output]
frames = 5
"#;

fn history(bench: &Bench, folder: &str) -> String {
    String::from_utf8(std::fs::read(bench.path(&format!("{folder}/history.csv"))).unwrap()).unwrap()
}

fn summary(bench: &Bench, folder: &str) -> Value {
    serde_json::from_slice(&std::fs::read(bench.path(&format!("{folder}/run.json"))).unwrap()).unwrap()
}

#[test]
fn a_servo_holds_a_force_and_follows_a_table() {
    let bench = Bench::new();
    bench.write("servo.toml", SERVO);
    bench.run(&["run", "servo.toml", "-o", "one", "--threads", "1", "-q"]).succeeds();
    let text = history(&bench, "one");
    let (time, force) = (column(&text, "time"), column(&text, "platen fy [N]"));
    let within = |from: f64, to: f64, expected: f64| {
        let rows = time.iter().zip(&force).filter(|(time, _)| (from..to).contains(*time));
        let rows: Vec<f64> = rows.map(|(_, force)| force / expected).collect();
        assert!(rows.len() > 100 && rows.iter().all(|ratio| (ratio - 1.0).abs() < 0.02), "{rows:?}");
    };
    within(2e-3, 3e-3, -200e3);
    within(5e-3, 6e-3, -100e3);
    let error = column(&text, "error");
    assert!(error.iter().all(|error| error.abs() < 1e-6), "{error:?}");
}

/// A run that is interrupted has the same bits: the servo looks at its column at the same steps.
#[test]
fn a_servo_is_resumed() {
    let bench = Bench::new();
    bench.write("servo.toml", SERVO);
    bench.run(&["run", "servo.toml", "-o", "one", "--threads", "1", "-q"]).succeeds();
    bench.write("short.toml", SERVO.replace("end_time = 6e-3", "end_time = 2.2225e-3\n"));
    bench.run(&["run", "short.toml", "-o", "two", "--threads", "2", "-q"]).succeeds();
    bench.run(&["resume", "two", "--until", "6e-3", "-q"]).succeeds();
    assert_eq!(summary(&bench, "two")["state_hash"], summary(&bench, "one")["state_hash"]);
}

#[test]
fn a_run_ends_at_a_share_of_the_peak() {
    let bench = Bench::new();
    bench.write("bar.toml", BAR);
    let run = bench.run(&["run", "bar.toml", "-o", "one", "--threads", "1"]).succeeds();
    assert!(run.stderr.contains("the run ends at") && run.stderr.contains("of its peak"), "{}", run.stderr);
    let text = history(&bench, "one");
    let force = column(&text, "top fy [N]");
    let peak = force.iter().fold(0.0, |peak: f64, force| peak.max(force.abs()));
    let (last, before) = (force[force.len() - 1].abs(), force[force.len() - 2].abs());
    assert!(peak > 50e3 && last <= 0.2 * peak && before > 0.2 * peak, "{peak} {before} {last}");
    let one = summary(&bench, "one");
    assert_eq!(one["status"], "finished");
    // The last frame is that of the end.
    let collection = std::fs::read_to_string(bench.path("one/results.pvd")).unwrap();
    let end = column(&text, "time").last().unwrap().to_string();
    assert!(collection.contains(&end), "{end} is not in\n{collection}");
    let again = bench.run(&["resume", "one", "--end-time", "8e-3"]).succeeds();
    assert!(again.stdout.contains("nothing to do"), "{}", again.stdout);
}

/// A condition that the first step meets ends the run after it, and the log says so.
#[test]
fn a_run_that_ends_with_its_first_step_says_why() {
    let bench = Bench::new();
    let until = "until = { column = \"time\", above = -1 }\nend_time = 6e-6";
    bench.write("servo.toml", SERVO.replace("end_time = 6e-3", until));
    bench.run(&["run", "servo.toml", "-o", "one", "-q"]).succeeds();
    assert_eq!(summary(&bench, "one")["steps"], 1);
    let log = std::fs::read_to_string(bench.path("one/run.log")).unwrap();
    assert!(log.contains("the run ends at") && log.contains("above -1"), "{log}");
}

/// A condition that was not met is reported at the end.
#[test]
fn what_was_not_reached_is_told() {
    let bench = Bench::new();
    bench.write(
        "servo.toml",
        SERVO
            .replace("\"-200 kN\"", "\"200 kN\"")
            .replace("end_time = 6e-3", "end_time = 1e-3\nuntil = { column = \"platen uy\", above = 1 }"),
    );
    let run = bench.run(&["run", "servo.toml", "-o", "one"]).succeeds();
    for line in
        ["until of [model], on platen uy [m], was not met", "the servo \"platen\" has not held its target"]
    {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
}

/// A column of a part that is removed is no number. The log names the conditions and servos that depend on
/// it, once.
#[test]
fn conditions_and_servos_on_what_is_removed_are_named() {
    let bench = Bench::new();
    let text = SERVO
        .replace("end_time = 6e-3", "end_time = 4e-4\nuntil = { column = \"core uy\", below = -1 }")
        .replace("\"platen fy\", target = \"-200 kN\"", "\"core uy\", target = -1e-3")
        .replace("mesh_size = 0.025", "mesh_size = 0.0125")
        .replace("checkpoint_steps = 7\n", "");
    let more = r#"
[[history]]
name = "core"
node = [0.05, 0.05]
[[stage]]
name = "rest"
duration = 1e-4
[[stage]]
name = "hole"
excavate_boxes = [[0.02, 0.02, 0.08, 0.08]]
duration = 3e-4
"#;
    bench.write("hole.toml", text + more);
    let run = bench.run(&["run", "hole.toml", "-o", "one"]).succeeds();
    for line in [
        "until of [model]: core uy [m] is not a number, so it cannot be met",
        "the servo \"platen\": its column is not a number, so it does not move",
        "the servo \"platen\" does not move at the end, because its column is not a number",
    ] {
        assert_eq!(run.stderr.matches(line).count(), 1, "{line:?} in\n{}", run.stderr);
    }
}

#[test]
fn a_stage_ends_on_a_condition() {
    let bench = Bench::new();
    let stages = r#"
[[stage]]
name = "pull"
until = { column = "top uy", above = "2 um" }
[[stage]]
name = "hold"
duration = 1e-4
"#;
    let text =
        BAR.replace("until = { column = \"top fy\", share_of_peak = 0.2, least_peak = \"10 kN\" }", "");
    bench.write("bar.toml", text + stages);
    let run = bench.run(&["run", "bar.toml", "-o", "one", "--threads", "1"]).succeeds();
    assert!(
        run.stderr.contains("stage \"pull\" ends at") && run.stderr.contains("above 2.0000e-6"),
        "{}",
        run.stderr
    );
    let one = summary(&bench, "one");
    let text = history(&bench, "one");
    let (time, moved) = (column(&text, "time"), column(&text, "top uy [m]"));
    let first = time[moved.iter().position(|moved| *moved > 2e-6).unwrap()];
    assert_eq!(one["stages"][1]["time"].as_f64().unwrap(), first);
    let end = *time.last().unwrap();
    assert!((end - first - 1e-4).abs() < 2e-6, "{end} {first}");
}

#[test]
fn conditions_and_servos_that_make_no_sense_are_refused() {
    let bench = Bench::new();
    let wrong = |text: &str, from: &str, to: &str, parts: &[&str]| {
        assert!(text.contains(from), "{from}");
        bench.write("wrong.toml", text.replacen(from, to, 1));
        bench.run(&["check", "wrong.toml"]).refused_with(&[&["wrong.toml"], parts].concat());
    };
    wrong(BAR, "\"top fy\"", "\"top fz\"", &["no column \"top fz\"", "top fx"]);
    wrong(BAR, "share_of_peak = 0.2,", "above = 3, share_of_peak = 0.2,", &["exactly one of"]);
    wrong(BAR, "share_of_peak = 0.2, ", "", &["exactly one of"]);
    wrong(BAR, "share_of_peak = 0.2", "above = 3", &["goes with share_of_peak"]);
    wrong(BAR, "share_of_peak = 0.2", "share_of_peak = 1.2", &["share_of_peak"]);
    wrong(SERVO, "\"platen fy\"", "\"time\"", &["no column \"time\"", "platen"]);
    wrong(SERVO, "\"-200 kN\"", "0", &["is not 0"]);
    wrong(SERVO, "\"-200 kN\"", "\"-2 MPa\"", &["\"target\" is a stress", "platen fy [N]", "in N"]);
    wrong(BAR, "\"10 kN\"", "\"10 mm\"", &["\"least_peak\" is a length", "top fy [N]"]);
    bench.write("fast.toml", SERVO.replace("[0, -0.02]", "[0, -2]"));
    let checked = bench.run(&["check", "fast.toml"]).succeeds();
    assert!(checked.stdout.contains("makes waves of"), "{}", checked.stdout);
    wrong(SERVO, "velocity = [0, -0.02]", "force = [0, -1]", &["a servo needs a velocity"]);
    wrong(SERVO, "[0, -0.02]", "[\"free\", 0]", &["a servo needs a velocity"]);
}
