//! Good packings of every form.

use crate::Bench;

/// Three discs in a row: 0 and 1 overlap by 0.25, 1 and 2 just touch.
const ROW: &str = "x,y,radius\n0,0,1\n1.75,0,1\n4.25,0,1.5\n";

const COUPLES: [&str; 2] = ["0,1,1.75,0.25", "1,2,2.5,0.0"];

#[test]
fn couples_go_to_standard_output_and_the_summary_to_standard_error() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    let run = bench.run(&["contacts", "row.csv"]).succeeds();
    assert_eq!(run.rows(), COUPLES);
    for part in [
        "3 discs in 2D",
        "radius 1 to 1.5",
        "couples          2",
        "1.3333",
        "largest overlap  0.25 between 0 and 1",
        "direct",
    ] {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    assert_eq!(bench.run(&["contacts", "row.csv", "--quiet"]).succeeds().stderr, "");
}

#[test]
fn every_spelling_of_the_same_packing_gives_the_same_couples() {
    let bench = Bench::new();
    let spellings: [(&str, &[&str]); 14] = [
        (ROW, &[]),
        ("0 0 1\n1.75 0 1\n4.25 0 1.5\n", &["--columns", "x,y,radius"]),
        ("Radius[m]\tPosX[m] PosY[m]\n 1 0 0\r\n 1\t1.75 0\r\n 1.5 4.25 0", &[]),
        ("X (mm);Y (mm);diameter (mm)\n0;0;2\n1.75;0;2\n4.25;0;3\n", &[]),
        ("# written by numpy\n# x y r\n0 0 1\n1.75 0 1\n\n4.25 0 1.5 # the last\n", &[]),
        (
            "\"Points:0\",\"Points:1\",\"radius\",\"Points_Magnitude\"\n0,0,1,0\n1.75,0,1,0\n4.25,0,1.5,0\n",
            &[],
        ),
        ("\u{feff}x y d\n0 0 2\n1.75 0 2\n4.25 0 3\n", &[]),
        ("a b c\n1 0 0\n1 1.75 0\n1.5 4.25 0\n", &["--columns", "x=b,y=c,radius=a"]),
        ("9 0 0 1\n9 1.75 0 1\n9 4.25 0 1.5\n", &["--columns", "_,x,y,r"]),
        ("0 0 0 1\n1.75 0 0 1\n4.25 0 0 1.5\n", &[]),
        ("x,y,z,radius\n0,0,0,1e0\n+1.75,-0,0,1.\n.425e1,0,0,1.5\n", &[]),
        ("x,y,radius\n0,0,1\n1.75,0,1\n4.25,0,1.5\nwhat,is,this\n", &["--skip-bad-lines"]),
        ("id,x,y,radius\n0,0,0,1\n1,1.75,0,1\n2,4.25,0,1.5\n", &[]),
        ("id,x,y,radius\n7,0,0,1\n8,1.75,0,1\n9,4.25,0,1.5\n", &["--ignore-ids"]),
    ];
    for (text, options) in spellings {
        let run = bench.run_with(&[&["contacts", "-"], options].concat(), text.as_bytes()).succeeds();
        assert_eq!(run.rows(), COUPLES, "{text}");
    }
}

#[test]
fn ids_of_the_file_name_the_elements() {
    let bench = Bench::new();
    bench.write("ids.csv", "id,x,y,r\n70,0,0,1\n-3,1.75,0,1\n9000000000,4.25,0,1.5\n");
    let run = bench.run(&["contacts", "ids.csv", "--json", "s.json"]).succeeds();
    assert_eq!(run.rows(), ["70,-3,1.75,0.25", "-3,9000000000,2.5,0.0"]);
    assert_eq!(bench.json("s.json")["max_overlap_couple"], serde_json::json!([70, -3]));
}

#[test]
fn points_need_a_cutoff_and_take_one_radius() {
    let bench = Bench::new();
    bench.write("points.txt", "0 0\n3 4\n6 8\n");
    assert_eq!(bench.run(&["contacts", "points.txt", "--cutoff", "5"]).succeeds().rows().len(), 2);
    assert_eq!(bench.run(&["contacts", "points.txt", "--cutoff", "4.999"]).succeeds().rows().len(), 0);
    let run = bench.run(&["contacts", "points.txt", "--radius", "2.75"]).succeeds();
    assert_eq!(run.rows(), ["0,1,5.0,0.5", "1,2,5.0,0.5"]);
    // An option wins over the file.
    bench.write("row.csv", ROW);
    assert_eq!(bench.run(&["contacts", "row.csv", "--radius", "0.5"]).succeeds().rows().len(), 0);
    assert_eq!(bench.run(&["contacts", "row.csv", "--cutoff", "4.25"]).succeeds().rows().len(), 3);
    bench.run(&["contacts", "points.txt"]).refused_with(&[
        "points.txt: no column for radius",
        "--radius",
        "--cutoff",
    ]);
}

#[test]
fn a_tolerance_adds_couples_across_a_gap() {
    let bench = Bench::new();
    bench.write("gap.csv", "x,y,r\n0,0,1\n2.5,0,1\n");
    assert_eq!(bench.run(&["contacts", "gap.csv"]).succeeds().rows().len(), 0);
    assert_eq!(bench.run(&["contacts", "gap.csv", "--tolerance", "0.5"]).succeeds().rows(), ["0,1,2.5,-0.5"]);
}

#[test]
fn all_engines_write_identical_files() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "3000", "--sizes", "lognormal:0.5:0.2", "-o", "gas.csv"]).succeeds();
    for engine in ["auto", "direct", "nbs", "rows"] {
        let output = format!("{engine}.csv");
        let run = bench
            .run(&["contacts", "gas.csv", "--engine", engine, "-o", &output, "--verify", "50"])
            .succeeds();
        assert_eq!(run.stdout, "");
        assert!(run.stderr.contains("50 elements by brute force"), "{}", run.stderr);
    }
    let direct = bench.read("direct.csv");
    assert!(direct.lines().count() > 5000);
    assert_eq!(bench.read("nbs.csv"), direct);
    assert_eq!(bench.read("rows.csv"), direct);
    assert_eq!(bench.read("auto.csv"), direct);
}

#[test]
fn count_prints_the_number_and_keeps_none() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    let run = bench.run(&["contacts", "row.csv", "--count", "--verify", "3"]).succeeds();
    assert_eq!(run.stdout, "2\n");
}

#[test]
fn the_json_summary_has_what_the_text_has() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    bench.run(&["contacts", "row.csv", "--json", "s.json", "--engine", "nbs", "--quiet"]).succeeds();
    let summary = bench.json("s.json");
    assert_eq!(summary["elements"], 3);
    assert_eq!(summary["dimensions"], 2);
    assert_eq!(summary["couples"], 2);
    assert_eq!(summary["mean_coordination"], 4.0 / 3.0);
    assert_eq!(summary["rattlers"], 0);
    assert_eq!(summary["max_overlap"], 0.25);
    assert_eq!(summary["engine"], "nbs");
    assert_eq!(summary["domain"], serde_json::json!([[-1.0, 5.75], [-1.5, 1.5]]));
    let cell = summary["cell_size"].as_f64().unwrap();
    assert!((3.0..3.001).contains(&cell), "{cell}");
    for phase in ["read", "detect", "write"] {
        assert!(summary["seconds"][phase].as_f64().unwrap() >= 0.0);
    }
    #[cfg(unix)]
    assert!(summary["peak_bytes"].as_u64().unwrap() > 100_000);
}

#[test]
fn numpy_arrays_go_in_and_out() {
    let bench = Bench::new();
    bench.run(&["generate", "lattice", "-n", "27", "--output", "cubes.npy"]).succeeds();
    bench.run(&["contacts", "cubes.npy", "--output", "couples.npy"]).succeeds();
    let bytes = std::fs::read(bench.path("couples.npy")).unwrap();
    let npy = npyz::NpyFile::new(&bytes[..]).unwrap();
    let npyz::DType::Record(fields) = npy.dtype() else { panic!("a record per couple") };
    assert_eq!(
        fields.iter().map(|field| field.name.as_str()).collect::<Vec<_>>(),
        ["i", "j", "distance", "overlap"]
    );
    assert_eq!(npy.shape(), [54]);
    // The records are four 8-byte numbers; the first couple is 0-1, at distance 1.
    let data = &bytes[bytes.len() - 54 * 32..];
    let word = |k: usize| <[u8; 8]>::try_from(&data[8 * k..8 * k + 8]).unwrap();
    assert_eq!((i64::from_le_bytes(word(0)), i64::from_le_bytes(word(1))), (0, 1));
    assert_eq!((f64::from_le_bytes(word(2)), f64::from_le_bytes(word(3))), (1.0, 0.0));
}

#[test]
fn radii_that_an_option_replaces_are_reported() {
    let bench = Bench::new();
    bench.write("discs.csv", "x,y,radius\n0,0,1\n1,0,1\n");
    for option in ["--radius", "--cutoff"] {
        let run = bench.run(&["contacts", "discs.csv", "--count", option, "0.6"]).succeeds();
        assert!(run.stderr.contains("the radii of the file are not used"), "{}", run.stderr);
    }
    let run = bench.run(&["contacts", "discs.csv", "--count"]).succeeds();
    assert!(!run.stderr.contains("not used"), "{}", run.stderr);
}

#[test]
fn elements_none_and_zero_radius() {
    let bench = Bench::new();
    bench.write("none.csv", "x,y,radius\n");
    let run = bench.run(&["contacts", "none.csv", "--json", "s.json"]).succeeds();
    assert_eq!(run.rows(), [""; 0]);
    assert_eq!(bench.json("s.json")["max_overlap"], serde_json::Value::Null);
    bench.write("points.csv", "x,y,radius\n0,0,0\n0,0,0\n1,0,1\n");
    let run = bench.run(&["contacts", "points.csv"]).succeeds();
    assert_eq!(run.rows().len(), 3);
    assert!(run.stderr.contains("2 of radius zero"), "{}", run.stderr);
}

#[test]
fn the_cutoff_is_shown_and_points_have_no_size() {
    let bench = Bench::new();
    bench.write("points.txt", "0 0\n3 4\n");
    let run = bench.run(&["contacts", "points.txt", "--cutoff", "5", "--json", "s.json"]).succeeds();
    for part in ["2 points in 2D", "cut-off          5", "domain           [0, 3] x [0, 4]"] {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    assert_eq!(bench.json("s.json")["cutoff"], 5.0);
}

/// Elements keep the number of their row in the file when others are left out.
#[test]
fn skipped_lines_do_not_renumber_the_others() {
    let bench = Bench::new();
    bench.write("in.csv", "x,y,r\n0,0,1\nbad,0,1\n1,0,1\n1.5,0,1\n");
    let run = bench.run(&["contacts", "in.csv", "--skip-bad-lines"]).succeeds();
    assert_eq!(run.rows(), ["0,2,1.0,1.0", "0,3,1.5,0.5", "2,3,0.5,1.5"]);
    assert!(run.stderr.contains("between 2 and 3"), "{}", run.stderr);
}

/// `--output -` is standard output, as `-` is standard input.
#[test]
fn a_dash_is_standard_output() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    assert_eq!(bench.run(&["contacts", "row.csv", "-o", "-"]).succeeds().rows(), COUPLES);
    assert_eq!(bench.files(), ["row.csv"]);
}

/// `fdem contacts … | head -1`
#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "30000", "-o", "gas.csv"]).succeeds();
    let mut command = bench.command(&["contacts", "gas.csv", "--quiet", "--json", "s.json"]);
    let mut child =
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), b"".as_slice()));
    assert!(
        bench.json("s.json")["couples"].as_u64().unwrap() > 50_000,
        "the other outputs are written all the same"
    );
}

/// The output of an earlier run is replaced whole; a link to it stays a link.
#[cfg(unix)]
#[test]
fn an_output_is_replaced_through_a_link() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    bench.write(
        "real.csv",
        "something long that was here before, and must not shine through at the end\n".repeat(9),
    );
    std::os::unix::fs::symlink(bench.path("real.csv"), bench.path("link.csv")).unwrap();
    bench.run(&["contacts", "row.csv", "-o", "link.csv"]).succeeds();
    assert!(bench.path("link.csv").is_symlink());
    assert_eq!(bench.read("real.csv").lines().count(), 3);
    assert_eq!(bench.files(), ["link.csv", "real.csv", "row.csv"]);
}
