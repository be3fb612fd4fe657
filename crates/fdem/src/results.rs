//! What a run of a simulation leaves behind: files for ParaView, pictures, an animation, a history with its plots, and a page for a browser.
//!
//! ```text
//! Snapshot ──┬─> vtu, cracks_vtp ── ParaView
//!            └─> Frame ──┬─> Pictures ── SVG, PNG, Animation (GIF)
//!                        └─> Report ──── one page
//! Row ── HistoryWriter ── history.csv ── History ── plots ── SVG, PNG, Report
//! ```
//! A [`Frame`] is a snapshot made small: a few bytes for each element, to be kept in memory or in a file until the series is complete and its colours
//! are known. Everything here is text or bytes; nothing knows a path.

mod animation;
mod chart;
mod field;
mod fill;
mod frame;
mod history;
mod packed;
mod pictures;
mod plots;
mod report;
mod stress;
mod unit;
mod vtk;

use std::fmt;
use std::io;

use fdem_simulation::Snapshot;

pub use animation::{Animation, AnimationError};
pub use fdem_io::pvd;
pub use field::{Field, Range};
pub use frame::{Frame, FrameError};
pub use history::{History, HistoryError, HistoryWriter, Row, kept};
pub use pictures::{FrameView, Pictures};
pub use plots::{Plot, plots};
pub use report::{MOST_FRAMES, Report};
pub use vtk::{write_cracks_vtp, write_vtu};

/// A snapshot that contradicts itself.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SnapshotError {
    /// An array has not as many entries as there are nodes or elements.
    Length {
        /// The array.
        name: &'static str,
        /// Its entries.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// An element has a node that is not there.
    Node {
        /// The element.
        element: usize,
        /// The node.
        node: u32,
        /// How many there are.
        nodes: usize,
    },
}

impl fmt::Display for SnapshotError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { name, found, expected } => {
                write!(out, "the snapshot has {found} {name}, where {expected} are needed")
            }
            Self::Node { element, node, nodes } => {
                write!(out, "element {element} of the snapshot has node {node}, but there are {nodes}")
            }
        }
    }
}

impl std::error::Error for SnapshotError {}

impl From<SnapshotError> for io::Error {
    fn from(error: SnapshotError) -> Self {
        Self::new(io::ErrorKind::InvalidInput, error)
    }
}

/// Every array has its length and every node is there.
fn checked(snapshot: &Snapshot) -> Result<(), SnapshotError> {
    let (nodes, elements) = (snapshot.positions.len(), snapshot.triangles.len());
    for (name, found, expected) in [
        ("displacements", snapshot.displacements.len(), nodes),
        ("velocities", snapshot.velocities.len(), nodes),
        ("stresses", snapshot.stresses.len(), elements),
        ("values of damage", snapshot.damage.len(), elements),
        ("bodies", snapshot.bodies.len(), elements),
        ("materials", snapshot.materials.len(), elements),
    ] {
        if found != expected {
            return Err(SnapshotError::Length { name, found, expected });
        }
    }
    for (element, triangle) in snapshot.triangles.iter().enumerate() {
        if let Some(&node) = triangle.iter().find(|&&node| node as usize >= nodes) {
            return Err(SnapshotError::Node { element, node, nodes });
        }
    }
    Ok(())
}
