//! Rigid bodies, and surfaces that touch from the beginning, on a device's run.

use std::sync::Arc;

use fdem_gpu::{DeviceSolid, HostBuild};
use fdem_simulation::{
    Element, Insertion, Load, Model, Schedule, Simulation, State, Target, UntilOverloaded,
};
use serde::Serialize;

use crate::{Counted, boundary, bytes, joined, model, put_on, same};

/// A second body like the first, above it by this distance, m, and moved aside.
fn two_bodies<const D: usize, const N: usize>(mut model: Model<D, N>, distance: f64) -> Model<D, N> {
    let first = model.mesh.nodes.len() as u32;
    let (nodes, elements) = (model.mesh.nodes.clone(), model.mesh.elements.clone());
    let moved = |place: &[f64; D]| {
        std::array::from_fn(|axis| place[axis] + if axis == D - 1 { 1.0 + distance } else { 0.0 })
    };
    model.mesh.nodes.extend(nodes.iter().map(moved));
    model.mesh.elements.extend(elements.iter().map(|element| element.map(|node| node + first)));
    model.mesh.bodies.extend(vec![1; elements.len()]);
    model.mesh.materials.extend_from_within(..);
    model.velocities.extend_from_within(..);
    model
}

/// A rigid body that falls on one that breaks, pushed aside by a force.
fn falling<const D: usize, const N: usize>(turns: bool, relaxes: bool) -> Model<D, N> {
    let mut model = two_bodies(joined::<D, N>(0.2, 30.0), 2e-3);
    model.fracture.insertion = Insertion::Adaptive;
    let first = model.velocities.len() as u32 / 2;
    model.velocities[first as usize..]
        .fill(std::array::from_fn(|axis| if axis == D - 1 { -5.0 } else { 0.5 }));
    model.rigid = vec![1];
    model.boundaries = vec![boundary(
        "push",
        Target::Nodes(vec![first, first + 5]),
        Load::Force([3e3; D]),
        Schedule::Constant,
    )];
    if turns {
        let spin = Load::Rotation { spin: [0.0, 0.0, 2.0], through: [0.4; D] };
        let all = (first..2 * first).collect();
        model.boundaries.push(boundary("turn", Target::Nodes(all), spin, Schedule::Ramp(1e-4)));
    }
    model.time.dynamic_relaxation = relaxes;
    model
}

fn fall_as_on_the_processor<const D: usize, const N: usize>()
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let model = falling::<D, N>(false, false);
    let (mut expected, mut run) =
        (Simulation::new(model.clone(), 1).unwrap(), Simulation::new(model, 1).unwrap());
    let mut touched = 0;
    for part in 0..5 {
        match part {
            0 | 3 => put_on(&mut run, HostBuild::Ascending).unwrap(),
            2 => run.take_back(),
            _ => {}
        }
        for run in [&mut run, &mut expected] {
            run.advance(40).unwrap();
        }
        assert!(bytes(&run) == bytes(&expected), "after {} steps", run.steps());
        assert_eq!(run.energies(), expected.energies());
        touched = touched.max(expected.counts().contacts);
    }
    let counts = expected.counts();
    assert!(touched > 3 && counts.joints + counts.broken > 3, "{touched}, {counts:?}");
    same(&falling::<D, N>(true, false), 60, 1e-4);
}

#[test]
fn rigid_bodies_in_the_plane_move_as_on_the_processor() {
    fall_as_on_the_processor::<2, 3>();
    same(&falling::<2, 3>(false, true), 60, 1e-6);
}

#[test]
fn rigid_bodies_in_space_move_as_on_the_processor() {
    fall_as_on_the_processor::<3, 4>();
}

/// Two bodies that press on each other from the beginning, and slide.
#[test]
fn surfaces_that_touch_from_the_beginning_have_the_state_of_the_processor() {
    let mut model = two_bodies(model::<2, 3>(0.1, [0.0, -2.0]), 0.0);
    model.stresses = vec![[[-1e4, 2e3], [2e3, -3e4]]; model.mesh.elements.len()];
    same(&model, 60, 1e-4);
}

/// Rigid bodies that are overloaded when they fall on another, and deform and break from then on.
fn overloaded_bodies_are_those_of_the_processor<const D: usize, const N: usize>()
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let mut model = falling::<D, N>(false, false);
    model.until_overloaded = vec![UntilOverloaded { body: 1, share: 0.3 }];
    let (mut expected, mut run) =
        (Simulation::new(model.clone(), 1).unwrap(), Simulation::new(model, 1).unwrap());
    let device = Counted::new();
    let (mut sent, mut released) = (Vec::new(), Vec::new());
    for part in 0..7 {
        match part {
            0 | 5 => run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))).unwrap(),
            4 => run.take_back(),
            _ => {}
        }
        for run in [&mut run, &mut expected] {
            run.advance(40).unwrap();
        }
        assert!(bytes(&run) == bytes(&expected), "after {} steps", run.steps());
        assert_eq!(run.energies(), expected.energies());
        assert_eq!(run.snapshot(), expected.snapshot());
        assert_eq!(run.released_bodies(), expected.released_bodies());
        released.push(expected.released_bodies().len());
        sent.push(device.bytes()[0]);
    }
    assert_eq!(released[0], 0, "{released:?}");
    // It is released on the device, and stays there.
    assert!(released[2] == 1 && sent[3] > sent[2] && sent[4] == sent[3], "{released:?}, {sent:?}");
}

#[test]
fn bodies_that_are_overloaded_deform_as_on_the_processor() {
    overloaded_bodies_are_those_of_the_processor::<2, 3>();
    overloaded_bodies_are_those_of_the_processor::<3, 4>();
}
