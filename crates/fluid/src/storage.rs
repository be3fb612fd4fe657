//! Mass in a compartment as a function of its pressure.

use crate::fluid::StateEquation;

/// The volume of a compartment, which grows with its pressure if walls are compliant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Storage {
    /// Volume at the reference pressure, m³.
    pub(crate) volume: f64,
    /// Growth of the volume with the pressure, m³/Pa.
    pub(crate) compliance: f64,
    /// The reference pressure, Pa: that at which the walls are where they are.
    pub(crate) reference: f64,
}

impl Storage {
    /// Volume, m³, and its derivative, m³/Pa. Below the reference pressure the volume is
    /// `V/(1 + C (p_ref - p)/V)`: the same slope there, and positive at any pressure.
    pub(crate) fn volume(&self, pressure: f64) -> [f64; 2] {
        let rise = self.compliance * (pressure - self.reference);
        if rise >= 0.0 {
            return [self.volume + rise, self.compliance];
        }
        let ratio = 1.0 / (1.0 - rise / self.volume);
        [self.volume * ratio, self.compliance * ratio * ratio]
    }

    /// Mass of the full compartment, kg, and its derivative, kg/Pa.
    pub(crate) fn mass(&self, state: &StateEquation, pressure: f64) -> [f64; 2] {
        let [volume, slope] = self.volume(pressure);
        let density = state.density(pressure);
        [density * volume, state.density_slope(pressure) * volume + density * slope]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fluid::Fluid;

    #[test]
    fn slopes_are_derivatives_and_volumes_positive() {
        let storage = Storage { volume: 1e-6, compliance: 1e-13, reference: 5e6 };
        let state = Fluid::WATER.state;
        for p in [0.0, 1e6, 4.9e6, 5.1e6, 3e7] {
            let h = 1e3;
            let difference = (storage.mass(&state, p + h)[0] - storage.mass(&state, p - h)[0]) / (2.0 * h);
            assert!((difference / storage.mass(&state, p)[1] - 1.0).abs() < 1e-6, "{p}");
            assert!(storage.volume(p - 1e12)[0] > 0.0);
        }
        assert_eq!(storage.volume(1.5e7), [1e-6 + 1e-6, 1e-13]);
    }
}
