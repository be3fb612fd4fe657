//! Distances and overlaps of couples.

use fdem::network::PairCutoffs;
use fdem_contact::{Couple, Error, PeriodicBox};
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::elements::{Elements, Set, SetSizes};
use crate::interrupt::{self, Stop};
use crate::number::{Number, rows_of, with_kind};
use crate::problem::{Problem, zeros};
use crate::search::{FoundPairs, into_pairs, is_long, threads_for};
use crate::tasks;

/// Couples that a thread measures at a time: enough to be worth a thread.
const PART: usize = 1 << 15;

/// Fills `values` on up to `threads` threads, until `stop` is set; `value` gets the place of the value.
fn fill<V: Copy + Send>(
    values: &mut [V],
    (threads, stop): (usize, &Stop),
    value: impl Fn(usize) -> V + Sync,
) {
    tasks::run((threads, stop), values.chunks_mut(PART).enumerate(), |(part, values)| {
        values.iter_mut().zip(part * PART..).for_each(|(to, place)| *to = value(place));
    });
}

/// Couples, checked.
struct Couples<'a, T, const D: usize> {
    set: Set<'a, T, D>,
    cell: Option<PeriodicBox<T, D>>,
    pairs: &'a [[u32; 2]],
    /// Shifts of the last couples; the couples before them have none.
    shifts: &'a [[i32; D]],
}

/// The lower and the upper corner of a box; twice the centre of a sphere.
type Ends<T, const D: usize> = [[T; D]; 2];

impl<T: Number, const D: usize> Couples<'_, T, D> {
    /// Refuses couples of other elements.
    fn check(&self) -> Result<(), Problem> {
        let n = self.set.points.len();
        let unknown = self.pairs.as_flattened().iter().any(|&element| element as usize >= n);
        if unknown || self.shifts.len() > self.pairs.len() {
            return Err(Problem::Arguments("couples of other elements".to_owned()));
        }
        Ok(())
    }

    fn ends(&self, element: u32) -> Ends<T, D> {
        let point = self.set.points[element as usize];
        match self.set.sizes {
            SetSizes::Upper(upper) => [point, upper[element as usize]],
            _ => [point, point],
        }
    }

    /// Both elements as the search has compared them: in a box that repeats they are wrapped, and the second
    /// one is displaced.
    fn compared(&self, couple: usize) -> [Ends<T, D>; 2] {
        let [i, j] = self.pairs[couple];
        let (a, b) = (self.ends(i), self.ends(j));
        let Some(cell) = &self.cell else { return [a, b] };
        let shift = couple
            .checked_sub(self.pairs.len() - self.shifts.len())
            .map_or([0; D], |place| self.shifts[place]);
        // Elements that were searched can be wrapped.
        let periods = |ends: &Ends<T, D>| cell.wrap(ends[0]).map_or([0; D], |(_, periods)| periods);
        let moved = |point: &[T; D], shift: &[i32; D]| {
            if *shift == [0; D] { *point } else { cell.displaced(point, shift) }
        };
        let (of_a, of_b) = (periods(&a), periods(&b));
        let back = |ends: &Ends<T, D>, periods: &[i32; D]| ends.map(|end| moved(&end, &periods.map(|n| -n)));
        let shift = std::array::from_fn(|edge| shift[edge] - of_a[edge] + of_b[edge]);
        [back(&a, &of_a), back(&b, &of_b).map(|end| moved(&end, &shift))]
    }

    /// The distance of the centres of spheres, or of the closest points of boxes.
    fn distance(&self, couple: usize) -> T {
        self.distance_squared(couple).sqrt()
    }

    fn distance_squared(&self, couple: usize) -> T {
        let [a, b] = self.compared(couple);
        let mut sum = T::ZERO;
        for axis in 0..D {
            let gap = match self.set.sizes {
                SetSizes::Upper(_) => {
                    let (one, two) = (a[0][axis] - b[1][axis], b[0][axis] - a[1][axis]);
                    let gap = if one > two { one } else { two };
                    if gap > T::ZERO { gap } else { T::ZERO }
                }
                _ => a[0][axis] - b[0][axis],
            };
            sum = sum + gap * gap;
        }
        sum
    }

    /// Whether the points of a couple that the search has found are within the cut-off of their types.
    fn is_within(&self, cutoffs: &PairCutoffs, tolerance: T, couple: usize) -> bool {
        let [i, j] = self.pairs[couple];
        cutoffs.of(i, j).is_some_and(|cutoff| {
            let reach = T::nearest(cutoff) + tolerance;
            // The search has compared those with the largest cut-off.
            cutoff == cutoffs.largest() || self.distance_squared(couple) <= reach * reach
        })
    }

    /// The sum of the radii, or the cut-off, less the distance; for boxes the smallest overlap along an axis.
    fn overlap(&self, couple: usize) -> T {
        let [i, j] = self.pairs[couple].map(|element| element as usize);
        match self.set.sizes {
            SetSizes::Each(radii) => (radii[i] + radii[j]) - self.distance(couple),
            SetSizes::All(radius) => (radius + radius) - self.distance(couple),
            SetSizes::Cutoff(cutoff) => cutoff - self.distance(couple),
            SetSizes::Pairs(cutoffs) => {
                // Couples that were found have a cut-off.
                let cutoff = cutoffs.of(i as u32, j as u32).map_or(T::ZERO, T::nearest);
                cutoff - self.distance(couple)
            }
            SetSizes::Upper(_) => {
                let [a, b] = self.compared(couple);
                let common = |axis: usize| {
                    let high = if a[1][axis] < b[1][axis] { a[1][axis] } else { b[1][axis] };
                    let low = if a[0][axis] > b[0][axis] { a[0][axis] } else { b[0][axis] };
                    high - low
                };
                (1..D)
                    .map(common)
                    .fold(common(0), |least, length| if length < least { length } else { least })
            }
        }
    }
}

/// The distance of each couple, or its overlap.
#[pyfunction]
pub(crate) fn measure<'py>(
    py: Python<'py>,
    elements: &Elements,
    pairs: PyReadonlyArray2<'py, u32>,
    shifts: PyReadonlyArray2<'py, i32>,
    overlap: bool,
    threads: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let stop = Stop::default();
    with_kind!(elements.kind, T, D => {
        let held = elements.hold::<T>(py)?;
        elements.check_unchanged(&held)?;
        let couples = Couples {
            set: held.set::<D>(elements)?,
            cell: elements.cell::<T, D>()?,
            pairs: rows_of(&pairs)?,
            shifts: rows_of(&shifts)?,
        };
        let values = interrupt::run(py, is_long(couples.pairs.len()), &stop, || {
            couples.check()?;
            let n = couples.set.points.len();
            if let SetSizes::Each(radii) = couples.set.sizes && radii.len() != n {
                return Err(Error::LengthMismatch { what: "radii", expected: n, found: radii.len() }.into());
            }
            let mut values = zeros::<T>(couples.pairs.len())?;
            let threads = threads_for(threads, couples.pairs.len());
            if overlap {
                fill(&mut values, (threads, &stop), |couple| couples.overlap(couple));
            } else {
                fill(&mut values, (threads, &stop), |couple| couples.distance(couple));
            }
            Ok(values)
        })?;
        Ok(values.into_pyarray(py).into_any())
    })
}

/// Keeps the couples that are within the cut-off of their types. A search finds all up to the largest one.
#[pyfunction]
pub(crate) fn within_cutoffs<'py>(
    py: Python<'py>,
    elements: &Elements,
    pairs: PyReadonlyArray2<'py, u32>,
    shifts: PyReadonlyArray2<'py, i32>,
) -> PyResult<FoundPairs<'py>> {
    let stop = Stop::default();
    with_kind!(elements.kind, T, D => {
        let held = elements.hold::<T>(py)?;
        let set = held.set::<D>(elements)?;
        let SetSizes::Pairs(cutoffs) = set.sizes else {
            return Err(Problem::Arguments("these elements have no cut-offs by types".to_owned()).into());
        };
        let cell = elements.cell::<T, D>()?;
        let couples = Couples { set, cell, pairs: rows_of(&pairs)?, shifts: rows_of(&shifts)? };
        let (kept, kept_shifts) = interrupt::run(py, false, &stop, || {
            couples.check()?;
            let unshifted = couples.pairs.len() - couples.shifts.len();
            let (mut kept, mut kept_shifts) = (Vec::new(), Vec::new());
            for (place, &[i, j]) in couples.pairs.iter().enumerate() {
                if couples.is_within(cutoffs, set.tolerance, place) {
                    kept.push(Couple { i, j });
                    kept_shifts.extend(place.checked_sub(unshifted).map(|place| couples.shifts[place]));
                }
            }
            Ok((kept, kept_shifts))
        })?;
        let rows = kept_shifts.len();
        let shifts = kept_shifts.into_flattened().into_pyarray(py).reshape([rows, D])?;
        Ok((into_pairs(py, kept)?, shifts))
    })
}
