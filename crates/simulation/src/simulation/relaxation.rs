//! Dynamic relaxation with kinetic damping: whenever the kinetic energy has passed a peak, all nodes stop.
//!
//! A body on its way to equilibrium has most kinetic energy where its potential energy is least. Nodes that stop there begin again from a state nearer to equilibrium, whatever the frequencies: there is
//! no coefficient to choose. Cundall, *Explicit finite difference methods in geomechanics* (1976); Barnes, International Journal of Space Structures 14 (1999) 89.
//!
//! The kinetic energy is looked at after every [`LOOK`] steps, and the nodes stop in the step after that. With `v₋` before the step, and `v₊` as it would be after it, a node loses the energy
//! `m v₋·v₊ / 2` that it has at the positions between them, so that the energy balance holds as it does without a stop.

use crate::motion::{force_on, local_damping};
use crate::ranks::Links;
use crate::simplex::Simplex;
use crate::simulation::Simulation;
use crate::sum::Sum;
use crate::topology::NONE;

/// Steps between two looks at the kinetic energy.
const LOOK: u64 = 10;

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Whether this step looks at the kinetic energy.
    pub(super) fn looks_for_peak(&self) -> bool {
        self.model.time.dynamic_relaxation && self.step.is_multiple_of(LOOK)
    }

    /// Looks at the kinetic energy: after a peak, nodes stop in the next step. `kinetic`: that of this rank, J.
    pub(super) fn look_for_peak(&mut self, kinetic: &Sum, links: Option<&Links<'_>>) {
        let mut kinetic = kinetic.clone();
        if let Some(links) = links {
            links.add_up(&mut [&mut kinetic]);
        }
        let now = kinetic.value();
        self.totals.halts = now < self.totals.kinetic;
        self.totals.kinetic = if self.totals.halts { 0.0 } else { now };
    }

    /// Stops all nodes along the axes on which they are free, if the step before has said so. The corners have the forces of this step.
    pub(super) fn halt(&mut self) {
        if !std::mem::take(&mut self.totals.halts) {
            return;
        }
        let factor = self.model.gravity_schedule.factor(self.time());
        let (step, damping) = (self.scales.time_step, self.model.time.local_damping);
        for node in (0..self.solid.nodes.len()).filter(|&node| self.solid.share.node(node)) {
            let constants = &self.solid.constants[node];
            let weight = self.model.gravity.map(|axis| factor * self.solid.true_mass(node) * axis);
            let force = force_on(node, &self.solid, &self.joints);
            let velocity = self.solid.nodes[node].velocity;
            let force: [f64; D] = std::array::from_fn(|axis| force[axis] + weight[axis]);
            let damped = local_damping(damping, force, velocity);
            for axis in 0..D {
                let before = velocity[axis];
                let is_held =
                    constants.hold != NONE && self.loads.holds[constants.hold as usize][axis].is_some();
                if is_held || before == 0.0 {
                    continue;
                }
                let after = before + step / constants.mass * (force[axis] - damped[axis]);
                self.totals.external.add(0.5 * step * weight[axis] * before);
                self.totals.damping.add(0.5 * step * damped[axis] * before);
                self.totals.damping.add(0.5 * constants.mass * before * after);
                self.solid.nodes[node].velocity[axis] = 0.0;
            }
        }
    }
}
