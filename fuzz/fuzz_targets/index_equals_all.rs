//! `Index`, with every set of vector instructions, finds the results of tests of all against all, or returns
//! the documented error.

#![no_main]

use fdem_contact::{CrossCouple, Csr, Elements, Error, Index, Simd};
use fdem_fuzz::{Number, Pair, PairLaw, check_pair, distance_squared};
use libfuzzer_sys::fuzz_target;

/// The rows of a search around points: the numbers of the elements and their squared distances; or the error
/// as text, so that NaN values compare equal.
type Rows<T> = Result<Vec<Vec<(u32, T)>>, String>;

struct IndexEqualsAll;

impl PairLaw for IndexEqualsAll {
    fn check<T: Number, const D: usize>(pair: &Pair<T, D>) {
        let Ok(fixed) = pair.fixed.elements() else { return };
        let (within, nearest) = (within(pair), nearest(pair));
        for simd in Simd::available() {
            let mut index = Index::new().with_simd(simd).expect("the level is available");
            index.build(&fixed).expect("what is checked can be sorted");
            check_couples(pair, &mut index);

            let mut found = Csr::new();
            let result = index.within_with_distances(&pair.points, pair.r, &mut found);
            assert_eq!(rows(result, &found), within, "{simd}: within {:?}", pair.r);
            let mut plain = Csr::new();
            let result = index.within(&pair.points, pair.r, &mut plain);
            assert_eq!(in_words(result).err().as_ref(), within.as_ref().err(), "{simd}");
            assert_eq!(plain.neighbours(), found.neighbours(), "{simd}");
            let result = index.nearest(&pair.points, pair.k, &mut found);
            assert_eq!(rows(result, &found), nearest, "{simd}: {} nearest", pair.k);
        }
    }
}

fn check_couples<T: Number, const D: usize>(pair: &Pair<T, D>, index: &mut Index<T, D>) {
    let Ok(moving) = pair.moving.elements() else { return };
    let expected = pair.moving.couples_with(&pair.fixed);
    let mut couples = vec![CrossCouple { i: 0, j: 0 }];
    let result = index.couples_with(&moving, &mut couples);
    let (mut visited, mut sorted) = (Vec::new(), couples.clone());
    sorted.sort_unstable();
    assert_eq!(result.map(|()| sorted), expected);
    assert_eq!(
        index.count_with(&moving),
        expected.as_ref().map(|couples| couples.len() as u64).map_err(Clone::clone)
    );
    let result = index.for_each_with(&moving, |couple| visited.push(couple));
    assert_eq!(result.err().as_ref(), expected.as_ref().err());
    assert_eq!(visited, couples, "the same order");
}

fn rows<T: Number>(result: Result<(), Error>, found: &Csr<T>) -> Rows<T> {
    let row = |q| found.neighbours_of(q).iter().copied().zip(found.values_of(q).iter().copied()).collect();
    if result.is_err() {
        assert!(found.is_empty(), "nothing is left of an earlier search");
    }
    in_words(result).map(|()| (0..found.len()).map(row).collect())
}

fn in_words<R>(result: Result<R, Error>) -> Result<R, String> {
    result.map_err(|error| error.to_string())
}

/// All elements with their squared distances, ascending by number.
fn all<T: Number, const D: usize>(pair: &Pair<T, D>, point: &[T; D]) -> Vec<(u32, T)> {
    (0..).zip(pair.fixed.points()).map(|(j, centre)| (j, distance_squared(point, centre))).collect()
}

fn within<T: Number, const D: usize>(pair: &Pair<T, D>) -> Rows<T> {
    in_words(Elements::points(&pair.points, pair.r))?;
    let row =
        |point| all(pair, point).into_iter().filter(|&(_, squared)| squared <= pair.r * pair.r).collect();
    Ok(pair.points.iter().map(row).collect())
}

fn nearest<T: Number, const D: usize>(pair: &Pair<T, D>) -> Rows<T> {
    in_words(Elements::points(&pair.points, T::ZERO))?;
    let row = |point| {
        let mut all = all(pair, point);
        all.sort_by(|(i, a), (j, b)| a.partial_cmp(b).expect("distances are finite").then(i.cmp(j)));
        all.truncate(pair.k);
        all
    };
    Ok(pair.points.iter().map(row).collect())
}

fuzz_target!(|bytes: &[u8]| check_pair::<IndexEqualsAll>(bytes));
