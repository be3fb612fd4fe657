//! Files whose third axis is easily misread: flat packings in thin periodic boxes, axes of mixed kinds,
//! columns that may be an axis.

use crate::Bench;

const THREE_DISCS: &str = "ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 12\n0 8\n\
    -0.5 0.5\nITEM: ATOMS id type x y z radius\n1 1 2 4 0 0.5\n2 1 5 4 0 0.6\n3 1 9 4 0 0.7\n";

/// A run of LAMMPS in two dimensions: its discs do not touch their own images.
#[test]
fn a_dump_in_two_dimensions_is_flat() {
    let bench = Bench::new();
    bench.write("a.dump", THREE_DISCS);
    let run = bench.run(&["contacts", "a.dump", "--json", "a.json"]).succeeds();
    assert_eq!(run.stdout, "i,j,distance,overlap,sx,sy\n");
    assert!(
        run.stderr.contains("note: a.dump: read in 2D, with x and y: all elements have z = 0"),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("3 discs in 2D"), "{}", run.stderr);
    assert_eq!(bench.json("a.json")["dimensions"], 2);

    let scaled = "ITEM: TIMESTEP\n250\nITEM: NUMBER OF ATOMS\n4\nITEM: BOX BOUNDS ff fm pp\n0 40\n0 20\n-0.5 0.5\n\
        ITEM: ATOMS id type xs ys zs\n1 1 0.1 0.5 0.5\n2 1 0.3 0.5 0.5\n3 1 0.6 0.5 0.5\n4 1 0.62 0.5 0.5\n";
    bench.write("b.dump", scaled);
    let run = bench.run(&["contacts", "b.dump", "--radius", "0.5"]).succeeds();
    assert_eq!(run.stdout, "i,j,distance,overlap\n3,4,0.8000000000000007,0.1999999999999993\n");
}

/// Frames of two and of three dimensions have other columns of shifts.
#[test]
fn frames_in_2d_and_in_3d_are_not_in_one_table() {
    let bench = Bench::new();
    let thick =
        THREE_DISCS.replace("-0.5 0.5", "-5 5").replace("3 1 9 4 0", "3 1 9 4 1").replace("100", "200");
    bench.write("a.dump", format!("{THREE_DISCS}{thick}"));
    let run = bench.run(&["contacts", "a.dump", "--frames", "::", "-o", "a.csv"]);
    run.refused_with(&["frame 1: it is in 3D, and the first frame is in 2D", "{frame}"]);
}

/// The line of a periodic box needs its three edges.
#[test]
fn a_periodic_box_without_edges_is_refused() {
    let bench = Bench::new();
    for line in ["##PERIODIC::", "##PERIODIC:: ", "##PERIODIC::2 3", "  ##PERIODIC:: 2 3 x"] {
        bench.write("a.txt", format!("{line}\n0 0 0 0.5\n1 1 1 0.5\n"));
        bench.run(&["contacts", "a.txt"]).refused_with(&["expected three edges of a periodic box"]);
    }
    bench.write("a.txt", "##PERIODIC::2 3 4\n0.1 1 1 0.5\n1.9 1 1 0.5\n");
    assert_eq!(bench.run(&["contacts", "a.txt", "--count"]).succeeds().stdout, "1\n");
}

/// Any axis, and any format with a box.
#[test]
fn a_thin_axis_may_be_any() {
    let bench = Bench::new();
    let text = "2\nLattice=\"9 0 0 0 0.8 0 0 0 9\" Properties=pos:R:3:radius:R:1 pbc=\"T T F\"\n0.2 3 4 0.5\n8.8 3 4 0.5\n";
    bench.write("a.xyz", text);
    let run = bench.run(&["contacts", "a.xyz", "--json", "a.json"]).succeeds();
    assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
    assert!(run.stderr.contains("read in 2D, with x and z: all elements have y = 3"), "{}", run.stderr);
    assert_eq!(bench.json("a.json")["periodic"]["axes"], "x");

    bench.write("b.txt", "##PERIODIC:: 9 9 0.5\n1 1 0.1 0.5\n3 1 0.1 0.5\n");
    let run = bench.run(&["contacts", "b.txt", "--count"]).succeeds();
    assert!(run.stderr.contains("2 discs in 2D"), "{}", run.stderr);
    assert_eq!(run.stdout, "0\n");
}

/// Elements in space that touch their own images are worth a line, and points with a cut-off stay in space.
#[test]
fn own_images_are_reported() {
    let bench = Bench::new();
    let cell = "Lattice=\"9 0 0 0 9 0 0 0 0.8\" Properties=pos:R:3:radius:R:1";
    bench.write("a.xyz", format!("2\n{cell}\n1 1 0 0.5\n4 4 0.1 0.5\n"));
    let run = bench.run(&["contacts", "a.xyz", "--json", "a.json"]).succeeds();
    assert!(run.stderr.contains("own images       2 of them"), "{}", run.stderr);
    assert_eq!(bench.json("a.json")["own_images"], 2);

    bench.write("b.xyz", format!("2\n{cell}\n1 1 0 0.5\n4 4 0 0.5\n"));
    let run = bench.run(&["contacts", "b.xyz", "--cutoff", "1", "--json", "b.json"]).succeeds();
    assert_eq!((bench.json("b.json")["dimensions"].as_u64(), run.stdout.lines().count()), (Some(3), 3));
    assert!(run.stderr.contains("if this is a run in two dimensions, say --periodic xy"), "{}", run.stderr);
}

#[test]
fn axes_of_mixed_kinds_are_all_used() {
    let bench = Bench::new();
    let dump = |columns: &str, rows: [&str; 2]| {
        let head =
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n0 10\n0 10\n0 10\n";
        bench.write(
            "a.dump",
            format!("{head}ITEM: ATOMS id {columns} radius\n1 {} 0.5\n2 {} 0.5\n", rows[0], rows[1]),
        );
        let run = bench.run(&["contacts", "a.dump", "--count"]).succeeds();
        assert!(run.stderr.contains("2 spheres in 3D"), "{columns}: {}", run.stderr);
        run.stdout.trim().parse::<u64>().unwrap()
    };
    assert_eq!(dump("x y zu", ["4 6 1", "4 6 7"]), 0);
    assert_eq!(dump("x y zs", ["4 6 0.1", "4 6 0.7"]), 0);
    assert_eq!(dump("xu yu z", ["14 6 1", "4 6 1.5"]), 1);
    assert_eq!(dump("x yu zs zu", ["4 6 0.1 7", "4 6 0.15 7"]), 1);
    // A kind with all axes comes first.
    assert_eq!(dump("x y xs ys zs", ["0 0 0.5 0.5 0.5", "9 9 0.5 0.5 0.58"]), 1);
}

#[test]
fn a_column_that_may_be_an_axis_is_reported() {
    let bench = Bench::new();
    let note = |header: &str| {
        let fields = header.split(',').count();
        let row = |from: usize| (0..fields).map(|k| (from + k).to_string()).collect::<Vec<_>>().join(",");
        bench.write("a.csv", format!("{header}\n{}\n{}\n", row(1), row(90)));
        let run = bench.run(&["contacts", "a.csv", "--count", "--quiet"]).succeeds();
        run.stderr.lines().find_map(|line| line.strip_prefix("note: a.csv: ").map(str::to_owned))
    };
    for header in ["x,y,zz,radius", "x,y,radius,z1", "posx,posy,zpos_,rad,z_p"] {
        let said = note(header);
        assert!(said.as_deref().is_none_or(|said| said.contains("is not used: is it z?")), "{said:?}");
        assert_eq!(said.is_some(), header != "posx,posy,zpos_,rad,z_p", "{header}");
    }
    for header in ["x,y,z,radius,zz", "x,y,radius,vx,vy,vz", "x,y,radius,size", "x,y,radius"] {
        assert_eq!(note(header), None, "{header}");
    }
}

/// YADE and Woo write the periodic box into a comment, and read it back.
#[test]
fn a_periodic_box_in_a_comment_is_used() {
    let bench = Bench::new();
    for text in [
        "##PERIODIC:: 2 3 4\n0.1 1.2 2.3 0.15\n1.85 1.2 2.3 0.15\n",
        "#format x_y_z_r\n0.1 1.2 2.3 0.15\n##PERIODIC:: 2. 3. 4.\n1.85 1.2 2.3 0.15\n",
    ] {
        bench.write("a.txt", text);
        let run = bench.run(&["contacts", "a.txt", "--json", "a.json"]).succeeds();
        assert_eq!(bench.json("a.json")["couples"], 1, "{}", run.stderr);
        assert_eq!(bench.json("a.json")["periodic"]["axes"], "xyz");
    }
    for bad in ["2 3", "2 3 4 5", "2 3 x", "2 3 0", "2 3 -4", "2 3 nan"] {
        bench.write("a.txt", format!("##PERIODIC:: {bad}\n0 0 0 1\n"));
        bench.run(&["contacts", "a.txt"]).refused_with(&["a.txt:1:", "three edges of a periodic box"]);
    }
}

/// The volume of a left-handed box is negative; couples and shifts are those of its edges.
#[test]
fn a_left_handed_box_is_used() {
    let bench = Bench::new();
    let rows = "Si 0.2 1 1\nSi 5.7 1 1\n";
    for lattice in ["\"0 6 0 6 0 0 0 0 6\"", "[[0, 6, 0], [6, 0, 0], [0, 0, 6]]"] {
        bench.write(
            "a.xyz",
            format!("2\nLattice={lattice} Properties=species:S:1:pos:R:3 pbc=\"T T T\"\n{rows}"),
        );
        let run = bench.run(&["contacts", "a.xyz", "--cutoff", "1"]).succeeds();
        let row = run.stdout.lines().nth(1).unwrap().to_owned();
        assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
        assert!(row.starts_with("0,1,0.4999999999999") && row.ends_with(",0,-1,0"), "{row}");
    }
}

#[test]
fn files_of_other_programs_are_named() {
    let bench = Bench::new();
    let cell = "5.0 0.0 0.0\n0.0 5.0 0.0\n0.0 0.0 5.0\n";
    let files = [
        (
            "POSCAR",
            format!("two\n1.0\n{cell}Si\n2\nDirect\n0.1 0.5 0.5\n0.98 0.5 0.5\n"),
            "a POSCAR file of VASP",
        ),
        ("a.cif", "data_two\n_cell_length_a 5.0\nloop_\n_atom_site_label\nSi1\n".to_owned(), "a CIF file"),
        ("a.pdb", "CRYST1    5.000    5.000\nATOM      1 SI   MOL A   1\n".to_owned(), "a PDB file"),
        (
            "positions",
            "FoamFile\n{\n    class vectorField;\n}\n2\n((0 0 0)(1 0 0))\n".to_owned(),
            "a field of OpenFOAM",
        ),
        ("a.yaml", "---\ncreator: LAMMPS\ntimestep: 0\n".to_owned(), "a dump of LAMMPS in YAML"),
        (
            "a.off",
            "OFF\n# a face\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_owned(),
            "a mesh in the Object File Format (OFF)",
        ),
        ("b.off", "COFF 3 1 0\n0 0 0 9 9 9 9\n".to_owned(), "a mesh in the Object File Format (OFF)"),
        (
            "a.gts",
            "# a face\n3 3 1 GtsSurface GtsFace GtsEdge GtsVertex\n0 0 0\n1 0 0\n0 1 0\n".to_owned(),
            "a surface of GTS",
        ),
        (
            "a.mesh",
            "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 0 1\n".to_owned(),
            "a mesh of MEDIT",
        ),
    ];
    for (name, text, format) in files {
        bench.write(name, text);
        bench.run(&["contacts", name, "--cutoff", "1"]).refused_with(&[name, format]);
    }
    bench.write("a.gsd", [[0xdf_u8, 0x65].repeat(4), vec![0; 248]].concat());
    bench.run(&["contacts", "a.gsd", "--cutoff", "1"]).refused_with(&["a.gsd", "a GSD file", "extended XYZ"]);
}

#[test]
fn a_dump_of_pairs_is_named() {
    let bench = Bench::new();
    bench
        .write("a.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\nITEM: ENTRIES index c_id[1]\n1 1\n");
    bench.run(&["contacts", "a.dump"]).refused_with(&["a.dump:3: this is a 'dump local' of pairs"]);
}

#[test]
fn columns_of_hybrid_styles_are_known() {
    let bench = Bench::new();
    let file = |style: &str, rows: &str| {
        format!("title\n\n3 atoms\n\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\nAtoms # {style}\n\n{rows}")
    };
    let rows = "1 1 4.2 5 5 1.0 2500 7\n2 1 5 5 5 1.0 2500 7\n3 1 8 5 5 1.0 2500 7\n";
    bench.write("a.data", file("hybrid sphere molecular", rows));
    let run = bench.run(&["contacts", "a.data"]).succeeds();
    assert!(run.stdout.lines().nth(1).unwrap().starts_with("1,2,0.7999999999999998,0.2"), "{}", run.stdout);
    bench.write("a.data", file("hybrid sphere ours", rows));
    bench.run(&["contacts", "a.data"]).refused_with(&["'hybrid sphere ours' are not known"]);
    bench.write("a.data", file("hybrid sphere charge", rows).replace(" 7\n", "\n"));
    bench.run(&["contacts", "a.data"]).refused_with(&["has 8 columns", "diameter density q"]);
}
