//! A rehearsal: the run of a model with a coarse mesh, which shows the cost of its breaking and when it ends.
//!
//! The cost of a run that breaks depends on how much of the model comes near its strength, and when. A coarse
//! mesh shows that in a fraction of the time: in `D` dimensions, elements `k` times as large make a run
//! `k^(D+1)` times shorter.

use crate::advice::clock::processor_time;
use crate::advice::preflight::{Preflight, Rehearsed, measured, seconds_of_spheres};
use crate::prepared::{Bound, Prepared, PreparedUntil};

/// A run that takes less while nothing breaks, s, has no rehearsal.
const SHORT: f64 = 0.25;

/// Processor time that a rehearsal should take, as a share of the run and within these limits, and after
/// which it ends, s.
const SHARE: f64 = 0.1;
const WANTED: [f64; 2] = [0.2, 3.0];
const MOST: f64 = 8.0;

/// Time of a run in which much breaks over that of one in which nothing does, with which the mesh of a
/// rehearsal is chosen, in the plane and in space.
const BREAKING: [f64; 2] = [5.0, 10.0];

/// Elements that a coarse mesh has at least, in the plane and in space: with fewer, the shapes of bodies and
/// the zones in which cracks grow are lost.
const ELEMENTS: [f64; 2] = [250.0, 250.0];

/// Share of the elements of a model that a coarse mesh has at most: bodies from mesh files stay as they are.
const FEWER: f64 = 0.7;

/// Share of the steps of a rehearsal, at its end, whose cost stands for the steps that it did not reach.
const LAST: f64 = 0.25;

/// Share of the time of a run that spheres take at most where a coarse mesh makes it shorter.
const SPHERES: f64 = 0.3;

/// Share of a run that a rehearsal must reach: the rest cannot be guessed from less.
const ENOUGH: f64 = 0.25;

/// Parts of equal length into which a rehearsal is cut.
const PARTS: u64 = 100;

/// The cost of breaking, from a run with a coarse mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rehearsal {
    /// Number of elements of the coarse mesh.
    pub elements: usize,
    /// Time that a step takes more than the first ones, in the mean over all steps, s for an element.
    pub more: f64,
    /// Share of the run that was rehearsed before its time was over.
    pub share: f64,
    /// Time at which a condition or the last stage ended the run before its end time, s.
    pub ended: Option<f64>,
}

impl Rehearsal {
    /// Mesh sizes for a rehearsal over those of the model. `None` if the run is short, if its bodies neither
    /// break nor are rigid, or if no coarser mesh would do.
    pub fn factor<const D: usize, const N: usize>(
        prepared: &Prepared<D, N>,
        preflight: &Preflight,
    ) -> Option<f64> {
        // Contacts of rigid bodies are most of their cost, and few are there from the beginning.
        let is_rigid = !prepared.model.rigid.is_empty();
        if !(preflight.breaks || is_rigid) || preflight.seconds_whole < SHORT {
            return None;
        }
        let time = preflight.seconds_whole;
        // A coarse mesh has as many spheres.
        if seconds_of_spheres(&prepared.model) * preflight.steps as f64 > SPHERES * time {
            return None;
        }
        let [least, most] = WANTED;
        let goal = (SHARE * BREAKING[D - 2] * time).clamp(least, most);
        let wanted = (BREAKING[D - 2] * time / goal).powf(1.0 / (D as f64 + 1.0));
        let coarsest = (preflight.quality.elements as f64 / ELEMENTS[D - 2]).powf(1.0 / D as f64);
        let factor = wanted.min(coarsest);
        // A run that may end early is tried, however long it is to its end time.
        let ends_early = prepared.until.is_some() || !prepared.stages.is_empty();
        let ends_soon = ENOUGH * time <= MOST * factor.powf(D as f64 + 1.0);
        (factor > 1.5 && (ends_early || ends_soon)).then_some(factor)
    }

    /// The box of each body, m. In the plane, the last coordinate is nothing.
    pub fn boxes<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<[[f64; 3]; 2]> {
        let mesh = &prepared.model.mesh;
        let mut boxes = vec![[[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]; prepared.bodies.len()];
        for (corners, &body) in mesh.elements.iter().zip(&mesh.bodies) {
            let Some([low, high]) = boxes.get_mut(body as usize) else { continue };
            for place in corners.iter().map(|&node| mesh.nodes[node as usize]) {
                for (axis, x) in place.into_iter().enumerate() {
                    low[axis] = low[axis].min(x);
                    high[axis] = high[axis].max(x);
                }
            }
        }
        boxes
    }

    /// Stretches the bodies of a coarse model to the boxes that they have in the model: with large elements a
    /// round body is smaller, and others would reach it later.
    pub fn fit<const D: usize, const N: usize>(coarse: &mut Prepared<D, N>, boxes: &[[[f64; 3]; 2]]) {
        let before = Self::boxes(coarse);
        let mesh = &mut coarse.model.mesh;
        let mut is_fit = vec![false; mesh.nodes.len()];
        for (corners, &body) in mesh.elements.iter().zip(&mesh.bodies) {
            let body = body as usize;
            let (Some([from, to]), Some([low, high])) = (before.get(body), boxes.get(body)) else { continue };
            for &node in corners {
                if std::mem::replace(&mut is_fit[node as usize], true) {
                    continue;
                }
                for (axis, x) in mesh.nodes[node as usize].iter_mut().enumerate() {
                    let factor = (high[axis] - low[axis]) / (to[axis] - from[axis]);
                    *x = low[axis] + factor * (*x - from[axis]);
                }
            }
        }
    }

    /// Changes the conditions of a coarse model on columns that count steps or joints to the counts that it
    /// has where the model has those given. `whole`: number of elements of the model.
    pub fn scale_counts<const D: usize, const N: usize>(coarse: &mut Prepared<D, N>, whole: usize) {
        // Elements that are `k` times as large have steps that are `k` times as long.
        let finer = (coarse.quality.elements as f64 / whole as f64).powf(1.0 / D as f64);
        let of_stages = coarse.stages.iter_mut().filter_map(|stage| stage.until.as_mut());
        for PreparedUntil { column, bound, .. } in coarse.until.iter_mut().chain(of_stages) {
            let factor = match column.as_str() {
                "step" => finer,
                "broken_joints" => finer.powf(D as f64 - 1.0),
                _ => continue,
            };
            match bound {
                Bound::Above(value) | Bound::Below(value) | Bound::ShareOfPeak { least: value, .. } => {
                    *value *= factor;
                }
            }
        }
    }

    /// Times a run with a coarse mesh. `elements`: number of its elements, and of those of the model; `steps`
    /// until its `end_time`, s. `advance` takes it to a step, or to its end if that is earlier, and returns
    /// the step and whether the run is over, or `None` if it cannot continue.
    ///
    /// `None` if half of the run takes too long, or if the mesh is hardly coarser than that of the model.
    pub fn of(
        [elements, whole]: [usize; 2],
        steps: u64,
        end_time: f64,
        mut advance: impl FnMut(u64) -> Option<(u64, bool)>,
    ) -> Option<Self> {
        if elements as f64 > FEWER * whole as f64 {
            return None;
        }
        let part = (steps / PARTS).max(1);
        let begin = processor_time();
        let (mut reached, mut is_over) = advance(1)?;
        // Steps and seconds of each part. The first one shows the cost while nothing breaks.
        let mut parts: Vec<[f64; 2]> = Vec::new();
        let mut last = processor_time();
        while !is_over && (parts.is_empty() || last - begin < MOST) {
            let length = if parts.is_empty() { measured(steps) } else { part };
            let before = reached;
            (reached, is_over) = advance((reached + length).min(steps))?;
            let now = processor_time();
            parts.push([(reached - before) as f64, now - last]);
            last = now;
        }
        let mean = |parts: &[[f64; 2]]| {
            let [steps, seconds] =
                parts.iter().fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
            (steps > 0.0).then_some(seconds / steps)
        };
        let calm = mean(parts.get(..1)?)?;
        let at_the_end = &parts[parts.len() - (LAST * parts.len() as f64).ceil() as usize..];
        let share = reached as f64 / steps as f64;
        let of_all =
            if is_over { mean(&parts)? } else { share * mean(&parts)? + (1.0 - share) * mean(at_the_end)? };
        let rehearsal = Self {
            elements,
            more: ((of_all - calm) / elements as f64).max(0.0),
            share: if is_over { 1.0 } else { share },
            ended: (is_over && reached < steps).then_some(share * end_time),
        };
        (rehearsal.share >= ENOUGH).then_some(rehearsal)
    }
}

impl Preflight {
    /// Takes the cost of breaking, and the time at which the run ends, from a rehearsal. Estimates for many
    /// ranks stay as they are.
    pub fn rehearse(&mut self, rehearsal: &Rehearsal) {
        let whole = self.seconds_whole / self.steps as f64;
        let of_a_step = whole + rehearsal.more * self.quality.elements as f64;
        let end = self.steps as f64 * self.step;
        let steps = self.steps as f64 * rehearsal.ended.map_or(1.0, |time| (time / end).min(1.0));
        self.seconds = of_a_step * steps;
        self.rehearsal = Some(Rehearsed::Done { elements: rehearsal.elements, ended: rehearsal.ended });
    }
}
