//! Work on all threads, with results that do not depend on the number of threads.
//!
//! Items are divided into chunks of a fixed size. The sums of the chunks are added in their order.

use std::sync::{Arc, Mutex};

use fdem_contact::keep_awake;
use rayon::prelude::*;

use crate::error::ModelError;

/// Number of items in a chunk: small enough that all threads get some, large enough that a task is worth its
/// cost.
pub(crate) const CHUNK: usize = 512;

/// Number of items below which one thread does the work. A pass takes about 1 µs more on several threads.
const WORTH_IT: usize = 2 * CHUNK;

/// The threads of a simulation.
#[derive(Clone, Debug)]
pub(crate) struct Team {
    /// `None` if the thread of the caller does all work.
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Team {
    /// The thread of the caller.
    pub(crate) const ALONE: Self = Self { pool: None };

    /// A team of the given number of threads; 0 for one on each processor.
    pub(crate) fn new(threads: usize) -> Result<Self, ModelError> {
        if threads == 1 {
            return Ok(Self::ALONE);
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|k| format!("fdem-{k}"))
            .build()
            .map_err(|error| ModelError::Threads { message: error.to_string() })?;
        Ok(Self { pool: (pool.current_num_threads() > 1).then(|| Arc::new(pool)) })
    }

    pub(crate) fn threads(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Calls `work` on a thread of the team, and keeps the others awake until it ends: most passes of a step
    /// are shorter than it takes to wake a thread.
    pub(crate) fn keep_awake<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => keep_awake(pool, work),
            None => work(),
        }
    }

    /// The pool of these threads. The search for contacts works on it too.
    pub(crate) fn pool(&self) -> Option<Arc<rayon::ThreadPool>> {
        self.pool.clone()
    }

    /// Calls both, at the same time if there is more than one thread.
    pub(crate) fn both<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match &self.pool {
            Some(pool) => pool.install(|| rayon::join(one, other)),
            None => (one(), other()),
        }
    }

    /// Calls `work` on chunks of a list of batches of `LANES` items, with the number of the first batch.
    /// Returns the results in the order of the chunks.
    pub(crate) fn change_lanes<const LANES: usize, T: Send, R: Send>(
        &self,
        batches: &mut [T],
        work: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> Vec<R> {
        let size = const { CHUNK / LANES };
        let count = LANES * batches.len();
        self.each(count, batches.chunks_mut(size), &|k, chunk| work(k * size, chunk))
    }

    /// Calls `work` on chunks of two lists of the same length, in the same way.
    pub(crate) fn change_both<A: Send, B: Send, R: Send>(
        &self,
        first: &mut [A],
        second: &mut [B],
        work: impl Fn(usize, &mut [A], &mut [B]) -> R + Sync,
    ) -> Vec<R> {
        let count = first.len();
        let pairs = first.chunks_mut(CHUNK).zip(second.chunks_mut(CHUNK));
        self.each(count, pairs, &|k, (a, b)| work(k * CHUNK, a, b))
    }

    /// Calls `work` on chunks of `items`, each with its own of two other lists.
    pub(crate) fn change_chunks<T: Send, A: Send, B: Send>(
        &self,
        items: &mut [T],
        first: &mut [A],
        second: &mut [B],
        work: impl Fn(&mut [T], &mut A, &mut B) + Sync,
    ) {
        let count = items.len();
        let chunks = items.chunks_mut(CHUNK).zip(first).zip(second);
        self.each(count, chunks, &|_, ((items, a), b)| work(items, a, b));
    }

    /// Calls `work` on chunks of a list of batches of `LANES` items, of the items themselves, and of another
    /// list of batches, in the same way. The third list may be empty; then its chunks are.
    pub(crate) fn change_batches<const LANES: usize, A: Send, B: Send, C: Send, R: Send>(
        &self,
        batches: &mut [A],
        items: &mut [B],
        more: &mut [C],
        work: impl Fn(usize, &mut [A], &mut [B], &mut [C]) -> R + Sync,
    ) -> Vec<R> {
        let size = const { CHUNK / LANES };
        let count = items.len();
        let more = more.chunks_mut(size).chain(std::iter::repeat_with(|| &mut [][..]));
        let chunks = batches.chunks_mut(size).zip(items.chunks_mut(CHUNK)).zip(more);
        self.each(count, chunks, &|k, ((a, b), c)| work(k * size, a, b, c))
    }

    /// Calls `work` on chunks of the numbers below `count`, in the same way.
    pub(crate) fn look<R: Send>(
        &self,
        count: usize,
        work: impl Fn(std::ops::Range<usize>) -> R + Sync,
    ) -> Vec<R> {
        let chunks = 0..count.div_ceil(CHUNK);
        self.each(count, chunks, &|k, _| work(k * CHUNK..((k + 1) * CHUNK).min(count)))
    }

    /// Calls `work` on chunks of the numbers below `count`, and joins the lists that it returns.
    pub(crate) fn list<R: Send>(
        &self,
        count: usize,
        work: impl Fn(std::ops::Range<usize>) -> Vec<R> + Sync,
    ) -> Vec<R> {
        let mut lists = self.look(count, work);
        if lists.len() == 1 {
            return lists.remove(0);
        }
        let mut all = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        for list in lists {
            all.extend(list);
        }
        all
    }

    /// Sorts numbers.
    pub(crate) fn sort(&self, numbers: &mut [u32]) {
        match self.pool.as_deref().filter(|_| numbers.len() >= WORTH_IT) {
            Some(pool) => pool.install(|| numbers.par_sort_unstable()),
            None => numbers.sort_unstable(),
        }
    }

    /// Calls `work` on chunks, which have `count` items together, with their numbers. Returns the results in
    /// the order of the chunks.
    ///
    /// `work` is behind a pointer, so that it is compiled once for one thread and many, and the code that
    /// shares it among threads once for all work.
    fn each<C: Send, R: Send>(
        &self,
        count: usize,
        chunks: impl Iterator<Item = C>,
        work: &(dyn Fn(usize, C) -> R + Sync),
    ) -> Vec<R> {
        let Some(pool) = self.pool.as_deref().filter(|_| count >= WORTH_IT) else {
            return chunks.enumerate().map(|(k, chunk)| work(k, chunk)).collect();
        };
        let slots: Vec<_> = chunks.map(|chunk| Mutex::new(Slot::Waits(chunk))).collect();
        share(pool, slots.len(), &|k| {
            let take = || std::mem::replace(&mut *slots[k].lock().expect(ALONE), Slot::Taken);
            if let Slot::Waits(chunk) = take() {
                let result = work(k, chunk);
                *slots[k].lock().expect(ALONE) = Slot::Done(result);
            }
        });
        let results = slots.into_iter().filter_map(|slot| match slot.into_inner().expect(ALONE) {
            Slot::Done(result) => Some(result),
            Slot::Waits(_) | Slot::Taken => None,
        });
        results.collect()
    }
}

/// A chunk, then the result of its work.
enum Slot<C, R> {
    Waits(C),
    Taken,
    Done(R),
}

/// No work is done while a slot is locked.
const ALONE: &str = "nothing panics while a slot is locked";

/// Calls `work` for each number below `count` on the threads of the pool.
fn share(pool: &rayon::ThreadPool, count: usize, work: &(dyn Fn(usize) + Sync)) {
    pool.install(|| (0..count).into_par_iter().for_each(work));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All threads take part while the team is kept awake, with work within work, and again after a panic.
    #[test]
    fn a_team_that_is_kept_awake_does_all_work_and_ends() {
        for threads in [1, 2, 5] {
            let team = Team::new(threads).expect("threads can be started");
            for _ in 0..20 {
                let sums = team.keep_awake(|| {
                    let (low, high) = team.both(
                        || team.look(10 * CHUNK, Iterator::sum::<usize>),
                        || team.look(20 * CHUNK, Iterator::sum::<usize>),
                    );
                    [low.len(), high.len(), low.iter().sum(), high.iter().sum()]
                });
                let whole = |chunks: usize| (0..chunks * CHUNK).sum::<usize>();
                assert_eq!(sums, [10, 20, whole(10), whole(20)]);
            }
            let panics = std::panic::AssertUnwindSafe(|| team.keep_awake(|| panic!("on purpose")));
            assert!(std::panic::catch_unwind(panics).is_err());
            assert_eq!(team.keep_awake(|| team.threads()), threads);
        }
    }
}
