//! Tests of the library from outside, by hazard.
//!
//! - `oracle`: every search equals all-against-all, for every dimension, float, shape and scene.
//! - `degenerate`: nothing, one, all in one place, far away, NaN, infinity, lengths that differ, domains too wide.
//! - `properties`: laws that hold for any input (proptest): renumbering, mirroring, translation, tolerance, no repeats.
//! - `determinism`: one order of couples for any number of threads and any vector instructions.
//! - `multilevel`: unlike sizes, from points to bodies that cover all: every choice of levels equals all-against-all, in one order.
//! - `reuse`: a search used again, whatever came before, finds the list of a new one.
//! - `buffer`: walking elements: the couples of every update equal all-against-all, at the limit of the buffer too; when detection is due.
//! - `csr`: compressed rows against a map of sets, in any order, with repeats, values and couples that are none.
//! - `periodic`: boxes that repeat, sheared or not, against all images one by one.
//! - `explain`: what is told of a search beforehand, against the search.
//! - `filter`: bodies, masks and groups: with any of them every search finds what filtering afterwards leaves, in the same order.
//! - `two_sets`: an index against another set: shapes, sizes, tolerances, places; every element with every element.
//! - `queries`: elements around points, and the nearest ones, against the distances to all of them.
//! - `against_all`: no test, but what the two before share.
//! - `numbers`: coordinates of 1e12, more couples than 32 bits count, domains of 10^15 cells.
//! - `doubt`: distances at the limit and just beside it, where the kernels must not trust 32 bits; lattices, and crowds.
//! - `golden`: the numbers printed in the book.
//! - `../boxes.rs`: boxes of which most are much shorter than the longest.
//! - `../kernels.rs`, a program of its own for valgrind: the vector kernels on short rows, at every level.
//! - `../memory.rs`, a program of its own because it counts allocations: the memory law.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

mod against_all;
mod buffer;
mod csr;
mod degenerate;
mod determinism;
mod doubt;
mod explain;
mod filter;
mod golden;
mod multilevel;
mod numbers;
mod oracle;
mod periodic;
mod properties;
mod queries;
mod reuse;
mod two_sets;

use fdem_contact::{Couple, Elements, Real, Search};

/// The couples of a search in ascending order; a couple found twice shows twice.
fn ascending<T: Real, const D: usize>(
    mut search: impl Search<T, D>,
    elements: &Elements<'_, T, D>,
) -> Vec<Couple> {
    let mut couples = Vec::new();
    search.couples(elements, &mut couples).unwrap();
    assert_eq!(search.count(elements).unwrap(), couples.len() as u64, "a second search finds the same");
    couples.sort_unstable();
    couples
}
