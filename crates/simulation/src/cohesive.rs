//! Traction-separation law of the joint between two elements.
//!
//! Combined single and smeared crack model (book, ch. 7): elastic up to the strength, then softening by z(D) (7.12). Opening (mode I) unloads towards the
//! origin. Sliding (mode II) is plastic, with the strength of Mohr and Coulomb,
//!
//! ```text
//! σ ≤ z(D) f_t,    |τ| ≤ z(D) c + σₙ tan φ    (σₙ: compression),
//! ```
//! so that the shear traction peaks at c + σₙ tan φ and ends at σₙ tan φ. The damage is D = `√(D_I² + D_II²)`: opening and sliding beyond the elastic range,
//! each over the value at which the fracture energy is dissipated. Compression does not break a joint, and a broken joint still transmits pressure and
//! friction.

use crate::model::{CriticalOpening, Strength};
use crate::potential::length;

/// Parameters of the softening curve (7.12), which the book fits to experiments.
const A: f64 = 0.63;
const B: f64 = 1.8;

/// ∫ z dD from 0 to 1.
pub(crate) const AREA: f64 = 0.386_307_294_743_943;

/// Critical opening and sliding of a joint without strength, over its length.
const OPEN: f64 = 1e-6;

/// Share of the strength that is left at damage `d`: 1 at 0, 0 at 1.
pub(crate) fn softening(d: f64) -> f64 {
    // Most joints are whole.
    if d == 0.0 {
        return 1.0;
    }
    let rest = 1.0 - d;
    if rest <= 0.0 {
        return 0.0;
    }
    // (a + c b) / ((a + b)(1 - a - b)) with c = 6.
    let rate = (A + 6.0 * B) / ((A + B) * (1.0 - A - B));
    let factor = 1.0 - (A + B - 1.0) / (A + B) * libm::exp(d * rate);
    let sixth = (rest * rest * rest) * (rest * rest * rest);
    factor * (A * rest + B * sixth)
}

/// Parameters of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Law {
    /// Penalty stiffness, Pa/m.
    pub(crate) penalty: f64,
    pub(crate) tensile: f64,
    pub(crate) cohesion: f64,
    /// Tangent of the friction angle.
    pub(crate) friction: f64,
    /// Opening and sliding beyond the elastic range at which the joint is broken, m.
    pub(crate) critical: [f64; 2],
}

impl Law {
    /// `elastic`: the work up to the strength counts as dissipated, as for intrinsic joints. Returns `None` if this work alone exceeds the fracture energy.
    /// `length`: length of the joint, m.
    ///
    /// A strength of 0 gives no critical length, so the joint takes that of the other strength. If both strengths are 0, the joint is open, with friction only:
    /// its critical length is a small share of its length.
    pub(crate) fn new(
        strength: &Strength,
        penalty: f64,
        opening: CriticalOpening,
        elastic: bool,
        length: f64,
    ) -> Option<Self> {
        let (tensile, cohesion) = (strength.tensile, strength.cohesion);
        let stored = if elastic { 0.5 * tensile * tensile / penalty } else { 0.0 };
        let both = match opening {
            CriticalOpening::Exact => {
                [(strength.energy_i - stored) / (AREA * tensile), strength.energy_ii / (AREA * cohesion)]
            }
            CriticalOpening::Customary => {
                [3.0 * strength.energy_i / tensile, 3.0 * strength.energy_ii / cohesion]
            }
        };
        let critical = match [tensile > 0.0, cohesion > 0.0] {
            [true, true] => both,
            [true, false] => [both[0]; 2],
            [false, true] => [both[1]; 2],
            [false, false] => [OPEN * length; 2],
        };
        let friction = strength.friction;
        (critical[0] > 0.0 && critical[1] > 0.0).then_some(Self {
            penalty,
            tensile,
            cohesion,
            friction,
            critical,
        })
    }
}

/// Whether a traction, normal (tension positive) and tangential, reaches a strength.
pub(crate) fn reaches(strength: &Strength, [normal, tangential]: [f64; 2]) -> bool {
    normal >= strength.tensile
        || tangential.abs() >= strength.cohesion + strength.friction * (-normal).max(0.0)
}

/// History of one end of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Memory {
    /// Largest opening beyond the elastic range, and total sliding beyond it, m.
    pub(crate) beyond: [f64; 2],
    /// Plastic sliding, m.
    pub(crate) slip: f64,
    /// Opening and sliding, m, that give the traction at insertion. They are added to the opening and sliding of the nodes.
    pub(crate) offset: [f64; 2],
}

impl Memory {
    /// History of a joint that is inserted where this traction acts: the joint begins with this traction, limited by its strength.
    pub(crate) fn under(law: &Law, traction: [f64; 2]) -> Self {
        let limit = law.cohesion + law.friction * (-traction[0]).max(0.0);
        let traction = [traction[0].min(law.tensile), traction[1].clamp(-limit, limit)];
        Self { offset: traction.map(|t| t / law.penalty), ..Self::default() }
    }

    /// Shares of opening and of sliding in the damage, 0 to 1 and beyond.
    pub(crate) fn modes(&self, law: &Law) -> [f64; 2] {
        [self.beyond[0] / law.critical[0], self.beyond[1] / law.critical[1]]
    }

    /// Damage from 0 (whole) to 1 (broken).
    pub(crate) fn damage(&self, law: &Law) -> f64 {
        // Most joints are whole.
        if self.beyond == [0.0; 2] {
            return 0.0;
        }
        let [opening, sliding] = self.modes(law);
        // Pure opening needs no square root.
        let damage = if sliding == 0.0 { opening } else { length([opening, sliding]) };
        damage.min(1.0)
    }

    /// Normal (tension positive) and tangential traction at this opening and sliding, Pa. Updates the history.
    pub(crate) fn traction(&mut self, law: &Law, opening: f64, sliding: f64) -> [f64; 2] {
        let (opening, sliding) = (opening + self.offset[0], sliding + self.offset[1]);
        let elastic = law.penalty * opening;
        if elastic > law.tensile {
            self.beyond[0] = self.beyond[0].max(opening - law.tensile / law.penalty);
        }
        let left = softening(self.damage(law));
        let normal = if opening <= 0.0 {
            elastic
        } else if self.beyond[0] == 0.0 {
            left * elastic
        } else {
            left * law.tensile * (opening / (law.tensile / law.penalty + self.beyond[0])).min(1.0)
        };
        let trial = law.penalty * (sliding - self.slip);
        let limit = left * law.cohesion + law.friction * (-normal).max(0.0);
        let tangential = trial.clamp(-limit, limit);
        if tangential != trial {
            let slip = (trial - tangential) / law.penalty;
            self.slip += slip;
            self.beyond[1] += slip.abs();
        }
        [normal, tangential]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROCK: Strength = Strength {
        tensile: 1e6,
        cohesion: 3e6,
        friction: 0.3,
        energy_i: 10.0,
        energy_ii: 50.0,
        weibull_modulus: None,
        seed: 0,
    };

    fn law(elastic: bool, opening: CriticalOpening) -> Law {
        Law::new(&ROCK, 1e13, opening, elastic, 1.0).expect("the energies are enough")
    }

    /// Work on a path of openings (`axis` 0) or slidings (`axis` 1), with the other component constant.
    fn work(law: &Law, memory: &mut Memory, axis: usize, path: impl Iterator<Item = f64>, other: f64) -> f64 {
        let (mut sum, mut last) = (0.0, None);
        for value in path {
            let (opening, sliding) = if axis == 0 { (value, other) } else { (other, value) };
            let traction = memory.traction(law, opening, sliding)[axis];
            if let Some((before, at)) = last {
                sum += 0.5 * (before + traction) * (value - at);
            }
            last = Some((traction, value));
        }
        sum
    }

    fn steps(from: f64, to: f64) -> impl Iterator<Item = f64> {
        (0..=100_000).map(move |k| from + (to - from) * f64::from(k) / 100_000.0)
    }

    #[test]
    fn the_curve_and_its_area() {
        assert!((softening(0.0) - 1.0).abs() < 1e-15);
        assert!((softening(0.1) - 0.878).abs() < 5e-4);
        assert!((softening(0.5) - 0.304).abs() < 5e-4);
        assert_eq!(softening(1.0), 0.0);
        let n = 1_000_000;
        let area: f64 = (0..n).map(|k| softening((f64::from(k) + 0.5) / f64::from(n)) / f64::from(n)).sum();
        assert!((area - AREA).abs() < 1e-12, "{area}");
        assert!((1..1000).all(|k| softening(f64::from(k) / 1000.0) < softening(f64::from(k - 1) / 1000.0)));
    }

    #[test]
    fn opening_dissipates_the_fracture_energy() {
        for elastic in [true, false] {
            let law = law(elastic, CriticalOpening::Exact);
            let mut memory =
                if elastic { Memory::default() } else { Memory::under(&law, [law.tensile, 0.0]) };
            let dissipated = work(&law, &mut memory, 0, steps(0.0, 4e-5), 0.0);
            assert!((dissipated / ROCK.energy_i - 1.0).abs() < 1e-5, "{elastic} {dissipated}");
            assert_eq!(memory.damage(&law), 1.0);
        }
        let law = law(false, CriticalOpening::Customary);
        let mut memory = Memory::under(&law, [law.tensile, 0.0]);
        let dissipated = work(&law, &mut memory, 0, steps(0.0, 4e-5), 0.0);
        assert!((dissipated / ROCK.energy_i - 3.0 * AREA).abs() < 1e-5);
    }

    #[test]
    fn sliding_peaks_at_cohesion_and_friction_and_ends_at_friction() {
        let law = law(true, CriticalOpening::Exact);
        let (pressure, mut memory) = (2e6, Memory::default());
        let closing = -pressure / law.penalty;
        let mut peak = 0.0_f64;
        for sliding in steps(0.0, 1e-4) {
            peak = peak.max(memory.traction(&law, closing, sliding)[1]);
        }
        assert!((peak / (3e6 + 0.3 * pressure) - 1.0).abs() < 1e-3, "{peak}");
        let residual = memory.traction(&law, closing, 1e-4)[1];
        assert!((residual / (0.3 * pressure) - 1.0).abs() < 1e-9, "{residual}");
        let mut memory = Memory::default();
        let all = work(&law, &mut memory, 1, steps(0.0, 1e-4), closing);
        // The work of friction and the energy stored at the end do not belong to the crack.
        let friction = 0.3 * pressure * (1e-4 - 0.5 * residual / law.penalty);
        assert!(((all - friction) / ROCK.energy_ii - 1.0).abs() < 3e-3, "{}", all - friction);
    }

    #[test]
    fn unloading_goes_to_the_origin_and_back() {
        let law = law(true, CriticalOpening::Exact);
        let mut memory = Memory::default();
        let far = law.tensile / law.penalty + 0.3 * law.critical[0];
        let at_far = memory.traction(&law, far, 0.0)[0];
        let damage = memory.damage(&law);
        assert!((memory.traction(&law, far / 2.0, 0.0)[0] / at_far - 0.5).abs() < 1e-12);
        assert_eq!(memory.traction(&law, 0.0, 0.0)[0], 0.0);
        assert_eq!(memory.traction(&law, -1e-7, 0.0)[0], -1e-7 * law.penalty);
        assert_eq!(memory.traction(&law, far, 0.0)[0], at_far);
        assert_eq!(memory.damage(&law), damage);
    }

    #[test]
    fn a_joint_put_in_under_load_begins_with_that_load() {
        let law = law(false, CriticalOpening::Exact);
        for traction in [[1e6, 0.0], [-4e6, 4.2e6], [0.5e6, -3e6]] {
            let found = Memory::under(&law, traction).traction(&law, 0.0, 0.0);
            for axis in 0..2 {
                assert!((found[axis] - traction[axis]).abs() < 1.0, "{traction:?} {found:?}");
            }
        }
    }

    #[test]
    fn an_open_joint_has_friction_and_nothing_else() {
        let open = Strength { tensile: 0.0, cohesion: 0.0, energy_i: 0.0, energy_ii: 0.0, ..ROCK };
        let law = Law::new(&open, 1e13, CriticalOpening::Exact, false, 0.1).expect("needs no energy");
        let mut memory = Memory::under(&law, [0.0; 2]);
        assert_eq!(memory.traction(&law, 1e-5, 1e-5), [0.0; 2]);
        assert_eq!(memory.damage(&law), 1.0);
        let [pressure, shear] = memory.traction(&law, -1e-6, 2e-5);
        assert_eq!(pressure, -1e7);
        assert!((shear - 0.3e7).abs() < 1e-6, "{shear}");
    }

    /// A joint without tensile strength still has its cohesion, and the other way round. Breaking in one mode breaks it in both.
    #[test]
    fn one_strength_may_be_zero() {
        let cohesive = Strength { tensile: 0.0, energy_i: 0.0, ..ROCK };
        let law = Law::new(&cohesive, 1e13, CriticalOpening::Exact, false, 0.1).expect("needs no energy");
        let mut memory = Memory::under(&law, [0.0; 2]);
        assert_eq!(memory.traction(&law, 0.0, 2e-7), [0.0, 2e6]);
        assert_eq!(memory.traction(&law, 1e-7, 2e-7)[0], 0.0);
        assert!(memory.damage(&law) > 0.0);
        memory.traction(&law, 1e-3, 0.0);
        assert_eq!(memory.damage(&law), 1.0);
        let tensile = Strength { cohesion: 0.0, energy_ii: 0.0, ..ROCK };
        let law = Law::new(&tensile, 1e13, CriticalOpening::Exact, true, 0.1).expect("needs no energy");
        let mut memory = Memory::default();
        assert_eq!(memory.traction(&law, 0.5e-7, 0.0), [0.5e6, 0.0]);
        assert_eq!(memory.traction(&law, 0.5e-7, 1e-8)[1], 0.0);
    }

    #[test]
    fn too_little_fracture_energy_is_refused() {
        let brittle = Strength { energy_i: 0.04, ..ROCK };
        assert_eq!(Law::new(&brittle, 1e13, CriticalOpening::Exact, true, 1.0), None);
        assert!(Law::new(&brittle, 1e13, CriticalOpening::Exact, false, 1.0).is_some());
    }
}
