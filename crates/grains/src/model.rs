//! The model: spheres, walls and their materials.

use serde::{Deserialize, Serialize};

use crate::clump::Clump;
use crate::domain::Domain;
use crate::error::GrainError;
use crate::insertion::{Insertion, Removal};
use crate::material::{ForceLaw, GrainMaterial, Surfaces};
use crate::vector::{length, minus};
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
    /// Numbers of the groups, see [`GrainModel::groups`]; empty if all are in the first.
    pub groups: Vec<u32>,
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
    /// Names of the groups of spheres, for messages and results; may be empty.
    pub groups: Vec<String>,
    /// Thickness of discs, m: the spheres are discs in the plane z = 0 and move in it. `None` for spheres.
    pub discs: Option<f64>,
    /// Spheres that move together as rigid bodies.
    pub clumps: Vec<Clump>,
    /// Spheres that come in during the run.
    pub insertions: Vec<Insertion>,
    /// Boxes in which spheres are removed.
    pub removals: Vec<Removal>,
    /// The box in which the spheres are; `None` for space without ends.
    pub domain: Option<Domain>,
    /// Time step, s; `None` for [`GrainModel::safe_step`].
    pub step: Option<f64>,
}

impl GrainModel {
    /// Number of the material of a sphere.
    pub(crate) fn material_of(&self, sphere: usize) -> u32 {
        self.spheres.materials.get(sphere).copied().unwrap_or(0)
    }

    /// Checks all numbers.
    ///
    /// # Errors
    /// The first number that is wrong, with its owner.
    pub fn check(&self) -> Result<(), GrainError> {
        let count = self.spheres.positions.len();
        let Spheres { radii, velocities, spins, materials, held, positions, groups } = &self.spheres;
        for (what, found, optional) in [
            ("radii", radii.len(), false),
            ("velocities", velocities.len(), true),
            ("spins", spins.len(), true),
            ("materials of spheres", materials.len(), true),
            ("held spheres", held.len(), true),
            ("groups of spheres", groups.len(), true),
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
            self.check_wall(number, wall)?;
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
        self.check_box()?;
        self.check_clumps()?;
        self.check_insertions()?;
        if let Some(step) = self.step {
            within(|| "the model".to_owned(), "time step", step, step > 0.0, "above 0")?;
        }
        Ok(())
    }

    fn check_wall(&self, number: usize, wall: &Wall) -> Result<(), GrainError> {
        let name =
            || if wall.name.is_empty() { format!("wall {number}") } else { format!("wall {}", wall.name) };
        if wall.material as usize >= self.materials.len() {
            return Err(GrainError::Material { place: name(), material: wall.material });
        }
        let is_direction = |what: &'static str, of: [f64; 3]| {
            let size = length(of);
            within(name, what, size, size > 0.0, "above 0")
        };
        let is_point =
            |of: &[f64; 3]| of.iter().try_for_each(|&x| within(name, "a coordinate", x, true, "a number"));
        match &wall.shape {
            WallShape::Plane { point, normal } => {
                is_point(point)?;
                is_direction("length of its direction", *normal)?;
            }
            WallShape::Tube { axis: [a, b], radius } => {
                is_point(a)?;
                is_direction("length of its direction", minus(*b, *a))?;
                within(name, "radius", *radius, *radius > 0.0, "above 0")?;
            }
            WallShape::Cone { axis: [a, b], radii } => {
                is_point(a)?;
                is_direction("length of its direction", minus(*b, *a))?;
                for &radius in radii {
                    within(name, "radius", radius, radius >= 0.0, "at least 0")?;
                }
                let largest = radii[0].max(radii[1]);
                within(name, "larger radius", largest, largest > 0.0, "above 0")?;
            }
            WallShape::Disc { centre, normal, radius } => {
                is_point(centre)?;
                is_direction("length of its direction", *normal)?;
                within(name, "radius", *radius, *radius > 0.0, "above 0")?;
            }
            WallShape::Mesh { triangles } => {
                let count = triangles.len() as f64;
                within(name, "number of triangles", count, count > 0.0, "above 0")?;
                triangles.iter().flatten().try_for_each(is_point)?;
            }
        }
        is_point(&wall.velocity)?;
        within(name, "time from which it moves", wall.from, true, "a number")?;
        if let Some(rotation) = &wall.rotation {
            is_point(&rotation.through)?;
            is_point(&rotation.spin)?;
        }
        let mut before = f64::NEG_INFINITY;
        for (time, displacement) in &wall.path {
            within(name, "time of its path", *time, *time > before, "above the time before it")?;
            is_point(displacement)?;
            before = *time;
        }
        if let Some(servo) = &wall.servo {
            is_direction("length of the direction of its servo", servo.direction)?;
            within(name, "force of its servo", servo.force, servo.force >= 0.0, "at least 0")?;
            within(name, "speed of its servo", servo.speed, servo.speed > 0.0, "above 0")?;
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
pub(crate) fn within(
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

/// Mass of a sphere, or of a disc of a thickness, kg.
pub(crate) fn mass(radius: f64, density: f64, thickness: Option<f64>) -> f64 {
    let square = std::f64::consts::PI * radius * radius;
    density * thickness.map_or(4.0 / 3.0 * square * radius, |thickness| square * thickness)
}
