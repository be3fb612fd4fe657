//! The pass of a step over a chunk of joints.

use crate::joints::batch::{JointBatch, JointCase, LawLanes, Link, SofteningLanes, WholeLanes};
use crate::joints::joint::{Joint, JointState};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Pile;
use crate::vector::Point;

/// Number of joints between one that is computed and the one whose nodes are prefetched.
const AHEAD: usize = 6;

/// Some joints, with their other data.
pub(super) struct JointChunk<'a, const D: usize, const N: usize> {
    pub(super) joints: &'a mut [Joint<D>],
    pub(super) links: &'a mut [Link<D>],
    pub(super) forces: &'a mut [[Point<D>; D]],
    pub(super) solid: &'a Solid<D, N>,
    /// Time step, and the time at its end, s.
    pub(super) step: f64,
    pub(super) time: f64,
}

/// The results of a pass over a chunk.
#[derive(Debug, Default)]
pub(super) struct PassResult {
    /// The joints that broke, ascending, with the modes of their damage.
    pub(super) broken: Vec<(usize, [f64; 2])>,
    /// Work done against the joints that are counted since the last pass, J.
    pub(super) work: Pile,
}

impl<const D: usize, const N: usize> JointChunk<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Updates all joints and their forces.
    pub(super) fn pull(&mut self) -> PassResult {
        let mut result = PassResult::default();
        let mut whole = None::<JointBatch<D, WholeLanes>>;
        let mut softening = None::<JointBatch<D, SofteningLanes<D>>>;
        for place in 0..self.joints.len() {
            if let Some(link) = self.links.get(place + AHEAD) {
                link.prefetch(self.solid);
            }
            match self.links[place].case {
                JointCase::AtRest | JointCase::Whole => self.take(place, &mut whole, &mut result),
                JointCase::Softening => self.take(place, &mut softening, &mut result),
                JointCase::Any => self.pull_one(place, &mut result),
                JointCase::Closed | JointCase::Gone => {}
            }
        }
        self.finish(&mut whole, &mut result);
        self.finish(&mut softening, &mut result);
        result.broken.sort_unstable_by_key(|(place, _)| *place);
        result
    }

    /// Takes a joint into a batch, and computes the batch if it is full.
    #[inline]
    fn take<L: LawLanes<D>>(
        &mut self,
        place: usize,
        batch: &mut Option<JointBatch<D, L>>,
        result: &mut PassResult,
    ) {
        let batch = batch.get_or_insert(JointBatch::EMPTY);
        let (joint, link) = (&self.joints[place], &self.links[place]);
        if batch.push(place, joint, link, &self.forces[place], self.solid) {
            self.compute(batch, result);
        }
    }

    /// Computes the last joints of a batch, and takes its work.
    fn finish<L: LawLanes<D>>(&mut self, batch: &mut Option<JointBatch<D, L>>, result: &mut PassResult) {
        if let Some(batch) = batch {
            if batch.count() > 0 {
                self.compute(batch, result);
            }
            result.work.add_pile(batch.works());
        }
    }

    /// Computes a batch. Joints that change their kind are computed by themselves.
    fn compute<L: LawLanes<D>>(&mut self, batch: &mut JointBatch<D, L>, result: &mut PassResult) {
        let (available, grains) = (self.solid.available, self.solid.grains);
        batch.compute(available, self.step, grains, |batch, place, lane| match lane {
            Some(lane) => batch.write(lane, &mut self.joints[place], &mut self.forces[place]),
            None => self.pull_one(place, result),
        });
    }

    /// Computes a joint by itself.
    pub(super) fn pull_one(&mut self, place: usize, result: &mut PassResult) {
        let joint = &mut self.joints[place];
        if joint.state == JointState::Removed {
            joint.fading = 0.0;
        } else {
            let (work, modes) = joint.pull(&mut self.forces[place], self.solid, self.step);
            if joint.softens == f64::INFINITY && joint.damage() > 0.0 {
                joint.softens = self.time;
            }
            if joint.counted {
                result.work.add(work, self.solid.grains);
            }
            result.broken.extend(modes.map(|modes| (place, modes)));
        }
        self.links[place] = Link::of(joint, self.solid.thickness);
    }
}
