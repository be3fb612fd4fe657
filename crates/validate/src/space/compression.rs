//! Compression of a cylinder of tetrahedra until it fails: the strength of Mohr and Coulomb.

use std::f64::consts::PI;

use super::bodies::{advance, force, start};
use crate::models::{meshes, worse};
use crate::rocks::prepared_in_space;
use crate::{Outcome, Size};

/// Radius and height, m.
const RADIUS: f64 = 0.025;
const HEIGHT: f64 = 0.1;
/// Cohesion, Pa, and the angle of internal friction, degrees.
const COHESION: f64 = 6e6;
const ANGLE: f64 = 35.0;

/// Both ends move alike and are free to widen, as between platens without friction, so that the stress is
/// even until the cylinder fails.
///
/// The strength is that of the material if the cylinder fails where it first reaches it. The length `E G/c²`
/// of a process zone of shear is 12 mm here, half of the radius. If it is 62 mm (five times the fracture
/// energy), the joints of a shear plane soften so slowly that all of it, and other planes, have to slip
/// together: then the cylinder carries 1.22 times the strength.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let angle = ANGLE.to_radians();
    let expected = 2.0 * COHESION * angle.cos() / (1.0 - angle.sin());
    let seeds = size.choose(1..=1, 1..=3);
    let count = seeds.clone().count();
    let (mut mean, mut farthest, mut balance) = (0.0, 0.0, 0.0);
    for seed in seeds {
        let [strength, error] = crush(size, seed)?;
        mean += strength / count as f64;
        farthest = worse(strength - expected, farthest);
        balance = worse(error, balance);
    }
    Ok(vec![
        Outcome::relative(format!("mean strength of {}", meshes(count)), expected, mean, 0.08, "Pa"),
        Outcome::relative("the farthest from it", expected, expected + farthest, 0.08, "Pa"),
        Outcome::absolute("error of the energy balance", 0.0, balance, 1e-3, ""),
    ])
}

/// Strength, Pa, and error of the energy balance.
fn crush(size: Size, seed: u32) -> Result<[f64; 2], String> {
    let mut run = start(prepared_in_space(&model(size, seed))?)?;
    let area = PI * RADIUS * RADIUS;
    let (mut peak, samples) = (0.0_f64, 20);
    loop {
        // Means over some steps, because single ones are disturbed by stress waves.
        let mut load = 0.0;
        for _ in 0..samples {
            advance(&mut run, 1)?;
            load += 0.5 * (force(&run, 1)?[2] - force(&run, 0)?[2]) / f64::from(samples);
        }
        peak = peak.max(load);
        if load < 0.8 * peak && run.counts().broken > 20 {
            return Ok([peak / area, run.energies().error()]);
        }
        if run.time() > 3e-3 {
            return Err(format!("the cylinder of mesh {seed} does not fail"));
        }
    }
}

fn model(size: Size, seed: u32) -> String {
    let mesh_size = size.choose(12e-3, 8e-3);
    let speed = size.choose(0.3, 0.12);
    format!(
        r#"
[model]
gravity = "none"
end_time = 1
[[body]]
name = "core"
material = "sandstone"
cylinder = {{ from = [0, 0, 0], to = [0, 0, {HEIGHT}], radius = {RADIUS} }}
mesh_size = {mesh_size}
seed = {seed}
[[material]]
name = "sandstone"
density = 2300
youngs_modulus = 15e9
poissons_ratio = 0.25
damping = 0.1
friction = 0.6
tensile_strength = 3e6
cohesion = {COHESION}
friction_angle = {ANGLE}
fracture_energy_i = 6
fracture_energy_ii = 30
[[boundary]]
name = "upper"
group = "top"
velocity = ["free", "free", -{speed}]
ramp = 0.1e-3
[[boundary]]
name = "lower"
group = "bottom"
velocity = ["free", "free", {speed}]
ramp = 0.1e-3
[contact]
penalty = 0.5
[fracture]
joint_penalty = 10
"#
    )
}
