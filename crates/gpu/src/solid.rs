//! Bodies of a simulation on a device: the elements and the nodes of a step.
//!
//! So far these are bodies that nothing touches, breaks or holds: the elastic part of a step of
//! fdem-simulation, with its bits.

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Kernel, SolidElementArguments, SolidNodeArguments};
use crate::primitives::launch;

/// The columns of bodies with elements of N corners in D dimensions: a value of each node, element or
/// corner, without gaps.
#[derive(Clone, Debug, Default)]
pub struct SolidColumns<const D: usize, const N: usize> {
    /// Positions of the nodes, m, and their velocities half a step before, m/s.
    pub positions: Vec<[f64; D]>,
    /// See `positions`.
    pub velocities: Vec<[f64; D]>,
    /// kg.
    pub masses: Vec<f64>,
    /// Nodes of each element.
    pub elements: Vec<[u32; N]>,
    /// Inverse of the matrix whose columns are the edges from corner 0, for each element, 1/m.
    pub gradients: Vec<[[f64; D]; D]>,
    /// Volumes of the undeformed elements, m³.
    pub volumes: Vec<f64>,
    /// Material of each element.
    pub materials: Vec<u32>,
    /// Moduli of shear and bulk of each material, Pa.
    pub moduli: Vec<[f64; 2]>,
    /// Viscosity of each element, Pa s; empty without viscosity.
    pub viscosities: Vec<f64>,
}

/// Time step and forces besides those of the elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidStep<const D: usize> {
    /// s.
    pub step: f64,
    /// m/s².
    pub gravity: [f64; D],
    /// Force against the motion of a node, as a share of the force on it.
    pub local_damping: f64,
}

/// Bodies on a device.
pub struct DeviceSolid<'d, V: Device, const D: usize, const N: usize> {
    device: &'d V,
    nodes: usize,
    elements: usize,
    positions: Array<V::Memory, f64>,
    velocities: Array<V::Memory, f64>,
    masses: Array<V::Memory, f64>,
    corners: Array<V::Memory, u32>,
    gradients: Array<V::Memory, f64>,
    volumes: Array<V::Memory, f64>,
    materials: Array<V::Memory, u32>,
    moduli: Array<V::Memory, f64>,
    viscosities: Array<V::Memory, f64>,
    viscous: Array<V::Memory, f64>,
    forces: Array<V::Memory, f64>,
    inverted: Array<V::Memory, u32>,
    starts: Array<V::Memory, u32>,
    of_nodes: Array<V::Memory, u32>,
}

impl<'d, V: Device, const D: usize, const N: usize> DeviceSolid<'d, V, D, N> {
    /// Copies bodies to a device.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for other elements than triangles in the plane and tetrahedra in space;
    /// [`GpuError::OutOfMemory`]; [`GpuError::Driver`].
    ///
    /// # Panics
    /// If the lengths of the columns do not agree, or an element has a node that there is not.
    pub fn new(device: &'d V, columns: &SolidColumns<D, N>) -> Result<Self, GpuError> {
        if (D != 2 && D != 3) || N != D + 1 {
            return Err(GpuError::Unsupported { what: "elements but triangles and tetrahedra" });
        }
        let (nodes, elements) = (columns.positions.len(), columns.elements.len());
        assert!([columns.velocities.len(), columns.masses.len()] == [nodes; 2], "a value of each node");
        let of_elements = [columns.gradients.len(), columns.volumes.len(), columns.materials.len()];
        assert!(of_elements == [elements; 3], "a value of each element");
        let viscous = columns.viscosities.len();
        assert!(viscous == 0 || viscous == elements, "a viscosity of each element, or none");
        assert!(columns.materials.iter().all(|&of| (of as usize) < columns.moduli.len()), "a material");
        let (starts, of_nodes) = corners_of_nodes(&columns.elements, nodes);
        let mut solid = Self {
            device,
            nodes,
            elements,
            positions: Array::new(),
            velocities: Array::new(),
            masses: Array::new(),
            corners: Array::new(),
            gradients: Array::new(),
            volumes: Array::new(),
            materials: Array::new(),
            moduli: Array::new(),
            viscosities: Array::new(),
            viscous: Array::new(),
            forces: Array::new(),
            inverted: Array::new(),
            starts: Array::new(),
            of_nodes: Array::new(),
        };
        solid.positions.write(device, columns.positions.as_flattened())?;
        solid.velocities.write(device, columns.velocities.as_flattened())?;
        solid.masses.write(device, &columns.masses)?;
        solid.corners.write(device, columns.elements.as_flattened())?;
        solid.gradients.write(device, columns.gradients.as_flattened().as_flattened())?;
        solid.volumes.write(device, &columns.volumes)?;
        solid.materials.write(device, &columns.materials)?;
        solid.moduli.write(device, columns.moduli.as_flattened())?;
        if viscous > 0 {
            solid.viscosities.write(device, &columns.viscosities)?;
            solid.viscous.write(device, &vec![0.0; D * D * elements])?;
        }
        solid.forces.resize(device, D * N * elements)?;
        solid.inverted.write(device, &[0])?;
        solid.starts.write(device, &starts)?;
        solid.of_nodes.write(device, &of_nodes)?;
        Ok(solid)
    }

    /// Does some steps. Returns whether all elements still have a volume.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    pub fn advance(&mut self, steps: u64, of: SolidStep<D>) -> Result<bool, GpuError> {
        let device = self.device;
        let elements = SolidElementArguments {
            positions: self.positions.address(device),
            velocities: self.velocities.address(device),
            corners: self.corners.address(device),
            gradients: self.gradients.address(device),
            volumes: self.volumes.address(device),
            materials: self.materials.address(device),
            moduli: self.moduli.address(device),
            viscosities: self.viscosities.address(device),
            viscous: self.viscous.address(device),
            forces: self.forces.address(device),
            inverted: self.inverted.address(device),
            count: self.elements as u64,
        };
        let mut gravity = [0.0; 3];
        gravity[..D].copy_from_slice(&of.gravity);
        let nodes = SolidNodeArguments {
            positions: elements.positions,
            velocities: elements.velocities,
            masses: self.masses.address(device),
            starts: self.starts.address(device),
            corners: self.of_nodes.address(device),
            forces: elements.forces,
            gravity,
            step: of.step,
            local_damping: of.local_damping,
            count: self.nodes as u64,
        };
        let [deform, advance] = match D {
            2 => [Kernel::SolidDeform2, Kernel::SolidMove2],
            _ => [Kernel::SolidDeform3, Kernel::SolidMove3],
        };
        for _ in 0..steps {
            launch(device, deform, self.elements, &elements)?;
            launch(device, advance, self.nodes, &nodes)?;
        }
        let mut inverted = [0];
        self.inverted.read(device, 0, &mut inverted)?;
        Ok(inverted == [0])
    }

    /// Positions of the nodes, m, and their velocities half a step before, m/s.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    pub fn motion(&self) -> Result<[Vec<[f64; D]>; 2], GpuError> {
        let read = |column: &Array<V::Memory, f64>| {
            let mut values = vec![[0.0; D]; self.nodes];
            column.read(self.device, 0, values.as_flattened_mut()).map(|()| values)
        };
        Ok([read(&self.positions)?, read(&self.velocities)?])
    }
}

/// The corners of each node, ascending: where those of each begin, and the corners.
fn corners_of_nodes<const N: usize>(elements: &[[u32; N]], nodes: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; nodes + 1];
    for &node in elements.as_flattened() {
        starts[node as usize + 1] += 1;
    }
    for node in 0..nodes {
        starts[node + 1] += starts[node];
    }
    let (mut next, mut corners) = (starts.clone(), vec![0; N * elements.len()]);
    for (corner, &node) in (0..).zip(elements.as_flattened()) {
        corners[next[node as usize] as usize] = corner;
        next[node as usize] += 1;
    }
    (starts, corners)
}
