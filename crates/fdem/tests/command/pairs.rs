//! Cut-offs by pairs of types.

use serde_json::json;

use crate::Bench;

/// Two C at a distance of 1.5, with H at distances of 1.25, 1 and 1.3125 from one of them, and an H that is
/// 0.25 from another H and farther than 1.25 from both C. Only the second H is below y = 0.
const ATOMS: [(&str, [f64; 2]); 6] = [
    ("C", [0.0, 0.0]),
    ("H", [1.25, 0.0]),
    ("H", [0.0, -1.0]),
    ("C", [0.0, 1.5]),
    ("H", [0.0, 2.8125]),
    ("H", [1.25, 0.25]),
];

/// The couples of [`ATOMS`] with H-C=1.25,C-C=1.5: two of them are as far apart as they may be.
const COUPLES: [&str; 3] = ["0,1,1.25,0.0", "0,2,1.0,0.25", "0,3,1.5,0.0"];

const PAIRS: [&str; 2] = ["--cutoff", "H-C=1.25,C-C=1.5"];

/// Rows of [`ATOMS`], each by a function of its number, type and place.
fn rows(row: impl Fn(usize, &str, [f64; 2]) -> String) -> String {
    ATOMS.iter().enumerate().map(|(k, (name, place))| row(k, name, *place) + "\n").collect()
}

fn xyz() -> String {
    let comment = "Properties=species:S:1:pos:R:3 pbc=\"F F F\"";
    format!("6\n{comment}\n{}", rows(|_, name, [x, y]| format!("{name} {x} {y} 0")))
}

fn with<'a>(file: &'a str, options: &[&'a str]) -> Vec<&'a str> {
    [&["contacts", file][..], options].concat()
}

#[test]
fn each_pair_of_types_has_its_cutoff() {
    let bench = Bench::new();
    bench.write("atoms.xyz", xyz());
    let run = bench.run(&[&with("atoms.xyz", &PAIRS)[..], &["--json", "s.json", "--verify", "6"]].concat());
    let run = run.succeeds();
    assert_eq!(run.rows(), COUPLES);
    for part in
        ["6 points in 3D", "cut-off          H-C=1.25, C-C=1.5\n", "without contact  2", "verified         6"]
    {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    let summary = bench.json("s.json");
    assert_eq!(summary["cutoffs"][0], json!({ "types": ["H", "C"], "cutoff": 1.25 }));
    assert_eq!(summary["couples"], 3);
    assert_eq!(summary["max_overlap_couple"], json!([0, 2]));
    for engine in ["direct", "nbs", "rows", "multilevel", "cgrid"] {
        let run = bench.run(&[&with("atoms.xyz", &PAIRS)[..], &["--engine", engine]].concat());
        assert_eq!(run.succeeds().rows(), COUPLES, "{engine}");
    }
    // The tolerance is added to each cut-off. The last H is 0.0247 too far from the first C.
    let run = bench.run(&[&with("atoms.xyz", &PAIRS)[..], &["--tolerance", "0.0625", "--count"]].concat());
    assert_eq!(run.succeeds().stdout, "5\n");
    let run = bench.run(&with("atoms.xyz", &["--cutoff", "C-C=1.4375", "--count"]));
    assert_eq!(run.succeeds().stdout, "0\n");
    let run = bench.run(&with("atoms.xyz", &["--cutoff", "H-H=0.25"]));
    assert_eq!(run.succeeds().rows(), ["1,5,0.25,0.0"]);
}

#[test]
fn types_are_read_from_files_of_every_format() {
    let bench = Bench::new();
    let numbered = |name: &str| if name == "H" { 1 } else { 2 };
    bench.write("plain.xyz", format!("6\n\n{}", rows(|_, name, [x, y]| format!("{name} {x} {y} 0"))));
    let head = "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n6\nITEM: BOX BOUNDS ff ff ff\n-2 9\n-2 9\n-2 9\n";
    let dumped = rows(|k, name, [x, y]| format!("{k} {} {name} {x} {y} 0", numbered(name)));
    bench.write("named.dump", format!("{head}ITEM: ATOMS id type element x y z\n{dumped}"));
    let dumped = rows(|k, name, [x, y]| format!("{k} {} {x} {y} 0", numbered(name)));
    bench.write("numbered.dump", format!("{head}ITEM: ATOMS id type x y z\n{dumped}"));
    let head =
        "atoms\n\n6 atoms\n2 atom types\n\n-2 9 xlo xhi\n-2 9 ylo yhi\n-2 9 zlo zhi\n\nAtoms # atomic\n\n";
    bench.write("atoms.data", format!("{head}{dumped}"));
    bench.write(
        "named.csv",
        format!("x,Species,y\n{}", rows(|_, name, [x, y]| format!("{x},\"{name}\",{y}"))),
    );
    bench.write("bare.txt", rows(|_, name, [x, y]| format!("{x} {name} {y}")));
    bench.write("kinds.csv", format!("x,y,kind\n{}", rows(|_, name, [x, y]| format!("{x},{y},{name}"))));

    let numbers = ["--cutoff", "1-2=1.25,2-2=1.5"];
    for (file, options) in [
        ("plain.xyz", &PAIRS[..]),
        ("named.dump", &PAIRS),
        ("numbered.dump", &numbers),
        ("named.dump", &[&numbers[..], &["--type-column", "type"]].concat()),
        ("atoms.data", &numbers),
        ("named.csv", &PAIRS),
        ("bare.txt", &[&PAIRS[..], &["--type-column", "2"]].concat()),
        ("kinds.csv", &[&PAIRS[..], &["--type-column", "kind"]].concat()),
        ("kinds.csv", &[&PAIRS[..], &["--type-column", "kind", "--columns", "x=1,y=2"]].concat()),
    ] {
        assert_eq!(bench.run(&with(file, options)).succeeds().rows(), COUPLES, "{file} {options:?}");
    }
}

/// A C and an H at the ends of a box of 4, 0.75 apart across its face, and the H at 0.75 from its own image
/// along y.
#[test]
fn pairs_are_found_across_the_faces_of_a_box() {
    let bench = Bench::new();
    let frame = |x: f64| {
        format!(
            "2\nLattice=\"4 0 0 0 0.75 0 0 0 9\" Properties=element:S:1:pos:R:3\nC 0.25 0.25 1\nH {x} 0.25 1\n"
        )
    };
    bench.write("box.xyz", frame(3.5) + &frame(3.25));
    let of_first = ["--frames", "0", "--verify", "2"];
    let run = bench.run(&[&with("box.xyz", &["--cutoff", "H-H=0.75,C-H=0.75"])[..], &of_first].concat());
    let head = "i,j,distance,overlap,sx,sy,sz\n0,1,0.75,0.0,-1,0,0\n";
    assert_eq!(run.succeeds().stdout, format!("{head}1,1,0.75,0.0,0,1,0\n"));
    let run = bench.run(&[&with("box.xyz", &["--cutoff", "H-H=0.875,C-H=0.75"])[..], &of_first].concat());
    assert_eq!(run.succeeds().stdout, format!("{head}1,1,0.75,0.125,0,1,0\n"));

    // The cut-off of a series is that of each frame.
    let run = bench.run(&with("box.xyz", &["--cutoff", "C-H=0.75", "--count"])).succeeds();
    assert_eq!(
        run.stdout.lines().map(|line| line.rsplit([' ', ',']).next().unwrap()).collect::<Vec<_>>(),
        ["1", "0"]
    );
    let run = bench.run(&with("box.xyz", &["--cutoff", "C-H=0.75"])).succeeds();
    assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
}

#[test]
fn outputs_and_the_analysis_have_the_cutoff_of_each_pair() {
    let bench = Bench::new();
    bench.write("atoms.xyz", xyz());
    let outputs = ["--analyse", "--json", "s.json", "--picture", "p.svg", "--report", "r.html"];
    for output in ["c.csv", "c.npz", "c.vtp", "c.graphml", "c.json", "c.parquet"] {
        bench.run(&[&with("atoms.xyz", &PAIRS)[..], &outputs, &["--output", output]].concat()).succeeds();
        assert_eq!(bench.json("s.json")["couples"], 3, "{output}");
    }
    let summary = bench.json("s.json");
    assert_eq!(
        summary["analysis"]["overlaps"]["overlaps"]["max"], 0.25,
        "{}",
        summary["analysis"]["overlaps"]
    );
    assert_eq!(bench.read("c.csv"), format!("i,j,distance,overlap\n{}\n", COUPLES.join("\n")));
    assert!(!bench.read("c.graphml").contains("radius"), "points have no radius");
}

#[test]
fn elements_of_one_body_form_no_couple_of_any_types() {
    let bench = Bench::new();
    let rows = rows(|k, name, [x, y]| format!("{x},{y},{name},{}", if k < 2 { 7 } else { k }));
    bench.write("atoms.csv", format!("x,y,type,body\n{rows}"));
    let run = bench.run(&[&with("atoms.csv", &PAIRS)[..], &["--bodies", "body", "--verify", "6"]].concat());
    assert_eq!(run.succeeds().rows(), COUPLES[1..]);
}

#[test]
fn types_that_cannot_be_used_are_refused() {
    let bench = Bench::new();
    bench.write("atoms.xyz", xyz());
    bench.write("points.csv", "x,y,mass\n0,0,1\n1,0,1\n");
    bench.write("gap.csv", "x,y,type\n0,0,H\n1,0,\n");
    let refused = |file: &str, options: &[&str], parts: &[&str]| {
        bench.run(&with(file, options)).refused_with(parts);
    };
    refused(
        "atoms.xyz",
        &["--cutoff", "H-O=1,C-C=1"],
        &["atoms.xyz: --cutoff H-O=1: no element has the type O", "column species are C, H"],
    );
    refused("atoms.xyz", &["--cutoff", "H-C=1,C-H=2"], &["H-C=1 and C-H=2 are of the same pair"]);
    refused("atoms.xyz", &["--cutoff", "H-C"], &["'H-C' is not a number"]);
    refused(
        "points.csv",
        &["--cutoff", "H-C=1"],
        &["points.csv:1: no column element, species, type", "the columns are x, y, mass", "--type-column"],
    );
    refused("points.csv", &["--cutoff", "H-C=1", "--type-column", "kind"], &["kind", "x, y, mass"]);
    refused("points.csv", &["--cutoff", "1-1=1", "--type-column", "y"], &["column y", "is the y"]);
    refused("points.csv", &["--cutoff", "1", "--type-column", "mass"], &["--type-column is for"]);
    refused("gap.csv", &["--cutoff", "H-H=1"], &["gap.csv:3: column type is empty"]);
    refused("atoms.xyz", &["--cutoff", "H-C=1", "--explain"], &["--explain", "--cutoff D"]);
    let bench_run = bench.run(&["bench", "atoms.xyz", "--cutoff", "H-C=1"]);
    bench_run.refused_with(&["--cutoff by pairs of types is for fdem contacts"]);
}
