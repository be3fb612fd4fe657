//! The formats of mesh files.

use std::fmt;

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
