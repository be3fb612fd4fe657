//! The stress in an element: isotropic, exact under finite rotations, derived from an energy.
//!
//! Munjiza's stress (book, (4.178)-(4.184)) splits the strain into a change of shape and a change of area or
//! volume, each with its modulus. It does not follow from an energy, so that a cycle of large strains gains
//! or loses energy. Here both parts follow from an energy per undeformed area or volume,
//!
//! ```text
//! W = G/2 (I₁ J^(−2/D) − D) + K/2 (J − 1)²,    I₁ = F:F,  J = det F,
//! ```
//! whose stress `P = ∂W/∂F` equals his to first order in the strain and vanishes under any rotation
//! (`simplex/triangle/elastic.rs` and `simplex/tetrahedron/elastic.rs`).
//!
//! An element under initial stress `S` (second Piola-Kirchhoff) has the energy
//!
//! ```text
//! U = σ:C⁻¹:σ / 2 + S:E + W,    E = (FᵀF - 1)/2,    σ = S at the beginning.
//! ```
//! Its gradient is `P = F S + ∂W/∂F`: the initial stress, which turns with the element, and the stress of the
//! deformation. The first term of `U` is the energy that the stress stored by Hooke's law before the run.
//! With this term, `U` is `(ε₀ + E):C:(ε₀ + E) / 2` to second order in the strains, with `ε₀ = C⁻¹:σ`. It is
//! positive, and 0 where the element has lost all of its stress.

use crate::simplex::Simplex;
use crate::vector::{Matrix, matrix, product, symmetric};

/// First Piola-Kirchhoff stress of the viscous stress `2 µ D` (book, (4.176), (4.183)), with `D` the
/// symmetric part of `rate F⁻¹`.
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
    use crate::model::{Material, Plane};
    use crate::moduli::Moduli;
    use crate::random::uniform;
    use crate::vector::{contraction, product_transposed};

    fn granite() -> Material {
        Material {
            name: String::new(),
            density: 2700.0,
            youngs_modulus: 50e9,
            poissons_ratio: 0.25,
            damping: 0.0,
            strength: None,
            friction: 0.0,
        }
    }

    fn of(moduli: &Moduli) -> [f64; 2] {
        [moduli.shear, moduli.bulk]
    }

    /// A matrix of numbers at random, between -1 and 1.
    fn any<const D: usize>(seed: u64) -> Matrix<D> {
        matrix(|i, k| 2.0 * uniform(seed, (D * i + k) as u64) - 1.0)
    }

    fn one<const D: usize>() -> Matrix<D> {
        matrix(|i, k| f64::from(u8::from(i == k)))
    }

    /// A rotation, from reflections at random.
    fn rotation<const D: usize>(seed: u64) -> Matrix<D> {
        let reflection = |row: [f64; D]| -> Matrix<D> {
            let squared = crate::vector::dot(row, row);
            matrix(|i, k| f64::from(u8::from(i == k)) - 2.0 * row[i] * row[k] / squared)
        };
        product(&reflection(any::<D>(seed)[0]), &reflection(any::<D>(seed)[1]))
    }

    /// All states of plane strain, plane stress and space.
    macro_rules! in_two_and_three_dimensions {
        ($check:ident) => {
            $check::<2, 3>(Plane::Strain);
            $check::<2, 3>(Plane::Stress);
            $check::<3, 4>(Plane::Strain);
        };
    }

    #[test]
    fn a_rotation_has_no_stress() {
        fn check<const D: usize, const N: usize>(plane: Plane)
        where
            [[f64; D]; N]: Simplex<D, N>,
        {
            let moduli = <[[f64; D]; N]>::moduli(&granite(), plane);
            for seed in 0..300 {
                let f = rotation::<D>(seed);
                let (stress, energy) =
                    <[[f64; D]; N]>::stress(of(&moduli), &f, <[[f64; D]; N]>::determinant(&f));
                // Rounding of the rotation, some 1e-16, times the modulus.
                assert!(stress.iter().flatten().all(|s| s.abs() < 50e9 * 3e-15), "{seed}: {stress:?}");
                assert!((0.0..50e9 * 1e-29).contains(&energy), "{energy}");
            }
        }
        in_two_and_three_dimensions!(check);
    }

    #[test]
    fn small_strains_have_the_stress_and_the_energy_of_hooke() {
        fn check<const D: usize, const N: usize>(plane: Plane)
        where
            [[f64; D]; N]: Simplex<D, N>,
        {
            let moduli = <[[f64; D]; N]>::moduli(&granite(), plane);
            let (e, nu) = (50e9, 0.25);
            let lame = match (D, plane) {
                (2, Plane::Stress) => e * nu / (1.0 - nu * nu),
                _ => e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            };
            let shear = e / (2.0 * (1.0 + nu));
            assert!((moduli.wave / (lame + 2.0 * shear) - 1.0).abs() < 1e-14);
            for seed in 0..100 {
                let strain = symmetric(&any::<D>(seed)).map(|row| row.map(|x| 1e-7 * x));
                let f = matrix(|i, k| one::<D>()[i][k] + strain[i][k]);
                let turned = product(&rotation::<D>(seed), &f);
                let trace: f64 = (0..D).map(|i| strain[i][i]).sum();
                let hooke = matrix(|i, k| lame * trace * one::<D>()[i][k] + 2.0 * shear * strain[i][k]);
                let expected = 0.5 * contraction(&hooke, &strain);
                let size = contraction(&hooke, &hooke).sqrt();
                let (stress, energy) =
                    <[[f64; D]; N]>::stress(of(&moduli), &f, <[[f64; D]; N]>::determinant(&f));
                let off = matrix::<D>(|i, k| stress[i][k] - hooke[i][k]);
                assert!(contraction(&off, &off).sqrt() < 1e-6 * size, "{stress:?} {hooke:?}");
                assert!((energy / expected - 1.0).abs() < 1e-6, "{energy} {expected}");
                // No digits are lost by a rotation.
                let determinant = <[[f64; D]; N]>::determinant(&turned);
                let (_, energy) = <[[f64; D]; N]>::stress(of(&moduli), &turned, determinant);
                assert!((energy / expected - 1.0).abs() < 1e-6, "{energy} {expected}");
                let stored = <[[f64; D]; N]>::stored(&moduli, &hooke);
                assert!((stored / expected - 1.0).abs() < 1e-12, "{stored} {expected}");
            }
        }
        in_two_and_three_dimensions!(check);
    }

    #[test]
    fn the_stress_is_the_gradient_of_the_energy() {
        fn check<const D: usize, const N: usize>(plane: Plane)
        where
            [[f64; D]; N]: Simplex<D, N>,
        {
            let moduli = <[[f64; D]; N]>::moduli(&granite(), plane);
            let energy_of =
                |f: &Matrix<D>| <[[f64; D]; N]>::stress(of(&moduli), f, <[[f64; D]; N]>::determinant(f)).1;
            for seed in 0..50 {
                let large = any::<D>(seed);
                let f = matrix(|i, k| one::<D>()[i][k] + 0.4 * large[i][k]);
                let j = <[[f64; D]; N]>::determinant(&f);
                if j < 0.2 {
                    continue;
                }
                let (stress, _) = <[[f64; D]; N]>::stress(of(&moduli), &f, j);
                for i in 0..D {
                    for k in 0..D {
                        let h = 1e-6;
                        let [before, after] = [-h, h].map(|step| {
                            let mut moved = f;
                            moved[i][k] += step;
                            energy_of(&moved)
                        });
                        let slope = (after - before) / (2.0 * h);
                        let error = (stress[i][k] - slope).abs();
                        assert!(error < 1e-8 * 50e9, "{seed} {i} {k}: {} {slope}", stress[i][k]);
                    }
                }
            }
        }
        in_two_and_three_dimensions!(check);
    }

    #[test]
    fn viscous_stress_resists_stretching_and_not_rotation() {
        fn check<const D: usize, const N: usize>(_: Plane)
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
        in_two_and_three_dimensions!(check);
    }

    #[test]
    fn inverse_and_determinant() {
        fn check<const D: usize, const N: usize>(_: Plane)
        where
            [[f64; D]; N]: Simplex<D, N>,
        {
            for seed in 0..100 {
                let f = any::<D>(seed);
                let (j, cofactor) = (<[[f64; D]; N]>::determinant(&f), <[[f64; D]; N]>::cofactor(&f));
                let product = product_transposed(&f, &cofactor);
                let off = matrix::<D>(|i, k| product[i][k] - j * one::<D>()[i][k]);
                assert!(off.iter().flatten().all(|x| x.abs() < 1e-15), "{off:?}");
            }
        }
        in_two_and_three_dimensions!(check);
    }
}
