//! Rigid bodies, and surfaces that touch from the beginning, on a device's run.

use fdem_gpu::HostBuild;
use fdem_simulation::{
    Bedding, Element, Insertion, Load, MaterialLaw, Model, Schedule, Simulation, State, Target,
    UntilOverloaded,
};
use serde::Serialize;

use crate::{boundary, bytes, joined, model, put_on, same};

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

#[test]
fn runs_that_no_device_computes_are_refused() {
    let refused = |model: Model| {
        let mut run = Simulation::new(model, 1).unwrap();
        let error = put_on(&mut run, HostBuild::Ascending).unwrap_err();
        run.advance(3).unwrap();
        error.to_string()
    };
    let mut bedded = model::<2, 3>(0.0, [0.0; 2]);
    bedded.materials[1].law = MaterialLaw::TransverselyIsotropic(Bedding {
        normal: [0.0, 1.0, 0.0],
        youngs_modulus: 4e6,
        poissons_ratio: 0.2,
        shear_modulus: 1e6,
        strength: None,
    });
    assert_eq!(refused(bedded), "a device does not compute a material with bedding");
    let mut overloaded = falling::<2, 3>(false, false);
    overloaded.until_overloaded = vec![UntilOverloaded { body: 1, share: 0.5 }];
    assert_eq!(
        refused(overloaded),
        "a device does not compute bodies that are rigid until they are overloaded"
    );
}
