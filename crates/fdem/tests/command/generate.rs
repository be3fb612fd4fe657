//! Packings from seeds.

use crate::Bench;

const KINDS: [&[&str]; 10] = [
    &["gas", "--dims", "2"],
    &["gas", "--sizes", "power:1:50:-2.5", "--neighbours", "1.4"],
    &["lattice", "--spacing", "1.5"],
    &["lattice", "--dims", "2"],
    &["jittered", "--sizes", "lognormal:0.5:0.25", "--jitter", "0.4"],
    &["clusters", "--per-cluster", "50"],
    &["clusters", "--dims", "2", "--domain", "1e6"],
    &["deposit", "--sizes", "lognormal:0.5:0.3"],
    &["book", "--packing", "a"],
    &["book", "--packing", "d", "--dims", "2", "--spacing", "20"],
];

#[test]
fn every_kind_makes_a_packing_that_can_be_read() {
    let bench = Bench::new();
    for (k, kind) in KINDS.iter().enumerate() {
        let [csv, npy] = ["csv", "npy"].map(|extension| format!("{k}.{extension}"));
        let arguments = |output| [&["generate"], *kind, &["-n", "500", "--output", output]].concat();
        bench.run(&arguments(&csv)).succeeds();
        bench.run(&arguments(&npy)).succeeds();
        let count = |file: &str, options: &[&str]| {
            let run =
                bench.run(&[&["contacts", file, "--count", "--json", "s.json"], options].concat()).succeeds();
            assert_eq!(bench.json("s.json")["elements"], 500, "{kind:?}");
            run.stdout
        };
        let planar = kind.contains(&"deposit") || kind.windows(2).any(|option| option == ["--dims", "2"]);
        // Three columns of an array without names are x, y and z by default.
        let columns: &[&str] = if planar { &["--columns", "x,y,radius"] } else { &[] };
        assert_eq!(count(&csv, &[]), count(&npy, columns), "{kind:?}: both formats hold the same numbers");
    }
}

#[test]
fn the_seed_decides() {
    let bench = Bench::new();
    let generate = |seed: &str| bench.run(&["generate", "gas", "-n", "50", "--seed", seed]).succeeds().stdout;
    assert_eq!(generate("7"), generate("7"));
    assert_ne!(generate("7"), generate("8"));
    assert_eq!(generate("7").lines().next(), Some("x,y,z,radius"));
    assert_eq!(generate("7").lines().count(), 51);
}

#[test]
fn a_gas_has_the_neighbours_asked_for() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "50000", "--neighbours", "12", "-o", "gas.csv"]).succeeds();
    bench.run(&["contacts", "gas.csv", "--count", "--json", "s.json"]).succeeds();
    let mean = bench.json("s.json")["mean_coordination"].as_f64().unwrap();
    // Elements near the faces of the domain lack some.
    assert!((11.0..12.1).contains(&mean), "{mean}");
}

#[test]
fn parameters_that_make_no_packing_are_refused() {
    let bench = Bench::new();
    let refused: [(&[&str], &str); 11] = [
        (&["gas", "--neighbours", "0"], "not above zero"),
        (&["gas", "--sizes", "power:2:1:-1"], "exceeds"),
        (&["gas", "--sizes", "equal:-1"], "radius"),
        (&["gas", "--dims", "4"], "--dims"),
        (&["lattice", "--spacing", "nan"], "not a finite number"),
        (&["deposit", "--dims", "3"], "--dims"),
        (&["book", "--packing", "a", "--spacing", "3"], "packing A is dense"),
        (&["gas", "--seed", "-1"], "'-1' is not a whole number"),
        (&["gas", "--sizes", "foo"], "expected equal:R"),
        (&["deposit", "--width", "0.1"], "disc"),
        (&["book"], "--packing"),
    ];
    for (kind, part) in refused {
        bench.run(&[&["generate"], kind, &["-o", "out.csv"]].concat()).refused_with(&[part]);
        assert!(bench.files().is_empty(), "{kind:?}");
    }
    bench.run(&["generate", "gas", "-o", "out.txt"]).refused_with(&[".csv or .npy"]);
}

/// The packing in `examples/` is the output of its command, on this platform too.
#[test]
fn the_example_is_reproduced_to_the_byte() {
    let example = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/packing.csv");
    let bench = Bench::new();
    let command = "generate deposit -n 600 --seed 1 --sizes lognormal:0.5:0.3 --width 30 -o packing.csv";
    bench.run(&command.split(' ').collect::<Vec<_>>()).succeeds();
    assert_eq!(bench.read("packing.csv"), std::fs::read_to_string(example).unwrap());
}
