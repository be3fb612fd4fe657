//! Joints that are inserted on a device's run, and nodes that are split there.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use fdem_gpu::kernels::Kernel;
use fdem_gpu::{Device, DeviceSolid, GpuError, Host, HostBuild};
use fdem_simulation::{
    Element, FractureOptions, JointSet, Load, Model, Schedule, Simulation, State, Strength, Target,
};
use serde::Serialize;

use crate::{Counted, boundary, bytes, facets, joined, meeting, model_of, put_on, side};

/// A body that is drawn and shaken until it breaks in many places. `damping`: of elements, and of nodes.
fn breaking<const D: usize, const N: usize>(speed: f64, [damping, local]: [f64; 2]) -> Model<D, N> {
    let mut model = joined::<D, N>(speed, 30.0);
    model.fracture = FractureOptions::default();
    model.materials.iter_mut().for_each(|material| material.damping = damping);
    model.time.local_damping = local;
    model.boundaries[1].schedule = Schedule::Constant;
    let load = |name: &str, target, load| boundary(name, target, load, Schedule::Constant);
    model.boundaries.push(load("pull", Target::Nodes(vec![17, 18]), Load::Force([2e3; D])));
    model.boundaries.push(load("press", facets(&model, 1, 1.0), Load::Pressure(1e4)));
    model
}

/// The same with joints of a set on a plane across it, which slide and dilate.
fn with_set<const D: usize, const N: usize>(mut model: Model<D, N>) -> Model<D, N>
where
    [[f64; D]; N]: Element<D, N>,
{
    model.joint_sets = vec![JointSet {
        name: "plane".to_owned(),
        strength: Strength { tensile: 2e5, cohesion: 3e5, ..model.materials[0].strength.unwrap() },
        residual_friction: 0.3,
        dilation: 0.1,
        dilation_slip: None,
        normal_stiffness: None,
        shear_stiffness: None,
        open: false,
    }];
    let cells = if D == 2 { 9 } else { 3 };
    let on_plane = |node: &u32| *node as usize / (cells + 1) % (cells + 1) == cells / 2;
    let of_element: &[&[usize]] = match D {
        2 => &[&[0, 1], &[1, 2], &[2, 0]],
        _ => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
    };
    let all = model.mesh.elements.iter().flat_map(|nodes| {
        of_element.iter().map(move |corners| std::array::from_fn::<u32, D, _>(|k| nodes[corners[k]]))
    });
    let plane: Vec<[u32; D]> = all.filter(|facet| facet.iter().all(on_plane)).collect();
    assert!(model.add_joints(0, &plane) > 3);
    model
}

/// Runs a model on the processor, on a device from the beginning on, and on one only in between. `least`:
/// numbers of insertions and of breaks that there are to be.
fn parts_as_on_the_processor<const D: usize, const N: usize>(
    model: &Model<D, N>,
    [insertions, breaks]: [usize; 2],
) where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let new = || Simulation::new(model.clone(), 1).unwrap();
    let (mut expected, mut placed, mut moved) = (new(), new(), new());
    let first = expected.counts();
    put_on(&mut placed, HostBuild::Ascending).unwrap();
    for (part, steps) in [3, 60, 60, 60, 60, 40].into_iter().enumerate() {
        match part {
            1 | 4 => put_on(&mut moved, HostBuild::Descending).unwrap(),
            3 => moved.take_back(),
            _ => {}
        }
        expected.advance(steps).unwrap();
        for run in [&mut placed, &mut moved] {
            run.advance(steps).unwrap();
            assert_eq!(run.counts(), expected.counts());
            assert!(bytes(run) == bytes(&expected), "after {} steps", run.steps());
            assert_eq!(run.energies(), expected.energies());
            assert!(run.snapshot() == expected.snapshot() && run.forces() == expected.forces());
        }
        // Changes between steps.
        if part == 2 {
            for run in [&mut expected, &mut placed, &mut moved] {
                run.set_velocities(&[20, 21], &[[0.3; D]; 2]).unwrap();
            }
        }
    }
    let counts = expected.counts();
    let inserted = counts.joints + counts.broken - first.joints;
    assert!(inserted > insertions && counts.broken > breaks, "{counts:?}, {first:?} before");
    assert!(counts.nodes > first.nodes + breaks, "{counts:?}, {first:?} before");
}

#[test]
fn triangles_part_as_on_the_processor() {
    for (speed, damping) in [(1.0, [0.0; 2]), (0.5, [0.1, 0.2]), (8.0, [0.05, 0.0])] {
        parts_as_on_the_processor(&breaking::<2, 3>(speed, damping), [20, 5]);
    }
    parts_as_on_the_processor(&with_set(breaking::<2, 3>(1.0, [0.05, 0.1])), [20, 5]);
}

#[test]
fn tetrahedra_part_as_on_the_processor() {
    for (speed, damping) in [(1.0, [0.0; 2]), (0.5, [0.1, 0.2])] {
        parts_as_on_the_processor(&breaking::<3, 4>(speed, damping), [20, 5]);
    }
    parts_as_on_the_processor(&with_set(breaking::<3, 4>(1.0, [0.05, 0.1])), [20, 5]);
}

/// A device that counts the bytes that it sends and takes.
struct Traffic(Host, [AtomicUsize; 2]);

impl Traffic {
    fn new() -> Arc<Self> {
        Arc::new(Self(Host(HostBuild::Ascending), Default::default()))
    }

    /// Bytes sent and taken since the last call.
    fn take(&self) -> [usize; 2] {
        self.1.each_ref().map(|bytes| bytes.swap(0, Ordering::Relaxed))
    }
}

impl Device for Traffic {
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

/// A run of a body that is drawn with a strain rate, 1/s, and breaks at a tensile strength, Pa, if it has
/// one. Returns the bytes that all columns have, at most, and the traffic of steps, some at a time, with the
/// number of their insertions.
fn drawn<const D: usize, const N: usize>(
    rate: f64,
    strength: Option<f64>,
    steps: u64,
) -> (usize, Vec<([usize; 2], usize)>)
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let mut model = model_of::<D, N>(if D == 2 { 30 } else { 6 }, 0.0, [0.0; D]);
    let weak = joined::<D, N>(1.0, 30.0).materials[0].strength.unwrap();
    for material in &mut model.materials {
        material.youngs_modulus *= 1e3;
        material.strength =
            strength.map(|strength| Strength { tensile: strength, cohesion: 2.0 * strength, ..weak });
    }
    let along = |speed: f64| std::array::from_fn(|axis| if axis == 0 { speed } else { 0.0 });
    model.velocities = model.mesh.nodes.iter().map(|place| along(rate * place[0])).collect();
    let held = |name: &str, at: f64| {
        let mut velocity = [None; D];
        velocity[0] = Some(rate * at);
        boundary(name, side(&model, 0, at), Load::Velocity(velocity), Schedule::Constant)
    };
    model.boundaries = vec![held("left", 0.0), held("right", 1.0)];
    let device = Traffic::new();
    let mut expected = Simulation::new(model.clone(), 1).unwrap();
    let mut run = Simulation::new(model, 1).unwrap();
    run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))).unwrap();
    run.advance(1).unwrap();
    let [columns, _] = device.take();
    let mut before = run.counts().joints;
    let measure = |_| {
        run.advance(steps).unwrap();
        let joints = run.counts().joints + run.counts().broken;
        (device.take(), joints - std::mem::replace(&mut before, joints))
    };
    let traffic = (0..8).map(measure).collect();
    expected.advance(8 * steps + 1).unwrap();
    assert!(bytes(&run) == bytes(&expected));
    (columns, traffic)
}

/// Steps in which no facet may fail send as much as those of a body that cannot break: they count the facets
/// that may.
#[test]
fn quiet_steps_of_bodies_that_may_break_copy_no_columns() {
    let (_, may_break) = drawn::<2, 3>(1e-4, Some(1e6), 50);
    let (_, cannot) = drawn::<2, 3>(1e-4, None, 50);
    assert_eq!(may_break, cannot);
}

/// Where bodies that may break touch, a step reads which couples do, and no histories of these.
#[test]
fn steps_in_contact_of_bodies_that_may_break_read_no_couples() {
    let sent = |strength: Option<f64>| {
        let mut model = meeting::<2, 3>(20);
        let [of_rock, _] = &joined::<2, 3>(0.0, 3000.0).materials[..] else { panic!("two materials") };
        for material in &mut model.materials {
            material.strength =
                strength.map(|size| Strength { tensile: size, cohesion: size, ..of_rock.strength.unwrap() });
        }
        let device = Counted::new();
        let mut run = Simulation::new(model, 1).unwrap();
        run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))).unwrap();
        run.advance(40).unwrap();
        let before = device.bytes()[0];
        run.advance_unsettled(60).unwrap();
        assert!(run.counts().contacts > 10 && run.counts().joints == 0, "{:?}", run.counts());
        device.bytes()[0] - before
    };
    let (may_break, cannot) = (sent(Some(1e12)), sent(None));
    // The elements around those that touch have 113 kB, the histories of couples 20 kB.
    assert!(may_break - cannot < 60 * 115_000, "{} bytes more in a step", (may_break - cannot) / 60);
}

/// Steps with few insertions copy the values around these, and no columns.
#[test]
fn steps_with_few_insertions_copy_no_columns() {
    let (columns, traffic) = drawn::<2, 3>(0.5, Some(1e6), 50);
    let few = traffic.iter().filter(|(_, inserted)| *inserted > 0 && *inserted < 50);
    assert!(few.clone().count() > 1, "{traffic:?}");
    for ([sent, taken], _) in few {
        let all = 50 * columns;
        assert!(*sent < all / 2 && *taken < all / 4, "{traffic:?}, columns: {columns}");
    }
}

/// A body of 1296 tetrahedra in which some facets fail in most steps, and many in others.
#[test]
fn many_tetrahedra_part_as_on_the_processor() {
    let (_, traffic) = drawn::<3, 4>(0.5, Some(4e5), 10);
    let inserted: Vec<usize> = traffic.into_iter().map(|(_, inserted)| inserted).collect();
    assert!(inserted.iter().sum::<usize>() > 500, "{inserted:?}");
}
