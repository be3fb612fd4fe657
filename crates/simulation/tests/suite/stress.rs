//! Bodies under initial stress: stored energy and equilibrium.

use crate::common::*;
use fdem_simulation::*;

/// Steps of a run that should stay at rest.
const STEPS: u64 = 2000;

/// Upper limit of kinetic over strain energy for a body at rest: its velocities come from rounding.
const REST: f64 = 1e-18;

/// The tensor of a stress `[xx, yy, xy]`.
fn symmetric([xx, yy, xy]: [f64; 3]) -> [[f64; 2]; 2] {
    [[xx, xy], [xy, yy]]
}

/// A model under uniform stress. The outer sides in `sides` (left, right, bottom, top of the bounding box)
/// carry the tractions of that stress. The bottom is held if it is not among them.
fn stressed(mesh: Mesh, stress: [f64; 3], sides: [bool; 4]) -> Model {
    let [xx, yy, xy] = stress;
    let (min, max) = bounds(&mesh);
    let on = |[x, y]: [f64; 2], side: usize| {
        let (at, limit) = [(x, min[0]), (x, max[0]), (y, min[1]), (y, max[1])][side];
        (at - limit).abs() < 1e-9
    };
    let names = ["left", "right", "bottom", "top"];
    let normals = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    let mut boundaries = Vec::new();
    for side in (0..4).filter(|&side| sides[side]) {
        let [x, y]: [f64; 2] = normals[side];
        boundaries.push(Boundary {
            name: names[side].to_owned(),
            target: Target::Facets(edges_where(&mesh, |node| on(node, side))),
            load: Load::Traction([xx * x + xy * y, xy * x + yy * y]),
            schedule: Schedule::Constant,
        });
    }
    if !sides[2] {
        boundaries.push(Boundary {
            name: "bottom".to_owned(),
            target: Target::Nodes(nodes_where(&mesh, |node| on(node, 2))),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        });
    }
    Model {
        stresses: vec![symmetric(stress); mesh.elements.len()],
        materials: vec![Material { poissons_ratio: 0.25, friction: 0.6, ..granite() }],
        mesh,
        boundaries,
        plane: Plane::Strain,
        ..Model::default()
    }
}

fn bounds(mesh: &Mesh) -> ([f64; 2], [f64; 2]) {
    let fold = |axis: usize, start: f64, f: fn(f64, f64) -> f64| {
        mesh.nodes.iter().map(|node| node[axis]).fold(start, f)
    };
    ([0, 1].map(|k| fold(k, f64::INFINITY, f64::min)), [0, 1].map(|k| fold(k, f64::NEG_INFINITY, f64::max)))
}

/// Edges of elements at both of whose ends `at` is true.
fn edges_where(mesh: &Mesh, at: impl Fn([f64; 2]) -> bool) -> Vec<[u32; 2]> {
    let all = mesh.elements.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    all.filter(|edge| edge.iter().all(|&node| at(mesh.nodes[node as usize]))).collect()
}

/// Runs a model, and checks that it stays at rest and keeps its stress.
fn rests(name: &str, model: Model) -> Simulation {
    let mut run = Simulation::new(model, 1).expect("a model");
    for _ in 0..4 {
        run.advance(STEPS / 4).expect("steps");
        let energies = run.energies();
        assert!(energies.strain > 0.0);
        assert!(energies.kinetic < REST * energies.strain, "{name}: {energies:?}");
        // Not rounding over rounding.
        assert!(energies.error().abs() < 1e-6, "{name}: {} {energies:?}", energies.error());
    }
    for (now, before) in run.snapshot().stresses.iter().zip(&run.model().stresses) {
        let [[xx, xy], [_, yy]] = *before;
        for (now, before) in [now[0], now[1], now[3]].into_iter().zip([xx, yy, xy]) {
            assert!((now - before).abs() < 1.0, "{name}: {now} {before}");
        }
    }
    run
}

/// Rock that breaks only far above the stresses of these tests.
fn strong() -> Strength {
    Strength { tensile: 20e6, cohesion: 40e6, energy_i: 500.0, energy_ii: 5000.0, ..rock() }
}

#[test]
fn a_body_under_matching_stress_stays_at_rest_with_any_joints() {
    let stress = [-8e6, -10e6, 1.5e6];
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let mut model = stressed(rectangle([0.0; 2], [3.0, 2.0], 9, 6), stress, [true, true, false, true]);
        model.materials[0].strength = Some(strong());
        model.fracture.insertion = insertion;
        let run = rests(&format!("{insertion:?}"), model);
        let cohesive = run.energies().cohesive;
        assert_eq!(
            cohesive > 0.0,
            insertion == Insertion::Intrinsic,
            "joints store what they carry: {cohesive}"
        );
        let dissipated = run.energies().joint_dissipated();
        assert!(dissipated.abs() <= 1e-7 * cohesive.abs(), "nothing breaks: {dissipated} of {cohesive}");
    }
}

/// Two blocks, one on the other. Their meshes match if `above`, the number of cells along the upper one,
/// is 8.
fn blocks(above: usize) -> Mesh {
    together(&[rectangle([0.0; 2], [2.0, 1.0], 8, 4), rectangle([0.0, 1.0], [2.0, 2.0], above, 5)])
}

#[test]
fn blocks_that_touch_under_matching_stress_stay_at_rest() {
    for above in [8, 5, 11] {
        for stress in [[0.0, -10e6, 0.0], [-6e6, -10e6, 2e6]] {
            let run = rests(
                &format!("{above} edges on 8, {stress:?}"),
                stressed(blocks(above), stress, [true, true, false, true]),
            );
            assert!(run.energies().contact > 0.0, "the contact has stored what it carries");
        }
    }
}

#[test]
fn blocks_that_are_released_part_without_gain_of_energy() {
    for above in [8, 5] {
        let mut model = stressed(blocks(above), [0.0, -10e6, 0.0], [true, true, false, true]);
        for boundary in &mut model.boundaries {
            if let Load::Traction(_) = boundary.load {
                boundary.schedule = Schedule::Table(vec![[0.0, 1.0], [1e-4, 1.0], [1.5e-4, 0.0]]);
            }
        }
        let mut run = Simulation::new(model, 1).expect("a model");
        run.advance(1).expect("a step");
        let stored = run.energies();
        while run.time() < 3e-3 {
            run.advance(50).expect("steps");
            assert!(run.energies().error().abs() < 1e-3, "{:?}", run.energies());
        }
        let energies = run.energies();
        assert!(energies.contact < 1e-3 * stored.contact, "{energies:?}");
        let upper = run.snapshot().velocities[45..].iter().map(|v| v[1]).sum::<f64>();
        assert!(upper / (run.snapshot().velocities.len() - 45) as f64 > 0.1, "the upper block flies off");
    }
}

/// Rock whose vertical stress carries its weight, with absorbing edges at both sides and below, and a
/// pressure of `-stress_at_top` above.
fn ground(stress_at_top: f64, gravity: f64) -> Model {
    let mesh = rectangle([0.0; 2], [8.0, 5.0], 16, 10);
    let weight = 2700.0 * gravity;
    let centre = |nodes: &[u32; 3]| nodes.iter().map(|&n| mesh.nodes[n as usize][1]).sum::<f64>() / 3.0;
    let stress = |nodes: &[u32; 3]| {
        let vertical = stress_at_top - weight * (5.0 - centre(nodes));
        symmetric([0.5 * vertical, vertical, 0.0])
    };
    let edges = |at: fn([f64; 2]) -> bool| Target::Facets(edges_where(&mesh, at));
    let boundary = |name: &str, target, load| Boundary {
        name: name.to_owned(),
        target,
        load,
        schedule: Schedule::Constant,
    };
    let boundaries = vec![
        boundary("left", edges(|[x, _]| x == 0.0), Load::Absorbing),
        boundary("right", edges(|[x, _]| x == 8.0), Load::Absorbing),
        boundary("below", edges(|[_, y]| y == 0.0), Load::Absorbing),
        boundary("above", edges(|[_, y]| y == 5.0), Load::Pressure(-stress_at_top)),
    ];
    Model {
        stresses: mesh.elements.iter().map(stress).collect(),
        materials: vec![Material { poissons_ratio: 0.25, ..granite() }],
        boundaries,
        mesh,
        gravity: [0.0, -gravity],
        plane: Plane::Strain,
        ..Model::default()
    }
}

#[test]
fn absorbing_edges_keep_the_stress_and_carry_the_weight() {
    rests("stress", ground(-10e6, 0.0));
    rests("stress and weight", ground(-10e6, 9.81));
}

/// A wave leaves through the absorbing edges, and the static stress stays.
#[test]
fn a_wave_leaves_through_absorbing_edges_and_the_stress_stays() {
    let mut model = ground(-10e6, 0.0);
    // Smooth, so that there are no waves as short as the elements, which hardly travel.
    let speed = |[x, y]: [f64; 2]| {
        let distance = ((x - 4.0) * (x - 4.0) + (y - 2.5) * (y - 2.5)).sqrt();
        0.25 * (1.0 + (std::f64::consts::PI * (distance / 2.0).min(1.0)).cos())
    };
    model.velocities = model.mesh.nodes.iter().map(|&node| [0.0, speed(node)]).collect();
    let before = model.stresses.clone();
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(1).expect("a step");
    let kinetic = run.energies().kinetic;
    while run.time() < 0.05 {
        run.advance(100).expect("steps");
    }
    assert!(run.energies().kinetic < 4e-3 * kinetic, "{kinetic} {:?}", run.energies());
    for (now, before) in run.snapshot().stresses.iter().zip(before) {
        assert!((now[1] - before[1][1]).abs() < 0.1e6, "{now:?} {before:?}");
    }
}

/// Without initial stress, a body settles on an absorbing edge by its weight over the stiffness of the
/// ground, and does not sink farther.
#[test]
fn a_body_on_an_absorbing_edge_settles_and_does_not_sink() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], 8, 4);
    let boundary = Boundary {
        name: "below".to_owned(),
        target: Target::Facets(edges_where(&mesh, |[_, y]| y == 0.0)),
        load: Load::Absorbing,
        schedule: Schedule::Constant,
    };
    let material = Material { poissons_ratio: 0.25, youngs_modulus: 1e8, ..granite() };
    let model = Model {
        mesh,
        materials: vec![material],
        boundaries: vec![boundary],
        gravity: [0.0, -9.81],
        ..Model::default()
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    // The box is 2 m long, so R is 1 m. The weight per area is that of 1 m of rock.
    let settled = 2700.0 * 9.81 / (1e8 / 2.5);
    let mut lowest = 0.0_f64;
    while run.time() < 3.0 {
        run.advance(500).expect("steps");
        lowest = lowest.min(run.node(4).expect("a node").0[1]);
    }
    let found = -run.node(4).expect("a node").0[1];
    assert!((found / settled - 1.0).abs() < 0.05 && -lowest < 2.1 * settled, "{found} {settled} {lowest}");
    let [_, carried] = run.force(0).expect("the boundary");
    assert!((carried / (2.0 * 2700.0 * 9.81) - 1.0).abs() < 0.01, "{carried}");
}

/// A square under initial stress with a hole that opens in one step. Its outline is held.
fn opened_hole() -> Model {
    let square = rectangle([-15.0; 2], [15.0; 2], 30, 30);
    let outside = |nodes: &[u32; 3]| {
        let [x, y] = [0, 1].map(|k| nodes.iter().map(|&n| square.nodes[n as usize][k]).sum::<f64>() / 3.0);
        x * x + y * y > 9.0
    };
    let elements: Vec<[u32; 3]> = square.elements.iter().copied().filter(outside).collect();
    let mut number = vec![None; square.nodes.len()];
    let (mut nodes, mut renumbered) = (Vec::new(), Vec::new());
    for triangle in elements {
        renumbered.push(triangle.map(|node| {
            *number[node as usize].get_or_insert_with(|| {
                nodes.push(square.nodes[node as usize]);
                nodes.len() as u32 - 1
            })
        }));
    }
    let count = renumbered.len();
    let mesh = Mesh { nodes, elements: renumbered, bodies: vec![0; count], materials: vec![0; count] };
    let held = nodes_where(&mesh, |[x, y]| x.abs().max(y.abs()) > 14.99);
    Model {
        boundaries: vec![Boundary {
            name: "outside".to_owned(),
            target: Target::Nodes(held),
            load: Load::Velocity([Some(0.0); 2]),
            schedule: Schedule::Constant,
        }],
        ..stressed(mesh, [-10e6, -10e6, 0.0], [false; 4])
    }
}

/// The rock exchanges a small part of its stored energy. The error of the balance is small compared with the
/// exchanged energy.
#[test]
fn a_hole_in_stressed_rock_is_no_error_of_the_energy() {
    let mut run = Simulation::new(opened_hole(), 1).expect("a model");
    run.advance(1).expect("a step");
    let begin = run.energies();
    // 10 MPa in both directions in plane strain: σ²/(2 K) for an area of about 872 m², K = E/(2 (1 + ν)(1 - 2
    // ν)).
    let area = run.model().mesh.elements.len() as f64 / 2.0;
    let stored = area * 1e14 / (2.0 * 50e9 / (2.0 * 1.25 * 0.5));
    assert!((begin.strain / stored - 1.0).abs() < 1e-3, "{begin:?} {stored}");
    let mut most = 0.0_f64;
    for _ in 0..20 {
        run.advance(100).expect("a sound run");
        let energies = run.energies();
        assert!(energies.strain > 0.0 && energies.error().abs() < 1e-3, "{energies:?}");
        most = most.max(energies.kinetic);
    }
    let scale = run.energies().scale();
    assert!(scale > most && scale < 0.2 * stored, "exchanged {scale}, kinetic {most}, stored {stored}");
}

/// `InitialContacts` finds tension, slip and unequal tractions on surfaces that touch.
#[test]
fn stress_that_surfaces_do_not_bear_is_found_before_a_run() {
    let found = |stress: [f64; 3]| {
        InitialContacts::of(&stressed(blocks(5), stress, [true, true, false, true])).expect("a model")
    };
    let good = found([-3e6, -10e6, 1e6]);
    assert!((good.length - 2.0).abs() < 1e-12, "{good:?}");
    assert_eq!((good.pulled, good.slipping, good.unlike), (None, None, None));
    assert!(found([0.0, 1e6, 0.0]).pulled.is_some());
    assert!(found([0.0, -1e6, 0.7e6]).slipping.is_some());
    let mut model = stressed(blocks(5), [0.0, -10e6, 0.0], [true, true, false, true]);
    model.stresses = (0..model.mesh.elements.len())
        .map(|k| symmetric([0.0, if k < 64 { -10e6 } else { -9e6 }, 0.0]))
        .collect();
    let all = InitialContacts::of(&model).expect("a model");
    assert!(all.unlike.is_some(), "{all:?}");
}

/// Blocks under stress, with an absorbing edge, on which a load changes.
pub(crate) fn shaken(insertion: Insertion) -> Model {
    let mut model = stressed(blocks(5), [-3e6, -10e6, 1e6], [true, true, true, true]);
    model.boundaries[2].load = Load::Absorbing;
    model.boundaries[3].schedule = Schedule::Table(vec![[0.0, 1.0], [1e-4, 0.2], [2e-4, 1.5]]);
    model.materials[0].strength = Some(strong());
    model.gravity = [0.0, -9.81];
    model.fracture.insertion = insertion;
    model
}

/// A resumed run with contacts, joints and absorbing edges under stress continues bit for bit.
#[test]
fn stressed_contacts_joints_and_edges_go_on_bit_for_bit() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = shaken(insertion);
        let mut whole = Simulation::new(model.clone(), 1).expect("a model");
        let mut parts = Simulation::new(model.clone(), 2).expect("a model");
        for steps in [0, 1, 99, 150, 333] {
            whole.advance(steps).expect("steps");
            parts.advance(steps).expect("steps");
            let saved = postcard::to_allocvec(&parts.state()).expect("bytes");
            let state = postcard::from_bytes(&saved).expect("a state");
            parts = Simulation::resume(model.clone(), state, 3).expect("the same model");
            assert_eq!(parts.snapshot(), whole.snapshot(), "{insertion:?}");
            assert_eq!(parts.energies(), whole.energies(), "{insertion:?}");
        }
        assert!(whole.energies().kinetic > 1.0, "it moves: {:?}", whole.energies());
    }
}
