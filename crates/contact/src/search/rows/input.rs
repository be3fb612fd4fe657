//! The input of a search over sorted rows, for a search on another device.

use crate::elements::{Elements, Shape, check_count};
use crate::error::{Error, check_lengths};
use crate::filter::Filter;
use crate::grid::Grid;
use crate::real::Real;
use crate::search::rows::Rows;
use crate::search::rows::layout::axes_of;
use crate::search::rows::sparse;

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
/// row, then those in the rows whose cells differ by the offsets before zero, in lexicographic order, of
/// -1, 0 and 1; in each row they ascend. Elements touch as [`Elements`] documents. A filter takes couples out
/// of this order and changes nothing else.
///
/// In a periodic box there are two searches, and
/// [`PeriodicSearch::for_each_by`](crate::PeriodicSearch::for_each_by) documents their order.
#[derive(Clone, Copy, Debug)]
pub struct RowsInput<'a, T, const D: usize> {
    /// The centres; empty if they are elsewhere.
    pub points: &'a [[T; D]],
    /// The radii; empty if there is only one, or if they are elsewhere.
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

/// Spheres or points that are elsewhere, such as on another device: the extremes of their numbers, which
/// must be those that [`Elements`] takes.
#[derive(Clone, Copy, Debug)]
pub struct RowsExtremes<T, const D: usize> {
    /// Number of elements.
    pub elements: usize,
    /// The smallest coordinates of the centres, axis by axis.
    pub min: [T; D],
    /// The largest coordinates.
    pub max: [T; D],
    /// The largest radius.
    pub radius: T,
    /// The gap that still counts as contact.
    pub tolerance: T,
}

impl<T: Real, const D: usize> Rows<T, D> {
    /// The size of the sample that [`Rows::input_elsewhere`] looks at, and the difference of the numbers of
    /// its elements, of which 0 is the first. Few elements have none.
    pub fn sample(elements: usize) -> [usize; 2] {
        <[usize; 2]>::from(sparse::sample_of(elements))
    }

    /// The numbers of a search over elements that are elsewhere: those of [`Rows::input`], without points,
    /// radii and filter. `sample` has the centres of their [sample](Rows::sample); `reach_squared` is that
    /// of two of the largest radius.
    ///
    /// # Errors
    /// [`Error::TooManyElements`], [`Error::InvalidRadius`], [`Error::InvalidTolerance`], and
    /// [`Error::LengthMismatch`] for a sample of another size.
    pub fn input_elsewhere(
        extremes: &RowsExtremes<T, D>,
        sample: &[[T; D]],
    ) -> Result<RowsInput<'static, T, D>, Error> {
        let n = extremes.elements;
        check_count(n)?;
        check_lengths("points of the sample", sparse::sample_of(n).0, sample.len())?;
        // Two elements with the extremes of all.
        let corners = [extremes.min, extremes.max];
        let largest = Elements::spheres(&corners, extremes.radius)?.with_tolerance(extremes.tolerance)?;
        let grid = Grid::unbounded_of::<T>(largest.reach(), n, largest.bounds());
        let grid = sparse::grid_of(grid, n, |k, axis| sample[k][axis].to_f64());
        Ok(RowsInput {
            points: &[],
            radii: &[],
            filter: None,
            cells: RowCells::new(&grid, axes_of(&grid)),
            reach: largest.rows_reach(),
            reach_squared: if let Shape::Equal(equal) = largest.shape {
                equal.reach_squared()
            } else {
                T::ZERO
            },
            tolerance: extremes.tolerance,
        })
    }

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
