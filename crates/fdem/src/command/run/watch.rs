//! Ctrl-C and the other signals that ask a program to end. A run writes a checkpoint before it ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};

use crate::command::failure::Failure;

/// The signal that has arrived, if any.
#[derive(Clone, Debug)]
pub(crate) struct Watch(Arc<AtomicI32>);

impl Watch {
    /// Starts to watch for signals. A second signal ends the program at once, because the files in the folder are complete at any time.
    pub(crate) fn new() -> Result<Self, Failure> {
        let came = Arc::new(AtomicI32::new(0));
        let note = {
            let came = Arc::clone(&came);
            move |signal: i32| {
                if came.swap(signal, Ordering::SeqCst) != 0 {
                    std::process::exit(128 + signal);
                }
            }
        };
        watch(note).map_err(|error| Failure::Unusable(format!("cannot watch for interrupts: {error}")))?;
        Ok(Self(came))
    }

    /// Number of the signal that asks the run to end.
    pub(crate) fn signal(&self) -> Option<i32> {
        Some(self.0.load(Ordering::SeqCst)).filter(|&signal| signal != 0)
    }
}

#[cfg(unix)]
fn watch(note: impl Fn(i32) + Send + 'static) -> Result<(), std::io::Error> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    std::thread::Builder::new().spawn(move || signals.forever().for_each(note)).map(drop)
}

#[cfg(not(unix))]
fn watch(note: impl Fn(i32) + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || note(2))
}
