//! Tests on ranks that are threads.
//!
//! - `ranks`: the calls of a communicator, and what happens if a rank panics.
//! - `search`: the couples of distributed searches equal those of one process.
//! - `unsafe_code`: unsafe code is only in the file that the documentation lists.
//! - `../common`: checks that `../mpi.rs` makes on processes under MPI, too.
//! - `../memory.rs`, a program of its own because it counts allocations: no rank holds all elements.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

#[path = "../common/ranks.rs"]
mod checks;
mod ranks;
mod search;
#[path = "../common/searches.rs"]
mod searches;
// The test is the same in both crates, which have unsafe code.
#[path = "../../../contact/tests/suite/unsafe_code.rs"]
mod unsafe_code;
