//! The model file as it is written: tables and keys, their units and defaults. Descriptions here are those of the JSON schema.

mod body;
mod boundary;
mod material;
mod output;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

pub use body::{Body, Disc, Hole, Outline, Packing, Piece, Polygon, Rectangle, Ring, Voronoi};
pub use boundary::{Boundary, Component, Fixed, Side};
pub use material::{Interface, Material};
pub use output::{Animate, History, Output};

/// A model of the combined finite-discrete element method in two dimensions. SI units: m, kg, s, N, Pa; angles in degrees.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// What holds for the model as a whole.
    pub model: General,
    /// Bodies, each meshed by itself. Bodies touch, they do not share nodes.
    #[schemars(length(min = 1))]
    pub body: Vec<Body>,
    /// What bodies are made of.
    #[schemars(length(min = 1))]
    pub material: Vec<Material>,
    /// Contacts and joints between two materials, where they are not what the two materials say.
    #[serde(default)]
    pub interface: Vec<Interface>,
    /// What holds, moves and loads the bodies.
    #[serde(default)]
    pub boundary: Vec<Boundary>,
    /// State at the beginning.
    #[serde(default)]
    pub initial: Initial,
    /// How bodies touch.
    #[serde(default)]
    pub contact: Contact,
    /// How bodies break.
    #[serde(default)]
    pub fracture: Fracture,
    /// What is written.
    #[serde(default)]
    pub output: Output,
    /// Quantities that are recorded over time.
    #[serde(default)]
    pub history: Vec<History>,
}

/// What holds for the model as a whole.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct General {
    /// For people: shown in pictures and reports. Default: none.
    #[serde(default)]
    pub title: String,
    /// What vanishes out of the plane: "stress" (a thin plate, the default) or "strain" (a slice of a long body).
    #[serde(default)]
    pub plane: Plane,
    /// Out of the plane, m. Default: 1.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
    /// Acceleration [x, y], m/s², such as [0, -9.81], or "none". Default: "none".
    #[serde(default)]
    pub gravity: Gravity,
    /// When the run ends, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_time: f64,
    /// "auto" (the default: the critical time step times `safety`), or seconds.
    #[serde(default)]
    pub time_step: TimeStep,
    /// Share of the critical time step that "auto" takes. Default: 0.8.
    #[serde(default = "safety")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub safety: f64,
    /// Damping of nodes against their motion as a share of the force on them (Cundall); for states of rest. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 1))]
    pub local_damping: f64,
    /// A run stops when more energy than this share of all that was in the system appears or vanishes. Default: 0.05.
    #[serde(default = "energy_bound")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy_bound: f64,
}

/// What vanishes out of the plane.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// A thin plate.
    #[default]
    Stress,
    /// A slice of a long body.
    Strain,
}

/// A vector, or none.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Gravity {
    /// m/s².
    Vector([f64; 2]),
    /// No gravity.
    None(NoGravity),
}

/// The word for no gravity.
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

/// A number, or what decides it.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum TimeStep {
    /// Seconds.
    Seconds(#[schemars(extend("exclusiveMinimum" = 0))] f64),
    /// From the critical time step.
    Auto(AutoStep),
}

/// The word for a time step that follows from the model.
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

/// State at the beginning.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Velocity [x, y] of bodies by their names, m/s, such as { hammer = [0, -5] }. Bodies that are not named rest, or move as their own `velocity` says.
    #[serde(default)]
    pub velocity: BTreeMap<String, [f64; 2]>,
    /// Stress [xx, yy, xy] in all bodies, Pa, tension positive. Default: none.
    #[serde(default)]
    pub stress: Option<[f64; 3]>,
}

/// How bodies touch.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Penalty of the contact potential over Young's modulus, of the softer of two. Default: 2.
    #[serde(default = "penalty")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub penalty: f64,
    /// Stiffness of friction before it slips, over that of the contact. Default: 0.5.
    #[serde(default = "tangential_stiffness")]
    #[schemars(extend("minimum" = 0))]
    pub tangential_stiffness: f64,
    /// Share of critical damping of normal contact motion. Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 1))]
    pub damping: f64,
    /// Gap up to which couples are kept between detections, over the mean edge. Default: 0.1.
    #[serde(default = "buffer")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub buffer: f64,
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            penalty: penalty(),
            tangential_stiffness: tangential_stiffness(),
            damping: 0.0,
            buffer: buffer(),
        }
    }
}

/// How bodies break. Only materials that have a strength do.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fracture {
    /// Which joints there are: "adaptive" (the default: where the traction across an edge has reached the strength) or "intrinsic" (everywhere).
    #[serde(default)]
    pub insertion: Insertion,
    /// Penalty of joints, α of α E/h, with h the mean height of the two elements over the edge. Default: 50.
    #[serde(default = "joint_penalty")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub joint_penalty: f64,
    /// "exact" (the default: a joint dissipates the fracture energy) or "customary" (3 G/f, which dissipates 1.16 G).
    #[serde(default)]
    pub critical_opening: CriticalOpening,
}

impl Default for Fracture {
    fn default() -> Self {
        Self {
            insertion: Insertion::default(),
            joint_penalty: joint_penalty(),
            critical_opening: CriticalOpening::default(),
        }
    }
}

/// Which joints there are between elements.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Insertion {
    /// Where the traction across an edge has reached the strength.
    #[default]
    Adaptive,
    /// Everywhere from the beginning.
    Intrinsic,
}

/// How the critical opening follows from the fracture energy.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CriticalOpening {
    /// A joint dissipates the fracture energy.
    #[default]
    Exact,
    /// 3 G/f.
    Customary,
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

fn penalty() -> f64 {
    fdem_simulation::ContactOptions::default().penalty
}

fn tangential_stiffness() -> f64 {
    fdem_simulation::ContactOptions::default().tangential_stiffness
}

fn buffer() -> f64 {
    fdem_simulation::ContactOptions::default().buffer
}

fn joint_penalty() -> f64 {
    fdem_simulation::FractureOptions::default().joint_penalty
}
