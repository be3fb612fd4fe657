use fdem_fluid::*;

use crate::common::*;

/// The text of the error of a model that is refused.
fn refused(model: FlowModel<2>, sources: Vec<Source>, mesh: &Mesh<2>) -> String {
    Network::new(model, sources, &mesh.cells, &mesh.shapes).expect_err("refused").to_string()
}

fn model() -> FlowModel<2> {
    FlowModel::new(liquid(2e9))
}

fn mesh() -> Mesh<2> {
    chain(4, 0.1, 1e-4, [1.0, 0.0])
}

#[test]
fn bad_numbers_are_named() {
    for viscosity in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        let text = refused(FlowModel::new(Fluid { viscosity, ..liquid(2e9) }), Vec::new(), &mesh());
        assert!(text.starts_with("fluid: viscosity is"), "{text}");
    }
    let text = refused(FlowModel { gravity: [0.0, f64::NAN], ..model() }, Vec::new(), &mesh());
    assert!(text.starts_with("model: gravity is NaN"), "{text}");
    let change = |change: &dyn Fn(&mut Mesh<2>)| {
        let mut mesh = mesh();
        change(&mut mesh);
        refused(model(), Vec::new(), &mesh)
    };
    for (found, expected) in [
        (change(&|mesh| mesh.shapes[2].opening = f64::NAN), "cell 2: opening is NaN"),
        (change(&|mesh| mesh.shapes[2].opening = -1e-5), "cell 2: opening is -1e-5"),
        (change(&|mesh| mesh.shapes[1].corners[0][1] = f64::INFINITY), "cell 1: coordinate of a corner"),
        (
            change(&|mesh| mesh.shapes[1].corners[0] = mesh.shapes[1].corners[1]),
            "the corners of cell 1 span no",
        ),
        (change(&|mesh| mesh.cells[3].law.residual = 0.0), "cell 3: residual aperture is 0e0"),
        (change(&|mesh| mesh.cells[3].law.largest = 1e-10), "cell 3: largest aperture"),
        (change(&|mesh| mesh.cells[3].leak_off = -1.0), "cell 3: leak-off coefficient is -1e0"),
        (change(&|mesh| mesh.cells[3].initial_pressure = Some(-1.0)), "cell 3: initial pressure is -1e0"),
        (change(&|mesh| mesh.cells[3].key = 0), "there are two of cell 0"),
        (change(&|mesh| mesh.cells[3].corners = [8, 8]), "cell 3 has corner 8 twice"),
        (change(&|mesh| mesh.shapes.truncate(3)), "3 shapes instead of 4"),
    ] {
        assert!(found.starts_with(expected), "{found}");
    }
}

#[test]
fn sources_without_place_or_at_one_cell_are_refused() {
    let of = |sources| refused(model(), sources, &mesh());
    assert_eq!(of(vec![pumped(1, &[9], 1.0)]), "source 1: there is no cell 9");
    assert_eq!(of(vec![pumped(1, &[], 1.0)]), "source 1 has neither cells nor a volume");
    let both = vec![pumped(1, &[0, 2], 1.0), held(2, &[2], 1.0)];
    assert_eq!(of(both), "sources 1 and 2 both act on cell 2");
    assert_eq!(of(vec![pumped(4, &[0], 1.0), held(4, &[2], 1.0)]), "there are two of source 4");
    assert!(of(vec![held(1, &[0], -5.0)]).starts_with("source 1: pressure is -5e0"));
    assert!(of(vec![pumped(1, &[0], f64::NAN)]).starts_with("source 1: rate is NaN"));
    let table = Schedule::table(vec![0.0, 0.0], vec![1.0, 2.0]);
    assert!(of(vec![at(1, &[0], Drive::Rate(table))]).starts_with("source 1: time of the table"));
    let table = Schedule::table(vec![0.0, 1.0], vec![1.0]);
    assert_eq!(of(vec![at(1, &[0], Drive::Rate(table))]), "1 values of a table instead of 2");
}

#[test]
fn injection_where_nothing_is_wet_is_refused() {
    let mut mesh = mesh();
    mesh.shapes[0].is_wet = false;
    for source in [pumped(1, &[0], 1e-6), held(1, &[0], 1e6)] {
        let mut network = mesh.network(model(), vec![source]);
        let error = network.advance(1.0).expect_err("refused");
        assert_eq!(error, FluidError::Unconnected { source: 1 });
        assert_eq!(network.time(), 0.0);
    }
    // A hole of its own can be filled.
    let hole = Source { volume: 1e-3, ..pumped(1, &[0], 1e-6) };
    let mut network = mesh.network(model(), vec![hole]);
    network.advance(1.0).expect("a step");
    assert_eq!(network.balance().stored, 1e-3);
    // A pump that does not run needs no cell.
    mesh.network(model(), vec![pumped(1, &[0], 0.0)]).advance(1.0).expect("a step");
}

#[test]
fn two_pressures_in_one_cavity_are_refused() {
    let model = FlowModel { connection: Connection::Cavities, ..model() };
    let mut network = mesh().network(model, vec![held(8, &[3], 1e6), held(5, &[0], 2e6)]);
    let error = network.advance(1.0).expect_err("refused");
    assert_eq!(error, FluidError::SharedCavity { sources: [5, 8] });
}

#[test]
fn steps_and_shapes_that_cannot_be_are_refused_and_change_nothing() {
    let mut mesh = mesh().full(1e5);
    let mut network = mesh.network(model(), vec![pumped(1, &[0], 1e-6)]);
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(network.advance(step).is_err(), "{step}");
    }
    let before = network.state().clone();
    mesh.shapes[2].is_wet = false;
    let text = network.update(&mesh.shapes).expect_err("refused").to_string();
    assert!(text.starts_with("cell 2 holds 1.00"), "{text}");
    // More fluid than any pressure presses into the walls.
    let error = network.advance(1e200).expect_err("refused");
    assert!(
        matches!(error, FluidError::NotConverged { what: "cell", .. } | FluidError::Pivot { .. }),
        "{error}"
    );
    assert_eq!(*network.state(), before);
    network.advance(1e-3).expect("a step");
}

#[test]
fn states_of_other_networks_are_refused() {
    let network = mesh().network(model(), Vec::new());
    let mut other = chain(5, 0.1, 1e-4, [1.0, 0.0]).network(model(), Vec::new());
    assert!(other.restore(network.state()).is_err());
    let mut state = other.state().clone();
    state.mass.pop();
    assert!(other.restore(&state).is_err());
    let mut state = other.state().clone();
    state.pressure[1] = f64::NAN;
    assert!(other.restore(&state).is_err());
}

#[test]
fn the_explicit_scheme_has_rigid_walls() {
    let mut mesh = mesh();
    mesh.shapes[1].compliance = 1e-12;
    let model = FlowModel { scheme: Scheme::Explicit, ..model() };
    assert!(refused(model, Vec::new(), &mesh).starts_with("cell 1: compliance is 1e-12"));
}

#[test]
fn an_explicit_step_has_a_million_parts_at_most() {
    let model = FlowModel { scheme: Scheme::Explicit, ..model() };
    let mut network = mesh().network(model, vec![held(1, &[0], 1e6)]);
    let bound = network.explicit_bound().expect("a bound");
    // Two arms of 5 cm, at two of its corners: V/(K Σ T), with V = 1e-5 m³ and T = a³/(12 μ 0.1).
    assert!((bound / (1e-5 / (2e9 * 2.0 * 1e-12 / (12e-3 * 0.1))) - 1.0).abs() < 1e-3, "{bound:e}");
    let text = network.advance(1e7 * bound).expect_err("refused").to_string();
    assert!(text.contains("number of parts of an explicit step"), "{text}");
}
