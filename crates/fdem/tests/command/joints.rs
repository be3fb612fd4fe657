//! Joint sets in runs: joints that are open from the start are no cracks, and joints store energy apart from
//! that which they dissipate.

use std::fs;

use serde_json::Value;

use crate::Bench;
use crate::stages::column;

/// A plate with an edge notch of 30 mm, given as an open joint set.
const NOTCH: &str = r#"
[model]
plane = "strain"
end_time = 1e-4
[[body]]
name = "plate"
material = "stone"
rectangle = { min = [0, -0.1], max = [0.1, 0.1] }
mesh_size = 0.01
[[material]]
name = "stone"
density = 2500
youngs_modulus = 30e9
poissons_ratio = 0.2
tensile_strength = 2.5e6
cohesion = 12.5e6
friction_angle = 30
fracture_energy_i = 3
fracture_energy_ii = 30
[[joint_set]]
name = "notch"
lines = [[-0.01, 0, 0.03, 0]]
open = true
friction_angle = 0
[[boundary]]
name = "top"
side = "top"
traction = [0, 1e3]
[[boundary]]
name = "bottom"
side = "bottom"
traction = [0, -1e3]
[output]
frames = 2
"#;

/// A block under in-situ stress with joints everywhere, which store energy and break nowhere.
const STRESSED: &str = r#"
[model]
end_time = 1e-4
[fracture]
insertion = "intrinsic"
[[body]]
name = "rock"
material = "rock"
rectangle = { min = [0, 0], max = [1, 1] }
mesh_size = 0.2
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
tensile_strength = 5e6
cohesion = 20e6
friction_angle = 30
fracture_energy_i = 100
fracture_energy_ii = 1000
[initial]
stress = [-10e6, -10e6, 0]
[[boundary]]
name = "around"
group = "outer"
absorbing = true
"#;

fn run_json(bench: &Bench, folder: &str) -> Value {
    serde_json::from_str(&bench.read(&format!("{folder}/run.json"))).unwrap()
}

#[test]
fn a_notch_is_no_crack() {
    let bench = Bench::new();
    bench.write("notch.toml", NOTCH);
    let check = bench.run(&["check", "notch.toml"]).succeeds();
    let joints = "notch: 1, 0.03 m long together, along 3 edges, open from the start";
    assert!(check.stdout.contains(joints), "{}", check.stdout);
    let run = bench.run(&["run", "notch.toml"]).succeeds();
    for part in ["cracks           none", "open joints      3 joints open from the start, 0.03 m"] {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    let json = run_json(&bench, "notch_results");
    assert_eq!((&json["broken_joints"], &json["crack_length"]), (&Value::from(0), &Value::from(0.0)));
    assert_eq!(json["open_joints"], 3, "as the summary says, also at the end of the notch");
    // They are in the files of broken joints from the first frame on, and are no damage of the elements.
    for frame in ["00000", "00002"] {
        let file = fs::read(bench.path(&format!("notch_results/frames/{frame}_cracks.vtp"))).unwrap();
        let text = String::from_utf8_lossy(&file[..1000]).into_owned();
        assert!(text.contains("NumberOfLines=\"3\""), "{frame}: {text}");
    }
    let history = bench.read("notch_results/history.csv");
    for name in ["broken_joints", "crack_length", "crack_length_tension", "joint_dissipated"] {
        assert!(column(&history, name).iter().all(|value| value.abs() < 1e-12), "{name}: {history}");
    }

    // A condition on broken joints is not met by the notch.
    let until = "end_time = 1e-4\nuntil = { column = \"broken_joints\", above = 0.5 }";
    bench.write("until.toml", NOTCH.replace("end_time = 1e-4", until));
    bench.run(&["run", "until.toml", "-q"]).succeeds();
    assert_eq!(run_json(&bench, "until_results")["steps"], json["steps"]);

    // The crack that grows from the notch counts, and the notch still does not.
    bench.write("torn.toml", NOTCH.replace("1e3]", "1.2e6]"));
    bench.run(&["run", "torn.toml", "-q"]).succeeds();
    let torn = run_json(&bench, "torn_results");
    let length = torn["crack_length"].as_f64().unwrap();
    assert!(torn["broken_joints"].as_u64().unwrap() > 0 && length > 0.0, "{torn}");
    assert!((0.069..0.08).contains(&length), "the ligament has 0.07 m: {length}");
    assert_eq!(torn["open_joints"], 3, "the end of the notch has parted too");
}

#[test]
fn whole_joints_are_shown_on_request() {
    let bench = Bench::new();
    let fault = "\n[[joint_set]]\nname = \"fault\"\nlines = [[0.05, 0.06, 0.09, 0.06]]\ncohesion = 1e6\n\
                 tensile_strength = 1e6\nfracture_energy_i = 3\nfracture_energy_ii = 30\nfriction_angle = 30\n";
    let model = format!("{}{fault}", NOTCH.replace("end_time = 1e-4", "end_time = 1e-5"));
    bench.write("plain.toml", &model);
    bench.write("shown.toml", model.replace("frames = 2", "frames = 2\nintact_joints = true"));
    bench.run(&["run", "plain.toml", "-q"]).succeeds();
    assert!(!bench.path("plain_results/intact_joints.pvd").exists());
    assert!(!bench.read("plain_results/report.html").contains("class=\"whole\""));
    bench.run(&["run", "shown.toml", "-q"]).succeeds();
    bench.has_all_that_collections_name("shown_results");
    assert!(bench.read("shown_results/intact_joints.pvd").contains("frames/00002_intact_joints.vtp"));
    let file = fs::read(bench.path("shown_results/frames/00002_intact_joints.vtp")).unwrap();
    let text = String::from_utf8_lossy(&file[..1000]).into_owned();
    let lines = text.split("NumberOfLines=\"").nth(1).unwrap().split('"').next().unwrap();
    // The fault, and not the notch.
    let check = bench.run(&["check", "shown.toml"]).succeeds();
    assert!(check.stdout.contains(&format!("along {lines} edges")), "{lines}: {}", check.stdout);
    assert!(bench.read("shown_results/report.html").contains(&format!("\"holding\":[{lines},0]")));
    // The key changes nothing in the run itself.
    let [plain, shown] = ["plain", "shown"].map(|name| run_json(&bench, &format!("{name}_results")));
    assert_eq!(plain["state_hash"], shown["state_hash"]);
    // Without the key, the collection of an earlier run is removed.
    bench.run(&["run", "plain.toml", "-q", "--force", "-o", "shown_results"]).succeeds();
    assert!(!bench.path("shown_results/intact_joints.pvd").exists());
}

#[test]
fn joints_under_initial_stress_store_energy_and_dissipate_none() {
    let bench = Bench::new();
    bench.write("stressed.toml", STRESSED);
    bench.run(&["run", "stressed.toml", "-q"]).succeeds();
    let history = bench.read("stressed_results/history.csv");
    let [stored, dissipated] = ["joint_elastic", "joint_dissipated"].map(|name| column(&history, name));
    assert!(stored.iter().all(|stored| *stored > 1.0), "{stored:?}");
    assert!(
        dissipated.iter().zip(&stored).all(|(lost, stored)| lost.abs() < 1e-6 * stored),
        "{dissipated:?}"
    );
    assert!(!history.lines().next().unwrap().contains("cohesive"), "{history}");
}
