//! The content of a mesh file.

use std::fmt;

use crate::mesh::format::MeshFormat;

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
