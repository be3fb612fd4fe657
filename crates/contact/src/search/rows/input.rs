//! The input of a search over sorted rows, for a search on another device.

use crate::elements::{Elements, Shape};
use crate::filter::Filter;
use crate::grid::Grid;
use crate::real::Real;
use crate::search::rows::Rows;
use crate::search::rows::layout::axes_of;

/// The cells by which elements are sorted into rows.
///
/// # Order
/// The cell of a coordinate `x` along an axis is the nearest integer to `(x - origin) * inverse`, in `f64`,
/// ties to even. Elements ascend by their cells along `axes[D - 1]`, ..., `axes[1]`, then by their coordinate
/// along `axes[0]`, then by their number. A row holds the elements of equal cells along all axes but
/// `axes[0]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowCells<const D: usize> {
    /// Where the cells begin.
    pub origin: [f64; D],
    /// 1 over the edge of a cell.
    pub inverse: f64,
    /// Number of cells along each axis.
    pub cells: [u64; D],
    /// The axes, that along the rows first: by their number of cells, largest first.
    pub axes: [usize; D],
}

impl<const D: usize> RowCells<D> {
    pub(crate) fn new(grid: &Grid<D>, axes: [usize; D]) -> Self {
        Self {
            origin: std::array::from_fn(|axis| grid.span(axis)[0]),
            inverse: grid.inverse(),
            cells: grid.cells(),
            axes,
        }
    }
}

/// The numbers of a search by [`Rows`] over spheres or points: a search on another device that sorts and
/// compares by them finds the same couples in the same order.
///
/// # Order
/// Elements are in the order of [`RowCells`]. The partners of an element are first those behind it in its
/// row, then those in the rows whose cells differ by the offsets before zero, in lexicographic order, of -1, 0
/// and 1; in each row they ascend. Elements touch as [`Elements`] documents. A filter takes couples out of
/// this order and changes nothing else.
///
/// In a periodic box there are two searches, and
/// [`PeriodicSearch::for_each_by`](crate::PeriodicSearch::for_each_by) documents their order.
#[derive(Clone, Copy, Debug)]
pub struct RowsInput<'a, T, const D: usize> {
    /// The centres.
    pub points: &'a [[T; D]],
    /// The radii; empty if there is only one.
    pub radii: &'a [T],
    /// The filter, if there is one.
    pub filter: Option<Filter<'a>>,
    /// The cells.
    pub cells: RowCells<D>,
    /// Elements that touch are not farther apart along any axis.
    pub reach: T,
    /// The largest squared distance of two that touch, for one radius.
    pub reach_squared: T,
    /// Distance up to which spheres with radii touch.
    pub tolerance: T,
}

impl<T: Real, const D: usize> Rows<T, D> {
    /// The numbers of a search over `elements`; `None` for boxes and no elements.
    ///
    /// # Cost
    /// A look at a sample of the elements.
    pub fn input<'a>(&self, elements: &Elements<'a, T, D>) -> Option<RowsInput<'a, T, D>> {
        if elements.is_empty() {
            return None;
        }
        let (points, radii, reach_squared) = match elements.shape {
            Shape::Equal(equal) => (equal.points(), &[][..], equal.reach_squared()),
            Shape::Spheres(spheres) => (spheres.points(), spheres.radii(), T::ZERO),
            Shape::Boxes(_) => return None,
        };
        let grid = self.plan(elements);
        Some(RowsInput {
            points,
            radii,
            filter: elements.filter(),
            cells: RowCells::new(&grid, axes_of(&grid)),
            reach: elements.rows_reach(),
            reach_squared,
            tolerance: elements.tolerance(),
        })
    }
}
