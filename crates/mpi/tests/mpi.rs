//! Run by `tests/mpirun.sh` on several processes. Without a launcher there is one rank.

#![allow(clippy::print_stdout, reason = "there is no harness that would print")]
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

// The checks of `fdem-distributed`, for threads and processes alike.
#[path = "../../distributed/tests/common/ranks.rs"]
mod ranks;
#[allow(dead_code, reason = "some parts are for tests on threads")]
#[path = "../../distributed/tests/common/searches.rs"]
mod searches;

use fdem_distributed::Communicator;
use fdem_mpi::World;

fn main() {
    let world = World::start().expect("MPI starts once");
    let asked_for = std::env::var("RANKS").map_or(1, |ranks| ranks.parse().expect("a number"));
    assert_eq!(world.size(), asked_for, "as many ranks as the launcher was asked for");
    ranks::all(&world);
    let spread = searches::SPREADS[asked_for % searches::SPREADS.len()];
    searches::open(&world, spread);
    searches::periodic(&world, spread);
    if world.rank() == 0 {
        println!("{} ranks: all calls and searches work", world.size());
    }
}
