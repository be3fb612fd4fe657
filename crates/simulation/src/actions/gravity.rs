//! Gravity: the weight of all nodes, and its work.

use std::ops::Range;

use crate::action::{Acting, Action, Scene};
use crate::energy::{Account, Ledger};
use crate::model::Model;
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::vector::{Point, dot};

/// Gravity, as the model has it.
#[derive(Debug)]
pub(crate) struct Gravity;

impl<const D: usize, const N: usize> Action<D, N> for Gravity
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The motion of the nodes adds their weights, which are no forces on corners.
    fn act(&mut self, _acting: &mut Acting<'_, D, N>) {}

    fn acceleration(&self, model: &Model<D, N>, time: f64) -> Option<Point<D>> {
        let factor = model.gravity_schedule.factor(time);
        Some(model.gravity.map(|acceleration| factor * acceleration))
    }

    fn add_energies(&self, scene: &Scene<'_, D, N>, ledger: &mut Ledger) {
        let Scene { model, team, time, .. } = *scene;
        if model.gravity == [0.0; D] {
            return;
        }
        let solid = scene.solid();
        let factor = model.gravity_schedule.factor(time);
        let work = |node: usize| {
            let moved = solid.displacement(node, model);
            factor * solid.true_mass(node) * dot(model.gravity, moved)
        };
        let of = |range: Range<usize>| [range.filter(|&node| solid.share().node(node)).map(work).collect()];
        let [sum] = Sum::all(team.look(solid.node_count(), of));
        ledger.add(Account::Gravity, &sum);
    }
}
