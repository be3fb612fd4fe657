//! `[[joint_set]]`.

use schemars::JsonSchema;
use serde::Deserialize;

/// A set of joints in two dimensions: bedding, foliation, faults, or a discrete fracture network, with a law of its own. Its lines are given by exactly one of `lines`, `file` and `dip`. They become edges of the
/// meshes of the bodies; lines that nearly coincide, at distances up to 0.35 of the mesh size, become one. A joint is elastic up to its strength, softens, and then slides with its residual friction.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointSet {
    /// Name of the set.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Names of the bodies that have the joints. Default: all bodies that are meshed from a shape.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub bodies: Option<Vec<String>>,
    /// Lines [x1, y1, x2, y2], or polylines [x1, y1, x2, y2, x3, y3, …], m. What is outside of the bodies is left out.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"), length(min = 1))]
    pub lines: Option<Vec<Vec<f64>>>,
    /// File with lines: CSV with one line or polyline x1,y1,x2,y2,… a row, GeoJSON with `LineString` or `MultiLineString`, or DXF (ASCII) with `LINE` or `LWPOLYLINE`. Coordinates in m.
    #[serde(default)]
    pub file: Option<String>,
    /// Mean angle of the joints of a statistical set to the x axis, degrees. Joints with a positive angle rise to the right.
    #[serde(default)]
    #[schemars(extend("minimum" = -90, "maximum" = 90, "x-unit" = "deg"))]
    pub dip: Option<f64>,
    /// Mean distance of neighbouring joints, across them, m. Needed with `dip`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub spacing: Option<f64>,
    /// Length of joints over the length of the line on which they lie. The rest is rock between joints. Default: 1, joints without end.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub persistence: Option<f64>,
    /// Mean length of a joint, m. Needed with a `persistence` below 1.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub trace_length: Option<f64>,
    /// Greatest deviation of the angle of each joint from `dip`, degrees. Deviations are uniformly distributed. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 45, "x-unit" = "deg"))]
    pub dip_deviation: Option<f64>,
    /// Greatest deviation of each joint from its place across the joints, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub spacing_deviation: Option<f64>,
    /// Greatest deviation of the length of each joint from `trace_length`, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub trace_deviation: Option<f64>,
    /// Point through which one joint passes if there is no deviation, m. Default: [0, 0].
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub origin: Option<[f64; 2]>,
    /// Seed of the places, lengths and deviations. Default: 1.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Whether the joints are open at the start: they have no strength, carry no initial stress, and transmit pressure and friction only where they close, as contacts do. Default: false, joints are closed.
    #[serde(default)]
    pub open: bool,
    /// Tensile strength, Pa. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub tensile_strength: Option<f64>,
    /// Shear strength without normal stress, Pa. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "Pa"))]
    pub cohesion: Option<f64>,
    /// Friction angle, degrees.
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 90, "x-unit" = "deg"))]
    pub friction_angle: f64,
    /// Friction angle of broken joints, degrees. Default: `friction_angle`.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 90, "x-unit" = "deg"))]
    pub residual_friction_angle: Option<f64>,
    /// Fracture energy of opening (mode I), J/m², with the elastic work up to the strength. Needed with a tensile strength.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II), beyond friction, J/m², with the elastic work up to the strength. Needed with a cohesion.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_ii: Option<f64>,
    /// Normal stiffness, Pa/m. Default: from the `joint_penalty` of `[fracture]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa/m"))]
    pub normal_stiffness: Option<f64>,
    /// Shear stiffness, Pa/m. Default: the normal stiffness.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa/m"))]
    pub shear_stiffness: Option<f64>,
}
