//! Changes by a program between steps: velocities and forces of nodes, factors of boundaries, spheres and
//! their law. Their work is in the energy balance.
//!
//! A program that holds a run may load it by a law of its own: before a step it reads the state, and sets
//! forces or velocities. Forces act like those of a [`Load`](crate::Load), from the next step on and until
//! they are set again. Velocities of nodes that a boundary moves are those of the boundary again after the
//! step. How they act, and their works: `src/actions/program.rs`.

use std::ops::Range;

use fdem_grains::{GrainRun, SphereLaw, SphereLawOptions, Spheres};

use crate::error::ModelError;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Sets the velocities of nodes, m/s. The work of the change is external work, which the energies have
    /// after the next step.
    ///
    /// # Shapes
    /// `nodes`: as a [`Snapshot`](crate::Snapshot) of now numbers them, with one velocity each; of a node
    /// that occurs twice the last velocity counts.
    ///
    /// # Errors
    /// [`ModelError::Length`], [`ModelError::Missing`], [`ModelError::OutOfRange`]: a velocity that is no
    /// number, or beyond the speed at which runs stop. Then nothing is changed.
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
        let order = self.solid().order(&self.topology);
        check(nodes, velocities, order.len(), ["velocities", "a velocity"])?;
        let limit = self.scales.speed_limit;
        if let Some(&value) = velocities.iter().flatten().find(|value| value.abs() > limit) {
            let place = "velocities that are set".to_owned();
            let range = "at most ten times the speed of waves";
            return Err(ModelError::OutOfRange { place, what: "a velocity", value, range });
        }
        let solid = &mut self.machine.columns_mut().solid;
        if let Some(&index) = nodes.iter().find(|&&node| solid.rigid.has_node(order[node as usize] as usize))
        {
            let what = "node of a body that deforms instead of";
            return Err(ModelError::Missing { what, index, place: "velocities that are set".to_owned() });
        }
        for (&node, &velocity) in nodes.iter().zip(velocities) {
            let node = order[node as usize] as usize;
            let before = solid.velocity(node);
            solid.set_velocity(node, velocity);
            self.actions.program.replaced.entry(solid.corners(node)[0]).or_insert(before);
        }
        Ok(())
    }

    /// Adds spheres to those of the model, and returns their numbers. They touch nothing at first, and move
    /// with the time step of the run. Their energy is external work.
    ///
    /// # Shapes
    /// As those of [`GrainModel::spheres`](fdem_grains::GrainModel::spheres).
    ///
    /// # Errors
    /// [`ModelError::Grains`] with the first sphere that overlaps another one, a wall or a body, or has a
    /// wrong number; [`ModelError::Missing`] if the model has no spheres. Then nothing is changed.
    ///
    /// # Cost
    /// A search for the couples of spheres.
    pub fn add_spheres(&mut self, spheres: &Spheres) -> Result<Range<u32>, ModelError> {
        Ok(self.spheres("spheres to add")?.add(spheres)?)
    }

    /// Sets a law of the caller for couples of spheres, from the next step on:
    /// [`GrainRun::set_law`]. A run that is continued from a state needs the law again.
    ///
    /// # Errors
    /// [`ModelError::Missing`] if the model has no spheres; [`ModelError::Grains`] with the errors of
    /// [`GrainRun::set_law`].
    pub fn set_sphere_law(&mut self, law: SphereLaw, options: SphereLawOptions) -> Result<(), ModelError> {
        Ok(self.spheres("law of spheres")?.set_law(law, options)?)
    }

    /// Takes the law of [`Simulation::set_sphere_law`] away.
    ///
    /// # Errors
    /// [`ModelError::Missing`] if the model has no spheres.
    pub fn clear_sphere_law(&mut self) -> Result<(), ModelError> {
        Ok(self.spheres("law of spheres")?.clear_law()?)
    }

    fn spheres(&mut self, place: &str) -> Result<&mut GrainRun, ModelError> {
        let missing = || ModelError::Missing { what: "model of spheres", index: 0, place: place.to_owned() };
        self.actions.spheres.run_mut().ok_or_else(missing)
    }

    /// Sets the forces of the caller on nodes, N, which act from the next step on until they are set again.
    /// Other nodes keep theirs. The elements around a node share its force equally, and keep their shares
    /// where the mesh breaks.
    ///
    /// # Shapes
    /// `nodes`: as a [`Snapshot`](crate::Snapshot) of now numbers them, with one force each; of a node that
    /// occurs twice the last force counts.
    ///
    /// # Errors
    /// [`ModelError::Length`], [`ModelError::Missing`], [`ModelError::OutOfRange`]: a force that is no
    /// number. Then nothing is changed.
    pub fn set_forces(&mut self, nodes: &[u32], forces: &[[f64; D]]) -> Result<(), ModelError> {
        let order = self.solid().order(&self.topology);
        check(nodes, forces, order.len(), ["forces", "a force"])?;
        let solid = &self.machine.columns().solid;
        for (&node, &force) in nodes.iter().zip(forces) {
            let corners = solid.corners(order[node as usize] as usize);
            let part = force.map(|f| f / corners.len() as f64);
            for &corner in corners {
                if part == [0.0; D] {
                    self.actions.program.forces.remove(&corner);
                } else {
                    self.actions.program.forces.insert(corner, part);
                }
            }
        }
        Ok(())
    }

    /// Takes all forces of the caller away.
    pub fn clear_forces(&mut self) {
        self.actions.program.forces.clear();
    }

    /// Sets the factor of a boundary from the next step on, in place of its schedule; `None` gives it its
    /// schedule back.
    ///
    /// # Errors
    /// [`ModelError::Missing`]; [`ModelError::OutOfRange`] for a factor that is no number;
    /// [`ModelError::NoFactor`] for an absorbing boundary.
    pub fn set_factor(&mut self, boundary: usize, factor: Option<f64>) -> Result<(), ModelError> {
        self.actions.set_factor(&self.model, boundary, factor)
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
