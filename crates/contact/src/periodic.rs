//! Search in a periodic box: wraps the elements, adds the images that may touch them, searches them all, and
//! reports shifts.

pub(crate) mod buffered;
pub(crate) mod cell;
mod images;
pub(crate) mod reduced;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::couple::Couple;
use crate::detector::Detector;
use crate::elements::{Elements, Shape};
use crate::engine::{Engine, Plan};
use crate::error::Error;
use crate::explain::{Around, Estimate, Explanation, Means};
use crate::grid::Grid;
use crate::memory::grow;
use crate::periodic::cell::PeriodicBox;
use crate::periodic::images::Images;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::Search;
use crate::simd::Simd;
use crate::stop::Stop;

/// Two touching elements of a periodic box: `i`, and `j` displaced by `shift` edges.
///
/// Take both elements at the caller's positions, which need not be inside the box. Element `j`, displaced by
/// the sum of `shift[a]` times edge `a`, touches element `i`. Seen from `j` the shift is `-shift`. Each
/// contact is reported in one form: `i < j` with any shift, or `i == j` with a shift whose first nonzero
/// number is positive (an element that touches its own image). Ordered by `i`, `j`, shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C)]
pub struct PeriodicCouple<const D: usize> {
    /// The smaller number.
    pub i: u32,
    /// The larger number; equal to `i` if an element touches its own image.
    pub j: u32,
    /// Number of edges by which `j` is displaced; 0 along edges that are not periodic.
    pub shift: [i32; D],
}

/// Default limit on the number of images: some 6 GB in 3D and `f64`.
pub const DEFAULT_MAX_IMAGES: usize = 1 << 26;

/// Largest shift of an image, so that shifts together with twice the periods of an element fit `i32`.
const MOST_IMAGES: usize = 1 << 30;

/// Finds every contact of elements in a [`PeriodicBox`], each once, with its shift. All touching images
/// count, not only the nearest.
///
/// Elements outside the box are wrapped into it. Every image of a wrapped element that may touch a wrapped
/// element is made; their number follows from the reach of the elements and the heights of the box. One
/// search runs over all elements, and another one over the elements near the faces together with the images.
/// If there are many images, a single search runs over all elements and images. Therefore the box may be
/// sheared by any amount, and may be smaller than the elements. A skewed box is searched by the short edges
/// of the same lattice ([`PeriodicBox::reduced`]); shifts count the given edges. The search does not use the
/// minimum image convention: the nearest image is only one of several contacts in a small box, and the wrong
/// one in a sheared box.
///
/// # When do two elements touch?
/// The comparison is that of [`Elements`], closed, in the type `T`, between two rounded points:
/// - `w_i`, the position of element `i` after [`PeriodicBox::wrap`]: displaced by `-n_i`, rounded once per
///   element, or `x_i` itself if `n_i` is 0.
/// - `p`, [`PeriodicBox::displaced`] of `w_j` by `s`: rounded once per image, or `w_j` itself if `s` is 0.
///
/// In a skewed box, points are wrapped and displaced by the short edges.
///
/// An axis-aligned box is displaced by the periods of its minimum corner; both corners are rounded in this
/// way.
///
/// The couple is `(i, j, shift)` with `shift = s + n_i - n_j`, where `i < j`, or `i == j` and the first
/// nonzero number of `s` is positive. Therefore the compared image always belongs to the element with the
/// larger number. The image of the other element may round differently, and decides nothing. If all sums are
/// exact, the result does not depend on the periods in which the caller places the elements.
///
/// With a [`Filter`](crate::Filter), an image has the numbers of its element: they belong to the same body
/// and the same group. Whether an element may touch its own image is decided by the filter for the element
/// and itself, [`Filter::admits(i, i)`](crate::Filter::admits).
///
/// # Order
/// First the order of the engine over the wrapped elements; then that of the engine over the elements near
/// the faces followed by the images, sorted by element, then by shift. If the number of images is more than a
/// quarter of the number of elements, the order of the engine over all elements followed by the images. The
/// order is a function of the input alone.
///
/// # Cost
/// Memory of the search over `n` elements, and of one over `m` images and at most `m` elements. For an edge
/// of height `h` and a reach `r` (largest diameter plus tolerance) there are about `2 r / h` images per
/// element: few in a large box. One pass over the elements finds those outside or near a face. If the edges
/// lie along the axes and no element is outside, only elements near faces are copied. Memory per image: twice
/// `D` coordinates, `D` integers of 4 bytes, the radius if radii differ, 8 bytes, the numbers of a filter,
/// and the engine. If an element is outside, `D` coordinates and `D` integers for each element. Boxes no
/// wider than two reaches are searched by testing elements against elements and images, at most `n (n + m)`
/// tests.
///
/// # Source
/// The ghost images of M.P. Allen, D.J. Tildesley, "Computer Simulation of Liquids", Oxford 1987,
/// section 1.5, without the minimum image convention.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, Engine, PeriodicBox, PeriodicCouple, PeriodicSearch};
///
/// let discs = [[0.25, 2.0], [3.75, 2.0], [2.0, 9.0]]; // the last one is two periods up
/// let elements = Elements::spheres(&discs, 0.5)?;
/// let cell = PeriodicBox::orthogonal([0.0, 0.0], [4.0, 4.0], [true, true])?;
///
/// let mut couples = Vec::new();
/// PeriodicSearch::new().couples(&elements, &cell, &mut couples)?;
/// // Disc 1, one edge to the left, is at -0.25 and touches disc 0.
/// assert_eq!(couples, [PeriodicCouple { i: 0, j: 1, shift: [-1, 0] }]);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "minimum image")]
#[doc(alias = "ghost")]
#[derive(Clone, Debug)]
pub struct PeriodicSearch<T, const D: usize> {
    /// The given engine; `None` to choose one.
    engine: Option<Engine>,
    /// Searches all elements; below, those near the faces with their images.
    detector: Detector<T, D>,
    outer_detector: Detector<T, D>,
    images: Images<T, D>,
    refuse_outside: bool,
    max_images: usize,
    pool: Pool,
    /// Couples of each part before they are appended to a list.
    parts: Vec<Vec<PeriodicCouple<D>>>,
}

impl<T: Real, const D: usize> Default for PeriodicSearch<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> PeriodicSearch<T, D> {
    /// A search that chooses its engines from the elements, and holds no memory yet.
    pub fn new() -> Self {
        Self {
            engine: None,
            detector: Detector::new(),
            outer_detector: Detector::new(),
            images: Images::new(),
            refuse_outside: false,
            max_images: DEFAULT_MAX_IMAGES,
            pool: Pool::default(),
            parts: Vec::new(),
        }
    }

    /// The same with this engine for elements and images; `None` chooses from the elements.
    #[must_use]
    pub fn with_engine(mut self, engine: impl Into<Option<Engine>>) -> Self {
        self.engine = engine.into();
        self.detector = self.detector.with_engine(self.engine);
        self.outer_detector = self.outer_detector.with_engine(self.engine);
        self
    }

    /// The same, but an element outside the box along a periodic edge is refused with [`Error::OutsideBox`]
    /// instead of being wrapped.
    ///
    /// The faces belong to the box. So do points that are outside by no more than rounding.
    #[must_use]
    pub fn refuse_outside(mut self) -> Self {
        self.refuse_outside = true;
        self
    }

    /// The same with another limit on the number of images, at most `2^30`; the default is
    /// [`DEFAULT_MAX_IMAGES`].
    #[must_use]
    pub fn with_max_images(mut self, max_images: usize) -> Self {
        self.max_images = max_images.min(MOST_IMAGES);
        self
    }

    /// The same on `threads` threads, as [`Rows::with_threads`](crate::Rows::with_threads); other engines use
    /// them for the images only. The couples and their order are the same for any number.
    ///
    /// # Errors
    /// [`Error::NoThreads`].
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?.stopped_by(self.pool.stop().clone());
        self.detector = self.detector.with_pool(self.pool.clone());
        self.outer_detector = self.outer_detector.with_pool(self.pool.clone());
        Ok(self)
    }

    /// The same, but a search for a list of couples ends with [`Error::Stopped`] soon after `stop` is set, as
    /// with [`Detector::stopped_by`].
    #[must_use]
    pub fn stopped_by(mut self, stop: Arc<AtomicBool>) -> Self {
        self.pool = self.pool.stopped_by(Stop::new(stop));
        self.detector = self.detector.with_pool(self.pool.clone());
        self.outer_detector = self.outer_detector.with_pool(self.pool.clone());
        self
    }

    /// The same with other vector instructions, if the engine uses any ([`Rows`](crate::Rows)). The couples
    /// and their order are the same.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks them.
    pub fn with_simd(mut self, simd: Simd) -> Result<Self, Error> {
        self.detector = self.detector.with_simd(simd)?;
        self.outer_detector = self.outer_detector.with_simd(simd)?;
        Ok(self)
    }

    /// Number of images that the last search or the last explanation made.
    pub fn images(&self) -> usize {
        self.images.owners.len()
    }

    /// Bytes held now: elements, images, the engines, and working memory.
    pub fn bytes(&self) -> usize {
        let parts = self.parts.iter().map(Vec::capacity).sum::<usize>();
        self.detector.bytes()
            + self.outer_detector.bytes()
            + self.images.bytes()
            + parts * size_of::<PeriodicCouple<D>>()
    }

    /// Predicts the cost of a search: engine, rows, images, memory, and the expected number of couples.
    ///
    /// The plan and the rows are those of the search over all elements. In a box with many images, elements
    /// and images are searched together, and the plan and the rows include the images. The number of couples
    /// is estimated as by [`Detector::explain`], with images among the neighbours.
    ///
    /// # Cost
    /// The elements are wrapped and the images made, in the memory that a search would use. Then follows one
    /// pass over elements and images, as in [`Detector::explain`].
    ///
    /// # Errors
    /// The errors of [`PeriodicSearch::for_each`], except running out of memory that only a search takes.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Engine, PeriodicBox, PeriodicSearch};
    ///
    /// // A row of discs that closes across the face of the box.
    /// let discs: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k), 0.0]).collect();
    /// let elements = Elements::spheres(&discs, 0.5)?;
    /// let cell = PeriodicBox::orthogonal([0.0, 0.0], [100.0, 9.0], [true, true])?;
    /// let explanation = PeriodicSearch::new().explain(&elements, &cell)?;
    /// assert_eq!(explanation.couples, 100.0);
    /// println!("{explanation}");
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    #[doc(alias = "estimate")]
    pub fn explain(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
    ) -> Result<Explanation<D>, Error> {
        let asked_for = self.engine.is_some();
        let Prepared { images, inner, outer, test, of_inner, of_outer, .. } = self.prepare(elements, cell)?;
        let (searched, by) = match &inner {
            Some(inner) => (inner, &*of_inner),
            None => (&outer, &*of_outer),
        };
        let (plan, mut means) = if test {
            let small =
                "all elements are within reach of most others: each is tested with all, and with all images";
            (Plan::without_cells(if asked_for { "requested" } else { small }), Means::NONE)
        } else {
            (by.plan(searched)?, by.means(searched)?)
        };
        if inner.is_some() {
            means.bytes += of_outer.means(&outer).map_err(|error| images.named_error(error))?.bytes;
        }
        means.bytes += images.bytes();

        // The cells hold elements and images together. Their larger number can only widen cells by the eighth
        // that is allowed for wide domains.
        let bounds = searched.bounds().join(&outer.bounds());
        let edge = Grid::unbounded(searched).cell_size().max(Grid::unbounded(&outer).cell_size());
        let grid = Grid::with_cell_size(bounds.min, bounds.max, 1.125 * edge);
        let around = AroundElements { images, outer: &outer };
        let couples = Estimate::with_images(searched, elements.len(), grid, &around);
        let told = Explanation::new(plan, searched, means, couples, size_of::<PeriodicCouple<D>>());
        Ok(Explanation { elements: elements.len(), images: Some(images.owners.len()), ..told })
    }

    /// Calls `visit` with every couple that touches. Only elements and images are stored.
    ///
    /// # Errors
    /// [`Error::TooFarFromBox`], [`Error::OutsideBox`], [`Error::UnresolvedBox`], [`Error::TooManyImages`],
    /// [`Error::OutOfMemory`], and those of [`Search::for_each`]. `visit` has not been called then, unless
    /// memory ran out.
    pub fn for_each(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        visit: impl FnMut(PeriodicCouple<D>),
    ) -> Result<(), Error> {
        self.prepare(elements, cell)?.for_each(visit)
    }

    /// Writes the couples into `couples`, which is cleared first; its memory is reused.
    ///
    /// # Errors
    /// The errors of [`PeriodicSearch::for_each`], and [`Error::OutOfMemory`] if the couples themselves do
    /// not fit. `couples` is empty after an error.
    pub fn couples(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        couples: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(), Error> {
        couples.clear();
        self.prepare(elements, cell)?.append(couples).inspect_err(|_| couples.clear())
    }

    /// Writes the couples with shift 0 into `unshifted` and all others into `shifted`, each in the order of
    /// [`PeriodicSearch::couples`]. Both are cleared first.
    ///
    /// In a large box with all elements inside, nearly all couples have shift 0. Then this takes less than
    /// half the memory, and less time.
    ///
    /// # Errors
    /// The errors of [`PeriodicSearch::couples`]; both lists are empty after an error.
    pub fn couples_by_shift(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        unshifted: &mut Vec<Couple>,
        shifted: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(), Error> {
        unshifted.clear();
        shifted.clear();
        self.prepare(elements, cell)?.append_by_shift(unshifted, shifted).inspect_err(|_| {
            unshifted.clear();
            shifted.clear();
        })
    }

    /// The number of couples. Only elements and images are stored.
    ///
    /// # Errors
    /// As [`PeriodicSearch::for_each`].
    pub fn count(&mut self, elements: &Elements<'_, T, D>, cell: &PeriodicBox<T, D>) -> Result<u64, Error> {
        self.prepare(elements, cell)?.count()
    }

    /// Folds the couples on all threads without storing them: `visit` gets every couple once, with the state
    /// of its part.
    ///
    /// As in [`Rows::fold`](crate::Rows::fold), the parts do not depend on the number of threads. Engines
    /// other than [`Rows`](crate::Rows) have one part.
    ///
    /// # Errors
    /// As [`PeriodicSearch::for_each`].
    #[doc(alias = "parallel visitor")]
    pub fn fold<S: Send>(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        start: impl Fn() -> S,
        visit: impl Fn(&mut S, PeriodicCouple<D>) + Sync,
    ) -> Result<Vec<S>, Error> {
        self.prepare(elements, cell)?.fold(start, visit)
    }

    /// Calls `visit` with every couple that touches, found by another search, such as one on another device.
    ///
    /// The engine of this search has no effect: both parts of [`PeriodicSearch`] are always searched.
    ///
    /// # Order
    /// First the couples of `search` over the wrapped elements. Then those of `search` over the elements near
    /// the faces, ascending by number, followed by the images, which ascend by element, then by shift, edge 0
    /// first; of these only the couples of an element and an image of one with a larger number, or a higher
    /// image of itself. If there are more images than a quarter of the elements, or all elements lie within
    /// two reaches, there is but one search: over all elements followed by the images. With
    /// [`Rows`](crate::Rows) it is the order of this search with [`Engine::Rows`].
    ///
    /// # Errors
    /// The errors of [`PeriodicSearch::for_each`] and of `search`.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, PeriodicBox, PeriodicCouple, PeriodicSearch, Rows};
    ///
    /// let discs = [[0.25, 2.0], [3.75, 2.0]];
    /// let elements = Elements::spheres(&discs, 0.5)?;
    /// let cell = PeriodicBox::orthogonal([0.0, 0.0], [4.0, 4.0], [true, true])?;
    /// let mut couples = Vec::new();
    /// PeriodicSearch::new().for_each_by(&mut Rows::new(), &elements, &cell, |couple| couples.push(couple))?;
    /// assert_eq!(couples, [PeriodicCouple { i: 0, j: 1, shift: [-1, 0] }]);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn for_each_by(
        &mut self,
        search: &mut impl Search<T, D>,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        mut visit: impl FnMut(PeriodicCouple<D>),
    ) -> Result<(), Error> {
        self.images.build(elements, cell, self.refuse_outside, true, self.max_images, &self.pool)?;
        let images = &self.images;
        let outer = images.with_images(elements)?;
        if images.apart {
            search.for_each(&images.wrapped(elements)?, |couple| visit(images.named(couple)))?;
        }
        search
            .for_each(&outer, |couple| {
                if let Some(couple) = images.named_outer(couple) {
                    visit(couple);
                }
            })
            .map_err(|error| images.named_error(error))
    }

    /// Writes the couples of [`PeriodicSearch::for_each_by`] into `couples`, which is cleared first.
    ///
    /// # Errors
    /// The errors of [`PeriodicSearch::for_each_by`], and [`Error::OutOfMemory`]. `couples` is empty after an
    /// error.
    pub fn couples_by(
        &mut self,
        search: &mut impl Search<T, D>,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        couples: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(), Error> {
        couples.clear();
        let mut room = Ok(());
        let found = self.for_each_by(search, elements, cell, |couple| {
            if room.is_ok() {
                room = grow(couples, 1);
            }
            if room.is_ok() {
                couples.push(couple);
            }
        });
        found.and(room).inspect_err(|_| couples.clear())
    }

    /// Wraps the elements, makes the images, and checks that all can be searched.
    fn prepare<'s>(
        &'s mut self,
        elements: &Elements<'s, T, D>,
        cell: &PeriodicBox<T, D>,
    ) -> Result<Prepared<'s, T, D>, Error> {
        let direct = self.engine == Some(Engine::Direct);
        self.images.build(elements, cell, self.refuse_outside, !direct, self.max_images, &self.pool)?;
        let images = &self.images;
        let inner = if images.apart { Some(images.wrapped(elements)?) } else { None };
        let outer = images.with_images(elements)?;
        let test = direct || (self.engine.is_none() && images.compact);
        if !test {
            self.detector.plan(&outer).map_err(|error| images.named_error(error))?;
            inner.iter().try_for_each(|inner| self.detector.plan(inner).map(drop))?;
        }
        let Self { detector: of_inner, outer_detector: of_outer, parts, pool, .. } = self;
        Ok(Prepared { images, inner, outer, test, of_inner, of_outer, parts, stop: pool.stop() })
    }
}

/// The elements to be searched, and the searches for them.
struct Prepared<'s, T, const D: usize> {
    images: &'s Images<T, D>,
    /// All elements; `None` if they are part of `outer`.
    inner: Option<Elements<'s, T, D>>,
    /// Elements near the faces, or all elements, with their images.
    outer: Elements<'s, T, D>,
    /// Whether every couple of `outer` is tested instead of searched.
    test: bool,
    of_inner: &'s mut Detector<T, D>,
    of_outer: &'s mut Detector<T, D>,
    /// Working memory for lists in parts.
    parts: &'s mut Vec<Vec<PeriodicCouple<D>>>,
    stop: &'s Stop,
}

impl<T: Real, const D: usize> Prepared<'_, T, D> {
    fn for_each(self, mut visit: impl FnMut(PeriodicCouple<D>)) -> Result<(), Error> {
        let Self { images, inner, outer, of_inner, of_outer, .. } = self;
        if self.test {
            return images.test(&outer, self.stop, visit);
        }
        if let Some(inner) = inner {
            of_inner.for_each_block(&inner, |block| {
                block.iter().map(|&couple| images.named(couple)).for_each(&mut visit);
            })?;
        }
        let outer = of_outer.for_each_block(&outer, |block| {
            block.iter().filter_map(|&couple| images.named_outer(couple)).for_each(&mut visit);
        });
        outer.map_err(|error| images.named_error(error))
    }

    fn append(self, couples: &mut Vec<PeriodicCouple<D>>) -> Result<(), Error> {
        let Self { images, inner, outer, of_inner, of_outer, parts, .. } = self;
        if self.test {
            let mut room = Ok(());
            images.test(&outer, self.stop, |couple| {
                if room.is_ok() {
                    room = grow(couples, 1);
                }
                if room.is_ok() {
                    couples.push(couple);
                }
            })?;
            return room;
        }
        if let Some(inner) = inner {
            let convert = |block: &[Couple], list: &mut Vec<_>| {
                grow(list, block.len())?;
                if images.any_away {
                    list.extend(block.iter().map(|&couple| images.named(couple)));
                } else {
                    list.extend(block.iter().map(|&Couple { i, j }| PeriodicCouple { i, j, shift: [0; D] }));
                }
                Ok(())
            };
            of_inner.append_converted(&inner, convert, parts, couples)?;
        }
        let convert = |block: &[Couple], list: &mut Vec<_>| {
            grow(list, block.len())?;
            list.extend(block.iter().filter_map(|&couple| images.named_outer(couple)));
            Ok(())
        };
        let outer = of_outer.append_converted(&outer, convert, parts, couples);
        outer.map_err(|error| images.named_error(error))
    }

    fn append_by_shift(
        mut self,
        unshifted: &mut Vec<Couple>,
        shifted: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(), Error> {
        if !self.images.any_away
            && !self.test
            && let Some(inner) = self.inner.take()
        {
            self.of_inner.couples(&inner, unshifted)?;
        }
        let mut room = Ok(());
        self.for_each(|couple| {
            let PeriodicCouple { i, j, shift } = couple;
            if room.is_ok() {
                room = if shift == [0; D] { grow(unshifted, 1) } else { grow(shifted, 1) };
            }
            match (&room, shift == [0; D]) {
                (Ok(()), true) => unshifted.push(Couple { i, j }),
                (Ok(()), false) => shifted.push(couple),
                (Err(_), _) => {}
            }
        })?;
        room
    }

    fn count(self) -> Result<u64, Error> {
        let Self { images, inner, outer, of_inner, of_outer, .. } = self;
        let mut count = 0;
        if self.test {
            images.test(&outer, self.stop, |_| count += 1)?;
            return Ok(count);
        }
        if let Some(inner) = inner {
            count += of_inner.count(&inner)?;
        }
        let counts = of_outer.fold_blocks(
            &outer,
            || 0,
            |count, block| {
                *count += block.iter().filter(|couple| images.is_reported(**couple)).count() as u64;
            },
        );
        let counts = counts.map_err(|error| images.named_error(error))?;
        Ok(count + counts.into_iter().sum::<u64>())
    }

    fn fold<S: Send>(
        self,
        start: impl Fn() -> S,
        visit: impl Fn(&mut S, PeriodicCouple<D>) + Sync,
    ) -> Result<Vec<S>, Error> {
        let Self { images, inner, outer, of_inner, of_outer, .. } = self;
        let mut states = Vec::new();
        if self.test {
            let mut state = start();
            images.test(&outer, self.stop, |couple| visit(&mut state, couple))?;
            states.push(state);
            return Ok(states);
        }
        if let Some(inner) = inner {
            states = of_inner.fold_blocks(&inner, &start, |state, block| {
                for &couple in block {
                    visit(state, images.named(couple));
                }
            })?;
        }
        let outer = of_outer.fold_blocks(&outer, start, |state, block| {
            let named = block.iter().filter_map(|&couple| images.named_outer(couple));
            named.for_each(|couple| visit(state, couple));
        });
        states.append(&mut outer.map_err(|error| images.named_error(error))?);
        Ok(states)
    }
}

/// The images around all elements, for an estimate of couples.
struct AroundElements<'s, T, const D: usize> {
    images: &'s Images<T, D>,
    /// Elements near the faces, or all elements, with the images.
    outer: &'s Elements<'s, T, D>,
}

impl<T: Real, const D: usize> AroundElements<'_, T, D> {
    /// An element and an image by their places in `outer`; `None` if the element is not there, because then
    /// it touches no image.
    fn couple(&self, element: usize, image: usize) -> Option<Couple> {
        let near = &self.images.near;
        let i = if self.images.apart { near.binary_search(&(element as u32)).ok()? } else { element };
        Some(Couple { i: i as u32, j: (near.len() + image) as u32 })
    }
}

impl<T: Real, const D: usize> Around<T, D> for AroundElements<'_, T, D> {
    fn points(&self) -> &[[T; D]] {
        let points = match &self.outer.shape {
            Shape::Equal(equal) => equal.points(),
            Shape::Spheres(spheres) => spheres.points(),
            Shape::Boxes(boxes) => boxes.points(),
        };
        &points[self.images.near.len()..]
    }

    fn touch(&self, element: usize, image: usize) -> bool {
        self.couple(element, image).is_some_and(|Couple { i, j }| self.outer.touch(i as usize, j as usize))
    }

    fn is_reported(&self, element: usize, image: usize) -> bool {
        self.couple(element, image).is_some_and(|couple| self.images.is_reported(couple))
    }
}

impl<T: Real, const D: usize> Images<T, D> {
    /// Tests all elements against all elements and images.
    fn test(
        &self,
        all: &Elements<'_, T, D>,
        stop: &Stop,
        mut visit: impl FnMut(PeriodicCouple<D>),
    ) -> Result<(), Error> {
        let n = self.near.len();
        let mut image = 0;
        for i in 0..n {
            stop.go_on()?;
            while self.owners.get(image).is_some_and(|&owner| (owner as usize) < i) {
                image += 1;
            }
            for other in (i + 1..n).chain(n + image..all.len()) {
                if let Some(couple) = self.named_outer(Couple { i: i as u32, j: other as u32 })
                    && all.touch(i, other)
                {
                    visit(couple);
                }
            }
        }
        Ok(())
    }

    /// The couple of two elements, with the shift between the caller's positions.
    #[inline]
    fn named(&self, couple: Couple) -> PeriodicCouple<D> {
        self.displaced(couple.i, couple.j, [0; D])
    }

    /// The couple of `i` and the image of `j` displaced by `shift`, with the shift between the caller's
    /// positions.
    ///
    /// With `x = w + n . v` for both positions, `x_j + shift . v` touches `x_i` if `w_j + s . v` touches
    /// `w_i` and `shift = s + n_i - n_j`. (Nothing overflows: `|s| <= 2^30`, `|n| <= 2^28`.)
    #[inline]
    fn displaced(&self, i: u32, j: u32, mut shift: [i32; D]) -> PeriodicCouple<D> {
        if self.any_away {
            let (of_i, of_j) = (self.periods_of(i as usize), self.periods_of(j as usize));
            for edge in 0..D {
                shift[edge] += of_i[edge] - of_j[edge];
            }
        }
        if let Some(reduced) = &self.reduced {
            shift = reduced.shift_of_couple([i, j], &shift);
        }
        PeriodicCouple { i, j, shift }
    }

    /// The couple of two elements of `outer`, `i < j`, if it [is reported](Self::is_reported).
    #[inline]
    fn named_outer(&self, couple: Couple) -> Option<PeriodicCouple<D>> {
        if !self.is_reported(couple) {
            return None;
        }
        let i = self.near[couple.i as usize];
        Some(match (couple.j as usize).checked_sub(self.near.len()) {
            None => self.displaced(i, self.near[couple.j as usize], [0; D]),
            Some(image) => self.displaced(i, self.owners[image], self.shifts[image]),
        })
    }

    /// Whether a couple of two elements of `outer`, `i < j`, is reported here. Not reported are: couples of
    /// two elements if all elements are searched separately; couples of two images; couples of an element and
    /// an image of an element with a smaller number; couples of an element and the lower of two opposite
    /// images of itself.
    #[inline]
    fn is_reported(&self, Couple { i, j }: Couple) -> bool {
        let Some(&element) = self.near.get(i as usize) else { return false };
        let Some(image) = (j as usize).checked_sub(self.near.len()) else { return !self.apart };
        let owner = self.owners[image];
        owner > element || (owner == element && self.shifts[image] > [0; D])
    }

    /// Names the caller's element in an error of a search of `outer`.
    fn named_error(&self, mut error: Error) -> Error {
        self.name_owner(&mut error);
        error
    }
}
