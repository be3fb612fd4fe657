//! The distributed potential contact force of two triangles (book, 2.4 and 2.5).
//!
//! Each triangle carries a potential φ that is 1 at its centroid, 0 on its boundary and linear in between (φ = 3 min λ, with λ the area coordinates). Two
//! triangles A and B that overlap store the energy
//!
//! ```text
//! U = p ∫ (φ_A + φ_B) dA    over the overlap,
//! ```
//! and the forces are the exact gradient of this energy. With B as the target, a pressure `p φ_B` acts on the boundary of A inside B, against its normal n
//! (2.25). The nodes b of B take the reaction in the shares `λ_b`. They also take the forces `−U_B ∇λ_b`, because `φ_B` moves with them. These forces sum to
//! zero, but without them, bodies whose elements deform while they touch would gain or lose energy.
//!
//! Everything follows from φ along the edges of A alone, where φ is linear between a few points. This includes the integral over the overlap. Let c be the
//! centroid of B, and let `w = 1 − φ` be the distance from c over the distance of the boundary of B in the same direction. The field `(x − c) h` with
//! `h = 1/2 − w/3 + C/w²` has the divergence φ for any C. With C = −1/6 the field vanishes on the boundary of B, and its flux out of the edges of A is the
//! integral, less a third of the area of B if c is in A. Without cancellation, `h = −φ² (3 − 2 φ)/(6 w²)` there. Near c the flux is nearly 0/0. If an edge of A
//! passes near c, C = 0 is used instead, and the flux out of the edges of B inside A, where h = 1/6, is added.

use crate::simplex::triangle::Triangle;
use crate::simplex::{Interaction, NEAR, Sum};
use crate::vector::{Point, add, cross, dot, length, minus};

/// Computes the interaction of two triangles. If they do not overlap, returns a lower bound of their distance.
pub(super) fn interaction(a: &Triangle, b: &Triangle) -> Result<Interaction, f64> {
    let coordinates = [Coordinates::of(a), Coordinates::of(b)];
    let in_b = a.map(|corner| coordinates[1].at(corner));
    coordinates[1].beyond(&in_b)?;
    let in_a = b.map(|corner| coordinates[0].at(corner));
    coordinates[0].beyond(&in_a)?;
    let chords = [chords(&in_b), chords(&in_a)];
    let mut result = Interaction::default();
    let [first, second] = &mut result.forces;
    let mut sum = Sum::default();
    press(a, b, &coordinates[1], [&chords[0], &chords[1]], [first, second], &mut sum);
    press(b, a, &coordinates[0], [&chords[1], &chords[0]], [second, first], &mut sum);
    // The triangles touch only in a point or along a line.
    if sum.energy <= 0.0 {
        return Err(0.0);
    }
    Ok(sum.completed(result, a[0]))
}

/// Adds the forces of the potential of `target` on the boundary of `contactor`, and their reaction. `chords`: those of the edges of the contactor in the
/// target, and the reverse.
fn press(
    contactor: &Triangle,
    target: &Triangle,
    coordinates: &Coordinates,
    chords: [&[Chord; 3]; 2],
    [on_contactor, on_target]: [&mut [Point; 3]; 2],
    sum: &mut Sum<2>,
) {
    let centroid: Point =
        std::array::from_fn(|axis| (target[0][axis] + target[1][axis] + target[2][axis]) / 3.0);
    let area = 0.5 * coordinates.double;
    let (mut outside, mut near, mut inside) = (0.0, 0.0, true);
    let mut passes_near = false;
    for (k, chord) in chords[0].iter().enumerate() {
        let next = (k + 1) % 3;
        let along = minus(contactor[next], contactor[k]);
        // The normal has the length of the edge.
        let normal = [along[1], -along[0]];
        let beyond = dot(minus(contactor[k], centroid), normal);
        inside &= beyond >= 0.0;
        let pressure = chord.at_start + chord.at_end;
        if pressure == 0.0 {
            continue;
        }
        outside += beyond * chord.outside;
        near += beyond * chord.near;
        passes_near |= chord.least < NEAR;
        add(&mut on_contactor[k], normal, -chord.at_start);
        add(&mut on_contactor[next], normal, -chord.at_end);
        let [start, end] = [k, next].map(|corner| coordinates.at(contactor[corner]));
        for corner in 0..3 {
            add(&mut on_target[corner], normal, start[corner] * chord.at_start + end[corner] * chord.at_end);
        }
        let long = length(normal);
        sum.weight += long * pressure;
        for axis in 0..2 {
            let moment = contactor[k][axis] * chord.at_start + contactor[next][axis] * chord.at_end;
            sum.moment[axis] += long * moment;
        }
    }
    let energy = if passes_near {
        near + area / 9.0 * chords[1].iter().map(|chord| chord.long).sum::<f64>()
    } else if inside {
        outside + area / 3.0
    } else {
        outside
    };
    for corner in 0..3 {
        add(&mut on_target[corner], coordinates.gradients[corner], -energy);
    }
    sum.energy += energy;
    sum.deep |= inside;
}

/// Area coordinates of a triangle.
pub(super) struct Coordinates {
    origin: Point,
    gradients: [Point; 3],
    /// Twice the area.
    double: f64,
}

impl Coordinates {
    #[inline]
    pub(super) fn of(triangle: &Triangle) -> Self {
        let [a, b, c] = *triangle;
        let double = cross(minus(b, a), minus(c, a));
        let per_double = 1.0 / double;
        let gradient = |[x, y]: Point| [-y * per_double, x * per_double];
        let gradients = [gradient(minus(c, b)), gradient(minus(a, c)), gradient(minus(b, a))];
        Self { origin: a, gradients, double }
    }

    #[inline]
    pub(super) fn at(&self, point: Point) -> [f64; 3] {
        let from = minus(point, self.origin);
        let (one, two) = (dot(self.gradients[1], from), dot(self.gradients[2], from));
        [1.0 - one - two, one, two]
    }

    /// Returns `Err` if corners with these coordinates are all on or beyond one of the edges; the value is a lower bound of their distance.
    #[inline]
    fn beyond(&self, corners: &[[f64; 3]; 3]) -> Result<(), f64> {
        let mut distance = None;
        for k in 0..3 {
            let most = corners[0][k].max(corners[1][k]).max(corners[2][k]);
            if most <= 0.0 {
                // The length of the gradient is one over the height.
                let beyond = -most / length(self.gradients[k]);
                distance = Some(distance.map_or(beyond, |other: f64| other.max(beyond)));
            }
        }
        distance.map_or(Ok(()), Err)
    }
}

/// The part of an edge that lies in another triangle, with integrals over this part. The length of the edge counts as 1.
#[derive(Clone, Copy, Default)]
struct Chord {
    /// Length of the part.
    long: f64,
    /// ∫ φ (1 − s) and ∫ φ s.
    at_start: f64,
    at_end: f64,
    /// ∫ h with C = −1/6, and with C = 0.
    outside: f64,
    near: f64,
    /// Smallest w on the part.
    least: f64,
}

/// Chords of the three edges of a triangle whose corners have these area coordinates in the other triangle.
#[inline]
fn chords(corners: &[[f64; 3]; 3]) -> [Chord; 3] {
    [0, 1, 2].map(|k| chord(&corners[k], &corners[(k + 1) % 3]))
}

/// Chord of an edge whose ends have these area coordinates in the other triangle.
#[inline]
fn chord(start: &[f64; 3], end: &[f64; 3]) -> Chord {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let (x, y) = (start[k], end[k]);
        if x < 0.0 && y < 0.0 {
            return Chord::default();
        }
        if x < 0.0 {
            from = from.max(x / (x - y));
        } else if y < 0.0 {
            to = to.min(x / (x - y));
        }
    }
    if from >= to {
        return Chord::default();
    }
    // Ends of the pieces on which one coordinate is the smallest: two coordinates are equal there.
    let (mut cuts, mut count) = ([from, to, to, to, to], 1);
    for (k, l) in [(0, 1), (1, 2), (2, 0)] {
        let (x, y) = (start[k] - start[l], end[k] - end[l]);
        if (x < 0.0 && y > 0.0) || (x > 0.0 && y < 0.0) {
            let cut = x / (x - y);
            if cut > from && cut < to {
                let mut place = count;
                while cuts[place - 1] > cut {
                    cuts[place] = cuts[place - 1];
                    place -= 1;
                }
                cuts[place] = cut;
                count += 1;
            }
        }
    }
    cuts[count] = to;
    let potential = |s: f64| {
        let at = |k: usize| start[k] + s * (end[k] - start[k]);
        3.0 * at(0).min(at(1)).min(at(2)).max(0.0)
    };
    let mut chord = Chord { long: to - from, least: 1.0, ..Chord::default() };
    let (mut s, mut a) = (from, potential(from));
    for &t in &cuts[1..=count] {
        let (b, long) = (potential(t), t - s);
        let (v, w) = (1.0 - a, 1.0 - b);
        chord.at_start += long / 6.0 * (a * (3.0 - 2.0 * s - t) + b * (3.0 - s - 2.0 * t));
        chord.at_end += long / 6.0 * (a * (2.0 * s + t) + b * (s + 2.0 * t));
        // Integral of -φ² (3 - 2 φ)/(6 w²), with φ from a to b.
        chord.outside -= long * (a * a + a * b + b * b - a * b * (a + b)) / (6.0 * v * w);
        chord.near += long * (0.5 - (v + w) / 6.0);
        chord.least = chord.least.min(v).min(w);
        (s, a) = (t, b);
    }
    chord
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of triangles that overlap in many ways, from a fixed pseudo-random sequence.
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
            let Ok(found) = interaction(&a, &b) else { continue };
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

    /// Integral of the potential of `target` over the part that `contactor` covers, summed over many small triangles.
    fn summed(contactor: &Triangle, target: &Triangle) -> f64 {
        let (n, mut sum) = (120_u32, 0.0);
        let coordinates = Coordinates::of(contactor);
        for i in 0..n {
            for j in 0..n - i {
                for (share, last) in [(1.0 / 3.0, n - i), (2.0 / 3.0, n - i - 1)] {
                    if j >= last {
                        continue;
                    }
                    let lambda = [i, j].map(|step| (f64::from(step) + share) / f64::from(n));
                    let lambda = [lambda[0], lambda[1], 1.0 - lambda[0] - lambda[1]];
                    let point = std::array::from_fn(|axis| (0..3).map(|k| lambda[k] * target[k][axis]).sum());
                    if coordinates.at(point).iter().all(|&own| own >= 0.0) {
                        sum += 3.0 * lambda[0].min(lambda[1]).min(lambda[2]);
                    }
                }
            }
        }
        0.5 * Coordinates::of(target).double * sum / f64::from(n * n)
    }

    #[test]
    fn the_energy_is_the_integral_over_the_overlap() {
        let mut deep = 0;
        for (a, b) in pairs().take(300) {
            let found = interaction(&a, &b).map_or(0.0, |found| found.energy);
            let expected = summed(&a, &b) + summed(&b, &a);
            assert!((found - expected).abs() < 3e-3, "{a:?} {b:?}: {found} {expected}");
            deep += usize::from(interaction(&a, &b).is_ok_and(|found| found.deep));
        }
        assert!(deep > 30, "{deep}");
    }

    /// Both forms of the integral agree where both are accurate. The form for edges near the centroid is continuous where an edge goes through the centroid.
    #[test]
    fn an_edge_through_the_centroid_is_as_one_that_passes_near() {
        let target = [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]];
        let contactor = |x: f64| [[x, -5.0], [x + 9.0, 0.3], [x, 5.0]];
        let energy = |x: f64| interaction(&contactor(x), &target).map_or(f64::NAN, |found| found.energy);
        let through = energy(1.0);
        for shift in [1e-12, 1e-9, 1e-6] {
            for sign in [-1.0, 1.0] {
                let passing = energy(1.0 + sign * shift);
                assert!((passing - through).abs() < 3.0 * shift + 1e-14, "{shift}: {passing} {through}");
            }
        }
        // On both sides of the limit between the two forms, where the smallest w on the edge is 0.1.
        let (one, other) = (energy(0.9 - 1e-9), energy(0.9 + 1e-9));
        assert!((one - other).abs() < 1e-8, "{one} {other}");
    }

    #[test]
    fn momentum_is_kept_to_rounding() {
        for (a, b) in pairs() {
            let Ok(found) = interaction(&a, &b) else { continue };
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
        assert_eq!(interaction(&a, &[[1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]), Err(0.0));
        assert_eq!(interaction(&a, &[[0.0, 0.0], [0.0, -1.0], [1.0, 0.0]]), Err(0.0));
        assert_eq!(interaction(&a, &[[5.0, 0.0], [6.0, 0.0], [5.0, 1.0]]), Err(4.0));
    }

    #[test]
    fn an_edge_pressed_flat_into_an_edge() {
        // A triangle dips by d into the edge of another: the pressure is 3 d/H on most of the edge.
        let d = 1e-6;
        let below = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]].map(|[x, y]: Point| [x, -y]);
        let below = [below[0], below[2], below[1]];
        let above = [[0.0, -d], [1.0, -d], [0.5, 1.0 - d]];
        let found = interaction(&above, &below).unwrap_or_default();
        let up = found.forces[0].iter().map(|f| f[1]).sum::<f64>();
        // Both potentials press, each with 3 d over a length of 1.
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
