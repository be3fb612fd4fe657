//! By how much the stress may change before a facet can fail: its slack. Facets are not looked at again
//! while the stresses beside them change by less.
//!
//! A facet fails by the mean traction of its two elements, `σ` normal and `τ` tangential, if `σ ≤ 0` and
//! `|τ| + µ σ ≥ c`, or if `σ > 0` and the traction is beyond the ellipse with the half axes `f_t` and `c`.
//! Every traction that fails reaches one of two lines: `|τ| + µ σ = c` and, where that line is beyond the
//! ellipse, the chord from their intersection to `(f_t, 0)`, `|τ| + m σ = m f_t`. If the stress changes by a
//! tensor of norm `δ`, each traction changes by at most `δ`. So the distance of a traction from the nearer
//! line bounds the change that it takes to fail.
//!
//! A facet also fails with a plane within `REACH` of it (`joints/plane.rs`). Over all planes, `f = |τ| + µ σ`
//! is at most `µ s + R √(1 + µ²)`, with the middle `s` and the radius `R` of Mohr's largest circle. Near a
//! facet it is less: on the circle, a plane at the angle `θ` is at `2 θ`, so that `f - µ s = R √(1 + µ²)
//! cos(ψ - 2 θ)` with `ψ` from the traction on the facet. That is a bound in space, too. Let the normal turn
//! by `dθ` towards `α` from the shear, `p` and `q` be half the sum and half the difference of the normal
//! stresses across the facet and along the shear, and `r² = τ² + q²`. Then `df = 2 (µ τ - q) cos α + τ_b sin
//! α`, with `(τ + µ q)² + (µ τ - q)² = (1 + µ²) r²` and `|p| ≤ R - r`. At `r = R` it is `2 √((1 + µ²) R² -
//! f²)` with `τ_b = 0`, as in the plane, and less for other `r`.

use crate::lanes::{larger, smaller};
use crate::model::Strength;
use crate::solid::watch::TURN;

/// A facet at a free surface or a crack tip is checked if the mean traction of its elements reaches this
/// share of its strength. The traction at the node exceeds that of the elements around it: by a factor
/// of 1.6 ahead of a crack, where stress is proportional to 1/√r, and by less elsewhere.
pub(super) const SUSPECT: f64 = 0.25;

/// Relative tolerance for rounding: the bounds are not computed by the same formulas as the tractions.
const ROUNDING: f64 = 1e-9;

/// Norm of the inverse of a deformation gradient from which on an element does not sleep.
pub(super) const MOST_SQUEEZED: f64 = 4.0;

/// Largest turn of a normal between two checks, in radians, with an inverse gradient of at most
/// [`MOST_SQUEEZED`]. Both elements of a facet may have changed since they were noted, and may change again.
pub(super) const NORMAL: f64 = 2.0 * MOST_SQUEEZED * TURN;

/// Largest change of a traction by such a turn, in the plane of `σ` and `τ`, over the norm of the stress: the
/// normal component changes by at most twice the turn, the tangential one by four times.
const TURNED: f64 = 4.5 * NORMAL;

/// The strengths of a facet as limits of its traction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    tensile: f64,
    cohesion: f64,
    friction: f64,
    /// `1/m` of the chord.
    flatness: f64,
    /// `√(1 + µ²)` and `√(1 + 1/m²)`.
    shear: f64,
    chord: f64,
}

impl Limits {
    /// The limits of a strength; `None` without a tensile strength or a cohesion.
    pub(super) fn of(strength: &Strength) -> Option<Self> {
        let Strength { tensile, cohesion, friction, .. } = *strength;
        let both = tensile > 0.0 && cohesion > 0.0;
        both.then(|| Self::new([tensile, cohesion, friction, flatness(strength)]))
    }

    /// From the strengths, Pa, the tangent of the friction angle, and `1/m`.
    #[inline(always)]
    pub(super) fn new([tensile, cohesion, friction, flatness]: [f64; 4]) -> Self {
        let [shear, chord] = [friction, flatness].map(|slope| (1.0 + slope * slope).sqrt());
        Self { tensile, cohesion, friction, flatness, shear, chord }
    }

    /// Distance, Pa, of a traction, across and along a facet, from the lines for this share of the strength;
    /// negative beyond them.
    #[inline(always)]
    fn distance(&self, share: f64, [across, along]: [f64; 2]) -> f64 {
        smaller(
            (share * self.cohesion - along - self.friction * across) / self.shear,
            (share * self.tensile - across - self.flatness * along) / self.chord,
        )
    }

    /// Bounds of the use of the strengths on planes within reach of a facet, by the chord and by the line.
    #[inline(always)]
    fn demands(&self, [across, along]: [f64; 2], [middle, radius]: [f64; 2]) -> [f64; 2] {
        let across = across - middle;
        let tension = middle + beside(across + self.flatness * along, self.chord * radius);
        let shear = self.friction * middle + beside(along + self.friction * across, self.shear * radius);
        [tension / self.tensile, shear / self.cohesion]
    }

    /// Growth of these bounds with the stress, 1/Pa.
    #[inline(always)]
    fn rises(&self) -> [f64; 2] {
        [self.chord / self.tensile, self.shear / self.cohesion]
    }

    /// The slack of a facet in whole material, Pa. `size`: norm of the mean stress, Pa. A facet whose own use
    /// is below a half does not fail with any plane.
    #[inline(always)]
    pub(super) fn slack(&self, traction: [f64; 2], circle: [f64; 2], size: f64) -> f64 {
        let ([tension, shear], [faster, pressed]) = (self.demands(traction, circle), self.rises());
        let near = smaller((1.0 - tension) / faster, (1.0 - shear) / pressed);
        self.after_turns(larger(near, self.distance(0.5, traction)), size)
    }

    /// The slack until the use of a facet reaches [`SUSPECT`].
    pub(super) fn until_suspect(&self, traction: [f64; 2], size: f64) -> f64 {
        self.after_turns(self.distance(SUSPECT, traction), size)
    }

    /// A slack less the share that changes of the shape and rounding may take.
    #[inline(always)]
    fn after_turns(&self, slack: f64, size: f64) -> f64 {
        let rounding = ROUNDING * (size + self.tensile + self.cohesion);
        slack - TURNED * (size + larger(slack, 0.0)) - rounding
    }

    /// The largest use of the strengths on planes within reach of a facet, or more.
    pub(super) fn most_used(&self, checked: &Checked) -> f64 {
        let [tension, shear] = self.demands(checked.traction, checked.circle);
        larger(tension, shear) * (1.0 + ROUNDING)
    }

    /// Largest growth of a use with the traction, 1/Pa: in compression, and anywhere.
    fn growth(&self) -> [f64; 2] {
        let pressed = self.shear / self.cohesion;
        [pressed, larger(pressed, 1.0 / self.tensile)]
    }
}

/// The result of a check of a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Checked {
    /// Use of its strength by `traction`.
    pub(super) used: f64,
    /// The mean traction of its two elements, across it and along it, Pa.
    pub(super) traction: [f64; 2],
    /// Middle and radius of Mohr's largest circle of their mean stress, Pa, or slightly more.
    pub(super) circle: [f64; 2],
    /// Change of their stresses, Pa, up to which it cannot fail in whole material; 0 or less if it may now.
    pub(super) slack: f64,
}

impl Checked {
    /// A facet that cannot get a joint.
    pub(super) const NEVER: Self =
        Self { used: 0.0, traction: [0.0; 2], circle: [0.0; 2], slack: f64::INFINITY };

    /// At least the norm of the mean stress, Pa.
    fn size(&self) -> f64 {
        3.0_f64.sqrt() * (self.circle[0].abs() + self.circle[1])
    }

    /// The slack until the use of this facet reaches [`SUSPECT`].
    pub(super) fn until_suspect(&self, limits: &Limits) -> f64 {
        limits.until_suspect(self.traction, self.size())
    }

    /// The slack until another facet is used more than this one.
    pub(super) fn until_overtaken(&self, own: &Limits, other: &Self, of_other: &Limits) -> f64 {
        let gap = self.used - other.used;
        let ([pressed, any], [pressed_other, any_other]) = (own.growth(), of_other.growth());
        let margin = (-self.traction[0]).min(-other.traction[0]);
        let slack = (gap / (pressed + pressed_other)).min(margin).max(gap / (any + any_other));
        own.after_turns(slack, self.size().max(other.size()))
    }
}

/// The traction that holds two groups of elements together at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    /// The use of the strength of the facet of the cut, and the traction across the cut and along it, Pa.
    pub(super) used: f64,
    pub(super) traction: [f64; 2],
    /// Change of the traction over that of the stresses around the vertex, and the change by changed shapes,
    /// Pa.
    pub(super) follows: f64,
    pub(super) turned: f64,
}

impl Held {
    /// The slack, Pa, of all stresses around the vertex until the cut may open. `facet`: the check of the
    /// facet that gives its plane.
    ///
    /// The cut opens if the use times the excess of a plane near the facet reaches 1. The excess is at most
    /// 2, and at most the largest use on a plane within reach over that on the facet.
    pub(super) fn slack(&self, facet: &Checked, limits: &Limits) -> f64 {
        let rounding = ROUNDING * (limits.tensile + limits.cohesion);
        let half = (limits.distance(0.5, self.traction) - self.turned - rounding) / self.follows;
        let own_turned = TURNED * facet.size() + rounding;
        // The slack with which a use grows by `growth`.
        let with = |growth: f64| {
            let (used, faster) = (self.used + growth * (self.turned + rounding), growth * self.follows);
            let own = facet.used - growth * own_turned;
            let root = |(demand, rises): (f64, f64)| {
                // (used + faster δ) (demand + rises δ) = own - growth δ
                let demand = larger(demand + rises * own_turned, 0.0) * (1.0 + ROUNDING);
                let (a, c) = (faster * rises, used * demand - own);
                let b = used * rises + faster * demand + growth;
                if c < 0.0 { -2.0 * c / (b + (b * b - 4.0 * a * c).sqrt()) } else { 0.0 }
            };
            let [tension, shear] = limits.demands(facet.traction, facet.circle);
            let [faster, pressed] = limits.rises();
            root((tension, faster)).min(root((shear, pressed)))
        };
        let [pressed, any] = limits.growth();
        let margin = ((-self.traction[0] - self.turned) / self.follows).min(-facet.traction[0] - own_turned);
        half.max(with(pressed).min(margin)).max(with(any))
    }
}

/// The largest `R √(1 + µ²) cos(ψ - 2 θ)` within `REACH`, from its value at `θ = 0`, `level`, and from
/// `R √(1 + µ²)`.
#[inline(always)]
fn beside(level: f64, most: f64) -> f64 {
    // sin and cos of twice the reach, 30 degrees.
    const TURN: [f64; 2] = [0.5, 0.866_025_403_784_438_6];
    let [sin, cos] = TURN;
    let turned = cos * level + sin * larger(most * most - level * level, 0.0).sqrt();
    if level >= cos * most { most } else { turned }
}

/// `1/m` of the chord of a strength; 0 where the line `|τ| + µ σ = c` is within the ellipse up to the axis:
/// there no chord is needed.
pub(super) fn flatness(strength: &Strength) -> f64 {
    let steepness = strength.friction * strength.tensile / strength.cohesion;
    if strength.tensile > 0.0 && steepness < 1.0 {
        let share = 2.0 * steepness / (1.0 + steepness * steepness);
        strength.tensile / strength.cohesion * (1.0 - share) / (1.0 - steepness * share)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cohesive::use_of;
    use crate::joints::plane::{REACH, breaks, plane_near};
    use crate::random;
    use crate::simplex::Simplex;
    use crate::vector::{
        Matrix, Point, applied, contraction, dot, length, matrix, minus, product, transposed, unit,
    };

    fn strength(tensile: f64, friction: f64) -> Strength {
        Strength {
            tensile,
            cohesion: 3.0,
            friction,
            energy_i: 1.0,
            energy_ii: 1.0,
            weibull_modulus: None,
            seed: 0,
        }
    }

    /// Random numbers from -1 to 1.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 += 1;
            2.0 * random::uniform(7, self.0) - 1.0
        }

        fn any<const D: usize>(&mut self, size: f64) -> Matrix<D> {
            std::array::from_fn(|_| std::array::from_fn(|_| size * self.next()))
        }

        fn symmetric<const D: usize>(&mut self, size: f64) -> Matrix<D> {
            let half = self.any::<D>(size);
            matrix(|i, k| half[i][k] + half[k][i])
        }

        /// A symmetric tensor of this norm.
        fn of_norm<const D: usize>(&mut self, norm: f64) -> Matrix<D> {
            let any = self.symmetric::<D>(1.0);
            let factor = norm / contraction(&any, &any).sqrt();
            any.map(|row| row.map(|x| factor * x))
        }
    }

    fn check<const D: usize, const N: usize>(
        facet: &[Point<D>; D],
        stress: &Matrix<D>,
        strength: &Strength,
    ) -> Checked
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let traction = <[[f64; D]; N]>::traction_on(facet, stress);
        let along = <[[f64; D]; N]>::sliding(&traction).abs();
        let (traction_of, circle) = ([traction[0], along], <[[f64; D]; N]>::circle_close(stress));
        let size = contraction(stress, stress).sqrt();
        let slack = Limits::of(strength).expect("strengths").slack(traction_of, circle, size);
        Checked { used: use_of(strength, traction), traction: traction_of, circle, slack }
    }

    fn moved<const D: usize>(facet: &[Point<D>; D], by: &Matrix<D>) -> [Point<D>; D] {
        facet.map(|point| std::array::from_fn(|i| point[i] + dot(by[i], point)))
    }

    /// With a change of stress below its slack, and a small one of its shape, no facet fails. Changes toward
    /// failure that are three times as large often fail.
    fn facets_do_not_fail_within_their_slack<const D: usize, const N: usize>()
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut numbers = Numbers(0);
        let (mut far, mut near, mut beyond) = (0, 0, 0);
        for k in 0..60_000 {
            let strength = [strength(1.5, 0.2), strength(1.0, 0.7), strength(2.9, 1.5)][k % 3];
            let facet: [Point<D>; D] = numbers.any(1.0);
            let stress: Matrix<D> = numbers.symmetric([0.1, 0.3, 0.6, 1.0, 2.0][k % 5]);
            let checked = check::<D, N>(&facet, &stress, &strength);
            if checked.slack <= 0.0 {
                continue;
            }
            let fails = |facet: &[Point<D>; D], stress: &Matrix<D>| {
                let used = use_of(&strength, <[[f64; D]; N]>::traction_on(facet, stress));
                breaks(used, || f64::INFINITY, || plane_near::<D, N>(facet, stress, &strength).excess)
            };
            // The same for a rotation, and along the gradient of the traction.
            for _ in 0..8 {
                let turn: Matrix<D> = numbers.any(2.0 * TURN / D as f64);
                let random: Matrix<D> = numbers.of_norm(0.999_999 * checked.slack);
                let axes = <[[f64; D]; N]>::unit_axes(&facet);
                let toward = [numbers.next(), numbers.next(), numbers.next()];
                let local: Matrix<D> = matrix(|i, k| {
                    if i == 0 {
                        toward[k]
                    } else if k == 0 {
                        toward[i]
                    } else {
                        0.0
                    }
                });
                let whole = product(&transposed(&axes), &product(&local, &axes));
                let norm = contraction(&whole, &whole).sqrt();
                for change in [random, whole.map(|row| row.map(|x| 0.999_999 * checked.slack / norm * x))] {
                    let at = |times: f64| matrix(|i, k| stress[i][k] + times * change[i][k]);
                    let facet = moved(&facet, &turn);
                    assert!(!fails(&facet, &at(1.0)), "{facet:?} {stress:?} {change:?} {checked:?}");
                    beyond += usize::from(fails(&facet, &at(3.0)));
                }
            }
            far += usize::from(checked.used < 0.5);
            near += usize::from(checked.used > 0.8);
        }
        assert!(far > 1000 && near > 50 && beyond > 1000, "{far} {near} {beyond}");
    }

    #[test]
    fn edges_do_not_fail_within_their_slack() {
        facets_do_not_fail_within_their_slack::<2, 3>();
    }

    #[test]
    fn faces_do_not_fail_within_their_slack() {
        facets_do_not_fail_within_their_slack::<3, 4>();
    }

    /// No plane within reach of a facet uses the strengths more than the bounds say, and some nearly as much.
    #[test]
    fn planes_within_reach_keep_to_the_bounds() {
        let mut numbers = Numbers(3);
        let mut closest = 0.0_f64;
        for k in 0..20_000 {
            let strength = [strength(1.5, 0.2), strength(1.0, 0.7), strength(2.9, 1.5)][k % 3];
            let limits = Limits::of(&strength).expect("strengths");
            let stress: Matrix<3> = numbers.symmetric(1.0);
            let normal = unit(numbers.any::<3>(1.0)[0]);
            let on = |normal: Point<3>| -> [f64; 2] {
                let whole = applied(&stress, normal);
                let across = dot(whole, normal);
                [across, length(minus(whole, normal.map(|x| across * x)))]
            };
            let bounds = limits.demands(on(normal), <[[f64; 3]; 4]>::circle(&stress));
            let uses = |turned: Point<3>| {
                let [across, along] = on(turned);
                [
                    (across + limits.flatness * along) / limits.tensile,
                    (along + limits.friction * across) / limits.cohesion,
                ]
            };
            // The steepest plane within the cone, by steps that shrink.
            for limit in 0..2 {
                let (mut best, mut step) = (normal, 0.2);
                for _ in 0..60 {
                    let any = numbers.any::<3>(step)[0];
                    let next = unit(std::array::from_fn(|i| best[i] + any[i]));
                    let within = dot(next, normal) >= REACH.cos();
                    if within && uses(next)[limit] > uses(best)[limit] {
                        best = next;
                    } else {
                        step *= 0.93;
                    }
                }
                let (used, bound) = (uses(best)[limit], bounds[limit]);
                assert!(used <= bound + 1e-12 * bound.abs(), "{stress:?} {normal:?}: {used} {bound}");
                if bound > 0.0 {
                    closest = closest.max(used / bound);
                }
            }
        }
        assert!(closest > 0.999, "{closest}");
    }

    /// A cut does not open, and the facet that is used most stays the same, while stresses change by less
    /// than the slack; the traction across the cut follows as fast as it may.
    #[test]
    fn cuts_do_not_open_within_their_slack() {
        let mut numbers = Numbers(1);
        let (mut some, mut beyond, mut overtaken) = (0, 0, 0);
        for k in 0..60_000 {
            let strength = [strength(1.5, 0.2), strength(1.0, 0.7)][k % 2];
            let limits = Limits::of(&strength).expect("strengths");
            let facets: [[Point<3>; 3]; 2] = [numbers.any(1.0), numbers.any(1.0)];
            let stress: Matrix<3> = numbers.symmetric([0.3, 0.6, 1.0, 2.0][k % 4]);
            let checked = facets.map(|facet| check::<3, 4>(&facet, &stress, &strength));
            let factor = 1.0 + 0.3 * numbers.next();
            let traction = <[[f64; 3]; 4]>::traction_on(&facets[0], &stress).map(|x| factor * x);
            let opens = |traction: [f64; 3], stress: &Matrix<3>| {
                let excess = || plane_near::<3, 4>(&facets[0], stress, &strength).excess;
                breaks(use_of(&strength, traction), || f64::INFINITY, excess)
            };
            let [across, one, other] = traction;
            let (follows, used) = (2.0 + numbers.next(), use_of(&strength, traction));
            let held = Held { used, traction: [across, one.hypot(other)], follows, turned: 0.0 };
            let slack = held.slack(&checked[0], &limits);
            let until = checked[0].until_overtaken(&limits, &checked[1], &limits);
            for _ in 0..8 {
                let direction: [f64; 3] = std::array::from_fn(|_| numbers.next());
                let long = dot(direction, direction).sqrt();
                for (slack, times) in [(slack, 1.0), (slack, 3.0), (until, 1.0)] {
                    if slack <= 0.0 || !slack.is_finite() {
                        continue;
                    }
                    let size = 0.999_999 * times * slack;
                    let change: Matrix<3> = numbers.of_norm(size);
                    let stress = matrix(|i, k| stress[i][k] + change[i][k]);
                    let traction =
                        std::array::from_fn(|i| traction[i] + follows * size / long * direction[i]);
                    if times > 1.0 {
                        beyond += usize::from(opens(traction, &stress));
                        continue;
                    }
                    some += 1;
                    if slack == until {
                        let [own, other] = facets.map(|facet| check::<3, 4>(&facet, &stress, &strength).used);
                        assert!(own >= other, "{facets:?} {stress:?} {change:?}");
                        overtaken += 1;
                    } else {
                        assert!(!opens(traction, &stress), "{facets:?} {stress:?} {change:?} {traction:?}");
                    }
                }
            }
        }
        assert!(some > 10_000 && beyond > 1000 && overtaken > 1000, "{some} {beyond} {overtaken}");
    }

    #[test]
    fn the_use_of_a_facet_that_nobody_suspects_stays_low() {
        let mut numbers = Numbers(2);
        let mut some = 0;
        for _ in 0..20_000 {
            let strength = strength(1.5, 0.5);
            let limits = Limits::of(&strength).expect("strengths");
            let facet: [Point<3>; 3] = numbers.any(1.0);
            let stress: Matrix<3> = numbers.symmetric(0.2);
            let slack = check::<3, 4>(&facet, &stress, &strength).until_suspect(&limits);
            if slack > 0.0 {
                let change: Matrix<3> = numbers.of_norm(0.999_999 * slack);
                let stress = matrix(|i, k| stress[i][k] + change[i][k]);
                assert!(use_of(&strength, <[[f64; 3]; 4]>::traction_on(&facet, &stress)) < SUSPECT);
                some += 1;
            }
        }
        assert!(some > 1000);
    }
}
