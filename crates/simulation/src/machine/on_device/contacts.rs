//! Contacts of a run on a device: the host finds couples, and the device computes their forces.
//!
//! A search gets the positions of the elements that can touch. Where it chooses couples anew, the host has
//! them, and the device takes them over once any of them is near. From then on their histories are on the
//! device, until the host chooses again or anything asks for its columns.

use crate::contacts::Touching;
use crate::error::Stop;
use crate::machine::Columns;
use crate::machine::on_device::{OnDevice, sum_of};
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::topology::Topology;

impl<const D: usize, const N: usize> OnDevice<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Finds the couples of elements that may touch. The device sends the positions of elements that can
    /// touch, and the state of the couples where these change; no other columns.
    pub(super) fn search(&mut self, topology: &Topology<D, N>) -> Result<(), Stop> {
        if self.known().contacts.is_detection_due() {
            let team = self.team.clone();
            let Columns { joints, contacts, .. } = self.known();
            contacts.watch_bare(joints, topology);
            self.refresh_watched();
            let Columns { solid, joints, contacts } = self.known();
            let chooses = contacts.look(solid, joints, topology, &team)?;
            if chooses || contacts.is_renewed() {
                self.refresh_couples();
                self.couples_changed = true;
                let Columns { solid, joints, contacts } = self.known();
                contacts.renew(solid, joints, topology, chooses, &team);
            }
        }
        self.failure().map_or(Ok(()), Err)
    }

    /// Updates the positions of the elements that the search looks at. All other columns stay as they are.
    fn refresh_watched(&mut self) {
        if self.host.get().is_some() {
            return;
        }
        let Columns { solid, contacts, .. } = self.known();
        let nodes = solid.nodes_of_all(contacts.looked_at());
        if let Some(positions) = self.call(|device| device.read_positions(&nodes)) {
            self.known().solid.take_positions(&nodes, &positions);
        }
    }

    /// The elements that touch others, with repetitions.
    pub(super) fn touching(&mut self) -> Vec<u32> {
        let team = self.team.clone();
        let has_couples = self.known().contacts.has_couples();
        if self.host.get().is_some() || self.couples_changed || !has_couples {
            return self.known().contacts.touching(&team);
        }
        let touches = self.call(|device| device.read_touching()).unwrap_or_default();
        self.known().contacts.elements_where(&touches)
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
