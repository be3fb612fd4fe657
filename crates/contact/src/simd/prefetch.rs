//! Hints that prefetch memory before it is used.

/// Prefetches memory some way behind `value`, for arrays that are read from beginning to end. Processors
/// prefetch on their own, but stop at the end of a page.
#[inline(always)]
pub(crate) fn read<V>(value: &V) {
    hint::<false>(std::ptr::from_ref(value).cast::<i8>().wrapping_add(READ_AHEAD));
}

/// Prefetches the memory behind `place` for writing. With hundreds of streams the processor cannot predict
/// it.
#[inline(always)]
pub(crate) fn write<V>(place: *mut V) {
    hint::<true>(place.cast::<i8>().wrapping_add(WRITE_AHEAD));
}

/// Prefetches the cache lines that hold `count` values from `values[from]` on; the last line may be left out.
#[inline(always)]
pub(crate) fn lines<V>(values: &[V], from: usize, count: usize) {
    let place = values.as_ptr().wrapping_add(from).cast::<i8>();
    for line in 0..(count * size_of::<V>()).div_ceil(LINE) {
        hint::<false>(place.wrapping_add(line * LINE));
    }
}

/// Prefetches a value that is read soon, from a place that the processor cannot guess.
#[inline(always)]
pub fn value<V>(value: &V) {
    lines(std::slice::from_ref(value), 0, 1);
    // It may begin within a cache line, and so end within one more.
    if (LINE - align_of::<V>().min(LINE) + size_of::<V>()).div_ceil(LINE) > size_of::<V>().div_ceil(LINE) {
        let last = size_of::<V>() - 1;
        hint::<false>(std::ptr::from_ref(value).cast::<i8>().wrapping_add(last));
    }
}

/// Size of a cache line in bytes.
const LINE: usize = 64;

/// Distance in bytes: a page.
const READ_AHEAD: usize = 4096;

/// Distance in bytes: two cache lines.
const WRITE_AHEAD: usize = 128;

#[inline(always)]
fn hint<const WRITE: bool>(place: *const i8) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_ET0, _MM_HINT_T0, _mm_prefetch};
        // SAFETY: this is a hint; it is without effect for memory that is not there, and on processors that
        // do not know it.
        unsafe {
            if WRITE { _mm_prefetch::<_MM_HINT_ET0>(place) } else { _mm_prefetch::<_MM_HINT_T0>(place) }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
