//! A set of numbers as bits, which threads change side by side.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

const BITS: usize = 64;

/// A set of numbers below a bound. It is the same in whatever order threads change it, as long as each number
/// is changed by one of them.
#[derive(Debug, Default)]
pub(crate) struct Marks(Vec<AtomicU64>);

impl Marks {
    /// An empty set of numbers below `count`.
    pub(crate) fn new(count: usize) -> Self {
        let mut words = Vec::new();
        words.resize_with(count.div_ceil(BITS), AtomicU64::default);
        Self(words)
    }

    pub(crate) fn add(&self, number: u32) {
        self.0[number as usize / BITS].fetch_or(1 << (number as usize % BITS), Ordering::Relaxed);
    }

    pub(crate) fn remove(&self, number: u32) {
        self.0[number as usize / BITS].fetch_and(!(1 << (number as usize % BITS)), Ordering::Relaxed);
    }

    /// Calls `each` for the numbers of a range that are in the set, in ascending order.
    #[inline]
    pub(crate) fn within(&self, range: Range<u32>, mut each: impl FnMut(u32)) {
        let (mut begin, end) = (range.start as usize, range.end as usize);
        while begin < end {
            let word = begin / BITS;
            let behind = (end - word * BITS).min(BITS);
            let mut bits = self.0[word].load(Ordering::Relaxed) >> (begin % BITS) << (begin % BITS);
            bits &= u64::MAX >> (BITS - behind);
            while bits != 0 {
                each((word * BITS) as u32 + bits.trailing_zeros());
                bits &= bits - 1;
            }
            begin = (word + 1) * BITS;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(marks: &Marks, range: Range<u32>) -> Vec<u32> {
        let mut numbers = Vec::new();
        marks.within(range, |number| numbers.push(number));
        numbers
    }

    #[test]
    fn numbers_of_a_range_are_found_across_words() {
        let marks = Marks::new(200);
        for number in [0, 3, 63, 64, 127, 128, 199] {
            marks.add(number);
        }
        assert_eq!(found(&marks, 0..200), [0, 3, 63, 64, 127, 128, 199]);
        assert_eq!(found(&marks, 1..64), [3, 63]);
        assert_eq!(found(&marks, 63..129), [63, 64, 127, 128]);
        assert_eq!(found(&marks, 64..64), []);
        assert_eq!(found(&marks, 65..127), []);
        marks.remove(64);
        marks.remove(0);
        assert_eq!(found(&marks, 0..128), [3, 63, 127]);
    }
}
