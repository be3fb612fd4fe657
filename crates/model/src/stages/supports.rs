//! Supports of rigid bodies that contradict each other, or leave a hinge: faults at their boundaries.

use std::collections::BTreeSet;

use fdem_simulation::{Element, Model, ModelError, Simulation};

use crate::prepared::{Entered, Prepared};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::ModelFile;

/// The fault of the supports of a rigid body, in the first stage that has one. Other errors of a model are
/// found when a run begins.
pub(crate) fn check<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    prepared: &Prepared<D, N>,
) -> Result<(), Fault>
where
    [[f64; D]; N]: Element<D, N>,
{
    if prepared.model.rigid.is_empty() {
        return Ok(());
    }
    let of_model = |model: &Model<D, N>, stage| {
        error_of(model).and_then(|error| fault(error, stage, (file, document), prepared))
    };
    let found = if prepared.stages.is_empty() {
        of_model(&prepared.model, None)
    } else {
        prepared.stages.iter().enumerate().find_map(|(number, stage)| {
            let present = prepared.at(&Entered::alone(number), 0.0).ok()?;
            of_model(&present.prepared.model, Some(&stage.name))
        })
    };
    found.map_or(Ok(()), Err)
}

/// The error of a model whose bodies are those that are rigid and supported.
fn error_of<const D: usize, const N: usize>(model: &Model<D, N>) -> Option<ModelError>
where
    [[f64; D]; N]: Element<D, N>,
{
    let moving = model.boundaries.iter().filter(|boundary| boundary.load.moves_nodes());
    let mut moved = vec![false; model.mesh.nodes.len()];
    for node in moving.flat_map(|boundary| boundary.target.nodes()) {
        moved[node as usize] = true;
    }
    let of_elements = || model.mesh.bodies.iter().zip(&model.mesh.elements);
    let touched = of_elements().filter(|(_, nodes)| nodes.iter().any(|&node| moved[node as usize]));
    let touched: BTreeSet<u32> = touched.map(|(body, _)| *body).collect();
    let held = |body: &u32| touched.contains(body) && model.rigid.binary_search(body).is_ok();
    let keep: Vec<bool> = model.mesh.bodies.iter().map(held).collect();
    if !keep.contains(&true) {
        return None;
    }
    let part = model.keeping(&keep).ok()?;
    Simulation::new(part.model, 1).err()
}

/// The fault of supports at their boundary, with the name of the body, in a stage with this name. `None` for
/// another error.
fn fault<const D: usize, const N: usize>(
    error: ModelError,
    stage: Option<&str>,
    (file, document): (&ModelFile, &Document<'_>),
    prepared: &Prepared<D, N>,
) -> Option<Fault> {
    let ModelError::RigidSupport { body, boundaries: [first, last], turns } = error else { return None };
    let name = &prepared.bodies[body as usize].name;
    let place = file.boundary.iter().position(|boundary| boundary.name == last)?;
    let stage = stage.map(|stage| format!("stage \"{stage}\": ")).unwrap_or_default();
    let at = document.key(Table::of("boundary", place), "name");
    Some(if turns {
        let message = format!(
            "{stage}boundary \"{last}\" leaves the rigid body \"{name}\" a rotation about a point or a line that it holds"
        );
        Fault::at(at, message).label("this boundary").help(
            "a boundary can only hold the rotation of a rigid body altogether, or leave one about an axis of coordinates \
             through the centre of mass; hold the whole body",
        )
    } else {
        let message = format!(
            "{stage}boundaries \"{first}\" and \"{last}\" move the rigid body \"{name}\" in different ways along one axis"
        );
        let help = "a rigid body moves as a whole: hold or move it by one boundary along each axis";
        Fault::at(at, message).label("the second").help(help)
    })
}
