//! Compression of a block until it fails: the strength of Mohr and Coulomb.

use fdem_simulation::{Boundary, Load, Model, Schedule, Target};

use super::models::{edges_where, line, mean_load, meshes, start, worse};
use super::rocks::prepared;
use super::{Outcome, Size};

/// Width and height of the block, m.
const WIDTH: f64 = 0.05;
const HEIGHT: f64 = 0.1;
/// Pressure on the sides, Pa.
const CONFINED: f64 = 4e6;
/// Time in which the ends reach their speed and the pressure on the sides is put on, s.
const RAMP: f64 = 2e-4;

/// A rock that is crushed.
#[derive(Clone, Copy)]
pub(super) struct Rock {
    /// kg/m³.
    density: f64,
    /// Pa.
    pub(super) youngs_modulus: f64,
    pub(super) poissons_ratio: f64,
    /// Pa.
    pub(super) tensile_strength: f64,
    /// Pa.
    pub(super) cohesion: f64,
    /// Tangent of the angle of internal friction.
    pub(super) friction: f64,
    /// Fracture energies of opening and of sliding, J/m².
    pub(super) energies: [f64; 2],
    /// Velocity of each of the ends, m/s.
    velocity: f64,
}

/// A soft rock, which fails in a short run.
pub(super) const SOFT: Rock = Rock {
    density: 2700.0,
    youngs_modulus: 30e9,
    poissons_ratio: 0.3,
    tensile_strength: 1e6,
    cohesion: 3e6,
    friction: 0.3,
    energies: [1.0, 5.0],
    velocity: 0.025,
};

/// Berea sandstone. Cohesion and angle of friction (27.8°) were fitted to triaxial tests; elasticity also
/// from Goodman, Introduction to Rock Mechanics, 2nd ed. (1989), tables 3.3 and 6.1. Fracture energies that
/// are as brittle on this specimen as those of [`SOFT`].
const BEREA: Rock = Rock {
    density: 2200.0,
    youngs_modulus: 19.3e9,
    poissons_ratio: 0.38,
    tensile_strength: 9e6,
    cohesion: 27.2e6,
    friction: 0.527,
    energies: [130.0, 640.0],
    velocity: 0.6,
};

impl Rock {
    /// Strength without pressure on the sides, Pa, and its growth with the pressure: Mohr and Coulomb.
    fn strength(&self) -> [f64; 2] {
        let (sin, cos) = self.friction.atan().sin_cos();
        [2.0 * self.cohesion * cos / (1.0 - sin), (1.0 + sin) / (1.0 - sin)]
    }
}

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(3e-3, 2e-3);
    let seeds = size.choose(1..=1, 1..=5);
    let count = seeds.clone().count();
    let [bound, slope] = SOFT.strength();
    let (mut outcomes, mut balance) = (Vec::new(), 0.0_f64);
    // Mean strength over the meshes, and the one farthest from the bound.
    let mut strengths = |energy: f64, pressure: f64| -> Result<[f64; 2], String> {
        let (mut sum, mut farthest) = (0.0, 0.0);
        for seed in seeds.clone() {
            let rock = Rock { energies: [1.0, energy], ..SOFT };
            let crushed = crush(&rock, "", mesh_size, seed, pressure)?;
            sum += crushed.strength;
            farthest = worse(farthest, crushed.strength - bound);
            balance = balance.max(crushed.balance.abs());
        }
        Ok([sum / count as f64, bound + farthest])
    };
    let [confined, _] = strengths(5.0, CONFINED)?;
    for energy in [5.0, 15.0] {
        let [mean, farthest] = strengths(energy, 0.0)?;
        let case = |what: &str| format!("{what}, {}, G_II {energy} J/m²", meshes(count));
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

/// Strengths of Berea sandstone under four pressures on the sides, against the line that was fitted to its
/// triaxial tests: the figures of the material are those of the tests.
pub(super) fn envelope(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(4e-3, 2e-3);
    let seeds = size.choose(1..=1, 1..=3);
    let [at_zero, slope] = BEREA.strength();
    let pressures = [0.0, 10e6, 20e6, 40e6];
    let mut strengths = Vec::new();
    for pressure in pressures {
        let mut sum = 0.0;
        for seed in seeds.clone() {
            sum += crush(&BEREA, "", mesh_size, seed, pressure)?.strength;
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

pub(super) struct Crushed {
    /// Pa.
    pub(super) strength: f64,
    /// Error of the energy balance, a share.
    pub(super) balance: f64,
}

/// Crushes a block. `more`: further keys of its material. `pressure`: on its sides, Pa.
pub(super) fn crush(
    rock: &Rock,
    more: &str,
    mesh_size: f64,
    seed: u32,
    pressure: f64,
) -> Result<Crushed, String> {
    let mut run = start(block(rock, more, mesh_size, seed, pressure)?)?;
    let (mut peak, mut at) = (0.0_f64, 0.0);
    loop {
        let load = mean_load(&mut run, 1)?;
        if load > peak {
            (peak, at) = (load, run.time());
        }
        if load < 0.97 * peak && run.time() > at + 0.3 * RAMP && run.counts().broken > 20 {
            break;
        }
        // Twice the time in which it gets to its strength without sliding.
        let [at_zero, slope] = rock.strength();
        let strain = (at_zero + slope * pressure) / rock.youngs_modulus;
        if run.time() > 5.0 * RAMP + strain * HEIGHT / rock.velocity {
            return Err(format!("the block of mesh {seed} does not fail"));
        }
    }
    Ok(Crushed { strength: peak / WIDTH, balance: run.energies().error() })
}

fn block(rock: &Rock, more: &str, mesh_size: f64, seed: u32, pressure: f64) -> Result<Model, String> {
    let Rock {
        density,
        youngs_modulus,
        poissons_ratio,
        tensile_strength,
        cohesion,
        friction,
        energies: [opening, sliding],
        velocity,
    } = rock;
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
density = {density}
youngs_modulus = {youngs_modulus}
poissons_ratio = {poissons_ratio}
damping = 0.1
friction = {friction}
tensile_strength = {tensile_strength}
cohesion = {cohesion}
friction_angle = {angle}
fracture_energy_i = {opening}
fracture_energy_ii = {sliding}
{more}
[[boundary]]
name = "upper"
body = "block"
side = "top"
velocity = ["free", -{velocity}]
ramp = {RAMP}
[[boundary]]
name = "lower"
body = "block"
side = "bottom"
velocity = ["free", {velocity}]
ramp = {RAMP}
"#,
        left = -0.5 * WIDTH,
        right = 0.5 * WIDTH,
        bottom = -0.5 * HEIGHT,
        top = 0.5 * HEIGHT,
        angle = friction.atan().to_degrees(),
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
