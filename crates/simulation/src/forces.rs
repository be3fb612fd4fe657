//! Forces between elements and on nodes for results.

use std::collections::BTreeMap;

use crate::contacts::Contacts;
use crate::joints::Joints;
use crate::simplex::Simplex;
use crate::simulation::Simulation;
use crate::solid::Solid;
use crate::topology::Topology;
use crate::vector::{Point, add, length, plus};

/// Forces at the beginning of the last step. There are none before the first step of a run, nor before the first step after a resume.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces<const D: usize = 2> {
    /// Forces of couples of elements that press each other, ascending by their elements.
    pub contacts: Vec<ContactForce<D>>,
    /// Force of all boundaries on each node, N, in the order of the nodes of a [`Snapshot`](crate::Snapshot).
    pub reactions: Vec<[f64; D]>,
}

/// Contact force between two elements.
///
/// A broken joint that is closed presses its two elements until they have slid far enough for the contact to take over. Its force is included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce<const D: usize = 2> {
    /// Numbers of the two elements, the lower first.
    pub elements: [u32; 2],
    /// Point where the force acts, m.
    pub point: [f64; D],
    /// Normal force on the first element, N; the second element has the opposite.
    pub normal: [f64; D],
    /// Tangential force on the first element, N: friction.
    pub tangential: [f64; D],
}

impl<const D: usize> ContactForce<D> {
    /// Force on the first element, N.
    pub fn force(&self) -> [f64; D] {
        plus(self.normal, self.tangential)
    }

    /// Merges the forces of two contacts of the same elements. The point is the mean of their points, weighted by the forces.
    fn merged(self, other: Self) -> Self {
        let [a, b] = [self.force(), other.force()].map(length);
        Self {
            elements: self.elements,
            point: std::array::from_fn(|axis| (a * self.point[axis] + b * other.point[axis]) / (a + b)),
            normal: plus(self.normal, other.normal),
            tangential: plus(self.tangential, other.tangential),
        }
    }
}

/// Forces of contacts and broken joints, one for each couple of elements.
pub(crate) fn contact_forces<const D: usize, const N: usize>(
    contacts: &Contacts<D, N>,
    joints: &Joints<D>,
    solid: &Solid<D, N>,
    topology: &Topology<D, N>,
) -> Vec<ContactForce<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut all = contacts.forces(solid);
    all.extend(joints.pressing(solid, topology));
    all.retain(|contact| contact.force() != [0.0; D]);
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

/// Force of all boundaries on each node, N, in the order of results. `held`: forces on the nodes that boundaries move.
pub(crate) fn reactions<const D: usize, const N: usize>(run: &Simulation<D, N>) -> Vec<[f64; D]>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    placed_reactions(run, &mut own_reactions(run).into_iter())
}

/// Force of all boundaries on each node of this rank on which one acts, N, by the code of the first corner of the node.
pub(crate) fn own_reactions<const D: usize, const N: usize>(run: &Simulation<D, N>) -> Vec<(u32, Point<D>)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let applied = run.loads.applied(&run.solid);
    let applied = applied.map(|([_, corner], force)| (run.solid.corners.node_at(corner), force));
    let mut forces = BTreeMap::new();
    for (node, force) in run.held.iter().copied().chain(applied) {
        add(forces.entry(node).or_insert([0.0; D]), force, 1.0);
    }
    let code = |node: u32| run.topology.code_of_corner(run.solid.corners.of(node as usize)[0]);
    forces.into_iter().map(|(node, force)| (code(node), force)).collect()
}

/// The same forces of a whole run, in the order of results.
pub(crate) fn placed_reactions<const D: usize, const N: usize>(
    run: &Simulation<D, N>,
    forces: &mut dyn Iterator<Item = (u32, Point<D>)>,
) -> Vec<[f64; D]>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut all = vec![[0.0; D]; run.solid.nodes.len()];
    for (corner, force) in forces {
        all[run.solid.corners.node_at(corner) as usize] = force;
    }
    run.solid.order(&run.topology).into_iter().map(|node| all[node as usize]).collect()
}
