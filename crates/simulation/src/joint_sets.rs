//! Sets of joints: surfaces inside bodies, such as bedding planes or bonds, each set with a common law.

use std::collections::BTreeMap;

use fdem_mesh::sorted;
use serde::{Deserialize, Serialize};

use crate::model::{Model, Strength};
use crate::simplex::Simplex;
use crate::topology::NONE;

/// A set of joints. They are in the mesh from the beginning, whatever the option for the insertion of others
/// is.
///
/// A joint is elastic up to its strength, softens, and then has its residual friction. Under initial stress
/// it begins with the traction of that stress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSet {
    /// Name, for messages.
    pub name: String,
    /// Strength and fracture energies. Tensile strength and cohesion may be 0. The fracture energy contains
    /// the elastic work up to the strength.
    pub strength: Strength,
    /// Tangent of the friction angle of broken joints. The friction falls to it from that of the strength as
    /// the joint softens. It is also the coefficient of friction of the contacts between elements on the two
    /// sides of the set, after joints have handed over to contact.
    pub residual_friction: f64,
    /// Normal stiffness, Pa/m; `None` for the joint penalty of [`FractureOptions`](crate::FractureOptions).
    pub normal_stiffness: Option<f64>,
    /// Shear stiffness, Pa/m; `None` for the normal stiffness.
    pub shear_stiffness: Option<f64>,
    /// Tangent of the dilation angle: how far the sides of a joint move apart for each length that they slip
    /// under friction. At most the residual friction. 0 for none.
    pub dilation: f64,
    /// Slip, m, up to which joints dilate; `None` for 5 % of the length of each.
    pub dilation_slip: Option<f64>,
    /// Whether the joints are broken from the beginning: they have no strength, carry no initial stress, and
    /// leave pressure and friction to contacts.
    pub open: bool,
}

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
