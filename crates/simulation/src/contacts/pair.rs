//! A pair of kinds of bodies: the data that their couples keep from step to step, parts that may touch, and
//! their forces.
//!
//! `couples.rs` is written once for all pairs, and calls these functions for chunks and batches of couples.
//! The pair of elements with elements is `elements.rs`.

use std::fmt::Debug;
use std::ops::Range;

use crate::bodies::Bodies;
use crate::contacts::places::{Histories, HistoryBatch};
use crate::lanes::{Lanes, row};
use crate::vector::Point;

/// Number of couples between one whose forces are computed and the one whose nodes are prefetched; twice as
/// far ahead, the numbers of the nodes are.
pub(super) const AHEAD: usize = 6;

/// Types that the couples of two kinds of bodies keep from step to step.
pub(crate) trait Pair: Clone + Debug + Send + Sync {
    /// Anything between the two parts besides their contact: the joint of two elements.
    type Between: Copy + Debug + Send + Sync;
    /// Histories of a batch of couples that touch.
    type Histories: HistoryBatch + Clone + Debug + Send + Sync;
    /// Forces of a batch of couples.
    type Forces: Clone + Debug + Send + Sync;

    const NO_FORCES: Self::Forces;

    /// Time that a couple that touches takes in a step, in the unit of `ranks/spread.rs`.
    const COST: u64;
}

/// A couple of a pair of kinds.
pub(crate) type CoupleOf<P> = Couple<<P as Pair>::Between>;

/// The history of a couple that touches.
pub(crate) type HistoryOf<P> = <<P as Pair>::Histories as HistoryBatch>::History;

/// Whether a couple that begins to touch may overlap already, without a force that has pressed its parts
/// apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Overlap {
    /// It does not: all of the overlap counts.
    #[default]
    Counts,
    /// Forces begin at zero with this overlap.
    Credited,
    /// The same, for bodies that overlap at the beginning.
    Ignored,
    /// The same, but this overlap is less in each step.
    Relaxing,
}

impl Overlap {
    /// The way with this number.
    pub(super) fn of_number(number: u8) -> Self {
        let ways = [Self::Counts, Self::Credited, Self::Ignored, Self::Relaxing];
        ways.into_iter().find(|way| *way as u8 == number).unwrap_or_default()
    }
}

/// Two parts that may touch. Of parts of one kind, the one with the lower number is the first.
#[derive(Clone, Debug)]
pub(crate) struct Couple<B> {
    pub(super) parts: [u32; 2],
    pub(super) between: B,
    /// Whether an overlap counts that no force has pressed apart. Once the forces have been computed, this is
    /// [`Overlap::Counts`].
    pub(super) initial_overlap: Overlap,
    /// Whether the two overlap. Then they have a history, at this place in the [`Histories`] of their chunk.
    pub(super) touches: bool,
    pub(super) slot: u16,
    /// The two cannot touch before points of bodies have travelled this distance since the beginning, m.
    pub(super) apart_until: f64,
}

impl<B> Couple<B> {
    /// A couple that does not touch.
    pub(super) fn new(parts: [u32; 2], between: B, initial_overlap: Overlap) -> Self {
        Self { parts, between, initial_overlap, touches: false, slot: 0, apart_until: 0.0 }
    }

    /// Notes that the parts are at least this far apart, m. `travel`: distance that points of bodies have
    /// travelled since the beginning, m.
    pub(super) fn part(&mut self, travel: f64, distance: f64) {
        self.initial_overlap = Overlap::Counts;
        self.touches = false;
        // Both parts may move, each by half of the distance. The factor is slightly below 0.5 because
        // `travel` is rounded.
        self.apart_until = travel + 0.499 * distance;
    }
}

/// Energy of a contact, and works since the last pass, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Works {
    pub(super) energy: f64,
    pub(super) friction: f64,
    pub(super) damping: f64,
    /// Energy that appeared because a joint handed over to the contact.
    pub(super) handed_over: f64,
    /// Energy that appeared because less of an initial overlap is ignored.
    pub(super) relaxed: f64,
}

/// The numbers of [`Works`] of a batch of couples, in the order of its fields.
pub(crate) type BatchWorks = [Lanes; 5];

impl Works {
    /// Returns the energy and the works of one couple of a batch.
    #[inline]
    pub(super) fn of(batch: &BatchWorks, lane: usize) -> Self {
        let [energy, friction, damping, handed_over, relaxed] = row(batch, lane);
        Self { energy, friction, damping, handed_over, relaxed }
    }
}

/// Two kinds of bodies in a step, with all that their contacts depend on.
pub(crate) trait PairPass<const D: usize>: Sync {
    type Pair: Pair;
    type One: Bodies<D>;
    type Other: Bodies<D>;
    /// Sums to which the forces of contacts are added.
    type Target: ?Sized + Send;
    /// Memory for a group of batches.
    type Work;

    /// Whether the two kinds are one, so that couples are found within one list of parts.
    const ALIKE: bool;
    /// Number of batches whose forces are computed together.
    const GROUP: usize;

    fn one(&self) -> &Self::One;

    fn other(&self) -> &Self::Other;

    /// Parts among which couples are searched, of the first kind and of the second; none of the second if
    /// both are one.
    fn searched(&self) -> [&[u32]; 2];

    /// A new couple of two parts; `None` if they cannot touch.
    fn couple(&self, parts: [u32; 2]) -> Option<CoupleOf<Self::Pair>>;

    /// A lower bound of the distance of the parts of a couple, m, which need not be sharp beyond `most`;
    /// `None` if they overlap, are near each other, or must be looked at in each step.
    fn distance(&self, couple: &CoupleOf<Self::Pair>, most: f64) -> Option<f64>;

    /// Whether parts that do not touch may begin to.
    #[inline]
    fn may_begin(&self, parts: [u32; 2]) -> bool {
        let _ = parts;
        true
    }

    /// Whether the contact of a couple acts. Notes an initial overlap, too.
    #[inline]
    fn acts(&self, couple: &mut CoupleOf<Self::Pair>) -> bool {
        let _ = couple;
        true
    }

    /// `step`: time step, s.
    fn work(&self, step: f64) -> Self::Work;

    /// Lower bounds of the distances, m, of the first couples of `near`, as many as a batch has at most;
    /// negative if the parts may overlap. `near`: places among `couples`; those behind the batch follow next.
    fn distances(
        &self,
        couples: &[CoupleOf<Self::Pair>],
        near: &[usize],
        work: &mut Self::Work,
        distances: &mut Lanes,
    );

    /// Computes the forces of a group of batches of couples that have a place, and continues their histories.
    /// `found` and `works`: forces and works of these batches.
    fn press(
        &self,
        couples: &[CoupleOf<Self::Pair>],
        histories: &mut Histories<<Self::Pair as Pair>::Histories>,
        batches: Range<usize>,
        found: &mut [<Self::Pair as Pair>::Forces],
        works: &mut [BatchWorks],
        work: &mut Self::Work,
    );

    /// Whether the parts of a couple overlap, by its forces.
    fn overlaps(found: &<Self::Pair as Pair>::Forces, lane: usize) -> bool;

    /// A lower bound of the distance, m, of a couple of the last group of batches whose parts do not overlap.
    /// `batch`: its place in the group.
    fn distance_in(&self, work: &Self::Work, batch: usize, lane: usize) -> f64;

    /// Works against the friction and the damping that a couple had in the last step, in the second half of
    /// that step, J.
    fn last_works(&self, parts: [u32; 2], history: &HistoryOf<Self::Pair>, step: f64) -> [f64; 2];

    /// Adds the forces of a couple to the sums. Returns whether one part has sunk so deep into the other that
    /// the contact is too soft.
    fn add(
        found: &<Self::Pair as Pair>::Forces,
        lane: usize,
        parts: [u32; 2],
        target: &mut Self::Target,
    ) -> bool;

    /// Prefetches the sums of a couple.
    #[inline]
    fn prefetch(parts: [u32; 2], target: &Self::Target) {
        let _ = (parts, target);
    }

    /// The force on the first part of a couple, and the tangential part of it, N.
    fn force(history: &HistoryOf<Self::Pair>) -> [Point<D>; 2];

    /// Points where the forces of couples act, m.
    fn points(&self, couples: &[[u32; 2]]) -> Vec<Point<D>>;
}
