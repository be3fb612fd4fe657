//! The places on which boundaries act.

use serde::{Deserialize, Serialize};

/// Nodes or facets on which a [`Boundary`](crate::Boundary) acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[u32; D]: Serialize, [[f64; D]; D]: Serialize",
    deserialize = "[u32; D]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>"
))]
pub enum Target<const D: usize = 2> {
    /// Nodes of the mesh.
    Nodes(Vec<u32>),
    /// Facets of elements by their nodes, which go around them counter-clockwise, seen from outside.
    Facets(Vec<[u32; D]>),
    /// Facets of elements, with the force on each of their nodes, N: for [`Load::Held`](crate::Load::Held).
    Held(Vec<[u32; D]>, Vec<[[f64; D]; D]>),
}

impl<const D: usize> Target<D> {
    /// Whether it has no nodes and no facets.
    pub(crate) fn is_empty(&self) -> bool {
        match self {
            Self::Nodes(nodes) => nodes.is_empty(),
            Self::Facets(facets) | Self::Held(facets, _) => facets.is_empty(),
        }
    }

    /// Nodes of the target, each once, ascending.
    pub fn nodes(&self) -> Vec<u32> {
        let mut nodes = match self {
            Self::Nodes(nodes) => nodes.clone(),
            Self::Facets(facets) | Self::Held(facets, _) => facets.as_flattened().to_vec(),
        };
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Nodes of the target as it has them, to be given other numbers.
    pub fn nodes_mut(&mut self) -> &mut [u32] {
        match self {
            Self::Nodes(nodes) => nodes,
            Self::Facets(facets) | Self::Held(facets, _) => facets.as_flattened_mut(),
        }
    }

    /// Its facets; none if it has nodes alone.
    pub fn facets(&self) -> &[[u32; D]] {
        match self {
            Self::Nodes(_) => &[],
            Self::Facets(facets) | Self::Held(facets, _) => facets,
        }
    }
}
