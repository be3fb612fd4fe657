//! Sorting by cell numbers of any size, in buckets within buckets: never more buckets than elements.

use std::cmp::Ordering;

use crate::error::Error;
use crate::search::rows::layout::resize;

/// Memory for the sorting, kept between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Buckets {
    /// Bucket of each element, or room to move elements.
    keys: Vec<u32>,
    moved: Vec<u32>,
    /// Elements in each bucket, one array for each depth of recursion.
    counts: Vec<Vec<u32>>,
}

/// So few elements are compared with each other at once.
const FEW: usize = 32;

impl Buckets {
    /// Sorts `ids` by `cell(id, level)` for the levels from `level` down to 1, then by `compare`.
    ///
    /// Every pass spreads m elements over at most 2 m buckets of equal width. A bucket with one cell goes on to the next
    /// level, one with more is spread again; where all elements are close together that is one pass per level.
    pub(crate) fn sort(
        &mut self,
        ids: &mut [u32],
        level: usize,
        cell: &impl Fn(u32, usize) -> u64,
        compare: &impl Fn(u32, u32) -> Ordering,
    ) -> Result<(), Error> {
        resize(&mut self.keys, ids.len(), 0)?;
        resize(&mut self.moved, ids.len(), 0)?;
        let Self { keys, moved, counts } = self;
        spread(ids, keys, moved, counts, 0, level, cell, compare)
    }

    pub(crate) fn bytes(&self) -> usize {
        let counts: usize = self.counts.iter().map(Vec::capacity).sum();
        (self.keys.capacity() + self.moved.capacity() + counts) * size_of::<u32>()
    }
}

#[allow(clippy::too_many_arguments, reason = "one recursion; a struct would only rename them")]
fn spread(
    ids: &mut [u32],
    keys: &mut [u32],
    moved: &mut [u32],
    counts: &mut Vec<Vec<u32>>,
    depth: usize,
    level: usize,
    cell: &impl Fn(u32, usize) -> u64,
    compare: &impl Fn(u32, u32) -> Ordering,
) -> Result<(), Error> {
    if level == 0 || ids.len() <= FEW {
        let by_cells = |a: u32, b: u32| {
            (1..=level).rev().map(|level| cell(a, level).cmp(&cell(b, level))).find(|order| order.is_ne())
        };
        ids.sort_unstable_by(|&a, &b| by_cells(a, b).unwrap_or_else(|| compare(a, b)));
        return Ok(());
    }
    let (first, last) = ids
        .iter()
        .map(|&id| cell(id, level))
        .fold((u64::MAX, 0), |(first, last), cell| (first.min(cell), last.max(cell)));
    if first == last {
        return spread(ids, keys, moved, counts, depth, level - 1, cell, compare);
    }
    let width = (last - first) / (2 * ids.len() as u64) + 1;
    let buckets = ((last - first) / width) as usize + 1;
    if counts.len() == depth {
        counts.push(Vec::new());
    }
    let mut ends = std::mem::take(&mut counts[depth]);
    ends.clear();
    resize(&mut ends, buckets, 0)?;
    for (key, &id) in keys.iter_mut().zip(&*ids) {
        *key = ((cell(id, level) - first) / width) as u32;
        ends[*key as usize] += 1;
    }
    let mut start = 0;
    for end in &mut ends {
        start += std::mem::replace(end, start);
    }
    for (&key, &id) in keys.iter().zip(&*ids) {
        let place = &mut ends[key as usize];
        moved[*place as usize] = id;
        *place += 1;
    }
    ids.copy_from_slice(&moved[..ids.len()]);

    // Each place has become the end of its bucket.
    let next = if width == 1 { level - 1 } else { level };
    let mut start = 0;
    for &end in &ends {
        let bucket = start..end as usize;
        start = bucket.end;
        if bucket.len() > 1 {
            let (keys, moved) = (&mut keys[bucket.clone()], &mut moved[bucket.clone()]);
            spread(&mut ids[bucket], keys, moved, counts, depth + 1, next, cell, compare)?;
        }
    }
    counts[depth] = ends;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells from a few to astronomically many, in clusters and far apart: the order is that of a plain sort.
    #[test]
    fn the_order_is_that_of_a_plain_sort() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 11
        };
        for scale in [1, 20, 3000, 1 << 30, 1 << 46] {
            for n in [0, 1, 2, 33, 500, 4000] {
                let mut cells: Vec<[u64; 3]> =
                    (0..n).map(|_| [random(), random(), random()].map(|x| x % scale)).collect();
                for cell in cells.iter_mut().skip(n / 2) {
                    cell[2] %= 3;
                }
                let compare =
                    |a: u32, b: u32| cells[a as usize][0].cmp(&cells[b as usize][0]).then(a.cmp(&b));
                let mut ids: Vec<u32> = (0..n as u32).collect();
                let mut expected = ids.clone();
                expected.sort_by(|&a, &b| {
                    let key = |id: u32| (cells[id as usize][2], cells[id as usize][1]);
                    key(a).cmp(&key(b)).then(compare(a, b))
                });
                Buckets::default()
                    .sort(&mut ids, 2, &|id, level| cells[id as usize][level], &compare)
                    .unwrap();
                assert_eq!(ids, expected, "scale {scale}, n {n}");
            }
        }
    }
}
