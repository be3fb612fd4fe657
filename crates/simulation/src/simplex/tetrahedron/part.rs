//! Parts of faces, a batch of them side by side: a triangle, cut by up to four lines, and integrals over the
//! rest.
//!
//! A cut without a branch: a convex polygon is a list of a fixed number of corners, some of which may be the
//! same point. A line takes away one run of corners, around the polygon. It ends where the outline leaves the
//! kept side and begins again where it enters it: these two points are found by comparing each corner with
//! the next. In the list that is left, which has one corner more, the first of the run becomes the point
//! where the outline leaves, all others the point where it enters. Twin: `crates/gpu/kernels/contact.h`.

use crate::lanes::{Available, LANES, Lanes, Rows, compiled_for_vectors, either, larger, row, set_row};
use crate::vector::cross;

/// Most lines that cut a part.
pub(super) const CUTS: usize = 4;

/// Most corners: each line adds one to the triangle.
const MOST: usize = 3 + CUTS;

/// Numbers that are integrated over a part. The area of the face counts as 1: area, ∫ φ, ∫ φ β with the last
/// two barycentric coordinates β on the face, ∫ h with C = −1/12, and the largest φ.
pub(super) const NUMBERS: usize = 5;

/// A batch of parts.
pub(super) struct PartBatch {
    /// A quarter of φ at the corners of the face.
    potential: [Lanes; 3],
    /// Linear functions that are not negative on the part, by their values at the corners of the face.
    lines: [[Lanes; 3]; CUTS],
    /// The last two barycentric coordinates of the corners of the part on the face, before and after a cut.
    places: [Rows<2, MOST>; 2],
    signs: Signs,
    /// 0 where nothing is left of a part, else 1.
    left: Lanes,
    /// φ at the corners of the part.
    phi: [Lanes; MOST],
    numbers: [Lanes; NUMBERS],
}

impl PartBatch {
    pub(super) const NONE: Self = Self {
        potential: [Lanes::ZERO; 3],
        lines: [[Lanes::ZERO; 3]; CUTS],
        places: [[[Lanes::ZERO; 2]; MOST]; 2],
        signs: Signs::NONE,
        left: Lanes::ZERO,
        phi: [Lanes::ZERO; MOST],
        numbers: [Lanes::ZERO; NUMBERS],
    };

    /// Sets a quarter of φ at the corners of a face.
    #[inline]
    pub(super) fn set_potential(&mut self, lane: usize, values: [f64; 3]) {
        set_row(&mut self.potential, lane, &values);
    }

    /// Sets the values of a line at the corners of a face. The part lies where they are not negative.
    #[inline]
    pub(super) fn set_line(&mut self, lane: usize, number: usize, values: [f64; 3]) {
        set_row(&mut self.lines[number], lane, &values);
    }

    /// Adds the numbers of a part to sums, of which the last is the largest.
    #[inline]
    pub(super) fn add_to(&self, lane: usize, sums: &mut [Lanes; NUMBERS], own: usize) {
        for k in 0..NUMBERS - 1 {
            sums[k].set(own, sums[k].get(own) + self.numbers[k].get(lane));
        }
        let last = &mut sums[NUMBERS - 1];
        last.set(own, larger(last.get(own), self.numbers[NUMBERS - 1].get(lane)));
    }

    /// Computes parts that are cut by `cuts` lines.
    pub(super) fn compute(&mut self, available: Available, cuts: usize) {
        for (corner, place) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
            self.places[0][corner] = place.map(Lanes::all);
        }
        self.left = Lanes::all(1.0);
        match cuts {
            0 => integrals::<3, 0>(available, self),
            1 => {
                self.cut::<3, 0>(available);
                integrals::<4, 1>(available, self);
            }
            2 => {
                self.cut::<3, 0>(available);
                self.cut::<4, 1>(available);
                integrals::<5, 0>(available, self);
            }
            3 => {
                self.cut::<3, 0>(available);
                self.cut::<4, 1>(available);
                self.cut::<5, 0>(available);
                integrals::<6, 1>(available, self);
            }
            _ => {
                self.cut::<3, 0>(available);
                self.cut::<4, 1>(available);
                self.cut::<5, 0>(available);
                self.cut::<6, 1>(available);
                integrals::<7, 0>(available, self);
            }
        }
    }

    /// Cuts polygons of `M` corners by the next line.
    fn cut<const M: usize, const FROM: usize>(&mut self, available: Available) {
        let Self { lines, places, signs, left, .. } = self;
        let [one, other] = places;
        let (from, to) = if FROM == 0 { (&*one, other) } else { (&*other, one) };
        find_signs::<M>(available, &lines[M - 3], from, signs, left);
        // A line crosses the outline of a convex polygon twice. Rounding can let it cross more often, near
        // corners that coincide: the longest run is kept.
        for lane in 0..LANES {
            if signs.exits[lane] > 1 {
                keep_longest_run(&mut signs.kept[..M], lane);
            }
        }
        find_ends::<M>(available, from, signs);
        cuts::<M>(available, from, signs, to);
    }
}

/// On which side of a line the corners of a polygon are.
struct Signs {
    /// The values of the line at the corners, and all bits where they are not negative, else none.
    at: [Lanes; MOST],
    kept: [[u64; LANES]; MOST],
    /// How often the outline leaves the kept side.
    exits: [u64; LANES],
    /// Where it leaves that side, and where it enters it again.
    leaving: [Lanes; 2],
    entering: [Lanes; 2],
}

impl Signs {
    const NONE: Self = Self {
        at: [Lanes::ZERO; MOST],
        kept: [[0; LANES]; MOST],
        exits: [0; LANES],
        leaving: [Lanes::ZERO; 2],
        entering: [Lanes::ZERO; 2],
    };
}

compiled_for_vectors!(fn find_signs = all_signs<const M: usize>(
    line: &[Lanes; 3],
    from: &Rows<2, MOST>,
    signs: &mut Signs,
    left: &mut Lanes
));

/// Finds the side of the corners of polygons, and where none is kept.
#[inline(always)]
fn all_signs<const M: usize>(line: &[Lanes; 3], from: &Rows<2, MOST>, signs: &mut Signs, left: &mut Lanes) {
    for lane in 0..LANES {
        let [zero, one, two] = row(line, lane);
        let (one, two) = (one - zero, two - zero);
        let (mut first, mut before, mut some, mut exits) = (0, 0, 0, 0);
        for k in 0..M {
            let [x, y] = row(&from[k], lane);
            let at = zero + x * one + y * two;
            let kept = if at >= 0.0 { !0 } else { 0_u64 };
            signs.at[k].set(lane, at);
            signs.kept[k][lane] = kept;
            exits += before & !kept & 1;
            some |= kept;
            first = if k == 0 { kept } else { first };
            before = kept;
        }
        signs.exits[lane] = exits + (before & !first & 1);
        left.set(lane, either(some, left.get(lane), 0.0));
    }
}

/// Keeps only the longest run, around the polygon, of the corners that are kept.
#[cold]
fn keep_longest_run(kept: &mut [[u64; LANES]], lane: usize) {
    let count = kept.len();
    let length = |first: usize| (0..count).take_while(|k| kept[(first + k) % count][lane] != 0).count();
    // The first of the longest.
    let first = (0..count).rev().max_by_key(|&first| length(first)).unwrap_or(0);
    let run = length(first);
    for k in 0..count {
        let is_in = (k + count - first) % count < run;
        kept[k][lane] = if is_in { !0 } else { 0 };
    }
}

compiled_for_vectors!(fn find_ends = all_ends<const M: usize>(from: &Rows<2, MOST>, signs: &mut Signs));

/// Finds the points where the outlines of polygons of `M` corners leave and enter the kept side.
#[inline(always)]
fn all_ends<const M: usize>(from: &Rows<2, MOST>, signs: &mut Signs) {
    for lane in 0..LANES {
        let last = row(&from[M - 1], lane);
        // Where all or none are kept, both points are a corner.
        let (mut leaving, mut entering) = (Edge::at(last), Edge::at(last));
        for k in 0..M {
            let next = (k + 1) % M;
            let [own, other] = [signs.kept[k][lane], signs.kept[next][lane]];
            let edge = Edge {
                from: row(&from[k], lane),
                to: row(&from[next], lane),
                values: [signs.at[k].get(lane), signs.at[next].get(lane)],
            };
            leaving = edge.or(leaving, own & !other);
            entering = edge.or(entering, !own & other);
        }
        set_row(&mut signs.leaving, lane, &leaving.crossing());
        set_row(&mut signs.entering, lane, &entering.crossing());
    }
}

compiled_for_vectors!(fn cuts = all_cuts<const M: usize>(from: &Rows<2, MOST>, signs: &Signs, to: &mut Rows<2, MOST>));

/// Cuts polygons of `M` corners. The corners that are kept are one run.
#[inline(always)]
#[allow(clippy::range_plus_one, reason = "the compiler makes no vectors of a loop over an inclusive range")]
fn all_cuts<const M: usize>(from: &Rows<2, MOST>, signs: &Signs, to: &mut Rows<2, MOST>) {
    let Signs { kept, leaving, entering, .. } = signs;
    // Whether all corners before are kept, and whether one of them is.
    let (mut all, mut some) = ([!0; LANES], [0; LANES]);
    for k in 0..M + 1 {
        let (here, before) = (k.min(M - 1), k.max(1) - 1);
        let [is_there, has_before] = [k < M, k > 0].map(|is| if is { !0 } else { 0_u64 });
        let [from, moved] = [&from[here], &from[before]];
        for lane in 0..LANES {
            let (own, before) = (kept[here][lane] & is_there, kept[before][lane] & has_before);
            // Where the first corner is kept, the corners after the run move by one place.
            let turns = kept[0][lane];
            let keeps = own & (all[lane] | !turns);
            let leaves = !own & ((turns & all[lane]) | (!turns & some[lane]));
            let moves = turns & !all[lane] & before;
            let point = either_point(moves, row(moved, lane), row(entering, lane));
            let point = either_point(leaves, row(leaving, lane), point);
            set_row(&mut to[k], lane, &either_point(keeps, row(from, lane), point));
            all[lane] &= own;
            some[lane] |= own;
        }
    }
}

/// One of two points.
#[inline(always)]
fn either_point(mask: u64, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> [f64; 2] {
    [either(mask, x, u), either(mask, y, v)]
}

/// An edge of a polygon, and the values of a line at its ends.
#[derive(Clone, Copy)]
struct Edge {
    from: [f64; 2],
    to: [f64; 2],
    values: [f64; 2],
}

impl Edge {
    /// An edge whose crossing is this point.
    #[inline(always)]
    fn at(point: [f64; 2]) -> Self {
        Self { from: point, to: point, values: [1.0, 0.0] }
    }

    /// This edge where the mask is set, else the other.
    #[inline(always)]
    fn or(self, other: Self, mask: u64) -> Self {
        Self {
            from: either_point(mask, self.from, other.from),
            to: either_point(mask, self.to, other.to),
            values: either_point(mask, self.values, other.values),
        }
    }

    /// The point where the line is zero.
    #[inline(always)]
    fn crossing(self) -> [f64; 2] {
        let ([x, y], [u, v], [a, b]) = (self.from, self.to, self.values);
        let share = a / (a - b);
        [x + share * (u - x), y + share * (v - y)]
    }
}

compiled_for_vectors!(fn integrals = all_integrals<const M: usize, const FROM: usize>(parts: &mut PartBatch));

/// Integrates over polygons of `M` corners, on which φ is linear.
#[inline(always)]
fn all_integrals<const M: usize, const FROM: usize>(parts: &mut PartBatch) {
    let PartBatch { potential, places, left, phi, numbers, .. } = parts;
    let places = &places[FROM];
    for lane in 0..LANES {
        let [zero, one, two] = row(potential, lane);
        let (one, two) = (one - zero, two - zero);
        let mut most = 0.0;
        for k in 0..M {
            let [x, y] = row(&places[k], lane);
            let at = larger(4.0 * (zero + x * one + y * two), 0.0);
            phi[k].set(lane, at);
            most = larger(most, at);
        }
        set_row(numbers, lane, &[0.0, 0.0, 0.0, 0.0, most]);
    }
    for k in 2..M {
        let corners = [&places[0], &places[k - 1], &places[k]];
        let phi = [&phi[0], &phi[k - 1], &phi[k]];
        for lane in 0..LANES {
            let [first, second, third] = corners.map(|corner| row(corner, lane));
            let [a, b, c] = phi.map(|phi| phi.get(lane));
            let from = |corner: [f64; 2]| [corner[0] - first[0], corner[1] - first[1]];
            let area = cross(from(second), from(third));
            let sum = a + b + c;
            let moment = |axis: usize| {
                let own = a * first[axis] + b * second[axis] + c * third[axis];
                area * (sum * (first[axis] + second[axis] + third[axis]) + own)
            };
            let (pairs, three) = (a * b + b * c + c * a, a * b * c);
            let w = (1.0 - a) * (1.0 - b) * (1.0 - c);
            let flux = area * (sum * sum - pairs - sum * pairs + three + sum * three) / w;
            let more = [area * sum, moment(0), moment(1), -flux];
            for number in 0..NUMBERS - 1 {
                numbers[number].set(lane, numbers[number].get(lane) + more[number]);
            }
        }
    }
    for lane in 0..LANES {
        let factors = [1.0 / 3.0, 1.0 / 12.0, 1.0 / 12.0, 1.0 / 12.0, 1.0];
        let left = left.get(lane) > 0.0;
        for k in 0..NUMBERS {
            numbers[k].set(lane, if left { factors[k] * numbers[k].get(lane) } else { 0.0 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::simplex::tetrahedron::piece::{ConvexPiece, CutTriangle, share_of};

    /// Values of four functions at the corners of a triangle, by seed. Every fourth triangle has values that
    /// are multiples of a fifth: lines through corners, and along edges.
    fn values(seed: u64) -> [[f64; 4]; 3] {
        std::array::from_fn(|corner| {
            std::array::from_fn(|k| {
                let value = uniform(seed, (4 * corner + k) as u64) - 0.4;
                if seed.is_multiple_of(4) { (5.0 * value).round() / 5.0 } else { value }
            })
        })
    }

    /// The numbers of the parts where the first functions are not negative, of one triangle in each lane.
    fn parts(seeds: std::ops::Range<u64>, lines: usize) -> Vec<[f64; NUMBERS]> {
        let mut parts = PartBatch::NONE;
        for (lane, seed) in seeds.enumerate() {
            let values = values(seed);
            let of = |k: usize| values.map(|at| at[k]);
            parts.set_potential(lane, of(0).map(|value| 0.1 * value));
            for line in 0..lines {
                parts.set_line(lane, line, of(line));
            }
        }
        parts.compute(Available::best(), lines);
        (0..LANES)
            .map(|lane| {
                let mut sums = [Lanes::ZERO; NUMBERS];
                parts.add_to(lane, &mut sums, 0);
                row(&sums, 0)
            })
            .collect()
    }

    #[test]
    fn a_part_is_what_cuts_one_by_one_leave() {
        for lines in 0..=CUTS {
            let mut empty = 0;
            for first in (0..4000).step_by(LANES) {
                let found = parts(first..first + LANES as u64, lines);
                for (seed, found) in (first..).zip(found) {
                    let mut pieces = CutTriangle::of(&values(seed));
                    let mut left = ConvexPiece::WHOLE;
                    for line in 0..lines {
                        left = pieces.cut(&left, |at| at[line]);
                    }
                    let corners: Vec<_> = pieces.corners(&left).copied().collect();
                    let (mut area, mut potential, mut most) = (0.0, 0.0, 0.0_f64);
                    for k in 2..corners.len() {
                        let three = [&corners[0], &corners[k - 1], &corners[k]];
                        let phi = three.map(|corner| 4.0 * (0.1 * corner.values[0]).max(0.0));
                        area += share_of(three);
                        potential += share_of(three) / 3.0 * (phi[0] + phi[1] + phi[2]);
                        most = phi.into_iter().fold(most, f64::max);
                    }
                    empty += usize::from(area == 0.0);
                    assert!((found[0] - potential).abs() < 1e-14, "{lines} {seed}: {} {potential}", found[0]);
                    if area > 1e-12 {
                        assert!((found[4] - most).abs() < 1e-14, "{lines} {seed}: {} {most}", found[4]);
                    }
                }
            }
            assert!(lines == 0 || empty > 100 && empty < 3900, "{lines}: {empty}");
        }
    }

    #[test]
    fn only_the_longest_run_is_kept() {
        let kept = |bits: [u64; 6]| {
            let mut kept = bits.map(|bit| [bit * !0; LANES]);
            keep_longest_run(&mut kept, 3);
            assert_eq!(kept.map(|at| at[2]), bits.map(|bit| bit * !0), "another lane");
            kept.map(|at| at[3] & 1)
        };
        assert_eq!(kept([1, 0, 1, 1, 0, 0]), [0, 0, 1, 1, 0, 0]);
        assert_eq!(kept([1, 0, 1, 0, 1, 1]), [1, 0, 0, 0, 1, 1]);
        assert_eq!(kept([1, 0, 1, 0, 0, 0]), [1, 0, 0, 0, 0, 0]);
        assert_eq!(kept([0, 0, 1, 1, 1, 1]), [0, 0, 1, 1, 1, 1]);
    }
}
