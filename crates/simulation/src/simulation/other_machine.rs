//! A run on a second machine: the same bits.

use std::sync::{Arc, Mutex, OnceLock};

use fdem_mesh::Mesh;
use serde::Serialize;

use crate::cohesive::tests::ROCK;
use crate::contacts::Touching;
use crate::error::Stop;
use crate::joints::Pulling;
use crate::laws::MaterialLaw;
use crate::machine::list::Machines;
use crate::machine::{Columns, Machine};
use crate::model::{Boundary, Load, Material, Model, Schedule, Target};
use crate::motion::nodes::Motion;
use crate::motion::{MotionSums, Selected};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::simulation::advance::Concrete;
use crate::simulation::run::Simulation;
use crate::simulation::saved::State;
use crate::solid::Node;
use crate::sum::Sum;
use crate::team::Team;
use crate::topology::Topology;
use crate::vector::Point;

/// The phases of a step without other ranks, in their order.
const STEP: [&str; 9] =
    ["deform", "pull", "detect", "touch", "add forces", "failing", "move nodes", "move nodes", "end motion"];

/// A machine with a memory of its own, as a graphics processor has. The host gets a copy of the columns when
/// it asks for them, and the next phase takes over the changes of the host.
#[derive(Debug)]
struct Device<const D: usize, const N: usize> {
    own: Box<dyn Machine<D, N>>,
    /// The columns of the host since the last phase, and whether it may have changed them.
    host: OnceLock<Columns<D, N>>,
    changed: bool,
    /// Whether all facets are checked in every step.
    sleepless: bool,
    /// All phases so far, and the number of copies for the host.
    phases: Arc<Mutex<Vec<&'static str>>>,
    copies: Arc<Mutex<usize>>,
}

impl<const D: usize, const N: usize> Device<D, N> {
    /// The memory of the device for a phase. The columns of the host are lost.
    fn begin(&mut self, phase: &'static str) -> &mut dyn Machine<D, N> {
        self.phases.lock().expect("phases").push(phase);
        if let Some(columns) = self.host.take().filter(|_| self.changed) {
            *self.own.columns_mut() = columns;
        }
        self.changed = false;
        &mut *self.own
    }
}

impl<const D: usize, const N: usize> Machine<D, N> for Device<D, N> {
    fn deform(&mut self, step: f64) -> Option<(u32, f64)> {
        self.begin("deform").deform(step)
    }

    fn pull(&mut self, step: f64, time: f64, energies: bool) -> Pulling {
        self.begin("pull").pull(step, time, energies)
    }

    fn detect(&mut self, topology: &Topology<D, N>) -> Result<(), Stop> {
        self.begin("detect").detect(topology)
    }

    fn touch(&mut self, topology: &Topology<D, N>, step: f64, energies: bool) -> Touching {
        self.begin("touch").touch(topology, step, energies)
    }

    fn add_forces(&mut self, forces: &[(u32, Point<D>)]) {
        self.begin("add forces").add_forces(forces);
    }

    fn failing(&mut self, model: &Model<D, N>, topology: &Topology<D, N>) -> Vec<u32> {
        if self.sleepless {
            let solid = &mut self.own.columns_mut().solid;
            (0..solid.element_count() as u32).for_each(|element| solid.wake(element));
        }
        self.begin("failing").failing(model, topology)
    }

    fn move_nodes(
        &mut self,
        motion: &Motion<'_, D, N>,
        selected: Selected<'_>,
        sums: &mut MotionSums<Sum, D>,
    ) {
        self.begin("move nodes").move_nodes(motion, selected, sums);
    }

    fn read_nodes(&self, nodes: &[u32], each: &mut dyn FnMut(Node<D>)) {
        self.own.read_nodes(nodes, each);
    }

    fn read_corners(&self, corners: &[u32], each: &mut dyn FnMut(Node<D>)) {
        self.own.read_corners(corners, each);
    }

    fn share(&self) -> &Share {
        self.own.share()
    }

    fn write_nodes(&mut self, nodes: &[u32], next: &mut dyn FnMut() -> Node<D>) {
        self.begin("write nodes").write_nodes(nodes, next);
    }

    fn end_motion(&mut self, distance: f64) {
        self.begin("end motion").end_motion(distance);
    }

    fn energies(&self) -> [Sum; 2] {
        self.own.energies()
    }

    fn columns(&self) -> &Columns<D, N> {
        self.host.get_or_init(|| {
            *self.copies.lock().expect("copies") += 1;
            self.own.columns().clone()
        })
    }

    fn columns_mut(&mut self) -> &mut Columns<D, N> {
        self.columns();
        self.changed = true;
        self.host.get_mut().expect("columns of the host")
    }
}

/// A grid of cells, each divided into the simplices along the ways through it.
fn grid<const D: usize, const N: usize>(min: Point<D>, cell: f64, cells: [usize; D]) -> Mesh<D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    let number = |at: &[usize; D]| (0..D).rev().fold(0, |sum, axis| sum * (cells[axis] + 1) + at[axis]);
    let points = |more: usize| {
        let count: usize = cells.iter().map(|count| count + more).product();
        (0..count).map(move |mut rest| {
            std::array::from_fn::<usize, D, _>(|axis| {
                let place = rest % (cells[axis] + more);
                rest /= cells[axis] + more;
                place
            })
        })
    };
    let nodes: Vec<Point<D>> =
        points(1).map(|at| std::array::from_fn(|axis| min[axis] + cell * at[axis] as f64)).collect();
    let mut ways = vec![Vec::new()];
    for _ in 0..D {
        let longer = |way: Vec<usize>| {
            let axes: Vec<usize> = (0..D).filter(|axis| !way.contains(axis)).collect();
            axes.into_iter().map(move |axis| [&way[..], &[axis]].concat())
        };
        ways = ways.into_iter().flat_map(longer).collect();
    }
    let mut elements = Vec::new();
    for first in points(0) {
        for way in &ways {
            let mut at = first;
            let mut element = [number(&at) as u32; N];
            for (corner, &axis) in element[1..].iter_mut().zip(way) {
                at[axis] += 1;
                *corner = number(&at) as u32;
            }
            if element.map(|node| nodes[node as usize]).measure() < 0.0 {
                element.swap(0, 1);
            }
            elements.push(element);
        }
    }
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// A block that falls on another, pushed by a force, and breaks.
fn crash<const D: usize, const N: usize>(speed: f64) -> Model<D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    let (mut low, mut high) = ([0.0; D], [0.013; D]);
    (low[D - 1], high[D - 1]) = (-0.04, 1e-4);
    let mut cells = [4; D];
    cells[D - 1] = 2;
    let mut mesh = grid::<D, N>(low, 0.02, cells);
    let block = grid::<D, N>(high, 0.013, [3; D]);
    let floor = (0..mesh.nodes.len() as u32).filter(|&node| mesh.nodes[node as usize][D - 1] < -0.039);
    let floor = Target::Nodes(floor.collect());
    let first = mesh.nodes.len() as u32;
    let mut velocities = vec![[0.0; D]; mesh.nodes.len()];
    velocities.extend(
        block.nodes.iter().map(|_| std::array::from_fn(|axis| if axis == D - 1 { -speed } else { 1.0 })),
    );
    mesh.nodes.extend(&block.nodes);
    mesh.elements.extend(block.elements.iter().map(|nodes| nodes.map(|node| node + first)));
    mesh.bodies.extend(block.bodies.iter().map(|_| 1));
    mesh.materials.extend(&block.materials);
    let boundary = |name: &str, target, load| Boundary {
        name: name.to_owned(),
        target,
        load,
        schedule: Schedule::Constant,
    };
    let mut push = [0.0; D];
    push[0] = 1e3;
    Model {
        boundaries: vec![
            boundary("floor", floor, Load::Velocity([Some(0.0); D])),
            boundary("push", Target::Nodes(vec![first, first + 1]), Load::Force(push)),
        ],
        mesh,
        velocities,
        materials: vec![Material {
            name: "rock".to_owned(),
            density: 2700.0,
            youngs_modulus: 30e9,
            poissons_ratio: 0.2,
            law: MaterialLaw::NeoHookean,
            damping: 0.05,
            strength: Some(ROCK),
            friction: 0.5,
        }],
        gravity: std::array::from_fn(|axis| if axis == D - 1 { -9.81 } else { 0.0 }),
        ..Model::default()
    }
}

/// Puts a run on a device. Returns its phases, and its copies for the host.
fn put_on_device<const D: usize, const N: usize>(
    run: &mut Simulation<D, N>,
) -> (Arc<Mutex<Vec<&'static str>>>, Arc<Mutex<usize>>)
where
    [[f64; D]; N]: Concrete<D, N>,
{
    let (phases, copies) = (Arc::default(), Arc::default());
    let columns = run.machine.columns().clone();
    run.machine = Box::new(Device {
        own: <[[f64; D]; N]>::machine(columns, &Team::new(3).expect("threads")),
        host: OnceLock::new(),
        changed: false,
        sleepless: false,
        phases: Arc::clone(&phases),
        copies: Arc::clone(&copies),
    });
    (phases, copies)
}

fn check<const D: usize, const N: usize>(speed: f64)
where
    [[f64; D]; N]: Concrete<D, N>,
    State<D, N>: Serialize,
{
    let model = crash::<D, N>(speed);
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    let mut other = Simulation::new(model, 1).expect("a model");
    let (phases, copies) = put_on_device(&mut other);
    let (mut done, mut most_contacts) = (0, 0);
    for steps in [1, 120, 280] {
        for run in [&mut run, &mut other] {
            run.advance(steps).expect("steps");
        }
        done += steps as usize;
        most_contacts = most_contacts.max(run.counts().contacts);
        assert_eq!(other.snapshot(), run.snapshot());
        assert_eq!(other.forces(), run.forces());
        assert_eq!(other.energies(), run.energies());
        let [state, expected] = [&other, &run].map(|run| postcard::to_allocvec(&run.state()).expect("bytes"));
        assert!(state == expected, "after {done} steps");
        // A program changes columns between steps.
        for run in [&mut run, &mut other] {
            run.set_velocities(&[0, 1], &[[0.5; D]; 2]).expect("velocities");
        }
    }
    assert_eq!(*phases.lock().expect("phases"), STEP.repeat(done));
    assert!(*copies.lock().expect("copies") > 5, "the host reads columns where bodies break");
    let counts = run.counts();
    assert!(counts.broken > 5 && most_contacts > 0, "it should have broken and touched: {counts:?}");
}

/// Insertion, splitting, audits, snapshots and changes by a program reach the columns of a machine that has
/// a memory of its own.
#[test]
fn a_machine_with_its_own_memory_gives_the_same_bits() {
    check::<2, 3>(10.0);
    check::<3, 4>(10.0);
}

/// A block that is drawn along its last axis until it breaks.
fn drawn<const D: usize, const N: usize>() -> Model<D, N>
where
    [[f64; D]; N]: Concrete<D, N>,
{
    let mut cells = [4; D];
    cells[D - 1] = 8;
    let mesh = grid::<D, N>([0.0; D], 0.02, cells);
    let rate =
        |place: &Point<D>| std::array::from_fn(|axis| if axis == D - 1 { 0.8 * place[axis] } else { 0.0 });
    let velocities: Vec<Point<D>> = mesh.nodes.iter().map(rate).collect();
    let end = |name: &str, at: f64| {
        let there = |node: &u32| (mesh.nodes[*node as usize][D - 1] - at).abs() < 1e-9;
        let mut velocity = [None; D];
        velocity[D - 1] = Some(0.8 * at);
        Boundary {
            name: name.to_owned(),
            target: Target::Nodes((0..mesh.nodes.len() as u32).filter(there).collect()),
            load: Load::Velocity(velocity),
            schedule: Schedule::Constant,
        }
    };
    let boundaries = vec![end("bottom", 0.0), end("top", 0.16)];
    let mut model = Model { mesh, boundaries, velocities, ..crash::<D, N>(0.0) };
    model.gravity = [0.0; D];
    for strength in model.materials.iter_mut().filter_map(|material| material.strength.as_mut()) {
        strength.weibull_modulus = Some(8.0);
    }
    model
}

fn sleeps<const D: usize, const N: usize>()
where
    [[f64; D]; N]: Concrete<D, N>,
    State<D, N>: Serialize,
{
    for (model, steps) in [(crash::<D, N>(5.0), 400), (drawn::<D, N>(), 900)] {
        let mut run = Simulation::new(model.clone(), 1).expect("a model");
        let mut other = Simulation::new(model, 1).expect("a model");
        other.machine = Box::new(Device {
            own: <[[f64; D]; N]>::machine(other.machine.columns().clone(), &Team::ALONE),
            host: OnceLock::new(),
            changed: false,
            sleepless: true,
            phases: Arc::default(),
            copies: Arc::default(),
        });
        let (mut awake, mut all) = (0, 0);
        for step in 0..steps {
            for run in [&mut run, &mut other] {
                run.advance(1).expect("a step");
            }
            let solid = &run.machine.columns().solid;
            awake += (0..solid.element_count()).filter(|&element| solid.is_awake(element)).count();
            all += solid.element_count();
            if step % 50 == 0 || step == steps - 1 {
                let [state, expected] =
                    [&other, &run].map(|run| postcard::to_allocvec(&run.state()).expect("bytes"));
                assert!(state == expected, "after {step} steps");
            }
        }
        let counts = run.counts();
        assert!(counts.joints > 5, "it should have broken: {counts:?}");
        assert!(4 * awake < 3 * all, "elements should have slept: {awake} of {all}");
    }
}

/// Where a check says how long facets need no other one, checks in each step find nothing more.
#[test]
fn facets_that_are_not_checked_do_not_fail() {
    sleeps::<2, 3>();
    sleeps::<3, 4>();
}

/// Steps without loads and fracture read columns only where energies are summed up.
#[test]
fn quiet_steps_copy_no_columns() {
    let mut model = crash::<2, 3>(10.0);
    model.boundaries.truncate(1);
    model.materials[0].strength = None;
    let mut run = Simulation::new(model, 1).expect("a model");
    let (_, copies) = put_on_device(&mut run);
    run.advance(1).expect("steps");
    let before = *copies.lock().expect("copies");
    run.advance(60).expect("steps");
    assert_eq!(*copies.lock().expect("copies"), before + 1, "for the energies of the last step");
}
