//! `principal` of `[initial]`.

use schemars::JsonSchema;
use serde::Deserialize;

/// A stress by its principal values, Pa, tension positive, and the direction of the largest compression. In
/// two dimensions it has `angle`; in three `sigma2`, `trend` and `plunge`, and `rake` if needed.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Principal {
    /// Largest compression, Pa: a negative number, the least of all.
    #[schemars(extend("x-unit" = "Pa"))]
    pub sigma1: f64,
    /// In three dimensions: the principal stress between the others, Pa.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub sigma2: Option<f64>,
    /// Least compression, or tension, Pa.
    #[schemars(extend("x-unit" = "Pa"))]
    pub sigma3: f64,
    /// In two dimensions: angle of `sigma1` to the x axis, degrees, positive if it rises to the right.
    #[serde(default)]
    #[schemars(extend("minimum" = -180, "maximum" = 180, "x-unit" = "deg"))]
    pub angle: Option<f64>,
    /// In three dimensions: direction of `sigma1` seen from above, clockwise from y (north), so that 90 is x
    /// (east), degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = -360, "maximum" = 360, "x-unit" = "deg"))]
    pub trend: Option<f64>,
    /// In three dimensions: angle of `sigma1` below the horizontal, degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = -90, "maximum" = 90, "x-unit" = "deg"))]
    pub plunge: Option<f64>,
    /// In three dimensions: angle by which `sigma2` is turned about `sigma1`, degrees. At 0 `sigma2` is
    /// horizontal, with a trend of 90 degrees more than that of `sigma1`; at 90 it points down as far as it
    /// can. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = -180, "maximum" = 180, "x-unit" = "deg"))]
    pub rake: Option<f64>,
}

impl Principal {
    /// Keys of two dimensions only, and of three only, and whether they are given.
    pub(crate) fn of_dimensions(&self) -> [Vec<(&'static str, bool)>; 2] {
        [
            vec![("angle", self.angle.is_some())],
            vec![
                ("sigma2", self.sigma2.is_some()),
                ("trend", self.trend.is_some()),
                ("plunge", self.plunge.is_some()),
                ("rake", self.rake.is_some()),
            ],
        ]
    }

    /// The components in the order of the model file: [xx, yy, xy] or [xx, yy, zz, xy, yz, xz].
    pub(crate) fn components(&self, dimensions: usize) -> Vec<f64> {
        let sin_cos = |degrees: Option<f64>| {
            let angle = degrees.unwrap_or(0.0).to_radians();
            (libm::sin(angle), libm::cos(angle))
        };
        if dimensions == 2 {
            let (sin, cos) = sin_cos(self.angle);
            let (first, last) = (self.sigma1, self.sigma3);
            return vec![
                first * cos * cos + last * sin * sin,
                first * sin * sin + last * cos * cos,
                (first - last) * sin * cos,
            ];
        }
        let ((east, north), (down, level)) = (sin_cos(self.trend), sin_cos(self.plunge));
        let first = [east * level, north * level, -down];
        let across = [north, -east, 0.0];
        let steep = [-east * down, -north * down, -level];
        let (sin, cos) = sin_cos(self.rake);
        let second: [f64; 3] = std::array::from_fn(|k| cos * across[k] + sin * steep[k]);
        let third: [f64; 3] = std::array::from_fn(|k| cos * steep[k] - sin * across[k]);
        let parts = [(self.sigma1, first), (self.sigma2.unwrap_or(0.0), second), (self.sigma3, third)];
        let component = |[row, column]: [usize; 2]| {
            parts.iter().map(|(value, direction)| value * direction[row] * direction[column]).sum()
        };
        [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]].map(component).to_vec()
    }
}
