//! Writing to one array from several threads, each thread to its own places.

#![allow(unsafe_code, reason = "the compiler cannot see that the threads write to different places")]

use std::marker::PhantomData;

use crate::simd::prefetch;

/// An array that several threads fill at once.
#[derive(Clone, Copy)]
pub(crate) struct Scatter<'a, V> {
    start: *mut V,
    len: usize,
    array: PhantomData<&'a mut [V]>,
}

// SAFETY: this represents a mutable borrow of the array, which may be sent where `V` may. Its one method
// writes, to places that no other thread uses at the same time, by the contract of that method.
unsafe impl<V: Send> Send for Scatter<'_, V> {}
// SAFETY: as above: only the borrow is shared, and each entry is written by one thread.
unsafe impl<V: Send> Sync for Scatter<'_, V> {}

impl<'a, V: Copy> Scatter<'a, V> {
    pub(crate) fn new(array: &'a mut [V]) -> Self {
        Self { start: array.as_mut_ptr(), len: array.len(), array: PhantomData }
    }

    /// Writes one entry.
    ///
    /// # Safety
    /// No other thread writes the same place while the array is borrowed by this.
    ///
    /// # Panics
    /// If `place` is behind the end of the array.
    #[inline]
    pub(crate) unsafe fn write(self, place: usize, value: V) {
        assert!(place < self.len);
        // SAFETY: the place is inside the array, and no other thread writes it by the contract of this
        // function.
        unsafe { self.start.add(place).write(value) };
        prefetch::write(self.start.wrapping_add(place));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_threads_fill_one_array() {
        let mut array = vec![0; 1000];
        let scatter = Scatter::new(&mut array);
        std::thread::scope(|scope| {
            for thread in 0..2 {
                scope.spawn(move || {
                    for place in (thread..1000).step_by(2) {
                        // SAFETY: one thread writes to even places, the other to odd ones, all below the
                        // array's length.
                        unsafe { scatter.write(place, place + 1) };
                    }
                });
            }
        });
        assert!(array.iter().enumerate().all(|(place, &value)| value == place + 1));
    }

    #[test]
    #[should_panic(expected = "place < self.len")]
    fn behind_the_end_is_a_panic() {
        // SAFETY: there is one thread.
        unsafe { Scatter::new(&mut [0; 3]).write(3, 1) };
    }
}
