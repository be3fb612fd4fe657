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
use crate::joints::demand::{Demand, SUSPECT, find_demands};
use crate::joints::fan::{Fan, end_at};
use crate::joints::plane::{breaks, mean_stress, plane_near, plane_of, side, traction};
use crate::joints::uses::UseBatch;
use crate::joints::{Joints, Tip, VertexSplit};
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
        let mut demands = std::mem::take(&mut self.demands);
        let (weakest, slopes) = (&self.weakest, &self.slopes);
        let suspect = team.change_lanes::<LANES, _, _>(&mut demands, |first, chunk| {
            let mut suspect = false;
            for (batch, demands) in (first..).zip(chunk) {
                let deformed = solid.deformed(batch);
                suspect |= find_demands::<D, N>(solid.available, slopes, deformed, &weakest[batch], demands);
            }
            suspect
        });
        self.demands = demands;
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
            for &facet in alone.iter().chain(&together) {
                self.near_tip[facet as usize] = true;
            }
            if !alone.is_empty() || !together.is_empty() {
                self.tips.push(Tip { vertex, alone: alone.as_slice().into(), together, cuts: Vec::new() });
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
            let least = if self.near_tip[facet as usize] { SUSPECT } else { 1.0 };
            uses[place] = 0.0;
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
        let state = InsertionData { solid, model, topology };
        let fan = Fan::new(vertex, &[], self, state);
        // Tractions of the ends that open now, computed before the nodes are split.
        let mut begin: Vec<(u32, [f64; D])> = Vec::new();
        if pulled && solid.hold_at(corners[0]) == NONE {
            let owned = |(_, corner): &(u32, u32)| solid.share().corner(*corner);
            for (facet, corner) in topology.facets_around(vertex).filter(owned) {
                let sides = fan.groups_beside(facet);
                if sides[0] != sides[1] && fan.closed(facet) && fan.groups_of_node(corner) == 2 {
                    let cut = fan.cut(facet, &[]);
                    let (held, axes) = cut.held(vertex, |corner| self.force_on(corner, state.solid), state);
                    let share = <[[f64; D]; N]>::projection(cut.normal(state), axes[0]);
                    let traction = held.map(|x| share * x);
                    begin.push((facet, components(traction, solid, &topology.facets[facet as usize])));
                }
            }
        }
        let (owned, groups) = solid.share().owned(corners, fan.groups());
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
        if joint.open[end] {
            self.connect(number, end, topology);
        }
    }
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
