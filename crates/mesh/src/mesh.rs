//! The mesh of a set of bodies.

use serde::{Deserialize, Serialize};

/// Elements above which a mesh, or a model, is refused.
pub const MOST_ELEMENTS: usize = 20_000_000;

/// A mesh of triangles or of tetrahedra, which share nodes inside of a body: `D` dimensions, `N = D + 1`
/// corners.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; N]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; N]: Deserialize<'de>"
))]
pub struct Mesh<const D: usize = 2, const N: usize = 3> {
    /// Coordinates of the nodes, m. No two elements of different bodies share one.
    pub nodes: Vec<[f64; D]>,
    /// Nodes of each element: those of a triangle counter-clockwise; those of a tetrahedron such that the
    /// first three are counter-clockwise seen from the last.
    pub elements: Vec<[u32; N]>,
    /// Body of each element.
    pub bodies: Vec<u32>,
    /// Material of each element.
    pub materials: Vec<u32>,
}

impl<const D: usize, const N: usize> Mesh<D, N> {
    /// Centroid of an element, m.
    pub fn centroid(&self, element: usize) -> [f64; D] {
        let nodes = self.elements[element].map(|node| self.nodes[node as usize]);
        std::array::from_fn(|axis| nodes.iter().map(|node| node[axis]).sum::<f64>() / N as f64)
    }
}

/// Least and largest coordinates; infinite the wrong way round without points.
pub fn bounds<const D: usize>(points: impl Iterator<Item = [f64; D]>) -> [[f64; D]; 2] {
    let mut bounds = [[f64::INFINITY; D], [f64::NEG_INFINITY; D]];
    for point in points {
        for axis in 0..D {
            bounds[0][axis] = bounds[0][axis].min(point[axis]);
            bounds[1][axis] = bounds[1][axis].max(point[axis]);
        }
    }
    bounds
}
