//! Two sets searched with an index, against every element of one with every element of the other.

use fdem_contact::{CrossCouple, Csr, Elements, Error, Filter, GroupMatrix, Index, Rows, Search, Simd};
use fdem_scenes::{Cloud, Sizes, gas};
use proptest::prelude::*;

use crate::against_all::{EQUAL, Scenes, coordinate, in_all_dimensions, indices, squared};
use crate::oracle::FromF64;

/// The arrays of one set.
struct Set<T, const D: usize> {
    centres: Vec<[T; D]>,
    far: Vec<[T; D]>,
    radii: Vec<T>,
}

impl<T: FromF64, const D: usize> Set<T, D> {
    fn new(cloud: &Cloud<D>, scale: f64, shift: f64) -> Self {
        let centres: Vec<[f64; D]> = cloud.centres.iter().map(|centre| centre.map(|x| x + shift)).collect();
        let far = centres.iter().zip(&cloud.radii).enumerate().map(|(k, (centre, radius))| {
            let edge = |axis: usize| if axis == k % D { 0.5 } else { 2.0 } * radius * scale;
            std::array::from_fn(|axis| T::from_f64(centre[axis] + edge(axis)))
        });
        Self {
            far: far.collect(),
            radii: cloud.radii.iter().map(|radius| T::from_f64(radius * scale)).collect(),
            centres: centres.into_iter().map(|centre| centre.map(T::from_f64)).collect(),
        }
    }

    fn shapes(&self, tolerance: f64) -> [Elements<'_, T, D>; 3] {
        let radius = self.radii.first().copied().unwrap_or(T::HALF);
        [
            Elements::spheres(&self.centres, radius),
            Elements::spheres_with_radii(&self.centres, &self.radii),
            Elements::boxes(&self.centres, &self.far),
        ]
        .map(|elements| elements.unwrap().with_tolerance(T::from_f64(tolerance)).unwrap())
    }

    /// The contact test documented at `Elements`, for element `i` of this set and `j` of another.
    fn touch(
        &self,
        shape: usize,
        i: usize,
        other: &Self,
        other_shape: usize,
        j: usize,
        tolerance: T,
    ) -> bool {
        let radius = |set: &Self, shape: usize, k: usize| set.radii[if shape == 0 { 0 } else { k }];
        if shape == 2 {
            return (0..D).all(|axis| {
                self.centres[i][axis] <= other.far[j][axis] + tolerance
                    && other.centres[j][axis] <= self.far[i][axis] + tolerance
            });
        }
        let reach = (radius(self, shape, i) + radius(other, other_shape, j)) + tolerance;
        squared(&self.centres[i], &other.centres[j]) <= reach * reach
    }
}

/// All combinations of shapes and tolerances; returns the number of couples. One index is built repeatedly.
fn compare<T: FromF64, const D: usize>(scene: &str, moving: &Set<T, D>, fixed: &Set<T, D>) -> usize {
    let mut indices = indices();
    let mut total = 0;
    for (ours, theirs) in [(0.0, 0.0), (0.0, 0.3), (1.5, 0.1)] {
        for (their_shape, target) in fixed.shapes(theirs).iter().enumerate() {
            for (_, _, index) in &mut indices {
                index.build(target).unwrap();
                assert_eq!(index.len(), fixed.centres.len());
            }
            for (shape, elements) in moving.shapes(ours).iter().enumerate() {
                let mut couples = Vec::new();
                if (shape == 2) != (their_shape == 2) {
                    let error = indices[0].2.couples_with(elements, &mut couples);
                    assert_eq!(error, Err(Error::UnlikeShapes));
                    continue;
                }
                let tolerance = T::from_f64(f64::max(ours, theirs));
                let mut expected = Vec::new();
                for i in 0..moving.centres.len() {
                    let touching = (0..fixed.centres.len())
                        .filter(|&j| moving.touch(shape, i, fixed, their_shape, j, tolerance));
                    expected.extend(touching.map(|j| CrossCouple { i: i as u32, j: j as u32 }));
                }
                let mut order: Option<Vec<CrossCouple>> = None;
                for (simd, threads, index) in &mut indices {
                    let context = || {
                        format!("{scene}, {simd}, {threads}, shapes {shape} {their_shape}, {ours} {theirs}")
                    };
                    index.couples_with(elements, &mut couples).unwrap();
                    let mut visited = Vec::new();
                    index.for_each_with(elements, |couple| visited.push(couple)).unwrap();
                    assert!(visited == couples, "{}", context());
                    assert!(order.get_or_insert_with(|| couples.clone()) == &couples, "order: {}", context());
                    couples.sort_unstable();
                    assert!(couples == expected, "{}", context());
                    assert_eq!(index.count_with(elements), Ok(expected.len() as u64), "{}", context());
                }
                total += expected.len();
            }
        }
    }
    total
}

fn all_scenes<T: FromF64, const D: usize>() {
    let unlike = Sizes::PowerLaw { min: 0.2, max: 1.0, exponent: -2.5 };
    let Scenes { gas: cloud, lattice, clusters, outliers, one_place, nothing } = Scenes::<D>::new();
    let other = gas::<D>(300, 2, 6.0, unlike).unwrap();
    let set = |cloud: &Cloud<D>, scale: f64, shift: f64| Set::<T, D>::new(cloud, scale, shift);
    let fixed = set(&cloud, 1.0, 0.0);

    assert!(compare("side by side", &set(&other, 1.0, 0.25), &fixed) > 1000);
    assert!(compare("much larger", &set(&other, 6.0, -1.0), &fixed) > 5000);
    assert!(compare("much smaller", &set(&other, 0.01, 0.5), &fixed) > 100);
    assert!(compare("the index much smaller", &fixed, &set(&other, 0.01, 0.5)) > 100);
    compare("far away", &set(&other, 1.0, 1e5), &fixed);
    compare("far away, below", &set(&other, 1.0, -1e5), &fixed);
    assert_eq!(compare("nothing asks", &set(&nothing, 1.0, 0.0), &fixed), 0);
    assert_eq!(compare("nobody to ask", &fixed, &set(&nothing, 1.0, 0.0)), 0);

    // Equal spacings, exactly touching.
    let touching = set(&lattice, 1.0, 0.0);
    assert!(compare("lattice", &touching, &touching) > 1000);
    let clustered = set(&clusters, 1.0, 0.0);
    assert!(compare("clusters", &clustered, &clustered) > 1000);
    assert!(compare("outliers", &set(&outliers, 1.0, 0.0), &fixed) > 1000);
    assert!(compare("outliers in the index", &fixed, &set(&outliers, 1.0, 0.0)) > 1000);
    assert!(compare("one place", &set(&one_place, 1.0, 0.0), &set(&one_place, 1.0, 0.0)) >= 50 * 50);
}

in_all_dimensions!(all_scenes);

/// Several parts of the work on several threads: each element of a set with itself, and every couple of one
/// set twice.
#[test]
fn a_set_with_itself_finds_what_one_search_finds() {
    let cloud = gas::<3>(30_000, 3, 12.0, EQUAL).unwrap();
    let elements = Elements::points(&cloud.centres, 1.0).unwrap();
    let mut expected = Vec::new();
    Rows::new().couples(&elements, &mut expected).unwrap();
    let mut order: Option<Vec<CrossCouple>> = None;
    for threads in [1, 2, 3] {
        let mut index = Index::new().with_threads(threads).unwrap();
        index.build(&elements).unwrap();
        let mut couples = Vec::new();
        index.couples_with(&elements, &mut couples).unwrap();
        assert!(order.get_or_insert_with(|| couples.clone()) == &couples, "{threads} threads");
        assert_eq!(index.count_with(&elements), Ok(2 * expected.len() as u64 + 30_000));
        couples.retain(|couple| couple.i < couple.j);
        couples.sort_unstable();
        expected.sort_unstable();
        assert!(couples.iter().map(|couple| (couple.i, couple.j)).eq(expected.iter().map(|c| (c.i, c.j))));
    }
}

#[test]
fn an_index_that_is_not_built_says_so() {
    let mut index = Index::<f64, 2>::new();
    let elements = Elements::points(&[[0.0, 0.0]], 1.0).unwrap();
    let mut couples = vec![CrossCouple { i: 0, j: 0 }];
    assert_eq!(index.couples_with(&elements, &mut couples), Err(Error::IndexNotBuilt));
    assert!(couples.is_empty() && index.is_empty());
    assert_eq!(index.count_with(&elements), Err(Error::IndexNotBuilt));
}

/// Cells beyond any integer, squares that underflow, domains of 10^15 cells.
#[test]
fn extremes_of_scale() {
    for scale in [1e-300, 1e-160, 1.0, 1e140] {
        let fixed: Vec<[f64; 2]> =
            (0..50).map(|k| [f64::from(k) * scale, f64::from(k % 7) * scale]).collect();
        let mut moving = fixed.clone();
        moving.push([1e149, -1e149]);
        let (target, elements) =
            (Elements::points(&fixed, scale).unwrap(), Elements::points(&moving, scale).unwrap());
        let (s, mut expected) = ((0.5 * scale + 0.5 * scale) * (0.5 * scale + 0.5 * scale), 0);
        for a in &moving {
            expected += fixed
                .iter()
                .filter(|b| (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) <= s)
                .count() as u64;
        }
        let mut index = Index::new();
        index.build(&target).unwrap();
        assert_eq!(index.count_with(&elements), Ok(expected), "scale {scale}");
    }
}

fn spheres() -> impl Strategy<Value = Vec<([f64; 3], f64)>> {
    prop::collection::vec(([coordinate(), coordinate(), coordinate()], 0.0..4.0), 0..40)
}

proptest! {
    #![proptest_config(crate::cases(512))]

    #[test]
    fn any_two_sets(moving in spheres(), fixed in spheres()) {
        let (centres, radii): (Vec<_>, Vec<_>) = moving.iter().copied().unzip();
        let (their_centres, their_radii): (Vec<_>, Vec<_>) = fixed.iter().copied().unzip();
        let both: Vec<[f64; 3]> = centres.iter().chain(&their_centres).copied().collect();
        let all: Vec<f64> = radii.iter().chain(&their_radii).copied().collect();
        let union = Elements::spheres_with_radii(&both, &all).unwrap();
        let mut expected = Vec::new();
        for i in 0..centres.len() {
            let touching = (0..fixed.len()).filter(|&j| union.touch(i, centres.len() + j));
            expected.extend(touching.map(|j| CrossCouple { i: i as u32, j: j as u32 }));
        }
        let mut index = Index::new();
        index.build(&Elements::spheres_with_radii(&their_centres, &their_radii).unwrap()).unwrap();
        let mut couples = Vec::new();
        index.couples_with(&Elements::spheres_with_radii(&centres, &radii).unwrap(), &mut couples).unwrap();
        couples.sort_unstable();
        prop_assert_eq!(couples, expected);
    }
}

/// Filters between two sets: all kinds, compared with filtering afterwards, with every set of instructions,
/// also for boxes.
#[test]
fn filters_of_the_two_sets_are_tested_together() {
    let [moving, fixed] = [(700, 1), (900, 2)].map(|(n, seed)| {
        Set::<f64, 3>::new(&gas::<3>(n, seed, 8.0, Sizes::Equal { radius: 0.5 }).unwrap(), 1.0, 0.0)
    });
    let numbers = |n: u32, number: fn(u32) -> u32| -> Vec<u32> { (0..n).map(number).collect() };
    let numbered = |n| {
        let groups = numbers(n, |k| k * 7 % 40);
        (numbers(n, |k| k % 5), numbers(n, |k| 1 << (k % 3)), numbers(n, |k| 3 << (k % 2)), groups)
    };
    let (ours, theirs) = (numbered(700), numbered(900));
    let mut matrix = GroupMatrix::all(40).unwrap();
    (0..40).for_each(|group| matrix.set(group, group / 2, false).unwrap());
    let filters = |kind: usize| {
        [&ours, &theirs].map(|(bodies, categories, masks, groups)| match kind {
            0 => Filter::bodies(bodies),
            1 => Filter::masks(categories, masks),
            _ => Filter::groups(groups, &matrix).with_bodies(bodies),
        })
    };
    let see = |kind: usize, i: usize, j: usize| match kind {
        0 => ours.0[i] != theirs.0[j],
        1 => ours.1[i] & theirs.2[j] != 0 && theirs.1[j] & ours.2[i] != 0,
        _ => ours.0[i] != theirs.0[j] && matrix.sees(ours.3[i], theirs.3[j]),
    };
    for (a, b) in moving.shapes(0.1).into_iter().zip(fixed.shapes(0.1)) {
        for simd in Simd::available() {
            let mut index = Index::new().with_simd(simd).unwrap();
            index.build(&b).unwrap();
            let mut all = Vec::new();
            index.couples_with(&a, &mut all).unwrap();
            for kind in 0..3 {
                let [of_a, of_b] = filters(kind);
                let a = a.with_filter(of_a).unwrap();
                assert_eq!(index.count_with(&a), Err(Error::UnlikeFilters), "only one set has a filter");
                index.build(&b.with_filter(of_b).unwrap()).unwrap();
                let mut expected = all.clone();
                expected.retain(|&CrossCouple { i, j }| see(kind, i as usize, j as usize));
                assert!(expected.len() < all.len() && !expected.is_empty());
                let mut found = Vec::new();
                index.couples_with(&a, &mut found).unwrap();
                assert_eq!(found, expected, "{simd}, kind {kind}");
                assert_eq!(index.count_with(&a), Ok(expected.len() as u64));
                // Filters have no effect on queries around points.
                let mut around = Csr::new();
                index.within(&[[0.0; 3]], 1e9, &mut around).unwrap();
                assert_eq!(around.neighbours_of(0).len(), 900);
                index.build(&b).unwrap();
            }
        }
    }
}
