//! The time step that follows the contacts of a model.

use crate::material::ForceLaw;
use crate::model::{GrainModel, mass};
use crate::vector::{Vector, dot, length, minus};
use crate::wall::WallShape;

/// Time step over the time in which a Rayleigh wave runs round a sphere, and over the duration of an impact.
const RAYLEIGH: f64 = 0.2;
const IMPACT: f64 = 0.02;

/// Time step over the duration of an impact at the speed of a fall through the whole model.
const FALL: f64 = 0.05;

impl GrainModel {
    /// A time step that follows the contacts, s: see [`GrainModel::shortest_step`].
    pub fn safe_step(&self) -> f64 {
        self.shortest_step().0
    }

    /// A time step that follows the contacts, s, and the sphere that sets it. Spheres that come in count
    /// after the others, in the order of the insertions.
    ///
    /// Hertz: a fifth of the time in which a Rayleigh wave runs round a sphere, a fiftieth of the impact of
    /// two such spheres at twice the greatest speed of the model, and a twentieth of that at the speed of a
    /// fall through the box around all spheres and walls. Hooke: a fiftieth of the impact. Infinite without
    /// spheres.
    pub fn shortest_step(&self) -> (f64, u32) {
        let speed = self.greatest_speed();
        let fall = self.fall();
        let own = (0..self.spheres.positions.len())
            .map(|sphere| (self.spheres.radii[sphere], self.material_of(sphere)));
        let coming =
            self.insertions.iter().flat_map(|of| of.radii.iter().map(|&radius| (radius, of.material)));
        let mut shortest = (f64::INFINITY, 0);
        for (number, (radius, material)) in (0..).zip(own.chain(coming)) {
            let step = self.step_of(radius, material, [speed, fall]);
            if step < shortest.0 {
                shortest = (step, number);
            }
        }
        shortest
    }

    /// The step of a sphere of a radius, m, and a material, s; with these speeds, m/s.
    fn step_of(&self, radius: f64, material: u32, [speed, fall]: [f64; 2]) -> f64 {
        let Some(material) = self.materials.get(material as usize) else { return f64::INFINITY };
        let half = 0.5 * mass(radius, material.density, self.discs);
        if let ForceLaw::Hooke { normal, .. } = self.law {
            // A thirteenth of 2 √(m/12 k), the longest stable step among twelve neighbours.
            return IMPACT * std::f64::consts::PI * (half / normal).sqrt();
        }
        let (young, poisson) = (material.youngs_modulus, material.poissons_ratio);
        let shear = young / (2.0 * (1.0 + poisson));
        let wave =
            std::f64::consts::PI * radius * (material.density / shear).sqrt() / (0.1631 * poisson + 0.8766);
        let reduced = 0.5 * young / (1.0 - poisson * poisson);
        let impact = |speed: f64| {
            let depth =
                libm::pow(15.0 / 16.0 * half * speed * speed / (reduced * (0.5 * radius).sqrt()), 0.4);
            if speed > 0.0 { 2.9432 * depth / speed } else { f64::INFINITY }
        };
        (RAYLEIGH * wave).min(IMPACT * impact(speed)).min(FALL * impact(fall))
    }

    /// Twice the greatest speed of spheres, walls and spheres that come in, m/s.
    fn greatest_speed(&self) -> f64 {
        let of_walls = self.walls.iter().map(|wall| length(wall.velocity));
        let of_paths = self.walls.iter().flat_map(|wall| {
            wall.path.windows(2).map(|rows| length(minus(rows[1].1, rows[0].1)) / (rows[1].0 - rows[0].0))
        });
        let of_servos = self.walls.iter().filter_map(|wall| wall.servo).map(|servo| servo.speed);
        let of_spheres = self.spheres.velocities.iter().map(|&velocity| length(velocity));
        let coming = self.insertions.iter().map(|of| length(of.velocity));
        let all = of_walls.chain(of_paths).chain(of_servos).chain(of_spheres).chain(coming);
        2.0 * all.fold(0.0, f64::max)
    }

    /// Speed after a fall through the box around all spheres and the corners of walls, m/s.
    fn fall(&self) -> f64 {
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        let mut visit = |place: Vector| {
            let along = dot(self.gravity, place);
            ends = [ends[0].min(along), ends[1].max(along)];
        };
        self.spheres.positions.iter().for_each(|&place| visit(place));
        self.insertions.iter().flat_map(|of| of.region).for_each(&mut visit);
        for wall in &self.walls {
            match &wall.shape {
                WallShape::Plane { point, .. } => visit(*point),
                WallShape::Tube { axis, .. } | WallShape::Cone { axis, .. } => {
                    for &place in axis {
                        visit(place);
                    }
                }
                WallShape::Disc { centre, .. } => visit(*centre),
                WallShape::Mesh { triangles } => triangles.iter().flatten().for_each(|&place| visit(place)),
            }
        }
        // Half of the square of the speed is the difference of the potentials.
        if ends[1] > ends[0] { (2.0 * (ends[1] - ends[0])).sqrt() } else { 0.0 }
    }
}
