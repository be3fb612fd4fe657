//! Search for the nearest elements of points.

use std::collections::BinaryHeap;
use std::ops::Range;

use crate::couple::Couple;
use crate::elements::Elements;
use crate::error::Error;
use crate::geometry::distance_squared;
use crate::index::Index;
use crate::index::part::PointsPart;
use crate::index::rows::{hand_over, no_entries};
use crate::index::sort::{FEW, sort};
use crate::real::Real;
use crate::search::rows::layout::Layout;
use crate::search::rows::reach::RowsInReach;
use crate::search::rows::scan::{PART, Scan};
use crate::simd::task::{Arrays, Looks, Neighbour, Output, ROOM, Span, Task};

/// Number of neighbouring points that are searched for with one reach: enough to share the rows in reach, few
/// enough to have similar neighbours.
const STRETCH: usize = 32;

/// The next reach is chosen so that one in this many of the latest distances is larger.
const MISSES: usize = 16;

/// If the windows of a stretch hold more elements than this per point and neighbour, or if there are more
/// rows than the limit below, its points are searched for one by one.
const MAX_WINDOW: usize = 16;
const MAX_ROWS: usize = 256;

impl<T: Real, const D: usize> Index<T, D> {
    pub(super) fn find_nearest(
        &mut self,
        points: &[[T; D]],
        k: usize,
        offsets: &mut Vec<usize>,
        neighbours: &mut Vec<u32>,
        values: &mut Vec<T>,
    ) -> Result<(), Error> {
        let elements = Elements::points(points, T::ZERO)?;
        if !self.sort_points(&elements, points, true)? || k == 0 {
            return no_entries(points.len(), offsets);
        }
        let Self { layout, moving, centres, places, parts, order, bounds, pool, simd, .. } = self;
        let (layout, moving, bounds, simd) = (&*layout, &*moving, &*bounds, *simd);
        parts.resize_with(points.len().div_ceil(PART), PointsPart::default);
        let search_row = |task: &Task<'_, T>, out: &mut Output<'_>| T::search::<D>(simd, task, out);
        let scan = Scan {
            layout: moving,
            against: Some(layout),
            arrays: [moving, layout].map(|layout| Arrays {
                coordinates: &layout.coordinates,
                far: &[],
                radii: &[],
                ids: places,
                filter: None,
            }),
            reach: T::ZERO,
            reach_squared: T::ZERO,
            tolerance: T::ZERO,
            largest: 0.0,
            one_numbering: false,
            part: PART,
            search_row: &search_row,
        };
        let wanted = k.min(layout.len());
        pool.run(parts.iter_mut().zip(scan.ranges()), |(part, range)| {
            let gap = |point: &[T; D]| {
                layout.axes[1..].iter().fold(0.0, |gap, &axis| {
                    let x = point[axis].to_f64();
                    f64::max(gap, f64::max(bounds.min[axis] - x, x - bounds.max[axis]))
                })
            };
            let mut nearest = Nearest {
                layout,
                centres,
                wanted,
                rows: RowsInReach::new(layout),
                best: BinaryHeap::new(),
                keys: Vec::new(),
                neighbours: Vec::new(),
                seen: Vec::new(),
                rows_now: Vec::new(),
            };
            nearest.part(&scan, part, range, gap);
        });
        hand_over(parts, moving, order, pool, offsets, neighbours, Some(values))
    }
}

/// The search for the nearest elements of the points of one part.
///
/// Points near each other have neighbours at similar distances. Therefore the distances that the latest
/// points needed are tried first, for a stretch of points together, with the kernel, and then somewhat larger
/// distances for each point that has found too few. A point that still has too few is searched for alone, in
/// growing boxes of rows. In any case all elements up to the distance of the last neighbour have been
/// compared, so the result is exact.
struct Nearest<'a, T, const D: usize> {
    layout: &'a Layout<T, D>,
    centres: &'a [[T; D]],
    wanted: usize,
    rows: RowsInReach<'a, T, D>,
    /// The best elements so far, with the worst of them on top.
    best: BinaryHeap<u128>,
    keys: Vec<u128>,
    /// Rows in reach of a stretch.
    neighbours: Vec<Neighbour<T>>,
    /// Rows of the last box, ascending; below, those of the next box.
    seen: Vec<usize>,
    rows_now: Vec<usize>,
}

impl<T: Real, const D: usize> Nearest<'_, T, D> {
    fn part(
        &mut self,
        scan: &Scan<'_, T, D>,
        part: &mut PointsPart<T>,
        range: Range<usize>,
        gap: impl Fn(&[T; D]) -> f64,
    ) {
        part.clear();
        let mut rows = RowsInReach::new(self.layout);
        let mut again = Vec::new();
        let mut reach_squared = None;
        let mut needed = Vec::with_capacity(STRETCH);
        for (_, places, whole) in scan.stretches(&range) {
            for from in whole.clone().step_by(STRETCH) {
                let stretch = from..whole.end.min(from + STRETCH);
                let mut couples = std::mem::take(&mut part.couples);
                couples.clear();
                if let Some(reach_squared) = reach_squared {
                    self.kernel(scan, &places, stretch.clone(), reach_squared, &mut rows, &mut couples);
                }
                if !part.has_room(stretch.len().saturating_mul(self.wanted)) {
                    return;
                }
                let mut rest = &couples[..];
                needed.clear();
                for k in stretch {
                    let place = places.start + k;
                    let len = rest.iter().take_while(|couple| couple.i as usize == place).count();
                    let (mut found, others) = rest.split_at(len);
                    rest = others;
                    if let Some(reach_squared) = reach_squared
                        && found.len() < self.wanted
                    {
                        again.clear();
                        let more = reach_squared + reach_squared;
                        self.kernel(scan, &places, k..k + 1, more, &mut rows, &mut again);
                        found = &again;
                    }
                    let point = &scan.layout.point(&places, k);
                    self.keys.clear();
                    if found.len() >= self.wanted {
                        for couple in found {
                            self.keys.push(self.key(point, couple.j as usize));
                        }
                    } else {
                        self.boxes(point, gap(point));
                        self.keys.extend(self.best.drain());
                    }
                    self.sort_keys();
                    part.found.extend(self.keys.iter().map(|&key| key as u32));
                    part.values.extend(self.keys.iter().map(|&key| squared::<T>(key)));
                    part.ends.push(part.found.len());
                    needed.extend(self.keys.last().map(|&key| squared::<T>(key)));
                }
                part.couples = couples;
                let rank = needed.len() - 1 - needed.len() / MISSES;
                let by_size = |a: &T, b: &T| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
                reach_squared = Some(*needed.select_nth_unstable_by(rank, by_size).1);
            }
        }
    }

    /// Writes the couples of a stretch of a row with all elements in reach; none if there are too many.
    fn kernel(
        &mut self,
        scan: &Scan<'_, T, D>,
        places: &Range<usize>,
        stretch: Range<usize>,
        reach_squared: T,
        rows: &mut RowsInReach<'_, T, D>,
        couples: &mut Vec<Couple>,
    ) {
        let layout = self.layout;
        let reach = T::at_least(reach_of::<T, D>(reach_squared));
        let [min, max] = scan.layout.extremes(places, &stretch);
        let long = layout.axes[0];
        let (low, high) = (min[long] - reach, max[long] + reach);
        let mut room = (STRETCH * MAX_WINDOW).saturating_mul(self.wanted + 4);
        let neighbours = &mut self.neighbours;
        neighbours.clear();
        let fits = rows.find(&min, &max, reach.to_f64(), |row| {
            let row = layout.row(row);
            let along = layout.along(&row);
            let first = along.partition_point(|&x| x < low);
            let len = along[first..].partition_point(|&x| x <= high);
            if len > 0 {
                neighbours.push(Neighbour {
                    row: Span { start: row.start, len: row.len() },
                    low: first,
                    looks: Looks::Back,
                    reach,
                });
            }
            let fits = len <= room && neighbours.len() <= MAX_ROWS;
            room = if fits { room - len } else { 0 };
            fits
        });
        if fits {
            let scan = Scan { reach, reach_squared, ..*scan };
            let make_room = &mut |couples: &mut Vec<Couple>| couples.reserve(STRETCH * ROOM);
            scan.stretch(places, stretch, neighbours, &mut Output::new(couples, make_room));
        }
    }

    /// Finds the best of all elements, at any distance, and writes them into `best`.
    fn boxes(&mut self, point: &[T; D], gap: f64) {
        self.best.clear();
        self.seen.clear();
        let mut reach = gap + self.layout.grid.cell_size();
        loop {
            let mut rows = std::mem::replace(&mut self.rows, RowsInReach::new(self.layout));
            let mut now = std::mem::take(&mut self.rows_now);
            now.clear();
            let mut next = 0;
            rows.find(point, point, reach, |row| {
                now.push(row);
                while self.seen.get(next).is_some_and(|&seen| seen < row) {
                    next += 1;
                }
                if self.seen.get(next) != Some(&row) {
                    self.row(point, row);
                }
                true
            });
            self.rows = rows;
            self.rows_now = std::mem::replace(&mut self.seen, now);
            let worst = if self.best.len() == self.wanted { self.best.peek() } else { None };
            let Some(&worst) = worst else {
                reach *= 2.0;
                continue;
            };
            let needed = reach_of::<T, D>(squared(worst));
            if needed <= reach {
                return;
            }
            reach = needed;
        }
    }

    /// Tests the elements of one row, from the point outwards, as long as they can be among the best.
    fn row(&mut self, point: &[T; D], row: usize) {
        let row = self.layout.row(row);
        let along = self.layout.along(&row);
        let x = point[self.layout.axes[0]];
        let square = |y: T| (x - y) * (x - y);
        let mut right = along.partition_point(|&y| y < x);
        let mut left = right;
        loop {
            let below = (left > 0).then(|| square(along[left - 1]));
            let above = (right < along.len()).then(|| square(along[right]));
            let (nearest, k) = match (below, above) {
                (Some(below), above) if above.is_none_or(|above| below < above) => {
                    left -= 1;
                    (below, left)
                }
                (_, Some(above)) => {
                    right += 1;
                    (above, right - 1)
                }
                _ => return,
            };
            let full = self.best.len() == self.wanted;
            // A rounded sum of squares is at least as large as each square.
            if full && self.best.peek().is_some_and(|&worst| nearest > squared(worst)) {
                return;
            }
            let key = self.key(point, row.start + k);
            if !full {
                self.best.push(key);
            } else if let Some(mut worst) = self.best.peek_mut()
                && key < *worst
            {
                *worst = key;
            }
        }
    }

    /// Sorts the keys and keeps the first ones.
    fn sort_keys(&mut self) {
        let n = self.keys.len();
        if n <= FEW {
            // Sorts by the leading bits of the distances first, without branches; any wrong order that is
            // left is between near places.
            let mut rough = [0; FEW];
            for ((rough, &key), k) in rough.iter_mut().zip(&self.keys).zip(0_u64..) {
                *rough = (key >> 32) as u64 & !(FEW as u64 - 1) | k;
            }
            sort(&mut rough[..n], u64::MAX);
            let mut keys = [0; FEW];
            for (key, &rough) in keys.iter_mut().zip(&rough[..n]) {
                *key = self.keys[rough as usize % FEW];
            }
            for k in 1..n {
                let mut to = k;
                while to > 0 && keys[to - 1] > keys[to] {
                    keys.swap(to - 1, to);
                    to -= 1;
                }
            }
            self.keys.copy_from_slice(&keys[..n]);
        } else {
            if n > 4 * self.wanted {
                self.keys.select_nth_unstable(self.wanted - 1);
                self.keys.truncate(self.wanted);
            }
            self.keys.sort_unstable();
        }
        self.keys.truncate(self.wanted);
    }

    /// A key that ascends with the squared distance, then with the number: non-negative floats ascend with
    /// their bits.
    fn key(&self, point: &[T; D], place: usize) -> u128 {
        let squared = distance_squared(point, &self.centres[place]).to_f64();
        u128::from(squared.to_bits()) << 32 | u128::from(self.layout.ids[place])
    }
}

/// The squared distance in a key.
fn squared<T: Real>(key: u128) -> T {
    T::nearest(f64::from_bits((key >> 32) as u64))
}

/// Upper bound on the distance, along any axis, of elements whose rounded squared distance is at most
/// `squared`. The argument is that of `Elements::reach`.
fn reach_of<T: Real, const D: usize>(squared: T) -> f64 {
    (squared.to_f64().sqrt() * (1.0 + (D + 8) as f64 * T::EPSILON)).max(T::MIN_RESOLVED)
}
