//! A hole through a block under tension, in plane strain, at rest.
//!
//! A quarter of the block up to four radii of the hole, between two planes of symmetry across the hole's
//! axis. Its outer face is moved as the infinite block moves there. With `κ = 3 - 4 ν` (plane strain), a
//! tension `σ` along x and the radius `a` of the hole, polar displacements are those of Kirsch (Timoshenko
//! and Goodier, 35)
//!
//! ```text
//! u = σ/(4 G) (r ((κ - 1)/2 + cos 2θ) + a²/r (1 + (1 + κ) cos 2θ) - a⁴/r³ cos 2θ)
//! v = σ/(4 G) (-r + a²/r (1 - κ) - a⁴/r³) sin 2θ
//! ```
//!
//! and stresses
//!
//! ```text
//! σ_r = σ/2 (1 - a²/r²) + σ/2 (1 - 4 a²/r² + 3 a⁴/r⁴) cos 2θ,    σ_θ = σ/2 (1 + a²/r²) - σ/2 (1 + 3 a⁴/r⁴) cos 2θ.
//! ```
//!
//! From these follow, up to the radius `R` and for the thickness `t`: the force across the plane x = 0, the
//! integral of `σ_θ` at θ = 90°, is `σ t (R - a²/(2 R) - a⁴/(2 R³))`; the force along the axis of the hole is
//! `ν` times the integral of `σ_r + σ_θ = σ (1 - 2 a²/r² cos 2θ)`, which is `ν σ` times the area, because
//! `cos 2θ` cancels over the quarter.

use std::f64::consts::{FRAC_PI_2, PI};

use fdem_simulation::{Boundary, Load, Material, Model, Schedule, Target, TimeOptions};

use super::bodies::{Point, advance_to, cuboid, dot, force, length, mapped, mean_motion, minus, start};
use crate::models::{granite, moved, nodes_where};
use crate::{Outcome, Size};

/// Radii of the hole and of the outer face, m.
const HOLE: f64 = 0.1;
const OUTER: f64 = 0.4;

/// Pa.
const TENSION: f64 = 1e5;

const POISSON: f64 = 0.25;

/// Cells through the thickness.
const LAYERS: usize = 2;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let mut errors = Vec::new();
    let sizes: &[usize] = size.choose(&[8, 16], &[12, 24, 48]);
    for &cells in sizes {
        let (found, error) = block(cells)?;
        outcomes.extend(found);
        errors.push(error.abs());
    }
    let order = (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64;
    outcomes.push(Outcome::absolute("order of the error in the cell size", 2.0, order, 0.4, ""));
    Ok(outcomes)
}

/// Displacement of the infinite block, m.
fn displacement([x, y, _]: Point) -> Point {
    let shear = granite().youngs_modulus / (2.0 * (1.0 + POISSON));
    let kappa = 3.0 - 4.0 * POISSON;
    let r = x.hypot(y);
    let (sin, cos) = (y / r, x / r);
    let (sin2, cos2) = (2.0 * sin * cos, cos * cos - sin * sin);
    let (near, far) = (HOLE * HOLE / r, HOLE.powi(4) / r.powi(3));
    let scale = TENSION / (4.0 * shear);
    let u = scale * (r * (0.5 * (kappa - 1.0) + cos2) + near * (1.0 + (1.0 + kappa) * cos2) - far * cos2);
    let v = scale * (-r + near * (1.0 - kappa) - far) * sin2;
    [u * cos - v * sin, u * sin + v * cos, 0.0]
}

/// Outcomes of a block with `cells` cells along the quarter of the hole's edge, and the error of the
/// displacement of the edge along the tension.
fn block(cells: usize) -> Result<(Vec<Outcome>, f64), String> {
    // Cells are about as long as wide.
    let rows = ((OUTER / HOLE).ln() * cells as f64 / FRAC_PI_2).round() as usize;
    let thickness = 2.0 * LAYERS as f64 * FRAC_PI_2 * HOLE / cells as f64;
    let mesh = mapped(&cuboid([0.0; 3], [1.0; 3], [rows, cells, LAYERS]), |[i, j, k]| {
        let (sin, cos) = (FRAC_PI_2 * j).sin_cos();
        let r = HOLE * (OUTER / HOLE).powf(i);
        [if j == 1.0 { 0.0 } else { r * cos }, r * sin, thickness * k]
    });
    let on = |axis: usize, place: f64| nodes_where(&mesh, |p: Point| (p[axis] - place).abs() < 1e-9);
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let mut boundaries = vec![
        moved("x", on(0, 0.0), still(0), Schedule::Constant),
        moved("y", on(1, 0.0), still(1), Schedule::Constant),
        moved("front", on(2, 0.0), still(2), Schedule::Constant),
        moved("back", on(2, thickness), still(2), Schedule::Constant),
    ];
    let material = Material { poissons_ratio: POISSON, ..granite() };
    let e = material.youngs_modulus;
    let passage = OUTER / (e / material.density).sqrt();
    for node in nodes_where(&mesh, |[x, y, _]| x.hypot(y) > OUTER * (1.0 - 1e-9)) {
        let place = mesh.nodes[node as usize];
        let goal = displacement(place);
        // The planes of symmetry hold their own direction.
        let free = |axis: usize| (place[axis].abs() > 1e-9).then_some(goal[axis]);
        boundaries.push(Boundary {
            name: format!("node {node}"),
            target: Target::Nodes(vec![node]),
            load: Load::Displacement([free(0), free(1), None]),
            schedule: Schedule::Ramp(8.0 * passage),
        });
    }
    let places = mesh.nodes.clone();
    let mut run = start(Model {
        mesh,
        materials: vec![material],
        boundaries,
        time: TimeOptions { local_damping: 0.5, ..TimeOptions::default() },
        ..Model::default()
    })?;
    advance_to(&mut run, 25.0 * passage)?;

    // Means over the layers of nodes through the thickness.
    let edge = |column: usize| -> Vec<u32> {
        (0..=LAYERS).map(|layer| ((layer * (cells + 1) + column) * (rows + 1)) as u32).collect()
    };
    let [along, across] = [(0, 0), (cells, 1)].map(|(column, axis)| {
        let nodes = edge(column);
        (displacement(places[nodes[0] as usize])[axis], mean_motion(&run, &nodes)[0][axis])
    });
    // The edge carries no traction and does not stretch along the axis: its stress is E/(1 - ν²) times the
    // stretch of its first and its last piece.
    let stress = |columns: [usize; 2]| {
        let [a, b] = columns.map(|column| places[edge(column)[0] as usize]);
        let [before, after] = columns.map(|column| mean_motion(&run, &edge(column))[0]);
        let piece = minus(b, a);
        let stretch = dot(minus(after, before), piece) / length(piece).powi(2);
        e / (1.0 - POISSON * POISSON) * stretch / TENSION
    };
    // The middles of the pieces are half a piece from the axes.
    let cos2 = (FRAC_PI_2 / cells as f64).cos();
    let held =
        TENSION * thickness * (OUTER - HOLE * HOLE / (2.0 * OUTER) - HOLE.powi(4) / (2.0 * OUTER.powi(3)));
    let area = PI * (OUTER * OUTER - HOLE * HOLE) / 4.0;
    let bound = BOUND / (cells * cells) as f64;
    let name = |what: &str| format!("{what}, {cells} cells along the edge");
    let outcomes = vec![
        // All errors of one kind are compared with the largest value of that kind.
        Outcome::absolute(
            name("displacement of the edge along the tension"),
            along.0,
            along.1,
            bound * along.0,
            "m",
        ),
        Outcome::absolute(
            name("displacement of the edge across it"),
            across.0,
            across.1,
            bound * along.0,
            "m",
        ),
        Outcome::absolute(
            name("largest stress along the edge, over the tension"),
            1.0 + 2.0 * cos2,
            stress([cells - 1, cells]),
            3.0 * bound,
            "",
        ),
        Outcome::absolute(
            name("least stress along the edge, over the tension"),
            1.0 - 2.0 * cos2,
            stress([0, 1]),
            3.0 * bound,
            "",
        ),
        Outcome::relative(name("force across the plane of symmetry"), -held, force(&run, 0)?[0], bound, "N"),
        Outcome::relative(
            name("force along the axis of the hole"),
            POISSON * TENSION * area,
            force(&run, 3)?[2],
            bound,
            "N",
        ),
    ];
    Ok((outcomes, along.1 / along.0 - 1.0))
}

/// Bound of the errors times the square of the number of cells along the quarter of the edge. Errors fall
/// with the square of the size: the order is an outcome. A chord of the edge alone is off by `(π/2)²/8 = 0.3`
/// of the radius over that square, and the stress, three times the tension, falls by a third of itself within
/// a tenth of the radius.
const BOUND: f64 = 3.0;
