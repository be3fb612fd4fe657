//! Graphics processors: the list of them, and searches that are refused.

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
    let with = |device: &str, output: &str| {
        bench.run(&["contacts", "gas.csv", "--device", device, "--output", output, "--verify", "20"])
    };
    with("cpu", "cpu.csv").succeeds();
    if has_device(&bench) {
        with("gpu", "gpu.csv").succeeds();
        assert_eq!(bench.read("cpu.csv"), bench.read("gpu.csv"));
    } else {
        with("gpu", "gpu.csv").refused_with(&["--device gpu: "]);
        assert_eq!(bench.files(), ["cpu.csv", "gas.csv"]);
    }
    with("gpu:1000", "gpu.csv").refused_with(&["--device gpu: "]);
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
    refused(
        &["--device", "gpu", "--periodic", "x", "--box", "0,9,0,9"],
        "--device gpu does not go with --periodic",
    );
    refused(&["--device", "gpu", "--explain"], "--device gpu does not go with --explain");
    refused(&["--device", "gpu", "--engine", "nbs"], "--device gpu has the engine rows only");
    refused(&["--device", "gpu", "packing.csv"], "--device gpu does not go with more than one file");
}
