//! Signs that decide topology, exact for all coordinates that [`super::shapes`] accepts.
//!
//! Orientations are those of the crate `robust`. It has no predicates for the sides of an edge within its
//! triangle, nor for the order of points along an edge. These are evaluated in floating point and, where the
//! error bound leaves a doubt, as expansions.
//!
//! # Source
//! J.R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
//! Discrete & Computational Geometry 18 (1997) 305–363: two-sum, two-product, grow-expansion and
//! scale-expansion.

use robust::{Coord, Coord3D};

use super::vector::{dot, sub};

/// Largest magnitude of a coordinate or radius: `2^200`, so that products of four differences do not
/// overflow.
pub const MAX_MAGNITUDE: f64 = f64::from_bits((1023 + 200) << 52);

/// Smallest magnitude of a coordinate or radius that is not 0: `2^-200`, so that products of four differences
/// do not underflow.
pub const MIN_MAGNITUDE: f64 = f64::from_bits((1023 - 200) << 52);

/// Twice the signed area of a triangle. Its sign is exact: positive if `a`, `b`, `c` turn left.
#[inline]
pub(super) fn orient2d(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let coord = |p: [f64; 2]| Coord { x: p[0], y: p[1] };
    // Differences are taken from the last point. Seen from `a`, errors are in proportion to the edge `ab`,
    // however short it is.
    robust::orient2d(coord(b), coord(c), coord(a))
}

/// Six times the signed volume of a tetrahedron. Its sign is exact: positive if `d` is on the side from which
/// `a`, `b`, `c` turn left.
#[inline]
pub(super) fn orient3d(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> f64 {
    let coord = |p: [f64; 3]| Coord3D { x: p[0], y: p[1], z: p[2] };
    -robust::orient3d(coord(d), coord(c), coord(b), coord(a))
}

/// The same with an accurate value too, to 1e-12 of it. Close to the plane of a needle, only the sign of the
/// other function may be right.
pub(super) fn orient3d_value(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> f64 {
    let value = orient3d(a, b, c, d);
    let [u, v, w] = [b, c, d].map(|p| sub(p, a));
    let magnitude = dot(u, u).sqrt() * dot(v, v).sqrt() * dot(w, w).sqrt();
    if value == 0.0 || value.abs() > magnitude / 1024.0 {
        return value;
    }
    let [u, v, w] = [b, c, d].map(|p| difference(p, a));
    let mut sum = Expansion::new();
    for (k, height) in w.iter().enumerate() {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let mut minor = product(&u[i], &v[j]);
        for term in product(&u[j], &v[i]) {
            grow(&mut minor, -term);
        }
        for term in product(&minor, height) {
            grow(&mut sum, term);
        }
    }
    sum.iter().sum()
}

/// A point without one of its coordinates; `axis` 0 to 2 leaves out x, y or z.
#[inline]
pub(super) fn project(p: [f64; 3], axis: usize) -> [f64; 2] {
    match axis {
        0 => [p[1], p[2]],
        1 => [p[2], p[0]],
        _ => [p[0], p[1]],
    }
}

/// Whether three points are on one line.
pub(super) fn collinear(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> bool {
    (0..3).all(|axis| orient2d(project(a, axis), project(b, axis), project(c, axis)) == 0.0)
}

/// A number with the exact sign of `(b - a) · (p - a)`: the position of `p` along the edge from `a` to `b`.
pub(super) fn along(a: [f64; 3], b: [f64; 3], p: [f64; 3]) -> f64 {
    let (u, w) = (sub(b, a), sub(p, a));
    let value = dot(u, w);
    // At most five roundings in a row: two differences, a product, two sums.
    if value.abs() > 8.0 * f64::EPSILON * dot(u.map(f64::abs), w.map(f64::abs)) {
        return value;
    }
    sign(&dot_exact(&difference(b, a), &difference(p, a)))
}

/// A number with the exact sign of `((u × v) × u) · w`, where `u = b - a`, `v = c - a`, `w = p - a`. It is
/// positive if the projection of `p` into the plane of the triangle is on the same side of the edge `ab` as
/// `c`; 0 for a triangle without area.
pub(super) fn inner_side(a: [f64; 3], b: [f64; 3], c: [f64; 3], p: [f64; 3]) -> f64 {
    // The same product without a cross product: (v·w)(u·u) - (u·w)(u·v).
    let (u, v, w) = (sub(b, a), sub(c, a), sub(p, a));
    let value = dot(v, w) * dot(u, u) - dot(u, w) * dot(u, v);
    let (u, v, w) = (u.map(f64::abs), v.map(f64::abs), w.map(f64::abs));
    // At most twelve roundings in a row: five for each of two dot products, their product, the difference.
    let magnitude = dot(v, w) * dot(u, u) + dot(u, w) * dot(u, v);
    if value.abs() > 16.0 * f64::EPSILON * magnitude {
        return value;
    }
    let (u, v, w) = (difference(b, a), difference(c, a), difference(p, a));
    let mut first = product(&dot_exact(&v, &w), &dot_exact(&u, &u));
    for term in product(&dot_exact(&u, &w), &dot_exact(&u, &v)) {
        grow(&mut first, -term);
    }
    sign(&first)
}

/// An exact number: a sum of floats that do not overlap, in ascending order of magnitude, without zeros.
type Expansion = Vec<f64>;

fn difference(a: [f64; 3], b: [f64; 3]) -> [Expansion; 3] {
    std::array::from_fn(|k| {
        let mut e = Expansion::new();
        grow(&mut e, a[k]);
        grow(&mut e, -b[k]);
        e
    })
}

fn dot_exact(a: &[Expansion; 3], b: &[Expansion; 3]) -> Expansion {
    let mut sum = Expansion::new();
    for k in 0..3 {
        for term in product(&a[k], &b[k]) {
            grow(&mut sum, term);
        }
    }
    sum
}

fn product(a: &[f64], b: &[f64]) -> Expansion {
    let mut sum = Expansion::new();
    for &x in a {
        for &y in b {
            let (high, low) = two_product(x, y);
            grow(&mut sum, low);
            grow(&mut sum, high);
        }
    }
    sum
}

/// The exact sum of the products of pairs, rounded at the end. Products must be far from the limits of `f64`.
pub(crate) fn sum_of_products(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut sum = Expansion::new();
    for (x, y) in pairs {
        let (high, low) = two_product(x, y);
        grow(&mut sum, low);
        grow(&mut sum, high);
    }
    sum.into_iter().sum()
}

/// Adds a float to an expansion.
fn grow(e: &mut Expansion, x: f64) {
    let mut carry = x;
    let mut kept = 0;
    for k in 0..e.len() {
        let (high, low) = two_sum(carry, e[k]);
        carry = high;
        if low != 0.0 {
            e[kept] = low;
            kept += 1;
        }
    }
    e.truncate(kept);
    if carry != 0.0 {
        e.push(carry);
    }
}

/// The sign is that of the largest term, which outweighs the rest.
fn sign(e: &[f64]) -> f64 {
    e.last().copied().unwrap_or(0.0)
}

fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((a1, a0), (b1, b0)) = (split(a), split(b));
    (product, a0 * b0 - (((product - a1 * b1) - a0 * b1) - a1 * b0))
}

/// Splits a float into two halves of 26 bits.
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientations_have_the_documented_sign() {
        assert!(orient2d([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]) > 0.0);
        assert!(orient3d([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]) > 0.0);
    }

    #[test]
    fn the_value_beside_a_needle_is_right() {
        let (a, b, c) = ([0.0; 3], [1.0, 3.0, 0.0], [2.0, 6.0_f64.next_up(), 0.0]);
        assert_eq!(orient3d_value(a, b, c, [5.0, 7.0, 3.0]), 3.0 * (6.0_f64.next_up() - 6.0));
        assert_eq!(orient3d_value(a, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.3, 5.0]), 5.0);
    }

    #[test]
    fn a_foot_one_step_off_an_edge_is_seen() {
        let (a, b, c) = ([0.1, 0.1, 0.1], [0.7, 0.7, 0.7], [0.0, 1.0, 0.3]);
        assert_eq!(inner_side(a, b, c, [0.3, 0.3, 0.3]), 0.0);
        // (1, 1, 1) is the direction of the edge; c is off it by (-4, 5, -1)/7 or so.
        assert!(inner_side(a, b, c, [0.3, 0.3_f64.next_up(), 0.3]) > 0.0);
        assert!(inner_side(a, b, c, [0.3, 0.3_f64.next_down(), 0.3]) < 0.0);
    }

    #[test]
    fn a_point_one_step_behind_the_end_of_an_edge_is_seen() {
        let (a, b) = ([1.0, 1.0, 1.0], [2.0, 3.0, 1.0]);
        assert_eq!(along(a, b, [3.0, 0.0, 7.0]), 0.0);
        assert!(along(a, b, [3.0, 0.0_f64.next_up(), 7.0]) >= 0.0);
        assert!(along(a, b, [3.0_f64.next_up(), 0.0, 7.0]) > 0.0);
        assert!(along(a, b, [3.0_f64.next_down(), 0.0, 7.0]) < 0.0);
    }

    #[test]
    fn products_of_the_smallest_and_the_largest_numbers_are_exact() {
        let (tiny, huge) = (MIN_MAGNITUDE, MAX_MAGNITUDE);
        let a = [0.0; 3];
        // (v·w)(u·u) - (u·w)(u·v) with u along x, and w off the edge by the smallest number.
        assert!(inner_side(a, [huge, 0.0, 0.0], [huge, huge, 0.0], [huge, tiny, 0.0]) > 0.0);
        assert!(inner_side(a, [tiny, 0.0, 0.0], [tiny, tiny, 0.0], [tiny, -tiny, 0.0]) < 0.0);
        assert_eq!(inner_side(a, [huge, 0.0, 0.0], [huge, huge, 0.0], [tiny, 0.0, huge]), 0.0);
    }
}
