//! NBS on contiguous memory: sorted rows, a moving window, and vectors.

mod axis;
mod block_sort;
mod cursor;
mod keys;
pub(crate) mod layout;
pub(crate) mod reach;
mod scatter;

use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::Labels;
use crate::grid::Grid;
use crate::ordered;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::{Search, make_room};
use crate::simd::kernel::{Arrays, Neighbour, Output, Span, Task};
use crate::simd::{Simd, has_vectors, portable};

use cursor::{Cursor, half_mask};
use layout::Layout;
pub(crate) use layout::{reserve, resize};
use reach::RowsInReach;

/// The decomposition and the contact mask of Munjiza-NBS, on sorted rows instead of lists: the default engine.
///
/// Elements are sorted by row of cells and, inside a row, by coordinate along it, the axis with the most cells. The lists of NBS
/// become runs of contiguous memory; rows without elements do not exist. A row is compared with itself and with the half mask of neighbour
/// rows (1 in 2D, 4 in 3D, `(3^(D-1) - 1)/2`). Because rows are sorted, an element's candidates in a neighbour row
/// are one window, whose lower end only moves forward; vectors of coordinates are tested at once, with
/// AVX-512, AVX2 or NEON where the processor has them, where it pays those of four elements in 32 bits first. All levels give the same couples in
/// the same order, by the comparison of [`Elements`].
/// ```text
///   row below   . . [ x x x x x ] . . .      |x_j - x_i| <= reach
///   own row     . . . . i [ x x x ] . .      j > i
/// ```
///
/// # Order
/// Rows ascend by cell, the axis with the most cells left out; elements ascend along their row; the partners of an element are first those in
/// its own row, then those in the rows of the mask, each ascending. A function of the input alone.
///
/// # Cost
/// Time proportional to N for similar sizes: some tens of nanoseconds per element and core. Memory per
/// element: `D` coordinates, and the radius if there is one for each; 4 bytes of id; 2 of the bin; at most 8 of row starts. In 3D and `f64` 30 to
/// 38 bytes, and 8 more with radii; with a [`Filter`](crate::Filter) 4 to 12 more. Besides, each thread sorts a block of rows at a time in memory of
/// its own: some hundred kilobytes, or 50 bytes for each element of a row if one row has more. Nothing grows with the domain.
///
/// # Source
/// The decomposition: A. Munjiza, K.R.F. Andrews, Int. J. Numer. Meth. Engng 43 (1998) 131-149. Rows, windows and vectors are ours.
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
    /// Couples of each part, on their way to a visitor or into a list.
    parts: Vec<Vec<Couple>>,
    simd: Simd,
    pool: Pool,
}

/// Elements of one part of the work: enough to forget its start, few enough for its couples to stay in cache.
pub(crate) const PART: usize = 4096;

/// Parts that each thread has in a batch.
const PARTS_AT_ONCE: usize = 8;

/// Room for couples to begin with: they stay in the first-level cache.
pub(crate) const FIRST_ROOM: usize = 1024;

impl<T: Real, const D: usize> Default for Rows<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> Rows<T, D> {
    /// A search that holds no memory yet, with the fastest instructions of this processor.
    pub fn new() -> Self {
        Self { layout: Layout::new(), parts: Vec::new(), simd: Simd::best(), pool: Pool::default() }
    }

    /// The same with other vector instructions; the couples and their order are the same.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks them.
    pub fn with_simd(mut self, simd: Simd) -> Result<Self, Error> {
        if !simd.is_available() {
            return Err(Error::SimdUnavailable { simd });
        }
        self.simd = simd;
        Ok(self)
    }

    /// The same on `threads` threads; 0 is one for each processor, 1 is the default and uses no pool. The couples and their order are
    /// the same for any number.
    ///
    /// # Errors
    /// [`Error::NoThreads`] if they cannot be had, above 1024, or if the crate was built without its feature `rayon`.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?;
        Ok(self)
    }

    /// The same on threads that others use too.
    pub(crate) fn with_pool(mut self, pool: Pool) -> Self {
        self.pool = pool;
        self
    }

    /// Bytes that the engine holds now.
    pub fn bytes(&self) -> usize {
        self.layout.bytes() + self.parts.iter().map(Vec::capacity).sum::<usize>() * size_of::<Couple>()
    }

    /// What [`Rows::bytes`] will be after a count of `elements`, from above.
    pub(crate) fn expected_bytes(&self, elements: &Elements<'_, T, D>) -> usize {
        let n = elements.len();
        if n == 0 {
            return 0;
        }
        let has_radii = matches!(elements.shape, Shape::Spheres(_));
        let labels = match elements.shape {
            Shape::Boxes(_) => 0,
            _ => elements.filter().map_or(0, |filter| Labels::numbers_of(&filter)),
        };
        Layout::<T, D>::expected_bytes(n, has_radii, labels, &self.plan(elements), &self.pool)
    }

    /// Number of threads that a search uses.
    pub(crate) fn threads(&self) -> usize {
        self.pool.threads()
    }

    /// The vector instructions that a search over `elements` uses: boxes are compared without, and dimensions other than 2 and 3.
    pub(crate) fn simd_for(&self, elements: &Elements<'_, T, D>) -> Simd {
        let vectors = has_vectors(D) && !matches!(elements.shape, Shape::Boxes(_));
        if vectors { self.simd } else { Simd::Portable }
    }

    /// The cells that a search over `elements` would use.
    pub fn plan(&self, elements: &Elements<'_, T, D>) -> Grid<D> {
        Grid::unbounded(elements)
    }

    /// Folds the couples on all threads, without a list: `visit` sees every couple once, with the state of its part.
    ///
    /// The elements are cut into parts, of which each begins with a state from `start`; the states are returned in
    /// the order of the parts. The parts do not depend on the number of threads, and so a sum over the states does not either.
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

    /// As [`Rows::fold`], a block of couples at a time: so many as stay in the first-level cache.
    pub(crate) fn fold_blocks<S: Send>(
        &mut self,
        elements: &Elements<'_, T, D>,
        start: impl Fn() -> S,
        visit: impl Fn(&mut S, &[Couple]) + Sync,
    ) -> Result<Vec<S>, Error> {
        let mut states: Vec<S> = (0..elements.len().div_ceil(PART)).map(|_| start()).collect();
        self.with_layout(elements, |scan, pool, _| {
            pool.run(states.iter_mut().zip(scan.ranges()), |(state, range)| {
                let mut waiting = Vec::with_capacity(FIRST_ROOM);
                let mut take = |found: &mut Vec<Couple>| {
                    visit(state, found);
                    found.clear();
                };
                scan.part(range, &mut waiting, &mut take);
                take(&mut waiting);
            });
            Ok(())
        })?;
        Ok(states)
    }

    /// Calls `visit` with all couples in their order, a block at a time.
    pub(crate) fn for_each_block(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(&[Couple]),
    ) -> Result<(), Error> {
        self.search(elements, Sink::Visit(&mut visit))
    }

    /// Appends what `convert` makes of each block of couples to `list`, in their order, on all threads; `parts` is memory for that.
    pub(crate) fn append_converted<V: Copy + Send + Sync>(
        &mut self,
        elements: &Elements<'_, T, D>,
        convert: impl Fn(&[Couple], &mut Vec<V>) -> Result<(), Error> + Sync,
        parts: &mut Vec<Vec<V>>,
        list: &mut Vec<V>,
    ) -> Result<(), Error> {
        self.with_layout(elements, |scan, pool, _| {
            let one_part = |range: Range<usize>, list: &mut Vec<V>| {
                let mut waiting = Vec::new();
                waiting.try_reserve(FIRST_ROOM).map_err(|_| out_of_memory(FIRST_ROOM))?;
                let mut room = Ok(());
                let mut take = |found: &mut Vec<Couple>| {
                    if room.is_ok() {
                        room = convert(found, list);
                    }
                    found.clear();
                };
                scan.part(range, &mut waiting, &mut take);
                take(&mut waiting);
                room
            };
            if pool.threads() == 1 {
                return one_part(0..scan.layout.len(), list);
            }
            let fill = |part, list: &mut Vec<V>| one_part(scan.range(part), list);
            ordered::append(list, scan.parts(), fill, pool, parts)
        })
    }

    fn search(&mut self, elements: &Elements<'_, T, D>, sink: Sink<'_>) -> Result<(), Error> {
        self.with_layout(elements, |scan, pool, parts| scan.all(pool, parts, sink))
    }

    /// Sorts the elements, and hands over what a search of their rows needs.
    fn with_layout(
        &mut self,
        elements: &Elements<'_, T, D>,
        search: impl FnOnce(&Scan<'_, T, D>, &Pool, &mut Vec<Vec<Couple>>) -> Result<(), Error>,
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
        // Boxes are compared by `Elements::touch`, filter and all.
        let filter = elements.filter().filter(|_| !matches!(elements.shape, Shape::Boxes(_)));
        layout.label(filter, pool)?;
        let ids = &layout.ids;
        let spheres = |task: &Task<'_, T, D>, out: &mut Output<'_>| T::search(simd, task, out);
        let boxes = |task: &Task<'_, T, D>, out: &mut Output<'_>| {
            portable::scan(task, out, |row, k, other, j| {
                elements.touch(ids[row.start + k] as usize, ids[other.start + j] as usize)
            });
        };
        let scan = Scan {
            layout,
            against: None,
            arrays: [layout.arrays(filter); 2],
            reach: T::at_least(elements.reach().max(T::MIN_RESOLVED)),
            reach_squared: if let Shape::Equal(equal) = elements.shape {
                equal.reach_squared()
            } else {
                T::ZERO
            },
            tolerance: elements.tolerance(),
            search_row: if matches!(elements.shape, Shape::Boxes(_)) { &boxes } else { &spheres },
        };
        search(&scan, pool, parts)
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

/// What becomes of the couples.
pub(crate) enum Sink<'a> {
    List(&'a mut Vec<Couple>),
    /// A block at a time.
    Visit(&'a mut dyn FnMut(&[Couple])),
    Count(&'a mut u64),
}

/// A search over sorted rows.
pub(crate) struct Scan<'a, T, const D: usize> {
    pub(crate) layout: &'a Layout<T, D>,
    /// The other set, if there are two, with the same axes.
    pub(crate) against: Option<&'a Layout<T, D>>,
    /// What the kernel reads of the first and of the other set (of one set twice); radii in both or in none.
    pub(crate) arrays: [Arrays<'a, T>; 2],
    pub(crate) reach: T,
    pub(crate) reach_squared: T,
    pub(crate) tolerance: T,
    pub(crate) search_row: &'a (dyn Fn(&Task<'_, T, D>, &mut Output<'_>) + Sync),
}

impl<T: Real, const D: usize> Scan<'_, T, D> {
    /// The number of parts of the work.
    fn parts(&self) -> usize {
        self.layout.len().div_ceil(PART)
    }

    /// A part of the work: a stretch of elements in row order.
    fn range(&self, part: usize) -> Range<usize> {
        part * PART..self.layout.len().min((part + 1) * PART)
    }

    /// All parts.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        (0..self.parts()).map(|part| self.range(part))
    }

    /// Searches all rows on the threads of `pool`.
    ///
    /// For a visitor parts are searched at the same time and visited in their order, a batch after the other, so that couples wait in cache.
    pub(crate) fn all(&self, pool: &Pool, parts: &mut Vec<Vec<Couple>>, sink: Sink<'_>) -> Result<(), Error> {
        let n = self.layout.len();
        match sink {
            Sink::Count(count) => {
                let total = AtomicU64::new(0);
                pool.run(self.ranges(), |range| {
                    let (couples, make_room) = (&mut Vec::new(), &mut |_: &mut _| {});
                    let mut out = Output::new(couples, make_room);
                    out.count_only = true;
                    self.rows(range, &mut out);
                    total.fetch_add(out.count, Ordering::Relaxed);
                });
                *count = total.into_inner();
                Ok(())
            }
            Sink::List(couples) if pool.threads() == 1 => self.list(0..n, couples),
            Sink::Visit(visit) if pool.threads() == 1 => {
                parts.resize_with(parts.len().max(1), Vec::new);
                let waiting = &mut parts[0];
                waiting.try_reserve(FIRST_ROOM).map_err(|_| out_of_memory(FIRST_ROOM))?;
                let mut take = |found: &mut Vec<Couple>| {
                    visit(found);
                    found.clear();
                };
                self.part(0..n, waiting, &mut take);
                take(waiting);
                Ok(())
            }
            Sink::List(couples) => {
                let fill = |part, list: &mut Vec<Couple>| self.list(self.range(part), list);
                ordered::append(couples, self.parts(), fill, pool, parts)
            }
            Sink::Visit(visit) => {
                let batch = PARTS_AT_ONCE * pool.threads();
                parts.resize_with(parts.len().max(batch), Vec::new);
                for first in (0..self.parts()).step_by(batch) {
                    let numbers = first..self.parts().min(first + batch);
                    let failed = OnceLock::new();
                    pool.run(parts.iter_mut().zip(numbers.clone()), |(part, number)| {
                        part.clear();
                        if let Err(error) = self.list(self.range(number), part) {
                            failed.get_or_init(|| error);
                        }
                    });
                    if let Some(error) = failed.into_inner() {
                        return Err(error);
                    }
                    parts[..numbers.len()].iter().for_each(|part| visit(part));
                }
                Ok(())
            }
        }
    }

    /// Appends the couples of a stretch to a list.
    fn list(&self, range: Range<usize>, couples: &mut Vec<Couple>) -> Result<(), Error> {
        couples.try_reserve(FIRST_ROOM).map_err(|_| out_of_memory(FIRST_ROOM))?;
        let mut room = Ok(());
        self.part(range, couples, &mut |found| grow(found, &mut room));
        room
    }

    /// Writes the couples whose first elements are at the places `range` of the order.
    pub(crate) fn part(
        &self,
        range: Range<usize>,
        couples: &mut Vec<Couple>,
        make_room: &mut dyn FnMut(&mut Vec<Couple>),
    ) {
        self.rows(range, &mut Output::new(couples, make_room));
    }

    pub(crate) fn rows(&self, range: Range<usize>, out: &mut Output<'_>) {
        match self.against {
            None => self.rows_of_one_set(range, out),
            Some(other) => self.rows_of_two_sets(other, range, out),
        }
    }

    fn rows_of_one_set(&self, range: Range<usize>, out: &mut Output<'_>) {
        let layout = self.layout;
        let first = layout.row_of(range.start);
        let mut cursors: Vec<_> =
            half_mask::<D>().into_iter().map(|offset| Cursor::new(layout, offset, first)).collect();
        let mut neighbours = Vec::with_capacity(cursors.len());
        for (row, places, stretch) in self.stretches(&range) {
            let low = layout.along(&places)[stretch.start] - self.reach;
            let cells = layout.row_cells(row);
            neighbours.clear();
            for row in cursors.iter_mut().filter_map(|cursor| cursor.find(layout, &cells)) {
                let row = layout.row(row);
                let low =
                    if stretch.start == 0 { 0 } else { layout.along(&row).partition_point(|&x| x < low) };
                neighbours.push(Neighbour { row: Span { start: row.start, len: row.len() }, low });
            }
            self.stretch(&places, stretch, &neighbours, out);
        }
    }

    fn rows_of_two_sets(&self, other: &Layout<T, D>, range: Range<usize>, out: &mut Output<'_>) {
        let mut rows = RowsInReach::new(other);
        let mut neighbours = Vec::new();
        for (_, places, stretch) in self.stretches(&range) {
            let along = &self.layout.along(&places)[stretch.clone()];
            let (low, high) = (along[0] - self.reach, along[along.len() - 1] + self.reach);
            neighbours.clear();
            let [min, max] = self.layout.extremes(&places, &stretch);
            rows.find(&min, &max, self.reach.to_f64(), |row| {
                let row = other.row(row);
                let along = other.along(&row);
                let low = along.partition_point(|&x| x < low);
                if low < row.len() && along[low] <= high {
                    neighbours.push(Neighbour { row: Span { start: row.start, len: row.len() }, low });
                }
                true
            });
            if !neighbours.is_empty() {
                self.stretch(&places, stretch, &neighbours, out);
            }
        }
    }

    /// The rows that have places in `range`: each with its places, and those of them that are inside, counted from its start.
    pub(crate) fn stretches(
        &self,
        range: &Range<usize>,
    ) -> impl Iterator<Item = (usize, Range<usize>, Range<usize>)> + use<'_, T, D> {
        let (layout, range) = (self.layout, range.clone());
        let rows = (layout.row_of(range.start)..layout.rows()).map(|row| (row, layout.row(row)));
        rows.take_while(move |(_, places)| places.start < range.end).map(move |(row, places)| {
            let from = range.start.max(places.start) - places.start;
            let to = range.end.min(places.end) - places.start;
            (row, places, from..to)
        })
    }

    /// Compares a stretch of a row with `neighbours`, and in one set with the rest of its row.
    pub(crate) fn stretch(
        &self,
        places: &Range<usize>,
        stretch: Range<usize>,
        neighbours: &[Neighbour],
        out: &mut Output<'_>,
    ) {
        let task = Task {
            own: self.arrays[0],
            other: self.arrays[1],
            two_sets: self.against.is_some(),
            row: Span { start: places.start, len: places.len() },
            from: stretch.start,
            to: stretch.end,
            neighbours,
            long: self.layout.axes[0],
            reach: self.reach,
            reach_squared: self.reach_squared,
            tolerance: self.tolerance,
            spread: if self.against.is_some() { f64::INFINITY } else { 2.1 * self.layout.grid.cell_size() },
        };
        (self.search_row)(&task, out);
    }
}

/// Doubles the room for couples; without memory for that, what was found is given up, and `room` says so.
fn grow(found: &mut Vec<Couple>, room: &mut Result<(), Error>) {
    if room.is_ok() {
        *room = make_room(found);
    }
    if room.is_err() {
        // The search goes on into memory that it has; its result is refused.
        found.clear();
    }
}

pub(crate) fn out_of_memory(couples: usize) -> Error {
    Error::OutOfMemory { bytes: couples.saturating_mul(size_of::<Couple>()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{Filter, GroupMatrix};
    use crate::simd::Kernels;

    /// Points from 0 to `width` on each axis.
    fn scattered<const D: usize>(n: usize, width: f64, seed: u64) -> Vec<[f64; D]> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1_u64 << 24) as f64 * width
        };
        (0..n).map(|_| std::array::from_fn(|_| next())).collect()
    }

    /// The rows of one layout against those of another, whose cells are of another size than the reach, and elsewhere.
    fn two_layouts<const D: usize>(cell: f64, reach: f64, shift: f64) -> usize {
        let (mut moving, fixed) = (scattered::<D>(300, 6.0, 1), scattered::<D>(400, 7.0, 2));
        moving.iter_mut().flatten().for_each(|x| *x += shift);
        let pool = Pool::default();
        let (mut own, mut other) = (Layout::new(), Layout::new());
        let grid = Grid::unbounded(&Elements::points(&fixed, cell).unwrap());
        other.build(&fixed, &[], grid, &pool).unwrap();
        let elements = Elements::points(&moving, reach).unwrap();
        own.build_along(&moving, &[], grid.over(elements.bounds()), other.axes, &pool).unwrap();

        let squares =
            |a: &[f64; D], b: &[f64; D]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let mut expected = Vec::new();
        for (i, a) in moving.iter().enumerate() {
            let touching = fixed.iter().enumerate().filter(|(_, b)| squares(a, b) <= reach * reach);
            expected.extend(touching.map(|(j, _)| Couple { i: i as u32, j: j as u32 }));
        }
        let numbers = |n: u32, number: fn(u32) -> u32| -> Vec<u32> { (0..n).map(number).collect() };
        let numbered = |n| {
            let groups = numbers(n, |k| k * 7 % 40);
            (numbers(n, |k| k % 5), numbers(n, |k| 1 << (k % 3)), numbers(n, |k| 3 << (k % 2)), groups)
        };
        let (ours, theirs) = (numbered(300), numbered(400));
        let mut matrix = GroupMatrix::all(40).unwrap();
        (0..40).for_each(|group| matrix.set(group, group / 2, false).unwrap());
        let filters = |kind: usize| {
            [&ours, &theirs].map(|(bodies, categories, masks, groups)| match kind {
                0 => None,
                1 => Some(Filter::bodies(bodies)),
                2 => Some(Filter::masks(categories, masks)),
                _ => Some(Filter::groups(groups, &matrix).with_bodies(bodies)),
            })
        };
        let mut order = Vec::new();
        for (kind, simd) in
            (0..4).flat_map(|kind| Simd::available().into_iter().map(move |simd| (kind, simd)))
        {
            let filters = filters(kind);
            own.label(filters[0], &pool).unwrap();
            other.label(filters[1], &pool).unwrap();
            let mut expected = expected.clone();
            expected.retain(|&Couple { i, j }| match filters {
                [Some(ours), Some(theirs)] => ours.admits_of(i as usize, &theirs, j as usize),
                _ => true,
            });
            let search_row = |task: &Task<'_, f64, D>, out: &mut Output<'_>| f64::search(simd, task, out);
            let scan = Scan {
                layout: &own,
                against: Some(&other),
                arrays: [own.arrays(filters[0]), other.arrays(filters[1])],
                reach: elements.reach(),
                reach_squared: reach * reach,
                tolerance: 0.0,
                search_row: &search_row,
            };
            let mut couples = Vec::new();
            scan.all(&pool, &mut Vec::new(), Sink::List(&mut couples)).unwrap();
            if simd == Simd::Portable {
                order.clone_from(&couples);
            }
            assert_eq!(order, couples, "{simd}: the order");
            couples.sort_unstable();
            assert_eq!(couples, expected, "{simd}, filter {kind}, cell {cell}, reach {reach}, shift {shift}");
            let mut count = 0;
            scan.all(&pool, &mut Vec::new(), Sink::Count(&mut count)).unwrap();
            assert_eq!(count, expected.len() as u64);
        }
        expected.len()
    }

    #[test]
    fn rows_of_one_layout_against_those_of_another() {
        for shift in [0.0, -3.3, 5.9] {
            for (cell, reach) in [(1.0, 1.0), (0.3, 1.1), (2.0, 0.4), (0.01, 0.5), (1.0, 20.0)] {
                let found = [
                    two_layouts::<1>(cell, reach, shift),
                    two_layouts::<2>(cell, reach, shift),
                    two_layouts::<3>(cell, reach, shift),
                ];
                assert!(found[0] > 0 && found[1] > 0);
            }
        }
        assert_eq!(two_layouts::<2>(1.0, 1.0, 1e9), 0);
        assert_eq!(two_layouts::<2>(1.0, 1.0, -1e15), 0);
    }
}
