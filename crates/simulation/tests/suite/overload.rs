//! Bodies that are rigid until they are overloaded.

use crate::common::*;
use crate::rigid::{blocks, blocks_in_space};
use crate::space::cuboid;
use fdem_simulation::*;

fn until(bodies: &[u32], share: f64) -> Vec<UntilOverloaded> {
    bodies.iter().map(|&body| UntilOverloaded { body, share }).collect()
}

/// A turned square with a pressure on two opposite sides, Pa.
fn pressed(pressure: f64, share: f64) -> Model {
    let square = rectangle([-0.05, -0.05], [0.05, 0.05], 8, 8);
    let on = |side: f64| nodes_where(&square, |[_, y]| y == side);
    let facets = |nodes: Vec<u32>| nodes.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>();
    let top = on(0.05).into_iter().rev().collect();
    let mesh = turned(&square, 0.7, [0.2, 0.1]);
    Model {
        boundaries: vec![Boundary {
            name: "pressure".to_owned(),
            target: Target::Facets([facets(on(-0.05)), facets(top)].concat()),
            load: Load::Pressure(pressure),
            schedule: Schedule::Constant,
        }],
        mesh,
        materials: vec![Material { strength: Some(rock()), poissons_ratio: 0.2, ..granite() }],
        rigid: vec![0],
        until_overloaded: until(&[0], share),
        ..Model::default()
    }
}

/// The square gets the uniform stress of the pressure, and does not swing, as it would if it began to deform
/// without stress.
#[test]
fn an_overloaded_body_has_the_static_stress_of_its_loads() {
    let mut run = Simulation::new(pressed(1.2e6, 0.59999), 1).expect("a model");
    assert!(run.released_bodies().is_empty());
    assert!(run.snapshot().stresses.iter().flatten().all(|stress| *stress == 0.0));
    run.advance(1).expect("a step");
    assert_eq!(run.released_bodies(), [0]);
    let (sin, cos) = 0.7_f64.sin_cos();
    // The axis of the pressure is [-sin, cos].
    let expected = [[sin * sin, -sin * cos], [-sin * cos, cos * cos]];
    for steps in [0, 1, 500] {
        run.advance(steps).expect("steps");
        for stress in run.snapshot().stresses {
            for (at, to) in [(0, expected[0][0]), (1, expected[1][1]), (3, expected[0][1])] {
                assert!((stress[at] / -1.2e6 - to).abs() < 1e-4, "{stress:?}");
            }
        }
    }
    let energies = run.energies();
    let stored = 0.01 * 1.2e6 * 1.2e6 / (2.0 * 50e9);
    assert!((energies.strain / stored - 1.0).abs() < 1e-3, "{energies:?}");
    assert!(energies.kinetic < 1e-6 * energies.strain, "{energies:?}");
    assert!(energies.error().abs() < 1e-6, "{energies:?}");

    let mut lighter = Simulation::new(pressed(0.9e6, 0.5), 1).expect("a model");
    lighter.advance(200).expect("steps");
    assert!(lighter.released_bodies().is_empty());
}

/// The bodies of a model that are rigid, until they are overloaded.
fn model() -> Model {
    Model { until_overloaded: until(&[1, 2], 0.3), ..blocks() }
}

fn model_in_space() -> Model<3, 4> {
    let mut model = blocks_in_space();
    model.materials[0].strength = Some(Strength { tensile: 4e6, cohesion: 12e6, ..rock() });
    let box_in_space = cuboid([0.08, 0.05, 0.002], [0.18, 0.11, 0.06], [4, 2, 2]);
    let slab = cuboid([0.0, 0.0, -0.05], [0.3, 0.2, 0.0], [6, 4, 1]);
    let velocities =
        slab.nodes.iter().map(|_| [0.0; 3]).chain(box_in_space.nodes.iter().map(|_| [1.0, 0.5, -4.0]));
    model.velocities = velocities.collect();
    model.mesh = together(&[slab, box_in_space]);
    Model { until_overloaded: until(&[1], 0.3), time: TimeOptions::default(), ..model }
}

#[test]
fn bodies_that_collide_deform_and_break_and_keep_the_energy() {
    let mut run = Simulation::new(model(), 2).expect("a model");
    run.advance(2500).expect("steps");
    assert_eq!(run.released_bodies(), [1, 2]);
    assert!(run.energies().error().abs() < 1e-4, "{:?}", run.energies());
    // The body that struck the ground has broken, too.
    let bodies = &run.model().mesh.bodies;
    assert!(run.snapshot().cracks.iter().any(|crack| bodies[crack.elements[0] as usize] == 1));

    // In space, with the steps of a run that deforms from the beginning, and with the error of that.
    let time = TimeOptions { safety: 0.4, ..TimeOptions::default() };
    let model = Model { time, ..model_in_space() };
    let from_the_beginning = Model { rigid: Vec::new(), until_overloaded: Vec::new(), ..model.clone() };
    let [space, deformable] = [model, from_the_beginning].map(|model| {
        let mut run = Simulation::new(model, 2).expect("a model");
        run.advance(8000).expect("steps");
        run
    });
    assert_eq!(space.released_bodies(), [1]);
    let errors = [&space, &deformable].map(|run| run.energies().error());
    assert!((errors[0] - errors[1]).abs() < 5e-5, "{errors:?}");
}

/// Runs are saved before and after a body is released, and while the next one is still rigid.
#[test]
fn a_run_is_resumed_bit_for_bit() {
    fn check<const D: usize, const N: usize>(model: &Model<D, N>, parts: [u64; 4])
    where
        [[f64; D]; N]: Element<D, N>,
        State<D, N>: serde::Serialize + serde::de::DeserializeOwned,
    {
        let bytes = |run: &Simulation<D, N>| postcard::to_allocvec(&run.state()).expect("bytes");
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        let mut saved = Vec::new();
        let mut released = Vec::new();
        for steps in parts {
            saved.push((steps, bytes(&whole)));
            released.push(whole.released_bodies().len());
            whole.advance(steps).expect("steps");
        }
        released.push(whole.released_bodies().len());
        assert!(released[0] < released[4] && released.is_sorted(), "{released:?}");
        for (k, (_, state)) in saved.iter().enumerate() {
            let state = postcard::from_bytes(state).expect("a state");
            let mut resumed = Simulation::resume(model.clone(), state, 1 + k % 3).expect("the same model");
            saved[k..].iter().for_each(|(steps, _)| resumed.advance(*steps).expect("steps"));
            assert!(bytes(&resumed) == bytes(&whole), "{k}");
        }
    }
    check(&model(), [800, 1000, 7, 700]);
    check(&model_in_space(), [500, 1500, 7, 2000]);
}

/// A later model keeps the body as it is, and excavation takes it out.
#[test]
fn a_changed_model_keeps_a_released_body() {
    let mut run = Simulation::new(pressed(1.2e6, 0.59999), 1).expect("a model");
    run.advance(20).expect("steps");
    let before = pressed(1.2e6, 0.59999);
    let change = Change {
        model: Model { gravity: [0.0, -9.81], ..before.clone() },
        elements: (0..before.mesh.elements.len() as u32).map(Some).collect(),
        release: None,
    };
    let (model, state) = run.state().changed(&before, change, 1).expect("a change");
    assert_eq!(model.rigid, [0]);
    let mut next = Simulation::resume(model, state, 1).expect("the changed model");
    next.advance(50).expect("steps");
    assert_eq!(next.released_bodies(), [0]);
    assert!(next.energies().error().abs() < 1e-6, "{:?}", next.energies());
    assert!(next.energies().kinetic < 1e-3 * next.energies().strain, "{:?}", next.energies());
}

#[test]
fn bodies_that_cannot_be_released_are_refused() {
    let refused = |model: Model| Simulation::new(model, 1).expect_err("refused").to_string();
    let model = || pressed(1.2e6, 0.59999);
    let mut strong = model();
    strong.materials[0].strength = None;
    assert!(
        refused(strong)
            .contains("body 0 cannot be rigid until it is overloaded: its material has no strength")
    );
    let fracture = FractureOptions { insertion: Insertion::Intrinsic, ..FractureOptions::default() };
    assert!(refused(Model { fracture, ..model() }).contains("joints are on all facets"));
    let mut fixed = model();
    fixed.boundaries.push(held("floor", vec![0], [Some(0.0); 2], Schedule::Constant));
    assert!(refused(fixed).contains("a boundary holds or moves it"));
    assert!(
        refused(Model { until_overloaded: until(&[0], 1.5), ..model() }).contains("above 0 and at most 1")
    );
    assert!(refused(Model { until_overloaded: until(&[3], 0.5), ..model() }).contains("no body 3"));
    assert!(refused(Model { until_overloaded: until(&[0, 0], 0.5), ..model() }).contains("ascending"));
    let stresses = vec![[[1e5, 0.0], [0.0, 1e5]]; 128];
    assert!(refused(Model { stresses, ..model() }).contains("begins with a stress"));
    assert!(refused(Model { mass_factors: vec![2.0; 128], ..model() }).contains("masses are scaled"));
}

/// A block that strikes a rigid floor flat passes its strength within a few steps: it gets the stress of its
/// share alone, and no more energy than it had.
#[test]
fn a_blow_brings_no_energy() {
    let floor = rectangle([-0.2, -0.1], [0.4, 0.0], 3, 1);
    let block = rectangle([0.0, 0.0002], [0.2, 0.2002], 8, 8);
    let velocities = [vec![[0.0; 2]; floor.nodes.len()], vec![[0.0, -1.0]; block.nodes.len()]].concat();
    let whole: Vec<u32> = (0..floor.nodes.len() as u32).collect();
    let strength =
        Strength { tensile: 2e6, cohesion: 6e6, friction: 0.7, energy_i: 20.0, energy_ii: 80.0, ..rock() };
    let stone = Material { youngs_modulus: 5e9, density: 2500.0, strength: Some(strength), ..granite() };
    let model = |until_overloaded: Vec<UntilOverloaded>| Model {
        boundaries: vec![held("floor", whole.clone(), [Some(0.0); 2], Schedule::Constant)],
        mesh: together(&[floor.clone(), block.clone()]),
        velocities: velocities.clone(),
        materials: vec![stone.clone()],
        rigid: if until_overloaded.is_empty() { vec![0] } else { vec![0, 1] },
        until_overloaded,
        ..Model::default()
    };
    let before = 0.5 * 2500.0 * 0.04;
    let mut run = Simulation::new(model(until(&[1], 0.1)), 1).expect("a model");
    run.advance((6e-4 / run.time_step()) as u64).expect("steps");
    assert_eq!(run.released_bodies(), [1]);
    let energies = run.energies();
    assert!(energies.external.abs() < 0.02 * before, "{energies:?}");
    assert!(energies.kinetic + energies.strain < 1.02 * before, "{energies:?}");
    assert!(energies.error().abs() < 2e-3, "{energies:?}");
}

/// A ring of stress holds a body together that turns: its spin overloads it.
#[test]
fn a_spin_overloads_a_body() {
    let spinning = |rate: f64| {
        let mut model = pressed(1.0, 0.5);
        model.boundaries.clear();
        model.mesh = rectangle([-0.05, -0.05], [0.05, 0.05], 8, 8);
        model.velocities = model.mesh.nodes.iter().map(|[x, y]| [-rate * y, rate * x]).collect();
        let mut run = Simulation::new(model, 1).expect("a model");
        run.advance(20).expect("steps");
        run
    };
    // The mean stress of a square of side a is ρ ω² a² / 12.
    let limit = (0.5e6_f64 * 12.0 / (2700.0 * 0.01)).sqrt();
    assert!(spinning(0.99 * limit).released_bodies().is_empty());
    let mut fast = spinning(1.01 * limit);
    assert_eq!(fast.released_bodies(), [0]);
    // The body turns with the stress of its rotation, and does not ring.
    let strain = fast.energies().strain;
    fast.advance(500).expect("steps");
    assert!((fast.energies().strain / strain - 1.0).abs() < 0.05, "{strain} {:?}", fast.energies());
    assert!(fast.counts().broken == 0 && fast.energies().error().abs() < 1e-4, "{:?}", fast.energies());
}
