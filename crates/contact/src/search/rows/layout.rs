//! Elements in row order: the lists of NBS as sorted, contiguous runs.

#![allow(unsafe_code, reason = "threads drop elements into one array, each into places of its own")]

use std::ops::Range;

use crate::error::Error;
use crate::filter::{Filter, Labels};
use crate::grid::{Grid, rows_of};
use crate::memory::{reserve, resize};
use crate::pool::Pool;
use crate::real::Real;
use crate::search::rows::block_sort::{Block, BlockElements, BlockSort};
use crate::search::rows::keys::RowKeys;
use crate::search::rows::scatter::Scatter;
use crate::simd::prefetch;
use crate::simd::task::Arrays;

/// A copy of the elements, sorted by row of cells and by coordinate inside the row.
///
/// A *row* is all cells that differ in one axis only, the *long* one: the axis with the most cells. Only rows
/// that hold elements exist. Inside a row the coordinates are stored axis by axis, so that a vector holds one
/// coordinate of neighbouring elements.
///
/// # Shapes
/// Row `r` holds the elements `starts[r]..starts[r + 1]`. With `start` and `len` of it, axis `a` of the row
/// is `coordinates[D * start + a * len ..][.. len]`, ascending for the long axis; `ids` and `radii` are
/// `[start ..][.. len]`. All arrays end with [`PADDING`] unused entries, so that a vector may be loaded from
/// any element on.
#[derive(Clone, Debug)]
pub(crate) struct Layout<T, const D: usize> {
    pub(crate) coordinates: Vec<T>,
    /// The upper ends of boxes, with the tolerance added, in the order of `coordinates`; empty for spheres.
    far: Vec<T>,
    /// Mean width of boxes along the long axis, tolerance included, from a sample.
    mean_width: f64,
    /// Empty for elements of one radius.
    pub(crate) radii: Vec<T>,
    pub(crate) ids: Vec<u32>,
    /// The numbers of the filter, if the elements have one.
    pub(crate) labels: Labels,
    /// First element of each row; the last entry is the number of elements.
    pub(crate) starts: Vec<u32>,
    /// The cells of each row, as [`Layout::row_cells`] has them; empty until [`Layout::keep_cells`].
    cells: Vec<[u32; D]>,
    /// The axes by number of cells: the long one first, then the one whose index changes fastest from row to
    /// row.
    pub(crate) axes: [usize; D],
    pub(crate) grid: Grid<D>,
    /// The bin of each element; a bin is a few rows.
    bins: Vec<u16>,
    /// Number of elements in each bin, for each stretch of elements that one thread handles.
    counts: Vec<u32>,
    /// The block of each bin.
    block_of: Vec<u16>,
    /// The blocks, followed by an entry for the end of the last one.
    blocks: Vec<Block>,
    /// For each stretch, where the next element of each block goes.
    cursors: Vec<u32>,
    sorts: Vec<BlockSort<T, D>>,
}

/// The elements that a layout holds, by number.
pub(crate) trait Chosen: Copy + Sync {
    fn len(self) -> usize;

    /// The number of the `k`-th element.
    fn number(self, k: usize) -> usize;

    /// The points of the elements `range`, copied into `few` if they are not contiguous.
    fn points<'p, T: Copy, const D: usize>(
        self,
        points: &'p [[T; D]],
        range: Range<usize>,
        few: &'p mut [[T; D]; FEW],
    ) -> &'p [[T; D]];
}

/// All elements; the field is how many.
#[derive(Clone, Copy)]
struct AllElements(usize);

impl Chosen for AllElements {
    #[inline]
    fn len(self) -> usize {
        self.0
    }

    #[inline]
    fn number(self, k: usize) -> usize {
        k
    }

    #[inline]
    fn points<'p, T: Copy, const D: usize>(
        self,
        points: &'p [[T; D]],
        range: Range<usize>,
        _: &'p mut [[T; D]; FEW],
    ) -> &'p [[T; D]] {
        &points[range]
    }
}

impl Chosen for &[u32] {
    #[inline]
    fn len(self) -> usize {
        <[u32]>::len(self)
    }

    #[inline]
    fn number(self, k: usize) -> usize {
        self[k] as usize
    }

    #[inline]
    fn points<'p, T: Copy, const D: usize>(
        self,
        points: &'p [[T; D]],
        range: Range<usize>,
        few: &'p mut [[T; D]; FEW],
    ) -> &'p [[T; D]] {
        let numbers = &self[range];
        for (point, &number) in few.iter_mut().zip(numbers) {
            *point = points[number as usize];
        }
        &few[..numbers.len()]
    }
}

/// Unused entries behind each array: the widest vector has 16 lanes (`f32`, AVX-512).
pub(crate) const PADDING: usize = 16;

/// Approximate number of elements in a block of consecutive rows: these can be sorted in the second-level
/// cache.
const BLOCK: usize = if cfg!(miri) { 32 } else { 2048 };

/// Largest number of blocks that are filled at once: with more, the processor runs out of entries in its
/// translation lookaside buffer.
const MAX_BLOCKS: usize = 1024;

/// Largest number of bins, of which blocks are made: their counts stay in the first-level cache.
const MAX_BINS: u64 = 8192;

/// Number of elements whose rows are found at a time.
const FEW: usize = 64;

/// With fewer elements several threads do not pay.
const FEW_ELEMENTS: usize = if cfg!(miri) { 60 } else { 20_000 };

/// With fewer elements a second thread alone does not pay. Cache lines of blocks that both threads write move
/// between their caches, which takes twice the time while everything would fit into the cache of one.
const FEW_FOR_TWO: usize = if cfg!(miri) { 60 } else { 150_000 };

/// Number of points in the sample that is looked at first.
const SAMPLE: usize = 512;

/// Number of candidates that cost as much time as one more window.
const WINDOW: f64 = 10.0;

/// If one block holds more than one element in this number, most bins are empty.
const SKEWED: usize = 8;

/// The axes of a grid by their number of cells, the largest first; of equal ones the lower axis.
pub(crate) fn axes_of<const D: usize>(grid: &Grid<D>) -> [usize; D] {
    let cells = grid.cells();
    let mut axes = std::array::from_fn(|axis| axis);
    axes.sort_by_key(|&axis| std::cmp::Reverse(cells[axis]));
    axes
}

impl<T: Real, const D: usize> Layout<T, D> {
    pub(crate) fn new() -> Self {
        Self {
            coordinates: Vec::new(),
            far: Vec::new(),
            mean_width: 0.0,
            radii: Vec::new(),
            ids: Vec::new(),
            labels: Labels::default(),
            starts: Vec::new(),
            cells: Vec::new(),
            axes: std::array::from_fn(|axis| axis),
            grid: Grid::empty(),
            bins: Vec::new(),
            counts: Vec::new(),
            block_of: Vec::new(),
            blocks: Vec::new(),
            cursors: Vec::new(),
            sorts: Vec::new(),
        }
    }

    /// Copies and sorts all `points`, with `radii` unless that is empty.
    pub(crate) fn build(
        &mut self,
        points: &[[T; D]],
        radii: &[T],
        grid: Grid<D>,
        pool: &Pool,
    ) -> Result<(), Error> {
        self.build_along(points, radii, grid, axes_of(&grid), pool)
    }

    /// The same with the `axes` in a given order: that of the layout with which this one is to be compared.
    pub(crate) fn build_along(
        &mut self,
        points: &[[T; D]],
        radii: &[T],
        grid: Grid<D>,
        axes: [usize; D],
        pool: &Pool,
    ) -> Result<(), Error> {
        self.build_of(points, radii, AllElements(points.len()), grid, axes, pool)
    }

    /// Like [`Self::build_along`], for the `chosen` elements.
    ///
    /// Works in two steps: elements are dropped into blocks of rows, then every block is sorted in cache.
    pub(crate) fn build_of(
        &mut self,
        points: &[[T; D]],
        radii: &[T],
        chosen: impl Chosen,
        grid: Grid<D>,
        axes: [usize; D],
        pool: &Pool,
    ) -> Result<(), Error> {
        let n = chosen.len();
        self.grid = grid;
        self.axes = axes;
        self.cells.clear();
        self.far.clear();

        resize(&mut self.coordinates, D * n + PADDING, T::ZERO)?;
        resize(&mut self.ids, n + PADDING, 0)?;
        resize(&mut self.radii, if radii.is_empty() { 0 } else { n + PADDING }, T::ZERO)?;

        pool.stop().go_on()?;
        let mut keys = RowKeys::new(grid, &self.axes);
        let mut skewed = seem_skewed(points, chosen, &keys);
        if !skewed {
            self.find_blocks(points, chosen, &keys, pool)?;
            skewed = self.is_skewed();
        }
        if skewed {
            keys = keys.without_empty_stretches((0..n).map(|k| &points[chosen.number(k)]));
            self.find_blocks(points, chosen, &keys, pool)?;
        }
        pool.stop().go_on()?;
        self.fill_blocks(points, radii, chosen, pool)?;
        pool.stop().go_on()?;
        self.sort_blocks(&keys, pool)
    }

    /// Sets the upper ends of boxes, given by element; the lower ends have been sorted already.
    pub(crate) fn set_far(&mut self, far_points: &[[T; D]], tolerance: T, pool: &Pool) -> Result<(), Error> {
        let n = self.len();
        resize(&mut self.far, D * n + PADDING, T::ZERO)?;
        let (rows, each) = (self.rows(), self.rows().div_ceil(4 * pool.threads()));
        let (starts, ids) = (&self.starts, &self.ids);
        let mut far = self.far.as_mut_slice();
        let tasks = (0..rows).step_by(each).map(|first| {
            let starts = &starts[first..=rows.min(first + each)];
            let n = (starts[starts.len() - 1] - starts[0]) as usize;
            (starts, far.split_off_mut(..D * n).unwrap_or_default())
        });
        pool.run(tasks, |(starts, mut far)| {
            for row in starts.windows(2).map(|pair| pair[0] as usize..pair[1] as usize) {
                let of_row = far.split_off_mut(..D * row.len()).unwrap_or_default();
                for (k, &id) in ids[row.clone()].iter().enumerate() {
                    for (axis, &x) in far_points[id as usize].iter().enumerate() {
                        of_row[axis * row.len() + k] = x + tolerance;
                    }
                }
            }
        });
        let width = |place: usize| {
            let row = self.row(self.row_of(place));
            let at = D * row.start + self.axes[0] * row.len() + place - row.start;
            self.far[at].to_f64() - self.coordinates[at].to_f64()
        };
        let sample = (0..n).step_by(n.div_ceil(SAMPLE));
        let count = sample.len() as f64;
        self.mean_width = sample.map(|place| width(place) / count).sum();
        Ok(())
    }

    /// Whether boxes look only ahead, but in all rows around them, instead of ahead and back in half of the
    /// rows. That pays if most boxes are so much shorter than the longest one that the candidates left out
    /// outweigh twice the number of windows.
    pub(crate) fn looks_ahead(&self, reach: T) -> bool {
        let [low, high] = self.grid.span(self.axes[0]);
        let along_rows = self.len() as f64 / (self.rows() as f64 * (high - low));
        !self.far.is_empty() && (reach.to_f64() - self.mean_width) * along_rows > WINDOW
    }

    /// Arranges the numbers of a filter in the order that has been built.
    pub(crate) fn label(&mut self, filter: Option<Filter<'_>>, pool: &Pool) -> Result<(), Error> {
        let n = self.len();
        self.labels.arrange(filter, &self.ids[..n], PADDING, pool)
    }

    /// Counts the elements in bins of `2^shift` rows, and groups the bins into blocks.
    fn find_blocks(
        &mut self,
        points: &[[T; D]],
        chosen: impl Chosen,
        keys: &RowKeys<D>,
        pool: &Pool,
    ) -> Result<(), Error> {
        let n = chosen.len();
        let shift = shift_to_bins(keys);
        let bins = ((keys.rows() - 1) >> shift) as usize + 1;
        let stretch = stretch(n, pool);
        self.counts.clear();
        resize(&mut self.counts, n.div_ceil(stretch) * bins, 0)?;
        resize(&mut self.bins, n, 0)?;
        let firsts = (0..n).step_by(stretch);
        let tasks = firsts.zip(self.bins.chunks_mut(stretch)).zip(self.counts.chunks_mut(bins));
        pool.run(tasks, |((first, bins), counts)| {
            let (mut few, mut rows) = ([[T::ZERO; D]; FEW], [0; FEW]);
            for (first, bins) in (first..).step_by(FEW).zip(bins.chunks_mut(FEW)) {
                let points = chosen.points(points, first..first + bins.len(), &mut few);
                points.iter().for_each(prefetch::read);
                keys.of(points, &mut rows);
                for (bin, row) in bins.iter_mut().zip(rows) {
                    *bin = (row >> shift) as u16;
                    counts[(row >> shift) as usize] += 1;
                }
            }
        });

        let enough = (n / MAX_BLOCKS).max(BLOCK);
        self.blocks.clear();
        self.block_of.clear();
        let mut start = 0;
        for bin in 0..bins {
            if self.blocks.last().is_none_or(|block| start - block.start >= enough) {
                self.blocks.push(Block { first_row: (bin as u64) << shift, start });
            }
            self.block_of.push((self.blocks.len() - 1) as u16);
            start += self.counts[bin..].iter().step_by(bins).map(|&count| count as usize).sum::<usize>();
        }
        self.blocks.push(Block { first_row: keys.rows(), start });
        Ok(())
    }

    /// Whether one block holds a large part of the elements because most bins are empty.
    fn is_skewed(&self) -> bool {
        let n = self.bins.len();
        let largest = self.blocks.windows(2).map(|pair| pair[1].start - pair[0].start).max();
        n > SKEWED * BLOCK && largest.is_some_and(|largest| largest > n / SKEWED)
    }

    /// Drops every element into its block, in the order of the elements.
    ///
    /// Each thread drops one stretch of elements. In each block the first places belong to the first stretch,
    /// so the order is the same as on one thread.
    fn fill_blocks(
        &mut self,
        points: &[[T; D]],
        radii: &[T],
        chosen: impl Chosen,
        pool: &Pool,
    ) -> Result<(), Error> {
        let n = chosen.len();
        let (stretch, bins, blocks) = (stretch(n, pool), self.block_of.len(), self.blocks.len() - 1);
        let block_of = &self.block_of;
        self.cursors.clear();
        resize(&mut self.cursors, self.counts.len() / bins * blocks, 0)?;
        for (cursors, counts) in self.cursors.chunks_mut(blocks).zip(self.counts.chunks(bins)) {
            for (&block, count) in block_of.iter().zip(counts) {
                cursors[block as usize] += count;
            }
        }
        for (block, &Block { start, .. }) in self.blocks[..blocks].iter().enumerate() {
            let mut start = start as u32;
            for cursor in self.cursors[block..].iter_mut().step_by(blocks) {
                start += std::mem::replace(cursor, start);
            }
        }

        let places = Scatter::new(self.coordinates.as_chunks_mut::<D>().0);
        let (ids, their_radii) = (Scatter::new(&mut self.ids), Scatter::new(&mut self.radii));
        let firsts = (0..n).step_by(stretch);
        let tasks = firsts.zip(self.bins.chunks(stretch)).zip(self.cursors.chunks_mut(blocks));
        pool.run(tasks, |((first, bins), cursors)| {
            for (k, &bin) in (first..).zip(bins) {
                let number = chosen.number(k);
                let point = &points[number];
                prefetch::read(point);
                let place = &mut cursors[block_of[bin as usize] as usize];
                let at = *place as usize;
                *place += 1;
                // SAFETY: the sums above gave every block of every stretch a separate range of places, as
                // long as its count; one task has a stretch.
                unsafe {
                    places.write(at, *point);
                    ids.write(at, number as u32);
                    if !radii.is_empty() {
                        their_radii.write(at, radii[number]);
                    }
                }
            }
        });
        Ok(())
    }

    /// Sorts every block. A thread takes several consecutive blocks.
    fn sort_blocks(&mut self, keys: &RowKeys<D>, pool: &Pool) -> Result<(), Error> {
        let count = self.blocks.len() - 1;
        let stretches = if pool.threads() == 1 { 1 } else { count.min(4 * pool.threads()) };
        self.sorts.resize_with(stretches, BlockSort::default);
        let blocks = &self.blocks;
        let mut coordinates = self.coordinates.as_mut_slice();
        let mut ids = self.ids.as_mut_slice();
        let mut radii = self.radii.as_mut_slice();
        let tasks = self.sorts.iter_mut().enumerate().map(|(k, sort)| {
            let blocks = &blocks[k * count / stretches..=(k + 1) * count / stretches];
            let n = blocks[blocks.len() - 1].start - blocks[0].start;
            let elements = BlockElements {
                coordinates: coordinates.split_off_mut(..D * n).unwrap_or_default(),
                ids: ids.split_off_mut(..n).unwrap_or_default(),
                radii: radii.split_off_mut(..n).unwrap_or_default(),
            };
            (sort, blocks, elements)
        });
        pool.try_run(tasks, |(sort, blocks, elements)| sort.sort(keys, blocks, elements))?;
        self.starts.clear();
        reserve(&mut self.starts, self.sorts.iter().map(|sort| sort.starts.len()).sum::<usize>() + 1)?;
        for sort in &self.sorts {
            self.starts.extend_from_slice(&sort.starts);
        }
        self.starts.push(self.bins.len() as u32);
        Ok(())
    }

    /// The arrays that a kernel reads; `filter` is the one given to [`Layout::label`].
    pub(crate) fn arrays<'a>(&'a self, filter: Option<Filter<'a>>) -> Arrays<'a, T> {
        let filter = filter.map(|filter| self.labels.arranged(filter));
        Arrays { coordinates: &self.coordinates, far: &self.far, radii: &self.radii, ids: &self.ids, filter }
    }

    /// Number of rows that hold elements.
    pub(crate) fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The places of the elements of a row in the sorted order.
    #[inline]
    pub(crate) fn row(&self, row: usize) -> Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    /// Number of elements.
    pub(crate) fn len(&self) -> usize {
        self.starts[self.rows()] as usize
    }

    /// The row that holds the element at `place`.
    pub(crate) fn row_of(&self, place: usize) -> usize {
        self.starts.partition_point(|&start| start as usize <= place) - 1
    }

    /// The coordinates of a row along the long axis, ascending.
    pub(crate) fn along(&self, row: &Range<usize>) -> &[T] {
        &self.coordinates[D * row.start + self.axes[0] * row.len()..][..row.len()]
    }

    /// Estimate of the place in a row where the coordinate along it is `x`, assuming that elements are spread
    /// evenly.
    pub(crate) fn guess(&self, row: &Range<usize>, x: T) -> usize {
        let [low, high] = self.grid.span(self.axes[0]);
        let guess = (x.to_f64() - low) / (high - low) * row.len() as f64;
        // The conversion saturates.
        (guess as usize).min(row.len())
    }

    /// The radii of a row; empty if the elements have one radius or are boxes.
    pub(crate) fn radii(&self, row: &Range<usize>) -> &[T] {
        self.radii.get(row.clone()).unwrap_or_default()
    }

    /// The point at the place `k` of a row.
    pub(crate) fn point(&self, row: &Range<usize>, k: usize) -> [T; D] {
        std::array::from_fn(|axis| self.coordinates[D * row.start + axis * row.len() + k])
    }

    /// The smallest and largest coordinates of a stretch of a row, axis by axis.
    pub(crate) fn extremes(&self, row: &Range<usize>, stretch: &Range<usize>) -> [[T; D]; 2] {
        let (mut min, mut max) = ([T::ZERO; D], [T::ZERO; D]);
        for axis in 0..D {
            let block = &self.coordinates[D * row.start + axis * row.len()..][stretch.clone()];
            let first = block[0];
            (min[axis], max[axis]) = block.iter().fold((first, first), |(min, max), &x| {
                (if x < min { x } else { min }, if x > max { x } else { max })
            });
        }
        [min, max]
    }

    /// The cells of a row on all axes but the long one, most significant first. Rows ascend by these.
    #[inline]
    pub(crate) fn row_cells(&self, row: usize) -> [i64; D] {
        if let Some(cells) = self.cells.get(row) {
            return cells.map(i64::from);
        }
        let row = self.row(row);
        let mut cells = [0; D];
        for (cell, &axis) in cells.iter_mut().zip(self.axes[1..].iter().rev()) {
            *cell = self
                .grid
                .wide_cell(axis, self.coordinates[D * row.start + axis * row.len()].to_f64())
                .cast_signed();
        }
        cells
    }

    /// Stores the cells of each row for searches that skip from row to row. Finding the cells from the
    /// coordinates of an element would read memory that is seldom in cache.
    pub(crate) fn keep_cells(&mut self) -> Result<(), Error> {
        if self.grid.cells().iter().any(|&cells| cells > u64::from(u32::MAX)) {
            return Ok(());
        }
        let mut cells = std::mem::take(&mut self.cells);
        reserve(&mut cells, self.rows())?;
        cells.extend((0..self.rows()).map(|row| self.row_cells(row).map(|cell| cell as u32)));
        self.cells = cells;
        Ok(())
    }

    /// Upper bound on [`Layout::bytes`] for `n` elements over `grid`, unless a few bins hold most of them.
    /// `floats` is the number of floats per element in addition to its point: 1 for a radius, `D` for the
    /// upper ends of a box.
    pub(crate) fn expected_bytes(
        n: usize,
        floats: usize,
        labels: usize,
        grid: &Grid<D>,
        pool: &Pool,
    ) -> usize {
        let rows = rows_of(&grid.cells());
        let occupied = rows.min(n as f64) as usize;
        let bins = rows.min(MAX_BINS as f64) as usize;
        let blocks = bins.min(n / (n / MAX_BLOCKS).max(BLOCK) + 1);
        let stretches = n.div_ceil(stretch(n, pool));
        // A block is closed once it has enough elements, and the bin that closes it may be large.
        let in_block = n.min((n / MAX_BLOCKS).max(BLOCK) + 2 * n.div_ceil(bins));
        let sorts = if pool.threads() == 1 { 1 } else { blocks.min(4 * pool.threads()) };

        let element = (D + floats) * size_of::<T>() + size_of::<u32>();
        let arrays = (n + PADDING) * (element + labels * size_of::<u32>()) + n * size_of::<u16>();
        let counts = stretches * (bins + blocks) * size_of::<u32>();
        let lists = 2 * bins * size_of::<u16>() + 2 * blocks * size_of::<Block>();
        // The memory for starts doubles as they are found.
        let starts = 3 * (occupied + sorts) * size_of::<u32>();
        // There are at most as many digits as elements, fewer with two passes.
        let digits = (in_block + 16 * in_block.next_power_of_two().isqrt()) * size_of::<u32>();
        let sort = in_block * (element + 2 * size_of::<u64>()) + digits;
        arrays + counts + lists + starts + sorts * sort
    }

    /// Bytes held; small arrays that do not grow with the elements are left out.
    pub(crate) fn bytes(&self) -> usize {
        let sorts: usize = self.sorts.iter().map(BlockSort::bytes).sum();
        let floats = self.coordinates.capacity() + self.far.capacity() + self.radii.capacity();
        let integers = self.ids.capacity()
            + self.starts.capacity()
            + self.counts.capacity()
            + self.cursors.capacity()
            + D * self.cells.capacity();
        let small = self.bins.capacity() + self.block_of.capacity();
        floats * size_of::<T>()
            + integers * size_of::<u32>()
            + small * size_of::<u16>()
            + self.blocks.capacity() * size_of::<Block>()
            + sorts
            + self.labels.bytes()
    }
}

/// The smallest shift with which bins of `2^shift` rows are few enough.
fn shift_to_bins<const D: usize>(keys: &RowKeys<D>) -> u32 {
    (0..64).find(|shift| (keys.rows() - 1) >> shift < MAX_BINS).unwrap_or(63)
}

/// Whether a sample of the points shows that one bin holds a large part of all points. Then not all need be
/// counted to find that out.
fn seem_skewed<T: Real, const D: usize>(points: &[[T; D]], chosen: impl Chosen, keys: &RowKeys<D>) -> bool {
    let shift = shift_to_bins(keys);
    let mut bins = [0; SAMPLE];
    let step = chosen.len() / SAMPLE;
    if step < SKEWED {
        return false;
    }
    for (bin, k) in bins.iter_mut().zip((0..chosen.len()).step_by(step)) {
        let point = &points[chosen.number(k)];
        keys.of(std::slice::from_ref(point), std::slice::from_mut(bin));
        *bin >>= shift;
    }
    bins.sort_unstable();
    bins.chunk_by(u64::eq).any(|equal| equal.len() > 2 * SAMPLE / SKEWED)
}

/// Number of consecutive elements that one thread counts and drops into blocks.
fn stretch(n: usize, pool: &Pool) -> usize {
    let few = if pool.threads() == 2 { FEW_FOR_TWO } else { FEW_ELEMENTS };
    if n < few { n } else { n.div_ceil(pool.threads()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::Elements;

    /// The order of the layout equals that of a plain sort by cells, then along the row, then by number, for
    /// any number of threads.
    fn is_a_plain_sort<const D: usize>(points: &[[f64; D]], reach: f64, what: &str) {
        let elements = Elements::points(points, reach).unwrap();
        let grid = Grid::unbounded(&elements);
        for threads in [1, 3] {
            let Ok(pool) = Pool::new(threads) else { continue };
            let mut layout = Layout::new();
            layout.build(points, &[], grid, &pool).unwrap();
            let axes = layout.axes;
            let cells = |k: u32| {
                axes[1..].iter().rev().map(move |&axis| grid.wide_cell(axis, points[k as usize][axis]))
            };
            let along = |k: u32| points[k as usize][axes[0]];
            let mut expected: Vec<u32> = (0..points.len() as u32).collect();
            expected.sort_by(|&a, &b| cells(a).cmp(cells(b)).then(along(a).partial_cmp(&along(b)).unwrap()));
            assert_eq!(layout.ids[..points.len()], expected, "{what}, D = {D}, {threads} threads");
            let mut starts = vec![0];
            for k in 1..points.len() {
                if !cells(expected[k - 1]).eq(cells(expected[k])) {
                    starts.push(k as u32);
                }
            }
            starts.push(points.len() as u32);
            assert_eq!(layout.starts, starts, "{what}, D = {D}, {threads} threads: rows");
            for row in 0..layout.rows() {
                let row = layout.row(row);
                for (k, &id) in expected[row.clone()].iter().enumerate() {
                    let at = |axis: usize| layout.coordinates[D * row.start + axis * row.len() + k];
                    assert_eq!(std::array::from_fn(at), points[id as usize], "{what}, D = {D}: coordinates");
                }
            }
        }
    }

    fn is_a_plain_sort_of_any_distribution<const D: usize>() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut points = |n: usize, width: f64| -> Vec<[f64; D]> {
            (0..n).map(|_| std::array::from_fn(|_| random() * width)).collect()
        };
        for n in [1, 2, 33, 500, 40_000] {
            is_a_plain_sort(&points(n, (n as f64).powf(1.0 / D as f64)), 1.0, "gas");
            is_a_plain_sort(&points(n, 0.9), 1.0, "all in one cell");
            is_a_plain_sort(&points(n, 1e6), 1.0, "far apart");
            is_a_plain_sort(&points(n, 1e15), 1.0, "so far apart that rows are not counted");
            let rounded = points(n, 7.0).iter().map(|point| point.map(f64::floor)).collect::<Vec<_>>();
            is_a_plain_sort(&rounded, 1.0, "many in one place");
            is_a_plain_sort(&vec![[1.5; D]; n], 1.0, "all in one place");
            let mut thrown = points(n, 30.0);
            thrown[n / 2] = [1e12; D];
            is_a_plain_sort(&thrown, 1.0, "one thrown far away");
            let mut clusters = points(n, 5.0);
            for (k, point) in clusters.iter_mut().enumerate() {
                *point = point.map(|x| x + (k % 7) as f64 * 1e7);
            }
            is_a_plain_sort(&clusters, 1.0, "clusters");
        }
    }

    /// The last block has few elements, and its rows lie on both sides of row number `2^40`: the number of
    /// the row and the place together would need more bits than an integer has.
    #[test]
    fn rows_are_counted_from_the_block() {
        let mut state = 3_u64;
        for n in BLOCK + 1..BLOCK + 24 {
            let mut random = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 * 1_049_100.0
            };
            let points: Vec<[f64; 3]> = (0..n).map(|_| std::array::from_fn(|_| random())).collect();
            is_a_plain_sort(&points, 1.0, "a small last block");
        }
    }

    #[test]
    fn the_order_is_that_of_a_plain_sort() {
        is_a_plain_sort_of_any_distribution::<1>();
        is_a_plain_sort_of_any_distribution::<2>();
        is_a_plain_sort_of_any_distribution::<3>();
        is_a_plain_sort_of_any_distribution::<5>();
    }
}
