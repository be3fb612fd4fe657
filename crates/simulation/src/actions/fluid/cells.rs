//! Cells of the fluid: joints that it can enter, their shapes, and how soft the fluid in them has to be.

use fdem_fluid::{ApertureLaw, Scheme, Shape};

use crate::action::Scene;
use crate::joints::Joint;
use crate::model::{FluidOptions, Insertion, WetFrom};
use crate::simplex::Simplex;
use crate::vector::dot;

/// A joint that fluid can enter.
#[derive(Clone, Copy, Debug)]
pub(super) struct FluidCell {
    /// Code of its facet.
    pub(super) key: u64,
    /// Number of the joint.
    pub(super) joint: u32,
    pub(super) facet: u32,
    /// Growth of its aperture with the pressure, m/Pa: see the front page of the module.
    pub(super) softness: f64,
}

/// The joints that fluid can enter, by their keys, all with the softness 0.
pub(super) fn wet_joints<const D: usize, const N: usize>(
    options: &FluidOptions<D>,
    scene: &Scene<'_, D, N>,
) -> Vec<FluidCell>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let joints = scene.joints();
    let adaptive = scene.model.fracture.insertion == Insertion::Adaptive;
    let is_wet = |joint: &Joint<D>| {
        let softens = joint.softens < f64::INFINITY || adaptive && joints.set(joint.facet).is_none();
        joint.open_from_start || !joint.holds() || options.wet_from == WetFrom::Insertion && softens
    };
    let all = (0..).zip(&joints.all).filter(|(_, joint)| is_wet(joint));
    let mut cells: Vec<FluidCell> = all
        .map(|(number, &Joint { facet, .. })| FluidCell {
            key: u64::from(scene.topology.code(facet)),
            joint: number,
            facet,
            softness: 0.0,
        })
        .collect();
    cells.sort_unstable_by_key(|cell| cell.key);
    cells
}

/// Sets the softness of cells. `walls`: corners of the walls of holes.
pub(super) fn soften<'a, const D: usize, const N: usize>(
    cells: &mut [FluidCell],
    options: &FluidOptions<D>,
    walls: impl Iterator<Item = &'a [u32; D]>,
    scene: &Scene<'_, D, N>,
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    if options.flow.scheme == Scheme::Explicit {
        return;
    }
    let (solid, joints) = (scene.solid(), scene.joints());
    // Area around each node on which fluid acts, over the mass of the node.
    let mut yields = vec![0.0; solid.node_count()];
    for cell in &*cells {
        let joint = &joints.all[cell.joint as usize];
        for node in joint.nodes.into_iter().filter(|[a, b]| a != b).flatten() {
            yields[node as usize] += joint.measure * solid.thickness / D as f64;
        }
    }
    for corners in walls {
        // Undeformed, so that it does not depend on the step in which it is computed.
        let vertices = corners.map(|corner| scene.topology.vertices[corner as usize]);
        let places = vertices.map(|vertex| scene.model.mesh.nodes[vertex as usize]);
        let part = <[[f64; D]; N]>::facet_measure(&places) * solid.thickness / D as f64;
        for corner in corners {
            yields[solid.node_at(*corner) as usize] += part;
        }
    }
    for (node, area) in yields.iter_mut().enumerate().filter(|(_, area)| **area > 0.0) {
        *area /= solid.constants(node).mass;
    }
    let step = scene.step * f64::from(options.steps);
    for cell in cells {
        let ends = joints.all[cell.joint as usize].nodes.into_iter().filter(|[a, b]| a != b);
        let sum: f64 = ends.flatten().map(|node| yields[node as usize]).sum();
        cell.softness = step * step * sum / D as f64;
    }
}

/// The shape of a cell now. `above`: its pressure above the lowest one, Pa.
pub(super) fn shape_of<const D: usize, const N: usize>(
    cell: &FluidCell,
    above: f64,
    options: &FluidOptions<D>,
    scene: &Scene<'_, D, N>,
) -> Shape<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let solid = scene.solid();
    let joint = &scene.joints().all[cell.joint as usize];
    // In the middle of the time in which the pressure will be constant.
    let ahead = 0.5 * f64::from(options.steps - 1) * scene.step;
    let mut opening = 0.0;
    for [gap, rate] in joint.openings(solid) {
        opening += (gap + ahead * rate).max(0.0) / D as f64;
    }
    let compression = if opening == 0.0 { compression_of(cell, scene) } else { 0.0 };
    let is_pressed = compression > 0.0 && law_of(cell, options, scene).reference_stress.is_some();
    let corners = joint.nodes.map(|nodes| {
        let [a, b] = nodes.map(|node| solid.position(node as usize));
        std::array::from_fn(|axis| f64::midpoint(a[axis], b[axis]))
    });
    Shape {
        corners,
        opening: if is_pressed { 0.0 } else { opening + cell.softness * above },
        compression,
        compliance: cell.softness,
        is_wet: true,
    }
}

/// The law of the aperture of a cell.
pub(super) fn law_of<const D: usize, const N: usize>(
    cell: &FluidCell,
    options: &FluidOptions<D>,
    scene: &Scene<'_, D, N>,
) -> ApertureLaw
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let of_set = scene.joints().set(cell.facet).and_then(|set| options.set_apertures.get(set as usize));
    of_set.copied().unwrap_or(options.aperture)
}

/// Compression across a cell, Pa: the mean of the two elements beside it.
fn compression_of<const D: usize, const N: usize>(cell: &FluidCell, scene: &Scene<'_, D, N>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let solid = scene.solid();
    let facet = &scene.topology.facets[cell.facet as usize];
    let across = <[[f64; D]; N]>::facet_normal(&facet.corners[0].map(|corner| solid.position_at(corner)));
    let square = dot(across, across);
    let tension = |element: u32| {
        let stress = solid.stress(element as usize);
        dot(stress.map(|row| dot(row, across)), across) / square
    };
    let [a, b] = facet.elements().map(tension);
    (-f64::midpoint(a, b)).max(0.0)
}
