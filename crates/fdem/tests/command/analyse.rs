//! `--analyse`: the summary, and refused options. The numbers are compared in `tests/suite/analysis.rs` and
//! `tests/python/test_analysis.py`.

use crate::{Bench, foreign_data};

/// A cube of 4 x 4 x 4 touching spheres.
fn cube() -> String {
    let row = |k: u32| format!("{}.5,{}.5,{}.5,0.5", k % 4, k / 4 % 4, k / 16);
    let rows: Vec<_> = (0..64).map(row).collect();
    format!("x,y,z,radius\n{}\n", rows.join("\n"))
}

#[test]
fn a_lattice_is_told() {
    let bench = Bench::new();
    bench.write("cube.csv", cube());
    let options = ["--analyse", "--json", "cube.json", "--count"];
    let run = bench.run(&[&["contacts", "cube.csv"], &options[..]].concat()).succeeds();
    assert_eq!(run.stdout, "144\n");
    for line in [
        "contacts each    3: 8, 4: 24, 5: 24, 6: 8\n",
        "rattlers         0 of 64 (removed repeatedly: fewer than 2 contacts each); 64 remain with 4.5000 contacts each\n",
        "                 as with friction; 0 would remain without friction (--rattlers 4)\n",
        "fabric           eigenvalues 0.3333, 0.3333, 0.3333, most contacts along ",
        "clusters         1, the largest of 64 elements; percolates from face to face along x, y, z\n",
        "overlaps         144, 0 to 0, mean 0, 0 of the mean radius\n",
        "packing fraction 0.52360 in [1, 3] x [1, 3] x [1, 3]; at least 0.52360 without counting overlaps twice\n",
        "g(r)             up to 0.75, largest 0.000 at 0\n",
        ", analyse 0.",
    ] {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
    let json = bench.json("cube.json");
    let analysis = &json["analysis"];
    assert_eq!(analysis["coordination"]["distribution"][5], 24);
    assert_eq!(analysis["without_rattlers"]["elements"], 64);
    assert_eq!(analysis["without_rattlers"]["frictionless"]["elements"], 0);
    assert_eq!(analysis["clusters"]["percolation"][2]["percolates"], true);
    assert_eq!(analysis["radial"]["counts"].as_array().unwrap().len(), 150);
    assert!(json["seconds"]["analyse"].as_f64().is_some());

    let around = ["--periodic", "xyz", "--box", "0,4,0,4,0,4", "--rattlers", "2", "--rdf", "1.2,24"];
    let run = bench.run(&[&["contacts", "cube.csv"], &options[..], &around].concat()).succeeds();
    for line in [
        "contacts each    6: 64\n",
        "rattlers         0 of 64 (removed repeatedly: fewer than 2 contacts each); 64 remain with 6.0000 contacts each\n",
        "percolates around the box along x, y, z\n",
        "packing fraction 0.52360 in [0, 4] x [0, 4] x [0, 4]",
        "g(r)             up to 1.2, largest ",
    ] {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
    let inner = ["--inner", "0,1,0,4,0.5,1"];
    let run = bench.run(&[&["contacts", "cube.csv"], &options[..], &inner].concat()).succeeds();
    assert!(run.stderr.contains("packing fraction 0.52360 in [0, 1] x [0, 4] x [0.5, 1]"), "{}", run.stderr);

    let plain = bench.run(&["contacts", "cube.csv", "--json", "plain.json", "--count"]).succeeds();
    assert!(!plain.stderr.contains("rattlers") && bench.json("plain.json").get("analysis").is_none());
}

/// Threads change nothing.
#[test]
fn the_analysis_is_the_same_for_any_number_of_threads() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "5000", "--seed", "3", "--output", "gas.csv"]).succeeds();
    let mut found = Vec::new();
    for threads in ["1", "2", "3"] {
        bench
            .run(&[
                "contacts",
                "gas.csv",
                "--analyse",
                "--threads",
                threads,
                "--json",
                "gas.json",
                "-o",
                "gas.vtp",
            ])
            .succeeds();
        found.push((
            bench.json("gas.json")["analysis"].clone(),
            std::fs::read(bench.path("gas.vtp")).unwrap(),
        ));
    }
    assert!(found[0] == found[1] && found[0] == found[2]);
}

#[test]
fn what_cannot_be_analysed_is_refused() {
    let bench = Bench::new();
    bench.write("cube.csv", cube());
    bench.write("ball.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n");
    let refused = |file: &str, options: &[&str], parts: &[&str]| {
        bench.run(&[&["contacts", file, "-o", "out.csv"], options].concat()).refused_with(parts);
        assert!(!bench.files().iter().any(|file| file.starts_with("out") || file.starts_with(".fdem")));
    };
    refused("cube.csv", &["--inner", "0,1,0,1,0,1"], &["--analyse"]);
    refused("cube.csv", &["--rdf", "1"], &["--analyse"]);
    refused("cube.csv", &["--analyse", "--inner", "0,1,0,1"], &["--inner", "needs 6 numbers", "not 4"]);
    refused(
        "cube.csv",
        &["--analyse", "--inner", "0,1,0,1,1,0"],
        &["--inner", "empty along axis 2: from 1 to 0"],
    );
    refused("cube.csv", &["--analyse", "--rdf", "1,2,3"], &["--rdf", "not 3 numbers"]);
    refused("cube.csv", &["--analyse", "--rdf", "1,2.5"], &["--rdf", "2.5 is not a number of bins"]);
    refused("cube.csv", &["--analyse", "--rdf", "1,0"], &["--rdf", "0 bins"]);
    refused("cube.csv", &["--analyse", "--rdf", "1,1e300"], &["--rdf", "bins are not between"]);
    refused("cube.csv", &["--analyse", "--rdf", "-1"], &["--rdf", "-1 is not above 0"]);
    refused("cube.csv", &["--analyse", "--rdf", "7"], &["--rdf", "no centre is 7 away"]);
    refused("ball.stl", &["--analyse"], &["ball.stl", "--analyse is for one packing"]);
    let sheared = ["--periodic", "xyz", "--edges", "4,0,0,1,4,0,0,0,4", "--inner", "0,1,0,1,0,1"];
    refused("cube.csv", &[&["--analyse"], &sheared[..]].concat(), &["--inner", "sheared box"]);
}

/// 25,000 equal spheres of the DEM round robin.
#[test]
fn the_bed_is_analysed() {
    let Some(bed) = foreign_data("roundrobin/penetration/25KParticles.txt") else { return };
    let bench = Bench::new();
    let bed = bed.to_str().unwrap();
    bench
        .run(&["contacts", bed, "--skip-bad-lines", "--analyse", "--json", "bed.json", "--count"])
        .succeeds();
    let analysis = &bench.json("bed.json")["analysis"];
    let counts = analysis["coordination"]["distribution"].as_array().unwrap();
    let sum: u64 = counts.iter().enumerate().map(|(k, count)| k as u64 * count.as_u64().unwrap()).sum();
    assert_eq!(sum, 2 * 53_876);
    let fraction = analysis["packing"]["fraction"].as_f64().unwrap();
    assert!((0.5..0.64).contains(&fraction), "a poured bed is not {fraction}");
    assert!(analysis["clusters"]["percolation"][2]["percolates"].as_bool().unwrap());
}
