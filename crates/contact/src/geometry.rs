//! When two elements touch: the floating-point operations that [`Elements`](crate::Elements) documents, for
//! each kind of element.

use crate::filter::Filter;
use crate::real::Real;

/// The geometry of a set of elements as an engine reads it: the kind of element is resolved once per search,
/// not once per couple.
pub(crate) trait Geometry: Copy {
    /// Number of elements.
    fn len(self) -> usize;

    /// The coordinate that decides the cell of an element: that of its centre, or of the minimum corner of
    /// its box.
    fn anchor(self, index: usize, axis: usize) -> f64;

    /// The closed comparison documented at [`Elements`](crate::Elements).
    fn touch(self, i: usize, j: usize) -> bool;
}

/// Geometry and filter together: elements touch if both say so.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filtered<'a, G> {
    pub(crate) geometry: G,
    pub(crate) filter: Filter<'a>,
}

impl<G: Geometry> Geometry for Filtered<'_, G> {
    fn len(self) -> usize {
        self.geometry.len()
    }

    #[inline]
    fn anchor(self, index: usize, axis: usize) -> f64 {
        self.geometry.anchor(index, axis)
    }

    #[inline]
    fn touch(self, i: usize, j: usize) -> bool {
        self.filter.admits(i, j) && self.geometry.touch(i, j)
    }
}

/// Spheres of one radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EqualSpheres<'a, T, const D: usize> {
    pub(crate) centres: &'a [[T; D]],
    pub(crate) radius: T,
    pub(crate) reach_squared: T,
}

/// Spheres, each with its own radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spheres<'a, T, const D: usize> {
    pub(crate) centres: &'a [[T; D]],
    pub(crate) radii: &'a [T],
    pub(crate) tolerance: T,
}

/// Axis-aligned boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boxes<'a, T, const D: usize> {
    pub(crate) min: &'a [[T; D]],
    pub(crate) max: &'a [[T; D]],
    pub(crate) tolerance: T,
}

impl<'a, T: Real, const D: usize> EqualSpheres<'a, T, D> {
    pub(crate) fn points(self) -> &'a [[T; D]] {
        self.centres
    }

    /// The radius as a slice of length 1, for the check.
    pub(crate) fn radii(&self) -> &[T] {
        std::slice::from_ref(&self.radius)
    }

    pub(crate) fn radius(self) -> T {
        self.radius
    }

    pub(crate) fn reach_squared(self) -> T {
        self.reach_squared
    }

    pub(crate) fn distance_squared(self, i: usize, j: usize) -> T {
        distance_squared(&self.centres[i], &self.centres[j])
    }
}

impl<'a, T: Real, const D: usize> Spheres<'a, T, D> {
    pub(crate) fn points(self) -> &'a [[T; D]] {
        self.centres
    }

    pub(crate) fn radii(self) -> &'a [T] {
        self.radii
    }
}

impl<'a, T: Real, const D: usize> Boxes<'a, T, D> {
    /// The corners that decide the cells of boxes.
    pub(crate) fn points(self) -> &'a [[T; D]] {
        self.min
    }

    pub(crate) fn far_points(self) -> &'a [[T; D]] {
        self.max
    }

    pub(crate) fn distance_squared(self, i: usize, j: usize) -> T {
        let mut sum = T::ZERO;
        for axis in 0..D {
            for (low, high) in [(self.min[i], self.max[j]), (self.min[j], self.max[i])] {
                let gap = low[axis] - high[axis];
                // At most one of the two is positive.
                if gap > T::ZERO {
                    sum = sum + gap * gap;
                }
            }
        }
        sum
    }
}

impl<T: Real, const D: usize> Geometry for EqualSpheres<'_, T, D> {
    fn len(self) -> usize {
        self.centres.len()
    }

    #[inline]
    fn anchor(self, index: usize, axis: usize) -> f64 {
        self.centres[index][axis].to_f64()
    }

    #[inline]
    fn touch(self, i: usize, j: usize) -> bool {
        // Twin, also of spheres: `touch` in `crates/gpu/kernels/rows.h`.
        self.distance_squared(i, j) <= self.reach_squared
    }
}

impl<T: Real, const D: usize> Geometry for Spheres<'_, T, D> {
    fn len(self) -> usize {
        self.centres.len()
    }

    #[inline]
    fn anchor(self, index: usize, axis: usize) -> f64 {
        self.centres[index][axis].to_f64()
    }

    #[inline]
    fn touch(self, i: usize, j: usize) -> bool {
        let reach = (self.radii[i] + self.radii[j]) + self.tolerance;
        distance_squared(&self.centres[i], &self.centres[j]) <= reach * reach
    }
}

impl<T: Real, const D: usize> Geometry for Boxes<'_, T, D> {
    fn len(self) -> usize {
        self.min.len()
    }

    #[inline]
    fn anchor(self, index: usize, axis: usize) -> f64 {
        self.min[index][axis].to_f64()
    }

    #[inline]
    fn touch(self, i: usize, j: usize) -> bool {
        (0..D).all(|axis| {
            self.min[i][axis] <= self.max[j][axis] + self.tolerance
                && self.min[j][axis] <= self.max[i][axis] + self.tolerance
        })
    }
}

#[inline]
pub(crate) fn distance_squared<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let mut sum = T::ZERO;
    for axis in 0..D {
        let difference = a[axis] - b[axis];
        sum = sum + difference * difference;
    }
    sum
}
