//! The stress in the plane: see `laws/neo_hookean.rs`.

use crate::moduli::{Moduli, Plane};
use crate::vector::Matrix;

pub(super) fn moduli(e: f64, nu: f64, plane: Plane) -> Moduli {
    let shear = e / (2.0 * (1.0 + nu));
    let (bulk, out_of_plane) = match plane {
        Plane::Stress => (e / (2.0 * (1.0 - nu)), 0.0),
        Plane::Strain => (e / (2.0 * (1.0 + nu) * (1.0 - 2.0 * nu)), nu),
    };
    Moduli { shear, bulk, wave: shear + bulk, out_of_plane }
}

/// Energy density, J/m³, that a stress has stored by Hooke's law: `σ:C⁻¹:σ / 2`.
pub(super) fn stored(moduli: &Moduli, [[xx, xy], [_, yy]]: &Matrix) -> f64 {
    let (difference, sum) = (xx - yy, xx + yy);
    (0.5 * difference * difference + 2.0 * xy * xy) / (4.0 * moduli.shear) + sum * sum / (8.0 * moduli.bulk)
}

/// First Piola-Kirchhoff stress, Pa, and energy per undeformed volume, J/m³. `j` is the determinant of `f`;
/// it must be positive. Twin: `crates/gpu/kernels/laws.h`.
#[inline(always)]
pub(super) fn stress([shear, bulk]: [f64; 2], f: &Matrix, j: f64) -> (Matrix, f64) {
    let [[a, b], [c, d]] = *f;
    // I₁ - 2J as a sum of squares that vanish under rotation, so that no large terms cancel.
    let (difference, sum) = (a - d, b + c);
    let inverse = 1.0 / j;
    let shape = (difference * difference + sum * sum) * inverse;
    let volume = j - 1.0;
    let g = shear * inverse;
    let k = bulk * volume - 0.5 * g * shape;
    let stress = [[g * difference + k * d, g * sum + k * -c], [g * sum + k * -b, g * -difference + k * a]];
    (stress, 0.5 * (shear * shape + bulk * volume * volume))
}
