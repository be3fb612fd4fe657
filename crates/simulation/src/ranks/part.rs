//! What a rank knows of its part of a run.

use fdem_distributed::wire;

use crate::joints::MovingJoint;
use crate::loads::Wide;
use crate::seams::SeamState;
use crate::sum::Sum;

/// A point of a seam, by the codes of its two sides and its place among their points.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeamPoint<const D: usize> {
    pub(super) sides: [u32; 2],
    pub(super) place: u32,
    pub(super) hold: SeamState<D>,
}

wire!([const D: usize] SeamPoint<D> { sides, place, hold });

/// A part of a run, besides what every [`Simulation`](crate::Simulation) has.
#[derive(Debug)]
pub(crate) struct RankPart<const D: usize> {
    /// The rank that owns each corner.
    pub(super) owners: Vec<u32>,
    /// Number of each vertex in the whole mesh.
    pub(super) vertices: Vec<u32>,
    /// Code of the first corner of each vertex in the whole mesh.
    pub(super) first: Vec<u32>,
    pub(super) wide: Wide,
    /// For each boundary, the places of its facets among all of its facets.
    pub(super) places: Vec<Vec<u32>>,
    /// Joints and points of seams that this rank counts, and whose other element is elsewhere: they have no
    /// force any more.
    pub(super) loose_joints: Vec<MovingJoint<D>>,
    pub(super) loose_seams: Vec<SeamPoint<D>>,
}

impl<const D: usize> RankPart<D> {
    /// Whether a corner, by its code, is the first of a vertex in the whole mesh.
    pub(super) fn is_first(&self, vertex: u32, code: u32) -> bool {
        self.first[vertex as usize] == code
    }

    /// Friction of loose points of seams, J.
    pub(crate) fn friction(&self) -> Sum {
        self.loose_seams.iter().map(|point| point.hold.friction()).collect()
    }
}
