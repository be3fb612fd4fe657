//! Runs in stages: excavation, released forces, resumed runs; ground at rest.

use serde_json::Value;

use crate::Bench;

/// A core that is excavated from stressed rock, half of whose support is released immediately and the rest
/// later; a block that is put on top then.
const TUNNEL: &str = r#"
[model]
plane = "strain"
end_time = 6e-3
[[body]]
name = "rock"
material = "rock"
polygon = { points = [[-5, -5], [5, -5], [5, 5], [-5, 5]], holes = [{ centre = [0, 0], radius = 1.5 }] }
mesh_size = 1.2
[[body]]
name = "core"
material = "rock"
disc = { centre = [0, 0], radius = 1.5 }
mesh_size = 1.2
[[body]]
name = "block"
material = "rock"
rectangle = { min = [-1, 5], max = [1, 6] }
mesh_size = 1.0
[[material]]
name = "rock"
density = 2700
youngs_modulus = 10e9
poissons_ratio = 0.25
friction = 0.6
damping = 0.2
[initial]
stress = [-5e6, -5e6, 0]
[[boundary]]
name = "sides"
body = "rock"
group = "outer"
fixed = "xy"
[[boundary]]
name = "hammer"
body = "block"
velocity = [0, -1]
stages = ["strike"]
[[stage]]
name = "rest"
equilibrium = 1e-6
duration = 1e-3
[[stage]]
name = "excavate"
excavate = ["core"]
release = [[0, 1], [5e-4, 0.5]]
local_damping = 0.7
duration = 2e-3
[[stage]]
name = "strike"
activate = ["block"]
duration = 1e-3
[[history]]
name = "crown"
node = [0, 1.5]
body = "rock"
[[history]]
name = "core"
node = [0, 0]
body = "core"
[[history]]
name = "hammer"
force = "hammer"
[output]
frames = 12
checkpoint_steps = 5
"#;

/// The numbers of a column of a history.
pub(crate) fn column(history: &str, name: &str) -> Vec<f64> {
    let place = history.lines().next().unwrap().split(',').position(|column| column == name);
    let place = place.unwrap_or_else(|| panic!("no column {name}"));
    history.lines().skip(1).map(|row| row.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

#[test]
fn a_run_goes_through_its_stages() {
    let bench = Bench::new();
    bench.write("tunnel.toml", TUNNEL);
    let run = bench.run(&["run", "tunnel.toml", "-o", "one", "--threads", "1"]).succeeds();
    for line in [
        "stage \"rest\" ends at",
        "equilibrium",
        "stage \"excavate\" begins",
        "its time has passed",
        "stages",
    ] {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
    let lost =
        "warning: [[history]] \"core\" has NaN from this stage on: the part that it measures is not there";
    assert_eq!(run.stderr.matches(lost).count(), 1, "{}", run.stderr);
    assert_eq!(run.stderr.matches("has NaN").count(), 1, "{}", run.stderr);
    let history = String::from_utf8(std::fs::read(bench.path("one/history.csv")).unwrap()).unwrap();
    // It ends with its last stage.
    let end = *column(&history, "time").last().unwrap();
    assert!((3e-3..4.1e-3).contains(&end), "{end}");
    // Half of the convergence of the whole ring is (1 + ν) p a/(2 E) in infinite rock: 0.7 mm; less so near
    // to sides that are held.
    let crown = column(&history, "crown uy [m]");
    assert!((-0.7e-3..-0.3e-3).contains(crown.last().unwrap()), "{:?}", crown.last());
    let core = column(&history, "core ux [m]");
    assert!(core[0] == 0.0 && core.last().unwrap().is_nan(), "{core:?}");
    let hammer = column(&history, "hammer fy [N]");
    assert!(hammer[hammer.len() / 2] == 0.0 && hammer.last().unwrap().abs() > 0.0, "{hammer:?}");
    let summary: Value = serde_json::from_slice(&std::fs::read(bench.path("one/run.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "finished");
    let stages = summary["stages"].as_array().unwrap().iter().map(|stage| stage["name"].as_str().unwrap());
    assert_eq!(stages.collect::<Vec<_>>(), ["rest", "excavate", "strike"]);
    let error = column(&history, "error");
    assert!(error.iter().all(|error| error.abs() < 1e-3), "{error:?}");
    // It is finished, although its end time is later.
    let again = bench.run(&["resume", "one"]).succeeds();
    assert!(again.stdout.contains("nothing to do"), "{}", again.stdout);

    let checked = bench.run(&["check", "tunnel.toml"]).succeeds();
    assert!(checked.stdout.contains("elements"), "{}", checked.stdout);

    // A later stage may have the shortest step; a step that the model gives is nobody's.
    let later = "of the first stage; a later one has a shorter one";
    let told = |text: String| {
        bench.write("steps.toml", text);
        bench.run(&["check", "steps.toml"]).succeeds().stdout
    };
    let fine = told(TUNNEL.replace("mesh_size = 1.0", "mesh_size = 0.2"));
    assert!(fine.contains(later), "{fine}");
    let given = told(TUNNEL.replace("[model]", "[model]\ntime_step = 1e-6"));
    assert!(!given.contains(later), "{given}");
}

/// Wherever a run is interrupted, before or after its elements have changed, it reaches the same end.
#[cfg(unix)]
#[test]
fn a_run_in_stages_is_resumed() {
    let bench = Bench::new();
    bench.write("tunnel.toml", TUNNEL);
    bench.run(&["run", "tunnel.toml", "-o", "one", "--threads", "1", "-q"]).succeeds();
    let hash = |folder: &str| -> Value {
        let summary = std::fs::read(bench.path(&format!("{folder}/run.json"))).unwrap();
        serde_json::from_slice::<Value>(&summary).unwrap()["state_hash"].clone()
    };
    // The time of the checkpoint from which it continues differs from round to round.
    for wait in [30, 120, 250, 400] {
        let mut child = bench.command(&["run", "tunnel.toml", "-o", "two", "--force", "-q"]).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait));
        let _ = child.kill();
        child.wait().unwrap();
        if !bench.path("two/checkpoint").exists() {
            continue;
        }
        bench.run(&["resume", "two", "-q"]).succeeds();
        assert_eq!(hash("two"), hash("one"), "killed after {wait} ms");
        let read = |folder: &str| std::fs::read(bench.path(&format!("{folder}/history.csv"))).unwrap();
        assert!(read("two") == read("one"), "killed after {wait} ms");
    }
}

/// A core that becomes ten times softer lets a part of the convergence of an open tunnel happen.
#[test]
fn a_stage_softens_a_body() {
    let bench = Bench::new();
    let soft = "[[material]]\nname = \"soft\"\ndensity = 2700\nyoungs_modulus = 1e9\npoissons_ratio = 0.25\nfriction = 0.6\ndamping = 0.2\n[initial]";
    let model = TUNNEL.replace("[initial]", soft).replace(
        "excavate = [\"core\"]\nrelease = [[0, 1], [5e-4, 0.5]]",
        "materials = { core = \"soft\" }\nrelease = 5e-4",
    );
    bench.write("soft.toml", &model);
    bench.run(&["run", "soft.toml", "-o", "one", "-q"]).succeeds();
    let history = String::from_utf8(std::fs::read(bench.path("one/history.csv")).unwrap()).unwrap();
    let crown = *column(&history, "crown uy [m]").last().unwrap();
    assert!((-0.7e-3..-0.05e-3).contains(&crown), "{crown}");
    let error = column(&history, "error");
    assert!(error.iter().all(|error| error.abs() < 1e-3), "{error:?}");
    let wrong = |from: &str, to: &str, parts: &[&str]| {
        assert!(model.contains(from), "{from}");
        bench.write("wrong.toml", model.replacen(from, to, 1));
        bench.run(&["check", "wrong.toml"]).refused_with(parts);
    };
    // A core that breaks becomes one that does not.
    let strong = "tensile_strength = 1e7\ncohesion = 3e7\nfriction_angle = 45\nfracture_energy_i = 1e5\nfracture_energy_ii = 1e5\n";
    let breaks =
        model.replace("[[material]]\nname = \"rock\"\n", &format!("[[material]]\nname = \"rock\"\n{strong}"));
    assert_ne!(breaks, model);
    bench.write("breaks.toml", &breaks);
    bench.run(&["check", "breaks.toml"]).refused_with(&["\"soft\" has no strengths", "unbreakable = true"]);
    bench.write("breaks.toml", breaks.replace("name = \"soft\"\n", "name = \"soft\"\nunbreakable = true\n"));
    bench.run(&["run", "breaks.toml", "-o", "broken", "-q"]).succeeds();
    let history = String::from_utf8(std::fs::read(bench.path("broken/history.csv")).unwrap()).unwrap();
    let held = *column(&history, "crown uy [m]").last().unwrap();
    assert!((held / crown - 1.0).abs() < 0.05, "{held} and {crown}");
    wrong("core = \"soft\"", "cor = \"soft\"", &["there is no body \"cor\"", "core"]);
    wrong("core = \"soft\"", "core = \"sofft\"", &["sofft", "soft"]);
    wrong("name = \"soft\"\ndensity = 2700", "name = \"soft\"\ndensity = 2600", &["another density"]);
}

/// Displacements count from the stage that sets them back, in frames and in the history, also after a resume
/// and in a run that begins with this one.
#[test]
fn a_stage_sets_displacements_back() {
    let bench = Bench::new();
    let model =
        TUNNEL.replace("activate = [\"block\"]", "activate = [\"block\"]\nreset_displacements = true");
    bench.write("plain.toml", TUNNEL);
    bench.write("back.toml", &model);
    let history = |folder: &str| {
        String::from_utf8(std::fs::read(bench.path(&format!("{folder}/history.csv"))).unwrap()).unwrap()
    };
    let of_run = |folder: &str, key: &str| -> Value {
        let summary = std::fs::read(bench.path(&format!("{folder}/run.json"))).unwrap();
        serde_json::from_slice::<Value>(&summary).unwrap()[key].clone()
    };
    for name in ["plain", "back"] {
        bench.run(&["run", &format!("{name}.toml"), "-o", name, "-q"]).succeeds();
    }
    assert_eq!(of_run("back", "state_hash"), of_run("plain", "state_hash"));
    let strike = of_run("back", "stages")[2]["time"].as_f64().unwrap();
    let times = column(&history("back"), "time");
    let [plain, back] = ["plain", "back"].map(|name| column(&history(name), "crown uy [m]"));
    let first = plain.iter().zip(&back).position(|(plain, back)| plain != back).unwrap();
    // The row before is that with which the stage begins.
    let moved = plain[first - 1];
    assert!((times[first - 1] - strike).abs() < 1e-9 && moved < -1e-4, "{strike}, {moved}");
    for (plain, back) in plain.iter().zip(&back).skip(first) {
        assert!((plain - back - moved).abs() < 1e-12, "{plain} and {back}");
    }
    bench.write("open.toml", TUNNEL.replace("[5e-4, 0.5]", "[5e-4, 0]"));
    bench.run(&["run", "open.toml", "-o", "open", "-q"]).succeeds();
    // The rock alone, held at its sides.
    let part = |from: &str, to: &str| &TUNNEL[TUNNEL.find(from).unwrap()..TUNNEL.find(to).unwrap()];
    let parts = [
        &part("[model]", "[[body]]\nname = \"core\"").replace("6e-3", "8e-3"),
        part("[[material]]", "[[boundary]]\nname = \"hammer\""),
        "[[stage]]\nname = \"late\"\nreset_displacements = true\n",
        part("[[history]]", "[[history]]\nname = \"core\""),
    ];
    bench.write("later.toml", parts.concat());
    bench.run(&["run", "later.toml", "--from", "open", "-o", "later", "-q"]).succeeds();
    // Without a stage that resets them, displacements count from the beginning again, and the run says so.
    bench.write("set.toml", model.replace("[5e-4, 0.5]", "[5e-4, 0]"));
    bench.run(&["run", "set.toml", "-o", "set", "-q"]).succeeds();
    bench.write("anew.toml", parts.concat().replace("reset_displacements = true\n", ""));
    let anew = bench.run(&["run", "anew.toml", "--from", "set", "-o", "anew"]).succeeds();
    assert!(
        anew.stderr.contains("displacements count from the beginning of the run in set"),
        "{}",
        anew.stderr
    );
    // Its first row is one interval after its beginning.
    let [before, crown] = ["open", "later"].map(|folder| column(&history(folder), "crown uy [m]"));
    let last = before.last().unwrap();
    assert!(crown[0].abs() < 0.05 * last.abs() && *last < -3e-4, "{} after {last}", crown[0]);
}

/// A stage of dynamic relaxation ends at an equilibrium that the same stage without damping does not find.
#[test]
fn a_stage_relaxes_to_an_equilibrium() {
    let bench = Bench::new();
    let without =
        TUNNEL.replace("damping = 0.2\n", "").replace("local_damping = 0.7\n", "equilibrium = 1e-3\n");
    let without =
        without.replace("duration = 2e-3", "duration = 0.2").replace("end_time = 6e-3", "end_time = 0.3");
    let without = without.replace("checkpoint_steps = 5\n", "");
    let with = without.replace("equilibrium = 1e-3\n", "equilibrium = 1e-3\ndynamic_relaxation = true\n");
    let [relaxed, swings] = [("with", with), ("without", without)].map(|(name, text)| {
        bench.write(&format!("{name}.toml"), text);
        bench.run(&["run", &format!("{name}.toml"), "-o", name]).succeeds().stderr
    });
    let ends = "stage \"excavate\" ends at";
    let line = |told: &str| told.lines().find(|line| line.starts_with(ends)).unwrap().to_owned();
    assert!(line(&relaxed).contains("equilibrium: kinetic"), "{}", line(&relaxed));
    assert!(line(&swings).contains("warning: its time has passed"), "{}", line(&swings));
    let checked = bench.run(&["check", "without.toml"]).succeeds();
    assert!(checked.stdout.contains("dynamic_relaxation = true"), "{}", checked.stdout);
}

#[test]
fn stages_that_make_no_sense_are_refused() {
    let bench = Bench::new();
    let wrong = |from: &str, to: &str, parts: &[&str]| {
        assert!(TUNNEL.contains(from), "{from}");
        bench.write("wrong.toml", TUNNEL.replacen(from, to, 1));
        bench.run(&["check", "wrong.toml"]).refused_with(&[&["wrong.toml"], parts].concat());
    };
    wrong("stages = [\"strike\"]", "stages = [\"strke\"]", &["there is no stage \"strke\"", "strike"]);
    wrong("stages = [\"strike\"]", "stages = []", &["acts in no stage"]);
    wrong("excavate = [\"core\"]", "excavate = [\"cor\"]", &["there is no body \"cor\"", "core"]);
    wrong("equilibrium = 1e-6\nduration = 1e-3\n", "", &["\"rest\" does not end"]);
    wrong("equilibrium = 1e-6\n", "excavate = [\"core\"]\n", &["is the first"]);
    wrong("[5e-4, 0.5]", "[-5e-4, 0.5]", &["do not ascend"]);
    wrong("name = \"strike\"", "name = \"rest\"", &["already"]);
    wrong("excavate = [\"core\"]", "excavate_boxes = [[90, 90, 99, 99]]", &["no element is in this box"]);
    wrong("excavate = [\"core\"]", "excavate_boxes = [[9, 9]]", &["2 numbers"]);
    wrong("excavate = [\"core\"]", "excavate = [\"core\", \"rock\"]", &["no element is left"]);
    let strike = "activate = [\"block\"]";
    wrong(
        strike,
        "activate = [\"block\"]\nexcavate = [\"core\"]",
        &["\"core\" is not there before this stage"],
    );
    wrong(strike, "activate = [\"block\"]\nexcavate = [\"block\"]", &["appears and vanishes in one stage"]);
    wrong("excavate = [\"core\"]", "activate = [\"block\"]", &["appears in a stage before"]);
}

/// Boundaries of different stages may move the same nodes, and bodies that are never there together do not
/// overlap.
#[test]
fn what_is_in_different_stages_does_not_meet() {
    let bench = Bench::new();
    let model = TUNNEL.replace("stages = [\"strike\"]", "stages = [\"strike\"]\n[[boundary]]\nname = \"other\"\nbody = \"core\"\nvelocity = [0, 1]\nramp = 1e-3\nstages = [\"rest\"]\n[[boundary]]\nname = \"same\"\nbody = \"core\"\nvelocity = [0, 2]\nramp = 1e-3\nstages = [\"excavate\"]");
    let lining = "name = \"block\"\nmaterial = \"rock\"\nrectangle = { min = [-1, 5], max = [1, 6] }";
    let model = model.replace(
        lining,
        "name = \"block\"\nmaterial = \"rock\"\nrectangle = { min = [-1, -1], max = [1, 1] }",
    );
    bench.write("apart.toml", &model);
    let checked = bench.run(&["check", "apart.toml"]).succeeds().stdout;
    assert!(!checked.contains("overlap"), "{checked}");
    bench.write("met.toml", model.replace("stages = [\"excavate\"]", "stages = [\"excavate\", \"rest\"]"));
    bench.run(&["check", "met.toml"]).refused_with(&["\"same\" and \"other\" both prescribe"]);
    // Two bodies that are there together do overlap.
    bench.write("overlaps.toml", model.replace("excavate = [\"core\"]\n", ""));
    let checked = bench.run(&["check", "overlaps.toml"]).succeeds().stdout;
    assert!(checked.contains("\"core\" and \"block\" overlap"), "{checked}");
}

/// Ground under its own weight and a tectonic stress, in two and in three dimensions: nothing moves.
#[test]
fn ground_at_rest_stays_at_rest() {
    let flat = r#"
[model]
plane = "strain"
gravity = [0, -9.81]
end_time = 0.05
[[body]]
name = "ground"
material = "soil"
rectangle = { min = [0, -10], max = [20, 0] }
mesh_size = 2
[[material]]
name = "soil"
density = 2000
youngs_modulus = 100e6
poissons_ratio = 0.3
[initial]
ground = { surface = 0, k0 = 0.5, tectonic = -1e5 }
[[boundary]]
name = "left"
side = "left"
fixed = "x"
[[boundary]]
name = "right"
side = "right"
fixed = "x"
[[boundary]]
name = "base"
side = "bottom"
fixed = "xy"
"#;
    let space = flat
        .replace("plane = \"strain\"", "")
        .replace("[0, -9.81]", "[0, 0, -9.81]")
        .replace(
            "rectangle = { min = [0, -10], max = [20, 0] }",
            "box = { min = [0, 0, -10], max = [20, 10, 0] }",
        )
        .replace("mesh_size = 2", "mesh_size = 5")
        .replace("k0 = 0.5, tectonic = -1e5", "k0 = [0.5, 0.8], tectonic = [-1e5, 0]")
        .replace("fixed = \"xy\"", "fixed = \"xyz\"")
        + "[[boundary]]\nname = \"front\"\nside = \"front\"\nfixed = \"y\"\n[[boundary]]\nname = \"back\"\nside = \"back\"\nfixed = \"y\"\n";
    let bench = Bench::new();
    for (name, model) in [("flat", flat.to_owned()), ("space", space)] {
        bench.write(&format!("{name}.toml"), model);
        bench.run(&["run", &format!("{name}.toml"), "-o", name, "-q"]).succeeds();
        let history =
            String::from_utf8(std::fs::read(bench.path(&format!("{name}/history.csv"))).unwrap()).unwrap();
        let largest = |column_name: &str| column(&history, column_name).into_iter().fold(0.0, f64::max);
        let (kinetic, strain) = (largest("kinetic"), largest("strain"));
        // (Velocity over wave speed times strain)² is their ratio: 1e-6 of it would be 1e-12.
        assert!(strain > 0.0 && kinetic < 1e-20 * strain, "{name}: {kinetic} {strain}");
    }
    bench.write("wrong.toml", flat.replace("gravity = [0, -9.81]\n", ""));
    bench.run(&["check", "wrong.toml"]).refused_with(&["\"ground\" goes with gravity"]);
    bench.write("wrong.toml", flat.replace("k0 = 0.5", "k0 = [0.5, 0.5]"));
    bench.run(&["check", "wrong.toml"]).refused_with(&["one horizontal axis"]);
}

/// The last lines of a run that stops repeat the warnings of the model, which may be the cause.
#[test]
fn a_run_that_stops_names_the_overlap_of_a_body_that_appears() {
    let bench = Bench::new();
    let body = |name: &str, left: f64, right: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmaterial = \"m\"\nmesh_size = 0.2\n\
             rectangle = {{ min = [{left}, 0], max = [{right}, 1] }}\n"
        )
    };
    let model = format!(
        "[model]\nend_time = 0.02\nplane = \"strain\"\n{}{}\
         [[material]]\nname = \"m\"\ndensity = 2000\nyoungs_modulus = 1e8\npoissons_ratio = 0\n\
         [[boundary]]\nname = \"l\"\nbody = \"a\"\nside = \"left\"\nfixed = \"xy\"\n\
         [[stage]]\nname = \"one\"\nduration = 0.005\n\
         [[stage]]\nname = \"two\"\nactivate = [\"b\"]\n",
        body("a", 0.0, 1.0),
        body("b", 0.98, 2.0)
    );
    bench.write("push.toml", &model);
    let run = bench.run(&["run", "push.toml"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    let end = run.stderr.split("error: ").last().unwrap_or_default();
    assert!(end.contains("the energy balance is off by"), "{end}");
    assert!(
        end.contains("\"a\" and \"b\" overlap by 0.02 m² at the beginning of stage \"two\", in "),
        "{end}"
    );
}
