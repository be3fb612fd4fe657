//! Ranks that are threads of one process: for tests, and where there is no MPI.

use std::collections::{BTreeMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, SyncSender};
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::communicator::{Communicator, Halo, Message, Port, check_messages, check_other};

/// Messages of [`Communicator::send`] that wait between two ranks before the sender waits. Small, so that a
/// program that would lock up under MPI does so here.
const WAITING: usize = 1;

/// The collective call to which a message belongs. If ranks are in different calls, the program has a
/// mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Barrier,
    Exchange,
    AllGather,
    Broadcast,
    AllSum,
    AllMax,
}

/// A message of a collective call; `None` if an exchange has nothing for the rank.
type Collective = (Call, Option<Vec<u8>>);

/// A message of a halo, with the number of the halo.
type OfHalo = (u64, Vec<u8>);

/// A rank: its channels to all ranks. They close when the rank ends, and threads that wait for it notice.
struct Thread {
    rank: usize,
    to_all: Vec<Sender<Collective>>,
    from_all: Vec<Mutex<Receiver<Collective>>>,
    to_one: Vec<SyncSender<Vec<u8>>>,
    from_one: Vec<Mutex<Receiver<Vec<u8>>>>,
    to_neighbour: Vec<Sender<OfHalo>>,
    from_neighbour: Vec<Mutex<Inbox>>,
    halos: AtomicU64,
}

/// The messages of halos from one rank. Messages that arrive before they are waited for are kept by the
/// number of their halo.
struct Inbox {
    receiver: Receiver<OfHalo>,
    early: BTreeMap<u64, VecDeque<Vec<u8>>>,
}

/// The panic of a rank that waited for one that had ended. It is not the cause, so it is not the one that is
/// passed on.
struct Abandoned;

/// Ends this rank because another one has ended.
fn abandoned() -> ! {
    // Without the message of a panic: the rank that ended first has written one.
    resume_unwind(Box::new(Abandoned))
}

/// Runs `work` on `size` ranks, each a thread, and returns their results in the order of the ranks.
///
/// # Panics
/// If `work` panics on a rank: the others stop as soon as they wait for that rank, and its panic is passed
/// on. Also if `size` is 0, if the ranks make different collective calls, or if a rank waits for one that has
/// returned.
///
/// # Example
/// ```
/// let all = fdem_distributed::threads::run(2, |communicator| communicator.all_gather(&[communicator.rank() as u8]));
/// assert_eq!(all, [[[0], [1]], [[0], [1]]]);
/// ```
pub fn run<T: Send>(size: usize, work: impl Fn(&dyn Communicator) -> T + Sync) -> Vec<T> {
    assert!(size > 0, "at least one rank");
    let done: Vec<thread::Result<T>> = thread::scope(|scope| {
        let work = &work;
        let started: Vec<_> = ranks(size)
            .into_iter()
            .map(|rank| {
                // The channels close with the rank, before anybody joins the thread.
                scope
                    .spawn(move || catch_unwind(AssertUnwindSafe(|| work(&rank))).inspect_err(|_| drop(rank)))
            })
            .collect();
        started.into_iter().map(|thread| thread.join().unwrap_or_else(Err)).collect()
    });
    let mut results = Vec::with_capacity(size);
    let mut left = false;
    let mut panics = Vec::new();
    for result in done {
        match result {
            Ok(result) => results.push(result),
            Err(panic) if panic.is::<Abandoned>() => left = true,
            Err(panic) => panics.push(panic),
        }
    }
    if let Some(panic) = panics.into_iter().next() {
        resume_unwind(panic);
    }
    assert!(!left, "a rank waited for one that had returned");
    results
}

/// Makes the ranks and all channels between them.
fn ranks(size: usize) -> Vec<Thread> {
    let mut ranks: Vec<Thread> = (0..size)
        .map(|rank| Thread {
            rank,
            to_all: Vec::new(),
            from_all: Vec::new(),
            to_one: Vec::new(),
            from_one: Vec::new(),
            to_neighbour: Vec::new(),
            from_neighbour: Vec::new(),
            halos: AtomicU64::new(0),
        })
        .collect();
    for from in 0..size {
        for to in 0..size {
            let (sender, receiver) = mpsc::channel();
            ranks[from].to_all.push(sender);
            ranks[to].from_all.push(Mutex::new(receiver));
            let (sender, receiver) = mpsc::sync_channel(WAITING);
            ranks[from].to_one.push(sender);
            ranks[to].from_one.push(Mutex::new(receiver));
            let (sender, receiver) = mpsc::channel();
            ranks[from].to_neighbour.push(sender);
            ranks[to].from_neighbour.push(Mutex::new(Inbox { receiver, early: BTreeMap::new() }));
        }
    }
    ranks
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Thread {
    fn tell(&self, to: usize, call: Call, bytes: Option<Vec<u8>>) {
        if self.to_all[to].send((call, bytes)).is_err() {
            abandoned();
        }
    }

    fn hear(&self, from: usize, call: Call) -> Option<Vec<u8>> {
        let Ok((of, bytes)) = lock(&self.from_all[from]).recv() else { abandoned() };
        assert!(of == call, "rank {} is in {call:?}, rank {from} in {of:?}", self.rank);
        bytes
    }

    /// The bytes of all ranks.
    fn gather(&self, call: Call, bytes: &[u8]) -> Vec<Vec<u8>> {
        for to in 0..self.size() {
            self.tell(to, call, Some(bytes.to_vec()));
        }
        (0..self.size()).map(|from| self.hear(from, call).unwrap_or_default()).collect()
    }

    /// Combines each value with those of the other ranks, in the order of the ranks.
    fn reduce<V: Copy>(
        &self,
        call: Call,
        values: &mut [V],
        bytes: fn(V) -> [u8; 8],
        combine: fn(V, [u8; 8]) -> V,
        first: V,
    ) {
        let own: Vec<u8> = values.iter().flat_map(|&value| bytes(value)).collect();
        values.fill(first);
        for other in self.gather(call, &own) {
            let (other, _) = other.as_chunks::<8>();
            assert!(other.len() == values.len(), "as many values on each rank");
            for (value, other) in values.iter_mut().zip(other) {
                *value = combine(*value, *other);
            }
        }
    }
}

impl Communicator for Thread {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to_all.len()
    }

    fn barrier(&self) {
        self.gather(Call::Barrier, &[]);
    }

    fn exchange(&self, messages: Vec<Message>) -> Vec<Message> {
        check_messages(&messages, self.size());
        let mut bytes = vec![None; self.size()];
        for message in messages {
            bytes[message.rank] = Some(message.bytes);
        }
        for (to, bytes) in bytes.into_iter().enumerate() {
            self.tell(to, Call::Exchange, bytes);
        }
        (0..self.size())
            .filter_map(|rank| self.hear(rank, Call::Exchange).map(|bytes| Message { rank, bytes }))
            .collect()
    }

    fn all_gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        self.gather(Call::AllGather, bytes)
    }

    fn broadcast(&self, bytes: &mut Vec<u8>) {
        if self.rank == 0 {
            (1..self.size()).for_each(|to| self.tell(to, Call::Broadcast, Some(bytes.clone())));
        } else {
            *bytes = self.hear(0, Call::Broadcast).unwrap_or_default();
        }
    }

    fn all_sum(&self, values: &mut [i64]) {
        let add = |sum: i64, bytes| sum.wrapping_add(i64::from_le_bytes(bytes));
        self.reduce(Call::AllSum, values, i64::to_le_bytes, add, 0);
    }

    fn all_max(&self, values: &mut [f64]) {
        let larger = |most: f64, bytes| most.max(f64::from_le_bytes(bytes));
        self.reduce(Call::AllMax, values, f64::to_le_bytes, larger, f64::NEG_INFINITY);
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        check_other(to, self.rank, self.size());
        if self.to_one[to].send(bytes.to_vec()).is_err() {
            abandoned();
        }
    }

    fn receive(&self, from: usize) -> Vec<u8> {
        check_other(from, self.rank, self.size());
        lock(&self.from_one[from]).recv().unwrap_or_else(|_| abandoned())
    }

    fn halo(&self, send: &[Port], receive: &[Port]) -> Box<dyn Halo + '_> {
        let empty = |ports: &[Port]| ports.iter().map(|port| (port.rank, vec![0; port.bytes])).collect();
        Box::new(Neighbours {
            of: self,
            number: self.halos.fetch_add(1, Ordering::Relaxed),
            outgoing: empty(send),
            incoming: empty(receive),
            started: false,
        })
    }

    fn abort(&self, code: i32) -> ! {
        resume_unwind(Box::new(format!("rank {} ended the program with code {code}", self.rank)))
    }
}

/// The halo of a rank that is a thread.
struct Neighbours<'a> {
    of: &'a Thread,
    /// The halos of a communicator have the same numbers on all ranks.
    number: u64,
    /// Ranks and bytes by port.
    outgoing: Vec<(usize, Vec<u8>)>,
    incoming: Vec<(usize, Vec<u8>)>,
    started: bool,
}

impl Halo for Neighbours<'_> {
    fn outgoing(&mut self, port: usize) -> &mut [u8] {
        assert!(!self.started, "the messages are under way");
        &mut self.outgoing[port].1
    }

    fn start(&mut self) {
        assert!(!self.started, "the messages are under way");
        self.started = true;
        for (to, bytes) in &self.outgoing {
            if self.of.to_neighbour[*to].send((self.number, bytes.clone())).is_err() {
                abandoned();
            }
        }
    }

    fn finish(&mut self) {
        assert!(self.started, "the messages have been started");
        self.started = false;
        for (from, bytes) in &mut self.incoming {
            let received = lock(&self.of.from_neighbour[*from]).next(self.number);
            assert!(received.len() == bytes.len(), "rank {from} sends as many bytes as are expected");
            *bytes = received;
        }
    }

    fn incoming(&self, port: usize) -> &[u8] {
        assert!(!self.started, "the messages are under way");
        &self.incoming[port].1
    }
}

impl Inbox {
    /// The next message of a halo.
    fn next(&mut self, halo: u64) -> Vec<u8> {
        if let Some(bytes) = self.early.get_mut(&halo).and_then(VecDeque::pop_front) {
            return bytes;
        }
        loop {
            match self.receiver.recv() {
                Ok((of, bytes)) if of == halo => return bytes,
                Ok((of, bytes)) => self.early.entry(of).or_default().push_back(bytes),
                Err(_) => abandoned(),
            }
        }
    }
}
