use crate::common::*;
use fdem_grains::*;

/// Test 1 of Chung and Ooi: two equal spheres meet at 10 m/s each.
#[test]
fn two_spheres_meet_as_hertz_says() {
    for (of, force, overlap, time) in [
        (material(48e9, 0.20, 2800.0), 10_696.9, 274.11e-6, 40.338e-6),
        (material(20e9, 0.25, 2500.0), 7_108.2, 368.30e-6, 54.200e-6),
    ] {
        let model = GrainModel {
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
        };
        let mut run = GrainRun::new(model, 1).expect("a model");
        let (mut most, mut deepest, mut end) = (0.0_f64, 0.0_f64, 0.0);
        for _ in 0..4000 {
            run.advance(1).expect("a step");
            let contacts = run.contacts();
            let Some(contact) = contacts.first() else {
                end = if run.steps() > 1 { run.time() } else { 0.0 };
                if end > 0.0 {
                    break;
                }
                continue;
            };
            most = most.max(contact.normal);
            deepest = deepest.max(contact.overlap);
        }
        assert!((most / force - 1.0).abs() < 1e-4, "{most} {force}");
        assert!((deepest / overlap - 1.0).abs() < 1e-4, "{deepest} {overlap}");
        assert_eq!(run.deepest_overlap(), Some((deepest / 0.01, 0)));
        assert!((end / time - 1.0).abs() < 2e-3, "{end} {time}");
        assert!((run.velocity(0)[0] + 10.0).abs() < 1e-4, "{:?}", run.velocity(0));
    }
}

/// Test 2: a sphere meets a rigid plane at 0.2 m/s.
#[test]
fn a_sphere_meets_a_plane_as_hertz_says() {
    let rigid = material(f64::INFINITY, 0.3, 1.0);
    for (of, force, overlap, time) in [
        (material(70e9, 0.30, 2699.0), 11_369.9, 49.717e-6, 731.64e-6),
        (material(40e9, 0.35, 1800.0), 7_232.7, 52.123e-6, 767.05e-6),
    ] {
        let mut model = on_plane(0.1, [0.0, 0.0, -0.2], [0.0; 3], [of, rigid]);
        model.step = Some(time / 2000.0);
        let (run, most, deepest, end) = bounce(model);
        assert!((most / force - 1.0).abs() < 1e-4, "{most} {force}");
        assert!((deepest / overlap - 1.0).abs() < 1e-4, "{deepest} {overlap}");
        let (share, sphere) = run.deepest_overlap().expect("an impact");
        assert!((0.1 * share / overlap - 1.0).abs() < 1e-4 && sphere == 0, "{share}");
        assert!((end / time - 1.0).abs() < 2e-3, "{end} {time}");
        assert!((run.velocity(0)[2] - 0.2).abs() < 1e-5);
    }
}

/// Test 3: the speed after an impact is the coefficient of restitution times that before, with both laws.
#[test]
fn restitution_is_exact() {
    for law in [ForceLaw::HertzMindlin, ForceLaw::Hooke { normal: 1e6, tangential: 0.8 }] {
        for (of, wall) in [
            (material(380e9, 0.23, 4000.0), material(380e9, 0.23, 4000.0)),
            (material(210e9, 0.3, 7000.0), material(100e9, 0.25, 7200.0)),
        ] {
            for k in 1..11 {
                let restitution = f64::from(k) / 10.0;
                let mut model = on_plane(2.5e-3, [0.0, 0.0, -3.9], [0.0; 3], [of, wall]);
                model.law = law;
                model.surfaces[0].restitution = restitution;
                model.step = Some(model.safe_step() / 80.0);
                let (run, ..) = bounce(model);
                let found = run.velocity(0)[2] / 3.9;
                assert!((found - restitution).abs() < 1e-4, "{law:?} {restitution} {found}");
            }
        }
    }
}

/// The impact of test 4 at an angle to the normal: the velocity along the plane after it over that before,
/// and the run.
fn oblique(degrees: f64) -> (f64, GrainRun) {
    let of = material(380e9, 0.23, 4000.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut model = on_plane(2.5e-3, [3.9 * sin, 0.0, -3.9 * cos], [0.0; 3], [of, of]);
    model.surfaces[0] = Surfaces { friction: 0.092, restitution: 0.98, ..Surfaces::smooth([0, 1]) };
    model.step = Some(model.safe_step() / 8.0);
    let (run, ..) = bounce(model);
    (run.velocity(0)[0] / (3.9 * sin), run)
}

/// Test 4: oblique impacts that slide from the beginning to the end have the velocities of a rigid body.
#[test]
fn an_oblique_impact_that_slides_is_that_of_a_rigid_body() {
    for (degrees, ratio, spin) in [
        (40.0, 0.7829, -544.2),
        (50.0, 0.8471, -456.7),
        (60.0, 0.8948, -355.2),
        (70.0, 0.9337, -243.0),
        (80.0, 0.9679, -123.4),
    ] {
        let (found, run) = oblique(degrees);
        assert!((found / ratio - 1.0).abs() < 1e-3, "{degrees} {found} {ratio}");
        // The spin about y turns the top forwards, with the sign of the published curve.
        let turned = -run.spin(0)[1];
        assert!((turned / spin - 1.0).abs() < 5e-3, "{degrees} {turned} {spin}");
    }
}

/// Test 4 at angles at which the contact sticks for some of the time, against the published curve, which was
/// read off a figure: 15 degrees and less are not compared, where published codes differ by more.
#[test]
fn an_oblique_impact_that_sticks_follows_the_published_curve() {
    for (degrees, ratio) in [(20.059, 0.6161), (25.05, 0.6343), (30.119, 0.6837), (35.03, 0.7372)] {
        let (found, _) = oblique(degrees);
        assert!((found / ratio - 1.0).abs() < 1e-2, "{degrees} {found} {ratio}");
    }
}

/// Tests 5 and 6: gross sliding with and without restitution and with a spin, and a stick where the angle is
/// small.
#[test]
fn oblique_impacts_follow_the_formulas_of_sliding() {
    let steel = material(208e9, 0.3, 7850.0);
    let polyethylene = material(1e9, 0.4, 1400.0);
    for (of, radius, normal, friction, restitution) in
        [(steel, 1e-5, 5.0, 0.3, 1.0), (polyethylene, 1e-5, 5.0, 0.3, 1.0), (steel, 0.1, 0.2, 0.4, 0.5)]
    {
        let most = 3.5 * friction * (1.0 + restitution);
        for tangent in [1.2 * most, 2.0 * most, 5.0 * most] {
            for share in [0.0, 0.5] {
                // Half of the speed at the contact from the velocity, or from the spin.
                let speed = tangent * normal;
                let spin = -share * speed / radius;
                let velocity = [(1.0 - share) * speed, 0.0, -normal];
                let mut model = on_plane(radius, velocity, [0.0, spin, 0.0], [of, of]);
                model.surfaces[0] = Surfaces { friction, restitution, ..Surfaces::smooth([0, 1]) };
                model.step = Some(model.safe_step() / 8.0);
                let (run, _, depth, _) = bounce(model);
                // The arm of the force is shorter by the depth.
                let bound = 2e-3 + depth / radius;
                let kick = friction * (1.0 + restitution) * normal;
                let expected = (1.0 - share) * speed - kick;
                assert!(
                    (run.velocity(0)[0] - expected).abs() < bound * kick,
                    "{:?} {expected}",
                    run.velocity(0)
                );
                let expected = spin + 2.5 * kick / radius;
                assert!(
                    (run.spin(0)[1] - expected).abs() < 2.5 * bound * kick / radius,
                    "{:?} {expected}",
                    run.spin(0)
                );
            }
        }
    }
}

/// Test 7: two spheres that meet head on and turn in opposite ways roll over each other: no force across.
#[test]
fn opposite_spins_have_no_friction() {
    for spin in [0.175, 5.0, 22.9] {
        let of = material(70e9, 0.33, 2700.0);
        let model = GrainModel {
            spheres: Spheres {
                positions: vec![[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]],
                radii: vec![0.1; 2],
                velocities: vec![[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]],
                spins: vec![[0.0, 0.0, spin], [0.0, 0.0, -spin]],
                ..Spheres::default()
            },
            materials: vec![of],
            surfaces: vec![Surfaces { friction: 0.4, restitution: 0.5, ..Surfaces::smooth([0, 0]) }],
            ..GrainModel::default()
        };
        let mut run = GrainRun::new(model, 1).expect("a model");
        run.advance(3000).expect("steps");
        assert!((run.velocity(0)[0] + 0.1).abs() < 1e-3, "{:?}", run.velocity(0));
        assert!(
            run.velocity(0)[1].abs() < 1e-12 && (run.spin(0)[2] - spin).abs() < 1e-12,
            "{:?}",
            run.spin(0)
        );
    }
}

/// Test 8: a turning sphere meets one at rest that is much heavier, as it would a wall.
#[test]
fn a_heavy_sphere_is_a_wall() {
    let of = material(70e9, 0.33, 2700.0);
    let heavy = material(70e9, 0.33, 2.7e12);
    let (friction, restitution) = (0.4, 0.5);
    let kick = friction * (1.0 + restitution) * 0.2;
    for spin in [20.0, 80.0] {
        let model = GrainModel {
            spheres: Spheres {
                positions: vec![[0.0, 0.0, 0.1], [0.0, 0.0, -0.2]],
                radii: vec![0.1, 0.2],
                velocities: vec![[0.0, 0.0, -0.2], [0.0; 3]],
                spins: vec![[0.0, spin, 0.0], [0.0; 3]],
                materials: vec![0, 1],
                ..Spheres::default()
            },
            materials: vec![of, heavy],
            surfaces: vec![Surfaces { friction, restitution, ..Surfaces::smooth([0, 1]) }],
            ..GrainModel::default()
        };
        let mut run =
            GrainRun::new(GrainModel { step: Some(model.safe_step() / 4.0), ..model }, 1).expect("a model");
        run.advance(8000).expect("steps");
        assert!((run.velocity(0)[2] - 0.1).abs() < 1e-4, "{:?}", run.velocity(0));
        // The contact moves along -x at the bottom, so friction pushes along +x.
        assert!((run.velocity(0)[0] / kick - 1.0).abs() < 5e-3, "{spin} {:?} {kick}", run.velocity(0));
        let turned = spin - 2.5 * kick / 0.1;
        assert!((run.spin(0)[1] / turned - 1.0).abs() < 1e-2, "{:?} {turned}", run.spin(0));
    }
}

/// An impact at 76 degrees without restitution loss must not gain energy; one in which it sticks loses
/// little.
#[test]
fn no_oblique_impact_gains_energy() {
    let of = material(50e9, 0.3, 2500.0);
    for degrees in [5.0, 20.0, 45.0, 60.0, 70.0, 76.0, 80.0, 85.0] {
        for friction in [0.1, 0.5, 100.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let mut model = on_plane(0.01, [3.0 * sin, 0.0, -3.0 * cos], [0.0; 3], [of, of]);
            model.surfaces[0].friction = friction;
            model.step = Some(model.safe_step() / 4.0);
            let before = GrainRun::new(model.clone(), 1).expect("a model").energies();
            let (run, ..) = bounce(model);
            let after = run.energies();
            let gain = (after.kinetic + after.rotational) / (before.kinetic + before.rotational) - 1.0;
            assert!(gain < 1e-3, "{degrees} {friction} {gain}");
            if friction > 10.0 {
                assert!(gain > -0.25, "{degrees} {gain}");
            }
        }
    }
}
