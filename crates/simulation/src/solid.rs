//! Elements and nodes, and the forces of deformation.

use serde::{Deserialize, Serialize};

use crate::elastic::{Moduli, Tensor, contraction, determinant, product, product_transposed, viscous_stress};
use crate::model::{Model, Plane};
use crate::potential::{Point, Triangle, cross, minus};
use crate::team::Team;
use crate::topology::{NONE, Nodes, Topology};

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Node {
    pub(crate) position: Point,
    /// Half a step before the position.
    pub(crate) velocity: Point,
    /// Where it was at the beginning.
    pub(crate) origin: Point,
    pub(crate) mass: f64,
    /// The node of the mesh.
    pub(crate) vertex: u32,
    /// What moves it: a number among the holds of the loads, or [`NONE`].
    pub(crate) hold: u32,
}

/// A triangle of constant strain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Element {
    pub(crate) nodes: [u32; 3],
    pub(crate) material: u32,
    /// Inverse of the undeformed edges from corner 0, as columns.
    gradients: Tensor,
    /// Undeformed area times thickness.
    pub(crate) volume: f64,
    /// On its corners.
    pub(crate) forces: [Point; 3],
    /// Cauchy, `[xx, yy, xy]`.
    pub(crate) stress: [f64; 3],
    pub(crate) energy: f64,
    /// The viscous part of the stress (first Piola-Kirchhoff).
    pub(crate) viscous: Tensor,
    /// Among the entries of the contacts: first, and one past the last.
    pub(crate) contacts: [u32; 2],
}

impl Element {
    /// What it weighs at each of its corners, kg.
    pub(crate) fn corner_mass(&self, model: &Model) -> f64 {
        model.materials[self.material as usize].density * self.volume / 3.0
    }
}

/// The material of an element, as its forces need it.
#[derive(Clone, Copy, Debug)]
struct Response {
    moduli: Moduli,
    /// Viscosity over the smallest height of an element, Pa s/m.
    viscosity: f64,
}

/// Bodies of elements.
#[derive(Debug)]
pub(crate) struct Solid {
    pub(crate) nodes: Vec<Node>,
    pub(crate) elements: Vec<Element>,
    pub(crate) corners: Nodes,
    pub(crate) thickness: f64,
    responses: Vec<Response>,
    /// Smallest height of each element; empty without viscosity.
    heights: Vec<f64>,
    /// Second Piola-Kirchhoff stress at the beginning, `[xx, yy, xy]`; empty for none.
    prestress: Vec<[f64; 3]>,
}

/// What a pass over the elements found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deformation {
    /// Dissipated by viscosity since the last pass.
    pub(crate) dissipated: f64,
    /// The first inverted element, with its ratio of areas.
    pub(crate) inverted: Option<(u32, f64)>,
}

impl Solid {
    pub(crate) fn new(model: &Model, topology: &Topology) -> Self {
        let mesh = &model.mesh;
        let mut elements = Vec::with_capacity(mesh.triangles.len());
        for (number, &nodes) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = nodes.map(|node| mesh.nodes[node as usize]);
            let (e, f) = (minus(b, a), minus(c, a));
            let double = cross(e, f);
            elements.push(Element {
                nodes,
                material: mesh.materials[number],
                gradients: [f[1] / double, -f[0] / double, -e[1] / double, e[0] / double],
                volume: 0.5 * double * model.thickness,
                forces: [[0.0; 2]; 3],
                stress: [0.0; 3],
                energy: 0.0,
                viscous: [0.0; 4],
                contacts: [0; 2],
            });
        }
        let responses: Vec<Response> = model
            .materials
            .iter()
            .map(|material| Response {
                moduli: Moduli::new(material, model.plane),
                // The fastest mode of an element is near 2 c over its height: E/ω is half of h √(E ρ).
                viscosity: 0.5 * material.damping * (material.youngs_modulus * material.density).sqrt(),
            })
            .collect();
        let viscous = responses.iter().any(|response| response.viscosity > 0.0);
        let heights = if viscous {
            (0..elements.len()).map(|e| least_height(&triangle_of(mesh, e))).collect()
        } else {
            Vec::new()
        };
        let nodes = mesh
            .nodes
            .iter()
            .enumerate()
            .map(|(vertex, &position)| Node {
                position,
                velocity: model.velocities.get(vertex).copied().unwrap_or_default(),
                origin: position,
                mass: 0.0,
                vertex: vertex as u32,
                hold: NONE,
            })
            .collect();
        let corners = Nodes::new(topology.vertices.clone(), mesh.nodes.len());
        let mut solid = Self {
            nodes,
            elements,
            corners,
            thickness: model.thickness,
            responses,
            heights,
            prestress: model.stresses.clone(),
        };
        for node in 0..solid.nodes.len() {
            solid.weigh(node as u32, model);
        }
        solid
    }

    /// Gives a node the mass of its corners.
    pub(crate) fn weigh(&mut self, node: u32, model: &Model) {
        let (mut mass, mut corner) = (0.0, self.corners.first[node as usize]);
        while corner != NONE {
            mass += self.elements[corner as usize / 3].corner_mass(model);
            corner = self.corners.next[corner as usize];
        }
        self.nodes[node as usize].mass = mass;
    }

    /// The corners of an element now.
    #[inline]
    pub(crate) fn triangle(&self, element: u32) -> Triangle {
        self.elements[element as usize].nodes.map(|node| self.nodes[node as usize].position)
    }

    #[inline]
    pub(crate) fn at_corner(&self, corner: u32) -> &Node {
        &self.nodes[self.corners.of_corner[corner as usize] as usize]
    }

    /// Stress and forces of all elements, from where their nodes are and how they move.
    pub(crate) fn deform(&mut self, step: f64, team: &Team) -> Deformation {
        let Self { nodes, elements, responses, heights, prestress, .. } = self;
        let (nodes, responses, heights, prestress) =
            (&nodes[..], &responses[..], &heights[..], &prestress[..]);
        let found = team.change(elements, |first, chunk| {
            let mut sum = Deformation::default();
            for (k, element) in chunk.iter_mut().enumerate() {
                let number = first + k;
                let response = &responses[element.material as usize];
                let [a, b, c] = element.nodes.map(|node| &nodes[node as usize]);
                let (e, f) = (minus(b.position, a.position), minus(c.position, a.position));
                let gradient = product(&[e[0], f[0], e[1], f[1]], &element.gradients);
                let j = determinant(&gradient);
                if (j <= 0.0 || j.is_nan()) && sum.inverted.is_none() {
                    sum.inverted = Some((number as u32, j));
                }
                let (mut stress, mut energy) = response.moduli.stress(&gradient, j);
                if let Some(&[xx, yy, xy]) = prestress.get(number) {
                    let second = [xx, xy, xy, yy];
                    let first = product(&gradient, &second);
                    stress = std::array::from_fn(|i| stress[i] + first[i]);
                    let [p, q, r, s] = gradient;
                    let strain = [p * p + r * r - 1.0, p * q + r * s, p * q + r * s, q * q + s * s - 1.0];
                    energy += 0.5 * contraction(&second, &strain);
                }
                if response.viscosity > 0.0 {
                    let (e, f) = (minus(b.velocity, a.velocity), minus(c.velocity, a.velocity));
                    let rate = product(&[e[0], f[0], e[1], f[1]], &element.gradients);
                    let viscous = viscous_stress(response.viscosity * heights[number], &gradient, j, &rate);
                    // What the last force did in the second half of its step, and this one in the first half.
                    let power = contraction(&element.viscous, &rate) + contraction(&viscous, &rate);
                    sum.dissipated += 0.5 * step * power * element.volume;
                    element.viscous = viscous;
                    stress = std::array::from_fn(|i| stress[i] + viscous[i]);
                }
                element.energy = energy * element.volume;
                let cauchy = product_transposed(&stress, &gradient);
                element.stress = [cauchy[0] / j, cauchy[3] / j, 0.5 * (cauchy[1] + cauchy[2]) / j];
                let forces = product_transposed(&stress, &element.gradients).map(|f| -element.volume * f);
                let (one, two) = ([forces[0], forces[2]], [forces[1], forces[3]]);
                element.forces = [[-one[0] - two[0], -one[1] - two[1]], one, two];
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

    /// Stored in the elements by the last pass.
    pub(crate) fn strain_energy(&self, team: &Team) -> f64 {
        team.look(self.elements.len(), |range| {
            self.elements[range].iter().map(|element| element.energy).sum::<f64>()
        })
        .into_iter()
        .sum()
    }

    /// The stress out of the plane of an element.
    pub(crate) fn stress_out_of_plane(&self, element: &Element) -> f64 {
        self.responses[element.material as usize].moduli.out_of_plane
            * (element.stress[0] + element.stress[1])
    }
}

/// An element of the mesh.
pub(crate) fn triangle_of(mesh: &crate::model::Mesh, element: usize) -> Triangle {
    mesh.triangles[element].map(|node| mesh.nodes[node as usize])
}

/// Height of a triangle over its edge from corner `k`.
pub(crate) fn height(triangle: &Triangle, k: usize) -> f64 {
    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| triangle[k]);
    let edge = minus(b, a);
    cross(edge, minus(c, a)) / edge[0].hypot(edge[1])
}

pub(crate) fn least_height(triangle: &Triangle) -> f64 {
    (0..3).map(|k| height(triangle, k)).fold(f64::INFINITY, f64::min)
}

/// Largest ratio of stiffness to mass of an element that is free, 1/s²: the square of its highest frequency.
pub(crate) fn highest_square(triangle: &Triangle, material: &crate::model::Material, plane: Plane) -> f64 {
    let moduli = Moduli::new(material, plane);
    let [a, b, c] = *triangle;
    let double = cross(minus(b, a), minus(c, a));
    // ∇N of each corner; S = Σ ∇N ∇Nᵀ. With S diagonal, B Bᵀ is diag(s₁, s₂, s₁ + s₂), and D is the same in any axes.
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
