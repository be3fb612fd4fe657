//! The run of a rank, and the common results of all ranks.

use fdem_distributed::Communicator;
use fdem_distributed::wire::{bytes_of, value_of};
use fdem_fluid::Network;

use crate::actions::fluid::{FluidAction, SharedFluid};
use crate::actions::spheres::{SavedSpheres, SphereAction};
use crate::critical::CriticalStep;
use crate::energy::Energies;
use crate::error::{ModelError, Stop};
use crate::joints::saved::MovingJoint;
use crate::machine::Columns;
use crate::machine::list::Machines;
use crate::model::Model;
use crate::probe::Probe;
use crate::ranks::gather::Gathered;
use crate::ranks::links::Links;
use crate::ranks::piece::{CarriedState, CommonData, RunPieces};
use crate::ranks::spread::{Division, spread};
use crate::simplex::Simplex;
use crate::simulation::advance::Concrete;
use crate::simulation::run::{Counts, Simulation};
use crate::simulation::snapshots::mode;
use crate::simulation::totals::Totals;
use crate::sum::Sum;
use crate::team::Team;
use crate::timings::Timings;

/// A run on many ranks. Its calls are collective: all ranks make the same calls in the same order.
///
/// Results are those of a [`Simulation`] of the same model, to the last bit, for any number of ranks and
/// threads.
///
/// # Example
/// ```
/// # use fdem_simulation::*;
/// # let mesh = Mesh { nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], elements: vec![[0, 1, 2]], bodies: vec![0], materials: vec![0] };
/// # let material = Material { name: "rock".to_owned(), density: 2700.0, youngs_modulus: 50e9, poissons_ratio: 0.25, law: fdem_simulation::MaterialLaw::NeoHookean, damping: 0.0, strength: None, friction: 0.5 };
/// let model = Model { mesh, materials: vec![material], gravity: [0.0, -9.81], ..Model::default() };
/// let mut whole = Simulation::new(model.clone(), 1)?;
/// whole.advance(100)?;
/// let states = fdem_distributed::threads::run(2, |communicator| {
///     let run = (communicator.rank() == 0).then(|| Simulation::new(model.clone(), 1).unwrap());
///     let mut run = Distributed::new(communicator, run, 1).unwrap();
///     run.advance(100).unwrap();
///     run.gathered()
/// });
/// // Rank 0 gets the whole run.
/// assert_eq!(states[0].as_ref().map(Gathered::snapshot), Some(whole.snapshot()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Distributed<'c, const D: usize = 2, const N: usize = 3> {
    communicator: &'c dyn Communicator,
    frame: CommonData<D, N>,
    division: Option<Division<D>>,
    pub(super) run: Simulation<D, N>,
    links: Links<'c>,
    team: Team,
    /// Number of times that elements were given to ranks, after the first.
    spreads: u64,
    /// Bytes and messages of earlier links.
    sent: [u64; 2],
    /// The step at which the run was distributed.
    first: u64,
}

/// Sums of the traffic of a run on many ranks, and the elements of each rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Number of ranks.
    pub ranks: usize,
    /// Elements that this rank counts, and those that it computes too because they act on its nodes or are
    /// near its elements.
    pub own: usize,
    /// See `own`.
    pub halo: usize,
    /// Ranks with which this one shares nodes.
    pub neighbours: usize,
    /// Steps since the run was distributed.
    pub steps: u64,
    /// Bytes of motions of nodes that this rank has sent in these steps.
    pub bytes: u64,
    /// Messages with them.
    pub messages: u64,
    /// Number of times that elements were given to ranks again.
    pub spreads: u64,
}

impl<'c, const D: usize, const N: usize> Distributed<'c, D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    /// Distributes a run that rank 0 has among all ranks. `threads`: threads of each rank; 0 for one per
    /// processor.
    ///
    /// # Errors
    /// If threads cannot be started.
    ///
    /// # Panics
    /// If rank 0 gives no run.
    pub fn new(
        communicator: &'c dyn Communicator,
        run: Option<Simulation<D, N>>,
        threads: usize,
    ) -> Result<Self, ModelError> {
        let mut run = run;
        let mut bytes = Vec::new();
        if communicator.rank() == 0 {
            let run = run.as_mut().expect("rank 0 has the run");
            run.watch();
            let spheres: Vec<_> = run.actions.spheres.save().into_iter().collect();
            let fluid: Vec<_> = run.actions.fluid.shared().into_iter().collect();
            run.actions.fluid = FluidAction::default();
            bytes = bytes_of(&[
                CommonData::of(run).bytes(),
                run.carried().bytes(),
                bytes_of(&spheres),
                bytes_of(&fluid),
            ]);
        } else {
            run = None;
        }
        communicator.broadcast(&mut bytes);
        let [frame, common, spheres, fluid]: [Vec<u8>; 4] = value_of(&bytes);
        let frame = CommonData::of_bytes(&frame);
        if frame.model.pores.is_some() {
            return Err(ModelError::Pores("the run is on many ranks"));
        }
        if let Some(of) = frame.model.until_overloaded.first() {
            return Err(ModelError::UntilOverloaded { body: of.body, why: "the run is on many ranks" });
        }
        if frame.elements == 0 {
            return Err(ModelError::GrainsOnRanks);
        }
        let team = Team::new(threads)?;
        let carried = run.as_ref().map_or_else(|| CarriedState::of_bytes(&common), Simulation::carried);
        let mut division = None;
        let (mut run, links) = part(run, None, &mut division, &frame, carried, communicator, &team)?;
        run.actions.spheres = SphereAction::new(&frame.model, frame.scales.time_step, &team)?;
        if let Some(saved) = value_of::<Vec<SavedSpheres<D>>>(&spheres).pop() {
            run.actions.spheres.restore(saved)?;
        }
        if let (Some(options), Some(shared)) =
            (&frame.model.fluid, value_of::<Vec<SharedFluid<D>>>(&fluid).pop())
        {
            run.actions.fluid = FluidAction::of_rank(shared, options, frame.model.thickness)?;
        }
        let first = run.step;
        Ok(Self { communicator, frame, division, run, links, team, spreads: 0, sent: [0; 2], first })
    }

    /// Advances the run by `steps` steps.
    ///
    /// # Errors
    /// The reason why the run cannot continue, the same on all ranks.
    pub fn advance(&mut self, steps: u64) -> Result<(), Stop> {
        let end = self.run.step + steps;
        while self.run.step < end {
            if self.links.stale {
                self.spread().map_err(|error| Stop::OnRank {
                    rank: self.communicator.rank(),
                    reason: error.to_string(),
                })?;
            }
            let left = end - self.run.step;
            <[[f64; D]; N]>::take(&mut self.run, left, Some(&mut self.links))?;
        }
        Ok(())
    }

    /// Checks the energy balance at the end of a run: see [`Simulation::check_balance`]. All ranks call it.
    ///
    /// # Errors
    /// Those of [`Simulation::check_balance`]; all ranks return the same error.
    pub fn check_balance(&self) -> Result<(), Stop> {
        self.run.audit_end(&self.links)
    }

    /// Divides the work among the ranks again, by the present cost of each element, before the next step. A
    /// run does this automatically when one rank has much more than others.
    pub fn rebalance(&mut self) {
        self.division = None;
        self.links.ask();
    }

    /// Gives ranks the elements that they need now.
    fn spread(&mut self) -> Result<(), ModelError> {
        self.run.watch();
        let mut fluid = std::mem::take(&mut self.run.actions.fluid);
        fluid.note(&self.run.scene());
        let carried = self.run.carried();
        for (sum, more) in self.sent.iter_mut().zip(self.links.sent) {
            *sum += more;
        }
        let spheres = std::mem::take(&mut self.run.actions.spheres);
        let motion = self.motion_of_surface(&spheres);
        let Self { communicator, frame, division, run, links, team, .. } = self;
        let taken = std::mem::replace(run, Simulation::nothing(frame, team.clone())?);
        let (new, messages) = part(Some(taken), Some(links), division, frame, carried, *communicator, team)?;
        (self.run, self.links) = (new, messages);
        self.run.actions.spheres = spheres.among_others(motion);
        self.run.actions.fluid = fluid.among_others();
        self.spreads += 1;
        Ok(())
    }

    /// The motion of the surface that spheres touch, of all ranks: see [`SphereAction::surface_motion`].
    fn motion_of_surface(&self, spheres: &SphereAction<D>) -> Vec<(u32, [f64; D])> {
        if spheres.run().is_none() {
            return Vec::new();
        }
        self.links.all(&spheres.surface_motion()).concat()
    }

    /// Sets the factor of a boundary from the next step on: see [`Simulation::set_factor`]. All ranks call
    /// it.
    ///
    /// # Errors
    /// Those of [`Simulation::set_factor`], the same on all ranks.
    pub fn set_factor(&mut self, boundary: usize, factor: Option<f64>) -> Result<(), ModelError> {
        self.run.set_factor(boundary, factor)
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.run.steps()
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.run.time()
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.run.time_step()
    }

    /// The longest stable time step, and the part that sets it.
    pub fn critical_step(&self) -> CriticalStep {
        self.run.critical_step()
    }

    /// Energies at the beginning of the last step, J.
    pub fn energies(&self) -> Energies {
        self.run.energies()
    }

    /// Whether forces are in equilibrium: see [`Simulation::imbalance`].
    pub fn imbalance(&self) -> f64 {
        self.run.imbalance()
    }

    /// Force of a boundary on the bodies at the beginning of the last step, N; `None` if there is no such
    /// boundary.
    pub fn force(&self, boundary: usize) -> Option<[f64; D]> {
        self.run.force(boundary)
    }

    /// Moment of a boundary on the bodies, N m: see [`Simulation::moment`].
    pub fn moment(&self, boundary: usize) -> Option<[f64; 3]> {
        self.run.moment(boundary)
    }

    /// Computing time of this rank so far, by parts of the steps.
    pub fn timings(&self) -> Timings {
        self.run.timings()
    }

    /// The fluid in the cracks: see [`Simulation::fluid`]. All ranks have all of it.
    pub fn fluid(&self) -> Option<&Network<D>> {
        self.run.fluid()
    }

    /// The two elements beside each cell of the fluid: see [`Simulation::fluid_joints`].
    pub fn fluid_joints(&self) -> Vec<[u32; 2]> {
        self.run.fluid_joints()
    }

    /// Number of threads of this rank.
    pub fn threads(&self) -> usize {
        self.run.threads()
    }

    /// Memory of the mesh, the nodes, the elements and the joints of this rank, bytes, without contacts.
    pub fn memory(&self) -> usize {
        let run = &self.run;
        let (mesh, solid) = (&run.model.mesh, run.solid());
        let of_mesh = size_of_val(&*mesh.nodes)
            + size_of_val(&*mesh.elements)
            + size_of_val(&*mesh.bodies)
            + size_of_val(&*mesh.materials);
        // Owners of corners, whether an element is this rank's, and three numbers for each vertex.
        let owners = run.part.as_ref().map_or(0, |part| size_of_val(&*part.owners));
        let of_part = owners + solid.element_count() + 3 * size_of::<u32>() * mesh.nodes.len();
        of_mesh + of_part + run.topology.bytes() + solid.bytes() + run.joints().bytes()
    }

    /// The elements and the traffic of this rank.
    pub fn traffic(&self) -> Traffic {
        let share = self.run.solid().share();
        let elements = self.run.solid().element_count();
        let own = (0..elements as u32).filter(|&element| share.element(element)).count();
        Traffic {
            ranks: self.communicator.size(),
            own,
            halo: elements - own,
            neighbours: self.links.neighbours.len(),
            steps: self.run.step - self.first,
            bytes: self.sent[0] + self.links.sent[0],
            messages: self.sent[1] + self.links.sent[1],
            spreads: self.spreads,
        }
    }

    /// The elements and the traffic of every rank, in the order of the ranks.
    pub fn traffic_of_all(&self) -> Vec<Traffic> {
        let own = self.traffic();
        let numbers = |traffic: Traffic| {
            let Traffic { own, halo, neighbours, bytes, messages, .. } = traffic;
            [own as u64, halo as u64, neighbours as u64, bytes, messages]
        };
        let of = |[elements, halo, neighbours, bytes, messages]: [u64; 5]| Traffic {
            own: elements as usize,
            halo: halo as usize,
            neighbours: neighbours as usize,
            bytes,
            messages,
            ..own
        };
        self.links.all(&numbers(own)).into_iter().map(of).collect()
    }

    /// Numbers of joints, contacts and nodes of the whole run. Detections are those of the rank with most.
    pub fn counts(&self) -> Counts {
        let own = self.run.own_counts();
        let numbers = |counts: &Counts| {
            [counts.joints, counts.broken, counts.open, counts.parted, counts.contacts, counts.nodes]
                .map(|count| (count as u64).cast_signed())
        };
        let mut sums = numbers(&own);
        self.communicator.all_sum(&mut sums);
        let mut most = [own.detections as f64];
        self.communicator.all_max(&mut most);
        let [joints, broken, open, parted, contacts, nodes] = sums.map(|sum| sum as usize);
        let detections = most[0] as u64;
        // All ranks have all spheres.
        let Counts { spheres, sphere_contacts, waiting_spheres, .. } = own;
        Counts {
            joints,
            broken,
            open,
            parted,
            contacts,
            detections,
            nodes,
            spheres,
            sphere_contacts,
            waiting_spheres,
        }
    }

    /// The elements of the first couple in which one element reached the centroid of the other in the last
    /// step; `None` if there is no such couple.
    pub fn penetrated(&self) -> Option<[u32; 2]> {
        let own = self.run.touching.deep.map(|pair| pair.map(|element| self.run.topology.number(element)));
        self.links.all(&own).into_iter().flatten().min()
    }

    /// Displacements, m, and velocities, m/s, of some nodes of the mesh: see [`Simulation::node`].
    pub fn nodes(&self, nodes: &[u32]) -> Vec<Option<([f64; D], [f64; D])>> {
        let mut found = vec![None; nodes.len()];
        let own = (0..).zip(nodes).filter_map(|(place, &node)| {
            let (displacement, velocity) = self.run.own_node(node)?;
            Some((place, [displacement, velocity]))
        });
        let own: Vec<(u32, [[f64; D]; 2])> = own.collect();
        for (place, [displacement, velocity]) in self.links.all(&own).into_iter().flatten() {
            found[place as usize] = Some((displacement, velocity));
        }
        found
    }

    /// Total lengths, m, or areas, m², of joints that broke by opening, by sliding, and by both.
    pub fn crack_lengths(&self) -> [f64; 3] {
        let mut lengths = self.run.own_crack_lengths();
        let [a, b, c] = &mut lengths;
        self.links.add_up(&mut [a, b, c]);
        lengths.map(|length| length.value())
    }

    /// Measures quantities of the whole run now: see [`Simulation::measure`].
    pub fn measure(&self, probes: &[Probe<D, N>]) -> Vec<Vec<f64>> {
        let mut sums: Vec<Vec<Sum>> = probes.iter().map(|probe| self.run.sums(probe)).collect();
        for (probe, sums) in probes.iter().zip(&mut sums) {
            if let Probe::JointSet(name) = probe {
                self.run.add_separated(name, &self.links, sums);
            }
        }
        self.links.add_up(&mut sums.iter_mut().flatten().collect::<Vec<_>>());
        probes.iter().zip(sums).map(|(probe, sums)| probe.values(&sums)).collect()
    }

    /// Fragment of each element, on rank 0: see [`Simulation::fragments`]. `None` on the other ranks.
    pub fn fragments(&self) -> Option<Vec<u32>> {
        let mut pairs = Vec::new();
        let mut first = Vec::new();
        for (element, piece) in (0..).zip(self.run.fragments()) {
            let number = self.run.topology.number(element);
            if piece as usize == first.len() {
                first.push(number);
            }
            pairs.push([number, first[piece as usize]]);
        }
        let pairs = self.collect(&bytes_of(&pairs))?;
        let pairs = pairs.iter().flat_map(|bytes| value_of::<Vec<[u32; 2]>>(bytes));
        Some(united(self.elements(), pairs))
    }

    /// The whole run for results and checkpoints, on rank 0; `None` on the others.
    pub fn gathered(&self) -> Option<Gathered<D, N>> {
        let mut carried = self.run.carried();
        let totals = &mut carried.totals;
        self.links.add_up(&mut [
            &mut totals.friction,
            &mut totals.cohesive,
            &mut totals.inserted,
            &mut totals.damping,
            &mut totals.external,
            &mut totals.loads,
        ]);
        let fragments = self.fragments();
        let motion = self.motion_of_surface(&self.run.actions.spheres);
        let own = self.run.own();
        let Some(fragments) = fragments else {
            self.communicator.send(0, &bytes_of(&own));
            return None;
        };
        let others = (1..self.communicator.size()).map(|rank| value_of(&self.communicator.receive(rank)));
        let of_spheres = (self.run.spheres_now(), self.run.actions.spheres.save_with(motion));
        let parts = std::iter::once(own).chain(others);
        let gathered = Gathered::of(&self.frame, carried, parts, fragments, of_spheres);
        // All ranks have all of the fluid.
        Some(gathered.with_fluid(self.run.wet_joints()))
    }

    /// The model without its mesh and without the nodes and facets on which boundaries act.
    pub fn model(&self) -> &Model<D, N> {
        &self.frame.model
    }

    /// Number of elements of the whole model.
    pub fn elements(&self) -> usize {
        self.frame.elements as usize
    }

    /// Bytes of all ranks, in their order, on rank 0.
    fn collect(&self, bytes: &[u8]) -> Option<Vec<Vec<u8>>> {
        if self.communicator.rank() > 0 {
            self.communicator.send(0, bytes);
            return None;
        }
        let others = (1..self.communicator.size()).map(|rank| self.communicator.receive(rank));
        Some(std::iter::once(bytes.to_vec()).chain(others).collect())
    }
}

/// Numbers the fragments of elements that hang together by these pairs, from 0 in the order of their first
/// elements.
fn united(elements: usize, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    // Every element points to one before it, or to itself if it is the first of its fragment.
    let mut before: Vec<u32> = (0..elements as u32).collect();
    let first = |before: &mut Vec<u32>, mut element: u32| {
        while before[element as usize] != element {
            let next = before[before[element as usize] as usize];
            before[element as usize] = next;
            element = next;
        }
        element
    };
    for [a, b] in pairs {
        let [a, b] = [first(&mut before, a), first(&mut before, b)];
        before[a.max(b) as usize] = a.min(b);
    }
    let mut numbers = vec![0; elements];
    let mut count = 0;
    for element in 0..elements as u32 {
        let of = first(&mut before, element);
        if of == element {
            numbers[element as usize] = count;
            count += 1;
        } else {
            numbers[element as usize] = numbers[of as usize];
        }
    }
    numbers
}

/// Gives this rank its part of a run.
fn part<'c, const D: usize, const N: usize>(
    run: Option<Simulation<D, N>>,
    links: Option<&Links<'c>>,
    division: &mut Option<Division<D>>,
    frame: &CommonData<D, N>,
    carried: CarriedState<D>,
    communicator: &'c dyn Communicator,
    team: &Team,
) -> Result<(Simulation<D, N>, Links<'c>), ModelError>
where
    [[f64; D]; N]: Machines<D, N>,
{
    let (pieces, near) = spread(run.as_ref(), links, division, frame, communicator);
    // The memory of the old part is free before that of the new one is needed.
    drop(run);
    let run = Simulation::of_pieces(frame, pieces, carried, communicator.rank() as u32, team.clone())?;
    let links = near.links(&run, communicator);
    Ok((run, links))
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// A run without elements.
    fn nothing(frame: &CommonData<D, N>, team: Team) -> Result<Self, ModelError> {
        let common = CarriedState {
            step: 0,
            totals: Totals::default(),
            energies: Energies::default(),
            imbalance: f64::INFINITY,
            reactions: Vec::new(),
            factors: Vec::new(),
            records: Vec::new(),
            timings: Timings::default(),
            detections: 0,
        };
        Self::of_pieces(frame, RunPieces::default(), common, u32::MAX, team)
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Watches all bare elements.
    pub(crate) fn watch(&mut self) {
        let Columns { joints, contacts, .. } = self.machine.columns_mut();
        contacts.watch_bare(joints, &self.topology);
    }

    /// Numbers of the joints, contacts and nodes that this rank counts.
    fn own_counts(&self) -> Counts {
        let share = self.solid().share();
        let loose = self.part.iter().flat_map(|part| &part.loose_joints).map(|moving| (&moving.joint, false));
        let here = self.joints().all.iter().filter(|joint| joint.counted);
        let (mut joints, mut broken, mut open, mut parted) = (0, 0, 0, 0);
        for (joint, holds) in here.map(|joint| (joint, joint.holds())).chain(loose) {
            let count = match (holds, joint.open_from_start) {
                (_, true) => &mut open,
                (true, false) => &mut joints,
                (false, false) => &mut broken,
            };
            *count += 1;
            parted += usize::from(!holds);
        }
        Counts {
            joints,
            broken,
            open,
            parted,
            contacts: self.touching.count,
            detections: self.contacts().detections(),
            nodes: (0..self.solid().node_count()).filter(|&node| share.node(node)).count(),
            ..self.sphere_counts()
        }
    }

    /// Displacement and velocity of a node of the mesh, if this rank owns its first corner.
    fn own_node(&self, node: u32) -> Option<([f64; D], [f64; D])> {
        let vertex = self.vertex_with(node)?;
        let first = *self.topology.corners_of(vertex).first()?;
        let is_first =
            self.part.as_ref().is_none_or(|part| part.is_first(vertex, self.topology.code_of_corner(first)));
        (is_first && self.solid().share().corner(first)).then(|| self.at_vertex(vertex))
    }

    fn own_crack_lengths(&self) -> [Sum; 3] {
        let counted = |joint: u32| self.joints().all[joint as usize].counted;
        let mut lengths = self.lengths_of_cracks(counted);
        for (modes, measure) in
            self.part.iter().flat_map(|part| &part.loose_joints).filter_map(MovingJoint::failed)
        {
            lengths[mode(modes) as usize].add(measure);
        }
        lengths
    }
}
