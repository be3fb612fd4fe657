//! The forces of all contacts of two spheres.
//!
//! First all couples whose spheres may have come together are looked at. Those that touch become contacts,
//! and then the forces of all contacts are computed in batches.

#![allow(clippy::inline_always, reason = "what is compiled for vector instructions must be inlined")]

use fdem_contact::{Simd, prefetch};
use rayon::prelude::*;

use crate::error::GrainError;
use crate::law::{Meeting, PairLaw};
use crate::run::balls::{Ball, Balls};
use crate::run::batch::{Batch, Common, LANES};
use crate::run::cell::{Repeats, RunBox};
use crate::run::contacts::{Acting, CHUNK, ContactChunk, Contacts, Couple, Memory, Rolling, history};
use crate::run::laws::Laws;
use crate::run::level::{self, Level, Work};
use crate::run::lists::Lists;
use crate::vector::{cross, dot, minus, plus, times};

/// Number of batches ahead whose spheres are prefetched.
const AHEAD: usize = 2;

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

/// Computes all contacts of two spheres.
///
/// # Errors
/// Two materials that touch have no law.
pub(crate) fn press(of: Pressing<'_>, lists: &mut Lists) -> Result<(), GrainError> {
    let periodic = of.cell.is_some_and(RunBox::is_periodic);
    let looks: Vec<Result<(), GrainError>> = looks(lists)
        .into_par_iter()
        .map_init(Vec::new, |slots, look| {
            if periodic { look.find::<true>(of, slots) } else { look.find::<false>(of, slots) }
        })
        .collect();
    looks.into_iter().collect::<Result<(), GrainError>>()?;
    lists.contacts.follow(of.balls, &lists.pairs);
    let lone = lists.lone.filter(|&number| !of.laws.list[number].sticks());
    parts(&mut lists.contacts, lone).into_par_iter().try_for_each_init(
        || vec![Batch::default(); of.laws.list.len()],
        |batches, part| {
            if periodic {
                level::run(of.simd, Press::<true> { part, of, batches })
            } else {
                level::run(of.simd, Press::<false> { part, of, batches })
            }
        },
    )
}

/// The couples of the places of one chunk, among which some may begin to touch.
struct Look<'a> {
    /// The first slot among those of all chunks.
    first_slot: u32,
    pairs: &'a [[u32; 2]],
    due: &'a mut [f32],
    couples: &'a [Couple],
    chunk: &'a mut ContactChunk,
    travel: f64,
    skin: f64,
}

/// Divides the couples into chunks of places.
fn looks(lists: &mut Lists) -> Vec<Look<'_>> {
    let Lists { first, pairs, due, contacts, travel, skin, .. } = lists;
    let Contacts { chunks, couples, .. } = contacts;
    let mut due = &mut due[..];
    let count = first.len() - 1;
    let looks = (0..).step_by(CHUNK).zip(chunks).map(|(begin, chunk)| {
        let own = first[begin] as usize..first[(begin + CHUNK).min(count)] as usize;
        Look {
            first_slot: own.start as u32,
            pairs: &pairs[own.clone()],
            due: front(&mut due, own.len()),
            couples,
            chunk,
            travel: *travel,
            skin: *skin,
        }
    });
    looks.collect()
}

impl Look<'_> {
    /// Finds the couples that begin to touch.
    fn find<const PERIODIC: bool>(self, of: Pressing<'_>, slots: &mut Vec<u32>) -> Result<(), GrainError> {
        for &place in &self.chunk.ended {
            let slot = self.couples[self.chunk.begin + place as usize].slot;
            self.due[(slot - self.first_slot) as usize] = f32::NEG_INFINITY;
        }
        let repeats = of.cell.map_or(Repeats::NONE, RunBox::repeats);
        let count = self.list(slots);
        for (k, &slot) in slots[..count].iter().enumerate() {
            if let Some(&slot) = slots[..count].get(k + 2 * AHEAD * LANES) {
                prefetch(&self.pairs[slot as usize]);
            }
            if let Some(&slot) = slots[..count].get(k + AHEAD * LANES) {
                for place in self.pairs[slot as usize] {
                    prefetch(&of.balls.list[place as usize]);
                }
            }
            let [one, two] = self.pairs[slot as usize].map(|place| &of.balls.list[place as usize]);
            let apart = apart::<PERIODIC>(repeats, one.position, two.position);
            let (square, sum) = (dot(apart, apart), one.radius + two.radius);
            let due = &mut self.due[slot as usize];
            if square >= sum * sum {
                // Rounded down by more than the rounding of positions.
                let travel = self.travel + square.sqrt() - sum;
                *due = (travel * (1.0 - 1e-6) - 1e-6 * self.skin) as f32;
                continue;
            }
            of.laws.number([one.material, two.material])?;
            *due = f32::INFINITY;
            self.chunk.begun.push(self.first_slot + slot);
        }
        Ok(())
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
}

/// The contacts of the places of one chunk.
struct Part<'a> {
    couples: &'a [Couple],
    memories: &'a mut [Memory],
    acting: &'a mut [Acting],
    rolling: &'a mut [Rolling],
    stretched: &'a mut [f64],
    ended: &'a mut Vec<u32>,
    /// The law of all of them, if there is one only and it has batches.
    lone: Option<usize>,
}

/// Divides the contacts into chunks.
fn parts(contacts: &mut Contacts, lone: Option<usize>) -> Vec<Part<'_>> {
    let (mut memories, mut acting) = (&mut contacts.memories[..], &mut contacts.acting[..]);
    let (mut rolling, mut stretched) = (&mut contacts.rolling[..], &mut contacts.stretched[..]);
    let couples = &contacts.couples;
    let parts = contacts.chunks.iter_mut().map(|chunk| Part {
        couples: &couples[chunk.begin..chunk.begin + chunk.count],
        memories: front(&mut memories, chunk.room),
        acting: front(&mut acting, chunk.room),
        rolling: front(&mut rolling, chunk.room),
        stretched: front(&mut stretched, chunk.room),
        ended: &mut chunk.ended,
        lone,
    });
    parts.collect()
}

/// Takes the front of a list, or nothing of an empty one.
#[allow(clippy::mut_mut, reason = "the list that is left replaces the list")]
fn front<'a, T>(list: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    list.split_off_mut(..count).unwrap_or_default()
}

/// The contacts of a chunk, as work. It has a batch for each law.
struct Press<'a, 'b, const PERIODIC: bool> {
    part: Part<'a>,
    of: Pressing<'a>,
    batches: &'b mut [Batch],
}

impl<const PERIODIC: bool> Work for Press<'_, '_, PERIODIC> {
    type Done = Result<(), GrainError>;

    #[inline(always)]
    fn run<L: Level>(self) -> Self::Done {
        self.part.press::<L, PERIODIC>(self.of, self.batches)
    }
}

impl Part<'_> {
    #[inline(always)]
    fn press<L: Level, const PERIODIC: bool>(
        mut self,
        of: Pressing<'_>,
        batches: &mut [Batch],
    ) -> Result<(), GrainError> {
        // An error may have left some.
        for batch in batches.iter_mut() {
            batch.count = 0;
        }
        for begin in (0..self.couples.len()).step_by(LANES) {
            for couple in self.couples.iter().skip(begin + AHEAD * LANES).take(LANES) {
                for place in couple.places {
                    prefetch(&of.balls.list[place as usize]);
                }
            }
            let group = begin..(begin + LANES).min(self.couples.len());
            if let Some(number) = self.lone {
                let batch = &mut batches[number];
                batch.fill(begin, &self.couples[group]);
                self.finish::<L, PERIODIC>(of, batch, &of.laws.list[number]);
                continue;
            }
            for contact in group {
                let places = self.couples[contact].places;
                let number = of.laws.number(places.map(|place| of.balls.list[place as usize].material))?;
                let law = &of.laws.list[number];
                if law.sticks() {
                    self.stick::<PERIODIC>(of, contact, law);
                    continue;
                }
                let batch = &mut batches[number];
                batch.take(contact as u32, places);
                if batch.count == LANES {
                    self.finish::<L, PERIODIC>(of, batch, law);
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

    /// Computes a batch, and writes the results to their contacts.
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

    /// Writes the results of four lanes of a batch, from `FIRST` on, to their contacts.
    #[inline(always)]
    fn write<L: Level, const PERIODIC: bool, const FIRST: usize>(
        &mut self,
        of: Pressing<'_>,
        batch: &Batch,
        law: &PairLaw,
    ) {
        let (memories, pushes, turns) = batch.rows::<L, FIRST>();
        let touch = batch.touch::<FIRST>();
        for k in 0..4.min(batch.count.saturating_sub(FIRST)) {
            let lane = FIRST + k;
            let contact = batch.contacts[lane] as usize;
            if !touch[k] {
                self.part(contact, law, batch.radius(lane));
                continue;
            }
            self.memories[contact] = Memory(memories[k]);
            self.acting[contact] = Acting { push: pushes[k], turn: turns[k] };
            if let Some(rolling) = self.rolling.get_mut(contact) {
                *rolling = batch.rolled(lane);
            }
            if let (true, Some(work), Some(cell)) = (PERIODIC, self.stretched.get_mut(contact), of.cell) {
                let [force, apart] = batch.stretched(lane);
                *work = stretch(cell, force, apart, of.step);
            }
        }
    }

    /// Ends a contact. The energy of its springs is lost in this step; in the next one it is no contact.
    /// `radius`: the reduced one, m.
    #[cold]
    fn part(&mut self, contact: usize, law: &PairLaw, radius: f64) {
        let history = history(self.memories[contact], self.rolling.get(contact));
        self.memories[contact] = Memory::default();
        if let Some(rolling) = self.rolling.get_mut(contact) {
            *rolling = Rolling::default();
        }
        if let Some(work) = self.stretched.get_mut(contact) {
            *work = 0.0;
        }
        let lost = if history.contact > 0.0 { law.lost(radius, &history) } else { 0.0 };
        self.acting[contact] = Acting { push: [0.0, 0.0, 0.0, lost], turn: [0.0; 4] };
        self.ended.push(contact as u32);
    }

    /// Computes a contact of two spheres that stick to each other.
    #[cold]
    fn stick<const PERIODIC: bool>(&mut self, of: Pressing<'_>, contact: usize, law: &PairLaw) {
        let [one, two] = self.couples[contact].places.map(|place| &of.balls.list[place as usize]);
        let repeats = of.cell.map_or(Repeats::NONE, RunBox::repeats);
        let apart = apart::<PERIODIC>(repeats, one.position, two.position);
        let distance = dot(apart, apart).sqrt();
        let overlap = one.radius + two.radius - distance;
        let radius = one.radius * two.radius / (one.radius + two.radius);
        let mut history = history(self.memories[contact], self.rolling.get(contact));
        if !law.touches(overlap, radius, &history) {
            self.part(contact, law, radius);
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
        let [[x, y, z], [a, b, c]] = [push.force, cross(push.force, normal)];
        self.acting[contact] = Acting { push: [x, y, z, push.dissipated], turn: [a, b, c, overlap] };
        let [p, q, r] = history.tangential;
        self.memories[contact] = Memory([p, q, r, history.contact]);
        if let Some(rolling) = self.rolling.get_mut(contact) {
            *rolling = Rolling { spring: history.rolling, twisting: history.twisting, moment: push.moment };
        }
        if let (Some(work), Some(cell)) = (self.stretched.get_mut(contact), of.cell) {
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
