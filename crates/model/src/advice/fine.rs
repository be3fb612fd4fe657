//! Elements much finer than the others of their body, which set the time step of the whole model.

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Corners;
use fdem_simulation::Element;

use crate::advice::deforming;
use crate::advice::ready::Ready;
use crate::advice::slivers::{Slivers, speed};
use crate::shapes::placed::Placed;
use crate::text::file::Body;

/// Least ratio of the time steps, without and with the fine elements, that is worth a warning.
const SHORTER: f64 = 10.0;

/// Share of `mesh_size` below which an edge of a surface is fine.
const FINE: f64 = 0.1;

/// Warns of the body whose finest element sets the time step, if half of its elements would allow one that is
/// ten times longer. Slivers have a warning of their own, and places to refine are meant.
pub(crate) fn warn<const D: usize, const N: usize>(ready: &Ready<'_, D, N>, warnings: &mut Vec<String>)
where
    [[f64; D]; N]: Corners<D, N> + Element<D, N>,
{
    let Ready { file, model, placed, bodies, .. } = *ready;
    if file.model.mass_scaling.is_some() {
        return;
    }
    let speeds: Vec<f64> = (0..model.materials.len()).map(|material| speed(model, material)).collect();
    let height = |element: u32| {
        let nodes = model.mesh.elements[element as usize];
        nodes.map(|node| model.mesh.nodes[node as usize]).least_height()
    };
    let time = |element: u32| height(element) / speeds[model.mesh.materials[element as usize] as usize];
    // Waves through a rigid body set no time step.
    let Some(finest) = deforming::elements(model).min_by(|&a, &b| time(a).total_cmp(&time(b))) else {
        return;
    };
    let Some(number) = bodies.iter().position(|body| body.elements.contains(&finest)) else { return };
    let (body, table) = (&bodies[number], &file.body[placed[number].table]);
    let mut heights: Vec<f64> = body.elements.clone().map(height).collect();
    let half = heights.len() / 2;
    let (_, median, _) = heights.select_nth_unstable_by(half, f64::total_cmp);
    let factor = meant(table) * *median / height(finest);
    let by_slivers = Slivers::of(model).map_or(1.0, |slivers| slivers.longer);
    if factor < SHORTER * by_slivers {
        return;
    }
    warnings.push(format!(
        "element {finest} at [{}] is {} m high, and half of the elements of the body \"{}\" {} m or more: it makes the time step \
         about {} times shorter than theirs; {}",
        model.mesh.centroid(finest as usize).map(brief).join(", "),
        brief(height(finest)),
        body.name,
        brief(*median),
        brief(factor.round()),
        help(table, &placed[number])
    ));
}

/// Smallest size to refine over the mesh size.
fn meant(body: &Body) -> f64 {
    let Some(size) = body.mesh_size else { return 1.0 };
    body.refine.iter().map(|place| place.size / size).fold(1.0, f64::min)
}

/// Names the fine facets of a surface, which the mesh has as they are.
fn help<const D: usize, const N: usize>(body: &Body, placed: &Placed<D, N>) -> String {
    let (Some(_), Some(size)) = (&body.surface, body.mesh_size) else {
        return "coarsen the mesh there, or take mass_scaling".to_owned();
    };
    let piece = &placed.piece;
    let is_fine = |facet: &&[u32; D]| {
        let corners = facet.map(|node| piece.nodes[node as usize]);
        let far = |a: [f64; D], b: [f64; D]| (0..D).fold(0.0, |sum: f64, k| sum.hypot(a[k] - b[k]));
        (0..D).any(|k| far(corners[k], corners[(k + 1) % D]) < FINE * size)
    };
    let fine = piece.outline.iter().filter(is_fine).count();
    let way = if body.surface_tolerance.is_some() { "take a larger" } else { "give it a" };
    format!(
        "{} facets of its surface have edges below a tenth of mesh_size: {way} surface_tolerance, within which these become \
         larger, coarsen the surface there, or take mass_scaling",
        grouped(fine as u64)
    )
}
