//! Adaptive insertion: where joints are inserted, and with which traction. `joints/failing.rs` finds the
//! facets that get one.
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

use crate::cohesive::{JointPlane, Memory};
use crate::joints::batch::Link;
use crate::joints::cut::InsertionData;
use crate::joints::fan::{Fan, end_at};
use crate::joints::plane::{mean_stress, plane_of, side, traction};
use crate::joints::{Joint, Joints, Tip, VertexSplit};
use crate::model::{Insertion, Model, Strength};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::team::Team;
use crate::topology::{Facet, NONE, Topology};
use crate::vector::{Point, dot, unit};

impl<const D: usize> Joints<D> {
    /// Inserts joints on these facets, and splits the nodes at which elements are no longer connected.
    /// Returns the vertices at which this rank has done so.
    ///
    /// All that takes long is computed from the state before, on all threads. Then it is written in order.
    pub(crate) fn insert<const N: usize>(
        &mut self,
        failing: &[u32],
        solid: &mut Solid<D, N>,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Vec<VertexSplit<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        // The laws of all facets were checked together with the model.
        let joint = |facet: u32| {
            let law = self.law(facet, model, topology).ok().flatten()?;
            Some(self.joint(facet, law, self.plane(facet, solid, topology), model, topology, solid.share()))
        };
        let new: Vec<Joint<D>> = team
            .list(failing.len(), |range| failing[range].iter().filter_map(|&facet| joint(facet)).collect());
        let corners = new.iter().flat_map(|joint| topology.facets[joint.facet as usize].corners[0]);
        let mut vertices: Vec<u32> = corners.map(|corner| topology.vertices[corner as usize]).collect();
        team.sort(&mut vertices);
        vertices.dedup();
        self.reserve(new.len());
        for joint in new {
            self.put(joint, topology, model.thickness);
        }
        let split = self.part(&vertices, solid, true, model, topology, team);
        if !vertices.is_empty() {
            self.find_tips(&vertices, topology, solid.share(), team);
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
        team: &Team,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.tips.retain(|tip| vertices.binary_search(&tip.vertex).is_err());
        let tips = team.list(vertices.len(), |range| {
            let mut bridges = Vec::new();
            let tip = |&vertex: &u32| self.tip(vertex, topology, share, &mut bridges);
            vertices[range].iter().filter_map(tip).collect()
        });
        for &vertex in vertices {
            self.tip_slack[vertex as usize] = f64::INFINITY;
        }
        self.tips.extend(tips);
    }

    /// The facets at a vertex that can get a joint, `None` if there is none. `bridges`: memory to use again.
    fn tip<const N: usize>(
        &self,
        vertex: u32,
        topology: &Topology<D, N>,
        share: &Share,
        bridges: &mut Vec<u32>,
    ) -> Option<Tip<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let whole = |facet: u32| self.of_facet[facet as usize] == NONE;
        topology.bridges(vertex, whole, bridges);
        let all = || {
            let owned = topology.facets_around(vertex).filter(|(_, corner)| share.corner(*corner));
            owned.map(|(facet, _)| facet)
        };
        let together: Box<[u32]> = all()
            .filter(|&facet| whole(facet) && self.may_part(facet) && !bridges.contains(&facet))
            .collect();
        bridges.retain(|&facet| self.may_part(facet) && (share.is_whole() || all().any(|own| own == facet)));
        let some = !bridges.is_empty() || !together.is_empty();
        some.then(|| Tip {
            vertex,
            alone: bridges.as_slice().into(),
            together,
            cuts: Vec::new(),
            contenders: Vec::new(),
        })
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

    /// Splits the nodes of these vertices, ascending, so that each group of elements between joints has a
    /// separate node. Joint ends that open begin with the traction that acts there, if forces have `pulled`
    /// at the elements. Returns these tractions, each with its facet, at the vertices of this rank.
    pub(crate) fn part<const N: usize>(
        &mut self,
        vertices: &[u32],
        solid: &mut Solid<D, N>,
        pulled: bool,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        team: &Team,
    ) -> Vec<VertexSplit<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let state = InsertionData { solid, model, topology };
        let owned = |vertex: &&u32| {
            topology.corners_of(**vertex).iter().any(|&corner| state.solid.share().corner(corner))
        };
        // No vertex depends on another.
        let partings: Vec<Parting<D>> = team.list(vertices.len(), |range| {
            let here = vertices[range].iter().filter(owned);
            here.map(|&vertex| self.parting(vertex, pulled, state)).collect()
        });
        let mut changed = Vec::new();
        for Parting { corners, groups, .. } in &partings {
            changed.extend(solid.split(corners, groups));
        }
        for node in changed {
            solid.weigh(node, model);
        }
        let opening = |parting: &Parting<D>| {
            let Parting { vertex, corners, begin, .. } = parting;
            self.openings(*vertex, corners, begin, solid, topology)
        };
        let openings = team.list(partings.len(), |range| partings[range].iter().flat_map(opening).collect());
        self.open(openings, solid, topology, team);
        for &vertex in vertices {
            solid.wake_around(vertex, topology);
        }
        partings.into_iter().map(|parting| (parting.vertex, parting.begin)).collect()
    }

    /// The groups into which the elements at a vertex part, and the tractions with which ends of joints begin
    /// there.
    fn parting<const N: usize>(&self, vertex: u32, pulled: bool, state: InsertionData<'_, D, N>) -> Parting<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let corners = topology.corners_of(vertex);
        let fan = Fan::new(vertex, &[], self, state);
        let mut begin: Vec<(u32, [f64; D])> = Vec::new();
        if pulled && solid.hold_at(corners[0]) == NONE {
            let owned = |(_, corner): &(u32, u32)| solid.share().corner(*corner);
            for (facet, corner) in topology.facets_around(vertex).filter(owned) {
                let sides = fan.groups_beside(facet);
                if sides[0] != sides[1] && fan.closed(facet) && fan.groups_of_node(corner) == 2 {
                    let cut = fan.cut(facet, &[]);
                    let pull = cut.held(vertex, |corner| self.force_on(corner, solid), state);
                    let share = <[[f64; D]; N]>::projection(cut.normal(state), pull.axes[0]);
                    let traction = pull.traction.map(|x| share * x);
                    begin.push((facet, components(traction, solid, &topology.facets[facet as usize])));
                }
            }
        }
        let (corners, groups) = solid.share().owned(corners, fan.groups());
        Parting { vertex, corners, groups, begin }
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
        team: &Team,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let openings = self.openings(vertex, corners, begin, solid, topology);
        self.open(openings, solid, topology, team);
    }

    /// The joints at these corners of a vertex, with their nodes, and the histories of their ends that open
    /// there. `begin`: the tractions that held some ends together, by their facets; for others that of the
    /// two elements is taken.
    fn openings<const N: usize>(
        &self,
        vertex: u32,
        corners: &[u32],
        begin: &[(u32, [f64; D])],
        solid: &Solid<D, N>,
        topology: &Topology<D, N>,
    ) -> Vec<Opening<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let at_corners = corners.iter().flat_map(|&corner| topology.facets_at(corner));
        let joined = |facet: &u32| *facet != NONE && self.of_facet[*facet as usize] != NONE;
        let mut facets: Vec<u32> = at_corners.filter(joined).collect();
        facets.sort_unstable();
        facets.dedup();
        let opening = |facet: u32| {
            let number = self.of_facet[facet as usize];
            let (mut joint, sides) = (self.all[number as usize], &topology.facets[facet as usize]);
            joint.find_nodes(sides, solid);
            let end = end_at(sides, vertex, topology);
            let [a, b] = joint.nodes[end];
            let opens = !joint.open[end] && a != b;
            let memory = opens.then(|| {
                let known = begin.iter().find(|(other, _)| *other == facet).map(|(_, traction)| *traction);
                self.begins_with(&joint, known, sides, solid)
            });
            Opening { number, end, nodes: joint.nodes, memory }
        };
        facets.into_iter().map(opening).collect()
    }

    /// The history with which an end of a joint begins that opens, as [`Joints::openings`] has it.
    fn begins_with<const N: usize>(
        &self,
        joint: &Joint<D>,
        known: Option<[f64; D]>,
        sides: &Facet<D>,
        solid: &Solid<D, N>,
    ) -> Memory<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if joint.open_from_start {
            Memory::broken()
        } else if self.insertion == Insertion::Adaptive || solid.is_prestressed() {
            Memory::under(&joint.law, known.unwrap_or_else(|| traction(solid, sides)))
        } else {
            Memory::default()
        }
    }

    /// Opens ends of joints.
    fn open<const N: usize>(
        &mut self,
        openings: Vec<Opening<D>>,
        solid: &Solid<D, N>,
        topology: &Topology<D, N>,
        team: &Team,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut changed: Vec<u32> = openings.iter().map(|opening| opening.number).collect();
        for Opening { number, end, nodes, memory } in openings {
            let joint = &mut self.all[number as usize];
            joint.nodes = nodes;
            if let Some(memory) = memory {
                joint.open[end] = true;
                joint.ends[end] = memory;
                if joint.counted {
                    self.inserted.add(joint.share(solid.thickness) * memory.stored(&joint.law));
                }
                self.connect(number as usize, end, topology);
            }
        }
        team.sort(&mut changed);
        changed.dedup();
        let links: Vec<Link<D>> = team.list(changed.len(), |range| {
            let link = |&number: &u32| Link::of(&self.all[number as usize], solid.thickness);
            changed[range].iter().map(link).collect()
        });
        for (number, link) in changed.into_iter().zip(links) {
            self.links[number as usize] = link;
        }
    }
}

/// The groups into which the elements at a vertex part.
struct Parting<const D: usize> {
    vertex: u32,
    /// The corners there of this rank, and the group of each.
    corners: Vec<u32>,
    groups: Vec<u32>,
    /// Tractions with which ends of joints begin there, by their facets.
    begin: Vec<(u32, [f64; D])>,
}

/// A joint at a vertex whose nodes were split.
struct Opening<const D: usize> {
    /// Its number, its end at the vertex, and the nodes of all its ends.
    number: u32,
    end: usize,
    nodes: [[u32; 2]; D],
    /// History of the end if it opens.
    memory: Option<Memory<D>>,
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
