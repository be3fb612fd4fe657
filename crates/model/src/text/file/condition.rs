//! `until` and `servo`: reactions of a run to a column of its history.

use schemars::JsonSchema;
use serde::Deserialize;

/// A condition on a column of the history: exactly one of `above`, `below` and `share_of_peak`. It is looked
/// at with each row of the history.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "until")]
pub struct Until {
    /// Column of the history: the name of a `[[history]]` and its part, such as "platen fy" or "axial
    /// strain", or a column of every history, such as `broken_joints`.
    pub column: String,
    /// Met when the column is above this, in its unit.
    #[serde(default)]
    pub above: Option<f64>,
    /// Met when the column is below this, in its unit.
    #[serde(default)]
    pub below: Option<f64>,
    /// Met when the magnitude of the column has fallen to this share of its largest so far, in this stage or
    /// in this run: 0.5 is half of the peak.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1, "x-unit" = "1"))]
    pub share_of_peak: Option<f64>,
    /// Magnitude below which nothing counts as a peak, for `share_of_peak`, in the unit of the column.
    /// Default: 0.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub least_peak: Option<f64>,
}

/// Control of a velocity, so that a column of the history gets to a target and stays there. The velocity is
/// that of the boundary while the column is farther than `band` from the target, less the nearer it is, and
/// backwards beyond the target. The `ramp` or the `table` of the boundary is that of the target.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "servo")]
pub struct Servo {
    /// Column of a `[[history]]`, such as "platen fy", "core syy" or "axial strain". The velocity of the
    /// boundary moves it from 0 towards the target.
    pub column: String,
    /// The target value of the column, in its unit.
    pub target: f64,
    /// Distance from the target within which the velocity falls, as a share of the target: a wide band is
    /// steady, a narrow one quick. Default: 0.1.
    #[serde(default = "band")]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1"))]
    pub band: f64,
    /// Time steps between two looks at the column. Default: 10.
    #[serde(default = "steps")]
    #[schemars(range(min = 1))]
    pub steps: u32,
}

fn band() -> f64 {
    0.1
}

fn steps() -> u32 {
    10
}
