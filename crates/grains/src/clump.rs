//! Clumps: spheres that overlap and move as one rigid body.
//!
//! The mass of a clump and its moments of inertia are those of the union of its spheres, in which places that
//! several spheres cover count once. They are found as the sum of the spheres, which is exact, less the parts
//! that are covered more than once, along parallel lines. Along a line everything is exact.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::rotation::{Matrix, UNTURNED, matrix, turned_by};
use crate::vector::{Vector, minus, plus, times};

/// Lines along an axis on which the union of spheres, or of discs, is found.
const LINES: [usize; 2] = [256, 4096];

/// Spheres of a model that move as one rigid body. They do not touch each other.
///
/// Their contacts with others follow the laws of spheres, with the mass of the whole clump.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clump {
    /// Numbers of its spheres, ascending. The clump is held if all of them are.
    pub spheres: Vec<u32>,
    /// Velocity of its centre of mass, m/s. Its spheres have none of their own in the model.
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
    /// Mass, centre and moments of inertia; `None` for those of the union of its spheres, which then must
    /// have one density.
    pub inertia: Option<ClumpInertia>,
}

/// Mass, centre of mass and moments of inertia of a clump.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClumpInertia {
    /// kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre: [f64; 3],
    /// Moments of inertia about the centre of mass, kg m²: the rows of a symmetric matrix.
    pub moments: [[f64; 3]; 3],
}

impl ClumpInertia {
    /// The union of spheres of one density, kg/m³: exact if they do not overlap, and within about 1e-5 of the
    /// mass if they do.
    ///
    /// # Cost
    /// About a millisecond for a few spheres that overlap. Clumps of one shape share the result, see
    /// [`ClumpInertia::turned`].
    pub fn of_spheres(centres: &[[f64; 3]], radii: &[f64], density: f64) -> Self {
        Integrals::of_spheres(centres, radii).inertia(density, 0.0)
    }

    /// The union of discs in the plane z = 0 with a thickness, m, and one density, kg/m³.
    pub fn of_discs(centres: &[[f64; 3]], radii: &[f64], density: f64, thickness: f64) -> Self {
        Integrals::of_discs(centres, radii).inertia(density * thickness, thickness)
    }

    /// The same clump, turned about the origin by a vector: its length is the angle, rad.
    #[must_use]
    pub fn turned(&self, vector: [f64; 3]) -> Self {
        let turn = matrix(turned_by(UNTURNED, vector));
        let column = |k: usize| [turn[0][k], turn[1][k], turn[2][k]];
        // Of R M R': rows of R M first.
        let half: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|k| (0..3).map(|j| turn[i][j] * self.moments[j][k]).sum())
        });
        let entry = |i: usize, k: usize| (0..3).map(|j| half[i][j] * turn[k][j]).sum();
        Self {
            mass: self.mass,
            centre: (0..3).fold([0.0; 3], |sum, k| plus(sum, times(self.centre[k], column(k)))),
            moments: std::array::from_fn(|i| std::array::from_fn(|k| entry(i.min(k), i.max(k)))),
        }
    }

    /// The same clump, moved, m.
    #[must_use]
    pub fn moved(&self, by: [f64; 3]) -> Self {
        Self { centre: plus(self.centre, by), ..*self }
    }
}

/// Integrals over a body, about a point.
#[derive(Clone, Copy, Debug)]
struct Integrals {
    about: Vector,
    /// Of 1, m³ in space.
    volume: f64,
    /// Of x, y and z.
    first: Vector,
    /// Of xx, yy, zz, xy, yz and zx.
    second: [f64; 6],
}

impl Integrals {
    fn about(about: Vector) -> Self {
        Self { about, volume: 0.0, first: [0.0; 3], second: [0.0; 6] }
    }

    fn of_spheres(centres: &[Vector], radii: &[f64]) -> Self {
        let [low, high] = bounds(centres, radii);
        let middle = times(0.5, plus(low, high));
        let mut sum = Self::about(middle);
        for (&centre, &radius) in centres.iter().zip(radii) {
            let volume = 4.0 / 3.0 * PI * radius * radius * radius;
            sum.add(volume, minus(centre, middle), [0.2 * volume * radius * radius; 3]);
        }
        if !overlap(centres, radii) {
            return sum;
        }
        let [wide, high] = [1, 2].map(|axis| (high[axis] - low[axis]) / LINES[0] as f64);
        for row in 0..LINES[0] {
            for column in 0..LINES[0] {
                let y = low[1] + (column as f64 + 0.5) * wide;
                let z = low[2] + (row as f64 + 0.5) * high;
                let half = |centre: &Vector, radius: f64| {
                    radius * radius - (y - centre[1]).powi(2) - (z - centre[2]).powi(2)
                };
                sum.take_line(centres, radii, half, ([y, z], [wide, high]));
            }
        }
        sum
    }

    fn of_discs(centres: &[Vector], radii: &[f64]) -> Self {
        let [low, high] = bounds(centres, radii);
        let middle = times(0.5, [low[0] + high[0], low[1] + high[1], 0.0]);
        let mut sum = Self::about(middle);
        for (&[x, y, _], &radius) in centres.iter().zip(radii) {
            let area = PI * radius * radius;
            let own = 0.25 * area * radius * radius;
            sum.add(area, minus([x, y, 0.0], middle), [own, own, 0.0]);
        }
        if !overlap(centres, radii) {
            return sum;
        }
        let wide = (high[1] - low[1]) / LINES[1] as f64;
        for column in 0..LINES[1] {
            let y = low[1] + (column as f64 + 0.5) * wide;
            let half = |centre: &Vector, radius: f64| radius * radius - (y - centre[1]).powi(2);
            sum.take_line(centres, radii, half, ([y, 0.0], [wide, 0.0]));
        }
        sum
    }

    /// Adds a body with its centre and its integrals of xx, yy and zz about that.
    fn add(&mut self, volume: f64, [x, y, z]: Vector, own: Vector) {
        self.volume += volume;
        self.first = plus(self.first, times(volume, [x, y, z]));
        let products = [x * x, y * y, z * z, x * y, y * z, z * x];
        for (k, (sum, product)) in self.second.iter_mut().zip(products).enumerate() {
            *sum += volume * product + own.get(k).copied().unwrap_or(0.0);
        }
    }

    /// Subtracts the parts of a line along x that are covered more than once. `square`: the square of half of
    /// the part of the line in a sphere; the line has this place and these widths along y and z, m.
    fn take_line(
        &mut self,
        centres: &[Vector],
        radii: &[f64],
        square: impl Fn(&Vector, f64) -> f64,
        ([y, z], widths): ([f64; 2], [f64; 2]),
    ) {
        let mut parts: Vec<[f64; 2]> = Vec::new();
        for (centre, &radius) in centres.iter().zip(radii) {
            let square = square(centre, radius);
            if square > 0.0 {
                let half = square.sqrt();
                parts.push([centre[0] - half, centre[0] + half].map(|x| x - self.about[0]));
            }
        }
        if parts.len() < 2 {
            return;
        }
        parts.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let (y, z) = (y - self.about[1], z - self.about[2]);
        // In the plane a line has no width along z.
        let area = if widths[1] > 0.0 { widths[0] * widths[1] } else { widths[0] };
        let own = widths.map(|width| width * width / 12.0);
        let mut end = parts[0][1];
        for &[begin, own_end] in &parts[1..] {
            let covered = end.min(own_end);
            if covered > begin {
                let [a, b] = [begin, covered];
                let volume = area * (b - a);
                let first = area * 0.5 * (b * b - a * a);
                let squares = area * (b * b * b - a * a * a) / 3.0;
                self.volume -= volume;
                self.first = minus(self.first, [first, volume * y, volume * z]);
                let products = [
                    squares,
                    volume * (y * y + own[0]),
                    volume * (z * z + own[1]),
                    first * y,
                    volume * y * z,
                    first * z,
                ];
                for (sum, product) in self.second.iter_mut().zip(products) {
                    *sum -= product;
                }
            }
            end = end.max(own_end);
        }
    }

    /// Mass, centre and moments of inertia, with a thickness of a plane, m.
    fn inertia(&self, density: f64, thickness: f64) -> ClumpInertia {
        let centre = times(1.0 / self.volume, self.first);
        let [x, y, z] = centre;
        let products = [x * x, y * y, z * z, x * y, y * z, z * x];
        let mut own = self.second;
        for (sum, product) in own.iter_mut().zip(products) {
            *sum -= self.volume * product;
        }
        own[2] += self.volume * thickness * thickness / 12.0;
        let [xx, yy, zz, xy, yz, zx] = own.map(|integral| density * integral);
        ClumpInertia {
            mass: density * self.volume,
            centre: plus(self.about, centre),
            moments: [[yy + zz, -xy, -zx], [-xy, xx + zz, -yz], [-zx, -yz, xx + yy]],
        }
    }
}

/// The lowest and the highest corner of a box around spheres, m.
fn bounds(centres: &[Vector], radii: &[f64]) -> [Vector; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (centre, &radius) in centres.iter().zip(radii) {
        for axis in 0..3 {
            low[axis] = low[axis].min(centre[axis] - radius);
            high[axis] = high[axis].max(centre[axis] + radius);
        }
    }
    [low, high]
}

/// Whether any two spheres overlap.
fn overlap(centres: &[Vector], radii: &[f64]) -> bool {
    (0..centres.len()).any(|i| {
        (0..i).any(|k| {
            let apart = minus(centres[i], centres[k]);
            let (sum, square) = (radii[i] + radii[k], crate::vector::dot(apart, apart));
            square < sum * sum
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64, bound: f64) {
        assert!((found - expected).abs() < bound, "{found} {expected}");
    }

    #[test]
    fn spheres_that_are_apart_are_exact() {
        let of = ClumpInertia::of_spheres(&[[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0]], &[1.0, 1.0], 3.0);
        let mass = 4.0 * PI;
        near(of.mass, 2.0 * mass, 1e-13);
        assert_eq!(of.centre, [0.0, 0.0, 2.0]);
        near(of.moments[0][0], 0.8 * mass, 1e-13);
        near(of.moments[1][1], 0.8 * mass + 2.0 * mass, 1e-13);
        assert_eq!(of.moments[0][1], 0.0);
    }

    /// Two spheres with a lens in common, along each axis and along a diagonal: volume and moments of caps.
    #[test]
    fn the_lens_of_two_spheres_counts_once() {
        // Each sphere of radius 1 has its part beyond the plane between them, at -h of its centre along it.
        let h = 0.4_f64;
        // Of the part of a sphere of radius 1 with x > -h: volume, and integrals of x, x², y².
        let volume = PI * (2.0 / 3.0 + h - h.powi(3) / 3.0);
        let first = PI * (0.25 - (h * h / 2.0 - h.powi(4) / 4.0));
        let xx = PI * (2.0 / 15.0 + h.powi(3) / 3.0 - h.powi(5) / 5.0);
        let yy = 0.25 * PI * (8.0 / 15.0 + h - 2.0 * h.powi(3) / 3.0 + h.powi(5) / 5.0);
        let along = 2.0 * (xx + 2.0 * h * first + h * h * volume);
        let across = 2.0 * yy;
        for direction in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.48, 0.6, -0.64]] {
            let shift = [5.0, -7.0, 3.0];
            let centres = [times(h, direction), times(-h, direction)].map(|at| plus(at, shift));
            let of = ClumpInertia::of_spheres(&centres, &[1.0; 2], 1.0);
            near(of.mass, 2.0 * volume, 2e-5 * volume);
            assert!((0..3).all(|k| (of.centre[k] - shift[k]).abs() < 1e-5), "{:?}", of.centre);
            let moment = |axis: Vector| {
                let row = of.moments.map(|row| crate::vector::dot(row, axis));
                crate::vector::dot(row, axis)
            };
            near(moment(direction), 2.0 * across, 5e-5);
            let other = [-direction[1], direction[0], 0.0];
            let other = if direction[2] == 1.0 { [1.0, 0.0, 0.0] } else { other };
            let other = times(1.0 / crate::vector::length(other), other);
            near(moment(other), across + along, 5e-5);
        }
    }

    #[test]
    fn a_sphere_within_another_and_one_twice_count_once() {
        let lone = ClumpInertia::of_spheres(&[[0.0; 3]], &[1.0], 1.0);
        for (centre, radius) in [([0.0; 3], 1.0), ([0.2, 0.1, -0.1], 0.5)] {
            let of = ClumpInertia::of_spheres(&[[0.0; 3], centre], &[1.0, radius], 1.0);
            near(of.mass, lone.mass, 1e-4);
            for k in 0..3 {
                near(of.moments[k][k], lone.moments[k][k], 1e-4);
                near(of.centre[k], 0.0, 1e-5);
            }
        }
    }

    #[test]
    fn discs_have_the_moments_of_the_plane() {
        let thickness = 0.5;
        let lone = ClumpInertia::of_discs(&[[3.0, 4.0, 0.0]], &[2.0], 10.0, thickness);
        near(lone.mass, 20.0 * PI, 1e-12);
        near(lone.moments[2][2], 40.0 * PI, 1e-12);
        assert_eq!(lone.centre, [3.0, 4.0, 0.0]);
        // Two discs of radius 1, at -h and h: each has a segment beyond the line between them.
        let h = 0.3_f64;
        let of = ClumpInertia::of_discs(&[[h, 0.0, 0.0], [-h, 0.0, 0.0]], &[1.0; 2], 1.0, 1.0);
        let lens = 2.0 * (h.acos() - h * (1.0 - h * h).sqrt());
        near(of.mass, 2.0 * PI - lens, 1e-6);
        let turned = ClumpInertia::of_discs(&[[0.0, h, 0.0], [0.0, -h, 0.0]], &[1.0; 2], 1.0, 1.0);
        near(of.moments[2][2], turned.moments[2][2], 1e-5);
    }

    #[test]
    fn a_turned_clump_has_turned_moments() {
        let centres = [[0.0; 3], [0.8, 0.1, 0.0], [0.2, 0.9, 0.4]];
        let radii = [1.0, 0.7, 0.6];
        let of = ClumpInertia::of_spheres(&centres, &radii, 2.0);
        let vector = [0.3, -0.8, 0.5];
        let turn = matrix(turned_by(UNTURNED, vector));
        let shift = [1.0, 2.0, 3.0];
        let other = centres.map(|at| plus(crate::rotation::applied(&turn, at), shift));
        let expected = ClumpInertia::of_spheres(&other, &radii, 2.0);
        let found = of.turned(vector).moved(shift);
        near(found.mass, expected.mass, 1e-4);
        for i in 0..3 {
            near(found.centre[i], expected.centre[i], 1e-5);
            for k in 0..3 {
                near(found.moments[i][k], expected.moments[i][k], 1e-4);
            }
        }
    }
}
