//! Adaptive insertion: where joints are inserted, and with which traction.
//!
//! In whole material an edge gets a joint when the mean stress of its two elements reaches the strength on the edge or on a plane near it
//! (`joints/plane.rs`). At a free surface and at a crack tip, the traction
//! at the node is higher than in the elements. There the traction is computed from the force `R` with which the other side of the edge holds side 0 at the
//! node,
//!
//! ```text
//! R = m₀ a - f₀
//! ```
//! with `f₀` the sum of all forces on the elements of side 0 at the node, `m₀` their mass at the node, and `a` the common acceleration of the two sides as long
//! as they share the node. `R` acts on the area at the node of the edge, and of a joint behind the tip whose end is still closed. When the two sides separate,
//! their joints begin with exactly this traction, so that no force jumps.

use crate::cohesive::{Memory, Plane, use_of};
use crate::contacts::Contacts;
use crate::joints::near::{Near, SUSPECT};
use crate::joints::plane::{along, breaks, mean_stress, plane_near, traction};
use crate::joints::{Joints, edge_length, nodes_at};
use crate::model::{Insertion, Model};
use crate::solid::Solid;
use crate::team::Team;
use crate::topology::{Facet, NONE, Topology};
use crate::vector::{Point, dot, length, minus};

/// The data of a run that insertion reads.
#[derive(Clone, Copy)]
struct State<'a> {
    solid: &'a Solid,
    contacts: &'a Contacts,
    model: &'a Model,
    topology: &'a Topology,
}

impl Joints {
    /// Inserts joints on the edges whose traction has reached their strength, and splits the nodes at which elements are no longer connected.
    pub(crate) fn insert(
        &mut self,
        solid: &mut Solid,
        contacts: &Contacts,
        model: &Model,
        topology: &Topology,
        team: &Team,
    ) {
        if self.insertion == Insertion::Intrinsic || self.strengths.is_empty() {
            return;
        }
        let state = State { solid, contacts, model, topology };
        let mut near = std::mem::take(&mut self.near);
        let whole = team.change(&mut near, |first, chunk| {
            let mut failing = Vec::new();
            for (k, near) in chunk.iter_mut().enumerate() {
                let element = first + k;
                *near = self.slopes.near(self.weakest[element], solid.strained[element].stress);
                if *near == Near::Failing {
                    let edges = topology.facet_of[element].into_iter().filter(|&edge| edge != NONE);
                    failing.extend(edges.filter(|&edge| {
                        breaks(self.used(edge, state), || self.plane(edge, state.solid, topology))
                    }));
                }
            }
            failing
        });
        self.near = near;
        let tips = team.look(self.tips.len(), |range| {
            let mut failing = Vec::new();
            for &vertex in &self.tips[range] {
                self.failing_at(vertex, state, &mut failing);
            }
            failing
        });
        let mut failing = [whole, tips].concat().concat();
        failing.sort_unstable();
        failing.dedup();
        let mut vertices = Vec::new();
        for edge in failing {
            // The laws of all edges were checked together with the model.
            if let Ok(Some(law)) = self.law(edge, model, topology) {
                let plane = self.plane(edge, solid, topology);
                self.put(edge, law, plane, topology, model);
                let corners = topology.facets[edge as usize].corners[0];
                vertices.extend(corners.map(|corner| topology.vertices[corner as usize]));
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        for &vertex in &vertices {
            self.part(vertex, solid, Some(contacts), model, topology);
        }
        if !vertices.is_empty() {
            // Vertices whose edges all have joints need no further checks.
            let of_edge = &self.of_edge;
            let may_fail = |edge: u32| of_edge[edge as usize] == NONE;
            self.tips.retain(|&vertex| topology.facets_around(vertex).any(|(edge, _)| may_fail(edge)));
        }
    }

    /// The plane for which a joint on an edge would stand. The edges of an interface lie in the plane that is weak.
    fn plane(&self, edge: u32, solid: &Solid, topology: &Topology) -> Plane {
        let sides = &topology.facets[edge as usize];
        let of_interface = self.of_interface.get(self.class[edge as usize] as usize) == Some(&true);
        let strength = self.strength(edge).filter(|_| !of_interface);
        strength.map_or(Plane::OWN, |strength| {
            plane_near(along(solid, sides), mean_stress(solid, sides), &strength)
        })
    }

    /// Use of the strength of an edge by the mean stress of its two elements; 0 if the edge has a joint or cannot break.
    fn used(&self, edge: u32, state: State<'_>) -> f64 {
        let strength = self.strength(edge).filter(|_| self.of_edge[edge as usize] == NONE);
        strength.map_or(0.0, |strength| {
            use_of(&strength, traction(state.solid, &state.topology.facets[edge as usize]))
        })
    }

    /// Adds the failing edges at a vertex on a free surface or at a crack tip: those where the traction that holds their two sides together at the vertex
    /// reaches the strength.
    fn failing_at(&self, vertex: u32, state: State<'_>, failing: &mut Vec<u32>) {
        let State { solid, topology, .. } = state;
        let corners = topology.corners_of(vertex);
        if corners.iter().all(|&corner| self.near[corner as usize / 3] == Near::Far) {
            return;
        }
        // The force that moves a held node is unknown here. There the mean traction of the elements decides.
        if solid.hold_at(corners[0]) != NONE {
            return;
        }
        let mut groups = Vec::new();
        for (edge, _) in topology.facets_around(vertex) {
            if self.used(edge, state) < SUSPECT {
                continue;
            }
            let holds = |other| other != edge && self.of_edge[other as usize] == NONE;
            topology.groups(vertex, holds, &mut groups);
            let fan = Fan { vertex, groups: &groups, joints: self, state };
            let sides = fan.groups_beside(edge);
            // The two sides are still connected the other way round the vertex.
            if sides[0] == sides[1] {
                continue;
            }
            let held = fan.held_by(sides, half_length(edge, state));
            let traction = components(held, solid, &topology.facets[edge as usize]);
            let used = self.strength(edge).map_or(0.0, |strength| use_of(&strength, traction));
            if breaks(used, || self.plane(edge, solid, topology)) {
                failing.push(edge);
            }
        }
    }

    /// Splits the node of a vertex, so that each group of elements between joints has a node of its own. Joint ends that open begin with the traction that acts
    /// there.
    pub(crate) fn part(
        &mut self,
        vertex: u32,
        solid: &mut Solid,
        contacts: Option<&Contacts>,
        model: &Model,
        topology: &Topology,
    ) {
        let corners = topology.corners_of(vertex);
        let mut groups = Vec::new();
        topology.groups(vertex, |edge| self.of_edge[edge as usize] == NONE, &mut groups);
        // Tractions of the ends that open now, computed before the nodes are split.
        let mut begin: Vec<(u32, [f64; 2])> = Vec::new();
        if let Some(contacts) = contacts.filter(|_| solid.hold_at(corners[0]) == NONE) {
            let state = State { solid, contacts, model, topology };
            let fan = Fan { vertex, groups: &groups, joints: self, state };
            for (edge, corner) in topology.facets_around(vertex) {
                let sides = fan.groups_beside(edge);
                if sides[0] != sides[1] && fan.closed(edge) && fan.groups_of_node(corner) == 2 {
                    let traction = fan.held_by(sides, 0.0);
                    begin.push((edge, components(traction, solid, &topology.facets[edge as usize])));
                }
            }
        }
        let Solid { nodes, constants, corners: lists, .. } = solid;
        let mut all = Vec::new();
        lists.split(corners, &groups, |old, new| {
            nodes.push(nodes[old as usize]);
            constants.push(constants[old as usize]);
            all.extend([old, new]);
        });
        for node in all {
            solid.weigh(node, model);
        }
        for &corner in corners {
            for edge in topology.facets_at(corner) {
                let known = begin.iter().find(|(other, _)| *other == edge).map(|(_, traction)| *traction);
                self.open(edge, vertex, known, solid, topology);
            }
        }
    }

    /// Marks an end of a joint as open if it has two nodes now. `known`: the traction that held them together; if it is `None`, that of the two elements is
    /// taken.
    fn open(&mut self, edge: u32, vertex: u32, known: Option<[f64; 2]>, solid: &Solid, topology: &Topology) {
        if edge == NONE {
            return;
        }
        let Some(joint) = self.all.get_mut(self.of_edge[edge as usize] as usize) else { return };
        let sides = &topology.facets[edge as usize];
        let end = end_at(sides, vertex, topology);
        joint.nodes = nodes_at(sides, solid);
        let [a, b] = joint.nodes[end];
        if joint.open[end] || a == b {
            return;
        }
        joint.open[end] = true;
        if self.insertion == Insertion::Adaptive || solid.is_prestressed() {
            let traction = known.unwrap_or_else(|| traction(solid, sides));
            joint.ends[end] = Memory::under(&joint.law, traction);
        }
    }
}

/// Half of the length of an undeformed edge, m.
fn half_length(edge: u32, state: State<'_>) -> f64 {
    let corners = state.topology.facets[edge as usize].corners[0];
    0.5 * edge_length(state.model, corners.map(|corner| state.topology.vertices[corner as usize]))
}

/// The elements around a vertex, in groups.
struct Fan<'a> {
    vertex: u32,
    groups: &'a [u32],
    joints: &'a Joints,
    state: State<'a>,
}

impl Fan<'_> {
    fn corners(&self) -> &[u32] {
        self.state.topology.corners_of(self.vertex)
    }

    /// The corners at this vertex on the two sides of an edge.
    fn beside(&self, edge: u32) -> [u32; 2] {
        let edge = &self.state.topology.facets[edge as usize];
        let end = end_at(edge, self.vertex, self.state.topology);
        edge.corners.map(|side| side[end])
    }

    /// Groups on the two sides of an edge.
    fn groups_beside(&self, edge: u32) -> [u32; 2] {
        let group =
            |corner: u32| self.corners().binary_search(&corner).map_or(NONE, |place| self.groups[place]);
        self.beside(edge).map(group)
    }

    /// Whether the end of a joint at this vertex is closed: one node on both sides.
    fn closed(&self, edge: u32) -> bool {
        let [a, b] = self.beside(edge).map(|corner| self.state.solid.corners.node_at(corner));
        a == b
    }

    /// How many groups share the node of a corner.
    fn groups_of_node(&self, corner: u32) -> usize {
        let nodes = &self.state.solid.corners;
        let node = nodes.node_at(corner);
        let all = self.corners().iter().zip(self.groups);
        let mut groups: Vec<u32> =
            all.filter(|(corner, _)| nodes.node_at(**corner) == node).map(|(_, &group)| group).collect();
        groups.sort_unstable();
        groups.dedup();
        groups.len()
    }

    /// Traction, Pa, with which group `sides[1]` holds group `sides[0]`. It acts on the half lengths of the closed joints between the two groups, and on
    /// `more`, m, besides.
    fn held_by(&self, sides: [u32; 2], more: f64) -> Point {
        let State { solid, contacts, model, topology } = self.state;
        let (mut force, mut mass) = ([[0.0; 2]; 2], [0.0; 2]);
        for (&corner, &group) in self.corners().iter().zip(self.groups) {
            let Some(side) = sides.iter().position(|&side| side == group) else { continue };
            let mut total = solid.strained[corner as usize / 3].forces[corner as usize % 3];
            self.joints.add_force(corner, &mut total);
            contacts.add_force(corner, &mut total);
            for axis in 0..2 {
                force[side][axis] += total[axis];
            }
            mass[side] += solid.elements[corner as usize / 3].corner_mass(model);
        }
        let mut width = more;
        for (edge, _) in topology.facets_around(self.vertex) {
            if self.joints.of_edge[edge as usize] != NONE && self.closed(edge) {
                let beside = self.groups_beside(edge);
                if beside == sides || beside == [sides[1], sides[0]] {
                    width += half_length(edge, self.state);
                }
            }
        }
        // Gravity accelerates both sides equally, so it cancels.
        let share = mass[0] / (mass[0] + mass[1]);
        std::array::from_fn(|axis| {
            let held = share * (force[0][axis] + force[1][axis]) - force[0][axis];
            held / (width * solid.thickness)
        })
    }
}

/// The end of an edge that is at a vertex.
fn end_at(edge: &Facet, vertex: u32, topology: &Topology) -> usize {
    usize::from(topology.vertices[edge.corners[0][0] as usize] != vertex)
}

/// Components of a traction on side 0 of an edge: normal (tension positive) and tangential.
fn components(traction: Point, solid: &Solid, edge: &Facet) -> [f64; 2] {
    let [a, b] = edge.corners[0].map(|corner| solid.at_corner(corner).position);
    let along = minus(b, a);
    let long = length(along);
    let tangent = along.map(|x| x / long);
    [traction[0] * tangent[1] - traction[1] * tangent[0], dot(traction, tangent)]
}
