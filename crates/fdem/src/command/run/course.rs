//! The course of a run: its steps, and the changes that its model makes between them: stages, conditions and
//! servos.
//!
//! `fdem run` and a program that holds a run take the same course, so that both reach the same bits.

use std::path::Path;

use fdem_io::numbers::{brief, grouped};
use fdem_results::Row;
use fdem_simulation::{Forces, Model, ModelError, Simulation, Snapshot, State, Stop};

use crate::command::failure::Failure;
use crate::command::run::beginning::Beginning;
use crate::command::run::earlier::EarlierRun;
use crate::command::run::engine::Engine;
use crate::command::run::observer::Observer;
use crate::command::run::results::Results;
use crate::command::run::stages::{Stages, StepState};
use fdem_model::{Entered, Prepared, Quantity, Reached};

/// A run before its first step, or at the point where it continues.
pub(crate) struct Start<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Bodies, boundaries and histories of the stage in which it starts.
    pub(crate) prepared: Prepared<D, N>,
    /// `None` if the run is one.
    pub(crate) stages: Option<Stages<D, N>>,
    /// When it has begun from another run.
    pub(crate) begun: Option<Beginning>,
    earlier: Option<EarlierRun<D, N>>,
}

impl<const D: usize, const N: usize> Start<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// The start of a new run of a model, or of one that begins with the end of the run in a folder.
    pub(crate) fn new(mut prepared: Prepared<D, N>, from: Option<&Path>) -> Result<Self, StartError> {
        let earlier = from.map(EarlierRun::open).transpose().map_err(StartError::From)?;
        let begun = earlier.as_ref().map(|earlier| earlier.begun(&prepared)).transpose()?;
        let mut entered = Entered::first();
        if let Some(begun) = &begun {
            begun.apply(&mut prepared.model);
            entered.begun = vec![begun.step];
        }
        let (stages, prepared) = Stages::new(prepared, entered)?;
        Ok(Self { prepared, stages, begun, earlier })
    }

    /// The start of a run that continues.
    pub(crate) fn again(
        mut prepared: Prepared<D, N>,
        begun: Option<Beginning>,
        entered: Entered<D>,
    ) -> Result<Self, String> {
        if let Some(begun) = &begun {
            begun.apply(&mut prepared.model);
        }
        let (stages, prepared) = Stages::new(prepared, entered)?;
        Ok(Self { prepared, stages, begun, earlier: None })
    }

    /// The simulation of a new run, and the parts that it takes over from the earlier one, in words.
    pub(crate) fn simulation(&mut self, threads: usize) -> Result<(Simulation<D, N>, Vec<String>), String> {
        let wrong = |error: ModelError| error.to_string();
        let Some(earlier) = self.earlier.take() else {
            return Ok((Simulation::new(self.prepared.model.clone(), threads).map_err(wrong)?, Vec::new()));
        };
        let (model, state, told) = earlier.taken_over(&self.prepared, threads)?;
        self.prepared.model = model;
        let run = self.resumed(state, threads).map_err(wrong)?;
        if let Some(stages) = &mut self.stages {
            stages.set_back(&run);
        }
        Ok((run, told))
    }

    /// The simulation of a run that continues with a state.
    pub(crate) fn resumed(&self, state: State<D, N>, threads: usize) -> Result<Simulation<D, N>, ModelError> {
        let model: Model<D, N> = self.prepared.model.clone();
        Simulation::resume(model, state, threads)
    }
}

/// Why a run cannot start.
pub(crate) enum StartError {
    /// The model cannot run, for this reason.
    Model(String),
    /// The run with which it would begin cannot be opened.
    From(Failure),
}

impl From<String> for StartError {
    fn from(why: String) -> Self {
        Self::Model(why)
    }
}

impl StartError {
    /// The failure of a run of the model of this name.
    pub(crate) fn of(self, name: &str) -> Failure {
        match self {
            Self::Model(why) => Failure::Unusable(format!("{name} cannot run: {why}")),
            Self::From(failure) => failure,
        }
    }
}

/// A run with all that steers it.
pub(crate) struct Course<E, const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
    E: ?Sized,
{
    /// Bodies, boundaries and histories of the present stage.
    pub(crate) prepared: Prepared<D, N>,
    /// `None` if the run is one.
    pub(crate) stages: Option<Stages<D, N>>,
    /// When it has begun from another run.
    pub(crate) begun: Option<Beginning>,
    /// Peaks of the conditions that end the run and the stage, and whether the run is over.
    pub(crate) reached: Reached,
    pub(crate) run: Box<E>,
    pub(crate) observer: Observer<D>,
    /// Time between rows of the history, s.
    pub(crate) interval: f64,
    /// Whether rows are made where no condition needs them.
    is_recorded: bool,
    /// Conditions and servos whose column is no number, which the log has named.
    blind: Vec<String>,
    /// Bodies that were rigid until they were overloaded, which the log has named.
    released: Vec<u32>,
}

/// A part of a course.
pub(crate) struct Passed {
    /// Rows of the history.
    pub(crate) rows: Vec<Row>,
    /// Numbers of the row at its end, if one is due there.
    due: Option<Vec<f64>>,
}

/// Changes of a run after a part of its course.
#[derive(Default)]
pub(crate) struct Turned {
    /// Lines for the log.
    pub(crate) told: Vec<String>,
    /// Whether another stage has begun.
    pub(crate) entered: bool,
}

impl<E, const D: usize, const N: usize> Course<E, D, N>
where
    [[f64; D]; N]: Results<D, N>,
    E: Engine<D, N> + ?Sized,
{
    /// The course of a run from where it is. `interval`: time between rows of the history, s.
    pub(crate) fn new(
        start: Start<D, N>,
        run: Box<E>,
        interval: f64,
        reached: Reached,
        is_recorded: bool,
    ) -> Result<Self, Failure> {
        let Start { prepared, stages, begun, .. } = start;
        let mut course = Self {
            observer: Observer::new(&prepared, stages.as_ref().and_then(Stages::origin))?,
            prepared,
            stages,
            begun,
            reached,
            interval,
            is_recorded,
            blind: Vec::new(),
            released: run.released_bodies(),
            run,
        };
        if course.run.steps() == 0 {
            // Columns without a number at the beginning are named after the first steps.
            course.control(true, &mut Turned::default())?;
            course.blind.clear();
        }
        Ok(course)
    }

    /// Steps of the whole run, from its beginning to its end time.
    pub(crate) fn total(&self) -> u64 {
        ((self.prepared.end_time / self.run.time_step()).ceil() as u64).max(1)
    }

    /// Whether the run has ended: by its end time, its condition, or its last stage.
    pub(crate) fn is_over(&self) -> bool {
        self.reached.over || self.run.steps() >= self.total()
    }

    /// A snapshot of the run with displacements that count from the last stage that has set them back.
    pub(crate) fn counted(&self, mut snapshot: Snapshot<D, N>) -> Snapshot<D, N> {
        if let Some(origin) = &self.observer.origin {
            origin.subtract_from(&mut snapshot);
        }
        snapshot
    }

    /// The snapshot of a frame, counted in the same way and with the joints that the model asks for, and the
    /// forces at its instant.
    pub(crate) fn frame(&self) -> (Snapshot<D, N>, Forces<D>) {
        let (snapshot, forces) = self.run.frame();
        (self.with_joints(self.counted(snapshot)), forces)
    }

    /// The snapshot with the joints that hold, if the model asks for them.
    pub(crate) fn with_joints(&self, mut snapshot: Snapshot<D, N>) -> Snapshot<D, N> {
        if self.prepared.output.intact_joints {
            snapshot.intact = Some(self.run.intact_joints());
        }
        snapshot
    }

    /// The stages so far; none if the run is one.
    pub(crate) fn entered(&self) -> Entered<D> {
        self.stages.as_ref().map(|stages| stages.entered.clone()).unwrap_or_default()
    }

    /// Takes steps: to this one, or to the next at which something is due, or to the end of the run.
    pub(crate) fn advance(&mut self, limit: u64) -> Result<Passed, Stop> {
        let step = self.run.steps();
        let needs = self.prepared.until.is_some() || self.stages.as_ref().is_some_and(Stages::has_conditions);
        let row = if self.is_recorded || needs {
            next(step, self.interval / self.run.time_step())
        } else {
            u64::MAX
        };
        let opening =
            (self.is_recorded && step == 0).then(|| self.observer.values(&*self.run, &self.prepared));
        // A part that is recorded has one step at first, because the initial forces and energies are known
        // after it.
        let first = if opening.is_some() { 1 } else { u64::MAX };
        let stage = self.stages.as_ref().map_or(u64::MAX, Stages::end);
        let stop = limit.min(row).min(stage).min(self.next_control(step)).min(first);
        self.run.advance(stop - step)?;
        let mut rows = Vec::new();
        if let Some(values) = opening {
            rows.push(self.observer.first_row(&*self.run, &self.prepared, values));
        }
        let mut due = None;
        if stop == row || (self.is_recorded && stop == self.total()) {
            let present = self.observer.row(&*self.run, &self.prepared);
            due = (stop == row).then(|| present.numbers());
            rows.push(present);
        }
        self.run.check_device()?;
        Ok(Passed { rows, due })
    }

    /// Applies the changes of the model after a part: ends the stage and begins the next, ends the run, and
    /// moves servos.
    pub(crate) fn turn(&mut self, passed: &Passed) -> Result<Turned, Failure> {
        let mut turned = Turned::default();
        self.name_released(&mut turned);
        self.go_through_stages(passed.due.as_deref(), &mut turned)?;
        self.end_if_met(passed.due.as_deref(), &mut turned);
        self.control(false, &mut turned)?;
        if let Some(row) = passed.due.as_deref().filter(|_| !turned.entered) {
            self.name_blind_conditions(row, &mut turned);
        }
        Ok(turned)
    }

    /// Names the bodies that are no longer rigid.
    fn name_released(&mut self, turned: &mut Turned) {
        let released = self.run.released_bodies();
        let new = released.iter().filter(|body| !self.released.contains(body));
        let names: Vec<&str> = new.map(|&body| self.prepared.bodies[body as usize].name.as_str()).collect();
        if !names.is_empty() {
            let time = brief(self.run.time());
            turned
                .told
                .push(format!("overloaded until {time} s, deformable from now on: {}", names.join(", ")));
            self.released = released;
        }
    }

    /// Names conditions whose column is no number in a row of the history.
    fn name_blind_conditions(&mut self, row: &[f64], turned: &mut Turned) {
        let of_stage = self.stages.as_ref().map(Stages::now);
        let of_stage =
            of_stage.and_then(|stage| Some((format!("stage \"{}\"", stage.name), stage.until.as_ref()?)));
        let of_run = self.prepared.until.as_ref().map(|until| ("[model]".to_owned(), until));
        for (title, until) in of_run.into_iter().chain(of_stage) {
            if row[until.place].is_nan() {
                let line = format!("until of {title}: {} is not a number, so it cannot be met", until.column);
                name_once(&mut self.blind, turned, line);
            }
        }
    }

    /// Ends the run if its condition is met by a row of the history.
    fn end_if_met(&mut self, row: Option<&[f64]>, turned: &mut Turned) {
        let (Some(until), Some(row)) = (&self.prepared.until, row) else { return };
        if let Some(why) = until.met(row, &mut self.reached.peaks[0]) {
            self.reached.over = true;
            self.reached.met = true;
            turned.told.push(format!("the run ends at {} s: {why}", brief(self.run.time())));
        }
    }

    /// Ends the stage if it is over, and begins the next. `row`: a row of the history of this step, if there
    /// is one.
    fn go_through_stages(&mut self, row: Option<&[f64]>, turned: &mut Turned) -> Result<(), Failure> {
        let Some(stages) = &mut self.stages else { return Ok(()) };
        let peak = &mut self.reached.peaks[1];
        let known = row.map(|row| {
            let (energies, imbalance) = (self.run.energies(), self.run.imbalance());
            StepState { energies, imbalance, row, peak }
        });
        let Some(over) = stages.is_over(self.run.steps(), known) else { return Ok(()) };
        let ended = format!(
            "stage \"{}\" ends at {} s: {}",
            stages.now().name,
            brief(self.run.time()),
            over.in_words()
        );
        if stages.is_last() {
            self.reached.over = true;
            turned.told.push(ended);
            return Ok(());
        }
        self.run.settle().map_err(|stop| Failure::Wrong(stop.to_string()))?;
        let before = self.observer.values(&*self.run, &self.prepared);
        let next = stages.next(&self.prepared, self.run.state(), self.run.threads());
        let (mut prepared, run) =
            next.map_err(|why| Failure::Wrong(format!("{ended}; the next cannot begin: {why}")))?;
        let now = format!("stage \"{}\" begins", stages.now().name);
        self.run.replace(run).map_err(Failure::Unusable)?;
        prepared.output.animate = self.prepared.output.animate;
        self.prepared = prepared;
        self.observer = Observer::new(&self.prepared, stages.origin())?;
        self.reached.peaks[1] = 0.0;
        self.control(true, turned)?;
        turned.told.push(ended);
        turned.told.push(format!("{now} with {} elements", grouped(self.run.elements() as u64)));
        self.name_lost_histories(&before, turned);
        turned.entered = true;
        Ok(())
    }

    /// Names the histories that have lost their values with the part or the boundary that they measure.
    /// `before`: values of each history at the end of the stage before.
    fn name_lost_histories(&self, before: &[Vec<f64>], turned: &mut Turned) {
        let has_values = |values: &Vec<f64>| !values.iter().any(|value| value.is_nan());
        let now = self.observer.values(&*self.run, &self.prepared);
        for ((history, before), now) in self.prepared.histories.iter().zip(before).zip(&now) {
            if has_values(before) && !has_values(now) {
                let why = match history.quantity {
                    Quantity::Force(_) | Quantity::Torque(..) => "its boundary does not act there",
                    _ => "the part that it measures is not there",
                };
                turned.told.push(format!(
                    "warning: [[history]] \"{}\" has NaN from this stage on: {why}",
                    history.name
                ));
            }
        }
    }

    /// The first step after this one at which a servo looks at its column.
    fn next_control(&self, step: u64) -> u64 {
        let steps = self.prepared.servos.iter().map(|servo| u64::from(servo.steps));
        steps.map(|steps| (step / steps + 1).saturating_mul(steps)).min().unwrap_or(u64::MAX)
    }

    /// Sets the velocities of the servos that look at their columns now, or of `all`.
    fn control(&mut self, all: bool, turned: &mut Turned) -> Result<(), Failure> {
        let step = self.run.steps();
        let mut values = None;
        for servo in &self.prepared.servos {
            if !all && !step.is_multiple_of(u64::from(servo.steps)) {
                continue;
            }
            let values =
                values.get_or_insert_with(|| self.observer.values(&*self.run, &self.prepared).concat());
            self.run.check_device().map_err(|stop| Failure::Wrong(stop.to_string()))?;
            let boundary = &self.prepared.model.boundaries[servo.boundary];
            if values[servo.place].is_nan() {
                let line = format!(
                    "the servo \"{}\": its column is not a number, so it does not move",
                    boundary.name
                );
                name_once(&mut self.blind, turned, line);
            }
            let factor = servo.factor(values[servo.place], boundary.schedule.factor(self.run.time()));
            self.run.set_factor(servo.boundary, factor).map_err(Failure::Wrong)?;
        }
        Ok(())
    }

    /// Conditions that were not met, stages that were not reached, and servos that are far from their
    /// targets, in words.
    pub(crate) fn unmet(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(until) = self.prepared.until.as_ref().filter(|_| !self.reached.met) {
            warnings.push(format!("until of [model], on {}, was not met", until.column));
        }
        warnings.extend(self.stages.as_ref().and_then(Stages::unreached));
        let values = self.observer.values(&*self.run, &self.prepared).concat();
        for servo in &self.prepared.servos {
            let boundary = &self.prepared.model.boundaries[servo.boundary];
            let scale = boundary.schedule.factor(self.run.time());
            let found = values[servo.place];
            if found.is_nan() {
                warnings.push(format!(
                    "the servo \"{}\" does not move at the end, because its column is not a number: its part has been removed",
                    boundary.name
                ));
            } else if servo.factor(found, scale).abs() >= 1.0 {
                warnings.push(format!(
                    "the servo \"{}\" has not held its target: {} and not {} at the end; see that its velocity has the right sign, is high enough to get there in time, and not so high that it overshoots",
                    boundary.name,
                    brief(found),
                    brief(servo.target * scale)
                ));
            }
        }
        warnings
    }
}

/// Adds a line to the log unless it is among those of before.
fn name_once(before: &mut Vec<String>, turned: &mut Turned, line: String) {
    if !before.contains(&line) {
        turned.told.push(line.clone());
        before.push(line);
    }
}

/// Returns the first multiple of an interval after a step. The interval is in steps and need not be a whole
/// number.
pub(crate) fn next(step: u64, every: f64) -> u64 {
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
