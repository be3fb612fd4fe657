//! NBS on contiguous memory: sorted rows, a moving window, and vectors.

mod axis;
mod block_sort;
mod cursor;
pub(crate) mod input;
mod keys;
pub(crate) mod layout;
pub(crate) mod reach;
pub(crate) mod scan;
mod scatter;
mod sparse;

use crate::compiled::compiled;
use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::Labels;
use crate::grid::Grid;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::Search;
use crate::simd::{Available, Simd, has_vectors};

use layout::Layout;
use scan::{PART, Scan, Scanner, Scans, Sink};

/// The default engine: the decomposition and the contact mask of Munjiza-NBS, on sorted rows instead of
/// lists.
///
/// A *row* is a line of cells along the axis with the most cells. Cells are as wide as the largest element,
/// and wider where rows would hold few elements. Elements are sorted by row and, inside a row, by coordinate
/// along it. The lists of NBS become runs of contiguous memory, and rows without elements do not exist. A row
/// is compared with itself and with the half mask of neighbour rows (1 in 2D, 4 in 3D, `(3^(D-1) - 1)/2`).
/// Because rows are sorted, an element's candidates in a neighbour row are one window, whose lower end only
/// moves forward. Coordinates are tested a vector at a time, with AVX-512, AVX2 or NEON if the processor has
/// them. Where it is faster, four elements are compared at once in 32 bits first. All instruction sets give
/// the same couples in the same order, by the comparison of [`Elements`].
/// ```text
///   row below   . . [ x x x x x ] . . .      |x_j - x_i| <= reach
///   own row     . . . . i [ x x x ] . .      j > i
/// ```
///
/// # Order
/// Rows ascend by cell on the other axes, and elements ascend along their row. The partners of an element are
/// first those in its own row, then those in the rows of the mask, each ascending. If most boxes are much
/// shorter than the longest one, the partners of a box are instead those that begin later along the row, in
/// all rows around it. The order is a function of the input alone.
///
/// # Cost
/// Time proportional to N for similar sizes: some tens of nanoseconds per element and core. Memory per
/// element: `D` coordinates; the radius, if radii differ; 4 bytes of id; 2 bytes of bin; at most 8 bytes of
/// row starts. That is 30 to 38 bytes in 3D and `f64`, 8 more with radii, and 4 to 12 more with a
/// [`Filter`](crate::Filter). In addition, each thread sorts one block of rows at a time in its own memory:
/// some hundred kilobytes, or 50 bytes per element of the longest row if that is more. Nothing grows with the
/// domain.
///
/// # Source
/// The decomposition is that of A. Munjiza, K.R.F. Andrews, Int. J. Numer. Meth. Engng 43 (1998) 131-149.
/// Rows, windows and vectors are our own.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, Rows, Search};
///
/// let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1e12]];
/// assert_eq!(Rows::new().count(&Elements::points(&centres, 1.0)?)?, 1);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rows<T, const D: usize> {
    layout: Layout<T, D>,
    /// Couples of each part before they are visited or appended to a list.
    parts: Vec<Vec<Couple>>,
    simd: Available,
    pool: Pool,
}

impl<T: Real, const D: usize> Default for Rows<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> Rows<T, D> {
    /// A search that holds no memory yet, with the fastest instructions of this processor.
    pub fn new() -> Self {
        Self { layout: Layout::new(), parts: Vec::new(), simd: Available::best(), pool: Pool::default() }
    }

    /// The same with other vector instructions; the couples and their order are the same.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks them.
    pub fn with_simd(mut self, simd: Simd) -> Result<Self, Error> {
        self.simd = Available::new(simd)?;
        Ok(self)
    }

    /// The same on `threads` threads. 0 is one thread per processor; 1 is the default and uses no thread
    /// pool. The couples and their order are the same for any number. Clones share their threads.
    ///
    /// # Errors
    /// [`Error::NoThreads`] if the threads cannot be started, if there are more than 1024, or if the crate
    /// was built without its feature `rayon`.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?;
        Ok(self)
    }

    /// The thread pool, which another engine may share.
    pub(crate) fn pool(&self) -> Pool {
        self.pool.clone()
    }

    pub(crate) fn with_pool(mut self, pool: Pool) -> Self {
        self.pool = pool;
        self
    }

    /// Bytes that the engine holds now.
    pub fn bytes(&self) -> usize {
        self.layout.bytes() + self.parts.iter().map(Vec::capacity).sum::<usize>() * size_of::<Couple>()
    }

    /// Upper bound on [`Rows::bytes`] after a count of `elements`.
    pub(crate) fn expected_bytes(&self, elements: &Elements<'_, T, D>) -> usize {
        let n = elements.len();
        if n == 0 {
            return 0;
        }
        let floats = elements.shape.floats();
        let labels = elements.filter().map_or(0, |filter| Labels::numbers_of(&filter));
        Layout::<T, D>::expected_bytes(n, floats, labels, &self.plan(elements), &self.pool)
    }

    /// Number of threads that a search uses.
    pub(crate) fn threads(&self) -> usize {
        self.pool.threads()
    }

    /// The vector instructions that a search uses.
    pub(crate) fn simd(&self) -> Simd {
        if has_vectors(D) { self.simd.level() } else { Simd::Portable }
    }

    /// The grid that a search over `elements` would use.
    pub fn plan(&self, elements: &Elements<'_, T, D>) -> Grid<D> {
        sparse::grid(elements)
    }

    /// Folds the couples on all threads without storing them: `visit` gets every couple once, with the state
    /// of its part.
    ///
    /// The elements are cut into parts. Each part begins with a state from `start`, and the states are
    /// returned in the order of the parts. The parts do not depend on the number of threads, so neither does
    /// a sum over the states.
    ///
    /// # Errors
    /// As [`Search::for_each`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Rows};
    ///
    /// let centres: Vec<[f64; 2]> = (0..10_000).map(|k| [f64::from(k), 0.0]).collect();
    /// let elements = Elements::points(&centres, 1.0)?;
    /// let sums = Rows::new().with_threads(2)?.fold(&elements, || 0.0, |sum, couple| {
    ///     *sum += centres[couple.j as usize][0] - centres[couple.i as usize][0];
    /// })?;
    /// assert_eq!(sums.into_iter().sum::<f64>(), 9_999.0);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    #[doc(alias = "parallel visitor")]
    pub fn fold<S: Send>(
        &mut self,
        elements: &Elements<'_, T, D>,
        start: impl Fn() -> S,
        visit: impl Fn(&mut S, Couple) + Sync,
    ) -> Result<Vec<S>, Error> {
        self.fold_blocks(elements, start, |state, block| {
            for &couple in block {
                visit(state, couple);
            }
        })
    }
}

compiled!(fn search = Rows<T, D>, Rows<f64, 2>, Rows<f64, 3>: scan_all(Sink<'_>));

impl<T: Real, const D: usize> Scanner<T, D> for Rows<T, D> {
    fn search(&mut self, elements: &Elements<'_, T, D>, sink: Sink<'_>) -> Result<(), Error> {
        search(self, elements, sink)
    }

    fn with_scans(
        &mut self,
        elements: &Elements<'_, T, D>,
        search: impl FnOnce(Scans<'_, T, D>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if elements.is_empty() {
            return Ok(());
        }
        let grid = self.plan(elements);
        let Self { layout, parts, simd, pool } = self;
        let simd = *simd;
        match elements.shape {
            Shape::Equal(equal) => layout.build(equal.points(), &[], grid, pool),
            Shape::Spheres(spheres) => layout.build(spheres.points(), spheres.radii(), grid, pool),
            Shape::Boxes(boxes) => layout.build(boxes.points(), &[], grid, pool),
        }?;
        if let Shape::Boxes(boxes) = elements.shape {
            layout.set_far(boxes.far_points(), elements.tolerance(), pool)?;
        }
        let filter = elements.filter();
        layout.label(filter, pool)?;
        let scan = Scan {
            layout,
            against: None,
            arrays: [layout.arrays(filter); 2],
            reach: elements.rows_reach(),
            reach_squared: if let Shape::Equal(equal) = elements.shape {
                equal.reach_squared()
            } else {
                T::ZERO
            },
            tolerance: elements.tolerance(),
            largest: 0.5 * elements.largest(),
            one_numbering: true,
            part: PART,
            search_row: &|task, out| T::search::<D>(simd, task, out),
        };
        search(Scans { each: &[scan], pool, parts })
    }
}

impl<T: Real, const D: usize> Search<T, D> for Rows<T, D> {
    fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(Couple),
    ) -> Result<(), Error> {
        self.for_each_block(elements, |block| block.iter().copied().for_each(&mut visit))
    }

    fn couples(&mut self, elements: &Elements<'_, T, D>, couples: &mut Vec<Couple>) -> Result<(), Error> {
        couples.clear();
        self.search(elements, Sink::List(couples)).inspect_err(|_| couples.clear())
    }

    fn count(&mut self, elements: &Elements<'_, T, D>) -> Result<u64, Error> {
        let mut count = 0;
        self.search(elements, Sink::Count(&mut count))?;
        Ok(count)
    }
}
