//! Mass scaling: mass that is added to elements so that a longer time step is stable.
//!
//! In a quasi-static run nothing depends on mass but the time step and how fast waves die out. Where a few
//! small or stiff elements alone set the time step, some more mass on them makes all steps longer. The added
//! mass has inertia and kinetic energy, and no weight: forces in equilibrium are those of the true masses.
//!
//! The bound of `critical.rs` says how much mass each node needs. A node gets the missing mass on the
//! stiffest of its elements: with stiffnesses `kₑ` and masses `mₑ` of the elements at the node, a limit `λ`
//! of the square of the frequency, and the least `t` for which the sum is enough,
//!
//! ```text
//! Σ max(mₑ, t kₑ/λ) = Σ kₑ/λ
//! ```
//! Each element takes the largest factor that one of its nodes requires.

use crate::compiled::compiled;
use crate::critical::{least_nodes, reduction};
use crate::error::ModelError;
use crate::joints::Joints;
use crate::model::Model;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::corners_of;
use crate::topology::Topology;

/// Relative margin against rounding, so that the critical step is not below the requested one.
const MARGIN: f64 = 1e-12;

/// Mass scaling of a model: the factors of the masses of its elements for any time step.
#[derive(Clone, Debug)]
pub struct MassScaling {
    /// Elements at each node, with their stiffness there, N/m, and their mass, kg.
    nodes: Vec<AtNode>,
    /// Number of `nodes` up to and with each node.
    ends: Vec<usize>,
    /// The critical time step over that without damping.
    reduction: f64,
    /// Factors that the model has already; empty for none.
    given: Vec<f64>,
    /// True mass of each element, kg.
    masses: Vec<f64>,
}

/// An element at a node.
#[derive(Clone, Copy, Debug)]
struct AtNode {
    element: u32,
    stiffness: f64,
    mass: f64,
}

impl MassScaling {
    /// The mass scaling of a model, beyond the factors that it has.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated.
    pub fn of<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        compiled!((model: reference [Model<2, 3>, Model<3, 4>])
            -> [Result<MassScaling, ModelError>, Result<MassScaling, ModelError>] = MassScaling::of_model)
    }

    fn of_model<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        crate::checks::check(model)?;
        let topology = Topology::of(&model.mesh)?;
        let joints = Joints::new(model, &topology, &Share::default());
        let (mut nodes, mut ends) = (Vec::with_capacity(N * model.mesh.elements.len()), Vec::new());
        least_nodes(model, &topology, &joints, |corners| {
            nodes.extend(corners.iter().map(|(corner, of_corner)| AtNode {
                element: corner / N as u32,
                stiffness: of_corner.stiffness(),
                mass: of_corner.mass,
            }));
            ends.push(nodes.len());
        });
        Ok(Self {
            nodes,
            ends,
            reduction: reduction(model),
            given: model.mass_factors.clone(),
            masses: model.true_masses(),
        })
    }

    /// Factors of the masses of all elements with which the critical time step is at least `step`, s: for
    /// [`Model::mass_factors`]. Empty if all are 1.
    pub fn factors(&self, step: f64) -> Vec<f64> {
        let exact = (2.0 * self.reduction / step).powi(2);
        let (limit, bound) = (exact * (1.0 - MARGIN), exact * (1.0 - 0.5 * MARGIN));
        let mut factors = self.given.clone();
        let mut sorted = Vec::new();
        let mut first = 0;
        for &end in &self.ends {
            let at = &self.nodes[first..end];
            first = end;
            let (stiffness, mass) = at.iter().fold((0.0, 0.0), |(k, m), at| (k + at.stiffness, m + at.mass));
            if stiffness <= bound * mass {
                continue;
            }
            if factors.is_empty() {
                factors.resize(self.masses.len(), 1.0);
            }
            sorted.clear();
            sorted.extend_from_slice(at);
            let share = share(&mut sorted, limit);
            for at in at {
                let given = self.given.get(at.element as usize).copied().unwrap_or(1.0);
                let factor = given * (share * at.stiffness / (limit * at.mass)).max(1.0);
                let of_element = &mut factors[at.element as usize];
                *of_element = of_element.max(factor);
            }
        }
        factors
    }

    /// True mass of the model, and the mass that these factors add to it, kg.
    pub fn added(&self, factors: &[f64]) -> [f64; 2] {
        [
            self.masses.iter().sum(),
            self.masses.iter().zip(factors).map(|(mass, factor)| (factor - 1.0) * mass).sum(),
        ]
    }
}

impl<const D: usize, const N: usize> Model<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Mass of each element without its factor, kg.
    pub fn true_masses(&self) -> Vec<f64> {
        let mass = |element: usize| {
            let density = self.materials[self.mesh.materials[element] as usize].density;
            density * corners_of(&self.mesh, element).measure() * self.thickness
        };
        (0..self.mesh.elements.len()).map(mass).collect()
    }
}

/// The share `t` of the stiffness of each element over the limit that is its mass at least, where a node has
/// too little mass. Sorts its elements.
fn share(at: &mut [AtNode], limit: f64) -> f64 {
    let ratio = |at: &AtNode| at.stiffness / at.mass;
    at.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)).then(a.element.cmp(&b.element)));
    let needed: f64 = at.iter().map(|at| at.stiffness).sum();
    let mut others: f64 = at.iter().map(|at| at.mass).sum();
    let mut stiffness = 0.0;
    for number in 0..at.len() {
        stiffness += at[number].stiffness;
        others -= at[number].mass;
        let share = (needed - limit * others) / stiffness;
        // The next element has enough mass already.
        if at.get(number + 1).is_none_or(|next| share * ratio(next) <= limit) {
            return share.min(1.0);
        }
    }
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_gets_what_it_lacks_on_its_stiffest_elements() {
        let at = |element, stiffness, mass| AtNode { element, stiffness, mass };
        // The limit is 1: 12 kg are needed, and 6 are there. The first two share the 6 others as their
        // stiffnesses.
        let mut node = [at(0, 1.0, 3.0), at(1, 3.0, 1.0), at(2, 8.0, 2.0)];
        let share = share(&mut node, 1.0);
        assert!((share - 9.0 / 11.0).abs() < 1e-15, "{share}");
        let mass: f64 = node.iter().map(|at| at.mass.max(share * at.stiffness)).sum();
        assert!((mass - 12.0).abs() < 1e-14, "{mass}");
    }
}
