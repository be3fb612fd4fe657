//! Sets of mesh files, and elements that are cut.

use std::fmt::Write;

use fdem_io::{BodiesFrom, MeshFile, MeshGroup};

use crate::{fails, names, read};

/// Two triangles of a square.
const SQUARE: &str =
    "*Node\n1, 0, 0\n2, 1, 0\n3, 1, 1\n4, 0, 1\n*Element, type=CPS3\n1, 1, 2, 3\n2, 1, 3, 4\n";

fn group<'a>(mesh: &'a MeshFile, name: &str) -> &'a MeshGroup {
    let found = mesh.groups.iter().find(|group| group.name.as_deref() == Some(name));
    found.unwrap_or_else(|| panic!("no group {name} among {:?}", mesh.groups))
}

#[test]
fn sets_are_groups_beside_the_bodies() {
    let named = SQUARE.replace("CPS3", "CPS3, elset=all");
    let mesh = read("a.inp", format!("{named}*Elset, elset=upper\n2\n"));
    assert_eq!((names(&mesh), mesh.source.bodies_from.clone()), (vec![Some("all")], BodiesFrom::ElementSets));
    assert_eq!((&group(&mesh, "all").triangles, &group(&mesh, "upper").triangles), (&vec![0, 1], &vec![1]));
    let of_sets =
        "*Elset, elset=lower\n1\n*Elset, elset=Upper, generate\n2, 2\n*Elset, elset=whole\nLOWER, upper\n";
    assert_eq!(group(&read("a.inp", format!("{SQUARE}{of_sets}")), "whole").triangles, [0, 1]);
    let nodes = "*Nset, nset=base\n1, 2\n*Nset, nset=roof, generate\n3, 4, 1\n*Nset, nset=of, elset=upper\n";
    let mesh = read("a.inp", format!("{named}*Elset, elset=upper\n2\n{nodes}"));
    assert_eq!((&group(&mesh, "base").nodes, &group(&mesh, "roof").nodes), (&vec![0, 1], &vec![2, 3]));
    assert_eq!(group(&mesh, "of").nodes, [0, 2, 3]);
    let surfaces = "*Surface, name=floor\n1, S1\n*Surface, type=NODE, name=corner\n4\n*Surface, name=free\n1\n*Boundary\n1, 1\n";
    let mesh = read("a.inp", format!("{named}{surfaces}"));
    assert_eq!((&group(&mesh, "floor").edges, &group(&mesh, "corner").nodes), (&vec![[0, 1]], &vec![3]));
    assert_eq!(
        mesh.source.notes(),
        ["a line of the surface free is not used: it names no face, S1, S2, …", "not used: *BOUNDARY"]
    );
}

/// An assembly and its part have a set of one name, with one instance.
#[test]
fn sets_of_one_name_are_noted_and_apart_by_their_instance() {
    let part = format!("*Part, name=P\n{SQUARE}*Nset, nset=base\n1, 2\n*End Part\n");
    let assembly = "*Assembly, name=A\n*Instance, name=I, part=P\n*End Instance\n";
    let mesh = read("a.inp", format!("{part}{assembly}*Nset, nset=BASE, instance=I\n4\n*End Assembly\n"));
    assert_eq!((&group(&mesh, "base").nodes, &group(&mesh, "I.base").nodes), (&vec![0, 1, 3], &vec![0, 1]));
    assert_eq!(
        mesh.source.notes(),
        [
            "several sets have the name base: the group base has all of them, INSTANCE.base those of an instance"
        ]
    );
    let mesh = read("a.inp", format!("{part}{assembly}*Nset, nset=top, instance=I\n4\n*End Assembly\n"));
    assert_eq!((&group(&mesh, "top").nodes, &group(&mesh, "I.base").nodes), (&vec![3], &vec![0, 1]));
    assert!(mesh.source.notes().is_empty());
}

#[test]
fn included_files_are_read_in_their_place() {
    let files = |path: &str| {
        let text = match path {
            "m/nodes/all.txt" => "1, 0, 0\n2, 1, 0\n*Include, input=\"more.txt\"\n",
            "m/nodes/more.txt" => "3, 1, 1\n4, 0, 1\n",
            "m/elements.inp" => "** two triangles\n*Element, type=CPS3, elset=all\n1, 1, 2, 3\n2, 1, 3, 4\n",
            "m/wrong.inp" => "*Element, type=CPS3\n1, 1, 2\n",
            "m/self.inp" => "*Include, input=../m/self.inp\n",
            _ => return Err("there is none".to_owned()),
        };
        Ok(text.as_bytes().to_vec())
    };
    let read = |text: &str| fdem_io::read_mesh_with(text.as_bytes(), "m/a.inp", &mut { files });
    let mesh =
        read("*Node, input=nodes\\all.txt\n*INCLUDE, INPUT=elements.inp\n*Nset, nset=base\n1\n").unwrap();
    assert_eq!((mesh.points.len(), &mesh.triangles.nodes), (4, &vec![[0, 1, 2], [0, 2, 3]]));
    assert_eq!((names(&mesh), &group(&mesh, "base").nodes), (vec![Some("all")], &vec![0]));
    for (text, message) in [
        (
            "*Node\n*Include, input=none.inp\n",
            "m/a.inp:2: *INCLUDE, INPUT=: the file none.inp: there is none",
        ),
        ("*Include, input=wrong.inp\n", "m/a.inp:1: m/wrong.inp:2: element 1 (triangle) has 2 nodes"),
        (
            "*Include, input=self.inp\n",
            "m/a.inp:1: m/self.inp:1: *INCLUDE, INPUT=: the file ../m/self.inp includes itself",
        ),
        ("*Include\n", "m/a.inp:1: *INCLUDE without INPUT="),
    ] {
        assert_eq!(read(text).unwrap_err().to_string(), message);
    }
}

/// Values of cells that a person may have meant as bodies.
#[test]
fn cell_data_that_are_not_used_are_named() {
    let cells = "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n\
        CELLS 2 8\n3 0 1 2\n3 0 2 3\nCELL_TYPES 2\n5 5\nCELL_DATA 2\nSCALARS MaterialId int 1\nLOOKUP_TABLE default\n1 2\n";
    let notes = read("a.vtk", cells).source.notes();
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(
        notes[0].starts_with("cell data not used: MaterialId; bodies are the values of body,"),
        "{notes:?}"
    );
    let bodies = "SCALARS body int 1\nLOOKUP_TABLE default\n1 2\n";
    assert_eq!(read("a.vtk", format!("{cells}{bodies}")).source.notes(), ["cell data not used: MaterialId"]);
    let xml = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">\
        <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points>\
        <Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\
        <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray>\
        <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells>\
        <CellData><DataArray type=\"Float64\" Name=\"stress\" format=\"ascii\">1.5</DataArray></CellData>\
        </Piece></UnstructuredGrid></VTKFile>";
    assert!(read("a.vtu", xml).source.notes()[0].starts_with("cell data not used: stress;"));
}

#[test]
fn sets_of_parts_are_in_each_instance() {
    let part = format!("*Part, name=P\n{SQUARE}*Elset, elset=low\n1\n*End Part\n");
    let alone = read("a.inp", &part);
    assert_eq!(names(&alone), [Some("P")]);
    assert_eq!((alone.groups.len(), &group(&alone, "low").triangles), (1, &vec![0]));
    let instances =
        "*Instance, name=I, part=P\n*End Instance\n*Instance, name=J, part=P\n5, 0\n*End Instance\n";
    let sets = "*Elset, elset=one, instance=J\n2\n*Nset, nset=two\nI.1, J.1\n*Elset, elset=three\nJ.low\n*Elset, elset=four\none, three\n";
    let mesh = read("a.inp", format!("{part}{instances}{sets}"));
    assert_eq!(group(&mesh, "low").triangles, [0, 2]);
    assert_eq!((&group(&mesh, "I.low").triangles, &group(&mesh, "J.low").triangles), (&vec![0], &vec![2]));
    assert_eq!((&group(&mesh, "one").triangles, &group(&mesh, "two").nodes), (&vec![3], &vec![0, 4]));
    assert_eq!((&group(&mesh, "three").triangles, &group(&mesh, "four").triangles), (&vec![2], &vec![2, 3]));
}

/// Sets of sets may grow without bound: 2^24 members from a few lines.
#[test]
fn sets_do_not_outgrow_the_mesh() {
    let rows = vec!["1, 2"; 256].join(", ");
    let doubled = (0..16)
        .map(|k| format!("*Nset, nset=n{}\nn{k}, n{k}, n{k}, n{k}\n", k + 1))
        .collect::<Vec<_>>()
        .concat();
    let error = fails("a.inp", format!("{SQUARE}*Nset, nset=n0\n{rows}\n{doubled}"));
    assert!(error.to_string().contains("the sets have more than 1048576 members"), "{error}");
}

#[test]
fn nodes_are_made_between_others() {
    let made = "*Node\n11, 0, 0\n17, 3, 6\n*Ngen, nset=edge\n11, 17, 2\n*Element";
    let mesh = read("a.inp", SQUARE.replace("*Element", made));
    assert_eq!(mesh.points[6..], [[1.0, 2.0, 0.0], [2.0, 4.0, 0.0]]);
    assert_eq!(group(&mesh, "edge").nodes, [4, 5, 6, 7]);
}

#[test]
fn cohesive_elements_with_a_thickness_are_left_out() {
    let text = "*Element, type=COH2D4, elset=glue\n5, 4, 3, 2, 1\n*Elset, elset=some\n1, 5\n";
    let mesh = read("a.inp", format!("{SQUARE}{text}"));
    assert_eq!((mesh.triangles.len(), &group(&mesh, "some").triangles), (2, &vec![0]));
    assert_eq!(mesh.source.notes(), ["1 cohesive element with a thickness is left out"]);
}

/// Two squares with nodes of their own along their common side.
#[test]
fn cohesive_elements_without_thickness_join_their_sides() {
    let text = "*Node\n1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,1,1\n6,0,1\n7,1,2\n8,0,2\n*Nset, nset=upper\n5, 7\n\
                *Element, type=CPE3, elset=rock\n1,1,2,3\n2,1,3,4\n3,6,5,7\n4,6,7,8\n\
                *Element, type=COH2D4, elset=glue\n5,4,3,5,6\n*Elset, elset=both\n4, 5\n";
    let mesh = read("a.inp", text);
    assert_eq!(mesh.triangles.nodes, [[0, 1, 2], [0, 2, 3], [3, 2, 6], [3, 6, 7]]);
    assert_eq!(mesh.segments.nodes, [[3, 2]]);
    assert_eq!(mesh.bodies[mesh.segments.bodies[0] as usize].name.as_deref(), Some("glue"));
    assert_eq!(group(&mesh, "upper").nodes, [2, 6]);
    assert_eq!((&group(&mesh, "both").triangles, &group(&mesh, "both").segments), (&vec![3], &vec![0]));
    assert_eq!(
        mesh.source.notes(),
        [
            "1 cohesive element is without thickness: the two sides share nodes, and a joint set with group = SET \
          gives them a law"
        ]
    );
}

/// Two cubes: the common face is cut as those of the two cubes are.
#[test]
fn cohesive_elements_between_solids_fit_them() {
    let mut nodes = String::new();
    for (first, low) in [(1, 0.0), (11, 1.0)] {
        for k in 0..8 {
            let [x, y] = [[0, 0], [1, 0], [1, 1], [0, 1]][k % 4];
            writeln!(nodes, "{}, {x}, {y}, {}", first + k, low + (k / 4) as f64).unwrap();
        }
    }
    let text = format!(
        "*Node\n{nodes}*Element, type=C3D8, elset=rock\n1,1,2,3,4,5,6,7,8\n2,11,12,13,14,15,16,17,18\n\
         *Element, type=COH3D8, elset=glue\n3,5,6,7,8,11,12,13,14\n"
    );
    let mesh = read("a.inp", text);
    assert_eq!((mesh.tetrahedra.len(), mesh.triangles.len()), (12, 2));
    for face in &mesh.triangles.nodes {
        let has_face = |nodes: &&[u32; 4]| face.iter().all(|node| nodes.contains(node));
        assert_eq!(mesh.tetrahedra.nodes.iter().filter(has_face).count(), 2, "{face:?}");
    }
}

/// A cube of 8 corners, with the 12 nodes on its edges as a second order element has them.
fn cube(kind: &str, further: &str) -> String {
    let nodes = "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n20,.5,.5,.5\n";
    format!(
        "*Node\n{nodes}*Element, type={kind}, elset=rock\n1,1,2,3,4,5,6,7,8{further}\n*Surface, name=top\n1, S2\n"
    )
}

#[test]
fn solids_of_both_orders_are_cut() {
    let first = read("a.inp", cube("C3D8R", ""));
    let second = read("a.inp", cube("C3D20", &",20".repeat(12)));
    assert_eq!(first.tetrahedra, second.tetrahedra);
    assert_eq!((first.tetrahedra.len(), first.source.cut_solids), (6, 1));
    // The top is cut through its smallest node, as the tetrahedra below it are.
    for face in &group(&first, "top").faces {
        assert!(face.contains(&4), "{face:?}");
        let has_face = |nodes: &[u32; 4]| face.iter().all(|node| nodes.contains(node));
        assert_eq!(first.tetrahedra.nodes.iter().filter(|nodes| has_face(nodes)).count(), 1, "{face:?}");
    }
    assert_eq!(
        second.source.notes(),
        [
            "1 pyramid, wedge or hexahedron is cut into tetrahedra",
            "1 element of second order is taken by the corners alone"
        ]
    );
    let folded = cube("C3D8", "").replace("7,8\n*S", "8,7\n*S");
    assert!(
        fails("a.inp", folded).to_string().contains("element 1 (hexahedron) crosses itself or has no volume")
    );
}

/// The cells of a VTK file list corners in their own orders; all have a positive volume.
#[test]
fn solids_of_vtk_have_positive_volumes() {
    let points = "POINTS 8 float\n0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\n";
    for (nodes, kind, count) in [
        ("8 0 1 2 3 4 5 6 7", 12, 6),
        ("8 0 1 3 2 4 5 7 6", 11, 6),
        ("6 0 3 1 4 7 5", 13, 3),
        ("5 0 1 2 3 4", 14, 2),
        ("10 0 1 2 4 7 7 7 7 7 7", 24, 1),
    ] {
        let numbers = nodes.split(' ').count();
        let text = format!(
            "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n{points}CELLS 1 {numbers}\n{nodes}\nCELL_TYPES 1\n{kind}\n"
        );
        let mesh = read("a.vtk", text);
        assert_eq!(mesh.tetrahedra.len(), count, "{kind}");
        for nodes in &mesh.tetrahedra.nodes {
            let [a, b, c, d] = nodes.map(|node| mesh.points[node as usize]);
            let [p, q, r] = [b, c, d].map(|to| [0, 1, 2].map(|axis| to[axis] - a[axis]));
            let volume = p[0] * (q[1] * r[2] - q[2] * r[1])
                + p[1] * (q[2] * r[0] - q[0] * r[2])
                + p[2] * (q[0] * r[1] - q[1] * r[0]);
            assert!(volume > 0.0, "{kind} {nodes:?}");
        }
    }
}

const CURVES: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 2 the base\n1 3 \"outside\"\n2 1 rock\n$EndPhysicalNames\n\
    $Entities\n0 2 1 0\n1 0 0 0 1 0 0 2 2 3 0\n2 1 0 0 1 1 0 1 3 0\n1 0 0 0 1 1 0 1 1 0\n$EndEntities\n\
    $Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n1 1 0\n$EndNodes\n\
    $Elements\n3 3 1 3\n1 1 1 1\n1 1 2\n1 2 1 1\n2 2 3\n2 1 2 1\n3 1 2 3\n$EndElements\n";

#[test]
fn a_curve_may_be_in_two_physical_groups() {
    let mesh = read("a.msh", CURVES);
    assert_eq!(names(&mesh), [Some("the base"), Some("outside"), Some("rock")]);
    assert_eq!(mesh.segments.bodies, [0, 1]);
    assert_eq!((mesh.groups.len(), &group(&mesh, "outside").segments), (1, &vec![0]));
    // A surface is a body, and in one group.
    let error = fails("a.msh", CURVES.replace("1 0 0 0 1 1 0 1 1 0\n$", "1 0 0 0 1 1 0 2 1 7 0\n$"));
    assert!(error.to_string().contains("physical group 1 (rock) and in physical group 7"), "{error}");
    // Version 2.2 has such a curve twice.
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n\
        $Elements\n3\n1 1 2 1 1 1 2\n2 1 2 2 1 1 2\n3 2 2 1 1 1 2 3\n$EndElements\n";
    assert_eq!(read("a.msh", text).segments.nodes, [[0, 1], [0, 1]]);
}

#[test]
fn parts_of_partitioned_entities_have_their_groups() {
    let parts = "$PartitionedEntities\n2\n1\n9 1\n0 0 2 0\n11 2 1 1 1 0 0 0 1 1 0 1 1 0\n12 2 1 1 2 0 0 0 1 1 0 1 1 0\n$EndPartitionedEntities\n$Nodes";
    let elements = "1 1 1 1\n1 1 2\n1 2 1 1\n2 2 3\n2 1 2 1\n3 1 2 3\n";
    let text = CURVES
        .replace("$Nodes", parts)
        .replace("3 3 1 3\n", "2 2 1 4\n")
        .replace(elements, "2 11 2 1\n3 1 2 3\n2 12 2 1\n4 2 1 3\n");
    let mesh = read("a.msh", &text);
    assert_eq!((names(&mesh), mesh.triangles.len()), (vec![Some("rock")], 2));
    // Without groups, bodies are the entities that the parts are of.
    let mesh = read("a.msh", text.replace(" 0 0 0 1 1 0 1 1 0\n", " 0 0 0 1 1 0 0 0\n"));
    assert_eq!((crate::body_numbers(&mesh), mesh.source.bodies_from), (vec![Some(1)], BodiesFrom::Entities));
}

/// Pixels and voxels are cells; cell data give their bodies.
#[test]
fn structured_points_are_pixels_and_voxels() {
    let file = |dimensions: &str, data: &str| {
        format!(
            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {dimensions}\nORIGIN 1 2 0\n\
             SPACING 0.5 2 3\n{data}"
        )
    };
    let data = "CELL_DATA 2\nSCALARS body int 1\nLOOKUP_TABLE default\n7 9\n";
    let mesh = read("a.vtk", file("3 2 1", data));
    assert_eq!((mesh.dimensions, mesh.points.len(), mesh.triangles.len()), (2, 6, 4));
    assert_eq!((mesh.points[0], mesh.points[5]), ([1.0, 2.0, 0.0], [2.0, 4.0, 0.0]));
    assert_eq!(mesh.bodies.iter().map(|body| body.number).collect::<Vec<_>>(), [Some(7), Some(9)]);
    let mesh = read("a.vtk", file("2 2 3", data));
    assert_eq!((mesh.tetrahedra.len(), mesh.source.cut_solids), (12, 2));
    let volume = |nodes: &[u32; 4]| {
        let [a, b, c, d] = nodes.map(|node| mesh.points[node as usize]);
        let [u, v, w] = [b, c, d].map(|corner| [0, 1, 2].map(|axis| corner[axis] - a[axis]));
        (u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0])
            + u[2] * (v[0] * w[1] - v[1] * w[0]))
            / 6.0
    };
    assert!((mesh.tetrahedra.nodes.iter().map(volume).sum::<f64>() - 6.0).abs() < 1e-12);
    let error = fails("a.vtk", file("1000 1000 1000", data));
    assert!(error.to_string().contains("DIMENSIONS 1000 1000 1000 do not fit the file"), "{error}");
    let error = fails("a.vtk", file("3 1 1", ""));
    assert!(error.to_string().contains("no element that is read"), "{error}");
}
