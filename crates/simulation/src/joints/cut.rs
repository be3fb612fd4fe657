//! Cuts at a vertex: which facets part two groups of its elements, and the traction with which one group
//! holds the other there.
//!
//! The elements of a cut change only when joints at the vertex do, or, in space, when an element moves from
//! one side of its plane to the other. A cut is kept from step to step, because to find it takes ten times as
//! long as to sum its forces.

use crate::joints::plane::side;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Topology;
use crate::vector::{Matrix, Point, add, dot, minus, unit};

/// The data of a run that insertion reads.
#[derive(Clone, Copy)]
pub(super) struct InsertionData<'a, const D: usize, const N: usize> {
    pub(super) solid: &'a Solid<D, N>,
    pub(super) model: &'a Model<D, N>,
    pub(super) topology: &'a Topology<D, N>,
}

/// Two groups of elements at a vertex, and the facets between them.
#[derive(Clone, Debug)]
pub(super) struct Cut<const D: usize> {
    /// The facet that gives its plane.
    pub(super) facet: u32,
    /// The facets that get joints if the cut opens.
    pub(super) facets: Box<[u32]>,
    /// Whether each corner of the vertex is above that plane; empty if the plane does not decide.
    pub(super) above: Box<[bool]>,
    /// The group of each corner of the vertex: 0, 1, or neither.
    pub(super) groups: Box<[u8]>,
    /// The facets between the groups: `facets`, and those of closed joints.
    pub(super) parts: Box<[CutFacet]>,
    /// Mass of group 0 over that of both.
    pub(super) share: f64,
}

/// A facet between two groups.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutFacet {
    pub(super) facet: u32,
    /// The corners of its two sides at the vertex.
    pub(super) corners: [u32; 2],
    /// Whether its normal points into group 0.
    pub(super) turned: bool,
    /// Its undeformed size at the vertex, m or m².
    pub(super) size: f64,
}

impl<const D: usize> Cut<D> {
    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { facets, above, groups, parts, .. } = self;
        let lists = size_of_val(&**facets) + size_of_val(&**above) + size_of_val(&**groups);
        size_of::<Self>() + lists + size_of_val(&**parts)
    }

    /// Whether the elements at the vertex are still on the same sides of the plane, and all facets still have
    /// one node on both sides there: other ranks may split it, too.
    pub(super) fn holds<const N: usize>(&self, vertex: u32, state: InsertionData<'_, D, N>) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let one_node = |part: &CutFacet| {
            let [a, b] = part.corners.map(|corner| state.solid.node_at(corner));
            a == b
        };
        let above = above(self.facet, state);
        let mut known = self.above.iter().zip(state.topology.corners_of(vertex));
        self.parts.iter().all(one_node) && known.all(|(&known, &corner)| known == above(corner))
    }

    /// Traction, Pa, with which group 1 holds group 0 across the cut, and the axes of the cut: its unit
    /// normal, out of group 0, and directions along it. `force_on`: the force on a corner, N. Each facet
    /// counts by its projection on the plane of the cut.
    pub(super) fn held<const N: usize>(
        &self,
        vertex: u32,
        force_on: impl Fn(u32) -> Point<D>,
        state: InsertionData<'_, D, N>,
    ) -> (Point<D>, Matrix<D>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let mut force = [[0.0; D]; 2];
        for (&corner, &group) in topology.corners_of(vertex).iter().zip(&self.groups) {
            let Some(force) = force.get_mut(usize::from(group)) else { continue };
            add(force, force_on(corner), 1.0);
        }
        let parts: Vec<(Point<D>, f64)> =
            self.parts.iter().map(|part| (part.normal(state), part.size)).collect();
        let mut sum = [0.0; D];
        for (normal, size) in &parts {
            add(&mut sum, *normal, *size);
        }
        let axes = <[[f64; D]; N]>::cut_axes(&side(solid, &topology.facets[self.facet as usize]), sum);
        let projected =
            |(normal, size): &(Point<D>, f64)| size * <[[f64; D]; N]>::projection(*normal, axes[0]);
        let width: f64 = parts.iter().map(projected).sum();
        // Gravity accelerates both sides equally, so it cancels. With added mass it cancels at rest, because
        // the masses are the true ones here.
        let held = std::array::from_fn(|axis| {
            let held = self.share * (force[0][axis] + force[1][axis]) - force[0][axis];
            held / (width * solid.thickness)
        });
        (held, axes)
    }

    /// The unit normal of its facet, out of group 0.
    pub(super) fn normal<const N: usize>(&self, state: InsertionData<'_, D, N>) -> Point<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        normal(self.facet, false, state)
    }
}

impl CutFacet {
    /// The unit normal, out of group 0.
    fn normal<const D: usize, const N: usize>(&self, state: InsertionData<'_, D, N>) -> Point<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        normal(self.facet, self.turned, state)
    }
}

/// The unit normal of a facet out of its side 0, or out of its other side.
fn normal<const D: usize, const N: usize>(
    facet: u32,
    turned: bool,
    state: InsertionData<'_, D, N>,
) -> Point<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let normal =
        unit(<[[f64; D]; N]>::facet_normal(&side(state.solid, &state.topology.facets[facet as usize])));
    if turned { normal.map(|x| -x) } else { normal }
}

/// Whether the element of a corner is above the plane of a facet through that corner.
pub(super) fn above<const D: usize, const N: usize>(
    facet: u32,
    state: InsertionData<'_, D, N>,
) -> impl Fn(u32) -> bool
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let InsertionData { solid, topology, .. } = state;
    let normal = <[[f64; D]; N]>::facet_normal(&side(solid, &topology.facets[facet as usize]));
    move |corner: u32| {
        let middle = solid.shape(corner / N as u32);
        let at = middle[corner as usize % N];
        middle.iter().map(|&place| dot(minus(place, at), normal)).sum::<f64>() > 0.0
    }
}
