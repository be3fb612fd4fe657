//! The forces of all contacts of two spheres.

use fdem_contact::Simd;
use rayon::prelude::*;

use crate::error::GrainError;
use crate::law::{ContactHistory, Meeting, PairLaw};
use crate::run::balls::{Ball, Balls};
use crate::run::batch::{Batch, LANES, at, compute, put};
use crate::run::cell::{Repeats, RunBox};
use crate::run::laws::Laws;
use crate::run::lists::{APART, Acting, CHUNK, IS_FIRST, Lists, Memory, Rolling};
use crate::vector::{cross, dot, minus, plus, times};

/// Radius of a contact that has ended in the last step.
const PARTED: f64 = -1.0;

/// Everything that the contacts of a step read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pressing<'a> {
    pub(crate) balls: &'a Balls,
    pub(crate) spots: &'a [Spot],
    pub(crate) laws: &'a Laws,
    pub(crate) cell: Option<&'a RunBox>,
    pub(crate) simd: Simd,
    /// s.
    pub(crate) step: f64,
}

/// The couples of the places of one chunk.
struct Part<'a> {
    /// The first place, and where the couples of each place begin.
    begin: usize,
    starts: &'a [u32],
    others: &'a [u32],
    memories: &'a mut [Memory],
    rolling: &'a mut [Rolling],
    acted: &'a mut [u32],
    acting: &'a mut [Acting],
    /// Number of actions so far.
    used: usize,
    stretched: &'a mut [f64],
}

/// Computes all contacts of two spheres.
///
/// # Errors
/// Two materials that touch have no law.
pub(crate) fn press(of: Pressing<'_>, lists: &mut Lists) -> Result<(), GrainError> {
    let parts = parts(lists);
    let periodic = of.cell.is_some_and(RunBox::is_periodic);
    let done: Vec<Result<(), GrainError>> = parts
        .into_par_iter()
        .map_init(
            || Scratch { batches: vec![Batch::default(); of.laws.list.len()], couples: Vec::new() },
            |scratch, part| {
                if periodic { part.press::<true>(of, scratch) } else { part.press::<false>(of, scratch) }
            },
        )
        .collect();
    done.into_iter().collect()
}

/// Divides the couples into chunks of places.
fn parts(lists: &mut Lists) -> Vec<Part<'_>> {
    let Lists { first, other, memories, rolling, acted, acting, stretched, .. } = lists;
    let count = first.len() - 1;
    let (mut others, mut memories, mut acting) = (&other[..], &mut memories[..], &mut acting[..]);
    let (mut rolling, mut stretched) = (&mut rolling[..], &mut stretched[..]);
    let mut acted = &mut acted[..];
    let mut parts = Vec::with_capacity(count.div_ceil(CHUNK));
    for begin in (0..count).step_by(CHUNK) {
        let starts = &first[begin..=(begin + CHUNK).min(count)];
        let slots = (starts[starts.len() - 1] - starts[0]) as usize;
        let own;
        (own, others) = others.split_at(slots);
        parts.push(Part {
            begin,
            starts,
            others: own,
            memories: front(&mut memories, slots),
            rolling: front(&mut rolling, slots),
            acted: front(&mut acted, slots),
            acting: front(&mut acting, slots),
            used: 0,
            stretched: front(&mut stretched, slots),
        });
    }
    parts
}

/// Takes the front of a list, or nothing of an empty one.
#[allow(clippy::mut_mut, reason = "the list that is left replaces the list")]
fn front<'a, T>(list: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    list.split_off_mut(..count).unwrap_or_default()
}

/// Memory that a thread uses for one chunk after the other.
struct Scratch {
    /// A batch for each law.
    batches: Vec<Batch>,
    couples: Vec<Listed>,
}

/// A couple whose contact is computed: its slot in the part, and the places of its two spheres.
#[derive(Clone, Copy, Default)]
struct Listed {
    slot: u32,
    pair: [u32; 2],
}

/// A sphere as the test of candidates sees it: half of a cache line, because many are read.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Spot {
    position: [f64; 3],
    radius: f64,
}

/// Fills the spots of all spheres.
pub(crate) fn fill_spots(spots: &mut Vec<Spot>, balls: &Balls) {
    let list = balls.list.par_iter().with_min_len(CHUNK);
    list.map(|ball| Spot { position: ball.position, radius: ball.radius }).collect_into_vec(spots);
}

impl Part<'_> {
    fn press<const PERIODIC: bool>(
        mut self,
        of: Pressing<'_>,
        scratch: &mut Scratch,
    ) -> Result<(), GrainError> {
        let Scratch { batches, couples } = scratch;
        let list = &of.balls.list;
        let repeats = of.cell.map_or(Repeats::NONE, RunBox::repeats);
        let count = self.list::<PERIODIC>(of.spots, repeats, couples);
        for &Listed { slot, pair } in &couples[..count] {
            let slot = slot as usize;
            let [one, two] = pair.map(|place| &list[place as usize]);
            let apart = apart::<PERIODIC>(repeats, one.position, two.position);
            let (square, sum) = (dot(apart, apart), one.radius + two.radius);
            let number = of.laws.number([one.material, two.material])?;
            let law = &of.laws.list[number];
            if law.sticks() {
                self.stick(of, slot, law, (apart, [one, two]));
                continue;
            }
            if square >= sum * sum {
                self.part(slot, law, [one, two]);
                continue;
            }
            let batch = &mut batches[number];
            self.gather::<PERIODIC>(batch, slot, (apart, square), [one, two], of.cell);
            if batch.count == LANES {
                self.finish::<PERIODIC>(of, batch, law);
            }
        }
        for (batch, law) in batches.iter_mut().zip(&of.laws.list) {
            if batch.count > 0 {
                self.finish::<PERIODIC>(of, batch, law);
            }
        }
        Ok(())
    }

    /// Lists the couples that touch and those that have touched. Returns how many.
    ///
    /// About half of the candidates touch, in no order: a branch for each would be guessed wrong as often,
    /// and would keep the processor from loading the spheres ahead of it.
    fn list<const PERIODIC: bool>(
        &self,
        spots: &[Spot],
        repeats: Repeats,
        couples: &mut Vec<Listed>,
    ) -> usize {
        let base = self.starts[0];
        // One place more, which is written last and not used.
        couples.resize(couples.len().max(self.others.len() + 1), Listed::default());
        let mut count = 0;
        for (place, ends) in (self.begin..).zip(self.starts.windows(2)) {
            let spot = spots[place];
            for slot in (ends[0] - base) as usize..(ends[1] - base) as usize {
                let other = self.others[slot] & !IS_FIRST;
                let its = &spots[other as usize];
                let apart = apart::<PERIODIC>(repeats, spot.position, its.position);
                let sum = spot.radius + its.radius;
                // The contact is the same whichever of the two has the lower place.
                let is_first = (self.others[slot] / IS_FIRST) as usize;
                let listed = &mut couples[count];
                listed.slot = slot as u32;
                listed.pair[is_first] = place as u32;
                listed.pair[1 - is_first] = other;
                count += usize::from(dot(apart, apart) < sum * sum) | usize::from(self.acted[slot] != APART);
            }
        }
        count
    }

    /// Puts a contact into the next lane of a batch.
    #[inline]
    fn gather<const PERIODIC: bool>(
        &mut self,
        batch: &mut Batch,
        slot: usize,
        (apart, square): ([f64; 3], f64),
        [one, two]: [&Ball; 2],
        cell: Option<&RunBox>,
    ) {
        let lane = batch.count;
        batch.count += 1;
        batch.slots[lane] = slot as u32;
        self.act(slot);
        // Spheres at one point have no normal: any will do.
        let (apart, square) = if square > 0.0 { (apart, square) } else { ([1e-150, 0.0, 0.0], 1e-300) };
        put(&mut batch.apart, lane, apart);
        batch.square[lane] = square;
        let mut velocity = minus(one.velocity, two.velocity);
        if let (true, Some(cell)) = (PERIODIC, cell) {
            let rates = cell.rates();
            velocity = plus(velocity, [rates[0] * apart[0], rates[1] * apart[1], rates[2] * apart[2]]);
        }
        put(&mut batch.velocity, lane, velocity);
        put(&mut batch.spins[0], lane, one.spin);
        put(&mut batch.spins[1], lane, two.spin);
        (batch.radii[0][lane], batch.radii[1][lane]) = (one.radius, two.radius);
        (batch.masses[0][lane], batch.masses[1][lane]) = (one.mass, two.mass);
        let memory = &self.memories[slot];
        put(&mut batch.tangential, lane, memory.tangential);
        batch.contact[lane] = memory.contact;
        if let Some(rolling) = self.rolling.get(slot) {
            put(&mut batch.rolling, lane, rolling.spring);
            batch.twisting[lane] = rolling.twisting;
        }
    }

    /// Computes a batch, and writes the results to their slots.
    #[inline]
    fn finish<const PERIODIC: bool>(&mut self, of: Pressing<'_>, batch: &mut Batch, law: &PairLaw) {
        compute(of.simd, law, batch, of.step, of.balls.share);
        let rolls = law.rolls();
        for lane in 0..batch.count {
            let slot = batch.slots[lane] as usize;
            self.memories[slot] =
                Memory { tangential: at(&batch.tangential, lane), contact: batch.contact[lane] };
            self.acting[(self.acted[slot] - self.starts[0]) as usize] = Acting {
                force: at(&batch.force, lane),
                torque: at(&batch.torque, lane),
                overlap: batch.overlap[lane],
                dissipated: batch.dissipated[lane],
            };
            if rolls {
                self.rolling[slot] = Rolling {
                    spring: at(&batch.rolling, lane),
                    twisting: batch.twisting[lane],
                    moment: at(&batch.moment, lane),
                };
            }
            if let (true, Some(work), Some(cell)) = (PERIODIC, self.stretched.get_mut(slot), of.cell) {
                *work = stretch(cell, at(&batch.force, lane), at(&batch.apart, lane), of.step);
            }
        }
        batch.count = 0;
    }

    /// Gives a couple the next place for its action.
    #[inline]
    fn act(&mut self, slot: usize) -> usize {
        let place = self.used;
        self.acted[slot] = self.starts[0] + place as u32;
        self.used += 1;
        place
    }

    /// Ends a contact. The energy of its springs is lost in this step; in the next one it has no action.
    #[cold]
    fn part(&mut self, slot: usize, law: &PairLaw, [one, two]: [&Ball; 2]) {
        let history = self.history(slot);
        self.set(slot, ContactHistory::default(), [0.0; 3]);
        if history.contact > 0.0 {
            let radius = one.radius * two.radius / (one.radius + two.radius);
            let place = self.act(slot);
            self.acting[place] = Acting { dissipated: law.lost(radius, &history), ..Acting::default() };
            self.memories[slot].contact = PARTED;
        } else {
            self.acted[slot] = APART;
        }
    }

    fn history(&self, slot: usize) -> ContactHistory {
        let Memory { tangential, contact } = self.memories[slot];
        let Rolling { spring: rolling, twisting, .. } = self.rolling.get(slot).copied().unwrap_or_default();
        ContactHistory { tangential, contact, rolling, twisting }
    }

    /// Sets the memory of a couple, and its moment of rolling, N m.
    fn set(&mut self, slot: usize, history: ContactHistory, moment: [f64; 3]) {
        let ContactHistory { tangential, contact, rolling, twisting } = history;
        self.memories[slot] = Memory { tangential, contact };
        if let Some(of_slot) = self.rolling.get_mut(slot) {
            *of_slot = Rolling { spring: rolling, twisting, moment };
        }
        if let Some(work) = self.stretched.get_mut(slot) {
            *work = 0.0;
        }
    }

    /// Computes a contact of two spheres that stick to each other.
    #[cold]
    fn stick(
        &mut self,
        of: Pressing<'_>,
        slot: usize,
        law: &PairLaw,
        (apart, [one, two]): ([f64; 3], [&Ball; 2]),
    ) {
        let distance = dot(apart, apart).sqrt();
        let overlap = one.radius + two.radius - distance;
        let radius = one.radius * two.radius / (one.radius + two.radius);
        let mut history = self.history(slot);
        if !law.touches(overlap, radius, &history) {
            self.part(slot, law, [one, two]);
            return;
        }
        let normal = if distance > 0.0 { times(1.0 / distance, apart) } else { [1.0, 0.0, 0.0] };
        let arms =
            plus(times(one.radius - 0.5 * overlap, one.spin), times(two.radius - 0.5 * overlap, two.spin));
        let rates = of.cell.map_or([0.0; 3], RunBox::rates);
        let drift = [rates[0] * apart[0], rates[1] * apart[1], rates[2] * apart[2]];
        let velocity = plus(plus(minus(one.velocity, two.velocity), drift), cross(normal, arms));
        let inertia = |ball: &Ball| (of.balls.share + 1.0) * ball.mass * ball.radius * ball.radius;
        let meeting = Meeting {
            normal,
            overlap,
            radius,
            mass: one.mass * two.mass / (one.mass + two.mass),
            inertias: [inertia(one), inertia(two)],
            velocity,
            spins: [one.spin, two.spin],
        };
        let push = law.push(&meeting, &mut history, of.step);
        let torque = cross(push.force, normal);
        let place = self.act(slot);
        self.acting[place] = Acting { force: push.force, torque, overlap, dissipated: push.dissipated };
        self.set(slot, history, push.moment);
        if let (Some(work), Some(cell)) = (self.stretched.get_mut(slot), of.cell) {
            *work = stretch(cell, push.force, apart, of.step);
        }
    }
}

/// From the second sphere, or its nearest image, to the first, m.
#[inline]
fn apart<const PERIODIC: bool>(repeats: Repeats, one: [f64; 3], two: [f64; 3]) -> [f64; 3] {
    let apart = minus(one, two);
    if PERIODIC { repeats.shortest(apart) } else { apart }
}

/// Work of a growing box on a couple, J.
#[inline]
fn stretch(cell: &RunBox, force: [f64; 3], apart: [f64; 3], step: f64) -> f64 {
    let rates = cell.rates();
    -step * (force[0] * rates[0] * apart[0] + force[1] * rates[1] * apart[1] + force[2] * rates[2] * apart[2])
}
