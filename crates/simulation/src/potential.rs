//! The distributed potential contact force of two triangles (book, 2.4 and 2.5).
//!
//! Each triangle carries a potential φ that is 1 at its centroid, 0 on its boundary and linear between (φ = 3 min λ, with λ the area coordinates). Two triangles A and B
//! that overlap store the energy
//!
//! ```text
//! U = p ∫ (φ_A + φ_B) dA    over the overlap,
//! ```
//! and the forces are its exact gradient. With B as the target, the boundary of A inside B is pressed by `p φ_B` against its normal n (2.25); the nodes b of B take
//! the reaction, shared by `λ_b`, and, because `φ_B` moves with them, `−U_B ∇λ_b` besides. That last part sums to zero; without it, bodies whose elements
//! deform while they touch would gain or lose energy.
//!
//! `φ_B` is linear on each of the three triangles that the centroid makes of B. A is clipped by each of them, and the edges of what is left that are parts of edges
//! of A give the boundary integral.

/// A point or vector of the plane.
pub(crate) type Point = [f64; 2];
/// Corners, counter-clockwise.
pub(crate) type Triangle = [Point; 3];

/// What two triangles do to each other, for a penalty of 1 and a thickness of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Interaction {
    /// On the corners of the first and of the second.
    pub(crate) forces: [[Point; 3]; 2],
    /// The integral of the potentials over the overlap.
    pub(crate) energy: f64,
    /// The point where the force acts: the mean of the boundary in contact, weighted by its pressure.
    pub(crate) point: Point,
    /// The first reaches the centroid of the second or the reverse: the potential does not grow any deeper.
    pub(crate) deep: bool,
}

/// The forces on the corners of `a` and `b`; `None` if they do not overlap.
pub(crate) fn interaction(a: &Triangle, b: &Triangle) -> Option<Interaction> {
    if apart(a, b) || apart(b, a) {
        return None;
    }
    let mut sum = Sum::default();
    let mut result = Interaction::default();
    {
        let [first, second] = &mut result.forces;
        press(a, b, first, second, &mut sum);
        press(b, a, second, first, &mut sum);
    }
    // Triangles that touch in a point or along a line.
    if sum.energy <= 0.0 {
        return None;
    }
    result.energy = sum.energy;
    // Without a resultant there is no friction, wherever it would act.
    result.point = if sum.weight > 0.0 { sum.moment.map(|x| x / sum.weight) } else { a[0] };
    result.deep = sum.deep;
    Some(result)
}

/// All of `b` lies outside of an edge of `a`, or on it.
#[inline]
fn apart(a: &Triangle, b: &Triangle) -> bool {
    (0..3).any(|k| {
        let (from, to) = (a[k], a[(k + 1) % 3]);
        let along = minus(to, from);
        b.iter().all(|&corner| cross(along, minus(corner, from)) <= 0.0)
    })
}

#[derive(Default)]
struct Sum {
    energy: f64,
    weight: f64,
    moment: Point,
    deep: bool,
}

/// Adds what the potential of `target` does to the boundary of `contactor`, and the reaction.
fn press(
    contactor: &Triangle,
    target: &Triangle,
    on_contactor: &mut [Point; 3],
    on_target: &mut [Point; 3],
    sum: &mut Sum,
) {
    let gradients = gradients(target);
    let origin = target[0];
    let lambda = |point: Point| {
        let from = minus(point, origin);
        let (one, two) = (dot(gradients[1], from), dot(gradients[2], from));
        [1.0 - one - two, one, two]
    };
    let edges: [Point; 3] = std::array::from_fn(|k| minus(contactor[(k + 1) % 3], contactor[k]));
    let at_corners = contactor.map(lambda);
    let mut energy = 0.0;
    for k in 0..3 {
        // Where λ_k is the least: it is 0 on the edge opposite of corner k.
        let signs =
            at_corners.map(|lambda| [lambda[k], lambda[(k + 1) % 3] - lambda[k], lambda[(k + 2) % 3] - lambda[k]]);
        // All beyond one of the lines: most contacts are with one of the three alone.
        if (0..3).any(|side| signs.iter().all(|sign| sign[side] <= 0.0)) {
            continue;
        }
        let mut part = Clipped::new(contactor, signs);
        for side in 0..3 {
            part.cut(side);
        }
        let count = part.count;
        for i in 0..count {
            let (p, q) = (part.points[i], part.points[(i + 1) % count]);
            let (phi_p, phi_q) =
                (3.0 * part.signs[i][0].max(0.0), 3.0 * part.signs[(i + 1) % count][0].max(0.0));
            // The integral of a linear function over a polygon, as a fan of triangles.
            if i > 0 && i + 1 < count {
                let corner = part.points[0];
                let area = 0.5 * cross(minus(p, corner), minus(q, corner));
                energy += area * (3.0 * part.signs[0][0].max(0.0) + phi_p + phi_q) / 3.0;
            }
            let edge = part.edges[i];
            if edge == INNER {
                continue;
            }
            let (edge, along) = (usize::from(edge), edges[usize::from(edge)]);
            let squared = dot(along, along);
            let share = |point: Point| dot(minus(point, contactor[edge]), along) / squared;
            let length = dot(minus(q, p), along) / squared.sqrt();
            // ∫ φ g over the segment, for φ and g linear.
            let integral = |g: f64, h: f64| length / 6.0 * (phi_p * (2.0 * g + h) + phi_q * (g + 2.0 * h));
            let (s, t) = (share(p), share(q));
            let normal = [along[1], -along[0]].map(|x| x / squared.sqrt());
            let (at_start, at_end) = (integral(1.0 - s, 1.0 - t), integral(s, t));
            add(&mut on_contactor[edge], normal, -at_start);
            add(&mut on_contactor[(edge + 1) % 3], normal, -at_end);
            let (lambda_p, lambda_q) = (lambda(p), lambda(q));
            for corner in 0..3 {
                add(&mut on_target[corner], normal, integral(lambda_p[corner], lambda_q[corner]));
            }
            sum.weight += at_start + at_end;
            for axis in 0..2 {
                sum.moment[axis] += integral(p[axis], q[axis]);
            }
        }
    }
    for corner in 0..3 {
        add(&mut on_target[corner], gradients[corner], -energy);
    }
    sum.energy += energy;
    let centroid = std::array::from_fn(|axis| (target[0][axis] + target[1][axis] + target[2][axis]) / 3.0);
    sum.deep |= (0..3).all(|k| cross(edges[k], minus(centroid, contactor[k])) >= 0.0);
}

/// Of the area coordinates.
fn gradients(triangle: &Triangle) -> [Point; 3] {
    let [a, b, c] = *triangle;
    let double = cross(minus(b, a), minus(c, a));
    [minus(c, b), minus(a, c), minus(b, a)].map(|[x, y]| [-y / double, x / double])
}

/// An edge that a cut has made.
const INNER: u8 = 3;

/// A triangle, cut by up to three lines: at most six corners.
struct Clipped {
    points: [Point; 6],
    /// At each corner the three functions whose positive sides are kept: linear, so that they are interpolated with the points.
    signs: [[f64; 3]; 6],
    /// The edge of the triangle that follows each corner, or [`INNER`].
    edges: [u8; 6],
    count: usize,
}

impl Clipped {
    fn new(triangle: &Triangle, signs: [[f64; 3]; 3]) -> Self {
        let mut all =
            Self { points: [[0.0; 2]; 6], signs: [[0.0; 3]; 6], edges: [0, 1, 2, 0, 0, 0], count: 3 };
        all.points[..3].copy_from_slice(triangle);
        all.signs[..3].copy_from_slice(&signs);
        all
    }

    /// Keeps the side on which function `side` is not negative (Sutherland and Hodgman).
    fn cut(&mut self, side: usize) {
        if self.signs[..self.count].iter().all(|sign| sign[side] >= 0.0) {
            return;
        }
        let before = Self { ..*self };
        self.count = 0;
        for i in 0..before.count {
            let j = if i + 1 == before.count { 0 } else { i + 1 };
            let (here, there) = (before.signs[i][side], before.signs[j][side]);
            if here >= 0.0 {
                self.push(
                    before.points[i],
                    before.signs[i],
                    if there < 0.0 && here == 0.0 { INNER } else { before.edges[i] },
                );
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                let share = here / (here - there);
                let between = |a: f64, b: f64| a + share * (b - a);
                let point =
                    std::array::from_fn(|axis| between(before.points[i][axis], before.points[j][axis]));
                let mut signs: [f64; 3] =
                    std::array::from_fn(|k| between(before.signs[i][k], before.signs[j][k]));
                signs[side] = 0.0;
                self.push(point, signs, if here > 0.0 { INNER } else { before.edges[i] });
            }
        }
    }

    fn push(&mut self, point: Point, signs: [f64; 3], edge: u8) {
        // A convex polygon gains at most one corner by a cut; a sliver whose signs contradict each other by a rounding must not write beyond.
        if self.count < self.points.len() {
            self.points[self.count] = point;
            self.signs[self.count] = signs;
            self.edges[self.count] = edge;
            self.count += 1;
        }
    }
}

#[inline]
pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline]
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// By a square root, which is the same on every platform, unlike `hypot`.
#[inline]
pub(crate) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

#[inline]
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline]
fn add(to: &mut Point, direction: Point, factor: f64) {
    to[0] += direction[0] * factor;
    to[1] += direction[1] * factor;
}

/// Area coordinates of a point.
pub(crate) fn area_coordinates(triangle: &Triangle, point: Point) -> [f64; 3] {
    let g = gradients(triangle);
    let from = minus(point, triangle[0]);
    let (one, two) = (dot(g[1], from), dot(g[2], from));
    [1.0 - one - two, one, two]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of triangles that overlap in many ways, from a fixed sequence.
    fn pairs() -> impl Iterator<Item = (Triangle, Triangle)> {
        let mut state = 12345_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        std::iter::repeat_with(move || {
            let mut triangle = |shift: f64| -> Triangle {
                loop {
                    let t: Triangle = std::array::from_fn(|_| [random() * 2.0 + shift, random() * 2.0]);
                    if cross(minus(t[1], t[0]), minus(t[2], t[0])) > 0.3 {
                        return t;
                    }
                }
            };
            (triangle(0.0), triangle(0.7))
        })
        .take(2000)
    }

    #[test]
    fn forces_are_the_gradient_of_the_energy() {
        let mut overlapping = 0;
        for (a, b) in pairs() {
            let Some(found) = interaction(&a, &b) else { continue };
            overlapping += 1;
            for side in 0..2 {
                for corner in 0..3 {
                    for axis in 0..2 {
                        let h = 1e-6;
                        let energy = |sign: f64| {
                            let mut moved = [a, b];
                            moved[side][corner][axis] += sign * h;
                            interaction(&moved[0], &moved[1]).map_or(0.0, |i| i.energy)
                        };
                        let slope = (energy(1.0) - energy(-1.0)) / (2.0 * h);
                        let force = found.forces[side][corner][axis];
                        assert!(
                            (force + slope).abs() < 2e-5,
                            "{a:?} {b:?}: {side} {corner} {axis}: {force} {slope}"
                        );
                    }
                }
            }
        }
        assert!(overlapping > 1000, "{overlapping}");
    }

    #[test]
    fn momentum_is_kept_to_rounding() {
        for (a, b) in pairs() {
            let Some(found) = interaction(&a, &b) else { continue };
            let (mut force, mut torque) = ([0.0; 2], 0.0);
            for (corners, forces) in [a, b].iter().zip(&found.forces) {
                for (corner, f) in corners.iter().zip(forces) {
                    force = [force[0] + f[0], force[1] + f[1]];
                    torque += cross(*corner, *f);
                }
            }
            assert!(force[0].abs() + force[1].abs() + torque.abs() < 1e-13, "{force:?} {torque}");
        }
    }

    #[test]
    fn triangles_that_touch_do_nothing() {
        let a = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(interaction(&a, &[[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]), None);
        assert_eq!(interaction(&a, &[[0.0, 0.0], [0.0, -1.0], [1.0, 0.0]]), None);
        assert_eq!(interaction(&a, &[[5.0, 0.0], [6.0, 0.0], [5.0, 1.0]]), None);
    }

    #[test]
    fn an_edge_pressed_flat_into_an_edge() {
        // A square's lower triangle dips by d into the edge of another: pressure 3 d/H on most of the edge.
        let d = 1e-6;
        let below = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]].map(|[x, y]: Point| [x, -y]);
        let below = [below[0], below[2], below[1]];
        let above = [[0.0, -d], [1.0, -d], [0.5, 1.0 - d]];
        let found = interaction(&above, &below).unwrap_or_default();
        let up = found.forces[0].iter().map(|f| f[1]).sum::<f64>();
        // Both potentials press, each with 3 d on a length of 1.
        assert!((up / (6.0 * d) - 1.0).abs() < 1e-4, "{up}");
        assert!((found.point[0] - 0.5).abs() < 1e-9 && !found.deep);
        assert!((found.energy / (3.0 * d * d) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_same_triangle_twice_is_deep() {
        let a = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let found = interaction(&a, &a).unwrap_or_default();
        assert!(found.deep);
        // ∫ φ over a triangle is a third of its area.
        assert!((found.energy - 2.0 * 0.5 / 3.0).abs() < 1e-14);
    }
}
