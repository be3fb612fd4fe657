//! The contacts of a saved run, or on their way between ranks.
//!
//! All functions that save, resume, renumber or distribute a run call these. A pair of kinds of bodies adds
//! its couples here.

use std::collections::BTreeMap;

use fdem_distributed::wire;
use serde::{Deserialize, Serialize};

use crate::contacts::elements::grips::Grip;
use crate::lists::once_each;

/// State of contacts between two steps, without couples that do not touch: these are found again.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "Grip<D, N>: Serialize", deserialize = "Grip<D, N>: Deserialize<'de>"))]
pub(crate) struct SavedContacts<const D: usize = 2, const N: usize = 3> {
    /// Couples of elements that touch, with their history of friction and damping.
    pub(super) grips: Vec<([u32; 2], Grip<D, N>)>,
    /// Pairs of elements that separated in the last step, and elements that became bare: see
    /// [`Surface`](crate::contacts::surface::Surface).
    pub(super) parted: Vec<[u32; 2]>,
    pub(super) bared: Vec<u32>,
    /// Elements that the model has since the next step, as far as their overlaps do not count immediately.
    pub(super) new: Vec<u32>,
}

wire!([const D: usize, const N: usize] SavedContacts<D, N> { grips, parted, bared, new });

impl<const D: usize, const N: usize> Default for SavedContacts<D, N> {
    fn default() -> Self {
        Self { grips: Vec::new(), parted: Vec::new(), bared: Vec::new(), new: Vec::new() }
    }
}

impl<const D: usize, const N: usize> SavedContacts<D, N> {
    /// Adds those of another part of a run.
    pub(crate) fn add(&mut self, more: Self) {
        self.grips.extend(more.grips);
        self.parted.extend(more.parted);
        self.bared.extend(more.bared);
        self.new.extend(more.new);
    }

    /// Puts everything in order, without repetition.
    pub(crate) fn sort(&mut self) {
        self.grips.sort_unstable_by_key(|(elements, _)| *elements);
        self.sort_parted();
    }

    /// Puts elements that have separated or become bare in order, without repetition.
    pub(crate) fn sort_parted(&mut self) {
        once_each(&mut self.parted);
        once_each(&mut self.bared);
        once_each(&mut self.new);
    }

    /// The same with other numbers of elements. Entries are left out if one of their elements has none.
    pub(crate) fn renumbered(self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let both = |[a, b]: [u32; 2]| Some([number(a)?, number(b)?]);
        Self {
            grips: self.grips.into_iter().filter_map(|(pair, grip)| Some((both(pair)?, grip))).collect(),
            parted: self.parted.into_iter().filter_map(both).collect(),
            bared: self.bared.into_iter().filter_map(&number).collect(),
            new: self.new.into_iter().filter_map(number).collect(),
        }
    }

    /// Distributes everything among the ranks that have one of its elements. `ranks`: those that have an
    /// element, each once.
    pub(crate) fn distributed(self, ranks: impl Fn(u32) -> Vec<u32>) -> BTreeMap<usize, Self> {
        let mut to = BTreeMap::<usize, Self>::new();
        let of_both = |elements: [u32; 2]| {
            let mut of = elements.map(&ranks).concat();
            once_each(&mut of);
            of.into_iter().map(|rank| rank as usize)
        };
        for (elements, grip) in self.grips {
            of_both(elements).for_each(|rank| to.entry(rank).or_default().grips.push((elements, grip)));
        }
        for elements in self.parted {
            of_both(elements).for_each(|rank| to.entry(rank).or_default().parted.push(elements));
        }
        for element in self.bared {
            for rank in ranks(element) {
                to.entry(rank as usize).or_default().bared.push(element);
            }
        }
        for element in self.new {
            for rank in ranks(element) {
                to.entry(rank as usize).or_default().new.push(element);
            }
        }
        to
    }

    /// Adds the new elements of a run that begins with another model, as far as they are new to this one.
    pub(crate) fn add_new(&mut self, begun: &Self, is_new: impl Fn(u32) -> bool) {
        self.new.extend(begun.new.iter().copied().filter(|&element| is_new(element)));
        once_each(&mut self.new);
    }

    /// The elements among some that have separated or become bare.
    pub(crate) fn parted_at(&self, is_at: impl Fn(&u32) -> bool) -> Self {
        Self {
            grips: Vec::new(),
            parted: self.parted.iter().filter(|pair| pair.iter().any(&is_at)).copied().collect(),
            bared: self.bared.iter().filter(|element| is_at(element)).copied().collect(),
            new: self.new.iter().filter(|element| is_at(element)).copied().collect(),
        }
    }

    /// Forgets the forces of the last step: a resumed run has none before its first step.
    pub(crate) fn without_forces(self) -> Self {
        let grips = self.grips.into_iter().map(|(elements, grip)| (elements, grip.without_push()));
        Self { grips: grips.collect(), ..self }
    }
}
