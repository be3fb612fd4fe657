//! Fluid in cracks: results, columns, stages, runs that continue, and refusals.

use crate::Bench;

/// A plate with a hole and an open joint at its wall, into which water is pumped.
const PLATE: &str = r#"[model]
title = "plate"
plane = "strain"
end_time = 4e-5
[[body]]
name = "plate"
material = "rock"
rectangle = { min = [-0.1, -0.1], max = [0.1, 0.1], holes = [{ centre = [0, 0], radius = 0.02 }] }
mesh_size = 0.012
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
damping = 0.1
friction = 0.6
tensile_strength = 2e6
cohesion = 10e6
friction_angle = 40
fracture_energy_i = 2
fracture_energy_ii = 20
[[joint_set]]
name = "notch"
lines = [[0.015, 0, 0.045, 0]]
friction_angle = 30
open = true
aperture = "20 um"
[fluid]
viscosity = "1 cP"
bulk_modulus = "0.5 GPa"
[[injection]]
name = "well"
at = [0, 0]
rate = 0.3
initial_pressure = 0
[output]
frames = 4
history_interval = 1e-6
fields = ["fluid_pressure", "max_principal"]
"#;

/// A column of the history of a run.
pub(crate) fn column(bench: &Bench, folder: &str, name: &str) -> Vec<f64> {
    crate::stages::column(&bench.read(&format!("{folder}/history.csv")), name)
}

#[test]
fn a_run_records_its_fluid() {
    let bench = Bench::new();
    bench.write("plate.toml", PLATE);
    let check = bench.run(&["check", "plate.toml"]);
    assert_eq!(check.code, Some(0), "{}", check.stderr);
    assert!(check.stdout.contains("\nfluid            "), "{}", check.stdout);
    assert!(check.stdout.contains("well: a fracture in the regime of "), "{}", check.stdout);
    let run = bench.run(&["run", "plate.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let last = |name: &str| *column(&bench, "plate_results", name).last().unwrap();
    let injected = last("fluid injected [m³]");
    assert!((injected / (0.3 * 4e-5) - 1.0).abs() < 0.01, "{injected}");
    assert_eq!(last("well injected [m³]"), injected);
    assert!((last("well rate [m³/s]") / 0.3 - 1.0).abs() < 1e-9);
    assert!(last("well pressure [Pa]") > 1e6 && last("fluid wet_length [m]") > 0.02);
    assert!(last("fluid mass_error [kg]").abs() < 1e-12 * 1000.0);
    let balance =
        last("fluid initial [m³]") + injected - last("fluid leaked [m³]") - last("fluid stored [m³]");
    assert!(balance.abs() < 1e-12, "{balance}");
    let summary = bench.json("plate_results/run.json");
    assert_eq!(summary["fluid"]["injected"], injected);
    assert_eq!(summary["fluid"]["injections"][0]["name"], "well");
    assert!(bench.read("plate_results/run.log").contains("fluid            "));
    let names: Vec<String> = std::fs::read_dir(bench.path("plate_results/frames"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let of_cracks = names.iter().filter(|name| name.ends_with("_cracks.vtp")).max().unwrap();
    let bytes = std::fs::read(bench.path("plate_results/frames").join(of_cracks)).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    for field in ["fluid_pressure", "aperture", "saturation"] {
        assert!(text.contains(&format!("\"{field}\"")), "{of_cracks} has no {field}");
    }
    assert!(bench.read("plate_results/report.html").contains("pressure of the fluid"));
}

#[test]
fn a_run_without_fluid_has_no_fields_of_fluid() {
    let bench = Bench::new();
    let (rock, _) = PLATE.split_once("[fluid]").unwrap();
    bench.write("dry.toml", rock.replace("aperture = \"20 um\"\n", "").replace("4e-5", "4e-6"));
    let run = bench.run(&["run", "dry.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(!bench.read("dry_results/report.html").contains("pressure of the fluid"));
    assert!(!bench.read("dry_results/history.csv").contains("fluid"));
    assert!(bench.json("dry_results/run.json")["fluid"].is_null());
    bench.write(
        "asks.toml",
        rock.replace("aperture = \"20 um\"\n", "") + "[output]\nfields = [\"fluid_pressure\"]\n",
    );
    let run = bench.run(&["check", "asks.toml"]);
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("there is no fluid"), "{}", run.stderr);
}

/// Fluid that begins in the second stage, and is shut in in the third: an interrupted run that continues has
/// the bits of a whole one.
#[test]
fn fluid_begins_in_a_later_stage_and_a_run_continues() {
    let bench = Bench::new();
    let stages = "[[stage]]\nname = \"dry\"\nduration = 1e-5\n[[stage]]\nname = \"pump\"\nduration = 2e-5\n\
                  [[stage]]\nname = \"shut in\"\n[fluid]\nfrom_stage = \"pump\"\n";
    let staged = PLATE.replace("[fluid]\n", stages).replace("rate = 0.3", "rate = 0.3\nstages = [\"pump\"]");
    bench.write("staged.toml", &staged);
    let run = bench.run(&["run", "staged.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let injected = column(&bench, "staged_results", "well injected [m³]");
    let times = column(&bench, "staged_results", "time");
    let at = |time: f64| injected[times.iter().position(|of| *of >= time).unwrap()];
    assert!(at(0.5e-5).is_nan());
    assert!((at(2e-5) / (0.3 * 1e-5) - 1.0).abs() < 0.1, "{}", at(2e-5));
    let last = *injected.last().unwrap();
    assert!((last / (0.3 * 2e-5) - 1.0).abs() < 0.05, "{last}");
    assert!(column(&bench, "staged_results", "fluid mass_error [kg]").last().unwrap().abs() < 1e-9);
    // The same run in two parts.
    bench.write("parts.toml", &staged);
    let text = staged.replace("end_time = 4e-5", "end_time = 2.1e-5");
    bench.write("parts.toml", text);
    let run = bench.run(&["run", "parts.toml", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let run = bench.run(&["resume", "parts_results", "--until", "4e-5", "--quiet"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(
        column(&bench, "parts_results", "well pressure [Pa]").last(),
        column(&bench, "staged_results", "well pressure [Pa]").last()
    );
}

#[test]
fn fluid_on_ranks_is_foretold() {
    let bench = Bench::new();
    bench.write("plate.toml", PLATE);
    let run = bench.run(&["check", "plate.toml", "--ranks", "2"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("\nfluid            "), "{}", run.stdout);
}
