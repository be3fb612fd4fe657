//! Compressed rows equal a map of sets, for any order of the couples.

use std::collections::BTreeMap;

use fdem_contact::{Couple, Csr, Detector, Direct, Elements, Error, PeriodicCouple};
use proptest::prelude::*;

/// The neighbours of each element in ascending order, repeats included.
fn rows(elements: usize, couples: &[Couple], full: bool) -> Vec<Vec<u32>> {
    let mut map: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for couple in couples {
        map.entry(couple.i).or_default().push(couple.j);
        if full {
            map.entry(couple.j).or_default().push(couple.i);
        }
    }
    for row in map.values_mut() {
        row.sort_unstable();
    }
    (0..elements as u32).map(|element| map.remove(&element).unwrap_or_default()).collect()
}

fn check(csr: &Csr, elements: usize, couples: &[Couple], full: bool) {
    let expected = rows(elements, couples, full);
    assert_eq!(csr.len(), elements);
    assert_eq!(csr.offsets().len(), elements + 1);
    assert_eq!(csr.neighbours().len(), if full { 2 * couples.len() } else { couples.len() });
    for (element, row) in expected.iter().enumerate() {
        assert_eq!(csr.neighbours_of(element), row, "element {element}");
        assert_eq!(csr.degree(element), row.len());
    }
    assert_eq!(csr.neighbours(), expected.concat());
}

/// Up to 40 elements, with couples in any order and some of them twice, followed by up to 20 elements without
/// couples.
fn list() -> impl Strategy<Value = (usize, Vec<Couple>)> {
    (2..40_u32, 0..20_usize).prop_flat_map(|(named, more)| {
        let couple = (0..named, 0..named - 1)
            .prop_map(|(a, b)| if b < a { Couple::new(b, a) } else { Couple::new(a, b + 1) });
        (Just(named as usize + more), prop::collection::vec(couple, 0..200))
    })
}

proptest! {
    /// One `Csr` is filled repeatedly; an earlier filling must have no effect.
    #[test]
    fn equals_a_map_of_sets(lists in prop::collection::vec(list(), 1..4)) {
        let mut csr = Csr::new();
        for (elements, couples) in &lists {
            csr.fill_half(*elements, couples).unwrap();
            check(&csr, *elements, couples, false);
            csr.fill_full(*elements, couples).unwrap();
            check(&csr, *elements, couples, true);
        }
    }

    #[test]
    fn the_order_of_the_couples_does_not_matter((elements, couples) in list()) {
        let mut reversed = couples.clone();
        reversed.reverse();
        let (mut a, mut b) = (Csr::new(), Csr::new());
        a.fill_full(elements, &couples).unwrap();
        b.fill_full(elements, &reversed).unwrap();
        prop_assert_eq!((a.offsets(), a.neighbours()), (b.offsets(), b.neighbours()));
    }

    #[test]
    fn full_is_half_and_its_transpose((elements, couples) in list()) {
        let (mut half, mut full) = (Csr::new(), Csr::new());
        half.fill_half(elements, &couples).unwrap();
        full.fill_full(elements, &couples).unwrap();
        let mut both: Vec<Vec<u32>> = vec![Vec::new(); elements];
        for i in 0..elements {
            for &j in half.neighbours_of(i) {
                both[i].push(j);
                both[j as usize].push(i as u32);
            }
        }
        for (element, row) in both.iter_mut().enumerate() {
            row.sort_unstable();
            prop_assert_eq!(full.neighbours_of(element), &row[..]);
        }
    }

    /// The value of an entry is that from the element to its neighbour; values come in the order of the
    /// entries.
    #[test]
    fn values_belong_to_their_entries((elements, couples) in list()) {
        let mut csr = Csr::new();
        for full in [false, true] {
            let mut calls = 0;
            let value = |element: usize, neighbour: usize| {
                calls += 1;
                (calls, element, neighbour)
            };
            if full {
                csr.fill_full_with(elements, &couples, value).unwrap();
            } else {
                csr.fill_half_with(elements, &couples, value).unwrap();
            }
            prop_assert_eq!(csr.values().len(), csr.neighbours().len());
            let mut expected = 0;
            for element in 0..elements {
                for (&neighbour, &found) in csr.neighbours_of(element).iter().zip(csr.values_of(element)) {
                    expected += 1;
                    prop_assert_eq!(found, (expected, element, neighbour as usize));
                }
            }
        }
    }
}

#[test]
fn nothing_has_no_rows_and_loners_have_empty_ones() {
    let mut csr = Csr::new();
    assert!(csr.is_empty() && csr.offsets().is_empty());
    csr.fill_full(0, &[]).unwrap();
    assert!(csr.is_empty());
    assert_eq!(csr.offsets(), [0]);
    csr.fill_half(3, &[]).unwrap();
    assert_eq!(csr.offsets(), [0, 0, 0, 0]);
    assert_eq!(csr.neighbours_of(2), [0; 0]);
}

#[test]
fn a_couple_of_other_elements_is_refused_and_named() {
    let mut csr = Csr::new();
    csr.fill_full(2, &[Couple::new(0, 1)]).unwrap();
    for (i, j) in [(0, 3), (2, 2), (2, 1), (u32::MAX, u32::MAX)] {
        let couples = [Couple::new(0, 1), Couple { i, j }];
        let error = Error::MalformedCouple { index: 1, i, j, elements: 3 };
        assert_eq!(csr.fill_half(3, &couples), Err(error.clone()));
        assert!(csr.is_empty() && csr.neighbours().is_empty(), "nothing is left of an earlier filling");
        assert_eq!(csr.fill_full(3, &couples), Err(error.clone()));
        assert!(error.to_string().contains(&format!("couple 1 is ({i}, {j})")), "{error}");
    }
    csr.fill_half(3, &[Couple::new(0, 1)]).unwrap();
    assert_eq!(csr.offsets(), [0, 1, 1, 1]);
}

#[test]
fn rows_of_a_search_hold_what_touches() {
    let cloud = fdem_scenes::peers::gas(500, 7).unwrap();
    let elements = Elements::points(&cloud.centres, 1.0).unwrap();
    let couples = crate::ascending(Direct, &elements);
    let (mut csr, mut detector) = (Csr::new(), Detector::new());
    csr.find_half(&mut detector, &elements).unwrap();
    check(&csr, 500, &couples, false);
    csr.find_full(&mut detector, &elements).unwrap();
    check(&csr, 500, &couples, true);
    let held = csr.bytes();
    csr.find_full(&mut detector, &elements).unwrap();
    assert_eq!(csr.bytes(), held, "the memory is used again");
}

/// Couples of a periodic box: several images of one neighbour, and elements with their own images.
fn periodic_list() -> impl Strategy<Value = (usize, Vec<PeriodicCouple<2>>)> {
    (1..20_u32, 0..5_usize).prop_flat_map(|(named, more)| {
        let couple = (0..named, 0..named, prop::array::uniform2(-2..3_i32)).prop_map(|(a, b, shift)| {
            let shift = if a == b && shift <= [0, 0] { [-shift[0], 1 - shift[1].min(0)] } else { shift };
            PeriodicCouple { i: a.min(b), j: a.max(b), shift }
        });
        (Just(named as usize + more), prop::collection::vec(couple, 0..80))
    })
}

proptest! {
    /// The entries equal those of a sorted list, with the opposite shift from the other side; an earlier
    /// filling has no effect.
    #[test]
    fn periodic_rows_equal_a_sorted_list(lists in prop::collection::vec(periodic_list(), 1..4)) {
        let mut csr = Csr::new();
        for (elements, couples) in &lists {
            for full in [false, true] {
                let mut expected: Vec<(u32, u32, [i32; 2])> =
                    couples.iter().map(|couple| (couple.i, couple.j, couple.shift)).collect();
                if full {
                    expected.extend(couples.iter().map(|couple| (couple.j, couple.i, couple.shift.map(|s| -s))));
                    csr.fill_full_periodic(*elements, couples).unwrap();
                } else {
                    csr.fill_half_periodic(*elements, couples).unwrap();
                }
                expected.sort_unstable();
                let mut found = Vec::new();
                for element in 0..csr.len() {
                    let row = csr.neighbours_of(element).iter().zip(csr.values_of(element));
                    found.extend(row.map(|(&neighbour, &shift)| (element as u32, neighbour, shift)));
                }
                prop_assert_eq!(csr.len(), *elements);
                prop_assert_eq!(found, expected);
            }
        }
    }
}

#[test]
fn a_periodic_couple_in_another_form_is_refused() {
    let mut csr = Csr::new();
    let good = PeriodicCouple { i: 0, j: 1, shift: [-1] };
    csr.fill_full_periodic(2, &[good]).unwrap();
    for (i, j, shift) in [(1, 0, 1), (0, 2, 0), (1, 1, 0), (1, 1, -1)] {
        let couples = [good, PeriodicCouple { i, j, shift: [shift] }];
        let error = Error::MalformedCouple { index: 1, i, j, elements: 2 };
        assert_eq!(csr.fill_half_periodic(2, &couples), Err(error.clone()));
        assert_eq!(csr.fill_full_periodic(2, &couples), Err(error));
        assert!(csr.is_empty() && csr.neighbours().is_empty() && csr.values().is_empty());
    }
}
