//! Walls: a sphere in a tube that turns.

use fdem_grains::{GrainMaterial, GrainModel, Spheres, Surfaces, Wall, WallRotation, WallShape};

use crate::outcome::{Outcome, Size};
use super::models::{GRAVITY, advance_to, hertz_depth, mass, reduced_modulus, start};

/// Radius of the tube, m, and of the sphere.
const TUBE: f64 = 0.1;
const RADIUS: f64 = 0.01;

/// Angular velocity of the tube, rad/s.
const SPIN: f64 = 3.0;

const SOFT: GrainMaterial = GrainMaterial { density: 2500.0, youngs_modulus: 1e7, poissons_ratio: 0.3 };

/// Simulated time, s: several swings of the sphere in the tube.
const TIME: f64 = 5.0;

pub(crate) fn run(_: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for (friction, resistance) in [(0.5, 0.0), (0.5, 0.2), (0.15, 0.4)] {
        let slides = friction < resistance;
        // The weight pulls back with the moment of rolling friction, or with the force of friction. A sphere that
        // slides turns with the tube, because it does not roll on it.
        let overlap = overlap();
        let tangent = if slides { friction } else { resistance * RADIUS / (RADIUS - overlap) };
        let angle = libm::atan(tangent);
        let spin = if slides { SPIN } else { SPIN * TUBE / (RADIUS - overlap) };
        let [deviation, turning] = in_a_tube(friction, resistance, angle, spin)?;
        let of = format!("friction {friction}, rolling friction {resistance}");
        outcomes.push(Outcome::absolute(
            format!("angle, {of}"),
            angle.to_degrees(),
            (angle + deviation).to_degrees(),
            0.05,
            "degrees",
        ));
        outcomes.push(Outcome::relative(format!("angular velocity, {of}"), spin, turning, 1e-3, "rad/s"));
    }
    Ok(outcomes)
}

/// Overlap of the sphere at the lowest place, m.
fn overlap() -> f64 {
    hertz_depth(mass(RADIUS, SOFT) * GRAVITY, reduced_modulus([SOFT, SOFT]), RADIUS)
}

/// A sphere in a tube that turns about a horizontal axis, from the angle and with the spin, rad/s, of its
/// equilibrium. Nothing damps its swings about that, so that a wrong equilibrium shows. Returns the largest
/// deviation from the angle, and the mean angular velocity, rad/s.
fn in_a_tube(friction: f64, rolling_friction: f64, angle: f64, spin: f64) -> Result<[f64; 2], String> {
    let (sin, cos) = libm::sincos(angle);
    let from_axis = TUBE - RADIUS + overlap();
    let mut run = start(GrainModel {
        spheres: Spheres {
            positions: vec![[-from_axis * sin, 0.0, -from_axis * cos]],
            radii: vec![RADIUS],
            spins: vec![[0.0, spin, 0.0]],
            ..Spheres::default()
        },
        walls: vec![Wall {
            shape: WallShape::Tube { axis: [[0.0; 3], [0.0, 1.0, 0.0]], radius: TUBE },
            rotation: Some(WallRotation { through: [0.0; 3], spin: [0.0, SPIN, 0.0] }),
            ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)
        }],
        materials: vec![SOFT],
        surfaces: vec![Surfaces {
            friction,
            rolling_friction,
            restitution: 0.2,
            ..Surfaces::smooth([0, 0])
        }],
        gravity: [0.0, 0.0, -GRAVITY],
        step: Some(5e-5),
        ..GrainModel::default()
    })?;
    let samples = 200;
    let (mut deviation, mut turning) = (0.0_f64, 0.0);
    for sample in 1..=samples {
        advance_to(&mut run, TIME * f64::from(sample) / f64::from(samples))?;
        let [x, _, z] = run.position(0);
        let now = libm::atan2(-x, -z) - angle;
        deviation = if now.abs() > deviation.abs() { now } else { deviation };
        turning += run.spin(0)[1] / f64::from(samples);
    }
    Ok([deviation, turning])
}
