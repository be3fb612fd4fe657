//! One small mesh, written in every supported format and encoding.

#![allow(clippy::cast_possible_wrap, reason = "numbers of a small mesh")]

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Files with names that state format and encoding.
type Files = Vec<(String, Vec<u8>)>;

/// All of them are exact as 32-bit floats.
pub(crate) const POINTS: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [2.0, 0.0, 0.0],
    [2.0, 1.0, 0.0],
    [0.5, 0.5, -1.25],
];

/// An element with its numbers in each format.
struct Element {
    gmsh: i32,
    vtk: u8,
    abaqus: &'static str,
    dimension: i32,
    body: i32,
    set: &'static str,
    nodes: &'static [usize],
}

const ELEMENTS: [Element; 6] = [
    Element { gmsh: 1, vtk: 3, abaqus: "T3D2", dimension: 1, body: 11, set: "edge", nodes: &[0, 1] },
    Element { gmsh: 2, vtk: 5, abaqus: "S3R", dimension: 2, body: 12, set: "left", nodes: &[0, 1, 2] },
    Element { gmsh: 2, vtk: 5, abaqus: "S3R", dimension: 2, body: 12, set: "left", nodes: &[0, 2, 3] },
    Element { gmsh: 3, vtk: 9, abaqus: "CPS4R", dimension: 2, body: 13, set: "right", nodes: &[1, 4, 5, 2] },
    Element { gmsh: 4, vtk: 10, abaqus: "C3D4", dimension: 3, body: 14, set: "solid", nodes: &[0, 1, 2, 6] },
    Element { gmsh: 15, vtk: 1, abaqus: "MASS", dimension: 0, body: 15, set: "mass", nodes: &[3] },
];

/// Node numbers with gaps, in descending order.
fn node(index: usize) -> usize {
    75 - 10 * index
}

/// Writes numbers as text or as bytes.
struct Out {
    bytes: Vec<u8>,
    binary: Option<bool>,
}

impl Out {
    /// Writes text, or binary with the high byte first or last.
    fn new(binary: Option<bool>) -> Self {
        Self { bytes: Vec::new(), binary }
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }

    fn put<const N: usize>(&mut self, text: &str, mut bytes: [u8; N]) {
        match self.binary {
            None => self.text(&format!("{text} ")),
            Some(big) => {
                if big {
                    bytes.reverse();
                }
                self.bytes.extend(bytes);
            }
        }
    }

    fn ints(&mut self, values: impl IntoIterator<Item = i32>) {
        for value in values {
            self.int(value);
        }
    }

    fn wides(&mut self, values: impl IntoIterator<Item = usize>) {
        for value in values {
            self.wide(value);
        }
    }

    fn points(&mut self, points: impl IntoIterator<Item = [f64; 3]>) {
        for point in points {
            self.point(point);
        }
    }

    fn byte(&mut self, value: u8) {
        self.put(&value.to_string(), [value]);
    }

    fn int(&mut self, value: i32) {
        self.put(&value.to_string(), value.to_le_bytes());
    }

    fn wide(&mut self, value: usize) {
        self.put(&value.to_string(), (value as u64).to_le_bytes());
    }

    fn real(&mut self, value: f64) {
        self.put(&value.to_string(), value.to_le_bytes());
    }

    fn single(&mut self, value: f64) {
        self.put(&value.to_string(), (value as f32).to_le_bytes());
    }

    /// Ends a line; binary data have no lines.
    fn end(&mut self) {
        if self.binary.is_none() {
            self.text("\n");
        }
    }

    fn point(&mut self, point: [f64; 3]) {
        for value in point {
            self.real(value);
        }
        self.end();
    }
}

const ENCODINGS: [(&str, Option<bool>); 3] = [("ascii", None), ("little", Some(false)), ("big", Some(true))];

/// Formats that number nodes and elements: Gmsh and Abaqus.
pub(crate) fn numbered() -> Files {
    let mut files = Vec::new();
    for (encoding, binary) in ENCODINGS {
        files.push((format!("gmsh 2.2 {encoding}.msh"), gmsh_2(binary)));
        files.push((format!("gmsh 4.1 {encoding}.msh"), gmsh_4(binary)));
    }
    files.push(("abaqus.inp".into(), abaqus().into_bytes()));
    files
}

fn gmsh_head(out: &mut Out, version: &str) {
    out.text(&format!("$MeshFormat\n{version} {} 8\n", i32::from(out.binary.is_some())));
    if out.binary.is_some() {
        out.int(1);
        out.text("\n");
    }
    out.text("$EndMeshFormat\n$Comments\nby hand\n$EndComments\n$PhysicalNames\n2\n2 12 \"left\"\n2 13 \"right\"\n$EndPhysicalNames\n");
}

fn gmsh_2(binary: Option<bool>) -> Vec<u8> {
    let mut out = Out::new(binary);
    gmsh_head(&mut out, "2.2");
    out.text("$Nodes\n7\n");
    for (index, point) in POINTS.into_iter().enumerate() {
        out.int(node(index) as i32);
        out.point(point);
    }
    out.text("\n$EndNodes\n$Elements\n6\n");
    for (number, element) in (101..).zip(&ELEMENTS) {
        let tags = [element.body, 1];
        if binary.is_some() {
            out.ints([element.gmsh, 1, 2, number]);
        } else {
            out.ints([number, element.gmsh, 2]);
        }
        out.ints(tags);
        for &index in element.nodes {
            out.int(node(index) as i32);
        }
        out.end();
    }
    out.text("\n$EndElements\n$NodeData\nskipped\n$EndNodeData\n");
    out.bytes
}

fn gmsh_4(binary: Option<bool>) -> Vec<u8> {
    let mut out = Out::new(binary);
    gmsh_head(&mut out, "4.1");
    out.text("$Entities\n");
    // One entity per element; two of the triangles share a group.
    let of =
        |dimension: i32| ELEMENTS.iter().zip(1..).filter(move |(element, _)| element.dimension == dimension);
    for dimension in 0..4 {
        out.wide(of(dimension).count());
    }
    out.end();
    for dimension in 0..4 {
        for (element, tag) in of(dimension) {
            out.int(tag);
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                out.real(0.5);
            }
            out.wide(1);
            out.int(element.body);
            if dimension > 0 {
                out.wide(1);
                out.int(-tag);
            }
            out.end();
        }
    }
    out.text("\n$EndEntities\n$Nodes\n");
    out.wides([2, 7, 1, 75]);
    out.end();
    // The second block has parameters.
    for (dimension, range) in [(3, 0..4), (2, 4..7)] {
        let parametric = i32::from(dimension == 2);
        out.ints([dimension, 1, parametric]);
        out.wide(range.len());
        out.end();
        for index in range.clone() {
            out.wide(node(index));
        }
        out.end();
        for index in range {
            out.point(POINTS[index]);
            for _ in 0..2 * parametric {
                out.real(0.25);
            }
        }
    }
    out.text("\n$EndNodes\n$Elements\n");
    out.wides([6, 6, 101, 106]);
    out.end();
    for (tag, element) in (1..).zip(&ELEMENTS) {
        out.ints([element.dimension, tag, element.gmsh]);
        out.wide(1);
        out.end();
        out.wide(100 + tag as usize);
        for &index in element.nodes {
            out.wide(node(index));
        }
        out.end();
    }
    out.text("\n$EndElements\n");
    out.bytes
}

fn abaqus() -> String {
    let mut text = "*Heading\nby hand\n*Node\n".to_owned();
    for (index, [x, y, z]) in POINTS.into_iter().enumerate() {
        writeln!(text, " {}, {x}, {y}, {z}", node(index)).unwrap();
    }
    for (number, element) in (101..).zip(&ELEMENTS) {
        let nodes: Vec<String> = element.nodes.iter().map(|&index| node(index).to_string()).collect();
        writeln!(
            text,
            "*Element, type={},\n elset={}\n{number}, {}",
            element.abaqus,
            element.set,
            nodes.join(", ")
        )
        .unwrap();
    }
    text
}

/// Legacy VTK.
pub(crate) fn vtk() -> Files {
    let mut files = Vec::new();
    for (encoding, binary) in [("ASCII", None), ("BINARY", Some(true))] {
        for version in ["3.0", "5.1"] {
            files.push((format!("legacy {version} {encoding}.vtk"), vtk_legacy(version, encoding, binary)));
        }
    }
    files
}

fn vtk_legacy(version: &str, encoding: &str, binary: Option<bool>) -> Vec<u8> {
    let mut out = Out::new(binary);
    let nodes: usize = ELEMENTS.iter().map(|element| element.nodes.len()).sum();
    out.text(&format!(
        "# vtk DataFile Version {version}\nby hand\n{encoding}\nDATASET UNSTRUCTURED_GRID\nPOINTS 7 double\n"
    ));
    out.points(POINTS);
    out.text("\nMETADATA\nINFORMATION 0\n\n");
    if version == "5.1" {
        out.text(&format!("CELLS 7 {nodes}\nOFFSETS vtktypeint64\n"));
        let mut end = 0;
        out.wide(0);
        for element in &ELEMENTS {
            end += element.nodes.len();
            out.wide(end);
        }
        out.text("\nCONNECTIVITY vtktypeint64\n");
        for &index in ELEMENTS.iter().flat_map(|element| element.nodes) {
            out.wide(index);
        }
    } else {
        out.text(&format!("CELLS 6 {}\n", nodes + 6));
        for element in &ELEMENTS {
            out.int(element.nodes.len() as i32);
            for &index in element.nodes {
                out.int(index as i32);
            }
            out.end();
        }
    }
    out.text("\nCELL_TYPES 6\n");
    for element in &ELEMENTS {
        out.int(i32::from(element.vtk));
    }
    out.text("\nPOINT_DATA 7\nSCALARS T float\nLOOKUP_TABLE default\n");
    for [x, ..] in POINTS {
        out.single(x);
    }
    out.text("\nCELL_DATA 6\nVECTORS v float\n");
    for value in 0..18 {
        out.single(f64::from(value));
    }
    out.text("\nFIELD FieldData 2\nflags 1 6 bit\n");
    if binary.is_some() {
        out.byte(0b1010_1000);
    } else {
        out.text("1 0 1 0 1 0");
    }
    out.text("\nbody_id 1 6 int\n");
    for element in &ELEMENTS {
        out.int(element.body);
    }
    out.text("\n");
    out.bytes
}

/// VTU in text, base64, and appended, raw or encoded, compressed or not.
pub(crate) fn xml() -> Files {
    let mut files = Vec::new();
    for (how, big, wide, zlib) in [
        ("ascii", false, false, false),
        ("binary", false, false, false),
        ("binary", true, true, false),
        ("binary", false, true, true),
        ("binary", true, false, true),
        ("raw", false, false, false),
        ("raw", true, true, true),
        ("base64", false, true, false),
        ("base64", false, false, true),
    ] {
        let label = format!("{how}, big {big}, header of 64 bits {wide}, zlib {zlib}.vtu");
        files.push((label, Xml { how, big, wide, zlib, appended: Vec::new() }.file()));
    }
    files
}

struct Xml {
    how: &'static str,
    big: bool,
    wide: bool,
    zlib: bool,
    appended: Vec<u8>,
}

impl Xml {
    fn file(mut self) -> Vec<u8> {
        let order = if self.big { "BigEndian" } else { "LittleEndian" };
        let header = if self.wide { "UInt64" } else { "UInt32" };
        let compressor = if self.zlib { "compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let points = self.array("type=\"Float64\" NumberOfComponents=\"3\"", |out| {
            out.points(POINTS);
        });
        let connectivity = self.array("type=\"Int64\" Name=\"connectivity\"", |out| {
            for &index in ELEMENTS.iter().flat_map(|element| element.nodes) {
                out.wide(index);
            }
        });
        let offsets = self.array("type=\"Int32\" Name=\"offsets\"", |out| {
            let mut end = 0;
            for element in &ELEMENTS {
                end += element.nodes.len() as i32;
                out.int(end);
            }
        });
        let types = self.array("type=\"UInt8\" Name=\"types\"", |out| {
            for element in &ELEMENTS {
                out.byte(element.vtk);
            }
        });
        let bodies = self.array("type=\"Int32\" Name=\"body_id\"", |out| {
            for element in &ELEMENTS {
                out.int(element.body);
            }
        });
        let mut bytes = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" header_type=\"{header}\" {compressor}>\n\
             <UnstructuredGrid>\n<Piece NumberOfPoints=\"7\" NumberOfCells=\"6\">\n<Points>\n{points}</Points>\n<Cells>\n{connectivity}{offsets}{types}</Cells>\n\
             <CellData>\n{bodies}</CellData>\n</Piece>\n</UnstructuredGrid>\n"
        )
        .into_bytes();
        if matches!(self.how, "raw" | "base64") {
            bytes.extend(format!("<AppendedData encoding=\"{}\">\n  _", self.how).as_bytes());
            bytes.extend(&self.appended);
            bytes.extend(b"\n</AppendedData>\n");
        }
        bytes.extend(b"</VTKFile>\n");
        bytes
    }

    /// A `<DataArray>` with its data inline or appended.
    fn array(&mut self, attributes: &str, write: impl Fn(&mut Out)) -> String {
        if self.how == "ascii" {
            let mut out = Out::new(None);
            write(&mut out);
            let text = String::from_utf8(out.bytes).unwrap();
            return format!("<DataArray {attributes} format=\"ascii\">\n{text}</DataArray>\n");
        }
        let mut out = Out::new(Some(self.big));
        write(&mut out);
        let data = self.coded(&out.bytes);
        if self.how == "binary" {
            let text = String::from_utf8(data).unwrap();
            return format!(
                "<DataArray {attributes} format=\"binary\">\n<InformationKey name=\"K\">1</InformationKey>\n  {text}\n</DataArray>\n"
            );
        }
        let offset = self.appended.len();
        self.appended.extend(data);
        format!("<DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>\n")
    }

    /// Header and data, compressed in blocks of 40 bytes.
    fn coded(&self, data: &[u8]) -> Vec<u8> {
        const BLOCK: usize = 40;
        let mut header = Out::new(Some(self.big));
        let number = |header: &mut Out, value: usize| {
            if self.wide { header.wide(value) } else { header.int(value as i32) }
        };
        let mut packed = Vec::new();
        if self.zlib {
            let blocks: Vec<Vec<u8>> = data
                .chunks(BLOCK)
                .map(|block| miniz_oxide::deflate::compress_to_vec_zlib(block, 6))
                .collect();
            for value in [blocks.len(), BLOCK, data.len() % BLOCK] {
                number(&mut header, value);
            }
            for block in blocks {
                number(&mut header, block.len());
                packed.extend(block);
            }
        } else {
            number(&mut header, data.len());
            packed.extend(data);
        }
        match (self.how, self.zlib) {
            ("raw", _) => [header.bytes, packed].concat(),
            // A compressed array has a separately encoded header.
            (_, true) => (STANDARD.encode(header.bytes) + &STANDARD.encode(packed)).into_bytes(),
            (_, false) => STANDARD.encode([header.bytes, packed].concat()).into_bytes(),
        }
    }
}

/// Only the faces, in formats of surfaces: OBJ, PLY, VTP.
pub(crate) fn surfaces() -> Files {
    let mut files = vec![("objects.obj".to_owned(), obj().into_bytes())];
    for ((encoding, binary), format) in
        ENCODINGS.into_iter().zip(["ascii", "binary_little_endian", "binary_big_endian"])
    {
        files.push((format!("{encoding}.ply"), ply(format, binary)));
    }
    files.push(("polys.vtp".into(), vtp().into_bytes()));
    files
}

fn faces() -> impl Iterator<Item = &'static Element> {
    ELEMENTS.iter().filter(|element| element.dimension == 2)
}

fn obj() -> String {
    let mut text = "# by hand\r\nmtllib none.mtl\r\n".to_owned();
    for [x, y, z] in &POINTS[..6] {
        write!(text, "v {x} {y} {z}\r\n").unwrap();
    }
    text += "vn 0 0 1\r\nvt 0 0\r\ng all\r\n";
    let mut object = "";
    for face in faces() {
        if face.set != object {
            object = face.set;
            write!(text, "o {object}\r\nusemtl none\r\ns off\r\n").unwrap();
        }
        let corners: Vec<String> = face.nodes.iter().map(|index| format!("{}/1/1", index + 1)).collect();
        write!(text, "f {}\r\n", corners.join(" ")).unwrap();
    }
    text
}

fn ply(format: &str, binary: Option<bool>) -> Vec<u8> {
    let mut out = Out::new(binary);
    out.text(&format!(
        "ply\nformat {format} 1.0\ncomment by hand\nelement note 1\nproperty list uint8 int16 words\nelement vertex 6\nproperty uchar red\n\
         property float x\nproperty double y\nproperty float32 z\nelement face 3\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n"
    ));
    out.byte(1);
    out.put("7", 7_i16.to_le_bytes());
    out.end();
    for [x, y, z] in &POINTS[..6] {
        out.byte(200);
        out.single(*x);
        out.real(*y);
        out.single(*z);
        out.end();
    }
    for face in faces() {
        out.byte(1);
        out.byte(face.nodes.len() as u8);
        for &index in face.nodes {
            out.int(index as i32);
        }
        out.end();
    }
    out.bytes
}

fn vtp() -> String {
    let points: Vec<String> = POINTS[..6].iter().flatten().map(f64::to_string).collect();
    let nodes: Vec<String> = faces().flat_map(|face| face.nodes).map(usize::to_string).collect();
    format!(
        "<VTKFile type=\"PolyData\" version=\"0.1\">\n<PolyData><Piece NumberOfPoints=\"6\" NumberOfPolys=\"3\" NumberOfVerts=\"0\">\n\
         <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points>\n\
         <Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">{}</DataArray>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3 6 10</DataArray></Polys>\n\
         </Piece></PolyData></VTKFile>\n",
        points.join(" "),
        nodes.join(" ")
    )
}

/// Corners of facets: two facets of one solid, one without area, and one of another solid that shares two
/// corners with the first.
const FACETS: [([usize; 3], usize); 4] = [([0, 1, 2], 0), ([0, 2, 3], 0), ([4, 4, 5], 0), ([1, 4, 5], 1)];

/// STL, and the same facets as a table.
pub(crate) fn solids() -> Files {
    let mut text = String::new();
    for (name, solid) in [("left part", 0), ("", 1)] {
        writeln!(text, "Solid {name}").unwrap();
        for (corners, _) in FACETS.iter().filter(|facet| facet.1 == solid) {
            text += "  facet normal 0 0 1\n    outer loop\n";
            for &corner in corners {
                let [x, y, z] = POINTS[corner];
                writeln!(text, "      vertex {x:e} {y} -{z}").unwrap();
            }
            text += "    endloop\n  endfacet\n";
        }
        writeln!(text, "endsolid {name}").unwrap();
    }
    let mut out = Out::new(Some(false));
    out.bytes.extend([b' '; 80]);
    out.int(4);
    let mut table = "vertex1_X[mm]\tvertex1_Y[mm]\tvertex1_Z[mm]\tvertex2_X[mm]\tvertex2_Y[mm]\tvertex2_Z[mm]\tvertex3_X[mm]\tvertex3_Y[mm]\tvertex3_Z[mm]\n".to_owned();
    for (corners, _) in FACETS {
        for _ in 0..3 {
            out.single(0.0);
        }
        for corner in corners {
            for value in POINTS[corner] {
                out.single(value);
                write!(table, "{value}\t").unwrap();
            }
        }
        out.bytes.extend([0, 0]);
        table += "\n";
    }
    vec![
        ("ascii.stl".into(), text.into_bytes()),
        ("binary.stl".into(), out.bytes),
        ("table.txt".into(), table.into_bytes()),
    ]
}
