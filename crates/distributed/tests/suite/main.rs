//! Tests on ranks that are threads.
//!
//! - `ranks`: the calls of a communicator, and the errors if a rank panics.
//! - `search`: the couples of distributed searches equal those of one process.
//! - `../common`: checks that `crates/mpi/tests/mpi.rs` makes on processes under MPI, too.
//! - `../memory.rs`, a separate program because it counts allocations: no rank holds all elements.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

#[path = "../common/ranks.rs"]
mod checks;
mod ranks;
mod search;
#[path = "../common/searches.rs"]
mod searches;
