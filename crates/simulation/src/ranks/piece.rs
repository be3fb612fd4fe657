//! Parts of a simulation on their way between ranks.
//!
//! All numbers are those of the whole model, and all facets and corners are codes (`topology.rs`): they mean
//! the same on every rank.

use std::collections::BTreeMap;

use fdem_distributed::wire;
use fdem_distributed::wire::{Wire, bytes_of};
use fdem_mesh::Mesh;

use crate::action::Record;
use crate::actions::ground::{is_ground, radii};
use crate::contacts::{SavedContacts, edges, mean_edge};
use crate::energy::Energies;
use crate::forces::Reaction;
use crate::joints::saved::MovingJoint;
use crate::model::{Load, Model, Target};
use crate::outer_side::outer_side;
use crate::simplex::Simplex;
use crate::simulation::advance::Concrete;
use crate::simulation::run::{Scales, Simulation};
use crate::simulation::totals::{Relaxation, Totals};
use crate::solid::Node;
use crate::timings::Timings;
use crate::vector::{Matrix, Point};

/// A corner of an element.
#[derive(Clone, Debug)]
pub(super) struct CornerState<const D: usize> {
    pub(super) vertex: u32,
    /// Undeformed position, m.
    pub(super) place: Point<D>,
    /// The rank that owns the corner.
    pub(super) owner: u32,
    /// Code of the first corner of its node.
    pub(super) node: u32,
    pub(super) position: Point<D>,
    pub(super) velocity: Point<D>,
    /// See [`Solid::masses`](crate::solid::Solid::masses).
    pub(super) masses: [f64; 2],
    /// See [`Surface`](crate::contacts::Surface).
    pub(super) group: u32,
    pub(super) free: bool,
    /// Number of corners at the vertex, and code of the first.
    pub(super) corners: u32,
    pub(super) first: u32,
    /// Boundaries that act on the vertex.
    pub(super) boundaries: Vec<u32>,
}

wire!([const D: usize] CornerState<D> {
    vertex, place, owner, node, position, velocity, masses, group, free, corners, first, boundaries,
});

/// A facet on which a boundary acts.
#[derive(Clone, Debug)]
pub(super) struct BoundarySide<const D: usize> {
    pub(super) boundary: u32,
    /// Place of the facet among those of the boundary.
    pub(super) place: u32,
    pub(super) vertices: [u32; D],
    /// Static forces of the ground beyond it, N.
    pub(super) held: [Point<D>; D],
}

wire!([const D: usize] BoundarySide<D> { boundary, place, vertices, held });

/// An element with all that is known at its corners.
#[derive(Clone, Debug)]
pub(super) struct ElementPiece<const D: usize, const N: usize> {
    pub(super) number: u32,
    pub(super) body: u32,
    pub(super) material: u32,
    pub(super) watched: bool,
    /// Whether each of its facets is on the surface of the mesh.
    pub(super) outer: [bool; N],
    pub(super) initial: Option<Matrix<D>>,
    /// Factor of its mass: see [`Model::mass_factors`].
    pub(super) mass_factor: Option<f64>,
    /// Joint sets of its facets.
    pub(super) sets: Option<[u32; N]>,
    pub(super) stress: Matrix<D>,
    pub(super) viscous: Matrix<D>,
    pub(super) dissipated: f64,
    /// Memory of its law.
    pub(super) memory: Vec<f64>,
    pub(super) corners: [CornerState<D>; N],
    pub(super) sides: Vec<BoundarySide<D>>,
}

wire!([const D: usize, const N: usize] ElementPiece<D, N> {
    number, body, material, watched, outer, initial, mass_factor, sets, stress, viscous, dissipated, memory, corners, sides,
});

impl<const D: usize, const N: usize> ElementPiece<D, N> {
    /// The ranks that own its corners, each once, ascending.
    pub(super) fn owners(&self) -> impl Iterator<Item = u32> + use<D, N> {
        let mut owners = [u32::MAX; N];
        for (owner, corner) in owners.iter_mut().zip(&self.corners) {
            *owner = corner.owner;
        }
        owners.sort_unstable();
        (0..N).filter(move |&k| k == 0 || owners[k] != owners[k - 1]).map(move |k| owners[k])
    }

    /// Whether it had stress at the beginning.
    pub(super) fn is_stressed(&self) -> bool {
        self.initial.is_some()
    }

    /// The rank that counts it.
    pub(super) fn counted_by(&self) -> u32 {
        self.corners[0].owner
    }

    /// The box around it.
    pub(super) fn bounds(&self) -> [Point<D>; 2] {
        let along = |axis: usize| self.corners.iter().map(move |corner| corner.position[axis]);
        [
            std::array::from_fn(|axis| along(axis).fold(f64::INFINITY, f64::min)),
            std::array::from_fn(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max)),
        ]
    }
}

/// All that a rank makes its part of.
#[derive(Clone, Debug)]
pub(super) struct RunPieces<const D: usize, const N: usize> {
    pub(super) elements: Vec<ElementPiece<D, N>>,
    pub(super) joints: Vec<MovingJoint<D>>,
    pub(super) contacts: SavedContacts<D, N>,
    /// The memory of the actions at these elements.
    pub(super) records: Vec<Record>,
}

wire!([const D: usize, const N: usize] RunPieces<D, N> { elements, joints, contacts, records });

impl<const D: usize, const N: usize> Default for RunPieces<D, N> {
    fn default() -> Self {
        Self {
            elements: Vec::new(),
            joints: Vec::new(),
            contacts: SavedContacts::default(),
            records: Vec::new(),
        }
    }
}

impl<const D: usize, const N: usize> RunPieces<D, N> {
    pub(super) fn add(&mut self, more: Self) {
        self.elements.extend(more.elements);
        self.joints.extend(more.joints);
        self.contacts.add(more.contacts);
        self.records.extend(more.records);
    }
}

/// The model without its mesh, and numbers of the whole run: all ranks have them.
#[derive(Clone, Debug)]
pub(crate) struct CommonData<const D: usize, const N: usize> {
    pub(crate) model: Model<D, N>,
    pub(crate) origin: Point<D>,
    pub(crate) scales: Scales,
    /// Mean length of edges, and length of the longest, m.
    pub(crate) edge: f64,
    pub(crate) longest: f64,
    /// Number of elements of the whole model.
    pub(crate) elements: u32,
    /// Number of nodes of the mesh on which each boundary acts.
    pub(super) nodes: Vec<u32>,
    pub(super) radii: BTreeMap<u32, f64>,
}

impl<const D: usize, const N: usize> CommonData<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The frame of a whole simulation.
    pub(super) fn of(run: &Simulation<D, N>) -> Self {
        let whole = &run.model;
        let boundaries = whole.boundaries.iter().map(|boundary| {
            let mut boundary = boundary.clone();
            boundary.target = match boundary.target {
                Target::Nodes(_) => Target::Nodes(Vec::new()),
                Target::Facets(_) => Target::Facets(Vec::new()),
                Target::Held(..) => Target::Held(Vec::new(), Vec::new()),
            };
            boundary
        });
        let model = Model {
            mesh: Mesh::default(),
            boundaries: boundaries.collect(),
            velocities: Vec::new(),
            stresses: Vec::new(),
            mass_factors: Vec::new(),
            joint_facets: Vec::new(),
            ..whole.clone()
        };
        Self {
            model,
            origin: run.solid().origin,
            scales: run.scales,
            edge: mean_edge(whole),
            longest: edges(whole).fold(0.0, f64::max),
            elements: whole.mesh.elements.len() as u32,
            nodes: whole.boundaries.iter().map(|boundary| boundary.target.nodes().len() as u32).collect(),
            radii: if run.actions.ground.is_empty() { BTreeMap::new() } else { radii(whole) },
        }
    }
}

impl<const D: usize, const N: usize> CommonData<D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = bytes_of(&<[[f64; D]; N]>::encode(&self.model));
        self.origin.put(&mut bytes);
        self.scales.put(&mut bytes);
        [self.edge, self.longest].put(&mut bytes);
        self.elements.put(&mut bytes);
        self.nodes.put(&mut bytes);
        self.radii.iter().map(|(&body, &radius)| (body, radius)).collect::<Vec<_>>().put(&mut bytes);
        bytes
    }

    pub(super) fn of_bytes(mut bytes: &[u8]) -> Self {
        let bytes = &mut bytes;
        let model = <[[f64; D]; N]>::decode(&Vec::take(bytes));
        let (origin, scales) = (Wire::take(bytes), Wire::take(bytes));
        let [edge, longest] = Wire::take(bytes);
        let (elements, nodes) = (u32::take(bytes), Vec::take(bytes));
        let radii = Vec::take(bytes).into_iter().collect();
        Self { model, origin, scales, edge, longest, elements, nodes, radii }
    }
}

/// The step, sums and times that a run keeps when its elements change.
#[derive(Clone, Debug)]
pub(super) struct CarriedState<const D: usize> {
    pub(super) step: u64,
    pub(super) totals: Totals,
    pub(super) energies: Energies,
    pub(super) imbalance: f64,
    pub(super) reactions: Vec<Reaction<D>>,
    /// Factors of boundaries that the caller has set.
    pub(super) factors: Vec<(u32, f64)>,
    /// The memory of the actions at no element.
    pub(super) records: Vec<Record>,
    pub(super) timings: Timings,
    pub(super) detections: u64,
}

impl<const D: usize> CarriedState<D> {
    /// Bytes of the data that all ranks have in common.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let Totals { first, exchanged, most_dissipated, relaxation, .. } = &self.totals;
        let mut bytes = bytes_of(&self.step);
        first.put(&mut bytes);
        [*exchanged, *most_dissipated, relaxation.work, relaxation.damping].put(&mut bytes);
        self.energies.put(&mut bytes);
        self.imbalance.put(&mut bytes);
        self.reactions.put(&mut bytes);
        self.factors.put(&mut bytes);
        self.records.put(&mut bytes);
        bytes
    }

    /// The values with which a rank without a part begins.
    pub(super) fn of_bytes(mut bytes: &[u8]) -> Self {
        let bytes = &mut bytes;
        let step = u64::take(bytes);
        let first = Wire::take(bytes);
        let [exchanged, most_dissipated, work, damping] = Wire::take(bytes);
        let relaxation = Relaxation { work, damping };
        let energies = Wire::take(bytes);
        let imbalance = f64::take(bytes);
        let (reactions, factors, records) = (Vec::take(bytes), Vec::take(bytes), Vec::take(bytes));
        let totals = Totals { first, exchanged, most_dissipated, relaxation, ..Totals::default() };
        let timings = Timings::default();
        Self { step, totals, energies, imbalance, reactions, factors, records, timings, detections: 0 }
    }
}

/// Numbers of the whole model, for the pieces of a part.
pub(super) struct Lookup<'a, const D: usize, const N: usize> {
    run: &'a Simulation<D, N>,
    /// Boundaries on each vertex.
    boundaries: BTreeMap<u32, Vec<u32>>,
    sides: BTreeMap<u32, Vec<BoundarySide<D>>>,
    viscous: Vec<Matrix<D>>,
    dissipated: Vec<f64>,
}

impl<'a, const D: usize, const N: usize> Lookup<'a, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    pub(super) fn new(run: &'a Simulation<D, N>) -> Self {
        let (mut boundaries, mut sides) =
            (BTreeMap::<u32, Vec<u32>>::new(), BTreeMap::<u32, Vec<BoundarySide<D>>>::new());
        let mut held = run.actions.ground.held();
        for (number, boundary) in (0..).zip(&run.model.boundaries) {
            if acts_on_nodes(&boundary.load) {
                for vertex in boundary.target.nodes() {
                    boundaries.entry(vertex).or_default().push(number);
                }
                continue;
            }
            for (k, facet) in boundary.target.facets().iter().enumerate() {
                let Ok(side) = outer_side(&run.model, &run.topology, *facet, &boundary.name) else {
                    continue;
                };
                let held = if is_ground(&boundary.load) { held.next().map(|(_, held)| held) } else { None };
                sides.entry(side.corners[0] / N as u32).or_default().push(BoundarySide {
                    boundary: number,
                    place: run.part.as_ref().map_or(k as u32, |part| part.places[number as usize][k]),
                    vertices: facet.map(|vertex| run.vertex(vertex)),
                    held: held.unwrap_or([[0.0; D]; D]),
                });
            }
        }
        let (viscous, dissipated) = (run.solid().viscous(), run.solid().dissipated());
        Self { run, boundaries, sides, viscous, dissipated }
    }

    /// An element with all that is known of it. `owners`: the ranks that own each corner from now on.
    pub(super) fn piece(&self, element: u32, owners: &[u32]) -> ElementPiece<D, N> {
        let Self { run, .. } = *self;
        let (topology, solid, k) = (&run.topology, run.solid(), element as usize);
        let corner = |corner: usize| {
            let number = element * N as u32 + corner as u32;
            let (vertex, node) = (topology.vertices[number as usize], solid.node_at(number));
            let Node { position, velocity } = solid.node(node as usize);
            let star = topology.corners_of(vertex);
            let (count, first) = (star.len() as u32, topology.code_of_corner(star[0]));
            CornerState {
                vertex: run.vertex(vertex),
                place: run.model.mesh.nodes[vertex as usize],
                owner: owners[number as usize],
                node: solid.code_of_node(node, topology),
                position,
                velocity,
                masses: solid.masses(node as usize),
                group: run.contacts().surface.groups[number as usize],
                free: run.contacts().surface.free[vertex as usize],
                corners: run.part.as_ref().map_or(count, |part| part.wide.corners[vertex as usize]),
                first: run.part.as_ref().map_or(first, |part| part.first[vertex as usize]),
                boundaries: self.boundaries.get(&vertex).cloned().unwrap_or_default(),
            }
        };
        let outer = |facet: usize| {
            topology.facet_of[k][facet] == crate::topology::NONE && topology.is_outer(k, facet)
        };
        ElementPiece {
            number: topology.number(element),
            body: run.model.mesh.bodies[k],
            material: run.model.mesh.materials[k],
            watched: run.contacts().surface.watched[k],
            outer: std::array::from_fn(outer),
            initial: run.model.stresses.get(k).copied(),
            mass_factor: run.model.mass_factors.get(k).copied(),
            sets: run.model.joint_facets.get(k).copied(),
            stress: solid.stress(k),
            viscous: self.viscous[k],
            dissipated: self.dissipated.get(k).copied().unwrap_or_default(),
            memory: solid.memory_of(k).collect(),
            corners: std::array::from_fn(corner),
            sides: self.sides.get(&element).cloned().unwrap_or_default(),
        }
    }
}

/// Whether a load acts on nodes, and not on facets.
pub(super) fn acts_on_nodes<const D: usize>(load: &Load<D>) -> bool {
    load.moves_nodes() || matches!(load, Load::Force(_))
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Number of a vertex in the whole mesh.
    pub(crate) fn vertex(&self, vertex: u32) -> u32 {
        self.topology.vertex(vertex)
    }

    /// Vertex with a number in the whole mesh.
    pub(super) fn vertex_with(&self, number: u32) -> Option<u32> {
        self.topology.vertex_with(number)
    }

    /// The elements that this rank counts.
    pub(super) fn counted(&self) -> Vec<u32> {
        let share = self.solid().share();
        (0..self.solid().element_count() as u32).filter(|&element| share.element(element)).collect()
    }

    /// The joints that this rank counts.
    pub(super) fn own_joints(&self) -> Vec<MovingJoint<D>> {
        let counted = (0..self.joints().all.len()).filter(|&joint| self.joints().all[joint].counted);
        let joints = counted.map(|joint| self.joints().moving(joint as u32, &self.topology));
        joints.chain(self.part.iter().flat_map(|part| part.loose_joints.iter().copied())).collect()
    }

    /// The contacts that this rank counts, with the numbers of elements in the whole mesh.
    pub(super) fn own_contacts(&self) -> SavedContacts<D, N> {
        let own = self.contacts().save_counted(|element| self.solid().share().element(element));
        own.renumbered(|element| Some(self.topology.number(element)))
    }

    /// The memory of the actions at elements, as far as this rank counts it.
    pub(super) fn own_records(&self) -> Vec<Record> {
        self.records().into_iter().filter(|record| !record.is_common()).collect()
    }

    /// The step, sums and times that the run keeps when its elements change.
    pub(super) fn carried(&self) -> CarriedState<D> {
        CarriedState {
            step: self.step,
            totals: self.totals.clone(),
            energies: self.energies,
            imbalance: self.imbalance,
            reactions: self.reactions.clone(),
            factors: self.actions.factors.iter().map(|(&boundary, &factor)| (boundary, factor)).collect(),
            records: self.records().into_iter().filter(Record::is_common).collect(),
            timings: self.timings,
            detections: self.contacts().detections(),
        }
    }
}
