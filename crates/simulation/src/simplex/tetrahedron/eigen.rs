//! Eigenvalues and eigenvectors of symmetric matrices, by Jacobi's rotations: square roots are their only
//! functions, so that they are the same on every platform.

use crate::simplex::tetrahedron::elastic;
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
            // So small that it turns no digit of a vector.
            if off.abs() <= 1e-18 * (a[q][q] - a[p][p]).abs() {
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

/// Upper bounds of the middle and of the radius of Mohr's largest circle, for batches.
///
/// With the mean p, the second invariant J₂ of the deviator, t = √(J₂/3), and the third invariant as
/// x = J₃/(2 t³), the eigenvalues are p + 2 t cos(θ + 2πk/3) with cos 3θ = x (Lode's angle). Of these, the
/// middle between the largest and the least is p + t w, and half of their difference √3 t √(1 - w²), with w =
/// sin(arcsin(x)/3).
#[inline(always)]
pub(super) fn circle_close(stress: &Matrix<3>) -> [f64; 2] {
    let mean = (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0;
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = *stress;
    let (xx, yy, zz) = (xx - mean, yy - mean, zz - mean);
    // The sum of squares is 3 J₂.
    let t = elastic::deviation(stress).sqrt() / 3.0;
    // Divided first, so that nothing overflows. Without a deviator x is 0.
    let scale = 1.0 / (t + f64::MIN_POSITIVE);
    let [xx, yy, zz, xy, yz, xz] = [xx, yy, zz, xy, yz, xz].map(|entry| entry * scale);
    let third = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    let x = (0.5 * third).abs().min(1.0);
    let w = third_of_arcsine(x).copysign(third);
    let radius = 3.0_f64.sqrt() * t * (1.0 - w * w).sqrt();
    // The error of w is below 1e-7; where the mean is large beside t, that of x is larger by rounding.
    let slack = 1e-6 * t + 1e-9 * mean.abs();
    [mean + t * w + slack, radius + slack]
}

/// sin(arcsin(x)/3) for x from 0 to 1, within 1e-7.
#[inline(always)]
fn third_of_arcsine(x: f64) -> f64 {
    // arccos(x) = √(1 - x) P(x) within 2e-8: Abramowitz and Stegun, 4.4.46.
    const ARCCOSINE: [f64; 8] = [
        -0.001_262_491_1,
        0.006_670_090_1,
        -0.017_088_125_6,
        0.030_891_881_0,
        -0.050_174_304_6,
        0.088_978_987_4,
        -0.214_598_801_6,
        1.570_796_305_0,
    ];
    let mut sum = ARCCOSINE[0];
    for factor in &ARCCOSINE[1..] {
        sum = sum * x + factor;
    }
    // From 0 to 30 degrees, where the series of sine and cosine converge at once.
    let angle = (1.0 - x).sqrt() * sum / 3.0;
    let square = angle * angle;
    let sine =
        angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))));
    let cosine = 1.0
        - square / 2.0
            * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0))));
    // sin(30° - angle)
    0.5 * cosine - 0.75_f64.sqrt() * sine
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::vector::{applied, dot, length, minus};

    /// The bounds are above the circle, and close to it, also where two eigenvalues are the same, or all are
    /// nearly so.
    #[test]
    fn the_bound_of_a_circle_is_close() {
        for seed in 0..20_000_u64 {
            let random = |k: u64| uniform(seed, k) - 0.5;
            let mut a: Matrix<3> = matrix(|i, k| random((3 * i.min(k) + i.max(k)) as u64));
            match seed % 4 {
                0 => {}
                // A uniaxial stress in any direction, with or without others beside it.
                1 => a = matrix(|i, k| random(i as u64) * random(k as u64)),
                2 => a = matrix(|i, k| -random(i as u64) * random(k as u64) + 1e-9 * a[i][k]),
                _ => {
                    a = matrix(|i, k| {
                        10.0_f64.powi((seed % 17) as i32 - 12) * a[i][k] + if i == k { -3.0 } else { 0.0 }
                    });
                }
            }
            let values = values(a);
            let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let least = values.into_iter().fold(f64::INFINITY, f64::min);
            let mean = (values[0] + values[1] + values[2]).abs() / 3.0;
            let bounds = circle_close(&a);
            for (bound, exact) in bounds.into_iter().zip([0.5 * (most + least), 0.5 * (most - least)]) {
                let room = 1e-6 * (most - least) + 2e-9 * mean + 1e-300;
                assert!(exact <= bound && bound <= exact + 2.0 * room, "{a:?}: {bound} for {exact}");
            }
        }
        assert_eq!(circle_close(&[[0.0; 3]; 3]), [0.0; 2]);
    }

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
