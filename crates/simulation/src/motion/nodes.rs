//! Motion of nodes.

use crate::actions::prescribed::Hold;
use crate::joints::Joints;
use crate::model::{Model, Schedule};
use crate::motion::{Freedoms, MotionSums, MovedNow, RelaxationSums, Selected, add_works};
use crate::rotation::lifted;
use crate::simplex::Simplex;
use crate::solid::{Constants, Node, Solid};
use crate::sum::{Grains, Pile, Sum};
use crate::team::Team;
use crate::topology::NONE;
use crate::vector::{Point, add, dot, minus, plus};

/// Everything that the motion of the nodes in a step depends on.
pub(crate) struct Motion<'a, const D: usize, const N: usize> {
    pub(crate) model: &'a Model<D, N>,
    /// Prescribed motions, and the factor of each boundary in time.
    pub(crate) holds: &'a [[Option<Hold>; D]],
    pub(crate) schedules: &'a [Schedule],
    /// Acceleration of gravity at the beginning of the step, m/s².
    pub(crate) gravity: Point<D>,
    pub(crate) time: f64,
    pub(crate) step: f64,
    pub(crate) speed_limit: f64,
    /// Grains of the works that are added up.
    pub(crate) grains: Grains,
    /// Whether to compute the kinetic energy.
    pub(crate) energy: bool,
    /// Damping of dynamic relaxation: force on a node over its mass and its velocity, 1/s.
    pub(crate) relaxation: f64,
    /// Sums for that damping.
    pub(crate) taken: RelaxationSums,
}

/// The nodes of a solid, and all that their motion depends on.
struct NodeFreedoms<'a, const D: usize, const N: usize> {
    solid: &'a Solid<D, N>,
    joints: &'a Joints<D>,
    motion: &'a Motion<'a, D, N>,
}

impl<const D: usize, const N: usize> Freedoms<D> for NodeFreedoms<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    type Moving<'m> = (&'m mut Point<D>, &'m mut Point<D>);
    /// Force without the weight, N.
    type Force = Point<D>;

    #[inline]
    fn is_own(&self, node: usize) -> bool {
        self.solid.share().node(node) && !self.solid.rigid.has_node(node)
    }

    #[inline]
    fn force(&self, node: usize) -> Point<D> {
        force_on(node, self.solid, self.joints)
    }

    #[inline]
    fn advance(
        &self,
        number: usize,
        (position, velocity): (&mut Point<D>, &mut Point<D>),
        force: Point<D>,
        sum: &mut MotionSums<Pile, D>,
    ) -> f64 {
        let Self { solid, motion, .. } = self;
        let constants = solid.constants(number);
        let true_mass = solid.true_mass(number);
        let weight = motion.gravity.map(|acceleration| true_mass * acceleration);
        if motion.energy {
            let free = if constants.hold == NONE { plus(force, weight) } else { [0.0; D] };
            let corners = solid.corners(number).iter();
            sum.note_forces(free, corners.map(|&corner| solid.force(corner)));
        }
        let before = *position;
        let node = Node { position: before, velocity: *velocity };
        let (node, reaction, squared) =
            move_node(node, constants, [force, weight], solid.origin, motion, sum);
        (*position, *velocity) = (node.position, node.velocity);
        if constants.hold != NONE {
            sum.held.push((number as u32, reaction));
            // A rotation holds a node along all axes.
            if let Some(hold) = motion.holds[constants.hold as usize][0] {
                sum.moments.extend(hold.moment(lifted(plus(before, solid.origin)), lifted(reaction)));
            }
        }
        squared
    }

    fn element(&self, node: usize) -> u32 {
        self.solid.corners(node)[0] / N as u32
    }
}

/// Gathers the forces on each node that is selected, moves it, and adds to the sums over all nodes.
pub(crate) fn advance<const D: usize, const N: usize>(
    solid: &mut Solid<D, N>,
    joints: &Joints<D>,
    motion: &Motion<'_, D, N>,
    team: &Team,
    selected: Selected<'_>,
    all: &mut MotionSums<Sum, D>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    match selected {
        Selected::Only([]) => {}
        Selected::Except([]) => advance_where(solid, joints, motion, team, |_| true, all),
        Selected::Only(list) => advance_where(solid, joints, motion, team, |node| list[node], all),
        Selected::Except(list) => advance_where(solid, joints, motion, team, |node| !list[node], all),
    }
}

/// [`advance`] for the nodes that `moves` selects by their numbers.
fn advance_where<const D: usize, const N: usize>(
    solid: &mut Solid<D, N>,
    joints: &Joints<D>,
    motion: &Motion<'_, D, N>,
    team: &Team,
    moves: impl Fn(usize) -> bool + Sync,
    all: &mut MotionSums<Sum, D>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let now = MovedNow { moves, speed_limit: motion.speed_limit };
    let found = solid.with_motion(|solid, positions, velocities| {
        let nodes = NodeFreedoms { solid, joints, motion };
        team.change_both(positions, velocities, |first, positions, velocities| {
            now.advance_chunk(&nodes, first, positions.iter_mut().zip(velocities))
        })
    });
    all.add_chunks(found);
}

/// Force on a node, without its weight, N: the sum over its corners in their order, for each the force of its
/// element with its contacts, and of its joints. Twin: `move_node` in `crates/gpu/kernels/step.h`.
#[inline]
pub(crate) fn force_on<const D: usize, const N: usize>(
    node: usize,
    solid: &Solid<D, N>,
    joints: &Joints<D>,
) -> Point<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut force = [0.0; D];
    let joined = joints.at_vertex[solid.vertex(node) as usize];
    for &corner in solid.corners(node) {
        add(&mut force, solid.force(corner), 1.0);
        if joined {
            joints.add_force(corner, &mut force);
        }
    }
    force
}

/// Moves a node under the force on it without its weight, and its weight, N. Returns the node at the end of
/// the step, the reaction of its supports, and the square of its speed. Twin: `move_node` in
/// `crates/gpu/kernels/step.h`.
#[inline]
fn move_node<const D: usize, const N: usize>(
    node: Node<D>,
    constants: &Constants,
    [force, weight]: [Point<D>; 2],
    origin: Point<D>,
    motion: &Motion<'_, D, N>,
    sum: &mut MotionSums<Pile, D>,
) -> (Node<D>, Point<D>, f64) {
    let (mass, step) = (constants.mass, motion.step);
    let Node { position, velocity: before } = node;
    let force = plus(force, weight);
    let over = step / mass;
    let (damped, after, reactions) = if constants.hold == NONE {
        let damped = damping(motion, mass, force, before);
        (damped, accelerated(before, over, minus(force, damped)), [0.0; D])
    } else {
        hold_node(&node, constants, force, origin, motion)
    };
    let position = std::array::from_fn(|axis| position[axis] + step * after[axis]);
    if motion.energy {
        sum.kinetic.add(0.5 * mass * dot(before, after), motion.grains);
    }
    // Forces that do work, besides those of elements, joints and contacts.
    add_works(&mut sum.external, plus(weight, reactions), [before, after], step, motion.grains);
    add_works(&mut sum.damping, damped, [before, after], step, motion.grains);
    if motion.taken != RelaxationSums::Nothing {
        take(motion, constants, force, [before, after], sum);
    }
    (Node { position, velocity: after }, reactions, dot(after, after))
}

/// Adds the terms of a node along its free axes to the sums for the damping of dynamic relaxation.
#[cold]
#[inline(never)]
fn take<const D: usize, const N: usize>(
    motion: &Motion<'_, D, N>,
    constants: &Constants,
    force: Point<D>,
    [before, after]: [Point<D>; 2],
    sum: &mut MotionSums<Pile, D>,
) {
    for axis in 0..D {
        if constants.hold != NONE && motion.holds[constants.hold as usize][axis].is_some() {
            continue;
        }
        let (velocities, momentum) = ([before[axis], after[axis]], constants.mass * before[axis]);
        sum.take(motion.taken, motion.step * force[axis], velocities, momentum, motion.grains);
    }
}

/// The force of local damping, and of dynamic relaxation, against a motion.
#[inline]
pub(super) fn damping<const D: usize, const N: usize>(
    motion: &Motion<'_, D, N>,
    mass: f64,
    force: Point<D>,
    before: Point<D>,
) -> Point<D> {
    let local = local_damping(motion.model.time.local_damping, force, before);
    relaxed(motion, mass, force, before, local)
}

/// The force of dynamic relaxation, with that of `local` damping. For a rotation, force and velocity are
/// moment and angular momentum, and the mass is 1.
#[inline]
pub(super) fn relaxed<const K: usize, const D: usize, const N: usize>(
    motion: &Motion<'_, D, N>,
    mass: f64,
    force: [f64; K],
    before: [f64; K],
    local: [f64; K],
) -> [f64; K] {
    if motion.relaxation == 0.0 {
        return local;
    }
    // It acts with the mean of the velocities before and after the step, so that any damping is stable.
    let half = 0.5 * motion.relaxation * motion.step;
    std::array::from_fn(|axis| {
        let speed = before[axis] + 0.5 * motion.step / mass * (force[axis] - local[axis]);
        local[axis] + motion.relaxation * mass * speed / (1.0 + half)
    })
}

/// Velocity after a step. `over`: step over mass, s/kg.
#[inline]
fn accelerated<const D: usize>(before: Point<D>, over: f64, force: Point<D>) -> Point<D> {
    std::array::from_fn(|axis| before[axis] + over * force[axis])
}

/// The force of local damping against a motion.
#[inline]
pub(super) fn local_damping<const D: usize>(damping: f64, force: Point<D>, velocity: Point<D>) -> Point<D> {
    if damping == 0.0 {
        return [0.0; D];
    }
    let against = |force: f64, v: f64| if v == 0.0 { 0.0 } else { damping * force.abs() * v.signum() };
    std::array::from_fn(|axis| against(force[axis], velocity[axis]))
}

/// The force of local damping on a node that is held, its velocity after the step, and the reaction of its
/// supports. Apart from the others, which are most: where axes are counted one by one, vectors stay in
/// memory.
#[cold]
#[inline(never)]
fn hold_node<const D: usize, const N: usize>(
    node: &Node<D>,
    constants: &Constants,
    force: Point<D>,
    origin: Point<D>,
    motion: &Motion<'_, D, N>,
) -> (Point<D>, Point<D>, Point<D>) {
    let (mass, step) = (constants.mass, motion.step);
    let before = node.velocity;
    let mut damped = damping(motion, mass, force, before);
    let mut after = accelerated(before, step / mass, minus(force, damped));
    let mut reactions = [0.0; D];
    let held = motion.holds[constants.hold as usize];
    let place = lifted(plus(node.position, origin));
    for axis in 0..D {
        let Some(hold) = held[axis] else { continue };
        let start = motion.model.mesh.nodes[constants.vertex as usize][axis] - origin[axis];
        let moved = node.position[axis] - start;
        after[axis] = hold.velocity(axis, motion.schedules, [motion.time, step], moved, place);
        damped[axis] = 0.0;
        reactions[axis] = mass * (after[axis] - before[axis]) / step - force[axis];
    }
    (damped, after, reactions)
}
