//! Periodic boxes on a device: couples and shifts of `PeriodicSearch` with the engine `Rows`, in its order.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use std::cmp::Ordering;

use bytemuck::Pod;
use fdem_contact::{Elements, Engine, Error, Filter, PeriodicBox, PeriodicSearch, Real};
use fdem_gpu::{DeviceRows, Host, HostBuild};
use fdem_scenes::random::Random;

/// The couples on the device, which are compared with those of the processor. Returns their number, and that
/// of the images.
fn same<T: Real + Pod, const D: usize>(
    what: &str,
    elements: &Elements<'_, T, D>,
    cell: &PeriodicBox<T, D>,
) -> [usize; 2] {
    let mut expected = Vec::new();
    PeriodicSearch::new().with_engine(Engine::Rows).couples(elements, cell, &mut expected).unwrap();
    let mut images = 0;
    for build in [HostBuild::Ascending, HostBuild::Descending] {
        let host = Host(build);
        let (mut search, mut found) = (PeriodicSearch::new(), Vec::new());
        search.couples_by(&mut DeviceRows::new(&host), elements, cell, &mut found).unwrap();
        assert!(found == expected, "{what}: {build:?}, {} couples", expected.len());
        images = search.images();
    }
    [expected.len(), images]
}

/// Edges of a box: along the axes, sheared, sheared by more than an edge, skewed so far that short edges are
/// searched.
fn boxes<const D: usize>() -> Vec<(&'static str, [[f64; D]; D])> {
    let sheared = |tilt: f64| -> [[f64; D]; D] {
        std::array::from_fn(|a| {
            std::array::from_fn(|b| match a.cmp(&b) {
                Ordering::Equal => 1.0 + 0.3 * a as f64,
                Ordering::Greater => tilt,
                Ordering::Less => 0.0,
            })
        })
    };
    vec![
        ("along the axes", sheared(0.0)),
        ("sheared", sheared(0.4)),
        ("far", sheared(1.7)),
        ("skewed", sheared(60.0)),
    ]
}

/// Elements in all boxes: inside, outside, on the faces; from boxes thinner than an element to wide ones.
fn elements_in_boxes<T: Real + Pod, const D: usize>() {
    let mut random = Random::new(9);
    let of = T::nearest;
    let (mut couples, mut images, mut apart) = (0, 0, 0);
    for (shape, edges) in boxes::<D>() {
        for bits in 1..1_u32 << D {
            let periodic: [bool; D] = std::array::from_fn(|axis| bits >> axis & 1 == 1);
            for (size, n, outside) in
                [(0.6, 3, 1.0), (1.5, 20, 3.0), (7.0, 300, 1.0), (30.0, 1000, 1.0), (30.0, 1000, 1.5)]
            {
                let scaled = edges.map(|edge| edge.map(|x| of(x * size)));
                let cell = PeriodicBox::triclinic([of(-1.25); D], scaled, periodic).unwrap();
                // One fraction in three is that of a face, or next to it.
                let mut fraction = |k: u32| match (k % 3, random.below(6)) {
                    (0, 0) => 0.0,
                    (0, 1) => 1.0,
                    (0, 2) => 1.0 - 1e-16,
                    (0, 3) => -1e-17,
                    _ => 0.5 + outside * (random.uniform() - 0.5),
                };
                let points: Vec<[T; D]> = (0..n)
                    .map(|k| {
                        let fractions: [f64; D] = std::array::from_fn(|_| fraction(k));
                        std::array::from_fn(|axis| {
                            let sum = (0..D).map(|a| fractions[a] * scaled[a][axis].to_f64()).sum::<f64>();
                            of(sum - 1.25)
                        })
                    })
                    .collect();
                let what = format!("{shape}, {periodic:?}, {size} wide, {outside}, {n} elements");
                let elements = Elements::points(&points, of(1.0)).unwrap();
                let found = same(&what, &elements, &cell);
                let bodies: Vec<u32> = (0..n).map(|_| random.below(5) as u32).collect();
                let filtered = elements.with_filter(Filter::bodies(&bodies)).unwrap();
                assert!(same(&what, &filtered, &cell)[0] <= found[0]);
                let radii: Vec<T> = (0..n).map(|_| of(random.between(0.1, 0.5))).collect();
                let spheres = Elements::spheres_with_radii(&points, &radii).unwrap();
                let with_radii = same(&what, &spheres.with_tolerance(of(0.01)).unwrap(), &cell);
                couples += found[0] + with_radii[0];
                images += found[1];
                apart += usize::from(found[1] > 0 && 4 * found[1] <= points.len());
            }
        }
    }
    assert!(couples > 10_000 && images > 5_000 && apart > 2, "{couples} couples, {images} images, {apart}");
}

#[test]
fn elements_in_boxes_in_the_plane() {
    elements_in_boxes::<f64, 2>();
    elements_in_boxes::<f32, 2>();
}

#[test]
fn elements_in_boxes_in_space() {
    elements_in_boxes::<f64, 3>();
    elements_in_boxes::<f32, 3>();
}

#[test]
fn few_elements_in_boxes() {
    let cell = PeriodicBox::orthogonal([0.0; 3], [2.0, 0.5, 9.0], [true, true, false]).unwrap();
    assert_eq!(same("none", &Elements::points(&[], 1.0).unwrap(), &cell), [0, 0]);
    // It touches its own images along y, one and two edges away.
    assert_eq!(same("one", &Elements::points(&[[7.0, -3.0, 100.0]], 1.0).unwrap(), &cell)[0], 2);
    let crowd = vec![[0.0, 0.5, 3.0]; 40];
    assert!(same("one place", &Elements::points(&crowd, 0.0).unwrap(), &cell)[0] >= 40 * 39 / 2);
}

/// Elements that no search takes are refused with the number of the caller.
#[test]
fn errors_name_elements() {
    let host = Host(HostBuild::Ascending);
    let cell = PeriodicBox::orthogonal([0.0; 2], [1.0; 2], [true; 2]).unwrap();
    let points = [[0.5, 0.5], [1e12, 0.0]];
    let elements = Elements::points(&points, 0.1).unwrap();
    let mut couples = vec![];
    let found = PeriodicSearch::new().couples_by(&mut DeviceRows::new(&host), &elements, &cell, &mut couples);
    assert!(matches!(found, Err(Error::TooFarFromBox { index: 1, edge: 0, .. })), "{found:?}");
}
