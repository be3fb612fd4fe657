//! Joints under pressure that are sheared along any direction of their plane.

use fdem_simulation::{FractureOptions, Insertion, Interface, Load, Material, Model, Schedule, Strength};

use super::bodies::{
    Point, Run, advance, advance_to, centroid, cuboid, dot, faces_where, force, jittered, loaded, on_box,
    start,
};
use crate::models::{granite, moved, nodes_where, rock};
use crate::{Outcome, Size};

/// Width of a cell, m.
const CELL: f64 = 0.002;

/// Height of a block, m. Blocks are flat, so that their free sides have little influence on the stress.
const HEIGHT: f64 = 0.0005;

/// Time in which the pressure rises, s: many times the period in which the heavy platens swing on the blocks.
/// In a third of it the normal stress still swings by 6 %, and the peak with it.
const PRESSING: f64 = 3e-4;

/// Speeds, m/s: up to the peak, and while the joints break.
const SPEEDS: [f64; 2] = [0.01, 0.2];

/// A shear box of two flat blocks with joints between them, under a normal stress σ. The shear stress peaks
/// at `c + σ tan φ` and falls to `σ tan φ`; it acts against the motion, for any direction of the motion in
/// the plane. Half of the way the direction changes by 90°, and friction follows.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let stresses: &[f64] = size.choose(&[4e6], &[2e6, 4e6, 8e6]);
    let some = size.choose([&[35.0] as &[f64], &[90.0]], [&[0.0, 35.0, 90.0, 200.0] as &[f64]; 2]);
    for (name, insertion, ways) in
        [("adaptive", Insertion::Adaptive, some[0]), ("intrinsic", Insertion::Intrinsic, some[1])]
    {
        for &stress in stresses {
            for &way in ways {
                let sheared = shear(size.choose(3, 5), insertion, stress, way)?;
                let case = |what: &str| format!("{what}, {} MPa, along {way}°, {name}", stress / 1e6);
                let residual = stress * rock().friction;
                outcomes.extend([
                    Outcome::relative(case("peak"), rock().cohesion + residual, sheared.peak, 0.02, "Pa"),
                    Outcome::relative(case("residual"), residual, sheared.residual, 0.02, "Pa"),
                    Outcome::absolute(
                        case("shear across the motion over the peak"),
                        0.0,
                        sheared.across,
                        0.02,
                        "",
                    ),
                    Outcome::relative(case("residual after the turn"), residual, sheared.turned, 0.02, "Pa"),
                    Outcome::absolute(case("error of the energy balance"), 0.0, sheared.balance, 1e-3, ""),
                ]);
            }
        }
    }
    Ok(outcomes)
}

struct SpaceShearBox {
    /// Pa.
    peak: f64,
    residual: f64,
    turned: f64,
    /// Shares.
    across: f64,
    balance: f64,
}

fn shear(cells: usize, insertion: Insertion, stress: f64, way: f64) -> Result<SpaceShearBox, String> {
    let width = CELL * cells as f64;
    let (min, max) = ([0.0, 0.0, -2.0 * HEIGHT], [width, width, 2.0 * HEIGHT]);
    let mut mesh = jittered(&cuboid(min, max, [cells, cells, 4]), 0.1 * HEIGHT, 1, |place| {
        let [x, y, z] = on_box(min, max)(place);
        [x, y, z || place[2].abs() < 1e-9 || (place[2].abs() - HEIGHT).abs() < 1e-9]
    });
    for element in 0..mesh.elements.len() {
        let z = centroid(&mesh, element)[2];
        mesh.materials[element] = match z {
            z if z.abs() > HEIGHT => 2,
            z if z > 0.0 => 1,
            _ => 0,
        };
    }
    let held = nodes_where(&mesh, |p: Point| p[2] < -0.9 * HEIGHT);
    let pushed = nodes_where(&mesh, |p: Point| p[2] > 0.9 * HEIGHT);
    let faces = faces_where(&mesh, |p| p[2] > 1.9 * HEIGHT);
    let (sin, cos) = way.to_radians().sin_cos();
    let rock_of_blocks = Material { density: 16.0 * 2700.0, youngs_modulus: 30e9, damping: 0.1, ..granite() };
    let platen = Material {
        density: 100.0 * rock_of_blocks.density,
        youngs_modulus: 100.0 * rock_of_blocks.youngs_modulus,
        ..rock_of_blocks.clone()
    };
    let strength = Strength { energy_ii: 20.0, ..rock() };
    let critical = strength.energy_ii / (0.386 * strength.cohesion);
    // Up to the peak; until all is broken; and as far again to the side.
    let peak = 2.0 * PRESSING + 8e-7 / SPEEDS[0];
    let broken = peak + PRESSING + 1.5 * critical / SPEEDS[1];
    let aside = broken + 0.5 * PRESSING;
    let (slow, fast) = (SPEEDS[0], SPEEDS[1]);
    let along = [
        [2.0 * PRESSING, 0.0],
        [2.0 * PRESSING + 1e-5, slow],
        [peak, slow],
        [peak + PRESSING, fast],
        [broken, fast],
        [aside, 0.0],
    ];
    let side = [[broken, 0.0], [aside, fast]];
    let mix = |u: f64, v: f64| Schedule::Table(merged(&along, &side, u, v));
    let model = Model {
        mesh,
        materials: vec![rock_of_blocks.clone(), rock_of_blocks, platen],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: rock().friction,
            penalty: None,
            strength: Some(strength),
        }],
        boundaries: vec![
            moved("lower", held, [Some(0.0); 3], Schedule::Constant),
            moved("upper along x", pushed.clone(), [Some(1.0), None, None], mix(cos, -sin)),
            moved("upper along y", pushed.clone(), [None, Some(1.0), None], mix(sin, cos)),
            loaded("pressure", faces, Load::Pressure(stress), Schedule::Ramp(PRESSING)),
        ],
        fracture: FractureOptions { insertion, joint_penalty: 20.0, ..FractureOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance_to(&mut run, 2.0 * PRESSING)?;
    let (mut most, mut across) = (0.0_f64, 0.0_f64);
    let ways = [[cos, sin, 0.0], [-sin, cos, 0.0]];
    // The force on the lower block, which does not move, contains no inertia.
    let traction = |run: &Run| -> Result<[f64; 2], String> {
        let on = force(run, 0)?;
        Ok(ways.map(|way| -dot(on, way) / (width * width)))
    };
    let (mut residual, mut count) = (0.0, 0.0);
    while run.time() < broken {
        advance(&mut run, 1)?;
        let [forward, aside] = traction(&run)?;
        most = most.max(forward);
        across = across.max(aside.abs());
        if run.time() > peak + 0.9 * (broken - peak) {
            residual += forward;
            count += 1.0;
        }
    }
    if run.counts().joints > 0 {
        return Err(format!("{} joints hold", run.counts().joints));
    }
    let residual = residual / count;
    advance_to(&mut run, aside + 0.5 * PRESSING)?;
    let (mut later, mut count) = (0.0, 0.0);
    while run.time() < aside + PRESSING {
        advance(&mut run, 1)?;
        later += traction(&run)?[1];
        count += 1.0;
    }
    Ok(SpaceShearBox {
        peak: most,
        residual,
        turned: later / count,
        across: across / most,
        balance: run.energies().error(),
    })
}

/// The sum of two tables of times and values, times factors.
fn merged(one: &[[f64; 2]], other: &[[f64; 2]], u: f64, v: f64) -> Vec<[f64; 2]> {
    let mut times: Vec<f64> = one.iter().chain(other).map(|row| row[0]).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let at = |rows: &[[f64; 2]], time: f64| Schedule::Table(rows.to_vec()).factor(time);
    times.into_iter().map(|time| [time, u * at(one, time) + v * at(other, time)]).collect()
}
