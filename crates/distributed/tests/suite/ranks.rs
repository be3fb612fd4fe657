//! Ranks that are threads of one process.

use std::panic::catch_unwind;

use fdem_distributed::{Communicator, Message, threads};

use crate::checks;

#[test]
fn all_calls_work_on_any_number_of_ranks() {
    for size in [1, 2, 3, 4, 8] {
        assert_eq!(threads::run(size, checks::all).len(), size);
    }
}

/// Runs three ranks, of which rank 1 panics, while the others wait for it in a call.
fn panic_while_others(wait: impl Fn(&dyn Communicator) + Sync + std::panic::RefUnwindSafe) {
    let run = || {
        threads::run(3, |communicator| {
            assert!(communicator.rank() != 1, "rank 1 has a fault");
            wait(communicator);
        })
    };
    let panic = catch_unwind(run).expect_err("a rank has panicked");
    assert_eq!(panic.downcast_ref(), Some(&"rank 1 has a fault"));
}

#[test]
fn a_panic_ends_the_ranks_that_wait_and_is_passed_on() {
    panic_while_others(|communicator| communicator.barrier());
    panic_while_others(|communicator| drop(communicator.receive(1)));
    panic_while_others(|communicator| drop(communicator.exchange(Vec::new())));
    // Rank 2 waits for rank 0, which waits for rank 1.
    panic_while_others(|communicator| {
        drop(communicator.receive(usize::from(communicator.rank() == 0)));
    });
    panic_while_others(|communicator| {
        let port = [fdem_distributed::Port { rank: 1, bytes: 1 }];
        let mut halo = communicator.halo(&[], &port);
        halo.start();
        halo.finish();
    });
    panic_while_others(|communicator| {
        loop {
            communicator.send(1, &[0]);
        }
    });
}

/// A rank that waits for one that has returned does not wait forever.
#[test]
#[should_panic(expected = "a rank waited for one that had returned")]
fn a_rank_that_returned_is_noticed() {
    threads::run(2, |communicator| {
        if communicator.rank() == 0 {
            communicator.barrier();
        }
    });
}

#[test]
#[should_panic(expected = "one message for each rank")]
fn two_messages_for_one_rank_are_refused() {
    threads::run(1, |communicator| {
        communicator.exchange(vec![Message::default(), Message::default()]);
    });
}

#[test]
fn an_abort_ends_all_ranks() {
    let run = || {
        threads::run(2, |communicator| {
            if communicator.rank() == 1 {
                communicator.abort(7);
            }
            communicator.barrier();
        })
    };
    let panic = catch_unwind(run).expect_err("a rank has panicked");
    assert_eq!(
        panic.downcast_ref::<String>().map(String::as_str),
        Some("rank 1 ended the program with code 7")
    );
}
