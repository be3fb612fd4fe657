//! Models far from the origin of their coordinates.

use crate::common::*;
use fdem_simulation::*;

/// An offset far from 0. It is a power of 2, so that the coordinates of the models here are exact with and
/// without it.
const FAR: [f64; 2] = [131_072.0, -131_072.0];

/// A block of 3 cm that is driven into another and breaks. All coordinates are multiples of 2^-20 m, and the
/// middle of the model is at `middle`.
fn crash(middle: [f64; 2]) -> Model {
    let lower = rectangle([-0.031_25, -0.031_25], [0.031_25, -0.000_976_562_5], 16, 8);
    let upper = rectangle([-0.015_625, 0.000_976_562_5], [0.015_625, 0.031_25], 8, 8);
    let mut mesh = together(&[lower, upper]);
    let bottom = nodes_where(&mesh, |[_, y]| y == -0.031_25);
    let top = nodes_where(&mesh, |[_, y]| y == 0.031_25);
    for node in &mut mesh.nodes {
        *node = [node[0] + middle[0], node[1] + middle[1]];
    }
    let strength = Strength { tensile: 2e6, cohesion: 4e6, energy_i: 1.0, energy_ii: 4.0, ..rock() };
    let held = |name: &str, nodes, load| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(nodes),
        load,
        schedule: Schedule::Ramp(1e-4),
    };
    Model {
        boundaries: vec![
            held("floor", bottom, Load::Velocity([Some(0.0); 2])),
            held("ram", top, Load::Displacement([Some(1e-4), Some(-2e-3)])),
        ],
        mesh,
        materials: vec![Material { strength: Some(strength), friction: 0.5, damping: 0.05, ..granite() }],
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

#[test]
fn a_model_far_away_does_the_same_to_the_last_bit() {
    let mut near = Simulation::new(crash([0.0; 2]), 1).expect("a model");
    let mut far = Simulation::new(crash(FAR), 1).expect("a model");
    for _ in 0..4 {
        near.advance(500).expect("steps");
        far.advance(500).expect("steps");
        let (a, b) = (near.snapshot(), far.snapshot());
        assert_eq!((&a.displacements, &a.velocities), (&b.displacements, &b.velocities));
        assert_eq!((&a.stresses, &a.damage), (&b.stresses, &b.damage));
        assert_eq!(near.energies(), far.energies());
        assert_eq!([0, 1].map(|k| near.force(k)), [0, 1].map(|k| far.force(k)));
        // Positions are in the coordinates of the model.
        let moved = |[x, y]: [f64; 2]| [x + FAR[0], y + FAR[1]];
        assert_eq!(a.positions.iter().copied().map(moved).collect::<Vec<_>>(), b.positions);
        let ends =
            |snapshot: &Snapshot| -> Vec<_> { snapshot.cracks.iter().map(|crack| crack.corners).collect() };
        assert_eq!(ends(&a).into_iter().map(|ends| ends.map(moved)).collect::<Vec<_>>(), ends(&b));
    }
    let counts = near.counts();
    assert!(counts.broken > 5 && counts.contacts > 5, "it should have broken: {counts:?}");
}

#[test]
fn a_run_far_away_goes_on_bit_for_bit() {
    let mut whole = Simulation::new(crash(FAR), 2).expect("a model");
    whole.advance(1100).expect("steps");
    let saved = postcard::to_allocvec(&whole.state()).expect("bytes");
    let state: State = postcard::from_bytes(&saved).expect("a state");
    let mut resumed = Simulation::resume(crash(FAR), state, 1).expect("the same model");
    whole.advance(700).expect("steps");
    resumed.advance(700).expect("steps");
    assert_eq!(resumed.snapshot(), whole.snapshot());
    assert_eq!(resumed.energies(), whole.energies());
}
