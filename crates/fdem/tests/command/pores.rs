//! Liquid in pores: consolidation, results, threads, runs that continue, stages, and refusals.

use std::f64::consts::PI;

use crate::Bench;
use crate::fluid::column as values;

/// Modulus of compression without strain across, Pa, load, Pa, and coefficient of consolidation, m²/s.
const DRAINED: f64 = 10e9 * 0.8 / (1.2 * 0.6);
const LOAD: f64 = 1e6;
const SPREAD: f64 = 25.0;

/// Storage without strain across, 1/Pa.
fn storage() -> f64 {
    1.0 / 8e9 + 0.64 / DRAINED
}

/// A column of 1 m that is loaded at its top, where it is drained. One and a half periods of the column leave
/// it without vibrations.
fn column() -> String {
    let permeability = SPREAD * storage() * 1e-3;
    format!(
        r#"[model]
title = "column"
plane = "strain"
end_time = 0.0132
local_damping = 0.3
[[body]]
name = "column"
material = "rock"
rectangle = {{ min = [0, 0], max = [0.0625, 1] }}
mesh_size = 0.0625
[[material]]
name = "rock"
density = 2500
youngs_modulus = 10e9
poissons_ratio = 0.2
damping = 0.1
pores = {{ permeability = {permeability:e}, biot = 0.8, biot_modulus = "8 GPa" }}
[pores]
[[pore_surface]]
name = "top"
side = "top"
pressure = 0
[[boundary]]
name = "sides"
sides = ["left", "right"]
fixed = "x"
[[boundary]]
name = "base"
side = "bottom"
fixed = "y"
[[boundary]]
name = "load"
side = "top"
pressure = 1e6
ramp = 2.4e-3
[[history]]
name = "bottom"
pore_pressure = [0.03, 0]
[contact]
penalty = 0.02
[output]
frames = 2
history_interval = 4e-4
fields = ["pore_pressure"]
"#
    )
}

/// Terzaghi's consolidation: the pressure at the base is `p0 Σ 2/m sin(m) exp(-m² c t/h²)` with
/// `m = (k + 1/2) π` and `p0 = α σ/(K_v S)`; half of the load is there after half of its time. The same in
/// two threads, and in two parts.
#[test]
fn a_column_consolidates() {
    let bench = Bench::new();
    bench.write("column.toml", column());
    let check = bench.run(&["check", "column.toml"]).succeeds();
    for line in [
        "\npores            34 nodes with a pressure",
        "rock: hydraulic diffusivity c = 25 m²/s",
        "h²/c = 0.04 s",
    ] {
        assert!(check.stdout.contains(line), "{line}\n{}", check.stdout);
    }
    bench.run(&["run", "column.toml", "--threads", "1", "--output", "one", "--quiet"]).succeeds();
    let found = values(&bench, "one", "bottom pressure [Pa]");
    let first = 0.8 * LOAD / (DRAINED * storage());
    let mut compared = 0;
    for (time, found) in
        values(&bench, "one", "time").into_iter().zip(&found).filter(|(time, _)| *time > 3.6e-3)
    {
        let spread = SPREAD * (time - 1.2e-3);
        let of = |k: u32| (f64::from(k) + 0.5) * PI;
        let exact: f64 =
            (0..60).map(of).map(|m| 2.0 / m * m.sin() * (-m * m * spread).exp()).sum::<f64>() * first;
        assert!((found - exact).abs() < 0.02 * first, "{time}: {found} {exact}");
        compared += 1;
    }
    assert!(compared > 20 && found.last().unwrap() < &(0.75 * first), "{compared} {found:?}");
    // Liquid that is no longer stored has left through the top.
    let last = |name: &str| *values(&bench, "one", name).last().unwrap();
    let inflow = last("top inflow [m³]");
    assert!(inflow < 0.0 && last("pores inflow [m³]") == inflow && last("pores exchanged [m³]") == 0.0);
    let change = last("pores stored [m³]") - last("pores initial [m³]");
    assert!((change / inflow - 1.0).abs() < 1e-9, "{change} {inflow}");
    assert!(last("pores volume_error [m³]").abs() < 1e-12 * inflow.abs());
    let summary = bench.json("one/run.json");
    assert_eq!(summary["pores"]["surfaces"][0]["inflow"], inflow);
    assert!(bench.read("one/run.log").contains("m³ through surfaces"));
    assert!(bench.read("one/report.html").contains("pressure in pores"));
    let frames = std::fs::read_dir(bench.path("one/frames")).unwrap();
    let names = frames.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let last_of = names.filter(|name| name.rsplit('.').next() == Some("vtu")).max().unwrap();
    let bytes = std::fs::read(bench.path("one/frames").join(last_of)).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("\"pore_pressure\""));

    bench.run(&["run", "column.toml", "--threads", "2", "--output", "two", "--quiet"]).succeeds();
    assert_eq!(bench.read("one/history.csv"), bench.read("two/history.csv"));
    bench.write("parts.toml", column().replace("end_time = 0.0132", "end_time = 0.005"));
    bench.run(&["run", "parts.toml", "--quiet"]).succeeds();
    bench.run(&["resume", "parts_results", "--until", "0.0132", "--quiet"]).succeeds();
    let end = |folder: &str| bench.read(&format!("{folder}/history.csv")).lines().last().unwrap().to_owned();
    assert_eq!(end("parts_results"), end("one"));
}

/// A column that is loaded while it is sealed, drained in the second stage, and sealed again: pressures and
/// volumes live from stage to stage.
#[test]
fn pores_live_from_stage_to_stage() {
    let bench = Bench::new();
    let stages = "[[stage]]\nname = \"load\"\nduration = 4e-3\n[[stage]]\nname = \"drain\"\nduration = 3e-3\n\
                  [[stage]]\nname = \"seal\"\n[pores]\nsteps = 4\n";
    let staged = column()
        .replace("[pores]\n", stages)
        .replace("pressure = 0\n", "pressure = 0\nstages = [\"drain\"]\n")
        .replace("end_time = 0.0132", "end_time = 0.008");
    bench.write("staged.toml", &staged);
    bench.run(&["run", "staged.toml", "--quiet"]).succeeds();
    let times = values(&bench, "staged_results", "time");
    let at = |name: &str, time: f64| {
        values(&bench, "staged_results", name)[times.iter().position(|of| *of >= time - 1e-9).unwrap()]
    };
    // Without flow: α M ε, under the load that the liquid and the frame bear.
    let sealed = 0.8 * 8e9 * LOAD / (DRAINED + 0.64 * 8e9);
    let bottom = at("bottom pressure [Pa]", 3.6e-3);
    assert!((bottom / sealed - 1.0).abs() < 0.02, "{bottom} {sealed}");
    assert_eq!(at("top inflow [m³]", 3.6e-3), 0.0);
    let [drained, end] = [7.2e-3, 8e-3].map(|time| at("top inflow [m³]", time));
    assert!(drained < -1e-8 && end == drained, "{drained} {end}");
    let error = values(&bench, "staged_results", "pores volume_error [m³]");
    assert!(error.iter().all(|error| error.abs() < 1e-12 * drained.abs()), "{error:?}");
    bench.write("parts.toml", staged.replace("end_time = 0.008", "end_time = 0.0062"));
    bench.run(&["run", "parts.toml", "--quiet"]).succeeds();
    bench.run(&["resume", "parts_results", "--until", "0.008", "--quiet"]).succeeds();
    let end = |folder: &str| bench.read(&format!("{folder}/history.csv")).lines().last().unwrap().to_owned();
    assert_eq!(end("parts_results"), end("staged_results"));
}

#[test]
fn a_run_without_pores_has_no_fields_of_pores() {
    let bench = Bench::new();
    let whole = column();
    let (before, after) = whole.split_once("[pores]").unwrap();
    let (_, boundaries) = after.split_once("[[boundary]]").unwrap();
    let (before, _) = before.split_once("pores =").unwrap();
    let (boundaries, _) = boundaries.split_once("[[history]]").unwrap();
    let dry = format!("{before}[[boundary]]{boundaries}").replace("0.0132", "1e-4");
    bench.write("dry.toml", &dry);
    bench.run(&["run", "dry.toml", "--quiet"]).succeeds();
    assert!(!bench.read("dry_results/report.html").contains("pressure in pores"));
    assert!(!bench.read("dry_results/history.csv").contains("pores"));
    assert!(bench.json("dry_results/run.json")["pores"].is_null());
    bench.write("asks.toml", dry + "[output]\nfields = [\"pore_pressure\"]\n");
    bench.run(&["check", "asks.toml"]).refused_with(&["there is no liquid in pores", "fields"]);
}

#[test]
fn a_check_reports_long_steps_and_sealed_pores() {
    let bench = Bench::new();
    bench.write("long.toml", column().replace("[pores]\n", "[pores]\nsteps = 400\n"));
    let check = bench.run(&["check", "long.toml"]).succeeds();
    assert!(check.stdout.contains("[pores]: a step of the flow of"), "{}", check.stdout);
    bench.write("pumped.toml", column().replace("pressure = 0\n", "rate = 1e-6\n"));
    let check = bench.run(&["check", "pumped.toml"]).succeeds();
    assert!(check.stdout.contains("no surface has a pressure"), "{}", check.stdout);
    assert!(!check.stdout.contains("[pores]"), "{}", check.stdout);
}

#[test]
fn pores_that_cannot_be_run_are_refused() {
    let bench = Bench::new();
    bench.write("column.toml", column());
    bench.run(&["check", "column.toml", "--ranks", "2"]).refused_with(&["pores: the run is on many ranks"]);
    bench.write("plate.toml", column().replace("plane = \"strain\"", "plane = \"stress\""));
    bench.run(&["run", "plate.toml"]).refused_with(&["plate.toml:", "not known in plane stress"]);
    bench.write("sealed.toml", column().replace("permeability = ", "permeability = -"));
    bench.run(&["run", "sealed.toml"]).refused_with(&["sealed.toml:", "permeability"]);
}
