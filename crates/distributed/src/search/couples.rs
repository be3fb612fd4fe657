//! Couples in order over all ranks.

use fdem_contact::PeriodicCouple;

use crate::communicator::{Communicator, Message};
use crate::curve::{even_splitters, owner};
use crate::wire::{Reader, Writer};

/// The two elements of a couple as one number, whose order is that of couples.
pub(crate) fn key(i: u32, j: u32) -> u64 {
    u64::from(i) << 32 | u64::from(j)
}

/// A couple that can be sorted and sent.
pub(crate) trait Sortable: Copy + Ord {
    fn key(&self) -> u64;
    fn write(couples: &[Self], out: &mut Writer);
    fn read(bytes: &[u8], couples: &mut Vec<Self>);
}

impl Sortable for u64 {
    fn key(&self) -> u64 {
        *self
    }

    fn write(couples: &[Self], out: &mut Writer) {
        out.u64s(couples.iter().copied());
    }

    fn read(bytes: &[u8], couples: &mut Vec<Self>) {
        couples.extend(Reader::new(bytes).u64s(bytes.len() / 8));
    }
}

impl<const D: usize> Sortable for PeriodicCouple<D> {
    fn key(&self) -> u64 {
        key(self.i, self.j)
    }

    fn write(couples: &[Self], out: &mut Writer) {
        out.u64s(couples.iter().map(Sortable::key));
        out.shifts(couples.iter().map(|couple| couple.shift));
    }

    fn read(bytes: &[u8], couples: &mut Vec<Self>) {
        let count = bytes.len() / (8 + 4 * D);
        let mut from = Reader::new(bytes);
        let keys = from.u64s(count);
        let pairs = keys.zip(from.shifts::<D>(count));
        couples.extend(pairs.map(|(key, shift)| Self { i: (key >> 32) as u32, j: key as u32, shift }));
    }
}

/// Sorts the couples of all ranks. Afterwards the ranks, one after the other, have consecutive runs of about the same length. Collective.
pub(crate) fn sort<C: Sortable>(communicator: &dyn Communicator, mut couples: Vec<C>) -> Vec<C> {
    couples.sort_unstable();
    if communicator.size() == 1 {
        return couples;
    }
    let splitters = even_splitters(communicator, &couples, Sortable::key);
    let messages =
        couples.chunk_by(|a, b| owner(&splitters, a.key()) == owner(&splitters, b.key())).map(|run| {
            let mut out = Writer::default();
            C::write(run, &mut out);
            Message { rank: owner(&splitters, run[0].key()), bytes: out.bytes }
        });
    let messages: Vec<Message> = messages.collect();
    drop(couples);
    let received = communicator.exchange(messages);
    let mut couples = Vec::with_capacity(
        received.iter().map(|message| message.bytes.len()).sum::<usize>() / size_of::<C>(),
    );
    for message in received {
        C::read(&message.bytes, &mut couples);
    }
    // Each rank sends a sorted run. A stable sort merges runs.
    couples.sort();
    couples
}
