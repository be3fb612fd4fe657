//! The extent of an element along each axis: where it enters the lists and where it leaves them.

use crate::elements::{Elements, Shape};
use crate::real::Real;

/// Number of boxes in the sample that shows whether most are long.
const SAMPLE: usize = 63;

/// The spans of elements ([`Elements::span`]): elements that touch overlap on every axis, so no couple is
/// lost.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spans<'e, 'a, T, const D: usize> {
    elements: &'e Elements<'a, T, D>,
}

impl<'e, 'a, T: Real, const D: usize> Spans<'e, 'a, T, D> {
    pub(super) fn new(elements: &'e Elements<'a, T, D>) -> Self {
        Self { elements }
    }

    pub(super) fn elements(self) -> &'e Elements<'a, T, D> {
        self.elements
    }

    /// Where an element begins and ends along an axis.
    #[inline]
    pub(super) fn span(self, index: usize, axis: usize) -> [f64; 2] {
        self.elements.span(index, axis)
    }

    /// Whether the elements are boxes most of which, judged by a sample, are several times longer than their
    /// mean width.
    pub(super) fn are_long_boxes(self) -> bool {
        let n = self.elements.len();
        if n == 0 || !matches!(self.elements.shape, Shape::Boxes(_)) {
            return false;
        }
        let sample = n.min(SAMPLE);
        let long = |&k: &usize| {
            let widths = self.widths(k * n / sample);
            let longest = widths.iter().fold(0.0, |longest, &width| f64::max(longest, width));
            // The volume of a cube of half the length of the box is larger than that of the box.
            longest > 0.0 && widths.iter().map(|width| 2.0 * width / longest).product::<f64>() < 1.0
        };
        2 * (0..sample).filter(long).count() > sample
    }

    /// The width of an element along each axis, at least 0.
    pub(super) fn widths(self, index: usize) -> [f64; D] {
        std::array::from_fn(|axis| {
            let [low, high] = self.span(index, axis);
            high - low
        })
    }
}
