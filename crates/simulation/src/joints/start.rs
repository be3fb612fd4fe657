//! Joints that are there from the beginning: those of joint sets, and all joints if they are intrinsic.

use crate::cohesive::JointPlane;
use crate::error::ModelError;
use crate::joints::Joints;
use crate::model::Model;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::team::Team;
use crate::topology::{NONE, Topology};

impl<const D: usize> Joints<D> {
    /// The joint set of a facet.
    pub(crate) fn set(&self, facet: u32) -> Option<u32> {
        self.sets.get(self.class[facet as usize] as usize).copied().filter(|&set| set != NONE)
    }

    /// Inserts undamaged joints on all facets that can break. [`Joints::part`] gives them the traction of the
    /// initial stress.
    pub(crate) fn everywhere<const N: usize>(
        &mut self,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
    ) -> Result<(), ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.at_once(Self::may_part, model, topology).map(|_| ())
    }

    /// Inserts undamaged joints on the facets of all joint sets.
    pub(crate) fn of_sets<const N: usize>(
        &mut self,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
    ) -> Result<(), ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let facets = self.at_once(|joints, facet| joints.set(facet).is_some(), model, topology)?;
        let corners = facets.iter().flat_map(|&facet| topology.facets[facet as usize].corners[0]);
        let mut vertices: Vec<u32> = corners.map(|corner| topology.vertices[corner as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        if self.inserts() {
            self.find_tips(&vertices, topology, &Share::default(), &Team::ALONE);
        }
        Ok(())
    }

    /// Inserts undamaged joints on some facets, before the run. Returns these facets.
    fn at_once<const N: usize>(
        &mut self,
        chosen: impl Fn(&Self, u32) -> bool,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
    ) -> Result<Vec<u32>, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let facets: Vec<u32> =
            (0..topology.facets.len() as u32).filter(|&facet| chosen(self, facet)).collect();
        self.reserve(facets.len());
        for &facet in &facets {
            if let Some(law) = self.law(facet, model, topology)? {
                let joint = self.joint(facet, law, JointPlane::own(), model, topology, &Share::default());
                self.put(joint, topology, model.thickness);
            }
        }
        Ok(facets)
    }
}
