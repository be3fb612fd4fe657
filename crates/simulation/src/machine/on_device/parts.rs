//! Phases of the host on a device's run that read and change few nodes, elements and joints: it reads these,
//! and the device takes their changes over as patches.

use std::sync::PoisonError;

use crate::accelerator::{Accelerator, FromDevice};
use crate::joints::Pulling;
use crate::lists::once_each;
use crate::machine::on_device::OnDevice;
use crate::machine::on_device::values::Values;
use crate::machine::{Columns, Wanted};
use crate::model::Model;
use crate::simplex::Simplex;
use crate::topology::Topology;

impl<const D: usize, const N: usize> OnDevice<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Calls the device, between two of its phases. `None` once it has failed.
    pub(super) fn call<T>(
        &mut self,
        work: impl FnOnce(&mut dyn Accelerator<D, N>) -> FromDevice<T>,
    ) -> Option<T> {
        if self.failure().is_some() {
            return None;
        }
        let device = self.device.get_mut().unwrap_or_else(PoisonError::into_inner);
        match work(&mut **device) {
            Ok(found) => Some(found),
            Err(error) => {
                self.fail(&error.to_string());
                None
            }
        }
    }

    /// Reads the present values of some nodes, elements and joints, unless the columns of the host are up to
    /// date. Returns nothing if the device has failed.
    fn refresh(&mut self, wanted: &Wanted) -> Option<()> {
        if self.host.get().is_some() {
            // The device alone knows how far elements are from their noted states.
            let values = self.call(|device| device.read_elements(&wanted.elements))?;
            self.known().solid.take_moved(&wanted.elements, &values.moved);
            return Some(());
        }
        self.call(|device| Values::read(device, wanted))?.put_into(wanted, self.known());
        Some(())
    }

    /// Hands the noted states of some elements over.
    pub(super) fn note(&mut self, elements: &[u32]) -> Option<()> {
        let states = self.known().solid.noted(elements);
        if states.is_empty() {
            return Some(());
        }
        self.call(|device| device.note(elements, &states))
    }

    /// Computes joints, ascending, one by one at a time, s.
    pub(super) fn pull_left(&mut self, joints: &[u32], step: f64, time: f64) -> Option<Pulling> {
        let [nodes, elements] = self.known().joints.beside(joints);
        let wanted = Wanted { nodes, elements, joints: joints.to_vec(), ..Wanted::default() };
        self.refresh(&wanted)?;
        // Joints carry a part of the forces between their elements.
        self.refresh_couples();
        self.couples_changed = true;
        let Columns { solid, joints, .. } = self.known();
        let pulling = joints.pull_some(&wanted.joints, solid, step, time);
        let patch = joints.patch(wanted.joints, Vec::new(), solid.thickness);
        self.call(|device| device.patch_joints(&patch))?;
        Some(pulling)
    }

    /// The facets that fail: [`Joints::failing`](crate::joints::Joints::failing).
    pub(super) fn find_failing(
        &mut self,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        loaded: Vec<u32>,
    ) -> Option<Vec<u32>> {
        let (team, mut lists) = (self.team.clone(), std::mem::take(&mut self.lists));
        let mut pressed = self.touching();
        pressed.extend(loaded);
        let awake = self.call(|device| device.awake())?;
        let Columns { solid, joints, .. } = self.known();
        let due = joints.due(&mut lists, awake, pressed, topology, &team);
        let mut failing = Vec::new();
        if let Some(due) = due {
            let nodes = solid.nodes_of_all(&due.around);
            let joined = joints.of_elements(&due.around, topology);
            let elements = due.around.clone();
            self.refresh(&Wanted { nodes, elements, joints: joined, ..Wanted::default() })?;
            let Columns { solid, joints, .. } = self.known();
            let [found, noted] = joints.failing_among(due, &mut lists, solid, model, topology, &team);
            self.note(&noted)?;
            failing = found;
        }
        self.lists = lists;
        Some(failing)
    }

    /// Changes the columns at the vertices of some facets.
    pub(super) fn change_around(
        &mut self,
        facets: &[u32],
        topology: &Topology<D, N>,
        change: &mut dyn FnMut(&mut Columns<D, N>),
    ) -> Option<()> {
        let of_facets = facets.iter().flat_map(|&facet| topology.facets[facet as usize].corners[0]);
        let mut vertices: Vec<u32> = of_facets.map(|corner| topology.vertices[corner as usize]).collect();
        once_each(&mut vertices);
        let corners: Vec<u32> =
            vertices.iter().flat_map(|&vertex| topology.corners_of(vertex)).copied().collect();
        let mut elements: Vec<u32> = corners.iter().map(|corner| corner / N as u32).collect();
        once_each(&mut elements);
        let Columns { solid, joints, .. } = self.known();
        let (nodes, joined) = (solid.nodes_of_all(&elements), joints.of_elements(&elements, topology));
        let before = solid.node_count();
        let around = elements.clone();
        self.refresh(&Wanted { nodes, elements: around, joints: joined, ..Wanted::default() })?;
        change(self.known());
        if self.changed.all {
            // The device takes all columns over before its next phase.
            return Some(());
        }
        let holds = std::mem::take(&mut self.holds);
        let mut held = std::mem::take(&mut self.held);
        let Columns { solid, joints, .. } = self.known();
        let patch = solid.patch(&corners, before, &holds, &mut held);
        let joined = joints.of_elements(&elements, topology);
        let of_joints = joints.patch(joined, corners, solid.thickness);
        (self.holds, self.held) = (holds, held);
        self.call(|device| {
            device.patch(&patch)?;
            device.patch_joints(&of_joints)
        })?;
        self.note(&elements)
    }
}
