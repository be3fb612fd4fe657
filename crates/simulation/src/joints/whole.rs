//! Whole joints, a batch of them side by side: see `lanes.rs`.
//!
//! Where nothing has broken yet, nearly all joints are whole and stay so. A step reads only a [`Link`] of
//! such a joint, a quarter of the whole record, and its tractions have no branch, unlike those of joints that
//! soften. [`pull_one`] does the operations of [`Joint::pull`] on it.

use crate::cohesive::{JointLaw, across};
use crate::joints::joint::{Joint, JointState};
use crate::lanes::{LANES, Lanes, Tensors, compiled_for_vectors, row, set_tensor, tensor};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::{Grains, Pile};
use crate::vector::{Point, dot, minus, plus};

/// Number of whole joints in a batch from which it is worth its cost.
const WORTH_IT: usize = 4;

/// Number of joints between one that is taken and the one whose nodes are prefetched.
const AHEAD: usize = 6;

/// How a step treats a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum JointCase {
    /// It is whole, and has no traction where its sides lie on each other.
    AtRest,
    /// It is whole.
    Whole,
    /// It softens, or is broken.
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
    kind: JointCase,
}

impl<const D: usize> Link<D> {
    /// The link of a joint in its present state.
    pub(super) fn of(joint: &Joint<D>, thickness: f64) -> Self {
        // A batch has one stiffness for all directions of a joint.
        let whole = joint.law.shear == 1.0
            && joint.state == JointState::Holding
            && joint.fading == 0.0
            && joint.detached == [false; D]
            && joint.ends.iter().all(|end| end.is_whole(&joint.law));
        let kind = if joint.state == JointState::Removed && joint.fading == 0.0 {
            JointCase::Gone
        } else if joint.open == [false; D] && joint.holds() && joint.fading == 0.0 {
            JointCase::Closed
        } else if !whole {
            JointCase::Any
        } else if joint.ends.iter().all(|end| end.origin() == [0.0; D]) {
            JointCase::AtRest
        } else {
            JointCase::Whole
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
            kind,
        }
    }

    #[inline]
    fn is_whole(&self) -> bool {
        matches!(self.kind, JointCase::AtRest | JointCase::Whole)
    }

    /// Whether a step changes nothing in the joint.
    #[inline]
    pub(super) fn is_idle(&self) -> bool {
        matches!(self.kind, JointCase::Closed | JointCase::Gone)
    }

    /// Whether the joint has been removed, and nothing changes any more.
    #[inline]
    pub(super) fn is_gone(&self) -> bool {
        self.kind == JointCase::Gone
    }
}

/// The data that the forces of a batch depend on. The first index of tensors is the end of a joint.
#[derive(Clone, Debug)]
pub(super) struct JointBatch<const D: usize> {
    /// Sums of the positions of both sides, m.
    sums: Tensors<D>,
    /// Differences of the positions and velocities of side 1 from those of side 0, m and m/s.
    apart: Tensors<D>,
    rates: Tensors<D>,
    /// Openings and slidings without traction, m.
    origins: Tensors<D>,
    /// Forces on side 0, N: of the last step, then of this one.
    forces: Tensors<D>,
    /// Unit vectors across the facet and along it.
    axes: Tensors<D>,
    /// 1 if the end has two nodes, otherwise 0.
    open: [Lanes; D],
    penalty: Lanes,
    tensile: Lanes,
    cohesion: Lanes,
    friction: Lanes,
    /// Area of each end, m².
    share: Lanes,
    /// Work since the last step, J.
    work: Lanes,
    /// 1 where there is a whole joint, and where this rank counts it, otherwise 0.
    whole: Lanes,
    counted: Lanes,
    /// Work of all whole joints of some batches, in the parts of [`Grains`].
    works: [Lanes; 2],
    /// 1 if the joint was computed and stays whole, otherwise 0.
    holds: Lanes,
}

impl<const D: usize> JointBatch<D> {
    pub(super) const EMPTY: Self = Self {
        sums: [[Lanes::ZERO; D]; D],
        apart: [[Lanes::ZERO; D]; D],
        rates: [[Lanes::ZERO; D]; D],
        origins: [[Lanes::ZERO; D]; D],
        forces: [[Lanes::ZERO; D]; D],
        axes: [[Lanes::ZERO; D]; D],
        open: [Lanes::ZERO; D],
        penalty: Lanes::ZERO,
        tensile: Lanes::ZERO,
        cohesion: Lanes::ZERO,
        friction: Lanes::ZERO,
        share: Lanes::ZERO,
        work: Lanes::ZERO,
        whole: Lanes::ZERO,
        counted: Lanes::ZERO,
        works: [Lanes::ZERO; 2],
        holds: Lanes::ZERO,
    };

    /// Computes those of up to [`LANES`] joints that are whole. Returns whether they are worth it. `links`:
    /// those of these joints, and of the next ones.
    #[inline]
    pub(super) fn pull<const N: usize>(
        &mut self,
        joints: &[Joint<D>],
        links: &[Link<D>],
        forces: &[[Point<D>; D]],
        solid: &Solid<D, N>,
        step: f64,
    ) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (next, links) = (&links[AHEAD.min(links.len())..], &links[..joints.len()]);
        if links.iter().filter(|link| link.is_whole()).count() < WORTH_IT {
            return false;
        }
        self.whole = Lanes::ZERO;
        for (lane, ((link, joint), forces)) in links.iter().zip(joints).zip(forces).enumerate() {
            if let Some(next) = next.get(lane) {
                next.nodes.as_flattened().iter().for_each(|&node| solid.prefetch_node(node as usize));
            }
            if link.is_whole() {
                self.whole.set(lane, 1.0);
                self.counted.set(lane, if link.counted { 1.0 } else { 0.0 });
                self.take(lane, link, forces, solid);
                for end in 0..D {
                    let at_rest = link.kind == JointCase::AtRest;
                    let origin = if at_rest { [0.0; D] } else { joint.ends[end].origin() };
                    for axis in 0..D {
                        self.origins[end][axis].set(lane, origin[axis]);
                    }
                }
            }
        }
        vectors::<D, N>(solid.available, self, step, solid.grains);
        true
    }

    /// Takes a joint into a lane.
    #[inline]
    fn take<const N: usize>(
        &mut self,
        lane: usize,
        link: &Link<D>,
        forces: &[Point<D>; D],
        solid: &Solid<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let ends = link.nodes.map(|end| end.map(|node| solid.position(node as usize)));
        let speeds = link.nodes.map(|end| end.map(|node| solid.velocity(node as usize)));
        set_tensor(&mut self.sums, lane, &ends.map(|[a, b]| plus(a, b)));
        set_tensor(&mut self.apart, lane, &ends.map(|[a, b]| minus(b, a)));
        set_tensor(&mut self.rates, lane, &speeds.map(|[a, b]| minus(b, a)));
        set_tensor(&mut self.forces, lane, forces);
        for end in 0..D {
            self.open[end].set(lane, f64::from(u8::from(link.open[end])));
        }
        self.penalty.set(lane, link.penalty);
        self.tensile.set(lane, link.tensile);
        self.cohesion.set(lane, link.cohesion);
        self.friction.set(lane, link.friction);
        self.share.set(lane, link.share);
    }

    /// The forces on side 0 of a joint, `None` if the joint was not computed, or does not stay whole.
    #[inline]
    pub(super) fn result(&self, lane: usize) -> Option<[Point<D>; D]> {
        (self.holds.get(lane) == 1.0).then(|| tensor(&self.forces, lane))
    }

    /// The work of all joints that were computed and stayed whole since the last step, J.
    pub(super) fn works(&self) -> Pile {
        Pile::of(self.works.map(|part| (0..LANES).map(|lane| part.get(lane)).sum()))
    }
}

/// Computes the axes of a joint of a batch.
#[inline(always)]
fn turn_one<const D: usize, const N: usize>(lane: usize, batch: &mut JointBatch<D>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    set_tensor(&mut batch.axes, lane, &<[[f64; D]; N]>::unit_axes(&tensor(&batch.sums, lane)));
    batch.work.set(lane, 0.0);
    batch.holds.set(lane, batch.whole.get(lane));
}

/// Computes an end of a joint of a batch.
#[inline(always)]
fn pull_one<const D: usize>(lane: usize, end: usize, batch: &mut JointBatch<D>, step: f64) {
    let axes = tensor(&batch.axes, lane);
    let (apart, rate) = (row(&batch.apart[end], lane), row(&batch.rates[end], lane));
    let (origin, before) = (row(&batch.origins[end], lane), row(&batch.forces[end], lane));
    let law = JointLaw {
        normal: across(),
        penalty: batch.penalty.get(lane),
        tensile: batch.tensile.get(lane),
        cohesion: batch.cohesion.get(lane),
        friction: batch.friction.get(lane),
        residual: 0.0,
        shear: 1.0,
        critical: [0.0; 2],
        dilation: 0.0,
        dilated: 0.0,
    };
    let share = batch.share.get(lane);
    let open = batch.open[end].get(lane) > 0.0;
    let gap: [f64; D] = std::array::from_fn(|k| dot(apart, axes[k]));
    let (traction, holds) = law.of_whole(minus(gap, origin));
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
fn pull_all<const D: usize, const N: usize>(batch: &mut JointBatch<D>, step: f64, grains: Grains)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        turn_one::<D, N>(lane, batch);
    }
    for end in 0..D {
        for lane in 0..LANES {
            pull_one::<D>(lane, end, batch, step);
        }
    }
    for lane in 0..LANES {
        let counts = batch.holds.get(lane) * batch.counted.get(lane) > 0.0;
        let parts = grains.parts(if counts { batch.work.get(lane) } else { 0.0 });
        for (sum, part) in batch.works.iter_mut().zip(parts) {
            sum.set(lane, sum.get(lane) + part);
        }
    }
}

compiled_for_vectors!(fn vectors = pull_all<const D: usize, const N: usize>(batch: &mut JointBatch<D>, step: f64, grains: Grains) where [[f64; D]; N]: Simplex<D, N>);
