//! Places of couples among the histories of a chunk.
//!
//! A couple has a lane of a batch as long as it touches. Its history stays there, and each step replaces it.

use crate::lanes::LANES;

/// Marks a place of [`Histories`] without a couple.
const FREE: u16 = u16::MAX;

/// Histories of a batch of couples.
pub(crate) trait HistoryBatch: Sized {
    /// History of one couple.
    type History: Copy;

    /// A batch without histories.
    const NONE: Self;
    /// The history with which a couple begins.
    const NEW: Self::History;

    fn get(&self, lane: usize) -> Self::History;

    fn set(&mut self, lane: usize, history: &Self::History);
}

/// Histories of the couples of a chunk that touch. Each has a place: place `k` is lane `k % LANES` of batch
/// `k / LANES`.
#[derive(Clone, Debug)]
pub(crate) struct Histories<B> {
    pub(super) batches: Vec<B>,
    /// The couple in each place, by its number in the chunk, or [`FREE`].
    couples: Vec<u16>,
    /// No place before this one is free.
    full: usize,
}

impl<B: HistoryBatch> Histories<B> {
    /// Reserves memory for the given number of couples.
    pub(super) fn with_capacity(couples: usize) -> Self {
        let batches = couples.div_ceil(LANES);
        Self { batches: Vec::with_capacity(batches), couples: Vec::with_capacity(batches * LANES), full: 0 }
    }

    /// Gives a place to a couple, and returns it.
    pub(super) fn give(&mut self, couple: usize, history: &B::History) -> u16 {
        while self.couple(self.full).is_some() {
            self.full += 1;
        }
        let place = self.full;
        if place == self.couples.len() {
            // Not twice the number: in most chunks, few couples touch.
            self.batches.reserve_exact(1);
            self.couples.reserve_exact(LANES);
            self.batches.push(B::NONE);
            self.couples.resize(place + LANES, FREE);
        }
        self.couples[place] = couple as u16;
        self.batches[place / LANES].set(place % LANES, history);
        place as u16
    }

    /// Takes the place of a couple back.
    pub(super) fn free(&mut self, place: u16) {
        self.couples[place as usize] = FREE;
        self.full = self.full.min(place as usize);
    }

    /// Drops batches at the end in which no place is taken.
    pub(super) fn trim(&mut self) {
        let places = self.couples.iter().rposition(|&couple| couple != FREE).map_or(0, |last| last + 1);
        self.batches.truncate(places.div_ceil(LANES));
        self.couples.truncate(places.next_multiple_of(LANES));
        self.full = self.full.min(self.couples.len());
    }

    /// The history in a place.
    pub(super) fn get(&self, place: u16) -> B::History {
        self.batches[place as usize / LANES].get(place as usize % LANES)
    }

    /// The couple in a place, by its number in the chunk; `None` if the place is free, or does not exist.
    #[inline]
    pub(super) fn couple(&self, place: usize) -> Option<usize> {
        self.couples.get(place).filter(|&&couple| couple != FREE).map(|&couple| couple as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl HistoryBatch for [f64; LANES] {
        type History = f64;

        const NONE: Self = [0.0; LANES];
        const NEW: f64 = 0.0;

        fn get(&self, lane: usize) -> f64 {
            self[lane]
        }

        fn set(&mut self, lane: usize, history: &f64) {
            self[lane] = *history;
        }
    }

    /// A place is free as soon as its couple separates, and the first free one is given next. The others keep
    /// their histories.
    #[test]
    fn a_couple_keeps_its_place_and_a_free_one_is_given_again() {
        let mut histories = Histories::<[f64; LANES]>::with_capacity(0);
        let places: Vec<u16> = (0..40).map(|couple| histories.give(couple, &(couple as f64))).collect();
        assert!(places.into_iter().eq(0..40));
        assert_eq!(histories.batches.len(), 3);
        histories.free(20);
        histories.free(5);
        assert_eq!([5, 20, 40].map(|place| histories.couple(place)), [None; 3]);
        let given = [100, 101, 102].map(|couple| histories.give(couple, &(couple as f64)));
        assert_eq!(given, [5, 20, 40]);
        for (place, couple) in [(4, 4), (5, 100), (20, 101), (39, 39), (40, 102)] {
            assert_eq!(histories.couple(place), Some(couple));
            assert_eq!(histories.get(place as u16), couple as f64, "place {place}");
        }
    }

    /// Batches without couples at the end cost nothing in the next step; those in the middle stay.
    #[test]
    fn batches_at_the_end_are_dropped_without_couples() {
        let mut histories = Histories::<[f64; LANES]>::with_capacity(40);
        for couple in 0..40 {
            histories.give(couple, &(couple as f64));
        }
        (0..16).chain(17..40).for_each(|place| histories.free(place));
        histories.trim();
        assert_eq!((histories.batches.len(), histories.couple(16)), (2, Some(16)));
        assert_eq!(histories.get(16), 16.0);
        histories.free(16);
        histories.trim();
        assert_eq!(histories.batches.len(), 0);
        assert_eq!(histories.give(7, &7.0), 0);
    }
}
