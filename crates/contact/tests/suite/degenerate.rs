//! Extreme inputs: each gives the exact answer or a typed error with the problem, its place and the limit.

use fdem_contact::{Couple, Detector, Direct, Elements, Engine, Error, Nbs, Search};

use crate::ascending;

#[test]
fn no_elements_and_one_element_have_no_couples() {
    let none: [[f64; 3]; 0] = [];
    assert_eq!(fdem_contact::couples(&none, &[]), Ok(vec![]));
    assert_eq!(Nbs::new().count(&Elements::spheres(&none, 1.0).unwrap()), Ok(0));
    assert_eq!(Nbs::new().count(&Elements::spheres(&[[1.0, 2.0, 3.0]], 1.0).unwrap()), Ok(0));
}

#[test]
fn nan_and_infinity_name_the_element_and_the_axis() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut centres = vec![[0.0, 0.0, 0.0]; 5];
        centres[3][1] = value;
        let error = Elements::spheres(&centres, 1.0).unwrap_err();
        assert!(matches!(error, Error::NonFiniteCoordinate { index: 3, axis: 1, .. }), "{error:?}");
        assert!(error.to_string().contains("element 3: coordinate y"), "{error}");

        let error = Elements::boxes(&[[0.0; 3]; 5], &centres).unwrap_err();
        assert!(matches!(error, Error::NonFiniteCoordinate { index: 3, axis: 1, .. }), "{error:?}");
    }
}

#[test]
fn coordinates_whose_squares_overflow_are_refused() {
    let error = Elements::spheres(&[[0.0_f32], [1e19]], 1.0).unwrap_err();
    assert!(matches!(error, Error::CoordinateTooLarge { index: 1, axis: 0, .. }), "{error:?}");
    let error = Elements::spheres(&[[-1e151_f64]], 1.0).unwrap_err();
    assert!(matches!(error, Error::CoordinateTooLarge { index: 0, axis: 0, .. }), "{error:?}");
}

#[test]
fn bad_radii_name_the_element() {
    let centres = [[0.0, 0.0]; 3];
    for value in [-1.0, f64::NAN, f64::INFINITY, 1e300, -f64::MIN_POSITIVE] {
        let error = Elements::spheres_with_radii(&centres, &[1.0, value, 1.0]).unwrap_err();
        assert!(matches!(error, Error::InvalidRadius { index: Some(1), .. }), "{error:?}");
        let error = Elements::spheres(&centres, value).unwrap_err();
        assert!(matches!(error, Error::InvalidRadius { index: None, .. }), "{error:?}");
        let error = Elements::spheres(&centres, 1.0).unwrap().with_tolerance(value).unwrap_err();
        assert!(matches!(error, Error::InvalidTolerance { .. }), "{error:?}");
    }
}

#[test]
fn a_bad_cutoff_is_named_as_it_was_given() {
    for (value, text) in [(-3.0, "-3"), (1e300, "1e300"), (f64::NAN, "NaN")] {
        let error = Elements::points(&[[0.0]], value).unwrap_err();
        assert!(matches!(error, Error::InvalidCutoff { .. }), "{error:?}");
        assert!(error.to_string().starts_with(&format!("cut-off {text} is not")), "{error}");
    }
}

/// The error concerns the caller's domain, not an element.
#[test]
fn a_domain_that_is_set_too_wide_blames_no_element() {
    let elements = Elements::points(&[[0.0], [1.0]], 1.0).unwrap();
    let error = Nbs::new().with_domain([[0.0, 1e12]]).count(&elements).unwrap_err();
    assert!(matches!(error, Error::DomainTooWide { stretched_by: None, .. }), "{error:?}");
    assert_eq!(error.element(), None);
}

#[test]
fn lengths_that_differ_and_inverted_boxes_are_refused() {
    let centres = [[0.0, 0.0]; 3];
    let error = Elements::spheres_with_radii(&centres, &[1.0; 2]).unwrap_err();
    assert_eq!(error, Error::LengthMismatch { what: "radii", expected: 3, found: 2 });
    let error = Elements::boxes(&centres, &[[1.0, 1.0]; 2]).unwrap_err();
    assert_eq!(error, Error::LengthMismatch { what: "maximum corners", expected: 3, found: 2 });
    let error = Elements::boxes(&centres, &[[1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]).unwrap_err();
    assert_eq!(error, Error::InvertedBox { index: 1, axis: 1, min: 0.0, max: -1.0 });
}

#[test]
fn points_touch_what_covers_them_and_each_other_where_they_coincide() {
    let centres = [[0.0, 0.0], [0.5, 0.0], [2.0, 2.0], [2.0, 2.0]];
    let elements = Elements::spheres_with_radii(&centres, &[1.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(ascending(Nbs::new(), &elements), [Couple::new(0, 1), Couple::new(2, 3)]);
    let elements = Elements::spheres(&centres, 0.0).unwrap();
    assert_eq!(ascending(Nbs::new(), &elements), [Couple::new(2, 3)]);
}

#[test]
fn one_element_that_covers_everything() {
    let mut centres: Vec<[f64; 2]> = (0..500).map(|k| [f64::from(k % 25), f64::from(k / 25)]).collect();
    centres.push([12.0, 10.0]);
    let mut radii = vec![0.5; 500];
    radii.push(100.0);
    let elements = Elements::spheres_with_radii(&centres, &radii).unwrap();
    let couples = ascending(Nbs::new(), &elements);
    assert_eq!(couples, ascending(Direct, &elements));
    assert_eq!(couples.iter().filter(|couple| couple.j == 500).count(), 500);
}

#[test]
fn a_domain_too_wide_says_how_wide_who_and_what_instead() {
    let mut centres: Vec<[f64; 3]> = (0..200).map(|k| [f64::from(k), 0.0, 0.0]).collect();
    centres[77][2] = 1e12;
    let elements = Elements::points(&centres, 1.0).unwrap();
    let mut visited = 0;
    let error = Nbs::new().for_each(&elements, |_| visited += 1).unwrap_err();
    assert_eq!(visited, 0);
    let Error::DomainTooWide { axis: 2, stretched_by, .. } = error else { panic!("{error:?}") };
    assert_eq!(stretched_by, Some((77, 1e12)));
    assert_eq!(error.element(), Some(77));
    let message = error.to_string();
    for part in ["along z", "Element 77", "1e12", "134217728", "Engine::Rows", "with_max_heads"] {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }

    // Auto chooses another engine instead, and says so.
    let mut detector = Detector::new();
    let plan = detector.plan(&elements).unwrap();
    assert_eq!(plan.engine, Engine::Rows);
    assert!(plan.reason.contains("domain"), "{}", plan.reason);
    assert_eq!(detector.count(&elements), Ok(197)); // the chain is cut twice
}

#[test]
fn the_bound_on_heads_is_the_callers() {
    let centres = [[0.0, 0.0], [999.5, 0.0]];
    let elements = Elements::points(&centres, 1.0).unwrap();
    // 1,000 cells along x in two sets, and one cell along y in one set.
    assert_eq!(Nbs::new().with_max_heads(2001).count(&elements), Ok(0));
    let error = Nbs::new().with_max_heads(2000).count(&elements).unwrap_err();
    assert!(matches!(error, Error::DomainTooWide { heads, limit: 2000, .. } if heads == 2001.0), "{error:?}");
}

#[test]
fn a_domain_that_is_set_must_hold_the_elements() {
    let centres = [[1.0, 1.0], [2.0, 1.0], [2.5, 7.0]];
    let elements = Elements::points(&centres, 1.0).unwrap();
    assert_eq!(Nbs::new().with_domain([[0.0, 10.0]; 2]).count(&elements), Ok(1));
    let error = Nbs::new().with_domain([[0.0, 10.0], [0.0, 5.0]]).count(&elements).unwrap_err();
    assert_eq!(error, Error::OutsideDomain { index: 2, axis: 1, value: 7.0, domain: [0.0, 5.0] });
    for domain in [[f64::NAN, 1.0], [1.0, 0.0], [0.0, f64::INFINITY]] {
        let error = Nbs::new().with_domain([domain; 2]).count(&elements).unwrap_err();
        assert!(matches!(error, Error::InvalidDomain { axis: 0, .. }), "{error:?}");
    }
}

/// Lattices far from the origin: only differences of coordinates matter.
#[test]
fn far_from_the_origin_touching_neighbours_are_found() {
    for offset in [1e6, 1e9, 1e12, -1e12] {
        let centres: Vec<[f64; 2]> =
            (0..400).map(|k| [offset + f64::from(k % 20), offset + f64::from(k / 20)]).collect();
        let elements = Elements::points(&centres, 1.0).unwrap();
        assert_eq!(Nbs::new().count(&elements), Ok(2 * 20 * 19), "offset {offset}");
    }
}

/// The rounding of `max + tolerance` exceeds the width of the boxes; NBS must find the same couples.
#[test]
fn boxes_far_from_the_origin_with_a_small_tolerance() {
    let step = 1e12_f64.next_up() - 1e12;
    let min: Vec<[f64; 1]> = (0..50).map(|k| [1e12 + f64::from(k) * step]).collect();
    for tolerance in [0.0, step / 4.0, step / 2.0, 0.75 * step, step] {
        let elements = Elements::boxes(&min, &min).unwrap().with_tolerance(tolerance).unwrap();
        assert_eq!(ascending(Nbs::new(), &elements), ascending(Direct, &elements), "tolerance {tolerance:e}");
    }
}

/// After a visitor has panicked, the same search still gives the right answer.
#[test]
fn a_panic_in_the_visitor_leaves_a_usable_search() {
    let centres: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k % 10), f64::from(k / 10)]).collect();
    let elements = Elements::points(&centres, 1.0).unwrap();
    let mut nbs = Nbs::new();
    let search = std::panic::AssertUnwindSafe(|| nbs.for_each(&elements, |_| panic!("visitor")));
    assert!(std::panic::catch_unwind(search).is_err());
    assert_eq!(nbs.count(&elements), Ok(180));
}

/// Searches of different sizes and domains in the same memory do not affect each other.
#[test]
fn memory_is_reused_without_a_trace() {
    let mut nbs = Nbs::new();
    for (n, width) in [(300, 30), (10, 3), (1000, 7), (0, 1), (500, 500), (300, 30)] {
        let centres: Vec<[f64; 2]> =
            (0..n).map(|k| [f64::from(k % width), f64::from(k / width) * 0.7]).collect();
        let elements = Elements::points(&centres, 1.0).unwrap();
        let mut couples = Vec::new();
        nbs.couples(&elements, &mut couples).unwrap();
        let mut fresh = Vec::new();
        Nbs::new().couples(&elements, &mut fresh).unwrap();
        assert_eq!(couples, fresh, "n = {n}, width = {width}: the order is a function of the input alone");
    }
}
