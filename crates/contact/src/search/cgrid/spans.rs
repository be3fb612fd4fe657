//! The extent of an element along each axis: where it enters the lists and where it leaves them.

use crate::elements::{Elements, Shape};
use crate::real::Real;

/// Number of boxes in the sample that shows whether most are long.
const SAMPLE: usize = 63;

/// The bounding boxes of elements, extended by the reach of contact: if elements touch, their boxes overlap (closed) on every axis.
///
/// # Why no couple is lost
/// Boxes: `low = min` and `high = max + tolerance`, rounded as in the comparison of [`Elements`]. They overlap on every axis exactly where
/// the boxes touch.
///
/// Spheres: `low = x - h` and `high = x + h` with `h = (r + tolerance / 2) (1 + (D + 8) EPSILON) + MIN_RESOLVED / 2`. The relative part of
/// [`Elements::rounding`] may be taken of `r_i + r_j` instead of the largest sum. So spheres that touch are at most `h_i + h_j` apart along
/// an axis; that bound is four times what is needed, which covers the roundings of `h`. Hence `x_i - h_i <= x_j + h_j` holds for exact
/// numbers. Both sides are rounded once, and rounding does not change an order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spans<'e, 'a, T, const D: usize> {
    elements: &'e Elements<'a, T, D>,
    half_tolerance: f64,
    widening: f64,
}

impl<'e, 'a, T: Real, const D: usize> Spans<'e, 'a, T, D> {
    pub(super) fn new(elements: &'e Elements<'a, T, D>) -> Self {
        Self {
            elements,
            half_tolerance: 0.5 * elements.tolerance().to_f64(),
            widening: 1.0 + (D + 8) as f64 * T::EPSILON,
        }
    }

    pub(super) fn elements(&self) -> &'e Elements<'a, T, D> {
        self.elements
    }

    /// Where an element begins and ends along an axis.
    #[inline]
    pub(super) fn span(&self, index: usize, axis: usize) -> [f64; 2] {
        let (centre, radius) = match self.elements.shape {
            Shape::Boxes(boxes) => {
                let high = boxes.far_points()[index][axis] + self.elements.tolerance();
                return [boxes.points()[index][axis].to_f64(), high.to_f64()];
            }
            Shape::Equal(equal) => (equal.points()[index][axis], equal.radius()),
            Shape::Spheres(spheres) => (spheres.points()[index][axis], spheres.radii()[index]),
        };
        let half = (radius.to_f64() + self.half_tolerance) * self.widening + 0.5 * T::MIN_RESOLVED;
        let centre = centre.to_f64();
        [centre - half, centre + half]
    }

    /// Whether the elements are boxes most of which, judged by a sample, are several times longer than their mean width.
    pub(super) fn are_long_boxes(&self) -> bool {
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
    pub(super) fn widths(&self, index: usize) -> [f64; D] {
        std::array::from_fn(|axis| {
            let [low, high] = self.span(index, axis);
            high - low
        })
    }
}
