//! Forces and fragments in results, compared with the motion that they cause.

use crate::common::*;
use fdem_simulation::*;

/// A tilted block that falls on the ground under a force from the left, slides and breaks.
fn crash() -> Model {
    let ground = rectangle([0.0, -0.1], [0.4, 0.0], 16, 4);
    let block = turned(&rectangle([0.0, 0.0], [0.1, 0.1], 6, 6), 0.5, [0.2, 0.001]);
    let velocities = [vec![[0.0; 2]; ground.nodes.len()], vec![[1.0, -15.0]; block.nodes.len()]].concat();
    let strength = Strength { tensile: 2e6, cohesion: 4e6, energy_i: 5.0, energy_ii: 20.0, ..rock() };
    let mesh = together(&[ground, block]);
    let boundary = |name: &str, nodes, load| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(nodes),
        load,
        schedule: Schedule::Constant,
    };
    Model {
        boundaries: vec![
            boundary("floor", nodes_where(&mesh, |[_, y]| y < -0.0999), Load::Velocity([Some(0.0); 2])),
            boundary("push", nodes_where(&mesh, |[_, y]| y > 0.05), Load::Force([300.0, -20.0])),
        ],
        mesh,
        velocities,
        materials: vec![Material { strength: Some(strength), friction: 0.5, damping: 0.05, ..granite() }],
        contact: ContactOptions { damping: 0.1, ..ContactOptions::default() },
        fracture: FractureOptions { joint_penalty: 100.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// Momentum of the elements for which `counts` is true.
fn momentum_of(run: &Simulation, counts: impl Fn(usize) -> bool) -> [f64; 2] {
    let (snapshot, mesh) = (run.snapshot(), &run.model().mesh);
    let mut sum = [0.0; 2];
    for (element, nodes) in snapshot.elements.iter().enumerate().filter(|(element, _)| counts(*element)) {
        let [a, b, c] = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let mass = granite().density * area / 3.0;
        for &node in nodes {
            for (sum, velocity) in sum.iter_mut().zip(snapshot.velocities[node as usize]) {
                *sum += mass * velocity;
            }
        }
    }
    sum
}

#[test]
fn contact_forces_are_what_changes_the_momentum_of_a_fragment() {
    let mut run = Simulation::new(crash(), 1).expect("a model");
    let (mut rubbing, mut between_fragments) = (0, 0);
    for _ in 0..60 {
        run.advance(49).expect("steps");
        // Only the fragment of the last element is checked. Steps in which it breaks are skipped.
        let before = run.snapshot();
        let last = *before.fragments.last().expect("elements");
        let own = |element: usize| before.fragments[element] == last;
        let momentum = momentum_of(&run, own);
        run.advance(1).expect("a step");
        let after = momentum_of(&run, own);
        let (snapshot, forces) = (run.snapshot(), run.forces());
        let softening = snapshot.cracks.iter().any(|crack| {
            let [a, b] = crack.elements.map(|element| own(element as usize));
            a != b && crack.time.is_none()
        });
        if softening || snapshot.fragments != before.fragments {
            continue;
        }
        let mut expected = [0.0; 2];
        let mut scale = 1.0;
        for contact in &forces.contacts {
            let [a, b] = contact.elements.map(|element| own(element as usize));
            assert!(contact.elements[0] < contact.elements[1]);
            let sign = f64::from(u8::from(a)) - f64::from(u8::from(b));
            let bodies = contact.elements.map(|element| snapshot.bodies[element as usize]);
            between_fragments += usize::from(sign != 0.0 && bodies[0] == bodies[1]);
            rubbing += usize::from(contact.tangential != [0.0; 2]);
            for (expected, force) in expected.iter_mut().zip(contact.force()) {
                *expected += sign * force;
                scale += force.abs();
            }
        }
        let mut nodes: Vec<u32> = (0..snapshot.elements.len())
            .filter(|&element| own(element))
            .flat_map(|element| snapshot.elements[element])
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        for (axis, &of_contacts) in expected.iter().enumerate() {
            let of_supports: f64 = nodes.iter().map(|&node| forces.reactions[node as usize][axis]).sum();
            let expected = of_contacts + of_supports;
            let found = (after[axis] - momentum[axis]) / run.time_step();
            assert!(
                (found - expected).abs() < 1e-9 * scale.max(found.abs() * 1e3),
                "step {}: {found} {expected}, {scale}",
                run.steps()
            );
        }
    }
    assert!(rubbing > 20 && between_fragments > 0, "{rubbing} {between_fragments}");
}

#[test]
fn reactions_of_the_nodes_add_up_to_those_of_the_boundaries() {
    let mut run = Simulation::new(crash(), 2).expect("a model");
    assert_eq!(run.forces().contacts, []);
    for _ in 0..10 {
        run.advance(100).expect("steps");
        let forces = run.forces();
        let snapshot = run.snapshot();
        assert_eq!(forces.reactions.len(), snapshot.positions.len());
        for axis in 0..2 {
            let all: f64 = forces.reactions.iter().map(|force| force[axis]).sum();
            let expected: f64 = (0..2).map(|k| run.force(k).expect("a boundary")[axis]).sum();
            assert!((all - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{all} {expected}");
        }
        let low = |place: [f64; 2]| place[1] < -0.099;
        let floor: f64 = (0..snapshot.positions.len())
            .filter(|&node| low(snapshot.positions[node]))
            .map(|node| forces.reactions[node][1])
            .sum();
        let expected = run.force(0).expect("the floor")[1];
        assert!((floor - expected).abs() < 1e-9 * (1.0 + expected.abs()));
    }
}

#[test]
fn forces_are_those_of_a_run_that_never_stopped() {
    let model = crash();
    let mut whole = Simulation::new(model.clone(), 1).expect("a model");
    whole.advance(900).expect("steps");
    let mut resumed = Simulation::resume(model, whole.state(), 3).expect("the same model");
    assert_eq!(resumed.forces().contacts, [], "none before the first step");
    whole.advance(1).expect("a step");
    resumed.advance(1).expect("a step");
    assert!(whole.forces().contacts.len() > 3);
    assert_eq!(resumed.forces(), whole.forces());
}

#[test]
fn fragments_are_what_hangs_together_by_edges_that_are_not_broken() {
    let mut run = Simulation::new(crash(), 1).expect("a model");
    let counts = |run: &Simulation| run.snapshot().fragments.iter().max().map_or(0, |last| last + 1);
    assert_eq!(counts(&run), 2, "two bodies");
    run.advance(1500).expect("steps");
    let snapshot = run.snapshot();
    assert!(counts(&run) > 3, "{}", counts(&run));
    assert_eq!(run.fragments(), snapshot.fragments);
    // The same result by another method: the lowest number spreads from neighbour to neighbour until nothing
    // changes.
    let elements = &run.model().mesh.elements;
    let mut neighbours = Vec::new();
    for a in 0..elements.len() {
        for b in a + 1..elements.len() {
            let common = elements[a].iter().filter(|&node| elements[b].contains(node)).count();
            let broken = snapshot
                .cracks
                .iter()
                .any(|crack| crack.time.is_some() && crack.elements == [a as u32, b as u32]);
            if common == 2 && !broken {
                neighbours.push([a, b]);
            }
        }
    }
    let mut lowest: Vec<usize> = (0..elements.len()).collect();
    loop {
        let before = lowest.clone();
        for &[a, b] in &neighbours {
            let least = lowest[a].min(lowest[b]);
            (lowest[a], lowest[b]) = (least, least);
        }
        if before == lowest {
            break;
        }
    }
    let mut firsts = lowest.clone();
    firsts.sort_unstable();
    firsts.dedup();
    for (element, first) in lowest.iter().enumerate() {
        let expected = firsts.binary_search(first).expect("a first element") as u32;
        assert_eq!(snapshot.fragments[element], expected, "element {element}");
    }
}

#[test]
fn contacts_far_from_the_origin_are_where_their_elements_are() {
    let mut model = crash();
    for node in &mut model.mesh.nodes {
        *node = [node[0] + 5e4, node[1] - 2e4];
    }
    let mut run = Simulation::new(model, 1).expect("a model");
    for _ in 0..200 {
        run.advance(20).expect("steps");
        if !run.forces().contacts.is_empty() {
            break;
        }
    }
    let (snapshot, forces) = (run.snapshot(), run.forces());
    assert!(!forces.contacts.is_empty());
    for contact in &forces.contacts {
        for element in contact.elements {
            let corners = snapshot.elements[element as usize].map(|node| snapshot.positions[node as usize]);
            for axis in 0..2 {
                let low = corners.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
                let high = corners.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
                assert!((low - 1e-3..=high + 1e-3).contains(&contact.point[axis]), "{contact:?} {corners:?}");
            }
        }
    }
}
