//! A double cantilever beam whose arms are pulled apart: linear elastic fracture mechanics.

use fdem_simulation::{FractureOptions, Interface, Material, Model, Schedule, Strength, TimeOptions};

use super::models::{advance_to, force, granite, moved, nodes_where, rectangle, slit, start};
use super::{Outcome, Size};

/// Height of each of the two arms, m.
const ARM: f64 = 0.01;
/// Length of the beam and of its crack at the beginning, m.
const LENGTH: f64 = 0.07;
const CRACK: f64 = 0.025;
/// Pa.
const MODULUS: f64 = 30e9;
/// J/m².
const ENERGY: f64 = 20.0;
/// Length of the process zone, E G/f², m: small beside the arms.
const ZONE: f64 = 4e-3;

/// Lengths of the crack at which load and opening are compared, m.
const COMPARED: [f64; 3] = [0.030, 0.035, 0.040];

/// Stress intensity of a double cantilever over load and geometry: K = P (3.46 a + 2.38 h) / h^1.5 for a
/// thickness of 1.
fn geometry(crack: f64) -> f64 {
    3.46 * crack + 2.38 * ARM
}

/// Load at which a crack of this length grows, N for a thickness of 1 m.
fn load(crack: f64) -> f64 {
    (MODULUS * ENERGY).sqrt() * ARM.powf(1.5) / geometry(crack)
}

/// Opening of the arms under that load, m: the compliance is the integral of 2 G/P² over the crack.
fn opening(crack: f64) -> f64 {
    load(crack) * 2.0 * geometry(crack).powi(3) / (3.0 * 3.46 * ARM.powi(3) * MODULUS)
}

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(8, 16);
    let speed = size.choose(0.06, 0.03);
    let mut run = start(beam(cells, speed))?;
    let mut outcomes = Vec::new();
    for &crack in &COMPARED[..size.choose(2, 3)] {
        let expected = opening(crack);
        // Both arms move, and the ramp counts as half of its time.
        let middle = expected / (2.0 * speed) + 0.5 * RAMP;
        // The mean over some periods of the arms, which swing a little.
        let (mut sum, mut count) = (0.0, 0);
        for k in 0..200 {
            advance_to(&mut run, middle + (f64::from(k) / 199.0 - 0.5) * 2e-4)?;
            sum += 0.5 * (force(&run, 1)?[1] - force(&run, 0)?[1]);
            count += 1;
        }
        let found = sum / f64::from(count);
        let name = format!("load at an opening of {:.1} µm", 1e6 * expected);
        outcomes.push(Outcome::relative(name, load(crack), found, 0.05, "N"));
    }
    let balance = run.energies().error();
    outcomes.push(Outcome::absolute("error of the energy balance", 0.0, balance, 1e-3, ""));
    Ok(outcomes)
}

/// Time until the arms have reached their speed, s.
const RAMP: f64 = 2e-4;

fn beam(cells: usize, speed: f64) -> Model {
    let along = (LENGTH / ARM * cells as f64).round() as usize;
    let mesh = slit(&rectangle([0.0, -ARM], [LENGTH, ARM], [along, 2 * cells]), CRACK);
    let tensile = (MODULUS * ENERGY / ZONE).sqrt();
    let arm = Material { youngs_modulus: MODULUS, poissons_ratio: 0.3, damping: 0.2, ..granite() };
    let strength = Strength {
        tensile,
        cohesion: 10.0 * tensile,
        friction: 0.0,
        energy_i: ENERGY,
        energy_ii: 100.0 * ENERGY,
        weibull_modulus: None,
        seed: 0,
    };
    let end = |sign: f64| nodes_where(&mesh, |[x, y]| x < 1e-9 && sign * y > 0.1 * ARM);
    let boundaries = vec![
        moved("lower arm", end(-1.0), [None, Some(-speed)], Schedule::Ramp(RAMP)),
        moved("upper arm", end(1.0), [None, Some(speed)], Schedule::Ramp(RAMP)),
    ];
    Model {
        mesh,
        boundaries,
        materials: vec![arm.clone(), arm],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.0,
            penalty: None,
            strength: Some(strength),
        }],
        fracture: FractureOptions { joint_penalty: 20.0, ..FractureOptions::default() },
        time: TimeOptions { local_damping: 0.02, ..TimeOptions::default() },
        ..Model::default()
    }
}
