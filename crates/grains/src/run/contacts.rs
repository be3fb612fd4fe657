//! The contacts of two spheres that touch: their memory, their forces, and the sums in which these count.
//!
//! Few contacts begin or end in a step. So those of a chunk of places lie side by side, and each step goes
//! through them without looking for them; and each chunk keeps a list of the contacts of its spheres, in the
//! order in which their forces are added up.

use rayon::prelude::*;

use crate::law::ContactHistory;
use crate::run::balls::Balls;
use crate::vector::Vector;

/// Spheres that one thread computes at a time.
pub(crate) const CHUNK: usize = 512;

/// Memory that all contacts have, as in [`ContactHistory`]: the force across the normal, N, and the radius of
/// the contact, m. In a row, because it is read and written as one vector.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Memory(pub(crate) [f64; 4]);

impl Memory {
    /// Radius of the contact, m; 0 before its first step and after its last one.
    pub(crate) fn contact(&self) -> f64 {
        self.0[3]
    }
}

/// Memory of contacts with rolling friction, and their moment on the first sphere, N m.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rolling {
    pub(crate) spring: Vector,
    pub(crate) twisting: f64,
    pub(crate) moment: Vector,
}

/// The action of a contact on its spheres. The first sphere is the one with the lower number.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Acting {
    /// Force on the first, N, whose opposite acts on the second; energy that the step has dissipated, J.
    pub(crate) push: [f64; 4],
    /// The moments on the two over the distances of the contact from their centres, N; overlap, m.
    pub(crate) turn: [f64; 4],
}

impl Acting {
    /// Force on the first sphere, N.
    pub(crate) fn force(&self) -> Vector {
        let [force @ .., _] = self.push;
        force
    }

    /// Energy that the step has dissipated, J.
    pub(crate) fn dissipated(&self) -> f64 {
        self.push[3]
    }

    /// m.
    pub(crate) fn overlap(&self) -> f64 {
        self.turn[3]
    }
}

/// The spheres of a contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Couple {
    /// Their places; the first is the one with the lower number.
    pub(crate) places: [u32; 2],
    /// Its place among all couples that may touch.
    pub(crate) slot: u32,
}

impl Couple {
    /// The chunk that has the contact: that of the lower place.
    fn chunk(&self) -> usize {
        chunk_of(self.places[0].min(self.places[1]))
    }
}

/// A contact among those of a sphere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Twice the number of the contact, and 1 more where the sphere is its second.
    code: u32,
    /// Place of the sphere in its chunk.
    pub(crate) sphere: u32,
}

impl Entry {
    fn new(contact: u32, is_second: bool, place: u32) -> Self {
        Self { code: 2 * contact + u32::from(is_second), sphere: place % CHUNK as u32 }
    }

    #[inline]
    pub(crate) fn contact(self) -> usize {
        (self.code / 2) as usize
    }

    /// 0 for the first sphere of the contact, 1 for the second.
    #[inline]
    pub(crate) fn side(self) -> usize {
        (self.code & 1) as usize
    }

    pub(crate) fn is_second(self) -> bool {
        self.code & 1 == 1
    }
}

/// The contacts of the couples of a chunk of places, and those of its spheres.
#[derive(Debug, Default)]
pub(crate) struct ContactChunk {
    /// Its contacts: how many there are from `begin` on, and for how many there is room.
    pub(crate) begin: usize,
    pub(crate) count: usize,
    pub(crate) room: usize,
    /// Contacts that ended in the last step, by their places in the chunk.
    pub(crate) ended: Vec<u32>,
    /// Slots of couples that begin to touch.
    pub(crate) begun: Vec<u32>,
    /// The contacts of each sphere in ascending order of the other sphere's number: so sums of forces do not
    /// depend on places.
    pub(crate) entries: Vec<Entry>,
}

impl ContactChunk {
    /// Where the entries of a sphere are.
    fn range(&self, place: u32) -> std::ops::Range<usize> {
        let sphere = place % CHUNK as u32;
        let begin = self.entries.partition_point(|entry| entry.sphere < sphere);
        let count = self.entries[begin..].iter().take_while(|entry| entry.sphere == sphere).count();
        begin..begin + count
    }
}

/// All contacts.
#[derive(Debug, Default)]
pub(crate) struct Contacts {
    pub(crate) chunks: Vec<ContactChunk>,
    pub(crate) couples: Vec<Couple>,
    pub(crate) memories: Vec<Memory>,
    pub(crate) acting: Vec<Acting>,
    /// Empty without rolling friction.
    pub(crate) rolling: Vec<Rolling>,
    /// Work of the box on each contact in the step, J; empty if the box does not grow, or has a servo.
    pub(crate) stretched: Vec<f64>,
    pub(crate) rolls: bool,
    pub(crate) stretches: bool,
}

impl Contacts {
    /// Begins anew, with the contacts of each chunk, in the order of the chunks. `kinds`: whether they roll,
    /// and whether the box does work on them.
    pub(crate) fn renew(
        &mut self,
        balls: &Balls,
        of_chunks: impl Iterator<Item = Vec<(Couple, ContactHistory)>>,
        [rolls, stretches]: [bool; 2],
    ) {
        *self = Self { rolls, stretches, ..Self::default() };
        let mut keys = vec![Vec::new(); balls.list.len().div_ceil(CHUNK)];
        for contacts in of_chunks {
            let begin = self.couples.len();
            for (contact, (couple, history)) in (begin as u32..).zip(&contacts) {
                for (place, other, entry) in entries(contact, couple, balls) {
                    keys[chunk_of(place)].push((entry.sphere, other, entry.code));
                }
                self.couples.push(*couple);
                let [x, y, z] = history.tangential;
                self.memories.push(Memory([x, y, z, history.contact]));
                if rolls {
                    let ContactHistory { rolling: spring, twisting, .. } = *history;
                    self.rolling.push(Rolling { spring, twisting, moment: [0.0; 3] });
                }
            }
            let (count, room) = (contacts.len(), with_room(contacts.len()));
            self.resize(begin + room);
            self.chunks.push(ContactChunk { begin, count, room, ..ContactChunk::default() });
        }
        self.chunks.par_iter_mut().zip(keys).for_each(|(chunk, mut keys)| {
            keys.sort_unstable();
            chunk.entries = keys.into_iter().map(|(sphere, _, code)| Entry { code, sphere }).collect();
        });
    }

    /// Makes all lists as long as a number of contacts.
    fn resize(&mut self, count: usize) {
        self.couples.resize(count, Couple::default());
        self.memories.resize(count, Memory::default());
        self.acting.resize(count, Acting::default());
        self.rolling.resize(if self.rolls { count } else { 0 }, Rolling::default());
        self.stretched.resize(if self.stretches { count } else { 0 }, 0.0);
    }

    /// All contacts.
    pub(crate) fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.chunks.iter().flat_map(|chunk| chunk.begin..chunk.begin + chunk.count)
    }

    /// The contacts of a sphere, in the order of the other spheres' numbers.
    pub(crate) fn of(&self, place: usize) -> &[Entry] {
        let Some(chunk) = self.chunks.get(chunk_of(place as u32)) else { return &[] };
        &chunk.entries[chunk.range(place as u32)]
    }

    /// The memory of a contact.
    pub(crate) fn history(&self, contact: usize) -> ContactHistory {
        history(self.memories[contact], self.rolling.get(contact))
    }

    /// Takes the forces out of all springs across the normals.
    pub(crate) fn relax(&mut self) {
        self.memories.iter_mut().for_each(|Memory(row)| *row = [0.0, 0.0, 0.0, row[3]]);
        self.rolling.fill(Rolling::default());
    }

    /// Removes the contacts that have ended, and adds those that begin. `pairs`: places of the spheres of
    /// each couple.
    pub(crate) fn follow(&mut self, balls: &Balls, pairs: &[[u32; 2]]) {
        for number in 0..self.chunks.len() {
            let mut ended = std::mem::take(&mut self.chunks[number].ended);
            ended.sort_unstable();
            // From the last one on, because the last contact takes the place of one that goes.
            for place in ended.drain(..).rev() {
                self.remove(number, place as usize);
            }
            self.chunks[number].ended = ended;
        }
        if self.chunks.iter().any(|chunk| chunk.count + chunk.begun.len() > chunk.room) {
            self.make_room();
        }
        for number in 0..self.chunks.len() {
            let mut begun = std::mem::take(&mut self.chunks[number].begun);
            for slot in begun.drain(..) {
                self.add(number, Couple { places: pairs[slot as usize], slot }, balls);
            }
            self.chunks[number].begun = begun;
        }
    }

    fn remove(&mut self, number: usize, place: usize) {
        let chunk = &mut self.chunks[number];
        chunk.count -= 1;
        let (contact, last) = (chunk.begin + place, chunk.begin + chunk.count);
        for side in [0, 1] {
            let (of, index) = self.find(contact, side);
            self.chunks[of].entries.remove(index);
        }
        if contact == last {
            return;
        }
        for side in [0, 1] {
            let (of, index) = self.find(last, side);
            self.chunks[of].entries[index].code = (2 * contact + side) as u32;
        }
        self.couples[contact] = self.couples[last];
        self.memories[contact] = self.memories[last];
        if self.rolls {
            self.rolling[contact] = self.rolling[last];
        }
    }

    fn add(&mut self, number: usize, couple: Couple, balls: &Balls) {
        let chunk = &mut self.chunks[number];
        let contact = chunk.begin + chunk.count;
        chunk.count += 1;
        self.couples[contact] = couple;
        self.memories[contact] = Memory::default();
        if self.rolls {
            self.rolling[contact] = Rolling::default();
        }
        for (place, other, entry) in entries(contact as u32, &couple, balls) {
            let chunk = &self.chunks[chunk_of(place)];
            let range = chunk.range(place);
            let other_of = |entry: &Entry| {
                let other = self.couples[entry.contact()].places[1 - entry.side()];
                balls.list[other as usize].number
            };
            let of_place = &chunk.entries[range.clone()];
            let index = range.start + of_place.partition_point(|entry| other_of(entry) < other);
            self.chunks[chunk_of(place)].entries.insert(index, entry);
        }
    }

    /// Where the entry of a contact is: the chunk of one of its spheres, and the place in its list.
    fn find(&self, contact: usize, side: usize) -> (usize, usize) {
        let place = self.couples[contact].places[side];
        let number = chunk_of(place);
        let chunk = &self.chunks[number];
        let range = chunk.range(place);
        let code = (2 * contact + side) as u32;
        let of_place = &chunk.entries[range.clone()];
        let index = of_place.iter().position(|entry| entry.code == code);
        (number, range.start + index.expect("both spheres of a contact list it"))
    }

    /// Makes room for contacts that begin: all get other places.
    fn make_room(&mut self) {
        let before = std::mem::take(self);
        (self.rolls, self.stretches) = (before.rolls, before.stretches);
        let mut shifts = Vec::with_capacity(before.chunks.len());
        for mut chunk in before.chunks {
            let begin = self.couples.len();
            let own = chunk.begin..chunk.begin + chunk.count;
            self.couples.extend(&before.couples[own.clone()]);
            self.memories.extend(&before.memories[own.clone()]);
            if self.rolls {
                self.rolling.extend(&before.rolling[own]);
            }
            shifts.push(2 * (begin as u32).wrapping_sub(chunk.begin as u32));
            (chunk.begin, chunk.room) = (begin, with_room(chunk.count + chunk.begun.len()));
            self.resize(begin + chunk.room);
            self.chunks.push(chunk);
        }
        for chunk in &mut self.chunks {
            for entry in &mut chunk.entries {
                let of = before.couples[entry.contact()].chunk();
                entry.code = entry.code.wrapping_add(shifts[of]);
            }
        }
    }
}

/// The chunk of a place.
fn chunk_of(place: u32) -> usize {
    place as usize / CHUNK
}

/// The entries of a contact: the place of each sphere, the other sphere's number, by which the entries of a
/// sphere are sorted, and the entry.
fn entries(contact: u32, couple: &Couple, balls: &Balls) -> [(u32, u32, Entry); 2] {
    [0, 1].map(|side: usize| {
        let [place, other] = [couple.places[side], couple.places[1 - side]];
        (place, balls.list[other as usize].number, Entry::new(contact, side == 1, place))
    })
}

/// The room that some contacts get, so that others may begin.
fn with_room(count: usize) -> usize {
    count + count / 8 + 16
}

/// The history of a contact.
pub(crate) fn history(memory: Memory, rolling: Option<&Rolling>) -> ContactHistory {
    let Memory([tangential @ .., contact]) = memory;
    let Rolling { spring: rolling, twisting, .. } = rolling.copied().unwrap_or_default();
    ContactHistory { tangential, contact, rolling, twisting }
}
