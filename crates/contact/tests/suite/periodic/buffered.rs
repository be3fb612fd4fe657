//! Elements that walk in boxes that repeat: after each update the couples are those of a search that tests
//! everything.

use fdem_contact::{
    Elements, Engine, Error, Filter, PeriodicBox, PeriodicBuffered, PeriodicCouple, PeriodicSearch, Reason,
};
use fdem_scenes::random::Random;

use crate::oracle::FromF64;

fn expected<T: FromF64, const D: usize>(
    elements: &Elements<'_, T, D>,
    cell: &PeriodicBox<T, D>,
) -> Vec<PeriodicCouple<D>> {
    let mut couples = Vec::new();
    PeriodicSearch::new().with_engine(Engine::Direct).couples(elements, cell, &mut couples).unwrap();
    couples.sort_unstable();
    couples
}

/// Steps of the elements, and treatment of elements that leave the box.
#[derive(Clone, Copy)]
struct Walk {
    step: f64,
    drift: f64,
    wraps: bool,
}

/// Walks `n` elements; returns how many updates detected.
fn walk<T: FromF64, const D: usize>(n: usize, cell: &PeriodicBox<T, D>, shape: usize, walk: Walk) -> usize {
    let mut random = Random::new((n + shape) as u64);
    let edges = cell.edges().map(|edge| edge.map(T::to_f64));
    let mut centres: Vec<[T; D]> = (0..n)
        .map(|_| {
            let fractions: [f64; D] = std::array::from_fn(|_| random.between(-0.5, 1.5));
            std::array::from_fn(|axis| {
                T::from_f64((0..D).map(|edge| fractions[edge] * edges[edge][axis]).sum())
            })
        })
        .collect();
    let radii: Vec<T> = (0..n).map(|_| T::from_f64(random.between(0.2, 0.5))).collect();
    let bodies: Vec<u32> = (0..n as u32).map(|k| k / 3).collect();
    let mut buffered = PeriodicBuffered::new(T::from_f64(0.25)).unwrap();
    let (mut couples, mut detected) = (Vec::new(), 0);
    for step in 0..12 {
        let far: Vec<[T; D]> = centres
            .iter()
            .zip(&radii)
            .map(|(x, r)| x.map(|x| T::from_f64(x.to_f64() + r.to_f64())))
            .collect();
        let elements = match shape {
            0 => Elements::points(&centres, T::from_f64(1.0)),
            1 => Elements::spheres_with_radii(&centres, &radii),
            2 => Elements::spheres_with_radii(&centres, &radii).unwrap().with_filter(Filter::bodies(&bodies)),
            _ => Elements::boxes(&centres, &far),
        };
        let elements = elements.unwrap().with_tolerance(T::from_f64(0.05)).unwrap();
        let reason = buffered.update(&elements, cell, &mut couples).unwrap();
        assert_eq!(step == 0, reason == Some(Reason::First), "{reason:?}");
        detected += usize::from(reason.is_some());
        couples.sort_unstable();
        assert_eq!(couples, expected(&elements, cell), "step {step}, {n} elements of shape {shape}");
        for centre in &mut centres {
            for x in centre.iter_mut() {
                *x = T::from_f64(x.to_f64() + walk.drift + random.between(-walk.step, walk.step));
            }
            if walk.wraps {
                *centre = cell.wrap(*centre).unwrap().0;
            }
        }
    }
    assert_eq!((buffered.updates(), buffered.redetections()), (12, detected as u64));
    detected
}

fn boxes<T: FromF64>() {
    let t = |rows: [[f64; 3]; 3]| rows.map(|row| row.map(T::from_f64));
    let cells = [
        PeriodicBox::orthogonal([T::ZERO; 3], [T::from_f64(6.0); 3], [true; 3]),
        PeriodicBox::triclinic(
            [T::from_f64(-2.0); 3],
            t([[5.0, 0.0, 0.0], [2.0, 4.0, 0.5], [-1.0, 1.5, 6.0]]),
            [true; 3],
        ),
        PeriodicBox::orthogonal([T::ZERO; 3], [T::from_f64(5.0); 3], [true, false, true]),
        // Skewed: searched by other edges than these.
        PeriodicBox::triclinic(
            [T::ZERO; 3],
            t([[6.0, 0.0, 0.0], [120.0, 6.0, 0.0], [0.0, -60.0, 6.0]]),
            [true; 3],
        ),
        // Smaller than the elements reach.
        PeriodicBox::orthogonal([T::ZERO; 3], [T::from_f64(0.9); 3], [true; 3]),
    ];
    for (k, cell) in cells.into_iter().enumerate() {
        let cell = cell.unwrap();
        let n = if k == 4 { 5 } else { 150 };
        for shape in 0..4 {
            for wraps in [false, true] {
                let slow = walk(n, &cell, shape, Walk { step: 0.008, drift: 0.07, wraps });
                assert!(slow < 12, "drift alone must not detect");
                let fast = walk(n, &cell, shape, Walk { step: 0.2, drift: 0.0, wraps });
                assert!(fast > 6, "{fast} detections");
            }
        }
    }
}

#[test]
fn couples_are_those_of_all_against_all_in_single() {
    boxes::<f32>();
}

#[test]
fn couples_are_those_of_all_against_all_in_double() {
    boxes::<f64>();
}

#[test]
fn in_a_plane() {
    let cell = PeriodicBox::triclinic([0.0, 0.0], [[7.0, 0.0], [3.0, 6.0]], [true, true]).unwrap();
    assert!(walk(120, &cell, 1, Walk { step: 0.01, drift: 0.3, wraps: true }) < 12);
}

#[test]
fn what_changes_is_noticed() {
    let centres = [[0.1, 1.0], [3.9, 1.0]];
    let cell = |x: f64| PeriodicBox::orthogonal([0.0, 0.0], [x, 9.0], [true, true]).unwrap();
    let mut buffered = PeriodicBuffered::new(0.5).unwrap();
    let mut couples = Vec::new();
    let mut update = |centres: &[[f64; 2]], radius: f64, x: f64| {
        let reason = buffered.update(&Elements::spheres(centres, radius).unwrap(), &cell(x), &mut couples);
        (reason, couples.len())
    };
    assert_eq!(update(&centres, 0.2, 4.0), (Ok(Some(Reason::First)), 1));
    assert_eq!(update(&centres, 0.2, 4.0), (Ok(None), 1));
    assert_eq!(update(&centres, 0.2, 5.0), (Ok(Some(Reason::BoxChanged)), 0));
    assert_eq!(update(&centres, 0.7, 5.0), (Ok(Some(Reason::SizeChanged { element: 0 })), 1));
    assert_eq!(update(&centres[..1], 0.7, 5.0), (Ok(Some(Reason::CountChanged { before: 2, now: 1 })), 0));
    assert_eq!(update(&[], 0.7, 5.0), (Ok(Some(Reason::CountChanged { before: 1, now: 0 })), 0));
    let (far, found) = update(&[[1e18, 0.0]], 0.7, 5.0);
    assert!(matches!(far, Err(Error::TooFarFromBox { index: 0, .. })) && found == 0, "{far:?}");
    assert_eq!(update(&centres, 0.7, 5.0), (Ok(Some(Reason::First)), 1), "an error leaves nothing behind");

    let elements = Elements::spheres(&centres, 0.2).unwrap();
    let mut none = PeriodicBuffered::new(0.0).unwrap();
    for reason in [Reason::First, Reason::BufferTooSmall, Reason::BufferTooSmall] {
        assert_eq!(none.update(&elements, &cell(4.0), &mut couples), Ok(Some(reason)));
    }
    assert!(matches!(PeriodicBuffered::<f64, 2>::new(-1.0), Err(Error::InvalidBuffer { .. })));
}
