//! Bounds of the use of strengths on any plane, by the stress of an element. Only edges whose two elements
//! may reach their strength are checked one by one.
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

/// Largest values over all planes of the two limits, Pa, for a tensile strength and for a cohesion. They may
/// be larger than the true ones by a part in a million, and in batches far from failure by more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    tension: f64,
    shear: f64,
}

impl Demand {
    /// A bound for the mean of two stresses: both limits are convex in the stress.
    #[inline]
    pub(crate) fn mean([one, two]: [Self; 2]) -> Self {
        Self { tension: 0.5 * (one.tension + two.tension), shear: 0.5 * (one.shear + two.shear) }
    }

    /// Whether an edge with these strengths, Pa, may reach this share of them. Any traction that does makes
    /// this true.
    #[inline(always)]
    #[allow(
        clippy::needless_bitwise_bool,
        reason = "a lazy operator is a branch, of which the compiler makes no vectors"
    )]
    pub(crate) fn reaches(self, share: f64, of: Weakest) -> bool {
        let share = share * (1.0 - ROUNDING);
        (self.tension >= share * of.tensile) | (self.shear >= share * of.cohesion)
    }

    /// The largest use of strengths on any plane, or more.
    pub(crate) fn most(self, of: Weakest) -> f64 {
        if of.tensile > 0.0 && of.cohesion > 0.0 {
            larger(self.tension / of.tensile, self.shear / of.cohesion) * (1.0 + ROUNDING)
        } else {
            f64::INFINITY
        }
    }
}

/// The demands of the elements of a batch.
#[derive(Clone, Debug)]
pub(crate) struct Demands {
    tension: Lanes,
    shear: Lanes,
}

impl Demands {
    pub(crate) const ZERO: Self = Self { tension: Lanes::ZERO, shear: Lanes::ZERO };

    #[inline]
    pub(crate) fn get(&self, lane: usize) -> Demand {
        Demand { tension: self.tension.get(lane), shear: self.shear.get(lane) }
    }
}

/// Lowest tensile strength and lowest cohesion of the edges of an element, Pa.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weakest {
    tensile: f64,
    cohesion: f64,
}

impl Weakest {
    /// Strengths that nothing reaches.
    pub(crate) const NONE: Self = Self { tensile: f64::INFINITY, cohesion: f64::INFINITY };

    /// The strengths of a facet; [`Weakest::NONE`] without one.
    pub(crate) fn of(strength: Option<Strength>) -> Self {
        strength.map_or(Self::NONE, |Strength { tensile, cohesion, .. }| Self { tensile, cohesion })
    }

    /// The lowest of these.
    pub(crate) fn least(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::NONE, |least, next| Self {
            tensile: least.tensile.min(next.tensile),
            cohesion: least.cohesion.min(next.cohesion),
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

    /// The demand of a stress, by the middle and the radius of Mohr's largest circle.
    #[inline(always)]
    pub(crate) fn demand(&self, [mean, radius]: [f64; 2]) -> Demand {
        let [one, other] = self.friction.map(|[friction, secant]| friction * mean + secant * radius);
        Demand { tension: mean + self.chord * radius, shear: larger(one, other) }
    }
}

/// Level of an element of which an edge may reach [`SUSPECT`], and of one of which an edge may fail; that of
/// others is 0.
pub(crate) const SUSPECTED: u8 = 1;
pub(crate) const FAILING: u8 = 2;

/// Computes the demands of a batch and the levels of its elements. Returns whether one of them is above 0.
pub(crate) fn find_demands<const D: usize, const N: usize>(
    available: Available,
    slopes: &Slopes,
    deformed: &Deformed<D>,
    weakest: &[Weakest; LANES],
    demands: &mut Demands,
    levels: &mut [u8; LANES],
) -> bool
where
    [[f64; D]; N]: Simplex<D, N>,
{
    demands_of::<D, N, false>(available, slopes, deformed, weakest, demands, levels);
    let most = levels.iter().fold(0, |most, &level| most.max(level));
    // In two dimensions the bound is the circle itself.
    if !<[[f64; D]; N]>::IS_TRIANGLE && most == FAILING {
        demands_of::<D, N, true>(available, slopes, deformed, weakest, demands, levels);
    }
    most > 0
}

compiled_for_vectors!(fn demands_of = all_demands<const D: usize, const N: usize, const CLOSE: bool>(
    slopes: &Slopes,
    deformed: &Deformed<D>,
    weakest: &[Weakest; LANES],
    demands: &mut Demands,
    levels: &mut [u8; LANES]
) where [[f64; D]; N]: Simplex<D, N>);

#[inline(always)]
fn all_demands<const D: usize, const N: usize, const CLOSE: bool>(
    slopes: &Slopes,
    deformed: &Deformed<D>,
    weakest: &[Weakest; LANES],
    demands: &mut Demands,
    levels: &mut [u8; LANES],
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        let stress = deformed.stress(lane);
        let circle = if CLOSE {
            <[[f64; D]; N]>::circle_close(&stress)
        } else {
            <[[f64; D]; N]>::circle_bound(&stress)
        };
        let demand = slopes.demand(circle);
        demands.tension.set(lane, demand.tension);
        demands.shear.set(lane, demand.shear);
        levels[lane] =
            u8::from(demand.reaches(SUSPECT, weakest[lane])) + u8::from(demand.reaches(1.0, weakest[lane]));
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

    /// The demand of a mean stress, and the mean of two demands, are at least the use of any edge.
    #[test]
    fn the_demand_bounds_the_use_on_any_plane() {
        let (strong, weak) = (strength(1.5, 0.2), strength(1.0, 0.7));
        let slopes = Slopes::of(&[strong, weak]);
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
            let demands =
                pair.map(|[xx, yy, xy]| slopes.demand(<[[f64; 2]; 3]>::circle(&[[xx, xy], [xy, yy]])));
            let mean = Demand::mean(demands);
            for strength in [strong, weak] {
                let used = use_of(&strength, [normal, tangential]);
                let of = Weakest::of(Some(strength));
                for share in [1.0, SUSPECT, used] {
                    let reached = used >= share && share > 0.0;
                    assert!(!reached || mean.reaches(share, of), "{pair:?} {share}");
                    let either = demands.iter().any(|demand| demand.reaches(share, of));
                    assert!(!reached || either, "{pair:?} {share}");
                }
                assert!(used == 0.0 || mean.most(of) >= used, "{pair:?}");
                failed += usize::from(used >= 1.0);
                suspected += usize::from((SUSPECT..1.0).contains(&used));
                near += usize::from(used < SUSPECT && mean.reaches(1.0, of));
                far += usize::from(!mean.reaches(SUSPECT, of));
            }
        }
        assert!([failed, suspected, near, far].into_iter().all(|count| count > 1000));
    }

    #[test]
    fn nothing_reaches_the_strength_of_what_cannot_break() {
        let demand = Slopes::of(&[strength(1.0, 0.5)]).demand([1e150; 2]);
        assert!(!demand.reaches(1.0, Weakest::NONE));
    }
}
