//! The content of a checkpoint.

use fdem_simulation::State;
use serde::{Deserialize, Serialize};

use crate::command::run::account::Account;

/// The state of a run, with the state of its files.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "State<D, N>: Serialize", deserialize = "State<D, N>: Deserialize<'de>"))]
pub(crate) struct Checkpoint<const D: usize, const N: usize> {
    /// Hash of the model, [`Prepared::hash`](crate::model::Prepared).
    pub(crate) model: String,
    /// Step and time, s, of each frame that has been written.
    pub(crate) frames: Vec<(u64, f64)>,
    /// Length of the history, bytes.
    pub(crate) history: u64,
    /// Time between frames and time between rows of the history, s: they stay as they are if the end time changes.
    pub(crate) intervals: [f64; 2],
    /// Times and numbers since the beginning of the run.
    pub(crate) account: Account,
    pub(crate) state: State<D, N>,
}

/// The part of a [`Checkpoint`] that is known before frames and rows on their way to the disk are written.
pub(crate) struct Unsaved<const D: usize, const N: usize> {
    pub(crate) model: String,
    pub(crate) intervals: [f64; 2],
    pub(crate) account: Account,
    pub(crate) state: State<D, N>,
}
