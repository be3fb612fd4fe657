//! `CGrid` finds the couples of all-against-all, for any sizes and any domain, and again in the same order
//! when it is reused.

#![no_main]

use fdem_contact::{CGrid, Elements, Search};
use fdem_fuzz::{Law, Number, ascending, check, expected};
use libfuzzer_sys::fuzz_target;

struct CGridEqualsDirect;

impl Law for CGridEqualsDirect {
    fn check<T: Number, const D: usize>(elements: &Elements<'_, T, D>) {
        let expected = expected(elements);
        let mut search = CGrid::new();
        let (mut couples, mut again) = (Vec::new(), Vec::new());
        search.couples(elements, &mut couples).expect("the C-grid takes any domain");
        assert_eq!(ascending(&couples), expected);
        search.couples(elements, &mut again).expect("the C-grid takes any domain");
        assert_eq!(again, couples, "the order");
        assert_eq!(search.count(elements), Ok(expected.len() as u64), "counted");
    }
}

fuzz_target!(|bytes: &[u8]| check::<CGridEqualsDirect>(bytes));
