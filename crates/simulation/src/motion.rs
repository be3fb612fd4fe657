//! Motion of degrees of freedom: central differences (book, (5.12)-(5.13)).
//!
//! Velocities are half a step before positions. With `v₋` before and `v₊` after a step, `m v₋·v₊ / 2` is the
//! kinetic energy at the positions between them: with it, the sum of kinetic and strain energy of a linear
//! system is constant to rounding, and the work of a force in the step is `F·(v₋ + v₊) h / 2`.
//!
//! Nodes are one kind of members with degrees of freedom (`motion/nodes.rs`). A kind implements [`Freedoms`];
//! chunks of members, and sums over their motion, are written once.

pub(crate) mod nodes;
pub(crate) mod rigid;

use crate::sum::{Grains, Pile, Sum};
use crate::vector::{Point, dot};

/// Members of one kind in a step, with all that their motion depends on: nodes, or bodies that are rigid.
pub(crate) trait Freedoms<const D: usize>: Sync {
    /// Position and velocity of a member, which its motion replaces.
    type Moving<'m>;
    /// Force on a member: D components on a node; force and moment on a body that turns.
    type Force;

    /// Whether this rank moves a member.
    fn is_own(&self, member: usize) -> bool;

    /// Gathers the force on a member.
    fn force(&self, member: usize) -> Self::Force;

    /// Moves a member under a force, and adds its energies and works to the sums. Returns the square of the
    /// speed of its fastest point after the step.
    fn advance(
        &self,
        member: usize,
        moving: Self::Moving<'_>,
        force: Self::Force,
        sum: &mut MotionSums<Pile, D>,
    ) -> f64;

    /// The first element of a member, for messages.
    fn element(&self, member: usize) -> u32;
}

/// Members that a rank moves now.
pub(crate) struct MovedNow<M> {
    /// Selects members by their numbers.
    pub(crate) moves: M,
    /// Speed of the fastest point at which the run continues, m/s.
    pub(crate) speed_limit: f64,
}

impl<M: Fn(usize) -> bool> MovedNow<M> {
    /// Moves a chunk of members. `first`: number of its first member.
    #[inline]
    pub(crate) fn advance_chunk<'m, const D: usize, F: Freedoms<D> + 'm>(
        &self,
        freedoms: &F,
        first: usize,
        chunk: impl Iterator<Item = F::Moving<'m>>,
    ) -> MotionSums<Pile, D> {
        let limit = self.speed_limit * self.speed_limit;
        let mut sum = MotionSums::<Pile, D>::default();
        for (k, moving) in chunk.enumerate() {
            let member = first + k;
            if !freedoms.is_own(member) || !(self.moves)(member) {
                continue;
            }
            let squared = freedoms.advance(member, moving, freedoms.force(member), &mut sum);
            sum.fastest = sum.fastest.max(squared);
            if squared > limit || squared.is_nan() {
                sum.note_runaway((freedoms.element(member), squared.sqrt()));
            }
        }
        sum
    }
}

/// Sums over the free axes of nodes, for the damping of dynamic relaxation, that are taken in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RelaxationSums {
    Nothing,
    /// Power of the forces with the velocities after the step.
    After,
    /// Power with the velocities before the step, and twice the kinetic energy of these.
    Before,
}

/// Sums over the motion of all members, or piles over that of a chunk.
#[derive(Clone, Debug, Default)]
pub(crate) struct MotionSums<S, const D: usize> {
    /// Kinetic energy, J, if requested.
    pub(crate) kinetic: S,
    /// Work of gravity and of prescribed motions, up to the positions at the beginning of the step and after
    /// them, J.
    pub(crate) external: [S; 2],
    /// Energy dissipated by local damping and dynamic relaxation, up to these two positions, J.
    pub(crate) damping: [S; 2],
    /// Sums for the damping of dynamic relaxation: power, W, and mass times the square of the velocity, J.
    pub(crate) taken: [S; 2],
    /// Force on each node that a boundary moves, N.
    pub(crate) held: Vec<(u32, Point<D>)>,
    /// Moments of boundaries that turn nodes or bodies, each with the number of its boundary, about the point
    /// through which the axis passes, N m.
    pub(crate) moments: Vec<(u32, Point<3>)>,
    /// Speed of the fastest point, m/s; its square in the sums of a chunk.
    pub(crate) fastest: f64,
    /// Squares of the largest force on a node that is free, and of the largest that an element exerts on one
    /// of its nodes, N², if the kinetic energy is requested.
    pub(crate) largest: [f64; 2],
    /// The first element with a point that is too fast, and the speed of that point, m/s.
    pub(crate) runaway: Option<(u32, f64)>,
}

impl<S, const D: usize> MotionSums<S, D> {
    /// Notes the force on a node, and those of its corners.
    fn note_forces(&mut self, node: Point<D>, of_corners: impl Iterator<Item = Point<D>>) {
        self.largest[0] = self.largest[0].max(dot(node, node));
        for force in of_corners {
            self.largest[1] = self.largest[1].max(dot(force, force));
        }
    }

    /// Notes an element with a point that is too fast.
    pub(crate) fn note_runaway(&mut self, found: (u32, f64)) {
        if self.runaway.is_none_or(|(element, _)| found.0 < element) {
            self.runaway = Some(found);
        }
    }
}

impl<const D: usize> MotionSums<Pile, D> {
    /// Adds the terms of a free axis to the sums for the damping of dynamic relaxation, J: powers times the
    /// step, because grains are those of works. `impulse`: of the force in a step; `velocities`: before and
    /// after the step; `momentum`: before it.
    #[inline]
    fn take(
        &mut self,
        taken: RelaxationSums,
        impulse: f64,
        [before, after]: [f64; 2],
        momentum: f64,
        grains: Grains,
    ) {
        match taken {
            RelaxationSums::Nothing => {}
            RelaxationSums::After => self.taken[0].add(impulse * after, grains),
            RelaxationSums::Before => {
                self.taken[0].add(impulse * before, grains);
                self.taken[1].add(momentum * before, grains);
            }
        }
    }
}

/// Adds the works of a force in the two halves of a step, J. `velocities`: before and after it.
#[inline(always)]
fn add_works<const K: usize>(
    works: &mut [Pile; 2],
    force: [f64; K],
    velocities: [[f64; K]; 2],
    step: f64,
    grains: Grains,
) {
    // Most members have none.
    if force != [0.0; K] {
        for (work, velocity) in works.iter_mut().zip(velocities) {
            work.add(0.5 * step * dot(force, velocity), grains);
        }
    }
}

/// Nodes that are selected by a list with an entry for each; an empty list has none of them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Selected<'a> {
    Only(&'a [bool]),
    Except(&'a [bool]),
}

impl<const D: usize> MotionSums<Sum, D> {
    /// Adds the sums of chunks, in their order.
    pub(crate) fn add_chunks(&mut self, found: Vec<MotionSums<Pile, D>>) {
        for chunk in found {
            self.kinetic.add_pile(chunk.kinetic);
            self.fastest = self.fastest.max(chunk.fastest.sqrt());
            self.largest = std::array::from_fn(|k| self.largest[k].max(chunk.largest[k]));
            for half in 0..2 {
                self.taken[half].add_pile(chunk.taken[half]);
                self.external[half].add_pile(chunk.external[half]);
                self.damping[half].add_pile(chunk.damping[half]);
            }
            self.held.extend(chunk.held);
            self.moments.extend(chunk.moments);
            if let Some(runaway) = chunk.runaway {
                self.note_runaway(runaway);
            }
        }
    }
}
