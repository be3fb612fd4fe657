//! `Nbs` finds the couples of all-against-all, or returns the error that the domain is too wide for its
//! limit.

#![no_main]

use fdem_contact::{Elements, Error, Nbs, Search};
use fdem_fuzz::{Law, Number, ascending, check, expected};
use libfuzzer_sys::fuzz_target;

/// A small limit: couples and errors are both common, and searches are short.
const MAX_HEADS: usize = 4096;

struct NbsEqualsDirect;

impl Law for NbsEqualsDirect {
    fn check<T: Number, const D: usize>(elements: &Elements<'_, T, D>) {
        let mut nbs = Nbs::new().with_max_heads(MAX_HEADS);
        let mut couples = Vec::new();
        match nbs.couples(elements, &mut couples) {
            Ok(()) => assert_eq!(ascending(&couples), expected(elements)),
            Err(Error::DomainTooWide { heads, limit, .. }) => {
                assert_eq!(limit, MAX_HEADS);
                assert!(heads > limit as f64, "{heads} heads were refused");
                assert!(couples.is_empty());
                return;
            }
            Err(error) => panic!("{error}"),
        }
        let mut again = Vec::new();
        nbs.couples(elements, &mut again).expect("what was searched once");
        assert_eq!(again, couples, "the same memory, the same order");
    }
}

fuzz_target!(|bytes: &[u8]| check::<NbsEqualsDirect>(bytes));
