//! Ctrl-C and the other signals that interrupt a program. A run writes a checkpoint before it ends.

use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crate::command::failure::Failure;
use crate::command::output::end;

/// Signals within this time are one request: `timeout` and batch systems send one to the program and one to
/// its group.
const ONE_REQUEST: Duration = Duration::from_secs(1);

/// The signal that has arrived, if any, and whether the run waits for one.
#[derive(Debug)]
pub(crate) struct Watch {
    came: Arc<AtomicI32>,
    runs: Arc<AtomicBool>,
}

impl Watch {
    /// Starts to watch for signals. They end the program immediately, until [`Self::begin`]; so does a second
    /// request afterwards, because the files in the folder are complete at any time.
    pub(crate) fn new() -> Result<Self, Failure> {
        let (came, runs) = (Arc::new(AtomicI32::new(0)), Arc::new(AtomicBool::new(false)));
        let note = {
            let (came, runs) = (Arc::clone(&came), Arc::clone(&runs));
            let first = OnceLock::new();
            move |signal: i32| {
                came.store(signal, Ordering::SeqCst);
                let since = first.get_or_init(Instant::now).elapsed();
                if since > ONE_REQUEST || !runs.load(Ordering::SeqCst) {
                    end(128 + signal);
                }
            }
        };
        watch(note).map_err(|error| Failure::Unusable(format!("cannot watch for interrupts: {error}")))?;
        Ok(Self { came, runs })
    }

    /// From here on a first signal is left to the run.
    pub(crate) fn begin(&self) {
        self.runs.store(true, Ordering::SeqCst);
    }

    /// Number of the signal that interrupts the run.
    pub(crate) fn signal(&self) -> Option<i32> {
        Some(self.came.load(Ordering::SeqCst)).filter(|&signal| signal != 0)
    }
}

impl Drop for Watch {
    /// A program that continues after its run is not ended by the signals of that time.
    fn drop(&mut self) {
        self.begin();
    }
}

#[cfg(unix)]
fn watch(note: impl Fn(i32) + Send + 'static) -> Result<(), std::io::Error> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    crate::command::threads::start("signals", move || signals.forever().for_each(note)).map(drop)
}

#[cfg(not(unix))]
fn watch(note: impl Fn(i32) + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || note(2))
}
