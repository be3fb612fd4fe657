//! Forces between two elements in contact: potential, friction, damping.
//!
//! Couples are computed in batches: those that no facet parts are told from the others, then the forces of their potentials are computed, then friction and damping.

use serde::{Deserialize, Serialize};

use crate::contacts::{AHEAD, Couple, skipped_until};
use crate::joints::Joints;
use crate::lanes::{LANES, Lanes, Rows, compiled_for_vectors, larger, row, rows, set_row, set_rows, smaller};
use crate::model::Model;
use crate::simplex::{Interactions, Shapes, Simplex, apart, gap, parted};
use crate::solid::Solid;
use crate::vector::{Point, add, dot, length};

/// Number of batches whose potentials are computed together.
const GROUP: usize = 4;

/// Energy of a contact, and works since the last pass, J.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Works {
    pub(super) energy: f64,
    pub(super) friction: f64,
    pub(super) damping: f64,
    pub(super) handed_over: f64,
}

/// History of friction and damping of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [f64; N]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [f64; N]: Deserialize<'de>"
))]
pub(super) struct Grip<const D: usize, const N: usize> {
    /// Friction on the first element, N.
    pub(super) friction: Point<D>,
    /// Damping on the first element, N.
    damping: Point<D>,
    /// Barycentric coordinates, in both elements, of the point where the force acted, without the first, which is 1 less the others.
    shares: [[f64; D]; 2],
    /// Initial potential energy, J, which is not counted: see [`count_from`].
    credited_energy: f64,
    /// Force on the first element, N, for results.
    pub(super) push: Point<D>,
}

impl<const D: usize, const N: usize> Grip<D, N> {
    const NONE: Self = Self {
        friction: [0.0; D],
        damping: [0.0; D],
        shares: [[0.0; D]; 2],
        credited_energy: 0.0,
        push: [0.0; D],
    };

    /// This history without a force: a resumed run tells none before its first step.
    pub(super) fn without_push(self) -> Self {
        Self { push: [0.0; D], ..self }
    }

    /// Work against friction and damping, J, in the second half of the step in which they acted.
    #[inline(always)]
    fn second_half(&self, velocities: &[[Point<D>; N]; 2], step: f64) -> [f64; 2] {
        let rate = relative_velocity(velocities, &self.shares);
        [-0.5 * step * dot(self.friction, rate), -0.5 * step * dot(self.damping, rate)]
    }
}

/// Contact parameters of two materials.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    /// Penalty times thickness: N/m in two dimensions, Pa in three.
    penalty: f64,
    friction: f64,
    /// Tangential stiffness, likewise.
    tangential: f64,
    /// Share of critical damping.
    damping: f64,
}

/// Parameters of contacts between two materials.
pub(super) fn law<const D: usize, const N: usize>(model: &Model<D, N>, a: u32, b: u32) -> Law {
    let interface = model.interface(a, b);
    let [one, two] = [a, b].map(|material| &model.materials[material as usize]);
    let penalty = interface
        .and_then(|interface| interface.penalty)
        .unwrap_or(model.contact.penalty * one.youngs_modulus.min(two.youngs_modulus))
        * model.thickness;
    let friction = interface.map_or(one.friction.min(two.friction), |interface| interface.friction);
    Law {
        penalty,
        friction,
        tangential: model.contact.tangential_stiffness * penalty,
        damping: model.contact.damping,
    }
}

/// Penalty of contacts between two materials, Pa, and their coefficient of friction.
pub(crate) fn penalty_and_friction<const D: usize, const N: usize>(
    model: &Model<D, N>,
    [a, b]: [u32; 2],
) -> [f64; 2] {
    let law = law(model, a, b);
    [law.penalty / model.thickness, law.friction]
}

/// Upper bound of the stiffness, N/m, that a contact over facet `k` of an element of this material has at each vertex of the facet.
pub(crate) fn stiffness<const D: usize, const N: usize>(
    model: &Model<D, N>,
    corners: &[Point<D>; N],
    k: usize,
    material: u32,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let penalty = (0..model.materials.len() as u32)
        .map(|other| law(model, material, other).penalty)
        .fold(0.0_f64, f64::max);
    let measure = <[[f64; D]; N]>::facet_measure(&<[[f64; D]; N]>::FACETS[k].map(|corner| corners[corner]));
    // φ grows by N over the height. A part of 1/D of the pressure on the facet goes to each vertex. Each of the two elements presses the other: factor 2.
    let normal = N as f64 * penalty / corners.height(k) * (1.0 / D as f64) * measure;
    let length = <[[f64; D]; N]>::contact_length(corners.measure());
    2.0 * normal.max(model.contact.tangential_stiffness * penalty * length)
}

/// A couple whose forces are computed.
#[derive(Clone, Copy)]
struct Member {
    /// Its number in the chunk.
    couple: u32,
    /// Share of the forces that acts, while a joint between the two elements carries the rest, and the increase of this share in the last step.
    weight: f64,
    fading: f64,
}

impl Member {
    const NONE: Self = Self { couple: 0, weight: 0.0, fading: 0.0 };
}

/// Forces of a chunk of couples.
#[derive(Debug)]
pub(super) struct Pressed<const D: usize, const N: usize> {
    /// Those of the couples that touch, in the order of their histories.
    pub(super) pushes: Vec<Push<D, N>>,
    /// Couples of the chunk that have separated in this pass, ascending, with the works of their last forces.
    pub(super) separated: Vec<(u32, Works)>,
}

impl<const D: usize, const N: usize> Default for Pressed<D, N> {
    fn default() -> Self {
        Self { pushes: Vec::new(), separated: Vec::new() }
    }
}

/// Forces of a couple that touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push<const D: usize, const N: usize> {
    /// Forces of potential, damping and friction on the corners of both elements, N.
    pub(super) forces: [[Point<D>; N]; 2],
    pub(super) works: Works,
    pub(super) deep: bool,
}

/// What the forces of all couples depend on in this pass.
pub(super) struct Pass<'a, const D: usize, const N: usize> {
    pub(super) solid: &'a Solid<D, N>,
    pub(super) joints: &'a Joints<D>,
    /// Parameters of the contacts of each pair of materials, and the number of materials.
    pub(super) laws: &'a [Law],
    pub(super) materials: usize,
    /// Time step, s.
    pub(super) step: f64,
    /// Distance that nodes have travelled since the beginning, m.
    pub(super) travel: f64,
}

impl<const D: usize, const N: usize> Pass<'_, D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Computes the forces of a chunk of couples. `grips`: the histories of those that touch.
    pub(super) fn press(
        &self,
        couples: &mut [Couple],
        grips: &mut Vec<Grip<D, N>>,
        pressed: &mut Pressed<D, N>,
    ) {
        pressed.pushes.clear();
        pressed.separated.clear();
        // Mostly, bodies do not touch anywhere near.
        if couples.iter().all(|couple| couple.apart_until > self.travel) {
            return;
        }
        let before = std::mem::replace(grips, Vec::with_capacity(grips.len()));
        let mut histories = Histories { before: &before, grips, pressed };
        let mut work = Work::<D, N>::new();
        // Couples that are looked at together, and those that no facet parts.
        let mut near = [Member::NONE; LANES];
        let mut group = [Member::NONE; GROUP * LANES];
        let (mut looked, mut count) = (0, 0);
        for number in 0..couples.len() {
            if let Some(next) = couples.get(number + AHEAD)
                && next.apart_until <= self.travel
            {
                next.prefetch(self.solid);
            }
            let couple = &mut couples[number];
            if couple.apart_until <= self.travel {
                let joint = self.joints.all.get(couple.joint as usize);
                // A detached joint did not press its elements apart: their overlap now must not count at once.
                couple.initial_overlap |=
                    joint.is_some_and(|joint| joint.fading > 0.0 && joint.detached != [false; D]);
                let [weight, fading] = joint.map_or([1.0, 0.0], |joint| [joint.faded, joint.fading]);
                let member = Member { couple: number as u32, weight, fading };
                // Most couples that touched still do.
                let (shapes, lane) = if couple.touches && weight > 0.0 {
                    group[count] = member;
                    count += 1;
                    (&mut work.shapes[(count - 1) / LANES], (count - 1) % LANES)
                } else {
                    near[looked] = member;
                    looked += 1;
                    (&mut work.near, looked - 1)
                };
                for (shape, element) in shapes.iter_mut().zip(couple.elements) {
                    set_rows(shape, lane, &self.solid.shape(element));
                }
            }
            let is_last = number + 1 == couples.len();
            if looked == LANES || is_last {
                self.choose(&near[..looked], &mut work, couples, &mut group, &mut count, &mut histories);
                looked = 0;
            }
            if count + LANES >= group.len() || is_last {
                self.press_group(&group[..count], &mut work, couples, &mut histories);
                count = 0;
            }
        }
        pressed.separated.sort_unstable_by_key(|(couple, _)| *couple);
    }

    /// Takes the couples that no facet parts into the group.
    fn choose(
        &self,
        near: &[Member],
        work: &mut Work<D, N>,
        couples: &mut [Couple],
        group: &mut [Member],
        count: &mut usize,
        histories: &mut Histories<'_, D, N>,
    ) {
        if near.is_empty() {
            return;
        }
        let mut distances = Lanes::ZERO;
        distances_of::<D, N>(self.solid.available, &work.near, &mut distances);
        for (lane, member) in near.iter().enumerate() {
            // While the joint carries the whole load, the gap says nothing about when contact begins: the couple must not be skipped.
            let distance = if member.weight > 0.0 { distances.get(lane) } else { 0.0 };
            if distance >= 0.0 {
                self.separate(couples, member, distance, histories);
                continue;
            }
            for (to, from) in work.shapes[*count / LANES].iter_mut().zip(&work.near) {
                set_rows(to, *count % LANES, &rows(from, lane));
            }
            group[*count] = *member;
            *count += 1;
        }
    }

    /// Computes the forces of a group of couples, whose shapes are in `work`.
    fn press_group(
        &self,
        group: &[Member],
        work: &mut Work<D, N>,
        couples: &mut [Couple],
        histories: &mut Histories<'_, D, N>,
    ) {
        if group.is_empty() {
            return;
        }
        let solid = self.solid;
        work.clear(group.len());
        let Work { shapes, found, scratch, batch, .. } = work;
        let count = group.len().div_ceil(LANES);
        <[[f64; D]; N]>::interactions(solid.available, &shapes[..count], scratch, &mut found[..count]);
        for (members, (shapes, found)) in group.chunks(LANES).zip(shapes.iter().zip(found)) {
            for (lane, member) in members.iter().enumerate() {
                let couple = &couples[member.couple as usize];
                let pair = couple.elements.map(|element| &solid.elements[element as usize]);
                let law = &self.laws[pair[0].material as usize * self.materials + pair[1].material as usize];
                let velocities = couple.elements.map(|element| self.velocities(element));
                let masses = pair.map(|element| element.mass);
                let length = smaller(pair[0].length, pair[1].length);
                batch.take(lane, law, histories.before(couple), &velocities, masses, length);
                batch.weight.set(lane, member.weight);
                batch.fading.set(lane, member.fading);
                batch.initial.set(lane, f64::from(u8::from(couple.initial_overlap)));
            }
            grip_of::<D, N>(solid.available, shapes, found, batch, self.step);
            for (lane, member) in members.iter().enumerate() {
                if found.energy.get(lane) <= 0.0 {
                    // They touch, or are apart with an edge of each nearest to the other.
                    let [a, b] = [0, 1].map(|side| rows(&shapes[side], lane));
                    self.separate(couples, member, a.distance(&b, 0.0), histories);
                    continue;
                }
                let couple = &mut couples[member.couple as usize];
                couple.initial_overlap = false;
                couple.touches = true;
                couple.slot = histories.grips.len() as u16;
                histories.grips.push(batch.grip(lane));
                histories.pressed.pushes.push(Push {
                    forces: [0, 1].map(|side| rows(&found.forces[side], lane)),
                    works: batch.works(lane),
                    deep: found.deep.get(lane) > 0.0,
                });
            }
        }
    }

    /// Notes that the elements of a couple are at least this far apart, m, and counts the works of its last forces.
    fn separate(
        &self,
        couples: &mut [Couple],
        member: &Member,
        distance: f64,
        histories: &mut Histories<'_, D, N>,
    ) {
        let couple = &mut couples[member.couple as usize];
        couple.initial_overlap = false;
        couple.apart_until = skipped_until(self.travel, distance);
        if couple.touches {
            let velocities = couple.elements.map(|element| self.velocities(element));
            let [friction, damping] = histories.before(couple).second_half(&velocities, self.step);
            couple.touches = false;
            let works = Works { friction, damping, ..Works::default() };
            histories.pressed.separated.push((member.couple, works));
        }
    }

    /// Velocities of the corners of an element, m/s.
    #[inline]
    fn velocities(&self, element: u32) -> [Point<D>; N] {
        self.solid.nodes_of(element).map(|node| self.solid.nodes[node as usize].velocity)
    }
}

/// The histories of the couples of a chunk that touched before, and those of couples that touch now with their forces.
struct Histories<'a, const D: usize, const N: usize> {
    before: &'a [Grip<D, N>],
    grips: &'a mut Vec<Grip<D, N>>,
    pressed: &'a mut Pressed<D, N>,
}

impl<const D: usize, const N: usize> Histories<'_, D, N> {
    /// The history of a couple.
    #[inline]
    fn before(&self, couple: &Couple) -> &Grip<D, N> {
        if couple.touches { &self.before[couple.slot as usize] } else { const { &Grip::NONE } }
    }
}

/// Memory for a group of couples.
struct Work<const D: usize, const N: usize>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Shapes of the couples that are looked at, and of those of the group.
    near: Shapes<D, N>,
    shapes: [Shapes<D, N>; GROUP],
    found: [Interactions<D, N>; GROUP],
    scratch: <[[f64; D]; N] as Simplex<D, N>>::Scratch,
    batch: Batch<D, N>,
}

impl<const D: usize, const N: usize> Work<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn new() -> Self {
        Self {
            shapes: [[[[Lanes::ZERO; D]; N]; 2]; GROUP],
            near: [[[Lanes::ZERO; D]; N]; 2],
            found: [const { Interactions::NONE }; GROUP],
            scratch: Default::default(),
            batch: Batch::NONE,
        }
    }

    /// Clears the shapes of all couples from this one on: they cost nothing then.
    fn clear(&mut self, count: usize) {
        for k in count..count.next_multiple_of(LANES) {
            for shape in &mut self.shapes[k / LANES] {
                set_rows(shape, k % LANES, &[[0.0; D]; N]);
            }
        }
    }
}

/// Lower bounds of the distances of a batch of couples.
#[inline(always)]
fn all_distances<const D: usize, const N: usize>(shapes: &Shapes<D, N>, distances: &mut Lanes)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        distances.set(lane, gap(&rows(&shapes[0], lane), &rows(&shapes[1], lane)));
    }
    for side in 0..2 {
        for lane in 0..LANES {
            let parted = parted::<D, N>(&rows(&shapes[side], lane), &rows(&shapes[1 - side], lane));
            distances.set(lane, larger(distances.get(lane), parted));
        }
    }
}

compiled_for_vectors!(fn distances_of = all_distances<const D: usize, const N: usize>(shapes: &Shapes<D, N>, distances: &mut Lanes)
    where [[f64; D]; N]: Simplex<D, N>);

/// Friction and damping of a batch of couples: what they depend on, and their results.
struct Batch<const D: usize, const N: usize> {
    velocities: [Rows<D, N>; 2],
    /// Parameters of [`Law`].
    penalty: Lanes,
    coefficient: Lanes,
    tangential: Lanes,
    ratio: Lanes,
    /// Those of [`Member`].
    weight: Lanes,
    fading: Lanes,
    /// 1 where the overlap of now must not count at once, else 0.
    initial: Lanes,
    /// Mean masses of the nodes of the elements, kg, and the contact length, m.
    masses: [Lanes; 2],
    length: Lanes,
    /// The history: that of the pass before, then that of this one.
    friction: [Lanes; D],
    damping: [Lanes; D],
    shares: [[Lanes; D]; 2],
    credited_energy: Lanes,
    push: [Lanes; D],
    /// The numbers of [`Works`].
    works: [Lanes; 4],
}

impl<const D: usize, const N: usize> Batch<D, N> {
    const NONE: Self = Self {
        velocities: [[[Lanes::ZERO; D]; N]; 2],
        penalty: Lanes::ZERO,
        coefficient: Lanes::ZERO,
        tangential: Lanes::ZERO,
        ratio: Lanes::ZERO,
        weight: Lanes::ZERO,
        fading: Lanes::ZERO,
        initial: Lanes::ZERO,
        masses: [Lanes::ZERO; 2],
        length: Lanes::ZERO,
        friction: [Lanes::ZERO; D],
        damping: [Lanes::ZERO; D],
        shares: [[Lanes::ZERO; D]; 2],
        credited_energy: Lanes::ZERO,
        push: [Lanes::ZERO; D],
        works: [Lanes::ZERO; 4],
    };

    /// Takes a couple into a lane.
    #[inline]
    fn take(
        &mut self,
        lane: usize,
        law: &Law,
        grip: &Grip<D, N>,
        velocities: &[[Point<D>; N]; 2],
        masses: [f64; 2],
        length: f64,
    ) {
        for side in 0..2 {
            set_rows(&mut self.velocities[side], lane, &velocities[side]);
            self.masses[side].set(lane, masses[side]);
            set_row(&mut self.shares[side], lane, &grip.shares[side]);
        }
        self.penalty.set(lane, law.penalty);
        self.coefficient.set(lane, law.friction);
        self.tangential.set(lane, law.tangential);
        self.ratio.set(lane, law.damping);
        self.length.set(lane, length);
        set_row(&mut self.friction, lane, &grip.friction);
        set_row(&mut self.damping, lane, &grip.damping);
        self.credited_energy.set(lane, grip.credited_energy);
    }

    #[inline]
    fn grip(&self, lane: usize) -> Grip<D, N> {
        Grip {
            friction: row(&self.friction, lane),
            damping: row(&self.damping, lane),
            shares: [0, 1].map(|side| row(&self.shares[side], lane)),
            credited_energy: self.credited_energy.get(lane),
            push: row(&self.push, lane),
        }
    }

    #[inline]
    fn works(&self, lane: usize) -> Works {
        let [energy, friction, damping, handed_over] = row(&self.works, lane);
        Works { energy, friction, damping, handed_over }
    }
}

/// Computes friction and damping of a batch of couples that overlap, and adds them to the forces of their potentials.
#[inline(always)]
fn grip_all<const D: usize, const N: usize>(
    shapes: &Shapes<D, N>,
    found: &mut Interactions<D, N>,
    batch: &mut Batch<D, N>,
    step: f64,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    for lane in 0..LANES {
        grip_one(lane, shapes, found, batch, step);
    }
}

compiled_for_vectors!(fn grip_of = grip_all<const D: usize, const N: usize>(
    shapes: &Shapes<D, N>,
    found: &mut Interactions<D, N>,
    batch: &mut Batch<D, N>,
    step: f64
) where [[f64; D]; N]: Simplex<D, N>);

/// Computes one couple of a batch.
#[inline(always)]
#[allow(
    clippy::needless_bitwise_bool,
    reason = "a lazy operator is a branch, of which the compiler makes no vectors"
)]
fn grip_one<const D: usize, const N: usize>(
    lane: usize,
    shapes: &Shapes<D, N>,
    found: &mut Interactions<D, N>,
    batch: &mut Batch<D, N>,
    step: f64,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let velocities = [0, 1].map(|side| rows(&batch.velocities[side], lane));
    let before: Grip<D, N> = batch.grip(lane);
    let [mut friction_work, mut damping_work] = before.second_half(&velocities, step);
    let [penalty, weight] = [batch.penalty.get(lane), batch.weight.get(lane)];
    let potential = penalty * found.energy.get(lane);
    let credited_energy =
        if batch.initial.get(lane) > 0.0 { potential } else { smaller(before.credited_energy, potential) };
    let (energy, slope) = count_from(credited_energy, potential);
    let scale = penalty * weight * slope;
    let mut forces = [0, 1].map(|side| rows(&found.forces[side], lane));
    for side in 0..2 {
        for corner in 0..N {
            for axis in 0..D {
                forces[side][corner][axis] *= scale;
            }
        }
    }
    let point = row(&found.point, lane);
    let mut shares = [[0.0; D]; 2];
    for side in 0..2 {
        let shape: [Point<D>; N] = rows(&shapes[side], lane);
        let all = shape.coordinates(point);
        shares[side] = std::array::from_fn(|k| all[k + 1]);
    }
    let rate = relative_velocity(&velocities, &shares);
    let push = total(&forces[0]);
    let size = dot(push, push).sqrt();
    let (coefficient, ratio) = (batch.coefficient.get(lane), batch.ratio.get(lane));
    let grips = size > 0.0;
    let axes = <[[f64; D]; N]>::axes_around(push.map(|x| x / size));
    let normal = axes[0];
    let long = batch.length.get(lane);
    let [m, n] = [0, 1].map(|side| batch.masses[side].get(lane));
    let critical = 2.0 * (penalty * long * m * n / (m + n)).sqrt();
    // At most the force that presses the two apart, so that they do not stick.
    let damping = larger(smaller(-ratio * weight * critical * dot(rate, normal), size), -size);
    let damping = if grips & (ratio > 0.0) { damping } else { 0.0 };
    let damped: Point<D> = std::array::from_fn(|axis| if grips { damping * normal[axis] } else { 0.0 });
    // In the directions along the surface, as these are now.
    let slip = weight * batch.tangential.get(lane) * long * step;
    let mut trial = [0.0; D];
    for k in 1..D {
        trial[k] = dot(before.friction, axes[k]) - slip * dot(rate, axes[k]);
    }
    let (tried, limit) = (dot(trial, trial).sqrt(), coefficient * (size + damping));
    let held = trial.map(|x| if tried > limit { limit * (x / tried) } else { x });
    let mut along = [0.0; D];
    for k in 1..D {
        add(&mut along, axes[k], held[k]);
    }
    let friction: Point<D> =
        std::array::from_fn(|axis| if grips & (coefficient > 0.0) { along[axis] } else { 0.0 });
    friction_work -= 0.5 * step * dot(friction, rate);
    damping_work -= 0.5 * step * dot(damped, rate);
    let both: Point<D> = std::array::from_fn(|axis| friction[axis] + damped[axis]);
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let all = completed::<D, N>(&shares[side]);
        for corner in 0..N {
            let share = sign * all[corner];
            for axis in 0..D {
                forces[side][corner][axis] += share * both[axis];
            }
        }
        set_rows(&mut found.forces[side], lane, &forces[side]);
        set_row(&mut batch.shares[side], lane, &shares[side]);
    }
    set_row(&mut batch.friction, lane, &friction);
    set_row(&mut batch.damping, lane, &damped);
    batch.credited_energy.set(lane, credited_energy);
    set_row(&mut batch.push, lane, &std::array::from_fn(|axis| push[axis] + both[axis]));
    let works = [weight * energy, friction_work, damping_work, batch.fading.get(lane) * energy];
    set_row(&mut batch.works, lane, &works);
}

/// Counted part of the potential energy `U`, J, and its derivative by `U`, if the energy `U₀` (`credited_energy`) was there before the two elements could touch.
///
/// Elements that were connected until a joint at their vertex broke overlap by the sliding of that joint. Counting this overlap at once would create energy.
/// `(U - U₀)² / U` begins without energy and without force, and its ratio to `U` tends to 1. When `U` falls below `U₀`, the caller lowers `U₀` to `U`.
#[inline(always)]
fn count_from(credited_energy: f64, potential: f64) -> (f64, f64) {
    let share = credited_energy / potential;
    let counted = (potential * (1.0 - share) * (1.0 - share), 1.0 - share * share);
    let counts = potential > credited_energy;
    (if counts { counted.0 } else { 0.0 }, if counts { counted.1 } else { 0.0 })
}

/// Barycentric coordinates, from all but the first.
#[inline(always)]
fn completed<const D: usize, const N: usize>(rest: &[f64; D]) -> [f64; N] {
    let mut first = 1.0;
    for k in 0..D {
        first -= rest[k];
    }
    std::array::from_fn(|k| if k == 0 { first } else { rest[k - 1] })
}

/// Velocity, m/s, of the first element relative to the second, at the points with these barycentric coordinates, of which the first is left out.
#[inline(always)]
fn relative_velocity<const D: usize, const N: usize>(
    velocities: &[[Point<D>; N]; 2],
    shares: &[[f64; D]; 2],
) -> Point<D> {
    let mut rate = [0.0; D];
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let all = completed::<D, N>(&shares[side]);
        for corner in 0..N {
            for axis in 0..D {
                rate[axis] += sign * all[corner] * velocities[side][corner][axis];
            }
        }
    }
    rate
}

/// Sum of forces.
#[inline(always)]
fn total<const D: usize, const N: usize>(forces: &[Point<D>; N]) -> Point<D> {
    let mut sum = [0.0; D];
    for force in forces {
        for axis in 0..D {
            sum[axis] += force[axis];
        }
    }
    sum
}

/// Points where the forces of couples act: the middle of their boundary in contact, or of their corners if they do not overlap any more.
pub(super) fn points<const D: usize, const N: usize>(
    couples: &[[u32; 2]],
    solid: &Solid<D, N>,
) -> Vec<Point<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut points = Vec::with_capacity(couples.len());
    let (mut shapes, mut found) = ([[[Lanes::ZERO; D]; N]; 2], Interactions::NONE);
    let (mut distances, mut scratch) = (Lanes::ZERO, Default::default());
    for couples in couples.chunks(LANES) {
        for (lane, elements) in couples.iter().enumerate() {
            for (shape, element) in shapes.iter_mut().zip(elements) {
                set_rows(shape, lane, &solid.shape(*element));
            }
        }
        distances_of::<D, N>(solid.available, &shapes, &mut distances);
        <[[f64; D]; N]>::interactions(
            solid.available,
            std::slice::from_ref(&shapes),
            &mut scratch,
            std::slice::from_mut(&mut found),
        );
        points.extend((0..couples.len()).map(|lane| {
            if distances.get(lane) < 0.0 && found.energy.get(lane) > 0.0 {
                return row(&found.point, lane);
            }
            let corners: [[Point<D>; N]; 2] = [0, 1].map(|side| rows(&shapes[side], lane));
            std::array::from_fn(|axis| {
                corners.as_flattened().iter().map(|corner| corner[axis]).sum::<f64>() / (2 * N) as f64
            })
        }));
    }
    points
}

/// A lower bound of the distance of two elements, m; `None` if no facet parts them: they overlap, or are near each other. The bound need not be sharp beyond `most`.
pub(super) fn distance<const D: usize, const N: usize>(
    a: &[Point<D>; N],
    b: &[Point<D>; N],
    most: f64,
) -> Option<f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let told = larger(gap(a, b), gap_between_middles(a, b));
    if told > most {
        return Some(told);
    }
    let apart = apart(a, b);
    if apart < 0.0 {
        return None;
    }
    let told = larger(told, apart);
    Some(if told > most { told } else { a.distance(b, told) })
}

/// Gap, m, between two elements along the line between their centroids; negative if there is none.
#[inline]
fn gap_between_middles<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64 {
    let line: Point<D> = std::array::from_fn(|axis| {
        b.iter().map(|corner| corner[axis]).sum::<f64>() - a.iter().map(|corner| corner[axis]).sum::<f64>()
    });
    let least = b.iter().map(|corner| dot(*corner, line)).fold(f64::INFINITY, f64::min);
    let most = a.iter().map(|corner| dot(*corner, line)).fold(f64::NEG_INFINITY, f64::max);
    (least - most) / length(line)
}
