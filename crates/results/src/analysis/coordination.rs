//! Contacts of the elements, with and without rattlers.

use serde::Serialize;

use crate::network::Network;

/// Contacts of the elements.
///
/// A couple counts for both of its elements, so that an element that touches its own image has two contacts
/// by it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coordination {
    /// Mean number of contacts, `2 m / n` for `m` couples and `n` elements; 0 without elements.
    pub mean: f64,
    /// Number of elements with `k` contacts, at index `k`.
    pub distribution: Vec<u64>,
    /// Number of contacts of each element, in the order of the centres. Not in the JSON.
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

/// The elements that can carry load: rattlers, elements with too few contacts, are removed repeatedly until
/// none is left.
///
/// By default the number of contacts is chosen from the data: `D + 1`, as without friction, or 2, as with
/// friction, if `D + 1` would remove more than half of the elements that 2 leaves. With `D + 1`, a packing
/// that friction holds would lose most of its elements, because each removed element makes rattlers of its
/// neighbours.
///
/// # Source
/// C.S. O'Hern, L.E. Silbert, A.J. Liu, S.R. Nagel, "Jamming at zero temperature and zero applied stress",
/// Phys. Rev. E 68 (2003) 011306: frictionless elements with fewer than `D + 1` contacts. With friction: K.
/// Shundyak, M. van Hecke, W. van Saarloos, Phys. Rev. E 75 (2007) 010301: fewer than 2.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WithoutRattlers {
    /// Elements with fewer contacts are rattlers.
    pub min_contacts: u32,
    /// The result with `D + 1` contacts, if 2 was chosen instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frictionless: Option<Frictionless>,
    /// Number of removed elements.
    pub rattlers: u64,
    /// Number of remaining elements.
    pub elements: u64,
    /// Number of couples among them.
    pub couples: u64,
    /// Mean number of contacts among the remaining elements; 0 if none remains.
    pub mean: f64,
    /// Number of remaining elements with `k` contacts, at index `k`.
    pub distribution: Vec<u64>,
    /// Whether each element is a rattler. Not in the JSON.
    #[serde(skip)]
    pub is_rattler: Vec<bool>,
}

/// The result for packings without friction, if it was not chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Frictionless {
    /// Elements with fewer contacts are rattlers.
    pub min_contacts: u32,
    /// Number of elements that would remain.
    pub elements: u64,
}

impl WithoutRattlers {
    /// Removes rattlers by the given number of contacts, or by a number chosen from the data.
    pub(crate) fn of<const D: usize>(
        network: &Network<'_, D>,
        coordination: &Coordination,
        min_contacts: Option<u32>,
    ) -> Self {
        /// Fewest contacts of an element held by friction.
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

    /// Removes elements with fewer contacts. The result does not depend on the order of removal.
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

/// Neighbours of each element, one per contact.
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

/// Adds one at an index of a distribution.
fn count(distribution: &mut Vec<u64>, place: u32) {
    if distribution.len() <= place as usize {
        distribution.resize(place as usize + 1, 0);
    }
    distribution[place as usize] += 1;
}

/// Returns `number / of`, or 0 if `of` is 0.
fn ratio(number: u64, of: u64) -> f64 {
    if of == 0 { 0.0 } else { number as f64 / of as f64 }
}
