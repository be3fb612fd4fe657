use fdem_fluid::*;

use crate::common::*;

#[test]
fn cells_keep_their_fluid_when_others_are_added() {
    let whole = chain(6, 0.1, 1e-4, [1.0, 0.0]).full(1e6);
    let first = Mesh { cells: whole.cells[1..4].to_vec(), shapes: whole.shapes[1..4].to_vec() };
    let mut network = first.network(FlowModel::new(liquid(2e9)), vec![pumped(1, &[2], 1e-9)]);
    network.advance(1.0).expect("a step");
    let before = network.balance();
    // New ones are in front, as a mesh may number them, and empty.
    let mut cells = whole.cells.clone();
    for k in [0, 4, 5] {
        cells[k].initial_pressure = None;
    }
    network.renew(&cells, &whole.shapes).expect("more cells");
    assert_eq!(network.balance(), before);
    assert_eq!(network.masses()[0], 0.0);
    network.advance(1.0).expect("a step");
    let balance = network.balance();
    assert_eq!(balance.initial, before.initial);
    assert!(balance.error().abs() < 1e-12 * balance.initial, "{balance:?}");
    assert!(network.masses()[0] > 0.0 && network.masses()[4] > 0.0, "{:?}", network.masses());
}

/// A corner that has split no longer connects its cells; one that closes does again.
#[test]
fn corners_that_split_divide_the_network() {
    let mut mesh = chain(4, 0.1, 1e-4, [1.0, 0.0]).full(1e6);
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), vec![held(1, &[0], 3e6)]);
    network.advance(1e3).expect("a step");
    network.pressures().iter().for_each(|pressure| assert_close(*pressure, 3e6, 1e-6));
    mesh.cells[2].corners[0] = 99;
    network.renew(&mesh.cells, &mesh.shapes).expect("other corners");
    let before = network.balance();
    network.set_drive(1, Some(Drive::Pressure(Schedule::constant(5e6)))).expect("a source");
    network.advance(1e3).expect("a step");
    for (pressure, exact) in network.pressures().into_iter().zip([5e6, 5e6, 3e6, 3e6]) {
        assert_close(pressure, exact, 1e-6);
    }
    let injected = network.balance().injected - before.injected;
    assert_close(network.balance().stored - before.stored, injected, 1e-9);
}

#[test]
fn cells_with_fluid_cannot_be_lost_but_drained() {
    let mesh = chain(4, 0.1, 1e-4, [1.0, 0.0]).full(1e6);
    let mut network = mesh.network(FlowModel::new(liquid(2e9)), Vec::new());
    let rest = Mesh { cells: mesh.cells[..3].to_vec(), shapes: mesh.shapes[..3].to_vec() };
    let error = network.renew(&rest.cells, &rest.shapes).expect_err("a cell is missing");
    assert!(matches!(error, FluidError::MassLost { key: 3, .. }), "{error}");
    let mass = network.masses()[3];
    assert_eq!(network.drain(&[3, 3]).expect("a cell"), mass);
    network.renew(&rest.cells, &rest.shapes).expect("fewer cells");
    assert_eq!(network.balance().drained, mass);
    assert!(network.balance().error().abs() < 1e-15);
    assert!(network.drain(&[77]).is_err());
}
