//! Searches that another thread stops.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use fdem_contact::{Csr, Detector, Elements, Engine, Error, Index, PeriodicBox, PeriodicSearch, Search};

use crate::ENGINES;

/// A grid whose points are 1 apart, in a shuffled order.
fn points(edge: u32) -> Vec<[f64; 3]> {
    let n = edge * edge * edge;
    // Steps by an odd number that does not divide the number of points.
    let step = (n / 2..n).find(|step| gcd(*step, n) == 1).unwrap();
    (0..n)
        .map(|k| (u64::from(k) * u64::from(step) % u64::from(n)) as u32)
        .map(|k| [k % edge, k / edge % edge, k / edge / edge].map(f64::from))
        .collect()
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[test]
fn who_may_be_stopped_finds_the_same_in_the_same_order() {
    for engine in ENGINES {
        // Enough for several threads, if the engine has them.
        let edge = if engine == Some(Engine::Direct) { 10 } else { 24 };
        let centres = points(edge);
        let radii: Vec<f64> = (0..centres.len()).map(|k| if k % 50 == 0 { 3.0 } else { 0.6 }).collect();
        let elements = Elements::spheres_with_radii(&centres, &radii).unwrap();
        let cell = PeriodicBox::orthogonal([0.0; 3], [f64::from(edge); 3], [true; 3]).unwrap();
        let (mut expected, mut couples) = (Vec::new(), Vec::new());
        let (mut in_cell, mut shifted) = (Vec::new(), Vec::new());
        Detector::new().with_engine(engine).couples(&elements, &mut expected).unwrap();
        PeriodicSearch::new().with_engine(engine).couples(&elements, &cell, &mut in_cell).unwrap();
        for threads in [1, 2, 3] {
            let stop = Arc::new(AtomicBool::new(false));
            let mut detector =
                Detector::new().with_engine(engine).with_threads(threads).unwrap().stopped_by(stop.clone());
            detector.couples(&elements, &mut couples).unwrap();
            assert_eq!(couples, expected, "{engine:?}, {threads} threads");
            let search = PeriodicSearch::new().with_engine(engine).with_threads(threads).unwrap();
            search.stopped_by(stop).couples(&elements, &cell, &mut shifted).unwrap();
            assert_eq!(shifted, in_cell, "{engine:?}, {threads} threads");
        }
    }
}

#[test]
fn a_search_ends_soon_after_it_is_stopped_and_may_run_again() {
    // Some 10^8 couples: unless it is stopped, the search takes seconds.
    let centres = points(48);
    let many = Elements::points(&centres, 12.0).unwrap();
    let fewer = points(16);
    let few = Elements::points(&fewer, 1.0).unwrap();
    let cell = PeriodicBox::orthogonal([0.0; 3], [100.0; 3], [true; 3]).unwrap();
    for engine in ENGINES {
        for threads in [1, 2] {
            let stop = Arc::new(AtomicBool::new(false));
            let mut detector =
                Detector::new().with_engine(engine).with_threads(threads).unwrap().stopped_by(stop.clone());
            let search = PeriodicSearch::new().with_engine(engine).with_threads(threads).unwrap();
            let mut search = search.stopped_by(stop.clone());
            let (mut couples, mut shifted) = (Vec::new(), Vec::new());
            let soon = |found: &mut dyn FnMut() -> Result<(), Error>| {
                stop.store(false, Ordering::Relaxed);
                thread::scope(|scope| {
                    scope.spawn(|| {
                        thread::sleep(Duration::from_millis(20));
                        stop.store(true, Ordering::Relaxed);
                    });
                    assert_eq!(found(), Err(Error::Stopped), "{engine:?}, {threads} threads");
                });
                stop.store(false, Ordering::Relaxed);
            };
            soon(&mut || detector.couples(&many, &mut couples));
            assert!(couples.is_empty());
            soon(&mut || search.couples(&many, &cell, &mut shifted));
            assert!(shifted.is_empty());
            detector.couples(&few, &mut couples).unwrap();
            assert_eq!(couples.len(), 3 * 15 * 16 * 16);
            search.couples(&few, &cell, &mut shifted).unwrap();
            assert_eq!(shifted.len(), 3 * 15 * 16 * 16);
        }
    }
}

#[test]
fn an_index_is_not_built_once_it_is_stopped_and_is_built_after_that() {
    let centres = points(16);
    let elements = Elements::points(&centres, 1.0).unwrap();
    let stop = Arc::new(AtomicBool::new(true));
    let mut index = Index::new().stopped_by(stop.clone()).with_threads(2).unwrap();
    assert_eq!(index.build(&elements), Err(Error::Stopped));
    assert_eq!(index.len(), 0);
    stop.store(false, Ordering::Relaxed);
    index.build(&elements).unwrap();
    let (mut plain, mut found, mut expected) = (Index::new(), Csr::new(), Csr::new());
    plain.build(&elements).unwrap();
    index.nearest(&centres, 4, &mut found).unwrap();
    plain.nearest(&centres, 4, &mut expected).unwrap();
    assert_eq!(found.neighbours(), expected.neighbours());
}
