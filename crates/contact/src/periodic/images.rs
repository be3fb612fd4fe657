//! Elements wrapped into a periodic box, and those of their images that may touch one of them.

use crate::elements::{Bounds, Elements, Shape};
use crate::error::Error;
use crate::filter::Labels;
use crate::memory::{reserve, resize};
use crate::periodic::cell::{MAX_PERIODS, PeriodicBox, norm};
use crate::periodic::reduced::ReducedBox;
use crate::pool::Pool;
use crate::real::Real;
use crate::search::make_room;

/// Elements wrapped into a box; separately, the elements near its faces together with their images.
///
/// Every couple with an image consists of an element of `near` and an image. If an image of `j` touches `i`,
/// then the opposite image of `i` is as near to `j` by the bound on fractions from which images are made (see
/// [`margin`]), so `i` has an image too. In a large box these elements are few. If they are not, `near` holds
/// all elements.
///
/// # Shapes
/// `wrapped`, `wrapped_far`: `[n]`, in the caller's order, filled only if some element was outside. `near`:
/// `[k]`, ascending. `points`: `[k + m]`, first the elements `near`, then the `m` images, by owner and then
/// by shift: centres, or minimum corners. `far_points`: the same for maximum corners, empty for spheres.
/// `radii`: the same, empty unless spheres have radii. `periods`: `[n]`. `owners`, `shifts`: `[m]`.
#[derive(Clone, Debug)]
pub(crate) struct Images<T, const D: usize> {
    wrapped: Vec<[T; D]>,
    wrapped_far: Vec<[T; D]>,
    /// Extremes of the wrapped elements; below, those of `points`.
    wrapped_bounds: Bounds<D>,
    bounds: Bounds<D>,
    /// Number of periods between each element and the box. Entries of elements that were inside are stale.
    periods: Vec<[i32; D]>,
    /// One bit per element: whether it was outside. Often most are inside, and these bits stay in cache where
    /// `periods` would not.
    away: Vec<u64>,
    pub(crate) any_away: bool,
    /// Elements that have images, or all elements if they are not kept apart.
    pub(crate) near: Vec<u32>,
    /// Whether couples of elements are searched among all elements, separately from `near`.
    pub(crate) apart: bool,
    points: Vec<[T; D]>,
    far_points: Vec<[T; D]>,
    radii: Vec<T>,
    /// The numbers of a filter, one per point; an image has those of its owner.
    labels: Labels,
    /// The element of each image.
    pub(crate) owners: Vec<u32>,
    /// Number of edges by which each image is displaced from its wrapped owner.
    pub(crate) shifts: Vec<[i32; D]>,
    /// The short edges in which `periods` and `shifts` count, if the given box is skewed.
    pub(crate) reduced: Option<ReducedBox<T, D>>,
    /// Whether the elements occupy so little space that most are within reach of most others.
    pub(crate) compact: bool,
    chunks: Vec<Chunk<T, D>>,
}

/// A chunk of the elements, handled by one thread. Chunks do not depend on the number of threads.
#[derive(Clone, Debug)]
struct Chunk<T, const D: usize> {
    /// Extremes of the wrapped elements and of their fractions; then the same for the elements that have
    /// images.
    bounds: Bounds<D>,
    fractions: Bounds<D>,
    any_away: bool,
    error: Option<Error>,
    /// The elements that have images, their positions, and the number of images.
    owners: Vec<u32>,
    points: Vec<[T; D]>,
    images: f64,
}

/// Number of elements in a chunk: a multiple of 64, so that no two chunks share a word of `away`.
const CHUNK: usize = 8192;

/// The box, the extremes of the fractions of the wrapped elements, and the largest difference between the
/// fractions of touching elements.
struct ImageWindow<'a, T, const D: usize> {
    cell: &'a PeriodicBox<T, D>,
    fractions: Bounds<D>,
    margin: [f64; D],
}

/// The largest distance between touching elements.
struct LargestReach {
    /// The reach: a Euclidean distance for spheres, a distance along each axis for boxes.
    reach: f64,
    /// Whether the reach holds along each axis.
    by_axis: bool,
    /// The distance that a box extends beyond its anchor.
    extent: f64,
}

impl LargestReach {
    /// The measure of wrapped elements; rounding may have stretched boxes.
    fn of<T: Real, const D: usize>(wrapped: &Elements<'_, T, D>) -> Self {
        let reach = wrapped.reach().max(T::MIN_RESOLVED);
        let by_axis = matches!(wrapped.shape, Shape::Boxes(_));
        Self { reach, by_axis, extent: if by_axis { reach } else { 0.0 } }
    }

    /// The largest difference between fractions along an edge, where `row` is its row of the inverse.
    fn width<const D: usize>(&self, row: &[f64; D]) -> f64 {
        self.reach * if self.by_axis { row.iter().map(|x| x.abs()).sum() } else { norm(row) }
    }
}

/// If all elements lie within this many reaches, testing all of them is cheaper than sorting them.
const COMPACT: f64 = 2.0;

/// With more images per element than this, the elements near the faces are not kept apart.
const APART: f64 = 0.25;

impl<T: Real, const D: usize> Images<T, D> {
    pub(crate) fn new() -> Self {
        Self {
            wrapped: Vec::new(),
            wrapped_far: Vec::new(),
            wrapped_bounds: Bounds::NOTHING,
            bounds: Bounds::NOTHING,
            labels: Labels::default(),
            periods: Vec::new(),
            away: Vec::new(),
            any_away: false,
            near: Vec::new(),
            apart: false,
            points: Vec::new(),
            far_points: Vec::new(),
            radii: Vec::new(),
            owners: Vec::new(),
            shifts: Vec::new(),
            reduced: None,
            compact: false,
            chunks: Vec::new(),
        }
    }

    /// Bytes held now.
    pub(crate) fn bytes(&self) -> usize {
        let points = self.wrapped.capacity() + self.wrapped_far.capacity();
        let points = points + self.points.capacity() + self.far_points.capacity();
        let shifts = self.periods.capacity() + self.shifts.capacity();
        let numbers = self.near.capacity() + self.owners.capacity();
        let chunk = |chunk: &Chunk<T, D>| {
            chunk.owners.capacity() * size_of::<u32>() + chunk.points.capacity() * size_of::<[T; D]>()
        };
        points * size_of::<[T; D]>()
            + shifts * size_of::<[i32; D]>()
            + numbers * size_of::<u32>()
            + self.away.capacity() * size_of::<u64>()
            + self.radii.capacity() * size_of::<T>()
            + self.labels.bytes()
            + self.chunks.capacity() * size_of::<Chunk<T, D>>()
            + self.chunks.iter().map(chunk).sum::<usize>()
    }

    /// Wraps the elements, and makes all images that may touch a wrapped element, at most `max_images`. In a
    /// skewed box they are those of its short edges.
    pub(crate) fn build(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        refuse_outside: bool,
        may_be_apart: bool,
        max_images: usize,
        pool: &Pool,
    ) -> Result<(), Error> {
        self.reduced = cell.reduced();
        let refuse_outside = refuse_outside.then_some(cell);
        if let Some(reduced) = self.reduced {
            Self::check_distances(elements, cell, &reduced)?;
            self.build_in(elements, &reduced.cell, refuse_outside, may_be_apart, max_images, pool)?;
            return reduced.check_shifts(&self.shifts);
        }
        self.build_in(elements, cell, refuse_outside, may_be_apart, max_images, pool)
    }

    /// Checks that the periods of all elements can be counted, in the given edges and in the short ones.
    fn check_distances(
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        reduced: &ReducedBox<T, D>,
    ) -> Result<(), Error> {
        let points = match &elements.shape {
            Shape::Equal(equal) => equal.points(),
            Shape::Spheres(spheres) => spheres.points(),
            Shape::Boxes(boxes) => boxes.points(),
        };
        for (index, point) in points.iter().enumerate() {
            let given = cell.fractions(point);
            let short = reduced.cell.fractions(point);
            if let Err(edge) = cell.periods(&given) {
                let periods = given[edge];
                return Err(Error::TooFarFromBox { index, edge, periods, limit: MAX_PERIODS });
            }
            if let Err(of_short) = reduced.cell.periods(&short) {
                // Named by the edge of the caller along which the element is farthest.
                let size = |edge: &usize| given[*edge].abs();
                let repeating = (0..D).filter(|&edge| cell.periodic()[edge]);
                let edge = repeating.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(of_short);
                let limit = MAX_PERIODS * (given[edge] / short[of_short]).abs();
                return Err(Error::TooFarFromBox { index, edge, periods: given[edge], limit });
            }
        }
        Ok(())
    }

    /// [`build`](Self::build) in exactly these edges. Elements outside the box `refuse_outside`, if there is
    /// one, are refused.
    fn build_in(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        refuse_outside: Option<&PeriodicBox<T, D>>,
        may_be_apart: bool,
        max_images: usize,
        pool: &Pool,
    ) -> Result<(), Error> {
        let n = elements.len();
        self.owners.clear();
        self.shifts.clear();
        self.any_away = false;
        if n == 0 {
            self.near.clear();
            self.points.clear();
            self.far_points.clear();
            self.radii.clear();
            self.bounds = elements.bounds();
            (self.compact, self.apart) = (true, false);
            return Ok(());
        }
        let (mut points, mut far_points, radii): (_, &[[T; D]], &[T]) = match &elements.shape {
            Shape::Equal(equal) => (equal.points(), &[], &[]),
            Shape::Spheres(spheres) => (spheres.points(), &[], spheres.radii()),
            Shape::Boxes(boxes) => (boxes.points(), boxes.far_points(), &[]),
        };
        self.chunks.resize_with(n.div_ceil(CHUNK), Chunk::default);
        // Points inside the short edges of a skewed box may be outside the box.
        let may_skip = self.reduced.is_none() || refuse_outside.is_none();
        let inside = if may_skip { cell.fractions_within(&elements.bounds()) } else { None };
        let inside = inside.filter(|fractions| cell.holds(&fractions.min) && cell.holds(&fractions.max));
        let (fractions, bounds) = match inside {
            Some(fractions) => (fractions, elements.bounds()),
            None => self.wrap(points, cell, refuse_outside, pool)?,
        };
        self.wrapped_bounds = bounds;
        if self.any_away {
            self.wrap_far_points(far_points, cell)?;
        }
        let measure = LargestReach::of(&self.wrapped(elements)?);
        if self.any_away {
            (points, far_points) = (&self.wrapped, &self.wrapped_far);
        }
        self.compact = (0..D).all(|edge| {
            fractions.max[edge] - fractions.min[edge] <= COMPACT * measure.reach * norm(&cell.dual()[edge])
        });

        let window = ImageWindow { cell, fractions, margin: margin(&bounds, cell, &fractions, &measure)? };
        let interior = window.interior();
        pool.try_run(
            self.chunks.iter_mut().zip(points.chunks(CHUNK)).enumerate(),
            |(k, (chunk, points))| chunk.find_near(k * CHUNK, points, &interior, &window),
        )?;
        let images = self.chunks.iter().map(|chunk| chunk.images).sum::<f64>();
        if images.is_nan() || images > max_images as f64 {
            return Err(Error::TooManyImages { images, limit: max_images });
        }
        self.apart = may_be_apart && !self.compact && images <= APART * n as f64;

        // The old entries are overwritten, so they need not be moved.
        let images = images as usize;
        let near =
            if self.apart { self.chunks.iter().map(|chunk| chunk.owners.len()).sum() } else { points.len() };
        self.near.clear();
        reserve(&mut self.near, near)?;
        self.points.truncate(near + images);
        resize(&mut self.points, near + images, [T::ZERO; D])?;
        resize(&mut self.owners, images, 0)?;
        resize(&mut self.shifts, images, [0; D])?;
        self.bounds = if self.apart { Bounds::NOTHING } else { bounds };
        if self.apart {
            let mut places = &mut self.points[..];
            for chunk in &self.chunks {
                self.near.extend_from_slice(&chunk.owners);
                let places = places.split_off_mut(..chunk.points.len()).unwrap_or_default();
                places.copy_from_slice(&chunk.points);
            }
        } else {
            self.near.extend(0..n as u32);
            self.points[..n].copy_from_slice(points);
        }
        let (mut places, mut owners, mut shifts) =
            (&mut self.points[near..], &mut self.owners[..], &mut self.shifts[..]);
        let tasks = self.chunks.iter_mut().filter(|chunk| !chunk.owners.is_empty()).map(|chunk| {
            let images = chunk.images as usize;
            let places = places.split_off_mut(..images).unwrap_or_default();
            let owners = owners.split_off_mut(..images).unwrap_or_default();
            let shifts = shifts.split_off_mut(..images).unwrap_or_default();
            (chunk, places, owners, shifts)
        });
        pool.run(tasks, |(chunk, places, owners, shifts)| chunk.make(places, owners, shifts, &window));
        self.bounds = self.chunks.iter().fold(self.bounds, |bounds, chunk| bounds.join(&chunk.bounds));
        if self.points.is_empty() {
            self.bounds = Bounds { min: [0.0; D], max: [0.0; D] };
        }

        self.radii.clear();
        if !radii.is_empty() {
            reserve(&mut self.radii, near + images)?;
            self.radii.extend(self.near.iter().chain(&self.owners).map(|&owner| radii[owner as usize]));
        }
        self.far_points.clear();
        if !far_points.is_empty() {
            reserve(&mut self.far_points, near + images)?;
            self.far_points.extend(self.near.iter().map(|&element| far_points[element as usize]));
            let images = self.owners.iter().zip(&self.shifts);
            self.far_points
                .extend(images.map(|(&owner, shift)| cell.displaced(&far_points[owner as usize], shift)));
        }
        self.labels.pick(elements.filter(), &self.near.iter().chain(&self.owners))
    }

    /// All elements, wrapped into the box.
    pub(crate) fn wrapped<'s>(&'s self, elements: &Elements<'s, T, D>) -> Result<Elements<'s, T, D>, Error> {
        if !self.any_away {
            return Ok(*elements);
        }
        let radii = if let Shape::Spheres(spheres) = elements.shape { spheres.radii() } else { &[] };
        elements.at(&self.wrapped, &self.wrapped_far, radii, self.wrapped_bounds, elements.filter())
    }

    /// The elements near the faces, or all elements, followed by the images.
    pub(crate) fn with_images<'s>(
        &'s self,
        elements: &Elements<'s, T, D>,
    ) -> Result<Elements<'s, T, D>, Error> {
        let filter = elements.filter().map(|filter| self.labels.filter(filter));
        elements.at(&self.points, &self.far_points, &self.radii, self.bounds, filter).map_err(|mut error| {
            self.name_owner(&mut error);
            error
        })
    }

    /// Whether an element was outside the box.
    #[inline]
    pub(crate) fn is_away(&self, index: usize) -> bool {
        self.away[index / 64] >> (index % 64) & 1 == 1
    }

    /// The number of periods between an element and the box.
    ///
    /// Valid only if [some element](Self::any_away) was outside.
    #[inline]
    pub(crate) fn periods_of(&self, index: usize) -> [i32; D] {
        if self.is_away(index) { self.periods[index] } else { [0; D] }
    }

    /// Wraps all points. Returns the extremes of their fractions, and those of the wrapped points.
    fn wrap(
        &mut self,
        points: &[[T; D]],
        cell: &PeriodicBox<T, D>,
        refuse_outside: Option<&PeriodicBox<T, D>>,
        pool: &Pool,
    ) -> Result<(Bounds<D>, Bounds<D>), Error> {
        let n = points.len();
        self.away.clear();
        resize(&mut self.away, n.div_ceil(64), 0)?;
        self.periods.truncate(n);
        resize(&mut self.periods, n, [0; D])?;
        self.wrapped.truncate(n);
        resize(&mut self.wrapped, n, [T::ZERO; D])?;
        let room = self.wrapped.chunks_mut(CHUNK).zip(self.periods.chunks_mut(CHUNK));
        let room = room.zip(self.away.chunks_mut(CHUNK / 64));
        let tasks = self.chunks.iter_mut().zip(points.chunks(CHUNK)).zip(room);
        pool.run(tasks.enumerate(), |(k, ((chunk, points), ((wrapped, periods), away)))| {
            chunk.wrap(points, wrapped, periods, away, cell, refuse_outside);
            if let Some(error) = &mut chunk.error {
                name_element(error, |index| k * CHUNK + index);
            }
        });

        let (mut fractions, mut bounds) = (Bounds::NOTHING, Bounds::NOTHING);
        for chunk in &mut self.chunks {
            if let Some(error) = chunk.error.take() {
                return Err(error);
            }
            self.any_away |= chunk.any_away;
            bounds = bounds.join(&chunk.bounds);
            fractions = fractions.join(&chunk.fractions);
        }
        Ok((fractions, bounds))
    }

    fn wrap_far_points(&mut self, far_points: &[[T; D]], cell: &PeriodicBox<T, D>) -> Result<(), Error> {
        let mut wrapped = std::mem::take(&mut self.wrapped_far);
        wrapped.clear();
        reserve(&mut wrapped, far_points.len())?;
        let wrap = |(index, point): (usize, &[T; D])| cell.wrapped(*point, &self.periods_of(index));
        wrapped.extend(far_points.iter().enumerate().map(wrap));
        self.wrapped_far = wrapped;
        Ok(())
    }

    /// Makes an error about an entry of `near`, or about an image, name the element itself.
    pub(crate) fn name_owner(&self, error: &mut Error) {
        name_element(error, |index| match index.checked_sub(self.near.len()) {
            Some(image) => self.owners[image] as usize,
            None => self.near[index] as usize,
        });
    }
}

impl<T, const D: usize> Default for Chunk<T, D> {
    fn default() -> Self {
        Self {
            fractions: Bounds::NOTHING,
            bounds: Bounds::NOTHING,
            any_away: false,
            error: None,
            owners: Vec::new(),
            points: Vec::new(),
            images: 0.0,
        }
    }
}

impl<T: Real, const D: usize> Chunk<T, D> {
    /// Wraps `points` into `wrapped`. Writes `periods` and `away` where an element is outside. All arguments
    /// belong to this chunk only.
    fn wrap(
        &mut self,
        points: &[[T; D]],
        wrapped: &mut [[T; D]],
        periods: &mut [[i32; D]],
        away: &mut [u64],
        cell: &PeriodicBox<T, D>,
        refuse_outside: Option<&PeriodicBox<T, D>>,
    ) {
        let (mut all_fractions, mut bounds) = (Bounds::NOTHING, Bounds::NOTHING);
        (self.any_away, self.error) = (false, None);
        for (index, (point, wrapped)) in points.iter().zip(wrapped).enumerate() {
            let mut fractions = cell.fractions(point);
            *wrapped = *point;
            let its_periods = match cell.periods(&fractions) {
                Ok(periods) => periods,
                Err(edge) => {
                    let periods = fractions[edge];
                    self.error = Some(Error::TooFarFromBox { index, edge, periods, limit: MAX_PERIODS });
                    return;
                }
            };
            if let Some(given) = refuse_outside {
                let fractions = given.fractions(point);
                if let Some(edge) = outside(given, point, &fractions) {
                    self.error = Some(Error::OutsideBox { index, edge, fraction: fractions[edge] });
                    return;
                }
            }
            if its_periods != [0; D] {
                self.any_away = true;
                away[index / 64] |= 1 << (index % 64);
                periods[index] = its_periods;
                *wrapped = cell.wrapped(*point, &its_periods);
                fractions = cell.fractions(wrapped);
            }
            all_fractions.include(&fractions);
            bounds.include(&wrapped.map(T::to_f64));
        }
        (self.fractions, self.bounds) = (all_fractions, bounds);
    }

    /// Finds the elements that have images among the wrapped `points`, which are numbered from `first` on.
    /// Points in `interior` have none.
    fn find_near(
        &mut self,
        first: usize,
        points: &[[T; D]],
        interior: &Bounds<D>,
        window: &ImageWindow<'_, T, D>,
    ) -> Result<(), Error> {
        self.owners.clear();
        self.points.clear();
        self.images = 0.0;
        self.bounds = Bounds::NOTHING;
        for (owner, point) in (first..).zip(points) {
            if interior.contains(point) {
                continue;
            }
            let fractions = window.cell.fractions(point);
            if window.has_images(&fractions) {
                if self.points.len() == self.points.capacity() {
                    make_room(&mut self.points)?;
                }
                if self.owners.len() == self.owners.capacity() {
                    make_room(&mut self.owners)?;
                }
                self.owners.push(owner as u32);
                self.points.push(*point);
                self.images += window.images(&fractions);
            }
        }
        Ok(())
    }

    /// Makes the images of the elements found, in arrays of exactly their number.
    fn make(
        &mut self,
        places: &mut [[T; D]],
        owners: &mut [u32],
        shifts: &mut [[i32; D]],
        window: &ImageWindow<'_, T, D>,
    ) {
        let mut bounds = Bounds::NOTHING;
        let mut places = places.iter_mut().zip(owners).zip(shifts);
        for (&owner, point) in self.owners.iter().zip(&self.points) {
            bounds.include(&point.map(T::to_f64));
            window.for_each(point, |shift| {
                if let Some(((place, its_owner), its_shift)) = places.next() {
                    *place = window.cell.displaced(point, &shift);
                    (*its_owner, *its_shift) = (owner, shift);
                    bounds.include(&place.map(T::to_f64));
                }
            });
        }
        self.bounds = bounds;
    }
}

/// The nearest whole number to `x` in the direction of zero.
///
/// (`f64::trunc` is a function call in a build for any processor.)
#[inline]
fn whole(x: f64) -> f64 {
    // Larger numbers are whole already.
    if x.abs() < 4_503_599_627_370_496.0 { (x as i64) as f64 } else { x }
}

/// Changes the number of the element in an error.
fn name_element(error: &mut Error, number: impl Fn(usize) -> usize) {
    if let Error::NonFiniteCoordinate { index, .. }
    | Error::CoordinateTooLarge { index, .. }
    | Error::TooFarFromBox { index, .. }
    | Error::OutsideBox { index, .. }
    | Error::DomainTooWide { stretched_by: Some((index, _)), .. } = error
    {
        *index = number(*index);
    }
}

/// The first periodic edge along which the point is outside the closed box by more than rounding.
fn outside<T: Real, const D: usize>(
    cell: &PeriodicBox<T, D>,
    point: &[T; D],
    fractions: &[f64; D],
) -> Option<usize> {
    (0..D).filter(|&edge| cell.periodic()[edge]).find(|&edge| {
        let row = &cell.dual()[edge];
        let size = (0..D)
            .map(|axis| row[axis].abs() * (point[axis].to_f64().abs() + cell.origin()[axis].to_f64().abs()));
        let rounding = 4.0 * T::EPSILON * (size.sum::<f64>() + 1.0);
        !(fractions[edge] >= -rounding && fractions[edge] <= 1.0 + rounding)
    })
}

/// The largest difference, along each edge, between the fractions of an element and of an image that touch.
///
/// # Why no image that touches is lost
/// Let `p` be the rounded image of the wrapped point `w_j` under the shift `s`, and let it touch `w_i`. Then
/// `|p - w_i| <= R`, the reach, which bounds the rounding of the contact test (`Elements::reach`). Let `g_a`
/// be the row of the inverse as it is stored, `v_b` the edges, `F` the fractions as they are computed, `S_b`
/// a bound on `|s_b|`, and `u = T::EPSILON` (at least `2^-52`, twice the error of an operation in `f64`).
/// - `g_a . v_b = [a = b] + E_ab`. `E_ab` is computed here, with an error of at most `D u` of the sum of the
///   absolute products.
/// - `p = w_j + s . v + d`, and `|d_k| <= (D + 3) u M_k` with `M_k = |w_k| + |o_k| + sum_b S_b |v_bk|`.
/// - `F_i = g_a . (w_i - o) + e`, and `|e| <= (D + 2) u sum_k |g_ak| M_k`; the same for `F_j`.
///
/// Therefore `|s_a + F_j - F_i| <= |g_a| R + sum_b S_b |E_ab| + (3 D + 7) u sum_k |g_ak| M_k`. The
/// differences of fractions from which the shifts are found add at most `4 u (S_a + 1)`. The factor
/// `1 + 2^-40` covers the rounding of this bound, and results below the normal floats.
///
/// Touching boxes have `|p_k - w_ik| <= L + t + (2 D + 7) u M_k` on every axis. Here `w` and `p` are minimum
/// corners, `L` is the longest edge of a wrapped box, `t` the tolerance, and `M_k` bounds maximum corners and
/// `t` too. An edge of an image exceeds that of its owner by at most the roundings of its two corners,
/// `2 (D + 3) u M_k`; `max + t` is rounded once. `R` is at least `L + t`, so `|g_a| R` is replaced by
/// `sum_k |g_ak| R`, and `3 D + 7` by `5 D + 14`.
///
/// It remains to find `S_b`. The margin is `|g_a| R` plus a rest that grows at most in proportion to the
/// shifts. Let `z` be the largest `|s_b| / S_b`. With `S_b = 2 (range_b + |g_b| R + 1)` the inequality gives
/// `|s_a| <= S_a / 2 + max(z, 1) rest_a`. If `rest_a <= S_a / 4`, which is checked, then
/// `z <= 1/2 + max(z, 1) / 4`, so `z <= 3/4`, and the bound holds.
fn margin<T: Real, const D: usize>(
    bounds: &Bounds<D>,
    cell: &PeriodicBox<T, D>,
    fractions: &Bounds<D>,
    measure: &LargestReach,
) -> Result<[f64; D], Error> {
    const ABOVE: f64 = 1.0 + 1.0 / 1_099_511_627_776.0;
    let (dual, edges, periodic) =
        (cell.dual(), cell.edges().map(|edge| edge.map(T::to_f64)), cell.periodic());
    let mut magnitude = cell.origin().map(|x| x.to_f64().abs());
    let nominal: [f64; D] = std::array::from_fn(|edge| measure.width(&dual[edge]) * ABOVE);
    let shifts: [f64; D] = std::array::from_fn(|edge| {
        let width = fractions.max[edge] - fractions.min[edge];
        if periodic[edge] { 2.0 * (width + nominal[edge] + 1.0) } else { 0.0 }
    });
    for axis in 0..D {
        magnitude[axis] += bounds.min[axis].abs().max(bounds.max[axis].abs()) + measure.extent;
        magnitude[axis] += (0..D).map(|edge| shifts[edge] * edges[edge][axis].abs()).sum::<f64>();
    }

    // Edges that are not periodic never lead to images.
    let roundings = (if measure.by_axis { 5 * D + 14 } else { 3 * D + 7 }) as f64;
    let mut margin = [f64::NEG_INFINITY; D];
    for a in (0..D).filter(|&a| periodic[a]) {
        let mut rest = 4.0 * T::EPSILON * (shifts[a] + 1.0);
        for axis in 0..D {
            rest += roundings * T::EPSILON * dual[a][axis].abs() * magnitude[axis];
        }
        for b in (0..D).filter(|&b| periodic[b]) {
            let products = || (0..D).map(|axis| dual[a][axis] * edges[b][axis]);
            let identity = if a == b { 1.0 } else { 0.0 };
            let residual = products().sum::<f64>() - identity;
            let rounding = (D + 1) as f64 * f64::EPSILON * (products().map(f64::abs).sum::<f64>() + identity);
            rest += shifts[b] * (residual.abs() + rounding);
        }
        rest *= ABOVE;
        if rest.is_nan() || shifts[a].is_nan() || rest > shifts[a] / 4.0 {
            return Err(Error::UnresolvedBox { edge: a, rounding: rest });
        }
        margin[a] = (nominal[a] + rest) * ABOVE;
    }
    Ok(margin)
}

impl<T: Real, const D: usize> ImageWindow<'_, T, D> {
    /// The lowest and the highest shift along an edge of a wrapped element with this fraction, before
    /// rounding to whole edges.
    #[inline]
    fn ends(&self, edge: usize, fraction: f64) -> [f64; 2] {
        let low = (self.fractions.min[edge] - fraction) - self.margin[edge];
        let high = (self.fractions.max[edge] - fraction) + self.margin[edge];
        [low, high]
    }

    /// A region whose elements have no images: with it most elements of a large box with edges along the axes
    /// need no closer look. Empty for other boxes.
    ///
    /// Neither end of the range of shifts grows where the fraction grows, and the fraction does not fall
    /// where the coordinate grows, even with rounding. Therefore, if there is no image to the left of the
    /// largest of some coordinates, nor one to the right of the smallest, there is none in between.
    fn interior(&self) -> Bounds<D> {
        let mut interior = {
            let limit = T::MAX_MAGNITUDE.to_f64();
            Bounds { min: [-limit; D], max: [limit; D] }
        };
        for edge in (0..D).filter(|&edge| self.cell.periodic()[edge]) {
            let (origin, length) =
                (self.cell.origin()[edge].to_f64(), self.cell.edges()[edge][edge].to_f64());
            // Slightly smaller than the nominal interior, so that rounding does not matter.
            let margin = self.margin[edge] + 1e-6;
            interior.min[edge] = origin + (self.fractions.max[edge] + margin - 1.0) * length;
            interior.max[edge] = origin + (self.fractions.min[edge] - margin + 1.0) * length;
        }
        let Some(fractions) = self.cell.fractions_within(&interior) else { return Bounds::NOTHING };
        let empty = (0..D).filter(|&edge| self.cell.periodic()[edge]).any(|edge| {
            let [_, high] = self.ends(edge, fractions.min[edge]);
            let [low, _] = self.ends(edge, fractions.max[edge]);
            !(high < 1.0 && low > -1.0)
        });
        if empty { Bounds::NOTHING } else { interior }
    }

    /// Whether a wrapped element with these fractions has an image.
    #[inline]
    fn has_images(&self, fractions: &[f64; D]) -> bool {
        let mut any = false;
        for (edge, &fraction) in fractions.iter().enumerate() {
            let [low, high] = self.ends(edge, fraction);
            any |= low <= -1.0 || high >= 1.0;
        }
        any
    }

    /// The range of shifts of a wrapped element along each edge, both ends included; it always contains 0.
    #[inline]
    fn shifts(&self, fractions: &[f64; D]) -> [[f64; 2]; D] {
        let mut shifts = [[0.0; 2]; D];
        for edge in 0..D {
            let [low, high] = self.ends(edge, fractions[edge]);
            if low <= -1.0 || high >= 1.0 {
                shifts[edge] = [whole(low), whole(high)];
            }
        }
        shifts
    }

    /// The number of images of a wrapped element, not counting itself.
    fn images(&self, fractions: &[f64; D]) -> f64 {
        self.shifts(fractions).iter().map(|[low, high]| high - low + 1.0).product::<f64>() - 1.0
    }

    /// Calls `image` with every nonzero shift of a wrapped element, in lexicographic order.
    fn for_each(&self, point: &[T; D], mut image: impl FnMut([i32; D])) {
        let shifts = self.shifts(&self.cell.fractions(point)).map(|ends| ends.map(|shift| shift as i32));
        let mut shift = shifts.map(|[low, _]| low);
        loop {
            if shift != [0; D] {
                image(shift);
            }
            // Counts like an odometer: the last edge changes fastest.
            let Some(edge) = (0..D).rev().find(|&edge| shift[edge] < shifts[edge][1]) else { return };
            shift[edge] += 1;
            for later in edge + 1..D {
                shift[later] = shifts[later][0];
            }
        }
    }
}
