//! Couples of spheres that may touch, their forces and their memory.

use fdem_contact::{Detector, Elements, PeriodicBox, PeriodicSearch, Search};
use rayon::prelude::*;

use crate::error::GrainError;
use crate::law::ContactHistory;
use crate::run::balls::{ALONE, Balls};
use crate::run::cell::RunBox;
use crate::run::marks::Marks;
use crate::vector::Vector;

/// Spheres that one thread computes at a time.
pub(crate) const CHUNK: usize = 512;

/// The place of the action of a couple that does not touch.
pub(crate) const APART: u32 = u32::MAX;

/// Memory that all contacts have, as in [`ContactHistory`].
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Memory {
    pub(crate) tangential: Vector,
    pub(crate) contact: f64,
}

/// Memory of contacts with rolling friction, and their moment on the first sphere, N m.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rolling {
    pub(crate) spring: Vector,
    pub(crate) twisting: f64,
    pub(crate) moment: Vector,
}

/// The history of a contact.
pub(crate) fn history(memory: Memory, rolling: Option<&Rolling>) -> ContactHistory {
    let Memory { tangential, contact } = memory;
    let Rolling { spring: rolling, twisting, .. } = rolling.copied().unwrap_or_default();
    ContactHistory { tangential, contact, rolling, twisting }
}

/// The action of a couple on its spheres. The first sphere is the one with the
/// lower number.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Acting {
    /// On the first, N; the opposite acts on the second.
    pub(crate) force: Vector,
    /// Energy that the step has dissipated, J.
    pub(crate) dissipated: f64,
    /// The moments on the two, over the distances of the contact from their centres, N.
    pub(crate) torque: Vector,
    /// m.
    pub(crate) overlap: f64,
}

/// The couples of each sphere, by places: each couple belongs to the lower place.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    /// Where the couples of each place begin.
    pub(crate) first: Vec<u32>,
    /// The places of the two spheres of each couple; the first is the one with the lower number.
    pub(crate) pairs: Vec<[u32; 2]>,
    pub(crate) memories: Vec<Memory>,
    /// Empty without rolling friction.
    pub(crate) rolling: Vec<Rolling>,
    /// Number of the law of all couples, if they have one only.
    pub(crate) lone: Option<usize>,
    /// The travel, m, after which the spheres of each couple may touch. Until then the step skips the couple.
    pub(crate) due: Vec<f32>,
    /// The most that two spheres can have moved against each other since the couples were found, m.
    pub(crate) travel: f64,
    /// The most that they may move until others might touch, m.
    pub(crate) skin: f64,
    /// The mean velocity of the spheres when the couples were found, m/s. Motion with it changes no distance.
    pub(crate) stream: Vector,
    /// Where the action of each couple is in `acting`, or [`APART`].
    pub(crate) acted: Vec<u32>,
    /// Actions, packed at the beginning of the part of each chunk: those of couples that do not touch are not
    /// read.
    pub(crate) acting: Vec<Acting>,
    /// Work of the box on each couple in the step, J; empty if the box does not grow, or has a servo.
    pub(crate) stretched: Vec<f64>,
    /// Where the couples of each place, as the lower or the higher one, begin in `incidents`.
    pub(crate) first_incident: Vec<u32>,
    /// Couples in ascending order of the other sphere's number: twice the slot, and 1 more where the sphere
    /// is the second.
    pub(crate) incidents: Vec<u32>,
    /// Where each couple is in `incidents`: of its first and of its second sphere.
    pub(crate) incident: Vec<[u32; 2]>,
    /// The incidents of couples that have an action.
    pub(crate) touching: Marks,
}

/// Contacts that touch, with their memory: pairs of numbers, ascending.
pub(crate) type Remembered = Vec<([u32; 2], ContactHistory)>;

/// The search for couples.
#[derive(Debug)]
pub(crate) enum Finder {
    Space(Box<Detector<f64, 3>>),
    Periodic(Box<PeriodicSearch<f64, 3>>),
}

impl Finder {
    /// The couples of spheres, by places, whose surfaces are at most `gap` apart, m, in no order.
    fn couples(
        &mut self,
        balls: &Balls,
        gap: f64,
        cell: Option<&RunBox>,
    ) -> Result<Vec<[u32; 2]>, GrainError> {
        let wrong = |error: fdem_contact::Error| GrainError::Search(error.to_string());
        let positions: Vec<Vector> = balls.list.iter().map(|ball| ball.position).collect();
        let radii: Vec<f64> = balls.list.iter().map(|ball| ball.radius + 0.5 * gap).collect();
        if positions.is_empty() {
            return Ok(Vec::new());
        }
        let elements = Elements::spheres_with_radii(&positions, &radii).map_err(wrong)?;
        match (self, cell) {
            (Self::Periodic(search), Some(cell)) => {
                let largest = radii.iter().copied().fold(0.0, f64::max);
                for axis in (0..3).filter(|&axis| cell.periodic()[axis]) {
                    // Two spheres touch one image of each other only.
                    if cell.lengths[axis] <= 4.0 * largest {
                        return Err(GrainError::Box {
                            axis,
                            length: cell.lengths[axis],
                            least: 4.0 * largest,
                        });
                    }
                }
                let high = [0, 1, 2].map(|axis| cell.low[axis] + cell.lengths[axis]);
                let cell = PeriodicBox::orthogonal(cell.low, high, cell.periodic()).map_err(wrong)?;
                let mut couples = Vec::new();
                search.couples(&elements, &cell, &mut couples).map_err(wrong)?;
                Ok(couples.into_iter().map(|couple| [couple.i, couple.j]).collect())
            }
            (Self::Space(search), _) => {
                let mut couples = Vec::new();
                search.couples(&elements, &mut couples).map_err(wrong)?;
                Ok(couples.into_iter().map(|couple| [couple.i, couple.j]).collect())
            }
            (Self::Periodic(_), None) => Ok(Vec::new()),
        }
    }
}

impl Lists {
    /// The contacts that touch, with their memory, by numbers in ascending order.
    pub(crate) fn remember(&self, balls: &Balls) -> Remembered {
        let mut contacts = Vec::new();
        for place in 0..self.first.len().saturating_sub(1) {
            for slot in self.first[place] as usize..self.first[place + 1] as usize {
                if self.memories[slot].contact > 0.0 {
                    let pair = self.pairs[slot].map(|place| balls.list[place as usize].number);
                    contacts.push((pair, self.history(slot)));
                }
            }
        }
        contacts.sort_unstable_by_key(|(pair, _)| *pair);
        contacts
    }

    /// The memory of a couple.
    pub(crate) fn history(&self, slot: usize) -> ContactHistory {
        history(self.memories[slot], self.rolling.get(slot))
    }

    /// Takes the forces out of all springs across the normals.
    pub(crate) fn relax(&mut self) {
        self.memories.iter_mut().for_each(|memory| memory.tangential = [0.0; 3]);
        self.rolling.fill(Rolling::default());
    }

    /// Finds the couples whose surfaces are at most `gap` apart, m, and gives them their memory.
    pub(crate) fn renew(
        &mut self,
        balls: &Balls,
        finder: &mut Finder,
        gap: f64,
        cell: Option<&RunBox>,
        (remembered, rolls): (&Remembered, bool),
    ) -> Result<(), GrainError> {
        let mut couples = finder.couples(balls, gap, cell)?;
        if !balls.pushes.is_empty() {
            let clump = |place: u32| balls.kinds[place as usize].clump;
            couples.retain(|&[low, high]| clump(low) == ALONE || clump(low) != clump(high));
        }
        let count = balls.list.len();
        let mut first = vec![0_u32; count + 1];
        for [low, _] in &couples {
            first[*low as usize + 1] += 1;
        }
        (0..count).for_each(|place| first[place + 1] += first[place]);
        let mut next = first.clone();
        let mut pairs = vec![[0_u32; 2]; couples.len()];
        for &[low, high] in &couples {
            let slot = &mut next[low as usize];
            let is_first = balls.list[low as usize].number < balls.list[high as usize].number;
            pairs[*slot as usize] = if is_first { [low, high] } else { [high, low] };
            *slot += 1;
        }
        (self.first, self.pairs) = (first, pairs);
        self.remind(balls, remembered, rolls);
        (self.travel, self.due) = (0.0, vec![f32::NEG_INFINITY; self.pairs.len()]);
        self.acting.clear();
        self.acting.resize(self.pairs.len(), Acting::default());
        self.acted.clear();
        let places = (0..).zip(&self.memories);
        self.acted.extend(places.map(|(slot, memory)| if memory.contact == 0.0 { APART } else { slot }));
        self.stretched.clear();
        if cell.is_some_and(|cell| cell.grows() && cell.servo().is_none()) {
            self.stretched.resize(self.pairs.len(), 0.0);
        }
        self.find_incidents(balls);
        Ok(())
    }

    /// Gives the couples that touched before their memory.
    fn remind(&mut self, balls: &Balls, remembered: &Remembered, rolls: bool) {
        let last = remembered.last().map_or(0, |(pair, _)| pair[0] as usize + 1);
        let mut begins = vec![0_u32; last + 1];
        for ([lower, _], _) in remembered {
            begins[*lower as usize + 1] += 1;
        }
        (0..last).for_each(|number| begins[number + 1] += begins[number]);
        let known = |pair: [u32; 2]| {
            let lower = pair[0] as usize;
            let range = if lower < last { begins[lower]..begins[lower + 1] } else { 0..0 };
            let of_lower = &remembered[range.start as usize..range.end as usize];
            of_lower.iter().find(|([_, number], _)| *number == pair[1]).map(|(_, history)| *history)
        };
        self.memories.clear();
        self.memories.resize(self.pairs.len(), Memory::default());
        self.rolling.clear();
        self.rolling.resize(if rolls { self.pairs.len() } else { 0 }, Rolling::default());
        for (slot, pair) in self.pairs.iter().enumerate() {
            let Some(history) = known(pair.map(|place| balls.list[place as usize].number)) else {
                continue;
            };
            let ContactHistory { tangential, contact, rolling, twisting } = history;
            self.memories[slot] = Memory { tangential, contact };
            if let Some(of_slot) = self.rolling.get_mut(slot) {
                *of_slot = Rolling { spring: rolling, twisting, moment: [0.0; 3] };
            }
        }
    }

    /// Lists the couples of each sphere in the order of the other spheres' numbers: so the sums of forces
    /// depend neither on places nor on candidates that do not touch.
    fn find_incidents(&mut self, balls: &Balls) {
        let count = balls.list.len();
        let mut first = vec![0_u32; count + 1];
        for place in self.pairs.as_flattened() {
            first[*place as usize + 1] += 1;
        }
        (0..count).for_each(|place| first[place + 1] += first[place]);
        let mut next = first.clone();
        // With the number of the other sphere.
        let mut incidents = vec![(0_u32, 0_u32); 2 * self.pairs.len()];
        for (slot, pair) in (0..).zip(&self.pairs) {
            for (is_second, place) in [(0, pair[0]), (1, pair[1])] {
                let other = balls.list[pair[1 - is_second as usize] as usize].number;
                let index = &mut next[place as usize];
                incidents[*index as usize] = (other, 2 * slot + is_second);
                *index += 1;
            }
        }
        let mut parts = Vec::with_capacity(count.div_ceil(CHUNK));
        let mut rest = incidents.as_mut_slice();
        for begin in (0..count).step_by(CHUNK) {
            let ends = &first[begin..=(begin + CHUNK).min(count)];
            let (part, more) = rest.split_at_mut((ends[ends.len() - 1] - ends[0]) as usize);
            rest = more;
            parts.push((ends, part));
        }
        parts.into_par_iter().for_each(|(ends, part)| {
            for range in ends.windows(2) {
                part[(range[0] - ends[0]) as usize..(range[1] - ends[0]) as usize].sort_unstable();
            }
        });
        self.first_incident = first;
        self.incidents.clear();
        self.incidents.extend(incidents.into_iter().map(|(_, incident)| incident));
        self.incident.clear();
        self.incident.resize(self.pairs.len(), [0; 2]);
        self.touching = Marks::new(self.incidents.len());
        for (index, &incident) in (0..).zip(&self.incidents) {
            let slot = incident as usize / 2;
            self.incident[slot][incident as usize % 2] = index;
            if self.acted[slot] != APART {
                self.touching.add(index);
            }
        }
    }
}
