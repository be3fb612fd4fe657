//! Contacts of a run on a device: the host finds couples, and the device computes their forces.
//!
//! After a search the host has the couples, and the device takes them over once any of them is near. From
//! then on their histories are on the device, until the host searches again or anything asks for its columns.

use crate::contacts::Touching;
use crate::error::Stop;
use crate::machine::Columns;
use crate::machine::on_device::{OnDevice, sum_of};
use crate::simplex::Simplex;
use crate::solid::Node;
use crate::sum::Sum;
use crate::topology::Topology;

impl<const D: usize, const N: usize> OnDevice<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Finds the couples of elements that may touch. The device sends the nodes and the state of the couples,
    /// and no other columns.
    pub(super) fn search(&mut self, topology: &Topology<D, N>) -> Result<(), Stop> {
        if self.known().contacts.is_detection_due() {
            self.refresh_nodes();
            let team = self.team.clone();
            self.couples_changed = true;
            let Columns { solid, joints, contacts } = self.known();
            contacts.detect(solid, joints, topology, &team)?;
        }
        self.failure().map_or(Ok(()), Err)
    }

    /// Updates the nodes and the couples of the host. All other columns stay as they are.
    fn refresh_nodes(&mut self) {
        if self.host.get().is_some() {
            return;
        }
        self.refresh_couples();
        let nodes: Vec<u32> = (0..self.known().solid.node_count() as u32).collect();
        let Some([positions, velocities]) = self.call(|device| device.read_nodes(&nodes)) else { return };
        let solid = &mut self.known().solid;
        for (node, (position, velocity)) in positions.into_iter().zip(velocities).enumerate() {
            solid.set_node(node, Node { position, velocity });
        }
    }

    /// Updates the couples of the host.
    pub(super) fn refresh_couples(&mut self) {
        if self.host.get().is_some() || self.couples_changed || !self.known().contacts.has_couples() {
            return;
        }
        if let Some(couples) = self.call(|device| device.read_couples()) {
            self.known().contacts.take_flat(&couples);
        }
    }

    /// Computes the forces of all couples on the device, and adds them to the forces on corners. `step`: time
    /// step, s; `energies`: whether to compute the energy of their potentials.
    pub(super) fn press(&mut self, topology: &Topology<D, N>, step: f64, energies: bool) -> Touching {
        let mut touching = Touching { energy: energies.then(Sum::default), ..Touching::default() };
        let changed = self.couples_changed;
        let Columns { solid, joints, contacts } = self.known();
        // Without a change, the device knows which couples are apart.
        if !contacts.has_couples() || (changed && !contacts.any_near()) {
            return touching;
        }
        let press = contacts.flat_press(step, solid.grains, energies);
        let couples = changed.then(|| contacts.flat(solid, joints, topology));
        let pressed = self.compute(|device| {
            if let Some((columns, states)) = &couples {
                device.load_couples(columns, states)?;
            }
            device.press(&press).map(Some)
        });
        self.couples_changed = false;
        let Some(pressed) = pressed else { return touching };
        let [friction, damping, handed_over, relaxed] = pressed.works.each_ref().map(sum_of);
        touching.friction = friction;
        touching.damping = damping;
        touching.handed_over = handed_over;
        touching.relaxed = relaxed;
        touching.energy = pressed.energy.as_ref().map(sum_of);
        touching.count = sum_of(&pressed.touching).value() as usize;
        touching.deep = pressed.deep.map(|place| self.known().contacts.elements_of(place));
        touching
    }
}
