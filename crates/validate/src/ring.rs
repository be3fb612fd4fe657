//! Lamé's thick ring: elastic equilibrium, and the order at which the elements converge to it.
//!
//! A ring with the radii a and b, plane stress, under a pressure p inside. Its inner radius grows by
//!
//! ```text
//! u = p a/E ((b² + a²)/(b² − a²) + ν).
//! ```

use std::f64::consts::PI;

use fdem_simulation::{Boundary, Load, Material, Mesh, Model, Schedule, Target, TimeOptions};

use super::models::{advance_to, granite, moved, nodes_where, one_body, start};
use super::{Outcome, Size};

/// m.
const INNER: f64 = 1.0;
const OUTER: f64 = 2.0;

/// Pa: strains are so small that a linear theory holds.
const PRESSURE: f64 = 1e3;

const POISSON: f64 = 0.25;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let (a, b) = (INNER * INNER, OUTER * OUTER);
    let modulus = granite().youngs_modulus;
    let expected = PRESSURE * INNER / modulus * ((b + a) / (b - a) + POISSON);
    let sizes: &[usize] = size.choose(&[4, 8], &[4, 8, 16]);
    let mut outcomes = Vec::new();
    let mut errors = Vec::new();
    for &elements in sizes {
        let found = growth(elements)?;
        // The error of a linear element is of the order of the square of its size.
        let bound = 0.4 / (elements * elements) as f64;
        let name = format!("growth of the inner radius, {elements} elements across");
        outcomes.push(Outcome::relative(name, expected, found, bound, "m"));
        errors.push((found / expected - 1.0).abs());
    }
    for (pair, elements) in errors.windows(2).zip(sizes) {
        let order = (pair[0] / pair[1]).log2();
        let name = format!("order of convergence from {elements} to {} elements", 2 * elements);
        outcomes.push(Outcome::absolute(name, 2.0, order, 0.2, ""));
    }
    Ok(outcomes)
}

/// Mean displacement of the nodes at the inner radius at rest, m.
fn growth(elements: usize) -> Result<f64, String> {
    let mesh = quarter(INNER, OUTER, elements, 3 * elements, 1.0);
    let [left, bottom] = [0, 1].map(|axis| nodes_where(&mesh, |node| node[axis].abs() < 1e-9));
    let inner: Vec<[u32; 2]> = (0..3 * elements as u32).map(|k| [k + 1, k]).collect();
    let radius = |[x, y]: [f64; 2]| x.hypot(y);
    let nodes = nodes_where(&mesh, |node| (radius(node) - INNER).abs() < 1e-9);
    let passage = OUTER / (granite().youngs_modulus / granite().density).sqrt();
    let model = Model {
        boundaries: vec![
            moved("left", left, [Some(0.0), None], Schedule::Constant),
            moved("bottom", bottom, [None, Some(0.0)], Schedule::Constant),
            Boundary {
                name: "pressure".to_owned(),
                target: Target::Facets(inner),
                load: Load::Pressure(PRESSURE),
                schedule: Schedule::Ramp(10.0 * passage),
            },
        ],
        mesh,
        materials: vec![Material { poissons_ratio: POISSON, ..granite() }],
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance_to(&mut run, 40.0 * passage)?;
    let moved = nodes.iter().filter_map(|&node| {
        let at = run.model().mesh.nodes[node as usize];
        let ([x, y], _) = run.node(node)?;
        Some((x * at[0] + y * at[1]) / INNER)
    });
    Ok(moved.sum::<f64>() / nodes.len() as f64)
}

/// A quarter of a ring in the first quadrant, of `rows` by `columns` cells of two triangles; rows grow
/// outwards by `growth` each. Nodes of the inner arc come first, from the x axis on.
pub(super) fn quarter(inner: f64, outer: f64, rows: usize, columns: usize, growth: f64) -> Mesh {
    let weight = |row: usize| {
        (0..row).map(|k| i32::try_from(k).unwrap_or(i32::MAX)).map(|k| growth.powi(k)).sum::<f64>()
    };
    let nodes = (0..=rows)
        .flat_map(|row| {
            let radius = inner + (outer - inner) * weight(row) / weight(rows);
            (0..=columns).map(move |column| {
                let (sin, cos) = (0.5 * PI * column as f64 / columns as f64).sin_cos();
                // The ends lie on the axes.
                let on = |x: f64, end: bool| if end { 0.0 } else { radius * x };
                [on(cos, column == columns), on(sin, column == 0)]
            })
        })
        .collect();
    let node = |row: usize, column: usize| (row * (columns + 1) + column) as u32;
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [node(row, column), node(row + 1, column)];
            let [d, c] = [node(row, column + 1), node(row + 1, column + 1)];
            if (row + column) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    one_body(nodes, triangles)
}
