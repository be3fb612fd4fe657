//! Elements wrapped into a periodic box, and the images of them that may touch one of them.

use crate::elements::{Elements, Shape};
use crate::error::Error;
use crate::filter::Labels;
use crate::periodic::cell::{MAX_PERIODS, PeriodicBox, norm};
use crate::real::Real;
use crate::search::rows::{reserve, resize};

/// The wrapped elements, then their images.
///
/// # Shapes
/// `centres`: `[n + m]`, first the `n` elements in the caller's order, then the `m` images, by owner and then by shift.
/// `radii`: the same, or empty for elements of one radius. `periods`: `[n]`. `owners`, `shifts`: `[m]`.
#[derive(Clone, Debug)]
pub(crate) struct Images<T, const D: usize> {
    pub(crate) centres: Vec<[T; D]>,
    pub(crate) radii: Vec<T>,
    /// The filter's numbers, as many as centres; an image has those of its owner.
    pub(crate) labels: Labels,
    /// Periods that each element was away from the box.
    pub(crate) periods: Vec<[i32; D]>,
    /// A bit for each element: whether it was away at all. Most are not, and these bits stay in cache where `periods` does not.
    pub(crate) away: Vec<u64>,
    /// The element that an image is of.
    pub(crate) owners: Vec<u32>,
    /// By how many edges the image is displaced from its wrapped owner.
    pub(crate) shifts: Vec<[i32; D]>,
    /// Whether the elements fill so little space that most are within reach of most others.
    pub(crate) compact: bool,
}

/// The range of the fractions of the wrapped elements.
#[derive(Clone, Copy)]
struct Range<const D: usize> {
    min: [f64; D],
    max: [f64; D],
}

/// The box, the range, and by how much the fractions of elements that touch may differ.
struct Window<'a, T, const D: usize> {
    cell: &'a PeriodicBox<T, D>,
    range: Range<D>,
    margin: [f64; D],
}

/// All elements within two reaches: testing all of them is cheaper than sorting them.
const COMPACT: f64 = 2.0;

impl<T: Real, const D: usize> Images<T, D> {
    pub(crate) fn new() -> Self {
        Self {
            centres: Vec::new(),
            radii: Vec::new(),
            labels: Labels::default(),
            periods: Vec::new(),
            away: Vec::new(),
            owners: Vec::new(),
            shifts: Vec::new(),
            compact: false,
        }
    }

    /// Wraps the elements and makes all images that may touch a wrapped element, at most `max_images`.
    pub(crate) fn build(
        &mut self,
        elements: &Elements<'_, T, D>,
        cell: &PeriodicBox<T, D>,
        refuse_outside: bool,
        max_images: usize,
    ) -> Result<(), Error> {
        self.owners.clear();
        self.shifts.clear();
        self.radii.clear();
        let centres = match elements.shape {
            Shape::Equal(equal) => equal.points(),
            Shape::Spheres(spheres) => spheres.points(),
            Shape::Boxes(_) => return Err(Error::BoxesNotPeriodic),
        };
        let range = self.wrap(centres, cell, refuse_outside)?;
        let reach = elements.reach().max(T::MIN_RESOLVED);
        self.compact = (0..D)
            .all(|edge| range.max[edge] - range.min[edge] <= COMPACT * reach * norm(&cell.dual()[edge]));
        let window = Window { cell, range, margin: margin(&self.centres, cell, range, reach)? };

        let images = self.centres.iter().map(|centre| window.images(centre)).sum::<f64>();
        if images.is_nan() || images > max_images as f64 {
            return Err(Error::TooManyImages { images, limit: max_images });
        }
        let images = images as usize;
        reserve(&mut self.owners, images)?;
        reserve(&mut self.shifts, images)?;
        reserve(&mut self.centres, images)?;
        if let Shape::Spheres(spheres) = elements.shape {
            reserve(&mut self.radii, centres.len() + images)?;
            self.radii.extend_from_slice(spheres.radii());
        }
        for owner in 0..centres.len() {
            let centre = self.centres[owner];
            window.for_each(&centre, |shift| {
                self.centres.push(cell.displaced(&centre, &shift));
                self.owners.push(owner as u32);
                self.shifts.push(shift);
            });
        }
        if let Shape::Spheres(spheres) = elements.shape {
            self.radii.extend(self.owners.iter().map(|&owner| spheres.radii()[owner as usize]));
        }
        self.labels.copy(elements.filter(), &self.owners)
    }

    /// Periods that an element was away from the box.
    #[inline]
    pub(crate) fn periods_of(&self, index: usize) -> [i32; D] {
        if self.away[index / 64] >> (index % 64) & 1 == 0 { [0; D] } else { self.periods[index] }
    }

    /// Wraps all centres; returns the range of their fractions.
    fn wrap(
        &mut self,
        centres: &[[T; D]],
        cell: &PeriodicBox<T, D>,
        refuse_outside: bool,
    ) -> Result<Range<D>, Error> {
        self.centres.clear();
        self.periods.clear();
        reserve(&mut self.centres, centres.len())?;
        reserve(&mut self.periods, centres.len())?;
        self.away.clear();
        resize(&mut self.away, centres.len().div_ceil(64), 0)?;
        let mut range = Range { min: [f64::INFINITY; D], max: [f64::NEG_INFINITY; D] };
        for (index, centre) in centres.iter().enumerate() {
            let mut fractions = cell.fractions(centre);
            let periods = cell.periods(&fractions).map_err(|edge| {
                let periods = fractions[edge];
                Error::TooFarFromBox { index, edge, periods, limit: MAX_PERIODS }
            })?;
            let mut wrapped = *centre;
            if periods != [0; D] {
                if refuse_outside && let Some(edge) = outside(cell, centre, &fractions) {
                    return Err(Error::OutsideBox { index, edge, fraction: fractions[edge] });
                }
                self.away[index / 64] |= 1 << (index % 64);
                wrapped = cell.wrapped(*centre, &periods);
                fractions = cell.fractions(&wrapped);
            }
            for (edge, fraction) in fractions.into_iter().enumerate() {
                range.min[edge] = range.min[edge].min(fraction);
                range.max[edge] = range.max[edge].max(fraction);
            }
            self.centres.push(wrapped);
            self.periods.push(periods);
        }
        Ok(range)
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

/// By how much the fractions of an element and of an image that touch may differ along each edge.
///
/// # Why no image that touches is lost
/// Let `p` be the rounded image of the wrapped point `w_j` under the shift `s`, and let it touch `w_i`. Then
/// `|p - w_i| <= R`, the reach, which bounds the rounding of the contact test (`Elements::reach`). Write `g_a` for the row of the
/// inverse as it is stored, `v_b` for the edges, `F` for the fractions as they are computed, `S_b` for a bound on `|s_b|`, `u` for
/// `T::EPSILON` (at least `2^-52`, twice the error of an operation in `f64`).
/// - `g_a . v_b = [a = b] + E_ab`. `E_ab` is computed here, with an error of at most `D u` of the sum of the absolute products.
/// - `p = w_j + s . v + d`, and `|d_k| <= (D + 3) u M_k` with `M_k = |w_k| + |o_k| + sum_b S_b |v_bk|`.
/// - `F_i = g_a . (w_i - o) + e`, and `|e| <= (D + 2) u sum_k |g_ak| M_k`; the same for `F_j`.
///
/// So `|s_a + F_j - F_i| <= |g_a| R + sum_b S_b |E_ab| + (3 D + 7) u sum_k |g_ak| M_k`. The differences of fractions with
/// which the shifts are found add at most `4 u (S_a + 1)`. The factor `1 + 2^-40` covers the rounding of this bound, and results below the normal floats.
///
/// That leaves `S_b`. The margin is `|g_a| R` plus a rest that grows at most in proportion to the shifts. Let `z` be the largest `|s_b| / S_b`.
/// With `S_b = 2 (range_b + |g_b| R + 1)` the inequality gives `|s_a| <= S_a / 2 + max(z, 1) rest_a`. If `rest_a <= S_a / 4`,
/// which is checked, then `z <= 1/2 + max(z, 1) / 4`, so `z <= 3/4`: the bound holds.
fn margin<T: Real, const D: usize>(
    wrapped: &[[T; D]],
    cell: &PeriodicBox<T, D>,
    range: Range<D>,
    reach: f64,
) -> Result<[f64; D], Error> {
    const ABOVE: f64 = 1.0 + 1.0 / 1_099_511_627_776.0;
    let (dual, edges, periodic) =
        (cell.dual(), cell.edges().map(|edge| edge.map(T::to_f64)), cell.periodic());
    let mut magnitude = cell.origin().map(|x| x.to_f64().abs());
    let mut largest = [T::ZERO; D];
    for point in wrapped {
        for axis in 0..D {
            let x = if point[axis] < T::ZERO { T::ZERO - point[axis] } else { point[axis] };
            if x > largest[axis] {
                largest[axis] = x;
            }
        }
    }
    let nominal: [f64; D] = std::array::from_fn(|edge| norm(&dual[edge]) * reach * ABOVE);
    let shifts: [f64; D] = std::array::from_fn(|edge| {
        let width = range.max[edge] - range.min[edge];
        if periodic[edge] { 2.0 * (width + nominal[edge] + 1.0) } else { 0.0 }
    });
    for axis in 0..D {
        magnitude[axis] += largest[axis].to_f64();
        magnitude[axis] += (0..D).map(|edge| shifts[edge] * edges[edge][axis].abs()).sum::<f64>();
    }

    let mut margin = [0.0; D];
    for a in (0..D).filter(|&a| periodic[a]) {
        let mut rest = 4.0 * T::EPSILON * (shifts[a] + 1.0);
        for axis in 0..D {
            rest += (3 * D + 7) as f64 * T::EPSILON * dual[a][axis].abs() * magnitude[axis];
        }
        for b in (0..D).filter(|&b| periodic[b]) {
            let products = || (0..D).map(|axis| dual[a][axis] * edges[b][axis]);
            let identity = if a == b { 1.0 } else { 0.0 };
            let residual = products().sum::<f64>() - identity;
            let rounding = (D + 1) as f64 * f64::EPSILON * (products().map(f64::abs).sum::<f64>() + identity);
            rest += shifts[b] * (residual.abs() + rounding);
        }
        rest *= ABOVE;
        // Written so that NaN fails too. No elements have no range, and need no images.
        if !(rest <= shifts[a] / 4.0 || wrapped.is_empty()) {
            return Err(Error::UnresolvedBox { edge: a, rounding: rest });
        }
        margin[a] = (nominal[a] + rest) * ABOVE;
    }
    Ok(margin)
}

impl<T: Real, const D: usize> Window<'_, T, D> {
    /// The shifts of a wrapped element along each edge, both ends included; always with 0. `None` if there is only 0.
    #[inline]
    fn shifts(&self, centre: &[T; D]) -> Option<[[f64; 2]; D]> {
        let fractions = self.cell.fractions(centre);
        let mut shifts = [[0.0; 2]; D];
        let mut any = false;
        for edge in (0..D).filter(|&edge| self.cell.periodic()[edge]) {
            let low = (self.range.min[edge] - fractions[edge]) - self.margin[edge];
            let high = (self.range.max[edge] - fractions[edge]) + self.margin[edge];
            if low <= -1.0 || high >= 1.0 {
                shifts[edge] = [low.ceil(), high.floor()];
                any = true;
            }
        }
        any.then_some(shifts)
    }

    /// The number of images of a wrapped element, itself not counted.
    fn images(&self, centre: &[T; D]) -> f64 {
        self.shifts(centre)
            .map_or(0.0, |shifts| shifts.iter().map(|[low, high]| high - low + 1.0).product::<f64>() - 1.0)
    }

    /// Calls `image` with every shift of a wrapped element but 0, in lexicographic order.
    fn for_each(&self, centre: &[T; D], mut image: impl FnMut([i32; D])) {
        let Some(shifts) = self.shifts(centre) else { return };
        let shifts = shifts.map(|ends| ends.map(|shift| shift as i32));
        let mut shift = shifts.map(|[low, _]| low);
        loop {
            if shift != [0; D] {
                image(shift);
            }
            // An odometer: the last edge turns fastest.
            let Some(edge) = (0..D).rev().find(|&edge| shift[edge] < shifts[edge][1]) else { return };
            shift[edge] += 1;
            for later in edge + 1..D {
                shift[later] = shifts[later][0];
            }
        }
    }
}
