//! Work on all threads, with results that do not depend on the number of threads.
//!
//! Items are divided into chunks of a fixed size. The sums of the chunks are added in their order.

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::ModelError;

/// Number of items in a chunk: so few that all threads get some, so many that a task is worth its cost.
pub(crate) const CHUNK: usize = 512;

/// Number of items below which one thread does the work.
const WORTH_IT: usize = 8 * CHUNK;

/// The threads of a simulation.
#[derive(Debug)]
pub(crate) struct Team {
    /// `None` if the thread of the caller does all work.
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Team {
    /// A team of so many threads; 0 for one on each processor.
    pub(crate) fn new(threads: usize) -> Result<Self, ModelError> {
        if threads == 1 {
            return Ok(Self { pool: None });
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

    /// The pool of these threads. Long work is given to it as a whole, so that no thread from outside has to be woken for each piece. The search for
    /// contacts works on it too.
    pub(crate) fn pool(&self) -> Option<Arc<rayon::ThreadPool>> {
        self.pool.clone()
    }

    /// Calls `work` on chunks of `items`, with the number of the first item. Returns the results in the order of the chunks.
    pub(crate) fn change<T: Send, R: Send>(
        &self,
        items: &mut [T],
        work: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> Vec<R> {
        match &self.pool {
            Some(pool) if items.len() >= WORTH_IT => pool.install(|| {
                items.par_chunks_mut(CHUNK).enumerate().map(|(k, chunk)| work(k * CHUNK, chunk)).collect()
            }),
            _ => items.chunks_mut(CHUNK).enumerate().map(|(k, chunk)| work(k * CHUNK, chunk)).collect(),
        }
    }

    /// Calls `work` on chunks of two lists of the same length, likewise.
    pub(crate) fn change_both<A: Send, B: Send, R: Send>(
        &self,
        first: &mut [A],
        second: &mut [B],
        work: impl Fn(usize, &mut [A], &mut [B]) -> R + Sync,
    ) -> Vec<R> {
        match &self.pool {
            Some(pool) if first.len() >= WORTH_IT => pool.install(|| {
                let pairs = first.par_chunks_mut(CHUNK).zip(second.par_chunks_mut(CHUNK));
                pairs.enumerate().map(|(k, (a, b))| work(k * CHUNK, a, b)).collect()
            }),
            _ => {
                let pairs = first.chunks_mut(CHUNK).zip(second.chunks_mut(CHUNK));
                pairs.enumerate().map(|(k, (a, b))| work(k * CHUNK, a, b)).collect()
            }
        }
    }

    /// Calls `work` on chunks of `items`, each with its own of two other lists.
    pub(crate) fn change_chunks<T: Send, A: Send, B: Send>(
        &self,
        items: &mut [T],
        first: &mut [A],
        second: &mut [B],
        work: impl Fn(&mut [T], &mut A, &mut B) + Sync,
    ) {
        match &self.pool {
            Some(pool) if items.len() >= WORTH_IT => pool.install(|| {
                let chunks = items.par_chunks_mut(CHUNK).zip(first).zip(second);
                chunks.for_each(|((items, a), b)| work(items, a, b));
            }),
            _ => {
                let chunks = items.chunks_mut(CHUNK).zip(first).zip(second);
                chunks.for_each(|((items, a), b)| work(items, a, b));
            }
        }
    }

    /// Calls `work` on chunks of a list of batches of `LANES` items, of the items themselves, and of another list of batches, likewise. The third list may be empty;
    /// then its chunks are.
    pub(crate) fn change_batches<const LANES: usize, A: Send, B: Send, C: Send, R: Send>(
        &self,
        batches: &mut [A],
        items: &mut [B],
        more: &mut [C],
        work: impl Fn(usize, &mut [A], &mut [B], &mut [C]) -> R + Sync,
    ) -> Vec<R> {
        let size = const { CHUNK / LANES };
        let parallel = items.len() >= WORTH_IT;
        let more = more.chunks_mut(size).chain(std::iter::repeat_with(|| &mut [][..]));
        let chunks = batches.chunks_mut(size).zip(items.chunks_mut(CHUNK)).zip(more).enumerate();
        match &self.pool {
            Some(pool) if parallel => {
                let chunks: Vec<_> = chunks.collect();
                pool.install(|| {
                    chunks.into_par_iter().map(|(k, ((a, b), c))| work(k * size, a, b, c)).collect()
                })
            }
            _ => chunks.map(|(k, ((a, b), c))| work(k * size, a, b, c)).collect(),
        }
    }

    /// Calls `work` on chunks of the numbers below `count`, likewise.
    pub(crate) fn look<R: Send>(
        &self,
        count: usize,
        work: impl Fn(std::ops::Range<usize>) -> R + Sync,
    ) -> Vec<R> {
        let chunks = count.div_ceil(CHUNK);
        let range = |k: usize| k * CHUNK..((k + 1) * CHUNK).min(count);
        match &self.pool {
            Some(pool) if count >= WORTH_IT => {
                pool.install(|| (0..chunks).into_par_iter().map(|k| work(range(k))).collect())
            }
            _ => (0..chunks).map(|k| work(range(k))).collect(),
        }
    }
}
