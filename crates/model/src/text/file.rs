//! Tables and keys of a model file, with units and defaults. The doc comments here are the descriptions in
//! the JSON schema.

mod body;
mod joint_set;
mod boundary;
mod coming;
mod condition;
mod fluid;
mod grains;
mod ground;
mod material;
mod output;
mod pores;
mod principal;
mod scaling;
mod stage;
mod vector;

use std::collections::BTreeMap;

use fdem_simulation::{ContactOptions, FractureOptions, Plane};
use schemars::JsonSchema;
use serde::Deserialize;

pub(crate) use body::SHAPES;
pub use body::{
    Block, Body, CopiesOf, Cylinder, Disc, Extrusion, Hole, Outline, Packing, PieceShape, Polygon,
    Polyhedron, Rectangle, Refine, Region, Ring, Sphere, Tube, Voronoi,
};
pub use boundary::{Boundary, Component, Fixed, Rotation, Side};
pub use coming::{BoxRegion, SphereInsertion, SphereRemoval};
pub use condition::{Servo, Until};
pub use fluid::{ConnectionWord, Fluid, Injection, SchemeWord, WetFromWord};
pub use grains::{
    ClumpOrientation, ClumpSphere, Domain, DomainAxis, DomainServo, GrainRadius, GrainRegion, Grains,
    NormalRadius, OutsideWord, RoundRegion, SphereLaw, SphereOptions, Wall, WallBox, WallCircle, WallCone,
    WallDisc, WallPlane, WallServo, WallTube,
};
pub use ground::{Ground, Ratio};
pub use joint_set::JointSet;
pub use material::{Interface, Material};
pub use output::{AcousticEmission, Animate, Coarse, Curve, History, Mean, Measured, Output};
pub use pores::{MaterialPores, Permeability, PoreSurface, Pores};
pub use principal::Principal;
pub use scaling::MassScaling;
pub use stage::{Release, Stage};
pub use vector::{Spin, Vector};

/// A model of the combined finite-discrete element method in two or three dimensions. SI units: m, kg, s, N,
/// Pa; angles in degrees.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Files whose tables are added to those of this file: "materials.toml", or a list of files. Paths are
    /// relative to this file. Where both have the same key of a table that comes once, such as `[model]`,
    /// that of this file wins.
    #[serde(default)]
    pub include: Option<Include>,
    /// Numbers with names of your own, for use in all other values: radius = 0.025, or radius = "25 mm". They
    /// may use each other.
    #[serde(default)]
    pub parameters: BTreeMap<String, Parameter>,
    /// Settings of the model as a whole.
    pub model: General,
    /// Bodies. Each is meshed separately; bodies touch, but share no nodes. A model has a body,
    /// `[[grains]]` or an `[[insertion]]`.
    #[serde(default)]
    pub body: Vec<Body>,
    /// Spheres, in two dimensions discs.
    #[serde(default)]
    pub grains: Vec<Grains>,
    /// Spheres that come in during the run.
    #[serde(default)]
    pub insertion: Vec<SphereInsertion>,
    /// Boxes in which spheres are removed.
    #[serde(default)]
    pub delete: Vec<SphereRemoval>,
    /// Walls that spheres touch.
    #[serde(default)]
    pub wall: Vec<Wall>,
    /// The law of the contacts of spheres.
    #[serde(default)]
    pub spheres: SphereOptions,
    /// The box in which the spheres are. Default: space without ends.
    #[serde(default)]
    pub domain: Option<Domain>,
    /// Materials of the bodies, spheres and walls.
    #[schemars(length(min = 1))]
    pub material: Vec<Material>,
    /// Contacts and joints between two materials, where they differ from the values of the two materials.
    #[serde(default)]
    pub interface: Vec<Interface>,
    /// Joint sets and fracture networks in the bodies, each with a separate law.
    #[serde(default)]
    pub joint_set: Vec<JointSet>,
    /// Supports, motions and loads of the bodies.
    #[serde(default)]
    pub boundary: Vec<Boundary>,
    /// Fluid in holes, joints and cracks. Default: none.
    #[serde(default)]
    pub fluid: Option<Fluid>,
    /// Places where the fluid enters.
    #[serde(default)]
    pub injection: Vec<Injection>,
    /// Liquid in the pores of materials. Default: none.
    #[serde(default)]
    pub pores: Option<Pores>,
    /// Drained surfaces, flows through surfaces, and wells of the liquid in pores.
    #[serde(default)]
    pub pore_surface: Vec<PoreSurface>,
    /// Parts of the run, one after the other. Default: the run is one.
    #[serde(default)]
    pub stage: Vec<Stage>,
    /// State at the start of the run.
    #[serde(default)]
    pub initial: Initial,
    /// Numbers of the contact law.
    #[serde(default)]
    pub contact: ContactOptions,
    /// Numbers of fracture.
    #[serde(default)]
    pub fracture: FractureOptions,
    /// Results to write.
    #[serde(default)]
    pub output: Output,
    /// Quantities to record over time.
    #[serde(default)]
    pub history: Vec<History>,
    /// Curves of one quantity over another.
    #[serde(default)]
    pub curve: Vec<Curve>,
}

impl ModelFile {
    /// Names of the groups of spheres: first of all `[[grains]]`, then of all `[[insertion]]`.
    pub(crate) fn groups_of_spheres(&self) -> impl Iterator<Item = &str> {
        let placed = self.grains.iter().map(|of| of.name.as_str());
        placed.chain(self.insertion.iter().map(|of| of.name.as_str()))
    }

    /// The names of all tables.
    pub(crate) const TABLES: [&str; 23] = [
        "model",
        "body",
        "grains",
        "insertion",
        "delete",
        "wall",
        "spheres",
        "domain",
        "material",
        "interface",
        "joint_set",
        "boundary",
        "fluid",
        "injection",
        "pores",
        "pore_surface",
        "stage",
        "initial",
        "contact",
        "fracture",
        "output",
        "history",
        "curve",
    ];

    /// Whether there are spheres, at the beginning or later.
    pub(crate) fn has_spheres(&self) -> bool {
        !self.grains.is_empty() || !self.insertion.is_empty()
    }
}

/// One file, or several.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Include {
    /// A file.
    One(String),
    /// Several files.
    Several(Vec<String>),
}

/// A number, or an expression.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Parameter {
    /// A number.
    Number(f64),
    /// An expression, such as "2*radius" or "25 mm".
    Expression(String),
}

/// Settings of the model as a whole.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct General {
    /// Title for pictures and reports. Default: none.
    #[serde(default)]
    pub title: String,
    /// Dimensions: 2 or 3. Default: those of the shapes and meshes of the bodies.
    #[serde(default)]
    #[schemars(range(min = 2, max = 3))]
    pub dimensions: Option<u8>,
    /// In two dimensions: plane "stress" (a thin plate, the default) or plane "strain" (a slice of a long
    /// body).
    #[serde(default)]
    pub plane: Plane,
    /// In two dimensions: thickness out of the plane, m. Default: 1.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "m"))]
    pub thickness: f64,
    /// Acceleration of gravity [x, y] or [x, y, z], m/s², such as [0, -9.81] or [0, 0, -9.81], or "none".
    /// Default: "none".
    #[serde(default)]
    #[schemars(extend("x-unit" = "m/s²"))]
    pub gravity: Gravity,
    /// Time within which gravity grows from 0 to its full value, as half a cosine, s. Gravity without a ramp
    /// makes stresses swing to twice their static values. Default: full gravity from the first step.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub gravity_ramp: Option<f64>,
    /// Time at which the run ends, s.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub end_time: f64,
    /// Time step, s, or "auto" (the default): the critical time step times `safety`.
    #[serde(default)]
    #[schemars(extend("x-unit" = "s"))]
    pub time_step: TimeStep,
    /// Time step of "auto" over the critical one. Default: 0.8.
    #[serde(default = "safety")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "1"))]
    pub safety: f64,
    /// Mass that is added for a longer time step in a quasi-static run, such as
    /// `{ time_step = "1e-6 s", added_mass = 0.05 }`. Default: none.
    #[serde(default)]
    pub mass_scaling: Option<MassScaling>,
    /// Local damping (Cundall): a force against the motion of each node, as a share of the force on it.
    /// Suited to finding states of rest. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 1, "x-unit" = "1"))]
    pub local_damping: f64,
    /// Dynamic relaxation, for runs that are to end in equilibrium: a force against the velocity of each
    /// node, whose factor follows the slowest motion. It needs no coefficient. The motion on the way to
    /// equilibrium is not physical.
    #[serde(default)]
    pub dynamic_relaxation: bool,
    /// Condition at which the run ends before its `end_time`, such as
    /// `{ column = "platen fy", share_of_peak = 0.5 }`. Default: none.
    #[serde(default)]
    pub until: Option<Until>,
    /// Error of the energy balance at which a run stops, as a share of the energy that has been exchanged.
    /// Default: 0.05.
    #[serde(default = "energy_bound")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1"))]
    pub energy_bound: f64,
}

/// A vector, or none.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Gravity {
    /// m/s².
    Vector(Vector),
    /// No gravity.
    None(NoGravity),
}

/// The word "none".
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NoGravity {
    /// No gravity.
    None,
}

impl Default for Gravity {
    fn default() -> Self {
        Self::None(NoGravity::None)
    }
}

/// A time step, or a word for its choice.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum TimeStep {
    /// Seconds.
    Seconds(#[schemars(extend("exclusiveMinimum" = 0))] f64),
    /// Chosen from the critical time step.
    Auto(AutoStep),
}

/// The word "auto".
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AutoStep {
    /// The critical time step times `safety`.
    Auto,
}

impl Default for TimeStep {
    fn default() -> Self {
        Self::Auto(AutoStep::Auto)
    }
}

/// State at the start of the run.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Velocity [x, y] or [x, y, z] of bodies by name, m/s, such as { hammer = [0, -5] }. Bodies that are not
    /// named here have their own `velocity`, or rest.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m/s"))]
    pub velocity: BTreeMap<String, Vector>,
    /// Stress [xx, yy, xy] or [xx, yy, zz, xy, yz, xz] in all bodies, Pa, tension positive. Surfaces that
    /// touch, joints and absorbing boundaries carry it from the beginning. Default: none.
    #[serde(default)]
    #[schemars(length(min = 3, max = 6))]
    #[schemars(extend("x-unit" = "Pa"))]
    pub stress: Option<Vec<f64>>,
    /// Stress in all bodies by its principal values and their directions, in place of `stress`. Default:
    /// none.
    #[serde(default)]
    pub principal: Option<Principal>,
    /// Change of that stress per metre upwards (y in two dimensions, z in three), Pa/m, with the components
    /// of `stress`; `stress` or `principal` is that at height 0. A yy, or zz, of density times gravity
    /// carries the weight. Default: none.
    #[serde(default)]
    #[schemars(length(min = 3, max = 6))]
    #[schemars(extend("x-unit" = "Pa/m"))]
    pub stress_gradient: Option<Vec<f64>>,
    /// Stress of ground at rest under its own weight, added to the others. Default: none.
    #[serde(default)]
    pub ground: Option<Ground>,
}

impl Initial {
    /// The stress at height 0 in `dimensions`, as components in the order of the model file.
    pub(crate) fn components(&self, dimensions: usize) -> Option<Vec<f64>> {
        let of_principal = || self.principal.as_ref().map(|principal| principal.components(dimensions));
        self.stress.clone().or_else(of_principal)
    }
}

fn one() -> f64 {
    1.0
}

fn safety() -> f64 {
    fdem_simulation::TimeOptions::default().safety
}

fn energy_bound() -> f64 {
    fdem_simulation::TimeOptions::default().energy_bound
}
