//! Eigenvalues and eigenvectors of symmetric matrices, by Jacobi's rotations: square roots are their only
//! functions, so that they are the same on every platform.

use crate::vector::{Matrix, matrix};

/// Convergence is quadratic: five rounds leave nothing that a double can hold.
const ROUNDS: usize = 6;

/// Eigenvalues, in no order.
pub(super) fn values(a: Matrix<3>) -> [f64; 3] {
    values_and_vectors(a).0
}

/// Eigenvalues, in no order, and the unit vector of each.
pub(super) fn values_and_vectors(mut a: Matrix<3>) -> ([f64; 3], Matrix<3>) {
    let mut vectors = matrix(|i, k| f64::from(u8::from(i == k)));
    for _ in 0..ROUNDS {
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let off = a[p][q];
            if off == 0.0 {
                continue;
            }
            let cotangent = (a[q][q] - a[p][p]) / (2.0 * off);
            let tangent = cotangent.signum() / (cotangent.abs() + (1.0 + cotangent * cotangent).sqrt());
            let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sin = tangent * cos;
            a[p][p] -= tangent * off;
            a[q][q] += tangent * off;
            (a[p][q], a[q][p]) = (0.0, 0.0);
            let (rp, rq) = (a[r][p], a[r][q]);
            (a[r][p], a[r][q]) = (cos * rp - sin * rq, sin * rp + cos * rq);
            (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
            let (one, two) = (vectors[p], vectors[q]);
            vectors[p] = std::array::from_fn(|axis| cos * one[axis] - sin * two[axis]);
            vectors[q] = std::array::from_fn(|axis| sin * one[axis] + cos * two[axis]);
        }
    }
    ([a[0][0], a[1][1], a[2][2]], vectors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::vector::{applied, dot, length, minus};

    #[test]
    fn vectors_are_stretched_by_their_values() {
        for seed in 0..1000 {
            // Also matrices that are nearly diagonal, and such of very unlike entries.
            let scale = |i: usize, k: usize| [1.0, 1e-9, 1e6][(i * k + seed as usize) % 3];
            let half: Matrix<3> = matrix(|i, k| scale(i, k) * (uniform(seed, (3 * i + k) as u64) - 0.5));
            let a: Matrix<3> = matrix(|i, k| half[i][k] + half[k][i]);
            let size = a.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let (values, vectors) = values_and_vectors(a);
            for (value, vector) in values.into_iter().zip(vectors) {
                assert!((dot(vector, vector) - 1.0).abs() < 1e-14);
                let off = length(minus(applied(&a, vector), vector.map(|x| value * x)));
                assert!(off < 1e-14 * size, "{a:?} {off}");
            }
            assert!(dot(vectors[0], vectors[1]).abs() < 1e-14 && dot(vectors[1], vectors[2]).abs() < 1e-14);
        }
    }
}
