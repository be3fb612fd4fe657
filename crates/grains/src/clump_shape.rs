//! Clumps of one shape: their spheres in a frame of their own, which are scaled, turned and moved.

use std::f64::consts::{PI, TAU};

use fdem_scenes::random::Random;

use crate::clump::ClumpInertia;
use crate::rotation::{UNTURNED, applied, matrix, turned_by};
use crate::vector::{Vector, dot, length, minus, plus, times};

/// Stream of a seed from which orientations are drawn.
const TURNS: u64 = 6;

/// Steps in which the sphere around a clump is found.
const AROUND: u32 = 2000;

/// The shape of clumps: spheres, or discs in the plane z = 0, in the frame of the shape.
#[derive(Clone, Debug, PartialEq)]
pub struct ClumpShape {
    centres: Vec<Vector>,
    radii: Vec<f64>,
    /// Thickness of discs, m.
    discs: Option<f64>,
    /// Mass, centre and moments of inertia of the unscaled shape with a density of 1. Discs have a thickness
    /// of 1.
    unit: ClumpInertia,
    /// A sphere around all: centre and radius, m.
    around: (Vector, f64),
}

impl ClumpShape {
    /// A shape of spheres, or of discs with a thickness, m, by their centres and radii, m.
    ///
    /// # Cost
    /// The same as the cost of [`ClumpInertia::of_spheres`].
    pub fn new(centres: Vec<[f64; 3]>, radii: Vec<f64>, discs: Option<f64>) -> Self {
        let unit = match discs {
            Some(_) => ClumpInertia::of_discs(&centres, &radii, 1.0, 1.0),
            None => ClumpInertia::of_spheres(&centres, &radii, 1.0),
        };
        let around = around(&centres, &radii);
        Self { centres, radii, discs, unit, around }
    }

    /// Radius of the sphere of the same volume, or of the disc of the same area, m.
    pub fn equal_radius(&self) -> f64 {
        match self.discs {
            Some(_) => (self.unit.mass / PI).sqrt(),
            None => libm::cbrt(0.75 * self.unit.mass / PI),
        }
    }

    /// Radius of a sphere around all spheres, m; hardly larger than that of the smallest one.
    pub fn outer_radius(&self) -> f64 {
        self.around.1
    }

    /// Number of spheres.
    pub fn count(&self) -> usize {
        self.radii.len()
    }

    /// The place of the origin of a clump, m, for which the sphere around it has its centre at `centre`; as
    /// in [`ClumpShape::placed`].
    pub fn origin(&self, centre: [f64; 3], turn: [f64; 3], scale: f64) -> [f64; 3] {
        minus(centre, applied(&matrix(turned_by(UNTURNED, turn)), times(scale, self.around.0)))
    }

    /// Whether the spheres touch each other, or chains of others between them.
    pub fn is_one_piece(&self) -> bool {
        let mut is_found: Vec<bool> = (0..self.centres.len()).map(|sphere| sphere == 0).collect();
        let mut open: Vec<usize> = (0..self.centres.len().min(1)).collect();
        while let Some(from) = open.pop() {
            for (other, found) in is_found.iter_mut().enumerate() {
                let apart = minus(self.centres[other], self.centres[from]);
                // Spheres that touch may miss each other by rounding.
                let reach = (1.0 + 1e-9) * (self.radii[from] + self.radii[other]);
                if !*found && dot(apart, apart) <= reach * reach {
                    *found = true;
                    open.push(other);
                }
            }
        }
        is_found.into_iter().all(|found| found)
    }

    /// Centres and radii, m, of the spheres of a clump: the shape times `scale`, turned about its origin by a
    /// vector, whose length is the angle, rad, with the origin at a place, m.
    pub fn placed(&self, at: [f64; 3], turn: [f64; 3], scale: f64) -> Vec<([f64; 3], f64)> {
        let turn = matrix(turned_by(UNTURNED, turn));
        let place = |&centre: &Vector| plus(at, applied(&turn, times(scale, centre)));
        self.centres.iter().map(place).zip(self.radii.iter().map(|radius| scale * radius)).collect()
    }

    /// Mass, centre and moments of inertia of such a clump with a density, kg/m³.
    pub fn inertia(&self, at: [f64; 3], turn: [f64; 3], scale: f64, density: f64) -> ClumpInertia {
        let (square, ClumpInertia { mass, centre, moments }) = (scale * scale, self.unit);
        let scaled = match self.discs {
            None => {
                let cube = density * square * scale;
                let moments = moments.map(|row| row.map(|moment| cube * square * moment));
                ClumpInertia { mass: cube * mass, centre: times(scale, centre), moments }
            }
            Some(thickness) => {
                let plate = density * thickness * square;
                let mut all = moments;
                for (row, moments) in all.iter_mut().enumerate() {
                    for (column, moment) in moments.iter_mut().enumerate() {
                        // The part of the moments about axes in the plane that the thickness causes.
                        let across = if row == column && row < 2 { mass / 12.0 } else { 0.0 };
                        *moment = plate * (square * (*moment - across) + thickness * thickness * across);
                    }
                }
                ClumpInertia { mass: plate * mass, centre: times(scale, centre), moments: all }
            }
        };
        scaled.turned(turn).moved(at)
    }
}

/// Centre and radius, m, of a sphere around spheres.
fn around(centres: &[Vector], radii: &[f64]) -> (Vector, f64) {
    let farthest = |from: Vector| {
        centres.iter().zip(radii).fold((0.0, from), |far, (&centre, radius)| {
            let arm = minus(centre, from);
            let away = length(arm);
            let end = if away > 0.0 { plus(centre, times(radius / away, arm)) } else { from };
            if away + radius > far.0 { (away + radius, end) } else { far }
        })
    };
    let sum = centres.iter().fold([0.0; 3], |sum, &centre| plus(sum, centre));
    let mut centre = times(1.0 / centres.len().max(1) as f64, sum);
    let (mut radius, mut end) = farthest(centre);
    let mut best = (centre, radius);
    // Steps towards the farthest point, each smaller than the one before (Badoiu and Clarkson 2003).
    for step in 1..=AROUND {
        centre = plus(centre, times(1.0 / f64::from(step + 1), minus(end, centre)));
        (radius, end) = farthest(centre);
        if radius < best.1 {
            best = (centre, radius);
        }
    }
    best
}

/// Random rotations, all equally likely: vectors whose length is the angle, rad; `discs` turn in the plane.
pub fn random_turns(count: usize, discs: bool, seed: u64) -> Vec<[f64; 3]> {
    let mut random = Random::with_stream(seed, TURNS);
    let mut turn = || {
        if discs {
            return [0.0, 0.0, TAU * random.uniform()];
        }
        // A random point of the unit sphere in four dimensions (Shoemake 1992).
        let share = random.uniform();
        let [one, other] = [TAU * random.uniform(), TAU * random.uniform()];
        let [outer, inner] = [(1.0 - share).sqrt(), share.sqrt()];
        let axis = [outer * libm::sin(one), outer * libm::cos(one), inner * libm::sin(other)];
        let size = length(axis);
        let angle = 2.0 * libm::atan2(size, inner * libm::cos(other));
        if size > 0.0 { times(angle / size, axis) } else { [0.0; 3] }
    };
    (0..count).map(|_| turn()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64, bound: f64) {
        assert!((found - expected).abs() < bound, "{found} {expected}");
    }

    fn all_near(found: &ClumpInertia, expected: &ClumpInertia, bound: f64) {
        near(found.mass, expected.mass, bound);
        for i in 0..3 {
            near(found.centre[i], expected.centre[i], bound);
            (0..3).for_each(|k| near(found.moments[i][k], expected.moments[i][k], bound));
        }
    }

    #[test]
    fn a_placed_clump_has_the_inertia_of_its_spheres() {
        let shape = ClumpShape::new(vec![[0.0; 3], [0.8, 0.1, 0.3]], vec![1.0, 0.7], None);
        let (at, turn, scale) = ([1.0, -2.0, 0.5], [0.4, 1.1, -0.3], 1.3);
        let (centres, radii): (Vec<_>, Vec<_>) = shape.placed(at, turn, scale).into_iter().unzip();
        let found = shape.inertia(at, turn, scale, 2.0);
        all_near(&found, &ClumpInertia::of_spheres(&centres, &radii, 2.0), 2e-3);
        near(4.0 / 3.0 * PI * shape.equal_radius().powi(3), found.mass / (2.0 * 1.3_f64.powi(3)), 1e-12);
    }

    #[test]
    fn a_placed_clump_of_discs_has_the_inertia_of_its_discs() {
        let shape = ClumpShape::new(vec![[0.0; 3], [0.8, 0.1, 0.0]], vec![1.0, 0.7], Some(0.4));
        let (at, turn, scale) = ([1.0, -2.0, 0.0], [0.0, 0.0, 0.9], 1.7);
        let (centres, radii): (Vec<_>, Vec<_>) = shape.placed(at, turn, scale).into_iter().unzip();
        let expected = ClumpInertia::of_discs(&centres, &radii, 3.0, 0.4);
        all_near(&shape.inertia(at, turn, scale, 3.0), &expected, 1e-3);
    }

    #[test]
    fn the_sphere_around_a_clump_is_tight() {
        let pair = ClumpShape::new(vec![[0.0; 3], [2.0, 0.0, 0.0]], vec![1.0, 1.0], None);
        assert_eq!(pair.around, ([1.0, 0.0, 0.0], 2.0));
        let three = vec![[0.0; 3], [3.0, 0.0, 0.0], [0.5, 0.2, 0.1]];
        let uneven = ClumpShape::new(three, vec![1.0, 0.5, 0.4], None);
        let (centre, radius) = uneven.around;
        near(radius, 2.25, 2e-3);
        near(centre[0], 1.25, 5e-3);
        let inner = ClumpShape::new(vec![[0.0; 3], [0.2, 0.0, 0.0]], vec![1.0, 0.3], None);
        near(inner.outer_radius(), 1.0, 1e-3);
    }

    #[test]
    fn pieces_are_found() {
        let of = |at: f64| ClumpShape::new(vec![[0.0; 3], [at, 0.0, 0.0]], vec![1.0, 1.0], None);
        assert!(of(2.0).is_one_piece() && !of(2.1).is_one_piece());
    }

    #[test]
    fn random_rotations_prefer_no_direction() {
        let turns = random_turns(4000, false, 3);
        for axis in 0..3 {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let turned = turns.iter().map(|&turn| applied(&matrix(turned_by(UNTURNED, turn)), unit));
            let sums =
                turned.fold([[0.0; 3]; 2], |[one, two], of| [plus(one, of), plus(two, of.map(|x| x * x))]);
            for (sum, of_squares) in sums[0].into_iter().zip(sums[1]) {
                near(sum / 4000.0, 0.0, 0.04);
                near(of_squares / 4000.0, 1.0 / 3.0, 0.03);
            }
        }
        assert!(random_turns(10, true, 1).iter().all(|turn| turn[..2] == [0.0; 2]));
    }
}
