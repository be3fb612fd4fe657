//! Vectors in model files.

use schemars::JsonSchema;
use serde::Deserialize;

/// A vector: [x, y] in two dimensions, [x, y, z] in three.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Vector(#[schemars(length(min = 2, max = 3))] pub Vec<f64>);

impl Vector {
    /// The vector in space; in two dimensions z is 0.
    pub(crate) fn in_space(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.0.get(axis).copied().unwrap_or(0.0))
    }

    /// The components; zeros if their number is another one, which is a fault that has been found before.
    pub(crate) fn components<const D: usize>(&self) -> [f64; D] {
        self.0.as_slice().try_into().unwrap_or([0.0; D])
    }
}

/// An angular velocity, degrees per second: one number in two dimensions, [x, y, z] in three.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Spin {
    /// Counter-clockwise in the plane.
    Plane(f64),
    /// About an axis in space.
    Space([f64; 3]),
}

impl Spin {
    /// Returns the angular velocity as a vector in space, rad/s.
    pub(crate) fn vector(self) -> [f64; 3] {
        match self {
            Self::Plane(about) => [0.0, 0.0, about.to_radians()],
            Self::Space(vector) => vector.map(f64::to_radians),
        }
    }
}
