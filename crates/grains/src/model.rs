//! The model: spheres, walls and their materials.

use serde::{Deserialize, Serialize};

use crate::error::GrainError;
use crate::material::{ForceLaw, GrainMaterial, Surfaces};
use crate::wall::{Wall, WallShape};

/// Spheres, each list in the order of their numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spheres {
    /// Centres, m.
    pub positions: Vec<[f64; 3]>,
    /// m.
    pub radii: Vec<f64>,
    /// Velocities, m/s; empty for rest.
    pub velocities: Vec<[f64; 3]>,
    /// Angular velocities, rad/s; empty for none.
    pub spins: Vec<[f64; 3]>,
    /// Numbers of the materials; empty if all are of the first.
    pub materials: Vec<u32>,
    /// Whether a sphere stays where it is, or keeps its velocity and spin; empty if all are free.
    pub held: Vec<bool>,
}

/// Spheres and walls, complete. SI units: m, kg, s, Pa.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GrainModel {
    /// The spheres.
    pub spheres: Spheres,
    /// The walls.
    pub walls: Vec<Wall>,
    /// Materials of spheres and walls.
    pub materials: Vec<GrainMaterial>,
    /// Surfaces of all pairs of materials that may touch.
    pub surfaces: Vec<Surfaces>,
    /// The law of all contacts.
    pub law: ForceLaw,
    /// Acceleration, m/s².
    pub gravity: [f64; 3],
    /// Time step, s; `None` for [`GrainModel::safe_step`].
    pub step: Option<f64>,
}

/// Time step over the time in which a Rayleigh wave runs round a sphere, and over the duration of an impact.
const RAYLEIGH: f64 = 0.2;
const IMPACT: f64 = 0.02;

impl GrainModel {
    /// Number of the material of a sphere.
    pub(crate) fn material_of(&self, sphere: usize) -> u32 {
        self.spheres.materials.get(sphere).copied().unwrap_or(0)
    }

    /// Mass of a sphere, kg.
    pub(crate) fn mass_of(&self, sphere: usize) -> f64 {
        let radius = self.spheres.radii[sphere];
        4.0 / 3.0
            * std::f64::consts::PI
            * radius
            * radius
            * radius
            * self.materials[self.material_of(sphere) as usize].density
    }

    /// A time step that follows the contacts, s. Hertz: a fifth of the time in which a Rayleigh wave runs
    /// round a sphere, and a fiftieth of the impact of two such spheres at twice the greatest speed of the
    /// model. Hooke: a fiftieth of the impact.
    pub fn safe_step(&self) -> f64 {
        let speeds = self.spheres.velocities.iter().chain(self.walls.iter().map(|wall| &wall.velocity));
        let speed = 2.0 * speeds.map(|&velocity| crate::vector::length(velocity)).fold(0.0, f64::max);
        let of = |sphere: usize| {
            let (radius, half) = (self.spheres.radii[sphere], 0.5 * self.mass_of(sphere));
            let material = &self.materials[self.material_of(sphere) as usize];
            let (young, poisson) = (material.youngs_modulus, material.poissons_ratio);
            if let ForceLaw::Hooke { normal, .. } = self.law {
                return IMPACT * std::f64::consts::PI * (half / normal).sqrt();
            }
            let shear = young / (2.0 * (1.0 + poisson));
            let wave = std::f64::consts::PI * radius * (material.density / shear).sqrt()
                / (0.1631 * poisson + 0.8766);
            if speed == 0.0 {
                return RAYLEIGH * wave;
            }
            let reduced = 0.5 * young / (1.0 - poisson * poisson);
            let depth =
                libm::pow(15.0 / 16.0 * half * speed * speed / (reduced * (0.5 * radius).sqrt()), 0.4);
            (RAYLEIGH * wave).min(IMPACT * 2.9432 * depth / speed)
        };
        (0..self.spheres.positions.len()).map(of).fold(f64::INFINITY, f64::min)
    }

    /// Checks all numbers.
    ///
    /// # Errors
    /// The first number that is wrong, with its owner.
    pub fn check(&self) -> Result<(), GrainError> {
        let count = self.spheres.positions.len();
        let Spheres { radii, velocities, spins, materials, held, positions } = &self.spheres;
        for (what, found, optional) in [
            ("radii", radii.len(), false),
            ("velocities", velocities.len(), true),
            ("spins", spins.len(), true),
            ("materials of spheres", materials.len(), true),
            ("held spheres", held.len(), true),
        ] {
            if found != count && !(optional && found == 0) {
                return Err(GrainError::Length { what, found, expected: count });
            }
        }
        for (number, of) in self.materials.iter().enumerate() {
            let place = || format!("material {number}");
            within(place, "density", of.density, of.density > 0.0, "above 0")?;
            // A rigid wall has an infinite one.
            let young = if of.youngs_modulus == f64::INFINITY { f64::MAX } else { of.youngs_modulus };
            within(place, "Young's modulus", young, young > 0.0, "above 0")?;
            let poisson = of.poissons_ratio;
            within(
                place,
                "Poisson's ratio",
                poisson,
                poisson > -1.0 && poisson <= 0.5,
                "above -1 and at most 0.5",
            )?;
        }
        let known = self.materials.len();
        for sphere in 0..count {
            let place = || format!("sphere {sphere}");
            within(place, "radius", radii[sphere], radii[sphere] > 0.0, "above 0")?;
            let none = [0.0; 3];
            let numbers = [
                &positions[sphere],
                velocities.get(sphere).unwrap_or(&none),
                spins.get(sphere).unwrap_or(&none),
            ];
            for &x in numbers.into_iter().flatten() {
                within(place, "a coordinate", x, true, "a number")?;
            }
            let material = self.material_of(sphere);
            if material as usize >= known {
                return Err(GrainError::Material { place: place(), material });
            }
        }
        for (number, wall) in self.walls.iter().enumerate() {
            let place = || format!("wall {number}");
            if wall.material as usize >= known {
                return Err(GrainError::Material { place: place(), material: wall.material });
            }
            let (direction, radius) = match wall.shape {
                WallShape::Plane { normal, .. } => (normal, 1.0),
                WallShape::Tube { axis: [a, b], radius } => (crate::vector::minus(b, a), radius),
            };
            let size = crate::vector::length(direction);
            within(place, "length of its direction", size, size > 0.0, "above 0")?;
            within(place, "radius", radius, radius > 0.0, "above 0")?;
        }
        self.surfaces.iter().try_for_each(|surfaces| self.check_surfaces(surfaces))?;
        if let ForceLaw::Hooke { normal, tangential } = self.law {
            let place = || "Hooke's law".to_owned();
            within(place, "stiffness", normal, normal > 0.0, "above 0")?;
            within(
                place,
                "tangential stiffness over the normal one",
                tangential,
                tangential >= 0.0,
                "at least 0",
            )?;
        }
        if let Some(step) = self.step {
            within(|| "the model".to_owned(), "time step", step, step > 0.0, "above 0")?;
        }
        Ok(())
    }

    fn check_surfaces(&self, of: &Surfaces) -> Result<(), GrainError> {
        let place = || format!("surfaces of materials {} and {}", of.materials[0], of.materials[1]);
        if let Some(&material) =
            of.materials.iter().find(|&&material| material as usize >= self.materials.len())
        {
            return Err(GrainError::Material { place: place(), material });
        }
        let e = of.restitution;
        within(place, "restitution", e, e > 0.0 && e <= 1.0, "above 0 and at most 1")?;
        for (what, value) in [
            ("friction", of.friction),
            ("rolling friction", of.rolling_friction),
            ("rolling damping", of.rolling_damping),
            ("twisting friction", of.twisting_friction),
            ("adhesion", of.adhesion),
        ] {
            within(place, what, value, value >= 0.0, "at least 0")?;
        }
        match self.law {
            ForceLaw::Hooke { .. } if of.adhesion > 0.0 => {
                let (what, value, range) = ("adhesion", of.adhesion, "0 with Hooke's law");
                Err(GrainError::OutOfRange { place: place(), what, value, range })
            }
            _ => Ok(()),
        }
    }
}

/// Whether a number is finite and in its range.
fn within(
    place: impl Fn() -> String,
    what: &'static str,
    value: f64,
    is_right: bool,
    range: &'static str,
) -> Result<(), GrainError> {
    if is_right && value.is_finite() {
        Ok(())
    } else {
        Err(GrainError::OutOfRange { place: place(), what, value, range })
    }
}
