//! Dividing elements among ranks along Hilbert's curve, so that each rank has a compact part of the domain.

use crate::communicator::Communicator;

/// The keys of points along Hilbert's curve through a box.
///
/// # Example
/// ```
/// let curve = fdem_distributed::curve::Curve::new([0.0, 0.0], [8.0, 8.0]);
/// let keys = [[0.5, 0.5], [7.5, 0.5], [0.6, 0.5]].map(|point| curve.key(point));
/// assert!(keys[0].abs_diff(keys[2]) < keys[0].abs_diff(keys[1]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Curve<const D: usize> {
    origin: [f64; D],
    per_length: f64,
}

impl<const D: usize> Curve<D> {
    /// Bits of a coordinate. A domain has 65,536 cells along each axis, which is enough to divide crowded
    /// places; more bits would take more time.
    const BITS: u32 = {
        let bits = 63 / D as u32;
        if bits < 16 { bits } else { 16 }
    };

    /// The curve through the smallest cube that holds the box from `min` to `max`.
    pub fn new(min: [f64; D], max: [f64; D]) -> Self {
        let width = (0..D).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
        let per_length = f64::from((1_u32 << Self::BITS) - 1) / width;
        Self { origin: min, per_length: if per_length.is_finite() { per_length } else { 0.0 } }
    }

    /// The key of a point. Points outside of the box have the key of a cell at its border.
    #[inline]
    pub fn key(&self, point: [f64; D]) -> u64 {
        fdem_mesh::curve::place(self.cell(point), Self::BITS)
    }

    /// The same curve with about `count` cells, at most [`MOST_CELLS`].
    pub(crate) fn coarse(&self, count: usize) -> Coarse<D> {
        let bits = count.clamp(1, MOST_CELLS).ilog2() / D as u32;
        let mask = (1_u32 << bits) - 1;
        let cell = |number: usize| {
            std::array::from_fn::<u32, D, _>(|axis| (number as u32 >> (bits * axis as u32)) & mask)
        };
        let places = (0..1_usize << (bits * D as u32))
            .map(|number| fdem_mesh::curve::place(cell(number), bits) as u32);
        Coarse { curve: *self, bits, places: places.collect() }
    }

    /// The cell of a point along each axis, in the finest grid.
    #[inline]
    fn cell(&self, point: [f64; D]) -> [u32; D] {
        // The conversion of a float to an integer saturates.
        let last = (1_u32 << Self::BITS) - 1;
        std::array::from_fn(|axis| (((point[axis] - self.origin[axis]) * self.per_length) as u32).min(last))
    }
}

/// Largest number of cells of a coarse grid. Its table fits the second-level cache.
const MOST_CELLS: usize = 1 << 16;

/// A [`Curve`] through a coarse grid, whose cells are looked up in a table. Each cell has consecutive keys of
/// the curve.
#[derive(Clone, Debug)]
pub(crate) struct Coarse<const D: usize> {
    curve: Curve<D>,
    /// Bits of a coordinate.
    bits: u32,
    /// Places of all cells along the curve.
    places: Vec<u32>,
}

impl<const D: usize> Coarse<D> {
    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// The whole curve.
    pub(crate) fn finest(&self) -> Curve<D> {
        self.curve
    }

    /// The key of a point along the whole curve.
    pub(crate) fn key(&self, point: [f64; D]) -> u64 {
        self.curve.key(point)
    }

    /// Number of bits by which a key of the curve is longer than the place of its cell.
    pub(crate) fn shift(&self) -> u32 {
        (Curve::<D>::BITS - self.bits) * D as u32
    }

    /// The place along the curve of the cell of a point: the first bits of its key.
    #[inline]
    pub(crate) fn place(&self, point: [f64; D]) -> u32 {
        let cell = self.curve.cell(point);
        let coarser = Curve::<D>::BITS - self.bits;
        let number =
            (0..D).fold(0, |number, axis| number | (cell[axis] >> coarser) << (self.bits * axis as u32));
        self.places[number as usize]
    }
}

/// Keys that divide weighted keys among the ranks: rank `r` gets the keys from the splitter before `r` up to,
/// but without, splitter `r`.
///
/// The weight of each rank differs from the mean by at most 2 %, unless many keys are equal or single weights
/// are large. The splitters depend on the keys of all ranks together, and not on which rank has which.
/// Collective.
///
/// # Shapes
/// `keys`, `weights`: `[n]` in any order, with another `n` on each rank; keys are below `u64::MAX`. Result:
/// one splitter fewer than ranks, ascending, the same on all ranks. [`owner`] finds the rank of a key.
///
/// # Cost
/// The rank's keys are sorted. Then at most 16 sums over all ranks of 15 numbers for each splitter; no rank
/// sees the keys of others.
///
/// # Panics
/// If the number of weights differs from the number of keys, or the sum of all weights exceeds `i64::MAX`.
///
/// # Source
/// The histogram sort of L.V. Kalé, S. Krishnan, "A comparison based parallel sorting algorithm", ICPP 1993.
///
/// # Example
/// ```
/// use fdem_distributed::{curve, threads};
///
/// // Rank 0 has all keys. The rank that gets the heaviest key gets no others.
/// let splitters = threads::run(2, |communicator| {
///     let keys: &[u64] = if communicator.rank() == 0 { &[5, 1, 9, 7] } else { &[] };
///     let weights: &[u64] = if communicator.rank() == 0 { &[1, 1, 3, 1] } else { &[] };
///     curve::splitters(communicator, keys, weights)
/// });
/// assert_eq!([5, 9].map(|key| curve::owner(&splitters[0], key)), [0, 1]);
/// ```
pub fn splitters(communicator: &dyn Communicator, keys: &[u64], weights: &[u64]) -> Vec<u64> {
    let (weight, below) = sums_below(keys, weights);
    divide(communicator.size(), weight, below, |values| communicator.all_sum(values))
}

/// The splitters that the given number of ranks would find with [`splitters`], for a caller that has the keys
/// of all of them. Not collective.
///
/// # Panics
/// As [`splitters`], and if there are no ranks.
///
/// # Example
/// ```
/// use fdem_distributed::curve;
///
/// let splitters = curve::splitters_of_all(2, &[5, 1, 9, 7], &[1, 1, 3, 1]);
/// assert_eq!([5, 9].map(|key| curve::owner(&splitters, key)), [0, 1]);
/// ```
pub fn splitters_of_all(ranks: usize, keys: &[u64], weights: &[u64]) -> Vec<u64> {
    let (weight, below) = sums_below(keys, weights);
    divide(ranks, weight, below, |_| {})
}

/// The sum of all weights, and a function that returns the sum of those of the keys below a key.
fn sums_below(keys: &[u64], weights: &[u64]) -> (u64, impl Fn(u64) -> u64) {
    assert!(keys.len() == weights.len(), "a weight for each key");
    let mut sorted: Vec<(u64, u64)> = keys.iter().copied().zip(weights.iter().copied()).collect();
    sorted.sort_unstable_by_key(|(key, _)| *key);
    let mut sum = 0;
    for (_, weight) in &mut sorted {
        sum += *weight;
        *weight = sum;
    }
    let below = move |key: u64| {
        let place = sorted.partition_point(|(other, _)| *other < key);
        if place == 0 { 0 } else { sorted[place - 1].1 }
    };
    (sum, below)
}

/// The rank that gets a key.
#[inline]
pub fn owner(splitters: &[u64], key: u64) -> usize {
    splitters.partition_point(|splitter| *splitter <= key)
}

/// Parts into which the interval of each splitter is cut in a round.
const PARTS: u64 = 16;

/// Largest distance of a splitter from its place, as a part of the mean weight of a rank. A rank has two
/// ends.
const INEXACT: i64 = 100;

/// An interval of keys that holds a splitter: at most the target weight is below `low`, and more than that
/// below `high`.
#[derive(Clone, Copy)]
pub(crate) struct Interval {
    pub(crate) low: u64,
    pub(crate) high: u64,
    /// Weights of the keys below the two ends.
    below: [i64; 2],
    wanted: i64,
}

impl Interval {
    /// The end whose weight is nearer to the target weight.
    pub(crate) fn nearer_end(&self) -> (u64, i64) {
        let [low, high] = self.below.map(|below| (below - self.wanted).abs());
        if low <= high { (self.low, low) } else { (self.high, high) }
    }

    fn is_open(&self, enough: i64) -> bool {
        self.high - self.low > 1 && self.nearer_end().1 > enough
    }

    /// The inner ends of the parts, ascending.
    fn probes(&self) -> impl Iterator<Item = u64> {
        let Self { low, high, .. } = *self;
        (1..PARTS)
            .map(move |part| low + ((u128::from(high - low) * u128::from(part)) / u128::from(PARTS)) as u64)
    }
}

/// Finds splitters. `below` returns the weight of this rank's keys below a key, `weight` is that of all of
/// them, and `add_up` adds up values of all ranks.
fn divide(size: usize, weight: u64, below: impl Fn(u64) -> u64, add_up: impl Fn(&mut [i64])) -> Vec<u64> {
    let (mut intervals, enough) = intervals(size, weight, u64::MAX, &add_up);
    narrow(&mut intervals, enough, below, &add_up);
    ascending(intervals.iter().map(|interval| interval.nearer_end().0))
}

/// The intervals of the splitters before any sum, with keys below `high`; and the allowed deviation of a
/// weight from its target.
pub(crate) fn intervals(
    size: usize,
    weight: u64,
    high: u64,
    add_up: impl Fn(&mut [i64]),
) -> (Vec<Interval>, i64) {
    assert!(size > 0, "at least one rank");
    let mut total = [weight.cast_signed()];
    add_up(&mut total);
    let [total] = total;
    assert!(total >= 0, "the sum of weights fits 63 bits");
    let wanted = |rank: usize| (i128::from(total) * rank as i128 / size as i128) as i64;
    let intervals =
        (1..size).map(|rank| Interval { low: 0, high, below: [0, total], wanted: wanted(rank) }).collect();
    (intervals, total / size.cast_signed() as i64 / INEXACT)
}

/// Narrows intervals until an end of each is near enough, or no key is inside.
pub(crate) fn narrow(
    intervals: &mut [Interval],
    enough: i64,
    below: impl Fn(u64) -> u64,
    add_up: impl Fn(&mut [i64]),
) {
    loop {
        let open: Vec<usize> = (0..intervals.len()).filter(|&k| intervals[k].is_open(enough)).collect();
        if open.is_empty() {
            return;
        }
        let mut sums: Vec<i64> = open
            .iter()
            .flat_map(|&k| intervals[k].probes())
            .map(|probe| below(probe).cast_signed())
            .collect();
        add_up(&mut sums);
        for (&k, sums) in open.iter().zip(sums.chunks(PARTS as usize - 1)) {
            let before = intervals[k];
            let interval = &mut intervals[k];
            for (probe, &sum) in before.probes().zip(sums) {
                if sum <= before.wanted {
                    (interval.low, interval.below[0]) = (probe, sum);
                } else {
                    (interval.high, interval.below[1]) = (probe, sum);
                    break;
                }
            }
        }
    }
}

/// Raises each splitter to the one before it.
pub(crate) fn ascending(splitters: impl Iterator<Item = u64>) -> Vec<u64> {
    let raised = splitters.scan(0, |last, splitter| {
        *last = splitter.max(*last);
        Some(*last)
    });
    raised.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads;

    /// Splitters do not depend on where the keys are, and divide the weight evenly.
    #[test]
    fn splitters_are_even_wherever_the_keys_are() {
        let n = 40_000_u64;
        // Keys that crowd at the low end, in no order.
        let keys: Vec<u64> = (0..n).map(|k| (k * 7919 % n).pow(4)).collect();
        let weights: Vec<u64> = (0..n).map(|k| 1 + k % 3).collect();
        let total: u64 = weights.iter().sum();
        for size in [1, 2, 3, 8] {
            let found = |rank_of: fn(usize, usize) -> usize| {
                threads::run(size, |communicator| {
                    let own = |k: &usize| rank_of(*k, size) == communicator.rank();
                    let own: Vec<usize> = (0..n as usize).filter(own).collect();
                    let keys: Vec<u64> = own.iter().map(|&k| keys[k]).collect();
                    let weights: Vec<u64> = own.iter().map(|&k| weights[k]).collect();
                    splitters(communicator, &keys, &weights)
                })
            };
            let first = found(|k, size| k % size);
            assert_eq!(first[0], splitters_of_all(size, &keys, &weights));
            assert!(first.iter().all(|splitters| *splitters == first[0]), "the same on all ranks");
            assert_eq!(found(|_, size| size - 1), first);
            let mut of_rank = vec![0; size];
            for (&key, weight) in keys.iter().zip(&weights) {
                of_rank[owner(&first[0], key)] += weight;
            }
            for weight in of_rank {
                assert!(
                    (weight * size as u64).abs_diff(total) * 50 <= total,
                    "{weight} of {total} on {size}"
                );
            }
        }
    }

    /// Equal keys stay together, and fewer keys than ranks leave ranks empty.
    #[test]
    fn equal_keys_have_one_owner_and_few_keys_suffice() {
        for keys in [&[][..], &[3], &[0, 0, 0, 0, 0], &[u64::MAX - 1, 0, 5]] {
            let splitters = threads::run(4, |communicator| {
                let own = if communicator.rank() == 2 { keys } else { &[] };
                super::splitters(communicator, own, &vec![1; own.len()])
            });
            assert!(splitters[0].is_sorted() && splitters[0].len() == 3);
            assert!(splitters.iter().all(|other| *other == splitters[0]));
        }
    }

    /// The cell of a point in a coarse grid is the beginning of its key.
    fn check_coarse<const D: usize>() {
        let curve = Curve::<D>::new([-1.0; D], [1.0; D]);
        for count in [0, 1, 2, 100, 5000, usize::MAX] {
            let coarse = curve.coarse(count);
            assert!(coarse.len() <= MOST_CELLS && coarse.len() <= count.max(1));
            for k in 0..200 {
                let point = std::array::from_fn(|axis| (f64::from(k) * (1.3 + axis as f64)).sin());
                let start = coarse.key(point).checked_shr(coarse.shift()).unwrap_or(0);
                assert_eq!(u64::from(coarse.place(point)), start);
            }
        }
    }

    #[test]
    fn a_coarse_cell_has_consecutive_keys() {
        check_coarse::<1>();
        check_coarse::<2>();
        check_coarse::<3>();
        check_coarse::<4>();
    }

    #[test]
    fn a_domain_without_width_has_one_key() {
        let curve = Curve::new([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]);
        assert_eq!(curve.key([1.0, 2.0, 3.0]), curve.key([9.0, 9.0, 9.0]));
    }
}
