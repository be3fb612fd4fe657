//! External actions: nodes that are held or moved, forces, pressures, absorbing edges.

use std::collections::BTreeMap;

use crate::error::ModelError;
use crate::ground::{Ground, Reaction};
use crate::model::{Load, Model, Schedule, Target};
use crate::outer_side::{OuterSide, outer_side};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::{NONE, Topology};
use crate::vector::{Point, add, dot, plus};

/// Prescribed motion of a node along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hold {
    pub(crate) boundary: u32,
    motion: PrescribedMotion,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PrescribedMotion {
    /// Velocity, m/s.
    Velocity(f64),
    /// Displacement, m.
    Displacement(f64),
}

impl Hold {
    /// Velocity in the step that begins at `time`, of a node that has moved by `displacement` so far.
    #[inline]
    pub(crate) fn velocity(&self, schedules: &[Schedule], time: f64, step: f64, displacement: f64) -> f64 {
        let schedule = &schedules[self.boundary as usize];
        match self.motion {
            PrescribedMotion::Velocity(velocity) => velocity * schedule.factor(time + 0.5 * step),
            PrescribedMotion::Displacement(goal) => {
                (goal * schedule.factor(time + step) - displacement) / step
            }
        }
    }
}

/// The greatest speed that a model gives to nodes, m/s: at the beginning, and by prescribed motions.
pub(crate) fn fastest<const D: usize, const N: usize>(model: &Model<D, N>, step: f64) -> f64 {
    let length = |vector: [f64; D]| dot(vector, vector).sqrt();
    let initial = model.velocities.iter().map(|&velocity| length(velocity));
    let prescribed = model.boundaries.iter().map(|boundary| match boundary.load {
        Load::Velocity(velocity) => {
            length(velocity.map(Option::unwrap_or_default)) * boundary.schedule.most()
        }
        Load::Displacement(goal) => {
            length(goal.map(Option::unwrap_or_default)) * boundary.schedule.steepest(step)
        }
        _ => 0.0,
    });
    initial.chain(prescribed).fold(0.0, f64::max)
}

impl Schedule {
    /// The largest magnitude of the factor.
    fn most(&self) -> f64 {
        match self {
            Self::Constant | Self::Ramp(_) => 1.0,
            Self::Table(rows) => rows.iter().map(|row| row[1].abs()).fold(0.0, f64::max),
            Self::From(_, schedule) => schedule.most(),
        }
    }

    /// The largest magnitude of the change of the factor in time, 1/s. At the beginning it changes from 0 within a step, s.
    fn steepest(&self, step: f64) -> f64 {
        let first = self.factor(0.0).abs() / step;
        match self {
            Self::Constant => first,
            Self::Ramp(duration) => first.max(0.5 * std::f64::consts::PI / duration.max(step)),
            Self::Table(rows) => {
                let slope = |pair: &[[f64; 2]]| ((pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).abs();
                rows.windows(2).map(slope).fold(first, f64::max)
            }
            Self::From(_, schedule) => schedule.steepest(step),
        }
    }

    /// The factor at a time, s.
    pub fn factor(&self, time: f64) -> f64 {
        match self {
            Self::Ramp(duration) if time < *duration => {
                0.5 * (1.0 - libm::cos(std::f64::consts::PI * time.max(0.0) / duration))
            }
            Self::Constant | Self::Ramp(_) => 1.0,
            Self::Table(rows) => {
                let after = rows.partition_point(|row| row[0] <= time);
                match (after.checked_sub(1).map(|k| rows[k]), rows.get(after).copied()) {
                    (Some([t, f]), Some([u, g])) => f + (g - f) * (time - t) / (u - t),
                    (Some([_, f]), None) | (None, Some([_, f])) => f,
                    (None, None) => 0.0,
                }
            }
            Self::From(start, schedule) => schedule.factor((time - start).max(0.0)),
        }
    }
}

/// A force on a corner of an element in this step.
#[derive(Clone, Copy, Debug)]
struct Applied<const D: usize> {
    corner: u32,
    boundary: u32,
    /// All of it.
    force: Point<D>,
    /// The part that dissipates.
    viscous: Point<D>,
}

/// Numbers of the whole model that a rank needs for its part of the loads.
#[derive(Debug)]
pub(crate) struct Wide {
    /// Number of nodes of the mesh on which each boundary acts.
    pub(crate) nodes: Vec<u32>,
    /// Number of corners at each vertex.
    pub(crate) corners: Vec<u32>,
    /// Half of the longer side of the bounding box of each body, m.
    pub(crate) radii: BTreeMap<u32, f64>,
}

/// All external actions on a model.
#[derive(Debug)]
pub(crate) struct Loads<const D: usize = 2, const N: usize = 3> {
    pub(crate) schedules: Vec<Schedule>,
    /// Prescribed motions by axis. Nodes refer to them by their numbers.
    pub(crate) holds: Vec<[Option<Hold>; D]>,
    /// Boundaries with forces on corners.
    forces: Vec<(u32, Point<D>, Vec<u32>)>,
    /// Boundaries on facets.
    sides: Vec<(u32, Load<D>, Vec<OuterSide<D>>)>,
    applied: Vec<Applied<D>>,
    /// Ground beyond absorbing facets.
    pub(crate) ground: Ground<D, N>,
}

impl<const D: usize, const N: usize> Loads<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Checks the boundaries and marks the nodes that they hold. `wide`: what is known of the whole model, if this is a part.
    pub(crate) fn new(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        solid: &mut Solid<D, N>,
        wide: Option<&Wide>,
    ) -> Result<Self, ModelError> {
        let mut loads = Self {
            schedules: model.boundaries.iter().map(|boundary| boundary.schedule.clone()).collect(),
            holds: Vec::new(),
            forces: Vec::new(),
            sides: Vec::new(),
            applied: Vec::new(),
            ground: Ground::new(model, topology, wide.map(|wide| &wide.radii))?,
        };
        for (number, boundary) in model.boundaries.iter().enumerate() {
            let number = number as u32;
            let wrong = |needs| ModelError::Target { boundary: boundary.name.clone(), needs };
            if wide.is_some() && boundary.target.is_empty() {
                continue;
            }
            match (boundary.load, &boundary.target) {
                (Load::Velocity(velocity), target) => {
                    let nodes = target.nodes();
                    loads.hold(
                        model,
                        solid,
                        number,
                        &nodes,
                        velocity.map(|v| v.map(PrescribedMotion::Velocity)),
                    )?;
                }
                (Load::Displacement(goal), target) => {
                    let nodes = target.nodes();
                    loads.hold(
                        model,
                        solid,
                        number,
                        &nodes,
                        goal.map(|u| u.map(PrescribedMotion::Displacement)),
                    )?;
                }
                (Load::Force(force), target) => {
                    let nodes = target.nodes();
                    if nodes.is_empty() {
                        return Err(wrong("nodes"));
                    }
                    // Equal parts for the nodes of the mesh. The corners of a node share its part, because they may separate.
                    let count = wide.map_or(nodes.len(), |wide| wide.nodes[number as usize] as usize);
                    let each = force.map(|f| f / count as f64);
                    for &node in &nodes {
                        let corners = topology.corners_of(node).to_vec();
                        let count = wide.map_or(corners.len(), |wide| wide.corners[node as usize] as usize);
                        let part = each.map(|f| f / count as f64);
                        loads.forces.push((number, part, corners));
                    }
                }
                (Load::Absorbing, Target::Facets(facets)) | (Load::Held, Target::Held(facets, _))
                    if !facets.is_empty() => {}
                (load, Target::Facets(facets)) if !facets.is_empty() => {
                    let sides =
                        facets.iter().map(|&facet| outer_side(model, topology, facet, &boundary.name));
                    loads.sides.push((number, load, sides.collect::<Result<_, _>>()?));
                }
                _ => return Err(wrong(<[[f64; D]; N]>::FACETS_ARE)),
            }
        }
        Ok(loads)
    }

    fn hold(
        &mut self,
        model: &Model<D, N>,
        solid: &mut Solid<D, N>,
        boundary: u32,
        nodes: &[u32],
        motion: [Option<PrescribedMotion>; D],
    ) -> Result<(), ModelError> {
        if nodes.is_empty() {
            let boundary = model.boundaries[boundary as usize].name.clone();
            return Err(ModelError::Target { boundary, needs: "nodes" });
        }
        for &number in nodes {
            let node = &mut solid.constants[number as usize];
            if node.hold == NONE {
                node.hold = self.holds.len() as u32;
                self.holds.push([None; D]);
            }
            let held = &mut self.holds[node.hold as usize];
            for axis in 0..D {
                let Some(motion) = motion[axis] else { continue };
                match held[axis] {
                    None => held[axis] = Some(Hold { boundary, motion }),
                    // At a corner of a body two boundaries may both hold a node still.
                    Some(other) if other.motion == motion && motion == PrescribedMotion::Velocity(0.0) => {}
                    Some(other) => {
                        let name = |k: u32| model.boundaries[k as usize].name.clone();
                        let boundaries = [name(other.boundary), name(boundary)];
                        return Err(ModelError::HeldTwice { node: number, axis, boundaries });
                    }
                }
            }
        }
        Ok(())
    }

    /// Sets the static forces of the ground to what holds the nodes of absorbing facets in equilibrium at the beginning, under initial stress, weight, loads, and `others` on each corner.
    pub(crate) fn support(
        &mut self,
        model: &Model<D, N>,
        solid: &Solid<D, N>,
        others: impl Fn(u32) -> Point<D>,
    ) {
        if self.ground.is_empty() {
            return;
        }
        self.collect(solid, 0.0);
        let mut loads = vec![[0.0; D]; N * solid.elements.len()];
        for Applied { corner, force, .. } in self.applied.drain(..) {
            add(&mut loads[corner as usize], force, 1.0);
        }
        self.ground.support(model, solid, |corner| plus(loads[corner as usize], others(corner)));
    }

    /// Adds all forces to the corners on which they act. `of_caller`: forces of the caller on corners, N, which belong to no boundary.
    pub(crate) fn apply(
        &mut self,
        solid: &mut Solid<D, N>,
        model: &Model<D, N>,
        of_caller: &BTreeMap<u32, Point<D>>,
        time: f64,
    ) {
        self.collect(solid, time);
        self.applied.extend(self.ground.reactions(solid, model, time).map(|reaction| {
            let Reaction { corner, boundary, elastic, viscous } = reaction;
            Applied { corner, boundary, force: plus(elastic, viscous), viscous }
        }));
        let applied = |(&corner, &force)| Applied { corner, boundary: NONE, force, viscous: [0.0; D] };
        self.applied.extend(of_caller.iter().map(applied));
        for &Applied { corner, force, .. } in &self.applied {
            solid.add_force(corner, force);
        }
    }

    /// Collects the forces of loads.
    fn collect(&mut self, solid: &Solid<D, N>, time: f64) {
        self.applied.clear();
        for (boundary, force, corners) in &self.forces {
            let factor = self.schedules[*boundary as usize].factor(time);
            let force = force.map(|f| f * factor);
            let applied = |&corner: &u32| Applied { corner, boundary: *boundary, force, viscous: [0.0; D] };
            self.applied.extend(corners.iter().map(applied));
        }
        for (boundary, load, sides) in &self.sides {
            let factor = self.schedules[*boundary as usize].factor(time);
            for side in sides {
                // Each vertex takes an equal part.
                let part = solid.thickness / D as f64;
                let force = match *load {
                    Load::Traction(traction) => traction.map(|t| t * factor * part * side.measure),
                    Load::Pressure(pressure) => {
                        let now = side.corners.map(|corner| solid.at_corner(corner).position);
                        <[[f64; D]; N]>::facet_normal(&now).map(|n| -(pressure * factor * part * n))
                    }
                    Load::Velocity(_)
                    | Load::Displacement(_)
                    | Load::Force(_)
                    | Load::Absorbing
                    | Load::Held => [0.0; D],
                };
                for corner in side.corners {
                    self.applied.push(Applied { corner, boundary: *boundary, force, viscous: [0.0; D] });
                }
            }
        }
    }

    /// Works of the applied forces in half a step at the nodes' velocities: of loads, and of the dashpots of absorbing facets, one pair for each force.
    pub(crate) fn half_works(&self, solid: &Solid<D, N>, step: f64) -> impl Iterator<Item = [f64; 2]> {
        self.owned(solid).map(move |applied| {
            let velocity = solid.at_corner(applied.corner).velocity;
            let absorbed = 0.5 * step * dot(applied.viscous, velocity);
            [0.5 * step * dot(applied.force, velocity) - absorbed, absorbed]
        })
    }

    /// The forces that were applied in the last step on corners that this rank owns, each with its boundary, or `NONE`, and its corner.
    pub(crate) fn applied(&self, solid: &Solid<D, N>) -> impl Iterator<Item = ([u32; 2], Point<D>)> {
        self.owned(solid).map(|applied| ([applied.boundary, applied.corner], applied.force))
    }

    fn owned(&self, solid: &Solid<D, N>) -> impl Iterator<Item = &Applied<D>> {
        self.applied.iter().filter(|applied| solid.share.corner(applied.corner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedules_at_their_ends_and_between() {
        assert_eq!(Schedule::Constant.factor(3.0), 1.0);
        let ramp = Schedule::Ramp(2.0);
        assert_eq!([0.0, 2.0, 5.0].map(|t| ramp.factor(t)), [0.0, 1.0, 1.0]);
        assert!((ramp.factor(1.0) - 0.5).abs() < 1e-15);
        let table = Schedule::Table(vec![[1.0, 2.0], [3.0, 4.0], [4.0, 0.0]]);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 3.5, 9.0].map(|t| table.factor(t)), [2.0, 2.0, 3.0, 4.0, 2.0, 0.0]);
    }
}
