//! Steps of a simulation on a device are those on the processor, to the bit.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

#[path = "steps/bedding.rs"]
mod bedding;
#[path = "steps/insertion.rs"]
mod insertion;
#[path = "steps/pores.rs"]
mod pores;
#[path = "steps/rigid.rs"]
mod rigid;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use fdem_gpu::kernels::Kernel;
use fdem_gpu::{Device, DeviceSolid, GpuError, Host, HostBuild};
use fdem_scenes::random::Random;
use fdem_simulation::{
    Accelerator, Boundary, Element, FractureOptions, InitialOverlap, Insertion, Load, Material, MaterialLaw,
    MaterialPoint, Mesh, Model, ModelError, Probe, Schedule, Simulation, State, Strength, Target,
    TimeOptions,
};
use serde::Serialize;

/// A grid of cells whose inner nodes are off their places, each of the simplices along the ways through it,
/// and two materials by turns.
fn grid<const D: usize, const N: usize>(cells: usize) -> Mesh<D, N> {
    let side = cells + 1;
    let mut random = Random::new(3);
    let nodes: Vec<[f64; D]> = (0..side.pow(D as u32))
        .map(|k| {
            std::array::from_fn(|axis| {
                let at = k / side.pow(axis as u32) % side;
                let off = if at > 0 && at < cells { 0.15 * random.between(-1.0, 1.0) } else { 0.0 };
                (at as f64 + off) / cells as f64
            })
        })
        .collect();
    let ways: &[(&[usize], bool)] = match D {
        2 => &[(&[0, 1], false), (&[1, 0], true)],
        _ => &[
            (&[0, 1, 2], false),
            (&[1, 2, 0], false),
            (&[2, 0, 1], false),
            (&[0, 2, 1], true),
            (&[1, 0, 2], true),
            (&[2, 1, 0], true),
        ],
    };
    let mut elements = Vec::new();
    for cell in 0..cells.pow(D as u32) {
        let corner: usize =
            (0..D).map(|axis| cell / cells.pow(axis as u32) % cells * side.pow(axis as u32)).sum();
        for (way, is_odd) in ways {
            let mut element = [corner as u32; N];
            let mut at = corner;
            for (place, &axis) in way.iter().enumerate() {
                at += side.pow(axis as u32);
                element[place + 1] = at as u32;
            }
            if *is_odd {
                element.swap(0, 1);
            }
            elements.push(element);
        }
    }
    let count = elements.len();
    let materials = (0..count as u32).map(|k| k % 2).collect();
    Mesh { nodes, elements, bodies: vec![0; count], materials }
}

fn model<const D: usize, const N: usize>(damping: f64, gravity: [f64; D]) -> Model<D, N> {
    model_of(if D == 2 { 20 } else { 6 }, damping, gravity)
}

fn model_of<const D: usize, const N: usize>(cells: usize, damping: f64, gravity: [f64; D]) -> Model<D, N> {
    let mesh = grid::<D, N>(cells);
    let mut random = Random::new(11);
    let velocities =
        mesh.nodes.iter().map(|_| std::array::from_fn(|_| 3.0 * random.between(-1.0, 1.0))).collect();
    let material = |youngs_modulus: f64, poissons_ratio: f64| Material {
        name: format!("{youngs_modulus}"),
        density: 2000.0,
        youngs_modulus,
        poissons_ratio,
        law: MaterialLaw::NeoHookean,
        damping,
        strength: None,
        friction: 0.5,
    };
    Model {
        mesh,
        materials: vec![material(2e6, 0.2), material(5e6, 0.3)],
        velocities,
        gravity,
        time: TimeOptions { local_damping: if damping > 0.0 { 0.1 } else { 0.0 }, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// The nodes of a model near a side of the unit cube, at 0 or 1 along an axis.
fn side<const D: usize, const N: usize>(model: &Model<D, N>, axis: usize, at: f64) -> Target<D> {
    let nodes =
        (0..model.mesh.nodes.len() as u32).filter(|&node| model.mesh.nodes[node as usize][axis] == at);
    Target::Nodes(nodes.collect())
}

/// The outer facets of a side of the unit cube.
fn facets<const D: usize, const N: usize>(model: &Model<D, N>, axis: usize, at: f64) -> Target<D> {
    let of_element: &[&[usize]] = match D {
        2 => &[&[0, 1], &[1, 2], &[2, 0]],
        _ => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
    };
    let all =
        model.mesh.elements.iter().flat_map(|nodes| {
            of_element.iter().map(move |corners| std::array::from_fn(|k| nodes[corners[k]]))
        });
    let on_side = |facet: &[u32; D]| facet.iter().all(|&node| model.mesh.nodes[node as usize][axis] == at);
    Target::Facets(all.filter(on_side).collect())
}

fn boundary<const D: usize>(name: &str, target: Target<D>, load: Load<D>, schedule: Schedule) -> Boundary<D> {
    Boundary { name: name.to_owned(), target, load, schedule }
}

fn put_on<const D: usize, const N: usize>(
    run: &mut Simulation<D, N>,
    build: HostBuild,
) -> Result<(), ModelError>
where
    [[f64; D]; N]: Element<D, N>,
    DeviceSolid<Host, D, N>: Accelerator<D, N>,
{
    run.put_on(Box::new(DeviceSolid::new(Arc::new(Host(build)))))
}

/// All that a run has between two steps.
fn bytes<const D: usize, const N: usize>(run: &Simulation<D, N>) -> Vec<u8>
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    postcard::to_allocvec(&run.state()).unwrap()
}

/// Runs a model on the processor and on devices, and compares all that they have. `least`: a displacement
/// that nodes exceed, m.
fn same<const D: usize, const N: usize>(model: &Model<D, N>, most: u64, least: f64)
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let new = || Simulation::new(model.clone(), 1).unwrap();
    let builds = [HostBuild::Ascending, HostBuild::Descending, HostBuild::Contracted];
    let (mut expected, mut runs) = (new(), builds.map(|_| new()));
    for (run, build) in runs.iter_mut().zip(builds) {
        put_on(run, build).unwrap();
    }
    for steps in [1, 2, most] {
        expected.advance(steps).unwrap();
        for (run, build) in runs.iter_mut().zip(builds) {
            run.advance(steps).unwrap();
            let same = bytes(run) == bytes(&expected)
                && run.energies() == expected.energies()
                && run.imbalance().to_bits() == expected.imbalance().to_bits()
                && run.snapshot() == expected.snapshot()
                && run.forces() == expected.forces();
            // A sum that is not rounded may be the same in the first steps.
            let is_fused = build == HostBuild::Contracted;
            assert!(if is_fused { !same || steps <= 2 } else { same }, "{build:?}, {steps} steps");
        }
    }
    let moved = expected.snapshot().displacements;
    assert!(moved.iter().flatten().any(|x| x.abs() > least), "it hardly moves");
}

#[test]
fn elastic_triangles_move_as_on_the_processor() {
    // By a tenth of a cell: strains for which a cube root is needed.
    same(&model::<2, 3>(0.0, [0.0, -9.81]), 200, 0.01);
}

#[test]
fn elastic_tetrahedra_move_as_on_the_processor() {
    same(&model::<3, 4>(0.0, [0.0, 0.0, -9.81]), 200, 0.01);
}

#[test]
fn viscous_triangles_move_as_on_the_processor() {
    same(&model::<2, 3>(0.2, [1.0, 0.0]), 200, 1e-3);
}

#[test]
fn viscous_tetrahedra_move_as_on_the_processor() {
    same(&model::<3, 4>(0.2, [0.0, 1.0, 0.0]), 200, 1e-3);
}

/// A model with initial stress whose sides are held, moved, pressed and pulled.
fn loaded<const D: usize, const N: usize>(damping: f64, turns: bool) -> Model<D, N> {
    let mut model = model::<D, N>(damping, std::array::from_fn(|axis| if axis == 0 { 2.0 } else { -3.0 }));
    let mut random = Random::new(5);
    model.stresses = (0..model.mesh.elements.len())
        .map(|_| {
            let mut stress = [[0.0; D]; D];
            for (axis, row) in stress.iter_mut().enumerate() {
                row[axis] = -1e4 * random.uniform();
            }
            stress
        })
        .collect();
    let axis = |of: usize, value: f64| std::array::from_fn(|k| if k == of { Some(value) } else { None });
    let table = Schedule::Table(vec![[0.0, 0.3], [1e-3, 1.0], [1e-2, -0.5]]);
    let upper = if turns {
        Load::Rotation { spin: [0.1, 0.2, 3.0], through: [0.5; D] }
    } else {
        Load::Displacement(axis(D - 1, 1e-2))
    };
    model.boundaries = vec![
        boundary("floor", side(&model, D - 1, 0.0), Load::Velocity([Some(0.0); D]), Schedule::Constant),
        boundary("upper", side(&model, D - 1, 1.0), upper, Schedule::Ramp(5e-3)),
        boundary("pull", Target::Nodes(vec![30, 50, 70]), Load::Force([2e3; D]), table.clone()),
        boundary("push", Target::Nodes(vec![50, 51]), Load::Force([-1e3; D]), Schedule::Constant),
        boundary("press", facets(&model, 0, 1.0), Load::Pressure(5e3), table.clone()),
        boundary("drag", facets(&model, 0, 0.0), Load::Traction([7e2; D]), Schedule::Ramp(3e-3)),
    ];
    if !turns {
        let target = side(&model, 0, 0.0).nodes().into_iter();
        let free = target.filter(|&node| {
            let place = model.mesh.nodes[node as usize][D - 1];
            place > 0.0 && place < 1.0
        });
        let wall = boundary("wall", Target::Nodes(free.collect()), Load::Velocity(axis(0, 0.7)), table);
        model.boundaries.push(wall);
    }
    if turns {
        model.time.dynamic_relaxation = true;
    }
    model
}

#[test]
fn triangles_are_held_and_loaded_as_on_the_processor() {
    same(&loaded::<2, 3>(0.0, false), 150, 1e-4);
    same(&loaded::<2, 3>(0.1, true), 150, 1e-4);
}

#[test]
fn tetrahedra_are_held_and_loaded_as_on_the_processor() {
    same(&loaded::<3, 4>(0.1, false), 120, 1e-4);
    same(&loaded::<3, 4>(0.0, true), 120, 1e-4);
}

/// A model with a joint on every face, whose nodes move with some speed at the beginning, and that is drawn
/// and then pushed together. `energy`: the fracture energy of opening, J/m².
fn joined<const D: usize, const N: usize>(speed: f64, energy: f64) -> Model<D, N> {
    let mut model = model_of::<D, N>(if D == 2 { 9 } else { 3 }, 0.05, [1.0; D]);
    model.velocities.iter_mut().flatten().for_each(|velocity| *velocity *= speed / 3.0);
    let strength = Strength {
        tensile: 1e6,
        cohesion: 2e6,
        friction: 0.4,
        energy_i: energy,
        energy_ii: 3.0 * energy,
        weibull_modulus: Some(8.0),
        seed: 5,
    };
    for material in &mut model.materials {
        material.youngs_modulus *= 1e3;
        material.strength = Some(strength);
    }
    model.fracture = FractureOptions { insertion: Insertion::Intrinsic, ..FractureOptions::default() };
    let mut along = [None; D];
    along[0] = Some(speed);
    let wave = Schedule::Table(vec![[0.0, 1.0], [4e-4, 1.0], [5e-4, -2.0], [1e-3, 0.0]]);
    model.boundaries = vec![
        boundary("left", side(&model, 0, 0.0), Load::Velocity([Some(0.0); D]), Schedule::Constant),
        boundary("right", side(&model, 0, 1.0), Load::Velocity(along), wave),
    ];
    model
}

/// Joints that all stay whole, some that soften, and many that break, slide and hand over to contact.
fn joints_are_those_of_the_processor<const D: usize, const N: usize>()
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    for (speed, energy, stressed) in [(0.01, 300.0, false), (1.0, 3000.0, true), (15.0, 300.0, false)] {
        let mut model = joined::<D, N>(speed, energy);
        if stressed {
            let mut stress = [[0.0; D]; D];
            (0..D).for_each(|axis| stress[axis][axis] = -1e5);
            model.stresses = vec![stress; model.mesh.elements.len()];
        }
        let mut expected = Simulation::new(model.clone(), 1).unwrap();
        expected.advance(100).unwrap();
        let softened = expected.energies().joint_dissipated();
        let broken = expected.counts().broken;
        match speed {
            15.0 => assert!(broken > 20 && expected.counts().contacts > 0, "{:?}", expected.counts()),
            1.0 => assert!(broken == 0 && softened > 1.0, "{broken} broken, {softened} J"),
            _ => assert!(broken == 0 && softened.abs() < 1e-9, "{broken} broken, {softened} J"),
        }
        same(&model, 100, 0.0);
    }
}

#[test]
fn joints_of_triangles_are_those_of_the_processor() {
    joints_are_those_of_the_processor::<2, 3>();
}

#[test]
fn joints_of_tetrahedra_are_those_of_the_processor() {
    joints_are_those_of_the_processor::<3, 4>();
}

/// A run that begins on the processor, goes to a device, is changed between its steps, and ends on the
/// processor has the state of a run that never left it.
#[test]
fn a_run_goes_to_a_device_and_back() {
    let model = loaded::<2, 3>(0.1, false);
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    let mut run = Simulation::new(model, 1).unwrap();
    let mut both = |steps: u64, change: &dyn Fn(&mut Simulation), place: &dyn Fn(&mut Simulation)| {
        place(&mut run);
        for run in [&mut run, &mut expected] {
            change(run);
            run.advance(steps).unwrap();
        }
        assert!(bytes(&run) == bytes(&expected), "after {} steps", run.steps());
    };
    let unchanged = |_: &mut Simulation| {};
    let faster = |run: &mut Simulation| run.set_velocities(&[100, 101], &[[3.0, 1.0]; 2]).unwrap();
    let stay = |_: &mut Simulation| {};
    both(30, &unchanged, &stay);
    both(40, &unchanged, &|run| put_on(run, HostBuild::Ascending).unwrap());
    both(40, &faster, &stay);
    both(40, &faster, &Simulation::take_back);
    both(40, &unchanged, &|run| put_on(run, HostBuild::Descending).unwrap());
}

/// A device that counts the bytes that it sends to the host, and those that it gets.
struct Counted(Host, [AtomicUsize; 2]);

impl Counted {
    fn new() -> Arc<Self> {
        Arc::new(Self(Host(HostBuild::Ascending), Default::default()))
    }

    /// Bytes that have been sent so far, and those that it has got.
    fn bytes(&self) -> [usize; 2] {
        self.1.each_ref().map(|count| count.load(Ordering::Relaxed))
    }
}

impl Device for Counted {
    type Memory = <Host as Device>::Memory;

    fn allocate(&self, bytes: usize) -> Result<Self::Memory, GpuError> {
        self.0.allocate(bytes)
    }

    fn address(&self, memory: &Self::Memory) -> u64 {
        self.0.address(memory)
    }

    fn bytes(&self, memory: &Self::Memory) -> usize {
        self.0.bytes(memory)
    }

    fn write(&self, to: &mut Self::Memory, bytes: &[u8]) -> Result<(), GpuError> {
        self.1[1].fetch_add(bytes.len(), Ordering::Relaxed);
        self.0.write(to, bytes)
    }

    fn read(&self, from: &Self::Memory, offset: usize, bytes: &mut [u8]) -> Result<(), GpuError> {
        self.1[0].fetch_add(bytes.len(), Ordering::Relaxed);
        self.0.read(from, offset, bytes)
    }

    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u64]) -> Result<(), GpuError> {
        self.0.launch(kernel, blocks, arguments)
    }
}

/// Steps with supports, loads and whole joints copy sums and the nodes of supports and loads, and no columns.
#[test]
fn quiet_steps_copy_no_columns() {
    let mut model = joined::<2, 3>(0.01, 300.0);
    let load = |name: &str, target, load| boundary(name, target, load, Schedule::Constant);
    model.boundaries.push(load("pull", Target::Nodes(vec![30]), Load::Force([1.0; 2])));
    model.boundaries.push(load("press", facets(&model, 1, 1.0), Load::Pressure(10.0)));
    let elements = model.mesh.elements.len();
    let device = Counted::new();
    let mut run = Simulation::new(model, 1).unwrap();
    run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))).unwrap();
    run.advance(1).unwrap();
    let [before, _] = device.bytes();
    run.advance(60).unwrap();
    let copied = device.bytes()[0] - before;
    // A step copies 12 kB, and all columns have 70 kB: once it is done.
    assert!(copied < 60 * 12_500 + 80_000, "{copied} bytes, {elements} elements");
    assert_eq!(run.counts().broken, 0);
}

/// Rows of a history read the values that they need from the device, and no columns. `most`: bytes of a row.
fn histories_copy_no_columns<const D: usize, const N: usize>(model: &Model<D, N>, most: usize)
where
    [[f64; D]; N]: Element<D, N>,
{
    let supported: Vec<u32> = (0..model.mesh.nodes.len() as u32).collect();
    let point = |element: u32| {
        let corners = model.mesh.elements[element as usize].map(|node| model.mesh.nodes[node as usize]);
        let middle = std::array::from_fn(|axis| corners.iter().map(|at| at[axis]).sum::<f64>() / N as f64);
        MaterialPoint::at(&model.mesh, middle, |_| true).unwrap()
    };
    let probes = [
        Probe::Stress(vec![3]),
        Probe::Stress(vec![1, 4, 7]),
        Probe::Strain(vec![2, 5]),
        Probe::Velocity(vec![8]),
        Probe::PointVelocity(point(6)),
        Probe::Gauge { ends: [point(1), point(9)], span: vec![0.5; D] },
        Probe::Reaction(supported),
    ];
    let device = Counted::new();
    let [mut expected, mut run, mut other] = [(); 3].map(|()| Simulation::new(model.clone(), 1).unwrap());
    for run in [&mut run, &mut other] {
        run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))).unwrap();
    }
    let mut sent = [0; 3];
    for step in 0..21 {
        let before = device.bytes()[0];
        other.advance_unsettled(3).unwrap();
        let between = device.bytes()[0];
        run.advance_unsettled(3).unwrap();
        expected.advance(3).unwrap();
        assert_eq!(run.measure(&probes), expected.measure(&probes));
        assert_eq!(run.nodes(&[5, 17]), expected.nodes(&[5, 17]));
        assert_eq!(run.energies(), expected.energies());
        assert_eq!(run.counts(), expected.counts());
        assert_eq!(run.fragments(), expected.fragments());
        assert_eq!(run.crack_lengths(), expected.crack_lengths());
        assert_eq!(run.force(0), expected.force(0));
        assert_eq!(run.imbalance().to_bits(), expected.imbalance().to_bits());
        run.check_device().unwrap();
        // The first steps exchange columns that the host has.
        if step > 0 {
            sent[0] += between - before;
            sent[1] += device.bytes()[0] - between;
        }
    }
    let before = device.bytes()[0];
    run.settle().unwrap();
    sent[2] = device.bytes()[0] - before;
    // Probes of joints and contacts need all columns.
    let softening = [Probe::Softening];
    run.advance_unsettled(1).unwrap();
    expected.advance(1).unwrap();
    assert_eq!(run.measure(&softening), expected.measure(&softening));
    assert_eq!(run.snapshot(), expected.snapshot());
    let [steps, rows, columns] = sent;
    assert!(
        rows > steps && rows - steps < 20 * most,
        "{} bytes a row, all columns {columns}",
        (rows - steps) / 20
    );
    assert!(steps < 20 * columns, "{} bytes for three steps", steps / 20);
    assert_eq!(expected.counts().broken, 0);
}

#[test]
fn rows_of_histories_copy_no_columns() {
    histories_copy_no_columns(&joined::<2, 3>(0.01, 300.0), 1000);
    histories_copy_no_columns(&bedding::bedded(joined::<2, 3>(0.01, 300.0), true), 1000);
    histories_copy_no_columns(&joined::<3, 4>(0.01, 300.0), 1800);
    histories_copy_no_columns(&meeting::<2, 3>(20), 1000);
}

/// A body and one above it that falls on it and slides along it.
fn meeting<const D: usize, const N: usize>(cells: usize) -> Model<D, N> {
    let mut model = model_of::<D, N>(cells, 0.1, [0.0; D]);
    let first = model.mesh.nodes.len() as u32;
    let (nodes, elements) = (model.mesh.nodes.clone(), model.mesh.elements.clone());
    let along = |of: usize, value: f64, rest: f64| -> [f64; D] {
        std::array::from_fn(|axis| if axis == of { value } else { rest })
    };
    let (by, velocity) = (along(D - 1, 1.005, 0.1), along(D - 1, -8.0, 2.0));
    let moved = nodes.iter().map(|node| std::array::from_fn(|axis| node[axis] + by[axis]));
    model.mesh.nodes.extend(moved);
    model.mesh.elements.extend(elements.iter().map(|element| element.map(|node| node + first)));
    model.mesh.bodies.extend(vec![1; elements.len()]);
    model.mesh.materials.extend_from_within(..);
    model.velocities.extend(vec![velocity; nodes.len()]);
    model.contact.damping = 0.2;
    model
}

/// Bodies that meet and part again, with friction and damping, and bodies that overlap at the beginning.
fn contacts_are_those_of_the_processor<const D: usize, const N: usize>(cells: usize, steps: u64)
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let model = meeting::<D, N>(cells);
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    expected.advance(steps).unwrap();
    assert!(expected.counts().contacts > 10, "{:?}", expected.counts());
    let energies = expected.energies();
    assert!(energies.contact > 0.0 && energies.friction > 0.0, "{energies:?}");
    same(&model, steps, 1e-3);
    for overlap in [InitialOverlap::Ignore, InitialOverlap::Relax] {
        let mut model = model.clone();
        model.contact.initial_overlap = overlap;
        let upper = model.mesh.nodes.len() / 2..;
        model.mesh.nodes[upper].iter_mut().for_each(|node| node[D - 1] -= 0.01);
        same(&model, steps / 2, 1e-4);
    }
}

#[test]
fn triangles_that_meet_have_the_state_of_the_processor() {
    contacts_are_those_of_the_processor::<2, 3>(20, 60);
}

#[test]
fn tetrahedra_that_meet_have_the_state_of_the_processor() {
    contacts_are_those_of_the_processor::<3, 4>(4, 40);
}

/// Bodies that sink deep into each other, because their contacts are soft.
#[test]
fn the_first_deep_overlap_is_that_of_the_processor() {
    let mut model = meeting::<2, 3>(8);
    model.contact.penalty = 1e-3;
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    let mut run = Simulation::new(model, 1).unwrap();
    put_on(&mut run, HostBuild::Descending).unwrap();
    let mut found = Vec::new();
    for _ in 0..15 {
        run.advance(4).unwrap();
        expected.advance(4).unwrap();
        assert_eq!(run.penetrated(), expected.penetrated());
        found.push(expected.penetrated());
    }
    assert!(found.contains(&None) && found.iter().flatten().count() > 2, "{found:?}");
}

/// Runs whose bodies touch go to a device and back, and to another one.
fn contacts_go_to_a_device_and_back<const D: usize, const N: usize>(mut model: Model<D, N>, steps: u64)
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    model.contact.initial_overlap = InitialOverlap::Ignore;
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    let mut run = Simulation::new(model, 1).unwrap();
    let mut contacts = 0;
    let places: [&dyn Fn(&mut Simulation<D, N>); 5] = [
        &|run| put_on(run, HostBuild::Ascending).unwrap(),
        &Simulation::take_back,
        &|run| put_on(run, HostBuild::Descending).unwrap(),
        &|_| {},
        &|run| put_on(run, HostBuild::Ascending).unwrap(),
    ];
    for place in places {
        place(&mut run);
        run.advance(steps).unwrap();
        expected.advance(steps).unwrap();
        assert!(bytes(&run) == bytes(&expected), "after {} steps", run.steps());
        contacts += u32::from(expected.counts().contacts > 5);
    }
    assert!(contacts > 2, "{contacts}");
}

#[test]
fn runs_go_to_a_device_and_back_while_bodies_touch() {
    contacts_go_to_a_device_and_back(meeting::<2, 3>(12), 20);
    contacts_go_to_a_device_and_back(meeting::<3, 4>(3), 10);
    contacts_go_to_a_device_and_back(joined::<2, 3>(15.0, 300.0), 40);
    contacts_go_to_a_device_and_back(joined::<3, 4>(15.0, 300.0), 25);
}

/// Steps in which bodies touch copy sums, and no columns, but for the positions of the elements that can
/// touch where couples of these are searched, and couples where they are chosen anew.
#[test]
fn steps_in_contact_copy_no_columns() {
    let device = Counted::new();
    let mut run = Simulation::new(meeting::<2, 3>(20), 1).unwrap();
    run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))).unwrap();
    run.advance(40).unwrap();
    let (before, detections) = (device.bytes(), run.counts().detections);
    run.advance(60).unwrap();
    let [sent, got] = [0, 1].map(|way| device.bytes()[way] - before[way]);
    let searched = run.counts().detections - detections;
    // The sums of a step have 15 kB, positions of a search 5 kB, and all columns 250 kB: once it is done.
    // With all nodes and couples in each search it would be 1.6 MB.
    assert!(searched > 5 && sent < 1_450_000, "{sent} bytes, {searched} detections");
    // Couples, where they are chosen anew.
    assert!(got < 550_000, "{got} bytes");
    assert!(run.counts().contacts > 10, "{:?}", run.counts());
}

/// An element that turns inside out, and a node that is too fast, stop a run as on the processor.
#[test]
fn runs_stop_as_on_the_processor() {
    for (speed, step) in [(400.0, None), (3.0, Some(1e-2))] {
        let mut model = model::<2, 3>(0.0, [0.0; 2]);
        model.velocities[230] = [speed, 0.0];
        model.time.step = step;
        let mut expected = Simulation::new(model.clone(), 1).unwrap();
        let mut run = Simulation::new(model, 1).unwrap();
        put_on(&mut run, HostBuild::Ascending).unwrap();
        let [stop, expected_stop] = [&mut run, &mut expected].map(|run| run.advance(200).unwrap_err());
        assert_eq!(stop.to_string(), expected_stop.to_string());
        assert_eq!(run.steps(), expected.steps());
    }
}

/// The same on a card, if there is one.
#[cfg(feature = "cuda")]
#[test]
fn runs_on_a_card_have_the_states_of_the_processor() {
    fn compare<const D: usize, const N: usize>(card: &Arc<fdem_gpu::Cuda>, model: Model<D, N>)
    where
        [[f64; D]; N]: Element<D, N>,
        State<D, N>: Serialize,
    {
        let mut expected = Simulation::new(model.clone(), 1).unwrap();
        let mut run = Simulation::new(model, 1).unwrap();
        run.put_on(Box::new(DeviceSolid::new(Arc::clone(card)))).unwrap();
        for steps in [1, 2, 150] {
            expected.advance(steps).unwrap();
            run.advance(steps).unwrap();
            assert!(bytes(&run) == bytes(&expected), "after {} steps", run.steps());
        }
    }
    if fdem_gpu::devices().is_ok_and(|devices| !devices.is_empty()) {
        let card = Arc::new(fdem_gpu::Cuda::new(0).unwrap());
        compare(&card, model::<2, 3>(0.0, [0.0, -9.81]));
        compare(&card, model::<3, 4>(0.0, [0.0, 0.0, -9.81]));
        compare(&card, loaded::<2, 3>(0.1, false));
        compare(&card, loaded::<3, 4>(0.1, true));
        compare(&card, meeting::<2, 3>(20));
        compare(&card, meeting::<3, 4>(4));
        compare(&card, joined::<2, 3>(15.0, 300.0));
        compare(&card, joined::<3, 4>(1.0, 3000.0));
    }
}
