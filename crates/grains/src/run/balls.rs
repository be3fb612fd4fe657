//! The spheres of a run, in the order of their places in memory.

use serde::{Deserialize, Serialize};

use crate::model::{GrainModel, Spheres, mass};
use crate::run::order::along_curve;
use crate::vector::{Vector, plus, times};

/// A sphere as its contacts see it, at the time of its position.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Ball {
    /// m.
    pub(crate) position: Vector,
    /// m.
    pub(crate) radius: f64,
    /// m/s.
    pub(crate) velocity: Vector,
    /// kg.
    pub(crate) mass: f64,
    /// rad/s.
    pub(crate) spin: Vector,
    pub(crate) material: u32,
    /// It is the sphere's for the whole run.
    pub(crate) number: u32,
}

/// The motion of a sphere, and its sums over the run. In rows of four numbers, each of which moves as one
/// vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C, align(32))]
pub(crate) struct Drive {
    /// Velocity, m/s, half a step before the position.
    pub(crate) velocity: Vector,
    /// Energy that its contacts with walls, bodies and spheres of higher numbers have dissipated, J.
    pub(crate) dissipated: f64,
    /// Angular velocity, rad/s, half a step before the position.
    pub(crate) spin: Vector,
    /// Work from outside on it, J.
    pub(crate) external: f64,
}

/// The clump of a sphere that belongs to none.
pub(crate) const ALONE: u32 = u32::MAX;

/// Properties that the motion alone reads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BallKind {
    pub(crate) group: u32,
    pub(crate) held: bool,
    /// Number of its clump, or [`ALONE`].
    pub(crate) clump: u32,
}

/// A sphere of a saved run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedBall {
    number: u32,
    position: Vector,
    radius: f64,
    material: u32,
    kind: BallKind,
    /// Velocity, m/s, and angular velocity, rad/s, at the time of the position.
    now: [Vector; 2],
    drive: Drive,
}

impl SavedBall {
    /// Numbers of its material and of its group.
    pub(crate) fn kinds(&mut self) -> [&mut u32; 2] {
        [&mut self.material, &mut self.kind.group]
    }
}

/// All spheres.
#[derive(Clone, Debug, Default)]
pub(crate) struct Balls {
    pub(crate) list: Vec<Ball>,
    pub(crate) drives: Vec<Drive>,
    pub(crate) kinds: Vec<BallKind>,
    /// Place of each sphere, in ascending order of their numbers.
    pub(crate) places: Vec<u32>,
    /// Force, N, and moment, N m, on each sphere in the last step; only with clumps.
    pub(crate) pushes: Vec<[Vector; 2]>,
    /// Mass, kg, and number of spheres of each clump.
    clumps: Vec<(f64, usize)>,
    /// Moment of inertia over mass and square of the radius.
    pub(crate) share: f64,
    /// Mass over density and a power of the radius.
    thickness: Option<f64>,
    densities: Vec<f64>,
}

impl Balls {
    pub(crate) fn new(model: &GrainModel) -> Self {
        let mut balls = Self {
            share: if model.discs.is_some() { 0.5 } else { 0.4 },
            thickness: model.discs,
            densities: model.materials.iter().map(|material| material.density).collect(),
            ..Self::default()
        };
        balls.add(0, &model.spheres);
        for (clump, of) in (0..).zip(&model.clumps) {
            let mass = model.inertia_of(clump as usize).mass;
            balls.clumps.push((mass, of.spheres.len()));
            for &sphere in &of.spheres {
                balls.kinds[sphere as usize].clump = clump;
                balls.list[sphere as usize].mass = mass;
            }
        }
        balls.make_pushes();
        balls
    }

    /// Adds spheres, numbered from `first` on.
    pub(crate) fn add(&mut self, first: u32, spheres: &Spheres) {
        let given = |list: &[Vector], sphere: usize| list.get(sphere).copied().unwrap_or([0.0; 3]);
        for (sphere, number) in (0..spheres.positions.len()).zip(first..) {
            let material = spheres.materials.get(sphere).copied().unwrap_or(0);
            let (velocity, spin) = (given(&spheres.velocities, sphere), given(&spheres.spins, sphere));
            self.push(SavedBall {
                number,
                position: spheres.positions[sphere],
                radius: spheres.radii[sphere],
                material,
                kind: BallKind {
                    group: spheres.groups.get(sphere).copied().unwrap_or(0),
                    held: spheres.held.get(sphere).copied().unwrap_or(false),
                    clump: ALONE,
                },
                now: [velocity, spin],
                drive: Drive { velocity, spin, ..Drive::default() },
            });
        }
        self.find_places();
    }

    /// Mass of a sphere for results, kg: of a clump, each one has an equal part.
    pub(crate) fn share_of_mass(&self, place: usize) -> f64 {
        let clump = self.clumps.get(self.kinds[place].clump as usize);
        clump.map_or(self.list[place].mass, |&(mass, count)| mass / count as f64)
    }

    /// Whether these are discs, which stay in their plane.
    pub(crate) fn are_discs(&self) -> bool {
        self.thickness.is_some()
    }

    fn make_pushes(&mut self) {
        let count = if self.clumps.is_empty() { 0 } else { self.list.len() };
        self.pushes.resize(count, [[0.0; 3]; 2]);
    }

    fn push(&mut self, of: SavedBall) {
        // The contacts of a clump have the mass of the whole.
        let whole = self.clumps.get(of.kind.clump as usize).map(|(mass, _)| *mass);
        let own = || mass(of.radius, self.densities[of.material as usize], self.thickness);
        self.list.push(Ball {
            position: of.position,
            radius: of.radius,
            velocity: of.now[0],
            mass: whole.unwrap_or_else(own),
            spin: of.now[1],
            material: of.material,
            number: of.number,
        });
        self.drives.push(of.drive);
        self.kinds.push(of.kind);
    }

    /// The spheres in the order of their numbers.
    pub(crate) fn saved(&self) -> Vec<SavedBall> {
        let saved = |&place: &u32| {
            let (ball, drive) = (self.list[place as usize], self.drives[place as usize]);
            SavedBall {
                number: ball.number,
                position: ball.position,
                radius: ball.radius,
                material: ball.material,
                kind: self.kinds[place as usize],
                now: [ball.velocity, ball.spin],
                drive,
            }
        };
        self.places.iter().map(saved).collect()
    }

    /// Takes over the spheres of a saved run.
    pub(crate) fn take(&mut self, saved: Vec<SavedBall>) {
        self.list.clear();
        self.drives.clear();
        self.kinds.clear();
        for of in saved {
            self.push(of);
        }
        self.find_places();
    }

    /// Removes the spheres for which `goes` holds, by their places. Returns how many.
    pub(crate) fn remove(&mut self, goes: impl Fn(usize, &Ball) -> bool) -> usize {
        let before = self.list.len();
        let stays: Vec<usize> = (0..before).filter(|&place| !goes(place, &self.list[place])).collect();
        if stays.len() < before {
            self.arrange(&stays);
        }
        before - stays.len()
    }

    /// Arranges the spheres along a curve through space.
    pub(crate) fn sort(&mut self) {
        let positions: Vec<Vector> = self.list.iter().map(|ball| ball.position).collect();
        let order: Vec<usize> = along_curve(&positions).into_iter().map(|place| place as usize).collect();
        self.arrange(&order);
    }

    /// Mean velocity, m/s.
    pub(crate) fn mean_velocity(&self) -> Vector {
        let mut sum = [0.0; 3];
        for &place in &self.places {
            sum = plus(sum, self.drives[place as usize].velocity);
        }
        times(1.0 / self.places.len().max(1) as f64, sum)
    }

    /// Keeps the spheres of these places, in this order.
    fn arrange(&mut self, order: &[usize]) {
        self.list = order.iter().map(|&place| self.list[place]).collect();
        self.drives = order.iter().map(|&place| self.drives[place]).collect();
        self.kinds = order.iter().map(|&place| self.kinds[place]).collect();
        self.find_places();
    }

    fn find_places(&mut self) {
        self.make_pushes();
        self.places.clear();
        self.places.extend(0..self.list.len() as u32);
        let list = &self.list;
        self.places.sort_unstable_by_key(|&place| list[place as usize].number);
    }

    /// Moment of inertia of a sphere, kg m².
    #[inline]
    pub(crate) fn inertia(&self, place: usize) -> f64 {
        let ball = &self.list[place];
        self.share * ball.mass * ball.radius * ball.radius
    }
}
