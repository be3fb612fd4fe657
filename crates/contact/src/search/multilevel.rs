//! Search among unlike sizes: levels of elements of similar size, each sorted into its own rows.

mod levels;

use std::sync::atomic::{AtomicU64, Ordering};

use crate::compiled::compiled;
use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::Labels;
use crate::grid::rows_of;
use crate::memory::reserve;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::Search;
use crate::search::level::Level;
use crate::search::rows::layout::Layout;
use crate::search::rows::scan::{Scan, Scanner, Scans, Sink};
use crate::simd::task::{Arrays, Looks, Output, Span, Task};
use crate::simd::{Available, Simd};

use levels::Model;

/// A search for elements of any sizes, in levels. It suits powders, where the largest element is many times
/// as large as the smallest.
///
/// A single cell size suits similar sizes only: cells as wide as the largest element would hold thousands of
/// small ones. Here the elements are split by size. Each level is sorted into rows of cells of its own size,
/// as in [`Rows`](crate::Rows), and compared with itself and with every other level. Between two levels, each
/// element of one looks for elements of the other in the rows around it. It looks as far as its own radius
/// plus the largest radius of the other level, and less far along rows that are farther away, but never as
/// far as the largest size of all elements would require.
///
/// A model of the cost, made from the sizes and the extent of the domain, decides where one level ends and
/// the next begins, and which of two levels looks for the other. Neighbouring classes of size (two per
/// octave) are merged into one level as long as that reduces the predicted time.
///
/// # Order
/// Level by level, the smallest first: the couples within the level in the order of [`Rows`](crate::Rows),
/// then those with each larger level. The order is a function of the input alone.
///
/// # Cost
/// Time proportional to N for a given distribution of sizes. Memory per element: that of
/// [`Rows`](crate::Rows), 4 bytes for its number, and `4 D` bytes for the cells of its row if it is alone in
/// the row.
///
/// # Source
/// Levels of linked cells: V. Ogarko, S. Luding, Comput. Phys. Commun. 183 (2012) 931-936. Their optimal
/// choice: D. Krijgsman, V. Ogarko, S. Luding, Comput. Part. Mech. 1 (2014) 357-372. Rows, windows and the
/// model of the cost are our own.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, Multilevel, Search};
///
/// let centres: Vec<[f64; 2]> = (0..1000).map(|k| [f64::from(k), 0.0]).collect();
/// let radii: Vec<f64> = (0..1000).map(|k| if k == 500 { 100.0 } else { 0.1 }).collect();
/// let elements = Elements::spheres_with_radii(&centres, &radii)?;
/// assert_eq!(Multilevel::new().count(&elements)?, 200);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Multilevel<T, const D: usize> {
    /// The sizes at which one level ends and the next begins, if they were given.
    limits: Option<Vec<f64>>,
    sorted: Vec<Sorted<T, D>>,
    /// Couples of each part before they are visited or appended to a list.
    parts: Vec<Vec<Couple>>,
    simd: Available,
    pool: Pool,
}

/// The elements of a level.
#[derive(Clone, Debug)]
struct Sorted<T, const D: usize> {
    numbers: Vec<u32>,
    layout: Layout<T, D>,
}

impl<T: Real, const D: usize> Sorted<T, D> {
    fn new() -> Self {
        Self { numbers: Vec::new(), layout: Layout::new() }
    }

    fn bytes(&self) -> usize {
        self.numbers.capacity() * size_of::<u32>() + self.layout.bytes()
    }
}

impl<T: Real, const D: usize> Default for Multilevel<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> Multilevel<T, D> {
    /// A search that holds no memory yet, with the fastest instructions of this processor.
    pub fn new() -> Self {
        Self {
            limits: None,
            sorted: Vec::new(),
            parts: Vec::new(),
            simd: Available::best(),
            pool: Pool::default(),
        }
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
    /// pool. The couples and their order are the same for any number.
    ///
    /// # Errors
    /// [`Error::NoThreads`] if the threads cannot be started, if there are more than 1024, or if the crate
    /// was built without its feature `rayon`.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?;
        Ok(self)
    }

    /// The same with given levels. The first level holds sizes (diameters, largest edges of boxes) up to the
    /// first of `limits`, the next one sizes up to the next limit, and the last one all others. Empty levels
    /// are left out. The couples are the same; their order differs.
    ///
    /// Each limit is moved up to the next power of two, or 1.5 times a power of two, because classes of sizes
    /// are not split. NaN counts as infinity.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Multilevel};
    ///
    /// let elements = Elements::spheres_with_radii(&[[0.0], [1.0], [2.0]], &[0.1, 0.2, 5.0])?;
    /// let search = Multilevel::new().with_limits(&[1.0]);
    /// assert_eq!(search.levels(&elements).iter().map(|level| level.elements).collect::<Vec<_>>(), [2, 1]);
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    #[must_use]
    pub fn with_limits(mut self, limits: &[f64]) -> Self {
        self.limits = Some(limits.to_vec());
        self
    }

    /// The same on a thread pool that is shared with other engines.
    pub(crate) fn with_pool(mut self, pool: Pool) -> Self {
        self.pool = pool;
        self
    }

    /// The levels that a search over `elements` would use, the smallest elements first.
    pub fn levels(&self, elements: &Elements<'_, T, D>) -> Vec<Level> {
        if elements.is_empty() {
            Vec::new()
        } else {
            Model::new(elements, self.limits.as_deref()).levels().to_vec()
        }
    }

    /// [`Multilevel::levels`] for at least one element, and the predicted time of the search in nanoseconds.
    pub(crate) fn levels_and_cost(&self, elements: &Elements<'_, T, D>) -> (Vec<Level>, f64) {
        let model = Model::new(elements, self.limits.as_deref());
        (model.levels().to_vec(), model.total())
    }

    /// The predicted and the actual work of a search over `elements`. Searches once and counts.
    ///
    /// There is one entry for each level alone and for each pair of levels, in the order of the search.
    ///
    /// # Cost
    /// The time of a count that looks at each candidate once more.
    ///
    /// # Errors
    /// As [`Search::for_each`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Multilevel};
    ///
    /// let centres: Vec<[f64; 2]> = (0..1000).map(|k| [f64::from(k), 0.0]).collect();
    /// let radii: Vec<f64> = (0..1000).map(|k| if k == 500 { 100.0 } else { 0.1 }).collect();
    /// let elements = Elements::spheres_with_radii(&centres, &radii)?;
    /// for work in Multilevel::new().work(&elements)? {
    ///     println!("{:?}: {} of {:.0} candidates", work.levels, work.candidates, work.predicted_candidates);
    /// }
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn work(&mut self, elements: &Elements<'_, T, D>) -> Result<Vec<Work>, Error> {
        if elements.is_empty() {
            return Ok(Vec::new());
        }
        let simd = self.simd;
        let [windows, candidates] = [AtomicU64::new(0), AtomicU64::new(0)];
        let search_row = |task: &Task<'_, T>, out: &mut Output<'_>| {
            let counted = in_windows::<T, D>(task);
            windows.fetch_add(counted[0], Ordering::Relaxed);
            candidates.fetch_add(counted[1], Ordering::Relaxed);
            T::search::<D>(simd, task, out);
        };
        let mut works = Vec::new();
        self.with_scans_by(elements, &search_row, |model, pairs, Scans { each, pool, parts }| {
            for (scan, &[level, other]) in each.iter().zip(pairs) {
                let mut couples = 0;
                let scans = Scans { each: std::slice::from_ref(scan), pool, parts: &mut *parts };
                scans.all(Sink::Count(&mut couples))?;
                let against = (level != other).then(|| &model.levels()[other]);
                let [predicted_windows, predicted_candidates] = model.work(&model.levels()[level], against);
                works.push(Work {
                    levels: [level, other],
                    predicted_windows,
                    windows: windows.swap(0, Ordering::Relaxed),
                    predicted_candidates,
                    candidates: candidates.swap(0, Ordering::Relaxed),
                    couples,
                });
            }
            Ok(())
        })?;
        Ok(works)
    }

    /// Bytes that the engine holds now.
    pub fn bytes(&self) -> usize {
        self.sorted.iter().map(Sorted::bytes).sum::<usize>()
            + self.parts.iter().map(Vec::capacity).sum::<usize>() * size_of::<Couple>()
    }

    /// Upper bound on [`Multilevel::bytes`] after a count of `elements`.
    pub(crate) fn expected_bytes(&self, elements: &Elements<'_, T, D>) -> usize {
        if elements.is_empty() {
            return 0;
        }
        let floats = elements.shape.floats();
        let labels = elements.filter().map_or(0, |filter| Labels::numbers_of(&filter));
        let model = Model::new(elements, self.limits.as_deref());
        let of_level = |level: &Level| {
            let (n, grid) = (level.elements, model.grid(level));
            let rows = rows_of(&grid.cells()).min(n as f64) as usize;
            (n + D * rows) * size_of::<u32>()
                + Layout::<T, D>::expected_bytes(n, floats, labels, &grid, &self.pool)
        };
        model.levels().iter().map(of_level).sum()
    }

    /// Splits the elements by level and sorts each level.
    fn sort(&mut self, elements: &Elements<'_, T, D>, model: &Model<'_, '_, T, D>) -> Result<(), Error> {
        let levels = model.levels();
        let (points, radii): (_, &[T]) = match elements.shape {
            Shape::Equal(equal) => (equal.points(), &[]),
            Shape::Spheres(spheres) => (spheres.points(), spheres.radii()),
            Shape::Boxes(boxes) => (boxes.points(), &[]),
        };
        self.sorted.resize_with(self.sorted.len().max(levels.len()), Sorted::new);
        for (sorted, level) in self.sorted.iter_mut().zip(levels) {
            sorted.numbers.clear();
            reserve(&mut sorted.numbers, level.elements)?;
        }
        for number in 0..elements.len() {
            self.sorted[model.level_of(elements.size(number))].numbers.push(number as u32);
        }
        let mut axes = std::array::from_fn(|axis| axis);
        let cells = model.grid(&levels[0]).cells();
        axes.sort_by_key(|&axis| std::cmp::Reverse(cells[axis]));
        for (sorted, level) in self.sorted.iter_mut().zip(levels) {
            let Sorted { numbers, layout } = sorted;
            layout.build_of(points, radii, numbers.as_slice(), model.grid(level), axes, &self.pool)?;
            layout.keep_cells()?;
            if let Shape::Boxes(boxes) = elements.shape {
                layout.set_far(boxes.far_points(), elements.tolerance(), &self.pool)?;
            }
            layout.label(elements.filter(), &self.pool)?;
        }
        Ok(())
    }
}

/// The work of a search within one level, or between two: see [`Multilevel::work`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Work {
    /// The level whose elements look for others, and the level of these others, as places in
    /// [`Multilevel::levels`]. Both are equal for one level alone.
    pub levels: [usize; 2],
    /// Predicted number of windows that the elements open on rows of cells.
    pub predicted_windows: f64,
    /// Actual number of windows.
    pub windows: u64,
    /// Predicted number of elements in these windows.
    pub predicted_candidates: f64,
    /// Actual number of elements in these windows. Each is compared, or found to be too far away along
    /// another axis.
    pub candidates: u64,
    /// Couples found.
    pub couples: u64,
}

/// The number of windows that the elements of a stretch open, and of elements in them.
fn in_windows<T: Real, const D: usize>(task: &Task<'_, T>) -> [u64; 2] {
    let along = |arrays: &Arrays<'_, T>, row: Span| {
        let start = D * row.start + task.long * row.len;
        start..start + row.len.min(arrays.coordinates.len() - start)
    };
    let own = &task.own.coordinates[along(&task.own, task.row)];
    let mut counted = [0; 2];
    let mut count = |low: T, high: T, others: &[T]| {
        let first = others.partition_point(|&other| other < low);
        let behind = others[first..].partition_point(|&other| other <= high);
        counted[0] += 1;
        counted[1] += behind as u64;
    };
    for (k, &x) in (task.from..).zip(&own[task.from..task.to]) {
        if !task.two_sets {
            count(x, x + task.reach, &own[k + 1..]);
        }
        for neighbour in task.neighbours {
            let low = if neighbour.looks == Looks::Back { x - neighbour.reach } else { x };
            count(low, x + neighbour.reach, &task.other.coordinates[along(&task.other, neighbour.row)]);
        }
    }
    counted
}

compiled!(fn search = Multilevel<T, D>, Multilevel<f64, 2>, Multilevel<f64, 3>: scan_all(Sink<'_>));

impl<T: Real, const D: usize> Scanner<T, D> for Multilevel<T, D> {
    fn search(&mut self, elements: &Elements<'_, T, D>, sink: Sink<'_>) -> Result<(), Error> {
        search(self, elements, sink)
    }

    fn with_scans(
        &mut self,
        elements: &Elements<'_, T, D>,
        search: impl FnOnce(Scans<'_, T, D>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let simd = self.simd;
        let search_row = |task: &Task<'_, T>, out: &mut Output<'_>| T::search::<D>(simd, task, out);
        self.with_scans_by(elements, &search_row, |_, _, scans| search(scans))
    }
}

impl<T: Real, const D: usize> Multilevel<T, D> {
    /// Sorts the levels and passes on the scans, each with its two levels.
    fn with_scans_by(
        &mut self,
        elements: &Elements<'_, T, D>,
        search_row: &(dyn Fn(&Task<'_, T>, &mut Output<'_>) + Sync),
        search: impl FnOnce(&Model<'_, '_, T, D>, &[[usize; 2]], Scans<'_, T, D>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if elements.is_empty() {
            return Ok(());
        }
        let model = Model::new(elements, self.limits.as_deref());
        let levels = model.levels();
        self.sort(elements, &model)?;
        let Self { sorted, parts, pool, .. } = self;
        let filter = elements.filter();
        let (mut scans, mut pairs) = (Vec::new(), Vec::new());
        for (k, level) in levels.iter().enumerate() {
            for (l, larger) in levels.iter().enumerate().skip(k) {
                let (own, other) = if model.looks(level, larger) { (k, l) } else { (l, k) };
                let (layout, against) = (&sorted[own].layout, &sorted[other].layout);
                pairs.push([own, other]);
                scans.push(Scan {
                    layout,
                    against: (k != l).then_some(against),
                    arrays: [layout.arrays(filter), against.arrays(filter)],
                    reach: T::at_least(model.reach(level, larger).max(T::MIN_RESOLVED)),
                    reach_squared: if let Shape::Equal(equal) = elements.shape {
                        equal.reach_squared()
                    } else {
                        T::ZERO
                    },
                    tolerance: elements.tolerance(),
                    largest: 0.5 * levels[own].largest,
                    one_numbering: true,
                    part: model.part(&levels[own], &levels[other]),
                    search_row,
                });
            }
        }
        search(&model, &pairs, Scans { each: &scans, pool, parts })
    }
}

impl<T: Real, const D: usize> Search<T, D> for Multilevel<T, D> {
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
