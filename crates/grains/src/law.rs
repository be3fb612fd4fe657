//! The force of one contact.
//!
//! With the reduced moduli `1/E = Σ (1 - ν²)/E`, `1/G = Σ 2 (2 - ν)(1 + ν)/E`, radius `1/R = Σ 1/r` and mass
//! `1/m = Σ 1/m`, the overlap `δ` and the damping ratio `b` ([`restitution`](crate::restitution)):
//!
//! | | along the normal | across it |
//! |---|---|---|
//! | Hertz and Mindlin | `4/3 E √(R δ) δ`, stiffness `2 E √(R δ)` | stiffness `8 G √(R δ)` |
//! | Hooke | `k δ` | stiffness `κ k` |
//!
//! The damping is `2 b √(stiffness m)` times the velocity, with `√(5/6)` for Hertz (Tsuji 1992). The force
//! across the normal adds up over the steps. It turns with the contact, is shortened where it exceeds
//! friction, and falls in proportion to the radius of the contact where that falls (Thornton, Cummins and
//! Cleary 2013): without that a closed cycle would gain energy. Rolling and twisting have a spring that
//! yields, with damping below its bound (model C of Ai, Chen, Rotter and Ooi 2011).

mod reduced;

use crate::adhesion;
use crate::material::{ForceLaw, GrainMaterial, Surfaces};
use crate::restitution::damping_ratio;
use crate::servo::Answer;
use crate::vector::{Vector, across, cross, dot, length, minus, plus, times};

/// The memory of a contact from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ContactHistory {
    /// Elastic force across the normal on the first of the two, N.
    pub(crate) tangential: Vector,
    /// Radius of the contact in the last step, m; 0 if it did not touch.
    pub(crate) contact: f64,
    /// Moment against rolling on the first of the two, N m.
    pub(crate) rolling: Vector,
    /// Moment against twisting about the normal, N m.
    pub(crate) twisting: f64,
}

/// Constants of the contacts of two materials.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairLaw {
    pub(crate) law: ForceLaw,
    /// Reduced moduli, Pa.
    pub(crate) young: f64,
    shear: f64,
    /// Damping over the root of a stiffness and the mass.
    pub(crate) damping: f64,
    /// The same across the normal, over the root of the stiffness along it and the mass.
    pub(crate) damping_across: f64,
    /// 1 over the stiffness of Hooke's law across the normal, m/N; 0 for Hertz's, or if that has none.
    pub(crate) softness_across: f64,
    pub(crate) surfaces: Surfaces,
}

/// Two bodies that may touch, in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// From the second to the first, of unit length.
    pub(crate) normal: Vector,
    /// m; negative if they are apart.
    pub(crate) overlap: f64,
    /// Reduced radius, m, and mass, kg.
    pub(crate) radius: f64,
    pub(crate) mass: f64,
    /// Moments of inertia of the two for rolling about the contact, kg m²; infinite for a wall.
    pub(crate) inertias: [f64; 2],
    /// Velocity of the first at the contact over that of the second, m/s.
    pub(crate) velocity: Vector,
    /// Angular velocities, rad/s.
    pub(crate) spins: [Vector; 2],
}

/// Forces of a contact on its first body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Push {
    /// N.
    pub(crate) force: Vector,
    /// Moment of rolling and twisting, N m.
    pub(crate) moment: Vector,
    /// Energy that the step dissipates, J.
    pub(crate) dissipated: f64,
}

impl Meeting {
    /// Reduced moment of inertia for rolling about the contact, kg m².
    fn inertia(&self) -> f64 {
        1.0 / (1.0 / self.inertias[0] + 1.0 / self.inertias[1])
    }
}

impl PairLaw {
    /// No force.
    pub(crate) const NONE: Self = Self {
        law: ForceLaw::Hooke { normal: 0.0, tangential: 0.0 },
        young: 1.0,
        shear: 1.0,
        damping: 0.0,
        damping_across: 0.0,
        softness_across: 0.0,
        surfaces: Surfaces::smooth([0; 2]),
    };

    pub(crate) fn new(law: ForceLaw, materials: [&GrainMaterial; 2], surfaces: &Surfaces) -> Self {
        // Hertz's stiffness changes during an impact (Tsuji 1992).
        let share = if matches!(law, ForceLaw::HertzMindlin) { 5.0_f64 / 6.0 } else { 1.0 };
        let sum = |of: fn(&GrainMaterial) -> f64| materials.into_iter().map(of).sum::<f64>();
        let young = 1.0 / sum(|of| (1.0 - of.poissons_ratio.powi(2)) / of.youngs_modulus);
        let shear =
            1.0 / sum(|of| 2.0 * (2.0 - of.poissons_ratio) * (1.0 + of.poissons_ratio) / of.youngs_modulus);
        let damping = 2.0 * damping_ratio(surfaces.restitution) * share.sqrt();
        // Both stiffnesses of Hertz's law are in proportion to the radius of the contact.
        let (across, stiffness) = match law {
            ForceLaw::HertzMindlin => (4.0 * shear / young, 0.0),
            ForceLaw::Hooke { normal, tangential } => (tangential, normal * tangential),
        };
        Self {
            law,
            young,
            shear,
            damping,
            damping_across: damping * across.sqrt(),
            softness_across: if stiffness > 0.0 { 1.0 / stiffness } else { 0.0 },
            surfaces: *surfaces,
        }
    }

    /// Distance at which two bodies with this reduced radius still touch once they did, m.
    pub(crate) fn reach(&self, radius: f64) -> f64 {
        if self.sticks() { -adhesion::last_overlap(radius, self.young, self.surfaces.adhesion) } else { 0.0 }
    }

    pub(crate) fn sticks(&self) -> bool {
        self.surfaces.adhesion > 0.0
    }

    /// Whether rolling or twisting has a spring.
    pub(crate) fn rolls(&self) -> bool {
        self.surfaces.rolling_friction > 0.0 || self.surfaces.twisting_friction > 0.0
    }

    /// Stiffness of Hooke's law along the normal, N/m; 0 for Hertz's.
    #[inline]
    pub(crate) fn normal(&self) -> f64 {
        match self.law {
            ForceLaw::HertzMindlin => 0.0,
            ForceLaw::Hooke { normal, .. } => normal,
        }
    }

    /// Whether the two touch. Those that stick touch until they part.
    #[inline]
    pub(crate) fn touches(&self, overlap: f64, radius: f64, history: &ContactHistory) -> bool {
        overlap > 0.0 || (self.sticks() && history.contact > 0.0 && overlap > -self.reach(radius))
    }

    /// Stiffness along the normal, N/m, at a radius of the contact, m.
    fn stiffness(&self, contact: f64) -> f64 {
        match self.law {
            ForceLaw::HertzMindlin => 2.0 * self.young * contact,
            ForceLaw::Hooke { normal, .. } => normal,
        }
    }

    /// Stiffness across the normal, N/m.
    #[inline]
    pub(crate) fn tangential_stiffness(&self, contact: f64) -> f64 {
        match self.law {
            ForceLaw::HertzMindlin => 8.0 * self.shear * contact,
            ForceLaw::Hooke { normal, tangential } => normal * tangential,
        }
    }

    /// Stiffness, N/m, and dashpot, N s/m, along the normal of a contact of a mass, kg.
    pub(crate) fn answer(&self, history: &ContactHistory, mass: f64) -> Answer {
        let stiffness = self.stiffness(history.contact);
        Answer { stiffness, damping: self.damping * (stiffness * mass).sqrt() }
    }

    /// Stiffness, N/m, and dashpot, N s/m, across the normal of a contact of a mass, kg.
    pub(crate) fn answer_across(&self, history: &ContactHistory, mass: f64) -> Answer {
        let stiffness = self.tangential_stiffness(history.contact);
        Answer { stiffness, damping: self.damping * (stiffness * mass).sqrt() }
    }

    /// Radius of the contact of two bodies without adhesion with this reduced radius, m, under a force, N.
    pub(crate) fn contact_under(&self, force: f64, radius: f64) -> f64 {
        match self.law {
            ForceLaw::HertzMindlin => libm::cbrt(0.75 * force * radius / self.young),
            ForceLaw::Hooke { normal, .. } => (radius * force / normal).sqrt(),
        }
    }

    /// Stiffness of the springs against rolling or twisting, N m, at a radius of the contact, m. `share`: its
    /// coefficient of friction.
    fn rolling_stiffness(&self, contact: f64, radius: f64, share: f64) -> f64 {
        2.25 * self.stiffness(contact) * (share * radius).powi(2)
    }

    /// Radius of the contact, m, and the elastic force along the normal, N.
    fn normal_force(&self, overlap: f64, radius: f64) -> (f64, f64) {
        match self.law {
            ForceLaw::HertzMindlin if self.sticks() => {
                let work = self.surfaces.adhesion;
                let contact = adhesion::contact_radius(overlap, radius, self.young, work);
                (contact, adhesion::force(contact, radius, self.young, work))
            }
            ForceLaw::HertzMindlin => {
                let contact = (radius * overlap).sqrt();
                (contact, 4.0 / 3.0 * self.young * contact * overlap)
            }
            ForceLaw::Hooke { normal, .. } => ((radius * overlap).sqrt(), normal * overlap),
        }
    }

    /// The forces of two bodies that touch, after a step, s. Continues their history.
    #[inline]
    pub(crate) fn push(&self, of: &Meeting, history: &mut ContactHistory, step: f64) -> Push {
        let normal = of.normal;
        let approach = -dot(of.velocity, normal);
        let (contact, elastic) = self.normal_force(of.overlap, of.radius);
        let stiffness = self.stiffness(contact);
        let dashpot = self.damping * (stiffness * of.mass).sqrt();
        let along = elastic + dashpot * approach;
        let along = if self.sticks() { along } else { along.max(0.0) };
        let pressed = if self.sticks() {
            elastic + 2.0 * adhesion::pull_off(of.radius, self.surfaces.adhesion)
        } else {
            along
        };
        let mut push = Push {
            force: times(along, normal),
            moment: [0.0; 3],
            dissipated: (along - elastic) * approach * step,
        };
        let stored = self.spring_energy(of.radius, history);
        let mut work = 0.0;
        let friction = self.surfaces.friction;
        if friction > 0.0 {
            let slip = across(of.velocity, normal);
            let force = self.tangential(of, history, (contact, friction * pressed), step);
            push.force = plus(push.force, force);
            work += step * dot(force, slip);
        }
        let rate = minus(of.spins[0], of.spins[1]);
        if self.surfaces.rolling_friction > 0.0 {
            push.moment = self.rolling(of, history, (contact, pressed), step);
        }
        if self.surfaces.twisting_friction > 0.0 {
            let moment = self.twisting(of, history, (contact, pressed), step);
            push.moment = plus(push.moment, times(moment, normal));
        }
        work += step * dot(push.moment, rate);
        history.contact = contact;
        push.dissipated -= work + self.spring_energy(of.radius, history) - stored;
        push
    }

    /// Energy of the springs across the normal, against rolling and against twisting, J.
    pub(crate) fn spring_energy(&self, radius: f64, history: &ContactHistory) -> f64 {
        let stored = |square: f64, stiffness: f64| if square > 0.0 { 0.5 * square / stiffness } else { 0.0 };
        let stiffness = |share: f64| self.rolling_stiffness(history.contact, radius, share);
        let across = dot(history.tangential, history.tangential);
        let rolling = dot(history.rolling, history.rolling);
        stored(across, self.tangential_stiffness(history.contact))
            + stored(rolling, stiffness(self.surfaces.rolling_friction))
            + stored(history.twisting * history.twisting, stiffness(self.surfaces.twisting_friction))
    }

    /// The force across the normal on the first body, at most that of friction, N.
    #[inline]
    fn tangential(
        &self,
        of: &Meeting,
        history: &mut ContactHistory,
        (contact, most): (f64, f64),
        step: f64,
    ) -> Vector {
        let slip = across(of.velocity, of.normal);
        let stiffness = self.tangential_stiffness(contact);
        let mut elastic = turned(history.tangential, of, step);
        if matches!(self.law, ForceLaw::HertzMindlin) && contact < history.contact {
            elastic = times(contact / history.contact, elastic);
        }
        elastic = minus(elastic, times(stiffness * step, slip));
        let dashpot = self.damping * (stiffness * of.mass).sqrt();
        let force = minus(elastic, times(dashpot, slip));
        let size = length(force);
        if size > most {
            // Sliding: the spring has the force of friction, and the dashpot none.
            let sliding = times(most / size, force);
            history.tangential = sliding;
            return sliding;
        }
        history.tangential = elastic;
        force
    }

    /// The moment against rolling on the first body, N m.
    fn rolling(
        &self,
        of: &Meeting,
        history: &mut ContactHistory,
        (contact, pressed): (f64, f64),
        step: f64,
    ) -> Vector {
        let coefficient = self.surfaces.rolling_friction;
        let stiffness = self.rolling_stiffness(contact, of.radius, coefficient);
        let rate = across(minus(of.spins[0], of.spins[1]), of.normal);
        let elastic = minus(turned(history.rolling, of, step), times(stiffness * step, rate));
        let (size, most) = (length(elastic), coefficient * of.radius * pressed.max(0.0));
        if size > most {
            history.rolling = times(most / size, elastic);
            return history.rolling;
        }
        history.rolling = elastic;
        let dashpot = 2.0 * self.surfaces.rolling_damping * (of.inertia() * stiffness).sqrt();
        minus(elastic, times(dashpot, rate))
    }

    /// The moment against twisting about the normal on the first body, N m.
    fn twisting(
        &self,
        of: &Meeting,
        history: &mut ContactHistory,
        (contact, pressed): (f64, f64),
        step: f64,
    ) -> f64 {
        let coefficient = self.surfaces.twisting_friction;
        let stiffness = self.rolling_stiffness(contact, of.radius, coefficient);
        let rate = dot(minus(of.spins[0], of.spins[1]), of.normal);
        let elastic = history.twisting - stiffness * step * rate;
        let most = coefficient * of.radius * pressed.max(0.0);
        history.twisting = elastic.clamp(-most, most);
        if elastic.abs() > most {
            return history.twisting;
        }
        let dashpot = 2.0 * self.surfaces.rolling_damping * (of.inertia() * stiffness).sqrt();
        elastic - dashpot * rate
    }

    /// Energy that is lost when the two part, J: that of springs which are not at rest, and, where they
    /// stick, that of the last pull.
    pub(crate) fn lost(&self, radius: f64, history: &ContactHistory) -> f64 {
        let work = self.surfaces.adhesion;
        let pull =
            if self.sticks() { adhesion::energy(history.contact, radius, self.young, work) } else { 0.0 };
        pull + self.spring_energy(radius, history)
    }

    /// Elastic energy of a contact, J: along the normal, and of all springs.
    pub(crate) fn energy(&self, overlap: f64, radius: f64, history: &ContactHistory) -> f64 {
        let along = match self.law {
            ForceLaw::HertzMindlin if self.sticks() => {
                adhesion::energy(history.contact, radius, self.young, self.surfaces.adhesion)
            }
            ForceLaw::HertzMindlin => 0.4 * self.normal_force(overlap.max(0.0), radius).1 * overlap,
            ForceLaw::Hooke { normal, .. } => 0.5 * normal * overlap * overlap,
        };
        along + self.spring_energy(radius, history)
    }
}

/// A vector across the normal that turns with the contact: into its plane, with its length, and about the
/// normal with the mean spin.
#[inline]
fn turned(vector: Vector, of: &Meeting, step: f64) -> Vector {
    let square = dot(vector, vector);
    if square == 0.0 {
        return vector;
    }
    let flat = across(vector, of.normal);
    let flat = times((square / dot(flat, flat).max(f64::MIN_POSITIVE)).sqrt(), flat);
    let spin = 0.5 * step * (dot(of.spins[0], of.normal) + dot(of.spins[1], of.normal));
    plus(flat, times(spin, cross(of.normal, flat)))
}
