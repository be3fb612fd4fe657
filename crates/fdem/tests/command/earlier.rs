//! Runs that begin with the state of an earlier run.

use serde_json::Value;

use crate::Bench;
use crate::stages::column;

/// A block that breaks where it falls on a floor.
const CRASH: &str = r#"
[model]
gravity = [0, -9.81]
end_time = 1e-3
[[body]]
name = "block"
material = "rock"
rectangle = { min = [0, 0.001], max = [0.1, 0.101] }
mesh_size = 0.025
velocity = [1, -8]
[[body]]
name = "floor"
material = "rock"
rectangle = { min = [-0.1, -0.05], max = [0.2, 0] }
mesh_size = 0.05
[[material]]
name = "rock"
density = 2500
youngs_modulus = 5e9
poissons_ratio = 0.2
friction = 0.5
damping = 0.1
tensile_strength = 1e6
cohesion = 3e6
friction_angle = 30
fracture_energy_i = 5
fracture_energy_ii = 20
[[boundary]]
name = "ground"
body = "floor"
side = "bottom"
fixed = "xy"
[output]
frames = 2
"#;

fn summary(bench: &Bench, folder: &str) -> Value {
    serde_json::from_slice(&std::fs::read(bench.path(&format!("{folder}/run.json"))).unwrap()).unwrap()
}

fn history(bench: &Bench, folder: &str) -> String {
    String::from_utf8(std::fs::read(bench.path(&format!("{folder}/history.csv"))).unwrap()).unwrap()
}

/// A run that takes over all of another, and changes nothing, is that run resumed: the same bits. The same
/// holds for one that was interrupted itself.
#[test]
fn a_run_that_changes_nothing_is_the_other_run_resumed() {
    let bench = Bench::new();
    bench.write("short.toml", CRASH);
    bench.write("long.toml", CRASH.replace("end_time = 1e-3", "end_time = 2e-3"));
    bench.write("middle.toml", CRASH.replace("end_time = 1e-3", "end_time = 1.5e-3"));
    bench.run(&["run", "short.toml", "-o", "short", "-q"]).succeeds();
    bench.run(&["run", "long.toml", "-o", "long", "-q"]).succeeds();
    let begun =
        bench.run(&["run", "long.toml", "-o", "next", "--from", "short", "--threads", "1"]).succeeds();
    for line in ["begins with short at 0.001", "block, floor", "the boundary \"ground\" goes on"] {
        assert!(begun.stderr.contains(line), "{line:?} is not in\n{}", begun.stderr);
    }
    let hash = |folder: &str| summary(&bench, folder)["state_hash"].clone();
    assert_eq!(hash("next"), hash("long"));
    assert!(summary(&bench, "next")["broken_joints"].as_u64().unwrap() > 3);
    bench.run(&["run", "middle.toml", "-o", "middle", "--from", "short", "-q"]).succeeds();
    bench.run(&["resume", "middle", "--end-time", "2e-3", "-q"]).succeeds();
    assert_eq!(hash("middle"), hash("long"));
}

/// Softer, removed, new or newly loaded bodies: the balance of energy continues.
#[test]
fn a_run_begins_with_another_and_changes_it() {
    let bench = Bench::new();
    bench.write("first.toml", CRASH);
    let push = r#"
[[boundary]]
name = "push"
body = "block"
force = [0, -1e3]
ramp = 2e-4
[[history]]
name = "push"
force = "push"
"#;
    let changed = CRASH
        .replace("end_time = 1e-3", "end_time = 2e-3")
        .replace("youngs_modulus = 5e9", "youngs_modulus = 4e9")
        .replace("gravity = [0, -9.81]\n", "");
    bench.write("next.toml", changed.clone() + push);
    bench.run(&["run", "first.toml", "-o", "first", "-q"]).succeeds();
    let run = bench.run(&["run", "next.toml", "-o", "next", "--from", "first"]).succeeds();
    for line in ["the material \"rock\" has changed", "the boundary \"push\" is new"] {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
    let text = history(&bench, "next");
    let (time, force, error) = (column(&text, "time"), column(&text, "push fy [N]"), column(&text, "error"));
    assert!(time[0] > 1e-3 && time[0] < 1.01e-3, "{time:?}");
    // The ramp begins with the run, and ends 0.2 ms later.
    assert!(force[0].abs() < 50.0 && (force[time.len() / 2] + 1e3).abs() < 1e-6, "{force:?}");
    assert!(error.iter().all(|error| error.abs() < 1e-3), "{error:?}");

    let body = |name: &str| changed.find(&format!("[[body]]\nname = \"{name}\"")).unwrap();
    let without_block = format!("{}{}", &changed[..body("block")], &changed[body("floor")..]);
    bench.write("floor.toml", without_block);
    let run = bench.run(&["run", "floor.toml", "-o", "floor", "--from", "first"]).succeeds();
    assert!(run.stderr.contains("the body \"block\" is gone"), "{}", run.stderr);
}

/// Spheres settle in a box; in a second model one wall is gone, another one moves, and spheres come in.
#[test]
fn spheres_go_on_among_other_walls() {
    const BED: &str = r#"
[model]
end_time = 0.08
gravity = [0, 0, -9.81]
[[material]]
name = "glass"
density = 2500
youngs_modulus = 1e7
poissons_ratio = 0.2
restitution = 0.4
friction = 0.4
[[grains]]
name = "beads"
material = "glass"
count = 60
radius = 0.01
within = { min = [0, 0, 0], max = [0.1, 0.06, 0.08] }
[[wall]]
name = "floor"
material = "glass"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
[[wall]]
name = "left"
material = "glass"
plane = { point = [0, 0, 0], normal = [1, 0, 0] }
[[wall]]
name = "front"
material = "glass"
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
[[wall]]
name = "back"
material = "glass"
plane = { point = [0, 0.06, 0], normal = [0, -1, 0] }
[[history]]
name = "bed"
grains = true
"#;
    const RIGHT: &str = "[[wall]]\nname = \"right\"\nmaterial = \"glass\"\nplane = { point = [0.1, 0, 0], normal = [-1, 0, 0] }\n";
    let bench = Bench::new();
    let later = |time: &str| BED.replace("end_time = 0.08", &format!("end_time = {time}"));
    bench.write("bed.toml", format!("{BED}{RIGHT}"));
    bench.write("long.toml", format!("{}{RIGHT}", later("0.1")));
    bench.run(&["run", "bed.toml", "-o", "bed", "-q"]).succeeds();
    // Nothing changes: the same bits as one run.
    bench.run(&["run", "long.toml", "-o", "long", "-q"]).succeeds();
    bench.run(&["run", "long.toml", "-o", "again", "--from", "bed", "-q"]).succeeds();
    assert_eq!(summary(&bench, "again")["state_hash"], summary(&bench, "long")["state_hash"]);

    let moves = "plane = { point = [0, 0, 0], normal = [1, 0, 0] }\nvelocity = [0.5, 0, 0]";
    let open = later("0.2").replacen("plane = { point = [0, 0, 0], normal = [1, 0, 0] }", moves, 1);
    let rain = "[[insertion]]\nname = \"rain\"\nmaterial = \"glass\"\ncount = 5\nradius = 0.01\n\
                within = { min = [0.2, 0, 0.2], max = [0.3, 0.06, 0.3] }\nrate = 1000\n";
    bench.write("open.toml", format!("{open}{rain}"));
    let run = bench.run(&["run", "open.toml", "-o", "open", "--from", "bed"]).succeeds();
    for line in [
        "begins with bed at 0.08",
        "the state of 60 spheres",
        "the wall \"left\" has changed, and moves from now on",
        "the wall \"right\" is gone",
    ] {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
    let told = summary(&bench, "open");
    assert_eq!(told["spheres"], 65, "{told}");
    assert!(told["energies"]["error"].as_f64().unwrap().abs() < 1e-3, "{told}");
    let text = history(&bench, "open");
    let (time, count, width) =
        (column(&text, "time"), column(&text, "bed spheres [1]"), column(&text, "bed lx [m]"));
    assert!(time[0] > 0.079 && count[0] == 60.0 && *count.last().unwrap() == 65.0, "{count:?}");
    // The wall pushes the spheres out of the box, whose right side is open.
    assert!(width[0] < 0.11 && *width.last().unwrap() > 0.15, "{width:?}");

    for (text, why) in [
        (
            open.replace("name = \"beads\"", "name = \"sand\""),
            "spheres of \"beads\" go on, and no table has this name",
        ),
        (
            format!(
                "{open}[[grains]]\nname = \"more\"\nmaterial = \"glass\"\nat = [[1, 0.03, 1]]\nradius = 0.01\n"
            ),
            "spheres of \"more\" are new",
        ),
    ] {
        bench.write("wrong.toml", text);
        bench.run(&["run", "wrong.toml", "-o", "wrong", "--from", "bed"]).refused_with(&[why]);
    }
}

/// Bonded bodies have common nodes, and continue nevertheless.
#[test]
fn bonded_bodies_go_on() {
    let bench = Bench::new();
    let bond = "[[joint_set]]\nname = \"bond\"\nbetween = [\"block\", \"cap\"]\nfriction_angle = 30\n\
                [[body]]\nname = \"cap\"\nmaterial = \"rock\"\nrectangle = { min = [0, 0.101], max = [0.1, 0.151] }\nmesh_size = 0.025\nvelocity = [1, -8]\n";
    bench.write("first.toml", CRASH.to_owned() + bond);
    bench.write("long.toml", CRASH.replace("end_time = 1e-3", "end_time = 1.5e-3") + bond);
    bench.run(&["run", "first.toml", "-o", "first", "-q"]).succeeds();
    bench.run(&["run", "long.toml", "-o", "long", "-q"]).succeeds();
    bench.run(&["run", "long.toml", "-o", "next", "--from", "first", "-q"]).succeeds();
    assert_eq!(summary(&bench, "next")["state_hash"], summary(&bench, "long")["state_hash"]);
}

#[test]
fn what_does_not_fit_to_the_other_run_is_refused() {
    let bench = Bench::new();
    bench.write("first.toml", CRASH);
    bench.run(&["run", "first.toml", "-o", "first", "-q"]).succeeds();
    let long = CRASH.replace("end_time = 1e-3", "end_time = 2e-3");
    let wrong = |from: &str, to: &str, parts: &[&str]| {
        assert!(long.contains(from), "{from}");
        bench.write("wrong.toml", long.replacen(from, to, 1));
        bench.run(&["run", "wrong.toml", "-o", "out", "--from", "first"]).refused_with(parts);
        assert!(!bench.path("out").exists());
    };
    wrong("end_time = 2e-3", "end_time = 1e-3", &["end_time", "time continues"]);
    wrong("mesh_size = 0.025", "mesh_size = 0.02", &["\"block\"", "another mesh"]);
    wrong("[[material]]", "[initial]\nstress = [1, 1, 0]\n[[material]]", &["initial stress"]);
    wrong("end_time = 2e-3", "end_time = 2e-3\ntime_step = 1e-9", &["time step"]);
    wrong("gravity", "plane = \"strain\"\ngravity", &["plane"]);
    wrong("[output]", "[fracture]\ninsertion = \"intrinsic\"\n[output]", &["insertion"]);
    let strengths = "tensile_strength = 1e6\ncohesion = 3e6\nfriction_angle = 30\nfracture_energy_i = 5\nfracture_energy_ii = 20\n";
    wrong(strengths, "", &["\"rock\"", "lost its strengths"]);
    bench.write("long.toml", &long);
    bench
        .run(&["run", "long.toml", "-o", "out", "--from", "nothing"])
        .refused_with(&["nothing", "no checkpoint"]);
    // Much stiffer than before, so that the time step is too long.
    wrong("youngs_modulus = 5e9", "youngs_modulus = 5e11", &["time step", "critical"]);
}
