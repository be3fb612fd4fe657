//! The distributed potential contact force of two triangles (book, 2.4 and 2.5).
//!
//! Each triangle carries a potential φ that is 1 at its centroid, 0 on its boundary and linear in between
//! (φ = 3 min λ, with λ the area coordinates). Two triangles A and B that overlap store the energy
//!
//! ```text
//! U = p ∫ (φ_A + φ_B) dA    over the overlap,
//! ```
//! and the forces are the exact gradient of this energy. With B as the target, a pressure `p φ_B` acts on the
//! boundary of A inside B, against its normal n (2.25). The nodes b of B take the reaction in the shares
//! `λ_b`. They also take the forces `−U_B ∇λ_b`, because `φ_B` moves with them. These forces sum to zero, but
//! without them, bodies whose elements deform while they touch would gain or lose energy.
//!
//! Everything follows from φ along the edges of A alone, where φ is linear between a few points. This
//! includes the integral over the overlap. Let c be the centroid of B, and let `w = 1 − φ` be the distance
//! from c over the distance of the boundary of B in the same direction. The field `(x − c) h` with
//! `h = 1/2 − w/3 + C/w²` has the divergence φ for any C. With C = −1/6 the field vanishes on the boundary of
//! B, and its flux out of the edges of A is the integral, less a third of the area of B if c is in A. Without
//! cancellation, `h = −φ² (3 − 2 φ)/(6 w²)` there. Near c the flux is nearly 0/0: see `interactions.rs`.
//!
//! Couples are computed in batches, without a branch that depends on one of them: see `lanes.rs`. Twin:
//! `crates/gpu/kernels/contact.h`.

#![allow(
    clippy::needless_bitwise_bool,
    reason = "a lazy operator is a branch, of which the compiler makes no vectors"
)]

use crate::lanes::{
    Available, LANES, Lanes, Rows, compiled_for_vectors, larger, row, rows, set_row, set_rows, smaller,
};
use crate::simplex::{Interactions, NEAR, Shapes, Triangle, furthest, points};
use crate::vector::{Point, cross, dot, minus};

const THIRD: f64 = 1.0 / 3.0;
const SIXTH: f64 = 1.0 / 6.0;

/// [`Simplex::usual_interactions`](crate::simplex::Simplex::usual_interactions).
pub(super) fn usual_interactions(
    available: Available,
    shapes: &[Shapes<2, 3>],
    between: &mut TriangleScratch,
    found: &mut [Interactions<2, 3>],
) {
    for (shapes, found) in shapes.iter().zip(found) {
        frames(available, shapes, between);
        for of in 0..2 {
            for k in 0..3 {
                let at = &between.at[of];
                chords(available, &at[k], &at[(k + 1) % 3], &mut between.chords[of][k]);
            }
        }
        *found = Interactions::NONE;
        side::<0>(available, shapes, between, found);
        side::<1>(available, shapes, between, found);
        points(available, &between.weight, &between.moment, &shapes[0][0], &mut found.point);
    }
}

/// Computes the forces and the energy of the potential of one triangle, that on the other: that of the second
/// for `OF` = 0.
fn side<const OF: usize>(
    available: Available,
    shapes: &Shapes<2, 3>,
    between: &mut TriangleScratch,
    found: &mut Interactions<2, 3>,
) {
    between.outside = Lanes::ZERO;
    between.inside = Lanes::all(1.0);
    between.passing = Lanes::ZERO;
    edges::<OF, 0>(available, shapes, between, &mut found.forces);
    edges::<OF, 1>(available, shapes, between, &mut found.forces);
    edges::<OF, 2>(available, shapes, between, &mut found.forces);
    energies::<OF>(available, between, found);
}

/// Values of a batch that are kept between the loops over its couples. The first of two is that of the first
/// triangle on the second, the other the reverse.
pub(crate) struct TriangleScratch {
    /// Gradients of the area coordinates, twice the area, and the centroid of the target.
    gradients: [Rows<2, 3>; 2],
    double: [Lanes; 2],
    centroids: [[Lanes; 2]; 2],
    /// Area coordinates of the corners of the contactor in the target.
    at: [Rows<3, 3>; 2],
    /// The numbers of a [`Chord`] for each edge of the contactor.
    chords: [Rows<4, 3>; 2],
    /// The flux of the field out of the edges of one contactor; 1 if the centroid of the target is inside,
    /// else 0; and the edges that pass near it, as the sum of their bits.
    outside: Lanes,
    inside: Lanes,
    passing: Lanes,
    /// Sums over all edges: pressure, and pressure times position.
    weight: Lanes,
    moment: [Lanes; 2],
}

impl Default for TriangleScratch {
    fn default() -> Self {
        Self {
            gradients: [[[Lanes::ZERO; 2]; 3]; 2],
            double: [Lanes::ZERO; 2],
            centroids: [[Lanes::ZERO; 2]; 2],
            at: [[[Lanes::ZERO; 3]; 3]; 2],
            chords: [[[Lanes::ZERO; 4]; 3]; 2],
            outside: Lanes::ZERO,
            inside: Lanes::ZERO,
            passing: Lanes::ZERO,
            weight: Lanes::ZERO,
            moment: [Lanes::ZERO; 2],
        }
    }
}

compiled_for_vectors!(fn frames = all_frames<>(shapes: &Shapes<2, 3>, between: &mut TriangleScratch));

/// The area coordinates of both triangles.
#[inline(always)]
fn all_frames(shapes: &Shapes<2, 3>, between: &mut TriangleScratch) {
    for lane in 0..LANES {
        let [a, b] = [rows(&shapes[0], lane), rows(&shapes[1], lane)];
        for (of, (target, contactor)) in [(b, a), (a, b)].into_iter().enumerate() {
            let coordinates = AreaCoordinates::of(&target);
            set_rows(&mut between.gradients[of], lane, &coordinates.gradients);
            between.double[of].set(lane, coordinates.double);
            let centroid: Point =
                std::array::from_fn(|axis| THIRD * (target[0][axis] + target[1][axis] + target[2][axis]));
            set_row(&mut between.centroids[of], lane, &centroid);
            set_rows(&mut between.at[of], lane, &contactor.map(|corner| coordinates.at(corner)));
        }
        between.weight.set(lane, 0.0);
        set_row(&mut between.moment, lane, &[0.0; 2]);
    }
}

compiled_for_vectors!(fn chords = all_chords<>(start: &[Lanes; 3], end: &[Lanes; 3], chords: &mut [Lanes; 4]));

/// The chords of one edge.
#[inline(always)]
fn all_chords(start: &[Lanes; 3], end: &[Lanes; 3], chords: &mut [Lanes; 4]) {
    for lane in 0..LANES {
        let chord = chord(row(start, lane), row(end, lane));
        set_row(chords, lane, &chord.numbers());
    }
}

compiled_for_vectors!(fn edges = all_edges<const OF: usize, const K: usize>(
    shapes: &Shapes<2, 3>,
    between: &mut TriangleScratch,
    forces: &mut [Rows<2, 3>; 2]
));

/// Adds the forces on one edge of the contactor, and their reaction.
#[inline(always)]
fn all_edges<const OF: usize, const K: usize>(
    shapes: &Shapes<2, 3>,
    between: &mut TriangleScratch,
    forces: &mut [Rows<2, 3>; 2],
) {
    let next = const { (K + 1) % 3 };
    for lane in 0..LANES {
        let chord = Chord::of(row(&between.chords[OF][K], lane));
        let [here, there]: [Point; 2] = [K, next].map(|corner| row(&shapes[OF][corner], lane));
        let [start, end]: [[f64; 3]; 2] = [K, next].map(|corner| row(&between.at[OF][corner], lane));
        let along = minus(there, here);
        // The normal has the length of the edge.
        let normal = [along[1], -along[0]];
        let beyond = dot(minus(here, row(&between.centroids[OF], lane)), normal);
        let pressure = chord.at_start + chord.at_end;
        // Without pressure, values near the centroid may be NaN.
        let presses = pressure != 0.0;
        let add_to = |sum: &mut Lanes, more: f64| sum.set(lane, sum.get(lane) + more);
        add_to(&mut between.outside, if presses { beyond * chord.outside } else { 0.0 });
        between.inside.set(lane, if beyond >= 0.0 { between.inside.get(lane) } else { 0.0 });
        let passes = presses & (chord.least < NEAR);
        add_to(&mut between.passing, if passes { const { (1 << K) as f64 } } else { 0.0 });
        for axis in 0..2 {
            add_to(&mut forces[OF][K][axis], normal[axis] * -chord.at_start);
            add_to(&mut forces[OF][next][axis], normal[axis] * -chord.at_end);
        }
        for corner in 0..3 {
            let share = start[corner] * chord.at_start + end[corner] * chord.at_end;
            for axis in 0..2 {
                add_to(&mut forces[1 - OF][corner][axis], normal[axis] * share);
            }
        }
        let long = dot(normal, normal).sqrt();
        add_to(&mut between.weight, long * pressure);
        for axis in 0..2 {
            let on = here[axis] * chord.at_start + there[axis] * chord.at_end;
            add_to(&mut between.moment[axis], long * on);
        }
    }
}

compiled_for_vectors!(fn energies = all_energies<const OF: usize>(between: &TriangleScratch, found: &mut Interactions<2, 3>));

/// Adds the energy of the potential of one target, unless an edge passes near its centroid.
#[inline(always)]
fn all_energies<const OF: usize>(between: &TriangleScratch, found: &mut Interactions<2, 3>) {
    for lane in 0..LANES {
        let area = 0.5 * between.double[OF].get(lane);
        let (inside, passing) = (between.inside.get(lane), between.passing.get(lane));
        let energy = between.outside.get(lane) + inside * (THIRD * area);
        let energy = if passing > 0.0 { 0.0 } else { energy };
        found.set_energy(lane, 1 - OF, &rows(&between.gradients[OF], lane), energy);
        found.passing[1 - OF].set(lane, passing);
        found.deep.set(lane, larger(found.deep.get(lane), inside));
    }
}

/// Area coordinates of a triangle.
pub(super) struct AreaCoordinates {
    origin: Point,
    gradients: [Point; 3],
    /// Twice the area.
    double: f64,
}

impl AreaCoordinates {
    #[inline(always)]
    pub(super) fn of(triangle: &Triangle) -> Self {
        let [a, b, c] = *triangle;
        let double = cross(minus(b, a), minus(c, a));
        let per_double = 1.0 / double;
        let gradient = |[x, y]: Point| [-y * per_double, x * per_double];
        let gradients = [gradient(minus(c, b)), gradient(minus(a, c)), gradient(minus(b, a))];
        Self { origin: a, gradients, double }
    }

    #[inline(always)]
    pub(super) fn at(&self, point: Point) -> [f64; 3] {
        let from = minus(point, self.origin);
        let (one, two) = (dot(self.gradients[1], from), dot(self.gradients[2], from));
        [1.0 - one - two, one, two]
    }
}

/// The square of the distance, m², by which an edge of `target` parts it from the other triangle, for the
/// edge that does so most; negative if no edge does.
#[inline(always)]
pub(super) fn parted(contactor: &Triangle, target: &Triangle) -> f64 {
    let coordinates = AreaCoordinates::of(target);
    furthest(&coordinates.gradients, &contactor.map(|corner| coordinates.at(corner)))
}

/// The part of an edge that lies in another triangle, with integrals over this part. The length of the edge
/// counts as 1.
#[derive(Clone, Copy)]
struct Chord {
    /// ∫ φ (1 − s) and ∫ φ s.
    at_start: f64,
    at_end: f64,
    /// ∫ h.
    outside: f64,
    /// Smallest w on the part.
    least: f64,
}

impl Chord {
    #[inline(always)]
    fn of([at_start, at_end, outside, least]: [f64; 4]) -> Self {
        Self { at_start, at_end, outside, least }
    }

    #[inline(always)]
    fn numbers(&self) -> [f64; 4] {
        [self.at_start, self.at_end, self.outside, self.least]
    }
}

/// Chord of an edge whose ends have these area coordinates in the other triangle.
#[inline(always)]
fn chord(start: [f64; 3], end: [f64; 3]) -> Chord {
    let back: [f64; 3] = std::array::from_fn(|k| start[k] - end[k]);
    let (mut from, mut to, mut beyond) = (0.0, 1.0, false);
    for k in 0..3 {
        let (x, y) = (start[k], end[k]);
        let crossing = x / back[k];
        from = if x < 0.0 { larger(from, crossing) } else { from };
        to = if y < 0.0 { smaller(to, crossing) } else { to };
        beyond |= (x < 0.0) & (y < 0.0);
    }
    // A part without length.
    to = if beyond { from } else { larger(to, from) };
    // Ends of the pieces on which one coordinate is the smallest: two coordinates are equal there. Unused
    // ones are at the end.
    let cut = |k: usize, l: usize| {
        let (x, y) = (start[k] - start[l], end[k] - end[l]);
        let cut = x / (x - y);
        if (cut > from) & (cut < to) { cut } else { to }
    };
    let (a, b, c) = (cut(0, 1), cut(1, 2), cut(2, 0));
    let (a, b) = (smaller(a, b), larger(b, a));
    let (b, c) = (smaller(b, c), larger(c, b));
    let (a, b) = (smaller(a, b), larger(b, a));
    let potential = |s: f64| {
        let at = |k: usize| start[k] - s * back[k];
        larger(3.0 * smaller(smaller(at(0), at(1)), at(2)), 0.0)
    };
    let at = [from, a, b, c, to];
    let phi = at.map(potential);
    let w = phi.map(|phi| 1.0 - phi);
    // For each piece: twice ∫ φ, six times ∫ φ s, and six times ∫ φ² (3 - 2 φ) over the w² of its ends.
    let pieces: [[f64; 3]; 4] = std::array::from_fn(|k| {
        let (s, t, a, b) = (at[k], at[k + 1], phi[k], phi[k + 1]);
        let (long, both) = (t - s, a + b);
        [long * both, long * (both * (s + t) + (a * s + b * t)), long * (both * both - a * b * (1.0 + both))]
    });
    let sum = |k: usize| (pieces[0][k] + pieces[1][k]) + (pieces[2][k] + pieces[3][k]);
    let (total, at_end) = (sum(0), SIXTH * sum(1));
    // The sum of four fractions, by one division.
    let (one, two) = (pieces[0][2] * w[2] + pieces[1][2] * w[0], pieces[2][2] * w[4] + pieces[3][2] * w[2]);
    let (before, after) = (w[0] * w[1], w[3] * w[4]);
    let outside = (one * after + two * before) / (before * w[2] * after);
    let least = smaller(smaller(w[0], w[1]), smaller(smaller(w[2], w[3]), w[4]));
    Chord { at_start: 0.5 * total - at_end, at_end, outside: -SIXTH * outside, least }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplex::interactions::interaction;

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

    /// Integral of the potential of `target` over the part that `contactor` covers, summed over many small
    /// triangles.
    fn summed(contactor: &Triangle, target: &Triangle) -> f64 {
        let (n, mut sum) = (120_u32, 0.0);
        let coordinates = AreaCoordinates::of(contactor);
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
        0.5 * AreaCoordinates::of(target).double * sum / f64::from(n * n)
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

    /// The energy is continuous where an edge goes through the centroid.
    #[test]
    fn an_edge_through_the_centroid_is_as_one_that_passes_near() {
        let target = [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]];
        let contactor = |x: f64| [[x, -5.0], [x + 9.0, 0.3], [x, 5.0]];
        let energy = |x: f64| interaction(&contactor(x), &target).map_or(f64::NAN, |found| found.energy);
        let through = energy(1.0);
        for shift in [1e-12, 1e-9, 0.5 * NEAR, 0.999 * NEAR, 1.001 * NEAR, 10.0 * NEAR] {
            // The slope is the same on both sides.
            let mean = 0.5 * (energy(1.0 - shift) + energy(1.0 + shift));
            assert!((mean - through).abs() < shift * shift + 3e-9, "{shift}: {mean} {through}");
            assert!((energy(1.0 + shift) - through).abs() < 3.0 * shift + 3e-9, "{shift}");
        }
    }

    /// Two triangles with edges on one line, as at the sides of two blocks that stand on each other, also
    /// where another edge goes through the centroid. Once, this line counted twice or not at all, as
    /// coordinates were rounded.
    #[test]
    fn edges_on_one_line_count_once() {
        let target: Triangle = [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]];
        for (x, bound) in [(0.95, 1e-12), (0.9999, 1e-9), (1.0, 1e-8)] {
            let contactor: Triangle = [[x, 0.0], [6.0, 0.0], [x, 9.0]];
            let energy = |angle: f64| {
                let (sin, cos) = angle.sin_cos();
                let turned =
                    |triangle: Triangle| triangle.map(|[x, y]| [cos * x - sin * y, sin * x + cos * y]);
                interaction(&turned(contactor), &turned(target)).map_or(f64::NAN, |found| found.energy)
            };
            let straight = energy(0.0);
            for k in 1..500 {
                let found = energy(0.01 * f64::from(k));
                assert!((found - straight).abs() < bound * straight, "{x} {k}: {found} {straight}");
            }
        }
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
        let found = interaction(&above, &below).expect("they overlap");
        let up = found.forces[0].iter().map(|f| f[1]).sum::<f64>();
        // Both potentials press, each with 3 d over a length of 1.
        assert!((up / (6.0 * d) - 1.0).abs() < 1e-4, "{up}");
        assert!((found.point[0] - 0.5).abs() < 1e-9 && !found.deep);
        assert!((found.energy / (3.0 * d * d) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_same_triangle_twice_is_deep() {
        let a = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let found = interaction(&a, &a).expect("they overlap");
        assert!(found.deep);
        // ∫ φ over a triangle is a third of its area.
        assert!((found.energy - 2.0 * 0.5 / 3.0).abs() < 1e-14);
    }
}
