//! Rows of four numbers: one operation on a row is one of a vector register.

#![allow(clippy::inline_always, reason = "what is compiled for vector instructions must be inlined")]

use crate::vector::Vector;

/// A vector and another number.
#[inline(always)]
pub(crate) fn row([x, y, z]: Vector, number: f64) -> [f64; 4] {
    [x, y, z, number]
}

/// A row and a multiple of another one.
#[inline(always)]
pub(crate) fn and(row: [f64; 4], scale: [f64; 4], other: [f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|k: usize| row[k] + scale[k] * other[k])
}

/// The difference of two rows.
#[inline(always)]
pub(crate) fn less(one: [f64; 4], two: [f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|k: usize| one[k] - two[k])
}

/// The square of the vector of a row.
#[inline(always)]
pub(crate) fn square(row: [f64; 4]) -> f64 {
    let squares = row.map(|x| x * x);
    squares[0] + squares[1] + squares[2]
}

/// The larger of two numbers; the second if one is none.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; the second if one is none.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
