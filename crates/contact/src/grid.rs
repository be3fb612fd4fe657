//! The grid: which cell an element belongs to, and how many cells there are along each axis.

use crate::elements::{Bounds, Elements};
use crate::error::Error;
use crate::real::Real;

/// A grid of square (cubic, …) cells over the domain. Points are mapped to integer coordinates axis by axis.
///
/// Cell `i` of an axis holds the points with `Int((x - x_min) / d) = i`, counted from 0: equations (3.59) to
/// (3.62) of the book, pp. 104-107. The edge `d` is the largest element plus the tolerance, widened so that
/// touching elements are at most one cell apart even though this division rounds.
///
/// # Why touching elements are at most one cell apart
/// Let `R` bound the distance of the anchors of touching elements along an axis, with the rounding of the
/// contact test included (`Elements::reach`). The subtraction, the inverse and the product below each round
/// once, so the computed quotient is `q = (x - x_min)/d * (1 + e)` with `|e| <= 3.1 * 2^-53`. With less than
/// `2^31` cells on the axis, two such quotients together differ from the exact ones by less than
/// `2^32 * 3.1 * 2^-53 < 2^-19`. With `d = R * (1 + 2^-18)` the exact quotients differ by at most
/// `1 - 2^-18 + 2^-36`. Therefore the computed ones differ by less than 1, and their integer parts by at
/// most 1.
///
/// A grid without list heads (`Grid::unbounded`) may have up to `2^46` cells on an axis. Its quotients
/// together are off by less than `2^47 * 3.1 * 2^-53 < 0.05`, and its edge is at least `R * (1 + 1/8)`; the
/// same argument holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    origin: [f64; D],
    cell_size: f64,
    inverse: f64,
    cells: [u64; D],
}

/// With more cells along one axis the bound on rounding above would not hold.
const MAX_CELLS_PER_AXIS: f64 = 2_147_483_648.0;

/// The limit without list heads, where the edge is an eighth wider.
const MAX_UNBOUNDED_CELLS: f64 = 70_368_744_177_664.0;

/// Factor by which a cell is wider than the largest element, to cover rounding.
const WIDENING: f64 = 1.0 + 1.0 / 262_144.0;

impl<const D: usize> Grid<D> {
    /// A grid that covers the elements, or the `domain` if one is given.
    ///
    /// `max_heads` limits the number of list heads over this grid: one set on the last axis, two on each
    /// other axis.
    ///
    /// # Errors
    /// [`Error::DomainTooWide`], [`Error::InvalidDomain`], [`Error::OutsideDomain`].
    pub(crate) fn fit<T: Real>(
        elements: &Elements<'_, T, D>,
        domain: Option<[[f64; 2]; D]>,
        max_heads: usize,
    ) -> Result<Self, Error> {
        let bounds = elements.bounds();
        let (mut min, mut max) = (bounds.min, bounds.max);
        if let Some(domain) = domain {
            check_domain(elements, &domain)?;
            min = domain.map(|[low, _]| low);
            max = domain.map(|[_, high]| high);
        }
        let cell_size = cell_size::<T, D>(elements.reach(), elements.len(), &Bounds { min, max });
        let mut grid = Self { origin: min, cell_size, inverse: 1.0 / cell_size, cells: [0; D] };

        let counts: [f64; D] = std::array::from_fn(|axis| grid.quotient(axis, max[axis]).floor() + 1.0);
        let heads =
            counts.iter().enumerate().map(|(axis, n)| if axis + 1 == D { *n } else { 2.0 * n }).sum::<f64>();
        let countable = counts.iter().all(|&n| n < MAX_CELLS_PER_AXIS);
        if !(countable && heads <= max_heads as f64) {
            return Err(grid.too_wide(elements, domain.is_some(), &counts, heads, max_heads));
        }
        grid.cells = counts.map(|n| n as u64);
        Ok(grid)
    }

    /// A grid of no cells.
    pub(crate) fn empty() -> Self {
        Self { origin: [0.0; D], cell_size: 1.0, inverse: 1.0, cells: [0; D] }
    }

    /// A grid that covers the elements however wide their domain is, for searches that store nothing per
    /// cell.
    pub(crate) fn unbounded<T: Real>(elements: &Elements<'_, T, D>) -> Self {
        Self::unbounded_of::<T>(elements.reach(), elements.len(), elements.bounds())
    }

    /// The same for a number of elements that are not here, with their [reach](Elements::reach).
    pub(crate) fn unbounded_of<T: Real>(reach: f64, elements: usize, bounds: Bounds<D>) -> Self {
        Self::countless(bounds, cell_size::<T, D>(reach, elements, &bounds))
    }

    /// The same for elements that touch nothing farther away than `reach`; the edge of a cell is at least
    /// `edge`.
    pub(crate) fn for_reach<T: Real>(bounds: Bounds<D>, reach: f64, edge: f64) -> Self {
        Self::countless(bounds, (reach.max(T::MIN_RESOLVED) * WIDENING).max(edge))
    }

    fn countless(bounds: Bounds<D>, mut cell_size: f64) -> Self {
        let widest = (0..D).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f64::max);
        if widest / cell_size >= MAX_CELLS_PER_AXIS / 2.0 {
            cell_size = (cell_size * 1.125).max(widest / MAX_UNBOUNDED_CELLS);
        }
        let mut grid = Self { origin: bounds.min, cell_size, inverse: 1.0 / cell_size, cells: [0; D] };
        grid.cells = std::array::from_fn(|axis| grid.wide_cell(axis, bounds.max[axis]) + 1);
        grid
    }

    /// A grid over other points with the same edge, whose cell faces lie in the same places. The edge is
    /// wider if there would be too many cells.
    ///
    /// The places of the faces affect speed only.
    pub(crate) fn over(&self, bounds: Bounds<D>) -> Self {
        let origin = std::array::from_fn(|axis| {
            let min = bounds.min[axis];
            let face = self.origin[axis] + self.quotient(axis, min).floor() * self.cell_size;
            // Far from the origin of this grid the rounding of a face exceeds a cell.
            if face <= min && min - face <= self.cell_size { face } else { min }
        });
        Self::with_cell_size(origin, bounds.max, self.cell_size)
    }

    /// A grid over points from `min` to `max` whose edge was chosen for speed alone; the edge is wider if
    /// there would be too many cells.
    pub(crate) fn with_cell_size(min: [f64; D], max: [f64; D], cell_size: f64) -> Self {
        let widest = (0..D).map(|axis| max[axis] - min[axis]).fold(0.0, f64::max);
        let cell_size = cell_size.max(widest / MAX_UNBOUNDED_CELLS);
        let mut grid = Self { origin: min, cell_size, inverse: 1.0 / cell_size, cells: [0; D] };
        grid.cells = std::array::from_fn(|axis| grid.wide_cell(axis, max[axis]) + 1);
        grid
    }

    /// The grid over the same domain whose cells are wider by `factor`, at least 1.
    pub(crate) fn wider(&self, factor: f64) -> Self {
        let max = std::array::from_fn(|axis| self.span(axis)[1]);
        Self::with_cell_size(self.origin, max, self.cell_size * factor)
    }

    /// Edge of a cell, in the unit of the coordinates.
    pub fn cell_size(&self) -> f64 {
        self.cell_size
    }

    /// 1 over the edge of a cell.
    pub(crate) fn inverse(&self) -> f64 {
        self.inverse
    }

    /// Number of cells along each axis: `n_x`, `n_y`, … in (3.55) and (3.56).
    pub fn cells(&self) -> [u64; D] {
        self.cells
    }

    /// The cell of coordinate `x` along `axis`, counted from 0: (3.59) to (3.62).
    #[inline]
    pub(crate) fn cell(&self, axis: usize, x: f64) -> u32 {
        self.quotient(axis, x) as u32
    }

    /// The cell of coordinate `x` as in [`Grid::cell`], but for grids with more cells than `u32` can count,
    /// and rounded to the nearest integer instead of down.
    ///
    /// The proof above only needs the quotient to be rounded to an integer in some monotonic way. Rounding to
    /// nearest takes two instructions: a sum beyond `2^52` has no room for a fraction, and its last bits are
    /// the integer. Twin: `cell_of` in `crates/gpu/kernels/rows.h`.
    #[inline]
    pub(crate) fn wide_cell(&self, axis: usize, x: f64) -> u64 {
        nearest_integer(self.quotient(axis, x))
    }

    /// [`Grid::wide_cell`] as a float; the conversion is exact.
    #[inline]
    pub(crate) fn rounded_cell(&self, axis: usize, x: f64) -> f64 {
        (self.quotient(axis, x) + NO_FRACTION) - NO_FRACTION
    }

    /// Where the cells of an axis begin and end, up to rounding.
    pub(crate) fn span(&self, axis: usize) -> [f64; 2] {
        let low = self.origin[axis];
        [low, low + self.cells[axis] as f64 * self.cell_size]
    }

    /// The first and the last cell that can hold points from `low` to `high`; `None` if there are none. Works
    /// for a grid from [`Grid::unbounded`], and for numbers of any size.
    ///
    /// The quotient, and so its nearest integer, ascends with the coordinate: no point in between has a cell
    /// outside of these two.
    pub(crate) fn cells_between(&self, axis: usize, low: f64, high: f64) -> Option<[u64; 2]> {
        let last = (self.cells[axis] - 1) as f64;
        let (low, high) = (self.quotient(axis, low), self.quotient(axis, high));
        (low <= last + 1.0 && high >= -1.0)
            .then(|| [low, high].map(|quotient| nearest_integer(quotient.clamp(0.0, last))))
    }

    #[inline]
    pub(crate) fn quotient(&self, axis: usize, x: f64) -> f64 {
        (x - self.origin[axis]) * self.inverse
    }

    #[cold]
    fn too_wide<T: Real>(
        &self,
        elements: &Elements<'_, T, D>,
        domain_is_set: bool,
        counts: &[f64; D],
        heads: f64,
        max_heads: usize,
    ) -> Error {
        let axis = (0..D).fold(0, |widest, axis| if counts[axis] > counts[widest] { axis } else { widest });
        let positions = || (0..elements.len()).map(|index| elements.anchor(index, axis));
        let n = elements.len() as f64;
        let mean = positions().map(|x| x / n).sum::<f64>();
        let farthest = positions().enumerate().fold((0, mean), |farthest, (index, x)| {
            if (x - mean).abs() > (farthest.1 - mean).abs() { (index, x) } else { farthest }
        });
        Error::DomainTooWide {
            axis,
            width: (counts[axis] - 1.0) * self.cell_size,
            cell_size: self.cell_size,
            heads,
            limit: max_heads,
            stretched_by: (!domain_is_set).then_some(farthest),
        }
    }
}

/// `2^52`: all floats from here on are integers.
const NO_FRACTION: f64 = 4_503_599_627_370_496.0;

/// The nearest integer to `x` for `x` from 0 to `2^51`; unspecified for other values.
#[inline]
pub(crate) fn nearest_integer(x: f64) -> u64 {
    (x + NO_FRACTION).to_bits() & ((1 << 52) - 1)
}

/// Checks that the domain is a finite box and that every element lies in it.
fn check_domain<T: Real, const D: usize>(
    elements: &Elements<'_, T, D>,
    domain: &[[f64; 2]; D],
) -> Result<(), Error> {
    let limit = T::MAX_MAGNITUDE.to_f64();
    for (axis, &[low, high]) in domain.iter().enumerate() {
        if !(low <= high && low >= -limit && high <= limit) {
            return Err(Error::InvalidDomain { axis, domain: [low, high] });
        }
        let bounds = elements.bounds();
        if !elements.is_empty() && (bounds.min[axis] < low || bounds.max[axis] > high) {
            let outside = |&index: &usize| {
                let x = elements.anchor(index, axis);
                x < low || x > high
            };
            let index =
                (0..elements.len()).find(outside).expect("a bound outside the domain belongs to an element");
            let value = elements.anchor(index, axis);
            return Err(Error::OutsideDomain { index, axis, value, domain: [low, high] });
        }
    }
    Ok(())
}

/// The largest edge with which at least `cells` cells cover a box; `None` if the box is a single point. Uses
/// integers, sums and products only, so the result is the same on every machine.
pub(crate) fn edge_for<const D: usize>(bounds: &Bounds<D>, cells: f64) -> Option<f64> {
    let extents: [f64; D] = std::array::from_fn(|axis| bounds.max[axis] - bounds.min[axis]);
    let widest = extents.iter().fold(0.0, |widest, &extent| f64::max(widest, extent));
    // The number of cells if the widest axis has `n`; an axis narrower than a cell has one.
    let enough = |n: u64| {
        let along = extents.iter().map(|extent| f64::max(1.0, extent / widest * n as f64));
        along.product::<f64>() >= cells
    };
    let (mut low, mut high) = (0, MAX_CELLS_PER_AXIS as u64);
    while low + 1 < high {
        let middle = u64::midpoint(low, high);
        if enough(middle) { high = middle } else { low = middle }
    }
    (widest > 0.0).then(|| widest / high as f64)
}

/// The edge of a cell: the largest element plus tolerance, widened. If all elements have size 0, there is
/// about one cell per element.
fn cell_size<T: Real, const D: usize>(mut reach: f64, elements: usize, bounds: &Bounds<D>) -> f64 {
    if reach == 0.0 {
        let widest = (0..D).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f64::max);
        reach = widest / integer_root(elements, D) as f64;
        if reach == 0.0 {
            reach = 1.0;
        }
    }
    reach.max(T::MIN_RESOLVED) * WIDENING
}

/// The smallest integer of at least 1 whose `power`-th power is at least `n`. Uses integers only, so the
/// result is the same on every machine.
fn integer_root(n: usize, power: usize) -> usize {
    let reaches = |root: usize| {
        (0..power).try_fold(1_usize, |product, _| product.checked_mul(root)).is_none_or(|p| p >= n)
    };
    let mut high = 1;
    while !reaches(high) {
        high *= 2;
    }
    let mut low = high / 2;
    while low + 1 < high {
        let middle = usize::midpoint(low, high);
        if reaches(middle) { high = middle } else { low = middle }
    }
    high
}

/// Number of rows: the product of the cells along all axes but the one with the most.
pub(crate) fn rows_of<const D: usize>(cells: &[u64; D]) -> f64 {
    let mut cells = *cells;
    cells.sort_unstable();
    cells[..D - 1].iter().map(|&cells| cells as f64).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNBOUNDED: usize = usize::MAX;

    #[test]
    fn rows_leave_the_longest_axis_out() {
        assert_eq!(rows_of(&[7]), 1.0);
        assert_eq!(rows_of(&[7, 9]), 7.0);
        assert_eq!(rows_of(&[7, 9, 2]), 14.0);
        assert_eq!(rows_of(&[1 << 40, 1 << 40, 1 << 40]), 2_f64.powi(80));
    }

    #[test]
    fn integers_are_the_nearest() {
        for (x, nearest) in
            [(0.0, 0), (0.4, 0), (0.6, 1), (1.0, 1), (12_345.49, 12_345), (2.0_f64.powi(46), 1 << 46)]
        {
            assert_eq!(nearest_integer(x), nearest, "{x}");
        }
    }

    #[test]
    fn roots_are_exact() {
        for (n, power, root) in
            [(0, 2, 1), (1, 3, 1), (8, 3, 2), (9, 3, 3), (100, 2, 10), (101, 2, 11), (7, 1, 7)]
        {
            assert_eq!(integer_root(n, power), root, "{n} {power}");
        }
    }

    /// On a lattice whose spacing is exactly the diameter, neighbours touch and must be at most one cell
    /// apart.
    #[test]
    fn touching_neighbours_on_a_long_lattice_are_adjacent() {
        for spacing in [1.0, 0.1, 1.0 / 3.0, 1e-9, 1e12] {
            let centres: Vec<[f64; 1]> = (0..100_000).map(|k| [f64::from(k) * spacing]).collect();
            let diameter = (1..centres.len()).map(|k| centres[k][0] - centres[k - 1][0]).fold(0.0, f64::max);
            let elements = Elements::points(&centres, diameter).unwrap();
            let grid = Grid::fit(&elements, None, UNBOUNDED).unwrap();
            for k in 1..centres.len() {
                let step = grid.cell(0, centres[k][0]) - grid.cell(0, centres[k - 1][0]);
                assert!(step <= 1, "spacing {spacing}, element {k}: {step} cells apart");
            }
        }
    }

    /// Elements on both sides of a cell face, far from the first element, where the quotients round most.
    /// Without the widening some of them would be two cells apart.
    #[test]
    fn rounding_at_distant_cell_faces_is_covered() {
        let mut steps = [0; 3];
        for k in 1..200 {
            let reach = 0.1 + f64::from(k) / 1000.0;
            let first = -0.7 / f64::from(k);
            let far = [[first], [reach * 2e9]];
            let grid = Grid::fit(&Elements::points(&far, reach).unwrap(), None, UNBOUNDED).unwrap();
            for face in (10..31).map(|exponent| 2.0_f64.powi(exponent)) {
                let mut left = first + face * grid.cell_size();
                for _ in 0..12 {
                    left = left.next_down();
                }
                for _ in 0..24 {
                    let mut right = left + reach;
                    while right - left > reach {
                        right = right.next_down();
                    }
                    steps[(grid.cell(0, right) - grid.cell(0, left)) as usize] += 1;
                    left = left.next_up();
                }
            }
        }
        assert!(steps[1] > 0, "the faces were not met");
        assert_eq!(steps[2], 0, "touching elements two cells apart: {steps:?}");
    }

    #[test]
    fn the_last_element_is_in_the_last_cell() {
        let centres = [[-7.5, 1e6], [0.0, -1e6], [3.25, 4.0]];
        let grid = Grid::fit(&Elements::points(&centres, 0.7).unwrap(), None, UNBOUNDED).unwrap();
        assert_eq!(u64::from(grid.cell(0, 3.25)) + 1, grid.cells()[0]);
        assert_eq!(u64::from(grid.cell(1, 1e6)) + 1, grid.cells()[1]);
        assert_eq!(grid.cell(0, -7.5), 0);
    }

    #[test]
    fn a_wide_domain_names_the_element_that_stretches_it() {
        let centres = [[0.0, 0.0], [1.0, -3e9], [2.0, 1.0], [3.0, 0.5]];
        let error = Grid::fit(&Elements::points(&centres, 1.0).unwrap(), None, 1_000_000).unwrap_err();
        let Error::DomainTooWide { axis: 1, stretched_by, .. } = error else { panic!("{error:?}") };
        assert_eq!(stretched_by, Some((1, -3e9)));
    }

    #[test]
    fn cells_beyond_any_integer_are_refused() {
        let centres = [[0.0], [1e140]];
        let error = Grid::fit(&Elements::points(&centres, 1e-10).unwrap(), None, UNBOUNDED).unwrap_err();
        assert!(matches!(error, Error::DomainTooWide { stretched_by: Some((0 | 1, _)), .. }), "{error:?}");
    }

    #[test]
    fn coincident_points_without_size_share_one_cell() {
        let centres = [[5.0, 5.0]; 3];
        let grid = Grid::fit(&Elements::points(&centres, 0.0).unwrap(), None, UNBOUNDED).unwrap();
        assert_eq!(grid.cells(), [1, 1]);
    }
}
