//! Couples of parts of two kinds of bodies that may touch, and their detection.
//!
//! The detection gets new boxes only when parts may have moved by a part of the buffer. Couples whose boxes
//! are near stay only if their parts are nearer than the buffer: in three dimensions a few of a hundred. A
//! couple that does not touch is skipped until points of bodies may have travelled half of its gap. All these
//! bounds add up the distance of the fastest point in each step, so that no contact is found too late.

use fdem_contact::{Buffered, Couple as Candidate, Detector, Elements as Boxes};

use crate::bodies::Bodies;
use crate::contacts::chunk::{ChunkForces, ChunkPass};
use crate::contacts::pair::{AHEAD, Couple, CoupleOf, HistoryOf, Overlap, Pair, PairPass, Works};
use crate::contacts::places::Histories;
use crate::error::{ModelError, Stop};
use crate::forces::ContactForce;
use crate::sum::{Grains, Pile, Sum};
use crate::team::{CHUNK, Team};
use crate::vector::minus;

/// Number of chunks of couples for each thread whose forces are computed together. Meanwhile, those of the
/// round before are added to the forces of bodies. The memory for the forces of couples does not grow beyond
/// two rounds.
const ROUND: usize = 16;

/// Share of the buffer for the motion of parts between two updates of their boxes.
const SLACK: f64 = 0.25;

/// Couples of parts that may touch, and their detection.
#[derive(Clone, Debug)]
pub(crate) struct Couples<const D: usize, P: Pair> {
    search: Buffered<f64, D>,
    /// Gap up to which couples are chosen among the candidates, m.
    buffer: f64,
    /// After each update of the search, all couples with a smaller gap than this are among the candidates, m.
    slack: f64,
    /// Upper bound of the distance that points of bodies have travelled in all steps so far, m, its value at
    /// the last update of the search, and when couples were chosen.
    travel: f64,
    looked: f64,
    chosen: f64,
    /// Couples that may touch now, ascending.
    all: Vec<CoupleOf<P>>,
    /// For each chunk of couples, the histories of the couples that touch.
    histories: Vec<Histories<P::Histories>>,
    /// Forces of the couples of two rounds. They are not kept.
    pressed: [Vec<ChunkForces<P>>; 2],
    pub(super) detections: u64,
}

/// Results of a pass over the couples. Energies and works in J.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touching {
    /// Energy stored in the contacts, if requested.
    pub(crate) energy: Option<Sum>,
    /// Work against friction since the last pass.
    pub(crate) friction: Sum,
    /// Energy dissipated by damping since the last pass.
    pub(crate) damping: Sum,
    /// Potential energy that appeared because joints handed over to contact since the last pass.
    pub(crate) handed_over: Sum,
    /// Potential energy that appeared because less of initial overlaps is ignored, since the last pass.
    pub(crate) relaxed: Sum,
    /// Number of couples that overlap.
    pub(crate) count: usize,
    /// The parts of the first couple in which one part has sunk too deep into the other.
    pub(crate) deep: Option<[u32; 2]>,
}

impl Touching {
    /// Takes the works of a round of couples, and adds their forces to those of their parts. One by one: sums
    /// of chunks would depend on the couples that do not touch, and a resumed run may have others.
    fn take<const D: usize, S: PairPass<D>>(
        &mut self,
        pass: &S,
        couples: &[CoupleOf<S::Pair>],
        pressed: &[ChunkForces<S::Pair>],
        grains: Grains,
        target: &mut S::Target,
    ) {
        for (couples, pressed) in couples.chunks(CHUNK).zip(pressed) {
            let mut piles = [Pile::default(); 4];
            let mut add = |sums: &mut Self, works: &Works| {
                if let Some(energy) = &mut sums.energy {
                    energy.add(works.energy);
                }
                let works = [works.friction, works.damping, works.handed_over, works.relaxed];
                piles.iter_mut().zip(works).for_each(|(pile, work)| pile.add(work, grains));
            };
            let mut separated = pressed.separated.iter().peekable();
            for (number, couple) in (0..).zip(couples) {
                if let Some(next) = couples.get(number as usize + 2 * AHEAD) {
                    S::prefetch(next.parts, target);
                }
                let counted = pass.one().counts(couple.parts[0]);
                if let Some((_, works)) = separated.next_if(|(couple, _)| *couple == number)
                    && counted
                {
                    add(self, works);
                }
                if couple.touches {
                    let (works, deep) = pressed.add_to::<D, S>(target, couple.parts, couple.slot);
                    if counted {
                        add(self, &works);
                        self.count += 1;
                        self.deep = self.deep.or(deep.then_some(couple.parts));
                    }
                }
            }
            let sums = [&mut self.friction, &mut self.damping, &mut self.handed_over, &mut self.relaxed];
            sums.into_iter().zip(piles).for_each(|(sum, pile)| sum.add_pile(pile));
        }
    }
}

impl<const D: usize, P: Pair> Couples<D, P> {
    /// `buffer`: gap up to which couples are chosen, m.
    pub(crate) fn new(buffer: f64, team: &Team) -> Result<Self, ModelError> {
        let slack = SLACK * buffer;
        let detector = team.pool().map_or_else(Detector::new, |pool| Detector::new().on_pool(pool));
        let search = Buffered::with_search(detector, buffer - slack)
            .map_err(|error| ModelError::Detection { message: error.to_string() })?;
        let round = || (0..ROUND * team.threads()).map(|_| ChunkForces::default()).collect();
        Ok(Self {
            search,
            buffer,
            slack,
            travel: 0.0,
            looked: f64::NEG_INFINITY,
            chosen: f64::NEG_INFINITY,
            all: Vec::new(),
            histories: Vec::new(),
            pressed: [round(), round()],
            detections: 0,
        })
    }

    /// Adds the distance of the fastest point of a body in a step, m.
    pub(crate) fn note_motion(&mut self, distance: f64) {
        self.travel += distance;
    }

    /// Asks for an update of the search in the next step, because it gets other parts.
    pub(crate) fn search_again(&mut self) {
        self.looked = f64::NEG_INFINITY;
    }

    /// Whether parts may have moved so far that the search must look at them.
    pub(super) fn is_due(&self) -> bool {
        // Both parts of a couple may have travelled this far.
        2.0 * (self.travel - self.looked) > self.slack
    }

    /// Whether any couple touches, or is not known to be apart.
    pub(super) fn any_near(&self) -> bool {
        self.all.iter().any(|couple| couple.touches || couple.apart_until <= self.travel)
    }

    /// Updates the search as far as motion requires, with the boxes of all parts. Returns whether couples are
    /// to be chosen then: those that were not chosen before must not touch before the next update.
    pub(super) fn look<S: PairPass<D, Pair = P>>(&mut self, pass: &S, team: &Team) -> Result<bool, Stop> {
        if !self.is_due() {
            return Ok(false);
        }
        let [ones, others] = pass.searched();
        let count = ones.len() + others.len();
        let [mut min, mut max] = [vec![[0.0; D]; count], vec![[0.0; D]; count]];
        team.change_both(&mut min, &mut max, |first, least, most| {
            for (k, (least, most)) in least.iter_mut().zip(most).enumerate() {
                [*least, *most] = match (first + k).checked_sub(ones.len()) {
                    None => pass.one().bounds(ones[first + k]),
                    Some(k) => pass.other().bounds(others[k]),
                };
            }
        });
        let update = self.search.update(&Boxes::boxes(&min, &max)?.with_tolerance(self.slack)?)?;
        let is_new = update.redetected();
        self.detections += u64::from(is_new);
        self.looked = self.travel;
        Ok(is_new || 2.0 * (self.travel - self.chosen) + self.slack > self.buffer)
    }

    /// Chooses the couples among the candidates of the last update whose parts are near.
    pub(super) fn choose_near<S: PairPass<D, Pair = P>>(&mut self, pass: &S, team: &Team) {
        let [ones, others] = pass.searched();
        let candidates = self.search.candidates();
        let (travel, buffer) = (self.travel, self.buffer);
        let parts = |&Candidate { i, j }: &Candidate| {
            let [i, j] = [i as usize, j as usize];
            if S::ALIKE {
                return Some([ones[i], ones[j]]);
            }
            Some([*ones.get(i)?, *others.get(j.checked_sub(ones.len())?)?])
        };
        let acts = |parts: &[u32; 2]| pass.one().acts(parts[0]) || pass.other().acts(parts[1]);
        let found = team.look(candidates.len(), |range| {
            let acting = candidates[range].iter().filter_map(parts).filter(acts);
            let couples = acting.filter_map(|parts| pass.couple(parts));
            couples.filter_map(|couple| near(couple, pass, travel, buffer)).collect::<Vec<_>>()
        });
        self.chosen = self.travel;
        let mut couples = Vec::with_capacity(found.iter().map(Vec::len).sum());
        couples.extend(found.into_iter().flatten());
        self.choose(couples);
    }

    /// All couples, ascending.
    pub(super) fn all(&self) -> &[CoupleOf<P>] {
        &self.all
    }

    /// Upper bound of the distance that points of bodies have travelled in all steps so far, m.
    pub(super) fn travel(&self) -> f64 {
        self.travel
    }

    /// Changes all couples by their places. `histories`: those of the couples that touch then, in their
    /// order.
    pub(super) fn change(
        &mut self,
        mut change: impl FnMut(usize, &mut CoupleOf<P>),
        histories: impl IntoIterator<Item = HistoryOf<P>>,
    ) {
        self.all.iter_mut().enumerate().for_each(|(place, couple)| change(place, couple));
        self.group_histories(histories);
    }

    /// The couples that touch, with their histories.
    pub(crate) fn touching(&self) -> impl Iterator<Item = ([u32; 2], HistoryOf<P>)> {
        let chunks = self.all.chunks(CHUNK).zip(&self.histories);
        chunks.flat_map(|(couples, histories)| {
            let touching = couples.iter().filter(|couple| couple.touches);
            touching.map(|couple| (couple.parts, histories.get(couple.slot)))
        })
    }

    /// The parts of the couples that touch, with repetitions.
    pub(crate) fn touching_parts(&self, team: &Team) -> Vec<u32> {
        team.list(self.all.len(), |range| {
            let touching = self.all[range].iter().filter(|couple| couple.touches);
            touching.flat_map(|couple| couple.parts).collect()
        })
    }

    /// The couples that touch, with the time that each takes in a step.
    pub(crate) fn costs(&self) -> impl Iterator<Item = ([u32; 2], u64)> {
        self.all.iter().filter(|couple| couple.touches).map(|couple| (couple.parts, P::COST))
    }

    /// Restores couples that touch. All others are found again in the next step. `between`: anything between
    /// the parts of a couple until then.
    pub(crate) fn restore(&mut self, mut touching: Vec<([u32; 2], HistoryOf<P>)>, between: P::Between) {
        self.search_again();
        touching.sort_unstable_by_key(|(parts, _)| *parts);
        let couple = |parts| Couple { touches: true, ..Couple::new(parts, between, Overlap::Counts) };
        self.all = touching.iter().map(|&(parts, _)| couple(parts)).collect();
        self.group_histories(touching.into_iter().map(|(_, history)| history));
    }

    /// Distributes the histories of the couples that touch, in their order, among the chunks of couples.
    fn group_histories(&mut self, histories: impl IntoIterator<Item = HistoryOf<P>>) {
        let mut of_couples = histories.into_iter();
        let group = |couples: &mut [CoupleOf<P>]| {
            let count = couples.iter().filter(|couple| couple.touches).count();
            let mut histories = Histories::with_capacity(count);
            let touching = couples.iter_mut().enumerate().filter(|(_, couple)| couple.touches);
            for ((number, couple), history) in touching.zip(&mut of_couples) {
                couple.slot = histories.give(number, &history);
            }
            histories
        };
        self.histories = self.all.chunks_mut(CHUNK).map(group).collect();
    }

    /// Replaces the couples by those that may touch now. Couples that were there before keep their history.
    fn choose(&mut self, mut couples: Vec<CoupleOf<P>>) {
        couples.sort_unstable_by_key(|couple| couple.parts);
        let histories: Vec<_> = self.touching().map(|(_, history)| history).collect();
        let mut histories = histories.into_iter();
        let before = std::mem::take(&mut self.all);
        let mut before = before.into_iter().map(|known| {
            let history = if known.touches { histories.next() } else { None };
            (known, history)
        });
        let mut known = before.next();
        let mut kept = Vec::new();
        for couple in &mut couples {
            while known.as_ref().is_some_and(|(known, _)| known.parts < couple.parts) {
                known = before.next();
            }
            if let Some((known, history)) = &known
                && known.parts == couple.parts
            {
                // The distance found now may be larger than the one found then.
                let apart_until = if !known.touches && known.initial_overlap == Overlap::Counts {
                    known.apart_until.max(couple.apart_until)
                } else {
                    known.apart_until
                };
                *couple = Couple { between: couple.between, apart_until, ..known.clone() };
                kept.extend(*history);
            }
        }
        self.all = couples;
        self.group_histories(kept);
    }

    /// Adds couples, ascending, as far as they are not known.
    pub(crate) fn add(&mut self, new: impl Iterator<Item = CoupleOf<P>>) {
        let is_known =
            |new: &CoupleOf<P>| self.all.binary_search_by_key(&new.parts, |couple| couple.parts).is_ok();
        let new: Vec<_> = new.filter(|new| !is_known(new)).collect();
        if !new.is_empty() {
            let histories: Vec<_> = self.touching().map(|(_, history)| history).collect();
            self.all.extend(new);
            // A stable sort of two ascending runs is one merge.
            self.all.sort_by_key(|couple| couple.parts);
            self.group_histories(histories);
        }
    }

    /// Notes which of the couples that may begin to touch may overlap already, in this way.
    pub(crate) fn note_overlaps(&mut self, way: Overlap, overlap: impl Fn(&[u32; 2]) -> bool) {
        // Couples that are known to be apart do not overlap.
        let travel = self.travel;
        let near = |couple: &&mut CoupleOf<P>| !couple.touches && couple.apart_until <= travel;
        for couple in self.all.iter_mut().filter(near) {
            if overlap(&couple.parts) {
                couple.initial_overlap = couple.initial_overlap.max(way);
            }
        }
    }

    /// Computes the forces of all couples, and adds them to those of their parts. `step`: time step, s;
    /// `grains`: of the works that are added up; `energy`: whether to compute the energy of the contacts.
    pub(crate) fn press<S: PairPass<D, Pair = P>>(
        &mut self,
        pass: &S,
        target: &mut S::Target,
        step: f64,
        grains: Grains,
        energy: bool,
        team: &Team,
    ) -> Touching {
        let mut all = Touching { energy: energy.then(Sum::default), ..Touching::default() };
        let Self { travel, all: couples, histories, pressed, .. } = self;
        let of_chunk = ChunkPass { pass, step, travel: *travel };
        let [last, next] = pressed;
        let (round, mut done) = (next.len(), &[][..]);
        let rounds = couples.chunks_mut(round * CHUNK).zip(histories.chunks_mut(round));
        for (couples, histories) in rounds {
            team.both(
                || all.take(pass, done, last, grains, target),
                || {
                    team.change_chunks(couples, histories, next, |couples, histories, pressed| {
                        of_chunk.press::<D>(couples, histories, pressed);
                    });
                },
            );
            done = couples;
            std::mem::swap(last, next);
        }
        all.take(pass, done, last, grains, target);
        all
    }

    /// Forces of the couples that touch, at the points where their parts overlap now.
    pub(crate) fn forces<S: PairPass<D, Pair = P>>(&self, pass: &S) -> Vec<ContactForce<D>> {
        let couples: Vec<[u32; 2]> = self.touching().map(|(parts, _)| parts).collect();
        let points = pass.points(&couples);
        let forces = self.touching().zip(points).map(|((elements, history), point)| {
            let [force, tangential] = S::force(&history);
            ContactForce { elements, point, normal: minus(force, tangential), tangential }
        });
        forces.collect()
    }
}

/// The couple, if its parts are not farther apart than this, m.
fn near<const D: usize, S: PairPass<D>>(
    mut couple: CoupleOf<S::Pair>,
    pass: &S,
    travel: f64,
    most: f64,
) -> Option<CoupleOf<S::Pair>> {
    if let Some(distance) = pass.distance(&couple, most) {
        couple.part(travel, distance);
        return (distance <= most).then_some(couple);
    }
    Some(couple)
}

#[cfg(test)]
mod tests;
