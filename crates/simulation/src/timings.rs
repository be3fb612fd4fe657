//! Time that the parts of a step take.

use std::ops::AddAssign;
use std::time::{Duration, Instant};

/// Time spent in each part of the steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    /// Stress and forces of elements.
    pub bulk: Duration,
    /// Insertion of joints and their forces.
    pub joints: Duration,
    /// Detection of contacts: boxes and couples.
    pub detection: Duration,
    /// Forces of contacts.
    pub contact: Duration,
    /// Spheres: all parts of their step.
    pub spheres: Duration,
    /// Loads and motion.
    pub integration: Duration,
    /// Messages to other ranks, and waiting for theirs.
    pub messages: Duration,
}

impl AddAssign for Timings {
    fn add_assign(&mut self, more: Self) {
        self.bulk += more.bulk;
        self.joints += more.joints;
        self.detection += more.detection;
        self.contact += more.contact;
        self.spheres += more.spheres;
        self.integration += more.integration;
        self.messages += more.messages;
    }
}

/// Measures the time since its last reading.
pub(crate) struct Clock(Instant);

impl Clock {
    pub(crate) fn new() -> Self {
        Self(Instant::now())
    }

    pub(crate) fn read(&mut self, sum: &mut Duration) {
        let now = Instant::now();
        *sum += now - self.0;
        self.0 = now;
    }
}
