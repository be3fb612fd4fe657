//! Contacts of spheres with walls.
//!
//! This is the door for everything that acts on spheres from outside: each contact is an [`Outer`], and the
//! motion adds them to the forces of the other spheres in their order.

use fdem_contact::prefetch;
use rayon::prelude::*;

use crate::error::GrainError;
use crate::law::{ContactHistory, Meeting};
use crate::run::balls::{Ball, Balls};
use crate::run::depth::Depth;
use crate::run::laws::Laws;
use crate::vector::{Vector, cross, dot, length, minus, plus, times};
use crate::wall::{Wall, WallShape};

/// Spheres that one thread computes at a time.
const CHUNK: usize = 256;

/// Spheres ahead that are prefetched: they are in the order of their numbers, and not as they lie in memory.
const AHEAD: usize = 8;

/// The action of a wall or a body on a sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outer {
    pub(crate) place: u32,
    /// On the sphere, N, and about its centre, N m.
    pub(crate) force: Vector,
    pub(crate) moment: Vector,
    /// Energy that the step dissipates, and work on the sphere from outside, J.
    pub(crate) dissipated: f64,
    pub(crate) external: f64,
}

/// A sphere that touches a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallTouch {
    pub(crate) wall: u32,
    /// Number of the sphere.
    pub(crate) number: u32,
    pub(crate) history: ContactHistory,
    /// m.
    pub(crate) overlap: f64,
    /// From the wall to the sphere, of unit length, and where they touch, m.
    pub(crate) normal: Vector,
    pub(crate) at: Vector,
    pub(crate) outer: Outer,
}

/// Contacts of a wall that persist: numbers of spheres, ascending, with their memory.
pub(crate) type OnWall = Vec<(u32, ContactHistory)>;

/// Contacts with walls of all shapes but triangles.
#[derive(Debug, Default)]
pub(crate) struct OnWalls {
    /// For each wall the places of spheres near it, in ascending order of their numbers.
    near: Vec<Vec<u32>>,
    /// How far spheres and walls can still move until others might touch, m.
    spare: f64,
    /// Bound on the distance of spheres from the axes of walls that turn, m.
    reach: f64,
    /// Contacts of the last step, by walls, then by spheres.
    pub(crate) touches: Vec<WallTouch>,
    /// Contacts of the step before that one. The next step reuses the memory.
    before: Vec<WallTouch>,
    /// The deepest contact of the last step.
    pub(crate) deepest: Depth,
    /// Force of the spheres on each wall, N, and moment about its axis of rotation or the origin, N m.
    pub(crate) forces: Vec<[Vector; 2]>,
}

/// Everything that the contacts with walls of a step read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnWallsOf<'a> {
    pub(crate) balls: &'a Balls,
    pub(crate) laws: &'a Laws,
    /// The walls where they are.
    pub(crate) walls: &'a [Wall],
    /// Largest speed of spheres in the last step, m/s.
    pub(crate) fastest: f64,
    /// s.
    pub(crate) step: f64,
}

impl OnWalls {
    pub(crate) fn new(walls: usize) -> Self {
        Self {
            near: vec![Vec::new(); walls],
            spare: 0.0,
            reach: 0.0,
            touches: Vec::new(),
            before: Vec::new(),
            deepest: Depth::default(),
            forces: vec![[[0.0; 3]; 2]; walls],
        }
    }

    /// Spheres have other places: those near walls are listed again in the next step.
    pub(crate) fn renew(&mut self) {
        self.spare = 0.0;
    }

    /// The memory of all contacts, by walls.
    pub(crate) fn saved(&self) -> Vec<OnWall> {
        let mut saved = vec![Vec::new(); self.near.len()];
        for touch in &self.touches {
            saved[touch.wall as usize].push((touch.number, touch.history));
        }
        saved
    }

    /// Takes the memory of a saved run over.
    pub(crate) fn take(&mut self, saved: Vec<OnWall>) {
        let touch = |wall: u32, (number, history): (u32, ContactHistory)| WallTouch {
            wall,
            number,
            history,
            overlap: 0.0,
            normal: [0.0; 3],
            at: [0.0; 3],
            outer: Outer { place: 0, force: [0.0; 3], moment: [0.0; 3], dissipated: 0.0, external: 0.0 },
        };
        let of_wall = |(wall, list): (u32, OnWall)| list.into_iter().map(move |of| touch(wall, of));
        self.touches = (0..).zip(saved).flat_map(of_wall).collect();
    }

    /// Computes all contacts of a step, and adds their actions to `outer`.
    ///
    /// # Errors
    /// Two materials that touch have no law.
    pub(crate) fn press(&mut self, of: OnWallsOf<'_>, outer: &mut Vec<Outer>) -> Result<(), GrainError> {
        if of.walls.is_empty() {
            return Ok(());
        }
        let speed = |wall: &Wall| length(wall.velocity) + length(wall.spin()) * self.reach;
        let moved = of.step * (of.fastest + of.walls.iter().map(speed).fold(0.0, f64::max));
        self.spare -= moved;
        if self.spare <= 0.0 {
            self.list_near(of, moved);
        }
        let Self { near, touches, before, deepest, forces, .. } = self;
        std::mem::swap(touches, before);
        touches.clear();
        *deepest = Depth::default();
        let mut rest = before.as_slice();
        for ((number, wall), near) in (0_u32..).zip(of.walls).zip(near) {
            let (own, more) = rest.split_at(rest.partition_point(|touch| touch.wall <= number));
            rest = more;
            let found = near.par_chunks(CHUNK).map(|near| on_wall(of, (number, wall), near, own));
            let chunks: Vec<_> = found.collect();
            let mut sums = [[0.0; 3]; 2];
            let centre = wall.rotation.map_or([0.0; 3], |rotation| rotation.through);
            for chunk in chunks {
                let mut found = chunk?;
                outer.extend(found.partings);
                for touch in &found.touches {
                    let force = touch.outer.force;
                    sums[0] = minus(sums[0], force);
                    sums[1] = minus(sums[1], cross(minus(touch.at, centre), force));
                    outer.push(touch.outer);
                }
                touches.append(&mut found.touches);
                *deepest = deepest.or(found.deepest);
            }
            forces[number as usize] = sums;
        }
        Ok(())
    }

    /// Lists the spheres that may touch a wall before they and it have moved by a quarter of the mean radius,
    /// or by 20 steps.
    fn list_near(&mut self, of: OnWallsOf<'_>, moved: f64) {
        let balls = of.balls;
        let mean = balls.list.iter().map(|ball| ball.radius).sum::<f64>() / balls.list.len().max(1) as f64;
        self.spare = (0.25 * mean).max(20.0 * moved);
        self.reach = farthest(of.walls, balls) + self.spare;
        let reach = self.spare + of.laws.reach(2.0 * mean);
        let near = |wall: &Wall| {
            if matches!(wall.shape, WallShape::Mesh { .. }) {
                return Vec::new();
            }
            let along = wall.along();
            let is_near = |place: &u32| {
                let ball = &balls.list[*place as usize];
                wall.nearest_along(ball.position, along).1 < ball.radius + reach
            };
            balls.places.par_iter().copied().filter(is_near).collect()
        };
        self.near = of.walls.iter().map(near).collect();
    }
}

/// Contacts of some spheres with a wall.
#[derive(Default)]
struct Found {
    touches: Vec<WallTouch>,
    /// The losses of those that have parted.
    partings: Vec<Outer>,
    deepest: Depth,
}

/// Contacts of spheres with a wall. `before`: those of the last step with this wall.
fn on_wall(
    of: OnWallsOf<'_>,
    (number, wall): (u32, &Wall),
    near: &[u32],
    before: &[WallTouch],
) -> Result<Found, GrainError> {
    let along = wall.along();
    let mut found = Found { touches: Vec::with_capacity(near.len()), ..Found::default() };
    let first = near.first().map_or(0, |&place| of.balls.list[place as usize].number);
    let mut before = &before[before.partition_point(|touch| touch.number < first)..];
    for (k, &place) in near.iter().enumerate() {
        if let Some(&place) = near.get(k + AHEAD) {
            prefetch(&of.balls.list[place as usize]);
        }
        let ball = &of.balls.list[place as usize];
        while before.first().is_some_and(|touch| touch.number < ball.number) {
            before = &before[1..];
        }
        let (normal, distance) = wall.nearest_along(ball.position, along);
        let known = before.first().filter(|touch| touch.number == ball.number);
        if distance >= ball.radius && known.is_none() {
            continue;
        }
        let law = of.laws.of([ball.material, wall.material])?;
        let overlap = ball.radius - distance;
        let mut history = known.map(|touch| touch.history).unwrap_or_default();
        let none = Outer { place, force: [0.0; 3], moment: [0.0; 3], dissipated: 0.0, external: 0.0 };
        if !law.touches(overlap, ball.radius, &history) {
            found.partings.push(Outer { dissipated: law.lost(ball.radius, &history), ..none });
            continue;
        }
        let arm = times(-distance, normal);
        let at = plus(ball.position, arm);
        let moving = wall.velocity_at(at);
        let push = law.push(
            &meeting(of.balls.share, ball, (wall, moving), (normal, arm, overlap)),
            &mut history,
            of.step,
        );
        found.deepest = found.deepest.or(Depth::of(overlap, ball));
        found.touches.push(WallTouch {
            wall: number,
            number: ball.number,
            history,
            overlap,
            normal,
            at,
            outer: Outer {
                place,
                force: push.force,
                moment: plus(cross(arm, push.force), push.moment),
                dissipated: push.dissipated,
                external: of.step * (dot(push.force, moving) + dot(push.moment, wall.spin())),
            },
        });
    }
    Ok(found)
}

/// A sphere and a wall in a step. `moving`: velocity of the wall at the contact, m/s; `arm`: from the centre
/// of the sphere to the contact, m.
fn meeting(
    share: f64,
    ball: &Ball,
    (wall, moving): (&Wall, Vector),
    (normal, arm, overlap): (Vector, Vector, f64),
) -> Meeting {
    Meeting {
        normal,
        overlap,
        radius: ball.radius,
        mass: ball.mass,
        inertias: [(share + 1.0) * ball.mass * ball.radius * ball.radius, f64::INFINITY],
        velocity: minus(plus(ball.velocity, cross(ball.spin, arm)), moving),
        spins: [ball.spin, wall.spin()],
    }
}

/// Largest distance of a sphere from a point about which a wall turns, m.
fn farthest(walls: &[Wall], balls: &Balls) -> f64 {
    let turning = walls.iter().filter_map(|wall| wall.rotation);
    let square = |centre: Vector| {
        let apart = balls.list.iter().map(|ball| minus(ball.position, centre));
        apart.map(|apart| dot(apart, apart)).fold(0.0, f64::max)
    };
    turning.map(|rotation| square(rotation.through)).fold(0.0, f64::max).sqrt()
}
