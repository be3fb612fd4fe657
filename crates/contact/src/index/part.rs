//! The results of a search for a part of the points.

use std::ops::Range;

use crate::couple::Couple;
use crate::geometry::distance_squared;
use crate::index::sort::sort;
use crate::real::Real;
use crate::search::rows::scan::{FIRST_ROOM, Scan};

/// The results for a part of the points, in sorted order.
#[derive(Clone, Debug)]
pub(super) struct PointsPart<T> {
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

impl<T> Default for PointsPart<T> {
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

impl<T: Real> PointsPart<T> {
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
    pub(super) fn entries(&self, point: usize) -> Range<usize> {
        let start = if point == 0 { 0 } else { self.ends[point - 1] };
        start..self.ends[point]
    }

    /// Finds everything within the reach of `scan` around the points at the places `range`.
    pub(super) fn find<const D: usize>(&mut self, scan: &Scan<'_, T, D>, range: Range<usize>) {
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
    pub(super) fn sort(&mut self) {
        let mut start = 0;
        for &end in &self.ends {
            sort(&mut self.found[start..end], u32::MAX);
            start = end;
        }
    }

    /// Turns places into numbers, sorts them, and adds the squared distances. `points` are the points of this
    /// part.
    pub(super) fn sort_with_distances<const D: usize>(
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
