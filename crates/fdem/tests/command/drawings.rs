//! Pictures, plots and reports: that they are there, whole, and the same at every run. What they look like is looked at.

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

#[test]
fn drawings_are_the_same_at_every_run_and_for_any_number_of_threads() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "3000", "--sizes", "power:1:20:-3", "-o", "gas.csv"]).succeeds();
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

/// None, one, points, all in one place, a box, unlike sizes, far away: nothing that is no number gets into a drawing.
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
        .refused_with(&["--plots a.svg is --picture too"]);
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
    assert_eq!(svg.matches("<path").count(), number("body_contacts"));
    assert!(svg.contains("squares.msh"));
    bench.run(&["contacts", squares, "--count", "--picture", "m.png", "--picture-width", "400"]).succeeds();
    assert_eq!(png_size(&std::fs::read(bench.path("m.png")).unwrap())[0], 400);
}
