//! The keys by which elements are sorted into rows.

use std::cmp::Ordering;

use crate::grid::{Grid, nearest_integer};
use crate::real::Real;
use crate::search::rows::axis::AxisMap;

/// The cells of an element on all axes but the long one, as one integer; rows ascend by it.
///
/// In domains with more rows than [`MAX_ROWS`] the key holds the most significant axes only, and several rows
/// share a key.
#[derive(Clone, Debug)]
pub(crate) struct RowKeys<const D: usize> {
    grid: Grid<D>,
    /// The axes, most significant first, the long one last.
    axes: [usize; D],
    /// How the cells of each axis are numbered; empty if every cell has its own number.
    maps: Vec<AxisMap>,
    /// How many of the axes the key holds.
    held: usize,
    rows: u64,
}

/// Converts coordinates along the rows into integers that ascend with them: fractions of the extent of the
/// domain. If most of the domain is empty, fractions of the range of some points instead, because a single
/// far element would leave the same integer for all others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    low: f64,
    scale: f64,
    last: f64,
    bits: u32,
}

impl Places {
    /// The integer for a coordinate of one of the points.
    #[inline]
    fn of(&self, x: f64) -> u64 {
        let place = (x - self.low) * self.scale;
        nearest_integer(if place < self.last { place } else { self.last })
    }
}

/// Largest number of rows that keys can distinguish: it leaves bits for the place along the row.
const MAX_ROWS: f64 = 281_474_976_710_656.0;

impl<const D: usize> RowKeys<D> {
    /// Keys for the cells of `grid`. `axes` are sorted by number of cells, the long one first.
    pub(crate) fn new(grid: Grid<D>, axes: &[usize; D]) -> Self {
        let mut axes = *axes;
        axes.reverse();
        Self { grid, axes, maps: Vec::new(), held: 0, rows: 0 }.hold_axes()
    }

    /// The same keys without the stretches of cells that hold none of `points`.
    pub(crate) fn without_empty_stretches<'p, T: Real>(
        mut self,
        points: impl Iterator<Item = &'p [T; D]>,
    ) -> Self {
        let axes = &self.axes[..D - 1];
        let mut maps: Vec<_> = axes.iter().map(|&axis| AxisMap::new(self.grid.cells()[axis])).collect();
        for point in points {
            for (map, &axis) in maps.iter_mut().zip(axes) {
                map.occupy(self.grid.wide_cell(axis, point[axis].to_f64()));
            }
        }
        maps.iter_mut().for_each(AxisMap::number);
        self.maps = maps;
        self.hold_axes()
    }

    fn hold_axes(mut self) -> Self {
        let cells =
            |level: usize| self.maps.get(level).map_or(self.grid.cells()[self.axes[level]], AxisMap::cells);
        let mut rows = 1.0;
        let fits = |&level: &usize| {
            rows *= cells(level) as f64;
            rows <= MAX_ROWS
        };
        let held = (0..D - 1).take_while(fits).count();
        self.rows = (0..held).map(cells).product();
        self.held = held;
        self
    }

    /// Number of keys, including those of empty rows.
    pub(crate) fn rows(&self) -> u64 {
        self.rows
    }

    /// Whether every row has a separate number.
    pub(crate) fn are_complete(&self) -> bool {
        self.held == D - 1
    }

    /// Writes the key of each point.
    #[inline]
    pub(crate) fn of<T: Real>(&self, points: &[[T; D]], keys: &mut [u64]) {
        if !self.maps.is_empty() {
            for (key, point) in keys.iter_mut().zip(points) {
                *key = 0;
                for (map, &axis) in self.maps.iter().zip(&self.axes[..self.held]) {
                    *key = *key * map.cells() + map.map(self.grid.wide_cell(axis, point[axis].to_f64()));
                }
            }
            return;
        }
        // Computed in floats, which are exact for such numbers. An axis that the key does not hold has one
        // cell, number 0.
        let (mut cells, mut step) = ([1.0; D], [0.0; D]);
        for level in 0..self.held {
            (cells[level], step[level]) = (self.grid.cells()[self.axes[level]] as f64, 1.0);
        }
        for (key, point) in keys.iter_mut().zip(points) {
            let mut row = 0.0;
            for level in 0..D - 1 {
                let axis = self.axes[level];
                row = row * cells[level] + self.grid.rounded_cell(axis, point[axis].to_f64()) * step[level];
            }
            *key = nearest_integer(row);
        }
    }

    /// Writes the key of each point, counted from `first_row`, followed by its place along the row.
    #[inline]
    pub(crate) fn add_places<T: Real>(
        &self,
        points: &[[T; D]],
        first_row: u64,
        places: &Places,
        keys: &mut [u64],
    ) {
        let long = self.long();
        for (key, point) in keys.iter_mut().zip(points) {
            *key = (*key - first_row) << places.bits | places.of(point[long].to_f64());
        }
    }

    /// A conversion into integers of `bits` bits for places along the rows of `points`.
    pub(crate) fn places<T: Real>(&self, points: &[[T; D]], bits: u32) -> Places {
        let long = self.long();
        let [mut low, mut high] = self.grid.span(long);
        if !self.maps.is_empty() {
            (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
            for point in points {
                let x = point[long].to_f64();
                low = if x < low { x } else { low };
                high = if x > high { x } else { high };
            }
        }
        let parts = ((1_u64 << bits) - 1) as f64;
        Places { low, scale: if high > low { parts / (high - low) } else { 0.0 }, last: parts, bits }
    }

    /// The order of two points by row, also if keys do not hold all axes.
    pub(crate) fn compare<T: Real>(&self, a: &[T; D], b: &[T; D]) -> Ordering {
        let cells = |point: &[T; D]| {
            let point = *point;
            self.axes[..D - 1].iter().map(move |&axis| self.grid.wide_cell(axis, point[axis].to_f64()))
        };
        cells(a).cmp(cells(b))
    }

    /// The axis along which rows are sorted.
    pub(crate) fn long(&self) -> usize {
        self.axes[D - 1]
    }

    /// The order of two points along their row.
    pub(crate) fn along<T: Real>(&self, a: &[T; D], b: &[T; D]) -> Ordering {
        let long = self.axes[D - 1];
        a[long].partial_cmp(&b[long]).unwrap_or(Ordering::Equal)
    }
}
