//! Files of several frames, each with its box, of any format, compressed or not.

use crate::Bench;

/// Two spheres that touch across the face x of the box, and a single one.
const FRAME_0: &str = "ITEM: TIMESTEP\n500\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp ff\n0 10\n0 10\n0 10\n\
                       ITEM: ATOMS id x y z radius\n1 0.25 5 5 0.5\n2 9.75 5 5 0.5\n7 5 5 5 0.5\n";
/// The same two in a sheared box, scaled, beside another that touches the second inside.
const FRAME_1: &str = "ITEM: TIMESTEP\n600\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS xy xz yz pp pp pp\n0 12 2\n0 10 0\n0 10 0\n\
                       ITEM: ATOMS id xs ys zs radius\n1 0.03125 0.5 0.5 0.5\n2 0.96875 0.5 0.5 0.5\n3 0.90625 0.5 0.5 0.5\n";
const COUPLES: &str = "frame,step,i,j,distance,overlap,sx,sy,sz\n0,500,1,2,0.5,0.5,-1,0,0\n\
                       1,600,1,2,0.625,0.375,-1,0,0\n1,600,2,3,0.625,0.375,0,0,0\n";

fn dump() -> Bench {
    let bench = Bench::new();
    bench.write("run.dump", [FRAME_0, FRAME_1].concat());
    bench
}

#[test]
fn a_series_is_one_table_with_the_box_of_each_frame() {
    let bench = dump();
    let run = bench.run(&["contacts", "run.dump", "--json", "all.json", "--verify", "3"]).succeeds();
    assert_eq!(run.stdout, COUPLES);
    for part in [
        "frames           2\n",
        "each frame in its own box",
        "in all           6 elements, 3 couples",
        "verified         6",
    ] {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    let lines: Vec<Vec<&str>> = run.stderr.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(lines.contains(&vec!["0", "500", "-", "3", "1", "0.6667", "1", "0.5"]), "{}", run.stderr);
    let json = bench.json("all.json");
    assert_eq!(json.as_array().unwrap().len(), 2);
    assert_eq!(
        (&json[1]["frame"], &json[1]["step"], &json[1]["couples"]),
        (&1.into(), &600.into(), &2.into())
    );
    assert_eq!(json[0]["periodic"]["axes"], "xy");
    assert_eq!(
        json[1]["periodic"]["edges"],
        serde_json::json!([[10.0, 0.0, 0.0], [2.0, 10.0, 0.0], [0.0, 0.0, 10.0]])
    );
    assert_eq!(json[1]["periodic"]["from"], "file");

    bench.run(&["contacts", "run.dump", "-o", "all.csv", "-q"]).succeeds();
    assert_eq!(bench.read("all.csv"), COUPLES);
    assert_eq!(bench.run(&["contacts", "run.dump", "--count", "-q"]).succeeds().stdout, "1\n2\n");
    bench.run(&["contacts", "run.dump", "-o", "all.npy", "-q"]).succeeds();
    let array = npyz::NpyFile::new(std::fs::File::open(bench.path("all.npy")).unwrap()).unwrap();
    assert_eq!(array.shape(), &[3]);
    let names: Vec<&str> = COUPLES.lines().next().unwrap().split(',').collect();
    let npyz::DType::Record(fields) = array.dtype() else { panic!("no fields") };
    assert_eq!(fields.iter().map(|field| field.name.as_str()).collect::<Vec<_>>(), names);

    // The archive has one array for each column; `crates/io/tests/python/test_written.py` reads it and the
    // Parquet file.
    for file in ["all.npz", "all.parquet"] {
        let run = bench.run(&["contacts", "run.dump", "-o", file]).succeeds();
        assert!(run.stderr.ends_with(&format!("written          {file}\n")), "{}", run.stderr);
    }
    let archive = std::fs::read(bench.path("all.npz")).unwrap();
    for name in ["frame.npy", "step.npy", "i.npy", "overlap.npy", "shift.npy"] {
        assert!(archive.windows(name.len()).any(|part| part == name.as_bytes()), "{name}");
    }
    assert!(std::fs::read(bench.path("all.parquet")).unwrap().ends_with(b"PAR1"));
    bench
        .run(&["contacts", "run.dump", "-o", "all.vtp"])
        .refused_with(&[".csv, .npy, .npz or .parquet", "{frame}"]);
}

/// The files of a series are named: one of all frames, and those of single frames in one line.
#[test]
fn the_summary_names_the_files_of_a_series() {
    let bench = dump();
    let run =
        bench.run(&["contacts", "run.dump", "--picture", "p{frame}.svg", "--json", "s.json"]).succeeds();
    assert_eq!(run.stdout, "");
    let files = "written          s.json\n                 p{frame}.svg: 2 files, frame 0 to 1\n";
    assert!(run.stderr.ends_with(files), "{}", run.stderr);
}

#[test]
fn frames_are_chosen_as_python_slices() {
    let bench = dump();
    let run = bench.run(&["contacts", "run.dump", "--frames", "-1"]).succeeds();
    assert_eq!(run.stdout, "i,j,distance,overlap,sx,sy,sz\n1,2,0.625,0.375,-1,0,0\n2,3,0.625,0.375,0,0,0\n");
    assert!(run.stderr.contains("frame            1, time step 600\n"), "{}", run.stderr);
    let run = bench.run(&["contacts", "run.dump", "--frames", "::-1", "--count", "-q"]).succeeds();
    assert_eq!(run.stdout, "2\n1\n");
    let run = bench.run(&["contacts", "run.dump", "--frames", "0:1", "-q"]).succeeds();
    assert_eq!(run.stdout.lines().collect::<Vec<_>>(), COUPLES.lines().take(2).collect::<Vec<_>>());
    for (frames, part) in [
        ("2", "0 to 1"),
        ("5:", "no frame: the file has 2 frames"),
        ("a", "not a frame"),
        ("::0", "must not be 0"),
    ] {
        bench.run(&["contacts", "run.dump", "--frames", frames]).refused_with(&[part]);
    }
    bench.run(&["bench", "run.dump"]).refused_with(&["2 frames", "--frames N"]);
    bench.run(&["bench", "run.dump", "--frames", "0", "--repeat", "1"]).succeeds();
    bench.run(&["contacts", "run.dump", "--explain"]).refused_with(&["--explain", "--frames N"]);
    assert!(
        bench
            .run(&["contacts", "run.dump", "--explain", "--frames", "0"])
            .succeeds()
            .stdout
            .contains("engine")
    );
}

#[test]
fn each_frame_may_have_files_of_its_own() {
    let bench = dump();
    let outputs = ["-o", "c{frame}.csv", "--json", "s{frame}.json", "--picture", "p{frame}.svg"];
    bench.run(&[&["contacts", "run.dump", "-q"], &outputs[..]].concat()).succeeds();
    assert_eq!(bench.files(), ["c0.csv", "c1.csv", "p0.svg", "p1.svg", "run.dump", "s0.json", "s1.json"]);
    assert_eq!(bench.read("c0.csv"), "i,j,distance,overlap,sx,sy,sz\n1,2,0.5,0.5,-1,0,0\n");
    assert_eq!(bench.json("s1.json")["frame"], 1);
    bench
        .run(&["contacts", "run.dump", "--frames", "1", "-o", "one{frame}.csv", "--json", "one.json"])
        .succeeds();
    assert_eq!(bench.read("one1.csv"), bench.read("c1.csv"));
    assert_eq!(bench.json("one.json")["couples"], 2);
    bench.run(&["contacts", "run.dump", "--picture", "p.svg"]).refused_with(&["--picture", "{frame}"]);
    bench.write("c1.csv", FRAME_0);
    bench.run(&["contacts", "c1.csv", "--frames", "0:", "-o", "c{frame}.csv"]).succeeds();
    bench.write("c0.csv", FRAME_0);
    bench
        .run(&["contacts", "c0.csv", "-o", "c{frame}.csv"])
        .refused_with(&["--output c0.csv is the same file as the input"]);
}

/// The second frame is cut off: no file of the first appears either.
#[test]
fn outputs_of_a_series_are_whole_or_absent() {
    let bench = Bench::new();
    bench.write("run.dump", [FRAME_0, &FRAME_1[..FRAME_1.len() - 30]].concat());
    let outputs = ["--json", "all.json", "--picture", "p{frame}.svg"];
    for output in ["all.csv", "all.npy", "c{frame}.csv"] {
        bench
            .run(&[&["contacts", "run.dump", "-o", output], &outputs[..]].concat())
            .refused_with(&["run.dump:23: frame 1 (counted from 0): ", "expected 5 fields"]);
        assert_eq!(bench.files(), ["run.dump"]);
    }
    assert_eq!(
        bench.run(&["contacts", "run.dump", "--frames", "0", "--count", "-q"]).succeeds().stdout,
        "1\n"
    );
}

#[test]
fn options_win_over_the_box_of_the_file() {
    let bench = Bench::new();
    bench.write("a.dump", FRAME_0);
    let count = |options: &[&str]| {
        bench
            .run(&[&["contacts", "a.dump", "--count", "--json", "s.json"], options].concat())
            .succeeds()
            .stdout
    };
    assert_eq!(count(&[]), "1\n");
    let run = bench.run(&["contacts", "a.dump"]).succeeds();
    assert!(
        run.stderr.contains("edges [10, 0, 0], [0, 10, 0], [0, 0, 10] from [0, 0, 0], the box of the file\n"),
        "{}",
        run.stderr
    );
    assert_eq!(count(&["--periodic", "none"]), "0\n");
    let summary = bench.json("s.json");
    assert_eq!(summary["periodic"], serde_json::Value::Null);
    assert_eq!(summary["box"]["edges"][2], serde_json::json!([0.0, 0.0, 10.0]));
    assert_eq!(count(&["--periodic", "z"]), "0\n", "the box of the file, along another edge");
    assert_eq!(bench.json("s.json")["periodic"]["axes"], "z");
    assert_eq!(count(&["--periodic", "x", "--box", "0,20,0,10,0,10"]), "0\n");
    assert_eq!(bench.json("s.json")["periodic"]["from"], "options");
    bench
        .run(&["contacts", "a.dump", "--periodic", "none", "--box", "0,20,0,10,0,10"])
        .refused_with(&["--periodic none", "--box"]);
    bench.write(
        "flat.xyz",
        "1\nLattice=\"4 0 0 0 4 0 0 0 0\" pbc=\"T T F\" Properties=pos:R:3:radius:R:1\n0 0 0 2\n",
    );
    let run = bench.run(&["contacts", "flat.xyz", "-q"]).succeeds();
    assert_eq!(run.stdout, "i,j,distance,overlap,sx,sy,sz\n0,0,4.0,0.0,0,1,0\n0,0,4.0,0.0,1,0,0\n");
    bench.write("bad.xyz", "1\nLattice=\"4 0 0 8 0 0 0 0 4\" Properties=pos:R:3:radius:R:1\n0 0 0 1\n");
    bench.run(&["contacts", "bad.xyz"]).refused_with(&["bad.xyz: the box of the file", "--periodic none"]);
    bench.write("wall.stl", "solid w\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid w\n");
    bench
        .run(&["contacts", "a.dump", "wall.stl"])
        .refused_with(&["a.dump: its box is periodic", "--periodic none"]);
    bench.run(&["contacts", "a.dump", "wall.stl", "--periodic", "none"]).succeeds();
}

#[test]
fn frames_that_do_not_fit_one_table_are_refused() {
    let open = "1\nProperties=pos:R:3:radius:R:1\n0 0 0 1\n";
    let closed = "1\nLattice=\"2 0 0 0 9 0 0 0 9\" Properties=pos:R:3:radius:R:1\n0 0 0 1\n";
    let bench = Bench::new();
    bench.write("a.xyz", [closed, open].concat());
    let run = bench.run(&["contacts", "a.xyz", "-q"]).succeeds();
    assert_eq!(run.stdout, "frame,step,i,j,distance,overlap,sx,sy,sz\n0,-1,0,0,2.0,0.0,1,0,0\n");
    bench.write("b.xyz", [open, closed].concat());
    bench.run(&["contacts", "b.xyz", "-o", "b.csv"]).refused_with(&["frame 1", "one table cannot hold both"]);
    assert_eq!(bench.files(), ["a.xyz", "b.xyz"]);
    bench.run(&["contacts", "b.xyz", "-o", "b{frame}.csv"]).succeeds();
    assert_eq!(
        bench.run(&["contacts", "b.xyz", "-q", "--periodic", "none"]).succeeds().stdout,
        "frame,step,i,j,distance,overlap\n"
    );
}

#[test]
fn the_format_is_told_by_content_or_by_option() {
    let bench = Bench::new();
    bench.write("a.csv", "3\n\nA 0 0 0\nA 1 0 0\nA 5 0 0\n");
    assert_eq!(bench.run(&["contacts", "a.csv", "--cutoff", "1", "--count", "-q"]).succeeds().stdout, "1\n");
    bench.run(&["contacts", "a.csv"]).refused_with(&["no column for radius", "--radius R"]);
    bench
        .run(&["contacts", "a.csv", "--format", "text"])
        .refused_with(&["a.csv:1:", "1 column and no header"]);
    bench.run(&["contacts", "a.csv", "--format", "lammps-dump"]).refused_with(&["a.csv:1:", "ITEM:"]);
    bench.run(&["contacts", "a.csv", "--format", "stl"]).refused_with(&["lammps-dump"]);
    bench.write(
        "wide.csv",
        "x,y,radius\n0,0,1\n".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>(),
    );
    bench.run(&["contacts", "wide.csv"]).refused_with(&["wide.csv: ", "UTF-16", "save it as UTF-8"]);
    bench.write("no.xyz", "x,y,radius\n0,0,1\n1,0\n");
    bench.run(&["contacts", "no.xyz"]).refused_with(&[
        "no.xyz:3:",
        "the name stands for a XYZ file",
        "expected 3 fields",
    ]);
}

/// A packing that is written with its box is read with its box: the box was passed over, and couples across
/// its faces were lost.
#[test]
fn the_box_of_an_archive_is_read_back() {
    let bench = dump();
    for (frame, couples) in [("0", "1\n"), ("1", "2\n")] {
        bench.run(&["contacts", "run.dump", "--frames", frame, "-o", "a.npz", "-q"]).succeeds();
        let run = bench.run(&["contacts", "a.npz", "--count", "--json", "s.json", "-q"]).succeeds();
        assert_eq!(run.stdout, couples, "frame {frame}");
        assert_eq!(bench.json("s.json")["periodic"]["from"], "file");
        let run = bench.run(&["contacts", "a.npz", "--count", "--periodic", "none", "-q"]).succeeds();
        assert_eq!(run.stdout, if frame == "0" { "0\n" } else { "1\n" }, "frame {frame}");
    }
    bench.run(&["contacts", "run.dump", "--count", "--analyse"]).refused_with(&["--analyse", "--json"]);
    bench.run(&["contacts", "run.dump", "--count", "--analyse", "--json", "all.json", "-q"]).succeeds();
    assert!(bench.json("all.json")[1]["analysis"]["coordination"]["mean"].is_number());
}

/// The pieces of a collection stand beside it; a piece is found from the file that lists it.
#[test]
fn collections_of_paraview_are_series() {
    let bench = Bench::new();
    let points = |xs: [f64; 2]| {
        format!(
            "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"2\"><PointData><DataArray type=\"Float64\" \
             Name=\"radius\" format=\"ascii\">0.5 0.5</DataArray></PointData><Points><DataArray type=\"Float64\" \
             NumberOfComponents=\"3\" format=\"ascii\">{} 0 0 {} 0 1e-3</DataArray></Points></Piece></PolyData></VTKFile>",
            xs[0], xs[1]
        )
    };
    std::fs::create_dir_all(bench.path("run/parts")).unwrap();
    bench.write("run/parts/one.vtp", points([0.0, 0.75]));
    bench.write("run/parts/two.vtp", points([1.5, 9.0]));
    bench.write(
        "run/all.pvtp",
        "<VTKFile type=\"PPolyData\"><PPolyData>\n<Piece Source=\"parts/one.vtp\"/>\n<Piece Source=\"parts/two.vtp\"/>\n\
         </PPolyData></VTKFile>",
    );
    bench.write(
        "run.pvd",
        "<VTKFile type=\"Collection\"><Collection>\n<DataSet timestep=\"0\" file=\"run/parts/one.vtp\"/>\n\
         <DataSet timestep=\"2.5\" file=\"run/all.pvtp\"/>\n</Collection></VTKFile>",
    );
    let run = bench.run(&["contacts", "run/all.pvtp", "--count"]).succeeds();
    assert_eq!(run.stdout, "2\n");
    let run = bench.run(&["contacts", "run.pvd", "--frames", "1", "--json", "s.json", "-q"]).succeeds();
    assert_eq!(run.stdout.lines().skip(1).map(|row| &row[..3]).collect::<Vec<_>>(), ["0,1", "1,2"]);
    assert_eq!(bench.json("s.json")["time"], 2.5);
    let run = bench.run(&["contacts", "run.pvd", "--frames", ":", "-q"]).succeeds();
    assert_eq!(run.stdout.lines().count(), 4, "{}", run.stdout);

    std::fs::remove_file(bench.path("run/parts/two.vtp")).unwrap();
    bench
        .run(&["contacts", "run/all.pvtp"])
        .refused_with(&["run/all.pvtp:3: piece parts/two.vtp: cannot read"]);
    bench
        .run(&["contacts", "run.pvd", "--frames", "1"])
        .refused_with(&["run.pvd:3: ", "piece run/all.pvtp: line 3: piece parts/two.vtp: cannot read"]);
    let circle =
        "<VTKFile type=\"PPolyData\"><PPolyData><Piece Source=\"../all.pvtp\"/></PPolyData></VTKFile>";
    bench.write("run/parts/two.vtp", circle);
    bench.run(&["contacts", "run/all.pvtp"]).refused_with(&["run/all.pvtp:3: ", "lists itself"]);
}
