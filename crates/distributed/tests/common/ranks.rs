//! Checks of the calls of a communicator, which threads and processes under MPI both pass.

use fdem_distributed::{Communicator, Message, Port};

/// Calls each operation, on any number of ranks.
pub(crate) fn all(communicator: &dyn Communicator) {
    exchange(communicator);
    small(communicator);
    streams(communicator);
    halos(communicator);
}

/// Each rank sends to some others, and to itself; several exchanges follow each other without a wait.
fn exchange(communicator: &dyn Communicator) {
    let (rank, size) = (communicator.rank(), communicator.size());
    let is_sent = |from: usize, to: usize, round: usize| (from * 7 + to * 5 + round).is_multiple_of(3);
    // The length differs between pairs; a message may be empty.
    let content = |from: usize, to: usize, round: usize| {
        vec![(from + 10 * to + round) as u8; (from * 1000 * to) + round]
    };
    for round in 0..20 {
        let to = (0..size).filter(|&to| is_sent(rank, to, round));
        let messages = to.map(|to| Message { rank: to, bytes: content(rank, to, round) }).collect();
        let expected: Vec<Message> = (0..size)
            .filter(|&from| is_sent(from, rank, round))
            .map(|from| Message { rank: from, bytes: content(from, rank, round) })
            .collect();
        assert_eq!(communicator.exchange(messages), expected, "round {round}");
    }
    assert_eq!(communicator.exchange(Vec::new()), []);
}

fn small(communicator: &dyn Communicator) {
    let (rank, size) = (communicator.rank(), communicator.size());
    communicator.barrier();
    let all = communicator.all_gather(&vec![rank as u8; rank]);
    assert_eq!(all, (0..size).map(|rank| vec![rank as u8; rank]).collect::<Vec<_>>());

    let mut bytes = if rank == 0 { vec![1, 2, 3] } else { vec![9; 10] };
    communicator.broadcast(&mut bytes);
    assert_eq!(bytes, [1, 2, 3]);

    let mut sums = [1, rank.cast_signed() as i64, if rank == 0 { i64::MAX } else { 1 }];
    communicator.all_sum(&mut sums);
    let (n, last) = (size.cast_signed() as i64, i64::MAX.wrapping_add(size.cast_signed() as i64 - 1));
    assert_eq!(sums, [n, n * (n - 1) / 2, last], "the last one wraps around");
    communicator.all_sum(&mut []);

    let mut largest = [rank as f64, -(rank as f64), f64::NEG_INFINITY];
    communicator.all_max(&mut largest);
    assert_eq!(largest, [(size - 1) as f64, 0.0, f64::NEG_INFINITY]);
}

/// Messages between two ranks keep their order, and do not mix with those of other calls.
fn streams(communicator: &dyn Communicator) {
    let (rank, size) = (communicator.rank(), communicator.size());
    if rank == 0 {
        for part in 0..50_usize {
            (1..size).for_each(|to| communicator.send(to, &vec![part as u8; part * 1000]));
        }
        (1..size).for_each(|from| assert_eq!(communicator.receive(from), [from as u8]));
    } else {
        for part in 0..50_usize {
            assert_eq!(communicator.receive(0), vec![part as u8; part * 1000]);
        }
        communicator.send(0, &[rank as u8]);
    }
    communicator.barrier();
}

/// Two halos together, with several ports to the same rank, started repeatedly and finished in another order,
/// with other calls between.
fn halos(communicator: &dyn Communicator) {
    let (rank, size) = (communicator.rank(), communicator.size());
    let (next, previous) = ((rank + 1) % size, (rank + size - 1) % size);
    // The second port is large enough not to be sent before the receiver is ready.
    let lengths = [3, 300_000, 3];
    let ports = |rank: usize| lengths.map(|bytes| Port { rank, bytes });
    let mut up = communicator.halo(&ports(next), &ports(previous));
    let mut down = communicator.halo(&[Port { rank: previous, bytes: 1 }], &[Port { rank: next, bytes: 1 }]);
    for round in 0..10 {
        for port in 0..lengths.len() {
            up.outgoing(port).fill((100 * port + 10 * round + rank) as u8);
        }
        down.outgoing(0)[0] = (round + rank) as u8;
        up.start();
        down.start();
        let mut sum = [1];
        communicator.all_sum(&mut sum);
        assert_eq!(sum, [size.cast_signed() as i64]);
        down.finish();
        up.finish();
        for (port, &length) in lengths.iter().enumerate() {
            assert_eq!(up.incoming(port), vec![(100 * port + 10 * round + previous) as u8; length]);
        }
        assert_eq!(down.incoming(0), [(round + next) as u8]);
    }
    // A rank without neighbours takes part in the call.
    let ports = [Port { rank: size - 1 - rank, bytes: 2 }];
    let ports = if rank == 0 || rank == size - 1 { &ports[..] } else { &[] };
    let mut ends = communicator.halo(ports, ports);
    if !ports.is_empty() {
        ends.outgoing(0).fill(rank as u8);
        ends.start();
        ends.finish();
        assert_eq!(ends.incoming(0), [(size - 1 - rank) as u8; 2]);
    }
}
