//! Joints of a simulation on a device.

use fdem_simulation::{EndMemory, FlatLaw, JointColumns, JointMemories, JointPatch};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Address, JointArguments, Kernel, NumberArguments, THREADS};
use crate::patch::{Columns, Rows, grow, stretch};
use crate::primitives::launch;
use crate::watch::MarkedList;

/// Bits of the marks of a joint in the kernels, beside its kind.
const COUNTED: u32 = 4;
const BROKEN: u32 = 8;
const OPEN: u32 = 16;

/// The joints of a run.
pub(crate) struct DeviceJoints<M, const D: usize> {
    pub(crate) count: usize,
    /// Joints for which columns have room: numbers from the beginning of one to that of the next.
    stride: usize,
    nodes: Array<M, u32>,
    marks: Array<M, u32>,
    laws: Array<M, f64>,
    memories: Array<M, f64>,
    pub(crate) forces: Array<M, f64>,
    /// Ends of joints at each corner.
    at_corner: Array<M, u32>,
    /// Joints that the host is to compute, and whether there are any.
    left: Array<M, u32>,
    any_left: Array<M, u32>,
    list: MarkedList<M>,
    elastic: Array<M, f64>,
    sums: Array<M, f64>,
}

impl<M, const D: usize> DeviceJoints<M, D> {
    /// Numbers of the memory of an end.
    const MEMORY: usize = 3 + 2 * D;

    pub(crate) const fn new() -> Self {
        Self {
            count: 0,
            stride: 0,
            nodes: Array::new(),
            marks: Array::new(),
            laws: Array::new(),
            memories: Array::new(),
            forces: Array::new(),
            at_corner: Array::new(),
            left: Array::new(),
            any_left: Array::new(),
            list: MarkedList::new(),
            elastic: Array::new(),
            sums: Array::new(),
        }
    }

    /// Blocks of joints.
    pub(crate) fn blocks(&self) -> usize {
        self.count.div_ceil(THREADS)
    }

    /// Takes joints over.
    pub(crate) fn load(
        &mut self,
        device: &impl Device<Memory = M>,
        joints: &JointColumns<D>,
    ) -> Result<(), GpuError> {
        (self.count, self.stride) = (joints.kinds.len(), joints.kinds.len());
        self.at_corner.write_some(device, joints.at_corner.as_flattened())?;
        self.nodes.write(device, joints.nodes.as_flattened().as_flattened())?;
        self.marks.write(device, &marks_of(joints))?;
        self.laws.write(device, &numbers_of(&joints.laws))?;
        self.make_room(device)
    }

    /// Makes room for the results of a pass.
    fn make_room(&mut self, device: &impl Device<Memory = M>) -> Result<(), GpuError> {
        self.left.resize(device, self.stride)?;
        self.elastic.resize(device, self.stride)?;
        self.sums.resize(device, 2 * self.stride.div_ceil(THREADS))?;
        Ok(())
    }

    /// Ends of joints at each corner; 0 without joints.
    pub(crate) fn ends(&self, device: &impl Device<Memory = M>) -> Address {
        if self.count == 0 { 0 } else { self.at_corner.address(device) }
    }

    /// Takes the state of the joints over.
    pub(crate) fn write(
        &mut self,
        device: &impl Device<Memory = M>,
        joints: &JointMemories<D>,
    ) -> Result<(), GpuError> {
        self.memories.write(device, &memory_numbers(&joints.ends))?;
        self.forces.write(device, joints.forces.as_flattened().as_flattened())?;
        Ok(())
    }

    /// The columns of the numbers of laws, and of memories.
    fn columns(stride: usize) -> [Columns; 2] {
        [9 + D, D * Self::MEMORY].map(|columns| Columns { columns, stride })
    }

    /// Takes changes of joints over.
    pub(crate) fn patch<V: Device<Memory = M>>(
        &mut self,
        device: &V,
        rows: &mut Rows<M>,
        patch: &JointPatch<D>,
    ) -> Result<(), GpuError> {
        if patch.count > self.stride {
            let stride = patch.count + patch.count / 4;
            let ([of_laws, of_memories], now) = (Self::columns(self.stride), Self::columns(stride));
            stretch(device, &mut self.laws, [of_laws, now[0]], self.count)?;
            stretch(device, &mut self.memories, [of_memories, now[1]], self.count)?;
            grow(device, &mut self.nodes, 2 * D * stride)?;
            grow(device, &mut self.marks, stride)?;
            grow(device, &mut self.forces, D * D * stride)?;
            self.stride = stride;
            self.make_room(device)?;
        }
        self.count = patch.count;
        let [of_laws, of_memories] = Self::columns(self.stride);
        let JointPatch { columns, memories, .. } = patch;
        rows.choose(device, &patch.joints)?;
        rows.write(device, &self.nodes, Columns::ONE, columns.nodes.as_flattened().as_flattened())?;
        rows.write(device, &self.marks, Columns::ONE, &marks_of(columns))?;
        rows.write(device, &self.laws, of_laws, &numbers_of(&columns.laws))?;
        rows.write(device, &self.memories, of_memories, &memory_numbers(&memories.ends))?;
        rows.write(device, &self.forces, Columns::ONE, memories.forces.as_flattened().as_flattened())?;
        rows.choose(device, &patch.corners)?;
        rows.write(device, &self.at_corner, Columns::ONE, columns.at_corner.as_flattened())
    }

    /// The state of some joints; all of them without a list.
    pub(crate) fn read(
        &self,
        device: &impl Device<Memory = M>,
        some: Option<(&[u32], &mut Rows<M>)>,
    ) -> Result<JointMemories<D>, GpuError> {
        let [_, columns] = Self::columns(self.stride);
        let count = some.as_ref().map_or(self.count, |(joints, _)| joints.len());
        let mut forces = vec![[[0.0; D]; D]; count];
        let mut numbers = vec![0.0; D * Self::MEMORY * count];
        let stride = if let Some((joints, rows)) = some {
            rows.choose(device, joints)?;
            rows.read(device, &self.memories, columns, &mut numbers)?;
            rows.read(device, &self.forces, Columns::ONE, forces.as_flattened_mut().as_flattened_mut())?;
            count
        } else {
            numbers.resize(D * Self::MEMORY * self.stride, 0.0);
            self.memories.read(device, 0, &mut numbers)?;
            self.forces.read(device, 0, forces.as_flattened_mut().as_flattened_mut())?;
            self.stride
        };
        let ends = |joint: usize| {
            std::array::from_fn(|end| {
                let number = |k: usize| numbers[(end * Self::MEMORY + k) * stride + joint];
                EndMemory {
                    damages: [number(0), number(1)],
                    stiffness: number(2),
                    origin: std::array::from_fn(|axis| number(3 + axis)),
                    rubbed: std::array::from_fn(|axis| number(3 + D + axis)),
                }
            })
        };
        Ok(JointMemories { ends: (0..count).map(ends).collect(), forces })
    }

    /// Where the elastic energies of the last pass are that was asked for them, a number for each joint.
    pub(crate) fn elastic(&self, device: &impl Device<Memory = M>) -> Address {
        self.elastic.address(device)
    }

    /// Computes the joints from the positions and velocities of the nodes. `energies`: whether to compute
    /// their elastic energies. Returns where the parts of their work are, two rows of a number for each
    /// block.
    pub(crate) fn pull(
        &mut self,
        device: &impl Device<Memory = M>,
        [positions, velocities]: [u64; 2],
        step: f64,
        grains: [f64; 2],
        energies: bool,
    ) -> Result<u64, GpuError> {
        let arguments = JointArguments {
            positions,
            velocities,
            nodes: self.nodes.address(device),
            marks: self.marks.address(device),
            laws: self.laws.address(device),
            memories: self.memories.address(device),
            forces: self.forces.address(device),
            left: self.left.address(device),
            any_left: self.any_left.write(device, &[0])?,
            elastic: if energies { self.elastic.address(device) } else { 0 },
            sums: self.sums.address(device),
            grains,
            step,
            count: self.count as u64,
            blocks: self.blocks() as u64,
            stride: self.stride as u64,
        };
        let kernel = if D == 2 { Kernel::PullJoints2 } else { Kernel::PullJoints3 };
        launch(device, kernel, self.count, &arguments)?;
        Ok(arguments.sums)
    }

    /// The joints that the host is to compute after the last pass.
    pub(crate) fn left(&mut self, device: &impl Device<Memory = M>) -> Result<Vec<u32>, GpuError> {
        let mut any = [0];
        self.any_left.read(device, 0, &mut any)?;
        if any == [0] {
            return Ok(Vec::new());
        }
        self.list.of(device, self.left.address(device), self.count)
    }
}

/// The kinds of joints, with bits for their marks.
fn marks_of<const D: usize>(joints: &JointColumns<D>) -> Vec<u32> {
    let marks = |k: usize| {
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let open = joints.open[k].iter().enumerate().map(|(end, open)| flag(*open, OPEN << end));
        let of_joint = flag(joints.counted[k], COUNTED) | flag(joints.broken[k], BROKEN);
        joints.kinds[k] as u32 | of_joint | open.fold(0, |all, bit| all | bit)
    };
    (0..joints.kinds.len()).map(marks).collect()
}

/// The numbers of laws, one column after the other.
fn numbers_of<const D: usize>(laws: &[FlatLaw<D>]) -> Vec<f64> {
    let number = |law: &FlatLaw<D>, number: usize| match number {
        0 => law.penalty,
        1 => law.tensile,
        2 => law.cohesion,
        3 => law.friction,
        4 | 5 => law.critical[number - 4],
        6 => law.share,
        7 => law.length,
        8 => law.faded,
        axis => law.normal[axis - 9],
    };
    (0..9 + D).flat_map(|column| laws.iter().map(move |law| number(law, column))).collect()
}

/// The numbers of the memories of joints, one column after the other.
fn memory_numbers<const D: usize>(ends: &[[EndMemory<D>; D]]) -> Vec<f64> {
    let columns = D * (3 + 2 * D);
    let mut numbers = vec![0.0; columns * ends.len()];
    for (joint, of_joint) in ends.iter().enumerate() {
        let of_end = |of: &EndMemory<D>| {
            of.damages.into_iter().chain([of.stiffness]).chain(of.origin).chain(of.rubbed)
        };
        for (column, number) in of_joint.iter().flat_map(of_end).enumerate() {
            numbers[column * ends.len() + joint] = number;
        }
    }
    numbers
}

/// Computes the tractions of ends of joints with a common law, in two or three dimensions: the numbers of
/// each end in the order of `JointEnd` in the kernels, 9 + 5 D of them.
///
/// # Errors
/// [`GpuError::OutOfMemory`], [`GpuError::Driver`].
///
/// # Panics
/// If the numbers are not those of whole ends.
pub fn soften_ends<const D: usize>(device: &impl Device, numbers: &mut [f64]) -> Result<(), GpuError> {
    let kernel = if D == 2 { Kernel::SoftenEnds2 } else { Kernel::SoftenEnds3 };
    change(device, kernel, 9 + 5 * D, numbers)
}

/// The exponential function of numbers from -3.8 to 0, with the bits of `libm`.
///
/// # Errors
/// [`GpuError::OutOfMemory`], [`GpuError::Driver`].
pub fn exponentials(device: &impl Device, numbers: &mut [f64]) -> Result<(), GpuError> {
    change(device, Kernel::Exponentials, 1, numbers)
}

/// Lets a kernel change records of some numbers each.
fn change(device: &impl Device, kernel: Kernel, of_each: usize, numbers: &mut [f64]) -> Result<(), GpuError> {
    let mut array = Array::new();
    let count = numbers.len() / of_each;
    assert_eq!(count * of_each, numbers.len(), "whole records");
    let arguments = NumberArguments { numbers: array.write(device, numbers)?, count: count as u64 };
    launch(device, kernel, count, &arguments)?;
    array.read(device, 0, numbers)
}
