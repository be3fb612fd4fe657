//! The C-grid equals all-against-all in any dimension, for bodies that span any number of cells; its memory
//! and its work are bounded.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use fdem_contact::{
    CGrid, Couple, Detector, Direct, Elements, Engine, Filter, GroupMatrix, Level, Multilevel, PeriodicBox,
    PeriodicCouple, PeriodicSearch, Real, Search, verify,
};
use fdem_scenes::random::Random;
use fdem_scenes::{Cloud, Sizes, clusters, gas, jittered_lattice, lattice};
use proptest::prelude::*;

use crate::ascending;
use crate::oracle::FromF64;

/// Compares with all-against-all, and returns the number of couples.
fn equals_direct<T: Real, const D: usize>(what: &str, elements: &Elements<'_, T, D>) -> usize {
    let mut expected = Vec::new();
    Direct.couples(elements, &mut expected).unwrap();
    let found = ascending(CGrid::new(), elements);
    assert!(found == expected, "{what}, D = {D}: {} couples instead of {}", found.len(), expected.len());
    let levels = CGrid::new().levels(elements);
    assert_eq!(levels.iter().map(|level| level.elements).sum::<usize>(), elements.len(), "{what}");
    expected.len()
}

/// Spheres of one radius, spheres with radii, and boxes that are longer along one axis, with and without
/// tolerance.
fn all_shapes<T: FromF64, const D: usize>(what: &str, cloud: &Cloud<D>) -> usize {
    let centres: Vec<[T; D]> = cloud.centres.iter().map(|centre| centre.map(T::from_f64)).collect();
    let radii: Vec<T> = cloud.radii.iter().copied().map(T::from_f64).collect();
    let corner = |side: f64, long: f64| -> Vec<[T; D]> {
        let corners = cloud.centres.iter().zip(&cloud.radii).enumerate();
        let half = |k: usize, axis: usize| if axis == k % D { long } else { 0.5 };
        corners
            .map(|(k, (centre, radius))| {
                std::array::from_fn(|axis| T::from_f64(centre[axis] + side * radius * half(k, axis)))
            })
            .collect()
    };
    let mut couples = 0;
    for tolerance in [0.0, 0.05, 1.5].map(T::from_f64) {
        let radius = radii.first().copied().unwrap_or(T::HALF);
        let equal = Elements::spheres(&centres, radius).unwrap().with_tolerance(tolerance).unwrap();
        couples += equals_direct(&format!("{what}, equal"), &equal);
        let spheres = Elements::spheres_with_radii(&centres, &radii).unwrap();
        couples += equals_direct(&format!("{what}, radii"), &spheres.with_tolerance(tolerance).unwrap());
        for long in [2.0, 50.0] {
            let (min, max) = (corner(-1.0, long), corner(1.0, long));
            let boxes = Elements::boxes(&min, &max).unwrap().with_tolerance(tolerance).unwrap();
            couples += equals_direct(&format!("{what}, boxes 1:{}", 2.0 * long), &boxes);
        }
    }
    couples
}

const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

fn power_law(ratio: f64) -> Sizes {
    Sizes::PowerLaw { min: 0.5, max: 0.5 * ratio, exponent: -2.0 }
}

fn all_scenes<T: FromF64, const D: usize>() {
    for n in [0, 1, 2, 10, 250] {
        let found = all_shapes::<T, D>("uniform", &gas::<D>(n, 1, 8.0, EQUAL).unwrap());
        assert!(n < 250 || found > 250, "the scene has couples to lose: {found}");
        // The spacing is exactly the diameter: all neighbours touch, to the last bit, at the faces of cells.
        let found = all_shapes::<T, D>("lattice", &lattice::<D>(n, 1.0, 0.5).unwrap());
        assert!(n < 10 || found >= n, "neighbours on the lattice touch");
    }
    for ratio in [10.0, 1000.0] {
        let cloud = gas::<D>(250, 3, 4.0, power_law(ratio)).unwrap();
        assert!(all_shapes::<T, D>(&format!("ratio {ratio}"), &cloud) > 250);
    }
    all_shapes::<T, D>("jittered", &jittered_lattice::<D>(150, 4, 1.0, 0.3, EQUAL).unwrap());
    all_shapes::<T, D>("clusters", &clusters::<D>(150, 5, 30, 1000.0, 6.0, EQUAL).unwrap());
    let mut shifted = gas::<D>(150, 6, 8.0, EQUAL).unwrap();
    shifted.centres.iter_mut().flatten().for_each(|x| *x -= 1234.5);
    all_shapes::<T, D>("negative coordinates", &shifted);
}

for_all_types! { all_scenes }

/// More dimensions than the lists are nested in.
#[test]
fn twenty_dimensions() {
    let mut random = Random::new(1);
    let centres: Vec<[f64; 20]> = (0..200).map(|_| std::array::from_fn(|_| random.uniform())).collect();
    let found = equals_direct("points", &Elements::points(&centres, 1.5).unwrap());
    assert!(found > 100 && found < 19_900, "{found}");
}

#[test]
fn bodies_that_cover_everything() {
    let mut cloud = gas::<3>(500, 2, 3.0, power_law(4.0)).unwrap();
    cloud.radii[123] = 1e3;
    assert!(all_shapes::<f64, 3>("one covers all", &cloud) > 4 * 499);
    cloud.radii[7] = 1e6;
    cloud.centres[7] = [1e6, 0.0, 0.0];
    all_shapes::<f64, 3>("two cover all", &cloud);
    all_shapes::<f32, 3>("two cover all", &cloud);
}

#[test]
fn thousands_of_coincident_bodies() {
    let centres = vec![[-3.0, 4.0]; 2000];
    let all = 2000 * 1999 / 2;
    assert_eq!(equals_direct("points", &Elements::points(&centres, 0.0).unwrap()), all);
    assert_eq!(equals_direct("discs", &Elements::spheres(&centres, 1.0).unwrap()), all);
    assert_eq!(equals_direct("flat", &Elements::boxes(&centres, &centres).unwrap()), all);
    let far: Vec<_> = (0..2000).map(|k| [-3.0 + f64::from(k), 4.0]).collect();
    assert_eq!(equals_direct("from one corner", &Elements::boxes(&centres, &far).unwrap()), all);
}

#[test]
fn bodies_without_size() {
    let mut cloud = gas::<3>(600, 4, 6.0, power_law(20.0)).unwrap();
    cloud.radii.iter_mut().step_by(3).for_each(|radius| *radius = 0.0);
    all_shapes::<f64, 3>("a third are points", &cloud);
    cloud.radii.iter_mut().step_by(5).for_each(|radius| *radius = 1e-320);
    all_shapes::<f64, 3>("some are nearly points", &cloud);
    cloud.radii.fill(0.0);
    cloud.centres[5] = cloud.centres[500];
    assert_eq!(
        equals_direct("points", &Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap()),
        1
    );
}

/// Sizes below the normal numbers. A search for cells that fit them once multiplied such a number by 1.25
/// forever.
#[test]
fn bodies_smaller_than_normal_numbers() {
    let centres = |scale: f64| -> Vec<[f64; 3]> {
        (0..40)
            .map(|k| [f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)].map(|x| x * scale))
            .collect()
    };
    for size in [5e-324, 4e-323, 1e-320, f64::MIN_POSITIVE] {
        for scale in [size, 1.0] {
            let spheres = centres(scale);
            let elements = Elements::spheres(&spheres, size).unwrap();
            equals_direct(&format!("radius {size:e}, {scale:e} apart"), &elements);
            let far: Vec<_> = spheres.iter().map(|low| low.map(|x| x + size)).collect();
            let elements = Elements::boxes(&spheres, &far).unwrap();
            equals_direct(&format!("edges {size:e}, {scale:e} apart"), &elements);
        }
    }
}

#[test]
fn bodies_on_the_faces_of_cells() {
    let centres: Vec<[f64; 2]> = (0..900).map(|k| [f64::from(k % 30), f64::from(k / 30)]).collect();
    let radii: Vec<f64> = (0..900).map(|k| [0.5, 0.25, 1.0, 4.0, 0.0][k * 7 % 41 % 5]).collect();
    all_shapes::<f64, 2>("a lattice", &Cloud { centres, radii });
    let min: Vec<[f64; 2]> = (0..900).map(|k| [f64::from(k % 30), f64::from(k / 30)]).collect();
    for edge in [0.0, 1.0, 2.0, 7.0] {
        let max: Vec<_> = min.iter().map(|corner| corner.map(|x| x + edge)).collect();
        let elements = Elements::boxes(&min, &max).unwrap();
        // Closed boxes of `e` steps touch where their corners differ by at most `e` on both axes.
        let close = (1..=edge as usize).map(|step| 30 - step).sum::<usize>();
        let expected = 2 * 30 * close + 2 * close * close;
        assert_eq!(equals_direct("boxes", &elements), expected, "edge {edge}");
    }
}

#[test]
fn far_apart_and_large() {
    let mut cloud = gas::<2>(800, 5, 3.0, power_law(10.0)).unwrap();
    cloud.centres.iter_mut().step_by(50).for_each(|centre| centre[0] += 1e12);
    cloud.centres.iter_mut().skip(1).step_by(50).for_each(|centre| centre[1] -= 1e12);
    let spheres = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    assert!(equals_direct("clusters 1e12 apart", &spheres) > 400);
    for exponent in [400, -400] {
        let scale = 2.0_f64.powi(exponent);
        let centres: Vec<_> = cloud.centres.iter().map(|centre| centre.map(|x| x * scale)).collect();
        let radii: Vec<_> = cloud.radii.iter().map(|radius| radius * scale).collect();
        equals_direct("scaled", &Elements::spheres_with_radii(&centres, &radii).unwrap());
    }
    // Sizes from the smallest to the largest lengths, all together.
    let radii: Vec<f64> = (0..800).map(|k| 2.0_f64.powi(k - 400)).collect();
    equals_direct("all magnitudes", &Elements::spheres_with_radii(&cloud.centres, &radii).unwrap());
    let ends = [[-f64::MAX_MAGNITUDE; 2], [f64::MAX_MAGNITUDE; 2], [0.0; 2]];
    let radii = [f64::MAX_MAGNITUDE, 0.0, 1e-300];
    equals_direct("the ends", &Elements::spheres_with_radii(&ends, &radii).unwrap());
}

/// Distances within a unit in the last place of the limit: mapping boxes to cells must not lose couples that
/// the comparison accepts.
#[test]
fn distances_at_the_limit() {
    let mut touching = 0;
    for k in 1..400 {
        let reach = 0.1 + f64::from(k) / 1000.0;
        let at = f64::from(k) * 1e3 / 7.0;
        let mut centres = Vec::new();
        let mut x = at + 2.0 * reach;
        for _ in 0..12 {
            x = x.next_down();
        }
        for _ in 0..24 {
            centres.push([x, 1e-9]);
            x = x.next_up();
        }
        centres.push([at, 1e-9]);
        let count = centres.len();
        let found = ascending(CGrid::new(), &Elements::spheres(&centres, reach).unwrap());
        assert!(found == ascending(Direct, &Elements::spheres(&centres, reach).unwrap()), "reach {reach}");
        touching += found.iter().filter(|couple| couple.j as usize == count - 1).count();
    }
    assert!((100..399 * 24).contains(&touching), "some touch and some do not: {touching}");
}

fn rods(n: usize, seed: u64, room: f64) -> [Vec<[f64; 3]>; 2] {
    let mut random = Random::new(seed);
    let (mut min, mut max) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let corner: [f64; 3] = std::array::from_fn(|_| random.between(0.0, room));
        let mut edges = [1.0; 3];
        edges[random.below(3) as usize] = 100.0;
        min.push(corner);
        max.push(std::array::from_fn(|axis| corner[axis] + edges[axis]));
    }
    [min, max]
}

#[test]
fn thin_boxes_of_100_to_1() {
    let [min, max] = rods(2500, 9, 120.0);
    let elements = Elements::boxes(&min, &max).unwrap();
    assert!(equals_direct("rods", &elements) > 2500);
    let mut search = CGrid::new();
    search.count(&elements).unwrap();
    // All against all would be 1250 tests per element.
    assert!(search.tests() < 150 * 2500, "{}", search.tests());
}

#[test]
fn filters_are_honoured() {
    let cloud = gas::<3>(1500, 11, 12.0, power_law(20.0)).unwrap();
    let bodies: Vec<u32> = (0..1500).map(|k| k % 3).collect();
    let categories: Vec<u32> = (0..1500).map(|k| 1 << (k % 4)).collect();
    let masks: Vec<u32> = (0..1500).map(|k| k * 7 % 16).collect();
    let groups: Vec<u32> = (0..1500).map(|k| k % 5).collect();
    let mut matrix = GroupMatrix::none(5).unwrap();
    matrix.set(0, 1, true).unwrap();
    matrix.set(2, 2, true).unwrap();
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let all = equals_direct("no filter", &elements);
    for filter in [
        Filter::bodies(&bodies),
        Filter::masks(&categories, &masks),
        Filter::groups(&groups, &matrix),
        Filter::groups(&groups, &matrix).with_bodies(&bodies),
    ] {
        let found = equals_direct("filter", &elements.with_filter(filter).unwrap());
        assert!(found > 10 && found < all, "{found} of {all}");
    }
}

/// Periodic boxes, compared with all images one by one.
#[test]
fn periodic_boxes() {
    let cloud = gas::<2>(300, 12, 6.0, power_law(20.0)).unwrap();
    let edge = cloud.centres.iter().flatten().fold(0.0, |edge, &x| f64::max(edge, x)) + 0.5;
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    for periodic in [[true, true], [true, false]] {
        let cell = PeriodicBox::orthogonal([0.0, 0.0], [edge, edge], periodic).unwrap();
        let mut found = Vec::new();
        PeriodicSearch::new().with_engine(Engine::CGrid).couples(&elements, &cell, &mut found).unwrap();
        found.sort_unstable();
        let mut direct: Vec<PeriodicCouple<2>> = Vec::new();
        PeriodicSearch::new().with_engine(Engine::Direct).couples(&elements, &cell, &mut direct).unwrap();
        direct.sort_unstable();
        assert!(found == direct, "{} couples instead of {}", found.len(), direct.len());
        assert!(found.iter().any(|couple| couple.shift != [0, 0]));

        // Makes the images by hand: all elements at nine (three) places.
        let steps = |axis: usize| if periodic[axis] { -1..=1 } else { 0..=0 };
        let places: Vec<[i32; 2]> = steps(0).flat_map(|x| steps(1).map(move |y| [x, y])).collect();
        let at = |place: &[i32; 2]| -> Vec<[f64; 2]> {
            let moved =
                |centre: &[f64; 2]| std::array::from_fn(|axis| centre[axis] + f64::from(place[axis]) * edge);
            cloud.centres.iter().map(moved).collect()
        };
        let centres: Vec<_> = places.iter().flat_map(at).collect();
        let radii = cloud.radii.repeat(places.len());
        let images = Elements::spheres_with_radii(&centres, &radii).unwrap();
        let home = places.iter().position(|place| *place == [0, 0]).unwrap();
        let of_home = ascending(CGrid::new(), &images).into_iter().filter(|couple| {
            let [i, j] = [couple.i, couple.j].map(|element| element as usize / 300);
            i == home || j == home
        });
        let (inside, across): (Vec<_>, Vec<_>) =
            of_home.partition(|couple| couple.i as usize / 300 == couple.j as usize / 300);
        let shifted = found.iter().filter(|couple| couple.shift != [0, 0]).count();
        // The box is so wide that no element is within reach of an image of an image. Each couple across a
        // face is seen from both sides.
        let far = found.iter().any(|couple| couple.shift.iter().any(|step| step.abs() > 1));
        assert!(!far);
        assert_eq!(inside.len(), found.len() - shifted);
        assert_eq!(across.len(), 2 * shifted);
    }
}

#[test]
fn a_detector_reports_levels_and_finds_the_same() {
    let cloud = gas::<3>(3000, 13, 6.0, power_law(100.0)).unwrap();
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let mut detector = Detector::new().with_engine(Engine::CGrid);
    let plan = detector.plan(&elements).unwrap();
    assert_eq!((plan.engine, plan.engine.name()), (Engine::CGrid, "cgrid"));
    assert_eq!(plan.levels, CGrid::new().levels(&elements));
    assert!(plan.levels.len() > 1);
    assert!(plan.levels.is_sorted_by(|one, two| one.cell_size < two.cell_size && one.largest < two.smallest));
    let mut order = Vec::new();
    detector.couples(&elements, &mut order).unwrap();
    let mut visited = Vec::new();
    CGrid::new().for_each(&elements, |couple| visited.push(couple)).unwrap();
    assert!(visited == order, "one order");
    assert_eq!(detector.count(&elements), Ok(order.len() as u64));
    order.sort_unstable();
    assert!(order == ascending(Direct, &elements));
    let explanation = detector.explain(&elements).unwrap();
    assert!(explanation.bytes >= bytes_of(&elements) && explanation.threads == 1);
    let text = explanation.to_string();
    assert!(text.starts_with("engine    cgrid: requested\n") && text.contains("\nlevel     "), "{text}");
}

fn bytes_of<const D: usize>(elements: &Elements<'_, f64, D>) -> usize {
    let mut search = CGrid::new();
    search.count(elements).unwrap();
    search.bytes()
}

/// Earlier searches, including one whose visitor panicked, have no effect.
#[test]
fn a_search_used_again_finds_what_a_new_one_finds() {
    let mut search = CGrid::<f64, 2>::new();
    for (n, ratio) in [(500, 30.0), (50, 1.0), (900, 3.0), (0, 1.0), (700, 1000.0)] {
        let cloud = gas::<2>(n, n as u64, 5.0, power_law(ratio)).unwrap();
        let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
        let (mut found, mut fresh) = (Vec::new(), Vec::new());
        search.couples(&elements, &mut found).unwrap();
        CGrid::new().couples(&elements, &mut fresh).unwrap();
        assert!(found == fresh, "n = {n}");
        assert!(fresh.is_empty() == (n == 0));
        let panicking = std::panic::AssertUnwindSafe(|| search.for_each(&elements, |_| panic!("on purpose")));
        assert_eq!(std::panic::catch_unwind(panicking).is_err(), n > 0);
    }
}

/// Memory is proportional to N for any domain: with 1e15 cells, or with the largest number of cells per axis
/// that floats can distinguish.
#[test]
fn memory_does_not_know_the_domain() {
    let mut per_element = Vec::new();
    for n in [2_000_u32, 20_000] {
        for spacing in [1.0, 1e5, 1e13] {
            let edge = f64::from(n).cbrt().ceil() as u32;
            let place = |k: u32| [k % edge, k / edge % edge, k / edge / edge].map(|x| f64::from(x) * spacing);
            let mut centres: Vec<[f64; 3]> = (0..n).map(place).collect();
            // Adds a partner of each element away from the start.
            centres.extend_from_within(..);
            let elements = Elements::points(&centres, 1e-3).unwrap();
            let mut search = CGrid::new();
            assert_eq!(search.count(&elements), Ok(u64::from(n)), "spacing {spacing}");
            // `memory.rs` shows that nothing else is allocated.
            per_element.push(search.bytes() as f64 / f64::from(2 * n));
        }
    }
    assert!(per_element.iter().all(|&bytes| bytes == per_element[0] && bytes < 220.0), "{per_element:?}");
}

/// Entries and tests per element are bounded by the number of cells that bodies span. They depend neither on
/// N nor on one body that covers everything.
#[test]
fn work_is_linear() {
    let work = |n: usize, edit: &dyn Fn(&mut Cloud<3>), sizes: Sizes| {
        let mut cloud = gas::<3>(n, 14, 6.0, sizes).unwrap();
        edit(&mut cloud);
        let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
        let mut search = CGrid::new();
        search.count(&elements).unwrap();
        [search.entries(), search.tests()].map(|count| count as f64 / n as f64)
    };
    for sizes in [EQUAL, power_law(30.0), Sizes::Lognormal { median: 0.5, sigma: 0.25 }] {
        let [few, many] = [2_000, 40_000].map(|n| work(n, &|_| {}, sizes));
        assert!(many[0] < 1.5 * few[0] && many[1] < 1.5 * few[1], "{few:?} {many:?}");
    }
    let giant = |cloud: &mut Cloud<3>| cloud.radii[5] = 1e5;
    let [without, with] =
        [&(|_: &mut Cloud<3>| {}) as &dyn Fn(&mut Cloud<3>), &giant].map(|edit| work(20_000, edit, EQUAL));
    assert!(with[0] < without[0] + 10.0 && with[1] < without[1] + 1.5, "{without:?} {with:?}");
}

/// Only levels with elements exist, and a class of few elements has no separate level.
#[test]
fn levels_follow_the_sizes() {
    let counts = |levels: Vec<Level>| levels.iter().map(|level| level.elements).collect::<Vec<_>>();
    let centres: Vec<[f64; 2]> = (0..1000).map(|k| [f64::from(k), 0.0]).collect();
    let of =
        |radii: &[f64]| counts(CGrid::new().levels(&Elements::spheres_with_radii(&centres, radii).unwrap()));
    let mut radii = vec![0.5; 1000];
    assert_eq!(of(&radii), [1000]);
    radii[3] = 1e9;
    assert_eq!(of(&radii), [999, 1]);
    radii[4..60].fill(1e-3);
    assert_eq!(of(&radii), [999, 1], "few small ones");
    radii[4..204].fill(1e-3);
    assert_eq!(of(&radii), [200, 799, 1]);
}

/// The C-grid is chosen for long thin boxes; other boxes, and spheres, use other engines.
#[test]
fn auto_takes_cells_for_long_boxes_only() {
    let auto = |min: &[[f64; 3]], max: &[[f64; 3]]| {
        Detector::new().plan(&Elements::boxes(min, max).unwrap()).unwrap()
    };
    let mut random = Random::new(15);
    let min: Vec<[f64; 3]> =
        (0..40_000).map(|_| std::array::from_fn(|_| random.between(0.0, 160.0))).collect();
    let max: Vec<_> =
        min.iter().map(|corner| [corner[0] + 100.0, corner[1] + 1.0, corner[2] + 1.0]).collect();
    let plan = auto(&min, &max);
    assert_eq!(plan.engine, Engine::CGrid);
    assert!(plan.reason.contains("long and thin") && !plan.levels.is_empty(), "{}", plan.reason);
    let max: Vec<_> = min.iter().map(|corner| corner.map(|x| x + 2.0)).collect();
    assert_eq!(auto(&min, &max).engine, Engine::Rows);
    let spheres = Elements::spheres(&min, 1.0).unwrap();
    assert_eq!(Detector::new().plan(&spheres).unwrap().engine, Engine::Rows);
    // So sparse that no element is near another: all the work is sorting.
    let sparse: Vec<[f64; 3]> = min.iter().map(|corner| corner.map(|x| x * 1e4)).collect();
    let max: Vec<_> =
        sparse.iter().map(|corner| [corner[0] + 100.0, corner[1] + 1.0, corner[2] + 1.0]).collect();
    assert_eq!(auto(&sparse, &max).engine, Engine::Rows);
}

/// Compares the predicted work of levels with the actual work: the candidates of one level by brute force,
/// and the sum of the couples.
#[test]
fn the_work_of_levels_is_counted() {
    // One row of cells along x, with a window of 1 on each side: elements 0.25 apart have 4 candidates behind
    // them.
    let centres: Vec<[f64; 2]> = (0..1000).map(|k| [f64::from(k) * 0.25, 0.0]).collect();
    let elements = Elements::points(&centres, 1.0).unwrap();
    let work = Multilevel::new().work(&elements).unwrap();
    assert_eq!(work.len(), 1);
    assert_eq!((work[0].levels, work[0].windows), ([0, 0], 1000));
    assert_eq!((work[0].candidates, work[0].couples), (4 * 1000 - 10, 4 * 1000 - 10));
    let predicted = work[0].predicted_candidates / work[0].candidates as f64;
    assert!((0.5..2.5).contains(&predicted), "{predicted}");

    let cloud = gas::<3>(30_000, 16, 6.0, power_law(100.0)).unwrap();
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let mut search = Multilevel::new();
    let levels = search.levels(&elements).len();
    let work = search.work(&elements).unwrap();
    assert_eq!(work.len(), levels * (levels + 1) / 2);
    assert_eq!(work.iter().map(|work| work.couples).sum::<u64>(), search.count(&elements).unwrap());
    assert!(work.iter().all(|work| work.couples <= work.candidates), "{work:?}");
    let [predicted, counted] = [
        work.iter().map(|work| work.predicted_candidates).sum::<f64>(),
        work.iter().map(|work| work.candidates as f64).sum(),
    ];
    assert!((0.5..2.0).contains(&(predicted / counted)), "{predicted} predicted, {counted} counted");
    assert_eq!(work, search.clone().with_threads(2).unwrap().work(&elements).unwrap());
    let none: [[f64; 3]; 0] = [];
    assert!(search.work(&Elements::points(&none, 1.0).unwrap()).unwrap().is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Arbitrary boxes whose coordinates are small integers: touching is exact, and sizes and places
    /// coincide.
    #[test]
    fn any_boxes_equal_direct(
        boxes in prop::collection::vec((prop::array::uniform3(-20_i16..20), prop::array::uniform3(0_u8..30)), 0..120),
        tolerance in 0_u8..3,
        long in 0_usize..60,
    ) {
        let min: Vec<[f64; 3]> = boxes.iter().map(|(corner, _)| corner.map(f64::from)).collect();
        let mut max: Vec<[f64; 3]> = boxes.iter().map(|(corner, edges)| {
            // Powers of two, so that sizes are unlike.
            std::array::from_fn(|axis| f64::from(corner[axis]) + f64::from(1_u32 << (edges[axis] % 8)) - 1.0)
        }).collect();
        for corner in max.iter_mut().take(long) {
            corner[0] += 1000.0;
        }
        let elements = Elements::boxes(&min, &max).unwrap().with_tolerance(f64::from(tolerance)).unwrap();
        let expected = ascending(Direct, &elements);
        prop_assert_eq!(&ascending(CGrid::new(), &elements), &expected);
        prop_assert!(verify(&elements, &expected, 10, 0).is_ok());

        // Moved by whole cells, exactly: the same couples in the same order.
        let mut order = Vec::new();
        CGrid::new().couples(&elements, &mut order).unwrap();
        let moved = |corners: &[[f64; 3]]| -> Vec<[f64; 3]> {
            corners.iter().map(|corner| [corner[0] + 4096.0, corner[1] - 1024.0, corner[2]]).collect()
        };
        let (low, high) = (moved(&min), moved(&max));
        let elements = Elements::boxes(&low, &high).unwrap().with_tolerance(f64::from(tolerance)).unwrap();
        let mut found = Vec::new();
        CGrid::new().couples(&elements, &mut found).unwrap();
        prop_assert_eq!(found, order);
    }

    /// Renumbering the elements only renumbers the couples.
    #[test]
    fn renumbering_renumbers(
        spheres in prop::collection::vec((prop::array::uniform2(-1e3..1e3_f64), 0.0..1.0_f64), 1..150),
        seed in any::<u64>(),
    ) {
        let centres: Vec<[f64; 2]> = spheres.iter().map(|(centre, _)| *centre).collect();
        // Most are small, and some cover much.
        let radii: Vec<f64> = spheres.iter().map(|(_, size)| 3.0 + 500.0 * size.powi(12)).collect();
        let elements = Elements::spheres_with_radii(&centres, &radii).unwrap();
        let couples = ascending(CGrid::new(), &elements);
        prop_assert_eq!(&couples, &ascending(Direct, &elements));

        let mut numbers: Vec<u32> = (0..centres.len() as u32).collect();
        let mut random = Random::new(seed);
        for k in (1..numbers.len()).rev() {
            numbers.swap(k, random.below(k as u64 + 1) as usize);
        }
        let shuffled: Vec<_> = numbers.iter().map(|&k| centres[k as usize]).collect();
        let shuffled_radii: Vec<_> = numbers.iter().map(|&k| radii[k as usize]).collect();
        let elements = Elements::spheres_with_radii(&shuffled, &shuffled_radii).unwrap();
        let mut found: Vec<Couple> = ascending(CGrid::new(), &elements)
            .into_iter()
            .map(|couple| Couple::new(numbers[couple.i as usize], numbers[couple.j as usize]))
            .collect();
        found.sort_unstable();
        prop_assert_eq!(found, couples);
    }

    /// Any finite floats.
    #[test]
    fn any_floats_equal_direct(
        spheres in prop::collection::vec((prop::array::uniform2(-1e30_f32..1e30), any::<f32>()), 0..60),
        exponent in -60_i32..1,
    ) {
        let scale = 2.0_f32.powi(exponent);
        let in_range = |x: f32| if x.abs() <= f32::MAX_MAGNITUDE { x } else { x.signum() };
        let centres: Vec<[f32; 2]> =
            spheres.iter().map(|(centre, _)| centre.map(|x| in_range(x * 1e-12) * scale)).collect();
        let radii: Vec<f32> =
            spheres.iter().map(|(_, radius)| if radius.is_finite() { in_range(radius.abs()) } else { 1.0 }).collect();
        let elements = Elements::spheres_with_radii(&centres, &radii).unwrap();
        prop_assert_eq!(ascending(CGrid::new(), &elements), ascending(Direct, &elements));
    }
}
