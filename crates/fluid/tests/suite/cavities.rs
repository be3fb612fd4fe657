use fdem_fluid::*;

use crate::common::*;

fn cavities(fluid: Fluid) -> FlowModel<2> {
    FlowModel { connection: Connection::Cavities, ..FlowModel::new(fluid) }
}

/// A borehole at the first cell of a chain.
fn hole(volume: f64, pressure: Option<f64>, drive: Option<Drive>) -> Source {
    Source { key: 7, cells: vec![0], volume, drive, initial_pressure: pressure }
}

/// Cells that are connected with a hole have its pressure, `K ln(m/(ρ0 V))`; others stay dry.
#[test]
fn connected_cells_and_their_hole_have_one_pressure() {
    let mut mesh = chain(5, 0.1, 1e-3, [1.0, 0.0]);
    // A second chain, apart from the first one.
    let other = chain(3, 0.1, 1e-3, [0.0, 1.0]);
    mesh.cells.extend(other.cells.iter().map(|of| cell(of.key + 50, of.corners.map(|corner| corner + 50))));
    mesh.shapes.extend(other.shapes);
    let rate = Drive::Rate(Schedule::constant(1e-5));
    let mut network = mesh.network(cavities(liquid(2e9)), vec![hole(2e-3, Some(1e6), Some(rate))]);
    let (volume, hole) = (5.0 * 0.1 * 1e-3, 2e-3);
    // The fluid of the hole fills the cells only when 0.5 litres more are there.
    network.advance(1.0).expect("a step");
    assert_eq!(network.pressures(), [0.0; 8]);
    network.advance(59.0).expect("a step");
    let injected = 60.0 * 1e-5;
    let mass = 1000.0 * (injected + hole * (1e6_f64 / 2e9).exp());
    let pressure = 2e9 * (mass / (1000.0 * (volume + hole))).ln();
    let found = network.pressures();
    found[..5].iter().for_each(|found| assert_close(*found, pressure, 1e-7));
    assert_eq!(found[5..], [0.0; 3]);
    assert_close(network.injection(7).expect("a source").pressure, pressure, 1e-7);
    assert!(network.balance().error().abs() < 1e-12 * 1000.0 * injected);

    // Where the chains are joined, the fluid is shared by the volumes.
    mesh.cells[5].corners[0] = 5;
    network.renew(&mesh.cells, &mesh.shapes).expect("other corners");
    network.advance(10.0).expect("a step");
    assert_eq!(network.pressures(), [0.0; 8]);
    let saturation = network.saturations();
    assert!(saturation.iter().all(|of| (of - saturation[0]).abs() < 1e-12 && *of < 1.0), "{saturation:?}");
}

/// `p V^n` of a gas stays as the hole grows, and as a crack opens at it.
#[test]
fn gas_expands_by_its_exponent() {
    let state = StateEquation::Gas { density: 1.2, reference_pressure: 1e5, exponent: 1.3 };
    let fluid = Fluid { viscosity: 2e-5, state };
    let mut mesh = chain(4, 0.1, 1e-3, [1.0, 0.0]);
    mesh.shapes.iter_mut().for_each(|shape| shape.is_wet = false);
    let mut network = mesh.network(cavities(fluid), vec![hole(1e-3, Some(1e9), None)]);
    let pressure = |network: &Network<2>| network.injection(7).expect("a source").pressure;
    network.advance(1e-6).expect("a step");
    assert_close(pressure(&network), 1e9, 1e-12);
    network.set_source_volume(7, 2e-3).expect("a volume");
    network.advance(1e-6).expect("a step");
    assert_close(pressure(&network), 1e9 * 0.5_f64.powf(1.3), 1e-12);
    mesh.shapes[..3].iter_mut().for_each(|shape| shape.is_wet = true);
    network.update(&mesh.shapes).expect("shapes");
    network.advance(1e-6).expect("a step");
    let exact = 1e9 * (1e-3_f64 / (2e-3 + 3.0 * 1e-4)).powf(1.3);
    assert_close(pressure(&network), exact, 1e-12);
    let pressures = network.pressures();
    assert_eq!(pressures, [pressure(&network), pressure(&network), pressure(&network), 0.0]);
}

/// A gas flows by the cubic law, too: in the end the pressure is the same everywhere.
#[test]
fn gas_flows_into_a_crack_until_the_pressure_is_even() {
    let state = StateEquation::Gas { density: 1.2, reference_pressure: 1e5, exponent: 1.0 };
    let fluid = Fluid { viscosity: 2e-5, state };
    let mesh = chain(10, 0.01, 1e-3, [1.0, 0.0]);
    let mut network = mesh.network(FlowModel::new(fluid), vec![hole(1e-4, Some(1e7), None)]);
    advance(&mut network, 200, 1e-3);
    let exact = 1e7 * 1e-4 / (1e-4 + 10.0 * 1e-5);
    network.pressures().iter().for_each(|pressure| assert_close(*pressure, exact, 1e-6));
    assert!(network.balance().error().abs() < 1e-12 * network.balance().initial);
}
