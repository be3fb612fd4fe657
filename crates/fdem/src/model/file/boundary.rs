//! `[[boundary]]`: where, what and when.

use schemars::JsonSchema;
use serde::Deserialize;

/// What acts on a part of the bodies. Where: `body` (default: all bodies) and at most one of side, box, group. What: exactly one of
/// fixed, velocity, displacement, force, traction, pressure, absorbing. When: ramp or table (default: from the beginning, constant).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// By which histories call it.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of a body; without side, box and group all of it. Default: all bodies.
    #[serde(default)]
    pub body: Option<String>,
    /// What is farthest to the "left", "right", "top" or "bottom" of all that `body` means.
    #[serde(default)]
    pub side: Option<Side>,
    /// What lies in a box [xmin, ymin, xmax, ymax], m.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box")]
    pub limits: Option<[f64; 4]>,
    /// A physical group of curves or surfaces of a mesh from a file; of other shapes "outer" (the outline), "holes" (of all holes) or "hole-1", "hole-2", …
    #[serde(default)]
    pub group: Option<String>,
    /// Held along "x", "y" or "xy".
    #[serde(default)]
    pub fixed: Option<Fixed>,
    /// Moved with this velocity [x, y], m/s; a component may be "free".
    #[serde(default)]
    pub velocity: Option<[Component; 2]>,
    /// Moved by [x, y] from where it was, m; a component may be "free".
    #[serde(default)]
    pub displacement: Option<[Component; 2]>,
    /// In all [x, y], N, on the nodes in equal parts.
    #[serde(default)]
    pub force: Option<[f64; 2]>,
    /// On edges of the outline [x, y], Pa, in fixed directions.
    #[serde(default)]
    pub traction: Option<[f64; 2]>,
    /// On edges of the outline, Pa, against their outward normals.
    #[serde(default)]
    pub pressure: Option<f64>,
    /// true: edges of the outline let waves out (Lysmer and Kuhlemeyer).
    #[serde(default)]
    pub absorbing: bool,
    /// From 0 to all of it as half a cosine within this time, s.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ramp: Option<f64>,
    /// [[time, factor], …], s: linear between them, constant before the first and after the last.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub table: Option<Vec<[f64; 2]>>,
}

/// A side of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Least x.
    Left,
    /// Largest x.
    Right,
    /// Largest y.
    Top,
    /// Least y.
    Bottom,
}

/// Which components are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fixed {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Both.
    Xy,
}

/// A number, or "free".
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Component {
    /// Prescribed.
    Number(f64),
    /// Not prescribed.
    Free(Free),
}

impl Component {
    /// What is prescribed, if anything is.
    pub(crate) fn prescribed(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Free(Free::Free) => None,
        }
    }
}

/// The word for what is not prescribed.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Free {
    /// Not prescribed.
    Free,
}
