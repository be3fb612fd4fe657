//! The viscous stress of an element.

use crate::simplex::Simplex;
use crate::vector::{Matrix, matrix, product, symmetric};

/// First Piola-Kirchhoff stress of the viscous stress `2 µ D` (book, (4.176), (4.183)), with `D` the
/// symmetric part of `rate F⁻¹`. Twin: `crates/gpu/kernels/laws.h`.
#[inline(always)]
pub(crate) fn viscous_stress<const D: usize, const N: usize>(
    viscosity: f64,
    f: &Matrix<D>,
    j: f64,
    rate: &Matrix<D>,
) -> Matrix<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (cofactor, over) = (<[[f64; D]; N]>::cofactor(f), 1.0 / j);
    let inverse = matrix(|i, k| cofactor[k][i] * over);
    let rate = symmetric(&product(rate, &inverse));
    product(&rate.map(|row| row.map(|x| 2.0 * viscosity * x)), &cofactor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::tests::{one, rotation};

    #[test]
    fn viscous_stress_resists_stretching_and_not_rotation() {
        fn check<const D: usize, const N: usize>()
        where
            [[f64; D]; N]: Simplex<D, N>,
        {
            let f = rotation::<D>(7);
            let spin = matrix(|i, k| 3.0 * (i as f64 - k as f64));
            let stress = viscous_stress::<D, N>(5.0, &f, 1.0, &product(&spin, &f));
            assert!(stress.iter().flatten().all(|s| s.abs() < 1e-13), "{stress:?}");
            let mut stretching = [[0.0; D]; D];
            stretching[0][0] = 2.0;
            let expected = stretching.map(|row| row.map(|x| 10.0 * x));
            assert_eq!(viscous_stress::<D, N>(5.0, &one(), 1.0, &stretching), expected);
        }
        check::<2, 3>();
        check::<3, 4>();
    }
}
