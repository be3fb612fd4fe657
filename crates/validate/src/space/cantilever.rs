//! A double cantilever of tetrahedra whose arms are pulled apart.
//!
//! Each arm of the height `h` and the width `b` is a beam that is clamped at the front of the crack: under
//! the load `P` the arms part by `2 P a³/(3 E I)`, with `I = b h³/12`, so that the compliance is
//! `C = 2 a³/(3 E I)`. The energy that a crack releases as it grows is `G b = P²/2 dC/da = P² a²/(E I)`: it
//! grows at `P = √(G b E I)/a`.
//!
//! Arms as short as these also shear, and turn about the front of the crack. Boundary collocation (Gross and
//! Srawley) gives `K = P (3.46 a + 2.38 h)/(b h^1.5)`; with `G = K²/E` that is the law of beams with
//! `a + 0.688 h` for `a`, both in the load and in the compliance, which is the integral of `2 G b/P²`. Here
//! `a` is 2 to 4 times `h`.
//!
//! The cells of the mesh are small beside the arm's height, because elements of constant strain are too stiff
//! in bending: the case "locking" says how much.

use fdem_simulation::{
    ContactOptions, FractureOptions, Interface, Material, Model, Schedule, Strength, TimeOptions,
};

use super::bodies::{Body, Point, Run, advance_to, centroid, cuboid, force, start};
use crate::models::{granite, moved, nodes_where};
use crate::{Outcome, Size};

/// Height of each arm, m.
const ARM: f64 = 0.01;
/// Pa.
const MODULUS: f64 = 30e9;
/// J/m².
const ENERGY: f64 = 20.0;
/// Length of the process zone, E G/f², m: small beside the arms.
const ZONE: f64 = 4e-3;
/// Time until the arms have reached their speed, s.
const RAMP: f64 = 2e-4;

/// Length of a crack with the turn about its front and the shear of the arms, m.
fn effective(crack: f64) -> f64 {
    crack + 2.38 / 3.46 * ARM
}

/// E I of an arm of the width 1 m, N m.
fn stiffness() -> f64 {
    MODULUS * ARM.powi(3) / 12.0
}

/// Load at which a crack of this length grows, N for a width of 1 m.
fn load(crack: f64) -> f64 {
    (ENERGY * stiffness()).sqrt() / effective(crack)
}

/// How far the arms part under a load of 1 N for a width of 1 m, m.
fn compliance(crack: f64) -> f64 {
    2.0 * effective(crack).powi(3) / (3.0 * stiffness())
}

/// Cells through the width: the front of the crack has vertices inside, where several faces must part
/// together.
const WIDE: usize = 2;

/// Size of the model.
struct Beam {
    /// Cells through the height of an arm.
    cells: usize,
    /// Lengths of the beam and of its crack at the beginning, m.
    length: f64,
    crack: f64,
    /// Speed of each arm, m/s.
    speed: f64,
}

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let beam = size.choose(
        Beam { cells: 8, length: 0.04, crack: 0.02, speed: 0.05 },
        Beam { cells: 12, length: 0.06, crack: 0.025, speed: 0.06 },
    );
    let width = WIDE as f64 * ARM / beam.cells as f64;
    let mut run = start(model(&beam, width))?;
    let mut outcomes = Vec::new();
    // Half of the opening at which the crack begins to grow.
    let opening = 0.5 * load(beam.crack) * compliance(beam.crack);
    let pulled = mean_load(&mut run, &beam, opening)? / width;
    outcomes.push(Outcome::relative(
        format!("compliance at a crack of {:.0} mm, for a width of 1 m", 1e3 * beam.crack),
        compliance(beam.crack),
        opening / pulled,
        0.05,
        "m/N",
    ));
    for &crack in size.choose(&[0.024] as &[f64], &[0.030, 0.035, 0.040]) {
        let opening = load(crack) * compliance(crack);
        outcomes.push(Outcome::relative(
            format!("load at an opening of {:.1} µm, at a crack of {:.0} mm", 1e6 * opening, 1e3 * crack),
            load(crack) * width,
            mean_load(&mut run, &beam, opening)?,
            0.05,
            "N",
        ));
    }
    outcomes.push(Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""));
    Ok(outcomes)
}

/// Mean load over the time about the instant at which the arms are so far apart, N: the arms swing a little.
fn mean_load(run: &mut Run, beam: &Beam, opening: f64) -> Result<f64, String> {
    // Both arms move, and the ramp counts as half of its time.
    let middle = opening / (2.0 * beam.speed) + 0.5 * RAMP;
    let (mut sum, samples) = (0.0, 200);
    for k in 0..samples {
        advance_to(run, middle + (f64::from(k) / f64::from(samples - 1) - 0.5) * 2e-4)?;
        sum += 0.5 * (force(run, 1)?[2] - force(run, 0)?[2]);
    }
    Ok(sum / f64::from(samples))
}

fn model(beam: &Beam, width: f64) -> Model<3, 4> {
    let along = (beam.length / ARM * beam.cells as f64).round() as usize;
    let max = [beam.length, width, ARM];
    let mesh = slit(cuboid([0.0, 0.0, -ARM], max, [along, WIDE, 2 * beam.cells]), beam.crack);
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
    let end = |sign: f64| nodes_where(&mesh, |[x, _, z]: Point| x < 1e-9 && sign * z > 0.1 * ARM);
    let pull = |speed| [None, None, Some(speed)];
    let boundaries = vec![
        moved("lower arm", end(-1.0), pull(-beam.speed), Schedule::Ramp(RAMP)),
        moved("upper arm", end(1.0), pull(beam.speed), Schedule::Ramp(RAMP)),
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
        // The arms only part: stiff contacts and joints would make the step shorter for nothing.
        contact: ContactOptions { penalty: 0.1, ..ContactOptions::default() },
        fracture: FractureOptions { joint_penalty: 20.0, ..FractureOptions::default() },
        time: TimeOptions { local_damping: 0.02, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// Separates the arms from the end to the front of the crack. The upper one becomes material 1.
fn slit(mut mesh: Body, crack: f64) -> Body {
    let first = mesh.nodes.len() as u32;
    let parted = nodes_where(&mesh, |[x, _, z]: Point| z.abs() < 1e-9 && x < crack - 1e-9);
    let copies: std::collections::BTreeMap<u32, u32> = parted.iter().copied().zip(first..).collect();
    mesh.nodes.extend(parted.iter().map(|&node| mesh.nodes[node as usize]).collect::<Vec<_>>());
    for element in 0..mesh.elements.len() {
        if centroid(&mesh, element)[2] > 0.0 {
            mesh.materials[element] = 1;
            let corners = &mut mesh.elements[element];
            *corners = corners.map(|corner| copies.get(&corner).copied().unwrap_or(corner));
        }
    }
    mesh
}
