//! Facets on the surface of the mesh on which boundaries act.

use crate::error::ModelError;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::topology::{Topology, are_alike};

/// An outer facet, by its corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OuterSide<const D: usize> {
    pub(crate) corners: [u32; D],
    /// Undeformed length, m, or area, m².
    pub(crate) measure: f64,
}

/// The outer facet between nodes of the mesh, which go around it in this order, from any of them on.
pub(crate) fn outer_side<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
    facet: [u32; D],
    name: &str,
) -> Result<OuterSide<D>, ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let vertices = |corners: &[u32; D]| corners.map(|corner| topology.vertices[corner as usize]);
    let around = |corners: &[u32; D]| are_alike(&vertices(corners), &facet);
    let corners = topology
        .surface_at(facet[0])
        .find(around)
        .ok_or_else(|| ModelError::NotOuter { boundary: name.to_owned(), facet: facet.to_vec() })?;
    let measure = <[[f64; D]; N]>::facet_measure(&facet.map(|node| model.mesh.nodes[node as usize]));
    Ok(OuterSide { corners, measure })
}
