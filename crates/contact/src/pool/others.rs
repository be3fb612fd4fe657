//! The threads of a pool, which are threads of rayon.

use std::sync::Arc;

use super::spread::Spread;
use crate::error::Error;

/// All threads except the caller's. The caller works too, because waking one thread fewer is faster.
#[derive(Debug)]
pub(super) struct Others {
    pool: rayon::ThreadPool,
    spread: Arc<Spread>,
}

impl Others {
    /// Starts all but one of `threads` threads, of which there are at least two.
    pub(super) fn new(threads: usize) -> Result<Self, Error> {
        let spread = Arc::new(Spread::new(threads - 1));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads - 1).start_handler({
            let spread = spread.clone();
            move |index| spread.enter(index)
        });
        let pool = pool.build().map_err(|error| Error::NoThreads { threads, reason: error.to_string() })?;
        Ok(Self { pool, spread })
    }

    /// Number of threads, without the caller's.
    pub(super) fn count(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Whether the caller is one of these threads.
    pub(super) fn is_inside(&self) -> bool {
        self.pool.current_thread_index().is_some()
    }

    /// Runs `take_all` on the caller and on as many others as are useful. `take_all` takes tasks until none of `tasks` is left.
    ///
    /// Not generic, so that the code for threads is compiled once.
    pub(super) fn run(&self, tasks: usize, take_all: &(dyn Fn() + Sync)) {
        let Self { pool, spread } = self;
        let run = || {
            let others = pool.current_num_threads().min(tasks.saturating_sub(1));
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
        };
        if rayon::current_thread_index().is_none() {
            run();
        } else {
            std::thread::scope(|scope| {
                if let Err(panic) = scope.spawn(run).join() {
                    std::panic::resume_unwind(panic);
                }
            });
        }
    }
}
