//! Whether the step is stable for the contacts that there are.

use rayon::prelude::*;

use crate::error::GrainError;
use crate::run::balls::{ALONE, Balls};
use crate::run::laws::Laws;
use crate::run::lists::{CHUNK, Lists};
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
pub(crate) fn check(balls: &Balls, lists: &Lists, laws: &Laws, step: f64) -> Result<(), GrainError> {
    let (longest, sphere, contacts) = (0..balls.list.len())
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|place| {
            let (response, contacts) = response(place, balls, lists, laws);
            (response.longest_step(), balls.list[place].number, contacts)
        })
        .reduce(
            || (f64::INFINITY, u32::MAX, 0),
            |one, two| if (two.0, two.1) < (one.0, one.1) { two } else { one },
        );
    // Where its neighbours turn likewise, half of it is the limit.
    if step > CERTAIN * longest {
        return Err(GrainError::Unstable { sphere, contacts, step, longest: 0.5 * longest });
    }
    Ok(())
}

/// The response of a sphere to a spin about an axis of any direction, and the number of contacts in it.
fn response(place: usize, balls: &Balls, lists: &Lists, laws: &Laws) -> (Response, usize) {
    let (mut sum, mut contacts) = (Response::default(), 0);
    let one = &balls.list[place];
    if balls.kinds[place].clump != ALONE || balls.kinds[place].held {
        return (sum, contacts);
    }
    // Two thirds of the contacts lie across an axis.
    let share = 2.0 / 3.0 / (balls.share * one.mass);
    lists.touching.within(lists.first_incident[place]..lists.first_incident[place + 1], |index| {
        let slot = lists.incidents[index as usize] as usize / 2;
        let history = lists.history(slot);
        let [a, b] = lists.pairs[slot].map(|place| &balls.list[place as usize]);
        let Ok(law) = laws.of([a.material, b.material]) else { return };
        let force = lists.acting[lists.acted[slot] as usize].force;
        let square = dot(history.tangential, history.tangential);
        // The spring of a contact that slides has the force of friction.
        let is_sliding = square >= NEARLY * law.surfaces.friction.powi(2) * (dot(force, force) - square);
        if history.contact <= 0.0 || is_sliding {
            return;
        }
        let across = law.answer_across(&history, a.mass * b.mass / (a.mass + b.mass));
        sum.stiffness += share * across.stiffness;
        sum.damping += share * across.damping;
        contacts += 1;
    });
    (sum, contacts)
}
