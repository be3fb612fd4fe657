//! Work without the interpreter's lock, which Ctrl-C ends.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::problem::Problem;

/// The time between two looks for signals: long enough to cost nothing, and too short for a person to notice.
const PERIOD: Duration = Duration::from_millis(20);

/// Set when the work is to stop.
pub(crate) type Stop = Arc<AtomicBool>;

/// Runs `work` without the interpreter's lock.
///
/// Long work runs on another thread while this one runs the handlers of signals. When one of them raises, as
/// that of Ctrl-C does, `stop` is set, the work is waited for, since it reads the caller's arrays, and the
/// exception is raised.
///
/// # Errors
/// The error of `work`, or the exception that a handler raised.
pub(crate) fn run<R: Send>(
    py: Python<'_>,
    is_long: bool,
    stop: &Stop,
    work: impl FnOnce() -> Result<R, Problem> + Send,
) -> PyResult<R> {
    let (mut work, mut done) = (Some(work), None);
    attend(py, is_long, stop, &mut || done = work.take().map(|work| work()))?;
    Ok(done.unwrap_or_else(|| unreachable!("the work has ended"))?)
}

/// The part of [`run`] that is the same for all work, so that it is compiled once.
fn attend(py: Python<'_>, is_long: bool, stop: &Stop, work: &mut (dyn FnMut() + Send)) -> PyResult<()> {
    stop.store(false, Ordering::Relaxed);
    if !is_long {
        py.detach(work);
        return Ok(());
    }
    let mut raised = None;
    py.detach(|| {
        thread::scope(|scope| {
            let (ends, ended) = channel::<()>();
            let work = move || {
                // Dropped at the end, also by a panic.
                let _ends = ends;
                work();
            };
            let thread = thread::Builder::new().spawn_scoped(scope, work);
            let thread = thread.map_err(|error| Problem::System(format!("no thread can be had: {error}")))?;
            while ended.recv_timeout(PERIOD) == Err(RecvTimeoutError::Timeout) {
                if let Err(error) = handle_signals() {
                    stop.store(true, Ordering::Relaxed);
                    raised.get_or_insert(error);
                }
            }
            thread.join().unwrap_or_else(|panic| resume_unwind(panic));
            Ok::<_, Problem>(())
        })
    })?;
    raised.map_or(Ok(()), Err)
}

/// Runs `work`, which owns all that it reads, without the interpreter's lock.
///
/// It runs on another thread while this one runs the handlers of signals. When one of them raises, the
/// exception is raised at once; the thread continues to the end of the work, whose result is dropped.
/// This is for work that cannot be stopped midway, and that changes nothing outside.
///
/// # Errors
/// The exception that a handler raised, or that no thread can be had.
pub(crate) fn leave<R: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> R + Send + 'static,
) -> PyResult<R> {
    let (sender, receiver) = channel();
    // A panic is that of the caller, if there still is one.
    let work = move || drop(sender.send(catch_unwind(AssertUnwindSafe(work))));
    let thread = thread::Builder::new().spawn(work);
    thread.map_err(|error| Problem::System(format!("no thread can be had: {error}")))?;
    py.detach(move || {
        loop {
            match receiver.recv_timeout(PERIOD) {
                Ok(done) => return Ok(done.unwrap_or_else(|panic| resume_unwind(panic))),
                Err(RecvTimeoutError::Timeout) => handle_signals()?,
                Err(RecvTimeoutError::Disconnected) => unreachable!("the work sends its result"),
            }
        }
    })
}

/// Runs the handlers of signals that have come.
fn handle_signals() -> PyResult<()> {
    #[allow(clippy::redundant_closure_for_method_calls, reason = "the method is not general enough")]
    Python::attach(|py| py.check_signals())
}
