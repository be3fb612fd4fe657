//! The strength of a material.

use serde::{Deserialize, Serialize};

/// Strength and fracture energies of a material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Tensile strength, Pa.
    pub tensile: f64,
    /// Cohesion, Pa.
    pub cohesion: f64,
    /// Tangent of the angle of internal friction.
    pub friction: f64,
    /// Fracture energy of opening, J/m².
    pub energy_i: f64,
    /// Fracture energy of sliding, beyond friction, J/m².
    pub energy_ii: f64,
    /// Weibull modulus of the factor, with a mean of 1, that scatters tensile strength and cohesion from edge
    /// to edge; `None` for no scatter.
    pub weibull_modulus: Option<f64>,
    /// Seed of the scatter.
    pub seed: u64,
}
