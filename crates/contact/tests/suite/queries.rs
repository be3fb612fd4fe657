//! Elements around points, and the nearest ones, against the distances to all elements.

use fdem_contact::{Csr, Elements, Error, Index, Real};
use fdem_scenes::{Cloud, gas};
use proptest::prelude::*;

use crate::against_all::{EQUAL, Scenes, coordinate, in_all_dimensions, indices, squared};
use crate::oracle::FromF64;

/// All elements sorted by distance, ties by number.
fn by_distance<T: Real, const D: usize>(point: &[T; D], centres: &[[T; D]]) -> Vec<(T, u32)> {
    let mut all: Vec<_> = centres.iter().zip(0..).map(|(centre, j)| (squared(point, centre), j)).collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

/// Searches around `points` with every set of instructions and several numbers of threads, for the distances
/// `radii` and the numbers `ks`, in an index of `elements`, whose cells depend on their size. Returns the
/// number of entries.
fn compare<T: Real, const D: usize>(
    scene: &str,
    elements: &Elements<'_, T, D>,
    centres: &[[T; D]],
    points: &[[T; D]],
    radii: &[T],
    ks: &[usize],
) -> usize {
    let sorted: Vec<_> = points.iter().map(|point| by_distance(point, centres)).collect();
    let mut entries = 0;
    for (simd, threads, mut index) in indices() {
        index.build(elements).unwrap();
        let (mut plain, mut found) = (Csr::new(), Csr::new());
        for &r in radii {
            index.within(points, r, &mut plain).unwrap();
            index.within_with_distances(points, r, &mut found).unwrap();
            assert_eq!((plain.len(), found.len()), (points.len(), points.len()));
            for (q, sorted) in sorted.iter().enumerate() {
                let near = sorted.iter().take_while(|&&(squared, _)| squared <= r * r);
                let mut expected: Vec<(u32, T)> = near.map(|&(squared, j)| (j, squared)).collect();
                expected.sort_by_key(|&(j, _)| j);
                let context = || format!("{scene}, {simd}, {threads}, D = {D}, r = {r}, point {q}");
                assert!(plain.neighbours_of(q).iter().eq(expected.iter().map(|(j, _)| j)), "{}", context());
                let pairs = found.neighbours_of(q).iter().copied().zip(found.values_of(q).iter().copied());
                assert!(pairs.eq(expected.iter().copied()), "{}", context());
                entries += expected.len();
            }
        }
        for &k in ks {
            index.nearest(points, k, &mut found).unwrap();
            assert_eq!(found.len(), points.len());
            for (q, sorted) in sorted.iter().enumerate() {
                let expected = &sorted[..k.min(centres.len())];
                let pairs = found.values_of(q).iter().copied().zip(found.neighbours_of(q).iter().copied());
                assert!(
                    pairs.eq(expected.iter().copied()),
                    "{scene}, {simd}, {threads}, D = {D}, k = {k}, point {q}: {:?} {:?}, not {expected:?}",
                    found.neighbours_of(q),
                    found.values_of(q)
                );
                entries += expected.len();
            }
        }
    }
    entries
}

fn all_scenes<T: FromF64, const D: usize>() {
    let to = |cloud: &Cloud<D>| -> Vec<[T; D]> { cloud.centres.iter().map(|c| c.map(T::from_f64)).collect() };
    let scenes = Scenes::<D>::new();
    let radii = [0.0, 0.05, 1.0, 2.7, 1e7].map(T::from_f64);
    let ks = [0, 1, 7, 40, 1000];

    let centres = to(&scenes.gas);
    // Points in between, points around, and the elements themselves.
    let mut points = to(&gas::<D>(100, 2, 8.0, EQUAL).unwrap());
    points.extend(&centres[..50]);
    points.extend(points.clone().iter().map(|point| point.map(|x| x * T::from_f64(-3.0))));
    points.push([T::from_f64(1e6); D]);
    points.push(std::array::from_fn(|axis| T::from_f64(if axis == 0 { -1e6 } else { 1.0 })));
    points.push(std::array::from_fn(|axis| T::from_f64(if axis + 1 == D { 1e6 } else { 1.0 })));
    // Cells that suit the density, that are far too small, and that are far too large.
    for cutoff in [1.0, 1e-6, 0.0, 100.0].map(T::from_f64) {
        let elements = Elements::points(&centres, cutoff).unwrap();
        assert!(compare("gas", &elements, &centres, &points, &radii, &ks) > 10_000);
    }

    let compare_points = |scene: &str, centres: &[[T; D]], points: &[[T; D]]| {
        let elements = Elements::points(centres, T::from_f64(1.0)).unwrap();
        compare(scene, &elements, centres, points, &radii, &ks)
    };
    // Many ties, also between points.
    let regular = to(&scenes.lattice);
    let between: Vec<[T; D]> = regular.iter().map(|centre| centre.map(|x| x + T::HALF)).collect();
    assert!(compare_points("lattice", &regular, &regular) > 1000);
    assert!(compare_points("between the lattice", &regular, &between) > 1000);

    let clustered = to(&scenes.clusters);
    compare_points("clusters", &clustered, &clustered[..100]);
    compare_points("around clusters", &clustered, &points);
    compare_points("outliers", &to(&scenes.outliers), &points);
    let mut repeated = centres[..20].to_vec();
    (0..4).for_each(|_| repeated.extend_from_within(..));
    compare_points("repeated", &repeated, &points);
    compare_points("one place", &to(&scenes.one_place), &points);
    compare_points("one", &centres[..1], &points);
    assert_eq!(compare_points("none", &to(&scenes.nothing), &points), 0);
    assert_eq!(compare_points("nobody asks", &centres, &[]), 0);
}

in_all_dimensions!(all_scenes);

/// Several parts of the work: all points of a gas among themselves, with any number of threads, in an index
/// that is reused.
#[test]
fn many_points() {
    let cloud = gas::<3>(20_000, 1, 12.0, EQUAL).unwrap();
    let elements = Elements::points(&cloud.centres, 1.0).unwrap();
    let mut half = Csr::new();
    let mut rows = fdem_contact::Rows::new();
    half.find_full(&mut rows, &elements).unwrap();
    let mut nearest: Option<(Vec<u32>, Vec<f64>)> = None;
    for threads in [1, 2, 3] {
        let mut index = Index::new().with_threads(threads).unwrap();
        for _ in 0..2 {
            index.build(&elements).unwrap();
            let mut found = Csr::new();
            index.within(&cloud.centres, 1.0, &mut found).unwrap();
            for q in 0..cloud.len() {
                let others = found.neighbours_of(q).iter().filter(|&&j| j as usize != q);
                assert!(others.eq(half.neighbours_of(q)), "{threads} threads, point {q}");
            }
            let mut found = Csr::new();
            index.nearest(&cloud.centres, 8, &mut found).unwrap();
            let result = (found.neighbours().to_vec(), found.values().to_vec());
            assert!(nearest.get_or_insert_with(|| result.clone()) == &result, "{threads} threads");
        }
    }
    let (neighbours, values) = nearest.unwrap();
    for q in (0..cloud.len()).step_by(97) {
        let expected = &by_distance(&cloud.centres[q], &cloud.centres)[..8];
        let found = values[8 * q..].iter().copied().zip(neighbours[8 * q..].iter().copied());
        assert!(found.take(8).eq(expected.iter().copied()), "point {q}");
    }
}

/// Boxes are found by their minimum corners.
#[test]
fn boxes_are_their_minimum_corners() {
    let min = [[0.0, 0.0], [2.0, 0.0], [7.0, 7.0]];
    let max = [[9.0, 9.0], [3.0, 1.0], [7.0, 8.0]];
    let mut index = Index::new();
    index.build(&Elements::boxes(&min, &max).unwrap()).unwrap();
    let mut found = Csr::new();
    index.within_with_distances(&[[7.0, 8.0]], 1.0, &mut found).unwrap();
    assert_eq!((found.neighbours_of(0), found.values_of(0)), (&[2][..], &[1.0][..]));
    index.nearest(&[[0.0, 1.0]], 2, &mut found).unwrap();
    assert_eq!((found.neighbours_of(0), found.values_of(0)), (&[0, 1][..], &[1.0, 5.0][..]));
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let mut index = Index::new();
    let (mut found, mut valued) = (Csr::new(), Csr::new());
    assert_eq!(index.within(&[[0.0, 0.0]], 1.0, &mut found), Err(Error::IndexNotBuilt));
    assert_eq!(index.nearest(&[[0.0, 0.0]], 1, &mut valued), Err(Error::IndexNotBuilt));
    index.build(&Elements::points(&[[0.0, 0.0]], 1.0).unwrap()).unwrap();
    index.within(&[[0.0, 0.0]], 1.0, &mut found).unwrap();
    assert_eq!(found.len(), 1);
    let limit = f64::MAX_MAGNITUDE;
    for r in [-1.0, f64::INFINITY] {
        let error = Err(Error::InvalidCutoff { value: r, limit });
        assert_eq!(index.within(&[[0.0, 0.0]], r, &mut found), error);
        assert!(found.is_empty());
    }
    assert!(matches!(index.within(&[[0.0, 0.0]], f64::NAN, &mut found), Err(Error::InvalidCutoff { .. })));
    let points = [[0.0, 0.0], [1.0, f64::NAN]];
    let refused = |error| matches!(error, Err(Error::NonFiniteCoordinate { index: 1, axis: 1, .. }));
    assert!(refused(index.within(&points, 1.0, &mut found)));
    assert!(refused(index.within_with_distances(&points, 1.0, &mut valued)));
    assert!(refused(index.nearest(&points, 3, &mut valued)));
    let error = Error::CoordinateTooLarge { index: 0, axis: 0, value: 1e300, limit };
    assert_eq!(index.nearest(&[[1e300, 0.0]], 1, &mut valued), Err(error));
}

fn cloud() -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec([coordinate(), coordinate()], 0..50)
}

proptest! {
    #![proptest_config(crate::cases(512))]

    #[test]
    fn any_points(centres in cloud(), points in cloud(), size in 0.0..4.0, r in coordinate(), k in 1..12_usize) {
        let elements = Elements::points(&centres, size).unwrap();
        compare("any", &elements, &centres, &points, &[r.abs()], &[k]);
    }
}
