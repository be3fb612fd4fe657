//! AVX-512: 8 lanes of `f64`, 16 of `f32`.

use std::arch::x86_64::*;

use crate::couple::Couple;
use crate::simd::kernel::{self, Output, Task, Vector};

/// # Safety
/// The processor has the features, and `task` is as its fields say, `TWO_SETS` among them.
#[target_feature(enable = "avx512f,avx512vl,avx2,bmi2,popcnt")]
pub(crate) unsafe fn search_f64<const D: usize, const TWO_SETS: bool>(
    task: &Task<'_, f64, D>,
    out: &mut Output<'_>,
) {
    // SAFETY: the contract of this function.
    unsafe { kernel::search::<f64, F64x8, D, TWO_SETS>(task, out) }
}

/// # Safety
/// The processor has the features, and `task` is as its fields say, `TWO_SETS` among them.
#[target_feature(enable = "avx512f,avx512vl,avx2,bmi2,popcnt")]
pub(crate) unsafe fn search_f32<const D: usize, const TWO_SETS: bool>(
    task: &Task<'_, f32, D>,
    out: &mut Output<'_>,
) {
    // SAFETY: the contract of this function.
    unsafe { kernel::search::<f32, F32x16, D, TWO_SETS>(task, out) }
}

#[derive(Clone, Copy)]
struct F64x8(__m512d);

impl Vector<f64> for F64x8 {
    const LANES: usize = 8;

    one_instruction!(f64: _mm512_set1_pd, _mm512_loadu_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd);

    #[inline(always)]
    unsafe fn at_most(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        u32::from(unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    unsafe fn below(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        u32::from(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    unsafe fn equal(number: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            u32::from(_mm256_cmpeq_epi32_mask(
                _mm256_loadu_si256(from.cast()),
                _mm256_set1_epi32(number.cast_signed()),
            ))
        }
    }

    #[inline(always)]
    unsafe fn overlap(bits: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            u32::from(_mm256_test_epi32_mask(
                _mm256_loadu_si256(from.cast()),
                _mm256_set1_epi32(bits.cast_signed()),
            ))
        }
    }

    #[inline(always)]
    unsafe fn set(row: *const u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let groups = _mm256_loadu_si256(from.cast());
            let words = _mm256_i32gather_epi32::<4>(row.cast(), _mm256_srli_epi32::<5>(groups));
            // The bit of the group becomes the sign.
            let shifts = _mm256_andnot_si256(groups, _mm256_set1_epi32(31));
            let signs = _mm256_sllv_epi32(words, shifts);
            _mm256_movemask_ps(_mm256_castsi256_ps(signs)).cast_unsigned()
        }
    }

    #[inline(always)]
    unsafe fn store<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`; a couple is two u32.
        unsafe {
            let ids = _mm256_maskz_compress_epi32(hits as __mmask8, _mm256_loadu_si256(ids.cast()));
            let id = _mm256_set1_epi32(id.cast_signed());
            let (low, high) =
                if TWO_SETS { (id, ids) } else { (_mm256_min_epu32(ids, id), _mm256_max_epu32(ids, id)) };
            // Zero-extended numbers side by side: i | j << 32 is the couple in memory.
            let couples = _mm512_or_si512(
                _mm512_cvtepu32_epi64(low),
                _mm512_slli_epi64::<32>(_mm512_cvtepu32_epi64(high)),
            );
            _mm512_storeu_si512(to.cast(), couples);
        }
    }
}

#[derive(Clone, Copy)]
struct F32x16(__m512);

impl Vector<f32> for F32x16 {
    const LANES: usize = 16;

    one_instruction!(f32: _mm512_set1_ps, _mm512_loadu_ps, _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps);

    #[inline(always)]
    unsafe fn at_most(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    unsafe fn below(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    unsafe fn equal(number: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            u32::from(_mm512_cmpeq_epi32_mask(
                _mm512_loadu_si512(from.cast()),
                _mm512_set1_epi32(number.cast_signed()),
            ))
        }
    }

    #[inline(always)]
    unsafe fn overlap(bits: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            u32::from(_mm512_test_epi32_mask(
                _mm512_loadu_si512(from.cast()),
                _mm512_set1_epi32(bits.cast_signed()),
            ))
        }
    }

    #[inline(always)]
    unsafe fn set(row: *const u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let groups = _mm512_loadu_si512(from.cast());
            let words = _mm512_i32gather_epi32::<4>(_mm512_srli_epi32::<5>(groups), row.cast());
            // The bit of the group becomes the sign.
            let shifts = _mm512_andnot_si512(groups, _mm512_set1_epi32(31));
            let signs = _mm512_sllv_epi32(words, shifts);
            u32::from(_mm512_cmplt_epi32_mask(signs, _mm512_setzero_si512()))
        }
    }

    #[inline(always)]
    unsafe fn store<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`; a couple is two u32.
        unsafe {
            let ids = _mm512_maskz_compress_epi32(hits as __mmask16, _mm512_loadu_si512(ids.cast()));
            let id = _mm512_set1_epi32(id.cast_signed());
            let (low, high) =
                if TWO_SETS { (id, ids) } else { (_mm512_min_epu32(ids, id), _mm512_max_epu32(ids, id)) };
            let to: *mut __m512i = to.cast();
            for half in 0..2 {
                let [low, high] = [low, high].map(|numbers| {
                    let half = if half == 0 {
                        _mm512_castsi512_si256(numbers)
                    } else {
                        _mm512_extracti64x4_epi64::<1>(numbers)
                    };
                    _mm512_cvtepu32_epi64(half)
                });
                _mm512_storeu_si512(to.add(half), _mm512_or_si512(low, _mm512_slli_epi64::<32>(high)));
            }
        }
    }
}
