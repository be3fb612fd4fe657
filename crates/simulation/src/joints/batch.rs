//! Joints of one kind, a batch of them side by side: see `lanes.rs`.
//!
//! Where nothing has broken yet, nearly all joints are whole and stay so. A step reads only a [`Link`] of
//! such a joint, a quarter of the whole record. Where a body fails, most joints soften, or are broken and still
//! pressed together. Each of the two kinds has batches of its own, without a branch that depends on a joint.
//! They do the operations of [`Joint::pull`]. It takes the joints that change their kind in this step, and
//! those with unusual laws.

use crate::cohesive::{JointLaw, Memory, across};
use crate::joints::joint::{APART, Joint, JointState, faded_at};
use crate::lanes::{
    Available, LANES, Lanes, Tensors, compiled_for_vectors, larger, row, set_row, set_tensor, smaller, tensor,
};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::{Grains, Pile};
use crate::vector::{Point, dot, minus, plus};

/// How a step treats a joint.
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

/// The law and the history of the joints of a batch.
pub(super) trait LawLanes<const D: usize>: Copy {
    const EMPTY: Self;

    /// Takes a joint into a lane.
    fn take(&mut self, lane: usize, link: &Link<D>, joint: &Joint<D>);

    /// Traction of an end at this opening and sliding, m, with the difference of the positions of its two
    /// nodes, and whether the joint may be computed in a batch. `open`: whether the end has two nodes.
    fn traction(
        &mut self,
        lane: usize,
        end: usize,
        open: bool,
        gap: [f64; D],
        apart: Point<D>,
    ) -> ([f64; D], bool);

    /// Whether the joint is still of the same kind, after all its ends.
    fn stays(&self, lane: usize) -> bool;

    /// Writes the history into a joint.
    fn write(&self, lane: usize, joint: &mut Joint<D>);
}

/// The data that the forces of a batch depend on. The first index of tensors is the end of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointBatch<const D: usize, L> {
    /// Number of joints.
    count: usize,
    /// The place of each in a chunk.
    places: [usize; LANES],
    /// Sums of the positions of both sides, m.
    sums: Tensors<D>,
    /// Differences of the positions and velocities of side 1 from those of side 0, m and m/s.
    apart: Tensors<D>,
    rates: Tensors<D>,
    /// Forces on side 0, N: of the last step, then of this one.
    forces: Tensors<D>,
    /// Unit vectors across the facet and along it.
    axes: Tensors<D>,
    /// 1 if the end has two nodes, otherwise 0.
    open: [Lanes; D],
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
        apart: [[Lanes::ZERO; D]; D],
        rates: [[Lanes::ZERO; D]; D],
        forces: [[Lanes::ZERO; D]; D],
        axes: [[Lanes::ZERO; D]; D],
        open: [Lanes::ZERO; D],
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
        let ends = link.nodes.map(|end| end.map(|node| solid.position(node as usize)));
        let speeds = link.nodes.map(|end| end.map(|node| solid.velocity(node as usize)));
        set_tensor(&mut self.sums, lane, &ends.map(|[a, b]| plus(a, b)));
        set_tensor(&mut self.apart, lane, &ends.map(|[a, b]| minus(b, a)));
        set_tensor(&mut self.rates, lane, &speeds.map(|[a, b]| minus(b, a)));
        set_tensor(&mut self.forces, lane, forces);
        set_row(&mut self.open, lane, &link.open.map(flag));
        self.share.set(lane, link.share);
        self.taken.set(lane, 1.0);
        self.counted.set(lane, flag(link.counted));
        self.law.take(lane, link, joint);
        self.places[lane] = place;
        self.count += 1;
        self.count == LANES
    }

    /// Computes the joints, and calls `done` for each, with its place. It gets the forces on side 0 and the
    /// law of the batch with the lane, or `None` if the joint is to be computed by itself. The batch is empty
    /// then.
    #[inline]
    pub(super) fn compute<const N: usize>(
        &mut self,
        available: Available,
        step: f64,
        grains: Grains,
        mut done: impl FnMut(usize, Option<([Point<D>; D], &L, usize)>),
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let count = std::mem::take(&mut self.count);
        for lane in count..LANES {
            self.taken.set(lane, 0.0);
        }
        vectors::<D, N, L>(available, self, step, grains);
        for lane in 0..count {
            let computed = self.holds.get(lane) == 1.0;
            done(self.places[lane], computed.then(|| (tensor(&self.forces, lane), &self.law, lane)));
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
fn turn_one<const D: usize, const N: usize, L>(lane: usize, batch: &mut JointBatch<D, L>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    set_tensor(&mut batch.axes, lane, &<[[f64; D]; N]>::unit_axes(&tensor(&batch.sums, lane)));
    batch.work.set(lane, 0.0);
    batch.holds.set(lane, batch.taken.get(lane));
}

/// Computes an end of a joint of a batch.
#[inline(always)]
fn pull_one<const D: usize, L: LawLanes<D>>(
    lane: usize,
    end: usize,
    batch: &mut JointBatch<D, L>,
    step: f64,
) {
    let axes = tensor(&batch.axes, lane);
    let (apart, rate) = (row(&batch.apart[end], lane), row(&batch.rates[end], lane));
    let before = row(&batch.forces[end], lane);
    let share = batch.share.get(lane);
    let open = batch.open[end].get(lane) > 0.0;
    let gap: [f64; D] = std::array::from_fn(|k| dot(apart, axes[k]));
    let (traction, holds) = batch.law.traction(lane, end, open, gap, apart);
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
        batch.forces[end][axis].set(lane, if open { force[axis] } else { before[axis] });
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
        for lane in 0..LANES {
            pull_one::<D, L>(lane, end, batch, step);
        }
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

/// Whole joints.
#[derive(Clone, Copy, Debug)]
pub(super) struct WholeLanes<const D: usize> {
    /// Openings and slidings without traction, m.
    origins: Tensors<D>,
    penalty: Lanes,
    tensile: Lanes,
    cohesion: Lanes,
    friction: Lanes,
}

impl<const D: usize> LawLanes<D> for WholeLanes<D> {
    const EMPTY: Self = Self {
        origins: [[Lanes::ZERO; D]; D],
        penalty: Lanes::ZERO,
        tensile: Lanes::ZERO,
        cohesion: Lanes::ZERO,
        friction: Lanes::ZERO,
    };

    #[inline(always)]
    fn take(&mut self, lane: usize, link: &Link<D>, joint: &Joint<D>) {
        // The record of a joint at rest is not read.
        let at_rest = link.case == JointCase::AtRest;
        for (end, origin) in self.origins.iter_mut().enumerate() {
            set_row(origin, lane, &if at_rest { [0.0; D] } else { joint.ends[end].origin });
        }
        self.penalty.set(lane, link.penalty);
        self.tensile.set(lane, link.tensile);
        self.cohesion.set(lane, link.cohesion);
        self.friction.set(lane, link.friction);
    }

    #[inline(always)]
    fn traction(
        &mut self,
        lane: usize,
        end: usize,
        _open: bool,
        gap: [f64; D],
        _apart: Point<D>,
    ) -> ([f64; D], bool) {
        let law = JointLaw {
            normal: across(),
            penalty: self.penalty.get(lane),
            tensile: self.tensile.get(lane),
            cohesion: self.cohesion.get(lane),
            friction: self.friction.get(lane),
            residual: 0.0,
            shear: 1.0,
            critical: [0.0; 2],
            dilation: 0.0,
            dilated: 0.0,
        };
        law.of_whole(minus(gap, row(&self.origins[end], lane)))
    }

    #[inline(always)]
    fn stays(&self, _lane: usize) -> bool {
        true
    }

    #[inline(always)]
    fn write(&self, _lane: usize, _joint: &mut Joint<D>) {}
}

/// Joints that soften, and broken joints that are pressed together, with common laws.
#[derive(Clone, Copy, Debug)]
pub(super) struct SofteningLanes<const D: usize> {
    normal: [Lanes; D],
    penalty: Lanes,
    tensile: Lanes,
    cohesion: Lanes,
    friction: Lanes,
    critical: [Lanes; 2],
    /// Histories of the ends.
    damages: [[Lanes; 2]; D],
    stiffness: [Lanes; D],
    origins: Tensors<D>,
    rubbed: Tensors<D>,
    /// Length of the joint, m, and the share of it that has been handed over to contact.
    length: Lanes,
    faded: Lanes,
    /// 1 if the joint is broken, otherwise 0.
    broken: Lanes,
    /// Number of its ends that are broken.
    ends: Lanes,
    /// Mean sliding of the ends, m.
    slid: [Lanes; D],
    /// Least opening of the ends, m; 1 if one is pressed, otherwise 0.
    least: Lanes,
    pressed: Lanes,
}

impl<const D: usize> LawLanes<D> for SofteningLanes<D> {
    const EMPTY: Self = Self {
        normal: [Lanes::ZERO; D],
        penalty: Lanes::ZERO,
        tensile: Lanes::ZERO,
        cohesion: Lanes::ZERO,
        friction: Lanes::ZERO,
        critical: [Lanes::ZERO; 2],
        damages: [[Lanes::ZERO; 2]; D],
        stiffness: [Lanes::ZERO; D],
        origins: [[Lanes::ZERO; D]; D],
        rubbed: [[Lanes::ZERO; D]; D],
        length: Lanes::ZERO,
        faded: Lanes::ZERO,
        broken: Lanes::ZERO,
        ends: Lanes::ZERO,
        slid: [Lanes::ZERO; D],
        least: Lanes::ZERO,
        pressed: Lanes::ZERO,
    };

    #[inline(always)]
    fn take(&mut self, lane: usize, _link: &Link<D>, joint: &Joint<D>) {
        let law = &joint.law;
        set_row(&mut self.normal, lane, &law.normal);
        self.penalty.set(lane, law.penalty);
        self.tensile.set(lane, law.tensile);
        self.cohesion.set(lane, law.cohesion);
        self.friction.set(lane, law.friction);
        set_row(&mut self.critical, lane, &law.critical);
        for (end, memory) in joint.ends.iter().enumerate() {
            self.set_memory(lane, end, memory);
        }
        self.length.set(lane, joint.length);
        self.faded.set(lane, joint.faded);
        self.broken.set(lane, flag(joint.state == JointState::Broken));
        self.ends.set(lane, 0.0);
        set_row(&mut self.slid, lane, &[0.0; D]);
        self.least.set(lane, f64::INFINITY);
        self.pressed.set(lane, 0.0);
    }

    #[inline(always)]
    fn traction(
        &mut self,
        lane: usize,
        end: usize,
        open: bool,
        gap: [f64; D],
        apart: Point<D>,
    ) -> ([f64; D], bool) {
        let law = JointLaw {
            normal: row(&self.normal, lane),
            penalty: self.penalty.get(lane),
            tensile: self.tensile.get(lane),
            cohesion: self.cohesion.get(lane),
            friction: self.friction.get(lane),
            residual: 0.0,
            shear: 1.0,
            critical: row(&self.critical, lane),
            dilation: 0.0,
            dilated: 0.0,
        };
        let mut memory = self.memory(lane, end);
        let reach = APART * self.length.get(lane);
        let far = (memory.damage() >= 1.0) & (dot(apart, apart) > reach * reach);
        let traction = memory.of_common(&law, gap);
        self.set_memory(lane, end, &memory);
        self.ends.set(lane, self.ends.get(lane) + flag(open & (memory.damage() >= 1.0)));
        for axis in 1..D {
            let slid = self.slid[axis].get(lane);
            self.slid[axis].set(lane, if open { slid + gap[axis] / D as f64 } else { slid });
        }
        let least = self.least.get(lane);
        self.least.set(lane, if open { smaller(gap[0], least) } else { least });
        self.pressed.set(lane, larger(self.pressed.get(lane), flag(open & (traction[0] < 0.0))));
        (traction, !far)
    }

    #[inline(always)]
    fn stays(&self, lane: usize) -> bool {
        let share = faded_at(row(&self.slid, lane), self.length.get(lane));
        let fades = share > self.faded.get(lane);
        let leaves = (self.least.get(lane) >= 0.0) & (self.pressed.get(lane) == 0.0);
        let breaks = self.ends.get(lane) == D as f64;
        if self.broken.get(lane) > 0.0 { !fades & !leaves } else { !breaks }
    }

    #[inline(always)]
    fn write(&self, lane: usize, joint: &mut Joint<D>) {
        for end in (0..D).filter(|&end| joint.open[end]) {
            joint.ends[end] = self.memory(lane, end);
        }
    }
}

impl<const D: usize> SofteningLanes<D> {
    #[inline(always)]
    fn memory(&self, lane: usize, end: usize) -> Memory<D> {
        Memory {
            damages: row(&self.damages[end], lane),
            stiffness: self.stiffness[end].get(lane),
            origin: row(&self.origins[end], lane),
            rubbed: row(&self.rubbed[end], lane),
        }
    }

    #[inline(always)]
    fn set_memory(&mut self, lane: usize, end: usize, memory: &Memory<D>) {
        set_row(&mut self.damages[end], lane, &memory.damages);
        self.stiffness[end].set(lane, memory.stiffness);
        set_row(&mut self.origins[end], lane, &memory.origin);
        set_row(&mut self.rubbed[end], lane, &memory.rubbed);
    }
}
