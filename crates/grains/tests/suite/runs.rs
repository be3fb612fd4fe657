use crate::common::*;
use fdem_grains::*;

/// Spheres that fall into a tube with a floor that turns.
fn tube(count: usize) -> GrainModel {
    let side = 0.011;
    let place = |k: usize| {
        let [i, j, l] = [k % 5, (k / 5) % 5, k / 25].map(|x| x as f64);
        let shift = 1e-3 * ((k * 7919) % 13) as f64 / 13.0;
        [(i - 2.0) * side + shift, (j - 2.0) * side - shift, 0.006 + l * side]
    };
    GrainModel {
        spheres: Spheres {
            positions: (0..count).map(place).collect(),
            radii: (0..count).map(|k| 0.004 + 1e-3 * ((k * 31) % 7) as f64 / 7.0).collect(),
            ..Spheres::default()
        },
        walls: vec![
            Wall {
                rotation: Some(WallRotation { through: [0.0; 3], spin: [0.0, 0.0, 30.0] }),
                ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)
            },
            Wall {
                shape: WallShape::Tube { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radius: 0.04 },
                ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)
            },
        ],
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces {
            friction: 0.5,
            restitution: 0.5,
            rolling_friction: 0.05,
            rolling_damping: 0.2,
            ..Surfaces::smooth([0, 0])
        }],
        gravity: [0.0, 0.0, -9.81],
        // A fifth of the time of a Rayleigh wave.
        step: Some(6.8e-5),
        ..GrainModel::default()
    }
}

/// A lattice of spheres, close together, which fly at random.
fn swarm() -> GrainModel {
    let side = 9;
    let mut random = random(5);
    let mut spheres = Spheres::default();
    for k in 0..side * side * side {
        let [i, j, l] = [k % side, k / side % side, k / side / side].map(f64::from);
        spheres.positions.push([0.01 * i, 0.01 * j, 0.01 * l]);
        spheres.radii.push(0.004_99 - 1e-5 * random());
        spheres.velocities.push([random() - 0.5, random() - 0.5, random() - 0.5]);
        spheres.spins.push([10.0 * random(), 0.0, 0.0]);
    }
    GrainModel {
        spheres,
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces { friction: 0.3, restitution: 0.8, ..Surfaces::smooth([0, 0]) }],
        step: Some(1e-5),
        ..GrainModel::default()
    }
}

/// A run keeps lists of its contacts from step to step. One that is continued from a state makes them anew.
#[test]
fn contacts_that_begin_and_end_by_hundreds_change_no_bit() {
    let mut whole = GrainRun::new(swarm(), 1).expect("a model");
    let (mut most, mut ended) = (0, 0);
    let mut before = std::collections::BTreeSet::new();
    for step in 0..150 {
        let state = postcard::from_bytes(&bytes(&whole)).expect("a state");
        let mut resumed = GrainRun::resume(swarm(), state, 2).expect("the same model");
        whole.advance(1).expect("a step");
        resumed.advance(1).expect("a step");
        assert!(bytes(&resumed) == bytes(&whole), "{step}");
        let pair = |of: &GrainContact| (of.sphere, format!("{:?}", of.other));
        let now: std::collections::BTreeSet<_> = whole.contacts().iter().map(pair).collect();
        most = most.max(now.difference(&before).count());
        ended += before.difference(&now).count();
        before = now;
    }
    assert!(whole.detections() < 10, "{}", whole.detections());
    assert!(most > 40 && ended > 100, "{most} in one step, {ended} in all");
}

#[test]
fn threads_and_states_change_no_bit() {
    let mut whole = GrainRun::new(tube(2000), 1).expect("a model");
    whole.advance(1500).expect("steps");
    let saved = bytes(&whole);
    whole.advance(700).expect("steps");
    assert!(whole.contacts().len() > 300, "{}", whole.contacts().len());
    for threads in [1, 2, 3] {
        let mut again = GrainRun::new(tube(2000), threads).expect("a model");
        again.advance(2200).expect("steps");
        assert!(bytes(&again) == bytes(&whole), "{threads}");
        let state = postcard::from_bytes(&saved).expect("a state");
        let mut resumed = GrainRun::resume(tube(2000), state, threads).expect("the same model");
        resumed.advance(700).expect("steps");
        assert!(bytes(&resumed) == bytes(&whole), "{threads}");
    }
}

/// Couples that do not touch are not looked at in each step. None is missed, in a stream through a periodic
/// box whose spheres also move fast against each other, and whose sizes differ by a factor of four.
#[test]
fn each_contact_of_a_fast_gas_is_found() {
    let mut number = random(1);
    let cells = (0..512).map(|k| [k % 8, k / 8 % 8, k / 64].map(|x| 0.01 * (f64::from(x) + 0.5)));
    let positions: Vec<[f64; 3]> = cells.collect();
    let radii: Vec<f64> = positions.iter().map(|_| 0.0012 + 0.0035 * number()).collect();
    let side = 0.08;
    let velocities = positions.iter().map(|_| [30.0, 0.0, 0.0].map(|v| v + 8.0 * (number() - 0.5))).collect();
    let model = GrainModel {
        spheres: Spheres { positions, radii: radii.clone(), velocities, ..Spheres::default() },
        domain: Some(cube(side)),
        materials: vec![material(1e8, 0.25, 2500.0)],
        surfaces: vec![Surfaces { friction: 0.3, restitution: 0.9, ..Surfaces::smooth([0, 0]) }],
        ..GrainModel::default()
    };
    let mut run = GrainRun::new(model, 2).expect("a model");
    let mut touched = 0;
    for _ in 0..2000 {
        let before: Vec<[f64; 3]> = (0..512).map(|sphere| run.position(sphere)).collect();
        run.advance(1).expect("a step");
        let found: Vec<[usize; 2]> =
            run.contacts().iter().map(|of| [of.sphere as usize, other(of)]).collect();
        let mut expected = Vec::new();
        for i in 0..512 {
            for j in i + 1..512 {
                let apart = |axis: usize| {
                    let apart = before[i][axis] - before[j][axis];
                    apart - side * (apart / side).round()
                };
                let square: f64 = (0..3).map(|axis| apart(axis) * apart(axis)).sum();
                if square < (radii[i] + radii[j]) * (radii[i] + radii[j]) {
                    expected.push([i, j]);
                }
            }
        }
        touched += expected.len();
        assert_eq!(found, expected, "step {}", run.steps());
    }
    assert!(touched > 10_000 && run.detections() > 20, "{touched} {}", run.detections());
}

fn other(of: &GrainContact) -> usize {
    match of.other {
        GrainPartner::Sphere(number) => number as usize,
        _ => usize::MAX,
    }
}

/// All vector instructions give the bits of the plain ones.
#[test]
fn levels_change_no_bit() {
    let [hertz, hooke] = [ForceLaw::HertzMindlin, ForceLaw::Hooke { normal: 2000.0, tangential: 2.0 / 7.0 }];
    for law in [hertz, hooke] {
        for friction in [0.0, 0.5] {
            let mut model = GrainModel { law, ..tube(500) };
            model.surfaces[0].friction = friction;
            if friction == 0.0 {
                (model.surfaces[0].rolling_friction, model.surfaces[0].rolling_damping) = (0.0, 0.0);
            }
            let after = |simd| {
                let mut run = GrainRun::new(model.clone(), 1).expect("a model").with_simd(simd);
                run.advance(1200).expect("steps");
                assert!(run.contacts().len() > 50, "{}", run.contacts().len());
                bytes(&run)
            };
            let plain = after(fdem_contact::Simd::Portable);
            for simd in fdem_contact::Simd::available() {
                assert!(after(simd) == plain, "{law:?} {friction} {}", simd.name());
            }
        }
    }
}

/// The weight of all spheres is on the floor in the end.
#[test]
fn a_floor_carries_the_weight() {
    let mut model = tube(100);
    model.walls[0].rotation = None;
    model.walls.truncate(1);
    model.walls.push(Wall {
        shape: WallShape::Tube { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radius: 0.04 },
        ..model.walls[0].clone()
    });
    // A smooth tube carries no weight.
    model.materials.push(model.materials[0]);
    model.walls[1].material = 1;
    model.surfaces.push(Surfaces { restitution: 0.5, ..Surfaces::smooth([0, 1]) });
    let mut run = GrainRun::new(model.clone(), 2).expect("a model");
    run.advance((1.5 / run.time_step()) as u64).expect("steps");
    let volume: f64 = model.spheres.radii.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
    let weight = 2500.0 * volume * 9.81;
    assert!((run.wall_force(0)[2] / -weight - 1.0).abs() < 1e-3, "{:?} {weight}", run.wall_force(0));
    assert!(run.energies().kinetic < 1e-8, "{:?}", run.energies());
}

/// Momentum of many spheres that collide.
#[test]
fn collisions_keep_momentum() {
    let mut model = tube(1000);
    model.walls.clear();
    model.gravity = [0.0; 3];
    let speed = |k: usize| [(k * 17 % 11) as f64 - 5.0, (k * 13 % 7) as f64 - 3.0, (k * 5 % 9) as f64 - 4.0];
    model.spheres.velocities = (0..1000).map(speed).collect();
    let mut run = GrainRun::new(model.clone(), 2).expect("a model");
    let momentum = |run: &GrainRun| {
        let mut sum = [0.0; 3];
        for k in 0..1000 {
            let mass = model.spheres.radii[k].powi(3);
            (0..3).for_each(|axis| sum[axis] += mass * run.velocity(k)[axis]);
        }
        sum
    };
    let before = momentum(&run);
    run.advance(500).expect("steps");
    let after = momentum(&run);
    assert!((0..3).all(|axis| (after[axis] - before[axis]).abs() < 1e-18), "{before:?} {after:?}");
}

#[test]
fn wrong_models_are_refused() {
    let refused = |change: fn(&mut GrainModel)| {
        let mut model = tube(3);
        change(&mut model);
        GrainRun::new(model, 1).expect_err("refused").to_string()
    };
    assert_eq!(refused(|of| of.spheres.radii[1] = -1.0), "sphere 1: radius is -1e0, and must be above 0");
    assert_eq!(refused(|of| of.spheres.radii.push(1.0)), "4 radii instead of 3");
    assert_eq!(
        refused(|of| of.spheres.positions[2][1] = f64::NAN),
        "sphere 2: a coordinate is NaN, and must be a number"
    );
    assert_eq!(
        refused(|of| of.materials[0].density = 0.0),
        "material 0: density is 0e0, and must be above 0"
    );
    assert_eq!(refused(|of| of.spheres.materials = vec![0, 0, 4]), "sphere 2: there is no material 4");
    assert!(refused(|of| of.surfaces[0].restitution = 0.0).contains("restitution is 0e0"));
    assert!(refused(|of| of.surfaces[0].friction = -0.5).contains("friction is -5e-1"));
    assert!(refused(|of| of.step = Some(0.0)).contains("time step is 0e0"));
    assert!(refused(|of| of.walls[0].material = 3).contains("wall 0: there is no material 3"));
    let mut strangers = tube(60);
    strangers.surfaces.clear();
    let mut run = GrainRun::new(strangers, 1).expect("nothing touches yet");
    let stop = run.advance(3000).expect_err("they touch");
    assert_eq!(stop.to_string(), "materials 0 and 0 may touch, and have no surfaces in common");
}

/// A chute: the weight does its work along an axis that repeats, whatever side a sphere comes in on.
#[test]
fn the_weight_works_along_axes_that_repeat() {
    let clump = Clump { spheres: vec![1, 2], ..Clump::default() };
    let model = GrainModel {
        spheres: Spheres {
            positions: vec![[0.01, 0.01, 0.01], [0.03, 0.03, 0.03], [0.033, 0.03, 0.03]],
            radii: vec![0.003; 3],
            ..Spheres::default()
        },
        clumps: vec![clump],
        gravity: [4.0, 0.0, -9.81],
        domain: Some(cube(0.05)),
        materials: vec![material(5e6, 0.25, 2500.0)],
        surfaces: vec![Surfaces::smooth([0, 0])],
        step: Some(1e-4),
        ..GrainModel::default()
    };
    let mut run = GrainRun::new(model, 1).expect("a model");
    let total = |of: GrainEnergies| of.kinetic + of.rotational + of.weight - of.external;
    let begin = total(run.energies());
    run.advance(3000).expect("steps");
    let energies = run.energies();
    let fallen = run.velocity(0);
    assert!((fallen[0] - 1.2).abs() < 1e-3 && (fallen[2] + 2.943).abs() < 1e-3, "{fallen:?}");
    assert!((total(energies) - begin).abs() < 1e-6 * energies.kinetic, "{begin} {energies:?}");
}

/// Spheres that a program adds collide as those of the model, with the same bits on threads and after a
/// checkpoint, and none comes in where there is no room.
#[test]
fn spheres_that_a_program_adds_have_the_same_bits() {
    let side = 0.05;
    let model = || GrainModel {
        spheres: Spheres {
            positions: vec![[0.001, 0.02, 0.02], [0.03, 0.02, 0.02]],
            radii: vec![0.005; 2],
            ..Spheres::default()
        },
        domain: Some(cube(side)),
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces { friction: 0.4, restitution: 0.8, ..Surfaces::smooth([0, 0]) }],
        step: Some(1e-5),
        ..GrainModel::default()
    };
    let shot = Spheres {
        positions: vec![[0.0155, 0.021, 0.02], [0.041, 0.02, 0.021]],
        radii: vec![0.004; 2],
        velocities: vec![[2.0, 0.0, 0.0]; 2],
        ..Spheres::default()
    };
    let finished = |threads: usize, stop: bool| {
        let mut run = GrainRun::new(model(), threads).expect("a model");
        run.advance(50).expect("steps");
        assert_eq!(run.add(&shot), Ok(2..4));
        if stop {
            let state = postcard::from_bytes(&bytes(&run)).expect("a state");
            run = GrainRun::resume(model(), state, threads).expect("the same model");
        }
        run.advance(4000).expect("steps");
        run
    };
    let whole = finished(1, false);
    // Two impacts, the second across a side that repeats; the spheres of the program had all of the energy.
    let of = whole.energies();
    let mass = 4.0 / 3.0 * std::f64::consts::PI * 0.004_f64.powi(3) * 2500.0;
    assert!((of.external / (2.0 * 0.5 * mass * 4.0) - 1.0).abs() < 1e-12, "{of:?}");
    let rest = of.kinetic + of.rotational + of.elastic + of.dissipated - of.external;
    assert!(rest.abs() < 1e-3 * of.external && of.dissipated > 0.01 * of.external, "{of:?}");
    assert!(whole.velocity(0)[0] > 0.1 && whole.velocity(1)[0] > 0.1, "both are struck");
    for (threads, stop) in [(2, false), (1, true), (2, true)] {
        assert!(bytes(&finished(threads, stop)) == bytes(&whole), "{threads} {stop}");
    }

    let mut run = GrainRun::new(model(), 1).expect("a model");
    let before = bytes(&run);
    let one = |place: [f64; 3]| Spheres { positions: vec![place], radii: vec![0.004], ..Spheres::default() };
    // It overlaps the first sphere of the model across the side.
    assert_eq!(run.add(&one([0.046, 0.02, 0.02])), Err(GrainError::NoRoom { sphere: 0 }));
    let twice = Spheres { positions: vec![[0.02; 3]; 2], radii: vec![0.004; 2], ..Spheres::default() };
    assert_eq!(run.add(&twice), Err(GrainError::NoRoom { sphere: 1 }));
    let small = Spheres { radii: vec![1e-4], ..one([0.02; 3]) };
    let error = run.add(&small).expect_err("a step that is too long").to_string();
    assert!(error.starts_with("sphere 0 of those to add: time step, s, is "), "{error}");
    let unknown = Spheres { materials: vec![3], ..one([0.02; 3]) };
    assert!(matches!(run.add(&unknown), Err(GrainError::Material { material: 3, .. })));
    assert_eq!(run.add(&Spheres::default()), Ok(2..2));
    assert!(bytes(&run) == before);
}

/// Spheres at a side that repeats reach into the region of an insertion at the other side.
#[test]
fn spheres_that_come_in_keep_off_images() {
    let side = 0.1;
    let place = |k: u32| [0.0, 0.02 * f64::from(k % 5) + 0.01, 0.02 * f64::from(k / 5) + 0.01];
    let rain = Insertion {
        name: "rain".to_owned(),
        region: [[0.0; 3], [side; 3]],
        radii: vec![0.004; 150],
        from: 0.0,
        rate: f64::INFINITY,
        velocity: [0.0; 3],
        spin: [0.0; 3],
        material: 0,
        group: 0,
        seed: 3,
    };
    let model = GrainModel {
        spheres: Spheres {
            positions: (0..25).map(place).collect(),
            radii: vec![0.0095; 25],
            ..Spheres::default()
        },
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces::smooth([0, 0])],
        insertions: vec![rain],
        domain: Some(cube(side)),
        ..GrainModel::default()
    };
    let mut run = GrainRun::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    assert_eq!(run.count(), 175);
    for later in 25..175 {
        for first in 0..later {
            let reach = if first < 25 { 0.0135 } else { 0.008 };
            let square: f64 = (0..3)
                .map(|axis| {
                    let apart = (run.position(later)[axis] - run.position(first)[axis]).abs();
                    apart.min(side - apart).powi(2)
                })
                .sum();
            assert!(square.sqrt() > reach - 1e-9, "{first} {later}");
        }
    }
}

#[test]
fn wrong_insertions_are_refused() {
    let rain = Insertion {
        name: "rain".to_owned(),
        region: [[0.0; 3], [1.0; 3]],
        radii: vec![0.1],
        from: 0.0,
        rate: 1.0,
        velocity: [0.0; 3],
        spin: [0.0; 3],
        material: 0,
        group: 0,
        seed: 1,
    };
    let error = |rain: Insertion| {
        let model = GrainModel { insertions: vec![rain], ..tube(1) };
        model.check().expect_err("it is wrong").to_string()
    };
    assert!(error(Insertion { rate: 0.0, ..rain.clone() }).contains("rate"));
    assert!(error(Insertion { material: 7, ..rain.clone() }).contains("insertion rain"));
    assert!(error(Insertion { radii: vec![0.6], ..rain.clone() }).contains("extent of its region"));
    assert!(error(Insertion { from: f64::NAN, ..rain }).contains("time of its beginning"));
    let hole = Removal { name: "hole".to_owned(), region: [[0.0; 3], [1.0; 3]], times: [2.0, 1.0] };
    let model = GrainModel { removals: vec![hole], ..tube(1) };
    assert!(model.check().expect_err("it ends before it begins").to_string().contains("removal hole"));
}
