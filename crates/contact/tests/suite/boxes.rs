//! Boxes most of which are much shorter than the longest, so that they look ahead in all rows around them.
//! Compared with all-against-all; the order is the same for every set of vector instructions and any number
//! of threads.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use fdem_contact::{Couple, Direct, Elements, Filter, Multilevel, Real, Rows, Search, Simd};
use fdem_scenes::random::Random;

/// Corners from 0 to `width` and edges from 0 to 1; one edge in 20 is `longest`. All are rounded to multiples
/// of `step`, so that boxes begin and end at the same places.
fn boxes<T: Real, const D: usize>(n: usize, width: f64, longest: f64, step: f64) -> [Vec<[T; D]>; 2] {
    let mut random = Random::new(n as u64);
    let rounded = |x: f64| T::at_least(if step > 0.0 { (x / step).floor() * step } else { x });
    let mut corners = [Vec::new(), Vec::new()];
    for k in 0..n {
        let low: [f64; D] = std::array::from_fn(|_| random.between(0.0, width));
        let edge = |axis: usize, random: &mut Random| {
            if (k + axis).is_multiple_of(20) { longest } else { random.between(0.0, 1.0) }
        };
        let high: [f64; D] = std::array::from_fn(|axis| low[axis] + edge(axis, &mut random));
        corners[0].push(low.map(rounded));
        corners[1].push(high.map(rounded));
    }
    corners
}

/// Checks that all searches find the same couples, and returns their number.
fn found_by_all<T: Real, const D: usize>(elements: &Elements<'_, T, D>, what: &str) -> usize {
    let mut expected = Vec::new();
    Direct.couples(elements, &mut expected).unwrap();
    let is_expected = |mut couples: Vec<Couple>, by: &str| {
        couples.sort_unstable();
        assert!(couples == expected, "{by}: {what}, D = {D}, {} boxes", elements.len());
    };
    // The first list is compared with all-against-all, and each other one with the first, in its order.
    let is_as_first = |first: &mut Option<Vec<Couple>>, couples: Vec<Couple>, by: &str| {
        if let Some(first) = first {
            assert!(*first == couples, "the order: {by}: {what}, D = {D}, {} boxes", elements.len());
        } else {
            is_expected(couples.clone(), by);
            *first = Some(couples);
        }
    };
    let levels = Simd::available().into_iter().map(|simd| (simd, 1)).chain([(Simd::best(), 3)]);
    let (mut of_rows, mut of_levels) = (None, [None, None]);
    for (simd, threads) in levels {
        let mut rows = Rows::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
        let mut couples = Vec::new();
        rows.couples(elements, &mut couples).unwrap();
        assert_eq!(rows.count(elements).unwrap(), couples.len() as u64, "{simd}: {what}");
        is_as_first(&mut of_rows, couples, &format!("rows, {simd}, {threads}"));
        for (limits, first) in [&[][..], &[0.5, 5.0]].into_iter().zip(&mut of_levels) {
            let levels = Multilevel::new().with_simd(simd).unwrap().with_limits(limits);
            let mut couples = Vec::new();
            levels.with_threads(threads).unwrap().couples(elements, &mut couples).unwrap();
            is_as_first(first, couples, &format!("levels {limits:?}, {simd}, {threads}"));
        }
    }
    expected.len()
}

fn all<T: Real, const D: usize>() {
    let mut couples = 0;
    for (n, width, longest, step) in [
        (3000, 20.0, 30.0, 0.0),
        (3000, 40.0, 10.0, 0.5),
        (2000, 12.0, 12.0, 1.0),
        (6000, 100.0, 20.0, 0.0),
        (300, 3.0, 50.0, 0.25),
        (40, 2.0, 1000.0, 1.0),
        (500, 0.0, 7.0, 1.0),
    ] {
        let [min, max] = boxes::<T, D>(n, width, longest, step);
        let what = format!("width {width}, longest {longest}, step {step}");
        let elements = Elements::boxes(&min, &max).unwrap();
        couples += found_by_all(&elements, &what);
        couples += found_by_all(&elements.with_tolerance(T::at_least(0.25)).unwrap(), &what);
        let bodies: Vec<u32> = (0..n as u32).map(|k| k / 3).collect();
        couples += found_by_all(&elements.with_filter(Filter::bodies(&bodies)).unwrap(), &what);
    }
    assert!(couples > 100_000, "{couples} couples to lose");
}

#[test]
fn f64_1d() {
    all::<f64, 1>();
}

#[test]
fn f64_2d() {
    all::<f64, 2>();
}

#[test]
fn f64_3d() {
    all::<f64, 3>();
}

#[test]
fn f32_2d() {
    all::<f32, 2>();
}

#[test]
fn f32_3d() {
    all::<f32, 3>();
}

#[test]
fn f64_4d() {
    all::<f64, 4>();
}
