//! Independent tasks on several threads.

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Runs `work` on each of `tasks`, on up to `threads` threads; 0 is one thread for each processor. Once
/// `stop` is set, no more tasks begin.
pub(crate) fn run<T: Send>(
    (threads, stop): (usize, &AtomicBool),
    tasks: impl ExactSizeIterator<Item = T> + Send,
    work: impl Fn(T) + Sync,
) {
    let threads = match threads {
        0 => thread::available_parallelism().map_or(1, NonZero::get),
        _ => threads,
    };
    let threads = threads.min(tasks.len());
    let waiting = Mutex::new(tasks);
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
    let all = || {
        while !stop.load(Ordering::Relaxed)
            && let Some(task) = next()
        {
            work(task);
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(all);
        }
        all();
    });
}
