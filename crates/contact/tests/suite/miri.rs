//! The unsafe code on a few hundred elements: also a program of its own for Miri, an interpreter that detects
//! undefined behaviour and data races. See `just miri`.
//!
//! Miri reports a processor without vector instructions beyond SSE2, so the portable kernel runs. Under Miri
//! the library cuts its work into smaller parts (`cfg!(miri)`), so that few elements suffice for two threads
//! to fill one array and one list. Outside of Miri this is an ordinary test.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use fdem_contact::{
    Buffered, CGrid, Couple, Csr, Direct, Elements, Engine, Filter, GroupMatrix, Index, Multilevel, Nbs,
    PeriodicBox, PeriodicSearch, Rows, Search, image,
};

const THREADS: [usize; 2] = [1, 2];

/// Numbers in `[0, 1)`, the same on every machine.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// `n` points with about two neighbours each at a distance of 1.
fn gas<const D: usize>(n: usize, seed: u64) -> Vec<[f64; D]> {
    let mut random = random(seed);
    let width = (1.5 * n as f64).powf(1.0 / D as f64);
    (0..n).map(|_| std::array::from_fn(|_| random() * width)).collect()
}

/// Radii of which the largest is eight times the smallest.
fn radii(n: usize) -> Vec<f64> {
    (0..n).map(|k| if k % 40 == 0 { 1.2 } else { 0.15 + 0.15 * (k % 3) as f64 }).collect()
}

fn all_of<const D: usize>(elements: &Elements<'_, f64, D>) -> Vec<Couple> {
    let mut couples = Vec::new();
    Direct.couples(elements, &mut couples).unwrap();
    couples.sort_unstable();
    couples
}

fn check<const D: usize>(
    name: &str,
    mut search: impl Search<f64, D>,
    elements: &Elements<'_, f64, D>,
    expected: &[Couple],
) {
    let mut couples = Vec::new();
    search.couples(elements, &mut couples).unwrap();
    couples.sort_unstable();
    assert_eq!(couples, expected, "{name}");
}

/// Each search takes Miri some seconds, so that every engine searches once; rows on both numbers of threads.
fn check_engines<const D: usize>(elements: &Elements<'_, f64, D>) {
    let expected = all_of(elements);
    assert!(!expected.is_empty());
    for threads in THREADS {
        // A build without the feature `rayon` has one thread.
        let Ok(rows) = Rows::new().with_threads(threads) else { continue };
        check("rows", rows, elements, &expected);
    }
    let multilevel = Multilevel::new();
    check("multilevel", multilevel.clone().with_threads(2).unwrap_or(multilevel), elements, &expected);
    check("nbs", Nbs::new(), elements, &expected);
    check("cgrid", CGrid::new(), elements, &expected);
}

#[test]
fn engines_on_spheres_of_one_radius() {
    check_engines(&Elements::points(&gas::<3>(40, 2), 1.0).unwrap());
}

#[test]
fn engines_on_spheres_with_radii_and_filters() {
    let (points, radii) = (gas::<3>(40, 3), radii(40));
    let spheres = Elements::spheres_with_radii(&points, &radii).unwrap();
    check_engines(&spheres);
    let bodies: Vec<u32> = (0..40).map(|k| k / 3).collect();
    let groups: Vec<u32> = (0..40).map(|k| k * 7 % 40).collect();
    let mut matrix = GroupMatrix::all(40).unwrap();
    (0..40).for_each(|group| matrix.set(group, 39 - group, false).unwrap());
    check_engines(&spheres.with_filter(Filter::groups(&groups, &matrix).with_bodies(&bodies)).unwrap());
}

#[test]
fn engines_on_boxes() {
    let lows = gas::<2>(40, 4);
    let highs: Vec<[f64; 2]> = lows.iter().zip(radii(40)).map(|(low, size)| low.map(|x| x + size)).collect();
    check_engines(&Elements::boxes(&lows, &highs).unwrap());
}

/// Two threads append to one list, whose room runs out on the way, and to parts of a sum.
#[test]
fn two_threads_write_one_list() {
    let points = gas::<3>(130, 5);
    let elements = Elements::points(&points, 1.2).unwrap();
    let mut expected = Vec::new();
    Rows::new().couples(&elements, &mut expected).unwrap();
    let Ok(mut rows) = Rows::new().with_threads(2) else { return };
    let mut couples = Vec::with_capacity(expected.len() / 2);
    rows.couples(&elements, &mut couples).unwrap();
    assert_eq!(couples, expected);
    let sums = rows.fold(&elements, || 0, |sum, _| *sum += 1).unwrap();
    assert_eq!(sums.into_iter().sum::<usize>(), expected.len());
}

#[test]
fn two_sets_and_queries() {
    let (fixed, moving) = (gas::<3>(66, 6), gas::<3>(10, 7));
    let fixed = Elements::points(&fixed, 1.0).unwrap();
    let asking = Elements::points(&moving, 1.0).unwrap();
    let mut index = Index::new().with_threads(2).unwrap_or_default();
    index.build(&fixed).unwrap();
    let mut couples = Vec::new();
    index.couples_with(&asking, &mut couples).unwrap();
    let mut found = Csr::new();
    index.within_with_distances(&moving, 1.0, &mut found).unwrap();
    assert_eq!(found.neighbours().len(), couples.len());
    index.nearest(&moving, 3, &mut found).unwrap();
    assert_eq!(found.neighbours().len(), 3 * moving.len());
}

#[test]
fn boxes_that_repeat_and_buffers() {
    let points = gas::<2>(20, 8);
    let elements = Elements::points(&points, 1.0).unwrap();
    let cell = PeriodicBox::orthogonal([0.0; 2], [6.0; 2], [true; 2]).unwrap();
    let mut counts = Vec::new();
    for threads in THREADS {
        let Ok(mut search) = PeriodicSearch::new().with_engine(Engine::Rows).with_threads(threads) else {
            continue;
        };
        let mut couples = Vec::new();
        search.couples(&elements, &cell, &mut couples).unwrap();
        counts.push(couples.len());
        let mut buffered = Buffered::new(0.2).unwrap().with_threads(threads).unwrap();
        let update = buffered.update(&elements).unwrap();
        assert_eq!(update.count(), all_of(&elements).len() as u64);
    }
    assert!(counts.windows(2).all(|pair| pair[0] == pair[1]) && counts[0] > 0);
}

#[test]
fn bodies_of_an_image() {
    let labels: Vec<u8> = (0..20 * 70).map(|k| (k % 70 / 9 + k / 70 / 7 * 8) as u8).collect();
    let contacts = image::contacts(&labels, [20, 70], image::Neighbourhood::Vertex).unwrap();
    assert!(!contacts.is_empty());
}
