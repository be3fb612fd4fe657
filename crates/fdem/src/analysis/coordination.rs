//! Contacts of the elements, with and without rattlers.

use serde::Serialize;

use crate::network::Network;

/// Contacts of the elements.
///
/// Every couple counts for both of its elements; an element that touches its own image has two contacts of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coordination {
    /// `2 m / n` of `m` couples and `n` elements; 0 without elements.
    pub mean: f64,
    /// Elements with `k` contacts, at `k`.
    pub distribution: Vec<u64>,
    /// Contacts of each element, in the order of the centres. Not in the JSON.
    #[serde(skip)]
    pub of_each: Vec<u32>,
}

impl Coordination {
    pub(crate) fn of<const D: usize>(network: &Network<'_, D>) -> Self {
        let mut of_each = vec![0_u32; network.space.centres.len()];
        for couple in network.couples.iter() {
            of_each[couple.i as usize] += 1;
            of_each[couple.j as usize] += 1;
        }
        let mut distribution = Vec::new();
        for &contacts in &of_each {
            count(&mut distribution, contacts);
        }
        let mean = ratio(2 * network.couples.len() as u64, of_each.len() as u64);
        Self { mean, distribution, of_each }
    }
}

/// The elements that carry load, if there is any: rattlers, elements with too few contacts, are removed repeatedly until none is left.
///
/// Unless the number of contacts is given, it is chosen from the data: `D + 1` for a packing without friction; 2, for one with friction, if `D + 1` would remove
/// more than half of the elements that 2 leaves. A packing that friction holds falls apart under the larger number: each element removed makes its
/// neighbours rattlers.
///
/// # Source
/// C.S. O'Hern, L.E. Silbert, A.J. Liu, S.R. Nagel, "Jamming at zero temperature and zero applied stress", Phys. Rev. E 68 (2003) 011306: frictionless elements
/// with fewer than `D + 1` contacts. With friction: K. Shundyak, M. van Hecke, W. van Saarloos, Phys. Rev. E 75 (2007) 010301: fewer than 2.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WithoutRattlers {
    /// Fewer contacts make a rattler.
    pub min_contacts: u32,
    /// What `D + 1`, the number for packings without friction, would leave: there if 2 was chosen instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frictionless: Option<Frictionless>,
    /// How many elements were removed.
    pub rattlers: u64,
    /// Elements that remain.
    pub elements: u64,
    /// Couples among them.
    pub couples: u64,
    /// Contacts of one that remains, with others that do; 0 without any.
    pub mean: f64,
    /// Elements that remain with `k` contacts, at `k`.
    pub distribution: Vec<u64>,
    /// Whether each element is a rattler. Not in the JSON.
    #[serde(skip)]
    pub is_rattler: Vec<bool>,
}

/// What a number of contacts that was not chosen would leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Frictionless {
    /// Fewer contacts make a rattler.
    pub min_contacts: u32,
    /// Elements that would remain.
    pub elements: u64,
}

impl WithoutRattlers {
    /// With this number of contacts, or the one that is chosen from the data.
    pub(crate) fn of<const D: usize>(
        network: &Network<'_, D>,
        coordination: &Coordination,
        min_contacts: Option<u32>,
    ) -> Self {
        /// The fewest contacts of an element that friction holds.
        const WITH_FRICTION: u32 = 2;
        let neighbours = Neighbours::of(network, &coordination.of_each);
        let with = |min_contacts| Self::with(&neighbours, coordination, min_contacts);
        if let Some(min_contacts) = min_contacts {
            return with(min_contacts);
        }
        let (frictionless, frictional) = (with(D as u32 + 1), with(WITH_FRICTION));
        if 2 * frictionless.elements < frictional.elements {
            let Self { min_contacts, elements, .. } = frictionless;
            return Self { frictionless: Some(Frictionless { min_contacts, elements }), ..frictional };
        }
        frictionless
    }

    /// What remains does not depend on the order in which elements are removed.
    fn with(neighbours: &Neighbours, coordination: &Coordination, min_contacts: u32) -> Self {
        let mut contacts = coordination.of_each.clone();
        let mut is_rattler: Vec<_> = contacts.iter().map(|&contacts| contacts < min_contacts).collect();
        let mut waiting: Vec<_> =
            (0..contacts.len() as u32).filter(|&element| is_rattler[element as usize]).collect();
        while let Some(rattler) = waiting.pop() {
            for &other in neighbours.of_element(rattler) {
                let left = &mut contacts[other as usize];
                *left -= 1;
                if *left < min_contacts && !std::mem::replace(&mut is_rattler[other as usize], true) {
                    waiting.push(other);
                }
            }
        }
        let mut distribution = Vec::new();
        let (mut elements, mut ends) = (0, 0);
        for (&contacts, _) in contacts.iter().zip(&is_rattler).filter(|(_, rattler)| !**rattler) {
            count(&mut distribution, contacts);
            elements += 1;
            ends += u64::from(contacts);
        }
        Self {
            min_contacts,
            frictionless: None,
            rattlers: is_rattler.len() as u64 - elements,
            elements,
            couples: ends / 2,
            mean: ratio(ends, elements),
            distribution,
            is_rattler,
        }
    }
}

/// The other elements of the couples of each element, once for each contact.
struct Neighbours {
    starts: Vec<usize>,
    others: Vec<u32>,
}

impl Neighbours {
    fn of<const D: usize>(network: &Network<'_, D>, contacts: &[u32]) -> Self {
        let mut starts = Vec::with_capacity(contacts.len() + 1);
        let mut total = 0;
        for &contacts in contacts {
            starts.push(total);
            total += contacts as usize;
        }
        let mut next = starts.clone();
        starts.push(total);
        let mut others = vec![0; total];
        for couple in network.couples.iter() {
            for (element, other) in [(couple.i, couple.j), (couple.j, couple.i)] {
                let place = &mut next[element as usize];
                others[*place] = other;
                *place += 1;
            }
        }
        Self { starts, others }
    }

    fn of_element(&self, element: u32) -> &[u32] {
        &self.others[self.starts[element as usize]..self.starts[element as usize + 1]]
    }
}

/// One more at this place.
fn count(distribution: &mut Vec<u64>, place: u32) {
    if distribution.len() <= place as usize {
        distribution.resize(place as usize + 1, 0);
    }
    distribution[place as usize] += 1;
}

/// 0 of nothing.
fn ratio(number: u64, of: u64) -> f64 {
    if of == 0 { 0.0 } else { number as f64 / of as f64 }
}
