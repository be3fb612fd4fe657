//! Compression of a block until it fails: the strength of Mohr and Coulomb.

use fdem_simulation::{Boundary, Load, Model, Schedule, Target};

use super::models::{edges_where, line, mean_load, start, worse};
use super::rocks::prepared;
use super::{Outcome, Size};

/// Width and height of the block, m.
const WIDTH: f64 = 0.05;
const HEIGHT: f64 = 0.1;
/// Cohesion, Pa, and the tangent of the angle of internal friction.
const COHESION: f64 = 3e6;
const FRICTION: f64 = 0.3;
/// Pressure on the sides, Pa.
const CONFINED: f64 = 4e6;
/// Time in which the ends reach their speed and the pressure on the sides is put on, s.
const RAMP: f64 = 2e-4;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(3e-3, 2e-3);
    let seeds = size.choose(1..=2, 1..=5);
    let count = seeds.clone().count();
    let angle = FRICTION.atan();
    let (sin, cos) = angle.sin_cos();
    let (bound, slope) = (2.0 * COHESION * cos / (1.0 - sin), (1.0 + sin) / (1.0 - sin));
    let (mut outcomes, mut balance) = (Vec::new(), 0.0_f64);
    // Mean strength over the meshes, and the one farthest from the bound.
    let mut strengths = |energy: f64, pressure: f64| -> Result<[f64; 2], String> {
        let (mut sum, mut farthest) = (0.0, 0.0);
        for seed in seeds.clone() {
            let crushed = crush(mesh_size, seed, energy, pressure)?;
            sum += crushed.strength;
            farthest = worse(farthest, crushed.strength - bound);
            balance = balance.max(crushed.balance.abs());
        }
        Ok([sum / count as f64, bound + farthest])
    };
    let [confined, _] = strengths(5.0, CONFINED)?;
    for energy in [5.0, 15.0] {
        let [mean, farthest] = strengths(energy, 0.0)?;
        let case = |what: &str| format!("{what}, {count} meshes, G_II {energy} J/m²");
        outcomes.extend([
            Outcome::relative(case("mean strength"), bound, mean, 0.04, "Pa"),
            Outcome::relative(case("the farthest from it"), bound, farthest, 0.08, "Pa"),
        ]);
        if energy == 5.0 {
            let found = (confined - mean) / CONFINED;
            let name = format!("growth with the pressure on the sides up to {} MPa", CONFINED / 1e6);
            outcomes.push(Outcome::relative(name, slope, found, 0.04, ""));
        }
    }
    outcomes.push(Outcome::absolute("error of the energy balance", 0.0, balance, 1e-2, ""));
    Ok(outcomes)
}

/// Strengths under four pressures on the sides, against the line of Mohr and Coulomb.
pub(super) fn envelope(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(4e-3, 2e-3);
    let seeds = size.choose(1..=1, 1..=3);
    let (sin, cos) = FRICTION.atan().sin_cos();
    let (at_zero, slope) = (2.0 * COHESION * cos / (1.0 - sin), (1.0 + sin) / (1.0 - sin));
    let pressures = [0.0, 2e6, 4e6, 8e6];
    let mut strengths = Vec::new();
    for pressure in pressures {
        let mut sum = 0.0;
        for seed in seeds.clone() {
            sum += crush(mesh_size, seed, 5.0, pressure)?.strength;
        }
        strengths.push(sum / seeds.clone().count() as f64);
    }
    let [found_slope, found] = line(&pressures, &strengths);
    let farthest = pressures.iter().zip(&strengths).map(|(pressure, strength)| {
        let on_line = found + found_slope * pressure;
        ((strength - on_line) / on_line).abs()
    });
    Ok(vec![
        Outcome::relative("strength without pressure, on the line", at_zero, found, 0.05, "Pa"),
        Outcome::relative("growth with the pressure", slope, found_slope, 0.05, ""),
        Outcome::absolute(
            "distance of a strength from the line, as a share",
            0.0,
            farthest.fold(0.0, f64::max),
            0.03,
            "",
        ),
    ])
}

struct Crushed {
    /// Pa.
    strength: f64,
    /// Error of the energy balance, a share.
    balance: f64,
}

/// Crushes a block. `energy`: fracture energy of sliding, J/m²; `pressure`: on its sides, Pa.
fn crush(mesh_size: f64, seed: u32, energy: f64, pressure: f64) -> Result<Crushed, String> {
    let mut run = start(block(mesh_size, seed, energy, pressure)?)?;
    let (mut peak, mut at) = (0.0_f64, 0.0);
    loop {
        let load = mean_load(&mut run, 1)?;
        if load > peak {
            (peak, at) = (load, run.time());
        }
        if load < 0.97 * peak && run.time() > at + 0.3 * RAMP && run.counts().broken > 20 {
            break;
        }
        if run.time() > 10.0 * RAMP {
            return Err(format!("the block of mesh {seed} does not fail"));
        }
    }
    Ok(Crushed { strength: peak / WIDTH, balance: run.energies().error() })
}

fn block(mesh_size: f64, seed: u32, energy: f64, pressure: f64) -> Result<Model, String> {
    let mut model = prepared(&format!(
        r#"
[model]
plane = "stress"
gravity = "none"
end_time = 1
[[body]]
name = "block"
material = "rock"
rectangle = {{ min = [{left}, {bottom}], max = [{right}, {top}] }}
mesh_size = {mesh_size}
seed = {seed}
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
fracture_energy_ii = {energy}
[[boundary]]
name = "upper"
body = "block"
side = "top"
velocity = ["free", -0.025]
ramp = {RAMP}
[[boundary]]
name = "lower"
body = "block"
side = "bottom"
velocity = ["free", 0.025]
ramp = {RAMP}
"#,
        left = -0.5 * WIDTH,
        right = 0.5 * WIDTH,
        bottom = -0.5 * HEIGHT,
        top = 0.5 * HEIGHT,
        angle = FRICTION.atan().to_degrees(),
    ))?;
    // No triangle reaches from one side to the other.
    let sides = edges_where(&model.mesh, |[x, _]| x.abs() > 0.5 * WIDTH - 1e-9);
    model.boundaries.push(Boundary {
        name: "sides".to_owned(),
        target: Target::Facets(sides),
        load: Load::Pressure(pressure),
        schedule: Schedule::Ramp(RAMP),
    });
    Ok(model)
}
