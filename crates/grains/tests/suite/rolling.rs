use crate::common::*;
use fdem_grains::*;

fn rolling(slope_degrees: f64, friction: f64, rolling_friction: f64, velocity: f64, spin: f64) -> GrainModel {
    let of = material(1e9, 0.3, 2500.0);
    let mut model = on_plane(0.05, [velocity, 0.0, 0.0], [0.0, spin, 0.0], [of, of]);
    let (sin, cos) = slope_degrees.to_radians().sin_cos();
    model.gravity = [9.81 * sin, 0.0, -9.81 * cos];
    model.surfaces[0] = Surfaces {
        friction,
        rolling_friction,
        rolling_damping: 0.3,
        restitution: 0.2,
        ..Surfaces::smooth([0, 1])
    };
    // At rest on the plane, by Hertz's law.
    let young = 0.5 * 1e9 / (1.0 - 0.09);
    let weight = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.05_f64.powi(3) * 9.81 * cos;
    let depth = (0.75 * weight / (young * 0.05_f64.sqrt())).powf(2.0 / 3.0);
    model.spheres.positions[0][2] -= depth;
    model
}

/// A sphere that rolls without slip is slowed down by 5/7 of the rolling friction times g, and then stays.
#[test]
fn rolling_friction_stops_a_sphere_and_holds_it() {
    let mut model = rolling(0.0, 0.5, 0.1, 1.0, 20.0);
    model.step = Some(2e-5);
    let mut run = GrainRun::new(model, 1).expect("a model");
    run.advance(50_000).expect("steps");
    let slowed = 1.0 - run.velocity(0)[0];
    assert!((slowed / 0.7007 - 1.0).abs() < 5e-3, "{slowed}");
    run.advance(50_000).expect("steps");
    let stopped = run.position(0)[0];
    assert!((stopped / 0.7136 - 1.0).abs() < 1e-2, "{stopped}");
    assert!(run.velocity(0)[0].abs() < 1e-6, "{:?}", run.velocity(0));
    run.advance(100_000).expect("steps");
    let drift = (run.position(0)[0] - stopped).abs();
    assert!(drift < 1e-7, "{drift}");
}

/// On a slope a sphere rests if its tangent is below both coefficients, or else rolls.
#[test]
fn a_sphere_rests_or_rolls_on_a_slope() {
    for (degrees, friction, resistance) in
        [(5.0, 0.5, 0.12), (8.0, 0.5, 0.12), (20.0, 0.5, 0.12), (20.0, 0.5, 0.0)]
    {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let mut run = GrainRun::new(rolling(degrees, friction, resistance, 0.0, 0.0), 1).expect("a model");
        let steps = (0.5 / run.time_step()) as u64;
        run.advance(steps).expect("steps");
        let found = run.velocity(0)[0] / run.time();
        if sin / cos < resistance {
            // The plane of the spring gives way a little at first.
            assert!(found.abs() < 1e-3, "{degrees} {found}");
        } else {
            let expected = 5.0 / 7.0 * 9.81 * (sin - resistance * cos);
            assert!((found - expected).abs() < 1e-3 * 9.81, "{degrees} {found} {expected}");
        }
    }
}

/// A sphere that slides at first rolls at 5/7 of its speed in the end.
#[test]
fn a_sliding_sphere_begins_to_roll() {
    let mut run = GrainRun::new(rolling(0.0, 0.2, 0.0, 2.0, 0.0), 1).expect("a model");
    let steps = (0.6 / run.time_step()) as u64;
    run.advance(steps).expect("steps");
    let [speed, ..] = run.velocity(0);
    assert!((speed / (10.0 / 7.0) - 1.0).abs() < 2e-3, "{speed}");
    assert!((run.spin(0)[1] * 0.05 / speed - 1.0).abs() < 5e-3, "{:?}", run.spin(0));
}

/// Two spheres that stick to each other are pulled apart with the force of Johnson, Kendall and Roberts.
#[test]
fn adhesion_holds_two_spheres_until_the_pull_off() {
    let of = material(1.5e8, 0.5, 1000.0);
    let adhesion = 0.05;
    let model = GrainModel {
        spheres: Spheres {
            positions: vec![[0.0; 3], [0.0, 0.0, 4e-3 - 1e-7]],
            radii: vec![2e-3; 2],
            velocities: vec![[0.0; 3], [0.0, 0.0, 1e-4]],
            held: vec![true; 2],
            ..Spheres::default()
        },
        materials: vec![of],
        surfaces: vec![Surfaces { adhesion, ..Surfaces::smooth([0, 0]) }],
        step: Some(1e-7),
        ..GrainModel::default()
    };
    let mut run = GrainRun::new(model, 1).expect("a model");
    let (mut pull, mut last) = (0.0_f64, 0.0);
    for _ in 0..40_000 {
        run.advance(1).expect("a step");
        let Some(contact) = run.contacts().first().copied() else { break };
        pull = pull.max(-contact.normal);
        last = contact.overlap;
    }
    assert!(run.contacts().is_empty());
    let expected = 1.5 * std::f64::consts::PI * adhesion * 1e-3;
    assert!((pull / expected - 1.0).abs() < 1e-3, "{pull} {expected}");
    assert!((last / -0.1013e-6 - 1.0).abs() < 1e-2, "{last}");
    // Spheres that approach do not pull before they touch.
    assert!(last < 0.0);
}
