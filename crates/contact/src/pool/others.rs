//! The threads of a pool, which are threads of rayon.

use std::hint::black_box;
use std::sync::Arc;

use super::spread::Spread;
use crate::error::Error;

/// Stack of a thread, bytes.
const STACK: usize = 2 << 20;

/// Memory that a thread needs when it begins, besides its stack, bytes: more than enough. The standard
/// library and the C library end the program if there is less.
const BEGINNING: usize = 1 << 18;

/// All threads except the caller's. The caller works too, because waking one thread fewer is faster.
#[derive(Debug)]
pub(super) struct Others {
    pool: Arc<rayon::ThreadPool>,
    count: usize,
    /// `None` if the pool belongs to the user, who may have placed its threads.
    spread: Option<Arc<Spread>>,
}

impl Others {
    /// Starts all but one of `threads` threads, of which there are at least two.
    pub(super) fn new(threads: usize) -> Result<Self, Error> {
        let count = threads - 1;
        let no_threads = |reason| Error::NoThreads { threads, reason };
        let mut room = Vec::<u8>::new();
        let enough = room.try_reserve_exact(count * (STACK + BEGINNING));
        enough.map_err(|error| no_threads(error.to_string()))?;
        // A compiler leaves out memory that nobody looks at.
        drop(black_box(room));
        let spread = Arc::new(Spread::new(count));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).stack_size(STACK).start_handler({
            let spread = spread.clone();
            move |index| spread.enter(index)
        });
        let pool = pool.build().map_err(|error| no_threads(error.to_string()))?;
        // They have begun when they have done something, and the caller may take all memory then.
        pool.broadcast(|_| ());
        Ok(Self { pool: Arc::new(pool), count, spread: Some(spread) })
    }

    /// All but one of the threads of a pool that the user has.
    pub(super) fn of(pool: Arc<rayon::ThreadPool>) -> Self {
        let count = pool.current_num_threads().saturating_sub(1);
        Self { pool, count, spread: None }
    }

    /// Number of threads, without the caller's.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Runs `take_all` on the caller and on as many other threads as are useful. `take_all` takes tasks until
    /// none of `tasks` is left.
    ///
    /// Not generic, so that the code for threads is compiled once.
    pub(super) fn run(&self, tasks: usize, take_all: &(dyn Fn() + Sync)) {
        let Self { pool, count, spread } = self;
        let spread = spread.as_deref();
        let run = || {
            let others = tasks.saturating_sub(1).min(*count);
            if let Some(spread) = spread {
                spread.before();
            }
            pool.in_place_scope(|scope| {
                for _ in 0..others {
                    scope.spawn(|_| {
                        if let Some(spread) = spread {
                            spread.start();
                        }
                        take_all();
                    });
                }
                if let Some(spread) = spread {
                    spread.look(others);
                }
                take_all();
            });
        };
        if rayon::current_thread_index().is_none() || pool.current_thread_index().is_some() {
            run();
        } else {
            // A thread of another pool would do other work of that pool while it waits.
            std::thread::scope(|scope| {
                if let Err(panic) = scope.spawn(run).join() {
                    std::panic::resume_unwind(panic);
                }
            });
        }
    }
}
