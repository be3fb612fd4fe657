//! The simulation that a rank makes of pieces.

use std::collections::BTreeSet;

use fdem_mesh::Mesh;

use crate::action::Wide;
use crate::actions::Actions;
use crate::actions::ground::is_ground;
use crate::actions::seams::Seams;
use crate::contacts::Contacts;
use crate::error::ModelError;
use crate::joints::Joints;
use crate::joints::saved::{MovingJoint, SavedJoints};
use crate::machine::Columns;
use crate::machine::list::Machines;
use crate::model::{Model, Target};
use crate::ranks::part::RankPart;
use crate::ranks::piece::{
    BoundarySide, CarriedState, CommonData, CornerState, ElementPiece, RunPieces, acts_on_nodes,
};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::simulation::run::{Components, Simulation};
use crate::solid::{Node, Solid};
use crate::sum::Grains;
use crate::team::Team;
use crate::topology::{PartOf, Topology};
use crate::vector::Point;

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// The part of a run that a rank makes of these pieces.
    pub(super) fn of_pieces(
        frame: &CommonData<D, N>,
        mut pieces: RunPieces<D, N>,
        carried: CarriedState<D>,
        rank: u32,
        team: Team,
    ) -> Result<Self, ModelError> {
        pieces.elements.sort_unstable_by_key(|piece| piece.number);
        pieces.elements.dedup_by_key(|piece| piece.number);
        // Joints may come from several ranks.
        pieces.joints.sort_unstable_by_key(|moving| moving.joint.facet);
        pieces.joints.dedup_by_key(|moving| moving.joint.facet);
        let all = &pieces.elements;
        let known = KnownVertices::of(all);
        let (model, places) = known.model(frame, all);
        let part = PartOf {
            numbers: all.iter().map(|piece| piece.number).collect(),
            vertices: known.vertices.clone(),
            outer: all.iter().map(|piece| piece.outer).collect(),
        };
        let owners: Vec<u32> = corners(all).map(|corner| corner.owner).collect();
        let mut share = Share {
            corners: owners.iter().map(|&owner| owner == rank).collect(),
            of_element: N,
            ..Share::default()
        };
        let wide = Wide {
            nodes: frame.nodes.clone(),
            corners: known.at().map(|corner| corner.corners).collect(),
            radii: frame.radii.clone(),
        };
        let topology = Topology::of_part(&model.mesh, part)?;
        let mut solid = Solid::with_origin(&model, frame.origin);
        let mut joints = Joints::new(&model, &topology, &share);
        let mut actions = Actions::new(&model, &topology, &mut solid, Some(&wide))?;
        actions.ground.hold(held_by_ground(all, &model));
        let mut contacts = Contacts::new(&model, &topology, &joints.faces, frame.edge, &team)?;
        // These are found where the model was before the run.
        actions.seams = Seams::new(&model, &joints.faces, &solid)?;

        let nodes = NodesOf::of(all);
        share.nodes = nodes.first.iter().map(|corner| corner.owner == rank).collect();
        share.codes = nodes.codes;
        let moving: Vec<_> =
            nodes.first.iter().map(|at| Node { position: at.position, velocity: at.velocity }).collect();
        solid.set_nodes(&moving, nodes.of_corner, &model);
        solid.set_masses(&nodes.first.iter().map(|at| at.masses).collect::<Vec<_>>());
        solid.set_share(share);
        solid.hold_rigid_bodies(&actions.prescribed.holds, &model)?;
        solid.grains = Grains::of(frame.scales.size);
        solid.restore(
            &all.iter().map(|piece| piece.stress).collect::<Vec<_>>(),
            &all.iter().map(|piece| piece.viscous).collect::<Vec<_>>(),
            &all.iter().map(|piece| piece.dissipated).collect::<Vec<_>>(),
            &all.iter().flat_map(|piece| piece.memory.iter().copied()).collect::<Vec<_>>(),
        );
        let is_here = |moving: &MovingJoint<D>| topology.facet_with(moving.joint.facet).is_some();
        let (here, loose): (Vec<_>, Vec<_>) = pieces.joints.iter().partition(|moving| is_here(moving));
        joints.restore(SavedJoints::of(here), &model, &topology, &solid)?;
        let counted = |code: u32| {
            topology.element(code / N as u32).is_some_and(|element| {
                let corner = <[[f64; D]; N]>::FACETS[code as usize % N][0] as u32;
                solid.share().corner(element * N as u32 + corner)
            })
        };
        let loose_joints = loose.into_iter().filter(|moving| counted(moving.joint.facet)).collect();
        contacts.surface.set_known(
            corners(all).map(|corner| corner.group).collect(),
            known.at().map(|corner| corner.free).collect(),
            &topology,
        );
        contacts.restore_couples(pieces.contacts.renumbered(|number| topology.element(number)));
        contacts.set_detections(carried.detections);
        let part = RankPart {
            owners,
            first: known.at().map(|corner| corner.first).collect(),
            wide,
            places,
            loose_joints,
        };
        let machine = <[[f64; D]; N]>::machine(Columns { solid, joints, contacts }, &team);
        let parts = Components { topology, machine, actions };
        let mut run = Self::with_parts(model, parts, team, frame.scales);
        run.part = Some(part);
        run.step = carried.step;
        run.totals = carried.totals;
        run.energies = carried.energies;
        run.imbalance = carried.imbalance;
        run.reactions = carried.reactions;
        for (boundary, factor) in carried.factors {
            run.set_factor(boundary as usize, Some(factor))?;
        }
        // Of an action between two elements, this part may have one alone.
        for record in pieces.records.iter().chain(&carried.records) {
            run.take_record(record);
        }
        run.begin_actions()?;
        run.timings = carried.timings;
        run.watch();
        Ok(run)
    }
}

/// The corners of all elements.
fn corners<const D: usize, const N: usize>(
    all: &[ElementPiece<D, N>],
) -> impl Iterator<Item = &CornerState<D>> {
    all.iter().flat_map(|piece| &piece.corners)
}

/// The vertices of some elements, ascending, each with one of its corners.
struct KnownVertices<'a, const D: usize> {
    vertices: Vec<u32>,
    corner: Vec<Option<&'a CornerState<D>>>,
}

impl<'a, const D: usize> KnownVertices<'a, D> {
    fn of<const N: usize>(all: &'a [ElementPiece<D, N>]) -> Self {
        let vertices: Vec<u32> =
            corners(all).map(|corner| corner.vertex).collect::<BTreeSet<u32>>().into_iter().collect();
        let mut known = Self { corner: vec![None; vertices.len()], vertices };
        for corner in corners(all) {
            let vertex = known.vertex(corner.vertex);
            known.corner[vertex as usize].get_or_insert(corner);
        }
        known
    }

    /// The place of a vertex, by its number in the whole mesh.
    fn vertex(&self, number: u32) -> u32 {
        self.vertices.binary_search(&number).unwrap_or_default() as u32
    }

    /// A corner of each vertex.
    fn at(&self) -> impl Iterator<Item = &'a CornerState<D>> {
        self.corner.iter().flatten().copied()
    }

    /// The model of these elements, and for each boundary the places of its facets among all of its facets.
    fn model<const N: usize>(
        &self,
        frame: &CommonData<D, N>,
        all: &[ElementPiece<D, N>],
    ) -> (Model<D, N>, Vec<Vec<u32>>) {
        let mesh = Mesh {
            nodes: self.at().map(|corner| corner.place).collect(),
            elements: all
                .iter()
                .map(|piece| piece.corners.each_ref().map(|at| self.vertex(at.vertex)))
                .collect(),
            bodies: all.iter().map(|piece| piece.body).collect(),
            materials: all.iter().map(|piece| piece.material).collect(),
        };
        let mut model = Model { mesh, ..frame.model.clone() };
        model.stresses = all.iter().filter_map(|piece| piece.initial).collect();
        model.mass_factors = all.iter().filter_map(|piece| piece.mass_factor).collect();
        model.joint_facets = all.iter().filter_map(|piece| piece.sets).collect();
        let sides = sides(all);
        let mut places = vec![Vec::new(); model.boundaries.len()];
        for (number, boundary) in (0..).zip(&mut model.boundaries) {
            if acts_on_nodes(&boundary.load) {
                let acts = |(_, corner): &(u32, &CornerState<D>)| corner.boundaries.contains(&number);
                let vertices = (0..).zip(self.at()).filter(acts).map(|(vertex, _)| vertex);
                boundary.target = Target::Nodes(vertices.collect());
            } else {
                let own = || sides.iter().filter(|side| side.boundary == number);
                places[number as usize] = own().map(|side| side.place).collect();
                let vertices = |side: &&BoundarySide<D>| side.vertices.map(|vertex| self.vertex(vertex));
                let facets = own().map(vertices).collect();
                boundary.target = match boundary.target {
                    Target::Held(..) => Target::Held(facets, own().map(|side| side.held).collect()),
                    _ => Target::Facets(facets),
                };
            }
        }
        (model, places)
    }
}

/// The facets on which boundaries act, by boundary and in the order of its facets.
fn sides<const D: usize, const N: usize>(all: &[ElementPiece<D, N>]) -> Vec<&BoundarySide<D>> {
    let mut sides: Vec<&BoundarySide<D>> = all.iter().flat_map(|piece| &piece.sides).collect();
    sides.sort_unstable_by_key(|side| (side.boundary, side.place));
    sides
}

/// Static forces of the ground, in the same order.
fn held_by_ground<const D: usize, const N: usize>(
    all: &[ElementPiece<D, N>],
    model: &Model<D, N>,
) -> Vec<[Point<D>; D]> {
    let of_ground = |side: &&BoundarySide<D>| is_ground(&model.boundaries[side.boundary as usize].load);
    sides(all).into_iter().filter(of_ground).map(|side| side.held).collect()
}

/// The nodes of some elements, in the order of the codes of their first corners.
struct NodesOf<'a, const D: usize, const N: usize> {
    codes: Vec<u32>,
    /// A corner of each.
    first: Vec<&'a CornerState<D>>,
    of_corner: Vec<[u32; N]>,
}

impl<'a, const D: usize, const N: usize> NodesOf<'a, D, N> {
    fn of(all: &'a [ElementPiece<D, N>]) -> Self {
        let mut first: Vec<&CornerState<D>> = corners(all).collect();
        first.sort_by_key(|corner| corner.node);
        first.dedup_by_key(|corner| corner.node);
        let codes: Vec<u32> = first.iter().map(|corner| corner.node).collect();
        let node = |corner: &CornerState<D>| codes.binary_search(&corner.node).unwrap_or_default() as u32;
        let of_corner = all.iter().map(|piece| piece.corners.each_ref().map(node)).collect();
        Self { codes, first, of_corner }
    }
}
