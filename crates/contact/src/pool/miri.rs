//! The threads of a pool under Miri, which are started for each run.
//!
//! The threads of rayon cannot run there: crossbeam-epoch, which they use, violates the rules for pointers
//! that Miri checks (Stacked Borrows).

use std::sync::Arc;

use crate::error::Error;

/// All threads except the caller's.
#[derive(Debug)]
pub(super) struct Others {
    count: usize,
}

impl Others {
    /// All but one of `threads` threads, of which there are at least two.
    #[allow(clippy::unnecessary_wraps, reason = "threads of rayon may fail to start")]
    pub(super) fn new(threads: usize) -> Result<Self, Error> {
        Ok(Self { count: threads - 1 })
    }

    /// Number of threads in a pool of the user, without the caller's.
    pub(super) fn of(pool: Arc<rayon::ThreadPool>) -> Self {
        Self { count: pool.current_num_threads() - 1 }
    }

    /// Number of threads, without the caller's.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Runs `take_all` on the caller and on as many other threads as are useful. `take_all` takes tasks until
    /// none of `tasks` is left.
    pub(super) fn run(&self, tasks: usize, take_all: &(dyn Fn() + Sync)) {
        std::thread::scope(|scope| {
            for _ in 0..self.count.min(tasks.saturating_sub(1)) {
                scope.spawn(take_all);
            }
            take_all();
        });
    }
}
