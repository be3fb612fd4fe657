//! The part of a model that deforms, at the latest when it is overloaded. Elements of rigid bodies have no
//! stress, so advice on stress, strength and waves is about the others.

use fdem_mesh::{Corners, Mesh, Quality, bounds};
use fdem_simulation::Model;

/// Whether a body, by its number, deforms.
pub(crate) fn deforms<const D: usize, const N: usize>(model: &Model<D, N>, body: u32) -> bool {
    !model.stays_rigid(body)
}

/// The elements of bodies that deform.
pub(crate) fn elements<const D: usize, const N: usize>(
    model: &Model<D, N>,
) -> impl Iterator<Item = u32> + Clone {
    (0..model.mesh.elements.len() as u32)
        .filter(|&element| deforms(model, model.mesh.bodies[element as usize]))
}

/// Whether no body deforms.
pub(crate) fn none<const D: usize, const N: usize>(model: &Model<D, N>) -> bool {
    !model.rigid.is_empty() && elements(model).next().is_none()
}

/// Whether each material is that of a body that deforms, or of no body at the beginning.
pub(crate) fn materials<const D: usize, const N: usize>(model: &Model<D, N>) -> Vec<bool> {
    let mut deform = vec![true; model.materials.len()];
    if !model.rigid.is_empty() {
        let all = &model.mesh.materials;
        for &material in all {
            deform[material as usize] = false;
        }
        for element in elements(model) {
            deform[all[element as usize] as usize] = true;
        }
    }
    deform
}

/// Whether each node belongs to a body that deforms.
pub(crate) fn nodes<const D: usize, const N: usize>(model: &Model<D, N>) -> Vec<bool> {
    let mut deform = vec![false; model.mesh.nodes.len()];
    for element in elements(model) {
        for node in model.mesh.elements[element as usize] {
            deform[node as usize] = true;
        }
    }
    deform
}

/// Whether a body that deforms has a material that breaks.
pub(crate) fn breaks<const D: usize, const N: usize>(model: &Model<D, N>) -> bool {
    let deform = materials(model);
    model.materials.iter().zip(deform).any(|(material, deforms)| deforms && material.strength.is_some())
}

/// The box around all bodies that deform, m.
pub(crate) fn extent<const D: usize, const N: usize>(model: &Model<D, N>) -> [[f64; D]; 2] {
    let mesh = &model.mesh;
    if model.rigid.is_empty() {
        return bounds(mesh.nodes.iter().copied());
    }
    let of_elements = elements(model).flat_map(|element| mesh.elements[element as usize]);
    bounds(of_elements.map(|node| mesh.nodes[node as usize]))
}

/// Sizes and shapes of the elements of bodies that deform, with their numbers in the model. `whole`: those of
/// all elements.
pub(crate) fn quality<const D: usize, const N: usize>(model: &Model<D, N>, whole: &Quality) -> Quality
where
    [[f64; D]; N]: Corners<D, N>,
{
    if model.rigid.is_empty() {
        return whole.clone();
    }
    let numbers: Vec<u32> = elements(model).collect();
    let mesh = &model.mesh;
    let part = Mesh {
        nodes: mesh.nodes.clone(),
        elements: numbers.iter().map(|&element| mesh.elements[element as usize]).collect(),
        ..Mesh::default()
    };
    let quality = Quality::of(&part);
    let worst = numbers.get(quality.worst as usize).copied().unwrap_or_default();
    Quality { worst, ..quality }
}
