//! Couples of moving elements in a box that repeats: detect once with a buffer, then check the candidates
//! while nothing has moved far.

use crate::buffer::{Reason, Reference};
use crate::elements::{Bounds, Elements, Shape};
use crate::error::Error;
use crate::memory::grow;
use crate::periodic::cell::PeriodicBox;
use crate::periodic::{PeriodicCouple, PeriodicSearch};
use crate::real::Real;

/// Repeated contact detection in a box that repeats, as [`Buffered`](crate::Buffered): it detects again only
/// when an element has moved farther than half the buffer relative to the mean motion of all.
///
/// A motion by whole edges is no motion: elements may leave the box, or be put back into it by the caller,
/// between two updates.
///
/// # Why no couple is lost
/// Each element is wrapped into the box, at the detection to `W_i` and now to `w_i`. For any whole numbers
/// `c_i` let `u_i = w_i + c_i . v`, with the edges `v`. The image of `j` at `w_j + s . v` touches `i` now.
/// With `t = s + c_i - c_j`, exactly, `u_i - (u_j + t . v) = w_i - (w_j + s . v)`. Therefore the argument of
/// [`Buffered`](crate::Buffered) holds for the positions `W` and `u` and the candidates `(i, j, t)`. The
/// choice of `c_i` decides only how often there is a detection: it is the one that makes the motion
/// `u_i - W_i` smallest along each edge.
///
/// Four points are rounded: both images, `u_i` and `u_j`. Per axis each of them is a sum of `D` products and
/// a coordinate in `f64`, rounded to `T`; it errs by less than `(D + 2)` units of `T` relative to the sum of
/// the magnitudes, and a vector by less than `D` times that. The limit is reduced by all four.
///
/// # Order
/// The order of the candidates, which is the order of [`PeriodicSearch`] at the last detection. It depends on
/// the sequence of updates.
///
/// # Cost
/// An update that keeps the candidates: two passes over the positions and two over the candidates, on one
/// thread. One that detects: a search besides, on the threads of the search. Memory: that of the search, the
/// positions four times, and `8 + 4 D` bytes per candidate.
///
/// # Example
/// ```
/// use fdem_contact::{Elements, PeriodicBox, PeriodicBuffered, PeriodicCouple, Reason};
///
/// let cell = PeriodicBox::orthogonal([0.0, 0.0], [10.0, 10.0], [true, true])?;
/// let mut centres = [[0.25, 5.0], [9.0, 5.0], [5.0, 5.0]];
/// let mut buffered = PeriodicBuffered::new(0.5)?;
/// let mut couples = Vec::new();
///
/// let reason = buffered.update(&Elements::points(&centres, 1.0)?, &cell, &mut couples)?;
/// assert_eq!((reason, couples.len()), (Some(Reason::First), 0));
///
/// centres[0][0] = 9.75; // To the left by half a unit, and put back into the box.
/// let reason = buffered.update(&Elements::points(&centres, 1.0)?, &cell, &mut couples)?;
/// assert!(matches!(reason, Some(Reason::Moved { element: 0, .. })));
/// centres[1][0] += 0.1;
/// assert_eq!(buffered.update(&Elements::points(&centres, 1.0)?, &cell, &mut couples)?, None);
/// assert_eq!(couples, [PeriodicCouple { i: 0, j: 1, shift: [0, 0] }]);
/// assert_eq!((buffered.updates(), buffered.redetections()), (3, 2));
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "skin")]
#[doc(alias = "Verlet list")]
#[derive(Clone, Debug)]
pub struct PeriodicBuffered<T, const D: usize> {
    search: PeriodicSearch<T, D>,
    buffer: T,
    /// The shifts are those between wrapped elements at the detection.
    candidates: Vec<PeriodicCouple<D>>,
    /// The wrapped elements at the last detection, and their box; `None` before the first and after one that
    /// failed.
    reference: Option<(Reference<T, D>, PeriodicBox<T, D>)>,
    now: Wrapped<T, D>,
    updates: u64,
    redetections: u64,
}

/// Elements, wrapped into the box.
#[derive(Clone, Debug)]
struct Wrapped<T, const D: usize> {
    /// Centres or minimum corners, and maximum corners of boxes; then those of images, and the radii of all
    /// where they differ.
    points: Vec<[T; D]>,
    far_points: Vec<[T; D]>,
    radii: Vec<T>,
    /// Periods that each element is away from the box.
    periods: Vec<[i32; D]>,
    /// Edges by which each wrapped element is displaced to be near the place where it was.
    back: Vec<[i32; D]>,
}

/// The points of a shape, and its maximum corners.
fn corners<'a, T, const D: usize>(elements: &Elements<'a, T, D>) -> (&'a [[T; D]], &'a [[T; D]])
where
    T: Real,
{
    match elements.shape {
        Shape::Equal(equal) => (equal.points(), &[]),
        Shape::Spheres(spheres) => (spheres.points(), &[]),
        Shape::Boxes(boxes) => (boxes.points(), boxes.far_points()),
    }
}

fn bounds<T: Real, const D: usize>(points: &[[T; D]]) -> Bounds<D> {
    let mut bounds = Bounds::NOTHING;
    for point in points {
        bounds.include(&point.map(T::to_f64));
    }
    if points.is_empty() { Bounds { min: [0.0; D], max: [0.0; D] } } else { bounds }
}

/// The largest coordinate, without sign.
fn magnitude<T: Real, const D: usize>(points: &[[T; D]]) -> f64 {
    points.as_flattened().iter().fold(0.0_f64, |largest, x| largest.max(x.to_f64().abs()))
}

/// The largest number of edges, without sign.
fn most<'a, const D: usize>(shifts: impl Iterator<Item = &'a [i32; D]>) -> f64 {
    shifts.flatten().fold(0.0_f64, |most, &edges| most.max(f64::from(edges).abs()))
}

impl<T: Real, const D: usize> PeriodicBuffered<T, D> {
    /// Nothing detected yet; the engine is picked from the elements.
    ///
    /// # Units
    /// `buffer` shares the length unit of the elements. With 0 every update detects.
    ///
    /// # Errors
    /// [`Error::InvalidBuffer`] for one that is negative, NaN, infinite or beyond [`Real::MAX_MAGNITUDE`].
    pub fn new(buffer: T) -> Result<Self, Error> {
        Self::with_search(PeriodicSearch::new(), buffer)
    }

    /// The same with a search of the caller's.
    ///
    /// # Errors
    /// As [`PeriodicBuffered::new`].
    pub fn with_search(search: PeriodicSearch<T, D>, buffer: T) -> Result<Self, Error> {
        if !(buffer >= T::ZERO && buffer <= T::MAX_MAGNITUDE) {
            let limit = T::MAX_MAGNITUDE.to_f64();
            return Err(Error::InvalidBuffer { value: buffer.to_f64(), limit });
        }
        let now = Wrapped {
            points: Vec::new(),
            far_points: Vec::new(),
            radii: Vec::new(),
            periods: Vec::new(),
            back: Vec::new(),
        };
        Ok(Self { search, buffer, candidates: Vec::new(), reference: None, now, updates: 0, redetections: 0 })
    }

    /// Number of updates that succeeded.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Number of updates that detected, the first one included.
    pub fn redetections(&self) -> u64 {
        self.redetections
    }

    /// Writes the couples that touch now into `couples`, cleared first, and returns why there was a new
    /// detection; `None` if the candidates were kept.
    ///
    /// The couples are those of [`PeriodicSearch::couples`].
    ///
    /// # Errors
    /// The errors of [`PeriodicSearch::couples`]; [`Error::InvalidTolerance`] if tolerance and buffer
    /// together are beyond [`Real::MAX_MAGNITUDE`]. `couples` is empty then, nothing is kept, and the next
    /// update detects.
    pub fn update(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        couples: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<Option<Reason>, Error> {
        couples.clear();
        // Everything below counts short edges, as the search does.
        let reduced = cell.reduced();
        let cell = reduced.as_ref().map_or(cell, |reduced| &reduced.cell);
        // Missing while anything below can fail.
        let reference = self.reference.take();
        let updated = self.try_update(elements, cell, reference, couples).inspect_err(|_| couples.clear());
        let (reference, reason) = updated?;
        if let Some(reduced) = reduced {
            for PeriodicCouple { i, j, shift } in couples.iter_mut() {
                *shift = reduced.shift_of_couple([*i, *j], shift);
            }
        }
        self.reference = Some((reference, *cell));
        self.updates += 1;
        self.redetections += u64::from(reason.is_some());
        Ok(reason)
    }

    fn try_update(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        reference: Option<(Reference<T, D>, PeriodicBox<T, D>)>,
        couples: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(Reference<T, D>, Option<Reason>), Error> {
        let is_wrapped = self.now.wrap(elements, cell)?;
        let (reference, reason) = match reference {
            None => (Reference::empty(), Some(Reason::First)),
            Some((reference, before)) if before != *cell => (reference, Some(Reason::BoxChanged)),
            // The search says which element is too far from the box.
            Some((reference, _)) if !is_wrapped => (reference, Some(Reason::First)),
            Some((reference, _)) => {
                let reason = self.outdated_by(elements, cell, &reference)?;
                (reference, reason)
            }
        };
        let reference = if reason.is_some() { self.detect(elements, cell, reference)? } else { reference };
        self.touching(elements, cell, couples)?;
        Ok((reference, reason))
    }

    /// Finds out where the elements are relative to the reference, and why the candidates may lack a couple.
    fn outdated_by(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        reference: &Reference<T, D>,
    ) -> Result<Option<Reason>, Error> {
        let Self { now, candidates, .. } = self;
        now.compare(reference.points(), cell);
        let moved = |points: &[[T; D]]| {
            let mut moved = Vec::new();
            grow(&mut moved, points.len())?;
            let places = points.iter().zip(&now.back);
            moved.extend(places.map(|(point, back)| displaced(cell, point, back)));
            Ok::<_, Error>(moved)
        };
        let (points, far_points) = (moved(&now.points)?, moved(&now.far_points)?);
        let (_, radii) = sizes(elements);
        let followed = elements.at(&points, &far_points, radii, bounds(&points), elements.filter())?;

        let coordinates = [&points[..], &far_points, &now.points, &now.far_points, reference.points()];
        let coordinates = coordinates.into_iter().map(magnitude).fold(0.0, f64::max);
        let edges = cell.edges().iter().map(|edge| magnitude(&[*edge])).sum::<f64>();
        let shifts = most(candidates.iter().map(|couple| &couple.shift)) + 2.0 * most(now.back.iter());
        let rounding = (4 * D * (D + 2)) as f64 * T::EPSILON * (coordinates + shifts * edges);
        Ok(reference.outdated_by(&followed, rounding))
    }

    fn detect(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        mut reference: Reference<T, D>,
    ) -> Result<Reference<T, D>, Error> {
        let Self { search, now, candidates, buffer, .. } = self;
        let enlarged = elements.with_tolerance(elements.tolerance() + *buffer)?;
        search.couples(&enlarged, cell, candidates)?;
        for PeriodicCouple { i, j, shift } in candidates.iter_mut() {
            let (of_i, of_j) = (now.periods[*i as usize], now.periods[*j as usize]);
            *shift = std::array::from_fn(|edge| shift[edge] - of_i[edge] + of_j[edge]);
        }
        now.back.fill([0; D]);
        let (_, radii) = sizes(elements);
        let bounds = bounds(&now.points);
        let wrapped = elements.at(&now.points, &now.far_points, radii, bounds, elements.filter())?;
        let enlarged = wrapped.with_tolerance(enlarged.tolerance())?;
        reference.copy(&wrapped, &enlarged)?;
        Ok(reference)
    }

    /// Appends the candidates that touch.
    fn touching(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        couples: &mut Vec<PeriodicCouple<D>>,
    ) -> Result<(), Error> {
        let Self { now, candidates, .. } = self;
        let n = elements.len();
        let (are_boxes, radii) = sizes(elements);
        now.radii.clear();
        grow(&mut now.radii, radii.len())?;
        now.radii.extend_from_slice(radii);
        let shift_of = |couple: &PeriodicCouple<D>, back: &[[i32; D]]| -> [i32; D] {
            let (of_i, of_j) = (back[couple.i as usize], back[couple.j as usize]);
            std::array::from_fn(|edge| couple.shift[edge] + of_j[edge] - of_i[edge])
        };
        for couple in &*candidates {
            let shift = shift_of(couple, &now.back);
            if shift == [0; D] {
                continue;
            }
            let j = couple.j as usize;
            grow(&mut now.points, 1)?;
            now.points.push(cell.displaced(&now.points[j], &shift));
            if are_boxes {
                grow(&mut now.far_points, 1)?;
                now.far_points.push(cell.displaced(&now.far_points[j], &shift));
            }
            if !radii.is_empty() {
                grow(&mut now.radii, 1)?;
                now.radii.push(radii[j]);
            }
        }
        // The candidates see each other.
        let all = elements.at(&now.points, &now.far_points, &now.radii, bounds(&now.points), None)?;
        let mut image = n;
        for couple in &*candidates {
            let PeriodicCouple { i, j, .. } = *couple;
            let shift = shift_of(couple, &now.back);
            let other = if shift == [0; D] { j as usize } else { image };
            image += usize::from(shift != [0; D]);
            if all.touch(i as usize, other) {
                let (of_i, of_j) = (now.periods[i as usize], now.periods[j as usize]);
                let shift = std::array::from_fn(|edge| shift[edge] + of_i[edge] - of_j[edge]);
                grow(couples, 1)?;
                couples.push(PeriodicCouple { i, j, shift });
            }
        }
        Ok(())
    }
}

/// Whether the elements are boxes; the radii, if each has its own.
fn sizes<'a, T: Real, const D: usize>(elements: &'a Elements<'_, T, D>) -> (bool, &'a [T]) {
    match &elements.shape {
        Shape::Equal(_) => (false, &[]),
        Shape::Spheres(spheres) => (false, spheres.radii()),
        Shape::Boxes(_) => (true, &[]),
    }
}

fn displaced<T: Real, const D: usize>(cell: &PeriodicBox<T, D>, point: &[T; D], shift: &[i32; D]) -> [T; D] {
    if *shift == [0; D] { *point } else { cell.displaced(point, shift) }
}

impl<T: Real, const D: usize> Wrapped<T, D> {
    /// Wraps all elements; `false` if one is too far from the box.
    fn wrap(&mut self, elements: &Elements<'_, T, D>, cell: &PeriodicBox<T, D>) -> Result<bool, Error> {
        let (points, far_points) = corners(elements);
        self.points.clear();
        self.far_points.clear();
        self.periods.clear();
        self.back.clear();
        grow(&mut self.points, points.len())?;
        grow(&mut self.far_points, far_points.len())?;
        grow(&mut self.periods, points.len())?;
        grow(&mut self.back, points.len())?;
        for point in points {
            let Some((wrapped, periods)) = cell.wrap(*point) else { return Ok(false) };
            self.points.push(wrapped);
            self.periods.push(periods);
        }
        let corners = far_points.iter().zip(&self.periods);
        self.far_points.extend(corners.map(|(point, periods)| cell.wrapped(*point, periods)));
        self.back.resize(points.len(), [0; D]);
        Ok(true)
    }

    /// Finds the number of edges by which each element is displaced, so that it is as near as possible to its
    /// previous place. Any number would do.
    fn compare(&mut self, before: &[[T; D]], cell: &PeriodicBox<T, D>) {
        for ((now, before), back) in self.points.iter().zip(before).zip(&mut self.back) {
            let motion: [f64; D] = std::array::from_fn(|axis| now[axis].to_f64() - before[axis].to_f64());
            for (edge, row) in cell.dual().iter().enumerate() {
                let fraction = row.iter().zip(&motion).map(|(row, motion)| row * motion).sum::<f64>();
                // No wrapped element is farther than a period from another but by rounding.
                back[edge] =
                    if cell.periodic()[edge] { -fraction.round().clamp(-2.0, 2.0) as i32 } else { 0 };
            }
        }
    }
}
