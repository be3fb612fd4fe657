//! Rotations in space, as quaternions of unit length with the real part first.

use crate::vector::{Vector, dot, length};

/// A rotation.
pub(crate) type Quaternion = [f64; 4];

/// A matrix by its rows.
pub(crate) type Matrix = [Vector; 3];

/// The rotation that turns nothing.
pub(crate) const UNTURNED: Quaternion = [1.0, 0.0, 0.0, 0.0];

/// The rotation, and one about a vector in space after it. The vector's length is the angle, rad.
pub(crate) fn turned_by(rotation: Quaternion, vector: Vector) -> Quaternion {
    let angle = length(vector);
    let along = if angle > 1e-100 { libm::sin(0.5 * angle) / angle } else { 0.5 };
    let real = libm::cos(0.5 * angle);
    let [i, j, k] = vector.map(|x| along * x);
    let [w, x, y, z] = rotation;
    let both = [
        real * w - i * x - j * y - k * z,
        real * x + i * w + j * z - k * y,
        real * y - i * z + j * w + k * x,
        real * z + i * y - j * x + k * w,
    ];
    let size = (both[0] * both[0] + both[1] * both[1] + both[2] * both[2] + both[3] * both[3]).sqrt();
    both.map(|part| part / size)
}

/// The matrix that turns vectors as a rotation does.
pub(crate) fn matrix([w, x, y, z]: Quaternion) -> Matrix {
    let [xx, yy, zz] = [2.0 * x * x, 2.0 * y * y, 2.0 * z * z];
    let [xy, yz, zx] = [2.0 * x * y, 2.0 * y * z, 2.0 * z * x];
    let [wx, wy, wz] = [2.0 * w * x, 2.0 * w * y, 2.0 * w * z];
    [[1.0 - yy - zz, xy - wz, zx + wy], [xy + wz, 1.0 - xx - zz, yz - wx], [zx - wy, yz + wx, 1.0 - xx - yy]]
}

/// The matrix times a vector.
#[inline]
pub(crate) fn applied(matrix: &Matrix, vector: Vector) -> Vector {
    [dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)]
}

/// The transposed matrix times a vector: that of a rotation turns the vector back.
#[inline]
pub(crate) fn applied_back(matrix: &Matrix, vector: Vector) -> Vector {
    let column = |k: usize| matrix[0][k] * vector[0] + matrix[1][k] * vector[1] + matrix[2][k] * vector[2];
    [column(0), column(1), column(2)]
}

/// The inverse of a matrix, or `None` if it is not symmetric and positive.
pub(crate) fn inverse(of: &Matrix) -> Option<Matrix> {
    let minor = |i: usize, k: usize| {
        let ([a, b], [c, d]) = ([(i + 1) % 3, (i + 2) % 3], [(k + 1) % 3, (k + 2) % 3]);
        of[a][c] * of[b][d] - of[a][d] * of[b][c]
    };
    let determinant = of[0][0] * minor(0, 0) + of[0][1] * minor(0, 1) + of[0][2] * minor(0, 2);
    let size = of[0][0] + of[1][1] + of[2][2];
    let is_symmetric =
        [(0, 1), (0, 2), (1, 2)].iter().all(|&(i, k)| (of[i][k] - of[k][i]).abs() <= 1e-9 * size);
    let is_positive = of[0][0] > 0.0 && minor(2, 2) > 0.0 && determinant > 0.0;
    (is_symmetric && is_positive).then(|| {
        // The transposed one of the minors; of a symmetric matrix both are the same.
        std::array::from_fn(|i| std::array::from_fn(|k| minor(i.min(k), i.max(k)) / determinant))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_turn_vectors() {
        // A third of a turn about the diagonal takes each axis to the next.
        let third = 2.0 * std::f64::consts::PI / 3.0;
        let turn = matrix(turned_by(UNTURNED, [third / 3.0_f64.sqrt(); 3]));
        let vector = [0.3, -2.0, 0.7];
        let found = applied(&turn, vector);
        assert!((0..3).all(|k| (found[(k + 1) % 3] - vector[k]).abs() < 1e-15), "{found:?}");
        let back = applied_back(&turn, found);
        assert!((0..3).all(|k| (back[k] - vector[k]).abs() < 1e-15), "{back:?}");
        // The second rotation is about axes in space.
        let (one, two) = ([0.3, -0.2, 0.9], [0.1, 0.7, -0.4]);
        let both = applied(&matrix(turned_by(turned_by(UNTURNED, one), two)), vector);
        let apart =
            applied(&matrix(turned_by(UNTURNED, two)), applied(&matrix(turned_by(UNTURNED, one)), vector));
        assert!((0..3).all(|k| (both[k] - apart[k]).abs() < 1e-15), "{both:?} {apart:?}");
    }

    #[test]
    fn inverses_are_those_of_positive_matrices() {
        let of = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.25], [-0.5, 0.25, 2.0]];
        let inverse_of = inverse(&of).expect("it is positive");
        for k in 0..3 {
            let mut unit = [0.0; 3];
            unit[k] = 1.0;
            let found = applied(&of, applied(&inverse_of, unit));
            assert!((0..3).all(|i| (found[i] - unit[i]).abs() < 1e-15), "{found:?}");
        }
        assert_eq!(inverse(&[[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), None);
        assert_eq!(inverse(&[[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), None);
    }
}
