//! The formats of `--output`: how each name is understood, and where it is refused. Other readers of these
//! files: `crates/io/tests/python/test_written.py`.

use std::fs;

use crate::Bench;

const PACKING: &str = "id,x,y,radius\n7,0,0,1\n9,1.5,0,1\n8,5,5,1\n";

#[test]
fn every_format_is_written() {
    let bench = Bench::new();
    bench.write("in.csv", PACKING);
    for (name, start) in [
        ("a.csv", &b"i,j,distance,overlap\n7,9,1.5,0.5\n"[..]),
        ("a.npy", b"\x93NUMPY"),
        ("a.npz", b"PK\x03\x04"),
        ("a.parquet", b"PAR1"),
        ("a.vtp", b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\""),
        ("a.graphml", b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<graphml"),
        ("a.JSON", b"{\"directed\":false,\"multigraph\":false,"),
    ] {
        bench.run(&["contacts", "in.csv", "-o", name]).succeeds();
        let bytes = fs::read(bench.path(name)).unwrap();
        assert!(bytes.starts_with(start), "{name}: {:?}", String::from_utf8_lossy(&bytes));
        // Nothing of it depends on the time.
        bench.run(&["contacts", "in.csv", "-o", name]).succeeds();
        assert!(fs::read(bench.path(name)).unwrap() == bytes, "{name}");
    }
    let graph = bench.json("a.JSON");
    assert_eq!(graph["nodes"][2]["id"], 8);
    assert_eq!(graph["edges"][0]["source"], 7);
    assert_eq!(graph["edges"][0]["overlap"], 0.5);
}

/// The mesh reader takes the lines: elements and images where they should be.
#[test]
fn lines_lead_to_images() {
    let bench = Bench::new();
    bench.write("in.csv", "x,y,radius\n0.5,2,1\n3.75,2,0.5\n");
    bench.run(&["contacts", "in.csv", "--periodic", "x", "--box", "0,4,0,4", "-o", "out.vtp"]).succeeds();
    let bytes = fs::read(bench.path("out.vtp")).unwrap();
    let mesh = fdem::io::read_mesh(&bytes, "out.vtp").unwrap();
    assert_eq!(mesh.points, [[0.5, 2.0, 0.0], [3.75, 2.0, 0.0], [-0.25, 2.0, 0.0]]);
    assert_eq!(mesh.segments.nodes, [[0, 2]]);
}

#[test]
fn networks_are_of_packings() {
    let bench = Bench::new();
    bench.write("in.csv", PACKING);
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let (mesh, image) = (format!("{root}/squares.msh"), format!("{root}/grains.npy"));
    for name in ["out.graphml", "out.json"] {
        let extension = &name[3..];
        bench.run(&["contacts", &mesh, "-o", name]).refused_with(&[extension, "not elements of meshes"]);
        bench
            .run(&["contacts", &image, "--labels", "-o", name])
            .refused_with(&[extension, "not bodies of an image"]);
        bench
            .run(&["contacts", &mesh, "-o", "out.csv", "--body-table", name])
            .refused_with(&[name, "its extension must be that of a format: .csv, .npy, .npz or .parquet"]);
    }
    for name in ["out.npz", "out.parquet", "out.vtp"] {
        bench
            .run(&["generate", "gas", "-n", "9", "-o", name])
            .refused_with(&[name, "its extension must be that of a format: .csv or .npy"]);
    }
    assert_eq!(bench.files(), ["in.csv"]);
}
