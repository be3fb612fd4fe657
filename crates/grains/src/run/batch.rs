//! Contacts of two spheres side by side, computed with vector instructions.
//!
//! The law is that of [`law`](crate::law) without adhesion, written for one contact without branches, in a
//! loop over the contacts of a batch. It is compiled for each set of instructions; all of them do the same
//! operations on each contact, so that the bits are the same.

#![allow(clippy::inline_always, reason = "the loop must end up in the function that is compiled for it")]
#![allow(clippy::needless_range_loop, reason = "a lane is a place in many lists")]

use fdem_contact::Simd;

use crate::law::PairLaw;
use crate::material::ForceLaw;
use crate::vector::{Vector, across, cross, dot, minus, plus, times};

/// Contacts in a batch.
pub(crate) const LANES: usize = 8;

/// A number of each contact.
type Lane = [f64; LANES];
/// A vector of each contact.
type Vectors = [Lane; 3];

/// The contacts of a batch. Those of lanes that are not in use are computed and thrown away.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Batch {
    /// Number of lanes in use.
    pub(crate) count: usize,
    /// Where each contact belongs.
    pub(crate) slots: [u32; LANES],
    /// From the second sphere to the first, m, and the square of that distance, m².
    pub(crate) apart: Vectors,
    pub(crate) square: Lane,
    /// Velocity of the first over that of the second, m/s, and angular velocities of both, rad/s.
    pub(crate) velocity: Vectors,
    pub(crate) spins: [Vectors; 2],
    /// Radii, m, and masses, kg.
    pub(crate) radii: [Lane; 2],
    pub(crate) masses: [Lane; 2],
    /// Memory of the contact, as in [`ContactHistory`](crate::ContactHistory).
    pub(crate) tangential: Vectors,
    pub(crate) contact: Lane,
    pub(crate) rolling: Vectors,
    pub(crate) twisting: Lane,
    /// Force on the first, N.
    pub(crate) force: Vectors,
    /// The moments on the two are this times the distance of the contact from their centres, N.
    pub(crate) torque: Vectors,
    /// Moment of rolling and twisting on the first, N m.
    pub(crate) moment: Vectors,
    /// m.
    pub(crate) overlap: Lane,
    /// Energy that the step dissipates, J.
    pub(crate) dissipated: Lane,
}

impl Default for Batch {
    /// Lanes of spheres that are side by side, so that no number of unused ones becomes slow to compute with.
    fn default() -> Self {
        let none = [[0.0; LANES]; 3];
        Self {
            count: 0,
            slots: [0; LANES],
            apart: [[1.0; LANES], [0.0; LANES], [0.0; LANES]],
            square: [1.0; LANES],
            velocity: none,
            spins: [none; 2],
            radii: [[1.0; LANES]; 2],
            masses: [[1.0; LANES]; 2],
            tangential: none,
            contact: [0.0; LANES],
            rolling: none,
            twisting: [0.0; LANES],
            force: none,
            torque: none,
            moment: none,
            overlap: [0.0; LANES],
            dissipated: [0.0; LANES],
        }
    }
}

#[inline(always)]
pub(crate) fn put(to: &mut Vectors, lane: usize, vector: Vector) {
    for axis in 0..3 {
        to[axis][lane] = vector[axis];
    }
}

#[inline(always)]
pub(crate) fn at(of: &Vectors, lane: usize) -> Vector {
    [of[0][lane], of[1][lane], of[2][lane]]
}

/// Computes the forces of all contacts of a batch after a step, s, and continues their histories. `share`:
/// moment of inertia over mass and square of the radius.
#[allow(unsafe_code, reason = "it is compiled for vector instructions")]
pub(crate) fn compute(simd: Simd, law: &PairLaw, batch: &mut Batch, step: f64, share: f64) {
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn avx2(law: &PairLaw, batch: &mut Batch, step: f64, share: f64) {
        by_law(law, batch, step, share);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512vl")]
    fn avx512(law: &PairLaw, batch: &mut Batch, step: f64, share: f64) {
        by_law(law, batch, step, share);
    }

    match simd {
        // SAFETY: a run takes the instructions that this processor has.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512 => unsafe { avx512(law, batch, step, share) },
        // SAFETY: the same.
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2 => unsafe { avx2(law, batch, step, share) },
        _ => by_law(law, batch, step, share),
    }
}

#[inline(always)]
fn by_law(law: &PairLaw, batch: &mut Batch, step: f64, share: f64) {
    let numbers = (step, share);
    match (law.law, law.surfaces.friction > 0.0, law.rolls()) {
        (ForceLaw::HertzMindlin, false, false) => all::<true, false, false>(law, batch, numbers),
        (ForceLaw::HertzMindlin, true, false) => all::<true, true, false>(law, batch, numbers),
        (ForceLaw::HertzMindlin, _, true) => all::<true, true, true>(law, batch, numbers),
        (ForceLaw::Hooke { .. }, false, false) => all::<false, false, false>(law, batch, numbers),
        (ForceLaw::Hooke { .. }, true, false) => all::<false, true, false>(law, batch, numbers),
        (ForceLaw::Hooke { .. }, _, true) => all::<false, true, true>(law, batch, numbers),
    }
}

#[inline(always)]
fn all<const HERTZ: bool, const SLIPS: bool, const ROLLS: bool>(
    law: &PairLaw,
    batch: &mut Batch,
    numbers: (f64, f64),
) {
    for lane in 0..LANES {
        one::<HERTZ, SLIPS, ROLLS>(law, batch, lane, numbers);
    }
}

/// Lengths of a contact, m, and its force along the normal.
struct Pressed {
    normal: Vector,
    /// Reduced radius, m, and mass, kg.
    radius: f64,
    mass: f64,
    /// N, and the stiffness along the normal, N/m.
    along: f64,
    stiffness: f64,
    /// Radius of the contact now and before, m.
    contact: [f64; 2],
}

#[inline(always)]
fn one<const HERTZ: bool, const SLIPS: bool, const ROLLS: bool>(
    law: &PairLaw,
    batch: &mut Batch,
    lane: usize,
    (step, share): (f64, f64),
) {
    let distance = batch.square[lane].sqrt();
    let normal = times(1.0 / distance, at(&batch.apart, lane));
    let [one, two] = [batch.radii[0][lane], batch.radii[1][lane]];
    let [first, second] = [batch.masses[0][lane], batch.masses[1][lane]];
    let overlap = one + two - distance;
    let [near, far] = [one - 0.5 * overlap, two - 0.5 * overlap];
    let [spin, other] = [at(&batch.spins[0], lane), at(&batch.spins[1], lane)];
    let arms = plus(times(near, spin), times(far, other));
    let velocity = plus(at(&batch.velocity, lane), cross(normal, arms));
    let approach = -dot(velocity, normal);
    let (radius, mass) = (one * two / (one + two), first * second / (first + second));
    // Lanes that are not in use may be apart.
    let contact = larger(radius * overlap, 0.0).sqrt();
    let (elastic, stiffness) = if HERTZ {
        (4.0 / 3.0 * law.young * contact * overlap, 2.0 * law.young * contact)
    } else {
        (law.normal() * overlap, law.normal())
    };
    let dashpot = law.damping * (stiffness * mass).sqrt();
    let along = larger(elastic + dashpot * approach, 0.0);
    let mut dissipated = (along - elastic) * approach * step;
    let mut force = times(along, normal);
    let mut torque = [0.0; 3];
    let of = Pressed { normal, radius, mass, along, stiffness, contact: [contact, batch.contact[lane]] };
    let twist = 0.5 * step * (dot(spin, normal) + dot(other, normal));
    if SLIPS {
        let slip = plus(velocity, times(approach, normal));
        let history = at(&batch.tangential, lane);
        let (push, history, lost) = slipping::<HERTZ>(law, &of, history, (slip, twist), step);
        put(&mut batch.tangential, lane, history);
        dissipated += lost;
        force = plus(force, push);
        torque = cross(push, normal);
    }
    if ROLLS {
        let [inert, inertial] = [first * one * one, second * two * two];
        let inertia = (share + 1.0) * (inert * inertial / (inert + inertial));
        let rate = minus(spin, other);
        let before = (at(&batch.rolling, lane), batch.twisting[lane]);
        let (moment, history, lost) = turning::<HERTZ>(law, &of, before, (rate, twist, inertia), step);
        put(&mut batch.rolling, lane, history.0);
        batch.twisting[lane] = history.1;
        put(&mut batch.moment, lane, moment);
        dissipated += lost;
    }
    put(&mut batch.force, lane, force);
    put(&mut batch.torque, lane, torque);
    batch.contact[lane] = contact;
    batch.overlap[lane] = overlap;
    batch.dissipated[lane] = dissipated;
}

/// The force across the normal, N, the elastic part that stays, N, and the energy that is dissipated, J.
#[inline(always)]
fn slipping<const HERTZ: bool>(
    law: &PairLaw,
    of: &Pressed,
    history: Vector,
    (slip, twist): (Vector, f64),
    step: f64,
) -> (Vector, Vector, f64) {
    let [contact, before] = of.contact;
    let [stiffness, earlier] = [law.tangential_stiffness(contact), law.tangential_stiffness(before)];
    let turned = turned(history, of.normal, twist);
    let kept = if HERTZ { smaller(contact / larger(before, f64::MIN_POSITIVE), 1.0) } else { 1.0 };
    let elastic = minus(times(kept, turned), times(stiffness * step, slip));
    let dashpot = law.damping * (stiffness * of.mass).sqrt();
    let force = minus(elastic, times(dashpot, slip));
    let size = dot(force, force).sqrt();
    let most = law.surfaces.friction * of.along;
    let slides = size > most;
    let scale = if slides { most / size } else { 1.0 };
    let force = times(scale, force);
    let stays = either(slides, force, elastic);
    let stored =
        |spring: Vector, stiffness: f64| 0.5 * dot(spring, spring) / larger(stiffness, f64::MIN_POSITIVE);
    let lost = -step * dot(force, slip) - (stored(stays, stiffness) - stored(history, earlier));
    (force, stays, lost)
}

/// The moment of rolling and twisting on the first, N m, the elastic parts that stay, and the energy that is
/// dissipated, J. `rate`: angular velocity of the first over that of the second, rad/s.
#[inline(always)]
fn turning<const HERTZ: bool>(
    law: &PairLaw,
    of: &Pressed,
    (rolling, twisting): (Vector, f64),
    (rate, twist, inertia): (Vector, f64, f64),
    step: f64,
) -> (Vector, (Vector, f64), f64) {
    let before = if HERTZ { 2.0 * law.young * of.contact[1] } else { of.stiffness };
    let [roll, spin] = [law.surfaces.rolling_friction, law.surfaces.twisting_friction];
    let spring = |normal: f64, share: f64| 2.25 * normal * (share * of.radius) * (share * of.radius);
    let damped = |stiffness: f64| 2.0 * law.surfaces.rolling_damping * (inertia * stiffness).sqrt();

    let [stiffness, earlier] = [spring(of.stiffness, roll), spring(before, roll)];
    let flat = across(rate, of.normal);
    let elastic = minus(turned(rolling, of.normal, twist), times(stiffness * step, flat));
    let (size, most) = (dot(elastic, elastic).sqrt(), roll * of.radius * of.along);
    let yields = size > most;
    let stays = times(if yields { most / size } else { 1.0 }, elastic);
    let moment = minus(stays, times(if yields { 0.0 } else { damped(stiffness) }, flat));
    let stored = |spring: f64, stiffness: f64| 0.5 * spring / larger(stiffness, f64::MIN_POSITIVE);
    let mut lost = -step * dot(moment, flat)
        - (stored(dot(stays, stays), stiffness) - stored(dot(rolling, rolling), earlier));

    let [stiffness, earlier] = [spring(of.stiffness, spin), spring(before, spin)];
    let about = dot(rate, of.normal);
    let elastic = twisting - stiffness * step * about;
    let most = spin * of.radius * of.along;
    let yields = elastic.abs() > most;
    let kept = larger(smaller(elastic, most), -most);
    let twisted = kept - if yields { 0.0 } else { damped(stiffness) * about };
    lost -= step * twisted * about + (stored(kept * kept, stiffness) - stored(twisting * twisting, earlier));
    (plus(moment, times(twisted, of.normal)), (stays, kept), lost)
}

/// A vector across the normal that turns with the contact: into its plane, with its length, and about the
/// normal by an angle, rad.
#[inline(always)]
fn turned(vector: Vector, normal: Vector, angle: f64) -> Vector {
    let flat = across(vector, normal);
    let scale = (dot(vector, vector) / larger(dot(flat, flat), f64::MIN_POSITIVE)).sqrt();
    let flat = times(scale, flat);
    plus(flat, times(angle, cross(normal, flat)))
}

/// The larger of two numbers; the second if one is none.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; the second if one is none.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn either(first: bool, one: Vector, two: Vector) -> Vector {
    let of = |axis: usize| if first { one[axis] } else { two[axis] };
    [of(0), of(1), of(2)]
}
