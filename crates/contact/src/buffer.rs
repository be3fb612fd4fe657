//! Couples of moving elements: candidates are detected with a buffer and reused until an element has moved
//! too far.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::couple::Couple;
use crate::detector::Detector;
use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::{GroupMatrix, Labels};
use crate::geometry::Geometry;
use crate::memory::reserve;
use crate::ordered;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::Search;
use crate::simd::extremes::Motions;

/// Repeated contact detection that keeps its candidates until an element has moved farther than half the
/// buffer.
///
/// A detection with the tolerance enlarged by the *buffer* finds candidates. They contain every couple until
/// two elements have approached each other by the buffer, which requires that one has moved by half of it.
/// Motion is measured relative to the mean motion of all elements, so a common translation costs nothing.
/// [`Buffered::update`] measures the motion and detects again only when needed. The couples are those
/// candidates that touch now, by the comparison of [`Elements`].
///
/// A large buffer makes detections rare but candidates many: `(1 + buffer/diameter)^D` times the couples of a
/// dense packing. A tenth to a third of the diameter is usual.
///
/// # Why no couple is lost
/// Let `X` be the positions at the detection, `x` the current ones, `c` any vector that is the same for all
/// elements, and `w_i = (x_i - X_i) - c`. Then `|X_i - X_j| <= |x_i - x_j| + |w_i| + |w_j|`, because `c`
/// cancels. Therefore `c` need not be the mean to the last bit, nor the mean at all. Elements that touch now
/// have `|x_i - x_j| <= reach + p`. Elements with `|X_i - X_j| <= reach + b - P` are candidates. Here `b` is
/// the difference of the two rounded tolerances, and `p` and `P` bound the errors of the two comparisons
/// (`Elements::rounding`, which covers corners of boxes too, whose motion is measured axis by axis). No
/// couple is lost while all `|w_i| <= (b - p - P) / 2`.
///
/// The `|w_i|` are computed in `f64`, with `v = 2^-53`. The two subtractions err by at most
/// `v (2 |w_i| + |c|)` to first order. The comparison of the square of `w_i` with that of the limit errs by
/// less than `(D + 3) v` relative to `|w_i|`. The limit is the bound above minus `(D + 8) 2 v` times the
/// larger tolerance, which is at least `b`, and minus `2 v` times the sum of the `|c|` of all axes. That is
/// twice the necessary margin; the remainder covers the roundings of the limit itself. If `c` is in the
/// middle of all motions, the corner of the box that holds them is compared instead of each `w_i`: rounding
/// is monotonic, so its computed square is at least as large as theirs. Squares that underflow are covered by
/// `MIN_RESOLVED` in `p` and `P`.
///
/// # Shapes
/// Elements of any shape. Each update may use other arrays. Element `i` must be the same element throughout;
/// otherwise it counts as moved, and the update detects again. A changed filter is noticed too.
///
/// # Order
/// The order of the candidates, which is that of the engine at the last detection. It depends on the sequence
/// of updates.
///
/// # Cost
/// An update that keeps the candidates takes one pass over the positions, two once elements have moved nearly
/// as far as the buffer covers, and, for the couples, one over the candidates, on any number of threads. The
/// pass over the candidates reads coordinates in spatial order, so it is twice as fast if elements are
/// numbered along space as if they are numbered at random. It can be skipped: [`Update::candidates`]. An
/// update that detects takes at most two passes over the positions, a search, and a copy of positions, radii
/// and filter. Memory: that of the search, the copy, and 8 bytes per candidate.
///
/// # Source
/// L. Verlet, "Computer experiments on classical fluids", Phys. Rev. 159 (1967) 98-103: lists with a skin. A.
/// Munjiza, "The Combined Finite-Discrete Element Method" (2004): the buffer. Subtracting the mean motion and
/// the margin for rounding are our own.
///
/// # Example
/// ```
/// use fdem_contact::{Buffered, Couple, Elements, Reason};
///
/// let mut centres = [[0.0, 0.0], [1.25, 0.0], [9.0, 0.0]];
/// let mut buffered = Buffered::new(0.5)?;
/// let mut couples = Vec::new();
///
/// let update = buffered.update(&Elements::points(&centres, 1.0)?)?;
/// assert_eq!(update.reason(), Some(Reason::First));
/// assert_eq!(update.count(), 0);
///
/// centres[1][0] = 1.0; // By half the buffer, but a third of it is mean motion.
/// let update = buffered.update(&Elements::points(&centres, 1.0)?)?;
/// assert!(!update.redetected());
/// update.couples(&mut couples)?;
/// assert_eq!(couples, [Couple::new(0, 1)]);
///
/// centres[2][0] = 2.0;
/// let update = buffered.update(&Elements::points(&centres, 1.0)?)?;
/// assert!(matches!(update.reason(), Some(Reason::Moved { element: 2, .. })));
/// assert_eq!(update.count(), 2);
/// assert_eq!((buffered.updates(), buffered.redetections()), (3, 2));
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "skin")]
#[doc(alias = "Verlet list")]
#[derive(Clone, Debug)]
pub struct Buffered<T, const D: usize, S = Detector<T, D>> {
    search: S,
    buffer: T,
    candidates: Vec<Couple>,
    pool: Pool,
    /// The elements at the last detection; `None` before the first detection and after one that failed.
    reference: Option<Reference<T, D>>,
    updates: u64,
    redetections: u64,
}

/// Why an update detected again.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// There were no candidates: it was the first update, or the first after one that failed.
    First,
    /// An element, or a corner of its box, moved farther than the buffer covers.
    Moved {
        /// The element that moved farthest, by its zero-based number.
        element: usize,
        /// Its motion relative to the mean motion of all; for boxes, along the axis of the largest motion.
        distance: f64,
        /// The allowed motion: half the buffer minus a margin for rounding.
        limit: f64,
    },
    /// The radius of an element differs. (A box that grows has moved corners instead.)
    SizeChanged {
        /// Zero-based number of the first such element; 0 if all have one radius.
        element: usize,
    },
    /// The number of elements differs.
    CountChanged {
        /// The number at the last detection.
        before: usize,
        /// The number now.
        now: usize,
    },
    /// Spheres have become boxes, or boxes spheres.
    ShapeChanged,
    /// The tolerance of the elements differs.
    ToleranceChanged,
    /// The numbers of the filter or its matrix differ, or may differ.
    FilterChanged {
        /// The first element with other numbers; `None` if there is none, or if the filters are of different
        /// kinds.
        element: Option<usize>,
    },
    /// The box that repeats differs: its origin, an edge, or which edges repeat.
    BoxChanged,
    /// The buffer is zero, or no larger than the rounding of coordinates and sizes, so it covers no motion.
    BufferTooSmall,
}

impl fmt::Display for Reason {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::First => out.write_str("there were no candidates yet"),
            Self::Moved { element, distance, limit } => {
                write!(
                    out,
                    "element {element} moved by {distance:e} relative to the mean, more than {limit:e}"
                )
            }
            Self::SizeChanged { element } => write!(out, "the radius of element {element} changed"),
            Self::CountChanged { before, now } => write!(out, "{before} elements became {now}"),
            Self::ShapeChanged => out.write_str("the elements are of another kind"),
            Self::ToleranceChanged => out.write_str("the tolerance changed"),
            Self::FilterChanged { element: Some(element) } => {
                write!(out, "the filter changed, first for element {element}")
            }
            Self::FilterChanged { element: None } => out.write_str("the filter changed"),
            Self::BoxChanged => out.write_str("the box that repeats changed"),
            Self::BufferTooSmall => {
                out.write_str("the buffer is no more than the rounding of the coordinates")
            }
        }
    }
}

/// The result of [`Buffered::update`]: the current elements, and candidates that contain all of their
/// couples.
#[derive(Clone, Copy, Debug)]
#[must_use = "the couples are in here"]
pub struct Update<'a, T, const D: usize> {
    elements: Elements<'a, T, D>,
    candidates: &'a [Couple],
    pool: &'a Pool,
    reason: Option<Reason>,
}

/// A copy of the elements at the last detection.
#[derive(Clone, Debug)]
pub(crate) struct Reference<T, const D: usize> {
    kind: ElementKind,
    tolerance: T,
    /// Difference between the tolerance of the detection and that of the elements.
    buffer: f64,
    /// Bound on the error of the comparison with the enlarged tolerance: `Elements::rounding`.
    rounding: f64,
    /// Centres, or minimum corners.
    points: Vec<[T; D]>,
    /// Maximum corners; empty for spheres.
    far_points: Vec<[T; D]>,
    /// The radius of each element, or the one radius of all; empty for boxes.
    radii: Vec<T>,
    /// The numbers of the filter, and its matrix.
    labels: Labels,
    matrix: Option<GroupMatrix>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ElementKind {
    Spheres,
    Boxes,
}

/// Slices of the numbers of a shape.
struct Numbers<'a, T, const D: usize> {
    kind: ElementKind,
    points: &'a [[T; D]],
    far_points: &'a [[T; D]],
    radii: &'a [T],
}

impl<'a, T: Real, const D: usize> Numbers<'a, T, D> {
    fn of(elements: &'a Elements<'_, T, D>) -> Self {
        let (kind, points, far_points, radii): (_, _, &[[T; D]], &[T]) = match &elements.shape {
            Shape::Equal(equal) => (ElementKind::Spheres, equal.points(), &[], equal.radii()),
            Shape::Spheres(spheres) => (ElementKind::Spheres, spheres.points(), &[], spheres.radii()),
            Shape::Boxes(boxes) => (ElementKind::Boxes, boxes.points(), boxes.far_points(), &[]),
        };
        Self { kind, points, far_points, radii }
    }
}

impl<T: Real, const D: usize> Buffered<T, D> {
    /// A detector with nothing detected yet; the engine is chosen from the elements.
    ///
    /// # Units
    /// `buffer` shares the length unit of the elements. With 0 every update detects.
    ///
    /// # Errors
    /// [`Error::InvalidBuffer`] if `buffer` is negative, NaN, infinite or beyond [`Real::MAX_MAGNITUDE`].
    pub fn new(buffer: T) -> Result<Self, Error> {
        Self::with_search(Detector::new(), buffer)
    }
}

impl<T: Real, const D: usize, S: Search<T, D>> Buffered<T, D, S> {
    /// Like [`Buffered::new`], with the caller's own search.
    ///
    /// # Errors
    /// As [`Buffered::new`].
    pub fn with_search(search: S, buffer: T) -> Result<Self, Error> {
        if !(buffer >= T::ZERO && buffer <= T::MAX_MAGNITUDE) {
            let limit = T::MAX_MAGNITUDE.to_f64();
            return Err(Error::InvalidBuffer { value: buffer.to_f64(), limit });
        }
        let (candidates, pool) = (Vec::new(), Pool::default());
        Ok(Self { search, buffer, candidates, pool, reference: None, updates: 0, redetections: 0 })
    }

    /// The same, with candidates tested on `threads` threads. 0 is one per processor; 1 is the default and
    /// uses no thread pool. The threads of the search are set separately. The couples and their order are the
    /// same for any number.
    ///
    /// # Errors
    /// [`Error::NoThreads`] if the threads cannot be started, if there are more than 1024, or if the crate
    /// was built without its feature `rayon`.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?;
        Ok(self)
    }

    /// The candidates for `elements`: the existing ones if they still contain every couple, otherwise new
    /// ones.
    ///
    /// # Errors
    /// The errors of the search; [`Error::InvalidTolerance`] if tolerance and buffer together exceed
    /// [`Real::MAX_MAGNITUDE`]; [`Error::OutOfMemory`]. After an error nothing is kept, and the next update
    /// detects.
    pub fn update<'a>(&'a mut self, elements: &Elements<'a, T, D>) -> Result<Update<'a, T, D>, Error> {
        let reason = match &self.reference {
            None => Some(Reason::First),
            Some(reference) => reference.outdated_by(elements, 0.0),
        };
        if reason.is_some() {
            self.detect(elements)?;
            self.redetections += 1;
        }
        self.updates += 1;
        Ok(Update { elements: *elements, candidates: &self.candidates, pool: &self.pool, reason })
    }

    /// Couples that may touch: [`Update::candidates`] of the last update.
    pub fn candidates(&self) -> &[Couple] {
        &self.candidates
    }

    /// The gap that candidates may have beyond the tolerance.
    pub fn buffer(&self) -> T {
        self.buffer
    }

    /// Number of updates that succeeded.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Number of updates that detected, the first one included.
    pub fn redetections(&self) -> u64 {
        self.redetections
    }

    /// The search that detects.
    pub fn search(&self) -> &S {
        &self.search
    }

    fn detect(&mut self, elements: &Elements<'_, T, D>) -> Result<(), Error> {
        // Taken out while anything below can fail; its memory is reused.
        let mut reference = self.reference.take().unwrap_or_else(Reference::empty);
        let tolerance = elements.tolerance();
        let enlarged = elements.with_tolerance(tolerance + self.buffer)?;
        self.search.couples(&enlarged, &mut self.candidates)?;
        reference.copy(elements, &enlarged)?;
        self.reference = Some(reference);
        Ok(())
    }
}

impl<T: Real, const D: usize> Reference<T, D> {
    pub(crate) fn empty() -> Self {
        Self {
            kind: ElementKind::Spheres,
            tolerance: T::ZERO,
            buffer: 0.0,
            rounding: 0.0,
            points: Vec::new(),
            far_points: Vec::new(),
            radii: Vec::new(),
            labels: Labels::default(),
            matrix: None,
        }
    }

    /// Copies the elements; the candidates are the couples of `enlarged`, the same elements with the larger
    /// tolerance.
    pub(crate) fn copy(
        &mut self,
        elements: &Elements<'_, T, D>,
        enlarged: &Elements<'_, T, D>,
    ) -> Result<(), Error> {
        let numbers = Numbers::of(elements);
        self.kind = numbers.kind;
        copy(numbers.points, &mut self.points)?;
        copy(numbers.far_points, &mut self.far_points)?;
        copy(numbers.radii, &mut self.radii)?;
        let matrix = elements.filter().and_then(|filter| filter.matrix());
        self.matrix = matrix.map(GroupMatrix::copy).transpose()?;
        self.tolerance = elements.tolerance();
        self.buffer = enlarged.tolerance().to_f64() - elements.tolerance().to_f64();
        self.rounding = enlarged.rounding();
        self.labels.copy(elements.filter())
    }

    /// Centres, or minimum corners.
    pub(crate) fn points(&self) -> &[[T; D]] {
        &self.points
    }

    /// The reason why the candidates may lack a couple of `elements`; `None` if they cannot. `rounding`
    /// bounds further errors of the distances, at the detection and now together.
    pub(crate) fn outdated_by(&self, elements: &Elements<'_, T, D>, rounding: f64) -> Option<Reason> {
        let now = Numbers::of(elements);
        if now.points.len() != self.points.len() {
            return Some(Reason::CountChanged { before: self.points.len(), now: now.points.len() });
        }
        if now.kind != self.kind {
            return Some(Reason::ShapeChanged);
        }
        if elements.tolerance() != self.tolerance {
            return Some(Reason::ToleranceChanged);
        }
        if let Some(element) = first_change(now.radii, &self.radii) {
            return Some(Reason::SizeChanged { element });
        }
        let filter = elements.filter();
        if !self.labels.equal(filter) || self.matrix.as_ref() != filter.and_then(|filter| filter.matrix()) {
            return Some(Reason::FilterChanged { element: self.labels.first_change(filter) });
        }
        self.moved(elements, &now, rounding)
    }

    /// Whether an element moved too far relative to a common motion.
    fn moved(&self, elements: &Elements<'_, T, D>, now: &Numbers<'_, T, D>, rounding: f64) -> Option<Reason> {
        if now.points.is_empty() {
            return None;
        }
        let motions = [
            Motion { now: now.points, before: &self.points },
            Motion { now: now.far_points, before: &self.far_points },
        ];
        let roundings = self.rounding + elements.rounding() + rounding;
        let enlarged = self.tolerance.to_f64() + self.buffer;
        let limit = |common: &[f64; D]| {
            0.5 * (self.buffer - roundings)
                - f64::EPSILON * ((D + 8) as f64 * enlarged + common.iter().map(|c| c.abs()).sum::<f64>())
        };
        let combine = match self.kind {
            ElementKind::Spheres => |sum: f64, square: f64| sum + square,
            ElementKind::Boxes => f64::max,
        };

        // Any common motion will do. The motion in the middle of all is tried first: only the extremes are
        // needed to compare with it.
        let all = motions.iter().fold(Motions::NONE, |all, motion| all.with(motion.now, motion.before));
        let middle = std::array::from_fn(|axis| f64::midpoint(all.min[axis], all.max[axis]));
        let corner = (0..D).fold(0.0, |squared, axis| {
            let (low, high) = (all.min[axis] - middle[axis], all.max[axis] - middle[axis]);
            combine(squared, f64::max(low * low, high * high))
        });
        let within = limit(&middle);
        if within > 0.0 && corner <= within * within {
            return None;
        }

        let count = (now.points.len() + now.far_points.len()) as f64;
        let mean = all.sum.map(|sum| sum / count);
        let limit = limit(&mean);
        if limit.is_nan() || limit <= 0.0 {
            return Some(Reason::BufferTooSmall);
        }
        let [near, far] = match self.kind {
            ElementKind::Spheres => motions.map(|motion| motion.farthest(&mean, |sum, square| sum + square)),
            ElementKind::Boxes => motions.map(|motion| motion.farthest(&mean, f64::max)),
        };
        let (element, squared) = if far.1 > near.1 { far } else { near };
        (squared > limit * limit).then(|| Reason::Moved { element, distance: squared.sqrt(), limit })
    }
}

/// The first element with another radius than before; a slice of one radius stands for all elements.
fn first_change<T: Real>(now: &[T], before: &[T]) -> Option<usize> {
    match (now, before) {
        (&[one], before) => before.iter().position(|&radius| radius != one),
        (now, &[one]) => now.iter().position(|&radius| radius != one),
        (now, before) => now.iter().zip(before).position(|(now, before)| now != before),
    }
}

/// Positions of points now and at the last detection.
struct Motion<'a, T, const D: usize> {
    now: &'a [[T; D]],
    before: &'a [[T; D]],
}

impl<T: Real, const D: usize> Motion<'_, T, D> {
    /// The point that moved farthest relative to `mean`, and the square of its motion, combined from the
    /// axes.
    #[inline]
    fn farthest(&self, mean: &[f64; D], combine: impl Fn(f64, f64) -> f64) -> (usize, f64) {
        let mut worst = (0, 0.0);
        for (index, (now, before)) in self.now.iter().zip(self.before).enumerate() {
            let mut squared = 0.0;
            for axis in 0..D {
                let motion = (now[axis].to_f64() - before[axis].to_f64()) - mean[axis];
                squared = combine(squared, motion * motion);
            }
            if squared > worst.1 {
                worst = (index, squared);
            }
        }
        worst
    }
}

impl<T: Real, const D: usize> Update<'_, T, D> {
    /// The reason for a new detection; `None` if the candidates were kept.
    pub fn reason(&self) -> Option<Reason> {
        self.reason
    }

    /// Whether there was a new detection.
    pub fn redetected(&self) -> bool {
        self.reason.is_some()
    }

    /// Couples that may touch: all that do, and others whose gap is at most the buffer plus twice the motion.
    ///
    /// A narrow phase that computes the distance anyway can use these instead of [`Update::couples`], which
    /// is most of the cost of an update.
    pub fn candidates(&self) -> &[Couple] {
        self.candidates
    }

    /// Calls `visit` with every couple that touches now, in the order of the candidates.
    pub fn for_each(&self, mut visit: impl FnMut(Couple)) {
        self.touching(self.candidates, |couples| couples.iter().copied().for_each(&mut visit));
    }

    /// Writes the couples that touch now into `couples`, in the order of the candidates. `couples` is cleared
    /// first.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; `couples` is then empty.
    pub fn couples(&self, couples: &mut Vec<Couple>) -> Result<(), Error> {
        couples.clear();
        if self.pool.threads() == 1 {
            return self.append_touching(self.candidates, couples);
        }
        let parts: Vec<_> = self.candidates.chunks(PART).collect();
        let fill = |part: usize, list: &mut Vec<Couple>| self.append_touching(parts[part], list);
        ordered::append(couples, parts.len(), fill, self.pool, &mut Vec::new())
            .inspect_err(|_| couples.clear())
    }

    fn append_touching(&self, candidates: &[Couple], couples: &mut Vec<Couple>) -> Result<(), Error> {
        reserve(couples, candidates.len())?;
        self.touching(candidates, |found| couples.extend_from_slice(found));
        Ok(())
    }

    /// The number of couples that touch now.
    pub fn count(&self) -> u64 {
        let total = AtomicU64::new(0);
        self.pool.run(self.candidates.chunks(PART), |candidates| {
            let mut count = 0;
            self.touching(candidates, |found| count += found.len() as u64);
            total.fetch_add(count, Ordering::Relaxed);
        });
        total.into_inner()
    }

    /// Passes on those of `candidates` that touch, in blocks. All satisfy the filter, which is that of the
    /// detection.
    fn touching(&self, candidates: &[Couple], visit: impl FnMut(&[Couple])) {
        match self.elements.shape {
            Shape::Equal(equal) => touching(equal, candidates, visit),
            Shape::Spheres(spheres) => touching(spheres, candidates, visit),
            Shape::Boxes(boxes) => touching(boxes, candidates, visit),
        }
    }
}

/// Number of candidates that a thread takes at a time.
const PART: usize = 16_384;

/// Number of candidates that are tested before those that touch are passed on: they stay in the first-level
/// cache.
const TESTED_AT_ONCE: usize = 512;

fn touching<G: Geometry>(geometry: G, candidates: &[Couple], mut visit: impl FnMut(&[Couple])) {
    let mut found = [Couple { i: 0, j: 1 }; TESTED_AT_ONCE];
    for candidates in candidates.chunks(TESTED_AT_ONCE) {
        let mut count = 0;
        for &couple in candidates {
            // Always written, then kept or not: a branch on whether they touch would be unpredictable.
            found[count] = couple;
            count += usize::from(geometry.touch(couple.i as usize, couple.j as usize));
        }
        visit(&found[..count]);
    }
}

fn copy<V: Copy>(from: &[V], to: &mut Vec<V>) -> Result<(), Error> {
    to.clear();
    reserve(to, from.len())?;
    to.extend_from_slice(from);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The box around the motions reaches beyond the limit at its corners; a motion does so only in the last
    /// case.
    #[test]
    fn a_motion_counts_by_its_length_where_the_box_around_all_does_not_decide() {
        let at = |by: f64| [[by, 0.0], [10.0 - by, 0.0], [20.0, by], [30.0, -by]];
        for (by, is_kept) in [(0.05, true), (0.09, true), (0.11, false)] {
            let mut buffered = Buffered::new(0.2).unwrap();
            let _ = buffered.update(&Elements::points(&at(0.0), 1.0).unwrap()).unwrap();
            let now = at(by);
            let update = buffered.update(&Elements::points(&now, 1.0).unwrap()).unwrap();
            match update.reason() {
                None => assert!(is_kept, "{by}"),
                Some(Reason::Moved { distance, limit, .. }) => {
                    assert!(!is_kept && (distance - by).abs() < 1e-12 && limit < 0.1, "{by}: {distance}");
                }
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn the_farthest_is_found_by_norm_or_by_axis() {
        let motion = Motion { now: &[[0.0_f32, 0.0], [3.0, 3.0], [4.0, 0.0]], before: &[[0.0; 2]; 3] };
        assert_eq!(motion.farthest(&[0.0, 0.0], |sum, square| sum + square), (1, 18.0));
        assert_eq!(motion.farthest(&[0.0, 0.0], f64::max), (2, 16.0));
    }
}
