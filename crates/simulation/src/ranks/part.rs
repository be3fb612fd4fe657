//! Data of a rank about its part of a run.

use crate::action::Wide;
use crate::joints::saved::MovingJoint;

/// A part of a run, apart from the fields of every [`Simulation`](crate::Simulation).
#[derive(Debug)]
pub(crate) struct RankPart<const D: usize> {
    /// The rank that owns each corner.
    pub(super) owners: Vec<u32>,
    /// Code of the first corner of each vertex in the whole mesh.
    pub(super) first: Vec<u32>,
    pub(super) wide: Wide,
    /// For each boundary, the places of its facets among all of its facets.
    pub(super) places: Vec<Vec<u32>>,
    /// Joints that this rank counts, and whose other element is elsewhere: they have no force any more.
    pub(super) loose_joints: Vec<MovingJoint<D>>,
}

impl<const D: usize> RankPart<D> {
    /// Whether a corner, by its code, is the first of a vertex in the whole mesh.
    pub(super) fn is_first(&self, vertex: u32, code: u32) -> bool {
        self.first[vertex as usize] == code
    }
}
