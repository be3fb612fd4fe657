//! Numbers of contacts that are known without a search: lattices, and the mean of a uniform gas.

use fdem_contact::{Elements, Engine, Error, PeriodicBox, PeriodicCouple, PeriodicSearch};
use fdem_scenes::random::Random;

use super::{ENGINES, at, displaced, found, shapes};
use crate::oracle::FromF64;

/// The smallest cut-off whose square is at least `squared`.
fn root<T: FromF64>(squared: f64) -> T {
    let mut root = T::from_f64(squared.sqrt());
    while (root * root).to_f64() < squared {
        root = T::at_least(root.to_f64() * (1.0 + T::EPSILON));
    }
    root
}

/// Every element of a lattice that fills the box has the coordination number of the lattice; in a small box
/// it touches itself.
fn coordination<T: FromF64, const D: usize>(basis: &[[f64; D]], squared: f64, coordination: usize) {
    for cells in [1, 2, 3, 4] {
        for origin in [0.0, -1.0, 0.5, 77.0] {
            let mut centres = vec![];
            let edge = 2 * cells;
            for k in 0..usize::pow(cells, D as u32) {
                for offset in basis {
                    let place = |axis: usize| (k / usize::pow(cells, axis as u32) % cells) as f64;
                    centres.push(std::array::from_fn(|axis| {
                        T::from_f64(origin + 2.0 * place(axis) + offset[axis])
                    }));
                }
            }
            let max = [T::from_f64(origin + edge as f64); D];
            let cell = PeriodicBox::orthogonal([T::from_f64(origin); D], max, [true; D]).unwrap();
            let elements = Elements::points(&centres, root::<T>(squared)).unwrap();
            for engine in ENGINES {
                let mut touching = vec![0; centres.len()];
                for couple in found(engine, &elements, &cell) {
                    touching[couple.i as usize] += 1;
                    touching[couple.j as usize] += 1;
                }
                assert!(
                    touching.iter().all(|&n| n == coordination),
                    "{engine:?}, {cells} cells: {touching:?}"
                );
            }
        }
    }
}

#[test]
fn lattices_have_their_coordination_numbers() {
    coordination::<f64, 1>(&[[0.0]], 4.0, 2);
    coordination::<f64, 2>(&[[0.0; 2]], 4.0, 4);
    coordination::<f32, 2>(&[[0.0; 2]], 4.0, 4);
    coordination::<f64, 2>(&[[0.0; 2]], 8.0, 8);
    coordination::<f64, 3>(&[[0.0; 3]], 4.0, 6);
    coordination::<f32, 3>(&[[0.0; 3]], 4.0, 6);
    let bcc = [[0.0; 3], [1.0; 3]];
    coordination::<f64, 3>(&bcc, 3.0, 8);
    coordination::<f32, 3>(&bcc, 3.0, 8);
    let fcc = [[0.0; 3], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
    coordination::<f64, 3>(&fcc, 2.0, 12);
    coordination::<f32, 3>(&fcc, 2.0, 12);
}

/// One element in the primitive cell of a lattice touches only its own images: half the coordination number
/// of couples.
#[test]
fn one_element_in_a_primitive_cell_touches_its_images() {
    let fcc = [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]];
    let bcc = [[1.0, 1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];
    for (edges, squared, couples) in [(fcc, 2.0, 6), (bcc, 3.0, 4), (fcc, 4.0, 9), (bcc, 4.0, 7)] {
        let cell = PeriodicBox::triclinic([0.0; 3], edges, [true; 3]).unwrap();
        let centre = [[0.25, -10.0, 30.5]];
        let elements = Elements::points(&centre, root::<f64>(squared)).unwrap();
        for engine in ENGINES {
            let found = found(engine, &elements, &cell);
            assert_eq!(found.len(), couples);
            assert!(found.iter().all(|couple| couple.i == 0 && couple.j == 0 && couple.shift > [0; 3]));
        }
    }
}

/// A hexagonal lattice, whose edges are irrational: six neighbours for any tilt that describes the same
/// lattice.
#[test]
fn every_basis_of_a_lattice_gives_the_same_contacts() {
    let height = 0.75_f64.sqrt();
    for tilt in -6..=6 {
        let edges = [[4.0, 0.0], [4.0 * (f64::from(tilt) + 0.5), 4.0 * height]];
        let cell = PeriodicBox::triclinic([0.1, -0.2], edges, [true, true]).unwrap();
        let centres: Vec<[f64; 2]> =
            (0..16).map(|k| [f64::from(k % 4) + 0.5 * f64::from(k / 4), f64::from(k / 4) * height]).collect();
        let elements = Elements::points(&centres, 1.0 + 1e-12).unwrap();
        for engine in ENGINES {
            assert_eq!(found(engine, &elements, &cell).len(), 48, "tilt {tilt}");
        }
    }
}

/// The mean number of couples of a uniform gas: `n (n - 1) / 2` times the volume of the ball over that of the
/// box, exact in periodic boxes of any shape, plus `n / 2` times the number of lattice points in the ball,
/// which is 0 for reaches below the shortest edge.
#[test]
fn a_uniform_gas_has_the_mean_number_of_couples() {
    let mut random = Random::new(23);
    let (n, gases) = (400_usize, 40);
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    for (shape, edges) in shapes::<3>() {
        let edges = edges.map(|edge| edge.map(|x| 8.0 * x));
        let cell = PeriodicBox::triclinic([-4.0; 3], edges, [true; 3]).unwrap();
        let volume = if shape == "unlike" {
            1.0 * 0.6 * 1.7
        } else if shape == "a rhombus" {
            0.75_f64.sqrt()
        } else {
            1.0
        } * 512.0;
        let mut couples = 0;
        for _ in 0..gases {
            let centres: Vec<[f64; 3]> =
                (0..n).map(|_| at(&edges, -4.0, std::array::from_fn(|_| random.uniform()))).collect();
            let elements = Elements::points(&centres, 1.0).unwrap();
            couples += PeriodicSearch::new().count(&elements, &cell).unwrap();
        }
        let mean = f64::from(gases) * (n * (n - 1)) as f64 / 2.0 * ball / volume;
        // Couples of a gas are nearly independent; the bound is five standard deviations.
        assert!((couples as f64 - mean).abs() < 5.0 * mean.sqrt(), "{shape}: {couples}, expected {mean}");
    }
}

/// The same cubic lattice by edges of growing skew: the same couples, displaced by the same distances.
#[test]
fn a_skewed_box_has_the_couples_of_its_lattice() {
    let mut random = Random::new(7);
    let points: Vec<[f64; 3]> =
        (0..60).map(|_| std::array::from_fn(|_| (random.uniform() * 6144.0).floor() / 1024.0)).collect();
    let elements = Elements::points(&points, 1.5).unwrap();
    let displacements = |m: f64, engine: Option<Engine>| {
        let edges = [[6.0, 0.0, 0.0], [6.0 * m, 6.0, 0.0], [6.0 * (m / 2.0).floor(), 6.0 * m, 6.0]];
        let cell = PeriodicBox::triclinic([0.0; 3], edges, [true; 3]).unwrap();
        let mut couples = found(engine, &elements, &cell);
        couples.sort_unstable();
        let mut placed: Vec<(u32, u32, [i64; 3])> = Vec::new();
        for PeriodicCouple { i, j, shift } in couples {
            let image = displaced(&points[j as usize], &shift, &edges);
            let apart: [f64; 3] = std::array::from_fn(|k| image[k] - points[i as usize][k]);
            assert!(apart.iter().map(|x| x * x).sum::<f64>() <= 2.25, "{i} {j} {shift:?} at m = {m}");
            // Coordinates are multiples of 1/1024, so all sums are exact.
            placed.push((i, j, apart.map(|x| (x * 1024.0) as i64)));
        }
        placed.sort_unstable();
        placed
    };
    for engine in ENGINES {
        let cube = displacements(0.0, engine);
        assert!(cube.len() > 60);
        for m in [5.0, 50.0, 1000.0] {
            assert_eq!(displacements(m, engine), cube, "m = {m}");
        }
    }
}

/// Atoms that touch their own images, in the form of a couple: the first nonzero number is positive.
#[test]
fn own_images_in_a_skewed_box_have_positive_shifts() {
    let cell = PeriodicBox::triclinic([0.0; 2], [[1.0, 0.0], [-50.0, 1.0]], [true; 2]).unwrap();
    let mut couples = found(None, &Elements::points(&[[0.25, 0.25]], 1.0).unwrap(), &cell);
    couples.sort_unstable();
    let shifts: Vec<[i32; 2]> = couples.iter().map(|couple| couple.shift).collect();
    assert_eq!(shifts, [[1, 0], [50, 1]]);
}

/// With [`PeriodicSearch::refuse_outside`], the given box decides which elements are outside, not its short
/// edges.
#[test]
fn elements_are_outside_of_the_given_box() {
    let cell = PeriodicBox::triclinic([0.0; 2], [[1.0, 0.0], [50.0, 1.0]], [true; 2]).unwrap();
    let mut search = PeriodicSearch::new().refuse_outside();
    let mut refused = |point: [f64; 2]| {
        search.couples(&Elements::points(&[point], 0.25).unwrap(), &cell, &mut Vec::new()).err()
    };
    assert_eq!(refused([25.5, 0.5]), None);
    assert!(matches!(refused([0.5, 0.5]), Some(Error::OutsideBox { index: 0, edge: 0, .. })));
}
