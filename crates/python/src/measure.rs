//! Distances and overlaps of couples.

use fdem_contact::{Error, PeriodicBox};
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::elements::{Elements, Set, SetSizes};
use crate::interrupt::{self, Stop};
use crate::number::{Number, rows_of, with_kind};
use crate::problem::{Problem, zeros};
use crate::search::threads_for;
use crate::tasks;

/// Couples that a thread measures at a time: enough to be worth a thread.
const PART: usize = 1 << 15;

/// Fills `values` on up to `threads` threads; `value` gets the place of the value.
fn fill<V: Copy + Send>(values: &mut [V], threads: usize, value: impl Fn(usize) -> V + Sync) {
    tasks::run(threads, values.chunks_mut(PART).enumerate(), |(part, values)| {
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
        sum.sqrt()
    }

    /// The sum of the radii, or the cut-off, less the distance; for boxes the smallest overlap along an axis.
    fn overlap(&self, couple: usize) -> T {
        let [i, j] = self.pairs[couple].map(|element| element as usize);
        match self.set.sizes {
            SetSizes::Each(radii) => (radii[i] + radii[j]) - self.distance(couple),
            SetSizes::All(radius) => (radius + radius) - self.distance(couple),
            SetSizes::Cutoff(cutoff) => cutoff - self.distance(couple),
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
        let values = interrupt::run(py, false, &stop, || {
            let n = couples.set.points.len();
            let unknown = couples.pairs.as_flattened().iter().any(|&element| element as usize >= n);
            if unknown || couples.shifts.len() > couples.pairs.len() {
                return Err(Problem::Arguments("couples of other elements".to_owned()));
            }
            if let SetSizes::Each(radii) = couples.set.sizes && radii.len() != n {
                return Err(Error::LengthMismatch { what: "radii", expected: n, found: radii.len() }.into());
            }
            let mut values = zeros::<T>(couples.pairs.len())?;
            let threads = threads_for(threads, couples.pairs.len());
            if overlap {
                fill(&mut values, threads, |couple| couples.overlap(couple));
            } else {
                fill(&mut values, threads, |couple| couples.distance(couple));
            }
            Ok(values)
        })?;
        Ok(values.into_pyarray(py).into_any())
    })
}
