//! Times of a run, summed over all parts of an interrupted run.

use std::time::Duration;

use fdem_simulation::{Element, Simulation, Timings};
use serde::{Deserialize, Serialize};

/// Parts of a step, in their order.
pub(crate) const PARTS: [&str; 5] = ["bulk", "joints", "detection", "contact force", "integration"];

/// Times and numbers summed over all parts of a run. A checkpoint stores them, because a [`Simulation`] counts only from its own creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Account {
    /// Wall-clock time, s.
    pub(crate) seconds: f64,
    /// Part of [`Self::seconds`] spent on results: files, plots, the report, s.
    pub(crate) output: f64,
    /// Time in each of [`PARTS`], s.
    pub(crate) parts: [f64; PARTS.len()],
    /// Number of detections of couples.
    pub(crate) detections: u64,
}

impl Account {
    /// Adds the times of a simulation since its creation, with the wall-clock time and the time for results since then.
    pub(crate) fn and<const D: usize, const N: usize>(
        &self,
        run: &Simulation<D, N>,
        clock: Duration,
        output: Duration,
    ) -> Self
    where
        [[f64; D]; N]: Element<D, N>,
    {
        let Timings { bulk, joints, detection, contact, integration } = run.timings();
        let mut parts = self.parts;
        for (sum, time) in parts.iter_mut().zip([bulk, joints, detection, contact, integration]) {
            *sum += time.as_secs_f64();
        }
        Self {
            seconds: self.seconds + clock.as_secs_f64(),
            output: self.output + output.as_secs_f64(),
            parts,
            detections: self.detections + run.counts().detections,
        }
    }

    /// Time in the steps, s.
    pub(crate) fn busy(&self) -> f64 {
        self.parts.iter().sum()
    }
}
