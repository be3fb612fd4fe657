//! The ground beyond absorbing facets.
//!
//! Three forces act on each end of an facet. Impedances and stiffnesses are per area.
//!
//! - Dashpots with the impedances `ρ c_p` along the normal and `ρ c_s` along the facet, so that waves leave
//!   (Lysmer and Kuhlemeyer, 1969).
//! - Springs with the stiffnesses `G/R` along the normal and `G/(2 R)` along the facet, with `R` half of the
//!   longer side of the bounding box of the body. They have the static stiffness of the ground, so that
//!   weight or a lasting load is carried after a finite settlement (viscous-spring boundary; Deeks and
//!   Randolph, 1994; Liu, Du, Du, Wang and Wu, 2006). They hardly affect waves shorter than `R`.
//! - Under initial stress, a constant static force. It holds the nodes of these facets in equilibrium at the
//!   beginning, under stress, weight and loads. The ground continues to carry its load, so that a body in
//!   equilibrium stays at rest.
//!
//! The work of springs and static forces counts as work of loads; the work of dashpots is dissipated.

use std::collections::BTreeMap;

use crate::action::{Acting, Action, Applied, Scene};
use crate::error::ModelError;
use crate::model::{Load, Model, Target};
use crate::outer_side::outer_side;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Topology;
use crate::vector::{Point, add, dot, minus, plus, unit};

/// The ground beyond all absorbing facets of a model.
#[derive(Debug, Default)]
pub(crate) struct Ground<const D: usize = 2, const N: usize = 3> {
    facets: Vec<Beyond<D>>,
}

/// The ground beyond an facet.
#[derive(Debug)]
struct Beyond<const D: usize> {
    boundary: u32,
    /// Corners of the element at both ends.
    corners: [u32; D],
    /// Half of the undeformed facet times the thickness, m²: the area of each end.
    area: f64,
    /// Outward normal of the undeformed facet.
    normal: Point<D>,
    /// Impedance along the normal and along the facet, Pa s/m.
    impedance: [f64; 2],
    /// Stiffness along the normal and along the facet, Pa/m.
    stiffness: [f64; 2],
    /// Static force on each end, N.
    held: [Point<D>; D],
    /// Whether this is no ground, but the forces of something that was there: [`Load::Held`].
    is_held: bool,
}

impl<const D: usize, const N: usize> Ground<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The ground of a model, without static forces. `known`: [`radii`] of the bodies, if this is a part of a
    /// model.
    pub(crate) fn new(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        known: Option<&BTreeMap<u32, f64>>,
    ) -> Result<Self, ModelError> {
        let mesh = &model.mesh;
        let mut facets = Vec::new();
        for (number, boundary) in model.boundaries.iter().enumerate() {
            if !is_ground(&boundary.load) {
                continue;
            }
            let is_held = matches!(boundary.load, Load::Held);
            for (k, &facet) in boundary.target.facets().iter().enumerate() {
                let side = outer_side(model, topology, facet, &boundary.name)?;
                let corners = facet.map(|node| mesh.nodes[node as usize]);
                let element = side.corners[0] as usize / N;
                let material = &model.materials[mesh.materials[element] as usize];
                let normal = unit(<[[f64; D]; N]>::axes(&corners)[0]);
                let [wave, shear] = material.in_elements::<D, N>(model.plane).wave_moduli::<N>(normal);
                let held = if let Target::Held(_, forces) = &boundary.target { forces.get(k) } else { None };
                facets.push(Beyond {
                    boundary: number as u32,
                    corners: side.corners,
                    area: if is_held { 0.0 } else { side.measure / D as f64 * model.thickness },
                    normal,
                    impedance: [wave, shear].map(|modulus| (material.density * modulus).sqrt()),
                    stiffness: [shear, 0.5 * shear],
                    held: held.copied().unwrap_or([[0.0; D]; D]),
                    is_held,
                });
            }
        }
        if !facets.is_empty() {
            let own = if known.is_none() { radii(model) } else { BTreeMap::new() };
            let radii = known.unwrap_or(&own);
            for facet in &mut facets {
                let radius = radii[&mesh.bodies[facet.corners[0] as usize / N]];
                facet.stiffness = facet.stiffness.map(|modulus| modulus / radius);
            }
        }
        Ok(Self { facets })
    }

    /// Static forces on the ends of each facet, N, by boundary and in the order of its facets.
    pub(crate) fn held(&self) -> impl Iterator<Item = (u32, [Point<D>; D])> {
        self.facets.iter().map(|facet| (facet.boundary, facet.held))
    }

    /// Sets the static forces to these, in the same order.
    pub(crate) fn hold(&mut self, held: impl IntoIterator<Item = [Point<D>; D]>) {
        for (facet, held) in self.facets.iter_mut().zip(held) {
            facet.held = held;
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Adds the forces at a time, s, to a list.
    fn collect(&self, solid: &Solid<D, N>, model: &Model<D, N>, time: f64, applied: &mut Vec<Applied<D>>) {
        for facet in &self.facets {
            let schedule = &model.boundaries[facet.boundary as usize].schedule;
            let factor = if facet.is_held { schedule.factor(time) } else { 1.0 };
            let corners = facet.corners.map(|corner| solid.position_at(corner));
            let now = unit(<[[f64; D]; N]>::axes(&corners)[0]);
            applied.extend((0..D).map(|end| {
                let corner = facet.corners[end];
                let node = solid.node_at(corner) as usize;
                let moved = solid.displacement(node, model);
                let velocity = solid.velocity(node);
                let springs = Self::against(moved, facet.normal, facet.stiffness);
                let dashpots = Self::against(velocity, now, facet.impedance);
                let elastic: Point<D> =
                    std::array::from_fn(|axis| factor * facet.held[end][axis] + facet.area * springs[axis]);
                let viscous = dashpots.map(|traction| facet.area * traction);
                Applied { corner, boundary: facet.boundary, force: plus(elastic, viscous), viscous }
            }));
        }
    }

    /// Traction against a displacement or velocity, with one factor along `normal` and one across it.
    fn against(vector: Point<D>, normal: Point<D>, [along, across]: [f64; 2]) -> Point<D> {
        let axes = <[[f64; D]; N]>::axes_around(normal);
        let mut traction = normal.map(|n| -(along * dot(vector, normal)) * n);
        for axis in &axes[1..] {
            add(&mut traction, *axis, -(across * dot(vector, *axis)));
        }
        traction
    }

    /// Stiffness of the springs on corners of elements, N/m, in the stiffer of the two directions.
    pub(crate) fn springs(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.facets.iter().flat_map(|facet| {
            facet.corners.map(|corner| (corner, facet.area * facet.stiffness[0].max(facet.stiffness[1])))
        })
    }
}

impl<const D: usize, const N: usize> Action<D, N> for Ground<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        if self.is_empty() {
            return;
        }
        let (model, time, solid) = (acting.scene.model, acting.scene.time, acting.solid());
        acting.apply(|applied| self.collect(solid, model, time, applied));
    }

    fn support(&mut self, scene: &Scene<'_, D, N>, others: &dyn Fn(u32) -> Point<D>) {
        let (model, solid) = (scene.model, scene.solid());
        let node_at = |corner: u32| solid.node_at(corner) as usize;
        // Edges at the same node share its force in proportion to their lengths.
        let mut width = vec![0.0; solid.node_count()];
        for facet in &self.facets {
            for corner in facet.corners {
                width[node_at(corner)] += facet.area;
            }
        }
        for facet in self.facets.iter_mut().filter(|facet| !facet.is_held) {
            for end in 0..D {
                let node = node_at(facet.corners[end]);
                let weight = model.gravity_schedule.factor(0.0) * solid.true_mass(node);
                let mut force = model.gravity.map(|g| weight * g);
                for &corner in solid.corners(node) {
                    for part in [solid.initial_force(corner), others(corner)] {
                        add(&mut force, part, 1.0);
                    }
                }
                let share = -facet.area / width[node];
                facet.held[end] = force.map(|f| share * f);
            }
        }
    }
}

/// Whether a load is among the forces of the ground.
pub(crate) fn is_ground<const D: usize>(load: &Load<D>) -> bool {
    matches!(load, Load::Absorbing | Load::Held)
}

/// Half of the longer side of the bounding box of each body, m.
pub(crate) fn radii<const D: usize, const N: usize>(model: &Model<D, N>) -> BTreeMap<u32, f64> {
    let mesh = &model.mesh;
    let mut boxes = BTreeMap::new();
    for (nodes, &body) in mesh.elements.iter().zip(&mesh.bodies) {
        let around = boxes.entry(body).or_insert([[f64::INFINITY; D], [f64::NEG_INFINITY; D]]);
        for node in nodes {
            for axis in 0..D {
                let x = mesh.nodes[*node as usize][axis];
                around[0][axis] = around[0][axis].min(x);
                around[1][axis] = around[1][axis].max(x);
            }
        }
    }
    let half = |[min, max]: [Point<D>; 2]| 0.5 * minus(max, min).into_iter().fold(0.0, f64::max);
    boxes.into_iter().map(|(body, around)| (body, half(around))).collect()
}
