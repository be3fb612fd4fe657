//! Boxes that repeat, threads, and predictions before a search.

use std::fmt::Write;

use crate::Bench;

/// A disc at each end of a box of 4 by 4, one in the middle that is two periods up, touching nothing.
const ENDS: &str = "x,y,radius\n0.25,2,0.5\n3.5,2,0.5\n2,8.5,0.5\n";

fn rows(run: &crate::Run, header: &str) -> Vec<String> {
    let mut lines = run.stdout.lines();
    assert_eq!(lines.next(), Some(header));
    lines.map(str::to_owned).collect()
}

#[test]
fn contacts_across_a_face_have_a_shift() {
    let bench = Bench::new();
    bench.write("ends.csv", ENDS);
    let options = ["contacts", "ends.csv", "--box", "0,4,0,4", "--periodic"];
    let run = bench.run(&[&options[..], &["x", "--json", "s.json", "--verify", "3"]].concat()).succeeds();
    assert_eq!(rows(&run, "i,j,distance,overlap,sx,sy"), ["0,1,0.75,0.25,-1,0"]);
    for part in [
        "periodic         along x: edges [4, 0], [0, 4] from [0, 0]",
        "largest overlap  0.25 between 0 and 1, shift [-1, 0]",
    ] {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    let summary = bench.json("s.json");
    assert_eq!(summary["max_overlap_shift"], serde_json::json!([-1, 0]));
    assert_eq!(summary["periodic"]["axes"], "x");
    assert_eq!(summary["periodic"]["edges"], serde_json::json!([[4.0, 0.0], [0.0, 4.0]]));
    assert_eq!(summary["verified"], 3);
    assert_eq!(summary["couples"], 1);

    // Along y only there is nothing to touch; without a box neither.
    let run = bench.run(&[&options[..], &["y"]].concat()).succeeds();
    assert_eq!(rows(&run, "i,j,distance,overlap,sx,sy"), [""; 0]);
    assert_eq!(bench.run(&["contacts", "ends.csv"]).succeeds().rows(), [""; 0]);

    let run = bench.run(&[&options[..], &["xy", "--count"]].concat()).succeeds();
    assert_eq!(run.stdout, "1\n");
    bench.run(&[&options[..], &["xy", "--count", "--picture", "p.svg"]].concat()).succeeds();
    assert_eq!(
        bench.read("p.svg").matches("<path").count(),
        2,
        "the contact across the face is drawn as two halves"
    );
}

/// One edge of 1.5 and discs of diameter 1 to 2: an element touches its own image, and another one from both
/// sides.
#[test]
fn small_and_sheared_boxes() {
    let bench = Bench::new();
    bench.write("two.csv", "id,x,y,r\n10,0.0,0.25,0.5\n20,0.75,0.25,0.5\n");
    let run = bench
        .run(&[
            "contacts",
            "two.csv",
            "--periodic",
            "x",
            "--box",
            "0,1.5,0,9",
            "--tolerance",
            "0.5",
            "--verify",
            "9",
        ])
        .succeeds();
    assert_eq!(
        rows(&run, "i,j,distance,overlap,sx,sy"),
        ["10,10,1.5,-0.5,1,0", "10,20,0.75,0.25,-1,0", "10,20,0.75,0.25,0,0", "20,20,1.5,-0.5,1,0"]
    );
    // The edge of the second axis leans by 0.5: the image above is half a unit to the right.
    bench.write("lean.csv", "x,y,r\n-1,-1,0.5\n-0.5,3,0.5\n");
    let run = bench
        .run(&[
            "contacts",
            "lean.csv",
            "--periodic",
            "xy",
            "--edges",
            "8,0,0.5,4.75",
            "--origin",
            "-2,-1.5",
            "--verify",
            "2",
        ])
        .succeeds();
    assert_eq!(rows(&run, "i,j,distance,overlap,sx,sy"), ["0,1,0.75,0.25,0,-1"]);
    assert!(run.stderr.contains("edges [8, 0], [0.5, 4.75] from [-2, -1.5]"), "{}", run.stderr);
}

#[test]
fn engines_threads_and_formats_agree_in_a_box() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "4000", "--sizes", "lognormal:0.5:0.2", "-o", "gas.csv"]).succeeds();
    // Smaller than the gas: most elements are wrapped.
    let sheared = "6,0,0,2,6,0,-1,1,6.5";
    let options = ["contacts", "gas.csv", "--periodic", "xz", "--edges", sheared, "--verify", "40"];
    let mut expected = None;
    for more in [
        ["--engine", "rows"],
        ["--engine", "nbs"],
        ["--engine", "auto"],
        ["--threads", "2"],
        ["--threads", "0"],
    ] {
        let run = bench.run(&[&options[..], &more].concat()).succeeds();
        assert!(run.stderr.contains("40 elements by brute force"), "{}", run.stderr);
        assert!(rows(&run, "i,j,distance,overlap,sx,sy,sz").len() > 10_000);
        assert!(expected.get_or_insert(run.stdout.clone()) == &run.stdout, "{more:?}");
    }
    let text = expected.unwrap();
    for row in text.lines().skip(1) {
        let overlap: f64 = row.split(',').nth(3).unwrap().parse().unwrap();
        assert!(overlap >= 0.0, "{row}");
    }
    bench.run(&[&options[..], &["-o", "couples.npy"]].concat()).succeeds();
    let bytes = std::fs::read(bench.path("couples.npy")).unwrap();
    let npy = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(npy.shape(), [text.lines().count() as u64 - 1]);
    let npyz::DType::Record(fields) = npy.dtype() else { panic!("a record per couple") };
    let names: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["i", "j", "distance", "overlap", "sx", "sy", "sz"]);
}

#[test]
fn threads_change_nothing() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "30000", "-o", "gas.csv"]).succeeds();
    let one = bench.run(&["contacts", "gas.csv", "--quiet"]).succeeds();
    for threads in ["0", "2", "3"] {
        let run = bench.run(&["contacts", "gas.csv", "--quiet", "--threads", threads]).succeeds();
        assert!(run.stdout == one.stdout, "{threads} threads");
        let count =
            bench.run(&["contacts", "gas.csv", "--quiet", "--count", "--threads", threads]).succeeds();
        assert_eq!(count.stdout.trim().parse::<usize>().unwrap(), one.rows().len());
    }
    for threads in ["1025", "18446744073709551615"] {
        let run = bench.run(&["contacts", "gas.csv", "--threads", threads]);
        run.refused_with(&["--threads", threads, "more than 1024"]);
    }
}

#[test]
fn boxes_that_make_no_sense_are_refused() {
    let bench = Bench::new();
    bench.write("in.csv", ENDS);
    bench.write("solid.csv", "x,y,z,r\n0,0,0,1\n");
    let refused: [(&[&str], &[&str]); 14] = [
        (&["--periodic", "x"], &["--periodic", "--box or --edges"]),
        (&["--box", "0,1,0,1"], &["--periodic"]),
        (&["--periodic", "xq", "--box", "0,1,0,1"], &["--periodic", "'q' is not one of x, y, z"]),
        (&["--periodic", "xx", "--box", "0,1,0,1"], &["--periodic", "given twice"]),
        (&["--periodic", "xyz", "--box", "0,1,0,1"], &["--periodic", "2D has no z"]),
        (&["--periodic", "x", "--box", "0,1,0,1,0,1"], &["--box", "4 numbers", "not 6"]),
        (&["--periodic", "x", "--box", "0,1,0"], &["--box", "not 3"]),
        (&["--periodic", "x", "--box", "0,1,0,much"], &["--box", "'much' is not a number"]),
        (&["--periodic", "x", "--box", "1,0,0,1"], &["--box"]),
        (&["--periodic", "x", "--box", "0,1,0,1", "--edges", "1,0,0,1"], &["--box", "--edges"]),
        (&["--periodic", "x", "--edges", "1,0,0"], &["--edges", "4 numbers", "not 3"]),
        (&["--periodic", "x", "--edges", "1,0,2,0"], &["--edges"]),
        (&["--periodic", "x", "--edges", "1,0,0,1", "--origin", "1"], &["--origin", "2 numbers"]),
        (&["--periodic", "x", "--box", "0,1,0,1", "--origin", "1,1"], &["--origin"]),
    ];
    for (options, parts) in refused {
        bench.run(&[&["contacts", "in.csv", "-o", "out.csv"], options].concat()).refused_with(parts);
        bench
            .run(&[&["contacts", "in.csv", "--explain", "--json", "e.json"], options].concat())
            .refused_with(parts);
        assert_eq!(bench.files(), ["in.csv", "solid.csv"], "{options:?}");
    }
    bench.run(&["contacts", "solid.csv", "--periodic", "z", "--box", "0,1,0,1"]).refused_with(&[
        "--box",
        "6 numbers",
        "not 4",
    ]);
    bench
        .run(&["contacts", "in.csv", "--threads", "-1"])
        .refused_with(&["--threads", "'-1' is not a whole number"]);
    // An element too far to be wrapped is named.
    bench.write("far.csv", "id,x,y,r\n7,1e12,0,0.1\n8,0,0,0.1\n");
    bench
        .run(&["contacts", "far.csv", "--periodic", "x", "--box", "0,1,0,1", "-o", "out.csv"])
        .refused_with(&["far.csv", "id 7"]);
    assert_eq!(bench.files(), ["far.csv", "in.csv", "solid.csv"]);
}

#[test]
fn a_search_is_explained_and_not_run() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "20000", "--neighbours", "12", "-o", "gas.csv"]).succeeds();
    let run =
        bench.run(&["contacts", "gas.csv", "--explain", "--threads", "2", "--json", "e.json"]).succeeds();
    for part in
        ["engine    rows: linear", "elements  20,000", "rows      ", "couples   about 1", "threads   2, "]
    {
        assert!(run.stdout.contains(part), "{part:?} is not in\n{}", run.stdout);
    }
    assert!(!run.stdout.contains("i,j,"), "no couples are written");
    let told = bench.json("e.json");
    let found =
        bench.run(&["contacts", "gas.csv", "--count"]).succeeds().stdout.trim().parse::<f64>().unwrap();
    let expected = told["expected_couples"].as_f64().unwrap();
    assert!((expected / found - 1.0).abs() < 0.1, "{expected} for {found}");
    assert_eq!(told["engine"], "rows");
    assert_eq!(told["elements"], 20_000);
    assert_eq!(told["threads"], 2);
    assert!(told["rows"].as_f64().unwrap() >= told["occupied_rows_at_most"].as_f64().unwrap());
    assert!((500_000..2_000_000).contains(&told["engine_bytes"].as_u64().unwrap()), "{told}");

    bench.write("few.csv", ENDS);
    let run = bench.run(&["contacts", "few.csv", "--explain"]).succeeds();
    assert!(
        run.stdout.contains("engine    direct") && run.stdout.contains("couples   0\n"),
        "{}",
        run.stdout
    );
    for option in ["--count", "--verify=3", "-o=x.csv", "--picture=x.svg", "--plots=x.svg", "--report=x.html"]
    {
        bench
            .run(&["contacts", "few.csv", "--explain", option])
            .refused_with(&["--explain", "cannot be used with"]);
    }
    bench.write("far.csv", format!("x,y,z,r\n0,0,0,1\n{}", "1e12,0,0,1\n".repeat(40)));
    bench
        .run(&["contacts", "far.csv", "--explain", "--engine", "nbs"])
        .refused_with(&["far.csv", "too many for the lists"]);
}

#[test]
fn a_search_in_a_box_is_explained_and_not_run() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "20000", "--neighbours", "12", "-o", "gas.csv"]).succeeds();
    // Most of the gas is outside of the sheared box, and so elements are wrapped.
    for edges in [&["--box", "0,19,0,19,0,19"][..], &["--edges", "9,0,0,3,9,0,-2,1,9"]] {
        let options = [&["contacts", "gas.csv", "--periodic", "xyz"], edges].concat();
        let told = |engine: &str| {
            let more = ["--engine", engine, "--explain", "--json", "e.json"];
            let run = bench.run(&[&options[..], &more].concat()).succeeds();
            for part in ["elements  20,000\n", "images    ", "couples   about "] {
                assert!(run.stdout.contains(part), "{part:?} is not in\n{}", run.stdout);
            }
            assert!(!run.stdout.contains("i,j,"), "no couples are written");
            bench.json("e.json")
        };
        let run = bench.run(&[&options[..], &["--count", "--json", "s.json"]].concat()).succeeds();
        let found = run.stdout.trim().parse::<f64>().unwrap();
        for engine in ["auto", "nbs"] {
            let told = told(engine);
            let expected = told["expected_couples"].as_f64().unwrap();
            assert!((expected / found - 1.0).abs() < 0.1, "{expected} for {found}");
            assert!(told["images"].as_u64().unwrap() > 1000, "{told}");
            assert_eq!(told["list_bytes"].as_f64().unwrap(), 20.0 * expected);
        }
        assert_eq!(told("auto")["engine"], bench.json("s.json")["engine"]);
    }
    // Few elements are counted, and those of one body do not count.
    bench.write("ends.csv", "x,y,radius,body\n0.25,2,0.5,1\n3.5,2,0.5,1\n0.25,3,0.5,2\n");
    let options = ["contacts", "ends.csv", "--explain", "--periodic", "x", "--box", "0,4,0,4"];
    assert!(bench.run(&options).succeeds().stdout.contains("couples   2\n"));
    let run = bench.run(&[&options[..], &["--bodies", "body"]].concat()).succeeds();
    assert!(run.stdout.contains("couples   1\n"), "{}", run.stdout);
    bench.write("far.csv", "id,x,y,r\n7,1e12,0,0.1\n8,0,0,0.1\n");
    bench
        .run(&["contacts", "far.csv", "--explain", "--periodic", "x", "--box", "0,1,0,1"])
        .refused_with(&["far.csv", "id 7"]);
}

/// The corners of a box that repeats are one place: a file that lists two of them lists an element and its
/// image.
#[test]
fn images_in_the_file_are_noted() {
    let bench = Bench::new();
    bench.write("twice.csv", "id,x,y\n7,0,1\n8,4,1\n9,2,2\n");
    let options = ["contacts", "twice.csv", "--cutoff", "0.5", "--periodic", "xy", "--box", "0,4,0,4"];
    for more in [&["--json", "s.json"][..], &["--count", "--quiet"]] {
        let run = bench.run(&[&options[..], more].concat()).succeeds();
        let note = "elements 7 and 8 have the same place in the periodic box, [-1, 0] edges apart. If";
        assert!(run.stderr.contains(note), "{}", run.stderr);
    }
    assert_eq!(bench.json("s.json")["repeated_images"], 1);
    bench.write("once.csv", "id,x,y\n7,0.125,1\n8,3.875,1\n9,2,2\n");
    let run = bench.run(&[&["contacts", "once.csv"], &options[2..]].concat()).succeeds();
    assert!(!run.stderr.contains("same place"), "{}", run.stderr);
}

/// A cube of atoms, and the same lattice by edges with a tilt of 1,000: the same couples at the same
/// distances.
#[test]
fn a_skewed_cell_gives_the_couples_of_its_lattice() {
    let bench = Bench::new();
    let mut atoms = String::new();
    for k in 0_u32..64 {
        let x = |axis: u32| f64::from((k * 37 + 11) * (axis + 3) * (axis + 5) % 96) / 16.0;
        writeln!(atoms, "C {} {} {}", x(0), x(1), x(2)).unwrap();
    }
    let file = |edges: &str| format!("64\nLattice=\"{edges}\" Properties=species:S:1:pos:R:3\n{atoms}");
    bench.write("cube.xyz", file("6 0 0 0 6 0 0 0 6"));
    bench.write("skewed.xyz", file("6 0 0 6000 6 0 3000 6000 6"));
    let distances = |name: &str| {
        let run = bench.run(&["contacts", name, "--cutoff", "1.5", "--verify", "64"]).succeeds();
        let of = |row: &str| row.split(',').take(3).collect::<Vec<_>>().join(",");
        let mut rows: Vec<String> = run.stdout.lines().skip(1).map(of).collect();
        rows.sort();
        rows
    };
    let expected = distances("cube.xyz");
    assert!(expected.len() > 50, "{}", expected.len());
    assert_eq!(distances("skewed.xyz"), expected);
}
