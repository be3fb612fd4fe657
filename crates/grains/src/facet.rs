//! The points of triangles and segments that are closest to a centre.
//!
//! All functions give the same bits for every order of the corners: they begin with the corner that has the
//! least coordinates. So a point on an edge has the same distance seen from both of its facets.

use std::cmp::Ordering;

use crate::vector::{Vector, cross, dot, length, minus, plus, times};

/// The point of a facet or of a ridge that is closest to a centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Closest {
    /// m.
    pub(crate) distance: f64,
    /// From the point to the centre, of unit length.
    pub(crate) normal: Vector,
    /// m.
    pub(crate) place: Vector,
    /// Corners between which the point lies, and their shares in it. Corners that repeat have no share.
    pub(crate) corners: [u32; 3],
    pub(crate) weights: [f64; 3],
}

/// Order of two points, by their first coordinate that differs.
pub(crate) fn by_place(a: Vector, b: Vector) -> Ordering {
    let along = |axis: usize| a[axis].total_cmp(&b[axis]);
    along(0).then_with(|| along(1)).then_with(|| along(2))
}

impl Closest {
    fn at(centre: Vector, place: Vector, corners: [u32; 3], weights: [f64; 3]) -> Self {
        let apart = minus(centre, place);
        let distance = length(apart);
        // A centre on the surface has no direction from there: any will do.
        let normal = if distance > 0.0 { times(1.0 / distance, apart) } else { [1.0, 0.0, 0.0] };
        Self { distance, normal, place, corners, weights }
    }

    /// Order by distance, then by place.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then_with(|| by_place(self.place, other.place))
    }

    /// A quantity of the corners at the point.
    #[inline]
    pub(crate) fn mean(&self, of: impl Fn(u32) -> Vector) -> Vector {
        let [a, b, c] = std::array::from_fn(|k| times(self.weights[k], of(self.corners[k])));
        plus(plus(a, b), c)
    }
}

/// The closest point of a segment, or of a point that is given twice.
pub(crate) fn of_segment(centre: Vector, ends: [u32; 2], points: &[Vector]) -> Closest {
    let [mut p, mut q] = ends;
    if by_place(points[q as usize], points[p as usize]).is_lt() {
        (p, q) = (q, p);
    }
    let [a, b] = [points[p as usize], points[q as usize]];
    let along = minus(b, a);
    let square = dot(along, along);
    let share = dot(minus(centre, a), along);
    if share <= 0.0 || square == 0.0 {
        Closest::at(centre, a, [p; 3], [1.0, 0.0, 0.0])
    } else if share >= square {
        Closest::at(centre, b, [q; 3], [1.0, 0.0, 0.0])
    } else {
        let share = share / square;
        Closest::at(centre, plus(a, times(share, along)), [p, q, q], [1.0 - share, share, 0.0])
    }
}

/// The closest point of a facet, and whether the centre is on its outer side.
pub(crate) fn of_facet(centre: Vector, facet: [u32; 3], points: &[Vector]) -> (Closest, bool) {
    if facet[1] == facet[2] {
        let [a, b] = [facet[0], facet[1]].map(|p| points[p as usize]);
        let (along, out) = (minus(b, a), minus(centre, a));
        let is_outside = out[0] * along[1] - out[1] * along[0] > 0.0;
        return (of_segment(centre, [facet[0], facet[1]], points), is_outside);
    }
    let (corners, is_turned) = sorted(facet, points);
    let [a, b, c] = corners.map(|p| points[p as usize]);
    let normal = cross(minus(b, a), minus(c, a));
    let square = dot(normal, normal);
    let height = dot(normal, minus(centre, a));
    let is_outside = if is_turned { height < 0.0 } else { height > 0.0 };
    let share = |from: Vector, to: Vector| dot(cross(minus(to, from), minus(centre, from)), normal) / square;
    let weights = [share(b, c), share(c, a), share(a, b)];
    // Comparisons with the shares of a facet without area are false.
    if weights.iter().all(|&weight| weight > 0.0) {
        let size = square.sqrt();
        let distance = height / size;
        let (distance, sign) = if distance < 0.0 { (-distance, -1.0) } else { (distance, 1.0) };
        let normal = times(sign / size, normal);
        let place = minus(centre, times(distance, normal));
        return (Closest { distance, normal, place, corners, weights }, is_outside);
    }
    let [p, q, r] = corners;
    let edges = [[p, q], [q, r], [p, r]].map(|edge| of_segment(centre, edge, points));
    let nearer = |a: Closest, b: Closest| if b.order(&a).is_lt() { b } else { a };
    (nearer(nearer(edges[0], edges[1]), edges[2]), is_outside)
}

/// The corners in the order of their coordinates, and whether they then go round the other way.
fn sorted(facet: [u32; 3], points: &[Vector]) -> ([u32; 3], bool) {
    let ([mut a, mut b, mut c], mut is_turned) = (facet, false);
    let is_less = |p: u32, q: u32| by_place(points[p as usize], points[q as usize]).is_lt();
    if is_less(b, a) {
        (a, b, is_turned) = (b, a, !is_turned);
    }
    if is_less(c, b) {
        (b, c, is_turned) = (c, b, !is_turned);
    }
    if is_less(b, a) {
        (a, b, is_turned) = (b, a, !is_turned);
    }
    ([a, b, c], is_turned)
}

/// Sum of the corners of a facet, the same for every order of them.
pub(crate) fn sum_of_corners(facet: [u32; 3], points: &[Vector]) -> Vector {
    let (corners, _) = sorted(facet, points);
    let [a, b, c] = corners.map(|p| points[p as usize]);
    plus(plus(a, b), c)
}

/// The rotation of a facet: tensor that makes moments of angular velocities, for its corners with unit mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetRotation {
    corners: [u32; 3],
    count: usize,
    /// From the middle to each corner, m.
    arms: [Vector; 3],
    /// Inverse of the sum of `arm² - arm arm`, 1/m².
    inverse: [Vector; 3],
}

impl FacetRotation {
    pub(crate) fn new(facet: [u32; 3], points: &[Vector]) -> Self {
        let count = if facet[1] == facet[2] { 2 } else { 3 };
        let corners = if count == 2 { facet } else { sorted(facet, points).0 };
        let mut middle = [0.0; 3];
        for &corner in &corners[..count] {
            middle = plus(middle, times(1.0 / count as f64, points[corner as usize]));
        }
        let arms = corners.map(|corner| minus(points[corner as usize], middle));
        let mut tensor = [[0.0; 3]; 3];
        for arm in &arms[..count] {
            for i in 0..3 {
                for j in 0..3 {
                    tensor[i][j] += if i == j { dot(*arm, *arm) } else { 0.0 } - arm[i] * arm[j];
                }
            }
        }
        if count == 2 {
            // A segment does not turn about itself, and turns in the plane only.
            let turning = tensor[2][2];
            tensor = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, turning]];
        }
        Self { corners, count, arms, inverse: inverse(&tensor) }
    }

    /// Angular velocity, rad/s, from the velocities of the points, m/s.
    pub(crate) fn spin(&self, velocities: &[Vector]) -> Vector {
        let mut sum = [0.0; 3];
        for k in 0..self.count {
            sum = plus(sum, cross(self.arms[k], velocities[self.corners[k] as usize]));
        }
        self.inverse.map(|row| dot(row, sum))
    }

    /// Forces on corners, N, that make a moment, N m, and no force.
    pub(crate) fn forces(&self, moment: Vector) -> impl Iterator<Item = (u32, Vector)> {
        let turning = self.inverse.map(|row| dot(row, moment));
        let Self { corners, count, arms, .. } = *self;
        (0..count).map(move |k| (corners[k], cross(turning, arms[k])))
    }
}

/// The inverse of a symmetric tensor; 0 for one without inverse.
fn inverse(of: &[Vector; 3]) -> [Vector; 3] {
    let rows = [cross(of[1], of[2]), cross(of[2], of[0]), cross(of[0], of[1])];
    let size = dot(of[0], rows[0]);
    if size > 0.0 { rows.map(|row| times(1.0 / size, row)) } else { [[0.0; 3]; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers from -1 to 1.
    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn place(seed: &mut u64) -> Vector {
        [random(seed), random(seed), random(seed)]
    }

    /// The closest of many points of the facet is not closer, and one of them is almost as close.
    #[test]
    fn the_closest_point_is_that_of_a_fine_grid() {
        let mut seed = 1;
        for _ in 0..200 {
            let points: Vec<Vector> = (0..3).map(|_| place(&mut seed)).collect();
            let centre = times(2.0, place(&mut seed));
            let (found, _) = of_facet(centre, [0, 1, 2], &points);
            let mut least = f64::INFINITY;
            for i in 0..=100 {
                for j in 0..=100 - i {
                    let [u, v] = [i, j].map(|k| f64::from(k) / 100.0);
                    let at =
                        plus(plus(times(u, points[0]), times(v, points[1])), times(1.0 - u - v, points[2]));
                    least = least.min(length(minus(centre, at)));
                }
            }
            assert!(least >= found.distance - 1e-14 && least < found.distance + 0.03);
            let mean = found.mean(|p| points[p as usize]);
            assert!(length(minus(mean, found.place)) < 1e-12);
            let back = plus(found.place, times(found.distance, found.normal));
            assert!(length(minus(back, centre)) < 1e-12);
        }
    }

    #[test]
    fn the_order_of_corners_changes_no_bit() {
        let mut seed = 7;
        for _ in 0..200 {
            let points: Vec<Vector> = (0..3).map(|_| place(&mut seed)).collect();
            let centre = place(&mut seed);
            let (first, is_outside) = of_facet(centre, [0, 1, 2], &points);
            for (facet, is_turned) in [([1, 2, 0], false), ([2, 0, 1], false), ([2, 1, 0], true)] {
                let (found, side) = of_facet(centre, facet, &points);
                assert_eq!(found, first);
                assert_eq!(side, is_outside != is_turned);
            }
        }
    }

    #[test]
    fn a_facet_turns_with_its_corners() {
        let mut seed = 3;
        let points: Vec<Vector> = (0..3).map(|_| place(&mut seed)).collect();
        let [spin, moment, drift] = [place(&mut seed), place(&mut seed), place(&mut seed)];
        let velocities: Vec<Vector> = points.iter().map(|&p| plus(drift, cross(spin, p))).collect();
        let rotation = FacetRotation::new([0, 1, 2], &points);
        assert!(length(minus(rotation.spin(&velocities), spin)) < 1e-12);
        let (mut force, mut total) = ([0.0; 3], [0.0; 3]);
        for (corner, push) in rotation.forces(moment) {
            force = plus(force, push);
            total = plus(total, cross(points[corner as usize], push));
        }
        assert!(length(force) < 1e-12 && length(minus(total, moment)) < 1e-12);
    }

    #[test]
    fn the_outer_side_of_a_segment_is_on_its_right() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0]];
        assert!(of_facet([0.5, -1.0, 0.0], [0, 1, 1], &points).1);
        assert!(!of_facet([0.5, 1.0, 0.0], [0, 1, 1], &points).1);
    }
}
