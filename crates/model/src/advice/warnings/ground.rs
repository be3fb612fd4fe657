//! A surface of the ground that is not where the bodies end.

use fdem_io::numbers::brief;
use fdem_mesh::{Corners, bounds};
use fdem_simulation::{Load, Model};

use crate::advice::deforming::deforms;
use crate::advice::ready::Ready;
use crate::bodies::dimensions::Dimensions;
use crate::text::file::Ground;

/// Ground above a free top, over the height of the bodies, that is no rounding of the surface.
const MISSING: f64 = 0.01;

/// Share of the weight of a body above the surface of the ground that moves the rest at once. Hills and
/// uneven tops have less.
const BARE: f64 = 0.1;

/// Levels of nodes that differ less, over the height of the bodies, are one.
const LEVEL: f64 = 1e-6;

/// Density of the ground over that of a body under its stress, beyond which one of the two is a slip.
const UNLIKE: f64 = 1.5;

/// Warns of ground whose weight acts on a free top, of bodies whose weight the stress of the ground does
/// not carry, of another density, and of horizontal tension.
///
/// Only the highest level of all bodies counts: faces of slopes and excavations are free below the surface,
/// and the run begins with their release.
pub(super) fn warn<const D: usize, const N: usize>(ready: &Ready<'_, D, N>, warnings: &mut Vec<String>)
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let Some(ground) = &ready.file.initial.ground else { return };
    if ground.k0.along().iter().any(|k0| *k0 < 0.0) {
        warnings.push(
            "[initial] ground: k0 is below 0, so the ground is under horizontal tension; at rest it is 0.3 to 2 mostly"
                .to_owned(),
        );
    }
    // Another stress may balance that of the ground.
    if ready.file.initial.components(D).is_some() || ready.file.initial.stress_gradient.is_some() {
        return;
    }
    let under_stress = |body: &usize| {
        let elements = &ready.bodies[*body].elements;
        let stresses = &ready.model.stresses[elements.start as usize..elements.end as usize];
        stresses.iter().flatten().flatten().any(|stress| *stress != 0.0)
    };
    let may_have_stress = |body: &usize| deforms(ready.model, *body as u32);
    let bodies: Vec<usize> = (0..ready.bodies.len()).filter(may_have_stress).filter(under_stress).collect();
    warnings.extend(bodies.iter().find_map(|&body| unlike(ready, ground, body)));
    let range = |body: usize| {
        let [low, high] = bounds(ready.placed[body].piece.nodes.iter().copied());
        [low[D - 1], high[D - 1]]
    };
    let by_top = |a: &&usize, b: &&usize| range(**a)[1].total_cmp(&range(**b)[1]);
    let Some(&highest) = bodies.iter().max_by(by_top) else { return };
    let top = range(highest)[1];
    let height = top - bodies.iter().map(|&body| range(body)[0]).fold(f64::INFINITY, f64::min);
    if ground.surface - top > MISSING * height {
        let ends_free = bodies.iter().find(|&&body| {
            let level = top - LEVEL * height;
            range(body)[1] >= level && has_free_top(ready, body, level)
        });
        warnings.extend(ends_free.map(|&body| missing(ready, ground, body, top)));
    } else {
        let above = bodies.iter().filter_map(|&body| bare(ready, ground, body, range(body)[1]));
        warnings.extend(above.take(1));
    }
}

/// The warning of a body whose density is far from that of the ground.
fn unlike<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    ground: &Ground,
    body: usize,
) -> Option<String> {
    // Without a key, the density is that of a material.
    let of_ground = ground.density?;
    let elements = &ready.bodies[body].elements;
    let materials = &ready.model.mesh.materials[elements.start as usize..elements.end as usize];
    let densities = materials.iter().map(|&number| ready.model.materials[number as usize].density);
    // Layers above and below may be denser and lighter than their mean.
    let [least, most] = densities
        .fold([f64::INFINITY, 0.0_f64], |[least, most], density| [least.min(density), most.max(density)]);
    (of_ground > UNLIKE * most || of_ground * UNLIKE < least).then(|| {
        format!(
            "[initial] ground: its density is {} kg/m³, but that of \"{}\" is {}: the stress does not balance the weight, and the body moves at once",
            brief(of_ground),
            ready.bodies[body].name,
            if least == most { format!("{} kg/m³", brief(most)) } else { format!("{} to {} kg/m³", brief(least), brief(most)) }
        )
    })
}

/// Whether a part of a body at a level or above it has no load and no support along the last axis.
fn has_free_top<const D: usize, const N: usize>(ready: &Ready<'_, D, N>, body: usize, level: f64) -> bool {
    let piece = &ready.placed[body].piece;
    let acted = acted_nodes(ready.model);
    let first = ready.bodies[body].nodes.start;
    let is_free = |node: u32| !acted[(first + node) as usize];
    let is_high = |node: u32| piece.nodes[node as usize][D - 1] >= level;
    let flat: Vec<&[u32; D]> =
        piece.outline.iter().filter(|facet| facet.iter().all(|&node| is_high(node))).collect();
    if flat.is_empty() {
        return (0..piece.nodes.len() as u32).any(|node| is_high(node) && is_free(node));
    }
    flat.iter().any(|facet| facet.iter().any(|&node| is_free(node)))
}

/// Whether a boundary acts on each node along the last axis.
fn acted_nodes<const D: usize, const N: usize>(model: &Model<D, N>) -> Vec<bool> {
    let mut acted = vec![false; model.mesh.nodes.len()];
    for boundary in &model.boundaries {
        let acts = match boundary.load {
            Load::Velocity(components) | Load::Displacement(components) => components[D - 1].is_some(),
            Load::Force(force) | Load::Traction(force) => force[D - 1] != 0.0,
            Load::Rotation { .. }
            | Load::Pressure(_)
            | Load::Cavity { .. }
            | Load::Absorbing
            | Load::Held => true,
        };
        if acts {
            for node in boundary.target.nodes() {
                acted[node as usize] = true;
            }
        }
    }
    acted
}

/// The warning of a free top below the surface.
fn missing<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    ground: &Ground,
    body: usize,
    top: f64,
) -> String {
    let first = ready.model.materials.first().map_or(0.0, |material| material.density);
    let pressure = ground.density.unwrap_or(first) * -ready.model.gravity[D - 1] * (ground.surface - top);
    format!(
        "[initial] ground: \"{}\" ends at {} m with a free top, {} m below the surface: {} Pa of its stress there are balanced by nothing, and it moves up at once; \
         write surface = {}, or load or hold its top",
        ready.bodies[body].name,
        brief(top),
        brief(ground.surface - top),
        brief(pressure),
        brief(top)
    )
}

/// The warning of a body of whose weight the ground carries too little.
fn bare<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    ground: &Ground,
    body: usize,
    top: f64,
) -> Option<String>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mesh = &ready.model.mesh;
    let (mut above, mut all) = (0.0, 0.0);
    for element in ready.bodies[body].elements.clone() {
        let corners = mesh.elements[element as usize].map(|node| mesh.nodes[node as usize]);
        let material = &ready.model.materials[mesh.materials[element as usize] as usize];
        let mass = material.density * corners.measure();
        let middle = corners.iter().map(|corner| corner[D - 1]).sum::<f64>() / N as f64;
        all += mass;
        above += if middle > ground.surface { mass } else { 0.0 };
    }
    (above > BARE * all).then(|| {
        format!(
            "[initial] ground: \"{}\" reaches {} m, above the surface at {} m: {:.0} % of its weight is there, where the ground has no stress, and it settles at once; \
             write surface = {}, or the level of the ground around it",
            ready.bodies[body].name,
            brief(top),
            brief(ground.surface),
            100.0 * above / all,
            brief(top)
        )
    })
}
