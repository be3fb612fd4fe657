//! Turning: no strain, and nothing lost.

use std::f64::consts::TAU;

use fdem_simulation::{Boundary, Load, Material, Model, Schedule, Target, TimeOptions};

use super::models::{advance, advance_to, granite, momentum, rectangle, rotated, start, worse};
use super::{Outcome, Size};

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = vec![Outcome::absolute("largest strain in a turn", 0.0, led()?, 1e-12, "")];
    outcomes.extend(free(size.choose(5.0, 2.0))?);
    Ok(outcomes)
}

fn rock() -> Material {
    Material { poissons_ratio: 0.25, ..granite() }
}

/// All nodes of a block are led through a full turn, a degree in each step. Returns the largest stress over Young's modulus.
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
    // One step more: stresses are those at the beginning of a step.
    for _ in 0..=steps {
        advance(&mut run, 1)?;
        let stresses = run.snapshot().stresses;
        largest = stresses.iter().flatten().fold(largest, |largest, &stress| worse(stress, largest));
    }
    Ok(largest.abs() / rock().youngs_modulus)
}

/// A block flies and spins, rad/s, for a turn: its energy and its momenta.
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
