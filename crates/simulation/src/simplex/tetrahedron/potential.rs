//! The potential contact force of two tetrahedra.
//!
//! Each tetrahedron carries a potential φ that is 1 at its centroid, 0 on its boundary and linear in between (φ = 4 min λ, with λ the barycentric coordinates).
//! Two tetrahedra A and B that overlap store the energy `U = p ∫ (φ_A + φ_B) dV` over the overlap, and the forces are the exact gradient of this energy: the same
//! as of two triangles (`triangle/potential.rs`).
//!
//! Everything follows from φ on the faces of A alone; no polyhedron is ever built. Let c be the centroid of B, and `w = 1 − φ`. The field `(x − c) h` with
//! `h = 1/3 − w/4 + C/w³` has the divergence φ for any C. With C = −1/12 the field vanishes on the boundary of B, and its flux out of the faces of A is the
//! integral over the overlap, less a quarter of the volume of B if c is in A. A face of A is cut into the pieces on which one λ of B is the least. There φ is linear,
//! and so is w, and `(x − c)·n` is a constant on the face. Over a triangle of unit area with the values φ₁ φ₂ φ₃ at its corners, the mean of h is then
//!
//! ```text
//! 1/3 − (w₁ + w₂ + w₃)/12 − 1/(12 w₁ w₂ w₃) = −(e₁² − e₂ − e₁ e₂ + e₃ + e₁ e₃)/(12 w₁ w₂ w₃)
//! ```
//! with `e₁ = Σ φᵢ`, `e₂ = Σ φᵢ φⱼ`, `e₃ = φ₁ φ₂ φ₃`, which has no cancellation where φ is small. Near c the flux is nearly 0/0. If a face of A passes near c, C = 0 is
//! used instead, and the flux out of the faces of B inside A, where h = 1/12, is added.
//!
//! A. Munjiza, "The Combined Finite-Discrete Element Method" (Wiley, 2004), 2.6, has another potential and other forces, which are not its gradient.

use crate::simplex::tetrahedron::distance;
use crate::simplex::tetrahedron::piece::{Piece, Pieces, share_of};
use crate::simplex::tetrahedron::{FACES, Tetrahedron, cross3};
use crate::simplex::{Interaction, NEAR, Sum};
use crate::vector::{Point, add, dot, length, minus};

/// Computes the interaction of two tetrahedra, for a penalty of 1. If they do not overlap, returns a lower bound of their distance.
pub(super) fn interaction(a: &Tetrahedron, b: &Tetrahedron) -> Result<Interaction<3, 4>, f64> {
    let coordinates = [Coordinates::of(a), Coordinates::of(b)];
    let in_b = a.map(|corner| coordinates[1].at(corner));
    coordinates[1].beyond(&in_b)?;
    let in_a = b.map(|corner| coordinates[0].at(corner));
    coordinates[0].beyond(&in_a)?;
    let mut pieces = Pieces::default();
    let covered = [faces_in(&in_b, &mut pieces), faces_in(&in_a, &mut pieces)];
    let mut result = Interaction::default();
    let mut sum = Sum::default();
    let [first, second] = &mut result.forces;
    press(a, (b, &coordinates[1], &in_b), [&covered[0], &covered[1]], [first, second], &mut sum);
    press(b, (a, &coordinates[0], &in_a), [&covered[1], &covered[0]], [second, first], &mut sum);
    // No face parts the two. They overlap, touch, or are apart with an edge of each nearest to the other.
    if sum.energy <= 0.0 {
        return Err(distance::between(a, b));
    }
    Ok(sum.completed(result, a[0]))
}

/// Adds the forces of the potential of `target` on the boundary of `contactor`, and their reaction. `at`: coordinates of the corners of the contactor in the target.
/// `covered`: what the target covers of the faces of the contactor, and the reverse.
fn press(
    contactor: &Tetrahedron,
    (target, coordinates, at): (&Tetrahedron, &Coordinates, &[[f64; 4]; 4]),
    covered: [&[Covered; 4]; 2],
    [on_contactor, on_target]: [&mut [Point<3>; 4]; 2],
    sum: &mut Sum<3>,
) {
    let centroid: Point<3> =
        std::array::from_fn(|axis| target.iter().map(|corner| corner[axis]).sum::<f64>() / 4.0);
    let volume = coordinates.six_volumes / 6.0;
    let (mut outside, mut near, mut inside, mut passes_near) = (0.0, 0.0, true, false);
    for (face, covered) in FACES.iter().zip(covered[0]) {
        let [p, q, r] = face.map(|corner| contactor[corner]);
        // The normal has twice the area of the face as its length.
        let normal = cross3(minus(q, p), minus(r, p));
        let beyond = dot(minus(p, centroid), normal);
        inside &= beyond >= 0.0;
        let pressure = covered.potential;
        if pressure == 0.0 {
            continue;
        }
        // Means over the face become integrals by its area, half of the length of the normal.
        outside += 0.5 * beyond * covered.outside;
        near += 0.5 * beyond * covered.near();
        passes_near |= 1.0 - covered.most < NEAR;
        let size = 0.5 * length(normal);
        for (&corner, share) in face.iter().zip(covered.shares()) {
            add(&mut on_contactor[corner], normal, -0.5 * share);
            for (node, on_target) in on_target.iter_mut().enumerate() {
                add(on_target, normal, 0.5 * share * at[corner][node]);
            }
            add(&mut sum.moment, contactor[corner], size * share);
        }
        sum.weight += size * pressure;
    }
    let energy = if passes_near {
        near + volume / 16.0 * covered[1].iter().map(|covered| covered.area).sum::<f64>()
    } else if inside {
        outside + volume / 4.0
    } else {
        outside
    };
    for (on_target, gradient) in on_target.iter_mut().zip(coordinates.gradients) {
        add(on_target, gradient, -energy);
    }
    sum.energy += energy;
    sum.deep |= inside;
}

/// Barycentric coordinates of a tetrahedron.
pub(super) struct Coordinates {
    origin: Point<3>,
    pub(super) gradients: [Point<3>; 4],
    pub(super) six_volumes: f64,
}

impl Coordinates {
    #[inline]
    pub(super) fn of(tetrahedron: &Tetrahedron) -> Self {
        let [a, b, c, d] = *tetrahedron;
        let (e, f, g) = (minus(b, a), minus(c, a), minus(d, a));
        let [one, two, three] = [cross3(f, g), cross3(g, e), cross3(e, f)];
        let six_volumes = dot(e, one);
        let per = 1.0 / six_volumes;
        let [one, two, three] = [one, two, three].map(|normal| normal.map(|x| x * per));
        let zero = std::array::from_fn(|axis| -one[axis] - two[axis] - three[axis]);
        Self { origin: a, gradients: [zero, one, two, three], six_volumes }
    }

    #[inline]
    pub(super) fn at(&self, point: Point<3>) -> [f64; 4] {
        let from = minus(point, self.origin);
        let [one, two, three] = [1, 2, 3].map(|k| dot(self.gradients[k], from));
        [1.0 - one - two - three, one, two, three]
    }

    /// Returns `Err` if corners with these coordinates are all on or beyond one of the faces; the value is a lower bound of their distance.
    #[inline]
    fn beyond(&self, corners: &[[f64; 4]; 4]) -> Result<(), f64> {
        let mut distance: Option<f64> = None;
        for k in 0..4 {
            let most = corners.iter().map(|corner| corner[k]).fold(f64::NEG_INFINITY, f64::max);
            if most <= 0.0 {
                // The length of the gradient is one over the height.
                let beyond = -most / length(self.gradients[k]);
                distance = Some(distance.map_or(beyond, |other| other.max(beyond)));
            }
        }
        distance.map_or(Ok(()), Err)
    }
}

/// The part of a face that lies in another tetrahedron, with integrals over this part. The area of the face counts as 1.
#[derive(Clone, Copy, Default)]
struct Covered {
    /// Area of the part.
    area: f64,
    /// ∫ φ.
    potential: f64,
    /// ∫ φ β, with β the last two barycentric coordinates on the face.
    shares: [f64; 2],
    /// ∫ h with C = −1/12.
    outside: f64,
    /// Largest φ on the part.
    most: f64,
}

impl Covered {
    /// ∫ φ β, with β the barycentric coordinates on the face.
    #[inline]
    fn shares(&self) -> [f64; 3] {
        let [one, two] = self.shares;
        [self.potential - one - two, one, two]
    }

    /// ∫ h with C = 0.
    #[inline]
    fn near(&self) -> f64 {
        self.area / 12.0 + 0.25 * self.potential
    }

    /// Adds the integrals over a piece of the face on which this coordinate is the least.
    #[inline]
    fn add(&mut self, pieces: &Pieces, piece: &Piece, least: usize) {
        let mut corners =
            pieces.corners(piece).map(|corner| (corner, larger(4.0 * corner.values[least], 0.0)));
        let (Some((first, a)), Some((mut second, mut b))) = (corners.next(), corners.next()) else { return };
        let mut most = larger(larger(self.most, a), b);
        for (third, c) in corners {
            let area = share_of([first, second, third]);
            self.area += area;
            let sum = a + b + c;
            self.potential += area / 3.0 * sum;
            for k in 0..2 {
                let places = first.place[k] + second.place[k] + third.place[k];
                let own = a * first.place[k] + b * second.place[k] + c * third.place[k];
                self.shares[k] += area / 12.0 * (sum * places + own);
            }
            let (two, three) = (a * b + b * c + c * a, a * b * c);
            let w = (1.0 - a) * (1.0 - b) * (1.0 - c);
            self.outside -= area * (sum * sum - two - sum * two + three + sum * three) / (12.0 * w);
            most = larger(most, c);
            (second, b) = (third, c);
        }
        self.most = most;
    }
}

/// The larger of two numbers. One instruction, where `f64::max` takes five, because it knows what is not a number.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The parts of the four faces of a tetrahedron that another one covers. `corners`: coordinates of the corners in that other one.
fn faces_in(corners: &[[f64; 4]; 4], pieces: &mut Pieces) -> [Covered; 4] {
    // The coordinates, as bits, that are positive and negative at each corner.
    let bits =
        |is: fn(&f64) -> bool| corners.map(|at| (0..4).fold(0, |all, k| all | u8::from(is(&at[k])) << k));
    let (positive, negative) = (bits(|x| *x > 0.0), bits(|x| *x < 0.0));
    FACES.map(|[a, b, c]| {
        // Beyond a face of the other one: most faces are.
        if positive[a] | positive[b] | positive[c] != 0b1111 {
            return Covered::default();
        }
        face_in(&[corners[a], corners[b], corners[c]], negative[a] | negative[b] | negative[c], pieces)
    })
}

/// Pairs of coordinates.
const PAIRS: [[usize; 2]; 6] = [[1, 0], [2, 1], [3, 2], [0, 3], [2, 0], [3, 1]];

/// The part of a face whose corners have these coordinates in the other tetrahedron. `negative`: those that are negative somewhere.
fn face_in(corners: &[[f64; 4]; 3], negative: u8, pieces: &mut Pieces) -> Covered {
    let mut covered = Covered::default();
    pieces.begin(corners);
    // Where no coordinate is negative.
    let mut inside = Piece::WHOLE;
    for k in (0..4).filter(|k| negative >> k & 1 != 0) {
        inside = pieces.cut(&inside, |values| values[k]);
        if inside.is_empty() {
            return covered;
        }
    }
    // The largest and the least difference of each pair of coordinates at the corners.
    let (mut largest, mut least) = ([f64::NEG_INFINITY; 6], [f64::INFINITY; 6]);
    for corner in pieces.corners(&inside) {
        for (pair, [k, j]) in PAIRS.into_iter().enumerate() {
            let difference = corner.values[k] - corner.values[j];
            largest[pair] = larger(difference, largest[pair]);
            least[pair] = if difference < least[pair] { difference } else { least[pair] };
        }
    }
    // Bit `j` of the mask `k`: at some corner coordinate `k` is more than `j`.
    let mut more = [0_u8; 4];
    for (pair, [k, j]) in PAIRS.into_iter().enumerate() {
        more[k] |= u8::from(largest[pair] > 0.0) << j;
        more[j] |= u8::from(least[pair] < 0.0) << k;
    }
    let is_more = |k: usize, j: usize| more[k] >> j & 1 != 0;
    let count = pieces.count();
    // Each part where one coordinate is the least: if another is nowhere more, there is none. Of two that are the same on the face, the first counts.
    for least in 0..4 {
        let others = (0..4).filter(|&other| other != least);
        if others.clone().any(|other| !is_more(other, least) && (is_more(least, other) || other < least)) {
            continue;
        }
        let mut part = inside;
        pieces.forget(count);
        for other in others.filter(|&other| is_more(least, other)) {
            part = pieces.cut(&part, |values| values[other] - values[least]);
        }
        covered.add(pieces, &part, least);
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;

    /// Pairs of tetrahedra that overlap in many ways, or do not, from a fixed pseudo-random sequence.
    fn pairs(count: u64) -> impl Iterator<Item = [Tetrahedron; 2]> {
        (0..count).map(|pair| {
            [(0, 0.0), (1, 0.4)].map(|(which, shift)| {
                let corner = |seed: u64, k: u64| {
                    std::array::from_fn(|axis| 2.0 * uniform(seed, 3 * k + axis as u64) + shift)
                };
                let all =
                    (0..).map(|attempt| [0, 1, 2, 3].map(|k| corner(1000 * pair + 500 * which + attempt, k)));
                let mut shapes = all.filter(|shape| Coordinates::of(shape).six_volumes > 0.5);
                shapes.next().expect("one of them is large enough")
            })
        })
    }

    #[test]
    fn forces_are_the_gradient_of_the_energy() {
        let (mut overlapping, mut deep) = (0, 0);
        for [a, b] in pairs(1000) {
            let Ok(found) = interaction(&a, &b) else { continue };
            overlapping += 1;
            deep += u32::from(found.deep);
            for side in 0..2 {
                for corner in 0..4 {
                    for axis in 0..3 {
                        let h = 1e-6;
                        let energy = |sign: f64| {
                            let mut moved = [a, b];
                            moved[side][corner][axis] += sign * h;
                            interaction(&moved[0], &moved[1]).map_or(0.0, |found| found.energy)
                        };
                        let slope = (energy(1.0) - energy(-1.0)) / (2.0 * h);
                        let force = found.forces[side][corner][axis];
                        assert!(
                            (force + slope).abs() < 1e-7,
                            "{a:?} {b:?}: {side} {corner} {axis}: {force} {slope}"
                        );
                    }
                }
            }
        }
        assert!(overlapping > 300 && deep > 20, "{overlapping} {deep}");
    }

    #[test]
    fn forces_and_torques_cancel() {
        for [a, b] in pairs(200) {
            let Ok(found) = interaction(&a, &b) else { continue };
            let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
            for (corners, forces) in [a, b].iter().zip(found.forces) {
                for (corner, on) in corners.iter().zip(forces) {
                    add(&mut force, on, 1.0);
                    add(&mut torque, cross3(*corner, on), 1.0);
                }
            }
            assert!(length(force) < 1e-13 && length(torque) < 1e-13, "{force:?} {torque:?}");
        }
    }

    /// Integral of the potential of `target` over the part that `contactor` covers, by points at random.
    fn sampled(contactor: &Tetrahedron, target: &Tetrahedron, seed: u64) -> [f64; 2] {
        let count = 40_000;
        let (own, other) = (Coordinates::of(target), Coordinates::of(contactor));
        let (mut sum, mut squares) = (0.0, 0.0);
        for k in 0..count {
            // Sorted numbers cut the unit interval into four lengths that are uniform in the tetrahedron.
            let mut cuts = [0, 1, 2].map(|axis| uniform(seed, 3 * k + axis));
            cuts.sort_unstable_by(f64::total_cmp);
            let lambda = [cuts[0], cuts[1] - cuts[0], cuts[2] - cuts[1], 1.0 - cuts[2]];
            let point =
                std::array::from_fn(|axis| (0..4).map(|corner| lambda[corner] * target[corner][axis]).sum());
            if other.at(point).iter().all(|&share| share >= 0.0) {
                let potential = 4.0 * lambda.into_iter().fold(1.0, f64::min);
                sum += potential;
                squares += potential * potential;
            }
        }
        let (n, volume) = (count as f64, own.six_volumes / 6.0);
        let mean = sum / n;
        [volume * mean, volume * ((squares / n - mean * mean) / n).sqrt()]
    }

    #[test]
    fn the_energy_is_the_integral_over_the_overlap() {
        for (number, [a, b]) in (0..).zip(pairs(60)) {
            let found = interaction(&a, &b).map_or(0.0, |found| found.energy);
            let [[one, error], [other, error_too]] = [sampled(&a, &b, number), sampled(&b, &a, number)];
            let error = error.hypot(error_too);
            assert!((found - one - other).abs() <= 4.5 * error + 1e-6, "{found} {} {error}", one + other);
        }
    }

    /// The potential of a tetrahedron has a quarter of its volume as its integral, also where another covers all of it.
    #[test]
    fn one_inside_another() {
        let small = [[0.1, 0.1, 0.1], [0.2, 0.1, 0.1], [0.1, 0.2, 0.1], [0.1, 0.1, 0.2]];
        let large = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let found = interaction(&small, &large).expect("they overlap");
        // In the large one φ = 4 min(x, y, z) over the small one; 0.1 plus a quarter of 0.1 is the mean of each coordinate.
        let [inside, error] = sampled(&small, &large, 1);
        assert!(
            (found.energy - inside - 1e-3 / 24.0).abs() < 4.0 * error,
            "{} {inside} {error}",
            found.energy
        );
        assert_eq!(interaction(&large, &large).map(|found| found.deep), Ok(true));
        let same = interaction(&large, &large).expect("they overlap");
        assert!((same.energy - 2.0 / 24.0).abs() < 1e-15, "{}", same.energy);
    }

    /// Both forms of the integral agree where both are accurate, and the one for faces near the centroid is continuous where a face goes through it.
    #[test]
    fn a_face_through_the_centroid_is_as_one_that_passes_near() {
        let target = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let contactor = |x: f64| [[x, -9.0, -9.0], [x, 9.0, -9.0], [x + 9.0, 0.0, 0.0], [x, 0.0, 18.0]];
        let contactor = |x: f64| {
            let shape = contactor(x);
            if Coordinates::of(&shape).six_volumes > 0.0 {
                shape
            } else {
                [shape[1], shape[0], shape[2], shape[3]]
            }
        };
        let energy = |x: f64| interaction(&contactor(x), &target).map_or(f64::NAN, |found| found.energy);
        let through = energy(1.0);
        for (h, bound) in [(1e-9, 1e-7), (1e-6, 1e-4)] {
            assert!((energy(1.0 + h) - through).abs() < bound && (energy(1.0 - h) - through).abs() < bound);
        }
        // Where the form changes, at w = 0.1 from the centroid.
        for at in [1.1, 0.9, 1.3, 0.7] {
            let (before, after) = (energy(at - 1e-9), energy(at + 1e-9));
            assert!((before - after).abs() < 1e-6, "{at}: {before} {after}");
        }
    }

    /// On a face in the plane where two coordinates of the other tetrahedron are the same, each part counts once.
    #[test]
    fn a_face_in_the_middle_plane_of_an_edge_is_as_one_beside_it() {
        let target = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let contactor = |by: f64| {
            [[-9.0, -9.0, -9.0], [9.0, 9.0, -9.0], [0.0, 0.0, 18.0], [9.0, -9.0, 0.0]]
                .map(|[x, y, z]| [x + by, y - by, z])
        };
        let contactor = |by: f64| {
            let shape = contactor(by);
            if Coordinates::of(&shape).six_volumes > 0.0 {
                shape
            } else {
                [shape[1], shape[0], shape[2], shape[3]]
            }
        };
        let at = |by: f64| interaction(&contactor(by), &target).expect("they overlap");
        let (before, middle, after) = (at(-1e-9), at(0.0), at(1e-9));
        let size = length(middle.forces[0][3]) + length(middle.forces[0][0]);
        assert!(size > 0.1);
        for side in 0..2 {
            for corner in 0..4 {
                for other in [&before, &after] {
                    let off = length(minus(middle.forces[side][corner], other.forces[side][corner]));
                    assert!(off < 1e-6 * size, "{off} of {size}");
                }
            }
        }
    }

    #[test]
    fn tetrahedra_that_touch_do_nothing() {
        let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let below = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];
        assert_eq!(interaction(&one, &below), Err(0.0));
        let far = below.map(|[x, y, z]| [x, y, z - 0.25]);
        assert!(matches!(interaction(&one, &far), Err(distance) if (distance - 0.25).abs() < 1e-15));
    }

    /// No face parts two tetrahedra whose edges cross at a distance. What is told is never more than the distance, and it tells all that are apart.
    #[test]
    fn the_distance_of_tetrahedra_whose_edges_cross() {
        let below = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, -1.0]];
        let below = if Coordinates::of(&below).six_volumes > 0.0 {
            below
        } else {
            [below[1], below[0], below[2], below[3]]
        };
        let above = below.map(|[x, y, z]| [y, x, 0.1 - z]);
        let above = if Coordinates::of(&above).six_volumes > 0.0 {
            above
        } else {
            [above[1], above[0], above[2], above[3]]
        };
        let found = interaction(&below, &above);
        assert!(matches!(found, Err(distance) if (distance - 0.1).abs() < 1e-15), "{found:?}");
        let mut told = 0;
        for [a, b] in pairs(300) {
            let b = b.map(|corner| corner.map(|x| x + 0.5));
            let Err(distance) = interaction(&a, &b) else { continue };
            // Points of both that are near each other.
            let point = |shape: &Tetrahedron, seed: u64, k: u64| -> Point<3> {
                let weights = [0, 1, 2, 3].map(|corner| uniform(seed, 4 * k + corner).powi(4));
                let sum: f64 = weights.iter().sum();
                std::array::from_fn(|axis| {
                    (0..4).map(|corner| weights[corner] * shape[corner][axis]).sum::<f64>() / sum
                })
            };
            let nearest = (0..200)
                .map(|k| length(minus(point(&a, 1, k), point(&b, 2, k))))
                .fold(f64::INFINITY, f64::min);
            assert!(distance <= nearest, "{distance} {nearest}");
            told += u32::from(distance > 0.0);
        }
        assert!(told > 100, "{told}");
    }
}
