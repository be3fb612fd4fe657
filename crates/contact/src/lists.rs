//! Singly connected lists in integer arrays: the list heads and the next numbers of one axis.

use crate::error::Error;
use crate::mask::Set;
use crate::memory::resize;

/// Marks an empty head and the end of a list; the book writes -1 (p. 106).
pub const NONE: u32 = u32::MAX;

/// All lists along one axis: `heads` per cell, `next` per element.
///
/// In the book `next` is `Y` and `heads` is `B` on the axis y, `X` and `A` on the axis x, `Z` and `C` on the
/// axis z (`D` and `H` for the last axis of n dimensions). The last axis has one set of heads, the others
/// two.
///
/// An element is on at most one list of an axis, so one `next` serves both sets. A list that has been visited
/// is marked *old* by adding N to its head, as in (3.39), because the memory formula (3.65) leaves no other
/// room for a mark. A reader of a list must therefore decode its head.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    heads: [Vec<u32>; 2],
    next: Vec<u32>,
}

/// The largest number of elements: head + N must stay below [`NONE`].
pub(crate) const MAX_LISTED: usize = (u32::MAX / 2) as usize;

impl Lists {
    /// The stored heads of a set: [`NONE`], an element (a *new* list), or an element + N (an *old* list).
    pub fn heads(&self, set: Set) -> &[u32] {
        &self.heads[set as usize]
    }

    /// The next element on the list of each element, or [`NONE`]; meaningless for elements that are on no
    /// list.
    pub fn next(&self) -> &[u32] {
        &self.next
    }

    /// The elements of list `cell` in list order; none beyond either end of the axis.
    pub fn iter(&self, set: Set, cell: u32) -> impl Iterator<Item = u32> {
        let listed = |element: u32| (element != NONE).then_some(element);
        std::iter::successors(listed(self.first(set, cell)), move |&element| listed(self.after(element)))
    }

    /// Sizes the arrays for `elements` elements and `cells` cells; all lists are empty afterwards.
    ///
    /// Existing heads are empty already, because the search empties every list that it fills. Therefore only
    /// added heads are written. `reset` writes them all; that is the only loop over cells.
    pub(crate) fn prepare(&mut self, elements: usize, cells: [u32; 2], reset: bool) -> Result<(), Error> {
        for (heads, cells) in self.heads.iter_mut().zip(cells) {
            resize(heads, cells as usize, NONE)?;
            if reset {
                heads.fill(NONE);
            }
        }
        resize(&mut self.next, elements, NONE)
    }

    /// Number of integers held: heads and next numbers.
    pub(crate) fn integers(&self) -> usize {
        self.heads[0].len() + self.heads[1].len() + self.next.len()
    }

    /// Whether every head is empty, as it must be between two searches.
    pub(crate) fn all_empty(&self) -> bool {
        self.heads.iter().flatten().all(|&head| head == NONE)
    }

    /// Pushes `element` at the head of list `cell`: (3.20), (3.35).
    #[inline]
    pub(crate) fn push(&mut self, set: Set, cell: u32, element: u32) {
        let head = &mut self.heads[set as usize][cell as usize];
        self.next[element as usize] = *head;
        *head = element;
    }

    /// The first element of list `cell`, whether the list is new or old; [`NONE`] beyond either end of the
    /// axis.
    #[inline]
    pub(crate) fn first(&self, set: Set, cell: u32) -> u32 {
        let head = self.heads[set as usize].get(cell as usize).copied().unwrap_or(NONE);
        let n = self.next.len() as u32;
        if head != NONE && head >= n { head - n } else { head }
    }

    /// Marks a new central list as old and returns its first element; `None` if the list is old already.
    #[inline]
    pub(crate) fn take_new(&mut self, cell: u32) -> Option<u32> {
        let n = self.next.len() as u32;
        let head = &mut self.heads[Set::Central as usize][cell as usize];
        (*head < n).then(|| std::mem::replace(head, *head + n))
    }

    /// The element after `element` on its list.
    #[inline]
    pub(crate) fn after(&self, element: u32) -> u32 {
        self.next[element as usize]
    }

    /// Removes the whole list `cell` by its head.
    #[inline]
    pub(crate) fn remove(&mut self, set: Set, cell: u32) {
        self.heads[set as usize][cell as usize] = NONE;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lists(elements: usize, cells: u32) -> Lists {
        let mut lists = Lists::default();
        lists.prepare(elements, [cells, cells], false).unwrap();
        lists
    }

    #[test]
    fn a_list_reads_in_reverse_order_of_insertion() {
        let mut lists = lists(5, 3);
        for element in [0, 3, 4] {
            lists.push(Set::Central, 1, element);
        }
        lists.push(Set::Neighbours, 1, 2);
        assert_eq!(lists.iter(Set::Central, 1).collect::<Vec<_>>(), [4, 3, 0]);
        assert_eq!(lists.iter(Set::Neighbours, 1).collect::<Vec<_>>(), [2]);
        assert_eq!(lists.iter(Set::Central, 0).count(), 0);
    }

    #[test]
    fn a_list_is_new_once_and_readable_when_old() {
        let mut lists = lists(5, 3);
        lists.push(Set::Central, 1, 0);
        lists.push(Set::Central, 1, 4);
        assert_eq!(lists.take_new(1), Some(4));
        assert_eq!(lists.take_new(1), None);
        assert_eq!(lists.heads(Set::Central), [NONE, 4 + 5, NONE]);
        assert_eq!(lists.first(Set::Central, 1), 4);
        assert_eq!(lists.take_new(0), None, "an empty list is not new");
    }

    #[test]
    fn beyond_the_ends_of_an_axis_there_is_nothing() {
        let lists = lists(5, 3);
        assert_eq!(lists.first(Set::Central, 3), NONE);
        assert_eq!(lists.first(Set::Central, 0_u32.wrapping_sub(1)), NONE);
    }

    #[test]
    fn shrinking_and_growing_again_leaves_only_empty_heads() {
        let mut lists = lists(4, 8);
        lists.prepare(2, [3, 3], false).unwrap();
        lists.prepare(6, [9, 9], false).unwrap();
        assert!(lists.all_empty());
        assert_eq!(lists.integers(), 9 + 9 + 6);
    }
}
