//! Packings that this project did not make. Skipped, with a message on standard error, where the data is not
//! there.

use crate::{Bench, foreign_data};

/// 25,000 equal spheres of the DEM round robin (Dosta et al., Comput. Phys. Commun. 296 (2024) 109066).
#[test]
fn bed_of_25_000_spheres() {
    let Some(bed) = foreign_data("roundrobin/penetration/25KParticles.txt") else { return };
    let bed = bed.to_str().unwrap();
    let bench = Bench::new();
    bench
        .run(&["contacts", bed, "-o", "out.csv"])
        .refused_with(&["25KParticles.txt:25002:", "5 0.01 0.01 0 0 0.06"]);
    assert!(bench.files().is_empty());

    for engine in ["nbs", "direct", "rows"] {
        let (couples, summary) = (format!("{engine}.csv"), format!("{engine}.json"));
        let options =
            ["--skip-bad-lines", "--engine", engine, "-o", &couples, "--json", &summary, "--verify", "25"];
        let run = bench.run(&[&["contacts", bed], &options[..]].concat()).succeeds();
        assert!(run.stderr.contains("25KParticles.txt:25002:"), "{}", run.stderr);
        let summary = bench.json(&summary);
        assert_eq!(summary["elements"], 25_000);
        assert_eq!(summary["skipped_lines"], 1);
        assert_eq!(summary["couples"], 53_876);
        assert_eq!(format!("{:.4}", summary["mean_coordination"].as_f64().unwrap()), "4.3101");
        assert_eq!(format!("{:.4e}", summary["max_overlap"].as_f64().unwrap()), "9.0117e-7");
        assert_eq!(summary["engine"], engine);
    }
    assert_eq!(bench.read("nbs.csv").lines().count(), 53_877);
    assert!(bench.read("nbs.csv") == bench.read("direct.csv"), "all engines write identical files");
    assert!(bench.read("rows.csv") == bench.read("direct.csv"), "all engines write identical files");
}

/// 38,000 spheres of two sizes at rest in a drum, same source.
#[test]
fn drum_with_two_sizes() {
    let Some(drum) = foreign_data("roundrobin/drum/PartCoordinates.txt") else { return };
    let bench = Bench::new();
    let mut couples = Vec::new();
    for engine in ["nbs", "direct", "rows"] {
        let run =
            bench.run(&["contacts", drum.to_str().unwrap(), "--engine", engine, "--verify", "50"]).succeeds();
        assert!(run.stderr.contains("38,000 spheres in 3D, radius 0.001 to 0.002 m"), "{}", run.stderr);
        couples.push(run.stdout);
    }
    assert!(couples[0] == couples[1] && couples[0] == couples[2], "all engines write identical couples");
    assert!(couples[0].lines().count() > 38_000);
}

/// The bed of 25,000 spheres as two frames of a dump.
#[test]
fn bed_as_a_series() {
    let Some(bed) = foreign_data("roundrobin/penetration/25KParticles.txt") else { return };
    let text = std::fs::read_to_string(bed).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).filter(|line| line.split_whitespace().count() == 4).collect();
    let frame = |step: usize| {
        let bounds = "ITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n";
        let columns = "ITEM: ATOMS radius x y z";
        format!(
            "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{}\n{bounds}{columns}\n{}\n",
            rows.len(),
            rows.join("\n")
        )
    };
    let bench = Bench::new();
    bench.write("bed.dump", [frame(10), frame(20)].concat());
    let run = bench.run(&["contacts", "bed.dump", "--count", "--json", "all.json"]).succeeds();
    assert_eq!(run.stdout, "53876\n53876\n");
    assert!(run.stderr.contains("50,000 elements, 107,752 couples"), "{}", run.stderr);
    assert_eq!(bench.json("all.json")[1]["step"], 20);
}
