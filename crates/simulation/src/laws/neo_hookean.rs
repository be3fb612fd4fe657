//! The neo-Hookean law: isotropic, exact under finite rotations, derived from an energy.
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

use crate::lanes::Lanes;
use crate::laws::element_law::{ElementLaw, Refusal, Response};
use crate::moduli::{Moduli, Plane};
use crate::simplex::Simplex;
use crate::vector::{Matrix, Point};

/// Checks Poisson's ratio.
pub(super) fn check<const D: usize, const N: usize>(poissons_ratio: f64, plane: Plane) -> Result<(), Refusal>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    // A material that cannot change its volume has no moduli, except in plane stress.
    let at_most = <[[f64; D]; N]>::is_plate(plane);
    let nu = poissons_ratio;
    if nu > -1.0 && nu <= 0.5 && (nu < 0.5 || at_most) {
        return Ok(());
    }
    let range = if at_most { "above -1 and at most 0.5" } else { "above -1 and below 0.5" };
    Err(Refusal { what: "Poisson's ratio", value: nu, range })
}

impl<const D: usize, const N: usize> ElementLaw<D, N> for Moduli
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Moduli of shear and bulk, Pa.
    type Constants = [Lanes; 2];

    const SMALL: f64 = <[[f64; D]; N] as Simplex<D, N>>::SMALL;

    #[inline(always)]
    fn constants(&self) -> [Lanes; 2] {
        [Lanes::all(self.shear), Lanes::all(self.bulk)]
    }

    #[inline(always)]
    fn set(&self, constants: &mut [Lanes; 2], lane: usize) {
        constants[0].set(lane, self.shear);
        constants[1].set(lane, self.bulk);
    }

    #[inline(always)]
    fn stress_of_small(
        constants: &[Lanes; 2],
        _: &mut [Lanes],
        lane: usize,
        f: &Matrix<D>,
        j: f64,
    ) -> Response<D> {
        let moduli = [constants[0].get(lane), constants[1].get(lane)];
        let (stress, energy, strain) = <[[f64; D]; N]>::stress_of_small(moduli, f, j);
        Response { stress, energy, dissipated: 0.0, strain }
    }

    #[inline]
    fn stress(constants: &[Lanes; 2], _: &mut [Lanes], lane: usize, f: &Matrix<D>, j: f64) -> Response<D> {
        let moduli = [constants[0].get(lane), constants[1].get(lane)];
        let (stress, energy) = <[[f64; D]; N]>::stress(moduli, f, j);
        Response { stress, energy, dissipated: 0.0, strain: 0.0 }
    }

    fn stored(&self, stress: &Matrix<D>) -> f64 {
        <[[f64; D]; N]>::stored(self, stress)
    }

    #[inline]
    fn out_of_plane(&self, stress: &Matrix<D>, _: &[f64]) -> f64 {
        let mut sum = stress[0][0];
        for axis in 1..D {
            sum += stress[axis][axis];
        }
        self.out_of_plane * sum
    }

    fn highest_square(&self, shape: &[Point<D>; N], density: f64) -> f64 {
        shape.highest_square(self, density)
    }

    fn wave_moduli(&self, _: Point<D>) -> [f64; 2] {
        [self.wave, self.shear]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::tests::{any, one, rotation};
    use crate::vector::{contraction, matrix, product, product_transposed, symmetric};

    fn of(moduli: &Moduli) -> [f64; 2] {
        [moduli.shear, moduli.bulk]
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
            let moduli = <[[f64; D]; N]>::moduli(50e9, 0.25, plane);
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
            let moduli = <[[f64; D]; N]>::moduli(50e9, 0.25, plane);
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
            let moduli = <[[f64; D]; N]>::moduli(50e9, 0.25, plane);
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
