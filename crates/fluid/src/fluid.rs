//! The fluid: its viscosity, and its density as a function of the pressure.

use serde::{Deserialize, Serialize};

use crate::error::{FluidError, check};

/// Density of a fluid as a function of its pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum StateEquation {
    /// `ρ = ρ0 exp((p - p0)/K)`: a constant bulk modulus. A cell that is not full has the pressure of
    /// cavitation: the gap between the front of the fluid and the tip of a crack, its *lag*.
    Liquid {
        /// Density `ρ0` at the reference pressure, kg/m³.
        density: f64,
        /// Reference pressure `p0`, Pa.
        reference_pressure: f64,
        /// Bulk modulus `K`, Pa.
        bulk_modulus: f64,
        /// Pressure of cells that are not full, Pa. No pressure is below it.
        cavitation_pressure: f64,
    },
    /// `p = p0 (ρ/ρ0)^n`: a gas, which fills every cell. Pressures are absolute.
    Gas {
        /// Density `ρ0` at the reference pressure, kg/m³.
        density: f64,
        /// Reference pressure `p0`, Pa.
        reference_pressure: f64,
        /// Exponent `n`: 1 for an isothermal gas, the ratio of specific heats for an adiabatic one.
        exponent: f64,
    },
}

impl StateEquation {
    /// Density at the reference pressure, kg/m³. Volumes and rates of sources and leak-off refer to it.
    pub fn reference_density(&self) -> f64 {
        match *self {
            Self::Liquid { density, .. } | Self::Gas { density, .. } => density,
        }
    }

    /// Lowest pressure, Pa: that of cavitation, or zero.
    pub fn lowest_pressure(&self) -> f64 {
        match *self {
            Self::Liquid { cavitation_pressure, .. } => cavitation_pressure,
            Self::Gas { .. } => 0.0,
        }
    }

    /// Density at a pressure, kg/m³.
    pub fn density(&self, pressure: f64) -> f64 {
        match *self {
            Self::Liquid { density, reference_pressure, bulk_modulus, .. } => {
                density * libm::exp((pressure - reference_pressure) / bulk_modulus)
            }
            Self::Gas { density, reference_pressure, exponent } => {
                density * libm::pow(pressure / reference_pressure, 1.0 / exponent)
            }
        }
    }

    /// Derivative of the density by the pressure, kg/(m³ Pa).
    pub fn density_slope(&self, pressure: f64) -> f64 {
        match *self {
            Self::Liquid { bulk_modulus, .. } => self.density(pressure) / bulk_modulus,
            Self::Gas { exponent, .. } => self.density(pressure) / (exponent * pressure),
        }
    }

    /// Pressure at a density, Pa: the lowest one for cells that are not full.
    pub fn pressure(&self, density: f64) -> f64 {
        let lowest = self.lowest_pressure();
        if density <= self.density(lowest) {
            return lowest;
        }
        let ratio = density / self.reference_density();
        match *self {
            Self::Liquid { reference_pressure, bulk_modulus, .. } => {
                (reference_pressure + bulk_modulus * libm::log(ratio)).max(lowest)
            }
            Self::Gas { reference_pressure, exponent, .. } => reference_pressure * libm::pow(ratio, exponent),
        }
    }

    /// Mean density between two pressures, `∫ρ dp/Δp` by Simpson's rule: with it, steady flow through links
    /// in series is that of the compressible fluid, to (Δp/K)⁴/2880 of a link.
    pub(crate) fn mean_density(&self, [a, b]: [f64; 2]) -> f64 {
        (self.density(a) + 4.0 * self.density(0.5 * (a + b)) + self.density(b)) / 6.0
    }

    fn check(&self) -> Result<(), FluidError> {
        let positive = |what, value: f64| check(value > 0.0, "fluid", what, value, "positive");
        match *self {
            Self::Liquid { density, reference_pressure, bulk_modulus, cavitation_pressure } => {
                positive("density", density)?;
                positive("bulk modulus", bulk_modulus)?;
                check(true, "fluid", "reference pressure", reference_pressure, "finite")?;
                let ratio = (cavitation_pressure - reference_pressure).abs() / bulk_modulus;
                check(ratio <= 1.0, "fluid", "cavitation pressure", cavitation_pressure, {
                    "within a bulk modulus of the reference pressure"
                })
            }
            Self::Gas { density, reference_pressure, exponent } => {
                positive("density", density)?;
                positive("reference pressure", reference_pressure)?;
                check(exponent >= 1.0, "fluid", "exponent", exponent, "at least 1")
            }
        }
    }
}

/// A fluid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fluid {
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Density as a function of the pressure.
    pub state: StateEquation,
}

impl Fluid {
    /// Water at 20 °C, without pressure above that of cavitation at rest: 1 mPa s, 998 kg/m³,
    /// a bulk modulus of 2.2e9 Pa.
    pub const WATER: Self = Self {
        viscosity: 1e-3,
        state: StateEquation::Liquid {
            density: 998.0,
            reference_pressure: 0.0,
            bulk_modulus: 2.2e9,
            cavitation_pressure: 0.0,
        },
    };

    pub(crate) fn check(&self) -> Result<(), FluidError> {
        check(self.viscosity > 0.0, "fluid", "viscosity", self.viscosity, "positive")?;
        self.state.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_inverts_density_and_the_slope_is_its_derivative() {
        let gas = StateEquation::Gas { density: 1.2, reference_pressure: 1e5, exponent: 1.4 };
        for (state, pressures) in [(Fluid::WATER.state, [1e3, 2e7, 5e8]), (gas, [1e3, 1e5, 3e8])] {
            for p in pressures {
                assert!((state.pressure(state.density(p)) - p).abs() <= 1e-12 * p + 1e-5, "{p}");
                let h = 1e-3 * p;
                let difference = (state.density(p + h) - state.density(p - h)) / (2.0 * h);
                assert!((difference / state.density_slope(p) - 1.0).abs() < 1e-5, "{p}");
            }
        }
        // 1.2 (2e5/1e5)^(1/1.4)
        assert!((gas.density(2e5) / 1.968_803_7 - 1.0).abs() < 1e-6);
    }

    /// The integral of the exponential is `K (ρ_b - ρ_a)`.
    #[test]
    fn the_mean_density_is_that_of_the_integral() {
        let state = Fluid::WATER.state;
        let (a, b) = (1e6, 4e7);
        let exact = 2.2e9 * (state.density(b) - state.density(a)) / (b - a);
        assert!((state.mean_density([a, b]) / exact - 1.0).abs() < 1e-10);
    }
}
