//! `fdem run` and `fdem resume`: a model is simulated, its results are written as it goes.

pub(crate) mod folder;
mod recorder;
mod told;
mod watch;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fdem_simulation::{Simulation, Stop};

use crate::command::args::{ResumeArguments, RunArguments, RunOptions};
use crate::command::check::{read_text, refused};
use crate::command::failure::{Failure, display_name};
use crate::model::{Checkpoint as When, Preflight, Prepared, prepare};
use crate::numbers::{brief, grouped};
use folder::{Checkpoint, Folder, MODEL, SUMMARY};
use recorder::Recorder;
use told::Told;
use watch::Watch;

/// How long a run may go on before it looks at the clock and for signals.
const SLICE: Duration = Duration::from_millis(100);

pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let path = &arguments.model;
    let text = read_text(path)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let mut inputs = Vec::new();
    let mut load = |file: &str| {
        let bytes = fs::read(beside.join(file)).map_err(|error| error.to_string())?;
        inputs.push(bytes.clone());
        Ok(bytes)
    };
    let prepared = prepare(&text, &display_name(path), &mut load).map_err(|errors| refused(&errors))?;
    let unusable = |why: String| Failure::Unusable(format!("{} cannot run: {why}", display_name(path)));
    let simulation = Simulation::new(prepared.model.clone(), arguments.options.threads)
        .map_err(|error| unusable(error.to_string()))?;
    let preflight = Preflight::with(&prepared, simulation.critical_step()).map_err(unusable)?;
    let target = arguments.output.clone().unwrap_or_else(|| default_folder(path));
    let folder = Folder::create(&target, arguments.force, text.as_bytes(), &inputs)?;
    let recorder = Recorder::new(&folder, &prepared)?;
    let mut going = Going::new(folder, prepared, simulation, recorder, 0.0, &arguments.options)?;
    for line in preflight.to_string().lines() {
        going.told.say(line);
    }
    going.recorder.frame(&going.run)?;
    // From here on the run can be resumed.
    going.save()?;
    going.go()
}

pub(crate) fn resume(arguments: &ResumeArguments) -> Result<(), Failure> {
    let (folder, checkpoint) = Folder::open(&arguments.folder)?;
    let path = folder.path(MODEL);
    let text = read_text(&path)?;
    let mut next = 0;
    let mut load = |_: &str| {
        next += 1;
        folder.input(next - 1).map_err(|error| error.to_string())
    };
    let prepared = prepare(&text, &display_name(&path), &mut load).map_err(|errors| refused(&errors))?;
    if prepared.hash != checkpoint.model {
        return Err(Failure::Unusable(format!(
            "{} is not the model of this run any more: put it back, or start anew with `fdem run`",
            display_name(&path)
        )));
    }
    let Checkpoint { frames, history, seconds, state, .. } = checkpoint;
    let step = state.step();
    let simulation =
        Simulation::resume(prepared.model.clone(), state, arguments.options.threads).map_err(|error| {
            Failure::Unusable(format!("{} cannot go on: {error}", display_name(&arguments.folder)))
        })?;
    let recorder = Recorder::going_on(&folder, &prepared, step, frames, history)?;
    let mut going = Going::new(folder, prepared, simulation, recorder, seconds, &arguments.options)?;
    going.told.say(&format!("goes on after step {}", grouped(step)));
    going.go()
}

/// The name of the model with `_results` after it, in the working directory.
fn default_folder(model: &Path) -> PathBuf {
    let mut name = model.file_stem().unwrap_or_default().to_owned();
    name.push("_results");
    PathBuf::from(name)
}

/// A run on its way.
struct Going {
    folder: Folder,
    prepared: Prepared,
    run: Simulation,
    recorder: Recorder,
    told: Told,
    watch: Watch,
    /// Steps in all.
    total: u64,
    /// Between frames and between rows of the history.
    every: [f64; 2],
    /// On the clock, before this part of the run.
    before: f64,
    /// For results.
    output: Duration,
    saved: Instant,
    warned: bool,
}

/// Why a run is over.
enum End {
    Finished,
    /// By this signal.
    Interrupted(i32),
    Stopped(Stop),
}

impl Going {
    fn new(
        folder: Folder,
        mut prepared: Prepared,
        run: Simulation,
        recorder: Recorder,
        before: f64,
        options: &RunOptions,
    ) -> Result<Self, Failure> {
        if let Some(asked) = options.animate {
            prepared.output.animate = asked.or(prepared.output.fields.first().copied());
        }
        let step = run.time_step();
        let total = ((prepared.end_time / step).ceil() as u64).max(1);
        let told = Told::new(&folder, &run, total, options.quiet)?;
        let every = [prepared.output.interval / step, prepared.output.history_interval / step];
        Ok(Self {
            folder,
            prepared,
            run,
            recorder,
            told,
            watch: Watch::new()?,
            total,
            every,
            before,
            output: Duration::ZERO,
            saved: Instant::now(),
            warned: false,
        })
    }

    /// To the end, or as far as it goes.
    fn go(&mut self) -> Result<(), Failure> {
        let end = self.steps()?;
        self.told.end();
        match &end {
            End::Finished | End::Interrupted(_) => self.save()?,
            // What is wrong is shown; the last good checkpoint stays.
            End::Stopped(_) => self.recorder.frame(&self.run)?,
        }
        let status = match &end {
            End::Finished => "finished".to_owned(),
            End::Interrupted(_) => "interrupted".to_owned(),
            End::Stopped(stop) => format!("stopped: {stop}"),
        };
        let start = Instant::now();
        let facts = self.facts(&status);
        let facts: Vec<(&str, &str)> = facts.iter().map(|(name, text)| (*name, text.as_str())).collect();
        self.recorder.finish(&self.prepared, &facts)?;
        self.output += start.elapsed();
        let seconds = self.before + self.told.seconds();
        let json = told::json(&self.run, &self.prepared, &status, seconds, self.output.as_secs_f64());
        self.folder.write(SUMMARY, format!("{json:#}\n").as_bytes())?;
        for (name, text) in &facts {
            self.told.say(&format!("{name:<16} {text}"));
        }
        let place = display_name(&self.folder.path(""));
        match end {
            End::Finished => {
                // A message that nobody can see any more is no failure.
                let _ = writeln!(
                    std::io::stdout(),
                    "results are in {place}: report.html for a browser, results.pvd for ParaView, history.csv, plots"
                );
                Ok(())
            }
            End::Interrupted(signal) => Err(Failure::Interrupted {
                message: format!(
                    "interrupted after step {}; `fdem resume {place}` goes on",
                    self.run.steps()
                ),
                signal,
            }),
            End::Stopped(stop) => Err(Failure::Wrong(format!(
                "{stop}\nthe last frame in {place} shows it; its checkpoint is of before"
            ))),
        }
    }

    fn steps(&mut self) -> Result<End, Failure> {
        let mut slice = 1;
        while self.run.steps() < self.total {
            let step = self.run.steps();
            let [frame, row] = self.every.map(|every| next(step, every));
            let checkpoint = match self.prepared.output.checkpoint {
                When::Steps(every) => next(step, every as f64),
                When::Seconds(_) => u64::MAX,
            };
            // The first row is of the first step: energies are known then.
            let row = if step == 0 { 1 } else { row };
            let stop = frame.min(row).min(checkpoint).min(self.total).min(step + slice);
            let start = Instant::now();
            if let Err(stop) = self.run.advance(stop - step) {
                return Ok(End::Stopped(stop));
            }
            slice = steps_for(SLICE, start.elapsed(), stop - step, slice);
            let step = stop;
            let start = Instant::now();
            if step == row || step == self.total {
                self.recorder.row(&self.run, &self.prepared)?;
            }
            if step == frame || step == self.total {
                self.recorder.frame(&self.run)?;
            }
            let due = match self.prepared.output.checkpoint {
                When::Steps(_) => step == checkpoint,
                When::Seconds(seconds) => self.saved.elapsed().as_secs_f64() >= seconds,
            };
            if due {
                self.save()?;
            }
            self.output += start.elapsed();
            self.told.show(&self.run);
            self.warn();
            if let Some(signal) = self.watch.signal() {
                return Ok(End::Interrupted(signal));
            }
        }
        Ok(End::Finished)
    }

    /// Once, of contacts that are too soft.
    fn warn(&mut self) {
        if let Some(element) = self.run.penetrated().filter(|_| !self.warned) {
            self.warned = true;
            self.told.say(&format!(
                "warning: at step {} element {element} and another overlap to a centroid: contacts are too soft; raise [contact] penalty",
                self.run.steps()
            ));
        }
    }

    /// Where the run stands, on the disk.
    fn save(&mut self) -> Result<(), Failure> {
        self.recorder.flush()?;
        self.folder.save(&Checkpoint {
            model: self.prepared.hash.clone(),
            frames: self.recorder.frames.clone(),
            history: self.recorder.length()?,
            seconds: self.before + self.told.seconds(),
            state: self.run.state(),
        })?;
        self.saved = Instant::now();
        Ok(())
    }

    /// The run in a few lines.
    fn facts(&self, status: &str) -> Vec<(&'static str, String)> {
        let run = &self.run;
        let (counts, energies) = (run.counts(), run.energies());
        let elements = run.model().mesh.triangles.len();
        let parts = told::parts(&run.timings());
        let busy: f64 = parts.iter().map(|(_, seconds)| seconds).sum();
        let shares: Vec<String> = parts
            .iter()
            .map(|(name, seconds)| format!("{name} {:.0} %", 100.0 * seconds / busy.max(1e-9)))
            .collect();
        let energy = |name: &str, value: f64| format!("{name} {}", brief(value));
        let cracks: Vec<String> = ["tension", "shear", "both"]
            .into_iter()
            .zip(run.crack_lengths())
            .filter(|(_, length)| *length > 0.0)
            .map(|(name, length)| format!("{} m by {name}", brief(length)))
            .collect();
        vec![
            ("status", status.to_owned()),
            (
                "mesh",
                format!("{} elements, {} nodes", grouped(elements as u64), grouped(counts.nodes as u64)),
            ),
            (
                "time",
                format!(
                    "{} s in {} steps of {} s",
                    brief(run.time()),
                    grouped(run.steps()),
                    brief(run.time_step())
                ),
            ),
            (
                "cracks",
                if cracks.is_empty() {
                    "none".to_owned()
                } else {
                    format!("{} joints broken: {}", grouped(counts.broken as u64), cracks.join(", "))
                },
            ),
            (
                "energies (J)",
                [
                    energy("kinetic", energies.kinetic),
                    energy("strain", energies.strain),
                    energy("contact", energies.contact),
                    energy("friction", energies.friction),
                    energy("cohesive", energies.cohesive),
                    energy("damping", energies.damping),
                    energy("external", energies.external),
                ]
                .join(", "),
            ),
            (
                "balance",
                format!(
                    "{} J, {:.2e} of what has been in the system",
                    brief(energies.balance()),
                    energies.error()
                ),
            ),
            (
                "detection",
                format!(
                    "{} times, {} contacts at the end",
                    grouped(counts.detections),
                    grouped(counts.contacts as u64)
                ),
            ),
            ("run time", format!("{:.1} s on {} threads: {}", busy, run.threads(), shares.join(", "))),
        ]
    }
}

/// The first multiple of an interval after a step, both in steps; intervals need not be whole.
fn next(step: u64, every: f64) -> u64 {
    let every = every.max(1.0);
    let mut count = (step as f64 / every).floor();
    loop {
        let at = (count * every).ceil() as u64;
        if at > step {
            return at;
        }
        count += 1.0;
    }
}

/// How many steps fill a slice of time, if so many took so long.
fn steps_for(slice: Duration, took: Duration, steps: u64, before: u64) -> u64 {
    let fit = slice.as_secs_f64() / (took.as_secs_f64() / steps.max(1) as f64).max(1e-9);
    // Never more than ten times as many at once: the first steps may be quicker than what follows.
    (fit as u64).clamp(1, before.saturating_mul(10))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_are_not_whole_do_not_drift() {
        let mut step = 0;
        for k in 1..1000 {
            step = next(step, 3.7);
            assert_eq!(step, (f64::from(k) * 3.7).ceil() as u64);
        }
        assert_eq!(next(5, 0.01), 6);
    }
}
