//! Work on parts of a fixed length, on several threads.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Number of couples or elements of a part: enough that a thread is worth its start.
const PART: usize = 1 << 15;

/// Threads that share work, and a counter of the couples and elements handled.
#[derive(Clone, Debug)]
pub(crate) struct Team<'a> {
    /// `None` if the thread of the caller does all work.
    pool: Option<Arc<ThreadPool>>,
    handled: &'a AtomicU64,
}

impl<'a> Team<'a> {
    /// A team of `threads` threads; 0 is one per processor. If the system has no more threads, the work takes
    /// longer. `handled` counts couples and elements, those of each pass.
    pub(crate) fn new(threads: usize, handled: &'a AtomicU64) -> Self {
        let pool = (threads != 1).then(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.thread_name(|k| format!("analysis-{k}")).build().ok().map(Arc::new)
        });
        Self { pool: pool.flatten(), handled }
    }

    pub(crate) fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Adds to the number of couples and elements that were handled.
    pub(crate) fn count(&self, handled: usize) {
        self.handled.fetch_add(handled as u64, Ordering::Relaxed);
    }

    /// Does two works, at the same time if there are threads.
    pub(crate) fn both<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match &self.pool {
            Some(pool) => pool.join(one, other),
            None => (one(), other()),
        }
    }

    /// Calls `work` with each part of `0..count` and returns the results in the order of the parts.
    ///
    /// The parts do not depend on the number of threads, so neither does a sum over the results in their
    /// order.
    pub(crate) fn parts<S: Send>(&self, count: usize, work: impl Fn(Range<usize>) -> S + Sync) -> Vec<S> {
        self.parts_of(PART, count, work)
    }

    /// [`Self::parts`] of up to `length`.
    pub(crate) fn parts_of<S: Send>(
        &self,
        length: usize,
        count: usize,
        work: impl Fn(Range<usize>) -> S + Sync,
    ) -> Vec<S> {
        let part = |number: usize| {
            let range = number * length..count.min((number + 1) * length);
            let handled = range.len();
            let result = work(range);
            self.count(handled);
            result
        };
        let parts = 0..count.div_ceil(length);
        match &self.pool {
            Some(pool) => pool.install(|| parts.into_par_iter().map(part).collect()),
            None => parts.map(part).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_works_are_done() {
        let handled = AtomicU64::new(0);
        for threads in [1, 2] {
            assert_eq!(Team::new(threads, &handled).both(|| 1, || "two"), (1, "two"));
        }
    }

    #[test]
    fn parts_do_not_depend_on_threads() {
        let handled = AtomicU64::new(0);
        for count in [0, 1, PART - 1, PART, PART + 1, 10 * PART + 3] {
            let one = Team::new(1, &handled).parts(count, |range| range);
            for threads in [2, 7] {
                assert_eq!(Team::new(threads, &handled).parts(count, |range| range), one);
            }
            assert_eq!(one.into_iter().flatten().collect::<Vec<_>>(), (0..count).collect::<Vec<_>>());
        }
        assert_eq!(handled.into_inner(), 3 * (13 * PART as u64 + 4));
    }
}
