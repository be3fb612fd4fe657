//! Contacts of bodies in labelled images: `--labels`.

use std::fmt::Write;

use fdem_contact::image::{Neighbourhood, Spacing, contacts};

use crate::Bench;

/// A NumPy file in C order.
fn npy(descr: &str, shape: &str, data: impl IntoIterator<Item = u8>) -> Vec<u8> {
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

/// Two bodies side by side, a third at a corner, a fourth alone.
const PIXELS: [u8; 20] = [
    1, 1, 2, 2, 0, //
    1, 1, 2, 2, 0, //
    0, 0, 0, 0, 3, //
    4, 0, 0, 0, 0,
];

/// Bodies are where the means of their grid squares are, x along the last axis, and of their size.
#[test]
fn bodies_of_an_image_are_drawn() {
    let bench = Bench::new();
    bench.write("in.npy", npy("|u1", "(4, 5)", PIXELS));
    let outputs = ["--picture", "p.svg", "--plots", "d.png", "--report", "r.html", "-o", "o.vtp"];
    let options = ["--labels", "--spacing", "2,1"];
    let run = bench.run(&[&["contacts", "in.npy"], &options[..], &outputs].concat()).succeeds();
    assert!(run.stderr.contains("written          o.vtp\n                 p.svg\n"), "{}", run.stderr);
    assert!(bench.read("p.svg").contains("4 bodies, 1 contact, 0.5000 per body, 2 without"));
    assert!(bench.read("r.html").contains("shared length"));
    let bytes = std::fs::read(bench.path("o.vtp")).unwrap();
    let network = fdem::io::read_mesh(&bytes, "o.vtp").unwrap();
    assert_eq!(network.points, [[1.0, 0.5, 0.0], [5.0, 0.5, 0.0], [8.0, 2.0, 0.0], [0.0, 3.0, 0.0]]);
    assert_eq!(network.segments.nodes, [[0, 1]]);
    // In space too.
    bench.write("solid.npy", npy("|u1", "(2, 2, 5)", PIXELS));
    bench.run(&["contacts", "solid.npy", "--labels", "--report", "r.html", "--picture", "p.png"]).succeeds();
    assert!(bench.read("r.html").contains("shared area"));
}

#[test]
fn contacts_in_2d() {
    let bench = Bench::new();
    bench.write("in.npy", npy("|u1", "(4, 5)", PIXELS));
    let run = bench.run(&["contacts", "in.npy", "--labels", "--json", "s.json"]).succeeds();
    assert_eq!(run.stdout, "i,j,faces,length,x,y,nx,ny\n1,2,2,2.0,1.5,0.5,1.0,0.0\n");
    for line in [
        "image            5 x 4 pixels (x, y) of 1 x 1",
        "bodies           4, background 0",
        "contacts         1\n",
        "coordination     0.5000 contacts per body",
        "without contact  2\n",
        "shared faces     2, length 2\n",
    ] {
        assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
    }
    let json = bench.json("s.json");
    assert_eq!((&json["bodies"], &json["contacts"], &json["faces"]), (&4.into(), &1.into(), &2.into()));
    assert_eq!(json["shape"], serde_json::json!([5, 4]));
    assert!(json.get("vertices").is_none(), "nobody asked for vertices");

    let options =
        ["contacts", "in.npy", "--labels", "--neighbourhood", "vertex", "--spacing", "3,4", "--threads", "2"];
    let run = bench.run(&options).succeeds();
    let start = "i,j,faces,vertices,length,x,y,nx,ny\n1,2,2,2,8.0,4.5,2.0,1.0,0.0\n2,3,0,1,0.0,10.5,6.0,";
    let normal = run.stdout.strip_prefix(start).unwrap_or_else(|| panic!("{}", run.stdout));
    let normal: Vec<f64> = normal.trim().split(',').map(|x| x.parse().unwrap()).collect();
    assert!((normal[0] - 0.6).abs() < 1e-15 && (normal[1] - 0.8).abs() < 1e-15, "{normal:?}");
    assert!(run.stderr.contains("shared vertices  3 without a shared face or edge"), "{}", run.stderr);
    let run =
        bench.run(&["contacts", "in.npy", "--labels", "--count", "-q", "--background", "none"]).succeeds();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("5\n", ""));
    let run = bench.run(&["contacts", "in.npy", "--labels", "--background", "2"]).succeeds();
    assert_eq!(run.stdout.lines().skip(1).map(|row| &row[..3]).collect::<Vec<_>>(), ["0,1", "0,3", "0,4"]);
}

/// The library over a whole image gives the contacts of the command over slabs, for every neighbourhood, in C
/// and in Fortran order.
#[test]
fn contacts_in_3d() {
    let bench = Bench::new();
    let shape = [31, 23, 17];
    let label = |at: i32| {
        let [z, y, x] = [at / (23 * 17), at / 17 % 23, at % 17];
        z / 5 * 100 + y / 4 * 10 + (x + z) / 4 - 100
    };
    let labels: Vec<i32> = (0..31 * 23 * 17).map(label).collect();
    bench.write("c.npy", npy("<i4", "(31, 23, 17)", labels.iter().flat_map(|label| label.to_le_bytes())));
    // Transposed: the same array in Fortran order.
    let transposed =
        (0..labels.len()).map(|at| labels[at % 31 * 23 * 17 + at / 31 % 23 * 17 + at / (31 * 23)]);
    let fortran = npy("<i4", "(31, 23, 17)", transposed.flat_map(i32::to_le_bytes));
    let text = String::from_utf8_lossy(&fortran[..80]).replace("False, 'shape'", "True , 'shape'");
    let mut bytes = fortran.clone();
    bytes[10..70].copy_from_slice(&text.as_bytes()[text.find('{').unwrap()..][..60]);
    bench.write("f.npy", &bytes);
    let spacing = Spacing::new([1.0, 2.0, 3.0]).unwrap();
    for (name, neighbourhood, columns) in [
        ("face", Neighbourhood::Face, "i,j,faces,area,x,y,z,nx,ny,nz"),
        ("edge", Neighbourhood::Edge, "i,j,faces,edges,area,x,y,z,nx,ny,nz"),
        ("vertex", Neighbourhood::Vertex, "i,j,faces,edges,vertices,area,x,y,z,nx,ny,nz"),
    ] {
        let found = contacts(&labels, shape, neighbourhood).unwrap();
        assert!(found.len() > 300);
        let mut expected = columns.to_owned() + "\n";
        for contact in &found {
            let [i, j] = contact.labels();
            let counts = [contact.faces(), contact.edges(), contact.vertices()];
            let counts: Vec<_> = counts[..=neighbourhood as usize].iter().map(u64::to_string).collect();
            let [z, y, x] = contact.centroid(&spacing);
            let [nz, ny, nx] = contact.normal(&spacing);
            let floats = [contact.area(&spacing), x, y, z, nx, ny, nz].map(|x| format!("{x:?}"));
            writeln!(expected, "{i},{j},{},{}", counts.join(","), floats.join(",")).unwrap();
        }
        for (file, threads) in [("c.npy", "1"), ("c.npy", "3"), ("f.npy", "1")] {
            let mut options =
                vec!["contacts", file, "--labels", "--neighbourhood", name, "--spacing", "3,2,1"];
            options.extend(["--threads", threads, "-o", "out.csv"]);
            bench.run(&options).succeeds();
            let found = bench.read("out.csv");
            if file == "c.npy" {
                assert!(found == expected, "{options:?}");
                continue;
            }
            // Sums in another order round otherwise.
            let numbers =
                |text: &str| -> Vec<f64> { text.split(['\n', ',']).filter_map(|x| x.parse().ok()).collect() };
            let (found, expected) = (numbers(&found), numbers(&expected));
            assert_eq!(found.len(), expected.len());
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * (1.0 + b.abs());
            assert!(found.iter().zip(&expected).all(near), "{options:?}");
        }
        let run =
            bench.run(&["contacts", "c.npy", "--labels", "--neighbourhood", name, "--count"]).succeeds();
        assert_eq!(run.stdout, format!("{}\n", found.len()));
        assert!(run.stderr.contains("17 x 23 x 31 voxels (x, y, z)"), "{}", run.stderr);
    }
    let error = bench.run(&["contacts", "c.npy", "--labels", "--spacing", "3,2"]);
    error.refused_with(&["c.npy: --spacing has 2 numbers, the image is 3D: give X,Y,Z"]);
}

#[test]
fn contacts_are_written_as_arrays() {
    let bench = Bench::new();
    let huge = [u64::MAX, 7, 7, u64::MAX - 1];
    bench.write("in.npy", npy("<u8", "(1, 2, 2)", huge.into_iter().flat_map(u64::to_le_bytes)));
    bench.run(&["contacts", "in.npy", "--labels", "-o", "out.npy", "--neighbourhood", "edge"]).succeeds();
    let bytes = std::fs::read(bench.path("out.npy")).unwrap();
    let file = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(file.shape(), [3]);
    let dtype = file.dtype().descr();
    for field in [
        "('i', '<u8')",
        "('faces', '<u8')",
        "('edges', '<u8')",
        "('area', '<f8')",
        "('z', '<f8')",
        "('nx', '<f8')",
    ] {
        assert!(dtype.contains(field), "{dtype}");
    }
    let row = 11 * 8;
    let data = &bytes[bytes.len() - 3 * row..];
    let label = |place: usize| u64::from_le_bytes(data[place..place + 8].try_into().unwrap());
    assert_eq!([label(0), label(8), label(16), label(24)], [7, u64::MAX - 1, 2, 0]);
    assert_eq!([label(2 * row), label(2 * row + 8), label(2 * row + 24)], [u64::MAX - 1, u64::MAX, 1]);
    let run = bench.run(&["contacts", "in.npy", "--labels"]).succeeds();
    assert!(run.stdout.contains("\n7,18446744073709551614,2,"), "{}", run.stdout);
}

#[test]
fn images_come_through_pipes() {
    let bench = Bench::new();
    let run = bench.run_with(&["contacts", "-", "--labels"], &npy("|u1", "(4, 5)", PIXELS)).succeeds();
    assert_eq!(run.stdout.lines().count(), 2);
    bench.run_with(&["contacts", "-", "--labels"], b"").refused_with(&["standard input: the file is empty"]);
    bench.run(&["contacts", "missing.npy", "--labels"]).refused_with(&["cannot read missing.npy: "]);
    bench.run(&["contacts", ".", "--labels"]).refused_with(&["it is a directory"]);
    #[cfg(unix)]
    bench.run(&["contacts", "/dev/zero", "--labels"]).refused_with(&["/dev/zero: not a labelled image"]);
}

/// Options that do not go together, or not with the image: a message, and no files left behind.
#[test]
fn options_that_do_not_fit_are_refused() {
    let bench = Bench::new();
    bench.write("in.npy", npy("|u1", "(4, 5)", PIXELS));
    let refused = |options: &[&str], parts: &[&str]| {
        bench
            .run(&[&["contacts", "in.npy", "-o", "out.csv", "--json", "s.json"], options].concat())
            .refused_with(parts);
        assert_eq!(bench.files(), ["in.npy"]);
    };
    for other in [
        &["--radius", "1"][..],
        &["--cutoff", "1"],
        &["--tolerance", "1"],
        &["--columns", "x,y"],
        &["--skip-bad-lines"],
        &["--ignore-ids"],
        &["--engine", "rows"],
        &["--bodies", "body"],
        &["--periodic", "x", "--box", "0,1,0,1"],
        &["--verify", "3"],
    ] {
        refused(&[&["--labels"], other].concat(), &["cannot be used with", "--labels", other[0]]);
    }
    for other in [["--neighbourhood", "edge"], ["--spacing", "1,1"], ["--background", "1"], ["--member", "a"]]
    {
        refused(&other, &["--labels"]);
    }
    refused(&["--labels", "--neighbourhood", "edge"], &["in.npy: --neighbourhood edge: in 2D"]);
    refused(&["--labels", "--spacing", "1,1,1"], &["--spacing has 3 numbers, the image is 2D: give X,Y"]);
    refused(&["--labels", "--spacing", "1,0"], &["--spacing: ", "is not a length"]);
    refused(&["--labels", "--spacing", "1,-1"], &["--spacing: ", "is not a length"]);
    refused(&["--labels", "--spacing", "1;1"], &["'1;1' is not a number"]);
    refused(&["--labels", "--background", "256"], &["in.npy: --background 256: a label of", "|u1"]);
    refused(&["--labels", "--background", "-1"], &["--background -1"]);
    refused(&["--labels", "--background", "x"], &["neither a whole number nor none"]);
    refused(&["--labels", "--member", "a"], &["in.npy: there is no member 'a'"]);
    refused(&["--labels", "--threads", "100000"], &["in.npy: --threads: "]);
    bench
        .run(&["contacts", "in.npy", "--labels", "-o", "in.npy"])
        .refused_with(&["is the same file as the input"]);
    let whole = npy("|u1", "(4, 5)", PIXELS);
    bench.write("cut.npy", &whole[..whole.len() - 1]);
    bench
        .run(&["contacts", "cut.npy", "--labels"])
        .refused_with(&["cut.npy: the array should take 20 bytes", "cut off"]);
}
