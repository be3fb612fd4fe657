//! The content of a checkpoint.

use fdem_simulation::{Boundary, State};
use serde::{Deserialize, Serialize};

use crate::command::run::account::Account;
use crate::command::run::beginning::Beginning;
use fdem_model::{Entered, Reached};

/// The state of a run. The state of its files is in the [`Manifest`](super::manifest::Manifest).
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "State<D, N>: Serialize, Boundary<D>: Serialize, [f64; D]: Serialize",
    deserialize = "State<D, N>: Deserialize<'de>, Boundary<D>: Deserialize<'de>, [f64; D]: Deserialize<'de>"
))]
pub(crate) struct Checkpoint<const D: usize, const N: usize> {
    /// Hash of the model, [`Prepared::hash`](fdem_model::Prepared).
    pub(crate) model: String,
    /// Time between frames and time between rows of the history, s: they stay as they are if the end time
    /// changes.
    pub(crate) intervals: [f64; 2],
    /// The stages so far; none if the run is one.
    pub(crate) entered: Entered<D>,
    /// Peaks of the conditions that end the run and its stages, and whether the run is over.
    pub(crate) reached: Reached,
    /// When it has begun from another run.
    pub(crate) begun: Option<Beginning>,
    /// Times and numbers since the beginning of the run.
    pub(crate) account: Account,
    pub(crate) state: State<D, N>,
}
