//! `[[boundary]]`: where, what and when.

use schemars::JsonSchema;
use serde::Deserialize;

/// A support, motion or load on a part of the bodies. Where: `body` (default: all bodies) and at most one of side, box, group. What: exactly one of
/// fixed, velocity, displacement, force, traction, pressure, absorbing. When: ramp or table (default: constant from the start).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Name of the boundary for histories.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of a body. Without side, box and group the boundary acts on all of the body. Default: all bodies.
    #[serde(default)]
    pub body: Option<String>,
    /// Side of the body, or of all bodies together: the nodes farthest to the "left", "right", "top" or "bottom".
    #[serde(default)]
    pub side: Option<Side>,
    /// Box [xmin, ymin, xmax, ymax], m: the nodes and edges inside.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box")]
    pub limits: Option<[f64; 4]>,
    /// Physical group of curves or surfaces of a mesh file. Other shapes have the groups "outer" (the outline), "holes" (all holes) and "hole-1", "hole-2", …
    #[serde(default)]
    pub group: Option<String>,
    /// Directions in which the nodes are held: "x", "y" or "xy".
    #[serde(default)]
    pub fixed: Option<Fixed>,
    /// Prescribed velocity [x, y], m/s. A component may be "free".
    #[serde(default)]
    pub velocity: Option<[Component; 2]>,
    /// Prescribed displacement [x, y] from the start, m. A component may be "free".
    #[serde(default)]
    pub displacement: Option<[Component; 2]>,
    /// Total force [x, y], N. Each node gets an equal part.
    #[serde(default)]
    pub force: Option<[f64; 2]>,
    /// Traction [x, y] on edges of the outline, Pa, in fixed directions.
    #[serde(default)]
    pub traction: Option<[f64; 2]>,
    /// Pressure on edges of the outline, Pa, against their outward normals.
    #[serde(default)]
    pub pressure: Option<f64>,
    /// true: edges of the outline absorb waves (Lysmer and Kuhlemeyer), carry the initial stress, and support the body with the stiffness of the ground beyond. Default: false.
    #[serde(default)]
    pub absorbing: bool,
    /// Time within which the load rises from 0 to its full value, as half a cosine, s.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ramp: Option<f64>,
    /// Factor of the load over time, [[time, factor], …], s: linear between the entries, constant before the first and after the last.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub table: Option<Vec<[f64; 2]>>,
}

/// A side of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Smallest x.
    Left,
    /// Largest x.
    Right,
    /// Largest y.
    Top,
    /// Smallest y.
    Bottom,
}

/// Directions in which nodes are held.
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
    /// The prescribed number; `None` if the direction is free.
    pub(crate) fn prescribed(self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number),
            Self::Free(Free::Free) => None,
        }
    }
}

/// The word "free".
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Free {
    /// Not prescribed.
    Free,
}
