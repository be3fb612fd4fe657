//! Fluids, rock and joints that cases of fluid in cracks use.

use fdem_simulation::fluid::{ApertureLaw, Drive, FlowModel, Fluid, Schedule, StateEquation};
use fdem_simulation::{FluidOptions, FluidSource, JointSet, Material, Mesh, Strength};

use crate::cavity::{graded, mirrored, open};
use crate::models::{edges_where, granite, one_body, rectangle};

/// Poisson's ratio, Young's modulus and the modulus of plane strain, Pa.
pub(super) const POISSON: f64 = 0.25;
pub(super) const YOUNG: f64 = 30e9;
pub(super) const MODULUS: f64 = YOUNG / (1.0 - POISSON * POISSON);

/// Rock whose masses are `scale` times the real ones.
pub(super) fn rock_of_scaled_mass(scale: f64) -> Material {
    let material = granite();
    Material {
        poissons_ratio: POISSON,
        youngs_modulus: YOUNG,
        density: scale * material.density,
        damping: 0.1,
        ..material
    }
}

/// Joints that whole rock of a toughness (Pa √m) has, with this tensile strength, Pa.
pub(super) fn of_toughness(toughness: f64, tensile: f64) -> JointSet {
    let energy_i = toughness * toughness / MODULUS;
    let strength = Strength {
        tensile,
        cohesion: 10.0 * tensile,
        friction: 0.0,
        energy_i,
        energy_ii: 20.0 * energy_i,
        weibull_modulus: None,
        seed: 0,
    };
    JointSet { name: "plane".to_owned(), strength, open: false, ..open() }
}

/// Water of another viscosity, Pa s. A cell that is not full has the pressure `lowest`, Pa: pressures count
/// from the stress of the ground, so that an empty cell is at minus that stress.
pub(super) fn water(viscosity: f64, lowest: f64) -> Fluid {
    let state = match Fluid::WATER.state {
        StateEquation::Liquid { density, reference_pressure, bulk_modulus, .. } => {
            StateEquation::Liquid { density, reference_pressure, bulk_modulus, cavitation_pressure: lowest }
        }
        gas @ StateEquation::Gas { .. } => gas,
    };
    Fluid { viscosity, state }
}

/// A constant rate of injection, m³/s.
pub(super) fn rate(value: f64) -> Drive {
    Drive::Rate(Schedule::constant(value))
}

/// A fluid that comes in at some facets, into cracks of which the smallest aperture is `residual`, m.
pub(super) fn injected<const D: usize>(
    fluid: Fluid,
    residual: f64,
    facets: Vec<[u32; D]>,
    drive: Drive,
) -> FluidOptions<D> {
    let source = FluidSource { name: "pump".to_owned(), facets, drive: Some(drive), initial_pressure: None };
    let aperture = ApertureLaw { residual, ..ApertureLaw::default() };
    FluidOptions { aperture, ..FluidOptions::new(FlowModel::new(fluid), vec![source]) }
}

/// The mean of ratios over the time. A crack grows by whole elements, and its pressure falls with each of
/// them and rises again.
pub(super) fn mean(ratios: &[f64]) -> f64 {
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

/// The right half of a plate from -`half` to `half` along y, with `rows` rows of elements of the size `cell`
/// on both sides of the line from the origin to `near`, m. Returns the edges on that line, from left to
/// right.
pub(super) fn line_in_plate(cell: f64, rows: usize, near: f64, half: f64) -> (Mesh, Vec<[u32; 2]>) {
    let across = graded(near, half, (near / cell).round() as usize, 1.15);
    let up = mirrored(&graded(rows as f64 * cell, half, rows, 1.15));
    let counts = [across.len() - 1, up.len() - 1];
    let even = rectangle([0.0; 2], counts.map(|count| count as f64), counts);
    let nodes = even.nodes.iter().map(|[i, j]| [across[i.round() as usize], up[j.round() as usize]]);
    let mesh = Mesh { nodes: nodes.collect(), ..even };
    let mut edges = edges_where(&mesh, |[x, y]| y.abs() < 1e-9 && x < near + 1e-9);
    let at = |node: u32| mesh.nodes[node as usize][0];
    // Each edge is one of the element above it, and in the other direction of that below it.
    edges.retain(|&[a, b]| at(a) < at(b));
    edges.sort_unstable_by(|a, b| at(a[0]).total_cmp(&at(b[0])));
    (mesh, edges)
}

/// A round plate around a hole: circles with these radii, and these angles from 0 on, an even number of them.
/// Returns the edges of the hole, too, around the elements.
pub(super) fn round_plate(radii: &[f64], angles: &[f64]) -> (Mesh, Vec<[u32; 2]>) {
    let around = angles.len();
    let even =
        rectangle([0.0; 2], [radii.len() - 1, around].map(|count| count as f64), [radii.len() - 1, around]);
    let rings = radii.len() as u32;
    let place = |number: u32| {
        let (radius, angle) = (radii[(number % rings) as usize], angles[(number / rings) as usize]);
        // Exactly on the axes.
        let on = |x: f64| if x.abs() < 1e-12 { 0.0 } else { radius * x };
        [on(angle.cos()), on(angle.sin())]
    };
    let count = rings * around as u32;
    let elements = even.elements.iter().map(|nodes| nodes.map(|node| node % count)).collect();
    let mesh = one_body((0..count).map(place).collect(), elements);
    let wall = (0..around as u32).map(|k| [(k + 1) % around as u32 * rings, k * rings]);
    let wall = wall.collect();
    (mesh, wall)
}
