//! Settings of the output, and quantities to record over time.

use fdem_results::{CoarseGrid, Field};
use serde::Serialize;

use crate::text::file::AcousticEmission;

/// Settings of the output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputSettings {
    /// Time between result files, s.
    pub interval: f64,
    /// Fields of pictures and the report; at least one.
    pub fields: Vec<Field>,
    /// Field of the animation; `None` for no animation.
    pub animate: Option<Field>,
    /// Number of elements beyond which pictures and the report show a sample, and number of triangles of that
    /// sample.
    pub shown: [usize; 2],
    /// Whether frames have the joints that are whole.
    pub intact_joints: bool,
    /// Numbers of the bodies whose fragments count; `None` for the bodies that can break.
    pub fragments: Option<Vec<u32>>,
    /// How breaks are put together to events of acoustic emission; `None` if they are not.
    pub emission: Option<AcousticEmission>,
    /// Grid on which frames show spheres as a continuum; `None` if they do not.
    pub coarse: Option<CoarseGrid>,
    /// Interval of checkpoints.
    pub checkpoint: Checkpoint,
    /// Time between rows of the history, s.
    pub history_interval: f64,
    /// Times between results that the model file gives, s, with their keys.
    pub given: Vec<(String, f64)>,
}

/// Interval of checkpoints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Checkpoint {
    /// Wall-clock time, s.
    Seconds(f64),
    /// Number of steps.
    Steps(u64),
}

/// A quantity that is recorded over time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreparedHistory {
    /// Name of its columns.
    pub name: String,
    /// The quantity.
    pub quantity: Quantity,
}

/// A kind of quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Quantity {
    /// Displacement and velocity of this node of the mesh.
    Node(u32),
    /// The force that this boundary, by its place in [`Model::boundaries`](fdem_simulation::Model), exerts on
    /// the bodies, N.
    Force(usize),
    /// The same of a boundary with a rotation, and its moment on the bodies about its axis in this direction,
    /// N m.
    Torque(usize, [f64; 3]),
    /// The energies, which are recorded in any case.
    Energy,
    /// The length of the cracks, which is recorded in any case.
    CrackLength,
    /// The quantity of this probe, by its place in [`Prepared::probes`](crate::Prepared).
    Probe(usize),
}
