use crate::common::*;
use fdem_grains::*;

/// Spheres on a lattice with gaps, which move in all directions, in a box that repeats along all axes.
fn gas(servo: BoxServo, strain_rates: [f64; 3]) -> GrainModel {
    let side = 0.011;
    let mut number = random(7);
    let cells: Vec<[f64; 3]> =
        (0..343).map(|k| [k % 7, k / 7 % 7, k / 49].map(|x| side * (f64::from(x) + 0.5))).collect();
    GrainModel {
        spheres: Spheres {
            radii: cells.iter().map(|_| 0.004 + 0.001 * number()).collect(),
            velocities: cells.iter().map(|_| [0.0; 3].map(|_: f64| 0.4 * (number() - 0.5))).collect(),
            positions: cells,
            ..Spheres::default()
        },
        domain: Some(Domain { strain_rates, servo: Some(servo), ..cube(7.0 * side) }),
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces { friction: 0.4, restitution: 0.4, ..Surfaces::smooth([0, 0]) }],
        ..GrainModel::default()
    }
}

/// A third of the time step of a Rayleigh wave keeps a dense packing stable; the whole of it does not.
#[test]
fn a_step_that_is_too_long_for_many_contacts_is_refused() {
    let model = GrainModel { step: Some(5e-5), ..gas(CONFINED, [0.0; 3]) };
    assert!(GrainModel { step: None, ..model.clone() }.safe_step() < 3e-5);
    let mut run = GrainRun::new(model, 1).expect("a model");
    let error = run.advance(10_000).expect_err("too long a step");
    assert!(matches!(error, GrainError::Unstable { contacts: 4..=12, .. }), "{error}");
    let message = error.to_string();
    assert!(message.starts_with("the step of 5.0e-5 s is too long for sphere "), "{message}");
}

const CONFINED: BoxServo = BoxServo { pressures: [Some(2e4); 3], largest_rate: 2.0 };

/// The pressure is reached along all axes and kept, the spheres come to rest, and the energies balance.
#[test]
fn a_box_keeps_its_pressure() {
    let mut run = GrainRun::new(gas(CONFINED, [0.0; 3]), 1).expect("a model");
    let begin = run.energies();
    let total = |of: &GrainEnergies| of.kinetic + of.rotational + of.elastic + of.weight + of.dissipated;
    run.advance((0.4 / run.time_step()) as u64).expect("steps");
    let mut farthest = 0.0_f64;
    for _ in 0..100 {
        run.advance(17).expect("steps");
        let [_, pressures] = run.box_pressure().expect("a box");
        farthest = pressures.into_iter().fold(farthest, |most, p| most.max((p / 2e4 - 1.0).abs()));
    }
    let end = run.energies();
    assert!(farthest < 0.005, "{farthest}");
    assert!(end.kinetic < 1e-3 * end.elastic, "{end:?}");
    let supplied = end.external - begin.external;
    let error = (total(&end) - total(&begin) - supplied) / supplied;
    assert!(error.abs() < 1e-3, "{error:e} {begin:?} {end:?}");
}

/// A triaxial test without walls: along one axis the box shrinks at a rate, along the others it keeps up
/// its pressure.
#[test]
fn a_triaxial_test_has_the_strength_of_its_friction() {
    let mut run = GrainRun::new(gas(CONFINED, [0.0; 3]), 1).expect("a model");
    run.advance((0.3 / run.time_step()) as u64).expect("steps");
    let [lengths, _] = run.box_pressure().expect("a box");
    let mut model = gas(CONFINED, [0.0, 0.0, -0.3]);
    let domain = model.domain.as_mut().expect("a box");
    let centre = 0.5 * (domain.high[0] - domain.low[0]);
    (domain.low, domain.high) =
        (lengths.map(|side| centre - 0.5 * side), lengths.map(|side| centre + 0.5 * side));
    domain.servo = Some(BoxServo { pressures: [Some(2e4), Some(2e4), None], largest_rate: 2.0 });
    model.spheres.positions = (0..343).map(|sphere| run.position(sphere)).collect();
    model.spheres.velocities.clear();
    let mut run = GrainRun::new(model, 1).expect("a model");
    let (mut ratios, mut farthest) = (Vec::new(), 0.0_f64);
    for _ in 0..(0.008 / run.time_step()) as u64 {
        run.advance(100).expect("steps");
        if run.time() > 0.1 {
            let [_, p] = run.box_pressure().expect("a box");
            ratios.push(2.0 * p[2] / (p[0] + p[1]));
            farthest = farthest.max((p[0] / 2e4 - 1.0).abs()).max((p[1] / 2e4 - 1.0).abs());
        }
    }
    let largest = ratios.iter().copied().fold(0.0, f64::max);
    assert!(farthest < 0.005, "{farthest}");
    // A loose packing, with friction of 0.4: angles of friction of 17 to 34 degrees.
    assert!((1.83..3.54).contains(&largest), "{largest}");
}

#[test]
fn threads_and_states_change_no_bit() {
    let model =
        || gas(BoxServo { pressures: [Some(2e4), None, Some(1e4)], largest_rate: 3.0 }, [0.0, -0.5, 0.0]);
    let mut whole = GrainRun::new(model(), 1).expect("a model");
    whole.advance(9000).expect("steps");
    let saved = bytes(&whole);
    whole.advance(1000).expect("steps");
    assert!(whole.contact_count() > 300, "{}", whole.contact_count());
    for threads in [1, 2] {
        let mut again = GrainRun::new(model(), threads).expect("a model");
        again.advance(10_000).expect("steps");
        assert!(bytes(&again) == bytes(&whole), "{threads}");
        let state = postcard::from_bytes(&saved).expect("a state");
        let mut resumed = GrainRun::resume(model(), state, threads).expect("the same model");
        resumed.advance(1000).expect("steps");
        assert!(bytes(&resumed) == bytes(&whole), "{threads}");
    }
}

#[test]
fn wrong_servos_are_refused() {
    let refused = |servo: BoxServo, rates: [f64; 3]| {
        GrainRun::new(gas(servo, rates), 1).expect_err("a wrong servo").to_string()
    };
    let still = BoxServo { largest_rate: 0.0, ..CONFINED };
    assert_eq!(refused(still, [0.0; 3]), "the servo of the box: largest rate is 0e0, and must be above 0");
    let twice = refused(CONFINED, [0.0, 0.1, 0.0]);
    assert!(
        twice.starts_with("the servo of the box along y: pressure is 2e4, and must be at least 0"),
        "{twice}"
    );
    let pulled = BoxServo { pressures: [Some(-1.0), None, None], ..CONFINED };
    assert!(refused(pulled, [0.0; 3]).contains("along x: pressure is -1e0"));
}

#[test]
fn discs_move_in_a_box() {
    let model = |periodic| GrainModel {
        spheres: Spheres {
            positions: vec![[0.05, 0.1, 0.0], [0.15, 0.1, 0.0]],
            radii: vec![0.01; 2],
            velocities: vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
            ..Spheres::default()
        },
        materials: vec![material(1e7, 0.2, 2500.0)],
        surfaces: vec![Surfaces { restitution: 1.0, ..Surfaces::smooth([0, 0]) }],
        discs: Some(0.5),
        domain: Some(Domain {
            low: [0.0, 0.0, -0.25],
            high: [0.2, 0.2, 0.25],
            periodic,
            outside: Outside::Delete,
            ..cube(0.2)
        }),
        ..GrainModel::default()
    };
    for periodic in [[false; 3], [true, true, false]] {
        let mut run = GrainRun::new(model(periodic), 1).expect("a model");
        run.advance((0.09 / run.time_step()) as u64).expect("steps");
        assert_eq!(run.count(), 2);
        // They have met, and go back.
        assert!((run.velocity(0)[0] + 1.0).abs() < 1e-3, "{:?}", run.velocity(0));
    }
    let mut endless = model([false; 3]);
    endless.domain.as_mut().expect("a box").high[2] = f64::INFINITY;
    let error = GrainRun::new(endless, 1).expect_err("an endless box").to_string();
    assert!(error.contains("the box along z: upper side is inf"), "{error}");
}
