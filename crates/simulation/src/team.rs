//! Work on all threads, with results that do not depend on how many there are.
//!
//! Items are cut into chunks of a fixed size; what a chunk sums up is added in the order of the chunks.

use std::sync::Arc;

use rayon::prelude::*;

use crate::error::ModelError;

/// Items of a chunk: few enough to share out, enough to be worth a task.
const CHUNK: usize = 512;

/// Fewer items than this are not worth waking threads for.
const WORTH_IT: usize = 8 * CHUNK;

/// The threads of a simulation.
#[derive(Debug)]
pub(crate) struct Team {
    /// `None`: the caller's alone.
    pool: Option<Arc<rayon::ThreadPool>>,
}

impl Team {
    /// So many threads; 0: one for each processor.
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

    /// These threads, to be given long work as a whole: each piece of it then goes from one of them to the others, and no other thread has to be woken.
    pub(crate) fn pool(&self) -> Option<Arc<rayon::ThreadPool>> {
        self.pool.clone()
    }

    /// Has `work` done on chunks of `items`, given the number of the first; its results in the order of the chunks.
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

    /// The same on chunks of two lists of one length.
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

    /// The same on chunks of the numbers below `count`.
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
