//! `[output]` and `[[history]]`.

use schemars::JsonSchema;
use serde::Deserialize;

use fdem_results::Field;

use crate::model::file::vector::Vector;

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
    /// Fields that pictures and the report show; result files for ParaView have all fields. Default: `max_principal`, `velocity`, `damage`.
    #[serde(default)]
    pub fields: Option<Vec<Field>>,
    /// Animation (GIF): true for the first of `fields`, or the name of a field. Default: false.
    #[serde(default)]
    pub animate: Option<Animate>,
    /// Triangles that pictures and the report show at most; a larger mesh is shown by a sample of as many. Default: all, and 250,000 of more than 1,000,000.
    #[serde(default)]
    #[schemars(range(min = 100, max = 1_000_000))]
    pub shown_elements: Option<u32>,
    /// Names of bodies whose fragments are counted in the history, the summary and the plots. Default: all bodies that can break, or all if none can.
    #[serde(default)]
    pub fragments: Option<Vec<String>>,
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

/// Whether there is an animation, and its field.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Animate {
    /// An animation of the first of the fields, or none.
    Switch(bool),
    /// An animation of this field.
    Field(Field),
}

/// A quantity that is recorded over time. It has exactly one of the keys `node`, `force`, `energy` and `crack_length`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// Name of its column.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Displacement and velocity of the node nearest to [x, y] or [x, y, z], m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub node: Option<Vector>,
    /// Body among whose nodes the one nearest to `node` is taken. Default: all bodies.
    #[serde(default)]
    pub body: Option<String>,
    /// Name of a boundary: its total force on the bodies, N, and the mean displacement of its nodes, m.
    #[serde(default)]
    pub force: Option<String>,
    /// true: all energies, J. They are recorded in any case.
    #[serde(default)]
    pub energy: bool,
    /// true: length of the cracks, m, or their area, m². It is recorded in any case.
    #[serde(default)]
    pub crack_length: bool,
    /// Time between rows, s. The history is one table with the shortest of all intervals. Default: that of `[output]`.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s"))]
    pub interval: Option<f64>,
}
