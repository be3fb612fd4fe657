//! AVX2: 4 lanes of `f64`, 8 of `f32`.

use std::arch::x86_64::*;

use crate::couple::Couple;
use crate::simd::vector::{CLUSTER, EstimateVector, Vector};

entry_points!("avx2,fma,bmi2,popcnt", F64x4, F32x8);

/// For each mask of 8 lanes, the lanes that are set, in order: the operation that AVX-512 calls compress.
static COMPRESS: [[u8; 8]; 256] = compress([0, 1, 2, 3, 4, 5, 6, 7]);

/// The same in the order in which unpacking, which works within halves of 128 bits, makes couples.
static COMPRESS_TO_UNPACK: [[u8; 8]; 256] = compress([0, 1, 4, 5, 2, 3, 6, 7]);

/// The lanes that are set, each at the next of `places`.
const fn compress(places: [usize; 8]) -> [[u8; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][places[place]] = lane as u8;
                place += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
}

#[derive(Clone, Copy)]
struct F64x4(__m256d);

impl Vector<f64> for F64x4 {
    const LANES: usize = 4;

    one_instruction!(f64: _mm256_set1_pd, _mm256_loadu_pd, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd);

    #[inline(always)]
    unsafe fn store_short(self, to: *mut f32) {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm_storeu_ps(to, _mm256_cvtpd_ps(self.0)) }
    }

    #[inline(always)]
    unsafe fn at_most(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)).cast_unsigned() }
    }

    #[inline(always)]
    unsafe fn below(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)).cast_unsigned() }
    }

    #[inline(always)]
    unsafe fn equal(number: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let equal = _mm_cmpeq_epi32(_mm_loadu_si128(from.cast()), _mm_set1_epi32(number.cast_signed()));
            _mm_movemask_ps(_mm_castsi128_ps(equal)).cast_unsigned()
        }
    }

    #[inline(always)]
    unsafe fn overlap(bits: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let common = _mm_and_si128(_mm_loadu_si128(from.cast()), _mm_set1_epi32(bits.cast_signed()));
            let none = _mm_cmpeq_epi32(common, _mm_setzero_si128());
            _mm_movemask_ps(_mm_castsi128_ps(none)).cast_unsigned() ^ 0xf
        }
    }

    #[inline(always)]
    unsafe fn set(row: *const u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let groups = _mm_loadu_si128(from.cast());
            let words = _mm_i32gather_epi32::<4>(row.cast(), _mm_srli_epi32::<5>(groups));
            // Moves the bit of the group to the sign.
            let shifts = _mm_andnot_si128(groups, _mm_set1_epi32(31));
            let signs = _mm_sllv_epi32(words, shifts);
            _mm_movemask_ps(_mm_castsi128_ps(signs)).cast_unsigned()
        }
    }

    #[inline(always)]
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`; a couple is two u32, and four lanes have 16 masks, below 256.
        unsafe {
            let lanes = _mm_cvtepu8_epi32(_mm_loadl_epi64(COMPRESS.as_ptr().add(hits as usize).cast()));
            let ids =
                _mm_castps_si128(_mm_permutevar_ps(_mm_castsi128_ps(_mm_loadu_si128(ids.cast())), lanes));
            let id = _mm_set1_epi32(id.cast_signed());
            let (low, high) =
                if TWO_SETS { (id, ids) } else { (_mm_min_epu32(ids, id), _mm_max_epu32(ids, id)) };
            let to: *mut __m128i = to.cast();
            _mm_storeu_si128(to, _mm_unpacklo_epi32(low, high));
            _mm_storeu_si128(to.add(1), _mm_unpackhi_epi32(low, high));
        }
    }
}

#[derive(Clone, Copy)]
struct F32x8(__m256);

impl Vector<f32> for F32x8 {
    const LANES: usize = 8;

    one_instruction!(f32: _mm256_set1_ps, _mm256_loadu_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps);

    #[inline(always)]
    unsafe fn store_short(self, to: *mut f32) {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_storeu_ps(to, self.0) }
    }

    #[inline(always)]
    unsafe fn at_most(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)).cast_unsigned() }
    }

    #[inline(always)]
    unsafe fn below(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)).cast_unsigned() }
    }

    #[inline(always)]
    unsafe fn equal(number: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let equal =
                _mm256_cmpeq_epi32(_mm256_loadu_si256(from.cast()), _mm256_set1_epi32(number.cast_signed()));
            _mm256_movemask_ps(_mm256_castsi256_ps(equal)).cast_unsigned()
        }
    }

    #[inline(always)]
    unsafe fn overlap(bits: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let common =
                _mm256_and_si256(_mm256_loadu_si256(from.cast()), _mm256_set1_epi32(bits.cast_signed()));
            let none = _mm256_cmpeq_epi32(common, _mm256_setzero_si256());
            _mm256_movemask_ps(_mm256_castsi256_ps(none)).cast_unsigned() ^ 0xff
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
        // SAFETY: the contract of `Vector`; a couple is two u32, and eight lanes have 256 masks.
        unsafe {
            let lanes =
                _mm256_cvtepu8_epi32(_mm_loadl_epi64(COMPRESS_TO_UNPACK.as_ptr().add(hits as usize).cast()));
            let ids = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(ids.cast()), lanes);
            let id = _mm256_set1_epi32(id.cast_signed());
            let (low, high) =
                if TWO_SETS { (id, ids) } else { (_mm256_min_epu32(ids, id), _mm256_max_epu32(ids, id)) };
            let to: *mut __m256i = to.cast();
            _mm256_storeu_si256(to, _mm256_unpacklo_epi32(low, high));
            _mm256_storeu_si256(to.add(1), _mm256_unpackhi_epi32(low, high));
        }
    }
}

impl EstimateVector for F32x8 {
    const MARKS: [u32; CLUSTER] = [1 << 7, 1 << 15, 1 << 23, 1 << 31];

    #[inline(always)]
    unsafe fn mul_add(self, other: Self, sum: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        Self(unsafe { _mm256_fmadd_ps(self.0, other.0, sum.0) })
    }

    #[inline(always)]
    unsafe fn and(self, other: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        Self(unsafe { _mm256_and_ps(self.0, other.0) })
    }

    #[inline(always)]
    unsafe fn least(self, other: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let least = _mm256_min_epi32(_mm256_castps_si256(self.0), _mm256_castps_si256(other.0));
            Self(_mm256_castsi256_ps(least))
        }
    }

    #[inline(always)]
    unsafe fn is_within(self, width: f32) -> bool {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let beyond = _mm256_set1_epi32((-width).to_bits().cast_signed());
            let nearer = _mm256_cmpgt_epi32(beyond, _mm256_castps_si256(self.0));
            _mm256_testz_si256(nearer, nearer) == 0
        }
    }

    #[inline(always)]
    unsafe fn marks(vectors: [Self; CLUSTER]) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let [a, b, c, d] = vectors;
            let [a, b] = [_mm256_castps_si256(a.0), _mm256_castps_si256(b.0)];
            let [c, d] = [_mm256_castps_si256(c.0), _mm256_castps_si256(d.0)];
            // Packing keeps signs: in each half, four bytes of each vector, which are then put together lane
            // by lane.
            let bytes = _mm256_packs_epi16(_mm256_packs_epi32(a, b), _mm256_packs_epi32(c, d));
            let order = _mm256_setr_epi8(
                0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15, 0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14,
                3, 7, 11, 15,
            );
            Self(_mm256_castsi256_ps(_mm256_shuffle_epi8(bytes, order)))
        }
    }

    #[inline(always)]
    unsafe fn marked(self, of: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let marks = _mm256_castps_si256(_mm256_and_ps(self.0, of.0));
            let none = _mm256_cmpeq_epi32(marks, _mm256_setzero_si256());
            _mm256_movemask_ps(_mm256_castsi256_ps(none)).cast_unsigned() ^ 0xff
        }
    }

    #[inline(always)]
    unsafe fn marked_near(self, nearest: Self, _: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_movemask_ps(nearest.0).cast_unsigned() }
    }

    #[inline(always)]
    unsafe fn marked_by<const MEMBER: usize>(self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let marks = _mm256_castps_si256(self.0);
            // Moves the mark to the sign.
            let signs = match MEMBER {
                0 => _mm256_slli_epi32::<24>(marks),
                1 => _mm256_slli_epi32::<16>(marks),
                2 => _mm256_slli_epi32::<8>(marks),
                _ => marks,
            };
            _mm256_movemask_ps(_mm256_castsi256_ps(signs)).cast_unsigned()
        }
    }

    #[inline(always)]
    unsafe fn count_marks(self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { _mm256_movemask_epi8(_mm256_castps_si256(self.0)).count_ones() }
    }

    #[inline(always)]
    unsafe fn sift(self, ids: *const u32, lanes: u32, marks: *mut f32, to: *mut u32) {
        // SAFETY: the contract of `EstimateVector`; eight lanes have 256 masks.
        unsafe {
            let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(COMPRESS.as_ptr().add(lanes as usize).cast()));
            _mm256_storeu_ps(marks, _mm256_permutevar8x32_ps(self.0, order));
            let ids = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(ids.cast()), order);
            _mm256_storeu_si256(to.cast(), ids);
        }
    }
}
