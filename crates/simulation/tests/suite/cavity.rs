//! Pressures in holes and in the cracks that are connected with them.

use std::collections::BTreeSet;

use crate::common::*;
use fdem_simulation::*;

/// The outer facets of a mesh whose nodes are all inside of its box.
fn hole<const D: usize, const N: usize>(mesh: &Mesh<D, N>, facets: [[usize; D]; N]) -> Vec<[u32; D]> {
    let sorted = |mut facet: [u32; D]| {
        facet.sort_unstable();
        facet
    };
    let all = || mesh.elements.iter().flat_map(|nodes| facets.map(|facet| facet.map(|k| nodes[k])));
    let (mut once, mut twice) = (BTreeSet::new(), BTreeSet::new());
    for facet in all().map(sorted) {
        if !once.insert(facet) {
            twice.insert(facet);
        }
    }
    let along = |axis: usize| mesh.nodes.iter().map(move |node| node[axis]);
    let inside = |node: u32| {
        (0..D).all(|axis| {
            let (least, most) = (along(axis).fold(f64::MAX, f64::min), along(axis).fold(f64::MIN, f64::max));
            least < mesh.nodes[node as usize][axis] && mesh.nodes[node as usize][axis] < most
        })
    };
    let is_hole =
        |facet: &[u32; D]| !twice.contains(&sorted(*facet)) && facet.iter().all(|&node| inside(node));
    all().filter(is_hole).collect()
}

fn cavity<const D: usize>(facets: Vec<[u32; D]>, pressure: f64, gas: Option<f64>) -> Boundary<D> {
    Boundary {
        name: "blast hole".to_owned(),
        target: Target::Facets(facets),
        load: Load::Cavity { pressure, gas },
        schedule: Schedule::Constant,
    }
}

/// A plate of 0.2 m by 0.2 m with a hole of 0.04 m by 0.04 m in its middle, without the load in it.
fn plate(strength: Option<Strength>) -> Model {
    let mesh = rectangle([0.0, 0.0], [0.2, 0.2], 10, 10);
    let middle = |nodes: &[u32; 3]| {
        [0, 1].map(|axis| nodes.iter().map(|&node| mesh.nodes[node as usize][axis]).sum::<f64>() / 3.0)
    };
    let keep: Vec<bool> =
        mesh.elements.iter().map(|nodes| middle(nodes).iter().any(|x| (x - 0.1).abs() > 0.02)).collect();
    let whole = Model {
        materials: vec![Material { strength, damping: 0.1, friction: 0.5, ..granite() }],
        mesh: mesh.clone(),
        ..Model::default()
    };
    whole.keeping(&keep).expect("a plate").model
}

const EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// A plate with a pressure or a gas in its hole.
fn pressed(strength: Option<Strength>, pressure: f64, gas: Option<f64>) -> Model {
    let mut model = plate(strength);
    model.boundaries.push(cavity(hole(&model.mesh, EDGES), pressure, gas));
    model
}

/// A plate that a gas bursts.
pub(crate) fn bursting() -> Model {
    let weak = Strength { tensile: 2e6, cohesion: 6e6, energy_i: 5.0, energy_ii: 25.0, ..rock() };
    let mut model = pressed(Some(weak), 30e6, Some(1.3));
    model.time.safety = 0.5;
    model
}

fn state<const D: usize, const N: usize>(run: &Simulation<D, N>) -> CavityState
where
    [[f64; D]; N]: Element<D, N>,
{
    run.cavity(0).expect("a cavity")
}

#[test]
fn the_volume_of_a_hole_is_exact_and_pressure_opens_it() {
    for pressure in [20e6, -20e6] {
        let model = pressed(None, pressure, None);
        let Target::Facets(edges) = model.boundaries[0].target.clone() else { panic!("facets") };
        let mut run = Simulation::new(model, 1).expect("a model");
        let before = state(&run);
        assert!(
            (before.volume - 0.04 * 0.04).abs() < 1e-16 && (before.area - 0.16).abs() < 1e-15,
            "{before:?}"
        );
        run.advance(400).expect("steps");
        let now = state(&run);
        let positions = run.snapshot().positions;
        // The hole is on the right of its edges.
        let enclosed: f64 = edges
            .iter()
            .map(|edge| edge.map(|node| positions[node as usize]))
            .map(|[[ax, ay], [bx, by]]| -0.5 * ((ax - 0.1) * (by - 0.1) - (ay - 0.1) * (bx - 0.1)))
            .sum();
        assert!((now.volume - enclosed).abs() < 1e-12 * enclosed, "{} {enclosed}", now.volume);
        assert!((now.volume - before.volume) * pressure > 0.0, "{now:?}");
        // The work of a constant pressure, which the balance has one step later.
        let work = pressure * (now.volume - before.volume);
        assert!((now.work - work).abs() < 1e-9 * work, "{} {work}", now.work);
        run.advance(1).expect("a step");
        let energies = run.energies();
        assert!((energies.external - work).abs() < 1e-7 * work, "{} {work}", energies.external);
        assert!(energies.error().abs() < 1e-4, "{}", energies.error());
    }
}

#[test]
fn a_gas_follows_its_volume_and_its_energy_is_in_the_balance() {
    let (pressure, exponent) = (200e6, 1.4);
    let mut run = Simulation::new(pressed(None, pressure, Some(exponent)), 2).expect("a model");
    let first = state(&run);
    let stored =
        |volume: f64| pressure * first.volume.powf(exponent) * volume.powf(1.0 - exponent) / (exponent - 1.0);
    let (mut volume, mut least, mut most) = (first.volume, f64::MAX, 0.0_f64);
    for _ in 0..500 {
        run.advance(1).expect("a step");
        let now = state(&run);
        let expected = pressure * (first.volume / volume).powf(exponent);
        assert!((now.pressure / expected - 1.0).abs() < 1e-12, "{now:?} {expected}");
        assert!((now.stored / stored(volume) - 1.0).abs() < 1e-12, "{now:?}");
        volume = now.volume;
        (least, most) = (least.min(volume), most.max(volume));
    }
    assert!(most > 1.005 * first.volume && least > 0.99 * first.volume, "{least} {most}");
    let energies = run.energies();
    let gas = energies.terms().into_iter().find(|term| term.key == "gas").expect("a term").value;
    assert!((gas - stored(volume)).abs() < 1e-3 * gas, "{gas}");
    // The energy lost by the gas is the work that it has done, and nothing else is external work.
    let lost = stored(first.volume) - stored(volume);
    assert!((state(&run).work / lost - 1.0).abs() < 1e-4, "{} {lost}", state(&run).work);
    assert_eq!(energies.external, 0.0);
    assert!(energies.error().abs() < 5e-3, "{}", energies.error());
}

#[test]
fn a_cavity_grows_with_the_cracks_and_continues_after_a_resume() {
    let model = bursting();
    let mut whole = Simulation::new(model.clone(), 2).expect("a model");
    let first = state(&whole);
    for threads in [1, 3] {
        whole.advance(250).expect("steps");
        let mut resumed = Simulation::resume(model.clone(), whole.state(), threads).expect("a state");
        assert_eq!(resumed.cavity(0), whole.cavity(0));
        whole.advance(250).expect("steps");
        resumed.advance(250).expect("steps");
        assert_eq!(resumed.snapshot(), whole.snapshot());
        assert_eq!((resumed.energies(), resumed.cavity(0)), (whole.energies(), whole.cavity(0)));
    }
    let now = state(&whole);
    assert!(whole.counts().broken > 10, "{:?}", whole.counts());
    // Both faces of the broken joints, which are all connected with the hole here.
    let length: f64 = whole.crack_lengths().iter().sum();
    assert!(now.area > first.area + length && now.volume > first.volume, "{now:?} {length}");
    assert!(whole.energies().error().abs() < 0.02, "{}", whole.energies().error());
}

/// Elements far from the hole vanish: the volume stays that of the step before.
#[test]
fn a_cavity_continues_in_a_changed_model() {
    let mut model = pressed(None, 20e6, Some(1.4));
    model.time.safety = 0.4;
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(100).expect("steps");
    let before = state(&run);
    let far = |nodes: &[u32; 3]| nodes.iter().all(|&node| model.mesh.nodes[node as usize][0] < 0.0201);
    let keep: Vec<bool> = model.mesh.elements.iter().map(|nodes| !far(nodes)).collect();
    let change = Change::excavating(&model, &keep, None).expect("a change");
    let (changed, state_then) = run.state().changed(&model, change, 1).expect("a changed model");
    let mut after = Simulation::resume(changed, state_then, 1).expect("a run");
    assert_eq!(state(&after), before);
    after.advance(100).expect("steps");
    assert!(after.energies().error().abs() < 1e-3, "{}", after.energies().error());
}

/// A crack in the middle of a plate that is there from the beginning, without a hole.
#[test]
fn a_cavity_may_begin_with_an_open_joint() {
    let mesh = rectangle([0.0, 0.0], [0.2, 0.2], 20, 20);
    let inside = |node: u32| (mesh.nodes[node as usize][0] - 0.1).abs() < 0.0401;
    let edges: Vec<[u32; 2]> = crate::joint_sets::along_height(&mesh, 0.1)
        .into_iter()
        .filter(|edge| edge.iter().all(|&node| inside(node)))
        .collect();
    let mut model = Model {
        materials: vec![Material { damping: 0.3, strength: Some(rock()), ..granite() }],
        joint_sets: vec![JointSet { open: true, ..crate::joint_sets::open(0.0) }],
        mesh,
        ..Model::default()
    };
    assert_eq!(model.add_joints(0, &edges), 8);
    // One edge of the crack is enough: the others are connected with it.
    model.boundaries.push(cavity(vec![edges[6]], 1e5, None));
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    assert!((state(&run).area - 2.0 * 0.08).abs() < 1e-12, "{:?}", state(&run));
    run.advance(300).expect("steps");
    let now = state(&run);
    assert!(now.volume > 0.0 && now.work > 0.0, "{now:?}");
    assert!((now.work / (1e5 * now.volume) - 1.0).abs() < 1e-6, "{now:?}");
    let refused = model.boundaries[0].clone();
    model.boundaries[0].load = Load::Cavity { pressure: 1e5, gas: Some(1.4) };
    let error = Simulation::new(model.clone(), 1).expect_err("a gas needs a volume").to_string();
    assert!(error.contains("closed hole"), "{error}");
    model.boundaries[0] = Boundary { load: Load::Cavity { pressure: 1e5, gas: Some(1.0) }, ..refused };
    let error = Simulation::new(model, 1).expect_err("an exponent of 1").to_string();
    assert!(error.contains("ratio of the specific heats"), "{error}");
}

const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// A cube of 0.1 m with a cubic hole of 0.02 m in its middle, which a gas bursts if the cube has a strength.
pub(crate) fn cube(strength: Option<Strength>, pressure: f64) -> Model<3, 4> {
    let mesh = crate::space::cuboid([0.0; 3], [0.1; 3], [5; 3]);
    let middle = |nodes: &[u32; 4]| {
        [0, 1, 2].map(|axis| nodes.iter().map(|&node| mesh.nodes[node as usize][axis]).sum::<f64>() / 4.0)
    };
    let keep: Vec<bool> =
        mesh.elements.iter().map(|nodes| middle(nodes).iter().any(|x| (x - 0.05).abs() > 0.01)).collect();
    let material = Material { strength, damping: 0.1, friction: 0.5, ..granite() };
    let whole = Model { materials: vec![material], mesh: mesh.clone(), ..Model::default() };
    let mut model = whole.keeping(&keep).expect("a cube").model;
    model.boundaries.push(cavity(hole(&model.mesh, FACES), pressure, Some(1.3)));
    model
}

#[test]
fn the_volume_of_a_hole_in_space_is_exact() {
    let mut run = Simulation::<3, 4>::new(cube(None, 500e6), 1).expect("a model");
    let first = state(&run);
    assert!((first.volume - 8e-6).abs() < 1e-18 && (first.area - 6.0 * 4e-4).abs() < 1e-15, "{first:?}");
    run.advance(100).expect("steps");
    let Target::Facets(faces) = run.model().boundaries[0].target.clone() else { panic!("facets") };
    let positions = run.snapshot().positions;
    let enclosed: f64 = faces
        .iter()
        .map(|face| face.map(|node| positions[node as usize].map(|x| x - 0.05)))
        .map(|[a, b, c]| {
            let [u, v, w] =
                [0, 1, 2].map(|k| b[(k + 1) % 3] * c[(k + 2) % 3] - b[(k + 2) % 3] * c[(k + 1) % 3]);
            -(a[0] * u + a[1] * v + a[2] * w) / 6.0
        })
        .sum();
    let now = state(&run);
    assert!(now.volume > 1.002 * first.volume, "{now:?}");
    assert!((now.volume - enclosed).abs() < 1e-9 * enclosed, "{} {enclosed}", now.volume);
    let energies = run.energies();
    assert!(energies.error().abs() < 1e-3, "{}", energies.error());
}
