//! Elastic bodies: waves, rotation, gravity. Comparison with theory and conservation laws.

use crate::common::*;
use fdem_simulation::*;

/// A bar of length 1 along x.
fn bar(cells: usize) -> Mesh {
    rectangle([0.0, 0.0], [1.0, 0.05], cells, 2)
}

#[test]
fn a_wave_in_a_bar_travels_at_the_speed_of_theory_and_doubles_at_the_free_end() {
    // nu = 0: a plane wave along x. The left end is pushed at 1 m/s after a short ramp.
    let mesh = bar(200);
    let left = nodes_where(&mesh, |[x, _]| x < 1e-9);
    let (middle, right) =
        (nodes_where(&mesh, |[x, _]| (x - 0.5).abs() < 1e-9), nodes_where(&mesh, |[x, _]| x > 1.0 - 1e-9));
    let ramp = 4e-5;
    let model = Model {
        mesh,
        materials: vec![granite()],
        boundaries: vec![Boundary {
            name: "piston".to_owned(),
            target: Target::Nodes(left),
            load: Load::Velocity([Some(1.0), None]),
            schedule: Schedule::Ramp(ramp),
        }],
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    let speed = f64::sqrt(50e9 / 2700.0);
    // The wave has arrived when the velocity in the middle of the bar reaches that of the middle of the ramp.
    let mut arrival = None;
    while arrival.is_none() {
        run.advance(1).expect("a step");
        let velocity = run.node(middle[1]).expect("a node").1[0];
        if velocity >= 0.5 {
            arrival = Some(run.time() - 0.5 * ramp);
        }
    }
    let found = 0.5 / arrival.expect("it arrived");
    assert!((found / speed - 1.0).abs() < 0.005, "{found} {speed}");
    while run.time() < 1.0 / speed + 3.0 * ramp {
        run.advance(1).expect("a step");
    }
    let end = run.node(right[1]).expect("a node").1[0];
    assert!((end / 2.0 - 1.0).abs() < 0.02, "{end}");
    assert!(run.energies().error().abs() < 1e-9, "{:?}", run.energies());
}

#[test]
fn a_block_that_spins_has_no_strain_and_keeps_its_momenta() {
    let mesh = rectangle([-0.5, -0.25], [0.5, 0.25], 6, 3);
    let spin = 10.0;
    let velocities = mesh.nodes.iter().map(|[x, y]| [3.0 - spin * y, -2.0 + spin * x]).collect();
    let model = Model {
        mesh,
        velocities,
        materials: vec![Material { poissons_ratio: 0.25, ..granite() }],
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let (before, energy) = (momentum(&run), run.energies());
    let turn = 2.0 * std::f64::consts::PI / spin;
    while run.time() < turn {
        run.advance(100).expect("steps");
    }
    let after = momentum(&run);
    for k in 0..3 {
        assert!((after[k] - before[k]).abs() < 1e-11 * before[2].abs(), "{before:?} {after:?}");
    }
    let error = run.energies().balance() / energy.kinetic;
    assert!(error.abs() < 1e-9, "{error}");
}

#[test]
fn gravity_at_once_doubles_the_load_and_a_ramp_does_not() {
    let height = 1.0;
    let mesh = rectangle([0.0, 0.0], [0.1, height], 2, 40);
    let base = nodes_where(&mesh, |[_, y]| y < 1e-9);
    let passage = height / f64::sqrt(50e9 / 2700.0);
    let weight = 2700.0 * 0.1 * height * 9.81;
    let largest_load = |gravity_schedule: Schedule| {
        let model = Model {
            mesh: mesh.clone(),
            materials: vec![granite()],
            gravity: [0.0, -9.81],
            gravity_schedule,
            boundaries: vec![Boundary {
                name: "base".to_owned(),
                target: Target::Nodes(base.clone()),
                load: Load::Velocity([Some(0.0); 2]),
                schedule: Schedule::Constant,
            }],
            ..Model::default()
        };
        let mut run = Simulation::new(model, 1).expect("a model");
        let mut largest = 0.0_f64;
        while run.time() < 30.0 * passage {
            run.advance(1).expect("a step");
            largest = largest.max(run.force(0).expect("the base")[1] / weight);
        }
        assert!(run.energies().error().abs() < 1e-6, "{:?}", run.energies());
        largest
    };
    let (sudden, ramped) = (largest_load(Schedule::Constant), largest_load(Schedule::Ramp(20.0 * passage)));
    assert!((sudden / 2.0 - 1.0).abs() < 0.03, "{sudden}");
    assert!((ramped - 1.0).abs() < 0.02, "{ramped}");
}

#[test]
fn results_do_not_depend_on_threads() {
    let mesh = together(&[bar(120), turned(&bar(120), 0.3, [1.01, 0.0])]);
    let against: Vec<[f64; 2]> =
        mesh.nodes.iter().map(|[x, _]| [if *x < 1.005 { 5.0 } else { -5.0 }, 0.0]).collect();
    let strength = Strength { tensile: 2e5, cohesion: 4e5, energy_i: 0.5, energy_ii: 2.0, ..rock() };
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = Model {
            mesh: together(&[
                mesh.clone(),
                turned(&rectangle([0.0, 0.0], [0.5, 0.5], 40, 40), 0.1, [0.0, 0.06]),
            ]),
            materials: vec![Material { strength: Some(strength), friction: 0.4, damping: 0.01, ..granite() }],
            velocities: [against.clone(), vec![[0.0, -20.0]; 41 * 41]].concat(),
            fracture: FractureOptions { insertion, joint_penalty: 100.0, ..FractureOptions::default() },
            ..Model::default()
        };
        let mut states = Vec::new();
        for threads in [1, 2, 5] {
            let mut run = Simulation::new(model.clone(), threads).expect("a model");
            run.advance(400).expect("steps");
            let counts = run.counts();
            assert!(counts.contacts > 0 && counts.joints > 0, "{counts:?}");
            states.push((run.snapshot(), run.energies()));
        }
        assert!(states[0] == states[1] && states[0] == states[2]);
    }
}

#[test]
fn the_kinetic_energy_of_a_run_that_stops_is_not_negative() {
    let mesh = bar(40);
    let velocities = mesh.nodes.iter().map(|[x, _]| [x.sin(), 0.0]).collect();
    let model = Model { mesh, materials: vec![granite()], velocities, ..Model::default() };
    let critical = Simulation::new(model.clone(), 1).expect("a model").critical_step().step;
    for share in [4.0, 8.0, 30.0] {
        let time = TimeOptions { step: Some(share * critical), ..TimeOptions::default() };
        let mut run = Simulation::new(Model { time, ..model.clone() }, 1).expect("a model");
        let stop = run.advance(10_000).expect_err("it is not stable");
        assert!(run.energies().kinetic >= 0.0, "{share}: {stop}: {:?}", run.energies());
    }
}
