//! Values of some nodes, elements and joints that the host reads from a device.

use crate::accelerator::{Accelerator, ElementValues, FromDevice, JointMemories};
use crate::machine::{Columns, Wanted};
use crate::simplex::Simplex;
use crate::vector::Point;

/// The present values of wanted nodes, elements and joints.
pub(super) struct Values<const D: usize, const N: usize> {
    positions: Vec<Point<D>>,
    nodes: [Vec<Point<D>>; 2],
    elements: ElementValues<D, N>,
    joints: JointMemories<D>,
}

impl<const D: usize, const N: usize> Values<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Reads them.
    pub(super) fn read(device: &mut dyn Accelerator<D, N>, wanted: &Wanted) -> FromDevice<Self> {
        let Wanted { positions, nodes, elements, joints } = wanted;
        let mut values = Self {
            positions: Vec::new(),
            nodes: Default::default(),
            elements: ElementValues::default(),
            joints: JointMemories::default(),
        };
        if !positions.is_empty() {
            values.positions = device.read_positions(positions)?;
        }
        if !nodes.is_empty() {
            values.nodes = device.read_nodes(nodes)?;
        }
        if !elements.is_empty() {
            values.elements = device.read_elements(elements)?;
        }
        if !joints.is_empty() {
            values.joints = device.read_joints(joints)?;
        }
        Ok(values)
    }

    /// Puts them into the columns of the host.
    pub(super) fn put_into(self, wanted: &Wanted, columns: &mut Columns<D, N>) {
        columns.solid.take_positions(&wanted.positions, &self.positions);
        columns.solid.take_nodes(&wanted.nodes, &self.nodes);
        columns.solid.take_elements(&wanted.elements, &self.elements);
        columns.solid.take_moved(&wanted.elements, &self.elements.moved);
        columns.joints.take_some(&wanted.joints, self.joints);
    }
}
