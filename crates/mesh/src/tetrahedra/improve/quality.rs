//! How good a tetrahedron is.

use crate::tetrahedra::vector::{Point, cross, dot, minus};

/// The smallest sine of the six angles between facets; negative if the volume is not positive.
///
/// With the double areas `N` of the facets and six times the volume `V`, the sine at an edge of length `l`
/// between facets `i` and `j` is `V l / (N_i N_j)`.
#[inline]
pub(crate) fn quality(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let (ab, ac, ad) = (minus(b, a), minus(c, a), minus(d, a));
    let (bc, bd, cd) = (minus(c, b), minus(d, b), minus(d, c));
    let (abc, abd, acd, bcd) = (cross(ab, ac), cross(ab, ad), cross(ac, ad), cross(bc, bd));
    let volume = dot(abc, ad);
    let [abc, abd, acd, bcd] = [abc, abd, acd, bcd].map(|n| dot(n, n));
    let pairs = [
        dot(ab, ab) * (acd * bcd),
        dot(ac, ac) * (abd * bcd),
        dot(ad, ad) * (abc * bcd),
        dot(bc, bc) * (abd * acd),
        dot(bd, bd) * (abc * acd),
        dot(cd, cd) * (abc * abd),
    ];
    let least = pairs.into_iter().fold(f64::INFINITY, f64::min);
    let all = (abc * abd) * (acd * bcd);
    if volume > 0.0 && all > 0.0 { volume * (least / all).sqrt() } else { volume.min(0.0) - 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_and_a_right_tetrahedron_have_known_angles() {
        let even = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let [a, b, c, d] = even;
        let sine = (8.0_f64 / 9.0).sqrt();
        assert!((quality(a, c, b, d) - sine).abs() < 1e-12 || (quality(a, b, c, d) - sine).abs() < 1e-12);
        // The angles of the corner of a cube are 90° and acos(1/√3).
        let corner = quality([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert!((corner - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!(quality([0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]) < 0.0);
        assert!(quality([0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]) < 0.0);
    }
}
