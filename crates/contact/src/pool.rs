//! Threads: tasks that do not depend on each other, on a pool or one after the other.

use crate::error::Error;

/// More threads than any machine has processors would be started for minutes, and then stand in each other's way.
#[cfg(feature = "rayon")]
const MAX_THREADS: usize = 4096;

/// A number of threads.
///
/// Whoever uses it splits work so that the result does not depend on the number; the pool decides who does what, and
/// nothing else.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pool {
    #[cfg(feature = "rayon")]
    pool: Option<std::sync::Arc<rayon::ThreadPool>>,
}

#[cfg_attr(
    not(feature = "rayon"),
    allow(clippy::unused_self, reason = "without rayon there is nothing in a pool")
)]
impl Pool {
    /// `threads` threads; 0 is one for each processor. One thread needs no pool.
    #[cfg(feature = "rayon")]
    pub(crate) fn new(threads: usize) -> Result<Self, Error> {
        if threads == 1 {
            return Ok(Self::default());
        }
        if threads > MAX_THREADS {
            return Err(Error::NoThreads { threads, reason: format!("more than {MAX_THREADS} is not of use") });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| Error::NoThreads { threads, reason: error.to_string() })?;
        Ok(Self { pool: Some(pool.into()) })
    }

    /// One thread: this build has no other.
    #[cfg(not(feature = "rayon"))]
    pub(crate) fn new(threads: usize) -> Result<Self, Error> {
        if threads <= 1 {
            return Ok(Self::default());
        }
        Err(Error::NoThreads { threads, reason: "built without the feature `rayon`".to_owned() })
    }

    pub(crate) fn threads(&self) -> usize {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            return pool.current_num_threads();
        }
        1
    }

    /// Runs `work` on each task, in any order and at the same time.
    pub(crate) fn run<I: Send>(&self, tasks: impl Iterator<Item = I>, work: impl Fn(I) + Sync + Send) {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
            let tasks: Vec<I> = tasks.collect();
            pool.install(|| tasks.into_par_iter().with_max_len(1).for_each(work));
            return;
        }
        tasks.for_each(work);
    }
}
