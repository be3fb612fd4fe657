//! The motion of the spheres in a step.

#![allow(clippy::inline_always, reason = "what is compiled for vector instructions must be inlined")]

use fdem_contact::{Simd, prefetch};
use rayon::prelude::*;

use crate::domain::Outside;
use crate::error::GrainError;
use crate::run::balls::{ALONE, Ball, BallKind, Balls, Drive};
use crate::run::cell::RunBox;
use crate::run::depth::Depth;
use crate::run::level::{self, Level, Work};
use crate::run::lists::{CHUNK, Lists};
use crate::run::on_walls::Outer;
use crate::vector::{Vector, dot, minus, plus, times};

/// Number of spheres whose actions are prefetched together.
const BLOCK: usize = 64;

/// A sphere farther away than this is lost, m.
pub(crate) const FARTHEST: f64 = 1e30;

/// Everything that the motion of a step reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moving<'a> {
    pub(crate) lists: &'a Lists,
    /// Contacts with walls and bodies, by places.
    pub(crate) outer: &'a [Outer],
    pub(crate) cell: Option<&'a RunBox>,
    pub(crate) simd: Simd,
    /// The velocity with which most spheres go, m/s.
    pub(crate) stream: Vector,
    /// m/s².
    pub(crate) gravity: Vector,
    /// s.
    pub(crate) step: f64,
    pub(crate) number: u64,
}

/// The motion of all spheres in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moved {
    /// Largest speed, m/s.
    pub(crate) fastest: f64,
    /// Largest speed against the stream, m/s.
    pub(crate) spread: f64,
    /// Whether a sphere has left the box, and is to be removed.
    pub(crate) leaves: bool,
    /// The deepest overlap of two spheres.
    pub(crate) deepest: Depth,
}

impl Moved {
    /// The motion of these spheres and others.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            fastest: self.fastest.max(other.fastest),
            spread: self.spread.max(other.spread),
            leaves: self.leaves | other.leaves,
            deepest: self.deepest.or(other.deepest),
        }
    }
}

/// Adds up the forces on each sphere in one order, and moves it: spheres in the order of their numbers, then
/// walls, then bodies.
///
/// # Errors
/// The sphere with the lowest number that has no place any more, or that has left the box.
pub(crate) fn move_all(balls: &mut Balls, of: Moving<'_>) -> Result<Moved, GrainError> {
    let share = balls.share;
    let chunks = balls.list.par_chunks_mut(CHUNK).zip(balls.drives.par_chunks_mut(CHUNK));
    // Empty without clumps.
    let mut pushes: Vec<&mut [[Vector; 2]]> = balls.pushes.chunks_mut(CHUNK).collect();
    pushes.resize_with(balls.kinds.len().div_ceil(CHUNK), Default::default);
    let chunks = chunks.zip(balls.kinds.par_chunks(CHUNK)).zip(pushes).enumerate();
    let parts: Vec<Result<Moved, (u32, GrainError)>> = chunks
        .map_init(OfBlock::default, |touching, (chunk, (((balls, drives), kinds), pushes))| {
            level::run(
                of.simd,
                MoveChunk { begin: chunk * CHUNK, touching, balls, drives, kinds, pushes, share, of },
            )
        })
        .collect();
    let mut all = Moved::default();
    let mut first: Option<(u32, GrainError)> = None;
    for part in parts {
        match part {
            Ok(moved) => all = all.and(moved),
            Err((number, error)) => {
                if first.as_ref().is_none_or(|(lowest, _)| number < *lowest) {
                    first = Some((number, error));
                }
            }
        }
    }
    first.map_or(Ok(all), |(_, error)| Err(error))
}

/// The motion of the spheres of a chunk, as work.
struct MoveChunk<'a, 'b> {
    begin: usize,
    touching: &'b mut OfBlock,
    balls: &'a mut [Ball],
    drives: &'a mut [Drive],
    kinds: &'a [BallKind],
    pushes: &'a mut [[Vector; 2]],
    share: f64,
    of: Moving<'a>,
}

impl Work for MoveChunk<'_, '_> {
    type Done = Result<Moved, (u32, GrainError)>;

    #[inline(always)]
    fn run<L: Level>(self) -> Self::Done {
        let Self { begin, touching, balls, drives, kinds, pushes, share, of } = self;
        let mut outer = &of.outer[of.outer.partition_point(|outer| (outer.place as usize) < begin)..];
        let mut moved = Moved::default();
        let (mut fastest, mut spread) = (0.0_f64, 0.0_f64);
        let mut lost: Option<(u32, GrainError)> = None;
        let count = balls.len();
        for (k, ((ball, drive), kind)) in balls.iter_mut().zip(drives).zip(kinds).enumerate() {
            let place = begin + k;
            if k % BLOCK == 0 {
                touching.fill(of.lists, place, BLOCK.min(count - k));
            }
            let ([mut force, mut moment], overlap) =
                sums(of.lists, touching.of(k % BLOCK), ball.radius, drive);
            if overlap > 0.0 {
                moved.deepest = moved.deepest.or(Depth::of(overlap, ball));
            }
            while outer.first().is_some_and(|outer| outer.place as usize == place) {
                force = plus(force, outer[0].force);
                moment = plus(moment, outer[0].moment);
                drive.dissipated += outer[0].dissipated;
                drive.external += outer[0].external;
                outer = &outer[1..];
            }
            if kind.clump != ALONE {
                // Its clump moves it.
                pushes[k] = [force, moment];
                continue;
            }
            if kind.held {
                drive.external -= of.step * (dot(force, ball.velocity) + dot(moment, ball.spin));
            }
            advance(ball, drive, *kind, (force, moment), (share, of));
            fastest = fastest.max(dot(drive.velocity, drive.velocity));
            let against = minus(drive.velocity, of.stream);
            spread = spread.max(dot(against, against));
            let error = if ball.position.iter().all(|x| x.abs() < FARTHEST) {
                match of.cell.and_then(|cell| cell.outside(ball.position)) {
                    Some(Outside::Stop) => GrainError::Outside { sphere: ball.number, step: of.number },
                    leaves => {
                        moved.leaves |= leaves.is_some();
                        continue;
                    }
                }
            } else {
                GrainError::Lost { sphere: ball.number as usize, step: of.number }
            };
            if lost.as_ref().is_none_or(|(lowest, _)| ball.number < *lowest) {
                lost = Some((ball.number, error));
            }
        }
        (moved.fastest, moved.spread) = (fastest.sqrt(), spread.sqrt());
        lost.map_or(Ok(moved), Err)
    }
}

/// A contact of a sphere: the places of its action and of its couple, and whether the sphere is its second.
#[derive(Clone, Copy)]
struct Touching {
    acted: u32,
    slot: u32,
    is_second: bool,
}

/// The contacts of the spheres of a block.
#[derive(Default)]
struct OfBlock {
    list: Vec<Touching>,
    /// End of the contacts of each sphere in `list`.
    ends: Vec<u32>,
}

impl OfBlock {
    /// Lists the contacts of `count` spheres from a place on, and prefetches their actions.
    #[inline(never)]
    fn fill(&mut self, lists: &Lists, begin: usize, count: usize) {
        self.list.clear();
        self.ends.clear();
        for range in lists.first_incident[begin..=begin + count].windows(2) {
            lists.touching.within(range[0]..range[1], |index| {
                let incident = lists.incidents[index as usize];
                let slot = incident / 2;
                let acted = lists.acted[slot as usize];
                prefetch(&lists.acting[acted as usize]);
                self.list.push(Touching { acted, slot, is_second: incident & 1 == 1 });
            });
            self.ends.push(self.list.len() as u32);
        }
    }

    /// Returns the contacts of sphere `k` of the block.
    #[inline(always)]
    fn of(&self, k: usize) -> &[Touching] {
        let begin = if k == 0 { 0 } else { self.ends[k - 1] };
        &self.list[begin as usize..self.ends[k] as usize]
    }
}

/// Force, N, and moment, N m, of all spheres on one, and its deepest overlap, m. Adds the energy that its
/// contacts have dissipated to its sum.
#[inline(always)]
fn sums(lists: &Lists, touching: &[Touching], radius: f64, drive: &mut Drive) -> ([Vector; 2], f64) {
    // Rows of four numbers are one operation of a vector.
    let (mut pushes, mut moment) = ([0.0, 0.0, 0.0, drive.dissipated], [0.0; 3]);
    let mut deepest = 0.0_f64;
    for of in touching {
        let acting = &lists.acting[of.acted as usize];
        let (sign, once) = if of.is_second { (-1.0, 0.0) } else { (1.0, 1.0) };
        let [x, y, z] = acting.force;
        let push = [x, y, z, acting.dissipated];
        let scale = [sign, sign, sign, once];
        pushes = [0, 1, 2, 3].map(|k: usize| pushes[k] + scale[k] * push[k]);
        moment = plus(moment, times(radius - 0.5 * acting.overlap, acting.torque));
        deepest = if acting.overlap > deepest { acting.overlap } else { deepest };
        if let Some(rolling) = lists.rolling.get(of.slot as usize) {
            moment = plus(moment, times(sign, rolling.moment));
        }
        if let Some(work) = lists.stretched.get(of.slot as usize) {
            drive.external += once * work;
        }
    }
    let [x, y, z, dissipated] = pushes;
    drive.dissipated = dissipated;
    ([[x, y, z], moment], deepest)
}

/// Moves a sphere under a force, N, and a moment, N m, for a step.
#[inline(always)]
fn advance(
    ball: &mut Ball,
    drive: &mut Drive,
    kind: BallKind,
    (force, moment): (Vector, Vector),
    (share, of): (f64, Moving<'_>),
) {
    let half = 0.5 * of.step;
    if !kind.held {
        let mut acceleration = plus(times(1.0 / ball.mass, force), of.gravity);
        if let Some(cell) = of.cell.filter(|cell| cell.grows()) {
            // The velocity is that over the motion of the box, which takes the sphere along.
            let rates = cell.rates();
            let v = ball.velocity;
            let slowing = [rates[0] * v[0], rates[1] * v[1], rates[2] * v[2]];
            acceleration = minus(acceleration, slowing);
            drive.external -= of.step * ball.mass * dot(v, slowing);
        }
        let turning = times(1.0 / (share * ball.mass * ball.radius * ball.radius), moment);
        drive.velocity = plus(drive.velocity, times(of.step, acceleration));
        drive.spin = plus(drive.spin, times(of.step, turning));
        ball.velocity = plus(drive.velocity, times(half, acceleration));
        ball.spin = plus(drive.spin, times(half, turning));
    }
    let mut velocity = drive.velocity;
    if let Some(cell) = of.cell.filter(|cell| cell.grows()) {
        velocity = plus(velocity, cell.drift(ball.position));
    }
    ball.position = plus(ball.position, times(of.step, velocity));
    if let Some(cell) = of.cell {
        let place = ball.position;
        ball.position = cell.wrapped(place);
        // A sphere that comes in on the other side has another potential energy.
        drive.external -= ball.mass * dot(of.gravity, minus(ball.position, place));
    }
}
