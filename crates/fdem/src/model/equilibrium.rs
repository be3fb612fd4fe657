//! Warnings of initial states that are not in equilibrium.

use fdem_io::numbers::brief;
use fdem_simulation::{InitialContacts, Load, Model, Schedule, Target, principal_stresses};

use crate::model::Body;

/// Forces out of balance, over the weights, from which a body is said not to be in equilibrium.
const UNBALANCED: f64 = 0.1;

/// Adds what is not in equilibrium at the beginning, in words.
pub(crate) fn warnings(model: &Model, bodies: &[Body], warnings: &mut Vec<String>) {
    weight(model, bodies, warnings);
    if model.stresses.is_empty() {
        return;
    }
    strength(model, warnings);
    // A model that cannot be run is told so where it is run.
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
    tell(
        found.unlike,
        "its tractions on the two differ: they begin with the mean, and move until they are alike",
    );
}

/// Weight that the initial stress does not carry, on bodies that rest on absorbing edges.
fn weight(model: &Model, bodies: &[Body], warnings: &mut Vec<String>) {
    let mesh = &model.mesh;
    let size = model.gravity[0].hypot(model.gravity[1]);
    let absorbs = |load: &Load| matches!(load, Load::Absorbing);
    let sudden = model.gravity_schedule == Schedule::Constant;
    if size == 0.0 || !sudden || !model.boundaries.iter().any(|boundary| absorbs(&boundary.load)) {
        return;
    }
    // Nodes on absorbing edges are held in equilibrium by the ground, where there is a stress.
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
    let Some(body) = (0..bodies.len() as u32).find(|&body| on_ground(body)) else { return };
    let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
    let mut weights = vec![0.0; mesh.nodes.len()];
    for (element, nodes) in mesh.elements.iter().enumerate().filter(|(k, _)| mesh.bodies[*k] == body) {
        let [a, b, c] = nodes.map(|node| mesh.nodes[node as usize]);
        let density = model.materials[mesh.materials[element] as usize].density;
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let [[xx, xy], [_, yy]] = model.stresses.get(element).copied().unwrap_or_default();
        for (node, [p, q]) in nodes.iter().zip([[b, c], [c, a], [a, b]]) {
            // Half of the opposite edge, turned inwards: area times the gradient of the shape function.
            let [x, y] = [0.5 * (p[1] - q[1]), 0.5 * (q[0] - p[0])];
            let force = &mut forces[*node as usize];
            let mass = density * area / 3.0;
            force[0] += mass * model.gravity[0] - xx * x - xy * y;
            force[1] += mass * model.gravity[1] - xy * x - yy * y;
            weights[*node as usize] += mass * size;
        }
    }
    let inside = || (0..mesh.nodes.len()).filter(|&node| !outer[node]);
    let left = inside().fold([0.0; 2], |sum, node| [sum[0] + forces[node][0], sum[1] + forces[node][1]]);
    let along = (left[0] * model.gravity[0] + left[1] * model.gravity[1]) / size;
    let all: f64 = inside().map(|node| weights[node]).sum();
    if along > UNBALANCED * all {
        warnings.push(format!(
            "\"{}\" rests on absorbing edges, and {:.0} % of its weight is not carried by an initial stress: it settles on the springs of the edges and swings; \
             give it [initial] stress and stress_gradient in equilibrium with gravity, or hold its base",
            bodies[body as usize].name,
            (100.0 * along / all).min(100.0)
        ));
    }
}

/// Initial stress that a material does not bear.
fn strength(model: &Model, warnings: &mut Vec<String>) {
    for (number, material) in model.materials.iter().enumerate() {
        let Some(strength) = material.strength else { continue };
        let breaks = |[[xx, xy], [_, yy]]: [[f64; 2]; 2]| {
            let [most, least] = principal_stresses::<2, 3>(&[[xx, xy], [xy, yy]]);
            let (mean, radius) = (f64::midpoint(most, least), 0.5 * (most - least));
            let secant = (1.0 + strength.friction * strength.friction).sqrt();
            most > strength.tensile || radius * secant + strength.friction * mean.min(0.0) > strength.cohesion
        };
        let mut own =
            model.stresses.iter().zip(&model.mesh.materials).filter(|(_, own)| **own as usize == number);
        if let Some((stress, _)) = own.find(|(stress, _)| breaks(**stress)) {
            let [[xx, xy], [_, yy]] = stress.map(|row| row.map(brief));
            warnings.push(format!(
                "[initial] stress: \"{}\" does not bear [{xx}, {yy}, {xy}] Pa in every direction: it may break at once",
                material.name
            ));
        }
    }
}
