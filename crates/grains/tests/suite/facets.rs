use crate::common::*;
use fdem_grains::*;

type Vector = [f64; 3];

/// Numbers from -1 to 1, the same in each run.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn direction(&mut self) -> Vector {
        loop {
            let vector = [self.number(), self.number(), self.number()];
            let size = dot(vector, vector).sqrt();
            if size > 0.1 && size < 1.0 {
                return vector.map(|x| x / size);
            }
        }
    }
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn plus(a: Vector, factor: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|k| a[k] + factor * b[k])
}

/// Points with their velocities, facets and one material.
#[derive(Clone)]
struct Body {
    points: Vec<Vector>,
    velocities: Vec<Vector>,
    facets: Vec<[u32; 3]>,
    material: u32,
}

impl Body {
    fn at_rest(points: Vec<Vector>, facets: Vec<[u32; 3]>) -> Self {
        Self { velocities: vec![[0.0; 3]; points.len()], points, facets, material: 1 }
    }

    fn step(&self, run: &mut GrainRun) {
        let materials = vec![self.material; self.facets.len()];
        let Self { points, velocities, facets, .. } = self;
        let surface = Surface { points, velocities, facets, materials: &materials };
        run.step_on(&surface).expect("a step");
    }

    fn triangles(&self) -> Vec<[Vector; 3]> {
        self.facets.iter().map(|facet| facet.map(|p| self.points[p as usize])).collect()
    }

    /// The same surface with other numbers of points and facets, and other first corners.
    fn renumbered(&self, random: &mut Random) -> Self {
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        let mut shuffle = |list: &mut Vec<usize>| {
            for k in (1..list.len()).rev() {
                let other = ((random.number() * 0.5 + 0.5) * (k + 1) as f64) as usize;
                list.swap(k, other.min(k));
            }
        };
        shuffle(&mut order);
        let mut number = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            number[old] = new as u32;
        }
        let mut facets: Vec<usize> = (0..self.facets.len()).collect();
        shuffle(&mut facets);
        let facet = |old: &usize| {
            let mut facet = self.facets[*old].map(|p| number[p as usize]);
            facet.rotate_left(old % 3);
            facet
        };
        Self {
            points: order.iter().map(|&old| self.points[old]).collect(),
            velocities: order.iter().map(|&old| self.velocities[old]).collect(),
            facets: facets.iter().map(facet).collect(),
            material: self.material,
        }
    }
}

/// A rectangle of cells with irregular points and diagonals at a height, seen from above.
fn sheet(cells: i32, size: f64, height: impl Fn(f64, f64) -> f64, random: &mut Random) -> Body {
    let (mut points, mut facets) = (Vec::new(), Vec::new());
    for i in 0..=cells {
        for j in 0..=cells {
            let inside = |k: i32| if k == 0 || k == cells { 0.0 } else { 0.3 };
            let [x, y] = [i, j].map(|k| f64::from(k) + inside(k) * random.number());
            let [x, y] = [x, y].map(|x| (x / f64::from(cells) - 0.5) * size);
            points.push([x, y, height(x, y)]);
        }
    }
    for i in 0..cells {
        for j in 0..cells {
            let at = |i: i32, j: i32| (i * (cells + 1) + j) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let other = random.number() > 0.0;
            facets.extend(if other { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    Body::at_rest(points, facets)
}

/// A box about the origin.
fn block(half: Vector) -> Body {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] });
    let facets = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    Body::at_rest((0..8).map(corner).collect(), facets)
}

fn sphere(radius: f64, position: Vector, velocity: Vector, surfaces: Surfaces) -> GrainModel {
    let of = material(1e8, 0.3, 2000.0);
    GrainModel {
        spheres: Spheres {
            positions: vec![position],
            radii: vec![radius],
            velocities: vec![velocity],
            ..Spheres::default()
        },
        materials: vec![of, of],
        surfaces: vec![surfaces],
        ..GrainModel::default()
    }
}

fn rough() -> Surfaces {
    Surfaces {
        restitution: 0.6,
        friction: 0.4,
        rolling_friction: 0.05,
        rolling_damping: 0.3,
        twisting_friction: 0.05,
        ..Surfaces::smooth([0, 1])
    }
}

fn mesh(triangles: Vec<[Vector; 3]>) -> Wall {
    Wall { shape: WallShape::Mesh { triangles }, ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 1) }
}

/// A sphere slides, rolls and spins over triangles of one plane as over the plane, as a wall's mesh and as
/// the surface of a body.
#[test]
fn triangles_of_one_plane_are_a_plane() {
    let mut model = sphere(0.01, [-0.03, 0.004, 0.00999], [1.5, 0.4, -0.1], rough());
    model.spheres.spins = vec![[20.0, -60.0, 200.0]];
    model.gravity = [0.0, 0.0, -9.81];
    model.step = Some(1e-5);
    let body = sheet(40, 0.2, |_, _| 0.0, &mut Random(5));
    let with = |wall: Option<Wall>| {
        let model = GrainModel { walls: wall.into_iter().collect(), ..model.clone() };
        GrainRun::new(model, 1).expect("a model")
    };
    let mut runs = [
        with(Some(Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 1))),
        with(Some(mesh(body.triangles()))),
        with(None),
    ];
    for step in 0..4000 {
        let [plane, on_mesh, on_body] = &mut runs;
        plane.advance(1).expect("a step");
        on_mesh.advance(1).expect("a step");
        body.step(on_body);
        for other in [on_mesh, on_body] {
            for axis in 0..3 {
                let position = other.position(0)[axis] - plane.position(0)[axis];
                let spin = other.spin(0)[axis] - plane.spin(0)[axis];
                assert!(position.abs() < 1e-12 && spin.abs() < 1e-8, "{step} {position:e} {spin:e}");
            }
        }
    }
    assert!(runs[0].position(0)[0] > 0.01, "{:?}", runs[0].position(0));
}

/// A sphere that sticks to triangles of one plane moves as on a plane: it comes to rest and hangs on.
#[test]
fn a_sphere_sticks_to_triangles_as_to_a_plane() {
    let corner = |x: f64, y: f64| [0.05 * x, 0.05 * y, 0.0];
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let model = |wall: Wall, pull: f64| GrainModel {
        spheres: Spheres {
            positions: vec![[0.012, 0.003, 0.00999]],
            radii: vec![0.01],
            velocities: vec![[0.05, 0.02, -0.01]],
            ..Spheres::default()
        },
        walls: vec![wall],
        materials: vec![material(5e6, 0.25, 2500.0)],
        surfaces: vec![Surfaces {
            adhesion: 5.0,
            friction: 0.4,
            restitution: 0.6,
            ..Surfaces::smooth([0, 0])
        }],
        gravity: [0.0, 0.0, pull],
        step: Some(5e-6),
        ..GrainModel::default()
    };
    let plane = Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0);
    let triangles = WallShape::Mesh { triangles: vec![[a, b, c], [a, c, d]] };
    for pull in [-9.81, 0.0] {
        let [on_plane, on_mesh] =
            [plane.clone(), Wall { shape: triangles.clone(), ..plane.clone() }].map(|wall| {
                let mut run = GrainRun::new(model(wall, pull), 1).expect("a model");
                run.advance(20_000).expect("steps");
                run
            });
        assert_eq!(on_plane.contacts().len(), 1, "it sticks");
        let [one, other] = [on_plane.position(0), on_mesh.position(0)];
        assert!((0..3).all(|k| (one[k] - other[k]).abs() < 1e-9), "{one:?} {other:?}");
        let [one, other] = [on_plane.wall_force(0), on_mesh.wall_force(0)];
        assert!((0..3).all(|k| (one[k] - other[k]).abs() < 1e-6), "{one:?} {other:?}");
    }
}

/// Speed after an impact over that before, without damping and friction, and the largest number of contacts.
fn restored(model: GrainModel, body: &Body) -> (f64, usize) {
    let speed = dot(model.spheres.velocities[0], model.spheres.velocities[0]).sqrt();
    let mut run = GrainRun::new(model, 1).expect("a model");
    let mut most = 0;
    for step in 0..100_000 {
        body.step(&mut run);
        let contacts = run.contacts().len();
        assert!(step > 0 || contacts == 0);
        most = most.max(contacts);
        if most > 0 && contacts == 0 {
            break;
        }
    }
    assert!(most > 0);
    (dot(run.velocity(0), run.velocity(0)).sqrt() / speed, most)
}

/// Faces, edges and vertices of a block return the energy of an impact.
#[test]
fn impacts_on_a_block_keep_the_energy() {
    let mut random = Random(11);
    let body = block([0.02, 0.03, 0.01]);
    let mut worst = 0.0_f64;
    for _ in 0..40 {
        // Towards a point of the surface of the block, at or near its edges and vertices in part.
        let mut target = [0.02, 0.03, 0.01].map(|half| half * (1.3 * random.number()).clamp(-1.0, 1.0));
        let (axis, side) = ((random.number().abs() * 3.0) as usize % 3, random.number().signum());
        target[axis] = [0.02, 0.03, 0.01][axis] * side;
        let outwards = random.direction();
        let outwards =
            [0, 1, 2].map(|k| if target[k] * outwards[k] < 0.0 { -outwards[k] } else { outwards[k] });
        // Not along the face.
        let mut outwards = outwards;
        outwards[axis] = side * outwards[axis].abs().max(0.6);
        let size = dot(outwards, outwards).sqrt();
        let outwards = outwards.map(|x| x / size);
        let position = plus(target, 0.023, outwards);
        let mut model = sphere(0.01, position, outwards.map(|x| -2.0 * x), Surfaces::smooth([0, 1]));
        model.step = Some(8e-7);
        worst = worst.max((restored(model, &body).0 - 1.0).abs());
    }
    assert!(worst < 1e-6, "{worst:e}");
}

/// So do grooves, pits and rough ground.
#[test]
fn impacts_in_hollows_keep_the_energy() {
    let mut random = Random(23);
    let (mut worst, mut most) = (0.0_f64, 0);
    for k in 0..24 {
        let slope = [0.02, 0.1, 0.4, 0.8][k % 4];
        let ground = match k % 3 {
            0 => sheet(2, 0.1, |x, _| slope * x.abs(), &mut random),
            1 => sheet(2, 0.1, |x, y| slope * x.abs().max(y.abs()), &mut random),
            _ => {
                let mut other = Random(k as u64);
                let heights: Vec<f64> = (0..400).map(|_| other.number()).collect();
                let at =
                    |x: f64, y: f64| ((x + 0.02) * 1000.0) as usize * 19 + ((y + 0.02) * 1000.0) as usize;
                sheet(40, 0.04, |x, y| 0.0005 * slope * heights[at(x, y) % 400], &mut random)
            }
        };
        let [x, y] = [0.002 * random.number(), 0.002 * random.number()];
        let velocity = [0.5 * random.number(), 0.5 * random.number(), -2.0];
        let mut model = sphere(0.01, [x, y, 0.0], velocity, Surfaces::smooth([0, 1]));
        model.spheres.positions[0][2] = 0.014 + 0.03 * slope;
        model.step = Some(8e-7);
        let (kept, contacts) = restored(model, &ground);
        worst = worst.max((kept - 1.0).abs());
        most = most.max(contacts);
    }
    assert!(worst < 1e-6 && most > 3, "{worst:e} {most}");
}

/// A body whose points move under the forces of a sphere: its momentum and angular momentum, and those of the
/// sphere, add up to the same. Numbers that change in every step change no bit.
#[test]
fn momentum_is_kept_and_numbers_do_not_matter() {
    let mut random = Random(3);
    let mut model = sphere(0.01, [0.012, 0.021, 0.0225], [-0.7, -0.6, -1.5], rough());
    model.spheres.spins = vec![[50.0, 30.0, -80.0]];
    model.step = Some(2e-6);
    let point_mass = 0.004;
    let mass = 2000.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    let sums = |run: &GrainRun, body: &Body| {
        let velocity = run.velocity(0);
        let mut momentum = velocity.map(|v| mass * v);
        let spin = run.spin(0).map(|w| 0.4 * mass * 1e-4 * w);
        // Forces act at the positions, half a step after the velocities: moments of momentum are taken there.
        let mut angular = plus(spin, 1.0, cross(run.position(0), momentum));
        for (point, velocity) in body.points.iter().zip(&body.velocities) {
            momentum = plus(momentum, point_mass, *velocity);
            angular = plus(angular, point_mass, cross(*point, *velocity));
        }
        (momentum, angular)
    };
    let mut results = Vec::new();
    for renumbers in [false, true] {
        let mut run = GrainRun::new(model.clone(), 1).expect("a model");
        let mut body = block([0.02, 0.03, 0.01]);
        let first = sums(&run, &body);
        let mut touched = 0;
        for _ in 0..4000 {
            let dt = run.time_step();
            if renumbers {
                body = body.renumbered(&mut random);
            }
            let [points, velocities] = [body.points.clone(), body.velocities.clone()];
            body.step(&mut run);
            touched += usize::from(!run.surface_forces().is_empty());
            for &(point, force) in run.surface_forces() {
                body.velocities[point as usize] = plus(velocities[point as usize], dt / point_mass, force);
            }
            for (k, point) in body.points.iter_mut().enumerate() {
                *point = plus(points[k], dt, body.velocities[k]);
            }
        }
        let last = sums(&run, &body);
        assert!(touched > 100, "{touched}");
        for axis in 0..3 {
            assert!((first.0[axis] - last.0[axis]).abs() < 1e-13, "{first:?} {last:?}");
            assert!((first.1[axis] - last.1[axis]).abs() < 1e-13, "{first:?} {last:?}");
        }
        results.push((run.position(0), run.velocity(0), run.spin(0)));
    }
    assert_eq!(results[0], results[1]);
}

/// The energy of a sphere that rubs on a block which moves, and the work on its points, add up.
#[test]
fn the_work_on_a_body_is_in_the_balance() {
    let mut model = sphere(0.01, [0.012, 0.021, 0.0225], [-0.7, -0.6, -1.5], rough());
    model.spheres.spins = vec![[50.0, 30.0, -80.0]];
    model.step = Some(1e-6);
    let point_mass = 0.004;
    let mut run = GrainRun::new(model, 1).expect("a model");
    let mut body = block([0.02, 0.03, 0.01]);
    let (mut first, mut last, mut touched) = (f64::NAN, f64::NAN, false);
    let mut largest = 0.0_f64;
    for step in 0..8000 {
        let dt = run.time_step();
        let velocities = body.velocities.clone();
        body.step(&mut run);
        let mut kinetic = 0.0;
        let mut forces = vec![[0.0; 3]; body.points.len()];
        for &(point, force) in run.surface_forces() {
            forces[point as usize] = force;
            touched = true;
        }
        for (k, point) in body.points.iter_mut().enumerate() {
            // The surface had the velocities at the positions: half a step before the next ones.
            body.velocities[k] = plus(velocities[k], dt / point_mass, forces[k]);
            kinetic += 0.5 * point_mass * dot(velocities[k], velocities[k]);
            *point = plus(*point, dt, body.velocities[k]);
        }
        let of = run.energies();
        let total = of.kinetic + of.rotational + of.elastic + of.dissipated + kinetic;
        if step == 0 {
            first = total;
        }
        last = of.kinetic + of.rotational + of.elastic + of.dissipated + of.on_bodies;
        largest = largest.max((last - first).abs());
    }
    assert!(touched && run.energies().on_bodies > 0.0 && last > 0.0);
    assert!(largest < 1e-3 * first, "{largest:e} {first:e}");
}

/// A sphere rolls over the edge of a table and falls; on a thin plate it stays on its side.
#[test]
fn a_sphere_rolls_off_a_table_and_stays_on_its_side_of_a_plate() {
    let mut model =
        sphere(0.01, [0.01, 0.001, 0.02], [0.5, 0.0, 0.0], Surfaces { restitution: 0.3, ..rough() });
    model.surfaces[0].rolling_friction = 0.0;
    model.spheres.spins = vec![[0.0, 50.0, 0.0]];
    model.gravity = [0.0, 0.0, -9.81];
    let mut run = GrainRun::new(model.clone(), 1).expect("a model");
    let table = block([0.03, 0.03, 0.01]);
    let mut turned = 0;
    for _ in 0..(0.15 / run.time_step()) as u64 {
        table.step(&mut run);
        let contacts = run.contacts();
        assert!(contacts.len() <= 1);
        turned += usize::from(contacts.iter().any(|of| of.place[0] == 0.03 && of.force[0] > 0.0));
    }
    assert!(turned > 0 && run.position(0)[2] < 0.0 && run.position(0)[0] > 0.03, "{:?}", run.position(0));

    // A plate that is thinner than the sphere is pressed in.
    let plate = block([0.05, 0.05, 2e-5]);
    for side in [1.0, -1.0] {
        model.gravity = [0.0, 0.0, -50_000.0 * side];
        model.spheres.positions = vec![[0.003, 0.001, 0.00999 * side]];
        model.spheres.velocities = vec![[0.0; 3]];
        model.spheres.spins = vec![[0.0; 3]];
        let mut run = GrainRun::new(model.clone(), 1).expect("a model");
        let mut deepest = 1.0_f64;
        for _ in 0..20_000 {
            plate.step(&mut run);
            deepest = deepest.min(run.position(0)[2] * side);
            assert!(run.contacts().len() <= 1);
        }
        assert!(deepest < 0.01 - 4e-5 && run.position(0)[2] * side > 0.005, "{deepest}");
        let force: Vector = run.surface_forces().iter().fold([0.0; 3], |sum, of| plus(sum, 1.0, of.1));
        let weight = 2000.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6 * 50_000.0;
        assert!((force[2] * side / -weight - 1.0).abs() < 1e-3, "{force:?} {weight}");
    }
}

/// A sphere whose centre is pressed through a surface is pressed back.
#[test]
fn a_sphere_that_is_pressed_beyond_its_radius_comes_back() {
    for two_sided in [false, true] {
        let mut model = sphere(0.01, [0.003, 0.001, 0.011], [0.0, 0.0, -1.0], Surfaces::smooth([0, 1]));
        model.law = ForceLaw::Hooke { normal: 50.0, tangential: 0.3 };
        model.step = Some(2e-6);
        let body = block([0.05, 0.05, 0.04]);
        let body =
            Body { points: body.points.iter().map(|&p| plus(p, 1.0, [0.0, 0.0, -0.04])).collect(), ..body };
        if two_sided {
            model.walls = vec![mesh(body.triangles())];
        }
        let mut run = GrainRun::new(model, 1).expect("a model");
        let mut deepest = 1.0_f64;
        for _ in 0..40_000 {
            if two_sided {
                run.advance(1).expect("a step");
            } else {
                body.step(&mut run);
            }
            deepest = deepest.min(run.position(0)[2]);
        }
        assert!(deepest < -0.001, "{deepest}");
        assert!((run.velocity(0)[2] - 1.0).abs() < 1e-4, "{:?} {deepest}", run.velocity(0));
    }
}

/// Segments in the plane: a sphere rolls over collinear ones as over a plane, and keeps its energy at a
/// corner.
#[test]
fn segments_are_touched_as_triangles_are() {
    let points: Vec<Vector> =
        [-0.06, -0.031, -0.01, 0.0, 0.002, 0.02, 0.04, 0.09].map(|x| [x, 0.0, 0.0]).to_vec();
    // The body is below: on the left of segments that run to the left.
    let facets: Vec<[u32; 3]> = (0..7).map(|k| [k + 1, k, k]).collect();
    let floor = Body::at_rest(points, facets);
    let mut model = sphere(0.01, [-0.03, 0.00999, 0.0], [1.0, -0.1, 0.0], rough());
    model.gravity = [0.0, -9.81, 0.0];
    model.step = Some(1e-5);
    let plane = Wall::plane([0.0; 3], [0.0, 1.0, 0.0], 1);
    let mut on_plane = GrainRun::new(GrainModel { walls: vec![plane], ..model.clone() }, 1).expect("a model");
    let mut run = GrainRun::new(model, 1).expect("a model");
    for _ in 0..4000 {
        on_plane.advance(1).expect("a step");
        floor.step(&mut run);
        for axis in 0..3 {
            assert!((run.position(0)[axis] - on_plane.position(0)[axis]).abs() < 1e-12);
        }
    }
    let corner = Body::at_rest(
        vec![[0.0; 3], [-0.05, -0.03, 0.0], [0.04, -0.05, 0.0]],
        vec![[0, 1, 1], [1, 2, 2], [2, 0, 0]],
    );
    let mut model = sphere(0.01, [0.001, 0.012, 0.0], [0.3, -2.0, 0.0], Surfaces::smooth([0, 1]));
    model.step = Some(4e-7);
    let (kept, _) = restored(model, &corner);
    assert!((kept - 1.0).abs() < 2e-5, "{kept}");
}

/// A sphere rolls and slides in a trough of strips as in the tube around them: friction goes over from strip
/// to strip.
#[test]
fn a_trough_of_strips_is_a_tube() {
    let (radius, strips) = (0.1, 314);
    // As deep as the tube in the mean.
    let turn = std::f64::consts::TAU / f64::from(strips);
    let corner = radius / (1.0 - turn * turn / 12.0).sqrt();
    let point = |k: i32, y: f64| {
        let angle = turn * f64::from(k);
        [corner * angle.sin(), y, -corner * angle.cos()]
    };
    let triangles = (0..strips).flat_map(|k| {
        let [a, b, c, d] = [point(k, -1.0), point(k + 1, -1.0), point(k + 1, 1.0), point(k, 1.0)];
        [[a, b, c], [a, c, d]]
    });
    let tube = WallShape::Tube { axis: [[0.0; 3], [0.0, 1.0, 0.0]], radius };
    for (friction, spin) in [(0.5, 0.0), (0.2, 100.0)] {
        let surfaces = Surfaces { friction, restitution: 0.5, ..Surfaces::smooth([0, 1]) };
        let mut model = sphere(0.01, [0.09 * 0.7, 0.0, -0.09 * 0.714], [0.0; 3], surfaces);
        model.spheres.spins = vec![[0.0, spin, 0.0]];
        model.gravity = [0.0, 0.0, -9.81];
        model.step = Some(1e-5);
        let run = |shape: WallShape| {
            let wall = Wall { shape, ..Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 1) };
            let mut run =
                GrainRun::new(GrainModel { walls: vec![wall], ..model.clone() }, 1).expect("a model");
            run.advance(25_000).expect("steps");
            (run.position(0), run.spin(0))
        };
        let (smooth, strips) =
            (run(tube.clone()), run(WallShape::Mesh { triangles: triangles.clone().collect() }));
        let apart = plus(smooth.0, -1.0, strips.0);
        assert!(dot(apart, apart).sqrt() < 1e-3, "{smooth:?} {strips:?}");
        assert!((smooth.1[1] - strips.1[1]).abs() < 0.02 * smooth.1[1].abs(), "{smooth:?} {strips:?}");
    }
}

/// A block below a sphere breaks in two: the new edge begins without force and bears the sphere afterwards; a
/// run that is saved and continued after that has the same bits.
#[test]
fn a_block_that_breaks_below_a_sphere_gives_it_no_energy() {
    let mut model = sphere(0.01, [0.001, 0.002, 0.0199], [0.0; 3], Surfaces::smooth([0, 1]));
    model.gravity = [0.0, 0.0, -9.81];
    model.step = Some(2e-6);
    let whole = {
        let points = vec![[-0.03, -0.03, 0.01], [0.0, -0.03, 0.01], [0.03, -0.03, 0.01]];
        let back = points.iter().map(|p: &Vector| [p[0], 0.03, p[2]]).collect();
        Body::at_rest([points, back].concat(), vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    };
    let mut broken = whole.clone();
    broken.points.extend([whole.points[1], whole.points[4]]);
    broken.velocities.extend([[0.0; 3]; 2]);
    broken.facets[0] = [0, 6, 7];
    broken.facets[1] = [0, 7, 3];
    let mut run = GrainRun::new(model.clone(), 1).expect("a model");
    let total = |run: &GrainRun| {
        let of = run.energies();
        of.kinetic + of.elastic + of.weight + of.dissipated - of.external
    };
    whole.step(&mut run);
    let first = total(&run);
    for _ in 0..50 {
        whole.step(&mut run);
    }
    let before = run.contacts()[0];
    broken.step(&mut run);
    let after = run.contacts();
    assert!(before.overlap > 5e-5 && after.len() == 1, "{before:?} {after:?}");
    assert!((after[0].force[2] / before.force[2] - 1.0).abs() < 0.05, "{before:?} {after:?}");
    let mut other = GrainRun::resume(model, run.state(), 2).expect("a run");
    for _ in 0..6000 {
        broken.step(&mut run);
        broken.step(&mut other);
        assert!((total(&run) - first).abs() < 1e-5 * first, "{} {first}", total(&run));
    }
    assert_eq!(run.state(), other.state());
    assert!(run.position(0)[2] > 0.0201, "{:?}", run.position(0));
    // It falls on both halves.
    let mut most = 0;
    for _ in 0..40_000 {
        broken.step(&mut run);
        most = most.max(run.contacts().len());
    }
    assert_eq!(most, 2);
}

/// Wrong surfaces are refused.
#[test]
fn surfaces_that_do_not_fit_are_refused() {
    let model = sphere(0.01, [0.0; 3], [0.0; 3], Surfaces::smooth([0, 1]));
    let mut run = GrainRun::new(model, 1).expect("a model");
    let (points, velocities) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    let of = Surface { points: &points, velocities: &velocities, facets: &[[0, 1, 3]], materials: &[1] };
    let error = run.step_on(&of).expect_err("a missing point").to_string();
    assert_eq!(error, "facet 0 of the surface: there is no point 3");
    let of = Surface { facets: &[[0, 1, 2]], materials: &[2], ..of };
    let error = run.step_on(&of).expect_err("a missing material").to_string();
    assert_eq!(error, "facet 0 of the surface: there is no material 2");
    let of = Surface { materials: &[], ..of };
    let error = run.step_on(&of).expect_err("missing materials").to_string();
    assert_eq!(error, "0 materials of facets of the surface instead of 1");
}
