//! Threads: tasks that do not depend on each other, on a pool or one after the other.

#[cfg(feature = "rayon")]
mod spread;

#[cfg(feature = "rayon")]
use std::sync::{Arc, Mutex};

use crate::error::Error;
#[cfg(feature = "rayon")]
use spread::Spread;

/// More threads than any machine has processors would be started for minutes, and then stand in each other's way.
#[cfg(feature = "rayon")]
const MAX_THREADS: usize = 1024;

/// A number of threads.
///
/// Whoever uses it splits work so that the result does not depend on the number; the pool decides who does what, and
/// nothing else.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pool {
    #[cfg(feature = "rayon")]
    others: Option<Arc<Others>>,
}

/// All threads but the caller's, which works too: to wake one fewer is quicker.
#[cfg(feature = "rayon")]
#[derive(Debug)]
struct Others {
    pool: rayon::ThreadPool,
    spread: Arc<Spread>,
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
        let spread = Arc::new(Spread::new(threads - 1));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads - 1).start_handler({
            let spread = spread.clone();
            move |index| spread.enter(index)
        });
        let pool = pool.build().map_err(|error| Error::NoThreads { threads, reason: error.to_string() })?;
        Ok(Self { others: Some(Others { pool, spread }.into()) })
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
        if let Some(others) = &self.others {
            return others.pool.current_num_threads() + 1;
        }
        1
    }

    /// Runs `work` on each task, in any order and at the same time.
    pub(crate) fn run<I: Send>(&self, tasks: impl Iterator<Item = I>, work: impl Fn(I) + Sync + Send) {
        #[cfg(feature = "rayon")]
        if let Some(Others { pool, spread }) = self.others.as_deref() {
            let tasks: Vec<I> = tasks.collect();
            let others = pool.current_num_threads().min(tasks.len().saturating_sub(1));
            let tasks = Mutex::new(tasks.into_iter());
            let next = || tasks.lock().ok().and_then(|mut tasks| tasks.next());
            let take_all = || std::iter::from_fn(next).for_each(&work);
            spread.before();
            pool.in_place_scope(|scope| {
                for _ in 0..others {
                    scope.spawn(|_| {
                        spread.start();
                        take_all();
                    });
                }
                spread.look(others);
                take_all();
            });
            return;
        }
        tasks.for_each(work);
    }
}
