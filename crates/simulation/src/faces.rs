//! The faces of bodies that can be seen from outside: outer facets of the mesh, and both sides of each broken
//! joint.
//!
//! The list is kept while joints break. Contact begins at its vertices, and cracks spread from them; seams
//! look for outer facets that touch; cavities follow the sides of broken joints.

use fdem_distributed::wire;

use crate::simplex::Simplex;
use crate::topology::{Facet, Topology};

/// The list of faces.
#[derive(Clone, Debug)]
pub(crate) struct Faces<const D: usize> {
    /// Outer facets, each by its corners, in the order of the elements.
    pub(crate) outer: Vec<[u32; D]>,
    /// Facets between elements whose joint has broken, in the order in which they were noted. Both of their
    /// sides are faces.
    pub(crate) broken: Vec<u32>,
}

impl<const D: usize> Faces<D> {
    /// The faces of a mesh that is whole.
    pub(crate) fn new<const N: usize>(topology: &Topology<D, N>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        Self { outer: topology.surface().collect(), broken: Vec::new() }
    }

    /// Whether each vertex is on a face.
    pub(crate) fn vertices<const N: usize>(&self, topology: &Topology<D, N>) -> Vec<bool>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut on = vec![false; topology.vertex_count()];
        let broken = self.broken.iter().map(|&facet| topology.facets[facet as usize].corners[0]);
        for corner in self.outer.iter().copied().chain(broken).flatten() {
            on[topology.vertices[corner as usize] as usize] = true;
        }
        on
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.outer) + size_of_val(&*self.broken)
    }
}

/// A joint that has broken, with the names that are the same on all ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BrokenSides<const D: usize> {
    /// Codes of its two sides. The first is that of its facet.
    pub(crate) sides: [u32; 2],
    /// Numbers of its vertices in the whole mesh.
    pub(crate) vertices: [u32; D],
}

wire!([const D: usize] BrokenSides<D> { sides, vertices });

impl<const D: usize> BrokenSides<D> {
    /// The broken joint on a facet.
    pub(crate) fn of<const N: usize>(facet: &Facet<D>, topology: &Topology<D, N>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        Self {
            sides: facet.corners.map(|side| topology.code_of_side(&side)),
            vertices: facet.corners[0].map(|corner| topology.vertex(topology.vertices[corner as usize])),
        }
    }
}
