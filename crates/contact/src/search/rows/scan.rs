//! Searches over sorted rows, in parts, on all threads.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::couple::Couple;
use crate::elements::Elements;
use crate::error::Error;
use crate::ordered;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::make_room;
use crate::search::rows::cursor::{Cursor, half_mask};
use crate::search::rows::layout::Layout;
use crate::search::rows::reach::RowsInReach;
use crate::simd::prefetch;
use crate::simd::task::{Arrays, Looks, Neighbour, Output, Span, Task};

/// Elements in one part of the work, if all have similar numbers of partners. Enough to outweigh the start of
/// a part, few enough for its couples to stay in cache.
pub(crate) const PART: usize = if cfg!(miri) { 64 } else { 4096 };

/// Number of parts per thread in a batch.
const PARTS_AT_ONCE: usize = 8;

/// Number of elements before and behind an estimated place that are prefetched.
const NEAR: usize = 16;

/// First capacity for couples: they stay in the first-level cache.
pub(crate) const FIRST_ROOM: usize = if cfg!(miri) { 32 } else { 1024 };

/// A search that sorts elements into rows.
pub(crate) trait Scanner<T: Real, const D: usize> {
    /// Sorts the elements and passes the scans to `search`, which need not be called if there are no
    /// elements.
    fn with_scans(
        &mut self,
        elements: &Elements<'_, T, D>,
        search: impl FnOnce(Scans<'_, T, D>) -> Result<(), Error>,
    ) -> Result<(), Error>;

    /// Runs all scans in their order, by code that is compiled with this crate if it has the types.
    fn search(&mut self, elements: &Elements<'_, T, D>, sink: Sink<'_>) -> Result<(), Error>;

    /// [`Scanner::search`] by code that is compiled where it is called.
    fn scan_all(&mut self, elements: &Elements<'_, T, D>, sink: Sink<'_>) -> Result<(), Error> {
        self.with_scans(elements, |scans| scans.all(sink))
    }

    /// Calls `visit` with all couples in their order, a block at a time.
    fn for_each_block(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(&[Couple]),
    ) -> Result<(), Error> {
        self.search(elements, Sink::Visit(&mut visit))
    }

    /// Appends the result of `convert` for each block of couples to `list`, in their order, on all threads.
    /// `parts` is working memory.
    fn append_converted<V: Copy + Send + Sync>(
        &mut self,
        elements: &Elements<'_, T, D>,
        convert: impl Fn(&[Couple], &mut Vec<V>) -> Result<(), Error> + Sync,
        parts: &mut Vec<Vec<V>>,
        list: &mut Vec<V>,
    ) -> Result<(), Error> {
        self.with_scans(elements, |scans| {
            let fill = |scan: &Scan<'_, T, D>, range, list: &mut Vec<V>| {
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
            append(scans.each, fill, scans.pool, parts, list)
        })
    }

    /// Folds the couples on all threads, in blocks of couples that stay in the first-level cache.
    fn fold_blocks<S: Send>(
        &mut self,
        elements: &Elements<'_, T, D>,
        start: impl Fn() -> S,
        visit: impl Fn(&mut S, &[Couple]) + Sync,
    ) -> Result<Vec<S>, Error> {
        let mut states = Vec::new();
        self.with_scans(elements, |scans| {
            let parts = parts(scans.each);
            states.extend(parts.iter().map(|_| start()));
            scans.pool.run(states.iter_mut().zip(parts), |(state, (scan, range))| {
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
}

/// Where the couples go.
pub(crate) enum Sink<'a> {
    List(&'a mut Vec<Couple>),
    /// Visits a block of couples at a time.
    Visit(&'a mut dyn FnMut(&[Couple])),
    Count(&'a mut u64),
}

/// The scans of a search, to be run one after the other.
pub(crate) struct Scans<'a, T, const D: usize> {
    pub(crate) each: &'a [Scan<'a, T, D>],
    pub(crate) pool: &'a Pool,
    /// Working memory for couples before they are visited or appended to a list.
    pub(crate) parts: &'a mut Vec<Vec<Couple>>,
}

impl<T: Real, const D: usize> Scans<'_, T, D> {
    /// Runs all scans on all threads.
    pub(crate) fn all(self, sink: Sink<'_>) -> Result<(), Error> {
        let Self { each: scans, pool, parts: memory } = self;
        match sink {
            Sink::Count(count) => {
                let total = AtomicU64::new(0);
                pool.run(parts(scans).into_iter(), |(scan, range)| {
                    let (couples, make_room) = (&mut Vec::new(), &mut |_: &mut _| {});
                    let mut out = Output::new(couples, make_room);
                    out.count_only = true;
                    scan.rows(range, &mut out);
                    total.fetch_add(out.count, Ordering::Relaxed);
                });
                *count = total.into_inner();
                Ok(())
            }
            Sink::List(couples) => append(scans, Scan::list, pool, memory, couples),
            Sink::Visit(visit) if pool.threads() == 1 => {
                memory.resize_with(memory.len().max(1), Vec::new);
                let waiting = &mut memory[0];
                waiting.try_reserve(FIRST_ROOM).map_err(|_| out_of_memory(FIRST_ROOM))?;
                waiting.clear();
                let mut take = |found: &mut Vec<Couple>| {
                    visit(found);
                    found.clear();
                };
                for (scan, range) in stretches(scans, pool) {
                    pool.stop().go_on()?;
                    scan.part(range, waiting, &mut take);
                }
                take(waiting);
                Ok(())
            }
            Sink::Visit(visit) => {
                // The parts of a batch are searched at the same time and visited in their order, batch by
                // batch, so that couples stay in cache.
                for batch in parts(scans).chunks(PARTS_AT_ONCE * pool.threads()) {
                    pool.stop().go_on()?;
                    memory.resize_with(memory.len().max(batch.len()), Vec::new);
                    pool.try_run(memory.iter_mut().zip(batch), |(couples, (scan, range))| {
                        couples.clear();
                        scan.list(range.clone(), couples)
                    })?;
                    memory[..batch.len()].iter().for_each(|couples| visit(couples));
                }
                Ok(())
            }
        }
    }
}

/// The parts of the work in the order of their couples. They do not depend on the number of threads.
fn parts<'s, 'a, T: Real, const D: usize>(
    scans: &'s [Scan<'a, T, D>],
) -> Vec<(&'s Scan<'a, T, D>, Range<usize>)> {
    scans.iter().flat_map(|scan| scan.ranges().map(move |range| (scan, range))).collect()
}

/// The same in as few parts as possible: one thread that cannot be stopped does each scan as one part.
fn stretches<'s, 'a, T: Real, const D: usize>(
    scans: &'s [Scan<'a, T, D>],
    pool: &Pool,
) -> Vec<(&'s Scan<'a, T, D>, Range<usize>)> {
    if pool.threads() == 1 && !pool.stop().is_possible() {
        return scans.iter().map(|scan| (scan, 0..scan.layout.len())).collect();
    }
    parts(scans)
}

/// Appends the results of `fill` for each part to `list`, in their order.
fn append<'a, T: Real, V: Copy + Send, const D: usize>(
    scans: &[Scan<'a, T, D>],
    fill: impl Fn(&Scan<'a, T, D>, Range<usize>, &mut Vec<V>) -> Result<(), Error> + Sync,
    pool: &Pool,
    memory: &mut Vec<Vec<V>>,
    list: &mut Vec<V>,
) -> Result<(), Error> {
    let parts = stretches(scans, pool);
    let fill = |part: usize, list: &mut Vec<V>| {
        pool.stop().go_on()?;
        fill(parts[part].0, parts[part].1.clone(), list)
    };
    if pool.threads() == 1 {
        return (0..parts.len()).try_for_each(|part| fill(part, list));
    }
    ordered::append(list, parts.len(), fill, pool, memory)
}

/// The rows of one layout, to be compared with each other or with the rows of another layout.
pub(crate) struct Scan<'a, T, const D: usize> {
    pub(crate) layout: &'a Layout<T, D>,
    /// The other layout, with the same axes, if two sets are compared.
    pub(crate) against: Option<&'a Layout<T, D>>,
    /// The arrays that the kernel reads, of the first and of the other set (twice the same for one set). Both
    /// have radii or neither.
    pub(crate) arrays: [Arrays<'a, T>; 2],
    pub(crate) reach: T,
    pub(crate) reach_squared: T,
    pub(crate) tolerance: T,
    /// The largest radius of the first set; meaningless without radii.
    pub(crate) largest: f64,
    /// Whether both sets are parts of one set; then the smaller number of a couple comes first.
    pub(crate) one_numbering: bool,
    /// Elements in one part of the work.
    pub(crate) part: usize,
    pub(crate) search_row: &'a (dyn Fn(&Task<'_, T>, &mut Output<'_>) + Sync),
}

impl<T: Real, const D: usize> Scan<'_, T, D> {
    /// The parts of the work: ranges of places in row order.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = Range<usize>> + use<'_, T, D> {
        let n = self.layout.len();
        (0..n).step_by(self.part).map(move |start| start..n.min(start + self.part))
    }

    /// Appends the couples of a range of places to a list.
    fn list(&self, range: Range<usize>, couples: &mut Vec<Couple>) -> Result<(), Error> {
        couples.try_reserve(FIRST_ROOM).map_err(|_| out_of_memory(FIRST_ROOM))?;
        let mut room = Ok(());
        self.part(range, couples, &mut |found| grow(found, &mut room));
        room
    }

    /// Writes the couples whose first elements are at the places `range`.
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
        let cursor = |offset| Cursor::new(layout, offset, first);
        let mut cursors = Vec::new();
        if layout.looks_ahead(self.reach) {
            for offset in half_mask::<D>() {
                cursors.push((cursor(offset), Looks::Ahead));
                cursors.push((cursor(offset.map(|step| -step)), Looks::Beyond));
            }
        } else {
            cursors.extend(half_mask::<D>().into_iter().map(|offset| (cursor(offset), Looks::Back)));
        }
        let mut neighbours = Vec::with_capacity(cursors.len());
        for (row, places, stretch) in self.stretches(&range) {
            let x = layout.along(&places)[stretch.start];
            let cells = layout.row_cells(row);
            neighbours.clear();
            for (cursor, looks) in &mut cursors {
                let Some(row) = cursor.find(layout, &cells) else { continue };
                let row = layout.row(row);
                let low = if *looks == Looks::Back { x - self.reach } else { x };
                let low =
                    if stretch.start == 0 { 0 } else { layout.along(&row).partition_point(|&x| x < low) };
                let row = Span { start: row.start, len: row.len() };
                neighbours.push(Neighbour { row, low, looks: *looks, reach: self.reach });
            }
            self.stretch(&places, stretch, &neighbours, out);
        }
    }

    fn rows_of_two_sets(&self, other: &Layout<T, D>, range: Range<usize>, out: &mut Output<'_>) {
        let mut rows = RowsInReach::new(other);
        let mut neighbours = Vec::new();
        // Spheres of levels have unlike sizes, each with its own reach.
        let alone = self.one_numbering && self.arrays[0].far.is_empty();
        let far = if alone { T::ZERO } else { self.reach + self.reach };
        for (_, places, stretch) in self.stretches(&range) {
            let whole = self.layout.along(&places);
            for piece in Self::pieces(whole, stretch, far) {
                let along = &whole[piece.clone()];
                let (first, last) = (along[0], along[along.len() - 1]);
                neighbours.clear();
                let [min, max] = self.layout.extremes(&places, &piece);
                let reach = self.reach_of(&places, &piece);
                // All rows are found, and the data needed from them is prefetched, before the first is read.
                rows.find_around(&min, &max, reach, self.arrays[0].far.is_empty(), |row, reach| {
                    let (row, reach) = (other.row(row), T::at_least(reach));
                    let low = other.guess(&row, first - reach);
                    self.ask_for(&row, low);
                    let row = Span { start: row.start, len: row.len() };
                    neighbours.push(Neighbour { row, low, looks: Looks::Back, reach });
                });
                neighbours.retain_mut(|Neighbour { row, low, reach, .. }| {
                    let along = other.along(&(row.start..row.start + row.len));
                    *low = first_near(along, first - *reach, *low);
                    *low < row.len && along[*low] <= last + *reach
                });
                if !neighbours.is_empty() {
                    self.stretch(&places, piece, &neighbours, out);
                }
            }
        }
    }

    /// Prefetches the data of the other set that the kernel reads near one place in a row.
    fn ask_for(&self, row: &Range<usize>, element: usize) {
        let theirs = &self.arrays[1];
        let first = element.saturating_sub(NEAR);
        for axis in 0..D {
            prefetch::lines(theirs.coordinates, D * row.start + axis * row.len() + first, 2 * NEAR);
        }
        prefetch::lines(theirs.radii, row.start + first, 2 * NEAR);
        prefetch::lines(theirs.ids, row.start + first, 2 * NEAR);
    }

    /// The reach of the elements of a stretch, which may be smaller than that of their set.
    ///
    /// Subtracting the difference of radii leaves slightly more than needed, because the margin for rounding
    /// was made for larger numbers.
    fn reach_of(&self, places: &Range<usize>, stretch: &Range<usize>) -> f64 {
        let reach = self.reach.to_f64();
        match self.layout.radii(places).get(stretch.clone()) {
            None => reach,
            Some(radii) => {
                let largest = radii.iter().fold(0.0, |largest, radius| f64::max(largest, radius.to_f64()));
                reach - (self.largest - largest)
            }
        }
    }

    /// Cuts a stretch of a row at gaps longer than `far`. A short piece has fewer rows around it, and the gap
    /// is not searched.
    fn pieces(
        along: &[T],
        stretch: Range<usize>,
        far: T,
    ) -> impl Iterator<Item = Range<usize>> + use<'_, T, D> {
        let mut start = stretch.start;
        along[stretch].chunk_by(move |&x, &next| next - x <= far).map(move |piece| {
            start += piece.len();
            start - piece.len()..start
        })
    }

    /// The rows that have places in `range`: the number of the row, its places, and the part of it inside
    /// `range`, counted from its start.
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

    /// Compares a stretch of a row with `neighbours` and, if there is one set, with the rest of its row.
    pub(crate) fn stretch(
        &self,
        places: &Range<usize>,
        stretch: Range<usize>,
        neighbours: &[Neighbour<T>],
        out: &mut Output<'_>,
    ) {
        let task = Task {
            own: self.arrays[0],
            other: self.arrays[1],
            two_sets: self.against.is_some(),
            one_numbering: self.one_numbering,
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

/// The place of the first number that is not below `low` in an ascending list; fast if `guess` is near it.
fn first_near<T: Real>(along: &[T], low: T, guess: usize) -> usize {
    let (mut from, mut to) = (guess.saturating_sub(NEAR), along.len().min(guess + NEAR));
    if from > 0 && along[from - 1] >= low {
        from = 0;
    }
    if to < along.len() && along[to] < low {
        to = along.len();
    }
    from + along[from..to].partition_point(|&x| x < low)
}

/// Doubles the room for couples. If there is no memory, the couples found are dropped and `room` becomes the
/// error.
fn grow(found: &mut Vec<Couple>, room: &mut Result<(), Error>) {
    if room.is_ok() {
        *room = make_room(found);
    }
    if room.is_err() {
        // The search continues in the memory that it has; its result is discarded.
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
    use crate::grid::Grid;
    use crate::simd::{Available, Kernels, Simd};

    /// Points from 0 to `width` on each axis.
    fn scattered<const D: usize>(n: usize, width: f64, seed: u64) -> Vec<[f64; D]> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1_u64 << 24) as f64 * width
        };
        (0..n).map(|_| std::array::from_fn(|_| next())).collect()
    }

    /// Compares the rows of one layout with those of another whose cells have another size than the reach and
    /// other places.
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
            let (filters, level) = (filters(kind), Available::new(simd).unwrap());
            own.label(filters[0], &pool).unwrap();
            other.label(filters[1], &pool).unwrap();
            let mut expected = expected.clone();
            expected.retain(|&Couple { i, j }| match filters {
                [Some(ours), Some(theirs)] => ours.admits_of(i as usize, &theirs, j as usize),
                _ => true,
            });
            let search_row = |task: &Task<'_, f64>, out: &mut Output<'_>| f64::search::<D>(level, task, out);
            let scan = Scan {
                layout: &own,
                against: Some(&other),
                arrays: [own.arrays(filters[0]), other.arrays(filters[1])],
                reach: elements.reach(),
                reach_squared: reach * reach,
                tolerance: 0.0,
                largest: 0.0,
                one_numbering: false,
                part: PART,
                search_row: &search_row,
            };
            let mut couples = Vec::new();
            let scans = [scan];
            let all = |sink: Sink<'_>| {
                Scans { each: &scans, pool: &pool, parts: &mut Vec::new() }.all(sink).unwrap();
            };
            all(Sink::List(&mut couples));
            if simd == Simd::Portable {
                order.clone_from(&couples);
            }
            assert_eq!(order, couples, "{simd}: the order");
            couples.sort_unstable();
            assert_eq!(couples, expected, "{simd}, filter {kind}, cell {cell}, reach {reach}, shift {shift}");
            let mut count = 0;
            all(Sink::Count(&mut count));
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
