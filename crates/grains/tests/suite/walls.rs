use crate::common::*;
use fdem_grains::*;

/// Spheres in a box of walls, with a floor of triangles and a lid.
fn bed(lid: Wall) -> GrainModel {
    let of = material(5e7, 0.3, 2500.0);
    let mut spheres = Spheres::default();
    for k in 0..200_u32 {
        let [i, j, layer] = [k % 5, k / 5 % 5, k / 25];
        let shift = 0.001 * f64::from(k * 7 % 11) / 11.0;
        let place = |n: u32| 0.0105 + 0.0215 * f64::from(n);
        spheres.positions.push([place(i) + shift, place(j) - shift + 0.001, place(layer) + shift]);
        spheres.radii.push(0.009 + 0.001 * f64::from(k * 13 % 17) / 17.0);
    }
    let side = |point: [f64; 3], normal: [f64; 3]| Wall::plane(point, normal, 0);
    let size = 0.109;
    let corners = [[0.0, 0.0, 0.0], [size, 0.0, 0.0], [size, size, 0.0], [0.0, size, 0.0]];
    let middle = [0.6 * size, 0.45 * size, 0.0];
    let triangles = (0..4).map(|k| [corners[k], corners[(k + 1) % 4], middle]).collect();
    let walls = vec![
        Wall { shape: WallShape::Mesh { triangles }, ..side([0.0; 3], [0.0, 0.0, 1.0]) },
        side([0.0; 3], [1.0, 0.0, 0.0]),
        side([size, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        side([0.0; 3], [0.0, 1.0, 0.0]),
        side([0.0, size, 0.0], [0.0, -1.0, 0.0]),
        lid,
    ];
    GrainModel {
        spheres,
        walls,
        materials: vec![of],
        surfaces: vec![Surfaces { restitution: 0.3, friction: 0.3, ..Surfaces::smooth([0, 0]) }],
        gravity: [0.0, 0.0, -9.81],
        ..GrainModel::default()
    }
}

fn servo(force: f64) -> Wall {
    let servo = Servo { direction: [0.0, 0.0, -2.0], force, speed: 1.0 };
    Wall { servo: Some(servo), ..Wall::plane([0.0, 0.0, 0.18], [0.0, 0.0, -1.0], 0) }
}

/// A lid presses on a bed with its force: loose or stiff, light or heavy.
#[test]
fn a_servo_keeps_up_its_force() {
    for force in [20.0, 1000.0] {
        let mut model = bed(servo(force));
        model.step = Some(2e-5);
        let mut run = GrainRun::new(model, 1).expect("a model");
        let steps = (0.4 / run.time_step()) as u64;
        run.advance(steps).expect("steps");
        let mut worst = 0.0_f64;
        for _ in 0..50 {
            run.advance(10).expect("steps");
            worst = worst.max((run.wall_force(5)[2] / force - 1.0).abs());
        }
        assert!(worst < 0.01, "{force} {worst}");
        let floor = -run.wall_force(0)[2];
        assert!(floor > 0.3 * force, "{floor} {force}");
    }
}

/// Threads and saved states change no bit, with meshes and a servo.
#[test]
fn threads_and_states_do_not_change_a_bed() {
    let mut once = GrainRun::new(bed(servo(500.0)), 1).expect("a model");
    once.advance(3000).expect("steps");
    let mut first = GrainRun::new(bed(servo(500.0)), 3).expect("a model");
    first.advance(2345).expect("steps");
    let saved = postcard::to_allocvec(&first.state()).expect("bytes");
    let state = postcard::from_bytes(&saved).expect("a state");
    let mut second = GrainRun::resume(bed(servo(500.0)), state, 2).expect("a run");
    second.advance(655).expect("steps");
    assert_eq!(once.state(), second.state());
    assert!(once.wall_force(5)[2] > 0.0 && once.wall_force(0)[2] < 0.0);
}

/// The energies of a bed on a floor of triangles that turns and moves, under a lid with a servo, balance.
#[test]
fn the_work_of_meshes_and_servos_is_in_the_balance() {
    let mut model = bed(servo(50.0));
    model.surfaces[0] = Surfaces {
        restitution: 0.5,
        friction: 0.5,
        rolling_friction: 0.05,
        rolling_damping: 0.3,
        twisting_friction: 0.02,
        ..model.surfaces[0]
    };
    model.walls[0].velocity = [0.3, 0.0, 0.05];
    model.walls[0].rotation = Some(WallRotation { through: [0.05, 0.05, 0.0], spin: [0.0, 0.0, 5.0] });
    model.step = Some(1e-5);
    let mut run = GrainRun::new(model, 1).expect("a model");
    let total =
        |of: GrainEnergies| of.kinetic + of.rotational + of.elastic + of.weight + of.dissipated - of.external;
    let first = run.energies();
    let mut worst = 0.0_f64;
    for _ in 0..100 {
        run.advance(100).expect("steps");
        worst = worst.max((total(run.energies()) - total(first)).abs());
    }
    let last = run.energies();
    let exchanged = (last.weight - first.weight).abs() + last.external.abs() + last.dissipated;
    assert!(last.external.abs() > 0.01 && worst < 1e-3 * exchanged, "{worst:e} {exchanged:e} {last:?}");
}

/// A wall is where its path is, and pushes with the velocity of the path.
#[test]
fn a_wall_follows_its_path() {
    let of = material(1e8, 0.3, 2500.0);
    let mut model = on_plane(0.01, [0.0; 3], [0.0; 3], [of, of]);
    model.spheres.positions[0][2] = 0.0101;
    model.walls[0].path = vec![(0.001, [0.0; 3]), (0.003, [0.0, 0.0, 0.002]), (0.004, [0.0, 0.0, 0.001])];
    model.step = Some(1e-6);
    let mut run = GrainRun::new(model, 1).expect("a model");
    let height = |run: &GrainRun| match run.columns().walls[0].shape {
        WallShape::Plane { point, .. } => point[2],
        _ => f64::NAN,
    };
    for (time, expected) in [(0.0005, 0.0), (0.002, 0.001), (0.0035, 0.0015), (0.0045, 0.001)] {
        run.advance(((time - run.time()) / 1e-6).round() as u64).expect("steps");
        // The walls are those of the last step.
        assert!((height(&run) - expected).abs() < 1.001e-6, "{time} {}", height(&run));
    }
    // Struck by a plane of 1 m/s, without damping.
    assert!((run.velocity(0)[2] - 2.0).abs() < 1e-4, "{:?}", run.velocity(0));
}

/// Spheres rest in a cone, on a disc, and on its rim.
#[test]
fn cones_and_discs_bear_spheres() {
    let of = material(1e8, 0.3, 2500.0);
    let weight = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6 * 9.81;
    let cone = WallShape::Cone { axis: [[0.0; 3], [0.0, 0.0, 0.1]], radii: [0.0, 0.1] };
    let disc = WallShape::Disc { centre: [0.0; 3], normal: [0.0, 0.0, 3.0], radius: 0.03 };
    for (shape, start, gravity) in [
        (cone.clone(), [0.02, 0.0, 0.02 + 0.0141], [0.0, 0.0, -9.81]),
        // From outside.
        (cone, [0.05, 0.0, 0.05 - 0.0142], [-9.81, 0.0, 9.81]),
        (disc.clone(), [0.01, 0.0, 0.01], [0.0, 0.0, -9.81]),
        (disc.clone(), [0.01, 0.01, -0.01], [0.0, 0.0, 9.81]),
        (disc, [0.0, 0.04, 0.0], [0.0, -9.81, 0.0]),
    ] {
        let mut model = on_plane(0.01, [0.0; 3], [0.0; 3], [of, of]);
        model.walls[0].shape = shape.clone();
        model.spheres.positions[0] = start;
        model.gravity = gravity;
        model.surfaces[0] =
            Surfaces { restitution: 0.2, friction: 1.2, rolling_friction: 1.1, ..Surfaces::smooth([0, 1]) };
        let mut run = GrainRun::new(model, 1).expect("a model");
        run.advance((0.05 / run.time_step()) as u64).expect("steps");
        let force = run.wall_force(0);
        for axis in 0..3 {
            let expected = weight * gravity[axis] / 9.81;
            assert!((force[axis] - expected).abs() < 0.05 * weight, "{shape:?} {force:?} {expected}");
        }
    }
}

/// Each wall that is wrong is named.
#[test]
fn wrong_walls_are_refused() {
    let of = material(1e8, 0.3, 2500.0);
    let refused = |change: &dyn Fn(&mut Wall)| {
        let mut model = on_plane(0.01, [0.0; 3], [0.0; 3], [of, of]);
        change(&mut model.walls[0]);
        model.check().expect_err("a wrong wall").to_string()
    };
    let axis = [[0.0; 3], [0.0, 0.0, 1.0]];
    let shape = |shape: WallShape| refused(&|wall: &mut Wall| wall.shape = shape.clone());
    assert!(shape(WallShape::Cone { axis, radii: [0.0, 0.0] }).starts_with("wall 0: larger radius"));
    assert!(shape(WallShape::Cone { axis, radii: [-1.0, 1.0] }).starts_with("wall 0: radius"));
    assert!(shape(WallShape::Mesh { triangles: Vec::new() }).starts_with("wall 0: number of triangles"));
    let triangles = vec![[[0.0; 3], [f64::NAN; 3], [1.0; 3]]];
    assert!(shape(WallShape::Mesh { triangles }).starts_with("wall 0: a coordinate"));
    let disc = WallShape::Disc { centre: [0.0; 3], normal: [0.0; 3], radius: 1.0 };
    assert!(shape(disc).starts_with("wall 0: length of its direction"));
    let path = refused(&|wall: &mut Wall| {
        wall.name = "jaw".to_owned();
        wall.path = vec![(1.0, [0.0; 3]), (1.0, [0.0; 3])];
    });
    assert!(path.starts_with("wall jaw: time of its path"), "{path}");
    let servo = refused(&|wall: &mut Wall| {
        wall.servo = Some(Servo { direction: [0.0, 0.0, 1.0], force: 1.0, speed: 0.0 });
    });
    assert!(servo.starts_with("wall 0: speed of its servo"), "{servo}");
}
