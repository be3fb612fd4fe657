//! A device with a memory of its own as a machine: see `accelerator.rs`.
//!
//! The device has nodes, elements, joints, and couples of elements while any of these is near. It computes
//! their phases. The host computes all others on its columns: it copies them when a phase or anything else
//! asks for them, and the device takes changed ones over before its next phase. Phases that have nothing to
//! do ask for none. The search of couples gets the elements that can touch
//! (`on_device/contacts.rs`).
//!
//! Joints that change their kind, the check of facets, insertion and splitting concern few nodes, elements
//! and joints. The host reads the values of these only, computes, and sends the changes
//! (`on_device/parts.rs`). The device finds the elements whose facets may fail. Where many facets fail in a
//! step, all is copied. The host moves rigid bodies, and sends their nodes (`on_device/rigid.rs`).

mod contacts;
mod parts;
mod rigid;
mod values;

use std::sync::{Mutex, OnceLock, PoisonError};

use crate::accelerator::{Accelerator, DeviceSum, FromDevice, HeldNode, NodeMotion, Pulled};
use crate::actions::prescribed;
use crate::contacts::Touching;
use crate::error::Stop;
use crate::joints::Pulling;
use crate::joints::due::CheckLists;
use crate::machine::on_device::values::Values;
use crate::machine::{Columns, Machine, Wanted};
use crate::model::Model;
use crate::motion::nodes::Motion;
use crate::motion::{MotionSums, RelaxationSums, Selected};
use crate::rotation::lifted;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::Node;
use crate::sum::Sum;
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::{Point, dot, plus};

/// Share of the facets that fail in a step, 1 in this number, above which all columns are copied.
const FEW: usize = 100;

/// The changes of the host that the device has not taken over: of values of nodes and elements that phases
/// change, and of all columns.
#[derive(Clone, Copy, Debug, Default)]
struct Changed {
    solid: bool,
    all: bool,
}

impl Changed {
    const NOTHING: Self = Self { solid: false, all: false };
    const SOLID: Self = Self { solid: true, ..Self::NOTHING };
    const ALL: Self = Self { solid: true, all: true };
}

/// A device, and the columns of the host.
#[derive(Debug)]
pub(crate) struct OnDevice<const D: usize, const N: usize> {
    device: Mutex<Box<dyn Accelerator<D, N>>>,
    /// The columns of the host, while they are up to date.
    host: OnceLock<Columns<D, N>>,
    /// The same ones, while they are not.
    stale: Mutex<Option<Columns<D, N>>>,
    changed: Changed,
    /// Whether the couples of the host are up to date, and those of the device are not.
    couples_changed: bool,
    /// The motions that boundaries prescribe, by their numbers.
    holds: Vec<HeldNode<D>>,
    /// The nodes of these motions, ascending, each with the number of its motion.
    held: Vec<[u32; 2]>,
    /// The elements on which loads act in this step, with repetitions.
    loaded: Vec<u32>,
    /// The elements and facets of checks, where joints are inserted.
    lists: CheckLists,
    /// Origin of positions, m.
    origin: Point<D>,
    /// Why the device has failed. It computes nothing any more.
    failure: Mutex<Option<String>>,
    /// The share of a run that has no other ranks.
    whole: Share,
    team: Team,
}

impl<const D: usize, const N: usize> OnDevice<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Hands columns over to a device. `holds`: the motions that boundaries prescribe, by their numbers.
    pub(crate) fn new(
        device: Box<dyn Accelerator<D, N>>,
        mut columns: Columns<D, N>,
        holds: Vec<HeldNode<D>>,
        team: Team,
    ) -> FromDevice<Self> {
        let mut lists = CheckLists::default();
        if columns.joints.inserts() {
            columns.solid.begin_watch();
            lists = columns.joints.begin_lists();
        }
        let mut this = Self {
            device: Mutex::new(device),
            host: OnceLock::from(columns),
            stale: Mutex::default(),
            changed: Changed::ALL,
            couples_changed: true,
            holds,
            held: Vec::new(),
            loaded: Vec::new(),
            lists,
            origin: [0.0; D],
            failure: Mutex::default(),
            whole: Share::default(),
            team,
        };
        this.hand_over()?;
        Ok(this)
    }

    /// Lets the device take over the changes of the host, whose columns are up to date.
    fn hand_over(&mut self) -> FromDevice<()> {
        let changed = std::mem::take(&mut self.changed);
        let Some(columns) = self.host.get() else { return Ok(()) };
        let device = self.device.get_mut().unwrap_or_else(PoisonError::into_inner);
        if changed.all {
            let solid = columns.solid.flat(&self.holds);
            self.held = solid.held.iter().map(|of| [of.node, columns.solid.hold(of.node as usize)]).collect();
            self.origin = solid.origin;
            device.load(&solid)?;
        }
        if changed.solid {
            device.write(&columns.solid.flat_state())?;
        }
        if changed.all {
            device.load_joints(&columns.joints.flat(columns.solid.thickness))?;
            device.write_joints(&columns.joints.flat_memories())?;
            let elements: Vec<u32> = (0..columns.solid.element_count() as u32).collect();
            let states = columns.solid.noted(&elements);
            if !states.is_empty() {
                device.note(&elements, &states)?;
            }
        }
        Ok(())
    }

    /// A phase on the device, after which the columns of the host are out of date. Nothing once the device
    /// has failed.
    fn compute<T: Default>(&mut self, phase: impl FnOnce(&mut dyn Accelerator<D, N>) -> FromDevice<T>) -> T {
        if self.failure().is_some() {
            return T::default();
        }
        let mut done = self.hand_over();
        if let Some(columns) = self.host.take() {
            *self.stale.get_mut().unwrap_or_else(PoisonError::into_inner) = Some(columns);
        }
        let device = self.device.get_mut().unwrap_or_else(PoisonError::into_inner);
        let mut result = T::default();
        if done.is_ok() {
            done = phase(&mut **device).map(|found| result = found);
        }
        if let Err(error) = done {
            self.fail(&error.to_string());
        }
        result
    }

    fn fail(&self, reason: &str) {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.get_or_insert_with(|| reason.to_owned());
    }

    fn failure(&self) -> Option<Stop> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.clone().map(Stop::Device)
    }

    /// The columns of the host, of which those that the device has may be out of date.
    fn known(&mut self) -> &mut Columns<D, N> {
        let stale = self.stale.get_mut().unwrap_or_else(PoisonError::into_inner);
        self.host.get_mut().or(stale.as_mut()).expect("the columns are in one of the two places")
    }

    /// A value of the columns of the host that the device does not change.
    fn of_known<T>(&self, value: impl FnOnce(&Columns<D, N>) -> T) -> T {
        if let Some(columns) = self.host.get() {
            return value(columns);
        }
        let stale = self.stale.lock().unwrap_or_else(PoisonError::into_inner);
        value(stale.as_ref().expect("the columns are in one of the two places"))
    }

    /// The columns of the host, up to date, for a phase that it computes.
    fn on_host(&mut self, changed: Changed) -> &mut Columns<D, N> {
        self.columns();
        self.changed.solid |= changed.solid;
        self.changed.all |= changed.all;
        // Joints carry a part of the forces between their elements.
        self.couples_changed |= changed.all;
        self.host.get_mut().expect("they are up to date")
    }
}

impl<const D: usize, const N: usize> Machine<D, N> for OnDevice<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn deform(&mut self, step: f64) -> Option<(u32, f64)> {
        let is_inverted = self.compute(|device| Ok(!device.deform(step)?));
        if is_inverted { self.columns().solid.first_inverted() } else { None }
    }

    fn pull(&mut self, step: f64, time: f64, energies: bool) -> Pulling {
        if self.known().joints.all.is_empty() {
            let elastic = energies.then(Sum::default);
            return Pulling { broken: Vec::new(), work: Sum::default(), elastic };
        }
        let grains = self.known().solid.grains.shifts();
        let pulled = self.compute(|device| device.pull(step, grains, energies).map(Some));
        let mut pulling = Pulling { broken: Vec::new(), work: Sum::default(), elastic: None };
        if let Some(Pulled { work, elastic, left }) = pulled {
            let mut elastic = elastic.as_ref().map(sum_of);
            if !left.is_empty() {
                pulling = self.pull_left(&left, step, time).unwrap_or(pulling);
                let Columns { solid, joints, .. } = self.known();
                if let Some(elastic) = &mut elastic {
                    elastic.add_sum(&joints.elastic_of(&left, solid));
                }
            }
            pulling.work.add_sum(&sum_of(&work));
            pulling.elastic = elastic;
        }
        pulling
    }

    fn detect(&mut self, topology: &Topology<D, N>) -> Result<(), Stop> {
        if let Some(stop) = self.failure() {
            return Err(stop);
        }
        self.search(topology)
    }

    fn touch(&mut self, topology: &Topology<D, N>, step: f64, energies: bool) -> Touching {
        self.press(topology, step, energies)
    }

    fn add_forces(&mut self, forces: &[(u32, Point<D>)]) {
        self.compute(|device| device.add_forces(forces));
        if self.known().joints.inserts() {
            self.loaded.extend(forces.iter().map(|(corner, _)| corner / N as u32));
        }
    }

    fn failing(&mut self, model: &Model<D, N>, topology: &Topology<D, N>) -> Vec<u32> {
        let loaded = std::mem::take(&mut self.loaded);
        if !self.known().joints.inserts() {
            return Vec::new();
        }
        self.find_failing(model, topology, loaded).unwrap_or_default()
    }

    fn move_nodes(
        &mut self,
        motion: &Motion<'_, D, N>,
        selected: Selected<'_>,
        sums: &mut MotionSums<Sum, D>,
    ) {
        // There are no other ranks: the second call is for all nodes.
        if matches!(selected, Selected::Only(_)) {
            return;
        }
        if !self.known().solid.rigid.is_empty() && self.move_rigid(motion, sums).is_none() {
            return;
        }
        let drives = prescribed::drives(motion.model, motion.schedules, [motion.time, motion.step]);
        let given = NodeMotion {
            step: motion.step,
            gravity: motion.gravity,
            local_damping: motion.model.time.local_damping,
            relaxation: motion.relaxation,
            speed_limit: motion.speed_limit,
            grains: motion.grains.shifts(),
            energy: motion.energy,
            taken: [RelaxationSums::After, RelaxationSums::Before].map(|of| motion.taken == of),
            drives: &drives,
        };
        let Some(moved) = self.compute(|device| device.move_nodes(&given).map(Some)) else { return };
        sums.kinetic.add_sum(&sum_of(&moved.sums[0]));
        for half in 0..2 {
            sums.external[half].add_sum(&sum_of(&moved.sums[1 + half]));
            sums.damping[half].add_sum(&sum_of(&moved.sums[3 + half]));
            sums.taken[half].add_sum(&sum_of(&moved.sums[5 + half]));
        }
        sums.fastest = sums.fastest.max(moved.fastest.sqrt());
        sums.largest = std::array::from_fn(|k| sums.largest[k].max(moved.largest[k]));
        for (&[node, hold], [reaction, before]) in self.held.iter().zip(&moved.held) {
            sums.held.push((node, *reaction));
            // A rotation holds a node along all axes.
            if let Some(hold) = motion.holds[hold as usize][0] {
                let place = lifted(plus(*before, self.origin));
                sums.moments.extend(hold.moment(place, lifted(*reaction)));
            }
        }
        if moved.runs_away {
            let solid = &self.columns().solid;
            let limit = motion.speed_limit * motion.speed_limit;
            let free = (0..solid.node_count()).filter(|&node| !solid.rigid.has_node(node));
            let squares = free.map(|node| {
                let velocity = solid.velocity(node);
                (solid.corners(node)[0] / N as u32, dot(velocity, velocity))
            });
            for (element, squared) in squares.filter(|(_, of)| *of > limit || of.is_nan()) {
                sums.note_runaway((element, squared.sqrt()));
            }
        }
    }

    fn read_nodes(&self, nodes: &[u32], each: &mut dyn FnMut(Node<D>)) {
        if let Some(columns) = self.host.get() {
            for &node in nodes {
                each(columns.solid.node(node as usize));
            }
            return;
        }
        let mut device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        let found = device.read_nodes(nodes);
        let [positions, velocities] = found.unwrap_or_else(|error| {
            self.fail(&error.to_string());
            [(); 2].map(|()| vec![[0.0; D]; nodes.len()])
        });
        for (position, velocity) in positions.into_iter().zip(velocities) {
            each(Node { position, velocity });
        }
    }

    fn read_corners(&self, corners: &[u32], each: &mut dyn FnMut(Node<D>)) {
        if corners.is_empty() {
            return;
        }
        let nodes: Vec<u32> =
            self.of_known(|columns| corners.iter().map(|&corner| columns.solid.node_at(corner)).collect());
        self.read_nodes(&nodes, each);
    }

    fn share(&self) -> &Share {
        &self.whole
    }

    fn write_nodes(&mut self, nodes: &[u32], next: &mut dyn FnMut() -> Node<D>) {
        let Columns { solid, .. } = self.on_host(Changed::SOLID);
        for &node in nodes {
            solid.set_node(node as usize, next());
        }
    }

    fn end_motion(&mut self, distance: f64) {
        self.known().contacts.note_motion(distance);
    }

    fn energies(&self) -> [Sum; 2] {
        if let Some(columns) = self.host.get() {
            return columns.solid.energies(&self.team);
        }
        let device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        match device.energies() {
            Ok(sums) => sums.each_ref().map(sum_of),
            Err(error) => {
                self.fail(&error.to_string());
                Default::default()
            }
        }
    }

    /// The host moves rigid bodies, and has read the forces on them.
    fn look_at(&self, wanted: &Wanted, look: &mut dyn FnMut(&Columns<D, N>)) {
        if let Some(columns) = self.host.get() {
            return look(columns);
        }
        let mut stale = self.stale.lock().unwrap_or_else(PoisonError::into_inner);
        let columns = stale.as_mut().expect("the columns are in one of the two places");
        if !wanted.is_empty() && self.failure().is_none() {
            let mut device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
            match Values::read(&mut **device, wanted) {
                Ok(values) => values.put_into(wanted, columns),
                Err(error) => self.fail(&error.to_string()),
            }
        }
        look(columns);
    }

    fn columns(&self) -> &Columns<D, N> {
        self.host.get_or_init(|| {
            let stale = self.stale.lock().unwrap_or_else(PoisonError::into_inner).take();
            let mut columns = stale.expect("the columns are in one of the two places");
            let device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
            let couples = if self.couples_changed { Ok(None) } else { device.read_couples().map(Some) };
            match device.read().and_then(|read| Ok((read, couples?))) {
                Ok(((solid, joints), couples)) => {
                    columns.solid.take_flat(solid);
                    columns.joints.take_flat(joints);
                    if let Some(couples) = couples {
                        columns.contacts.take_flat(&couples);
                    }
                }
                Err(error) => self.fail(&error.to_string()),
            }
            columns
        })
    }

    fn columns_mut(&mut self) -> &mut Columns<D, N> {
        self.on_host(Changed::ALL)
    }

    fn change_at(
        &mut self,
        facets: &[u32],
        topology: &Topology<D, N>,
        change: &mut dyn FnMut(&mut Columns<D, N>),
    ) {
        if facets.is_empty() {
            // The columns of joints that broke have been handed over.
            change(self.known());
        } else if FEW * facets.len() > topology.facets.len() {
            change(self.on_host(Changed::ALL));
        } else {
            // After a failure of the device the run stops.
            self.change_around(facets, topology, change);
        }
    }

    fn check(&self) -> Result<(), Stop> {
        self.failure().map_or(Ok(()), Err)
    }

    fn into_device(self: Box<Self>) -> Option<Box<dyn Accelerator<D, N>>> {
        Some(self.device.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

fn sum_of(parts: &DeviceSum) -> Sum {
    Sum::of_parts(parts)
}
