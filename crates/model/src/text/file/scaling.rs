//! `mass_scaling`: mass that is added for a longer time step.

use schemars::JsonSchema;
use serde::Deserialize;

/// Mass that is added to elements so that the run can take a longer time step, for quasi-static runs. The
/// added mass has inertia, and no weight: forces at rest are the same. Each node gets the missing mass on the
/// stiffest of its elements.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "mass_scaling")]
pub struct MassScaling {
    /// Time step of the run, s, in place of `time_step` of `[model]`. All elements get the mass with which
    /// the critical time step is this one over `safety`.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub time_step: f64,
    /// Largest mass that may be added, as a share of the mass of the model. A time step that needs more is an
    /// error. Default: 0.1.
    #[serde(default = "tenth")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1"))]
    pub added_mass: f64,
    /// Kinetic over strain energy up to which the run is quasi-static. A run that exceeds it ends with a
    /// warning. Rows of the history count where the strain energy is at least 10 % of its largest.
    /// Default: 0.1.
    #[serde(default = "tenth")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1"))]
    pub kinetic_energy: f64,
}

fn tenth() -> f64 {
    0.1
}
