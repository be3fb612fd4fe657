//! Cuts at a vertex: which facets part two groups of its elements, and the traction with which one group
//! holds the other there.
//!
//! The elements of a cut change only when joints at the vertex do. A cut is kept from step to step, because
//! to find it takes ten times as long as to sum its forces.

use crate::joints::plane::side;
use crate::joints::slack::NORMAL;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Topology;
use crate::vector::{Matrix, Point, add, contraction, dot, length, minus, unit};

/// Height of an element above a plane, over the lengths of its edges, up to which it lies in the plane.
const IN_PLANE: f64 = 1e-9;

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
    /// The group of each corner of the vertex: 0, 1, or neither.
    pub(super) groups: Box<[u8]>,
    /// The facets between the groups: `facets`, and those of closed joints.
    pub(super) parts: Box<[CutFacet]>,
    /// Mass of group 0 over that of both.
    pub(super) share: f64,
}

/// The traction that holds the two groups of a cut together.
pub(super) struct Pull<const D: usize> {
    /// Traction, Pa, with which group 1 holds group 0.
    pub(super) traction: Point<D>,
    /// The unit normal of the cut, out of group 0, and directions along it.
    pub(super) axes: Matrix<D>,
    /// Width of the cut at the vertex, m or m².
    width: f64,
    /// The sizes of its facets together, over the width and over the length of the sum of their normals.
    folds: [f64; 2],
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
        let Self { facets, groups, parts, .. } = self;
        size_of::<Self>() + size_of_val(&**facets) + size_of_val(&**groups) + size_of_val(&**parts)
    }

    /// Whether all of its facets still have one node on both sides at the vertex.
    pub(super) fn holds<const N: usize>(&self, state: InsertionData<'_, D, N>) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.parts.iter().all(|part| {
            let [a, b] = part.corners.map(|corner| state.solid.node_at(corner));
            a == b
        })
    }

    /// The traction with which group 1 holds group 0 across the cut. `force_on`: the force on a corner, N.
    /// Each facet counts by its projection on the plane of the cut.
    pub(super) fn held<const N: usize>(
        &self,
        vertex: u32,
        force_on: impl Fn(u32) -> Point<D>,
        state: InsertionData<'_, D, N>,
    ) -> Pull<D>
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
        let (mut sum, mut sizes) = ([0.0; D], 0.0);
        for (normal, size) in &parts {
            add(&mut sum, *normal, *size);
            sizes += size;
        }
        let axes = <[[f64; D]; N]>::cut_axes(&side(solid, &topology.facets[self.facet as usize]), sum);
        let projected =
            |(normal, size): &(Point<D>, f64)| size * <[[f64; D]; N]>::projection(*normal, axes[0]);
        let width: f64 = parts.iter().map(projected).sum();
        // Gravity accelerates both sides equally, so it cancels. With added mass it cancels at rest, because
        // the masses are the true ones here.
        let traction = std::array::from_fn(|axis| {
            let held = self.share * (force[0][axis] + force[1][axis]) - force[0][axis];
            held / (width * solid.thickness)
        });
        Pull { traction, axes, width, folds: [sizes / width, sizes / length(sum)] }
    }

    /// Largest change of the traction across the cut, over the change of the stresses around the vertex; and
    /// its largest change by changes of the shapes up to [`TURN`](crate::solid::watch::TURN), Pa.
    ///
    /// The force on a corner is the stress times a vector of area, a `D`-th of the facet opposite. Such a
    /// vector changes with the shape by at most twice [`NORMAL`] of its length, the width of the cut by three
    /// times, and its normal turns by twice that angle, both times the folds.
    pub(super) fn sensitivity<const N: usize>(
        &self,
        vertex: u32,
        pull: &Pull<D>,
        state: InsertionData<'_, D, N>,
    ) -> [f64; 2]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let (mut follows, mut largest) = (0.0, 0.0_f64);
        for (&corner, &group) in topology.corners_of(vertex).iter().zip(&self.groups) {
            let share = match group {
                0 => 1.0 - self.share,
                1 => self.share,
                _ => continue,
            };
            let (element, place) = (corner / N as u32, corner as usize % N);
            let shape = solid.shape(element);
            let opposite: [Point<D>; D] = std::array::from_fn(|k| shape[(place + 1 + k) % N]);
            follows += share * <[[f64; D]; N]>::facet_measure(&opposite) / D as f64;
            let stress = solid.stress(element as usize);
            largest = largest.max(contraction(&stress, &stress));
        }
        let follows = follows * (1.0 + 4.0 * NORMAL) / pull.width;
        let [narrow, folded] = pull.folds;
        let turned = 2.0 * follows * largest.sqrt() + length(pull.traction) * folded * (3.0 * narrow + 9.0);
        [follows, NORMAL * turned]
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

/// Whether the element of a corner is above the plane of a facet through that corner, both undeformed: the
/// elements that a staircase parts do not change while it deforms. An element in the plane, but for
/// rounding, is below it.
pub(super) fn above<const D: usize, const N: usize>(
    facet: u32,
    state: InsertionData<'_, D, N>,
) -> impl Fn(u32) -> bool
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let InsertionData { model, topology, .. } = state;
    let place = |corner: u32| model.mesh.nodes[topology.vertices[corner as usize] as usize];
    let corners = topology.facets[facet as usize].corners[0].map(place);
    let normal = unit(<[[f64; D]; N]>::facet_normal(&corners));
    move |corner: u32| {
        let (at, first) = (place(corner), corner / N as u32 * N as u32);
        let offsets = || (first..first + N as u32).map(|other| minus(place(other), at));
        let height: f64 = offsets().map(|offset| dot(offset, normal)).sum();
        height > IN_PLANE * offsets().map(length).sum::<f64>()
    }
}
