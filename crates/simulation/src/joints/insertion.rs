//! Adaptive insertion: where joints are inserted, and with which traction.
//!
//! In whole material a facet gets a joint when the mean stress of its two elements reaches the strength on
//! the facet or on a plane near it (`joints/plane.rs`). At a free surface and at a crack tip, the traction at
//! the node is higher than in the elements. There the traction is computed from the force `R` with which the
//! other side of the facet holds side 0 at the node,
//!
//! ```text
//! R = m₀ a - f₀
//! ```
//! with `f₀` the sum of all forces on the elements of side 0 at the node, `m₀` their mass at the node, and
//! `a` the common acceleration of the two sides as long as they share the node. `R` acts on the area at the
//! node of the facet, and of a joint behind the tip whose end is still closed. When the two sides separate,
//! their joints begin with exactly this traction, so that no force jumps.
//!
//! At the end of an edge crack one more facet parts the two sides of a vertex. In space the front of a crack
//! is a line: at a vertex on it several faces must part together, and each of them alone is held by the
//! others. There the facet whose strength is used most gives a plane, and all facets between the elements on
//! its two sides are one cut, with one traction. The cut is a staircase, so that its area is that of the sum
//! of the vectors of its facets, and each facet takes a share by its projection.

use crate::cohesive::{JointPlane, Memory, use_of};
use crate::joints::plane::{breaks, mean_stress, plane_near, plane_of, side, traction};
use crate::joints::stress_level::{SUSPECT, StressLevel, nears};
use crate::joints::whole::Link;
use crate::joints::{Joints, Tip, VertexSplit, measure_of};
use crate::lanes::LANES;
use crate::model::{Insertion, Model, Strength};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::team::Team;
use crate::topology::{Facet, NONE, Topology};
use crate::vector::{Matrix, Point, add, dot, minus, unit};

/// The data of a run that insertion reads.
#[derive(Clone, Copy)]
struct InsertionData<'a, const D: usize, const N: usize> {
    solid: &'a Solid<D, N>,
    model: &'a Model<D, N>,
    topology: &'a Topology<D, N>,
}

impl<const D: usize> Joints<D> {
    /// Returns the facets, ascending, whose traction has reached their strength.
    pub(crate) fn failing<const N: usize>(
        &mut self,
        solid: &Solid<D, N>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Vec<u32>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if self.weakest.is_empty() {
            return Vec::new();
        }
        let state = InsertionData { solid, model, topology };
        let mut near = std::mem::take(&mut self.near);
        let suspects = team.change(&mut near, |first, chunk| {
            let mut failing = Vec::new();
            for (batch, near) in (first / LANES..).zip(chunk.chunks_mut(LANES)) {
                let (weakest, deformed) = (&self.weakest[batch], solid.deformed(batch));
                nears::<D, N>(solid.available, &self.slopes, deformed, weakest, near);
                for (lane, near) in near.iter_mut().enumerate() {
                    // The circle itself costs more than its bound.
                    if *near == StressLevel::Failing {
                        *near =
                            self.slopes.near(weakest[lane], <[[f64; D]; N]>::circle(&deformed.stress(lane)));
                    }
                    if *near == StressLevel::Failing {
                        failing.push((batch * LANES + lane) as u32);
                    }
                }
            }
            failing
        });
        self.near = near;
        let suspects = suspects.concat();
        let whole = team.look(suspects.len(), |range| {
            let mut failing = Vec::new();
            for &element in &suspects[range] {
                self.failing_beside(element, state, &mut failing);
            }
            failing
        });
        let tips = team.look(self.tips.len(), |range| {
            let mut failing = Vec::new();
            for tip in &self.tips[range] {
                self.failing_at(tip, state, &mut failing);
            }
            failing
        });
        let mut failing = [whole, tips].concat().concat();
        failing.sort_unstable();
        failing.dedup();
        failing
    }

    /// Inserts joints on these facets, and splits the nodes at which elements are no longer connected.
    /// Returns the vertices at which this rank has done so.
    pub(crate) fn insert<const N: usize>(
        &mut self,
        failing: &[u32],
        solid: &mut Solid<D, N>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
    ) -> Vec<VertexSplit<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut vertices = Vec::new();
        for &facet in failing {
            // The laws of all facets were checked together with the model.
            if let Ok(Some(law)) = self.law(facet, model, topology) {
                let plane = self.plane(facet, solid, topology);
                self.put(facet, law, plane, topology, model, solid.share());
                let corners = topology.facets[facet as usize].corners[0];
                vertices.extend(corners.map(|corner| topology.vertices[corner as usize]));
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        let mut split = Vec::new();
        for &vertex in &vertices {
            if topology.corners_of(vertex).iter().any(|&corner| solid.share().corner(corner)) {
                split.push((vertex, self.part(vertex, solid, true, model, topology)));
            }
        }
        if !vertices.is_empty() {
            self.find_tips(&vertices, topology, solid.share());
        }
        split
    }

    /// Finds the facets at these vertices, ascending, that alone connect elements there, and can get a joint.
    /// Other joints at the vertices of a facet change the result at these vertices only.
    pub(super) fn find_tips<const N: usize>(
        &mut self,
        vertices: &[u32],
        topology: &Topology<D, N>,
        share: &Share,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.tips.retain(|tip| vertices.binary_search(&tip.vertex).is_err());
        let mut alone = Vec::new();
        for &vertex in vertices {
            topology.bridges(vertex, |facet| self.of_facet[facet as usize] == NONE, &mut alone);
            let owned = |(_, corner): &(u32, u32)| share.corner(*corner);
            let all = || topology.facets_around(vertex).filter(owned).map(|(facet, _)| facet);
            let together: Box<[u32]> = all()
                .filter(|facet| {
                    self.of_facet[*facet as usize] == NONE && self.may_part(*facet) && !alone.contains(facet)
                })
                .collect();
            alone
                .retain(|&facet| self.may_part(facet) && (share.is_whole() || all().any(|own| own == facet)));
            if !alone.is_empty() || !together.is_empty() {
                self.tips.push(Tip { vertex, alone: alone.as_slice().into(), together });
            }
        }
    }

    /// The strength of a facet that a plane near it may have in its place: the facets of an interface lie in
    /// the plane that is weak.
    pub(super) fn strength_of_planes(&self, facet: u32) -> Option<Strength> {
        let of_interface = self.of_interface.get(self.class[facet as usize] as usize) == Some(&true);
        self.strength(facet).filter(|_| !of_interface)
    }

    /// The plane that a joint on a facet would represent.
    fn plane<const N: usize>(
        &self,
        facet: u32,
        solid: &Solid<D, N>,
        topology: &Topology<D, N>,
    ) -> JointPlane<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let sides = &topology.facets[facet as usize];
        self.strength_of_planes(facet).map_or(JointPlane::own(), |strength| {
            plane_of::<D, N>(&side(solid, sides), &mean_stress(solid, sides), &strength)
        })
    }

    /// Use of the strength on a plane near a facet over that on the facet, at least 1.
    fn excess<const N: usize>(&self, facet: u32, state: InsertionData<'_, D, N>) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let sides = &topology.facets[facet as usize];
        self.strength_of_planes(facet).map_or(1.0, |strength| {
            plane_near::<D, N>(&side(solid, sides), &mean_stress(solid, sides), &strength).excess
        })
    }

    /// Use of the strength of a facet by the mean stress of its two elements; 0 if the facet has a joint or
    /// cannot break.
    fn used<const N: usize>(&self, facet: u32, state: InsertionData<'_, D, N>) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let strength = self.strength(facet).filter(|_| self.of_facet[facet as usize] == NONE);
        strength.map_or(0.0, |strength| {
            use_of(&strength, traction(state.solid, &state.topology.facets[facet as usize]))
        })
    }

    /// Adds the facets of an element near failure that fail by the mean stress of their two elements. A facet
    /// between two such elements belongs to the first.
    fn failing_beside<const N: usize>(
        &self,
        element: u32,
        state: InsertionData<'_, D, N>,
        failing: &mut Vec<u32>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { topology, .. } = state;
        for facet in topology.facet_of[element as usize].into_iter().filter(|&facet| facet != NONE) {
            let [first, _] = topology.facets[facet as usize].elements();
            if first != element && self.near[first as usize] == StressLevel::Failing {
                continue;
            }
            if breaks(self.used(facet, state), || self.excess(facet, state)) {
                failing.push(facet);
            }
        }
    }

    /// Adds the failing facets at a vertex on a free surface or at a crack tip: those where the traction that
    /// holds their two sides together at the vertex reaches the strength.
    fn failing_at<const N: usize>(&self, tip: &Tip, state: InsertionData<'_, D, N>, failing: &mut Vec<u32>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let &Tip { vertex, ref alone, ref together } = tip;
        // The force that moves a held node is unknown here. There the mean traction of the elements decides.
        if solid.hold_at(topology.corners_of(vertex)[0]) != NONE {
            return;
        }
        let used = |facet: u32| {
            let beside = topology.facets[facet as usize].elements();
            let far = beside.iter().all(|&element| self.near[element as usize] == StressLevel::Far);
            if far { 0.0 } else { self.used(facet, state) }
        };
        for &facet in alone.iter().filter(|&&facet| used(facet) >= SUSPECT) {
            self.fails_with(&[facet], vertex, state, failing);
        }
        let all = together.iter().map(|&facet| (used(facet), facet)).filter(|(used, _)| *used >= SUSPECT);
        let most = all.reduce(|most, next| if next.0 > most.0 { next } else { most });
        if let Some(cut) = most.and_then(|(_, facet)| self.cut_along(facet, vertex, state)) {
            self.fails_with(&cut, vertex, state, failing);
        }
    }

    /// The facets that separate the elements at a vertex on the two sides of the plane of a facet, that facet
    /// first; `None` if one of them cannot get a joint.
    fn cut_along<const N: usize>(
        &self,
        facet: u32,
        vertex: u32,
        state: InsertionData<'_, D, N>,
    ) -> Option<Vec<u32>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let whole = |facet: u32| self.of_facet[facet as usize] == NONE;
        let mut groups = Vec::new();
        topology.groups(vertex, whole, &mut groups);
        let fan = Fan { vertex, groups: &groups, joints: self, state };
        let normal = <[[f64; D]; N]>::facet_normal(&side(solid, &topology.facets[facet as usize]));
        let above = |corner: u32| {
            let middle = solid.shape(corner / N as u32);
            let at = middle[corner as usize % N];
            middle.iter().map(|&place| dot(minus(place, at), normal)).sum::<f64>() > 0.0
        };
        let group = fan.groups_beside(facet)[0];
        let mut cut = vec![facet];
        for (other, _) in topology.facets_around(vertex).filter(|(other, _)| *other != facet && whole(*other))
        {
            let [a, b] = fan.beside(other).map(above);
            if fan.groups_beside(other)[0] == group && a != b {
                if !self.may_part(other) {
                    return None;
                }
                cut.push(other);
            }
        }
        Some(cut)
    }

    /// Adds these facets to those that fail if the traction at the vertex does that holds the two sides of
    /// the first together, when all are cut.
    fn fails_with<const N: usize>(
        &self,
        cut: &[u32],
        vertex: u32,
        state: InsertionData<'_, D, N>,
        failing: &mut Vec<u32>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { topology, .. } = state;
        let Some(&facet) = cut.first() else { return };
        let mut groups = Vec::new();
        let holds = |other| !cut.contains(&other) && self.of_facet[other as usize] == NONE;
        topology.groups(vertex, holds, &mut groups);
        let fan = Fan { vertex, groups: &groups, joints: self, state };
        let sides = fan.groups_beside(facet);
        let (held, axes) = fan.held_by(facet, sides, cut);
        let traction = axes.map(|axis| dot(held, axis));
        let used = self.strength(facet).map_or(0.0, |strength| use_of(&strength, traction));
        if breaks(used, || self.excess(facet, state)) {
            failing.extend(cut);
        }
    }

    /// Splits the node of a vertex, so that each group of elements between joints has a separate node. Joint
    /// ends that open begin with the traction that acts there, if forces have `pulled` at the elements.
    /// Returns these tractions, each with its facet.
    pub(crate) fn part<const N: usize>(
        &mut self,
        vertex: u32,
        solid: &mut Solid<D, N>,
        pulled: bool,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
    ) -> Vec<(u32, [f64; D])>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let corners = topology.corners_of(vertex);
        let mut groups = Vec::new();
        topology.groups(vertex, |facet| self.of_facet[facet as usize] == NONE, &mut groups);
        // Tractions of the ends that open now, computed before the nodes are split.
        let mut begin: Vec<(u32, [f64; D])> = Vec::new();
        if pulled && solid.hold_at(corners[0]) == NONE {
            let state = InsertionData { solid, model, topology };
            let fan = Fan { vertex, groups: &groups, joints: self, state };
            let owned = |(_, corner): &(u32, u32)| solid.share().corner(*corner);
            for (facet, corner) in topology.facets_around(vertex).filter(owned) {
                let sides = fan.groups_beside(facet);
                if sides[0] != sides[1] && fan.closed(facet) && fan.groups_of_node(corner) == 2 {
                    let (held, axes) = fan.held_by(facet, sides, &[]);
                    let share = <[[f64; D]; N]>::projection(fan.normal(facet, sides), axes[0]);
                    let traction = held.map(|x| share * x);
                    begin.push((facet, components(traction, solid, &topology.facets[facet as usize])));
                }
            }
        }
        let (owned, groups) = solid.share().owned(corners, &groups);
        for node in solid.split(&owned, &groups) {
            solid.weigh(node, model);
        }
        self.open_at(vertex, &owned, &begin, solid, topology);
        begin
    }

    /// Marks the ends of joints at these corners of a vertex as open that have two nodes now. `begin`:
    /// tractions with which some ends begin, by their facets.
    pub(crate) fn open_at<const N: usize>(
        &mut self,
        vertex: u32,
        corners: &[u32],
        begin: &[(u32, [f64; D])],
        solid: &Solid<D, N>,
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        for &corner in corners {
            for facet in topology.facets_at(corner) {
                let known = begin.iter().find(|(other, _)| *other == facet).map(|(_, traction)| *traction);
                self.open(facet, vertex, known, solid, topology);
            }
        }
    }

    /// Marks an end of a joint as open if it has two nodes now. `known`: the traction that held them
    /// together; if it is `None`, that of the two elements is taken.
    fn open<const N: usize>(
        &mut self,
        facet: u32,
        vertex: u32,
        known: Option<[f64; D]>,
        solid: &Solid<D, N>,
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if facet == NONE {
            return;
        }
        let number = self.of_facet[facet as usize] as usize;
        let Some(joint) = self.all.get_mut(number) else { return };
        let sides = &topology.facets[facet as usize];
        let end = end_at(sides, vertex, topology);
        joint.find_nodes(sides, solid);
        let [a, b] = joint.nodes[end];
        if !joint.open[end] && a != b {
            joint.open[end] = true;
            if joint.open_from_start {
                joint.ends[end] = Memory::broken();
            } else if self.insertion == Insertion::Adaptive || solid.is_prestressed() {
                let traction = known.unwrap_or_else(|| traction(solid, sides));
                joint.ends[end] = Memory::under(&joint.law, traction);
                if joint.counted {
                    self.inserted.add(joint.share(solid.thickness) * joint.ends[end].stored(&joint.law));
                }
            }
        }
        self.links[number] = Link::of(joint, solid.thickness);
    }
}

/// The part of an undeformed facet that belongs to each of its vertices, m or m².
fn part_of<const D: usize, const N: usize>(facet: u32, state: InsertionData<'_, D, N>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    measure_of(state.model, state.topology, &state.topology.facets[facet as usize]) / D as f64
}

/// The elements around a vertex, in groups.
struct Fan<'a, const D: usize, const N: usize> {
    vertex: u32,
    groups: &'a [u32],
    joints: &'a Joints<D>,
    state: InsertionData<'a, D, N>,
}

impl<const D: usize, const N: usize> Fan<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
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
    fn groups_beside(&self, facet: u32) -> [u32; 2] {
        let group =
            |corner: u32| self.corners().binary_search(&corner).map_or(NONE, |place| self.groups[place]);
        self.beside(facet).map(group)
    }

    /// Whether the end of a joint at this vertex is closed: one node on both sides.
    fn closed(&self, facet: u32) -> bool {
        let [a, b] = self.beside(facet).map(|corner| self.state.solid.node_at(corner));
        a == b
    }

    /// How many groups share the node of a corner.
    fn groups_of_node(&self, corner: u32) -> usize {
        let solid = self.state.solid;
        let node = solid.node_at(corner);
        let all = self.corners().iter().zip(self.groups);
        let mut groups: Vec<u32> =
            all.filter(|(corner, _)| solid.node_at(**corner) == node).map(|(_, &group)| group).collect();
        groups.sort_unstable();
        groups.dedup();
        groups.len()
    }

    /// Traction, Pa, with which group `sides[1]` holds group `sides[0]` across their cut, and the axes of the
    /// cut: its unit normal, out of `sides[0]`, and directions along it. The cut consists of the closed
    /// joints between the two groups at the vertex, among them `facet`, and of the facets `more`; each counts
    /// by its projection on the plane of the cut.
    fn held_by(&self, facet: u32, sides: [u32; 2], more: &[u32]) -> (Point<D>, Matrix<D>) {
        let InsertionData { solid, model, topology } = self.state;
        let (mut force, mut mass) = ([[0.0; D]; 2], [0.0; 2]);
        for (&corner, &group) in self.corners().iter().zip(self.groups) {
            let Some(side) = sides.iter().position(|&side| side == group) else { continue };
            let mut total = solid.force(corner);
            self.joints.add_force(corner, &mut total);
            for axis in 0..D {
                force[side][axis] += total[axis];
            }
            mass[side] += solid.element(corner as usize / N).corner_mass(model);
        }
        let is_between = |beside: [u32; 2]| beside == sides || beside == [sides[1], sides[0]];
        let closed = topology.facets_around(self.vertex).map(|(other, _)| other).filter(|&other| {
            self.joints.of_facet[other as usize] != NONE
                && self.closed(other)
                && is_between(self.groups_beside(other))
        });
        let parts: Vec<(Point<D>, f64)> = (more.iter().copied().chain(closed))
            .map(|other| (self.normal(other, sides), part_of(other, self.state)))
            .collect();
        let mut sum = [0.0; D];
        for (normal, part) in &parts {
            add(&mut sum, *normal, *part);
        }
        let axes = <[[f64; D]; N]>::cut_axes(&side(solid, &topology.facets[facet as usize]), sum);
        let width: f64 =
            parts.iter().map(|(normal, part)| part * <[[f64; D]; N]>::projection(*normal, axes[0])).sum();
        // Gravity accelerates both sides equally, so it cancels. With added mass it cancels at rest, because
        // the masses are the true ones here.
        let share = mass[0] / (mass[0] + mass[1]);
        let held = std::array::from_fn(|axis| {
            let held = share * (force[0][axis] + force[1][axis]) - force[0][axis];
            held / (width * solid.thickness)
        });
        (held, axes)
    }

    /// The unit normal of a facet, out of group `sides[0]`.
    fn normal(&self, facet: u32, sides: [u32; 2]) -> Point<D> {
        let InsertionData { solid, topology, .. } = self.state;
        let normal = unit(<[[f64; D]; N]>::facet_normal(&side(solid, &topology.facets[facet as usize])));
        if self.groups_beside(facet)[0] == sides[0] { normal } else { normal.map(|x| -x) }
    }
}

/// The end of a facet that is at a vertex.
fn end_at<const D: usize, const N: usize>(facet: &Facet<D>, vertex: u32, topology: &Topology<D, N>) -> usize {
    let at = |corner: &u32| topology.vertices[*corner as usize] == vertex;
    facet.corners[0].iter().position(at).unwrap_or_default()
}

/// Components of a traction on side 0 of a facet: across it (tension positive) and along it.
fn components<const D: usize, const N: usize>(
    traction: Point<D>,
    solid: &Solid<D, N>,
    facet: &Facet<D>,
) -> [f64; D]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    <[[f64; D]; N]>::axes(&side(solid, facet)).map(|axis| dot(traction, unit(axis)))
}
