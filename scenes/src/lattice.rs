//! Square and cubic grids.

use crate::cloud::{Cloud, require_axes};
use crate::error::{Error, not_negative, positive, reserved};
use crate::random::{CENTRES, Random};
use crate::sizes::Sizes;

/// A square (`D = 2`) or cubic (`D = 3`) lattice of equal elements.
///
/// With `k` the smallest number for which `k^D >= n`, elements fill the `k^D` grid row by row, `x` fastest;
/// the last rows may be incomplete. Coordinates are whole multiples of the spacing, each rounded once. With
/// `spacing` 1 and a diameter that is a power of two, neighbours touch exactly.
///
/// # Shapes
/// `n` centres and radii, in grid order.
///
/// # Units
/// The unit of `radius`; `spacing` counts diameters.
///
/// # Cost
/// Time and memory proportional to `n`.
///
/// # Errors
/// [`Error::OutOfRange`] if `spacing`, `radius` or the edge of the lattice is not positive and finite;
/// [`Error::OutOfMemory`].
///
/// # Example
/// ```
/// let cloud = fdem_scenes::lattice::<2>(5, 1.5, 1.0)?;
/// assert_eq!(cloud.centres, [[0.0, 0.0], [3.0, 0.0], [6.0, 0.0], [0.0, 3.0], [3.0, 3.0]]);
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn lattice<const D: usize>(n: usize, spacing: f64, radius: f64) -> Result<Cloud<D>, Error> {
    positive("spacing", spacing)?;
    let sizes = Sizes::Equal { radius };
    let radii = sizes.radii(n, 0)?;
    let step = spacing * sizes.mean_diameter(&radii)?;
    positive("edge of the lattice", step * side::<D>(n).max(1) as f64)?;
    let centres = fill::<D>(n, |cell| cell.map(|i| i as f64 * step))?;
    Ok(Cloud { centres, radii })
}

/// A [`lattice`] whose elements are moved at random and may differ in size.
///
/// Every coordinate moves by a uniformly random amount of at most `jitter` spacings in either direction;
/// at 0.5, neighbouring elements can just meet.
///
/// # Shapes
/// `n` centres and radii, in grid order.
///
/// # Units
/// The unit of `sizes`; `spacing` counts mean diameters, that is twice the mean of the drawn radii; `jitter`
/// counts spacings.
///
/// # Cost
/// Time and memory proportional to `n`.
///
/// # Errors
/// The errors of [`lattice`] and [`Sizes::radii`]; [`Error::OutOfRange`] if `jitter` is negative or not
/// finite.
pub fn jittered_lattice<const D: usize>(
    n: usize,
    seed: u64,
    spacing: f64,
    jitter: f64,
    sizes: Sizes,
) -> Result<Cloud<D>, Error> {
    positive("spacing", spacing)?;
    not_negative("jitter", jitter)?;
    let radii = sizes.radii(n, seed)?;
    if n == 0 {
        return Ok(Cloud { centres: Vec::new(), radii });
    }
    let step = spacing * sizes.mean_diameter(&radii)?;
    let reach = jitter * step;
    positive("edge of the lattice", step * side::<D>(n) as f64 + 2.0 * reach)?;
    let mut random = Random::with_stream(seed, CENTRES);
    let centres = fill::<D>(n, |cell| cell.map(|i| i as f64 * step + random.between(-reach, reach)))?;
    Ok(Cloud { centres, radii })
}

/// Smallest `k` with `k^D >= n`.
pub(crate) fn side<const D: usize>(n: usize) -> usize {
    require_axes::<D>();
    let holds =
        |k: usize| (0..D).try_fold(1_usize, |product, _| product.checked_mul(k)).is_none_or(|all| all >= n);
    // The rounded root is off by at most one; the loops correct that.
    let mut k = libm::pow(n as f64, 1.0 / D as f64) as usize;
    while !holds(k) {
        k += 1;
    }
    while k > 0 && holds(k - 1) {
        k -= 1;
    }
    k
}

/// Places `n` elements into the cells of a grid of `side::<D>(n)` cells per axis, first axis fastest.
pub(crate) fn fill<const D: usize>(
    n: usize,
    mut centre: impl FnMut([usize; D]) -> [f64; D],
) -> Result<Vec<[f64; D]>, Error> {
    let side = side::<D>(n);
    let mut centres = reserved(n)?;
    let mut cell = [0; D];
    for _ in 0..n {
        centres.push(centre(cell));
        for i in &mut cell {
            *i += 1;
            if *i < side {
                break;
            }
            *i = 0;
        }
    }
    Ok(centres)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn side_is_the_rounded_up_root() {
        for k in 1_usize..200 {
            assert_eq!([side::<1>(k), side::<2>(k * k), side::<3>(k.pow(3)), side::<4>(k.pow(4))], [k; 4]);
            assert_eq!([side::<2>(k * k + 1), side::<3>(k.pow(3) + 1)], [k + 1; 2]);
        }
        assert_eq!([side::<2>(0), side::<3>(1), side::<3>(50_000_000)], [0, 1, 369]);
        assert_eq!(side::<2>(usize::MAX), 1 << (usize::BITS / 2));
        // This number rounds up when it is converted to a float.
        assert_eq!(side::<1>(usize::MAX >> 1), usize::MAX >> 1);
    }

    #[test]
    fn spacing_is_exact() {
        let cloud = lattice::<3>(30, 1.25, 0.5).unwrap();
        // There are 4^3 = 64 cells; the last rows are empty.
        for (e, centre) in cloud.centres.iter().enumerate() {
            assert_eq!(*centre, [e % 4, e / 4 % 4, e / 16].map(|i| i as f64 * 1.25));
        }
        assert_eq!(cloud.radii, [0.5; 30]);
    }

    #[test]
    fn jitter_is_bounded_and_used() {
        let (spacing, jitter) = (1.5, 0.25);
        let sizes = Sizes::Equal { radius: 1.0 };
        let still = lattice::<2>(400, spacing, 1.0).unwrap();
        let moved = jittered_lattice::<2>(400, 5, spacing, jitter, sizes).unwrap();
        let shifts: Vec<f64> =
            still.centres.iter().zip(&moved.centres).flat_map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        assert!(shifts.iter().all(|s| s.abs() <= 0.75 + 1e-12));
        assert!(shifts.iter().any(|&s| s > 0.7) && shifts.iter().any(|&s| s < -0.7));
        let mean = shifts.iter().sum::<f64>() / 800.0;
        assert!(mean.abs() < 0.077, "{mean}");
        assert_eq!(jittered_lattice::<2>(400, 5, spacing, 0.0, sizes).unwrap(), still);
    }

    #[test]
    fn unequal_spacing_counts_the_mean_diameter() {
        let sizes = Sizes::Lognormal { median: 1.0, sigma: 0.3 };
        let cloud = jittered_lattice::<2>(4, 6, 2.0, 0.0, sizes).unwrap();
        let diameter = 2.0 * (cloud.radii.iter().sum::<f64>() / 4.0);
        assert_eq!(cloud.centres[3], [2.0 * diameter; 2]);
    }

    #[test]
    fn none_and_one_are_fine() {
        let sizes = Sizes::Equal { radius: 1.0 };
        assert!(lattice::<3>(0, 1.0, 1.0).unwrap().is_empty());
        assert_eq!(lattice::<3>(1, 1.0, 1.0).unwrap().centres, [[0.0; 3]]);
        assert!(jittered_lattice::<2>(0, 1, 1.0, 0.1, sizes).unwrap().is_empty());
        assert_eq!(jittered_lattice::<2>(1, 1, 1.0, 0.1, sizes).unwrap().len(), 1);
    }

    #[test]
    fn bad_parameters_are_refused() {
        let sizes = Sizes::Equal { radius: 1.0 };
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(lattice::<2>(4, bad, 1.0).is_err() && lattice::<2>(4, 1.0, bad).is_err(), "{bad}");
            assert!(jittered_lattice::<2>(4, 1, bad, 0.1, sizes).is_err(), "{bad}");
        }
        assert!(jittered_lattice::<2>(4, 1, 1.0, -0.1, sizes).is_err());
        assert!(jittered_lattice::<2>(4, 1, 1.0, f64::NAN, sizes).is_err());
        assert!(jittered_lattice::<2>(4, 1, 1.0, 1e308, sizes).is_err());
        assert!(lattice::<1>(1_000_000, 1e305, 1.0).is_err());
    }
}
