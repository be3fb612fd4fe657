//! On which side of a plane, and of a sphere, a point is: exactly.
//!
//! Both are first computed in plain arithmetic. Only where the result is smaller than its error can be, exact
//! arithmetic decides.
//!
//! # Source
//! J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
//! Discrete Comput. Geom. 18 (1997), for the bounds of the errors: here they are taken with the largest
//! differences of coordinates instead of the exact sum of products, which is larger and cheaper.

use robust::Coord3D;

use super::vector::Point;

/// Bound of the error of [`side`], over the product of the largest differences along the axes: Shewchuk's
/// (7 + 56 ε) ε, times 6 products, and a little more.
const SIDE: f64 = 6.0 * 7.9e-16;

/// Bound of the error of [`within`], over the product of the largest differences and the largest square:
/// (16 + 224 ε) ε, times 4 · 6 products times 3 squares, and a little more.
const WITHIN: f64 = 72.0 * 1.8e-15;

fn exact(point: Point) -> Coord3D<f64> {
    Coord3D { x: point[0], y: point[1], z: point[2] }
}

#[inline]
fn largest(a: f64, b: f64, c: f64) -> f64 {
    a.abs().max(b.abs()).max(c.abs())
}

/// Six times the volume of a tetrahedron: positive if the first three corners are counter-clockwise seen from
/// the last, 0 if all are in a plane. The sign is exact.
#[inline]
pub(crate) fn side(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let [ax, ay, az] = [a[0] - d[0], a[1] - d[1], a[2] - d[2]];
    let [bx, by, bz] = [b[0] - d[0], b[1] - d[1], b[2] - d[2]];
    let [cx, cy, cz] = [c[0] - d[0], c[1] - d[1], c[2] - d[2]];
    let determinant = ax * (cy * bz - by * cz) + bx * (ay * cz - cy * az) + cx * (by * az - ay * bz);
    let bound = SIDE * largest(ax, bx, cx) * largest(ay, by, cy) * largest(az, bz, cz);
    if determinant > bound || -determinant > bound {
        return determinant;
    }
    -robust::orient3d(exact(a), exact(b), exact(c), exact(d))
}

/// Positive if `e` is inside the sphere around the tetrahedron `abcd` of positive volume, negative if it is
/// outside, 0 if it is on the sphere. The sign is exact.
#[inline]
pub(crate) fn within(a: Point, b: Point, c: Point, d: Point, e: Point) -> f64 {
    let [ax, ay, az] = [a[0] - e[0], a[1] - e[1], a[2] - e[2]];
    let [bx, by, bz] = [b[0] - e[0], b[1] - e[1], b[2] - e[2]];
    let [cx, cy, cz] = [c[0] - e[0], c[1] - e[1], c[2] - e[2]];
    let [dx, dy, dz] = [d[0] - e[0], d[1] - e[1], d[2] - e[2]];
    let (ab, bc, cd, da) = (ax * by - bx * ay, bx * cy - cx * by, cx * dy - dx * cy, dx * ay - ax * dy);
    let (ac, bd) = (ax * cy - cx * ay, bx * dy - dx * by);
    let abc = az * bc - bz * ac + cz * ab;
    let bcd = bz * cd - cz * bd + dz * bc;
    let cda = cz * da + dz * ac + az * cd;
    let dab = dz * ab + az * bd + bz * da;
    let (aa, bb) = (ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz);
    let (cc, dd) = (cx * cx + cy * cy + cz * cz, dx * dx + dy * dy + dz * dz);
    let determinant = (cc * dab - dd * abc) + (aa * bcd - bb * cda);
    let [x, y, z] = [
        largest(ax, bx, cx).max(dx.abs()),
        largest(ay, by, cy).max(dy.abs()),
        largest(az, bz, cz).max(dz.abs()),
    ];
    let most = x.max(y).max(z);
    let bound = WITHIN * x * y * z * most * most;
    if determinant > bound || -determinant > bound {
        return determinant;
    }
    -robust::insphere(exact(a), exact(b), exact(c), exact(d), exact(e))
}

#[cfg(test)]
mod tests {
    use fdem_scenes::random::Random;

    use super::*;

    const UNIT: [Point; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn signs_are_as_said() {
        let [a, b, c, d] = UNIT;
        assert!(side(a, b, c, d) > 0.0);
        assert!(side(a, c, b, d) < 0.0);
        assert_eq!(side(a, b, c, [0.3, 0.7, 0.0]), 0.0);
        assert!(within(a, b, c, d, [0.9, 0.9, 0.9]) > 0.0);
        assert!(within(a, b, c, d, [1.1, 1.1, 1.1]) < 0.0);
        assert_eq!(within(a, b, c, d, [1.0, 1.0, 1.0]), 0.0);
    }

    #[test]
    fn signs_equal_those_of_exact_arithmetic() {
        let mut random = Random::new(1);
        let mut point = || [(); 3].map(|()| random.below(8) as f64 / 8.0 + random.below(3) as f64 * 1e-16);
        for _ in 0..20_000 {
            let [a, b, c, d, e] = [(); 5].map(|()| point());
            let volume = -robust::orient3d(exact(a), exact(b), exact(c), exact(d));
            assert_eq!(side(a, b, c, d) > 0.0, volume > 0.0);
            assert_eq!(side(a, b, c, d) == 0.0, volume == 0.0);
            let inside = -robust::insphere(exact(a), exact(b), exact(c), exact(d), exact(e));
            assert_eq!(within(a, b, c, d, e) > 0.0, inside > 0.0);
            assert_eq!(within(a, b, c, d, e) == 0.0, inside == 0.0);
        }
    }
}
