//! Collects elements row by row, from text or from an array.

use crate::columns::Role;
use crate::error::ReadError;
use crate::packing::{BadLine, Centres, Frame, Packing, Skipped, Source};
use crate::row::{Row, SIZE};
use crate::types::TypesOfRows;

/// A packing that is being read.
#[derive(Debug)]
pub(crate) struct Elements {
    pub(crate) centres: Centres,
    pub(crate) radii: Option<Vec<f64>>,
    pub(crate) ids: Option<Vec<i64>>,
    pub(crate) bodies: Option<Vec<i64>>,
    pub(crate) types: Option<TypesOfRows>,
    pub(crate) skipped: Skipped,
    /// See [`Packing::row_numbers`](crate::Packing::row_numbers).
    pub(crate) row_numbers: Option<Vec<u64>>,
    /// Line or row of every element, kept only if ids must be compared.
    places: Vec<u64>,
    /// Radius divided by the value in the size column: 1 for radii, 1/2 for diameters.
    scale: f64,
}

/// An id on two rows.
#[derive(Debug, PartialEq, Eq)]
struct Duplicate {
    id: i64,
    first: u64,
    second: u64,
}

impl Elements {
    /// Room for `capacity` elements with these columns.
    pub(crate) fn new(roles: &[Option<Role>], capacity: usize) -> Result<Self, ReadError> {
        let has = |role| roles.contains(&Some(role));
        let sized = has(Role::Radius) || has(Role::Diameter);
        Ok(Self {
            centres: if has(Role::Z) {
                Centres::Three(room(capacity)?)
            } else {
                Centres::Two(room(capacity)?)
            },
            radii: sized.then(|| room(capacity)).transpose()?,
            ids: has(Role::Id).then(|| room(capacity)).transpose()?,
            bodies: has(Role::Body).then(|| room(capacity)).transpose()?,
            types: has(Role::Type).then(|| room(capacity).map(TypesOfRows::new)).transpose()?,
            skipped: Skipped::default(),
            row_numbers: None,
            places: room(if has(Role::Id) { capacity } else { 0 })?,
            scale: if has(Role::Diameter) { 0.5 } else { 1.0 },
        })
    }

    #[inline]
    pub(crate) fn push(&mut self, row: &Row<'_>, place: u64) {
        if let Some(numbers) = &mut self.row_numbers {
            numbers.push(self.centres.len() as u64 + self.skipped.count);
        }
        let [x, y, z, size] = row.values;
        match &mut self.centres {
            Centres::Two(centres) => centres.push([x, y]),
            Centres::Three(centres) => centres.push([x, y, z]),
        }
        if let Some(radii) = &mut self.radii {
            radii.push(size * self.scale);
        }
        if let Some(ids) = &mut self.ids {
            ids.push(row.id);
            self.places.push(place);
        }
        if let Some(bodies) = &mut self.bodies {
            bodies.push(row.body);
        }
        if let Some(types) = &mut self.types {
            types.push(row.type_of);
        }
    }

    /// Skips a row and records why.
    fn skip(&mut self, bad: BadLine) {
        self.row_numbers.get_or_insert_with(|| (0..self.centres.len() as u64).collect());
        self.skipped.push(bad);
    }

    /// The packing, for a file without a box; `source` describes the file.
    pub(crate) fn into_packing(self, frame: Frame, source: impl FnOnce(Skipped) -> Source) -> Packing {
        Packing {
            centres: self.centres,
            radii: self.radii,
            ids: self.ids,
            bodies: self.bodies,
            types: self.types.map(TypesOfRows::into_types),
            row_numbers: self.row_numbers,
            cell: None,
            frame,
            source: source(self.skipped),
        }
    }

    /// Skips a bad line of text if bad lines are skipped; otherwise returns its error.
    pub(crate) fn bad_line(&mut self, bad: BadLine, skips: bool) -> Result<(), ReadError> {
        if !skips {
            return Err(ReadError::Malformed { line: bad.line, text: bad.text, problem: bad.problem });
        }
        self.skip(bad);
        Ok(())
    }

    /// Like [`Elements::bad_line`], for a row of an array.
    pub(crate) fn bad_row(&mut self, bad: BadLine, skips: bool) -> Result<(), ReadError> {
        if !skips {
            return Err(ReadError::BadRow { row: bad.line, text: bad.text, problem: bad.problem });
        }
        self.skip(bad);
        Ok(())
    }

    /// Checks that not all rows are bad, and that no id is twice. `are_lines`: whether rows are lines of
    /// text.
    pub(crate) fn check(&self, are_lines: bool) -> Result<(), ReadError> {
        if let Some(bad) = self.skipped.first.first().filter(|_| self.centres.is_empty()) {
            let (text, problem) = (bad.text.clone(), bad.problem.clone());
            let line = are_lines.then_some(bad.line);
            return Err(ReadError::AllBad { count: self.skipped.count, line, text, problem });
        }
        match self.duplicate() {
            None => Ok(()),
            Some(Duplicate { id, first, second }) if are_lines => {
                Err(ReadError::DuplicateId { id, first, second })
            }
            Some(Duplicate { id, first, second }) => Err(ReadError::DuplicateIdRow { id, first, second }),
        }
    }

    /// The first row, in the order of the file, that repeats the id of an earlier row.
    fn duplicate(&self) -> Option<Duplicate> {
        let ids = self.ids.as_ref()?;
        if ids.is_sorted_by(|a, b| a < b) {
            return None;
        }
        let mut order: Vec<(i64, u64)> = ids.iter().copied().zip(self.places.iter().copied()).collect();
        order.sort_unstable();
        let twice = order.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let pair = twice.min_by_key(|pair| pair[1].1)?;
        Some(Duplicate { id: pair[0].0, first: pair[0].1, second: pair[1].1 })
    }
}

const _: () = assert!(SIZE == 3, "`push` takes the size from the last value");

fn room<V>(elements: usize) -> Result<Vec<V>, ReadError> {
    let mut values = Vec::new();
    values.try_reserve_exact(elements).map_err(|_| ReadError::OutOfMemory { elements })?;
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_ids(ids: &[i64]) -> Elements {
        let mut elements = Elements::new(&[Some(Role::X), Some(Role::Y), Some(Role::Id)], 0).unwrap();
        for (place, id) in ids.iter().enumerate() {
            elements.push(&Row { id: *id, ..Row::default() }, place as u64 + 10);
        }
        elements
    }

    #[test]
    fn the_earliest_repetition_is_reported() {
        assert_eq!(with_ids(&[1, 2, 3]).duplicate(), None);
        assert_eq!(with_ids(&[3, -1, 2]).duplicate(), None);
        assert_eq!(with_ids(&[9, 5, 9, 5, 9]).duplicate(), Some(Duplicate { id: 9, first: 10, second: 12 }));
        assert_eq!(with_ids(&[1, 1]).duplicate(), Some(Duplicate { id: 1, first: 10, second: 11 }));
    }

    #[test]
    fn rows_are_numbered_once_one_is_skipped() {
        let mut elements = with_ids(&[1, 2]);
        assert_eq!(elements.row_numbers, None);
        for _ in 0..2 {
            elements.skip(BadLine { line: 1, text: String::new(), problem: String::new() });
        }
        elements.push(&Row::default(), 1);
        elements.push(&Row::default(), 2);
        assert_eq!(elements.row_numbers, Some(vec![0, 1, 4, 5]));
    }

    #[test]
    fn diameters_are_halved() {
        let mut elements = Elements::new(&[Some(Role::X), Some(Role::Y), Some(Role::Diameter)], 1).unwrap();
        elements.push(&Row { values: [1.0, 2.0, 0.0, 3.0], ..Row::default() }, 1);
        assert_eq!(elements.radii, Some(vec![1.5]));
        assert_eq!(elements.centres, Centres::Two(vec![[1.0, 2.0]]));
        assert_eq!(elements.ids, None);
    }
}
