//! Rotations in space, as quaternions of unit length with the real part first. A rotation in the plane is one
//! about the third axis.

use std::f64::consts::PI;

use crate::simplex::Simplex;
use crate::vector::{Matrix, Point, dot, length, matrix};

/// A rotation.
pub(crate) type Quaternion = [f64; 4];

/// The rotation that turns nothing.
pub(crate) const UNTURNED: Quaternion = [1.0, 0.0, 0.0, 0.0];

/// The matrix of a rotation.
pub(crate) fn matrix_of([w, x, y, z]: Quaternion) -> Matrix<3> {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// A rotation, followed by one about a vector in space: the angle, in radians, is its length.
pub(crate) fn turned(rotation: Quaternion, by: Point<3>) -> Quaternion {
    let angle = length(by);
    // sin(angle/2) / angle.
    let share = if angle > 1e-100 { libm::sin(0.5 * angle) / angle } else { 0.5 };
    let (a, [b, c, d]) = (libm::cos(0.5 * angle), by.map(|x| share * x));
    let [w, x, y, z] = rotation;
    let product = [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ];
    let long = dot(product, product).sqrt();
    product.map(|x| x / long)
}

/// The vector of a rotation, along its axis and as long as its angle, rad. Of all angles that differ by whole
/// turns, it is that nearest to the vector a step before, so that turns add up.
pub(crate) fn rotation_vector([w, x, y, z]: Quaternion, before: Point<3>) -> Point<3> {
    let (imaginary, size, so_far) = ([x, y, z], length([x, y, z]), length(before));
    // After whole turns the axis is that before, and rounding must not decide it: the error of the axis is
    // that of the quaternion over this size.
    let (axis, angle) = if size < 1e-7 && so_far > PI {
        let axis = before.map(|x| x / so_far);
        (axis, 2.0 * dot(axis, imaginary) * w.signum())
    } else if size > 0.0 {
        (imaginary.map(|x| x / size), 2.0 * libm::atan2(size, w))
    } else {
        return [0.0; 3];
    };
    let turns = ((dot(axis, before) - angle) / (2.0 * PI)).round();
    axis.map(|x| (angle + 2.0 * PI * turns) * x)
}

/// A vector in space: one of the plane has no third component.
#[inline]
pub(crate) fn lifted<const D: usize>(vector: Point<D>) -> Point<3> {
    std::array::from_fn(|axis| vector.get(axis).copied().unwrap_or(0.0))
}

/// The components of a vector in the dimensions of the model.
#[inline]
pub(crate) fn lowered<const D: usize>(vector: Point<3>) -> Point<D> {
    std::array::from_fn(|axis| vector[axis])
}

/// The inverse of a symmetric matrix.
pub(crate) fn inverse(a: &Matrix<3>) -> Matrix<3> {
    let cofactor = <[[f64; 3]; 4]>::cofactor(a);
    let determinant = <[[f64; 3]; 4]>::determinant(a);
    matrix(|i, k| cofactor[i.min(k)][i.max(k)] / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{applied, product, transposed};

    #[test]
    fn rotations_follow_one_another() {
        let third = 2.0 * std::f64::consts::PI / 3.0;
        // A third of a turn about the diagonal takes each axis to the next.
        let diagonal = [third / 3.0_f64.sqrt(); 3];
        let turn = matrix_of(turned(UNTURNED, diagonal));
        for axis in 0..3 {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let mut next = [0.0; 3];
            next[(axis + 1) % 3] = 1.0;
            let found = applied(&turn, unit);
            assert!((0..3).all(|k| (found[k] - next[k]).abs() < 1e-15), "{found:?}");
        }
        let whole = turned(turned(turned(UNTURNED, diagonal), diagonal), diagonal);
        assert!((whole[0].abs() - 1.0).abs() < 1e-15, "{whole:?}");
        // The second rotation is about axes in space.
        let (one, other) = ([0.3, -0.2, 0.9], [0.1, 0.7, -0.4]);
        let both = matrix_of(turned(turned(UNTURNED, one), other));
        let apart = product(&matrix_of(turned(UNTURNED, other)), &matrix_of(turned(UNTURNED, one)));
        let straight = product(&both, &transposed(&both));
        for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
            assert!((both[i][k] - apart[i][k]).abs() < 1e-15);
            assert!((straight[i][k] - f64::from(u8::from(i == k))).abs() < 1e-15);
        }
        assert_eq!(turned(one_of(one), [0.0; 3]), one_of(one));
    }

    fn one_of(vector: Point<3>) -> Quaternion {
        turned(UNTURNED, vector)
    }

    /// Many turns forwards and back, about an axis in general position.
    #[test]
    fn the_vector_of_a_rotation_counts_turns() {
        let axis = [0.36, -0.48, 0.8];
        let (mut rotation, mut vector, mut angle) = (UNTURNED, [0.0; 3], 0.0);
        // 500 steps are exactly five turns.
        for step in (0..500).chain([500; 3]).chain((0..1300).map(|_| 1000)) {
            let by = match step {
                500 => 0.0,
                1000 => -0.02 * PI,
                _ => 0.02 * PI,
            };
            rotation = turned(rotation, axis.map(|x| by * x));
            vector = rotation_vector(rotation, vector);
            angle += by;
            for k in 0..3 {
                assert!((vector[k] - angle * axis[k]).abs() < 1e-10, "{vector:?} {angle}");
            }
        }
        assert!((angle + 16.0 * PI).abs() < 1e-10, "{angle}");
        assert_eq!(rotation_vector(UNTURNED, [0.0; 3]), [0.0; 3]);
    }

    #[test]
    fn a_rotation_in_the_plane_leaves_the_third_axis() {
        let turn = matrix_of(turned(turned(UNTURNED, [0.0, 0.0, 0.4]), [0.0, 0.0, 2.9]));
        assert_eq!([turn[2], [turn[0][2], turn[1][2], 1.0]], [[0.0, 0.0, 1.0]; 2]);
        assert!((turn[0][0] - 3.3_f64.cos()).abs() < 1e-15);
    }

    #[test]
    fn the_inverse_of_a_symmetric_matrix() {
        let a = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.25], [-0.5, 0.25, 2.0]];
        let one = product(&a, &inverse(&a));
        for (i, k) in (0..3).flat_map(|i| (0..3).map(move |k| (i, k))) {
            assert!((one[i][k] - f64::from(u8::from(i == k))).abs() < 1e-15);
        }
    }
}
