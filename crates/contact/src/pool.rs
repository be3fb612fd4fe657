//! Threads: tasks that do not depend on each other, on a pool or one after the other.

#[cfg(feature = "rayon")]
use std::sync::Mutex;

use crate::error::Error;

/// More threads than any machine has processors would be started for minutes, and then stand in each other's way.
#[cfg(feature = "rayon")]
const MAX_THREADS: usize = 1024;

/// A number of threads.
///
/// Whoever uses it splits work so that the result does not depend on the number; the pool decides who does what, and
/// nothing else.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pool {
    /// All threads but the caller's, which works too: one that waits and one that is woken may be given the same processor, and the other one
    /// stands idle for some milliseconds.
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
        let threads = match threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            _ => threads,
        };
        if threads == 1 {
            return Ok(Self::default());
        }
        if threads > MAX_THREADS {
            return Err(Error::NoThreads {
                threads,
                reason: format!("more than {MAX_THREADS} is not of use"),
            });
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads - 1).build();
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
            return pool.current_num_threads() + 1;
        }
        1
    }

    /// Runs `work` on each task, in any order and at the same time.
    pub(crate) fn run<I: Send>(&self, tasks: impl Iterator<Item = I>, work: impl Fn(I) + Sync + Send) {
        #[cfg(feature = "rayon")]
        if let Some(pool) = &self.pool {
            let tasks: Vec<I> = tasks.collect();
            let others = pool.current_num_threads().min(tasks.len().saturating_sub(1));
            let tasks = Mutex::new(tasks.into_iter());
            let next = || tasks.lock().ok().and_then(|mut tasks| tasks.next());
            let take_all = || std::iter::from_fn(next).for_each(&work);
            pool.in_place_scope(|scope| {
                (0..others).for_each(|_| scope.spawn(|_| take_all()));
                take_all();
            });
            return;
        }
        tasks.for_each(work);
    }
}
