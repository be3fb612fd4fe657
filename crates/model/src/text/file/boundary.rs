//! `[[boundary]]`: place, kind and time.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::condition::Servo;
use crate::text::file::vector::Vector;

/// A support, motion or load on a part of the bodies. Where: `body` (default: all bodies) and at most one of
/// side, sides, box, group, at. How: exactly one of fixed, velocity, displacement, rotation, force, traction,
/// pressure, absorbing. When: one of ramp, table, `table_file`, expression (default: constant from the
/// start).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Name of the boundary for histories.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Name of a body. Without side, box and group the boundary acts on all of the body. Default: all bodies.
    #[serde(default)]
    pub body: Option<String>,
    /// Side of the body, or of all bodies together: the nodes farthest to the "left", "right", "top" or
    /// "bottom"; in three dimensions also "front" or "back". Left and right are along x, bottom and top along
    /// the last axis, front and back along y.
    #[serde(default)]
    pub side: Option<Side>,
    /// Several sides, in a list: the boundary acts on all of them.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub sides: Option<Vec<Side>>,
    /// Box [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m: the nodes and edges, or
    /// faces, inside.
    #[serde(default, rename = "box")]
    #[schemars(rename = "box", length(min = 4, max = 6))]
    #[schemars(extend("x-unit" = "m"))]
    pub limits: Option<Vec<f64>>,
    /// Physical group of a mesh file: of curves or surfaces, in three dimensions of surfaces or volumes. Flat
    /// shapes have the groups "outer" (the outline), "holes" (all holes) and "hole-1", "hole-2", …; for
    /// shapes in space see their descriptions.
    #[serde(default)]
    pub group: Option<String>,
    /// Point [x, y] or [x, y, z], m, in a hole or on an open joint: the place of a `cavity`.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub at: Option<Vector>,
    /// Directions in which the nodes are held: "x", "y", "z" or several of them, such as "xy" or "xyz".
    #[serde(default)]
    pub fixed: Option<Fixed>,
    /// Prescribed velocity [x, y] or [x, y, z], m/s. A component may be "free".
    #[serde(default)]
    #[schemars(length(min = 2, max = 3))]
    #[schemars(extend("x-unit" = "m/s"))]
    pub velocity: Option<Vec<Component>>,
    /// Prescribed displacement [x, y] or [x, y, z] from the start, m. A component may be "free".
    #[serde(default)]
    #[schemars(length(min = 2, max = 3))]
    #[schemars(extend("x-unit" = "m"))]
    pub displacement: Option<Vec<Component>>,
    /// Rotation of the nodes about a fixed axis: of a drum, a roller, a jaw, an end that twists. A rigid body
    /// turns as a whole.
    #[serde(default)]
    pub rotation: Option<Rotation>,
    /// Total force [x, y] or [x, y, z], N. Each node gets an equal part.
    #[serde(default)]
    #[schemars(extend("x-unit" = "N"))]
    pub force: Option<Vector>,
    /// Traction [x, y] or [x, y, z] on edges of the outline, or on outer faces, Pa, in fixed directions.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub traction: Option<Vector>,
    /// Pressure on edges of the outline, or on outer faces, Pa, against their outward normals.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Pa"))]
    pub pressure: Option<f64>,
    /// true: the pressure also acts on the faces of all broken joints that are connected with this place, and
    /// follows the cracks as they grow: a blast, a borehole under pressure. Default: false.
    #[serde(default)]
    pub cavity: bool,
    /// Ratio of the specific heats of a gas in the cavity, such as 1.4: `pressure` is that at the beginning,
    /// and falls as the volume grows, p = p0 (V0/V)^gamma. Default: none; the pressure follows the schedule.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 1, "x-unit" = "1"))]
    pub gas_exponent: Option<f64>,
    /// true: edges of the outline, or outer faces, absorb waves (Lysmer and Kuhlemeyer), carry the initial
    /// stress, and support the body with the stiffness of the ground beyond. Default: false.
    #[serde(default)]
    pub absorbing: bool,
    /// Time within which the load rises from 0 to its full value, as half a cosine, s.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub ramp: Option<f64>,
    /// Factor of the load over time, [[time, factor], …], s: linear between the entries, constant before the
    /// first and after the last.
    #[serde(default)]
    #[schemars(length(min = 1))]
    #[schemars(extend("x-unit" = ["s", "1"]))]
    pub table: Option<Vec<[f64; 2]>>,
    /// CSV file with such a table: one row for each time, s, with its factor.
    #[serde(default)]
    pub table_file: Option<String>,
    /// Factor of the load as an expression of the time `t` in seconds, such as "exp(-t/1e-3)" or
    /// "exp(-t/1ms)". Straight lines over 4000 intervals of the run stand for it.
    #[serde(default)]
    pub expression: Option<String>,
    /// Control of `velocity`, so that a force, a stress or a strain gets to a target. The `ramp` or the
    /// `table` is that of the target. Default: none.
    #[serde(default)]
    pub servo: Option<Servo>,
    /// Names of the stages in which it acts. The times of ramp and table begin with the first of them.
    /// Default: all.
    #[serde(default)]
    pub stages: Option<Vec<String>>,
}

impl Boundary {
    /// The sides on which it acts.
    pub(crate) fn all_sides(&self) -> impl Iterator<Item = Side> {
        self.side.into_iter().chain(self.sides.iter().flatten().copied())
    }
}

/// A rotation about a fixed axis.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Angular velocity, degrees per second: counter-clockwise in the plane, right-handed about the axis in
    /// space. The ramp, table or expression of the boundary is its factor.
    #[schemars(extend("x-unit" = "deg/s"))]
    pub speed: f64,
    /// Point [x, y] or [x, y, z] on the axis, m.
    #[schemars(extend("x-unit" = "m"))]
    pub through: Vector,
    /// In three dimensions: the direction [x, y, z] of the axis.
    #[serde(default)]
    #[schemars(extend("x-unit" = "1"))]
    pub axis: Option<[f64; 3]>,
}

impl Rotation {
    /// The direction of the axis, of length 1. Without an axis it is the third one.
    pub(crate) fn direction(&self) -> [f64; 3] {
        let axis = self.axis.unwrap_or([0.0, 0.0, 1.0]);
        let long = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        axis.map(|x| x / long)
    }

    /// The angular velocity as a vector in space, rad/s.
    pub(crate) fn spin(&self) -> [f64; 3] {
        self.direction().map(|x| x * self.speed.to_radians())
    }
}

/// A side of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Smallest x.
    Left,
    /// Largest x.
    Right,
    /// Largest y in two dimensions, z in three.
    Top,
    /// Smallest y in two dimensions, z in three.
    Bottom,
    /// Smallest y, in three dimensions.
    Front,
    /// Largest y, in three dimensions.
    Back,
}

/// Directions in which nodes are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fixed {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
    /// Along x and y.
    Xy,
    /// Along x and z.
    Xz,
    /// Along y and z.
    Yz,
    /// Along all axes.
    Xyz,
}

impl Fixed {
    /// Whether nodes are held along x, y and z.
    pub(crate) fn axes(self) -> [bool; 3] {
        match self {
            Self::X => [true, false, false],
            Self::Y => [false, true, false],
            Self::Z => [false, false, true],
            Self::Xy => [true, true, false],
            Self::Xz => [true, false, true],
            Self::Yz => [false, true, true],
            Self::Xyz => [true; 3],
        }
    }
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
