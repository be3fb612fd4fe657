//! Meshes, several files, spheres against walls.

use std::fmt::Write;

use crate::{Bench, foreign_data};

/// Two squares of two triangles each, side by side, and a segment; physical groups 5 and 9 are the squares, 1
/// is the segment.
const SQUARES: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
    $PhysicalNames\n2\n2 5 \"left\"\n2 9 \"right\"\n$EndPhysicalNames\n\
    $Nodes\n6\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 2 0 0\n6 2 1 0\n$EndNodes\n\
    $Elements\n5\n1 1 2 1 1 1 2\n11 2 2 5 1 1 2 3\n12 2 2 5 1 1 3 4\n13 2 2 9 2 2 5 6\n14 2 2 9 2 2 6 3\n$EndElements\n";

/// A tetrahedron with its corner at a point, as OBJ has no tetrahedra: Abaqus.
fn tetrahedron(name: &str, x: f64) -> String {
    format!(
        "*NODE\n1, {x}, 0, 0\n2, {}, 0, 0\n3, {x}, 2, 0\n4, {x}, 0, 2\n*ELEMENT, TYPE=C3D4, ELSET={name}\n7, 1, 2, 3, 4\n",
        x + 2.0
    )
}

/// A square in the plane of this z, of two triangles.
fn floor(z: f64) -> String {
    let mut text = "solid floor\n".to_owned();
    for corners in [[[0, 0], [4, 0], [4, 4]], [[0, 0], [4, 4], [0, 4]]] {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y] in corners {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid floor\n"
}

#[test]
fn a_mesh_of_two_bodies() {
    let bench = Bench::new();
    bench.write("squares.msh", SQUARES);
    for engine in ["auto", "direct", "nbs", "rows", "multilevel", "cgrid"] {
        let options = ["--engine", engine, "--json", "s.json", "--body-table", "bodies.csv", "--verify", "9"];
        let run = bench.run(&[&["contacts", "squares.msh"], &options[..]].concat()).succeeds();
        let rows: Vec<_> = run.stdout.lines().collect();
        assert_eq!(rows.len(), 4);
        assert_eq!(rows[0], "i,j,body_i,body_j,kind,measure,x,y,nx,ny");
        // At the ends of the side they meet in a point; which way that is, is for the narrow phase to say.
        assert!(rows[1].starts_with("11,13,0,1,area,0.0,1.0,0.0,"), "{}", rows[1]);
        assert_eq!(rows[2], "11,14,0,1,area,0.0,1.0,0.5,1.0,0.0");
        assert!(rows[3].starts_with("12,14,0,1,area,0.0,1.0,1.0,"), "{}", rows[3]);
        assert_eq!(
            bench.read("bodies.csv"),
            "i,j,couples,overlap,shared,x,y,nx,ny\n0,1,3,0.0,1.0,1.0,0.5,1.0,0.0\n"
        );
        for line in [
            "Gmsh: 4 triangles, without 1 segments",
            "couples          3\n",
            "overlap          0 (an area, in units of the file squared)\n",
            "shared boundary  1 (a length, in units of the file)\n",
        ] {
            assert!(run.stderr.contains(line), "{line:?} is not in\n{}", run.stderr);
        }
        let json = bench.json("s.json");
        assert_eq!((&json["couples"], &json["bodies"], &json["verified"]), (&3.into(), &2.into(), &4.into()));
        assert_eq!(json["bodies_of_meshes"][1]["number"], 9);
        assert_eq!(json["bodies_of_meshes"][1]["name"], "right");
        assert_eq!(json["files"][0]["left_out"]["segments"], 1);
    }
    assert_eq!(bench.run(&["contacts", "squares.msh", "--count", "-q"]).succeeds().stdout, "3\n");
    // All four elements have neighbours; of one body only those without a common node would count.
    assert_eq!(bench.run(&["contacts", "squares.msh", "--count", "--self-contact"]).succeeds().stdout, "3\n");
    bench
        .run(&["contacts", "squares.msh", "-o", "c.npy", "--body-table", "b.npy", "--threads", "2"])
        .succeeds();
    let file = std::fs::read(bench.path("c.npy")).unwrap();
    assert_eq!(npyz::NpyFile::new(&file[..]).unwrap().shape(), [3]);
    let file = std::fs::read(bench.path("b.npy")).unwrap();
    let array = npyz::NpyFile::new(&file[..]).unwrap();
    assert!(array.dtype().descr().contains("('shared', '<f8')"), "{}", array.dtype().descr());
    assert_eq!(array.shape(), [1]);
    bench.run_with(&["contacts", "-", "--count"], SQUARES.as_bytes()).succeeds();
}

#[test]
fn several_meshes_are_several_bodies() {
    let bench = Bench::new();
    bench.write("a.inp", tetrahedron("A", 0.0));
    bench.write("b.inp", tetrahedron("B", 1.0));
    bench.write("floor.stl", floor(0.0));
    let run = bench.run(&["contacts", "a.inp", "b.inp", "floor.stl", "--verify", "9"]).succeeds();
    let rows: Vec<Vec<&str>> = run.stdout.lines().skip(1).map(|row| row.split(',').collect()).collect();
    let volume: f64 = rows[0][5].parse().unwrap();
    assert!((volume - 1.0 / 6.0).abs() < 1e-14, "{volume}");
    assert_eq!(rows[0][..5], ["7", "7", "0", "1", "volume"]);
    // Both rest on the two triangles of the floor.
    let of_floor: Vec<_> = rows[1..].iter().map(|row| (row[1], row[2], row[3], row[5])).collect();
    assert_eq!(
        of_floor,
        [("0", "0", "2", "0.0"), ("1", "0", "2", "0.0"), ("0", "1", "2", "0.0"), ("1", "1", "2", "0.0")]
    );
    assert!(run.stderr.contains("bodies           3\n"), "{}", run.stderr);
}

#[test]
fn spheres_meet_walls_once() {
    let bench = Bench::new();
    bench.write("floor.stl", floor(0.0));
    // Above the edge between the triangles; beside it; touching the first; nowhere.
    bench.write(
        "spheres.csv",
        "id,x,y,z,radius\n70,2,2,0.75,1\n71,3.5,0.5,0.5,0.5\n72,2,2,2.5,1\n73,9,9,9,1\n",
    );
    for engine in ["auto", "direct", "rows", "multilevel", "cgrid"] {
        let options = ["--engine", engine, "--verify", "4", "--json", "s.json", "--body-table", "b.csv"];
        let run = bench.run(&[&["contacts", "spheres.csv", "floor.stl"], &options[..]].concat()).succeeds();
        assert_eq!(
            run.stdout,
            "i,j,body_i,body_j,kind,measure,x,y,z,nx,ny,nz\n\
            70,72,0,2,depth,0.25,2.0,2.0,1.625,0.0,0.0,1.0\n\
            70,0,0,4,depth,0.25,2.0,2.0,0.0,0.0,0.0,-1.0\n\
            71,0,1,4,depth,0.0,3.5,0.5,0.0,0.0,0.0,-1.0\n"
        );
        assert_eq!(bench.read("b.csv").lines().count(), 4);
        let json = bench.json("s.json");
        let kinds = &json["couples_by_kind"];
        assert_eq!(kinds["spheres"], 1);
        assert_eq!(kinds["spheres_and_meshes"], 2);
        assert_eq!((&json["without_contact"], &json["bodies"]), (&1.into(), &5.into()));
    }
    // The other way round the wall comes first, and normals lead from it.
    let run = bench.run(&["contacts", "floor.stl", "spheres.csv"]).succeeds();
    assert!(run.stdout.contains("\n0,70,0,1,depth,0.25,2.0,2.0,0.0,0.0,0.0,1.0\n"), "{}", run.stdout);
}

/// A binary STL file has zeros among its bytes, which packings never have, and may be longer than the part
/// that is looked at first.
#[test]
fn large_binary_meshes_are_read_whole() {
    let bench = Bench::new();
    let facets: u32 = 30_000;
    let mut bytes = vec![b' '; 80];
    bytes.extend(facets.to_le_bytes());
    for k in 0..facets {
        let at = (k % 200) as f32 * 2.0;
        let y = (k / 200) as f32 * 2.0;
        let numbers = [0.0, 0.0, 1.0, at, y, 0.0, at + 1.0, y, 0.0, at, y + 1.0, 0.0_f32];
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bench.write("facets", &bytes);
    bench.write("ball.csv", "x,y,z,radius\n0.25,0.25,0.5,0.5\n398.25,298.25,0.5,0.5\n");
    let run = bench.run(&["contacts", "facets", "ball.csv", "--verify", "2"]).succeeds();
    let ends: Vec<_> =
        run.stdout.lines().skip(1).map(|row| row.split(',').take(2).collect::<Vec<_>>()).collect();
    assert_eq!(ends, [["0", "0"], ["29999", "1"]]);
}

#[test]
fn what_does_not_fit_is_refused() {
    let bench = Bench::new();
    bench.write("squares.msh", SQUARES);
    bench.write("tetrahedron.inp", tetrahedron("A", 0.0));
    bench.write("floor.stl", floor(1.0));
    bench.write("spheres.csv", "x,y,z,radius\n0,0,0,1\n");
    bench.write("discs.csv", "x,y,radius\n0,0,1\n");
    bench.write("tiny.csv", "x,y,z,radius\n0,0,0,1\n0,0,1e-90,1\n");
    bench.write("tiny.obj", "v 0 0 0\nv 1 0 0\nv 0 1e-90 1\nf 1 2 3\n");
    bench.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
    bench.write("line.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    let before = bench.files();
    let refused = |options: &[&str], parts: &[&str]| {
        bench
            .run(
                &[&["contacts", "-o", "out.csv", "--json", "s.json", "--body-table", "b.csv"], options]
                    .concat(),
            )
            .refused_with(parts);
        assert_eq!(bench.files(), before);
    };
    refused(&["spheres.csv"], &["spheres.csv: --body-table is for meshes"]);
    refused(&["floor.stl", "--radius", "5"], &["floor.stl: --radius is for packings"]);
    refused(&["floor.stl", "bad.obj"], &["bad.obj:2: element 0 (triangle) names node 2"]);
    refused(&["floor.stl", "line.obj"], &["line.obj: the mesh has only segments"]);
    refused(&["floor.stl", "missing.csv"], &["cannot read missing.csv: "]);
    refused(&["floor.stl", "discs.csv"], &["discs.csv: discs in 2D"]);
    refused(
        &["tetrahedron.inp", "spheres.csv"],
        &["tetrahedron.inp has tetrahedra, spheres.csv has spheres"],
    );
    refused(
        &["floor.stl", "spheres.csv", "tiny.csv"],
        &["tiny.csv: sphere 1 (counted from 0): ", "axis 2: 1e-90"],
    );
    refused(&["floor.stl", "tiny.obj"], &["tiny.obj: node 2, axis 1: 1e-90"]);
    refused(&["-", "-"], &["standard input can only be read once"]);
    for option in [
        &["--tolerance", "0.1"][..],
        &["--cutoff", "1"],
        &["--bodies", "body"],
        &["--periodic", "x", "--box", "0,1,0,1"],
    ] {
        refused(&[&["squares.msh"], option].concat(), &["squares.msh: ", option[0], "not for meshes"]);
    }
    refused(&["squares.msh", "--threads", "100000"], &["squares.msh: --threads: "]);
    refused(&["squares.msh", "--labels"], &["cannot be used with"]);
    bench
        .run(&["contacts", "floor.stl", "spheres.csv", "-o", "spheres.csv"])
        .refused_with(&["is the same file as the input"]);
    bench
        .run(&["contacts", "squares.msh", "-o", "x.csv", "--body-table", "x.csv"])
        .refused_with(&["--body-table x.csv is the same file as --output"]);
}

/// Meshes in a plane and in space, and spheres with walls, have all drawings and a network for ParaView,
/// which were refused.
#[test]
fn bodies_of_every_kind_are_drawn() {
    let bench = Bench::new();
    bench.write("squares.msh", SQUARES);
    bench.write("floor.stl", floor(0.0));
    bench.write("spheres.csv", "x,y,z,radius\n2,2,0.9,1\n3.5,2,0.9,1\n2,2,5,1\n");
    bench.write("a.inp", tetrahedron("a", 0.0));
    bench.write("b.inp", tetrahedron("b", 1.5));
    for (files, bodies, contacts, noun) in [
        (&["squares.msh"][..], 2, 1, "overlap"),
        (&["spheres.csv", "floor.stl"], 4, 3, "depth"),
        (&["a.inp", "b.inp"], 2, 1, "overlap"),
    ] {
        let outputs = ["--picture", "p.png", "--plots", "d.svg", "--report", "r.html", "-o", "o.vtp"];
        let run = bench.run(&[&["contacts"], files, &outputs[..]].concat()).succeeds();
        assert_eq!(run.stdout, "");
        let page = bench.read("r.html");
        assert!(page.contains(&format!("{bodies} bodies, {contacts} contact")), "{files:?}");
        assert!(page.contains(noun) && page.contains("Table of bodies"), "{files:?}");
        assert!(std::fs::read(bench.path("p.png")).unwrap().starts_with(b"\x89PNG"));
        assert!(bench.read("d.svg").contains("contacts of a body"));
        let bytes = std::fs::read(bench.path("o.vtp")).unwrap();
        let lines = fdem::io::read_mesh(&bytes, "o.vtp").unwrap();
        assert!(!lines.segments.is_empty(), "{files:?}");
    }
    // A sphere has its number, and two ends in its contact with the other one.
    let run = bench.run(&["contacts", "spheres.csv", "floor.stl", "--picture", "p.svg"]).succeeds();
    assert!(run.stderr.contains("written          p.svg"), "{}", run.stderr);
}

/// 38,000 spheres of two sizes at rest in a drum with walls of triangles (Dosta et al., Comput. Phys. Commun.
/// 296 (2024) 109066).
#[test]
fn drum_with_walls() {
    let Some(spheres) = foreign_data("roundrobin/drum/PartCoordinates.txt") else { return };
    let Some(walls) = foreign_data("roundrobin/drum/walls.txt") else { return };
    let (spheres, walls) = (spheres.to_str().unwrap(), walls.to_str().unwrap());
    let bench = Bench::new();
    // The same spheres as a packing on their own.
    let alone = bench.run(&["contacts", spheres, "--count", "-q"]).succeeds().stdout;
    let mut couples = Vec::new();
    for engine in ["multilevel", "direct", "nbs", "rows", "cgrid", "auto"] {
        let options = ["--engine", engine, "--json", "s.json", "--verify", "20", "-o", "c.csv"];
        bench.run(&[&["contacts", spheres, walls], &options[..]].concat()).succeeds();
        let json = bench.json("s.json");
        assert_eq!(json["files"][0]["elements"], 38_000);
        assert_eq!(json["files"][0]["kind"], "spheres");
        assert_eq!(json["files"][1]["kind"], "triangles");
        let kinds = &json["couples_by_kind"];
        assert_eq!(kinds["meshes"], 0);
        let [of_spheres, of_walls] =
            ["spheres", "spheres_and_meshes"].map(|kind| kinds[kind].as_u64().unwrap());
        let text = bench.read("c.csv");
        assert_eq!(text.lines().count() as u64, 1 + of_spheres + of_walls);
        assert_eq!(alone, format!("{of_spheres}\n"));
        // Spheres that are at rest in a drum lie on it.
        assert!(of_walls > 500, "{of_walls}");
        couples.push(text);
    }
    assert!(couples.iter().all(|text| *text == couples[0]), "all engines write identical couples");

    // The data as their readme has them: the quadrant x < 0, z < 0, and the largest distance from the axis y.
    let text = std::fs::read_to_string(spheres).unwrap();
    let rows: Vec<[f64; 4]> = text
        .lines()
        .filter_map(|line| {
            let numbers: Vec<f64> = line.split_whitespace().map_while(|x| x.parse().ok()).collect();
            numbers.try_into().ok()
        })
        .collect();
    assert_eq!(rows.len(), 38_000);
    let in_quadrant =
        |radius: f64| rows.iter().filter(|[r, x, _, z]| *r == radius && *x < 0.0 && *z < 0.0).count();
    assert_eq!((in_quadrant(0.001), in_quadrant(0.002)), (15_047, 3_963));
    let farthest = rows.iter().map(|[r, x, _, z]| r + x.hypot(*z)).fold(0.0, f64::max);
    assert_eq!(format!("{farthest:.7}"), "0.0999995");
}

/// Sets that overlap are no bodies; the summary says so, and how elements were cut.
#[test]
fn the_summary_has_notes_on_mesh_files() {
    let bench = Bench::new();
    let nodes = "*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n5, 0, 2\n";
    bench.write("nodes.inp", nodes);
    let elements = "*Element, type=CPS4\n1, 1, 2, 3, 4\n*Element, type=CPS3\n2, 4, 3, 5\n*Elset, elset=whole\n1, 2\n*Elset, elset=upper\n2\n";
    bench.write("a.inp", format!("*Include, input=nodes.inp\n{elements}"));
    let run = bench.run(&["contacts", "a.inp", "--json", "a.json"]).succeeds();
    for part in [
        "  note           1 quadrilateral is cut into triangles",
        "  note           the element sets whole, upper overlap: the elements are one body",
    ] {
        assert!(run.stderr.contains(part), "{}", run.stderr);
    }
    assert_eq!(bench.json("a.json")["files"][0]["notes"].as_array().map(Vec::len), Some(2));
}

/// The note on sets that overlap once named all of them, which took pages for a file of grains.
#[test]
fn a_note_names_some_of_many_sets() {
    let bench = Bench::new();
    let set = |k: usize| format!("*Elset, elset=poly{k}\n{}\n", 1 + k % 2);
    let sets: String = (1..=1300).map(set).collect();
    let mesh = "*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n*Element, type=CPS3\n1, 1, 2, 3\n2, 1, 3, 4\n";
    bench.write("a.inp", format!("{mesh}{sets}*Elset, elset=all\n1, 2\n"));
    let run = bench.run(&["contacts", "a.inp"]).succeeds();
    let named = "the element sets poly1, poly2, poly3, poly4, poly5, poly6 and 1,295 more overlap: the";
    assert!(run.stderr.contains(named), "{}", run.stderr);
}

/// Elements that are cut when they are read have one contact for each pair of them.
#[test]
fn pairs_of_hexahedra_are_one_row() {
    let bench = Bench::new();
    let hexahedron = |first: usize, low: f64| -> String {
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let nodes = (0..8).map(|k| {
            let [x, y] = corners[k % 4];
            format!("{}, {}, {y}, {}\n", first + k, low + f64::from(x), k / 4)
        });
        nodes.collect()
    };
    let file = |low: f64| {
        format!(
            "*NODE\n{}{}*ELEMENT, TYPE=C3D8R, ELSET=A\n1, 1,2,3,4,5,6,7,8\n*ELEMENT, TYPE=C3D8, ELSET=B\n2, 11,12,13,14,15,16,17,18\n",
            hexahedron(1, 0.0),
            hexahedron(11, low)
        )
    };
    let rows = |text: &str| -> Vec<Vec<String>> {
        text.lines().skip(1).map(|row| row.split(',').map(str::to_owned).collect()).collect()
    };
    // They share a face, or a quarter of their volume.
    for (low, volume, shared, least) in [(1.0, 0.0, 1.0, 0.999), (0.75, 0.25, 0.0, 0.9)] {
        bench.write("hex.inp", file(low));
        let options = ["--body-table", "b.csv", "--json", "s.json", "--verify", "9"];
        let run = bench.run(&[&["contacts", "hex.inp"], &options[..]].concat()).succeeds();
        let found = rows(&run.stdout);
        assert_eq!(found.len(), 1, "{}", run.stdout);
        assert_eq!(found[0][..5], ["1", "2", "0", "1", "volume"]);
        let numbers: Vec<f64> = found[0][5..].iter().map(|number| number.parse().unwrap()).collect();
        assert!((numbers[0] - volume).abs() < 1e-14, "{numbers:?}");
        assert!((numbers[1] - 0.5 * (1.0 + low)).abs() < 1e-14 && numbers[4] > least, "{numbers:?}");
        let bodies = rows(&bench.read("b.csv"));
        assert_eq!(bodies[0][..3], ["0", "1", "1"], "one couple of elements");
        let [overlap, area] = [3, 4].map(|column| bodies[0][column].parse::<f64>().unwrap());
        assert!((overlap - volume).abs() < 1e-14 && (area - shared).abs() < 1e-14, "{bodies:?}");
        let json = bench.json("s.json");
        assert_eq!((&json["couples"], &json["couples_by_kind"]["meshes"]), (&1.into(), &1.into()));
    }
    // Above the diagonal of a square, a sphere touches both halves.
    bench.write("floor.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n");
    bench.write("ball.csv", "x,y,z,radius\n2,2,0.75,1\n");
    let run = bench.run(&["contacts", "floor.obj", "ball.csv", "--verify", "9"]).succeeds();
    assert_eq!(run.stdout.lines().count(), 2, "{}", run.stdout);
    assert!(run.stdout.contains("\n0,0,0,1,depth,0.25,2.0,2.0,0.0,0.0,0.0,1.0\n"), "{}", run.stdout);
}
