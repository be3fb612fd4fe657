//! Results of a simulation: files for ParaView, pictures, an animation, a history with its plots, and a page for a browser.
//!
//! ```text
//! Snapshot ──┬─> vtu, vtp ── ParaView
//!            ├─> Fragments ── fragments.csv, plot of sizes
//!            └─> Frame ──┬─> Pictures ── SVG, PNG, Animation (GIF)
//!                        └─> Report ──── one page
//! Row ── HistoryWriter ── history.csv ── History ── plots ── SVG, PNG, Report
//! ```
//! A [`Frame`] is a compressed snapshot with a few bytes for each element. It is kept in memory or in a file until the series is complete and the range of
//! its colours is known. This module makes text and bytes, and knows no paths.

mod animation;
mod chart;
mod curves;
mod emission;
pub(crate) mod field;
mod fill;
pub(crate) mod fragments;
pub(crate) mod frame;
mod history;
mod loads;
pub(crate) mod names;
mod noise;
pub(crate) mod outlines;
pub(crate) mod packed;
pub(crate) mod pictures;
pub(crate) mod plots;
mod sample;
mod stress;
pub(crate) mod unit;
mod vtk;

use std::fmt;
use std::io;

use fdem_simulation::Snapshot;

pub use animation::{Animation, AnimationError, SpaceAnimation};
pub use curves::{CurveFigures, HistoryCurve};
pub use emission::{BValue, Break, Clustering, Event, breaks, events, events_csv, magnitude_frequency};
pub use fdem_io::pvd;
pub use field::{Field, Range};
pub use fragments::{ElementMasses, Fragment, FragmentCount, Fragments, SizeDistribution};
pub use frame::{Frame, FrameError};
pub use history::{History, HistoryError, HistoryWriter, Row, history_columns, kept};
pub use names::Names;
pub use outlines::Outlines;
pub use pictures::{FrameView, Pictures};
pub use plots::{Plot, RANK_PLOTS, RankLoad, fragment_sizes, plots, rank_loads};
pub use vtk::{write_contacts_vtp, write_cracks_vtp, write_damaged_joints_vtp, write_vtu};

/// A snapshot that contradicts itself.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The number of entries of an array is not that of the nodes or elements.
    Length {
        /// Name of the array.
        name: &'static str,
        /// Number of its entries.
        found: usize,
        /// Number of entries that it should have.
        expected: usize,
    },
    /// An element has a node that does not exist.
    Node {
        /// The element.
        element: usize,
        /// The node.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// An element has a material that does not exist.
    Material {
        /// The element.
        element: usize,
        /// The material.
        material: u32,
        /// Number of materials.
        materials: usize,
    },
    /// A contact has an element that does not exist.
    Contact {
        /// The element.
        element: u32,
        /// Number of elements.
        elements: usize,
    },
    /// A crack is between elements that have no facet in common.
    Crack {
        /// The elements.
        elements: [u32; 2],
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
            Self::Material { element, material, materials } => {
                write!(out, "element {element} has material {material}, but there are {materials}")
            }
            Self::Contact { element, elements } => {
                write!(out, "a contact has element {element}, but there are {elements}")
            }
            Self::Crack { elements: [one, other] } => {
                write!(out, "a crack is between elements {one} and {other}, which have no facet in common")
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

/// Checks that every array has its length and that every node exists.
pub(crate) fn checked<const D: usize, const N: usize>(
    snapshot: &Snapshot<D, N>,
) -> Result<(), SnapshotError> {
    let (nodes, elements) = (snapshot.positions.len(), snapshot.elements.len());
    for (name, found, expected) in [
        ("displacements", snapshot.displacements.len(), nodes),
        ("velocities", snapshot.velocities.len(), nodes),
        ("stresses", snapshot.stresses.len(), elements),
        ("values of damage", snapshot.damage.len(), elements),
        ("bodies", snapshot.bodies.len(), elements),
        ("materials", snapshot.materials.len(), elements),
        ("fragments", snapshot.fragments.len(), elements),
    ] {
        if found != expected {
            return Err(SnapshotError::Length { name, found, expected });
        }
    }
    for (element, corners) in snapshot.elements.iter().enumerate() {
        if let Some(&node) = corners.iter().find(|&&node| node as usize >= nodes) {
            return Err(SnapshotError::Node { element, node, nodes });
        }
    }
    Ok(())
}
