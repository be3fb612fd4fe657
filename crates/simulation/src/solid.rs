//! Elements and nodes, and the forces of their deformation.

use serde::{Deserialize, Serialize};

use crate::elastic::{Moduli, Tensor, contraction, determinant, product, product_transposed, viscous_stress};
use crate::model::{Model, Plane};
use crate::potential::{Point, Triangle, cross, length, minus};
use crate::team::Team;
use crate::topology::{NONE, Nodes};

/// Motion of a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Node {
    /// Position relative to [`Solid::origin`], m.
    pub(crate) position: Point,
    /// Velocity half a step before the position, m/s.
    pub(crate) velocity: Point,
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

/// A triangle of constant strain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element {
    pub(crate) material: u32,
    /// Inverse of the matrix whose columns are the undeformed edges from corner 0, 1/m.
    gradients: Tensor,
    /// Undeformed area times thickness, m³.
    pub(crate) volume: f64,
}

/// Results of the deformation of an element.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Strained {
    /// Forces on its corners, N.
    pub(crate) forces: [Point; 3],
    /// Cauchy stress, `[xx, yy, xy]` in Pa.
    pub(crate) stress: [f64; 3],
    pub(crate) energy: f64,
    /// Viscous part of the stress (first Piola-Kirchhoff), Pa.
    pub(crate) viscous: Tensor,
}

impl Element {
    /// Mass at each of its corners, kg.
    pub(crate) fn corner_mass(&self, model: &Model) -> f64 {
        model.materials[self.material as usize].density * self.volume / 3.0
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
pub(crate) struct Solid {
    /// Origin of positions, in the model's coordinates, m.
    pub(crate) origin: Point,
    pub(crate) nodes: Vec<Node>,
    pub(crate) constants: Vec<Constants>,
    pub(crate) elements: Vec<Element>,
    /// Results of the deformation of each element.
    pub(crate) strained: Vec<Strained>,
    pub(crate) corners: Nodes,
    pub(crate) thickness: f64,
    responses: Vec<Response>,
    /// Smallest height of each element; empty without viscosity.
    heights: Vec<f64>,
    /// Initial stress of each element; empty for none.
    prestress: Vec<Prestress>,
}

/// The initial stress of an element.
#[derive(Clone, Copy, Debug)]
struct Prestress {
    /// Second Piola-Kirchhoff stress, `[xx, yy, xy]` in Pa.
    stress: [f64; 3],
    /// Energy that it has stored before the run, J/m³.
    energy: f64,
}

/// Results of a pass over the elements.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deformation {
    /// Energy dissipated by viscosity since the last pass, J.
    pub(crate) dissipated: f64,
    /// The first inverted element, with its ratio of deformed to undeformed area.
    pub(crate) inverted: Option<(u32, f64)>,
}

impl Solid {
    pub(crate) fn new(model: &Model) -> Self {
        let mesh = &model.mesh;
        let mut elements = Vec::with_capacity(mesh.triangles.len());
        for number in 0..mesh.triangles.len() {
            let [a, b, c] = triangle_of(mesh, number);
            let (e, f) = (minus(b, a), minus(c, a));
            let double = cross(e, f);
            elements.push(Element {
                material: mesh.materials[number],
                gradients: [f[1] / double, -f[0] / double, -e[1] / double, e[0] / double],
                volume: 0.5 * double * model.thickness,
            });
        }
        let responses: Vec<Response> = model
            .materials
            .iter()
            .map(|material| Response {
                moduli: Moduli::new(material, model.plane),
                // The highest angular frequency ω of an element is about 2 c/h, so E/ω is half of h √(E ρ).
                viscosity: 0.5 * material.damping * (material.youngs_modulus * material.density).sqrt(),
            })
            .collect();
        let viscous = responses.iter().any(|response| response.viscosity > 0.0);
        let heights = if viscous {
            (0..elements.len()).map(|e| least_height(&triangle_of(mesh, e))).collect()
        } else {
            Vec::new()
        };
        let all = || mesh.nodes.iter().enumerate();
        let origin = middle_if_far(&mesh.nodes);
        let nodes = all()
            .map(|(vertex, &place)| Node {
                position: minus(place, origin),
                velocity: model.velocities.get(vertex).copied().unwrap_or_default(),
            })
            .collect();
        let constants =
            all().map(|(vertex, _)| Constants { mass: 0.0, vertex: vertex as u32, hold: NONE }).collect();
        let corners = Nodes::new(mesh.triangles.clone(), mesh.nodes.len());
        let moduli = |element: usize| &responses[elements[element].material as usize].moduli;
        let prestress: Vec<Prestress> = model
            .stresses
            .iter()
            .enumerate()
            .map(|(element, &stress)| Prestress { stress, energy: moduli(element).stored(stress) })
            .collect();
        let mut strained = vec![Strained::default(); elements.len()];
        for ((strained, prestress), element) in strained.iter_mut().zip(&prestress).zip(&elements) {
            strained.stress = prestress.stress;
            strained.energy = prestress.energy * element.volume;
        }
        let mut solid = Self {
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
        self.corners.first.reserve_exact(more);
    }

    /// Numbers the nodes by their first corners. If each element has nodes of its own, a step then reads the nodes in the order of the elements.
    pub(crate) fn number_by_corners(&mut self) {
        let mut order: Vec<u32> = (0..self.nodes.len() as u32).collect();
        order.sort_unstable_by_key(|&node| self.corners.first[node as usize]);
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
    pub(crate) fn weigh(&mut self, node: u32, model: &Model) {
        let (mut mass, mut corner) = (0.0, self.corners.first[node as usize]);
        while corner != NONE {
            mass += self.elements[corner as usize / 3].corner_mass(model);
            corner = self.corners.next[corner as usize];
        }
        self.constants[node as usize].mass = mass;
    }

    /// Present nodes of an element.
    #[inline]
    pub(crate) fn nodes_of(&self, element: u32) -> [u32; 3] {
        self.corners.of_corner[element as usize]
    }

    /// Present positions of the corners of an element.
    #[inline]
    pub(crate) fn triangle(&self, element: u32) -> Triangle {
        self.nodes_of(element).map(|node| self.nodes[node as usize].position)
    }

    #[inline]
    pub(crate) fn at_corner(&self, corner: u32) -> &Node {
        &self.nodes[self.corners.node_at(corner) as usize]
    }

    /// Displacement of a node, m.
    pub(crate) fn displacement(&self, node: usize, model: &Model) -> Point {
        let vertex = self.constants[node].vertex as usize;
        minus(self.nodes[node].position, minus(model.mesh.nodes[vertex], self.origin))
    }

    /// Converts a position to the model's coordinates, m.
    pub(crate) fn place(&self, position: Point) -> Point {
        [position[0] + self.origin[0], position[1] + self.origin[1]]
    }

    /// Prescribed motion of the node of a corner: an index of the holds of the loads, or [`NONE`].
    pub(crate) fn hold_at(&self, corner: u32) -> u32 {
        self.constants[self.corners.node_at(corner) as usize].hold
    }

    /// Computes stresses and forces of all elements from the positions and velocities of their nodes.
    pub(crate) fn deform(&mut self, step: f64, team: &Team) -> Deformation {
        let Self { nodes, elements, strained, corners, responses, heights, prestress, .. } = self;
        let found = team.change(strained, |first, chunk| {
            let mut sum = Deformation::default();
            for (k, strained) in chunk.iter_mut().enumerate() {
                let number = first + k;
                let element = &elements[number];
                let response = &responses[element.material as usize];
                let [a, b, c] = corners.of_corner[number].map(|node| &nodes[node as usize]);
                let (e, f) = (minus(b.position, a.position), minus(c.position, a.position));
                let gradient = product(&[e[0], f[0], e[1], f[1]], &element.gradients);
                let j = determinant(&gradient);
                if (j <= 0.0 || j.is_nan()) && sum.inverted.is_none() {
                    sum.inverted = Some((number as u32, j));
                }
                let (mut stress, mut energy) = response.moduli.stress(&gradient, j);
                if let Some(prestress) = prestress.get(number) {
                    let [xx, yy, xy] = prestress.stress;
                    let second = [xx, xy, xy, yy];
                    let first = product(&gradient, &second);
                    stress = std::array::from_fn(|i| stress[i] + first[i]);
                    let [p, q, r, s] = gradient;
                    let strain = [p * p + r * r - 1.0, p * q + r * s, p * q + r * s, q * q + s * s - 1.0];
                    energy += prestress.energy + 0.5 * contraction(&second, &strain);
                }
                if response.viscosity > 0.0 {
                    let (e, f) = (minus(b.velocity, a.velocity), minus(c.velocity, a.velocity));
                    let rate = product(&[e[0], f[0], e[1], f[1]], &element.gradients);
                    let viscous = viscous_stress(response.viscosity * heights[number], &gradient, j, &rate);
                    // Work of the last viscous stress in the second half of its step, and of the new one in the first half of its step.
                    let power = contraction(&strained.viscous, &rate) + contraction(&viscous, &rate);
                    sum.dissipated += 0.5 * step * power * element.volume;
                    strained.viscous = viscous;
                    stress = std::array::from_fn(|i| stress[i] + viscous[i]);
                }
                strained.energy = energy * element.volume;
                let cauchy = product_transposed(&stress, &gradient);
                strained.stress = [cauchy[0] / j, cauchy[3] / j, 0.5 * (cauchy[1] + cauchy[2]) / j];
                let forces = product_transposed(&stress, &element.gradients).map(|f| -element.volume * f);
                let (one, two) = ([forces[0], forces[2]], [forces[1], forces[3]]);
                strained.forces = [[-one[0] - two[0], -one[1] - two[1]], one, two];
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
    pub(crate) fn initial_force(&self, corner: u32) -> Point {
        let Some(prestress) = self.prestress.get(corner as usize / 3) else { return [0.0; 2] };
        let element = &self.elements[corner as usize / 3];
        let [xx, yy, xy] = prestress.stress;
        let forces = product_transposed(&[xx, xy, xy, yy], &element.gradients).map(|f| -element.volume * f);
        let (one, two) = ([forces[0], forces[2]], [forces[1], forces[3]]);
        [[-one[0] - two[0], -one[1] - two[1]], one, two][corner as usize % 3]
    }

    /// Out-of-plane stress of an element, Pa.
    pub(crate) fn stress_out_of_plane(&self, element: usize) -> f64 {
        let [xx, yy, _] = self.strained[element].stress;
        self.responses[self.elements[element].material as usize].moduli.out_of_plane * (xx + yy)
    }
}

/// Middle of the bounding box along each axis on which the middle is at least as far from 0 as the box is wide; 0 along other axes.
///
/// All coordinates are then within a factor of 2 of the middle, so that differences from it are exact (Sterbenz' lemma).
fn middle_if_far(nodes: &[Point]) -> Point {
    std::array::from_fn(|axis| {
        let along = || nodes.iter().map(|node| node[axis]);
        let [low, high] = [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)];
        let middle = 0.5 * low + 0.5 * high;
        if middle.abs() >= high - low { middle } else { 0.0 }
    })
}

/// Undeformed corners of an element.
pub(crate) fn triangle_of(mesh: &crate::model::Mesh, element: usize) -> Triangle {
    mesh.triangles[element].map(|node| mesh.nodes[node as usize])
}

/// Height of a triangle over its edge from corner `k`, m.
pub(crate) fn height(triangle: &Triangle, k: usize) -> f64 {
    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| triangle[k]);
    let edge = minus(b, a);
    cross(edge, minus(c, a)) / length(edge)
}

pub(crate) fn least_height(triangle: &Triangle) -> f64 {
    (0..3).map(|k| height(triangle, k)).fold(f64::INFINITY, f64::min)
}

/// Square of the highest angular frequency of a free element, 1/s²: the largest ratio of its stiffness to its lumped mass.
pub(crate) fn highest_square(triangle: &Triangle, material: &crate::model::Material, plane: Plane) -> f64 {
    let moduli = Moduli::new(material, plane);
    let [a, b, c] = *triangle;
    let double = cross(minus(b, a), minus(c, a));
    // ∇N of each corner, and S = Σ ∇N ∇Nᵀ. In the axes in which S is diagonal, B Bᵀ is diag(s₁, s₂, s₁ + s₂). D is the same in all axes.
    let gradients = [minus(c, b), minus(a, c), minus(b, a)].map(|[x, y]| [-y / double, x / double]);
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for [x, y] in gradients {
        xx += x * x;
        yy += y * y;
        xy += x * y;
    }
    let [one, two] = crate::elastic::principal_stresses([xx, yy, xy]);
    let (sum, product) = (one + two, (one * two).max(0.0));
    let (wave, shear) = (moduli.wave(), moduli.shear);
    let root = (wave * wave * sum * sum - 16.0 * moduli.bulk * shear * product).max(0.0).sqrt();
    let largest = (0.5 * (wave * sum + root)).max(shear * sum);
    3.0 / material.density * largest
}
