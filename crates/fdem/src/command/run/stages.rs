//! Stages of a run: when one ends, and how the next begins.

use fdem_io::numbers::brief;
use fdem_simulation::{Change, Energies, Load, Model, Schedule, Simulation, State, Target};
use serde_json::{Value, json};

use crate::command::run::results::Results;
use fdem_model::{Entered, Origin, Prepared, PreparedStage, Present};

/// The stages of a run, one of which it is in.
pub(crate) struct Stages<const D: usize, const N: usize> {
    /// The model with all that is there in any stage.
    whole: Prepared<D, N>,
    pub(crate) entered: Entered<D>,
    /// Bodies, boundaries and histories of the present stage. Its model is that of the run.
    present: Present<D, N>,
    /// Time step, s.
    step: f64,
    /// Time from which an equilibrium counts, s: releases and ramps are over. Before it, a slow beginning
    /// would pass for rest.
    calm: f64,
}

/// The state of a run with a row of its history.
pub(crate) struct StepState<'a> {
    pub(crate) energies: Energies,
    /// Imbalance of forces.
    pub(crate) imbalance: f64,
    /// Numbers of the row.
    pub(crate) row: &'a [f64],
    /// The largest magnitude so far of the column on which the end of the stage depends.
    pub(crate) peak: &'a mut f64,
}

/// Why a stage ends.
pub(crate) enum Over {
    /// Its time has passed. `false`: without the equilibrium or the condition that it was to reach.
    Time(bool),
    /// The condition is met, for this reason.
    Until(String),
    /// Kinetic over strain energy, and imbalance of forces.
    Equilibrium([f64; 2]),
}

impl<const D: usize, const N: usize> Stages<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// The stages of a model, and the parts present in the one that has been `entered`; `None`, and the
    /// unchanged model, if it has none. The time step is the one that is stable in all of them.
    pub(crate) fn new(
        whole: Prepared<D, N>,
        entered: Entered<D>,
    ) -> Result<(Option<Self>, Prepared<D, N>), String> {
        if whole.stages.is_empty() {
            return Ok((None, whole));
        }
        let (whole, first) = whole.in_stages()?;
        let step = first.prepared.model.time.step.unwrap_or_default();
        let present = if entered == Entered::first() {
            first
        } else {
            whole.at(&entered, step).map_err(|error| error.to_string())?
        };
        let prepared = present.prepared.clone();
        let calm = calm(&prepared.model);
        Ok((Some(Self { whole, entered, present, step, calm }), prepared))
    }

    /// Time step, s.
    pub(crate) fn time_step(&self) -> f64 {
        self.step
    }

    /// The stage that the run is in.
    pub(crate) fn now(&self) -> &PreparedStage {
        &self.whole.stages[self.entered.stage()]
    }

    /// Whether the end of the present stage depends on a row of the history.
    pub(crate) fn has_conditions(&self) -> bool {
        self.now().equilibrium.is_some() || self.now().until.is_some()
    }

    /// Step at which the stage ends at the latest.
    pub(crate) fn end(&self) -> u64 {
        let begun = self.entered.begun.last().copied().unwrap_or_default();
        self.now().duration.map_or(u64::MAX, |time| begun + ((time / self.step).ceil() as u64).max(1))
    }

    /// Whether the stage ends after a step. `known`: with a row of the history.
    pub(crate) fn is_over(&self, step: u64, known: Option<StepState<'_>>) -> Option<Over> {
        let begun = self.entered.begun.last().copied().unwrap_or_default();
        let Some(StepState { energies, imbalance, row, peak }) = known.filter(|_| step > begun) else {
            return (step >= self.end()).then(|| self.out_of_time());
        };
        if let Some(bound) = self.now().equilibrium.filter(|_| step as f64 * self.step >= self.calm) {
            let share = energies.kinetic / energies.strain;
            // Without any force nothing moves.
            if [share, imbalance].iter().all(|number| number.is_nan() || *number < bound) {
                return Some(Over::Equilibrium([share, imbalance]));
            }
        }
        if let Some(why) = self.now().until.as_ref().and_then(|until| until.met(row, peak)) {
            return Some(Over::Until(why));
        }
        (step >= self.end()).then(|| self.out_of_time())
    }

    /// The end of a stage whose time has passed.
    fn out_of_time(&self) -> Over {
        Over::Time(self.now().equilibrium.is_none() && self.now().until.is_none())
    }

    /// Whether the stage is the last.
    pub(crate) fn is_last(&self) -> bool {
        self.entered.stage() + 1 == self.whole.stages.len()
    }

    /// Says which stage was not reached, if one was not.
    pub(crate) fn unreached(&self) -> Option<String> {
        let next = self.whole.stages.get(self.entered.stage() + 1)?;
        Some(format!("the run ended before the stage \"{}\"", next.name))
    }

    /// Enters the next stage with a run that is in a state after a step. Returns the parts that are present,
    /// and the continued run.
    pub(crate) fn next(
        &mut self,
        before: &Prepared<D, N>,
        state: State<D, N>,
        threads: usize,
    ) -> Result<(Prepared<D, N>, Simulation<D, N>), String> {
        let mut entered = self.entered.clone();
        entered.begun.push(state.step());
        if let Some(release) = &self.whole.stages[entered.stage()].release {
            // The remaining forces of earlier stages are released too, from their present value.
            let now = state.step() as f64 * self.step;
            for boundary in &mut entered.held {
                let factor = boundary.schedule.factor(now);
                if let Target::Held(_, forces) = &mut boundary.target {
                    for force in forces.as_flattened_mut().as_flattened_mut() {
                        *force *= factor;
                    }
                }
                boundary.schedule = Schedule::From(now, Box::new(release.clone()));
            }
        }
        let wrong = |error: fdem_simulation::ModelError| error.to_string();
        let mut next = self.whole.at(&entered, self.step).map_err(wrong)?;
        let earlier = |element: &u32| {
            let place = self.present.elements.binary_search(element).ok();
            place.map(|place| place as u32)
        };
        let stage = &self.whole.stages[entered.stage()];
        let change = Change {
            model: next.prepared.model.clone(),
            elements: next.elements.iter().map(earlier).collect(),
            release: stage.release.clone().map(|release| (format!("released in {}", stage.name), release)),
        };
        let (model, state) = state.changed(&before.model, change, threads).map_err(wrong)?;
        entered.held = next.held(&model.boundaries);
        next.prepared.model = model;
        let run = Simulation::resume(next.prepared.model.clone(), state, threads).map_err(wrong)?;
        self.entered = entered;
        let prepared = next.prepared.clone();
        self.calm = calm(&prepared.model);
        self.present = next;
        self.set_back(&run);
        Ok((prepared, run))
    }

    /// Lets displacements count from now, if the present stage says so.
    pub(crate) fn set_back(&mut self, run: &Simulation<D, N>) {
        if self.now().resets {
            let mesh = &self.whole.model.mesh;
            let counts = [mesh.elements.len(), mesh.nodes.len()];
            let present = (&self.present.elements[..], &self.present.nodes[..]);
            self.entered.origin = Some(Origin::of(run, present, counts));
        }
    }

    /// Displacements from which those of the elements and nodes of the present stage count.
    pub(crate) fn origin(&self) -> Option<Origin<D>> {
        let origin = self.entered.origin.as_ref()?;
        Some(origin.part::<N>(&self.present.elements, &self.present.nodes))
    }

    /// The stages so far, for `run.json`.
    pub(crate) fn json(&self) -> Value {
        let begun = self.entered.begun.iter().zip(&self.whole.stages);
        let begun = begun.map(
            |(step, stage)| json!({ "name": stage.name, "step": step, "time": *step as f64 * self.step }),
        );
        begun.collect()
    }

    /// When each stage so far has begun, in words.
    pub(crate) fn in_words(&self) -> String {
        let begun = self.entered.begun.iter().zip(&self.whole.stages);
        let begun =
            begun.map(|(step, stage)| format!("{} from {} s", stage.name, brief(*step as f64 * self.step)));
        begun.collect::<Vec<_>>().join(", ")
    }
}

/// Time at which all releases and ramps of a model are over, s. A table of a load may be the whole history of
/// it, and is not waited for.
fn calm<const D: usize, const N: usize>(model: &Model<D, N>) -> f64 {
    fn end(schedule: &Schedule, is_release: bool) -> f64 {
        match schedule {
            Schedule::From(start, inner) => start + end(inner, is_release),
            Schedule::Ramp(duration) => *duration,
            Schedule::Table(rows) if is_release => rows.last().map_or(0.0, |row| row[0]),
            Schedule::Table(_) | Schedule::Constant => 0.0,
        }
    }
    let loads = model.boundaries.iter().map(|boundary| end(&boundary.schedule, boundary.load == Load::Held));
    loads.chain([end(&model.gravity_schedule, false)]).fold(0.0, f64::max)
}

impl Over {
    /// Says how a stage ends.
    pub(crate) fn in_words(&self) -> String {
        match self {
            Self::Time(true) => "its time has passed".to_owned(),
            Self::Time(false) => {
                "warning: its time has passed before its equilibrium or condition".to_owned()
            }
            Self::Until(why) => why.clone(),
            Self::Equilibrium([share, imbalance]) => format!(
                "equilibrium: kinetic over strain energy {share:.1e}, imbalance of forces {imbalance:.1e}"
            ),
        }
    }
}
