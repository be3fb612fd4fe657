//! Dynamic relaxation with adaptive damping: a run goes to its state of rest as fast as the slowest motion in
//! it allows.
//!
//! A force `c m v` against the motion of each node damps all modes alike, and best with `c` twice the lowest
//! angular frequency that still moves. Rayleigh's quotient of the velocities says which one that is:
//!
//! ```text
//! ω² = -v·Δf / (h Σ m v²),   c = 2 ω
//! ```
//! with the change `Δf` of the forces on nodes in a step `h` with the velocities `v`. Fast modes die out
//! first, then the quotient falls to that of the slowest. Where nothing resists a motion, as in a fall, it
//! is 0. Underwood, in *Computational Methods for Transient Analysis* (1983), chapter 5; Oakley and Knight,
//! Computer Methods in Applied Mechanics and Engineering 126 (1995) 67.
//!
//! With forces `f₀` at the beginning of a step and `f₁` at its end, `v·Δf` is the difference of two sums over
//! the nodes, `f₁·v - f₀·v`, of which the first is known one step after the second. They are taken every
//! [`LOOK`] steps.

use crate::motion::{MotionSums, RelaxationSums};
use crate::peers::Peers;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::sum::Sum;

/// Steps between two changes of the damping.
const LOOK: u64 = 10;

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The sums of this step for the damping of dynamic relaxation.
    pub(super) fn taken(&self) -> RelaxationSums {
        match self.step % LOOK {
            _ if !self.model.time.dynamic_relaxation => RelaxationSums::Nothing,
            0 => RelaxationSums::After,
            1 => RelaxationSums::Before,
            _ => RelaxationSums::Nothing,
        }
    }

    /// Notes the sums of a step, and changes the damping from the next step on.
    pub(super) fn relax(&mut self, moved: &MotionSums<Sum, D>, peers: &dyn Peers<D, N>) {
        let taken = self.taken();
        if taken == RelaxationSums::Nothing {
            return;
        }
        let [mut work, mut inertia] = moved.taken.clone();
        peers.add_up(&mut [&mut work, &mut inertia]);
        let relaxation = &mut self.totals.relaxation;
        if taken == RelaxationSums::After {
            relaxation.work = work.value();
            return;
        }
        let step = self.scales.time_step;
        let square = (relaxation.work - work.value()) / (step * step * inertia.value());
        // It is negative where forces accelerate the motion, and NaN at rest. A stable step follows no mode
        // that is faster than 2/h.
        relaxation.damping =
            if square.is_finite() { 2.0 * square.max(0.0).sqrt().min(2.0 / step) } else { 0.0 };
    }
}
