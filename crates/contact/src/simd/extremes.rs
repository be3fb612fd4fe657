//! Extremes of coordinates, for the check of the input, and of motions.
//!
//! Both passes are plain Rust over a fixed number of lanes, compiled once more for AVX2. The lanes are the
//! same for all instructions, and no result depends on them but the sum of the motions, whose order is that
//! of the lanes. Therefore every processor gives the same bits.

#![allow(clippy::needless_range_loop, reason = "a lane is an index into several arrays")]
#![allow(
    clippy::eq_op,
    reason = "the difference of a number and itself is NaN if the number is NaN or infinite"
)]

use crate::real::Real;
#[cfg(target_arch = "x86_64")]
use crate::simd::level::Simd;
use crate::simd::prefetch;

/// Numbers taken at a time. Lane `k` belongs to axis `k % D`, so `D` must divide this; other dimensions have
/// one lane for each axis.
const LANES: usize = 12;

/// The smallest and the largest coordinate on each axis; `None` if there are no points, or if a coordinate is
/// NaN or infinite.
pub(crate) fn of_points<T: Real, const D: usize>(points: &[[T; D]]) -> Option<([T; D], [T; D])> {
    let first = points.first()?;
    let start = Extremes { min: *first, max: *first, odd: [T::ZERO; D] };
    let extremes = if LANES.is_multiple_of(D) {
        #[cfg(target_arch = "x86_64")]
        if Simd::Avx2.is_available() {
            // SAFETY: the processor has AVX2.
            unsafe { points_avx2(start, points) }
        } else {
            points_in_lanes(start, points)
        }
        #[cfg(not(target_arch = "x86_64"))]
        points_in_lanes(start, points)
    } else {
        start.with_points::<D>(points.as_flattened())
    };
    extremes.odd.iter().all(|&odd| odd == T::ZERO).then_some((extremes.min, extremes.max))
}

/// # Safety
/// The processor has AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn points_avx2<T: Real, const D: usize>(start: Extremes<T, D>, points: &[[T; D]]) -> Extremes<T, D> {
    points_in_lanes(start, points)
}

#[inline(always)]
fn points_in_lanes<T: Real, const D: usize>(start: Extremes<T, D>, points: &[[T; D]]) -> Extremes<T, D> {
    let numbers = points.as_flattened();
    // The same number of bytes for either type.
    if size_of::<T>() == size_of::<f32>() {
        start.with_points::<{ 2 * LANES }>(numbers)
    } else {
        start.with_points::<LANES>(numbers)
    }
}

/// Extremes of some numbers in `N` lanes.
#[derive(Clone, Copy)]
struct Extremes<T, const N: usize> {
    min: [T; N],
    max: [T; N],
    /// 0, or NaN if a number was NaN or infinite.
    odd: [T; N],
}

impl<T: Real, const N: usize> Extremes<T, N> {
    #[inline(always)]
    fn take(&mut self, numbers: &[T; N]) {
        for k in 0..N {
            let x = numbers[k];
            self.min[k] = if x < self.min[k] { x } else { self.min[k] };
            self.max[k] = if x > self.max[k] { x } else { self.max[k] };
            self.odd[k] = self.odd[k] + (x - x);
        }
    }

    /// These extremes, one for each axis, with those of `numbers`, taken in `M` lanes.
    #[inline(always)]
    fn with_points<const M: usize>(mut self, numbers: &[T]) -> Self {
        let mut lanes = Extremes { min: [T::ZERO; M], max: [T::ZERO; M], odd: [T::ZERO; M] };
        for k in 0..M {
            (lanes.min[k], lanes.max[k]) = (self.min[k % N], self.max[k % N]);
        }
        let (blocks, rest) = numbers.as_chunks::<M>();
        for block in blocks {
            prefetch::read(&block[0]);
            prefetch::read(&block[M / 2]);
            lanes.take(block);
        }
        for k in 0..M {
            let axis = k % N;
            self.take_one(axis, lanes.min[k]);
            self.take_one(axis, lanes.max[k]);
            self.odd[axis] = self.odd[axis] + lanes.odd[k];
        }
        for (k, &x) in rest.iter().enumerate() {
            self.take_one(k % N, x);
        }
        self
    }

    #[inline(always)]
    fn take_one(&mut self, axis: usize, x: T) {
        self.min[axis] = if x < self.min[axis] { x } else { self.min[axis] };
        self.max[axis] = if x > self.max[axis] { x } else { self.max[axis] };
        self.odd[axis] = self.odd[axis] + (x - x);
    }
}

/// The motions of points on each axis: the differences of their coordinates, which are finite, now and
/// before, rounded in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motions<const D: usize> {
    pub(crate) min: [f64; D],
    pub(crate) max: [f64; D],
    pub(crate) sum: [f64; D],
}

impl<const D: usize> Motions<D> {
    /// The motions of no points.
    pub(crate) const NONE: Self =
        Self { min: [f64::INFINITY; D], max: [f64::NEG_INFINITY; D], sum: [0.0; D] };

    /// Takes the motions of more points; both slices have the same length.
    pub(crate) fn with<T: Real>(self, now: &[[T; D]], before: &[[T; D]]) -> Self {
        let (now, before) = (now.as_flattened(), before.as_flattened());
        if !LANES.is_multiple_of(D) {
            return self.in_lanes::<T, D>(now, before);
        }
        #[cfg(target_arch = "x86_64")]
        if Simd::Avx2.is_available() {
            // SAFETY: the processor has AVX2.
            return unsafe { self.with_avx2(now, before) };
        }
        self.in_lanes::<T, LANES>(now, before)
    }

    /// # Safety
    /// The processor has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn with_avx2<T: Real>(self, now: &[T], before: &[T]) -> Self {
        self.in_lanes::<T, LANES>(now, before)
    }

    #[inline(always)]
    fn in_lanes<T: Real, const M: usize>(mut self, now: &[T], before: &[T]) -> Self {
        let mut lanes = Motions { min: [f64::INFINITY; M], max: [f64::NEG_INFINITY; M], sum: [0.0; M] };
        let ((now, last_now), (before, last_before)) = (now.as_chunks::<M>(), before.as_chunks::<M>());
        for (now, before) in now.iter().zip(before) {
            for place in [&now[0], &now[M / 2], &before[0], &before[M / 2]] {
                prefetch::read(place);
            }
            // One loop for each operation: compilers make vectors of these, and not of one loop with all of
            // them.
            let mut motion = [0.0; M];
            for k in 0..M {
                motion[k] = now[k].to_f64() - before[k].to_f64();
            }
            for k in 0..M {
                lanes.min[k] = if motion[k] < lanes.min[k] { motion[k] } else { lanes.min[k] };
            }
            for k in 0..M {
                lanes.max[k] = if motion[k] > lanes.max[k] { motion[k] } else { lanes.max[k] };
            }
            for k in 0..M {
                lanes.sum[k] += motion[k];
            }
        }
        for k in 0..M {
            self.join(k % D, lanes.min[k], lanes.max[k], lanes.sum[k]);
        }
        for (k, (now, before)) in last_now.iter().zip(last_before).enumerate() {
            let motion = now.to_f64() - before.to_f64();
            self.join(k % D, motion, motion, motion);
        }
        self
    }

    #[inline(always)]
    fn join(&mut self, axis: usize, min: f64, max: f64, sum: f64) {
        self.min[axis] = if min < self.min[axis] { min } else { self.min[axis] };
        self.max[axis] = if max > self.max[axis] { max } else { self.max[axis] };
        self.sum[axis] += sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points whose coordinates are all different.
    fn points<T: Real, const D: usize>(n: usize) -> Vec<[T; D]> {
        let number = |k: usize| T::nearest(((k * 7919) % 10_007) as f64 - 5000.0);
        (0..n).map(|k| std::array::from_fn(|axis| number(D * k + axis))).collect()
    }

    fn extremes_of<T: Real, const D: usize>() {
        assert_eq!(of_points::<T, D>(&[]), None);
        for n in [1, 2, 3, 4, 5, 7, 8, 9, 16, 33, 100] {
            let mut points = points::<T, D>(n);
            for axis in 0..D {
                let all = || points.iter().map(|point| point[axis].to_f64());
                let (min, max) = of_points(&points).unwrap();
                assert_eq!(min[axis].to_f64(), all().fold(f64::INFINITY, f64::min), "{n} points in {D}D");
                assert_eq!(max[axis].to_f64(), all().fold(f64::NEG_INFINITY, f64::max), "{n} points in {D}D");
            }
            for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(T::nearest) {
                for k in 0..n {
                    for axis in 0..D {
                        let right = std::mem::replace(&mut points[k][axis], wrong);
                        assert_eq!(of_points(&points), None, "{wrong} at {k} of {n}, axis {axis} of {D}");
                        points[k][axis] = right;
                    }
                }
            }
            assert!(of_points(&points).is_some());
        }
    }

    #[test]
    fn extremes_are_those_of_all_coordinates_and_none_is_overlooked() {
        extremes_of::<f64, 1>();
        extremes_of::<f64, 2>();
        extremes_of::<f64, 3>();
        extremes_of::<f64, 5>();
        extremes_of::<f32, 2>();
        extremes_of::<f32, 3>();
        extremes_of::<f32, 7>();
    }

    fn motions_of<T: Real, const D: usize>() {
        assert_eq!(Motions::<D>::NONE.with::<T>(&[], &[]), Motions::NONE);
        for n in [1, 2, 3, 4, 5, 7, 8, 9, 16, 33, 100] {
            let (now, mut before) = (points::<T, D>(n), points::<T, D>(n + 50));
            before.drain(..50);
            let motions = Motions::<D>::NONE.with(&now, &before);
            for axis in 0..D {
                // Whole numbers: the order of a sum does not matter.
                let all = || {
                    now.iter().zip(&before).map(|(now, before)| now[axis].to_f64() - before[axis].to_f64())
                };
                assert_eq!(motions.min[axis], all().fold(f64::INFINITY, f64::min), "{n} points in {D}D");
                assert_eq!(motions.max[axis], all().fold(f64::NEG_INFINITY, f64::max), "{n} points in {D}D");
                assert_eq!(motions.sum[axis], all().sum::<f64>(), "{n} points in {D}D");
            }
        }
    }

    #[test]
    fn motions_are_those_of_all_points() {
        motions_of::<f64, 1>();
        motions_of::<f64, 2>();
        motions_of::<f64, 3>();
        motions_of::<f64, 5>();
        motions_of::<f32, 2>();
        motions_of::<f32, 3>();
    }
}
