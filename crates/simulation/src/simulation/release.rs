//! Bodies that are rigid until they are overloaded: they get a stress in balance with the forces on them, and
//! deform from the next step on. A run goes from the one model to the other by its state, as from stage to
//! stage, so that a run that is resumed has the same bits.

use crate::error::Stop;
use crate::machine::list::Machines;
use crate::machine::{Columns, Wanted};
use crate::rigid::nodes::RECORD;
use crate::rotation::{lifted, lowered, matrix_of};
use crate::simulation::run::Simulation;
use crate::simulation::saved::State;
use crate::vector::{Matrix, applied, transposed};

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// The bodies that were rigid until they were overloaded, in ascending order.
    pub fn released_bodies(&self) -> Vec<u32> {
        let body = |(element, _): &(u32, _)| self.model.mesh.bodies[*element as usize];
        let mut bodies: Vec<u32> = self.released.iter().map(body).collect();
        bodies.sort_unstable();
        bodies.dedup();
        bodies
    }

    /// After a step: releases the rigid bodies that are overloaded.
    ///
    /// # Cost
    /// Three times that of [`Simulation::new`], if there are any. A device sends and gets all columns then.
    pub(super) fn release_overloaded(&mut self) -> Result<(), Stop> {
        if self.model.until_overloaded.is_empty() {
            return Ok(());
        }
        let mut overloaded = Vec::new();
        let Self { model, topology, machine, .. } = &*self;
        machine.look_at(&Wanted::default(), &mut |Columns { solid, .. }| {
            for (place, body) in model.rigid.iter().enumerate() {
                let Some(until) = model.until_overloaded(*body) else { continue };
                let load = solid.overload(place, model, topology);
                if load < until.share {
                    continue;
                }
                overloaded.push((place, until.share / load));
            }
        });
        if overloaded.is_empty() {
            return Ok(());
        }
        let (mut released, mut stresses) = (Vec::new(), Vec::new());
        let solid = self.solid();
        for (place, part) in overloaded {
            // A blow passes the share within a step. The body would have deformed under the share, and gets
            // the stress of that: with all of it, it would have more energy than the blow.
            let turn: Matrix<3> = matrix_of(solid.rigid.motions[place].orientation);
            for (element, stress) in solid.balanced_stresses(place, &self.model) {
                let stress = stress.map(|row| row.map(|x| part * x));
                released.push((element, stress));
                stresses.push((element, turned_by(&turn, &stress)));
            }
        }
        self.change_to(released, &stresses).map_err(|error| Stop::Released(error.to_string()))
    }

    /// Continues with these elements as ones that deform, which begin with these stresses: in the undeformed
    /// body, and now.
    fn change_to(
        &mut self,
        released: Vec<(u32, Matrix<D>)>,
        stresses: &[(u32, Matrix<D>)],
    ) -> Result<(), crate::error::ModelError> {
        let before: State<D, N> = self.state();
        let mut state = before.clone();
        let is_released = |element: u32| released.binary_search_by_key(&element, |of| of.0).is_ok();
        let topology = &self.topology;
        state.records.retain(|record| {
            let corner = topology.corner(record.codes[0]);
            record.action != RECORD || !corner.is_some_and(|corner| is_released(corner / N as u32))
        });
        for &(element, stress) in stresses {
            state.stresses[element as usize] = stress;
        }
        state.released.extend(released);
        state.released.sort_unstable_by_key(|of| of.0);
        let again = |state| Self::continued_on(self.model.clone(), state, self.team.clone());
        let (had, has) = (again(before)?.look(), again(state.clone())?.look());
        // The elastic energy that the rigid body did not have, and that of nodes that no longer turn as one.
        state.totals.external.add_sum(&has.energy);
        state.totals.external.subtract(&had.energy);
        let mut new = again(state)?;
        new.actions.spheres.keep_law(&mut self.actions.spheres);
        // The results of the last step stay; nodes have the numbers of the state.
        let order = self.solid().order(&self.topology);
        let mut number = vec![0; order.len()];
        for (new, &old) in (0..).zip(&order) {
            number[old as usize] = new;
        }
        let held = self.held.iter().map(|&(node, force)| (number[node as usize], force)).collect();
        let Self { imbalance, timings, .. } = *self;
        let (joint_elastic, touching) = (self.joint_elastic.clone(), std::mem::take(&mut self.touching));
        let new = Self { imbalance, held, joint_elastic, touching, timings, ..new };
        self.stand_in(new)
    }
}

/// A stress of the undeformed body in a body that has turned.
fn turned_by<const D: usize>(turn: &Matrix<3>, stress: &Matrix<D>) -> Matrix<D> {
    let columns: Matrix<D> = stress.map(|row| lowered(applied(turn, lifted(row))));
    transposed(&columns).map(|row| lowered(applied(turn, lifted(row))))
}
