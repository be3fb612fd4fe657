//! Couples in order over all ranks.

use fdem_contact::{Couple, PeriodicCouple};

use crate::communicator::{Communicator, Message};
use crate::division::Division;

/// A couple that can be sorted and sent.
pub(crate) trait Sortable: Copy + Ord {
    /// Length in a message.
    const BYTES: usize;

    /// The two elements as one number, whose order is that of couples.
    fn key(&self) -> u64;
    fn write(&self, bytes: &mut [u8]);
    fn read(bytes: &[u8]) -> Self;
}

impl Sortable for Couple {
    const BYTES: usize = 8;

    #[inline]
    fn key(&self) -> u64 {
        u64::from(self.i) << 32 | u64::from(self.j)
    }

    #[inline]
    fn write(&self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.key().to_le_bytes());
    }

    #[inline]
    fn read(bytes: &[u8]) -> Self {
        let key = bytes.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        Self { i: (key >> 32) as u32, j: key as u32 }
    }
}

impl<const D: usize> Sortable for PeriodicCouple<D> {
    const BYTES: usize = 8 + 4 * D;

    #[inline]
    fn key(&self) -> u64 {
        Couple { i: self.i, j: self.j }.key()
    }

    fn write(&self, bytes: &mut [u8]) {
        let (couple, shift) = bytes.split_at_mut(8);
        Couple { i: self.i, j: self.j }.write(couple);
        for (bytes, edges) in shift.as_chunks_mut().0.iter_mut().zip(self.shift) {
            *bytes = edges.to_le_bytes();
        }
    }

    fn read(bytes: &[u8]) -> Self {
        let (couple, shift) = bytes.split_at(8);
        let (Couple { i, j }, shift) = (Couple::read(couple), shift.as_chunks().0);
        Self { i, j, shift: std::array::from_fn(|edge| i32::from_le_bytes(shift[edge])) }
    }
}

/// Cells of keys, which are counted from the first one on.
#[derive(Clone, Copy)]
struct Cells {
    first: u64,
    /// Number of bits of a key inside its cell.
    shift: u32,
    count: usize,
}

/// Largest number of cells. Each has a place in memory that is written to, and the processor keeps track of
/// about this number of pages.
const MOST_CELLS: usize = 1 << 10;

/// Elements whose couples are in one cell, if no rank has more than the others and ids are consecutive.
const IN_CELL: usize = 1 << 8;

impl Cells {
    /// Cells for the couples of the elements of all ranks, of which this one has these. Collective.
    fn new(communicator: &dyn Communicator, ids: &[u32]) -> Self {
        let low = ids.iter().min().map_or(f64::INFINITY, |id| f64::from(*id));
        let high = ids.iter().max().map_or(f64::NEG_INFINITY, |id| f64::from(*id));
        let mut extremes = [-low, high, ids.len() as f64];
        communicator.all_max(&mut extremes);
        let [first, last] = [-extremes[0], extremes[1]].map(|i| (i as u64) << 32);
        let wanted = (extremes[2] as usize / IN_CELL).clamp(2, MOST_CELLS);
        let span = last.saturating_sub(first) | u64::from(u32::MAX);
        let shift = (u64::BITS - span.leading_zeros()) - wanted.ilog2();
        Self { first, shift, count: (span >> shift) as usize + 1 }
    }

    #[inline]
    fn key<C: Sortable>(&self, couple: &C) -> u64 {
        couple.key() - self.first
    }

    #[inline]
    fn cell<C: Sortable>(&self, couple: &C) -> usize {
        (self.key(couple) >> self.shift) as usize
    }
}

/// The couples that a rank has found, and how many there are in each cell.
pub(crate) struct FoundCouples<C> {
    couples: Vec<C>,
    cells: Cells,
    counts: Vec<usize>,
}

impl<C: Sortable> FoundCouples<C> {
    /// No couples yet. `ids` are those of this rank's elements. Collective.
    pub(crate) fn new(communicator: &dyn Communicator, ids: &[u32]) -> Self {
        let cells = Cells::new(communicator, ids);
        Self { couples: Vec::new(), cells, counts: vec![0; cells.count] }
    }

    pub(crate) fn len(&self) -> usize {
        self.couples.len()
    }

    #[inline]
    pub(crate) fn push(&mut self, couple: C) {
        self.counts[self.cells.cell(&couple)] += 1;
        self.couples.push(couple);
    }

    /// Sorts the couples of all ranks. Afterwards the ranks, one after the other, have consecutive runs of
    /// about the same length. Collective.
    ///
    /// Each rank sorts its couples into cells, and writes them to the messages in which they are sent. The
    /// rank that owns a cell sorts the couples in it while they are in cache.
    pub(crate) fn sorted(self, communicator: &dyn Communicator) -> Vec<C> {
        let Self { mut couples, cells, counts } = self;
        let division = Division::new(communicator, &counts, cells.shift, |is_marked| {
            let marked = couples.iter().filter(|couple| is_marked[cells.cell(*couple)]);
            marked.map(|couple| cells.key(couple)).collect()
        });
        let messages = messages(&couples, cells, &division);
        couples.clear();
        let received = communicator.exchange(messages);
        let bytes: usize = received.iter().map(|message| message.bytes.len()).sum();
        couples.reserve_exact(bytes / C::BYTES);

        let mut runs: Vec<&[u8]> = received.iter().map(|message| &message.bytes[..]).collect();
        let mut counts = Vec::new();
        for part in division.parts().iter().filter(|part| part.owner == communicator.rank()) {
            let of_cell = runs.iter_mut().map(|run| {
                let all = run.chunks_exact(C::BYTES).map(C::read);
                let count = all.take_while(|couple| cells.cell(couple) == part.cell).count();
                run.split_off(..count * C::BYTES).unwrap_or_default()
            });
            let of_cell: Vec<&[u8]> = of_cell.collect();
            append_sorted(&of_cell, cells, &mut counts, &mut couples);
        }
        couples
    }
}

/// The couples of each rank, in the order of the cells.
fn messages<C: Sortable>(couples: &[C], cells: Cells, division: &Division) -> Vec<Message> {
    let of_owners = division.parts().chunk_by(|a, b| a.owner == b.owner);
    let empty = of_owners.map(|parts| {
        let count: usize = parts.iter().map(|part| part.count).sum();
        Message { rank: parts[0].owner, bytes: vec![0; count * C::BYTES] }
    });
    let mut messages: Vec<Message> = empty.collect();
    let mut rooms: Vec<&mut [u8]> = Vec::with_capacity(division.parts().len());
    for (message, parts) in messages.iter_mut().zip(division.parts().chunk_by(|a, b| a.owner == b.owner)) {
        let mut rest = &mut message.bytes[..];
        rooms
            .extend(parts.iter().map(|part| rest.split_off_mut(..part.count * C::BYTES).unwrap_or_default()));
    }
    for couple in couples {
        let key = cells.key(couple);
        let room = &mut rooms[division.part((key >> cells.shift) as usize, || key)];
        if let Some(bytes) = room.split_off_mut(..C::BYTES) {
            couple.write(bytes);
        }
    }
    messages.retain(|message| !message.bytes.is_empty());
    messages
}

/// Most bits of a digit.
const MOST_DIGIT_BITS: u32 = 14;

/// Few couples are sorted by insertion.
const FEW: usize = 16;

/// Appends the couples of one cell in their order. They come in several runs. `ends` is memory.
fn append_sorted<C: Sortable>(runs: &[&[u8]], cells: Cells, ends: &mut Vec<usize>, couples: &mut Vec<C>) {
    let all = || runs.iter().flat_map(|run| run.chunks_exact(C::BYTES)).map(C::read);
    let Some(first) = all().next() else { return };
    let start = couples.len();
    couples.resize(start + runs.iter().map(|run| run.len()).sum::<usize>() / C::BYTES, first);
    let sorted = &mut couples[start..];
    // There are about as many digits as couples. The first bits of a key in its cell are those of the first
    // element.
    let bits = sorted.len().ilog2().min(MOST_DIGIT_BITS).min(cells.shift);
    let digit = |couple: &C| (cells.key(couple) >> (cells.shift - bits)) as usize & ((1 << bits) - 1);
    ends.clear();
    ends.resize(1 << bits, 0);
    all().for_each(|couple| ends[digit(&couple)] += 1);
    let mut end = 0;
    for count in &mut *ends {
        end += std::mem::replace(count, end);
    }
    all().for_each(|couple| {
        let place = &mut ends[digit(&couple)];
        sorted[*place] = couple;
        *place += 1;
    });
    let mut start = 0;
    for &end in &*ends {
        sort_few(&mut sorted[start..end]);
        start = end;
    }
}

/// Sorts couples, mostly few.
#[inline]
fn sort_few<C: Sortable>(couples: &mut [C]) {
    if couples.len() > FEW {
        couples.sort_unstable();
        return;
    }
    for next in 1..couples.len() {
        let couple = couples[next];
        let mut place = next;
        while place > 0 && couples[place - 1] > couple {
            couples[place] = couples[place - 1];
            place -= 1;
        }
        couples[place] = couple;
    }
}
