//! `[[material]]` and `[[interface]]`.

use schemars::JsonSchema;
use serde::Deserialize;

/// An elastic material. With the five keys `tensile_strength`, `cohesion`, `friction_angle`, `fracture_energy_i` and `fracture_energy_ii` it breaks, without it does not.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// By which bodies and interfaces call it.
    #[schemars(length(min = 1))]
    pub name: String,
    /// kg/m³.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: f64,
    /// Pa.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub youngs_modulus: f64,
    /// From 0 to 0.5; in plane strain below 0.5. Auxetic materials have a negative one, above -1.
    #[schemars(extend("exclusiveMinimum" = -1, "maximum" = 0.5))]
    pub poissons_ratio: f64,
    /// Share of critical damping of an element's fastest mode by its viscosity. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub damping: f64,
    /// Coefficient of friction where the material touches, unless an `[[interface]]` says otherwise. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub friction: f64,
    /// Pa.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tensile_strength: Option<f64>,
    /// Shear strength without normal stress, Pa.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cohesion: Option<f64>,
    /// Of internal friction, degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 90))]
    pub friction_angle: Option<f64>,
    /// Fracture energy of opening (mode I), J/m².
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II), beyond friction, J/m².
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fracture_energy_ii: Option<f64>,
    /// Weibull modulus of the scatter of tensile strength and cohesion from edge to edge, with a mean of 1. Default: no scatter.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub weibull_modulus: Option<f64>,
    /// Of that scatter. Default: 1.
    #[serde(default = "seed")]
    pub weibull_seed: u64,
}

/// Contacts and joints between two materials, which may be the same.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interface {
    /// Names of the two.
    pub materials: [String; 2],
    /// Coefficient of friction of contacts. Default: the lesser of the two materials.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub friction: Option<f64>,
    /// Penalty of contacts, Pa. Default: as `[contact]` says.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub penalty: Option<f64>,
    /// Of joints between the two, Pa; needs the four keys below. Default: the lesser of the two materials.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tensile_strength: Option<f64>,
    /// Shear strength without normal stress, Pa.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cohesion: Option<f64>,
    /// Of internal friction, degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 90))]
    pub friction_angle: Option<f64>,
    /// Fracture energy of opening (mode I), J/m².
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II), beyond friction, J/m².
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub fracture_energy_ii: Option<f64>,
    /// Weibull modulus of the scatter of tensile strength and cohesion from edge to edge, with a mean of 1. Default: no scatter.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub weibull_modulus: Option<f64>,
    /// Of that scatter. Default: 1.
    #[serde(default = "seed")]
    pub weibull_seed: u64,
}

fn seed() -> u64 {
    1
}
