//! Elements and nodes, and the forces of their deformation.

use fdem_mesh::Mesh;
use serde::{Deserialize, Serialize};

use crate::elastic::{Moduli, viscous_stress};
use crate::model::Model;
use crate::simplex::Simplex;
use crate::team::Team;
use crate::topology::{NONE, Nodes};
use crate::vector::{
    Matrix, Point, add, contraction, matrix, minus, product, product_transposed, symmetric, transposed,
};

/// Motion of a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub(crate) struct Node<const D: usize = 2> {
    /// Position relative to [`Solid::origin`], m.
    pub(crate) position: Point<D>,
    /// Velocity half a step before the position, m/s.
    pub(crate) velocity: Point<D>,
}

/// Properties of a node that its motion does not change. They are stored apart from [`Node`], which a step reads far more often.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Constants {
    pub(crate) mass: f64,
    /// Node of the mesh.
    pub(crate) vertex: u32,
    /// Prescribed motion of the node: an index of the holds of the loads, or [`NONE`].
    pub(crate) hold: u32,
}

/// An element of constant strain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element<const D: usize = 2> {
    pub(crate) material: u32,
    /// Inverse of the matrix whose columns are the undeformed edges from corner 0, 1/m.
    gradients: Matrix<D>,
    /// Undeformed volume, m³: in two dimensions area times thickness.
    pub(crate) volume: f64,
}

/// Results of the deformation of an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strained<const D: usize = 2> {
    /// Cauchy stress, Pa.
    pub(crate) stress: Matrix<D>,
    /// Strain energy, J.
    pub(crate) energy: f64,
}

impl<const D: usize> Default for Strained<D> {
    fn default() -> Self {
        Self { stress: [[0.0; D]; D], energy: 0.0 }
    }
}

impl<const D: usize> Element<D> {
    /// Mass at each of its corners, kg.
    pub(crate) fn corner_mass<const N: usize>(&self, model: &Model<D, N>) -> f64 {
        model.materials[self.material as usize].density * self.volume / N as f64
    }

    /// Forces on the corners of the element of a stress (first Piola-Kirchhoff), N.
    #[inline]
    fn forces<const N: usize>(&self, stress: &Matrix<D>) -> [Point<D>; N] {
        let on = product_transposed(stress, &self.gradients).map(|row| row.map(|f| -self.volume * f));
        let mut forces = [[0.0; D]; N];
        for axis in 0..D {
            forces[0][axis] = -on[axis][0];
            forces[1][axis] = on[axis][0];
            for k in 1..D {
                forces[0][axis] -= on[axis][k];
                forces[k + 1][axis] = on[axis][k];
            }
        }
        forces
    }
}

/// Constants of a material for the forces of its elements.
#[derive(Clone, Copy, Debug)]
struct Response {
    moduli: Moduli,
    /// Viscosity over the smallest height of an element, Pa s/m.
    viscosity: f64,
}

/// Nodes and elements of all bodies.
///
/// Positions of nodes are relative to [`Solid::origin`], so that bodies far from the origin of the model's coordinates lose no digits.
#[derive(Debug)]
pub(crate) struct Solid<const D: usize = 2, const N: usize = 3> {
    /// Origin of positions, in the model's coordinates, m.
    pub(crate) origin: Point<D>,
    pub(crate) nodes: Vec<Node<D>>,
    pub(crate) constants: Vec<Constants>,
    pub(crate) elements: Vec<Element<D>>,
    /// Results of the deformation of each element.
    pub(crate) strained: Vec<Strained<D>>,
    /// Forces of the deformation and of loads on the corners of each element, N. They are stored apart because the motion of nodes reads nothing else of an element.
    pub(crate) forces: Vec<[Point<D>; N]>,
    /// Viscous part of the stress of each element (first Piola-Kirchhoff), Pa; empty without viscosity.
    pub(crate) viscous: Vec<Matrix<D>>,
    pub(crate) corners: Nodes<N>,
    /// Thickness out of the plane, m; 1 in space.
    pub(crate) thickness: f64,
    responses: Vec<Response>,
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

/// Results of a pass over the elements.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deformation {
    /// Energy dissipated by viscosity since the last pass, J.
    pub(crate) dissipated: f64,
    /// The first inverted element, with its ratio of deformed to undeformed area or volume.
    pub(crate) inverted: Option<(u32, f64)>,
}

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    pub(crate) fn new(model: &Model<D, N>) -> Self {
        let mesh = &model.mesh;
        let element = |number: usize| {
            let corners = corners_of(mesh, number);
            let gradients = <[[f64; D]; N]>::inverse_edges(&corners);
            Element {
                material: mesh.materials[number],
                gradients,
                volume: corners.measure() * model.thickness,
            }
        };
        let elements: Vec<Element<D>> = (0..mesh.elements.len()).map(element).collect();
        let responses: Vec<Response> = model
            .materials
            .iter()
            .map(|material| Response {
                moduli: <[[f64; D]; N]>::moduli(material, model.plane),
                // The highest angular frequency ω of an element is about 2 c/h, so E/ω is half of h √(E ρ).
                viscosity: 0.5 * material.damping * (material.youngs_modulus * material.density).sqrt(),
            })
            .collect();
        let viscous = responses.iter().any(|response| response.viscosity > 0.0);
        let heights = if viscous {
            (0..elements.len()).map(|e| corners_of(mesh, e).least_height()).collect()
        } else {
            Vec::new()
        };
        let all = || mesh.nodes.iter().enumerate();
        let origin = middle_if_far(&mesh.nodes);
        let nodes = all()
            .map(|(vertex, &place)| Node {
                position: minus(place, origin),
                velocity: model.velocities.get(vertex).copied().unwrap_or([0.0; D]),
            })
            .collect();
        let constants =
            all().map(|(vertex, _)| Constants { mass: 0.0, vertex: vertex as u32, hold: NONE }).collect();
        let corners = Nodes::new(mesh.elements.clone(), mesh.nodes.len());
        let moduli = |element: usize| &responses[elements[element].material as usize].moduli;
        let prestress: Vec<Prestress<D>> = model
            .stresses
            .iter()
            .enumerate()
            .map(|(element, &stress)| Prestress {
                stress,
                energy: <[[f64; D]; N]>::stored(moduli(element), &stress),
            })
            .collect();
        let mut strained = vec![Strained::default(); elements.len()];
        for ((strained, prestress), element) in strained.iter_mut().zip(&prestress).zip(&elements) {
            strained.stress = prestress.stress;
            strained.energy = prestress.energy * element.volume;
        }
        let mut solid = Self {
            forces: vec![[[0.0; D]; N]; elements.len()],
            viscous: vec![[[0.0; D]; D]; heights.len()],
            origin,
            nodes,
            constants,
            strained,
            elements,
            corners,
            thickness: model.thickness,
            responses,
            heights,
            prestress,
        };
        for node in 0..solid.nodes.len() {
            solid.weigh(node as u32, model);
        }
        solid
    }

    /// Reserves memory for `count` nodes in total.
    pub(crate) fn reserve_nodes(&mut self, count: usize) {
        let more = count.saturating_sub(self.nodes.len());
        self.nodes.reserve_exact(more);
        self.constants.reserve_exact(more);
        self.corners.reserve(more);
    }

    /// Numbers the nodes by their first corners. If each element has nodes of its own, a step then reads the nodes in the order of the elements.
    pub(crate) fn number_by_corners(&mut self) {
        let mut order: Vec<u32> = (0..self.nodes.len() as u32).collect();
        order.sort_unstable_by_key(|&node| self.corners.of(node as usize)[0]);
        self.nodes = order.iter().map(|&node| self.nodes[node as usize]).collect();
        self.constants = order.iter().map(|&node| self.constants[node as usize]).collect();
        let mut number = vec![0; order.len()];
        for (new, &old) in (0..).zip(&order) {
            number[old as usize] = new;
        }
        let of_corner = self.corners.of_corner.iter().map(|nodes| nodes.map(|node| number[node as usize]));
        self.corners = Nodes::new(of_corner.collect(), order.len());
    }

    /// Sets the mass of a node to the sum over its corners.
    pub(crate) fn weigh(&mut self, node: u32, model: &Model<D, N>) {
        let mut mass = 0.0;
        for &corner in self.corners.of(node as usize) {
            mass += self.elements[corner as usize / N].corner_mass(model);
        }
        self.constants[node as usize].mass = mass;
    }

    /// Present nodes of an element.
    #[inline]
    pub(crate) fn nodes_of(&self, element: u32) -> [u32; N] {
        self.corners.of_corner[element as usize]
    }

    /// Present positions of the corners of an element.
    #[inline]
    pub(crate) fn shape(&self, element: u32) -> [Point<D>; N] {
        self.nodes_of(element).map(|node| self.nodes[node as usize].position)
    }

    #[inline]
    pub(crate) fn at_corner(&self, corner: u32) -> &Node<D> {
        &self.nodes[self.corners.node_at(corner) as usize]
    }

    /// Adds a force, N, on a corner of an element.
    #[inline]
    pub(crate) fn add_force(&mut self, corner: u32, force: Point<D>) {
        add(&mut self.forces[corner as usize / N][corner as usize % N], force, 1.0);
    }

    /// The viscous part of the stress of each element, Pa: 0 without viscosity.
    pub(crate) fn all_viscous(&self) -> Vec<Matrix<D>> {
        let mut all = self.viscous.clone();
        all.resize(self.elements.len(), [[0.0; D]; D]);
        all
    }

    /// Displacement of a node, m.
    pub(crate) fn displacement(&self, node: usize, model: &Model<D, N>) -> Point<D> {
        let vertex = self.constants[node].vertex as usize;
        minus(self.nodes[node].position, minus(model.mesh.nodes[vertex], self.origin))
    }

    /// Converts a position to the model's coordinates, m.
    pub(crate) fn place(&self, position: Point<D>) -> Point<D> {
        std::array::from_fn(|axis| position[axis] + self.origin[axis])
    }

    /// Prescribed motion of the node of a corner: an index of the holds of the loads, or [`NONE`].
    pub(crate) fn hold_at(&self, corner: u32) -> u32 {
        self.constants[self.corners.node_at(corner) as usize].hold
    }

    /// Computes stresses and forces of all elements from the positions and velocities of their nodes.
    pub(crate) fn deform(&mut self, step: f64, team: &Team) -> Deformation {
        let Self {
            nodes, elements, strained, forces, viscous, corners, responses, heights, prestress, ..
        } = self;
        let found = team.change_all(strained, forces, viscous, |first, chunk, forces, viscous| {
            let mut sum = Deformation::default();
            for (k, (strained, forces)) in chunk.iter_mut().zip(forces).enumerate() {
                let number = first + k;
                let element = &elements[number];
                let response = &responses[element.material as usize];
                let ends = corners.of_corner[number].map(|node| &nodes[node as usize]);
                let edges = <[[f64; D]; N]>::edges(&ends.map(|node| node.position));
                let gradient = product(&edges, &element.gradients);
                let j = <[[f64; D]; N]>::determinant(&gradient);
                if (j <= 0.0 || j.is_nan()) && sum.inverted.is_none() {
                    sum.inverted = Some((number as u32, j));
                }
                let (mut stress, mut energy) = <[[f64; D]; N]>::stress(&response.moduli, &gradient, j);
                if let Some(prestress) = prestress.get(number) {
                    let first = product(&gradient, &prestress.stress);
                    stress = matrix(|i, k| stress[i][k] + first[i][k]);
                    let across = transposed(&gradient);
                    let mut strain = product_transposed(&across, &across);
                    for axis in 0..D {
                        strain[axis][axis] -= 1.0;
                    }
                    energy += prestress.energy + 0.5 * contraction(&prestress.stress, &strain);
                }
                if response.viscosity > 0.0 {
                    let edges = <[[f64; D]; N]>::edges(&ends.map(|node| node.velocity));
                    let rate = product(&edges, &element.gradients);
                    let viscosity = response.viscosity * heights[number];
                    let now = viscous_stress::<D, N>(viscosity, &gradient, j, &rate);
                    let before = std::mem::replace(&mut viscous[k], now);
                    // Work of the last viscous stress in the second half of its step, and of the new one in the first half of its step.
                    let power = contraction(&before, &rate) + contraction(&now, &rate);
                    sum.dissipated += 0.5 * step * power * element.volume;
                    stress = matrix(|i, k| stress[i][k] + now[i][k]);
                }
                strained.energy = energy * element.volume;
                let cauchy = symmetric(&product_transposed(&stress, &gradient));
                strained.stress = cauchy.map(|row| row.map(|x| x / j));
                *forces = element.forces(&stress);
            }
            sum
        });
        let mut all = Deformation::default();
        for chunk in found {
            all.dissipated += chunk.dissipated;
            all.inverted = all.inverted.or(chunk.inverted);
        }
        all
    }

    /// Strain energy of all elements in the last pass, J.
    pub(crate) fn strain_energy(&self, team: &Team) -> f64 {
        team.look(self.elements.len(), |range| {
            self.strained[range].iter().map(|strained| strained.energy).sum::<f64>()
        })
        .into_iter()
        .sum()
    }

    /// Whether there is initial stress.
    pub(crate) fn is_prestressed(&self) -> bool {
        !self.prestress.is_empty()
    }

    /// Force of the initial stress of an element on one of its corners, N.
    pub(crate) fn initial_force(&self, corner: u32) -> Point<D> {
        let element = corner as usize / N;
        let Some(prestress) = self.prestress.get(element) else { return [0.0; D] };
        self.elements[element].forces::<N>(&prestress.stress)[corner as usize % N]
    }

    /// Out-of-plane stress of an element in two dimensions, Pa.
    pub(crate) fn moduli(&self, element: usize) -> &Moduli {
        &self.responses[self.elements[element].material as usize].moduli
    }
}

/// Middle of the bounding box along each axis on which the middle is at least as far from 0 as the box is wide; 0 along other axes.
///
/// All coordinates are then within a factor of 2 of the middle, so that differences from it are exact (Sterbenz' lemma).
fn middle_if_far<const D: usize>(nodes: &[Point<D>]) -> Point<D> {
    std::array::from_fn(|axis| {
        let along = || nodes.iter().map(|node| node[axis]);
        let [low, high] = [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)];
        let middle = 0.5 * low + 0.5 * high;
        if middle.abs() >= high - low { middle } else { 0.0 }
    })
}

/// Undeformed corners of an element.
pub(crate) fn corners_of<const D: usize, const N: usize>(mesh: &Mesh<D, N>, element: usize) -> [Point<D>; N] {
    mesh.elements[element].map(|node| mesh.nodes[node as usize])
}
