//! Forces between elements and on nodes for results.

use crate::contacts::Contacts;
use crate::joints::Joints;
use crate::loads::Loads;
use crate::solid::Solid;
use crate::topology::Topology;
use crate::vector::Point;

/// Forces at the beginning of the last step. There are none before the first step of a run, nor before the first step after a resume.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// Forces of couples of elements that press each other, ascending by their elements.
    pub contacts: Vec<ContactForce>,
    /// Force of all boundaries on each node, N.
    pub reactions: Vec<[f64; 2]>,
}

/// Contact force between two elements.
///
/// A broken joint that is closed presses its two elements until they have slid far enough for the contact to take over. Its force is included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Numbers of the two elements, the lower first.
    pub elements: [u32; 2],
    /// Point where the force acts, m.
    pub point: [f64; 2],
    /// Normal force on the first element, N; the second element has the opposite.
    pub normal: [f64; 2],
    /// Tangential force on the first element, N: friction.
    pub tangential: [f64; 2],
}

impl ContactForce {
    /// Force on the first element, N.
    pub fn force(&self) -> [f64; 2] {
        [self.normal[0] + self.tangential[0], self.normal[1] + self.tangential[1]]
    }

    /// Merges the forces of two contacts of the same elements. The point is the mean of their points, weighted by the forces.
    fn merged(self, other: Self) -> Self {
        let [a, b] = [self.force(), other.force()].map(|[x, y]| x.hypot(y));
        let sum = |one: Point, two: Point| [one[0] + two[0], one[1] + two[1]];
        Self {
            elements: self.elements,
            point: [0, 1].map(|axis| (a * self.point[axis] + b * other.point[axis]) / (a + b)),
            normal: sum(self.normal, other.normal),
            tangential: sum(self.tangential, other.tangential),
        }
    }
}

/// Forces of contacts and broken joints, one for each couple of elements.
pub(crate) fn contact_forces(
    contacts: &Contacts,
    joints: &Joints,
    solid: &Solid,
    topology: &Topology,
) -> Vec<ContactForce> {
    let mut all = contacts.forces(solid);
    all.extend(joints.pressing(solid, topology));
    all.retain(|contact| contact.force() != [0.0; 2]);
    // A stable sort: contacts stay before joints.
    all.sort_by_key(|contact| contact.elements);
    all.dedup_by(|next, kept| {
        let same = next.elements == kept.elements;
        if same {
            *kept = kept.merged(*next);
        }
        same
    });
    for contact in &mut all {
        contact.point = solid.place(contact.point);
    }
    all
}

/// Force of all boundaries on each node, N. `held`: forces on the nodes that boundaries move.
pub(crate) fn reactions(solid: &Solid, loads: &Loads, held: &[(u32, Point)]) -> Vec<[f64; 2]> {
    let mut forces = vec![[0.0; 2]; solid.nodes.len()];
    let applied = loads.applied().map(|(corner, force)| (solid.corners.node_at(corner), force));
    for (node, force) in held.iter().copied().chain(applied) {
        let sum: &mut Point = &mut forces[node as usize];
        sum[0] += force[0];
        sum[1] += force[1];
    }
    forces
}
