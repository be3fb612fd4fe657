//! The vector instructions of a search, chosen at run time, so that a standard build is fast on every
//! processor.
//!
//! The kernel is written once, in `kernel`, over the few operations of `Vector`. A second kernel, in
//! `cluster`, compares four elements at a time and falls back on the first. Each other file implements the
//! operations for one instruction set and compiles both kernels for it. `portable` is plain Rust and the
//! definition: all others give the same couples in the same order. To add an instruction set, write its file
//! and add it to [`Simd`] and to the macro below; tests pick it up from [`Simd::available`].

#![allow(unsafe_code, reason = "vector instructions, and pointers instead of slices in inner loops")]
#![allow(
    clippy::inline_always,
    reason = "instructions must end up in the function that is compiled for them"
)]
#![allow(clippy::wildcard_imports, reason = "std::arch is a flat list of instructions")]

/// The operations of `Vector` that are one instruction each: splat, load, add, sub, mul.
#[allow(unused_macros, reason = "only processors with a file of their own use it")]
macro_rules! one_instruction {
    ($scalar:ty: $splat:ident, $load:ident, $add:ident, $sub:ident, $mul:ident) => {
        #[inline(always)]
        unsafe fn splat(x: $scalar) -> Self {
            // SAFETY: the contract of `Vector`.
            Self(unsafe { $splat(x) })
        }

        #[inline(always)]
        unsafe fn load(from: *const $scalar) -> Self {
            // SAFETY: the contract of `Vector`.
            Self(unsafe { $load(from) })
        }

        #[inline(always)]
        unsafe fn add(self, other: Self) -> Self {
            // SAFETY: the contract of `Vector`.
            Self(unsafe { $add(self.0, other.0) })
        }

        #[inline(always)]
        unsafe fn sub(self, other: Self) -> Self {
            // SAFETY: the contract of `Vector`.
            Self(unsafe { $sub(self.0, other.0) })
        }

        #[inline(always)]
        unsafe fn mul(self, other: Self) -> Self {
            // SAFETY: the contract of `Vector`.
            Self(unsafe { $mul(self.0, other.0) })
        }
    };
}

/// Compiles the kernels for a set of instructions, with its vectors, in 2D and 3D. None of the functions is
/// generic, so they are compiled once with this crate, not again with every crate that uses it.
#[allow(unused_macros, reason = "as above")]
macro_rules! entry_points {
    ($features:literal, $f64:ident, $f32:ident) => {
        entry_points!($features, 2, plane, $f64, $f32);
        entry_points!($features, 3, space, $f64, $f32);
    };
    ($features:literal, $dimensions:literal, $module:ident, $f64:ident, $f32:ident) => {
        pub(crate) mod $module {
            use super::{$f32, $f64};
            use crate::simd::task::{Output, Task};
            use crate::simd::{cluster, kernel};

            entry_points!($features, $dimensions, $f64, $f32, f64: search_f64, rows_f64, two_sets_f64, clusters_f64);
            entry_points!($features, $dimensions, $f32, $f32, f32: search_f32, rows_f32, two_sets_f32, clusters_f32);
        }
    };
    ($features:literal, $dimensions:literal, $vector:ident, $f32:ident,
        $type:ident: $search:ident, $rows:ident, $two_sets:ident, $clusters:ident) => {
        /// Searches with the kernel that suits `task`.
        ///
        /// # Safety
        /// The processor has the features. The groups of the filters are groups of their matrix, as
        /// [`Arranged`](crate::filter::Arranged) promises. The kernels assert everything else that they rely
        /// on.
        pub(crate) unsafe fn $search(task: &Task<'_, $type>, out: &mut Output<'_>) {
            // SAFETY: the contract of this function; the conditions establish the rest of each contract.
            unsafe {
                if task.two_sets && !task.one_numbering {
                    $two_sets(task, out);
                } else if cluster::pays(task) {
                    $clusters(task, out);
                } else {
                    $rows(task, out);
                }
            }
        }

        /// The kernel of one numbering, compiled for the features.
        ///
        /// # Safety
        /// The conditions of the search above.
        #[target_feature(enable = $features)]
        unsafe fn $rows(task: &Task<'_, $type>, out: &mut Output<'_>) {
            // SAFETY: the contract of this function.
            unsafe { kernel::search::<$type, $vector, $dimensions, false>(task, out) }
        }

        /// The kernel of two numberings, compiled for the features.
        ///
        /// # Safety
        /// The conditions of the search above.
        #[target_feature(enable = $features)]
        unsafe fn $two_sets(task: &Task<'_, $type>, out: &mut Output<'_>) {
            // SAFETY: the contract of this function.
            unsafe { kernel::search::<$type, $vector, $dimensions, true>(task, out) }
        }

        /// The kernel of clusters, compiled for the features.
        ///
        /// # Safety
        /// The conditions of the search above, and `cluster::pays(task)`.
        #[target_feature(enable = $features)]
        unsafe fn $clusters(task: &Task<'_, $type>, out: &mut Output<'_>) {
            // SAFETY: the contract of this function.
            unsafe { cluster::search::<$type, $vector, $f32, $dimensions>(task, out) }
        }
    };
}

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod cluster;
pub(crate) mod extremes;
mod kernel;
pub(crate) mod level;
mod labels;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
pub(crate) mod prefetch;
pub(crate) mod task;
mod vector;

pub use level::Simd;
pub(crate) use task::{Available, Kernels};
use task::{Output, Task};

/// Collects the bit `7 - SHIFT` of each byte; that of the first byte becomes the lowest bit.
#[inline(always)]
pub(crate) fn bits_of_bytes<const SHIFT: i32>(bytes: &[u8; 64]) -> u64 {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::*;

        (0..4).rev().fold(0, |bits, quarter| {
            // SAFETY: every x86-64 has SSE2, and 16 bytes are read inside the array.
            let quarter = unsafe {
                let bytes = _mm_loadu_si128(bytes.as_ptr().add(16 * quarter).cast());
                // The shift is by 16-bit numbers: a bit that comes from the byte below is never the highest
                // bit of a byte.
                _mm_movemask_epi8(_mm_slli_epi16::<SHIFT>(bytes))
            };
            bits << 16 | u64::from(quarter.cast_unsigned())
        })
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let (words, _) = bytes.as_chunks::<8>();
        words.iter().rev().fold(0, |bits, word| {
            // Each product of a lowest bit with the one relevant power of two out of eight lands in the
            // highest byte, and no other product reaches it.
            let lowest = u64::from_le_bytes(*word) >> (7 - SHIFT) & 0x0101_0101_0101_0101;
            bits << 8 | lowest.wrapping_mul(0x0102_0408_1020_4080) >> 56
        })
    }
}

/// Whether there are vector kernels for this dimension. Each dimension costs the time to compile some fifty
/// kernels.
pub(crate) const fn has_vectors(dimensions: usize) -> bool {
    dimensions == 2 || dimensions == 3
}

macro_rules! kernels {
    ($type:ty, $search:ident) => {
        impl Kernels for $type {
            fn search<const D: usize>(level: Available, task: &Task<'_, Self>, out: &mut Output<'_>) {
                // SAFETY: this processor has the instructions, or there were no `Available`. The groups of
                // the filters of `task` are checked, or there were no `Arranged`.
                unsafe {
                    match (level.level(), D) {
                        #[cfg(target_arch = "x86_64")]
                        (Simd::Avx512, 2) => avx512::plane::$search(task, out),
                        #[cfg(target_arch = "x86_64")]
                        (Simd::Avx512, 3) => avx512::space::$search(task, out),
                        #[cfg(target_arch = "x86_64")]
                        (Simd::Avx2, 2) => avx2::plane::$search(task, out),
                        #[cfg(target_arch = "x86_64")]
                        (Simd::Avx2, 3) => avx2::space::$search(task, out),
                        #[cfg(target_arch = "aarch64")]
                        (Simd::Neon, 2) => neon::plane::$search(task, out),
                        #[cfg(target_arch = "aarch64")]
                        (Simd::Neon, 3) => neon::space::$search(task, out),
                        _ => portable::search::<$type, D>(task, out),
                    }
                }
            }
        }
    };
}

kernels!(f32, search_f32);
kernels!(f64, search_f64);
