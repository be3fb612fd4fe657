//! The force of a contact that is joined to a deeper one over a pass; see [`sheets`](crate::sheets).

use super::{ContactHistory, Meeting, PairLaw, Push};
use crate::adhesion;
use crate::material::ForceLaw;
use crate::servo::Answer;
use crate::vector::{dot, plus, times};

/// A contact that counts only as far as it lies below a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reduced {
    /// Forces at the minimum. The force of the pass is not yet taken off.
    pub(crate) push: Push,
    /// Elastic force at the overlap of the pass, N: it acts the other way from there.
    pub(crate) pass: f64,
    /// The force along the normal above that of the pass, N.
    pub(crate) own: f64,
    /// Stiffness and dashpot along the normal.
    pub(crate) answer: Answer,
    /// Power that the dashpot along the normal takes, W.
    pub(crate) dashpot: f64,
}

impl PairLaw {
    /// The forces of two bodies that touch, after a step, s; `pass`: overlap at the pass, m, if there is one.
    /// Continues their history.
    pub(crate) fn push_reduced(
        &self,
        of: &Meeting,
        pass: Option<f64>,
        history: &mut ContactHistory,
        step: f64,
    ) -> Reduced {
        let (contact, elastic) = self.normal_force(of.overlap, of.radius);
        let (contact_of_pass, pass) = self.pass(pass, of.radius);
        let own = elastic - pass;
        let (contact, stiffness) = self.own_stiffness(contact, contact_of_pass, own / elastic);
        let approach = -dot(of.velocity, of.normal);
        let damping = self.damping * (stiffness * of.mass).sqrt();
        let dashpot = damping * approach;
        let along = if self.sticks() { own + dashpot } else { (own + dashpot).max(0.0) };
        let pressed = if self.sticks() {
            own + 2.0 * adhesion::pull_off(of.radius, self.surfaces.adhesion)
        } else {
            along
        };
        let mut push = Push { force: times(along + pass, of.normal), ..Push::default() };
        if self.surfaces.friction > 0.0 {
            let most = self.surfaces.friction * pressed.max(0.0);
            let force = self.tangential(of, history, (contact, most), step);
            push.force = plus(push.force, force);
        }
        if self.surfaces.rolling_friction > 0.0 {
            push.moment = self.rolling(of, history, (contact, pressed), step);
        }
        if self.surfaces.twisting_friction > 0.0 {
            let moment = self.twisting(of, history, (contact, pressed), step);
            push.moment = plus(push.moment, times(moment, of.normal));
        }
        history.contact = contact;
        Reduced {
            push,
            pass,
            own: along,
            answer: Answer { stiffness, damping },
            dashpot: (along - own) * approach,
        }
    }

    /// Elastic energy along the normal above that of the pass, J.
    pub(crate) fn energy_reduced(&self, overlap: f64, pass: Option<f64>, radius: f64) -> f64 {
        let of = |overlap: f64| {
            let contact = self.normal_force(overlap, radius).0;
            self.energy(overlap, radius, &ContactHistory { contact, ..ContactHistory::default() })
        };
        of(overlap) - pass.filter(|&overlap| overlap > 0.0).map_or(0.0, of)
    }

    /// Elastic force at the overlap of a pass, N; 0 without one.
    pub(crate) fn pass_force(&self, overlap: Option<f64>, radius: f64) -> f64 {
        self.pass(overlap, radius).1
    }

    /// Radius of the contact, m, and force, N, at the overlap of a pass.
    fn pass(&self, overlap: Option<f64>, radius: f64) -> (f64, f64) {
        overlap
            .filter(|&overlap| overlap > 0.0)
            .map_or((0.0, 0.0), |overlap| self.normal_force(overlap, radius))
    }

    /// Radius of the contact, m, and stiffness, N/m, above those of the pass.
    fn own_stiffness(&self, contact: f64, of_pass: f64, share: f64) -> (f64, f64) {
        match self.law {
            ForceLaw::HertzMindlin => {
                let own = (contact - of_pass).max(0.0);
                (own, self.stiffness(own))
            }
            ForceLaw::Hooke { .. } => (contact * share, self.stiffness(contact) * share),
        }
    }
}

impl ContactHistory {
    /// Moves a share of the springs to a pool.
    pub(crate) fn hand_over(&mut self, share: f64, pool: &mut Self) {
        pool.take_over(share, self);
        self.tangential = times(1.0 - share, self.tangential);
        self.rolling = times(1.0 - share, self.rolling);
        self.twisting *= 1.0 - share;
        self.contact *= 1.0 - share;
    }

    /// Adds a share of the springs of a pool.
    pub(crate) fn take_over(&mut self, share: f64, pool: &Self) {
        self.tangential = plus(self.tangential, times(share, pool.tangential));
        self.rolling = plus(self.rolling, times(share, pool.rolling));
        self.twisting += share * pool.twisting;
    }
}
