//! The forces of all contacts of two spheres.

#![allow(clippy::inline_always, reason = "what is compiled for vector instructions must be inlined")]

use fdem_contact::{Simd, prefetch};
use rayon::prelude::*;

use crate::error::GrainError;
use crate::law::{ContactHistory, Meeting, PairLaw};
use crate::run::balls::{Ball, Balls};
use crate::run::batch::{Batch, Common, LANES};
use crate::run::cell::{Repeats, RunBox};
use crate::run::laws::Laws;
use crate::run::level::{self, Level, Work};
use crate::run::lists::{APART, Acting, CHUNK, Lists, Memory, Rolling, history};
use crate::run::marks::Marks;
use crate::vector::{cross, dot, minus, plus, times};

/// Number of batches ahead whose spheres are prefetched.
const AHEAD: usize = 2;

/// Radius of a contact that has ended in the last step.
const PARTED: f64 = -1.0;

/// Everything that the contacts of a step read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pressing<'a> {
    pub(crate) balls: &'a Balls,
    pub(crate) laws: &'a Laws,
    pub(crate) cell: Option<&'a RunBox>,
    pub(crate) simd: Simd,
    /// s.
    pub(crate) step: f64,
}

/// The couples of the places of one chunk.
struct Part<'a> {
    /// The first slot among those of all chunks.
    first_slot: u32,
    pairs: &'a [[u32; 2]],
    incident: &'a [[u32; 2]],
    touching: &'a Marks,
    lone: Option<usize>,
    memories: &'a mut [Memory],
    rolling: &'a mut [Rolling],
    due: &'a mut [f32],
    acted: &'a mut [u32],
    acting: &'a mut [Acting],
    /// Number of actions so far.
    used: usize,
    stretched: &'a mut [f64],
    travel: f64,
    skin: f64,
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
            || Scratch { batches: vec![Batch::default(); of.laws.list.len()], slots: Vec::new() },
            |scratch, part| {
                if periodic {
                    level::run(of.simd, Press::<true> { part, of, scratch })
                } else {
                    level::run(of.simd, Press::<false> { part, of, scratch })
                }
            },
        )
        .collect();
    done.into_iter().collect()
}

/// The contacts of a chunk, as work.
struct Press<'a, 'b, const PERIODIC: bool> {
    part: Part<'a>,
    of: Pressing<'a>,
    scratch: &'b mut Scratch,
}

impl<const PERIODIC: bool> Work for Press<'_, '_, PERIODIC> {
    type Done = Result<(), GrainError>;

    #[inline(always)]
    fn run<L: Level>(self) -> Self::Done {
        self.part.press::<L, PERIODIC>(self.of, self.scratch)
    }
}

/// Divides the couples into chunks of places.
fn parts(lists: &mut Lists) -> Vec<Part<'_>> {
    let Lists { first, pairs, incident, touching, lone, travel, skin, .. } = lists;
    let (mut memories, mut rolling) = (&mut lists.memories[..], &mut lists.rolling[..]);
    let (mut due, mut acted) = (&mut lists.due[..], &mut lists.acted[..]);
    let (mut acting, mut stretched) = (&mut lists.acting[..], &mut lists.stretched[..]);
    let count = first.len() - 1;
    let mut parts = Vec::with_capacity(count.div_ceil(CHUNK));
    for begin in (0..count).step_by(CHUNK) {
        let own = first[begin] as usize..first[(begin + CHUNK).min(count)] as usize;
        let slots = own.len();
        parts.push(Part {
            first_slot: own.start as u32,
            pairs: &pairs[own.clone()],
            incident: &incident[own],
            touching,
            lone: *lone,
            memories: front(&mut memories, slots),
            rolling: front(&mut rolling, slots),
            due: front(&mut due, slots),
            acted: front(&mut acted, slots),
            acting: front(&mut acting, slots),
            used: 0,
            stretched: front(&mut stretched, slots),
            travel: *travel,
            skin: *skin,
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
    slots: Vec<u32>,
}

impl Part<'_> {
    #[inline(always)]
    fn press<L: Level, const PERIODIC: bool>(
        mut self,
        of: Pressing<'_>,
        scratch: &mut Scratch,
    ) -> Result<(), GrainError> {
        let Scratch { batches, slots } = scratch;
        // An error may have left some.
        for batch in batches.iter_mut() {
            batch.count = 0;
        }
        let count = self.list(slots);
        let slots = &slots[..count];
        let lone = self.lone.filter(|&number| !of.laws.list[number].sticks());
        for (k, group) in slots.chunks(LANES).enumerate() {
            for &slot in slots.iter().skip(LANES * (k + AHEAD)).take(LANES) {
                for place in self.pairs[slot as usize] {
                    prefetch(&of.balls.list[place as usize]);
                }
                prefetch(&self.memories[slot as usize]);
            }
            if let Some(number) = lone {
                let batch = &mut batches[number];
                for &slot in group {
                    batch.take(slot, self.pairs[slot as usize]);
                }
                self.finish::<L, PERIODIC>(of, batch, &of.laws.list[number]);
                continue;
            }
            for &slot in group {
                let Some(number) = self.sort::<PERIODIC>(of, slot as usize)? else { continue };
                let batch = &mut batches[number];
                batch.take(slot, self.pairs[slot as usize]);
                if batch.count == LANES {
                    self.finish::<L, PERIODIC>(of, batch, &of.laws.list[number]);
                }
            }
        }
        for (batch, law) in batches.iter_mut().zip(&of.laws.list) {
            if batch.count > 0 {
                self.finish::<L, PERIODIC>(of, batch, law);
            }
        }
        Ok(())
    }

    /// The number of the law of a couple, if it is computed in batches. Others are computed here.
    fn sort<const PERIODIC: bool>(
        &mut self,
        of: Pressing<'_>,
        slot: usize,
    ) -> Result<Option<usize>, GrainError> {
        let [one, two] = self.pairs[slot].map(|place| &of.balls.list[place as usize]);
        let repeats = of.cell.map_or(Repeats::NONE, RunBox::repeats);
        let apart = apart::<PERIODIC>(repeats, one.position, two.position);
        let (square, sum) = (dot(apart, apart), one.radius + two.radius);
        if square >= sum * sum && self.memories[slot].contact == 0.0 {
            self.due[slot] = self.due_of(square.sqrt() - sum);
            return Ok(None);
        }
        let number = of.laws.number([one.material, two.material])?;
        let law = &of.laws.list[number];
        if !law.sticks() {
            return Ok(Some(number));
        }
        self.stick(of, slot, law, (apart, [one, two]));
        Ok(None)
    }

    /// Lists the couples that may touch. Returns how many.
    ///
    /// Couples that may touch and others are mixed. The processor would guess a branch for each couple wrong,
    /// and would not load the spheres ahead of it.
    #[inline(always)]
    fn list(&self, slots: &mut Vec<u32>) -> usize {
        // One place more, which is written last and not used.
        slots.resize(slots.len().max(self.due.len() + 1), 0);
        let travel = self.travel as f32;
        let mut count = 0;
        let slots = slots.as_mut_slice();
        for (slot, &due) in (0..).zip(&*self.due) {
            slots[count] = slot;
            count += usize::from(due <= travel);
        }
        count
    }

    /// Computes a batch, and writes the results to their slots.
    #[inline(always)]
    fn finish<L: Level, const PERIODIC: bool>(&mut self, of: Pressing<'_>, batch: &mut Batch, law: &PairLaw) {
        let common = Common {
            balls: &of.balls.list,
            law,
            repeats: of.cell.map_or(Repeats::NONE, RunBox::repeats),
            rates: of.cell.map_or([0.0; 3], RunBox::rates),
            simd: of.simd,
            step: of.step,
            share: of.balls.share,
        };
        batch.compute::<L, PERIODIC>(common, self.memories, self.rolling);
        self.write::<L, PERIODIC, 0>(of, batch, law);
        self.write::<L, PERIODIC, 4>(of, batch, law);
        batch.count = 0;
    }

    /// Writes the results of four lanes of a batch, from `FIRST` on, to their slots.
    #[inline(always)]
    fn write<L: Level, const PERIODIC: bool, const FIRST: usize>(
        &mut self,
        of: Pressing<'_>,
        batch: &Batch,
        law: &PairLaw,
    ) {
        let (memories, pushes, torques) = batch.rows::<L, FIRST>();
        let gaps = batch.gaps::<FIRST>();
        for k in 0..4.min(batch.count.saturating_sub(FIRST)) {
            let lane = FIRST + k;
            let slot = batch.slots[lane] as usize;
            if gaps[k] >= 0.0 {
                if self.memories[slot].contact == 0.0 {
                    self.due[slot] = self.due_of(gaps[k]);
                } else {
                    self.part(slot, law, batch.radius(lane));
                }
                continue;
            }
            let place = self.act(slot);
            let [tangential @ .., contact] = memories[k];
            let ([force @ .., dissipated], [torque @ .., overlap]) = (pushes[k], torques[k]);
            self.memories[slot] = Memory { tangential, contact };
            self.acting[place] = Acting { force, dissipated, torque, overlap };
            if let Some(rolling) = self.rolling.get_mut(slot) {
                *rolling = batch.rolled(lane);
            }
            if let (true, Some(work), Some(cell)) = (PERIODIC, self.stretched.get_mut(slot), of.cell) {
                let [force, apart] = batch.stretched(lane);
                *work = stretch(cell, force, apart, of.step);
            }
        }
    }

    /// Gives a couple the next place for its action.
    #[inline(always)]
    fn act(&mut self, slot: usize) -> usize {
        let place = self.used;
        if self.acted[slot] == APART {
            self.begin(slot);
        }
        self.acted[slot] = self.first_slot + place as u32;
        self.used += 1;
        place
    }

    /// Has a couple looked at in each step, and its spheres add up its action.
    #[cold]
    fn begin(&mut self, slot: usize) {
        self.due[slot] = f32::NEG_INFINITY;
        for incident in self.incident[slot] {
            self.touching.add(incident);
        }
    }

    /// Ends a contact. The energy of its springs is lost in this step; in the next one it has no action.
    /// `radius`: the reduced one, m.
    #[cold]
    fn part(&mut self, slot: usize, law: &PairLaw, radius: f64) {
        let history = self.history(slot);
        self.set(slot, ContactHistory::default(), [0.0; 3]);
        if history.contact > 0.0 {
            let place = self.act(slot);
            self.acting[place] = Acting { dissipated: law.lost(radius, &history), ..Acting::default() };
            self.memories[slot].contact = PARTED;
        } else {
            self.acted[slot] = APART;
            for incident in self.incident[slot] {
                self.touching.remove(incident);
            }
        }
    }

    /// The travel, m, after which two spheres with this gap, m, may touch. It is rounded down,
    /// by more than the rounding of positions.
    #[inline]
    fn due_of(&self, gap: f64) -> f32 {
        ((self.travel + gap) * (1.0 - 1e-6) - 1e-6 * self.skin) as f32
    }

    fn history(&self, slot: usize) -> ContactHistory {
        history(self.memories[slot], self.rolling.get(slot))
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
            if history.contact != 0.0 {
                self.part(slot, law, radius);
            }
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
