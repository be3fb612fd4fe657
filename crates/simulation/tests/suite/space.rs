//! Bodies of tetrahedra: elasticity, waves, collisions, fracture, the same bits.

use crate::common::*;
use fdem_simulation::*;

pub(crate) type Solid = Mesh<3, 4>;

/// A box of `cells` cells along each axis, each of six tetrahedra around its diagonal.
pub(crate) fn cuboid(min: [f64; 3], max: [f64; 3], cells: [usize; 3]) -> Solid {
    let number = |at: [usize; 3]| ((at[2] * (cells[1] + 1) + at[1]) * (cells[0] + 1) + at[0]) as u32;
    let mut nodes = Vec::new();
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let share =
                    [i as f64 / cells[0] as f64, j as f64 / cells[1] as f64, k as f64 / cells[2] as f64];
                nodes.push([0, 1, 2].map(|axis| min[axis] + share[axis] * (max[axis] - min[axis])));
            }
        }
    }
    let mut elements = Vec::new();
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                for (order, odd) in [
                    ([0, 1, 2], false),
                    ([1, 2, 0], false),
                    ([2, 0, 1], false),
                    ([0, 2, 1], true),
                    ([1, 0, 2], true),
                    ([2, 1, 0], true),
                ] {
                    let mut at = [i, j, k];
                    let mut element = [number(at); 4];
                    for (corner, axis) in (1..).zip(order) {
                        at[axis] += 1;
                        element[corner] = number(at);
                    }
                    if odd {
                        element.swap(0, 1);
                    }
                    elements.push(element);
                }
            }
        }
    }
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// Turned about an axis aslant to all others, and moved.
fn turned(mesh: &Solid, angle: f64, by: [f64; 3]) -> Solid {
    let (sin, cos) = angle.sin_cos();
    let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
    let rotated = |p: [f64; 3]| {
        let along: f64 = (0..3).map(|k| axis[k] * p[k]).sum();
        let across = [
            axis[1] * p[2] - axis[2] * p[1],
            axis[2] * p[0] - axis[0] * p[2],
            axis[0] * p[1] - axis[1] * p[0],
        ];
        std::array::from_fn(|k| cos * p[k] + sin * across[k] + (1.0 - cos) * along * axis[k] + by[k])
    };
    Mesh { nodes: mesh.nodes.iter().map(|&node| rotated(node)).collect(), ..mesh.clone() }
}

fn nodes_at(mesh: &Solid, at: impl Fn([f64; 3]) -> bool) -> Vec<u32> {
    (0..mesh.nodes.len() as u32).filter(|&node| at(mesh.nodes[node as usize])).collect()
}

fn moved(name: &str, nodes: Vec<u32>, velocity: [Option<f64>; 3], schedule: Schedule) -> Boundary<3> {
    Boundary { name: name.to_owned(), target: Target::Nodes(nodes), load: Load::Velocity(velocity), schedule }
}

#[test]
fn a_body_falls_and_spins_freely() {
    let mesh = turned(&cuboid([0.0; 3], [0.1, 0.2, 0.3], [2, 3, 4]), 0.7, [1.0, 2.0, 3.0]);
    let spin = |p: &[f64; 3]| [-20.0 * (p[1] - 2.0), 20.0 * (p[0] - 1.0), 3.0];
    let velocities = mesh.nodes.iter().map(spin).collect();
    let model = Model {
        mesh,
        velocities,
        materials: vec![granite()],
        gravity: [0.0, 0.0, -9.81],
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let before = run.energies();
    run.advance(2000).expect("steps");
    let energies = run.energies();
    assert!(energies.error().abs() < 1e-6, "{energies:?}");
    let work = 0.5 * energies.external + before.kinetic;
    assert!(energies.external.abs() > 0.0 && work.is_finite());
    assert_eq!(run.counts().contacts, 0);
}

/// Under a uniform strain every element has the stress of Hooke's law, so that the forces on the sides are
/// those of the stress.
#[test]
fn a_block_that_is_stretched_pulls_with_the_stress_of_hooke() {
    let mesh = cuboid([0.0; 3], [0.1, 0.1, 0.2], [2, 2, 4]);
    let material = Material { poissons_ratio: 0.25, damping: 0.5, ..granite() };
    let strain = 1e-4;
    let (e, nu, goal) = (material.youngs_modulus, material.poissons_ratio, 0.2 * strain);
    let on = |axis: usize, at: f64| nodes_at(&mesh, |p| (p[axis] - at).abs() < 1e-9);
    let free = [None; 3];
    let still = |axis: usize| std::array::from_fn(|k| if k == axis { Some(0.0) } else { free[k] });
    let boundaries = vec![
        moved("x", on(0, 0.0), still(0), Schedule::Constant),
        moved("y", on(1, 0.0), still(1), Schedule::Constant),
        moved("z", on(2, 0.0), still(2), Schedule::Constant),
        Boundary {
            name: "top".to_owned(),
            target: Target::Nodes(on(2, 0.2)),
            load: Load::Displacement([None, None, Some(goal)]),
            schedule: Schedule::Ramp(2e-3),
        },
    ];
    let model = Model { mesh: mesh.clone(), materials: vec![material], boundaries, ..Model::default() };
    let mut run = Simulation::new(model, 1).expect("a model");
    while run.time() < 4e-3 {
        run.advance(50).expect("steps");
    }
    let force = run.force(3).expect("a boundary");
    let expected = e * strain * 0.01;
    assert!((force[2] / expected - 1.0).abs() < 1e-3, "{force:?} {expected}");
    // The sides draw in by ν.
    let corner = nodes_at(&mesh, |p| p == [0.1, 0.1, 0.2])[0];
    let (displacement, _) = run.node(corner).expect("a node");
    for axis in 0..2 {
        assert!((displacement[axis] / (-nu * strain * 0.1) - 1.0).abs() < 1e-3, "{displacement:?}");
    }
    let energies = run.energies();
    assert!((energies.strain / (0.5 * e * strain * strain * 0.002) - 1.0).abs() < 2e-3, "{energies:?}");
    assert!(energies.error().abs() < 1e-4);
}

/// Gravity, pressure and traction on faces put the same force into a body: it hangs in equilibrium.
#[test]
fn loads_on_faces_are_in_equilibrium() {
    let mesh = cuboid([0.0; 3], [0.2, 0.1, 0.1], [3, 2, 2]);
    let faces = |axis: usize, at: f64, outwards: f64| -> Vec<[u32; 3]> {
        let on = |node: u32| (mesh.nodes[node as usize][axis] - at).abs() < 1e-9;
        let all = mesh.elements.iter().flat_map(|&[a, b, c, d]| [[a, c, b], [a, b, d], [b, c, d], [a, d, c]]);
        let found: Vec<[u32; 3]> = all.filter(|face| face.iter().all(|&node| on(node))).collect();
        assert!(found.len() > 3 && outwards != 0.0);
        found
    };
    let pressure = 3e5;
    let weight = 2700.0 * 0.002 * 9.81;
    let boundaries = vec![
        Boundary {
            name: "left".to_owned(),
            target: Target::Facets(faces(0, 0.0, -1.0)),
            load: Load::Pressure(pressure),
            schedule: Schedule::Constant,
        },
        Boundary {
            name: "right".to_owned(),
            target: Target::Facets(faces(0, 0.2, 1.0)),
            load: Load::Traction([-pressure, 0.0, 0.0]),
            schedule: Schedule::Constant,
        },
        Boundary {
            name: "above".to_owned(),
            target: Target::Nodes(nodes_at(&mesh, |p| p[2] > 0.0999)),
            load: Load::Force([0.0, 0.0, weight]),
            schedule: Schedule::Constant,
        },
    ];
    let model = Model {
        mesh: mesh.clone(),
        materials: vec![granite()],
        boundaries,
        gravity: [0.0, 0.0, -9.81],
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let forces = [0, 1, 2].map(|boundary| run.force(boundary).expect("a boundary"));
    assert!((forces[0][0] / (pressure * 0.01) - 1.0).abs() < 1e-9, "{forces:?}");
    assert!((forces[1][0] / (-pressure * 0.01) - 1.0).abs() < 1e-9, "{forces:?}");
    assert!((forces[2][2] / weight - 1.0).abs() < 1e-9, "{forces:?}");
    run.advance(3000).expect("steps");
    let total: [f64; 3] = std::array::from_fn(|axis| {
        let momentum = |node: u32| run.node(node).expect("a node").1[axis];
        (0..mesh.nodes.len() as u32).map(momentum).sum::<f64>() / mesh.nodes.len() as f64
    });
    assert!(total.iter().all(|v| v.abs() < 1e-3), "{total:?}");
    assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
}

/// Two turned blocks that meet and part, without friction and damping.
fn collision(friction: f64) -> Model<3, 4> {
    let one = cuboid([-0.05; 3], [0.05; 3], [2, 2, 2]);
    let other = turned(&one, 1.1, [0.03, 0.12, 0.02]);
    let velocities =
        [vec![[0.0, 5.0, 0.0]; one.nodes.len()], vec![[0.0, -5.0, 1.0]; other.nodes.len()]].concat();
    Model {
        mesh: together(&[one, other]),
        velocities,
        materials: vec![Material { friction, poissons_ratio: 0.2, ..granite() }],
        time: TimeOptions { safety: 0.3, ..TimeOptions::default() },
        ..Model::default()
    }
}

#[test]
fn blocks_that_collide_keep_their_energy() {
    for friction in [0.0, 0.6] {
        let mut run = Simulation::new(collision(friction), 1).expect("a model");
        run.advance(1).expect("a step");
        let before = run.energies();
        let (mut touched, mut stored) = (0, 0.0_f64);
        while run.time() < 2e-3 {
            run.advance(20).expect("steps");
            touched = touched.max(run.counts().contacts);
            stored = stored.max(run.energies().contact);
        }
        let energies = run.energies();
        assert!(touched > 0 && stored > 1e-3 * before.kinetic, "{touched} {stored}");
        assert_eq!((run.counts().contacts, energies.contact), (0, 0.0), "they have parted");
        assert!(energies.error().abs() < 1e-3, "{energies:?}");
        assert!(energies.kinetic + energies.strain + energies.friction > 0.999 * before.kinetic);
        assert_eq!(energies.friction > 1e-3 * before.kinetic, friction > 0.0, "{energies:?}");
        // The second body was struck: it does not fly on as it came.
        let last = run.model().mesh.nodes.len() as u32 - 1;
        assert!(run.node(last).expect("a node").1[1] > -4.0);
    }
}

/// A bar that is pulled apart slowly. Only the joints in the middle, between the two materials, can break.
fn tension(insertion: Insertion) -> Simulation<3, 4> {
    let mut mesh = cuboid([0.0; 3], [0.01, 0.01, 0.04], [1, 1, 4]);
    for element in 0..mesh.elements.len() {
        let above = mesh.elements[element].iter().any(|&node| mesh.nodes[node as usize][2] > 0.0201);
        mesh.materials[element] = u32::from(above);
    }
    let half = Material { youngs_modulus: 30e9, damping: 0.2, ..granite() };
    let speed = 0.001;
    let model = Model {
        velocities: mesh.nodes.iter().map(|p| [0.0, 0.0, speed * p[2] / 0.04]).collect(),
        materials: vec![half.clone(), half],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.0,
            penalty: None,
            strength: Some(Strength { energy_i: 3.0, ..rock() }),
        }],
        boundaries: vec![
            moved("bottom", nodes_at(&mesh, |p| p[2] < 1e-9), [None, None, Some(0.0)], Schedule::Constant),
            moved(
                "top",
                nodes_at(&mesh, |p| p[2] > 0.04 - 1e-9),
                [None, None, Some(speed)],
                Schedule::Constant,
            ),
        ],
        mesh,
        fracture: FractureOptions { insertion, joint_penalty: 20.0, ..FractureOptions::default() },
        ..Model::default()
    };
    Simulation::new(model, 1).expect("a model")
}

#[test]
fn tension_peaks_at_the_strength_and_dissipates_the_fracture_energy() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let mut run = tension(insertion);
        let (mut peak, area) = (0.0_f64, 1e-4);
        while run.counts().broken == 0 {
            run.advance(1).expect("a step");
            peak = peak.max(run.force(1).expect("a boundary")[2] / area);
            assert!(run.time() < 0.1, "{insertion:?}: it never breaks");
        }
        let at_break = run.time();
        while run.time() < 1.2 * at_break {
            run.advance(50).expect("steps");
        }
        let energies = run.energies();
        assert!((peak / 1e6 - 1.0).abs() < 0.01, "{insertion:?}: {peak}");
        // Two faces in the middle.
        assert_eq!((run.counts().broken, run.counts().joints), (2, 0), "{insertion:?}");
        assert!((run.crack_lengths()[0] / area - 1.0).abs() < 1e-9, "{:?}", run.crack_lengths());
        assert!((energies.cohesive / (3.0 * area) - 1.0).abs() < 0.01, "{insertion:?}: {energies:?}");
        assert!(energies.error().abs() < 1e-2, "{insertion:?}: {energies:?}");
    }
}

/// A bar that is pressed, sheared until its joints break, and pulled apart. Joints that were inserted under
/// pressure press until the pressure is gone, not only until their gap is 0: no force jumps, and the energy
/// balance holds.
#[test]
fn a_joint_that_broke_under_pressure_lets_go_without_a_jump() {
    let mut mesh = cuboid([0.0; 3], [0.01, 0.01, 0.04], [1, 1, 4]);
    for element in 0..mesh.elements.len() {
        let above = mesh.elements[element].iter().any(|&node| mesh.nodes[node as usize][2] > 0.0201);
        mesh.materials[element] = u32::from(above);
    }
    let half = Material { youngs_modulus: 30e9, damping: 0.2, ..granite() };
    let strength = Strength { cohesion: 1e6, energy_ii: 2.0, ..rock() };
    let table = |rows: &[[f64; 2]]| Schedule::Table(rows.iter().map(|[t, f]| [1e-4 * t, *f]).collect());
    let across = table(&[[2.0, 0.0], [3.0, 1.0], [8.0, 1.0], [9.0, 0.0]]);
    let along = table(&[[0.0, 0.0], [0.5, -1.0], [1.5, -1.0], [2.0, 0.0], [9.0, 0.0], [9.5, 1.0]]);
    let top = nodes_at(&mesh, |p| p[2] > 0.04 - 1e-9);
    let model = Model {
        materials: vec![half.clone(), half],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.1,
            penalty: None,
            strength: Some(Strength { friction: 0.1, ..strength }),
        }],
        boundaries: vec![
            moved("bottom", nodes_at(&mesh, |p| p[2] < 1e-9), [Some(0.0); 3], Schedule::Constant),
            moved("along", top.clone(), [None, None, Some(0.04)], along),
            moved("across", top, [Some(0.03), Some(0.0), None], across),
        ],
        mesh,
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    let (mut most, mut before, mut jump, mut drift) = (0.0_f64, 0.0, 0.0_f64, 0.0_f64);
    while run.time() < 1.2e-3 {
        run.advance(1).expect("a step");
        let now = run.force(0).expect("a boundary")[2];
        if run.counts().broken == 2 {
            jump = jump.max((now - before).abs());
        }
        (most, before) = (most.max(now), now);
        drift = drift.max(run.energies().error().abs());
    }
    assert_eq!(run.counts().broken, 2);
    assert!(most > 100.0 && before.abs() < 1e-2 * most, "{most} {before}");
    assert!(jump < 0.02 * most, "{jump} of {most}");
    assert!(drift < 1e-5, "{drift}");
}

/// A turned block that falls on another and breaks.
pub(crate) fn crash(insertion: Insertion) -> Model<3, 4> {
    let ground = cuboid([0.0, 0.0, -0.05], [0.2, 0.2, 0.0], [4, 4, 2]);
    let mut block = turned(&cuboid([-0.04; 3], [0.04; 3], [3, 3, 3]), 0.9, [0.1, 0.1, 0.0]);
    let lowest = block.nodes.iter().map(|node| node[2]).fold(f64::INFINITY, f64::min);
    block.nodes.iter_mut().for_each(|node| node[2] += 1e-4 - lowest);
    let velocities =
        [vec![[0.0; 3]; ground.nodes.len()], vec![[1.0, 0.5, -30.0]; block.nodes.len()]].concat();
    let strength = Strength { tensile: 2e6, cohesion: 4e6, energy_i: 5.0, energy_ii: 20.0, ..rock() };
    Model {
        boundaries: vec![moved(
            "floor",
            nodes_at(&ground, |p| p[2] < -0.0499),
            [Some(0.0); 3],
            Schedule::Constant,
        )],
        mesh: together(&[ground, block]),
        velocities,
        materials: vec![Material { strength: Some(strength), friction: 0.5, damping: 0.05, ..granite() }],
        gravity: [0.0, 0.0, -9.81],
        fracture: FractureOptions { insertion, joint_penalty: 100.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

#[test]
fn a_crash_is_the_same_for_any_threads_and_after_a_restart() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crash(insertion);
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        whole.advance(200).expect("steps");
        let mut saved = postcard::to_allocvec(&whole.state()).expect("bytes");
        for (threads, steps) in [(1, 300), (3, 300)] {
            whole.advance(steps).expect("steps");
            let state: State<3, 4> = postcard::from_bytes(&saved).expect("a state");
            let mut resumed = Simulation::resume(model.clone(), state, threads).expect("the same model");
            resumed.advance(steps).expect("steps");
            assert_eq!(resumed.energies(), whole.energies());
            saved = postcard::to_allocvec(&whole.state()).expect("bytes");
            assert!(postcard::to_allocvec(&resumed.state()).expect("bytes") == saved, "{insertion:?}");
        }
        let (counts, energies) = (whole.counts(), whole.energies());
        assert!(
            counts.broken > 10 && counts.contacts > 5,
            "{insertion:?}: it should have broken: {counts:?}"
        );
        assert!(energies.error().abs() < 0.01, "{insertion:?}: {energies:?}");
    }
}

/// A model that lies 1.3 million times its size away, and the same with its middle at 0. All coordinates are
/// multiples of 2⁻²⁵ m, so that they are exact in both places.
#[test]
fn a_model_far_away_does_the_same_to_the_last_bit() {
    let grid = 2.0_f64.powi(24);
    let mut near = crash(Insertion::Adaptive);
    near.mesh.nodes.iter_mut().flatten().for_each(|x| *x = (*x * grid).round() / grid);
    for axis in 0..3 {
        let along = || near.mesh.nodes.iter().map(|node| node[axis]);
        let middle =
            0.5 * (along().fold(f64::INFINITY, f64::min) + along().fold(f64::NEG_INFINITY, f64::max));
        near.mesh.nodes.iter_mut().for_each(|node| node[axis] -= middle);
    }
    let offset = [2.0_f64.powi(18), -(2.0_f64.powi(18)), 2.0_f64.powi(18)];
    let mut far = near.clone();
    for (axis, by) in offset.into_iter().enumerate() {
        far.mesh.nodes.iter_mut().for_each(|node| node[axis] += by);
    }
    let [mut near, mut far] = [near, far].map(|model| Simulation::new(model, 1).expect("a model"));
    for _ in 0..3 {
        near.advance(250).expect("steps");
        far.advance(250).expect("steps");
        let (a, b) = (near.snapshot(), far.snapshot());
        // Not assert_eq, which would print all of them.
        assert!((&a.displacements, &a.velocities) == (&b.displacements, &b.velocities));
        assert!((&a.stresses, &a.damage) == (&b.stresses, &b.damage));
        assert_eq!((near.energies(), near.force(0)), (far.energies(), far.force(0)));
    }
    let counts = near.counts();
    assert!(counts.broken > 10 && counts.contacts > 5, "it should have broken: {counts:?}");
}

/// Two blocks on each other under a stress that both have rest, and their contact carries it.
#[test]
fn blocks_under_matching_stress_stay_at_rest() {
    let stress = [[-2e6, 0.0, 0.3e6], [0.0, -3e6, 0.5e6], [0.3e6, 0.5e6, -5e6]];
    let one = cuboid([0.0; 3], [0.1, 0.1, 0.1], [2, 2, 2]);
    // The nodes do not match.
    let other = cuboid([0.0, 0.0, 0.1], [0.1, 0.1, 0.2], [3, 3, 2]);
    let mesh = together(&[one, other]);
    let mut boundaries = Vec::new();
    for (axis, at, sign) in
        [(0, 0.0, -1.0), (0, 0.1, 1.0), (1, 0.0, -1.0), (1, 0.1, 1.0), (2, 0.0, -1.0), (2, 0.2, 1.0)]
    {
        let on = |node: u32| (mesh.nodes[node as usize][axis] - at).abs() < 1e-9;
        let all = mesh.elements.iter().flat_map(|&[a, b, c, d]| [[a, c, b], [a, b, d], [b, c, d], [a, d, c]]);
        boundaries.push(Boundary {
            name: format!("side {axis} {at}"),
            target: Target::Facets(all.filter(|face| face.iter().all(|&node| on(node))).collect()),
            load: Load::Traction(stress.map(|row| sign * row[axis])),
            schedule: Schedule::Constant,
        });
    }
    let model = Model {
        stresses: vec![stress; mesh.elements.len()],
        materials: vec![Material { poissons_ratio: 0.25, friction: 0.6, ..granite() }],
        mesh,
        boundaries,
        ..Model::default()
    };
    let contacts = InitialContacts::of(&model).expect("a model");
    assert!((contacts.length / 0.01 - 1.0).abs() < 1e-9, "{contacts:?}");
    assert_eq!((contacts.pulled, contacts.slipping, contacts.unlike), (None, None, None));
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1500).expect("steps");
    let energies = run.energies();
    assert!(energies.strain > 0.0 && energies.kinetic < 1e-18 * energies.strain, "{energies:?}");
}

#[test]
fn models_that_are_none_are_refused() {
    let good = cuboid([0.0; 3], [1.0; 3], [1, 1, 1]);
    let model = |mesh: Solid, nu: f64| Model {
        mesh,
        materials: vec![Material { poissons_ratio: nu, ..granite() }],
        ..Model::default()
    };
    assert!(Simulation::new(model(good.clone(), 0.49), 1).is_ok());
    let refused = |model| Simulation::<3, 4>::new(model, 1).err();
    assert!(matches!(refused(model(good.clone(), 0.5)), Some(ModelError::OutOfRange { .. })));
    let mut inverted = good.clone();
    inverted.elements[2].swap(0, 1);
    assert!(matches!(refused(model(inverted, 0.2)), Some(ModelError::Area { element: 2, .. })));
    let mut loose = good;
    loose.nodes.push([9.0; 3]);
    assert_eq!(refused(model(loose, 0.2)), Some(ModelError::LooseNode { node: 8 }));
}
