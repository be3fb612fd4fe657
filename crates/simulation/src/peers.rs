//! Everything that a time step asks of the other ranks of a run.
//!
//! A run in one process has no peers, and [`Alone`] answers at once. On many ranks, messages answer:
//! `ranks/links.rs`.

use std::time::Duration;

use fdem_distributed::wire::{Wire, bytes_of, value_of};

use crate::error::Stop;
use crate::faces::BrokenSides;
use crate::joints::VertexSplit;
use crate::machine::{Columns, Machine};
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::topology::Topology;

/// A rank's report of the forces and the motion of a step. Of each number, the largest of all ranks counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StepReport {
    /// Speed of the fastest node, m/s.
    pub(crate) fastest: f64,
    /// Whether joints are to be inserted, or broke.
    pub(crate) parts: bool,
    /// Whether forces could not be computed, and whether a node is too fast.
    pub(crate) fails: bool,
    pub(crate) runs_away: bool,
}

/// The other ranks of a run. Calls are collective: all ranks make the same calls in the same order.
pub(crate) trait Peers<const D: usize, const N: usize>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Whether this rank has too few elements of other ranks for another step.
    fn is_stale(&self) -> bool;

    /// Whether other ranks need the motion of each node; empty if they need none.
    fn awaited(&self) -> &[bool];

    /// Starts to send the motions of these nodes.
    fn start_motion(&mut self, machine: &dyn Machine<D, N>);

    /// Receives the motions of the nodes that other ranks move, and combines the reports of all ranks.
    /// `step`: time step, s; `waiting`: time that this takes is added.
    fn finish_motion(
        &mut self,
        machine: &mut dyn Machine<D, N>,
        step: f64,
        report: StepReport,
        waiting: &mut Duration,
    ) -> StepReport;

    /// Adds the facets that fail on other ranks, and puts all of them in order.
    fn add_failing(&self, failing: &mut Vec<u32>, topology: &Topology<D, N>);

    /// Exchanges how vertices came apart, and repeats here the changes of their owners. `broken`: vertices at
    /// which joints broke, ascending.
    fn exchange_splits(
        &mut self,
        split: &[VertexSplit<D>],
        broken: &[u32],
        columns: &mut Columns<D, N>,
        topology: &Topology<D, N>,
    );

    /// Reports elements that became bare in this step and may touch elements of other ranks that do not know
    /// them. `bared`: elements that became bare.
    fn note_bared(&mut self, bared: &[u32]);

    /// The joints that broke in this step on any rank. `own`: those of this rank.
    fn all_broken(&self, own: Vec<BrokenSides<D>>) -> Vec<BrokenSides<D>>;

    /// Adds up sums over all ranks.
    fn add_up(&self, sums: &mut [&mut Sum]);

    /// Replaces numbers by the largest of all ranks.
    fn largest(&self, numbers: &mut [f64]);

    /// The number of this rank.
    fn rank(&self) -> usize;

    /// Whether this process has the whole run.
    fn are_none(&self) -> bool;

    /// The messages of all ranks, in the order of the ranks.
    fn all_bytes(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// The reason to stop of the first element that is one on any rank.
    fn first_stop(&self, own: Option<Stop>) -> Option<Stop>;

    /// The element with the largest value of all ranks, and of equal ones the first. `own`: value and number
    /// of that of this rank.
    fn first_of_largest(&self, own: Option<(f64, u32)>) -> Option<(f64, u32)>;
}

/// The values of all ranks, in the order of the ranks.
pub(crate) fn all<T: Wire, const D: usize, const N: usize>(peers: &dyn Peers<D, N>, own: T) -> Vec<T>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    if peers.are_none() {
        return vec![own];
    }
    peers.all_bytes(&bytes_of(&own)).iter().map(|bytes| value_of(bytes)).collect()
}

/// Of two elements with a value each, that with the larger one, and of equal ones the first.
pub(crate) fn first_of_largest(a: (f64, u32), b: (f64, u32)) -> (f64, u32) {
    let order = b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    if order.is_le() { a } else { b }
}

/// No other ranks: one process has the whole run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alone;

impl<const D: usize, const N: usize> Peers<D, N> for Alone
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn is_stale(&self) -> bool {
        false
    }

    fn awaited(&self) -> &[bool] {
        &[]
    }

    fn start_motion(&mut self, _: &dyn Machine<D, N>) {}

    fn finish_motion(
        &mut self,
        _: &mut dyn Machine<D, N>,
        _: f64,
        report: StepReport,
        _: &mut Duration,
    ) -> StepReport {
        report
    }

    fn add_failing(&self, _: &mut Vec<u32>, _: &Topology<D, N>) {}

    fn exchange_splits(
        &mut self,
        _: &[VertexSplit<D>],
        _: &[u32],
        _: &mut Columns<D, N>,
        _: &Topology<D, N>,
    ) {
    }

    fn note_bared(&mut self, _: &[u32]) {}

    fn all_broken(&self, own: Vec<BrokenSides<D>>) -> Vec<BrokenSides<D>> {
        own
    }

    fn add_up(&self, _: &mut [&mut Sum]) {}

    fn largest(&self, _: &mut [f64]) {}

    fn rank(&self) -> usize {
        0
    }

    fn are_none(&self) -> bool {
        true
    }

    fn all_bytes(&self, own: &[u8]) -> Vec<Vec<u8>> {
        vec![own.to_vec()]
    }

    fn first_stop(&self, own: Option<Stop>) -> Option<Stop> {
        own
    }

    fn first_of_largest(&self, own: Option<(f64, u32)>) -> Option<(f64, u32)> {
        own
    }
}
