//! The law of joints, end by end, as other devices compute it: for tests that compare the two.

use crate::accelerator::{EndMemory, FlatLaw};
use crate::cohesive::{JointLaw, Memory};

/// An end of a joint with one stiffness and one friction, that does not dilate.
#[derive(Clone, Copy, Debug)]
pub struct JointEnd<const D: usize> {
    /// Its law. Share, length and faded share do not count.
    pub law: FlatLaw<D>,
    /// The history of the end, which the pass changes.
    pub memory: EndMemory<D>,
    /// Opening and sliding, m.
    pub gap: [f64; D],
    /// Traction, Pa: the result.
    pub traction: [f64; D],
}

/// Computes the tractions of ends of joints, in two or three dimensions, and updates their histories.
pub fn soften_ends<const D: usize>(ends: &mut [JointEnd<D>]) {
    for end in ends {
        let FlatLaw { normal, penalty, tensile, cohesion, friction, critical, .. } = end.law;
        let law = JointLaw {
            normal,
            penalty,
            tensile,
            cohesion,
            friction,
            residual: friction,
            shear: 1.0,
            critical,
            dilation: 0.0,
            dilated: 0.0,
        };
        let EndMemory { damages, stiffness, origin, rubbed } = end.memory;
        let mut memory = Memory { damages, stiffness, origin, rubbed };
        end.traction = memory.traction(&law, end.gap);
        let Memory { damages, stiffness, origin, rubbed } = memory;
        end.memory = EndMemory { damages, stiffness, origin, rubbed };
    }
}
