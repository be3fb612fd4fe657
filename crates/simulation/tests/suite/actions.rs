use crate::common::*;
use crate::resume::crash;
use fdem_distributed::{Communicator, threads};
use fdem_simulation::*;

/// A bar whose left end is held, at rest.
fn bar() -> Model {
    let mesh = rectangle([0.0, 0.0], [1.0, 0.1], 20, 2);
    let held = |name: &str, load| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(nodes_where(&mesh, |[x, _]| x < 1e-9)),
        load,
        schedule: Schedule::Constant,
    };
    Model {
        boundaries: vec![held("wall", Load::Velocity([Some(0.0), Some(0.0)]))],
        mesh,
        materials: vec![granite()],
        ..Model::default()
    }
}

fn right(model: &Model) -> Vec<u32> {
    nodes_where(&model.mesh, |[x, _]| x > 1.0 - 1e-9)
}

/// A pull by forces of the caller is that of a boundary with the same force: motion, energies, external work.
#[test]
fn forces_do_the_work_of_a_boundary_with_forces() {
    let plain = bar();
    let nodes = right(&plain);
    let mut loaded = plain.clone();
    loaded.boundaries.push(Boundary {
        name: "pull".to_owned(),
        target: Target::Nodes(nodes.clone()),
        load: Load::Force([3e6, 0.0]),
        schedule: Schedule::Constant,
    });
    let mut by_boundary = Simulation::new(loaded, 1).expect("a model");
    let mut by_caller = Simulation::new(plain, 2).expect("a model");
    by_caller.set_forces(&nodes, &vec![[1e6, 0.0]; nodes.len()]).expect("nodes");
    by_boundary.advance(500).expect("steps");
    by_caller.advance(500).expect("steps");
    assert_eq!(nodes.len(), 3);
    let [one, other] = [by_boundary.snapshot(), by_caller.snapshot()];
    for (one, other) in one.displacements.iter().zip(&other.displacements) {
        assert!((one[0] - other[0]).abs() < 1e-12, "{one:?} {other:?}");
    }
    let [one, other] = [by_boundary.energies(), by_caller.energies()];
    assert!((one.external / other.external - 1.0).abs() < 1e-9 && other.external > 1.0, "{one:?} {other:?}");
    assert!(other.error().abs() < 1e-3, "{other:?}");
    // They stay until they are taken away, and belong to no boundary.
    let pulled = by_caller.forces().reactions[nodes[0] as usize];
    assert!((pulled[0] - 1e6).abs() < 1e-3, "{pulled:?}");
    assert!(by_caller.force(1).is_none());
    by_caller.clear_forces();
    by_caller.advance(1).expect("a step");
    assert_eq!(by_caller.forces().reactions[nodes[0] as usize], [0.0; 2]);
}

#[test]
fn a_change_of_velocities_is_external_work() {
    let model = bar();
    let all: Vec<u32> = (0..model.mesh.nodes.len() as u32).collect();
    let mut run = Simulation::new(Model { boundaries: Vec::new(), ..model }, 1).expect("a model");
    run.advance(50).expect("steps");
    run.set_velocities(&all, &vec![[2.0, 0.0]; all.len()]).expect("nodes");
    run.advance(100).expect("steps");
    let expected = 0.5 * 2700.0 * 0.1 * 4.0;
    let energies = run.energies();
    assert!((energies.kinetic / expected - 1.0).abs() < 1e-9, "{energies:?}");
    assert!((energies.external / expected - 1.0).abs() < 1e-9, "{energies:?}");
}

/// A law of the caller that sets velocities before each step keeps the balance as well as a boundary with the
/// same velocities, over thousands of steps under stress.
#[test]
fn velocities_that_are_set_in_each_step_keep_the_balance() {
    let model = bar();
    let nodes = right(&model);
    let mut run = Simulation::new(model, 1).expect("a model");
    for step in 0..3000 {
        let speed = 0.5 * libm::sin(f64::from(step) * 0.01);
        run.set_velocities(&nodes, &vec![[speed, 0.0]; nodes.len()]).expect("nodes");
        run.advance(1).expect("a step");
        let energies = run.energies();
        assert!(
            step < 100 || energies.error().abs() < 1e-4,
            "step {step}: {energies:?} {}",
            energies.error()
        );
    }
    let energies = run.energies();
    assert!(energies.exchanged > 1.0, "{energies:?}");
}

#[test]
fn a_factor_replaces_the_schedule_and_gives_it_back() {
    let mut model = bar();
    let nodes = right(&model);
    model.boundaries.push(Boundary {
        name: "pull".to_owned(),
        target: Target::Nodes(nodes.clone()),
        load: Load::Velocity([Some(1.0), None]),
        schedule: Schedule::Ramp(1e-3),
    });
    let mut run = Simulation::new(model, 1).expect("a model");
    run.set_factor(1, Some(0.25)).expect("a boundary");
    run.advance(10).expect("steps");
    assert_eq!(run.node(nodes[0]).expect("a node").1[0], 0.25);
    run.set_factor(1, None).expect("a boundary");
    run.advance(1).expect("a step");
    assert!(run.node(nodes[0]).expect("a node").1[0] < 0.25);
    run.advance(500).expect("steps");
    assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
    assert_eq!(
        run.set_factor(2, None).expect_err("there are two").to_string(),
        "factors that are set: there is no boundary 2"
    );
    assert!(run.set_factor(1, Some(f64::NAN)).is_err());
}

/// All that the caller sets is in the state, also between a change of velocities and the next step, and while
/// the mesh breaks.
#[test]
fn actions_are_saved_and_resumed() {
    let model = crash(Insertion::Adaptive);
    let set = |run: &mut Simulation, size: f64| {
        let nodes: Vec<u32> = (0..run.counts().nodes as u32).rev().step_by(7).collect();
        let forces: Vec<[f64; 2]> = nodes.iter().map(|&node| [size * f64::from(node), -size]).collect();
        run.set_forces(&nodes, &forces).expect("nodes");
        run.set_velocities(&nodes[..5], &[[0.5, -1.0]; 5]).expect("nodes");
        run.set_factor(0, Some(0.5)).expect("a boundary");
    };
    let mut whole = Simulation::new(model.clone(), 2).expect("a model");
    whole.advance(900).expect("steps");
    set(&mut whole, 10.0);
    let saved = postcard::to_allocvec(&whole.state()).expect("bytes");
    let state: State = postcard::from_bytes(&saved).expect("a state");
    let mut resumed = Simulation::resume(model, state, 1).expect("the same model");
    for _ in 0..3 {
        whole.advance(200).expect("steps");
        resumed.advance(200).expect("steps");
        assert_eq!(resumed.snapshot(), whole.snapshot());
        assert_eq!(resumed.energies(), whole.energies());
        set(&mut whole, 25.0);
        set(&mut resumed, 25.0);
    }
    assert!(whole.counts().broken > 10, "{:?}", whole.counts());
}

/// Unused actions change no bit, and values that cannot be set change nothing.
#[test]
fn refused_actions_change_nothing() {
    let mut plain = Simulation::new(bar(), 1).expect("a model");
    let mut run = Simulation::new(bar(), 1).expect("a model");
    for (nodes, vectors) in [
        (vec![0, 1000], vec![[0.0; 2]; 2]),
        (vec![0, 1], vec![[1.0; 2]; 1]),
        (vec![0, 1], vec![[1.0, 1.0], [f64::NAN, 0.0]]),
    ] {
        assert!(run.set_velocities(&nodes, &vectors).is_err());
        assert!(run.set_forces(&nodes, &vectors).is_err());
    }
    let error = run.set_velocities(&[0], &[[1e6, 0.0]]).expect_err("a shell is slower");
    assert!(error.to_string().contains("at most ten times the speed of waves"), "{error}");
    run.advance(20).expect("steps");
    plain.advance(20).expect("steps");
    assert_eq!(run.snapshot(), plain.snapshot());
    assert_eq!(run.energies(), plain.energies());
}

/// Forces and velocities that are set before a run is distributed act as on one rank, and are in its
/// checkpoints.
#[test]
fn a_run_with_actions_is_the_same_on_ranks() {
    let begun = || {
        let mut run = Simulation::new(bar(), 1).expect("a model");
        run.advance(5).expect("steps");
        run.set_forces(&[3, 4], &[[1e3, 0.0], [0.0, -2e3]]).expect("nodes");
        run.set_velocities(&[0, 4], &[[0.5, 0.0], [0.0, 0.25]]).expect("nodes");
        run
    };
    let mut one = begun();
    one.advance(20).expect("steps");
    let found = threads::run(3, |ranks: &dyn Communicator| {
        let run = (ranks.rank() == 0).then(begun);
        let mut run = Distributed::<2, 3>::new(ranks, run, 1).expect("a run");
        run.advance(20).expect("steps");
        (run.gathered(), run.energies())
    });
    let (whole, energies) = &found[0];
    let whole = whole.as_ref().expect("rank 0 has the whole run");
    assert_eq!((whole.snapshot(), *energies), (one.snapshot(), one.energies()));
    let mut resumed = Simulation::resume(bar(), whole.state(), 1).expect("a state");
    resumed.advance(5).expect("steps");
    one.advance(5).expect("steps");
    assert_eq!(resumed.snapshot(), one.snapshot());
}
