//! A run: spheres that move under the forces of their contacts.
//!
//! One step:
//!
//! 1. Candidates: couples of spheres that may touch, from [`Buffered`]; when they change, the histories go
//!    over to the new list.
//! 2. Forces: each sphere computes its contacts with spheres of higher numbers.
//! 3. Motion: each sphere adds up the forces of its contacts in the order of the other spheres, those of
//!    walls after that, and moves. Velocities are half a step behind positions; contacts see them at the
//!    positions, by the accelerations of the last step.
//!
//! So the sums depend neither on threads nor on the list of candidates.

mod on_walls;

use std::sync::Arc;

use fdem_contact::{Buffered, Detector, Elements};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::{GrainContact, GrainPartner, SphereColumns};
use crate::error::GrainError;
use crate::law::{ContactHistory, Meeting, PairLaw};
use crate::material::ForceLaw;
use crate::model::GrainModel;
use crate::on_facet::{Ball, FacetHistory, SurfaceMotion};
use crate::on_surface::{Balls, Laws, OnSurface};
use crate::surface::Surface;
use crate::vector::{Vector, cross, dot, length, minus, plus, times};
use on_walls::{OnWalls, WallState};

/// Gap up to which spheres are candidates, as a share of their mean radius.
const BUFFER: f64 = 0.2;

/// Spheres that one thread computes at a time.
const CHUNK: usize = 512;

/// A sphere in motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Sphere {
    /// m.
    position: Vector,
    /// Velocity, m/s, and angular velocity, rad/s, half a step before the position.
    velocity: Vector,
    spin: Vector,
    /// Accelerations in the last step, m/s² and rad/s².
    acceleration: Vector,
    turning: Vector,
}

/// Properties of a sphere that do not change.
#[derive(Clone, Copy, Debug)]
struct Fixed {
    radius: f64,
    mass: f64,
    material: u32,
    held: bool,
}

/// A sphere as its contacts see it.
#[derive(Clone, Copy, Debug)]
struct Seen {
    position: Vector,
    radius: f64,
    velocity: Vector,
    mass: f64,
    spin: Vector,
    material: u32,
}

/// Forces of a contact on its two bodies.
#[derive(Clone, Copy, Debug, Default)]
struct Acting {
    /// On the first, N; the opposite acts on the second.
    force: Vector,
    /// Moments about the two centres, N m.
    moments: [Vector; 2],
    touches: bool,
}

/// Couples of spheres that may touch: for each sphere those with higher numbers, ascending.
#[derive(Clone, Debug, Default)]
struct Neighbours {
    /// Where the couples of each sphere begin.
    first: Vec<u32>,
    other: Vec<u32>,
    histories: Vec<ContactHistory>,
    acting: Vec<Acting>,
    /// Where the couples of each sphere with lower numbers begin in `slots`, and these couples, ascending.
    first_lower: Vec<u32>,
    slots: Vec<u32>,
}

/// The spheres for contacts with walls and bodies.
#[derive(Clone, Copy, Debug)]
struct AllSeen<'a> {
    seen: &'a [Seen],
    fixed: &'a [Fixed],
}

impl Balls for AllSeen<'_> {
    fn count(&self) -> usize {
        self.seen.len()
    }

    fn number(&self, place: usize) -> u32 {
        place as u32
    }

    fn position(&self, place: usize) -> Vector {
        self.seen[place].position
    }

    fn radius(&self, place: usize) -> f64 {
        self.seen[place].radius
    }

    fn ball(&self, place: usize) -> Ball {
        let Seen { position, radius, velocity, mass, spin, material } = self.seen[place];
        let (number, inertia) = (place as u32, self.fixed[place].inertia());
        Ball { number, material, position, velocity, spin, radius, mass, inertia }
    }
}

/// Everything that a run is continued from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrainState {
    step: u64,
    spheres: Vec<Sphere>,
    contacts: Vec<([u32; 2], ContactHistory)>,
    walls: WallState,
    on_bodies: Vec<(u32, Vec<FacetHistory>)>,
    on_surface: OnSurfaceAccounts,
}

/// Energies of contacts with bodies since the beginning, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct OnSurfaceAccounts {
    dissipated: f64,
    /// Work on the bodies.
    work: f64,
}

/// Energies of a run, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GrainEnergies {
    /// Kinetic energy of the velocities, half a step before the positions.
    pub kinetic: f64,
    /// Kinetic energy of the rotations.
    pub rotational: f64,
    /// Stored in contacts, along and across their normals.
    pub elastic: f64,
    /// Potential energy of the weight; 0 at the origin.
    pub weight: f64,
    /// Dissipated since the beginning: by dashpots, friction, rolling and twisting.
    pub dissipated: f64,
    /// Work of walls that move and of held spheres on the others since the beginning.
    pub external: f64,
    /// Work of the spheres on the surface of bodies since the beginning. The elastic energy of these contacts
    /// is that of the last step.
    pub on_surface: f64,
}

/// A run of spheres.
///
/// # Example
/// A sphere falls on a plane, and rebounds with half of its speed.
///
/// ```
/// use fdem_grains::*;
///
/// let glass = GrainMaterial { density: 2500.0, youngs_modulus: 50e9, poissons_ratio: 0.2 };
/// let model = GrainModel {
///     spheres: Spheres {
///         positions: vec![[0.0, 0.0, 0.0101]],
///         radii: vec![0.01],
///         velocities: vec![[0.0, 0.0, -1.0]],
///         ..Spheres::default()
///     },
///     walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)],
///     materials: vec![glass],
///     surfaces: vec![Surfaces { restitution: 0.5, ..Surfaces::smooth([0, 0]) }],
///     ..GrainModel::default()
/// };
/// let mut run = GrainRun::new(model, 1)?;
/// run.advance(1000)?;
/// assert!((run.velocity(0)[2] - 0.5).abs() < 1e-3);
/// # Ok::<(), GrainError>(())
/// ```
#[derive(Debug)]
pub struct GrainRun {
    model: GrainModel,
    laws: Vec<Option<PairLaw>>,
    fixed: Vec<Fixed>,
    spheres: Vec<Sphere>,
    search: Buffered<f64, 3>,
    positions: Vec<Vector>,
    /// Radii of the search, m: larger than those of the spheres where they stick to each other.
    reaches: Vec<f64>,
    seen: Vec<Seen>,
    neighbours: Neighbours,
    on_walls: OnWalls,
    on_bodies: OnSurface,
    on_surface: OnSurfaceAccounts,
    step: u64,
    time_step: f64,
    pool: Arc<rayon::ThreadPool>,
}

impl GrainRun {
    /// Creates a run on `threads` threads; 0 stands for one per processor. Results do not depend on the
    /// number of threads.
    ///
    /// # Errors
    /// The number of the model that is wrong.
    pub fn new(model: GrainModel, threads: usize) -> Result<Self, GrainError> {
        model.check()?;
        let count = model.spheres.positions.len();
        let kinds = model.materials.len();
        let mut laws = vec![None; kinds * kinds];
        for surfaces in &model.surfaces {
            let [a, b] = surfaces.materials.map(|material| material as usize);
            let law = PairLaw::new(model.law, [&model.materials[a], &model.materials[b]], surfaces);
            (laws[a * kinds + b], laws[b * kinds + a]) = (Some(law), Some(law));
        }
        let fixed: Vec<Fixed> = (0..count)
            .map(|sphere| Fixed {
                radius: model.spheres.radii[sphere],
                mass: model.mass_of(sphere),
                material: model.material_of(sphere),
                held: model.spheres.held.get(sphere).copied().unwrap_or(false),
            })
            .collect();
        let given = |list: &[Vector], sphere: usize| list.get(sphere).copied().unwrap_or([0.0; 3]);
        let spheres = (0..count)
            .map(|sphere| Sphere {
                position: model.spheres.positions[sphere],
                velocity: given(&model.spheres.velocities, sphere),
                spin: given(&model.spheres.spins, sphere),
                acceleration: [0.0; 3],
                turning: [0.0; 3],
            })
            .collect();
        let largest = fixed.iter().map(|of| of.radius).fold(0.0, f64::max);
        let reach = laws.iter().flatten().map(|law| law.reach(0.5 * largest)).fold(0.0, f64::max);
        let reaches = fixed.iter().map(|of| of.radius + 0.5 * reach).collect();
        let mean = fixed.iter().map(|of| of.radius).sum::<f64>() / count.max(1) as f64;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = Arc::new(pool.map_err(|error| GrainError::Search(error.to_string()))?);
        let detector = Detector::new().on_pool(Arc::clone(&pool));
        let search = Buffered::with_search(detector, BUFFER * mean);
        let time_step = model.step.unwrap_or_else(|| model.safe_step());
        Ok(Self {
            laws,
            fixed,
            spheres,
            search: search.map_err(|error| GrainError::Search(error.to_string()))?,
            positions: Vec::new(),
            reaches,
            seen: Vec::new(),
            neighbours: Neighbours { first: vec![0; count + 1], ..Neighbours::default() },
            on_walls: OnWalls::new(&model, mean),
            on_bodies: OnSurface::new(true, mean),
            on_surface: OnSurfaceAccounts::default(),
            step: 0,
            time_step,
            pool,
            model,
        })
    }

    /// A run that continues from a state of a run of the same model, as if it had never stopped.
    ///
    /// # Errors
    /// The errors of [`GrainRun::new`]; [`GrainError::Length`] if the state belongs to another model.
    pub fn resume(model: GrainModel, state: GrainState, threads: usize) -> Result<Self, GrainError> {
        let mut run = Self::new(model, threads)?;
        let (what, found, expected) = ("spheres", state.spheres.len(), run.spheres.len());
        if found != expected {
            return Err(GrainError::Length { what, found, expected });
        }
        (run.step, run.spheres, run.on_surface) = (state.step, state.spheres, state.on_surface);
        run.look();
        let balls = AllSeen { seen: &run.seen, fixed: &run.fixed };
        run.on_bodies.restore(state.on_bodies, &balls);
        let (what, found, expected) = ("walls", state.walls.count(), run.model.walls.len());
        if !run.on_walls.restore(state.walls, &balls) {
            return Err(GrainError::Length { what, found, expected });
        }
        run.detect()?;
        for ([i, j], history) in state.contacts {
            if let Some(slot) = run.neighbours.slot(i, j) {
                run.neighbours.histories[slot] = history;
            }
        }
        Ok(run)
    }

    /// The state from which this run can be continued.
    pub fn state(&self) -> GrainState {
        let of = &self.neighbours;
        let mut contacts = Vec::new();
        let seen = self.seen_now();
        let balls = AllSeen { seen: &seen, fixed: &self.fixed };
        for i in 0..self.spheres.len() {
            for slot in of.first[i] as usize..of.first[i + 1] as usize {
                if of.histories[slot].contact > 0.0 {
                    contacts.push(([i as u32, of.other[slot]], of.histories[slot]));
                }
            }
        }
        GrainState {
            step: self.step,
            spheres: self.spheres.clone(),
            contacts,
            walls: self.on_walls.state(&balls),
            on_bodies: self.on_bodies.state(&balls),
            on_surface: self.on_surface,
        }
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.time_step
    }

    /// Centre of a sphere, m.
    pub fn position(&self, sphere: usize) -> [f64; 3] {
        self.spheres[sphere].position
    }

    /// Velocity of a sphere, m/s, half a step before its position.
    pub fn velocity(&self, sphere: usize) -> [f64; 3] {
        self.spheres[sphere].velocity
    }

    /// Angular velocity of a sphere, rad/s, half a step before its position.
    pub fn spin(&self, sphere: usize) -> [f64; 3] {
        self.spheres[sphere].spin
    }

    /// Force of the spheres on a wall in the last step, N.
    pub fn wall_force(&self, wall: usize) -> [f64; 3] {
        self.on_walls.force(wall)
    }

    /// Moment of the spheres on a wall in the last step about the origin, N m.
    pub fn wall_moment(&self, wall: usize) -> [f64; 3] {
        self.on_walls.moment(wall)
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// [`GrainError::Lost`] if a sphere has no place any more.
    pub fn advance(&mut self, steps: u64) -> Result<(), GrainError> {
        let pool = Arc::clone(&self.pool);
        pool.install(|| (0..steps).try_for_each(|_| self.take_step(None)))
    }

    /// Takes one step in which the spheres touch this surface of bodies, too.
    ///
    /// # Errors
    /// [`GrainError::Lost`] if a sphere has no place any more. [`GrainError::Length`] if the lists of the surface
    /// do not fit each other, [`GrainError::Point`] if a facet has a point that does not exist.
    pub fn step_on(&mut self, surface: &Surface<'_>) -> Result<(), GrainError> {
        surface.check(self.model.materials.len())?;
        let pool = Arc::clone(&self.pool);
        pool.install(|| self.take_step(Some(surface)))
    }

    /// Forces of the spheres on points of the surface in the last step, N, in ascending order of the points.
    pub fn surface_forces(&self) -> &[(u32, [f64; 3])] {
        &self.on_bodies.on_points
    }

    /// The spheres, their contacts and the walls now.
    ///
    /// # Cost
    /// A pass over all spheres and contacts.
    pub fn columns(&self) -> SphereColumns {
        let count = self.spheres.len();
        let of = |sphere: usize| self.fixed[sphere];
        SphereColumns {
            numbers: (0..count as u32).collect(),
            positions: self.spheres.iter().map(|sphere| sphere.position).collect(),
            radii: self.fixed.iter().map(|of| of.radius).collect(),
            velocities: self.spheres.iter().map(|sphere| sphere.velocity).collect(),
            spins: self.spheres.iter().map(|sphere| sphere.spin).collect(),
            forces: vec![[0.0; 3]; count],
            masses: (0..count).map(|sphere| of(sphere).mass).collect(),
            materials: (0..count).map(|sphere| of(sphere).material).collect(),
            groups: vec![0; count],
            group_names: self.model.groups.clone(),
            contacts: self.contacts(),
            walls: self.on_walls.at(&self.model.walls, self.time()).collect(),
            wall_forces: (0..self.model.walls.len()).map(|wall| self.wall_force(wall)).collect(),
            discs: self.model.discs,
            period: None,
        }
    }

    fn take_step(&mut self, surface: Option<&Surface<'_>>) -> Result<(), GrainError> {
        self.detect()?;
        self.look();
        self.press()?;
        self.press_on_surfaces(surface).map_err(|materials| GrainError::UnknownSurfaces { materials })?;
        self.move_all()?;
        self.step += 1;
        Ok(())
    }

    /// Computes the forces of all contacts with walls and bodies.
    fn press_on_surfaces(&mut self, surface: Option<&Surface<'_>>) -> Result<(), [u32; 2]> {
        let time = self.time();
        let laws = of_all(&self.laws, &self.model, self.time_step);
        let balls = AllSeen { seen: &self.seen, fixed: &self.fixed };
        self.on_walls.press(&balls, &self.model, laws, time)?;
        let Some(surface) = surface else {
            self.on_bodies.leave();
            return Ok(());
        };
        self.on_bodies.place(surface.points, surface.facets);
        let motion = SurfaceMotion::Points(surface.velocities);
        self.on_bodies.press(&balls, surface.materials, motion, None, laws)?;
        self.on_surface.dissipated += self.on_bodies.totals.dissipated;
        self.on_surface.work += self.on_bodies.totals.work;
        Ok(())
    }

    /// Updates the couples that may touch.
    fn detect(&mut self) -> Result<(), GrainError> {
        self.positions.clear();
        self.positions.extend(self.spheres.iter().map(|sphere| sphere.position));
        if self.positions.is_empty() {
            return Ok(());
        }
        let wrong = |error: fdem_contact::Error| GrainError::Search(error.to_string());
        let elements = Elements::spheres_with_radii(&self.positions, &self.reaches).map_err(wrong)?;
        let update = self.search.update(&elements).map_err(wrong)?;
        if update.redetected() {
            self.neighbours = Neighbours::of(update.candidates(), self.spheres.len(), &self.neighbours);
        }
        Ok(())
    }

    /// The spheres at the time of their positions.
    fn look(&mut self) {
        let mut seen = std::mem::take(&mut self.seen);
        self.look_into(&mut seen);
        self.seen = seen;
    }

    fn seen_now(&self) -> Vec<Seen> {
        let mut seen = Vec::new();
        self.look_into(&mut seen);
        seen
    }

    fn look_into(&self, seen: &mut Vec<Seen>) {
        let half = 0.5 * self.time_step;
        let all = self.spheres.par_iter().zip(&self.fixed).with_min_len(CHUNK);
        all.map(|(sphere, fixed)| Seen {
            position: sphere.position,
            radius: fixed.radius,
            velocity: plus(sphere.velocity, times(half, sphere.acceleration)),
            mass: fixed.mass,
            spin: plus(sphere.spin, times(half, sphere.turning)),
            material: fixed.material,
        })
        .collect_into_vec(seen);
    }

    /// Computes the forces of all contacts of two spheres.
    fn press(&mut self) -> Result<(), GrainError> {
        let Self { neighbours, seen, laws, model, time_step, .. } = self;
        let (kinds, step) = (model.materials.len(), *time_step);
        let Neighbours { first, other, histories, acting, .. } = neighbours;
        let chunks: Vec<usize> = (0..seen.len()).step_by(CHUNK).collect();
        let ends = |begin: usize| (begin + CHUNK).min(seen.len());
        let mut parts = Vec::with_capacity(chunks.len());
        let (mut histories, mut acting) = (histories.as_mut_slice(), acting.as_mut_slice());
        for begin in chunks {
            let count = (first[ends(begin)] - first[begin]) as usize;
            let (own, rest) = std::mem::take(&mut histories).split_at_mut(count);
            let (pushes, more) = std::mem::take(&mut acting).split_at_mut(count);
            (histories, acting) = (rest, more);
            parts.push((begin, own, pushes));
        }
        let unknown = parts.into_par_iter().map(|(begin, histories, acting)| {
            let base = first[begin] as usize;
            for i in begin..ends(begin) {
                let one = &seen[i];
                for slot in first[i] as usize..first[i + 1] as usize {
                    let two = &seen[other[slot] as usize];
                    let (history, acting) = (&mut histories[slot - base], &mut acting[slot - base]);
                    let apart = minus(one.position, two.position);
                    let (square, sum) = (dot(apart, apart), one.radius + two.radius);
                    if square >= sum * sum && history.contact == 0.0 {
                        acting.touches = false;
                        continue;
                    }
                    let Some(law) = &laws[one.material as usize * kinds + two.material as usize] else {
                        return Some([one.material, two.material]);
                    };
                    *acting = touch(law, one, two, square.sqrt(), history, step);
                }
            }
            None
        });
        match unknown.find_map_first(|materials| materials) {
            Some(materials) => Err(GrainError::UnknownSurfaces { materials }),
            None => Ok(()),
        }
    }

    /// Adds up the forces on each sphere, and moves it.
    fn move_all(&mut self) -> Result<(), GrainError> {
        let on_bodies: Vec<(u32, [Vector; 2])> = self.on_bodies.on_spheres().collect();
        let Self { neighbours, model, fixed, time_step, on_walls, spheres, .. } = self;
        let (step, gravity) = (*time_step, model.gravity);
        let (neighbours, fixed) = (&*neighbours, &*fixed);
        let lists = [on_walls.on_spheres(), &on_bodies];
        let lost = spheres.par_chunks_mut(CHUNK).enumerate().map(|(chunk, spheres)| {
            let begin = chunk * CHUNK;
            let mut lists = lists.map(|list| &list[list.partition_point(|of| (of.0 as usize) < begin)..]);
            for (k, sphere) in spheres.iter_mut().enumerate() {
                let i = begin + k;
                let [mut force, mut moment] = neighbours.sums(i);
                for list in &mut lists {
                    while let [(of, [push, turn]), rest @ ..] = list
                        && *of as usize == i
                    {
                        (force, moment) = (plus(force, *push), plus(moment, *turn));
                        *list = rest;
                    }
                }
                sphere.advance(&fixed[i], (force, moment), gravity, step);
                if !sphere.position.iter().all(|x| x.abs() < 1e30) {
                    return Some(i);
                }
            }
            None
        });
        match lost.find_map_first(|sphere| sphere) {
            Some(sphere) => Err(GrainError::Lost { sphere, step: self.step }),
            None => Ok(()),
        }
    }

    /// Energies now.
    ///
    /// # Cost
    /// A pass over all spheres and contacts on one thread.
    pub fn energies(&self) -> GrainEnergies {
        let mut energies = GrainEnergies::default();
        for (sphere, fixed) in self.spheres.iter().zip(&self.fixed) {
            energies.kinetic += 0.5 * fixed.mass * dot(sphere.velocity, sphere.velocity);
            energies.rotational += 0.5 * fixed.inertia() * dot(sphere.spin, sphere.spin);
            energies.weight -= fixed.mass * dot(self.model.gravity, sphere.position);
        }
        let kinds = self.model.materials.len();
        for (i, j, history) in self.neighbours.touching() {
            let [one, two] = [&self.fixed[i], &self.fixed[j]];
            let apart = length(minus(self.spheres[i].position, self.spheres[j].position));
            let radius = one.radius * two.radius / (one.radius + two.radius);
            if let Some(law) = &self.laws[one.material as usize * kinds + two.material as usize] {
                energies.elastic += law.energy(one.radius + two.radius - apart, radius, history);
            }
        }
        let laws = of_all(&self.laws, &self.model, self.time_step);
        let seen = self.seen_now();
        let balls = AllSeen { seen: &seen, fixed: &self.fixed };
        energies.elastic += self.on_walls.elastic(&balls, &self.model, laws, self.time());
        energies.elastic += self.on_bodies.totals.elastic;
        energies.dissipated += self.on_walls.dissipated + self.on_surface.dissipated;
        energies.external += self.on_walls.external;
        energies.on_surface = self.on_surface.work;
        energies
    }

    /// Contacts in the last step, by their spheres: with others of higher numbers, with walls, with bodies.
    pub fn contacts(&self) -> Vec<GrainContact> {
        let mut contacts = Vec::new();
        for i in 0..self.spheres.len() {
            for slot in self.neighbours.first[i] as usize..self.neighbours.first[i + 1] as usize {
                let (other, acting) = (self.neighbours.other[slot], &self.neighbours.acting[slot]);
                if !acting.touches {
                    continue;
                }
                let [one, two] = [&self.seen[i], &self.seen[other as usize]];
                let apart = minus(one.position, two.position);
                let distance = length(apart);
                contacts.push(GrainContact {
                    sphere: i as u32,
                    other: GrainPartner::Sphere(other),
                    force: acting.force,
                    place: minus(
                        one.position,
                        times((one.radius - 0.5 * (one.radius + two.radius - distance)) / distance, apart),
                    ),
                    normal: dot(acting.force, apart) / distance,
                    overlap: one.radius + two.radius - distance,
                });
            }
        }
        let on_bodies = self.on_bodies.contacts.iter().map(|of| of.named(GrainPartner::Facet(of.facet)));
        contacts.extend(self.on_walls.contacts().iter().copied().chain(on_bodies));
        contacts.sort_by_key(|of: &GrainContact| of.sphere);
        contacts
    }

    /// Number of searches for contacts so far.
    pub fn detections(&self) -> u64 {
        self.search.redetections()
    }

    /// The law of all contacts.
    pub fn law(&self) -> ForceLaw {
        self.model.law
    }
}

impl Fixed {
    fn inertia(&self) -> f64 {
        0.4 * self.mass * self.radius * self.radius
    }
}

impl Sphere {
    /// Moves under a force, N, and a moment, N m, for a step, s.
    #[inline]
    fn advance(&mut self, fixed: &Fixed, (force, moment): (Vector, Vector), gravity: Vector, step: f64) {
        if !fixed.held {
            self.acceleration = plus(times(1.0 / fixed.mass, force), gravity);
            self.turning = times(1.0 / fixed.inertia(), moment);
            self.velocity = plus(self.velocity, times(step, self.acceleration));
            self.spin = plus(self.spin, times(step, self.turning));
        }
        self.position = plus(self.position, times(step, self.velocity));
    }
}

impl Neighbours {
    /// The candidates of a search, with the histories of the couples that touched before.
    fn of(candidates: &[fdem_contact::Couple], count: usize, before: &Self) -> Self {
        let mut first = vec![0_u32; count + 1];
        for couple in candidates {
            first[couple.i as usize + 1] += 1;
        }
        (0..count).for_each(|i| first[i + 1] += first[i]);
        let mut next = first.clone();
        let mut other = vec![0_u32; candidates.len()];
        for couple in candidates {
            let place = &mut next[couple.i as usize];
            other[*place as usize] = couple.j;
            *place += 1;
        }
        let mut first_lower = vec![0_u32; count + 1];
        for i in 0..count {
            other[first[i] as usize..first[i + 1] as usize].sort_unstable();
        }
        for &j in &other {
            first_lower[j as usize + 1] += 1;
        }
        (0..count).for_each(|i| first_lower[i + 1] += first_lower[i]);
        let (mut next, mut slots) = (first_lower.clone(), vec![0_u32; other.len()]);
        let mut histories = vec![ContactHistory::default(); other.len()];
        for i in 0..count {
            for slot in first[i] as usize..first[i + 1] as usize {
                let place = &mut next[other[slot] as usize];
                slots[*place as usize] = slot as u32;
                *place += 1;
                if let Some(old) = before.slot(i as u32, other[slot]) {
                    histories[slot] = before.histories[old];
                }
            }
        }
        let acting = vec![Acting::default(); other.len()];
        Self { first, other, histories, acting, first_lower, slots }
    }

    /// The place of a couple.
    fn slot(&self, i: u32, j: u32) -> Option<usize> {
        let [begin, end] = [i as usize, i as usize + 1].map(|k| self.first[k] as usize);
        self.other[begin..end].binary_search(&j).ok().map(|place| begin + place)
    }

    /// Force, N, and moment, N m, of all spheres on one.
    #[inline]
    fn sums(&self, i: usize) -> [Vector; 2] {
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        if self.first_lower.is_empty() {
            return [force, moment];
        }
        for &slot in &self.slots[self.first_lower[i] as usize..self.first_lower[i + 1] as usize] {
            let acting = &self.acting[slot as usize];
            if acting.touches {
                force = minus(force, acting.force);
                moment = plus(moment, acting.moments[1]);
            }
        }
        for acting in &self.acting[self.first[i] as usize..self.first[i + 1] as usize] {
            if acting.touches {
                force = plus(force, acting.force);
                moment = plus(moment, acting.moments[0]);
            }
        }
        [force, moment]
    }

    /// The couples that touch, with their histories.
    fn touching(&self) -> impl Iterator<Item = (usize, usize, &ContactHistory)> {
        (0..self.first.len() - 1).flat_map(move |i| {
            let slots = self.first[i] as usize..self.first[i + 1] as usize;
            slots
                .filter(|&slot| self.histories[slot].contact > 0.0)
                .map(move |slot| (i, self.other[slot] as usize, &self.histories[slot]))
        })
    }
}

/// The forces of two spheres at a distance, m.
#[inline]
fn touch(
    law: &PairLaw,
    one: &Seen,
    two: &Seen,
    distance: f64,
    history: &mut ContactHistory,
    step: f64,
) -> Acting {
    let overlap = one.radius + two.radius - distance;
    let radius = one.radius * two.radius / (one.radius + two.radius);
    if !law.touches(overlap, radius, history) {
        *history = ContactHistory::default();
        return Acting::default();
    }
    let apart = minus(one.position, two.position);
    // Concentric spheres have no normal: any will do.
    let normal = if distance > 0.0 { times(1.0 / distance, apart) } else { [1.0, 0.0, 0.0] };
    // The contact is in the middle of the overlap.
    let arms = [times(-(one.radius - 0.5 * overlap), normal), times(two.radius - 0.5 * overlap, normal)];
    let velocity =
        minus(plus(one.velocity, cross(one.spin, arms[0])), plus(two.velocity, cross(two.spin, arms[1])));
    let inertia = |of: &Seen| 1.4 * of.mass * of.radius * of.radius;
    let meeting = Meeting {
        normal,
        overlap,
        radius,
        mass: one.mass * two.mass / (one.mass + two.mass),
        inertias: [inertia(one), inertia(two)],
        velocity,
        spins: [one.spin, two.spin],
    };
    let push = law.push(&meeting, history, step);
    let moment = |arm: Vector, sign: f64| plus(cross(arm, times(sign, push.force)), times(sign, push.moment));
    Acting { force: push.force, moments: [moment(arms[0], 1.0), moment(arms[1], -1.0)], touches: true }
}

/// The laws as contacts with walls and bodies see them.
fn of_all<'a>(laws: &'a [Option<PairLaw>], model: &GrainModel, step: f64) -> Laws<'a> {
    let sticks = laws.iter().flatten().any(|law| law.reach(1.0) > 0.0);
    Laws { pairs: laws, kinds: model.materials.len(), sticks, step }
}
