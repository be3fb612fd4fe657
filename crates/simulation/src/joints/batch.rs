//! Joints of one kind, a batch of them side by side: see `lanes.rs`.
//!
//! Where nothing has broken yet, nearly all joints are whole and stay so. A step reads only a [`Link`] of
//! such a joint, a quarter of the whole record. Where a body fails, most joints soften, or are broken and
//! still pressed together. Each of the two kinds has batches of its own, without a branch that depends on a
//! joint. They do the operations of [`Joint::pull`]. It takes the joints that change their kind in this
//! step, and those with unusual laws.

use crate::cohesive::{JointLaw, Memory, across};
use crate::joints::joint::{APART, Joint, JointState, faded_at};
use crate::lanes::{
    Available, LANES, Lanes, Tensors, compiled_for_vectors, row, set_row, set_tensor, smaller, tensor,
};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::{Grains, Pile};
use crate::vector::{Point, dot, minus, plus};

/// The kind of a joint, on which its computation in a step depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointCase {
    /// It is whole, and has no traction where its sides lie on each other.
    AtRest,
    /// It is whole.
    Whole,
    /// It softens or is broken, and has a common law.
    Softening,
    /// It is computed by itself.
    Any,
    /// None of its ends has two nodes.
    Closed,
    /// It has been removed, and nothing changes any more.
    Gone,
}

/// The data that the forces of a whole joint depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link<const D: usize> {
    nodes: [[u32; 2]; D],
    penalty: f64,
    tensile: f64,
    cohesion: f64,
    friction: f64,
    /// Area of each end, m².
    share: f64,
    open: [bool; D],
    counted: bool,
    pub(super) case: JointCase,
}

impl<const D: usize> Link<D> {
    /// The link of a joint in its present state.
    pub(super) fn of(joint: &Joint<D>, thickness: f64) -> Self {
        let steady = joint.fading == 0.0 && joint.detached == [false; D];
        // A batch has one stiffness for all directions of a joint.
        let whole = joint.law.shear == 1.0
            && joint.state == JointState::Holding
            && steady
            && joint.ends.iter().all(|end| end.is_whole(&joint.law));
        let case = if joint.state == JointState::Removed && joint.fading == 0.0 {
            JointCase::Gone
        } else if joint.open == [false; D] && joint.holds() && joint.fading == 0.0 {
            JointCase::Closed
        } else if whole && joint.ends.iter().all(|end| end.origin == [0.0; D]) {
            JointCase::AtRest
        } else if whole {
            JointCase::Whole
        } else if joint.state != JointState::Removed && steady && joint.law.is_common() {
            JointCase::Softening
        } else {
            JointCase::Any
        };
        let JointLaw { penalty, tensile, friction, .. } = joint.law;
        let share = joint.share(thickness);
        Self {
            nodes: joint.nodes,
            penalty,
            tensile,
            // A batch takes the plane of each joint for its own.
            cohesion: joint.law.least_pressed(),
            friction,
            share,
            open: joint.open,
            counted: joint.counted,
            case,
        }
    }

    /// Whether the joint has been removed, and nothing changes any more.
    #[inline]
    pub(super) fn is_gone(&self) -> bool {
        self.case == JointCase::Gone
    }

    /// Reads the nodes ahead of their use.
    #[inline]
    pub(super) fn prefetch<const N: usize>(&self, solid: &Solid<D, N>) {
        self.nodes.as_flattened().iter().for_each(|&node| solid.prefetch_node(node as usize));
    }
}

/// Opening and sliding of an end, m, the square of the distance between its two nodes, m², and whether there
/// are two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap<const D: usize> {
    between: [f64; D],
    apart: f64,
    open: bool,
}

/// The law of the joints of a batch.
pub(super) trait LawLanes<const D: usize>: Copy {
    /// The history of one end of the joints.
    type End: Copy;

    const EMPTY: Self;
    const EMPTY_END: Self::End;

    /// Takes a joint into a lane.
    fn take(&mut self, lane: usize, link: &Link<D>, joint: &Joint<D>);

    /// Takes the history of an end into a lane.
    fn take_end(history: &mut Self::End, lane: usize, end: usize, link: &Link<D>, joint: &Joint<D>);

    /// Whether the history of an end does not change at this opening and sliding, m, found with little work;
    /// `false` may be wrong.
    fn rests(&self, history: &Self::End, lane: usize, gap: [f64; D]) -> bool;

    /// Traction of an end at an opening and sliding, and whether the joint may be computed in a batch.
    /// `rests`: that of [`rests`](Self::rests) for all joints of the batch.
    fn traction(
        &mut self,
        history: &mut Self::End,
        lane: usize,
        gap: Gap<D>,
        rests: bool,
    ) -> ([f64; D], bool);

    /// Whether the joint is still of the same kind, after all its ends.
    fn stays(&self, lane: usize) -> bool;

    /// Writes the history of an open end into a joint.
    fn write(history: &Self::End, lane: usize, end: usize, joint: &mut Joint<D>);
}

/// One end of the joints of a batch.
#[derive(Clone, Copy, Debug)]
struct EndLanes<const D: usize, H> {
    /// Differences of the positions and velocities of side 1 from those of side 0, m and m/s.
    apart: [Lanes; D],
    rates: [Lanes; D],
    /// Force on side 0, N: of the last step, then of this one.
    force: [Lanes; D],
    /// 1 if the end has two nodes, otherwise 0.
    open: Lanes,
    history: H,
}

/// The data that the forces of a batch depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointBatch<const D: usize, L: LawLanes<D>> {
    /// Number of joints.
    count: usize,
    /// The place of each in a chunk.
    places: [usize; LANES],
    /// Sums of the positions of both sides of each end, m.
    sums: Tensors<D>,
    /// Unit vectors across the facet and along it.
    axes: Tensors<D>,
    ends: [EndLanes<D, L::End>; D],
    /// Area of each end, m².
    share: Lanes,
    /// Work since the last step, J.
    work: Lanes,
    /// 1 where there is a joint, and where this rank counts it, otherwise 0.
    taken: Lanes,
    counted: Lanes,
    /// Work of all joints of some batches, in the parts of [`Grains`].
    works: [Lanes; 2],
    /// 1 if the joint was computed and is still of the same kind, otherwise 0.
    holds: Lanes,
    law: L,
}

impl<const D: usize, L: LawLanes<D>> JointBatch<D, L> {
    pub(super) const EMPTY: Self = Self {
        count: 0,
        places: [0; LANES],
        sums: [[Lanes::ZERO; D]; D],
        axes: [[Lanes::ZERO; D]; D],
        ends: [EndLanes {
            apart: [Lanes::ZERO; D],
            rates: [Lanes::ZERO; D],
            force: [Lanes::ZERO; D],
            open: Lanes::ZERO,
            history: L::EMPTY_END,
        }; D],
        share: Lanes::ZERO,
        work: Lanes::ZERO,
        taken: Lanes::ZERO,
        counted: Lanes::ZERO,
        works: [Lanes::ZERO; 2],
        holds: Lanes::ZERO,
        law: L::EMPTY,
    };

    /// Takes a joint. Returns whether the batch is full.
    #[inline]
    pub(super) fn push<const N: usize>(
        &mut self,
        place: usize,
        joint: &Joint<D>,
        link: &Link<D>,
        forces: &[Point<D>; D],
        solid: &Solid<D, N>,
    ) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let lane = self.count;
        for (end, nodes) in link.nodes.iter().enumerate() {
            let [a, b] = nodes.map(|node| solid.position(node as usize));
            let [before, after] = nodes.map(|node| solid.velocity(node as usize));
            let at = &mut self.ends[end];
            set_row(&mut self.sums[end], lane, &plus(a, b));
            set_row(&mut at.apart, lane, &minus(b, a));
            set_row(&mut at.rates, lane, &minus(after, before));
            set_row(&mut at.force, lane, &forces[end]);
            at.open.set(lane, flag(link.open[end]));
            L::take_end(&mut at.history, lane, end, link, joint);
        }
        self.share.set(lane, link.share);
        self.taken.set(lane, 1.0);
        self.counted.set(lane, flag(link.counted));
        self.law.take(lane, link, joint);
        self.places[lane] = place;
        self.count += 1;
        self.count == LANES
    }

    /// Computes the joints. The batch is empty then. Calls `done` for each of them with its place and its
    /// lane, `None` if it is to be computed by itself.
    #[inline]
    pub(super) fn compute<const N: usize>(
        &mut self,
        available: Available,
        step: f64,
        grains: Grains,
        mut done: impl FnMut(&Self, usize, Option<usize>),
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let count = std::mem::take(&mut self.count);
        for lane in count..LANES {
            self.taken.set(lane, 0.0);
        }
        vectors::<D, N, L>(available, self, step, grains);
        for lane in 0..count {
            done(self, self.places[lane], (self.holds.get(lane) == 1.0).then_some(lane));
        }
    }

    /// Writes a joint that was computed, and its forces on side 0.
    #[inline]
    pub(super) fn write(&self, lane: usize, joint: &mut Joint<D>, forces: &mut [Point<D>; D]) {
        for (end, at) in self.ends.iter().enumerate() {
            forces[end] = row(&at.force, lane);
            L::write(&at.history, lane, end, joint);
        }
    }

    /// Number of joints that wait to be computed.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The work of all joints that were computed since the last step, J.
    pub(super) fn works(&self) -> Pile {
        Pile::of(self.works.map(|part| (0..LANES).map(|lane| part.get(lane)).sum()))
    }
}

/// 1 or 0.
#[inline(always)]
fn flag(set: bool) -> f64 {
    if set { 1.0 } else { 0.0 }
}

/// Computes the axes of a joint of a batch.
#[inline(always)]
fn turn_one<const D: usize, const N: usize, L: LawLanes<D>>(lane: usize, batch: &mut JointBatch<D, L>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    set_tensor(&mut batch.axes, lane, &<[[f64; D]; N]>::unit_axes(&tensor(&batch.sums, lane)));
    batch.work.set(lane, 0.0);
    batch.holds.set(lane, batch.taken.get(lane));
}

/// Whether an end of a joint of a batch rests, or there is none.
#[inline(always)]
fn rests_one<const D: usize, L: LawLanes<D>>(
    lane: usize,
    at: &EndLanes<D, L::End>,
    batch: &JointBatch<D, L>,
) -> bool {
    let (axes, apart) = (tensor(&batch.axes, lane), row(&at.apart, lane));
    let rests = batch.law.rests(&at.history, lane, std::array::from_fn(|k| dot(apart, axes[k])));
    rests || (at.open.get(lane) == 0.0) || (batch.taken.get(lane) == 0.0)
}

/// Computes an end of a joint of a batch. `rests`: see [`LawLanes::traction`]. Twin: `pull_joint` in
/// `crates/gpu/kernels/joints.h`.
#[inline(always)]
fn pull_one<const D: usize, L: LawLanes<D>>(
    lane: usize,
    at: &mut EndLanes<D, L::End>,
    batch: &mut JointBatch<D, L>,
    step: f64,
    rests: bool,
) {
    let axes = tensor(&batch.axes, lane);
    let (apart, rate) = (row(&at.apart, lane), row(&at.rates, lane));
    let before = row(&at.force, lane);
    let share = batch.share.get(lane);
    let open = at.open.get(lane) > 0.0;
    let gap = Gap { between: std::array::from_fn(|k| dot(apart, axes[k])), apart: dot(apart, apart), open };
    let (traction, holds) = batch.law.traction(&mut at.history, lane, gap, rests);
    let force: Point<D> = std::array::from_fn(|axis| {
        let mut sum = traction[0] * axes[0][axis];
        for k in 1..D {
            sum += traction[k] * axes[k][axis];
        }
        share * sum
    });
    let done = 0.5 * step * (dot(before, rate) + dot(force, rate));
    batch.work.set(lane, batch.work.get(lane) + if open { done } else { 0.0 });
    for axis in 0..D {
        at.force[axis].set(lane, if open { force[axis] } else { before[axis] });
    }
    batch.holds.set(lane, if open && !holds { 0.0 } else { batch.holds.get(lane) });
}

/// Computes a batch.
#[inline(always)]
fn pull_all<const D: usize, const N: usize, L: LawLanes<D>>(
    batch: &mut JointBatch<D, L>,
    step: f64,
    grains: Grains,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        turn_one::<D, N, L>(lane, batch);
    }
    for end in 0..D {
        // A copy, because the compiler makes no vectors where `end` decides the address.
        let mut at = batch.ends[end];
        let mut resting = 0;
        for lane in 0..LANES {
            resting += u64::from(rests_one::<D, L>(lane, &at, batch));
        }
        if resting == LANES as u64 {
            for lane in 0..LANES {
                pull_one::<D, L>(lane, &mut at, batch, step, true);
            }
        } else {
            for lane in 0..LANES {
                pull_one::<D, L>(lane, &mut at, batch, step, false);
            }
        }
        batch.ends[end] = at;
    }
    for lane in 0..LANES {
        let stays = batch.law.stays(lane);
        batch.holds.set(lane, if stays { batch.holds.get(lane) } else { 0.0 });
        let counts = batch.holds.get(lane) * batch.counted.get(lane) > 0.0;
        let parts = grains.parts(if counts { batch.work.get(lane) } else { 0.0 });
        for (sum, part) in batch.works.iter_mut().zip(parts) {
            sum.set(lane, sum.get(lane) + part);
        }
    }
}

compiled_for_vectors!(fn vectors = pull_all<const D: usize, const N: usize; L>(batch: &mut JointBatch<D, L>, step: f64, grains: Grains) where [[f64; D]; N]: Simplex<D, N>, L: LawLanes<D>);

/// Stiffness, Pa/m, strengths, Pa, and coefficient of friction of the joints of a batch.
#[derive(Clone, Copy, Debug)]
struct StrengthLanes {
    penalty: Lanes,
    tensile: Lanes,
    cohesion: Lanes,
    friction: Lanes,
}

impl StrengthLanes {
    const EMPTY: Self =
        Self { penalty: Lanes::ZERO, tensile: Lanes::ZERO, cohesion: Lanes::ZERO, friction: Lanes::ZERO };

    #[inline(always)]
    fn set(&mut self, lane: usize, [penalty, tensile, cohesion, friction]: [f64; 4]) {
        self.penalty.set(lane, penalty);
        self.tensile.set(lane, tensile);
        self.cohesion.set(lane, cohesion);
        self.friction.set(lane, friction);
    }

    /// A common law with this normal and these critical lengths.
    #[inline(always)]
    fn law<const D: usize>(&self, lane: usize, normal: [f64; D], critical: [f64; 2]) -> JointLaw<D> {
        JointLaw {
            normal,
            penalty: self.penalty.get(lane),
            tensile: self.tensile.get(lane),
            cohesion: self.cohesion.get(lane),
            friction: self.friction.get(lane),
            residual: 0.0,
            shear: 1.0,
            critical,
            dilation: 0.0,
            dilated: 0.0,
        }
    }
}

/// Whole joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct WholeLanes {
    strengths: StrengthLanes,
}

impl<const D: usize> LawLanes<D> for WholeLanes {
    /// Opening and sliding without traction, m.
    type End = [Lanes; D];

    const EMPTY: Self = Self { strengths: StrengthLanes::EMPTY };
    const EMPTY_END: Self::End = [Lanes::ZERO; D];

    #[inline(always)]
    fn take(&mut self, lane: usize, link: &Link<D>, _joint: &Joint<D>) {
        self.strengths.set(lane, [link.penalty, link.tensile, link.cohesion, link.friction]);
    }

    #[inline(always)]
    fn take_end(origin: &mut Self::End, lane: usize, end: usize, link: &Link<D>, joint: &Joint<D>) {
        // The record of a joint at rest is not read.
        let at_rest = link.case == JointCase::AtRest;
        set_row(origin, lane, &if at_rest { [0.0; D] } else { joint.ends[end].origin });
    }

    #[inline(always)]
    fn rests(&self, _origin: &Self::End, _lane: usize, _gap: [f64; D]) -> bool {
        true
    }

    #[inline(always)]
    fn traction(
        &mut self,
        origin: &mut Self::End,
        lane: usize,
        Gap { between: gap, .. }: Gap<D>,
        _rests: bool,
    ) -> ([f64; D], bool) {
        let law = self.strengths.law(lane, across(), [0.0; 2]);
        law.of_whole(minus(gap, row(origin, lane)))
    }

    #[inline(always)]
    fn stays(&self, _lane: usize) -> bool {
        true
    }

    #[inline(always)]
    fn write(_origin: &Self::End, _lane: usize, _end: usize, _joint: &mut Joint<D>) {}
}

/// Joints that soften, and broken joints that are pressed together, with common laws.
#[derive(Clone, Copy, Debug)]
pub(super) struct SofteningLanes<const D: usize> {
    normal: [Lanes; D],
    strengths: StrengthLanes,
    critical: [Lanes; 2],
    /// Length of the joint, m, and the share of it that has been handed over to contact.
    length: Lanes,
    faded: Lanes,
    /// 1 if the joint is broken, otherwise 0.
    broken: Lanes,
    /// Number of its ends that are broken.
    broken_ends: Lanes,
    /// Mean sliding of the ends, m.
    slid: [Lanes; D],
    /// Least opening of the ends, m; 1 if one is pressed, otherwise 0.
    least: Lanes,
    pressed: Lanes,
}

/// History of one end of the joints of a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemoryLanes<const D: usize> {
    damages: [Lanes; 2],
    stiffness: Lanes,
    origin: [Lanes; D],
    rubbed: [Lanes; D],
    left: Lanes,
}

impl<const D: usize> MemoryLanes<D> {
    #[inline(always)]
    fn get(&self, lane: usize) -> Memory<D> {
        Memory {
            damages: row(&self.damages, lane),
            stiffness: self.stiffness.get(lane),
            origin: row(&self.origin, lane),
            rubbed: row(&self.rubbed, lane),
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, memory: &Memory<D>) {
        set_row(&mut self.damages, lane, &memory.damages);
        self.stiffness.set(lane, memory.stiffness);
        set_row(&mut self.origin, lane, &memory.origin);
        set_row(&mut self.rubbed, lane, &memory.rubbed);
    }
}

impl<const D: usize> SofteningLanes<D> {
    #[inline(always)]
    fn law(&self, lane: usize) -> JointLaw<D> {
        self.strengths.law(lane, row(&self.normal, lane), row(&self.critical, lane))
    }
}

impl<const D: usize> LawLanes<D> for SofteningLanes<D> {
    type End = MemoryLanes<D>;

    const EMPTY: Self = Self {
        normal: [Lanes::ZERO; D],
        strengths: StrengthLanes::EMPTY,
        critical: [Lanes::ZERO; 2],
        length: Lanes::ZERO,
        faded: Lanes::ZERO,
        broken: Lanes::ZERO,
        broken_ends: Lanes::ZERO,
        slid: [Lanes::ZERO; D],
        least: Lanes::ZERO,
        pressed: Lanes::ZERO,
    };
    const EMPTY_END: Self::End = MemoryLanes {
        damages: [Lanes::ZERO; 2],
        stiffness: Lanes::ZERO,
        origin: [Lanes::ZERO; D],
        rubbed: [Lanes::ZERO; D],
        left: Lanes::ZERO,
    };

    #[inline(always)]
    fn take(&mut self, lane: usize, _link: &Link<D>, joint: &Joint<D>) {
        let law = &joint.law;
        set_row(&mut self.normal, lane, &law.normal);
        self.strengths.set(lane, [law.penalty, law.tensile, law.cohesion, law.friction]);
        set_row(&mut self.critical, lane, &law.critical);
        self.length.set(lane, joint.length);
        self.faded.set(lane, joint.faded);
        self.broken.set(lane, flag(joint.state == JointState::Broken));
        self.broken_ends.set(lane, 0.0);
        set_row(&mut self.slid, lane, &[0.0; D]);
        self.least.set(lane, f64::INFINITY);
        self.pressed.set(lane, 0.0);
    }

    #[inline(always)]
    fn take_end(history: &mut Self::End, lane: usize, end: usize, _link: &Link<D>, joint: &Joint<D>) {
        history.set(lane, &joint.ends[end]);
        history.left.set(lane, joint.left[end]);
    }

    #[inline(always)]
    fn rests(&self, history: &Self::End, lane: usize, gap: [f64; D]) -> bool {
        history.get(lane).rests(&self.law(lane), gap, history.left.get(lane))
    }

    #[inline(always)]
    fn traction(
        &mut self,
        history: &mut Self::End,
        lane: usize,
        Gap { between: gap, apart, open }: Gap<D>,
        rests: bool,
    ) -> ([f64; D], bool) {
        let law = self.law(lane);
        let mut memory = history.get(lane);
        let reach = APART * self.length.get(lane);
        let far = (memory.damage() >= 1.0) && (apart > reach * reach);
        let mut left = history.left.get(lane);
        let traction = memory.of_common(&law, gap, rests, &mut left);
        history.set(lane, &memory);
        history.left.set(lane, left);
        let broken = flag(open && (memory.damage() >= 1.0));
        self.broken_ends.set(lane, self.broken_ends.get(lane) + broken);
        for axis in 1..D {
            let slid = if open { gap[axis] / D as f64 } else { 0.0 };
            self.slid[axis].set(lane, self.slid[axis].get(lane) + slid);
        }
        let least = if open { gap[0] } else { f64::INFINITY };
        self.least.set(lane, smaller(self.least.get(lane), least));
        self.pressed.set(lane, self.pressed.get(lane) + flag(open && (traction[0] < 0.0)));
        (traction, !far)
    }

    #[inline(always)]
    fn stays(&self, lane: usize) -> bool {
        let share = faded_at(row(&self.slid, lane), self.length.get(lane));
        let fades = share > self.faded.get(lane);
        let leaves = (self.least.get(lane) >= 0.0) && (self.pressed.get(lane) == 0.0);
        let breaks = self.broken_ends.get(lane) == D as f64;
        let broken = self.broken.get(lane) > 0.0;
        !(broken && (fades || leaves)) && (broken || !breaks)
    }

    #[inline(always)]
    fn write(history: &Self::End, lane: usize, end: usize, joint: &mut Joint<D>) {
        if joint.open[end] {
            joint.ends[end] = history.get(lane);
            joint.left[end] = history.left.get(lane);
        }
    }
}
