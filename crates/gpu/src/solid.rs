//! Phases of a step of a simulation on a device: elements, supports, and the motion of nodes.

use std::fmt;
use std::sync::Arc;

use bytemuck::cast_slice;
use fdem_simulation::{
    Accelerator, CoupleColumns, CoupleStates, DeviceSum, ElementValues, FlatBedding, FromDevice, HeldNode,
    JointColumns, JointMemories, JointPatch, NodeMotion, NodeSums, NotedState, Press, PressSums, Pulled,
    SUM_PARTS, SolidColumns, SolidPatch, SolidState,
};

use crate::array::Array;
use crate::contacts::DeviceContacts;
use crate::device::Device;
use crate::error::GpuError;
use crate::joints::DeviceJoints;
use crate::kernels::{
    CornerForceArguments, GatheredArguments, Kernel, LargestArguments, SolidElementArguments,
    SolidNodeArguments, THREADS,
};
use crate::patch::{Columns, Rows, grow};
use crate::primitives::{add_up, launch, launch_blocks, pieces, sums_of};
use crate::watch::DeviceWatch;

/// Sums over the motion of all nodes, and largest numbers.
const SUMS: usize = 7;
const MOSTS: usize = 3;

/// Bodies of a [`Simulation`](fdem_simulation::Simulation) on a device, for
/// [`Simulation::put_on`](fdem_simulation::Simulation::put_on).
pub struct DeviceSolid<V: Device, const D: usize, const N: usize> {
    device: Arc<V>,
    nodes: usize,
    elements: usize,
    held: usize,
    is_viscous: bool,
    is_bedded: bool,
    origin: [f64; D],
    positions: Array<V::Memory, f64>,
    velocities: Array<V::Memory, f64>,
    masses: Array<V::Memory, f64>,
    true_masses: Array<V::Memory, f64>,
    places: Array<V::Memory, u32>,
    holds: Array<V::Memory, u32>,
    drives: Array<V::Memory, f64>,
    reactions: Array<V::Memory, f64>,
    of_elements: Array<V::Memory, u32>,
    gradients: Array<V::Memory, f64>,
    volumes: Array<V::Memory, f64>,
    materials: Array<V::Memory, u32>,
    moduli: Array<V::Memory, f64>,
    beddings: Array<V::Memory, f64>,
    normals: Array<V::Memory, f64>,
    initial: Array<V::Memory, f64>,
    stored: Array<V::Memory, f64>,
    viscosities: Array<V::Memory, f64>,
    viscous: Array<V::Memory, f64>,
    dissipated: Array<V::Memory, f64>,
    forces: Array<V::Memory, f64>,
    stresses: Array<V::Memory, f64>,
    energies: Array<V::Memory, f64>,
    joints: DeviceJoints<V::Memory, D>,
    contacts: DeviceContacts<V::Memory, D>,
    ranges: Array<V::Memory, u32>,
    corners: Array<V::Memory, u32>,
    /// Corners on which forces are added, where those of each begin, and the forces.
    loaded: Array<V::Memory, u32>,
    starts: Array<V::Memory, u32>,
    added: Array<V::Memory, f64>,
    /// Nodes that the host reads, and their values.
    wanted: Array<V::Memory, u32>,
    gathered: Array<V::Memory, f64>,
    /// Sums and largest numbers of the blocks of nodes.
    sums: Array<V::Memory, f64>,
    mosts: Array<V::Memory, f64>,
    /// Whether an element is inverted, whether one is awake, and whether a node is too fast.
    flags: Array<V::Memory, u32>,
    /// Elements whose facets may fail, and whether any may by the last deformation.
    watch: DeviceWatch<V::Memory, D>,
    any_awake: bool,
    /// Rows that the host reads or changes.
    rows: Rows<V::Memory>,
    /// The parts of all sums, then the bits of the largest numbers.
    report: Array<V::Memory, u64>,
}

impl<V: Device, const D: usize, const N: usize> fmt::Debug for DeviceSolid<V, D, N> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { nodes, elements, held, .. } = self;
        write!(out, "DeviceSolid({nodes} nodes, {elements} elements, {held} held)")
    }
}

impl<V: Device, const D: usize, const N: usize> DeviceSolid<V, D, N> {
    /// A device without bodies.
    pub fn new(device: Arc<V>) -> Self {
        Self {
            device,
            nodes: 0,
            elements: 0,
            held: 0,
            is_viscous: false,
            is_bedded: false,
            origin: [0.0; D],
            positions: Array::new(),
            velocities: Array::new(),
            masses: Array::new(),
            true_masses: Array::new(),
            places: Array::new(),
            holds: Array::new(),
            drives: Array::new(),
            reactions: Array::new(),
            of_elements: Array::new(),
            gradients: Array::new(),
            volumes: Array::new(),
            materials: Array::new(),
            moduli: Array::new(),
            beddings: Array::new(),
            normals: Array::new(),
            initial: Array::new(),
            stored: Array::new(),
            viscosities: Array::new(),
            viscous: Array::new(),
            dissipated: Array::new(),
            forces: Array::new(),
            stresses: Array::new(),
            energies: Array::new(),
            joints: DeviceJoints::new(),
            contacts: DeviceContacts::new(),
            ranges: Array::new(),
            corners: Array::new(),
            loaded: Array::new(),
            starts: Array::new(),
            added: Array::new(),
            wanted: Array::new(),
            gathered: Array::new(),
            sums: Array::new(),
            mosts: Array::new(),
            flags: Array::new(),
            watch: DeviceWatch::new(),
            any_awake: false,
            rows: Rows::new(),
            report: Array::new(),
        }
    }

    /// The kernel for these dimensions.
    fn of<T>(plane: T, space: T) -> T {
        if D == 2 { plane } else { space }
    }

    /// Makes room for the sums over nodes.
    fn make_sums(&mut self) -> Result<(), GpuError> {
        let blocks = self.nodes.div_ceil(THREADS);
        self.sums.resize(&*self.device, 2 * SUMS * blocks)?;
        self.mosts.resize(&*self.device, MOSTS * blocks)?;
        self.make_report()
    }

    /// Makes room for the report.
    fn make_report(&mut self) -> Result<(), GpuError> {
        let nodes = 2 * SUMS * pieces(self.nodes.div_ceil(THREADS));
        let joints = pieces(self.joints.count).max(2 * pieces(self.joints.blocks()));
        let rows = nodes.max(pieces(self.elements)).max(joints);
        self.report.resize(&*self.device, SUM_PARTS * rows + MOSTS)?;
        Ok(())
    }

    /// The values of the wanted nodes, whose number this is.
    fn gather(&mut self, values: u64, count: usize) -> Result<Vec<[f64; D]>, GpuError> {
        let device = &*self.device;
        let mut found = vec![[0.0; D]; count];
        let arguments = GatheredArguments {
            values,
            numbers: self.wanted.address(device),
            gathered: self.gathered.resize(device, D * count)?,
            count: count as u64,
        };
        launch(device, Self::of(Kernel::GatherRows2, Kernel::GatherRows3), count, &arguments)?;
        self.gathered.read(device, 0, found.as_flattened_mut())?;
        Ok(found)
    }

    /// The sums of rows of numbers; successive rows belong to one sum.
    fn sums<const ROWS: usize, const SUMS: usize>(
        &self,
        numbers: u64,
        count: usize,
    ) -> Result<[DeviceSum; SUMS], GpuError> {
        add_up(&*self.device, self.report.address(&*self.device), ROWS, [numbers, count as u64])?;
        let mut parts = vec![0; SUM_PARTS * ROWS * pieces(count)];
        self.report.read(&*self.device, 0, &mut parts)?;
        Ok(sums_of(&parts))
    }
}

/// A node that is held, in the words of `HeldNode` in the kernels.
fn words<const D: usize>(of: &HeldNode<D>) -> impl Iterator<Item = u32> {
    let numbers = of.kinds.map(|kind| kind as u32).into_iter().chain(of.boundaries);
    let values: Vec<u32> = cast_slice([of.values, of.start].as_flattened()).to_vec();
    numbers.chain(values)
}

/// The bedding of a material, in the numbers of `Bedding` in the kernels.
fn numbers<const D: usize>(of: &FlatBedding<D>) -> impl Iterator<Item = f64> + use<D> {
    of.rest.into_iter().chain(of.normal)
}

impl<V: Device + Send + Sync, const D: usize, const N: usize> Accelerator<D, N> for DeviceSolid<V, D, N> {
    fn load(&mut self, solid: &SolidColumns<D, N>) -> FromDevice<()> {
        if (D != 2 && D != 3) || N != D + 1 {
            return Err(GpuError::Unsupported { what: "elements but triangles and tetrahedra" }.into());
        }
        let device = &*self.device;
        (self.nodes, self.elements) = (solid.masses.len(), solid.elements.len());
        self.held = solid.held.len();
        (self.is_viscous, self.is_bedded) = (!solid.viscosities.is_empty(), !solid.beddings.is_empty());
        self.origin = solid.origin;
        self.masses.write(device, &solid.masses)?;
        self.true_masses.write_some(device, &solid.true_masses)?;
        self.places.write(device, &solid.places)?;
        let holds: Vec<u32> = solid.held.iter().flat_map(words).collect();
        self.holds.write(device, &holds)?;
        self.reactions.resize(device, 2 * D * self.held)?;
        self.of_elements.write(device, solid.elements.as_flattened())?;
        self.gradients.write(device, solid.gradients.as_flattened().as_flattened())?;
        self.volumes.write(device, &solid.volumes)?;
        self.materials.write(device, &solid.materials)?;
        self.moduli.write(device, solid.moduli.as_flattened())?;
        let beddings: Vec<f64> = solid.beddings.iter().flat_map(numbers).collect();
        self.beddings.write_some(device, &beddings)?;
        self.initial.write_some(device, solid.initial.as_flattened().as_flattened())?;
        self.stored.write_some(device, &solid.stored)?;
        self.viscosities.write_some(device, &solid.viscosities)?;
        self.ranges.write(device, solid.ranges.as_flattened())?;
        self.corners.write(device, &solid.corners)?;
        self.watch = DeviceWatch::new();
        Ok(self.make_sums()?)
    }

    fn load_joints(&mut self, joints: &JointColumns<D>) -> FromDevice<()> {
        self.joints.load(&*self.device, joints)?;
        self.make_report()?;
        Ok(())
    }

    fn write_joints(&mut self, joints: &JointMemories<D>) -> FromDevice<()> {
        Ok(self.joints.write(&*self.device, joints)?)
    }

    fn write(&mut self, solid: &SolidState<D, N>) -> FromDevice<()> {
        let device = &*self.device;
        self.positions.write(device, solid.positions.as_flattened())?;
        self.velocities.write(device, solid.velocities.as_flattened())?;
        self.forces.write(device, solid.forces.as_flattened().as_flattened())?;
        self.stresses.write(device, solid.stresses.as_flattened().as_flattened())?;
        self.energies.write(device, &solid.energies)?;
        self.normals.write_some(device, solid.normals.as_flattened())?;
        self.viscous.write_some(device, solid.viscous.as_flattened().as_flattened())?;
        self.dissipated.write_some(device, &solid.dissipated)?;
        self.flags.write(device, &[0; 3])?;
        Ok(())
    }

    fn read(&self) -> FromDevice<(SolidState<D, N>, JointMemories<D>)> {
        let device = &*self.device;
        let (nodes, elements) = (self.nodes, self.elements);
        let viscous = if self.is_viscous { elements } else { 0 };
        let bedded = if self.is_bedded { elements } else { 0 };
        let mut state = SolidState {
            positions: vec![[0.0; D]; nodes],
            velocities: vec![[0.0; D]; nodes],
            forces: vec![[[0.0; D]; N]; elements],
            stresses: vec![[[0.0; D]; D]; elements],
            energies: vec![0.0; elements],
            viscous: vec![[[0.0; D]; D]; viscous],
            dissipated: vec![0.0; viscous],
            normals: vec![[0.0; D]; bedded],
        };
        self.positions.read(device, 0, state.positions.as_flattened_mut())?;
        self.velocities.read(device, 0, state.velocities.as_flattened_mut())?;
        self.forces.read(device, 0, state.forces.as_flattened_mut().as_flattened_mut())?;
        self.stresses.read(device, 0, state.stresses.as_flattened_mut().as_flattened_mut())?;
        self.energies.read(device, 0, &mut state.energies)?;
        self.normals.read(device, 0, state.normals.as_flattened_mut())?;
        if self.is_viscous {
            self.viscous.read(device, 0, state.viscous.as_flattened_mut().as_flattened_mut())?;
            self.dissipated.read(device, 0, &mut state.dissipated)?;
        }
        Ok((state, self.joints.read(device, None)?))
    }

    fn deform(&mut self, step: f64) -> FromDevice<bool> {
        let device = &*self.device;
        let arguments = SolidElementArguments {
            positions: self.positions.address(device),
            velocities: self.velocities.address(device),
            corners: self.of_elements.address(device),
            gradients: self.gradients.address(device),
            volumes: self.volumes.address(device),
            materials: self.materials.address(device),
            moduli: self.moduli.address(device),
            beddings: self.beddings.address(device),
            normals: self.normals.address(device),
            initial: self.initial.address(device),
            stored: self.stored.address(device),
            viscosities: self.viscosities.address(device),
            viscous: self.viscous.address(device),
            dissipated: self.dissipated.address(device),
            forces: self.forces.address(device),
            stresses: self.stresses.address(device),
            energies: self.energies.address(device),
            inverted: self.flags.address(device),
            step,
            count: self.elements as u64,
            watched: self.watch.arguments(device, self.flags.address(device) + size_of::<u32>() as u64),
        };
        launch(device, Self::of(Kernel::SolidDeform2, Kernel::SolidDeform3), self.elements, &arguments)?;
        let mut flags = [0; 2];
        self.flags.read(device, 0, &mut flags)?;
        self.any_awake = flags[1] != 0;
        Ok(flags[0] == 0)
    }

    fn pull(&mut self, step: f64, grains: [f64; 2], energies: bool) -> FromDevice<Pulled> {
        let device = &*self.device;
        let nodes = [&self.positions, &self.velocities].map(|column| column.address(device));
        let works = self.joints.pull(device, nodes, step, grains, energies)?;
        let [work] = self.sums::<2, 1>(works, self.joints.blocks())?;
        let mut elastic = None;
        if energies {
            let [sum] = self.sums::<1, 1>(self.joints.elastic(device), self.joints.count)?;
            elastic = Some(sum);
        }
        Ok(Pulled { work, elastic, left: self.joints.left(device)? })
    }

    fn load_couples(&mut self, couples: &CoupleColumns, states: &CoupleStates<D>) -> FromDevice<()> {
        Ok(self.contacts.load(&*self.device, couples, states)?)
    }

    fn read_couples(&self) -> FromDevice<CoupleStates<D>> {
        Ok(self.contacts.read(&*self.device)?)
    }

    fn read_touching(&self) -> FromDevice<Vec<bool>> {
        Ok(self.contacts.touching(&*self.device)?)
    }

    fn press(&mut self, press: &Press) -> FromDevice<PressSums> {
        let device = &*self.device;
        let nodes = [&self.positions, &self.velocities].map(|column| column.address(device));
        let elements = [self.of_elements.address(device), self.forces.address(device)];
        Ok(self.contacts.press(device, [nodes[0], nodes[1], elements[0], elements[1]], press)?)
    }

    fn add_forces(&mut self, forces: &[(u32, [f64; D])]) -> FromDevice<()> {
        let device = &*self.device;
        let mut forces = forces.to_vec();
        // Stable: the forces on a corner stay in their order.
        forces.sort_by_key(|(corner, _)| *corner);
        let (mut loaded, mut starts) = (Vec::new(), Vec::new());
        for (place, (corner, _)) in (0..).zip(&forces) {
            if loaded.last() != Some(corner) {
                loaded.push(*corner);
                starts.push(place);
            }
        }
        starts.push(forces.len() as u32);
        let added: Vec<[f64; D]> = forces.into_iter().map(|(_, force)| force).collect();
        let arguments = CornerForceArguments {
            corners: self.loaded.write(device, &loaded)?,
            starts: self.starts.write(device, &starts)?,
            added: self.added.write(device, added.as_flattened())?,
            forces: self.forces.address(device),
            count: loaded.len() as u64,
        };
        launch(device, Self::of(Kernel::AddForces2, Kernel::AddForces3), loaded.len(), &arguments)?;
        Ok(())
    }

    fn move_nodes(&mut self, motion: &NodeMotion<'_, D>) -> FromDevice<NodeSums<D>> {
        let device = &*self.device;
        let drives: Vec<f64> = motion
            .drives
            .iter()
            .flat_map(|of| of.factors.into_iter().chain(of.turn.into_iter().flatten()).chain(of.through))
            .collect();
        let in_space = |vector: [f64; D]| std::array::from_fn(|k| vector.get(k).copied().unwrap_or(0.0));
        let blocks = self.nodes.div_ceil(THREADS);
        let arguments = SolidNodeArguments {
            positions: self.positions.address(device),
            velocities: self.velocities.address(device),
            masses: self.masses.address(device),
            true_masses: self.true_masses.address(device),
            ranges: self.ranges.address(device),
            corners: self.corners.address(device),
            forces: self.forces.address(device),
            ends: self.joints.ends(device),
            of_joints: self.joints.forces.address(device),
            places: self.places.address(device),
            held: self.holds.address(device),
            drives: self.drives.write(device, &drives)?,
            reactions: self.reactions.address(device),
            sums: self.sums.address(device),
            mosts: self.mosts.address(device),
            runaway: self.flags.address(device) + 2 * size_of::<u32>() as u64,
            gravity: in_space(motion.gravity),
            origin: in_space(self.origin),
            grains: motion.grains,
            step: motion.step,
            local_damping: motion.local_damping,
            relaxation: motion.relaxation,
            speed_limit: motion.speed_limit,
            count: self.nodes as u64,
            energy: u32::from(motion.energy),
            taken: motion.taken.map(u32::from),
            blocks: blocks as u32,
        };
        launch(device, Self::of(Kernel::SolidMove2, Kernel::SolidMove3), self.nodes, &arguments)?;
        add_up(device, self.report.address(device), 2 * SUMS, [arguments.sums, blocks as u64])?;
        let parts = SUM_PARTS * 2 * SUMS * pieces(blocks);
        let largest = LargestArguments {
            numbers: arguments.mosts,
            largest: self.report.address(device) + (size_of::<u64>() * parts) as u64,
            count: blocks as u64,
        };
        launch_blocks(device, Kernel::LargestNumbers, MOSTS, &largest)?;
        let (mut report, mut runaway) = (vec![0; parts + MOSTS], [0]);
        let mut held = vec![[[0.0; D]; 2]; self.held];
        self.report.read(device, 0, &mut report)?;
        self.flags.read(device, 2, &mut runaway)?;
        if self.held > 0 {
            self.reactions.read(device, 0, held.as_flattened_mut().as_flattened_mut())?;
        }
        let mosts: [f64; MOSTS] = std::array::from_fn(|k| f64::from_bits(report[parts + k]));
        // Both parts of the rounded numbers belong to one sum.
        let sums = sums_of::<SUMS>(&report[..parts]);
        Ok(NodeSums {
            sums,
            fastest: mosts[0],
            largest: [mosts[1], mosts[2]],
            runs_away: runaway != [0],
            held,
        })
    }

    fn read_positions(&mut self, nodes: &[u32]) -> FromDevice<Vec<[f64; D]>> {
        let device = &*self.device;
        self.wanted.write(device, nodes)?;
        Ok(self.gather(self.positions.address(device), nodes.len())?)
    }

    fn read_nodes(&mut self, nodes: &[u32]) -> FromDevice<[Vec<[f64; D]>; 2]> {
        let positions = self.read_positions(nodes)?;
        Ok([positions, self.gather(self.velocities.address(&*self.device), nodes.len())?])
    }

    fn write_nodes(&mut self, nodes: &[u32], motion: &[Vec<[f64; D]>; 2]) -> FromDevice<()> {
        let device = &*self.device;
        self.rows.choose(device, nodes)?;
        for (column, values) in [&self.positions, &self.velocities].into_iter().zip(motion) {
            self.rows.write(device, column, Columns::ONE, values.as_flattened())?;
        }
        Ok(())
    }

    fn note(&mut self, elements: &[u32], states: &[NotedState<D>]) -> FromDevice<()> {
        let device = &*self.device;
        self.rows.choose(device, elements)?;
        Ok(self.watch.note(device, &mut self.rows, states, self.elements)?)
    }

    fn awake(&mut self) -> FromDevice<Vec<u32>> {
        if !std::mem::take(&mut self.any_awake) {
            return Ok(Vec::new());
        }
        let device = &*self.device;
        self.flags.write(device, &[0; 3])?;
        Ok(self.watch.awake(device, self.elements)?)
    }

    fn read_elements(&mut self, elements: &[u32]) -> FromDevice<ElementValues<D, N>> {
        let (device, count) = (&*self.device, elements.len());
        let mut values = ElementValues {
            stresses: vec![[[0.0; D]; D]; count],
            forces: vec![[[0.0; D]; N]; count],
            moved: vec![0.0; if self.watch.is_empty() { 0 } else { count }],
            normals: vec![[0.0; D]; if self.is_bedded { count } else { 0 }],
        };
        let (stresses, forces) = (values.stresses.as_flattened_mut(), values.forces.as_flattened_mut());
        self.rows.choose(device, elements)?;
        self.rows.read(device, &self.stresses, Columns::ONE, stresses.as_flattened_mut())?;
        self.rows.read(device, &self.forces, Columns::ONE, forces.as_flattened_mut())?;
        self.watch.moved(device, &mut self.rows, &mut values.moved)?;
        self.rows.read(device, &self.normals, Columns::ONE, values.normals.as_flattened_mut())?;
        Ok(values)
    }

    fn read_joints(&mut self, joints: &[u32]) -> FromDevice<JointMemories<D>> {
        Ok(self.joints.read(&*self.device, Some((joints, &mut self.rows)))?)
    }

    fn patch(&mut self, patch: &SolidPatch<D, N>) -> FromDevice<()> {
        let (device, rows) = (&*self.device, &mut self.rows);
        self.nodes = patch.node_count;
        let (of_hold, held) = (6 * D, self.held);
        self.held += patch.held.len();
        for column in [&mut self.positions, &mut self.velocities] {
            grow(device, column, D * self.nodes)?;
        }
        grow(device, &mut self.masses, self.nodes)?;
        grow(device, &mut self.places, self.nodes)?;
        grow(device, &mut self.ranges, 2 * self.nodes)?;
        grow(device, &mut self.holds, of_hold * self.held)?;
        rows.choose(device, &patch.nodes)?;
        if !patch.true_masses.is_empty() {
            grow(device, &mut self.true_masses, self.nodes)?;
            rows.write(device, &self.true_masses, Columns::ONE, &patch.true_masses)?;
        }
        rows.write(device, &self.positions, Columns::ONE, patch.positions.as_flattened())?;
        rows.write(device, &self.velocities, Columns::ONE, patch.velocities.as_flattened())?;
        rows.write(device, &self.masses, Columns::ONE, &patch.masses)?;
        rows.write(device, &self.places, Columns::ONE, &patch.places)?;
        rows.write(device, &self.ranges, Columns::ONE, patch.ranges.as_flattened())?;
        let places: Vec<u32> = patch.ranges.iter().flat_map(|[begin, end]| *begin..*end).collect();
        rows.choose(device, &places)?;
        rows.write(device, &self.corners, Columns::ONE, &patch.corners)?;
        rows.choose(device, &patch.elements)?;
        rows.write(device, &self.of_elements, Columns::ONE, patch.of_elements.as_flattened())?;
        let holds: Vec<u32> = patch.held.iter().flat_map(words).collect();
        rows.choose(device, &(held as u32..self.held as u32).collect::<Vec<_>>())?;
        rows.write(device, &self.holds, Columns::ONE, &holds)?;
        self.reactions.resize(device, 2 * D * self.held)?;
        Ok(self.make_sums()?)
    }

    fn patch_joints(&mut self, patch: &JointPatch<D>) -> FromDevice<()> {
        self.joints.patch(&*self.device, &mut self.rows, patch)?;
        Ok(self.make_report()?)
    }

    fn energies(&self) -> FromDevice<[DeviceSum; 2]> {
        let device = &*self.device;
        let mut sums = [[0; SUM_PARTS]; 2];
        let columns = [&self.energies, &self.dissipated];
        for (sum, column) in sums.iter_mut().zip(columns).take(1 + usize::from(self.is_viscous)) {
            [*sum] = self.sums::<1, 1>(column.address(device), self.elements)?;
        }
        Ok(sums)
    }
}
