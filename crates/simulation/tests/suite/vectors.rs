//! Results do not depend on the vector instructions on which a run is computed.

use crate::common::*;
use fdem_simulation::*;
use serde::Serialize;

/// Runs a model on all vector instructions that the processor has, and compares the states to the last bit.
/// Returns the last run.
macro_rules! on_all_instructions {
    ($model:expr, $steps:expr) => {{
        let runs = Simd::available().into_iter().map(|simd| {
            let mut run = Simulation::new($model.clone(), 1).expect("a model");
            assert!(run.set_simd(simd) && run.simd() == simd);
            run.advance($steps).expect("steps");
            (bytes(&run.state()), run)
        });
        let runs: Vec<_> = runs.collect();
        for (state, run) in &runs {
            assert!(*state == runs[0].0, "{} and {}", run.simd(), runs[0].1.simd());
        }
        runs.into_iter().last().expect("portable code runs everywhere").1
    }};
}

fn bytes(state: &impl Serialize) -> Vec<u8> {
    postcard::to_allocvec(state).expect("bytes")
}

/// Two materials, side by side in the same batches: one with viscosity and one without, the second under
/// initial stress.
#[test]
fn a_crash_in_the_plane_is_the_same() {
    let ground = rectangle([0.0, -0.1], [0.4, 0.0], 13, 5);
    let block = turned(&rectangle([0.0, 0.0], [0.1, 0.1], 5, 5), 0.5, [0.2, 0.001]);
    let velocities = [vec![[0.0; 2]; ground.nodes.len()], vec![[1.0, -25.0]; block.nodes.len()]].concat();
    let floor = nodes_where(&ground, |[_, y]| y < -0.0999);
    let mut mesh = together(&[ground, block]);
    for (number, material) in mesh.materials.iter_mut().enumerate() {
        *material = u32::from(number % 3 == 0);
    }
    let strength = Strength { tensile: 2e6, cohesion: 4e6, energy_i: 5.0, energy_ii: 20.0, ..rock() };
    let stiff = Material { strength: Some(strength), friction: 0.5, damping: 0.05, ..granite() };
    let soft = Material { youngs_modulus: 20e9, damping: 0.0, ..stiff.clone() };
    for (insertion, pressure) in
        [(Insertion::Adaptive, 0.0), (Insertion::Intrinsic, 0.0), (Insertion::Intrinsic, 1e5)]
    {
        let stress = [[-pressure, 0.0], [0.0, -pressure]];
        let model = Model {
            boundaries: vec![Boundary {
                name: "floor".to_owned(),
                target: Target::Nodes(floor.clone()),
                load: Load::Velocity([Some(0.0); 2]),
                schedule: Schedule::Constant,
            }],
            mesh: mesh.clone(),
            velocities: velocities.clone(),
            stresses: if pressure > 0.0 { vec![stress; mesh.elements.len()] } else { Vec::new() },
            materials: vec![stiff.clone(), soft.clone()],
            gravity: [0.0, -9.81],
            fracture: FractureOptions { insertion, joint_penalty: 100.0, ..FractureOptions::default() },
            time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
            ..Model::default()
        };
        let counts = on_all_instructions!(model, 900).counts();
        assert!(
            counts.broken > 10 && counts.contacts > 5,
            "{insertion:?}: it should have broken: {counts:?}"
        );
    }
}

/// Two laws, side by side in the same batches.
#[test]
fn a_crash_of_bedded_bodies_is_the_same() {
    for (insertion, pressure) in [(Insertion::Adaptive, 0.0), (Insertion::Intrinsic, 1e5)] {
        let counts = on_all_instructions!(crate::laws::crash(insertion, pressure), 1400).counts();
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

#[test]
fn a_crash_in_space_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let counts = on_all_instructions!(crate::space::crash(insertion), 800).counts();
        assert!(
            counts.broken > 10 && counts.contacts > 5,
            "{insertion:?}: it should have broken: {counts:?}"
        );
    }
}

/// A block that is stretched by half: most strains are too large for the series of the cube root, which all
/// lanes compute first.
#[test]
fn large_strains_are_the_same() {
    let mesh = crate::space::cuboid([0.0; 3], [0.1; 3], [3, 2, 2]);
    let velocities = mesh.nodes.iter().map(|p| [200.0 * p[0] / 0.1, 0.0, 0.0]).collect();
    let soft = Material { youngs_modulus: 1e7, poissons_ratio: 0.3, ..granite() };
    let model =
        Model { mesh, velocities, materials: vec![soft], gravity: [0.0; 3], ..Model::<3, 4>::default() };
    let step = Simulation::new(model.clone(), 1).expect("a model").time_step();
    let run = on_all_instructions!(model, (0.25e-3 / step) as u64);
    let most = run.snapshot().displacements.iter().map(|u| u[0]).fold(0.0, f64::max);
    assert!(most > 0.03, "{most}");
    assert!(run.energies().error().abs() < 0.01, "{:?}", run.energies());
}

/// The rest of a batch that is not full.
#[test]
fn any_number_of_elements_is_the_same() {
    for cells in 1..=9 {
        let mesh = rectangle([0.0; 2], [0.1 * f64::from(cells), 0.1], cells as usize, 1);
        let velocities = mesh.nodes.iter().map(|[x, y]| [0.1 * y, 0.3 * x]).collect();
        let model =
            Model { mesh, velocities, materials: vec![granite()], gravity: [0.0; 2], ..Model::default() };
        let run = on_all_instructions!(model, 50);
        assert!(run.energies().strain > 0.0);
    }
}
