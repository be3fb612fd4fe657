//! A run of a model: its state, and the time step that advances it.

use std::ops::Range;
use std::time::{Duration, Instant};

use fdem_contact::Simd;
use serde::{Deserialize, Serialize};

use crate::checks;
use crate::contacts::{Contacts, Saved as SavedContacts, Touching, mean_edge};
use crate::critical::CriticalStep;
use crate::energy::Energies;
use crate::error::{ModelError, Stop};
use crate::forces::{self, Forces};
use crate::joints::{Break, Joint, Joints, Saved};
use crate::lanes::Available;
use crate::loads::Loads;
use crate::model::{Insertion, Model};
use crate::motion::{self, Motion};
use crate::ranks::{Frame, Links, Part, Told};
use crate::seams::{Hold, Seams};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::snapshot::{Crack, Mode, Snapshot};
use crate::solid::{Constants, Node, Solid};
use crate::sum::{Grains, Sum};
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::{Matrix, Point, dot};

/// Steps between two checks of the energy balance.
const AUDIT: u64 = 100;

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
    pub(crate) critical: CriticalStep,
    pub(crate) time_step: f64,
    /// Largest speed of a node at which the run continues, m/s.
    pub(crate) speed_limit: f64,
    /// Energy of the stiffest element at a strain of 1, J: the size of the works that are added up.
    pub(crate) size: f64,
    /// Exchanged energy below which the energy balance is not checked, J.
    pub(crate) negligible: f64,
    pub(crate) step: u64,
    pub(crate) totals: Totals,
    /// Energies at the beginning of the last step that they were asked for, J: of the last step of [`Simulation::advance`].
    pub(crate) energies: Energies,
    /// Force of each boundary on the bodies then, N.
    pub(crate) reactions: Vec<Point<D>>,
    /// Force on each node that a boundary moves, at the beginning of the last step, N.
    pub(crate) held: Vec<(u32, Point<D>)>,
    pub(crate) touching: Touching,
    pub(crate) timings: Timings,
    /// What this rank has of a run of many; `None` for a whole run.
    pub(crate) part: Option<Part<D>>,
}

/// The parts of a simulation that depend on its elements.
pub(crate) struct Parts<const D: usize, const N: usize> {
    pub(crate) topology: Topology<D, N>,
    pub(crate) solid: Solid<D, N>,
    pub(crate) joints: Joints<D>,
    pub(crate) contacts: Contacts<D, N>,
    pub(crate) seams: Seams<D>,
    pub(crate) loads: Loads<D, N>,
}

/// Sums over a run, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Totals {
    /// Work against friction of contacts.
    pub(crate) friction: Sum,
    /// Work against joints, less the potential energy of contacts to which they have handed over.
    pub(crate) cohesive: Sum,
    /// Energy dissipated by local damping, damping of contacts and absorbing edges.
    pub(crate) damping: Sum,
    /// Work of applied forces, of gravity, and of boundaries that move nodes.
    pub(crate) external: Sum,
    /// Work of applied forces, which `external` contains.
    pub(crate) loads: Sum,
    /// Energies at the beginning, once the first step has found them.
    pub(crate) first: Option<Energies>,
    /// Largest exchanged and cohesive energy at any audit.
    pub(crate) exchanged: f64,
    pub(crate) most_cohesive: f64,
}

/// State of a run, without its model. A run that is resumed from it continues as if it had never stopped.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; N]: Serialize, [[f64; D]; D]: Serialize, Joint<D>: Serialize, [f64; N]: Serialize, SavedContacts<D, N>: Serialize, Saved<D>: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; N]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>, Joint<D>: Deserialize<'de>, [f64; N]: Deserialize<'de>, SavedContacts<D, N>: Deserialize<'de>, Saved<D>: Deserialize<'de>"
))]
pub struct State<const D: usize = 2, const N: usize = 3> {
    step: u64,
    totals: Totals,
    energies: Energies,
    reactions: Vec<Point<D>>,
    /// In the order of results: see [`Snapshot`].
    nodes: Vec<Node<D>>,
    of_corner: Vec<[u32; N]>,
    stresses: Vec<Matrix<D>>,
    viscous: Vec<Matrix<D>>,
    dissipated: Vec<f64>,
    joints: Saved<D>,
    contacts: SavedContacts<D, N>,
    seams: Vec<Hold<D>>,
}

impl Totals {
    /// Adds works of loads, and of the dashpots of absorbing facets.
    fn add_works(&mut self, works: impl Iterator<Item = [f64; 2]>) {
        for [work, absorbed] in works {
            self.external.add(work);
            self.loads.add(work);
            self.damping.add(-absorbed);
        }
    }
}

impl<const D: usize, const N: usize> State<D, N> {
    /// Number of steps done.
    pub fn step(&self) -> u64 {
        self.step
    }
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
        let size = stiffnesses().fold(0.0, f64::max);
        solid.grains = Grains::of(size);
        let [strain, _] = solid.energies(&team).map(|sum| sum.value());
        let cohesive = joints.stored(&solid);
        let totals = Totals { most_cohesive: cohesive.value(), cohesive, ..Totals::default() };
        Ok(Self {
            size,
            time_step: model.time.step.unwrap_or(critical.step * model.time.safety),
            negligible: 0.5 * stiffness.value() * NEGLIGIBLE_STRAIN * NEGLIGIBLE_STRAIN
                + NEGLIGIBLE_SHARE * strain,
            reactions: vec![[0.0; D]; model.boundaries.len()],
            team,
            step: 0,
            totals,
            energies: Energies { strain, initial: strain, ..Energies::default() },
            held: Vec::new(),
            touching: Touching::default(),
            timings: Timings::default(),
            model,
            topology,
            solid,
            joints,
            contacts,
            seams,
            loads,
            critical,
            speed_limit,
            part: None,
        })
    }

    /// A run of a part of a model, before its first step.
    pub(crate) fn with_parts(
        model: Model<D, N>,
        parts: Parts<D, N>,
        team: Team,
        frame: &Frame<D, N>,
    ) -> Self {
        let Parts { topology, solid, joints, contacts, seams, loads } = parts;
        Self {
            time_step: frame.time_step,
            negligible: frame.negligible,
            size: frame.size,
            reactions: vec![[0.0; D]; model.boundaries.len()],
            team,
            step: 0,
            totals: Totals::default(),
            energies: Energies::default(),
            held: Vec::new(),
            touching: Touching::default(),
            timings: Timings::default(),
            model,
            topology,
            solid,
            joints,
            contacts,
            seams,
            loads,
            critical: frame.critical,
            speed_limit: frame.speed_limit,
            part: None,
        }
    }

    /// Advances one step: from positions at its beginning, and velocities half a step earlier, to positions at its end. `energies`: whether they are asked for. `links`: messages to other
    /// ranks, if this is a part of a run.
    fn step(&mut self, energies: bool, mut links: Option<&mut Links<'_>>) -> Result<(), Stop> {
        let mut told = Told::default();
        let pressed = self.press(energies);
        // A rank that cannot go on says so where all ranks hear it.
        if links.is_none()
            && let Err(stop) = pressed
        {
            return Err(stop);
        }
        let mut clock = Clock::new();
        let time = self.time();
        let Self { model, topology, solid, joints, loads, team, totals, timings, .. } = self;
        let step = self.time_step;
        // The forces of this step say where joints are inserted; they act from the next one.
        let mut failing = joints.failing(solid, model, topology, team);
        clock.read(&mut timings.joints);

        let factor = model.gravity_schedule.factor(time);
        let gravity = model.gravity.map(|acceleration| factor * acceleration);
        let speed_limit = self.speed_limit;
        let grains = solid.grains;
        let motion =
            Motion { model, joints, loads, gravity, time, step, speed_limit, grains, energy: energies };
        let moved = motion::advance(solid, &motion, team);
        let broken = pressed.as_ref().map_or(&[][..], |pressed| pressed);
        told.fastest = moved.fastest;
        told.parts = !failing.is_empty() || !broken.is_empty();
        told.fails = pressed.is_err();
        told.runs_away = moved.runaway.is_some();
        totals.external.add_sum(&moved.external[0]);
        totals.damping.add_sum(&moved.damping[0]);
        self.held = moved.held;
        clock.read(&mut timings.integration);
        if let Some(links) = links.as_deref_mut() {
            links.exchange_motion(&mut self.solid, step, &mut told);
            clock.read(&mut self.timings.messages);
            if told.fails {
                return Err(self.first_stop(pressed.err(), links));
            }
        }
        self.contacts.note_motion(step * told.fastest);
        if energies {
            // The energy balance holds here, at the time of the positions. The work in the second half of the step is added after it.
            self.account(&moved.kinetic, links.as_deref());
        }
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
            let at = contacts.part(broken, joints, topology, &solid.share);
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
            let limit = self.speed_limit;
            let runaway = moved.runaway.map(|(element, speed)| Stop::Runaway {
                element: self.topology.number(element),
                step: self.step,
                speed,
                limit,
            });
            return Err(match links {
                Some(links) => self.first_stop(runaway, links),
                None => runaway.unwrap_or_else(|| self.unknown_stop()),
            });
        }
        self.step += 1;
        Ok(())
    }

    /// Computes all forces on the corners of elements. Returns the joints that broke.
    fn press(&mut self, energies: bool) -> Result<Vec<u32>, Stop> {
        let time = self.time();
        let Self { model, topology, solid, joints, contacts, seams, loads, team, totals, timings, .. } = self;
        let step = self.time_step;
        let mut clock = Clock::new();
        if let Some((element, ratio)) = solid.deform(step, team) {
            return Err(Stop::Inverted { element: topology.number(element), step: self.step, ratio });
        }
        clock.read(&mut timings.bulk);

        let (broken, work) = joints.pull(solid, step, time, team);
        totals.cohesive.add_sum(&work);
        clock.read(&mut timings.joints);

        contacts.detect(solid, joints, topology, team)?;
        clock.read(&mut timings.detection);

        let touching = contacts.press(solid, joints, step, energies, team);
        totals.friction.add_sum(&touching.friction);
        totals.damping.add_sum(&touching.damping);
        totals.cohesive.subtract(&touching.handed_over);
        self.touching = touching;
        seams.press(solid, team);
        clock.read(&mut timings.contact);

        loads.apply(solid, model, time);
        totals.add_works(loads.half_works(solid, step));
        clock.read(&mut timings.integration);
        Ok(broken)
    }

    /// Whether the energy balance is checked in this step.
    fn is_audited(&self) -> bool {
        self.step.is_multiple_of(AUDIT)
    }

    /// Sums up the energies and the reactions at the beginning of this step. `kinetic`: the kinetic energy, J.
    fn account(&mut self, kinetic: &Sum, links: Option<&Links<'_>>) {
        let [mut strain, viscous] = self.solid.energies(&self.team);
        let [mut contact, mut friction] = self.seams.energies(&self.solid.share);
        let mut damping = viscous;
        let Totals { cohesive, external, loads, .. } = &self.totals;
        let [mut kinetic, mut cohesive, mut external, mut loads] =
            [kinetic, cohesive, external, loads].map(Clone::clone);
        let mut gravity = self.work_of_gravity();
        contact.add_sum(self.touching.energy.as_ref().unwrap_or(&Sum::default()));
        friction.add_sum(&self.totals.friction);
        damping.add_sum(&self.totals.damping);
        if let Some(part) = &self.part {
            friction.add_sum(&part.friction());
        }
        let mut reactions = self.reactions_of_boundaries();
        if let Some(links) = links {
            let mut sums = vec![
                &mut kinetic,
                &mut strain,
                &mut contact,
                &mut friction,
                &mut cohesive,
                &mut damping,
                &mut external,
                &mut loads,
                &mut gravity,
            ];
            sums.extend(reactions.iter_mut().flatten());
            links.add_up(&mut sums);
        }
        let now = Energies {
            kinetic: kinetic.value(),
            strain: strain.value(),
            contact: contact.value(),
            friction: friction.value(),
            cohesive: cohesive.value(),
            damping: damping.value(),
            external: external.value(),
            ..Energies::default()
        };
        // Three works that may cancel: of loads, of gravity, and of boundaries that move or hold nodes.
        let (loads, gravity) = (loads.value(), gravity.value());
        let done = loads.abs() + gravity.abs() + (now.external - loads - gravity).abs();
        let first = *self.totals.first.get_or_insert(now);
        let exchanged = now.changed(&first).max(done).max(self.totals.exchanged);
        self.energies = Energies { initial: first.balance(), exchanged, ..now };
        self.reactions =
            reactions.iter().map(|sums| std::array::from_fn(|axis| sums[axis].value())).collect();
    }

    /// Checks the energy balance.
    fn audit(&mut self, links: Option<&Links<'_>>) -> Result<(), Stop> {
        let energies = self.energies;
        self.totals.exchanged = energies.exchanged;
        self.totals.most_cohesive = self.totals.most_cohesive.max(energies.cohesive);
        let (step, bound) = (self.step, self.model.time.energy_bound);
        let (error, scale, available) = (energies.error(), energies.scale(), energies.available());
        if scale <= self.negligible {
            return Ok(());
        }
        if error.abs() > bound || error.is_nan() {
            return Err(Stop::Energy { element: self.hottest(links), step, error, bound });
        }
        if energies.kinetic > available + bound * scale {
            return Err(Stop::Kinetic {
                element: self.hottest(links),
                step,
                kinetic: energies.kinetic,
                available,
            });
        }
        // Intrinsic joints store elastic energy and return it, as elements do.
        let returned = match self.model.fracture.insertion {
            Insertion::Adaptive => self.totals.most_cohesive - energies.cohesive,
            Insertion::Intrinsic => -energies.cohesive,
        };
        let share = returned / scale;
        if share > bound {
            return Err(Stop::Returned { element: self.hottest(links), step, share, bound });
        }
        Ok(())
    }

    /// Force of each boundary on the bodies in this step, N.
    fn reactions_of_boundaries(&self) -> Vec<[Sum; D]> {
        let mut sums = vec![[(); D].map(|()| Sum::default()); self.model.boundaries.len()];
        for (node, reaction) in &self.held {
            let hold = self.loads.holds[self.solid.constants[*node as usize].hold as usize];
            for axis in 0..D {
                if let Some(hold) = hold[axis] {
                    sums[hold.boundary as usize][axis].add(reaction[axis]);
                }
            }
        }
        for ([boundary, _], force) in self.loads.applied(&self.solid) {
            for axis in 0..D {
                sums[boundary as usize][axis].add(force[axis]);
            }
        }
        sums
    }

    /// The element with the most energy per mass: the first of them.
    fn hottest(&self, links: Option<&Links<'_>>) -> u32 {
        let density = |number: u32| {
            let element = &self.solid.elements[number as usize];
            let square = |node: u32| {
                let velocity = self.solid.nodes[node as usize].velocity;
                dot(velocity, velocity)
            };
            let fastest = self.solid.nodes_of(number).into_iter().map(square).fold(0.0, f64::max);
            let density = self.model.materials[element.material as usize].density;
            0.5 * fastest + self.solid.energy(number as usize) / (density * element.volume)
        };
        let all = (0..self.solid.elements.len() as u32).filter(|&element| self.solid.share.element(element));
        let of_all = all.map(|element| (density(element), self.topology.number(element)));
        let hotter = |a: (f64, u32), b: (f64, u32)| {
            let order = b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
            if order.is_le() { a } else { b }
        };
        let own = of_all.reduce(hotter);
        let found = match links {
            Some(links) => links.all(&own).into_iter().flatten().reduce(hotter),
            None => own,
        };
        found.map_or(0, |(_, element)| element)
    }

    /// The reason why the run cannot go on, the same on all ranks: that of the first rank that has one.
    fn first_stop(&self, own: Option<Stop>, links: &Links<'_>) -> Stop {
        let all = links.all(&own.map(|stop| stop.on_rank(links.rank())));
        let order = |stop: &Stop| stop.element();
        all.into_iter().flatten().min_by_key(order).unwrap_or_else(|| self.unknown_stop())
    }

    /// The reason of a run that does not say why.
    fn unknown_stop(&self) -> Stop {
        Stop::Runaway { element: 0, step: self.step, speed: f64::NAN, limit: self.speed_limit }
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

    /// Kinetic energy with the velocities half a step after the positions, J.
    fn kinetic_of_half_step(&self) -> Sum {
        let of = |(node, constants): (&Node<D>, &Constants)| {
            0.5 * constants.mass * dot(node.velocity, node.velocity)
        };
        let all = self.solid.nodes.iter().zip(&self.solid.constants).enumerate();
        all.filter(|(node, _)| self.solid.share.node(*node)).map(|(_, node)| of(node)).collect()
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
        self.step as f64 * self.time_step
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// The longest stable time step, and what sets it.
    pub fn critical_step(&self) -> CriticalStep {
        self.critical
    }

    /// Energies at the beginning of the last step, J.
    pub fn energies(&self) -> Energies {
        self.energies
    }

    /// Work of gravity so far, J.
    fn work_of_gravity(&self) -> Sum {
        if self.model.gravity == [0.0; D] {
            return Sum::default();
        }
        let factor = self.model.gravity_schedule.factor(self.time());
        let work = |node: usize| {
            let moved = self.solid.displacement(node, &self.model);
            factor * self.solid.constants[node].mass * dot(self.model.gravity, moved)
        };
        let of =
            |range: Range<usize>| [range.filter(|&node| self.solid.share.node(node)).map(work).collect()];
        let [sum] = Sum::all(self.team.look(self.solid.nodes.len(), of));
        sum
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
        Forces {
            contacts: forces::contact_forces(&self.contacts, &self.joints, &self.solid, &self.topology),
            reactions: forces::reactions(self),
        }
    }

    /// State from which the run can be resumed.
    pub fn state(&self) -> State<D, N> {
        let order = self.solid.order(&self.topology);
        State {
            step: self.step,
            totals: self.totals.clone(),
            energies: self.energies,
            reactions: self.reactions.clone(),
            nodes: order.iter().map(|&node| self.solid.nodes[node as usize]).collect(),
            of_corner: self.solid.in_order(&order),
            stresses: (0..self.solid.elements.len()).map(|element| self.solid.stress(element)).collect(),
            viscous: self.solid.viscous(),
            dissipated: self.solid.dissipated(),
            joints: self.joints.save(&self.topology),
            contacts: self.contacts.save(),
            seams: self.seams.save(),
        }
    }

    /// Creates a run that continues from a state of a run of the same model.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated; [`ModelError::Length`] or [`ModelError::Missing`] if the state belongs to another model.
    pub fn resume(model: Model<D, N>, state: State<D, N>, threads: usize) -> Result<Self, ModelError> {
        let mut run = Self::new(model, threads)?;
        let elements = run.solid.elements.len();
        let lengths = [
            ("stresses", state.stresses.len(), elements),
            ("viscous stresses", state.viscous.len(), elements),
            ("elements", state.of_corner.len(), elements),
            ("dissipated energies", state.dissipated.len(), run.solid.dissipated().len()),
            ("boundaries", state.reactions.len(), run.reactions.len()),
        ];
        for (what, found, expected) in lengths {
            if found != expected {
                return Err(ModelError::Length { what, found, expected });
            }
        }
        let missing =
            |index| ModelError::Missing { what: "node", index, place: "the saved state".to_owned() };
        if let Some(&node) =
            state.of_corner.iter().flatten().find(|&&node| node as usize >= state.nodes.len())
        {
            return Err(missing(node));
        }
        run.solid.set_nodes(state.nodes, state.of_corner, &run.model);
        run.solid.restore(&state.stresses, &state.viscous, &state.dissipated);
        run.joints.restore(state.joints, &run.model, &run.topology, &run.solid)?;
        let couples = Contacts::without_forces(state.contacts);
        run.contacts.restore(couples, &run.joints, &run.topology);
        run.seams.restore(state.seams)?;
        run.step = state.step;
        run.totals = state.totals;
        run.energies = state.energies;
        run.reactions = state.reactions;
        Ok(run)
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Positions, motion, stress and cracks now.
    pub fn snapshot(&self) -> Snapshot<D, N> {
        let order = self.solid.order(&self.topology);
        let nodes = || order.iter().map(|&node| node as usize);
        let elements = self.solid.elements.len();
        let mut damage = vec![0.0_f64; elements];
        let mut cracks = Vec::new();
        for number in self.joints.in_order() {
            let joint = &self.joints.all[number as usize];
            let of_joint = joint.damage();
            let facet = &self.topology.facets[joint.facet as usize];
            for element in facet.elements() {
                let damage = &mut damage[element as usize];
                *damage = damage.max(of_joint);
            }
            if of_joint > 0.0 {
                cracks.push(self.crack(joint, of_joint, self.joints.break_of(number)));
            }
        }
        Snapshot {
            step: self.step,
            time: self.time(),
            positions: nodes().map(|node| self.solid.place(self.solid.nodes[node].position)).collect(),
            displacements: nodes().map(|node| self.solid.displacement(node, &self.model)).collect(),
            velocities: nodes().map(|node| self.solid.nodes[node].velocity).collect(),
            elements: self.solid.in_order(&order),
            stresses: (0..elements)
                .map(|element| {
                    <[[f64; D]; N]>::in_tensor(&self.solid.stress(element), self.solid.moduli(element))
                })
                .collect(),
            damage,
            bodies: self.model.mesh.bodies.clone(),
            materials: self.model.mesh.materials.clone(),
            fragments: self.fragments(),
            cracks,
        }
    }

    fn crack(&self, joint: &Joint<D>, damage: f64, broken: Option<&Break>) -> Crack<D> {
        let facet = &self.topology.facets[joint.facet as usize];
        let corner = |corner: usize| {
            let [a, b] = facet.corners.map(|side| self.solid.at_corner(side[corner]).position);
            self.solid.place(std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis])))
        };
        let gap = joint.gap(&self.solid);
        let modes = broken.map_or_else(|| joint.modes(), |broken| broken.modes);
        Crack {
            corners: std::array::from_fn(corner),
            elements: facet.elements(),
            damage,
            mode: mode(modes),
            opening: gap[0],
            sliding: <[[f64; D]; N]>::sliding(&gap),
            time: broken.map(|broken| broken.time),
            measure: joint.measure,
        }
    }
}

/// Mode of failure of a joint from its damage by opening and by sliding.
pub(crate) fn mode(damages: [f64; 2]) -> Mode {
    let opening = damages[0] / (damages[0] + damages[1]).max(f64::MIN_POSITIVE);
    if opening >= 0.75 {
        Mode::Tension
    } else if opening <= 0.25 {
        Mode::Shear
    } else {
        Mode::Mixed
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

#[cfg(test)]
mod tests {
    use super::*;
    use fdem_mesh::Mesh;

    use crate::model::Material;

    /// Kinetic energy out of nothing is found although the balance holds: negative dissipation cancels it, but it exceeds the energy available.
    #[test]
    fn kinetic_energy_out_of_nothing_stops_a_run() {
        let mesh = Mesh {
            nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            elements: vec![[0, 1, 2]],
            bodies: vec![0],
            materials: vec![0],
        };
        let material = Material {
            name: "rock".to_owned(),
            density: 2700.0,
            youngs_modulus: 50e9,
            poissons_ratio: 0.25,
            damping: 0.0,
            strength: None,
            friction: 0.5,
        };
        let model =
            Model { mesh, materials: vec![material], velocities: vec![[1.0, 0.0]; 3], ..Model::default() };
        let mut run = Simulation::new(model, 1).expect("a model");
        run.advance(150).expect("a sound run");
        let kinetic = run.energies().kinetic;
        for node in &mut run.solid.nodes {
            node.velocity = node.velocity.map(|v| 2.0 * v);
        }
        run.totals.damping.add(-3.0 * kinetic);
        let stop = run.advance(100).expect_err("three times the energy from nowhere");
        assert!(matches!(stop, Stop::Kinetic { step: 200, .. }), "{stop}");
    }
}
