//! Ground under its own weight: rest, and a slope that slides on a plane.

use fdem_simulation::{
    Boundary, JointSet, Load, Material, Model, Plane, Schedule, Simulation, Strength, Target,
};

use super::models::{
    DENSITY, advance, advance_to, edges_where, force, granite, line, mean_velocity, moved, nodes_where,
    rectangle, start,
};
use super::rocks::{prepared, prepared_in_space};
use super::{Outcome, Size};

/// Height and width of the ground, m; density, kg/m³; gravity, m/s².
const HEIGHT: f64 = 10.0;
const WIDTH: f64 = 20.0;
const SOIL: f64 = 2000.0;
const GRAVITY: f64 = 9.81;

/// Horizontal over vertical stress, and the tectonic stress, Pa.
const K0: f64 = 0.5;
const TECTONIC: f64 = -1e5;

/// Young's modulus, Pa.
const MODULUS: f64 = 100e6;

/// Ground at rest.
pub(super) fn rest(size: Size) -> Result<Vec<Outcome>, String> {
    let mesh_size = size.choose(2.0, 1.0);
    let text = |dimensions: &str, shape: &str, gravity: &str, held: [&str; 2]| {
        let [sides, base] = held;
        format!(
            r#"
[model]
{dimensions}
gravity = {gravity}
end_time = 1
[[body]]
name = "ground"
material = "soil"
{shape}
mesh_size = {mesh_size}
[[material]]
name = "soil"
density = {SOIL}
youngs_modulus = {MODULUS}
poissons_ratio = 0.3
[initial]
ground = {{ surface = 0, k0 = {K0}, tectonic = {TECTONIC} }}
[[boundary]]
name = "base"
side = "bottom"
fixed = "{base}"
[[boundary]]
name = "left"
side = "left"
fixed = "x"
[[boundary]]
name = "right"
side = "right"
fixed = "x"
{sides}
"#
        )
    };
    let flat = prepared(&text(
        "plane = \"strain\"",
        &format!("rectangle = {{ min = [0, {}], max = [{WIDTH}, 0] }}", -HEIGHT),
        &format!("[0, {}]", -GRAVITY),
        ["", "y"],
    ))?;
    let faces = "[[boundary]]\nname = \"front\"\nside = \"front\"\nfixed = \"y\"\n\
                 [[boundary]]\nname = \"back\"\nside = \"back\"\nfixed = \"y\"";
    let deep = prepared_in_space(&text(
        "dimensions = 3",
        &format!("box = {{ min = [0, 0, {}], max = [{HEIGHT}, {HEIGHT}, 0] }}", -HEIGHT),
        &format!("[0, 0, {}]", -GRAVITY),
        [faces, "z"],
    ))?;
    // The wave speed times the strain at the base.
    let strain = SOIL * GRAVITY * HEIGHT / MODULUS;
    let speed = (MODULUS / SOIL).sqrt();
    let passages = 20.0 * HEIGHT / speed;
    // Weight at the base: of a layer 1 m thick, and of a block.
    let weight = SOIL * GRAVITY * HEIGHT;
    let side = 0.5 * K0 * weight * HEIGHT - TECTONIC * HEIGHT;
    let mut run = start(flat)?;
    advance_to(&mut run, passages)?;
    let fastest = run.snapshot().velocities.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    let [carried, _] = [force(&run, 0)?[1], 0.0];
    let pushed = force(&run, 1)?[0];
    let mut outcomes = vec![
        Outcome::absolute(
            "largest velocity, over wave speed times strain",
            0.0,
            fastest / speed / strain,
            1e-6,
            "",
        ),
        Outcome::relative("force of the base", weight * WIDTH, carried, 1e-6, "N"),
        Outcome::relative("force of a side", side, pushed, 1e-6, "N"),
    ];
    let mut run = Simulation::new(deep, 1).map_err(|error| error.to_string())?;
    let steps = (passages / run.time_step()).ceil() as u64;
    run.advance(steps).map_err(|stop| stop.to_string())?;
    let length = |velocity: &[f64; 3]| velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
    let fastest = run.snapshot().velocities.iter().map(length).fold(0.0, f64::max);
    let carried = run.force(0).map_or(f64::NAN, |force| force[2]);
    outcomes.extend([
        Outcome::absolute(
            "largest velocity in space, over wave speed times strain",
            0.0,
            fastest / speed / strain,
            1e-6,
            "",
        ),
        Outcome::relative("force of the base in space", weight * HEIGHT * HEIGHT, carried, 1e-6, "N"),
    ]);
    Ok(outcomes)
}

/// Length and height of the block on the plane, m.
const LENGTH: f64 = 4.0;
const THICK: f64 = 0.4;

/// Cohesion, Pa, and tangent of the friction angle of the plane.
const COHESION: f64 = 20e3;
const FRICTION: f64 = 0.5;

/// Dip of the plane, degrees.
const DIP: f64 = 40.0;

/// Gravity over that of equilibrium at which a block slides on a plane with cohesion and friction.
///
/// A block of the weight W on a plane of the area A that dips by ψ has the factor of safety (c A + W cos ψ
/// tan φ)/(W sin ψ). Its weight grows until that is 1.
pub(super) fn plane_failure(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let dips: &[f64] = size.choose(&[DIP], &[35.0, DIP, 50.0]);
    for &dip in dips {
        let (sin, cos) = dip.to_radians().sin_cos();
        let expected = COHESION / (DENSITY * THICK * (sin - cos * FRICTION));
        let found = gravity_of_failure(dip, expected, size)?;
        // The factor of safety falls as 1/g once the part of cohesion is taken out.
        let of_safety = (COHESION / (DENSITY * THICK * found) + cos * FRICTION) / sin;
        outcomes.push(Outcome::relative(
            format!("factor of safety at failure, dip {dip}°"),
            1.0,
            of_safety,
            0.03,
            "",
        ));
    }
    Ok(outcomes)
}

/// The gravity at which the block begins to slide, m/s².
fn gravity_of_failure(dip: f64, expected: f64, size: Size) -> Result<f64, String> {
    let (sin, cos) = dip.to_radians().sin_cos();
    let (columns, rows) = size.choose((20, 2), (40, 4));
    let mesh = rectangle([0.0, -THICK], [LENGTH, THICK], [columns, 2 * rows]);
    let below = nodes_where(&mesh, |[_, y]| y < -1e-9);
    let above = nodes_where(&mesh, |[_, y]| y > 0.5 * THICK);
    let plane = edges_where(&mesh, |[_, y]| y.abs() < 1e-9);
    // Gravity grows in a straight line up to 1.3 times that of failure.
    let duration = 2.0;
    let most = 1.3 * expected;
    let mut model = Model {
        materials: vec![Material { youngs_modulus: 1e9, damping: 0.3, friction: FRICTION, ..granite() }],
        boundaries: vec![moved("below", below, [Some(0.0); 2], Schedule::Constant)],
        joint_sets: vec![JointSet {
            name: "plane".to_owned(),
            strength: Strength {
                tensile: 20e3,
                cohesion: COHESION,
                friction: FRICTION,
                energy_i: 100.0,
                energy_ii: 400.0,
                weibull_modulus: None,
                seed: 0,
            },
            residual_friction: FRICTION,
            dilation: 0.0,
            dilation_slip: None,
            normal_stiffness: Some(5e9),
            shear_stiffness: Some(2e9),
            open: false,
        }],
        gravity: [most * sin, -most * cos],
        gravity_schedule: Schedule::Table(vec![[0.0, 0.0], [duration, 1.0]]),
        plane: Plane::Strain,
        mesh,
        ..Model::default()
    };
    model.add_joints(0, &plane);
    let mut run = start(model)?;
    // Elastic motion is far slower than this.
    while mean_velocity(&run, &above)[0] < 0.05 {
        let next = run.time() + 1e-3;
        if next > duration {
            return Err(format!("the block on a plane of {dip}° does not slide"));
        }
        advance_to(&mut run, next)?;
    }
    Ok(most * run.time() / duration)
}

/// Direct shear of a joint set under three normal stresses: cohesion and friction from the line through the
/// peaks.
pub(super) fn direct_shear(size: Size) -> Result<Vec<Outcome>, String> {
    let (cohesion, friction, residual) = (1e6, 0.6, 0.4);
    let stresses = [1e6, 2e6, 4e6];
    let (mut peaks, mut residuals) = (Vec::new(), Vec::new());
    for stress in stresses {
        let [peak, last] = sheared(stress, cohesion, [friction, residual], size.choose(10, 20))?;
        peaks.push(peak);
        residuals.push(last);
    }
    let [slope, at_zero] = line(&stresses, &peaks);
    let [residual_slope, _] = line(&stresses, &residuals);
    Ok(vec![
        Outcome::relative("cohesion", cohesion, at_zero, 0.02, "Pa"),
        Outcome::relative("tangent of the friction angle", friction, slope, 0.02, ""),
        Outcome::relative("tangent of the residual friction angle", residual, residual_slope, 0.05, ""),
    ])
}

/// The largest traction along a joint under a normal stress, and the last one, Pa.
fn sheared(
    stress: f64,
    cohesion: f64,
    [friction, residual]: [f64; 2],
    count: usize,
) -> Result<[f64; 2], String> {
    // Flat halves: high ones would tilt, and carry another normal stress at their ends.
    let (length, half) = (0.2, 0.02);
    let mesh = rectangle([0.0, -half], [length, half], [count, 4]);
    let below = nodes_where(&mesh, |[_, y]| y < -1e-9);
    let above = nodes_where(&mesh, |[_, y]| y > 1e-9);
    let joint = edges_where(&mesh, |[_, y]| y.abs() < 1e-9);
    let top = edges_where(&mesh, |[_, y]| y > half - 1e-9);
    let mut model = Model {
        materials: vec![Material { damping: 0.3, friction: 0.9, ..granite() }],
        boundaries: vec![
            moved("below", below, [Some(0.0); 2], Schedule::Constant),
            // The upper half moves as a whole along x, and is free along y.
            moved("above", above, [Some(0.05), None], Schedule::Table(vec![[1e-3, 0.0], [2e-3, 1.0]])),
            Boundary {
                name: "pressure".to_owned(),
                target: Target::Facets(top),
                load: Load::Pressure(stress),
                schedule: Schedule::Ramp(3e-4),
            },
        ],
        joint_sets: vec![JointSet {
            name: "joint".to_owned(),
            strength: Strength {
                tensile: 0.5e6,
                cohesion,
                friction,
                energy_i: 50.0,
                energy_ii: 300.0,
                weibull_modulus: None,
                seed: 0,
            },
            residual_friction: residual,
            dilation: 0.0,
            dilation_slip: None,
            normal_stiffness: Some(4e11),
            shear_stiffness: Some(1e11),
            open: false,
        }],
        plane: Plane::Strain,
        mesh,
        ..Model::default()
    };
    model.add_joints(0, &joint);
    let mut run = start(model)?;
    let (mut peak, mut last) = (0.0_f64, [0.0, 0.0]);
    while run.time() < 1.6e-2 {
        advance(&mut run, 10)?;
        let traction = -force(&run, 0)?[0] / length;
        peak = peak.max(traction);
        if run.time() > 1.4e-2 {
            last = [last[0] + traction, last[1] + 1.0];
        }
    }
    Ok([peak, last[0] / last[1]])
}
