//! Rigid bodies on a device's run: the host moves them, and the device has their nodes.

use crate::machine::on_device::OnDevice;
use crate::motion::nodes::Motion;
use crate::motion::{MotionSums, rigid};
use crate::simplex::Simplex;
use crate::sum::Sum;

impl<const D: usize, const N: usize> OnDevice<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Moves all rigid bodies, and hands their nodes over. Returns nothing if the device has failed.
    pub(super) fn move_rigid(
        &mut self,
        motion: &Motion<'_, D, N>,
        sums: &mut MotionSums<Sum, D>,
    ) -> Option<()> {
        let bodies = &self.known().solid.rigid;
        let elements: Vec<u32> = bodies.all.iter().flat_map(|body| &body.elements).copied().collect();
        let nodes = bodies.node_numbers();
        if self.host.get().is_none() {
            // The forces of loads. The host has placed the nodes.
            let values = self.call(|device| device.read_elements(&elements))?;
            self.known().solid.take_elements(&elements, &values);
        }
        let team = self.team.clone();
        let solid = &mut self.known().solid;
        rigid::advance(solid, motion, &team, sums);
        let moved = solid.motion_of(&nodes);
        self.call(|device| device.write_nodes(&nodes, &moved))
    }
}
