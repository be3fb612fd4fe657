//! Warnings of settings that are possible, but probably not meant.

mod gravity;
mod ground;

use std::collections::BTreeMap;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::bounds;
use fdem_mesh::tetrahedra::{sharpest_corner, sharpest_edge};
use fdem_simulation::{Boundary, Load, MaterialLaw, Model, Strength, Target};

use crate::advice::deforming::{self, breaks};
use crate::advice::ready::Ready;
use crate::advice::{coarse, equilibrium, fine, process_zone, quasi_static};
use crate::bodies::dimensions::Dimensions;
use crate::stages::pores::at_first;
use crate::text::file;

/// Share of elements with equal angles from which a mesh is regular.
const REGULAR: f64 = 0.5;

/// Elements of a body up to which a boundary on one of its nodes is no wonder.
const FEW: usize = 10;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Penalty over Young's modulus below which bodies sink into each other.
const SOFT: f64 = 0.5;

/// Angle of a triangle, degrees, below which its stress is poor, and that of better meshes.
const POOR: [f64; 2] = [10.0, 25.0];

/// The same for the angle between two faces of a tetrahedron, degrees.
const POOR_IN_SPACE: [f64; 2] = [8.0, 15.0];

/// Returns the warnings of models in the plane.
pub(crate) fn of_plane(ready: &Ready<'_, 2, 3>) -> Vec<String> {
    let mut warnings = of_both(ready, POOR, String::new);
    if breaks(ready.model) && ready.quality.regular > REGULAR {
        warnings.push(format!(
            "{:.0} % of the elements have the angles of a regular mesh: cracks follow its lines; take an unstructured one",
            100.0 * ready.quality.regular
        ));
    }
    of_start(ready, &mut warnings);
    warnings
}

/// Returns the warnings of models in space.
pub(crate) fn of_space(ready: &Ready<'_, 3, 4>) -> Vec<String> {
    let mut warnings = of_both(ready, POOR_IN_SPACE, || sharp_shape(ready).unwrap_or_default());
    of_start(ready, &mut warnings);
    warnings
}

/// Adds warnings about the initial state.
fn of_start<const D: usize, const N: usize>(ready: &Ready<'_, D, N>, warnings: &mut Vec<String>)
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    coarse::warn(ready, warnings);
    fine::warn(ready, warnings);
    // Ground at rest carries its weight from the beginning.
    if ready.file.initial.ground.is_none() {
        gravity::sudden(ready.model, ready.bodies, warnings);
    }
    ground::warn(ready, warnings);
    quasi_static::advice(ready.file, ready.model, warnings);
    let pores = at_first(ready.file, ready.model.pores.as_ref());
    equilibrium::warnings((ready.model, pores), ready.bodies, warnings);
}

/// Angle of a flat face at a corner, degrees, below which the elements there are flat.
const SHARP_CORNER: f64 = 2.0;

/// The sharp edge, or the sharp corner of a face, of a body that gives the smallest angle of the model, in
/// words. A mesh has no larger angles than the edge, and hardly any better ones beside the corner, as its
/// faces have that of the corner.
fn sharp_shape(ready: &Ready<'_, 3, 4>) -> Option<String> {
    let body = ready.model.mesh.bodies[ready.quality.worst as usize];
    let piece = &ready.placed[body as usize].piece;
    let name = &ready.bodies[body as usize].name;
    let edge = sharpest_edge(&piece.nodes, &piece.outline).filter(|edge| edge.angle < 2.0 * POOR_IN_SPACE[0]);
    if let Some(edge) = edge {
        return Some(format!(
            "; \"{name}\" has an edge of {:.1} degrees from {} to {}, which no mesh makes better: make the body blunter there",
            edge.angle,
            place(&edge.ends[0]),
            place(&edge.ends[1])
        ));
    }
    let corner = sharpest_corner(&piece.nodes, &piece.outline)?;
    (corner.angle < SHARP_CORNER).then(|| {
        format!(
            "; \"{name}\" has a face that ends in an angle of {:.2} degrees at {}, beside which elements are flat: move the corners of this face away from the line between its ends",
            corner.angle,
            place(&corner.place)
        )
    })
}

/// Returns the warnings of models in any dimensions. Angles below `poor` degrees are poor; `cause` says why
/// there are any.
fn of_both<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    [poor, better]: [f64; 2],
    cause: impl Fn() -> String,
) -> Vec<String> {
    let Ready { model, bodies, quality, .. } = *ready;
    let mut warnings = Vec::new();
    process_zone::warnings(model, &mut warnings);
    platens(model, &mut warnings);
    let deforms = deforming::nodes(model);
    for boundary in &model.boundaries {
        // Nothing sends a shock into a rigid body.
        if boundary.target.nodes().iter().any(|&node| deforms[node as usize]) {
            stepped(boundary, &mut warnings);
        }
        lone_node(ready, boundary, &mut warnings);
    }
    let breaks = breaks(model);
    if quality.elements > 0 && quality.smallest_angle[0] < poor {
        warnings.push(format!(
            "element {} near {} has an angle of {:.1} degrees: its stress is poor; better meshes have {better} degrees or more{}",
            quality.worst,
            place(&quality.worst_at),
            quality.smallest_angle[0],
            cause()
        ));
    }
    if model.contact.penalty < SOFT && (bodies.len() > 1 || breaks) && !deforming::none(model) {
        warnings.push(format!(
            "[contact] penalty = {}: bodies are softer where they touch than inside, and sink into each other; 1 to 10 is usual",
            brief(model.contact.penalty)
        ));
    }
    if model.fracture.joint_penalty < 1.0 && breaks {
        warnings.push(format!(
            "[fracture] joint_penalty = {}: joints are softer than the elements beside them, and may store more than the energy that breaks them; 10 to 100 is usual",
            brief(model.fracture.joint_penalty)
        ));
    }
    apex(model, &mut warnings);
    warnings
}

/// Warns of a tensile strength above that at which Mohr and Coulomb's strength in shear is 0, c/tan φ.
fn apex<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    for (material, deforms) in model.materials.iter().zip(deforming::materials(model)) {
        let Some(strength) = material.strength.filter(|_| deforms) else { continue };
        let on_bedding = match &material.law {
            MaterialLaw::TransverselyIsotropic(bedding) => bedding.strength,
            _ => None,
        };
        let all = [Some((strength, "")), on_bedding.map(|strength| (strength, " on its bedding"))];
        for (Strength { tensile, cohesion, .. }, place) in all.into_iter().flatten() {
            let apex = cohesion / strength.friction;
            if tensile > apex {
                warnings.push(format!(
                    "material \"{}\" cannot carry its tensile strength of {} Pa{place}: by cohesion / tan(friction_angle) it fails in shear at a tension of {} Pa",
                    material.name,
                    brief(tensile),
                    brief(apex)
                ));
            }
        }
    }
}

/// Warns of one side that is held while the opposite one is driven: stress waves load the two unequally.
fn platens<const D: usize, const N: usize>(model: &Model<D, N>, warnings: &mut Vec<String>) {
    let components = |boundary: &Boundary<D>| match boundary.load {
        Load::Velocity(components) | Load::Displacement(components) => components,
        _ => [None; D],
    };
    let middle = |boundary: &Boundary<D>, axis: usize| {
        let nodes = boundary.target.nodes();
        let [low, high] = bounds(nodes.iter().map(|&node| model.mesh.nodes[node as usize]));
        f64::midpoint(low[axis], high[axis])
    };
    // Stress waves pass through a body that deforms between the two.
    let deforms = deforming::nodes(model);
    let deforms_between = |axis: usize, [one, other]: [f64; 2]| {
        let between = one.min(other)..=one.max(other);
        let mut nodes = model.mesh.nodes.iter().zip(&deforms).filter(|(_, deforms)| **deforms);
        nodes.any(|(node, _)| between.contains(&node[axis]))
    };
    for moving in &model.boundaries {
        for (axis, name) in AXES.iter().enumerate().take(D) {
            let Some(speed) = components(moving)[axis].filter(|speed| *speed != 0.0) else { continue };
            // A boundary that is driven towards a held one, or away from it.
            let held = model.boundaries.iter().find(|held| {
                let ends = [held, moving].map(|boundary| middle(boundary, axis));
                components(held)[axis] == Some(0.0) && ends[0] != ends[1] && deforms_between(axis, ends)
            });
            if let Some(held) = held {
                warnings.push(format!(
                    "\"{}\" is fixed along {name} while \"{}\" moves: the two sides are not loaded alike; move both, with {} and {}",
                    held.name,
                    moving.name,
                    brief(speed / 2.0),
                    brief(-speed / 2.0)
                ));
                return;
            }
        }
    }
}

/// Warns of a boundary on the side of a body, or in a box, that takes one node of a body alone: a sphere has
/// one lowest node.
fn lone_node<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    boundary: &Boundary<D>,
    warnings: &mut Vec<String>,
) {
    let Target::Nodes(nodes) = &boundary.target else { return };
    let in_place =
        |given: &&file::Boundary| given.side.is_some() || given.sides.is_some() || given.limits.is_some();
    let given = ready.file.boundary.iter().filter(in_place);
    if !given.into_iter().any(|given| given.name == boundary.name) {
        return;
    }
    let what = match boundary.load {
        Load::Force(_) => "loads",
        Load::Velocity(components) if components.iter().flatten().all(|speed| *speed == 0.0) => "holds",
        _ => "moves",
    };
    // Nodes of each body that has any.
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for &node in nodes {
        *counts.entry(ready.bodies.partition_point(|body| body.nodes.end <= node)).or_default() += 1;
    }
    let is_lone = |&(body, count): &(usize, usize)| {
        count == 1 && ready.bodies[body].elements.len() > FEW && deforming::deforms(ready.model, body as u32)
    };
    let lone = counts.into_iter().filter(is_lone);
    let lone: Vec<usize> = lone.map(|(body, _)| body).collect();
    let Some(&first) = lone.first() else { return };
    let others = match lone.len() - 1 {
        0 => String::new(),
        others => format!(" (and of {} other bodies)", grouped(others as u64)),
    };
    let body = &ready.bodies[first];
    warnings.push(format!(
        "[[boundary]] \"{}\" {what} one node alone of the {} of \"{}\"{others}: its stress grows without limit as elements become smaller; take a box with more nodes, or a body that presses on it",
        boundary.name,
        grouped(body.nodes.len() as u64),
        body.name
    ));
}

/// Warns of velocities and displacements that start at full size.
fn stepped<const D: usize>(boundary: &Boundary<D>, warnings: &mut Vec<String>) {
    let starts = boundary.schedule.factor(0.0) != 0.0;
    let moves = |components: [Option<f64>; D]| components.iter().flatten().any(|speed| *speed != 0.0);
    let what = match boundary.load {
        Load::Velocity(velocity) if moves(velocity) => "velocity",
        Load::Displacement(by) if moves(by) => "displacement",
        Load::Rotation { spin, .. } if spin != [0.0; 3] => "rotation",
        _ => return,
    };
    if starts {
        warnings.push(format!(
            "\"{}\": its {what} is there at once, and sends a shock into the body; give it a ramp",
            boundary.name
        ));
    }
}

pub(super) fn place(at: &[f64]) -> String {
    format!("[{}]", at.iter().map(|x| brief(*x)).collect::<Vec<_>>().join(", "))
}
