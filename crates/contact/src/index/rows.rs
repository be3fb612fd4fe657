//! Searches around points: results are collected in the order of the index and returned in the order of the
//! points.

use crate::csr::set_len;
use crate::elements::Elements;
use crate::error::Error;
use crate::index::Index;
use crate::index::part::PointsPart;
use crate::memory::reserve;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::rows::layout::{Layout, PADDING};
use crate::search::rows::scan::{PART, Scan};
use crate::simd::task::{Arrays, Output, Task};

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
        parts.resize_with(points.len().div_ceil(PART), PointsPart::default);
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
    parts: &[PointsPart<T>],
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
