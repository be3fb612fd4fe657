//! Compressed sparse rows: the neighbours of each element, contiguous in memory.

use crate::couple::Couple;
use crate::elements::{Elements, MAX_ELEMENTS};
use crate::error::Error;
use crate::memory::reserve;
use crate::periodic::PeriodicCouple;
use crate::real::Real;
use crate::search::Search;

/// The neighbours of every element in compressed sparse rows, made from a couple list in linear time,
/// optionally with a value per entry.
///
/// Row `i` is `neighbours[offsets[i]..offsets[i + 1]]`, ascending. *Half* rows hold each couple once, under
/// its smaller number; they suit a loop over couples. *Full* rows hold it under both numbers; they suit a
/// loop over elements, and threads that must not write to each other's elements.
/// ```text
/// couples 0-1 1-2 0-3      offsets   neighbours
///                  half    0 2 3 3 3   1 3 | 2 |   |
///                  full    0 2 4 5 6   1 3 | 0 2 | 1 | 0
/// ```
/// An [`Index`](crate::Index) fills rows too: one row per query point, with the elements found near it,
/// ascending by number, or by distance for a query of the nearest.
///
/// The memory is kept from one filling to the next. A couple that is listed twice appears twice in its row.
///
/// # Shapes
/// `offsets` `[n + 1]`, `neighbours` and `values` `[m]` (half) or `[2 m]` (full), for `n` elements and `m`
/// couples. Rows depend on the set of couples, not on their order. Without values `V` is `()`, which takes no
/// memory.
///
/// # Cost
/// Time proportional to `n + m`: two counting sorts, by the larger and then by the smaller number, without
/// comparisons. Memory: 16 bytes per element, 8 (half) or 12 (full) bytes per couple, and the values.
///
/// # Errors
/// All filling functions return [`Error::MalformedCouple`] for a couple that is not `i < j < n`,
/// [`Error::TooManyElements`] for an `n` that does not fit into `u32`, or [`Error::OutOfMemory`]. There are
/// no rows after an error.
///
/// # Example
/// ```
/// use fdem_contact::{Csr, Detector, Elements, Engine, Search};
///
/// let centres = [[0.0_f64, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0]];
/// let elements = Elements::points(&centres, 1.0)?;
/// let mut detector = Detector::new();
/// let mut csr = Csr::new();
/// csr.find_full(&mut detector, &elements)?;
/// assert_eq!(csr.neighbours_of(0), [1, 3]);
/// assert_eq!(csr.neighbours_of(1), [0, 2]);
///
/// // With the distance of each couple, which is stored once.
/// let mut couples = Vec::new();
/// detector.couples(&elements, &mut couples)?;
/// let mut distances = Csr::<f64>::new();
/// distances.fill_half_with(elements.len(), &couples, |i, j| elements.distance_squared(i, j).sqrt())?;
/// assert_eq!(distances.values_of(0), [1.0, 1.0]);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "neighbour list")]
#[doc(alias = "adjacency")]
#[derive(Clone, Debug)]
pub struct Csr<V = ()> {
    offsets: Vec<usize>,
    neighbours: Vec<u32>,
    values: Vec<V>,
    /// Working memory: the ends of rows by the larger number; below, the smaller numbers in these rows.
    ends: Vec<usize>,
    smaller: Vec<u32>,
    /// Couples of a search, before they are put into rows.
    found: Vec<Couple>,
}

/// Which rows a couple is put into.
#[derive(Clone, Copy, PartialEq, Eq)]
enum CsrRows {
    Half,
    Full,
}

impl<V> Default for Csr<V> {
    fn default() -> Self {
        Self::new()
    }
}

impl Csr {
    /// Fills rows with each couple once, under its smaller number.
    ///
    /// # Errors
    /// See [`Csr`].
    pub fn fill_half(&mut self, elements: usize, couples: &[Couple]) -> Result<(), Error> {
        self.fill(elements, couples, CsrRows::Half)
    }

    /// Fills rows with each couple under both of its numbers.
    ///
    /// # Errors
    /// See [`Csr`].
    pub fn fill_full(&mut self, elements: usize, couples: &[Couple]) -> Result<(), Error> {
        self.fill(elements, couples, CsrRows::Full)
    }

    /// Searches, then fills as [`Csr::fill_half`]. The couple list is kept as working memory (8 bytes per
    /// couple).
    ///
    /// # Errors
    /// See [`Csr`] and [`Search::couples`].
    pub fn find_half<T: Real, const D: usize>(
        &mut self,
        search: &mut impl Search<T, D>,
        elements: &Elements<'_, T, D>,
    ) -> Result<(), Error> {
        self.find(search, elements, CsrRows::Half)
    }

    /// Searches, then fills as [`Csr::fill_full`]. The couple list is kept as working memory (8 bytes per
    /// couple).
    ///
    /// # Errors
    /// See [`Csr`] and [`Search::couples`].
    pub fn find_full<T: Real, const D: usize>(
        &mut self,
        search: &mut impl Search<T, D>,
        elements: &Elements<'_, T, D>,
    ) -> Result<(), Error> {
        self.find(search, elements, CsrRows::Full)
    }

    fn find<T: Real, const D: usize>(
        &mut self,
        search: &mut impl Search<T, D>,
        elements: &Elements<'_, T, D>,
        rows: CsrRows,
    ) -> Result<(), Error> {
        self.clear();
        let mut found = std::mem::take(&mut self.found);
        let result =
            search.couples(elements, &mut found).and_then(|()| self.fill(elements.len(), &found, rows));
        self.found = found;
        result
    }
}

impl<const D: usize> Csr<[i32; D]> {
    /// Fills rows with each periodic couple once, under its smaller number. The values are the shifts of the
    /// neighbours.
    ///
    /// Each row is sorted by neighbour, then by shift. A neighbour appears once for each of its images that
    /// touches.
    ///
    /// # Errors
    /// See [`Csr`]. Here [`Error::MalformedCouple`] means a couple that is not `i <= j < n`, or an element
    /// with its own image whose shift is not the higher of the two opposite ones.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Csr, PeriodicCouple};
    ///
    /// let couples = [PeriodicCouple { i: 0, j: 0, shift: [1] }, PeriodicCouple { i: 0, j: 1, shift: [-1] }];
    /// let mut csr = Csr::new();
    /// csr.fill_full_periodic(2, &couples)?;
    /// assert_eq!((csr.neighbours_of(0), csr.values_of(0)), (&[0, 0, 1][..], &[[-1], [1], [-1]][..]));
    /// assert_eq!((csr.neighbours_of(1), csr.values_of(1)), (&[0][..], &[[1]][..]));
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn fill_half_periodic(
        &mut self,
        elements: usize,
        couples: &[PeriodicCouple<D>],
    ) -> Result<(), Error> {
        self.try_fill_periodic(elements, couples, CsrRows::Half).inspect_err(|_| self.clear())
    }

    /// Fills rows with each periodic couple from both sides, as [`Csr::fill_half_periodic`]. Seen from the
    /// larger number, the shift is the opposite one. An element that touches its own image has both shifts in
    /// its row.
    ///
    /// # Errors
    /// See [`Csr::fill_half_periodic`].
    pub fn fill_full_periodic(
        &mut self,
        elements: usize,
        couples: &[PeriodicCouple<D>],
    ) -> Result<(), Error> {
        self.try_fill_periodic(elements, couples, CsrRows::Full).inspect_err(|_| self.clear())
    }

    fn try_fill_periodic(
        &mut self,
        elements: usize,
        couples: &[PeriodicCouple<D>],
        rows: CsrRows,
    ) -> Result<(), Error> {
        if elements > MAX_ELEMENTS {
            return Err(Error::TooManyElements { elements, limit: MAX_ELEMENTS });
        }
        let full = rows == CsrRows::Full;
        let entries = if full { couples.len().saturating_mul(2) } else { couples.len() };
        set_len(&mut self.offsets, elements + 1)?;
        set_len(&mut self.neighbours, entries)?;
        // Values of earlier rows may remain, because all of them will be overwritten.
        self.values.truncate(entries);
        let more = entries - self.values.len();
        reserve(&mut self.values, more)?;
        self.values.resize(entries, [0; D]);

        self.offsets.fill(0);
        for (index, &PeriodicCouple { i, j, shift }) in couples.iter().enumerate() {
            if i > j || j as usize >= elements || (i == j && shift <= [0; D]) {
                return Err(Error::MalformedCouple { index, i, j, elements });
            }
            self.offsets[i as usize + 1] += 1;
            self.offsets[j as usize + 1] += usize::from(full);
        }
        let mut start = 0;
        for row in &mut self.offsets[1..] {
            // The place of the next entry of the row; once the row is full, its end.
            start += std::mem::replace(row, start);
        }
        for &PeriodicCouple { i, j, shift } in couples {
            let opposite = full.then(|| (j, i, shift.map(|s| -s)));
            for (element, neighbour, shift) in [(i, j, shift)].into_iter().chain(opposite) {
                let place = &mut self.offsets[element as usize + 1];
                (self.neighbours[*place], self.values[*place]) = (neighbour, shift);
                *place += 1;
            }
        }
        let mut sorted = Vec::new();
        for row in self.offsets.windows(2) {
            let row = row[0]..row[1];
            let (neighbours, shifts) = (&mut self.neighbours[row.clone()], &mut self.values[row]);
            sorted.clear();
            sorted.extend(neighbours.iter().copied().zip(shifts.iter().copied()));
            sorted.sort_unstable();
            for (place, &entry) in neighbours.iter_mut().zip(&mut *shifts).zip(&sorted) {
                (*place.0, *place.1) = entry;
            }
        }
        Ok(())
    }
}

impl<V> Csr<V> {
    /// No rows, and no memory.
    pub const fn new() -> Self {
        Self {
            offsets: Vec::new(),
            neighbours: Vec::new(),
            values: Vec::new(),
            ends: Vec::new(),
            smaller: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Rows from their arrays, as another device computes them.
    ///
    /// # Panics
    /// If `offsets` do not begin with 0, descend, or do not end with the number of entries, or if there are
    /// values and not one for each entry.
    pub fn from_arrays(offsets: Vec<usize>, neighbours: Vec<u32>, values: Vec<V>) -> Self {
        assert!(offsets.first() == Some(&0) && offsets.is_sorted(), "offsets ascend from 0");
        assert_eq!(offsets.last(), Some(&neighbours.len()), "the last row ends with the entries");
        assert!(values.is_empty() || values.len() == neighbours.len(), "one value for each entry");
        Self { offsets, neighbours, values, ..Self::new() }
    }

    /// Fills as [`Csr::fill_half`], with a value for each entry. `value(i, j)`, `i < j`, is called in the
    /// order of the entries.
    ///
    /// # Errors
    /// See [`Csr`]; after an error `value` has not been called.
    pub fn fill_half_with(
        &mut self,
        elements: usize,
        couples: &[Couple],
        value: impl FnMut(usize, usize) -> V,
    ) -> Result<(), Error> {
        self.fill(elements, couples, CsrRows::Half)?;
        self.evaluate(value)
    }

    /// Fills as [`Csr::fill_full`], with a value for each entry. `value(element, neighbour)` is called in the
    /// order of the entries, twice per couple, so that a direction can point from the element to its
    /// neighbour.
    ///
    /// # Errors
    /// See [`Csr`]; after an error `value` has not been called.
    pub fn fill_full_with(
        &mut self,
        elements: usize,
        couples: &[Couple],
        value: impl FnMut(usize, usize) -> V,
    ) -> Result<(), Error> {
        self.fill(elements, couples, CsrRows::Full)?;
        self.evaluate(value)
    }

    /// Number of rows, which is the number of elements.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The neighbours of `element`, ascending; in half rows only those with a larger number.
    ///
    /// # Panics
    /// When `element` is not below [`Csr::len`].
    #[inline]
    pub fn neighbours_of(&self, element: usize) -> &[u32] {
        &self.neighbours[self.offsets[element]..self.offsets[element + 1]]
    }

    /// The values of the entries of `element`, in the order of [`Csr::neighbours_of`].
    ///
    /// # Panics
    /// When `element` is not below [`Csr::len`].
    #[inline]
    pub fn values_of(&self, element: usize) -> &[V] {
        &self.values[self.offsets[element]..self.offsets[element + 1]]
    }

    /// Number of entries in the row of `element`.
    ///
    /// # Panics
    /// When `element` is not below [`Csr::len`].
    pub fn degree(&self, element: usize) -> usize {
        self.offsets[element + 1] - self.offsets[element]
    }

    /// Where the rows start, followed by the end of the last: `n + 1` numbers, or none before the first
    /// filling.
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// The entries of all rows, one row after the other.
    #[doc(alias = "indices")]
    pub fn neighbours(&self) -> &[u32] {
        &self.neighbours
    }

    /// The values of all entries.
    pub fn values(&self) -> &[V] {
        &self.values
    }

    /// Bytes held now, working memory included.
    pub fn bytes(&self) -> usize {
        (self.offsets.capacity() + self.ends.capacity()) * size_of::<usize>()
            + (self.neighbours.capacity() + self.smaller.capacity()) * size_of::<u32>()
            + self.found.capacity() * size_of::<Couple>()
            + if size_of::<V>() == 0 { 0 } else { self.values.capacity() * size_of::<V>() }
    }

    /// The arrays of offsets, neighbours and values, for a search that fills them itself.
    pub(crate) fn arrays_mut(&mut self) -> (&mut Vec<usize>, &mut Vec<u32>, &mut Vec<V>) {
        (&mut self.offsets, &mut self.neighbours, &mut self.values)
    }

    pub(crate) fn clear(&mut self) {
        self.offsets.clear();
        self.neighbours.clear();
        self.values.clear();
    }

    fn fill(&mut self, elements: usize, couples: &[Couple], rows: CsrRows) -> Result<(), Error> {
        // If anything below fails, there are no rows.
        self.values.clear();
        let result = self.try_fill(elements, couples, rows);
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// Fills the rows by two passes of count, scan and fill.
    ///
    /// `offsets[i + 1]` and `ends[j + 1]` first hold counts, then the place where the next entry of the row
    /// goes, which is the end of the row once it is full. First the couples are put into rows by `j`. Reading
    /// these rows in order, `j` ascends, so the larger neighbours of every `i` arrive sorted. Reading the
    /// resulting rows in order, the smaller neighbours arrive sorted in turn.
    fn try_fill(&mut self, elements: usize, couples: &[Couple], rows: CsrRows) -> Result<(), Error> {
        if elements > MAX_ELEMENTS {
            return Err(Error::TooManyElements { elements, limit: MAX_ELEMENTS });
        }
        let full = rows == CsrRows::Full;
        // A product beyond `usize` cannot be allocated either.
        let entries = if full { couples.len().saturating_mul(2) } else { couples.len() };
        set_len(&mut self.offsets, elements + 1)?;
        set_len(&mut self.ends, elements + 1)?;
        set_len(&mut self.smaller, couples.len())?;
        set_len(&mut self.neighbours, entries)?;
        let (offsets, ends) = (&mut self.offsets[..], &mut self.ends[..]);
        let (smaller, neighbours) = (&mut self.smaller[..], &mut self.neighbours[..]);

        offsets.fill(0);
        ends.fill(0);
        for (index, &Couple { i, j }) in couples.iter().enumerate() {
            if i >= j || j as usize >= elements {
                return Err(Error::MalformedCouple { index, i, j, elements });
            }
            offsets[i as usize + 1] += 1;
            ends[j as usize + 1] += 1;
        }
        let (mut start, mut smaller_start) = (0, 0);
        for (row, end) in offsets[1..].iter_mut().zip(&mut ends[1..]) {
            let (larger_here, smaller_here) = (*row, *end);
            // Full rows begin with the smaller neighbours, which are filled in later.
            let before = if full { smaller_here } else { 0 };
            *row = start + before;
            *end = smaller_start;
            start += before + larger_here;
            smaller_start += smaller_here;
        }

        for &Couple { i, j } in couples {
            let place = &mut ends[j as usize + 1];
            smaller[*place] = i;
            *place += 1;
        }
        for j in 0..elements {
            for &i in &smaller[ends[j]..ends[j + 1]] {
                let place = &mut offsets[i as usize + 1];
                neighbours[*place] = j as u32;
                *place += 1;
            }
        }
        if full {
            // From here on `ends[i]` is the place for the next smaller neighbour of `i`.
            ends.copy_from_slice(offsets);
            for i in 0..elements {
                // All smaller neighbours of `i` have been placed: its larger ones start where they end.
                for entry in ends[i]..offsets[i + 1] {
                    let place = &mut ends[neighbours[entry] as usize];
                    neighbours[*place] = i as u32;
                    *place += 1;
                }
            }
        }
        Ok(())
    }

    fn evaluate(&mut self, mut value: impl FnMut(usize, usize) -> V) -> Result<(), Error> {
        let entries = self.neighbours.len();
        if let Err(error) = reserve(&mut self.values, entries) {
            self.clear();
            return Err(error);
        }
        for element in 0..self.len() {
            let row = &self.neighbours[self.offsets[element]..self.offsets[element + 1]];
            self.values.extend(row.iter().map(|&neighbour| value(element, neighbour as usize)));
        }
        Ok(())
    }
}

/// Sets the length to `len` with arbitrary values, or returns an error if there is no memory.
pub(crate) fn set_len<N: Copy + Default>(values: &mut Vec<N>, len: usize) -> Result<(), Error> {
    if len > values.capacity() {
        // The old values need not be moved.
        values.clear();
        reserve(values, len)?;
    }
    values.resize(len, N::default());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_memory_holds_is_refused() {
        let mut values = vec![1_u32, 2];
        let error = set_len(&mut values, usize::MAX).unwrap_err();
        assert_eq!(error, Error::OutOfMemory { bytes: usize::MAX });
        set_len(&mut values, 3).unwrap();
        assert_eq!(values.len(), 3);
    }

    #[test]
    fn more_elements_than_u32_can_number_are_refused() {
        let elements = MAX_ELEMENTS + 1;
        let mut csr = Csr::new();
        let error = Error::TooManyElements { elements, limit: MAX_ELEMENTS };
        assert_eq!(csr.fill_half(elements, &[]), Err(error));
        assert!(csr.is_empty() && csr.bytes() == 0);
    }

    #[test]
    fn the_figure() {
        let couples = [Couple::new(0, 1), Couple::new(1, 2), Couple::new(0, 3)];
        let mut csr = Csr::new();
        csr.fill_half(4, &couples).unwrap();
        assert_eq!((csr.offsets(), csr.neighbours()), (&[0, 2, 3, 3, 3][..], &[1, 3, 2][..]));
        csr.fill_full(4, &couples).unwrap();
        assert_eq!((csr.offsets(), csr.neighbours()), (&[0, 2, 4, 5, 6][..], &[1, 3, 0, 2, 1, 0][..]));
    }
}
