//! The stress in an element: isotropic, exact under finite rotations, derived from an energy.
//!
//! Munjiza's stress (book, (4.178)-(4.184)) splits the strain into a change of shape and a change of area, each with its modulus. It does not follow from an
//! energy, so that a cycle of large strains gains or loses energy. Here both parts follow from an energy per undeformed area,
//!
//! ```text
//! W = G/2 (I₁/J − 2) + K/2 (J − 1)²,    I₁ = F:F,  J = det F,
//! ```
//! whose stress `P = ∂W/∂F` equals his to first order in the strain and vanishes under any rotation.
//!
//! An element under initial stress `S` (second Piola-Kirchhoff) has the energy
//!
//! ```text
//! U = σ:C⁻¹:σ / 2 + S:E + W,    E = (FᵀF - 1)/2,    σ = S at the beginning.
//! ```
//! Its gradient is `P = F S + ∂W/∂F`: the initial stress, which turns with the element, and the stress of the deformation. The first term of `U` is the energy
//! that the stress stored by Hooke's law before the run. With this term, `U` is `(ε₀ + E):C:(ε₀ + E) / 2` to second order in the strains, with `ε₀ = C⁻¹:σ`. It
//! is positive, and 0 where the element has lost all of its stress.

use crate::model::{Material, Plane};
use crate::potential::length;

/// A tensor in the plane: `[xx, xy, yx, yy]`.
pub(crate) type Tensor = [f64; 4];

/// Moduli in the plane, Pa.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli {
    pub(crate) shear: f64,
    /// Mean in-plane stress over the relative change of area.
    pub(crate) bulk: f64,
    /// σzz over σxx + σyy.
    pub(crate) out_of_plane: f64,
}

impl Moduli {
    pub(crate) fn new(material: &Material, plane: Plane) -> Self {
        let (e, nu) = (material.youngs_modulus, material.poissons_ratio);
        let shear = e / (2.0 * (1.0 + nu));
        match plane {
            Plane::Stress => Self { shear, bulk: e / (2.0 * (1.0 - nu)), out_of_plane: 0.0 },
            Plane::Strain => {
                Self { shear, bulk: e / (2.0 * (1.0 + nu) * (1.0 - 2.0 * nu)), out_of_plane: nu }
            }
        }
    }

    /// Energy density, J/m³, that a stress `[xx, yy, xy]` has stored by Hooke's law: `σ:C⁻¹:σ / 2`.
    pub(crate) fn stored(&self, [xx, yy, xy]: [f64; 3]) -> f64 {
        let (difference, sum) = (xx - yy, xx + yy);
        (0.5 * difference * difference + 2.0 * xy * xy) / (4.0 * self.shear) + sum * sum / (8.0 * self.bulk)
    }

    /// P-wave modulus, Pa: stress over strain in a compressional wave.
    pub(crate) fn wave(&self) -> f64 {
        self.shear + self.bulk
    }

    /// First Piola-Kirchhoff stress, Pa, and energy per undeformed volume, J/m³. `j` is the determinant of `f`; it must be positive.
    #[inline]
    pub(crate) fn stress(&self, f: &Tensor, j: f64) -> (Tensor, f64) {
        let [a, b, c, d] = *f;
        let cofactor = [d, -c, -b, a];
        // I₁ - 2J as a sum of squares that vanish under rotation, so that no large terms cancel.
        let (difference, sum) = (a - d, b + c);
        let shape = (difference * difference + sum * sum) / j;
        let volume = j - 1.0;
        let (g, k) = (self.shear / j, self.bulk * volume - 0.5 * self.shear / j * shape);
        let change = [difference, sum, sum, -difference];
        let stress = std::array::from_fn(|i| g * change[i] + k * cofactor[i]);
        (stress, 0.5 * (self.shear * shape + self.bulk * volume * volume))
    }
}

/// `a b`.
#[inline]
pub(crate) fn product(a: &Tensor, b: &Tensor) -> Tensor {
    [
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    ]
}

/// `a bᵀ`.
#[inline]
pub(crate) fn product_transposed(a: &Tensor, b: &Tensor) -> Tensor {
    [
        a[0] * b[0] + a[1] * b[1],
        a[0] * b[2] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[1],
        a[2] * b[2] + a[3] * b[3],
    ]
}

/// `a:b`.
#[inline]
pub(crate) fn contraction(a: &Tensor, b: &Tensor) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

#[inline]
pub(crate) fn determinant(f: &Tensor) -> f64 {
    f[0] * f[3] - f[1] * f[2]
}

/// First Piola-Kirchhoff stress of the viscous stress `2 µ D` (book, (4.176), (4.183)), with `D` the symmetric part of `rate F⁻¹`.
#[inline]
pub(crate) fn viscous_stress(viscosity: f64, f: &Tensor, j: f64, rate: &Tensor) -> Tensor {
    let [a, b, c, d] = *f;
    let gradient = product(rate, &[d / j, -b / j, -c / j, a / j]);
    let shear = 0.5 * (gradient[1] + gradient[2]);
    let stress = [gradient[0], shear, shear, gradient[3]].map(|x| 2.0 * viscosity * x);
    product(&stress, &[d, -c, -b, a])
}

/// Largest and smallest eigenvalue of a stress `[xx, yy, xy]`.
pub fn principal_stresses([xx, yy, xy]: [f64; 3]) -> [f64; 2] {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = length([half, xy]);
    [mean + radius, mean - radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn granite(plane: Plane) -> Moduli {
        let material = Material {
            name: String::new(),
            density: 2700.0,
            youngs_modulus: 50e9,
            poissons_ratio: 0.25,
            damping: 0.0,
            strength: None,
            friction: 0.0,
        };
        Moduli::new(&material, plane)
    }

    fn rotation(angle: f64) -> Tensor {
        let (sin, cos) = angle.sin_cos();
        [cos, -sin, sin, cos]
    }

    #[test]
    fn a_rotation_has_no_stress() {
        for k in 0..360 {
            let f = rotation(f64::from(k).to_radians());
            let (stress, energy) = granite(Plane::Strain).stress(&f, determinant(&f));
            // Rounding of sine and cosine, 1e-16, times the modulus.
            assert!(stress.iter().all(|s| s.abs() < 50e9 * 1e-15), "{k}: {stress:?}");
            assert!(energy < 50e9 * 1e-30);
        }
    }

    #[test]
    fn small_strains_have_the_stress_of_hooke() {
        let strain = 1e-7;
        for plane in [Plane::Stress, Plane::Strain] {
            let moduli = granite(plane);
            let (e, nu) = (50e9, 0.25);
            let f = [1.0 + strain, 0.0, 0.0, 1.0];
            let (stress, _) = moduli.stress(&f, determinant(&f));
            let (xx, yy) = match plane {
                Plane::Stress => (e / (1.0 - nu * nu), e * nu / (1.0 - nu * nu)),
                Plane::Strain => {
                    let lame = e / ((1.0 + nu) * (1.0 - 2.0 * nu));
                    (lame * (1.0 - nu), lame * nu)
                }
            };
            assert!((stress[0] / (xx * strain) - 1.0).abs() < 1e-6, "{stress:?}");
            assert!((stress[3] / (yy * strain) - 1.0).abs() < 1e-6, "{stress:?}");
            let f = [1.0, 2.0 * strain, 0.0, 1.0];
            let (stress, _) = moduli.stress(&f, determinant(&f));
            assert!((stress[1] / (e / (1.0 + nu) * strain) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_stress_is_the_gradient_of_the_energy() {
        let moduli = granite(Plane::Strain);
        let f = [1.3, -0.4, 0.2, 0.8];
        let (stress, _) = moduli.stress(&f, determinant(&f));
        for i in 0..4 {
            let h = 1e-6;
            let energy = |sign: f64| {
                let mut moved = f;
                moved[i] += sign * h;
                moduli.stress(&moved, determinant(&moved)).1
            };
            let slope = (energy(1.0) - energy(-1.0)) / (2.0 * h);
            assert!((stress[i] - slope).abs() < 1e-8 * 50e9, "{i}: {} {slope}", stress[i]);
        }
    }

    /// The energy stored by an initial stress equals the energy of the strain that causes this stress.
    #[test]
    fn an_initial_stress_has_stored_the_energy_of_its_strain() {
        for plane in [Plane::Stress, Plane::Strain] {
            let moduli = granite(plane);
            let f = [1.0 + 3e-6, 1e-6, 0.5e-6, 1.0 - 2e-6];
            let (stress, energy) = moduli.stress(&f, determinant(&f));
            let stored = moduli.stored([stress[0], stress[3], 0.5 * (stress[1] + stress[2])]);
            assert!((stored / energy - 1.0).abs() < 1e-5, "{stored} {energy}");
        }
    }

    #[test]
    fn viscous_stress_resists_stretching_and_not_rotation() {
        let f = rotation(0.7);
        let spin = product(&[0.0, -3.0, 3.0, 0.0], &f);
        assert!(viscous_stress(5.0, &f, 1.0, &spin).iter().all(|s| s.abs() < 1e-14));
        let stretching = [2.0, 0.0, 0.0, 0.0];
        assert_eq!(viscous_stress(5.0, &[1.0, 0.0, 0.0, 1.0], 1.0, &stretching), [20.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn principal_stresses_of_known_states() {
        assert_eq!(principal_stresses([3.0, -1.0, 0.0]), [3.0, -1.0]);
        assert_eq!(principal_stresses([0.0, 0.0, 2.0]), [2.0, -2.0]);
    }
}
