//! Distances of points and of boxes, in the form that is compared.
//!
//! Nearly all questions are about Euclid's norm where nothing repeats: it is compiled for itself, in a plane
//! and in space with loops of a fixed length. The operations and their order are those of all other cases.

use super::Norm;
use super::norm::{Far, NearSide, along};

/// Distances between points and boxes. A point is a box whose corners are equal.
pub(crate) trait Metric: Copy + Sync {
    /// The distance of two points.
    fn distance(self, a: &[f64], b: &[f64]) -> f64;

    /// No points of two boxes, each with its lower and its upper corner, are nearer.
    fn least(self, a: [&[f64]; 2], b: [&[f64]; 2]) -> f64;

    /// No points of two boxes are farther.
    fn greatest(self, a: [&[f64]; 2], b: [&[f64]; 2]) -> f64;
}

/// Euclid's norm in `D` dimensions of which none repeats.
#[derive(Clone, Copy)]
pub(crate) struct Euclid<const D: usize>;

impl<const D: usize> Metric for Euclid<D> {
    #[inline]
    fn distance(self, a: &[f64], b: &[f64]) -> f64 {
        let (a, b) = (&a[..D], &b[..D]);
        let mut sum = 0.0;
        for axis in 0..D {
            let x = a[axis] - b[axis];
            sum += x * x;
        }
        sum
    }

    #[inline]
    fn least(self, [low, high]: [&[f64]; 2], [other_low, other_high]: [&[f64]; 2]) -> f64 {
        let (low, high, other_low, other_high) = (&low[..D], &high[..D], &other_low[..D], &other_high[..D]);
        let mut sum = 0.0;
        for axis in 0..D {
            let x = (low[axis] - other_high[axis]).max(other_low[axis] - high[axis]).max(0.0);
            sum += x * x;
        }
        sum
    }

    #[inline]
    fn greatest(self, [low, high]: [&[f64]; 2], [other_low, other_high]: [&[f64]; 2]) -> f64 {
        let (low, high, other_low, other_high) = (&low[..D], &high[..D], &other_low[..D], &other_high[..D]);
        let mut sum = 0.0;
        for axis in 0..D {
            let x = (low[axis] - other_high[axis]).abs().max((high[axis] - other_low[axis]).abs());
            sum += x * x;
        }
        sum
    }
}

/// Euclid's norm in any number of dimensions, of which none repeats.
#[derive(Clone, Copy)]
pub(crate) struct EuclidOfMany;

/// The differences of coordinates along each axis.
fn differences(a: &[f64], b: &[f64]) -> impl Iterator<Item = f64> {
    a.iter().zip(b).map(|(a, b)| a - b)
}

impl Metric for EuclidOfMany {
    #[inline]
    fn distance(self, a: &[f64], b: &[f64]) -> f64 {
        Norm::Two.sum(differences(a, b))
    }

    #[inline]
    fn least(self, [low, high]: [&[f64]; 2], [other_low, other_high]: [&[f64]; 2]) -> f64 {
        let gaps = differences(low, other_high).zip(differences(other_low, high));
        Norm::Two.sum(gaps.map(|(below, above)| below.max(above).max(0.0)))
    }

    #[inline]
    fn greatest(self, [low, high]: [&[f64]; 2], [other_low, other_high]: [&[f64]; 2]) -> f64 {
        let ways = differences(low, other_high).zip(differences(high, other_low));
        Norm::Two.sum(ways.map(|(one, other)| one.abs().max(other.abs())))
    }
}

/// Any norm, on axes of which some repeat.
#[derive(Clone, Copy)]
pub(crate) struct General<'a> {
    pub(crate) norm: Norm,
    /// Length of the box that repeats, on each axis; 0 where nothing repeats.
    pub(crate) sides: &'a [f64],
}

impl Metric for General<'_> {
    #[inline]
    fn distance(self, a: &[f64], b: &[f64]) -> f64 {
        let axes = a.iter().zip(b).zip(self.sides);
        self.norm.sum(axes.map(|((&x, &y), &side)| along(x - y, side)))
    }

    #[inline]
    fn least(self, [low, high]: [&[f64]; 2], [other_low, other_high]: [&[f64]; 2]) -> f64 {
        self.norm.sum(self.sides.iter().enumerate().map(|(axis, &side)| {
            let (from, to) = (low[axis] - other_high[axis], high[axis] - other_low[axis]);
            NearSide { from, to, side }.value()
        }))
    }

    #[inline]
    fn greatest(self, [low, high]: [&[f64]; 2], [other_low, other_high]: [&[f64]; 2]) -> f64 {
        self.norm.sum(self.sides.iter().enumerate().map(|(axis, &side)| {
            let (from, to) = (low[axis] - other_high[axis], high[axis] - other_low[axis]);
            Far { from, to, side }.value()
        }))
    }
}

/// Evaluates `work` with the metric of a norm in the space of a tree.
macro_rules! with_metric {
    ($tree:expr, $norm:expr, $metric:ident => $work:expr) => {
        match ($norm, $tree.dimensions, $tree.repeats) {
            (Norm::Two, 2, false) => {
                let $metric = $crate::tree::metric::Euclid::<2>;
                $work
            }
            (Norm::Two, 3, false) => {
                let $metric = $crate::tree::metric::Euclid::<3>;
                $work
            }
            (Norm::Two, _, false) => {
                let $metric = $crate::tree::metric::EuclidOfMany;
                $work
            }
            (norm, ..) => {
                let $metric = $crate::tree::metric::General { norm, sides: &$tree.sides };
                $work
            }
        }
    };
}
pub(crate) use with_metric;
