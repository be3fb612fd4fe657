//! Forces of a chunk of couples.
//!
//! Couples that did not touch and that nothing parts now get a place among the histories; then the forces of
//! all couples with a place are computed, a group of batches at a time. Twin: `press_couple` in
//! `crates/gpu/kernels/contact.h`.

use std::ops::Range;

use crate::contacts::pair::{BatchWorks, CoupleOf, Overlap, Pair, PairPass, Works};
use crate::contacts::places::{Histories, HistoryBatch};
use crate::lanes::{LANES, Lanes};
use crate::team::CHUNK;

/// Forces of a chunk of couples.
#[derive(Clone, Debug)]
pub(super) struct ChunkForces<P: Pair> {
    /// Forces in batches. Each couple has the place of its history.
    found: Vec<P::Forces>,
    /// The works of each couple, in the same places.
    works: Vec<BatchWorks>,
    /// Couples of the chunk that have separated in this pass, ascending, with the works of their last forces.
    pub(super) separated: Vec<(u32, Works)>,
}

impl<P: Pair> Default for ChunkForces<P> {
    fn default() -> Self {
        Self { found: Vec::new(), works: Vec::new(), separated: Vec::new() }
    }
}

impl<P: Pair> ChunkForces<P> {
    /// Adds the forces of the couple in a place to the sums of its parts, N. Returns its works, and whether
    /// one part has sunk too deep into the other.
    #[inline]
    pub(super) fn add_to<const D: usize, S: PairPass<D, Pair = P>>(
        &self,
        target: &mut S::Target,
        parts: [u32; 2],
        place: u16,
    ) -> (Works, bool) {
        let (batch, lane) = (place as usize / LANES, place as usize % LANES);
        let deep = S::add(&self.found[batch], lane, parts, target);
        (Works::of(&self.works[batch], lane), deep)
    }
}

/// The pass over the couples of a pair of kinds in a step.
pub(super) struct ChunkPass<'a, S> {
    pub(super) pass: &'a S,
    /// Time step, s.
    pub(super) step: f64,
    /// Distance that points of bodies have travelled since the beginning, m.
    pub(super) travel: f64,
}

impl<S> ChunkPass<'_, S> {
    /// Computes the forces of a chunk of couples.
    pub(super) fn press<const D: usize>(
        &self,
        couples: &mut [CoupleOf<S::Pair>],
        histories: &mut Histories<<S::Pair as Pair>::Histories>,
        pressed: &mut ChunkForces<S::Pair>,
    ) where
        S: PairPass<D>,
    {
        pressed.separated.clear();
        // Mostly, bodies do not touch anywhere near.
        if couples.iter().all(|couple| couple.apart_until > self.travel) {
            return;
        }
        let mut work = self.pass.work(self.step);
        self.look(couples, &mut work, histories, &mut pressed.separated);
        let batches = histories.batches.len();
        pressed.found.resize(batches, S::Pair::NO_FORCES);
        pressed.works.resize(batches, [Lanes::ZERO; 5]);
        for first in (0..batches).step_by(S::GROUP) {
            let group = first..batches.min(first + S::GROUP);
            self.press_group(group, couples, histories, pressed, &mut work);
        }
        histories.trim();
        pressed.separated.sort_unstable_by_key(|(couple, _)| *couple);
    }

    /// Gives a place to the couples that did not touch and that nothing parts now.
    fn look<const D: usize>(
        &self,
        couples: &mut [CoupleOf<S::Pair>],
        work: &mut S::Work,
        histories: &mut Histories<<S::Pair as Pair>::Histories>,
        separated: &mut Vec<(u32, Works)>,
    ) where
        S: PairPass<D>,
    {
        let (mut near, mut count) = ([0_usize; CHUNK], 0);
        for (number, couple) in couples.iter_mut().enumerate() {
            if couple.apart_until > self.travel {
                continue;
            }
            if !couple.touches && !self.pass.may_begin(couple.parts) {
                continue;
            }
            if !self.pass.acts(couple) {
                // While something else carries the whole load, such as a joint, the gap says nothing about
                // when contact begins: the couple must not be skipped.
                if couple.touches {
                    let history = histories.get(couple.slot);
                    let [friction, damping] = self.pass.last_works(couple.parts, &history, self.step);
                    separated.push((number as u32, Works { friction, damping, ..Works::default() }));
                    histories.free(couple.slot);
                }
                couple.part(self.travel, 0.0);
            } else if !couple.touches {
                near[count] = number;
                count += 1;
            }
        }
        let near = &near[..count];
        let mut distances = Lanes::ZERO;
        for first in (0..count).step_by(LANES) {
            self.pass.distances(couples, &near[first..], work, &mut distances);
            for (lane, &number) in near[first..].iter().take(LANES).enumerate() {
                let (couple, distance) = (&mut couples[number], distances.get(lane));
                if distance >= 0.0 {
                    couple.part(self.travel, distance);
                } else {
                    couple.touches = true;
                    couple.slot = histories.give(number, &<S::Pair as Pair>::Histories::NEW);
                }
            }
        }
    }

    /// Computes the forces of some batches of couples that have a place.
    fn press_group<const D: usize>(
        &self,
        group: Range<usize>,
        couples: &mut [CoupleOf<S::Pair>],
        histories: &mut Histories<<S::Pair as Pair>::Histories>,
        pressed: &mut ChunkForces<S::Pair>,
        work: &mut S::Work,
    ) where
        S: PairPass<D>,
    {
        let ChunkForces { found, works, separated } = pressed;
        let (forces, of_forces) = (&mut found[group.clone()], &mut works[group.clone()]);
        self.pass.press(couples, histories, group.clone(), forces, of_forces, work);
        for batch in group.clone() {
            for lane in 0..LANES {
                let Some(number) = histories.couple(batch * LANES + lane) else { continue };
                let couple = &mut couples[number];
                if S::overlaps(&found[batch], lane) {
                    couple.initial_overlap = Overlap::Counts;
                    continue;
                }
                let Works { friction, damping, .. } = Works::of(&works[batch], lane);
                separated.push((number as u32, Works { friction, damping, ..Works::default() }));
                histories.free(couple.slot);
                couple.part(self.travel, self.pass.distance_in(work, batch - group.start, lane));
            }
        }
    }
}
