//! Contacts of two spheres side by side, computed with vector instructions.
//!
//! The law is that of [`law`](crate::law) without adhesion, written for one contact without branches, in a
//! loop over the contacts of a batch. It is compiled for each set of instructions ([`level`](super::level)).

#![allow(clippy::inline_always, reason = "the loop must end up in the function that is compiled for it")]
#![allow(clippy::needless_range_loop, reason = "a lane is a place in many lists")]

use fdem_contact::Simd;

use crate::law::PairLaw;
use crate::material::ForceLaw;
use crate::run::balls::Ball;
use crate::run::cell::Repeats;
use crate::run::contacts::{Couple, Memory, Rolling};
use crate::run::level::Level;
use crate::run::rows::{larger, row, smaller};
use crate::vector::{Vector, across, cross, dot, minus, plus, times};

/// Contacts in a batch.
pub(crate) const LANES: usize = 8;

/// A number of each contact.
type Lane = [f64; LANES];
/// A vector of each contact.
type Vectors = [Lane; 3];
/// Three numbers of a vector and another one, of four contacts.
type Rows = [[f64; 4]; 4];

/// The contacts of a batch. Lanes that are not in use compute the first one, too. Results of these lanes and
/// of contacts that end are thrown away.
#[derive(Clone, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Batch {
    /// Number of lanes in use.
    pub(crate) count: usize,
    /// The contacts, by their places in the chunk.
    pub(crate) contacts: [u32; LANES],
    /// Places of the first and the second sphere of each contact.
    places: [[u32; LANES]; 2],
    balls: [Columns; 2],
    /// From the second sphere to the first, m, and the square of that distance, m².
    apart: Vectors,
    square: Lane,
    /// Velocity of the first over that of the second, m/s.
    velocity: Vectors,
    /// From the second sphere to the first, of unit length.
    normal: Vectors,
    /// Velocity across the normal at the contact, m/s.
    slip: Vectors,
    /// Mean angle about the normal by which the spheres turn in the step, rad.
    twist: Lane,
    /// Root of the product of stiffness along the normal and reduced mass, N s/m.
    root: Lane,
    /// Force along the normal, N.
    along: Lane,
    /// Elastic force across the normal before friction, N.
    elastic: Vectors,
    /// Radius of the contact, m.
    radius_now: Lane,
    /// Memory of the contact, as in [`ContactHistory`](crate::ContactHistory).
    tangential: Vectors,
    contact: Lane,
    rolling: Vectors,
    twisting: Lane,
    /// Force on the first, N.
    force: Vectors,
    /// The moments on the two are this times the distance of the contact from their centres, N.
    torque: Vectors,
    /// Moment of rolling and twisting on the first, N m.
    moment: Vectors,
    /// m.
    overlap: Lane,
    /// Energy that the step dissipates, J.
    dissipated: Lane,
}

/// Spheres, as in [`Ball`].
#[derive(Clone, Debug, Default)]
struct Columns {
    position: Vectors,
    radius: Lane,
    velocity: Vectors,
    mass: Lane,
    spin: Vectors,
}

/// The numbers that all contacts of a batch have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Common<'a> {
    pub(crate) balls: &'a [Ball],
    pub(crate) law: &'a PairLaw,
    pub(crate) repeats: Repeats,
    /// Rates at which the box grows, 1/s.
    pub(crate) rates: Vector,
    pub(crate) simd: Simd,
    /// s.
    pub(crate) step: f64,
    /// Moment of inertia over mass and square of the radius.
    pub(crate) share: f64,
}

impl Batch {
    /// Takes a contact into the next lane: its place in the chunk, and those of its spheres.
    #[inline(always)]
    pub(crate) fn take(&mut self, contact: u32, places: [u32; 2]) {
        let lane = self.count;
        self.contacts[lane] = contact;
        (self.places[0][lane], self.places[1][lane]) = (places[0], places[1]);
        self.count += 1;
    }

    /// Takes contacts that lie side by side into the lanes. `begin`: the place of the first one in the chunk.
    #[inline(always)]
    pub(crate) fn fill(&mut self, begin: usize, couples: &[Couple]) {
        for (lane, couple) in couples.iter().enumerate().take(LANES) {
            self.contacts[lane] = (begin + lane) as u32;
            (self.places[0][lane], self.places[1][lane]) = (couple.places[0], couple.places[1]);
        }
        self.count = couples.len();
    }

    /// Computes the forces of all contacts after a step, and continues their histories.
    #[inline(always)]
    pub(crate) fn compute<L: Level, const PERIODIC: bool>(
        &mut self,
        of: Common<'_>,
        memories: &[Memory],
        rolling: &[Rolling],
    ) {
        for lane in self.count..LANES {
            self.contacts[lane] = self.contacts[0];
            (self.places[0][lane], self.places[1][lane]) = (self.places[0][0], self.places[1][0]);
        }
        for side in 0..2 {
            let balls = self.places[side].map(|place| &of.balls[place as usize]);
            let to = &mut self.balls[side];
            let of_position = balls.map(|ball| row(ball.position, ball.radius));
            columns::<L>(of_position, &mut to.position, &mut to.radius);
            let of_velocity = balls.map(|ball| row(ball.velocity, ball.mass));
            columns::<L>(of_velocity, &mut to.velocity, &mut to.mass);
            columns::<L>(balls.map(|ball| row(ball.spin, 0.0)), &mut to.spin, &mut [0.0; LANES]);
        }
        let of_memory = self.contacts.map(|contact| memories[contact as usize].0);
        columns::<L>(of_memory, &mut self.tangential, &mut self.contact);
        if of.law.rolls() {
            for lane in 0..LANES {
                let rolling = &rolling[self.contacts[lane] as usize];
                put(&mut self.rolling, lane, rolling.spring);
                self.twisting[lane] = rolling.twisting;
            }
        }
        for lane in 0..LANES {
            self.meet::<PERIODIC>(lane, of);
        }
        compute(of.simd, of.law, self, of.step, of.share);
    }

    /// Places and velocities of the two spheres of a contact against each other.
    #[inline(always)]
    fn meet<const PERIODIC: bool>(&mut self, lane: usize, of: Common<'_>) {
        let [one, two] = &self.balls;
        let apart = minus(at(&one.position, lane), at(&two.position, lane));
        let apart = if PERIODIC { of.repeats.shortest(apart) } else { apart };
        let mut velocity = minus(at(&one.velocity, lane), at(&two.velocity, lane));
        if PERIODIC {
            let rates = of.rates;
            velocity = plus(velocity, [rates[0] * apart[0], rates[1] * apart[1], rates[2] * apart[2]]);
        }
        let square = dot(apart, apart);
        // Spheres at one point have no normal: any will do.
        let is_one = square == 0.0;
        put(&mut self.apart, lane, either(is_one, [1e-150, 0.0, 0.0], apart));
        self.square[lane] = if is_one { 1e-300 } else { square };
        put(&mut self.velocity, lane, velocity);
    }

    /// Memories, forces and torques of four contacts from a lane on, as rows: three numbers of a vector, and
    /// the radius of the contact, the energy that is dissipated, the overlap.
    #[inline(always)]
    pub(crate) fn rows<L: Level, const FIRST: usize>(&self) -> (Rows, Rows, Rows) {
        (
            rows::<L, FIRST>(&self.tangential, &self.contact),
            rows::<L, FIRST>(&self.force, &self.dissipated),
            rows::<L, FIRST>(&self.torque, &self.overlap),
        )
    }

    /// Whether the spheres of four lanes from one on touch.
    #[inline(always)]
    pub(crate) fn touch<const FIRST: usize>(&self) -> [bool; 4] {
        let mut touch = [false; 4];
        for k in 0..4 {
            let sum = self.balls[0].radius[FIRST + k] + self.balls[1].radius[FIRST + k];
            touch[k] = self.square[FIRST + k] < sum * sum;
        }
        touch
    }

    /// Reduced radius of the spheres of a lane, m.
    pub(crate) fn radius(&self, lane: usize) -> f64 {
        let [one, two] = [self.balls[0].radius[lane], self.balls[1].radius[lane]];
        one * two / (one + two)
    }

    /// Memory of the rolling of a contact.
    #[inline(always)]
    pub(crate) fn rolled(&self, lane: usize) -> Rolling {
        Rolling {
            spring: at(&self.rolling, lane),
            twisting: self.twisting[lane],
            moment: at(&self.moment, lane),
        }
    }

    /// Force on the first sphere of a contact, N, and from the second to it, m.
    #[inline(always)]
    pub(crate) fn stretched(&self, lane: usize) -> [Vector; 2] {
        [at(&self.force, lane), at(&self.apart, lane)]
    }
}

/// Turns rows of all lanes into lists of their numbers.
#[inline(always)]
fn columns<L: Level>(rows: [[f64; 4]; LANES], vectors: &mut Vectors, numbers: &mut Lane) {
    for half in [0, 4] {
        let [x, y, z, number] = L::columns([rows[half], rows[half + 1], rows[half + 2], rows[half + 3]]);
        vectors[0][half..half + 4].copy_from_slice(&x);
        vectors[1][half..half + 4].copy_from_slice(&y);
        vectors[2][half..half + 4].copy_from_slice(&z);
        numbers[half..half + 4].copy_from_slice(&number);
    }
}

/// Turns lists of the numbers of four lanes, from one on, into rows.
#[inline(always)]
fn rows<L: Level, const FIRST: usize>([x, y, z]: &Vectors, number: &Lane) -> Rows {
    L::columns([four::<FIRST>(x), four::<FIRST>(y), four::<FIRST>(z), four::<FIRST>(number)])
}

#[inline(always)]
fn four<const FIRST: usize>(list: &Lane) -> [f64; 4] {
    [list[FIRST], list[FIRST + 1], list[FIRST + 2], list[FIRST + 3]]
}

#[inline(always)]
fn put(to: &mut Vectors, lane: usize, vector: Vector) {
    for axis in 0..3 {
        to[axis][lane] = vector[axis];
    }
}

#[inline(always)]
fn at(of: &Vectors, lane: usize) -> Vector {
    [of[0][lane], of[1][lane], of[2][lane]]
}

/// Computes the law. It is a function of its own, in which the compiler knows that nothing else changes the
/// batch: without that it makes no vectors of the lanes.
#[allow(unsafe_code, reason = "it is compiled for vector instructions")]
fn compute(simd: Simd, law: &PairLaw, batch: &mut Batch, step: f64, share: f64) {
    #[cfg(target_arch = "x86_64")]
    #[inline(never)]
    #[target_feature(enable = "avx2")]
    fn avx2(law: &PairLaw, batch: &mut Batch, step: f64, share: f64) {
        by_law(law, batch, step, share);
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(never)]
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

/// Goes through the lanes several times, with a part of the law each time. The roots and quotients of a lane
/// wait for each other. The processor computes the lanes side by side only if they are few operations apart.
#[inline(always)]
fn all<const HERTZ: bool, const SLIPS: bool, const ROLLS: bool>(
    law: &PairLaw,
    batch: &mut Batch,
    (step, share): (f64, f64),
) {
    for lane in 0..LANES {
        measure::<HERTZ>(law, batch, lane);
    }
    for lane in 0..LANES {
        press_together::<HERTZ>(law, batch, lane, step);
    }
    if SLIPS {
        for lane in 0..LANES {
            turn::<HERTZ>(law, batch, lane, step);
        }
        for lane in 0..LANES {
            slip::<HERTZ>(law, batch, lane, step);
        }
    }
    if ROLLS {
        for lane in 0..LANES {
            roll::<HERTZ>(law, batch, lane, (step, share));
        }
    }
    batch.contact = batch.radius_now;
}

/// The size of a contact.
#[inline(always)]
fn measure<const HERTZ: bool>(law: &PairLaw, batch: &mut Batch, lane: usize) {
    let distance = batch.square[lane].sqrt();
    let [one, two] = [batch.balls[0].radius[lane], batch.balls[1].radius[lane]];
    let [first, second] = [batch.balls[0].mass[lane], batch.balls[1].mass[lane]];
    let overlap = one + two - distance;
    let (radius, mass) = (one * two / (one + two), first * second / (first + second));
    let contact = (radius * overlap).sqrt();
    let normal = times(1.0 / distance, at(&batch.apart, lane));
    put(&mut batch.normal, lane, normal);
    batch.root[lane] = (normal_stiffness::<HERTZ>(law, contact) * mass).sqrt();
    batch.overlap[lane] = overlap;
    batch.radius_now[lane] = contact;
}

/// Stiffness along the normal, N/m, at a radius of the contact, m.
#[inline(always)]
fn normal_stiffness<const HERTZ: bool>(law: &PairLaw, contact: f64) -> f64 {
    if HERTZ { 2.0 * law.young * contact } else { law.normal() }
}

/// The velocity at a contact and the force along its normal.
#[inline(always)]
fn press_together<const HERTZ: bool>(law: &PairLaw, batch: &mut Batch, lane: usize, step: f64) {
    let (normal, overlap) = (at(&batch.normal, lane), batch.overlap[lane]);
    let [near, far] = [0, 1].map(|side: usize| batch.balls[side].radius[lane] - 0.5 * overlap);
    let [spin, other] = [at(&batch.balls[0].spin, lane), at(&batch.balls[1].spin, lane)];
    let arms = plus(times(near, spin), times(far, other));
    let velocity = plus(at(&batch.velocity, lane), cross(normal, arms));
    let approach = -dot(velocity, normal);
    let elastic =
        if HERTZ { 4.0 / 3.0 * law.young * batch.radius_now[lane] * overlap } else { law.normal() * overlap };
    let along = larger(elastic + law.damping * batch.root[lane] * approach, 0.0);
    put(&mut batch.slip, lane, plus(velocity, times(approach, normal)));
    batch.twist[lane] = 0.5 * step * (dot(spin, normal) + dot(other, normal));
    batch.along[lane] = along;
    batch.dissipated[lane] = (along - elastic) * approach * step;
    put(&mut batch.force, lane, times(along, normal));
    put(&mut batch.torque, lane, [0.0; 3]);
}

/// The elastic force across the normal, after the contact has turned and slipped. That of before remains in
/// the memory.
#[inline(always)]
fn turn<const HERTZ: bool>(law: &PairLaw, batch: &mut Batch, lane: usize, step: f64) {
    let turned = turned(at(&batch.tangential, lane), at(&batch.normal, lane), batch.twist[lane]);
    let [contact, before] = [batch.radius_now[lane], batch.contact[lane]];
    let kept = if HERTZ { smaller(contact / larger(before, f64::MIN_POSITIVE), 1.0) } else { 1.0 };
    let slip = times(law.tangential_stiffness(contact) * step, at(&batch.slip, lane));
    put(&mut batch.elastic, lane, minus(times(kept, turned), slip));
}

/// The force across the normal, N, its part that stays, and the energy that is dissipated, J.
#[inline(always)]
fn slip<const HERTZ: bool>(law: &PairLaw, batch: &mut Batch, lane: usize, step: f64) {
    let (elastic, slip) = (at(&batch.elastic, lane), at(&batch.slip, lane));
    let force = minus(elastic, times(law.damping_across * batch.root[lane], slip));
    let size = dot(force, force).sqrt();
    let most = law.surfaces.friction * batch.along[lane];
    let slides = size > most;
    let scale = if slides { most / size } else { 1.0 };
    let force = times(scale, force);
    let stays = either(slides, force, elastic);
    let history = at(&batch.tangential, lane);
    let stored = |spring: Vector, contact: f64| {
        // The stiffness of Hooke's law is one for all.
        let stiffness =
            if HERTZ { larger(law.tangential_stiffness(contact), f64::MIN_POSITIVE) } else { 1.0 };
        0.5 * dot(spring, spring) / stiffness
    };
    let [now, before] = [stored(stays, batch.radius_now[lane]), stored(history, batch.contact[lane])];
    let gained = if HERTZ { now - before } else { (now - before) * law.softness_across };
    batch.dissipated[lane] += -step * dot(force, slip) - gained;
    put(&mut batch.tangential, lane, stays);
    let all = plus(at(&batch.force, lane), force);
    put(&mut batch.force, lane, all);
    let torque = cross(force, at(&batch.normal, lane));
    put(&mut batch.torque, lane, torque);
}

/// The moments against rolling and twisting.
#[inline(always)]
fn roll<const HERTZ: bool>(law: &PairLaw, batch: &mut Batch, lane: usize, (step, share): (f64, f64)) {
    let [one, two] = [batch.balls[0].radius[lane], batch.balls[1].radius[lane]];
    let [first, second] = [batch.balls[0].mass[lane], batch.balls[1].mass[lane]];
    let [inert, inertial] = [first * one * one, second * two * two];
    let inertia = (share + 1.0) * (inert * inertial / (inert + inertial));
    let rate = minus(at(&batch.balls[0].spin, lane), at(&batch.balls[1].spin, lane));
    let before = (at(&batch.rolling, lane), batch.twisting[lane]);
    let contact = batch.radius_now[lane];
    let of = Pressed {
        normal: at(&batch.normal, lane),
        radius: one * two / (one + two),
        along: batch.along[lane],
        stiffness: normal_stiffness::<HERTZ>(law, contact),
        before: normal_stiffness::<HERTZ>(law, batch.contact[lane]),
    };
    let (moment, history, lost) = turning(law, &of, before, (rate, batch.twist[lane], inertia), step);
    put(&mut batch.rolling, lane, history.0);
    batch.twisting[lane] = history.1;
    put(&mut batch.moment, lane, moment);
    batch.dissipated[lane] += lost;
}

/// Lengths of a contact, m, and its force along the normal.
struct Pressed {
    normal: Vector,
    /// Reduced radius, m.
    radius: f64,
    /// N, and the stiffness along the normal now and before, N/m.
    along: f64,
    stiffness: f64,
    before: f64,
}

/// The moment of rolling and twisting on the first, N m, the elastic parts that stay, and the energy that is
/// dissipated, J. `rate`: angular velocity of the first over that of the second, rad/s.
#[inline(always)]
fn turning(
    law: &PairLaw,
    of: &Pressed,
    (rolling, twisting): (Vector, f64),
    (rate, twist, inertia): (Vector, f64, f64),
    step: f64,
) -> (Vector, (Vector, f64), f64) {
    let [roll, spin] = [law.surfaces.rolling_friction, law.surfaces.twisting_friction];
    let spring = |normal: f64, share: f64| 2.25 * normal * (share * of.radius) * (share * of.radius);
    let damped = |stiffness: f64| 2.0 * law.surfaces.rolling_damping * (inertia * stiffness).sqrt();

    let [stiffness, earlier] = [spring(of.stiffness, roll), spring(of.before, roll)];
    let flat = across(rate, of.normal);
    let elastic = minus(turned(rolling, of.normal, twist), times(stiffness * step, flat));
    let (size, most) = (dot(elastic, elastic).sqrt(), roll * of.radius * of.along);
    let yields = size > most;
    let stays = times(if yields { most / size } else { 1.0 }, elastic);
    let moment = minus(stays, times(if yields { 0.0 } else { damped(stiffness) }, flat));
    let stored = |spring: f64, stiffness: f64| 0.5 * spring / larger(stiffness, f64::MIN_POSITIVE);
    let mut lost = -step * dot(moment, flat)
        - (stored(dot(stays, stays), stiffness) - stored(dot(rolling, rolling), earlier));

    let [stiffness, earlier] = [spring(of.stiffness, spin), spring(of.before, spin)];
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

#[inline(always)]
fn either(first: bool, one: Vector, two: Vector) -> Vector {
    let of = |axis: usize| if first { one[axis] } else { two[axis] };
    [of(0), of(1), of(2)]
}
