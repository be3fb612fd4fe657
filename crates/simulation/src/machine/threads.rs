//! The threads of the processor as a machine.

use crate::contacts::Touching;
use crate::error::Stop;
use crate::joints::Pulling;
use crate::machine::{Columns, Machine};
use crate::model::Model;
use crate::motion::nodes::{self, Motion};
use crate::motion::{MotionSums, Selected, rigid};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::Node;
use crate::sum::Sum;
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::Point;

/// Threads that share the memory of the process.
#[derive(Debug)]
pub(super) struct Threads<const D: usize, const N: usize> {
    columns: Columns<D, N>,
    /// The corners on which loads act in this step, with repetitions.
    loaded: Vec<u32>,
    team: Team,
}

impl<const D: usize, const N: usize> Threads<D, N> {
    pub(super) fn new(columns: Columns<D, N>, team: Team) -> Self {
        Self { columns, loaded: Vec::new(), team }
    }
}

impl<const D: usize, const N: usize> Machine<D, N> for Threads<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn deform(&mut self, step: f64) -> Option<(u32, f64)> {
        self.columns.solid.deform(step, &self.team)
    }

    fn pull(&mut self, step: f64, time: f64, energies: bool) -> Pulling {
        let Columns { solid, joints, .. } = &mut self.columns;
        joints.pull(solid, step, time, energies, &self.team)
    }

    fn detect(&mut self, topology: &Topology<D, N>) -> Result<(), Stop> {
        let Columns { solid, joints, contacts } = &mut self.columns;
        contacts.detect(solid, joints, topology, &self.team)
    }

    fn touch(&mut self, topology: &Topology<D, N>, step: f64, energies: bool) -> Touching {
        let Columns { solid, joints, contacts } = &mut self.columns;
        contacts.press(solid, joints, topology, step, energies, &self.team)
    }

    fn add_forces(&mut self, forces: &[(u32, Point<D>)]) {
        for &(corner, force) in forces {
            self.columns.solid.add_force(corner, force);
        }
        self.loaded.extend(forces.iter().map(|(corner, _)| corner));
    }

    fn failing(&mut self, model: &Model<D, N>, topology: &Topology<D, N>) -> Vec<u32> {
        let Columns { solid, joints, contacts } = &mut self.columns;
        let loaded = std::mem::take(&mut self.loaded);
        if !joints.inserts() {
            return Vec::new();
        }
        let mut pressed = contacts.touching(&self.team);
        pressed.extend(loaded.into_iter().map(|corner| corner / N as u32));
        joints.failing(solid, pressed, model, topology, &self.team)
    }

    fn move_nodes(
        &mut self,
        motion: &Motion<'_, D, N>,
        selected: Selected<'_>,
        sums: &mut MotionSums<Sum, D>,
    ) {
        let Columns { solid, joints, .. } = &mut self.columns;
        // Rigid bodies move with the nodes that other ranks wait for, if there are any.
        let awaited = matches!(selected, Selected::Only([_, ..]) | Selected::Except([]));
        if awaited {
            rigid::advance(solid, motion, &self.team, sums);
        }
        nodes::advance(solid, joints, motion, &self.team, selected, sums);
    }

    fn read_nodes(&self, nodes: &[u32], each: &mut dyn FnMut(Node<D>)) {
        for &node in nodes {
            each(self.columns.solid.node(node as usize));
        }
    }

    fn read_corners(&self, corners: &[u32], each: &mut dyn FnMut(Node<D>)) {
        let solid = &self.columns.solid;
        for &corner in corners {
            each(solid.node(solid.node_at(corner) as usize));
        }
    }

    fn share(&self) -> &Share {
        self.columns.solid.share()
    }

    fn write_nodes(&mut self, nodes: &[u32], next: &mut dyn FnMut() -> Node<D>) {
        for &node in nodes {
            self.columns.solid.set_node(node as usize, next());
        }
    }

    fn end_motion(&mut self, distance: f64) {
        self.columns.contacts.note_motion(distance);
    }

    fn energies(&self) -> [Sum; 2] {
        self.columns.solid.energies(&self.team)
    }

    fn columns(&self) -> &Columns<D, N> {
        &self.columns
    }

    fn columns_mut(&mut self) -> &mut Columns<D, N> {
        &mut self.columns
    }
}
