//! No rank holds all elements or all couples: the memory of one rank grows with its share, and not with the
//! whole.
//!
//! A separate program, because it replaces the allocator by one that counts. The ranks are threads, so the
//! peak is that of all of them together; a rank that gathered everything would multiply it by the number of
//! ranks.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failed unwrap is a failed test")]

use fdem_distributed::{Communicator, DistributedSearch, Shapes, threads};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Spheres on a cubic grid, each of which touches its six neighbours; rank `r` has every `size`-th one.
fn elements(communicator: &dyn Communicator, side: u32) -> (Vec<u32>, Vec<[f64; 3]>) {
    let (rank, size) = (communicator.rank() as u32, communicator.size());
    let ids: Vec<u32> = (rank..side.pow(3)).step_by(size).collect();
    let place = |id: &u32| [id % side, id / side % side, id / side / side].map(f64::from);
    let centres = ids.iter().map(place).collect();
    (ids, centres)
}

/// Peak of all ranks together beyond the caller's elements, in bytes per element.
fn peak(size: usize, side: u32) -> f64 {
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let couples = threads::run(size, |communicator| {
        let (ids, centres) = elements(communicator, side);
        let spheres = Shapes::Equal { centres: &centres, radius: 0.5 };
        DistributedSearch::new(communicator).couples(&ids, &spheres, 0.0).unwrap().len()
    });
    let peak = ALLOCATOR.peak_usage() - before;
    let n = side.pow(3) as usize;
    assert_eq!(couples.iter().sum::<usize>(), 3 * side.pow(2) as usize * (side as usize - 1));
    let most = couples.iter().max().unwrap() * size;
    assert!(
        most * 20 < couples.iter().sum::<usize>() * 21,
        "each rank has its share of the couples: {couples:?}"
    );
    peak as f64 / n as f64
}

fn main() {
    // Bytes per element with 4 and with 16 ranks at two sizes. If each rank held all elements (28 bytes
    // each), or all couples (24 bytes for each element), 12 more ranks would add 336 or 288 bytes. Borders,
    // which shrink with the size, add some.
    for side in [40, 60] {
        let [few, many] = [4, 16].map(|size| peak(size, side));
        println!("{side}^3 elements: {few:.0} bytes each on 4 ranks, {many:.0} on 16");
        assert!(many - few < 200.0, "{few} bytes per element on 4 ranks, {many} on 16");
    }
    let [small, large] = [40, 60].map(|side| peak(8, side));
    println!("8 ranks: {small:.0} bytes for each of 64,000 elements, {large:.0} for each of 216,000");
    assert!(large < 1.05 * small, "memory is proportional to the number of elements: {small}, then {large}");
}
