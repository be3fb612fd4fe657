use crate::common::*;
use fdem_grains::*;

const STIFFNESS: f64 = 1e4;

/// Spheres that move in all directions in a box that repeats along all axes.
fn gas() -> GrainModel {
    let side = 0.0101;
    let mut number = random(11);
    let cells: Vec<[f64; 3]> =
        (0..125).map(|k| [k % 5, k / 5 % 5, k / 25].map(|x| side * (f64::from(x) + 0.5))).collect();
    GrainModel {
        spheres: Spheres {
            radii: cells.iter().map(|_| 0.004 + 0.001 * number()).collect(),
            velocities: cells.iter().map(|_| [0.0; 3].map(|_: f64| 2.0 * (number() - 0.5))).collect(),
            positions: cells,
            ..Spheres::default()
        },
        domain: Some(cube(5.0 * side)),
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces::smooth([0, 0])],
        law: ForceLaw::Hooke { normal: STIFFNESS, tangential: 0.0 },
        step: Some(2e-6),
        ..GrainModel::default()
    }
}

/// The linear spring of [`gas`], as a law of the caller.
fn spring() -> SphereLaw {
    Box::new(|pairs| {
        for (pair, force) in pairs.forces.iter_mut().enumerate() {
            *force = pairs.normals[pair].map(|n| STIFFNESS * pairs.overlaps[pair].max(0.0) * n);
        }
        Ok(())
    })
}

/// A bond that breaks: a spring across the gap at which the couple was first seen, and a dashpot.
fn bond() -> SphereLaw {
    Box::new(|pairs| {
        for pair in 0..pairs.spheres.len() {
            let [first, count] = &mut pairs.memory[2 * pair..2 * pair + 2] else { unreachable!() };
            if *count == 0.0 {
                *first = pairs.overlaps[pair];
            }
            *count += 1.0;
            let normal = pairs.normals[pair];
            let along: f64 = (0..3).map(|k| normal[k] * pairs.velocities[pair][k]).sum();
            let stretch = *first - pairs.overlaps[pair];
            let size = if stretch.abs() < 2e-4 { -2e3 * stretch - 0.2 * along } else { 0.0 };
            pairs.forces[pair] = normal.map(|n| size * n);
            pairs.moments[pair] = [1e-7 * size, 0.0, 0.0];
        }
        Ok(())
    })
}

fn with(model: GrainModel, law: SphereLaw, options: SphereLawOptions) -> GrainRun {
    let mut run = GrainRun::new(model, 1).expect("a model");
    run.set_law(law, options).expect("a law");
    run
}

fn sum(energies: GrainEnergies) -> f64 {
    let GrainEnergies { kinetic, rotational, elastic, weight, dissipated, external, on_bodies } = energies;
    kinetic + rotational + elastic + weight + dissipated + on_bodies - external
}

const BESIDES: SphereLawOptions = SphereLawOptions { reach: 0.001, columns: 2, replaces: false };
const REPLACES: SphereLawOptions = SphereLawOptions { reach: 0.0, columns: 0, replaces: true };

/// A law of the caller with the formula of the model gives the paths and the contacts of the model.
#[test]
fn a_law_of_the_caller_replaces_that_of_the_model() {
    let mut own = GrainRun::new(gas(), 1).expect("a model");
    let mut by_program = with(gas(), spring(), REPLACES);
    let first = sum(by_program.energies());
    let mut kinetic = [f64::INFINITY, 0.0_f64];
    for _ in 0..10 {
        own.advance(150).expect("steps");
        by_program.advance(150).expect("steps");
        let energies = by_program.energies();
        kinetic = [kinetic[0].min(energies.kinetic), kinetic[1].max(energies.kinetic)];
        assert!((sum(energies) - first).abs() < 2e-3 * first, "{} {first}", sum(energies));
        assert_eq!(energies.elastic, 0.0);
    }
    assert!(kinetic[0] < 0.97 * kinetic[1], "energy goes into springs and back: {kinetic:?}");
    for sphere in 0..own.count() {
        for (a, b) in own.position(sphere).into_iter().zip(by_program.position(sphere)) {
            assert!((a - b).abs() < 1e-9, "{sphere} {a} {b}");
        }
    }
    let [own, by_program] = [own.contacts(), by_program.contacts()];
    assert!(own.len() > 10, "{}", own.len());
    assert_eq!(own.len(), by_program.len());
    for (a, b) in own.iter().zip(&by_program) {
        assert_eq!((a.sphere, a.other), (b.sphere, b.other));
        assert!((a.normal - b.normal).abs() < 1e-6 * STIFFNESS * 1e-3, "{} {}", a.normal, b.normal);
    }
}

/// Couples across a gap are in the law, in the results, and in the pressure of the box.
#[test]
fn a_law_acts_across_gaps() {
    let mut run = with(gas(), bond(), BESIDES);
    let first = sum(run.energies());
    run.advance(100).expect("steps");
    let contacts = run.contacts();
    let apart = contacts.iter().filter(|of| of.overlap < 0.0).count();
    assert!(apart > 100, "{apart} of {}", contacts.len());
    assert!(contacts.windows(2).all(|two| (two[0].sphere, two[0].other) < (two[1].sphere, two[1].other)));
    let energies = run.energies();
    assert!((sum(energies) - first).abs() < 1e-3 * first, "{energies:?} {first}");
    assert!(energies.external.abs() > 0.01 * first, "{energies:?} {first}");
    let columns = run.columns();
    for axis in 0..3 {
        let total: f64 = columns.forces.iter().map(|force| force[axis]).sum();
        let size: f64 = columns.forces.iter().map(|force| force[axis].abs()).sum();
        assert!(total.abs() < 1e-12 * size, "{total} {size}");
    }
    let [lengths, pressure] = run.box_pressure().expect("a box");
    let middle = |of: &GrainContact| {
        let GrainPartner::Sphere(other) = of.other else { panic!("spheres alone") };
        let apart = columns.positions[of.sphere as usize][0] - columns.positions[other as usize][0];
        of.force[0] * (apart - lengths[0] * (apart / lengths[0]).round())
    };
    let found = contacts.iter().map(middle).sum::<f64>() / lengths.iter().product::<f64>();
    assert!((found - pressure[0]).abs() < 0.02 * found.abs(), "{found} {pressure:?}");
}

#[test]
fn threads_and_states_keep_the_memory_of_a_law() {
    let mut whole = with(gas(), bond(), BESIDES);
    whole.advance(300).expect("steps");
    let saved = bytes(&whole);
    whole.advance(300).expect("steps");
    let mut threads = GrainRun::new(gas(), 2).expect("a model");
    threads.set_law(bond(), BESIDES).expect("a law");
    threads.advance(600).expect("steps");
    assert!(bytes(&threads) == bytes(&whole));
    let state = || postcard::from_bytes(&saved).expect("a state");
    let mut resumed = GrainRun::resume(gas(), state(), 2).expect("the same model");
    assert!(bytes(&resumed) == saved);
    let error = resumed.advance(1).expect_err("it has no law yet").to_string();
    assert_eq!(error, "law of the program: the run that is continued has a law of a program: set it again");
    let error = resumed.set_law(spring(), REPLACES).expect_err("another law").to_string();
    assert_eq!(
        error,
        "law of the program: the law of the run that is continued has reach 1e-3 m, 2 columns of memory, and acts \
         besides the law of the model"
    );
    resumed.set_law(bond(), BESIDES).expect("the law");
    resumed.advance(300).expect("steps");
    assert!(bytes(&resumed) == bytes(&whole));
    // Without its memory it is another run.
    let mut forgetful = GrainRun::resume(gas(), state(), 1).expect("the same model");
    forgetful.clear_law().expect("none");
    forgetful.set_law(bond(), BESIDES).expect("a new law");
    forgetful.advance(300).expect("steps");
    assert!(bytes(&forgetful) != bytes(&whole));
}

/// The energies balance when a law comes and goes between two steps.
#[test]
fn laws_come_and_go() {
    let mut run = GrainRun::new(gas(), 1).expect("a model");
    run.advance(200).expect("steps");
    let first = sum(run.energies());
    run.set_law(spring(), REPLACES).expect("a law");
    run.advance(200).expect("steps");
    assert_eq!(run.energies().elastic, 0.0);
    run.clear_law().expect("none");
    run.advance(200).expect("steps");
    let energies = run.energies();
    assert!(energies.elastic > 0.0);
    assert!((sum(energies) - first).abs() < 5e-3 * first, "{} {first}", sum(energies));
}

#[test]
fn laws_that_fail_are_named() {
    let failing: [(SphereLaw, &str); 4] = [
        (Box::new(|_| Err("no such table".to_owned())), "no such table"),
        (
            Box::new(|pairs| {
                pairs.forces.pop();
                Ok(())
            }),
            "it has returned 0 forces instead of 1",
        ),
        (
            Box::new(|pairs| {
                pairs.moments[0][1] = f64::NAN;
                Ok(())
            }),
            "it gives spheres 0 and 1 a value of NaN",
        ),
        (
            Box::new(|pairs| {
                pairs.forces[0][2] = 1.0;
                Ok(())
            }),
            "it moves discs 0 and 1 out of their plane",
        ),
    ];
    let discs = GrainModel {
        spheres: Spheres {
            positions: vec![[0.0; 3], [0.0195, 0.0, 0.0]],
            radii: vec![0.01; 2],
            ..Spheres::default()
        },
        discs: Some(0.01),
        domain: None,
        ..gas()
    };
    for (law, why) in failing {
        let mut run = with(discs.clone(), law, REPLACES);
        let error = run.advance(1).expect_err(why);
        assert_eq!(error.to_string(), format!("law of the program: {why}"));
    }
    let mut run = GrainRun::new(discs.clone(), 1).expect("a model");
    let error =
        run.set_law(spring(), SphereLawOptions { reach: f64::NAN, ..BESIDES }).expect_err("no number");
    assert_eq!(error.to_string(), "law of the program: reach is NaN, and must be at least 0");
    let servo = BoxServo { pressures: [Some(1e4); 3], largest_rate: 1.0 };
    let kept = GrainModel { domain: Some(Domain { servo: Some(servo), ..cube(0.055) }), ..gas() };
    let error =
        GrainRun::new(kept, 1).expect("a model").set_law(spring(), REPLACES).expect_err("no stiffness");
    assert!(error.to_string().contains("the servo of the box needs the stiffness"), "{error}");
}
