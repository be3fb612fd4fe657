//! Liquid in the pores of a model: its constants, the materials with pores, and their drained surfaces.

use fdem_fluid::{Drive, PoreLiquid, PorousMaterial};
use serde::{Deserialize, Serialize};

use crate::model::target::Target;

/// Liquid in the pores of the elements of a model, which flows by Darcy's law and pushes them apart (Biot).
///
/// Stresses of elements, of [`Model::stresses`](crate::Model::stresses) and of results are then effective
/// ones, `σ' = σ + α p`, and strengths are compared with them. Densities of materials are those with the
/// liquid. Strains are small as far as the flow is concerned.
///
/// Together with [`FluidOptions`](crate::FluidOptions), cracks and pores exchange fluid: volumes are those at
/// the reference density of the fluid in cracks, whose leak-off must be zero.
///
/// Neither in plane stress nor on many ranks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; D]: Serialize, [[f64; D]; D]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; D]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>"
))]
pub struct PoreOptions<const D: usize = 2> {
    /// The liquid and its weight in the flow.
    pub liquid: PoreLiquid<D>,
    /// The pores of each material; `None` for a material without pores, through which nothing flows.
    pub materials: Vec<Option<PorousMaterial<D>>>,
    /// Pressure at each node of the mesh at the beginning, Pa; empty for zero. Pores without weight and flow
    /// begin in equilibrium with stresses that are effective ones.
    pub initial_pressures: Vec<f64>,
    /// Surfaces and wells. The rest of the surface is sealed, and cracks are neither sealed nor drained.
    pub surfaces: Vec<PoreSurface<D>>,
    /// Number of steps of the solid in each step of the flow, at least 1. Pressures follow the volumes of
    /// elements in each step of the solid.
    pub steps: u32,
}

impl<const D: usize> PoreOptions<D> {
    /// Sealed pores without pressure, and a step of the flow in ten steps of the solid.
    pub fn new(liquid: PoreLiquid<D>, materials: Vec<Option<PorousMaterial<D>>>) -> Self {
        Self { liquid, materials, initial_pressures: Vec::new(), surfaces: Vec::new(), steps: 10 }
    }

    /// The pores of a material.
    pub(crate) fn material(&self, number: u32) -> Option<&PorousMaterial<D>> {
        self.materials.get(number as usize)?.as_ref()
    }

    /// `α p` at the beginning of an element with these nodes, Pa; zero without pores.
    pub fn first_push<const N: usize>(&self, nodes: &[u32; N], material: u32) -> f64 {
        let pressure = |node: &u32| self.initial_pressures.get(*node as usize).copied().unwrap_or(0.0);
        let mean = nodes.iter().map(pressure).sum::<f64>() / N as f64;
        self.material(material).map_or(0.0, |pores| pores.biot * mean)
    }

    /// The pores of a part of a model: surfaces have the nodes that are left, and those without any are left
    /// out. `nodes`: the number in the part of each node.
    pub(crate) fn on_part(mut self, nodes: &[Option<u32>]) -> Self {
        let number = |node: u32| nodes.get(node as usize).copied().flatten();
        for surface in &mut self.surfaces {
            match &mut surface.target {
                Target::Nodes(all) => all.retain(|node| number(*node).is_some()),
                Target::Facets(facets) | Target::Held(facets, _) => {
                    facets.retain(|facet| facet.iter().all(|node| number(*node).is_some()));
                }
            }
            for node in surface.target.nodes_mut() {
                *node = number(*node).unwrap_or(*node);
            }
        }
        self.surfaces.retain(|surface| !surface.target.is_empty());
        let left = nodes.iter().zip(&self.initial_pressures).filter(|(node, _)| node.is_some());
        self.initial_pressures = left.map(|(_, pressure)| *pressure).collect();
        self
    }
}

/// A part of the surface of pores that is drained, or through which liquid comes in; or a well.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[u32; D]: Serialize, [[f64; D]; D]: Serialize",
    deserialize = "[u32; D]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>"
))]
pub struct PoreSurface<const D: usize = 2> {
    /// Name, for messages; no other surface of pores has it.
    pub name: String,
    /// Facets or nodes.
    pub target: Target<D>,
    /// Pressure, or rate of the whole, m³/s: by the areas of facets, or equally for nodes. Times are those of
    /// the run.
    pub drive: Drive,
}
