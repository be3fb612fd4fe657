//! The state of a run at one instant, as results show it.

use fdem_grains::SphereColumns;

use crate::exposure::{exposure, exposure_of_planes};
use crate::laws::MaterialLaw;
use crate::model::Strength;
use crate::simplex::Simplex;
use crate::vector::{applied, minus, transposed, unit};

/// Positions, motion, stress and cracks at one instant. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot<const D: usize = 2, const N: usize = 3> {
    /// Steps done.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Positions of the nodes, m. A node of the mesh becomes several nodes where the mesh has broken: the
    /// first keeps its number, and the others follow after all nodes of the mesh, in the order of the nodes
    /// of the mesh and, at each of these, of the elements.
    pub positions: Vec<[f64; D]>,
    /// Displacements of the nodes, m.
    pub displacements: Vec<[f64; D]>,
    /// Velocities of the nodes, m/s.
    pub velocities: Vec<[f64; D]>,
    /// Nodes of each element, in the order of the mesh.
    pub elements: Vec<[u32; N]>,
    /// Cauchy stress of each element, `[xx, yy, zz, xy, yz, xz]` in Pa, tension positive.
    pub stresses: Vec<[f64; 6]>,
    /// Largest damage of the joints of each element, from 0 to 1. Joints that are open from the beginning do
    /// not count.
    pub damage: Vec<f64>,
    /// Body of each element.
    pub bodies: Vec<u32>,
    /// Material of each element.
    pub materials: Vec<u32>,
    /// Fragment of each element: elements that hang together by facets have one number. Numbers count from 0
    /// in the order of the first element of each fragment.
    pub fragments: Vec<u32>,
    /// Joints that are softening or broken, in the order of their elements; those of sets that are open from
    /// the beginning are marked.
    pub cracks: Vec<Crack<D>>,
    /// Whole joints, of joint sets and of models that have a joint on each facet, in the order of their
    /// elements. `None` if they are not shown, nor are joints that soften. Snapshots of a run leave them out:
    /// [`Simulation::intact_joints`](crate::Simulation) and [`Leader`](crate::Leader) return them on request.
    pub intact: Option<Vec<Crack<D>>>,
    /// Strength of each material; `None` for a material that does not break.
    pub strengths: Vec<Option<Strength>>,
    /// Law of each material, which strengths may depend on; empty for laws without directions.
    pub laws: Vec<MaterialLaw>,
    /// Spheres and walls.
    pub spheres: SphereColumns,
    /// The joints that fluid can enter, by ascending elements; `None` without a fluid.
    pub fluid: Option<Vec<WetJoint>>,
    /// Pressure of the liquid in the pores at each node, Pa; `None` at a node of the mesh that no element
    /// with pores has. `None` as a whole without pores.
    pub pore_pressures: Option<Vec<Option<f64>>>,
}

/// A joint that fluid can enter: a cell of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WetJoint {
    /// Elements on its two sides, ascending.
    pub elements: [u32; 2],
    /// Pressure, Pa; the lowest one of the fluid where the joint is not full.
    pub pressure: f64,
    /// Hydraulic aperture, m.
    pub aperture: f64,
    /// Part of it that is full, from 0 to 1.
    pub saturation: f64,
}

impl<const D: usize, const N: usize> Default for Snapshot<D, N> {
    /// A snapshot of nothing.
    fn default() -> Self {
        Self {
            step: 0,
            time: 0.0,
            positions: Vec::new(),
            displacements: Vec::new(),
            velocities: Vec::new(),
            elements: Vec::new(),
            stresses: Vec::new(),
            damage: Vec::new(),
            bodies: Vec::new(),
            materials: Vec::new(),
            fragments: Vec::new(),
            cracks: Vec::new(),
            intact: None,
            strengths: Vec::new(),
            laws: Vec::new(),
            spheres: SphereColumns::default(),
            fluid: None,
            pore_pressures: None,
        }
    }
}

impl<const D: usize, const N: usize> Snapshot<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The fluid in the joint between two elements; `None` if fluid cannot enter it.
    pub fn wet_joint(&self, elements: [u32; 2]) -> Option<&WetJoint> {
        let [a, b] = elements;
        let fluid = self.fluid.as_deref()?;
        let place = fluid.binary_search_by_key(&[a.min(b), a.max(b)], |of| of.elements).ok()?;
        fluid.get(place)
    }

    /// Largest and smallest principal stress of an element, Pa: of those in the plane, in two dimensions.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn principal_stresses(&self, element: usize) -> [f64; 2] {
        principal_stresses::<D, N>(&<[[f64; D]; N]>::of_tensor(&self.stresses[element]))
    }

    /// Exposure of an element: the reciprocal of the factor by which its stress can grow until it reaches the
    /// strength of its material. It is 1 where the stress reaches the strength; `None` if the material has
    /// none. The strength is the mean one, without its scatter; in bedded rock it is that of each plane. See
    /// `src/exposure.rs` for the definition.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn exposure(&self, element: usize) -> Option<f64> {
        let material = self.materials[element] as usize;
        let strength = self.strengths.get(material)?.as_ref()?;
        let stress = <[[f64; D]; N]>::of_tensor(&self.stresses[element]);
        let Some(law) = self.laws.get(material).filter(|law| law.has_directions()) else {
            return Some(exposure::<D, N>(strength, &stress));
        };
        // Strengths depend on the normal in the undeformed body. An edge there has the same component along
        // it as the deformed edge along the present normal, but for a common factor.
        let nodes = self.elements[element].map(|node| node as usize);
        let edge = |k: usize| minus(self.positions[nodes[k + 1]], self.positions[nodes[0]]);
        let moved = |k: usize| minus(self.displacements[nodes[k + 1]], self.displacements[nodes[0]]);
        let now = std::array::from_fn(edge);
        let before = std::array::from_fn(|k| minus(now[k], moved(k)));
        let inverse = transposed(&<[[f64; D]; N]>::cofactor(&before));
        let on = |normal| law.strength_on(*strength, unit(applied(&inverse, applied(&now, normal))));
        Some(exposure_of_planes::<D, N>(&stress, on))
    }
}

/// Largest and smallest principal stress, Pa: of those in the plane, in two dimensions.
pub fn principal_stresses<const D: usize, const N: usize>(stress: &[[f64; D]; D]) -> [f64; 2]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let [middle, radius] = <[[f64; D]; N]>::circle(stress);
    [middle + radius, middle - radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stresses_of_known_states() {
        assert_eq!(principal_stresses::<2, 3>(&[[3.0, 0.0], [0.0, -1.0]]), [3.0, -1.0]);
        assert_eq!(principal_stresses::<2, 3>(&[[0.0, 2.0], [2.0, 0.0]]), [2.0, -2.0]);
        assert_eq!(principal_stresses::<2, 3>(&[[4.0, 3.0], [3.0, -4.0]]), [5.0, -5.0]);
        let found = principal_stresses::<3, 4>(&[[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, -4.0]]);
        assert!((found[0] - 3.0).abs() < 1e-14 && (found[1] + 4.0).abs() < 1e-14, "{found:?}");
    }
}

/// A joint on a facet between two elements: one that has passed its strength, or, with a damage of 0, a whole
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crack<const D: usize = 2> {
    /// Current positions of its corners, m, half way between the two elements: the two ends of an edge, the
    /// three corners of a face.
    pub corners: [[f64; D]; D],
    /// Elements on its two sides.
    pub elements: [u32; 2],
    /// Damage from 0 (whole) to 1 (broken), the mean of its corners.
    pub damage: f64,
    /// Mode of failure; that of a whole joint has no meaning.
    pub mode: Mode,
    /// Mean opening, m; negative where it is closed.
    pub opening: f64,
    /// Mean sliding, m: along the edge, with a sign, in two dimensions; its magnitude in three.
    pub sliding: f64,
    /// Time of failure, s; `None` while the joint holds; 0 for one that is open from the beginning.
    pub time: Option<f64>,
    /// Time at which it began to soften, s; `None` for a whole one, and for one that is open from the
    /// beginning.
    pub softens: Option<f64>,
    /// Share of its fracture energy that it has dissipated, from 0 to 1: the mean of its corners.
    pub dissipated: f64,
    /// Length, m, of the undeformed edge, or area, m², of the undeformed face.
    pub measure: f64,
    /// Whether the joint is of a set that is open from the beginning: no crack of the run.
    pub open_from_start: bool,
}

/// Mode of failure of a joint, by the shares of opening and sliding in its damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// At least three quarters by opening (mode I).
    Tension,
    /// At least three quarters by sliding (mode II).
    Shear,
    /// Neither has three quarters.
    Mixed,
}
