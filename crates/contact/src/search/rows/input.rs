//! The input of a search over sorted rows, for a search on another device.

use crate::elements::{Elements, Shape};
use crate::real::Real;
use crate::search::rows::Rows;
use crate::search::rows::layout::axes_of;

/// The numbers of a search by [`Rows`] over spheres or points: a search on another device that sorts and
/// compares by them finds the same couples in the same order.
///
/// # Order
/// The cell of a coordinate `x` along an axis is the nearest integer to `(x - origin) * inverse`, ties to
/// even. Elements ascend by their cells along `axes[D - 1]`, ..., `axes[1]`, then by their coordinate along
/// `axes[0]`, then by their number. The partners of an element are first those behind it in its row, then
/// those in the rows whose cells differ by the offsets before zero, in lexicographic order, of -1, 0 and 1;
/// in each row they ascend. Elements touch as [`Elements`] documents.
#[derive(Clone, Copy, Debug)]
pub struct RowsInput<'a, T, const D: usize> {
    /// The centres.
    pub points: &'a [[T; D]],
    /// The radii; empty if there is only one.
    pub radii: &'a [T],
    /// Where the cells begin.
    pub origin: [f64; D],
    /// 1 over the edge of a cell.
    pub inverse: f64,
    /// Number of cells along each axis.
    pub cells: [u64; D],
    /// The axes by their number of cells, largest first.
    pub axes: [usize; D],
    /// Elements that touch are not farther apart along any axis.
    pub reach: T,
    /// The largest squared distance of two that touch, for one radius.
    pub reach_squared: T,
    /// Distance up to which spheres with radii touch.
    pub tolerance: T,
}

impl<T: Real, const D: usize> Rows<T, D> {
    /// The numbers of a search over `elements`; `None` for boxes, filters and no elements.
    ///
    /// # Cost
    /// A look at a sample of the elements.
    pub fn input<'a>(&self, elements: &Elements<'a, T, D>) -> Option<RowsInput<'a, T, D>> {
        if elements.is_empty() || elements.filter().is_some() {
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
            origin: std::array::from_fn(|axis| grid.span(axis)[0]),
            inverse: grid.inverse(),
            cells: grid.cells(),
            axes: axes_of(&grid),
            reach: elements.rows_reach(),
            reach_squared,
            tolerance: elements.tolerance(),
        })
    }
}
