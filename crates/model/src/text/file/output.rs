//! `[output]`, `[[history]]` and `[[curve]]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use fdem_results::Field;

use crate::text::file::vector::Vector;

/// Results to write.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Time between result files, s, instead of `frames`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub interval: Option<f64>,
    /// Number of result files after the first, which is of the start, at equal intervals. Default: 50.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub frames: Option<u32>,
    /// Fields that pictures and the report show; result files for ParaView have all fields. Default:
    /// `max_principal`, `velocity`, `damage`.
    #[serde(default)]
    pub fields: Option<Vec<Field>>,
    /// Animation (GIF): true for the first of `fields`, or the name of a field. Default: false.
    #[serde(default)]
    pub animate: Option<Animate>,
    /// Triangles that pictures and the report show at most; a larger mesh is shown by a sample of this size.
    /// Default: all, and 250,000 of more than 1,000,000.
    #[serde(default)]
    #[schemars(range(min = 100, max = 1_000_000))]
    pub shown_elements: Option<u32>,
    /// true: joints that hold are shown as well, whole ones and ones that soften: a layer of the report's
    /// page, thin lines of pictures, and for the whole ones `intact_joints.pvd`. They are those of joint
    /// sets, such as faults and bedding; with intrinsic joints every facet has one. Default: false.
    #[serde(default)]
    pub intact_joints: bool,
    /// Names of bodies whose fragments are counted in the history, the summary and the plots. Default: all
    /// bodies that can break, or all if none can.
    #[serde(default)]
    pub fragments: Option<Vec<String>>,
    /// Acoustic emission, `{}` or with limits: `events.csv`, a plot of the frequency of magnitudes, and the
    /// b-value in the summary. Default: none.
    #[serde(default)]
    pub acoustic_emission: Option<AcousticEmission>,
    /// Spheres as a continuum: `coarse.pvd` with density, velocity and stress on a grid, in every frame.
    /// Default: none.
    #[serde(default)]
    pub coarse: Option<Coarse>,
    /// Time between rows of the history, s. Default: a thousandth of the end time.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub history_interval: Option<f64>,
    /// Wall-clock time between checkpoints, s. Default: 60.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub checkpoint_interval: Option<f64>,
    /// Steps between checkpoints, instead of `checkpoint_interval`.
    #[serde(default)]
    #[schemars(range(min = 1))]
    pub checkpoint_steps: Option<u64>,
}

/// Acoustic emission: joints that break, or begin to soften, near each other in space and time are one event.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "acoustic_emission")]
pub struct AcousticEmission {
    /// Whether joints that soften and hold are events, too; `false`: only those that broke. Default: true.
    #[serde(default)]
    pub softening: Option<bool>,
    /// Largest distance of two joints that are linked, m. Default: twice the size of a facet, the mean over
    /// all that emit.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub distance: Option<f64>,
    /// Largest time between two joints that are linked, s. Default: the time in which a shear
    /// wave of the slowest material that can break travels `distance`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub window: Option<f64>,
}

/// A grid on which spheres are a continuum: sums over the spheres and their contacts, weighted with a kernel
/// (Goldhirsch 2010).
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "coarse")]
pub struct Coarse {
    /// Distance of neighbouring points, m.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub spacing: f64,
    /// Width of the kernel, m: half of its reach. One to three radii of the spheres show a continuum.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub width: f64,
    /// The box of the grid [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m.
    #[serde(rename = "box")]
    #[schemars(rename = "box", length(min = 4, max = 6))]
    #[schemars(extend("x-unit" = "m"))]
    pub limits: Vec<f64>,
}

/// Whether there is an animation, and its field.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Animate {
    /// An animation of the first of the fields, or none.
    Switch(bool),
    /// An animation of this field.
    Field(Field),
}

/// A point, or the word "mean".
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Measured {
    /// The element at [x, y] or [x, y, z], m.
    Point(Vector),
    /// All elements of `body` whose centroids are in `box`.
    Mean(Mean),
}

/// The word "mean".
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mean {
    /// Mean over elements.
    Mean,
}

/// A quantity that is recorded over time. It has exactly one of the keys `node`, `force`, `stress`, `strain`,
/// `velocity`, `gauge`, `contact_force`, `reaction`, `cavity`, `joint_set`, `motion`, `wall`, `grains`,
/// `softening`, `energy` and `crack_length`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(clippy::struct_excessive_bools, reason = "a switch of the file is a key of its own")]
pub struct History {
    /// Name of its column.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Displacement and velocity of the node nearest to [x, y] or [x, y, z], m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub node: Option<Vector>,
    /// Name of a body: only its nodes and elements count for `node`, `stress`, `strain`, `velocity`,
    /// `pore_pressure`, `gauge` and `reaction`. Default: all bodies.
    #[serde(default)]
    pub body: Option<String>,
    /// Box [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m: of the undeformed bodies, for
    /// a "mean": elements whose centroids are inside; for `grains`: spheres whose centres are inside.
    /// Default: no limits.
    #[serde(default, rename = "box")]
    #[schemars(extend("x-unit" = "m"), rename = "box", length(min = 4, max = 6))]
    pub limits: Option<Vec<f64>>,
    /// Cauchy stress, Pa, tension positive: of the element at a point [x, y] or [x, y, z] of the undeformed
    /// bodies, m, or "mean": the mean over `body` and `box`, weighted by area or volume.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub stress: Option<Measured>,
    /// Green-Lagrange strain, measured in the same way. Its shear components are half of the changes of
    /// angles.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub strain: Option<Measured>,
    /// Velocity, m/s: at a point, or "mean", weighted by mass.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub velocity: Option<Measured>,
    /// Pressure of the liquid in pores at a point [x, y] or [x, y, z] of the undeformed bodies, m: Pa, linear
    /// within its element.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub pore_pressure: Option<Vector>,
    /// Strain gauge between two points [[x, y], [x, y]] or [[x, y, z], [x, y, z]] of the undeformed bodies,
    /// m: change of their distance over that distance.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"), length(min = 2, max = 2))]
    pub gauge: Option<Vec<Vector>>,
    /// Names of two bodies or groups of spheres: the force that the first exerts on the second by contact,
    /// N. The name of a packing means all of its pieces.
    #[serde(default)]
    #[schemars(length(min = 2, max = 2))]
    pub contact_force: Option<Vec<String>>,
    /// Name of a group of nodes, such as "outer" or a physical group of a mesh file: the force of all
    /// boundaries on its nodes, N.
    #[serde(default)]
    pub reaction: Option<String>,
    /// Name of a boundary with `cavity = true`: pressure, Pa, volume, m³, area of its faces, m², work of the
    /// pressure, J, and energy of a gas in it, J.
    #[serde(default)]
    pub cavity: Option<String>,
    /// Name of a `[[joint_set]]`: mean opening and slip of its joints, m, and mean normal and shear stress on
    /// them, Pa, tension positive, weighted by length or area, in every state of the joints.
    #[serde(default)]
    pub joint_set: Option<String>,
    /// Name of a rigid body: displacement of its centre of mass, m, and its velocity, m/s, its rotation since
    /// the start, rad, and its angular velocity, rad/s. In three dimensions the rotation is a vector along
    /// its axis, as long as its angle. Whole turns add up.
    #[serde(default)]
    pub motion: Option<String>,
    /// Name of a wall: force of the spheres on it, N, their moment about its axis or else the origin, N m,
    /// and its displacement, m.
    #[serde(default)]
    pub wall: Option<String>,
    /// true: the spheres in the `box`, or all: their number, coordination (contacts of a sphere in the mean),
    /// solid fraction, kinetic energy, J, mean stress by Love and Weber, Pa, tension positive, fabric, and
    /// the sides of the region, m. All spheres of a `[domain]` that repeats are in its box.
    #[serde(default)]
    pub grains: bool,
    /// true: length, m, or area, m², of all joints past their strength, whether they soften or are broken,
    /// and the same with the damage of each joint as a factor.
    #[serde(default)]
    pub softening: bool,
    /// Name of a boundary: its total force on the bodies, N, and the mean displacement of its nodes, m; with
    /// `rotation` also its moment on the bodies about its axis, N m, positive as its `speed`.
    #[serde(default)]
    pub force: Option<String>,
    /// true: all energies, J. They are recorded in any case.
    #[serde(default)]
    pub energy: bool,
    /// true: length of the cracks, m, or their area, m². It is recorded in any case.
    #[serde(default)]
    pub crack_length: bool,
    /// Time between rows, s. The history is one table with the shortest of all intervals. Default: that of
    /// `[output]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub interval: Option<f64>,
}

/// A curve of one column of the history over another, with its peak and its modulus in the summary: force and
/// displacement, stress and strain.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Name of the curve and of its plot.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Column across: the name of a history and its part, such as "axial strain" of a gauge or "top uy" of a
    /// force, or a column of every history, such as "time".
    pub x: String,
    /// Column upwards, such as "top fy" or "core syy".
    pub y: String,
    /// Length by which a displacement across is divided, m, so that it is a strain. Default: none.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub length: Option<f64>,
    /// Area by which a force upwards is divided, m², so that it is a stress; in two dimensions width times
    /// `thickness`. Default: none.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m²"))]
    pub area: Option<f64>,
    /// Column of a history with `softening = true`, such as `"cracks softening_length"`: the summary gives
    /// the value upwards at which cracks initiate, where the first joints soften.
    #[serde(default)]
    pub softening: Option<String>,
    /// Whether the curve may be without values. A curve without values is otherwise a warning at the end of
    /// the run. Default: false.
    #[serde(default)]
    pub optional: bool,
    /// Columns of the strains across the axis of a test in compression, one in two dimensions and two in
    /// three: their sum and the strain `x` is the volumetric strain, and the summary gives the crack-damage
    /// stress, at which it turns from contraction to dilation.
    #[serde(default)]
    #[schemars(length(min = 1, max = 2))]
    pub lateral: Option<Vec<String>>,
}
