//! Kirsch's plate: a circular hole in a plate under tension.
//!
//! A quarter of the plate up to six radii of the hole, whose outer arc is moved as the infinite plate moves
//! there. With κ = (3 − ν)/(1 + ν) in plane stress, a tension σ along x and the radius a, polar displacements
//! are
//!
//! ```text
//! u = σ/(4 G) (r ((κ − 1)/2 + cos 2θ) + a²/r (1 + (1 + κ) cos 2θ) − a⁴/r³ cos 2θ)
//! v = σ/(4 G) (−r + a²/r (1 − κ) − a⁴/r³) sin 2θ
//! ```
//! and the stress along the edge of the hole is σ (1 − 2 cos 2θ), from −σ to 3 σ.

use fdem_simulation::{Boundary, Load, Material, Model, Schedule, Simulation, Target, TimeOptions};

use super::models::{advance_to, granite, moved, nodes_where, start};
use super::ring::quarter;
use super::{Outcome, Size};

/// Radii of the hole and of the plate, m.
const HOLE: f64 = 1.0;
const PLATE: f64 = 6.0;

/// Pa.
const TENSION: f64 = 1e3;

const POISSON: f64 = 0.25;

/// Displacement of the infinite plate at a point, m.
fn displacement([x, y]: [f64; 2]) -> [f64; 2] {
    let shear = granite().youngs_modulus / (2.0 * (1.0 + POISSON));
    let kappa = (3.0 - POISSON) / (1.0 + POISSON);
    let r = x.hypot(y);
    let (sin, cos) = (y / r, x / r);
    let (sin2, cos2) = (2.0 * sin * cos, cos * cos - sin * sin);
    let (near, far) = (HOLE * HOLE / r, HOLE.powi(4) / r.powi(3));
    let scale = TENSION / (4.0 * shear);
    let u = scale * (r * (0.5 * (kappa - 1.0) + cos2) + near * (1.0 + (1.0 + kappa) * cos2) - far * cos2);
    let v = scale * (-r + near * (1.0 - kappa) - far) * sin2;
    [u * cos - v * sin, u * sin + v * cos]
}

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    // Cells are about as long as wide.
    let rows = size.choose(24, 48);
    let columns = rows;
    let mut run = plate(rows, columns)?;
    let passage = PLATE / (granite().youngs_modulus / granite().density).sqrt();
    advance_to(&mut run, 40.0 * passage)?;
    let found = |node: u32, axis: usize| run.node(node).map_or(f64::NAN, |(moved, _)| moved[axis]);
    let last = columns as u32;
    let bound = size.choose(0.01, 0.003);
    let mut outcomes = Vec::new();
    for (name, node, axis) in [("along the tension", 0, 0), ("across it", last, 1)] {
        let expected = displacement(run.model().mesh.nodes[node as usize])[axis];
        let name = format!("displacement of the edge of the hole {name}");
        outcomes.push(Outcome::relative(name, expected, found(node, axis), bound, "m"));
    }
    // The edge carries no traction: E times the stretch of its first and its last piece, whose middles are
    // half a piece from the axes.
    let stress = |pair: [u32; 2]| {
        let [a, b] = pair.map(|node| run.model().mesh.nodes[node as usize]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let grown = [0, 1].map(|axis| found(pair[1], axis) - found(pair[0], axis));
        let square = along[0] * along[0] + along[1] * along[1];
        granite().youngs_modulus * (grown[0] * along[0] + grown[1] * along[1]) / square / TENSION
    };
    let half = 0.25 * std::f64::consts::PI / columns as f64;
    let cos2 = (2.0 * half).cos();
    for (name, pair, expected) in [
        ("largest stress along the edge, over the tension", [last - 1, last], 1.0 + 2.0 * cos2),
        ("least stress along the edge, over the tension", [0, 1], 1.0 - 2.0 * cos2),
    ] {
        outcomes.push(Outcome::relative(name, expected, stress(pair), 3.0 * bound, ""));
    }
    Ok(outcomes)
}

fn plate(rows: usize, columns: usize) -> Result<Simulation, String> {
    let mesh = quarter(HOLE, PLATE, rows, columns, (PLATE / HOLE).powf(1.0 / rows as f64));
    let [left, bottom] = [0, 1].map(|axis| {
        nodes_where(&mesh, |node| node[axis].abs() < 1e-9 && node[0].hypot(node[1]) < PLATE - 1e-9)
    });
    let mut boundaries = vec![
        moved("left", left, [Some(0.0), None], Schedule::Constant),
        moved("bottom", bottom, [None, Some(0.0)], Schedule::Constant),
    ];
    let passage = PLATE / (granite().youngs_modulus / granite().density).sqrt();
    for node in nodes_where(&mesh, |[x, y]| x.hypot(y) > PLATE - 1e-9) {
        boundaries.push(Boundary {
            name: format!("node {node}"),
            target: Target::Nodes(vec![node]),
            load: Load::Displacement(displacement(mesh.nodes[node as usize]).map(Some)),
            schedule: Schedule::Ramp(10.0 * passage),
        });
    }
    start(Model {
        mesh,
        boundaries,
        materials: vec![Material { poissons_ratio: POISSON, ..granite() }],
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        ..Model::default()
    })
}
