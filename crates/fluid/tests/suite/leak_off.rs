use fdem_fluid::*;

use crate::common::*;

/// `4 A C_L √(t - t_c)` for each cell, by whatever steps.
#[test]
fn full_cells_leak_by_the_square_root_of_the_time() {
    for steps in [1, 7, 200] {
        let mut mesh = chain(6, 0.1, 1e-4, [1.0, 0.0]).full(1e6);
        let coefficient = |k: usize| 1e-6 * (1.0 + k as f64);
        mesh.cells.iter_mut().enumerate().for_each(|(k, cell)| cell.leak_off = coefficient(k));
        let thickness = 0.4;
        let model = FlowModel { thickness, ..FlowModel::new(liquid(2e9)) };
        let mut network = mesh.network(model, vec![held(1, &[0], 1e6)]);
        for _ in 0..steps {
            network.advance(100.0 / f64::from(steps)).expect("a step");
        }
        assert_eq!(network.saturations(), [1.0; 6]);
        let exact: f64 = (0..6).map(|k| 4.0 * 0.1 * thickness * coefficient(k) * 10.0).sum();
        assert_close(network.balance().leaked / 1000.0, exact, 1e-10);
        // Pressures fall a little along the chain, which stores less: nearly all of it was injected.
        assert_close(network.injection(1).expect("a source").injected, exact, 1e-3);
        assert!(network.balance().error().abs() < 1e-12 * 1000.0 * exact);
    }
}

/// The time counts from when fluid has reached a cell.
#[test]
fn the_time_of_leak_off_begins_with_the_fluid() {
    let mut mesh = chain(2, 0.1, 1e-4, [1.0, 0.0]);
    mesh.cells[1].leak_off = 1e-6;
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), vec![held(1, &[0], 1e6)]);
    network.advance(4.0).expect("a step");
    assert_eq!(network.wet_since(), [4.0; 2]);
    assert_eq!(network.balance().leaked, 0.0);
    assert_eq!(network.saturations(), [1.0; 2]);
    network.advance(9.0).expect("a step");
    assert_close(network.balance().leaked, 1000.0 * 4.0 * 0.1 * 1e-6 * 3.0, 1e-12);
}

/// A cell that is half full leaks through half of its faces.
#[test]
fn leak_off_is_that_of_the_filled_part() {
    let mut mesh = chain(1, 0.1, 1e-4, [1.0, 0.0]);
    mesh.cells[0].leak_off = 1e-7;
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), vec![pumped(1, &[0], 5e-6)]);
    network.advance(1.0).expect("a step");
    network.set_drive(1, None).expect("a source");
    assert_close(network.saturations()[0], 0.5, 1e-12);
    assert_eq!((network.apertures(), network.areas()), (vec![1e-4], vec![0.1]));
    network.advance(4.0).expect("a step");
    assert_close(network.balance().leaked, 1000.0 * 0.5 * 4.0 * 0.1 * 1e-7 * 2.0, 1e-12);
}

/// No more leaks off than there is.
#[test]
fn a_cell_that_has_leaked_off_is_empty() {
    let mut mesh = chain(3, 0.1, 1e-5, [1.0, 0.0]).full(1e5);
    mesh.cells.iter_mut().for_each(|cell| cell.leak_off = 1e-4);
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), Vec::new());
    advance(&mut network, 9, 10.0);
    assert_eq!(network.masses(), [0.0; 3]);
    assert_close(network.balance().leaked, network.balance().initial, 1e-12);
}

/// Injection at a table of rates into cells that cross, open, close and leak.
#[test]
fn no_mass_is_lost() {
    let mut mesh = sheet(10, 0.4, 1e-4);
    mesh.cells.iter_mut().for_each(|cell| cell.leak_off = 3e-6);
    let rate = Schedule::table(vec![1.0, 2.0, 30.0], vec![0.0, 3e-7, 1e-7]);
    let model = FlowModel { gravity: [3.0, -9.0, 0.0], ..FlowModel::new(liquid(2.2e9)) };
    let mut network = mesh.network(model, vec![at(5, &[90, 91], Drive::Rate(rate.clone()))]);
    for step in 0..60 {
        for (k, shape) in mesh.shapes.iter_mut().enumerate() {
            shape.opening = 1e-4 * (1.0 + 0.5 * random(k as u32 + 1000 * step));
        }
        network.update(&mesh.shapes).expect("shapes");
        network.advance(0.5).expect("a step");
        let balance = network.balance();
        assert!(balance.error().abs() <= 1e-12 * balance.injected, "{balance:?}");
        assert!(network.pressures().iter().all(|pressure| *pressure >= 0.0));
        assert!(network.masses().iter().all(|mass| *mass >= 0.0));
    }
    assert_close(network.balance().injected, 1000.0 * rate.integral(0.0, 30.0), 1e-12);
    assert!(network.balance().leaked > 0.0);
}
