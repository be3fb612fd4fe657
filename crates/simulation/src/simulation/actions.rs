//! Actions of the caller between steps: velocities and forces of nodes, factors of boundaries. Their work is in the energy balance.
//!
//! A program that holds a run may load it by a law of its own: before a step it reads the state, and sets forces or velocities. Forces act like those of a
//! [`Load`], from the next step on and until they are set again. A change of velocities is an impulse `m (v' - v)`, whose work the next step adds, once its forces
//! are known:
//!
//! ```text
//! W = m (v'² - v²) / 2 + h F·(v' - v) / 2
//! ```
//! with the force `F` of elements, joints and contacts on the node, and the time step `h`. The second term is there because velocities stand half a step before
//! positions (`motion.rs`): with it, the balance of a linear system stays exact however often velocities are set. Velocities of nodes that a boundary moves
//! are those of the boundary again after the step.

use std::collections::BTreeMap;

use crate::error::ModelError;
use crate::model::{Load, Schedule};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::simulation::totals::Actions;
use crate::vector::{Point, add, dot, minus};

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Sets the velocities of nodes, m/s. The work of the change is external work, which the energies have after the next step.
    ///
    /// # Shapes
    /// `nodes`: as a [`Snapshot`](crate::Snapshot) of now numbers them, with one velocity each; of a node that occurs twice the last velocity counts.
    ///
    /// # Errors
    /// [`ModelError::Length`], [`ModelError::Missing`], [`ModelError::OutOfRange`]: a velocity that is no number, or beyond the speed at which runs stop. Then nothing is
    /// changed.
    ///
    /// # Example
    /// ```
    /// # use fdem_simulation::*;
    /// # let mesh = Mesh { nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], elements: vec![[0, 1, 2]], bodies: vec![0], materials: vec![0] };
    /// # let material = Material { name: "rock".to_owned(), density: 2700.0, youngs_modulus: 50e9, poissons_ratio: 0.25, law: fdem_simulation::MaterialLaw::NeoHookean, damping: 0.0, strength: None, friction: 0.5 };
    /// let mut run = Simulation::new(Model { mesh, materials: vec![material], ..Model::default() }, 1)?;
    /// run.advance(10)?;
    /// run.set_velocities(&[0, 1, 2], &[[1.0, 0.0]; 3])?;
    /// run.advance(1)?;
    /// let energies = run.energies();
    /// assert!((energies.kinetic - 0.5 * 2700.0 * 0.5).abs() < 1e-9);
    /// assert!((energies.external - energies.kinetic).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_velocities(&mut self, nodes: &[u32], velocities: &[[f64; D]]) -> Result<(), ModelError> {
        let order = self.solid.order(&self.topology);
        check(nodes, velocities, order.len(), ["velocities", "a velocity"])?;
        let limit = self.scales.speed_limit;
        if let Some(&value) = velocities.iter().flatten().find(|value| value.abs() > limit) {
            let place = "velocities that are set".to_owned();
            let range = "at most ten times the speed of waves";
            return Err(ModelError::OutOfRange { place, what: "a velocity", value, range });
        }
        for (&node, &velocity) in nodes.iter().zip(velocities) {
            let node = order[node as usize] as usize;
            let before = std::mem::replace(&mut self.solid.nodes[node].velocity, velocity);
            self.actions.replaced.entry(self.solid.corners.of(node)[0]).or_insert(before);
        }
        Ok(())
    }

    /// Sets the forces of the caller on nodes, N, which act from the next step on until they are set again. Other nodes keep theirs. The elements around a node share
    /// its force equally, and keep their shares where the mesh breaks.
    ///
    /// # Shapes
    /// `nodes`: as a [`Snapshot`](crate::Snapshot) of now numbers them, with one force each; of a node that occurs twice the last force counts.
    ///
    /// # Errors
    /// [`ModelError::Length`], [`ModelError::Missing`], [`ModelError::OutOfRange`]: a force that is no number. Then nothing is changed.
    pub fn set_forces(&mut self, nodes: &[u32], forces: &[[f64; D]]) -> Result<(), ModelError> {
        let order = self.solid.order(&self.topology);
        check(nodes, forces, order.len(), ["forces", "a force"])?;
        for (&node, &force) in nodes.iter().zip(forces) {
            let corners = self.solid.corners.of(order[node as usize] as usize);
            let part = force.map(|f| f / corners.len() as f64);
            for &corner in corners {
                if part == [0.0; D] {
                    self.actions.forces.remove(&corner);
                } else {
                    self.actions.forces.insert(corner, part);
                }
            }
        }
        Ok(())
    }

    /// Takes all forces of the caller away.
    pub fn clear_forces(&mut self) {
        self.actions.forces.clear();
    }

    /// Sets the factor of a boundary from the next step on, in place of its schedule; `None` gives it its schedule back.
    ///
    /// # Errors
    /// [`ModelError::Missing`]; [`ModelError::OutOfRange`] for a factor that is no number; [`ModelError::NoFactor`] for an absorbing boundary.
    pub fn set_factor(&mut self, boundary: usize, factor: Option<f64>) -> Result<(), ModelError> {
        let number = u32::try_from(boundary).unwrap_or(u32::MAX);
        let Some(of_model) = self.model.boundaries.get(boundary) else {
            let place = "factors that are set".to_owned();
            return Err(ModelError::Missing { what: "boundary", index: number, place });
        };
        if of_model.load == Load::Absorbing {
            return Err(ModelError::NoFactor { boundary: of_model.name.clone() });
        }
        if let Some(value) = factor.filter(|factor| !factor.is_finite()) {
            let place = format!("boundary '{}'", of_model.name);
            return Err(ModelError::OutOfRange { place, what: "the factor", value, range: "a number" });
        }
        if let Some(factor) = factor {
            self.actions.factors.insert(number, factor);
            self.loads.schedules[boundary] = Schedule::Table(vec![[0.0, factor]]);
        } else {
            self.actions.factors.remove(&number);
            self.loads.schedules[boundary] = of_model.schedule.clone();
        }
        Ok(())
    }

    /// Adds the works of the velocities that the caller has replaced since the last step. The corners have the forces of this step.
    pub(super) fn add_works_of_changes(&mut self) {
        if self.actions.replaced.is_empty() {
            return;
        }
        // Works of loads are counted with the new velocities, so that the forces of loads have no part in the second term.
        let mut by_loads: BTreeMap<u32, Point<D>> = BTreeMap::new();
        for ([_, corner], force) in self.loads.applied(&self.solid) {
            add(by_loads.entry(corner).or_insert([0.0; D]), force, -1.0);
        }
        for (corner, before) in std::mem::take(&mut self.actions.replaced) {
            let node = self.solid.corners.node_at(corner) as usize;
            let constants = &self.solid.constants[node];
            let velocity = self.solid.nodes[node].velocity;
            let mut force = [0.0; D];
            for &corner in self.solid.corners.of(node) {
                add(&mut force, self.solid.force(corner), 1.0);
                add(&mut force, by_loads.get(&corner).copied().unwrap_or([0.0; D]), 1.0);
                if self.joints.at_vertex[constants.vertex as usize] {
                    self.joints.add_force(corner, &mut force);
                }
            }
            let impulse = 0.5 * constants.mass * (dot(velocity, velocity) - dot(before, before));
            let work = impulse + 0.5 * self.scales.time_step * dot(force, minus(velocity, before));
            self.totals.external.add(work);
            self.totals.loads.add(work);
        }
    }

    /// Continues the actions of a saved run.
    pub(super) fn restore_actions(&mut self, actions: Actions<D>) -> Result<(), ModelError> {
        let corners = (N * self.solid.elements.len()) as u32;
        let place = || "the saved state".to_owned();
        if let Some(&index) = actions.forces.keys().chain(actions.replaced.keys()).find(|&&c| c >= corners) {
            return Err(ModelError::Missing { what: "corner", index, place: place() });
        }
        for (&boundary, &factor) in &actions.factors {
            self.set_factor(boundary as usize, Some(factor))?;
        }
        self.actions = actions;
        Ok(())
    }
}

/// Checks vectors of nodes before any of them is set. `names`: of all of them, and of one component.
fn check<const D: usize>(
    nodes: &[u32],
    vectors: &[[f64; D]],
    count: usize,
    [all, one]: [&'static str; 2],
) -> Result<(), ModelError> {
    let place = || format!("{all} that are set");
    if vectors.len() != nodes.len() {
        return Err(ModelError::Length { what: all, found: vectors.len(), expected: nodes.len() });
    }
    if let Some(&index) = nodes.iter().find(|&&node| node as usize >= count) {
        return Err(ModelError::Missing { what: "node", index, place: place() });
    }
    match vectors.iter().flatten().find(|value| !value.is_finite()) {
        Some(&value) => Err(ModelError::OutOfRange { place: place(), what: one, value, range: "a number" }),
        None => Ok(()),
    }
}
