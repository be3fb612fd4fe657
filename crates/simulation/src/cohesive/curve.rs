//! The softening curve, and the energy dissipated along it.

/// Parameters of the softening curve (7.12), which the book fits to experiments.
const A: f64 = 0.63;
const B: f64 = 1.8;

/// ∫ z dD from 0 to 1.
pub(crate) const AREA: f64 = 0.386_307_294_743_943;

/// Share of the strength that is left at damage `d`: 1 at 0, 0 at 1. There is no branch, so that many joints
/// can be computed side by side. Twin: `crates/gpu/kernels/joints.h`.
#[inline(always)]
pub(crate) fn softening(d: f64) -> f64 {
    let rest = 1.0 - d;
    // (a + c b) / ((a + b)(1 - a - b)) with c = 6.
    let rate = (A + 6.0 * B) / ((A + B) * (1.0 - A - B));
    let factor = 1.0 - (A + B - 1.0) / (A + B) * exp_down(d * rate);
    let sixth = (rest * rest * rest) * (rest * rest * rest);
    let left = factor * (A * rest + B * sixth);
    let left = if rest <= 0.0 { 0.0 } else { left };
    if d == 0.0 { 1.0 } else { left }
}

/// exp(x) for x from -3.8 to 0, without a branch, with the bits of `libm::exp`.
///
/// x = k ln 2 + r with |r| about ln 2 / 2 at most, and exp r from a rational function of r; the method and
/// the constants are those of FDLIBM (Sun Microsystems, 1993, `e_exp.c`).
#[inline(always)]
fn exp_down(x: f64) -> f64 {
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    const P: [f64; 5] = [
        1.666_666_666_666_660_2e-1,
        -2.777_777_777_701_559_3e-3,
        6.613_756_321_437_934e-5,
        -1.653_390_220_546_525_2e-6,
        4.138_136_797_057_238_5e-8,
    ];
    // The largest |x| that is not reduced, somewhat above ln 2 / 2, and the least that counts.
    const REDUCED: f64 = f64::from_bits(0x3fd6_2e43_0000_0000);
    const TINY: f64 = f64::from_bits(0x3e30_0001_0000_0000);
    let turns = std::f64::consts::LOG2_E * x - 0.5;
    let (mut k, mut power) = (0.0, 1.0);
    for n in 1..6 {
        let passed = if n == 1 { x <= -REDUCED } else { turns <= -f64::from(n) };
        k -= if passed { 1.0 } else { 0.0 };
        power *= if passed { 0.5 } else { 1.0 };
    }
    let (high, low) = (x - k * LN_2[0], k * LN_2[1]);
    let r = high - low;
    let square = r * r;
    let c = r - square * (P[0] + square * (P[1] + square * (P[2] + square * (P[3] + square * P[4]))));
    let value = 1.0 + (r * c / (2.0 - c) - low + high);
    power * if x > -TINY { 1.0 + x } else { value }
}

/// Share of the fracture energy that is dissipated at damage `d`: the work until then, less the energy that
/// the bond, which unloads towards its origin, gives back. The elastic range is left out.
pub(crate) fn dissipated_at(d: f64) -> f64 {
    if d <= 0.0 || d >= 1.0 {
        return d.clamp(0.0, 1.0);
    }
    // Simpson's rule: the curve is smooth, and the error below 1e-5.
    let (intervals, width) = (16, d / 16.0);
    let weight = |k: u32| if k == 0 || k == intervals { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    let sum: f64 = (0..=intervals).map(|k| weight(k) * softening(f64::from(k) * width)).sum();
    (sum * width / 3.0 - 0.5 * d * softening(d)) / AREA
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bits on a fine grid, and about the ends of the intervals of the reduction.
    #[test]
    fn the_exponential_has_the_bits_of_libm() {
        let ends = (0..=7).map(|half| -0.5 * f64::from(half) * std::f64::consts::LN_2);
        let near = ends.flat_map(|end| (-2000..2000_i64).map(move |ulps| (end, ulps)));
        let near = near.map(|(end, ulps)| -f64::from_bits((-end).to_bits().wrapping_add_signed(ulps)));
        let coarse = (0..4000).map(|k| -f64::from_bits(0x3e20_0000_0000_0000 + (k << 42)));
        let special =
            [0.0, -0.0, -f64::from_bits(0x3ff0_a2b2_0000_0000), -f64::from_bits(0x3fd6_2e42_ffff_ffff)];
        let grid = (0..1_000_000).map(|k| -3.8 * f64::from(k) / 1e6);
        for x in near.chain(coarse).chain(special).chain(grid).filter(|x| (-3.8..=0.0).contains(x)) {
            assert_eq!(exp_down(x).to_bits(), libm::exp(x).to_bits(), "{x:e}");
        }
    }
}
