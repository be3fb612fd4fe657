//! Dividing keys among ranks without sorting them: they are counted by cells, and only cells in which a splitter falls are looked into.

use crate::communicator::Communicator;
use crate::curve::{ascending, intervals, narrow, owner};

/// The keys of a rank, divided among all ranks. Cell `c` has the keys from `c << shift` up to `(c + 1) << shift`.
///
/// A part is what one rank gets of one cell; nearly all cells have one part.
pub(crate) struct Division {
    /// First part of each cell. [`SEVERAL`] is added if there are more.
    first_parts: Vec<u32>,
    /// All parts, ascending by cell and by owner.
    parts: Vec<Part>,
    /// The splitters, as of [`splitters`](crate::curve::splitters).
    splitters: Vec<u64>,
}

/// The keys of a cell that one rank gets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) cell: usize,
    /// The rank that gets them.
    pub(crate) owner: usize,
    /// Number of this rank's keys in the part.
    pub(crate) count: usize,
}

/// Marks cells with several parts.
const SEVERAL: u32 = 1 << 31;

impl Division {
    /// Divides keys so that all ranks get about as many, up to 2 %. Collective.
    ///
    /// `counts` has the number of this rank's keys in each cell. `keys_in` returns the keys of all cells that are marked, in any order.
    pub(crate) fn new(
        communicator: &dyn Communicator,
        counts: &[usize],
        shift: u32,
        keys_in: impl FnOnce(&[bool]) -> Vec<u64>,
    ) -> Self {
        let mut sum = 0;
        let mut below: Vec<u64> = vec![0];
        below.extend(counts.iter().map(|&count| {
            sum += count as u64;
            sum
        }));
        let start = |cell: u64| u64::try_from(u128::from(cell) << shift).unwrap_or(u64::MAX);
        let add_up = |values: &mut [i64]| communicator.all_sum(values);

        let cells = counts.len() as u64;
        let (mut found, enough) = intervals(communicator.size(), sum, cells, add_up);
        narrow(&mut found, enough, |cell| below[cell as usize], add_up);

        // Splitters that are not near enough fall into a cell.
        let mut is_open = vec![false; counts.len()];
        for interval in &mut found {
            let (cell, distance) = interval.nearer_end();
            if distance > enough {
                is_open[interval.low as usize] = true;
                (interval.low, interval.high) = (start(interval.low), start(interval.high));
            } else {
                (interval.low, interval.high) = (start(cell), start(cell));
            }
        }
        let mut keys = Vec::new();
        if is_open.contains(&true) {
            keys = keys_in(&is_open);
            keys.sort_unstable();
            let before = |key: u64| keys.partition_point(|other| *other < key);
            let keys_below = |key: u64| {
                let cell = key >> shift;
                below[cell as usize] + (before(key) - before(start(cell))) as u64
            };
            narrow(&mut found, enough, keys_below, add_up);
        }
        let splitters = ascending(found.iter().map(|interval| interval.nearer_end().0));

        let mut parts = Vec::with_capacity(counts.len());
        let first_parts = (0..).zip(counts).map(|(cell, &count)| {
            let first = parts.len() as u32;
            let (low, high) = (start(cell), start(cell + 1));
            let owners = owner(&splitters, low)..=owner(&splitters, high - 1);
            let several = if owners.start() < owners.end() { SEVERAL } else { 0 };
            for owner in owners {
                let mut part = Part { cell: cell as usize, owner, count };
                if several != 0 {
                    let ends = [owner.checked_sub(1), Some(owner)]
                        .map(|rank| rank.and_then(|rank| splitters.get(rank)));
                    let [from, to] = [
                        ends[0].map_or(low, |end| low.max(*end)),
                        ends[1].map_or(high, |end| high.min(*end)),
                    ];
                    part.count =
                        keys.partition_point(|key| *key < to) - keys.partition_point(|key| *key < from);
                }
                parts.push(part);
            }
            first | several
        });
        let first_parts = first_parts.collect();
        Self { first_parts, parts, splitters }
    }

    /// All parts, ascending by cell and by owner.
    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The number of the part of a key in a cell. `key` is called if the cell has several parts.
    #[inline]
    pub(crate) fn part(&self, cell: usize, key: impl FnOnce() -> u64) -> usize {
        let first = self.first_parts[cell];
        if first & SEVERAL == 0 {
            return first as usize;
        }
        let first = (first & !SEVERAL) as usize;
        first + owner(&self.splitters, key()) - self.parts[first].owner
    }
}
