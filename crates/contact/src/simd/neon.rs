//! NEON: 2 lanes of `f64`, 4 of `f32`.

use std::arch::aarch64::*;

use crate::couple::Couple;
use crate::simd::vector::{CLUSTER, EstimateVector, Vector};

entry_points!("neon", F64x2, F32x4);

/// Stores the couples whose bit is set one by one; there is no compress, and few lanes.
///
/// # Safety
/// `LANES` numbers can be read from `ids` on, and `LANES` couples written from `to` on.
#[inline(always)]
unsafe fn store<const LANES: usize, const TWO_SETS: bool>(
    id: u32,
    ids: *const u32,
    hits: u32,
    to: *mut Couple,
) {
    let mut place = 0;
    for lane in 0..LANES {
        // SAFETY: `place <= lane < LANES`.
        unsafe {
            let other = *ids.add(lane);
            let (i, j) = if TWO_SETS { (id, other) } else { (id.min(other), id.max(other)) };
            // A couple that is no hit is overwritten by the next, or not counted.
            *to.add(place) = Couple { i, j };
        }
        place += (hits >> lane & 1) as usize;
    }
}

/// Looks the words up one by one; there is no gather.
///
/// # Safety
/// The conditions of [`Vector::set`].
#[inline(always)]
unsafe fn set<const LANES: usize>(row: *const u32, from: *const u32) -> u32 {
    let mut bits = 0;
    for lane in 0..LANES {
        // SAFETY: the contract of this function.
        unsafe {
            let group = *from.add(lane);
            bits |= (*row.add(group as usize / 32) >> (group % 32) & 1) << lane;
        }
    }
    bits
}

#[derive(Clone, Copy)]
struct F64x2(float64x2_t);

impl F64x2 {
    /// A bit for each lane that is all ones.
    ///
    /// # Safety
    /// The processor has the instructions.
    #[inline(always)]
    unsafe fn bits(lanes: uint64x2_t) -> u32 {
        // SAFETY: the contract of this function.
        unsafe { (vgetq_lane_u64::<0>(lanes) & 1 | vgetq_lane_u64::<1>(lanes) & 2) as u32 }
    }
}

impl Vector<f64> for F64x2 {
    const LANES: usize = 2;

    one_instruction!(f64: vdupq_n_f64, vld1q_f64, vaddq_f64, vsubq_f64, vmulq_f64);

    #[inline(always)]
    unsafe fn store_short(self, to: *mut f32) {
        // SAFETY: the contract of `Vector`.
        unsafe { vst1_f32(to, vcvt_f32_f64(self.0)) }
    }

    #[inline(always)]
    unsafe fn at_most(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vcleq_f64(self.0, other.0)) }
    }

    #[inline(always)]
    unsafe fn below(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vcltq_f64(self.0, other.0)) }
    }

    #[inline(always)]
    unsafe fn equal(number: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vmovl_u32(vceq_u32(vld1_u32(from), vdup_n_u32(number)))) }
    }

    #[inline(always)]
    unsafe fn overlap(bits: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vmovl_u32(vtst_u32(vld1_u32(from), vdup_n_u32(bits)))) }
    }

    #[inline(always)]
    unsafe fn set(row: *const u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { set::<2>(row, from) }
    }

    #[inline(always)]
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`.
        unsafe { store::<2, TWO_SETS>(id, ids, hits, to) }
    }
}

#[derive(Clone, Copy)]
struct F32x4(float32x4_t);

impl F32x4 {
    /// A bit for each lane that is all ones.
    ///
    /// # Safety
    /// The processor has the instructions.
    #[inline(always)]
    unsafe fn bits(lanes: uint32x4_t) -> u32 {
        const BIT_OF_LANE: [u32; 4] = [1, 2, 4, 8];
        // SAFETY: the contract of this function, and four lanes are loaded from four numbers.
        unsafe { vaddvq_u32(vandq_u32(lanes, vld1q_u32(BIT_OF_LANE.as_ptr()))) }
    }
}

impl Vector<f32> for F32x4 {
    const LANES: usize = 4;

    one_instruction!(f32: vdupq_n_f32, vld1q_f32, vaddq_f32, vsubq_f32, vmulq_f32);

    #[inline(always)]
    unsafe fn store_short(self, to: *mut f32) {
        // SAFETY: the contract of `Vector`.
        unsafe { vst1q_f32(to, self.0) }
    }

    #[inline(always)]
    unsafe fn at_most(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vcleq_f32(self.0, other.0)) }
    }

    #[inline(always)]
    unsafe fn below(self, other: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vcltq_f32(self.0, other.0)) }
    }

    #[inline(always)]
    unsafe fn equal(number: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vceqq_u32(vld1q_u32(from), vdupq_n_u32(number))) }
    }

    #[inline(always)]
    unsafe fn overlap(bits: u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vtstq_u32(vld1q_u32(from), vdupq_n_u32(bits))) }
    }

    #[inline(always)]
    unsafe fn set(row: *const u32, from: *const u32) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { set::<4>(row, from) }
    }

    #[inline(always)]
    unsafe fn store_couples<const TWO_SETS: bool>(id: u32, ids: *const u32, hits: u32, to: *mut Couple) {
        // SAFETY: the contract of `Vector`.
        unsafe { store::<4, TWO_SETS>(id, ids, hits, to) }
    }
}

impl EstimateVector for F32x4 {
    const MARKS: [u32; CLUSTER] = [1 << 31, 1 << 30, 1 << 29, 1 << 28];

    #[inline(always)]
    unsafe fn mul_add(self, other: Self, sum: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        Self(unsafe { vfmaq_f32(sum.0, self.0, other.0) })
    }

    #[inline(always)]
    unsafe fn and(self, other: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let both = vandq_u32(vreinterpretq_u32_f32(self.0), vreinterpretq_u32_f32(other.0));
            Self(vreinterpretq_f32_u32(both))
        }
    }

    #[inline(always)]
    unsafe fn least(self, other: Self) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let least = vminq_s32(vreinterpretq_s32_f32(self.0), vreinterpretq_s32_f32(other.0));
            Self(vreinterpretq_f32_s32(least))
        }
    }

    #[inline(always)]
    unsafe fn is_within(self, width: f32) -> bool {
        // SAFETY: the contract of `Vector`.
        unsafe { vminvq_s32(vreinterpretq_s32_f32(self.0)) < (-width).to_bits().cast_signed() }
    }

    #[inline(always)]
    unsafe fn marks(vectors: [Self; CLUSTER]) -> Self {
        // SAFETY: the contract of `Vector`.
        unsafe {
            let [a, b, c, d] = vectors;
            let [a, b] = [vreinterpretq_u32_f32(a.0), vreinterpretq_u32_f32(b.0)];
            let [c, d] = [vreinterpretq_u32_f32(c.0), vreinterpretq_u32_f32(d.0)];
            // Each keeps its highest bit and takes those of the next below it.
            let marks = vsriq_n_u32::<1>(a, vsriq_n_u32::<1>(b, vsriq_n_u32::<1>(c, d)));
            Self(vreinterpretq_f32_u32(marks))
        }
    }

    #[inline(always)]
    unsafe fn marked(self, of: Self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vtstq_u32(vreinterpretq_u32_f32(self.0), vreinterpretq_u32_f32(of.0))) }
    }

    #[inline(always)]
    unsafe fn marked_by<const MEMBER: usize>(self) -> u32 {
        // SAFETY: the contract of `Vector`.
        unsafe { Self::bits(vtstq_u32(vreinterpretq_u32_f32(self.0), vdupq_n_u32(Self::MARKS[MEMBER]))) }
    }

    #[inline(always)]
    unsafe fn sift(self, ids: *const u32, lanes: u32, marks: *mut f32, to: *mut u32) {
        let mut numbers = [0.0; 4];
        // SAFETY: the contract of `EstimateVector`; `place` stays below `LANES`.
        unsafe {
            vst1q_f32(numbers.as_mut_ptr(), self.0);
            let mut place = 0;
            for (lane, &number) in numbers.iter().enumerate() {
                // Unmarked elements are overwritten by the next, or not counted.
                *marks.add(place) = number;
                *to.add(place) = *ids.add(lane);
                place += (lanes >> lane & 1) as usize;
            }
        }
    }
}
