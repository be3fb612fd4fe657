//! Prescribed motions of nodes, by velocities or displacements of boundaries. They are no forces: the motion
//! of the nodes finds the reactions.

use crate::accelerator::{Drive, HeldNode, HoldKind};
use crate::error::ModelError;
use crate::model::{Boundary, Load, Model, Schedule};
use crate::rotation::{UNTURNED, lifted, matrix_of, turned};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::NONE;
use crate::vector::{Matrix, Point, applied, cross3, dot, length, minus};

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
    /// Angular velocity, rad/s, about an axis through a point, m.
    Rotation { spin: Point<3>, through: Point<3> },
}

impl Hold {
    /// Velocity along an axis in the step that begins at `time`, m/s, of a node at a place that has moved by
    /// `displacement` along the axis so far, m. Twin: `held_velocity` in `crates/gpu/kernels/step.h`.
    pub(crate) fn velocity(
        &self,
        axis: usize,
        schedules: &[Schedule],
        [time, step]: [f64; 2],
        displacement: f64,
        place: Point<3>,
    ) -> f64 {
        let schedule = &schedules[self.boundary as usize];
        match self.motion {
            PrescribedMotion::Velocity(velocity) => velocity * schedule.factor(time + 0.5 * step),
            PrescribedMotion::Displacement(goal) => {
                (goal * schedule.factor(time + step) - displacement) / step
            }
            PrescribedMotion::Rotation { spin, through } => {
                let turn = turn_by(spin, step * schedule.factor(time + 0.5 * step));
                let arm = minus(place, through);
                (applied(&turn, arm)[axis] - arm[axis]) / step
            }
        }
    }

    /// Angular velocity in the middle of the step that begins at `time`, rad/s, of a rotation.
    pub(crate) fn spin(&self, schedules: &[Schedule], [time, step]: [f64; 2]) -> Option<Point<3>> {
        let PrescribedMotion::Rotation { spin, .. } = self.motion else { return None };
        let factor = schedules[self.boundary as usize].factor(time + 0.5 * step);
        Some(spin.map(|x| factor * x))
    }

    /// The moment of a force, N, at a place, m, about the point through which the axis of a rotation passes,
    /// N m, with the number of its boundary. `None` if the motion is no rotation.
    pub(crate) fn moment(&self, place: Point<3>, force: Point<3>) -> Option<(u32, Point<3>)> {
        let PrescribedMotion::Rotation { through, .. } = self.motion else { return None };
        Some((self.boundary, cross3(minus(place, through), force)))
    }

    pub(crate) fn is_rotation(&self) -> bool {
        matches!(self.motion, PrescribedMotion::Rotation { .. })
    }
}

/// The greatest speed that a model gives to nodes, m/s: at the beginning, and by prescribed motions.
pub(crate) fn fastest<const D: usize, const N: usize>(model: &Model<D, N>, step: f64) -> f64 {
    let initial = model.velocities.iter().map(|&velocity| length_of(velocity));
    let prescribed = model.boundaries.iter().map(|boundary| match boundary.load {
        Load::Displacement(goal) => {
            length_of(goal.map(Option::unwrap_or_default)) * boundary.schedule.steepest(step)
        }
        _ => boundary.greatest_speed(&model.mesh.nodes, f64::INFINITY),
    });
    initial.chain(prescribed).fold(0.0, f64::max)
}

fn length_of<const D: usize>(vector: [f64; D]) -> f64 {
    dot(vector, vector).sqrt()
}

impl<const D: usize> Boundary<D> {
    /// The greatest speed that its velocity, its rotation or the ramp or table of its displacement gives to a
    /// node before a time `end`, s, in m/s; 0 for other loads. `nodes`: those of the mesh, m.
    pub fn greatest_speed(&self, nodes: &[[f64; D]], end: f64) -> f64 {
        let full = match self.load {
            Load::Velocity(velocity) => length_of(velocity.map(Option::unwrap_or_default)),
            Load::Rotation { spin, through } => {
                let speed = |node: u32| length(cross3(spin, lifted(minus(nodes[node as usize], through))));
                self.target.nodes().into_iter().map(speed).fold(0.0, f64::max)
            }
            Load::Displacement(goal) => {
                return length_of(goal.map(Option::unwrap_or_default)) * self.schedule.slope(end);
            }
            _ => return 0.0,
        };
        full * self.schedule.most(end)
    }
}

impl Schedule {
    /// The largest magnitude of the factor from the beginning to a time `end`, s.
    fn most(&self, end: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Ramp(_) => self.factor(end),
            Self::Table(rows) => {
                let ends = self.factor(0.0).abs().max(self.factor(end).abs());
                let inside = rows.iter().filter(|row| (0.0..end).contains(&row[0]));
                inside.map(|row| row[1].abs()).fold(ends, f64::max)
            }
            Self::From(start, schedule) => schedule.most((end - start).max(0.0)),
        }
    }

    /// The largest magnitude of the change of the factor in time after the beginning and before a time `end`,
    /// s, in 1/s.
    fn slope(&self, end: f64) -> f64 {
        match self {
            Self::Constant => 0.0,
            Self::Ramp(duration) => 0.5 * std::f64::consts::PI / duration,
            Self::Table(rows) => {
                let slope = |pair: &[[f64; 2]]| ((pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).abs();
                rows.windows(2).filter(|pair| pair[0][0] < end).map(slope).fold(0.0, f64::max)
            }
            Self::From(start, schedule) => schedule.slope((end - start).max(0.0)),
        }
    }

    /// The largest magnitude of the change of the factor in time, 1/s. At the beginning it changes from 0
    /// within a step, s.
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

/// The motion of each boundary in the step that begins at `time`, for devices.
pub(crate) fn drives<const D: usize, const N: usize>(
    model: &Model<D, N>,
    schedules: &[Schedule],
    [time, step]: [f64; 2],
) -> Vec<Drive> {
    let of = |(boundary, schedule): (&Boundary<D>, &Schedule)| {
        let factors = [schedule.factor(time + 0.5 * step), schedule.factor(time + step)];
        let (turn, through) = match rotation_of(boundary.load) {
            Some((spin, through)) => (turn_by(spin, step * factors[0]), through),
            None => ([[0.0; 3]; 3], [0.0; 3]),
        };
        Drive { factors, turn, through }
    };
    model.boundaries.iter().zip(schedules).map(of).collect()
}

/// Angular velocity of a rotation, rad/s, and a point of its axis, m.
fn rotation_of<const D: usize>(load: Load<D>) -> Option<(Point<3>, Point<3>)> {
    let Load::Rotation { spin, through } = load else { return None };
    // In the plane only the third component counts.
    let first = 3 - D * (D - 1) / 2;
    Some((std::array::from_fn(|axis| if axis < first { 0.0 } else { spin[axis] }), lifted(through)))
}

/// The rotation by an angle times a vector.
fn turn_by(spin: Point<3>, angle: f64) -> Matrix<3> {
    matrix_of(turned(UNTURNED, spin.map(|x| angle * x)))
}

/// All prescribed motions of a model.
#[derive(Debug, Default)]
pub(crate) struct Prescribed<const D: usize> {
    /// Motions by axis. Nodes refer to them by their numbers.
    pub(crate) holds: Vec<[Option<Hold>; D]>,
}

impl<const D: usize> Prescribed<D> {
    /// The motions for devices, by their numbers. `solid`: the nodes, at any time.
    pub(crate) fn on_device<const N: usize>(
        &self,
        model: &Model<D, N>,
        solid: &Solid<D, N>,
    ) -> Vec<HeldNode<D>> {
        let free = HeldNode {
            node: NONE,
            kinds: [HoldKind::Free; D],
            boundaries: [NONE; D],
            values: [0.0; D],
            start: [0.0; D],
        };
        let mut all = vec![free; self.holds.len()];
        for (held, holds) in all.iter_mut().zip(&self.holds) {
            for (axis, hold) in holds.iter().enumerate() {
                let Some(Hold { boundary, motion }) = *hold else { continue };
                held.boundaries[axis] = boundary;
                (held.kinds[axis], held.values[axis]) = match motion {
                    PrescribedMotion::Velocity(velocity) => (HoldKind::Velocity, velocity),
                    PrescribedMotion::Displacement(goal) => (HoldKind::Displacement, goal),
                    PrescribedMotion::Rotation { .. } => (HoldKind::Rotation, 0.0),
                };
            }
        }
        // All nodes of a vertex have its hold.
        for node in 0..solid.node_count() {
            if let Some(held) = all.get_mut(solid.hold(node) as usize) {
                held.start = minus(model.mesh.nodes[solid.vertex(node) as usize], solid.origin);
            }
        }
        all
    }

    /// Marks the nodes of a boundary that prescribes their motion. Returns `false` for another boundary.
    pub(crate) fn prescribe<const N: usize>(
        &mut self,
        boundary: u32,
        model: &Model<D, N>,
        solid: &mut Solid<D, N>,
    ) -> Result<bool, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let of_model = &model.boundaries[boundary as usize];
        let motion = match of_model.load {
            Load::Velocity(velocity) => velocity.map(|v| v.map(PrescribedMotion::Velocity)),
            Load::Displacement(goal) => goal.map(|u| u.map(PrescribedMotion::Displacement)),
            load => match rotation_of(load) {
                Some((spin, through)) => [Some(PrescribedMotion::Rotation { spin, through }); D],
                None => return Ok(false),
            },
        };
        self.hold(model, solid, boundary, &of_model.target.nodes(), motion)?;
        Ok(true)
    }

    fn hold<const N: usize>(
        &mut self,
        model: &Model<D, N>,
        solid: &mut Solid<D, N>,
        boundary: u32,
        nodes: &[u32],
        motion: [Option<PrescribedMotion>; D],
    ) -> Result<(), ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if nodes.is_empty() {
            let boundary = model.boundaries[boundary as usize].name.clone();
            return Err(ModelError::Target { boundary, needs: "nodes" });
        }
        for &number in nodes {
            if solid.hold(number as usize) == NONE {
                solid.set_hold(number as usize, self.holds.len() as u32);
                self.holds.push([None; D]);
            }
            let held = &mut self.holds[solid.hold(number as usize) as usize];
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
        assert_eq!([0.0, 2.0, 3.5, f64::INFINITY].map(|end| table.most(end)), [2.0, 3.0, 4.0, 4.0]);
        assert_eq!([1.0, f64::INFINITY].map(|end| ramp.most(end)), [ramp.factor(1.0), 1.0]);
    }
}
