//! Liquid in pores, which is computed beside the device, on the nodes that it moves.

use fdem_simulation::fluid::{Drive, PoreLiquid, PorousMaterial, Schedule as FluidSchedule};
use fdem_simulation::{Element, Model, Plane, PoreOptions, PoreSurface, State};
use serde::Serialize;

use crate::{joined, model, same, side};

/// The model with liquid in the pores of its materials, drained at x = 0.
fn porous<const D: usize, const N: usize>(mut model: Model<D, N>) -> Model<D, N>
where
    [[f64; D]; N]: Element<D, N>,
    State<D, N>: Serialize,
{
    let soil = PorousMaterial::isotropic(1e-8, 0.9, 1e-7);
    let drive = Drive::Pressure(FluidSchedule::constant(0.0));
    let drain = PoreSurface { name: "drain".to_owned(), target: side(&model, 0, 0.0), drive };
    let materials = vec![Some(soil); model.materials.len()];
    model.pores = Some(PoreOptions {
        surfaces: vec![drain],
        initial_pressures: vec![1e4; model.mesh.nodes.len()],
        steps: 3,
        ..PoreOptions::new(PoreLiquid::WATER, materials)
    });
    model.plane = Plane::Strain;
    model
}

#[test]
fn liquid_in_pores_pushes_as_on_the_processor() {
    same(&porous(model::<2, 3>(0.1, [0.0, -9.81])), 60, 1e-4);
    same(&porous(model::<3, 4>(0.0, [0.0, 0.0, -9.81])), 40, 1e-4);
}

#[test]
fn liquid_in_pores_of_breaking_bodies_pushes_as_on_the_processor() {
    same(&porous(joined::<2, 3>(20.0, 30.0)), 60, 1e-4);
}
