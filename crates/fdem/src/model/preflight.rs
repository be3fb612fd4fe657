//! Estimates of what a run will take, before it starts.

use std::fmt;

use fdem_simulation::{CriticalStep, Insertion, Model, Simulation};
use serde::Serialize;

use crate::model::slivers::Slivers;
use crate::model::{Prepared, Quality};
use crate::numbers::{brief, grouped};

/// What an element costs.
struct Cost {
    /// Time in a step on one core, s.
    seconds: f64,
    /// Memory while the run writes a frame or a checkpoint, bytes.
    bytes: f64,
}

/// Cost of an element of a material that does not break.
const WHOLE: Cost = Cost { seconds: 40e-9, bytes: 600.0 };

/// Cost of an element with joints on its edges from the beginning.
const JOINED: Cost = Cost { seconds: 160e-9, bytes: 2100.0 };

/// Cost of an element of a material that breaks, in the mean over a run in which it does: joints are inserted, fragments touch.
const BREAKING: Cost = Cost { seconds: 400e-9, bytes: 1500.0 };

/// Memory of the program without a model, with what it needs to draw, bytes.
const PROGRAM: f64 = 28e6;

/// Memory for an element of each frame when the report is made, bytes.
const IN_REPORT: f64 = 16.0;

/// Most steps that a run may take: beyond this number not every whole number is a floating-point number.
const MOST: f64 = 9e15;

/// The time step beyond which the integration is not stable, and what sets it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Critical {
    /// s.
    pub step: f64,
    /// The element that it belongs to.
    pub element: u32,
    /// What is stiff there: "bulk", "joint" or "contact".
    pub cause: String,
}

impl From<CriticalStep> for Critical {
    fn from(critical: CriticalStep) -> Self {
        Self { step: critical.step, element: critical.element, cause: critical.cause.to_string() }
    }
}

/// What a run would take. Shown as lines of text.
#[derive(Debug, Clone, Serialize)]
pub struct Preflight {
    /// Of the model; empty if it has none.
    pub title: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Their names; of packings each piece.
    pub names: Vec<String>,
    /// Sizes and shapes of elements.
    pub quality: Quality,
    /// The critical time step.
    pub critical: Critical,
    /// The time step that the run takes, s.
    pub step: f64,
    /// Until the end time.
    pub steps: u64,
    /// Time on one core, s. Where materials can break: if they break to pieces.
    pub seconds: f64,
    /// Time on one core if nothing breaks, s.
    pub seconds_whole: f64,
    /// Bytes.
    pub memory: f64,
    /// What may not be meant.
    pub warnings: Vec<String>,
    /// Of the model.
    pub hash: String,
}

impl Preflight {
    /// Of a model that is ready to run.
    ///
    /// # Errors
    /// In words: what of the model cannot be run.
    pub fn of(prepared: &Prepared) -> Result<Self, String> {
        // All that a run would find is found here.
        let run = Simulation::new(prepared.model.clone(), 1).map_err(|error| error.to_string())?;
        Self::with(prepared, run.critical_step())
    }

    /// The same, where a run was made of the model and has told its critical step.
    ///
    /// # Errors
    /// In words: more steps than a clock can count.
    pub fn with(prepared: &Prepared, critical: CriticalStep) -> Result<Self, String> {
        let (model, critical) = (&prepared.model, Critical::from(critical));
        let step = model.time.step.unwrap_or(critical.step * model.time.safety);
        let steps = (prepared.end_time / step).ceil();
        if !(1.0..=MOST).contains(&steps) {
            return Err(format!(
                "it would take {steps:e} steps of {step:e} s: look at densities, moduli, penalties, damping and end time"
            ));
        }
        let mut warnings = prepared.warnings.clone();
        if step > critical.step {
            warnings.push(format!(
                "the time step {} s is above the critical one, {} s: the run will not be stable",
                brief(step),
                brief(critical.step)
            ));
        }
        let seconds = sum(model, |cost| cost.seconds) * steps;
        if let Some(slivers) = Slivers::of(model) {
            warnings.push(slivers.told(&duration(seconds), &duration(seconds / slivers.longer)));
        }
        Ok(Self {
            title: prepared.title.clone(),
            bodies: prepared.bodies.len(),
            names: prepared.bodies.iter().map(|body| body.name.clone()).collect(),
            quality: prepared.quality.clone(),
            critical,
            step,
            steps: steps as u64,
            seconds,
            seconds_whole: whole(model) * steps,
            memory: PROGRAM + sum(model, |cost| cost.bytes).max(in_report(prepared)),
            warnings,
            hash: prepared.hash.clone(),
        })
    }
}

/// A cost, added up over the elements.
fn sum(model: &Model, of: impl Fn(&Cost) -> f64) -> f64 {
    let cost = |material: &u32| {
        let breaks = model.materials[*material as usize].strength.is_some();
        of(match model.fracture.insertion {
            _ if !breaks => &WHOLE,
            Insertion::Adaptive => &BREAKING,
            Insertion::Intrinsic => &JOINED,
        })
    };
    model.mesh.materials.iter().map(cost).sum()
}

/// Time of a step on one core if nothing breaks, s.
fn whole(model: &Model) -> f64 {
    match model.fracture.insertion {
        Insertion::Adaptive => sum(model, |_| WHOLE.seconds),
        Insertion::Intrinsic => sum(model, |cost| cost.seconds),
    }
}

/// Memory for the report beside the simulation, bytes: all frames, of which those of large meshes are samples.
fn in_report(prepared: &Prepared) -> f64 {
    let [most, sample] = prepared.output.shown;
    let elements = prepared.quality.elements;
    let shown = if elements > most { sample } else { elements };
    let frames = (prepared.end_time / prepared.output.interval).ceil() + 1.0;
    sum(&prepared.model, |cost| cost.bytes) / 2.0 + frames * shown as f64 * IN_REPORT
}

/// Names beyond which the rest is counted.
const NAMES: usize = 6;

impl fmt::Display for Preflight {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quality = &self.quality;
        if !self.title.is_empty() {
            writeln!(out, "title            {}", self.title)?;
        }
        let mut names = self.names[..self.names.len().min(NAMES)].join(", ");
        if self.names.len() > NAMES {
            names.push_str(", …");
        }
        writeln!(out, "bodies           {}: {names}", grouped(self.bodies as u64))?;
        writeln!(
            out,
            "mesh             {} elements, {} nodes",
            grouped(quality.elements as u64),
            grouped(quality.nodes as u64)
        )?;
        let [least, mean, most] = quality.edges.map(brief);
        writeln!(out, "edges            {least} to {most} m, mean {mean} m")?;
        let [x, y] = quality.worst_at.map(brief);
        writeln!(
            out,
            "quality          smallest angle {:.1} degrees (element {} at [{x}, {y}]), in the mean {:.1}; below 25 degrees: {:.2} %",
            quality.smallest_angle[0],
            quality.worst,
            quality.smallest_angle[1],
            100.0 * quality.below_25
        )?;
        writeln!(
            out,
            "critical step    {} s, set by the {} of element {}",
            brief(self.critical.step),
            self.critical.cause,
            self.critical.element
        )?;
        writeln!(out, "steps            {} of {} s", grouped(self.steps), brief(self.step))?;
        let most = duration(self.seconds);
        if self.seconds_whole < self.seconds {
            let whole = duration(self.seconds_whole);
            writeln!(
                out,
                "run time         about {most} on one core if it breaks to pieces, {whole} if nothing breaks"
            )?;
        } else {
            writeln!(out, "run time         about {most} on one core")?;
        }
        writeln!(out, "memory           about {}", size(self.memory))?;
        writeln!(out, "model            {}", &self.hash[..self.hash.len().min(16)])?;
        for warning in &self.warnings {
            writeln!(out, "warning          {warning}")?;
        }
        Ok(())
    }
}

/// `75` as `1 min 15 s`; at least 0.1 s.
fn duration(seconds: f64) -> String {
    if seconds < 0.1 {
        "0.1 s".to_owned()
    } else if seconds < 60.0 {
        format!("{seconds:.1} s")
    } else if seconds < 7200.0 {
        format!("{:.0} min {:02.0} s", (seconds / 60.0).floor(), seconds % 60.0)
    } else if seconds < 48.0 * 3600.0 {
        format!("{:.1} h", seconds / 3600.0)
    } else {
        format!("{:.1} days", seconds / 86_400.0)
    }
}

fn size(bytes: f64) -> String {
    if bytes < 1e9 { format!("{:.1} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_told_as_people_tell_them() {
        assert_eq!(
            [1e-3, 3.21, 75.0, 7300.0, 1e6].map(duration),
            ["0.1 s", "3.2 s", "1 min 15 s", "2.0 h", "11.6 days"]
        );
    }
}
