//! The elements around a vertex, and how they are cut.

use crate::joints::Joints;
use crate::joints::cut::{Cut, CutFacet, InsertionData, above};
use crate::joints::strength::measure_of;
use crate::simplex::Simplex;
use crate::topology::{Facet, NONE, Topology};

/// In neither of the two groups of a cut.
const OTHER: u8 = 2;

/// The elements around a vertex, in groups that facets without joints connect.
pub(super) struct Fan<'a, const D: usize, const N: usize> {
    vertex: u32,
    groups: Vec<u32>,
    joints: &'a Joints<D>,
    state: InsertionData<'a, D, N>,
}

impl<'a, const D: usize, const N: usize> Fan<'a, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The groups when these facets are cut, too.
    pub(super) fn new(
        vertex: u32,
        cut: &[u32],
        joints: &'a Joints<D>,
        state: InsertionData<'a, D, N>,
    ) -> Self {
        let mut groups = Vec::new();
        let holds = |facet| !cut.contains(&facet) && joints.of_facet[facet as usize] == NONE;
        state.topology.groups(vertex, holds, &mut groups);
        Self { vertex, groups, joints, state }
    }

    /// The group of each corner, in the order of [`Topology::corners_of`].
    pub(super) fn groups(&self) -> &[u32] {
        &self.groups
    }

    fn corners(&self) -> &[u32] {
        self.state.topology.corners_of(self.vertex)
    }

    /// The corners at this vertex on the two sides of a facet.
    fn beside(&self, facet: u32) -> [u32; 2] {
        let facet = &self.state.topology.facets[facet as usize];
        let end = end_at(facet, self.vertex, self.state.topology);
        facet.corners.map(|side| side[end])
    }

    /// Groups on the two sides of a facet.
    pub(super) fn groups_beside(&self, facet: u32) -> [u32; 2] {
        let group =
            |corner: u32| self.corners().binary_search(&corner).map_or(NONE, |place| self.groups[place]);
        self.beside(facet).map(group)
    }

    /// Whether the end of a joint at this vertex is closed: one node on both sides.
    pub(super) fn closed(&self, facet: u32) -> bool {
        let [a, b] = self.beside(facet).map(|corner| self.state.solid.node_at(corner));
        a == b
    }

    /// Number of groups that share the node of a corner.
    pub(super) fn groups_of_node(&self, corner: u32) -> usize {
        let solid = self.state.solid;
        let node = solid.node_at(corner);
        let all = (0..).zip(self.corners()).zip(&self.groups);
        // A group has the number of its first corner, and its corners have one node.
        all.filter(|((place, corner), group)| place == *group && solid.node_at(**corner) == node).count()
    }

    /// The cut between the groups on the two sides of a facet, through this facet, through `more` facets
    /// without joints, and through the closed joints between the groups.
    pub(super) fn cut(&self, facet: u32, more: &[u32]) -> Cut<D> {
        let InsertionData { solid, model, topology } = self.state;
        let sides = self.groups_beside(facet);
        let place = |group: u32| sides.iter().position(|&side| side == group);
        let groups: Box<[u8]> =
            self.groups.iter().map(|&group| place(group).map_or(OTHER, |side| side as u8)).collect();
        let mut mass = [0.0; 2];
        for (&corner, &group) in self.corners().iter().zip(&groups) {
            if let Some(mass) = mass.get_mut(usize::from(group)) {
                *mass += solid.element(corner as usize / N).corner_mass(model);
            }
        }
        let is_between = |beside: [u32; 2]| beside == sides || beside == [sides[1], sides[0]];
        let closed = topology.facets_around(self.vertex).map(|(other, _)| other).filter(|&other| {
            self.joints.of_facet[other as usize] != NONE
                && self.closed(other)
                && is_between(self.groups_beside(other))
        });
        let parts = more.iter().copied().chain(closed).map(|other| CutFacet {
            facet: other,
            corners: self.beside(other),
            turned: self.groups_beside(other)[0] != sides[0],
            size: measure_of(model, topology, &topology.facets[other as usize]) / D as f64,
        });
        Cut {
            facet,
            facets: more.into(),
            parts: parts.collect(),
            groups,
            share: mass[0] / (mass[0] + mass[1]),
        }
    }

    /// The cut along the plane of a facet, through all facets whose elements are on its two sides; `None` if
    /// one of them cannot get a joint.
    pub(super) fn cut_along(&self, facet: u32) -> Option<Cut<D>> {
        let whole = |facet: u32| self.joints.of_facet[facet as usize] == NONE;
        let above = above(facet, self.state);
        let group = self.groups_beside(facet)[0];
        let mut cut = vec![facet];
        let around = self.state.topology.facets_around(self.vertex);
        for (other, _) in around.filter(|(other, _)| *other != facet && whole(*other)) {
            let [a, b] = self.beside(other).map(&above);
            if self.groups_beside(other)[0] == group && a != b {
                if !self.joints.may_part(other) {
                    return None;
                }
                cut.push(other);
            }
        }
        let parted = Fan::new(self.vertex, &cut, self.joints, self.state);
        Some(parted.cut(facet, &cut))
    }
}

/// The end of a facet that is at a vertex.
pub(super) fn end_at<const D: usize, const N: usize>(
    facet: &Facet<D>,
    vertex: u32,
    topology: &Topology<D, N>,
) -> usize {
    let at = |corner: &u32| topology.vertices[*corner as usize] == vertex;
    facet.corners[0].iter().position(at).unwrap_or_default()
}
