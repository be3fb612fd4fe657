//! Sets of joints with their own laws.

use crate::common::*;
use fdem_simulation::*;

/// A set without strength, with friction alone.
pub(crate) fn open(friction: f64) -> JointSet {
    JointSet {
        name: "bedding".to_owned(),
        strength: Strength { tensile: 0.0, cohesion: 0.0, friction, energy_i: 0.0, energy_ii: 0.0, ..rock() },
        residual_friction: friction,
        dilation: 0.0,
        dilation_slip: None,
        normal_stiffness: None,
        shear_stiffness: None,
        open: false,
    }
}

/// The edges of a mesh along a height.
pub(crate) fn along_height(mesh: &Mesh, height: f64) -> Vec<[u32; 2]> {
    let on = |node: u32| (mesh.nodes[node as usize][1] - height).abs() < 1e-9;
    let edges = mesh.elements.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.filter(|edge| edge.iter().all(|&node| on(node))).collect()
}

/// One body of 0.2 m by 0.2 m, cut by a joint along y = 0.1; the lower half is held.
fn cut(set: JointSet) -> Model {
    halves(set, 0.1, 4)
}

/// Two halves of this height with a joint between them at y = 0.1, with the given number of elements along
/// the joint.
pub(crate) fn halves(set: JointSet, height: f64, count: usize) -> Model {
    let mesh = rectangle([0.0, 0.1 - height], [0.2, 0.1 + height], count, 4);
    let held = Boundary {
        name: "below".to_owned(),
        target: Target::Nodes(nodes_where(&mesh, |[_, y]| y < 0.0999)),
        load: Load::Velocity([Some(0.0); 2]),
        schedule: Schedule::Constant,
    };
    let mut model = Model {
        materials: vec![Material { damping: 0.3, friction: 0.9, ..granite() }],
        boundaries: vec![held],
        joint_sets: vec![set],
        mesh,
        ..Model::default()
    };
    let edges = along_height(&model.mesh, 0.1);
    assert_eq!(model.add_joints(0, &edges), count);
    model
}

fn top(model: &Model) -> Vec<u32> {
    let most = model.mesh.nodes.iter().map(|node| node[1]).fold(0.0, f64::max);
    nodes_where(&model.mesh, |[_, y]| y > most - 1e-9)
}

pub(crate) fn top_edges(model: &Model) -> Vec<[u32; 2]> {
    top(model).windows(2).map(|pair| [pair[1], pair[0]]).collect()
}

/// A block on a dipping joint slides if the tangent of the dip is above that of the friction angle, with the
/// acceleration of a rigid block, and stays below. The friction of its material is another one: that of the
/// set also holds after it has slid far, when contacts have taken over.
#[test]
fn a_block_on_a_dipping_joint_slides_above_its_friction_angle() {
    let friction = 0.5_f64;
    for (slope, slides, open_at_start) in
        [(0.45_f64, false, false), (0.6, true, false), (0.45, false, true), (0.6, true, true)]
    {
        let (sin, cos) = slope.atan().sin_cos();
        let gravity = 1000.0;
        let mut model = cut(JointSet { open: open_at_start, ..open(friction) });
        model.gravity = [gravity * sin, -gravity * cos];
        model.gravity_schedule = Schedule::Ramp(2e-4);
        let mut run = Simulation::new(model, 1).expect("a model");
        let to = |run: &mut Simulation, time: f64| {
            let steps = ((time - run.time()) / run.time_step()).ceil() as u64;
            run.advance(steps).expect("steps");
            let snapshot = run.snapshot();
            let (mut sum, mut count) = (0.0, 0.0);
            for (position, velocity) in snapshot.positions.iter().zip(&snapshot.velocities) {
                if position[1] > 0.15 {
                    (sum, count) = (sum + velocity[0], count + 1.0);
                }
            }
            (run.time(), sum / count)
        };
        let (from, first) = to(&mut run, 3e-3);
        let (until, last) = to(&mut run, 1.5e-2);
        if slides {
            let expected = gravity * (sin - friction * cos);
            let found = (last - first) / (until - from);
            assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
        } else {
            assert!(last.abs() < 1e-3, "{last}");
        }
    }
}

/// A block that slides on a joint with dilation rises by the tangent of its angle times the slip, up to the
/// slip where that ends; its friction is that of the set, and the balance of energy holds.
#[test]
fn joints_dilate_as_they_slip() {
    let (dilation, most) = (0.2, 4e-4);
    let set = JointSet { dilation, dilation_slip: Some(most), ..open(0.6) };
    let mut model = halves(set, 0.02, 10);
    model.plane = Plane::Strain;
    let edges = top_edges(&model);
    let moved = nodes_where(&model.mesh, |[_, y]| y > 0.101);
    model.boundaries.push(Boundary {
        name: "pressure".to_owned(),
        target: Target::Facets(edges),
        load: Load::Pressure(1e6),
        schedule: Schedule::Ramp(3e-4),
    });
    model.boundaries.push(Boundary {
        name: "shear".to_owned(),
        target: Target::Nodes(moved),
        load: Load::Velocity([Some(0.1), None]),
        schedule: Schedule::Table(vec![[1e-3, 0.0], [2e-3, 1.0]]),
    });
    let corner = *top(&model).first().expect("a node");
    let mut run = Simulation::new(model, 1).expect("a model");
    let rises = |run: &mut Simulation, time: f64| {
        run.advance(((time - run.time()) / run.time_step()).ceil() as u64).expect("steps");
        let ([x, y], _) = run.node(corner).expect("a node");
        (x, y, -run.force(0).expect("a boundary")[0] / 0.2)
    };
    let (from, low, _) = rises(&mut run, 2.5e-3);
    let (to, high, traction) = rises(&mut run, 4.5e-3);
    let found = (high - low) / (to - from);
    assert!((found / dilation - 1.0).abs() < 0.02, "{found}");
    assert!((traction / 0.6e6 - 1.0).abs() < 0.02, "{traction}");
    let (_, first, _) = rises(&mut run, 8e-3);
    let (_, last, _) = rises(&mut run, 1e-2);
    assert!(
        (first / (dilation * most) - 1.0).abs() < 0.05 && (last - first).abs() < 1e-3 * first,
        "{first} {last}"
    );
    assert!(run.energies().error().abs() < 1e-4, "{:?}", run.energies());
}

/// Direct shear at three normal stresses: the peaks are on the line of cohesion and friction, and the
/// residuals on that of the residual friction.
#[test]
fn direct_shear_gives_cohesion_and_friction() {
    let strength =
        Strength { cohesion: 1e6, tensile: 0.5e6, friction: 0.6, energy_i: 50.0, energy_ii: 300.0, ..rock() };
    let set = JointSet {
        strength,
        residual_friction: 0.4,
        normal_stiffness: Some(4e11),
        shear_stiffness: Some(1e11),
        ..open(0.0)
    };
    let (mut peaks, mut residuals) = (Vec::new(), Vec::new());
    let stresses = [1e6, 2e6, 4e6];
    for stress in stresses {
        // Flat halves: high ones would tilt, and carry another normal stress at their ends.
        let mut model = halves(set.clone(), 0.02, 10);
        model.plane = Plane::Strain;
        // The upper block moves as a whole along x, and is free along y.
        let upper = nodes_where(&model.mesh, |[_, y]| y > 0.099);
        let moved = nodes_where(&model.mesh, |[_, y]| y > 0.101);
        assert!(upper.len() > moved.len());
        let edges = top_edges(&model);
        model.boundaries.push(Boundary {
            name: "pressure".to_owned(),
            target: Target::Facets(edges),
            load: Load::Pressure(stress),
            schedule: Schedule::Ramp(3e-4),
        });
        model.boundaries.push(Boundary {
            name: "shear".to_owned(),
            target: Target::Nodes(moved),
            load: Load::Velocity([Some(0.05), None]),
            schedule: Schedule::Table(vec![[1e-3, 0.0], [2e-3, 1.0]]),
        });
        let mut run = Simulation::new(model, 1).expect("a model");
        let (mut peak, mut last) = (0.0_f64, (0.0, 0.0));
        while run.time() < 2.2e-2 {
            run.advance(5).expect("steps");
            let traction = -run.force(0).expect("a boundary")[0] / 0.2;
            peak = peak.max(traction);
            if run.time() > 2e-2 {
                last = (last.0 + traction, last.1 + 1.0);
            }
        }
        peaks.push(peak);
        residuals.push(last.0 / last.1);
    }
    for ((stress, peak), residual) in stresses.into_iter().zip(&peaks).zip(&residuals) {
        assert!((peak / (1e6 + 0.6 * stress) - 1.0).abs() < 0.02, "{peaks:?}");
        assert!((residual / (0.4 * stress) - 1.0).abs() < 0.05, "{residuals:?}");
    }
}

/// Under pressure and shear below the strength, a joint closes and slides by the traction over its stiffness.
#[test]
fn stiffnesses_are_those_of_the_set() {
    let strength = Strength { cohesion: 1e9, tensile: 1e9, energy_i: 1e8, energy_ii: 1e8, ..rock() };
    for (normal, shear) in [(2e11, 5e10), (5e10, 2e11)] {
        let set =
            JointSet { strength, normal_stiffness: Some(normal), shear_stiffness: Some(shear), ..open(0.3) };
        let mut model = cut(set);
        let traction = [1e6, -2e6];
        let edges = top_edges(&model);
        model.boundaries.push(Boundary {
            name: "load".to_owned(),
            target: Target::Facets(edges),
            load: Load::Traction(traction),
            schedule: Schedule::Ramp(1e-3),
        });
        model.time.local_damping = 0.5;
        let mut run = Simulation::new(model, 1).expect("a model");
        while run.time() < 3e-3 {
            run.advance(100).expect("steps");
        }
        // The mean gap of the joint: that of the two sides of the cut.
        let snapshot = run.snapshot();
        let mesh = &run.model().mesh;
        let (mut gaps, mut count) = ([[0.0; 2]; 2], [0.0; 2]);
        for (element, nodes) in snapshot.elements.iter().enumerate() {
            let middle: f64 =
                mesh.elements[element].iter().map(|&n| mesh.nodes[n as usize][1]).sum::<f64>() / 3.0;
            let side = usize::from(middle > 0.1);
            for (&node, &original) in nodes.iter().zip(&mesh.elements[element]) {
                let [x, y] = mesh.nodes[original as usize];
                if (y - 0.1).abs() < 1e-9 && x > 0.01 && x < 0.19 {
                    let moved = snapshot.displacements[node as usize];
                    gaps[side] = [gaps[side][0] + moved[0], gaps[side][1] + moved[1]];
                    count[side] += 1.0;
                }
            }
        }
        let gap = [0, 1].map(|axis| gaps[1][axis] / count[1] - gaps[0][axis] / count[0]);
        let expected = [traction[0] / shear, traction[1] / normal];
        for axis in 0..2 {
            assert!((gap[axis] / expected[axis] - 1.0).abs() < 0.06, "{gap:?} {expected:?}");
        }
    }
}

/// Closed joints carry the initial stress from the first step on: a body in equilibrium stays at rest.
#[test]
fn a_closed_joint_carries_the_initial_stress() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        for set in
            [open(0.6), JointSet { normal_stiffness: Some(1e10), shear_stiffness: Some(3e9), ..open(0.6) }]
        {
            let mut model = cut(set);
            let edges = top_edges(&model);
            model.stresses = vec![[[-1e6, 0.4e6], [0.4e6, -2e6]]; model.mesh.elements.len()];
            let right = nodes_where(&model.mesh, |[x, _]| !(0.001..0.199).contains(&x));
            model.boundaries.push(Boundary {
                name: "sides".to_owned(),
                target: Target::Nodes(
                    right.into_iter().filter(|&n| model.mesh.nodes[n as usize][1] > 0.09).collect(),
                ),
                load: Load::Velocity([Some(0.0); 2]),
                schedule: Schedule::Constant,
            });
            model.boundaries.push(Boundary {
                name: "load".to_owned(),
                target: Target::Facets(edges),
                load: Load::Traction([0.4e6, -2e6]),
                schedule: Schedule::Constant,
            });
            model.fracture.insertion = insertion;
            let mut run = Simulation::new(model, 1).expect("a model");
            run.advance(200).expect("steps");
            let moved =
                run.snapshot().displacements.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(moved < 1e-12, "{insertion:?}: {moved}");
            assert_eq!(run.counts().broken, 0);
        }
    }
}

/// The falling block of other tests, cut by two joints of two sets that cross each other and end inside.
pub(crate) fn crash(insertion: Insertion) -> Model {
    let mut model = crate::resume::crash(insertion);
    let weak = Strength { tensile: 0.3e6, cohesion: 0.5e6, energy_i: 2.0, energy_ii: 4.0, ..rock() };
    model.joint_sets = vec![
        JointSet { strength: weak, normal_stiffness: Some(2e12), shear_stiffness: Some(7e11), ..open(0.3) },
        JointSet { open: true, ..open(0.2) },
    ];
    let ground = along_height(&model.mesh, -0.025);
    assert!(model.add_joints(0, &ground) > 5);
    // The block has 7 nodes in a row.
    let first = (model.mesh.nodes.len() - 49) as u32;
    let node = |i: u32, j: u32| first + 7 * j + i;
    let level: Vec<[u32; 2]> = (0..5).map(|i| [node(i, 3), node(i + 1, 3)]).collect();
    let upright: Vec<[u32; 2]> = (1..6).map(|j| [node(3, j), node(3, j + 1)]).collect();
    assert_eq!(model.add_joints(1, &level) + model.add_joints(0, &upright), 10);
    model
}

#[test]
fn a_run_with_joint_sets_goes_on_bit_for_bit() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crash(insertion);
        let mut whole = Simulation::new(model.clone(), 2).expect("a model");
        for steps in [0, 7, 300, 700] {
            whole.advance(steps).expect("steps");
            let bytes = postcard::to_allocvec(&whole.state()).expect("bytes");
            let state: State = postcard::from_bytes(&bytes).expect("a state");
            let mut resumed = Simulation::resume(model.clone(), state, 1).expect("the same model");
            let mut on = Simulation::resume(model.clone(), whole.state(), 3).expect("the same model");
            resumed.advance(400).expect("steps");
            on.advance(400).expect("steps");
            assert_eq!(resumed.snapshot(), on.snapshot());
            whole.advance(400).expect("steps");
            assert_eq!(resumed.snapshot(), whole.snapshot());
            assert_eq!(resumed.energies(), whole.energies());
            let parted = |run: &Simulation| (run.counts().broken, run.counts().open, run.crack_lengths());
            assert_eq!(parted(&resumed), parted(&whole));
        }
        assert!(whole.counts().broken > 10 && whole.counts().open == 5, "{:?}", whole.counts());
    }
}

/// A notch that is given as an open joint set is no crack of the run; the crack that grows from it is one.
#[test]
fn open_joints_are_no_cracks() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let mut model = cut(JointSet { open: true, ..open(0.0) });
        // Two of the four edges stay whole.
        let keep: Vec<[u32; 2]> = along_height(&model.mesh, 0.1)
            .into_iter()
            .filter(|edge| edge.iter().all(|&node| model.mesh.nodes[node as usize][0] < 0.101))
            .collect();
        model.joint_facets.clear();
        assert_eq!(model.add_joints(0, &keep), 2);
        model.materials[0].strength = Some(rock());
        model.fracture.insertion = insertion;
        let load = |size: f64| Boundary {
            name: "load".to_owned(),
            target: Target::Facets(top_edges(&model)),
            load: Load::Traction([0.0, size]),
            schedule: Schedule::Ramp(2e-5),
        };
        let [small, large] = [1e2, 5e6].map(load);
        let mut run = Simulation::new(
            Model { boundaries: [model.boundaries.clone(), vec![small]].concat(), ..model.clone() },
            1,
        )
        .expect("a model");
        run.advance(500).expect("steps");
        let counts = run.counts();
        // One of them still has one node at its end, unless every element has its own nodes.
        let parted = if insertion == Insertion::Intrinsic { 2 } else { 1 };
        assert_eq!((counts.broken, counts.open, counts.parted), (0, 2, parted), "{insertion:?}: {counts:?}");
        assert!(run.snapshot().damage.iter().all(|&damage| damage == 0.0), "no damage has happened");
        assert!(run.intact_joints().iter().all(|joint| !joint.open_from_start));
        assert_eq!(run.crack_lengths(), [0.0; 3]);
        let cracks = run.snapshot().cracks;
        assert!(
            cracks.iter().all(|crack| crack.open_from_start && crack.time == Some(0.0)) && cracks.len() == 2,
            "{cracks:?}"
        );

        let mut run = Simulation::new(
            Model { boundaries: [model.boundaries.clone(), vec![large]].concat(), ..model },
            1,
        )
        .expect("a model");
        while run.counts().broken < 2 {
            run.advance(50).expect("steps");
            assert!(run.time() < 1e-3, "{insertion:?}: {:?}", run.counts());
        }
        let broken: Vec<f64> = run
            .snapshot()
            .cracks
            .iter()
            .filter(|crack| crack.time.is_some() && !crack.open_from_start)
            .map(|crack| crack.measure)
            .collect();
        assert_eq!(broken.len(), run.counts().broken);
        let [sum, length] = [broken.iter().sum::<f64>(), run.crack_lengths().iter().sum()];
        assert!((sum - length).abs() < 1e-12, "{insertion:?}: {sum} {length}");
    }
}

#[test]
fn wrong_sets_are_refused() {
    let refused = |set: JointSet| Simulation::new(cut(set), 1).expect_err("refused").to_string();
    let strength = Strength { energy_ii: 1.0, ..rock() };
    let soft = JointSet { strength, normal_stiffness: Some(1e10), ..open(0.3) };
    let text = refused(soft);
    assert!(text.contains("joint set 'bedding'") && text.contains("fracture_energy_i"), "{text}");
    let text = refused(JointSet { dilation: 0.4, ..open(0.3) });
    assert!(text.contains("dilation") && text.contains("residual friction"), "{text}");
    let text = refused(JointSet { normal_stiffness: Some(-1.0), ..open(0.3) });
    assert!(text.contains("normal stiffness"), "{text}");
    let mut model = cut(open(0.3));
    model.joint_sets.clear();
    let text = Simulation::new(model, 1).expect_err("refused").to_string();
    assert!(text.contains("joint set 0"), "{text}");
}
