//! The motion of clumps: rigid bodies of spheres.
//!
//! The centre moves as a sphere does. The angular momentum in space is half a step behind the orientation.
//! The angular velocity of a step is that which belongs to the angular momentum at the orientation in the
//! middle of the step, found by iteration: so a free clump keeps its energy.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::clump::ClumpInertia;
use crate::domain::Outside;
use crate::error::GrainError;
use crate::model::GrainModel;
use crate::rotation::{Matrix, Quaternion, UNTURNED, applied, applied_back, inverse, matrix, turned_by};
use crate::run::balls::{Ball, Balls};
use crate::run::motion::{FARTHEST, Moved, Moving};
use crate::vector::{Vector, cross, dot, length, minus, plus, times};

/// Iterations of the angular velocity in the middle of a step.
const ITERATIONS: usize = 8;

/// A clump as it was at the beginning.
#[derive(Clone, Debug)]
struct ClumpBody {
    mass: f64,
    /// Moments of inertia about the centre of mass, kg m², and their inverse.
    moments: Matrix,
    inverse: Matrix,
    held: bool,
    /// Numbers of its spheres, ascending, and their centres relative to the centre of mass, m.
    members: Vec<(u32, Vector)>,
}

/// The motion of a clump. Velocity, momentum and spin are half a step before the rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClumpMotion {
    /// Centre of mass, m.
    centre: Vector,
    /// m/s.
    velocity: Vector,
    /// Rotation since the beginning, and that a step ago.
    orientation: Quaternion,
    before: Quaternion,
    /// Angular momentum, N m s, and angular velocity, rad/s.
    momentum: Vector,
    spin: Vector,
    /// Velocity, m/s, angular momentum, N m s, and angular velocity, rad/s, at the time of the centre.
    now: [Vector; 3],
    /// Work from outside since the beginning, J.
    external: f64,
    /// Whether it has been removed.
    removed: bool,
}

/// All clumps of a run.
#[derive(Debug, Default)]
pub(crate) struct Clumps {
    bodies: Vec<ClumpBody>,
    motions: Vec<ClumpMotion>,
    /// Places in memory of the spheres of each clump.
    places: Vec<Vec<u32>>,
}

/// A step of a clump.
struct Turned {
    /// Matrices of the orientations before and after it.
    matrices: [Matrix; 2],
    motion: ClumpMotion,
}

impl Clumps {
    /// The clumps of a model that has been checked.
    pub(crate) fn new(model: &GrainModel) -> Self {
        let mut clumps = Self::default();
        for (number, of) in model.clumps.iter().enumerate() {
            let ClumpInertia { mass, centre, moments } = model.inertia_of(number);
            let arm = |&sphere: &u32| (sphere, minus(model.spheres.positions[sphere as usize], centre));
            let body = ClumpBody {
                mass,
                moments,
                // The check of the model has refused others.
                inverse: inverse(&moments).unwrap_or_default(),
                held: of
                    .spheres
                    .iter()
                    .all(|&sphere| model.spheres.held.get(sphere as usize).copied().unwrap_or(false)),
                members: of.spheres.iter().map(arm).collect(),
            };
            let momentum = applied(&moments, of.spin);
            clumps.motions.push(ClumpMotion {
                centre,
                velocity: of.velocity,
                orientation: UNTURNED,
                before: UNTURNED,
                momentum,
                spin: of.spin,
                now: [of.velocity, momentum, of.spin],
                external: 0.0,
                removed: false,
            });
            clumps.bodies.push(body);
        }
        clumps
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Gives the spheres of the clumps their velocities at the beginning.
    pub(crate) fn begin(&self, balls: &mut Balls) {
        for (body, motion) in self.bodies.iter().zip(&self.motions) {
            for (number, arm) in &body.members {
                let place = balls.places[*number as usize] as usize;
                let velocity = plus(motion.velocity, cross(motion.spin, *arm));
                (balls.list[place].velocity, balls.list[place].spin) = (velocity, motion.spin);
                (balls.drives[place].velocity, balls.drives[place].spin) = (velocity, motion.spin);
            }
        }
    }

    pub(crate) fn saved(&self) -> Vec<ClumpMotion> {
        self.motions.clone()
    }

    /// Takes the clumps of a saved run over.
    ///
    /// # Errors
    /// [`GrainError::Length`] if it has another number of them.
    pub(crate) fn take(&mut self, saved: Vec<ClumpMotion>) -> Result<(), GrainError> {
        let (found, expected) = (saved.len(), self.bodies.len());
        if found != expected {
            return Err(GrainError::Length { what: "clumps", found, expected });
        }
        self.motions = saved;
        Ok(())
    }

    /// Notes where the spheres are in memory.
    pub(crate) fn find(&mut self, balls: &Balls) {
        let place = |(number, _): &(u32, Vector)| {
            let rank = balls.places.binary_search_by_key(number, |&place| balls.list[place as usize].number);
            rank.ok().map(|rank| balls.places[rank])
        };
        let places = |body: &ClumpBody| body.members.iter().filter_map(place).collect();
        self.places = self.bodies.iter().map(places).collect();
    }

    /// Moves all clumps under the forces and moments of their spheres, and the spheres with them.
    ///
    /// # Errors
    /// The sphere with the lowest number that has no place any more, or that has left the box.
    pub(crate) fn advance(&mut self, balls: &mut Balls, of: Moving<'_>) -> Result<Moved, GrainError> {
        let Self { bodies, motions, places } = self;
        let pushes = &balls.pushes;
        let turns: Vec<Option<Turned>> = bodies
            .par_iter()
            .zip(&*motions)
            .zip(&*places)
            .map(|((body, motion), places)| {
                (!motion.removed).then(|| turn(body, *motion, (pushes, places), of))
            })
            .collect();
        let mut moved = Moved::default();
        let mut first: Option<(u32, GrainError)> = None;
        for ((body, motion), (turned, places)) in bodies.iter().zip(motions).zip(turns.iter().zip(&*places)) {
            let Some(turned) = turned else { continue };
            *motion = turned.motion;
            for (&(number, arm), &place) in body.members.iter().zip(places) {
                let place = place as usize;
                follow(turned, arm, (balls, place), of);
                let drive = &balls.drives[place];
                moved.fastest = moved.fastest.max(length(drive.velocity));
                moved.spread = moved.spread.max(length(minus(drive.velocity, of.stream)));
                match error_of(&balls.list[place], of) {
                    Ok(leaves) => moved.leaves |= leaves,
                    Err(error) if first.as_ref().is_none_or(|(lowest, _)| number < *lowest) => {
                        first = Some((number, error));
                    }
                    Err(_) => {}
                }
            }
        }
        first.map_or(Ok(moved), |(_, error)| Err(error))
    }

    /// Removes the clumps that have a sphere for which `goes` holds. Returns the energy of their motion and
    /// weight less the work from outside on them, J, and whether each clump goes.
    pub(crate) fn remove(
        &mut self,
        balls: &Balls,
        gravity: Vector,
        goes: impl Fn(Vector) -> bool,
    ) -> (f64, Vec<bool>) {
        let mut energy = 0.0;
        let mut going = vec![false; self.bodies.len()];
        for (clump, (body, motion)) in self.bodies.iter().zip(&mut self.motions).enumerate() {
            let is_out = |&place: &u32| goes(balls.list[place as usize].position);
            if motion.removed || !self.places[clump].iter().any(is_out) {
                continue;
            }
            (motion.removed, going[clump]) = (true, true);
            energy += 0.5 * body.mass * dot(motion.velocity, motion.velocity)
                + 0.5 * dot(motion.spin, motion.momentum)
                - body.mass * dot(gravity, motion.centre)
                - motion.external;
        }
        (energy, going)
    }

    /// Energies of the clumps at the positions of the last step, `step` ago, s: kinetic, of rotation, of the
    /// weight, and the work from outside on them, J.
    pub(crate) fn energies(&self, (gravity, step): (Vector, f64)) -> [f64; 4] {
        let mut energies = [0.0; 4];
        for (body, motion) in self.bodies.iter().zip(&self.motions).filter(|(_, motion)| !motion.removed) {
            let velocity = minus(times(2.0, motion.velocity), motion.now[0]);
            let momentum = minus(times(2.0, motion.momentum), motion.now[1]);
            let (spin, momentum) = if body.held {
                (motion.spin, motion.momentum)
            } else {
                (body.spin(&matrix(motion.before), momentum), momentum)
            };
            let centre = minus(motion.centre, times(step, motion.velocity));
            energies[0] += 0.5 * body.mass * dot(velocity, velocity);
            energies[1] += 0.5 * dot(spin, momentum);
            energies[2] -= body.mass * dot(gravity, centre);
            energies[3] += motion.external;
        }
        energies
    }

    /// Masses, kg, centres, m, and velocities, m/s, of the clumps that have not been removed.
    pub(crate) fn centres(&self) -> impl Iterator<Item = (f64, Vector, Vector)> {
        let all = self.bodies.iter().zip(&self.motions).filter(|(_, motion)| !motion.removed);
        all.map(|(body, motion)| (body.mass, motion.centre, motion.velocity))
    }
}

impl ClumpBody {
    /// Angular velocity, rad/s, of an angular momentum, N m s, at an orientation.
    #[inline]
    fn spin(&self, turn: &Matrix, momentum: Vector) -> Vector {
        applied(turn, applied(&self.inverse, applied_back(turn, momentum)))
    }
}

/// A clump after a step under the forces and moments of its spheres.
fn turn(
    body: &ClumpBody,
    mut motion: ClumpMotion,
    (pushes, places): (&[[Vector; 2]], &[u32]),
    of: Moving<'_>,
) -> Turned {
    let (step, half) = (of.step, 0.5 * of.step);
    let before = matrix(motion.orientation);
    let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
    for ((_, arm), &place) in body.members.iter().zip(places) {
        let [own, own_moment] = pushes[place as usize];
        force = plus(force, own);
        moment = plus(moment, plus(own_moment, cross(applied(&before, *arm), own)));
    }
    motion.before = motion.orientation;
    if body.held {
        let [velocity, _, spin] = motion.now;
        motion.external -= step * (dot(force, velocity) + dot(moment, spin));
        motion.orientation = turned_by(motion.orientation, times(step, motion.spin));
    } else {
        let acceleration = plus(times(1.0 / body.mass, force), of.gravity);
        motion.velocity = plus(motion.velocity, times(step, acceleration));
        motion.now[0] = plus(motion.velocity, times(half, acceleration));
        motion.momentum = plus(motion.momentum, times(step, moment));
        motion.spin = body.spin(&before, motion.momentum);
        for _ in 0..ITERATIONS {
            let middle = matrix(turned_by(motion.orientation, times(half, motion.spin)));
            let spin = body.spin(&middle, motion.momentum);
            if spin == std::mem::replace(&mut motion.spin, spin) {
                break;
            }
        }
        motion.orientation = turned_by(motion.orientation, times(step, motion.spin));
    }
    let after = matrix(motion.orientation);
    if body.held {
        motion.momentum = applied(&after, applied(&body.moments, applied_back(&after, motion.spin)));
        motion.now[1] = motion.momentum;
    } else {
        motion.now[1] = plus(motion.momentum, times(half, moment));
        motion.now[2] = body.spin(&after, motion.now[1]);
    }
    motion.centre = plus(motion.centre, times(step, motion.velocity));
    if let Some(cell) = of.cell {
        let place = motion.centre;
        motion.centre = cell.wrapped(place);
        motion.external -= body.mass * dot(of.gravity, minus(motion.centre, place));
    }
    Turned { matrices: [before, after], motion }
}

/// Moves a sphere with its clump. Its velocity is that of its displacement in the step.
fn follow(turned: &Turned, arm: Vector, (balls, place): (&mut Balls, usize), of: Moving<'_>) {
    let Turned { matrices: [before, after], motion } = turned;
    let [old, new] = [applied(before, arm), applied(after, arm)];
    let (ball, drive) = (&mut balls.list[place], &mut balls.drives[place]);
    drive.velocity = plus(motion.velocity, times(1.0 / of.step, minus(new, old)));
    drive.spin = motion.spin;
    ball.velocity = plus(motion.now[0], cross(motion.now[2], new));
    ball.spin = motion.now[2];
    ball.position = plus(motion.centre, new);
    if let Some(cell) = of.cell {
        ball.position = cell.wrapped(ball.position);
    }
}

/// Whether a sphere has left the box, and is to be removed.
fn error_of(ball: &Ball, of: Moving<'_>) -> Result<bool, GrainError> {
    if !ball.position.iter().all(|x| x.abs() < FARTHEST) {
        return Err(GrainError::Lost { sphere: ball.number as usize, step: of.number });
    }
    match of.cell.and_then(|cell| cell.outside(ball.position)) {
        Some(Outside::Stop) => Err(GrainError::Outside { sphere: ball.number, step: of.number }),
        leaves => Ok(leaves.is_some()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A free body with the moments 1, 2 and 3 that turns about its middle axis, which is unstable.
    #[test]
    fn a_free_top_keeps_energy_and_momentum_and_flips_in_time() {
        let moments = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let body = ClumpBody {
            mass: 1.0,
            moments,
            inverse: inverse(&moments).expect("positive"),
            held: false,
            members: Vec::new(),
        };
        let spin = [0.01, 1.0, 0.01];
        let momentum = applied(&moments, spin);
        let mut motion = ClumpMotion {
            centre: [0.0; 3],
            velocity: [0.0; 3],
            orientation: UNTURNED,
            before: UNTURNED,
            momentum,
            spin,
            now: [[0.0; 3], momentum, spin],
            external: 0.0,
            removed: false,
        };
        let contacts = crate::run::contacts::Contacts::default();
        let of = Moving {
            contacts: &contacts,
            outer: (&[], &[]),
            cell: None,
            simd: fdem_contact::Simd::best(),
            stream: [0.0; 3],
            deepest: 0.0,
            gravity: [0.0; 3],
            step: 1e-3,
            number: 0,
        };
        let energy = |motion: &ClumpMotion| dot(motion.now[2], motion.now[1]);
        let (begin, size) = (energy(&motion), length(momentum));
        let mut flips = Vec::new();
        let mut last = 1.0;
        for step in 0..1_000_000 {
            motion = turn(&body, motion, (&[], &[]), of).motion;
            let middle = applied_back(&matrix(motion.orientation), motion.now[2])[1];
            if middle * last < 0.0 {
                flips.push(1e-3 * f64::from(step));
            }
            last = middle;
            if step % 1000 == 0 {
                assert!((energy(&motion) / begin - 1.0).abs() < 1e-6, "{step} {}", energy(&motion) / begin);
            }
        }
        assert!((length(motion.momentum) / size - 1.0).abs() < 1e-12);
        // Between two flips is half of a period of an elliptic function.
        let period = (flips[flips.len() - 1] - flips[0]) / (flips.len() - 1) as f64;
        let expected = half_period(moments, spin);
        assert!((period / expected - 1.0).abs() < 1e-3, "{period} {expected}");
    }

    /// Half of the period of the middle component of a free top's angular velocity: `2 K(m) / w` by Jacobi's
    /// functions, with `K` from the arithmetic and geometric mean.
    fn half_period(moments: Matrix, spin: Vector) -> f64 {
        let [a, b, c] = [moments[0][0], moments[1][1], moments[2][2]];
        let [p, q, r] = spin;
        let twice = a * p * p + b * q * q + c * r * r;
        let square = a * a * p * p + b * b * q * q + c * c * r * r;
        let (low, high) = (square - twice * a, twice * c - square);
        let (rate, modulus) = if twice * b < square {
            (((c - b) * low / (a * b * c)).sqrt(), (b - a) * high / ((c - b) * low))
        } else {
            (((b - a) * high / (a * b * c)).sqrt(), (c - b) * low / ((b - a) * high))
        };
        let (mut x, mut y) = (1.0, (1.0 - modulus).sqrt());
        for _ in 0..40 {
            (x, y) = (0.5 * (x + y), f64::sqrt(x * y));
        }
        std::f64::consts::PI / x / rate
    }
}
