//! Materials with bedding on a device's run.

use fdem_gpu::HostBuild;
use fdem_simulation::{Bedding, Element, Insertion, MaterialLaw, Model, Simulation, State, Strength};
use serde::Serialize;

use crate::{bytes, joined, loaded, put_on, same};

/// Gives materials a bedding across this direction: all, or the second one only.
pub(crate) fn bedded<const D: usize, const N: usize>(mut model: Model<D, N>, all: bool) -> Model<D, N> {
    for (place, material) in (0..).zip(&mut model.materials).skip(usize::from(!all)) {
        let strength = material.strength;
        material.law = MaterialLaw::TransverselyIsotropic(Bedding {
            normal: std::array::from_fn(|axis| if axis < D { 1.0 + (axis + place) as f64 } else { 0.0 }),
            youngs_modulus: 0.6 * material.youngs_modulus,
            poissons_ratio: 0.1,
            shear_modulus: 0.2 * material.youngs_modulus,
            strength: strength.map(|across| Strength { tensile: 0.4 * across.tensile, ..across }),
        });
    }
    model
}

fn bedded_bodies_are_those_of_the_processor<const D: usize, const N: usize>(steps: u64)
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    // Elements of both laws by turns, and of one law with two normals.
    same(&bedded(loaded::<D, N>(0.1, false), false), steps, 1e-4);
    same(&bedded(loaded::<D, N>(0.0, true), true), steps, 1e-4);
    let mut model = bedded(joined::<D, N>(15.0, 300.0), true);
    model.fracture.insertion = Insertion::Adaptive;
    same(&model, 50, 0.0);
}

#[test]
fn triangles_with_bedding_move_as_on_the_processor() {
    bedded_bodies_are_those_of_the_processor::<2, 3>(100);
}

#[test]
fn tetrahedra_with_bedding_move_as_on_the_processor() {
    bedded_bodies_are_those_of_the_processor::<3, 4>(80);
}

/// Bodies with bedding that break on a device, on the processor, and on a device again.
fn go_to_a_device_and_back<const D: usize, const N: usize>()
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let mut model = bedded(joined::<D, N>(15.0, 300.0), false);
    model.fracture.insertion = Insertion::Adaptive;
    let (mut expected, mut run) =
        (Simulation::new(model.clone(), 1).unwrap(), Simulation::new(model, 1).unwrap());
    for part in 0..4 {
        match part {
            0 | 3 => put_on(&mut run, HostBuild::Descending).unwrap(),
            2 => run.take_back(),
            _ => {}
        }
        for run in [&mut run, &mut expected] {
            run.advance(30).unwrap();
        }
        assert!(bytes(&run) == bytes(&expected), "after {} steps", run.steps());
        assert_eq!(run.snapshot(), expected.snapshot());
    }
    let counts = expected.counts();
    assert!(counts.joints + counts.broken > 10, "{counts:?}");
}

#[test]
fn runs_with_bedding_go_to_a_device_and_back() {
    go_to_a_device_and_back::<2, 3>();
    go_to_a_device_and_back::<3, 4>();
}
