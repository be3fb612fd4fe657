//! Spheres and walls, alone and with bodies.

use crate::common::*;
use fdem_simulation::grains::{
    GrainMaterial, GrainModel, GrainRun, Spheres, Surfaces, Wall, WallRotation,
};
use fdem_simulation::*;

/// Granite as spheres have it.
fn grains_of(material: &Material) -> GrainMaterial {
    GrainMaterial {
        density: material.density,
        youngs_modulus: material.youngs_modulus,
        poissons_ratio: material.poissons_ratio,
    }
}

/// Spheres of granite that fall on a plane: 3 by 3 columns of 4, a little apart.
fn heap() -> GrainModel {
    let place = |k: usize| {
        let [i, j, l] = [k % 3, k / 3 % 3, k / 9].map(|n| n as f64);
        [0.021 * i + 0.003 * l, 0.021 * j - 0.002 * l, 0.0101 + 0.0205 * l]
    };
    GrainModel {
        spheres: Spheres {
            positions: (0..36).map(place).collect(),
            radii: (0..36).map(|k| 0.01 - 1e-4 * f64::from(k % 5)).collect(),
            velocities: vec![[0.1, 0.0, -0.5]; 36],
            ..Spheres::default()
        },
        walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)],
        materials: vec![GrainMaterial { youngs_modulus: 1e8, ..grains_of(&granite()) }],
        surfaces: vec![Surfaces { restitution: 0.6, friction: 0.4, ..Surfaces::smooth([0, 0]) }],
        gravity: [0.0, 0.0, -9.81],
        ..GrainModel::default()
    }
}

/// A model of spheres alone.
fn alone(grains: GrainModel) -> Model<3, 4> {
    Model { gravity: grains.gravity, grains: Some(grains), ..Model::default() }
}

#[test]
fn spheres_alone_move_as_in_their_own_run() {
    let mut run = Simulation::new(alone(heap()), 1).expect("a model");
    assert_eq!(run.critical_step().cause, Cause::Sphere);
    let step = run.time_step();
    assert!((step / heap().safe_step() - 1.0).abs() < 1e-15);
    run.advance(2000).expect("steps");
    let mut own = GrainRun::new(GrainModel { step: Some(step), ..heap() }, 1).expect("a model");
    own.advance(2000).expect("steps");
    let snapshot = run.snapshot();
    assert_eq!(snapshot.spheres, own.columns());
    assert!(snapshot.spheres.contacts.len() > 10, "{}", snapshot.spheres.contacts.len());
    let counts = run.counts();
    assert_eq!([counts.spheres, counts.nodes], [36, 0]);
    assert!(counts.sphere_contacts > 10, "{counts:?}");
    let energies = run.energies();
    assert!(energies.damping > 1e-3 && energies.error().abs() < 2e-3, "{energies:?}");
}

#[test]
fn a_resumed_run_of_spheres_has_the_same_bits() {
    let gravity = Schedule::Ramp(2e-3);
    let model = || Model { gravity_schedule: gravity.clone(), ..alone(heap()) };
    let mut whole = Simulation::new(model(), 1).expect("a model");
    whole.advance(900).expect("steps");
    let state = whole.state();
    whole.advance(600).expect("steps");
    let mut resumed = Simulation::resume(model(), state, 3).expect("a state of this model");
    resumed.advance(600).expect("steps");
    assert_eq!(whole.snapshot(), resumed.snapshot());
    assert_eq!(whole.energies(), resumed.energies());
    // The weight grows in time, and its work is that of the sphere's fall.
    assert!(whole.energies().error().abs() < 2e-3, "{:?}", whole.energies());
}

/// A sphere in free fall under a weight that grows.
#[test]
fn a_weight_that_grows_does_the_work_of_the_fall() {
    let spheres = Spheres { positions: vec![[0.3, 0.2, 5.0]], radii: vec![0.01], ..Spheres::default() };
    let grains = GrainModel { spheres, step: None, walls: Vec::new(), ..heap() };
    let mut model = alone(grains);
    model.gravity_schedule = Schedule::Table(vec![[0.0, 0.0], [0.02, 1.0], [0.05, -0.5]]);
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance((0.06 / run.time_step()) as u64).expect("steps");
    let energies = run.energies();
    assert!(energies.kinetic > 1e-6 && energies.balance().abs() < 1e-9 * energies.kinetic, "{energies:?}");
}

#[test]
fn wrong_numbers_of_spheres_are_refused() {
    let refused = |model: Model<3, 4>| Simulation::new(model, 1).expect_err("a wrong model").to_string();
    let mut grains = heap();
    grains.spheres.radii[7] = -1.0;
    assert_eq!(refused(alone(grains)), "grains: sphere 7: radius is -1e0, and must be above 0");
    assert_eq!(refused(Model::default()), "the model has no elements and no spheres");
    let discs = GrainModel { discs: Some(1.0), ..heap() };
    assert!(refused(alone(discs)).contains("thickness as discs"), "{}", refused(alone(heap())));
    let on_ranks = fdem_distributed::threads::run(2, |communicator| {
        let run = (communicator.rank() == 0).then(|| Simulation::new(alone(heap()), 1).expect("a model"));
        Distributed::new(communicator, run, 1).err().map(|error| error.to_string())
    });
    let told = "spheres and walls are not divided among ranks: run the model on one";
    assert_eq!(on_ranks, vec![Some(told.to_owned()); 2]);
}

/// A plane that turns about an axis, and moves, under spheres that lie on it.
#[test]
fn probes_measure_walls_and_spheres() {
    let mut grains = heap();
    grains.walls[0].rotation = Some(WallRotation { through: [0.02, 0.02, 0.0], spin: [0.0, 0.0, 2.0] });
    grains.walls[0].velocity = [0.0, 0.3, 0.0];
    let mut run = Simulation::new(alone(grains), 1).expect("a model");
    run.advance(1500).expect("steps");
    let probes = [
        Probe::Wall { wall: 0 },
        Probe::Wall { wall: 1 },
        Probe::Spheres { region: None },
        Probe::Spheres { region: Some([[-1.0, -1.0, -1.0], [1.0, 1.0, 0.02]]) },
    ];
    let values = run.measure(&probes);
    for (probe, values) in probes.iter().zip(&values) {
        assert_eq!(probe.columns().len(), values.len());
    }
    let columns = run.snapshot().spheres;
    let force = columns.wall_forces[0];
    assert_eq!(values[0][..3], force);
    assert!(force[2] < 0.0);
    assert!(values[0][3..6].iter().any(|moment| *moment != 0.0), "{values:?}");
    assert!((values[0][7] / (0.3 * run.time()) - 1.0).abs() < 1e-12, "{values:?}");
    assert!(values[1].iter().all(|value| value.is_nan()));
    let [all, low] = [&values[2], &values[3]];
    let contacts = columns.contacts.iter();
    let ends = contacts.map(|contact| match contact.other {
        grains::GrainPartner::Sphere(_) => 2.0,
        _ => 1.0,
    });
    assert_eq!(all[0], 36.0);
    assert!((all[1] - ends.sum::<f64>() / 36.0).abs() < 1e-12, "{all:?}");
    let below = columns.positions.iter().filter(|position| position[2] <= 0.02).count();
    assert_eq!(low[0], below as f64);
    assert!(below > 5 && below < 36);
    for of in [all, low] {
        assert!((of[10] + of[11] + of[12] - 1.0).abs() < 1e-12, "fabric of {of:?}");
        // Pressure under their own weight.
        assert!(of[6] < 0.0, "{of:?}");
    }
    // The kinetic energy at the positions differs from that half a step before.
    assert!((all[3] / run.energies().kinetic - 1.0).abs() < 0.05, "{} {:?}", all[3], run.energies());
}
