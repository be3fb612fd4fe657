//! Sorting a block of rows, in cache.

use crate::error::Error;
use crate::real::Real;
use crate::search::rows::keys::RowKeys;
use crate::search::rows::layout::{reserve, resize};

/// Memory to sort one block, kept between blocks.
#[derive(Clone, Debug)]
pub(crate) struct BlockSort<T, const D: usize> {
    /// The block before the sort.
    points: Vec<[T; D]>,
    ids: Vec<u32>,
    radii: Vec<T>,
    /// One for each element: row, place along the row, place in the block, from the highest bits to the lowest.
    keys: Vec<u64>,
    moved: Vec<u64>,
    counts: [Vec<u32>; 2],
    /// First element of each row.
    pub(crate) starts: Vec<u32>,
}

/// A stretch of rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) first_row: u64,
    /// Its first element.
    pub(crate) start: usize,
}

/// Elements of the layout.
pub(crate) struct Elements<'a, T> {
    /// Points before the sort; one array for each axis of each row after it.
    pub(crate) coordinates: &'a mut [T],
    pub(crate) ids: &'a mut [u32],
    /// As many as elements, or none.
    pub(crate) radii: &'a mut [T],
}

/// With fewer bits for the place along the row, elements are compared instead.
const MIN_PLACE_BITS: u32 = 8;

/// More are not exact in `f64`.
const MAX_PLACE_BITS: u32 = 50;

/// Insertion is quick while elements move over a few others on average; beyond, another sort takes over.
const MAX_MOVES_PER_ELEMENT: usize = 4;

/// So many elements are sorted without counting.
const FEW: usize = 32;

impl<T, const D: usize> Default for BlockSort<T, D> {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            ids: Vec::new(),
            radii: Vec::new(),
            keys: Vec::new(),
            moved: Vec::new(),
            counts: [Vec::new(), Vec::new()],
            starts: Vec::new(),
        }
    }
}

impl<T: Real, const D: usize> BlockSort<T, D> {
    /// Sorts `elements`, which begin with the first of the `blocks` and end where the last begins.
    ///
    /// By row, then along the row, then by place before, block by block.
    pub(crate) fn sort(
        &mut self,
        keys: &RowKeys<D>,
        blocks: &[Block],
        elements: Elements<'_, T>,
    ) -> Result<(), Error> {
        let Elements { mut coordinates, mut ids, mut radii } = elements;
        self.starts.clear();
        for pair in blocks.windows(2) {
            let n = pair[1].start - pair[0].start;
            let elements = Elements {
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
        mut elements: Elements<'_, T>,
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
            keys.of(&self.points, &mut self.keys);
            keys.add_places(&self.points, block.first_row, place_bits, &mut self.keys);
            for (place, key) in self.keys.iter_mut().enumerate() {
                *key = *key << id_bits | place as u64;
            }
            self.sort_keys(bits(rows - 1) + place_bits + id_bits)?;
            id_bits + place_bits
        } else {
            self.sort_by_comparison(keys, id_bits);
            id_bits
        };
        self.write(keys, block.start, &mut elements, id_bits, row_shift);
        Ok(())
    }

    /// Sorts the keys, which have so many `bits`: by the highest ones, in two passes, then by insertion.
    ///
    /// Those in one row are nearly uniform, and the highest bits tell most of them apart.
    fn sort_keys(&mut self, bits: u32) -> Result<(), Error> {
        let n = self.keys.len();
        if n <= FEW {
            self.keys.sort_unstable();
            return Ok(());
        }
        let digit = (self::bits(n as u64 - 1) + 5).min(bits) / 2;
        let shift = bits - 2 * digit;
        let mask = (1 << digit) - 1;
        let [low, high] = &mut self.counts;
        for counts in [&mut *low, &mut *high] {
            counts.clear();
            resize(counts, 1 << digit, 0)?;
        }
        let low_digit = |key: u64| (key >> shift & mask) as usize;
        let high_digit = |key: u64| (key >> (shift + digit) & mask) as usize;
        let (low, high) = (low.as_mut_slice(), high.as_mut_slice());
        for &key in &self.keys {
            low[low_digit(key)] += 1;
            high[high_digit(key)] += 1;
        }
        spread(&self.keys, &mut self.moved, low, low_digit);
        spread(&self.moved, &mut self.keys, high, high_digit);
        insert(&mut self.keys);
        Ok(())
    }

    /// Any number of cells, by comparing them. The keys become the number of the row in the block, and the place.
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
    /// The keys round places along the row, so that elements very close together may be in the wrong order.
    fn write(
        &mut self,
        keys: &RowKeys<D>,
        first: usize,
        to: &mut Elements<'_, T>,
        id_bits: u32,
        row_shift: u32,
    ) {
        let (points, ids) = (&self.points, &self.ids);
        let place = |key: u64| (key & ((1 << id_bits) - 1)) as usize;
        let long = keys.long();
        let mut start = 0;
        while start < self.keys.len() {
            let row = self.keys[start] >> row_shift;
            let rest = &mut self.keys[start..];
            let len = rest.iter().position(|key| key >> row_shift != row).unwrap_or(rest.len());
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
        let counts: usize = self.counts.iter().map(Vec::capacity).sum();
        (D * self.points.capacity() + self.radii.capacity()) * size_of::<T>()
            + (self.keys.capacity() + self.moved.capacity()) * size_of::<u64>()
            + (self.ids.capacity() + counts + self.starts.capacity()) * size_of::<u32>()
    }
}

/// Writes the coordinates of one row, axis by axis; false if those along the row do not ascend.
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

/// One pass of a sort by counting: stable, by one digit. `counts` becomes the end of each digit.
#[inline]
fn spread(keys: &[u64], sorted: &mut [u64], counts: &mut [u32], digit: impl Fn(u64) -> usize) {
    let mut start = 0;
    for count in &mut *counts {
        start += std::mem::replace(count, start);
    }
    for &key in keys {
        let place = &mut counts[digit(key)];
        sorted[*place as usize] = key;
        *place += 1;
    }
}

/// Sorts what is nearly sorted.
fn insert(keys: &mut [u64]) {
    let mut moves = MAX_MOVES_PER_ELEMENT * keys.len();
    for k in 1..keys.len() {
        let moving = keys[k];
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

/// A copy, in memory that is kept.
fn copy<V: Copy>(values: &mut Vec<V>, of: &[V]) -> Result<(), Error> {
    values.clear();
    reserve(values, of.len())?;
    values.extend_from_slice(of);
    Ok(())
}

/// Bits of `x`.
fn bits(x: u64) -> u32 {
    64 - x.leading_zeros()
}
