//! The trait of actions on the bodies: the state that they see, the forces that they add, and their memory.

use std::collections::BTreeMap;
use std::fmt;

use fdem_distributed::wire;
use fdem_distributed::wire::{Wire, bytes_of, value_of};
use serde::{Deserialize, Serialize};

use crate::energy::Ledger;
use crate::error::{ModelError, Stop};
use crate::faces::BrokenSides;
use crate::joints::Joints;
use crate::machine::Machine;
use crate::model::{Model, Schedule};
use crate::peers::Peers;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Sum;
use crate::team::Team;
use crate::topology::{NONE, Topology};
use crate::vector::{Point, add};

/// The state of a run, as actions see it.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a, const D: usize, const N: usize> {
    pub(crate) model: &'a Model<D, N>,
    pub(crate) topology: &'a Topology<D, N>,
    pub(crate) machine: &'a dyn Machine<D, N>,
    pub(crate) team: &'a Team,
    /// Time of the positions, s.
    pub(crate) time: f64,
    /// Time step, s.
    pub(crate) step: f64,
}

impl<'a, const D: usize, const N: usize> Scene<'a, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Nodes and elements. An action that has nothing to do does not ask for them: a machine with a memory of
    /// its own copies them.
    pub(crate) fn solid(&self) -> &'a Solid<D, N> {
        &self.machine.columns().solid
    }

    pub(crate) fn joints(&self) -> &'a Joints<D> {
        &self.machine.columns().joints
    }

    /// Whether this rank counts the data that all ranks know: one of them does.
    pub(crate) fn counts_common(&self) -> bool {
        self.topology.is_whole()
            || self.topology.element(0).is_some_and(|first| self.machine.share().element(first))
    }
}

/// A step in which actions add forces to the corners of elements.
pub(crate) struct Acting<'a, const D: usize, const N: usize>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The state, without the forces of actions.
    pub(crate) scene: Scene<'a, D, N>,
    /// The other ranks, which act in the same step.
    pub(crate) peers: &'a dyn Peers<D, N>,
    /// The factor of each boundary in time.
    pub(crate) schedules: &'a [Schedule],
    /// The reason why the run cannot continue after this step.
    pub(crate) stop: &'a mut Option<Stop>,
    pub(crate) applied: &'a mut Vec<Applied<D>>,
    /// Forces on corners of elements, N, in the order in which they are added.
    pub(crate) forces: &'a mut Vec<(u32, Point<D>)>,
}

impl<'a, const D: usize, const N: usize> Acting<'a, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Nodes and elements: see [`Scene::solid`].
    pub(crate) fn solid(&self) -> &'a Solid<D, N> {
        self.scene.solid()
    }

    /// Notes that the run cannot continue after this step. The first reason counts.
    pub(crate) fn fail(&mut self, stop: Stop) {
        self.stop.get_or_insert(stop);
    }

    /// Adds forces whose work is external work. Forces that are the gradient of an energy of the action are
    /// added with [`Acting::add_force`] instead.
    pub(crate) fn apply(&mut self, list: impl FnOnce(&mut Vec<Applied<D>>)) {
        let first = self.applied.len();
        list(self.applied);
        let on = |&Applied { corner, force, .. }: &Applied<D>| (corner, force);
        self.forces.extend(self.applied[first..].iter().map(on));
    }

    /// Adds a force, N, on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&mut self, corner: u32, force: Point<D>) {
        self.forces.push((corner, force));
    }
}

/// A force on a corner of an element in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Applied<const D: usize> {
    pub(crate) corner: u32,
    /// The boundary that exerts the force, or [`NONE`].
    pub(crate) boundary: u32,
    /// Whole force, N.
    pub(crate) force: Point<D>,
    /// Part of the force that dissipates, N.
    pub(crate) viscous: Point<D>,
}

/// A part of the memory of an action between steps. It belongs to one element, to two, or to none; then all
/// ranks have it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Place of the action in the list of all kinds.
    pub(crate) action: u32,
    /// Codes of corners or facets of the two elements, equal for one element; [`NONE`] for none.
    pub(crate) codes: [u32; 2],
    /// Number among the records with these codes.
    pub(crate) place: u32,
    /// Name of the boundary to which it belongs; empty for none.
    pub(crate) boundary: String,
    value: Vec<u8>,
}

wire!([] Record { action, codes, place, boundary, value });

impl Record {
    /// A record of an action, whose place is set later.
    pub(crate) fn new(codes: [u32; 2], place: u32, value: &impl Wire) -> Self {
        Self { action: NONE, codes, place, boundary: String::new(), value: bytes_of(value) }
    }

    /// A record that belongs to a boundary, and to no element.
    pub(crate) fn of_boundary(name: &str, place: u32, value: &impl Wire) -> Self {
        Self { boundary: name.to_owned(), ..Self::new([NONE; 2], place, value) }
    }

    /// The value, if it has the size of this one.
    pub(crate) fn value<T: Wire>(&self, like: &T) -> Option<T> {
        (self.value.len() == bytes_of(like).len()).then(|| value_of(&self.value))
    }

    /// Whether it belongs to no element.
    pub(crate) fn is_common(&self) -> bool {
        self.codes == [NONE; 2]
    }

    /// The record with other numbers of elements; `None` if one of its elements has no number there.
    pub(crate) fn renumbered<const N: usize>(mut self, number: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        if !self.is_common() {
            for code in &mut self.codes {
                *code = number(*code / N as u32)? * N as u32 + *code % N as u32;
            }
        }
        Some(self)
    }
}

/// Events of a run, for the actions that measure it.
pub(crate) enum Event<'a, const D: usize> {
    /// The nodes have moved.
    Moved,
    /// These joints have broken, on any rank.
    Broke(&'a [BrokenSides<D>]),
}

/// A kind of action. Methods that a kind does not need have a default that does nothing.
pub(crate) trait Action<const D: usize, const N: usize>: fmt::Debug + Send + Sync
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Adds the forces at the present positions.
    fn act(&mut self, acting: &mut Acting<'_, D, N>);

    /// Acceleration that it gives to all nodes, m/s²; `None` for an action that gives none.
    fn acceleration(&self, _model: &Model<D, N>, _time: f64) -> Option<Point<D>> {
        None
    }

    /// Force on each corner at the beginning, N; empty for none.
    fn initial_forces(&self, _scene: &Scene<'_, D, N>, _schedules: &[Schedule]) -> Vec<Point<D>> {
        Vec::new()
    }

    /// Sets static forces so that they hold the nodes in equilibrium at the beginning. `others`: force on a
    /// corner besides that of its element, N.
    fn support(&mut self, _scene: &Scene<'_, D, N>, _others: &dyn Fn(u32) -> Point<D>) {}

    /// Works that are known only when all forces of a step are, J. `applied`: forces whose work is counted
    /// already.
    fn works(&mut self, _scene: &Scene<'_, D, N>, _applied: &[Applied<D>]) -> Vec<f64> {
        Vec::new()
    }

    /// Adds its energies at the present positions, J, as far as this rank counts them.
    fn add_energies(&self, _scene: &Scene<'_, D, N>, _ledger: &mut Ledger) {}

    /// Begins a run, or continues one whose records have been taken over.
    fn begin(&mut self, _scene: &Scene<'_, D, N>) -> Result<(), ModelError> {
        Ok(())
    }

    /// Whether it measures anything after events.
    fn follows_events(&self) -> bool {
        false
    }

    /// Measures sums of this rank after an event. All ranks have the same number of them.
    fn measure(&mut self, _event: &Event<'_, D>, _scene: &Scene<'_, D, N>) -> Vec<Sum> {
        Vec::new()
    }

    /// Takes these sums over, added up over all ranks. Returns the energy that is dissipated, J.
    fn settle(&mut self, _event: &Event<'_, D>, _sums: &[Sum]) -> f64 {
        0.0
    }

    /// The records that this rank counts.
    fn records(&self, _scene: &Scene<'_, D, N>) -> Vec<Record> {
        Vec::new()
    }

    /// Takes a record over. Returns `false` if it does not fit the model.
    fn take(&mut self, _record: &Record, _scene: &Scene<'_, D, N>) -> bool {
        false
    }
}

/// Numbers of the whole model that a rank needs for the actions on its part.
#[derive(Debug)]
pub(crate) struct Wide {
    /// Number of nodes of the mesh on which each boundary acts.
    pub(crate) nodes: Vec<u32>,
    /// Number of corners at each vertex.
    pub(crate) corners: Vec<u32>,
    /// Half of the longer side of the bounding box of each body, m.
    pub(crate) radii: BTreeMap<u32, f64>,
}

/// Adds up forces of corners in one list. `corners`: number of corners.
pub(crate) fn on_corners<const D: usize>(
    corners: usize,
    forces: impl Iterator<Item = (u32, Point<D>)>,
) -> Vec<Point<D>> {
    let mut all = vec![[0.0; D]; corners];
    forces.for_each(|(corner, force)| add(&mut all[corner as usize], force, 1.0));
    all
}
