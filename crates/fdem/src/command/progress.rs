//! The progress bar on standard error: of a step that takes longer than a second, and of a run.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::command::threads;

/// Time after which a bar appears: nobody could read the bar of a shorter step.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time after which a step is named in one line where no bar can be drawn.
const SILENCE: Duration = Duration::from_secs(10);

/// Time between two updates of a bar.
pub(crate) const INTERVAL: Duration = Duration::from_millis(100);

/// Whether standard error is a terminal, where a bar can be drawn.
pub(crate) fn is_terminal() -> bool {
    std::io::stderr().is_terminal()
}

/// Measures the time of steps, and shows a bar on standard error during each.
pub(crate) struct Progress {
    quiet: bool,
}

/// Progress of a step. The code that works on the step advances it.
pub(crate) type Position = Arc<AtomicU64>;

impl Progress {
    pub(crate) fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Runs `work` and returns its result with the seconds it took.
    ///
    /// The bar runs up to `total`. Without a total it shows the position and the time. Without a terminal a
    /// long step is named in a line.
    pub(crate) fn step<R>(
        &self,
        label: &'static str,
        total: Option<u64>,
        work: impl FnOnce(&Position) -> R,
    ) -> (R, f64) {
        let position = Position::default();
        let start = Instant::now();
        let bar = self.watch(label, total, &position);
        let result = work(&position);
        let seconds = start.elapsed().as_secs_f64();
        if let Some(bar) = bar {
            bar.finish();
        }
        (result, seconds)
    }

    /// Starts the thread that shows a step. Not generic, so that it is compiled once.
    fn watch(&self, label: &'static str, total: Option<u64>, position: &Position) -> Option<Watched> {
        let position = Arc::clone(position);
        match (self.quiet, is_terminal()) {
            (true, _) => None,
            (false, true) => Watched::start(move |wait| draw(label, total, &position, wait)),
            (false, false) => Watched::start(move |wait| tell(label, wait)),
        }
    }
}

/// A thread that shows the progress, so that the work never waits for the terminal.
struct Watched {
    done: Sender<()>,
    thread: JoinHandle<()>,
}

impl Watched {
    /// Starts the thread; `None` if the system has no thread left. The work then continues without a bar.
    /// `show` waits for the end.
    fn start(show: impl FnOnce(&Receiver<()>) + Send + 'static) -> Option<Self> {
        let (done, wait) = mpsc::channel();
        let thread = threads::start("progress", move || show(&wait)).ok()?;
        Some(Self { done, thread })
    }

    fn finish(self) {
        drop(self.done);
        // The thread only draws: the result is right even if it panicked.
        let _ = self.thread.join();
    }
}

/// Draws the position until the step ends.
fn draw(label: &'static str, total: Option<u64>, position: &Position, wait: &Receiver<()>) {
    if wait.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout) {
        return;
    }
    let length = label.chars().count();
    let mut bar = Bar::new(total, PATIENCE, move |width| template(total.is_some(), length, width).to_owned());
    bar.say(label);
    while wait.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
        bar.show(position.load(Ordering::Relaxed));
    }
    bar.finish();
}

/// Reports the current step if it is a long one.
fn tell(label: &str, wait: &Receiver<()>) {
    if wait.recv_timeout(SILENCE) == Err(RecvTimeoutError::Timeout) {
        eprintln!("{label} ...");
    }
}

/// A bar that fits into the terminal, however wide it becomes.
pub(crate) struct Bar {
    inner: ProgressBar,
    /// Returns the template for a terminal of this width.
    template: Box<dyn Fn(usize) -> String + Send>,
    width: usize,
}

impl Bar {
    /// A bar up to `total`, or a spinner, for work that began `elapsed` ago. `template` returns its template
    /// for a terminal with the given number of columns, at least one.
    fn new(
        total: Option<u64>,
        elapsed: Duration,
        template: impl Fn(usize) -> String + Send + 'static,
    ) -> Self {
        let inner = total.map_or_else(ProgressBar::new_spinner, ProgressBar::new).with_elapsed(elapsed);
        Self { inner, template: Box::new(template), width: 0 }
    }

    /// The bar of a run of `total` steps that is at step `position`. It has a line for messages below it, and
    /// keeps moving while no step updates it.
    pub(crate) fn of_run(total: u64, position: u64) -> Self {
        let mut bar =
            Self::new(Some(total), Duration::ZERO, |width| format!("{}\n{{msg}}", bar_of_run(width)));
        bar.show(position);
        bar.inner.enable_steady_tick(INTERVAL);
        bar
    }

    /// Draws the bar at a position.
    pub(crate) fn show(&mut self, position: u64) {
        let width = columns();
        if width != self.width {
            self.width = width;
            self.inner.set_style(style(&(self.template)(width)));
        }
        self.inner.set_position(position);
        self.inner.tick();
    }

    /// Shows the first of these parts that fit into a line, as the message of the bar.
    pub(crate) fn say_what_fits(&self, parts: &[String]) {
        self.inner.set_message(fitted(parts, columns()));
    }

    /// Shows a message.
    pub(crate) fn say(&self, message: &str) {
        self.inner.set_message(message.to_owned());
    }

    /// Prints a line above the bar.
    pub(crate) fn print(&self, line: &str) {
        self.inner.println(line);
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        self.inner.finish_and_clear();
    }
}

/// Columns of the terminal.
fn columns() -> usize {
    usize::from(console::Term::stderr().size().1)
}

/// Template of the progress of a step that fits into a line of this width, beside a label of `label`
/// characters.
fn template(total: bool, label: usize, width: usize) -> &'static str {
    // The widths hold for the longest percentages, times and counts, and for a bar of ten columns.
    match (total, width.saturating_sub(label)) {
        (true, 38..) => "{msg} {wide_bar} {percent} %, {eta} left",
        (true, 8..) => "{msg} {percent} %",
        (false, 40..) => "{spinner} {msg}: {human_pos} so far, {elapsed}",
        (false, 18..) => "{msg}: {human_pos}",
        _ => "{wide_msg}",
    }
}

/// Template of the first line of the progress of a run, for a terminal of this width.
fn bar_of_run(width: usize) -> &'static str {
    match width {
        52.. => "{wide_bar} {percent} %, {elapsed} gone, {eta} left",
        32.. => "{wide_bar} {percent} %, {eta} left",
        _ => "{percent} %",
    }
}

/// Joins the parts that fit into a line, in their order. If none fits, returns the beginning of the first
/// part.
fn fitted(parts: &[String], width: usize) -> String {
    let mut line = String::new();
    let mut used = 0;
    for part in parts {
        let gap = if used > 0 { 2 } else { 0 };
        let count = part.chars().count();
        if used + gap + count <= width {
            if gap > 0 {
                line.push_str(", ");
            }
            line.push_str(part);
            used += gap + count;
        }
    }
    if line.is_empty() {
        parts.first().map_or_else(String::new, |part| part.chars().take(width).collect())
    } else {
        line
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates in this file are valid")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit_into_any_width_and_leave_out_what_does_not() {
        let parts =
            ["step 1,200 of 40,000", "time 0.00123 s", "3.1 million element-steps a second", "12 broken"];
        let parts = parts.map(str::to_owned);
        for width in 0..120 {
            let line = fitted(&parts, width);
            assert!(line.chars().count() <= width, "{width}: {line}");
            assert!(width < 20 || line.starts_with("step 1,200 of 40,000"), "{width}: {line}");
        }
        assert_eq!(fitted(&parts, 120), parts.join(", "));
        assert_eq!(fitted(&parts, 50), "step 1,200 of 40,000, time 0.00123 s, 12 broken");
        assert_eq!(fitted(&[], 10), "");
    }

    #[test]
    fn bars_fit_into_any_width() {
        // The longest values of the keys.
        let longest = |template: &str, label: usize| {
            let keys = [
                ("{msg}", label),
                ("{percent}", 3),
                ("{eta}", 10),
                ("{elapsed}", 10),
                ("{human_pos}", 15),
                ("{spinner}", 1),
            ];
            let bars = template.replace("{wide_bar}", "").replace("{wide_msg}", "");
            keys.iter()
                .fold(bars, |text, (key, count)| text.replace(key, &"x".repeat(*count)))
                .chars()
                .count()
        };
        for width in 6..200 {
            assert!(longest(bar_of_run(width), 0) <= width, "{width}");
            for label in 0..40 {
                for total in [false, true] {
                    let template = template(total, label, width);
                    assert!(longest(template, label) <= width, "{width}: {template}");
                }
            }
        }
    }
}
