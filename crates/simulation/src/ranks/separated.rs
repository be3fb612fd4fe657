//! Joints whose two elements are so far apart that no rank knows both of them, for probes of joints.

use fdem_distributed::wire;

use crate::probe::joints::{JointSide, joint_terms};
use crate::ranks::links::Links;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::sum::Sum;
use crate::topology::place_in_element;

/// A joint whose second element is not on the rank that counts the joint.
#[derive(Clone, Copy, Debug)]
struct SeparatedJoint<const D: usize> {
    /// Codes of its corners on both sides.
    corners: [[u32; D]; 2],
    /// Length, m, of the undeformed edge, or area, m², of the undeformed face.
    measure: f64,
}

wire!([const D: usize] SeparatedJoint<D> { corners, measure });

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Adds the separated joints of a set to the sums of one rank. All ranks call it together.
    pub(super) fn add_separated(&self, name: &str, links: &Links<'_>, sums: &mut [Sum]) {
        let joints = links.all(&self.separated_joints(name)).concat();
        // All ranks have the same list.
        if joints.is_empty() {
            return;
        }
        let mut sides = links.all(&self.separated_sides(&joints)).concat();
        if !self.scene().counts_common() {
            return;
        }
        sides.sort_unstable_by_key(|(place, _)| *place);
        for (joint, sides) in joints.iter().zip(sides.chunks_exact(2)) {
            let terms = joint_terms::<D, N>([sides[0].1, sides[1].1], joint.measure);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| sum.add(term));
        }
    }

    /// Visits the lengths or areas of the damaged joints that this rank counts, without and with the damage
    /// as a factor. Joints that are open from the beginning are left out.
    pub(crate) fn damaged_lengths(&self, mut visit: impl FnMut([f64; 2])) {
        let loose = self.part.iter().flat_map(|part| &part.loose_joints);
        let loose = loose.map(|moving| (moving.corners[0], moving.measure, 1.0));
        let here = self.joints().all.iter().filter(|joint| joint.counted).map(|joint| {
            let side = self.topology.facets[joint.facet as usize].corners[0];
            (side.map(|corner| self.topology.code_of_corner(corner)), joint.measure, joint.damage())
        });
        for (side, measure, damage) in here.chain(loose).filter(|(.., damage)| *damage > 0.0) {
            if !self.set_of_side(side).is_some_and(|set| self.model.joint_sets[set as usize].open) {
                visit([measure, damage * measure]);
            }
        }
    }

    /// The joint set on a side, given by its codes, of an element that this rank knows.
    fn set_of_side(&self, side: [u32; D]) -> Option<u32> {
        let element = self.topology.element(side[0] / N as u32)?;
        self.model.set_of(element, place_in_element::<D, N>(&side))
    }

    /// The separated joints of a set that this rank counts.
    fn separated_joints(&self, name: &str) -> Vec<SeparatedJoint<D>> {
        let set = self.joint_set(name);
        // The rank that counts a joint knows the element on its first side.
        let of_set = |joint: &SeparatedJoint<D>| {
            let of = self.set_of_side(joint.corners[0]);
            of.is_some() && of == set
        };
        let loose = self.part.iter().flat_map(|part| &part.loose_joints);
        loose
            .map(|moving| SeparatedJoint { corners: moving.corners, measure: moving.measure })
            .filter(of_set)
            .collect()
    }

    /// The sides of joints that this rank counts, each with twice the place of its joint, plus 1 for the
    /// second side.
    fn separated_sides(&self, joints: &[SeparatedJoint<D>]) -> Vec<(u32, JointSide<D>)> {
        let mut known = Vec::new();
        for (place, side) in (0..).zip(joints.iter().flat_map(|joint| joint.corners)) {
            let Some(element) = self.topology.element(side[0] / N as u32) else { continue };
            if self.solid().share().element(element) {
                let corners = side.map(|code| element * N as u32 + code % N as u32);
                known.push((place, self.joint_side(&corners)));
            }
        }
        known
    }
}
