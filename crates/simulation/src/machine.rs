//! The machine of a run: it has the columns, and computes the phases of a step on them.
//!
//! A column has a value of every node, element, corner, joint or couple. The phases read and write whole
//! columns. Everything else that a step does is apart from them, and reaches the columns through the machine
//! only: insertion and splitting (`simulation/breaking.rs`), the audit (`simulation/audit.rs`), snapshots,
//! states that are saved, and messages to other ranks.
//!
//! The threads of the processor are one machine: `machine/threads.rs`. A machine with a memory of its own
//! keeps its columns there; it returns them when [`Machine::columns`] asks for them, and takes changed ones
//! over before the next phase: `machine/on_device.rs`.

pub(crate) mod list;
pub(crate) mod on_device;
mod threads;

use std::fmt;

use crate::accelerator::Accelerator;
use crate::contacts::{Contacts, Touching};
use crate::error::Stop;
use crate::joints::{Joints, Pulling};
use crate::model::Model;
use crate::motion::nodes::Motion;
use crate::motion::{MotionSums, Selected};
use crate::share::Share;
use crate::solid::{Node, Solid};
use crate::sum::Sum;
use crate::topology::Topology;
use crate::vector::Point;

/// The columns of a run.
#[derive(Clone, Debug)]
pub(crate) struct Columns<const D: usize, const N: usize> {
    /// Nodes, elements and their corners.
    pub(crate) solid: Solid<D, N>,
    pub(crate) joints: Joints<D>,
    /// Couples of elements.
    pub(crate) contacts: Contacts<D, N>,
}

/// Nodes, elements and joints whose present values something reads.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wanted {
    /// Nodes of which the positions are read, and nothing else.
    pub(crate) positions: Vec<u32>,
    pub(crate) nodes: Vec<u32>,
    pub(crate) elements: Vec<u32>,
    pub(crate) joints: Vec<u32>,
}

impl Wanted {
    /// Whether nothing is read.
    fn is_empty(&self) -> bool {
        let Self { positions, nodes, elements, joints } = self;
        [positions, nodes, elements, joints].iter().all(|list| list.is_empty())
    }
}

/// The columns of a run, and the phases of a step, which are called in the order of these functions.
///
/// All machines give the same bits: sums over corners go in the order of the corners, those over couples in
/// the order of the couples, and sums of energies are exact.
pub(crate) trait Machine<const D: usize, const N: usize>: fmt::Debug + Send + Sync {
    /// Computes the stresses of all elements, and sets the forces on their corners. `step`: time step, s.
    /// Returns the first inverted element, with its ratio of deformed to undeformed area or volume.
    fn deform(&mut self, step: f64) -> Option<(u32, f64)>;

    /// Computes the forces of all joints at a time, s. `energies`: whether to compute their elastic energy.
    fn pull(&mut self, step: f64, time: f64, energies: bool) -> Pulling;

    /// Finds the couples of elements that may touch.
    fn detect(&mut self, topology: &Topology<D, N>) -> Result<(), Stop>;

    /// Computes the forces of all couples, and adds them to the forces on corners. `energies`: whether to
    /// compute the energy of their potentials.
    fn touch(&mut self, topology: &Topology<D, N>, step: f64, energies: bool) -> Touching;

    /// Adds forces, N, to those on corners, in this order.
    fn add_forces(&mut self, forces: &[(u32, Point<D>)]);

    /// The facets, ascending, on which the forces have reached the strength.
    fn failing(&mut self, model: &Model<D, N>, topology: &Topology<D, N>) -> Vec<u32>;

    /// Gathers the forces on the selected nodes, moves these nodes, and adds to the sums over all nodes.
    fn move_nodes(
        &mut self,
        motion: &Motion<'_, D, N>,
        selected: Selected<'_>,
        sums: &mut MotionSums<Sum, D>,
    );

    /// Calls `each` with the present positions and velocities of some nodes, in this order.
    fn read_nodes(&self, nodes: &[u32], each: &mut dyn FnMut(Node<D>));

    /// Calls `each` with the present positions and velocities of the nodes of some corners, in this order.
    fn read_corners(&self, corners: &[u32], each: &mut dyn FnMut(Node<D>));

    /// The share of this rank.
    fn share(&self) -> &Share;

    /// Sets the positions and velocities of some nodes, in this order, to those that `next` returns.
    fn write_nodes(&mut self, nodes: &[u32], next: &mut dyn FnMut() -> Node<D>);

    /// Ends the motion of all nodes: none has moved farther than this in the step, m.
    fn end_motion(&mut self, distance: f64);

    /// Strain energy in the last pass, and energy that viscosity and laws have dissipated so far, J.
    fn energies(&self) -> [Sum; 2];

    /// Calls `look` with the columns, of which the values of the wanted nodes, elements and joints are those
    /// after the last phase, and all that no device changes: numbers, rigid bodies with their nodes and the
    /// forces on them, the states of joints. `look` does not ask for [`Machine::columns`].
    fn look_at(&self, wanted: &Wanted, look: &mut dyn FnMut(&Columns<D, N>)) {
        let _ = wanted;
        look(self.columns());
    }

    /// The columns after the last phase.
    fn columns(&self) -> &Columns<D, N>;

    /// The columns after the last phase, to be changed before the next one.
    fn columns_mut(&mut self) -> &mut Columns<D, N>;

    /// Calls `change` with the columns. It puts joints on these facets, and splits the nodes of their
    /// vertices; of nodes, elements and joints it reads and changes those around these vertices only.
    fn change_at(
        &mut self,
        _facets: &[u32],
        _topology: &Topology<D, N>,
        change: &mut dyn FnMut(&mut Columns<D, N>),
    ) {
        change(self.columns_mut());
    }

    /// The reason if the machine has failed, so that values that it has returned are not those of the run.
    fn check(&self) -> Result<(), Stop> {
        Ok(())
    }

    /// The device that computes the phases, for another run; none if there is none.
    fn into_device(self: Box<Self>) -> Option<Box<dyn Accelerator<D, N>>> {
        None
    }
}
