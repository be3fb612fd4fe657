//! Plane stress and plane strain, and the moduli of an isotropic material in them.

use serde::{Deserialize, Serialize};

/// Plane stress or plane strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// The stress out of the plane vanishes: a thin plate.
    #[default]
    Stress,
    /// The strain out of the plane vanishes: a slice of a long body.
    Strain,
}

/// Moduli of an isotropic material, Pa: in the plane, or in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli {
    pub(crate) shear: f64,
    /// Mean stress over the relative change of area or volume.
    pub(crate) bulk: f64,
    /// P-wave modulus: stress over strain in a compressional wave.
    pub(crate) wave: f64,
    /// σzz over σxx + σyy in the plane.
    pub(crate) out_of_plane: f64,
}
