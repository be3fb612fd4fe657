//! Tests of `fdem sweep` and of `--set`: values, results, interrupts, runs that fail, and sweep files that
//! are refused.

use std::collections::BTreeMap;
use std::fs;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use crate::Bench;

/// A plate with a notch is torn apart, in some hundred steps.
const PLATE: &str = r#"
[parameters]
strength = "2.5 MPa"
speed = 0.2

[model]
title = "torn plate"
end_time = 2e-4
gravity = "none"

[[body]]
name = "plate"
material = "rock"
polygon = { points = [[0, -0.03], [0.04, -0.03], [0.04, 0.03], [0, 0.03], [0, 0.001], [0.01, 0], [0, -0.001]] }
mesh_size = 8e-3

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.2
damping = 0.1
friction = 0.5
tensile_strength = "strength"
cohesion = "3*strength"
friction_angle = 30
fracture_energy_i = 2.5
fracture_energy_ii = 12.5

[[boundary]]
name = "lower end"
body = "plate"
side = "bottom"
velocity = [0, "-speed"]

[[boundary]]
name = "upper end"
body = "plate"
side = "top"
velocity = [0, "speed"]

[output]
frames = 2

[[history]]
name = "pull"
force = "upper end"

[[curve]]
name = "pull"
x = "time"
y = "pull fy"
"#;

/// The table of a sweep: its rows, by the names of the columns.
fn table(bench: &Bench, folder: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(bench.path(&format!("{folder}/runs.csv"))).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn column(rows: &[BTreeMap<String, String>], name: &str) -> Vec<String> {
    rows.iter()
        .map(|row| row.get(name).unwrap_or_else(|| panic!("no column {name} in {row:?}")).clone())
        .collect()
}

fn bench(sweep: &str) -> Bench {
    let bench = Bench::new();
    bench.write("plate.toml", PLATE);
    bench.write("sweep.toml", sweep);
    bench
}

const GRID: &str = "model = \"plate.toml\"\n[grid]\nstrength = [\"2 MPa\", 3e6]\nspeed = { from = 0.1, to = 0.4, count = 3, scale = \"log\" }\n";

/// A sweep runs all combinations; its runs are those of `fdem run --set`, its files do not depend on the
/// number of processes, and the same command has nothing left to do.
#[test]
fn a_grid_is_run_and_compared() {
    let bench = bench(GRID);
    let run = bench.run(&["sweep", "sweep.toml", "--processes", "2"]).succeeds();
    assert!(
        run.stdout.starts_with("6 of 6 runs have finished: results are in sweep_results"),
        "{}",
        run.stdout
    );
    assert!(run.stderr.contains("run 1 (strength = 2 MPa, speed = 0.1) finished"), "{}", run.stderr);
    let rows = table(&bench, "sweep_results");
    assert_eq!(column(&rows, "strength"), ["2000000", "2000000", "2000000", "3000000", "3000000", "3000000"]);
    assert_eq!(column(&rows, "speed"), ["0.1", "0.2", "0.4", "0.1", "0.2", "0.4"]);
    assert_eq!(column(&rows, "status"), ["finished"; 6]);
    let number = |row: usize, name: &str| rows[row][name].parse::<f64>().unwrap();
    assert!(number(2, "pull peak").abs() > number(0, "pull peak").abs(), "a faster pull is a larger force");
    assert_eq!(number(5, "time_step"), number(0, "time_step"));
    let history = bench.read("sweep_results/runs/003/history.csv");
    let place = history.lines().next().unwrap().split(',').position(|name| name == "pull fy [N]").unwrap();
    let last = history.lines().last().unwrap().split(',').nth(place).unwrap();
    assert_eq!(number(2, "pull fy [N] at the end"), last.parse::<f64>().unwrap());

    let sets = ["--set", "strength=3 MPa", "--set", "speed=0.4"];
    bench.run(&[&["run", "plate.toml", "-q", "--output", "alone"], &sets[..]].concat()).succeeds();
    let (alone, swept) = (bench.json("alone/run.json"), bench.json("sweep_results/runs/006/run.json"));
    assert_eq!((&swept["state_hash"], &swept["model_hash"]), (&alone["state_hash"], &alone["model_hash"]));
    assert_eq!(rows[5]["state_hash"], alone["state_hash"].as_str().unwrap());
    let model = bench.read("sweep_results/runs/002/model.toml");
    assert!(model.contains("strength = \"2 MPa\"\nspeed = 0.2"), "{model}");

    bench.run(&["sweep", "sweep.toml", "--processes", "1", "--threads", "2", "-q", "-o", "again"]).succeeds();
    assert_eq!(bench.read("again/runs.csv"), bench.read("sweep_results/runs.csv"));
    assert_eq!(bench.read("again/report.html"), bench.read("sweep_results/report.html"));
    assert!(bench.read("again/report.html").contains("<h1>Sweep of plate.toml: torn plate</h1>"));

    let before = fs::metadata(bench.path("sweep_results/runs/003/run.json")).unwrap().modified().unwrap();
    let run = bench.run(&["sweep", "sweep.toml"]).succeeds();
    assert!(run.stderr.contains("6 runs, 0 to do; 6 have finished before"), "{}", run.stderr);
    assert_eq!(
        fs::metadata(bench.path("sweep_results/runs/003/run.json")).unwrap().modified().unwrap(),
        before
    );
    // A run that is taken out is done again.
    fs::remove_dir_all(bench.path("sweep_results/runs/004")).unwrap();
    let run = bench.run(&["sweep", "sweep.toml"]).succeeds();
    assert!(run.stderr.contains("6 runs, 1 to do; 5 have finished before"), "{}", run.stderr);
    assert_eq!(bench.read("again/runs.csv"), bench.read("sweep_results/runs.csv"));
}

/// The table has whether the condition that ends a run was met.
#[test]
fn a_condition_that_ends_runs_is_in_the_table() {
    let bench = bench("model = \"plate.toml\"\n[grid]\nspeed = [0.1, 0.4]\n");
    let until = "end_time = 2e-4\nuntil = { column = \"pull fy\", above = 1e5 }\n";
    bench.write("plate.toml", PLATE.replacen("end_time = 2e-4\n", until, 1));
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    let rows = table(&bench, "sweep_results");
    assert_eq!(column(&rows, "until_met"), ["no", "yes"]);
}

/// A sweep or a model that has changed is refused, and replaced only on request.
#[test]
fn another_sweep_in_the_folder_is_refused() {
    let bench = bench("model = \"plate.toml\"\nfolder = \"out\"\n[[run]]\nspeed = 0.1\n");
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    bench.write(
        "sweep.toml",
        "model = \"plate.toml\"\nfolder = \"out\"\nprocesses = 2\n[[run]]\nspeed = 0.1\n",
    );
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    bench.write("sweep.toml", "model = \"plate.toml\"\nfolder = \"out\"\n[[run]]\nspeed = 0.3\n");
    bench.run(&["sweep", "sweep.toml", "-q"]).refused_with(&[
        "out has another sweep",
        "values of its runs",
        "--force",
    ]);
    bench.run(&["sweep", "sweep.toml", "-q", "--force"]).succeeds();
    assert_eq!(column(&table(&bench, "out"), "speed"), ["0.3"]);
    bench.write("plate.toml", PLATE.replace("2700", "2600"));
    bench.run(&["sweep", "sweep.toml", "-q"]).refused_with(&["its model has changed"]);
    fs::create_dir(bench.path("mine")).unwrap();
    bench.write("mine/thesis.txt", "text");
    bench
        .run(&["sweep", "sweep.toml", "-q", "-o", "mine", "--force"])
        .refused_with(&["mine is not empty and has no sweep"]);
    assert_eq!(bench.read("mine/thesis.txt"), "text");
}

/// Two sweeps that are started at the same moment in one folder: one has it, and the other changes nothing.
#[test]
fn of_two_sweeps_started_at_once_one_has_the_folder() {
    let bench = bench("model = \"plate.toml\"\n[[run]]\nspeed = 0.1\n");
    bench.write("other.toml", "model = \"plate.toml\"\n[[run]]\nspeed = 0.3\n");
    let sweeps = [("sweep.toml", "0.1"), ("other.toml", "0.3")];
    for _ in 0..4 {
        let both = sweeps.map(|(sweep, _)| {
            let mut command = bench.command(&["sweep", sweep, "-q", "-o", "both"]);
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        });
        let ended = both.map(|child| child.wait_with_output().unwrap());
        let codes = ended.each_ref().map(|output| output.status.code());
        let first = codes.iter().position(|code| *code == Some(0));
        let first = first.unwrap_or_else(|| panic!("both have failed: {ended:?}"));
        let other = String::from_utf8_lossy(&ended[1 - first].stderr);
        assert_eq!(codes[1 - first], Some(2), "{other}");
        let holds = other.contains("another fdem process is using both") && other.contains("process ");
        assert!(holds || other.contains("both has another sweep"), "{other}");
        assert_eq!(column(&table(&bench, "both"), "speed"), [sweeps[first].1]);
        fs::remove_dir_all(bench.path("both")).unwrap();
    }
}

/// A sweep does not replace runs that still work after their own sweep was killed.
#[test]
fn runs_that_still_work_are_not_replaced() {
    let bench = bench("model = \"plate.toml\"\n[[run]]\nspeed = 0.1\n");
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    let run = "sweep_results/runs/001";
    let mut orphan = bench
        .command(&["run", "plate.toml", "-q", "--force", "--set", "model.end_time=2e-1", "-o", run])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let summary = || fs::read_to_string(bench.path(run).join("run.json")).unwrap_or_default();
    let start = Instant::now();
    while !summary().contains("begun") || !bench.path(run).join("checkpoint").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "the run has not begun");
        thread::sleep(Duration::from_millis(5));
    }
    bench
        .run(&["sweep", "sweep.toml", "-q", "--force"])
        .refused_with(&["another fdem process is using", "001"]);
    assert!(bench.path(run).join("checkpoint").exists());
    orphan.kill().unwrap();
    orphan.wait().unwrap();
    bench.run(&["sweep", "sweep.toml", "-q", "--force"]).succeeds();
}

/// Paths of keys, rows of a table, and values that the table does not have in the model.
#[test]
fn a_table_sets_keys_by_their_paths() {
    let bench = bench("model = \"plate.toml\"\ntable = \"values.csv\"\n");
    bench.write(
        "values.csv",
        "material.rock.density,material.rock.weibull_modulus,boundary.upper end.velocity.1,model.plane\n2600,5,0.1,strain\n2700,9,\"2 * speed\",stress\n",
    );
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    let rows = table(&bench, "sweep_results");
    assert_eq!(column(&rows, "material.rock.density"), ["2600", "2700"]);
    assert_eq!(column(&rows, "boundary.upper end.velocity.1"), ["0.1", "2 * speed"]);
    let model = bench.read("sweep_results/runs/002/model.toml");
    assert!(model.contains("velocity = [0, \"2 * speed\"]"), "{model}");
    assert!(model.contains("[model]\nplane = \"stress\""), "{model}");
    assert!(model.contains("[[material]]\nweibull_modulus = 9"), "{model}");
}

/// Seeds are whole numbers, also 0 and those that are no floating-point numbers.
#[test]
fn seeds_are_swept_with_all_of_their_digits() {
    let bench = bench("model = \"plate.toml\"\n[grid]\nbody.plate.seed = [0, 9007199254740993]\n");
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    let seeds = column(&table(&bench, "sweep_results"), "body.plate.seed");
    assert_eq!(seeds, ["0", "9007199254740993"]);
    assert!(bench.read("sweep_results/runs/001/model.toml").contains("seed = 0\n"));
    assert!(bench.read("sweep_results/runs/002/model.toml").contains("seed = 9007199254740993\n"));
    bench.write("values.csv", "body.plate.seed\n0\n9007199254740993\n");
    bench.write("sweep.toml", "model = \"plate.toml\"\ntable = \"values.csv\"\n");
    bench.run(&["sweep", "sweep.toml", "-q", "-o", "again"]).succeeds();
    assert_eq!(bench.read("again/runs.csv"), bench.read("sweep_results/runs.csv"));
    bench
        .run(&["check", "plate.toml", "--set", "output.frames=0"])
        .refused_with(&["\"frames\" is 0: it has to be at least 1"]);
}

/// Runs that stop by themselves are noted and do not stop the others; refused models stop the sweep unless
/// they are to be skipped.
#[test]
fn runs_that_fail_are_noted() {
    let bench = bench("model = \"plate.toml\"\n[grid]\n\"model.energy_bound\" = [1e-12, 0.02]\n");
    let run = bench.run(&["sweep", "sweep.toml"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("1 of 2 runs have finished"), "{}", run.stderr);
    let rows = table(&bench, "sweep_results");
    assert_eq!(column(&rows, "status"), ["stopped", "finished"]);
    assert!(rows[0]["message"].contains("energy"), "{}", rows[0]["message"]);
    // It would stop again.
    let run = bench.run(&["sweep", "sweep.toml"]);
    assert!(run.stderr.contains("2 runs, 0 to do"), "{}", run.stderr);

    bench.write("sweep.toml", "model = \"plate.toml\"\n[grid]\nstrength = [\"2 MPa\", -1, \"3 mm\"]\n");
    let refused = bench.run(&["sweep", "sweep.toml", "-o", "other"]);
    refused.refused_with(&[
        "run 2 (strength = -1) of 3 is refused: plate.toml has",
        "\"tensile_strength\" is -1",
        "run 3 (strength = 3 mm) is refused: \"strength\" is a length",
        "nothing has run; --skip-refused",
    ]);
    assert!(!bench.path("other").exists());
    let run = bench.run(&["sweep", "sweep.toml", "-o", "other", "--skip-refused", "-q"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    let rows = table(&bench, "other");
    assert_eq!(column(&rows, "status"), ["finished", "refused", "refused"]);
    assert!(rows[2]["message"].contains("is a length"), "{}", rows[2]["message"]);
    assert_eq!(rows[2]["time"], "");
}

/// Mistakes in a sweep file are reported with their lines, before anything is written.
#[test]
fn mistakes_are_told_before_anything_runs() {
    let bench = Bench::new();
    bench.write("plate.toml", PLATE);
    bench.write("empty.csv", "speed\n");
    bench.write("short.csv", "speed,strength\n1,2\n3\n");
    let model = "model = \"plate.toml\"\n";
    for (text, parts) in [
        ("[grid]\nspeed = [1]\n".to_owned(), &["lacks the key \"model\""][..]),
        (model.to_owned(), &["has no values to run", "[latin_hypercube]"]),
        (
            format!("{model}grdi = 3\n[grid]\nspeed = [1]\n"),
            &["sweep.toml:2", "no key \"grdi\"", "did you mean \"grid\"?"],
        ),
        (format!("{model}[grid]\nspeed = []\n"), &["sweep.toml:3", "\"speed\" has no values"]),
        (format!("{model}[grid]\n"), &["there is no run"]),
        (
            format!("{model}[grid]\nspeed = [nan]\n"),
            &["sweep.toml has 1 error", "a value of \"speed\" is a finite number"],
        ),
        (format!("{model}[grid]\nspeed = 3\n"), &["no list and no range"]),
        (format!("{model}[grid]\nspeed = {{ from = 1, to = 2 }}\n"), &["lacks \"count\""]),
        (
            format!("{model}[grid]\nspeed = {{ from = 1, to = 1, count = 3 }}\n"),
            &["is empty: both ends are 1"],
        ),
        (
            format!("{model}[grid]\nspeed = {{ from = 1, to = 2, count = 1 }}\n"),
            &["\"count\" is a whole number from 2"],
        ),
        (
            format!("{model}[grid]\nspeed = {{ from = 0, to = 2, count = 3, scale = \"log\" }}\n"),
            &["above 0"],
        ),
        (
            format!("{model}[grid]\nspeed = {{ from = \"1 m\", to = \"2 s\", count = 3 }}\n"),
            &["goes from a length to a time"],
        ),
        (
            format!("{model}[grid]\nspeed = {{ from = 1, to = 2, count = 99999 }}\n"),
            &["99,999 runs, more than 1,000", "--max-runs"],
        ),
        (
            format!("{model}[grid]\na = {{ from = 1, to = 2, count = 900 }}\nb = [1, 2]\n"),
            &["1,800 runs, more than 1,000"],
        ),
        (
            format!("{model}[grid]\nspeeed = [1]\n"),
            &["run 1 (speeed = 1) of 1", "no parameter \"speeed\"", "did you mean \"speed\"?"],
        ),
        (
            format!("{model}[grid]\n\"material.rok.density\" = [1]\n"),
            &["\"material.rok.density\" is no key", "did you mean \"rock\"?"],
        ),
        (format!("{model}[grid]\n\"matter.rock.density\" = [1]\n"), &["there is no table \"matter\""]),
        (
            format!("{model}[grid]\n\"material.rock.densty\" = [1]\n"),
            &["has no key \"densty\"", "did you mean \"density\"?"],
        ),
        (
            format!("{model}[[run]]\nspeed = 1\n[[run]]\nstrength = 1\n"),
            &["first [[run]] has no \"strength\"", "number 2 lacks \"speed\""],
        ),
        (format!("{model}[[run]]\nspeed = 1\n[grid]\nspeed = [1]\n"), &["second kind of values"]),
        (format!("{model}[latin_hypercube]\ncount = 3\n"), &["needs \"count\" and \"ranges\""]),
        (format!("{model}[latin_hypercube]\ncount = 3\nranges = {{}}\n"), &["\"ranges\" is empty"]),
        (format!("{model}processes = 0\n[grid]\nspeed = [1]\n"), &["\"processes\" is a whole number from 1"]),
        (format!("{model}table = \"empty.csv\"\n"), &["empty.csv: it has no rows"]),
        (format!("{model}table = \"short.csv\"\n"), &["short.csv: ", "line 3 has 1 value"]),
        (format!("{model}table = \"absent.csv\"\n"), &["absent.csv: "]),
        ("model = \"absent.toml\"\n[grid]\nspeed = [1]\n".to_owned(), &["cannot read absent.toml"]),
        ("model = plate\n".to_owned(), &["not TOML", "quotes"]),
    ] {
        bench.write("sweep.toml", &text);
        let run = bench.run(&["sweep", "sweep.toml", "-q"]);
        assert_eq!(run.code, Some(2), "{text}{}{}", run.stdout, run.stderr);
        for part in parts {
            assert!(run.stderr.contains(part), "{text}lacks {part}:\n{}", run.stderr);
        }
        assert!(!bench.path("sweep_results").exists(), "{text}");
    }
    bench.run(&["sweep", "absent.toml"]).refused_with(&["cannot read absent.toml"]);
    bench.run(&["sweep", "sweep.toml", "--processes", "0"]).refused_with(&["1 to 1024"]);
    bench.run(&["run", "plate.toml", "--set", "speed"]).refused_with(&["equals sign"]);
    bench
        .run(&["check", "plate.toml", "--set", "sped=1"])
        .refused_with(&["no parameter \"sped\"", "\"speed\""]);
    let run = bench
        .run(&["check", "plate.toml", "--set", "speed=\"0.3 m/s\"".replace('"', "").as_str()])
        .succeeds();
    assert!(run.stdout.contains("torn plate"), "{}", run.stdout);
}

/// A Latin hypercube has the values of its seed, and a run for each.
#[test]
fn a_latin_hypercube_is_run() {
    let sweep = "model = \"plate.toml\"\n[latin_hypercube]\ncount = 3\nseed = 5\n[latin_hypercube.ranges]\nspeed = { from = \"10 cm/s\", to = \"40 cm/s\" }\n";
    let bench = bench(sweep);
    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    let mut speeds: Vec<f64> =
        column(&table(&bench, "sweep_results"), "speed").iter().map(|speed| speed.parse().unwrap()).collect();
    speeds.sort_by(f64::total_cmp);
    for (part, speed) in (0..).zip(&speeds) {
        assert!((0.1 + 0.1 * f64::from(part)..0.2 + 0.1 * f64::from(part)).contains(speed), "{speeds:?}");
    }
}

/// An interrupted sweep leaves checkpoints, and the same command gives the results of one that was not
/// interrupted.
#[test]
#[cfg(unix)]
fn an_interrupted_sweep_goes_on() {
    let long = PLATE.replace("end_time = 2e-4", "end_time = 6e-3");
    let sweep = "model = \"plate.toml\"\nprocesses = 2\n[grid]\nspeed = [0.1, 0.2, 0.3]\n";
    let whole = bench(sweep);
    whole.write("plate.toml", &long);
    whole.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    let bench = bench(sweep);
    bench.write("plate.toml", &long);
    let mut child =
        bench.command(&["sweep", "sweep.toml"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = |number: usize| bench.path(&format!("sweep_results/runs/00{number}/checkpoint")).exists();
    let start = Instant::now();
    while !(begun(1) && begun(2)) {
        assert!(start.elapsed() < Duration::from_secs(60), "the runs have not begun");
        thread::sleep(Duration::from_millis(5));
    }
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    let mut said = String::new();
    std::io::Read::read_to_string(child.stderr.as_mut().unwrap(), &mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143), "{said}");
    assert!(said.contains("the same command continues the sweep"), "{said}");
    let rows = table(&bench, "sweep_results");
    assert_eq!(column(&rows, "status"), ["interrupted", "interrupted", "waiting"], "{said}");
    assert!(bench.read("sweep_results/report.html").contains("2 interrupted, 1 waiting"));

    bench.run(&["sweep", "sweep.toml", "-q"]).succeeds();
    assert_eq!(bench.read("sweep_results/runs.csv"), whole.read("sweep_results/runs.csv"));
    assert!(bench.read("sweep_results/runs/001/run.log").contains("continues after step"));
    let left: Vec<_> =
        fs::read_dir(bench.path("sweep_results")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 5, "{left:?}");
    assert!(left.iter().any(|name| name == ".fdem.lock"), "{left:?}");
}
