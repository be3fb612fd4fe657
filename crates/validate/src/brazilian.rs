//! Brazilian test: a disc between two platens. Elastic stress, tensile strength, and a crack along the loaded
//! diameter.

use std::f64::consts::PI;

use fdem_simulation::Simulation;

use super::models::{advance, start};
use super::rocks::{prepared, stress_near};
use super::{Outcome, Size};

/// m.
const DIAMETER: f64 = 0.05;
/// Pa.
const STRENGTH: f64 = 1e6;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = elastic(size)?;
    let seeds = size.choose(1..=2, 1..=5);
    let count = seeds.clone().count();
    let (mut strengths, mut away) = (Vec::new(), Vec::new());
    let (mut imbalance, mut balance) = (0.0_f64, 0.0_f64);
    for seed in seeds {
        let split = split(size, seed)?;
        strengths.push(split.strength);
        imbalance = imbalance.max(split.imbalance);
        away.push(split.away);
        balance = balance.max(split.balance.abs());
    }
    let mean = strengths.iter().sum::<f64>() / count as f64;
    let scatter = strengths.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count as f64 - 1.0);
    outcomes.extend([
        Outcome::relative(format!("mean strength of {count} meshes, 2 P/(π D)"), STRENGTH, mean, 0.05, "Pa"),
        Outcome::absolute("scatter of the strength over its mean", 0.0, scatter.sqrt() / mean, 0.05, ""),
        Outcome::absolute("difference of the two loads at the peak over the load", 0.0, imbalance, 0.05, ""),
        Outcome::absolute(
            "distance of the cracks from the diameter over the radius, mean",
            0.0,
            away.iter().sum::<f64>() / count as f64,
            0.2,
            "",
        ),
        Outcome::absolute("the largest of these", 0.0, away.into_iter().fold(0.0, f64::max), 0.3, ""),
        Outcome::absolute("error of the energy balance", 0.0, balance, 1e-2, ""),
    ]);
    Ok(outcomes)
}

/// A model of the disc. `rock`: the keys of its strength, empty for none.
fn model(mesh_size: f64, seed: u32, end: f64, damping: f64, rock: &str) -> String {
    format!(
        r#"
[model]
plane = "stress"
gravity = "none"
end_time = {end:e}
[[body]]
name = "disc"
material = "rock"
disc = {{ centre = [0, 0], radius = 0.025 }}
mesh_size = {mesh_size}
seed = {seed}
[[body]]
name = "upper platen"
material = "steel"
rectangle = {{ min = [-0.008, 0.025], max = [0.008, 0.029] }}
mesh_size = {mesh_size}
[[body]]
name = "lower platen"
material = "steel"
rectangle = {{ min = [-0.008, -0.029], max = [0.008, -0.025] }}
mesh_size = {mesh_size}
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.3
damping = {damping}
friction = 0.3
{rock}
[[material]]
name = "steel"
density = 7800
youngs_modulus = 200e9
poissons_ratio = 0.3
damping = {damping}
friction = 0.1
[[boundary]]
name = "upper"
body = "upper platen"
side = "top"
velocity = [0, -0.02]
ramp = 0.2e-3
[[boundary]]
name = "lower"
body = "lower platen"
side = "bottom"
velocity = [0, 0.02]
ramp = 0.2e-3
"#
    )
}

/// Stress in the centre of a disc that does not break.
fn elastic(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(1.4e-3, 0.9e-3);
    let end = 0.5e-3;
    let mut run = start(prepared(&model(mesh_size, 1, end, 0.5, ""))?)?;
    // The mean over the last tenth of the time: the disc still swings a little after the ramp.
    let (mut stress, mut load, samples) = ([0.0; 2], 0.0, 50);
    let steps = (end / run.time_step()) as u64;
    advance(&mut run, steps * 9 / 10)?;
    for _ in 0..samples {
        advance(&mut run, steps / 10 / samples)?;
        let [xx, yy, _] = stress_near(&run, [0.0, 0.0], 0.003);
        let forces = [0, 1].map(|boundary| run.force(boundary).unwrap_or_default()[1].abs());
        stress = [stress[0] + xx, stress[1] + yy];
        load += 0.5 * (forces[0] + forces[1]);
    }
    let [xx, yy] = stress.map(|s| s / samples as f64);
    let unit = 2.0 * load / samples as f64 / (PI * DIAMETER);
    Ok(vec![
        Outcome::relative(
            "elastic stress across the diameter in the centre, 2 P/(π D)",
            unit,
            xx,
            0.03,
            "Pa",
        ),
        Outcome::relative("elastic stress along it, -6 P/(π D)", -3.0 * unit, yy, 0.03, "Pa"),
    ])
}

struct Split {
    strength: f64,
    imbalance: f64,
    away: f64,
    balance: f64,
}

fn split(size: Size, seed: u32) -> Result<Split, String> {
    let mesh_size = size.choose(1.6e-3, 1.4e-3);
    // Cohesion and friction of a granite. With a cohesion of 3 f and 17° the elastic stress on the diameter
    // reaches the strength of Mohr and Coulomb at 0.8 of the radius when the tension in the centre is 0.7 f:
    // such a rock shears beneath the platens first.
    let rock = "tensile_strength = 1e6\ncohesion = 4e6\nfriction_angle = 45\nfracture_energy_i = 3\nfracture_energy_ii = 30";
    let end = 1.4e-3;
    let mut run = start(prepared(&model(mesh_size, seed, end, 0.1, rock))?)?;
    let steps = (end / run.time_step()) as u64;
    let samples = 1000;
    let (mut peak, mut imbalance) = (0.0_f64, 0.0);
    for _ in 0..samples {
        // Means over several steps, because stress waves disturb single steps.
        let mut forces = [0.0; 2];
        for _ in 0..4 {
            advance(&mut run, (steps / samples / 4).max(1))?;
            for (boundary, force) in forces.iter_mut().enumerate() {
                *force += 0.25 * run.force(boundary).unwrap_or_default()[1].abs();
            }
        }
        let load = 0.5 * (forces[0] + forces[1]);
        if load > peak {
            peak = load;
            imbalance = (forces[0] - forces[1]).abs() / load;
        }
        // Joints that break after the halves have separated do not belong to the crack.
        if load < 0.7 * peak && middle_crack(&run)[0] >= 0.5 * DIAMETER {
            break;
        }
        if load < 0.02 * peak && run.counts().broken > 10 {
            break;
        }
    }
    let [length, away] = middle_crack(&run);
    if length < 0.25 * DIAMETER {
        return Err(format!("the disc of mesh {seed} does not split"));
    }
    let away = away / (0.5 * DIAMETER);
    Ok(Split { strength: 2.0 * peak / (PI * DIAMETER), imbalance, away, balance: run.energies().error() })
}

/// Length of the broken joints in the middle half of the diameter, away from the platens, and their mean
/// distance from the diameter.
fn middle_crack(run: &Simulation) -> [f64; 2] {
    let (mut sum, mut length) = (0.0, 0.0);
    for crack in run.snapshot().cracks.iter().filter(|crack| crack.time.is_some()) {
        let [x, y] = [0, 1].map(|axis| 0.5 * (crack.corners[0][axis] + crack.corners[1][axis]));
        if y.abs() < 0.25 * DIAMETER {
            sum += x.abs() * crack.measure;
            length += crack.measure;
        }
    }
    [length, sum / f64::max(length, f64::MIN_POSITIVE)]
}
