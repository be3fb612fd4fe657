//! Distributed searches on ranks that are threads, against a search by one process.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use fdem_contact::PeriodicBox;
use fdem_distributed::{DistributedSearch, Error, Shapes, threads};
use fdem_scenes::random::Random;
use proptest::prelude::*;

use crate::searches::{self, SPREADS, Scene, SceneSizes, check_open, check_periodic};

#[test]
fn couples_in_open_space_are_those_of_one_process() {
    for (spread, size) in [1, 2, 3, 4, 8].into_iter().enumerate() {
        threads::run(size, |communicator| searches::open(communicator, SPREADS[spread % SPREADS.len()]));
    }
}

#[test]
fn couples_in_a_periodic_box_are_those_of_one_process() {
    for (spread, size) in [1, 2, 3, 4, 8].into_iter().enumerate() {
        threads::run(size, |communicator| searches::periodic(communicator, SPREADS[spread % SPREADS.len()]));
    }
}

/// More ranks than cells with elements; and ids far apart, most of which are consecutive.
#[test]
fn many_ranks_and_ids_far_apart() {
    let n = 3000;
    let mut random = Random::new(6);
    let points: Vec<[f64; 3]> = (0..n).map(|_| std::array::from_fn(|_| random.between(0.0, 12.0))).collect();
    let id = |place: usize| if place == 0 { u32::MAX - 1 } else { place as u32 };
    let found = |size: usize| {
        let runs = threads::run(size, |communicator| {
            let own: Vec<usize> = (0..n).filter(|place| place % size == communicator.rank()).collect();
            let centres: Vec<[f64; 3]> = own.iter().map(|&place| points[place]).collect();
            let ids: Vec<u32> = own.iter().map(|&place| id(place)).collect();
            let spheres = Shapes::Equal { centres: &centres, radius: 0.5 };
            DistributedSearch::new(communicator).couples(&ids, &spheres, 0.0).unwrap()
        });
        let total: usize = runs.iter().map(Vec::len).sum();
        assert!(runs.iter().all(|run| run.len() * size < 2 * total), "even runs");
        runs.concat()
    };
    let one = found(1);
    assert!(one.is_sorted() && one.iter().any(|couple| couple.j == u32::MAX - 1));
    assert_eq!(found(3), one);
    assert_eq!(found(50), one);
}

/// Large elements are sent to the ranks of small ones, and not the other way: the ghosts of a packing with
/// one giant are few.
#[test]
fn a_giant_does_not_widen_the_halo_of_all() {
    let n = 4000;
    let mut random = Random::new(5);
    let points: Vec<[f64; 2]> = (0..n).map(|_| std::array::from_fn(|_| random.between(0.0, 100.0))).collect();
    let ghosts = AtomicUsize::new(0);
    threads::run(4, |communicator| {
        let places: Vec<usize> = (0..n).filter(|place| place % 4 == communicator.rank()).collect();
        let centres: Vec<[f64; 2]> = places.iter().map(|&place| points[place]).collect();
        let radii: Vec<f64> = places.iter().map(|&place| if place == 0 { 200.0 } else { 0.5 }).collect();
        let ids: Vec<u32> = places.iter().map(|&place| place as u32).collect();
        let mut search = DistributedSearch::new(communicator);
        let discs = Shapes::Spheres { centres: &centres, radii: &radii };
        let couples = search.couples(&ids, &discs, 0.0).unwrap();
        assert!(couples.len() > n / 5, "the giant touches all: {}", couples.len());
        ghosts.fetch_add(search.statistics().ghosts, Ordering::Relaxed);
    });
    let ghosts = ghosts.into_inner();
    assert!(ghosts < n / 5, "{ghosts} ghosts of {n} elements");
}

#[test]
fn all_ranks_return_the_error_of_the_first_rank_that_has_one() {
    let errors = threads::run(3, |communicator| {
        let rank = communicator.rank();
        let x = if rank == 0 { 1.0 } else { f64::NAN };
        let ids = [10 * rank as u32, 10 * rank as u32 + 1];
        let centres = [[0.0, 0.0], [x, 0.0]];
        DistributedSearch::new(communicator).couples(
            &ids,
            &Shapes::Equal { centres: &centres, radius: 1.0 },
            0.0,
        )
    });
    for error in errors {
        let reason = "element 11: coordinate x is NaN, not a finite number".to_owned();
        assert_eq!(error, Err(Error::Refused { rank: 1, id: Some(11), reason }));
    }

    let errors = threads::run(3, |communicator| {
        let radius = if communicator.rank() == 2 { 2.0 } else { 1.0 };
        DistributedSearch::<f64, 2>::new(communicator).couples(
            &[],
            &Shapes::Equal { centres: &[], radius },
            0.0,
        )
    });
    assert!(errors.into_iter().all(|error| error == Err(Error::Unlike { rank: 2 })));

    // The element is 2^30 periods away from the box.
    let errors = threads::run(2, |communicator| {
        let cell = PeriodicBox::orthogonal([0.0], [1.0], [true]).unwrap();
        let centres = [[f64::from(communicator.rank() as u32) * 1_073_741_824.0]];
        let points = Shapes::Equal { centres: &centres, radius: 0.0 };
        DistributedSearch::new(communicator).periodic_couples(
            &[communicator.rank() as u32],
            &points,
            0.0,
            &cell,
        )
    });
    for error in errors {
        let Err(Error::Refused { rank: 1, id: Some(1), reason }) = error else { panic!("{error:?}") };
        assert!(reason.contains("periods"), "{reason}");
    }

    // A box that is thinner than the resolution of coordinates of this magnitude, and one that would need too
    // many images.
    let refused = |height: f64, radius: f64| {
        let errors = threads::run(2, |communicator| {
            let cell = PeriodicBox::orthogonal([0.0, 0.0], [1e9, height], [true, true]).unwrap();
            let centres = [[1e8 * communicator.rank() as f64, 0.0]];
            let discs = Shapes::Equal { centres: &centres, radius };
            DistributedSearch::new(communicator).periodic_couples(
                &[communicator.rank() as u32],
                &discs,
                0.0,
                &cell,
            )
        });
        assert_eq!(errors[0], errors[1]);
        errors[0].clone().unwrap_err().to_string()
    };
    assert!(refused(1e-9, 1e-10).contains("too thin"), "{}", refused(1e-9, 1e-10));
    assert!(refused(1.0, 1e9).contains("images"), "{}", refused(1.0, 1e9));
}

/// Coordinates on a grid, so that many touch exactly; any radii, spread and number of ranks.
fn any_scene() -> impl Strategy<Value = Arc<Scene<f64, 2>>> {
    let element = ([-40..40_i32, -40..40_i32], prop_oneof![Just(0), 0..8_i32, Just(64)]);
    (prop::collection::vec(element, 0..60), 0..4_i32, any::<bool>()).prop_map(
        |(elements, tolerance, boxes)| {
            let scale = |number: i32| f64::from(number) / 8.0;
            let points: Vec<[f64; 2]> = elements.iter().map(|(point, _)| point.map(scale)).collect();
            let far = || {
                elements
                    .iter()
                    .zip(&points)
                    .map(|((_, size), point)| point.map(|x| x + scale(*size)))
                    .collect()
            };
            let sizes = if boxes {
                SceneSizes::Far(far())
            } else {
                SceneSizes::Radii(elements.iter().map(|(_, size)| scale(*size)).collect())
            };
            Arc::new(Scene { points, sizes, tolerance: scale(tolerance) })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn any_elements_on_any_ranks(scene in any_scene(), size in 1..6_usize, spread in 0..SPREADS.len()) {
        threads::run(size, |communicator| check_open(communicator, &scene, SPREADS[spread]));
    }

    #[test]
    fn any_elements_in_any_box(
        scene in any_scene(),
        size in 1..6_usize,
        spread in 0..SPREADS.len(),
        edges in [4..80_i32, 4..80_i32],
        tilt in [-40..40_i32, 0..2_i32],
        axes in [any::<bool>(), any::<bool>()],
    ) {
        let scale = |number: i32| f64::from(number) / 8.0;
        let edges = [[scale(edges[0]), scale(tilt[1])], [scale(tilt[0]), scale(edges[1])]];
        if let Ok(cell) = PeriodicBox::triclinic([-1.0, 0.5], edges, axes) {
            threads::run(size, |communicator| check_periodic(communicator, &scene, &cell, SPREADS[spread]));
        }
    }
}
