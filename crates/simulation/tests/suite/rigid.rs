//! Bodies that are rigid.

use crate::common::*;
use fdem_simulation::*;

/// A tilted block that falls on another one, with a third beside it, and a paddle that turns: all rigid but
/// the lowest.
pub(crate) fn blocks() -> Model {
    let ground = rectangle([0.0, -0.05], [0.4, 0.0], 16, 2);
    let one = turned(&rectangle([0.0, 0.0], [0.1, 0.06], 3, 2), 0.5, [0.2, 0.002]);
    let other = turned(&rectangle([0.0, 0.0], [0.08, 0.08], 2, 2), -0.3, [0.08, 0.03]);
    let paddle = rectangle([0.32, 0.002], [0.34, 0.1], 1, 4);
    let moves = |mesh: &Mesh, velocity: [f64; 2]| vec![velocity; mesh.nodes.len()];
    let velocities =
        [moves(&ground, [0.0; 2]), moves(&one, [-1.0, -8.0]), moves(&other, [6.0, -2.0])].concat();
    let velocities = [velocities, moves(&paddle, [0.0; 2])].concat();
    let first = (ground.nodes.len() + one.nodes.len() + other.nodes.len()) as u32;
    let strength = Strength { tensile: 2e6, cohesion: 4e6, energy_i: 5.0, energy_ii: 20.0, ..rock() };
    Model {
        boundaries: vec![
            held("floor", nodes_where(&ground, |[_, y]| y < -0.0499), [Some(0.0); 2], Schedule::Constant),
            Boundary {
                name: "paddle".to_owned(),
                target: Target::Nodes((first..first + paddle.nodes.len() as u32).collect()),
                load: Load::Rotation { spin: [0.0, 0.0, 30.0], through: [0.33, 0.08] },
                schedule: Schedule::Ramp(1e-3),
            },
        ],
        mesh: together(&[ground, one, other, paddle]),
        velocities,
        materials: vec![Material { strength: Some(strength), friction: 0.5, damping: 0.05, ..granite() }],
        gravity: [0.0, -9.81],
        rigid: vec![1, 2, 3],
        contact: ContactOptions { damping: 0.2, ..ContactOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// A tumbling rigid box that falls on a slab.
pub(crate) fn blocks_in_space() -> Model<3, 4> {
    let slab = crate::space::cuboid([0.0, 0.0, -0.05], [0.3, 0.2, 0.0], [6, 4, 1]);
    let falling = crate::space::cuboid([0.08, 0.05, 0.002], [0.18, 0.11, 0.06], [2, 1, 1]);
    let spin = [40.0, -25.0, 10.0];
    let velocity = |node: &[f64; 3]| {
        let arm = [node[0] - 0.13, node[1] - 0.08, node[2] - 0.031];
        [
            3.0 + spin[1] * arm[2] - spin[2] * arm[1],
            spin[2] * arm[0] - spin[0] * arm[2],
            -9.0 + spin[0] * arm[1] - spin[1] * arm[0],
        ]
    };
    let velocities = slab.nodes.iter().map(|_| [0.0; 3]).chain(falling.nodes.iter().map(velocity)).collect();
    let bottom = (0..).zip(&slab.nodes).filter(|(_, node)| node[2] < -0.0499).map(|(node, _)| node);
    Model {
        boundaries: vec![held("floor", bottom.collect(), [Some(0.0); 3], Schedule::Constant)],
        mesh: together(&[slab, falling]),
        velocities,
        materials: vec![Material { friction: 0.5, ..granite() }],
        gravity: [0.0, 0.0, -9.81],
        rigid: vec![1],
        time: TimeOptions { step: Some(1e-6), ..TimeOptions::default() },
        ..Model::default()
    }
}

/// A box that tumbles onto a slab keeps the energy, the better the shorter the step.
#[test]
fn a_box_in_space_bounces_off_a_slab() {
    let mut errors = Vec::new();
    for step in [1e-6, 0.5e-6, 0.25e-6] {
        let time = TimeOptions { step: Some(step), ..TimeOptions::default() };
        let mut run = Simulation::new(Model { time, ..blocks_in_space() }, 1).expect("a model");
        run.advance((1.2e-3 / step) as u64).expect("steps");
        assert!(run.energies().friction > 0.0);
        errors.push(run.energies().error().abs());
    }
    // Of second order.
    assert!(errors[0] < 3e-3 && errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1], "{errors:?}");
}

/// Distances of all nodes of a body to each other, squared.
fn distances(run: &Simulation, body: u32) -> Vec<f64> {
    let snapshot = run.snapshot();
    let elements = run.model().mesh.bodies.iter().zip(&snapshot.elements).filter(|(of, _)| **of == body);
    let nodes: Vec<u32> = elements.flat_map(|(_, nodes)| *nodes).collect();
    let at = |node: &u32| snapshot.positions[*node as usize];
    nodes
        .iter()
        .flat_map(|a| nodes.iter().map(move |b| [at(a), at(b)]))
        .map(|[[x, y], [u, v]]| (x - u).powi(2) + (y - v).powi(2))
        .collect()
}

#[test]
fn rigid_bodies_keep_their_shape_and_the_energy_and_break_others() {
    let mut run = Simulation::new(blocks(), 1).expect("a model");
    let before = [1, 2].map(|body| distances(&run, body));
    run.advance(4000).expect("steps");
    for (before, body) in before.iter().zip([1, 2]) {
        for (a, b) in before.iter().zip(distances(&run, body)) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
    }
    let counts = run.counts();
    assert!(counts.broken > 5, "{counts:?}");
    assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
    let stresses = run.snapshot().stresses;
    let rigid = run.model().mesh.bodies.iter().zip(&stresses).filter(|(body, _)| **body > 0);
    assert!(rigid.into_iter().all(|(_, stress)| stress.iter().all(|part| *part == 0.0)));
}

/// Two free squares that meet at any angle, without friction.
#[test]
fn a_collision_keeps_momentum_and_energy() {
    for k in 0..6 {
        let angle = 1.27 * f64::from(k);
        let square = rectangle([-0.05, -0.05], [0.05, 0.05], 2, 2);
        let meshes = [turned(&square, angle, [-0.08, 0.01]), turned(&square, 1.7 * angle, [0.08, 0.0])];
        let moves = [vec![[5.0, 0.3]; 9], vec![[-3.0, 0.0]; 9]].concat();
        let model = Model {
            mesh: together(&meshes),
            velocities: moves,
            materials: vec![granite()],
            rigid: vec![0, 1],
            time: TimeOptions { safety: 0.1, ..TimeOptions::default() },
            ..Model::default()
        };
        let mut run = Simulation::new(model, 1).expect("a model");
        let before = momentum(&run);
        run.advance((0.03 / run.time_step()) as u64).expect("steps");
        let after = momentum(&run);
        let (_, [velocity, _]) = run.node(4).expect("the middle of the first square");
        assert!((velocity - 5.0).abs() > 1.0 && run.counts().contacts == 0, "{k}: {velocity}");
        let kinetic = run.energies().kinetic;
        let first = 0.5 * 27.0 * (25.09 + 9.0);
        assert!((kinetic / first - 1.0).abs() < 1e-4, "{k}: {kinetic} {first}");
        for axis in 0..2 {
            assert!((after[axis] - before[axis]).abs() < 1e-10, "{k}: {before:?} {after:?}");
        }
        assert!(run.energies().error().abs() < 1e-4, "{k}: {:?}", run.energies());
    }
}

/// A block on a plane at rest, and one that slides; both planes are rigid and held.
#[test]
fn a_block_rests_or_slides_on_a_slope() {
    let g = 9.81;
    for (friction, degrees, moves) in [(0.45, 20.0, false), (0.3, 20.0, true), (0.3, -20.0, true)] {
        let angle = f64::to_radians(degrees);
        let plane = rectangle([-1.0, -0.1], [1.0, 0.0], 8, 1);
        // It begins where the contact carries the weight.
        let block = rectangle([-0.05, 0.0], [0.05, 0.1], 1, 1);
        let mesh = together(&[plane.clone(), block]);
        let model = Model {
            boundaries: vec![held(
                "plane",
                (0..plane.nodes.len() as u32).collect(),
                [Some(0.0); 2],
                Schedule::Constant,
            )],
            mesh,
            materials: vec![Material { friction, youngs_modulus: 1e8, ..granite() }],
            gravity: [g * angle.sin(), -g * angle.cos()],
            rigid: vec![0, 1],
            contact: ContactOptions { damping: 0.3, ..ContactOptions::default() },
            ..Model::default()
        };
        let mut run = Simulation::new(model, 1).expect("a model");
        let node = 2 * 9;
        run.advance((0.1 / run.time_step()) as u64).expect("steps");
        let (_, [first, _]) = run.node(node).expect("a node");
        let time = run.time();
        run.advance((0.2 / run.time_step()) as u64).expect("steps");
        let (_, [last, _]) = run.node(node).expect("a node");
        let found = (last - first) / (run.time() - time);
        let expected =
            if moves { g * (angle.abs().sin() - friction * angle.cos()) * angle.signum() } else { 0.0 };
        assert!((found - expected).abs() < 1e-3 * g, "{friction} {degrees}: {found} {expected}");
    }
}

/// Supports hold a whole body, and its reaction is its weight; supports of one node would be a hinge.
#[test]
fn supports_hold_a_body_or_are_refused() {
    let block = rectangle([0.0, 0.0], [0.2, 0.1], 4, 2);
    let block_on = |nodes: Vec<u32>, axes: [Option<f64>; 2]| Model {
        boundaries: vec![held("held", nodes, axes, Schedule::Constant)],
        mesh: block.clone(),
        materials: vec![granite()],
        gravity: [0.0, -9.81],
        rigid: vec![0],
        ..Model::default()
    };
    let bottom = nodes_where(&block, |[_, y]| y == 0.0);
    let mut run = Simulation::new(block_on(bottom.clone(), [None, Some(0.0)]), 1).expect("a model");
    run.advance(100).expect("steps");
    let [_, force] = run.force(0).expect("a boundary");
    assert!((force - 0.2 * 0.1 * 2700.0 * 9.81).abs() < 1e-9, "{force}");
    let (moved, velocity) = run.node(3).expect("a node");
    assert_eq!((moved, velocity), ([0.0; 2], [0.0; 2]));
    for (nodes, axes) in [(vec![0], [Some(0.0); 2]), (vec![0], [None, Some(0.0)])] {
        let refused = Simulation::new(block_on(nodes, axes), 1).expect_err("a hinge");
        assert!(matches!(refused, ModelError::RigidSupport { body: 0, turns: true, .. }), "{refused}");
    }
    // A body that is driven moves as a whole.
    let mut run = Simulation::new(block_on(bottom, [Some(2.0), Some(-1.0)]), 1).expect("a model");
    run.advance(100).expect("steps");
    for node in 0..block.nodes.len() as u32 {
        let ([x, y], [u, v]) = run.node(node).expect("a node");
        let time = run.time();
        assert!((x - 2.0 * time).abs() < 1e-15 && (y + time).abs() < 1e-15 && [u, v] == [2.0, -1.0]);
    }
}

#[test]
fn a_run_with_rigid_bodies_is_resumed_bit_for_bit() {
    let mut whole = Simulation::new(blocks(), 2).expect("a model");
    whole.advance(700).expect("steps");
    let saved = postcard::to_allocvec(&whole.state()).expect("bytes");
    whole.advance(900).expect("steps");
    let state: State = postcard::from_bytes(&saved).expect("a state");
    let mut resumed = Simulation::resume(blocks(), state, 1).expect("the same model");
    resumed.advance(900).expect("steps");
    assert!(resumed.counts().contacts > 0);
    let bytes = |run: &Simulation| postcard::to_allocvec(&run.state()).expect("bytes");
    assert!(bytes(&resumed) == bytes(&whole));
}

/// A body of bricks in space that turns about no axis of its own: its energy does not drift, and its moments
/// of inertia are those of the formula for a box.
#[test]
fn a_free_body_keeps_its_energy_while_it_tumbles() {
    let sides = [0.3, 0.2, 0.1];
    let mesh = crate::space::cuboid([0.0; 3], sides, [1, 1, 1]);
    let spin = [0.01, 1.0, 0.01];
    let velocity = |node: &[f64; 3]| {
        let arm: [f64; 3] = std::array::from_fn(|k| node[k] - 0.5 * sides[k]);
        [
            spin[1] * arm[2] - spin[2] * arm[1],
            spin[2] * arm[0] - spin[0] * arm[2],
            spin[0] * arm[1] - spin[1] * arm[0],
        ]
    };
    let model = Model {
        velocities: mesh.nodes.iter().map(velocity).collect(),
        mesh,
        materials: vec![granite()],
        rigid: vec![0],
        time: TimeOptions { step: Some(2e-3), ..TimeOptions::default() },
        ..Model::<3, 4>::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    let mass = 2700.0 * sides.iter().product::<f64>();
    let square = |a: usize, b: usize| mass / 12.0 * (sides[a].powi(2) + sides[b].powi(2));
    let inertia = [square(1, 2), square(0, 2), square(0, 1)];
    let expected: f64 = (0..3).map(|k| 0.5 * inertia[k] * spin[k].powi(2)).sum();
    let (mut least, mut turned) = (f64::INFINITY, false);
    for _ in 0..200 {
        run.advance(100).expect("steps");
        let kinetic = run.energies().kinetic;
        assert!((kinetic / expected - 1.0).abs() < 1e-6, "{kinetic} {expected}");
        least = least.min(kinetic);
        // The middle axis is unstable: the body turns over.
        let corner = |node: u32| run.snapshot().positions[node as usize];
        let along: f64 = corner(2)[1] - corner(0)[1];
        turned |= along < 0.0;
    }
    assert!(turned);
}

/// The largest distance of the nodes of a model from where a rotation about an axis takes them, m.
fn off_circle<const D: usize, const N: usize>(
    run: &Simulation<D, N>,
    [through, axis]: [[f64; 3]; 2],
    angle: f64,
) -> f64
where
    [[f64; D]; N]: Element<D, N>,
{
    let snapshot = run.snapshot();
    let (sin, cos) = angle.sin_cos();
    let mut largest = 0.0_f64;
    for (nodes, of_run) in run.model().mesh.elements.iter().zip(&snapshot.elements) {
        for (&node, &now) in nodes.iter().zip(of_run) {
            let start = run.model().mesh.nodes[node as usize];
            let arm: [f64; 3] = std::array::from_fn(|k| start.get(k).copied().unwrap_or(0.0) - through[k]);
            let along: f64 = (0..3).map(|k| axis[k] * arm[k]).sum();
            let cross = |k: usize| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                axis[i] * arm[j] - axis[j] * arm[i]
            };
            for k in 0..D {
                let to = through[k] + cos * arm[k] + sin * cross(k) + (1.0 - cos) * along * axis[k];
                largest = largest.max((snapshot.positions[now as usize][k] - to).abs());
            }
        }
    }
    largest
}

#[test]
fn a_rotation_turns_bodies_about_an_axis() {
    // A deformable block in the plane, all of whose nodes turn: exactly along circles, without stress.
    let mesh = rectangle([0.0, 0.0], [0.1, 0.05], 4, 2);
    let nodes = (0..mesh.nodes.len() as u32).collect();
    let turning = |target, spin, schedule| Boundary {
        name: "turning".to_owned(),
        target,
        load: Load::Rotation { spin, through: [-0.2, 0.1] },
        schedule,
    };
    let model = Model {
        mesh,
        materials: vec![granite()],
        boundaries: vec![turning(Target::Nodes(nodes), [0.0, 0.0, 50.0], Schedule::Constant)],
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(20_000).expect("steps");
    let angle = 50.0 * run.time();
    assert!(angle > 0.5 && off_circle(&run, [[-0.2, 0.1, 0.0], [0.0, 0.0, 1.0]], angle) < 1e-12);
    assert!(run.energies().strain < 1e-9 * run.energies().kinetic, "{:?}", run.energies());
}

#[test]
fn a_rotation_of_a_rigid_body_does_the_work_of_its_kinetic_energy() {
    let mesh = crate::space::cuboid([0.0, 0.0, 0.0], [0.1, 0.06, 0.02], [3, 2, 1]);
    let (through, spin) = ([0.05, -0.1, 0.0], [20.0, 0.0, 15.0]);
    // One face of the body is enough.
    let face = (0..).zip(&mesh.nodes).filter(|(_, node)| node[0] < 1e-9).map(|(node, _)| node).collect();
    let model = Model {
        mesh,
        materials: vec![granite()],
        rigid: vec![0],
        boundaries: vec![Boundary {
            name: "turning".to_owned(),
            target: Target::Nodes(face),
            load: Load::Rotation { spin, through },
            schedule: Schedule::Ramp(0.02),
        }],
        time: TimeOptions { step: Some(1e-5), ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(2_000).expect("steps");
    let before = run.time();
    run.advance(3_000).expect("steps");
    let speed = 25.0;
    // The ramp is half a cosine: its mean is 1/2.
    let angle = speed * (0.5 * before + (run.time() - before));
    let axis = spin.map(|x| x / speed);
    let off = off_circle(&run, [through, axis], angle);
    assert!(angle > 0.9 && off < 1e-9, "{angle} {off}");
    let energies = run.energies();
    assert!(energies.error().abs() < 1e-4, "{energies:?}");
    assert!((energies.external / energies.kinetic - 1.0).abs() < 1e-4, "{energies:?}");
    // ½ ω I ω of a block about an axis beside its centre.
    let (mass, sides) = (2700.0 * 0.1 * 0.06 * 0.02, [0.1, 0.06, 0.02_f64]);
    let about = |k: usize| mass * (sides.iter().map(|x| x * x).sum::<f64>() - sides[k] * sides[k]) / 12.0;
    let arm = [0.0, 0.13, 0.01];
    let along: f64 = (0..3).map(|k| axis[k] * arm[k]).sum();
    let aside: f64 = arm.iter().map(|x| x * x).sum::<f64>() - along * along;
    let inertia: f64 = (0..3).map(|k| axis[k] * axis[k] * about(k)).sum::<f64>() + mass * aside;
    let kinetic = 0.5 * inertia * speed * speed;
    assert!((energies.kinetic / kinetic - 1.0).abs() < 1e-6, "{} {kinetic}", energies.kinetic);
    // The support holds the centre of mass on its circle.
    let force = run.force(0).expect("a boundary");
    let size = force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let wanted = mass * aside.sqrt() * speed * speed;
    assert!((size / wanted - 1.0).abs() < 1e-3, "{size} {wanted}");
}

/// A support that comes while a body turns takes its angular momentum, and the energy.
#[test]
fn a_support_that_comes_later_stops_a_rotation() {
    let block = rectangle([0.0, 0.0], [0.2, 0.1], 4, 2);
    let velocities = block.nodes.iter().map(|[x, y]| [-3.0 * (y - 0.05), 3.0 * (x - 0.1)]).collect();
    let free =
        Model { mesh: block, velocities, materials: vec![granite()], rigid: vec![0], ..Model::default() };
    let mut run = Simulation::new(free.clone(), 1).expect("a model");
    run.advance(500).expect("steps");
    let kinetic = run.energies().kinetic;
    assert!(kinetic > 0.0);
    let nodes = (0..free.mesh.nodes.len() as u32).collect();
    let held =
        Model { boundaries: vec![held("held", nodes, [Some(0.0); 2], Schedule::Constant)], ..free.clone() };
    let elements = (0..free.mesh.elements.len() as u32).map(Some).collect();
    let change = Change { model: held, elements, release: None };
    let (held, state) = run.state().changed(&free, change, 1).expect("a changed run");
    let mut held = Simulation::resume(held, state, 1).expect("a run");
    held.advance(500).expect("energies in balance");
    let energies = held.energies();
    assert!(energies.kinetic == 0.0 && (energies.external / kinetic + 1.0).abs() < 1e-9, "{energies:?}");
    assert!(energies.error().abs() < 1e-9, "{energies:?}");
}

/// A body that a rotation turns, rigid or with all nodes driven, and the axis: a point and a direction.
fn turning<const D: usize, const N: usize>(
    mesh: Mesh<D, N>,
    is_rigid: bool,
    (through, spin): ([f64; D], [f64; 3]),
    schedule: Schedule,
) -> Simulation<D, N>
where
    [[f64; D]; N]: Element<D, N>,
    Model<D, N>: Default,
{
    let nodes = (0..mesh.nodes.len() as u32).collect();
    let model = Model {
        mesh,
        materials: vec![granite()],
        rigid: if is_rigid { vec![0] } else { Vec::new() },
        boundaries: vec![Boundary {
            name: "turning".to_owned(),
            target: Target::Nodes(nodes),
            load: Load::Rotation { spin, through },
            schedule,
        }],
        time: TimeOptions { step: Some(2e-6), ..TimeOptions::default() },
        ..Model::default()
    };
    Simulation::new(model, 1).expect("a model")
}

/// A rotation at a constant speed needs no moment, and one that is ramped up that of the moment of inertia.
#[test]
fn the_moment_of_a_rotation_is_that_of_the_inertia() {
    let (through, rate) = ([-0.2, 0.1], 50.0);
    let mass = 2700.0 * 0.1 * 0.05;
    let square = mass * 50.0_f64.powi(2) * 0.3;
    for is_rigid in [true, false] {
        let mesh = rectangle([0.0, 0.0], [0.1, 0.05], 4, 2);
        let mut run = turning(mesh.clone(), is_rigid, (through, [0.0, 0.0, rate]), Schedule::Constant);
        run.advance(1_000).expect("steps");
        let [x, y, moment] = run.moment(0).expect("a boundary");
        assert!([x, y] == [0.0; 2] && moment.abs() < 1e-9 * square, "{is_rigid}: {moment} {square}");
        // The angular velocity grows linearly, 1000 rad/s in a second.
        let table = Schedule::Table(vec![[0.0, 0.0], [1.0, 1.0]]);
        let mut run = turning(mesh.clone(), is_rigid, (through, [0.0, 0.0, 1000.0]), table);
        run.advance(1_000).expect("steps");
        // Masses at the nodes have more inertia than a body that is homogeneous.
        let lumped = |node: &[f64; 2]| (node[0] + 0.2).powi(2) + (node[1] - 0.1).powi(2);
        let inertia = if is_rigid {
            mass * ((0.1_f64.powi(2) + 0.05_f64.powi(2)) / 12.0 + 0.25_f64.powi(2) + 0.075_f64.powi(2))
        } else {
            let of_element = |element: &[u32; 3]| {
                let each = element.map(|node| lumped(&mesh.nodes[node as usize]));
                mass / mesh.elements.len() as f64 * each.iter().sum::<f64>() / 3.0
            };
            mesh.elements.iter().map(of_element).sum()
        };
        let [_, _, moment] = run.moment(0).expect("a boundary");
        assert!((moment / (1000.0 * inertia) - 1.0).abs() < 1e-5, "{is_rigid}: {moment} {inertia}");
        assert_eq!(run.moment(1), None);
    }
    // About an axis aslant, not through the centre: the moment along the axis.
    let (sides, axis) = ([0.1, 0.06, 0.02], [0.8, 0.0, 0.6]);
    let mesh = crate::space::cuboid([0.0; 3], sides, [3, 2, 1]);
    let through = [0.05, -0.1, 0.0];
    let table = Schedule::Table(vec![[0.0, 0.0], [1.0, 1.0]]);
    let mut run = turning(mesh, true, (through, axis.map(|x| 1000.0 * x)), table);
    run.advance(1_000).expect("steps");
    let mass = 2700.0 * sides.iter().product::<f64>();
    let about = |k: usize| mass * (sides.iter().map(|x| x * x).sum::<f64>() - sides[k] * sides[k]) / 12.0;
    let arm = [0.0, 0.13, 0.01];
    let along = axis[0] * arm[0] + axis[2] * arm[2];
    let aside = arm.iter().map(|x| x * x).sum::<f64>() - along * along;
    let inertia = (0..3).map(|k| axis[k] * axis[k] * about(k)).sum::<f64>() + mass * aside;
    let moment = run.moment(0).expect("a boundary");
    let found: f64 = (0..3).map(|k| axis[k] * moment[k]).sum();
    assert!((found / (1000.0 * inertia) - 1.0).abs() < 1e-5, "{found} {inertia}");
}

/// A horizontal arm that its boundary turns slowly needs the moment of its weight.
#[test]
fn the_moment_of_a_rotation_carries_the_weight() {
    let mesh = rectangle([0.0, 0.0], [0.1, 0.05], 4, 2);
    let run = turning(mesh, true, ([0.0, 0.025], [0.0, 0.0, 1e-3]), Schedule::Constant);
    let model = Model { gravity: [0.0, -9.81], ..run.model().clone() };
    let mut run = Simulation::new(model, 1).expect("a model");
    // The first step brings it to its speed.
    run.advance(2).expect("steps");
    let [_, _, moment] = run.moment(0).expect("a boundary");
    let weight = 2700.0 * 0.1 * 0.05 * 9.81;
    assert!((moment / (0.05 * weight) - 1.0).abs() < 1e-8, "{moment}");
    let force = run.force(0).expect("a boundary");
    assert!((force[1] / weight - 1.0).abs() < 1e-8, "{force:?}");
}

/// The probe of a rigid body has the motion of its centre of mass, and turns that add up.
#[test]
fn the_motion_of_a_rigid_body_is_measured() {
    // A block that flies and spins in the plane.
    let mesh = rectangle([0.0, 0.0], [0.2, 0.1], 2, 1);
    let velocities = mesh.nodes.iter().map(|[x, y]| [2.0 + 30.0 * (y - 0.05), -1.0 - 30.0 * (x - 0.1)]);
    let model = Model {
        velocities: velocities.collect(),
        mesh,
        materials: vec![granite()],
        rigid: vec![0],
        time: TimeOptions { step: Some(1e-3), ..TimeOptions::default() },
        ..Model::default()
    };
    let probes = [Probe::RigidBody(0), Probe::RigidBody(1)];
    let names: Vec<_> = probes[0].columns().iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["ux", "uy", "vx", "vy", "rz", "wz"]);
    let mut run = Simulation::new(model, 1).expect("a model");
    for steps in [0, 1, 999, 2000] {
        run.advance(steps).expect("steps");
        let time = run.time();
        let [found, none] = &run.measure(&probes)[..] else { panic!("two probes") };
        let expected = [2.0 * time, -time, 2.0, -1.0, -30.0 * time, -30.0];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
        assert!(none.len() == 6 && none.iter().all(|value| value.is_nan()));
    }
    // In space, a block that a boundary turns about an axis aslant: 4.8 turns.
    let mesh = crate::space::cuboid([0.0; 3], [0.1, 0.06, 0.02], [3, 2, 1]);
    let axis = [0.8, 0.0, 0.6];
    let mut run = turning(mesh, true, ([0.05, 0.03, 0.01], axis.map(|x| 3e3 * x)), Schedule::Constant);
    run.advance(5_000).expect("steps");
    let found = run.measure(&[Probe::RigidBody(0)]).concat();
    let angle = 3e3 * run.time();
    let turns = [axis.map(|x| angle * x), axis.map(|x| 3e3 * x)].concat();
    let expected = [[0.0; 6].to_vec(), turns].concat();
    assert_eq!(found.len(), 12);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}
