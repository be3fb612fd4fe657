//! The vector kernels on short rows, with every set of instructions that the processor has. Fast enough for
//! valgrind, an emulator that watches each access to memory, or for a sanitizer. See `.ci/run`.
//!
//! A new engine holds arrays without spare capacity, and so does the input: an access behind them is outside
//! of the allocation.

use fdem_contact::{
    Couple, CrossCouple, Csr, Direct, Elements, Filter, GroupMatrix, Index, Real, Rows, Search, Simd,
};

/// More elements than two of the widest vectors, of 16 lanes, hold.
const LONGEST: usize = 40;

/// `n` elements in one row of cells, or in several: neighbours touch exactly, others by chance.
fn points<T: Real, const D: usize>(n: usize, rows: usize) -> Box<[[T; D]]> {
    let number = |k: usize| T::at_least(k as f64 * 0.5);
    (0..n).map(|k| std::array::from_fn(|axis| number(if axis == 0 { k / rows } else { k % rows }))).collect()
}

fn radii<T: Real>(n: usize) -> Box<[T]> {
    (0..n).map(|k| T::at_least(0.25 * (1 + k % 3) as f64)).collect()
}

fn check<T: Real, const D: usize>(elements: &Elements<'_, T, D>) {
    let mut expected = Vec::new();
    Direct.couples(elements, &mut expected).unwrap();
    expected.sort_unstable();
    let mut order: Option<Vec<Couple>> = None;
    for simd in Simd::available() {
        let mut rows = Rows::new().with_simd(simd).unwrap();
        let mut couples = Vec::new();
        rows.couples(elements, &mut couples).unwrap();
        assert_eq!(rows.count(elements), Ok(expected.len() as u64), "{simd}, {} elements", elements.len());
        assert_eq!(order.get_or_insert_with(|| couples.clone()), &couples, "{simd}: the order");
        couples.sort_unstable();
        assert_eq!(couples, expected, "{simd}, {} elements", elements.len());
    }
}

/// Every kind of filter, on numbers in arrays as short as the others.
fn check_filters<T: Real, const D: usize>(elements: &Elements<'_, T, D>) {
    let numbers = |number: fn(u32) -> u32| -> Box<[u32]> { (0..elements.len() as u32).map(number).collect() };
    let (bodies, groups) = (numbers(|k| k / 2), numbers(|k| k * 7 % 33));
    let (categories, masks) = (numbers(|k| 1 << (k % 3)), numbers(|k| 3 << (k % 2)));
    let mut matrix = GroupMatrix::all(33).unwrap();
    (0..33).for_each(|group| matrix.set(group, 32 - group, false).unwrap());
    let filters = [
        Filter::bodies(&bodies),
        Filter::masks(&categories, &masks),
        Filter::groups(&groups, &matrix).with_bodies(&bodies),
    ];
    for filter in filters {
        check(&elements.with_filter(filter).unwrap());
    }
}

fn check_all<T: Real, const D: usize>() {
    eprintln!("levels: {:?}", Simd::available());
    for n in 1..=LONGEST {
        for rows in [1, 3] {
            let (points, radii) = (points::<T, D>(n, rows), radii::<T>(n));
            let tolerance = T::at_least(0.25);
            check(&Elements::points(&points, T::HALF).unwrap());
            check(&Elements::spheres(&points, T::HALF).unwrap().with_tolerance(tolerance).unwrap());
            check(&Elements::spheres_with_radii(&points, &radii).unwrap());
            check(&Elements::spheres_with_radii(&points, &radii).unwrap().with_tolerance(tolerance).unwrap());
            // The first box is as long as all are wide. The others have no width, and most begin where
            // another one does.
            let short: Box<[[T; D]]> =
                points.iter().map(|point| point.map(|x| x * T::at_least(0.1))).collect();
            let mut far = short.clone();
            far[0] = far[0].map(|x| x + T::at_least(5.0));
            for (min, max) in [(&points, &points), (&short, &far)] {
                check(&Elements::boxes(min, max).unwrap());
                check(&Elements::boxes(min, max).unwrap().with_tolerance(tolerance).unwrap());
                check_filters(&Elements::boxes(min, max).unwrap());
            }
            check_filters(&Elements::points(&points, T::HALF).unwrap());
            check_filters(&Elements::spheres_with_radii(&points, &radii).unwrap());
        }
    }
}

#[test]
fn discs_f32() {
    check_all::<f32, 2>();
}

#[test]
fn discs_f64() {
    check_all::<f64, 2>();
}

#[test]
fn spheres_f32() {
    check_all::<f32, 3>();
}

#[test]
fn spheres_f64() {
    check_all::<f64, 3>();
}

/// More couples than the first room of a list holds, so that lists grow inside the kernels.
#[test]
fn all_in_one_place() {
    let points = vec![[0.0_f32; 3]; 70].into_boxed_slice();
    check(&Elements::points(&points, 1.0).unwrap());
    let radii = vec![0.0_f32; 70].into_boxed_slice();
    check(&Elements::spheres_with_radii(&points, &radii).unwrap());
}

/// Enough elements to be sorted and searched on several threads, which write to one array.
#[test]
fn several_threads() {
    let points = points::<f64, 3>(21_000, 100);
    let elements = Elements::points(&points, 0.5).unwrap();
    let mut one = Vec::new();
    Rows::new().couples(&elements, &mut one).unwrap();
    assert!(one.len() > 20_000);
    let bodies: Box<[u32]> = (0..21_000).map(|k| k / 2).collect();
    let filtered = elements.with_filter(Filter::bodies(&bodies)).unwrap();
    let mut fewer = one.clone();
    fewer.retain(|couple| couple.i / 2 != couple.j / 2);
    if let Ok(mut rows) = Rows::new().with_threads(3) {
        let mut three = Vec::new();
        rows.couples(&filtered, &mut three).unwrap();
        assert_eq!(three, fewer);
        rows.couples(&elements, &mut three).unwrap();
        assert_eq!(three, one);
        assert_eq!(rows.count(&elements), Ok(one.len() as u64));
    }
}

/// Two sets of few elements, and queries: rows of one layout against those of another.
#[test]
fn two_sets() {
    for n in [1, 7, 8, 9, LONGEST] {
        for m in [1, 15, 16, 17, LONGEST] {
            for rows in [1, 3] {
                let (ours, theirs) = (points::<f32, 3>(n, rows), points::<f32, 3>(m, 2));
                let (our_radii, their_radii) = (radii::<f32>(n), radii::<f32>(m));
                let elements = Elements::spheres_with_radii(&ours, &our_radii).unwrap();
                let (fixed, equal) = (
                    Elements::spheres_with_radii(&theirs, &their_radii).unwrap(),
                    Elements::spheres(&theirs, 0.25).unwrap(),
                );
                let mut expected = Vec::new();
                for i in 0..n {
                    for j in 0..m {
                        let (pair, pair_radii) = ([ours[i], theirs[j]], [our_radii[i], their_radii[j]]);
                        if Elements::spheres_with_radii(&pair, &pair_radii).unwrap().touch(0, 1) {
                            expected.push(CrossCouple { i: i as u32, j: j as u32 });
                        }
                    }
                }
                let mut order: Option<Vec<CrossCouple>> = None;
                for simd in Simd::available() {
                    let mut index = Index::new().with_simd(simd).unwrap();
                    index.build(&fixed).unwrap();
                    let mut couples = Vec::new();
                    index.couples_with(&elements, &mut couples).unwrap();
                    assert_eq!(order.get_or_insert_with(|| couples.clone()), &couples, "{simd}: the order");
                    couples.sort_unstable();
                    assert_eq!(couples, expected, "{simd}, {n} against {m}");
                    assert_eq!(index.count_with(&elements), Ok(couples.len() as u64));
                    index.build(&equal).unwrap();
                    index.couples_with(&elements, &mut couples).unwrap();
                    assert_eq!(index.count_with(&elements), Ok(couples.len() as u64));
                    let mut found = Csr::new();
                    index.within_with_distances(&ours, 0.5, &mut found).unwrap();
                    assert!(found.values().iter().all(|&squared| squared <= 0.25));
                    index.nearest(&ours, 3, &mut found).unwrap();
                    assert_eq!(found.neighbours().len(), n * m.min(3));
                }
            }
        }
    }
}
