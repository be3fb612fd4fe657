//! Numbers of several elements or joints side by side, and functions that are compiled for vector
//! instructions.
//!
//! The frequent parts of a step are written for one element or joint of a batch, without a branch that
//! depends on it, and called in a loop over the batch. The compiler makes vectors of such a loop: one for
//! each set of instructions that [`compiled_for_vectors`] names, chosen at run time. All of them do the same
//! operations on each element, so that the bits are the same.
//!
//! Section "Vectors" of `bench/NOTES.md` lists obstacles to vectors, and explains how to check a loop.

use fdem_contact::Simd;

use crate::vector::{Matrix, matrix};

/// Number of elements or joints in a batch: two vectors of the widest kind.
pub(crate) const LANES: usize = 16;

/// A number of each member of a batch.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes([f64; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self::all(0.0);

    pub(crate) const fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }
}

/// A tensor, or D vectors, of each member of a batch.
pub(crate) type Tensors<const D: usize> = [[Lanes; D]; D];

/// The tensor of one member.
#[inline(always)]
pub(crate) fn tensor<const D: usize>(of: &Tensors<D>, lane: usize) -> Matrix<D> {
    matrix(|i, k| of[i][k].get(lane))
}

#[inline(always)]
pub(crate) fn set_tensor<const D: usize>(of: &mut Tensors<D>, lane: usize, value: &Matrix<D>) {
    for i in 0..D {
        for k in 0..D {
            of[i][k].set(lane, value[i][k]);
        }
    }
}

/// Points, or other rows of numbers, of each member of a batch.
pub(crate) type Rows<const D: usize, const N: usize> = [[Lanes; D]; N];

/// The points of one member.
#[inline(always)]
pub(crate) fn rows<const D: usize, const N: usize>(of: &Rows<D, N>, lane: usize) -> [[f64; D]; N] {
    std::array::from_fn(|row| std::array::from_fn(|k| of[row][k].get(lane)))
}

#[inline(always)]
pub(crate) fn set_rows<const D: usize, const N: usize>(
    of: &mut Rows<D, N>,
    lane: usize,
    value: &[[f64; D]; N],
) {
    for (row, value) in of.iter_mut().zip(value) {
        set_row(row, lane, value);
    }
}

/// The numbers of one member.
#[inline(always)]
pub(crate) fn row<const D: usize>(of: &[Lanes; D], lane: usize) -> [f64; D] {
    std::array::from_fn(|k| of[k].get(lane))
}

#[inline(always)]
pub(crate) fn set_row<const D: usize>(of: &mut [Lanes; D], lane: usize, value: &[f64; D]) {
    for k in 0..D {
        of[k].set(lane, value[k]);
    }
}

/// The larger of two numbers. One instruction, where `f64::max` takes five, because it handles NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// One number where all bits of the mask are set, the other where none is. By its bits: for a comparison of
/// numbers in memory, the compiler chooses the address to read, and makes no vector.
#[inline(always)]
pub(crate) fn either(mask: u64, one: f64, other: f64) -> f64 {
    f64::from_bits((one.to_bits() & mask) | (other.to_bits() & !mask))
}

/// A set of vector instructions that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Available(Simd);

impl Available {
    /// This set, if the processor has it.
    pub(crate) fn new(simd: Simd) -> Option<Self> {
        simd.is_available().then_some(Self(simd))
    }

    /// The fastest.
    pub(crate) fn best() -> Self {
        Self(Simd::best())
    }

    pub(crate) fn simd(self) -> Simd {
        self.0
    }
}

/// Calls a function on batches, compiled for a set of instructions:
/// `compiled_for_vectors!(fn name = function<const parameters; types>(arguments: types) where bounds)`. The
/// function must be `#[inline(always)]`, and so must be the functions that it calls.
macro_rules! compiled_for_vectors {
    ($vis:vis fn $name:ident = $all:ident<$(const $parameter:ident: $kind:ty),* $(; $generic:ident)?>($($argument:ident: $type:ty),+) $(where $($bound:tt)+)?) => {
        /// The loop over a batch, with these instructions.
        #[allow(unsafe_code, reason = "it is compiled for vector instructions")]
        #[inline]
        $vis fn $name<$(const $parameter: $kind,)* $($generic)?>(available: $crate::lanes::Available, $($argument: $type),+) $(where $($bound)+)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2")]
            fn avx2<$(const $parameter: $kind,)* $($generic)?>($($argument: $type),+) $(where $($bound)+)? {
                $all::<$($parameter,)* $($generic)?>($($argument),+);
            }

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512vl")]
            fn avx512<$(const $parameter: $kind,)* $($generic)?>($($argument: $type),+) $(where $($bound)+)? {
                $all::<$($parameter,)* $($generic)?>($($argument),+);
            }

            match available.simd() {
                // SAFETY: this processor has the instructions, or there were no `Available`.
                #[cfg(target_arch = "x86_64")]
                fdem_contact::Simd::Avx512 => unsafe { avx512::<$($parameter,)* $($generic)?>($($argument),+) },
                // SAFETY: the same.
                #[cfg(target_arch = "x86_64")]
                fdem_contact::Simd::Avx2 => unsafe { avx2::<$($parameter,)* $($generic)?>($($argument),+) },
                _ => $all::<$($parameter,)* $($generic)?>($($argument),+),
            }
        }
    };
}
pub(crate) use compiled_for_vectors;
