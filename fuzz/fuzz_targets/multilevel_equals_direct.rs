//! `Multilevel`, with its own choice of levels and with any others, finds the couples of all-against-all, in
//! one order for every set of vector instructions.

#![no_main]

use fdem_contact::{Elements, Multilevel, Search, Simd};
use fdem_fuzz::{Law, Number, ascending, check, expected};
use libfuzzer_sys::fuzz_target;

struct MultilevelEqualsDirect;

impl Law for MultilevelEqualsDirect {
    fn check<T: Number, const D: usize>(elements: &Elements<'_, T, D>) {
        let expected = expected(elements);
        for limits in [None, Some(&[0.5, 1.0, 2.0][..])] {
            let mut order = None;
            for (simd, threads) in Simd::available().into_iter().map(|simd| (simd, 1)).chain([(Simd::best(), 2)]) {
                let search = Multilevel::new().with_simd(simd).expect("the level is available");
                let mut search = search.with_threads(threads).expect("two threads can be had");
                if let Some(limits) = limits {
                    search = search.with_limits(limits);
                }
                let mut couples = Vec::new();
                search.couples(elements, &mut couples).expect("levels take any domain");
                assert_eq!(ascending(&couples), expected, "{simd}, {threads} threads, {limits:?}");
                assert_eq!(search.count(elements), Ok(expected.len() as u64), "{simd}, counted");
                assert_eq!(order.get_or_insert_with(|| couples.clone()), &couples, "{simd}: the order");
            }
        }
    }
}

fuzz_target!(|bytes: &[u8]| check::<MultilevelEqualsDirect>(bytes));
