//! Laws of elements on a device.

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{DeformArguments, Kernel};
use crate::primitives::launch;

/// Elements by the numbers that a kernel reads and writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementKind {
    /// 32 numbers of a state, 19 of the results.
    Triangle,
    /// 58 numbers of a state, 36 of the results.
    Tetrahedron,
}

impl ElementKind {
    /// Numbers of the state of an element, and of its results.
    pub fn numbers(self) -> [usize; 2] {
        match self {
            Self::Triangle => [32, 19],
            Self::Tetrahedron => [58, 36],
        }
    }

    fn kernel(self) -> Kernel {
        match self {
            Self::Triangle => Kernel::DeformTriangles,
            Self::Tetrahedron => Kernel::DeformTetrahedra,
        }
    }
}

/// Deforms elements with the neo-Hookean law of fdem-simulation, with initial stress, viscosity and bedding
/// if they are asked for: the numbers of each element in the order of `ElementState` there, to those in the
/// order of `ElementForces`. Numbers that only viscosity or bedding has are 0 without it.
///
/// # Errors
/// [`GpuError::OutOfMemory`], [`GpuError::Driver`].
///
/// # Panics
/// If the numbers are not those of whole elements.
pub fn deform(
    device: &impl Device,
    kind: ElementKind,
    states: &[f64],
    [has_initial, is_viscous, is_bedded]: [bool; 3],
) -> Result<Vec<f64>, GpuError> {
    let [state, results] = kind.numbers();
    let count = states.len() / state;
    assert_eq!(count * state, states.len(), "whole elements");
    let (mut given, mut found) = (Array::new(), Array::new());
    let mut forces = vec![0.0; count * results];
    let arguments = DeformArguments {
        states: given.write(device, states)?,
        forces: found.write(device, &forces)?,
        count: count as u64,
        has_initial: u32::from(has_initial),
        is_viscous: u32::from(is_viscous),
        is_bedded: u32::from(is_bedded),
        unused: 0,
    };
    launch(device, kind.kernel(), count, &arguments)?;
    found.read(device, 0, &mut forces)?;
    Ok(forces)
}
