//! The periodic box: its edges, and the position of a point in it.

use crate::elements::Bounds;
use crate::error::Error;
use crate::real::Real;

/// A box that is periodic along some or all of its edges: rectangular, or sheared (triclinic).
///
/// `D` edges from the origin span the box. The fractions of a point are its coordinates in units of the
/// edges; inside they are 0 to 1. Along a periodic edge everything repeats: points that differ by whole edges
/// are equivalent. The edges may have any direction and tilt as long as they are linearly independent and
/// right-handed.
///
/// An edge that is not periodic only gives the direction of the faces across which the other edges repeat;
/// these are parallel to it. Its length has no effect, nothing is wrapped along it, and elements may lie
/// anywhere along it.
///
/// # Shapes
/// `origin`: `[D]`; `edges`: `[D]` rows of `[D]`. Edge `a` is periodic if `periodic[a]`.
///
/// # Units
/// The length unit of the elements. Fractions and shifts count edges.
///
/// # Example
/// ```
/// use fdem_contact::PeriodicBox;
///
/// let sheared = PeriodicBox::triclinic([0.0, 0.0], [[4.0, 0.0], [2.0, 4.0]], [true, true])?;
/// let (wrapped, periods) = sheared.wrap([7.0, 5.0]).unwrap();
/// assert_eq!((wrapped, periods), ([1.0, 1.0], [1, 1])); // [7, 5] = [1, 1] + 1 * [4, 0] + 1 * [2, 4]
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "unit cell")]
#[doc(alias = "simulation box")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicBox<T, const D: usize> {
    origin: [T; D],
    edges: [[T; D]; D],
    periodic: [bool; D],
    /// Rows of the inverse matrix: the fraction along edge `a` is the product of row `a` with the point,
    /// relative to the origin.
    dual: [[f64; D]; D],
}

/// Largest number of periods between a point and the box: a shift is the sum of two of these and the shift of
/// an image, in `i32`.
pub(crate) const MAX_PERIODS: f64 = 268_435_456.0;

/// Smallest height of an edge above the edges before it, in units of its length; lower edges count as
/// linearly dependent.
const MIN_HEIGHT: f64 = 1e-10;

impl<T: Real, const D: usize> PeriodicBox<T, D> {
    /// A box with edges along the axes, from `min` to `max`.
    ///
    /// The length of an edge is the difference `max - min`, rounded once.
    ///
    /// # Errors
    /// [`Error::InvalidDomain`] if `min < max` does not hold on every axis; otherwise those of
    /// [`PeriodicBox::triclinic`].
    pub fn orthogonal(min: [T; D], max: [T; D], periodic: [bool; D]) -> Result<Self, Error> {
        let mut edges = [[T::ZERO; D]; D];
        for axis in 0..D {
            if !(min[axis] < max[axis] && min[axis].is_finite() && max[axis].is_finite()) {
                let domain = [min[axis].to_f64(), max[axis].to_f64()];
                return Err(Error::InvalidDomain { axis, domain });
            }
            edges[axis][axis] = max[axis] - min[axis];
        }
        Self::triclinic(min, edges, periodic)
    }

    /// A box spanned by `edges` from `origin`; they may be left-handed.
    ///
    /// # Errors
    /// [`Error::InvalidBoxOrigin`], [`Error::InvalidBoxEdge`], [`Error::DependentBoxEdges`].
    pub fn triclinic(origin: [T; D], edges: [[T; D]; D], periodic: [bool; D]) -> Result<Self, Error> {
        let limit = T::MAX_MAGNITUDE.to_f64();
        for (axis, x) in origin.into_iter().enumerate() {
            if !x.is_finite() || x.to_f64().abs() > limit {
                return Err(Error::InvalidBoxOrigin { axis, value: x.to_f64(), limit });
            }
        }
        let mut directions = [[0.0; D]; D];
        let mut lengths = [0.0; D];
        for (edge, vector) in edges.iter().enumerate() {
            let vector = vector.map(T::to_f64);
            let largest =
                vector.iter().fold(0.0_f64, |largest, x| if x.abs() <= largest { largest } else { x.abs() });
            let odd = vector.iter().copied().find(|x| !x.is_finite());
            if odd.is_some() || !(largest >= T::MIN_RESOLVED && largest <= limit) {
                let limits = [T::MIN_RESOLVED, limit];
                return Err(Error::InvalidBoxEdge { edge, value: odd.unwrap_or(largest), limits });
            }
            lengths[edge] = largest;
            directions[edge] = vector.map(|x| x / largest);
        }
        check_independent(&directions)?;
        let inverse = invert(directions);
        let dual =
            std::array::from_fn(|edge| std::array::from_fn(|axis| inverse[axis][edge] / lengths[edge]));
        Ok(Self { origin, edges, periodic, dual })
    }

    /// The corner where the edges start.
    pub fn origin(&self) -> [T; D] {
        self.origin
    }

    /// The edges, one per row.
    pub fn edges(&self) -> [[T; D]; D] {
        self.edges
    }

    /// Which edges are periodic.
    pub fn periodic(&self) -> [bool; D] {
        self.periodic
    }

    /// The distances between opposite faces, up to rounding. They never exceed the lengths of the edges.
    pub fn heights(&self) -> [f64; D] {
        self.dual.map(|row| 1.0 / norm(&row))
    }

    /// The position of a point along each edge, in units of the edge.
    ///
    /// With `g_a` the row of the inverse matrix of the edges for edge `a`, in `f64`:
    /// `((g_a0 * (x_0 - o_0)) + g_a1 * (x_1 - o_1)) + …`, the axes in ascending order, each operation rounded
    /// once.
    #[inline]
    pub fn fractions(&self, point: &[T; D]) -> [f64; D] {
        self.fractions_of(&point.map(T::to_f64))
    }

    #[inline]
    fn fractions_of(&self, point: &[f64; D]) -> [f64; D] {
        let from_origin: [f64; D] = std::array::from_fn(|axis| point[axis] - self.origin[axis].to_f64());
        std::array::from_fn(|edge| {
            let row = &self.dual[edge];
            (1..D).fold(row[0] * from_origin[0], |sum, axis| sum + row[axis] * from_origin[axis])
        })
    }

    /// The image of a point in the box, and the number of periods along each edge between the point and its
    /// image.
    ///
    /// The periods are `n_a = floor` of the [`fractions`](Self::fractions), and 0 along edges that are not
    /// periodic. The image is the point [`displaced`](Self::displaced) by `-n`, or the point itself if all
    /// `n` are 0. It may be outside the box by a rounding error. `None` if a coordinate is not finite, or the
    /// point is more than `2^28` periods away.
    pub fn wrap(&self, point: [T; D]) -> Option<([T; D], [i32; D])> {
        let periods = self.periods(&self.fractions(&point)).ok()?;
        Some((self.wrapped(point, &periods), periods))
    }

    /// The point displaced by `shift` edges: per axis `x + (((s_0 * v_0) + s_1 * v_1) + …)`, where `v_a` is
    /// the component of edge `a`.
    ///
    /// The operations are done in `f64`, the edges in ascending order. Each operation rounds once, without
    /// fused multiply-add; the result is rounded to `T`.
    #[inline]
    pub fn displaced(&self, point: &[T; D], shift: &[i32; D]) -> [T; D] {
        std::array::from_fn(|axis| {
            let term = |edge: usize| f64::from(shift[edge]) * self.edges[edge][axis].to_f64();
            let offset = (1..D).fold(term(0), |sum, edge| sum + term(edge));
            T::nearest(point[axis].to_f64() + offset)
        })
    }

    /// The extremes of the fractions of points with the extremes `bounds`, if the edges lie along the axes.
    /// Then each fraction depends on one coordinate and, even with rounding, never falls where that
    /// coordinate grows. (The other terms of its sum are zeros.) `None` for other boxes.
    pub(crate) fn fractions_within(&self, bounds: &Bounds<D>) -> Option<Bounds<D>> {
        let along_axes = (0..D).all(|edge| (0..D).all(|axis| edge == axis || self.dual[edge][axis] == 0.0));
        let positive = (0..D).all(|edge| self.dual[edge][edge] > 0.0);
        (along_axes && positive)
            .then(|| Bounds { min: self.fractions_of(&bounds.min), max: self.fractions_of(&bounds.max) })
    }

    /// Whether a point with these fractions is in the box: all of its periods are 0.
    #[inline]
    pub(crate) fn holds(&self, fractions: &[f64; D]) -> bool {
        let mut inside = true;
        for (edge, fraction) in fractions.iter().enumerate() {
            inside &= !self.periodic[edge] || (0.0 <= *fraction && *fraction < 1.0);
        }
        inside
    }

    /// The periods of a point, or the edge along which there are too many.
    #[inline]
    pub(crate) fn periods(&self, fractions: &[f64; D]) -> Result<[i32; D], usize> {
        let mut periods = [0; D];
        for edge in 0..D {
            let fraction = fractions[edge];
            if self.periodic[edge] && !(0.0..1.0).contains(&fraction) {
                if fraction.is_nan() || fraction.abs() > MAX_PERIODS {
                    return Err(edge);
                }
                periods[edge] = fraction.floor() as i32;
            }
        }
        Ok(periods)
    }

    /// The image in the box of a point that is `periods` away from it.
    #[inline]
    pub(crate) fn wrapped(&self, point: [T; D], periods: &[i32; D]) -> [T; D] {
        if *periods == [0; D] { point } else { self.displaced(&point, &periods.map(|n| -n)) }
    }

    /// The rows of the inverse of the matrix of edges: the fraction along edge `a` grows by the product of
    /// row `a` with a displacement.
    pub fn dual(&self) -> &[[f64; D]; D] {
        &self.dual
    }
}

pub(crate) fn norm<const D: usize>(vector: &[f64; D]) -> f64 {
    let largest = vector.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    vector.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt() * largest
}

/// Checks linear independence by the Gram-Schmidt process. Every vector is orthogonalised twice, so that
/// rounding is not mistaken for height.
fn check_independent<const D: usize>(directions: &[[f64; D]; D]) -> Result<(), Error> {
    let mut basis = [[0.0; D]; D];
    for edge in 0..D {
        let length = norm(&directions[edge]);
        let mut rest = directions[edge].map(|x| x / length);
        for _ in 0..2 {
            for before in &basis[..edge] {
                let along = (0..D).map(|axis| rest[axis] * before[axis]).sum::<f64>();
                rest = std::array::from_fn(|axis| rest[axis] - along * before[axis]);
            }
        }
        let height = norm(&rest);
        if height.is_nan() || height < MIN_HEIGHT {
            return Err(Error::DependentBoxEdges { edge, height, limit: MIN_HEIGHT });
        }
        basis[edge] = rest.map(|x| x / height);
    }
    Ok(())
}

/// The inverse, by Gauss-Jordan elimination with row pivots. The inverse of a diagonal
/// matrix is exact except for its divisions.
fn invert<const D: usize>(mut matrix: [[f64; D]; D]) -> [[f64; D]; D] {
    let mut inverse: [[f64; D]; D] =
        std::array::from_fn(|row| std::array::from_fn(|column| if row == column { 1.0 } else { 0.0 }));
    for column in 0..D {
        let pivot = (column..D).fold(column, |best, row| {
            if matrix[row][column].abs() > matrix[best][column].abs() { row } else { best }
        });
        if pivot != column {
            matrix.swap(pivot, column);
            inverse.swap(pivot, column);
        }
        let divisor = matrix[column][column];
        matrix[column] = matrix[column].map(|x| x / divisor);
        inverse[column] = inverse[column].map(|x| x / divisor);
        for row in (0..D).filter(|&row| row != column) {
            let factor = matrix[row][column];
            if factor != 0.0 {
                for k in 0..D {
                    matrix[row][k] -= factor * matrix[column][k];
                    inverse[row][k] -= factor * inverse[column][k];
                }
            }
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [bool; 3] = [true; 3];

    #[test]
    fn the_dual_of_a_rectangular_box_is_the_inverse_of_its_lengths() {
        let cell = PeriodicBox::orthogonal([1.0, -2.0, 0.0], [4.0, -1.0, 0.1], ALL).unwrap();
        assert_eq!(cell.dual, [[1.0 / 3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0 / 0.1]]);
        assert_eq!(cell.heights().map(|h| (h * 1e9).round()), [3e9, 1e9, 1e8]);
    }

    #[test]
    fn faulty_boxes_are_refused_with_what_is_wrong() {
        let fault = |edges: [[f64; 3]; 3]| PeriodicBox::triclinic([0.0; 3], edges, ALL).unwrap_err();
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let with = |edge: usize, vector| {
            let mut edges = unit;
            edges[edge] = vector;
            edges
        };
        for (edge, vector) in [(1, [0.0; 3]), (2, [f64::NAN, 0.0, 0.0]), (0, [f64::INFINITY, 1.0, 0.0])] {
            let error = fault(with(edge, vector));
            assert!(matches!(error, Error::InvalidBoxEdge { edge: e, .. } if e == edge), "{error}");
        }
        for (edge, vector) in [(1, [5.0, 0.0, 0.0]), (2, [1.0, 1.0, 1e-12]), (2, [0.1, 0.7, 0.0])] {
            let error = fault(with(edge, vector));
            assert!(matches!(error, Error::DependentBoxEdges { edge: e, .. } if e == edge), "{error}");
        }
        let error = PeriodicBox::triclinic([0.0, f64::NAN, 0.0], unit, ALL).unwrap_err();
        assert!(matches!(error, Error::InvalidBoxOrigin { axis: 1, .. }), "{error}");
        for max in [0.0, -1.0, f64::NAN] {
            let error = PeriodicBox::orthogonal([0.0; 3], [1.0, max, 1.0], ALL).unwrap_err();
            assert!(matches!(error, Error::InvalidDomain { axis: 1, .. }), "{error}");
        }
    }

    #[test]
    fn points_are_wrapped_along_periodic_edges_only() {
        let edges = [[4.0, 0.0], [8.0, 4.0]];
        let cell = PeriodicBox::triclinic([0.0, 0.0], edges, [true, false]).unwrap();
        // The faces are inclined: at y = 5 the box extends from x = 10 to 14.
        assert_eq!(cell.wrap([1.0, 5.0]), Some(([13.0, 5.0], [-3, 0])));
        assert_eq!(cell.wrap([f64::NAN, 5.0]), None);
        assert_eq!(cell.wrap([1e10, 5.0]), None);
    }
}
