//! Parameters of contacts between two materials.

use crate::joint_sets::common_set;
use crate::model::{ContactOptions, Model};
use crate::simplex::Simplex;
use crate::vector::Point;

/// Contact parameters of two materials.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactLaw {
    /// Penalty times thickness: N/m in two dimensions, Pa in three.
    pub(super) penalty: f64,
    pub(super) friction: f64,
    /// Tangential stiffness, in the same unit.
    pub(super) tangential: f64,
    /// Share of critical damping.
    pub(super) damping: f64,
}

/// Parameters of contacts between two materials.
fn law<const D: usize, const N: usize>(model: &Model<D, N>, a: u32, b: u32) -> ContactLaw {
    let interface = model.interface(a, b);
    let [one, two] = [a, b].map(|material| &model.materials[material as usize]);
    let penalty = interface
        .and_then(|interface| interface.penalty)
        .unwrap_or(model.contact.penalty * one.stiffest_modulus().min(two.stiffest_modulus()))
        * model.thickness;
    let friction = interface.map_or(one.friction.min(two.friction), |interface| interface.friction);
    ContactLaw {
        penalty,
        friction,
        tangential: model.contact.tangential_stiffness * penalty,
        damping: model.contact.damping,
    }
}

/// Parameters of the contacts of a model.
#[derive(Clone, Debug)]
pub(super) struct ContactLaws<const N: usize> {
    /// Laws of all pairs of materials, then for each joint set the same laws with its residual friction.
    pub(super) all: Vec<ContactLaw>,
    materials: usize,
    /// Joint sets of the facets of each element; empty without joint sets.
    joint_facets: Vec<[u32; N]>,
    options: ContactOptions,
}

impl<const N: usize> ContactLaws<N> {
    pub(super) fn new<const D: usize>(model: &Model<D, N>) -> Self {
        let count = model.materials.len();
        let pairs = || (0..count * count).map(|k| law(model, (k / count) as u32, (k % count) as u32));
        let of_sets = model
            .joint_sets
            .iter()
            .flat_map(|set| pairs().map(|law| ContactLaw { friction: set.residual_friction, ..law }));
        Self {
            all: pairs().chain(of_sets).collect(),
            materials: count,
            joint_facets: model.joint_facets.clone(),
            options: model.contact,
        }
    }

    /// Ignored energy of an overlap that relaxes over that before a step. The depth of the overlap goes with
    /// the root of its energy. `step`: s.
    pub(super) fn still_ignored(&self, step: f64) -> f64 {
        let share = 1.0 / (1.0 + step / self.options.relaxing_time(step));
        share * share
    }

    /// Memory of the properties of elements, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.joint_facets)
    }

    /// The law of two elements of these materials: its place in all laws.
    #[inline]
    pub(super) fn number(&self, elements: [u32; 2], materials: [u32; 2]) -> usize {
        let [one, other] = materials.map(|material| material as usize);
        let set = common_set(&self.joint_facets, elements).map_or(0, |set| set as usize + 1);
        (set * self.materials + one) * self.materials + other
    }
}

/// Penalty of contacts between two materials, Pa, and their coefficient of friction.
pub(crate) fn penalty_and_friction<const D: usize, const N: usize>(
    model: &Model<D, N>,
    [a, b]: [u32; 2],
) -> [f64; 2] {
    let law = law(model, a, b);
    [law.penalty / model.thickness, law.friction]
}

/// Upper bound of the stiffness, N/m, that a contact over facet `k` of an element of this material has at
/// each vertex of the facet.
pub(crate) fn stiffness<const D: usize, const N: usize>(
    model: &Model<D, N>,
    corners: &[Point<D>; N],
    k: usize,
    material: u32,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let penalty = (0..model.materials.len() as u32)
        .map(|other| law(model, material, other).penalty)
        .fold(0.0_f64, f64::max);
    let measure = <[[f64; D]; N]>::facet_measure(&<[[f64; D]; N]>::FACETS[k].map(|corner| corners[corner]));
    // φ grows by N over the height. A part of 1/D of the pressure on the facet goes to each vertex. Each of
    // the two elements presses the other: factor 2.
    let normal = N as f64 * penalty / corners.height(k) * (1.0 / D as f64) * measure;
    let length = <[[f64; D]; N]>::contact_length(corners.measure());
    2.0 * normal.max(model.contact.tangential_stiffness * penalty * length)
}
