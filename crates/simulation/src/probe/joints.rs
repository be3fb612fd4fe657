//! Means over the joints of a set: opening, slip, and the stresses on it.
//!
//! A joint is known for the whole run, also after it has handed over to contact. Opening and slip come from
//! the corners of its two sides, and stresses from its two elements, so that they have one meaning in every
//! state of the joint.

use fdem_distributed::wire;

use crate::joints::JointAxes;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::vector::{Matrix, Point, applied, dot, matrix};

/// Names and units of the means over a joint set.
pub(super) const COLUMNS: [(&str, &str); 4] =
    [("opening", "m"), ("slip", "m"), ("normal_stress", "Pa"), ("shear_stress", "Pa")];

/// One side of a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointSide<const D: usize> {
    /// Positions of its corners, m, in the order of the corners of the other side.
    corners: [Point<D>; D],
    /// Stress of its element, Pa.
    stress: Matrix<D>,
}

wire!([const D: usize] JointSide<D> { corners, stress });

/// Opening and slip, m, normal and shear stress, Pa, of a joint, and 1, all times its length or area.
pub(crate) fn joint_terms<const D: usize, const N: usize>(sides: [JointSide<D>; 2], measure: f64) -> [f64; 5]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let [one, other] = &sides;
    let frame = JointAxes::of::<N>(std::array::from_fn(|end| [one.corners[end], other.corners[end]]));
    let gap = frame.mean_gap();
    let stress: Matrix<D> = matrix(|i, k| 0.5 * (one.stress[i][k] + other.stress[i][k]));
    let across = applied(&stress, frame.axes[0]);
    let traction = frame.axes.map(|axis| dot(axis, across));
    let sliding = |components| <[[f64; D]; N]>::sliding(&components);
    [gap[0], sliding(gap), traction[0], sliding(traction), 1.0].map(|term| measure * term)
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The number of a joint set.
    pub(crate) fn joint_set(&self, name: &str) -> Option<u32> {
        self.model.joint_sets.iter().position(|set| set.name == name).map(|set| set as u32)
    }

    /// Visits the joints of a set that this rank counts and whose two sides it knows, with their
    /// [`joint_terms`].
    pub(super) fn each_joint_of(&self, name: &str, mut visit: impl FnMut([f64; 5])) {
        let Some(set) = self.joint_set(name) else { return };
        for joint in &self.joints().all {
            if joint.counted && self.joints().set(joint.facet) == Some(set) {
                let sides = self.topology.facets[joint.facet as usize].corners;
                visit(joint_terms::<D, N>(sides.map(|side| self.joint_side(&side)), joint.measure));
            }
        }
    }

    /// One side of a joint, by its corners.
    pub(crate) fn joint_side(&self, corners: &[u32; D]) -> JointSide<D> {
        JointSide {
            corners: corners.map(|corner| self.solid().position_at(corner)),
            stress: self.solid().stress(corners[0] as usize / N),
        }
    }
}
