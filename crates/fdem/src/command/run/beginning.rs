//! When a run has begun from the end of another one.

use fdem_simulation::{Model, Schedule};
use serde::{Deserialize, Serialize};

/// When a run has begun from another one. With it, the model is made again when the run continues.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Beginning {
    /// Step at which it has begun.
    pub(crate) step: u64,
    /// Time step, s, of both runs.
    pub(crate) time_step: f64,
    /// Whether the schedule of each boundary begins then.
    pub(crate) boundaries: Vec<bool>,
    /// Whether that of gravity does.
    pub(crate) gravity: bool,
    /// Times from which walls move, and whether each insertion begins then.
    pub(crate) walls: Vec<f64>,
    pub(crate) insertions: Vec<bool>,
}

impl Beginning {
    /// Gives the model the time step of the earlier run, and its schedules their beginning.
    pub(crate) fn apply<const D: usize, const N: usize>(&self, model: &mut Model<D, N>) {
        model.time.step = Some(self.time_step);
        let start = self.step as f64 * self.time_step;
        let from = |schedule: &mut Schedule| {
            let own = std::mem::replace(schedule, Schedule::Constant);
            *schedule = Schedule::From(start, Box::new(own));
        };
        for (boundary, _) in model.boundaries.iter_mut().zip(&self.boundaries).filter(|(_, begins)| **begins)
        {
            from(&mut boundary.schedule);
        }
        if self.gravity {
            from(&mut model.gravity_schedule);
        }
        if let Some(grains) = &mut model.grains {
            grains.walls.iter_mut().zip(&self.walls).for_each(|(wall, &from)| wall.from = from);
            let insertions = grains.insertions.iter_mut().zip(&self.insertions);
            insertions.filter(|(_, begins)| **begins).for_each(|(insertion, _)| insertion.from += start);
        }
    }
}
