//! A chain of spheres between two held ones, pressed: its waves, and its forces at rest.

use fdem_grains::{GrainModel, Spheres, Surfaces, Wall};

use super::models::{GRAVITY, advance_to, hertz_depth, mass, material, reduced_modulus, start};
use crate::outcome::{Outcome, Size};

/// m.
const RADIUS: f64 = 0.01;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = waves(size)?;
    outcomes.extend(column()?);
    Ok(outcomes)
}

/// Standing waves of a chain that is pressed: its frequencies are 2 √(k/m) sin(n π/(2 (N + 1))), with the
/// stiffness `k` of a contact by Hertz's law, for each mode `n` of `N` spheres.
fn waves(size: Size) -> Result<Vec<Outcome>, String> {
    let of = material(1e9, 0.25, 2500.0);
    let overlap = 1e-3 * RADIUS;
    let stiffness = 2.0 * reduced_modulus([of, of]) * (0.5 * RADIUS * overlap).sqrt();
    let pi = std::f64::consts::PI;
    let rate = (stiffness / mass(RADIUS, of)).sqrt();
    let mut outcomes = Vec::new();
    let count = size.choose(20, 100);
    for mode in [1, 2, 5] {
        let angle = f64::from(mode) * pi / f64::from(count + 1);
        // Far less than the overlap, so that the contacts are linear.
        let speed = 1e-5 * rate * overlap;
        let pitch = 2.0 * RADIUS - overlap;
        let frequency = 2.0 * rate * (0.5 * angle).sin();
        let steps_of_period = 2.0 * pi / frequency * rate * 50.0;
        let mut run = start(GrainModel {
            spheres: Spheres {
                positions: (0..count + 2).map(|k| [pitch * f64::from(k), 0.0, 0.0]).collect(),
                radii: vec![RADIUS; count as usize + 2],
                velocities: (0..count + 2)
                    .map(|k| [speed * (angle * f64::from(k)).sin(), 0.0, 0.0])
                    .collect(),
                held: (0..count + 2).map(|k| k == 0 || k == count + 1).collect(),
                ..Spheres::default()
            },
            materials: vec![of],
            surfaces: vec![Surfaces::smooth([0, 0])],
            step: Some(2.0 * pi / frequency / steps_of_period.round()),
            ..GrainModel::default()
        })?;
        // The velocity of one sphere near an antinode over two periods: where it changes its sign.
        let sphere = (f64::from(count + 1) / (2.0 * f64::from(mode))).round() as usize;
        let mut crossings = Vec::new();
        let mut before = run.velocity(sphere)[0];
        while crossings.len() < 5 {
            run.advance(1).map_err(|error| error.to_string())?;
            let now = run.velocity(sphere)[0];
            if now * before < 0.0 {
                crossings.push(run.time() - run.time_step() * now / (now - before));
            }
            before = now;
            if run.time() > 20.0 / frequency * pi {
                return Err("the chain does not swing".to_owned());
            }
        }
        let found = (crossings[4] - crossings[0]) / 2.0;
        let quantity = format!("period of mode {mode} of a chain of {count}");
        outcomes.push(Outcome::relative(quantity, 2.0 * pi / frequency, found, 1e-3, "s"));
        if mode == 1 {
            // The wave runs along the chain and back in a period.
            let expected = pitch * rate;
            let found = 2.0 * pitch * f64::from(count + 1) / found;
            outcomes.push(Outcome::relative("speed of long waves", expected, found, 2e-3, "m/s"));
        }
    }
    Ok(outcomes)
}

/// A column of ten spheres that stands on a plane: its forces are the weights above.
fn column() -> Result<Vec<Outcome>, String> {
    const COUNT: usize = 10;
    let of = material(1e7, 0.3, 2500.0);
    let weight = mass(RADIUS, of) * GRAVITY;
    let mut model = GrainModel {
        spheres: Spheres {
            positions: (0..COUNT).map(|k| [0.0, 0.0, RADIUS * (2 * k + 1) as f64]).collect(),
            radii: vec![RADIUS; COUNT],
            ..Spheres::default()
        },
        walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)],
        materials: vec![of],
        surfaces: vec![Surfaces { friction: 0.5, restitution: 0.1, ..Surfaces::smooth([0, 0]) }],
        gravity: [0.0, 0.0, -GRAVITY],
        ..GrainModel::default()
    };
    model.step = Some(0.5 * model.safe_step());
    let mut run = start(model)?;
    advance_to(&mut run, 2.0)?;
    let modulus = reduced_modulus([of, of]);
    let mut worst = (-run.wall_force(0)[2] / (COUNT as f64 * weight) - 1.0).abs();
    let contacts = run.contacts();
    let mut sunk = hertz_depth(COUNT as f64 * weight, modulus, RADIUS);
    for above in 1..COUNT {
        let load = (COUNT - above) as f64 * weight;
        let of_pair = |contact: &&fdem_grains::GrainContact| {
            contact.sphere as usize == above - 1
                && contact.other == fdem_grains::GrainPartner::Sphere(above as u32)
        };
        let force = contacts.iter().find(of_pair).map_or(0.0, |contact| contact.normal);
        worst = worst.max((force / load - 1.0).abs());
        sunk += hertz_depth(load, modulus, 0.5 * RADIUS);
    }
    let top = RADIUS * (2 * COUNT - 1) as f64 - run.position(COUNT - 1)[2];
    Ok(vec![
        Outcome::absolute("column of ten: largest error of a force, as a share", 0.0, worst, 1e-6, ""),
        Outcome::relative("column of ten: descent of the top", sunk, top, 1e-6, "m"),
    ])
}
