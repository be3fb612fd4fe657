//! Whether the step is stable for the contacts that there are.

use rayon::prelude::*;

use crate::error::GrainError;
use crate::run::balls::{ALONE, Balls};
use crate::run::contacts::{CHUNK, ContactChunk, Contacts, Entry};
use crate::run::laws::Laws;
use crate::time_step::Response;
use crate::vector::dot;

/// Share of the square of the friction above which a contact counts as one that slides.
const NEARLY: f64 = 0.999;

/// Share of the longest stable step of a sphere among others at rest, beyond which no packing was stable.
const CERTAIN: f64 = 0.8;

/// Checks that the step is not too long for the springs and dashpots across the contacts of any sphere.
/// Contacts that slide, and those with walls and bodies, do not count; nor do clumps.
///
/// # Errors
/// [`GrainError::Unstable`] with the sphere that needs the shortest step.
pub(crate) fn check(balls: &Balls, of: &Contacts, laws: &Laws, step: f64) -> Result<(), GrainError> {
    let of_chunk = |(number, chunk): (usize, &ContactChunk)| {
        let spheres = chunk.entries.chunk_by(|one, two| one.sphere == two.sphere);
        let steps = spheres.map(|entries| {
            let place = number * CHUNK + entries[0].sphere as usize;
            let (response, contacts) = response(place, balls, (of, entries), laws);
            (response.longest_step(), balls.list[place].number, contacts)
        });
        steps.fold(NONE, shorter)
    };
    let (longest, sphere, contacts) = of.chunks.par_iter().enumerate().map(of_chunk).reduce(|| NONE, shorter);
    // Where its neighbours turn likewise, half of it is the limit.
    if step > CERTAIN * longest {
        return Err(GrainError::Unstable { sphere, contacts, step, longest: 0.5 * longest });
    }
    Ok(())
}

/// The longest stable step of no sphere, s; its number and its contacts.
const NONE: (f64, u32, usize) = (f64::INFINITY, u32::MAX, 0);

/// The shorter of two steps; of equal ones that of the lower number.
fn shorter(one: (f64, u32, usize), two: (f64, u32, usize)) -> (f64, u32, usize) {
    if (two.0, two.1) < (one.0, one.1) { two } else { one }
}

/// The response of a sphere with these contacts to a spin about an axis of any direction, and the number of
/// contacts in it.
fn response(
    place: usize,
    balls: &Balls,
    (of, entries): (&Contacts, &[Entry]),
    laws: &Laws,
) -> (Response, usize) {
    let (mut sum, mut contacts) = (Response::default(), 0);
    let one = &balls.list[place];
    if balls.kinds[place].clump != ALONE || balls.kinds[place].held {
        return (sum, contacts);
    }
    // Two thirds of the contacts lie across an axis.
    let share = 2.0 / 3.0 / (balls.share * one.mass);
    for entry in entries {
        let contact = entry.contact();
        let history = of.history(contact);
        let [a, b] = of.couples[contact].places.map(|place| &balls.list[place as usize]);
        let Ok(law) = laws.of([a.material, b.material]) else { continue };
        let force = of.acting[contact].force();
        let square = dot(history.tangential, history.tangential);
        // The spring of a contact that slides has the force of friction.
        let is_sliding = square >= NEARLY * law.surfaces.friction.powi(2) * (dot(force, force) - square);
        if history.contact <= 0.0 || is_sliding {
            continue;
        }
        let across = law.answer_across(&history, a.mass * b.mass / (a.mass + b.mass));
        sum.stiffness += share * across.stiffness;
        sum.damping += share * across.damping;
        contacts += 1;
    }
    (sum, contacts)
}
