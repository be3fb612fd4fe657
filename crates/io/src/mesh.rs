//! The reader of meshes of all formats.

#![allow(clippy::cast_possible_wrap, reason = "lengths of what is in memory fit 63 bits")]

pub(crate) mod cursor;
pub(crate) mod error;
mod build;
mod cut;
pub(crate) mod file;
pub(crate) mod format;
mod recognise;
mod shape;

mod abaqus;
pub(crate) mod abaqus_include;
mod abaqus_sets;
mod abaqus_types;
mod gmsh;
mod obj;
mod ply;
mod stl;
mod triangles;
pub(crate) mod vtk;
mod vtk_data;
pub(crate) mod vtk_points;
pub(crate) mod vtk_xml;

use crate::excerpt;
use crate::foreign::{BYTE_ORDER_MARK, recognised};
use crate::place::Place;
use abaqus_include::MeshLoad;
use build::Draft;
use error::{Fault, MeshError, MeshProblem};
use file::MeshFile;
use format::MeshFormat;

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
/// - VTK, the legacy format (ASCII, binary), unstructured grids, poly data and structured points, whose cells
///   are quadrilaterals or hexahedra; VTU and VTP (ASCII, base64, appended, zlib). Bodies are the values of
///   the first of these cell data that exists, in any capitals:
///   `body`, `body_id`, `bodyid`, `gmsh:physical`, `CellEntityIds`, `ObjectId`, `PartId`, `RegionId`.
/// - Abaqus `.inp`: nodes, elements, element sets, parts and instances, translated but not rotated. Bodies
///   are the instances, otherwise the parts, otherwise the sets named by `*ELEMENT`, otherwise those of
///   `*ELSET` if no element is in two. All sets and surfaces are groups.
/// - Tables of triangles, three corners per line, with columns `vertex1_X` … `vertex3_Z`. Equal corners
///   become one node. One body.
///
/// If the file does not distinguish bodies, there is one body. Nodes that two bodies share stay shared.
///
/// A quadrilateral is cut into two triangles along the diagonal through its smallest node, or along the other
/// diagonal if only that lies inside; if the quadrilateral is not flat, this choice determines its shape.
/// Polygons are cut into triangles; pyramids, wedges and hexahedra are cut into tetrahedra by the same rule
/// of the smallest node, so that neighbours agree on their common face. Of elements of second order the
/// corners are taken. Elements of one node are counted but not kept. Cohesive elements without thickness
/// become segments or triangles, and the nodes of their two sides become one; those with a thickness are
/// counted but not kept.
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
    let alone = |_: &str| Err("copy its lines into this one, because one file is read".to_owned());
    read_mesh_with(bytes, name, &mut { alone })
}

/// Like [`read_mesh`], for files that may include others: `*INCLUDE` and `INPUT=` of Abaqus.
///
/// `load` gives the bytes of an included file by its path, which is relative to the folder of the file that
/// includes it, and so begins with the folder of `name`.
///
/// # Errors
/// As [`read_mesh`]; also a file that cannot be read, that includes itself, or is one of more than 1000.
///
/// # Example
/// ```
/// let text = b"*Include, input=nodes.inp\n*Element, type=CPS3\n1, 1, 2, 3\n";
/// let mut load = |path: &str| match path {
///     "parts/nodes.inp" => Ok(b"*Node\n1, 0, 0\n2, 1, 0\n3, 0, 1\n".to_vec()),
///     _ => Err("there is none".to_owned()),
/// };
/// let mesh = fdem_io::read_mesh_with(text, "parts/plate.inp", &mut load)?;
/// assert_eq!(mesh.points[1], [1.0, 0.0, 0.0]);
/// # Ok::<(), fdem_io::MeshError>(())
/// ```
pub fn read_mesh_with(bytes: &[u8], name: &str, load: &mut MeshLoad<'_>) -> Result<MeshFile, MeshError> {
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
        MeshFormat::Abaqus => abaqus::read(bare, name, load),
        MeshFormat::Triangles => triangles::read(bare),
    };
    draft.and_then(|draft: Draft| draft.finish(format)).map_err(locate)
}

fn found(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "no bytes".into();
    }
    if let Some((format, _)) = recognised(bytes) {
        return format.to_owned();
    }
    let line = bytes.split(|&byte| byte == b'\n').next().unwrap_or(bytes);
    format!("'{}'", excerpt::field(line))
}
