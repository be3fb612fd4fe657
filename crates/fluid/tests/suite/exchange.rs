//! Cracks at the surface of pores.

use std::f64::consts::PI;

use crate::common::{assert_close, cell, held, shape};
use crate::matrix::square;
use fdem_fluid::*;

/// A body of `k` by `k` squares with pores, 1 m wide, a crack of `k` cells along its side x = 0, and the
/// shapes of these.
fn cracked(
    k: u32,
    bulk_modulus: f64,
    filled: Option<f64>,
    sources: Vec<Source>,
    initial: f64,
) -> (Network<2>, PorousMatrix<2, 3>, Vec<Shape<2>>) {
    let body = square(k, 0.0);
    let matrix = body.matrix(Vec::new(), &vec![initial; body.places.len()]);
    let cells: Vec<Cell<2>> = (0..k)
        .map(|j| Cell { initial_pressure: filled, ..cell(u64::from(j), [j, j + 1].map(|j| j * (k + 1))) })
        .collect();
    let at = |vertex: u32| body.places[vertex as usize];
    let shapes: Vec<Shape<2>> = cells.iter().map(|cell| shape(cell.corners.map(at), 1e-4)).collect();
    let state = StateEquation::Liquid {
        density: 998.0,
        reference_pressure: 0.0,
        bulk_modulus,
        cavitation_pressure: 0.0,
    };
    let fluid = Fluid { viscosity: 1e-3, state };
    let network = Network::new(FlowModel::new(fluid), sources, &cells, &shapes).expect("a network");
    (network, matrix, shapes)
}

/// Takes steps, and checks both masses after each.
fn step(
    (network, matrix, shapes): &mut (Network<2>, PorousMatrix<2, 3>, Vec<Shape<2>>),
    length: f64,
    steps: u32,
) {
    for _ in 0..steps {
        network.update(shapes).expect("shapes");
        network.advance(length).expect("a step");
        exchange(network, matrix).expect("an exchange");
        matrix.advance(length).expect("a step");
    }
    let (of_cracks, of_pores) = (network.balance(), matrix.balance());
    let whole = of_cracks.initial + of_cracks.injected.abs() + of_cracks.leaked.abs();
    assert!(of_cracks.error().abs() < 1e-12 * whole, "{of_cracks:?}");
    assert!(of_pores.error().abs() < 1e-12 * of_pores.moved, "{of_pores:?}");
    assert_close(of_cracks.leaked, 998.0 * of_pores.exchanged, 1e-12);
}

/// The volume that a column takes from a crack at a constant pressure: `S p (1 - Σ 2/m² exp(-m² c t))`, `m =
/// (k + 1/2) π`, with a storage of 1e-10 1/Pa and a diffusivity of 0.1 m²/s.
#[test]
fn a_crack_at_a_pressure_fills_a_column() {
    let all: Vec<u64> = (0..20).collect();
    let mut both = cracked(20, 2.2e9, Some(1e6), vec![held(0, &all, 1e6)], 0.0);
    // Walls that give way, as a solid does: the capacity of the crack is not far below that of pores.
    both.2.iter_mut().for_each(|shape| shape.compliance = 5e-12);
    let mut last = 0.0;
    for time in [0.3, 1.0] {
        step(&mut both, 5e-4, ((time - last) / 5e-4_f64).round() as u32);
        last = time;
        let term = |k: u32| {
            let m = (f64::from(k) + 0.5) * PI;
            2.0 / (m * m) * (-m * m * 0.1 * time).exp()
        };
        let exact = 1e-10 * 1e6 * (1.0 - (0..40).map(term).sum::<f64>());
        assert_close(both.1.balance().exchanged, exact, 0.02);
    }
}

/// A closed crack and its pores come to one pressure, and no pressure overshoots.
#[test]
fn a_crack_and_pores_level_out() {
    for bulk_modulus in [2.2e9, 2.2e7] {
        let mut both = cracked(8, bulk_modulus, Some(1e6), Vec::new(), 2e5);
        let mut before = 1e6;
        for _ in 0..20 {
            step(&mut both, 1.0, 10);
            let highest = both.0.pressures().into_iter().fold(0.0, f64::max);
            let lowest = both.1.pressures().iter().fold(f64::MAX, |least, p| least.min(*p));
            assert!(highest <= before * (1.0 + 1e-9) && lowest > 2e5 * (1.0 - 1e-9), "{highest} {lowest}");
            before = highest;
        }
        let level = both.1.pressures()[0];
        assert!(both.1.pressures().iter().all(|p| (p / level - 1.0).abs() < 1e-6), "{level}");
        assert!(both.0.pressures().iter().all(|p| (p / level - 1.0).abs() < 1e-6), "{level}");
        // 1e-4 m² of the crack at 1e6 Pa, 1e-10 m²/Pa of pores at 2e5 Pa.
        let crack = 1e-4 / bulk_modulus;
        let mean = (crack * 1e6 + 1e-10 * 2e5) / (crack + 1e-10);
        assert!((level / mean - 1.0).abs() < 0.1 && level > 2e5, "{level} {mean}");
    }
}

/// Pores drain into a crack that is empty, and fill a part of it.
#[test]
fn pores_drain_into_an_empty_crack() {
    let mut both = cracked(8, 2.2e9, None, Vec::new(), 2e5);
    step(&mut both, 1.0, 300);
    assert!(both.1.pressures().iter().all(|p| (0.0..2e3).contains(p)), "{:?}", both.1.pressures());
    assert!(both.0.pressures().iter().all(|p| *p == 0.0));
    // 1e-10 m²/Pa times 2e5 Pa, in 1e-4 m².
    let filled: f64 = both.0.saturations().iter().sum::<f64>() / 8.0;
    assert!((filled - 0.2).abs() < 0.005, "{filled}");
}

#[test]
fn a_corner_without_pores_is_refused() {
    let (mut network, _, _) = cracked(8, 2.2e9, None, Vec::new(), 0.0);
    let mut small = square(2, 0.0).matrix(Vec::new(), &[]);
    assert!(exchange(&mut network, &mut small).expect_err("no vertex").to_string().contains("corner"));
}
