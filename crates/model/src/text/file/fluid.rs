//! `[fluid]` and `[[injection]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::vector::Vector;

/// A fluid in holes, in open joints and in cracks. Its pressure acts on both faces of cracks, and on the
/// walls of holes with an `[[injection]]`. The gravity of the model acts on it, in full from the beginning.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Dynamic viscosity, Pa s. Default: 1e-3, water at 20 °C.
    #[serde(default = "viscosity")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa*s"))]
    pub viscosity: f64,
    /// Density at the reference pressure, kg/m³. Default: 998, water; a gas needs it.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "kg/m³"))]
    pub density: Option<f64>,
    /// Bulk modulus of a liquid, Pa. Default: 2.2e9, water.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub bulk_modulus: Option<f64>,
    /// Pressure at which the fluid has its density, Pa. Default: 0; a gas needs it.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub reference_pressure: Option<f64>,
    /// Pressure of a liquid in cells that it does not fill, Pa: between its front and the tip of a crack. No
    /// pressure is below it. Default: 0.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub cavitation_pressure: Option<f64>,
    /// Exponent n of a gas, p = p0 (density/density0)^n: 1 at a constant temperature, 1.4 for air without
    /// exchange of heat. Default: none, a liquid.
    #[serde(default)]
    #[schemars(extend("minimum" = 1, "x-unit" = "1"))]
    pub gas_exponent: Option<f64>,
    /// Joints that the fluid can enter: "insertion", all new cracks as soon as they soften, or "break", those
    /// that are broken. Joints of open sets, and of sets with an aperture, are entered from the beginning.
    /// Default: "insertion".
    #[serde(default)]
    pub wet_from: WetFromWord,
    /// Time integration of the flow: "implicit", or "explicit" to check it. Default: "implicit".
    #[serde(default)]
    pub scheme: SchemeWord,
    /// Number of steps of the solid in each step of the fluid. Default: 1.
    #[serde(default = "steps")]
    #[schemars(range(min = 1))]
    pub steps: u32,
    /// Connection of cells: "network", flow by the cubic law, or "cavities", without resistance: all that is
    /// connected has one pressure. Default: "network".
    #[serde(default)]
    pub connection: ConnectionWord,
    /// Carter's coefficient of leak-off through each of the two faces of a crack, m/√s. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m/s^0.5"))]
    pub leak_off: f64,
    /// Pressure of the fluid that fills joints when it can enter them, Pa: new cracks too. Default: none,
    /// they are empty.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub initial_pressure: Option<f64>,
    /// Hydraulic aperture of closed cracks, m: the aperture is this one plus the roughness factor times the
    /// opening. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub aperture: f64,
    /// Smallest hydraulic aperture, m. Default: 1e-6.
    #[serde(default = "residual_aperture")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub residual_aperture: f64,
    /// Largest hydraulic aperture, m. Default: 1.
    #[serde(default = "max_aperture")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub max_aperture: f64,
    /// Effective compression, the total one less the pressure of the fluid, at which a closed crack has a
    /// tenth of its `aperture`, Pa (Barton and Bandis); not with the explicit scheme. Default: none,
    /// compression has no effect.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub reference_stress: Option<f64>,
    /// Factor of the opening in the hydraulic aperture, below 1 for rough walls. Default: 1.
    #[serde(default = "roughness_factor")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub roughness_factor: f64,
    /// Name of the stage from which on there is fluid. Default: the first.
    #[serde(default)]
    pub from_stage: Option<String>,
}

/// A place where fluid enters: a hole, or joints. Where: exactly one of `at`, `group` and `boundary`. How: at
/// most one of `rate` and `pressure`; without them, a hole is only connected with its cracks. When: at most
/// one of `ramp`, `table`, `table_file` and `expression` (default: constant from the start).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Injection {
    /// Name of the injection, and of its columns in the history.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Point [x, y] or [x, y, z], m: in a hole, or on a joint that fluid can enter from the beginning; then
    /// the nearest edge or face of it.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub at: Option<Vector>,
    /// Group of outer edges or faces of the bodies around a hole: "holes", "hole-1", or a physical group of a
    /// mesh file.
    #[serde(default)]
    pub group: Option<String>,
    /// Name of a boundary with a load on edges or faces, around a hole.
    #[serde(default)]
    pub boundary: Option<String>,
    /// Volume that flows in, m³/s at the reference density; in two dimensions into the whole thickness.
    /// Negative: fluid is taken out, as far as there is some.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m³/s"))]
    pub rate: Option<f64>,
    /// Pressure that is held, Pa.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub pressure: Option<f64>,
    /// Pressure of the fluid that fills the hole at the beginning, Pa. Default: none, the hole is empty.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub initial_pressure: Option<f64>,
    /// Time within which the rate or pressure rises from 0 to its full value, as half a cosine, s.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub ramp: Option<f64>,
    /// Factor of the rate or pressure over time, [[time, factor], …], s: linear between the entries, constant
    /// before the first and after the last.
    #[serde(default)]
    #[schemars(length(min = 1))]
    #[schemars(extend("x-unit" = ["s", "1"]))]
    pub table: Option<Vec<[f64; 2]>>,
    /// CSV file with such a table: one row for each time, s, with its factor.
    #[serde(default)]
    pub table_file: Option<String>,
    /// Factor of the rate or pressure as an expression of the time `t` in seconds, such as "exp(-t/1ms)".
    /// Straight lines over 4000 intervals of the run stand for it.
    #[serde(default)]
    pub expression: Option<String>,
    /// Names of the stages in which it pumps. In the others it is shut in: its hole keeps its fluid. The
    /// times of ramp and table begin with the first of them. Default: all.
    #[serde(default)]
    pub stages: Option<Vec<String>>,
}

/// Joints that fluid can enter.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WetFromWord {
    /// New cracks as soon as they soften.
    #[default]
    Insertion,
    /// Broken joints.
    Break,
}

/// Time integration of the flow.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SchemeWord {
    /// Backward Euler: stable at any step.
    #[default]
    Implicit,
    /// Forward Euler, in as many parts of a step as it needs.
    Explicit,
}

/// Connection of the cells of the fluid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ConnectionWord {
    /// Flow by the cubic law.
    #[default]
    Network,
    /// One pressure in all that is connected.
    Cavities,
}

fn viscosity() -> f64 {
    1e-3
}

fn steps() -> u32 {
    1
}

fn residual_aperture() -> f64 {
    1e-6
}

fn max_aperture() -> f64 {
    1.0
}

fn roughness_factor() -> f64 {
    1.0
}
