use crate::common::*;
use fdem_simulation::*;

/// A tilted block that falls on another and breaks.
pub(crate) fn crash(insertion: Insertion) -> Model {
    let ground = rectangle([0.0, -0.1], [0.4, 0.0], 16, 4);
    let block = turned(&rectangle([0.0, 0.0], [0.1, 0.1], 6, 6), 0.5, [0.2, 0.001]);
    let velocities = [vec![[0.0; 2]; ground.nodes.len()], vec![[1.0, -15.0]; block.nodes.len()]].concat();
    let strength = Strength { tensile: 2e6, cohesion: 4e6, energy_i: 5.0, energy_ii: 20.0, ..rock() };
    Model {
        boundaries: vec![held(
            "floor",
            nodes_where(&ground, |[_, y]| y < -0.0999),
            [Some(0.0); 2],
            Schedule::Constant,
        )],
        mesh: together(&[ground, block]),
        velocities,
        materials: vec![Material { strength: Some(strength), friction: 0.5, damping: 0.05, ..granite() }],
        gravity: [0.0, -9.81],
        contact: ContactOptions { damping: 0.2, ..ContactOptions::default() },
        fracture: FractureOptions { insertion, joint_penalty: 100.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

#[test]
fn a_run_that_was_saved_goes_on_bit_for_bit() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crash(insertion);
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        whole.advance(300).expect("steps");
        let mut saved = postcard::to_allocvec(&whole.state()).expect("bytes");
        for (threads, steps) in [(1, 700), (3, 600), (1, 1400)] {
            whole.advance(steps).expect("steps");
            let state: State = postcard::from_bytes(&saved).expect("a state");
            let mut resumed = Simulation::resume(model.clone(), state, threads).expect("the same model");
            resumed.advance(steps).expect("steps");
            assert_eq!(resumed.snapshot(), whole.snapshot());
            assert_eq!(resumed.energies(), whole.energies());
            saved = postcard::to_allocvec(&whole.state()).expect("bytes");
            assert!(postcard::to_allocvec(&resumed.state()).expect("bytes") == saved);
        }
        let counts = whole.counts();
        assert!(
            counts.broken > 10 && counts.contacts > 5,
            "{insertion:?}: it should have broken: {counts:?}"
        );
    }
}

#[test]
fn a_run_that_is_saved_again_and_again_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crash(insertion);
        let mut whole = Simulation::new(model.clone(), 1).expect("a model");
        let mut patched = Simulation::new(model.clone(), 1).expect("a model");
        for part in 0..120 {
            let steps = 3 + part % 17;
            whole.advance(steps).expect("steps");
            patched.advance(steps).expect("steps");
            let saved = postcard::to_allocvec(&patched.state()).expect("bytes");
            let state = postcard::from_bytes(&saved).expect("a state");
            patched = Simulation::resume(model.clone(), state, 1).expect("the same model");
            assert!(
                patched.energies() == whole.energies(),
                "{insertion:?}, step {}: {:?} {:?}",
                whole.steps(),
                patched.energies(),
                whole.energies()
            );
            assert!(patched.snapshot() == whole.snapshot(), "{insertion:?}, step {}", whole.steps());
        }
        assert!(whole.counts().broken > 5, "{:?}", whole.counts());
    }
}

#[test]
fn a_state_of_another_model_is_refused() {
    let mut run = Simulation::new(crash(Insertion::Adaptive), 1).expect("a model");
    run.advance(10).expect("steps");
    let other = Model {
        mesh: rectangle([0.0; 2], [1.0; 2], 2, 2),
        boundaries: Vec::new(),
        velocities: Vec::new(),
        ..crash(Insertion::Adaptive)
    };
    let refused = Simulation::resume(other, run.state(), 1).err();
    assert!(matches!(refused, Some(ModelError::Length { .. })), "{refused:?}");
}

#[test]
fn a_step_that_is_too_long_stops_the_run_and_names_an_element() {
    let mut model = crash(Insertion::Adaptive);
    model.time.step = Some(20.0 * CriticalStep::of(&model).expect("a model").step);
    let mut run = Simulation::new(model, 1).expect("a model");
    let stop = run.advance(100_000).expect_err("it cannot go well");
    assert!(stop.to_string().contains("element"), "{stop}");
}

#[test]
fn the_critical_step_is_stable_and_not_far_from_the_limit() {
    // An elastic body without contacts, so that only the elements set the critical step.
    let mesh = rectangle([0.0; 2], [1.0, 1.0], 8, 8);
    let velocities =
        (0..mesh.nodes.len()).map(|k| [1e-3 * ((k * 7) % 5) as f64, -1e-3 * ((k * 3) % 4) as f64]).collect();
    let mut model = Model {
        mesh,
        velocities,
        materials: vec![Material { poissons_ratio: 0.25, ..granite() }],
        contact: ContactOptions { penalty: 1e-6, tangential_stiffness: 0.0, ..ContactOptions::default() },
        ..Model::default()
    };
    let critical = CriticalStep::of(&model).expect("a model");
    assert_eq!(critical.cause, Cause::Bulk);
    let mut errors = Vec::new();
    for factor in [0.99, 2.0] {
        model.time.step = Some(factor * critical.step);
        let mut run = Simulation::new(model.clone(), 1).expect("a model");
        errors.push(run.advance(3000).err());
    }
    assert!(errors[0].is_none() && errors[1].is_some(), "{errors:?}");
}
