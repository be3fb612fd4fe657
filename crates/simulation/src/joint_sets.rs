//! Sets of joints: surfaces inside bodies, such as bedding planes or bonds, each set with a common law.

use std::collections::BTreeMap;

use fdem_mesh::sorted;

use crate::model::{JointSet, Model};
use crate::simplex::Simplex;
use crate::topology::NONE;

impl<const D: usize, const N: usize> Model<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Puts joints of a set on facets between elements, by their nodes in any order. Returns the number of
    /// facets that lie between two elements; others are ignored. A facet that is of a set already stays with
    /// it.
    pub fn add_joints(&mut self, set: u32, facets: &[[u32; D]]) -> usize {
        let elements = &self.mesh.elements;
        if self.joint_facets.is_empty() {
            self.joint_facets = vec![[NONE; N]; elements.len()];
        }
        let mut sides: BTreeMap<[u32; D], Vec<[usize; 2]>> =
            facets.iter().map(|&facet| (sorted(facet), Vec::new())).collect();
        for (element, nodes) in elements.iter().enumerate() {
            for (k, facet) in <[[f64; D]; N]>::FACETS.into_iter().enumerate() {
                if let Some(sides) = sides.get_mut(&sorted(facet.map(|corner| nodes[corner]))) {
                    sides.push([element, k]);
                }
            }
        }
        let inner = sides.values().filter(|sides| sides.len() == 2);
        for &[element, k] in inner.clone().flatten() {
            let of = &mut self.joint_facets[element][k];
            *of = (*of).min(set);
        }
        inner.count()
    }

    /// The set of the joint on facet `k` of an element.
    pub(crate) fn set_of(&self, element: u32, k: usize) -> Option<u32> {
        self.joint_facets.get(element as usize).map(|sets| sets[k]).filter(|&set| set != NONE)
    }
}

/// The first set that two elements both have joints of. `facets`: joint sets of the facets of each element;
/// empty without joint sets.
#[inline]
pub(crate) fn common_set<const N: usize>(facets: &[[u32; N]], elements: [u32; 2]) -> Option<u32> {
    let [one, other] = elements.map(|element| facets.get(element as usize));
    let of_both = one?.iter().filter(|&&set| set != NONE && other.is_some_and(|other| other.contains(&set)));
    of_both.min().copied()
}

impl JointSet {
    /// Normal stiffness, Pa/m, and the square root of the ratio of the shear stiffness to it. `penalty`: the
    /// normal stiffness of a set without one.
    pub(crate) fn stiffness(&self, penalty: f64) -> [f64; 2] {
        let normal = self.normal_stiffness.unwrap_or(penalty);
        [normal, self.shear_stiffness.map_or(1.0, |shear| (shear / normal).sqrt())]
    }
}
