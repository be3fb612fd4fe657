//! Meshes: the content of a file of nodes and elements, and the reader for all formats.

#![allow(clippy::cast_possible_wrap, reason = "lengths of what is in memory fit 63 bits")]

use std::fmt;

pub(crate) mod cursor;
pub(crate) mod error;
mod build;

mod abaqus;
mod gmsh;
mod obj;
mod ply;
mod stl;
mod triangles;
mod vtk;
mod vtk_data;
pub(crate) mod vtk_points;
mod vtk_xml;

use crate::excerpt;
use crate::read::{BYTE_ORDER_MARK, FOREIGN};
use build::Draft;
use error::{Fault, MeshError, MeshProblem, Place};

/// The content of a mesh file: nodes and the elements between them; each element is part of a body.
///
/// # Shapes
/// `points` `[n]`; the nodes of elements are indices into it. `segments`, `triangles` and `tetrahedra` have
/// any length and are in the order of the file.
///
/// # Units
/// The units of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// Nodes, finite, in the order of the file; `z = 0` if the file has x and y only.
    pub points: Vec<[f64; 3]>,
    /// 2 if every z is 0 and there is no tetrahedron, otherwise 3: most formats write z for flat meshes too.
    pub dimensions: usize,
    /// Elements of two nodes.
    pub segments: Cells<2>,
    /// Elements of three nodes, and the halves of quadrilaterals.
    pub triangles: Cells<3>,
    /// Elements of four nodes with a volume, with the orientation of the file.
    pub tetrahedra: Cells<4>,
    /// The bodies that have elements, in the order of their first elements in the file; at least one.
    pub bodies: Vec<MeshBody>,
    /// How the file was interpreted.
    pub source: MeshSource,
}

/// The elements of one kind.
///
/// # Shapes
/// All three arrays have the same length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells<const N: usize> {
    /// Indices into [`MeshFile::points`], `N` different ones for each element.
    pub nodes: Vec<[u32; N]>,
    /// The body of each element, an index into [`MeshFile::bodies`].
    pub bodies: Vec<u32>,
    /// The number of each element in the file, for messages. If the file has none, its place among all
    /// elements of the file, counted from
    /// 0. Both halves of a quadrilateral have the same number.
    pub numbers: Vec<u64>,
}

impl<const N: usize> Cells<N> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}

/// A body of a mesh; [`MeshSource::bodies_from`] says how the file defines its bodies.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct MeshBody {
    /// Its number in the file: the tag of a physical group, or the value of the cell data. Groups of curves,
    /// surfaces and volumes may share a number.
    pub number: Option<i64>,
    /// Its name in the file, cut to 80 characters, with control characters escaped.
    pub name: Option<String>,
}

/// How a mesh file was interpreted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshSource {
    /// The format.
    pub format: MeshFormat,
    /// The meaning of bodies in the file.
    pub bodies_from: BodiesFrom,
    /// Number of elements of one node, which are not in the mesh.
    pub point_elements: u64,
    /// Number of facets of STL files and tables with two equal corners. They have no area and are not in the
    /// mesh.
    pub collapsed_facets: u64,
    /// Number of quadrilaterals; each is in the mesh as two triangles.
    pub quadrilaterals: u64,
}

/// The meaning of the bodies of a mesh in its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BodiesFrom {
    /// The file does not distinguish bodies: everything is one body.
    File,
    /// Physical groups of Gmsh. Elements in no group form one body without number.
    PhysicalGroups,
    /// Curves, surfaces and volumes of Gmsh, if there are no physical groups.
    Entities,
    /// `solid`s of STL.
    Solids,
    /// Objects of OBJ, `o`.
    Objects,
    /// Groups of OBJ, `g`, if there are no objects.
    Groups,
    /// The cell data of this name, VTK.
    CellData(String),
    /// Instances of parts, Abaqus.
    Instances,
    /// Parts, Abaqus, if there are no instances.
    Parts,
    /// Element sets, Abaqus. Elements in no set form one body without name.
    ElementSets,
}

impl fmt::Display for BodiesFrom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::File => "the file as a whole",
            Self::PhysicalGroups => "physical groups",
            Self::Entities => "geometrical entities",
            Self::Solids => "solids",
            Self::Objects => "objects",
            Self::Groups => "groups",
            Self::CellData(name) => return write!(f, "cell data {name}"),
            Self::Instances => "instances",
            Self::Parts => "parts",
            Self::ElementSets => "element sets",
        })
    }
}

/// Format of a mesh file.
///
/// # Example
/// ```
/// use fdem_io::MeshFormat;
///
/// assert_eq!(MeshFormat::of(b"solid wall\nendsolid wall\n", "wall.txt"), Some(MeshFormat::Stl));
/// assert_eq!(MeshFormat::of(b"x,y\n0,1\n", "packing.csv"), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// Gmsh `.msh`, 2.2 and 4.1.
    Gmsh,
    /// Stereolithography, `.stl`.
    Stl,
    /// Wavefront `.obj`.
    Obj,
    /// Polygon file format, `.ply`.
    Ply,
    /// Legacy VTK, `.vtk`: unstructured grids and poly data.
    Vtk,
    /// XML VTK, `.vtu` and `.vtp`.
    VtkXml,
    /// Abaqus input, `.inp`.
    Abaqus,
    /// Text of nine columns named `vertex1_X`, `vertex1_Y`, … `vertex3_Z`, the format of the walls in the DEM
    /// round robin of 2024.
    Triangles,
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gmsh => "Gmsh",
            Self::Stl => "STL",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Vtk => "VTK",
            Self::VtkXml => "XML VTK",
            Self::Abaqus => "Abaqus",
            Self::Triangles => "table of triangles",
        })
    }
}

impl MeshFormat {
    /// The format by the content of a file, otherwise by its extension; `None` if neither is that of a mesh.
    ///
    /// # Cost
    /// Reads the first lines only.
    pub fn of(bytes: &[u8], name: &str) -> Option<Self> {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        by_content(bytes).or_else(|| by_name(name))
    }
}

fn by_name(name: &str) -> Option<MeshFormat> {
    let extension = name.rsplit_once('.')?.1.to_ascii_lowercase();
    Some(match extension.as_str() {
        "msh" => MeshFormat::Gmsh,
        "stl" => MeshFormat::Stl,
        "obj" => MeshFormat::Obj,
        "ply" => MeshFormat::Ply,
        "vtk" => MeshFormat::Vtk,
        "vtu" | "vtp" => MeshFormat::VtkXml,
        "inp" => MeshFormat::Abaqus,
        _ => return None,
    })
}

/// Number of bytes of leading comments that are searched for the first significant line.
const HEAD: usize = 1 << 16;

fn by_content(bytes: &[u8]) -> Option<MeshFormat> {
    if stl::is_binary(bytes) {
        return Some(MeshFormat::Stl);
    }
    let head = &bytes[..bytes.len().min(HEAD)];
    let mut lines = head.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    let first = lines.clone().next()?;
    let starts = |word: &[u8]| first.len() >= word.len() && first[..word.len()].eq_ignore_ascii_case(word);
    if triangles::is_header(first) {
        return Some(MeshFormat::Triangles);
    }
    if first == b"ply" {
        return Some(MeshFormat::Ply);
    }
    if starts(b"# vtk DataFile") {
        return Some(MeshFormat::Vtk);
    }
    if starts(b"<?xml") || starts(b"<VTKFile") || starts(b"<!--") {
        return memchr::memmem::find(head, b"<VTKFile").map(|_| MeshFormat::VtkXml);
    }
    if starts(b"$") {
        let sections = [&b"$MeshFormat"[..], b"$NOD", b"$Comments", b"$PhysicalNames"];
        return sections.contains(&first).then_some(MeshFormat::Gmsh);
    }
    if starts(b"solid") && first.get(5).is_none_or(u8::is_ascii_whitespace) {
        let next = lines.nth(1).unwrap_or(b"");
        let facet = |line: &[u8]| {
            ["facet", "endsolid"].iter().any(|word| line.to_ascii_lowercase().starts_with(word.as_bytes()))
        };
        return (next.is_empty() || facet(next)).then_some(MeshFormat::Stl);
    }
    if starts(b"*") {
        let keyword = lines.find(|line| !line.starts_with(b"**"))?;
        let letter = keyword.get(1).is_some_and(u8::is_ascii_alphabetic);
        return (keyword.starts_with(b"*") && letter).then_some(MeshFormat::Abaqus);
    }
    let statement = |line: &[u8]| {
        let mut words = cursor::words(line);
        words.next() == Some(b"v")
            && words.by_ref().take(3).filter(|word| cursor::float(word).is_ok()).count() == 3
    };
    let keywords = [&b"mtllib"[..], b"o", b"g", b"v", b"vn", b"vt", b"usemtl", b"s"];
    let first = lines.clone().find(|line| !line.starts_with(b"#"))?;
    let keyword = cursor::words(first).next()?;
    (keywords.contains(&keyword) && lines.any(statement)).then_some(MeshFormat::Obj)
}

/// Reads a mesh from the content of a file.
///
/// The format is recognised by the content or, if that is not conclusive, by the extension of `name`. The
/// formats are:
///
/// - Gmsh `.msh` 2.2 and 4.1, ASCII and binary. Bodies are the physical groups, or the curves, surfaces and
///   volumes if there are no groups.
/// - STL, ASCII and binary. Corners of one solid with equal coordinates become one node. Bodies are the
///   solids.
/// - OBJ. Bodies are the objects, or the groups if there are no objects.
/// - PLY, ASCII and binary: vertices, faces, edges. One body.
/// - VTK, the legacy format (ASCII, binary), unstructured grids and poly data; VTU and VTP (ASCII, base64,
///   appended, zlib). Bodies are the values of the first of these cell data that exists, in any capitals:
///   `body`, `body_id`, `bodyid`, `gmsh:physical`, `CellEntityIds`, `ObjectId`, `PartId`, `RegionId`.
/// - Abaqus `.inp`: nodes, elements, element sets, parts and instances, translated but not rotated. Bodies
///   are the instances, otherwise the parts, otherwise the sets named by `*ELEMENT`, otherwise those of
///   `*ELSET`.
/// - Tables of triangles, three corners per line, with columns `vertex1_X` … `vertex3_Z`. Equal corners
///   become one node. One body.
///
/// If the file does not distinguish bodies, there is one body. Nodes that two bodies share stay shared. A
/// quadrilateral is split into two triangles along the diagonal from its first node, or along the other
/// diagonal if only that lies inside; if the quadrilateral is not flat, this choice determines its shape.
/// Elements of one node are counted but not kept. Elements with more corners, more faces or nodes on edges
/// are refused.
///
/// # Shapes
/// `bytes`: a whole file. `name`: the name of the file, for messages and for its extension.
///
/// # Units
/// The units of the file.
///
/// # Cost
/// Time proportional to the bytes, times the logarithm of the number of nodes if node numbers have gaps or
/// nodes are merged; one thread. Memory follows the bytes of the file, whatever its header says. Compressed
/// data may take a thousand times its bytes, and every instance of an Abaqus part has its own nodes.
/// Overlapping ranges of Abaqus sets are processed one after another.
///
/// # Errors
/// [`MeshError`], with file, line or byte, and the element or node: another format, a violation of the
/// format, the elements listed above as refused, nodes that do not exist or that one element names twice,
/// coordinates that are not finite, or no element at all.
///
/// # Source
/// Gmsh reference manual, "MSH file format"; VTK file formats, VTK user's guide; G. Turk, "The PLY Polygon
/// File Format" (1994); Wavefront, "Object Files"; Abaqus keywords reference guide.
///
/// # Example
/// ```
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let mesh = fdem_io::read_mesh(text, "triangle.obj")?;
/// assert_eq!(mesh.triangles.nodes, [[0, 1, 2]]);
/// let error = fdem_io::read_mesh(b"v 0 0 0\nf 1 2 3\n", "bad.obj").unwrap_err();
/// assert_eq!(error.to_string(), "bad.obj:2: element 0 (triangle) names node 2, which the file does not have");
/// # Ok::<(), fdem_io::MeshError>(())
/// ```
pub fn read_mesh(bytes: &[u8], name: &str) -> Result<MeshFile, MeshError> {
    let locate = |(place, problem): Fault| MeshError { file: name.to_owned(), place, problem };
    let bare = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let Some(format) = MeshFormat::of(bytes, name) else {
        return Err(locate((Place::File, MeshProblem::UnknownFormat { found: found(bytes) })));
    };
    let draft = match format {
        MeshFormat::Gmsh => gmsh::read(bare),
        MeshFormat::Stl => stl::read(bare),
        MeshFormat::Obj => obj::read(bare),
        MeshFormat::Ply => ply::read(bare),
        MeshFormat::Vtk => vtk::read(bare),
        MeshFormat::VtkXml => vtk_xml::read(bare),
        MeshFormat::Abaqus => abaqus::read(bare),
        MeshFormat::Triangles => triangles::read(bare),
    };
    draft.and_then(|draft: Draft| draft.finish(format)).map_err(locate)
}

fn found(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "no bytes".into();
    }
    if let Some((_, format, _)) = FOREIGN.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        return (*format).to_owned();
    }
    let line = bytes.split(|&byte| byte == b'\n').next().unwrap_or(bytes);
    format!("'{}'", excerpt::field(line))
}
