//! Forces between elements and on nodes for results.

use std::collections::BTreeMap;

use fdem_distributed::wire;
use serde::{Deserialize, Serialize};

use crate::vector::{Point, length, plus};

/// Forces at the beginning of the last step; none before the first step of a run, nor before the first step
/// after a resume.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces<const D: usize = 2> {
    /// Forces of couples of elements that press each other, ascending by their elements.
    pub contacts: Vec<ContactForce<D>>,
    /// Force of all boundaries on each node, N, in the order of the nodes of a [`Snapshot`](crate::Snapshot).
    pub reactions: Vec<[f64; D]>,
}

/// Contact force between two elements.
///
/// A broken joint that is closed presses its two elements until they have slid far enough for the contact to
/// take over. Its force is included.
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

    /// Merges the forces of two contacts of the same elements. The point is the mean of their points,
    /// weighted by the forces.
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

/// Action of a boundary on the bodies at the beginning of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub(crate) struct Reaction<const D: usize> {
    /// N.
    pub(crate) force: Point<D>,
    /// Moment of a boundary that turns nodes or bodies, about the point through which its axis passes, N m.
    pub(crate) moment: Point<3>,
}

impl<const D: usize> Default for Reaction<D> {
    fn default() -> Self {
        Self { force: [0.0; D], moment: [0.0; 3] }
    }
}

wire!([const D: usize] Reaction<D> { force, moment });

/// The forces of a step that a rank counts. Elements have their numbers in the whole mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnForces<const D: usize> {
    pub(crate) contacts: Vec<ContactForce<D>>,
    /// Forces of broken joints that are closed.
    pub(crate) joints: Vec<ContactForce<D>>,
    /// Force of all boundaries on each node on which one acts, N, by the code of the first corner of the
    /// node.
    pub(crate) reactions: Vec<(u32, Point<D>)>,
}

wire!([const D: usize] OwnForces<D> { contacts, joints, reactions });
wire!([const D: usize] ContactForce<D> { elements, point, normal, tangential });

impl<const D: usize> OwnForces<D> {
    /// Adds the forces of another rank.
    pub(crate) fn add(&mut self, more: Self) {
        self.contacts.extend(more.contacts);
        self.joints.extend(more.joints);
        self.reactions.extend(more.reactions);
    }

    /// All forces, for results. `codes`: of the first corner of each node, in the order of results; `origin`:
    /// of positions.
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
