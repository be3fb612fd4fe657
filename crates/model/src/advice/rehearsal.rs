//! A rehearsal: the run of a model with a coarse mesh, which shows the cost of its breaking. It goes to the
//! end time: it does not know the conditions of `until`.
//!
//! The cost of a run that breaks depends on how much of the model comes near its strength, and when. A coarse
//! mesh shows that in a fraction of the time: in `D` dimensions, elements `k` times as large make a run
//! `k^(D+1)` times shorter.

use fdem_simulation::{Insertion, Simulation};

use crate::advice::clock::processor_time;
use crate::advice::preflight::{Preflight, measured, steps};
use crate::bodies::dimensions::Dimensions;
use crate::prepared::Prepared;

/// A run that takes less, s, has no rehearsal.
const SHORT: f64 = 5.0;

/// Processor time that a rehearsal should take, and after which it ends, s.
const WANTED: f64 = 1.5;
const MOST: f64 = 5.0;

/// Time of a run in which much breaks over that of one in which nothing does, with which the mesh of a
/// rehearsal is chosen.
const BREAKING: f64 = 5.0;

/// Elements that a coarse mesh has at least, in the plane and in space: with fewer, the shapes of bodies and
/// the zones in which cracks grow are lost.
const ELEMENTS: [f64; 2] = [250.0, 400.0];

/// Share of the steps of a rehearsal, at its end, whose cost stands for the steps that it did not reach.
const LAST: f64 = 0.25;

/// Share of a run that a rehearsal must reach: the rest cannot be guessed from less.
const ENOUGH: f64 = 0.5;

/// Parts of equal length into which a rehearsal is cut.
const PARTS: usize = 100;

/// The cost of breaking, from a run with a coarse mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rehearsal {
    /// Number of elements of the coarse mesh.
    pub elements: usize,
    /// Time that breaking takes more, in the mean over all steps, s for an element and a step.
    pub more: f64,
    /// Share of the run that was rehearsed before its time was over.
    pub share: f64,
}

impl Rehearsal {
    /// Mesh sizes for a rehearsal over those of the model. `None` if the run is short, or does not break, or
    /// if no coarser mesh would do.
    pub fn factor<const D: usize, const N: usize>(
        prepared: &Prepared<D, N>,
        preflight: &Preflight,
    ) -> Option<f64> {
        let model = &prepared.model;
        let breaks = model.materials.iter().any(|material| material.strength.is_some())
            && model.fracture.insertion == Insertion::Adaptive;
        if !breaks || !prepared.stages.is_empty() || preflight.seconds_whole < SHORT {
            return None;
        }
        let wanted = (BREAKING * preflight.seconds_whole / WANTED).powf(1.0 / (D as f64 + 1.0));
        let coarsest = (preflight.quality.elements as f64 / ELEMENTS[D - 2]).powf(1.0 / D as f64);
        let factor = wanted.min(coarsest);
        (factor > 1.5).then_some(factor)
    }

    /// Runs a model with a coarse mesh. `None` if it cannot run, or if half of the run takes too long.
    pub fn of<const D: usize, const N: usize>(coarse: &Prepared<D, N>) -> Option<Self>
    where
        [[f64; D]; N]: Dimensions<D, N>,
    {
        let mut run = Simulation::new(coarse.model.clone(), 1).ok()?;
        let (_, steps) = steps(coarse, run.critical_step().step).ok()?;
        let elements = coarse.model.mesh.elements.len();
        let calm = measured(steps);
        let begin = processor_time();
        run.advance(1).ok()?;
        let first = processor_time();
        run.advance(calm).ok()?;
        let whole = (processor_time() - first) / calm as f64;
        if ENOUGH * whole * steps as f64 > MOST {
            return None;
        }
        // Times of a step, in the mean over each part.
        let part = (steps / PARTS as u64).max(1);
        let mut times = Vec::new();
        let mut last = processor_time();
        while run.steps() < steps && last - begin < MOST {
            run.advance(part).ok()?;
            let now = processor_time();
            times.push((now - last) / part as f64);
            last = now;
        }
        let reached = times.len() as u64 * part;
        let at_the_end = &times[times.len() - (LAST * times.len() as f64).ceil() as usize..];
        let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len().max(1) as f64;
        let left = steps.saturating_sub(reached) as f64;
        let of_all = (mean(&times) * reached as f64 + mean(at_the_end) * left) / (reached as f64 + left);
        let more = ((of_all - whole) / elements as f64).max(0.0);
        let share = (reached as f64 / steps as f64).min(1.0);
        (share >= ENOUGH).then_some(Self { elements, more, share })
    }
}

impl Preflight {
    /// Takes the cost of breaking from a rehearsal. Estimates for many ranks stay as they are.
    pub fn rehearse(&mut self, rehearsal: &Rehearsal) {
        let more = rehearsal.more * self.quality.elements as f64 * self.steps as f64;
        self.seconds = self.seconds_whole + more;
        self.rehearsed = Some(rehearsal.elements);
    }
}
