//! Deformations at random, for tests of laws.

use crate::random::uniform;
use crate::vector::{Matrix, dot, matrix, product};

/// A matrix of numbers at random, between -1 and 1.
pub(crate) fn any<const D: usize>(seed: u64) -> Matrix<D> {
    matrix(|i, k| 2.0 * uniform(seed, (D * i + k) as u64) - 1.0)
}

pub(crate) fn one<const D: usize>() -> Matrix<D> {
    matrix(|i, k| f64::from(u8::from(i == k)))
}

/// A rotation, from reflections at random.
pub(crate) fn rotation<const D: usize>(seed: u64) -> Matrix<D> {
    let reflection = |row: [f64; D]| -> Matrix<D> {
        let squared = dot(row, row);
        matrix(|i, k| f64::from(u8::from(i == k)) - 2.0 * row[i] * row[k] / squared)
    };
    product(&reflection(any::<D>(seed)[0]), &reflection(any::<D>(seed)[1]))
}
