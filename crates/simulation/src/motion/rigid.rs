//! Motion of rigid bodies: central differences for the centre of mass and for the angular momentum, and a
//! rotation by the angular velocity in the middle of a step.
//!
//! With the angular momentum `L` after a step, the angular velocity at its middle is `ω = I⁻¹(q) L`, with the
//! orientation `q` in the middle, which depends on `ω`: a fixed point, found by iteration. The orientation
//! then turns by `h ω`. Backwards in time the step is the same, so that the energy of a free body does not
//! drift; its angular momentum is kept exactly.

use crate::motion::nodes::{Motion, damping, local_damping, relaxed};
use crate::motion::{Freedoms, MotionSums, MovedNow, add_works};
use crate::rigid::{RigidBody, RigidMotion};
use crate::rotation::{lifted, matrix_of, turned};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::{Pile, Sum};
use crate::team::Team;
use crate::vector::{Point, add, cross3, dot, length, minus, plus};

/// Most iterations for the orientation in the middle of a step. Each multiplies the error by about the angle
/// of a step.
const ITERATIONS: usize = 30;

/// The rigid bodies of a solid, and all that their motion depends on.
struct RigidFreedoms<'a, const D: usize, const N: usize> {
    solid: &'a Solid<D, N>,
    motion: &'a Motion<'a, D, N>,
}

/// Moves all rigid bodies of this rank, and their nodes.
pub(crate) fn advance<const D: usize, const N: usize>(
    solid: &mut Solid<D, N>,
    motion: &Motion<'_, D, N>,
    team: &Team,
    all: &mut MotionSums<Sum, D>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    if solid.rigid.is_empty() {
        return;
    }
    let mut motions = std::mem::take(&mut solid.rigid.motions);
    let freedoms = RigidFreedoms { solid: &*solid, motion };
    let now = MovedNow { moves: |_| true, speed_limit: motion.speed_limit };
    let found = team.change_lanes::<1, _, _>(&mut motions, |first, motions| {
        now.advance_chunk(&freedoms, first, motions.iter_mut())
    });
    solid.rigid.motions = motions;
    all.add_chunks(found);
    solid.place_rigid_nodes(motion.model, motion.step, team);
}

/// Force and moment on a rigid body, without its weight.
struct RigidForce<const D: usize> {
    /// N.
    force: Point<D>,
    /// About `pivot`, N m.
    moment: Point<3>,
    /// A point of the body relative to [`Solid::origin`], m.
    pivot: Point<D>,
}

impl<const D: usize, const N: usize> RigidFreedoms<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The corners of a body, with the forces on them, N.
    fn corner_forces(&self, body: &RigidBody<D>) -> impl Iterator<Item = (u32, Point<D>)> {
        let corners = |&element: &u32| (0..N as u32).map(move |k| element * N as u32 + k);
        let solid = self.solid;
        body.elements.iter().flat_map(corners).map(move |corner| (corner, solid.force(corner)))
    }

    /// The rotation that is prescribed for a body: its boundary, and the angular velocity in the middle of
    /// this step, rad/s.
    fn turning_of(&self, body: &RigidBody<D>) -> Option<(u32, Point<3>)> {
        let [number, _] = body.holds[0]?;
        let Motion { holds, schedules, time, step, .. } = self.motion;
        let hold = holds[number as usize][0]?;
        Some((hold.boundary, hold.spin(schedules, [*time, *step])?))
    }

    /// Moves the centre of mass under a force without the weight, N. Returns its speed, m/s.
    fn move_centre(
        &self,
        body: &RigidBody<D>,
        moving: &mut RigidMotion<D>,
        force: Point<D>,
        sum: &mut MotionSums<Pile, D>,
    ) -> f64 {
        let Self { solid, motion, .. } = self;
        let (mass, step, before) = (body.mass, motion.step, moving.velocity);
        let weight = motion.gravity.map(|acceleration| mass * acceleration);
        let force = plus(force, weight);
        if motion.energy {
            let free = if body.is_held() { [0.0; D] } else { force };
            sum.note_forces(free, self.corner_forces(body).map(|(_, force)| force));
        }
        let mut damped = damping(motion, mass, force, before);
        let mut after = std::array::from_fn(|axis| before[axis] + step / mass * (force[axis] - damped[axis]));
        let mut reactions = [0.0; D];
        let place = lifted(plus(moving.centre, solid.origin));
        for axis in 0..D {
            let Some([number, corner]) = body.holds[axis] else { continue };
            let Some(hold) = motion.holds[number as usize][axis] else { continue };
            let moved = body.displacement(moving, axis);
            after[axis] = hold.velocity(axis, motion.schedules, [motion.time, step], moved, place);
            damped[axis] = 0.0;
            reactions[axis] = mass * (after[axis] - before[axis]) / step - force[axis];
            let mut reaction = [0.0; D];
            reaction[axis] = reactions[axis];
            sum.held.push((solid.node_at(corner), reaction));
        }
        // A rotation holds the centre along all axes.
        let turning = body.holds[0].and_then(|[number, _]| motion.holds[number as usize][0]);
        sum.moments.extend(turning.and_then(|hold| hold.moment(place, lifted(reactions))));
        add(&mut moving.centre, after, step);
        moving.velocity = after;
        if motion.energy {
            sum.kinetic.add(0.5 * mass * dot(before, after), motion.grains);
        }
        add_works(&mut sum.external, plus(weight, reactions), [before, after], step, motion.grains);
        add_works(&mut sum.damping, damped, [before, after], step, motion.grains);
        for axis in (0..D).filter(|&axis| body.holds[axis].is_none()) {
            let (velocities, momentum) = ([before[axis], after[axis]], mass * before[axis]);
            sum.take(motion.taken, motion.step * force[axis], velocities, momentum, motion.grains);
        }
        length(after)
    }
}

impl<const D: usize, const N: usize> Freedoms<D> for RigidFreedoms<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    type Moving<'m> = &'m mut RigidMotion<D>;
    type Force = RigidForce<D>;

    fn is_own(&self, body: usize) -> bool {
        self.solid.moves_rigid(body)
    }

    fn force(&self, body: usize) -> RigidForce<D> {
        let body = &self.solid.rigid.all[body];
        let pivot = self.solid.position_at(body.elements[0] * N as u32);
        let (mut force, mut moment) = ([0.0; D], [0.0; 3]);
        for (corner, on_corner) in self.corner_forces(body).filter(|(_, force)| *force != [0.0; D]) {
            let arm = minus(self.solid.position_at(corner), pivot);
            add(&mut force, on_corner, 1.0);
            add(&mut moment, cross3(lifted(arm), lifted(on_corner)), 1.0);
        }
        RigidForce { force, moment, pivot }
    }

    fn advance(
        &self,
        number: usize,
        moving: &mut RigidMotion<D>,
        RigidForce { force, mut moment, pivot }: RigidForce<D>,
        sum: &mut MotionSums<Pile, D>,
    ) -> f64 {
        let body = &self.solid.rigid.all[number];
        let arm = lifted(minus(pivot, moving.centre));
        add(&mut moment, cross3(arm, lifted(force)), 1.0);
        match self.turning_of(body) {
            Some((boundary, spin)) => {
                let reaction = turn_held_body(body, moving, (moment, spin), self.motion, sum);
                sum.moments.push((boundary, reaction));
            }
            None => turn_body(body, moving, moment, self.motion, sum),
        }
        let speed = self.move_centre(body, moving, force, sum) + length(moving.spin) * body.radius;
        speed * speed
    }

    fn element(&self, body: usize) -> u32 {
        self.solid.rigid.all[body].elements[0]
    }
}

/// Turns a body with a prescribed angular velocity, rad/s, against a moment about its centre of mass, N m.
/// The moment of its support, which it returns, N m, does work.
fn turn_held_body<const D: usize, const N: usize>(
    body: &RigidBody<D>,
    moving: &mut RigidMotion<D>,
    (moment, spin): (Point<3>, Point<3>),
    motion: &Motion<'_, D, N>,
    sum: &mut MotionSums<Pile, D>,
) -> Point<3> {
    let (step, before) = (motion.step, moving.momentum);
    let middle = matrix_of(turned(moving.orientation, spin.map(|x| 0.5 * step * x)));
    let after = body.momentum(&middle, spin);
    let reaction = minus(minus(after, before).map(|x| x / step), moment);
    if motion.energy {
        sum.kinetic.add(0.5 * dot(before, spin), motion.grains);
    }
    add_works(&mut sum.external, reaction, [moving.spin, spin], step, motion.grains);
    moving.turn_by(spin.map(|x| step * x));
    (moving.momentum, moving.spin) = (after, spin);
    reaction
}

/// Turns a body under a moment about its centre of mass, N m.
fn turn_body<const D: usize, const N: usize>(
    body: &RigidBody<D>,
    moving: &mut RigidMotion<D>,
    moment: Point<3>,
    motion: &Motion<'_, D, N>,
    sum: &mut MotionSums<Pile, D>,
) {
    let (step, momentum) = (motion.step, moving.momentum);
    let (whole, moment) = (moment, body.left(moment));
    let now = matrix_of(moving.orientation);
    let before = body.spin(&now, momentum);
    let local = local_damping(motion.model.time.local_damping, moment, before);
    let damped = relaxed(motion, 1.0, moment, momentum, local);
    let pushed = plus(momentum, minus(whole, damped).map(|x| step * x));
    moving.momentum = body.left(pushed);
    let after = body.spin(&now, moving.momentum);
    if body.is_held() {
        // A support that is new takes the angular momentum that it does not leave.
        let reaction = minus(moving.momentum, pushed).map(|x| x / step);
        add_works(&mut sum.external, reaction, [moving.spin, after], step, motion.grains);
    }
    moving.spin = after;
    for _ in 0..ITERATIONS {
        let middle = matrix_of(turned(moving.orientation, moving.spin.map(|x| 0.5 * step * x)));
        let spin = body.spin(&middle, moving.momentum);
        if spin == std::mem::replace(&mut moving.spin, spin) {
            break;
        }
    }
    moving.turn_by(moving.spin.map(|x| step * x));
    if motion.energy {
        sum.kinetic.add(0.5 * dot(momentum, after), motion.grains);
    }
    add_works(&mut sum.damping, damped, [before, after], step, motion.grains);
    for axis in 0..3 {
        let spins = [before[axis], after[axis]];
        sum.take(motion.taken, motion.step * moment[axis], spins, momentum[axis], motion.grains);
    }
}
