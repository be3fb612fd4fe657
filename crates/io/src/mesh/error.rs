//! Everything that can be wrong with a mesh file.

use std::fmt;

use thiserror::Error;

use crate::excerpt;
use crate::mesh::MeshFormat;

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Line of text, counted from 1.
    Line(u64),
    /// Offset in bytes, counted from 0, in a file or a part of one that is no text.
    Byte(u64),
    /// The file as a whole.
    File,
}

/// Why a mesh could not be read: what is wrong, in which file, and where.
///
/// Printed as `file:line: text`, or `file: at byte 84: text` where there are no lines.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub struct MeshError {
    /// Name of the file as it was given to [`read_mesh`](crate::read_mesh).
    pub file: String,
    /// Where the file is wrong.
    pub place: Place,
    /// What is wrong there.
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

/// What is wrong in a mesh file.
///
/// Elements and nodes go by their numbers in the file; where it has none, they are counted from 0, in OBJ vertices from 1, as its faces do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// The content is that of none of the formats, and the name says nothing.
    #[error("no mesh: expected Gmsh .msh, STL, OBJ, PLY, VTK, VTU, VTP or Abaqus .inp, found {found}")]
    UnknownFormat {
        /// The first bytes, or the name of a format that is read by nothing here.
        found: String,
    },
    /// The file does not keep to its format.
    #[error("{problem}")]
    Malformed {
        /// What is wrong.
        problem: String,
    },
    /// The file ends too early.
    #[error("the file ends here: expected {expected}")]
    CutOff {
        /// What should follow.
        expected: String,
    },
    /// The format allows this, but it is not read.
    #[error("{what}: {advice}")]
    Unsupported {
        /// The keyword, version or element.
        what: String,
        /// What is read, or what to do.
        advice: String,
    },
    /// An element names a node that is not there.
    #[error("element {element} ({kind}) names node {node}, which the file does not have")]
    UnknownNode {
        /// Number of the element.
        element: u64,
        /// Its kind, such as `triangle`.
        kind: &'static str,
        /// Number of the node.
        node: i64,
    },
    /// An element names a node twice.
    #[error("element {element} ({kind}) names node {node} twice")]
    RepeatedNode {
        /// Number of the element.
        element: u64,
        /// Its kind, such as `triangle`.
        kind: &'static str,
        /// Number of the node.
        node: i64,
    },
    /// A quadrilateral cannot be split into two triangles that face the same way.
    #[error("element {element} (quadrilateral) crosses itself or has no area")]
    FoldedQuadrilateral {
        /// Number of the element.
        element: u64,
    },
    /// Two nodes have the same number.
    #[error("node {node} is defined twice")]
    RepeatedNumber {
        /// The number.
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
    #[error("{what} is in {first} and in {second}: which body it is a part of cannot be told")]
    TwoBodies {
        /// The element or entity.
        what: String,
        /// Name or number of one.
        first: String,
        /// Name or number of the other.
        second: String,
    },
    /// There is no segment, triangle or tetrahedron in the file.
    #[error("the {format} file has {} and no element that is read", excerpt::count(*points, "node"))]
    NoElements {
        /// Its format.
        format: MeshFormat,
        /// How many nodes there are.
        points: u64,
    },
    /// More nodes than 32 bits count.
    #[error("more than 4294967295 nodes")]
    TooManyNodes,
}

/// A problem and its place: what the readers fail with, before the file's name is added.
pub(crate) type Fault = (Place, MeshProblem);

pub(crate) fn malformed(problem: impl Into<String>) -> MeshProblem {
    MeshProblem::Malformed { problem: problem.into() }
}

pub(crate) fn unsupported(what: impl Into<String>, advice: impl Into<String>) -> MeshProblem {
    MeshProblem::Unsupported { what: what.into(), advice: advice.into() }
}
