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
use crate::joints::batch::Link;
use crate::joints::cut::{Cut, InsertionData};
use crate::joints::demand::{Demand, FAILING, SUSPECT, SUSPECTED, find_demands};
use crate::joints::fan::{Fan, end_at};
use crate::joints::plane::{breaks, mean_stress, plane_near, plane_of, side, traction};
use crate::joints::uses::UseBatch;
use crate::joints::{Joint, Joints, Tip, VertexSplit};
use crate::lanes::LANES;
use crate::model::{Insertion, Model, Strength};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::team::Team;
use crate::topology::{Facet, NONE, Topology};
use crate::vector::{Point, dot, unit};

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
        let Self { weakest, slopes, demands, levels, .. } = self;
        let none: &mut [()] = &mut [];
        let suspect =
            team.change_batches::<LANES, _, _, _, _>(demands, levels, none, |first, chunk, levels, _| {
                let mut suspect = false;
                for ((batch, demands), levels) in (first..).zip(chunk).zip(levels.as_chunks_mut().0) {
                    let (deformed, weakest) = (solid.deformed(batch), &weakest[batch]);
                    suspect |=
                        find_demands::<D, N>(solid.available, slopes, deformed, weakest, demands, levels);
                }
                suspect
            });
        if suspect.iter().all(|suspect| !suspect) {
            return Vec::new();
        }
        let mut uses = std::mem::take(&mut self.uses);
        let whole = team.change_lanes::<1, _, _>(&mut uses, |first, uses| {
            self.find_uses(first as u32, uses, state);
            let facets = (first as u32..).zip(uses);
            let fails = |(facet, used): &(u32, &mut f64)| self.fails(**used, **used, *facet, state);
            facets.filter(fails).map(|(facet, _)| facet).collect::<Vec<u32>>()
        });
        self.uses = uses;
        let mut tips = std::mem::take(&mut self.tips);
        let at_tips = team.change_lanes::<1, _, _>(&mut tips, |_, tips| {
            let mut failing = Vec::new();
            for tip in tips {
                self.failing_at(tip, state, &mut failing);
            }
            failing
        });
        self.tips = tips;
        let mut failing = [whole, at_tips].concat().concat();
        team.sort(&mut failing);
        failing.dedup();
        failing
    }

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
        for tip in &tips {
            for &facet in tip.alone.iter().chain(&tip.together) {
                self.near_tip[facet as usize] = true;
            }
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
        some.then(|| Tip { vertex, alone: bridges.as_slice().into(), together, cuts: Vec::new() })
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

    /// Whether a use of the strength of a facet breaks it or a plane near it. `own`: the use by the mean
    /// stress of its two elements.
    fn fails<const N: usize>(&self, used: f64, own: f64, facet: u32, state: InsertionData<'_, D, N>) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let most = || self.demand_on(facet, state).most(self.limits[facet as usize]) / own;
        breaks(used, most, || self.excess(facet, state))
    }

    /// The demand of the mean stress of the two elements of a facet.
    fn demand_on<const N: usize>(&self, facet: u32, state: InsertionData<'_, D, N>) -> Demand {
        let of = |element: u32| self.demands[element as usize / LANES].get(element as usize % LANES);
        Demand::mean(state.topology.facets[facet as usize].elements().map(of))
    }

    /// Computes the uses of the strengths of facets by the mean stress of their two elements. A use is 0 if
    /// the facet has a joint or cannot break, or if it is certain to be too little to count: below 1 on all
    /// planes, and below [`SUSPECT`] at a tip.
    fn find_uses<const N: usize>(&self, first: u32, uses: &mut [f64], state: InsertionData<'_, D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let mut batch = UseBatch::EMPTY;
        for place in 0..uses.len() {
            let facet = first + place as u32;
            let sides = &topology.facets[facet as usize];
            let (level, least) =
                if self.near_tip[facet as usize] { (SUSPECTED, SUSPECT) } else { (FAILING, 1.0) };
            uses[place] = 0.0;
            // The mean demand of two elements reaches a limit only if that of one does.
            if sides.elements().iter().all(|&element| self.levels[element as usize] < level) {
                continue;
            }
            if self.demand_on(facet, state).reaches(least, self.limits[facet as usize])
                && let Some(strength) = self.strength(facet)
            {
                batch.push(place, &strength, sides, solid, uses);
            }
        }
        batch.write::<N>(solid.available, uses);
    }

    /// Adds the failing facets at a vertex on a free surface or at a crack tip: those where the traction that
    /// holds their two sides together at the vertex reaches the strength.
    fn failing_at<const N: usize>(
        &self,
        tip: &mut Tip<D>,
        state: InsertionData<'_, D, N>,
        failing: &mut Vec<u32>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let InsertionData { solid, topology, .. } = state;
        let Tip { vertex, alone, together, cuts } = tip;
        let vertex = *vertex;
        // The force that moves a held node is unknown here. There the mean traction of the elements decides.
        if solid.hold_at(topology.corners_of(vertex)[0]) != NONE {
            return;
        }
        let used = |facet: u32| self.uses[facet as usize];
        for &facet in alone.iter().filter(|&&facet| used(facet) >= SUSPECT) {
            let known = cuts.iter().position(|cut| cut.facet == facet && cut.holds(vertex, state));
            let place = known.unwrap_or_else(|| {
                cuts.retain(|cut| cut.facet != facet);
                cuts.push(Fan::new(vertex, &[facet], self, state).cut(facet, &[facet]));
                cuts.len() - 1
            });
            self.fails_along(&cuts[place], vertex, state, failing);
        }
        let all = together.iter().map(|&facet| (used(facet), facet)).filter(|(used, _)| *used >= SUSPECT);
        let most = all.reduce(|most, next| if next.0 > most.0 { next } else { most });
        let Some((_, facet)) = most else { return };
        if !cuts.iter().any(|cut| cut.facet == facet && cut.holds(vertex, state)) {
            // One cut through several facets is kept.
            cuts.retain(|cut| alone.contains(&cut.facet));
            cuts.extend(Fan::new(vertex, &[], self, state).cut_along(facet));
        }
        if let Some(cut) = cuts.iter().find(|cut| cut.facet == facet) {
            self.fails_along(cut, vertex, state, failing);
        }
    }

    /// Force of elements, contacts and joints on a corner, N.
    fn force_on<const N: usize>(&self, corner: u32, solid: &Solid<D, N>) -> Point<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut total = solid.force(corner);
        self.add_force(corner, &mut total);
        total
    }

    /// Adds the facets of a cut to those that fail if the traction at the vertex does that holds its two
    /// sides together.
    fn fails_along<const N: usize>(
        &self,
        cut: &Cut<D>,
        vertex: u32,
        state: InsertionData<'_, D, N>,
        failing: &mut Vec<u32>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (held, axes) = cut.held(vertex, |corner| self.force_on(corner, state.solid), state);
        let traction = axes.map(|axis| dot(held, axis));
        let used = self.strength(cut.facet).map_or(0.0, |strength| use_of(&strength, traction));
        if self.fails(used, self.uses[cut.facet as usize], cut.facet, state) {
            failing.extend(&cut.facets);
        }
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
                    let (held, axes) = cut.held(vertex, |corner| self.force_on(corner, solid), state);
                    let share = <[[f64; D]; N]>::projection(cut.normal(state), axes[0]);
                    let traction = held.map(|x| share * x);
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
