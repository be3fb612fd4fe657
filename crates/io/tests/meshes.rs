//! Meshes: one mesh gives the same result in every format and encoding; errors are reported; no bytes make a
//! reader panic or allocate much memory.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail like tests")]

#[path = "meshes/files.rs"]
mod files;
#[path = "meshes/sets.rs"]
mod sets;

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use fdem_io::{BodiesFrom, MeshError, MeshFile, MeshFormat, Place, read_mesh};
use files::{POINTS, numbered, solids, surfaces, vtk, xml};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Held by tests that measure memory or use much of it, because the allocator counts all threads.
static ALONE: Mutex<()> = Mutex::new(());

fn read(name: &str, bytes: impl AsRef<[u8]>) -> MeshFile {
    read_mesh(bytes.as_ref(), name).unwrap_or_else(|error| panic!("{error}"))
}

fn fails(name: &str, bytes: impl AsRef<[u8]>) -> MeshError {
    match read_mesh(bytes.as_ref(), name) {
        Err(error) => error,
        Ok(mesh) => panic!("read {mesh:?} from {:?}", String::from_utf8_lossy(bytes.as_ref())),
    }
}

fn names(mesh: &MeshFile) -> Vec<Option<&str>> {
    mesh.bodies.iter().map(|body| body.name.as_deref()).collect()
}

fn body_numbers(mesh: &MeshFile) -> Vec<Option<i64>> {
    mesh.bodies.iter().map(|body| body.number).collect()
}

/// A segment, two triangles, a quadrilateral, a tetrahedron and a point: see `files`.
fn assert_full(label: &str, mesh: &MeshFile) {
    assert_eq!(mesh.points, POINTS, "{label}");
    assert_eq!(mesh.dimensions, 3, "{label}");
    assert_eq!(mesh.segments.nodes, [[0, 1]], "{label}");
    assert_eq!(mesh.segments.bodies, [0], "{label}");
    assert_eq!(mesh.triangles.nodes, [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]], "{label}");
    assert_eq!(mesh.triangles.bodies, [1, 1, 2, 2], "{label}");
    assert_eq!(mesh.tetrahedra.nodes, [[0, 1, 2, 6]], "{label}");
    assert_eq!(mesh.tetrahedra.bodies, [3], "{label}");
    assert_eq!((mesh.source.point_elements, mesh.source.quadrilaterals), (1, 1), "{label}");
}

#[test]
fn gmsh_and_abaqus_are_the_same_mesh() {
    for (label, bytes) in numbered() {
        let mesh = read(&label, &bytes);
        assert_full(&label, &mesh);
        assert_eq!(mesh.segments.numbers, [101], "{label}");
        assert_eq!(mesh.triangles.numbers, [102, 103, 104, 104], "{label}");
        assert_eq!(mesh.tetrahedra.numbers, [105], "{label}");
        if label.ends_with("inp") {
            assert_eq!(mesh.source.bodies_from, BodiesFrom::ElementSets);
            assert_eq!(names(&mesh), [Some("edge"), Some("left"), Some("right"), Some("solid")]);
        } else {
            assert_eq!(mesh.source.bodies_from, BodiesFrom::PhysicalGroups, "{label}");
            assert_eq!(names(&mesh), [None, Some("left"), Some("right"), None], "{label}");
            assert_eq!(body_numbers(&mesh), [Some(11), Some(12), Some(13), Some(14)], "{label}");
        }
    }
}

#[test]
fn vtk_is_the_same_mesh() {
    for (label, bytes) in vtk().into_iter().chain(xml()) {
        let mesh = read(&label, &bytes);
        assert_full(&label, &mesh);
        assert_eq!(mesh.segments.numbers, [0], "{label}");
        assert_eq!(mesh.triangles.numbers, [1, 2, 3, 3], "{label}");
        assert_eq!(mesh.tetrahedra.numbers, [4], "{label}");
        assert_eq!(mesh.source.bodies_from, BodiesFrom::CellData("body_id".into()), "{label}");
        assert_eq!(body_numbers(&mesh), [Some(11), Some(12), Some(13), Some(14)], "{label}");
    }
}

/// Formats of surfaces, where points are shared by number.
#[test]
fn surfaces_are_the_same_mesh() {
    for (label, bytes) in surfaces() {
        let mesh = read(&label, &bytes);
        assert_eq!(mesh.points, POINTS[..6], "{label}");
        assert_eq!(mesh.dimensions, 2, "{label}");
        assert_eq!(mesh.triangles.nodes, [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]], "{label}");
        assert_eq!(mesh.source.quadrilaterals, 1, "{label}");
        match mesh.source.format {
            MeshFormat::Obj => {
                assert_eq!(names(&mesh), [Some("left"), Some("right")], "{label}");
                assert_eq!(mesh.triangles.bodies, [0, 0, 1, 1], "{label}");
            }
            _ => assert_eq!(names(&mesh), [None], "{label}"),
        }
    }
}

/// Formats of triangles with separate corners, which are merged.
#[test]
fn solids_are_welded() {
    for (label, bytes) in solids() {
        let mesh = read(&label, &bytes);
        let named = label.contains("ascii");
        // Two touching solids keep their nodes apart; without solids, equal corners become one node.
        let triangles =
            if named { [[0, 1, 2], [0, 2, 3], [4, 5, 6]] } else { [[0, 1, 2], [0, 2, 3], [1, 4, 5]] };
        assert_eq!(mesh.triangles.nodes, triangles, "{label}");
        assert_eq!(mesh.triangles.numbers, [0, 1, 3], "{label}");
        assert_eq!(mesh.source.collapsed_facets, 1, "{label}");
        if named {
            assert_eq!(names(&mesh), [Some("left part"), None], "{label}");
            assert_eq!(mesh.triangles.bodies, [0, 0, 1], "{label}");
        }
    }
}

#[test]
fn bodies_of_gmsh_without_groups_are_entities() {
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n$EndNodes\n\
                $Elements\n3\n1 1 2 0 7 1 2\n2 2 2 0 7 1 2 3\n3 2 2 0 9 2 4 3\n$EndElements\n";
    let mesh = read("a.msh", text);
    assert_eq!(mesh.dimensions, 2);
    assert_eq!(mesh.source.bodies_from, BodiesFrom::Entities);
    // Curve 7 is not surface 7.
    assert_eq!(body_numbers(&mesh), [Some(7), Some(7), Some(9)]);
    assert_eq!((mesh.segments.bodies, mesh.triangles.bodies), (vec![0], vec![1, 2]));
    let untagged = text.replace(" 2 0 7 ", " 0 ").replace(" 2 0 9 ", " 0 ");
    let mesh = read("a.msh", untagged);
    assert_eq!(mesh.source.bodies_from, BodiesFrom::File);
    assert_eq!(mesh.bodies.len(), 1);
    // Elements in no group form one body if others are in a group.
    let partly = text.replace("2 2 2 0 7", "2 2 2 -5 7");
    assert_eq!(body_numbers(&read("a.msh", partly)), [None, Some(5)]);
}

#[test]
fn instances_of_abaqus_are_moved() {
    let text = "*Heading\n a heading, with *stars\n** a comment\n*Part, name=Grain\n*Node\n 1, 0., 0.\n 2, 1., 0.\n 3, 0., 1.\n\
                *Element, type=CPS3\n 7, 1,\n 2, 3\n*End Part\n*Assembly, name=A\n*Instance, name=\"Grain-1\", part=GRAIN\n\
                *End Instance\n*Instance, name=Grain-2, part=Grain\n 5., 0.25, 0.\n*End Instance\n*Elset, elset=All, instance=Grain-1\n 7\n*End Assembly\n\
                *Material, name=Steel\n*Elastic\n 2e11, 0.3\n";
    let mesh = read("model.inp", text);
    assert_eq!(mesh.source.bodies_from, BodiesFrom::Instances);
    assert_eq!(names(&mesh), [Some("Grain-1"), Some("Grain-2")]);
    assert_eq!(mesh.points[3..], [[5.0, 0.25, 0.0], [6.0, 0.25, 0.0], [5.0, 1.25, 0.0]]);
    assert_eq!(mesh.triangles.nodes, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.triangles.numbers, [7, 7]);
    assert_eq!((mesh.triangles.bodies, mesh.dimensions), (vec![0, 1], 2));
    let parts = text.split("*Assembly").next().unwrap();
    let mesh = read("model.inp", parts);
    assert_eq!((names(&mesh), mesh.source.bodies_from.clone()), (vec![Some("Grain")], BodiesFrom::Parts));
}

#[test]
fn sets_of_abaqus_are_bodies() {
    let mesh = "*NODE\n1,0,0\n2,1,0\n3,0,1\n4,1,1\n*ELEMENT,TYPE=S3\n1,1,2,3\n2,2,4,3\n9,4,3,1\n";
    let sets = format!("{mesh}*ELSET,ELSET=Left\n1\n*ELSET,ELSET=right,GENERATE\n2,9,7\n");
    let read_sets = read("a.inp", sets);
    assert_eq!(names(&read_sets), [Some("Left"), Some("right")]);
    assert_eq!(read_sets.triangles.bodies, [0, 1, 1]);
    // Sets that overlap are groups and no bodies.
    let both = read("a.inp", format!("{mesh}*ELSET,ELSET=A\n1,2\n*ELSET,ELSET=B\n2,9\n"));
    assert_eq!((names(&both), both.source.bodies_from.clone()), (vec![None], BodiesFrom::File));
    let groups: Vec<_> = both.groups.iter().map(|group| group.triangles.clone()).collect();
    assert_eq!(groups, [[0, 1], [1, 2]]);
    assert_eq!(fails("a.inp", format!("{mesh}*ELSET,ELSET=A\n3\n")).line(), Some(11));
}

#[test]
fn models_of_abaqus_that_are_refused() {
    let part = "*PART, NAME=P\n*NODE\n1,0,0\n2,1,0\n3,0,1\n*ELEMENT,TYPE=CPE3\n1,1,2,3\n*END PART\n";
    let instance = "*INSTANCE, NAME=I, PART=P\n1,0,0\n";
    for (text, line, message) in [
        (
            format!("{part}{instance}0,0,0,0,0,1,90\n*END INSTANCE\n"),
            11,
            "a rotated instance: instances may be moved",
        ),
        (
            format!("{part}*PART, NAME=Q\n*END PART\n{instance}*END INSTANCE\n"),
            9,
            "the part Q without an instance",
        ),
        (
            format!("{part}{}", instance.replace("=P", "=Q")),
            9,
            "*INSTANCE names the part 'Q', which is not there",
        ),
        (format!("{part}{instance}*NODE\n1,0,0\n"), 11, "*NODE in an instance: write it in its part"),
        (format!("{part}{part}"), 9, "a part in a part, or two of one name"),
        (
            format!("{INP}*ELSET,ELSET=B\nA\n*ELSET,ELSET=A\n5\n"),
            8,
            "set B names the set 'A', which has no element so far: define a set before",
        ),
        (format!("{INP}*ELSET,ELSET=B\nA\n"), 8, "set B names the set 'A', which is not there"),
        (format!("{INP}*NSET,NSET=B\n4\n"), 8, "set B names node 4, which is not there"),
        (
            format!("{INP}*ELSET,ELSET=B,INSTANCE=I\n5\n"),
            8,
            "set B names the instance 'I', which is not there",
        ),
        (format!("{INP}*SURFACE,NAME=B\n5,S4\n"), 8, "*SURFACE B: element 5 (triangle) has no face S4"),
        (format!("{INP}*NGEN\n1,3,4\n"), 8, "*NGEN goes from node 1 to node 3 in steps of 4"),
        (format!("{INP}*NGEN\n1,9\n"), 8, "*NGEN names node 9, which is not defined so far"),
        (format!("{INP}*NODE\n9000000,1,1\n*NGEN\n1,9000000\n"), 10, "*NGEN makes more than 1048576 nodes"),
        (format!("{INP}*ELSET,ELSET=A,GENERATE\n5,1\n"), 8, "expected first, last and step of a set"),
    ] {
        let error = fails("a.inp", &text);
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(error.line(), Some(line), "{error}");
    }
}

/// The points and cells of pieces follow each other; no cell refers to another piece.
#[test]
fn pieces_of_a_grid() {
    let (from, to) = (VTU.find("<Piece").unwrap(), VTU.find("</UnstructuredGrid>").unwrap());
    let with = |body: &str| {
        let data =
            format!("<CellData><DataArray type=\"Int8\" Name=\"Body\">{body}</DataArray></CellData></Piece>");
        VTU[from..to].replace("</Piece>", &data)
    };
    let file = |pieces: &str| format!("{}{pieces}{}", &VTU[..from], &VTU[to..]);
    let mesh = read("a.vtu", file(&(with("5") + &with("-5"))));
    assert_eq!(mesh.triangles.nodes, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.triangles.numbers, [0, 1]);
    assert_eq!((body_numbers(&mesh), mesh.triangles.bodies), (vec![Some(5), Some(-5)], vec![0, 1]));
    let beyond = fails("a.vtu", file(&(with("5").replace("0 1 2</", "0 1 3</") + &with("5"))));
    assert!(beyond.to_string().contains("element 0 (triangle) names node 3"), "{beyond}");
    let one = fails("a.vtu", file(&(with("5") + &VTU[from..to])));
    assert!(one.to_string().contains("cell data Body has 1 values for 2 cells"), "{one}");
}

#[test]
fn poly_data_number_their_cells_by_kind() {
    let text = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\n\
                POLYGONS 2 8\n3 0 1 2\n3 0 2 3\nLINES 1 4\n3 0 1 2\nVERTICES 1 2\n1 3\nCELL_DATA 4\nSCALARS RegionId float 1\n\
                LOOKUP_TABLE default\n9 8 7 6\nNORMALS n float\n0 0 1 0 0 1 0 0 1 0 0 1\nPOINT_DATA 4\nFIELD f 1\nbody 1 4 int\n1 2 3 4\n";
    let mesh = read("a.vtk", text);
    assert_eq!(mesh.segments.nodes, [[0, 1], [1, 2]]);
    assert_eq!(mesh.segments.numbers, [1, 1]);
    assert_eq!(mesh.triangles.numbers, [2, 3]);
    assert_eq!(body_numbers(&mesh), [Some(8), Some(7), Some(6)]);
    assert_eq!(mesh.source.point_elements, 1);
}

#[test]
fn objects_groups_and_relative_vertices() {
    let text = "# a comment\nv 0 0 0 1.0\nv 1 0 0\nv 0 1 \\\n 0\ng one\nf -3//1 -2/4/1 -1\ng two\nv 5 5 5 0.1 0.2 0.3\nf 1 2 4\ng one\nl 1 2 3\np 1\n";
    let mesh = read("a.obj", text);
    assert_eq!(mesh.source.bodies_from, BodiesFrom::Groups);
    assert_eq!(names(&mesh), [Some("one"), Some("two")]);
    assert_eq!((mesh.triangles.nodes, mesh.triangles.bodies), (vec![[0, 1, 2], [0, 1, 3]], vec![0, 1]));
    assert_eq!((mesh.segments.nodes, mesh.segments.bodies), (vec![[0, 1], [1, 2]], vec![0, 0]));
    assert_eq!(mesh.source.point_elements, 1);
}

/// The first byte of the length of raw data may equal a blank: 32 bytes.
#[test]
fn raw_data_may_start_with_a_blank() {
    let head = "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">\
        <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Cells>\
        <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray>\
        <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells><CellData><DataArray type=\"Int32\" Name=\"body\" format=\"appended\" offset=\"36\"/>\
        </CellData></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">\n _";
    let mut bytes = head.as_bytes().to_vec();
    bytes.extend(32_u32.to_le_bytes());
    bytes.extend([0xff; 32]);
    bytes.extend(4_u32.to_le_bytes());
    bytes.extend(9_i32.to_le_bytes());
    bytes.extend(b"\n</AppendedData></VTKFile>");
    assert_eq!(body_numbers(&read("a.vtu", &bytes)), [Some(9)]);
    let at = head.len();
    let shifted = [&bytes[..at], &bytes[at + 36..]].concat();
    let offset = String::from_utf8_lossy(&shifted).replace("offset=\"36\"", "offset=\"0\"");
    assert_eq!(body_numbers(&read("a.vtu", offset)), [Some(9)]);
}

#[test]
fn formats_by_content_then_name() {
    let mut solid = solids().into_iter().find(|(label, _)| label.contains("binary")).unwrap().1;
    solid[..5].copy_from_slice(b"solid");
    for (bytes, name, format) in [
        (&solid[..], "x", Some(MeshFormat::Stl)),
        (b"solid\nfacet normal", "x", Some(MeshFormat::Stl)),
        (b"\n$MeshFormat\n", "x.csv", Some(MeshFormat::Gmsh)),
        (b"# made by hand\n\nmtllib a.mtl\no A\nv 0 0 0\n", "x.txt", Some(MeshFormat::Obj)),
        (b"** c\n*Heading\n", "x", Some(MeshFormat::Abaqus)),
        (b"<?xml version=\"1.0\"?>\n<VTKFile>", "x", Some(MeshFormat::VtkXml)),
        (b"\xef\xbb\xbfply\n", "x", Some(MeshFormat::Ply)),
        (b"", "A.PLY", Some(MeshFormat::Ply)),
        (b"", "stl", None),
        (b"x,y,z,radius\n0,0,0,1\n", "x.csv", None),
        (b"v x y\n0 0 0\n", "x.csv", None),
        (b"solid fraction\n0.5\n", "x.csv", None),
        (b"# x y z\n0 0 0\n", "x", None),
        (b"***\n0 0 0\n", "x", None),
        (b"<svg/>", "x", None),
        (b"\x93NUMPY\x01\0", "x.npy", None),
    ] {
        assert_eq!(MeshFormat::of(bytes, name), format, "{:?} {name}", String::from_utf8_lossy(bytes));
    }
    assert_eq!(
        fails("a.csv", "x,y\n0,1\n").to_string(),
        "a.csv: no mesh: expected Gmsh .msh, STL, OBJ, PLY, VTK, VTU, VTP or Abaqus .inp, found 'x,y'"
    );
}

const MSH: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n5 2 2 1 1 1 2 3\n$EndElements\n";
const MSH_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n7 0 0 0 1 1 0 1 3 0\n$EndEntities\n$Nodes\n1 3 1 3\n2 7 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n\
                     $Elements\n1 1 5 5\n2 7 2 1\n5 1 2 3\n$EndElements\n";
const INP: &str = "*NODE\n1,0,0\n2,1,0\n3,0,1\n*ELEMENT,TYPE=S3\n5,1,2,3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                   property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
const VTK: &str = "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0\n1 0 0\n0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n";
const VTU: &str = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>\n<Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">\n\
                   <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">0 0 0 1 0 0 0 1 0</DataArray></Points>\n\
                   <Cells><DataArray type=\"Int32\" Name=\"connectivity\">0 1 2</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\">3</DataArray>\n\
                   <DataArray type=\"UInt8\" Name=\"types\">5</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>\n";
const TABLE: &str = "vertex1_X[m] vertex1_Y[m] vertex1_Z[m] vertex2_X[m] vertex2_Y[m] vertex2_Z[m] vertex3_X[m] vertex3_Y[m] vertex3_Z[m]\n0 0 0 1 0 0 0 1 0\n";

/// The name and content of a good file, a replacement in it, the line of the error, and the required part of
/// the message.
type Wrong = (&'static str, &'static str, &'static str, &'static str, u64, &'static str);

const WRONG: &[Wrong] = &[
    (
        "a.msh",
        MSH,
        "1 1 2 3\n",
        "1 1 2 4\n",
        12,
        "element 5 (triangle) names node 4, which the file does not have",
    ),
    ("a.msh", MSH, "1 1 2 3\n", "1 1 2 2\n", 12, "element 5 (triangle) names node 2 twice"),
    ("a.msh", MSH, "3 0 1 0\n", "2 0 1 0\n", 8, "node 2 is defined twice"),
    ("a.msh", MSH, "2 1 0 0\n", "2 1 nan 0\n", 7, "node 2: coordinate y is not a finite number"),
    ("a.msh", MSH, "2 1 0 0\n", "2 1 0 1e999\n", 7, "node 2: coordinate z is not a finite number"),
    ("a.msh", MSH, "2 1 0 0\n", "2 1 O 0\n", 7, "expected a number, found 'O'"),
    (
        "a.msh",
        MSH,
        "Nodes\n3\n",
        "Nodes\n4\n",
        9,
        "number of a node: expected a whole number, found '$EndNodes'",
    ),
    ("a.msh", MSH, "Nodes\n3\n", "Nodes\n2\n", 8, "expected $EndNodes, found '3'"),
    ("a.msh", MSH, "Nodes\n3\n", "Nodes\n-3\n", 5, "-3 is negative"),
    ("a.msh", MSH, "Nodes\n3\n", "Nodes\n300000000000\n", 5, "number of nodes: 300000000000, with"),
    ("a.msh", MSH, "5 2 2", "5 21 2", 12, "element 5 is of Gmsh's type 21"),
    ("a.msh", MSH, "5 2 2", "5 5 2", 13, "node of an element: expected a whole number, found '$EndElements'"),
    ("a.msh", MSH, "2.2 0 8", "4 0 8", 2, "version '4' of the format: save as 4.1 or 2.2"),
    ("a.msh", MSH, "$EndElements\n", "", 13, "the file ends here: expected $EndElements"),
    ("a.msh", MSH, "$Nodes", "$ParametricNodes", 4, "$ParametricNodes: save the mesh without"),
    (
        "a.msh",
        MSH,
        "1\n5 2 2 1 1 1 2 3",
        "2\n5 2 2 1 1 1 2 3\n6 2 2 2 1 1 2 3",
        13,
        "physical group 1 and in physical group 2",
    ),
    ("a.msh", MSH, "$Nodes", "$NOD", 4, "version 1 of the format: save as 4.1 or 2.2"),
    ("a.msh", MSH_4, " 1 3 0\n$", " 1 3 0 0\n$", 6, "expected $EndEntities, found '0'"),
    (
        "a.msh",
        MSH_4,
        "1 3 0\n$",
        "2 3 4 0\n$",
        20,
        "entity 7 of dimension 2 is in physical group 3 and in physical group 4",
    ),
    ("a.msh", MSH_4, "1 3 1 3\n2", "1 4 1 3\n2", 16, "expected 4 nodes, found 3"),
    ("a.msh", MSH_4, "1 1 5 5\n2", "1 2 5 5\n2", 21, "expected 2 elements, found 1"),
    (
        "a.msh",
        MSH_4,
        "$EndElements\n",
        "$EndElements\n$Entities\n0 0 0 0\n$EndEntities\n",
        24,
        "$Entities behind $Elements",
    ),
    ("a.msh", MSH_4, "5 1 2 3", "5 1 2 9", 21, "element 5 (triangle) names node 9"),
    ("a.msh", MSH_4, "2 7 0 3", "2 7 2 3", 10, "expected 0 or 1 for parametric nodes"),
    (
        "a.msh",
        MSH_4,
        "$Entities\n",
        "$PartitionedEntities\n2\n1000\n",
        6,
        "number of ghost entities: 1000, with",
    ),
    ("a.inp", INP, "5,1,2,3", "5,1,2,4", 6, "element 5 (triangle) names node 4"),
    ("a.inp", INP, "5,1,2,3", "5,1,2", 6, "element 5 (triangle) has 2 nodes"),
    ("a.inp", INP, "5,1,2,3", "5,1,2,", 6, "element 5 ends too early"),
    ("a.inp", INP, "5,1,2,3", "4,1,2,\n*ELEMENT, TYPE=S3\n5,1,2,3", 6, "element 4 ends too early"),
    ("a.inp", INP, "5,1,2,3", "5,1,2,3,1", 6, "element 5 has more than 3 nodes"),
    ("a.inp", INP, "5,1,2,3", "5,1,2,3\n5,1,2,3", 7, "element 5 is defined twice"),
    ("a.inp", INP, "TYPE=S3", "TYPE=C3D27", 5, "elements of type C3D27"),
    ("a.inp", INP, "TYPE=S3", "TYPE=C3D8R", 6, "element 5 (hexahedron) has 3 nodes"),
    ("a.inp", INP, ",TYPE=S3", "", 5, "*ELEMENT without TYPE="),
    ("a.inp", INP, "2,1,0\n", "2,1,inf\n", 3, "node 2: coordinate y is not a finite number"),
    ("a.inp", INP, "2,1,0\n", "1,1,0\n", 3, "node 1 is defined twice"),
    ("a.inp", INP, "*NODE\n", "*NODE, SYSTEM=C\n", 1, "*NODE, SYSTEM=: write rectangular coordinates"),
    ("a.inp", INP, "*NODE\n", "*INCLUDE, INPUT=b.inp\n*NODE\n", 1, "*INCLUDE, INPUT=: the file b.inp"),
    ("a.inp", INP, "*NODE\n", "*NODE, INPUT=b.inp\n", 1, "*NODE, INPUT=: the file b.inp"),
    ("a.inp", INP, "*ELEMENT", "*NFILL\n1,3,1\n*ELEMENT", 5, "*NFILL: write nodes"),
    ("a.ply", PLY, "3 0 1 2\n", "3 0 1 3\n", 13, "element 0 (triangle) names node 3"),
    ("a.ply", PLY, "3 0 1 2\n", "3 0 1 -1\n", 13, "element 0 (triangle) names node -1"),
    ("a.ply", PLY, "3 0 1 2\n", "5 0 1 2 0 1\n", 13, "element 0 (polygon) names node 0 twice"),
    ("a.ply", PLY, "3 0 1 2\n", "4 0 1 2\n", 13, "face 0: no value of vertex_indices"),
    ("a.ply", PLY, "3 0 1 2\n", "3 0 1 2 7\n", 13, "face 0: more values than properties"),
    ("a.ply", PLY, "1 0 0\n", "1 0 -inf\n", 11, "node 1: coordinate z is not a finite number"),
    ("a.ply", PLY, "end_header\n", "", 9, "expected format, element, property, comment or end_header: 0 0 0"),
    ("a.ply", PLY, "property float y\n", "", 3, "expected one element vertex, with x and y"),
    ("a.ply", PLY, "format ascii 1.0", "format ascii 2.0", 2, "expected format, element"),
    ("a.ply", PLY, "face 1", "face 2", 14, "the file ends here: expected face 1"),
    ("a.obj", OBJ, "f 1 2 3", "f 1 2 0", 4, "vertices are counted from 1, found 0"),
    ("a.obj", OBJ, "f 1 2 3", "f 1 2 -4", 4, "vertex -4 of the 3 so far"),
    ("a.obj", OBJ, "f 1 2 3", "f 1 2", 4, "element 0 is a polygon of 2 corners"),
    ("a.obj", OBJ, "f 1 2 3", "f 1 2 3 1", 4, "element 0 (quadrilateral) names node 1 twice"),
    ("a.obj", OBJ, "f 1 2 3", "v 1 1 0\nf 1 4 2 3", 5, "element 0 (quadrilateral) crosses itself"),
    (
        "a.obj",
        OBJ,
        "f 1 2 3",
        "v 0.17365 0.5 0.98481\nf 1 2 3 4",
        5,
        "(quadrilateral) is folded by 100 degrees",
    ),
    ("a.obj", OBJ, "f 1 2 3", "f 1 2 \\", 5, "the file ends here: expected the rest of a line after '\\'"),
    ("a.obj", OBJ, "v 1 0 0", "v 1 0", 2, "expected x, y and z of a vertex, found 2 numbers"),
    ("a.obj", OBJ, "f 1 2 3", "cstype bezier", 4, "the statement 'cstype'"),
    ("a.stl", STL, "vertex 1 0 0\n", "", 6, "expected 'vertex' three times, then 'endloop', found 'endloop'"),
    ("a.stl", STL, "endsolid a\n", "", 9, "the file ends here: expected 'facet' or 'endsolid'"),
    ("a.stl", STL, "vertex 1 0 0", "vertex 1 0", 5, "the vertex has no z"),
    ("a.stl", STL, "vertex 1 0 0", "vertex 1 nan 0", 2, "node 1: coordinate y is not a finite number"),
    ("a.vtk", VTK, "3 0 1 2", "3 0 1 3", 9, "element 0 (triangle) names node 3"),
    ("a.vtk", VTK, "3 0 1 2", "4 0 1 2", 10, "a cell of 4 nodes"),
    ("a.vtk", VTK, "\n5\n", "\n12\n", 9, "element 0 is a hexahedron of 3 nodes"),
    ("a.vtk", VTK, "\n5\n", "\n22\n", 9, "element 0 (VTK's type 22) has 3 nodes"),
    ("a.vtk", VTK, "\n5\n", "\n42\n", 9, "element 0 is a polyhedron"),
    ("a.vtk", VTK, "\n5\n", "\n9\n", 9, "element 0 is a quadrilateral of 3 nodes"),
    ("a.vtk", VTK, "CELL_TYPES 1\n5\n", "", 9, "0 types for 1 cells"),
    ("a.vtk", VTK, "UNSTRUCTURED_GRID", "STRUCTURED_GRID", 4, "the data set STRUCTURED_GRID"),
    ("a.vtk", VTK, "3 float", "3 string", 5, "values of type 'string'"),
    ("a.vtu", VTU, "0 1 2</", "0 1 3</", 2, "element 0 (triangle) names node 3"),
    ("a.vtu", VTU, "Points=\"3", "Points=\"4", 3, "coordinates: expected 12, found 9"),
    ("a.vtu", VTU, "<Points>", "<Point>", 3, "XML: expected 'Point' tag, not 'Points'"),
    (
        "a.vtu",
        VTU,
        "type=\"U",
        "compressor=\"vtkLZ4DataCompressor\" type=\"U",
        1,
        "the compressor vtkLZ4DataCompressor",
    ),
    ("a.vtu", VTU, "0 1 0</", "0 1 x</", 3, "expected a number, found 'x'"),
    ("a.txt", TABLE, "0 1 0\n", "0 1\n", 2, "expected 9 numbers, found 8 numbers"),
    ("a.txt", TABLE, "0 1 0\n", "0 1 inf\n", 2, "node 2: coordinate z is not a finite number"),
];

#[test]
fn what_is_wrong_is_said() {
    let mut wrong = Vec::new();
    for &(name, good, from, to, line, message) in WRONG {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from:?} is not in the file");
        assert_eq!(read(name, good).triangles.len(), 1);
        let error = fails(name, &bad);
        let text = error.to_string();
        if error.line() != Some(line)
            || !text.starts_with(&format!("{name}:{line}: "))
            || !text.contains(message)
        {
            wrong.push(format!("{from:?} to {to:?}: {text}"));
        }
    }
    assert_eq!(wrong, Vec::<String>::new());
}

#[test]
fn meshes_without_elements() {
    for (name, text, message) in [
        ("a.stl", "solid\nendsolid\n", "the STL file has 0 nodes and no element that is read"),
        ("a.obj", "v 0 0 0\n", "the OBJ file has 1 node and no element that is read"),
        ("a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "the file ends here: expected $Nodes"),
        ("a.msh", "", "the file ends here: expected $MeshFormat"),
        (
            "a.inp",
            "*NODE\n1,0,0\n*ELEMENT,TYPE=MASS\n1,1\n",
            "the Abaqus file has 1 node and no element that is read",
        ),
        ("a.stl", "", "the file ends here: expected 84 bytes of header"),
    ] {
        let error = fails(name, text);
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn binary_errors_name_the_byte() {
    let (_, stl) = solids().into_iter().find(|(label, _)| label.contains("binary")).unwrap();
    let mut bad = stl.clone();
    bad[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = fails("a.stl", &bad);
    assert_eq!(error.place, Place::Byte(134));
    assert_eq!(error.to_string(), "a.stl: at byte 134: node 0: coordinate x is not a finite number");
    let error = fails("a.stl", &stl[..stl.len() - 1]);
    assert!(error.to_string().contains("4 facets take 200 bytes, found 199"), "{error}");
}

/// Nested more deeply than any stack allows.
#[test]
fn deep_xml() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let deep = "<VTKFile>".repeat(200_000);
    assert!(read_mesh(deep.as_bytes(), "a.vtu").is_err());
    let closed = format!("{deep}{}", "</VTKFile>".repeat(200_000));
    assert!(read_mesh(closed.as_bytes(), "a.vtu").is_err());
}

fn all_files() -> Vec<(String, Vec<u8>)> {
    let texts = [
        ("a.msh", MSH),
        ("a.msh", MSH_4),
        ("a.inp", INP),
        ("a.ply", PLY),
        ("a.obj", OBJ),
        ("a.stl", STL),
        ("a.vtk", VTK),
        ("a.vtu", VTU),
        ("a.txt", TABLE),
    ];
    let mut files: Vec<(String, Vec<u8>)> =
        texts.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())).to_vec();
    files.extend(numbered());
    files.extend(vtk());
    files.extend(xml());
    files.extend(surfaces());
    files.extend(solids());
    files
}

/// Reads a possibly damaged file: gives an error with a message, or a consistent mesh, within little memory.
fn survives(name: &str, bytes: &[u8]) {
    /// More than a thousand times the largest of the files, which is the highest ratio of deflate.
    const BYTES: usize = 16 << 20;
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    match read_mesh(bytes, name) {
        Err(error) => {
            let text = error.to_string();
            assert!(!text.contains(char::is_control) && text.len() < 1000, "{text:?}");
        }
        Ok(mesh) => {
            let nodes = mesh.points.len() as u32;
            let flat = |nodes: &[u32]| nodes.to_vec();
            let used = [
                flat(mesh.segments.nodes.as_flattened()),
                flat(mesh.triangles.nodes.as_flattened()),
                flat(mesh.tetrahedra.nodes.as_flattened()),
            ];
            assert!(used.iter().flatten().all(|&node| node < nodes));
            assert!(used.iter().any(|used| !used.is_empty()));
            assert!(mesh.points.as_flattened().iter().all(|value| value.is_finite()));
            let bodies = [&mesh.segments.bodies, &mesh.triangles.bodies, &mesh.tetrahedra.bodies];
            assert!(bodies.into_iter().flatten().all(|&body| (body as usize) < mesh.bodies.len()));
        }
    }
    let peak = MEMORY.peak_usage().saturating_sub(before);
    assert!(peak < BYTES, "{name}: {peak} bytes for a file of {}", bytes.len());
}

#[test]
fn cut_files() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for (name, bytes) in all_files() {
        for length in 0..bytes.len() {
            survives(&name, &bytes[..length]);
        }
    }
}

/// Text that causes problems in headers and counts.
const TROUBLE: [&[u8]; 12] = [
    b"-1",
    b"0",
    b"4294967296",
    b"18446744073709551615",
    b"9223372036854775807",
    b"1e999",
    b"nan",
    b"\n",
    b" ",
    b"\"",
    b"\xff\xff\xff\xff",
    b"\x00\x00\x00\x80",
];

#[test]
fn mutated_files() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    // SplitMix64, so that a failure can be reproduced.
    let mut state = 7_u64;
    let mut random = move |below: usize| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % below.max(1) as u64) as usize
    };
    for (name, bytes) in all_files() {
        for _ in 0..4000 {
            let mut bad = bytes.clone();
            for _ in 0..=random(3) {
                let at = random(bad.len());
                match random(6) {
                    0 => bad[at] ^= 1 << random(8),
                    1 => bad[at] = random(256) as u8,
                    2 => bad.truncate(at + 1),
                    3 => {
                        let end = bad.len().min(at + 1 + random(20));
                        let piece = bad[at..end].to_vec();
                        let to = random(bad.len());
                        bad.splice(to..to, piece);
                    }
                    4 => {
                        let end = bad.len().min(at + 1 + random(8));
                        bad.splice(at..end, TROUBLE[random(TROUBLE.len())].iter().copied());
                    }
                    _ => {
                        // Replaces an integer by another one.
                        let start =
                            bad[at..].iter().position(u8::is_ascii_digit).map_or(at, |digit| at + digit);
                        let digits = bad[start..].iter().take_while(|byte| byte.is_ascii_digit()).count();
                        bad.splice(start..start + digits, TROUBLE[random(6)].iter().copied());
                    }
                }
                if bad.is_empty() {
                    break;
                }
            }
            survives(&name, &bad);
        }
    }
}

/// Triangle walls of the DEM round robin, or `None` with a note if the data are not available.
fn walls(path: &str) -> Option<String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/roundrobin").join(path);
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(text),
        Err(error) => {
            eprintln!("SKIPPED: {}: {error}", path.display());
            None
        }
    }
}

/// The same walls as a table, as STL text and as binary STL.
#[test]
fn walls_of_the_round_robin() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for (path, triangles) in WALLS {
        let Some(text) = walls(path) else { return };
        let table = read("walls.txt", &text);
        assert_eq!(table.source.format, MeshFormat::Triangles);
        assert_eq!((table.triangles.len() as u64, table.source.collapsed_facets), triangles, "{path}");
        assert_eq!(
            triangles.0 + triangles.1,
            text.lines().filter(|line| !line.trim().is_empty()).count() as u64 - 1
        );

        let (mut stl, mut binary, mut facets) = ("solid walls\n".to_owned(), vec![0; 80], 0_u32);
        let mut data = Vec::new();
        for row in text.lines().skip(1).filter(|line| !line.trim().is_empty()) {
            let values: Vec<&str> = row.split_whitespace().collect();
            stl += "facet normal 0 0 0\nouter loop\n";
            data.extend([0; 12]);
            for corner in values.chunks(3) {
                stl.extend(["vertex ", &corner.join(" "), "\n"]);
                data.extend(corner.iter().flat_map(|value| value.parse::<f32>().unwrap().to_le_bytes()));
            }
            stl += "endloop\nendfacet\n";
            data.extend([0; 2]);
            facets += 1;
        }
        stl += "endsolid walls\n";
        binary.extend(facets.to_le_bytes());
        binary.extend(data);
        let ascii = read("walls.stl", &stl);
        assert_eq!((&ascii.points, &ascii.triangles), (&table.points, &table.triangles), "{path}");
        let binary = read("walls.stl", &binary);
        let corner =
            |mesh: &MeshFile, at: usize, node: usize| mesh.points[mesh.triangles.nodes[at][node] as usize];
        assert_eq!(binary.triangles.numbers, table.triangles.numbers, "{path}");
        for at in 0..binary.triangles.len() {
            for node in 0..3 {
                let single = corner(&table, at, node).map(|value| f64::from(value as f32));
                assert_eq!(corner(&binary, at, node), single, "{path}: triangle {at}");
            }
        }
    }
}

/// Number of triangles and of facets without area in each file.
const WALLS: [(&str, (u64, u64)); 4] = [
    ("drum/walls.txt", (1200, 0)),
    ("penetration/walls.txt", (56, 0)),
    ("silo/walls_large_orifice.txt", (7632, 0)),
    ("silo/walls_small_orifice.txt", (8636, 0)),
];
