//! Sums over the steps of a run.

use serde::{Deserialize, Serialize};

use crate::energy::Energies;
use crate::sum::Sum;

/// Sums over a run, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Totals {
    /// Work against friction of contacts.
    pub(crate) friction: Sum,
    /// Work against joints, less the potential energy of contacts to which they have handed over.
    pub(crate) cohesive: Sum,
    /// Elastic energy that joints had when they were inserted during the run. It is in no work.
    pub(crate) inserted: Sum,
    /// Energy dissipated by local damping, dynamic relaxation, damping of contacts and absorbing edges.
    pub(crate) damping: Sum,
    /// Work of applied forces, of gravity, of boundaries that move nodes, and of initial overlaps that relax.
    pub(crate) external: Sum,
    /// Work of applied forces, which `external` contains.
    pub(crate) loads: Sum,
    /// Energies at the beginning, once the first step has found them.
    pub(crate) first: Option<Energies>,
    /// Largest energy exchanged, and dissipated by joints, at any audit.
    pub(crate) exchanged: f64,
    pub(crate) most_dissipated: f64,
    pub(crate) relaxation: Relaxation,
}

/// Dynamic relaxation between two steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Relaxation {
    /// Work of the forces in a step at their speeds after it, at the last look, J.
    pub(crate) work: f64,
    /// Force on a node over its mass and its velocity, 1/s.
    pub(crate) damping: f64,
}

impl Totals {
    /// Adds works of loads, and of the dashpots of absorbing facets.
    pub(super) fn add_works(&mut self, works: impl IntoIterator<Item = [f64; 2]>) {
        for [work, absorbed] in works {
            self.external.add(work);
            self.loads.add(work);
            self.damping.add(-absorbed);
        }
    }
}
