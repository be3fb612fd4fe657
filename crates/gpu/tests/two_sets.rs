//! Two sets on a device: the couples of `Index`, in its order.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use bytemuck::Pod;
use fdem_contact::{CrossCouple, Elements, Error, Filter, GroupMatrix, Index, Real};
use fdem_gpu::{DeviceIndex, Host, HostBuild};
use fdem_scenes::random::Random;

/// The couples on the device, which are compared with those of `Index`, for all moving sets in turn.
fn same<T: Real + Pod, const D: usize>(
    what: &str,
    fixed: &Elements<'_, T, D>,
    moving: &[Elements<'_, T, D>],
) -> usize {
    let mut index = Index::new();
    index.build(fixed).unwrap();
    let mut all = 0;
    for build in [HostBuild::Ascending, HostBuild::Descending] {
        let host = Host(build);
        let mut on_device = DeviceIndex::new(&host);
        on_device.build(fixed).unwrap();
        for (k, elements) in moving.iter().enumerate() {
            let (mut expected, mut found) = (Vec::new(), vec![CrossCouple { i: 7, j: 7 }]);
            index.couples_with(elements, &mut expected).unwrap();
            on_device.couples_with(elements, &mut found).unwrap();
            assert!(found == expected, "{what}, {k}: {build:?}, {} couples", expected.len());
            assert_eq!(on_device.count_with(elements), Ok(expected.len() as u64), "{what}, {k}");
            all += expected.len();
        }
    }
    all / 2
}

fn points<T: Real, const D: usize>(random: &mut Random, n: usize, from: f64, to: f64) -> Vec<[T; D]> {
    (0..n).map(|_| std::array::from_fn(|_| T::nearest(random.between(from, to)))).collect()
}

/// Spheres of one radius and of many against each other, dense and sparse, of unlike sizes and numbers, in
/// places that overlap in part or not at all.
fn sets<T: Real + Pod, const D: usize>() {
    let mut random = Random::new(11);
    let of = T::nearest;
    let mut couples = 0;
    for (n, m) in [(1, 1), (1, 300), (300, 1), (700, 1500), (4000, 900)] {
        for density in [20.0, 1.0, 0.02] {
            let width = ((n + m) as f64 / density).powf(1.0 / D as f64);
            for place in [0.0, -0.7, 3.0] {
                let fixed = points::<T, D>(&mut random, n, 0.0, width);
                let moving = points::<T, D>(&mut random, m, place * width, (place + 0.9) * width);
                let radii = |random: &mut Random, n| -> Vec<T> {
                    (0..n).map(|k| of(random.between(0.0, if k % 50 == 3 { 3.0 } else { 0.5 }))).collect()
                };
                let (theirs, ours) = (radii(&mut random, m), radii(&mut random, n));
                let moving = [
                    Elements::points(&moving, of(1.0)).unwrap(),
                    Elements::spheres_with_radii(&moving, &theirs).unwrap(),
                    Elements::points(&moving, of(0.0)).unwrap().with_tolerance(of(0.6)).unwrap(),
                    Elements::points(&[], of(1.0)).unwrap(),
                ];
                let what = format!("{n} and {m} elements, {density}, {place}");
                couples += same(&what, &Elements::points(&fixed, of(1.0)).unwrap(), &moving);
                let spheres = Elements::spheres_with_radii(&fixed, &ours).unwrap();
                couples += same(&format!("{what}, with radii"), &spheres, &moving);
                let of_no_size = Elements::points(&fixed, of(0.0)).unwrap().with_tolerance(of(0.3)).unwrap();
                couples += same(&format!("{what}, of no size"), &of_no_size, &moving);
            }
        }
    }
    assert!(couples > 100_000, "{couples}");
}

#[test]
fn sets_in_the_plane() {
    sets::<f64, 2>();
    sets::<f32, 2>();
}

#[test]
fn sets_in_space() {
    sets::<f64, 3>();
    sets::<f32, 3>();
}

/// Crowds, clusters far from each other, all in one place; lattices, where many coordinates are equal.
#[test]
fn crowds_and_lattices() {
    let mut random = Random::new(12);
    let mut clusters = points::<f64, 3>(&mut random, 3000, 0.0, 3.0);
    clusters.iter_mut().step_by(2).for_each(|point| point[0] += 1e9);
    clusters.iter_mut().step_by(7).for_each(|point| point[2] -= 1e6);
    let mut near = points::<f64, 3>(&mut random, 500, 0.0, 3.0);
    near.iter_mut().step_by(3).for_each(|point| point[0] += 1e9);
    let near = [Elements::points(&near, 0.5).unwrap(), Elements::points(&near, 40.0).unwrap()];
    assert!(same("clusters", &Elements::points(&clusters, 0.5).unwrap(), &near) > 10_000);

    let lattice: Vec<[f64; 2]> = (0..2500).map(|k| [k % 50, k / 50].map(|i| f64::from(i) * 0.1)).collect();
    let other: Vec<[f64; 2]> = lattice.iter().map(|x| x.map(|x| x + 0.05)).collect();
    let moving = [Elements::points(&other, 0.1).unwrap(), Elements::points(&lattice, 0.1).unwrap()];
    assert!(same("lattices", &Elements::points(&lattice, 0.1).unwrap(), &moving) > 5_000);

    let one = vec![[0.5, 0.5, 0.5]; 300];
    let crowd = [Elements::points(&one, 0.0).unwrap(), Elements::spheres(&one, 7.0).unwrap()];
    assert_eq!(same("one place", &Elements::points(&one, 0.0).unwrap(), &crowd), 2 * 300 * 300);
}

#[test]
fn filters_of_two_sets() {
    let mut random = Random::new(13);
    let (fixed, moving) =
        (points::<f64, 3>(&mut random, 800, 0.0, 8.0), points::<f64, 3>(&mut random, 600, 0.0, 8.0));
    let mut numbers =
        |n: usize, below: u64| -> Vec<u32> { (0..n).map(|_| random.below(below) as u32).collect() };
    let (ours, theirs) = (numbers(800, 5), numbers(600, 5));
    let (our_masks, their_masks) = (numbers(800, 31), numbers(600, 31));
    let (our_groups, their_groups) = (numbers(800, 40), numbers(600, 40));
    let mut matrix = GroupMatrix::none(40).unwrap();
    (0..40).for_each(|k| matrix.set(k, k * 7 % 40, true).unwrap());
    let of = |points, filter| Elements::points(points, 1.0).unwrap().with_filter(filter).unwrap();
    let filters = [
        [Filter::bodies(&ours), Filter::bodies(&theirs)],
        [Filter::masks(&ours, &our_masks), Filter::masks(&theirs, &their_masks)],
        [Filter::groups(&our_groups, &matrix), Filter::groups(&their_groups, &matrix)],
        [
            Filter::groups(&our_groups, &matrix).with_bodies(&ours),
            Filter::groups(&their_groups, &matrix).with_bodies(&theirs),
        ],
    ];
    let all =
        same("all", &Elements::points(&fixed, 1.0).unwrap(), &[Elements::points(&moving, 1.0).unwrap()]);
    for (k, [our, their]) in filters.into_iter().enumerate() {
        let couples = same(&format!("filter {k}"), &of(&fixed, our), &[of(&moving, their)]);
        assert!(couples > 20 && couples < all, "filter {k}: {couples} of {all}");
    }
    let host = Host(HostBuild::Ascending);
    let mut index = DeviceIndex::new(&host);
    index.build(&of(&fixed, filters[0][0])).unwrap();
    assert_eq!(index.count_with(&of(&moving, filters[1][1])), Err(Error::UnlikeFilters));
    assert_eq!(index.count_with(&Elements::points(&moving, 1.0).unwrap()), Err(Error::UnlikeFilters));
}

#[test]
fn what_an_index_does_not_have_is_refused() {
    let host = Host(HostBuild::Ascending);
    let mut index = DeviceIndex::<_, f64, 3>::new(&host);
    let points = [[0.0; 3]];
    let point = Elements::points(&points, 1.0).unwrap();
    assert_eq!(index.count_with(&point), Err(Error::IndexNotBuilt));
    let boxes = Elements::boxes(&points, &[[1.0; 3]]).unwrap();
    let error = index.build(&boxes).unwrap_err();
    assert_eq!(error.to_string(), "a device does not search boxes");
    assert_eq!(index.count_with(&point), Err(Error::IndexNotBuilt));
    index.build(&Elements::points(&[], 1.0).unwrap()).unwrap();
    assert_eq!(index.count_with(&point), Ok(0));
    index.build(&point).unwrap();
    assert_eq!(index.count_with(&boxes), Err(Error::UnlikeShapes));
}
