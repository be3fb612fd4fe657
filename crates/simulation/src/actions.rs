//! Actions on the bodies: all forces besides those of elements, joints and contacts.
//!
//! Each kind of action is a file in `src/actions` that implements [`Action`] (`src/action.rs`): it sees the
//! state, adds forces, and names its energies. [`Actions`] has one field for each kind, and two lists that
//! name them all; nothing else knows how many there are. An action returns its memory between steps as
//! [`Record`]s, which belong to elements: checkpoints, stages and ranks carry records and do not depend on
//! their contents.

pub(crate) mod cavity;
pub(crate) mod fluid;
pub(crate) mod gravity;
pub(crate) mod ground;
pub(crate) mod loads;
pub(crate) mod pores;
pub(crate) mod prescribed;
pub(crate) mod program;
pub(crate) mod seams;
pub(crate) mod spheres;

use std::collections::BTreeMap;

use crate::action::{Acting, Action, Applied, Event, Record, Scene, Wide};
use crate::actions::cavity::Cavities;
use crate::actions::fluid::FluidAction;
use crate::actions::gravity::Gravity;
use crate::actions::ground::Ground;
use crate::actions::loads::Loads;
use crate::actions::pores::PoreAction;
use crate::actions::prescribed::Prescribed;
use crate::actions::program::Program;
use crate::actions::seams::Seams;
use crate::actions::spheres::SphereAction;
use crate::energy::Ledger;
use crate::error::{ModelError, Stop};
use crate::machine::Machine;
use crate::model::{Load, Model, Schedule};
use crate::peers::Peers;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Sum;
use crate::topology::{NONE, Topology};
use crate::vector::{Point, add, dot, plus};

/// All actions on a model.
#[derive(Debug)]
pub(crate) struct Actions<const D: usize = 2, const N: usize = 3> {
    /// The factor of each boundary in time.
    pub(crate) schedules: Vec<Schedule>,
    /// Factors of boundaries that the caller has set in place of their schedules.
    pub(crate) factors: BTreeMap<u32, f64>,
    /// Motions of nodes that boundaries prescribe. They add no force: the motion of the nodes finds their
    /// reactions.
    pub(crate) prescribed: Prescribed<D>,
    pub(crate) seams: Seams<D>,
    loads: Loads<D, N>,
    pub(crate) ground: Ground<D, N>,
    pub(crate) program: Program<D>,
    pub(crate) cavities: Cavities<D>,
    pub(crate) fluid: FluidAction<D>,
    pub(crate) pores: PoreAction<D, N>,
    gravity: Gravity,
    pub(crate) spheres: SphereAction<D>,
    /// Forces of this step whose work is external work.
    applied: Vec<Applied<D>>,
    /// Forces of this step on corners of elements, N.
    forces: Vec<(u32, Point<D>)>,
}

impl<const D: usize, const N: usize> Actions<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Checks the boundaries, and marks the nodes that they hold. `wide`: numbers of the whole model, if this
    /// is a part.
    pub(crate) fn new(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        solid: &mut Solid<D, N>,
        wide: Option<&Wide>,
    ) -> Result<Self, ModelError> {
        let ground = Ground::new(model, topology, wide.map(|wide| &wide.radii))?;
        let mut prescribed = Prescribed::default();
        let mut loads = Loads::default();
        let mut cavities = Cavities::default();
        for (number, boundary) in (0..).zip(&model.boundaries) {
            let is_part = wide.is_some();
            if cavities.add(number, model, is_part)? || is_part && boundary.target.is_empty() {
                continue;
            }
            if !prescribed.prescribe(number, model, solid)? {
                loads.load(number, model, topology, wide)?;
            }
        }
        Ok(Self {
            schedules: model.boundaries.iter().map(|boundary| boundary.schedule.clone()).collect(),
            factors: BTreeMap::new(),
            prescribed,
            seams: Seams::default(),
            loads,
            ground,
            program: Program::default(),
            cavities,
            fluid: FluidAction::default(),
            pores: PoreAction::default(),
            gravity: Gravity,
            spheres: SphereAction::default(),
            applied: Vec::new(),
            forces: Vec::new(),
        })
    }

    /// All kinds of actions, in the order in which their forces are added.
    fn all(&self) -> [&dyn Action<D, N>; 9] {
        let Self { seams, loads, ground, program, cavities, gravity, spheres, fluid, pores, .. } = self;
        [seams, loads, ground, program, cavities, gravity, spheres, fluid, pores]
    }

    /// The same list.
    fn all_mut(&mut self) -> ([&mut dyn Action<D, N>; 9], &mut Vec<Applied<D>>, &[Schedule]) {
        let Self { seams, loads, ground, program, cavities, gravity, spheres, fluid, pores, .. } = self;
        let all: [&mut dyn Action<D, N>; 9] =
            [seams, loads, ground, program, cavities, gravity, spheres, fluid, pores];
        (all, &mut self.applied, &self.schedules)
    }

    /// The forces of all actions on corners of elements, N, in the order in which they are added, and the
    /// reason why the run cannot continue after this step.
    pub(crate) fn act(
        &mut self,
        scene: Scene<'_, D, N>,
        peers: &dyn Peers<D, N>,
    ) -> (&[(u32, Point<D>)], Option<Stop>) {
        let mut forces = std::mem::take(&mut self.forces);
        forces.clear();
        if self.fluid.needs_pores(scene.model.fluid.as_ref()) {
            self.fluid.know_pores(self.pores.elements().iter().copied().zip(self.pores.pushes()));
        }
        let (all, applied, schedules) = self.all_mut();
        applied.clear();
        let mut stop = None;
        let mut acting = Acting { scene, peers, schedules, stop: &mut stop, applied, forces: &mut forces };
        for action in all {
            action.act(&mut acting);
        }
        // Cracks and pores exchange fluid.
        let Self { pores, fluid, applied, schedules, .. } = self;
        let mut acting = Acting { scene, peers, schedules, stop: &mut stop, applied, forces: &mut forces };
        pores.act_beside(fluid, &mut acting);
        self.forces = forces;
        (&self.forces, stop)
    }

    /// Acceleration of all nodes, m/s².
    pub(crate) fn acceleration(&self, model: &Model<D, N>, time: f64) -> Point<D> {
        let all = self.all().into_iter().filter_map(|action| action.acceleration(model, time));
        all.reduce(plus).unwrap_or([0.0; D])
    }

    /// Holds the nodes of absorbing facets in equilibrium at the beginning, under initial stress, weight, and
    /// the forces of the other actions and of joints.
    pub(crate) fn support(&mut self, scene: &Scene<'_, D, N>) {
        if self.ground.is_empty() {
            return;
        }
        let forces = self.all().map(|action| action.initial_forces(scene, &self.schedules));
        let [of_seams, of_others @ ..] = forces;
        let others = |corner: u32| {
            let mut force = of_seams.get(corner as usize).copied().unwrap_or([0.0; D]);
            scene.joints().add_initial_force(corner, scene.solid(), &mut force);
            for of_action in &of_others {
                if let Some(more) = of_action.get(corner as usize) {
                    add(&mut force, *more, 1.0);
                }
            }
            force
        };
        for action in self.all_mut().0 {
            action.support(scene, &others);
        }
    }

    /// Works that are known only when all forces of a step are, J.
    pub(crate) fn works(&mut self, scene: &Scene<'_, D, N>) -> Vec<f64> {
        let (all, applied, _) = self.all_mut();
        all.into_iter().flat_map(|action| action.works(scene, applied)).collect()
    }

    /// Works of the applied forces in half a step at the nodes' velocities: of loads, and of the dashpots of
    /// absorbing facets, one pair for each force.
    pub(crate) fn half_works(&self, machine: &dyn Machine<D, N>, step: f64) -> Vec<[f64; 2]> {
        let corners: Vec<u32> = self.applied.iter().map(|applied| applied.corner).collect();
        let mut works = Vec::with_capacity(corners.len());
        let (mut all, share) = (self.applied.iter(), machine.share());
        machine.read_corners(&corners, &mut |node| {
            let Some(applied) = all.next().filter(|applied| share.corner(applied.corner)) else { return };
            let absorbed = 0.5 * step * dot(applied.viscous, node.velocity);
            works.push([0.5 * step * dot(applied.force, node.velocity) - absorbed, absorbed]);
        });
        works
    }

    /// The forces that were applied in the last step on corners that this rank owns, each with its boundary,
    /// or [`NONE`], and its corner.
    pub(crate) fn applied(&self, solid: &Solid<D, N>) -> impl Iterator<Item = ([u32; 2], Point<D>)> {
        self.owned(solid).map(|applied| ([applied.boundary, applied.corner], applied.force))
    }

    fn owned(&self, solid: &Solid<D, N>) -> impl Iterator<Item = &Applied<D>> {
        self.applied.iter().filter(|applied| solid.share().corner(applied.corner))
    }

    /// Adds the energies of all actions, J.
    pub(crate) fn add_energies(&self, scene: &Scene<'_, D, N>, ledger: &mut Ledger) {
        for action in self.all() {
            action.add_energies(scene, ledger);
        }
    }

    /// The memory of the actions, as far as this rank counts it, in one order.
    pub(crate) fn records(&self, scene: &Scene<'_, D, N>) -> Vec<Record> {
        let numbered = |(number, action): (u32, &dyn Action<D, N>)| {
            let mut records = action.records(scene);
            for record in &mut records {
                record.action = number;
            }
            records
        };
        let mut records: Vec<Record> = (0..).zip(self.all()).flat_map(numbered).collect();
        records.sort_unstable();
        records
    }

    /// Takes a record over. Returns `false` if it does not fit the model.
    pub(crate) fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let mut all = self.all_mut().0;
        all.get_mut(record.action as usize).is_some_and(|action| action.take(record, scene))
    }

    /// Begins a run, or continues one whose records have been taken over.
    pub(crate) fn begin(&mut self, scene: &Scene<'_, D, N>) -> Result<(), ModelError> {
        self.all_mut().0.into_iter().try_for_each(|action| action.begin(scene))
    }

    /// Whether any action measures anything after events.
    pub(crate) fn follow_events(&self) -> bool {
        self.all().into_iter().any(Action::follows_events)
    }

    /// The sums of this rank after an event, of each action.
    pub(crate) fn measure(&mut self, event: &Event<'_, D>, scene: &Scene<'_, D, N>) -> Vec<Vec<Sum>> {
        self.all_mut().0.into_iter().map(|action| action.measure(event, scene)).collect()
    }

    /// Gives the sums back to their actions, added up over all ranks. Returns the energy that is dissipated,
    /// J.
    pub(crate) fn settle(&mut self, event: &Event<'_, D>, sums: &[Vec<Sum>]) -> f64 {
        let all = self.all_mut().0.into_iter().zip(sums);
        all.map(|(action, sums)| action.settle(event, sums)).sum()
    }

    /// Sets the factor of a boundary in place of its schedule; `None` gives it its schedule back.
    pub(crate) fn set_factor(
        &mut self,
        model: &Model<D, N>,
        boundary: usize,
        factor: Option<f64>,
    ) -> Result<(), ModelError> {
        let number = u32::try_from(boundary).unwrap_or(NONE);
        let Some(of_model) = model.boundaries.get(boundary) else {
            let place = "factors that are set".to_owned();
            return Err(ModelError::Missing { what: "boundary", index: number, place });
        };
        if of_model.load == Load::Absorbing {
            return Err(ModelError::NoFactor { boundary: of_model.name.clone() });
        }
        if let Some(value) = factor.filter(|factor| !factor.is_finite()) {
            let place = format!("boundary '{}'", of_model.name);
            return Err(ModelError::OutOfRange { place, what: "the factor", value, range: "a number" });
        }
        if let Some(factor) = factor {
            self.factors.insert(number, factor);
            self.schedules[boundary] = Schedule::Table(vec![[0.0, factor]]);
        } else {
            self.factors.remove(&number);
            self.schedules[boundary] = of_model.schedule.clone();
        }
        Ok(())
    }
}
