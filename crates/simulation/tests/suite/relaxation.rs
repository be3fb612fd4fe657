//! Dynamic relaxation: damping that follows the slowest motion.

use crate::common::*;
use fdem_simulation::*;

/// A column under its weight on a floor, without damping of the material.
fn column() -> Model {
    let mesh = rectangle([0.0; 2], [0.1, 1.0], 2, 20);
    Model {
        boundaries: vec![floor(&mesh)],
        mesh,
        materials: vec![Material { poissons_ratio: 0.0, damping: 0.0, ..granite() }],
        gravity: [0.0, -9.81],
        time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// Steps of `count` passages of a wave through the column.
fn passages(run: &Simulation, count: f64) -> u64 {
    let material = &run.model().materials[0];
    let wave = (material.youngs_modulus / material.density).sqrt();
    (count / wave / run.time_step()) as u64
}

#[test]
fn a_column_comes_to_rest_under_its_weight() {
    let mut run = Simulation::new(column(), 1).expect("a model");
    run.advance(passages(&run, 20.0)).expect("steps");
    let energies = run.energies();
    assert!(run.imbalance() < 1e-6, "{}", run.imbalance());
    assert!(energies.kinetic < 1e-12 * energies.strain, "{energies:?}");
    assert!(energies.error().abs() < 1e-7, "{}", energies.error());
    // The top sinks by ρ g h² / 2E; a linear triangle has that of its nodes exactly.
    let material = &run.model().materials[0];
    let sinks = material.density * 9.81 / (2.0 * material.youngs_modulus);
    let top = nodes_where(&run.model().mesh, |[_, y]| y == 1.0);
    let snapshot = run.snapshot();
    for node in top {
        let moved = -snapshot.displacements[node as usize][1];
        assert!((moved / sinks - 1.0).abs() < 2e-3, "{moved} and {sinks}");
    }
    // Without it the column swings for ever.
    let time = TimeOptions::default();
    let mut swings = Simulation::new(Model { time, ..column() }, 1).expect("a model");
    swings.advance(passages(&swings, 40.0)).expect("steps");
    assert!(swings.imbalance() > 0.01, "{}", swings.imbalance());
}

/// Damping takes energy, and never gives any.
#[test]
fn the_energy_of_damping_only_grows() {
    let mut run = Simulation::new(column(), 1).expect("a model");
    let mut last = 0.0;
    for _ in 0..300 {
        run.advance(7).expect("steps");
        let damping = run.energies().damping;
        assert!(damping >= last - 1e-12 * run.energies().strain, "{damping} after {last}");
        last = damping;
    }
}

/// Motion without resistance is not damped: a body that falls.
#[test]
fn a_body_falls_freely() {
    let mut model = column();
    model.boundaries.clear();
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1000).expect("steps");
    let time = run.time();
    let fallen = -run.snapshot().displacements[0][1];
    assert!((fallen / (0.5 * 9.81 * time * time) - 1.0).abs() < 2e-3, "{fallen} after {time} s");
}

#[test]
fn a_boundary_goes_on_as_it_is_told() {
    let mut model = column();
    model.boundaries[0].load = Load::Velocity([None, Some(0.01)]);
    model.gravity = [0.0; 2];
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(passages(&run, 20.0)).expect("steps");
    let time = run.time();
    let snapshot = run.snapshot();
    let floor = nodes_where(&run.model().mesh, |[_, y]| y == 0.0);
    for node in floor {
        assert!((snapshot.displacements[node as usize][1] - 0.01 * time).abs() < 1e-12);
    }
    let energies = run.energies();
    assert!(energies.damping > 0.0);
    assert!(energies.error().abs() < 1e-9, "{}", energies.error());
}

#[test]
fn the_balance_holds_with_local_damping_and_loads_too() {
    let mut model = column();
    model.time.local_damping = 0.1;
    let top = nodes_where(&model.mesh, |[_, y]| y == 1.0);
    model.boundaries.push(Boundary {
        name: "load".to_owned(),
        target: Target::Nodes(top),
        load: Load::Force([1e3, -1e4]),
        schedule: Schedule::Ramp(1e-4),
    });
    let mut run = Simulation::new(model, 1).expect("a model");
    for _ in 0..40 {
        run.advance(53).expect("steps");
        assert!(run.energies().error().abs() < 1e-6, "{}", run.energies().error());
    }
}

/// However steps are divided into calls, on any number of threads, and through a restart between the two
/// steps whose sums make the damping.
#[test]
fn the_bits_do_not_depend_on_calls_threads_or_a_restart() {
    let hash = |run: &Simulation| format!("{:?}", run.snapshot().velocities);
    let mut whole = Simulation::new(column(), 1).expect("a model");
    whole.advance(600).expect("steps");
    let mut parts = Simulation::new(column(), 3).expect("a model");
    for step in 0..600 {
        parts.advance(1).expect("a step");
        if step % 7 == 0 {
            parts = Simulation::resume(column(), parts.state(), 2).expect("a state");
        }
    }
    assert_eq!(hash(&parts), hash(&whole));
    assert!(parts.energies() == whole.energies());
}
