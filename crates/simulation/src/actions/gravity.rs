//! Gravity: the weight of all nodes, and its work.

use std::ops::Range;

use crate::action::{Acting, Action, Scene};
use crate::energy::{Account, Ledger};
use crate::machine::{Columns, Wanted};
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
        let Scene { model, team, time, machine, .. } = *scene;
        if model.gravity == [0.0; D] {
            return;
        }
        let factor = model.gravity_schedule.factor(time);
        let mut count = 0;
        machine.look_at(&Wanted::default(), &mut |columns| count = columns.solid.node_count());
        let wanted = Wanted { positions: (0..count as u32).collect(), ..Wanted::default() };
        machine.look_at(&wanted, &mut |Columns { solid, .. }| {
            let work = |node: usize| {
                let moved = solid.displacement(node, model);
                factor * solid.true_mass(node) * dot(model.gravity, moved)
            };
            let of =
                |range: Range<usize>| [range.filter(|&node| solid.share().node(node)).map(work).collect()];
            let [sum] = Sum::all(team.look(count, of));
            ledger.add(Account::Gravity, &sum);
        });
    }
}
