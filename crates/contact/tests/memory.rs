//! The memory law: Munjiza-NBS allocates exactly (3.65), (3.80) and their extension to D dimensions; the
//! C-grid allocates memory proportional to N.
//!
//! A separate program, because it replaces the allocator by one that counts, and without the test harness,
//! whose main thread allocates while a test runs.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::alloc::System;

use fdem_contact::{CGrid, Couple, Elements, Nbs, Search};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Measures the bytes allocated from its creation on, including memory that is freed again at once.
struct Meter(Region<'static, System>);

impl Meter {
    fn start() -> Self {
        Self(Region::new(ALLOCATOR))
    }

    fn total(&self) -> usize {
        self.0.change().bytes_allocated
    }

    fn live(&self) -> usize {
        let change = self.0.change();
        change.bytes_allocated - change.bytes_deallocated
    }
}

/// `n` elements in a slanted row, `spacing` diameters apart along every axis, so that the domain is wide
/// along all axes.
fn row<const D: usize>(n: usize, spacing: f64) -> Vec<[f64; D]> {
    (0..n).map(|k| std::array::from_fn(|axis| k as f64 * spacing * (1.0 + axis as f64))).collect()
}

fn obeys_the_law<const D: usize>(n: usize, spacing: f64) {
    let centres = row::<D>(n, spacing);
    let mut nbs = Nbs::<D>::new();

    let meter = Meter::start();
    let elements = Elements::points(&centres, 1.0).unwrap();
    nbs.count(&elements).unwrap();

    let cells = nbs.grid().unwrap().cells().map(|cells| cells as usize);
    let others: usize = cells[..D - 1].iter().sum();
    let law = D * n + cells[D - 1] + 2 * others;
    assert_eq!(nbs.integers(), law, "D = {D}, n = {n}, spacing {spacing}: {cells:?}");
    assert_eq!(meter.live(), 4 * law, "held after a search: D = {D}, n = {n}, spacing {spacing}");
    assert_eq!(meter.total(), 4 * law, "allocated at any time: D = {D}, n = {n}, spacing {spacing}");

    // A second search, into a list that has room, allocates nothing.
    let mut couples: Vec<Couple> = Vec::with_capacity(20 * n);
    let meter = Meter::start();
    nbs.couples(&elements, &mut couples).unwrap();
    assert_eq!(meter.total(), 0, "a second search: D = {D}, n = {n}, spacing {spacing}");
}

fn main() {
    nbs_allocates_what_the_book_says_and_nothing_else();
    c_grid_holds_so_much_per_element();
}

fn nbs_allocates_what_the_book_says_and_nothing_else() {
    for (n, spacing) in [(10, 1.0), (1000, 0.1), (1000, 1.0), (1000, 7.0), (10_000, 0.5), (10_000, 30.0)] {
        obeys_the_law::<1>(n, spacing);
        obeys_the_law::<2>(n, spacing);
        obeys_the_law::<3>(n, spacing);
        obeys_the_law::<4>(n, spacing);
        obeys_the_law::<6>(n, spacing);
    }

    // The letters are those of the book.
    let centres = row::<2>(500, 3.0);
    let mut nbs = Nbs::new();
    nbs.count(&Elements::points(&centres, 1.0).unwrap()).unwrap();
    let [nx, ny] = nbs.grid().unwrap().cells().map(|cells| cells as usize);
    assert_eq!(nbs.integers(), ny + 2 * nx + 2 * 500, "(3.65)");

    let centres = row::<3>(500, 3.0);
    let mut nbs = Nbs::new();
    nbs.count(&Elements::points(&centres, 1.0).unwrap()).unwrap();
    let [nx, ny, nz] = nbs.grid().unwrap().cells().map(|cells| cells as usize);
    assert_eq!(nbs.integers(), 3 * 500 + nz + 2 * nx + 2 * ny, "(3.80)");
}

/// The C-grid holds the reported number of bytes, proportional to N: in 1 cell, in 10^15, or in more cells
/// than integers can count.
fn c_grid_holds_so_much_per_element() {
    let mut per_element = Vec::new();
    for (n, spacing) in [(1_000, 1e-3), (1_000, 1.0), (100_000, 1.0), (100_000, 1e13)] {
        let centres = row::<3>(n, spacing);
        let elements = Elements::points(&centres, 0.5).unwrap();
        let mut search = CGrid::new();
        let meter = Meter::start();
        search.count(&elements).unwrap();
        assert_eq!(meter.live(), search.bytes(), "held after a search: n = {n}, spacing {spacing}");
        // The classes of sizes are counted while levels are chosen.
        assert!(meter.total() < search.bytes() + 200_000, "allocated at any time: {}", meter.total());
        per_element.push(search.bytes() as f64 / n as f64);
    }
    assert!(per_element.iter().all(|&bytes| (bytes - per_element[0]).abs() < 1.0), "{per_element:?}");
}
