//! Friction and damping of contacts between elements, and their histories.

use fdem_distributed::wire;
use serde::{Deserialize, Serialize};

use crate::bodies::Bodies;
use crate::bodies::elements::{completed, velocity_at};
use crate::contacts::law::ContactLaw;
use crate::contacts::pair::{BatchWorks, Overlap};
use crate::contacts::places::HistoryBatch;
use crate::lanes::{LANES, Lanes, Rows, compiled_for_vectors, larger, row, rows, set_row, smaller};
use crate::simplex::{Interactions, Shapes, Simplex};
use crate::vector::{Point, add, dot, minus, plus};

/// History of friction and damping of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [f64; N]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [f64; N]: Deserialize<'de>"
))]
pub(crate) struct Grip<const D: usize, const N: usize> {
    /// Friction on the first element, N.
    pub(super) friction: Point<D>,
    /// Damping on the first element, N.
    pub(super) damping: Point<D>,
    /// Barycentric coordinates, in both elements, of the point where the force acted, without the first,
    /// which is 1 less the others.
    pub(super) shares: [[f64; D]; 2],
    /// Initial potential energy, J, which is not counted: see [`count_from`].
    pub(super) credited_energy: f64,
    /// How: the number of an [`Overlap`].
    pub(super) way: u8,
    /// Force on the first element, N, for results.
    pub(crate) push: Point<D>,
}

wire!([const D: usize, const N: usize] Grip<D, N> { friction, damping, shares, credited_energy, way, push });

impl<const D: usize, const N: usize> Grip<D, N> {
    /// This history without a force: a resumed run has none before its first step.
    pub(crate) fn without_push(self) -> Self {
        Self { push: [0.0; D], ..self }
    }

    /// Work against friction and damping, J, in the second half of the step in which they acted. `rate`: of
    /// the first element against the second, where the force acted, m/s.
    #[inline(always)]
    fn second_half(&self, rate: Point<D>, step: f64) -> [f64; 2] {
        [-0.5 * step * dot(self.friction, rate), -0.5 * step * dot(self.damping, rate)]
    }

    /// The same for two elements of some bodies.
    pub(super) fn last_works(
        &self,
        bodies: &impl Bodies<D, Place = [f64; D]>,
        [one, other]: [u32; 2],
        step: f64,
    ) -> [f64; 2] {
        let [at_one, at_other] = &self.shares;
        self.second_half(minus(bodies.velocity_on(one, at_one), bodies.velocity_on(other, at_other)), step)
    }
}

/// Histories of a batch of couples.
#[derive(Clone, Debug)]
pub(crate) struct Grips<const D: usize, const N: usize> {
    friction: [Lanes; D],
    damping: [Lanes; D],
    shares: [[Lanes; D]; 2],
    credited_energy: Lanes,
    way: Lanes,
    push: [Lanes; D],
}

impl<const D: usize, const N: usize> HistoryBatch for Grips<D, N> {
    type History = Grip<D, N>;

    const NONE: Self = Self {
        friction: [Lanes::ZERO; D],
        damping: [Lanes::ZERO; D],
        shares: [[Lanes::ZERO; D]; 2],
        credited_energy: Lanes::ZERO,
        way: Lanes::ZERO,
        push: [Lanes::ZERO; D],
    };
    const NEW: Grip<D, N> = Grip {
        friction: [0.0; D],
        damping: [0.0; D],
        shares: [[0.0; D]; 2],
        credited_energy: 0.0,
        way: 0,
        push: [0.0; D],
    };

    #[inline(always)]
    fn get(&self, lane: usize) -> Grip<D, N> {
        Grip {
            friction: row(&self.friction, lane),
            damping: row(&self.damping, lane),
            shares: std::array::from_fn(|side| row(&self.shares[side], lane)),
            credited_energy: self.credited_energy.get(lane),
            way: self.way.get(lane) as u8,
            push: row(&self.push, lane),
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, grip: &Grip<D, N>) {
        set_row(&mut self.friction, lane, &grip.friction);
        set_row(&mut self.damping, lane, &grip.damping);
        for side in 0..2 {
            set_row(&mut self.shares[side], lane, &grip.shares[side]);
        }
        self.credited_energy.set(lane, grip.credited_energy);
        self.way.set(lane, f64::from(grip.way));
        set_row(&mut self.push, lane, &grip.push);
    }
}

/// Inputs of friction and damping for a batch of couples, besides their histories and shapes.
pub(super) struct ContactInputs<const D: usize, const N: usize> {
    pub(super) velocities: [Rows<D, N>; 2],
    /// Share of the forces that acts, while a joint between the two elements carries the rest, and the
    /// increase of this share in the last step.
    pub(super) weight: Lanes,
    pub(super) fading: Lanes,
    /// The number of each [`Overlap`].
    pub(super) initial: Lanes,
    /// Mean masses of the nodes of the elements, kg, and the contact length, m.
    pub(super) masses: [Lanes; 2],
    pub(super) length: Lanes,
    /// The numbers of [`ContactLaw`], and which of all laws each is.
    penalty: Lanes,
    friction: Lanes,
    tangential: Lanes,
    damping: Lanes,
    laws: [usize; LANES],
    /// Time step, s.
    step: f64,
    /// Ignored energy of an overlap that relaxes over that before the step.
    still_ignored: f64,
}

impl<const D: usize, const N: usize> ContactInputs<D, N> {
    /// Memory for a batch. `step`: time step, s; `still_ignored`: see [`ContactLaws::still_ignored`].
    pub(super) const fn new(step: f64, still_ignored: f64) -> Self {
        Self {
            velocities: [[[Lanes::ZERO; D]; N]; 2],
            weight: Lanes::ZERO,
            fading: Lanes::ZERO,
            initial: Lanes::ZERO,
            masses: [Lanes::ZERO; 2],
            length: Lanes::ZERO,
            penalty: Lanes::ZERO,
            friction: Lanes::ZERO,
            tangential: Lanes::ZERO,
            damping: Lanes::ZERO,
            laws: [usize::MAX; LANES],
            step,
            still_ignored,
        }
    }

    /// Sets the law of a couple. Most couples have that of the one before in this lane.
    #[inline]
    pub(super) fn set_law(&mut self, lane: usize, number: usize, laws: &[ContactLaw]) {
        if self.laws[lane] != number {
            let law = &laws[number];
            self.penalty.set(lane, law.penalty);
            self.friction.set(lane, law.friction);
            self.tangential.set(lane, law.tangential);
            self.damping.set(lane, law.damping);
            self.laws[lane] = number;
        }
    }
}

/// Forces of a batch: `scale` times those of the potential for a penalty of 1, and `along` at the points with
/// these barycentric coordinates. `slope`: the share of the depth that counts.
struct BatchForces<const D: usize, const N: usize> {
    scale: Lanes,
    slope: Lanes,
    along: [Lanes; D],
    shares: [[Lanes; N]; 2],
}

/// Computes friction and damping of a batch of couples that overlap, and adds them to the forces of their
/// potentials.
#[inline(always)]
fn grip_all<const D: usize, const N: usize>(
    shapes: &Shapes<D, N>,
    given: &ContactInputs<D, N>,
    found: &mut Interactions<D, N>,
    grips: &mut Grips<D, N>,
    works: &mut BatchWorks,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut forces = BatchForces {
        scale: Lanes::ZERO,
        slope: Lanes::ZERO,
        along: [Lanes::ZERO; D],
        shares: [[Lanes::ZERO; N]; 2],
    };
    for lane in 0..LANES {
        grip_one(lane, shapes, given, found, grips, works, &mut forces);
    }
    let BatchForces { scale, slope, along, shares } = &forces;
    for lane in 0..LANES {
        // An overlap that was there before any force does not show that contacts are soft.
        let deep = found.deep.get(lane);
        found.deep.set(lane, if slope.get(lane) > 0.5 { deep } else { 0.0 });
    }
    for corner in 0..N {
        for axis in 0..D {
            for lane in 0..LANES {
                let force = &mut found.forces[0][corner][axis];
                let more = shares[0][corner].get(lane) * along[axis].get(lane);
                force.set(lane, scale.get(lane) * force.get(lane) + more);
            }
            for lane in 0..LANES {
                let force = &mut found.forces[1][corner][axis];
                let more = shares[1][corner].get(lane) * along[axis].get(lane);
                force.set(lane, scale.get(lane) * force.get(lane) - more);
            }
        }
    }
}

compiled_for_vectors!(pub(super) fn grip_of = grip_all<const D: usize, const N: usize>(
    shapes: &Shapes<D, N>,
    given: &ContactInputs<D, N>,
    found: &mut Interactions<D, N>,
    grips: &mut Grips<D, N>,
    works: &mut BatchWorks
) where [[f64; D]; N]: Simplex<D, N>);

/// Computes friction and damping of one couple of a batch. Twin: `grip_one` in
/// `crates/gpu/kernels/contact.h`.
#[inline(always)]
#[allow(
    clippy::needless_bitwise_bool,
    reason = "a lazy operator is a branch, of which the compiler makes no vectors"
)]
fn grip_one<const D: usize, const N: usize>(
    lane: usize,
    shapes: &Shapes<D, N>,
    given: &ContactInputs<D, N>,
    found: &Interactions<D, N>,
    grips: &mut Grips<D, N>,
    works: &mut BatchWorks,
    forces: &mut BatchForces<D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let velocities = [rows(&given.velocities[0], lane), rows(&given.velocities[1], lane)];
    let before: Grip<D, N> = grips.get(lane);
    let step = given.step;
    let one = velocity_at(&velocities[0], &completed(&before.shares[0]));
    let other = velocity_at(&velocities[1], &completed(&before.shares[1]));
    let [mut friction_work, mut damping_work] = before.second_half(minus(one, other), step);
    let [penalty, weight] = [given.penalty.get(lane), given.weight.get(lane)];
    let potential = penalty * found.energy(lane);
    let initial = given.initial.get(lane);
    let way = if initial > 0.0 { initial } else { f64::from(before.way) };
    let relaxes = way >= f64::from(Overlap::Relaxing as u8);
    let ignored = smaller(before.credited_energy, potential);
    let still_ignored = if relaxes { given.still_ignored * before.credited_energy } else { ignored };
    let credited_energy = if initial > 0.0 { potential } else { smaller(still_ignored, potential) };
    let of_bodies = count_beyond(credited_energy, potential);
    // The ignored energy falls at this position, in the middle of the motion: half of the step has the force
    // before, half the force after. Otherwise the works would have an error of the first order.
    let goes_on = relaxes & (initial == 0.0);
    let of_bodies_before = count_beyond(ignored, potential);
    let relaxed = if goes_on { of_bodies.0 - of_bodies_before.0 } else { 0.0 };
    let slope_before = if goes_on { of_bodies_before.1 } else { of_bodies.1 };
    let of_joint = count_from(credited_energy, potential);
    let is_initial = way >= f64::from(Overlap::Ignored as u8);
    let energy = if is_initial { of_bodies.0 } else { of_joint.0 };
    let slope = if is_initial { 0.5 * (slope_before + of_bodies.1) } else { of_joint.1 };
    let scale = penalty * weight * slope;
    let mut push = [0.0; D];
    for corner in 0..N {
        for axis in 0..D {
            push[axis] += scale * found.forces[0][corner][axis].get(lane);
        }
    }
    let point = row(&found.point, lane);
    let one = rows::<D, N>(&shapes[0], lane).coordinates(point);
    let other = rows::<D, N>(&shapes[1], lane).coordinates(point);
    let rate = minus(velocity_at(&velocities[0], &one), velocity_at(&velocities[1], &other));
    let size = dot(push, push).sqrt();
    let (coefficient, ratio) = (given.friction.get(lane), given.damping.get(lane));
    // Couples that separate have only the works of their last forces.
    let touches = (size > 0.0) & (found.energy(lane) > 0.0);
    let per_size = 1.0 / size;
    let axes = <[[f64; D]; N]>::axes_around(push.map(|x| per_size * x));
    let normal = axes[0];
    let long = given.length.get(lane);
    let [m, n] = [given.masses[0].get(lane), given.masses[1].get(lane)];
    let critical = 2.0 * (penalty * long * m * n / (m + n)).sqrt();
    // At most the force that presses the two apart, so that they do not stick.
    let damping = larger(smaller(-ratio * weight * critical * dot(rate, normal), size), -size);
    let damping = if touches & (ratio > 0.0) { damping } else { 0.0 };
    let damped: Point<D> = std::array::from_fn(|axis| if touches { damping * normal[axis] } else { 0.0 });
    // In the directions along the surface, as these are now.
    let slip = weight * given.tangential.get(lane) * long * step;
    let mut trial = [0.0; D];
    for k in 1..D {
        trial[k] = dot(before.friction, axes[k]) - slip * dot(rate, axes[k]);
    }
    let (tried, limit) = (dot(trial, trial).sqrt(), coefficient * (size + damping));
    let kept = limit / tried;
    let held = trial.map(|x| if tried > limit { kept * x } else { x });
    let mut along = [0.0; D];
    for k in 1..D {
        add(&mut along, axes[k], held[k]);
    }
    let friction: Point<D> =
        std::array::from_fn(|axis| if touches & (coefficient > 0.0) { along[axis] } else { 0.0 });
    friction_work -= 0.5 * step * dot(friction, rate);
    damping_work -= 0.5 * step * dot(damped, rate);
    let both = plus(friction, damped);
    let shares = [rest_of(&one), rest_of(&other)];
    grips.set(
        lane,
        &Grip { friction, damping: damped, shares, credited_energy, way: way as u8, push: plus(push, both) },
    );
    let handed_over = given.fading.get(lane) * energy;
    set_row(works, lane, &[weight * energy, friction_work, damping_work, handed_over, weight * relaxed]);
    forces.scale.set(lane, scale);
    forces.slope.set(lane, slope);
    set_row(&mut forces.along, lane, &both);
    set_row(&mut forces.shares[0], lane, &one);
    set_row(&mut forces.shares[1], lane, &other);
}

/// Counted part of the potential energy `U`, J, and its derivative by `U`, if the energy `U₀`
/// (`credited_energy`) was there before the two elements could touch.
///
/// Elements that were connected until a joint at their vertex broke overlap by the sliding of that joint.
/// Counting this overlap immediately would create energy. `(U - U₀)² / U` begins without energy and without
/// force, and its ratio to `U` tends to 1. When `U` falls below `U₀`, the caller lowers `U₀` to `U`.
#[inline(always)]
fn count_from(credited_energy: f64, potential: f64) -> (f64, f64) {
    let share = credited_energy / potential;
    let counted = (potential * (1.0 - share) * (1.0 - share), 1.0 - share * share);
    let counts = potential > credited_energy;
    (if counts { counted.0 } else { 0.0 }, if counts { counted.1 } else { 0.0 })
}

/// The same for elements of bodies that overlap at the beginning of a run or of a stage:
/// [`InitialOverlap`](crate::InitialOverlap).
///
/// The overlap may be deep, where `(U - U₀)² / U` is up to four times as stiff as `U`. `(√U - √U₀)²` is as
/// stiff as `U`: where `U` is the energy of a spring that is compressed by `x`, it is that of one compressed
/// by `x - x₀`.
#[inline(always)]
fn count_beyond(credited_energy: f64, potential: f64) -> (f64, f64) {
    let rest = 1.0 - (credited_energy / potential).sqrt();
    let counts = potential > credited_energy;
    (if counts { potential * rest * rest } else { 0.0 }, if counts { rest } else { 0.0 })
}

/// Barycentric coordinates without the first, which is 1 less the others.
#[inline(always)]
fn rest_of<const D: usize, const N: usize>(all: &[f64; N]) -> [f64; D] {
    std::array::from_fn(|k| all[k + 1])
}
