//! Couples of spheres that may touch.

use fdem_contact::{Detector, Elements, PeriodicBox, PeriodicSearch, Search};

use crate::error::GrainError;
use crate::law::ContactHistory;
use crate::run::balls::{ALONE, Balls};
use crate::run::cell::RunBox;
use crate::run::contacts::{CHUNK, Contacts, Couple};
use crate::vector::Vector;

/// The couples of each sphere, by places: each couple belongs to the lower place.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    /// Where the couples of each place begin.
    pub(crate) first: Vec<u32>,
    /// The places of the two spheres of each couple; the first is the one with the lower number.
    pub(crate) pairs: Vec<[u32; 2]>,
    /// The travel, m, after which the spheres of each couple may touch. Until then the step skips the couple.
    /// Infinite while they touch.
    pub(crate) due: Vec<f32>,
    /// The couples that touch.
    pub(crate) contacts: Contacts,
    /// Number of the law of all couples, if they have one only.
    pub(crate) lone: Option<usize>,
    /// The most that two spheres can have moved against each other since the couples were found, m.
    pub(crate) travel: f64,
    /// The most that they may move until others might touch, m.
    pub(crate) skin: f64,
    /// The mean velocity of the spheres when the couples were found, m/s. Motion with it changes no distance.
    pub(crate) stream: Vector,
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
        let touching = self.contacts.all().filter(|&contact| self.contacts.memories[contact].contact() > 0.0);
        let number = |place: u32| balls.list[place as usize].number;
        let named = |contact: usize| {
            (self.contacts.couples[contact].places.map(number), self.contacts.history(contact))
        };
        let mut contacts: Remembered = touching.map(named).collect();
        contacts.sort_unstable_by_key(|(pair, _)| *pair);
        contacts
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
        (self.travel, self.due) = (0.0, vec![f32::NEG_INFINITY; self.pairs.len()]);
        let stretches = cell.is_some_and(|cell| cell.grows() && cell.servo().is_none());
        self.remind(balls, remembered, [rolls, stretches]);
        Ok(())
    }

    /// Makes the couples that touched before contacts, with their memory.
    fn remind(&mut self, balls: &Balls, remembered: &Remembered, kinds: [bool; 2]) {
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
        let Self { contacts, first, pairs, due, .. } = self;
        let of_chunks = first[..first.len() - 1].chunks(CHUNK).enumerate().map(|(chunk, places)| {
            let mut touching = Vec::new();
            for slot in places[0]..first[(chunk * CHUNK + places.len()).min(first.len() - 1)] {
                let places = pairs[slot as usize];
                if let Some(history) = known(places.map(|place| balls.list[place as usize].number)) {
                    due[slot as usize] = f32::INFINITY;
                    touching.push((Couple { places, slot }, history));
                }
            }
            touching
        });
        contacts.renew(balls, of_chunks, kinds);
    }
}
