//! The input of a search of one set against another, for a search on another device.

use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::{Filter, FilterKind};
use crate::grid::{Grid, edge_for};
use crate::real::Real;
use crate::search::rows::input::RowCells;
use crate::search::rows::layout::axes_of;

/// Allowed average number of elements per occupied cell. With fewer, rows are too short for vectors; with
/// more, too much is compared.
const CELL_LOAD: std::ops::RangeInclusive<f64> = 1.5..=16.0;

/// Number of elements per cell if they are spread evenly.
const EVEN_LOAD: f64 = 3.0;

/// Largest number of cell edges that are tried.
const MAX_BUILDS: usize = 6;

/// Finds the grid of an index. `load` sorts the elements by a grid, and returns the average number of
/// elements per occupied cell. The last grid that it gets is the one.
///
/// The size of the elements is the first estimate of the edge, unless an even spread over the whole
/// domain needs a larger one. If cells hold too few or too many elements, edges between the largest that
/// is too small and the smallest that is too large are tried.
pub(super) fn fit<T: Real, const D: usize, E>(
    elements: &Elements<'_, T, D>,
    mut load: impl FnMut(Grid<D>) -> Result<f64, E>,
) -> Result<Grid<D>, E> {
    let bounds = elements.bounds();
    let natural = Grid::unbounded(elements);
    let even = edge_for(&bounds, elements.len() as f64 / EVEN_LOAD);
    let mut edge = even.map_or(natural.cell_size(), |even| even.min(natural.cell_size()));
    edge = edge.max(T::MIN_RESOLVED);
    let (mut too_small, mut too_large) = (0.0, even.unwrap_or(edge).max(edge));
    let mut builds = 0;
    loop {
        let grid = Grid::with_cell_size(bounds.min, bounds.max, edge);
        let load = load(grid)?;
        builds += 1;
        if builds == MAX_BUILDS || CELL_LOAD.contains(&load) || even.is_none() {
            return Ok(grid);
        }
        if load < *CELL_LOAD.start() {
            too_small = edge;
        } else {
            too_large = edge;
        }
        if too_large < 2.0 * too_small || too_large <= T::MIN_RESOLVED {
            return Ok(grid);
        }
        edge = if too_small > 0.0 { (too_small * too_large).sqrt() } else { 0.125 * too_large };
        edge = edge.max(T::MIN_RESOLVED);
    }
}

/// The sizes of the elements of an index, by which those of another set touch them.
#[derive(Clone, Copy, Debug)]
pub(super) struct IndexSizes<T> {
    /// The radius of all; `None` for boxes and spheres with radii.
    pub(super) radius: Option<T>,
    pub(super) tolerance: T,
    pub(super) largest: f64,
    pub(super) magnitude: f64,
}

/// The distances at which elements of two sets touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct CrossReach<T> {
    pub(super) tolerance: T,
    /// Elements that touch are not farther apart along any axis.
    pub(super) reach: T,
    /// The largest squared distance of two that touch, if both sets have one radius.
    pub(super) reach_squared: T,
}

impl<T: Real> IndexSizes<T> {
    pub(super) fn new<const D: usize>(elements: &Elements<'_, T, D>) -> Self {
        let radius = if let Shape::Equal(equal) = elements.shape { Some(equal.radius()) } else { None };
        let (largest, magnitude) = (elements.largest(), elements.magnitude());
        Self { radius, tolerance: elements.tolerance(), largest, magnitude }
    }

    pub(super) fn reach_with<const D: usize>(&self, elements: &Elements<'_, T, D>) -> CrossReach<T> {
        let tolerance =
            if self.tolerance > elements.tolerance() { self.tolerance } else { elements.tolerance() };
        let reach = elements.reach_to(self.largest, self.magnitude, tolerance);
        let reach_squared = match (elements.shape, self.radius) {
            (Shape::Equal(equal), Some(radius)) => {
                let reach = (equal.radius() + radius) + tolerance;
                reach * reach
            }
            _ => T::ZERO,
        };
        CrossReach { tolerance, reach: T::at_least(reach.max(T::MIN_RESOLVED)), reach_squared }
    }
}

/// The numbers of an [`Index`](crate::Index) over spheres or points: an index on another device that sorts
/// and compares by them finds the couples of [`Index::couples_with`](crate::Index::couples_with) in the same
/// order, which [`CrossInput`] defines.
#[derive(Clone, Debug)]
pub struct IndexInput<T, const D: usize> {
    grid: Grid<D>,
    axes: [usize; D],
    sizes: IndexSizes<T>,
    filter: Option<FilterKind>,
}

/// The numbers of a search of elements against an index.
///
/// # Order
/// Both sets are in the order of [`RowCells`], each with its own cells, and with the axes of the index. The
/// partners of an element are in the order of the index, whatever their rows.
#[derive(Clone, Copy, Debug)]
pub struct CrossInput<'a, T, const D: usize> {
    /// The centres.
    pub points: &'a [[T; D]],
    /// The radii; empty if there is only one.
    pub radii: &'a [T],
    /// The filter, of the kind of the index, if there is one.
    pub filter: Option<Filter<'a>>,
    /// The cells of these elements.
    pub cells: RowCells<D>,
    /// The cells of the index.
    pub index: RowCells<D>,
    /// The one radius of these elements, and that of the index, if they have only one.
    pub radius: [Option<T>; 2],
    /// Elements that touch are not farther apart along any axis.
    pub reach: T,
    /// The largest squared distance of two that touch, if both sets have one radius.
    pub reach_squared: T,
    /// Distance up to which spheres with radii touch.
    pub tolerance: T,
}

impl<T: Real, const D: usize> IndexInput<T, D> {
    /// The numbers of an index over `elements`; `None` for boxes and no elements.
    ///
    /// `load` gets cells, the points, and the radii, which are empty if there is only one. It sorts the
    /// elements by the cells, and returns the average number of elements per occupied cell: it counts a cell
    /// wherever an element is in another row, or in another cell along its row, than the one before it. The
    /// elements stay as `load` has sorted them last.
    ///
    /// # Errors
    /// The errors of `load`, and [`Error::OutOfMemory`].
    pub fn new<E: From<Error>>(
        elements: &Elements<'_, T, D>,
        mut load: impl FnMut(RowCells<D>, &[[T; D]], &[T]) -> Result<f64, E>,
    ) -> Result<Option<Self>, E> {
        let (points, radii): (_, &[T]) = match elements.shape {
            _ if elements.is_empty() => return Ok(None),
            Shape::Equal(equal) => (equal.points(), &[]),
            Shape::Spheres(spheres) => (spheres.points(), spheres.radii()),
            Shape::Boxes(_) => return Ok(None),
        };
        let filter = elements.filter().map(|filter| filter.kind()).transpose()?;
        let grid = fit(elements, |grid| load(RowCells::new(&grid, axes_of(&grid)), points, radii))?;
        Ok(Some(Self { grid, axes: axes_of(&grid), sizes: IndexSizes::new(elements), filter }))
    }

    /// The numbers of a search of `elements` against the index; `None` if there are none.
    ///
    /// # Errors
    /// [`Error::UnlikeShapes`] for boxes, and [`Error::UnlikeFilters`].
    pub fn with<'a>(&self, elements: &Elements<'a, T, D>) -> Result<Option<CrossInput<'a, T, D>>, Error> {
        let (points, radii, radius): (_, &[T], _) = match elements.shape {
            Shape::Equal(equal) => (equal.points(), &[], Some(equal.radius())),
            Shape::Spheres(spheres) => (spheres.points(), spheres.radii(), None),
            Shape::Boxes(_) => return Err(Error::UnlikeShapes),
        };
        if elements.is_empty() {
            return Ok(None);
        }
        let filter = elements.filter();
        match (&filter, &self.filter) {
            (None, None) => {}
            (Some(theirs), Some(ours)) if ours.is_of(theirs) => {}
            _ => return Err(Error::UnlikeFilters),
        }
        let CrossReach { tolerance, reach, reach_squared } = self.sizes.reach_with(elements);
        let cells = RowCells::new(&self.grid.over(elements.bounds()), self.axes);
        let index = RowCells::new(&self.grid, self.axes);
        let radius = [radius, self.sizes.radius];
        Ok(Some(CrossInput { points, radii, filter, cells, index, radius, reach, reach_squared, tolerance }))
    }
}
