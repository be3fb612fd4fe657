//! Radii that are all equal are searched as one radius: the same couples in the same order as spheres that
//! each have a radius, for every engine.

use fdem_contact::{
    Couple, CrossCouple, Detector, Elements, Engine, Index, PeriodicBox, PeriodicCouple, PeriodicSearch,
    Real, Search, Simd,
};

use crate::ENGINES;

/// The couples of one set, of two sets and in a periodic box, in the order of each engine, with these vector
/// instructions and number of threads.
type Found<const D: usize> = (Vec<Vec<Couple>>, Vec<CrossCouple>, Vec<PeriodicCouple<D>>);

fn found<T: Real, const D: usize>(
    elements: &Elements<'_, T, D>,
    simd: Simd,
    threads: usize,
    width: T,
) -> Found<D> {
    let detector = Detector::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
    let of_engine = |engine: Option<Engine>| {
        let mut couples = Vec::new();
        detector.clone().with_engine(engine).couples(elements, &mut couples).unwrap();
        couples
    };
    let mut index = Index::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
    index.build(elements).unwrap();
    let (mut cross, mut periodic) = (Vec::new(), Vec::new());
    index.couples_with(elements, &mut cross).unwrap();
    let mut edges = [[T::ZERO; D]; D];
    (0..D).for_each(|axis| edges[axis][axis] = width);
    let cell = PeriodicBox::triclinic([T::ZERO; D], edges, [true; D]).unwrap();
    let mut search = PeriodicSearch::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
    search.couples(elements, &cell, &mut periodic).unwrap();
    (ENGINES.map(of_engine).to_vec(), cross, periodic)
}

/// Compares with spheres of which the last has the next larger radius, so that each has one of its own.
fn equal_radii_are_recognised<T: Real, const D: usize>(n: usize, width: f64, radius: f64) {
    let mut state = 5_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        T::nearest((state >> 40) as f64 / (1_u64 << 24) as f64 * width)
    };
    let centres: Vec<[T; D]> = (0..n).map(|_| std::array::from_fn(|_| random())).collect();
    let radii = vec![T::nearest(radius); n];
    let mut unlike = radii.clone();
    unlike[n - 1] = T::nearest(radius * (1.0 + T::EPSILON));
    assert!(unlike[n - 1] > radii[0]);
    for tolerance in [T::ZERO, T::nearest(0.1)] {
        let equal = Elements::spheres_with_radii(&centres, &radii).unwrap();
        let equal = equal.with_tolerance(tolerance).unwrap();
        let each = Elements::spheres_with_radii(&centres, &unlike).unwrap();
        let each = each.with_tolerance(tolerance).unwrap();
        for simd in Simd::available() {
            for threads in [1, 2] {
                let width = T::nearest(width);
                let (expected, found) =
                    (found(&each, simd, threads, width), found(&equal, simd, threads, width));
                assert!(found == expected, "D = {D}: {simd}, {threads} threads");
                assert!(found.0[0].len() > n / 2 && found.2.len() > found.0[0].len(), "D = {D}");
            }
        }
    }
}

#[test]
fn equal_radii_are_searched_as_one_radius() {
    equal_radii_are_recognised::<f64, 1>(300, 100.0, 0.5);
    equal_radii_are_recognised::<f64, 2>(3000, 30.0, 0.5);
    equal_radii_are_recognised::<f64, 3>(3000, 12.0, 0.5);
    equal_radii_are_recognised::<f32, 2>(3000, 30.0, 0.5);
    equal_radii_are_recognised::<f32, 3>(3000, 12.0, 0.3);
    equal_radii_are_recognised::<f64, 4>(500, 4.0, 0.5);
}
