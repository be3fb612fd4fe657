//! Runs: consecutive cells along the curve, whose elements a rank sends and keeps together.

use std::ops::Range;

use crate::communicator::{Communicator, Message};
use crate::wire::{put_all, take_all};

/// The run of each element that a rank gives.
pub(crate) struct Runs {
    pub(crate) of: Vec<u32>,
    /// Number of this rank's elements in each run.
    pub(crate) counts: Vec<usize>,
    /// The first run of each rank, and the number of runs.
    pub(crate) firsts: Vec<usize>,
}

/// The elements that one rank sends to another one.
pub(crate) struct Arriving {
    /// Number of elements in each run.
    pub(crate) counts: Vec<usize>,
    /// Places where they start in each run.
    pub(crate) starts: Vec<usize>,
}

impl Runs {
    /// The runs of a rank.
    pub(crate) fn of_rank(&self, rank: usize) -> Range<usize> {
        self.firsts[rank]..self.firsts[rank + 1]
    }

    /// Sends all ranks the numbers of elements that they get. Returns those that this rank gets, first from
    /// itself, then from each other rank that sends any; and the ends of its runs. Collective.
    pub(crate) fn announce(&self, communicator: &dyn Communicator) -> (Vec<Arriving>, Vec<usize>) {
        let own = communicator.rank();
        let counts_of = |rank: usize| &self.counts[self.of_rank(rank)];
        let others = (0..communicator.size())
            .filter(|&rank| rank != own && counts_of(rank).iter().any(|count| *count > 0));
        let messages = others.map(|rank| {
            let mut bytes = Vec::new();
            put_all(counts_of(rank).iter().map(|count| *count as u32), &mut bytes);
            Message { rank, bytes }
        });
        let received = communicator.exchange(messages.collect());
        let counts = received.iter().map(|message| {
            let count = message.bytes.len() / 4;
            take_all::<u32>(&mut &message.bytes[..], count).map(|count| count as usize).collect()
        });
        let counts = std::iter::once(counts_of(own).to_vec()).chain(counts);
        let mut arriving: Vec<Arriving> =
            counts.map(|counts| Arriving { counts, starts: Vec::new() }).collect();
        let mut end = 0;
        let ends = (0..counts_of(own).len()).map(|run| {
            for from in &mut arriving {
                from.starts.push(end);
                end += from.counts[run];
            }
            end
        });
        let ends = ends.collect();
        (arriving, ends)
    }
}
