//! Couples of moving elements: detect once with a buffer, then check the candidates while nothing has moved far.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::couple::Couple;
use crate::elements::{Elements, Geometry, Shape};
use crate::engine::{Detector, Engine};
use crate::error::Error;
use crate::filter::{GroupMatrix, Labels};
use crate::ordered;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::Search;
use crate::search::rows::reserve;

/// Repeated contact detection that keeps its candidates while no element has moved farther than half the buffer.
///
/// A detection with the tolerance enlarged by the *buffer* finds candidates. They contain every couple until two
/// elements have come nearer by the buffer, which takes one that has moved by half of it. Motion is counted relative
/// to the mean motion of all elements: a body that flies, or a moving frame, costs nothing. [`Buffered::update`] looks at the
/// motion and detects again only then; the couples are those candidates that touch now, by the comparison of [`Elements`].
///
/// A large buffer makes detections rare and candidates many, `(1 + buffer/diameter)^D` times the couples of a dense
/// packing; a tenth to a third of the diameter is usual.
///
/// # Why no couple is lost
/// Let `X` be the positions at the detection, `x` those now, and `c` any vector, the same for all elements; `w_i = (x_i - X_i) - c`. Then
/// `|X_i - X_j| <= |x_i - x_j| + |w_i| + |w_j|`, because `c` cancels. So `c` need not be the mean to the last bit, nor the
/// mean at all. What touches now has `|x_i - x_j| <= reach + p`, and what had `|X_i - X_j| <= reach + b - P` is a candidate;
/// `b` is the difference of the two tolerances as they were rounded, and `p` and `P` are what the two comparisons may err by
/// (`Elements::rounding`, where the same is said for corners of boxes, whose motion is measured axis by axis). No couple is lost
/// while all `|w_i| <= (b - p - P) / 2`.
///
/// The `|w_i|` are computed in `f64`, with `v = 2^-53`: the two subtractions err by at most `v (2 |w_i| + |c|)` to first order; the square of `w_i` and that of the
/// limit, compared, by less than `(D + 3) v` relative to `|w_i|`. The limit is the bound above, less `(D + 8) 2 v` times the
/// larger tolerance, which is at least `b`, and less `2 v` times the sum of the `|c|` of all axes: twice what is needed, and the
/// remainder covers the roundings of the limit itself. Squares that underflow are covered by `MIN_RESOLVED` in `p` and `P`.
///
/// # Shapes
/// Elements of any shape; those of one update may lie in other arrays than those of the last. Element `i` is
/// the same element throughout (if not, it has moved, and this is noticed). A filter that changes is noticed too.
///
/// # Order
/// That of the candidates, which is the order of the engine at the last detection. It depends on the sequence of updates.
///
/// # Cost
/// An update that keeps the candidates: one pass over the positions, and one over the candidates for the couples, on any number of threads. This second
/// one gathers coordinates in the order of space: where elements are numbered along space it takes half as long as where they are numbered
/// at random. It can be left out: [`Update::candidates`]. One that detects: at most two passes over the positions, a search, and a copy of positions, radii and filter. Memory: that of the search, the copy,
/// and 8 bytes per candidate.
///
/// # Source
/// L. Verlet, "Computer experiments on classical fluids", Phys. Rev. 159 (1967) 98-103: lists with a skin. A. Munjiza, "The Combined
/// Finite-Discrete Element Method" (2004): the buffer. The mean motion and the margin for rounding are ours.
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
    /// The elements at the last detection; `None` before the first and after one that failed.
    reference: Option<Reference<T, D>>,
    updates: u64,
    redetections: u64,
}

/// Why an update detected again.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// There were no candidates: the first update, or the first after one that failed.
    First,
    /// An element, or a corner of its box, moved farther than the buffer covers.
    Moved {
        /// The element that moved farthest, by its zero-based number.
        element: usize,
        /// How far, relative to the mean motion of all; for boxes, along the axis on which it was farthest.
        distance: f64,
        /// How far it may: half the buffer, less what roundings can amount to.
        limit: f64,
    },
    /// The radius of an element differs. (A box that grows has moved its corners.)
    SizeChanged {
        /// Zero-based number of the first such element; 0 if all have one radius.
        element: usize,
    },
    /// The number of elements differs.
    CountChanged {
        /// At the last detection.
        before: usize,
        /// Now.
        now: usize,
    },
    /// The elements are of another kind: spheres of one radius, spheres with radii, or boxes.
    ShapeChanged,
    /// The tolerance of the elements differs.
    ToleranceChanged,
    /// Which elements see each other differs, or may: the numbers of the filter, or its matrix.
    FilterChanged {
        /// The first element with other numbers; `None` if there is none, or if the filters are of different kinds.
        element: Option<usize>,
    },
    /// The buffer is zero, or no more than the rounding of coordinates and sizes: no motion at all is covered.
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
            Self::BufferTooSmall => {
                out.write_str("the buffer is no more than the rounding of the coordinates")
            }
        }
    }
}

/// The elements now, and the candidates that contain all of their couples: what [`Buffered::update`] returns.
#[derive(Clone, Copy, Debug)]
#[must_use = "the couples are in here"]
pub struct Update<'a, T, const D: usize> {
    elements: Elements<'a, T, D>,
    candidates: &'a [Couple],
    pool: &'a Pool,
    reason: Option<Reason>,
}

/// Elements as they were, copied.
#[derive(Clone, Debug)]
struct Reference<T, const D: usize> {
    kind: Kind,
    tolerance: T,
    /// Difference of the tolerances with which and for which the candidates were found.
    buffer: f64,
    /// What the comparison may err by: `Elements::rounding`, of the enlarged tolerance.
    rounding: f64,
    /// Centres, or minimum corners.
    points: Vec<[T; D]>,
    /// Maximum corners; empty for spheres.
    far_points: Vec<[T; D]>,
    /// The radius of each, or the one radius of all; empty for boxes.
    radii: Vec<T>,
    /// The numbers of the filter, and its matrix.
    labels: Labels,
    matrix: Option<GroupMatrix>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Equal,
    Spheres,
    Boxes,
}

/// The numbers of a shape, as slices.
struct Numbers<'a, T, const D: usize> {
    kind: Kind,
    points: &'a [[T; D]],
    far_points: &'a [[T; D]],
    radii: &'a [T],
}

impl<'a, T: Real, const D: usize> Numbers<'a, T, D> {
    fn of(elements: &'a Elements<'_, T, D>) -> Self {
        let (kind, points, far_points, radii): (_, _, &[[T; D]], &[T]) = match &elements.shape {
            Shape::Equal(equal) => (Kind::Equal, equal.points(), &[], equal.radii()),
            Shape::Spheres(spheres) => (Kind::Spheres, spheres.points(), &[], spheres.radii()),
            Shape::Boxes(boxes) => (Kind::Boxes, boxes.points(), boxes.far_points(), &[]),
        };
        Self { kind, points, far_points, radii }
    }
}

impl<T: Real, const D: usize> Buffered<T, D> {
    /// Nothing detected yet; the engine is picked from the elements.
    ///
    /// # Units
    /// `buffer` shares the length unit of the elements. With 0 every update detects.
    ///
    /// # Errors
    /// [`Error::InvalidBuffer`] for one that is negative, NaN, infinite or beyond [`Real::MAX_MAGNITUDE`].
    pub fn new(buffer: T) -> Result<Self, Error> {
        Self::with_search(Detector::new(Engine::Auto), buffer)
    }
}

impl<T: Real, const D: usize, S: Search<T, D>> Buffered<T, D, S> {
    /// The same with a search of the caller's.
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

    /// The same with candidates tested on `threads` threads; 0 is one for each processor, 1 is the default and uses no pool. Those of
    /// the search are its own. The couples and their order are the same for any number.
    ///
    /// # Errors
    /// [`Error::NoThreads`] if they cannot be had, above 1024, or if the crate was built without its feature `rayon`.
    pub fn with_threads(mut self, threads: usize) -> Result<Self, Error> {
        self.pool = Pool::new(threads)?;
        Ok(self)
    }

    /// The candidates for `elements`: those at hand if they still contain every couple, new ones otherwise.
    ///
    /// # Errors
    /// Those of the search; [`Error::InvalidTolerance`] if tolerance and buffer together are beyond
    /// [`Real::MAX_MAGNITUDE`]; [`Error::OutOfMemory`]. Nothing is kept then, and the next update detects.
    pub fn update<'a>(&'a mut self, elements: &Elements<'a, T, D>) -> Result<Update<'a, T, D>, Error> {
        let reason = match &self.reference {
            None => Some(Reason::First),
            Some(reference) => reference.outdated_by(elements),
        };
        if reason.is_some() {
            self.detect(elements)?;
            self.redetections += 1;
        }
        self.updates += 1;
        Ok(Update { elements: *elements, candidates: &self.candidates, pool: &self.pool, reason })
    }

    /// The gap that candidates have beyond the tolerance.
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
        // Missing while anything below can fail; its memory is used again.
        let mut reference = self.reference.take().unwrap_or_else(Reference::empty);
        let tolerance = elements.tolerance();
        let enlarged = elements.with_tolerance(tolerance + self.buffer)?;
        self.search.couples(&enlarged, &mut self.candidates)?;
        reference.copy(elements)?;
        reference.tolerance = tolerance;
        reference.buffer = enlarged.tolerance().to_f64() - tolerance.to_f64();
        reference.rounding = enlarged.rounding();
        self.reference = Some(reference);
        Ok(())
    }
}

/// Elements whose motion is averaged for a first guess at the mean of all.
const SAMPLE: usize = 1024;

impl<T: Real, const D: usize> Reference<T, D> {
    fn empty() -> Self {
        Self {
            kind: Kind::Equal,
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

    fn copy(&mut self, elements: &Elements<'_, T, D>) -> Result<(), Error> {
        let numbers = Numbers::of(elements);
        self.kind = numbers.kind;
        copy(numbers.points, &mut self.points)?;
        copy(numbers.far_points, &mut self.far_points)?;
        copy(numbers.radii, &mut self.radii)?;
        let matrix = elements.filter().and_then(|filter| filter.matrix());
        self.matrix = matrix.map(GroupMatrix::copy).transpose()?;
        self.labels.copy(elements.filter())
    }

    /// Why the candidates may lack a couple of `elements`; `None` if they cannot.
    fn outdated_by(&self, elements: &Elements<'_, T, D>) -> Option<Reason> {
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
        if now.radii != self.radii {
            let element = now.radii.iter().zip(&self.radii).position(|(now, before)| now != before);
            return Some(Reason::SizeChanged { element: element.unwrap_or(0) });
        }
        let filter = elements.filter();
        if !self.labels.equal(filter) || self.matrix.as_ref() != filter.and_then(|filter| filter.matrix()) {
            return Some(Reason::FilterChanged { element: self.labels.first_change(filter) });
        }
        // Any common motion will do, so that of a sample is tried first: it saves a pass over all.
        let n = now.points.len();
        let step = n.div_ceil(SAMPLE).max(1);
        let reason = self.moved(elements, &now, step)?;
        if step == 1 { Some(reason) } else { self.moved(elements, &now, 1) }
    }

    /// Whether an element moved too far relative to the mean motion of every `step`-th.
    fn moved(&self, elements: &Elements<'_, T, D>, now: &Numbers<'_, T, D>, step: usize) -> Option<Reason> {
        let motions = [
            Motion { now: now.points, before: &self.points },
            Motion { now: now.far_points, before: &self.far_points },
        ];
        let mean = mean_motion(&motions, step);

        let roundings = self.rounding + elements.rounding();
        let enlarged = self.tolerance.to_f64() + self.buffer;
        let limit = 0.5 * (self.buffer - roundings)
            - f64::EPSILON * ((D + 8) as f64 * enlarged + mean.iter().map(|c| c.abs()).sum::<f64>());
        if limit.is_nan() || limit <= 0.0 {
            return (!now.points.is_empty()).then_some(Reason::BufferTooSmall);
        }

        let [near, far] = motions.map(|motion| match self.kind {
            Kind::Equal | Kind::Spheres => motion.farthest(&mean, |sum, square| sum + square),
            Kind::Boxes => motion.farthest(&mean, f64::max),
        });
        let (element, squared) = if far.1 > near.1 { far } else { near };
        (squared > limit * limit).then(|| Reason::Moved { element, distance: squared.sqrt(), limit })
    }
}

/// Points now and before.
struct Motion<'a, T, const D: usize> {
    now: &'a [[T; D]],
    before: &'a [[T; D]],
}

impl<T: Real, const D: usize> Motion<'_, T, D> {
    /// The point that moved farthest relative to `mean`, and the square of its motion: the squares of the axes, combined.
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

/// The mean motion of every `step`-th point of all arrays; zero if there are none.
fn mean_motion<T: Real, const D: usize>(motions: &[Motion<'_, T, D>], step: usize) -> [f64; D] {
    let mut sum = [0.0; D];
    let mut count = 0.0_f64;
    for motion in motions {
        for (now, before) in motion.now.iter().zip(motion.before).step_by(step) {
            for axis in 0..D {
                sum[axis] += now[axis].to_f64() - before[axis].to_f64();
            }
            count += 1.0;
        }
    }
    sum.map(|sum| sum / count.max(1.0))
}

impl<T: Real, const D: usize> Update<'_, T, D> {
    /// Why there was a new detection, or `None` if the candidates were kept.
    pub fn reason(&self) -> Option<Reason> {
        self.reason
    }

    /// Whether there was a new detection.
    pub fn redetected(&self) -> bool {
        self.reason.is_some()
    }

    /// Couples that may touch: all that do, and others that are no more than the buffer and twice the motion apart.
    ///
    /// For a narrow phase that computes the distance anyway, this saves [`Update::couples`], which is most of an update.
    pub fn candidates(&self) -> &[Couple] {
        self.candidates
    }

    /// Calls `visit` with every couple that touches now, in the order of the candidates.
    pub fn for_each(&self, mut visit: impl FnMut(Couple)) {
        self.touching(self.candidates, |couples| couples.iter().copied().for_each(&mut visit));
    }

    /// Writes the couples that touch now into `couples`, cleared first, in the order of the candidates.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; `couples` is empty then.
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

    /// Hands over those of `candidates` that touch, some at a time. They see each other: the filter is that of the detection.
    fn touching(&self, candidates: &[Couple], visit: impl FnMut(&[Couple])) {
        match self.elements.shape {
            Shape::Equal(equal) => touching(equal, candidates, visit),
            Shape::Spheres(spheres) => touching(spheres, candidates, visit),
            Shape::Boxes(boxes) => touching(boxes, candidates, visit),
        }
    }
}

/// Candidates that a thread takes at a time.
const PART: usize = 16_384;

/// Candidates that are tested before those that touch are handed over: they stay in the first-level cache.
const TESTED_AT_ONCE: usize = 512;

fn touching<G: Geometry>(geometry: G, candidates: &[Couple], mut visit: impl FnMut(&[Couple])) {
    let mut found = [Couple { i: 0, j: 1 }; TESTED_AT_ONCE];
    for candidates in candidates.chunks(TESTED_AT_ONCE) {
        let mut count = 0;
        for &couple in candidates {
            // Written always and kept or not: which of them touch cannot be predicted.
            found[count] = couple;
            count += usize::from(geometry.touch(couple.i as usize, couple.j as usize));
        }
        visit(&found[..count]);
    }
}

fn copy<V: Copy>(from: &[V], to: &mut Vec<V>) -> Result<(), Error> {
    to.clear();
    to.try_reserve_exact(from.len()).map_err(|_| Error::OutOfMemory { bytes: size_of_val(from) })?;
    to.extend_from_slice(from);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_of_every_corner_and_of_every_step() {
        let before = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        let moved = || Motion { now: &[[1.0, 0.0], [2.0, 1.0], [6.0, 2.0]], before: &before };
        let still = Motion { now: &before, before: &before };
        assert_eq!(mean_motion(&[moved()], 1), [2.0, 0.0]);
        assert_eq!(mean_motion(&[moved()], 2), [2.5, 0.0]);
        assert_eq!(mean_motion(&[moved(), still], 1), [1.0, 0.0]);
        assert_eq!(mean_motion::<f64, 2>(&[], 1), [0.0, 0.0]);
    }

    #[test]
    fn the_farthest_is_found_by_norm_or_by_axis() {
        let motion = Motion { now: &[[0.0_f32, 0.0], [3.0, 3.0], [4.0, 0.0]], before: &[[0.0; 2]; 3] };
        assert_eq!(motion.farthest(&[0.0, 0.0], |sum, square| sum + square), (1, 18.0));
        assert_eq!(motion.farthest(&[0.0, 0.0], f64::max), (2, 16.0));
    }
}
