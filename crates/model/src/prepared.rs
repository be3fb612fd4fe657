//! A model that is ready to run.

mod added_mass;
mod conditions;
mod entered;
mod grains;
mod joints;
mod output;

use std::ops::Range;

use fdem_mesh::Quality;
use fdem_results::HistoryCurve;
use fdem_simulation::{Model, Probe, Schedule};
use serde::Serialize;

use crate::text::library::FromLibrary;

pub use added_mass::Scaled;
pub(crate) use added_mass::counted;
pub use conditions::{Bound, PreparedServo, PreparedUntil, Reached};
pub use entered::{Entered, Origin};
pub(crate) use grains::is_zero;
pub use grains::{ComingSpheres, PreparedRemoval, PreparedSpheres, SphereGroup};
pub use joints::{Joints, open_from_start};
pub use output::{Checkpoint, OutputSettings, PreparedHistory, Quantity};

/// A model that is ready to run.
#[derive(Debug, Clone)]
pub struct Prepared<const D: usize = 2, const N: usize = 3> {
    /// The model to simulate.
    pub model: Model<D, N>,
    /// Title; empty if the model has none.
    pub title: String,
    /// When the run ends, s.
    pub end_time: f64,
    /// The bodies, by their numbers in [`Mesh::bodies`](fdem_simulation::Mesh).
    pub bodies: Vec<PreparedBody>,
    /// Named parts of bodies: physical groups of mesh files; outlines, holes and faces of other shapes.
    pub groups: Vec<Group<D>>,
    /// Lines about the mesh files of bodies: their groups, the elements that are cut or left out, and parts
    /// of the files that are not used.
    pub about_files: Vec<String>,
    /// Grain of each element, numbered within its body; empty if no body has grains.
    pub grains: Vec<u32>,
    /// The spheres and walls; `None` without.
    pub spheres: Option<PreparedSpheres>,
    /// Joints of each joint set in the mesh.
    pub joint_sets: Vec<Joints>,
    /// Materials that have keys from the library.
    pub from_library: Vec<FromLibrary>,
    /// Settings of the output.
    pub output: OutputSettings,
    /// Quantities to record over time.
    pub histories: Vec<PreparedHistory>,
    /// Parts of the run; none if it is one. The model has all that is there in any of them.
    pub stages: Vec<PreparedStage>,
    /// Condition at which the run ends before its end time.
    pub until: Option<PreparedUntil>,
    /// Boundaries whose velocity follows a column of the history.
    pub servos: Vec<PreparedServo>,
    /// Mass that has been added for a longer time step.
    pub mass_scaling: Option<Scaled>,
    /// Probes of the histories.
    pub probes: Vec<Probe<D, N>>,
    /// Curves of one column of the history over another.
    pub curves: Vec<HistoryCurve>,
    /// Sizes and shapes of the elements.
    pub quality: Quality,
    /// Warnings of settings that are possible, but probably not meant.
    pub warnings: Vec<String>,
    /// SHA-256 of the model in hexadecimal digits. Two models are equal if their hashes are.
    pub hash: String,
}

/// A body of the mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PreparedBody {
    /// Its name; of a piece of a packing with its number from 1: `heap-7`.
    pub name: String,
    /// Nodes of the body.
    pub nodes: Range<u32>,
    /// Elements of the body.
    pub elements: Range<u32>,
}

/// A named part of a body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group<const D: usize = 2> {
    /// Number of its body.
    pub body: u32,
    /// Its name in the mesh file, or `outer`, `holes`, `hole-1`, ….
    pub name: String,
    /// Nodes of the group, ascending.
    pub nodes: Vec<u32>,
    /// Its outer facets: edges in the direction in which their triangle has them; faces with their nodes
    /// counter-clockwise seen from outside.
    pub facets: Vec<[u32; D]>,
}

/// A part of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreparedStage {
    /// Name of the stage.
    pub name: String,
    /// Time that it takes at most, s.
    pub duration: Option<f64>,
    /// Bound of the kinetic over the strain energy, and of the imbalance of forces, at which it ends.
    pub equilibrium: Option<f64>,
    /// Condition on the history at which it ends.
    pub until: Option<PreparedUntil>,
    /// Whether each element of the model is there.
    pub elements: Vec<bool>,
    /// Material of each element of the model; empty if no stage changes them.
    pub materials: Vec<u32>,
    /// Whether each boundary of the model acts.
    pub boundaries: Vec<bool>,
    /// Whether each injection pumps; `None` if there is no fluid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub injections: Option<Vec<bool>>,
    /// Whether each surface of pores acts; `None` if pores have no liquid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pore_surfaces: Option<Vec<bool>>,
    /// Factor of the forces of all that vanishes at its beginning; `None` if they vanish too.
    pub release: Option<Schedule>,
    /// Local damping.
    pub local_damping: f64,
    /// Whether dynamic relaxation damps it.
    pub dynamic_relaxation: bool,
    /// Whether displacements count from its beginning.
    pub resets: bool,
}

/// A model in two or in three dimensions that is ready to run.
#[derive(Debug, Clone)]
pub enum AnyPrepared {
    /// A model of triangles in the plane.
    Plane(Box<Prepared>),
    /// A model of tetrahedra in space.
    Space(Box<Prepared<3, 4>>),
}
