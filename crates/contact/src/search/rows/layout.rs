//! Elements in row order: the lists of NBS as sorted, contiguous runs.

use std::ops::Range;

use crate::error::Error;
use crate::grid::Grid;
use crate::real::Real;
use crate::search::rows::axis::AxisMap;
use crate::search::rows::buckets::Buckets;
use crate::search::rows::row_sort::RowSort;

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
    sort: RowSort<T>,
    buckets: Buckets,
}

/// The widest vector is 16 lanes (`f32`, AVX-512).
pub(crate) const PADDING: usize = 16;

/// Rows are counted, in one pass, if there are at most so many per element, empty ones included. The bound keeps memory
/// proportional to N, and the counts in cache.
const MAX_ROWS_PER_ELEMENT: f64 = 0.5;

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
            sort: RowSort::default(),
            buckets: Buckets::default(),
        }
    }

    /// Copies and sorts `points`, with `radii` unless that is empty.
    pub(crate) fn build(&mut self, points: &[[T; D]], radii: &[T], grid: Grid<D>) -> Result<(), Error> {
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
            self.count_rows(points, radii)
        } else {
            self.bucket_rows(points, radii)
        }
    }

    /// Number of rows, empty ones included.
    fn rows_with_maps(&self) -> f64 {
        self.maps.iter().map(|map| map.cells() as f64).product()
    }

    /// Rows by counting: one pass over the elements finds how many each row has, the next drops them there.
    fn count_rows(&mut self, points: &[[T; D]], radii: &[T]) -> Result<(), Error> {
        let rows = self.rows_with_maps() as usize;
        self.counts.clear();
        resize(&mut self.counts, rows, 0)?;
        resize(&mut self.keys, points.len(), 0)?;
        let (grid, axes) = (self.grid, self.axes);
        for (point, key) in points.iter().zip(&mut self.keys) {
            let mut row = 0;
            for (map, &axis) in self.maps.iter().zip(&axes[1..]).rev() {
                let cell = map.map(grid.wide_cell(axis, point[axis].to_f64()));
                row = row * map.cells() as u32 + cell as u32;
            }
            *key = row;
            self.counts[row as usize] += 1;
        }

        let mut start = 0;
        for count in &mut self.counts {
            if *count > 0 {
                self.starts.push(start);
            }
            start += std::mem::replace(count, start);
        }
        self.starts.push(start);

        let (places, _) = self.coordinates.as_chunks_mut::<D>();
        for ((point, &key), index) in points.iter().zip(&self.keys).zip(0..) {
            let place = &mut self.counts[key as usize];
            let at = *place as usize;
            *place += 1;
            places[at] = *point;
            self.ids[at] = index;
            if !radii.is_empty() {
                self.radii[at] = radii[index as usize];
            }
        }

        let long = self.axes[0];
        for row in self.starts.windows(2) {
            let row = row[0] as usize..row[1] as usize;
            let radii = self.radii.get_mut(row.clone()).unwrap_or_default();
            let coordinates = &mut self.coordinates[D * row.start..D * row.end];
            self.sort.sort::<D>(long, coordinates, &mut self.ids[row], radii);
        }
        Ok(())
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
        let floats = self.coordinates.capacity() + self.radii.capacity();
        let integers =
            self.ids.capacity() + self.starts.capacity() + self.keys.capacity() + self.counts.capacity();
        floats * size_of::<T>() + integers * size_of::<u32>() + self.sort.bytes() + self.buckets.bytes()
    }
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
