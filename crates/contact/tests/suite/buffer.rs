//! Buffered updates: after each one the couples equal those of `Direct`, and detections are as rare as
//! documented.

use fdem_contact::{Buffered, Couple, Direct, Elements, Error, Nbs, Real, Reason, Rows, Search, Update};
use fdem_scenes::random::Random;
use proptest::prelude::*;

use crate::ascending;
use crate::oracle::FromF64;

/// The couples of an update, ascending. All three ways to get them must agree.
fn couples<T: Real, const D: usize>(update: &Update<'_, T, D>) -> Vec<Couple> {
    let (mut couples, mut visited) = (vec![Couple::new(7, 8)], Vec::new());
    update.couples(&mut couples).unwrap();
    update.for_each(|couple| visited.push(couple));
    assert_eq!(couples, visited);
    assert_eq!(update.count(), couples.len() as u64);
    couples.sort_unstable();
    couples
}

/// Moving elements: centres and radii, from which boxes are made too.
struct Walk<T, const D: usize> {
    random: Random,
    centres: Vec<[T; D]>,
    radii: Vec<T>,
}

impl<T: FromF64, const D: usize> Walk<T, D> {
    fn new(n: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        // About eight neighbours within a diameter.
        let width = (n as f64 / 3.0).powf(1.0 / D as f64);
        let centres =
            (0..n).map(|_| std::array::from_fn(|_| T::from_f64(random.between(0.0, width)))).collect();
        let radii = (0..n).map(|_| T::from_f64(random.between(0.3, 0.5))).collect();
        Self { random, centres, radii }
    }

    fn step(&mut self, length: f64, drift: f64, growth: f64) {
        for (centre, radius) in self.centres.iter_mut().zip(&mut self.radii) {
            for x in centre {
                *x = T::from_f64(x.to_f64() + drift + self.random.between(-length, length));
            }
            *radius = T::from_f64(radius.to_f64() * (1.0 + growth));
        }
    }

    fn corners(&self, side: f64) -> Vec<[T; D]> {
        let corner = |(centre, radius): (&[T; D], &T)| {
            centre.map(|x| T::from_f64(x.to_f64() + side * radius.to_f64()))
        };
        self.centres.iter().zip(&self.radii).map(corner).collect()
    }
}

fn walks<T: FromF64, const D: usize>() {
    let buffers = [0.0, 1e-6, 0.05, 0.3, 1.0];
    let mut kept = 0;
    let mut detected = 0;
    for (seed, buffer) in buffers.into_iter().enumerate() {
        for (length, drift, growth) in [
            (0.002, 0.0, 0.0),
            (0.02, 1e3 * buffer, 0.0),
            (0.1, 0.0, 0.0),
            (0.002, -1e3 * buffer, 0.001),
            (0.0, 0.3, 0.0),
        ] {
            let mut walk = Walk::<T, D>::new(150, seed as u64);
            let buffer = T::from_f64(buffer);
            let tolerance = T::from_f64(0.03);
            let mut equal = Buffered::new(buffer).unwrap();
            let mut radii = Buffered::with_search(Rows::new(), buffer).unwrap();
            let mut boxes = Buffered::with_search(Direct, buffer).unwrap();
            for _ in 0..12 {
                let (min, max) = (walk.corners(-1.0), walk.corners(1.0));
                let shapes = [
                    (&mut equal as &mut dyn Engine<T, D>, Elements::spheres(&walk.centres, T::from_f64(0.4))),
                    (&mut radii, Elements::spheres_with_radii(&walk.centres, &walk.radii)),
                    (&mut boxes, Elements::boxes(&min, &max)),
                ];
                for (buffered, elements) in shapes {
                    let elements = elements.unwrap().with_tolerance(tolerance).unwrap();
                    let expected = ascending(Direct, &elements);
                    assert!(expected.len() > 20, "there are couples to lose");
                    let (found, reason) = buffered.update_to(&elements);
                    assert!(
                        found == expected,
                        "D = {D}, buffer {buffer}, step {length}, drift {drift}, {reason:?}"
                    );
                    if reason.is_some() {
                        detected += 1;
                    } else {
                        kept += 1;
                    }
                }
                walk.step(length, drift, growth);
            }
        }
    }
    assert!(kept > 100 && detected > 100, "{kept} updates kept their candidates, {detected} detected");
}

/// `Buffered` with any search.
trait Engine<T, const D: usize> {
    fn update_to(&mut self, elements: &Elements<'_, T, D>) -> (Vec<Couple>, Option<Reason>);
}

impl<T: Real, const D: usize, S: Search<T, D>> Engine<T, D> for Buffered<T, D, S> {
    fn update_to(&mut self, elements: &Elements<'_, T, D>) -> (Vec<Couple>, Option<Reason>) {
        let update = self.update(elements).unwrap();
        (couples(&update), update.reason())
    }
}

#[test]
fn walks_2d_f64() {
    walks::<f64, 2>();
}

#[test]
fn walks_3d_f64() {
    walks::<f64, 3>();
}

#[test]
fn walks_2d_f32() {
    walks::<f32, 2>();
}

#[test]
fn walks_3d_f32() {
    walks::<f32, 3>();
}

/// `x`, moved by some units in the last place up or down.
fn nudged<T: FromF64>(x: f64, units: i32) -> T {
    let rounded = T::from_f64(x).to_f64();
    T::from_f64(rounded * (1.0 + f64::from(units) * T::EPSILON))
}

/// Two elements that are just not candidates approach each other by about half a buffer each, give or take
/// some units in the last place. Rounding could lose a couple here. Also far from the origin, and with a
/// common drift.
fn at_the_limit<T: FromF64>(
    units: [i32; 4],
    size: f64,
    buffer: f64,
    origin: f64,
    drift: f64,
    kind: usize,
) -> bool {
    let reach = T::from_f64(size).to_f64();
    let before = [[nudged::<T>(origin, 0)], [nudged(origin + reach + buffer, units[0])]];
    let now = [
        [nudged::<T>(before[0][0].to_f64() + drift + buffer / 2.0, units[1])],
        [nudged(before[1][0].to_f64() + drift - buffer / 2.0, units[2])],
    ];
    let size = nudged::<T>(size, units[3]);
    let half = size * T::HALF;
    let buffer = T::from_f64(buffer);
    let radii = [half, size - half];
    let far = |points: &[[T; 1]; 2]| points.map(|[x]| [x + half]);
    let (far_before, far_now) = (far(&before), far(&now));
    let make = |points, far| {
        match kind {
            0 => Elements::points(points, size),
            1 => Elements::spheres_with_radii(points, &radii),
            _ => Elements::boxes(points, far),
        }
        .unwrap()
    };
    let mut buffered = Buffered::new(buffer).unwrap();
    let _ = buffered.update(&make(&before, &far_before)).unwrap();
    // Boxes are half as long; the other half is tolerance.
    let tolerance = if kind == 2 { half } else { T::ZERO };
    let start = make(&before, &far_before).with_tolerance(tolerance).unwrap();
    let candidate = buffered.update(&start).unwrap().candidates().len();
    let elements = make(&now, &far_now).with_tolerance(tolerance).unwrap();
    let update = buffered.update(&elements).unwrap();
    assert_eq!(couples(&update), ascending(Direct, &elements), "{:?}", update.reason());
    candidate == 0 && update.count() == 1
}

/// Cases of rounding at the limit: many under `just thorough`, which sets `FDEM_THOROUGH`.
fn rounding_cases() -> ProptestConfig {
    let cases = if crate::thorough() { 20_000 } else { 2000 };
    ProptestConfig { cases, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(rounding_cases())]

    #[test]
    fn no_rounding_loses_a_couple(
        units in [-4..4_i32, -4..4_i32, -4..4_i32, -4..4_i32],
        size in 0.1..2.0,
        buffer in prop_oneof![0.001..0.1, 0.1..1.0, 1e-15..1e-6],
        origin in prop_oneof![Just(0.0), -1.0..1.0, -1e4..1e4],
        drift in prop_oneof![Just(0.0), -1.0..1.0, -1e3..1e3],
        kind in 0..3_usize,
    ) {
        at_the_limit::<f64>(units, size, buffer, origin, drift, kind);
        at_the_limit::<f32>(units, size, buffer, origin, drift, kind);
    }

    /// Any scale, and any buffer that fits it: squares underflow, or nearly overflow.
    #[test]
    fn any_scale_equals_direct(
        steps in prop::collection::vec(prop::collection::vec([-1.0..1.0, -1.0..1.0], 6), 1..4),
        exponent in prop_oneof![-1070..490_i32, -560..-490_i32],
        buffer in 0.0..1.0,
        boxes in any::<bool>(),
    ) {
        let scale = 2.0_f64.powi(exponent);
        let mut buffered = Buffered::new(buffer * scale).unwrap();
        for step in steps {
            let centres: Vec<[f64; 2]> = step.iter().map(|centre| centre.map(|x: f64| x * scale)).collect();
            let far: Vec<[f64; 2]> = centres.iter().map(|centre| centre.map(|x| x + 0.1 * scale)).collect();
            let elements = if boxes { Elements::boxes(&centres, &far) } else { Elements::points(&centres, 0.5 * scale) };
            let elements = elements.unwrap();
            prop_assert_eq!(couples(&buffered.update(&elements).unwrap()), ascending(Direct, &elements));
        }
    }
}

/// Shows that the test above does reach couples that were not candidates.
#[test]
fn couples_at_the_limit_are_met() {
    let mut met = 0;
    let units = || (-3..=3).flat_map(|a| (-3..=3).flat_map(move |b| (-3..=3).map(move |c| [a, b, c, 0])));
    for (size, buffer) in [(1.0, 0.3), (0.7, 0.1), (1.3, 0.9)] {
        for units in units() {
            for kind in 0..3 {
                met += usize::from(at_the_limit::<f64>(units, size, buffer, 0.1, 0.0, kind));
                met += usize::from(at_the_limit::<f32>(units, size, buffer, 0.1, 0.7, kind));
            }
        }
    }
    assert!(met > 100, "{met}");
}

fn line(n: usize) -> Vec<[f64; 2]> {
    (0..n).map(|k| [k as f64, 0.0]).collect()
}

#[test]
fn motion_within_the_buffer_does_not_detect() {
    let n = 5000;
    let mut buffered = Buffered::new(0.2).unwrap();
    for step in 0..50 {
        // Back and forth by at most 0.09, neighbours against each other.
        let swing = 0.09 * f64::from((step + 2) % 5 - 2) / 2.0;
        let centres: Vec<[f64; 2]> = line(n)
            .iter()
            .enumerate()
            .map(|(k, [x, y])| [*x, if k % 2 == 0 { y + swing } else { y - swing }])
            .collect();
        let elements = Elements::points(&centres, 1.001).unwrap();
        let update = buffered.update(&elements).unwrap();
        assert_eq!(update.reason(), (step == 0).then_some(Reason::First));
        assert_eq!(couples(&update), ascending(Nbs::new(), &elements));
    }
    assert_eq!((buffered.updates(), buffered.redetections()), (50, 1));
}

/// More candidates than the threads take at a time.
#[test]
#[cfg(feature = "rayon")]
fn threads_change_nothing() {
    let cloud = fdem_scenes::peers::gas(60_000, 3).unwrap();
    let elements = Elements::points(&cloud.centres, 1.0).unwrap();
    let mut expected = Vec::new();
    for threads in [1, 2, 3] {
        let mut buffered = Buffered::with_search(Rows::new(), 0.1).unwrap().with_threads(threads).unwrap();
        let update = buffered.update(&elements).unwrap();
        assert!(update.candidates().len() > 300_000);
        let mut found = Vec::new();
        update.couples(&mut found).unwrap();
        assert_eq!(update.count(), found.len() as u64);
        if threads == 1 {
            expected = found;
            let mut direct = expected.clone();
            direct.sort_unstable();
            assert_eq!(direct, ascending(Rows::new(), &elements));
        } else {
            assert!(found == expected, "{threads} threads");
        }
    }
}

/// All elements move by a thousand buffers in each step; spheres and boxes; more elements than the sample for
/// the mean.
#[test]
fn common_drift_does_not_detect() {
    let mut spheres = Buffered::new(0.25).unwrap();
    let mut boxes = Buffered::new(0.25).unwrap();
    for step in 0..50 {
        let drift = 250.0 * f64::from(step);
        let low: Vec<[f64; 2]> = line(3000).iter().map(|[x, y]| [x + drift, y - drift]).collect();
        let high: Vec<[f64; 2]> = low.iter().map(|[x, y]| [x + 1.0, y + 1.0]).collect();
        for (buffered, elements) in
            [(&mut spheres, Elements::points(&low, 1.0)), (&mut boxes, Elements::boxes(&low, &high))]
        {
            assert_eq!(buffered.update(&elements.unwrap()).unwrap().count(), 2999);
        }
    }
    assert_eq!((spheres.redetections(), boxes.redetections()), (1, 1));
}

/// Of 4096 elements 1024 are sampled. If only these move, the mean of the sample misleads, and the mean of
/// all is computed.
#[test]
fn the_mean_of_all_decides() {
    let mut centres = line(4096);
    let mut buffered = Buffered::new(0.5).unwrap();
    assert!(buffered.update(&Elements::points(&centres, 1.0).unwrap()).unwrap().redetected());
    centres.iter_mut().step_by(4).for_each(|centre| centre[1] += 0.3);
    let elements = Elements::points(&centres, 1.0).unwrap();
    let update = buffered.update(&elements).unwrap();
    assert_eq!(update.reason(), None, "0.225 and 0.075 from the mean");
    assert_eq!(couples(&update), ascending(Direct, &elements));
}

#[test]
fn the_reason_is_told() {
    let centres = line(10);
    let mut moved = centres.clone();
    moved[7][1] = 0.5;
    let high: Vec<[f64; 2]> = centres.iter().map(|[x, y]| [x + 0.5, y + 0.5]).collect();
    let mut grown = high.clone();
    grown[3][1] = 0.9;
    let mut radii = [0.5; 10];
    let mut buffered = Buffered::new(0.4).unwrap();
    let mut reason = |elements: Result<Elements<'_, f64, 2>, Error>| {
        let elements = elements.unwrap();
        let update = buffered.update(&elements).unwrap();
        assert_eq!(couples(&update), ascending(Direct, &elements));
        assert_eq!(update.redetected(), update.reason().is_some());
        update.reason()
    };
    assert_eq!(reason(Elements::spheres(&centres, 0.5)), Some(Reason::First));
    assert_eq!(reason(Elements::spheres(&centres, 0.5)), None);
    let Some(Reason::Moved { element: 7, distance, limit }) = reason(Elements::spheres(&moved, 0.5)) else {
        panic!("element 7 moved")
    };
    assert!((distance - 0.45).abs() < 1e-12, "{distance}: a tenth of 0.5 is the mean");
    assert!(limit < 0.2 && limit > 0.2 - 1e-12, "{limit}");
    assert_eq!(reason(Elements::spheres(&moved, 0.6)), Some(Reason::SizeChanged { element: 0 }));
    assert_eq!(reason(Elements::spheres(&moved, 0.5)), Some(Reason::SizeChanged { element: 0 }));
    assert_eq!(reason(Elements::spheres_with_radii(&moved, &radii)), None, "equal radii");
    radii[4] = 0.3;
    let elements = Elements::spheres_with_radii(&moved, &radii);
    assert_eq!(reason(elements.clone()), Some(Reason::SizeChanged { element: 4 }));
    assert_eq!(reason(elements.clone()), None);
    assert_eq!(reason(Elements::spheres(&moved, 0.5)), Some(Reason::SizeChanged { element: 4 }));
    radii[2] = 0.4;
    let elements = Elements::spheres_with_radii(&moved, &radii);
    assert_eq!(reason(elements.clone()), Some(Reason::SizeChanged { element: 2 }));
    assert_eq!(reason(elements.unwrap().with_tolerance(0.1)), Some(Reason::ToleranceChanged));
    assert_eq!(reason(Elements::boxes(&centres, &high)), Some(Reason::ShapeChanged));
    assert!(matches!(reason(Elements::boxes(&centres, &grown)), Some(Reason::Moved { element: 3, .. })));
    let fewer = Reason::CountChanged { before: 10, now: 9 };
    assert_eq!(reason(Elements::boxes(&centres[1..], &high[1..])), Some(fewer));
    assert_eq!(reason(Elements::boxes(&[], &[])), Some(Reason::CountChanged { before: 9, now: 0 }));
    assert_eq!(reason(Elements::boxes(&[], &[])), None);
    assert_eq!(fewer.to_string(), "10 elements became 9");
}

#[test]
fn a_buffer_of_nothing_always_detects() {
    let centres = line(3);
    let elements = Elements::points(&centres, 1.0).unwrap();
    for buffer in [0.0, 1e-16] {
        let mut buffered = Buffered::new(buffer).unwrap();
        assert_eq!(buffered.update(&elements).unwrap().reason(), Some(Reason::First));
        assert_eq!(buffered.update(&elements).unwrap().reason(), Some(Reason::BufferTooSmall));
    }
}

#[test]
fn wrong_numbers_are_errors_and_keep_nothing_wrong() {
    for buffer in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
        let error = Buffered::<f64, 2>::new(buffer).unwrap_err();
        assert!(matches!(error, Error::InvalidBuffer { .. }), "{error:?}");
        assert!(error.to_string().starts_with("buffer "), "{error}");
    }

    // An update never sees NaN: the elements are refused, and the existing candidates stay valid.
    let mut centres = line(5);
    let mut buffered = Buffered::new(0.5).unwrap();
    assert_eq!(buffered.update(&Elements::points(&centres, 1.0).unwrap()).unwrap().count(), 4);
    centres[3][1] = f64::NAN;
    let error = Elements::points(&centres, 1.0).unwrap_err();
    assert!(matches!(error, Error::NonFiniteCoordinate { index: 3, axis: 1, .. }), "{error:?}");
    centres[3][1] = 0.1;
    assert!(!buffered.update(&Elements::points(&centres, 1.0).unwrap()).unwrap().redetected());

    // A search that fails leaves nothing that could be mistaken for a result.
    let mut buffered = Buffered::with_search(Nbs::new().with_max_heads(1000), 0.5).unwrap();
    let near = Elements::points(&centres, 1.0).unwrap();
    assert!(buffered.update(&near).unwrap().redetected());
    let mut far = centres.clone();
    far[0][0] = 1e9;
    let error = buffered.update(&Elements::points(&far, 1.0).unwrap()).unwrap_err();
    assert!(matches!(error, Error::DomainTooWide { .. }), "{error:?}");
    assert_eq!(buffered.update(&near).unwrap().reason(), Some(Reason::First));
    assert_eq!((buffered.updates(), buffered.redetections()), (2, 2));
    let too_far = near.with_tolerance(f64::MAX_MAGNITUDE).unwrap();
    let mut wide = Buffered::new(f64::MAX_MAGNITUDE).unwrap();
    assert!(matches!(wide.update(&too_far).unwrap_err(), Error::InvalidTolerance { .. }));
}
