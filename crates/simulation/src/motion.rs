//! Motion of the nodes: central differences (book, (5.12)-(5.13)).
//!
//! Velocities stand half a step before positions. With `v₋` before and `v₊` after a step, `m v₋·v₊ / 2` is the kinetic energy at the positions between them: with it, the sum of
//! kinetic and strain energy of a linear system is constant to rounding, and the work of a force in the step is `F·(v₋ + v₊) h / 2`.

use crate::contacts::Contacts;
use crate::joints::Joints;
use crate::loads::Loads;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::solid::{Constants, Node, Solid};
use crate::team::Team;
use crate::topology::{NONE, Nodes};
use crate::vector::{Point, add, dot};

/// Everything that the motion of the nodes in a step depends on.
pub(crate) struct Motion<'a, const D: usize, const N: usize> {
    pub(crate) model: &'a Model<D, N>,
    pub(crate) joints: &'a Joints<D>,
    pub(crate) contacts: &'a Contacts<D, N>,
    pub(crate) loads: &'a Loads<D, N>,
    /// Acceleration of gravity at the beginning of the step, m/s².
    pub(crate) gravity: Point<D>,
    pub(crate) time: f64,
    pub(crate) step: f64,
    pub(crate) speed_limit: f64,
}

/// Sums over the motion of all nodes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Moved<const D: usize> {
    pub(crate) kinetic: f64,
    /// Work of gravity and of prescribed motions, up to the positions at the beginning of the step and after them.
    pub(crate) external: [f64; 2],
    /// Energy dissipated by local damping, likewise.
    pub(crate) damping: [f64; 2],
    /// Force of each boundary on the nodes that it holds.
    pub(crate) reactions: Vec<Point<D>>,
    /// Force on each node that a boundary moves.
    pub(crate) held: Vec<(u32, Point<D>)>,
    /// Speed of the fastest node, m/s.
    pub(crate) fastest: f64,
    /// The first node that is too fast, and its speed, m/s.
    pub(crate) runaway: Option<(u32, f64)>,
}

/// Gathers the forces on each node, and moves it.
pub(crate) fn advance<const D: usize, const N: usize>(
    solid: &mut Solid<D, N>,
    motion: &Motion<'_, D, N>,
    team: &Team,
) -> Moved<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Solid { nodes, constants, forces, corners, origin, .. } = solid;
    let origin = *origin;
    let limit = motion.speed_limit * motion.speed_limit;
    let found = team.change(nodes, |first, chunk| {
        let mut sum = Moved::default();
        for (k, node) in chunk.iter_mut().enumerate() {
            let constants = &constants[first + k];
            let force = gather(first + k, constants, forces, corners, motion);
            let reaction = move_node(node, constants, force, origin, motion, &mut sum);
            if constants.hold != NONE {
                sum.held.push(((first + k) as u32, reaction));
            }
            let squared = dot(node.velocity, node.velocity);
            sum.fastest = sum.fastest.max(squared);
            if (squared > limit || squared.is_nan()) && sum.runaway.is_none() {
                sum.runaway = Some(((first + k) as u32, squared.sqrt()));
            }
        }
        sum
    });
    let mut all = Moved { reactions: vec![[0.0; D]; motion.model.boundaries.len()], ..Moved::default() };
    for chunk in found {
        all.kinetic += chunk.kinetic;
        all.fastest = all.fastest.max(chunk.fastest.sqrt());
        for half in 0..2 {
            all.external[half] += chunk.external[half];
            all.damping[half] += chunk.damping[half];
        }
        for (total, reaction) in all.reactions.iter_mut().zip(&chunk.reactions) {
            add(total, *reaction, 1.0);
        }
        all.held.extend(chunk.held);
        all.runaway = all.runaway.or(chunk.runaway);
    }
    all
}

/// Force on a node: the sum over its corners in their order, for each that of its element, its joints and its contacts.
#[inline]
fn gather<const D: usize, const N: usize>(
    number: usize,
    constants: &Constants,
    forces: &[[Point<D>; N]],
    corners: &Nodes<N>,
    motion: &Motion<'_, D, N>,
) -> Point<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut force = [0.0; D];
    let joined = motion.joints.at_vertex[constants.vertex as usize];
    for &corner in corners.of(number) {
        add(&mut force, forces[corner as usize / N][corner as usize % N], 1.0);
        if joined {
            motion.joints.add_force(corner, &mut force);
        }
        motion.contacts.add_force(corner, &mut force);
    }
    force
}

/// Moves a node, and returns the force of what holds it.
#[inline]
fn move_node<const D: usize, const N: usize>(
    node: &mut Node<D>,
    constants: &Constants,
    mut force: Point<D>,
    origin: Point<D>,
    motion: &Motion<'_, D, N>,
    sum: &mut Moved<D>,
) -> Point<D> {
    let mut reactions = [0.0; D];
    let mass = constants.mass;
    let step = motion.step;
    let over = step / mass;
    let before = node.velocity;
    let weight: Point<D> = motion.gravity.map(|acceleration| mass * acceleration);
    let held = motion.loads.holds.get(constants.hold as usize);
    let damping = motion.model.time.local_damping;
    let mut external = weight;
    let mut damped = [0.0; D];
    for axis in 0..D {
        force[axis] += weight[axis];
        let hold = held.and_then(|held| held[axis]);
        let after = if let Some(hold) = hold {
            let start = motion.model.mesh.nodes[constants.vertex as usize][axis] - origin[axis];
            let moved = node.position[axis] - start;
            let after = hold.velocity(&motion.loads.schedules, motion.time, step, moved);
            let reaction = mass * (after - before[axis]) / step - force[axis];
            external[axis] += reaction;
            reactions[axis] = reaction;
            if sum.reactions.is_empty() {
                sum.reactions = vec![[0.0; D]; motion.model.boundaries.len()];
            }
            sum.reactions[hold.boundary as usize][axis] += reaction;
            after
        } else {
            if damping != 0.0 && before[axis] != 0.0 {
                damped[axis] = damping * force[axis].abs() * before[axis].signum();
            }
            before[axis] + over * (force[axis] - damped[axis])
        };
        node.velocity[axis] = after;
        node.position[axis] += step * after;
    }
    sum.kinetic += 0.5 * mass * dot(before, node.velocity);
    for (half, velocity) in [before, node.velocity].into_iter().enumerate() {
        // Most nodes have no force that does work but those of elements, joints and contacts.
        if external != [0.0; D] {
            sum.external[half] += 0.5 * step * dot(external, velocity);
        }
        if damping != 0.0 {
            sum.damping[half] += 0.5 * step * dot(damped, velocity);
        }
    }
    reactions
}
