//! A reserve of memory, so that the program can report that memory has run out.
//!
//! Large arrays are allocated in ways that may fail, and the failure is an error that names the file. The
//! message itself takes memory, and so do threads and lists that end after it: without a reserve the program
//! would abort instead if the large arrays had left none.

#![allow(unsafe_code, reason = "an allocator is unsafe by its trait; each call says why it is sound")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::UnsafeCell;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Size of the reserve, bytes.
const ROOM: usize = 1 << 20;

/// Largest block that the reserve gives, bytes. A larger one fails, and its failure is reported.
const LARGEST: usize = 1 << 16;

/// The allocator of the system. Where that fails, a small block comes from the reserve, to which it does not
/// return.
pub(crate) struct Reserve {
    room: UnsafeCell<[u8; ROOM]>,
    taken: AtomicUsize,
}

// SAFETY: a block of the room belongs to one caller alone, because `taken` only grows.
unsafe impl Sync for Reserve {}

impl Reserve {
    #[allow(clippy::large_stack_arrays, reason = "it is the value of a static")]
    pub(crate) const fn new() -> Self {
        Self { room: UnsafeCell::new([0; ROOM]), taken: AtomicUsize::new(0) }
    }

    /// A block of zeros of the reserve; null if it is too large.
    fn take(&self, layout: Layout) -> *mut u8 {
        let first = self.room.get().cast::<u8>();
        let start = |taken: usize| (first as usize + taken).next_multiple_of(layout.align()) - first as usize;
        let end = |taken: usize| {
            let end = start(taken).checked_add(layout.size())?;
            (layout.size() <= LARGEST && end <= ROOM).then_some(end)
        };
        match self.taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, end) {
            Ok(taken) => first.wrapping_add(start(taken)),
            Err(_) => null_mut(),
        }
    }

    fn has(&self, block: *mut u8) -> bool {
        (block as usize).wrapping_sub(self.room.get() as usize) < ROOM
    }
}

// SAFETY: blocks come from the system, or are parts of the room that nobody else has, of the requested size
// and alignment.
unsafe impl GlobalAlloc for Reserve {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        let block = unsafe { System.alloc(layout) };
        if block.is_null() { self.take(layout) } else { block }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise.
        let block = unsafe { System.alloc_zeroed(layout) };
        if block.is_null() { self.take(layout) } else { block }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        if !self.has(block) {
            // SAFETY: the block is not of the room, so it is of the system, with this layout.
            unsafe { System.dealloc(block, layout) }
        }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !self.has(block) {
            // SAFETY: the block is of the system; the rest is the caller's promise.
            let new = unsafe { System.realloc(block, layout, size) };
            if !new.is_null() {
                return new;
            }
        }
        // SAFETY: the caller promises that the size is not zero and not too large for the alignment.
        let new = unsafe { self.alloc(Layout::from_size_align_unchecked(size, layout.align())) };
        if !new.is_null() {
            // SAFETY: both blocks are at least this long, and they are different; the old one is the
            // caller's, who does not use it any more.
            unsafe {
                new.copy_from_nonoverlapping(block, layout.size().min(size));
                self.dealloc(block, layout);
            }
        }
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reserve_gives_small_blocks_apart_and_aligned_until_it_is_empty() {
        static RESERVE: Reserve = Reserve::new();
        let blocks = || RESERVE.take(Layout::from_size_align(1000, 64).unwrap());
        let blocks: Vec<usize> = std::iter::repeat_with(blocks)
            .take_while(|block| !block.is_null())
            .map(|block| block as usize)
            .collect();
        assert!((1000..=1024).contains(&blocks.len()), "{}", blocks.len());
        assert!(blocks.windows(2).all(|pair| pair[0] + 1000 <= pair[1] && pair[1] % 64 == 0));
        assert!(blocks.iter().all(|&block| RESERVE.has(block as *mut u8)));
        assert!(RESERVE.take(Layout::new::<[u8; LARGEST + 1]>()).is_null());
    }

    #[test]
    fn a_block_of_the_reserve_grows_and_returns() {
        static RESERVE: Reserve = Reserve::new();
        let layout = Layout::new::<[u8; 3]>();
        let block = RESERVE.take(layout);
        // SAFETY: the blocks have these sizes, and are used until they are given back.
        unsafe {
            block.copy_from_nonoverlapping([1, 2, 3].as_ptr(), 3);
            let grown = RESERVE.realloc(block, layout, 5);
            assert!(!RESERVE.has(grown));
            assert_eq!(std::slice::from_raw_parts(grown, 3), [1, 2, 3]);
            RESERVE.dealloc(grown, Layout::new::<[u8; 5]>());
        }
    }
}
