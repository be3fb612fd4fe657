//! Progress on a terminal, for steps that take longer than a second.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// A step that takes less is over before a bar could be read.
const PATIENCE: Duration = Duration::from_secs(1);

const INTERVAL: Duration = Duration::from_millis(100);

/// Times steps, and shows a bar on standard error while one lasts.
pub(crate) struct Progress {
    visible: bool,
}

/// How far a step is, to be advanced by whoever works on it.
pub(crate) type Position = Arc<AtomicU64>;

impl Progress {
    pub(crate) fn new(quiet: bool) -> Self {
        Self { visible: !quiet && std::io::stderr().is_terminal() }
    }

    /// Runs `work` and returns its result with the seconds it took.
    ///
    /// The bar runs up to `total`; without one it shows the position and the time only.
    pub(crate) fn step<R>(
        &self,
        label: &'static str,
        total: Option<u64>,
        work: impl FnOnce(&Position) -> R,
    ) -> (R, f64) {
        let position = Position::default();
        let start = Instant::now();
        let bar = if self.visible { Bar::watch(label, total, &position) } else { None };
        let result = work(&position);
        let seconds = start.elapsed().as_secs_f64();
        if let Some(bar) = bar {
            bar.finish();
        }
        (result, seconds)
    }
}

/// A thread that looks at the position, so that the work itself never waits for a terminal.
struct Bar {
    done: Sender<()>,
    thread: JoinHandle<()>,
}

impl Bar {
    /// None where no thread can be had: the work goes on unseen.
    fn watch(label: &'static str, total: Option<u64>, position: &Position) -> Option<Self> {
        let (done, wait) = mpsc::channel();
        let position = Arc::clone(position);
        let draw = move || {
            if wait.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            let bar = match total {
                Some(total) => {
                    ProgressBar::new(total).with_style(style("{msg} {wide_bar} {percent} %, {eta} left"))
                }
                None => ProgressBar::new_spinner()
                    .with_style(style("{spinner} {msg}: {human_pos} so far, {elapsed}")),
            }
            .with_message(label)
            .with_elapsed(PATIENCE);
            while wait.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                bar.set_position(position.load(Ordering::Relaxed));
                bar.tick();
            }
            bar.finish_and_clear();
        };
        let thread = thread::Builder::new().spawn(draw).ok()?;
        Some(Self { done, thread })
    }

    fn finish(self) {
        drop(self.done);
        // The thread only draws: if it panicked, the result is right all the same.
        let _ = self.thread.join();
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates in this file are valid")
}
