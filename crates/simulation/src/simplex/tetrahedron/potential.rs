//! The potential contact force of two tetrahedra.
//!
//! Each tetrahedron carries a potential φ that is 1 at its centroid, 0 on its boundary and linear in between
//! (φ = 4 min λ, with λ the barycentric coordinates). Two tetrahedra A and B that overlap store the energy
//! `U = p ∫ (φ_A + φ_B) dV` over the overlap, and the forces are the exact gradient of this energy: the same
//! as of two triangles (`triangle/potential.rs`).
//!
//! Everything follows from φ on the faces of A alone; no polyhedron is ever built. Let c be the centroid of
//! B, and `w = 1 − φ`. The field `(x − c) h` with `h = 1/3 − w/4 + C/w³` has the divergence φ for any C. With
//! C = −1/12 the field vanishes on the boundary of B, and its flux out of the faces of A is the integral over
//! the overlap, less a quarter of the volume of B if c is in A. A face of A is cut into the pieces on which
//! one λ of B is the least. There φ is linear, and so is w, and `(x − c)·n` is a constant on the face. Over a
//! triangle of unit area with the values φ₁ φ₂ φ₃ at its corners, the mean of h is then
//!
//! ```text
//! 1/3 − (w₁ + w₂ + w₃)/12 − 1/(12 w₁ w₂ w₃) = −(e₁² − e₂ − e₁ e₂ + e₃ + e₁ e₃)/(12 w₁ w₂ w₃)
//! ```
//! with `e₁ = Σ φᵢ`, `e₂ = Σ φᵢ φⱼ`, `e₃ = φ₁ φ₂ φ₃`, which has no cancellation where φ is small. Near c the
//! flux is nearly 0/0: see `interactions.rs`.
//!
//! A. Munjiza, "The Combined Finite-Discrete Element Method" (Wiley, 2004), 2.6, has another potential and
//! other forces, which are not its gradient.
//!
//! Couples are computed in batches. Pieces of faces differ in the necessary cuts, so each piece is a separate
//! task, and tasks with the same number of cuts are computed side by side: see `part.rs` and `lanes.rs`.
//! Twin: `crates/gpu/kernels/contact.h`.

#![allow(
    clippy::needless_bitwise_bool,
    reason = "a lazy operator is a branch, of which the compiler makes no vectors"
)]

use crate::lanes::{
    Available, LANES, Lanes, Rows, compiled_for_vectors, larger, row, rows, set_row, set_rows,
};
use crate::simplex::Tetrahedron;
use crate::simplex::tetrahedron::numbering::FACES;
use crate::simplex::tetrahedron::part::{CUTS, NUMBERS, PartBatch};
use crate::simplex::{Interactions, NEAR, Shapes, furthest, points};
use crate::vector::{Point, cross3, dot, minus};

/// Memory for the interactions of a list of batches.
pub(crate) struct Scratch {
    frames: Vec<LoopValues>,
    tasks: Tasks,
}

impl Default for Scratch {
    fn default() -> Self {
        Self { frames: vec![LoopValues::NONE; TOGETHER], tasks: Tasks::new() }
    }
}

/// [`Simplex::usual_interactions`](crate::simplex::Simplex::usual_interactions).
pub(super) fn usual_interactions(
    available: Available,
    shapes: &[Shapes<3, 4>],
    Scratch { frames, tasks }: &mut Scratch,
    found: &mut [Interactions<3, 4>],
) {
    for (shapes, found) in shapes.chunks(TOGETHER).zip(found.chunks_mut(TOGETHER)) {
        let frames = &mut frames[..shapes.len()];
        tasks.clear();
        for (batch, (shapes, between)) in shapes.iter().zip(&mut *frames).enumerate() {
            frames_of(available, shapes, between);
            codes(available, between, &mut tasks.codes);
            tasks.list(batch);
        }
        tasks.compute(available, frames);
        for ((shapes, between), found) in shapes.iter().zip(frames).zip(found) {
            *found = Interactions::NONE;
            side::<0>(available, shapes, between, found);
            side::<1>(available, shapes, between, found);
            points(available, &between.weight, &between.moment, &shapes[0][0], &mut found.point);
        }
    }
}

/// Number of batches whose tasks are computed together.
const TOGETHER: usize = 4;

/// Computes the forces and the energy of the potential of one tetrahedron, that on the other: that of the
/// second for `OF` = 0.
fn side<const OF: usize>(
    available: Available,
    shapes: &Shapes<3, 4>,
    between: &mut LoopValues,
    found: &mut Interactions<3, 4>,
) {
    between.outside = Lanes::ZERO;
    between.inside = Lanes::all(1.0);
    between.passing = Lanes::ZERO;
    faces::<OF, 0>(available, shapes, between, &mut found.forces);
    faces::<OF, 1>(available, shapes, between, &mut found.forces);
    faces::<OF, 2>(available, shapes, between, &mut found.forces);
    faces::<OF, 3>(available, shapes, between, &mut found.forces);
    energies::<OF>(available, between, found);
}

/// Values of a batch that are kept between the loops over its couples. The first of two is that of the first
/// tetrahedron on the second, the other the reverse.
#[derive(Clone)]
struct LoopValues {
    /// Gradients of the barycentric coordinates, six times the volume, and the centroid of the target.
    gradients: [Rows<3, 4>; 2],
    six_volumes: [Lanes; 2],
    centroids: [[Lanes; 3]; 2],
    /// Barycentric coordinates of the corners of the contactor in the target.
    at: [Rows<4, 4>; 2],
    /// The numbers of [`PartBatch`], summed over the parts of each face of the contactor that the target
    /// covers.
    covered: [Rows<NUMBERS, 4>; 2],
    /// The flux of the field out of the faces of one contactor; 1 if the centroid of the target is inside,
    /// else 0; and the faces that pass near it, as the sum of their bits.
    outside: Lanes,
    inside: Lanes,
    passing: Lanes,
    /// Sums over all faces: pressure, and pressure times position.
    weight: Lanes,
    moment: [Lanes; 3],
}

impl LoopValues {
    const NONE: Self = Self {
        gradients: [[[Lanes::ZERO; 3]; 4]; 2],
        six_volumes: [Lanes::ZERO; 2],
        centroids: [[Lanes::ZERO; 3]; 2],
        at: [[[Lanes::ZERO; 4]; 4]; 2],
        covered: [[[Lanes::ZERO; NUMBERS]; 4]; 2],
        outside: Lanes::ZERO,
        inside: Lanes::ZERO,
        passing: Lanes::ZERO,
        weight: Lanes::ZERO,
        moment: [Lanes::ZERO; 3],
    };
}

compiled_for_vectors!(fn frames_of = all_frames<>(shapes: &Shapes<3, 4>, between: &mut LoopValues));

/// The barycentric coordinates of both tetrahedra.
#[inline(always)]
fn all_frames(shapes: &Shapes<3, 4>, between: &mut LoopValues) {
    for of in 0..2 {
        for lane in 0..LANES {
            let target: Tetrahedron = rows(&shapes[1 - of], lane);
            let contactor: Tetrahedron = rows(&shapes[of], lane);
            let coordinates = VolumeCoordinates::of(&target);
            set_rows(&mut between.gradients[of], lane, &coordinates.gradients);
            between.six_volumes[of].set(lane, coordinates.six_volumes);
            let [a, b, c, d] = target;
            let centroid: Point<3> =
                std::array::from_fn(|axis| 0.25 * (a[axis] + b[axis] + c[axis] + d[axis]));
            set_row(&mut between.centroids[of], lane, &centroid);
            set_rows(&mut between.at[of], lane, &contactor.map(|corner| coordinates.at(corner)));
        }
    }
    between.covered = [[[Lanes::ZERO; NUMBERS]; 4]; 2];
    between.weight = Lanes::ZERO;
    between.moment = [Lanes::ZERO; 3];
}

/// Bits of the word of a corner: coordinate k is positive; it is negative, from 4 on; coordinate k is more
/// than j, at 4 k + j from 8 on; it is less, from 24 on.
const NEGATIVE: u32 = 4;
const MORE: u32 = 8;
const LESS: u32 = 24;

/// The parts of the faces on each side. Part 4 f + k is that of face f on which coordinate k of the target is
/// the least. `parts`: those that are there, as bits. `lines`: the lines that cut each, four bits for each.
struct Codes {
    parts: [[u64; LANES]; 2],
    lines: [[u64; LANES]; 2],
}

compiled_for_vectors!(fn codes = all_codes<>(between: &LoopValues, codes: &mut Codes));

#[inline(always)]
fn all_codes(between: &LoopValues, codes: &mut Codes) {
    for of in 0..2 {
        let mut words = [[0_u64; LANES]; 4];
        for corner in 0..4 {
            for lane in 0..LANES {
                words[corner][lane] = word(&row(&between.at[of][corner], lane));
            }
        }
        codes.parts[of] = [0; LANES];
        codes.lines[of] = [0; LANES];
        for face in 0..4 {
            let [a, b, c] = FACES[face];
            for lane in 0..LANES {
                let word = words[a][lane] | words[b][lane] | words[c][lane];
                let (mut parts, mut lines) = (0, 0);
                for least in 0..4 {
                    let (is_there, cuts) = code(word, least as u32);
                    parts |= u64::from(is_there) << least;
                    lines |= cuts << (4 * least);
                }
                codes.parts[of][lane] |= parts << (4 * face);
                codes.lines[of][lane] |= lines << (16 * face);
            }
        }
    }
}

/// The signs of the coordinates of a corner, and of their differences, as bits.
#[inline(always)]
fn word(at: &[f64; 4]) -> u64 {
    let mut word = 0;
    for k in 0..4 {
        word |= u64::from(at[k] > 0.0) << k;
        word |= u64::from(at[k] < 0.0) << (NEGATIVE + k as u32);
        for j in 0..4 {
            if j != k {
                word |= u64::from(at[k] > at[j]) << (MORE + (4 * k + j) as u32);
                word |= u64::from(at[k] < at[j]) << (LESS + (4 * k + j) as u32);
            }
        }
    }
    word
}

/// Whether there is a part of a face on which coordinate `least` is the least, and the lines that cut it, as
/// bits: bit j means the line where it is the same as coordinate j, bit `least` the line where it is zero.
/// `word`: the words of the corners of the face.
#[inline(always)]
fn code(word: u64, least: u32) -> (bool, u64) {
    // Beyond a face of the other one: most faces are.
    let beyond = word & 0b1111 != 0b1111;
    let more = word >> (MORE + 4 * least) & 0b1111;
    let less = word >> (LESS + 4 * least) & 0b1111;
    // If another is nowhere more, there is no part. If two are the same on the face, the first counts.
    let none = !less & (more | ((1 << least) - 1)) & (0b1111 ^ 1 << least) != 0;
    let zero = (word >> (NEGATIVE + least) & 1) << least;
    (!(beyond | none), more | zero)
}

/// A part of a face: its batch, lane, side and number in [`Codes`], and the lines that cut it, as bits.
#[derive(Clone, Copy)]
struct Task {
    batch: u8,
    lane: u8,
    of: u8,
    part: u8,
    lines: u8,
}

/// The parts of faces to be computed, by the number of lines that cut them.
struct Tasks {
    codes: Codes,
    lists: [Vec<Task>; CUTS + 1],
    parts: PartBatch,
}

impl Tasks {
    fn new() -> Self {
        let codes = Codes { parts: [[0; LANES]; 2], lines: [[0; LANES]; 2] };
        Self { codes, lists: std::array::from_fn(|_| Vec::new()), parts: PartBatch::NONE }
    }

    fn clear(&mut self) {
        for list in &mut self.lists {
            list.clear();
        }
    }

    /// Lists the parts of a batch by their codes.
    fn list(&mut self, batch: usize) {
        for lane in 0..LANES {
            for of in 0..2 {
                let mut parts = self.codes.parts[of][lane];
                let lines = self.codes.lines[of][lane];
                while parts != 0 {
                    let part = parts.trailing_zeros();
                    parts &= parts - 1;
                    let lines = (lines >> (4 * part)) as u8 & 0b1111;
                    let [batch, lane, of, part] = [batch, lane, of, part as usize].map(|x| x as u8);
                    self.lists[lines.count_ones() as usize].push(Task { batch, lane, of, part, lines });
                }
            }
        }
    }

    /// Computes all parts, and adds their numbers to those of their faces: first those with no cut, then
    /// those with one and more, so that the order for each couple does not depend on the others.
    fn compute(&mut self, available: Available, frames: &mut [LoopValues]) {
        let Self { lists, parts, .. } = self;
        for (cuts, list) in lists.iter().enumerate() {
            for tasks in list.chunks(LANES) {
                for (lane, task) in tasks.iter().enumerate() {
                    task.give(&frames[task.batch as usize], lane, parts);
                }
                parts.compute(available, cuts);
                for (lane, task) in tasks.iter().enumerate() {
                    let frame = &mut frames[task.batch as usize];
                    let sums = &mut frame.covered[task.of as usize % 2][task.face()];
                    parts.add_to(lane, sums, task.lane as usize % LANES);
                }
            }
        }
    }
}

impl Task {
    fn face(self) -> usize {
        self.part as usize / 4 % 4
    }

    /// Gives the corners of the face to a lane of the parts.
    #[inline]
    fn give(self, between: &LoopValues, lane: usize, parts: &mut PartBatch) {
        let own = self.lane as usize % LANES;
        let at = &between.at[self.of as usize % 2];
        let corners = FACES[self.face()].map(|corner| &at[corner]);
        let values = |k: usize| corners.map(|at| at[k].get(own));
        let number = self.part as usize % 4;
        let least = values(number);
        parts.set_potential(lane, least);
        let mut lines = self.lines;
        let mut count = 0;
        while lines != 0 {
            let k = lines.trailing_zeros() as usize % 4;
            lines &= lines - 1;
            // The part lies where a line is not negative.
            let line = if k == number { least } else { minus(values(k), least) };
            parts.set_line(lane, count, line);
            count += 1;
        }
    }
}

compiled_for_vectors!(fn faces = all_faces<const OF: usize, const F: usize>(
    shapes: &Shapes<3, 4>,
    between: &mut LoopValues,
    forces: &mut [Rows<3, 4>; 2]
));

/// Adds the forces on one face of the contactor, and their reaction.
#[inline(always)]
fn all_faces<const OF: usize, const F: usize>(
    shapes: &Shapes<3, 4>,
    between: &mut LoopValues,
    forces: &mut [Rows<3, 4>; 2],
) {
    let corners = const { FACES[F] };
    for lane in 0..LANES {
        let [potential, one, two, outside, most] = row(&between.covered[OF][F], lane);
        let [p, q, r]: [Point<3>; 3] = corners.map(|corner| row(&shapes[OF][corner], lane));
        // The normal has twice the area of the face as its length.
        let normal = cross3(minus(q, p), minus(r, p));
        let beyond = 0.5 * dot(minus(p, row(&between.centroids[OF], lane)), normal);
        // Without pressure, values near the centroid may be NaN.
        let presses = potential != 0.0;
        let add_to = |sum: &mut Lanes, more: f64| sum.set(lane, sum.get(lane) + more);
        // Means over the face become integrals by its area, half of the length of the normal.
        add_to(&mut between.outside, if presses { beyond * outside } else { 0.0 });
        between.inside.set(lane, if beyond >= 0.0 { between.inside.get(lane) } else { 0.0 });
        let passes = presses & (1.0 - most < NEAR);
        add_to(&mut between.passing, if passes { const { (1 << F) as f64 } } else { 0.0 });
        let shares = [potential - one - two, one, two];
        for k in 0..3 {
            for axis in 0..3 {
                add_to(&mut forces[OF][corners[k]][axis], normal[axis] * (-0.5 * shares[k]));
            }
        }
        let at: [[f64; 4]; 3] = corners.map(|corner| row(&between.at[OF][corner], lane));
        for node in 0..4 {
            let share = shares[0] * at[0][node] + shares[1] * at[1][node] + shares[2] * at[2][node];
            for axis in 0..3 {
                add_to(&mut forces[1 - OF][node][axis], normal[axis] * (0.5 * share));
            }
        }
        let size = 0.5 * dot(normal, normal).sqrt();
        add_to(&mut between.weight, size * potential);
        for axis in 0..3 {
            let on = shares[0] * p[axis] + shares[1] * q[axis] + shares[2] * r[axis];
            add_to(&mut between.moment[axis], size * on);
        }
    }
}

compiled_for_vectors!(fn energies = all_energies<const OF: usize>(between: &LoopValues, found: &mut Interactions<3, 4>));

/// Adds the energy of the potential of one target, unless a face passes near its centroid.
#[inline(always)]
fn all_energies<const OF: usize>(between: &LoopValues, found: &mut Interactions<3, 4>) {
    for lane in 0..LANES {
        let volume = between.six_volumes[OF].get(lane) * (1.0 / 6.0);
        let (inside, passing) = (between.inside.get(lane), between.passing.get(lane));
        let energy = between.outside.get(lane) + inside * (0.25 * volume);
        let energy = if passing > 0.0 { 0.0 } else { energy };
        found.set_energy(lane, 1 - OF, &rows(&between.gradients[OF], lane), energy);
        found.passing[1 - OF].set(lane, passing);
        found.deep.set(lane, larger(found.deep.get(lane), inside));
    }
}

/// Barycentric coordinates of a tetrahedron.
pub(super) struct VolumeCoordinates {
    origin: Point<3>,
    pub(super) gradients: [Point<3>; 4],
    pub(super) six_volumes: f64,
}

impl VolumeCoordinates {
    #[inline(always)]
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

    #[inline(always)]
    pub(super) fn at(&self, point: Point<3>) -> [f64; 4] {
        let from = minus(point, self.origin);
        let [one, two, three] = [1, 2, 3].map(|k| dot(self.gradients[k], from));
        [1.0 - one - two - three, one, two, three]
    }
}

/// The square of the distance, m², by which a face of `target` parts it from the other tetrahedron, for the
/// face that does so most; negative if no face does.
#[inline(always)]
pub(super) fn parted(contactor: &Tetrahedron, target: &Tetrahedron) -> f64 {
    let coordinates = VolumeCoordinates::of(target);
    furthest(&coordinates.gradients, &contactor.map(|corner| coordinates.at(corner)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::simplex::interactions::interaction;
    use crate::vector::{add, length, unit};

    /// Pairs of tetrahedra that overlap in many ways, or do not, from a fixed pseudo-random sequence.
    fn pairs(count: u64) -> impl Iterator<Item = [Tetrahedron; 2]> {
        (0..count).map(|pair| {
            [(0, 0.0), (1, 0.4)].map(|(which, shift)| {
                let corner = |seed: u64, k: u64| {
                    std::array::from_fn(|axis| 2.0 * uniform(seed, 3 * k + axis as u64) + shift)
                };
                let all =
                    (0..).map(|attempt| [0, 1, 2, 3].map(|k| corner(1000 * pair + 500 * which + attempt, k)));
                let mut shapes = all.filter(|shape| VolumeCoordinates::of(shape).six_volumes > 0.5);
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
                            (force + slope).abs() < 1e-6,
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
        let (own, other) = (VolumeCoordinates::of(target), VolumeCoordinates::of(contactor));
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

    /// The potential of a tetrahedron has a quarter of its volume as its integral, also where another covers
    /// all of it.
    #[test]
    fn one_inside_another() {
        let small = [[0.1, 0.1, 0.1], [0.2, 0.1, 0.1], [0.1, 0.2, 0.1], [0.1, 0.1, 0.2]];
        let large = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let found = interaction(&small, &large).expect("they overlap");
        // In the large one φ = 4 min(x, y, z) over the small one; 0.1 plus a quarter of 0.1 is the mean of
        // each coordinate.
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

    /// The energy is continuous where any point of a face goes through the centroid of the other tetrahedron.
    #[test]
    fn a_face_through_the_centroid_is_as_one_that_passes_near() {
        for (number, [a, b]) in (0..).zip(pairs(400)) {
            let centroid: Point<3> =
                std::array::from_fn(|axis| b.iter().map(|corner| 0.25 * corner[axis]).sum());
            let face = FACES[number as usize % 4].map(|corner| a[corner]);
            let [u, v] = [0, 1].map(|k| 0.5 * uniform(number, k));
            let normal = unit(cross3(minus(face[1], face[0]), minus(face[2], face[0])));
            let energy = |beyond: f64| {
                let moved = |axis: usize| {
                    let [p, q, r] = face.map(|corner| corner[axis]);
                    centroid[axis] - (p + u * (q - p) + v * (r - p)) + beyond * normal[axis]
                };
                let by = [0, 1, 2].map(moved);
                let a = a.map(|corner| std::array::from_fn(|axis| corner[axis] + by[axis]));
                interaction(&a, &b).map_or(f64::NAN, |found| found.energy)
            };
            let through = energy(0.0);
            for shift in [1e-12, 1e-8, 1e-6, 3e-6, 1e-5, 1e-4] {
                let mean = 0.5 * (energy(shift) + energy(-shift));
                let off = (mean - through).abs() / through;
                assert!(off < 1e-7 + 1000.0 * shift * shift, "{number}, {shift}: {off:e}");
            }
        }
    }

    /// Two tetrahedra with faces in two planes, as at the sides of two blocks that stand on each other, also
    /// where another face goes through the centroid. Once, such a face counted twice or not at all, as
    /// coordinates were rounded.
    #[test]
    fn faces_in_one_plane_count_once() {
        let target = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        for (x, bound) in [(0.95, 1e-10), (0.9999, 1e-8), (1.0, 1e-8)] {
            let contactor = [[x, 0.0, 0.0], [9.0, 0.0, 0.0], [x, 9.0, 0.0], [x, 0.0, 9.0]];
            let energy = |angle: f64| {
                let ([s, c], [t, d]) =
                    ([angle.sin(), angle.cos()], [(0.7 * angle).sin(), (0.7 * angle).cos()]);
                let turned = |shape: Tetrahedron| {
                    shape.map(|[x, y, z]| {
                        let (x, y) = (c * x - s * y, s * x + c * y);
                        [x, d * y - t * z, t * y + d * z]
                    })
                };
                interaction(&turned(contactor), &turned(target)).map_or(f64::NAN, |found| found.energy)
            };
            let straight = energy(0.0);
            for k in 1..500 {
                let found = energy(0.01 * f64::from(k));
                assert!((found - straight).abs() < bound * straight, "{x} {k}: {found} {straight}");
            }
        }
    }

    /// On a face in the plane where two coordinates of the other tetrahedron are the same, each part counts
    /// once.
    #[test]
    fn a_face_in_the_middle_plane_of_an_edge_is_as_one_beside_it() {
        let target = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let contactor = |by: f64| {
            [[-9.0, -9.0, -9.0], [9.0, 9.0, -9.0], [0.0, 0.0, 18.0], [9.0, -9.0, 0.0]]
                .map(|[x, y, z]| [x + by, y - by, z])
        };
        let contactor = |by: f64| {
            let shape = contactor(by);
            if VolumeCoordinates::of(&shape).six_volumes > 0.0 {
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

    /// No face parts two tetrahedra whose edges cross at a distance. The function returns a lower bound of
    /// the distance, positive whenever the tetrahedra are apart.
    #[test]
    fn the_distance_of_tetrahedra_whose_edges_cross() {
        let below = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, -1.0]];
        let below = if VolumeCoordinates::of(&below).six_volumes > 0.0 {
            below
        } else {
            [below[1], below[0], below[2], below[3]]
        };
        let above = below.map(|[x, y, z]| [y, x, 0.1 - z]);
        let above = if VolumeCoordinates::of(&above).six_volumes > 0.0 {
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
