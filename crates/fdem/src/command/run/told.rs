//! What a run tells: progress on the terminal, `run.log`, `run.json`.

use std::fs::{File, OpenOptions};
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use fdem_simulation::{Simulation, Timings};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::command::failure::Failure;
use crate::command::run::folder::{Folder, LOG};
use crate::model::Prepared;
use crate::numbers::{brief, grouped};

/// Between two looks at the bar.
const REFRESH: Duration = Duration::from_millis(100);

/// Lines of progress where there is no terminal: every so many percent.
const PERCENT: u64 = 10;

/// Progress and log of a run.
pub(crate) struct Told {
    bar: Option<ProgressBar>,
    lines: bool,
    log: File,
    start: Instant,
    last: Instant,
    first_step: u64,
    total: u64,
    percent: u64,
}

impl Told {
    pub(crate) fn new(folder: &Folder, run: &Simulation, total: u64, quiet: bool) -> Result<Self, Failure> {
        let path = folder.path(LOG);
        let log = OpenOptions::new().create(true).append(true).open(&path);
        let terminal = std::io::stderr().is_terminal();
        let bar = (!quiet && terminal).then(|| {
            let style =
                ProgressStyle::with_template("{wide_bar} {percent} %, {elapsed} gone, {eta} left\n{msg}");
            ProgressBar::new(total)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
                .with_position(run.steps())
        });
        let now = Instant::now();
        Ok(Self {
            bar,
            lines: !quiet && !terminal,
            log: log.map_err(|error| Failure::writing(&path, error))?,
            start: now,
            last: now,
            first_step: run.steps(),
            total,
            percent: 100 * run.steps() / total.max(1) / PERCENT,
        })
    }

    /// Seconds since this part of the run began.
    pub(crate) fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// A line for the log, and for whoever looks.
    pub(crate) fn say(&mut self, text: &str) {
        // A log that cannot be written to is no reason to lose the run.
        let _ = writeln!(self.log, "{:10.3} s  {text}", self.start.elapsed().as_secs_f64());
        match &self.bar {
            Some(bar) => bar.println(text),
            None if self.lines => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
            None => {}
        }
    }

    /// How far the run is.
    pub(crate) fn show(&mut self, run: &Simulation) {
        let percent = 100 * run.steps() / self.total.max(1) / PERCENT;
        let line = percent > self.percent;
        if !line && self.last.elapsed() < REFRESH {
            return;
        }
        self.last = Instant::now();
        let rate = (run.steps() - self.first_step) as f64 * run.model().mesh.triangles.len() as f64
            / self.seconds().max(1e-9);
        let counts = run.counts();
        let text = format!(
            "time {} s, step {} of {}, {:.1} million element-steps a second, kinetic energy {} J, {} joints broken",
            brief(run.time()),
            grouped(run.steps()),
            grouped(self.total),
            rate / 1e6,
            brief(run.energies().kinetic),
            grouped(counts.broken as u64)
        );
        if let Some(bar) = &self.bar {
            bar.set_position(run.steps());
            bar.set_message(text.clone());
        }
        if line {
            self.percent = percent;
            let _ = writeln!(self.log, "{:10.3} s  {text}", self.start.elapsed().as_secs_f64());
            if self.lines {
                let _ = writeln!(std::io::stderr(), "{:3} %  {text}", percent * PERCENT);
            }
        }
    }

    pub(crate) fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Parts of a step, in their order, with the seconds that they took.
pub(crate) fn parts(timings: &Timings) -> [(&'static str, f64); 5] {
    [
        ("bulk", timings.bulk),
        ("joints", timings.joints),
        ("detection", timings.detection),
        ("contact force", timings.contact),
        ("integration", timings.integration),
    ]
    .map(|(name, time)| (name, time.as_secs_f64()))
}

/// The file for programs. `seconds`: on the clock, in all parts of the run; `output`: of it for results.
pub(crate) fn json(run: &Simulation, prepared: &Prepared, status: &str, seconds: f64, output: f64) -> Value {
    let (counts, energies) = (run.counts(), run.energies());
    let mut timings: serde_json::Map<String, Value> = parts(&run.timings())
        .into_iter()
        .map(|(name, seconds)| (name.replace(' ', "_"), json!(seconds)))
        .collect();
    timings.insert("output".to_owned(), json!(output));
    timings.insert("total".to_owned(), json!(seconds));
    let critical = run.critical_step();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "title": prepared.title,
        "model_hash": prepared.hash,
        "status": status,
        "machine": {
            "os": std::env::consts::OS,
            "architecture": std::env::consts::ARCH,
            "processors": std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            "threads": run.threads(),
        },
        "elements": run.model().mesh.triangles.len(),
        "nodes": counts.nodes,
        "steps": run.steps(),
        "time_step": run.time_step(),
        "time": run.time(),
        "critical_step": {
            "step": critical.step,
            "element": critical.element,
            "cause": critical.cause.to_string(),
        },
        "detections": counts.detections,
        "joints": counts.joints,
        "broken_joints": counts.broken,
        "crack_length": run.crack_lengths().iter().sum::<f64>(),
        "energies": {
            "kinetic": energies.kinetic,
            "strain": energies.strain,
            "contact": energies.contact,
            "friction": energies.friction,
            "cohesive": energies.cohesive,
            "damping": energies.damping,
            "external": energies.external,
            "initial": energies.initial,
            "balance": energies.balance(),
            "error": energies.error(),
        },
        "seconds": timings,
        "state_hash": state_hash(run),
    })
}

/// SHA-256 of where all is, how it moves, its stress, its cracks and its energies: equal for equal runs, whatever the threads, and however often they were interrupted.
fn state_hash(run: &Simulation) -> String {
    let (snapshot, energies) = (run.snapshot(), run.energies());
    let mut hash = Sha256::new();
    let mut add = |number: f64| hash.update(number.to_bits().to_le_bytes());
    for [x, y] in snapshot.positions.iter().chain(&snapshot.velocities) {
        add(*x);
        add(*y);
    }
    snapshot.stresses.iter().flatten().chain(&snapshot.damage).for_each(|&number| add(number));
    for crack in &snapshot.cracks {
        [crack.damage, crack.opening, crack.sliding, crack.time.unwrap_or(f64::NAN)]
            .into_iter()
            .for_each(&mut add);
    }
    let works = [energies.friction, energies.cohesive, energies.damping, energies.external, energies.initial];
    [energies.kinetic, energies.strain, energies.contact].into_iter().chain(works).for_each(&mut add);
    hexadecimal(&hash.finalize())
}

fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
