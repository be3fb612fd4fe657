//! Filters: every search finds its own result without a filter, filtered afterwards, in the same order.

use fdem_contact::{
    Buffered, CGrid, Couple, Detector, Direct, Elements, Engine, Error, Filter, GroupMatrix, Mismatch,
    Multilevel, Nbs, PeriodicBox, PeriodicCouple, PeriodicSearch, Real, Reason, Rows, Search, Simd, verify,
};
use fdem_scenes::random::Random;
use fdem_scenes::{Cloud, Sizes, clusters, gas};

use crate::ascending;
use crate::oracle::FromF64;

/// A filter that owns its numbers, with its rule written out independently.
#[derive(Clone, Default)]
struct Case {
    name: String,
    bodies: Option<Vec<u32>>,
    masks: Option<[Vec<u32>; 2]>,
    groups: Option<(Vec<u32>, GroupMatrix)>,
    /// The intended matrix.
    seen: Vec<Vec<bool>>,
}

impl Case {
    fn filter(&self) -> Filter<'_> {
        let sight = match (&self.masks, &self.groups) {
            (Some([categories, masks]), _) => Filter::masks(categories, masks),
            (_, Some((groups, matrix))) => Filter::groups(groups, matrix),
            _ => return Filter::bodies(self.bodies.as_ref().unwrap()),
        };
        self.bodies.iter().fold(sight, |sight, bodies| sight.with_bodies(bodies))
    }

    fn admits(&self, i: u32, j: u32) -> bool {
        let (i, j) = (i as usize, j as usize);
        let one_body = self.bodies.as_ref().is_some_and(|bodies| bodies[i] == bodies[j]);
        let masked = self.masks.as_ref().is_some_and(|[categories, masks]| {
            (categories[i] & masks[j]) == 0 || (categories[j] & masks[i]) == 0
        });
        let unseen = self
            .groups
            .as_ref()
            .is_some_and(|(groups, _)| !self.seen[groups[i] as usize][groups[j] as usize]);
        !one_body && !masked && !unseen
    }
}

fn numbers(n: usize, seed: u64, number: impl Fn(u64) -> u32) -> Vec<u32> {
    let mut random = Random::new(seed);
    (0..n).map(|_| number(random.bits())).collect()
}

/// Random groups, and a matrix in which about half of the entries are true.
fn grouped(n: usize, groups: usize, seed: u64) -> Case {
    let mut random = Random::new(seed);
    let mut seen = vec![vec![false; groups]; groups];
    let mut matrix = GroupMatrix::none(groups).unwrap();
    for (a, b) in (0..groups).flat_map(|a| (0..=a).map(move |b| (a, b))) {
        let see = random.bits() >> 63 == 1;
        (seen[a][b], seen[b][a]) = (see, see);
        matrix.set(b as u32, a as u32, see).unwrap();
    }
    let of = numbers(n, seed + 1, |bits| ((bits >> 20) % groups as u64) as u32);
    Case { name: format!("{groups} groups"), groups: Some((of, matrix)), seen, ..Case::default() }
}

/// Every kind of filter, each with and without bodies.
fn cases(n: usize) -> Vec<Case> {
    // The lowest and the highest bit are among them.
    let bits = |bits: u64| (bits >> 32) as u32 & 0x8000_0021;
    let masks = Case {
        name: "masks".to_owned(),
        masks: Some([numbers(n, 1, bits), numbers(n, 2, bits)]),
        ..Case::default()
    };
    // Some numbers have bit 31 set: they are compared, not subtracted.
    let bodies = numbers(n, 3, |bits| [0, 7, u32::MAX, 1 << 31][(bits >> 62) as usize]);
    let groups = [3, 31, 32, 33, 64, 100].map(|groups| grouped(n, groups, 4));
    let mut cases: Vec<Case> = groups.into_iter().chain([masks]).collect();
    for k in 0..cases.len() {
        let mut with_bodies = cases[k].clone();
        with_bodies.name += " and bodies";
        with_bodies.bodies = Some(bodies.clone());
        cases.push(with_bodies);
    }
    cases.push(Case { name: "bodies".to_owned(), bodies: Some(bodies), ..Case::default() });
    cases
}

/// The couples of all methods of a search, in its order.
fn found<T: Real, const D: usize>(
    search: &mut impl Search<T, D>,
    elements: &Elements<'_, T, D>,
) -> Vec<Couple> {
    let (mut couples, mut visited) = (Vec::new(), Vec::new());
    search.couples(elements, &mut couples).unwrap();
    search.for_each(elements, |couple| visited.push(couple)).unwrap();
    assert!(couples == visited, "a visitor sees the order of the list");
    assert_eq!(search.count(elements).unwrap(), couples.len() as u64);
    couples
}

/// Searches first without a filter and then with it, in the same memory.
fn compare_search<T: Real, const D: usize>(
    name: &str,
    mut search: impl Search<T, D>,
    elements: &Elements<'_, T, D>,
    cases: &[Case],
) {
    let all = found(&mut search, elements);
    for case in cases {
        let filtered = elements.with_filter(case.filter()).unwrap();
        let mut expected = all.clone();
        expected.retain(|couple| case.admits(couple.i, couple.j));
        assert!(!expected.is_empty() || all.len() < 100, "{}: nothing is left", case.name);
        assert!(expected.len() < all.len() || all.len() < 100, "{}: nothing is left out", case.name);
        let found = found(&mut search, &filtered);
        assert!(found == expected, "{name}, {}, D = {D}, {} elements", case.name, elements.len());
    }
    assert!(found(&mut search, elements) == all, "{name}: without a filter again");
}

fn compare<T: FromF64, const D: usize>(cloud: &Cloud<D>) {
    let centres: Vec<[T; D]> = cloud.centres.iter().map(|centre| centre.map(T::from_f64)).collect();
    let radii: Vec<T> = cloud.radii.iter().copied().map(T::from_f64).collect();
    let corner = |side: f64| -> Vec<[T; D]> {
        let corners = cloud.centres.iter().zip(&cloud.radii);
        corners.map(|(centre, radius)| centre.map(|x| T::from_f64(x + side * radius))).collect()
    };
    let (min, max) = (corner(-1.0), corner(1.0));
    let few = centres.len() <= 1000;
    let mut cases = cases(centres.len());
    cases.retain(|case| few || ["bodies", "masks and bodies", "33 groups"].contains(&case.name.as_str()));
    let shapes = [
        Elements::points(&centres, T::from_f64(1.0)),
        Elements::spheres_with_radii(&centres, &radii),
        Elements::boxes(&min, &max),
    ];
    for elements in shapes {
        let elements = elements.unwrap();
        for simd in Simd::available().into_iter().filter(|&simd| few || simd == Simd::best()) {
            for threads in [1, 3] {
                let rows = Rows::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
                compare_search(&format!("rows, {simd}, {threads} threads"), rows, &elements, &cases);
                let levels = Multilevel::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
                let levels = levels.with_limits(&[0.9, 1.2]);
                compare_search(&format!("levels, {simd}, {threads} threads"), levels, &elements, &cases);
            }
        }
        if few {
            compare_search("direct", Direct, &elements, &cases);
            compare_search("nbs", Nbs::new(), &elements, &cases);
            compare_search("cgrid", CGrid::new(), &elements, &cases);
            compare_search("auto", Detector::new(), &elements, &cases);
            // The engines agree with `touch`.
            for case in &cases {
                let filtered = elements.with_filter(case.filter()).unwrap();
                let couples = ascending(Direct, &filtered);
                assert_eq!(verify(&filtered, &couples, centres.len(), 0), Ok(centres.len()));
                assert!(couples.iter().all(|&Couple { i, j }| filtered.touch(j as usize, i as usize)));
            }
        }
    }
}

const SIZES: Sizes = Sizes::Lognormal { median: 0.5, sigma: 0.2 };

fn small_and_few<T: FromF64, const D: usize>() {
    for n in [0, 1, 2, 20, 400] {
        compare::<T, D>(&gas::<D>(n, 5, 8.0, SIZES).unwrap());
    }
    // One row that is longer than any vector, and a domain with more rows than elements.
    let mut row = gas::<D>(100, 5, 8.0, SIZES).unwrap();
    row.centres.iter_mut().enumerate().for_each(|(k, centre)| *centre = [k as f64 * 0.3; D]);
    row.centres.iter_mut().for_each(|centre| centre[1..].fill(0.5));
    compare::<T, D>(&row);
    compare::<T, D>(&clusters::<D>(300, 5, 30, 1000.0, 6.0, SIZES).unwrap());
}

#[test]
fn equal_to_filtering_afterwards_f64_2d() {
    small_and_few::<f64, 2>();
}

#[test]
fn equal_to_filtering_afterwards_f64_3d() {
    small_and_few::<f64, 3>();
}

#[test]
fn equal_to_filtering_afterwards_f64_4d() {
    small_and_few::<f64, 4>();
}

#[test]
fn equal_to_filtering_afterwards_f32_3d() {
    small_and_few::<f32, 3>();
}

/// Enough elements for several threads to sort and search, rows counted and in buckets.
#[test]
fn equal_to_filtering_afterwards_on_threads() {
    compare::<f64, 3>(&gas::<3>(25_000, 6, 8.0, SIZES).unwrap());
    compare::<f32, 2>(&clusters::<2>(25_000, 7, 500, 1e6, 4.0, SIZES).unwrap());
}

#[test]
fn a_fold_honours_the_filter() {
    let cloud = gas::<3>(6000, 8, 8.0, SIZES).unwrap();
    let elements = Elements::points(&cloud.centres, 1.0).unwrap();
    let all = ascending(Rows::new(), &elements);
    for case in cases(cloud.len()) {
        let filtered = elements.with_filter(case.filter()).unwrap();
        let counts = Rows::new().fold(&filtered, || 0, |count, _| *count += 1).unwrap();
        let expected = all.iter().filter(|couple| case.admits(couple.i, couple.j)).count();
        assert_eq!(counts.into_iter().sum::<usize>(), expected, "{}", case.name);
    }
}

#[test]
fn images_see_what_their_elements_see() {
    let mut random = Random::new(9);
    for (edge, n) in [(6.0, 120), (1.3, 12), (0.45, 4)] {
        let centres: Vec<[f64; 2]> =
            (0..n).map(|_| std::array::from_fn(|_| random.between(-edge, 2.0 * edge))).collect();
        let radii: Vec<f64> = (0..n).map(|_| random.between(0.2, 0.5)).collect();
        let cell =
            PeriodicBox::triclinic([0.0, 0.0], [[edge, 0.0], [0.3 * edge, edge]], [true, true]).unwrap();
        for elements in [Elements::points(&centres, 1.0), Elements::spheres_with_radii(&centres, &radii)] {
            let elements = elements.unwrap();
            for engine in Engine::ALL.map(Some).into_iter().chain([None]) {
                let mut search = PeriodicSearch::new().with_engine(engine);
                let mut found = |elements: &Elements<'_, f64, 2>| -> Vec<PeriodicCouple<2>> {
                    let mut couples = Vec::new();
                    search.couples(elements, &cell, &mut couples).unwrap();
                    couples
                };
                let all = found(&elements);
                let own_images = all.iter().filter(|couple| couple.i == couple.j).count();
                assert_eq!(own_images > 0, edge < 1.0, "elements touch their own images in small boxes");
                for case in cases(n) {
                    let mut expected = all.clone();
                    expected.retain(|couple| case.admits(couple.i, couple.j));
                    let found = found(&elements.with_filter(case.filter()).unwrap());
                    assert!(found == expected, "{engine:?}, {}, edge {edge}", case.name);
                    assert!(case.bodies.is_none() || found.iter().all(|couple| couple.i != couple.j));
                }
                assert!(found(&elements) == all, "{engine:?}: without a filter again");
            }
        }
    }
}

#[test]
fn updates_honour_the_filter() {
    let mut cloud = gas::<3>(300, 10, 8.0, SIZES).unwrap();
    let mut random = Random::new(11);
    for case in cases(300) {
        let mut auto = Buffered::new(0.3).unwrap();
        let mut rows = Buffered::with_search(Rows::new(), 0.3).unwrap();
        for step in 0..6 {
            let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
            let elements = elements.with_filter(case.filter()).unwrap();
            let expected = ascending(Direct, &elements);
            let mut couples = Vec::new();
            for update in [auto.update(&elements).unwrap(), rows.update(&elements).unwrap()] {
                assert_eq!(update.redetected(), step == 0, "{:?}", update.reason());
                update.couples(&mut couples).unwrap();
                couples.sort_unstable();
                assert_eq!(couples, expected, "{}, step {step}", case.name);
                let candidates = update.candidates();
                assert!(candidates.iter().all(|couple| case.admits(couple.i, couple.j)), "{}", case.name);
            }
            cloud.centres.iter_mut().flatten().for_each(|x| *x += random.between(-0.01, 0.01));
        }
    }
}

#[test]
fn a_filter_that_changes_is_noticed() {
    let centres: Vec<[f64; 2]> = (0..50).map(|k| [f64::from(k) * 0.5, 0.0]).collect();
    let plain = Elements::points(&centres, 1.0).unwrap();
    let mut buffered = Buffered::new(0.3).unwrap();
    let mut reason = |elements: Elements<'_, f64, 2>| {
        let (expected, mut found) = (ascending(Direct, &elements), Vec::new());
        let update = buffered.update(&elements).unwrap();
        update.couples(&mut found).unwrap();
        found.sort_unstable();
        assert_eq!(found, expected);
        update.reason()
    };
    let changed = |element| Some(Reason::FilterChanged { element });

    assert_eq!(reason(plain), Some(Reason::First));
    let mut numbers = vec![0; 50];
    assert_eq!(reason(plain.with_filter(Filter::bodies(&numbers)).unwrap()), changed(None));
    assert_eq!(reason(plain.with_filter(Filter::bodies(&numbers)).unwrap()), None);
    // A body breaks in two.
    numbers[31..].fill(1);
    assert_eq!(reason(plain.with_filter(Filter::bodies(&numbers)).unwrap()), changed(Some(31)));
    assert_eq!(reason(plain.with_filter(Filter::bodies(&numbers)).unwrap()), None);

    // The same numbers with another meaning.
    let mut matrix = GroupMatrix::all(2).unwrap();
    let mut grouped =
        |matrix: &GroupMatrix| reason(plain.with_filter(Filter::groups(&numbers, matrix)).unwrap());
    assert_eq!(grouped(&matrix), changed(None));
    assert_eq!(grouped(&matrix), None);
    matrix.set(1, 0, false).unwrap();
    assert_eq!(grouped(&matrix), changed(None));
    let categories = [1; 50];
    assert_eq!(reason(plain.with_filter(Filter::masks(&categories, &categories)).unwrap()), changed(None));
    let mut masks = categories;
    masks[7] = 2;
    assert_eq!(reason(plain.with_filter(Filter::masks(&categories, &masks)).unwrap()), changed(Some(7)));
    assert_eq!(reason(plain), changed(None));
    assert_eq!(reason(plain), None);
}

/// The couples of all engines and instruction sets for elements that all touch each other.
fn couples_of(elements: &Elements<'_, f32, 3>) -> Vec<Couple> {
    let expected = ascending(Direct, elements);
    assert_eq!(ascending(Nbs::new(), elements), expected);
    for simd in Simd::available() {
        assert_eq!(ascending(Rows::new().with_simd(simd).unwrap(), elements), expected, "{simd}");
    }
    expected
}

#[test]
fn everything_and_nothing_is_left_out() {
    let centres = [[0.5_f32; 3]; 40];
    let plain = Elements::points(&centres, 1.0).unwrap();
    let all = couples_of(&plain);
    assert_eq!(all.len(), 40 * 39 / 2);
    let filtered = |filter: Filter<'_>| couples_of(&plain.with_filter(filter).unwrap());

    assert_eq!(filtered(Filter::bodies(&[9; 40])), []);
    let own: Vec<u32> = (0..40).collect();
    assert_eq!(filtered(Filter::bodies(&own)), all);
    assert_eq!(filtered(Filter::masks(&[0; 40], &[u32::MAX; 40])), [], "no category");
    assert_eq!(filtered(Filter::masks(&[u32::MAX; 40], &[0; 40])), [], "no mask");
    assert_eq!(filtered(Filter::masks(&[1 << 31; 40], &[1 << 31; 40])), all);
    // i sees j, but j does not see i.
    let categories: Vec<u32> = (0..40).map(|k| 1 + k % 2).collect();
    assert_eq!(filtered(Filter::masks(&categories, &[1; 40])).len(), 20 * 19 / 2);

    for groups in [1, 31, 32, 33, 64, 65] {
        let of: Vec<u32> = (0..40).map(|k| k % groups).collect();
        let none = GroupMatrix::none(groups as usize).unwrap();
        assert_eq!(filtered(Filter::groups(&of, &none)), [], "{groups} groups");
        let matrix = GroupMatrix::all(groups as usize).unwrap();
        assert_eq!(filtered(Filter::groups(&of, &matrix)), all, "{groups} groups");
        assert_eq!(filtered(Filter::groups(&of, &matrix).with_bodies(&[0; 40])), [], "{groups} groups");
        // The last group sees the first one; no other groups see each other.
        let mut last = none;
        last.set(groups - 1, 0, true).unwrap();
        let of: Vec<u32> = (0..40).map(|k| if k == 3 { groups - 1 } else { 0 }).collect();
        let expected = if groups == 1 { 40 * 39 / 2 } else { 39 };
        assert_eq!(filtered(Filter::groups(&of, &last)).len(), expected, "{groups} groups");
    }
}

#[test]
fn a_matrix_is_symmetric_and_knows_its_groups() {
    for groups in [1, 31, 32, 33, 64, 70] {
        let last = groups as u32 - 1;
        let mut matrix = GroupMatrix::none(groups).unwrap();
        matrix.set(last, 0, true).unwrap();
        assert_eq!(matrix.groups(), groups);
        assert!(matrix.sees(0, last) && matrix.sees(last, 0));
        matrix.set(0, last, false).unwrap();
        assert_eq!(matrix, GroupMatrix::none(groups).unwrap());
        for (a, b) in (0..=last).flat_map(|a| (0..=last).map(move |b| (a, b))) {
            matrix.set(a, b, true).unwrap();
        }
        assert_eq!(matrix, GroupMatrix::all(groups).unwrap());
        assert_eq!(
            matrix.set(last + 1, 0, true),
            Err(Error::UnknownGroup { index: None, group: last + 1, groups })
        );
    }
    assert!(matches!(GroupMatrix::all(usize::MAX), Err(Error::OutOfMemory { .. })));
}

#[test]
#[should_panic(expected = "no group 3")]
fn a_group_behind_the_last_is_a_panic() {
    GroupMatrix::all(3).unwrap().sees(0, 3);
}

#[test]
fn no_elements_need_no_groups() {
    let matrix = GroupMatrix::all(0).unwrap();
    let elements = Elements::<f64, 3>::points(&[], 1.0).unwrap();
    let elements = elements.with_filter(Filter::groups(&[], &matrix).with_bodies(&[])).unwrap();
    assert_eq!(ascending(Rows::new(), &elements), []);
    assert_eq!(ascending(Nbs::new(), &elements), []);
    let one = Elements::points(&[[0.0; 3]], 1.0).unwrap();
    let error = one.with_filter(Filter::groups(&[0], &matrix)).unwrap_err();
    assert_eq!(error, Error::UnknownGroup { index: Some(0), group: 0, groups: 0 });
}

#[test]
fn wrong_numbers_are_named() {
    let elements = Elements::points(&[[0.0; 2]; 3], 1.0).unwrap();
    let refused = |filter: Filter<'_>| elements.with_filter(filter).unwrap_err();
    let length = |what, found| Error::LengthMismatch { what, expected: 3, found };
    let matrix = GroupMatrix::all(33).unwrap();
    assert_eq!(refused(Filter::bodies(&[])), length("bodies", 0));
    assert_eq!(refused(Filter::masks(&[1; 4], &[1; 3])), length("categories", 4));
    assert_eq!(refused(Filter::masks(&[1; 3], &[1; 2])), length("masks", 2));
    assert_eq!(refused(Filter::groups(&[1; 2], &matrix)), length("groups", 2));
    assert_eq!(refused(Filter::groups(&[1; 3], &matrix).with_bodies(&[1])), length("bodies", 1));
    assert_eq!(refused(Filter::bodies(&[1; 4])).to_string(), "3 elements but 4 bodies");

    let error = refused(Filter::groups(&[32, 33, 34], &matrix));
    assert_eq!(error, Error::UnknownGroup { index: Some(1), group: 33, groups: 33 });
    assert_eq!(error.element(), Some(1));
    assert_eq!(error.to_string(), "element 1: group 33 is not below 33, the number of groups of the matrix");
}

#[test]
fn a_check_honours_the_filter() {
    let plain = Elements::points(&[[0.0]; 3], 1.0).unwrap();
    let filtered = plain.with_filter(Filter::bodies(&[0, 1, 1])).unwrap();
    let all = ascending(Direct, &plain);
    assert_eq!(verify(&filtered, &all, 3, 0), Err(Mismatch::Extra(Couple::new(1, 2))));
    assert_eq!(verify(&filtered, &all[..1], 3, 0), Err(Mismatch::Missing(Couple::new(0, 2))));
    assert_eq!(verify(&filtered, &all[..2], 3, 0), Ok(3));
}

/// A later filter replaces an earlier one.
#[test]
fn a_filter_is_replaced() {
    let plain = Elements::points(&[[0.0]; 3], 1.0).unwrap();
    let twice = plain.with_filter(Filter::bodies(&[0; 3])).unwrap();
    let twice = twice.with_filter(Filter::bodies(&[0, 1, 1])).unwrap();
    assert_eq!(ascending(Direct, &twice).len(), 2);
    assert!(plain.filter().is_none() && twice.filter().is_some_and(|filter| filter.admits(0, 1)));
}

#[test]
fn memory_is_what_the_filter_says() {
    let n = 10_000;
    let cloud = gas::<3>(n, 12, 8.0, SIZES).unwrap();
    let elements = Elements::points(&cloud.centres, 1.0).unwrap();
    let bytes = |elements: &Elements<'_, f64, 3>| {
        let mut rows = Rows::new();
        rows.count(elements).unwrap();
        rows.bytes()
    };
    let none = bytes(&elements);
    for case in cases(n) {
        let of_sight = match (&case.masks, &case.groups) {
            (Some(_), _) => 8,
            (_, Some((_, matrix))) => {
                if matrix.groups() <= 32 {
                    8
                } else {
                    4
                }
            }
            _ => 0,
        };
        let each = of_sight + if case.bodies.is_some() { 4 } else { 0 };
        let more = bytes(&elements.with_filter(case.filter()).unwrap()) - none;
        assert_eq!(more / n, each, "{}: {more} bytes", case.name);
    }
}
