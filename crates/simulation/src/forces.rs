//! Forces between elements and on nodes for results.

use std::collections::BTreeMap;

use crate::ranks::wire::wire;
use crate::simplex::Simplex;
use crate::simulation::Simulation;
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

/// The forces of a step that a rank counts. Elements have their numbers in the whole mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnForces<const D: usize> {
    contacts: Vec<ContactForce<D>>,
    /// Forces of broken joints that are closed.
    joints: Vec<ContactForce<D>>,
    /// Force of all boundaries on each node on which one acts, N, by the code of the first corner of the node.
    reactions: Vec<(u32, Point<D>)>,
}

wire!([const D: usize] OwnForces<D> { contacts, joints, reactions });
wire!([const D: usize] ContactForce<D> { elements, point, normal, tangential });

impl<const D: usize> OwnForces<D> {
    /// The forces that this rank counts.
    pub(crate) fn of<const N: usize>(run: &Simulation<D, N>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let numbered = |force: ContactForce<D>| ContactForce {
            elements: force.elements.map(|element| run.topology.number(element)),
            ..force
        };
        let counted = |force: &ContactForce<D>| run.solid.share.element(force.elements[0]);
        let contacts = run.contacts.forces(&run.solid).into_iter().filter(counted).map(numbered);
        let joints = run.joints.pressing(&run.solid, &run.topology).into_iter().map(numbered);
        let applied = run.loads.applied(&run.solid);
        let applied = applied.map(|([_, corner], force)| (run.solid.corners.node_at(corner), force));
        let mut reactions = BTreeMap::new();
        for (node, force) in run.held.iter().copied().chain(applied) {
            add(reactions.entry(node).or_insert([0.0; D]), force, 1.0);
        }
        let code = |node: u32| run.topology.code_of_corner(run.solid.corners.of(node as usize)[0]);
        Self {
            contacts: contacts.collect(),
            joints: joints.collect(),
            reactions: reactions.into_iter().map(|(node, force)| (code(node), force)).collect(),
        }
    }

    /// Adds the forces of another rank.
    pub(crate) fn add(&mut self, more: Self) {
        self.contacts.extend(more.contacts);
        self.joints.extend(more.joints);
        self.reactions.extend(more.reactions);
    }

    /// All forces, for results. `codes`: of the first corner of each node, in the order of results; `origin`: of positions.
    pub(crate) fn placed(self, codes: impl Iterator<Item = u32>, origin: Point<D>) -> Forces<D> {
        let mut all = self.contacts;
        all.extend(self.joints);
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
            contact.point = plus(contact.point, origin);
        }
        let reactions: BTreeMap<u32, Point<D>> = self.reactions.into_iter().collect();
        let reaction = |code: u32| reactions.get(&code).copied().unwrap_or([0.0; D]);
        Forces { contacts: all, reactions: codes.map(reaction).collect() }
    }
}
