//! `Rows`, with every set of vector instructions, finds the couples of all-against-all, in one order.

#![no_main]

use fdem_contact::{Elements, Rows, Search, Simd};
use fdem_fuzz::{Law, Number, ascending, check, expected};
use libfuzzer_sys::fuzz_target;

struct RowsEqualsDirect;

impl Law for RowsEqualsDirect {
    fn check<T: Number, const D: usize>(elements: &Elements<'_, T, D>) {
        let expected = expected(elements);
        let mut order = None;
        for simd in Simd::available() {
            // A new engine holds arrays without spare capacity, so that a read behind the end is detected.
            let mut rows = Rows::new().with_simd(simd).expect("the level is available");
            let mut couples = Vec::new();
            rows.couples(elements, &mut couples).expect("rows take any domain");
            assert_eq!(ascending(&couples), expected, "{simd}");
            assert_eq!(rows.count(elements), Ok(expected.len() as u64), "{simd}, counted");
            let mut visited = Vec::new();
            rows.for_each(elements, |couple| visited.push(couple)).expect("as above");
            assert_eq!(visited, couples, "{simd}, visited");
            assert_eq!(order.get_or_insert_with(|| couples.clone()), &couples, "{simd}: the order");
        }
    }
}

fuzz_target!(|bytes: &[u8]| check::<RowsEqualsDirect>(bytes));
