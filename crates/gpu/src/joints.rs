//! Joints of a simulation on a device.

use fdem_simulation::{EndMemory, JointColumns, JointMemories};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{JointArguments, Kernel, NumberArguments, THREADS};
use crate::primitives::launch;

/// Bits of the marks of a joint in the kernels, beside its kind.
const COUNTED: u32 = 4;
const BROKEN: u32 = 8;
const OPEN: u32 = 16;

/// The joints of a run.
pub(crate) struct DeviceJoints<M, const D: usize> {
    pub(crate) count: usize,
    nodes: Array<M, u32>,
    marks: Array<M, u32>,
    laws: Array<M, f64>,
    memories: Array<M, f64>,
    pub(crate) forces: Array<M, f64>,
    /// Ends of joints at each corner.
    pub(crate) at_corner: Array<M, u32>,
    /// Joints that the host is to compute, and whether there are any.
    left: Array<M, u32>,
    any_left: Array<M, u32>,
    sums: Array<M, f64>,
}

impl<M, const D: usize> DeviceJoints<M, D> {
    /// Numbers of the memory of an end.
    const MEMORY: usize = 3 + 2 * D;

    pub(crate) const fn new() -> Self {
        Self {
            count: 0,
            nodes: Array::new(),
            marks: Array::new(),
            laws: Array::new(),
            memories: Array::new(),
            forces: Array::new(),
            at_corner: Array::new(),
            left: Array::new(),
            any_left: Array::new(),
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
        self.count = joints.kinds.len();
        if self.count == 0 {
            *self = Self::new();
            return Ok(());
        }
        self.nodes.write(device, joints.nodes.as_flattened().as_flattened())?;
        let marks = |k: usize| {
            let flag = |set: bool, bit: u32| if set { bit } else { 0 };
            let open = joints.open[k].iter().enumerate().map(|(end, open)| flag(*open, OPEN << end));
            let of_joint = flag(joints.counted[k], COUNTED) | flag(joints.broken[k], BROKEN);
            joints.kinds[k] as u32 | of_joint | open.fold(0, |all, bit| all | bit)
        };
        self.marks.write(device, &(0..self.count).map(marks).collect::<Vec<_>>())?;
        let laws: Vec<f64> = (0..9 + D)
            .flat_map(|number| {
                joints.laws.iter().map(move |law| match number {
                    0 => law.penalty,
                    1 => law.tensile,
                    2 => law.cohesion,
                    3 => law.friction,
                    4 | 5 => law.critical[number - 4],
                    6 => law.share,
                    7 => law.length,
                    8 => law.faded,
                    axis => law.normal[axis - 9],
                })
            })
            .collect();
        self.laws.write(device, &laws)?;
        self.at_corner.write(device, joints.at_corner.as_flattened())?;
        self.left.resize(device, self.count)?;
        self.sums.resize(device, 2 * self.blocks())?;
        Ok(())
    }

    /// Takes the state of the joints over.
    pub(crate) fn write(
        &mut self,
        device: &impl Device<Memory = M>,
        joints: &JointMemories<D>,
    ) -> Result<(), GpuError> {
        if self.count == 0 {
            return Ok(());
        }
        let mut memories = vec![0.0; D * Self::MEMORY * self.count];
        for (joint, ends) in joints.ends.iter().enumerate() {
            for (end, of) in ends.iter().enumerate() {
                let numbers = of.damages.into_iter().chain([of.stiffness]).chain(of.origin).chain(of.rubbed);
                for (k, number) in numbers.enumerate() {
                    memories[(end * Self::MEMORY + k) * self.count + joint] = number;
                }
            }
        }
        self.memories.write(device, &memories)?;
        self.forces.write(device, joints.forces.as_flattened().as_flattened())?;
        Ok(())
    }

    /// The state of the joints.
    pub(crate) fn read(&self, device: &impl Device<Memory = M>) -> Result<JointMemories<D>, GpuError> {
        let mut joints = JointMemories::default();
        if self.count == 0 {
            return Ok(joints);
        }
        let mut memories = vec![0.0; D * Self::MEMORY * self.count];
        self.memories.read(device, 0, &mut memories)?;
        let ends = |joint: usize| {
            std::array::from_fn(|end| {
                let number = |k: usize| memories[(end * Self::MEMORY + k) * self.count + joint];
                EndMemory {
                    damages: [number(0), number(1)],
                    stiffness: number(2),
                    origin: std::array::from_fn(|axis| number(3 + axis)),
                    rubbed: std::array::from_fn(|axis| number(3 + D + axis)),
                }
            })
        };
        joints.ends = (0..self.count).map(ends).collect();
        joints.forces = vec![[[0.0; D]; D]; self.count];
        self.forces.read(device, 0, joints.forces.as_flattened_mut().as_flattened_mut())?;
        Ok(joints)
    }

    /// Computes the joints from the positions and velocities of the nodes. Returns where the parts of their
    /// work are, two rows of a number for each block.
    pub(crate) fn pull(
        &mut self,
        device: &impl Device<Memory = M>,
        [positions, velocities]: [u64; 2],
        step: f64,
        grains: [f64; 2],
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
            sums: self.sums.address(device),
            grains,
            step,
            count: self.count as u64,
            blocks: self.blocks() as u64,
        };
        let kernel = if D == 2 { Kernel::PullJoints2 } else { Kernel::PullJoints3 };
        launch(device, kernel, self.count, &arguments)?;
        Ok(arguments.sums)
    }

    /// The joints that the host is to compute after the last pass.
    pub(crate) fn left(&self, device: &impl Device<Memory = M>) -> Result<Vec<u32>, GpuError> {
        let mut any = [0];
        self.any_left.read(device, 0, &mut any)?;
        if any == [0] {
            return Ok(Vec::new());
        }
        let mut marks = vec![0; self.count];
        self.left.read(device, 0, &mut marks)?;
        Ok((0..).zip(&marks).filter(|(_, mark)| **mark != 0).map(|(joint, _)| joint).collect())
    }
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
