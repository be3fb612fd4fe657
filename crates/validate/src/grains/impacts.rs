//! Impacts along the normal: Hertz's elastic impact, and the coefficient of restitution.

use fdem_grains::{ForceLaw, GrainMaterial, GrainModel, GrainRun, Spheres, Surfaces};

use super::models::{
    GRAVITY, advance_to, hertz_depth, mass, material, on_plane, reduced_modulus, rigid, start,
};
use crate::outcome::{Outcome, Size};

/// Most steps of one impact.
const MOST_STEPS: u64 = 1_000_000;

/// An impact on a plane.
pub(super) struct Impact {
    /// The run after it.
    pub(super) run: GrainRun,
    /// Largest force, N, and overlap, m.
    pub(super) force: f64,
    pub(super) overlap: f64,
    /// Duration, s.
    pub(super) time: f64,
}

/// Runs a model of one sphere on the plane z = 0 until the sphere has left the plane. Looks at it every
/// `stride` steps.
pub(super) fn impact(model: GrainModel, stride: u64) -> Result<Impact, String> {
    let radius = model.spheres.radii[0];
    let mut run = start(model)?;
    let (mut force, mut overlap) = (0.0_f64, 0.0_f64);
    while run.steps() < MOST_STEPS {
        overlap = overlap.max(radius - run.position(0)[2]);
        run.advance(stride).map_err(|error| error.to_string())?;
        force = force.max(-run.wall_force(0)[2]);
        if run.position(0)[2] > radius && run.velocity(0)[2] > 0.0 && run.wall_force(0) == [0.0; 3] {
            // The plane exerted a force up to the step before this one.
            let time = run.time() - run.time_step();
            return Ok(Impact { run, force, overlap, time });
        }
    }
    Err("the sphere does not leave the plane".to_owned())
}

/// Largest force, N, and overlap, m, and the duration, s, of an elastic impact. `of`: the reduced mass, kg.
fn hertz(of: f64, speed: f64, modulus: f64, radius: f64) -> [f64; 3] {
    let depth = libm::pow(15.0 / 16.0 * of * speed * speed / (modulus * radius.sqrt()), 0.4);
    [4.0 / 3.0 * modulus * radius.sqrt() * depth.powf(1.5), depth, 2.943_275 * depth / speed]
}

/// Tests 1 and 2 of Chung and Ooi.
pub(crate) fn elastic(_: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let mut compare = |name: &str, expected: [f64; 3], found: [f64; 3]| {
        for (k, (of, unit)) in [("force", "N"), ("overlap", "m")].into_iter().enumerate() {
            let bound = 1e-4;
            outcomes.push(Outcome::relative(
                format!("largest {of}, {name}"),
                expected[k],
                found[k],
                bound,
                unit,
            ));
        }
        outcomes.push(Outcome::relative(format!("duration, {name}"), expected[2], found[2], 1e-3, "s"));
    };
    for (name, of) in [("glass", material(48e9, 0.2, 2800.0)), ("limestone", material(20e9, 0.25, 2500.0))] {
        let expected = hertz(0.5 * mass(0.01, of), 20.0, reduced_modulus([of, of]), 0.005);
        compare(&format!("two spheres of {name}"), expected, two_spheres(of, expected[2])?);
    }
    for (name, of) in
        [("aluminium alloy", material(70e9, 0.3, 2699.0)), ("magnesium alloy", material(40e9, 0.35, 1800.0))]
    {
        let expected = hertz(mass(0.1, of), 0.2, reduced_modulus([of, rigid()]), 0.1);
        let mut model = on_plane(0.1, [0.0, 0.0, -0.2], [0.0; 3], [of, rigid()]);
        model.step = Some(expected[2] / 2000.0);
        let Impact { force, overlap, time, .. } = impact(model, 1)?;
        compare(&format!("{name} on a plane"), expected, [force, overlap, time]);
    }
    Ok(outcomes)
}

/// Two spheres of 1 cm that meet at 10 m/s each. Returns the largest force, the largest overlap and the time.
fn two_spheres(of: GrainMaterial, time: f64) -> Result<[f64; 3], String> {
    let mut run = start(GrainModel {
        spheres: Spheres {
            positions: vec![[-0.01, 0.0, 0.0], [0.01, 0.0, 0.0]],
            radii: vec![0.01; 2],
            velocities: vec![[10.0, 0.0, 0.0], [-10.0, 0.0, 0.0]],
            ..Spheres::default()
        },
        materials: vec![of],
        surfaces: vec![Surfaces::smooth([0, 0])],
        step: Some(time / 2000.0),
        ..GrainModel::default()
    })?;
    let (mut force, mut overlap) = (0.0_f64, 0.0_f64);
    while run.steps() < 4000 {
        run.advance(1).map_err(|error| error.to_string())?;
        match run.contacts().first() {
            Some(contact) => {
                force = force.max(contact.normal);
                overlap = overlap.max(contact.overlap);
            }
            None if run.steps() > 1 => return Ok([force, overlap, run.time() - run.time_step()]),
            None => {}
        }
    }
    Err("the spheres do not part".to_owned())
}

/// Test 3 of Chung and Ooi, and its whole range of coefficients.
pub(crate) fn restitution(size: Size) -> Result<Vec<Outcome>, String> {
    const SPEED: f64 = 3.9;
    const RADIUS: f64 = 2.5e-3;
    let oxide = material(380e9, 0.23, 4000.0);
    let iron = material(210e9, 0.3, 7000.0);
    let mut outcomes = Vec::new();
    let hooke = ForceLaw::Hooke { normal: 1e6, tangential: 0.8 };
    for (name, law, of) in [
        ("Hertz, aluminium oxide", ForceLaw::HertzMindlin, oxide),
        ("Hertz, cast iron", ForceLaw::HertzMindlin, iron),
        ("Hooke", hooke, oxide),
    ] {
        for k in (1..=10).rev() {
            // Cast iron has the coefficients of Chung and Ooi only.
            if size == Size::Reduced && of == iron && k % 2 == 1 {
                continue;
            }
            let expected = f64::from(k) / 10.0;
            let mut model = on_plane(RADIUS, [0.0, 0.0, -SPEED], [0.0; 3], [of, of]);
            model.law = law;
            model.surfaces[0].restitution = expected;
            model.step = Some(model.safe_step() / 80.0);
            let after = impact(model, 50)?.run.velocity(0)[2];
            let quantity = format!("restitution {expected}, {name}");
            outcomes.push(Outcome::absolute(quantity, expected, after / SPEED, 1e-4, ""));
        }
    }
    Ok(outcomes)
}

/// A sphere falls on a plane and comes to rest at the overlap at which Hertz's force is its weight.
pub(crate) fn rest(_: Size) -> Result<Vec<Outcome>, String> {
    let of = material(1e8, 0.3, 2500.0);
    let weight = mass(0.01, of) * GRAVITY;
    let depth = hertz_depth(weight, reduced_modulus([of, of]), 0.01);
    let mut model = on_plane(0.01, [0.0, 0.0, -0.2], [0.0; 3], [of, of]);
    model.gravity = [0.0, 0.0, -GRAVITY];
    model.surfaces[0].restitution = 0.3;
    let mut run = start(model)?;
    advance_to(&mut run, 0.3)?;
    Ok(vec![
        Outcome::relative("overlap at rest", depth, 0.01 - run.position(0)[2], 1e-6, "m"),
        Outcome::relative("force at rest", weight, -run.wall_force(0)[2], 1e-6, "N"),
    ])
}
