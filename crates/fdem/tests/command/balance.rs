//! The energy balance at the end of a run, which the checks during the run do not include.

use crate::Bench;

/// Two bodies that overlap at the beginning, with a time step of 40 % of the duration of their contact: their
/// energy grows. The run has 25 steps.
const SHORT: &str = include_str!("unbalanced.toml");

#[test]
fn a_run_of_fewer_steps_than_between_two_checks_is_checked_at_its_end() {
    let bench = Bench::new();
    bench.write("short.toml", SHORT);
    let run = bench.run(&["run", "short.toml", "--quiet"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("step 24: the energy balance is off by"), "{}", run.stderr);
    let summary = bench.json("short_results/run.json");
    assert_eq!(summary["steps"], 25);
    let status = summary["status"].as_str().unwrap();
    assert!(status.starts_with("stopped: step 24: "), "{status}");
    // The last frame is that of the end, and there is no second one of the same step.
    let collection = bench.read("short_results/results.pvd");
    let mut times: Vec<&str> =
        collection.split("timestep=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let count = times.len();
    times.dedup();
    assert!(count > 1 && times.len() == count, "{collection}");
    assert_eq!(times[count - 1].parse(), Ok(0.01), "{collection}");
    // The checkpoint is from before: the run stops again, in the same way.
    let again = bench.run(&["resume", "short_results", "--quiet"]);
    assert_eq!(again.code, Some(1), "{}", again.stderr);
    assert_eq!(bench.json("short_results/run.json")["status"], summary["status"]);

    bench.write("loose.toml", SHORT.replace("end_time", "energy_bound = 0.9\nend_time"));
    let run = bench.run(&["run", "loose.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);

    bench.write("sweep.toml", "model = \"short.toml\"\n[grid]\n\"model.energy_bound\" = [0.05, 0.9]\n");
    let sweep = bench.run(&["sweep", "sweep.toml"]);
    assert_eq!(sweep.code, Some(1), "{}", sweep.stderr);
    let results = bench.read("sweep_results/runs.csv");
    assert!(results.contains("stopped") && results.contains("finished"), "{results}");
}

/// A cavity with a gas in a block that begins with kinetic energy: the summary's line of energies adds up.
#[test]
fn the_energies_of_the_summary_add_up() {
    let bench = Bench::new();
    bench.write(
        "gas.toml",
        r#"
[model]
plane = "strain"
end_time = 2e-4
[[body]]
name = "block"
material = "m"
polygon = { points = [[0, 0], [1, 0], [1, 1], [0, 1]], holes = [{ centre = [0.5, 0.5], radius = 0.1 }] }
mesh_size = 0.1
velocity = [1, 0]
[[material]]
name = "m"
density = 2000
youngs_modulus = 1e9
poissons_ratio = 0.2
[[boundary]]
name = "charge"
group = "hole-1"
pressure = 1e6
cavity = true
gas_exponent = 1.3
"#,
    );
    let run = bench.run(&["run", "gas.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let log = bench.read("gas_results/run.log");
    let line = log.lines().find_map(|line| line.split_once("energies (J)")).unwrap().1.trim();
    let term = |term: &'_ str| -> (String, f64) {
        let (name, value) = term.split_once(' ').unwrap();
        (name.to_owned(), value.parse().unwrap())
    };
    let terms: Vec<(String, f64)> = line.split(", ").map(term).collect();
    let supplied = |name: &str| ["external", "initial"].contains(&name);
    for name in ["kinetic", "strain", "gas", "initial"] {
        assert!(terms.iter().any(|(found, _)| *found == name), "{name}: {line}");
    }
    let [used, given] = [false, true].map(|kind| {
        terms.iter().filter(|(name, _)| supplied(name) == kind).map(|(_, value)| value).sum::<f64>()
    });
    assert!((used - given).abs() < 1e-4 * given, "{line}: {used} {given}");
}
