//! The surfaces of bodies.

use super::vector::Point;

/// The region outside of all bodies.
pub const OUTSIDE: u32 = u32::MAX;

/// The region on both sides of a facet inside of any region: such a facet becomes facets of the mesh, and
/// separates nothing.
pub const INNER: u32 = u32::MAX - 1;

/// Closed surfaces that bound one or several regions.
///
/// Facets of one face need not be in one plane. Facets meet in common nodes and edges only. Regions may share
/// facets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Coordinates `[n]`, in any unit of length.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the triangles `[m]`.
    pub facets: Vec<[u32; 3]>,
    /// Face of each facet `[m]`.
    pub faces: Vec<u32>,
    /// Regions behind and before each facet `[m]`, or [`OUTSIDE`], or [`INNER`] on both sides: its corners
    /// are counter-clockwise seen from before.
    pub sides: Vec<[u32; 2]>,
    /// Names of the first faces; faces beyond have none.
    pub names: Vec<String>,
}

impl Surface {
    pub(crate) fn corners(&self, facet: usize) -> [Point; 3] {
        self.facets[facet].map(|node| self.nodes[node as usize])
    }
}
