//! Work on parts of a fixed length, on several threads.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::Builder;

/// Number of couples or elements of a part: enough that a thread is worth its start.
const PART: usize = 1 << 15;

/// Threads that share work, and the counter of what they have handled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Team<'a> {
    threads: usize,
    handled: &'a AtomicU64,
}

impl<'a> Team<'a> {
    /// A team of `threads` threads; 0 is one per processor. `handled` counts couples and elements, those of
    /// each pass.
    pub(crate) fn new(threads: usize, handled: &'a AtomicU64) -> Self {
        let threads = match threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            _ => threads,
        };
        Self { threads, handled }
    }

    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// Adds to the number of couples and elements that were handled.
    pub(crate) fn count(&self, handled: usize) {
        self.handled.fetch_add(handled as u64, Ordering::Relaxed);
    }

    /// Does two works, at the same time if there are threads.
    pub(crate) fn both<A, B: Send>(
        &self,
        one: impl FnOnce() -> A,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if self.threads == 1 {
            return (one(), other());
        }
        // The work of a thread that did not start is still here.
        let other = Mutex::new(Some(other));
        let take = || {
            let work = other.lock().unwrap_or_else(PoisonError::into_inner).take();
            work.map(|work| work())
        };
        std::thread::scope(|scope| {
            let started = Builder::new().name("analysis".to_owned()).spawn_scoped(scope, take);
            let one = one();
            let done = match started {
                Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
                Err(_) => take(),
            };
            (one, done.expect("one of the two threads has taken the work"))
        })
    }

    /// Calls `work` with each part of `0..count` and returns the results in the order of the parts.
    ///
    /// The parts do not depend on the number of threads, so neither does a sum over the results in their
    /// order. With fewer threads than wanted, if the system has no more, the work takes longer.
    pub(crate) fn parts<S: Send>(&self, count: usize, work: impl Fn(Range<usize>) -> S + Sync) -> Vec<S> {
        let parts = count.div_ceil(PART);
        let next = AtomicUsize::new(0);
        let take = || {
            let mut done = Vec::new();
            loop {
                let part = next.fetch_add(1, Ordering::Relaxed);
                if part >= parts {
                    return done;
                }
                let range = part * PART..count.min((part + 1) * PART);
                let handled = range.len();
                done.push((part, work(range)));
                self.count(handled);
            }
        };
        let others = (self.threads - 1).min(parts.saturating_sub(1));
        let mut done = std::thread::scope(|scope| {
            let start = |_| Builder::new().name("analysis".to_owned()).spawn_scoped(scope, take).ok();
            let others: Vec<_> = (0..others).map_while(start).collect();
            let mut done = take();
            for other in others {
                match other.join() {
                    Ok(more) => done.extend(more),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            done
        });
        done.sort_unstable_by_key(|(part, _)| *part);
        done.into_iter().map(|(_, result)| result).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_works_are_done() {
        let handled = AtomicU64::new(0);
        for threads in [1, 2] {
            assert_eq!(Team::new(threads, &handled).both(|| 1, || "two"), (1, "two"));
        }
    }

    #[test]
    fn parts_do_not_depend_on_threads() {
        let handled = AtomicU64::new(0);
        for count in [0, 1, PART - 1, PART, PART + 1, 10 * PART + 3] {
            let one = Team::new(1, &handled).parts(count, |range| range);
            for threads in [2, 7] {
                assert_eq!(Team::new(threads, &handled).parts(count, |range| range), one);
            }
            assert_eq!(one.into_iter().flatten().collect::<Vec<_>>(), (0..count).collect::<Vec<_>>());
        }
        assert_eq!(handled.into_inner(), 3 * (14 * PART as u64 + 4 - 1));
    }
}
