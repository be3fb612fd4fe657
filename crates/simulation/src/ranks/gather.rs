//! The whole of a run on many ranks, as results and checkpoints have it.
//!
//! Rank 0 gets the state of each element and node, and not the data that is needed to advance them.

use fdem_distributed::wire;
use fdem_grains::SphereColumns;

use crate::action::Record;
use crate::actions::spheres::SavedSpheres;
use crate::contacts::SavedContacts;
use crate::forces::{Forces, OwnForces};
use crate::joints::saved::{MovingJoint, SavedJoints};
use crate::model::Model;
use crate::ranks::piece::{CarriedState, CommonData};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::simulation::saved::State;
use crate::simulation::snapshots::{cracks, intact};
use crate::snapshot::{Crack, Snapshot, WetJoint};
use crate::solid::Node;
use crate::topology::NONE;
use crate::vector::{Matrix, Point, plus};

/// A node that a rank owns.
#[derive(Clone, Copy, Debug)]
struct OwnNode<const D: usize> {
    /// Code of its first corner, and whether that is the first of its vertex.
    code: u32,
    is_first: bool,
    vertex: u32,
    node: Node<D>,
    displacement: Point<D>,
}

wire!([const D: usize] OwnNode<D> { code, is_first, vertex, node, displacement });

/// An element that a rank counts.
#[derive(Clone, Copy, Debug)]
struct OwnElement<const D: usize, const N: usize> {
    number: u32,
    body: u32,
    material: u32,
    /// Codes of the first corners of its nodes.
    nodes: [u32; N],
    stress: Matrix<D>,
}

wire!([const D: usize, const N: usize] OwnElement<D, N> { number, body, material, nodes, stress });

/// All that a rank counts, for results and checkpoints.
pub(super) struct OwnResults<const D: usize, const N: usize> {
    nodes: Vec<OwnNode<D>>,
    elements: Vec<OwnElement<D, N>>,
    /// Viscous stress, and dissipated energy, of each of the elements; empty if nothing is dissipated.
    viscous: Vec<Matrix<D>>,
    dissipated: Vec<f64>,
    /// Memories of the laws in the elements, one after the other.
    memories: Vec<f64>,
    joints: Vec<MovingJoint<D>>,
    contacts: SavedContacts<D, N>,
    records: Vec<Record>,
    forces: OwnForces<D>,
}

wire!([const D: usize, const N: usize] OwnResults<D, N> {
    nodes, elements, viscous, dissipated, memories, joints, contacts, records, forces,
});

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// All that this rank counts, for results and checkpoints.
    pub(super) fn own(&self) -> OwnResults<D, N> {
        let Self { topology, model, .. } = self;
        let solid = self.solid();
        let share = solid.share();
        let node = |number: usize| {
            let vertex = solid.vertex(number);
            let code = topology.code_of_corner(solid.corners(number)[0]);
            let first = || topology.code_of_corner(topology.corners_of(vertex)[0]);
            OwnNode {
                code,
                is_first: code == self.part.as_ref().map_or_else(first, |part| part.first[vertex as usize]),
                vertex: self.vertex(vertex),
                node: solid.node(number),
                displacement: solid.displacement(number, model),
            }
        };
        let element = |number: usize| OwnElement {
            number: topology.number(number as u32),
            body: model.mesh.bodies[number],
            material: model.mesh.materials[number],
            nodes: solid.nodes_of(number as u32).map(|node| solid.code_of_node(node, topology)),
            stress: solid.stress(number),
        };
        let counted = || (0..solid.element_count()).filter(|&element| share.element(element as u32));
        let dissipated = solid.dissipated();
        let viscous = if dissipated.is_empty() { Vec::new() } else { solid.viscous() };
        OwnResults {
            nodes: (0..solid.node_count()).filter(|&number| share.node(number)).map(node).collect(),
            elements: counted().map(element).collect(),
            viscous: counted().filter_map(|element| viscous.get(element).copied()).collect(),
            dissipated: counted().filter_map(|element| dissipated.get(element).copied()).collect(),
            memories: counted().flat_map(|element| solid.memory_of(element)).collect(),
            joints: self.own_joints(),
            contacts: self.own_contacts(),
            records: self.own_records(),
            forces: self.own_forces(),
        }
    }
}

/// The whole of a [`Distributed`](crate::Distributed) run after a step, for results and checkpoints.
#[derive(Clone, Debug)]
pub struct Gathered<const D: usize = 2, const N: usize = 3> {
    carried: CarriedState<D>,
    time: f64,
    origin: Point<D>,
    model: Model<D, N>,
    /// In the order of results: see [`Snapshot`].
    nodes: Vec<OwnNode<D>>,
    /// Nodes of each element.
    elements: Vec<[u32; N]>,
    bodies: Vec<u32>,
    materials: Vec<u32>,
    stresses: Vec<Matrix<D>>,
    viscous: Vec<Matrix<D>>,
    dissipated: Vec<f64>,
    /// Memories of the laws in the elements, one after the other.
    memories: Vec<f64>,
    /// In the order of their facets, with the numbers of their nodes.
    joints: Vec<MovingJoint<D>>,
    contacts: SavedContacts<D, N>,
    records: Vec<Record>,
    fragments: Vec<u32>,
    forces: OwnForces<D>,
    spheres: SphereColumns,
    saved_spheres: Option<SavedSpheres<D>>,
    fluid: Option<Vec<WetJoint>>,
}

impl<const D: usize, const N: usize> Gathered<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Puts together the parts that the ranks send, one after the other.
    pub(super) fn of(
        frame: &CommonData<D, N>,
        carried: CarriedState<D>,
        all: impl Iterator<Item = OwnResults<D, N>>,
        fragments: Vec<u32>,
        (spheres, saved_spheres): (SphereColumns, Option<SavedSpheres<D>>),
    ) -> Self {
        let elements = frame.elements as usize;
        let mut whole = Self {
            time: carried.step as f64 * frame.scales.time_step,
            carried,
            origin: frame.origin,
            model: frame.model.clone(),
            nodes: Vec::new(),
            elements: vec![[0; N]; elements],
            bodies: vec![0; elements],
            materials: vec![0; elements],
            stresses: vec![[[0.0; D]; D]; elements],
            viscous: vec![[[0.0; D]; D]; elements],
            dissipated: Vec::new(),
            memories: Vec::new(),
            joints: Vec::new(),
            contacts: SavedContacts::default(),
            records: Vec::new(),
            fragments,
            forces: OwnForces::default(),
            spheres,
            saved_spheres,
            fluid: None,
        };
        all.for_each(|own| whole.add(own));
        whole.put_in_order();
        whole
    }

    /// The same with the joints that fluid can enter.
    pub(super) fn with_fluid(self, fluid: Option<Vec<WetJoint>>) -> Self {
        Self { fluid, ..self }
    }

    /// Adds the part of a rank. Its elements name nodes by their codes.
    fn add(&mut self, own: OwnResults<D, N>) {
        for element in &own.elements {
            let k = element.number as usize;
            self.elements[k] = element.nodes;
            self.bodies[k] = element.body;
            self.materials[k] = element.material;
            self.stresses[k] = element.stress;
        }
        if !own.dissipated.is_empty() {
            self.dissipated.resize(self.elements.len(), 0.0);
        }
        for ((element, viscous), dissipated) in own.elements.iter().zip(own.viscous).zip(own.dissipated) {
            let k = element.number as usize;
            (self.viscous[k], self.dissipated[k]) = (viscous, dissipated);
        }
        let length = own.memories.len() / own.elements.len().max(1);
        if length > 0 {
            self.memories.resize(length * self.elements.len(), 0.0);
            for (element, memory) in own.elements.iter().zip(own.memories.chunks_exact(length)) {
                self.memories[element.number as usize * length..][..length].copy_from_slice(memory);
            }
        }
        self.nodes.extend(own.nodes);
        self.joints.extend(own.joints);
        self.contacts.add(own.contacts);
        self.records.extend(own.records);
        self.forces.add(own.forces);
    }

    /// Gives nodes their numbers, and everything the order that it has in one process.
    fn put_in_order(&mut self) {
        let Self { nodes, elements, joints, records, contacts, carried, .. } = self;
        nodes.sort_unstable_by_key(|node| (!node.is_first, node.vertex, node.code));
        let mut number_of = vec![NONE; N * elements.len()];
        for (number, node) in (0..).zip(&*nodes) {
            number_of[node.code as usize] = number;
        }
        for codes in &mut *elements {
            *codes = codes.map(|code| number_of[code as usize]);
        }
        joints.sort_unstable_by_key(|moving| moving.joint.facet);
        for moving in joints {
            moving.find_nodes(|corner| elements[corner as usize / N][corner as usize % N]);
        }
        records.extend(carried.records.iter().cloned());
        records.sort_unstable();
        contacts.sort();
    }

    /// The whole joints now: see [`Simulation::intact_joints`](crate::Simulation::intact_joints).
    pub fn intact_joints(&self) -> Vec<Crack<D>> {
        let nodes = self.moving_nodes();
        let joints = self.joints.iter().map(MovingJoint::seen::<N>);
        intact::<D, N>(joints, |node| nodes[node as usize].position, self.origin)
    }

    /// Positions, motion, stress and cracks now.
    pub fn snapshot(&self) -> Snapshot<D, N> {
        let laws: Vec<_> =
            self.model.materials.iter().map(|at| at.in_elements::<D, N>(self.model.plane)).collect();
        let length = self.memories.len() / self.elements.len().max(1);
        let tensor = |(element, stress): (usize, &Matrix<D>)| {
            let memory = &self.memories[element * length..][..length];
            laws[self.materials[element] as usize].in_tensor::<N>(stress, memory)
        };
        let nodes = self.moving_nodes();
        let joints = self.joints.iter().map(MovingJoint::seen::<N>);
        let (damage, cracks) =
            cracks::<D, N>(joints, |node| nodes[node as usize].position, self.origin, self.elements.len());
        Snapshot {
            step: self.carried.step,
            time: self.time,
            positions: nodes.iter().map(|node| plus(node.position, self.origin)).collect(),
            displacements: self.nodes.iter().map(|node| node.displacement).collect(),
            velocities: nodes.iter().map(|node| node.velocity).collect(),
            elements: self.elements.clone(),
            stresses: self.stresses.iter().enumerate().map(tensor).collect(),
            damage,
            bodies: self.bodies.clone(),
            materials: self.materials.clone(),
            fragments: self.fragments.clone(),
            cracks,
            intact: None,
            strengths: self.model.materials.iter().map(|material| material.strength).collect(),
            laws: self.model.materials.iter().map(|material| material.law.clone()).collect(),
            spheres: self.spheres.clone(),
            fluid: self.fluid.clone(),
            // No model with pores runs on many ranks.
            pore_pressures: None,
        }
    }

    /// State from which the run can be resumed, on any number of ranks.
    pub fn state(&self) -> State<D, N> {
        State {
            released: Vec::new(),
            spheres: self.saved_spheres.clone(),
            step: self.carried.step,
            totals: self.carried.totals.clone(),
            energies: self.carried.energies,
            reactions: self.carried.reactions.clone(),
            nodes: self.moving_nodes(),
            of_corner: self.elements.clone(),
            stresses: self.stresses.clone(),
            viscous: self.viscous.clone(),
            dissipated: self.dissipated.clone(),
            memories: self.memories.clone(),
            joints: SavedJoints::of(self.joints.clone()),
            contacts: self.contacts.clone(),
            factors: self.carried.factors.iter().copied().collect(),
            records: self.records.clone(),
        }
    }

    /// Forces of contacts and boundaries at the beginning of the last step.
    pub fn forces(&self) -> Forces<D> {
        self.forces.clone().placed(self.nodes.iter().map(|node| node.code), self.origin)
    }

    /// Positions and velocities of all nodes.
    fn moving_nodes(&self) -> Vec<Node<D>> {
        self.nodes.iter().map(|node| node.node).collect()
    }
}
