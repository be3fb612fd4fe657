//! The caller's elements. They are checked once, and every engine relies on that.

use crate::error::{Error, check_lengths};
use crate::filter::Filter;
use crate::geometry::{Boxes, EqualSpheres, Geometry, Spheres, distance_squared};
use crate::real::Real;
use crate::simd::extremes;

/// A view of N elements: centres with one radius, with a radius each, or axis-aligned boxes.
///
/// The view borrows the caller's arrays and copies nothing. Its constructors check every number, so searches
/// need not check again.
///
/// # When do two elements touch?
/// Touching counts: the comparison is closed. Contact is defined by the floating-point operations below, in
/// the type `T` of the input. Each operation rounds once; there is no fused multiply-add. Every engine takes
/// the same decision.
/// - Spheres (discs, hyperspheres): `s = (r_i + r_j) + tolerance`; `d = x_i - x_j` per axis;
///   `((d_0 * d_0) + d_1 * d_1) + …  <=  s * s`, the axes in ascending order.
/// - Boxes: `min_i <= max_j + tolerance` and `min_j <= max_i + tolerance` on every axis.
/// - With a [`Filter`]: the same, and the filter admits the couple ([`Filter::admits`]).
///
/// All comparisons are symmetric in `i` and `j` to the last bit. Squares lose precision when differences or
/// radii are below about 1e-154 in `f64` (1e-19 in `f32`), and become zero below 1.6e-162 (2.6e-23): such
/// elements count as coincident.
///
/// # Shapes
/// `centres`, `min`, `max`: `[n]` points `[T; D]`, for `D` of at least 1; `radii`: `[n]`.
///
/// # Units
/// One length unit for everything. `tolerance` is the largest gap that still counts as contact; it is 0 by
/// default.
///
/// # Cost
/// Construction reads every number once. A radius of zero makes a point, which touches every element that
/// covers it.
///
/// # Example
/// ```
/// use fdem_contact::Elements;
///
/// let centres = [[0.0, 0.0], [2.0, 0.0], [9.0, 9.0]];
/// let elements = Elements::spheres_with_radii(&centres, &[1.0, 1.0, 0.5])?;
/// assert!(elements.touch(0, 1)); // exactly touching counts
/// assert!(!elements.touch(0, 2));
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Elements<'a, T, const D: usize> {
    pub(crate) shape: Shape<'a, T, D>,
    tolerance: T,
    bounds: Bounds<D>,
    /// Largest box edge (diameter) of all elements.
    largest: f64,
    filter: Option<Filter<'a>>,
}

/// One kind of element and its contact test.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape<'a, T, const D: usize> {
    Equal(EqualSpheres<'a, T, D>),
    Spheres(Spheres<'a, T, D>),
    Boxes(Boxes<'a, T, D>),
}

impl<T, const D: usize> Shape<'_, T, D> {
    /// Numbers per element in addition to its point: 1 for a radius, `D` for the upper ends of a box.
    pub(crate) fn floats(&self) -> usize {
        match self {
            Self::Equal(_) => 0,
            Self::Spheres(_) => 1,
            Self::Boxes(_) => D,
        }
    }
}

/// Extremes of the anchor points, axis by axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds<const D: usize> {
    pub(crate) min: [f64; D],
    pub(crate) max: [f64; D],
}

impl<const D: usize> Bounds<D> {
    /// The bounds of an empty set of points.
    pub(crate) const NOTHING: Self = Self { min: [f64::INFINITY; D], max: [f64::NEG_INFINITY; D] };

    /// The bounds, extended by one point, which is not NaN.
    #[inline]
    pub(crate) fn include(&mut self, point: &[f64; D]) {
        for (axis, &x) in point.iter().enumerate() {
            self.min[axis] = if x < self.min[axis] { x } else { self.min[axis] };
            self.max[axis] = if x > self.max[axis] { x } else { self.max[axis] };
        }
    }

    /// Whether a point is inside the bounds or on them.
    #[inline]
    pub(crate) fn contains<T: Real>(&self, point: &[T; D]) -> bool {
        let mut inside = true;
        for (axis, x) in point.iter().enumerate() {
            let x = x.to_f64();
            inside &= self.min[axis] <= x && x <= self.max[axis];
        }
        inside
    }

    /// The bounds of both sets of points together.
    pub(crate) fn join(mut self, other: &Self) -> Self {
        for axis in 0..D {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
        self
    }

    /// The same bounds, whose number of dimensions the caller knows to be `E`.
    fn of_dimensions<const E: usize>(&self) -> Bounds<E> {
        debug_assert_eq!(D, E);
        let Self { min, max } = self;
        Bounds { min: std::array::from_fn(|axis| min[axis]), max: std::array::from_fn(|axis| max[axis]) }
    }
}

impl<'a, T: Real, const D: usize> Elements<'a, T, D> {
    /// The same elements, which the caller knows to be in `f64` and in `E` dimensions.
    pub(crate) fn in_f64<const E: usize>(&self) -> Elements<'a, f64, E> {
        let shape = match self.shape {
            Shape::Equal(equal) => Shape::Equal(EqualSpheres {
                centres: points_in_f64(equal.centres),
                radius: equal.radius.to_f64(),
                reach_squared: equal.reach_squared.to_f64(),
            }),
            Shape::Spheres(spheres) => Shape::Spheres(Spheres {
                centres: points_in_f64(spheres.centres),
                radii: in_f64(spheres.radii),
                tolerance: spheres.tolerance.to_f64(),
            }),
            Shape::Boxes(boxes) => Shape::Boxes(Boxes {
                min: points_in_f64(boxes.min),
                max: points_in_f64(boxes.max),
                tolerance: boxes.tolerance.to_f64(),
            }),
        };
        Elements {
            shape,
            tolerance: self.tolerance.to_f64(),
            bounds: self.bounds.of_dimensions(),
            largest: self.largest,
            filter: self.filter,
        }
    }
}

fn in_f64<T: Real>(values: &[T]) -> &[f64] {
    T::as_f64(values).expect("the type is f64")
}

fn points_in_f64<T: Real, const D: usize, const E: usize>(points: &[[T; D]]) -> &[[f64; E]] {
    debug_assert_eq!(D, E);
    in_f64(points.as_flattened()).as_chunks().0
}

/// Ids are `u32`, and the largest value marks the end of a list.
pub(crate) const MAX_ELEMENTS: usize = u32::MAX as usize - 1;

impl<'a, T: Real, const D: usize> Elements<'a, T, D> {
    /// Spheres (discs in 2D) of one radius.
    ///
    /// # Errors
    /// [`Error::TooManyElements`], [`Error::InvalidRadius`], [`Error::NonFiniteCoordinate`],
    /// [`Error::CoordinateTooLarge`].
    pub fn spheres(centres: &'a [[T; D]], radius: T) -> Result<Self, Error> {
        check_count(centres.len())?;
        check_radius(radius, None)?;
        let bounds = check_points(centres)?;
        let reach = (radius + radius) + T::ZERO;
        let shape = Shape::Equal(EqualSpheres { centres, radius, reach_squared: reach * reach });
        Ok(Self { shape, tolerance: T::ZERO, bounds, largest: 2.0 * radius.to_f64(), filter: None })
    }

    /// Points that touch when they are at most `cutoff` apart: spheres of radius `cutoff / 2`.
    ///
    /// # Errors
    /// [`Error::InvalidCutoff`], and as [`Elements::spheres`].
    #[doc(alias = "neighbour list")]
    pub fn points(centres: &'a [[T; D]], cutoff: T) -> Result<Self, Error> {
        if !(cutoff >= T::ZERO && cutoff <= T::MAX_MAGNITUDE) {
            let limit = T::MAX_MAGNITUDE.to_f64();
            return Err(Error::InvalidCutoff { value: cutoff.to_f64(), limit });
        }
        Self::spheres(centres, cutoff * T::HALF)
    }

    /// Spheres (discs in 2D), each with its own radius.
    ///
    /// Equal radii are recognised: these are then the elements of [`Elements::spheres`], which are searched
    /// faster.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], and as [`Elements::spheres`].
    pub fn spheres_with_radii(centres: &'a [[T; D]], radii: &'a [T]) -> Result<Self, Error> {
        check_count(centres.len())?;
        check_lengths("radii", centres.len(), radii.len())?;
        if let Some(radius) = one_radius(radii) {
            // If it is invalid, so are all, and the first is named.
            check_radius(radius, Some(0))?;
            return Self::spheres(centres, radius);
        }
        let largest = check_radii(radii)?;
        let bounds = check_points(centres)?;
        let shape = Shape::Spheres(Spheres { centres, radii, tolerance: T::ZERO });
        Ok(Self { shape, tolerance: T::ZERO, bounds, largest: 2.0 * largest, filter: None })
    }

    /// Axis-aligned boxes from their minimum and maximum corners; an edge may be zero.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::InvertedBox`], and as [`Elements::spheres`].
    #[doc(alias = "aabb")]
    pub fn boxes(min: &'a [[T; D]], max: &'a [[T; D]]) -> Result<Self, Error> {
        check_count(min.len())?;
        check_lengths("maximum corners", min.len(), max.len())?;
        let bounds = check_points(min)?;
        check_points(max)?;
        let largest = check_edges(min, max)?;
        let shape = Shape::Boxes(Boxes { min, max, tolerance: T::ZERO });
        Ok(Self { shape, tolerance: T::ZERO, bounds, largest, filter: None })
    }

    /// The same elements, with a gap up to `tolerance` still counted as contact.
    ///
    /// # Errors
    /// [`Error::InvalidTolerance`].
    #[doc(alias = "buffer")]
    #[doc(alias = "skin")]
    pub fn with_tolerance(mut self, tolerance: T) -> Result<Self, Error> {
        if !(tolerance >= T::ZERO && tolerance <= T::MAX_MAGNITUDE) {
            let limit = T::MAX_MAGNITUDE.to_f64();
            return Err(Error::InvalidTolerance { value: tolerance.to_f64(), limit });
        }
        self.tolerance = tolerance;
        match &mut self.shape {
            Shape::Equal(equal) => {
                let reach = (equal.radius + equal.radius) + tolerance;
                equal.reach_squared = reach * reach;
            }
            Shape::Spheres(spheres) => spheres.tolerance = tolerance,
            Shape::Boxes(boxes) => boxes.tolerance = tolerance,
        }
        Ok(self)
    }

    /// The same elements with a filter: only couples that the filter admits touch. Replaces an earlier
    /// filter.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`]; [`Error::UnknownGroup`], which names the element.
    pub fn with_filter(mut self, filter: Filter<'a>) -> Result<Self, Error> {
        filter.check(self.len())?;
        self.filter = Some(filter);
        Ok(self)
    }

    /// Elements of the same kind at other places, in any number: `points` with the extremes `bounds`, `radii`
    /// or `far_points` (maximum corners) if this kind has them, and a `filter` of the same length.
    ///
    /// The caller passes only radii of these elements, because radii have been checked.
    pub(crate) fn at<'b>(
        &self,
        points: &'b [[T; D]],
        far_points: &'b [[T; D]],
        radii: &'b [T],
        bounds: Bounds<D>,
        filter: Option<Filter<'b>>,
    ) -> Result<Elements<'b, T, D>, Error> {
        let shape = match self.shape {
            Shape::Equal(EqualSpheres { radius, reach_squared, .. }) => {
                Shape::Equal(EqualSpheres { centres: points, radius, reach_squared })
            }
            Shape::Spheres(Spheres { tolerance, .. }) => {
                Shape::Spheres(Spheres { centres: points, radii, tolerance })
            }
            Shape::Boxes(_) => {
                let boxes = Elements::boxes(points, far_points)?.with_tolerance(self.tolerance)?;
                return Ok(Elements { filter, ..boxes });
            }
        };
        check_count(points.len())?;
        let limit = T::MAX_MAGNITUDE.to_f64();
        if bounds.min.iter().chain(&bounds.max).any(|x| x.abs() > limit) {
            // Finds the coordinate that is wrong.
            check_points(points)?;
        }
        Ok(Elements { shape, tolerance: self.tolerance, bounds, largest: self.largest, filter })
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        match self.shape {
            Shape::Equal(equal) => equal.len(),
            Shape::Spheres(spheres) => spheres.len(),
            Shape::Boxes(boxes) => boxes.len(),
        }
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The gap that still counts as contact.
    pub fn tolerance(&self) -> T {
        self.tolerance
    }

    /// The filter; `None` if all couples are admitted.
    pub fn filter(&self) -> Option<Filter<'a>> {
        self.filter
    }

    /// Number of elements that are points: their radius, or their longest box edge, is exactly zero.
    pub fn points_among(&self) -> usize {
        match self.shape {
            Shape::Equal(equal) if equal.radius == T::ZERO => equal.len(),
            Shape::Equal(_) => 0,
            Shape::Spheres(spheres) => spheres.radii.iter().filter(|&&radius| radius == T::ZERO).count(),
            Shape::Boxes(boxes) => boxes.min.iter().zip(boxes.max).filter(|(min, max)| min == max).count(),
        }
    }

    /// Whether elements `i` and `j` touch, by the comparison documented at [`Elements`].
    ///
    /// # Panics
    /// When `i` or `j` is not below [`Elements::len`].
    pub fn touch(&self, i: usize, j: usize) -> bool {
        if self.filter.is_some_and(|filter| !filter.admits(i, j)) {
            return false;
        }
        match self.shape {
            Shape::Equal(equal) => equal.touch(i, j),
            Shape::Spheres(spheres) => spheres.touch(i, j),
            Shape::Boxes(boxes) => boxes.touch(i, j),
        }
    }

    /// The squared distance of elements `i` and `j`: between the centres of spheres, or between the closest
    /// points of boxes.
    ///
    /// Spheres: `((d_0 * d_0) + d_1 * d_1) + …`, the left side of the comparison documented at [`Elements`],
    /// to the last bit. Boxes: the same sum, where `d` is the gap on an axis: the larger of `min_i - max_j`
    /// and `min_j - max_i`, or 0 where they overlap. The distance of boxes does not decide contact, because
    /// boxes are compared axis by axis. Symmetric in `i` and `j`.
    ///
    /// # Units
    /// The square of the length unit.
    ///
    /// # Panics
    /// When `i` or `j` is not below [`Elements::len`].
    pub fn distance_squared(&self, i: usize, j: usize) -> T {
        match self.shape {
            Shape::Equal(equal) => equal.distance_squared(i, j),
            Shape::Spheres(spheres) => distance_squared(&spheres.centres[i], &spheres.centres[j]),
            Shape::Boxes(boxes) => boxes.distance_squared(i, j),
        }
    }

    /// Where an element begins and ends along an axis, extended so that elements that touch overlap (closed)
    /// on every axis.
    ///
    /// With [`Elements::touch`], this is all that a [`Search`](crate::Search) needs to know of elements.
    ///
    /// # Why no couple is lost
    /// Boxes: `low = min` and `high = max + tolerance`, rounded as in the comparison of [`Elements`]. They
    /// overlap on every axis exactly where the boxes touch.
    ///
    /// Spheres: `low = x - h` and `high = x + h` with
    /// `h = (r + tolerance / 2) (1 + (D + 8) EPSILON) + MIN_RESOLVED / 2`. The relative part of `rounding()`
    /// below may be taken of `r_i + r_j` instead of the largest sum. Therefore spheres that touch are at most
    /// `h_i + h_j` apart along an axis; that bound is four times as large as necessary, which covers the
    /// roundings of `h`. Hence `x_i - h_i <= x_j + h_j` holds for exact numbers. Both sides are rounded once,
    /// and rounding does not change an order.
    ///
    /// # Panics
    /// When `index` is not below [`Elements::len`], or `axis` not below `D`.
    ///
    /// # Example
    /// A search of one's own, which sorts the elements along the first axis:
    /// ```
    /// use fdem_contact::{Couple, Elements, Error, Real, Search, verify};
    ///
    /// struct Sweep;
    ///
    /// impl<T: Real, const D: usize> Search<T, D> for Sweep {
    ///     fn for_each(
    ///         &mut self,
    ///         elements: &Elements<'_, T, D>,
    ///         mut visit: impl FnMut(Couple),
    ///     ) -> Result<(), Error> {
    ///         let mut order: Vec<usize> = (0..elements.len()).collect();
    ///         order.sort_by(|&i, &j| elements.span(i, 0)[0].total_cmp(&elements.span(j, 0)[0]));
    ///         for (place, &i) in order.iter().enumerate() {
    ///             let [_, end] = elements.span(i, 0);
    ///             for &j in order[place + 1..].iter().take_while(|&&j| elements.span(j, 0)[0] <= end) {
    ///                 if elements.touch(i, j) {
    ///                     visit(Couple::new(i as u32, j as u32));
    ///                 }
    ///             }
    ///         }
    ///         Ok(())
    ///     }
    /// }
    ///
    /// let centres: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k) * 0.4, f64::from(k % 7)]).collect();
    /// let elements = Elements::spheres(&centres, 0.6)?;
    /// let mut couples = Vec::new();
    /// Sweep.couples(&elements, &mut couples)?;
    /// verify(&elements, &couples, 100, 1)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline]
    pub fn span(&self, index: usize, axis: usize) -> [f64; 2] {
        let (centre, radius) = match self.shape {
            Shape::Boxes(boxes) => {
                let high = boxes.max[index][axis] + self.tolerance;
                return [boxes.min[index][axis].to_f64(), high.to_f64()];
            }
            Shape::Equal(equal) => (equal.centres[index][axis], equal.radius),
            Shape::Spheres(spheres) => (spheres.centres[index][axis], spheres.radii[index]),
        };
        let widened = (radius.to_f64() + 0.5 * self.tolerance.to_f64()) * (1.0 + (D + 8) as f64 * T::EPSILON);
        let half = widened + 0.5 * T::MIN_RESOLVED;
        let centre = centre.to_f64();
        [centre - half, centre + half]
    }

    pub(crate) fn anchor(&self, index: usize, axis: usize) -> f64 {
        match self.shape {
            Shape::Equal(equal) => equal.anchor(index, axis),
            Shape::Spheres(spheres) => spheres.anchor(index, axis),
            Shape::Boxes(boxes) => boxes.anchor(index, axis),
        }
    }

    pub(crate) fn bounds(&self) -> Bounds<D> {
        self.bounds
    }

    /// Upper bound on the distance, along any axis, between the anchors of two elements that touch.
    ///
    /// The nominal bound is the largest diameter (edge) plus the tolerance. The comparison of [`Elements`]
    /// rounds, so it may accept a couple that is some units in the last place farther apart. `D + 8` such
    /// units cover the roundings of one sum of `D` squares, one sum of radii and one square. Boxes compare
    /// coordinates with `max + tolerance`, whose rounding grows with the coordinate, not with the size of the
    /// box.
    pub(crate) fn reach(&self) -> f64 {
        self.reach_to(self.largest, self.magnitude(), self.tolerance)
    }

    /// The same as a coordinate, and not too small for the windows of rows.
    pub(crate) fn rows_reach(&self) -> T {
        T::at_least(self.reach().max(T::MIN_RESOLVED))
    }

    /// The same for an element of this set and one of another set of the same kind. The other set is given by
    /// its `largest` diameter (edge) and its [`magnitude`](Self::magnitude). A sphere extends half its
    /// diameter from its anchor. A box extends a whole edge, but to one side of its anchor only, so two boxes
    /// are at most one edge apart, that of the larger.
    pub(crate) fn reach_to(&self, largest: f64, magnitude: f64, tolerance: T) -> f64 {
        self.reach_of([self.largest, largest], self.magnitude().max(magnitude), tolerance)
    }

    /// The same for two elements of this set with the given diameters (largest edges).
    pub(crate) fn reach_between(&self, one: f64, two: f64) -> f64 {
        self.reach_of([one, two], self.magnitude(), self.tolerance)
    }

    fn reach_of(&self, [one, two]: [f64; 2], magnitude: f64, tolerance: T) -> f64 {
        let tolerance = tolerance.to_f64();
        let boxes = matches!(self.shape, Shape::Boxes(_));
        let sizes = if boxes { one.max(two) } else { 0.5 * one + 0.5 * two };
        let rounding = if boxes && tolerance > 0.0 { T::EPSILON * (magnitude + tolerance) } else { 0.0 };
        (sizes + tolerance) * (1.0 + (D + 8) as f64 * T::EPSILON) + rounding
    }

    /// The diameter of a sphere, or the largest edge of a box; 0 for a point.
    pub(crate) fn size(&self, index: usize) -> f64 {
        match self.shape {
            Shape::Equal(equal) => 2.0 * equal.radius.to_f64(),
            Shape::Spheres(spheres) => 2.0 * spheres.radii[index].to_f64(),
            Shape::Boxes(boxes) => (0..D).fold(0.0, |size, axis| {
                size.max(boxes.max[index][axis].to_f64() - boxes.min[index][axis].to_f64())
            }),
        }
    }

    /// Largest box edge (diameter) of all elements.
    pub(crate) fn largest(&self) -> f64 {
        self.largest
    }

    /// Upper bound on the magnitude of every coordinate of every corner.
    pub(crate) fn magnitude(&self) -> f64 {
        (0..D).fold(self.largest, |sum, axis| {
            sum + self.bounds.min[axis].abs().max(self.bounds.max[axis].abs())
        })
    }

    /// Largest error of the rounded comparison of [`Elements`], as a length. Elements that touch have a
    /// distance of at most `reach + rounding()`; elements whose distance is at most `reach - rounding()`
    /// touch.
    ///
    /// Spheres: `reach = r_i + r_j + tolerance`, and the distance is that of the centres. With
    /// `u = EPSILON / 2`, the computed sum of squares is the exact one times a factor within
    /// `(1 ± u)^(D + 2)`, and `s * s` is `reach^2` times a factor within `(1 ± u)^5`. The root of these
    /// `D + 7` factors is an error of `(D/2 + 4) u` relative to `reach`; `D + 8` units of `2 u` are four
    /// times as much. Squares that underflow add at most `(D + 1) 2^-1074` (`2^-149` in `f32`) to either
    /// side. The root of that, which is less than `MIN_RESOLVED`, is added to the length.
    ///
    /// Boxes: `reach = tolerance`, and the distance on an axis is `min_i - max_j`. Only `max_j + tolerance`
    /// rounds, by half a unit of the sum; `MIN_RESOLVED` is more than enough.
    pub(crate) fn rounding(&self) -> f64 {
        let tolerance = self.tolerance.to_f64();
        let relative = match self.shape {
            Shape::Boxes(_) => T::EPSILON * (self.magnitude() + tolerance),
            _ => (D + 8) as f64 * T::EPSILON * (self.largest + tolerance),
        };
        relative + T::MIN_RESOLVED
    }
}

pub(crate) fn check_count(elements: usize) -> Result<(), Error> {
    if elements > MAX_ELEMENTS {
        return Err(Error::TooManyElements { elements, limit: MAX_ELEMENTS });
    }
    Ok(())
}

fn check_radius<T: Real>(radius: T, index: Option<usize>) -> Result<(), Error> {
    if radius >= T::ZERO && radius <= T::MAX_MAGNITUDE {
        return Ok(());
    }
    Err(Error::InvalidRadius { index, value: radius.to_f64(), limit: T::MAX_MAGNITUDE.to_f64() })
}

// The checks pass over all elements. As in `compiled.rs`, their code for `f64` in the plane and in space is
// that of this crate, because a caller may not be optimised.

/// Checks every coordinate and returns the extremes, which are zero for no points.
fn check_points<T: Real, const D: usize>(points: &[[T; D]]) -> Result<Bounds<D>, Error> {
    #[inline(never)]
    fn plane(points: &[[f64; 2]]) -> Result<Bounds<2>, Error> {
        extremes_of(points)
    }

    #[inline(never)]
    fn space(points: &[[f64; 3]]) -> Result<Bounds<3>, Error> {
        extremes_of(points)
    }

    if const { D == 2 && T::IS_F64 } {
        plane(points_in_f64(points)).map(|bounds| bounds.of_dimensions())
    } else if const { D == 3 && T::IS_F64 } {
        space(points_in_f64(points)).map(|bounds| bounds.of_dimensions())
    } else {
        extremes_of(points)
    }
}

fn extremes_of<T: Real, const D: usize>(points: &[[T; D]]) -> Result<Bounds<D>, Error> {
    const { assert!(D > 0, "elements need at least one dimension") };
    let limit = T::MAX_MAGNITUDE;
    let (min, max) = match extremes::of_points(points) {
        None if points.is_empty() => ([T::ZERO; D], [T::ZERO; D]),
        Some((min, max)) if (0..D).all(|axis| min[axis] >= T::ZERO - limit && max[axis] <= limit) => {
            (min, max)
        }
        _ => return Err(first_invalid(points)),
    };
    Ok(Bounds { min: min.map(T::to_f64), max: max.map(T::to_f64) })
}

/// The radius of all, if all are equal and there is one. Looks no farther than the first that differs.
fn one_radius<T: Real>(radii: &[T]) -> Option<T> {
    #[inline(never)]
    fn doubles(radii: &[f64]) -> bool {
        are_equal(radii)
    }

    let equal = if const { T::IS_F64 } { doubles(in_f64(radii)) } else { are_equal(radii) };
    if equal { radii.first().copied() } else { None }
}

/// Both zeros are equal: no sum or square of a contact depends on the sign. NaN differs from itself.
fn are_equal<T: Real>(values: &[T]) -> bool {
    values.iter().all(|&value| value == values[0])
}

/// Checks every radius and returns the largest, which is zero for no radii.
fn check_radii<T: Real>(radii: &[T]) -> Result<f64, Error> {
    #[inline(never)]
    fn doubles(radii: &[f64]) -> Result<f64, Error> {
        largest_of(radii)
    }

    if const { T::IS_F64 } { doubles(in_f64(radii)) } else { largest_of(radii) }
}

fn largest_of<T: Real>(radii: &[T]) -> Result<f64, Error> {
    let mut largest = T::ZERO;
    for (index, &radius) in radii.iter().enumerate() {
        check_radius(radius, Some(index))?;
        if radius > largest {
            largest = radius;
        }
    }
    Ok(largest.to_f64())
}

/// Checks that no box is inverted and returns the longest edge, which is zero for no boxes.
fn check_edges<T: Real, const D: usize>(min: &[[T; D]], max: &[[T; D]]) -> Result<f64, Error> {
    #[inline(never)]
    fn plane(min: &[[f64; 2]], max: &[[f64; 2]]) -> Result<f64, Error> {
        longest_of(min, max)
    }

    #[inline(never)]
    fn space(min: &[[f64; 3]], max: &[[f64; 3]]) -> Result<f64, Error> {
        longest_of(min, max)
    }

    if const { D == 2 && T::IS_F64 } {
        plane(points_in_f64(min), points_in_f64(max))
    } else if const { D == 3 && T::IS_F64 } {
        space(points_in_f64(min), points_in_f64(max))
    } else {
        longest_of(min, max)
    }
}

fn longest_of<T: Real, const D: usize>(min: &[[T; D]], max: &[[T; D]]) -> Result<f64, Error> {
    let mut longest = 0.0_f64;
    for (index, (low, high)) in min.iter().zip(max).enumerate() {
        for axis in 0..D {
            let (low, high) = (low[axis].to_f64(), high[axis].to_f64());
            if low > high {
                return Err(Error::InvertedBox { index, axis, min: low, max: high });
            }
            longest = longest.max(high - low);
        }
    }
    Ok(longest)
}

/// The error of the first coordinate that is refused; there is one.
#[cold]
fn first_invalid<T: Real, const D: usize>(points: &[[T; D]]) -> Error {
    let limit = T::MAX_MAGNITUDE;
    let numbers = points.as_flattened();
    // The condition is negated so that NaN counts too.
    let place = numbers.iter().position(|&x| !(x <= limit && x >= T::ZERO - limit)).unwrap_or(0);
    let (index, axis, value) = (place / D, place % D, numbers[place].to_f64());
    if numbers[place].is_finite() {
        Error::CoordinateTooLarge { index, axis, value, limit: limit.to_f64() }
    } else {
        Error::NonFiniteCoordinate { index, axis, value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_radii_are_one_radius() {
        let centres = [[0.0], [2.5], [5.0]];
        let is_one = |radii: &[f64; 3]| {
            matches!(Elements::spheres_with_radii(&centres, radii).unwrap().shape, Shape::Equal(_))
        };
        assert!(is_one(&[0.5; 3]));
        assert!(!is_one(&[0.5, 0.5, 0.5_f64.next_up()]));
    }

    #[test]
    fn equal_radii_that_are_invalid_are_refused_by_number() {
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let error = Elements::spheres_with_radii(&[[0.0], [1.0]], &[wrong; 2]).unwrap_err();
            assert!(matches!(error, Error::InvalidRadius { index: Some(0), .. }), "{error:?}");
        }
        assert!(Elements::spheres_with_radii(&[[0.0; 2]; 0], &[]).unwrap().is_empty());
    }

    #[test]
    fn more_elements_than_u32_can_number_are_refused() {
        assert_eq!(check_count(MAX_ELEMENTS), Ok(()));
        let elements = MAX_ELEMENTS + 1;
        assert_eq!(check_count(elements), Err(Error::TooManyElements { elements, limit: MAX_ELEMENTS }));
    }

    #[test]
    fn tolerance_is_added_once_per_couple() {
        let centres = [[0.0], [2.5]];
        let elements = Elements::spheres(&centres, 1.0).unwrap();
        assert!(!elements.touch(0, 1));
        assert!(elements.with_tolerance(0.5).unwrap().touch(0, 1));
        assert!(!elements.with_tolerance(0.499).unwrap().touch(0, 1));
        let elements = Elements::spheres_with_radii(&centres, &[1.0, 1.0]).unwrap();
        assert!(elements.with_tolerance(0.5).unwrap().touch(0, 1));
        assert!(!elements.with_tolerance(0.499).unwrap().touch(0, 1));
        let elements = Elements::boxes(&[[0.0], [2.5]], &[[2.0], [3.0]]).unwrap();
        assert!(elements.with_tolerance(0.5).unwrap().touch(0, 1));
        assert!(!elements.with_tolerance(0.499).unwrap().touch(0, 1));
    }

    #[test]
    fn a_cutoff_is_closed() {
        let points = [[0.1_f32, 0.0], [0.4, 0.0]];
        let distance = points[1][0] - points[0][0];
        assert!(Elements::points(&points, distance).unwrap().touch(0, 1));
        assert!(!Elements::points(&points, distance.next_down()).unwrap().touch(0, 1));
    }

    #[test]
    fn distances_are_of_centres_and_of_closest_points() {
        let (low, high) = ([[0.0, 0.0], [4.0, 5.0], [0.5, 7.0]], [[1.0, 1.0], [5.0, 6.0], [6.0, 9.0]]);
        let spheres = Elements::spheres(&low, 1.0).unwrap();
        assert_eq!(spheres.distance_squared(0, 1), 41.0);
        let spheres = Elements::spheres_with_radii(&low, &[1.0, 2.0, 3.0]).unwrap();
        assert_eq!(spheres.distance_squared(1, 0), 41.0);
        let boxes = Elements::boxes(&low, &high).unwrap();
        assert_eq!([boxes.distance_squared(0, 1), boxes.distance_squared(1, 0)], [25.0, 25.0]);
        assert_eq!(boxes.distance_squared(0, 2), 36.0, "only y has a gap");
        assert_eq!(boxes.distance_squared(1, 1), 0.0);
    }

    #[test]
    fn points_are_counted() {
        let centres = [[0.0], [1.0], [2.0]];
        assert_eq!(Elements::spheres(&centres, 0.0).unwrap().points_among(), 3);
        assert_eq!(Elements::spheres(&centres, 0.5).unwrap().points_among(), 0);
        assert_eq!(Elements::spheres_with_radii(&centres, &[0.0, 1.0, 0.0]).unwrap().points_among(), 2);
        assert_eq!(Elements::boxes(&centres, &[[0.0], [1.5], [2.0]]).unwrap().points_among(), 2);
    }
}
