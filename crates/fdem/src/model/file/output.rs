//! `[output]` and `[[history]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::results::Field;

/// What is written.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Time between result files, s, instead of `frames`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Number of result files after that of the beginning, at equal intervals. Default: 50.
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub frames: Option<u32>,
    /// What pictures and the report show; result files for ParaView have everything. Default: `max_principal`, `velocity`, `damage`.
    #[serde(default)]
    pub fields: Option<Vec<Field>>,
    /// An animation (GIF): true, for the first of `fields`, or the name of a field. Default: false.
    #[serde(default)]
    pub animate: Option<Animate>,
    /// Time between rows of the history, s. Default: a thousandth of the end time.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub history_interval: Option<f64>,
    /// Time on the clock between checkpoints, s. Default: 60.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub checkpoint_interval: Option<f64>,
    /// Steps between checkpoints, instead of `checkpoint_interval`.
    #[serde(default)]
    #[schemars(range(min = 1))]
    pub checkpoint_steps: Option<u64>,
}

/// Whether there is an animation, and of what.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Animate {
    /// Of the first of the fields, or none.
    Switch(bool),
    /// Of this.
    Field(Field),
}

/// A quantity that is recorded over time. It has exactly one of the keys `node`, `force`, `energy` and `crack_length`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// Of its column.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Displacement and velocity of the node nearest to [x, y], m.
    #[serde(default)]
    pub node: Option<[f64; 2]>,
    /// Of `node`: only nodes of this body. Default: all.
    #[serde(default)]
    pub body: Option<String>,
    /// Name of a boundary: the force, in all, that it exerts on the bodies, N.
    #[serde(default)]
    pub force: Option<String>,
    /// true: all energies, J; they are recorded whether or not this is here.
    #[serde(default)]
    pub energy: bool,
    /// true: length of what is broken, m; it is recorded whether or not this is here.
    #[serde(default)]
    pub crack_length: bool,
    /// Time between records, s. The history is one table: the shortest of all intervals holds. Default: that of `[output]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}
