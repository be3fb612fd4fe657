//! Extreme numbers: coordinates of 1e12, more couples than 32 bits count, domains of 10^15 cells.

use fdem_contact::{Couple, Detector, Direct, Elements, Error, Nbs, Rows, Search, Simd};
use fdem_scenes::{Sizes, gas};

use crate::ascending;

const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

/// The couples by the definition of touching, one after the other.
fn by_hand<const D: usize>(elements: &Elements<'_, f64, D>) -> Vec<Couple> {
    let n = elements.len() as u32;
    let all = (0..n).flat_map(|i| (i + 1..n).map(move |j| Couple { i, j }));
    all.filter(|couple| elements.touch(couple.i as usize, couple.j as usize)).collect()
}

fn all_engines_agree<const D: usize>(elements: &Elements<'_, f64, D>, nbs: bool) {
    let expected = by_hand(elements);
    assert!(expected.len() > 500, "{} couples are too few to tell", expected.len());
    assert_eq!(ascending(Direct, elements), expected);
    assert_eq!(ascending(Detector::new(), elements), expected);
    for simd in Simd::available() {
        assert_eq!(ascending(Rows::new().with_simd(simd).unwrap(), elements), expected, "{simd}");
    }
    if nbs {
        assert_eq!(ascending(Nbs::new(), elements), expected);
    } else {
        let error = Nbs::new().count(elements).unwrap_err();
        assert!(matches!(error, Error::DomainTooWide { .. }), "{error:?}");
    }
}

fn far_away<const D: usize>(places: &[[f64; D]], nbs: bool) {
    let cloud = gas::<D>(1500, 3, 6.0, EQUAL).unwrap();
    let put = |(k, centre): (usize, &[f64; D])| {
        let place = places[k / 100 % places.len()];
        std::array::from_fn(|axis| centre[axis] + place[axis])
    };
    let centres: Vec<[f64; D]> = cloud.centres.iter().enumerate().map(put).collect();
    all_engines_agree(&Elements::points(&centres, 1.0).unwrap(), nbs);
    let radii: Vec<f64> = (0..1500).map(|k| 0.5 + f64::from(k % 7) / 64.0).collect();
    let spheres = Elements::spheres_with_radii(&centres, &radii).unwrap();
    all_engines_agree(&spheres.with_tolerance(1e-4).unwrap(), nbs);
    let corners: Vec<[f64; D]> = centres.iter().map(|centre| centre.map(|x| x + 1.0)).collect();
    all_engines_agree(&Elements::boxes(&centres, &corners).unwrap(), nbs);
}

/// Coordinates have 13 bits left for a diameter. These bits decide which elements touch, and every engine
/// takes the same decision.
#[test]
fn coordinates_of_1e12_with_diameters_of_1_are_exact() {
    far_away(&[[1e12, -1e12]], true);
    far_away(&[[-1e12, 1e12, 1e12]], true);
    // Some elements here and some far away: lists of 10^12 cells are refused, but rows are not made of cells.
    far_away(&[[0.0, 0.0], [1e12, -1e12]], false);
    far_away(&[[1e12, 1e12, -1e12], [0.0, -1e12, 1e12]], false);
}

/// 100,000 points in one place: more couples than 32 bits count.
#[test]
fn more_than_2_to_the_32_couples_are_counted() {
    let n = 100_000_u64;
    let points = vec![[1.0_f32, 2.0]; n as usize];
    let elements = Elements::points(&points, 0.5).unwrap();
    assert_eq!(Rows::new().count(&elements), Ok(n * (n - 1) / 2));
    assert!(n * (n - 1) / 2 > 1 << 32);
}

/// The memory of the engine does not grow with the domain.
#[test]
fn a_wide_domain_takes_no_more_memory() {
    const N: usize = 1_000_000;
    let dense = gas::<3>(N, 1, 12.0, EQUAL).unwrap().centres;
    let per_element = |centres: &[[f64; 3]], cells: f64| {
        let elements = Elements::points(centres, 1.0).unwrap();
        let mut rows = Rows::new();
        let found: f64 = rows.plan(&elements).cells().iter().map(|&cells| cells as f64).product();
        assert!(found > cells, "{found} cells");
        rows.count(&elements).unwrap();
        rows.bytes() as f64 / N as f64
    };
    let packed = per_element(&dense, 1e5);
    assert!(packed < 36.0, "{packed} bytes per element");

    let mut outlier = dense.clone();
    outlier[N / 3] = [1e9, -1e9, 1e9];
    let with_outlier = per_element(&outlier, 1e26);
    assert!(
        with_outlier < packed + 1.0,
        "one element far away: {with_outlier} bytes per element, {packed} before"
    );

    // Each element has its own row: two entries for its start, and the room in which starts were collected.
    let spread: Vec<[f64; 3]> = dense.iter().map(|centre| centre.map(|x| x * 20_000.0)).collect();
    let far = per_element(&spread, 1e15);
    assert!(far < 48.0 && far < packed + 16.0, "spread: {far} bytes per element, {packed} when packed");
}
