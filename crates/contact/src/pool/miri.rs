//! The threads of a pool under Miri, which are started anew for each run.
//!
//! The threads of rayon cannot run there: crossbeam-epoch, which they use, violates the rules for pointers that Miri checks (Stacked Borrows).

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

    /// Number of threads, without the caller's.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Whether the caller is one of these threads; it does not matter here, because every run has threads of its own.
    #[allow(clippy::unused_self, reason = "it matters for threads of rayon")]
    pub(super) fn is_inside(&self) -> bool {
        false
    }

    /// Runs `take_all` on the caller and on as many others as are useful. `take_all` takes tasks until none of `tasks` is left.
    pub(super) fn run(&self, tasks: usize, take_all: &(dyn Fn() + Sync)) {
        std::thread::scope(|scope| {
            for _ in 0..self.count.min(tasks.saturating_sub(1)) {
                scope.spawn(take_all);
            }
            take_all();
        });
    }
}
