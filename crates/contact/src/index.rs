//! Elements that are sorted once and searched many times: against another set, around points, for nearest
//! neighbours.

pub(crate) mod input;
mod nearest;
mod part;
mod rows;
mod sort;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::couple::{Couple, CrossCouple};
use crate::csr::Csr;
use crate::elements::{Bounds, Elements, Shape};
use crate::error::Error;
use crate::filter::{GroupMatrix, Labels};
use crate::memory::{grow, reserve, resize};
use crate::pool::Pool;
use crate::real::Real;
use crate::search::rows::layout::{Layout, PADDING};
use crate::search::rows::scan::{PART, Scan, Scans, Sink};
use crate::simd::task::Arrays;
use crate::simd::{Available, Simd};
use crate::stop::Stop;

use input::{CrossReach, IndexSizes};
use part::PointsPart;

/// Elements that are sorted once and searched many times: for example a fixed boundary that moving elements
/// may touch, or points whose neighbours are searched for.
///
/// The index owns a sorted copy of the elements; the caller's arrays are free after [`Index::build`]. Every
/// search takes many elements or points at once, sorts them as the index is sorted, and compares rows with
/// rows, a vector at a time. Sorting, rows and kernels are those of [`Rows`](crate::Rows). The cells follow
/// the density of the elements, not their size. Therefore the cost of a search for any distance follows from
/// the number of elements around, and empty space costs nothing.
///
/// # Searches
/// - *Two sets* ([`Index::couples_with`], [`Index::for_each_with`], [`Index::count_with`]): elements of
///   another set that touch elements of the index; no couples within either set. The comparison is that of
///   [`Elements`] with the radii of the two and the larger of the two tolerances. Two points with cut-offs
///   touch at half of the sum of the cut-offs. Either both sets are boxes or neither is. Either both have
///   filters of the same kind (groups: with equal matrices) or neither has.
/// - *Around points* ([`Index::within`], [`Index::within_with_distances`]): elements whose centre (of a box:
///   minimum corner) is at a distance of at most `r`.
/// - *Nearest* ([`Index::nearest`]): the `k` elements with the nearest centres.
///
/// Distances between centres are those of [`Elements::distance_squared`]: `((d_0 * d_0) + d_1 * d_1) + …` in
/// the type `T`, the axes in ascending order, without fused multiply-add. They are compared with `r * r`,
/// closed. Radii and tolerances have no effect on them.
///
/// # Order
/// All results are a function of the input alone. They are the same for any number of threads and any vector
/// instructions.
///
/// # Cost
/// Building takes some tens of nanoseconds per element. If sizes say little about density, the elements are
/// sorted up to six times. A search takes tens of nanoseconds per element or point, plus the comparisons, and
/// is most efficient for many points at once. For a point far outside, [`Index::nearest`] looks at all rows
/// on the facing side; a million elements in 3D have thousands of these. Many elements in exactly one place
/// are all compared for each query of the nearest. Memory per element: that of [`Rows`](crate::Rows), and `D`
/// coordinates more for boxes and for distances. Per query point the same, and its results once more.
///
/// # Errors
/// All searches return [`Error::IndexNotBuilt`] or [`Error::OutOfMemory`]; the output is then empty.
///
/// # Example
/// ```
/// use fdem_contact::{CrossCouple, Csr, Elements, Index};
///
/// let wall: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k), 0.0]).collect();
/// let mut index = Index::new();
/// index.build(&Elements::spheres(&wall, 0.5)?)?;
///
/// let grains = [[3.0, 1.0], [50.0, 7.0]];
/// let mut couples = Vec::new();
/// index.couples_with(&Elements::spheres(&grains, 0.5)?, &mut couples)?;
/// assert_eq!(couples, [CrossCouple { i: 0, j: 3 }]);
///
/// let mut found = Csr::new();
/// index.nearest(&grains, 1, &mut found)?;
/// assert_eq!((found.neighbours_of(1), found.values_of(1)), (&[50][..], &[49.0][..]));
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "spatial index")]
#[doc(alias = "cross list")]
#[derive(Clone, Debug)]
pub struct Index<T, const D: usize> {
    layout: Layout<T, D>,
    kind: Option<IndexKind<T>>,
    /// Number of elements. If it is 0, the layout is stale.
    len: usize,
    /// Maximum corners of boxes, by number.
    far: Vec<[T; D]>,
    /// The tolerance with which the layout holds the maximum corners; `None` if it does not hold them.
    far_tolerance: Option<T>,
    /// Centres in the order of the layout; filled once a search needs distances.
    centres: Vec<[T; D]>,
    bounds: Bounds<D>,
    sizes: IndexSizes<T>,
    /// The filter of the elements, by number.
    labels: Labels,
    matrix: Option<GroupMatrix>,
    /// The other set, sorted as the index is.
    moving: Layout<T, D>,
    /// The one radius of the other set, repeated for each of its elements.
    radii: Vec<T>,
    /// 0, 1, 2, …: numbers for kernels that report places in the sorted order.
    places: Vec<u32>,
    waiting: Vec<Vec<Couple>>,
    parts: Vec<PointsPart<T>>,
    /// The place of each point in the sorted order of the other set.
    order: Vec<u32>,
    simd: Available,
    pool: Pool,
}

/// The kind of elements of an index.
#[derive(Clone, Copy, Debug, PartialEq)]
enum IndexKind<T> {
    Equal { radius: T },
    Spheres,
    Boxes,
}

impl<T: Real, const D: usize> Default for Index<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> Index<T, D> {
    /// An index that is not built yet and holds no memory, with the fastest instructions of this processor.
    pub fn new() -> Self {
        Self {
            layout: Layout::new(),
            kind: None,
            len: 0,
            far: Vec::new(),
            far_tolerance: None,
            centres: Vec::new(),
            bounds: Bounds { min: [0.0; D], max: [0.0; D] },
            sizes: IndexSizes { radius: None, tolerance: T::ZERO, largest: 0.0, magnitude: 0.0 },
            labels: Labels::default(),
            matrix: None,
            moving: Layout::new(),
            radii: Vec::new(),
            places: Vec::new(),
            waiting: Vec::new(),
            parts: Vec::new(),
            order: Vec::new(),
            simd: Available::best(),
            pool: Pool::default(),
        }
    }

    /// The same with other vector instructions; the results are the same.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks them.
    pub fn with_simd(mut self, simd: Simd) -> Result<Self, Error> {
        self.simd = Available::new(simd)?;
        Ok(self)
    }

    /// The same on `threads` threads. 0 is one per processor; 1 is the default and uses no thread pool. The
    /// results are the same.
    ///
    /// # Errors
    /// [`Error::NoThreads`] if the threads cannot be started, if there are more than 1024, or if the crate
    /// was built without its feature `rayon`.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?.stopped_by(self.pool.stop().clone());
        Ok(self)
    }

    /// The same, but [`Index::build`] ends with [`Error::Stopped`] soon after `stop` is set, as with
    /// [`Detector::stopped_by`](crate::Detector::stopped_by); then the index is not built.
    /// Questions run to their end.
    #[must_use]
    pub fn stopped_by(mut self, stop: Arc<AtomicBool>) -> Self {
        self.pool = self.pool.stopped_by(Stop::new(stop));
        self
    }

    /// Number of elements; 0 before the index is built.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held now, working memory included.
    pub fn bytes(&self) -> usize {
        self.layout.bytes()
            + self.moving.bytes()
            + (self.far.capacity() + self.centres.capacity()) * size_of::<[T; D]>()
            + self.radii.capacity() * size_of::<T>()
            + (self.places.capacity() + self.order.capacity()) * size_of::<u32>()
            + self.labels.bytes()
            + self.waiting.iter().map(Vec::capacity).sum::<usize>() * size_of::<Couple>()
            + self.parts.iter().map(PointsPart::bytes).sum::<usize>()
    }

    /// Copies and sorts the elements. Earlier elements are replaced, and their memory is reused.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; the index is then not built.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::spheres(&[[0.0, 0.0], [3.0, 0.0]], 1.0)?)?;
    /// assert_eq!(index.len(), 2);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn build(&mut self, elements: &Elements<'_, T, D>) -> Result<(), Error> {
        (self.kind, self.len) = (None, 0);
        self.far.clear();
        self.far_tolerance = None;
        self.centres.clear();
        (self.bounds, self.sizes) = (elements.bounds(), IndexSizes::new(elements));
        let (kind, points, radii): (_, _, &[T]) = match elements.shape {
            Shape::Equal(equal) => (IndexKind::Equal { radius: equal.radius() }, equal.points(), &[]),
            Shape::Spheres(spheres) => (IndexKind::Spheres, spheres.points(), spheres.radii()),
            Shape::Boxes(boxes) => (IndexKind::Boxes, boxes.points(), &[]),
        };
        if !elements.is_empty() {
            self.sort(elements, points, radii)?;
        }
        if let Shape::Boxes(boxes) = elements.shape {
            reserve(&mut self.far, points.len())?;
            self.far.extend_from_slice(boxes.far_points());
        }
        self.labels.copy(elements.filter())?;
        self.matrix = match elements.filter().and_then(|filter| filter.matrix()) {
            Some(matrix) => Some(matrix.copy()?),
            None => None,
        };
        if !elements.is_empty() {
            self.layout.label(elements.filter(), &self.pool)?;
        }
        (self.kind, self.len) = (Some(kind), points.len());
        Ok(())
    }

    /// Sorts the elements into cells with a suitable number of elements each.
    fn sort(&mut self, elements: &Elements<'_, T, D>, points: &[[T; D]], radii: &[T]) -> Result<(), Error> {
        input::fit(elements, |grid| {
            self.layout.build(points, radii, grid, &self.pool)?;
            Ok::<_, Error>(self.load())
        })?;
        Ok(())
    }

    /// Average number of elements per occupied cell.
    fn load(&self) -> f64 {
        let (layout, long) = (&self.layout, self.layout.axes[0]);
        let mut cells = 0_usize;
        for row in 0..layout.rows() {
            let along = layout.along(&layout.row(row));
            let cell = |x: T| layout.grid.wide_cell(long, x.to_f64());
            cells += 1 + along.windows(2).filter(|pair| cell(pair[0]) != cell(pair[1])).count();
        }
        layout.len() as f64 / cells.max(1) as f64
    }

    /// Writes the couples of `elements` with the elements of the index into `couples`, which is cleared
    /// first.
    ///
    /// # Shapes
    /// `m` couples, each once: `i` belongs to `elements`, `j` to the index. Their order is a function of the
    /// input alone; [`CrossInput`](crate::CrossInput) defines it for spheres and points.
    ///
    /// # Errors
    /// [`Error::UnlikeShapes`], and those of [`Index`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{CrossCouple, Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::boxes(&[[0.0, 0.0]], &[[10.0, 1.0]])?)?;
    /// let mut couples = Vec::new();
    /// index.couples_with(&Elements::boxes(&[[4.0, 1.0], [4.0, 2.0]], &[[5.0, 2.0], [5.0, 3.0]])?, &mut couples)?;
    /// assert_eq!(couples, [CrossCouple { i: 0, j: 0 }]);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn couples_with(
        &mut self,
        elements: &Elements<'_, T, D>,
        couples: &mut Vec<CrossCouple>,
    ) -> Result<(), Error> {
        couples.clear();
        let mut room = Ok(());
        let mut take = |found: &[Couple]| {
            if room.is_ok() {
                room = grow(couples, found.len());
            }
            if room.is_ok() {
                couples.extend(found.iter().map(|&Couple { i, j }| CrossCouple { i, j }));
            }
        };
        let result = self.search_with(elements, Sink::Visit(&mut take));
        result.and(room).inspect_err(|_| couples.clear())
    }

    /// Calls `visit` with every couple of [`Index::couples_with`], in the same order, without storing them.
    ///
    /// # Errors
    /// As [`Index::couples_with`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::spheres(&[[0.0, 0.0], [3.0, 0.0]], 1.0)?)?;
    /// let mut sum = 0;
    /// index.for_each_with(&Elements::spheres(&[[1.5, 0.0]], 0.5)?, |couple| sum += couple.j)?;
    /// assert_eq!(sum, 1);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn for_each_with(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(CrossCouple),
    ) -> Result<(), Error> {
        let mut take =
            |found: &[Couple]| found.iter().for_each(|&Couple { i, j }| visit(CrossCouple { i, j }));
        self.search_with(elements, Sink::Visit(&mut take))
    }

    /// The number of couples of [`Index::couples_with`], without storing them.
    ///
    /// # Errors
    /// As [`Index::couples_with`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::points(&[[0.0], [3.0]], 1.0)?)?;
    /// assert_eq!(index.count_with(&Elements::points(&[[0.5], [1.5], [2.5]], 1.0)?)?, 2);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn count_with(&mut self, elements: &Elements<'_, T, D>) -> Result<u64, Error> {
        let mut count = 0;
        self.search_with(elements, Sink::Count(&mut count))?;
        Ok(count)
    }

    fn search_with(&mut self, elements: &Elements<'_, T, D>, sink: Sink<'_>) -> Result<(), Error> {
        let kind = self.kind.ok_or(Error::IndexNotBuilt)?;
        if (kind == IndexKind::Boxes) != matches!(elements.shape, Shape::Boxes(_)) {
            return Err(Error::UnlikeShapes);
        }
        if elements.is_empty() || self.is_empty() {
            return Ok(());
        }
        let filters = match (elements.filter(), self.labels.as_filter(self.matrix.as_ref())) {
            (None, None) => [None; 2],
            (Some(theirs), Some(ours)) if theirs.is_like(&ours) => [Some(theirs), Some(ours)],
            _ => return Err(Error::UnlikeFilters),
        };
        let CrossReach { tolerance, reach, reach_squared } = self.sizes.reach_with(elements);
        let Self { layout, moving, radii, pool, .. } = self;
        let n = elements.len();
        let (points, their_radii): (_, &[T]) = match (elements.shape, kind) {
            (Shape::Boxes(boxes), _) => (boxes.points(), &[]),
            (Shape::Spheres(spheres), _) => (spheres.points(), spheres.radii()),
            (Shape::Equal(equal), IndexKind::Equal { .. }) => (equal.points(), &[]),
            (Shape::Equal(equal), _) => {
                radii.clear();
                resize(radii, n, equal.radius())?;
                (equal.points(), &radii[..])
            }
        };
        let with_radii = !their_radii.is_empty();
        if let (IndexKind::Equal { radius }, true) = (kind, with_radii) {
            let len = layout.len() + PADDING;
            resize(&mut layout.radii, len, radius)?;
        }
        moving.build_along(points, their_radii, layout.grid.over(elements.bounds()), layout.axes, pool)?;

        if let Shape::Boxes(boxes) = elements.shape {
            moving.set_far(boxes.far_points(), tolerance, pool)?;
            if self.far_tolerance != Some(tolerance) {
                layout.set_far(&self.far, tolerance, pool)?;
                self.far_tolerance = Some(tolerance);
            }
        }
        moving.label(filters[0], pool)?;
        let mut arrays = [moving.arrays(filters[0]), layout.arrays(filters[1])];
        if !with_radii {
            arrays = arrays.map(|arrays| Arrays { radii: &[], ..arrays });
        }
        let simd = self.simd;
        let scan = Scan {
            layout: moving,
            against: Some(layout),
            arrays,
            reach,
            reach_squared,
            tolerance,
            largest: 0.5 * elements.largest(),
            one_numbering: false,
            part: PART,
            search_row: &|task, out| T::search::<D>(simd, task, out),
        };
        Scans { each: &[scan], pool, parts: &mut self.waiting }.all(sink)
    }

    /// Writes, for each point, the elements at a distance of at most `r` into its row of `found`, ascending
    /// by number.
    ///
    /// # Shapes
    /// `points` `[q]`; `found`: `q` rows.
    ///
    /// # Errors
    /// [`Error::InvalidCutoff`] if `r` is negative or NaN; [`Error::NonFiniteCoordinate`],
    /// [`Error::CoordinateTooLarge`] and [`Error::TooManyElements`] for the points; and those of [`Index`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Csr, Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::points(&[[0.0, 0.0], [1.0, 0.0], [5.0, 0.0]], 1.0)?)?;
    /// let mut found = Csr::new();
    /// index.within(&[[0.5, 0.0], [9.0, 9.0]], 0.5, &mut found)?;
    /// assert_eq!(found.neighbours_of(0), [0, 1]);
    /// assert!(found.neighbours_of(1).is_empty());
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    #[doc(alias = "range query")]
    #[doc(alias = "ball query")]
    pub fn within(&mut self, points: &[[T; D]], r: T, found: &mut Csr) -> Result<(), Error> {
        found.clear();
        let (offsets, neighbours, _) = found.arrays_mut();
        self.find_within(points, r, offsets, neighbours, None).inspect_err(|_| found.clear())
    }

    /// Finds elements as [`Index::within`] does, with the squared distance of each element as its value.
    ///
    /// # Errors
    /// As [`Index::within`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Csr, Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::points(&[[0.0, 0.0], [1.0, 0.0], [5.0, 0.0]], 1.0)?)?;
    /// let mut found = Csr::new();
    /// index.within_with_distances(&[[1.0, 2.0]], 3.0, &mut found)?;
    /// assert_eq!((found.neighbours_of(0), found.values_of(0)), (&[0, 1][..], &[5.0, 4.0][..]));
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn within_with_distances(
        &mut self,
        points: &[[T; D]],
        r: T,
        found: &mut Csr<T>,
    ) -> Result<(), Error> {
        found.clear();
        let (offsets, neighbours, values) = found.arrays_mut();
        self.find_within(points, r, offsets, neighbours, Some(values)).inspect_err(|_| found.clear())
    }

    /// Writes, for each point, the `k` nearest elements into its row of `found`, ascending by squared
    /// distance, then by number. The values are the squared distances.
    ///
    /// There are fewer entries if there are fewer than `k` elements. Elements at the same distance are
    /// ordered by number, so the row is unique.
    ///
    /// # Shapes
    /// `points` `[q]`; `found`: `q` rows of `min(k, n)` entries.
    ///
    /// # Errors
    /// [`Error::NonFiniteCoordinate`], [`Error::CoordinateTooLarge`] and [`Error::TooManyElements`] for the
    /// points; and those of [`Index`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Csr, Elements, Index};
    ///
    /// let mut index = Index::new();
    /// index.build(&Elements::points(&[[0.0, 0.0], [1.0, 0.0], [5.0, 0.0]], 1.0)?)?;
    /// let mut found = Csr::new();
    /// index.nearest(&[[0.5, 0.0], [4.0, 0.0]], 2, &mut found)?;
    /// assert_eq!((found.neighbours_of(0), found.values_of(0)), (&[0, 1][..], &[0.25, 0.25][..]));
    /// assert_eq!((found.neighbours_of(1), found.values_of(1)), (&[2, 1][..], &[1.0, 9.0][..]));
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    #[doc(alias = "knn")]
    pub fn nearest(&mut self, points: &[[T; D]], k: usize, found: &mut Csr<T>) -> Result<(), Error> {
        found.clear();
        let (offsets, neighbours, values) = found.arrays_mut();
        self.find_nearest(points, k, offsets, neighbours, values).inspect_err(|_| found.clear())
    }
}
