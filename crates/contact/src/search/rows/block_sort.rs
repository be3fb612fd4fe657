//! Sorts a block of rows in cache.

use crate::error::Error;
use crate::memory::{reserve, resize};
use crate::real::Real;
use crate::search::rows::keys::RowKeys;

/// Working memory for sorting one block, kept from block to block.
#[derive(Clone, Debug)]
pub(crate) struct BlockSort<T, const D: usize> {
    /// The points of the block before the sort.
    points: Vec<[T; D]>,
    ids: Vec<u32>,
    radii: Vec<T>,
    /// One key per element: row, place along the row, place in the block, from the highest bits to the
    /// lowest.
    keys: Vec<u64>,
    moved: Vec<u64>,
    counts: Vec<u32>,
    /// First element of each row.
    pub(crate) starts: Vec<u32>,
}

/// The start of a block: consecutive rows and their elements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) first_row: u64,
    /// First element of the block.
    pub(crate) start: usize,
}

/// The elements of some blocks, in the arrays of the layout.
pub(crate) struct BlockElements<'a, T> {
    /// Before the sort: points. After the sort: one array for each axis of each row.
    pub(crate) coordinates: &'a mut [T],
    pub(crate) ids: &'a mut [u32],
    /// One radius per element, or empty.
    pub(crate) radii: &'a mut [T],
}

/// If fewer bits are left for the place along the row, elements are compared instead of keys.
const MIN_PLACE_BITS: u32 = 8;

/// More bits than this are not exact in `f64`.
const MAX_PLACE_BITS: u32 = 50;

/// Insertion sort is fast while each element moves over a few others on average; beyond this number another
/// sort is used.
const MAX_MOVES_PER_ELEMENT: usize = 4;

/// Average number of keys per occurring digit beyond which one pass leaves too much work to insertion sort.
const CROWDED: usize = 3;

/// Bits of the place along the row that are sorted by in that case, where rows are short.
const PLACE_BITS_SORTED: u32 = 6;

/// Largest number of bits of a digit: the counts stay in the first-level cache.
const MAX_DIGIT_BITS: u32 = 11;

/// Up to this number, elements are sorted without counting.
const FEW: usize = 32;

impl<T, const D: usize> Default for BlockSort<T, D> {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            ids: Vec::new(),
            radii: Vec::new(),
            keys: Vec::new(),
            moved: Vec::new(),
            counts: Vec::new(),
            starts: Vec::new(),
        }
    }
}

impl<T: Real, const D: usize> BlockSort<T, D> {
    /// Sorts `elements`, which begin with the first of the `blocks` and end where the last one begins.
    ///
    /// Each block is sorted by row, then along the row, then by the place that the element had before.
    pub(crate) fn sort(
        &mut self,
        keys: &RowKeys<D>,
        blocks: &[Block],
        elements: BlockElements<'_, T>,
    ) -> Result<(), Error> {
        let BlockElements { mut coordinates, mut ids, mut radii } = elements;
        self.starts.clear();
        for pair in blocks.windows(2) {
            let n = pair[1].start - pair[0].start;
            let elements = BlockElements {
                coordinates: coordinates.split_off_mut(..D * n).unwrap_or_default(),
                ids: ids.split_off_mut(..n).unwrap_or_default(),
                radii: radii.split_off_mut(..n).unwrap_or_default(),
            };
            if n > 0 {
                self.sort_block(keys, pair[0], pair[1].first_row - pair[0].first_row, elements)?;
            }
        }
        Ok(())
    }

    fn sort_block(
        &mut self,
        keys: &RowKeys<D>,
        block: Block,
        rows: u64,
        mut elements: BlockElements<'_, T>,
    ) -> Result<(), Error> {
        let n = elements.ids.len();
        copy(&mut self.points, elements.coordinates.as_chunks::<D>().0)?;
        copy(&mut self.ids, elements.ids)?;
        copy(&mut self.radii, elements.radii)?;
        self.keys.clear();
        resize(&mut self.keys, n, 0)?;
        self.moved.clear();
        resize(&mut self.moved, n, 0)?;

        let id_bits = bits(n as u64 - 1);
        let place_bits = (63 - id_bits).saturating_sub(bits(rows - 1)).min(MAX_PLACE_BITS);
        let row_shift = if keys.are_complete() && place_bits >= MIN_PLACE_BITS {
            let places = keys.places(&self.points, place_bits);
            let digits = Digits::new(rows << (id_bits + place_bits), n);
            self.counts.clear();
            resize(&mut self.counts, n, 0)?;
            let mut place = 0;
            for (points, their_keys) in self.points.chunks(FEW).zip(self.keys.chunks_mut(FEW)) {
                keys.of(points, their_keys);
                keys.add_places(points, block.first_row, &places, their_keys);
                for key in their_keys {
                    *key = *key << id_bits | place;
                    place += 1;
                    self.counts[digits.of(*key)] += 1;
                }
            }
            self.sort_keys(bits(rows - 1), place_bits + id_bits, digits)?;
            id_bits + place_bits
        } else {
            self.sort_by_comparison(keys, id_bits);
            id_bits
        };
        self.write(keys, block.start, &mut elements, id_bits, row_shift);
        Ok(())
    }

    /// Sorts the keys by counting their `digits`, then by insertion. Keys have `row_bits` bits for the row
    /// and `rest` bits below.
    ///
    /// Keys of one row are nearly uniform, so few of them share a digit. If most rows are empty, many keys
    /// share a digit; then passes by digits that distinguish all rows are faster.
    fn sort_keys(&mut self, row_bits: u32, rest: u32, digits: Digits) -> Result<(), Error> {
        let n = self.keys.len();
        if n <= FEW {
            self.keys.sort_unstable();
            return Ok(());
        }
        let occupied = add_up(&mut self.counts);
        if occupied >= n / CROWDED {
            spread(&self.keys, &mut self.moved, &mut self.counts, |key| digits.of(key));
            swap_neighbours(&self.moved, &mut self.keys);
            insert(&mut self.keys);
            return Ok(());
        }
        let bits = row_bits + rest.min(PLACE_BITS_SORTED);
        let passes = bits.div_ceil(MAX_DIGIT_BITS);
        let digit = bits.div_ceil(passes);
        let lowest = (row_bits + rest).saturating_sub(passes * digit);
        for pass in 0..passes {
            let digit = |key: u64| (key >> (lowest + pass * digit)) as usize & ((1 << digit) - 1);
            self.counts.clear();
            resize(&mut self.counts, digit(u64::MAX) + 1, 0)?;
            for &key in &self.keys {
                self.counts[digit(key)] += 1;
            }
            add_up(&mut self.counts);
            spread(&self.keys, &mut self.moved, &mut self.counts, digit);
            std::mem::swap(&mut self.keys, &mut self.moved);
        }
        swap_neighbours(&self.keys, &mut self.moved);
        std::mem::swap(&mut self.keys, &mut self.moved);
        insert(&mut self.keys);
        Ok(())
    }

    /// Sorts any number of rows by comparing cells. The keys become the number of the row in the block,
    /// followed by the place.
    fn sort_by_comparison(&mut self, keys: &RowKeys<D>, id_bits: u32) {
        let points = &self.points;
        self.moved.iter_mut().zip(0..).for_each(|(place, index)| *place = index);
        self.moved.sort_unstable_by(|&a, &b| {
            let [p, q] = [a, b].map(|place| &points[place as usize]);
            keys.compare(p, q).then_with(|| keys.along(p, q)).then(a.cmp(&b))
        });
        let (mut row, mut before) = (0, &points[self.moved[0] as usize]);
        for (key, &place) in self.keys.iter_mut().zip(&self.moved) {
            let point = &points[place as usize];
            row += u64::from(keys.compare(before, point).is_ne());
            before = point;
            *key = row << id_bits | place;
        }
    }

    /// Writes the block in the order of the keys, row by row.
    ///
    /// Keys round the place along the row, so elements that are very close together may still be in the wrong
    /// order; this puts them right.
    fn write(
        &mut self,
        keys: &RowKeys<D>,
        first: usize,
        to: &mut BlockElements<'_, T>,
        id_bits: u32,
        row_shift: u32,
    ) {
        let (points, ids) = (&self.points, &self.ids);
        let mask = (1 << id_bits) - 1;
        let place = |key: u64| (key & mask) as usize;
        let long = keys.long();
        let mut start = 0;
        while start < self.keys.len() {
            let next_row = ((self.keys[start] >> row_shift) + 1) << row_shift;
            let rest = &mut self.keys[start..];
            let len = rest.iter().position(|&key| key >= next_row).unwrap_or(rest.len());
            let order = &mut rest[..len];
            let coordinates = &mut to.coordinates[D * start..][..D * len];
            if !fill(points, place, order, coordinates, long) {
                order.sort_unstable_by(|&a, &b| {
                    let [a, b] = [a, b].map(place);
                    keys.along(&points[a], &points[b]).then(a.cmp(&b))
                });
                fill(points, place, order, coordinates, long);
            }
            for (id, &key) in to.ids[start..].iter_mut().zip(&*order) {
                *id = ids[place(key)];
            }
            if !to.radii.is_empty() {
                for (radius, &key) in to.radii[start..].iter_mut().zip(&*order) {
                    *radius = self.radii[place(key)];
                }
            }
            self.starts.push((first + start) as u32);
            start += len;
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        (D * self.points.capacity() + self.radii.capacity()) * size_of::<T>()
            + (self.keys.capacity() + self.moved.capacity()) * size_of::<u64>()
            + (self.ids.capacity() + self.counts.capacity() + self.starts.capacity()) * size_of::<u32>()
    }
}

/// Writes the coordinates of one row, axis by axis. Returns false if those along the row do not ascend.
#[inline]
fn fill<T: Real, const D: usize>(
    points: &[[T; D]],
    place: impl Fn(u64) -> usize,
    order: &[u64],
    coordinates: &mut [T],
    long: usize,
) -> bool {
    let n = order.len();
    let mut ascend = true;
    let mut axes = coordinates.chunks_exact_mut(n);
    let axes: [&mut [T]; D] = std::array::from_fn(|_| axes.next().unwrap_or_default());
    let mut before = points[place(order[0])][long];
    for (k, &key) in order.iter().enumerate() {
        let point = &points[place(key)];
        for axis in 0..D {
            axes[axis][k] = point[axis];
        }
        ascend &= before <= point[long];
        before = point[long];
    }
    ascend
}

/// The highest part of a key, scaled to a number below the number of keys.
#[derive(Clone, Copy, Debug)]
struct Digits {
    factor: u64,
}

impl Digits {
    /// Digits for `n` keys below `end`; `end` is more than `n`.
    fn new(end: u64, n: usize) -> Self {
        Self { factor: (((n as u128) << 64) / u128::from(end)) as u64 }
    }

    /// The digit of a key: it ascends with the key and stays below `n`.
    #[inline]
    fn of(self, key: u64) -> usize {
        ((u128::from(key) * u128::from(self.factor)) >> 64) as usize
    }
}

/// Turns the count of each digit into its start, and returns how many digits there are.
fn add_up(counts: &mut [u32]) -> usize {
    let (mut start, mut occupied) = (0, 0);
    for count in counts {
        occupied += u32::from(*count > 0);
        start += std::mem::replace(count, start);
    }
    occupied as usize
}

/// One stable pass of a counting sort by one digit. `starts` becomes the end of each digit.
#[inline]
fn spread(keys: &[u64], sorted: &mut [u64], starts: &mut [u32], digit: impl Fn(u64) -> usize) {
    for &key in keys {
        let place = &mut starts[digit(key)];
        sorted[*place as usize] = key;
        *place += 1;
    }
}

/// Copies the keys, of which there are at least two, and corrects most that are up to two places off, without
/// unpredictable branches.
fn swap_neighbours(keys: &[u64], sorted: &mut [u64]) {
    // The largest key so far and the largest of the others: they wait until two smaller ones have passed.
    let (mut first, mut second) = (keys[0].max(keys[1]), keys[0].min(keys[1]));
    for (place, &key) in sorted.iter_mut().zip(&keys[2..]) {
        let smaller = first.min(key);
        first = first.max(key);
        *place = second.min(smaller);
        second = second.max(smaller);
    }
    let n = keys.len();
    (sorted[n - 2], sorted[n - 1]) = (second, first);
}

/// Insertion sort for keys that are nearly sorted.
fn insert(keys: &mut [u64]) {
    let mut moves = MAX_MOVES_PER_ELEMENT * keys.len();
    for k in 1..keys.len() {
        let moving = keys[k];
        if keys[k - 1] <= moving {
            continue;
        }
        let mut to = k;
        while to > 0 && keys[to - 1] > moving {
            keys[to] = keys[to - 1];
            to -= 1;
        }
        keys[to] = moving;
        if k - to > moves {
            keys.sort_unstable();
            return;
        }
        moves -= k - to;
    }
}

/// Copies `of` into `values`, whose memory is reused.
fn copy<V: Copy>(values: &mut Vec<V>, of: &[V]) -> Result<(), Error> {
    values.clear();
    reserve(values, of.len())?;
    values.extend_from_slice(of);
    Ok(())
}

/// Number of bits needed for `x`.
fn bits(x: u64) -> u32 {
    64 - x.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_ascend_and_stay_below_their_number() {
        for n in [1, 2, 33, 4096, 100_000] {
            for end in [1 << 25, (1 << 25) + 1, (1 << 63) - 1, 1 << 63] {
                let digits = Digits::new(end, n);
                let found = (0..1000).map(|k| digits.of(end / 1000 * k)).collect::<Vec<_>>();
                assert!(found.is_sorted(), "{n} digits below {end}");
                assert_eq!(found[0], 0);
                assert!(digits.of(end - 1) < n && n <= digits.of(end - 1) + 2, "{n} digits below {end}");
            }
        }
    }

    #[test]
    fn keys_up_to_two_places_off_are_put_right() {
        let mut sorted = [0; 7];
        swap_neighbours(&[2, 0, 1, 3, 6, 5, 4], &mut sorted);
        assert_eq!(sorted, [0, 1, 2, 3, 4, 5, 6]);
        swap_neighbours(&[9, 1], &mut sorted[..2]);
        assert_eq!(sorted[..2], [1, 9]);
        swap_neighbours(&[3, 2, 1, 0, 4, 5, 6], &mut sorted);
        assert_eq!(sorted, [1, 0, 2, 3, 4, 5, 6], "three places are too many");
    }

    /// One pass suffices where keys are uniform; two are needed where most keys have the same highest bits.
    #[test]
    fn keys_are_sorted_however_they_are_distributed() {
        let mut state = 5_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 24
        };
        for n in [2, 32, 33, 500, 5000] {
            for crowd in [1, 100, 1 << 20, 1 << 40] {
                let keys: Vec<u64> = (0..n).map(|k| (random() / crowd) << 13 | k as u64).collect();
                let digits = Digits::new(1 << 53, n);
                let mut sort = BlockSort::<f64, 3> { keys: keys.clone(), ..BlockSort::default() };
                sort.moved.resize(n, 0);
                sort.counts.resize(n, 0);
                for &key in &keys {
                    sort.counts[digits.of(key)] += 1;
                }
                sort.sort_keys(20, 33, digits).unwrap();
                let mut expected = keys;
                expected.sort_unstable();
                assert_eq!(sort.keys, expected, "{n} keys, crowded by {crowd}");
            }
        }
    }
}
