//! The prediction of a search, compared with the search.

use fdem_contact::{
    Couple, Detector, Direct, Elements, Engine, Error, Explanation, Filter, GroupMatrix, Nbs, PeriodicBox,
    PeriodicSearch, Rows, Search, Simd,
};
use fdem_scenes::{Cloud, Sizes, clusters, gas, lattice};

const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

fn explained<const D: usize>(
    engine: impl Into<Option<Engine>>,
    elements: &Elements<'_, f64, D>,
) -> Explanation<D> {
    let detector = Detector::new().with_engine(engine);
    let explanation = detector.explain(elements).unwrap();
    assert_eq!(detector.explain(elements).unwrap(), explanation, "the same at every call");
    explanation
}

/// The predicted number of couples is within a factor of the actual one.
fn is_within<const D: usize>(scene: &str, cloud: &Cloud<D>, factor: f64) {
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let explanation = explained(None, &elements);
    let found = Rows::new().count(&elements).unwrap() as f64;
    is_near(scene, &explanation, found, factor);
    assert_eq!((explanation.images, explanation.list_bytes), (None, 8.0 * explanation.couples));
}

fn is_near<const D: usize>(scene: &str, explanation: &Explanation<D>, found: f64, factor: f64) {
    let (expected, error) = (explanation.couples, explanation.couples_error);
    assert!(expected <= factor * found && found <= factor * expected, "{scene}: {expected} for {found}");
    assert!((expected - found).abs() <= 4.0 * error, "{scene}: {expected} +- {error} for {found}");
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

/// Rows of a lattice are as long as a stretch of the sample: taking the same place of every stretch would
/// sample a single face.
#[test]
fn a_lattice_is_not_in_step_with_the_sample() {
    is_within("lattice", &lattice::<3>(64 * 64 * 64, 0.5, 1.0).unwrap(), 1.03);
}

#[test]
fn few_elements_are_counted() {
    for n in [0, 1, 2, 40, 1024] {
        let cloud = gas::<3>(n, 5, 9.0, EQUAL).unwrap();
        for spread in [1.0, 1e9] {
            let centres: Vec<_> = cloud.centres.iter().map(|centre| centre.map(|x| x * spread)).collect();
            let elements = Elements::spheres(&centres, 0.5 * spread).unwrap();
            let explanation = explained(None, &elements);
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
    let explanation = explained(None, &Elements::spheres(&centres, 0.5).unwrap());
    assert_eq!(explanation.couples, 3000.0 * 2999.0 / 2.0);
}

/// The predicted number of bytes is an upper bound, and at most twice the bytes held.
fn bytes_are_told<const D: usize>(scene: &str, elements: &Elements<'_, f64, D>) {
    for threads in [1, 2] {
        let mut rows = Rows::new().with_threads(threads).unwrap();
        rows.count(elements).unwrap();
        let detector = Detector::new().with_engine(Engine::Rows).with_threads(threads).unwrap();
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
    let detector = Detector::new().with_simd(Simd::Portable).unwrap();
    let explanation = detector.explain(&elements).unwrap();
    let text = explanation.to_string();
    for part in [
        "engine    rows: linear",
        "elements  2,000",
        "rows      ",
        "at most ",
        "couples   about 1,9",
        "standard error",
        "memory    0.",
        "threads   1, portable",
    ] {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
    let mut couples: Vec<Couple> = Vec::new();
    Direct.couples(&elements, &mut couples).unwrap();
    assert_eq!(couples.len(), 1998);

    let few = Detector::new()
        .with_engine(Engine::Direct)
        .explain(&Elements::points(&centres[..3], 2.0).unwrap())
        .unwrap();
    assert_eq!(
        few.to_string(),
        "engine    direct: requested\nelements  3\ncouples   1\nmemory    0.0 MB for the engine, 0.0 MB for a list of the \
         couples\nthreads   1\n"
    );
}

/// A box whose edge is `fraction` of that of the cube around a cloud, sheared by `tilt` of its edge.
fn box_around<const D: usize>(cloud: &Cloud<D>, fraction: f64, tilt: f64) -> PeriodicBox<f64, D> {
    let edge = cloud.centres.as_flattened().iter().fold(0.0, |largest, &x| f64::max(largest, x)) * fraction;
    let mut edges = [[0.0; D]; D];
    for (axis, vector) in edges.iter_mut().enumerate() {
        vector[axis] = edge;
    }
    edges[D - 1][0] = tilt * edge;
    PeriodicBox::triclinic([0.0; D], edges, std::array::from_fn(|axis| axis != 1)).unwrap()
}

/// Compares with a search in the same box.
fn is_within_in_a_box<const D: usize>(
    scene: &str,
    cloud: &Cloud<D>,
    cell: &PeriodicBox<f64, D>,
    factor: f64,
) -> Explanation<D> {
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let mut search = PeriodicSearch::new();
    let explanation = search.explain(&elements, cell).unwrap();
    assert_eq!(search.explain(&elements, cell).unwrap(), explanation, "the same at every call");
    let found = search.count(&elements, cell).unwrap() as f64;
    is_near(scene, &explanation, found, factor);
    assert_eq!(explanation.images, Some(search.images()), "{scene}");
    assert_eq!(explanation.elements, cloud.len());
    assert_eq!(explanation.list_bytes, (8 + 4 * D) as f64 * explanation.couples);
    explanation
}

#[test]
fn couples_in_boxes_that_repeat_are_estimated() {
    for seed in 1..4 {
        let cloud = gas::<3>(60_000, seed, 12.0, EQUAL).unwrap();
        for tilt in [0.0, 0.4] {
            let told = is_within_in_a_box("gas", &cloud, &box_around(&cloud, 1.0, tilt), 1.1);
            assert!(told.images.unwrap() < 15_000, "few images: these are searched apart");
            // Most elements are outside and wrapped.
            is_within_in_a_box("wrapped", &cloud, &box_around(&cloud, 0.5, tilt), 1.1);
        }
        let flat = gas::<2>(60_000, seed, 6.0, EQUAL).unwrap();
        is_within_in_a_box("flat gas", &flat, &box_around(&flat, 1.0, -0.2), 1.1);
        let sizes = Sizes::Lognormal { median: 0.5, sigma: 0.3 };
        let unlike = gas::<3>(30_000, seed, 8.0, sizes).unwrap();
        is_within_in_a_box("sizes", &unlike, &box_around(&unlike, 1.0, 0.3), 1.3);
    }
    // More images than elements; a couple of thousand are in reach of each other.
    let cloud = gas::<2>(3000, 1, 1.0, EQUAL).unwrap();
    let cell = PeriodicBox::orthogonal([0.0; 2], [3.0; 2], [true; 2]).unwrap();
    let told = is_within_in_a_box("small box", &cloud, &cell, 1.1);
    assert!(told.images.unwrap() > 3000);
    let cell = PeriodicBox::orthogonal([0.0; 2], [1.5; 2], [true; 2]).unwrap();
    let told = is_within_in_a_box("smaller than two elements", &cloud, &cell, 1.1);
    assert_eq!(told.plan.engine, Engine::Direct, "{}", told.plan.reason);
}

#[test]
fn few_elements_in_boxes_that_repeat_are_counted() {
    for n in [0, 1, 2, 40, 400] {
        let cloud = gas::<3>(n, 5, 9.0, EQUAL).unwrap();
        let bodies: Vec<u32> = (0..n as u32).map(|k| k / 3).collect();
        let corners: Vec<_> = cloud.centres.iter().map(|centre| centre.map(|x| x + 0.8)).collect();
        let spheres = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
        for (edge, tilt) in [(40.0, 0.0), (3.0, 0.5), (1.7, -0.3), (0.9, 0.0)] {
            let edges = [[edge, 0.0, 0.0], [0.0, edge, 0.0], [tilt * edge, 0.0, edge]];
            for periodic in [[true; 3], [true, false, true], [false; 3]] {
                let cell = PeriodicBox::triclinic([0.1; 3], edges, periodic).unwrap();
                for elements in [
                    spheres,
                    spheres.with_tolerance(0.2).unwrap().with_filter(Filter::bodies(&bodies)).unwrap(),
                    Elements::boxes(&cloud.centres, &corners).unwrap(),
                ] {
                    let mut search = PeriodicSearch::new();
                    let told = search.explain(&elements, &cell).unwrap();
                    let found = search.count(&elements, &cell).unwrap();
                    assert_eq!((told.couples, told.couples_error), (found as f64, 0.0), "{n}, edge {edge}");
                    assert_eq!(told.images, Some(search.images()));
                }
            }
        }
    }
}

#[test]
fn the_bytes_of_a_periodic_search_are_told() {
    let cloud = gas::<3>(20_000, 1, 12.0, EQUAL).unwrap();
    let groups: Vec<u32> = (0..20_000).map(|k| k % 40).collect();
    let equal = Elements::spheres(&cloud.centres, 0.5).unwrap();
    let radii = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    for elements in [equal, radii, radii.with_filter(Filter::bodies(&groups)).unwrap()] {
        for (fraction, threads) in [(1.0, 1), (0.7, 1), (0.7, 2), (0.2, 1)] {
            let cell = box_around(&cloud, fraction, 0.0);
            for engine in [Engine::Rows, Engine::Nbs] {
                let search = || PeriodicSearch::new().with_engine(engine).with_threads(threads).unwrap();
                let told = search().explain(&elements, &cell).unwrap();
                let mut counted = search();
                counted.count(&elements, &cell).unwrap();
                let (told, held) = (told.bytes, counted.bytes());
                assert!(
                    held <= told && told <= 2 * held,
                    "{engine}, {fraction}, {threads}: {told} for {held}"
                );
                assert!(engine == Engine::Rows || held == told, "{fraction}: {told} for {held}");
            }
        }
    }
}

#[test]
fn a_periodic_search_is_explained_in_words_or_refused() {
    let centres: Vec<[f64; 2]> = (0..2000).map(|k| [f64::from(k), f64::from(k % 40)]).collect();
    let elements = Elements::points(&centres, 1.5).unwrap();
    let cell = PeriodicBox::orthogonal([0.0; 2], [2000.0, 40.0], [true, true]).unwrap();
    let mut search = PeriodicSearch::new().with_simd(Simd::Portable).unwrap();
    let text = search.explain(&elements, &cell).unwrap().to_string();
    let images = format!("images    {}\n", search.images());
    for part in [
        "engine    rows: linear",
        "elements  2,000\n",
        &images,
        "rows      ",
        "couples   2,000\n",
        ", portable",
    ] {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
    let plan = search.explain(&elements, &cell).unwrap().plan;
    assert_eq!(plan, Detector::new().plan(&elements).unwrap(), "all are inside, and few near a face");

    for engine in [Engine::Direct, Engine::Nbs] {
        let told = PeriodicSearch::new().with_engine(engine).explain(&elements, &cell).unwrap();
        assert_eq!((told.plan.engine, told.plan.reason.as_str()), (engine, "requested"));
    }
    let mut bounded = PeriodicSearch::new().with_engine(Engine::Rows).with_max_images(3);
    assert!(matches!(bounded.explain(&elements, &cell), Err(Error::TooManyImages { limit: 3, .. })));
    let mut strict = PeriodicSearch::new().with_engine(Engine::Rows).refuse_outside();
    let narrow = PeriodicBox::orthogonal([0.0; 2], [1998.5, 40.0], [true, true]).unwrap();
    let error = strict.explain(&elements, &narrow).unwrap_err();
    assert!(matches!(error, Error::OutsideBox { index: 1999, .. }), "{error}");
}
