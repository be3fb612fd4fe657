//! A model that is ready to run.

use std::ops::Range;

use fdem_mesh::Quality;
use fdem_results::HistoryCurve;
use fdem_simulation::{Boundary, Element, Model, Probe, Schedule, Simulation, Snapshot};
use serde::{Deserialize, Serialize};

use crate::conditions::{Servo, Until};
use crate::joint_sets::Joints;
use crate::library::FromLibrary;
use crate::scaled::Scaled;
use crate::settings::{History, OutputSettings};

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
    pub bodies: Vec<Body>,
    /// Named parts of bodies: physical groups of mesh files; outlines, holes and faces of other shapes.
    pub groups: Vec<Group<D>>,
    /// Grain of each element, numbered within its body; empty if no body has grains.
    pub grains: Vec<u32>,
    /// Joints of each joint set in the mesh.
    pub joint_sets: Vec<Joints>,
    /// Materials that have keys from the library.
    pub from_library: Vec<FromLibrary>,
    /// Settings of the output.
    pub output: OutputSettings,
    /// Quantities to record over time.
    pub histories: Vec<History>,
    /// Parts of the run; none if it is one. The model has all that is there in any of them.
    pub stages: Vec<Stage>,
    /// Condition at which the run ends before its end time.
    pub until: Option<Until>,
    /// Boundaries whose velocity follows a column of the history.
    pub servos: Vec<Servo>,
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
pub struct Body {
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
pub struct Stage {
    /// Name of the stage.
    pub name: String,
    /// Time that it takes at most, s.
    pub duration: Option<f64>,
    /// Bound of the kinetic over the strain energy, and of the imbalance of forces, at which it ends.
    pub equilibrium: Option<f64>,
    /// Condition on the history at which it ends.
    pub until: Option<Until>,
    /// Whether each element of the model is there.
    pub elements: Vec<bool>,
    /// Material of each element of the model; empty if no stage changes them.
    pub materials: Vec<u32>,
    /// Whether each boundary of the model acts.
    pub boundaries: Vec<bool>,
    /// Factor of the forces of all that vanishes at its beginning; `None` if they vanish too.
    pub release: Option<Schedule>,
    /// Local damping.
    pub local_damping: f64,
    /// Whether dynamic relaxation damps it.
    pub dynamic_relaxation: bool,
    /// Whether displacements count from its beginning.
    pub resets: bool,
}

/// The stage that a run is in, and the data that it has kept of the earlier ones.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "Boundary<D>: Serialize, [f64; D]: Serialize",
    deserialize = "Boundary<D>: Deserialize<'de>, [f64; D]: Deserialize<'de>"
))]
pub struct Entered<const D: usize = 2> {
    /// Step at which each stage so far has begun; the last of them is the present one.
    pub begun: Vec<u64>,
    /// Forces of removed parts, on nodes of the whole model.
    pub held: Vec<Boundary<D>>,
    /// Displacements at the last stage that has set them back.
    pub origin: Option<Origin<D>>,
}

/// Displacements, m, from which those of results count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub struct Origin<const D: usize = 2> {
    /// One displacement for each corner of each element, in the order of the elements. Corners at one node of
    /// the mesh differ where the mesh has broken.
    pub corners: Vec<[f64; D]>,
    /// One displacement for each node of the mesh.
    pub nodes: Vec<[f64; D]>,
}

impl<const D: usize> Origin<D> {
    /// The displacements of a run now. `elements`, `nodes`: numbers of its elements and of the nodes of its
    /// mesh in the whole model; `counts`: numbers of elements and nodes of the whole model.
    pub fn of<const N: usize>(
        run: &Simulation<D, N>,
        (elements, nodes): (&[u32], &[u32]),
        counts: [usize; 2],
    ) -> Self
    where
        [[f64; D]; N]: Element<D, N>,
    {
        let mut corners = vec![[0.0; D]; N * counts[0]];
        let snapshot = run.snapshot();
        for (&element, its_nodes) in elements.iter().zip(&snapshot.elements) {
            let of_element = &mut corners[N * element as usize..][..N];
            of_element.copy_from_slice(&its_nodes.map(|node| snapshot.displacements[node as usize]));
        }
        let mut of_nodes = vec![[0.0; D]; counts[1]];
        let own: Vec<u32> = (0..nodes.len() as u32).collect();
        for (&node, found) in nodes.iter().zip(run.nodes(&own)) {
            of_nodes[node as usize] = found.map_or([0.0; D], |(moved, _)| moved);
        }
        Self { corners, nodes: of_nodes }
    }

    /// The part of these elements and nodes, numbered in their order.
    #[must_use]
    pub fn part<const N: usize>(&self, elements: &[u32], nodes: &[u32]) -> Self {
        let of_element = |&element: &u32| self.corners[N * element as usize..][..N].iter().copied();
        Self {
            corners: elements.iter().flat_map(of_element).collect(),
            nodes: nodes.iter().map(|&node| self.nodes[node as usize]).collect(),
        }
    }

    /// Lets the displacements of a snapshot of all of these elements count from here.
    pub fn subtract_from<const N: usize>(&self, snapshot: &mut Snapshot<D, N>) {
        let all = snapshot.displacements.clone();
        for (its_nodes, origins) in snapshot.elements.iter().zip(self.corners.chunks_exact(N)) {
            for (&node, origin) in its_nodes.iter().zip(origins) {
                let node = node as usize;
                snapshot.displacements[node] = std::array::from_fn(|axis| all[node][axis] - origin[axis]);
            }
        }
    }
}

impl<const D: usize> Entered<D> {
    /// A run that begins.
    pub fn first() -> Self {
        Self::alone(0)
    }

    /// A run that has reached the stage of this number without any time in the earlier ones.
    pub fn alone(stage: usize) -> Self {
        Self { begun: vec![0; stage + 1], held: Vec::new(), origin: None }
    }

    /// Number of the present stage.
    pub fn stage(&self) -> usize {
        self.begun.len().saturating_sub(1)
    }
}

/// A model in two or in three dimensions that is ready to run.
#[derive(Debug, Clone)]
pub enum AnyPrepared {
    /// A model of triangles in the plane.
    Plane(Box<Prepared>),
    /// A model of tetrahedra in space.
    Space(Box<Prepared<3, 4>>),
}
