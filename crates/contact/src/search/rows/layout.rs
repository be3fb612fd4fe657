//! Elements in row order: the lists of NBS as sorted, contiguous runs.

#![allow(unsafe_code, reason = "one scatter, to places of its own for every thread")]

use std::ops::Range;

use crate::error::Error;
use crate::grid::Grid;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::rows::axis::AxisMap;
use crate::search::rows::buckets::Buckets;
use crate::search::rows::row_sort::RowSort;
use crate::search::rows::scatter::Scatter;

/// A copy of the elements, sorted by row of cells and by coordinate inside the row.
///
/// A *row* is all cells that differ in one axis only, the *long* one: the axis with the most cells. Only rows that hold
/// elements exist. Inside a row the coordinates are stored axis by axis, so that a vector holds one coordinate of
/// neighbouring elements.
///
/// # Shapes
/// Row `r` holds the elements `starts[r]..starts[r + 1]`. With `start` and `len` of it, axis `a` of the row is
/// `coordinates[D * start + a * len ..][.. len]`, ascending for the long axis; `ids` and `radii` are `[start ..][.. len]`.
/// All arrays end with [`PADDING`] unused entries, so that a vector may be loaded from any element on.
#[derive(Clone, Debug)]
pub(crate) struct Layout<T, const D: usize> {
    pub(crate) coordinates: Vec<T>,
    /// Empty for elements of one radius.
    pub(crate) radii: Vec<T>,
    pub(crate) ids: Vec<u32>,
    /// First element of each row, and the number of elements.
    pub(crate) starts: Vec<u32>,
    /// The axes by number of cells: the long one first, then the one whose rows change fastest.
    pub(crate) axes: [usize; D],
    pub(crate) grid: Grid<D>,
    /// The row of each element, where rows are counted; one bucket for each row.
    keys: Vec<u32>,
    counts: Vec<u32>,
    maps: Vec<AxisMap>,
    sorts: Vec<RowSort<T>>,
    buckets: Buckets,
}

/// The widest vector is 16 lanes (`f32`, AVX-512).
pub(crate) const PADDING: usize = 16;

/// Rows are counted, in one pass, if there are at most so many per element, empty ones included. The bound keeps memory
/// proportional to N, and the counts in cache.
const MAX_ROWS_PER_ELEMENT: f64 = 0.5;

/// Fewer elements are not worth a second thread.
const FEW_ELEMENTS: usize = 20_000;

/// Few elements may have many rows.
const FEW_ROWS: f64 = 1024.0;

impl<T: Real, const D: usize> Layout<T, D> {
    pub(crate) fn new() -> Self {
        Self {
            coordinates: Vec::new(),
            radii: Vec::new(),
            ids: Vec::new(),
            starts: Vec::new(),
            axes: std::array::from_fn(|axis| axis),
            grid: Grid::empty(),
            keys: Vec::new(),
            counts: Vec::new(),
            maps: Vec::new(),
            sorts: Vec::new(),
            buckets: Buckets::default(),
        }
    }

    /// Copies and sorts `points`, with `radii` unless that is empty.
    pub(crate) fn build(
        &mut self,
        points: &[[T; D]],
        radii: &[T],
        grid: Grid<D>,
        pool: &Pool,
    ) -> Result<(), Error> {
        self.grid = grid;
        let cells = grid.cells();
        self.axes = std::array::from_fn(|axis| axis);
        self.axes.sort_by_key(|&axis| std::cmp::Reverse(cells[axis]));

        resize(&mut self.coordinates, D * points.len() + PADDING, T::ZERO)?;
        resize(&mut self.ids, points.len() + PADDING, 0)?;
        resize(&mut self.radii, if radii.is_empty() { 0 } else { points.len() + PADDING }, T::ZERO)?;
        self.starts.clear();

        let limit = (points.len() as f64 * MAX_ROWS_PER_ELEMENT).max(FEW_ROWS);
        self.maps.clear();
        self.maps.extend(self.axes[1..].iter().map(|&axis| AxisMap::identity(cells[axis])));
        if self.rows_with_maps() > limit {
            for (map, &axis) in self.maps.iter_mut().zip(&self.axes[1..]) {
                map.skip_empty_stretches(
                    points.iter().map(|point| grid.wide_cell(axis, point[axis].to_f64())),
                );
            }
        }
        if self.rows_with_maps() <= limit {
            self.count_rows(points, radii, pool)
        } else {
            self.bucket_rows(points, radii)
        }
    }

    /// Number of rows, empty ones included.
    fn rows_with_maps(&self) -> f64 {
        self.maps.iter().map(|map| map.cells() as f64).product()
    }

    /// Rows by counting: one pass over the elements finds how many each row has, the next drops them there.
    ///
    /// Every thread counts a stretch of the elements; of each row the first places go to the first stretch. So the
    /// order is that of one thread.
    fn count_rows(&mut self, points: &[[T; D]], radii: &[T], pool: &Pool) -> Result<(), Error> {
        let (rows, n) = (self.rows_with_maps() as usize, points.len());
        let stretches = if n < FEW_ELEMENTS { 1 } else { pool.threads() };
        let stretch = n.div_ceil(stretches);
        self.counts.clear();
        resize(&mut self.counts, stretches * rows, 0)?;
        resize(&mut self.keys, n, 0)?;

        let (grid, axes, maps) = (self.grid, self.axes, &self.maps);
        let tasks =
            points.chunks(stretch).zip(self.keys.chunks_mut(stretch)).zip(self.counts.chunks_mut(rows));
        pool.run(tasks, |((points, keys), counts)| {
            for (point, key) in points.iter().zip(keys) {
                let mut row = 0;
                for (map, &axis) in maps.iter().zip(&axes[1..]).rev() {
                    let cell = map.map(grid.wide_cell(axis, point[axis].to_f64()));
                    row = row * map.cells() as u32 + cell as u32;
                }
                *key = row;
                counts[row as usize] += 1;
            }
        });

        let mut start = 0;
        for row in 0..rows {
            let first = start;
            for count in self.counts[row..].iter_mut().step_by(rows) {
                start += std::mem::replace(count, start);
            }
            if start > first {
                self.starts.push(first);
            }
        }
        self.starts.push(start);

        let places = Scatter::new(self.coordinates.as_chunks_mut::<D>().0);
        let (ids, their_radii) = (Scatter::new(&mut self.ids), Scatter::new(&mut self.radii));
        let tasks = points.chunks(stretch).zip(self.keys.chunks(stretch)).zip(self.counts.chunks_mut(rows));
        pool.run(tasks.enumerate(), |(k, ((points, keys), counts))| {
            let first = k * stretch;
            for ((point, &key), index) in points.iter().zip(keys).zip(first..) {
                let place = &mut counts[key as usize];
                let at = *place as usize;
                *place += 1;
                // SAFETY: the sums above gave every row of every stretch a range of its own, as long as its count.
                unsafe {
                    places.write(at, *point);
                    ids.write(at, index as u32);
                    if !radii.is_empty() {
                        their_radii.write(at, radii[index]);
                    }
                }
            }
        });
        self.sort_rows(pool);
        Ok(())
    }

    /// Sorts every row along the long axis; threads take stretches of rows with about as many elements each.
    fn sort_rows(&mut self, pool: &Pool) {
        let long = self.axes[0];
        let stretches = if pool.threads() == 1 { 1 } else { 4 * pool.threads() };
        self.sorts.resize_with(stretches, RowSort::default);
        let with_radii = !self.radii.is_empty();
        let mut coordinates = self.coordinates.as_mut_slice();
        let mut ids = self.ids.as_mut_slice();
        let mut radii = self.radii.as_mut_slice();
        let stretches =
            self.sorts.iter_mut().zip(stretches_of_rows(&self.starts, stretches)).map(|(sort, rows)| {
                let starts = &self.starts[rows.start..=rows.end];
                let n = (starts[starts.len() - 1] - starts[0]) as usize;
                let coordinates = coordinates.split_off_mut(..D * n).unwrap_or_default();
                let ids = ids.split_off_mut(..n).unwrap_or_default();
                let radii = radii.split_off_mut(..if with_radii { n } else { 0 }).unwrap_or_default();
                (sort, starts, coordinates, ids, radii)
            });
        pool.run(stretches, |(sort, starts, coordinates, ids, radii)| {
            for row in starts.windows(2) {
                let row = (row[0] - starts[0]) as usize..(row[1] - starts[0]) as usize;
                let radii = radii.get_mut(row.clone()).unwrap_or_default();
                sort.sort::<D>(long, &mut coordinates[D * row.start..D * row.end], &mut ids[row], radii);
            }
        });
    }

    /// Rows by buckets within buckets, for domains with more rows than elements.
    fn bucket_rows(&mut self, points: &[[T; D]], radii: &[T]) -> Result<(), Error> {
        let n = points.len();
        let (grid, axes) = (self.grid, self.axes);
        let cell = |id: u32, level: usize| {
            let axis = axes[level];
            grid.wide_cell(axis, points[id as usize][axis].to_f64())
        };
        let long = axes[0];
        self.ids.iter_mut().zip(0..).for_each(|(id, index)| *id = index);
        self.buckets.sort(&mut self.ids[..n], D - 1, &cell, &|a, b| {
            let [x, y] = [a, b].map(|id: u32| points[id as usize][long]);
            x.partial_cmp(&y).unwrap_or(std::cmp::Ordering::Equal).then(a.cmp(&b))
        })?;

        let ids = &self.ids[..n];
        let same_row = |a: &u32, b: &u32| (1..D).all(|level| cell(*a, level) == cell(*b, level));
        let mut start = 0;
        for row in ids.chunk_by(same_row) {
            self.starts.push(start as u32);
            let len = row.len();
            for (axis, _) in self.axes.iter().enumerate() {
                let block = &mut self.coordinates[D * start + axis * len..][..len];
                for (x, &id) in block.iter_mut().zip(row) {
                    *x = points[id as usize][axis];
                }
            }
            start += len;
        }
        self.starts.push(n as u32);
        if !radii.is_empty() {
            for (radius, &id) in self.radii.iter_mut().zip(ids) {
                *radius = radii[id as usize];
            }
        }
        Ok(())
    }

    /// Number of rows that hold elements.
    pub(crate) fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The elements of a row, by their place in the order.
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

    /// The cells of a row on all axes but the long one, most significant first; rows ascend by it.
    #[inline]
    pub(crate) fn row_cells(&self, row: usize) -> [i64; D] {
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

    /// Bytes held, per element where it matters.
    pub(crate) fn bytes(&self) -> usize {
        let sorts: usize = self.sorts.iter().map(RowSort::bytes).sum();
        let floats = self.coordinates.capacity() + self.radii.capacity();
        let integers =
            self.ids.capacity() + self.starts.capacity() + self.keys.capacity() + self.counts.capacity();
        floats * size_of::<T>() + integers * size_of::<u32>() + sorts + self.buckets.bytes()
    }
}

/// Cuts the rows into at most `count` stretches with about as many elements each. `starts` as in [`Layout`].
pub(crate) fn stretches_of_rows(starts: &[u32], count: usize) -> impl Iterator<Item = Range<usize>> {
    let (rows, n) = (starts.len() - 1, starts[starts.len() - 1] as usize);
    let cut = move |k: usize| {
        if k == count {
            rows
        } else {
            starts[..rows].partition_point(|&start| (start as usize) < k * n / count)
        }
    };
    (0..count).map(move |k| cut(k)..cut(k + 1)).filter(|rows| !rows.is_empty())
}

/// Exactly `len` entries; existing ones keep their value.
pub(crate) fn resize<V: Clone>(values: &mut Vec<V>, len: usize, value: V) -> Result<(), Error> {
    reserve(values, len.saturating_sub(values.len()))?;
    values.resize(len, value);
    Ok(())
}

/// Room for `more` entries, and no more than that.
pub(crate) fn reserve<V>(values: &mut Vec<V>, more: usize) -> Result<(), Error> {
    let bytes = (values.len() + more).saturating_mul(size_of::<V>());
    values.try_reserve_exact(more).map_err(|_| Error::OutOfMemory { bytes })
}
