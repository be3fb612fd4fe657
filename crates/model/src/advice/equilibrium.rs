//! Warnings of initial states that are not in equilibrium.

use fdem_io::numbers::brief;
use fdem_mesh::Corners;
use fdem_simulation::{InitialContacts, Load, Model, PoreOptions, Schedule, Target, principal_stresses};

use crate::advice::deforming;
use crate::bodies::dimensions::Dimensions;
use crate::prepared::PreparedBody;
use crate::stages::pores::push;

/// Forces out of balance, over the weights, from which a body counts as not in equilibrium.
const UNBALANCED: f64 = 0.1;

/// Adds warnings of bodies that are not in equilibrium at the beginning. `pores`: those with liquid then.
pub(crate) fn warnings<const D: usize, const N: usize>(
    (model, pores): (&Model<D, N>, Option<&PoreOptions<D>>),
    bodies: &[PreparedBody],
    warnings: &mut Vec<String>,
) where
    [[f64; D]; N]: Dimensions<D, N>,
{
    weight((model, pores), bodies, warnings);
    if model.stresses.is_empty() {
        return;
    }
    strength(model, warnings);
    // A model that cannot be run is reported when it is run.
    let Ok(found) = InitialContacts::of(model) else { return };
    let name = |element: u32| &bodies[model.mesh.bodies[element as usize] as usize].name;
    let mut tell = |pair: Option<[u32; 2]>, what: &str| {
        if let Some([a, b]) = pair {
            warnings.push(format!("[initial] stress: \"{}\" and \"{}\" touch, and {what}", name(a), name(b)));
        }
    };
    tell(
        found.pulled,
        "it pulls them apart: contacts carry no tension, so that part of it is released at once",
    );
    tell(found.slipping, "its shear there is more than friction holds: they slip at once");
    if let Some((pair, difference)) = found.unlike {
        let difference = brief(difference);
        tell(
            Some(pair),
            &format!(
                "its tractions on the two differ by up to {difference} Pa: they begin with the mean, and move until they are alike"
            ),
        );
    }
}

/// Weight that the initial stress does not carry, on bodies that rest on absorbing boundaries.
fn weight<const D: usize, const N: usize>(
    (model, pores): (&Model<D, N>, Option<&PoreOptions<D>>),
    bodies: &[PreparedBody],
    warnings: &mut Vec<String>,
) where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mesh = &model.mesh;
    let size = dot(&model.gravity, &model.gravity).sqrt();
    let absorbs = |load: &Load<D>| matches!(load, Load::Absorbing);
    let sudden = model.gravity_schedule == Schedule::Constant;
    if size == 0.0 || !sudden || !model.boundaries.iter().any(|boundary| absorbs(&boundary.load)) {
        return;
    }
    // Nodes on absorbing boundaries are held in equilibrium by the ground, where there is a stress.
    let mut outer = vec![false; mesh.nodes.len()];
    for boundary in model.boundaries.iter().filter(|boundary| absorbs(&boundary.load)) {
        let Target::Facets(edges) = &boundary.target else { continue };
        for &node in edges.iter().flatten() {
            outer[node as usize] = true;
        }
    }
    let on_ground = |body: u32| {
        let nodes = mesh.elements.iter().zip(&mesh.bodies).filter(move |(_, own)| **own == body);
        nodes.flat_map(|(nodes, _)| nodes).any(|&node| outer[node as usize])
    };
    let mut all = 0..bodies.len() as u32;
    let Some(body) = all.find(|&body| deforming::deforms(model, body) && on_ground(body)) else { return };
    let mut forces = vec![[0.0; D]; mesh.nodes.len()];
    let mut weights = vec![0.0; mesh.nodes.len()];
    for (element, nodes) in mesh.elements.iter().enumerate().filter(|(k, _)| mesh.bodies[*k] == body) {
        let corners = nodes.map(|node| mesh.nodes[node as usize]);
        let volume = corners.measure();
        let density = model.materials[mesh.materials[element] as usize].density;
        let stress = model.stresses.get(element).copied().unwrap_or([[0.0; D]; D]);
        let push = push(pores, nodes, mesh.materials[element]);
        for (node, gradient) in nodes.iter().zip(gradients(&corners)) {
            let force = &mut forces[*node as usize];
            let mass = density * volume / N as f64;
            for axis in 0..D {
                let inside = dot(&stress[axis], &gradient) - push * gradient[axis];
                force[axis] += mass * model.gravity[axis] - volume * inside;
            }
            weights[*node as usize] += mass * size;
        }
    }
    let inside = || (0..mesh.nodes.len()).filter(|&node| !outer[node]);
    let along = inside().map(|node| dot(&forces[node], &model.gravity)).sum::<f64>() / size;
    let all: f64 = inside().map(|node| weights[node]).sum();
    if along > UNBALANCED * all {
        warnings.push(format!(
            "\"{}\" rests on absorbing boundaries, and {:.0} % of its weight is not carried by an initial stress: it settles on their springs and swings; \
             give it [initial] stress and stress_gradient in equilibrium with gravity, or hold its base",
            bodies[body as usize].name,
            (100.0 * along / all).min(100.0)
        ));
    }
}

/// The gradients of the functions that are 1 at one corner of an element and 0 at all others, 1/m.
fn gradients<const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> [[f64; D]; N]
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let volume = corners.measure();
    let mut gradients = [[0.0; D]; N];
    for (corner, gradient) in gradients.iter_mut().enumerate() {
        for (axis, component) in gradient.iter_mut().enumerate() {
            // The measure is linear in each coordinate, so that this difference is exact but for rounding.
            let mut moved = *corners;
            let length = volume.abs().powf(1.0 / D as f64);
            moved[corner][axis] += length;
            *component = (moved.measure() / volume - 1.0) / length;
        }
    }
    gradients
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Warns of initial stress beyond the strength of a material.
fn strength<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>)
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    for (number, material) in model.materials.iter().enumerate() {
        let Some(strength) = material.strength else { continue };
        let breaks = |stress: &[[f64; D]; D]| {
            let [most, least] = principal_stresses::<D, N>(stress);
            let (mean, radius) = (f64::midpoint(most, least), 0.5 * (most - least));
            let secant = (1.0 + strength.friction * strength.friction).sqrt();
            most > strength.tensile || radius * secant + strength.friction * mean.min(0.0) > strength.cohesion
        };
        let is_own = |element: &u32| model.mesh.materials[*element as usize] as usize == number;
        let own = deforming::elements(model).filter(is_own);
        if let Some(stress) =
            own.map(|element| &model.stresses[element as usize]).find(|stress| breaks(stress))
        {
            // In the order of the model file: the diagonal, then xy, yz, xz.
            let diagonal = (0..D).map(|axis| stress[axis][axis]);
            let others = [[0, 1], [1, 2], [0, 2]].into_iter().filter(|[_, column]| *column < D);
            let all = diagonal.chain(others.map(|[row, column]| stress[row][column])).map(brief);
            warnings.push(format!(
                "[initial] stress: \"{}\" does not bear [{}] Pa in every direction: it may break at once",
                material.name,
                all.collect::<Vec<_>>().join(", ")
            ));
        }
    }
}
