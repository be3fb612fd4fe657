//! Work that is compiled for each set of vector instructions. All of them do the same operations on each
//! number, so that the bits are the same.

#![allow(clippy::inline_always, reason = "the work must end up in the function that is compiled for it")]

use fdem_contact::Simd;

/// Work on vectors.
pub(crate) trait Work {
    type Done;

    /// Does it. This must be inlined.
    fn run<L: Level>(self) -> Self::Done;
}

/// A set of vector instructions.
pub(crate) trait Level {
    /// The columns of four rows.
    fn columns(rows: [[f64; 4]; 4]) -> [[f64; 4]; 4];
}

/// Does some work with these instructions.
#[allow(unsafe_code, reason = "it is compiled for vector instructions")]
pub(crate) fn run<W: Work>(simd: Simd, work: W) -> W::Done {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn avx2<W: Work>(work: W) -> W::Done {
        work.run::<Avx2>()
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512vl")]
    fn avx512<W: Work>(work: W) -> W::Done {
        work.run::<Avx2>()
    }

    match simd {
        // SAFETY: a run takes the instructions that this processor has.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512 => unsafe { avx512(work) },
        // SAFETY: the same.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2 => unsafe { avx2(work) },
        _ => work.run::<Portable>(),
    }
}

/// The instructions of any processor.
struct Portable;

impl Level for Portable {
    #[inline(always)]
    fn columns(rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
        [0, 1, 2, 3].map(|column| rows.map(|row| row[column]))
    }
}

#[cfg(target_arch = "x86_64")]
struct Avx2;

#[cfg(target_arch = "x86_64")]
impl Level for Avx2 {
    /// The compiler would move one number at a time.
    #[inline(always)]
    #[allow(unsafe_code, reason = "vector instructions")]
    fn columns(rows: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
        use std::arch::x86_64::{__m256d, _mm256_permute2f128_pd, _mm256_unpackhi_pd, _mm256_unpacklo_pd};
        use std::mem::transmute;
        // SAFETY: only work that is compiled for AVX2 comes here; four numbers are the bytes of a vector.
        unsafe {
            let [a, b, c, d]: [__m256d; 4] = transmute(rows);
            let (low, high) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (lower, higher) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            transmute([
                _mm256_permute2f128_pd::<0x20>(low, lower),
                _mm256_permute2f128_pd::<0x20>(high, higher),
                _mm256_permute2f128_pd::<0x31>(low, lower),
                _mm256_permute2f128_pd::<0x31>(high, higher),
            ])
        }
    }
}
