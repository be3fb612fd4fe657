//! The stress in space: see `laws/neo_hookean.rs`.

use crate::moduli::Moduli;
use crate::vector::Matrix;

pub(super) fn moduli(e: f64, nu: f64) -> Moduli {
    let (shear, bulk) = (e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu)));
    Moduli { shear, bulk, wave: bulk + 4.0 / 3.0 * shear, out_of_plane: 0.0 }
}

/// Sum of squares that is 0 for a multiple of the unit tensor:
/// `((xx − yy)² + (yy − zz)² + (zz − xx)²)/2 + 3 (xy² + yz² + zx²)`.
#[inline(always)]
pub(super) fn deviation([[xx, xy, xz], [_, yy, yz], [_, _, zz]]: &Matrix<3>) -> f64 {
    let (one, two, three) = (xx - yy, yy - zz, zz - xx);
    0.5 * (one * one + two * two + three * three) + 3.0 * (xy * xy + yz * yz + xz * xz)
}

/// Up to this magnitude of its argument the series of the cube root is exact to rounding.
pub(super) const SMALL: f64 = 1e-3;

/// `∛(1 + z)`. For small strains it uses its series, which takes a fifth of the time.
#[inline]
pub(super) fn cube_root(z: f64) -> f64 {
    if z.abs() < SMALL { cube_root_of_small(z) } else { libm::cbrt(1.0 + z) }
}

/// `∛(1 + z)` by its series.
#[inline]
pub(super) fn cube_root_of_small(z: f64) -> f64 {
    let series = 22.0 / 729.0 * z - 10.0 / 243.0;
    let series = (series * z + 5.0 / 81.0) * z - 1.0 / 9.0;
    1.0 + z * (1.0 / 3.0 + z * series)
}

/// Energy density, J/m³, that a stress has stored by Hooke's law: `σ:C⁻¹:σ / 2`.
pub(super) fn stored(moduli: &Moduli, stress: &Matrix<3>) -> f64 {
    let sum = stress[0][0] + stress[1][1] + stress[2][2];
    deviation(stress) / (6.0 * moduli.shear) + sum * sum / (18.0 * moduli.bulk)
}

/// First Piola-Kirchhoff stress, Pa, and energy per undeformed volume, J/m³. `j` is the determinant of `f`,
/// which must be positive, and `cofactor` its matrix of cofactors. `root` is [`cube_root`].
///
/// The energy of the change of shape is `3/2 G (c − 1)` with `c³ = (I₁/3)³/J²`. Both are near 1 while strains
/// are small, and `c − 1` of the order of their squares. With the strain `E = (FᵀF − 1)/2`, `u = 2/3 tr E`
/// and `q` the [`deviation`] of E,
///
/// ```text
/// c³ − 1 = z = (4/3 q + u³ − 8 det E)/J²,    c − 1 = z/(c² + c + 1),
/// ```
/// in which no large terms cancel. Twin: `crates/gpu/kernels/laws.h`.
#[inline(always)]
pub(super) fn stress(
    [shear, bulk]: [f64; 2],
    f: &Matrix<3>,
    j: f64,
    cofactor: &Matrix<3>,
    root: impl FnOnce(f64) -> f64,
) -> (Matrix<3>, f64) {
    let strain = |i: usize, k: usize| {
        let sum = f[0][i] * f[0][k] + f[1][i] * f[1][k] + f[2][i] * f[2][k];
        0.5 * if i == k { sum - 1.0 } else { sum }
    };
    let (xx, yy, zz) = (strain(0, 0), strain(1, 1), strain(2, 2));
    let (xy, yz, xz) = (strain(0, 1), strain(1, 2), strain(0, 2));
    let u = 2.0 / 3.0 * (xx + yy + zz);
    let determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    let deviation = deviation(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    // Divisions cost more than all else here: there are two.
    let inverse = 1.0 / j;
    let z = (4.0 / 3.0 * deviation + u * u * u - 8.0 * determinant) * (inverse * inverse);
    let c = root(z);
    let (third, sum) = (1.0 + u, c * c + c + 1.0);
    let both = 1.0 / (third * sum);
    let shape = z * (third * both);
    let volume = j - 1.0;
    // G J^(−2/3), and the factor of the cofactors.
    let g = shear * c * (sum * both);
    let k = bulk * volume - g * third * inverse;
    let stress = std::array::from_fn(|i| std::array::from_fn(|l| g * f[i][l] + k * cofactor[i][l]));
    (stress, 1.5 * shear * shape + 0.5 * bulk * volume * volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;

    #[test]
    fn the_series_of_the_cube_root_is_exact_to_rounding() {
        for k in 0..10_000 {
            let z = 2.1e-3 * (uniform(3, k) - 0.5);
            let off = cube_root(z) - libm::cbrt(1.0 + z);
            assert!(off.abs() <= 2.0 * f64::EPSILON, "{z} {off}");
        }
    }
}
