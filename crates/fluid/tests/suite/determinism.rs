use fdem_fluid::*;

use crate::common::*;

/// A sheet of two layers at a right angle that fills at a table of rates, leaks, and moves.
fn case() -> (FlowModel<3>, Vec<Source>, Mesh<3>) {
    let mut mesh = sheet(8, 0.5, 1e-4);
    // Upright triangles on a row of edges in the middle: three cells at each.
    for i in 0..8 {
        let [a, b] = [4 * 9 + i, 4 * 9 + i + 1];
        let place = |number: u32| {
            let owner = mesh.cells.iter().zip(&mesh.shapes).find_map(|(cell, shape)| {
                cell.corners.iter().position(|corner| *corner == number).map(|k| shape.corners[k])
            });
            owner.expect("a vertex of the sheet")
        };
        let (pa, pb) = (place(a), place(b));
        let top = [0.5 * (pa[0] + pb[0]), 0.5 * (pa[1] + pb[1]), 0.01];
        mesh.cells.push(cell(1000 + u64::from(i), [a, b, 500 + i]));
        mesh.shapes.push(shape([pa, pb, top], 2e-4));
    }
    for (k, cell) in mesh.cells.iter_mut().enumerate() {
        cell.key = 7919 * (k as u64 + 1) % 1009;
        cell.leak_off = 1e-5;
    }
    let model = FlowModel { gravity: [0.0, -5.0, -8.0], ..FlowModel::new(liquid(2.2e9)) };
    let key = |k: usize| mesh.cells[k].key;
    let rate = Schedule::table(vec![0.0, 2.0, 5.0], vec![2e-8, 8e-8, 0.0]);
    let hole = Source {
        key: 3,
        cells: vec![key(40), key(41), key(42)],
        volume: 1e-7,
        drive: Some(Drive::Rate(rate)),
        initial_pressure: Some(1e5),
    };
    let sources = vec![hole, pumped(1, &[key(100)], 1e-8)];
    (model, sources, mesh)
}

/// The shapes after some steps: openings and corners have changed, cells have become wet.
fn moved(mesh: &Mesh<3>, step: u32) -> Vec<Shape<3>> {
    let shapes = mesh.cells.iter().zip(&mesh.shapes).map(|(cell, of)| {
        let at = cell.key as u32;
        let opening = of.opening * (1.0 + 0.2 * random(at + 17 * step));
        let is_wet = random(at) < 0.7 + 0.1 * f64::from(step / 4);
        let corners = of.corners.map(|place| place.map(|x| x * (1.0 + 1e-3 * f64::from(step))));
        let compliance = 1e-13 * random(at + 1);
        Shape { corners, opening, compliance, is_wet, ..*of }
    });
    shapes.collect()
}

/// Runs steps in the order of the cells, and returns the state.
fn run(network: &mut Network<3>, mesh: &Mesh<3>, steps: std::ops::Range<u32>) -> NetworkState {
    for step in steps {
        network.update(&moved(mesh, step)).expect("shapes");
        network.advance(0.4).expect("a step");
    }
    network.state().clone()
}

fn begin(mesh: &Mesh<3>) -> Network<3> {
    let (model, sources, _) = case();
    Network::new(model, sources, &mesh.cells, &moved(mesh, 0)).expect("a network")
}

/// All bits of a state.
fn bits(state: &NetworkState) -> Vec<u8> {
    postcard::to_allocvec(state).expect("bytes")
}

#[test]
fn two_runs_have_the_same_bits_and_keep_the_mass() {
    let (_, _, mesh) = case();
    let mut network = begin(&mesh);
    let state = run(&mut network, &mesh, 0..16);
    assert_eq!(bits(&state), bits(&run(&mut begin(&mesh), &mesh, 0..16)));
    let balance = network.balance();
    assert!(balance.leaked > 0.0 && balance.injected > 0.0, "{balance:?}");
    assert!(balance.error().abs() < 1e-12 * balance.injected, "{balance:?}");
    assert!(network.saturations().contains(&1.0));
    assert!(network.saturations().iter().any(|of| *of > 0.0 && *of < 1.0));
}

#[test]
fn the_order_of_the_cells_and_their_corners_numbers_change_no_bit() {
    let (_, _, mesh) = case();
    let state = run(&mut begin(&mesh), &mesh, 0..16);
    let mut order: Vec<usize> = (0..mesh.cells.len()).collect();
    order.sort_by_key(|k| (*k * 53) % mesh.cells.len());
    let mut other = Mesh { cells: Vec::new(), shapes: Vec::new() };
    for k in order {
        let corners = mesh.cells[k].corners.map(|corner| 9973 * (corner + 1) % 100_003);
        other.cells.push(Cell { corners, ..mesh.cells[k] });
        other.shapes.push(mesh.shapes[k]);
    }
    let mut network = begin(&other);
    assert_eq!(bits(&state), bits(&run(&mut network, &other, 0..16)));
    // Columns are in the order of the caller.
    let key = other.cells[5].key;
    let row = state.cells.binary_search(&key).expect("a cell");
    assert_eq!(network.pressures()[5], state.pressure[row]);
}

#[test]
fn a_saved_state_continues_with_the_same_bits() {
    let (_, _, mesh) = case();
    let whole = run(&mut begin(&mesh), &mesh, 0..16);
    let half = bits(&run(&mut begin(&mesh), &mesh, 0..9));
    let (model, sources, _) = case();
    let mut network = Network::new(model, sources, &mesh.cells, &moved(&mesh, 8)).expect("a network");
    network.restore(&postcard::from_bytes(&half).expect("a state")).expect("the same cells");
    assert_eq!(bits(network.state()), half);
    assert_eq!(bits(&run(&mut network, &mesh, 9..16)), bits(&whole));
}

/// A run on one processor has the bits of this list on all: operations are those of IEEE 754 and of `libm`.
#[test]
fn bits_are_those_of_any_processor() {
    let (_, _, mesh) = case();
    let state = run(&mut begin(&mesh), &mesh, 0..16);
    // FNV-1a.
    let hash = bits(&state).iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    assert_eq!(format!("{hash:016x}"), "26935e6eb3db478f");
}
