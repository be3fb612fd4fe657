//! Laws that hold for any input.

use std::collections::BTreeSet;

use fdem_contact::{Couple, Direct, Elements, Error, Nbs, Search};
use proptest::prelude::*;

use crate::ascending;

/// Multiples of 2^-10 in a bounded range: differences and their squares are exact, so "touching" does not
/// depend on rounding.
fn exact() -> impl Strategy<Value = f64> {
    (-8 * 1024..8 * 1024_i32).prop_map(|k| f64::from(k) / 1024.0)
}

/// Coordinates on a coarse lattice, so that exact touching is common.
fn coarse() -> impl Strategy<Value = f64> {
    (-12..12_i32).prop_map(|k| f64::from(k) / 2.0)
}

fn centre() -> impl Strategy<Value = [f64; 3]> {
    prop_oneof![[exact(), exact(), exact()], [coarse(), coarse(), coarse()]]
}

fn sphere() -> impl Strategy<Value = ([f64; 3], f64)> {
    (centre(), (0..1024_i32).prop_map(|k| f64::from(k) / 512.0))
}

fn spheres() -> impl Strategy<Value = (Vec<[f64; 3]>, Vec<f64>)> {
    prop::collection::vec(sphere(), 0..60).prop_map(|spheres| spheres.into_iter().unzip())
}

fn nbs(centres: &[[f64; 3]], radii: &[f64], tolerance: f64) -> Vec<Couple> {
    let elements = Elements::spheres_with_radii(centres, radii).unwrap().with_tolerance(tolerance).unwrap();
    ascending(Nbs::new(), &elements)
}

proptest! {
    #![proptest_config(crate::cases(512))]

    #[test]
    fn equals_direct_and_repeats_nothing((centres, radii) in spheres(), tolerance in 0.0..0.5) {
        let elements = Elements::spheres_with_radii(&centres, &radii).unwrap().with_tolerance(tolerance).unwrap();
        let couples = ascending(Nbs::new(), &elements);
        prop_assert_eq!(&couples, &ascending(Direct, &elements));
        prop_assert!(couples.windows(2).all(|pair| pair[0] < pair[1]));
        prop_assert!(couples.iter().all(|couple| couple.i < couple.j));
    }

    /// Renumbering the elements renumbers the couples.
    #[test]
    fn renumbering(
        (spheres, order) in prop::collection::vec(sphere(), 0..60)
            .prop_flat_map(|spheres| {
                let order = Just((0..spheres.len()).collect::<Vec<_>>()).prop_shuffle();
                (Just(spheres), order)
            })
    ) {
        let (centres, radii): (Vec<_>, Vec<_>) = spheres.iter().copied().unzip();
        let (renumbered, their_radii): (Vec<_>, Vec<_>) = order.iter().map(|&k| spheres[k]).unzip();
        let expected: BTreeSet<Couple> = nbs(&centres, &radii, 0.0).into_iter().collect();
        let original = |k: u32| order[k as usize] as u32;
        let found: BTreeSet<Couple> = nbs(&renumbered, &their_radii, 0.0)
            .into_iter()
            .map(|couple| Couple::new(original(couple.i), original(couple.j)))
            .collect();
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn mirroring((centres, radii) in spheres(), axis in 0..3_usize) {
        let mirrored: Vec<_> = centres.iter().map(|centre| {
            let mut centre = *centre;
            centre[axis] = -centre[axis];
            centre
        }).collect();
        prop_assert_eq!(nbs(&mirrored, &radii, 0.0), nbs(&centres, &radii, 0.0));
    }

    /// Translation by whole steps of the lattice is exact in `f64`, so nothing may change. (Cells start at
    /// the lowest element, so any step is also a translation by whole cells.)
    #[test]
    fn translation((centres, radii) in spheres(), steps in [-1000..1000_i32, -1000..1000_i32, -1000..1000_i32]) {
        let moved: Vec<_> = centres.iter()
            .map(|centre| std::array::from_fn(|axis| centre[axis] + f64::from(steps[axis]) * 4.0))
            .collect();
        prop_assert_eq!(nbs(&moved, &radii, 0.0), nbs(&centres, &radii, 0.0));
    }

    #[test]
    fn a_larger_tolerance_never_loses_a_couple((centres, radii) in spheres(), a in 0.0..1.0, b in 0.0..1.0) {
        let fewer: BTreeSet<_> = nbs(&centres, &radii, f64::min(a, b)).into_iter().collect();
        let more: BTreeSet<_> = nbs(&centres, &radii, f64::max(a, b)).into_iter().collect();
        prop_assert!(fewer.is_subset(&more));
    }

    /// Any scale: from squares that underflow to squares that nearly overflow.
    #[test]
    fn any_scale_equals_direct(
        spheres in prop::collection::vec(([-40.0..40.0, -40.0..40.0], 0.0..4.0), 0..40),
        exponent in -1000..490_i32,
        tolerance in prop_oneof![Just(0.0), 0.0..1.0],
    ) {
        let scale = 2.0_f64.powi(exponent);
        let centres: Vec<[f64; 2]> = spheres.iter().map(|(centre, _)| centre.map(|x: f64| x * scale)).collect();
        let radii: Vec<f64> = spheres.iter().map(|(_, radius): &(_, f64)| radius * scale).collect();
        let elements = Elements::spheres_with_radii(&centres, &radii).unwrap();
        let elements = elements.with_tolerance(tolerance * scale).unwrap();
        prop_assert_eq!(ascending(Nbs::new(), &elements), ascending(Direct, &elements));
    }

    /// Any finite `f32`: the answer of `Direct`, or a typed error; no panic, and no endless loop.
    #[test]
    fn arbitrary_floats_give_the_answer_or_an_error(
        centres in prop::collection::vec([any::<f32>(), any::<f32>()], 0..12),
        radius in any::<f32>(),
    ) {
        let Ok(elements) = Elements::spheres(&centres, radius) else { return Ok(()) };
        let mut couples = Vec::new();
        match Nbs::new().with_max_heads(1 << 20).couples(&elements, &mut couples) {
            Ok(()) => {
                couples.sort_unstable();
                prop_assert_eq!(couples, ascending(Direct, &elements));
            }
            Err(error) => prop_assert!(matches!(error, Error::DomainTooWide { .. }), "{error:?}"),
        }
    }

    /// Boxes of any aspect ratio, including flat ones and points.
    #[test]
    fn boxes_equal_direct(boxes in prop::collection::vec((centre(), centre()), 0..60), tolerance in 0.0..0.5) {
        let corner = |pick: fn(f64, f64) -> f64| -> Vec<[f64; 3]> {
            boxes.iter().map(|(a, b)| std::array::from_fn(|axis| pick(a[axis], b[axis]))).collect()
        };
        let (min, max) = (corner(f64::min), corner(f64::max));
        let elements = Elements::boxes(&min, &max).unwrap().with_tolerance(tolerance).unwrap();
        prop_assert_eq!(ascending(Nbs::new(), &elements), ascending(Direct, &elements));
    }
}
