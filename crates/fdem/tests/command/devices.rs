//! Graphics processors: the list of them, searches and runs on them, and those that are refused.

use std::fmt::Write;

use crate::Bench;

/// Whether there is a graphics processor, and fdem was built for it.
fn has_device(bench: &Bench) -> bool {
    let run = bench.run(&["devices"]).succeeds();
    let (first, rest) = run.stdout.split_once('\n').unwrap();
    assert!(first.starts_with("cpu    ") && first.contains(" processors, "), "{first}");
    let found = rest.starts_with("gpu:0  ");
    assert!(found || rest.starts_with("No graphics processor: ") && rest.ends_with(".\n"), "{rest}");
    found
}

#[test]
fn a_device_has_the_couples_of_the_processor_or_says_why_not() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "2000", "--seed", "1", "--output", "gas.csv"]).succeeds();
    bench.write("grains.csv", grains());
    let periodic = ["--periodic", "xz", "--box", "0,10,0,10,0,10"];
    let bodies = ["--bodies", "body"];
    let cutoffs = ["--cutoff", "A-A=0.9,A-B=0.7"];
    let has_device = has_device(&bench);
    for (file, options) in [
        ("gas.csv", vec![]),
        ("grains.csv", periodic.to_vec()),
        ("grains.csv", [&periodic[..], &bodies].concat()),
        ("grains.csv", [&bodies[..], &cutoffs].concat()),
    ] {
        let with = |device: &str, output: &str| {
            let places = ["contacts", file, "--device", device, "--output", output, "--verify", "20"];
            bench.run(&[&places[..], &options].concat())
        };
        with("cpu", "cpu.csv").succeeds();
        assert!(bench.read("cpu.csv").lines().count() > 100, "{file}: {options:?}");
        if has_device {
            with("gpu", "gpu.csv").succeeds();
            assert_eq!(bench.read("cpu.csv"), bench.read("gpu.csv"), "{file}: {options:?}");
        } else {
            with("gpu", "gpu.csv").refused_with(&["--device gpu: "]);
            assert_eq!(bench.files(), ["cpu.csv", "gas.csv", "grains.csv"]);
        }
        with("gpu:1000", "gpu.csv").refused_with(&["--device gpu: "]);
    }
}

/// Spheres from 0 to 10 on each axis, with bodies and types.
fn grains() -> String {
    let mut text = "x,y,z,radius,body,type\n".to_owned();
    for k in 0..1000_u32 {
        let [x, y, z] =
            [k % 10, k / 10 % 10, k / 100].map(|i| f64::from(i) + f64::from(k * 37 % 100) * 0.005);
        writeln!(text, "{x},{y},{z},0.45,{},{}", k % 3, ["A", "B"][k as usize % 2]).unwrap();
    }
    text
}

#[test]
fn options_that_do_not_go_with_a_device_are_refused() {
    let bench = Bench::new();
    bench.write("packing.csv", "x,y,r\n0,0,1\n1,0,1\n");
    let refused = |options: &[&str], part: &str| {
        bench.run(&[&["contacts", "packing.csv"], options].concat()).refused_with(&[part]);
    };
    refused(&["--device", "tpu"], "give cpu, gpu, or gpu:N");
    refused(&["--device", "gpu:"], "give cpu, gpu, or gpu:N");
    refused(&["--device", "gpu", "--labels"], "--device gpu does not go with --labels");
    refused(&["--device", "gpu", "--explain"], "--device gpu does not go with --explain");
    refused(&["--device", "gpu", "--engine", "nbs"], "--device gpu has the engine rows only");
    refused(&["--device", "gpu", "packing.csv"], "--device gpu does not go with more than one file");
}

#[test]
fn a_device_is_timed_or_says_why_not() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "2000", "--output", "gas.csv"]).succeeds();
    let with = |device: &str| {
        bench.run(&["bench", "gas.csv", "--repeat", "1", "--device", device, "--json", "t.json"])
    };
    if has_device(&bench) {
        with("gpu").succeeds();
        let rows = bench.json("t.json");
        assert_eq!([&rows[0]["engine"], &rows[0]["device"]], ["rows", "gpu:0"]);
        assert_eq!(rows[0]["couples"], rows[1]["couples"]);
    } else {
        with("gpu").refused_with(&["--device gpu: "]);
        assert!(!bench.path("t.json").exists());
    }
    with("gpu:1000").refused_with(&["--device gpu: "]);
    with("tpu").refused_with(&["give cpu, gpu, or gpu:N"]);
    with("cpu").succeeds();
    assert!(bench.json("t.json")[0].get("device").is_none());
}

/// An elastic bar that is hit at one end.
const BAR: &str = r#"
[model]
end_time = 1e-4

[[body]]
name = "bar"
material = "steel"
rectangle = { min = [0, 0], max = [0.2, 0.02] }
mesh_size = 0.01

[[material]]
name = "steel"
density = 7800
youngs_modulus = 200e9
poissons_ratio = 0.3

[[boundary]]
name = "blow"
body = "bar"
side = "left"
traction = [1e6, 0]
"#;

#[test]
fn a_run_on_a_device_has_the_results_of_the_processor_or_says_why_not() {
    let bench = Bench::new();
    bench.write("bar.toml", BAR);
    let with = |device: &str, output: &str| {
        bench.run(&["run", "bar.toml", "--device", device, "--output", output, "--quiet"])
    };
    with("cpu", "on_cpu").succeeds();
    if has_device(&bench) {
        with("gpu", "on_gpu").succeeds();
        assert_eq!(bench.read("on_cpu/history.csv"), bench.read("on_gpu/history.csv"));
    } else {
        with("gpu", "on_gpu").refused_with(&["--device gpu: "]);
        bench.run(&["resume", "on_cpu", "--device", "gpu"]).refused_with(&["--device gpu: "]);
    }
    with("gpu:1000", "other").refused_with(&["--device gpu: "]);
    assert!(!bench.path("other").exists());
}

/// A check has the memory of a run on a device, whether there is one or not.
#[test]
fn a_run_on_a_device_is_estimated() {
    let bench = Bench::new();
    bench.write("bar.toml", BAR);
    let has_device = has_device(&bench);
    let run = bench.run(&["check", "bar.toml", "--device", "gpu"]).succeeds();
    let parts: &[&str] = if has_device {
        &["device           gpu:0, ", "  memory         it fits"]
    } else {
        &["device           gpu:0 is not on this machine: "]
    };
    for part in parts.iter().chain(&["  arrays         ", " bytes for each element", "a guess of "]) {
        assert!(run.stdout.contains(part), "{part:?} is not in\n{}", run.stdout);
    }
    let run = bench.run(&["check", "bar.toml", "--device", "gpu:1000", "--json"]).succeeds();
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let device = &json["on_device"];
    assert!(
        device["missing"].is_string() && device["card"].is_null() && device["fits"].is_null(),
        "{device}"
    );
    assert_eq!(device["elements"], json["quality"]["elements"]);
    let bytes = device["memory"].as_f64().unwrap() / device["elements"].as_f64().unwrap();
    assert!((200.0..400.0).contains(&bytes), "{bytes} bytes for each element");
    let plain = bench.run(&["check", "bar.toml", "--json"]).succeeds();
    assert!(!plain.stdout.contains("on_device"));

    let bedding = "[material.anisotropy]\ndip = 30\nyoungs_modulus = 100e9\npoissons_ratio = 0.2\nshear_modulus = 40e9\n\n[[boundary]]";
    bench.write("bedded.toml", BAR.replace("[[boundary]]", bedding));
    let run = bench.run(&["check", "bedded.toml", "--device", "gpu"]).succeeds();
    assert!(run.stdout.contains(" bytes for each element"), "{}", run.stdout);
    bench.run(&["check", "bar.toml", "--device", "gpu", "--ranks", "2"]).refused_with(&["--ranks"]);
    bench.run(&["check", "bar.toml", "--device", "tpu"]).refused_with(&["give cpu, gpu, or gpu:N"]);
}

/// A check and a run take stages on a device.
#[test]
fn a_run_in_stages_goes_to_a_device_too() {
    let bench = Bench::new();
    let stages = "\n[[stage]]\nname = \"blown\"\nduration = 3e-5\n\n[[stage]]\nname = \"free\"\nexcavate_boxes = [[0.1501, 0, 0.2, 0.02]]\n";
    bench.write("bar.toml", BAR.to_owned() + stages);
    let run = bench.run(&["check", "bar.toml", "--device", "gpu"]).succeeds();
    assert!(run.stdout.contains(" in the first stage: "), "{}", run.stdout);
    let with = |device: &str, output: &str| {
        bench.run(&["run", "bar.toml", "--device", device, "--output", output, "--quiet"])
    };
    with("cpu", "on_cpu").succeeds();
    if has_device(&bench) {
        with("gpu", "on_gpu").succeeds();
        assert_eq!(bench.read("on_cpu/history.csv"), bench.read("on_gpu/history.csv"));
    } else {
        with("gpu", "on_gpu").refused_with(&["--device gpu: "]);
    }
}

/// `just gpu` fails where there is no graphics processor, before it does anything.
#[cfg(unix)]
#[test]
fn the_checks_that_need_a_device_fail_without_one() {
    let bench = Bench::new();
    if has_device(&bench) {
        return;
    }
    let run = std::process::Command::new("bash")
        .arg(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.ci/gpu"))
        .env("FDEM", assert_cmd::cargo::cargo_bin!("fdem"))
        .output()
        .unwrap();
    let said = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{said}");
    assert_eq!(said, "FAILED: there is no graphics processor, and all that follows needs one\n");
}
