//! Strengths, penalties and areas of facets, from the model.

use crate::joint_sets::common_set;
use crate::model::{Model, Strength};
use crate::simplex::Simplex;
use crate::solid::corners_of;
use crate::topology::{Facet, NONE, Topology, place_in_element};
use crate::vector::{Point, unit};

/// Penalty of the joint on a facet, Pa/m.
pub(crate) fn penalty<const D: usize, const N: usize>(model: &Model<D, N>, facet: &Facet<D>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let elements = facet.elements();
    let modulus =
        |element: u32| model.materials[model.mesh.materials[element as usize] as usize].stiffest_modulus();
    let heights = facet.corners.map(|corners| {
        corners_of(&model.mesh, corners[0] as usize / N).height(place_in_element::<D, N>(&corners))
    });
    let modulus = modulus(elements[0]).min(modulus(elements[1]));
    model.fracture.joint_penalty * modulus / (0.5 * (heights[0] + heights[1]))
}

/// Length of the undeformed edge, m, or area of the undeformed face, m².
pub(super) fn measure_of<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
    facet: &Facet<D>,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let place = |corner: u32| model.mesh.nodes[topology.vertices[corner as usize] as usize];
    <[[f64; D]; N]>::facet_measure(&facet.corners[0].map(place))
}

impl<const D: usize, const N: usize> Model<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Strength of the joint between two elements with a common facet: that of its joint set, or else that
    /// between their materials; `None` if it cannot break.
    pub fn strength_of(&self, elements: [u32; 2]) -> Option<Strength> {
        if let Some(set) = common_set(&self.joint_facets, elements) {
            return self.joint_sets.get(set as usize).map(|set| set.strength);
        }
        let [one, other] = elements.map(|element| self.mesh.elements[element as usize]);
        let facet = <[[f64; D]; N]>::FACETS
            .map(|facet| facet.map(|corner| one[corner]))
            .into_iter()
            .find(|facet| facet.iter().all(|node| other.contains(node)));
        let normal = facet.map(|facet| normal_of(&facet.map(|node| self.mesh.nodes[node as usize])));
        strength_between(self, elements.map(|element| self.mesh.materials[element as usize]), normal)
            .map(|(strength, _)| strength)
    }
}

/// Strength of the joint that a facet may get, whether it is that of an interface, and its joint set or
/// [`NONE`]. `None` if the facet cannot break. Strengths that depend on the direction are
/// [`directed_strength`].
pub(super) fn strength_on<const D: usize, const N: usize>(
    model: &Model<D, N>,
    facet: &Facet<D>,
) -> Option<(Strength, bool, u32)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let elements = facet.elements();
    if elements.iter().any(|&element| model.is_rigid(element)) {
        return None;
    }
    let side = facet.corners[0];
    let set = model.set_of(side[0] / N as u32, place_in_element::<D, N>(&side)).unwrap_or(NONE);
    let of_set = model.joint_sets.get(set as usize).map(|set| (set.strength, true));
    let materials = elements.map(|element| model.mesh.materials[element as usize]);
    let found = of_set.or_else(|| strength_between(model, materials, None));
    found.map(|(strength, interface)| (strength, interface, set))
}

/// The normal of an undeformed facet, of unit length.
fn normal_of<const D: usize, const N: usize>(facet: &[Point<D>; D]) -> Point<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    unit(<[[f64; D]; N]>::facet_normal(facet))
}

/// Strength of a facet that depends on its direction; `None` for one of a joint set or an interface, and for
/// one that cannot break.
pub(super) fn directed_strength<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
    facet: &Facet<D>,
) -> Option<Strength>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let side = facet.corners[0];
    if model.set_of(side[0] / N as u32, place_in_element::<D, N>(&side)).is_some() {
        return None;
    }
    let places = side.map(|corner| model.mesh.nodes[topology.vertices[corner as usize] as usize]);
    let materials = facet.elements().map(|element| model.mesh.materials[element as usize]);
    let found = strength_between(model, materials, Some(normal_of::<D, N>(&places)));
    found.filter(|(_, of_interface)| !of_interface).map(|(strength, _)| strength)
}

/// Strength between two materials, and whether it belongs to an interface between two different ones: the
/// strength of their interface if there is one, otherwise of the material with the lower tensile strength.
/// `None` if the facet cannot break. `normal`: that of the undeformed facet, of unit length, for strengths
/// that depend on it.
pub(super) fn strength_between<const D: usize, const N: usize>(
    model: &Model<D, N>,
    [a, b]: [u32; 2],
    normal: Option<Point<D>>,
) -> Option<(Strength, bool)> {
    if let Some(strength) = model.interface(a, b).and_then(|interface| interface.strength) {
        return Some((strength, a != b));
    }
    let strength = |material: u32| {
        let material = &model.materials[material as usize];
        normal.map_or(material.strength, |normal| material.strength_on(normal))
    };
    let weaker = match [a, b].map(strength) {
        [Some(one), Some(two)] => Some(if two.tensile < one.tensile { two } else { one }),
        [one, two] => one.or(two),
    };
    weaker.map(|strength| (strength, false))
}
