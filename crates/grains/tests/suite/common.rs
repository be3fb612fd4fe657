//! Models that several tests use.

use fdem_grains::*;

pub(crate) fn material(youngs_modulus: f64, poissons_ratio: f64, density: f64) -> GrainMaterial {
    GrainMaterial { density, youngs_modulus, poissons_ratio }
}

/// One sphere above the plane z = 0, which it touches at once.
pub(crate) fn on_plane(
    radius: f64,
    velocity: [f64; 3],
    spin: [f64; 3],
    of: [GrainMaterial; 2],
) -> GrainModel {
    GrainModel {
        spheres: Spheres {
            positions: vec![[0.0, 0.0, radius]],
            radii: vec![radius],
            velocities: vec![velocity],
            spins: vec![spin],
            ..Spheres::default()
        },
        walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 1)],
        materials: of.to_vec(),
        surfaces: vec![Surfaces::smooth([0, 1])],
        ..GrainModel::default()
    }
}

/// Runs until the sphere has left the plane again. Returns the largest force, the largest overlap and the
/// time.
pub(crate) fn bounce(model: GrainModel) -> (GrainRun, f64, f64, f64) {
    let radius = model.spheres.radii[0];
    let mut run = GrainRun::new(model, 1).expect("a model");
    let (mut force, mut overlap, mut time) = (0.0_f64, 0.0_f64, 0.0);
    for _ in 0..10_000_000 {
        overlap = overlap.max(radius - run.position(0)[2]);
        run.advance(1).expect("a step");
        force = force.max(-run.wall_force(0)[2]);
        if run.position(0)[2] > radius && run.velocity(0)[2] > 0.0 && run.wall_force(0) == [0.0; 3] {
            time = run.time();
            break;
        }
    }
    (run, force, overlap, time)
}

/// Numbers from 0 to 1, always the same for a seed.
pub(crate) fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A box with one side, m, which repeats along all axes.
pub(crate) fn cube(side: f64) -> Domain {
    Domain {
        low: [0.0; 3],
        high: [side; 3],
        periodic: [true; 3],
        strain_rates: [0.0; 3],
        strain_from: 0.0,
        servo: None,
        outside: Outside::Stop,
    }
}

/// The state of a run.
pub(crate) fn bytes(run: &GrainRun) -> Vec<u8> {
    postcard::to_allocvec(&run.state()).expect("bytes")
}
