//! Hydraulic aperture of a cell.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::{FluidError, check};

/// Hydraulic aperture as a function of the mechanical opening and of the compression of a closed joint.
///
/// `a = clamp(a0 + f w, a_res, a_max)`, with the mechanical opening `w`. Where `w` is zero and the joint has
/// a reference stress `σ_ref`, its aperture falls under an effective compression `σ > 0` as
/// `a = a0/(1 + 9 σ/σ_ref)`, within the same limits: a tenth of `a0` at the reference stress. At `σ = 0` and
/// `w = 0` both forms are `a0`.
///
/// # Source
/// N. R. Barton, S. C. Bandis and K. Bakhtar, "Strength, deformation and conductivity coupling of rock
/// joints", Int. J. Rock Mech. Min. Sci. 22 (1985) 121-140: their hyperbola `σ = k w/(1 - w/w_max)` of the
/// closure `w`, with the largest closure `w_max = a0` and the stiffness `k = σ_ref/(9 a0)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ApertureLaw {
    /// Aperture `a0` without opening and compression, m.
    pub initial: f64,
    /// Factor `f` of the opening, in (0, 1]: below 1 for rough walls.
    pub factor: f64,
    /// Smallest aperture `a_res`, m: positive, so that each cell has a volume.
    pub residual: f64,
    /// Largest aperture `a_max`, m.
    pub largest: f64,
    /// Compression that leaves a tenth of `a0`, Pa; `None` if compression has no effect.
    pub reference_stress: Option<f64>,
}

impl Default for ApertureLaw {
    /// The mechanical opening, between 1 µm and 1 m.
    fn default() -> Self {
        Self { initial: 0.0, factor: 1.0, residual: 1e-6, largest: 1.0, reference_stress: None }
    }
}

impl ApertureLaw {
    /// The aperture, m, at an opening (m, not negative) and an effective normal compression: the total one
    /// less the pressure of the fluid, Pa, positive if the walls are pressed together.
    pub fn aperture(&self, opening: f64, compression: f64) -> f64 {
        let closing = match self.reference_stress {
            Some(stress) if opening == 0.0 && compression > 0.0 => 1.0 + 9.0 * compression / stress,
            _ => 1.0,
        };
        (self.initial / closing + self.factor * opening).clamp(self.residual, self.largest)
    }

    /// Growth of the aperture of a closed joint under an effective compression (Pa, positive) with the
    /// pressure of its fluid, m/Pa: `9 a0/σ_ref/(1 + 9 σ/σ_ref)²` between the limits of the aperture.
    pub fn compliance(&self, compression: f64) -> f64 {
        let Some(stress) = self.reference_stress else { return 0.0 };
        let closing = 1.0 + 9.0 * compression / stress;
        let is_limited = !(self.residual..=self.largest).contains(&(self.initial / closing));
        if is_limited { 0.0 } else { 9.0 * self.initial / (stress * closing * closing) }
    }

    pub(crate) fn check(&self, place: impl fmt::Display + Copy) -> Result<(), FluidError> {
        let Self { initial, factor, residual, largest, reference_stress } = *self;
        check(initial >= 0.0, place, "initial aperture", initial, "zero or positive")?;
        check(factor > 0.0 && factor <= 1.0, place, "roughness factor", factor, "in (0, 1]")?;
        check(residual > 0.0, place, "residual aperture", residual, "positive")?;
        check(largest >= residual, place, "largest aperture", largest, "at least the residual one")?;
        let stress = reference_stress.unwrap_or(1.0);
        check(stress > 0.0, place, "reference stress", stress, "positive")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn openings_add_up_and_compression_closes() {
        let law = ApertureLaw {
            initial: 1e-4,
            factor: 0.5,
            residual: 4e-6,
            largest: 1e-3,
            reference_stress: Some(2e6),
        };
        let of = |opening, compression| law.aperture(opening, compression);
        assert_eq!(of(0.0, 0.0), 1e-4);
        assert_eq!(of(0.0, -1e6), 1e-4);
        assert_eq!(of(2e-4, 1e6), 1e-4 + 0.5 * 2e-4);
        assert_eq!(of(1.0, 0.0), 1e-3);
        assert!((of(0.0, 2e6) / 1e-5 - 1.0).abs() < 1e-15);
        // The closure c at half the reference stress solves σ = k c/(1 - c/a0) with k = σ_ref/(9 a0).
        let closure = 1e-4 - of(0.0, 1e6);
        assert!((2e6 / 9e-4 * closure / (1.0 - closure / 1e-4) / 1e6 - 1.0).abs() < 1e-12);
        assert_eq!(of(0.0, 1e12), 4e-6);
        let rise = (of(0.0, 0.999e6) - of(0.0, 1.001e6)) / 2e3;
        assert!((law.compliance(1e6) / rise - 1.0).abs() < 1e-5, "{rise}");
        assert_eq!(law.compliance(1e12), 0.0);
    }
}
