//! Munjiza-NBS, as published: singly connected lists and the contact mask, in any number of dimensions.

use crate::compiled::compiled;
use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::geometry::{Filtered, Geometry};
use crate::grid::Grid;
use crate::lists::{Lists, MAX_LISTED, NONE};
use crate::mask::{CONTACT_MASK, Set};
use crate::real::Real;
use crate::search::Search;
use crate::stop::Stop;

/// Munjiza-NBS ("no binary search"): all couples among elements of similar size, in time proportional to N.
///
/// Each element belongs to the cell that holds its centre. All elements are put onto lists along the last
/// axis. Each list that is not empty is in turn put onto lists along the next axis, together with its
/// neighbours below, and so on down to cells. Cells are compared by the contact mask ([`CONTACT_MASK`]). In
/// 2D (`o` the central cell):
/// ```text
/// .  .  .
/// x  o  .
/// x  x  x
/// ```
/// Lists are emptied by walking the elements again. After the heads have been written once, no loop runs over
/// cells, so the time depends neither on the size of the domain nor on the packing density.
///
/// # Reading this beside the book
/// One recursion (p. 128) covers the 8 steps of the 2D procedure (pp. 110-111) and the 13 steps of the 3D one
/// (pp. 126-128). The source file marks each step as follows:
///
/// | this file | 2D steps | 3D steps |
/// |---|---|---|
/// | last axis: all elements onto its lists | 1 | 1 |
/// | walk the central list; a new list is marked old and becomes central | 2, 5 | 2, 5, 8 |
/// | central list onto the lists of the next axis | 3 | 3, 6 |
/// | lists of the mask onto the lists of the next axis | 4 | 4, 7 |
/// | check by the mask | 5 | 8 |
/// | remove the lists of the central list | 6 | 9, 11 |
/// | remove the lists of the mask | 7 | 10, 12 |
/// | last axis: remove its lists | 8 | 13 |
///
/// # Order
/// Cells come in the order in which the walk over the elements first reaches their layer, row and cell. The
/// order is a function of the input alone.
///
/// # Cost
/// Time proportional to N at any packing density while sizes are similar. The cell is as large as the largest
/// element, and n small elements in one cell cost n² tests. Memory: exactly [`Nbs::integers`] integers of 4
/// bytes.
///
/// # Source
/// A. Munjiza, K.R.F. Andrews, "NBS contact detection algorithm for bodies of similar size", Int. J. Numer.
/// Meth. Engng 43 (1998) 131-149; A. Munjiza, "The Combined Finite-Discrete Element Method", Wiley 2004, pp.
/// 102-128. Departures: elements and cells are numbered from 0; empty is [`NONE`], not -1; the cell is wider
/// than the largest element by a rounding step (see [`Grid`]); boxes are mapped by their minimum corner,
/// because its differences round less than those of centres.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, Nbs, Search};
///
/// let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0]];
/// let elements = Elements::points(&centres, 1.0)?;
/// let mut nbs = Nbs::new();
/// assert_eq!(nbs.count(&elements)?, 1);
///
/// // (3.80): M = 3N + n_z + 2 n_x + 2 n_y
/// let [nx, ny, nz] = nbs.grid().unwrap().cells().map(|n| n as usize);
/// assert_eq!(nbs.integers(), 3 * 3 + nz + 2 * nx + 2 * ny);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Nbs<const D: usize> {
    /// The lists of each axis: `lists[0]` is A and X, `lists[1]` is B and Y, `lists[2]` is C and Z.
    lists: [Lists; D],
    grid: Option<Grid<D>>,
    domain: Option<[[f64; 2]; D]>,
    max_heads: usize,
    /// Whether the last search was stopped or its visitor panicked, so that the lists are not empty.
    interrupted: bool,
    stop: Stop,
}

/// Default limit on the number of list heads, unless [`Nbs::with_max_heads`] sets another: 512 MiB.
pub const DEFAULT_MAX_HEADS: usize = 1 << 27;

impl<const D: usize> Default for Nbs<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const D: usize> Nbs<D> {
    /// A search that holds no memory yet.
    pub fn new() -> Self {
        Self {
            lists: std::array::from_fn(|_| Lists::default()),
            grid: None,
            domain: None,
            max_heads: DEFAULT_MAX_HEADS,
            interrupted: false,
            stop: Stop::default(),
        }
    }

    /// The same with another limit on the number of list heads; each takes 4 bytes.
    #[must_use]
    pub fn with_max_heads(mut self, max_heads: usize) -> Self {
        self.max_heads = max_heads;
        self
    }

    /// The same with a fixed domain, `[min, max]` per axis, in which all centres (minimum corners) must lie.
    ///
    /// Without a fixed domain, each call uses the bounding box of the elements.
    #[must_use]
    pub fn with_domain(mut self, domain: [[f64; 2]; D]) -> Self {
        self.domain = Some(domain);
        self
    }

    /// Returns the search with a signal that stops it.
    pub(crate) fn stopped_by(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// The grid of the latest search; `None` before the first.
    pub fn grid(&self) -> Option<Grid<D>> {
        self.grid
    }

    /// Number of integers that the engine holds: list heads and next numbers. It holds no other memory.
    ///
    /// `M = n_y + 2 n_x + 2N` in 2D (3.65), `M = 3N + n_z + 2 n_x + 2 n_y` in 3D (3.80), and
    /// `D N + n_last + 2 (sum of the other n)` in D dimensions.
    pub fn integers(&self) -> usize {
        self.lists.iter().map(Lists::integers).sum()
    }

    /// The number [`Nbs::integers`] after a search over `elements` elements.
    pub(crate) fn integers_for(elements: usize, grid: &Grid<D>) -> usize {
        let heads = |(axis, cells): (usize, u64)| if axis + 1 == D { cells } else { 2 * cells } as usize;
        D * elements + grid.cells().into_iter().enumerate().map(heads).sum::<usize>()
    }

    /// The grid that a search over `elements` would use.
    ///
    /// # Errors
    /// The errors of [`Search::for_each`] that can be found without allocating.
    pub fn plan<T: Real>(&self, elements: &Elements<'_, T, D>) -> Result<Grid<D>, Error> {
        if elements.len() > MAX_LISTED {
            return Err(Error::TooManyElements { elements: elements.len(), limit: MAX_LISTED });
        }
        Grid::fit(elements, self.domain, self.max_heads)
    }

    /// Searches as [`Search::for_each`], and shows `observer` the lists, the central cells and the candidates
    /// as they occur.
    ///
    /// The figures of the book are printed in this way. An observer that does nothing costs nothing.
    ///
    /// # Errors
    /// As [`Search::for_each`].
    pub fn observe<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        observer: &mut impl Observer<D>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        self.all(elements, observer, &mut visit)
    }

    /// [`Nbs::observe`] without an observer.
    fn unobserved<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<(), Error> {
        self.all(elements, &mut Unobserved, visit)
    }

    fn all<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        observer: &mut impl Observer<D>,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<(), Error> {
        match elements.shape {
            Shape::Equal(equal) => self.filtered(elements, equal, observer, visit),
            Shape::Spheres(spheres) => self.filtered(elements, spheres, observer, visit),
            Shape::Boxes(boxes) => self.filtered(elements, boxes, observer, visit),
        }
    }

    fn filtered<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        geometry: impl Geometry,
        observer: &mut impl Observer<D>,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<(), Error> {
        match elements.filter() {
            None => self.search(elements, geometry, observer, visit),
            Some(filter) => self.search(elements, Filtered { geometry, filter }, observer, visit),
        }
    }

    fn search<T: Real>(
        &mut self,
        elements: &Elements<'_, T, D>,
        geometry: impl Geometry,
        observer: &mut impl Observer<D>,
        visit: &mut dyn FnMut(Couple),
    ) -> Result<(), Error> {
        let grid = self.plan(elements)?;
        for (axis, (lists, cells)) in self.lists.iter_mut().zip(grid.cells()).enumerate() {
            let cells = u32::try_from(cells).expect("the bound on heads keeps cells below u32");
            let neighbours = if axis + 1 == D { 0 } else { cells };
            lists.prepare(elements.len(), [cells, neighbours], self.interrupted)?;
        }
        self.grid = Some(grid);

        self.interrupted = true;
        let all = if elements.is_empty() { NONE } else { 0 };
        let Self { lists, stop, .. } = self;
        NbsPass { geometry, grid, lists, cell: [0; D], stop, observer, visit }.spread(
            D - 1,
            all,
            [NONE; 4],
        )?;
        self.interrupted = false;
        debug_assert!(self.lists.iter().all(Lists::all_empty), "a search empties the lists that it fills");
        Ok(())
    }
}

impl<T: Real, const D: usize> Search<T, D> for Nbs<D> {
    fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        search(self, elements, &mut visit)
    }
}

compiled!(fn search = Nbs<D>, Nbs<2>, Nbs<3>: unobserved(&mut dyn FnMut(Couple)));

/// Observes a search, for teaching and for the golden tests. Every method does nothing by default.
pub trait Observer<const D: usize> {
    /// The lists along `axis` are complete and all new, for the central list of the axes above:
    /// `cell[axis + 1..]`.
    fn lists(&mut self, axis: usize, cell: &[u32; D], lists: &Lists) {
        let _ = (axis, cell, lists);
    }

    /// `cell` has become the central cell.
    fn central_cell(&mut self, cell: &[u32; D]) {
        let _ = cell;
    }

    /// The two elements are in the same cell or in adjacent cells; the exact test follows.
    fn candidate(&mut self, couple: Couple) {
        let _ = couple;
    }
}

struct Unobserved;

impl<const D: usize> Observer<D> for Unobserved {}

/// The state of one detection in progress.
struct NbsPass<'a, G, O, const D: usize> {
    geometry: G,
    grid: Grid<D>,
    lists: &'a mut [Lists; D],
    /// The central list of each axis visited so far.
    cell: [u32; D],
    stop: &'a Stop,
    observer: &'a mut O,
    /// A trait object, so that the code is compiled once and not for every visitor.
    visit: &'a mut dyn FnMut(Couple),
}

impl<G: Geometry, O: Observer<D>, const D: usize> NbsPass<'_, G, O, D> {
    /// Spreads a central list of the axis above over the lists of `axis`, with its neighbours, and visits
    /// each.
    ///
    /// `central` and `neighbours` are first elements of lists of the axis above. Above the last axis there is
    /// a single list, that of all elements.
    fn spread(&mut self, axis: usize, central: u32, neighbours: [u32; 4]) -> Result<(), Error> {
        // 2D steps 1 and 3; 3D steps 1, 3 and 6: integerise the coordinate, push on the list.
        self.walk(axis, central, |pass, element, cell| {
            pass.lists[axis].push(Set::Central, cell, element);
            Ok(())
        })?;
        // 2D step 4; 3D steps 4 and 7: the same for the neighbours according to the contact mask.
        for first in neighbours {
            self.walk(axis, first, |pass, element, cell| {
                pass.lists[axis].push(Set::Neighbours, cell, element);
                Ok(())
            })?;
        }
        self.observer.lists(axis, &self.cell, &self.lists[axis]);

        // 2D steps 2 and 5; 3D steps 2, 5 and 8: a list that is new is marked old and becomes the central
        // one.
        self.walk(axis, central, |pass, _, cell| {
            if let Some(first) = pass.lists[axis].take_new(cell) {
                let neighbours = CONTACT_MASK
                    .map(|(set, offset)| pass.lists[axis].first(set, cell.wrapping_add_signed(offset)));
                pass.cell[axis] = cell;
                if axis == 0 {
                    pass.check(first, neighbours)?;
                } else {
                    pass.spread(axis - 1, first, neighbours)?;
                }
            }
            Ok(())
        })?;

        // 2D steps 6 and 8; 3D steps 9, 11 and 13: remove the lists, walking elements and never cells.
        self.walk(axis, central, |pass, _, cell| {
            pass.lists[axis].remove(Set::Central, cell);
            Ok(())
        })?;
        // 2D step 7; 3D steps 10 and 12.
        for first in neighbours {
            self.walk(axis, first, |pass, _, cell| {
                pass.lists[axis].remove(Set::Neighbours, cell);
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Walks a list of the axis above `axis` and calls `act` with each element and its cell on `axis`.
    #[inline]
    fn walk(
        &mut self,
        axis: usize,
        first: u32,
        mut act: impl FnMut(&mut Self, u32, u32) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut element = first;
        while element != NONE {
            let cell = self.grid.cell(axis, self.geometry.anchor(element as usize, axis));
            act(self, element, cell)?;
            element = self.after(axis + 1, element);
        }
        Ok(())
    }

    /// The next element on a list of `axis`; above the last axis, the next element in ascending order.
    #[inline]
    fn after(&self, axis: usize, element: u32) -> u32 {
        if axis < D {
            self.lists[axis].after(element)
        } else if (element as usize) + 1 < self.geometry.len() {
            element + 1
        } else {
            NONE
        }
    }

    /// 2D step 5; 3D step 8: compares the central cell with itself and with the cells of the contact mask.
    fn check(&mut self, central: u32, neighbours: [u32; 4]) -> Result<(), Error> {
        self.observer.central_cell(&self.cell);
        let mut element = central;
        while element != NONE {
            self.stop.go_on()?;
            let after = self.lists[0].after(element);
            self.check_list(element, after);
            for first in neighbours {
                self.check_list(element, first);
            }
            element = after;
        }
        Ok(())
    }

    /// Compares one element with the rest of a list.
    #[inline]
    fn check_list(&mut self, element: u32, first: u32) {
        let mut other = first;
        while other != NONE {
            let couple = Couple::new(element, other);
            self.observer.candidate(couple);
            if self.geometry.touch(element as usize, other as usize) {
                (self.visit)(couple);
            }
            other = self.lists[0].after(other);
        }
    }
}
