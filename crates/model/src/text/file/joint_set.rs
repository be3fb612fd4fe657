//! `[[joint_set]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::vector::Vector;

/// A set of joints with a common law: bedding, foliation, faults, or a discrete fracture network. Its joints
/// are lines in two dimensions and polygons in three, given by exactly one of `lines` or `polygons`, `file`,
/// `dip`, `group` and `between`. They become edges or faces of the meshes of the bodies; joints that nearly
/// coincide, at distances up to 0.35 of the mesh size, become one. A joint is elastic up to its strength,
/// softens, and then slides with its residual friction.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointSet {
    /// Name of the set.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Whether the set may have no joint in any body. Default: false, and that is an error.
    #[serde(default)]
    pub optional: bool,
    /// Names of the bodies that have the joints. Default: all bodies that are meshed from a shape; with
    /// `group`, all with a mesh file that has the group.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub bodies: Option<Vec<String>>,
    /// In two dimensions: lines [x1, y1, x2, y2], or polylines [x1, y1, x2, y2, x3, y3, …], m. Parts outside
    /// of the bodies are left out.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"), length(min = 1))]
    pub lines: Option<Vec<Vec<f64>>>,
    /// In three dimensions: flat polygons [x1, y1, z1, x2, y2, z2, x3, y3, z3, …] by their corners in order,
    /// m. Parts outside of the bodies are left out.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"), length(min = 1))]
    pub polygons: Option<Vec<Vec<f64>>>,
    /// File with joints. In two dimensions: CSV with one line or polyline x1,y1,x2,y2,… a row, GeoJSON with
    /// `LineString` or `MultiLineString`, or DXF (ASCII) with `LINE`, `POLYLINE`, `LWPOLYLINE`, `CIRCLE`,
    /// `ARC` or `ELLIPSE`. In three dimensions: CSV with one polygon x1,y1,z1,x2,y2,z2,… a row, GeoJSON with
    /// `Polygon` or `MultiPolygon` and heights, or DXF with `3DFACE`, closed `POLYLINE` or `LWPOLYLINE`,
    /// `CIRCLE` or `ELLIPSE`. Coordinates are in m, those of DXF in the unit of the drawing.
    #[serde(default)]
    pub file: Option<String>,
    /// Length in metres of the unit of `file`: "1 mm" for a file in millimetres. Default: 1, or the unit
    /// that a DXF file says (`$INSUNITS`).
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub scale: Option<f64>,
    /// Name of a group in the mesh file of a body, such as a physical group of embedded curves (in two
    /// dimensions) or surfaces (in three): its edges or faces between two elements are the joints.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub group: Option<String>,
    /// Names of two bodies that are bonded, such as bricks by mortar: their common edges or faces are the
    /// joints. The name of a body with `repeat`, or of a packing, means all of its copies, and the same name
    /// twice means every two of them. The meshes have to fit together: common sides have the same nodes. If
    /// there is no body of these names, they are groups of elements of mesh files, such as grains. In a name,
    /// `*` stands for any text: `["poly*", "poly*"]`.
    #[serde(default)]
    #[schemars(length(min = 2, max = 2))]
    pub between: Option<Vec<String>>,
    /// In two dimensions: mean angle of the joints of a statistical set to the x axis, degrees; joints with a
    /// positive angle rise to the right. In three: mean angle at which they dip below the horizontal (x and
    /// y), 0 to 90 degrees.
    #[serde(default)]
    #[schemars(extend("minimum" = -90, "maximum" = 90, "x-unit" = "deg"))]
    pub dip: Option<f64>,
    /// In three dimensions: direction in which joints dip, clockwise from y (north) seen from above, so that
    /// 90 is x (east), degrees. Needed with `dip`.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 360, "x-unit" = "deg"))]
    pub dip_direction: Option<f64>,
    /// Mean distance of neighbouring joints, across them, m. Needed with `dip`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub spacing: Option<f64>,
    /// Length of joints over the length of the line on which they lie, or their area over that of their
    /// plane, then at most 0.8 or 1. The rest is rock between joints. Default: 1, joints without end.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub persistence: Option<f64>,
    /// Mean length of a joint, m; in three dimensions its width, as joints are octagons. Needed with a
    /// `persistence` below 1.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub trace_length: Option<f64>,
    /// Greatest deviation of the angle of each joint from `dip`, degrees. Deviations are uniformly
    /// distributed. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 45, "x-unit" = "deg"))]
    pub dip_deviation: Option<f64>,
    /// In three dimensions: greatest deviation of the direction of each joint from `dip_direction`, degrees.
    /// Deviations are uniformly distributed. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 180, "x-unit" = "deg"))]
    pub dip_direction_deviation: Option<f64>,
    /// Greatest deviation of each joint from its place across the joints, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub spacing_deviation: Option<f64>,
    /// Greatest deviation of the length of each joint from `trace_length`, m. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub trace_deviation: Option<f64>,
    /// Point through which one joint passes if there is no deviation, [x, y] or [x, y, z], m. Default: the
    /// origin.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub origin: Option<Vector>,
    /// Seed of the places, lengths and deviations. Default: 1.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Dilation angle, degrees: sides that slip under friction move apart by its tangent times the slip. At
    /// most the residual friction angle. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 60, "x-unit" = "deg"))]
    pub dilation_angle: f64,
    /// Slip after which joints no longer dilate, m: asperities are worn. Default: 5 % of the length of the
    /// edge, or of the edges of an even face of the same area.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub dilation_slip: Option<f64>,
    /// Whether the joints are open at the start: they have no strength, carry no initial stress, and transmit
    /// pressure and friction only where they close, as contacts do. Default: false, joints are closed.
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
    /// Fracture energy of opening (mode I), J/m², with the elastic work up to the strength. Needed with a
    /// tensile strength.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "J/m²"))]
    pub fracture_energy_i: Option<f64>,
    /// Fracture energy of sliding (mode II), beyond friction, J/m², with the elastic work up to the strength.
    /// Needed with a cohesion.
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
    /// Hydraulic aperture of closed joints without compression, m: fluid can enter a set with an aperture
    /// from the beginning. Default: that of `[fluid]`.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "x-unit" = "m"))]
    pub aperture: Option<f64>,
    /// Smallest hydraulic aperture, m. Default: that of `[fluid]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub residual_aperture: Option<f64>,
    /// Largest hydraulic aperture, m. Default: that of `[fluid]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub max_aperture: Option<f64>,
    /// Effective compression, the total one less the pressure of the fluid, at which closed joints have a
    /// tenth of their `aperture`, Pa (Barton and Bandis). Default: that of `[fluid]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "Pa"))]
    pub reference_stress: Option<f64>,
    /// Factor of the opening in the hydraulic aperture, below 1 for rough walls. Default: that of `[fluid]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub roughness_factor: Option<f64>,
}
