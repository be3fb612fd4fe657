//! Searches around points: results are collected in the order of the index and returned in the order of the
//! points.

use std::ops::Range;

use crate::couple::Couple;
use crate::csr::set_len;
use crate::elements::Elements;
use crate::error::Error;
use crate::geometry::distance_squared;
use crate::index::Index;
use crate::index::sort::sort;
use crate::memory::reserve;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::rows::layout::{Layout, PADDING};
use crate::search::rows::scan::{FIRST_ROOM, PART, Scan};
use crate::simd::task::{Arrays, Output, Task};

/// The results for a part of the points, in sorted order.
#[derive(Clone, Debug)]
pub(super) struct Part<T> {
    pub(super) found: Vec<u32>,
    pub(super) values: Vec<T>,
    /// Where the entries of each point end.
    pub(super) ends: Vec<usize>,
    /// Couples from the kernel: the place of a point, and the place or the number of an element.
    pub(super) couples: Vec<Couple>,
    keys: Vec<u64>,
    /// Number of bytes that could not be allocated.
    pub(super) lacking: Option<usize>,
}

impl<T> Default for Part<T> {
    fn default() -> Self {
        Self {
            found: Vec::new(),
            values: Vec::new(),
            ends: Vec::new(),
            couples: Vec::new(),
            keys: Vec::new(),
            lacking: None,
        }
    }
}

impl<T: Real> Part<T> {
    pub(super) fn clear(&mut self) {
        self.found.clear();
        self.values.clear();
        self.ends.clear();
        self.couples.clear();
        self.lacking = None;
    }

    pub(super) fn bytes(&self) -> usize {
        self.found.capacity() * size_of::<u32>()
            + self.values.capacity() * size_of::<T>()
            + self.ends.capacity() * size_of::<usize>()
            + self.couples.capacity() * size_of::<Couple>()
            + self.keys.capacity() * size_of::<u64>()
    }

    /// Reserves room for `more` entries with values; returns whether there is memory.
    pub(super) fn has_room(&mut self, more: usize) -> bool {
        let bytes = (self.found.len() + more).saturating_mul(size_of::<u32>() + size_of::<T>());
        if self.found.try_reserve(more).is_err() || self.values.try_reserve(more).is_err() {
            self.lacking = Some(bytes);
        }
        self.lacking.is_none()
    }

    /// The entries of the point at place `point` of this part.
    fn entries(&self, point: usize) -> Range<usize> {
        let start = if point == 0 { 0 } else { self.ends[point - 1] };
        start..self.ends[point]
    }

    /// Finds everything within the reach of `scan` around the points at the places `range`.
    fn find<const D: usize>(&mut self, scan: &Scan<'_, T, D>, range: Range<usize>) {
        self.clear();
        self.ends.resize(range.len(), 0);
        let mut couples = std::mem::take(&mut self.couples);
        if couples.try_reserve(FIRST_ROOM).is_err() {
            self.lacking = Some(FIRST_ROOM * size_of::<Couple>());
            return;
        }
        let first = range.start;
        let mut take = |couples: &mut Vec<Couple>| {
            if self.lacking.is_none() && self.found.try_reserve(couples.len()).is_err() {
                self.lacking = Some(couples.len().saturating_mul(size_of::<u32>()));
            }
            if self.lacking.is_none() {
                let before = self.found.len() + 1;
                self.found.extend(couples.iter().map(|couple| couple.j));
                // The last entry of a point is written last.
                for (couple, end) in couples.iter().zip(before..) {
                    self.ends[couple.i as usize - first] = end;
                }
            }
            couples.clear();
        };
        scan.part(range, &mut couples, &mut take);
        take(&mut couples);
        self.couples = couples;
        let mut last = 0;
        for end in &mut self.ends {
            last = last.max(*end);
            *end = last;
        }
    }

    /// Sorts the entries of each point by number.
    fn sort(&mut self) {
        let mut start = 0;
        for &end in &self.ends {
            sort(&mut self.found[start..end], u32::MAX);
            start = end;
        }
    }

    /// Turns places into numbers, sorts them, and adds the squared distances. `points` are the points of this
    /// part.
    fn sort_with_distances<const D: usize>(
        &mut self,
        ids: &[u32],
        centres: &[[T; D]],
        points: impl Iterator<Item = [T; D]>,
    ) {
        if self.lacking.is_none() && self.values.try_reserve(self.found.len()).is_err() {
            self.lacking = Some(self.found.len().saturating_mul(size_of::<T>()));
        }
        if self.lacking.is_some() {
            return;
        }
        let mut start = 0;
        for (&end, point) in self.ends.iter().zip(points) {
            let row = &mut self.found[start..end];
            self.keys.clear();
            let key = |&place: &u32| u64::from(ids[place as usize]) << 32 | u64::from(place);
            self.keys.extend(row.iter().map(key));
            sort(&mut self.keys, u64::MAX);
            for (entry, &key) in row.iter_mut().zip(&self.keys) {
                *entry = (key >> 32) as u32;
                self.values.push(distance_squared(&point, &centres[key as u32 as usize]));
            }
            start = end;
        }
    }
}

impl<T: Real, const D: usize> Index<T, D> {
    pub(super) fn find_within(
        &mut self,
        points: &[[T; D]],
        r: T,
        offsets: &mut Vec<usize>,
        neighbours: &mut Vec<u32>,
        values: Option<&mut Vec<T>>,
    ) -> Result<(), Error> {
        let elements = Elements::points(points, r)?;
        if !self.sort_points(&elements, points, values.is_some())? {
            return no_entries(points.len(), offsets);
        }
        let Self { layout, moving, centres, places, parts, order, pool, simd, .. } = self;
        let (layout, moving, simd) = (&*layout, &*moving, *simd);
        let search_row = |task: &Task<'_, T>, out: &mut Output<'_>| T::search::<D>(simd, task, out);
        let with_distances = values.is_some();
        let scan = Scan {
            layout: moving,
            against: Some(layout),
            arrays: [
                Arrays { coordinates: &moving.coordinates, far: &[], radii: &[], ids: places, filter: None },
                Arrays {
                    coordinates: &layout.coordinates,
                    far: &[],
                    radii: &[],
                    ids: if with_distances { places } else { &layout.ids },
                    filter: None,
                },
            ],
            reach: T::at_least(elements.reach().max(T::MIN_RESOLVED)),
            reach_squared: r * r,
            tolerance: T::ZERO,
            largest: 0.0,
            one_numbering: false,
            part: PART,
            search_row: &search_row,
        };
        parts.resize_with(points.len().div_ceil(PART), Part::default);
        pool.run(parts.iter_mut().zip(scan.ranges()), |(part, range)| {
            part.find(&scan, range.clone());
            if with_distances {
                let points = scan
                    .stretches(&range)
                    .flat_map(|(_, row, stretch)| stretch.map(move |k| moving.point(&row, k)));
                part.sort_with_distances(&layout.ids, centres, points);
            } else {
                part.sort();
            }
        });
        hand_over(parts, moving, order, pool, offsets, neighbours, values)
    }

    /// Sorts points as the index is sorted. Returns `false` if there are no elements or no points.
    pub(super) fn sort_points(
        &mut self,
        elements: &Elements<'_, T, D>,
        points: &[[T; D]],
        with_distances: bool,
    ) -> Result<bool, Error> {
        if self.kind.is_none() {
            return Err(Error::IndexNotBuilt);
        }
        if points.is_empty() || self.is_empty() {
            return Ok(false);
        }
        let Self { layout, moving, pool, .. } = self;
        moving.build_along(points, &[], layout.grid.over(elements.bounds()), layout.axes, pool)?;
        let n = layout.len();
        let needed = n.max(points.len()) + PADDING;
        if self.places.len() < needed {
            let len = self.places.len();
            reserve(&mut self.places, needed - len)?;
            self.places.extend(len as u32..needed as u32);
        }
        if with_distances && self.centres.is_empty() {
            reserve(&mut self.centres, n)?;
            for row in (0..layout.rows()).map(|row| layout.row(row)) {
                self.centres.extend((0..row.len()).map(|k| layout.point(&row, k)));
            }
        }
        Ok(true)
    }
}

/// Rows for `points` points, all empty.
pub(super) fn no_entries(points: usize, offsets: &mut Vec<usize>) -> Result<(), Error> {
    set_len(offsets, points + 1)?;
    offsets.fill(0);
    Ok(())
}

/// Puts the entries of all parts into rows, in the order of the points.
pub(super) fn hand_over<T: Real, const D: usize>(
    parts: &[Part<T>],
    points: &Layout<T, D>,
    order: &mut Vec<u32>,
    pool: &Pool,
    offsets: &mut Vec<usize>,
    neighbours: &mut Vec<u32>,
    values: Option<&mut Vec<T>>,
) -> Result<(), Error> {
    if let Some(bytes) = parts.iter().find_map(|part| part.lacking) {
        return Err(Error::OutOfMemory { bytes });
    }
    let n = points.len();
    set_len(order, n)?;
    set_len(offsets, n + 1)?;
    offsets[0] = 0;
    let ids = points.ids.chunks(PART);
    for ((part, ids), first) in parts.iter().zip(ids).zip((0..n).step_by(PART)) {
        let mut start = 0;
        for ((&end, &id), place) in part.ends.iter().zip(ids).zip(first..) {
            order[id as usize] = place as u32;
            offsets[id as usize + 1] = end - start;
            start = end;
        }
    }
    let mut total = 0;
    for offset in &mut offsets[1..] {
        total += *offset;
        *offset = total;
    }
    set_len(neighbours, total)?;
    let mut values: &mut [T] = match values {
        None => &mut [],
        Some(values) => {
            set_len_of_values(values, total)?;
            values
        }
    };
    let with_values = !values.is_empty();
    let mut neighbours = neighbours.as_mut_slice();
    let stretch = n.div_ceil(4 * pool.threads());
    let tasks = order.chunks(stretch).zip(offsets.chunks(stretch)).enumerate().map(|(k, (order, starts))| {
        let end = offsets[(k * stretch + order.len()).min(n)];
        let len = end - starts[0];
        let neighbours = neighbours.split_off_mut(..len).unwrap_or_default();
        let values = values.split_off_mut(..if with_values { len } else { 0 }).unwrap_or_default();
        (order, neighbours, values)
    });
    pool.run(tasks, |(order, neighbours, values)| {
        let mut start = 0;
        for &place in order {
            let part = &parts[place as usize / PART];
            let entries = part.entries(place as usize % PART);
            let end = start + entries.len();
            neighbours[start..end].copy_from_slice(&part.found[entries.clone()]);
            if with_values {
                values[start..end].copy_from_slice(&part.values[entries]);
            }
            start = end;
        }
    });
    Ok(())
}

fn set_len_of_values<T: Real>(values: &mut Vec<T>, len: usize) -> Result<(), Error> {
    values.clear();
    reserve(values, len)?;
    values.resize(len, T::ZERO);
    Ok(())
}
