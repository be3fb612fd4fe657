//! Asking for memory before it is used.

/// Asks for what comes some way behind `value` in memory that is read from its beginning to its end: processors look ahead by themselves, but stop at the
/// end of a page.
#[inline(always)]
pub(crate) fn read<V>(value: &V) {
    hint::<false>(std::ptr::from_ref(value).cast::<i8>().wrapping_add(READ_AHEAD));
}

/// Asks for the memory behind `place`, which will be written: with hundreds of streams the processor does not foresee it.
#[inline(always)]
pub(crate) fn write<V>(place: *mut V) {
    hint::<true>(place.cast::<i8>().wrapping_add(WRITE_AHEAD));
}

/// Asks for the cache lines that hold `count` values from `values[from]` on, of which the last may be left out.
#[inline(always)]
pub(crate) fn lines<V>(values: &[V], from: usize, count: usize) {
    let place = values.as_ptr().wrapping_add(from).cast::<i8>();
    for line in 0..(count * size_of::<V>()).div_ceil(LINE) {
        hint::<false>(place.wrapping_add(line * LINE));
    }
}

/// Bytes of a cache line.
const LINE: usize = 64;

/// Bytes, half a page.
const READ_AHEAD: usize = 2048;

/// Bytes, two cache lines.
const WRITE_AHEAD: usize = 128;

#[inline(always)]
fn hint<const WRITE: bool>(place: *const i8) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_ET0, _MM_HINT_T0, _mm_prefetch};
        // SAFETY: this is a hint; it is without effect for memory that is not there, and on processors that do not know it.
        unsafe {
            if WRITE { _mm_prefetch::<_MM_HINT_ET0>(place) } else { _mm_prefetch::<_MM_HINT_T0>(place) }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}
