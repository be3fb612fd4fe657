//! `fdem run` and `fdem resume` simulate a model and write its results during the run.

mod account;
pub(crate) mod beginning;
pub(crate) mod checkpoint;
pub(crate) mod course;
mod earlier;
mod emission;
mod engine;
pub(crate) mod folder;
pub(crate) mod frame_files;
pub(crate) mod intact;
mod log;
mod manifest;
mod observer;
mod fluid;
mod pores;
mod quasi_static;
mod ranks;
mod recorder;
pub(crate) mod results;
mod stages;
mod summary;
pub(crate) mod watch;
mod writer;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fdem_distributed::Communicator;
use fdem_io::numbers::{brief, grouped};
use fdem_results::{CurveFigures, Fragments, History, Inertia, Row, inertia};
use fdem_simulation::Stop;
use serde_json::Value;

use crate::command::args::{ResumeArguments, RunArguments, RunOptions};
use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::model_file::{inputs_of, read_text, refused, with_settings};
use crate::command::output::print;
use crate::command::progress::Progress;
use crate::command::rehearsal::rehearse;
use account::{Account, Spent};
use checkpoint::Checkpoint;
use course::{Course, Start, next};
use emission::Emission;
use engine::Engine;
use fdem_model::{AnyPrepared, Checkpoint as When, Preflight, Prepared, Reached};
use fdem_model::{open_from_start, prepare_any, steps, with_end_time};
use fluid::RunFluid;
use folder::{EVENTS, Folder, MODEL, SUMMARY, SavedState};
use intact::Intact;
use log::RunLog;
use pores::RunPores;
use quasi_static::QuasiStatic;
use ranks::RunRanks;
use recorder::Recorder;
use results::Results;
use watch::Watch;
use writer::{Then, Writer, WriterTask};

/// Time between two looks at the clock and for signals.
const SLICE: Duration = Duration::from_millis(100);

/// Overlap of a sphere over a radius from which on a run warns.
const TOO_DEEP: f64 = 0.25;

/// Rows of the history that are handed to the writer together, where it has time for them.
const SOME: usize = 64;

/// Rows for which the run waits for the writer.
const MANY: usize = 10_000;

/// Runs a model. On several ranks, rank 0 does this, and the others follow it.
pub(crate) fn run(arguments: &RunArguments, ranks: Option<&dyn Communicator>) -> Result<(), Failure> {
    let watch = Watch::new()?;
    let Some(lead) = RunRanks::of(ranks, &watch, &arguments.options)? else { return Ok(()) };
    let path = &arguments.model;
    let text = with_settings(read_text(path)?, path, &arguments.set)?;
    let target = arguments.output.clone().unwrap_or_else(|| default_folder(path));
    Folder::check(&target, arguments.force)?;
    let mut inputs = Vec::new();
    let mut read = inputs_of(path);
    let mut load = |file: &str| {
        let bytes = read(file)?;
        inputs.push(bytes.clone());
        Ok(bytes)
    };
    let progress = Progress::new(arguments.options.quiet);
    let (prepared, _) = progress.step("meshing the model", None, |_| {
        prepare_any(&text, &display_name(path), &mut load, memory::free())
    });
    match prepared.map_err(|errors| refused(&errors))? {
        AnyPrepared::Plane(prepared) => begin(arguments, &target, &text, &inputs, *prepared, watch, lead),
        AnyPrepared::Space(prepared) => begin(arguments, &target, &text, &inputs, *prepared, watch, lead),
    }
}

/// A run that takes less, s, is not rehearsed before it begins.
const REHEARSED: f64 = 60.0;

/// Begins the run of a model.
fn begin<const D: usize, const N: usize>(
    arguments: &RunArguments,
    target: &Path,
    text: &str,
    inputs: &[Vec<u8>],
    prepared: Prepared<D, N>,
    watch: Watch,
    lead: RunRanks<'_>,
) -> Result<(), Failure>
where
    [[f64; D]; N]: Results<D, N>,
{
    let path = &arguments.model;
    let progress = Progress::new(arguments.options.quiet);
    let unusable = |why: String| Failure::Unusable(format!("{} cannot run: {why}", display_name(path)));
    let start = Start::new(prepared, arguments.from.as_deref());
    let mut start = start.map_err(|error| error.of(&display_name(path)))?;
    lead.check(&start).map_err(unusable)?;
    // The estimates use a separate simulation, which is dropped before the simulation of the run is made.
    let (ready, _) = progress.step("preparing the run", None, |_| {
        let preflight = Preflight::of(&start.prepared)?;
        let (mut simulation, told) = start.simulation(lead.threads)?;
        lead.put_on_device(&mut simulation)?;
        Ok((preflight, simulation, told))
    });
    let (mut preflight, simulation, taken) = ready.map_err(unusable)?;
    if preflight.seconds_whole > REHEARSED && arguments.from.is_none() {
        rehearse(&mut preflight, &start.prepared, (path, text), &progress);
    }
    let folder = Folder::create(target, arguments.force, text.as_bytes(), inputs)?;
    let recorder = Recorder::new(&folder, &start.prepared, inputs)?;
    let simulation = lead.distribute(simulation).map_err(unusable)?;
    let before = Before {
        account: Account::default(),
        intervals: [start.prepared.output.interval, start.prepared.output.history_interval],
        reached: Reached::default(),
        damaged: Vec::new(),
    };
    let mut running = Running::new(folder, start, simulation, recorder, before, &arguments.options, watch)?;
    let preflight = preflight.to_string();
    for line in preflight.lines().chain(taken.iter().map(String::as_str)) {
        running.told.say(line);
    }
    running.frame(false)?;
    // From here on the run can be resumed.
    running.save()?;
    running.go()
}

/// Continues a run and drives it in the same way.
pub(crate) fn resume(arguments: &ResumeArguments, ranks: Option<&dyn Communicator>) -> Result<(), Failure> {
    let watch = Watch::new()?;
    let Some(lead) = RunRanks::of(ranks, &watch, &arguments.options)? else { return Ok(()) };
    let (folder, saved) = Folder::open(&arguments.folder)?;
    let progress = Progress::new(arguments.options.quiet);
    let (intact, _) =
        progress.step("checking the results", None, |_| Intact::check(&folder, &saved.manifest));
    let intact = intact?;
    let path = folder.path(MODEL);
    let mut text = read_text(&path)?;
    if let Some(end) = arguments.end_time {
        text = with_end_time(&text, end).ok_or_else(|| {
            Failure::Unusable(format!("{} has no end_time that could be changed", display_name(&path)))
        })?;
    }
    let (prepared, _) = progress.step("meshing the model", None, |_| folder.prepared(&text));
    let earlier = Earlier { folder, saved, intact };
    match prepared.map_err(|errors| refused(&errors))?.0 {
        AnyPrepared::Plane(prepared) => go_on(arguments, earlier, &text, *prepared, watch, lead),
        AnyPrepared::Space(prepared) => go_on(arguments, earlier, &text, *prepared, watch, lead),
    }
}

/// A run that continues.
struct Earlier {
    folder: Folder,
    saved: SavedState,
    intact: Intact,
}

/// Continues the run of a model.
fn go_on<const D: usize, const N: usize>(
    arguments: &ResumeArguments,
    Earlier { folder, saved, intact }: Earlier,
    text: &str,
    prepared: Prepared<D, N>,
    watch: Watch,
    lead: RunRanks<'_>,
) -> Result<(), Failure>
where
    [[f64; D]; N]: Results<D, N>,
{
    let place = display_name(&arguments.folder);
    let path = folder.path(MODEL);
    let progress = Progress::new(arguments.options.quiet);
    let checkpoint = saved.open()?;
    if prepared.hash != checkpoint.model {
        return Err(Failure::Unusable(format!(
            "{} has changed since this run: restore it, or start a new run with `fdem run`. Only end_time may change",
            display_name(&path)
        )));
    }
    let Checkpoint::<D, N> { intervals, entered, reached, begun, account, state, .. } = checkpoint;
    let step = state.step();
    let unusable = |why: String| Failure::Unusable(format!("{place} cannot continue: {why}"));
    let start = Start::again(prepared, begun, entered).map_err(unusable)?;
    lead.check(&start).map_err(unusable)?;
    let prepared = &start.prepared;
    let (simulation, _) = progress.step("preparing the run", None, |_| start.resumed(state, lead.threads));
    let mut simulation = simulation.map_err(|error| unusable(error.to_string()))?;
    let (_, steps) = steps(prepared, simulation.critical_step().step).map_err(unusable)?;
    if steps < step {
        return Err(unusable(format!(
            "it has reached {} s, but its end_time is {} s",
            brief(simulation.time()),
            brief(prepared.end_time)
        )));
    }
    let is_over = steps == step || reached.over;
    if is_over && intact.is_whole() && arguments.options.animate.is_none() && folder.is_finished(step) {
        return print(&format!(
            "nothing to do: the run in {place} is finished, {} s in {} steps{}\n",
            brief(simulation.time()),
            grouped(step),
            if reached.over {
                ": its condition was met, or its last stage is over; `fdem run --from` begins with its end"
            } else {
                "; --end-time makes it longer"
            }
        ));
    }
    lead.put_on_device(&mut simulation).map_err(unusable)?;
    let recorder = Recorder::going_on(&folder, prepared, &saved.manifest, &intact)?;
    if arguments.end_time.is_some() {
        folder.write(MODEL, text.as_bytes())?;
    }
    let simulation = lead.distribute(simulation).map_err(unusable)?;
    let before = Before { account, intervals, reached, damaged: intact.damaged };
    let mut running = Running::new(folder, start, simulation, recorder, before, &arguments.options, watch)?;
    for name in &running.before.damaged {
        let place = display_name(&running.folder.path(name));
        running.told.say(&format!("warning: {place} is not as the checkpoint has it, and is made again"));
    }
    running.told.say(&format!("continues after step {}", grouped(step)));
    running.go()
}

/// Returns the default folder: the name of the model with `_results` after it, in the working directory.
fn default_folder(model: &Path) -> PathBuf {
    let mut name = model.file_stem().unwrap_or_default().to_owned();
    name.push("_results");
    PathBuf::from(name)
}

/// Account, intervals and conditions that a resumed run takes over, besides its state.
struct Before {
    account: Account,
    /// Time between frames and time between rows of the history, s.
    intervals: [f64; 2],
    reached: Reached,
    /// Names of damaged files that are made again.
    damaged: Vec<String>,
}

/// A simulation with its folder, its records and its progress.
struct Running<'c, const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    folder: Folder,
    course: Course<dyn Engine<D, N> + 'c, D, N>,
    /// Rows of the history on their way to the writer.
    rows: Vec<Row>,
    writer: Writer<D, N>,
    /// Number of frames that have been handed to the writer.
    frames: usize,
    /// Step of the last of them.
    framed: Option<u64>,
    told: RunLog,
    watch: Watch,
    before: Before,
    /// Steps of the whole run.
    total: u64,
    /// Time that results have taken in this part of the run.
    spent: Spent,
    saved: Instant,
    /// Whether contacts of bodies, and those of spheres, have been found too soft.
    warned: [bool; 2],
    quiet: bool,
    /// The share of inertia in the peak of the load, once the run has ended.
    inertia: Option<Inertia>,
    /// Peaks and moduli of the curves, once the run has ended.
    curves: Vec<CurveFigures>,
    /// Curves without values that are not optional, and why.
    empty_curves: Vec<(String, String)>,
    /// Acoustic emission of the run, once it has ended.
    emission: Option<Emission>,
    /// Whether the run was quasi-static, once it has ended.
    quasi_static: Option<QuasiStatic>,
    fluid: Option<RunFluid>,
    pores: Option<RunPores>,
}

/// How the steps of a run ended.
enum End {
    Finished,
    /// The run was interrupted by this signal.
    Interrupted(i32),
    Stopped(Stop),
}

impl<'c, const D: usize, const N: usize> Running<'c, D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    fn new(
        folder: Folder,
        mut start: Start<D, N>,
        run: Box<dyn Engine<D, N> + 'c>,
        mut recorder: Recorder<D, N>,
        before: Before,
        options: &RunOptions,
        watch: Watch,
    ) -> Result<Self, Failure> {
        watch.begin();
        let output = &mut start.prepared.output;
        if let Some(asked) = options.animate {
            output.animate = asked.or(output.fields.first().copied());
        }
        let course = Course::new(start, run, before.intervals[1], before.reached, true)?;
        let total = course.total();
        if !before.damaged.is_empty() {
            let (snapshot, forces) = course.frame();
            recorder.repair(&before.damaged, &snapshot, &forces)?;
        }
        Ok(Self {
            told: RunLog::new(&folder, &*course.run, total, options.quiet)?,
            folder,
            course,
            rows: Vec::new(),
            framed: recorder.last_frame(),
            frames: recorder.frames(),
            writer: Writer::start(recorder)?,
            watch,
            total,
            before,
            spent: Spent::default(),
            saved: Instant::now(),
            warned: [false; 2],
            quiet: options.quiet,
            inertia: None,
            curves: Vec::new(),
            empty_curves: Vec::new(),
            emission: None,
            quasi_static: None,
            fluid: None,
            pores: None,
        })
    }

    /// Finds the figures of the curves, and the curves without values that are not optional, of which it
    /// warns once the run is `finished`.
    fn look_at_curves(&mut self, history: &History, finished: bool) {
        let curves = &self.course.prepared.curves;
        self.curves = curves.iter().filter_map(|curve| curve.figures(history)).collect();
        let needed = curves.iter().filter(|curve| !curve.optional);
        self.empty_curves =
            needed.filter_map(|curve| Some((curve.name.clone(), curve.why_empty(history)?))).collect();
        for (name, why) in self.empty_curves.iter().filter(|_| finished) {
            self.told.say(&format!("warning: the curve \"{name}\" is empty: {why}"));
        }
    }

    /// Runs to the end, or until the run is interrupted or stops. Draws the results recorded so far.
    fn go(&mut self) -> Result<(), Failure> {
        let (end, mut recorder) = self.recorded().inspect_err(|failure| {
            // The disk may be full: then the summary cannot be written either.
            let _ = self.summarise(&format!("stopped: {failure}"));
        })?;
        self.told.end();
        let status = match &end {
            End::Finished => "finished".to_owned(),
            End::Interrupted(_) => "interrupted".to_owned(),
            End::Stopped(stop) => format!("stopped: {stop}"),
        };
        if let End::Interrupted(_) = end {
            // A launcher may give little time: the message comes before the drawings.
            self.told.say(&format!(
                "interrupted after step {}; the checkpoint is written",
                self.course.run.steps()
            ));
        }
        if matches!(end, End::Finished) {
            for warning in self.course.unmet() {
                self.told.say(&format!("warning: {warning}"));
            }
        }
        let history = recorder.history()?;
        self.look_at_curves(&history, matches!(end, End::Finished));
        // The kinetic energy is that of spheres, too.
        let has_spheres = self.course.prepared.model.grains.is_some();
        self.inertia = if has_spheres { None } else { inertia(&history) };
        self.quasi_static = QuasiStatic::of(&self.course.prepared, &history);
        if let Some(warning) = self.quasi_static.as_ref().and_then(QuasiStatic::warning) {
            self.told.say(&warning);
        }
        self.fluid = RunFluid::of(&*self.course.run, &self.course.prepared, &history);
        if let Some(warning) = self.fluid.as_ref().and_then(RunFluid::warning) {
            self.told.say(&warning);
        }
        self.pores = RunPores::of(&*self.course.run, &self.course.prepared);
        self.emission = Emission::of(&*self.course.run, &self.course.prepared);
        if let Some(emission) = &self.emission {
            recorder.table(EVENTS, emission.csv.as_bytes())?;
        }
        // The summary is written before the drawings, so that it shows how the run ended even if drawing
        // fails. Without a report, `fdem resume` draws again.
        self.folder.remove_report();
        self.summarise(&status)?;
        let fragments = self.course.observer.fragments(&*self.course.run)?;
        let facts = self.facts(&status, &fragments);
        let drawn = self.draw(&mut recorder, &facts, &fragments);
        if !matches!(end, End::Stopped(_)) {
            // The checkpoint is written again, so that its account has the time for drawing.
            recorder.save(&self.state())?;
        }
        self.summarise(&status)?;
        for (name, text) in &facts {
            self.told.say(&format!("{name:<16} {text}"));
        }
        drawn?;
        let place = display_name(&self.folder.path(""));
        match end {
            End::Finished => {
                let model = &self.course.prepared.model;
                let collections = match (model.mesh.elements.is_empty(), model.grains.is_some()) {
                    (true, _) => "spheres.pvd",
                    (false, true) => "results.pvd and spheres.pvd",
                    (false, false) => "results.pvd",
                };
                print(&format!(
                    "results are in {place}: report.html for a browser, {collections} for ParaView, history.csv, plots\n"
                ))
            }
            End::Interrupted(signal) => Err(Failure::Interrupted {
                message: format!(
                    "interrupted after step {}; `fdem resume {place}` continues the run",
                    self.course.run.steps()
                ),
                signal,
            }),
            End::Stopped(stop @ Stop::Device(_)) => Err(Failure::Wrong(format!(
                "{stop}\n`fdem resume {place}` continues the run from its last checkpoint, on this device or without it"
            ))),
            End::Stopped(stop) => Err(Failure::Wrong(format!(
                "{stop}\n{}the last frame in {place} shows this state; the checkpoint is from an earlier step",
                self.possible_causes()
            ))),
        }
    }

    /// The warnings of the model, which may say why a run has stopped; they were printed at its beginning.
    fn possible_causes(&self) -> String {
        let warnings = &self.course.prepared.warnings;
        if warnings.is_empty() {
            return String::new();
        }
        format!("the check of the model has warned of possible causes:\n  {}\n", warnings.join("\n  "))
    }

    /// Runs to the end, or until the run is interrupted or stops, and waits until frames, history and
    /// checkpoint are on the disk.
    fn recorded(&mut self) -> Result<(End, Recorder<D, N>), Failure> {
        let mut end = self.steps()?;
        // Nothing of a device that fails is written. The checks during the run do not include its last step.
        let settled = self.course.run.settle();
        if !matches!(end, End::Stopped(_))
            && let Err(stop) = settled.clone().and_then(|()| self.course.run.check_balance())
        {
            end = End::Stopped(stop);
        }
        match &end {
            End::Finished => self.save()?,
            End::Interrupted(_) => {
                self.save()?;
                // A resume removes this frame, so that the frames are those of a run without interruption.
                if self.framed != Some(self.course.run.steps()) {
                    self.frame(true)?;
                }
            }
            // The frame shows the reason. The last good checkpoint is kept.
            // The state of a device that has failed is lost.
            End::Stopped(Stop::Device(_)) => {}
            End::Stopped(_) if settled.is_err() => {}
            End::Stopped(_) if self.framed == Some(self.course.run.steps()) => {}
            End::Stopped(_) => self.frame(false)?,
        }
        let start = Instant::now();
        let recorder = self.writer.finish()?;
        self.spent.output += start.elapsed();
        Ok((end, recorder))
    }

    fn steps(&mut self) -> Result<End, Failure> {
        let mut slice = 1;
        let frames = self.before.intervals[0] / self.course.run.time_step();
        while !self.course.is_over() {
            let step = self.course.run.steps();
            let frame = next(step, frames);
            let checkpoint = match self.course.prepared.output.checkpoint {
                When::Steps(every) => next(step, every as f64),
                When::Seconds(_) => u64::MAX,
            };
            let start = Instant::now();
            let limit = frame.min(checkpoint).min(self.total).min(step + slice);
            let passed = match self.course.advance(limit) {
                Ok(passed) => passed,
                Err(stop) => return Ok(End::Stopped(stop)),
            };
            let now = self.course.run.steps();
            slice = steps_for(SLICE, start.elapsed(), now - step, slice);
            let start = Instant::now();
            self.rows.extend_from_slice(&passed.rows);
            if !passed.rows.is_empty() {
                self.offer_rows()?;
            }
            self.spent.output += start.elapsed();
            if now == frame || now == self.total {
                if let Err(stop) = self.course.run.settle() {
                    return Ok(End::Stopped(stop));
                }
                self.frame(false)?;
            }
            let turned = self.course.turn(&passed)?;
            if turned.entered {
                self.hand(Then::Outlines(<[[f64; D]; N]>::outlines(&self.course.prepared)))?;
            }
            for line in &turned.told {
                self.told.say(line);
            }
            if self.course.reached.over && now != frame && now != self.total {
                if let Err(stop) = self.course.run.settle() {
                    return Ok(End::Stopped(stop));
                }
                self.frame(false)?;
            }
            let due = match self.course.prepared.output.checkpoint {
                When::Steps(_) => now == checkpoint,
                // It may come later, so that the steps need not wait for a writer that is behind, but not by
                // more than another interval.
                When::Seconds(seconds) => {
                    let since = self.saved.elapsed().as_secs_f64();
                    since >= seconds && (self.writer.has_room() || since >= 2.0 * seconds)
                }
            };
            // At the end, the checkpoint is written after the last check.
            if due && !self.course.is_over() {
                if let Err(stop) = self.course.run.settle() {
                    return Ok(End::Stopped(stop));
                }
                self.save()?;
            }
            self.writer.check()?;
            self.told.show(&*self.course.run);
            self.warn();
            if let Some(signal) = self.watch.signal() {
                return Ok(End::Interrupted(signal));
            }
        }
        Ok(End::Finished)
    }

    /// Hands rows to the writer if it has time for them, and waits for it if there are many.
    fn offer_rows(&mut self) -> Result<(), Failure> {
        if self.rows.len() >= MANY {
            return self.hand(Then::Nothing);
        }
        if self.rows.len() >= SOME {
            let rows = std::mem::take(&mut self.rows);
            if let Some(task) = self.writer.offer(WriterTask { rows, then: Then::Nothing })? {
                self.rows = task.rows;
            }
        }
        Ok(())
    }

    /// Hands all rows to the writer, and a frame or a checkpoint after them.
    fn hand(&mut self, then: Then<D, N>) -> Result<(), Failure> {
        self.writer.send(WriterTask { rows: std::mem::take(&mut self.rows), then })
    }

    /// Hands a frame to the writer, after the rows before it. `between`: it shows the state of an interrupted
    /// run between two frames.
    fn frame(&mut self, between: bool) -> Result<(), Failure> {
        let start = Instant::now();
        self.told.does(&format!("writing frame {}", self.frames));
        let frame = self.course.frame();
        self.framed = Some(frame.0.step);
        let frame = Box::new(frame);
        self.hand(if between { Then::LastState(frame) } else { Then::Frame(frame) })?;
        self.frames += 1;
        self.spent.output += start.elapsed();
        Ok(())
    }

    /// Draws the plots, the picture, the animation and the report.
    fn draw(
        &mut self,
        recorder: &mut Recorder<D, N>,
        facts: &[(&str, String)],
        fragments: &Fragments<D>,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let facts: Vec<(&str, &str)> = facts.iter().map(|(name, text)| (*name, text.as_str())).collect();
        let ranks = ranks::plots(&self.course.run.traffic());
        let emitted = self.emission.as_ref().and_then(|emission| emission.plot.clone());
        let progress = Progress::new(self.quiet);
        let (drawn, _) = progress.step("reading frames, drawing plots and the report", None, |done| {
            recorder.finish(&self.course.prepared, &facts, (emitted, ranks), fragments, done)
        });
        self.spent.drawing += start.elapsed();
        drawn
    }

    /// Writes `run.json`.
    fn summarise(&self, status: &str) -> Result<(), Failure> {
        let fragments = self.course.observer.fragments(&*self.course.run)?;
        let mut json = log::json(
            &*self.course.run,
            &self.course.prepared,
            status,
            &self.account(),
            self.frames,
            &fragments,
        );
        if let Some(stages) = &self.course.stages {
            json["stages"] = stages.json();
        }
        let until = self.course.prepared.until.as_ref();
        json["until_met"] = until.map_or(Value::Null, |_| Value::Bool(self.course.reached.met));
        json["acoustic_emission"] = self.emission.as_ref().map_or(Value::Null, Emission::json);
        json["mass_scaling"] = self.quasi_static.as_ref().map_or(Value::Null, QuasiStatic::json);
        if let Some(fluid) = &self.fluid {
            json["fluid"] = fluid.json();
        }
        if let Some(pores) = &self.pores {
            json["pores"] = pores.json();
        }
        json["inertia"] = self.inertia.as_ref().map_or(Value::Null, log::inertia);
        let empty = self.empty_curves.iter().map(|(name, why)| log::empty_curve(name, why));
        json["curves"] = self.curves.iter().map(log::curve).chain(empty).collect();
        self.folder.write(SUMMARY, format!("{json:#}\n").as_bytes())
    }

    /// The account of the whole run until now.
    fn account(&self) -> Account {
        let detections = self.course.run.counts().detections;
        self.before.account.and(self.course.run.timings(), detections, self.told.elapsed(), &self.spent)
    }

    /// Warns once of contacts that are too soft.
    fn warn(&mut self) {
        if let Some([one, other]) = self.course.run.penetrated().filter(|_| !self.warned[0]) {
            self.warned[0] = true;
            self.told.say(&format!(
                "warning: at step {} elements {one} and {other} overlap up to the centroid of one: contacts are too soft, unless these bodies overlapped at the beginning; increase penalty in [contact]",
                self.course.run.steps()
            ));
        }
        let deepest = self.course.run.deepest_overlap().filter(|(share, _)| *share > TOO_DEEP);
        if let Some((share, sphere)) = deepest.filter(|_| !self.warned[1]) {
            self.warned[1] = true;
            self.told.say(&format!(
                "warning: up to step {} sphere {sphere} has overlapped by {:.0} % of a radius: its contacts are too soft for its speed or its load; increase youngs_modulus, or the stiffness in [spheres]",
                self.course.run.steps(),
                100.0 * share
            ));
        }
    }

    /// Hands a checkpoint to the writer, after the rows before it.
    fn save(&mut self) -> Result<(), Failure> {
        let start = Instant::now();
        self.told.does("writing a checkpoint");
        self.spent.checkpoints += 1;
        self.hand(Then::Checkpoint(Box::new(self.state())))?;
        self.saved = Instant::now();
        self.spent.output += start.elapsed();
        Ok(())
    }

    /// The state of the run, for a checkpoint.
    fn state(&self) -> Checkpoint<D, N> {
        Checkpoint {
            model: self.course.prepared.hash.clone(),
            intervals: self.before.intervals,
            reached: self.course.reached,
            begun: self.course.begun.clone(),
            entered: self.course.entered(),
            account: self.account(),
            state: self.course.run.state(),
        }
    }

    /// The summary of the run: names and texts of its lines.
    fn facts(&self, status: &str, fragments: &Fragments<D>) -> Vec<(&'static str, String)> {
        let mut more = Vec::new();
        more.extend(self.fluid.as_ref().map(|fluid| ("fluid", fluid.in_words())));
        more.extend(self.pores.as_ref().map(|pores| ("pores", pores.in_words())));
        more.extend(self.emission.as_ref().map(|emission| ("emission", emission.in_words())));
        more.extend(self.quasi_static.as_ref().map(|of_run| ("mass scaling", of_run.in_words())));
        more.extend(self.inertia.as_ref().map(|inertia| ("inertia", log::inertia_in_words(inertia))));
        more.extend(self.curves.iter().map(|curve| ("curve", log::curve_in_words(curve))));
        more.extend(self.empty_curves.iter().map(|(name, why)| ("curve", format!("{name}: {why}"))));
        more.extend(self.course.stages.as_ref().map(|stages| ("stages", stages.in_words())));
        let open = open_from_start(&self.course.prepared.joint_sets);
        summary::summary(&*self.course.run, status, &self.account(), self.frames, fragments, open, more)
    }
}

/// Number of steps that fill a slice of time, where `steps` steps took the time `took`.
fn steps_for(slice: Duration, took: Duration, steps: u64, before: u64) -> u64 {
    let fit = slice.as_secs_f64() / (took.as_secs_f64() / steps.max(1) as f64).max(1e-9);
    // At most ten times the number before: the first steps may be quicker than later ones.
    (fit as u64).clamp(1, before.saturating_mul(10))
}
