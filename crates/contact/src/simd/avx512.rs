//! AVX-512: 8 lanes of `f64`, 16 of `f32`.

use std::arch::x86_64::*;

use crate::couple::Couple;
use crate::simd::vector::{CLUSTER, EstimateVector, Vector};

entry_points!("avx512f,avx512vl,avx2,fma,bmi2,popcnt", F64x8, F32x16);

#[derive(Clone, Copy)]
struct F64x8(__m512d);

impl Vector<f64> for F64x8 {
    const LANES: usize = 8;

    one_instruction!(f64: _mm512_set1_pd, _mm512_loadu_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd);

    #[inline(always)]
    unsafe fn store_short(self, to: *mut f32) {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_storeu_ps(to, _mm512_cvtpd_ps(self.0)) }
    }

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
            // Moves the bit of the group to the sign.
            let shifts = _mm256_andnot_si256(groups, _mm256_set1_epi32(31));
            let signs = _mm256_sllv_epi32(words, shifts);
            _mm256_movemask_ps(_mm256_castsi256_ps(signs)).cast_unsigned()
        }
    }

    #[inline(always)]
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`; a couple is two u32.
        unsafe {
            let ids = _mm256_maskz_compress_epi32(hits as __mmask8, _mm256_loadu_si256(ids.cast()));
            let id = _mm256_set1_epi32(id.cast_signed());
            let (low, high) =
                if TWO_SETS { (id, ids) } else { (_mm256_min_epu32(ids, id), _mm256_max_epu32(ids, id)) };
            // Zero-extended numbers, combined: i | j << 32 is the couple in memory.
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
    unsafe fn store_short(self, to: *mut f32) {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm512_storeu_ps(to, self.0) }
    }

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
            // Moves the bit of the group to the sign.
            let shifts = _mm512_andnot_si512(groups, _mm512_set1_epi32(31));
            let signs = _mm512_sllv_epi32(words, shifts);
            u32::from(_mm512_cmplt_epi32_mask(signs, _mm512_setzero_si512()))
        }
    }

    #[inline(always)]
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`; a couple is two u32.
        unsafe {
            let ids = _mm512_maskz_compress_epi32(hits as __mmask16, _mm512_loadu_si512(ids.cast()));
            let id = _mm512_set1_epi32(id.cast_signed());
            let (low, high) =
                if TWO_SETS { (id, ids) } else { (_mm512_min_epu32(ids, id), _mm512_max_epu32(ids, id)) };
            let to: *mut __m512i = to.cast();
            let first = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            let rest = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
            _mm512_storeu_si512(to, _mm512_permutex2var_epi32(low, first, high));
            _mm512_storeu_si512(to.add(1), _mm512_permutex2var_epi32(low, rest, high));
        }
    }
}

impl EstimateVector for F32x16 {
    const MARKS: [u32; CLUSTER] = [1 << 31, 1 << 30, 1 << 29, 1 << 28];

    #[inline(always)]
    unsafe fn mul_add(self, other: Self, sum: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        Self(unsafe { _mm512_fmadd_ps(self.0, other.0, sum.0) })
    }

    #[inline(always)]
    unsafe fn and(self, other: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let both = _mm512_and_si512(_mm512_castps_si512(self.0), _mm512_castps_si512(other.0));
            Self(_mm512_castsi512_ps(both))
        }
    }

    #[inline(always)]
    unsafe fn least(self, other: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let least = _mm512_min_epi32(_mm512_castps_si512(self.0), _mm512_castps_si512(other.0));
            Self(_mm512_castsi512_ps(least))
        }
    }

    #[inline(always)]
    unsafe fn is_within(self, width: f32) -> bool {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let beyond = _mm512_set1_epi32((-width).to_bits().cast_signed());
            _mm512_cmplt_epi32_mask(_mm512_castps_si512(self.0), beyond) != 0
        }
    }

    #[inline(always)]
    unsafe fn marks(vectors: [Self; CLUSTER]) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let [a, b, c, d] = vectors;
            let [a, b] = [_mm512_castps_si512(a.0), _mm512_castps_si512(b.0)];
            let [c, d] = [_mm512_castps_si512(c.0), _mm512_castps_si512(d.0)];
            // 0xca: the bits of the second number where the first has ones, those of the third elsewhere.
            let sign = _mm512_set1_epi32(i32::MIN);
            let first = _mm512_ternarylogic_epi32::<0xca>(sign, a, _mm512_srli_epi32::<1>(b));
            let second = _mm512_ternarylogic_epi32::<0xca>(sign, c, _mm512_srli_epi32::<1>(d));
            let two = _mm512_set1_epi32(i32::MIN >> 1);
            let marks = _mm512_ternarylogic_epi32::<0xca>(two, first, _mm512_srli_epi32::<2>(second));
            Self(_mm512_castsi512_ps(marks))
        }
    }

    #[inline(always)]
    unsafe fn marked(self, of: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { u32::from(_mm512_test_epi32_mask(_mm512_castps_si512(self.0), _mm512_castps_si512(of.0))) }
    }

    #[inline(always)]
    unsafe fn marked_by<const MEMBER: usize>(self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let mark = _mm512_set1_epi32(Self::MARKS[MEMBER].cast_signed());
            u32::from(_mm512_test_epi32_mask(_mm512_castps_si512(self.0), mark))
        }
    }

    #[inline(always)]
    unsafe fn sift(self, ids: *const u32, lanes: u32, marks: *mut f32, to: *mut u32) {
        // SAFETY: the contract of `EstimateVector`.
        unsafe {
            let lanes = lanes as __mmask16;
            _mm512_storeu_ps(marks, _mm512_maskz_compress_ps(lanes, self.0));
            let ids = _mm512_maskz_compress_epi32(lanes, _mm512_loadu_si512(ids.cast()));
            _mm512_storeu_si512(to.cast(), ids);
        }
    }
}
