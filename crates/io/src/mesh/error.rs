//! The errors of reading a mesh.

use std::fmt;

use thiserror::Error;

use crate::excerpt;
use crate::mesh::format::MeshFormat;
use crate::place::Place;

/// The reason why a mesh could not be read: the problem, the file, and the place.
///
/// Printed as `file:line: text`, or as `file: at byte 84: text` if there are no lines.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub struct MeshError {
    /// Name of the file as passed to [`read_mesh`](crate::read_mesh).
    pub file: String,
    /// The place of the error.
    pub place: Place,
    /// The problem.
    pub problem: MeshProblem,
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::Line(line) => write!(f, "{}:{line}: {}", self.file, self.problem),
            Place::Byte(byte) => write!(f, "{}: at byte {byte}: {}", self.file, self.problem),
            Place::File => write!(f, "{}: {}", self.file, self.problem),
        }
    }
}

impl MeshError {
    /// The line the error is about, counted from 1; `None` for binary data and the file as a whole.
    pub fn line(&self) -> Option<u64> {
        match self.place {
            Place::Line(line) => Some(line),
            Place::Byte(_) | Place::File => None,
        }
    }
}

/// The problem of a mesh file.
///
/// Elements and nodes have the numbers of the file. If it has none, they are counted from 0; vertices of OBJ
/// files are counted from 1, as in their faces.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// The content has none of the formats, and the name does not help.
    #[error("no mesh: expected Gmsh .msh, STL, OBJ, PLY, VTK, VTU, VTP or Abaqus .inp, found {found}")]
    UnknownFormat {
        /// The first bytes, or the name of an unsupported format.
        found: String,
    },
    /// The file violates its format.
    #[error("{problem}")]
    Malformed {
        /// The problem.
        problem: String,
    },
    /// The file ends too early.
    #[error("the file ends here: expected {expected}")]
    CutOff {
        /// The expected content.
        expected: String,
    },
    /// The format allows this, but it is not supported.
    #[error("{what}: {advice}")]
    Unsupported {
        /// The keyword, version or element.
        what: String,
        /// The supported values, or advice.
        advice: String,
    },
    /// An element names a node that does not exist.
    #[error("element {element} ({kind}) names node {node}, which the file does not have")]
    UnknownNode {
        /// Number of the element.
        element: u64,
        /// Kind of the element, such as `triangle`.
        kind: &'static str,
        /// Number of the node.
        node: i64,
    },
    /// An element names a node twice.
    #[error("element {element} ({kind}) names node {node} twice")]
    RepeatedNode {
        /// Number of the element.
        element: u64,
        /// Kind of the element, such as `triangle`.
        kind: &'static str,
        /// Number of the node.
        node: i64,
    },
    /// An element cannot be cut into triangles or tetrahedra of the same orientation.
    #[error("element {element} ({kind}) crosses itself or has no {}", if matches!(*kind, "quadrilateral" | "polygon") { "area" } else { "volume" })]
    FoldedElement {
        /// Number of the element.
        element: u64,
        /// Kind of the element, such as `quadrilateral`.
        kind: &'static str,
    },
    /// A quadrilateral is folded along a diagonal by more than a right angle.
    #[error("element {element} (quadrilateral) is folded by {degrees} degrees: divide it into triangles")]
    FoldedQuadrilateral {
        /// Number of the element.
        element: u64,
        /// Angle between the normals of its two halves, degrees: 0 if it is flat.
        degrees: u32,
    },
    /// Two nodes have the same number.
    #[error("node {node} is defined twice")]
    RepeatedNumber {
        /// The number of the node.
        node: i64,
    },
    /// A coordinate is NaN, infinite or beyond 64-bit floats.
    #[error("node {node}: coordinate {axis} is not a finite number")]
    NotFinite {
        /// Number of the node; of the corner, counted from 0, in STL.
        node: i64,
        /// `x`, `y` or `z`.
        axis: char,
    },
    /// An element belongs to two bodies.
    #[error("{what} is in {first} and in {second}: its body is ambiguous")]
    TwoBodies {
        /// The element or entity.
        what: String,
        /// Name or number of one body.
        first: String,
        /// Name or number of the other body.
        second: String,
    },
    /// The file has no segment, triangle or tetrahedron.
    #[error("the {format} file has {} and no element that is read", excerpt::count(*points, "node"))]
    NoElements {
        /// Format of the file.
        format: MeshFormat,
        /// Number of nodes.
        points: u64,
    },
    /// A problem of a file that the mesh file includes.
    #[error("{file}:{line}: {problem}")]
    Included {
        /// The path of that file.
        file: String,
        /// The line, counted from 1.
        line: u64,
        /// The problem there.
        problem: Box<MeshProblem>,
    },
    /// There are more nodes than 32 bits can count.
    #[error("more than 4294967295 nodes")]
    TooManyNodes,
}

/// A place and a problem: the error of the readers, before the name of the file is added.
pub(crate) type Fault = (Place, MeshProblem);

pub(crate) fn malformed(problem: impl Into<String>) -> MeshProblem {
    MeshProblem::Malformed { problem: problem.into() }
}

pub(crate) fn unsupported(what: impl Into<String>, advice: impl Into<String>) -> MeshProblem {
    MeshProblem::Unsupported { what: what.into(), advice: advice.into() }
}
