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

use std::sync::Arc;

use fdem_contact::{Buffered, Detector, Elements};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::GrainError;
use crate::law::{ContactHistory, Meeting, PairLaw, Push};
use crate::material::ForceLaw;
use crate::model::GrainModel;
use crate::vector::{Vector, cross, dot, length, minus, plus, times};
use crate::wall::Wall;

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

/// Spheres that touch one wall, ascending, with their histories.
type OnWall = Vec<(u32, ContactHistory)>;

/// Everything that a run is continued from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrainState {
    step: u64,
    spheres: Vec<Sphere>,
    contacts: Vec<([u32; 2], ContactHistory)>,
    on_walls: Vec<OnWall>,
}

/// A contact of a sphere with another, or with a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainContact {
    /// Number of the first sphere.
    pub sphere: u32,
    /// Number of the other sphere, or of the wall.
    pub other: GrainPartner,
    /// Force on the sphere, N.
    pub force: [f64; 3],
    /// Part of the force along the normal, N; positive for pressure.
    pub normal: f64,
    /// Depth by which the two overlap, m.
    pub overlap: f64,
}

/// A thing that a sphere touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrainPartner {
    /// A sphere with a higher number.
    Sphere(u32),
    /// A wall.
    Wall(u32),
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
    on_walls: Vec<OnWall>,
    wall_forces: Vec<Vector>,
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
            on_walls: vec![Vec::new(); model.walls.len()],
            wall_forces: vec![[0.0; 3]; model.walls.len()],
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
        let [spheres, walls] = [state.spheres.len(), state.on_walls.len()];
        for (what, found, expected) in
            [("spheres", spheres, run.spheres.len()), ("walls", walls, run.on_walls.len())]
        {
            if found != expected {
                return Err(GrainError::Length { what, found, expected });
            }
        }
        (run.step, run.spheres, run.on_walls) = (state.step, state.spheres, state.on_walls);
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
            on_walls: self.on_walls.clone(),
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
        self.wall_forces[wall]
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// [`GrainError::Lost`] if a sphere has no place any more.
    pub fn advance(&mut self, steps: u64) -> Result<(), GrainError> {
        let pool = Arc::clone(&self.pool);
        pool.install(|| (0..steps).try_for_each(|_| self.take_step()))
    }

    fn take_step(&mut self) -> Result<(), GrainError> {
        self.detect()?;
        self.look();
        self.press()?;
        self.move_all()?;
        self.step += 1;
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
        .collect_into_vec(&mut self.seen);
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
        let time = self.time();
        let walls: Vec<Wall> = self.model.walls.iter().map(|wall| wall.at(time)).collect();
        let Self { neighbours, seen, laws, model, fixed, time_step, on_walls, spheres, .. } = self;
        let (step, kinds, gravity) = (*time_step, model.materials.len(), model.gravity);
        let on_walls_before = std::mem::take(on_walls);
        let neighbours = &*neighbours;
        let parts = spheres.par_chunks_mut(CHUNK).enumerate().map(|(chunk, spheres)| {
            let begin = chunk * CHUNK;
            let mut found: Vec<(OnWall, Vector)> = vec![(Vec::new(), [0.0; 3]); walls.len()];
            let mut before: Vec<&[(u32, ContactHistory)]> = on_walls_before
                .iter()
                .map(|list| &list[list.partition_point(|(sphere, _)| (*sphere as usize) < begin)..])
                .collect();
            for (k, sphere) in spheres.iter_mut().enumerate() {
                let i = begin + k;
                let one = &seen[i];
                let [mut force, mut moment] = neighbours.sums(i);
                for (number, wall) in walls.iter().enumerate() {
                    while before[number].first().is_some_and(|(sphere, _)| (*sphere as usize) < i) {
                        before[number] = &before[number][1..];
                    }
                    let (normal, distance) = wall.nearest(one.position);
                    let known = before[number].first().filter(|(sphere, _)| *sphere as usize == i);
                    if distance >= one.radius && known.is_none() {
                        continue;
                    }
                    let Some(law) = &laws[one.material as usize * kinds + wall.material as usize] else {
                        return Err(GrainError::UnknownSurfaces { materials: [one.material, wall.material] });
                    };
                    let mut history = known.map(|(_, history)| *history).unwrap_or_default();
                    let Some((push, arm)) =
                        touch_wall(law, one, (wall, normal, distance), &mut history, step)
                    else {
                        continue;
                    };
                    force = plus(force, push.force);
                    moment = plus(moment, plus(cross(arm, push.force), push.moment));
                    found[number].1 = minus(found[number].1, push.force);
                    found[number].0.push((i as u32, history));
                }
                sphere.advance(&fixed[i], (force, moment), gravity, step);
                if !sphere.position.iter().all(|x| x.abs() < 1e30) {
                    return Err(GrainError::Lost { sphere: i, step: 0 });
                }
            }
            Ok(found)
        });
        let parts: Result<Vec<_>, GrainError> = parts.collect::<Vec<_>>().into_iter().collect();
        let parts = parts.map_err(|error| match error {
            GrainError::Lost { sphere, .. } => GrainError::Lost { sphere, step: self.step },
            other => other,
        })?;
        self.on_walls = vec![Vec::new(); walls.len()];
        self.wall_forces = vec![[0.0; 3]; walls.len()];
        for (number, (list, force)) in parts.into_iter().flat_map(|of| of.into_iter().enumerate()) {
            self.on_walls[number].extend(list);
            self.wall_forces[number] = plus(self.wall_forces[number], force);
        }
        Ok(())
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
        let time = self.time();
        for (wall, list) in self.model.walls.iter().zip(&self.on_walls) {
            let wall = wall.at(time);
            for (sphere, history) in list {
                let of = &self.fixed[*sphere as usize];
                let (_, distance) = wall.nearest(self.spheres[*sphere as usize].position);
                if let Some(law) = &self.laws[of.material as usize * kinds + wall.material as usize] {
                    energies.elastic += law.energy(of.radius - distance, of.radius, history);
                }
            }
        }
        energies
    }

    /// Pairs of spheres that touched in the last step, in ascending order.
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
                    normal: dot(acting.force, apart) / distance,
                    overlap: one.radius + two.radius - distance,
                });
            }
        }
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

/// The push of a wall on a sphere, and the arm from its centre to the contact, m. `None` if they are apart.
#[inline]
fn touch_wall(
    law: &PairLaw,
    one: &Seen,
    (wall, normal, distance): (&Wall, Vector, f64),
    history: &mut ContactHistory,
    step: f64,
) -> Option<(Push, Vector)> {
    let overlap = one.radius - distance;
    if !law.touches(overlap, one.radius, history) {
        return None;
    }
    let arm = times(-distance, normal);
    let place = plus(one.position, arm);
    let meeting = Meeting {
        normal,
        overlap,
        radius: one.radius,
        mass: one.mass,
        inertias: [1.4 * one.mass * one.radius * one.radius, f64::INFINITY],
        velocity: minus(plus(one.velocity, cross(one.spin, arm)), wall.velocity_at(place)),
        spins: [one.spin, wall.spin()],
    };
    Some((law.push(&meeting, history, step), arm))
}
