//! Work whose passes are shorter than it takes to wake a thread.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rayon::{Scope, ThreadPool, Yield};

/// Time for which a thread without work looks for some without a pause. Then it leaves the processor to other
/// threads between two looks.
const IMPATIENT: Duration = Duration::from_micros(100);

/// Notes the end of work, also when it panics.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Does work of the pool until all of it has ended.
fn wait(ended: &AtomicBool) {
    let mut idle = Instant::now();
    while !ended.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(Yield::Executed) {
            idle = Instant::now();
        } else if idle.elapsed() < IMPATIENT {
            std::hint::spin_loop();
        } else {
            std::thread::yield_now();
        }
    }
}

/// Calls `work` on a thread of the pool, and keeps the others awake until it ends: most passes of a step of a
/// simulation are shorter than it takes to wake a thread.
pub fn keep_awake<R: Send>(pool: &ThreadPool, work: impl FnOnce() -> R + Send) -> R {
    let (awake, ended) = (AtomicUsize::new(1), AtomicBool::new(false));
    pool.scope(|scope: &Scope<'_>| {
        let caller = pool.current_thread_index();
        let (awake, ended) = (&awake, &ended);
        scope.spawn_broadcast(move |_, context| {
            if Some(context.index()) != caller {
                awake.fetch_add(1, Ordering::Relaxed);
                wait(ended);
            }
        });
        // Until all wait, no work may begin: a thread that waited for a part of it could otherwise begin to
        // wait for its end.
        while awake.load(Ordering::Relaxed) < pool.current_num_threads() {
            std::thread::yield_now();
        }
        let _end = End(ended);
        work()
    })
}
