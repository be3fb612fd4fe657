//! Progress of a run on the terminal, `run.log` and `run.json`.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::time::{Duration, Instant};

use fdem_io::numbers::{brief, grouped};
use fdem_results::{CurveFigures, CurvePoint, Fragments, Inertia};
use serde_json::{Value, json};

use crate::command::failure::Failure;
use crate::command::progress::{Bar, INTERVAL, is_terminal};
use crate::command::run::account::{Account, PARTS};
use crate::command::run::engine::Engine;
use crate::command::run::folder::{Folder, LOG};
use crate::command::run::results::Results;
use crate::state_hash::state_hash;
use fdem_model::Prepared;

/// Percentage between two lines of progress without a terminal.
const PERCENT: u64 = 10;

/// Longest time without a line.
const SILENCE: Duration = Duration::from_secs(10);

/// Progress and log of a run.
pub(crate) struct RunLog {
    bar: Option<Bar>,
    lines: bool,
    log: File,
    start: Instant,
    last: Instant,
    /// When the last line was written.
    written: Instant,
    first_step: u64,
    total: u64,
    percent: u64,
}

impl RunLog {
    pub(crate) fn new<const D: usize, const N: usize>(
        folder: &Folder,
        run: &dyn Engine<D, N>,
        total: u64,
        quiet: bool,
    ) -> Result<Self, Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let path = folder.path(LOG);
        let log = OpenOptions::new().create(true).append(true).open(&path);
        let terminal = is_terminal();
        let bar = (!quiet && terminal).then(|| Bar::of_run(total, run.steps()));
        let now = Instant::now();
        Ok(Self {
            bar,
            lines: !quiet && !terminal,
            log: log.map_err(|error| Failure::writing(&path, error))?,
            start: now,
            last: now,
            written: now,
            first_step: run.steps(),
            total,
            percent: 100 * run.steps() / total.max(1) / PERCENT,
        })
    }

    /// Time since this part of the run began.
    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Writes a line to the log and to standard error.
    pub(crate) fn say(&mut self, text: &str) {
        // The run continues without its log.
        let _ = writeln!(self.log, "{:10.3} s  {text}", self.start.elapsed().as_secs_f64());
        match &self.bar {
            Some(bar) => bar.print(text),
            None if self.lines => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
            None => {}
        }
    }

    /// Shows events between steps on a terminal.
    pub(crate) fn does(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.say(text);
        }
    }

    /// Updates the progress.
    pub(crate) fn show<const D: usize, const N: usize>(&mut self, run: &dyn Engine<D, N>)
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let percent = 100 * run.steps() / self.total.max(1) / PERCENT;
        let line = percent > self.percent || self.written.elapsed() >= SILENCE;
        if !line && self.last.elapsed() < INTERVAL {
            return;
        }
        self.last = Instant::now();
        let rate = (run.steps() - self.first_step) as f64 / self.start.elapsed().as_secs_f64().max(1e-9);
        let counts = run.counts();
        // The most important parts come first: a narrow terminal shows only those that fit.
        let mut parts = vec![
            format!("time {} s", brief(run.time())),
            format!("step {} of {}", grouped(run.steps()), grouped(self.total)),
        ];
        if run.elements() > 0 {
            parts.push(format!("{} joints broken", grouped(counts.broken as u64)));
            parts.push(format!("{:.1} million element-steps a second", rate / 1e6 * run.elements() as f64));
        } else {
            parts.push(format!("{} contacts", grouped(counts.sphere_contacts as u64)));
            parts.push(format!("{:.1} million sphere-steps a second", rate / 1e6 * counts.spheres as f64));
        }
        parts.push(format!("kinetic energy {} J", brief(run.energies().kinetic)));
        let text = parts.join(", ");
        if let Some(bar) = &mut self.bar {
            bar.show(run.steps());
            bar.say_what_fits(&parts);
        }
        if line {
            self.percent = percent;
            self.written = self.last;
            let _ = writeln!(self.log, "{:10.3} s  {text}", self.start.elapsed().as_secs_f64());
            if self.lines {
                let percent = 100 * run.steps() / self.total.max(1);
                let _ = writeln!(std::io::stderr(), "{percent:3} %  {text}");
            }
        }
    }

    pub(crate) fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish();
        }
    }
}

/// Returns the contents of `run.json`. `account`: the times of the whole run; `frames`: their number;
/// `fragments`: those of now.
pub(crate) fn json<const D: usize, const N: usize>(
    run: &dyn Engine<D, N>,
    prepared: &Prepared<D, N>,
    status: &str,
    account: &Account,
    frames: usize,
    fragments: &Fragments<D>,
) -> Value
where
    [[f64; D]; N]: Results<D, N>,
{
    let (counts, energies) = (run.counts(), run.energies());
    let mut timings: serde_json::Map<String, Value> = PARTS
        .into_iter()
        .zip(account.parts)
        .map(|(name, seconds)| (name.replace(' ', "_"), json!(seconds)))
        .collect();
    timings.insert("output".to_owned(), json!(account.output));
    timings.insert("drawing".to_owned(), json!(account.drawing));
    timings.insert("total".to_owned(), json!(account.seconds));
    let critical = run.critical_step();
    let (fragment_count, sizes) = (fragments.count(), fragments.sizes());
    let balance = [("balance", energies.balance()), ("error", energies.error())];
    let told_energies: serde_json::Map<String, serde_json::Value> = energies
        .terms()
        .into_iter()
        .map(|term| (term.key, term.value))
        .chain(balance)
        .map(|(key, value)| (key.to_owned(), json!(value)))
        .collect();
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
        "elements": run.elements(),
        "nodes": counts.nodes,
        "spheres": counts.spheres,
        "sphere_contacts": counts.sphere_contacts,
        "waiting_spheres": counts.waiting_spheres,
        "deepest_overlap": run.deepest_overlap().map(|(share, _)| share),
        "steps": run.steps(),
        "time_step": run.time_step(),
        "time": run.time(),
        "critical_step": {
            "step": critical.step,
            "element": critical.element,
            "cause": critical.cause.to_string(),
        },
        "detections": account.detections,
        "joints": counts.joints,
        "broken_joints": counts.broken,
        "open_joints": counts.open,
        <[[f64; D]; N]>::CRACKED.0: run.crack_lengths().iter().sum::<f64>(),
        "fragments": {
            "number": fragment_count.number,
            "largest": fragment_count.largest,
            "d20": sizes.size(0.2),
            "d50": sizes.size(0.5),
            "d80": sizes.size(0.8),
        },
        "energies": told_energies,
        "seconds": timings,
        "output": {
            "share": account.share(),
            "frames": frames,
            "checkpoints": account.checkpoints,
        },
        "state_hash": state_hash(&run.snapshot(), &energies),
    })
}

/// A curve in `run.json`.
pub(crate) fn curve(figures: &CurveFigures) -> Value {
    json!({
        "name": figures.name,
        "x_unit": figures.units[0],
        "y_unit": figures.units[1],
        "peak": figures.peak,
        "x_at_peak": figures.at,
        "time_of_peak": figures.time,
        "modulus": figures.modulus,
        "modulus_unit": figures.modulus_unit(),
        "crack_initiation": figures.initiation.map(curve_point),
        "crack_damage": figures.damage.map(curve_point),
    })
}

/// A curve without values in `run.json`, with the reason.
pub(crate) fn empty_curve(name: &str, why: &str) -> Value {
    json!({ "name": name, "peak": Value::Null, "modulus": Value::Null, "empty": why })
}

/// The share of inertia in the peak load, in `run.json`.
pub(crate) fn inertia(inertia: &Inertia) -> serde_json::Value {
    json!({ "load": inertia.load, "peak": inertia.peak, "kinetic_over_strain": inertia.share })
}

/// Kinetic over strain energy at the peak load up to which the load is that of a slow test, within some 5 %.
const SLOW: f64 = 0.01;

/// The same in the summary.
pub(crate) fn inertia_in_words(inertia: &Inertia) -> String {
    let Inertia { load, peak, share } = inertia;
    let meaning = if *share > SLOW {
        "above 1 %, so that inertia may have raised the peak by more than 5 %: compare with half of the velocity"
    } else {
        "up to 1 % inertia has no part in the peak"
    };
    format!(
        "kinetic energy {:.2} % of the strain energy at the peak of {load}, {} N; {meaning}",
        100.0 * share,
        brief(*peak)
    )
}

fn curve_point(CurvePoint { x, y, time }: CurvePoint) -> Value {
    json!({ "x": x, "y": y, "time": time })
}

/// A curve in the summary.
pub(crate) fn curve_in_words(figures: &CurveFigures) -> String {
    let CurveFigures { name, peak, at, time, modulus, initiation, damage, units: [x, y] } = figures;
    let modulus = match modulus {
        Some(modulus) => {
            format!("modulus {} {} from 10 to 50 % of it", brief(*modulus), figures.modulus_unit())
        }
        None => "no modulus: too few rows from 10 to 50 % of it".to_owned(),
    };
    let points = [("cracks initiate", initiation), ("crack damage", damage)].map(|(event, point)| {
        point.map_or_else(String::new, |CurvePoint { y: value, .. }| {
            format!("; {event} at {} {y}, {:.0} % of the peak", brief(value), 100.0 * value / peak)
        })
    });
    let [initiation, damage] = points;
    format!(
        "{name}: peak {} {y} at {} {x}, {} s; {modulus}{initiation}{damage}",
        brief(*peak),
        brief(*at),
        brief(*time)
    )
}
