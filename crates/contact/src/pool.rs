//! Threads: runs independent tasks on a thread pool, or one after the other.

#[cfg(feature = "rayon")]
#[cfg_attr(miri, path = "pool/miri.rs")]
mod others;
#[cfg(all(feature = "rayon", not(miri)))]
mod spread;

#[cfg(feature = "rayon")]
use std::cell::Cell;
#[cfg(feature = "rayon")]
use std::sync::Arc;
#[cfg(feature = "rayon")]
use std::sync::Mutex;
use std::sync::OnceLock;

use crate::error::Error;
use crate::stop::Stop;
#[cfg(feature = "rayon")]
use others::Others;

/// Limit on the number of threads. More than any machine has processors would take minutes to start, and then
/// slow each other down.
#[cfg(feature = "rayon")]
const MAX_THREADS: usize = 1024;

#[cfg(feature = "rayon")]
thread_local! {
    /// The pool whose task this thread runs, by the address of its [`Others`]; null outside.
    static INSIDE: Cell<*const Others> = const { Cell::new(std::ptr::null()) };
}

/// A number of threads.
///
/// Users split their work so that the result does not depend on the number of threads. The pool only decides
/// which thread does which task.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pool {
    #[cfg(feature = "rayon")]
    others: Option<Arc<Others>>,
    stop: Stop,
}

#[cfg_attr(
    not(feature = "rayon"),
    allow(clippy::unused_self, reason = "without rayon there is nothing in a pool")
)]
impl Pool {
    /// A pool of `threads` threads; 0 is one per processor. One thread needs no pool.
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
                reason: format!("more than {MAX_THREADS} are not supported"),
            });
        }
        Ok(Self { others: Some(Others::new(threads)?.into()), stop: Stop::default() })
    }

    /// The threads of a pool that the user has. Whoever calls a search from one of these threads must hold no
    /// lock that other work of the pool needs, because the thread may do that work while it waits.
    #[cfg(feature = "rayon")]
    pub(crate) fn of(pool: Arc<rayon::ThreadPool>) -> Self {
        let several = pool.current_num_threads() > 1;
        Self { others: several.then(|| Arc::new(Others::of(pool))), stop: Stop::default() }
    }

    /// One thread: this build cannot have more.
    #[cfg(not(feature = "rayon"))]
    pub(crate) fn new(threads: usize) -> Result<Self, Error> {
        if threads <= 1 {
            return Ok(Self::default());
        }
        Err(Error::NoThreads { threads, reason: "built without the feature `rayon`".to_owned() })
    }

    /// The same pool for work that ends with [`Error::Stopped`] once the flag of `stop` is set.
    pub(crate) fn stopped_by(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// The flag that stops the work.
    pub(crate) fn stop(&self) -> &Stop {
        &self.stop
    }

    pub(crate) fn threads(&self) -> usize {
        #[cfg(feature = "rayon")]
        if let Some(others) = &self.others {
            return others.count() + 1;
        }
        1
    }

    /// Runs tasks as [`Pool::run`] does, for work that may fail. Returns one of the errors after all tasks.
    pub(crate) fn try_run<I: Send>(
        &self,
        tasks: impl Iterator<Item = I>,
        work: impl Fn(I) -> Result<(), Error> + Sync + Send,
    ) -> Result<(), Error> {
        let failed = OnceLock::new();
        self.run(tasks, |task| {
            if let Err(error) = work(task) {
                failed.get_or_init(|| error);
            }
        });
        failed.into_inner().map_or(Ok(()), Err)
    }

    /// Runs `work` on each task, in any order and at the same time.
    ///
    /// The caller may itself be a thread of another pool. It must not do other work of that pool while it
    /// waits, as threads of rayon do, because it may hold a lock that this work needs.
    pub(crate) fn run<I: Send>(&self, tasks: impl Iterator<Item = I>, work: impl Fn(I) + Sync + Send) {
        // Behind a pointer it is compiled once, not twice.
        let work: &(dyn Fn(I) + Sync) = &work;
        #[cfg(feature = "rayon")]
        if let Some(others) = self.others.as_deref()
            // Inside work of this pool all its other threads may be waiting.
            && !std::ptr::eq(INSIDE.get(), others)
        {
            let tasks: Vec<I> = tasks.collect();
            let count = tasks.len();
            let tasks = Mutex::new(tasks.into_iter());
            let next = || tasks.lock().ok().and_then(|mut tasks| tasks.next());
            others.run(count, &|| {
                let _inside = Inside::new(others);
                std::iter::from_fn(next).for_each(work);
            });
            return;
        }
        tasks.for_each(work);
    }
}

/// Marks this thread as one that runs a task of a pool, until it is dropped, also by a panic.
#[cfg(feature = "rayon")]
struct Inside {
    before: *const Others,
}

#[cfg(feature = "rayon")]
impl Inside {
    fn new(others: &Others) -> Self {
        Self { before: INSIDE.replace(others) }
    }
}

#[cfg(feature = "rayon")]
impl Drop for Inside {
    fn drop(&mut self) {
        INSIDE.set(self.before);
    }
}

#[cfg(all(test, feature = "rayon"))]
mod tests {
    use std::cell::RefCell;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use rayon::prelude::*;

    use super::*;

    fn sum(pool: &Pool, n: usize) -> usize {
        let total = AtomicUsize::new(0);
        pool.run(0..n, |k| {
            total.fetch_add(k, Ordering::Relaxed);
        });
        total.into_inner()
    }

    /// The callers are threads of a pool, and each holds something while it waits. A thread that took another
    /// job meanwhile would need it twice.
    #[test]
    fn a_caller_that_waits_does_no_other_work() {
        thread_local!(static MINE: RefCell<Pool> = RefCell::new(Pool::new(2).unwrap()));
        let callers = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let shared = Mutex::new(Pool::new(2).unwrap());
        callers.install(|| {
            (0..200).into_par_iter().for_each(|_| {
                assert_eq!(MINE.with(|pool| sum(&pool.borrow_mut(), 100)), 4950);
                assert_eq!(sum(&shared.lock().unwrap(), 100), 4950);
            });
        });
    }

    #[test]
    fn work_may_run_work_on_the_same_pool() {
        let pool = Pool::new(3).unwrap();
        let total = AtomicUsize::new(0);
        pool.run(0..50, |_| {
            total.fetch_add(sum(&pool, 10), Ordering::Relaxed);
        });
        assert_eq!(total.into_inner(), 50 * 45);
    }

    /// A search inside a simulation works on the threads of the simulation, however often it is repeated.
    #[test]
    fn work_on_the_pool_of_the_caller_starts_no_thread() {
        let threads = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap());
        let (shared, own) = (Pool::of(threads.clone()), Pool::new(3).unwrap());
        assert_eq!(shared.threads(), 3);
        let worked = |pool: &Pool| {
            let threads = Mutex::new(Vec::new());
            for _ in 0..20 {
                pool.run(0..30, |_| {
                    // Work inside work of the pool.
                    assert_eq!(sum(pool, 10), 45);
                    let (mut threads, thread) = (threads.lock().unwrap(), std::thread::current().id());
                    if !threads.contains(&thread) {
                        threads.push(thread);
                    }
                });
            }
            threads.into_inner().unwrap().len()
        };
        assert!(threads.install(|| worked(&shared)) <= 3);
        // A caller from elsewhere works too, and any thread of the pool may be the one that it leaves idle.
        assert!(worked(&shared) <= 4);
        // The test can fail: a caller from another pool needs a new thread each time.
        assert!(threads.install(|| worked(&own)) > 4);
    }

    #[test]
    #[should_panic(expected = "77")]
    fn a_panic_comes_out_of_a_pool_inside_another() {
        let pool = Pool::new(2).unwrap();
        let callers = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        callers.install(|| pool.run(0..100, |k| assert!(k != 77, "{k}")));
    }
}
