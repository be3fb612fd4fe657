use crate::common::*;
use fdem_grains::*;

/// A sphere that is a clump of its own moves as it does alone.
#[test]
fn a_clump_of_one_sphere_is_a_sphere() {
    let of = material(1e8, 0.3, 2500.0);
    let mut model = on_plane(0.01, [0.0; 3], [0.0; 3], [of, of]);
    model.spheres.positions[0][2] = 0.012;
    model.surfaces[0] = Surfaces {
        friction: 0.4,
        restitution: 0.6,
        rolling_friction: 0.05,
        rolling_damping: 0.3,
        twisting_friction: 0.1,
        ..Surfaces::smooth([0, 1])
    };
    model.gravity = [0.0, 0.0, -9.81];
    let (velocity, spin) = ([0.3, -0.2, -0.5], [20.0, 5.0, -30.0]);
    let mut clumped = model.clone();
    clumped.spheres.velocities.clear();
    clumped.spheres.spins.clear();
    clumped.clumps = vec![Clump { spheres: vec![0], velocity, spin, inertia: None }];
    (model.spheres.velocities, model.spheres.spins) = (vec![velocity], vec![spin]);
    model.step = Some(model.safe_step());
    clumped.step = model.step;
    let mut runs = [model, clumped].map(|model| GrainRun::new(model, 1).expect("a model"));
    let mut touched = 0;
    for _ in 0..1000 {
        for run in &mut runs {
            run.advance(8).expect("steps");
        }
        let [sphere, clump] = &runs;
        touched += usize::from(sphere.wall_force(0) != [0.0; 3]);
        let near = |a: [f64; 3], b: [f64; 3], bound: f64| (0..3).all(|k| (a[k] - b[k]).abs() < bound);
        assert!(near(sphere.position(0), clump.position(0), 1e-10), "{:?}", clump.position(0));
        assert!(near(sphere.velocity(0), clump.velocity(0), 1e-8), "{:?}", clump.velocity(0));
        assert!(near(sphere.spin(0), clump.spin(0), 1e-6), "{:?} {:?}", sphere.spin(0), clump.spin(0));
        let [one, two] = [sphere.energies(), clump.energies()];
        assert!((one.rotational / two.rotational - 1.0).abs() < 1e-6, "{one:?} {two:?}");
        assert!((one.kinetic - two.kinetic).abs() < 1e-8 * one.kinetic.max(1e-6), "{one:?} {two:?}");
    }
    assert!(touched > 10, "{touched}");
}

/// A dumbbell meets a smooth plane with one end: the velocities after it are those of a rigid body.
#[test]
fn an_impact_at_one_end_turns_a_dumbbell() {
    let of = material(1e9, 0.3, 2500.0);
    let (radius, half, speed) = (0.01, 0.02, 1.0);
    for (degrees, restitution) in [(30.0, 1.0), (30.0, 0.5), (60.0, 0.8)] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let mut model = on_plane(radius, [0.0; 3], [0.0; 3], [of, of]);
        model.spheres = Spheres {
            positions: vec![[0.0, 0.0, radius], [2.0 * half * cos, 0.0, radius + 2.0 * half * sin]],
            radii: vec![radius; 2],
            ..Spheres::default()
        };
        model.surfaces = vec![Surfaces { restitution, ..Surfaces::smooth([0, 1]) }];
        model.surfaces.push(Surfaces::smooth([0, 0]));
        model.clumps = vec![Clump { spheres: vec![0, 1], velocity: [0.0, 0.0, -speed], ..Clump::default() }];
        model.step = Some(1e-7);
        let mass = 2500.0 * 8.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let inertia = mass * (0.4 * radius * radius + half * half);
        let (mut run, mut energy) = (GrainRun::new(model, 1).expect("a model"), 0.0_f64);
        let before = run.energies();
        run.advance(2).expect("steps");
        while run.wall_force(0) != [0.0; 3] {
            run.advance(1).expect("a step");
            let now = run.energies();
            let sum = now.kinetic + now.rotational + now.elastic + now.dissipated;
            energy = energy.max((sum / before.kinetic - 1.0).abs());
        }
        assert!(energy < 1e-4, "{energy}");
        // The impulse along the normal, at the arm to the end.
        let arm = half * cos;
        let at_end = |run: &GrainRun| run.velocity(0)[2];
        let kick = at_end(&run) + speed;
        let impulse = kick / (1.0 / mass + arm * arm / inertia);
        let spin = -impulse * -arm / inertia;
        assert!((run.spin(0)[1] / spin - 1.0).abs() < 1e-2, "{degrees} {:?} {spin}", run.spin(0));
        let centre = 0.5 * (run.velocity(0)[2] + run.velocity(1)[2]);
        assert!((centre - (impulse / mass - speed)).abs() < 1e-2 * speed, "{centre}");
        assert_eq!(run.spin(0), run.spin(1));
        if restitution == 1.0 {
            assert!((at_end(&run) / speed - 1.0).abs() < 1e-2, "{}", at_end(&run));
        }
    }
}

/// Rods of two and three spheres fall into a tube.
fn rods(count: usize) -> GrainModel {
    let (radius, side) = (0.004, 0.018);
    let (mut spheres, mut clumps) = (Spheres::default(), Vec::new());
    for rod in 0..count {
        let [i, j, l] = [rod % 3, (rod / 3) % 3, rod / 9].map(|x| x as f64);
        let angle = (rod * 7919 % 31) as f64;
        let (sin, cos) = angle.sin_cos();
        let along = [0.8 * cos, 0.8 * sin, 0.6];
        let centre = [(i - 1.0) * side, (j - 1.0) * side, 0.012 + 0.0135 * l];
        let members = 2 + rod % 2;
        let first = spheres.positions.len() as u32;
        for member in 0..members {
            let shift = (member as f64 - 0.5 * (members as f64 - 1.0)) * radius;
            spheres.positions.push([0, 1, 2].map(|k| centre[k] + shift * along[k]));
            spheres.radii.push(radius);
        }
        clumps.push(Clump {
            spheres: (first..first + members as u32).collect(),
            velocity: [0.0, 0.0, -0.5],
            ..Clump::default()
        });
    }
    GrainModel {
        spheres,
        clumps,
        walls: vec![
            Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0),
            Wall {
                shape: WallShape::Tube { axis: [[0.0; 3], [0.0, 0.0, 1.0]], radius: 0.035 },
                ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)
            },
        ],
        materials: vec![material(1e7, 0.25, 2500.0)],
        surfaces: vec![Surfaces { friction: 0.5, restitution: 0.5, ..Surfaces::smooth([0, 0]) }],
        gravity: [0.0, 0.0, -9.81],
        ..GrainModel::default()
    }
}

/// The balance of energy, and the members that stay where they are in their rods.
#[test]
fn rods_that_fall_into_a_tube_keep_the_balance_of_energy() {
    let mut model = rods(54);
    // The error falls with the square of the step: it is 2e-3 with the whole one.
    model.step = Some(0.5 * model.safe_step());
    let mut run = GrainRun::new(model.clone(), 2).expect("a model");
    let all =
        |of: GrainEnergies| of.kinetic + of.rotational + of.elastic + of.weight + of.dissipated - of.external;
    let (begin, mut most, mut fastest) = (run.energies(), 0.0_f64, 0.0_f64);
    for _ in 0..150 {
        run.advance((0.003 / run.time_step()) as u64).expect("steps");
        let now = run.energies();
        most = most.max((all(now) - all(begin)).abs());
        fastest = fastest.max(now.rotational);
    }
    let end = run.energies();
    let exchanged = begin.weight - end.weight + begin.kinetic;
    assert!(most < 1e-3 * exchanged, "{most} {exchanged} {end:?}");
    assert!(end.dissipated > 0.9 * exchanged && fastest > 0.01 * begin.kinetic, "{end:?} {fastest}");
    for clump in &model.clumps {
        for pair in clump.spheres.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|sphere| run.position(sphere as usize));
            let length = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            assert!((length / 0.004 - 1.0).abs() < 1e-9, "{length}");
        }
    }
    // The weight of all rods is on the walls.
    let mass: f64 = run.columns().masses.iter().sum();
    let weight = run.wall_force(0)[2] + run.wall_force(1)[2];
    assert!((weight / (-9.81 * mass) - 1.0).abs() < 2e-2, "{weight} {mass}");
    let alone = 4.0 / 3.0 * std::f64::consts::PI * 0.004_f64.powi(3) * 2500.0;
    // Two spheres a radius apart have 27/16 of the volume of one, and three 38/16.
    let expected = alone * 27.0 * (27.0 / 16.0 + 38.0 / 16.0);
    assert!((mass / expected - 1.0).abs() < 1e-4, "{mass} {expected}");
}

#[test]
fn threads_and_states_change_no_bit_of_clumps() {
    let bytes = |run: &GrainRun| postcard::to_allocvec(&run.state()).expect("bytes");
    let mut whole = GrainRun::new(rods(120), 1).expect("a model");
    whole.advance(3000).expect("steps");
    let saved = bytes(&whole);
    whole.advance(1000).expect("steps");
    assert!(whole.contacts().len() > 50, "{}", whole.contacts().len());
    for threads in [1, 3] {
        let state = postcard::from_bytes(&saved).expect("a state");
        let mut resumed = GrainRun::resume(rods(120), state, threads).expect("the same model");
        resumed.advance(1000).expect("steps");
        assert!(bytes(&resumed) == bytes(&whole), "{threads}");
    }
    let state = postcard::from_bytes(&saved).expect("a state");
    let other = GrainRun::resume(rods(119), state, 1).expect_err("another model");
    assert_eq!(other.to_string(), "120 clumps instead of 119");
}

/// A held clump turns about its centre and pushes others; a box removes a clump as a whole.
#[test]
fn clumps_are_held_and_removed_as_a_whole() {
    let mut model = rods(3);
    model.walls.clear();
    model.gravity = [0.0; 3];
    model.spheres.held = vec![false; model.spheres.positions.len()];
    model.clumps[0].spheres.iter().for_each(|&sphere| model.spheres.held[sphere as usize] = true);
    (model.clumps[0].velocity, model.clumps[0].spin) = ([0.0; 3], [0.0, 0.0, 100.0]);
    // The second rod has three spheres: the box takes one of them in.
    let end = model.spheres.positions[2];
    model.clumps[1].velocity = [0.0; 3];
    let region = [end.map(|x| x - 1e-4), end.map(|x| x + 1e-4)];
    model.removals = vec![Removal { name: String::new(), region, times: [1e-3, 1.0] }];
    let begin = model.spheres.positions.clone();
    let mut run = GrainRun::new(model, 1).expect("a model");
    let total = |of: GrainEnergies| of.kinetic + of.rotational - of.external;
    let energy = total(run.energies());
    let steps = (0.02 / run.time_step()) as u64;
    run.advance(steps).expect("steps");
    assert_eq!(run.columns().numbers, [0, 1, 5, 6]);
    let angle = 100.0 * run.time();
    let arm = [0, 1].map(|k| 0.5 * (begin[1][k] - begin[0][k]));
    let turned = [arm[0] * angle.cos() - arm[1] * angle.sin(), arm[0] * angle.sin() + arm[1] * angle.cos()];
    for k in 0..2 {
        let centre = 0.5 * (begin[0][k] + begin[1][k]);
        assert!((run.position(1)[k] - centre - turned[k]).abs() < 1e-12, "{:?}", run.position(1));
    }
    assert!((total(run.energies()) / energy - 1.0).abs() < 1e-9, "{:?}", run.energies());
}

#[test]
fn wrong_clumps_are_refused() {
    let refused = |change: fn(&mut GrainModel)| {
        let mut model = rods(4);
        change(&mut model);
        GrainRun::new(model, 1).expect_err("refused").to_string()
    };
    assert_eq!(refused(|of| of.clumps[2].spheres.clear()), "clump 2: it has no spheres");
    assert_eq!(
        refused(|of| of.clumps[1].spheres = vec![3, 2]),
        "clump 1: the numbers of its spheres do not ascend"
    );
    assert_eq!(
        refused(|of| of.clumps[1].spheres = vec![2, 40]),
        "clump 1: one of its spheres does not exist"
    );
    assert_eq!(
        refused(|of| of.clumps[1].spheres = vec![0, 2]),
        "clump 1: one of its spheres belongs to another clump"
    );
    assert!(refused(|of| of.spheres.velocities = vec![[1.0; 3]; 10]).contains("give it to the clump"));
    // The last one of ten spheres.
    assert_eq!(
        refused(|of| of.spheres.held = (0..10).map(|sphere| sphere < 9).collect()),
        "clump 3: some of its spheres are held, and others are not"
    );
    assert_eq!(
        refused(|of| {
            let moments = [[-1.0; 3]; 3];
            of.clumps[0].inertia = Some(ClumpInertia { mass: 1.0, centre: [0.0; 3], moments });
        }),
        "clump 0: its moments of inertia are not those of a body"
    );
}
