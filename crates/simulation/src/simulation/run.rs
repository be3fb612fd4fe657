//! A run of a model: all that it has between two steps.

use std::time::Duration;

use fdem_contact::Simd;
use fdem_distributed::wire;
use fdem_fluid::{Network, PorousMatrix};
use fdem_grains::GrainRun;

use crate::action::{Record, Scene};
use crate::actions::cavity::CavityState;
use crate::actions::seams::Seams;
use crate::actions::spheres::SphereAction;
use crate::actions::{Actions, prescribed};
use crate::checks;
use crate::compiled::compiled;
use crate::contacts::{Contacts, Touching, mean_edge};
use crate::critical::CriticalStep;
use crate::energy::Energies;
use crate::error::ModelError;
use crate::forces::Reaction;
use crate::joints::Joints;
use crate::lanes::Available;
use crate::machine::list::Machines;
use crate::machine::{Columns, Machine, Wanted};
use crate::model::{Insertion, Model};
use crate::ranks::part::RankPart;
use crate::rigid::nodes::RECORD;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::simulation::totals::Totals;
use crate::solid::Solid;
use crate::sum::{Grains, Sum};
use crate::team::Team;
use crate::timings::Timings;
use crate::topology::Topology;
use crate::vector::{Matrix, Point};

/// Energy that is negligible: that of a uniform strain of this size, and the work of the initial stress at
/// [`ROUNDED_STRAIN`].
const NEGLIGIBLE_STRAIN: f64 = 1e-8;

/// Strain that rounded coordinates may make. Stress does work at it in a body at rest.
const ROUNDED_STRAIN: f64 = 1e-7;

/// A run of a model.
///
/// # Example
/// ```
/// # use fdem_simulation::*;
/// # let mesh = Mesh { nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], elements: vec![[0, 1, 2]], bodies: vec![0], materials: vec![0] };
/// # let material = Material { name: "rock".to_owned(), density: 2700.0, youngs_modulus: 50e9, poissons_ratio: 0.25, law: fdem_simulation::MaterialLaw::NeoHookean, damping: 0.0, strength: None, friction: 0.5 };
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
    /// The columns of nodes, elements, joints and couples, and the phases of a step on them.
    pub(crate) machine: Box<dyn Machine<D, N>>,
    pub(crate) actions: Actions<D, N>,
    /// The threads of this process, for everything besides the phases.
    pub(crate) team: Team,
    pub(crate) scales: Scales,
    pub(crate) step: u64,
    pub(crate) totals: Totals,
    /// Energies at the beginning of the last step that they were asked for, J: of the last step of
    /// [`Simulation::advance`].
    pub(crate) energies: Energies,
    /// Force and moment of each boundary on the bodies then.
    pub(crate) reactions: Vec<Reaction<D>>,
    /// Largest force on a free node over the largest force of an element on a node, at the beginning of the
    /// last step that energies were asked for.
    pub(crate) imbalance: f64,
    /// Force on each node that a boundary moves, at the beginning of the last step, N.
    pub(crate) held: Vec<(u32, Point<D>)>,
    /// Moments of boundaries that turn nodes or bodies then: see
    /// [`MotionSums`](crate::motion::MotionSums).
    pub(crate) moments: Vec<(u32, Point<3>)>,
    /// Elastic energy of the joints that this rank counts, at the beginning of the last step for which
    /// energies were asked, J.
    pub(crate) joint_elastic: Sum,
    pub(crate) touching: Touching,
    pub(crate) timings: Timings,
    /// The elements of bodies that were rigid until they were overloaded, ascending, with the stress with
    /// which they began to deform, Pa: second Piola-Kirchhoff.
    pub(crate) released: Vec<(u32, Matrix<D>)>,
    /// The part of a run that this rank has; `None` for a whole run.
    pub(crate) part: Option<RankPart<D>>,
}

/// Numbers of a model that all of its parts share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    pub(crate) critical: CriticalStep,
    /// Time step, s.
    pub(crate) time_step: f64,
    /// Largest speed of a node at which the run continues, m/s.
    pub(crate) speed_limit: f64,
    /// Energy of the stiffest element at a strain of 1, J, or that of the heaviest node at the greatest speed
    /// that is prescribed, if that is more: the size of the works that are added up.
    pub(crate) size: f64,
    /// Exchanged energy below which the energy balance is not checked, J.
    pub(crate) negligible: f64,
}

wire!([] Scales { critical, time_step, speed_limit, size, negligible });

/// The parts of a simulation that depend on its elements.
pub(crate) struct Components<const D: usize, const N: usize> {
    pub(crate) topology: Topology<D, N>,
    pub(crate) machine: Box<dyn Machine<D, N>>,
    pub(crate) actions: Actions<D, N>,
}

/// Numbers of joints, contacts, nodes and spheres, which change during a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Joints that hold, elastic or softening; none of an open set.
    pub joints: usize,
    /// Joints that the run has broken.
    pub broken: usize,
    /// Joints of sets that are open from the beginning: all of their facets in the bodies. The sides of the
    /// joint at the end of such a set have one node there.
    pub open: usize,
    /// Joints whose sides are apart at all of their corners: those that the run has broken, and those of open
    /// sets but for the last of each, until the mesh breaks there.
    pub parted: usize,
    /// Couples of elements that overlap.
    pub contacts: usize,
    /// Number of detections of couples so far.
    pub detections: u64,
    /// Nodes.
    pub nodes: usize,
    /// Spheres.
    pub spheres: usize,
    /// Contacts of spheres with each other, with walls and with bodies.
    pub sphere_contacts: usize,
    /// Spheres that are due to come in, and find no room.
    pub waiting_spheres: usize,
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// Creates a run on `threads` threads; 0 stands for one per processor. Results do not depend on the
    /// number of threads.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated.
    pub fn new(model: Model<D, N>, threads: usize) -> Result<Self, ModelError> {
        compiled!((model: value [Model<2, 3>, Model<3, 4>], threads: as_is [usize, usize])
            -> [Result<Simulation<2, 3>, ModelError>, Result<Simulation<3, 4>, ModelError>] = Simulation::begin)
    }

    fn begin(model: Model<D, N>, threads: usize) -> Result<Self, ModelError> {
        Self::begin_on(model, Team::new(threads)?)
    }

    pub(super) fn begin_on(model: Model<D, N>, team: Team) -> Result<Self, ModelError> {
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
        let mut actions = Actions::new(&model, &topology, &mut solid, None)?;
        let time_step = model.time.step.unwrap_or(critical.step * model.time.safety);
        actions.spheres = SphereAction::new(&model, time_step, &team)?;
        solid.hold_rigid_bodies(&actions.prescribed.holds, &model)?;
        let contacts = Contacts::new(&model, &topology, &joints.faces, mean_edge(&model), &team)?;
        if model.fracture.insertion == Insertion::Intrinsic {
            solid.reserve_nodes(N * model.mesh.elements.len());
            joints.everywhere(&model, &topology)?;
        } else {
            joints.of_sets(&model, &topology)?;
        }
        // This also separates elements that have only a vertex in common.
        let vertices: Vec<u32> = (0..topology.vertex_count() as u32).collect();
        joints.part(&vertices, &mut solid, false, &model, &topology, &team);
        if model.fracture.insertion == Insertion::Intrinsic {
            solid.number_by_corners();
            joints.find_nodes(&topology, &solid);
        }
        actions.seams = Seams::new(&model, &joints.faces, &solid)?;
        let mut machine = <[[f64; D]; N]>::machine(Columns { solid, joints, contacts }, &team);
        let scene = Scene {
            model: &model,
            topology: &topology,
            machine: &*machine,
            team: &team,
            time: 0.0,
            step: 0.0,
        };
        actions.begin(&scene)?;
        let Columns { solid, joints, .. } = machine.columns();
        if solid.is_prestressed() {
            actions.support(&scene);
        }
        let speed_limit = model.speed_limit();
        let modulus = |material: u32| model.materials[material as usize].stiffest_modulus();
        let stiffnesses = || {
            let all = (0..solid.element_count()).map(|element| solid.element(element));
            all.map(|element| element.volume * modulus(element.material))
        };
        let stiffness: Sum = stiffnesses().collect();
        let masses = (0..solid.node_count()).map(|node| solid.constants(node).mass);
        let heaviest = masses.fold(0.0, f64::max);
        let fastest = prescribed::fastest(&model, time_step).min(speed_limit);
        // A node of a light body may rebound at twice the speed of a heavy one. Then it has four times the
        // kinetic energy, m/2 v².
        let size = stiffnesses().fold(4.0 * heaviest * fastest * fastest, f64::max);
        let cohesive = joints.stored(solid);
        let Columns { solid, joints, .. } = machine.columns_mut();
        solid.grains = Grains::of(size);
        // The balance counts the energy with which joints begin.
        joints.take_inserted();
        let [strain, _] = machine.energies().map(|sum| sum.value());
        let totals = Totals { cohesive, ..Totals::default() };
        let scales = Scales {
            critical,
            time_step,
            speed_limit,
            size,
            // The strain energy is V σ²/(2E), so the work is ε V σ.
            negligible: 0.5 * stiffness.value() * NEGLIGIBLE_STRAIN * NEGLIGIBLE_STRAIN
                + ROUNDED_STRAIN * (2.0 * stiffness.value() * strain).sqrt(),
        };
        let parts = Components { topology, machine, actions };
        let mut run = Self::with_parts(model, parts, team, scales);
        run.totals = totals;
        run.energies = Energies { strain, initial: strain, ..Energies::default() };
        Ok(run)
    }

    /// A run of a model, or of a part of one, before its first step.
    pub(crate) fn with_parts(
        model: Model<D, N>,
        parts: Components<D, N>,
        team: Team,
        scales: Scales,
    ) -> Self {
        let Components { topology, machine, actions } = parts;
        Self {
            scales,
            reactions: vec![Reaction::default(); model.boundaries.len()],
            machine,
            team,
            step: 0,
            totals: Totals::default(),
            energies: Energies::default(),
            imbalance: f64::INFINITY,
            held: Vec::new(),
            moments: Vec::new(),
            joint_elastic: Sum::default(),
            touching: Touching::default(),
            timings: Timings::default(),
            released: Vec::new(),
            model,
            topology,
            actions,
            part: None,
        }
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Nodes and elements now.
    pub(crate) fn solid(&self) -> &Solid<D, N> {
        &self.machine.columns().solid
    }

    /// A value of the columns that depends on the wanted nodes, elements and joints, and on no others that a
    /// device changes. It is not computed from [`Simulation::solid`], [`Simulation::joints`] or
    /// [`Simulation::contacts`], which would copy all.
    pub(crate) fn looked_at<T: Default>(
        &self,
        wanted: &Wanted,
        mut value: impl FnMut(&Columns<D, N>) -> T,
    ) -> T {
        let mut found = T::default();
        self.machine.look_at(wanted, &mut |columns| found = value(columns));
        found
    }

    /// Joints now.
    pub(crate) fn joints(&self) -> &Joints<D> {
        &self.machine.columns().joints
    }

    /// Couples now.
    pub(crate) fn contacts(&self) -> &Contacts<D, N> {
        &self.machine.columns().contacts
    }

    /// The state, as actions see it.
    pub(crate) fn scene(&self) -> Scene<'_, D, N> {
        let Self { model, topology, machine, team, .. } = self;
        Scene { model, topology, machine: &**machine, team, time: self.time(), step: self.scales.time_step }
    }

    /// The memory of the actions, as far as this rank counts it.
    pub(crate) fn records(&self) -> Vec<Record> {
        let mut records = self.actions.records(&self.scene());
        records.extend(self.solid().rigid_records(&self.topology));
        records
    }

    /// Gives an action a record. Returns `false` if it does not fit the model.
    pub(crate) fn take_record(&mut self, record: &Record) -> bool {
        let (time, step) = (self.time(), self.scales.time_step);
        let Self { model, topology, machine, actions, team, .. } = self;
        if record.action == RECORD {
            return machine.columns_mut().solid.take_rigid(record, topology);
        }
        actions.take(record, &Scene { model, topology, machine: &**machine, team, time, step })
    }

    /// Begins the actions after their records have been taken over.
    pub(crate) fn begin_actions(&mut self) -> Result<(), ModelError> {
        let (time, step) = (self.time(), self.scales.time_step);
        let Self { model, topology, machine, actions, team, .. } = self;
        actions.begin(&Scene { model, topology, machine: &**machine, team, time, step })
    }

    /// Number of elements whose facets the next step checks for failure. Those of the others are known to be
    /// too far from their strength to fail in it.
    ///
    /// # Cost
    /// A look at each element; on a device, a copy of its columns.
    pub fn awake(&self) -> usize {
        (0..self.solid().element_count()).filter(|&element| self.solid().is_awake(element)).count()
    }

    /// Pressure, volume and work of the cavity of a boundary; `None` if it has none.
    pub fn cavity(&self, boundary: usize) -> Option<CavityState> {
        self.actions.cavities.state(u32::try_from(boundary).ok()?)
    }

    /// The fluid in the cracks: pressures, apertures and saturations of its cells, injection by its sources,
    /// and the balance of its mass. Sources have their numbers in the model as keys, cells those of
    /// [`Simulation::fluid_joints`]. `None` without fluid.
    pub fn fluid(&self) -> Option<&Network<D>> {
        self.actions.fluid.network()
    }

    /// The two elements beside each cell of the fluid, in the order of the columns of [`Simulation::fluid`].
    pub fn fluid_joints(&self) -> Vec<[u32; 2]> {
        self.actions.fluid.elements::<N>()
    }

    /// The liquid in pores: pressures at the nodes of the mesh, flows in the elements of
    /// [`Simulation::pore_elements`], and the balance of its mass. Surfaces have their numbers in the model
    /// as keys. `None` without pores.
    pub fn pores(&self) -> Option<&PorousMatrix<D, N>> {
        self.actions.pores.matrix()
    }

    /// Numbers of the elements with pores.
    pub fn pore_elements(&self) -> &[u32] {
        self.actions.pores.elements()
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

    /// The longest stable time step, and the part that sets it.
    pub fn critical_step(&self) -> CriticalStep {
        self.scales.critical
    }

    /// Energies at the beginning of the last step, J.
    pub fn energies(&self) -> Energies {
        self.energies
    }

    /// Whether forces are in equilibrium: the largest force on a node that is free over the largest that an
    /// element exerts on one of its nodes, at the beginning of the last step. 0 at rest; infinite before the
    /// first step, and not a number without any force.
    pub fn imbalance(&self) -> f64 {
        self.imbalance
    }

    /// Force of a boundary on the bodies at the beginning of the last step, N; `None` if there is no such
    /// boundary.
    pub fn force(&self, boundary: usize) -> Option<[f64; D]> {
        self.reactions.get(boundary).map(|reaction| reaction.force)
    }

    /// Moment on the bodies of a boundary with a [`Load::Rotation`](crate::Load::Rotation) about the point
    /// through which its axis passes, at the beginning of the last step, N m. In two dimensions only the
    /// third component counts. Zero for other boundaries; `None` if there is no such boundary.
    pub fn moment(&self, boundary: usize) -> Option<[f64; 3]> {
        self.reactions.get(boundary).map(|reaction| reaction.moment)
    }

    /// Numbers of joints, contacts, nodes and spheres.
    pub fn counts(&self) -> Counts {
        self.looked_at(&Wanted::default(), |Columns { solid, joints, contacts }| {
            let [broken, open, parted] = joints.broken();
            Counts {
                joints: joints.all.len() - broken - open,
                broken,
                open,
                parted,
                contacts: self.touching.count,
                detections: contacts.detections(),
                nodes: solid.node_count(),
                ..self.sphere_counts()
            }
        })
    }

    /// Numbers of spheres and of their contacts.
    pub(crate) fn sphere_counts(&self) -> Counts {
        let spheres = self.actions.spheres.run();
        Counts {
            spheres: spheres.map_or(0, GrainRun::count),
            sphere_contacts: spheres.map_or(0, GrainRun::contact_count),
            waiting_spheres: spheres.map_or(0, GrainRun::waiting),
            ..Counts::default()
        }
    }

    /// The elements of a couple in which one element reached the centroid of the other in the last step: the
    /// contact is too soft. `None` if there is no such couple.
    pub fn penetrated(&self) -> Option<[u32; 2]> {
        self.touching.deep
    }

    /// The deepest overlap of a sphere so far, over the radius of the smaller of the two, and the sphere:
    /// [`GrainRun::deepest_overlap`].
    pub fn deepest_overlap(&self) -> Option<(f64, u32)> {
        self.actions.spheres.run().and_then(GrainRun::deepest_overlap)
    }

    /// Computing time so far, by parts of the steps.
    pub fn timings(&self) -> Timings {
        let spheres = self.actions.spheres.spent;
        Timings { spheres, integration: self.timings.integration.saturating_sub(spheres), ..self.timings }
    }

    /// Adds computing time and a number of detections of the run before.
    pub(crate) fn go_on(&mut self, timings: Timings, detections: u64) {
        self.actions.spheres.spent += timings.spheres;
        self.timings += Timings {
            spheres: Duration::ZERO,
            // The clock of the actions has that of the spheres, too.
            integration: timings.integration + timings.spheres,
            ..timings
        };
        let contacts = &mut self.machine.columns_mut().contacts;
        contacts.set_detections(contacts.detections() + detections);
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.team.threads()
    }

    /// The vector instructions on which elements, whole joints and contacts are computed: the fastest that
    /// the processor has, where nothing else was set.
    pub fn simd(&self) -> Simd {
        self.solid().available.simd()
    }

    /// Computes elements, whole joints and contacts on other vector instructions. Results are the same to the
    /// last bit. Returns `false`, and changes nothing, if the processor does not have them.
    pub fn set_simd(&mut self, simd: Simd) -> bool {
        let available = Available::new(simd);
        if let Some(available) = available {
            self.machine.columns_mut().solid.available = available;
        }
        available.is_some()
    }

    /// Displacement, m, and velocity, m/s, of a node of the mesh; those of the first of its nodes if the mesh
    /// has broken there. `None` if there is no such node.
    pub fn node(&self, node: u32) -> Option<([f64; D], [f64; D])> {
        let [found] = self.nodes(&[node])[..] else { return None };
        found
    }

    /// Displacement, m, and velocity, m/s, of the first node of a vertex.
    pub(crate) fn at_vertex(&self, vertex: u32) -> ([f64; D], [f64; D]) {
        self.at_vertices(&[vertex]).pop().unwrap_or(([0.0; D], [0.0; D]))
    }

    /// [`Simulation::at_vertex`] for some vertices.
    fn at_vertices(&self, vertices: &[u32]) -> Vec<([f64; D], [f64; D])> {
        let corners = || vertices.iter().map(|&vertex| self.topology.corners_of(vertex)[0]);
        let nodes = self.looked_at(&Wanted::default(), |Columns { solid, .. }| {
            corners().map(|corner| solid.node_at(corner)).collect::<Vec<_>>()
        });
        let wanted = Wanted { nodes, ..Wanted::default() };
        self.looked_at(&wanted, |Columns { solid, .. }| {
            let nodes = wanted.nodes.iter().map(|&node| node as usize);
            nodes.map(|node| (solid.displacement(node, &self.model), solid.velocity(node))).collect()
        })
    }

    /// [`Simulation::node`] for some nodes.
    pub fn nodes(&self, nodes: &[u32]) -> Vec<Option<([f64; D], [f64; D])>> {
        let is_there = |node: &u32| (*node as usize) < self.topology.vertex_count();
        let there: Vec<u32> = nodes.iter().copied().filter(is_there).collect();
        let mut found = self.at_vertices(&there).into_iter();
        nodes.iter().map(|node| if is_there(node) { found.next() } else { None }).collect()
    }
}
