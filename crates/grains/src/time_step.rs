//! The time step that follows the contacts of a model.

use crate::law::{ContactHistory, PairLaw};
use crate::material::ForceLaw;
use crate::model::{GrainModel, mass};
use crate::vector::{Vector, dot, length, minus, plus, times};
use crate::wall::WallShape;

/// Time step over the time in which a Rayleigh wave runs round a sphere, and over the duration of an impact.
const RAYLEIGH: f64 = 0.2;
const IMPACT: f64 = 0.02;

/// Time step over the duration of an impact at the speed of a fall through the whole model.
const FALL: f64 = 0.05;

/// Contacts of a sphere in a dense packing, for which a step is stable.
const CONTACTS: f64 = 10.0;

/// Sums over contacts, for which a step must be stable: of stiffness, 1/s², and of dashpots, 1/s, over the
/// inertia that they move.
///
/// The force across the normal at a step takes the slip of that step with the velocity at its end. For a
/// mode of motion with the stiffness `A` and the dashpots `C` the velocities then change by
/// `-(A/(1 - 1/z) dt² + C dt)(3 - 1/z)/2` in a step, where `z` is the factor from step to step. The root
/// `z = -1` is at `A dt²/2 + C dt = 1`; longer steps are unstable.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Response {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

impl Response {
    /// The longest stable step, s.
    pub(crate) fn longest_step(&self) -> f64 {
        2.0 / (self.damping + (self.damping * self.damping + 2.0 * self.stiffness).sqrt())
    }
}

impl GrainModel {
    /// A time step that follows the contacts, s: see [`GrainModel::shortest_step`].
    pub fn safe_step(&self) -> f64 {
        self.shortest_step(0.0).0
    }

    /// A time step that follows the contacts, s, and the sphere that sets it. Spheres that come in count
    /// after the others, in the order of the insertions. `others`: greatest speed of bodies, m/s.
    ///
    /// Hertz: a fifth of the time in which a Rayleigh wave runs round a sphere, a fiftieth of the impact of
    /// two such spheres at twice the greatest speed of the model and of bodies, and a twentieth of that at
    /// the speed of a fall through the box around all spheres and walls. Hooke: a fiftieth of the impact.
    /// Both: the longest step at which the springs and dashpots across ten contacts of a sphere are stable,
    /// under the weight of all spheres or the pressure that servos keep up. Infinite without spheres.
    pub fn shortest_step(&self, others: f64) -> (f64, u32) {
        let speed = self.greatest_speed().max(2.0 * others);
        let fall = self.fall();
        let kept = self.kept_pressure();
        let own = (0..self.spheres.positions.len())
            .map(|sphere| (self.spheres.radii[sphere], self.material_of(sphere)));
        let coming =
            self.insertions.iter().flat_map(|of| of.radii.iter().map(|&radius| (radius, of.material)));
        let laws: Vec<Vec<PairLaw>> =
            (0..self.materials.len() as u32).map(|of| self.rough_laws(of)).collect();
        let mut shortest = (f64::INFINITY, 0);
        for (number, (radius, material)) in (0..).zip(own.chain(coming)) {
            let Some(laws) = laws.get(material as usize) else { continue };
            let stable = self.stable_step(radius, material, laws, (fall, kept));
            let step = self.step_of(radius, material, [speed, fall]).min(stable);
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

    /// The laws of a material with friction.
    fn rough_laws(&self, material: u32) -> Vec<PairLaw> {
        let pairs = self.surfaces.iter().filter(|of| of.materials.contains(&material) && of.friction > 0.0);
        let laws = pairs.filter_map(|surfaces| {
            let [a, b] = surfaces.materials.map(|number| self.materials.get(number as usize));
            Some(PairLaw::new(self.law, [a?, b?], surfaces))
        });
        laws.collect()
    }

    /// The longest stable step of a sphere of a radius, m, and a material, s, with [`CONTACTS`] spheres like
    /// it around it, by the laws of its material. The pressure between them is that under a column of the
    /// spheres as high as a fall that ends at a speed, m/s, and the one that servos keep up, Pa.
    ///
    /// The fastest mode is the one in which all turn the same way: contacts slip by twice the radius, and two
    /// thirds of them lie across the axis.
    fn stable_step(&self, radius: f64, material: u32, laws: &[PairLaw], (fall, kept): (f64, f64)) -> f64 {
        let Some(of) = self.materials.get(material as usize) else { return f64::INFINITY };
        let pressure = 0.5 * of.density * fall * fall + kept;
        // Each of eight spheres in contact takes the pressure on two squares of the radius: twice the mean.
        let force = 4.0 * radius * radius * pressure;
        let mass = mass(radius, of.density, self.discs);
        let share = if self.discs.is_some() { 0.5 } else { 0.4 };
        let modes = 4.0 / 3.0 * CONTACTS / (share * mass);
        let steps = laws.iter().map(|law| {
            let contact = law.contact_under(force, 0.5 * radius);
            let history = ContactHistory { contact, ..ContactHistory::default() };
            let across = law.answer_across(&history, 0.5 * mass);
            let of = Response { stiffness: modes * across.stiffness, damping: modes * across.damping };
            of.longest_step()
        });
        steps.fold(f64::INFINITY, f64::min)
    }

    /// The largest pressure that servos keep up, Pa: of the box, and the force of walls over the section of
    /// the box around all spheres across them.
    fn kept_pressure(&self) -> f64 {
        let of_box = self.domain.and_then(|domain| domain.servo).into_iter().flat_map(|of| of.pressures);
        let (low, high) = self.extent();
        let sides = minus(high, low);
        let of_walls = self.walls.iter().filter_map(|wall| wall.servo).map(|servo| {
            let along = times(1.0 / length(servo.direction), servo.direction);
            let section = along[0].abs() * sides[1] * sides[2]
                + along[1].abs() * sides[2] * sides[0]
                + along[2].abs() * sides[0] * sides[1];
            if section > 0.0 { servo.force / section } else { 0.0 }
        });
        of_box.flatten().chain(of_walls).fold(0.0, f64::max)
    }

    /// The box around all spheres, m, and the regions where they come in.
    fn extent(&self) -> (Vector, Vector) {
        let own = (0..self.spheres.positions.len()).flat_map(|sphere| {
            let (place, radius) = (self.spheres.positions[sphere], self.spheres.radii[sphere]);
            [minus(place, [radius; 3]), plus(place, [radius; 3])]
        });
        let coming = self.insertions.iter().flat_map(|of| of.region);
        own.chain(coming).fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), place| {
            (
                [0, 1, 2].map(|axis| low[axis].min(place[axis])),
                [0, 1, 2].map(|axis| high[axis].max(place[axis])),
            )
        })
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
