//! `[[stage]]`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::text::file::condition::Until;

/// A part of the run, in the order of the file. A stage lasts until its `duration` has passed, its
/// `equilibrium` is reached or its `until` is met, whichever is first; the last one, if it has none of them,
/// until the end of the run. Then the next one begins.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    /// Name of the stage for boundaries and messages.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Time that the stage takes at most, s. Default: no limit but the end of the run.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub duration: Option<f64>,
    /// Bound at which the stage ends: the kinetic energy over the strain energy, and the largest force on a
    /// free node over the largest that an element exerts on one of its nodes, are both below it. It is looked
    /// at with each row of the history, once releases and ramps are over. Default: none.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1"))]
    pub equilibrium: Option<f64>,
    /// Condition on the history at which the stage ends, such as `{ column = "crown uy", below = -2e-3 }`.
    /// Default: none.
    #[serde(default)]
    pub until: Option<Until>,
    /// Names of bodies that vanish at the beginning of the stage.
    #[serde(default)]
    pub excavate: Vec<String>,
    /// Boxes [xmin, ymin, xmax, ymax] or [xmin, ymin, zmin, xmax, ymax, zmax], m: the elements with their
    /// centroids inside vanish at the beginning of the stage.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub excavate_boxes: Vec<Vec<f64>>,
    /// Names of bodies that appear at the beginning of the stage, with their `velocity` and without initial
    /// stress. Before it they are not there.
    #[serde(default)]
    pub activate: Vec<String>,
    /// Materials of bodies from this stage on, `{ core = "soft rock" }`: the core of a tunnel is softened,
    /// ground is grouted. The strain stays, the stress follows the new stiffness, and the initial stress is
    /// scaled by the ratio of Young's moduli; the load that this takes from the rest is released with
    /// `release`. A new material has the density of the old one.
    #[serde(default)]
    pub materials: BTreeMap<String, String>,
    /// Release of the forces with which vanished bodies and ended boundaries held the rest: the time within
    /// which they fall to 0, s, or a table [[time, factor], …], s from the beginning of the stage. A factor
    /// that stays above 0 leaves that share of the forces (the core of a tunnel that is only partly
    /// relieved), until a later stage with a `release` removes it. Default: released in one step.
    #[serde(default)]
    pub release: Option<Release>,
    /// Local damping (Cundall) in this stage, in place of that of `[model]`.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 1, "x-unit" = "1"))]
    pub local_damping: Option<f64>,
    /// Dynamic relaxation in this stage, in place of that of `[model]`.
    #[serde(default)]
    pub dynamic_relaxation: Option<bool>,
    /// Whether displacements count from the beginning of this stage: those of frames and of the history, not
    /// the goals of boundaries.
    #[serde(default)]
    pub reset_displacements: bool,
}

/// A time, or a table of factors.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Release {
    /// Time within which the forces fall to 0, s.
    Within(#[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))] f64),
    /// Times, s, and factors.
    Table(#[schemars(length(min = 1), extend("x-unit" = ["s", "1"]))] Vec<[f64; 2]>),
}
