//! Brazilian test of a thick disc: its strength.
//!
//! Two narrow strips of the surface are moved towards each other. The force of a node at the angle `φ` to the
//! loaded diameter acts along a chord: it and its opposite make the tension `s cos φ (2 cos 2φ - 1)` in the
//! centre, the sum of two radial fields and an even tension (Timoshenko and Goodier, 41), with
//! `s = 2 P/(π D t)`. The disc splits where the sum over all nodes, the mean over the thickness, is the
//! strength of the material.

use std::f64::consts::PI;

use fdem_simulation::{ContactOptions, FractureOptions, Schedule};

use super::bodies::{Point, advance, start};
use super::disc::{RADIUS, THICKNESS, disc};
use crate::models::{moved, nodes_where, worse};
use crate::{Outcome, Size};

/// Tensile strength, Pa.
const STRENGTH: f64 = 3e6;
/// Speed of each strip, m/s.
const SPEED: f64 = 0.05;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let seeds = size.choose(1..=1, 1..=5);
    let count = seeds.clone().count() as f64;
    let (mut strengths, mut balance) = (Vec::new(), 0.0_f64);
    for seed in seeds {
        let [strength, error] = split(seed)?;
        strengths.push(strength);
        balance = balance.max(error.abs());
    }
    let mean = strengths.iter().sum::<f64>() / count;
    let meshes = if count > 1.0 { format!("mean strength of {count} meshes") } else { "strength".to_owned() };
    let mut outcomes = vec![
        Outcome::relative(format!("{meshes}, 2 P/(π D t)"), STRENGTH, mean, 0.08, "Pa"),
        Outcome::absolute("error of the energy balance", 0.0, balance, 1e-3, ""),
    ];
    if count > 1.0 {
        let farthest = strengths.iter().map(|strength| strength - STRENGTH).fold(0.0, worse);
        outcomes.push(Outcome::relative("the farthest from it", STRENGTH, STRENGTH + farthest, 0.08, "Pa"));
        let squares: f64 = strengths.iter().map(|strength| (strength - mean).powi(2)).sum();
        let scatter = (squares / (count - 1.0)).sqrt() / mean;
        outcomes.push(Outcome::absolute("scatter of the strength over its mean", 0.0, scatter, 0.1, ""));
    }
    Ok(outcomes)
}

/// Strength, Pa, and error of the energy balance.
fn split(seed: u32) -> Result<[f64; 2], String> {
    // The process zone, E G/f², is a fifth of the diameter.
    let rock = format!(
        "tensile_strength = {STRENGTH}\ncohesion = 12e6\nfriction_angle = 45\nfracture_energy_i = 3\nfracture_energy_ii = 30\ndamping = 0.1"
    );
    let body = format!(
        "seed = {seed}\nrefine = [{{ box = [-0.004, -0.02, -0.03, 0.004, 0.02, 0.03], size = 4e-3 }}]"
    );
    let mut model = disc(7e-3, [&body, &rock])?;
    let strip = |sign: f64| nodes_where(&model.mesh, |p: Point| sign * p[2] > RADIUS * f64::cos(0.15));
    let strips = [strip(-1.0), strip(1.0)];
    for (sign, nodes) in [1.0, -1.0].into_iter().zip(strips) {
        model.boundaries.push(moved("strip", nodes, [None, None, Some(sign * SPEED)], Schedule::Ramp(1e-4)));
    }
    // Softer contacts and joints allow longer steps.
    model.contact = ContactOptions { penalty: 0.5, ..model.contact };
    model.fracture = FractureOptions { joint_penalty: 5.0, ..model.fracture };
    let mut run = start(model)?;
    let mut peak = 0.0_f64;
    loop {
        advance(&mut run, 10)?;
        // Both strips carry the same load: half of the sum over both.
        let mut sum = 0.0;
        for (place, force) in run.snapshot().positions.iter().zip(run.forces().reactions) {
            let angle = place[0].atan2(place[2].abs());
            sum += 0.5 * force[2].abs() * angle.cos() * (2.0 * (2.0 * angle).cos() - 1.0);
        }
        let tension = sum / (PI * RADIUS * THICKNESS);
        peak = peak.max(tension);
        if tension < 0.7 * peak && run.counts().broken > 10 {
            return Ok([peak, run.energies().error()]);
        }
        if run.time() > 2e-3 {
            return Err(format!("the disc of mesh {seed} does not split"));
        }
    }
}
