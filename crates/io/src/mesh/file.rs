//! The content of a mesh file.

use std::fmt;

use crate::mesh::format::MeshFormat;
use crate::numbers::grouped;

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
    /// Elements of three nodes, and the parts of quadrilaterals and polygons.
    pub triangles: Cells<3>,
    /// Elements of four nodes with a volume, and the parts of pyramids, wedges and hexahedra, with the
    /// orientation of the file.
    pub tetrahedra: Cells<4>,
    /// The bodies that have elements, in the order of their first elements in the file; at least one.
    pub bodies: Vec<MeshBody>,
    /// Sets that may overlap each other and the bodies, in the order of the file: the sets and surfaces of
    /// Abaqus, and the further physical groups of curves and surfaces of Gmsh that are in several. A set may
    /// have the name of a body.
    pub groups: Vec<MeshGroup>,
    /// Format of the file, and the meaning of its parts.
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
    /// 0. All parts of an element that is cut have its number.
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

/// A set of elements, of nodes or of facets of elements, or of several of them.
///
/// # Shapes
/// Indices into the cells of the mesh and into [`MeshFile::points`], of any length.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MeshGroup {
    /// Its number in the file, as in [`MeshBody`].
    pub number: Option<i64>,
    /// Its name in the file, as in [`MeshBody`]. A set of one instance or part of several is also there with
    /// the name of that before it, `plate-1.left`.
    pub name: Option<String>,
    /// Indices of segments.
    pub segments: Vec<u32>,
    /// Indices of triangles.
    pub triangles: Vec<u32>,
    /// Indices of tetrahedra.
    pub tetrahedra: Vec<u32>,
    /// Indices of nodes.
    pub nodes: Vec<u32>,
    /// Edges of triangles, by their nodes.
    pub edges: Vec<[u32; 2]>,
    /// Faces of tetrahedra, by their nodes.
    pub faces: Vec<[u32; 3]>,
}

/// Format of a mesh file, and the meaning of its parts.
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
    /// Number of polygons of five or more corners; each is in the mesh as triangles.
    pub polygons: u64,
    /// Number of pyramids, wedges and hexahedra; each is in the mesh as tetrahedra.
    pub cut_solids: u64,
    /// Number of elements of second order. Their nodes on edges, on faces and inside are among the points,
    /// but in no element.
    pub second_order: u64,
    /// Number of cohesive elements with a thickness, which are not in the mesh.
    pub cohesive_elements: u64,
    /// Number of cohesive elements without thickness. Each is in the mesh as a segment, or as one or two
    /// triangles, between elements that share its nodes.
    pub cohesive_facets: u64,
    /// Parts of the file that are not in the mesh, in words.
    pub unused: Vec<String>,
}

impl MeshSource {
    /// Differences between the elements of the file and those of the mesh, one sentence without a full stop
    /// each.
    pub fn notes(&self) -> Vec<String> {
        let of_count = [
            (self.quadrilaterals, "quadrilateral", "quadrilaterals", "cut into triangles"),
            (
                self.polygons,
                "polygon of five or more corners",
                "polygons of five or more corners",
                "cut into triangles",
            ),
            (
                self.cut_solids,
                "pyramid, wedge or hexahedron",
                "pyramids, wedges and hexahedra",
                "cut into tetrahedra",
            ),
            (
                self.second_order,
                "element of second order",
                "elements of second order",
                "taken by the corners alone",
            ),
            (
                self.cohesive_elements,
                "cohesive element with a thickness",
                "cohesive elements with a thickness",
                "left out",
            ),
            (
                self.cohesive_facets,
                "cohesive element",
                "cohesive elements",
                "without thickness: the two sides share nodes, and a joint set with group = SET gives them a law",
            ),
        ];
        let counted =
            of_count.into_iter().filter(|(count, ..)| *count > 0).map(|(count, one, more, what)| {
                let (noun, verb) = if count == 1 { (one, "is") } else { (more, "are") };
                format!("{} {noun} {verb} {what}", grouped(count))
            });
        counted.chain(self.unused.iter().cloned()).collect()
    }
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
    /// Element sets, Abaqus: those that `*ELEMENT` names, otherwise those of `*ELSET` if none overlap.
    /// Elements in no set form one body without name.
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
