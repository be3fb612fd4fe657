//! Laws of the material besides the neo-Hookean one.

use crate::common::*;
use fdem_simulation::*;

/// Shale whose bedding dips by an angle, in radians, and is weaker than the rock across it.
fn shale(dip: f64) -> Material {
    let strength = Strength { tensile: 4e6, cohesion: 8e6, energy_i: 10.0, energy_ii: 40.0, ..rock() };
    let (sin, cos) = dip.sin_cos();
    let bedding = Bedding {
        normal: [-sin, cos, 0.0],
        youngs_modulus: 18e9,
        poissons_ratio: 0.15,
        shear_modulus: 7e9,
        strength: Some(Strength { tensile: 2e6, cohesion: 3e6, energy_i: 4.0, energy_ii: 15.0, ..strength }),
    };
    Material {
        youngs_modulus: 40e9,
        poissons_ratio: 0.2,
        law: MaterialLaw::TransverselyIsotropic(bedding),
        strength: Some(strength),
        friction: 0.5,
        ..granite()
    }
}

/// A tilted block of shale that falls on a layer of shale and granite, whose elements alternate, and breaks.
/// Under initial stress, and with viscosity in the granite.
pub(crate) fn crash(insertion: Insertion, pressure: f64) -> Model {
    let ground = rectangle([0.0, -0.1], [0.4, 0.0], 13, 5);
    let block = turned(&rectangle([0.0, 0.0], [0.1, 0.1], 6, 6), 0.5, [0.2, 0.001]);
    let velocities = [vec![[0.0; 2]; ground.nodes.len()], vec![[1.0, -15.0]; block.nodes.len()]].concat();
    let floor = nodes_where(&ground, |[_, y]| y < -0.0999);
    let layer = ground.elements.len();
    let mut mesh = together(&[ground, block]);
    for (number, material) in mesh.materials[..layer].iter_mut().enumerate() {
        *material = u32::from(number % 3 == 0);
    }
    let stresses = vec![[[-pressure, 0.0], [0.0, -pressure]]; mesh.elements.len()];
    Model {
        boundaries: vec![Boundary {
            name: "floor".to_owned(),
            target: Target::Nodes(floor),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        mesh,
        velocities,
        stresses: if pressure > 0.0 { stresses } else { Vec::new() },
        materials: vec![shale(0.4), Material { damping: 0.05, ..granite() }],
        plane: Plane::Strain,
        gravity: [0.0, -9.81],
        fracture: FractureOptions { insertion, joint_penalty: 100.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

#[test]
fn a_bedded_run_that_was_saved_continues_bit_for_bit() {
    for (insertion, pressure) in [(Insertion::Adaptive, 0.0), (Insertion::Intrinsic, 1e5)] {
        let model = crash(insertion, pressure);
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        whole.advance(700).expect("steps");
        let saved = postcard::to_allocvec(&whole.state()).expect("bytes");
        let state: State = postcard::from_bytes(&saved).expect("a state");
        let mut resumed = Simulation::resume(model.clone(), state, 1).expect("the same model");
        // The stress out of the plane follows from the memory of the elements, also before the next step.
        assert_eq!(resumed.snapshot(), whole.snapshot());
        for run in [&mut whole, &mut resumed] {
            run.advance(700).expect("steps");
        }
        assert_eq!(resumed.snapshot(), whole.snapshot());
        assert_eq!(resumed.energies(), whole.energies());
        let counts = whole.counts();
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
        assert!(whole.energies().error().abs() < 1e-2, "{:?}", whole.energies());
    }
}

/// A square that swings, in any state of the plane, and the same one with everything turned.
#[test]
fn a_bedded_square_keeps_its_energy_whatever_its_orientation() {
    for plane in [Plane::Strain, Plane::Stress] {
        let mut energies = Vec::new();
        for angle in [0.0, 0.7] {
            let (sin, cos) = f64::sin_cos(angle);
            let turn = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
            let square = rectangle([0.0; 2], [0.1; 2], 5, 5);
            let velocities = square.nodes.iter().map(|[x, y]| turn([8.0 * y + 3.0 * x, -9.0 * x]));
            let model = Model {
                velocities: velocities.collect(),
                mesh: turned(&square, angle, [0.0; 2]),
                materials: vec![Material { strength: None, ..shale(0.4 + angle) }],
                plane,
                gravity: [0.0; 2],
                ..Model::default()
            };
            let mut run = Simulation::new(model, 1).expect("a model");
            run.advance(400).expect("steps");
            assert!(run.energies().error().abs() < 1e-5, "{:?}", run.energies());
            energies.push(run.energies().strain);
        }
        assert!((energies[1] / energies[0] - 1.0).abs() < 1e-10, "{plane:?} {energies:?}");
    }
}

#[test]
fn constants_without_a_positive_energy_are_refused() {
    let mut model = crash(Insertion::Adaptive, 0.0);
    let MaterialLaw::TransverselyIsotropic(bedding) = &mut model.materials[0].law else { panic!("shale") };
    bedding.poissons_ratio = 0.5;
    let refused = Simulation::new(model, 1).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(refused.contains("material 'granite'") && refused.contains("ν'² E/E'"), "{refused}");
}

/// Elements with a large strain are computed once more, and must not take the viscous stress of this step for
/// that of the step before.
#[test]
fn the_power_of_viscosity_has_the_stress_before_the_step_for_any_strain() {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let along = |x: f64| [[x, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    for stretch in [1.0 + 1e-6, 1.2] {
        let mut edges = unit;
        edges[0][0] = stretch;
        let element = ElementState {
            gradients: unit,
            edges,
            rates: along(2.0),
            initial: [[0.0; 3]; 3],
            viscous: along(7.0),
            volume: 1.0,
            viscosity: 5.0,
            stored: 0.0,
            shear: 2e10,
            bulk: 3e10,
            bedding: FlatBedding { rest: [0.0; 5], normal: [0.0; 3] },
        };
        let found = deform_tetrahedra(&[element], [false, true, false])[0];
        assert!(found.viscous[0][0] > 10.0, "{found:?}");
        assert_eq!(found.power, 2.0 * 7.0 + 2.0 * found.viscous[0][0], "{stretch}");
    }
}
