//! The messages between ranks: one trait, which threads of a process and processes under MPI implement.

/// Bytes for a rank, or from one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message {
    /// The rank that the bytes are sent to; in a received message, the rank that sent them.
    pub rank: usize,
    /// The content, of any length.
    pub bytes: Vec<u8>,
}

/// One message of a [`Halo`], of fixed length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Port {
    /// The rank at the other end.
    pub rank: usize,
    /// Length of the message.
    pub bytes: usize,
}

/// Ranks that work together: processes, or threads of one process, numbered from 0.
///
/// Calls are collective unless their description says otherwise: every rank makes the same calls in the same
/// order. A call that fails ends all ranks with a message; a rank that panics ends the others too. A rank
/// uses its communicator from one thread at a time.
///
/// # Example
/// ```
/// use fdem_distributed::threads;
///
/// let sums = threads::run(3, |communicator| {
///     let mut values = [1, communicator.rank() as i64];
///     communicator.all_sum(&mut values);
///     values
/// });
/// assert_eq!(sums, [[3, 3]; 3]);
/// ```
pub trait Communicator: Send + Sync {
    /// The number of this rank. Not collective.
    fn rank(&self) -> usize;

    /// The number of ranks. Not collective.
    fn size(&self) -> usize;

    /// Waits until all ranks have come here.
    fn barrier(&self);

    /// Sends messages, and returns those that other ranks have sent to this one, by sender in ascending
    /// order.
    ///
    /// At most one message for each rank. A message to the rank itself is handed back without a copy. The
    /// cost grows with the messages of this rank, and little with the number of ranks, so a rank may leave
    /// out ranks to which it has nothing to say.
    ///
    /// # Panics
    /// If a rank does not exist, or is named twice.
    fn exchange(&self, messages: Vec<Message>) -> Vec<Message>;

    /// Returns the bytes of all ranks, in the order of the ranks. For short messages: every rank gets all of
    /// them.
    fn all_gather(&self, bytes: &[u8]) -> Vec<Vec<u8>>;

    /// Replaces the bytes by those of rank 0.
    fn broadcast(&self, bytes: &mut Vec<u8>);

    /// Replaces each value by its sum over all ranks. The sum wraps around, so it is the same in any order.
    ///
    /// # Panics
    /// If the ranks have different numbers of values.
    fn all_sum(&self, values: &mut [i64]);

    /// Replaces each value by its maximum over all ranks. NaN is not allowed.
    ///
    /// # Panics
    /// If the ranks have different numbers of values.
    fn all_max(&self, values: &mut [f64]);

    /// Sends bytes to another rank, which calls [`receive`](Self::receive). Messages between two ranks keep
    /// their order.
    ///
    /// Not collective. The call may wait until the other rank receives, so that a stream of messages takes
    /// bounded memory.
    ///
    /// # Panics
    /// If there is no such other rank.
    fn send(&self, to: usize, bytes: &[u8]);

    /// Waits for the next message that another rank has [sent](Self::send) to this one. Not collective.
    ///
    /// # Panics
    /// If there is no such other rank.
    fn receive(&self, from: usize) -> Vec<u8>;

    /// Prepares messages of fixed lengths that are sent many times, one set of messages at a time.
    ///
    /// The first port to a rank is connected with the first port that receives from this one there, and so
    /// on; their lengths are equal. A rank without neighbours passes no ports. Ports to the rank itself are
    /// allowed.
    fn halo(&self, send: &[Port], receive: &[Port]) -> Box<dyn Halo + '_>;

    /// Ends all ranks with an exit code. Not collective.
    fn abort(&self, code: i32) -> !;
}

/// Messages of fixed lengths between neighbours: fill, start, work, finish, read; then again.
///
/// The calls are collective among neighbours: if one starts, so do the others. Several halos may be under way
/// at the same time.
///
/// # Example
/// ```
/// use fdem_distributed::{Port, threads};
///
/// // Each rank sends its number to the next one, in a ring.
/// let received = threads::run(3, |communicator| {
///     let (rank, size) = (communicator.rank(), communicator.size());
///     let (next, previous) = ((rank + 1) % size, (rank + size - 1) % size);
///     let mut halo = communicator.halo(&[Port { rank: next, bytes: 1 }], &[Port { rank: previous, bytes: 1 }]);
///     halo.outgoing(0)[0] = rank as u8;
///     halo.start();
///     // Work that needs nothing from the neighbours.
///     halo.finish();
///     halo.incoming(0)[0]
/// });
/// assert_eq!(received, [2, 0, 1]);
/// ```
pub trait Halo {
    /// The bytes that the next start sends by a port. They keep their values from one start to the next.
    ///
    /// # Panics
    /// Between start and finish, and for a port that does not exist.
    fn outgoing(&mut self, port: usize) -> &mut [u8];

    /// Starts to send and to receive all messages.
    ///
    /// # Panics
    /// If they have been started and not finished.
    fn start(&mut self);

    /// Waits until all messages have been received, and all outgoing bytes may change again.
    ///
    /// # Panics
    /// If they have not been started.
    fn finish(&mut self);

    /// The bytes that the last finish received by a port.
    ///
    /// # Panics
    /// Between start and finish, and for a port that does not exist.
    fn incoming(&self, port: usize) -> &[u8];
}

/// Checks the messages of an [exchange](Communicator::exchange) among `size` ranks: for those who implement a
/// communicator.
///
/// # Panics
/// If a rank does not exist, or is named twice.
pub fn check_messages(messages: &[Message], size: usize) {
    let mut named: Vec<usize> = messages.iter().map(|message| message.rank).collect();
    named.sort_unstable();
    assert!(named.last().is_none_or(|&last| last < size), "messages to ranks that exist");
    assert!(named.windows(2).all(|pair| pair[0] != pair[1]), "one message for each rank");
}

/// Checks that `other` is another one of `size` ranks than `rank`: for those who implement a communicator.
///
/// # Panics
/// If it is not.
pub fn check_other(other: usize, rank: usize, size: usize) {
    assert!(other < size && other != rank, "rank {other} is not another one of {size} ranks");
}
