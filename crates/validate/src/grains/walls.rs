//! Walls: a sphere in a tube that turns, and walls of triangles, discs and cones as planes.

use fdem_grains::{GrainMaterial, GrainModel, GrainRun, Spheres, Surfaces, Wall, WallRotation, WallShape};

use super::models::{GRAVITY, advance_to, hertz_depth, mass, reduced_modulus, start};
use crate::outcome::{Outcome, Size};

/// Radius of the tube, m, and of the sphere.
const TUBE: f64 = 0.1;
const RADIUS: f64 = 0.01;

/// Angular velocity of the tube, rad/s.
const SPIN: f64 = 3.0;

const SOFT: GrainMaterial = GrainMaterial { density: 2500.0, youngs_modulus: 1e7, poissons_ratio: 0.3 };

/// Simulated time, s: several swings of the sphere in the tube.
const TIME: f64 = 5.0;

pub(crate) fn tube(_: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for (friction, resistance) in [(0.5, 0.0), (0.5, 0.2), (0.15, 0.4)] {
        let slides = friction < resistance;
        // The weight pulls back with the moment of rolling friction, or with the force of friction. A sphere
        // that slides turns with the tube, because it does not roll on it.
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
        surfaces: vec![Surfaces { friction, rolling_friction, restitution: 0.2, ..Surfaces::smooth([0, 0]) }],
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

/// Side of the squares of the wall of triangles, m, and their number along a side.
const SIDE: f64 = 0.02;
const SQUARES: i32 = 20;

/// A plane of triangles, and a disc: spheres on them move as on a plane.
pub(crate) fn of_triangles(_: Size) -> Result<Vec<Outcome>, String> {
    let corner = |i: i32, j: i32| [SIDE * f64::from(i), SIDE * f64::from(j), 0.0];
    let triangles = (-SQUARES / 2..SQUARES / 2)
        .flat_map(|i| (-SQUARES / 2..SQUARES / 2).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let disc = WallShape::Disc { centre: [0.0; 3], normal: [0.0, 0.0, 1.0], radius: 0.3 };
    let mut outcomes = Vec::new();
    let plane = on_wall(Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0).shape)?;
    for (name, shape) in [("triangles", WallShape::Mesh { triangles }), ("a disc", disc)] {
        let run = on_wall(shape)?;
        for (of, unit, values) in [
            ("places", "m", GrainRun::position as fn(&GrainRun, usize) -> [f64; 3]),
            ("velocities", "m/s", GrainRun::velocity),
            ("spins", "rad/s", GrainRun::spin),
        ] {
            let differences = (0..STARTS.len()).flat_map(|k| {
                let [one, two] = [values(&run, k), values(&plane, k)];
                [0, 1, 2].map(|axis| (one[axis] - two[axis]).abs())
            });
            let most = differences.fold(0.0, f64::max);
            outcomes.push(Outcome::absolute(
                format!("{name}: largest difference of {of} from those on a plane"),
                0.0,
                most,
                1e-10,
                unit,
            ));
        }
    }
    let travelled = plane.position(0)[0] - STARTS[0].0[0];
    if travelled < 5.0 * SIDE {
        return Err(format!("the first sphere rolls over {travelled} m only"));
    }
    Ok(outcomes)
}

/// Places, without the height, and velocities of spheres on a wall: along a row of edges, along the diagonals
/// of the squares, in any direction, on a corner and on the middle of an edge, in free fall; and one that
/// slides slowly along an edge. All are farther than a diameter apart.
const STARTS: [([f64; 2], [f64; 3]); 6] = [
    ([-0.15, 0.0], [0.5, 0.0, 0.0]),
    ([-0.10, -0.16], [0.2, 0.2, 0.0]),
    ([-0.15, 0.05], [0.43, 0.17, 0.0]),
    ([0.10, -0.10], [0.0, 0.0, -0.5]),
    ([0.07, 0.10], [0.1, 0.0, -0.5]),
    ([0.14, -0.05], [0.0, 0.05, -0.01]),
];

fn on_wall(shape: WallShape) -> Result<GrainRun, String> {
    let mut run = start(GrainModel {
        spheres: Spheres {
            positions: STARTS.iter().map(|([x, y], _)| [*x, *y, RADIUS]).collect(),
            radii: vec![RADIUS; STARTS.len()],
            velocities: STARTS.iter().map(|(_, velocity)| *velocity).collect(),
            ..Spheres::default()
        },
        walls: vec![Wall { shape, ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0) }],
        materials: vec![SOFT],
        surfaces: vec![Surfaces {
            friction: 0.3,
            rolling_friction: 0.02,
            rolling_damping: 0.3,
            restitution: 0.6,
            ..Surfaces::smooth([0, 0])
        }],
        gravity: [0.0, 0.0, -GRAVITY],
        step: Some(5e-5),
        ..GrainModel::default()
    })?;
    advance_to(&mut run, 0.4)?;
    Ok(run)
}

/// A sphere rolls down the inside of a cone along the line of steepest descent, as on a slope.
pub(crate) fn cone(_: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for degrees in [20.0_f64, 35.0] {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let depth = hertz_depth(mass(RADIUS, SOFT) * GRAVITY * cos, reduced_modulus([SOFT, SOFT]), RADIUS);
        let arm = RADIUS - depth;
        // A cone of height 1 m, from the vertex at the origin; the sphere touches it at 0.8 m from the
        // vertex.
        let radii = [0.0, cos / sin];
        let place = [0.8 * cos - arm * sin, 0.0, 0.8 * sin + arm * cos];
        let mut run = start(GrainModel {
            spheres: Spheres { positions: vec![place], radii: vec![RADIUS], ..Spheres::default() },
            walls: vec![Wall {
                shape: WallShape::Cone { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radii },
                ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)
            }],
            materials: vec![SOFT],
            surfaces: vec![Surfaces { friction: 0.5, restitution: 0.3, ..Surfaces::smooth([0, 0]) }],
            gravity: [0.0, 0.0, -GRAVITY],
            step: Some(5e-5),
            ..GrainModel::default()
        })?;
        advance_to(&mut run, 0.05)?;
        let speed = |run: &GrainRun| -(run.velocity(0)[0] * cos + run.velocity(0)[2] * sin);
        let (before, begin) = (speed(&run), run.time());
        advance_to(&mut run, 0.35)?;
        let found = (speed(&run) - before) / (run.time() - begin);
        let expected = GRAVITY * sin / (1.0 + 0.4 * (RADIUS / arm).powi(2));
        let of = format!("cone, slope of {degrees} degrees");
        outcomes.push(Outcome::relative(format!("{of}: acceleration"), expected, found, 1e-3, "m/s²"));
        outcomes.push(Outcome::absolute(format!("{of}: way aside"), 0.0, run.position(0)[1], 1e-9, "m"));
    }
    Ok(outcomes)
}
