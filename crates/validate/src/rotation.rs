//! Rotation: it causes no strain, changes no energy or momentum, and turns results with the model.

use std::f64::consts::TAU;

use fdem_simulation::{Boundary, Load, Material, Model, Schedule, Snapshot, Target, TimeOptions};

use super::models::{
    advance, advance_to, disc, granite, momentum, rectangle, rotated, start, together, turned, worse,
};
use super::{Outcome, Size};

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = vec![Outcome::absolute("largest strain in a turn", 0.0, led()?, 1e-12, "")];
    outcomes.extend(free(size.choose(5.0, 2.0))?);
    Ok(outcomes)
}

/// Speed at which one disc meets the other, m/s.
const SPEED: f64 = 5.0;

/// Two discs that meet off centre, under gravity and with friction, and the same model turned by some angles:
/// the largest differences of displacements, velocities and stresses.
pub(super) fn objectivity(size: Size) -> Result<Vec<Outcome>, String> {
    let steps = size.choose(1500, 4000);
    let straight = meeting(0.0, steps)?;
    let mut outcomes = Vec::new();
    for degrees in [33.0_f64, 90.0, 200.0] {
        let angle = degrees.to_radians();
        let turned = meeting(angle, steps)?;
        let vectors = |of: fn(&Snapshot) -> &Vec<[f64; 2]>, scale| {
            difference(of(&straight).iter().map(|&v| rotated(v, angle)), of(&turned).iter().copied()) / scale
        };
        // The mean stress and the radius of Mohr's circle do not turn.
        let invariants = |snapshot: &Snapshot| -> Vec<[f64; 2]> {
            let of = |[xx, yy, _, xy, ..]: &[f64; 6]| [0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(*xy)];
            snapshot.stresses.iter().map(of).collect()
        };
        let stresses = difference(invariants(&straight).into_iter(), invariants(&turned).into_iter());
        let path = SPEED * straight.time;
        for (what, found) in [
            ("displacements, over the path of the disc", vectors(|snapshot| &snapshot.displacements, path)),
            ("velocities, over that of the disc", vectors(|snapshot| &snapshot.velocities, SPEED)),
            ("stresses, over ρ c v/2", stresses / impact_stress()),
        ] {
            let name = format!("turned by {degrees}°: difference of {what}");
            outcomes.push(Outcome::absolute(name, 0.0, found, 1e-10, ""));
        }
    }
    Ok(outcomes)
}

/// Largest difference of the vectors of two lists.
fn difference(one: impl Iterator<Item = [f64; 2]>, other: impl Iterator<Item = [f64; 2]>) -> f64 {
    one.zip(other).fold(0.0, |most, (a, b)| worse((a[0] - b[0]).hypot(a[1] - b[1]), most))
}

/// Stress behind the wave of an impact of two bars at this speed, Pa.
fn impact_stress() -> f64 {
    0.5 * SPEED * (rock().density * rock().youngs_modulus).sqrt()
}

/// Snapshot of two discs that meet, after `steps` steps, with the whole model turned by an angle.
fn meeting(angle: f64, steps: u64) -> Result<Snapshot, String> {
    let body = disc(0.5, 5);
    let mesh = turned(&together(&[body.clone(), turned(&body, 0.3, [0.3, 0.96])]), angle, [0.0; 2]);
    let count = body.nodes.len();
    let velocities =
        [vec![[0.0; 2]; count], vec![rotated([0.6 * SPEED, -0.8 * SPEED], angle); count]].concat();
    let model = Model {
        mesh,
        velocities,
        materials: vec![Material { friction: 0.3, damping: 0.02, ..rock() }],
        gravity: rotated([0.0, -9.81], angle),
        ..Model::default()
    };
    let mut run = start(model)?;
    let mut met = false;
    for _ in 0..steps / 10 {
        advance(&mut run, 10)?;
        met |= run.counts().contacts > 0;
    }
    if met { Ok(run.snapshot()) } else { Err("the discs do not meet".to_owned()) }
}

fn rock() -> Material {
    Material { poissons_ratio: 0.25, ..granite() }
}

/// Leads all nodes of a block through a full turn, by a degree in each step. Returns the largest stress over
/// Young's modulus.
fn led() -> Result<f64, String> {
    let mesh = rectangle([0.2, -0.1], [0.8, 0.2], [4, 2]);
    let (steps, step) = (360, 1e-3);
    let mut boundaries = Vec::new();
    for (node, &origin) in mesh.nodes.iter().enumerate() {
        for axis in 0..2 {
            let row = |k: usize| {
                let angle = TAU * k as f64 / f64::from(steps);
                [step * k as f64, rotated(origin, angle)[axis] - origin[axis]]
            };
            boundaries.push(Boundary {
                name: format!("node {node} along {axis}"),
                target: Target::Nodes(vec![node as u32]),
                load: Load::Displacement(std::array::from_fn(|other| (other == axis).then_some(1.0))),
                schedule: Schedule::Table((0..=steps as usize).map(row).collect()),
            });
        }
    }
    let time = TimeOptions { step: Some(step), ..TimeOptions::default() };
    let mut run = start(Model { mesh, materials: vec![rock()], boundaries, time, ..Model::default() })?;
    let mut largest = 0.0;
    // One more step, because stresses are those at the beginning of a step.
    for _ in 0..=steps {
        advance(&mut run, 1)?;
        let stresses = run.snapshot().stresses;
        largest = stresses.iter().flatten().fold(largest, |largest, &stress| worse(stress, largest));
    }
    Ok(largest.abs() / rock().youngs_modulus)
}

/// Energy and momenta of a block that flies freely and spins, in rad/s, for one turn.
fn free(spin: f64) -> Result<[Outcome; 3], String> {
    let mesh = rectangle([-0.5, -0.25], [0.5, 0.25], [6, 3]);
    let velocities = mesh.nodes.iter().map(|[x, y]| [3.0 - spin * y, -2.0 + spin * x]).collect();
    let mut run = start(Model { mesh, velocities, materials: vec![rock()], ..Model::default() })?;
    advance(&mut run, 1)?;
    let (before, kinetic) = (momentum(&run), run.energies().kinetic);
    let (mut drift, turn) = (0.0, TAU / spin);
    for part in 1..=100 {
        advance_to(&mut run, turn * f64::from(part) / 100.0)?;
        drift = worse(run.energies().balance() / kinetic, drift);
    }
    let after = momentum(&run);
    let change = |k: usize| after[k] - before[k];
    let linear = change(0).hypot(change(1)) / before[0].hypot(before[1]);
    Ok([
        Outcome::absolute("drift of the energy of a free block in a turn", 0.0, drift, 1e-9, ""),
        Outcome::absolute("change of its linear momentum", 0.0, linear, 1e-11, ""),
        Outcome::absolute("change of its angular momentum", 0.0, change(2) / before[2], 1e-11, ""),
    ])
}
