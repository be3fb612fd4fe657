//! Uniaxial compression of a block until it fails: the bound of Mohr and Coulomb.

use super::models::{advance, start};
use super::rocks::prepared;
use super::{Outcome, Size};

/// Width of the block, m.
const WIDTH: f64 = 0.05;
/// Cohesion, Pa, and the tangent of the angle of internal friction.
const COHESION: f64 = 3e6;
const FRICTION: f64 = 0.3;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(3e-3, 1.8e-3);
    let end = 1.2e-3;
    let model = format!(
        r#"
[model]
plane = "stress"
gravity = "none"
end_time = {end:e}
[[body]]
name = "block"
material = "rock"
rectangle = {{ min = [-0.025, -0.05], max = [0.025, 0.05] }}
mesh_size = {mesh_size}
[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.3
damping = 0.1
friction = 0.3
tensile_strength = 1e6
cohesion = {COHESION}
friction_angle = {angle}
fracture_energy_i = 1
fracture_energy_ii = 5
[[boundary]]
name = "upper"
body = "block"
side = "top"
velocity = ["free", -0.025]
ramp = 0.2e-3
[[boundary]]
name = "lower"
body = "block"
side = "bottom"
velocity = ["free", 0.025]
ramp = 0.2e-3
"#,
        angle = FRICTION.atan().to_degrees()
    );
    let mut run = start(prepared(&model)?)?;
    let steps = (end / run.time_step()) as u64;
    let samples = 1000;
    let mut peak = 0.0_f64;
    for _ in 0..samples {
        let mut load = 0.0;
        for _ in 0..4 {
            advance(&mut run, (steps / samples / 4).max(1))?;
            for boundary in 0..2 {
                load += 0.125 * run.force(boundary).unwrap_or_default()[1].abs();
            }
        }
        peak = peak.max(load);
        if load < 0.5 * peak && run.counts().broken > 20 {
            break;
        }
    }
    let [tension, shear, both] = run.crack_lengths();
    if tension + shear + both < WIDTH {
        return Err("the block does not fail".to_owned());
    }
    let angle = FRICTION.atan();
    let bound = 2.0 * COHESION * angle.cos() / (1.0 - angle.sin());
    Ok(vec![
        Outcome::relative("strength, 2 c cos φ/(1 - sin φ)", bound, peak / WIDTH, 0.15, "Pa"),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-2, ""),
    ])
}
