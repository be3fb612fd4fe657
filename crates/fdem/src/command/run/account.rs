//! Times of a run, summed over all parts of an interrupted run.

use std::time::Duration;

use fdem_simulation::Timings;
use serde::{Deserialize, Serialize};

/// Parts of a step, in their order.
pub(crate) const PARTS: [&str; 7] =
    ["bulk", "joints", "detection", "contact force", "spheres", "integration", "messages"];

/// Times and numbers summed over all parts of a run. A checkpoint stores them, because a simulation counts
/// only from its own creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Account {
    /// Wall-clock time, s.
    pub(crate) seconds: f64,
    /// Part of [`Self::seconds`] in which steps waited for frames, history and checkpoints, s.
    pub(crate) output: f64,
    /// Part of [`Self::seconds`] after the steps, in which plots, pictures and the report were drawn, s.
    pub(crate) drawing: f64,
    /// Number of checkpoints.
    pub(crate) checkpoints: u64,
    /// Time in each of [`PARTS`], s.
    pub(crate) parts: [f64; PARTS.len()],
    /// Number of detections of couples.
    pub(crate) detections: u64,
}

/// Time that results have taken in one part of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spent {
    /// Time in which steps waited for frames, history and checkpoints.
    pub(crate) output: Duration,
    /// Time for drawing after the steps.
    pub(crate) drawing: Duration,
    /// Number of checkpoints.
    pub(crate) checkpoints: u64,
}

impl Account {
    /// Adds the times and the detections of a simulation since its creation, with the wall-clock time and the
    /// time of the results since then.
    pub(crate) fn and(&self, timings: Timings, detections: u64, clock: Duration, spent: &Spent) -> Self {
        let Timings { bulk, joints, detection, contact, spheres, integration, messages } = timings;
        let times = [bulk, joints, detection, contact, spheres, integration, messages];
        let mut parts = self.parts;
        for (sum, time) in parts.iter_mut().zip(times) {
            *sum += time.as_secs_f64();
        }
        Self {
            seconds: self.seconds + clock.as_secs_f64(),
            output: self.output + spent.output.as_secs_f64(),
            drawing: self.drawing + spent.drawing.as_secs_f64(),
            checkpoints: self.checkpoints + spent.checkpoints,
            parts,
            detections: self.detections + detections,
        }
    }

    /// Share of the run, without drawing, in which steps waited for frames, history and checkpoints.
    pub(crate) fn share(&self) -> f64 {
        self.output / (self.seconds - self.drawing).max(1e-9)
    }

    /// Time in the steps, s.
    pub(crate) fn busy(&self) -> f64 {
        self.parts.iter().sum()
    }
}
