//! The snapshot of a run, for results.

use crate::joints::{Break, Joint};
use crate::simplex::Simplex;
use crate::simulation::Simulation;
use crate::snapshot::{Crack, Mode, Snapshot};

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Positions, motion, stress and cracks now.
    pub fn snapshot(&self) -> Snapshot<D, N> {
        let order = self.solid.order(&self.topology);
        let nodes = || order.iter().map(|&node| node as usize);
        let elements = self.solid.elements.len();
        let mut damage = vec![0.0_f64; elements];
        let mut cracks = Vec::new();
        for number in self.joints.in_order() {
            let joint = &self.joints.all[number as usize];
            let of_joint = joint.damage();
            let facet = &self.topology.facets[joint.facet as usize];
            for element in facet.elements() {
                let damage = &mut damage[element as usize];
                *damage = damage.max(of_joint);
            }
            if of_joint > 0.0 {
                cracks.push(self.crack(joint, of_joint, self.joints.break_of(number)));
            }
        }
        Snapshot {
            step: self.step,
            time: self.time(),
            positions: nodes().map(|node| self.solid.place(self.solid.nodes[node].position)).collect(),
            displacements: nodes().map(|node| self.solid.displacement(node, &self.model)).collect(),
            velocities: nodes().map(|node| self.solid.nodes[node].velocity).collect(),
            elements: self.solid.in_order(&order),
            stresses: (0..elements)
                .map(|element| {
                    <[[f64; D]; N]>::in_tensor(&self.solid.stress(element), self.solid.moduli(element))
                })
                .collect(),
            damage,
            bodies: self.model.mesh.bodies.clone(),
            materials: self.model.mesh.materials.clone(),
            fragments: self.fragments(),
            cracks,
        }
    }

    fn crack(&self, joint: &Joint<D>, damage: f64, broken: Option<&Break>) -> Crack<D> {
        let facet = &self.topology.facets[joint.facet as usize];
        let corner = |corner: usize| {
            let [a, b] = facet.corners.map(|side| self.solid.at_corner(side[corner]).position);
            self.solid.place(std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis])))
        };
        let gap = joint.gap(&self.solid);
        let modes = broken.map_or_else(|| joint.modes(), |broken| broken.modes);
        Crack {
            corners: std::array::from_fn(corner),
            elements: facet.elements(),
            damage,
            mode: mode(modes),
            opening: gap[0],
            sliding: <[[f64; D]; N]>::sliding(&gap),
            time: broken.map(|broken| broken.time),
            measure: joint.measure,
        }
    }
}

/// Mode of failure of a joint from its damage by opening and by sliding.
pub(crate) fn mode(damages: [f64; 2]) -> Mode {
    let opening = damages[0] / (damages[0] + damages[1]).max(f64::MIN_POSITIVE);
    if opening >= 0.75 {
        Mode::Tension
    } else if opening <= 0.25 {
        Mode::Shear
    } else {
        Mode::Mixed
    }
}
