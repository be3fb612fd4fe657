//! The energy balance at the end of a run, which the checks during the run do not include.

use crate::Bench;

/// Two bodies that overlap at the beginning, with a time step of 40 % of the duration of their contact: their
/// energy grows. The run has 25 steps.
const SHORT: &str = r#"
[model]
end_time = 0.01
time_step = 4e-4
[[body]]
name = "a"
material = "m"
rectangle = { min = [0, 0], max = [1, 1] }
mesh_size = 0.25
[[body]]
name = "b"
material = "m"
rectangle = { min = [0.98, 0], max = [2, 1] }
mesh_size = 0.25
[[material]]
name = "m"
density = 2000
youngs_modulus = 1e7
poissons_ratio = 0.2
[contact]
initial_overlap = "push"
"#;

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
    let frames = summary["frames"].as_u64().unwrap();
    assert!(bench.read("short_results/results.pvd").matches("<DataSet").count() as u64 == frames);
    // The checkpoint is from before: the run stops again, in the same way.
    let again = bench.run(&["resume", "short_results", "--quiet"]);
    assert_eq!(again.code, Some(1), "{}", again.stderr);
    assert_eq!(bench.json("short_results/run.json")["status"], summary["status"]);

    bench.write("loose.toml", &SHORT.replace("end_time", "energy_bound = 0.9\nend_time"));
    let run = bench.run(&["run", "loose.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);

    bench.write("sweep.toml", "model = \"short.toml\"\n[grid]\n\"model.energy_bound\" = [0.05, 0.9]\n");
    let sweep = bench.run(&["sweep", "sweep.toml"]);
    assert_eq!(sweep.code, Some(1), "{}", sweep.stderr);
    let results = bench.read("sweep_results/results.csv");
    assert!(results.contains("stopped") && results.contains("finished"), "{results}");
}
