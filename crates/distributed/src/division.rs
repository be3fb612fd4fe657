//! Dividing keys among ranks without sorting them: they are counted by cells, and only cells in which a
//! splitter falls are looked into.

use crate::communicator::Communicator;
use crate::curve::{ascending, intervals, narrow, owner};

/// The keys of a rank, divided among all ranks. Cell `c` has the keys from `c << shift` up to
/// `(c + 1) << shift`.
///
/// A part is the share of one rank in one cell; nearly all cells have one part.
pub(crate) struct Division {
    /// First part of each cell. [`SEVERAL`] is added if there are more.
    first_parts: Vec<u32>,
    /// All parts, ascending by cell and by owner.
    parts: Vec<DivisionPart>,
    /// The splitters, as of [`splitters`](crate::curve::splitters).
    splitters: Vec<u64>,
}

/// The keys of a cell that one rank gets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DivisionPart {
    pub(crate) cell: usize,
    /// The rank that gets them.
    pub(crate) owner: usize,
    /// Number of this rank's keys in the part.
    pub(crate) count: usize,
}

/// Marks cells with several parts.
const SEVERAL: u32 = 1 << 31;

impl Division {
    /// Divides keys so that all ranks get the same number, up to 2 %. Collective.
    ///
    /// `counts` has the number of this rank's keys in each cell. `keys_in` returns the keys of all cells that
    /// are marked, in any order.
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
                let mut part = DivisionPart { cell: cell as usize, owner, count };
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
    pub(crate) fn parts(&self) -> &[DivisionPart] {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads;

    /// Divides keys, of which rank `r` has every `size`-th one, in `cells` cells, and checks each rank's
    /// parts. Returns the number of keys of each owner.
    fn divided(size: usize, cells: usize, shift: u32, keys: &[u64]) -> Vec<usize> {
        let of_ranks = threads::run(size, |communicator| {
            let own: Vec<u64> = keys.iter().skip(communicator.rank()).step_by(size).copied().collect();
            let mut counts = vec![0; cells];
            for key in &own {
                counts[(key >> shift) as usize] += 1;
            }
            let division = Division::new(communicator, &counts, shift, |is_marked| {
                own.iter().copied().filter(|key| is_marked[(key >> shift) as usize]).collect()
            });
            assert!(division.parts().is_sorted_by_key(|part| (part.cell, part.owner)));
            assert!(division.parts().is_sorted_by_key(|part| part.owner));
            let mut in_parts = vec![0; division.parts().len()];
            for &key in &own {
                let part = division.part((key >> shift) as usize, || key);
                assert_eq!(division.parts()[part].cell, (key >> shift) as usize);
                assert_eq!(division.parts()[part].owner, owner(&division.splitters, key));
                in_parts[part] += 1;
            }
            assert!(division.parts().iter().map(|part| part.count).eq(in_parts));
            let of_owner = |rank: usize| division.parts().iter().filter(move |part| part.owner == rank);
            let counts: Vec<usize> =
                (0..size).map(|rank| of_owner(rank).map(|part| part.count).sum()).collect();
            (division.splitters, counts)
        });
        assert!(of_ranks.iter().all(|(splitters, _)| *splitters == of_ranks[0].0), "the same on all ranks");
        (0..size).map(|owner| of_ranks.iter().map(|(_, counts)| counts[owner]).sum()).collect()
    }

    #[test]
    fn keys_are_divided_evenly_however_they_crowd() {
        let n = 20_000_u64;
        let spread: Vec<u64> = (0..n).map(|k| k * 7919 % n).collect();
        // All keys in one cell, and nearly all.
        let crowded: Vec<u64> = spread.iter().map(|key| 3 << 40 | key).collect();
        let with_one_far: Vec<u64> = crowded.iter().copied().chain([63 << 40]).collect();
        let steep: Vec<u64> = spread.iter().map(|key| key.pow(3)).collect();
        for size in [1, 2, 3, 8, 40] {
            for (keys, shift) in [(&spread, 9), (&crowded, 40), (&with_one_far, 40), (&steep, 38)] {
                let mean = keys.len() / size;
                for count in divided(size, 64, shift, keys) {
                    assert!(count.abs_diff(mean) * 50 <= mean + 50, "{count} of {mean} on {size}");
                }
            }
        }
    }

    #[test]
    fn few_and_equal_keys_have_owners() {
        for keys in [&[][..], &[5], &[0, 1, 2], &[7; 30], &[u64::MAX - 1, 0]] {
            for (cells, shift) in [(1, 63), (2, 63), (8, 61)] {
                if keys.iter().all(|key| key >> shift < cells as u64) {
                    assert_eq!(divided(12, cells, shift, keys).iter().sum::<usize>(), keys.len());
                }
            }
        }
    }
}
