//! Bodies that break: strength, energy, compliance.

use crate::common::*;
use fdem_simulation::*;

fn brittle(strength: Strength) -> Material {
    Material { youngs_modulus: 30e9, strength: Some(strength), ..granite() }
}

/// A strip of 2 by 8 cells of 5 mm, pulled apart slowly along y.
fn tension(insertion: Insertion, strength: Strength) -> Simulation {
    let mut mesh = rectangle([0.0, 0.0], [0.01, 0.04], 2, 8);
    // Only the joints in the middle, between the two materials, have this strength. The materials are
    // slightly stronger, so that the place of the crack is known.
    for element in 0..mesh.elements.len() {
        mesh.materials[element] =
            u32::from(mesh.elements[element].iter().any(|&node| mesh.nodes[node as usize][1] > 0.0201));
    }
    let stronger = Strength { tensile: 1.05 * strength.tensile, ..strength };
    let half = Material { damping: 0.2, ..brittle(stronger) };
    let (bottom, top) = (nodes_where(&mesh, |[_, y]| y < 1e-9), nodes_where(&mesh, |[_, y]| y > 0.04 - 1e-9));
    let speed = 0.001;
    let velocities = mesh.nodes.iter().map(|[_, y]| [0.0, speed * y / 0.04]).collect();
    let model = Model {
        mesh,
        velocities,
        materials: vec![half.clone(), half],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.0,
            penalty: None,
            strength: Some(strength),
        }],
        boundaries: vec![
            held("bottom", bottom, [None, Some(0.0)], Schedule::Constant),
            held("top", top, [None, Some(speed)], Schedule::Constant),
        ],
        fracture: FractureOptions { insertion, joint_penalty: 20.0, ..FractureOptions::default() },
        ..Model::default()
    };
    Simulation::new(model, 1).expect("a model")
}

#[test]
fn tension_peaks_at_the_strength_and_dissipates_the_fracture_energy_in_one_crack() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let mut run = tension(insertion, Strength { energy_i: 3.0, ..rock() });
        let (mut peak, mut most, mut stored) = (0.0_f64, 0.0_f64, 0.0_f64);
        while run.counts().broken == 0 {
            run.advance(1).expect("a step");
            let energies = run.energies();
            let dissipated = energies.joint_dissipated();
            assert!(dissipated > most - 1e-6 * 0.03, "{insertion:?}: {dissipated} after {most}");
            most = most.max(dissipated);
            stored = stored.max(energies.joint_elastic);
            if run.force(1).expect("a boundary")[1] < 0.009e6 && peak < 0.0095e6 {
                assert!(dissipated.abs() < 1e-6 * 0.03, "{insertion:?}: {dissipated} before the strength");
            }
            peak = peak.max(run.force(1).expect("a boundary")[1] / 0.01);
            assert!(run.time() < 1.0, "it never breaks");
        }
        let at_break = run.time();
        while run.time() < 1.2 * at_break {
            run.advance(50).expect("steps");
        }
        let length: f64 = run.crack_lengths().iter().sum();
        let [opened, ..] = run.crack_lengths();
        assert!((peak / 1e6 - 1.0).abs() < 0.005, "{insertion:?}: {peak}");
        assert!(
            (length / 0.01 - 1.0).abs() < 1e-9 && opened == length,
            "{insertion:?}: {:?}",
            run.crack_lengths()
        );
        let dissipated = run.energies().cohesive;
        assert!((dissipated / (3.0 * 0.01) - 1.0).abs() < 0.01, "{insertion:?}: {dissipated}");
        assert!((most / (3.0 * 0.01) - 1.0).abs() < 0.02, "{insertion:?}: {most}");
        // The crack is open: its joint stores nothing, less the energy with which it was inserted.
        let elastic = run.energies().joint_elastic;
        assert!(elastic.abs() < 0.01 * most, "{insertion:?}: {elastic}");
        if insertion == Insertion::Intrinsic {
            assert!(stored > 0.0 && elastic.abs() < 0.01 * stored, "{elastic} of {stored}");
        }
        assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
    }
}

/// A block of two halves with a joint without strength between them. The lower half is fixed.
fn open_joint(top: Load, insertion: Insertion) -> Model {
    let mut mesh = rectangle([0.0, 0.0], [0.04, 0.02], 8, 4);
    for element in 0..mesh.elements.len() {
        mesh.materials[element] =
            u32::from(mesh.elements[element].iter().any(|&node| mesh.nodes[node as usize][1] > 0.0101));
    }
    let bottom = nodes_where(&mesh, |[_, y]| y < 1e-9);
    let nodes = nodes_where(&mesh, |[_, y]| y > 0.02 - 1e-9);
    // Counter-clockwise: from right to left along the top.
    let edges = nodes.windows(2).map(|pair| [pair[1], pair[0]]).collect();
    let half = Material { damping: 0.5, youngs_modulus: 30e9, ..granite() };
    let open = Strength { tensile: 0.0, cohesion: 0.0, energy_i: 0.0, energy_ii: 0.0, ..rock() };
    let ramp = Schedule::Ramp(1e-4);
    Model {
        mesh,
        materials: vec![half.clone(), half],
        interfaces: vec![Interface { materials: [0, 1], friction: 0.0, penalty: None, strength: Some(open) }],
        boundaries: vec![
            held("bottom", bottom, [Some(0.0), Some(0.0)], Schedule::Constant),
            Boundary { name: "top".to_owned(), target: Target::Facets(edges), load: top, schedule: ramp },
        ],
        fracture: FractureOptions { insertion, ..FractureOptions::default() },
        ..Model::default()
    }
}

/// The joint has the coefficient of friction of `rock()`, 0.3.
#[test]
fn a_joint_without_strength_carries_pressure_and_friction_and_no_tension() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let moved = |traction: [f64; 2], axis: usize| {
            let model = open_joint(Load::Traction(traction), insertion);
            let corner = model.mesh.nodes.len() - 1;
            let mut run = Simulation::new(model, 1).expect("a model");
            let mut most = 0.0_f64;
            while run.time() < 3e-4 {
                run.advance(20).expect("steps");
                most = most.max(run.force(0).expect("a boundary")[1].abs());
            }
            assert!(run.energies().error().abs() < 1e-2, "{:?}", run.energies());
            // Joints split nodes, which are renumbered: the corner is found through its element.
            let mesh = &run.model().mesh;
            let place = |triangle: &[u32; 3]| triangle.iter().position(|&node| node as usize == corner);
            let (element, k) =
                (0..).zip(&mesh.elements).find_map(|(i, t)| Some((i, place(t)?))).expect("an element");
            let snapshot = run.snapshot();
            let now: usize = snapshot.elements[element][k] as usize;
            (snapshot.positions[now][axis] - mesh.nodes[corner][axis], most)
        };
        let (held, pressed) = moved([0.2e6, -1e6], 0);
        let (slid, _) = moved([0.4e6, -1e6], 0);
        let (lifted, pulled) = moved([0.0, 1e5], 1);
        assert!(held.abs() < 3e-6 && slid > 3e-5, "{insertion:?}: {held} {slid}");
        // The fixed side carries the whole pressure of 1 MPa on 40 mm, and more while the block still moves.
        // It carries almost none of the pull.
        assert!((3.9e4..5.5e4).contains(&pressed), "{insertion:?}: {pressed}");
        assert!(lifted > 3e-5 && pulled < 400.0, "{insertion:?}: {lifted} {pulled}");
    }
}

/// A bar that is pressed, sheared until its joint breaks, and pulled apart. The joint was inserted under
/// pressure and presses until the pressure is gone, not only until its gap is 0: no force jumps, and the
/// energy balance holds.
#[test]
fn a_joint_that_broke_under_pressure_lets_go_without_a_jump() {
    let mut mesh = rectangle([0.0; 2], [0.01, 0.04], 1, 4);
    for element in 0..mesh.elements.len() {
        let above = mesh.elements[element].iter().any(|&node| mesh.nodes[node as usize][1] > 0.0201);
        mesh.materials[element] = u32::from(above);
    }
    let half = Material { youngs_modulus: 30e9, damping: 0.2, ..granite() };
    let table = |rows: &[[f64; 2]]| Schedule::Table(rows.iter().map(|[t, f]| [1e-4 * t, *f]).collect());
    let across = table(&[[2.0, 0.0], [3.0, 1.0], [8.0, 1.0], [9.0, 0.0]]);
    let along = table(&[[0.0, 0.0], [0.5, -1.0], [1.5, -1.0], [2.0, 0.0], [9.0, 0.0], [9.5, 1.0]]);
    let top = nodes_where(&mesh, |[_, y]| y > 0.04 - 1e-9);
    let moved = |name: &str, nodes, velocity, schedule| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(nodes),
        load: Load::Velocity(velocity),
        schedule,
    };
    let bottom = nodes_where(&mesh, |[_, y]| y < 1e-9);
    let model = Model {
        materials: vec![half.clone(), half],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.1,
            penalty: None,
            strength: Some(Strength { cohesion: 1e6, energy_ii: 2.0, friction: 0.1, ..rock() }),
        }],
        boundaries: vec![
            moved("bottom", bottom, [Some(0.0); 2], Schedule::Constant),
            moved("along", top.clone(), [None, Some(0.04)], along),
            moved("across", top, [Some(0.03), None], across),
        ],
        mesh,
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    let (mut most, mut before, mut jump, mut drift) = (0.0_f64, 0.0, 0.0_f64, 0.0_f64);
    while run.time() < 1.2e-3 {
        run.advance(1).expect("a step");
        let now = run.force(0).expect("a boundary")[1];
        if run.counts().broken == 1 {
            jump = jump.max((now - before).abs());
        }
        (most, before) = (most.max(now.abs()), now);
        drift = drift.max(run.energies().error().abs());
    }
    assert_eq!(run.counts().broken, 1);
    assert!(most > 100.0 && before.abs() < 1e-2 * most, "{most} {before}");
    assert!(jump < 0.02 * most, "{jump} of {most}");
    assert!(drift < 1e-5, "{drift}");
}

/// Joints that are inserted under pressure store energy, and return it where the pressure changes. That is no
/// energy out of nothing.
#[test]
fn joints_that_are_inserted_under_pressure_may_return_what_they_store() {
    let mesh = rectangle([0.0, 0.0], [0.02, 0.02], 20, 20);
    let material =
        brittle(Strength { cohesion: 15e6, tensile: 5e6, weibull_modulus: Some(20.0), seed: 1, ..rock() });
    let velocities = mesh.nodes.iter().map(|node| node.map(|x| 0.01 * (300.0 * x).sin())).collect();
    let sides = [(0, 0.0), (0, 0.02), (1, 0.0), (1, 0.02)].map(|(axis, end): (usize, f64)| {
        let mut velocity = [None; 2];
        velocity[axis] = Some(0.0);
        let nodes = nodes_where(&mesh, |node| (node[axis] - end).abs() < 1e-9);
        held("side", nodes, velocity, Schedule::Constant)
    });
    let model = Model {
        velocities,
        stresses: vec![[[0.0, 0.0], [0.0, -34e6]]; mesh.elements.len()],
        mesh,
        materials: vec![material],
        boundaries: sides.into(),
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    let (mut most, mut dissipated, mut returned) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..20 {
        run.advance(100).expect("energies in balance");
        let energies = run.energies();
        most = most.max(energies.cohesive);
        returned = returned.max((most - energies.cohesive) / energies.scale());
        assert!(energies.joint_dissipated() > dissipated - 0.01 * energies.scale(), "{energies:?}");
        dissipated = dissipated.max(energies.joint_dissipated());
    }
    assert!(run.counts().joints > 0 && run.counts().broken == 0, "{:?}", run.counts());
    assert!(returned > 0.05, "{returned}");
}
