//! A run of a model: its state, and the time step that advances it.

mod actions;
mod audit;
mod changed;
mod relaxation;
mod saved;
mod shown;

use std::time::{Duration, Instant};

use fdem_contact::Simd;

use crate::checks;
use crate::contacts::{Contacts, Touching, mean_edge};
use crate::critical::CriticalStep;
use crate::energy::Energies;
use crate::error::{ModelError, Stop};
use crate::forces::{Forces, OwnForces};
use crate::joints::Joints;
use crate::lanes::Available;
use crate::loads::{self, Loads};
use crate::model::{Insertion, Model};
use crate::motion::{self, Motion, Moved};
use crate::ranks::wire::wire;
use crate::ranks::{Links, Part, Told};
use crate::seams::Seams;
use crate::share::Share;
use crate::simplex::Simplex;
pub(crate) use crate::simulation::actions::Actions;
pub(crate) use crate::simulation::audit::{Relaxation, Totals};
pub use crate::simulation::changed::Change;
pub use crate::simulation::saved::State;
pub(crate) use crate::simulation::shown::{cracks, mode};
use crate::solid::Solid;
use crate::sum::{Grains, Sum};
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::Point;

/// A run stops when a node is faster than this multiple of the highest wave speed √(E/ρ) of the materials.
const RUNAWAY: f64 = 10.0;

/// Energy errors are ignored while the exchanged energy is below that of a uniform strain of this size, plus [`NEGLIGIBLE_SHARE`] of the initial strain energy.
const NEGLIGIBLE_STRAIN: f64 = 1e-8;

/// Share of the initial strain energy that is added to this limit, because coordinates are rounded.
const NEGLIGIBLE_SHARE: f64 = 1e-9;

/// A run of a model.
///
/// # Example
/// ```
/// # use fdem_simulation::*;
/// # let mesh = Mesh { nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], elements: vec![[0, 1, 2]], bodies: vec![0], materials: vec![0] };
/// # let material = Material { name: "rock".to_owned(), density: 2700.0, youngs_modulus: 50e9, poissons_ratio: 0.25, damping: 0.0, strength: None, friction: 0.5 };
/// let model = Model { mesh, materials: vec![material], gravity: [0.0, -9.81], ..Model::default() };
/// let mut run = Simulation::new(model, 1)?;
/// run.advance(1000)?;
/// let fallen = run.snapshot().displacements[0][1];
/// assert!((fallen / (-9.81 / 2.0 * run.time().powi(2)) - 1.0).abs() < 2e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Simulation<const D: usize = 2, const N: usize = 3> {
    pub(crate) model: Model<D, N>,
    pub(crate) topology: Topology<D, N>,
    pub(crate) solid: Solid<D, N>,
    pub(crate) joints: Joints<D>,
    pub(crate) contacts: Contacts<D, N>,
    pub(crate) seams: Seams<D>,
    pub(crate) loads: Loads<D, N>,
    pub(crate) team: Team,
    pub(crate) scales: Scales,
    pub(crate) step: u64,
    pub(crate) totals: Totals,
    /// Energies at the beginning of the last step that they were asked for, J: of the last step of [`Simulation::advance`].
    pub(crate) energies: Energies,
    /// Force of each boundary on the bodies then, N.
    pub(crate) reactions: Vec<Point<D>>,
    /// Largest force on a free node over the largest force of an element on a node, at the beginning of the last step that energies were asked for.
    pub(crate) imbalance: f64,
    /// Force on each node that a boundary moves, at the beginning of the last step, N.
    pub(crate) held: Vec<(u32, Point<D>)>,
    pub(crate) touching: Touching,
    pub(crate) timings: Timings,
    /// What the caller has set between steps.
    pub(crate) actions: Actions<D>,
    /// The part of a run that this rank has; `None` for a whole run.
    pub(crate) part: Option<Part<D>>,
}

/// Numbers of a model that all of its parts share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    pub(crate) critical: CriticalStep,
    /// Time step, s.
    pub(crate) time_step: f64,
    /// Largest speed of a node at which the run continues, m/s.
    pub(crate) speed_limit: f64,
    /// Energy of the stiffest element at a strain of 1, J, or that of the heaviest node at the greatest speed that is prescribed, if that is more: the size of the works that are added up.
    pub(crate) size: f64,
    /// Exchanged energy below which the energy balance is not checked, J.
    pub(crate) negligible: f64,
}

wire!([] Scales { critical, time_step, speed_limit, size, negligible });

/// The parts of a simulation that depend on its elements.
pub(crate) struct Parts<const D: usize, const N: usize> {
    pub(crate) topology: Topology<D, N>,
    pub(crate) solid: Solid<D, N>,
    pub(crate) joints: Joints<D>,
    pub(crate) contacts: Contacts<D, N>,
    pub(crate) seams: Seams<D>,
    pub(crate) loads: Loads<D, N>,
}

/// Time spent in each part of the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    /// Stress and forces of elements.
    pub bulk: Duration,
    /// Insertion of joints and their forces.
    pub joints: Duration,
    /// Detection of contacts: boxes and couples.
    pub detection: Duration,
    /// Forces of contacts.
    pub contact: Duration,
    /// Loads and motion.
    pub integration: Duration,
    /// Messages to other ranks, and waiting for theirs.
    pub messages: Duration,
}

/// Numbers of joints, contacts and nodes, which change during a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Joints that hold, elastic or softening.
    pub joints: usize,
    /// Broken joints.
    pub broken: usize,
    /// Couples of elements that overlap.
    pub contacts: usize,
    /// Number of detections of couples so far.
    pub detections: u64,
    /// Nodes.
    pub nodes: usize,
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Creates a run on `threads` threads; 0 stands for one per processor. Results do not depend on the number of threads.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated.
    pub fn new(model: Model<D, N>, threads: usize) -> Result<Self, ModelError> {
        checks::check(&model)?;
        let topology = Topology::of(&model.mesh)?;
        let mut joints = Joints::new(&model, &topology, &Share::default());
        // Before all that a run keeps, because it takes much memory for a moment.
        let critical = CriticalStep::new(&model, &topology, &joints);
        let mut solid = Solid::new(&model);
        // Checks the laws of all facets now, so that none can fail during the run.
        for facet in 0..topology.facets.len() as u32 {
            joints.law(facet, &model, &topology)?;
        }
        let mut loads = Loads::new(&model, &topology, &mut solid, None)?;
        let team = Team::new(threads)?;
        let contacts = Contacts::new(&model, &topology, mean_edge(&model), &team)?;
        if model.fracture.insertion == Insertion::Intrinsic {
            solid.reserve_nodes(N * model.mesh.elements.len());
            joints.everywhere(&model, &topology)?;
        } else {
            joints.of_sets(&model, &topology)?;
        }
        // This also separates elements that have only a vertex in common.
        for vertex in 0..topology.vertex_count() as u32 {
            joints.part(vertex, &mut solid, false, &model, &topology);
        }
        if model.fracture.insertion == Insertion::Intrinsic {
            solid.number_by_corners();
            joints.find_nodes(&topology, &solid);
        }
        let seams = Seams::new(&model, &topology, &solid)?;
        if solid.is_prestressed() {
            let by_seams = seams.initial_forces(&solid);
            loads.support(&model, &solid, |corner| {
                let mut force = by_seams.get(corner as usize).copied().unwrap_or([0.0; D]);
                joints.add_initial_force(corner, &solid, &mut force);
                force
            });
        }
        let wave = |material: &crate::model::Material| (material.youngs_modulus / material.density).sqrt();
        let speed_limit = RUNAWAY * model.materials.iter().map(wave).fold(0.0, f64::max);
        let modulus = |material: u32| model.materials[material as usize].youngs_modulus;
        let stiffnesses = || solid.elements.iter().map(|element| element.volume * modulus(element.material));
        let stiffness: Sum = stiffnesses().collect();
        let time_step = model.time.step.unwrap_or(critical.step * model.time.safety);
        let heaviest = solid.constants.iter().map(|node| node.mass).fold(0.0, f64::max);
        let fastest = loads::fastest(&model, time_step).min(speed_limit);
        // A node of a light body may rebound at twice the speed of a heavy one. Then it has four times the kinetic energy, m/2 v².
        let size = stiffnesses().fold(4.0 * heaviest * fastest * fastest, f64::max);
        solid.grains = Grains::of(size);
        let [strain, _] = solid.energies(&team).map(|sum| sum.value());
        let cohesive = joints.stored(&solid);
        let totals = Totals { most_cohesive: cohesive.value(), cohesive, ..Totals::default() };
        let scales = Scales {
            critical,
            time_step,
            speed_limit,
            size,
            negligible: 0.5 * stiffness.value() * NEGLIGIBLE_STRAIN * NEGLIGIBLE_STRAIN
                + NEGLIGIBLE_SHARE * strain,
        };
        let parts = Parts { topology, solid, joints, contacts, seams, loads };
        let mut run = Self::with_parts(model, parts, team, scales);
        run.totals = totals;
        run.energies = Energies { strain, initial: strain, ..Energies::default() };
        Ok(run)
    }

    /// A run of a model, or of a part of one, before its first step.
    pub(crate) fn with_parts(model: Model<D, N>, parts: Parts<D, N>, team: Team, scales: Scales) -> Self {
        let Parts { topology, solid, joints, contacts, seams, loads } = parts;
        Self {
            scales,
            reactions: vec![[0.0; D]; model.boundaries.len()],
            team,
            step: 0,
            totals: Totals::default(),
            energies: Energies::default(),
            imbalance: f64::INFINITY,
            held: Vec::new(),
            touching: Touching::default(),
            timings: Timings::default(),
            actions: Actions::default(),
            model,
            topology,
            solid,
            joints,
            contacts,
            seams,
            loads,
            part: None,
        }
    }

    /// Advances one step: from positions at its beginning, and velocities half a step earlier, to positions at its end. `energies`: whether they are asked for. `links`: messages to other
    /// ranks, if this is a part of a run.
    fn step(&mut self, energies: bool, mut links: Option<&mut Links<'_>>) -> Result<(), Stop> {
        let (broken, stop) = self.press(energies);
        self.add_works_of_changes();
        let taken = self.taken();
        let mut clock = Clock::new();
        let time = self.time();
        let Self { model, topology, solid, joints, loads, team, totals, timings, .. } = self;
        let step = self.scales.time_step;
        // The forces of this step say where joints are inserted; they act from the next one.
        let mut failing = joints.failing(solid, model, topology, team);
        clock.read(&mut timings.joints);

        let factor = model.gravity_schedule.factor(time);
        let gravity = model.gravity.map(|acceleration| factor * acceleration);
        let speed_limit = self.scales.speed_limit;
        let grains = solid.grains;
        let motion = Motion {
            model,
            joints,
            loads,
            gravity,
            time,
            step,
            speed_limit,
            grains,
            energy: energies,
            relaxation: totals.relaxation.damping,
            taken,
        };
        let mut moved = Moved::default();
        if let Some(links) = links.as_deref_mut() {
            let lent = links.lent();
            motion::advance(solid, &motion, team, |node| lent[node], &mut moved);
            links.start_motion(solid);
            let lent = links.lent();
            motion::advance(solid, &motion, team, |node| !lent[node], &mut moved);
        } else {
            motion::advance(solid, &motion, team, |_| true, &mut moved);
        }
        let mut told = Told {
            fastest: moved.fastest,
            parts: !failing.is_empty() || !broken.is_empty(),
            fails: stop.is_some(),
            runs_away: moved.runaway.is_some(),
        };
        totals.external.add_sum(&moved.external[0]);
        totals.damping.add_sum(&moved.damping[0]);
        self.held = std::mem::take(&mut moved.held);
        clock.read(&mut timings.integration);
        if let Some(links) = links.as_deref_mut() {
            links.finish_motion(&mut self.solid, step, &mut told);
            clock.read(&mut self.timings.messages);
        }
        if told.fails {
            return Err(self.first_stop(stop, links.as_deref()));
        }
        self.contacts.note_motion(step * told.fastest);
        if energies {
            self.account_of(&moved, links.as_deref());
        }
        self.relax(taken, &moved, links.as_deref());
        let Self { model, topology, solid, joints, contacts, loads, totals, timings, .. } = self;
        totals.add_works(loads.half_works(solid, step));
        totals.external.add_sum(&moved.external[1]);
        totals.damping.add_sum(&moved.damping[1]);
        clock.read(&mut timings.integration);

        if told.parts {
            if let Some(links) = links.as_deref() {
                links.share_failing(&mut failing, topology);
            }
            let split = joints.insert(&failing, solid, model, topology);
            let at = contacts.part(&broken, joints, topology, &solid.share);
            if let Some(links) = links.as_deref_mut() {
                links.exchange_changes(&split, &at, solid, joints, contacts, topology);
                let hidden = self
                    .part
                    .as_ref()
                    .is_some_and(|part| contacts.bared.iter().any(|&element| part.is_hidden(element)));
                if links.any(hidden) {
                    links.ask();
                }
            }
            clock.read(&mut timings.joints);
        }
        if self.is_audited() {
            self.audit(links.as_deref())?;
        }
        if told.runs_away {
            let limit = self.scales.speed_limit;
            let runaway = moved.runaway.map(|(element, speed)| Stop::Runaway {
                element: self.topology.number(element),
                step: self.step,
                speed,
                limit,
            });
            return Err(self.first_stop(runaway, links.as_deref()));
        }
        self.step += 1;
        Ok(())
    }

    /// The energies and the imbalance at the time of the positions, where the energy balance holds. The work in the second half of the step is added after it.
    fn account_of(&mut self, moved: &Moved<Sum, D>, links: Option<&Links<'_>>) {
        self.account(&moved.kinetic, links);
        let mut largest = moved.largest;
        if let Some(links) = links {
            links.most(&mut largest);
        }
        self.imbalance = (largest[0] / largest[1]).sqrt();
    }

    /// Computes all forces on the corners of elements. Returns the joints that broke, and the reason why the run cannot go on after this step, if there is one: the step is finished all the
    /// same, because the other ranks of a run finish it before they hear of the reason.
    fn press(&mut self, energies: bool) -> (Vec<u32>, Option<Stop>) {
        let time = self.time();
        let Self {
            model,
            topology,
            solid,
            joints,
            contacts,
            seams,
            loads,
            team,
            totals,
            timings,
            actions,
            ..
        } = self;
        let step = self.scales.time_step;
        let mut clock = Clock::new();
        let stop = solid.deform(step, team).map(|(element, ratio)| Stop::Inverted {
            element: topology.number(element),
            step: self.step,
            ratio,
        });
        clock.read(&mut timings.bulk);

        let (broken, work) = joints.pull(solid, step, time, team);
        totals.cohesive.add_sum(&work);
        clock.read(&mut timings.joints);

        if let Err(error) = contacts.detect(solid, joints, topology, team) {
            return (broken, stop.or(Some(error)));
        }
        clock.read(&mut timings.detection);

        let touching = contacts.press(solid, joints, step, energies, team);
        totals.friction.add_sum(&touching.friction);
        totals.damping.add_sum(&touching.damping);
        totals.cohesive.subtract(&touching.handed_over);
        self.touching = touching;
        seams.press(solid, team);
        clock.read(&mut timings.contact);

        loads.apply(solid, model, &actions.forces, time);
        totals.add_works(loads.half_works(solid, step));
        clock.read(&mut timings.integration);
        (broken, stop)
    }

    /// The reason why the run cannot go on, the same on all ranks: that of the first element that is a reason on any rank. `own`: that of this rank.
    fn first_stop(&self, own: Option<Stop>, links: Option<&Links<'_>>) -> Stop {
        let first = match links {
            Some(links) => {
                let all = links.all(&own.map(|stop| stop.on_rank(links.rank())));
                all.into_iter().flatten().min_by_key(Stop::element)
            }
            None => own,
        };
        first.unwrap_or_else(|| self.unknown_stop())
    }

    /// The reason of a run that does not say why.
    fn unknown_stop(&self) -> Stop {
        Stop::Runaway { element: 0, step: self.step, speed: f64::NAN, limit: self.scales.speed_limit }
    }

    /// Advances the run by `steps` steps.
    ///
    /// # Errors
    /// The reason why the run cannot continue. The run stays at the step in which this was found.
    pub fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        <[[f64; D]; N]>::advance(self, steps, None)
    }

    /// Takes so many steps. `links`: messages to other ranks, if this is a part of a run; then it takes fewer if ranks must first look for elements near theirs.
    pub(crate) fn take(&mut self, steps: u64, mut links: Option<&mut Links<'_>>) -> Result<(), Stop> {
        let last = self.step.saturating_add(steps).saturating_sub(1);
        let done = if let Some(links) = links.as_deref_mut() {
            (0..steps)
                .try_for_each(|_| if links.is_stale() { Ok(()) } else { self.one_of(last, Some(links)) })
        } else {
            let team = self.team.clone();
            team.keep_awake(|| (0..steps).try_for_each(|_| self.one_of(last, None)))
        };
        // Energies of the step that failed. Where a step turns velocities round, their product before and after it is negative, and says nothing.
        if done.is_err() {
            let kinetic = self.kinetic_of_half_step();
            self.account(&kinetic, links.as_deref());
        }
        done
    }

    /// Takes a step of many, of which this is the last.
    fn one_of(&mut self, last: u64, links: Option<&mut Links<'_>>) -> Result<(), Stop> {
        self.step(self.is_audited() || self.step == last, links)
    }

    /// The model as it was given.
    pub fn model(&self) -> &Model<D, N> {
        &self.model
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.scales.time_step
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.scales.time_step
    }

    /// The longest stable time step, and what sets it.
    pub fn critical_step(&self) -> CriticalStep {
        self.scales.critical
    }

    /// Energies at the beginning of the last step, J.
    pub fn energies(&self) -> Energies {
        self.energies
    }

    /// Whether forces are in equilibrium: the largest force on a node that is free over the largest that an element exerts on one of its nodes, at the beginning of the last step. 0 at rest;
    /// infinite before the first step, and not a number without any force.
    pub fn imbalance(&self) -> f64 {
        self.imbalance
    }

    /// Force of a boundary on the bodies at the beginning of the last step, N; `None` if there is no such boundary.
    pub fn force(&self, boundary: usize) -> Option<[f64; D]> {
        self.reactions.get(boundary).copied()
    }

    /// Numbers of joints, contacts and nodes.
    pub fn counts(&self) -> Counts {
        Counts {
            joints: self.joints.all.len() - self.joints.broken(),
            broken: self.joints.broken(),
            contacts: self.touching.count,
            detections: self.contacts.detections,
            nodes: self.solid.nodes.len(),
        }
    }

    /// The elements of a couple in which one element reached the centroid of the other in the last step: the contact is too soft. `None` if there is no such
    /// couple.
    pub fn penetrated(&self) -> Option<[u32; 2]> {
        self.touching.deep
    }

    /// Computing time so far, by parts of the steps.
    pub fn timings(&self) -> Timings {
        self.timings
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.team.threads()
    }

    /// The vector instructions on which elements, whole joints and contacts are computed: the fastest that the processor has, where nothing else was set.
    pub fn simd(&self) -> Simd {
        self.solid.available.simd()
    }

    /// Computes elements, whole joints and contacts on other vector instructions. Results are the same to the last bit. Returns `false`, and changes nothing, if the processor does not have
    /// them.
    pub fn set_simd(&mut self, simd: Simd) -> bool {
        let available = Available::new(simd);
        self.solid.available = available.unwrap_or(self.solid.available);
        available.is_some()
    }

    /// Displacement, m, and velocity, m/s, of a node of the mesh; those of the first of its nodes if the mesh has broken there. `None` if there is no such
    /// node.
    pub fn node(&self, node: u32) -> Option<([f64; D], [f64; D])> {
        if node as usize >= self.topology.vertex_count() {
            return None;
        }
        Some(self.at_vertex(node))
    }

    /// Displacement, m, and velocity, m/s, of the first node of a vertex.
    pub(crate) fn at_vertex(&self, vertex: u32) -> ([f64; D], [f64; D]) {
        let node = self.solid.corners.node_at(self.topology.corners_of(vertex)[0]) as usize;
        (self.solid.displacement(node, &self.model), self.solid.nodes[node].velocity)
    }

    /// [`Simulation::node`] for some nodes.
    pub fn nodes(&self, nodes: &[u32]) -> Vec<Option<([f64; D], [f64; D])>> {
        nodes.iter().map(|&node| self.node(node)).collect()
    }

    /// Total lengths of joints that broke by opening, by sliding, and by both, m.
    pub fn crack_lengths(&self) -> [f64; 3] {
        self.lengths_of_cracks(|_| true).map(|length| length.value())
    }

    /// Sums of the lengths of the broken joints that are `counted`, by mode.
    pub(crate) fn lengths_of_cracks(&self, counted: impl Fn(u32) -> bool) -> [Sum; 3] {
        let mut lengths = [(); 3].map(|()| Sum::default());
        for (_, joint, broken) in self.joints.breaks().filter(|(number, ..)| counted(*number)) {
            lengths[mode(broken.modes) as usize].add(joint.measure);
        }
        lengths
    }

    /// Fragment of each element: elements that hang together by facets have one number, from 0 in the order of the first element of each fragment. The fragments
    /// change only when joints break: see [`Counts::broken`]. Linear in the number of elements.
    pub fn fragments(&self) -> Vec<u32> {
        self.topology.pieces(|facet| self.joints.holds(facet))
    }

    /// Forces of contacts and boundaries at the beginning of the last step.
    pub fn forces(&self) -> Forces<D> {
        let order = self.solid.order(&self.topology);
        let codes = order.into_iter().map(|node| self.solid.corners.of(node as usize)[0]);
        OwnForces::of(self).placed(codes, self.solid.origin)
    }
}

/// Measures the time since its last reading.
pub(crate) struct Clock(Instant);

impl Clock {
    pub(crate) fn new() -> Self {
        Self(Instant::now())
    }

    pub(crate) fn read(&mut self, sum: &mut Duration) {
        let now = Instant::now();
        *sum += now - self.0;
        self.0 = now;
    }
}
