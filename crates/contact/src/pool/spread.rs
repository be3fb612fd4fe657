//! Moves threads that the system has woken on the same processor as the thread that woke them.
//!
//! A thread that has slept may be put on a busy processor while another one is idle, until the system
//! balances the load. That takes some milliseconds, longer than many searches. Linux does this in virtual
//! machines, where a virtual processor that has halted counts as busy; two threads are then slower than one.
//! A thread that has not started in time is excluded from the processor of the caller for a moment, which
//! moves it immediately. No thread stays pinned. On other systems nothing is done.

#[cfg(target_os = "linux")]
mod threads {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Mutex, OnceLock};
    use std::time::{Duration, Instant};

    use rustix::thread::{Pid, gettid, sched_getaffinity, sched_getcpu, sched_setaffinity};

    /// A thread that will start on an idle processor has started within this time.
    const PATIENCE: Duration = Duration::from_micros(30);

    /// Number of threads that are moved at a time. If many threads are late, the reason is that many threads
    /// take long to wake.
    const MOST: usize = 16;

    #[derive(Debug)]
    pub(crate) struct Spread {
        threads: Vec<Thread>,
        /// Whether there is a processor for each thread and for the caller.
        fit: bool,
    }

    #[derive(Debug, Default)]
    struct Thread {
        id: OnceLock<Pid>,
        /// Held while a thread is being moved. If two movers act together, the second would take the
        /// temporary exclusion of the first for the allowed set.
        moving: Mutex<()>,
        started: AtomicBool,
    }

    impl Spread {
        pub(crate) fn new(threads: usize) -> Self {
            let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
            Self {
                threads: std::iter::repeat_with(Thread::default).take(threads).collect(),
                fit: threads < processors,
            }
        }

        /// Must be called by thread `index` of the pool before anything else.
        pub(crate) fn enter(&self, index: usize) {
            self.threads[index].id.get_or_init(gettid);
        }

        /// Must be called by a thread of the pool when it starts to work.
        pub(crate) fn start(&self) {
            if let Some(index) = rayon::current_thread_index() {
                self.threads[index].started.store(true, Ordering::Relaxed);
            }
        }

        /// Must be called before threads are woken.
        pub(crate) fn before(&self) {
            self.threads.iter().for_each(|thread| thread.started.store(false, Ordering::Relaxed));
        }

        /// Waits for `others` threads to start. If that takes too long, moves those that have not started
        /// away from the processor of the caller.
        pub(crate) fn look(&self, others: usize) {
            if !self.fit {
                return;
            }
            let late = |thread: &&Thread| !thread.started.load(Ordering::Relaxed);
            let start = Instant::now();
            while self.threads.len() - self.threads.iter().filter(late).count() < others {
                if start.elapsed() > PATIENCE {
                    self.threads.iter().filter(late).take(MOST).for_each(Thread::go_elsewhere);
                    return;
                }
                std::hint::spin_loop();
            }
        }
    }

    impl Thread {
        /// Moves the thread to another processor. If the system refuses, the thread stays where it is.
        fn go_elsewhere(&self) {
            let Ok(_moving) = self.moving.try_lock() else { return };
            let here = sched_getcpu();
            let Some(&id) = self.id.get() else { return };
            let Ok(allowed) = sched_getaffinity(Some(id)) else { return };
            let mut elsewhere = allowed;
            elsewhere.unset(here);
            if elsewhere.count() > 0 && sched_setaffinity(Some(id), &elsewhere).is_ok() {
                // This restores the original set, so the system cannot refuse it.
                let _ = sched_setaffinity(Some(id), &allowed);
            }
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn a_thread_that_is_moved_keeps_its_processors() {
            let thread = Thread::default();
            thread.id.get_or_init(gettid);
            let processors =
                || (0..1024).filter(|&k| sched_getaffinity(None).unwrap().is_set(k)).collect::<Vec<_>>();
            let before = processors();
            thread.go_elsewhere();
            assert_eq!(processors(), before);
        }

        #[test]
        fn a_thread_that_many_move_keeps_its_processors() {
            let thread = Thread::default();
            thread.id.get_or_init(gettid);
            let me = gettid();
            let allowed = || (0..1024).filter(|&k| sched_getaffinity(Some(me)).unwrap().is_set(k)).count();
            let before = allowed();
            std::thread::scope(|scope| {
                for _ in 0..6 {
                    scope.spawn(|| (0..2000).for_each(|_| thread.go_elsewhere()));
                }
            });
            assert_eq!(allowed(), before);
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod threads {
    #[derive(Debug)]
    pub(crate) struct Spread;

    impl Spread {
        pub(crate) fn new(_: usize) -> Self {
            Self
        }

        pub(crate) fn enter(&self, _: usize) {}

        pub(crate) fn start(&self) {}

        pub(crate) fn before(&self) {}

        pub(crate) fn look(&self, _: usize) {}
    }
}

pub(super) use threads::Spread;
