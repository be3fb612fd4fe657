//! Pictures, plots and reports: that they are there, whole, and the same at every run. Their appearance is
//! checked by eye.

use crate::Bench;

/// Three discs in a row.
const ROW: &str = "id,x,y,radius\n7,0,0,1\n8,1.5,0,1\n9,3,0,1\n";

/// Size of a PNG file in pixels, from its header.
fn png_size(bytes: &[u8]) -> [u32; 2] {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    assert_eq!(&bytes[bytes.len() - 8..bytes.len() - 4], b"IEND");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn a_picture_shows_every_element_and_couple() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    bench.run(&["contacts", "row.csv", "--count", "--picture", "row.svg"]).succeeds();
    let svg = bench.read("row.svg");
    assert_eq!(svg.matches("<circle").count(), 3);
    assert_eq!(svg.matches("<path").count(), 2);
    for text in ["row.csv", "3 discs, 2 contacts, 1.3333 per element", "overlap", "<title>", "<desc>"] {
        assert!(svg.contains(text), "{text} is not in\n{svg}");
    }
}

/// The terminal was flooded with the couples; the summary did not list the written files.
#[test]
fn drawings_alone_print_the_summary_only() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    let run = bench
        .run(&["contacts", "row.csv", "--picture", "p.svg", "--report", "r.html", "--json", "s.json"])
        .succeeds();
    assert_eq!(run.stdout, "");
    let files = "written          p.svg\n                 r.html\n                 s.json\n";
    assert!(run.stderr.ends_with(files), "{}", run.stderr);
    assert!(!bench.read("r.html").contains("p.svg"), "a report tells of the packing");
    let run = bench.run(&["contacts", "row.csv", "--picture", "p.svg", "-o", "-"]).succeeds();
    assert_eq!(run.rows().len(), 2);
    let run = bench.run(&["contacts", "row.csv", "--plots", "d.svg", "-o", "c.csv"]).succeeds();
    assert!(run.stderr.ends_with("written          c.csv\n                 d.svg\n"), "{}", run.stderr);
    assert_eq!(bench.read("c.csv").lines().count(), 3);
    let run = bench.run(&["contacts", "row.csv"]).succeeds();
    assert!(run.rows().len() == 2 && !run.stderr.contains("written"), "{}", run.stderr);
}

/// One sphere that 20,000 others touch: each contact was drawn in the time of its box, which no picture of
/// such a packing was ready in.
#[test]
fn an_element_with_many_contacts_is_drawn() {
    let bench = Bench::new();
    let (count, golden) = (20_000, std::f64::consts::PI * (3.0 - 5_f64.sqrt()));
    let small = (0..count).map(|k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let (r, a) = ((1.0 - z * z).sqrt(), golden * f64::from(k));
        format!("{},{},{},0.002\n", r * a.cos(), r * a.sin(), z)
    });
    bench.write("hub.csv", format!("x,y,z,radius\n0,0,0,0.999\n{}", small.collect::<String>()));
    let files = ["--picture", "p.png", "--report", "r.html", "--plots", "d.svg", "--json", "s.json"];
    bench.run(&[&["contacts", "hub.csv"], &files[..]].concat()).succeeds();
    assert!(bench.json("s.json")["couples"].as_u64().unwrap() >= 20_000);
    png_size(&std::fs::read(bench.path("p.png")).unwrap());
}

/// Wherever memory ends, while the couples are found or while they are drawn: a drawing or an error. It was
/// an abort with exit code 134.
#[cfg(target_os = "linux")]
#[test]
fn any_limit_of_memory_ends_in_a_drawing_or_an_error() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "15000", "-o", "gas.npy"]).succeeds();
    let fdem = assert_cmd::cargo::cargo_bin!("fdem").display().to_string();
    let least = crate::least_memory();
    let small = "--picture p.png --picture-width 400";
    // The last one is slow in tests, so it has fewer limits.
    for (drawing, step) in
        [(small, 15_000), ("--plots p.png", 25_000), ("--report p.html", 25_000), ("--picture p.svg", 75_000)]
    {
        let mut ends = [0, 0];
        let step = if crate::thorough() { step } else { 6 * step };
        let mut kilobytes = least;
        // Machines differ in how much they need: more and more, until there is enough.
        while ends[0] < 2 {
            assert!(kilobytes < least + 4_000_000, "{drawing} takes more than 4 GB");
            let line = format!(
                "ulimit -v {kilobytes} && RUST_BACKTRACE=0 exec {fdem} contacts gas.npy -q {drawing}"
            );
            let run = std::process::Command::new("sh")
                .args(["-c", &line])
                .current_dir(bench.folder.path())
                .output()
                .unwrap();
            let message = String::from_utf8_lossy(&run.stderr).into_owned();
            match run.status.code() {
                Some(0) => ends[0] += 1,
                Some(2) => {
                    assert!(message.contains("memory"), "{drawing}, {kilobytes}: {message}");
                    ends[1] += 1;
                }
                code => panic!("{drawing}, {kilobytes} kB: {code:?}, {message}"),
            }
            kilobytes += step;
        }
        assert!(ends[1] > 0, "{drawing} has never too little memory");
    }
}

#[test]
fn drawings_are_the_same_at_every_run_and_for_any_number_of_threads() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "1000", "--sizes", "power:1:20:-3", "-o", "gas.csv"]).succeeds();
    for file in ["p.png", "p.svg", "d.png", "d.svg", "r.html"] {
        let option = match file.split('.').next().unwrap() {
            "p" => "--picture",
            "d" => "--plots",
            _ => "--report",
        };
        let drawn = |threads: &str| {
            bench.run(&["contacts", "gas.csv", "--count", "--threads", threads, option, file]).succeeds();
            std::fs::read(bench.path(file)).unwrap()
        };
        let first = drawn("1");
        assert!(first.len() > 10_000, "{file}");
        assert!(first == drawn("3"), "{file}");
    }
    let png = std::fs::read(bench.path("p.png")).unwrap();
    let [width, height] = png_size(&png);
    assert!((1000..4000).contains(&width) && (200..4000).contains(&height), "{width} x {height}");
    bench
        .run(&[
            "contacts",
            "gas.csv",
            "--count",
            "--picture",
            "p.png",
            "--plots",
            "d.png",
            "--picture-width",
            "801",
        ])
        .succeeds();
    for file in ["p.png", "d.png"] {
        assert_eq!(png_size(&std::fs::read(bench.path(file)).unwrap())[0], 801);
    }
    let narrow = bench.run(&["contacts", "gas.csv", "--picture", "p.png", "--picture-width", "199"]);
    narrow.refused_with(&["--picture-width", "200..=10000"]);
}

/// None, one, points, all in one place, a box, unlike sizes, far away: nothing that is no number gets into a
/// drawing.
#[test]
fn extremes_are_drawn() {
    let bench = Bench::new();
    let cases: [(&str, &[&str]); 7] = [
        ("x,y,r\n", &[]),
        ("x,y,z,r\n", &[]),
        ("x,y,r\n5,5,1\n", &[]),
        ("x,y,z,r\n5,5,5,0\n5,5,5,0\n", &[]),
        ("x,y,z\n0,0,0\n1,0,0\n", &["--cutoff", "1"]),
        ("x,y,z,r\n0.1,0.1,0.1,0.2\n0.9,0.9,0.9,0.2\n", &["--periodic", "xyz", "--box", "0,1,0,1,0,1"]),
        ("x,y,z,r\n0,0,0,1\n1e6,0,0,1e6\n0,1e-6,0,1e-9\n", &[]),
    ];
    for (rows, options) in cases {
        bench.write("in.csv", rows);
        let files = ["--picture", "p.svg", "--plots", "d.svg", "--report", "r.html", "--count"];
        bench.run(&[&["contacts", "in.csv"], &files[..], options].concat()).succeeds();
        for file in ["p.svg", "d.svg"] {
            // An image within may spell anything.
            let svg: String = bench.read(file).lines().filter(|line| !line.contains(";base64,")).collect();
            assert!(!svg.contains("NaN") && !svg.contains("inf\""), "{rows}{file}");
        }
        bench
            .run(
                &[&["contacts", "in.csv", "--picture", "p.png", "--plots", "d.png", "--count"], options]
                    .concat(),
            )
            .succeeds();
        png_size(&std::fs::read(bench.path("p.png")).unwrap());
        png_size(&std::fs::read(bench.path("d.png")).unwrap());
    }
}

/// The report has ids and names as text, also those that look like markup.
#[test]
fn a_report_holds_names_as_text() {
    let bench = Bench::new();
    let name = "<img src=x onerror=alert(1)>.csv";
    bench.write(name, ROW);
    bench.run(&["contacts", name, "--count", "--report", "r.html", "--picture", "p.svg"]).succeeds();
    for file in ["r.html", "p.svg"] {
        let text = bench.read(file);
        assert!(!text.contains("<img src=x"), "{file}");
        assert!(text.contains("&lt;img src=x onerror=alert(1)&gt;.csv"), "{file}");
    }
    let report = bench.read("r.html");
    assert!(report.contains("<td>3 discs in 2D, radius 1</td>"));
    assert!(!report.contains("peak memory") && !report.contains(">time<"), "these differ from run to run");
}

/// With a wrong name nothing is written at all.
#[test]
fn drawings_are_refused_whole() {
    let bench = Bench::new();
    bench.write("row.csv", ROW);
    bench
        .run(&["contacts", "row.csv", "--picture", "a.png", "--report", "nowhere/r.html"])
        .refused_with(&["nowhere/r.html"]);
    bench
        .run(&["contacts", "row.csv", "--picture", "a.svg", "--plots", "a.svg"])
        .refused_with(&["--plots a.svg is the same file as --picture"]);
    assert_eq!(bench.files(), ["row.csv"]);
}

#[test]
fn meshes_in_a_plane_are_drawn() {
    let bench = Bench::new();
    let squares = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/squares.msh");
    let run =
        bench.run(&["contacts", squares, "--count", "--picture", "m.svg", "--json", "m.json"]).succeeds();
    let (svg, json) = (bench.read("m.svg"), bench.read("m.json"));
    let number = |key: &str| -> usize {
        let rest = json.split(&format!("\"{key}\": ")).nth(1).unwrap();
        rest.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse().unwrap()
    };
    assert_eq!(svg.matches("<polygon").count(), number("elements"), "{}", run.stderr);
    let outlines = svg.matches("<path class=\"bodies\"").count();
    assert_eq!(outlines, 1, "one path has the outlines of all bodies");
    assert_eq!(svg.matches("<path").count() - outlines, number("body_contacts"));
    assert!(svg.contains("squares.msh"));
    bench.run(&["contacts", squares, "--count", "--picture", "m.png", "--picture-width", "400"]).succeeds();
    assert_eq!(png_size(&std::fs::read(bench.path("m.png")).unwrap())[0], 400);
}
