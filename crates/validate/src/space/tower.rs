//! A tower of rigid cubes that stands on a rigid plate.

use fdem_simulation::{ContactOptions, Material, Model, Probe, Schedule};

use super::bodies::{Point, advance_to, cuboid, length, mean_motion, start};
use crate::models::{DENSITY, granite, moved, nodes_where, together, worse};
use crate::{Outcome, Size};

/// m/s².
const GRAVITY: f64 = 9.81;

/// Side of a cube, m.
const SIDE: f64 = 0.1;

/// Number of cubes.
const COUNT: u32 = 10;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let material = Material { youngs_modulus: 2e7, friction: 0.5, ..granite() };
    let contact = ContactOptions { damping: 0.3, ..ContactOptions::default() };
    // Each contact of flush faces is a spring: see `rigid.rs`.
    let stiffness = contact.penalty * material.youngs_modulus * SIDE * SIDE * 4.0 * (2.0 / SIDE);
    let plate = cuboid([-SIDE, -SIDE, -SIDE], [2.0 * SIDE, 2.0 * SIDE, 0.0], [3, 3, 1]);
    let held = (0..plate.nodes.len() as u32).collect();
    let cube = |k: u32| {
        let [bottom, top] = [k, k + 1].map(|k| SIDE * f64::from(k));
        cuboid([0.0, 0.0, bottom], [SIDE, SIDE, top], [1, 1, 1])
    };
    let mut parts = vec![plate];
    parts.extend((0..COUNT).map(cube));
    let mut run = start(Model {
        mesh: together(&parts),
        materials: vec![material],
        boundaries: vec![moved("plate", held, [Some(0.0); 3], Schedule::Constant)],
        gravity: [0.0, 0.0, -GRAVITY],
        gravity_schedule: Schedule::Ramp(0.2),
        rigid: (0..=COUNT).collect(),
        contact,
        ..Model::default()
    })?;
    let weight = DENSITY * SIDE.powi(3) * GRAVITY;
    let (tall, all) = (SIDE * f64::from(COUNT), weight * f64::from(COUNT));
    let sunk = (1..=COUNT).map(|above| weight * f64::from(above) / stiffness).sum::<f64>();
    let top = nodes_where(&run.model().mesh, |[_, _, z]: Point| z > tall - 0.5 * SIDE);
    let bottom = [Probe::ContactForce([vec![1], vec![0]])];
    let end = size.choose(1.0, 10.0);
    let (mut force, mut depth, mut lean, mut kinetic) = (all, sunk, 0.0, 0.0);
    for part in 1..=10 {
        // After the first half of a second the tower is at rest.
        advance_to(&mut run, 0.5 + 0.1 * f64::from(part) * (end - 0.5))?;
        let [[x, y, z], _] = mean_motion(&run, &top);
        let [_, _, pressed] = run.measure(&bottom)[0][..] else { return Err("a force in space".to_owned()) };
        force = all + worse(-pressed - all, force - all);
        depth = sunk + worse(-z - sunk, depth - sunk);
        lean = worse(length([x, y, 0.0]) / tall, lean);
        kinetic = worse(run.energies().kinetic / (all * tall), kinetic);
    }
    Ok(vec![
        Outcome::relative(format!("force on the plate, farthest until {end} s"), all, force, 1e-9, "N"),
        Outcome::relative("depth of the top, farthest", sunk, depth, 1e-3, "m"),
        Outcome::absolute("largest lean, over the height", 0.0, lean, 1e-12, ""),
        Outcome::absolute("largest kinetic energy, over weight times height", 0.0, kinetic, 1e-20, ""),
    ])
}
