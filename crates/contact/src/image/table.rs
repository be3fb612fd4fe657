//! The contacts of an image while it is read: a hash table whose entries are contiguous.

use crate::error::Error;
use crate::image::row::{Direction, Run};
use crate::image::{ImageContact, Label};

/// Contacts by their labels, and the labels themselves.
///
/// The entries are in the order in which they were found; at the end they are sorted by label.
#[derive(Clone, Debug)]
pub(super) struct ContactTable<L, const D: usize> {
    places: HashPlaces,
    contacts: Vec<ImageContact<L, D>>,
    /// Contacts that were used recently: the next run mostly belongs to one of them.
    recent: Vec<Recent<L>>,
    label_places: HashPlaces,
    labels: Vec<L>,
}

/// The labels of a contact, the smaller first, and its place.
#[derive(Clone, Copy, Debug)]
struct Recent<L> {
    labels: [L; 2],
    place: u32,
}

/// A power of two: larger than the number of contacts in a plane of a thousand by a thousand squares, and
/// small enough for the second-level cache.
const RECENT: usize = if cfg!(miri) { 1 << 5 } else { 1 << 15 };

impl<L: Label, const D: usize> ContactTable<L, D> {
    pub(super) fn new() -> Self {
        Self {
            recent: vec![Recent { labels: [L::default(); 2], place: VACANT }; RECENT],
            places: HashPlaces::default(),
            contacts: Vec::new(),
            label_places: HashPlaces::default(),
            labels: Vec::new(),
        }
    }

    /// Adds the pairs of a run; `at` is the position of its later row.
    #[inline]
    pub(super) fn add(&mut self, run: &Run<L>, at: &[u64], direction: &Direction<D>) -> Result<(), Error> {
        let (a, b) = (run.earlier, run.later);
        let labels = [a.min(b), a.max(b)];
        let slot = near(labels);
        let recent = self.recent[slot];
        // Nothing is in contact with itself, so a vacant slot never matches.
        let is_recent = recent.labels == labels;
        let place = if is_recent { recent.place as usize } else { self.place(labels, slot)? };
        self.contacts[place].add(run, at, direction);
        Ok(())
    }

    /// The place of the contact of two labels, which is added if it is new; it is remembered in the slot
    /// `slot`.
    #[inline(never)]
    fn place(&mut self, labels: [L; 2], slot: usize) -> Result<usize, Error> {
        let Self { places, contacts, .. } = self;
        let hash = |[a, b]: [L; 2]| hash(a.bits(), b.bits());
        let place = match places.find(hash(labels), |at| contacts[at].labels() == labels) {
            Some(at) => at,
            None => places.add(contacts, ImageContact::new(labels), |contact| hash(contact.labels()))?,
        };
        self.recent[slot] = Recent { labels, place: place as u32 };
        Ok(place)
    }

    /// The contact of two labels, which is added if it is new.
    fn contact(&mut self, labels: [L; 2]) -> Result<&mut ImageContact<L, D>, Error> {
        let place = self.place(labels, near(labels))?;
        Ok(&mut self.contacts[place])
    }

    /// Records that this label occurs.
    pub(super) fn note(&mut self, label: L) -> Result<(), Error> {
        let Self { label_places, labels, .. } = self;
        let hash = |label: L| hash(label.bits(), 0);
        if label_places.find(hash(label), |at| labels[at] == label).is_none() {
            label_places.add(labels, label, |label| hash(*label))?;
        }
        Ok(())
    }

    pub(super) fn labels(&self) -> &[L] {
        &self.labels
    }

    /// Adds the contacts of another part of the image.
    pub(super) fn merge(&mut self, other: &Self) -> Result<(), Error> {
        other.contacts.iter().try_for_each(|contact| {
            self.contact(contact.labels())?.merge(contact);
            Ok(())
        })
    }

    /// The contacts, sorted by their labels.
    pub(super) fn into_contacts(self) -> Vec<ImageContact<L, D>> {
        let mut contacts = self.contacts;
        contacts.sort_unstable_by_key(ImageContact::labels);
        contacts
    }
}

/// Finds entries of an array by their hash: open addressing with linear probing.
#[derive(Clone, Debug, Default)]
struct HashPlaces {
    /// The slots: a power of two of them, at least a quarter of them vacant; or none.
    slots: Vec<u32>,
}

const VACANT: u32 = u32::MAX;
const FEWEST_SLOTS: usize = 1 << 8;

impl HashPlaces {
    /// The place of the entry with this hash for which `is_it` is true.
    #[inline]
    fn find(&self, hash: u64, mut is_it: impl FnMut(usize) -> bool) -> Option<usize> {
        let last = self.slots.len().checked_sub(1)?;
        let mut slot = hash as usize & last;
        loop {
            match self.slots[slot] {
                VACANT => return None,
                place if is_it(place as usize) => return Some(place as usize),
                _ => slot = (slot + 1) & last,
            }
        }
    }

    /// Appends a new entry and returns its place.
    #[cold]
    fn add<E>(&mut self, entries: &mut Vec<E>, entry: E, hash: impl Fn(&E) -> u64) -> Result<usize, Error> {
        let place = entries.len();
        if place >= VACANT as usize {
            return Err(Error::TooManyContacts { limit: VACANT as usize });
        }
        let bytes = |entries: usize, size: usize| entries.saturating_mul(size);
        let out_of_memory = |bytes| move |_| Error::OutOfMemory { bytes };
        if (place + 1) * 4 > self.slots.len() * 3 {
            let slots = (self.slots.len() * 2).max(FEWEST_SLOTS);
            let mut larger = Vec::new();
            larger.try_reserve_exact(slots).map_err(out_of_memory(bytes(slots, size_of::<u32>())))?;
            larger.resize(slots, VACANT);
            self.slots = larger;
            entries.iter().enumerate().for_each(|(place, entry)| self.occupy(hash(entry), place));
        }
        entries.try_reserve(1).map_err(out_of_memory(bytes(place + 1, size_of::<E>())))?;
        self.occupy(hash(&entry), place);
        entries.push(entry);
        Ok(place)
    }

    fn occupy(&mut self, hash: u64, place: usize) {
        let last = self.slots.len() - 1;
        let mut slot = hash as usize & last;
        while self.slots[slot] != VACANT {
            slot = (slot + 1) & last;
        }
        self.slots[slot] = place as u32;
    }
}

/// The slot of a contact among the recent ones. One multiplication suffices, since labels are often numbered
/// consecutively.
#[inline]
fn near<L: Label>([a, b]: [L; 2]) -> usize {
    // An odd number without a pattern: a fraction of the golden ratio.
    const RATIO: u64 = 0x9e37_79b9_7f4a_7c15;
    let mixed = (a.bits() ^ b.bits().rotate_left(u64::BITS / 2)).wrapping_mul(RATIO);
    (mixed >> (u64::BITS - RECENT.trailing_zeros())) as usize
}

/// Mixes two numbers: the halves of a 128-bit product, each of which depends on all bits of both.
#[inline]
fn hash(a: u64, b: u64) -> u64 {
    // Odd numbers without a pattern: fractions of the square roots of 2 and 3.
    const FIRST: u64 = 0x6a09_e667_f3bc_c909;
    const SECOND: u64 = 0xbb67_ae85_84ca_a73b;
    let fold = |product: u128| product as u64 ^ (product >> 64) as u64;
    let first = fold(u128::from(a ^ FIRST) * u128::from(SECOND));
    fold(u128::from(first ^ b) * u128::from(FIRST))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_again() {
        let mut table = ContactTable::<u64, 3>::new();
        let pair = |k: u64| [k % 100, 100 + (k << 32)];
        for k in (0..3000).chain(0..3000) {
            assert_eq!(table.contact(pair(k)).unwrap().labels(), pair(k));
            table.note(k).unwrap();
        }
        assert_eq!(table.labels().len(), 3000);
        let contacts = table.into_contacts();
        assert_eq!(contacts.len(), 3000);
        assert!(contacts.is_sorted_by_key(ImageContact::labels));
    }

    #[test]
    fn numbers_in_a_row_are_spread() {
        // Labels are often numbered along space; their hashes must not be consecutive.
        let mut slots = vec![0_u32; 1 << 12];
        for k in 0..1_u64 << 10 {
            for step in [1, 7] {
                slots[hash(k, k + step) as usize % (1 << 12)] += 1;
            }
        }
        assert!(slots.iter().all(|&used| used <= 6), "{:?}", slots.iter().max());
    }
}
