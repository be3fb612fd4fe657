//! Rehearses the run of a model with a coarse mesh, for the estimate of its run time.

use std::path::Path;

use crate::command::failure::display_name;
use crate::command::model_file::inputs_of;
use crate::command::progress::Progress;
use crate::command::run::course::{Course, Start};
use crate::command::run::results::Results;
use fdem_model::{AnyPrepared, Preflight, Prepared, Reached, Rehearsal, Rehearsed, prepare_coarse};

/// Rehearses the run of a model, if that is of use. Takes the path and the text of the model file.
pub(crate) fn rehearse<const D: usize, const N: usize>(
    preflight: &mut Preflight,
    prepared: &Prepared<D, N>,
    (path, text): (&Path, &str),
    progress: &Progress,
) {
    let Some(factor) = Rehearsal::factor(prepared, preflight) else { return };
    let boxes = Rehearsal::boxes(prepared);
    let (rehearsal, _) = progress.step("rehearsing the run with a coarse mesh", None, |_| {
        // A mesh may be too coarse for its bodies: then the estimate stays.
        match prepare_coarse(text, &display_name(path), &mut inputs_of(path), factor).ok()? {
            AnyPrepared::Plane(coarse) => rehearsal(*coarse, &boxes, preflight),
            AnyPrepared::Space(coarse) => rehearsal(*coarse, &boxes, preflight),
        }
    });
    match rehearsal {
        Some(rehearsal) => preflight.rehearse(&rehearsal),
        None => preflight.rehearsal = Some(Rehearsed::Failed),
    }
}

/// The rehearsal of a run, with its stages, servos and conditions. `None` if the coarse model cannot run, or
/// is too large.
fn rehearsal<const D: usize, const N: usize>(
    mut coarse: Prepared<D, N>,
    boxes: &[[[f64; 3]; 2]],
    preflight: &Preflight,
) -> Option<Rehearsal>
where
    [[f64; D]; N]: Results<D, N>,
{
    let elements = coarse.quality.elements;
    Rehearsal::fit(&mut coarse, boxes);
    Rehearsal::scale_counts(&mut coarse, preflight.quality.elements);
    let mut start = Start::new(coarse, None).ok()?;
    let (simulation, _) = start.simulation(1).ok()?;
    let interval = start.prepared.output.history_interval;
    let end_time = start.prepared.end_time;
    let mut course = Course::new(start, Box::new(simulation), interval, Reached::default(), false).ok()?;
    Rehearsal::of([elements, preflight.quality.elements], course.total(), end_time, |limit| {
        while course.run.steps() < limit && !course.is_over() {
            let passed = course.advance(limit).ok()?;
            course.turn(&passed).ok()?;
        }
        Some((course.run.steps(), course.is_over()))
    })
}
