//! Runs that continue with a changed model: excavation, boundaries that end.

use crate::common::*;
use fdem_simulation::*;

/// A square of rock under the stress of the ground, held all around.
pub(crate) fn ground() -> Model {
    let mesh = rectangle([0.0; 2], [1.0; 2], 12, 12);
    let around = nodes_where(&mesh, |[x, y]| [x, y].iter().any(|x| *x < 1e-9 || *x > 1.0 - 1e-9));
    Model {
        stresses: vec![[[-5e6, 1e6], [1e6, -8e6]]; mesh.elements.len()],
        materials: vec![Material { poissons_ratio: 0.25, damping: 0.3, friction: 0.6, ..granite() }],
        boundaries: vec![Boundary {
            name: "around".to_owned(),
            target: Target::Nodes(around),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        mesh,
        plane: Plane::Strain,
        ..Model::default()
    }
}

/// Whether elements are outside of a square tunnel in the middle.
fn outside(model: &Model) -> Vec<bool> {
    let inside = |nodes: &[u32; 3]| {
        let middle =
            |axis: usize| nodes.iter().map(|&node| model.mesh.nodes[node as usize][axis]).sum::<f64>() / 3.0;
        (0..2).all(|axis| (0.33..0.67).contains(&middle(axis)))
    };
    model.mesh.elements.iter().map(|nodes| !inside(nodes)).collect()
}

/// The run after 50 steps, after which the tunnel is excavated.
pub(crate) fn excavated(model: &Model, release: Option<Schedule>) -> Simulation {
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(50).expect("steps");
    let release = release.map(|release| ("tunnel".to_owned(), release));
    let change = Change::excavating(model, &outside(model), release).expect("a part");
    let (model, state) = run.state().changed(model, change, 1).expect("a changed run");
    Simulation::resume(model, state, 1).expect("a run")
}

fn fastest(run: &Simulation) -> f64 {
    run.snapshot().velocities.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
}

fn farthest(run: &Simulation) -> f64 {
    run.snapshot().displacements.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
}

/// The forces that held the rock continue to hold it: nothing moves. 1e-6 of the wave speed times the strain
/// would be 7e-7 m/s.
#[test]
fn held_ground_stays_at_rest() {
    let mut run = excavated(&ground(), Some(Schedule::Constant));
    assert_eq!(run.model().mesh.elements.len(), 2 * 144 - 32);
    run.advance(500).expect("steps");
    assert!(fastest(&run) < 1e-9, "{}", fastest(&run));
    assert!(run.energies().error().abs() < 1e-6, "{:?}", run.energies());
}

/// Released immediately, slowly, or in part: the same final convergence, or the same part of it.
#[test]
fn ground_converges_as_it_is_released() {
    let model = ground();
    let at_rest = |release: Option<Schedule>| {
        let mut model = model.clone();
        model.time.local_damping = 0.7;
        let mut run = excavated(&model, release);
        run.advance(6000).expect("steps");
        assert!(fastest(&run) < 1e-6, "{}", fastest(&run));
        assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
        farthest(&run)
    };
    let step = Simulation::new(model.clone(), 1).expect("a model").time_step();
    let whole = at_rest(None);
    assert!(whole > 1e-5, "{whole}");
    let ramp = at_rest(Some(Schedule::Table(vec![[0.0, 1.0], [2000.0 * step, 0.0]])));
    assert!((ramp / whole - 1.0).abs() < 1e-4, "{ramp} {whole}");
    let half = at_rest(Some(Schedule::Table(vec![[0.0, 1.0], [2000.0 * step, 0.5]])));
    assert!((half / whole - 0.5).abs() < 1e-2, "{half} {whole}");
}

/// A change that changes nothing keeps every bit, also of a model with broken and breaking joints and
/// contacts.
#[test]
fn a_change_of_nothing_changes_nothing() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::resume::crash(insertion);
        let mut run = Simulation::new(model.clone(), 1).expect("a model");
        run.advance(900).expect("steps");
        let elements = (0..model.mesh.elements.len() as u32).map(Some).collect();
        let change = Change { model: model.clone(), elements, release: None };
        let (model, state) = run.state().changed(&model, change, 1).expect("a changed run");
        let mut changed = Simulation::resume(model, state, 1).expect("a run");
        for steps in [0, 1, 600] {
            run.advance(steps).expect("steps");
            changed.advance(steps).expect("steps");
            assert_eq!(changed.snapshot(), run.snapshot(), "{insertion:?}");
            let [mut one, mut other] = [changed.energies(), run.energies()];
            for energies in [&mut one, &mut other] {
                // The energy of the vanishing parts, which is zero, is added.
                energies.external = 0.0;
            }
            assert_eq!(one, other);
        }
    }
}

/// A support that ends: the supported body falls, and the ground beneath it is relieved, as in a run without
/// it.
#[test]
fn a_boundary_that_ends_is_released() {
    let mesh = rectangle([0.0; 2], [0.2, 0.1], 4, 2);
    let top = nodes_where(&mesh, |[_, y]| y > 0.1 - 1e-9);
    let mut model = Model {
        materials: vec![granite()],
        boundaries: vec![Boundary {
            name: "hanger".to_owned(),
            target: Target::Nodes(top),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        mesh,
        gravity: [0.0, -10.0],
        ..Model::default()
    };
    model.time.local_damping = 0.8;
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(5000).expect("steps");
    let elements: Vec<Option<u32>> = (0..16).map(Some).collect();
    let free = Model { boundaries: Vec::new(), ..model.clone() };
    let change = |release| Change { model: free.clone(), elements: elements.clone(), release };
    let held = change(Some(("held".to_owned(), Schedule::Constant)));
    let (held, state) = run.state().changed(&model, held, 1).expect("a changed run");
    let mut held = Simulation::resume(held, state, 1).expect("a run");
    let before = farthest(&held);
    held.advance(1000).expect("steps");
    assert!((farthest(&held) / before - 1.0).abs() < 1e-6);
    let weight = 2700.0 * 0.02 * 10.0;
    let force = held.force(0).expect("the boundary that holds")[1];
    assert!((force / weight - 1.0).abs() < 1e-6, "{force}");
    let (free, state) = run.state().changed(&model, change(None), 1).expect("a changed run");
    let mut free = Simulation::resume(free, state, 1).expect("a run");
    free.advance(1000).expect("steps");
    assert!(farthest(&free) > 10.0 * before);
    assert!(free.energies().error().abs() < 1e-3, "{:?}", free.energies());
}

/// A body that appears: it begins as in a separate run.
#[test]
fn a_body_that_appears_falls() {
    let mesh = together(&[rectangle([0.0; 2], [0.2, 0.1], 4, 2), rectangle([0.0, 0.2], [0.1, 0.3], 2, 2)]);
    let whole = Model { materials: vec![granite()], mesh, gravity: [0.0, -10.0], ..Model::default() };
    let keep: Vec<bool> = whole.mesh.bodies.iter().map(|&body| body == 0).collect();
    let first = whole.keeping(&keep).expect("a part").model;
    let mut run = Simulation::new(first.clone(), 1).expect("a model");
    run.advance(100).expect("steps");
    let begin = run.time();
    let elements = (0..24).map(|element| (element < 16).then_some(element)).collect();
    let change = Change { model: whole, elements, release: None };
    let (model, state) = run.state().changed(&first, change, 1).expect("a changed run");
    let mut run = Simulation::resume(model, state, 1).expect("a run");
    run.advance(400).expect("steps");
    let fallen = run.snapshot().displacements.last().expect("a node")[1];
    let time = run.time() - begin;
    assert!((fallen / (-5.0 * time * time) - 1.0).abs() < 1e-2, "{fallen}");
    assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
}

/// Elements of another model, and elements that would hang on others which are there already.
#[test]
fn changes_that_do_not_fit_are_refused() {
    let model = ground();
    let run = Simulation::new(model.clone(), 1).expect("a model");
    let count = model.mesh.elements.len();
    let refused = |elements: Vec<Option<u32>>| {
        let change = Change { model: model.clone(), elements, release: None };
        run.state().changed(&model, change, 1).expect_err("a wrong change").to_string()
    };
    assert!(refused(vec![Some(0)]).contains("elements before"));
    assert!(refused((0..count as u32).rev().map(Some).collect()).contains("ascend"));
    assert!(refused((0..count as u32).map(|k| (k > 0).then_some(k)).collect()).contains("appears"));
    assert!(model.keeping(&[true]).is_err());
}

/// A bar that strikes a wall and becomes ten times softer meanwhile: the energy that the change removes is
/// external work, to the last half step.
#[test]
fn a_change_in_motion_keeps_the_balance() {
    let mesh = rectangle([0.0, 0.0], [1.0, 0.1], 20, 2);
    let wall = Boundary {
        name: "wall".to_owned(),
        target: Target::Nodes(nodes_where(&mesh, |[x, _]| x < 1e-9)),
        load: Load::Velocity([Some(0.0), None]),
        schedule: Schedule::Constant,
    };
    let hard = Model {
        velocities: vec![[-1.0, 0.0]; mesh.nodes.len()],
        materials: vec![granite()],
        boundaries: vec![wall],
        mesh,
        ..Model::default()
    };
    let soft = Material { youngs_modulus: 0.1 * granite().youngs_modulus, ..granite() };
    let mut run = Simulation::new(hard.clone(), 1).expect("a model");
    run.advance(40).expect("steps");
    let elements = (0..hard.mesh.elements.len() as u32).map(Some).collect();
    let change = Change { model: Model { materials: vec![soft], ..hard.clone() }, elements, release: None };
    let (model, state) = run.state().changed(&hard, change, 1).expect("a changed run");
    let mut run = Simulation::resume(model, state, 1).expect("a run");
    for _ in 0..20 {
        run.advance(7).expect("steps");
        let energies = run.energies();
        assert!(energies.error().abs() < 1e-6, "{energies:?}");
    }
    assert!(run.energies().external < -1.0, "{:?}", run.energies());
}
