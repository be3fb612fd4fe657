//! The motion of the spheres in a step.

#![allow(clippy::inline_always, reason = "what is compiled for vector instructions must be inlined")]

use fdem_contact::{Simd, prefetch};
use rayon::prelude::*;

use crate::domain::Outside;
use crate::error::GrainError;
use crate::run::balls::{ALONE, Ball, BallKind, Balls, Drive};
use crate::run::cell::RunBox;
use crate::run::contacts::{CHUNK, Contacts, Entry};
use crate::run::depth::Depth;
use crate::run::level::{self, Level, Work};
use crate::run::on_walls::Outer;
use crate::run::rows::{and, larger, less, row, square};
use crate::vector::{Vector, dot, minus};

/// Number of spheres whose forces are added up together.
const BLOCK: usize = 64;

/// Contacts ahead whose forces are prefetched.
const AHEAD: usize = 48;

/// Contacts with walls and bodies ahead that are prefetched.
const OUTER_AHEAD: usize = 4;

/// Signs of the force of a contact on its first and its second sphere. The first also has the energy that is
/// dissipated.
const SIGNS: [[f64; 4]; 2] = [[1.0; 4], [-1.0, -1.0, -1.0, 0.0]];

/// A sphere farther away than this is lost, m.
pub(crate) const FARTHEST: f64 = 1e30;

/// Everything that the motion of a step reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moving<'a> {
    pub(crate) contacts: &'a Contacts,
    /// Contacts with walls and bodies; and the place of the sphere and the index of each, ascending.
    pub(crate) outer: (&'a [Outer], &'a [(u32, u32)]),
    pub(crate) cell: Option<&'a RunBox>,
    pub(crate) simd: Simd,
    /// The velocity with which most spheres go, m/s.
    pub(crate) stream: Vector,
    /// The deepest overlap so far, over the radius of its sphere.
    pub(crate) deepest: f64,
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
        .map(|(chunk, (((balls, drives), kinds), pushes))| {
            level::run(of.simd, MoveChunk { chunk, balls, drives, kinds, pushes, share, of })
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
struct MoveChunk<'a> {
    chunk: usize,
    balls: &'a mut [Ball],
    drives: &'a mut [Drive],
    kinds: &'a [BallKind],
    pushes: &'a mut [[Vector; 2]],
    share: f64,
    of: Moving<'a>,
}

impl Work for MoveChunk<'_> {
    type Done = Result<Moved, (u32, GrainError)>;

    #[inline(always)]
    fn run<L: Level>(self) -> Self::Done {
        let Self { chunk, balls, drives, kinds, pushes, share, of } = self;
        let begin = chunk * CHUNK;
        let (outer, order) = of.outer;
        let mut order = &order[order.partition_point(|(place, _)| (*place as usize) < begin)..];
        let entries = of.contacts.chunks.get(chunk).map_or(&[][..], |chunk| &chunk.entries);
        let mut moved = Moved::default();
        let (mut fastest, mut spread, mut added) = (0.0_f64, 0.0_f64, 0);
        let mut lost: Option<(u32, GrainError)> = None;
        let rule = Rule::new(of, share);
        let mut later = drives;
        for (block, (balls, kinds)) in balls.chunks_mut(BLOCK).zip(kinds.chunks(BLOCK)).enumerate() {
            let drives;
            (drives, later) = later.split_at_mut(balls.len());
            let mut sums = [SphereSums::default(); BLOCK];
            let adding = AddUp { of, entries, begin: added, block, sums: &mut sums, balls, drives };
            let (end, depth) = level::run(of.simd, adding);
            added = end;
            moved.deepest = moved.deepest.or(depth);
            let spheres = balls.iter_mut().zip(drives).zip(kinds).zip(&mut sums).enumerate();
            for (k, (((ball, drive), kind), sums)) in spheres {
                let place = begin + block * BLOCK + k;
                if let Some(drive) = later.get(k) {
                    prefetch(drive);
                }
                while let Some(&(_, index)) = order.first().filter(|(of, _)| *of as usize == place) {
                    if let Some(&(_, ahead)) = order.get(OUTER_AHEAD) {
                        prefetch(&outer[ahead as usize]);
                    }
                    sums.add(&outer[index as usize], drive);
                    order = &order[1..];
                }
                if kind.clump != ALONE {
                    // Its clump moves it.
                    drive.dissipated += sums.force[3];
                    pushes[place - begin] = sums.vectors();
                    continue;
                }
                let velocity = rule.advance(ball, drive, kind.held, sums);
                fastest = larger(square(velocity), fastest);
                spread = larger(square(less(velocity, rule.stream)), spread);
                if rule.is_inside(ball) {
                    continue;
                }
                match rule.bring_back(ball, drive) {
                    Ok(leaves) => moved.leaves |= leaves,
                    Err(error) if lost.as_ref().is_none_or(|(lowest, _)| ball.number < *lowest) => {
                        lost = Some((ball.number, error));
                    }
                    Err(_) => {}
                }
            }
        }
        (moved.fastest, moved.spread) = (fastest.sqrt(), spread.sqrt());
        lost.map_or(Ok(moved), Err)
    }
}

/// Force, N, and moment, N m, of all spheres on one. The last number of the force is the energy that its
/// contacts have dissipated, J.
#[derive(Clone, Copy, Debug, Default)]
struct SphereSums {
    force: [f64; 4],
    moment: [f64; 4],
}

impl SphereSums {
    /// Adds the force of a contact with something else than a sphere.
    fn add(&mut self, outer: &Outer, drive: &mut Drive) {
        for axis in 0..3 {
            self.force[axis] += outer.force[axis];
            self.moment[axis] += outer.moment[axis];
        }
        drive.dissipated += outer.dissipated;
        drive.external += outer.external;
    }

    fn vectors(&self) -> [Vector; 2] {
        [self.force, self.moment].map(|[x, y, z, _]| [x, y, z])
    }
}

/// Adds up the forces of contacts on the spheres of a block, one contact after the other: a loop for each
/// sphere would end where the processor does not expect it. It is a function of its own, so that its numbers
/// stay in registers.
struct AddUp<'a, 'b> {
    of: Moving<'a>,
    /// The contacts of the chunk, and where those of the block begin.
    entries: &'a [Entry],
    begin: usize,
    block: usize,
    sums: &'b mut [SphereSums; BLOCK],
    balls: &'b [Ball],
    drives: &'b mut [Drive],
}

impl Work for AddUp<'_, '_> {
    /// Where the contacts of the block end, and the deepest overlap, if it is deeper than any so far.
    type Done = (usize, Depth);

    #[inline(always)]
    fn run<L: Level>(self) -> Self::Done {
        let Self { of, entries, begin, block, sums, balls, drives } = self;
        let (acting, rolling) = (&of.contacts.acting[..], &of.contacts.rolling[..]);
        let stretched = &of.contacts.stretched[..];
        let mut deepest = Depth::default();
        // Less by more than the rounding of a division.
        let mut deep = (1.0 - 1e-15) * of.deepest;
        let mut index = begin;
        while let Some(&entry) = entries.get(index).filter(|entry| entry.sphere as usize / BLOCK == block) {
            index += 1;
            if let Some(entry) = entries.get(index + AHEAD) {
                prefetch(&acting[entry.contact()]);
            }
            let contact = entry.contact();
            let action = &acting[contact];
            let place = entry.sphere as usize % BLOCK;
            let (ball, sum) = (&balls[place], &mut sums[place]);
            let signs = SIGNS[entry.side()];
            let arm = ball.radius - 0.5 * action.overlap();
            sum.force = and(sum.force, signs, action.push);
            sum.moment = and(sum.moment, [arm; 4], action.turn);
            if action.overlap() > deep * ball.radius {
                deepest = deepest.or(Depth::of(action.overlap(), ball));
                deep = deep.max((1.0 - 1e-15) * deepest.share);
            }
            if let Some(rolling) = rolling.get(contact) {
                for k in 0..3 {
                    sum.moment[k] += signs[0] * rolling.moment[k];
                }
            }
            if let Some(work) = stretched.get(contact) {
                drives[place].external += signs[3] * work;
            }
        }
        (index, deepest)
    }
}

/// The motion of one sphere in a step, and all numbers on which it depends, in rows.
struct Rule<'a> {
    of: Moving<'a>,
    share: f64,
    stream: [f64; 4],
    gravity: [f64; 4],
    /// The box, if its sides grow.
    growing: Option<&'a RunBox>,
    /// The lower end of each axis, m, and bounds of the place over it between which a sphere stays there, m.
    low: [f64; 4],
    least: [f64; 4],
    end: [f64; 4],
    /// The step for a vector, s, and how often the number behind it counts: once, and not at all.
    steps: [[f64; 4]; 2],
}

impl<'a> Rule<'a> {
    #[inline(always)]
    fn new(of: Moving<'a>, share: f64) -> Self {
        let (mut low, mut least, mut end) = ([0.0; 4], [-FARTHEST; 4], [FARTHEST; 4]);
        if let Some(cell) = of.cell {
            for axis in 0..3 {
                (low[axis], least[axis]) = (cell.low[axis], 0.0);
                end[axis] = cell.lengths[axis].min(FARTHEST);
            }
        }
        let growing = of.cell.filter(|cell| cell.grows());
        Self {
            of,
            share,
            stream: row(of.stream, 0.0),
            gravity: row(of.gravity, 0.0),
            growing,
            low,
            least,
            end,
            steps: [1.0, 0.0].map(|last| [of.step, of.step, of.step, last]),
        }
    }

    /// Moves a sphere for a step. Returns its velocity, m/s, and another number.
    #[inline(always)]
    fn advance(&self, ball: &mut Ball, drive: &mut Drive, held: bool, sums: &SphereSums) -> [f64; 4] {
        let (step, half) = (self.of.step, 0.5 * self.of.step);
        let [x, y, z] = drive.velocity;
        let mut velocity = [x, y, z, drive.dissipated];
        if held {
            let [force, moment] = sums.vectors();
            drive.external -= step * (dot(force, ball.velocity) + dot(moment, ball.spin));
            velocity[3] += sums.force[3];
        } else {
            // The last number of a row is an energy, which grows by that of the sums.
            let by = 1.0 / ball.mass;
            let mut acceleration = and(self.gravity, [by, by, by, 1.0], sums.force);
            if let Some(cell) = self.growing {
                // The velocity is that over the motion of the box, which takes the sphere along.
                let rates = cell.rates();
                let v = ball.velocity;
                let slowing = [rates[0] * v[0], rates[1] * v[1], rates[2] * v[2]];
                for axis in 0..3 {
                    acceleration[axis] -= slowing[axis];
                }
                drive.external -= step * ball.mass * dot(v, slowing);
            }
            let by = 1.0 / (self.share * ball.mass * ball.radius * ball.radius);
            let by_inertia = [by, by, by, 0.0];
            let turning = [0, 1, 2, 3].map(|k: usize| by_inertia[k] * sums.moment[k]);
            let [p, q, r] = drive.spin;
            velocity = and(velocity, self.steps[0], acceleration);
            let spin = and([p, q, r, drive.external], self.steps[0], turning);
            [drive.spin[0], drive.spin[1], drive.spin[2], drive.external] = spin;
            [ball.velocity[0], ball.velocity[1], ball.velocity[2], _] =
                and(velocity, [half; 4], acceleration);
            [ball.spin[0], ball.spin[1], ball.spin[2], _] = and(spin, [half; 4], turning);
        }
        [drive.velocity[0], drive.velocity[1], drive.velocity[2], drive.dissipated] = velocity;
        let mut moving = velocity;
        if let Some(cell) = self.growing {
            let drift = cell.drift(ball.position);
            for axis in 0..3 {
                moving[axis] += drift[axis];
            }
        }
        let [x, y, z] = ball.position;
        let place = and([x, y, z, ball.radius], self.steps[1], moving);
        [ball.position[0], ball.position[1], ball.position[2], _] = place;
        velocity
    }

    /// Whether a sphere is inside of the box along all axes, and not lost.
    #[inline(always)]
    fn is_inside(&self, ball: &Ball) -> bool {
        let [x, y, z] = ball.position;
        let out = less([x, y, z, ball.radius], self.low);
        [0, 1, 2, 3].iter().all(|&k: &usize| (self.least[k]..self.end[k]).contains(&out[k]))
    }

    /// Brings a sphere that is outside back along the axes that repeat. Returns whether it is to be removed.
    ///
    /// # Errors
    /// It has left the box, or has no place any more.
    #[cold]
    fn bring_back(&self, ball: &mut Ball, drive: &mut Drive) -> Result<bool, GrainError> {
        let place = ball.position;
        if let Some(cell) = self.of.cell {
            ball.position = cell.wrapped(place);
            // A sphere that comes in on the other side has another potential energy.
            drive.external -= ball.mass * dot(self.of.gravity, minus(ball.position, place));
        }
        if !ball.position.iter().all(|x| x.abs() < FARTHEST) {
            return Err(GrainError::Lost { sphere: ball.number as usize, step: self.of.number });
        }
        match self.of.cell.and_then(|cell| cell.outside(ball.position)) {
            Some(Outside::Stop) => Err(GrainError::Outside { sphere: ball.number, step: self.of.number }),
            leaves => Ok(leaves.is_some()),
        }
    }
}
