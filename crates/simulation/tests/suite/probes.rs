//! Probes: known states give known values, and ranks change no bit.

use crate::common::*;
use crate::joint_sets::{halves, open, top_edges};
use fdem_distributed::{Communicator, threads};
use fdem_simulation::*;

/// All elements of a mesh.
fn all<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Vec<u32> {
    (0..mesh.elements.len() as u32).collect()
}

fn point(mesh: &Mesh, at: [f64; 2]) -> MaterialPoint {
    MaterialPoint::at(mesh, at, |_| true).expect("a point of the mesh")
}

/// A bar of granite without lateral strain that both ends pull, until it is at rest.
fn stretched(mesh: Mesh, strain: f64) -> Model {
    let ends = [0.0, 0.4].map(|end| nodes_where(&mesh, |[x, _]| (x - end).abs() < 1e-12));
    let [left, right] = ends.map(Target::Nodes);
    let move_by = |name: &str, target, by: f64| Boundary {
        name: name.to_owned(),
        target,
        load: Load::Displacement([Some(by), None]),
        schedule: Schedule::Ramp(1e-3),
    };
    Model {
        boundaries: vec![move_by("left", left, 0.0), move_by("right", right, 0.4 * strain)],
        mesh,
        materials: vec![granite()],
        time: TimeOptions { local_damping: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// Uniform strain in a bar: the stress is E ε, and a gauge along, across or askew shows the strain.
#[test]
fn a_stretched_bar_has_its_strain_and_its_stress() {
    let strain = 1e-4;
    let mesh = rectangle([0.0; 2], [0.4, 0.1], 8, 2);
    let elements = all(&mesh);
    let gauge = |a: [f64; 2], b: [f64; 2]| Probe::Gauge {
        ends: [point(&mesh, a), point(&mesh, b)],
        span: vec![b[0] - a[0], b[1] - a[1]],
    };
    let probes = [
        Probe::Stress(elements.clone()),
        Probe::Strain(elements.clone()),
        Probe::Stress(vec![5]),
        Probe::Strain(vec![5]),
        Probe::Velocity(elements),
        gauge([0.03, 0.02], [0.37, 0.02]),
        gauge([0.2, 0.01], [0.2, 0.09]),
        gauge([0.1, 0.02], [0.17, 0.09]),
        Probe::Reaction(nodes_where(&mesh, |[x, _]| x == 0.4)),
        Probe::Reaction(nodes_where(&mesh, |[x, _]| x == 0.2)),
    ];
    let mut run = Simulation::new(stretched(mesh, strain), 1).expect("a model");
    let before = run.measure(&probes);
    assert!(before.iter().flatten().all(|value| *value == 0.0), "{before:?}");
    run.advance(20_000).expect("steps");
    let found = run.measure(&probes);
    for (probe, values) in probes.iter().zip(&found) {
        assert_eq!(probe.columns().len(), values.len());
    }
    let near = |value: f64, expected: f64, within: f64| {
        assert!((value - expected).abs() < within, "{value:e} {expected:e}\n{found:?}");
    };
    let stress = 50e9 * strain;
    for k in [0, 2] {
        // Poisson's ratio is 0. The law is Hooke's to first order in the strain.
        near(found[k][0], stress, 1e-3 * stress);
        found[k][1..].iter().for_each(|&component| near(component, 0.0, 1e-3 * stress));
    }
    for k in [1, 3] {
        // (1 + ε)²/2 - 1/2
        near(found[k][0], strain + 0.5 * strain * strain, 1e-9);
        near(found[k][1], 0.0, 1e-8);
        near(found[k][2], 0.0, 1e-9);
    }
    found[4].iter().for_each(|&velocity| near(velocity, 0.0, 1e-6));
    near(found[5][0], strain, 1e-9);
    near(found[6][0], 0.0, 1e-8);
    // Along the diagonal: ε cos² 45°.
    near(found[7][0], 0.5 * strain, 1e-8);
    near(found[8][0], 0.1 * stress, 1e-4 * stress);
    assert_eq!(found[9], [0.0, 0.0], "nothing holds the nodes of the middle");
}

/// A rigid rotation is no strain, and the mean velocity of a body that turns about its centre is that of the
/// centre.
#[test]
fn a_rotation_has_no_strain() {
    let mesh = rectangle([-0.1; 2], [0.1; 2], 4, 4);
    let velocities = mesh.nodes.iter().map(|[x, y]| [3.0 - 20.0 * y, 20.0 * x]).collect();
    let elements = all(&mesh);
    let probes = [
        Probe::Velocity(elements.clone()),
        Probe::PointVelocity(point(&mesh, [0.033, 0.021])),
        Probe::Strain(elements),
    ];
    let model = Model { velocities, mesh, materials: vec![granite()], ..Model::default() };
    let mut run = Simulation::new(model, 1).expect("a model");
    let found = run.measure(&probes);
    assert!((found[0][0] - 3.0).abs() < 1e-12 && found[0][1].abs() < 1e-12, "{found:?}");
    assert!((found[1][0] - (3.0 - 20.0 * 0.021)).abs() < 1e-12, "{found:?}");
    assert!((found[1][1] - 20.0 * 0.033).abs() < 1e-12, "{found:?}");
    // A quarter of a turn.
    let steps = (std::f64::consts::FRAC_PI_2 / 20.0 / run.time_step()) as u64;
    run.advance(steps).expect("steps");
    let found = run.measure(&probes);
    assert!((found[0][0] - 3.0).abs() < 1e-9 && found[0][1].abs() < 1e-9, "{found:?}");
    assert!(found[2].iter().all(|strain| strain.abs() < 1e-6), "{found:?}");
}

/// A uniform initial stress is the mean over any elements, in both dimensions.
#[test]
fn initial_stress_is_seen() {
    let mesh = rectangle([0.0; 2], [0.3, 0.2], 5, 4);
    let stress = [[-3e6, 1e6], [1e6, -2e6]];
    let count = mesh.elements.len();
    let model = Model { stresses: vec![stress; count], materials: vec![granite()], mesh, ..Model::default() };
    let run = Simulation::new(model, 1).expect("a model");
    let found = run.measure(&[Probe::Stress(vec![3]), Probe::Stress((3..20).collect())]);
    assert_eq!(found[0], [-3e6, -2e6, 0.0, 1e6]);
    for (a, b) in found[0].iter().zip(&found[1]) {
        assert!((a - b).abs() < 1e-8, "{found:?}");
    }

    let mesh = crate::space::cuboid([0.0; 3], [0.1; 3], [2, 2, 2]);
    let stress = [[-3e6, 1e6, 0.5e6], [1e6, -2e6, 0.0], [0.5e6, 0.0, -1e6]];
    let count = mesh.elements.len();
    let model = Model { stresses: vec![stress; count], materials: vec![granite()], mesh, ..Model::default() };
    let run = Simulation::new(model, 1).expect("a model");
    let found = run.measure(&[Probe::Stress(vec![3])]);
    assert_eq!(found[0], [-3e6, -2e6, -1e6, 1e6, 0.0, 0.5e6]);
}

/// A block at rest on another: the force between them is its weight, with opposite signs on the two.
#[test]
fn a_block_that_rests_presses_with_its_weight() {
    let mesh =
        together(&[rectangle([-0.3, -0.1], [0.3, 0.0], 6, 1), rectangle([-0.1, 0.0], [0.1, 0.2], 3, 3)]);
    let ground = nodes_where(&mesh, |[_, y]| y == -0.1);
    let model = Model {
        boundaries: vec![Boundary {
            name: "ground".to_owned(),
            target: Target::Nodes(ground.clone()),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        mesh,
        materials: vec![Material { youngs_modulus: 1e8, friction: 0.3, ..granite() }],
        gravity: [0.0, -9.81],
        gravity_schedule: Schedule::Ramp(0.02),
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    let steps = (0.1 / run.time_step()) as u64;
    run.advance(steps).expect("steps");
    let probes = [
        Probe::ContactForce([vec![1], vec![0]]),
        Probe::ContactForce([vec![0], vec![1]]),
        Probe::ContactForce([vec![0], vec![2, 3]]),
        Probe::Reaction(ground),
    ];
    let found = run.measure(&probes);
    let weight = 2700.0 * 9.81 * 0.2 * 0.2;
    assert!(
        (found[0][1] / -weight - 1.0).abs() < 1e-3 && found[0][0].abs() < 1e-3 * weight,
        "{found:?} {weight}"
    );
    assert_eq!(found[1], [-found[0][0], -found[0][1]]);
    assert_eq!(found[2], [0.0, 0.0]);
    let whole = weight + 2700.0 * 9.81 * 0.6 * 0.1;
    assert!((found[3][1] / whole - 1.0).abs() < 1e-3, "{found:?} {whole}");
}

/// Surfaces that touch under initial stress carry it: the force between two blocks is the stress times their
/// surface.
#[test]
fn initial_stress_between_bodies_is_a_contact_force() {
    let mesh = together(&[rectangle([0.0; 2], [0.2, 0.1], 4, 2), rectangle([0.0, 0.1], [0.2, 0.2], 3, 2)]);
    let outer = |y: f64| nodes_where(&mesh, |node| (node[1] - y).abs() < 1e-12);
    let hold = |name: &str, nodes| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(nodes),
        load: Load::Velocity([Some(0.0); 2]),
        schedule: Schedule::Constant,
    };
    let boundaries = vec![hold("bottom", outer(0.0)), hold("top", outer(0.2))];
    let count = mesh.elements.len();
    let model = Model {
        stresses: vec![[[0.0, 0.0], [0.0, -2e6]]; count],
        boundaries,
        materials: vec![granite()],
        mesh,
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let found = run.measure(&[Probe::ContactForce([vec![1], vec![0]])]);
    assert!((found[0][1] / -0.4e6 - 1.0).abs() < 1e-9 && found[0][0].abs() < 1e-3, "{found:?}");
}

/// Points outside of all elements are found up to a quarter of an element away, for outlines that are curved.
#[test]
fn points_are_found_near_elements_only() {
    let mesh = together(&[rectangle([0.0; 2], [0.4, 0.4], 4, 4), rectangle([1.0, 0.0], [1.4, 0.4], 4, 4)]);
    let at = |point: [f64; 2]| MaterialPoint::at(&mesh, point, |_| true);
    // A node belongs to the first of its elements.
    let first = (0..).zip(&mesh.elements).find(|(_, nodes)| nodes.contains(&7)).map(|(element, _)| element);
    assert_eq!(at(mesh.nodes[7]).map(|point| point.element), first);
    assert!(at([0.2, 0.42]).is_some() && at([0.2, 0.43]).is_none() && at([0.7, 0.2]).is_none());
    let weights = at([1.23, 0.41]).expect("near the second body").weights;
    assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(MaterialPoint::at(&mesh, [0.2, 0.2], |element| mesh.bodies[element as usize] == 1), None);
}

/// Measures a model on ranks, and compares to the last bit.
macro_rules! same_on_ranks {
    ($model:expr, $dimensions:literal, $corners:literal, $parts:expr) => {{
        let model: Model<$dimensions, $corners> = $model;
        let mesh = &model.mesh;
        let every_third: Vec<u32> = (0..mesh.elements.len() as u32).step_by(3).collect();
        let corner = |element: u32| MaterialPoint {
            element,
            weights: std::array::from_fn(|k| {
                [0.1, 0.2, 0.3, 0.4][k] + [0.4, 0.0][$dimensions - 2] * f64::from(u8::from(k == 0))
            }),
        };
        let last = mesh.elements.len() as u32 - 1;
        let bodies: Vec<u32> = (0..=mesh.bodies.iter().copied().max().unwrap_or(0)).collect();
        let mut probes = vec![
            Probe::Stress(every_third.clone()),
            Probe::Strain(every_third.clone()),
            Probe::Velocity(every_third),
            Probe::Stress(vec![last]),
            Probe::PointVelocity(corner(last / 2)),
            Probe::Gauge { ends: [corner(0), corner(last)], span: vec![0.1; $dimensions] },
            Probe::ContactForce([vec![0], bodies[1..].to_vec()]),
            Probe::ContactForce([bodies[1..].to_vec(), vec![0]]),
            Probe::Reaction((0..mesh.nodes.len() as u32).step_by(2).collect()),
        ];
        probes.extend(model.rigid.iter().map(|&body| Probe::RigidBody(body)));
        let boundaries = 0..model.boundaries.len();
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        let mut expected = Vec::new();
        for &steps in $parts {
            whole.advance(steps).expect("steps");
            expected.push(whole.measure(&probes));
        }
        let moments: Vec<_> = boundaries.clone().map(|boundary| whole.moment(boundary)).collect();
        for size in [1, 2, 3, 5] {
            threads::run(size, |communicator: &dyn Communicator| {
                if communicator.rank() > 0 {
                    return follow(communicator, 1).expect("threads");
                }
                let run = Simulation::new(model.clone(), 1).expect("a model");
                let mut run = Leader::new(communicator, run, 1).expect("threads");
                for (steps, expected) in $parts.iter().zip(&expected) {
                    run.advance(*steps).expect("steps");
                    assert_eq!(run.measure(&probes), *expected, "{size} ranks, step {}", run.steps());
                    assert_eq!(run.measure(&probes[..1]), expected[..1]);
                }
                assert_eq!(boundaries.clone().map(|at| run.moment(at)).collect::<Vec<_>>(), moments);
            });
        }
        // A run that is resumed measures the same after its next step.
        let mut first = Simulation::new(model.clone(), 1).expect("a model");
        first.advance($parts.iter().sum::<u64>() - 7).expect("steps");
        let mut resumed = Simulation::resume(model.clone(), first.state(), 1).expect("a state");
        resumed.advance(7).expect("steps");
        let found = resumed.measure(&probes);
        assert_eq!(Some(&found), expected.last());
        found
    }};
}

#[test]
fn a_crash_is_measured_the_same_on_ranks_and_after_a_resume() {
    let plane = same_on_ranks!(crate::resume::crash(Insertion::Adaptive), 2, 3, &[1, 299, 700, 200]);
    let space = same_on_ranks!(crate::space::crash(Insertion::Adaptive), 3, 4, &[1, 399, 200]);
    for found in [plane, space] {
        assert!(found.iter().flatten().all(|value| value.is_finite()), "{found:?}");
        assert!(found[0][0] != 0.0 && found[6].iter().any(|force| *force != 0.0), "{found:?}");
        let back: Vec<f64> = found[7].iter().map(|force| -force).collect();
        assert_eq!(found[6], back);
    }
}

#[test]
fn stressed_blocks_are_measured_the_same_on_ranks() {
    let _ = same_on_ranks!(crate::stress::shaken(Insertion::Adaptive), 2, 3, &[1, 99, 150]);
}

#[test]
fn rigid_bodies_are_measured_the_same_on_ranks_and_after_a_resume() {
    let plane = same_on_ranks!(crate::rigid::blocks(), 2, 3, &[1, 299, 700, 600]);
    assert!(plane[9..].iter().flatten().all(|value| value.is_finite()), "{plane:?}");
    assert!(plane.len() == 12 && plane[9..].iter().all(|motion| motion[4] != 0.0), "{plane:?}");
    let space = same_on_ranks!(crate::rigid::blocks_in_space(), 3, 4, &[1, 150, 70]);
    assert!(space[9].len() == 12 && space[9].iter().all(|value| value.abs() > 0.0), "{space:?}");
}

/// Advances to a time, s.
fn to(run: &mut Simulation, time: f64) {
    run.advance(((time - run.time()) / run.time_step()).ceil() as u64).expect("steps");
}

/// Two halves with a joint between them: a pressure on the upper one, Pa, and a velocity of it along x, m/s.
fn sheared(set: JointSet, pressure: f64, speed: f64) -> Model {
    let mut model = halves(set, 0.02, 10);
    model.plane = Plane::Strain;
    let edges = top_edges(&model);
    let moved = nodes_where(&model.mesh, |[_, y]| y > 0.101);
    let boundary =
        |name: &str, target, load, schedule| Boundary { name: name.to_owned(), target, load, schedule };
    model.boundaries.push(boundary(
        "pressure",
        Target::Facets(edges),
        Load::Pressure(pressure),
        Schedule::Ramp(3e-4),
    ));
    model.boundaries.push(boundary(
        "shear",
        Target::Nodes(moved),
        Load::Velocity([Some(speed), None]),
        Schedule::Table(vec![[1e-3, 0.0], [2e-3, 1.0]]),
    ));
    model
}

/// Direct shear of a joint set: in each state of its joints, whole, softening, broken, and handed over to
/// contact, the probe gives the pressure, the traction of the boundary that shears, and the travel of the
/// upper half. That goes to the right as seen from the lower half, which is negative.
#[test]
fn direct_shear_of_a_joint_set_is_measured_in_each_state() {
    let strength =
        Strength { cohesion: 1e6, tensile: 0.5e6, friction: 0.6, energy_i: 50.0, energy_ii: 600.0, ..rock() };
    let stiffness = [4e11, 1e11];
    let [normal, shear] = stiffness.map(Some);
    let set = JointSet {
        strength,
        residual_friction: 0.4,
        normal_stiffness: normal,
        shear_stiffness: shear,
        ..open(0.0)
    };
    let pressure = 2e6;
    let model = sheared(set, pressure, 0.5);
    let corner = top_edges(&model)[3][0];
    let mut run = Simulation::new(model, 1).expect("a model");
    let probe = [Probe::JointSet("bedding".to_owned())];
    assert_eq!(probe[0].columns()[1], ("slip", "m"));
    to(&mut run, 9e-4);
    let [opening, slip, normal, _] = run.measure(&probe)[0][..] else { panic!("4 values") };
    assert!((normal / -pressure - 1.0).abs() < 0.01, "{normal}");
    assert!((opening / (-pressure / stiffness[0]) - 1.0).abs() < 0.02, "{opening}");
    assert!(slip.abs() < 1e-3 * opening.abs(), "{slip}");
    // Sums over the samples in each state. The halves swing when the joints break.
    let mut sums = [[0.0; 4]; 4];
    while run.time() < 2.2e-2 {
        run.advance(100).expect("steps");
        let [opening, slip, normal, shear] = run.measure(&probe)[0][..] else { panic!("4 values") };
        let cracks = run.snapshot().cracks;
        let broken = cracks.iter().filter(|crack| crack.time.is_some()).count();
        let state = match (cracks.len(), broken) {
            (0, _) => 0,
            (_, 10) if slip.abs() > 0.4 * 0.02 => 3,
            (_, 10) => 2,
            _ => 1,
        };
        let traction = run.force(0).expect("a boundary")[0] / 0.2;
        let ([travel, _], _) = run.node(corner).expect("a node");
        let at = format!("{state} at {}: {opening} {slip} {normal} {shear} {traction} {travel}", run.time());
        assert!((slip + travel).abs() < 0.02 * travel.abs() + 5e-6, "{at}");
        assert!(opening.abs() < 3e-5, "{at}");
        let [damaged, weighted] = run.measure(&[Probe::Softening])[0][..] else { panic!("2 values") };
        let expected = [0, 1].map(|k| {
            let of = |crack: &Crack| crack.measure * if k == 0 { 1.0 } else { crack.damage };
            cracks.iter().map(of).sum::<f64>()
        });
        assert!((damaged - expected[0]).abs() < 1e-12 && (weighted - expected[1]).abs() < 1e-12, "{at}");
        let terms = [1.0, normal, shear, traction];
        sums[state].iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    for (state, [count, normal, shear, traction]) in sums.into_iter().enumerate() {
        let means = [normal, shear, traction].map(|sum| sum / count);
        assert!(count > 3.0, "{state}: {sums:?}");
        assert!((means[0] / -pressure - 1.0).abs() < 0.02, "{state}: {means:?}");
        assert!((means[1] - means[2]).abs() < 0.01 * pressure, "{state}: {means:?}");
        assert!(state < 2 || (means[1] / (-0.4 * pressure) - 1.0).abs() < 0.03, "{state}: {means:?}");
    }
}

/// Moves the part above a joint set that is open away from the rest, without stress, and asserts that the
/// probe gives its path.
macro_rules! parts_along {
    ($model:expr, $dimensions:literal, $middle:expr, $velocity:expr, $expected:expr) => {{
        let mut run = Simulation::new($model, 2).expect("a model");
        run.advance(1).expect("a step");
        let snapshot = run.snapshot();
        let above = |nodes: &[u32]| {
            nodes.iter().map(|&node| snapshot.positions[node as usize][$dimensions - 1]).fold(0.0, f64::max)
                > $middle
        };
        let nodes: std::collections::BTreeSet<u32> =
            snapshot.elements.iter().filter(|nodes| above(&nodes[..])).flatten().copied().collect();
        let nodes: Vec<u32> = nodes.into_iter().collect();
        let before = run.time();
        run.set_velocities(&nodes, &vec![$velocity; nodes.len()]).expect("velocities");
        run.advance(500).expect("steps");
        let found =
            run.measure(&[Probe::JointSet("bedding".to_owned()), Probe::JointSet("other".to_owned())]);
        for (found, expected) in found[0].iter().zip($expected) {
            let expected = expected * (run.time() - before);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        assert!(found[0][2..].iter().all(|stress| stress.abs() < 1e-3), "{found:?}");
        assert!(found[1].iter().all(|value| value.is_nan()), "{found:?}");
    }};
}

#[test]
fn sides_of_a_joint_set_that_part_are_measured_after_any_travel() {
    let set = JointSet { open: true, ..open(0.5) };
    let model = Model { boundaries: Vec::new(), ..halves(set.clone(), 0.1, 4) };
    parts_along!(model, 2, 0.1 + 1e-9, [3.0, 5.0], [5.0, -3.0]);
    let mesh = crate::space::cuboid([0.0; 3], [0.2; 3], [2, 2, 2]);
    let on = |node: &u32| (mesh.nodes[*node as usize][2] - 0.1).abs() < 1e-9;
    let faces = mesh.elements.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]]);
    let faces: Vec<[u32; 3]> = faces.filter(|face| face.iter().all(on)).collect();
    let mut model = Model { materials: vec![granite()], joint_sets: vec![set], mesh, ..Model::default() };
    assert_eq!(model.add_joints(0, &faces), 8);
    parts_along!(model, 3, 0.1 + 1e-9, [3.0, 4.0, 7.0], [7.0, 5.0]);
}

/// Means over joint sets are the same on ranks to the last bit, also after the two sides of joints have moved
/// to different ranks, and after a resume.
#[test]
fn joint_sets_are_measured_the_same_on_ranks() {
    let mut crash = crate::joint_sets::crash(Insertion::Adaptive);
    crash.joint_sets[1].name = "cross".to_owned();
    let mut parted = halves(JointSet { open: true, ..open(0.5) }, 0.1, 8);
    parted.velocities =
        parted.mesh.nodes.iter().map(|[_, y]| [0.0, if *y > 0.1001 { 60.0 } else { 0.0 }]).collect();
    parted.materials[0].damping = 0.1;
    for (model, parts, least) in [(crash, [1, 299, 900], -1.0), (parted, [1, 499, 1500], 1e-3)] {
        let named = |set: &JointSet| Probe::JointSet(set.name.clone());
        let sets = model.joint_sets.iter().map(named);
        let probes = &sets.chain([Probe::Softening]).collect::<Vec<_>>();
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        let mut expected = Vec::new();
        for steps in parts {
            whole.advance(steps).expect("steps");
            expected.push(whole.measure(probes));
        }
        assert!(expected[2].iter().flatten().all(|value| value.is_finite()), "{expected:?}");
        let most = expected[2].iter().map(|values| values[0]).fold(0.0, f64::max);
        assert!(most > least, "{expected:?}");
        // The lengths of the joints of a set that is open from the beginning do not count.
        let [damaged, weighted] = expected[2][model.joint_sets.len()][..] else { panic!("2 values") };
        let broken: f64 = whole.crack_lengths().iter().sum();
        let is_open = model.joint_sets[0].open;
        assert!(if is_open {
            damaged == 0.0
        } else {
            damaged > weighted && weighted > broken && broken > 0.0
        });
        for size in [1, 2, 3, 5] {
            threads::run(size, |communicator: &dyn Communicator| {
                if communicator.rank() > 0 {
                    return follow(communicator, 1).expect("threads");
                }
                let run = Simulation::new(model.clone(), 1).expect("a model");
                let mut run = Leader::new(communicator, run, 1).expect("threads");
                for (steps, expected) in parts.iter().zip(&expected) {
                    run.advance(*steps).expect("steps");
                    assert_eq!(run.measure(probes), *expected, "{size} ranks, step {}", run.steps());
                }
            });
        }
        let mut first = Simulation::new(model.clone(), 1).expect("a model");
        first.advance(parts.iter().sum::<u64>() - 7).expect("steps");
        let mut resumed = Simulation::resume(model, first.state(), 3).expect("a state");
        resumed.advance(7).expect("steps");
        assert_eq!(resumed.measure(probes), expected[2]);
    }
}
