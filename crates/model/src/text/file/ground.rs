//! `ground` of `[initial]`.

use schemars::JsonSchema;
use serde::Deserialize;

/// Stress of ground at rest under its own weight: the vertical stress is the weight above, the horizontal one
/// `k0` times that, plus the tectonic stress. Above the surface the stress is zero. Needs gravity along the
/// last axis, and in two dimensions plane strain. With the density of the bodies, nothing moves at the
/// beginning. Where pores have liquid at the beginning, it is the effective stress: the vertical one is the
/// weight less the part that the liquid bears, and the horizontal one is `k0` times that. A `water_level`
/// above the surface is water that stands on it: its pressure is a `[[boundary]]`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Height of the surface of the ground, m: y in two dimensions, z in three.
    #[schemars(extend("x-unit" = "m"))]
    pub surface: f64,
    /// Density of the ground, kg/m³. Default: that of the first material.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "kg/m³"))]
    pub density: Option<f64>,
    /// Horizontal over vertical stress: a number, or in three dimensions one along x and one along y.
    #[schemars(extend("x-unit" = "1"))]
    pub k0: Ratio,
    /// Horizontal stress besides, Pa, tension positive: a number, or in three dimensions one along x and one
    /// along y. Default: 0.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub tectonic: Option<Ratio>,
}

/// One number, or one for each horizontal axis.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Ratio {
    /// Along all horizontal axes.
    All(f64),
    /// Along x and along y.
    Each([f64; 2]),
}

impl Ratio {
    /// The number along x and along y.
    pub(crate) fn along(self) -> [f64; 2] {
        match self {
            Self::All(number) => [number; 2],
            Self::Each(numbers) => numbers,
        }
    }
}
