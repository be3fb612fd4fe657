//! The ground beyond absorbing edges.
//!
//! Three forces act on each end of an edge. Impedances and stiffnesses are per area.
//!
//! - Dashpots with the impedances `ρ c_p` along the normal and `ρ c_s` along the edge, so that waves leave (Lysmer and Kuhlemeyer, 1969).
//! - Springs with the stiffnesses `G/R` along the normal and `G/(2 R)` along the edge, with `R` half of the longer side of the bounding box of the body. They
//!   have the static stiffness of the ground, so that weight or a lasting load is carried after a finite settlement (viscous-spring boundary; Deeks and
//!   Randolph, 1994; Liu, Du, Du, Wang and Wu, 2006). They hardly affect waves shorter than `R`.
//! - Under initial stress, a constant static force. It holds the nodes of these edges in equilibrium at the beginning, under stress, weight and loads. The
//!   ground goes on to carry what it carried before, so that a body in equilibrium stays at rest.
//!
//! The work of springs and static forces counts as work of loads; the work of dashpots is dissipated.

use crate::error::ModelError;
use crate::loads::outer_side;
use crate::model::{Load, Model, Target};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::{NONE, Topology};
use crate::vector::{Point, dot, length, minus};

/// The ground beyond all absorbing edges of a model.
#[derive(Debug, Default)]
pub(crate) struct Ground {
    edges: Vec<Edge>,
}

/// The ground beyond an edge.
#[derive(Debug)]
struct Edge {
    boundary: u32,
    /// Corners of the element at both ends.
    corners: [u32; 2],
    /// Half of the undeformed edge times the thickness, m²: the area of each end.
    area: f64,
    /// Outward normal of the undeformed edge.
    normal: Point,
    /// Impedance along the normal and along the edge, Pa s/m.
    impedance: [f64; 2],
    /// Stiffness along the normal and along the edge, Pa/m.
    stiffness: [f64; 2],
    /// Static force on each end, N.
    held: [Point; 2],
}

/// Forces of the ground on a corner of an element.
pub(crate) struct Reaction {
    pub(crate) boundary: u32,
    pub(crate) corner: u32,
    /// Force of springs, and static force, N.
    pub(crate) elastic: Point,
    /// Force of dashpots, N.
    pub(crate) viscous: Point,
}

impl Ground {
    /// The ground of a model, without static forces.
    pub(crate) fn new(model: &Model, topology: &Topology) -> Result<Self, ModelError> {
        let mesh = &model.mesh;
        let mut edges = Vec::new();
        for (number, boundary) in model.boundaries.iter().enumerate() {
            let (Load::Absorbing, Target::Facets(all)) = (boundary.load, &boundary.target) else { continue };
            for &edge in all {
                let side = outer_side(model, topology, edge, &boundary.name)?;
                let [a, b] = edge.map(|node| mesh.nodes[node as usize]);
                let along = minus(b, a).map(|x| x / side.length);
                let element = side.corners[0] as usize / 3;
                let material = &model.materials[mesh.materials[element] as usize];
                let moduli = <[[f64; 2]; 3]>::moduli(material, model.plane);
                edges.push(Edge {
                    boundary: number as u32,
                    corners: side.corners,
                    area: 0.5 * side.length * model.thickness,
                    normal: [along[1], -along[0]],
                    impedance: [moduli.wave, moduli.shear].map(|modulus| (material.density * modulus).sqrt()),
                    stiffness: [moduli.shear, 0.5 * moduli.shear],
                    held: [[0.0; 2]; 2],
                });
            }
        }
        if !edges.is_empty() {
            let radii = radii(model);
            for edge in &mut edges {
                let radius = radii[&mesh.bodies[edge.corners[0] as usize / 3]];
                edge.stiffness = edge.stiffness.map(|modulus| modulus / radius);
            }
        }
        Ok(Self { edges })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// Sets the static forces so that they hold the nodes of absorbing edges in equilibrium now, at the beginning. `others`: force on a corner besides that of
    /// the initial stress of its element, N.
    pub(crate) fn support(&mut self, model: &Model, solid: &Solid, others: impl Fn(u32) -> Point) {
        let node_at = |corner: u32| solid.corners.node_at(corner) as usize;
        // Edges at the same node share its force in proportion to their lengths.
        let mut width = vec![0.0; solid.nodes.len()];
        for edge in &self.edges {
            for corner in edge.corners {
                width[node_at(corner)] += edge.area;
            }
        }
        for edge in &mut self.edges {
            for end in 0..2 {
                let node = node_at(edge.corners[end]);
                let weight = model.gravity_schedule.factor(0.0) * solid.constants[node].mass;
                let mut force = model.gravity.map(|g| weight * g);
                let mut corner = solid.corners.first[node];
                while corner != NONE {
                    for part in [solid.initial_force(corner), others(corner)] {
                        force[0] += part[0];
                        force[1] += part[1];
                    }
                    corner = solid.corners.next[corner as usize];
                }
                let share = -edge.area / width[node];
                edge.held[end] = force.map(|f| share * f);
            }
        }
    }

    /// Present forces of the ground.
    pub(crate) fn reactions<'a>(
        &'a self,
        solid: &'a Solid,
        model: &'a Model,
    ) -> impl Iterator<Item = Reaction> + 'a {
        self.edges.iter().flat_map(move |edge| {
            let [a, b] = edge.corners.map(|corner| solid.at_corner(corner).position);
            let along = minus(b, a);
            let long = length(along);
            let tangent = along.map(|x| x / long);
            let now = [tangent[1], -tangent[0]];
            [0, 1].map(|end| {
                let corner = edge.corners[end];
                let node = solid.corners.node_at(corner) as usize;
                let moved = solid.displacement(node, model);
                let velocity = solid.nodes[node].velocity;
                let springs = against(moved, edge.normal, edge.stiffness);
                let dashpots = against(velocity, now, edge.impedance);
                Reaction {
                    boundary: edge.boundary,
                    corner,
                    elastic: std::array::from_fn(|axis| edge.held[end][axis] + edge.area * springs[axis]),
                    viscous: dashpots.map(|traction| edge.area * traction),
                }
            })
        })
    }

    /// Stiffness of the springs on corners of elements, N/m, in the stiffer of the two directions.
    pub(crate) fn springs(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.edges.iter().flat_map(|edge| {
            edge.corners.map(|corner| (corner, edge.area * edge.stiffness[0].max(edge.stiffness[1])))
        })
    }
}

/// Traction against a displacement or velocity, with one factor along `normal` and one across it.
fn against(vector: Point, normal: Point, [along, across]: [f64; 2]) -> Point {
    let tangent = [-normal[1], normal[0]];
    let (n, t) = (along * dot(vector, normal), across * dot(vector, tangent));
    std::array::from_fn(|axis| -n * normal[axis] - t * tangent[axis])
}

/// Half of the longer side of the bounding box of each body, m.
fn radii(model: &Model) -> std::collections::BTreeMap<u32, f64> {
    let mesh = &model.mesh;
    let mut boxes = std::collections::BTreeMap::new();
    for (nodes, &body) in mesh.elements.iter().zip(&mesh.bodies) {
        let around = boxes.entry(body).or_insert([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]]);
        for node in nodes {
            for axis in 0..2 {
                let x = mesh.nodes[*node as usize][axis];
                around[0][axis] = around[0][axis].min(x);
                around[1][axis] = around[1][axis].max(x);
            }
        }
    }
    let half = |[min, max]: [Point; 2]| 0.5 * (max[0] - min[0]).max(max[1] - min[1]);
    boxes.into_iter().map(|(body, around)| (body, half(around))).collect()
}
