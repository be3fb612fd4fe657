//! Runs on many ranks: the results of one.

use crate::common::*;
use fdem_distributed::{Communicator, threads};
use fdem_simulation::*;
use proptest::collection::vec;
use proptest::prelude::*;
use serde::Serialize;

fn bytes(state: &impl Serialize) -> Vec<u8> {
    postcard::to_allocvec(state).expect("bytes")
}

/// Runs a model on ranks, and compares the states to the last bit after each number of steps, and the data of
/// results. Returns the counts at the end.
macro_rules! same_on_ranks {
    ($model:expr, $dimensions:literal, $corners:literal, $ranks:expr, $parts:expr) => {{
        let model: Model<$dimensions, $corners> = $model;
        let mut whole = Simulation::new(model.clone(), 1).expect("a model");
        let mut expected = Vec::new();
        for &steps in $parts {
            whole.advance(steps).expect("steps");
            let cracks = whole.crack_lengths();
            let imbalance = whole.imbalance().to_bits();
            expected.push((
                bytes(&whole.state()),
                (whole.snapshot(), whole.intact_joints()),
                whole.forces(),
                whole.counts(),
                (cracks, imbalance),
            ));
        }
        for &size in $ranks {
            let all = threads::run(size, |communicator: &dyn Communicator| {
                let root = communicator.rank() == 0;
                let run = root.then(|| Simulation::new(model.clone(), 1).expect("a model"));
                let mut run = Distributed::new(communicator, run, 1).expect("threads");
                let mut spreads = 0;
                for (steps, (state, (snapshot, intact), forces, counts, cracks)) in
                    $parts.iter().zip(&expected)
                {
                    run.advance(*steps).expect("steps");
                    let step = run.steps();
                    let gathered = run.gathered();
                    let found_counts = run.counts();
                    assert_eq!((run.crack_lengths(), run.imbalance().to_bits()), *cracks);
                    assert_eq!(
                        Counts { detections: 0, ..found_counts },
                        Counts { detections: 0, ..*counts },
                        "{size} ranks, step {step}"
                    );
                    if let Some(fragments) = run.fragments() {
                        assert_eq!(fragments, snapshot.fragments, "{size} ranks, step {step}");
                    }
                    if let Some(gathered) = gathered {
                        assert_eq!(gathered.snapshot(), *snapshot, "{size} ranks, step {step}");
                        assert_eq!(gathered.intact_joints(), *intact, "{size} ranks, step {step}");
                        assert_eq!(gathered.forces(), *forces, "{size} ranks, step {step}");
                        assert!(bytes(&gathered.state()) == *state, "{size} ranks, step {step}");
                    }
                    spreads = run.traffic().spreads;
                }
                spreads
            });
            assert!(all.iter().all(|spreads| *spreads == all[0]));
        }
        whole.counts()
    }};
}

/// Rigid bodies that break others; each has one owner, and moves from rank to rank with it.
#[test]
fn a_crash_of_rigid_bodies_is_the_same() {
    let counts = same_on_ranks!(crate::rigid::blocks(), 2, 3, &[1, 2, 3, 8], &[1, 299, 700, 1500]);
    assert!(counts.broken > 5 && counts.contacts > 5, "{counts:?}");
    let counts = same_on_ranks!(crate::rigid::blocks_in_space(), 3, 4, &[2, 3], &[1, 150, 70]);
    assert!(counts.contacts > 5, "{counts:?}");
}

/// A fluid that breaks a plate, in a step of each step of the solid, and of every third one; the same on
/// joints that may be wet when they have broken; and a fluid in a hole and its cracks in space.
#[test]
fn a_fluid_in_cracks_is_the_same() {
    let cases: [(u32, WetFrom, &[usize]); 3] =
        [(1, WetFrom::Insertion, &[1, 2, 3, 8]), (3, WetFrom::Insertion, &[3]), (3, WetFrom::Break, &[2])];
    for (steps, wet_from, ranks) in cases {
        let mut model = crate::fluid::breaking();
        let fluid = model.fluid.as_mut().expect("a fluid");
        (fluid.steps, fluid.wet_from) = (steps, wet_from);
        let counts = same_on_ranks!(model, 2, 3, ranks, &[1, 299, 301]);
        assert!(counts.broken > 5, "{counts:?}");
    }
    let counts =
        same_on_ranks!(crate::fluid::cube_with_fluid(Some(rock()), 2e8), 3, 4, &[2, 3], &[1, 150, 70]);
    assert!(counts.broken > 5, "{counts:?}");
}

/// A bar that a boundary twists at one end, whose nodes are on several ranks: so is its moment.
#[test]
fn the_moment_of_a_rotation_is_the_same() {
    let bar = rectangle([0.0, 0.0], [0.4, 0.1], 16, 4);
    let boundary = |name: &str, nodes, load| Boundary {
        name: name.to_owned(),
        target: Target::Nodes(nodes),
        load,
        schedule: Schedule::Ramp(1e-4),
    };
    let turns = Load::Rotation { spin: [0.0, 0.0, 20.0], through: [0.1, 0.02] };
    let model = Model {
        boundaries: vec![
            held("end", nodes_where(&bar, |[x, _]| x > 0.399), [Some(0.0); 2], Schedule::Constant),
            boundary("turns", nodes_where(&bar, |[x, _]| x < 0.201), turns),
        ],
        mesh: bar,
        materials: vec![granite()],
        ..Model::default()
    };
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(200).expect("steps");
    assert_eq!(run.moment(0), Some([0.0; 3]));
    let [x, y, moment] = run.moment(1).expect("a boundary");
    assert!([x, y] == [0.0; 2] && moment > 0.0, "{moment}");
    let _ = same_on_ranks!(model, 2, 3, &[1, 2, 3, 8], &[1, 99, 150]);
}

/// Everything that can happen in the plane: joints that are inserted, break and hand over; contacts, damping,
/// weight, a floor.
#[test]
fn a_crash_in_the_plane_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::resume::crash(insertion);
        let counts = same_on_ranks!(model, 2, 3, &[1, 2, 3, 4, 8], &[1, 299, 700, 500]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

/// Bodies that overlap at the beginning, whose contacts begin without force.
#[test]
fn a_crash_of_overlapping_bodies_is_the_same() {
    let mut model = crate::resume::crash(Insertion::Adaptive);
    // The block begins deep in the ground.
    let block = model.mesh.bodies.iter().position(|body| *body == 1).expect("a block");
    let first = model.mesh.elements[block..].iter().flatten().min().copied().expect("nodes");
    model.mesh.nodes[first as usize..].iter_mut().for_each(|node| node[1] -= 0.006);
    for initial_overlap in [InitialOverlap::Ignore, InitialOverlap::Relax] {
        model.contact.initial_overlap = initial_overlap;
        let counts = same_on_ranks!(model.clone(), 2, 3, &[1, 2, 3], &[1, 99, 500]);
        assert!(counts.contacts > 5, "{initial_overlap:?}: {counts:?}");
    }
}

#[test]
fn a_crash_of_jointed_bodies_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::joint_sets::crash(insertion);
        let counts = same_on_ranks!(model, 2, 3, &[1, 2, 3, 8], &[1, 299, 700, 500]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

/// Elements of two laws, which share batches.
#[test]
fn a_crash_of_bedded_bodies_is_the_same() {
    for (insertion, pressure) in [(Insertion::Adaptive, 0.0), (Insertion::Intrinsic, 1e5)] {
        let model = crate::laws::crash(insertion, pressure);
        let counts = same_on_ranks!(model, 2, 3, &[1, 2, 3, 8], &[1, 299, 700, 400]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

#[test]
fn a_crash_in_space_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::space::crash(insertion);
        let counts = same_on_ranks!(model, 3, 4, &[1, 2, 3, 4, 8], &[1, 399, 400]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

/// A gas bursts a plate, and a cube: the ranks add up its volume, and know all cracks that are connected with
/// it.
#[test]
fn a_gas_in_a_growing_cavity_is_the_same() {
    let counts = same_on_ranks!(crate::cavity::bursting(), 2, 3, &[1, 2, 3, 4], &[1, 299, 300]);
    assert!(counts.broken > 10, "{counts:?}");
    let weak = Strength { tensile: 2e6, cohesion: 6e6, energy_i: 5.0, energy_ii: 25.0, ..rock() };
    let counts = same_on_ranks!(crate::cavity::cube(Some(weak), 100e6), 3, 4, &[2, 3], &[1, 99, 100]);
    assert!(counts.broken > 10, "{counts:?}");
}

/// Added masses: nodes that part take theirs along, and weight is that of the true masses.
#[test]
fn a_crash_of_bodies_with_added_mass_is_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let mut model = Model { gravity: [0.0, -9.81], ..crate::resume::crash(insertion) };
        let step = CriticalStep::of(&model).expect("a model").step;
        model.mass_factors = MassScaling::of(&model).expect("a model").factors(1.5 * step);
        let counts = same_on_ranks!(model, 2, 3, &[1, 3, 8], &[1, 299, 700, 500]);
        assert!(counts.broken > 10 && counts.contacts > 5, "{insertion:?}: {counts:?}");
    }
}

/// An excavation whose forces are released: a model with different forces on each node of the surface.
#[test]
fn an_excavation_is_the_same() {
    let release = Schedule::Table(vec![[0.0, 1.0], [1e-4, 0.2]]);
    let model = crate::changed::excavated(&crate::changed::ground(), Some(release)).model().clone();
    assert!(matches!(model.boundaries[1].load, Load::Held));
    same_on_ranks!(model, 2, 3, &[1, 2, 3, 8], &[1, 99, 300]);
}

/// Dynamic relaxation: the damping is that of the motion on all ranks. Parts end between the two steps whose
/// sums make it.
#[test]
fn a_relaxation_is_the_same() {
    let release = Schedule::Table(vec![[0.0, 1.0], [1e-5, 0.2]]);
    let mut model = crate::changed::excavated(&crate::changed::ground(), Some(release)).model().clone();
    model.time.dynamic_relaxation = true;
    let parts: Vec<u64> = [11].into_iter().chain([10; 39]).collect();
    same_on_ranks!(model, 2, 3, &[1, 2, 3, 8], &parts);
    let mut model = Model { gravity: [0.0, -9.81], ..crate::resume::crash(Insertion::Adaptive) };
    model.time.dynamic_relaxation = true;
    same_on_ranks!(model, 2, 3, &[1, 3], &[1, 299, 701, 500]);
}

/// Two blocks that shatter: nearly all joints break.
#[test]
fn blocks_that_shatter_are_the_same() {
    let mesh =
        together(&[rectangle([0.0; 2], [0.1; 2], 9, 9), rectangle([0.101, 0.03], [0.201, 0.13], 9, 9)]);
    let velocities = mesh.nodes.iter().map(|[x, _]| [if *x < 0.1005 { 20.0 } else { -20.0 }, 0.0]).collect();
    let strength = Strength { tensile: 3e6, cohesion: 6e6, energy_i: 5.0, energy_ii: 20.0, ..rock() };
    let model = Model {
        mesh,
        velocities,
        materials: vec![Material {
            strength: Some(strength),
            friction: 0.5,
            poissons_ratio: 0.2,
            ..granite()
        }],
        fracture: FractureOptions { joint_penalty: 50.0, ..FractureOptions::default() },
        ..Model::default()
    };
    let counts = same_on_ranks!(model, 2, 3, &[3, 8], &[600, 100, 100, 100, 100, 500, 500, 1000]);
    assert!(counts.broken > 200, "{counts:?}");
}

/// Blocks under stress: seams, absorbing edges, loads that change.
#[test]
fn stressed_blocks_are_the_same() {
    for insertion in [Insertion::Adaptive, Insertion::Intrinsic] {
        let model = crate::stress::shaken(insertion);
        same_on_ranks!(model, 2, 3, &[1, 2, 3, 5], &[1, 99, 150, 333]);
    }
}

/// A run that cannot continue stops with the same reason and in the same state.
#[test]
fn a_run_that_stops_is_the_same() {
    // Two halves of a block drive into each other, and invert elements between them; in the other run they
    // are too fast.
    for speed in [8e3, 60e3] {
        let mesh = rectangle([0.0; 2], [0.2, 0.1], 12, 6);
        let velocities = mesh.nodes.iter().map(|[x, _]| [if *x < 0.1 { speed } else { -speed }, 0.0]);
        let model =
            Model { velocities: velocities.collect(), mesh, materials: vec![granite()], ..Model::default() };
        let mut whole = Simulation::new(model.clone(), 1).expect("a model");
        let stop = whole.advance(1000).expect_err("no solid survives this");
        match stop {
            Stop::Inverted { .. } => assert!(speed < 10e3),
            Stop::Runaway { .. } => assert!(speed > 10e3),
            _ => panic!("{stop}"),
        }
        for size in [1, 3, 8] {
            threads::run(size, |communicator: &dyn Communicator| {
                let run =
                    (communicator.rank() == 0).then(|| Simulation::new(model.clone(), 1).expect("a model"));
                let mut run = Distributed::new(communicator, run, 1).expect("threads");
                assert_eq!(run.advance(1000).expect_err("the same").to_string(), stop.to_string());
                // NaN, the stress of such an element, is not equal to itself.
                assert_eq!(
                    format!("{:?}", run.energies()),
                    format!("{:?}", whole.energies()),
                    "{size} ranks, {stop}"
                );
                if let Some(gathered) = run.gathered() {
                    assert_eq!(gathered.snapshot().positions, whole.snapshot().positions);
                    assert!(bytes(&gathered.state()) == bytes(&whole.state()), "{size} ranks, {stop}");
                }
            });
        }
    }
}

/// More ranks than elements: some have none.
#[test]
fn ranks_without_elements_wait_for_the_others() {
    let mesh = together(&[
        rectangle([0.0; 2], [0.1; 2], 1, 1),
        turned(&rectangle([0.0; 2], [0.1; 2], 1, 1), 0.3, [0.05, 0.11]),
    ]);
    let velocities =
        mesh.nodes.iter().map(|[_, y]| if *y > 0.105 { [0.0, -20.0] } else { [0.0; 2] }).collect();
    let model = Model { mesh, velocities, materials: vec![granite()], ..Model::default() };
    let counts = same_on_ranks!(model, 2, 3, &[3, 9], &[1, 60, 300]);
    assert!(counts.nodes == 8);
}

/// A model drawn at random.
#[derive(Clone, Debug)]
struct Drawn {
    /// Angle, height, and velocity of each block.
    blocks: Vec<(f64, f64, [f64; 2])>,
    insertion: Insertion,
    damping: f64,
    /// Ranks, threads of each, and steps of each part of the run, which is saved after each; and whether the
    /// work is divided again in its middle.
    parts: Vec<(usize, usize, u64, bool)>,
}

impl Drawn {
    fn any() -> impl Strategy<Value = Self> {
        let velocity = [-20.0..20.0, -40.0..10.0_f64];
        let block = (0.0..3.0_f64, 0.0..0.03_f64, velocity);
        let part = (1..6_usize, 1..3_usize, 1..400_u64, any::<bool>());
        (vec(block, 2..5), any::<bool>(), 0.0..0.3_f64, vec(part, 2..4)).prop_map(
            |(blocks, intrinsic, damping, parts)| Self {
                blocks,
                insertion: if intrinsic { Insertion::Intrinsic } else { Insertion::Adaptive },
                damping,
                parts,
            },
        )
    }

    fn model(&self) -> Model {
        let ground = rectangle([-0.1, -0.05], [0.5, 0.0], 12, 2);
        let mut velocities = vec![[0.0; 2]; ground.nodes.len()];
        let mut meshes = vec![ground];
        for (k, (angle, height, velocity)) in self.blocks.iter().enumerate() {
            let block = rectangle([-0.04, -0.03], [0.04, 0.03], 3, 3);
            let block = turned(&block, *angle, [0.1 * k as f64, 0.055 + height]);
            velocities.extend(block.nodes.iter().map(|_| *velocity));
            meshes.push(block);
        }
        let strength = Strength {
            tensile: 1e6,
            cohesion: 2e6,
            energy_i: 3.0,
            energy_ii: 9.0,
            weibull_modulus: Some(4.0),
            ..rock()
        };
        Model {
            mesh: together(&meshes),
            velocities,
            materials: vec![Material { strength: Some(strength), friction: 0.4, damping: 0.02, ..granite() }],
            gravity: [0.0, -9.81],
            contact: ContactOptions { damping: self.damping, ..ContactOptions::default() },
            fracture: FractureOptions {
                insertion: self.insertion,
                joint_penalty: 50.0,
                ..FractureOptions::default()
            },
            time: TimeOptions { safety: 0.5, ..TimeOptions::default() },
            ..Model::default()
        }
    }
}

/// The check at the end of a run finds the same on any number of ranks and after a resume, and changes
/// nothing.
#[test]
fn the_energy_balance_at_the_end_is_checked_the_same_on_ranks() {
    let mut model = crate::resume::crash(Insertion::Adaptive);
    let mut whole = Simulation::new(model.clone(), 1).expect("a model");
    whole.advance(1150).expect("steps");
    whole.check_balance().expect("a sound run");
    let state = whole.state();
    // With this bound it would have stopped at the first check after the blocks met.
    model.time.energy_bound = 1e-15;
    let again =
        |state: State| Simulation::resume(model.clone(), state, 1).expect("a state of the same bodies");
    let resumed = again(state.clone());
    let before = bytes(&resumed.state());
    let stop = resumed.check_balance().expect_err("rounding is above the bound");
    assert!(matches!(stop, Stop::Energy { step: 1149, .. }), "{stop}");
    assert!(bytes(&resumed.state()) == before);
    for size in [1, 2, 3] {
        threads::run(size, |communicator: &dyn Communicator| {
            if communicator.rank() > 0 {
                return follow(communicator, 1).expect("threads");
            }
            let run = Leader::new(communicator, again(state.clone()), 1).expect("threads");
            let before = bytes(&run.state());
            let found = run.check_balance().expect_err("rounding is above the bound");
            assert_eq!(found.to_string(), stop.to_string(), "{size} ranks");
            assert!(bytes(&run.state()) == before);
        });
    }
}

/// Runs on changing numbers of ranks and threads, saved and resumed, divided again at any time.
#[test]
fn any_run_is_the_same_on_any_ranks() {
    let config = ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() };
    proptest!(config, |(drawn in Drawn::any())| {
        let model = drawn.model();
        let mut whole = Simulation::new(model.clone(), 1).expect("a model");
        let mut saved = bytes(&whole.state());
        for &(size, threads, steps, anew) in &drawn.parts {
            let stops = whole.advance(steps).is_err();
            let states = threads::run(size, |communicator: &dyn Communicator| {
                let run = (communicator.rank() == 0).then(|| {
                    let state = postcard::from_bytes(&saved).expect("a state");
                    Simulation::resume(model.clone(), state, 1).expect("the same model")
                });
                let mut run = Distributed::new(communicator, run, threads).expect("threads");
                let done = run.advance(steps / 2);
                if anew && done.is_ok() {
                    run.rebalance();
                }
                let done = done.and_then(|()| run.advance(steps - steps / 2));
                assert_eq!(done.is_err(), stops);
                run.gathered().map(|run| (bytes(&run.state()), run.snapshot()))
            });
            if stops {
                break;
            }
            let (state, snapshot) = states.into_iter().flatten().next().expect("rank 0 has the run");
            prop_assert_eq!(&snapshot, &whole.snapshot());
            saved = bytes(&whole.state());
            prop_assert!(state == saved);
        }
    });
}
