//! Many spheres: momentum and energy of collisions, the energy balance of a collapse, and equal results for
//! all numbers of threads and after a saved state.

use fdem_grains::{ForceLaw, GrainModel, GrainRun, GrainState, Spheres, Surfaces, Wall, WallShape};

use super::models::{GRAVITY, advance_to, mass, material, scatter, start};
use crate::outcome::{Outcome, Size};

/// m.
const RADIUS: f64 = 2.5e-3;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for law in [ForceLaw::HertzMindlin, ForceLaw::Hooke { normal: 1e3, tangential: 0.8 }] {
        outcomes.extend(gas(law, size.choose(6, 12))?);
    }
    outcomes.extend(balance(size)?);
    outcomes.extend(repeats(size)?);
    Ok(outcomes)
}

/// Spheres of different sizes that fly in all directions and collide, without damping and friction.
fn gas(law: ForceLaw, side: usize) -> Result<Vec<Outcome>, String> {
    let count = side * side * side;
    let place = |k: usize| [k % side, k / side % side, k / (side * side)].map(|x| 2.6 * RADIUS * x as f64);
    let radius = |k: usize| RADIUS * (1.0 + 0.2 * scatter(k));
    // Towards the centre, and past it.
    let middle = 1.3 * RADIUS * (side - 1) as f64;
    let velocity = |k: usize| {
        let at = place(k);
        [0, 1, 2].map(|axis| 0.3 * scatter(3 * k + axis + 7) + 20.0 * (middle - at[axis]))
    };
    let of = material(1e7, 0.25, 2500.0);
    let model = GrainModel {
        spheres: Spheres {
            positions: (0..count).map(place).collect(),
            radii: (0..count).map(radius).collect(),
            velocities: (0..count).map(velocity).collect(),
            ..Spheres::default()
        },
        materials: vec![of],
        surfaces: vec![Surfaces::smooth([0, 0])],
        law,
        ..GrainModel::default()
    };
    let mut run = start(GrainModel { step: Some(0.5 * model.safe_step()), ..model })?;
    let momentum = |run: &GrainRun| {
        let mut sum = [0.0; 3];
        let mut size = 0.0;
        for k in 0..count {
            let (mass, velocity) = (mass(radius(k), of), run.velocity(k));
            for axis in 0..3 {
                sum[axis] += mass * velocity[axis];
                size += (mass * velocity[axis]).abs();
            }
        }
        (sum, size)
    };
    let (before, scale) = momentum(&run);
    let energy = |run: &GrainRun| run.energies().kinetic + run.energies().elastic;
    let energy_before = energy(&run);
    let mut hits = 0;
    for _ in 0..100 {
        advance_to_next(&mut run, 1e-3)?;
        hits += run.contacts().len();
    }
    if hits < count {
        return Err(format!("{hits} contacts of {count} spheres"));
    }
    let (after, _) = momentum(&run);
    let worst = (0..3).map(|axis| (after[axis] - before[axis]).abs() / scale).fold(0.0, f64::max);
    let name = if matches!(law, ForceLaw::HertzMindlin) { "Hertz" } else { "Hooke" };
    Ok(vec![
        Outcome::absolute(format!("momentum of {count} spheres, as a share, {name}"), 0.0, worst, 1e-13, ""),
        Outcome::relative(
            format!("energy of {count} spheres, {name}"),
            energy_before,
            energy(&run),
            1e-3,
            "J",
        ),
    ])
}

fn advance_to_next(run: &mut GrainRun, time: f64) -> Result<(), String> {
    let end = run.time() + time;
    advance_to(run, end)
}

/// A column in a box of planes without one side, which collapses.
fn column(size: Size) -> GrainModel {
    let [across, deep, high] = size.choose([6, 4, 12], [12, 8, 24]);
    let count = across * deep * high;
    let pitch = 2.3 * RADIUS;
    let place = |k: usize| {
        let cell = [k % across, k / across % deep, k / (across * deep)];
        [0, 1, 2].map(|axis| pitch * (cell[axis] as f64 + 0.5) + 0.1 * RADIUS * scatter(3 * k + axis))
    };
    let wall = |point: [f64; 3], normal: [f64; 3]| Wall::plane(point, normal, 0);
    GrainModel {
        spheres: Spheres {
            positions: (0..count).map(place).collect(),
            radii: (0..count).map(|k| RADIUS * (1.0 + 0.1 * scatter(k))).collect(),
            ..Spheres::default()
        },
        walls: vec![
            wall([0.0; 3], [0.0, 0.0, 1.0]),
            wall([0.0; 3], [1.0, 0.0, 0.0]),
            wall([0.0; 3], [0.0, 1.0, 0.0]),
            wall([0.0, pitch * deep as f64, 0.0], [0.0, -1.0, 0.0]),
            // A tube that turns, beside the column: spheres that reach it are lifted.
            Wall {
                shape: WallShape::Tube {
                    axis: [[0.0; 3], [0.0, 1.0, 0.0]],
                    radius: 2.0 * pitch * high as f64,
                },
                ..wall([0.0; 3], [0.0, 0.0, 1.0])
            },
        ],
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces {
            friction: 0.5,
            restitution: 0.5,
            rolling_friction: 0.1,
            rolling_damping: 0.3,
            twisting_friction: 0.05,
            ..Surfaces::smooth([0, 0])
        }],
        gravity: [0.0, 0.0, -GRAVITY],
        ..GrainModel::default()
    }
}

/// The energy balance of a collapse: the loss of the weight is the energy that contacts dissipate, store and
/// move.
fn balance(size: Size) -> Result<Vec<Outcome>, String> {
    let mut model = column(size);
    model.step = Some(0.25 * model.safe_step());
    let mut run = start(model)?;
    let before = run.energies();
    advance_to(&mut run, size.choose(0.15, 0.4))?;
    let after = run.energies();
    let released = before.weight - after.weight;
    let kept = after.kinetic + after.rotational + after.elastic;
    let error = (released + after.external - kept - after.dissipated) / released;
    Ok(vec![Outcome::absolute(
        "energy balance of a collapse, over the energy released",
        0.0,
        error,
        5e-3,
        "",
    )])
}

/// Equal states for 1, 2 and 3 threads, and after a state that was saved.
fn repeats(size: Size) -> Result<Vec<Outcome>, String> {
    let model = column(size);
    let run_on = |threads: usize| -> Result<GrainRun, String> {
        let mut run = GrainRun::new(model.clone(), threads).map_err(|error| error.to_string())?;
        run.advance(1500).map_err(|error| error.to_string())?;
        Ok(run)
    };
    let whole = run_on(1)?.state();
    let mut differing = 0;
    for threads in [2, 3] {
        differing += usize::from(run_on(threads)?.state() != whole);
    }
    let mut half = GrainRun::new(model.clone(), 1).map_err(|error| error.to_string())?;
    half.advance(700).map_err(|error| error.to_string())?;
    let saved: GrainState = half.state();
    let mut resumed = GrainRun::resume(model, saved, 2).map_err(|error| error.to_string())?;
    resumed.advance(800).map_err(|error| error.to_string())?;
    differing += usize::from(resumed.state() != whole);
    Ok(vec![Outcome::absolute(
        "states that differ: 1, 2 and 3 threads, and resumed",
        0.0,
        differing as f64,
        0.0,
        "",
    )])
}
