//! Elements of unlike sizes, in levels.

use fdem_contact::{Couple, Detector, Direct, Elements, Engine, Multilevel, Plan, Rows, Search, Simd};
use fdem_scenes::{Cloud, Sizes, gas};

use crate::ascending;

/// Limits that separate no levels, some, and all.
const LIMITS: [&[f64]; 4] =
    [&[], &[1.0], &[1e-3, 0.1, 1.0, 10.0], &[f64::NAN, 0.0, -1.0, 1e300, f64::INFINITY, 4.0]];

/// Every choice of levels, threads and vectors finds the couples of all-against-all, in one order per choice
/// of levels.
fn equals_direct<const D: usize>(what: &str, elements: &Elements<'_, f64, D>) -> usize {
    let expected = ascending(Direct, elements);
    for limits in std::iter::once(None).chain(LIMITS.map(Some)) {
        let mut order: Option<Vec<Couple>> = None;
        for (simd, threads) in
            Simd::available().into_iter().map(|simd| (simd, 1)).chain([(Simd::best(), 2), (Simd::best(), 5)])
        {
            let context = || format!("{what}, D = {D}, limits {limits:?}, {simd}, {threads} threads");
            let mut search = Multilevel::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
            if let Some(limits) = limits {
                search = search.with_limits(limits);
            }
            let counts: Vec<_> = search.levels(elements).iter().map(|level| level.elements).collect();
            assert_eq!(counts.iter().sum::<usize>(), elements.len(), "{}", context());
            assert!(!counts.contains(&0), "{}: {counts:?}", context());
            let (mut found, mut visited) = (Vec::new(), Vec::new());
            search.couples(elements, &mut found).unwrap();
            assert!(found.iter().all(|couple| couple.i < couple.j), "{}", context());
            assert!(*order.get_or_insert_with(|| found.clone()) == found, "the order: {}", context());
            search.for_each(elements, |couple| visited.push(couple)).unwrap();
            assert!(visited == found, "visited: {}", context());
            assert_eq!(search.count(elements), Ok(expected.len() as u64), "counted: {}", context());
            found.sort_unstable();
            assert!(
                found == expected,
                "{}: {} couples instead of {}",
                context(),
                found.len(),
                expected.len()
            );
        }
    }
    expected.len()
}

fn of<const D: usize>(what: &str, cloud: &Cloud<D>) {
    for tolerance in [0.0, 0.3] {
        let spheres = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
        let couples = equals_direct(what, &spheres.with_tolerance(tolerance).unwrap());
        assert!(couples > cloud.len() / 8, "{what} has couples to lose: {couples}");
        let corner = |side: f64| -> Vec<[f64; D]> {
            // Boxes that are longer along the first axis, some of them by far.
            let corners = cloud.centres.iter().zip(&cloud.radii).enumerate();
            let stretch = |k: usize, axis: usize| if axis == k % (D + 1) { 3.0 } else { 0.5 };
            corners
                .map(|(k, (centre, radius))| {
                    std::array::from_fn(|axis| centre[axis] + side * radius * stretch(k, axis))
                })
                .collect()
        };
        let (min, max) = (corner(-1.0), corner(1.0));
        let boxes = Elements::boxes(&min, &max).unwrap().with_tolerance(tolerance).unwrap();
        equals_direct(&format!("boxes, {what}"), &boxes);
    }
}

fn power_law(ratio: f64) -> Sizes {
    Sizes::PowerLaw { min: 0.5, max: 0.5 * ratio, exponent: -2.0 }
}

fn all_ratios<const D: usize>(n: usize) {
    for ratio in [1.0, 3.0, 30.0, 1000.0] {
        of(&format!("ratio {ratio}"), &gas::<D>(n, 1, 3.0, power_law(ratio)).unwrap());
    }
}

#[test]
fn size_ratios_from_1_to_1000() {
    all_ratios::<1>(400);
    all_ratios::<2>(1500);
    all_ratios::<3>(1500);
    all_ratios::<4>(300);
}

#[test]
fn a_body_that_covers_everything() {
    let mut cloud = gas::<3>(1000, 2, 3.0, power_law(4.0)).unwrap();
    cloud.radii[123] = 1e3;
    of("one covers all", &cloud);
    cloud.radii[7] = 1e6;
    cloud.centres[7] = [1e6, 0.0, 0.0];
    of("two cover all", &cloud);
}

#[test]
fn coincident_bodies() {
    let mut cloud = gas::<2>(1200, 3, 3.0, power_law(50.0)).unwrap();
    cloud.centres[..600].fill([1.0, 2.0]);
    of("half in one place", &cloud);
    cloud.centres.fill([-3.0, 4.0]);
    of("all in one place", &cloud);
}

#[test]
fn points_among_spheres() {
    let mut cloud = gas::<3>(1000, 4, 6.0, power_law(20.0)).unwrap();
    cloud.radii.iter_mut().step_by(3).for_each(|radius| *radius = 0.0);
    of("a third are points", &cloud);
    cloud.radii.iter_mut().step_by(5).for_each(|radius| *radius = 1e-320);
    of("some are nearly points", &cloud);
}

/// Centres on the faces of cells and sizes of whole steps, so that exact touching is common.
#[test]
fn bodies_on_the_faces_of_cells() {
    let centres: Vec<[f64; 2]> = (0..900).map(|k| [f64::from(k % 30), f64::from(k / 30)]).collect();
    let radii: Vec<f64> = (0..900).map(|k| [0.5, 0.25, 1.0, 4.0, 0.0][k * 7 % 41 % 5]).collect();
    of("a lattice", &Cloud { centres, radii });
}

#[test]
fn far_apart_and_large() {
    let mut cloud = gas::<2>(800, 5, 3.0, power_law(10.0)).unwrap();
    cloud.centres.iter_mut().step_by(50).for_each(|centre| centre[0] += 1e12);
    let spheres = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    equals_direct("clusters 1e12 apart", &spheres);
    let scale = 2.0_f64.powi(400);
    let centres: Vec<_> = cloud.centres.iter().map(|centre| centre.map(|x| x * scale)).collect();
    let radii: Vec<_> = cloud.radii.iter().map(|radius| radius * scale).collect();
    equals_direct("times 2^400", &Elements::spheres_with_radii(&centres, &radii).unwrap());
}

#[test]
fn nothing_and_one() {
    let none: [[f64; 2]; 0] = [];
    let elements = Elements::spheres_with_radii(&none, &[]).unwrap();
    assert!(Multilevel::new().levels(&elements).is_empty());
    assert_eq!(equals_direct("nothing", &elements), 0);
    assert_eq!(equals_direct("one", &Elements::spheres_with_radii(&[[1.0, 2.0]], &[3.0]).unwrap()), 0);
}

/// Sums over parts do not depend on the number of threads.
#[test]
fn a_large_set_on_threads() {
    let cloud = gas::<3>(60_000, 6, 3.0, power_law(100.0)).unwrap();
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let mut order = Vec::new();
    Multilevel::new().couples(&elements, &mut order).unwrap();
    assert!(order.len() > 30_000);
    assert!(Multilevel::new().levels(&elements).len() > 2);
    for threads in [2, 3, 8] {
        let mut search = Multilevel::new().with_threads(threads).unwrap();
        let mut found = Vec::new();
        for _ in 0..2 {
            search.couples(&elements, &mut found).unwrap();
            assert!(found == order, "{threads} threads");
        }
    }
    assert!(
        ascending(Rows::new(), &elements) == {
            order.sort_unstable();
            order
        }
    );
}

#[test]
fn auto_takes_levels_where_they_pay() {
    let plan = |sizes| -> Plan<3> {
        let cloud = gas::<3>(20_000, 7, 3.0, sizes).unwrap();
        let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
        Detector::new().plan(&elements).unwrap()
    };
    assert_eq!(plan(Sizes::Equal { radius: 1.0 }).engine, Engine::Rows);
    assert_eq!(plan(power_law(2.0)).engine, Engine::Rows);
    let unlike = plan(power_law(100.0));
    assert_eq!(unlike.engine, Engine::Multilevel);
    assert!(unlike.reason.contains("ratio"), "{}", unlike.reason);
}

/// Small spheres around large ones, which they touch in one point: at distances that are whole numbers, along
/// all rows, near and far from the origin. The large spheres have several sizes, each with a smaller reach
/// than its level.
#[test]
fn contacts_in_one_point_in_any_direction() {
    // Vectors for which x² + y² + z² is a square.
    let directions: [[f64; 3]; 6] = [
        [0.0, 0.0, 1.0],
        [3.0, 4.0, 0.0],
        [1.0, 2.0, 2.0],
        [2.0, 3.0, 6.0],
        [4.0, 4.0, 7.0],
        [1.0, 4.0, 8.0],
    ];
    for (origin, unit) in [(0.0, 1.0), (1e9, 0.25), (-1e12, 1.0)] {
        let (mut centres, mut radii) = (Vec::new(), Vec::new());
        for large in 0..24_u32 {
            let scale = f64::from(40 + large % 8 * 8);
            let centre =
                [0, 1, 2].map(|axis| origin + 4096.0 * f64::from(large / 3_u32.pow(axis) % 3) * unit);
            let centre = [centre[0], centre[1], centre[2] + 4096.0 * f64::from(large / 12) * unit];
            let mut nearest = f64::INFINITY;
            for turn in 0..48_usize {
                let mut offset = directions[turn % 6];
                let length = offset.iter().map(|x| x * x).sum::<f64>().sqrt();
                offset.rotate_left(turn / 6 % 3);
                let sign = |axis: usize| if (turn / 6 + turn) >> axis & 1 == 0 { 1.0 } else { -1.0 };
                // Whole multiples of the direction, about as long as the large radius.
                let times = (scale / length).floor();
                nearest = nearest.min(times * length);
                centres.push([0, 1, 2].map(|axis| centre[axis] + sign(axis) * offset[axis] * times * unit));
                radii.push(times * length);
            }
            // The small radius is the distance that remains to the surface of the large sphere.
            let large_radius = nearest - 1.0;
            let first = radii.len() - 48;
            radii[first..].iter_mut().for_each(|radius| *radius = (*radius - large_radius) * unit);
            centres.push(centre);
            radii.push(large_radius * unit);
        }
        let elements = Elements::spheres_with_radii(&centres, &radii).unwrap();
        let couples = equals_direct(&format!("touching spheres at {origin}"), &elements);
        assert!(couples >= 24 * 48, "each small one touches its large one: {couples}");
    }
}
