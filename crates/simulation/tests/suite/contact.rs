//! Collisions, contact pressure and friction.

use crate::common::*;
use fdem_simulation::*;

fn triangle(at: [[f64; 2]; 3]) -> Mesh {
    Mesh { nodes: at.to_vec(), elements: vec![[0, 1, 2]], bodies: vec![0], materials: vec![0] }
}

/// Runs two bodies, the second with `velocity`, until they have met and separated. Returns the kinetic
/// energies before and after, the strain energy after, and the momenta before and after.
fn collide(
    first: &Mesh,
    second: &Mesh,
    velocity: [f64; 2],
    material: Material,
) -> ([f64; 2], f64, [[f64; 3]; 2]) {
    let mesh = together(&[first.clone(), second.clone()]);
    let velocities = [vec![[0.0; 2]; first.nodes.len()], vec![velocity; second.nodes.len()]].concat();
    // An impact of two elements lasts only a few critical steps.
    let time = TimeOptions { safety: 0.05, ..TimeOptions::default() };
    let model = Model { mesh, velocities, materials: vec![material], time, ..Model::default() };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let (energy, before) = (run.energies(), momentum(&run));
    assert_eq!(run.counts().contacts, 0);
    let (mut met, mut apart) = (false, 0);
    while apart < 400 {
        run.advance(1).expect("a step");
        let touches = run.counts().contacts > 0;
        met |= touches;
        apart = if met && !touches { apart + 1 } else { 0 };
        assert!(run.steps() < 400_000, "they never met, or never part");
    }
    let after = run.energies();
    ([energy.kinetic, after.kinetic], after.strain, [before, momentum(&run)])
}

#[test]
fn two_triangles_bounce_whatever_meets_whatever() {
    let target = triangle([[0.0, 0.0], [1.0, 0.0], [0.5, 0.8]]);
    let vertex_first = triangle([[0.0, 0.0], [0.5, 0.8], [-0.5, 0.8]]);
    let edge_first = triangle([[-0.5, 0.0], [0.5, 0.0], [0.1, 0.8]]);
    let below = turned(&target, std::f64::consts::PI, [1.0, 0.0]);
    let stiff = Material { poissons_ratio: 0.2, ..granite() };
    let cases = [
        ("vertex on edge", below.clone(), turned(&vertex_first, 0.0, [0.45, 0.02]), [0.0, -1.0]),
        ("edge on edge", below.clone(), turned(&edge_first, 0.0, [0.5, 0.02]), [0.0, -1.0]),
        ("vertex on vertex", target.clone(), turned(&vertex_first, 0.0, [0.52, 0.83]), [0.0, -1.0]),
        ("edge on vertex", target.clone(), turned(&edge_first, 0.1, [0.5, 0.9]), [0.0, -1.0]),
        ("obliquely", target.clone(), turned(&edge_first, 0.7, [1.0, 1.3]), [-0.4, -1.0]),
    ];
    for (name, first, second, velocity) in cases {
        for turn in [0.0, 0.3, 2.1] {
            let (sin, cos) = f64::sin_cos(turn);
            let along = [cos * velocity[0] - sin * velocity[1], sin * velocity[0] + cos * velocity[1]];
            let (first, second) = (turned(&first, turn, [0.0; 2]), turned(&second, turn, [0.0; 2]));
            let (kinetic, strain, [before, after]) = collide(&first, &second, along, stiff.clone());
            // The elements vibrate after the impact: part of the energy is strain energy, and none is lost.
            assert!(((kinetic[1] + strain) / kinetic[0] - 1.0).abs() < 1e-3, "{name}: {kinetic:?} {strain}");
            let scale = before[0].abs() + before[1].abs();
            for k in 0..3 {
                assert!((after[k] - before[k]).abs() < 1e-11 * scale, "{name}: {before:?} {after:?}");
            }
        }
    }
}

#[test]
fn two_bars_part_after_the_wave_has_been_there_and_back() {
    let (length, speed) = (0.5, f64::sqrt(50e9 / 2700.0));
    let left = rectangle([0.0, 0.0], [length, 0.02], 100, 4);
    let right = rectangle([length, 0.0], [2.0 * length, 0.02], 100, 4);
    // The bars approach each other symmetrically at 10 m/s.
    let mesh = together(&[left.clone(), turned(&right, 0.0, [1e-7, 0.0])]);
    let velocities = [vec![[5.0, 0.0]; left.nodes.len()], vec![[-5.0, 0.0]; right.nodes.len()]].concat();
    let contact = ContactOptions { penalty: 10.0, ..ContactOptions::default() };
    let model = Model { mesh, velocities, materials: vec![granite()], contact, ..Model::default() };
    let mut run = Simulation::new(model, 2).expect("a model");
    let (mut began, mut ended, mut stress) = (None, 0.0, 0.0_f64);
    while began.is_none_or(|began| run.time() - began < 3.0 * length / speed) {
        run.advance(1).expect("a step");
        if run.counts().contacts > 0 {
            ended = run.time();
            began = began.or(Some(run.time()));
        }
        if began.is_some_and(|began| run.time() - began > 1.0 * length / speed) && stress == 0.0 {
            // Elements of the left bar behind the first wave and before the reflected one.
            let snapshot = run.snapshot();
            let inside: Vec<f64> = (0..left.elements.len())
                .filter(|&e| {
                    let x: f64 =
                        left.elements[e].iter().map(|&n| left.nodes[n as usize][0]).sum::<f64>() / 3.0;
                    x > 0.6 * length && x < 0.8 * length
                })
                .map(|e| snapshot.stresses[e][0])
                .collect();
            stress = inside.iter().sum::<f64>() / inside.len() as f64;
        }
    }
    let duration = ended - began.unwrap_or(0.0);
    assert!((duration / (2.0 * length / speed) - 1.0).abs() < 0.02, "{duration} {}", 2.0 * length / speed);
    let expected = -2700.0 * speed * 10.0 / 2.0;
    assert!((stress / expected - 1.0).abs() < 0.02, "{stress} {expected}");
}

/// A disc around the origin, made of rings of elements.
fn disc(radius: f64, rings: usize) -> Mesh {
    let mut nodes = vec![[0.0; 2]];
    let mut elements = Vec::new();
    let first = |ring: usize| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    for ring in 1..=rings {
        let count = 6 * ring;
        nodes.extend((0..count).map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
            [cos, sin].map(|x| x * radius * ring as f64 / rings as f64)
        }));
        let outer = |k: usize| (first(ring) + k % count) as u32;
        let inner = |k: usize| (first(ring - 1) + k % (count - 6).max(1)) as u32;
        for sector in 0..6 {
            for k in 0..ring {
                let (o, i) = (sector * ring + k, sector * (ring - 1) + k);
                elements.push([outer(o), outer(o + 1), inner(i)]);
                if k + 1 < ring {
                    elements.push([inner(i), outer(o + 1), inner(i + 1)]);
                }
            }
        }
    }
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// Coefficient of restitution of two discs: velocity of separation over velocity of approach.
fn restitution(rings: usize, damping: f64) -> f64 {
    let body = disc(0.5, rings);
    let half = vec![[0.0, 2.5]; body.nodes.len()];
    let down: Vec<_> = half.iter().map(|[u, v]| [-u, -v]).collect();
    let model = Model {
        mesh: together(&[body.clone(), turned(&body, 0.3, [0.0, 1.0005])]),
        velocities: [half, down].concat(),
        materials: vec![Material { poissons_ratio: 0.2, ..granite() }],
        contact: ContactOptions { damping, ..ContactOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let total = 2.0 * (run.energies().kinetic / 2.5_f64.powi(2));
    let (mut met, mut apart) = (false, 0);
    while apart < 200 {
        run.advance(1).expect("a step");
        let touches = run.counts().contacts > 0;
        met |= touches;
        apart = if met && !touches { apart + 1 } else { 0 };
        assert!(run.steps() < 100_000, "they never met, or never part");
    }
    // Momentum of the upper disc, which has half of the mass.
    let snapshot = run.snapshot();
    let mesh = &run.model().mesh;
    let mut momentum = 0.0;
    for (element, nodes) in snapshot.elements.iter().enumerate().skip(mesh.elements.len() / 2) {
        let [a, b, c] = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        momentum +=
            nodes.iter().map(|&n| 2700.0 * area / 3.0 * snapshot.velocities[n as usize][1]).sum::<f64>();
    }
    momentum / (0.5 * total) / 2.5
}

/// The documentation of `ContactOptions::damping` says so.
#[test]
fn damping_of_contacts_takes_less_on_a_finer_mesh() {
    let lost = |rings| restitution(rings, 0.0) - restitution(rings, 1.0);
    let (coarse, fine) = (lost(5), lost(10));
    assert!(coarse > 0.1 && fine > 0.005 && fine < 0.02, "{coarse} {fine}");
}

/// A block on a plane inclined by `degrees`: the plane is level, and gravity is turned instead.
fn slide(degrees: f64, friction: f64) -> Simulation {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let base = rectangle([-0.2, -0.1], [1.2, 0.0], 28, 2);
    let block = rectangle([0.0, 0.0], [0.2, 0.1], 5, 3);
    let held = nodes_where(&base, |[_, y]| y < -0.099);
    let model = Model {
        mesh: together(&[base, block]),
        materials: vec![Material { youngs_modulus: 1e8, friction, damping: 0.5, ..granite() }],
        gravity: [9.81 * sin, -9.81 * cos],
        boundaries: vec![Boundary {
            name: "ground".to_owned(),
            target: Target::Nodes(held),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        contact: ContactOptions { damping: 0.5, ..ContactOptions::default() },
        ..Model::default()
    };
    Simulation::new(model, 2).expect("a model")
}

/// Mean velocity of the block along the plane.
fn speed(run: &Simulation) -> f64 {
    let base = 29 * 3;
    let snapshot = run.snapshot();
    let block = &snapshot.velocities[base..];
    block.iter().map(|velocity| velocity[0]).sum::<f64>() / block.len() as f64
}

#[test]
fn a_block_slides_above_the_angle_of_friction_and_rests_below() {
    let mut run = slide(30.0, 0.4);
    let mut at = |time: f64| {
        while run.time() < time {
            run.advance(100).expect("steps");
        }
        (run.time(), speed(&run))
    };
    let ((t, v), (u, w)) = (at(0.1), at(0.4));
    let (found, expected) = ((w - v) / (u - t), 9.81 * (0.5 - 0.4 * 0.75_f64.sqrt()));
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    let mut run = slide(15.0, 0.4);
    while run.time() < 0.3 {
        run.advance(100).expect("steps");
    }
    assert!(speed(&run).abs() < 1e-4, "{}", speed(&run));
}

/// A block that lies in a larger one, above it, by 0.01 m; both of 0.1 m. Without gravity.
fn sunken(initial_overlap: InitialOverlap) -> Model {
    let mesh =
        together(&[rectangle([0.0, 0.0], [0.1, 0.1], 4, 4), rectangle([0.013, 0.095], [0.113, 0.195], 4, 4)]);
    let contact = ContactOptions { initial_overlap, ..ContactOptions::default() };
    Model { mesh, materials: vec![granite()], contact, ..Model::default() }
}

/// Elements in one place reach the centroids of each other, which says nothing of the stiffness of contacts.
#[test]
fn an_ignored_overlap_is_no_soft_contact() {
    let of = |initial_overlap: InitialOverlap| {
        let mesh =
            together(&[rectangle([0.0, 0.0], [0.1, 0.1], 2, 2), rectangle([0.0, 0.0], [0.1, 0.1], 2, 2)]);
        let contact = ContactOptions { initial_overlap, ..ContactOptions::default() };
        let model = Model { mesh, materials: vec![granite()], contact, ..Model::default() };
        let mut run = Simulation::new(model, 1).unwrap();
        run.advance(1).unwrap();
        assert!(run.counts().contacts > 0);
        run.penetrated()
    };
    assert_eq!(of(InitialOverlap::Ignore), None);
    assert!(of(InitialOverlap::Push).is_some());
}

/// Velocities of all nodes of the two bodies of [`sunken`].
fn approach(model: &mut Model, [below, above]: [f64; 2]) {
    let half = model.mesh.nodes.len() / 2;
    model.velocities = [vec![[0.0, below]; half], vec![[0.0, above]; half]].concat();
}

#[test]
fn an_ignored_overlap_gives_no_force_until_bodies_come_nearer() {
    let mut pushed = Simulation::new(sunken(InitialOverlap::Push), 1).unwrap();
    pushed.advance(1).unwrap();
    let overlap = pushed.energies().contact;
    assert!(overlap > 100.0, "{overlap}");
    let mut run = Simulation::new(sunken(InitialOverlap::Ignore), 1).unwrap();
    run.advance(500).unwrap();
    let energies = run.energies();
    assert!(energies.contact < 1e-15 * overlap && energies.kinetic < 1e-15 * overlap, "{energies:?}");
    assert!(run.counts().contacts > 0);

    // They bounce, part, and meet again.
    let mut model = sunken(InitialOverlap::Ignore);
    approach(&mut model, [2.0, -2.0]);
    model.time.safety = 0.2;
    let mut run = Simulation::new(model, 1).unwrap();
    run.advance(1).unwrap();
    let total = |run: &Simulation| {
        let energies = run.energies();
        energies.kinetic + energies.strain + energies.contact
    };
    let (first, mut pressed, mut steps) = (total(&run), 0.0_f64, 0);
    while run.counts().contacts > 0 {
        run.advance(1).unwrap();
        pressed = pressed.max(run.energies().contact);
        assert!((total(&run) / first - 1.0).abs() < 1e-2, "{} {first}", total(&run));
        steps += 1;
        assert!(steps < 200_000, "they never part");
    }
    assert!(pressed > 1e-3 * first, "{pressed} {first}");
}

#[test]
fn an_overlap_that_relaxes_presses_bodies_apart_slowly() {
    let mut pushed = Simulation::new(sunken(InitialOverlap::Push), 1).unwrap();
    pushed.advance(1).unwrap();
    let overlap = pushed.energies().contact;
    let mut model = sunken(InitialOverlap::Relax);
    model.contact.damping = 0.3;
    let mut run = Simulation::new(model.clone(), 1).unwrap();
    run.advance(1).unwrap();
    assert!(run.energies().contact < 1e-15 * overlap, "{:?}", run.energies());
    let first = run.counts().contacts;
    let mut most = 0.0_f64;
    while run.counts().contacts > 0 {
        run.advance(100).unwrap();
        let energies = run.energies();
        let stored = energies.kinetic + energies.strain + energies.contact;
        let spent = energies.friction + energies.damping;
        most = most.max(energies.external);
        assert!((stored + spent - energies.external).abs() < 0.01 * most, "{energies:?}");
        assert!(run.steps() < 20_000, "{} of {first} contacts are left: {energies:?}", run.counts().contacts);
    }
    let energies = run.energies();
    assert!(run.penetrated().is_none());
    assert!(energies.external > 0.0 && energies.kinetic < 0.01 * overlap, "{energies:?}, {overlap}");

    // Bodies that cannot part press on each other in the end as if nothing had been ignored.
    let nodes = (0..model.mesh.nodes.len() as u32).collect();
    model.boundaries.push(Boundary {
        name: "held".to_owned(),
        target: Target::Nodes(nodes),
        load: Load::Velocity([Some(0.0); 2]),
        schedule: Schedule::Constant,
    });
    model.contact.overlap_time = Some(2e-5);
    let mut run = Simulation::new(model, 1).unwrap();
    run.advance(1000).unwrap();
    let energies = run.energies();
    assert!((energies.contact / overlap - 1.0).abs() < 1e-3, "{energies:?}, {overlap}");
    assert!((energies.external / overlap - 1.0).abs() < 1e-3, "{energies:?}, {overlap}");
}
