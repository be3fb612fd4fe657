//! An eighth of a thick sphere under pressure inside, at rest.

use std::collections::BTreeMap;

use fdem_simulation::{Load, Material, Model, Schedule, TimeOptions};

use super::bodies::{
    Body, Point, advance_to, centroid, cuboid, dot, faces_where, force, length, loaded, mapped, mean_motion,
    one_body, start,
};
use crate::models::{granite, moved, nodes_where};
use crate::{Outcome, Size};

/// Inner and outer radius, m.
const RADII: [f64; 2] = [0.1, 0.2];

/// Pa.
const PRESSURE: f64 = 1e6;

const POISSON: f64 = 0.25;

/// Lamé's sphere (Timoshenko and Goodier, 136): with the radii `a` and `b`,
///
/// ```text
/// u = p a³ r/(E (b³ - a³)) ((1 - 2 ν) + (1 + ν) b³/(2 r³)),    σ_t = p a³/(b³ - a³) (1 + b³/(2 r³)),    σ_r = p a³/(b³ - a³) (1 - b³/r³).
/// ```
/// It is also a cavity in a body under pressure.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let [a, b] = RADII;
    let mut outcomes = Vec::new();
    let mut errors = Vec::new();
    for &cells in size.choose(&[4_usize, 8] as &[usize], &[4, 8, 16]) {
        let mesh = octant(cells);
        let radius = |p: Point| length(p);
        let inner = nodes_where(&mesh, |p| radius(p) < a * (1.0 + 1e-6));
        let outer = nodes_where(&mesh, |p| radius(p) > b * (1.0 - 1e-6));
        let faces = faces_where(&mesh, |p| radius(p) < a * (1.0 + 1e-6));
        let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
        let mut boundaries: Vec<_> = (0..3)
            .map(|axis| {
                let nodes = nodes_where(&mesh, |p: Point| p[axis].abs() < 1e-9);
                moved(["x", "y", "z"][axis], nodes, still(axis), Schedule::Constant)
            })
            .collect();
        boundaries.push(loaded("inside", faces, Load::Pressure(PRESSURE), Schedule::Ramp(5e-5)));
        let material = Material { poissons_ratio: POISSON, ..granite() };
        let e = material.youngs_modulus;
        let directions = mesh.nodes.clone();
        let middles: Vec<Point> = (0..mesh.elements.len()).map(|element| centroid(&mesh, element)).collect();
        let mut run = start(Model {
            mesh,
            materials: vec![material],
            boundaries,
            time: TimeOptions { local_damping: 0.4, ..TimeOptions::default() },
            ..Model::default()
        })?;
        advance_to(&mut run, 5e-4)?;
        let grown = |nodes: &[u32]| {
            let of = |&node: &u32| {
                let [moved, _] = mean_motion(&run, &[node]);
                dot(moved, directions[node as usize]) / length(directions[node as usize])
            };
            nodes.iter().map(of).sum::<f64>() / nodes.len() as f64
        };
        let factor = PRESSURE * a.powi(3) / (b.powi(3) - a.powi(3));
        let exact =
            |r: f64| factor * r / e * ((1.0 - 2.0 * POISSON) + (1.0 + POISSON) * (b / r).powi(3) / 2.0);
        let bound = 0.7 / (cells * cells) as f64;
        let name = |what: &str| format!("{what}, {cells} cells through the wall");
        let error = grown(&inner) / exact(a) - 1.0;
        errors.push(error.abs());
        outcomes.push(Outcome::relative(
            name("growth of the inner radius"),
            exact(a),
            grown(&inner),
            bound,
            "m",
        ));
        outcomes.push(Outcome::relative(
            name("growth of the outer radius"),
            exact(b),
            grown(&outer),
            bound,
            "m",
        ));
        // Stress across the radius in the middle of the wall, at r = 1.5 a.
        let stresses = run.snapshot().stresses;
        let (mut found, mut expected, mut count) = (0.0, 0.0, 0.0);
        for (middle, [xx, yy, zz, xy, yz, xz]) in middles.iter().zip(&stresses) {
            let r = length(*middle);
            if (r / (1.5 * a) - 1.0).abs() > 0.1 {
                continue;
            }
            let [x, y, z] = middle.map(|x| x / r);
            let radial = xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + yz * y * z + xz * x * z);
            found += 0.5 * (xx + yy + zz - radial);
            expected += factor * (1.0 + 0.5 * (b / r).powi(3));
            count += 1.0;
        }
        outcomes.push(Outcome::relative(
            name("stress along the wall, mean at 1.5 a"),
            expected / count,
            found / count,
            3.0 * bound,
            "Pa",
        ));
        let area = std::f64::consts::PI * a * a / 4.0;
        outcomes.push(Outcome::relative(
            name("force on a plane of symmetry"),
            PRESSURE * area,
            -force(&run, 2)?[2],
            bound,
            "N",
        ));
    }
    let order = (errors[0] / errors[1]).log2();
    outcomes.push(Outcome::absolute("order of the error in the cell size", 2.0, order, 0.4, ""));
    Ok(outcomes)
}

/// An eighth of the sphere: three lattices, each a third of the way around the diagonal, with `cells` cells
/// through the wall and along each edge. The cells grow with the radius.
fn octant(cells: usize) -> Body {
    let [a, b] = RADII;
    let third = mapped(&cuboid([0.0; 3], [1.0; 3], [cells; 3]), |[i, j, k]| {
        let angle = |share: f64| (share * std::f64::consts::FRAC_PI_4).tan();
        let direction = [angle(i), angle(j), 1.0];
        let r = a * (b / a).powf(k) / length(direction);
        direction.map(|x| r * x)
    });
    let mut nodes: Vec<Point> = Vec::new();
    let mut known = BTreeMap::new();
    let mut elements = Vec::new();
    for turn in 0..3 {
        let numbers: Vec<u32> = third
            .nodes
            .iter()
            .map(|&[x, y, z]| {
                let place = [[x, y, z], [z, x, y], [y, z, x]][turn];
                *known.entry(place.map(|x| (1e7 * x).round() as i64)).or_insert_with(|| {
                    nodes.push(place);
                    nodes.len() as u32 - 1
                })
            })
            .collect();
        elements.extend(third.elements.iter().map(|corners| corners.map(|node| numbers[node as usize])));
    }
    one_body(nodes, elements)
}
