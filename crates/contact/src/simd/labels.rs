//! A filter in the form that the kernels read.

use crate::filter::{Filter, GroupMatrix, Sight};
use crate::simd::task::Arrays;
use crate::simd::vector::Vector;

/// Pointers to the arrays of a filter; null for arrays that it does not have.
#[derive(Clone, Copy)]
pub(super) struct LabelPointers<'a> {
    bodies: *const u32,
    /// Categories, or groups if there are more groups than bits in a word.
    categories: *const u32,
    masks: *const u32,
    matrix: Option<&'a GroupMatrix>,
}

/// The numbers of one element.
#[derive(Clone, Copy)]
pub(super) struct ElementLabel {
    body: u32,
    category: u32,
    mask: u32,
    /// The groups that the element sees: one bit each.
    groups: *const u32,
}

pub(super) const NO_LABELS: LabelPointers<'_> = LabelPointers {
    bodies: std::ptr::null(),
    categories: std::ptr::null(),
    masks: std::ptr::null(),
    matrix: None,
};

pub(super) const NO_LABEL: ElementLabel =
    ElementLabel { body: 0, category: 0, mask: 0, groups: std::ptr::null() };

impl<'a> LabelPointers<'a> {
    #[inline(always)]
    pub(super) fn new<T>(arrays: &Arrays<'a, T>) -> Self {
        let mut labels = NO_LABELS;
        let Some(filter) = arrays.filter else { return labels };
        let &Filter { bodies, sight } = filter.filter();
        let len = arrays.ids.len();
        if let Some(bodies) = bodies {
            labels.bodies = bodies[..len].as_ptr();
        }
        match sight {
            Sight::All => {}
            Sight::Masks { categories, masks } => {
                labels.categories = categories[..len].as_ptr();
                labels.masks = masks[..len].as_ptr();
            }
            Sight::Groups { groups, matrix } => {
                labels.categories = groups[..len].as_ptr();
                labels.matrix = Some(matrix);
            }
        }
        labels
    }

    /// Whether both have the same kinds of numbers and the same number of groups.
    pub(super) fn are_like(&self, other: &Self) -> bool {
        [self.bodies, self.categories, self.masks].map(<*const u32>::is_null)
            == [other.bodies, other.categories, other.masks].map(<*const u32>::is_null)
            && self.matrix.map(GroupMatrix::groups) == other.matrix.map(GroupMatrix::groups)
    }

    /// The numbers of one element.
    ///
    /// # Safety
    /// `place` is inside the arrays that this was made from.
    #[inline(always)]
    pub(super) unsafe fn of(&self, place: usize) -> ElementLabel {
        let mut label = NO_LABEL;
        // SAFETY: the contract of this function.
        unsafe {
            if !self.bodies.is_null() {
                label.body = *self.bodies.add(place);
            }
            if !self.categories.is_null() {
                label.category = *self.categories.add(place);
            }
            if !self.masks.is_null() {
                label.mask = *self.masks.add(place);
            }
        }
        if let Some(matrix) = self.matrix {
            label.groups = matrix.row(label.category).as_ptr();
        }
        label
    }

    /// The bits of `hits` whose element, from `place` on, may form a couple with the labelled one.
    ///
    /// # Safety
    /// The processor has the instructions of `V`, the `V::LANES` places from `place` on are inside the
    /// arrays, all groups there are groups of the matrix, and `label` comes from [`LabelPointers::of`] of
    /// labels that are alike.
    #[inline(always)]
    pub(super) unsafe fn admitted<T, V: Vector<T>>(
        &self,
        label: &ElementLabel,
        place: usize,
        mut hits: u32,
    ) -> u32 {
        // SAFETY: the contract of this function. A row of the matrix has a bit for each group, in whole
        // words.
        unsafe {
            if !self.bodies.is_null() {
                hits &= !V::equal(label.body, self.bodies.add(place));
            }
            if !self.masks.is_null() {
                hits &= V::overlap(label.mask, self.categories.add(place))
                    & V::overlap(label.category, self.masks.add(place));
            } else if self.matrix.is_some() {
                hits &= V::set(label.groups, self.categories.add(place));
            }
        }
        hits
    }
}
