use fdem_fluid::*;

use crate::common::*;

/// At a constant rate the front is at `x = Q t/(a b)`, with steps in which it passes parts of a cell or many.
#[test]
fn the_front_is_where_its_volume_is() {
    for (cells_per_step, count) in [(0.37, 100), (3.1, 14), (40.0, 1)] {
        let (length, opening, rate) = (0.01, 1e-4, 2e-7);
        let mesh = chain(60, length, opening, [1.0, 0.0]);
        let mut network = mesh.network(FlowModel::new(liquid(2.2e9)), vec![pumped(1, &[0], rate)]);
        let step = cells_per_step * length * opening / rate;
        for _ in 0..count {
            network.advance(step).expect("a step");
            let front = rate * network.time() / (opening * length);
            let saturations = network.saturations();
            let filled = saturations.iter().filter(|of| **of == 1.0).count() as f64;
            assert!((filled - front).abs() <= 1.0, "{filled} of {front} cells");
            assert!(saturations.iter().filter(|of| **of > 0.0 && **of < 1.0).count() <= 1);
        }
        let balance = network.balance();
        assert!(balance.error().abs() < 1e-12 * balance.injected, "{balance:?}");
        assert_close(balance.injected, 1000.0 * rate * network.time(), 1e-12);
        // Behind the front the pressure falls by the cubic law.
        let pressures = network.pressures();
        let fall = 12.0 * 1e-3 * rate * length / opening.powi(3);
        if count > 1 {
            assert_close(pressures[3] - pressures[4], fall, 1e-2);
        }
    }
}

/// A cell that opens wider than its fluid has the pressure of cavitation, until it is full again.
#[test]
fn a_cell_that_opens_faster_than_it_fills_lags() {
    let mut mesh = chain(3, 0.01, 1e-4, [1.0, 0.0]).full(1e6);
    let fluid = Fluid {
        state: StateEquation::Liquid {
            density: 1000.0,
            reference_pressure: 0.0,
            bulk_modulus: 2e9,
            cavitation_pressure: -5e4,
        },
        ..liquid(2e9)
    };
    let mut network = mesh.network(FlowModel::new(fluid), vec![pumped(1, &[0], 1e-8)]);
    mesh.shapes.iter_mut().for_each(|shape| shape.opening = 2e-4);
    network.update(&mesh.shapes).expect("shapes");
    network.advance(1e-3).expect("a step");
    assert_eq!(network.pressures(), [-5e4; 3]);
    let saturation = network.saturations()[2];
    assert_close(saturation, 0.5 * (1.05e6_f64 / 2e9).exp(), 1e-12);
    // Half of the cells is empty: 3 cells of 0.01 m by 0.1 mm, at 10 mm³/s.
    let time = 3.0 * 0.01 * 1e-4 / 1e-8;
    advance(&mut network, 11, time / 10.0);
    assert!(network.pressures().iter().all(|pressure| *pressure > 1e5), "{:?}", network.pressures());
    assert_eq!(network.saturations(), [1.0; 3]);
    // Walls that close press the fluid.
    mesh.shapes.iter_mut().for_each(|shape| shape.opening *= 0.999);
    let before = network.pressures();
    network.update(&mesh.shapes).expect("shapes");
    network.set_drive(1, None).expect("a source");
    network.advance(1e-9).expect("a step");
    for (before, after) in before.iter().zip(network.pressures()) {
        assert_close(after - before, 2e9 * -(0.999_f64.ln()), 1e-3);
    }
}

/// Fluid that does not fill its cells runs down, collects at the bottom, and never is less than none.
#[test]
fn fluid_runs_down_and_collects() {
    for steps in [1, 10, 1000] {
        let mesh = chain(40, 0.1, 1e-4, [0.0, -1.0]);
        let model = FlowModel { gravity: [0.0, -9.81], ..FlowModel::new(liquid(2e9)) };
        let (first, middle) = (pumped(1, &[0], 1e-7), pumped(2, &[20], 1e-7));
        let mut network = mesh.network(model, vec![first, middle]);
        network.advance(100.0).expect("a step");
        network.set_drive(1, None).expect("a source");
        network.set_drive(2, None).expect("a source");
        for _ in 0..steps {
            network.advance(1e5 / f64::from(steps)).expect("a step");
            assert!(network.masses().iter().all(|mass| *mass >= 0.0));
            let balance = network.balance();
            assert!(balance.error().abs() < 1e-12 * balance.injected, "{balance:?}");
        }
        // 20 cm³ in cells of 10 cm³.
        let saturations = network.saturations();
        assert!(saturations[38] > 0.9 && saturations[39] == 1.0, "{saturations:?}");
        let below = network.pressures()[39];
        assert!((0.0..1.5e3).contains(&below), "{below}");
    }
}

/// A full chain runs out at its lower end, and the upper one empties.
#[test]
fn a_chain_runs_out() {
    for steps in [3, 300] {
        let mesh = chain(20, 0.1, 1e-4, [0.0, -1.0]).full(1e5);
        let model = FlowModel { gravity: [0.0, -9.81], ..FlowModel::new(liquid(2e9)) };
        let mut network = mesh.network(model, vec![held(1, &[19], 0.0)]);
        for _ in 0..steps {
            network.advance(2e4 / f64::from(steps)).expect("a step");
            assert!(network.masses().iter().all(|mass| *mass >= 0.0));
        }
        let balance = network.balance();
        assert!(balance.error().abs() < 1e-12 * balance.initial, "{balance:?}");
        let saturations = network.saturations();
        assert!(saturations[..19].iter().all(|of| *of < 0.05), "{saturations:?}");
    }
}

/// A pump that takes out more than there is leaves cells empty, and the rest is missed.
#[test]
fn a_pump_cannot_take_out_more_than_there_is() {
    let mesh = chain(5, 0.1, 1e-4, [1.0, 0.0]).full(1e5);
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), vec![pumped(1, &[2], -1e-6)]);
    advance(&mut network, 20, 10.0);
    let balance = network.balance();
    assert!(balance.missed > 0.0 && balance.error().abs() < 1e-12 * balance.initial, "{balance:?}");
    assert_close(balance.missed - balance.injected, 1000.0 * 1e-6 * 200.0, 1e-12);
    assert_eq!(network.masses()[2], 0.0);
    assert!(network.pressures().iter().all(|pressure| *pressure < 1.0));
}

/// With compliant walls the pressure of an injected volume is `ΔV/(V/K + A c)`, and walls that have moved as
/// the compliance says leave it.
#[test]
fn compliance_is_part_of_the_storage() {
    let mut mesh = chain(1, 0.1, 1e-4, [1.0, 0.0]).full(1e6);
    let compliance = 1e-12;
    mesh.shapes[0].compliance = compliance;
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), vec![pumped(1, &[0], 1e-9)]);
    network.advance(1.0).expect("a step");
    let rise = network.pressures()[0] - 1e6;
    assert_close(rise, 1e-9 / (1e-5 / 2e9 + 0.1 * compliance), 0.01);
    network.set_drive(1, None).expect("a source");
    mesh.shapes[0].opening += compliance * rise;
    network.update(&mesh.shapes).expect("shapes");
    network.advance(1.0).expect("a step");
    assert_close(network.pressures()[0], 1e6 + rise, 1e-7);
}

/// Both schemes fill alike.
#[test]
fn the_explicit_scheme_agrees() {
    let mesh = sheet(6, 0.3, 1e-5);
    let run = |scheme| {
        let model = FlowModel { scheme, gravity: [0.0, -9.81, 0.0], ..FlowModel::new(liquid(1e7)) };
        let mut network = mesh.network(model, vec![pumped(1, &[30], 1e-8)]);
        advance(&mut network, 40, 2e-3);
        assert!(network.balance().error().abs() < 1e-12 * network.balance().injected);
        network
    };
    let [implicit, explicit] = [Scheme::Implicit, Scheme::Explicit].map(run);
    let most = implicit.pressures().iter().copied().fold(0.0, f64::max);
    assert!(most > 0.0);
    for (a, b) in implicit.pressures().iter().zip(explicit.pressures()) {
        assert!((a - b).abs() < 0.05 * most, "{a} {b} of {most}");
    }
}
