//! What is told of a search beforehand, against the search.

use fdem_contact::{
    Couple, Detector, Direct, Elements, Engine, Explanation, Filter, GroupMatrix, Nbs, Rows, Search, Simd,
};
use fdem_scenes::{Cloud, Sizes, clusters, gas, lattice};

const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

fn explained<const D: usize>(engine: Engine, elements: &Elements<'_, f64, D>) -> Explanation<D> {
    let detector = Detector::new(engine);
    let explanation = detector.explain(elements).unwrap();
    assert_eq!(detector.explain(elements).unwrap(), explanation, "the same at every call");
    explanation
}

/// The couples are within a factor of those that a search finds.
fn is_within<const D: usize>(scene: &str, cloud: &Cloud<D>, factor: f64) {
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let explanation = explained(Engine::Auto, &elements);
    let found = Rows::new().count(&elements).unwrap() as f64;
    let (expected, error) = (explanation.couples, explanation.couples_error);
    assert!(expected <= factor * found && found <= factor * expected, "{scene}: {expected} for {found}");
    assert!((expected - found).abs() <= 4.0 * error, "{scene}: {expected} +- {error} for {found}");
    assert_eq!(explanation.list_bytes, 8.0 * expected);
}

#[test]
fn couples_are_estimated() {
    for seed in 1..6 {
        is_within("gas", &gas::<3>(60_000, seed, 12.0, EQUAL).unwrap(), 1.1);
        is_within("flat gas", &gas::<2>(60_000, seed, 6.0, EQUAL).unwrap(), 1.1);
        is_within("clusters", &clusters::<3>(60_000, seed, 1000, 1e5, 4.0, EQUAL).unwrap(), 1.3);
        let sizes = Sizes::Lognormal { median: 0.5, sigma: 0.3 };
        is_within("sizes", &gas::<3>(30_000, seed, 8.0, sizes).unwrap(), 1.3);
    }
    is_within("few", &gas::<3>(2000, 1, 0.5, EQUAL).unwrap(), 1.3);
}

/// Rows of a lattice are as long as a stretch of the sample: one element of each, by number, would see one face only.
#[test]
fn a_lattice_is_not_in_step_with_the_sample() {
    is_within("lattice", &lattice::<3>(64 * 64 * 64, 0.5, 1.0).unwrap(), 1.03);
}

#[test]
fn few_elements_are_counted() {
    for n in [0, 1, 2, 40, 1000, 1024] {
        let cloud = gas::<3>(n, 5, 9.0, EQUAL).unwrap();
        for spread in [1.0, 1e9] {
            let centres: Vec<_> = cloud.centres.iter().map(|centre| centre.map(|x| x * spread)).collect();
            let elements = Elements::spheres(&centres, 0.5 * spread).unwrap();
            let explanation = explained(Engine::Auto, &elements);
            assert_eq!(explanation.couples, Direct.count(&elements).unwrap() as f64, "{n}");
            assert_eq!(explanation.couples_error, 0.0);
        }
    }
    let (low, high): (Vec<_>, Vec<_>) =
        (0..900).map(|k| f64::from(k) * 0.25).map(|x| ([x; 4], [x + 1.0; 4])).unzip();
    let bodies: Vec<u32> = (0..900).map(|k| k / 3).collect();
    let boxes = Elements::boxes(&low, &high).unwrap().with_filter(Filter::bodies(&bodies)).unwrap();
    let explanation = explained(Engine::Rows, &boxes);
    assert_eq!(explanation.couples, Direct.count(&boxes).unwrap() as f64);
    assert_eq!(explanation.simd, Some(Simd::Portable), "boxes are compared one at a time");
}

#[test]
fn coincident_elements_all_touch() {
    let centres = vec![[1.0, 2.0]; 3000];
    let explanation = explained(Engine::Auto, &Elements::spheres(&centres, 0.5).unwrap());
    assert_eq!(explanation.couples, 3000.0 * 2999.0 / 2.0);
}

/// Bytes are an upper bound, and no more than twice what is held.
fn bytes_are_told<const D: usize>(scene: &str, elements: &Elements<'_, f64, D>) {
    for threads in [1, 2] {
        let mut rows = Rows::new().with_threads(threads).unwrap();
        rows.count(elements).unwrap();
        let detector = Detector::new(Engine::Rows).with_threads(threads).unwrap();
        let explanation = detector.explain(elements).unwrap();
        let (told, held) = (explanation.bytes, rows.bytes());
        assert!(held <= told && told <= 2 * held, "{scene}, {threads} threads: {told} for {held}");
        assert_eq!(explanation.threads, threads);
    }
}

#[test]
fn the_bytes_of_rows_are_told() {
    let cloud = gas::<3>(100_000, 1, 12.0, EQUAL).unwrap();
    let equal = Elements::spheres(&cloud.centres, 0.5).unwrap();
    bytes_are_told("gas", &equal);
    bytes_are_told("radii", &Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap());
    let groups: Vec<u32> = (0..100_000).map(|k| k % 40).collect();
    let matrix = GroupMatrix::all(40).unwrap();
    let filter = Filter::groups(&groups, &matrix).with_bodies(&groups);
    bytes_are_told("filter", &equal.with_filter(filter).unwrap());
    let flat = gas::<2>(100_000, 1, 6.0, EQUAL).unwrap();
    bytes_are_told("flat gas", &Elements::spheres(&flat.centres, 0.5).unwrap());
    let far = clusters::<3>(100_000, 1, 1000, 1e5, 4.0, EQUAL).unwrap();
    bytes_are_told("clusters", &Elements::spheres(&far.centres, 0.5).unwrap());
}

#[test]
fn the_bytes_of_nbs_are_exact() {
    for n in [0, 1, 5000] {
        let cloud = gas::<3>(n, 1, 12.0, EQUAL).unwrap();
        let elements = Elements::spheres(&cloud.centres, 0.5).unwrap();
        let mut nbs = Nbs::new();
        nbs.count(&elements).unwrap();
        assert_eq!(explained(Engine::Nbs, &elements).bytes, 4 * nbs.integers(), "{n}");
    }
}

#[test]
fn the_text_says_it_all() {
    let centres: Vec<[f64; 3]> = (0..2_000).map(|k| [f64::from(k), 0.0, f64::from(k % 2) * 1e15]).collect();
    let elements = Elements::points(&centres, 2.0).unwrap();
    let detector = Detector::new(Engine::Auto).with_simd(Simd::Portable).unwrap();
    let explanation = detector.explain(&elements).unwrap();
    let text = explanation.to_string();
    for part in [
        "engine    rows: linear",
        "elements  2,000",
        "rows      ",
        "at most ",
        "couples   about 1,9",
        "give or take",
        "memory    0.",
        "threads   1, portable",
    ] {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
    let mut couples: Vec<Couple> = Vec::new();
    Direct.couples(&elements, &mut couples).unwrap();
    assert_eq!(couples.len(), 1998);

    let few = Detector::new(Engine::Direct).explain(&Elements::points(&centres[..3], 2.0).unwrap()).unwrap();
    assert_eq!(
        few.to_string(),
        "engine    direct: asked for\nelements  3\ncouples   1\nmemory    0.0 MB for the engine, 0.0 MB for a list of the \
         couples\nthreads   1\n"
    );
}
