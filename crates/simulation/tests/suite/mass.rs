//! Mass scaling: mass that is added for a longer time step.

use crate::common::*;
use fdem_simulation::*;

/// A block under its weight on a floor that holds it, with one row of flat elements, and viscosity that
/// brings it to rest.
fn block() -> Model {
    let mut mesh = rectangle([0.0; 2], [0.1, 0.08], 10, 8);
    // The fifth row is a twentieth as high as the others.
    for node in &mut mesh.nodes {
        let row = (node[1] / 0.01).round();
        node[1] = if row < 5.0 { 0.01 * row } else { 0.01 * (row - 1.0) + 0.0005 };
    }
    Model {
        boundaries: vec![floor(&mesh)],
        mesh,
        materials: vec![Material { poissons_ratio: 0.2, ..granite() }],
        gravity: [0.0, -9.81],
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// The model with the factors for a critical step of this many times its own.
fn scaled<const D: usize, const N: usize>(model: &Model<D, N>, times: f64) -> Model<D, N>
where
    [[f64; D]; N]: Element<D, N>,
{
    let critical = CriticalStep::of(model).expect("a model").step;
    let scaling = MassScaling::of(model).expect("a model");
    Model { mass_factors: scaling.factors(times * critical), ..model.clone() }
}

#[test]
fn the_step_that_was_asked_for_is_stable() {
    let mut cases = vec![block()];
    let materials = vec![Material { strength: Some(rock()), damping: 0.2, ..granite() }];
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let fracture = FractureOptions { insertion, joint_penalty: 50.0, ..FractureOptions::default() };
        cases.push(Model { fracture, materials: materials.clone(), ..block() });
    }
    for model in cases {
        let critical = CriticalStep::of(&model).expect("a model");
        let scaling = MassScaling::of(&model).expect("a model");
        assert!(scaling.factors((1.0 - 1e-9) * critical.step).is_empty());
        for times in [1.001, 2.0, 10.0] {
            let step = times * critical.step;
            let factors = scaling.factors(step);
            let model = Model { mass_factors: factors.clone(), ..model.clone() };
            let now = CriticalStep::of(&model).expect("a model").step;
            assert!(now >= step && now < 1.5 * step, "{times}: {now} {step}");
            // Nothing more is needed, and the factors only grow.
            assert_eq!(MassScaling::of(&model).expect("a model").factors(step), factors);
            let more = MassScaling::of(&model).expect("a model").factors(1.5 * step);
            assert!(factors.iter().zip(&more).all(|(one, other)| other >= one));
        }
    }
}

/// Tetrahedra that break, with twice the step.
#[test]
fn tetrahedra_bear_a_longer_step() {
    let mut model = crate::space::crash(Insertion::Adaptive);
    let step = CriticalStep::of(&model).expect("a model").step;
    let scaling = MassScaling::of(&model).expect("a model");
    model.mass_factors = scaling.factors(2.0 * step);
    assert!(CriticalStep::of(&model).expect("a model").step >= 2.0 * step);
    let mut run = Simulation::new(model, 2).expect("a model");
    run.advance(300).expect("steps");
    assert!(run.energies().error().abs() < 1e-2, "{:?}", run.energies());
}

/// Few elements set the step, and they alone get more mass.
#[test]
fn mass_is_added_where_it_is_needed() {
    let mut model = block();
    model.mesh = rectangle([0.0; 2], [0.1, 0.08], 10, 8);
    let middle = nodes_where(&model.mesh, |[x, y]| (x - 0.05).abs() + (y - 0.04).abs() < 1e-9)[0];
    model.mesh.nodes[middle as usize][0] += 0.0095;
    let critical = CriticalStep::of(&model).expect("a model").step;
    let scaling = MassScaling::of(&model).expect("a model");
    let factors = scaling.factors(1.2 * critical);
    let [mass, added] = scaling.added(&factors);
    assert!((mass / (2700.0 * 0.1 * 0.08) - 1.0).abs() < 1e-12, "{mass}");
    assert!(added > 0.0 && added < 0.02 * mass, "{added} of {mass}");
    for (nodes, factor) in model.mesh.elements.iter().zip(&factors) {
        assert!(*factor == 1.0 || nodes.contains(&middle), "{nodes:?}: {factor}");
    }
}

/// The floor carries the true weight, and the block rests as it does with its true masses.
#[test]
fn added_mass_has_no_weight() {
    let at_rest = |model: Model, steps: u64| {
        let mut run = Simulation::new(model, 1).expect("a model");
        run.advance(steps).expect("steps");
        let energies = run.energies();
        assert!(energies.error().abs() < 1e-3, "{energies:?}");
        assert!(energies.kinetic < 1e-9 * energies.strain, "{energies:?}");
        let lowest = run.snapshot().displacements.iter().map(|[_, y]| *y).fold(0.0, f64::min);
        (run.force(0).expect("a floor")[1], lowest, run.time_step())
    };
    let weight = 2700.0 * 0.1 * (0.07 + 0.0005) * 9.81;
    let (force, lowest, step) = at_rest(block(), 40_000);
    assert!((force / weight - 1.0).abs() < 1e-6, "{force} {weight}");
    let (force, scaled_lowest, longer) = at_rest(scaled(&block(), 4.0), 10_000);
    assert!((force / weight - 1.0).abs() < 1e-6, "{force} {weight}");
    assert!((scaled_lowest / lowest - 1.0).abs() < 1e-6, "{scaled_lowest} {lowest}");
    assert!(longer > 3.9 * step, "{longer} {step}");
}

/// Without damping a block falls as fast as its added mass lets it, and the balance of energy holds.
#[test]
fn energy_is_conserved() {
    let mut model = scaled(&block(), 4.0);
    model.time.local_damping = 0.0;
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(2000).expect("steps");
    assert!(run.energies().kinetic > 1e-3 * run.energies().strain);
    assert!(run.energies().error().abs() < 1e-6, "{:?}", run.energies());
    // A free body: its weight accelerates its true and its added mass.
    model.boundaries.clear();
    let [mass, added] = MassScaling::of(&model).expect("a model").added(&model.mass_factors);
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1000).expect("steps");
    let energies = run.energies();
    let fallen = -energies.external / (mass * 9.81);
    let expected = -0.5 * 9.81 * mass / (mass + added) * run.time().powi(2);
    assert!((fallen / expected - 1.0).abs() < 1e-2, "{fallen} {expected}");
    assert!(energies.error().abs() < 1e-6, "{energies:?}");
}

/// Ground at rest between absorbing edges stays at rest: the static forces are those of the true weight.
#[test]
fn ground_at_rest_stays_at_rest() {
    let mut model = block();
    let top = 0.07 + 0.0005;
    let stress = |nodes: &[u32; 3]| {
        let height = nodes.iter().map(|&node| model.mesh.nodes[node as usize][1]).sum::<f64>() / 3.0;
        [[-0.5 * 2700.0 * 9.81 * (top - height), 0.0], [0.0, -2700.0 * 9.81 * (top - height)]]
    };
    model.stresses = model.mesh.elements.iter().map(stress).collect();
    let sides = nodes_where(&model.mesh, |[x, _]| !(1e-9..0.1 - 1e-9).contains(&x));
    let facets: Vec<[u32; 2]> = (0..10).map(|i| [i, i + 1]).collect();
    let boundary = |name: &str, target, load| Boundary {
        name: name.to_owned(),
        target,
        load,
        schedule: Schedule::Constant,
    };
    model.boundaries = vec![
        boundary("base", Target::Facets(facets), Load::Absorbing),
        boundary("sides", Target::Nodes(sides), Load::Velocity([Some(0.0), None])),
    ];
    model.time.local_damping = 0.0;
    let fastest = |model: Model, steps: u64| {
        let mut run = Simulation::new(model, 1).expect("a model");
        run.advance(steps).expect("steps");
        run.snapshot().velocities.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
    };
    let [before, after] = [fastest(model.clone(), 500), fastest(scaled(&model, 4.0), 500)];
    assert!(after < 1e-9 + 1.1 * before, "{after} {before}");
}

/// Threads change no bit; ranks are compared in `ranks.rs`.
#[test]
fn threads_change_nothing() {
    let model = scaled(&crate::resume::crash(Insertion::Adaptive), 2.0);
    let state = |threads: usize| {
        let mut run = Simulation::new(model.clone(), threads).expect("a model");
        run.advance(600).expect("steps");
        postcard::to_allocvec(&run.state()).expect("bytes")
    };
    assert!(state(1) == state(3));
}

/// A part has the factors of its elements, and a run that continues with it the same masses.
#[test]
fn a_part_keeps_its_factors() {
    let mut model = scaled(&block(), 4.0);
    let keep: Vec<bool> = (0..model.mesh.elements.len()).map(|element| element % 20 < 14).collect();
    let kept = model.keeping(&keep).expect("a part");
    for (factor, &element) in kept.model.mass_factors.iter().zip(&kept.elements) {
        assert_eq!(*factor, model.mass_factors[element as usize]);
    }
    // The remaining part is stable at the step.
    let step = (1.0 - 1e-9) * CriticalStep::of(&model).expect("a model").step;
    let alone = MassScaling::of(&kept.model).expect("a part").factors(step);
    assert!(alone != kept.model.mass_factors);
    for (factor, &element) in alone.iter().zip(&kept.elements) {
        model.mass_factors[element as usize] = *factor;
    }
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(5000).expect("steps");
    let release = ("cut".to_owned(), Schedule::Constant);
    let change = Change::excavating(&model, &keep, Some(release)).expect("a part");
    let (model, state) = run.state().changed(&model, change, 1).expect("a changed run");
    let mut run = Simulation::resume(model, state, 1).expect("a run");
    run.advance(200).expect("steps");
    let energies = run.energies();
    assert!(energies.kinetic < 1e-9 * energies.strain, "{energies:?}");
}
