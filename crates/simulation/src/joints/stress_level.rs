//! Finds the elements whose stress is near the strength of their edges in any direction. Only the edges of
//! these elements are checked one by one.
//!
//! An edge fails by the mean traction of its two elements, `σ` normal and `τ` tangential, if `σ ≤ 0` and
//! `|τ| + µ σ ≥ c`, or if `σ > 0` and the traction is beyond the ellipse with the half axes `f_t` and `c`.
//! The mean reaches a limit that is convex in the traction only if one of the two elements reaches it. Such
//! limits, of which every traction that fails reaches one, are `|τ| + µ σ ≥ c` and, where that line is beyond
//! the ellipse, the chord from their intersection to `(f_t, 0)`: `|τ| + m σ ≥ m f_t`. The largest value of
//! `|τ| + µ σ` over all directions is `µ s + R √(1 + µ²)`, with the mean stress `s` and the radius `R` of
//! Mohr's circle.

use crate::lanes::{Available, LANES, Lanes, compiled_for_vectors, larger};
use crate::model::Strength;
use crate::simplex::Simplex;
use crate::solid::batch::Deformed;

/// Edges at a free surface or a crack tip are checked if the mean traction of their elements reaches this
/// share of their strength. The traction at the node exceeds that of the elements around it: by a factor
/// of 1.6 ahead of a crack, where stress is proportional to 1/√r, and by less elsewhere.
pub(crate) const SUSPECT: f64 = 0.25;

/// Relative tolerance for rounding: the bounds are not computed by the same formulas as the tractions.
const ROUNDING: f64 = 1e-9;

/// The distance of an element's stress from the strength of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum StressLevel {
    Far,
    /// An edge may reach [`SUSPECT`].
    Suspect,
    /// An edge may fail.
    Failing,
}

/// Lowest tensile strength and lowest cohesion of the edges of an element, Pa.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weakest {
    tensile: f64,
    cohesion: f64,
}

impl Weakest {
    /// The weakest of the given strengths, or infinity without any.
    pub(crate) fn of(strengths: impl Iterator<Item = Strength>) -> Self {
        let none = Self { tensile: f64::INFINITY, cohesion: f64::INFINITY };
        strengths.fold(none, |weakest, strength| Self {
            tensile: weakest.tensile.min(strength.tensile),
            cohesion: weakest.cohesion.min(strength.cohesion),
        })
    }
}

/// The slopes of the limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slopes {
    /// The smallest and the largest tangent µ of the angle of internal friction, each with `√(1 + µ²)`. The
    /// bound for shear is convex in µ, so it is largest at one of the two.
    friction: [[f64; 2]; 2],
    /// `√(1 + 1/m²)` of the flattest chord: the bound for tension falls with m.
    chord: f64,
}

impl Slopes {
    /// The slopes of all strengths of a model.
    pub(crate) fn of(strengths: &[Strength]) -> Self {
        let all = strengths.iter().map(|strength| strength.friction);
        let ends = [all.clone().fold(f64::INFINITY, f64::min), all.fold(0.0, f64::max)];
        let flattest = strengths.iter().map(chord).fold(f64::INFINITY, f64::min);
        Self {
            friction: ends.map(|friction| [friction, (1.0 + friction * friction).sqrt()]),
            chord: (1.0 + 1.0 / (flattest * flattest)).sqrt(),
        }
    }

    /// Compares a stress, by the middle and the radius of Mohr's largest circle, with the strengths of an
    /// element's edges.
    #[inline]
    pub(crate) fn near(&self, weakest: Weakest, circle: [f64; 2]) -> StressLevel {
        StressLevel::of(self.level(weakest, circle))
    }

    /// 2 if an edge may fail, 1 if it may reach [`SUSPECT`], else 0.
    #[inline(always)]
    #[allow(
        clippy::needless_bitwise_bool,
        reason = "a lazy operator is a branch, of which the compiler makes no vectors"
    )]
    fn level(&self, weakest: Weakest, [mean, radius]: [f64; 2]) -> f64 {
        let [one, other] = self.friction.map(|[friction, secant]| friction * mean + secant * radius);
        let (tension, shear) = (mean + self.chord * radius, larger(one, other));
        let reaches = |share: f64| (tension >= share * weakest.tensile) | (shear >= share * weakest.cohesion);
        let suspect = if reaches(SUSPECT - ROUNDING) { 1.0 } else { 0.0 };
        if reaches(1.0 - ROUNDING) { 2.0 } else { suspect }
    }
}

impl StressLevel {
    #[inline]
    fn of(level: f64) -> Self {
        if level >= 2.0 {
            Self::Failing
        } else if level >= 1.0 {
            Self::Suspect
        } else {
            Self::Far
        }
    }
}

/// Compares the stresses of a batch, by bounds of Mohr's circles, with the strengths.
pub(crate) fn nears<const D: usize, const N: usize>(
    available: Available,
    slopes: &Slopes,
    deformed: &Deformed<D>,
    weakest: &[Weakest; LANES],
    near: &mut [StressLevel],
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut levels = Lanes::ZERO;
    levels_of::<D, N>(available, slopes, deformed, weakest, &mut levels);
    for (lane, near) in near.iter_mut().enumerate() {
        *near = StressLevel::of(levels.get(lane));
    }
}

compiled_for_vectors!(fn levels_of = all_levels<const D: usize, const N: usize>(
    slopes: &Slopes,
    deformed: &Deformed<D>,
    weakest: &[Weakest; LANES],
    levels: &mut Lanes
) where [[f64; D]; N]: Simplex<D, N>);

#[inline(always)]
fn all_levels<const D: usize, const N: usize>(
    slopes: &Slopes,
    deformed: &Deformed<D>,
    weakest: &[Weakest; LANES],
    levels: &mut Lanes,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        let circle = <[[f64; D]; N]>::circle_bound(&deformed.stress(lane));
        levels.set(lane, slopes.level(weakest[lane], circle));
    }
}

/// Slope m of the chord of a strength. Infinite where the line `|τ| + µ σ = c` is within the ellipse up to
/// the axis: there no chord is needed.
fn chord(strength: &Strength) -> f64 {
    let steepness = strength.friction * strength.tensile / strength.cohesion;
    if strength.tensile > 0.0 && steepness < 1.0 {
        let share = 2.0 * steepness / (1.0 + steepness * steepness);
        strength.cohesion / strength.tensile * (1.0 - steepness * share) / (1.0 - share)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cohesive::use_of;
    use crate::random;

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

    /// Every edge that fails by the mean of two stresses is found, and so is every edge that reaches
    /// [`SUSPECT`] of its strength.
    #[test]
    fn what_the_mean_of_two_elements_reaches_one_of_them_reaches() {
        let (strong, weak) = (strength(1.5, 0.2), strength(1.0, 0.7));
        let (weakest, slopes) = (Weakest::of([strong, weak].into_iter()), Slopes::of(&[strong, weak]));
        let mut next = (0..).map(|k| 2.0 * random::uniform(7, k) - 1.0);
        let mut random = |scale: f64| scale * next.next().unwrap_or(0.0);
        let (mut failed, mut suspected, mut near, mut far) = (0, 0, 0, 0);
        for k in 0..200_000 {
            let size = [0.3, 1.0, 3.0, 10.0][k % 4];
            let pair: [[f64; 3]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| random(size)));
            let [xx, yy, xy]: [f64; 3] = std::array::from_fn(|i| 0.5 * (pair[0][i] + pair[1][i]));
            let (sin, cos) = random(4.0).sin_cos();
            let normal = xx * sin * sin - 2.0 * xy * sin * cos + yy * cos * cos;
            let tangential = (xx - yy) * sin * cos + xy * (sin * sin - cos * cos);
            let found = pair
                .map(|[xx, yy, xy]| slopes.near(weakest, <[[f64; 2]; 3]>::circle(&[[xx, xy], [xy, yy]])))
                .into_iter()
                .max();
            let share = |share: f64| {
                let used = |strength| use_of(strength, [normal, tangential]);
                used(&strong) >= share || used(&weak) >= share
            };
            if share(1.0) {
                failed += 1;
                assert_eq!(found, Some(StressLevel::Failing), "{pair:?}");
            } else if share(SUSPECT) {
                suspected += 1;
                assert!(found >= Some(StressLevel::Suspect), "{pair:?}");
            }
            near += usize::from(found == Some(StressLevel::Suspect));
            far += usize::from(found == Some(StressLevel::Far));
        }
        assert!([failed, suspected, near, far].into_iter().all(|count| count > 1000));
    }

    #[test]
    fn nothing_reaches_what_cannot_break() {
        assert_eq!(
            Slopes::of(&[strength(1.0, 0.5)]).near(Weakest::of([].into_iter()), [1e150; 2]),
            StressLevel::Far
        );
    }
}
