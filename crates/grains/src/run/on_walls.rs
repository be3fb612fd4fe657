//! The contacts of spheres with walls in a step.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::{GrainContact, GrainPartner};
use crate::facet::by_place;
use crate::law::{ContactHistory, Meeting, PairLaw};
use crate::model::GrainModel;
use crate::on_facet::{Ball, FacetHistory, SurfaceMotion, SurfaceTotals};
use crate::on_surface::{Balls, Laws, OnSurface};
use crate::servo::{Answer, ServoMotion};
use crate::vector::{Vector, across, cross, dot, minus, plus, times};
use crate::wall::{Wall, WallShape};

/// Spheres that one thread computes at a time.
const CHUNK: usize = 512;

/// The memory of the contact of a sphere with a wall that is no mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct WallHistory {
    sphere: u32,
    contact: ContactHistory,
    /// Energy of its springs, J.
    springs: f64,
}

/// Everything of the walls that a run is continued from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct WallState {
    /// Contacts of each wall, by their spheres.
    histories: Vec<Vec<WallHistory>>,
    on_meshes: Vec<Vec<(u32, Vec<FacetHistory>)>>,
    servos: Vec<ServoMotion>,
    /// See [`OnWalls`].
    dissipated: f64,
    external: f64,
}

/// A wall that is a mesh.
#[derive(Debug)]
struct WallMesh {
    /// Points at the beginning, and now, m.
    first: Vec<Vector>,
    now: Vec<Vector>,
    corners: Vec<[u32; 3]>,
    moves: bool,
    on: OnSurface,
}

/// Contacts of the spheres of a chunk with walls that are no meshes.
#[derive(Default)]
struct Part {
    on_spheres: Vec<(u32, [Vector; 2])>,
    /// By walls.
    histories: Vec<Vec<WallHistory>>,
    contacts: Vec<GrainContact>,
    /// Wall, sphere and sums of each contact.
    totals: Vec<(u32, u32, SurfaceTotals)>,
    wrong: Option<[u32; 2]>,
}

/// Walls, and the spheres that touch them.
#[derive(Debug)]
pub(super) struct OnWalls {
    /// Where the walls were in the last step, without triangles.
    placed: Vec<Wall>,
    histories: Vec<Vec<WallHistory>>,
    meshes: Vec<Option<WallMesh>>,
    servos: Vec<ServoMotion>,
    /// Force of the spheres on each wall, N, moment about the origin, N m.
    totals: Vec<SurfaceTotals>,
    /// Force, N, and moment, N m, on spheres, in ascending order of their places.
    on_spheres: Vec<(u32, [Vector; 2])>,
    contacts: Vec<GrainContact>,
    /// Dissipated since the beginning, and work of the walls on the spheres, J.
    pub(super) dissipated: f64,
    pub(super) external: f64,
}

impl WallState {
    /// Number of walls.
    pub(super) fn count(&self) -> usize {
        self.histories.len()
    }
}

impl WallMesh {
    fn new(triangles: &[[Vector; 3]], moves: bool, radius: f64) -> Self {
        // Corners at one place are one; -0 is 0.
        let mut numbers: BTreeMap<PointKey, u32> = BTreeMap::new();
        let mut first = Vec::new();
        let corners = triangles.iter().map(|triangle| {
            triangle.map(|corner| {
                let place = corner.map(|x| x + 0.0);
                *numbers.entry(PointKey(place)).or_insert_with(|| {
                    first.push(place);
                    first.len() as u32 - 1
                })
            })
        });
        let corners = corners.collect();
        Self { now: first.clone(), first, corners, moves, on: OnSurface::new(false, radius) }
    }
}

/// A place as a key.
#[derive(Clone, Copy, Debug)]
struct PointKey(Vector);

impl Ord for PointKey {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        by_place(self.0, other.0)
    }
}

impl PartialOrd for PointKey {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for PointKey {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for PointKey {}

impl OnWalls {
    /// `radius`: mean radius of the spheres, m.
    pub(super) fn new(model: &GrainModel, radius: f64) -> Self {
        let walls = &model.walls;
        let mesh = |wall: &Wall| match &wall.shape {
            WallShape::Mesh { triangles } => Some(WallMesh::new(triangles, wall.moves(), radius)),
            _ => None,
        };
        let servos = vec![ServoMotion::default(); walls.len()];
        Self {
            placed: walls.iter().map(|wall| wall.at(0.0, &ServoMotion::default(), false)).collect(),
            histories: vec![Vec::new(); walls.len()],
            meshes: walls.iter().map(mesh).collect(),
            servos,
            totals: vec![SurfaceTotals::default(); walls.len()],
            on_spheres: Vec::new(),
            contacts: Vec::new(),
            dissipated: 0.0,
            external: 0.0,
        }
    }

    /// Computes the contacts of all spheres with the walls at a time, s, and moves the servos.
    ///
    /// # Errors
    /// Two materials that touch and have no law.
    pub(super) fn press(
        &mut self,
        balls: &impl Balls,
        model: &GrainModel,
        laws: Laws<'_>,
        time: f64,
    ) -> Result<(), [u32; 2]> {
        self.on_spheres.clear();
        self.contacts.clear();
        if model.walls.is_empty() {
            return Ok(());
        }
        let walls = model.walls.iter().zip(&self.servos);
        self.placed = walls.map(|(wall, servo)| wall.at(time, servo, false)).collect();
        self.press_shapes(balls, laws)?;
        for number in 0..model.walls.len() {
            self.press_mesh(number, balls, (&model.walls[number], laws), time)?;
        }
        self.contacts.sort_by_key(|of| of.sphere);
        self.on_spheres.sort_by_key(|of| of.0);
        for (wall, (motion, total)) in model.walls.iter().zip(self.servos.iter_mut().zip(&self.totals)) {
            self.dissipated += total.dissipated;
            self.external -= total.work;
            if let Some(servo) = &wall.servo {
                let answer = Answer { stiffness: total.stiffness, damping: total.damping };
                servo.follow(motion, total.force, answer, laws.step);
            }
        }
        Ok(())
    }

    /// Force of the spheres on a wall in the last step, N.
    pub(super) fn force(&self, wall: usize) -> Vector {
        self.totals[wall].force
    }

    /// Moment of the spheres on a wall in the last step about the origin, N m.
    pub(super) fn moment(&self, wall: usize) -> Vector {
        self.totals[wall].moment
    }

    /// The walls at a time, s.
    pub(super) fn at<'a>(&'a self, walls: &'a [Wall], time: f64) -> impl Iterator<Item = Wall> + 'a {
        walls.iter().zip(&self.servos).map(move |(wall, servo)| wall.at(time, servo, true))
    }

    /// Force, N, and moment, N m, on spheres in the last step, in ascending order of their places.
    pub(super) fn on_spheres(&self) -> &[(u32, [Vector; 2])] {
        &self.on_spheres
    }

    /// Contacts in the last step, by their spheres.
    pub(super) fn contacts(&self) -> &[GrainContact] {
        &self.contacts
    }

    /// Elastic energy of the contacts of spheres at a time, s, J.
    pub(super) fn elastic(&self, balls: &impl Balls, model: &GrainModel, laws: Laws<'_>, time: f64) -> f64 {
        let mut energy = 0.0;
        let places = places_of(balls);
        for (number, wall) in model.walls.iter().enumerate() {
            let placed = wall.at(time, &self.servos[number], false);
            for history in &self.histories[number] {
                let ball = balls.ball(places[history.sphere as usize] as usize);
                let (_, distance) = placed.nearest(ball.position);
                if let Some(law) = &laws.pairs[ball.material as usize * laws.kinds + wall.material as usize] {
                    energy += history.springs + law.energy_reduced(ball.radius - distance, None, ball.radius);
                }
            }
            if let Some(mesh) = &self.meshes[number] {
                let placement = wall.placement(time, &self.servos[number]);
                let points: Vec<Vector> = mesh.first.iter().map(|point| placement.of(*point)).collect();
                energy += mesh.on.elastic(balls, &points, &[wall.material], laws);
            }
        }
        energy
    }

    /// Everything that a run is continued from.
    pub(super) fn state(&self, balls: &impl Balls) -> WallState {
        let on_mesh =
            |mesh: &Option<WallMesh>| mesh.as_ref().map_or_else(Vec::new, |mesh| mesh.on.state(balls));
        WallState {
            histories: self.histories.clone(),
            on_meshes: self.meshes.iter().map(on_mesh).collect(),
            servos: self.servos.clone(),
            dissipated: self.dissipated,
            external: self.external,
        }
    }

    /// Continues from a state. Returns whether it has as many walls.
    pub(super) fn restore(&mut self, state: WallState, balls: &impl Balls) -> bool {
        let WallState { histories, on_meshes, servos, dissipated, external } = state;
        let count = self.placed.len();
        if [histories.len(), on_meshes.len(), servos.len()].iter().any(|&length| length != count) {
            return false;
        }
        for (mesh, saved) in self.meshes.iter_mut().zip(on_meshes) {
            if let Some(mesh) = mesh {
                mesh.on.restore(saved, balls);
            }
        }
        (self.histories, self.servos) = (histories, servos);
        (self.dissipated, self.external) = (dissipated, external);
        true
    }

    /// Contacts with walls that are no meshes.
    fn press_shapes(&mut self, balls: &impl Balls, laws: Laws<'_>) -> Result<(), [u32; 2]> {
        let Self { placed, histories, .. } = self;
        let chunks: Vec<usize> = (0..balls.count()).step_by(CHUNK).collect();
        let parts = chunks.into_par_iter().map(|begin| {
            let mut part = Part { histories: vec![Vec::new(); placed.len()], ..Part::default() };
            for place in begin..(begin + CHUNK).min(balls.count()) {
                part.press(place, balls, (placed, histories), laws);
            }
            part
        });
        let parts: Vec<Part> = parts.collect();
        if let Some(wrong) = parts.iter().find_map(|part| part.wrong) {
            return Err(wrong);
        }
        let mut totals: Vec<(u32, u32, SurfaceTotals)> = Vec::new();
        for (list, total) in histories.iter_mut().zip(&mut self.totals) {
            let springs = list.iter().map(|of| of.springs).sum();
            *total = SurfaceTotals { dissipated: springs, ..SurfaceTotals::default() };
            list.clear();
        }
        for part in parts {
            self.on_spheres.extend(part.on_spheres);
            self.contacts.extend(part.contacts);
            totals.extend(part.totals);
            for (list, more) in histories.iter_mut().zip(part.histories) {
                list.extend(more);
            }
        }
        for list in histories {
            list.sort_by_key(|of| of.sphere);
        }
        totals.sort_by_key(|&(wall, sphere, _)| (wall, sphere));
        for (wall, _, of) in &totals {
            self.totals[*wall as usize].add(of);
        }
        Ok(())
    }

    /// Contacts with a wall that is a mesh.
    fn press_mesh(
        &mut self,
        number: usize,
        balls: &impl Balls,
        (wall, laws): (&Wall, Laws<'_>),
        time: f64,
    ) -> Result<(), [u32; 2]> {
        let Some(WallMesh { first, now, corners, moves, on }) = &mut self.meshes[number] else {
            return Ok(());
        };
        if *moves {
            let placement = wall.placement(time, &self.servos[number]);
            now.par_iter_mut().zip(&*first).with_min_len(CHUNK).for_each(|(now, first)| {
                *now = placement.of(*first);
            });
        }
        on.place(now, corners);
        let motion = SurfaceMotion::Wall(&self.placed[number]);
        on.press(balls, &[wall.material], motion, wall.servo.map(|of| of.unit()), laws)?;
        self.totals[number] = on.totals;
        self.on_spheres.extend(on.on_spheres());
        self.contacts.extend(on.contacts.iter().map(|of| of.named(GrainPartner::Wall(number as u32))));
        Ok(())
    }
}

impl Part {
    /// Computes the contacts of a sphere.
    fn press(
        &mut self,
        place: usize,
        balls: &impl Balls,
        (walls, histories): (&[Wall], &[Vec<WallHistory>]),
        laws: Laws<'_>,
    ) {
        let (position, radius) = (balls.position(place), balls.radius(place));
        let (mut sum, mut touches) = ([[0.0; 3]; 2], false);
        for (number, wall) in walls.iter().enumerate() {
            let (normal, distance) = wall.nearest(position);
            if distance >= radius && (!laws.sticks || distance == f64::INFINITY) {
                continue;
            }
            let ball = balls.ball(place);
            let Some(law) = &laws.pairs[ball.material as usize * laws.kinds + wall.material as usize] else {
                self.wrong = self.wrong.or((distance < radius).then_some([ball.material, wall.material]));
                continue;
            };
            let known = histories[number].binary_search_by_key(&ball.number, |of| of.sphere);
            let mut history = known.map_or_else(|_| WallHistory::default(), |k| histories[number][k]);
            history.sphere = ball.number;
            if !law.touches(radius - distance, radius, &history.contact) {
                continue;
            }
            let of = OneWall { wall, number: number as u32, normal, distance };
            let [force, moment] = self.touch(&ball, law, &of, history, laws.step);
            sum = [plus(sum[0], force), plus(sum[1], moment)];
            touches = true;
        }
        if touches {
            self.on_spheres.push((place as u32, sum));
        }
    }

    /// Force and moment of a wall on a sphere.
    fn touch(
        &mut self,
        ball: &Ball,
        law: &PairLaw,
        of: &OneWall<'_>,
        mut history: WallHistory,
        step: f64,
    ) -> [Vector; 2] {
        let (overlap, normal) = (ball.radius - of.distance, of.normal);
        let arm = times(-of.distance, normal);
        let place = plus(ball.position, arm);
        let [velocity, spin] = [of.wall.velocity_at(place), of.wall.spin()];
        let meeting = Meeting {
            normal,
            overlap,
            radius: ball.radius,
            mass: ball.mass,
            inertias: [ball.inertia + ball.mass * ball.radius * ball.radius, f64::INFINITY],
            velocity: minus(plus(ball.velocity, cross(ball.spin, arm)), velocity),
            spins: [ball.spin, spin],
        };
        let reduced = law.push_reduced(&meeting, None, &mut history.contact, step);
        let push = reduced.push;
        history.springs = law.energy_of_springs(&history.contact, ball.radius, reduced.stiffness);
        let friction =
            dot(across(push.force, normal), meeting.velocity) + dot(push.moment, minus(ball.spin, spin));
        let [back, turn_back] = [push.force, push.moment].map(|vector| times(-1.0, vector));
        let direction = of.wall.servo.map_or([0.0; 3], |servo| servo.unit());
        self.totals.push((
            of.number,
            ball.number,
            SurfaceTotals {
                force: back,
                moment: plus(cross(place, back), turn_back),
                elastic: history.springs + law.energy_reduced(overlap, None, ball.radius),
                dissipated: step * (reduced.dashpot - friction) - history.springs,
                work: step * (dot(back, velocity) + dot(turn_back, spin)),
                stiffness: reduced.stiffness * dot(normal, direction).powi(2),
                damping: reduced.damping * dot(normal, direction).powi(2),
            },
        ));
        self.contacts.push(GrainContact {
            sphere: ball.number,
            other: GrainPartner::Wall(of.number),
            place,
            force: push.force,
            normal: dot(push.force, normal),
            overlap,
        });
        self.histories[of.number as usize].push(history);
        [push.force, plus(cross(arm, push.force), push.moment)]
    }
}

/// A wall as a sphere sees it.
struct OneWall<'a> {
    wall: &'a Wall,
    number: u32,
    /// From the wall to the sphere, and the distance of its centre, m.
    normal: Vector,
    distance: f64,
}

/// The place of each sphere, by its number.
fn places_of(balls: &impl Balls) -> Vec<u32> {
    let most = (0..balls.count()).map(|place| balls.number(place) + 1).max().unwrap_or(0);
    let mut places = vec![0; most as usize];
    for place in 0..balls.count() {
        places[balls.number(place) as usize] = place as u32;
    }
    places
}
