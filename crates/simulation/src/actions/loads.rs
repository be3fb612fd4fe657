//! Loads of boundaries: forces on nodes, tractions and pressures on facets.

use crate::action::{Acting, Action, Applied, Scene, Wide, on_corners};
use crate::error::ModelError;
use crate::model::{Load, Model, Schedule, Target};
use crate::outer_side::{OuterSide, outer_side};
use crate::simplex::Simplex;
use crate::topology::Topology;
use crate::vector::Point;

/// All loads of a model.
#[derive(Debug, Default)]
pub(crate) struct Loads<const D: usize = 2, const N: usize = 3> {
    /// Boundaries with forces on corners.
    forces: Vec<(u32, Point<D>, Vec<u32>)>,
    /// Boundaries on facets.
    sides: Vec<(u32, Load<D>, Vec<OuterSide<D>>)>,
}

impl<const D: usize, const N: usize> Loads<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Adds the load of a boundary. `wide`: numbers of the whole model, if this is a part.
    pub(crate) fn load(
        &mut self,
        number: u32,
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        wide: Option<&Wide>,
    ) -> Result<(), ModelError> {
        let boundary = &model.boundaries[number as usize];
        let wrong = |needs| ModelError::Target { boundary: boundary.name.clone(), needs };
        match (boundary.load, &boundary.target) {
            (Load::Force(force), target) => {
                let nodes = target.nodes();
                if nodes.is_empty() {
                    return Err(wrong("nodes"));
                }
                // Equal parts for the nodes of the mesh. The corners of a node share its part, because they
                // may separate.
                let count = wide.map_or(nodes.len(), |wide| wide.nodes[number as usize] as usize);
                let each = force.map(|f| f / count as f64);
                for &node in &nodes {
                    let corners = topology.corners_of(node).to_vec();
                    let count = wide.map_or(corners.len(), |wide| wide.corners[node as usize] as usize);
                    let part = each.map(|f| f / count as f64);
                    self.forces.push((number, part, corners));
                }
            }
            (Load::Absorbing, Target::Facets(facets)) | (Load::Held, Target::Held(facets, _))
                if !facets.is_empty() => {}
            (load @ (Load::Traction(_) | Load::Pressure(_)), Target::Facets(facets))
                if !facets.is_empty() =>
            {
                let sides = facets.iter().map(|&facet| outer_side(model, topology, facet, &boundary.name));
                self.sides.push((number, load, sides.collect::<Result<_, _>>()?));
            }
            _ => return Err(wrong(<[[f64; D]; N]>::FACETS_ARE)),
        }
        Ok(())
    }

    /// Adds the forces at a time, s, to a list.
    fn collect(
        &self,
        scene: &Scene<'_, D, N>,
        schedules: &[Schedule],
        time: f64,
        applied: &mut Vec<Applied<D>>,
    ) {
        for (boundary, force, corners) in &self.forces {
            let factor = schedules[*boundary as usize].factor(time);
            let force = force.map(|f| f * factor);
            let on = |&corner: &u32| Applied { corner, boundary: *boundary, force, viscous: [0.0; D] };
            applied.extend(corners.iter().map(on));
        }
        for (boundary, load, sides) in &self.sides {
            let factor = schedules[*boundary as usize].factor(time);
            // Each vertex takes an equal part.
            let part = scene.model.thickness / D as f64;
            let mut push = |side: &OuterSide<D>, force: Point<D>| {
                let on = |corner: u32| Applied { corner, boundary: *boundary, force, viscous: [0.0; D] };
                applied.extend(side.corners.map(on));
            };
            match *load {
                Load::Traction(traction) => {
                    for side in sides {
                        push(side, traction.map(|t| t * factor * part * side.measure));
                    }
                }
                Load::Pressure(pressure) => {
                    let corners: Vec<u32> = sides.iter().flat_map(|side| side.corners).collect();
                    let mut places = Vec::with_capacity(corners.len());
                    scene.machine.read_corners(&corners, &mut |node| places.push(node.position));
                    for (side, now) in sides.iter().zip(places.as_chunks::<D>().0) {
                        let normal = <[[f64; D]; N]>::facet_normal(now);
                        push(side, normal.map(|n| -(pressure * factor * part * n)));
                    }
                }
                _ => {}
            }
        }
    }
}

impl<const D: usize, const N: usize> Action<D, N> for Loads<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        if self.forces.is_empty() && self.sides.is_empty() {
            return;
        }
        let (schedules, scene) = (acting.schedules, acting.scene);
        acting.apply(|applied| self.collect(&scene, schedules, scene.time, applied));
    }

    fn initial_forces(&self, scene: &Scene<'_, D, N>, schedules: &[Schedule]) -> Vec<Point<D>> {
        let mut applied = Vec::new();
        self.collect(scene, schedules, 0.0, &mut applied);
        let forces = applied.into_iter().map(|Applied { corner, force, .. }| (corner, force));
        on_corners(N * scene.solid().element_count(), forces)
    }
}
