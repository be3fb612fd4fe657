//! Uniform random centres.

use std::f64::consts::PI;

use crate::cloud::{Cloud, require_axes};
use crate::error::{Error, positive, reserved};
use crate::random::{CENTRES, Random};
use crate::sizes::Sizes;

/// A gas: centres drawn uniformly from a cube, dense enough for `neighbours` contacts per element.
///
/// The cube is `[0, L)^D` with `L` from [`gas_edge`]. Elements overlap freely. Spheres near a face have fewer
/// contacts, so a finite gas has slightly fewer than `neighbours`: fewer by the fraction `9/8 d/L` for
/// spheres of diameter `d` and `8/(3π) d/L` for discs, plus terms of higher order.
///
/// # Shapes
/// `n` centres and radii, in no spatial order.
///
/// # Units
/// The unit of `sizes`; `neighbours` is a number.
///
/// # Cost
/// Time and memory proportional to `n`.
///
/// # Errors
/// [`Error::OutOfRange`] if `neighbours` is not positive, or so small or so large that `L` is infinite or
/// zero; the errors of [`Sizes::radii`]; [`Error::OutOfMemory`].
///
/// # Example
/// ```
/// use fdem_scenes::{Sizes, gas};
///
/// let cloud = gas::<3>(1_000, 7, 12.0, Sizes::Lognormal { median: 0.5, sigma: 0.25 })?;
/// assert_eq!(cloud.centres.len(), cloud.radii.len());
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn gas<const D: usize>(n: usize, seed: u64, neighbours: f64, sizes: Sizes) -> Result<Cloud<D>, Error> {
    positive("number of neighbours", neighbours)?;
    let radii = sizes.radii(n, seed)?;
    if n == 0 {
        return Ok(Cloud { centres: Vec::new(), radii });
    }
    let edge = gas_edge::<D>(&radii, neighbours)?;
    let mut random = Random::with_stream(seed, CENTRES);
    let mut centres = reserved(n)?;
    centres.extend((0..n).map(|_| -> [f64; D] { std::array::from_fn(|_| edge * random.uniform()) }));
    Ok(Cloud { centres, radii })
}

/// Edge `L` of the cube in which a gas of these `radii` has `neighbours` contacts per element on average.
///
/// `n V / L^D = neighbours`, where `V` is the mean over all pairs `i ≠ j` of the volume `V_D(r_i + r_j)` of a
/// ball with radius `r_i + r_j`; for equal sizes `V = V_D(2 r)`. The mean is exact in any dimension: expanded
/// by the binomial theorem, `Σ (r_i + r_j)^D` is a sum of products of the moments `Σ r_i^k`. The effect of
/// faces is not included.
///
/// # Shapes
/// `radii` `[n]`, `n >= 1`.
///
/// # Units
/// The unit of `radii`.
///
/// # Errors
/// [`Error::OutOfRange`] if `neighbours` is not positive, if there are no `radii` or one of them is not
/// positive and finite, or if `L` is not.
///
/// # Example
/// ```
/// let edge = fdem_scenes::gas_edge::<2>(&[0.5; 100], std::f64::consts::PI)?;
/// assert!((edge - 10.0).abs() < 1e-12);
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn gas_edge<const D: usize>(radii: &[f64], neighbours: f64) -> Result<f64, Error> {
    edge_for::<D>(radii, radii.len(), neighbours)
}

/// The edge as in [`gas_edge`], for `n` elements whose sizes are distributed like `radii`.
pub(crate) fn edge_for<const D: usize>(radii: &[f64], n: usize, neighbours: f64) -> Result<f64, Error> {
    require_axes::<D>();
    positive("number of neighbours", neighbours)?;
    // Radii are measured in units of the largest, so that their powers neither overflow nor underflow.
    let mut unit = 0.0_f64;
    for &radius in radii {
        unit = unit.max(positive("radius", radius)?);
    }
    let volume = ball_volume(D) * mean_pair_power(radii, unit, D);
    positive("edge of the gas", unit * root::<D>(n as f64 * volume / neighbours))
}

/// Volume of the ball with radius 1 in `d` dimensions: `V_d = V_{d−2} 2π/d`.
fn ball_volume(d: usize) -> f64 {
    let mut volume = if d.is_multiple_of(2) { 1.0 } else { 2.0 };
    let mut axes = d % 2;
    while axes < d {
        axes += 2;
        volume *= 2.0 * PI / axes as f64;
    }
    volume
}

/// Mean of `((r_i + r_j)/unit)^d` over all pairs `i ≠ j`; over `i = j` if there is only one.
fn mean_pair_power(radii: &[f64], unit: f64, d: usize) -> f64 {
    let mut moments = vec![0.0; d + 1];
    for radius in radii {
        let mut power = 1.0;
        for moment in &mut moments {
            *moment += power;
            power *= radius / unit;
        }
    }
    let n = radii.len() as f64;
    let (mut ordered_pairs, mut binomial, mut two_to_d) = (0.0, 1.0, 1.0);
    for k in 0..=d {
        ordered_pairs += binomial * moments[k] * moments[d - k];
        binomial *= (d - k) as f64 / (k + 1) as f64;
        two_to_d *= if k == 0 { 1.0 } else { 2.0 };
    }
    let with_itself = two_to_d * moments[d];
    if radii.len() < 2 { with_itself } else { (ordered_pairs - with_itself) / (n * (n - 1.0)) }
}

/// `D`-th root.
pub(crate) fn root<const D: usize>(x: f64) -> f64 {
    match D {
        1 => x,
        2 => x.sqrt(),
        3 => libm::cbrt(x),
        _ => libm::pow(x, 1.0 / D as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

    fn n_contacts<const D: usize>(cloud: &Cloud<D>) -> usize {
        let mut count = 0;
        for i in 0..cloud.len() {
            for j in 0..i {
                let square: f64 = (0..D).map(|k| (cloud.centres[i][k] - cloud.centres[j][k]).powi(2)).sum();
                count += usize::from(square.sqrt() <= cloud.radii[i] + cloud.radii[j]);
            }
        }
        count
    }

    /// The probability that two points of a unit square or cube are within `t`, including the effect of
    /// faces, is a polynomial in `t`.
    #[test]
    fn equal_gas_has_the_contacts_asked_for() {
        let (n, neighbours) = (2_000, 12.0);
        let pairs = f64::from(n * (n - 1) / 2);
        for seed in 0..4 {
            let flat = gas::<2>(n as usize, seed, neighbours, EQUAL).unwrap();
            let t = 1.0 / gas_edge::<2>(&flat.radii, neighbours).unwrap();
            let expected = pairs * (PI * t.powi(2) - 8.0 / 3.0 * t.powi(3) + 0.5 * t.powi(4));
            let found = n_contacts(&flat) as f64;
            assert!((found / expected - 1.0).abs() < 0.05, "2D, seed {seed}: {found} for {expected}");

            let solid = gas::<3>(n as usize, seed, neighbours, EQUAL).unwrap();
            let t = 1.0 / gas_edge::<3>(&solid.radii, neighbours).unwrap();
            let expected = pairs
                * (4.0 / 3.0 * PI * t.powi(3) - 1.5 * PI * t.powi(4) + 1.6 * t.powi(5) - t.powi(6) / 6.0);
            let found = n_contacts(&solid) as f64;
            assert!((found / expected - 1.0).abs() < 0.05, "3D, seed {seed}: {found} for {expected}");
        }
    }

    /// In 3D the mean over pairs of `(1 − 9/8 d/L) d³`, `d = r_i + r_j`, is the leading term with the effect
    /// of faces.
    #[test]
    fn unequal_gas_has_the_contacts_asked_for() {
        let (n, neighbours) = (2_000, 6.0);
        for sizes in [
            Sizes::Lognormal { median: 1.0, sigma: 0.4 },
            Sizes::PowerLaw { min: 1.0, max: 8.0, exponent: -2.5 },
        ] {
            let cloud = gas::<3>(n, 21, neighbours, sizes).unwrap();
            let edge = gas_edge::<3>(&cloud.radii, neighbours).unwrap();
            let mut expected = 0.0;
            for i in 0..n {
                for j in 0..i {
                    let t = (cloud.radii[i] + cloud.radii[j]) / edge;
                    expected += 4.0 / 3.0 * PI * t.powi(3) - 1.5 * PI * t.powi(4) + 1.6 * t.powi(5);
                }
            }
            let found = n_contacts(&cloud) as f64;
            assert!((found / expected - 1.0).abs() < 0.06, "{sizes:?}: {found} for {expected}");
            assert!((expected * 2.0 / n as f64 / neighbours - 1.0).abs() < 0.2, "{sizes:?}: {expected}");
        }
    }

    #[test]
    fn edge_solves_its_formula() {
        let radii = [1.0, 2.0, 4.0];
        let mean = |d: i32| (3.0_f64.powi(d) + 5.0_f64.powi(d) + 6.0_f64.powi(d)) / 3.0;
        let close =
            |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
        close(gas_edge::<1>(&radii, 0.1).unwrap(), 3.0 * 2.0 * mean(1) / 0.1);
        close(gas_edge::<2>(&radii, 0.1).unwrap(), (3.0 * PI * mean(2) / 0.1).sqrt());
        close(gas_edge::<3>(&radii, 0.1).unwrap(), (3.0 * 4.0 / 3.0 * PI * mean(3) / 0.1).cbrt());
        close(gas_edge::<4>(&radii, 0.1).unwrap(), (3.0 * PI * PI / 2.0 * mean(4) / 0.1).powf(0.25));
        close(gas_edge::<3>(&[0.5], 4.0 / 3.0 * PI).unwrap(), 1.0);
        close(gas_edge::<3>(&[1e-200; 8], 4.0 / 3.0 * PI).unwrap(), 4e-200);
    }

    #[test]
    fn centres_fill_the_cube() {
        let cloud = gas::<3>(5_000, 22, 8.0, EQUAL).unwrap();
        let edge = gas_edge::<3>(&cloud.radii, 8.0).unwrap();
        for axis in 0..3 {
            let xs = || cloud.centres.iter().map(|c| c[axis] / edge);
            assert!(xs().all(|x| (0.0..1.0).contains(&x)));
            let mean = xs().sum::<f64>() / 5_000.0;
            assert!((mean - 0.5).abs() < 0.0205, "axis {axis}: {mean}");
            assert!(xs().fold(1.0, f64::min) < 0.002 && xs().fold(0.0, f64::max) > 0.998);
        }
    }

    #[test]
    fn none_and_one_are_fine() {
        assert!(gas::<3>(0, 1, 12.0, EQUAL).unwrap().is_empty());
        assert_eq!(gas::<2>(1, 1, 12.0, EQUAL).unwrap().len(), 1);
    }

    #[test]
    fn bad_parameters_are_refused() {
        for neighbours in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
            assert!(gas::<3>(10, 0, neighbours, EQUAL).is_err(), "{neighbours}");
        }
        assert!(gas::<3>(10, 0, 0.0, EQUAL).is_err() && gas::<3>(0, 0, 0.0, EQUAL).is_err());
        assert!(gas::<3>(0, 0, 1.0, Sizes::Equal { radius: -1.0 }).is_err());
        assert_eq!(gas::<3>(usize::MAX, 0, 1.0, EQUAL), Err(Error::OutOfMemory { n: usize::MAX }));
        assert!(gas_edge::<2>(&[], 1.0).is_err() && gas_edge::<2>(&[1.0, f64::NAN], 1.0).is_err());
    }
}
