//! Elements and nodes, and the forces of their deformation.

pub(crate) mod batch;
mod by_law;
mod columns;
mod flat;
mod patch;
pub(crate) mod single;
mod viscous;
pub(crate) mod watch;

use std::ops::Range;

use fdem_distributed::wire;
use fdem_mesh::Mesh;
use serde::{Deserialize, Serialize};

use crate::lanes::{Available, LANES, set_tensor, tensor};
use crate::laws::AnyLaw;
use crate::model::{Material, Model};
use crate::rigid::RigidBodies;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::batch::{BatchInputs, BatchResults, Deformed, History, Undeformed, forces_of};
use crate::solid::by_law::ElementBatch;
use crate::sum::{Grains, Sum};
use crate::team::Team;
use crate::topology::{NONE, Nodes, Topology};
use crate::vector::{Matrix, Point, minus};

/// Motion of a node, as it is saved and sent to other ranks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub(crate) struct Node<const D: usize = 2> {
    /// Position relative to [`Solid::origin`], m.
    pub(crate) position: Point<D>,
    /// Velocity half a step before the position, m/s.
    pub(crate) velocity: Point<D>,
}

wire!([const D: usize] Node<D> { position, velocity });

/// Properties of a node that its motion does not change. They are stored apart from positions and
/// velocities, which a step reads far more often.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Constants {
    /// Mass in its motion, kg.
    pub(crate) mass: f64,
    /// Node of the mesh.
    pub(crate) vertex: u32,
    /// Prescribed motion of the node: an index of the holds of the loads, or [`NONE`].
    pub(crate) hold: u32,
}

/// An element of constant strain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidElement {
    pub(crate) material: u32,
    /// Undeformed volume, m³: in two dimensions area times thickness.
    pub(crate) volume: f64,
    /// Length for contacts, m: [`Simplex::contact_length`].
    pub(crate) length: f64,
    /// Mean mass of its nodes, kg.
    pub(crate) mass: f64,
}

impl SolidElement {
    /// Mass at each of its corners, kg: the true one, of its density.
    pub(crate) fn corner_mass<const D: usize, const N: usize>(&self, model: &Model<D, N>) -> f64 {
        model.materials[self.material as usize].density * self.volume / N as f64
    }
}

/// Mean mass of some nodes, kg.
fn mean_mass<const N: usize>(constants: &[Constants], nodes: &[u32; N]) -> f64 {
    nodes.iter().map(|&node| constants[node as usize].mass / N as f64).sum()
}

/// The law and the viscosity of a material in its elements.
#[derive(Clone, Copy, Debug)]
struct Constitution<const D: usize> {
    law: AnyLaw<D>,
    /// Whether the law dissipates energy.
    dissipates: bool,
    /// Viscosity over the smallest height of an element, Pa s/m.
    viscosity: f64,
}

/// Nodes and elements of all bodies: columns, each with a value of every node, element or corner.
///
/// Other files read and write the columns by the functions in `solid/columns.rs`.
///
/// Positions of nodes are relative to [`Solid::origin`], so that bodies far from the origin of the model's
/// coordinates lose no digits.
#[derive(Clone, Debug)]
pub(crate) struct Solid<const D: usize = 2, const N: usize = 3> {
    /// Origin of positions, in the model's coordinates, m.
    pub(crate) origin: Point<D>,
    /// Position of each node relative to the origin, m.
    positions: Vec<Point<D>>,
    /// Velocity of each node half a step before its position, m/s.
    velocities: Vec<Point<D>>,
    constants: Vec<Constants>,
    /// Mass of each node by the densities of its elements, kg, where masses are scaled; empty where they are
    /// not: [`Solid::true_mass`].
    true_masses: Vec<f64>,
    elements: Vec<SolidElement>,
    /// Undeformed shapes of the elements, in batches.
    undeformed: Vec<Undeformed<D>>,
    /// Results of the deformation of the elements, in batches.
    deformed: Vec<Deformed<D>>,
    /// Forces of the deformation, of contacts and of loads on the corners of each element, N. They are stored
    /// apart, element by element, because the motion of nodes reads nothing else of an element.
    forces: Vec<[Point<D>; N]>,
    /// Histories of the elements, in batches; empty if no element keeps anything.
    histories: Vec<History<D>>,
    /// Number of values of the memory of an element: that of the law with the most.
    pub(crate) memory: usize,
    corners: Nodes<N>,
    /// Bodies that are rigid. Their elements have no stress and no forces.
    pub(crate) rigid: RigidBodies<D>,
    share: Share,
    /// Thickness out of the plane, m; 1 in space.
    pub(crate) thickness: f64,
    /// Grains of the works that are added up.
    pub(crate) grains: Grains,
    /// Vector instructions of elements and joints.
    pub(crate) available: Available,
    constitutions: Vec<Constitution<D>>,
    /// Smallest height of each element; empty without viscosity.
    heights: Vec<f64>,
    /// Initial stress of each element; empty for none.
    prestress: Vec<Prestress<D>>,
}

/// The initial stress of an element.
#[derive(Clone, Copy, Debug)]
struct Prestress<const D: usize> {
    /// Second Piola-Kirchhoff stress, Pa.
    stress: Matrix<D>,
    /// Energy that it has stored before the run, J/m³.
    energy: f64,
}

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    pub(crate) fn new(model: &Model<D, N>) -> Self {
        Self::with_origin(model, middle_if_far(&model.mesh.nodes))
    }

    /// The nodes and elements of a model, or of a part of one, with this origin of positions, m.
    pub(crate) fn with_origin(model: &Model<D, N>, origin: Point<D>) -> Self {
        let mesh = &model.mesh;
        let element = |number: usize| {
            let volume = corners_of(mesh, number).measure() * model.thickness;
            let length = <[[f64; D]; N]>::contact_length(volume);
            SolidElement { material: mesh.materials[number], volume, length, mass: 0.0 }
        };
        let elements: Vec<SolidElement> = (0..mesh.elements.len()).map(element).collect();
        let rigid = RigidBodies::new(model, origin);
        let mut undeformed = vec![Undeformed::EMPTY; elements.len().div_ceil(LANES)];
        for (number, element) in elements.iter().enumerate() {
            let gradients = <[[f64; D]; N]>::inverse_edges(&corners_of(mesh, number));
            let batch = &mut undeformed[number / LANES];
            set_tensor(&mut batch.gradients, number % LANES, &gradients);
            // Forces and energy of an element are proportional to it.
            let volume = if rigid.of_element(number as u32).is_some() { 0.0 } else { element.volume };
            batch.volume.set(number % LANES, volume);
        }
        let constitution = |material: &Material| {
            let law = material.in_elements::<D, N>(model.plane);
            Constitution {
                law,
                dissipates: law.dissipates::<N>(),
                // The highest angular frequency ω of an element is about 2 c/h, so E/ω is half of h √(E ρ).
                viscosity: 0.5 * material.damping * (material.stiffest_modulus() * material.density).sqrt(),
            }
        };
        let constitutions: Vec<Constitution<D>> = model.materials.iter().map(constitution).collect();
        let of_element = |number: usize| &constitutions[elements[number].material as usize];
        let viscous = constitutions.iter().any(|constitution| constitution.viscosity > 0.0);
        let memory = constitutions.iter().map(|of| of.law.memory::<N>()).max().unwrap_or_default();
        let lasts = viscous || memory > 0 || constitutions.iter().any(|of| of.dissipates);
        let batches = if lasts { undeformed.len() } else { 0 };
        let mut histories = vec![History::new(memory); batches];
        let mut values = vec![0.0; memory];
        for number in 0..if memory > 0 { elements.len() } else { 0 } {
            of_element(number).law.begin::<N>(&mut values);
            histories[number / LANES].set_memory(number % LANES, &values);
        }
        let heights = if viscous {
            (0..elements.len()).map(|e| corners_of(mesh, e).least_height()).collect()
        } else {
            Vec::new()
        };
        let vertices = 0..mesh.nodes.len();
        let velocity = |vertex: usize| model.velocities.get(vertex).copied().unwrap_or([0.0; D]);
        let constant = |vertex: usize| Constants { mass: 0.0, vertex: vertex as u32, hold: NONE };
        let corners = Nodes::new(mesh.elements.clone(), mesh.nodes.len());
        let prestress: Vec<Prestress<D>> = model
            .stresses
            .iter()
            .enumerate()
            .map(|(element, &stress)| Prestress {
                stress,
                energy: of_element(element).law.stored::<N>(&stress),
            })
            .collect();
        let mut deformed = vec![Deformed::NONE; undeformed.len()];
        let stressed = prestress.iter().zip(&elements).enumerate();
        for (number, (prestress, element)) in stressed.filter(|(k, _)| rigid.of_element(*k as u32).is_none())
        {
            let batch: &mut Deformed<D> = &mut deformed[number / LANES];
            batch.set_stress(number % LANES, &prestress.stress);
            batch.energy.set(number % LANES, prestress.energy * element.volume);
        }
        let mut solid = Self {
            forces: vec![[[0.0; D]; N]; elements.len()],
            histories,
            memory,
            origin,
            true_masses: if model.mass_factors.is_empty() && rigid.is_empty() {
                Vec::new()
            } else {
                vec![0.0; mesh.nodes.len()]
            },
            positions: mesh.nodes.iter().map(|&place| minus(place, origin)).collect(),
            velocities: vertices.clone().map(velocity).collect(),
            constants: vertices.map(constant).collect(),
            elements,
            undeformed,
            deformed,
            available: Available::best(),
            corners,
            rigid,
            share: Share::default(),
            grains: Grains::of(0.0),
            thickness: model.thickness,
            constitutions,
            heights,
            prestress,
        };
        for node in 0..solid.node_count() {
            solid.weigh(node as u32, model);
        }
        solid.list_rigid_nodes();
        solid.place_rigid_nodes(model, 0.0, &Team::ALONE);
        solid
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { positions, velocities, constants, elements, undeformed, deformed, forces, .. } = self;
        let Self { corners, share, heights, prestress, true_masses, histories, .. } = self;
        size_of_val(&**positions)
            + size_of_val(&**velocities)
            + size_of_val(&**constants)
            + size_of_val(&**true_masses)
            + size_of_val(&**elements)
            + size_of_val(&**undeformed)
            + size_of_val(&**deformed)
            + deformed.iter().filter_map(|batch| batch.watch.as_deref()).map(size_of_val).sum::<usize>()
            + size_of_val(&**forces)
            + size_of_val(&**histories)
            + histories.iter().map(|history| size_of_val(&*history.memory)).sum::<usize>()
            + corners.bytes()
            + self.rigid.bytes()
            + size_of_val(&*share.corners)
            + size_of_val(&*share.nodes)
            + size_of_val(&**heights)
            + size_of_val(&**prestress)
    }

    /// Reserves memory for `count` nodes in total.
    pub(crate) fn reserve_nodes(&mut self, count: usize) {
        let more = count.saturating_sub(self.node_count());
        self.positions.reserve_exact(more);
        self.velocities.reserve_exact(more);
        self.constants.reserve_exact(more);
        if !self.true_masses.is_empty() {
            self.true_masses.reserve_exact(more);
        }
        self.corners.reserve(more);
    }

    /// Numbers the nodes by their first corners. If each element has separate nodes, a step then reads the
    /// nodes in the order of the elements.
    pub(crate) fn number_by_corners(&mut self) {
        let mut order: Vec<u32> = (0..self.node_count() as u32).collect();
        order.sort_unstable_by_key(|&node| self.corners.of(node as usize)[0]);
        self.positions = in_order(&self.positions, &order);
        self.velocities = in_order(&self.velocities, &order);
        self.constants = in_order(&self.constants, &order);
        if !self.true_masses.is_empty() {
            self.true_masses = in_order(&self.true_masses, &order);
        }
        let mut number = vec![0; order.len()];
        for (new, &old) in (0..).zip(&order) {
            number[old as usize] = new;
        }
        let of_corner = self.corners.of_corner.iter().map(|nodes| nodes.map(|node| number[node as usize]));
        self.corners = Nodes::new(of_corner.collect(), order.len());
        self.list_rigid_nodes();
    }

    /// The nodes in the order of results: the first of each vertex, and then all others, both in the order of
    /// the vertices. The first node of a vertex is that of its first corner; the others follow in the order
    /// of their first corners. Memory has them in the order in which they appeared.
    pub(crate) fn order(&self, topology: &Topology<D, N>) -> Vec<u32> {
        let key = |&node: &u32| {
            let (vertex, corner) = (self.constants[node as usize].vertex, self.corners.of(node as usize)[0]);
            (corner != topology.corners_of(vertex)[0], vertex, corner)
        };
        let mut order: Vec<u32> = (0..self.node_count() as u32).collect();
        order.sort_unstable_by_key(key);
        order
    }

    /// The nodes of each element, by their places in an order of all nodes.
    pub(crate) fn in_order(&self, order: &[u32]) -> Vec<[u32; N]> {
        let mut place = vec![0; order.len()];
        for (k, &node) in (0..).zip(order) {
            place[node as usize] = k;
        }
        self.corners.of_corner.iter().map(|nodes| nodes.map(|node| place[node as usize])).collect()
    }

    /// Replaces the nodes by those of a saved run. Each vertex keeps its supports.
    pub(crate) fn set_nodes(&mut self, nodes: &[Node<D>], of_corner: Vec<[u32; N]>, model: &Model<D, N>) {
        let vertices = &model.mesh.elements;
        let mut holds = vec![NONE; model.mesh.nodes.len()];
        for constants in &self.constants {
            holds[constants.vertex as usize] = constants.hold;
        }
        self.constants = vec![Constants { mass: 0.0, vertex: NONE, hold: NONE }; nodes.len()];
        for (&node, &vertex) in of_corner.as_flattened().iter().zip(vertices.as_flattened()) {
            self.constants[node as usize] = Constants { mass: 0.0, vertex, hold: holds[vertex as usize] };
        }
        self.corners = Nodes::new(of_corner, nodes.len());
        self.list_rigid_nodes();
        if !self.true_masses.is_empty() {
            self.true_masses = vec![0.0; nodes.len()];
        }
        self.positions = nodes.iter().map(|node| node.position).collect();
        self.velocities = nodes.iter().map(|node| node.velocity).collect();
        for node in 0..self.node_count() as u32 {
            self.weigh(node, model);
        }
        self.weigh_elements();
    }

    /// Sets the masses of a node to the sums over its corners, for the motion of a rigid body to that of the
    /// whole body, and the mean masses of the elements there.
    pub(crate) fn weigh(&mut self, node: u32, model: &Model<D, N>) {
        let Self { elements, constants, true_masses, corners, rigid, .. } = self;
        let (mut mass, mut true_mass) = (0.0, 0.0);
        for &corner in corners.of(node as usize) {
            let element = corner as usize / N;
            let of_corner = elements[element].corner_mass(model);
            mass += model.mass_factor(element) * of_corner;
            true_mass += of_corner;
        }
        let first = corners.of(node as usize)[0] / N as u32;
        constants[node as usize].mass = rigid.mass_with(first).unwrap_or(mass);
        if let Some(of_node) = true_masses.get_mut(node as usize) {
            *of_node = true_mass;
        }
        for &corner in corners.of(node as usize) {
            let element = corner as usize / N;
            elements[element].mass = mean_mass(constants, &corners.of_corner[element]);
        }
    }

    /// Mass of a node in its motion, and its true mass, kg.
    pub(crate) fn masses(&self, node: usize) -> [f64; 2] {
        [self.constants[node].mass, self.true_mass(node)]
    }

    /// Sets the [`Solid::masses`] of every node, kg.
    pub(crate) fn set_masses(&mut self, masses: &[[f64; 2]]) {
        for (constants, [mass, _]) in self.constants.iter_mut().zip(masses) {
            constants.mass = *mass;
        }
        for (of_node, [_, true_mass]) in self.true_masses.iter_mut().zip(masses) {
            *of_node = *true_mass;
        }
        self.weigh_elements();
    }

    /// Sets the [`Solid::masses`] of the node of a corner, kg, and the mean mass of the element.
    pub(crate) fn set_mass(&mut self, corner: u32, [mass, true_mass]: [f64; 2]) {
        let element = corner as usize / N;
        let node = self.corners.node_at(corner) as usize;
        self.constants[node].mass = mass;
        if let Some(of_node) = self.true_masses.get_mut(node) {
            *of_node = true_mass;
        }
        self.elements[element].mass = mean_mass(&self.constants, &self.corners.of_corner[element]);
    }

    /// The code of the first corner of a node, by which other ranks know it.
    pub(crate) fn code_of_node(&self, node: u32, topology: &Topology<D, N>) -> u32 {
        if self.share.node(node as usize) {
            topology.code_of_corner(self.corners.of(node as usize)[0])
        } else {
            self.share.codes[node as usize]
        }
    }

    /// Gives each group of these corners of a vertex a separate node. Returns the nodes whose corners have
    /// changed, ascending.
    pub(crate) fn split(&mut self, corners: &[u32], groups: &[u32]) -> Vec<u32> {
        let Self { positions, velocities, constants, true_masses, corners: lists, share, rigid, .. } = self;
        let mut changed = Vec::new();
        lists.split(corners, groups, |old, new| {
            positions.push(positions[old as usize]);
            velocities.push(velocities[old as usize]);
            constants.push(constants[old as usize]);
            if let Some(&true_mass) = true_masses.get(old as usize) {
                true_masses.push(true_mass);
            }
            share.split(old);
            rigid.split(old);
            changed.extend([old, new]);
        });
        changed.sort_unstable();
        changed.dedup();
        changed
    }

    /// Sets the mean masses of all elements from those of their nodes.
    fn weigh_elements(&mut self) {
        for (element, nodes) in self.elements.iter_mut().zip(&self.corners.of_corner) {
            element.mass = mean_mass(&self.constants, nodes);
        }
    }

    /// The viscous part of the stress of each element, Pa: 0 without viscosity.
    pub(crate) fn viscous(&self) -> Vec<Matrix<D>> {
        let of = |element: usize| match self.histories.get(element / LANES) {
            Some(batch) => tensor(&batch.viscous, element % LANES),
            None => [[0.0; D]; D],
        };
        (0..self.elements.len()).map(of).collect()
    }

    /// Energy that viscosity and laws have dissipated in each element so far, J; empty without any of them.
    pub(crate) fn dissipated(&self) -> Vec<f64> {
        let all = self.histories.iter().flat_map(|batch| (0..LANES).map(|lane| batch.dissipated.get(lane)));
        all.take(if self.dissipates() { self.elements.len() } else { 0 }).collect()
    }

    /// Whether viscosity or a law dissipates energy.
    fn dissipates(&self) -> bool {
        !self.heights.is_empty() || self.constitutions.iter().any(|of| of.dissipates)
    }

    /// The memory of the law in each element, [`Solid::memory`] values each.
    pub(crate) fn memories(&self) -> Vec<f64> {
        let of = |element: usize| self.memory_of(element).take(self.memory);
        (0..if self.memory > 0 { self.elements.len() } else { 0 }).flat_map(of).collect()
    }

    /// The memory of the law in an element.
    pub(crate) fn memory_of(&self, element: usize) -> impl Iterator<Item = f64> {
        let batch = self.histories.get(element / LANES).into_iter();
        batch.flat_map(move |batch| batch.memory.iter().map(move |value| value.get(element % LANES)))
    }

    /// Cauchy stress of an element in the last pass as the components `[xx, yy, zz, xy, yz, xz]`, Pa.
    pub(crate) fn stress_tensor(&self, element: usize) -> [f64; 6] {
        let memory: Vec<f64> = self.memory_of(element).collect();
        self.law(element).in_tensor::<N>(&self.stress(element), &memory)
    }

    /// Takes the stresses over with which some elements begin to deform, Pa: second Piola-Kirchhoff.
    pub(crate) fn take_stresses(&mut self, stresses: &[(u32, Matrix<D>)]) {
        if !stresses.is_empty() && self.prestress.is_empty() {
            self.prestress = vec![Prestress { stress: [[0.0; D]; D], energy: 0.0 }; self.elements.len()];
        }
        for &(element, stress) in stresses {
            let energy = self.law(element as usize).stored::<N>(&stress);
            self.prestress[element as usize] = Prestress { stress, energy };
        }
    }

    /// Sets the stresses of all elements, Pa, the viscous parts of them, the dissipated energies and the
    /// memories to those of a saved run.
    pub(crate) fn restore(
        &mut self,
        stresses: &[Matrix<D>],
        viscous: &[Matrix<D>],
        dissipated: &[f64],
        memories: &[f64],
    ) {
        for (number, stress) in stresses.iter().enumerate() {
            self.deformed[number / LANES].set_stress(number % LANES, stress);
        }
        for (number, viscous) in viscous.iter().enumerate() {
            if let Some(batch) = self.histories.get_mut(number / LANES) {
                set_tensor(&mut batch.viscous, number % LANES, viscous);
            }
        }
        for (number, dissipated) in dissipated.iter().enumerate() {
            if let Some(batch) = self.histories.get_mut(number / LANES) {
                batch.dissipated.set(number % LANES, *dissipated);
            }
        }
        for (number, values) in memories.chunks_exact(self.memory.max(1)).enumerate() {
            if let Some(batch) = self.histories.get_mut(number / LANES) {
                batch.set_memory(number % LANES, values);
            }
        }
    }

    /// Computes stresses and forces of all elements from the positions and velocities of their nodes. Returns
    /// the first inverted element, with its ratio of deformed to undeformed area or volume. Twin:
    /// `solid_deform` in `crates/gpu/kernels/step.h`.
    pub(crate) fn deform(&mut self, step: f64, team: &Team) -> Option<(u32, f64)> {
        match (self.is_prestressed(), !self.heights.is_empty()) {
            (false, false) => self.deform_with::<false, false>(step, team),
            (false, true) => self.deform_with::<false, true>(step, team),
            (true, false) => self.deform_with::<true, false>(step, team),
            (true, true) => self.deform_with::<true, true>(step, team),
        }
    }

    /// [`Solid::deform`], with or without `INITIAL` stress and viscosity.
    fn deform_with<const INITIAL: bool, const VISCOUS: bool>(
        &mut self,
        step: f64,
        team: &Team,
    ) -> Option<(u32, f64)> {
        let Self { positions, velocities, elements, undeformed, deformed, forces, histories, .. } = self;
        let (corners, rigid) = (&self.corners, &self.rigid);
        let constitutions = &self.constitutions;
        let any_dissipates = constitutions.iter().any(|of| of.dissipates);
        let (heights, prestress, available, share) =
            (&self.heights, &self.prestress, self.available, &self.share);
        let found = team.change_batches::<LANES, _, _, _, _>(
            deformed,
            forces,
            histories,
            |first, deformed, forces, histories| {
                let mut inverted = None;
                let (mut given, mut results) = (BatchInputs::NONE, BatchResults::NONE);
                let mut none = History::new(0);
                for (k, deformed) in deformed.iter_mut().enumerate() {
                    let batch = first + k;
                    let range = batch * LANES..((batch + 1) * LANES).min(elements.len());
                    if rigid.has_all(range.clone()) {
                        forces[k * LANES..][..range.len()].fill([[0.0; D]; N]);
                        continue;
                    }
                    for (lane, of_corner) in corners.of_corner[range.clone()].iter().enumerate() {
                        let ends = of_corner.map(|node| positions[node as usize]);
                        let edges = <[[f64; D]; N]>::edges(&ends);
                        set_tensor(&mut given.edges, lane, &edges);
                        if VISCOUS {
                            let ends = of_corner.map(|node| velocities[node as usize]);
                            let rates = <[[f64; D]; N]>::edges(&ends);
                            set_tensor(&mut given.rates, lane, &rates);
                        }
                    }
                    for (lane, number) in range.clone().enumerate() {
                        if VISCOUS {
                            let viscosity = constitutions[elements[number].material as usize].viscosity;
                            given.viscosity.set(lane, viscosity * heights[number]);
                        }
                        if INITIAL {
                            set_tensor(&mut given.initial, lane, &prestress[number].stress);
                            given.stored.set(lane, prestress[number].energy);
                        }
                    }
                    let own = &elements[range.clone()];
                    let undeformed = &undeformed[batch];
                    let history = histories.get_mut(k).unwrap_or(&mut none);
                    // Batches of rigid elements alone are left out, so histories of rigid ones do not change.
                    let before = rigid.among(range.clone()).next().map(|_| history.clone());
                    let batch = ElementBatch {
                        available,
                        undeformed,
                        given: &given,
                        count: own.len(),
                        alike: own.iter().all(|element| element.material == own[0].material),
                    };
                    let law_of = |lane: usize| &constitutions[own[lane].material as usize].law;
                    batch.deform::<N, INITIAL, VISCOUS>(law_of, deformed, history, &mut results);
                    for number in rigid.among(range.clone()) {
                        deformed.set_stress(number % LANES, &[[0.0; D]; D]);
                        if let Some(before) = &before {
                            history.take_lane(before, number % LANES);
                        }
                    }
                    deformed.find_moved(available, &given.edges);
                    let forces = &mut forces[k * LANES..][..range.len()];
                    for (lane, (number, forces)) in range.zip(forces).enumerate() {
                        *forces = results.forces(lane);
                        let ratio = results.ratio.get(lane);
                        if ratio <= 0.0 || ratio.is_nan() {
                            // Its stress may be infinite, and the step is finished.
                            *forces = [[0.0; D]; N];
                            if inverted.is_none() && share.element(number as u32) {
                                inverted = Some((number as u32, ratio));
                            }
                        }
                        if VISCOUS && given.viscosity.get(lane) > 0.0 {
                            // Work of the last viscous stress in the second half of its step, and of the new
                            // one in the first half of its step.
                            let work = 0.5 * step * results.power.get(lane) * undeformed.volume.get(lane);
                            history.dissipated.set(lane, history.dissipated.get(lane) + work);
                        }
                        if any_dissipates && constitutions[own[lane].material as usize].dissipates {
                            let lost = results.dissipated.get(lane) * undeformed.volume.get(lane);
                            history.dissipated.set(lane, history.dissipated.get(lane) + lost);
                        }
                    }
                }
                inverted
            },
        );
        found.into_iter().flatten().next()
    }

    /// Lets the facets of all elements at a vertex be checked in the next step.
    pub(crate) fn wake_around(&mut self, vertex: u32, topology: &Topology<D, N>) {
        topology.corners_of(vertex).iter().for_each(|corner| self.wake(corner / N as u32));
    }

    /// Strain energy in the last pass, and energy that viscosity and laws have dissipated so far, J.
    pub(crate) fn energies(&self, team: &Team) -> [Sum; 2] {
        let of = |range: Range<usize>| {
            let dissipated = |element: usize| {
                self.histories.get(element / LANES).map(|batch| batch.dissipated.get(element % LANES))
            };
            let counted = || range.clone().filter(|&element| self.share.element(element as u32));
            [
                counted().map(|element| self.energy(element)).collect(),
                counted().filter_map(dissipated).collect(),
            ]
        };
        Sum::all(team.look(self.elements.len(), of))
    }

    /// Whether there is initial stress.
    pub(crate) fn is_prestressed(&self) -> bool {
        !self.prestress.is_empty()
    }

    /// Force of the initial stress of an element on one of its corners, N.
    pub(crate) fn initial_force(&self, corner: u32) -> Point<D> {
        let element = corner as usize / N;
        let Some(prestress) = self.prestress.get(element) else { return [0.0; D] };
        let (batch, lane) = (&self.undeformed[element / LANES], element % LANES);
        let gradients = tensor(&batch.gradients, lane);
        let forces: [Point<D>; N] = forces_of(&prestress.stress, &gradients, batch.volume.get(lane));
        forces[corner as usize % N]
    }

    /// The inverse of the matrix of the edges of an undeformed element, 1/m.
    pub(crate) fn inverse_edges(&self, element: usize) -> Matrix<D> {
        tensor(&self.undeformed[element / LANES].gradients, element % LANES)
    }

    /// The law of an element.
    pub(crate) fn law(&self, element: usize) -> &AnyLaw<D> {
        &self.constitutions[self.elements[element].material as usize].law
    }
}

/// Middle of the bounding box along each axis on which the middle is at least as far from 0 as the box is
/// wide; 0 along other axes.
///
/// All coordinates are then within a factor of 2 of the middle, so that differences from it are exact
/// (Sterbenz' lemma).
fn middle_if_far<const D: usize>(nodes: &[Point<D>]) -> Point<D> {
    std::array::from_fn(|axis| {
        let along = || nodes.iter().map(|node| node[axis]);
        let [low, high] = [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)];
        let middle = 0.5 * low + 0.5 * high;
        if middle.abs() >= high - low { middle } else { 0.0 }
    })
}

/// The values of a column in this order.
fn in_order<T: Copy>(column: &[T], order: &[u32]) -> Vec<T> {
    order.iter().map(|&k| column[k as usize]).collect()
}

/// Undeformed corners of an element.
pub(crate) fn corners_of<const D: usize, const N: usize>(mesh: &Mesh<D, N>, element: usize) -> [Point<D>; N] {
    mesh.elements[element].map(|node| mesh.nodes[node as usize])
}
