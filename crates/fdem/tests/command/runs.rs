//! Tests of `fdem run` and `fdem resume`: results, interrupts, kills, runs that stop or cannot be resumed.

mod damaged;
mod killed;

use std::collections::BTreeMap;
use std::fs;
use std::process::{Child, Stdio};
use std::thread;
use std::time::Duration;

use serde_json::Value;

use crate::{Bench, thorough};

/// A block of some hundred elements falls on a floor and breaks.
const CRASH: &str = r#"
[model]
title = "crash"
plane = "strain"
end_time = 0.8e-3
[[body]]
name = "floor"
material = "rock"
rectangle = { min = [-0.2, -0.1], max = [0.2, 0] }
mesh_size = 0.03
[[body]]
name = "block"
material = "rock"
rectangle = { min = [-0.05, 0.0005], max = [0.05, 0.1] }
mesh_size = 0.015
velocity = [1, -20]
[[material]]
name = "rock"
density = 2700
youngs_modulus = 10e9
poissons_ratio = 0.2
damping = 0.05
friction = 0.4
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
frames = 8
checkpoint_steps = 40
acoustic_emission = {}
[[curve]]
name = "impact"
x = "time"
y = "ground fy"
[[history]]
name = "block on floor"
contact_force = ["block", "floor"]
[[history]]
name = "core"
stress = "mean"
body = "block"
box = [-0.03, 0.02, 0.03, 0.08]
[[history]]
name = "width"
gauge = [[-0.04, 0.05], [0.04, 0.05]]
[[history]]
name = "support"
reaction = "outer"
body = "floor"
[[history]]
name = "ground"
force = "ground"
[[history]]
name = "corner"
node = [0.05, 0.1]
body = "block"
"#;

/// A projectile hits grains: joints open as hinges, turn far, and close again.
const GRAINS: &str = r#"
[model]
end_time = 0.008
[[body]]
name = "grains"
material = "rock"
packing = { count = 8, radius = [0.01, 0.02], within = { min = [0,0], max = [0.1, 0.1] }, gap = 0.001, shape = "polygon", seed = 2 }
mesh_size = 0.008
[[body]]
name = "bullet"
material = "steel"
disc = { centre = [-0.03, 0.05], radius = 0.02 }
mesh_size = 0.008
velocity = [40, 0]
[[material]]
name = "rock"
density = 2500
youngs_modulus = 1e9
poissons_ratio = 0.25
friction = 0.4
tensile_strength = 2e6
cohesion = 5e6
friction_angle = 30
fracture_energy_i = 300
fracture_energy_ii = 1000
[[material]]
name = "steel"
density = 7800
youngs_modulus = 5e9
poissons_ratio = 0.3
friction = 0.2
[contact]
damping = 0.05
[output]
frames = 2
"#;

/// A bar in space that is torn apart. Its ends are held in all directions, so that it breaks between them.
const TORN: &str = r#"
[model]
end_time = 0.4e-3
[[body]]
name = "bar"
material = "rock"
box = { min = [0, 0, 0], max = [0.08, 0.02, 0.02] }
mesh_size = 0.01
[[material]]
name = "rock"
density = 2500
youngs_modulus = 5e9
poissons_ratio = 0.2
damping = 0.05
friction = 0.4
tensile_strength = 1e6
cohesion = 3e6
friction_angle = 30
fracture_energy_i = 1
fracture_energy_ii = 5
[[boundary]]
name = "left"
side = "left"
velocity = [-1, 0, 0]
[[boundary]]
name = "right"
side = "right"
velocity = [1, 0, 0]
[fracture]
joint_penalty = 10
[output]
frames = 2
"#;

impl Bench {
    fn of(model: &str) -> Self {
        let bench = Self::new();
        bench.write("crash.toml", model);
        bench
    }

    fn summary(&self, folder: &str) -> Value {
        self.json(&format!("{folder}/run.json"))
    }

    /// The columns of a table, by name.
    pub(crate) fn columns(&self, name: &str) -> BTreeMap<String, Vec<f64>> {
        let text = self.read(name);
        let mut lines = text.lines().map(|line| line.split(','));
        let mut columns: Vec<(String, Vec<f64>)> =
            lines.next().unwrap().map(|name| (name.to_owned(), Vec::new())).collect();
        for line in lines {
            for ((_, values), value) in columns.iter_mut().zip(line) {
                values.push(value.parse().unwrap_or(f64::NAN));
            }
        }
        columns.into_iter().collect()
    }

    fn start(&self, arguments: &[&str]) -> Child {
        self.command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// Asserts that a folder has the results of a fingerprint. Fails with the first difference.
    fn is_like(&self, folder: &str, (hash, history, frames): &(String, String, Vec<(String, Vec<u8>)>)) {
        let found = self.fingerprint(folder);
        for (line, (a, b)) in found.1.lines().zip(history.lines()).enumerate() {
            assert_eq!(a, b, "line {}", line + 1);
        }
        assert_eq!(found.1.len(), history.len());
        assert_eq!(found.0, *hash);
        for ((name, bytes), (other, expected)) in found.2.iter().zip(frames) {
            assert_eq!(name, other);
            assert!(bytes == expected, "{name}");
        }
        assert_eq!(found.2.len(), frames.len());
    }

    /// Asserts that the collections of a folder are complete, and that the files that they name exist.
    pub(crate) fn has_all_that_collections_name(&self, folder: &str) {
        for name in ["results.pvd", "cracks.pvd", "damaged_joints.pvd", "intact_joints.pvd", "contacts.pvd"] {
            let Ok(text) = fs::read_to_string(self.path(folder).join(name)) else { continue };
            assert!(text.ends_with("</VTKFile>\n"), "{name}: {text}");
            let files = text.split("file=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
            for file in files {
                assert!(self.path(folder).join(file).exists(), "{name} names {file}");
            }
        }
    }

    /// Results that must not depend on interruptions: hash of the state, history, frames.
    fn fingerprint(&self, folder: &str) -> (String, String, Vec<(String, Vec<u8>)>) {
        let json = self.summary(folder);
        assert_eq!(json["status"], "finished");
        let mut frames: Vec<(String, Vec<u8>)> = fs::read_dir(self.path(folder).join("frames"))
            .unwrap()
            .map(|entry| entry.unwrap())
            .map(|entry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap()))
            .collect();
        frames.sort();
        let mut rows = self.read(&format!("{folder}/history.csv"));
        if self.path(&format!("{folder}/events.csv")).exists() {
            rows += &self.read(&format!("{folder}/events.csv"));
        }
        (json["state_hash"].to_string(), rows, frames)
    }
}

/// Joints that had turned far about one of their ends once pushed their elements apart, and returned a fifth
/// of the dissipated energy.
#[test]
fn joints_do_not_give_back_what_they_have_dissipated() {
    let bench = Bench::of(GRAINS);
    bench.run(&["run", "crash.toml", "-q"]).succeeds();
    let history = bench.read("crash_results/history.csv");
    let mut lines = history.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "joint_dissipated").unwrap();
    let (mut most, mut fall) = (0.0_f64, 0.0_f64);
    for line in lines {
        let dissipated: f64 = line.split(',').nth(column).unwrap().parse().unwrap();
        most = most.max(dissipated);
        fall = fall.max(most - dissipated);
    }
    assert!(most > 500.0 && fall < 0.01 * most, "{fall} of {most}");
}

#[test]
fn force_replaces_runs_and_nothing_else() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.01e-3"));
    fs::create_dir_all(bench.path("mine/plots")).unwrap();
    bench.write("mine/plots/thesis.svg", "drawn by hand");
    bench.write("mine/model.toml", "mine");
    bench.run(&["run", "crash.toml", "-q", "--force", "-o", "mine"]).refused_with(&["mine", "has no run"]);
    // Before the model is looked at, because large ones take long to mesh.
    bench.write("wrong.toml", "[model]\n");
    bench.run(&["run", "wrong.toml", "-q", "-o", "mine"]).refused_with(&["mine", "not empty"]);
    assert_eq!(bench.read("mine/plots/thesis.svg"), "drawn by hand");
    assert_eq!(bench.read("mine/model.toml"), "mine");
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    bench.write("run/notes.txt", "keep");
    bench.run(&["run", "crash.toml", "-q", "--force", "-o", "run"]).succeeds();
    assert_eq!(bench.read("run/notes.txt"), "keep");
}

#[test]
fn a_run_without_a_checkpoint_is_told_how_to_start_again() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.01e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    fs::remove_file(bench.path("run/checkpoint")).unwrap();
    bench.run(&["resume", "-q", "run"]).refused_with(&[
        "the file was deleted",
        "before its first checkpoint",
        "fdem run --force",
    ]);
    bench.run(&["run", "crash.toml", "-q", "--force", "-o", "run"]).succeeds();
}

#[test]
fn one_folder_has_one_run_at_a_time() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "80e-3"));
    let mut first = bench.start(&["run", "crash.toml", "-q", "-o", "run"]);
    while !bench.path("run/checkpoint").exists() {
        assert!(first.try_wait().unwrap().is_none(), "the first run is over");
        thread::sleep(Duration::from_millis(5));
    }
    bench.run(&["run", "crash.toml", "-q", "--force", "-o", "run"]).refused_with(&["another fdem", "run"]);
    bench.run(&["resume", "-q", "run"]).refused_with(&["another fdem", "run"]);
    first.kill().unwrap();
    first.wait().unwrap();
    // A process that has ended holds no lock.
    let mut second = bench.start(&["resume", "-q", "run"]);
    thread::sleep(Duration::from_millis(200));
    assert!(second.try_wait().unwrap().is_none());
    second.kill().unwrap();
    second.wait().unwrap();
}

/// Two runs that are started at the same moment in one folder: one has it, and the other changes nothing.
#[test]
fn of_two_runs_started_at_once_one_has_the_folder() {
    let model = CRASH.replace("0.8e-3", "0.01e-3");
    let bench = Bench::of(&model);
    bench.write("faster.toml", model.replace("-20", "-21"));
    let models = ["crash.toml", "faster.toml"];
    let alone = models.map(|model| {
        bench.run(&["run", model, "-q", "-o", "alone", "--force"]).succeeds();
        bench.summary("alone")["state_hash"].clone()
    });
    assert_ne!(alone[0], alone[1]);
    for _ in 0..if thorough() { 24 } else { 6 } {
        let both = models.map(|model| {
            let mut command = bench.command(&["run", model, "-q", "-o", "both"]);
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        });
        let ended = both.map(|child| child.wait_with_output().unwrap());
        let codes = ended.each_ref().map(|output| output.status.code());
        let first = codes.iter().position(|code| *code == Some(0));
        let first = first.unwrap_or_else(|| panic!("both have failed: {ended:?}"));
        let other = String::from_utf8_lossy(&ended[1 - first].stderr);
        assert_eq!(codes[1 - first], Some(2), "{other}");
        let holds = other.contains("another fdem process is using both") && other.contains("process ");
        assert!(holds || other.contains("both is not empty"), "{other}");
        assert_eq!(bench.summary("both")["state_hash"], alone[first]);
        assert_eq!(bench.read("both/model.toml"), bench.read(models[first]));
        fs::remove_dir_all(bench.path("both")).unwrap();
    }
}

#[test]
fn an_animation_is_written_if_it_is_asked_for() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.01e-3"));
    bench.run(&["run", "crash.toml", "--animate=damaged"]).refused_with(&["damaged", "max_principal"]);
    assert!(!bench.path("crash_results").exists());
    bench.run(&["run", "--quiet", "crash.toml"]).succeeds();
    assert!(!bench.path("crash_results/animation.gif").exists());
    for option in ["--animate", "--animate=damage"] {
        bench.run(&["run", "--quiet", "--force", option, "crash.toml"]).succeeds();
        let gif = fs::read(bench.path("crash_results/animation.gif")).unwrap();
        assert!(gif.starts_with(b"GIF89a"), "{option}");
    }
}

#[test]
fn a_run_writes_all_that_it_promises_and_is_not_overwritten() {
    let bench = Bench::of(CRASH);
    let told = bench.run(&["run", "crash.toml", "--threads", "1"]).succeeds();
    assert!(told.stdout.contains("results are in crash_results"), "{}", told.stdout);
    assert!(told.stderr.contains("100 %") && told.stderr.contains("balance"), "{}", told.stderr);
    for file in
        ["results.pvd", "cracks.pvd", "report.html", "picture.png", "run.log", "checkpoint", "model.toml"]
    {
        assert!(bench.path("crash_results").join(file).metadata().unwrap().len() > 0, "{file}");
    }
    for plot in ["energies", "energy_error", "crack_growth", "fragments", "fragment_sizes"] {
        for format in ["svg", "png"] {
            assert!(
                bench.path("crash_results/plots").join(format!("{plot}.{format}")).exists(),
                "{plot}.{format}"
            );
        }
    }
    assert!(told.stderr.contains("% of the run (9 frames, "), "{}", told.stderr);
    let json = bench.summary("crash_results");
    let output = &json["output"];
    assert_eq!(output["frames"], 9);
    assert!(output["checkpoints"].as_u64().unwrap() >= 3, "{output}");
    assert!((0.0..=1.0).contains(&output["share"].as_f64().unwrap()), "{output}");
    assert!(json["broken_joints"].as_u64().unwrap() > 5, "{json}");
    assert!(json["energies"]["error"].as_f64().unwrap().abs() < 0.02, "{json}");
    assert!(told.stderr.contains("% of the mass; half of the mass passes"), "{}", told.stderr);
    fragments_agree(&bench, "crash_results", 2700.0 * (0.4 * 0.1 + 0.1 * 0.0995));
    let frames = bench.fingerprint("crash_results").2;
    assert_eq!(frames.len(), 5 * 9, "a frame at the beginning and eight more");
    let history = bench.read("crash_results/history.csv");
    let names = history.lines().next().unwrap();
    assert!(
        names.ends_with(
            "ground fx [N],ground fy [N],ground ux [m],ground uy [m],corner ux [m],corner uy [m],corner vx [m/s],corner vy [m/s]"
        ),
        "{names}"
    );

    probes_agree(&bench);

    bench.run(&["run", "crash.toml"]).refused_with(&["not empty", "--force"]);
    bench.write("crash_results/notes.txt", "mine");
    let forced = bench.run(&["run", "crash.toml", "--force", "--threads", "2", "--quiet"]).succeeds();
    assert_eq!(forced.stderr, "");
    assert_eq!(bench.read("crash_results/notes.txt"), "mine");
    assert_eq!(bench.summary("crash_results")["state_hash"], json["state_hash"], "threads change nothing");
}

/// Asserts that the probes of a crash give known values.
fn probes_agree(bench: &Bench) {
    let history = bench.columns("crash_results/history.csv");
    let most = |name: &str| history[name].iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    for name in ["block on floor fx [N]", "core syy [Pa]", "core sxy [Pa]", "width strain [m/m]"] {
        let (first, most) = (history[name][0], most(name));
        assert!(
            first.abs() <= 1e-12 * most && most > 0.0 && most.is_finite(),
            "{name}: from {first} to {most}"
        );
    }
    // The block pushes the floor down, and only the ground holds the outline of the floor.
    let least = history["block on floor fy [N]"].iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(least, -most("block on floor fy [N]"), "the largest force is downwards");
    for (support, ground) in history["support fy [N]"].iter().zip(&history["ground fy [N]"]) {
        assert!((support - ground).abs() <= 1e-9 * most("ground fy [N]"), "{support} {ground}");
    }
    let json = bench.summary("crash_results");
    let curve = &json["curves"][0];
    assert_eq!(curve["name"], "impact");
    assert_eq!(curve["peak"].as_f64().unwrap().abs(), most("ground fy [N]"));
    let emission = &json["acoustic_emission"];
    let count = |name: &str| emission[name].as_u64().unwrap();
    let broken = json["broken_joints"].as_u64().unwrap();
    assert!(
        count("softening_joints") > 0 && count("joints") == broken + count("softening_joints"),
        "{emission}"
    );
    let events = bench.columns("crash_results/events.csv");
    assert_eq!(events["event"].len() as u64, count("events"));
    let text = bench.read("crash_results/events.csv");
    let of_kind = |kind: &str| -> [u64; 2] {
        let rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>()).filter(|row| row[1] == kind);
        rows.fold([0; 2], |[events, joints], row| [events + 1, joints + row[2].parse::<u64>().unwrap()])
    };
    assert_eq!(of_kind("break"), [count("events") - count("softening_events"), broken]);
    assert_eq!(of_kind("softening"), ["softening_events", "softening_joints"].map(count));
    assert!(events["time [s]"].is_sorted() && events["energy [J]"].iter().all(|&energy| energy > 0.0));
    for name in
        ["histories_forces", "histories_stresses", "histories_strains", "curve_impact", "acoustic_emission"]
    {
        assert!(bench.path(&format!("crash_results/plots/{name}.svg")).exists(), "{name}");
    }
}

/// Asserts that the table of fragments, the last row of the history and the summary say the same, and that
/// the mass is complete.
fn fragments_agree(bench: &Bench, folder: &str, mass: f64) {
    let table = bench.columns(&format!("{folder}/fragments.csv"));
    let masses = &table["mass"];
    let all: f64 = masses.iter().sum();
    assert!((all / mass - 1.0).abs() < 1e-9, "{all} kg of {mass} kg");
    assert!(masses.is_sorted_by(|a, b| a >= b), "{masses:?}");
    assert!(table["counted"].iter().all(|&counted| counted == 1.0));
    let json = bench.summary(folder);
    let history = bench.columns(&format!("{folder}/history.csv"));
    let numbers = &history["fragments"];
    assert!(numbers[0] < numbers[numbers.len() - 1] && numbers.is_sorted(), "{numbers:?}");
    assert_eq!(numbers.last(), Some(&(masses.len() as f64)));
    assert_eq!(json["fragments"]["number"].as_f64(), numbers.last().copied());
    let largest = json["fragments"]["largest"].as_f64().unwrap();
    assert!((largest - masses[0] / all).abs() < 1e-12);
    assert!((history["largest_fragment"].last().unwrap() - largest).abs() < 1e-12);
    let [d20, d50, d80] = ["d20", "d50", "d80"].map(|name| json["fragments"][name].as_f64().unwrap());
    assert!(0.0 < d20 && d20 <= d50 && d50 <= d80, "{d20} {d50} {d80}");
    assert!(d80 <= table["diameter"].iter().copied().fold(0.0, f64::max));
}

#[test]
fn a_bar_in_space_that_is_torn_apart_leaves_fragments() {
    let bench = Bench::of(TORN);
    bench.run(&["run", "crash.toml", "-q"]).succeeds();
    fragments_agree(&bench, "crash_results", 2500.0 * 0.08 * 0.02 * 0.02);
    let table = bench.columns("crash_results/fragments.csv");
    // The two ends, which are pulled apart, and possibly fragments that broke off between them.
    let [one, other] = [0, 1].map(|k| [table["mass"][k], table["x"][k], table["vx"][k]]);
    assert!(one[0] + other[0] > 0.5 * 2500.0 * 0.08 * 0.02 * 0.02, "{one:?} {other:?}");
    assert!((one[2] - other[2]) * (one[1] - other[1]) > 0.0, "{one:?} {other:?}");
    assert!(bench.path("crash_results/plots/fragment_sizes.svg").exists());
    assert!(bench.read("crash_results/report.html").contains("of the mass; half of the mass passes"));
}

#[test]
fn fragments_are_counted_in_the_bodies_that_are_named() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.01e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "all"]).succeeds();
    bench.write(
        "crash.toml",
        bench.read("crash.toml").replace("[output]", "[output]\nfragments = [\"block\"]"),
    );
    bench.run(&["run", "crash.toml", "-q", "-o", "block"]).succeeds();
    for (folder, counted) in [("all", vec![1.0, 1.0]), ("block", vec![0.0, 1.0])] {
        let number = counted.iter().sum::<f64>();
        assert_eq!(bench.summary(folder)["fragments"]["number"], number as u64, "{folder}");
        assert_eq!(bench.columns(&format!("{folder}/fragments.csv"))["counted"], counted);
        let numbers = &bench.columns(&format!("{folder}/history.csv"))["fragments"];
        assert!(numbers.iter().all(|&found| found == number), "{folder}: {numbers:?}");
        assert!(!bench.path(folder).join("plots/fragments.svg").exists(), "nothing has broken");
    }
}

/// A report of more than a million elements was once refused, and the summary of the run was lost with it.
#[test]
fn a_mesh_that_is_too_large_for_a_page_is_shown_by_a_sample() {
    let bench = Bench::of(&CRASH.replace("[output]", "[output]\nshown_elements = 120"));
    bench.run(&["run", "crash.toml", "--animate", "-q", "-o", "run"]).succeeds();
    let json = bench.summary("run");
    assert_eq!(json["status"], "finished");
    let elements = json["elements"].as_u64().unwrap();
    assert!(elements > 200, "{elements}");
    let page = bench.read("run/report.html");
    assert!(page.contains(&format!("The mesh has {elements} elements. The view shows a sample")));
    for file in ["picture.png", "animation.gif", "plots/energies.svg"] {
        assert!(bench.path("run").join(file).exists(), "{file}");
    }
    // The files for ParaView are whole.
    let mesh = fs::read(bench.path("run/frames/00003.vtu")).unwrap();
    let head = String::from_utf8_lossy(&mesh[..1000]).into_owned();
    assert!(head.contains(&format!("NumberOfCells=\"{elements}\"")), "{head}");
}

/// The summary says how the run ended, whether or not the pictures can be drawn.
#[test]
fn a_page_that_cannot_be_written_does_not_take_the_run_with_it() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    fs::remove_file(bench.path("run/report.html")).unwrap();
    fs::create_dir(bench.path("run/report.html")).unwrap();
    let longer = ["resume", "-q", "run", "--end-time", "0.06e-3"];
    let told = bench.run(&longer);
    assert_eq!(told.code, Some(2), "{}", told.stderr);
    assert!(told.stderr.contains("report.html"), "{}", told.stderr);
    assert_eq!(bench.summary("run")["status"], "finished");
    // Once there is room for the page it is made, without a step.
    fs::remove_dir(bench.path("run/report.html")).unwrap();
    bench.run(&["resume", "-q", "run"]).succeeds();
    assert!(bench.path("run/report.html").exists());
}

#[test]
fn a_finished_run_has_nothing_left_to_do() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let files = ["run.json", "report.html", "history.csv", "checkpoint", "run.log"];
    let all = || files.map(|name| fs::read(bench.path("run").join(name)).unwrap());
    let before = all();
    let told = bench.run(&["resume", "run"]).succeeds();
    assert!(told.stdout.contains("nothing to do") && told.stdout.contains("--end-time"), "{}", told.stdout);
    assert!(all() == before, "a file changed");
    bench.run(&["resume", "run", "--end-time", "0.01e-3"]).refused_with(&["has reached", "end_time"]);
    bench.run(&["resume", "run", "--end-time", "0"]).refused_with(&["above 0"]);
    assert!(all() == before, "a file changed");
    // An animation is something to do.
    bench.run(&["resume", "-q", "run", "--animate"]).succeeds();
    assert!(bench.path("run/animation.gif").exists());
}

#[test]
fn a_run_with_a_later_end_is_the_run_that_had_it_from_the_beginning() {
    let output = "[output]\ninterval = 0.1e-3\nhistory_interval = 1e-6\ncheckpoint_steps = 40\n";
    let model = CRASH.replace("[output]\nframes = 8\ncheckpoint_steps = 40\n", output);
    let bench = Bench::of(&model);
    bench.run(&["run", "crash.toml", "-q", "-o", "whole"]).succeeds();
    bench.write("crash.toml", model.replace("end_time = 0.8e-3", "end_time = 0.4e-3 # half"));
    bench.run(&["run", "crash.toml", "-q", "-o", "parts"]).succeeds();
    bench.run(&["resume", "parts", "-q", "--end-time", "0.8e-3"]).succeeds();
    bench.is_like("parts", &bench.fingerprint("whole"));
    assert_eq!(bench.read("parts/fragments.csv"), bench.read("whole/fragments.csv"));
    assert!(bench.read("parts/model.toml").contains("end_time = 0.0008 # half"));
}

#[test]
fn a_resumed_run_keeps_its_account() {
    let bench = Bench::of(CRASH);
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let before = bench.summary("run");
    // A hundredth more: the time of this part alone would be less.
    bench.run(&["resume", "-q", "run", "--end-time", "0.808e-3"]).succeeds();
    let after = bench.summary("run");
    let number = |json: &Value, key: &str| json["seconds"][key].as_f64().unwrap();
    for key in ["bulk", "joints", "detection", "contact_force", "integration", "output", "drawing", "total"] {
        assert!(number(&after, key) > number(&before, key), "{key}: {after} after {before}");
    }
    let detections = |json: &Value| json["detections"].as_u64().unwrap();
    assert!(detections(&before) > 1 && detections(&after) > detections(&before), "{after} after {before}");
}

#[test]
fn the_history_begins_before_the_first_step() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q"]).succeeds();
    let history = bench.read("crash_results/history.csv");
    let mut lines = history.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let (names, first) = (lines.next().unwrap(), lines.next().unwrap());
    let value = |name: &str| {
        let place = names.iter().position(|other| *other == name).unwrap();
        first[place].parse::<f64>().unwrap()
    };
    assert_eq!([value("step"), value("time")], [0.0; 2]);
    let kinetic = 0.5 * 2700.0 * 0.1 * 0.0995 * 401.0;
    assert!((value("kinetic") / kinetic - 1.0).abs() < 1e-9, "{}", value("kinetic"));
    let motion = ["corner ux [m]", "corner uy [m]", "corner vx [m/s]", "corner vy [m/s]"].map(value);
    assert_eq!(motion, [0.0, 0.0, 1.0, -20.0]);
}

#[test]
fn columns_of_a_history_cannot_change_on_the_way() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let other = bench.read("run/model.toml").replace("name = \"corner\"", "name = \"edge\"");
    bench.write("run/model.toml", other);
    bench.run(&["resume", "-q", "run", "--end-time", "0.06e-3"]).refused_with(&[
        "history.csv",
        "columns",
        "[[history]]",
    ]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_message_that_cannot_be_written_is_an_error() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.01e-3"));
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = bench.command(&["run", "crash.toml", "-q"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("cannot write standard output"));
    assert_eq!(bench.summary("crash_results")["status"], "finished");
}

/// The model in a folder of results has its meshes in `inputs/`.
#[test]
fn the_model_of_a_run_can_be_run_again() {
    let model = CRASH
        .replace(
            "rectangle = { min = [-0.05, 0.0005], max = [0.05, 0.1] }\nmesh_size = 0.015",
            "mesh = \"block.obj\"",
        )
        .replace("[-0.03, 0.02, 0.03, 0.08]", "[0, 0, 1, 1]")
        .replace("[[-0.04, 0.05], [0.04, 0.05]]", "[[0.02, 0.015], [0.045, 0.05]]")
        .replace("0.8e-3", "0.01e-3");
    let bench = Bench::of(&model);
    bench.write("block.obj", "v 0 0.01 0\nv 0.05 0.01 0\nv 0.05 0.06 0\nv 0.05 0.1 0\nf 1 2 3\nf 1 3 4\n");
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    fs::remove_file(bench.path("block.obj")).unwrap();
    bench.run(&["check", "run/model.toml"]).succeeds();
    bench.run(&["run", "run/model.toml", "-q", "-o", "again"]).succeeds();
    assert_eq!(bench.summary("run")["state_hash"], bench.summary("again")["state_hash"]);
    // A mesh that has changed is named, and not the model.
    bench.write("run/inputs/0", bench.read("run/inputs/0").replace("0.05 0.1 0", "0.06 0.1 0"));
    bench.run(&["resume", "-q", "run"]).refused_with(&["inputs/0", "its contents have changed"]);
    bench.run(&["run", "run/model.toml", "-q", "-o", "next", "--from", "run"]).refused_with(&["inputs/0"]);
}

/// An interval that is nothing has a frame each step, and curves of other names other files.
#[test]
fn short_intervals_and_names_that_differ_in_few_letters() {
    let curve = |name: &str| format!("[[curve]]\nname = \"{name}\"\nx = \"time\"\ny = \"kinetic\"\n");
    // File systems allow 255 bytes, and a letter may take three.
    let long = "長".repeat(82);
    let curves = ["σ", "τ", "a b", "a-b", &format!("{long}1"), &format!("{long}2")].map(curve).concat();
    let bench = Bench::of(&format!("{}{curves}", CRASH.replace("frames = 8", "interval = 1e-29")));
    let set =
        ["--set", "output.interval=1e-29", "--set", "model.end_time=1e-6", "--set", "body.block.seed=0"];
    bench.run(&[&["run", "crash.toml", "-o", "short", "-q"][..], &set].concat()).succeeds();
    let steps = bench.summary("short")["steps"].as_u64().unwrap();
    assert!(bench.path(&format!("short/frames/{steps:05}.vtu")).exists(), "{steps}");
    let cut = format!("curve_{}", "長".repeat(64));
    for name in ["curve_σ", "curve_τ", "curve_a_b", "curve_a_b-2", &cut, &format!("{cut}-2")] {
        assert!(bench.path(&format!("short/plots/{name}.svg")).exists(), "{name}");
    }
}

/// The thread that writes results cannot continue without its folder, and the run ends with it.
#[test]
fn results_that_cannot_be_written_stop_the_run() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "80e-3").replace("frames = 8", "frames = 8000"));
    let child =
        bench.command(&["run", "crash.toml", "-q", "-o", "run"]).stderr(Stdio::piped()).spawn().unwrap();
    while !bench.path("run/frames/00003.frame").exists() {
        thread::sleep(Duration::from_millis(5));
    }
    fs::rename(bench.path("run/frames"), bench.path("run/elsewhere")).unwrap();
    let output = child.wait_with_output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("cannot write run/frames"), "{told}");
    let status = bench.summary("run")["status"].to_string();
    assert!(status.contains("stopped: cannot write run/frames"), "{status}");
    let names = fs::read_dir(bench.path("run")).unwrap();
    let names: Vec<_> = names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert!(!names.iter().any(|name| name.starts_with(".fdem-")), "partial files are left: {names:?}");
    // Once the folder is back, the run continues from its checkpoint.
    fs::rename(bench.path("run/elsewhere"), bench.path("run/frames")).unwrap();
    let mut second = bench.start(&["resume", "-q", "run"]);
    while !bench.path("run/frames/00008.frame").exists() {
        assert!(second.try_wait().unwrap().is_none(), "the run is over");
        thread::sleep(Duration::from_millis(5));
    }
    second.kill().unwrap();
    second.wait().unwrap();
}

#[test]
fn a_run_that_blows_up_says_where_and_keeps_its_checkpoint() {
    let model = CRASH.replace("title", "time_step = 2e-5\nsafety = 1.0\ntitle");
    let bench = Bench::of(&model);
    let told = bench.run(&["run", "crash.toml", "--output", "bad", "--quiet"]);
    assert_eq!(told.code, Some(1), "{}", told.stderr);
    assert!(told.stderr.contains("step ") && told.stderr.contains("element "), "{}", told.stderr);
    let json = bench.summary("bad");
    assert!(json["status"].as_str().unwrap().starts_with("stopped: "), "{json}");
    assert!(bench.path("bad/checkpoint").exists() && bench.path("bad/frames/00001.vtu").exists());
}

#[test]
fn what_cannot_run_leaves_no_folder() {
    let bench = Bench::of(&CRASH.replace("density = 2700", "density = -1"));
    bench.run(&["run", "crash.toml"]).refused_with(&["density"]);
    assert!(!bench.path("crash_results").exists());
    for (folder, message) in
        [("nothing", "no checkpoint"), ("torn", "damaged"), ("old", "not a checkpoint of this version")]
    {
        if folder != "nothing" {
            fs::create_dir(bench.path(folder)).unwrap();
        }
        if folder == "torn" {
            bench.write("torn/checkpoint", [b"fdem checkpoint 6\n".as_slice(), &[7; 100]].concat());
        }
        if folder == "old" {
            bench.write("old/checkpoint", "fdem checkpoint 0\n");
        }
        bench.run(&["resume", folder]).refused_with(&[message]);
    }
}
