//! A circular hole that is excavated from a stressed plate: Kirsch's stresses, Lamé's displacement, and the
//! energy that a sudden excavation sets free.
//!
//! A quarter of the plate with the core in it is under initial stress. The core vanishes, and the forces that
//! it exerted fall to 0. The hole adds to displacements, for a stress σ along x, with κ = (3 − ν)/(1 + ν) in
//! plane stress and the radius a, in polar coordinates
//!
//! ```text
//! u = σ/(4 G) (a²/r (1 + (1 + κ) cos 2θ) − a⁴/r³ cos 2θ)
//! v = σ/(4 G) (a²/r (1 − κ) − a⁴/r³) sin 2θ
//! ```
//! and the stress along the edge is σ (1 − 2 cos 2θ).

use std::f64::consts::PI;

use fdem_simulation::{
    Boundary, Change, Load, Material, Mesh, Model, Schedule, Simulation, Target, TimeOptions,
};

use super::models::{advance_to, centroid, edges_where, granite, moved, nodes_where, one_body, start};
use super::ring::quarter;
use super::{Outcome, Size};

/// Radii of the hole and of the plate, m.
const HOLE: f64 = 1.0;
const PLATE: f64 = 6.0;

/// Stresses along x and y before the excavation, Pa.
const STRESSES: [f64; 2] = [-2e3, -1e3];

const POISSON: f64 = 0.25;

/// Wave passages through the plate: when the core vanishes, for how long its forces fall, and until rest.
const BEGIN: f64 = 0.5;
const RELEASE: f64 = 10.0;
const REST: f64 = 45.0;

fn passage() -> f64 {
    PLATE / (granite().youngs_modulus / granite().density).sqrt()
}

/// Kirsch's hole in ground under two stresses: hoop stresses at the two ends of its edge, and how they
/// converge.
pub(super) fn kirsch(size: Size) -> Result<Vec<Outcome>, String> {
    let sizes: &[usize] = size.choose(&[8, 16], &[8, 16, 32]);
    let mut outcomes = Vec::new();
    let mut errors = Vec::new();
    let [x, y] = STRESSES;
    let largest = x + y - 2.0 * (y - x).abs();
    for &columns in sizes {
        let run = excavated(columns)?;
        let [least, most] = edge_stresses(&run, columns);
        let half = 0.25 * PI / columns as f64;
        let cos2 = (2.0 * half).cos();
        // At θ = half and at a right angle less that.
        let at = |cos2: f64| x + y - 2.0 * (x - y) * cos2;
        // The order is 2: 3 % at 32 elements around, and a quarter of that at 64.
        let bound = 0.03 * (8.0 / columns as f64).powi(2);
        for (name, expected, found) in [("at the sides", at(cos2), least), ("in the roof", at(-cos2), most)] {
            let name =
                format!("hoop stress {name} over the largest of theory, {} elements around", 4 * columns);
            outcomes.push(Outcome::absolute(name, expected / largest, found / largest, bound, ""));
        }
        errors.push((most / at(-cos2) - 1.0).abs());
    }
    for (pair, columns) in errors.windows(2).zip(sizes) {
        let name =
            format!("order of convergence in the roof from {} to {} elements", 4 * columns, 8 * columns);
        outcomes.push(Outcome::absolute(name, 2.0, (pair[0] / pair[1]).log2(), 0.5, ""));
    }
    Ok(outcomes)
}

/// A hole in ground under a pressure that is released suddenly: Lamé's displacement, and Salamon's energy
/// that is set free.
pub(super) fn sudden(size: Size) -> Result<Vec<Outcome>, String> {
    let columns = size.choose(12, 24);
    let pressure = 1e3;
    let (mut model, core) = plate(columns, [-pressure; 2], PLATE);
    let arc = edges_where(&model.mesh, |[x, y]| x.hypot(y) > PLATE - 1e-9);
    model.boundaries.push(Boundary {
        name: "pressure".to_owned(),
        target: Target::Facets(arc),
        load: Load::Pressure(pressure),
        schedule: Schedule::Constant,
    });
    let before = start(model)?;
    let mut run = without_core(&before, &core, None)?;
    advance_to(&mut run, REST * passage())?;
    let (a, b) = (HOLE * HOLE, PLATE * PLATE);
    let modulus = granite().youngs_modulus;
    let expected = pressure * HOLE / modulus * ((b + a) / (b - a) + POISSON);
    let wall = nodes_where(&run.model().mesh, |[x, y]| (x.hypot(y) - HOLE).abs() < 1e-9);
    let inward = wall.iter().filter_map(|&node| {
        let [x, y] = run.model().mesh.nodes[node as usize];
        let ([u, v], _) = run.node(node)?;
        Some(-(u * x + v * y) / HOLE)
    });
    let found = inward.sum::<f64>() / wall.len() as f64;
    // Half of the force that is released, times its way: a quarter of the circle.
    let free = 0.25 * PI * HOLE * pressure * expected;
    let energies = run.energies();
    Ok(vec![
        Outcome::relative("displacement of the wall", expected, found, 0.01, "m"),
        Outcome::relative("energy set free, which damping takes", free, energies.damping, 0.02, "J"),
        Outcome::absolute("error of the energy balance", 0.0, energies.error(), 1e-3, ""),
    ])
}

/// Displacement that the hole adds at a point, m.
fn added([x, y]: [f64; 2]) -> [f64; 2] {
    let shear = granite().youngs_modulus / (2.0 * (1.0 + POISSON));
    let kappa = (3.0 - POISSON) / (1.0 + POISSON);
    let r = x.hypot(y);
    let (sin, cos) = (y / r, x / r);
    let (sin2, cos2) = (2.0 * sin * cos, cos * cos - sin * sin);
    let (near, far) = (HOLE * HOLE / r, HOLE.powi(4) / r.powi(3));
    let [sum, difference] = [STRESSES[0] + STRESSES[1], STRESSES[0] - STRESSES[1]];
    let u = (sum * near + difference * ((1.0 + kappa) * near - far) * cos2) / (4.0 * shear);
    let v = difference * (near * (1.0 - kappa) - far) * sin2 / (4.0 * shear);
    [u * cos - v * sin, u * sin + v * cos]
}

/// The plate at rest after its hole has been excavated slowly. Its outer arc moves as that of an infinite
/// plate.
fn excavated(columns: usize) -> Result<Simulation, String> {
    let (mut model, core) = plate(columns, STRESSES, PLATE - 1e-9);
    let (begin, end) = (BEGIN * passage(), (BEGIN + RELEASE) * passage());
    for node in nodes_where(&model.mesh, |[x, y]| x.hypot(y) > PLATE - 1e-9) {
        model.boundaries.push(Boundary {
            name: format!("node {node}"),
            target: Target::Nodes(vec![node]),
            load: Load::Displacement(added(model.mesh.nodes[node as usize]).map(Some)),
            schedule: Schedule::Table(vec![[0.0, 0.0], [begin, 0.0], [end, 1.0]]),
        });
    }
    let mut before = start(model)?;
    advance_to(&mut before, begin)?;
    let release = Schedule::Table(vec![[0.0, 1.0], [RELEASE * passage(), 0.0]]);
    let mut run = without_core(&before, &core, Some(release))?;
    advance_to(&mut run, REST * passage())?;
    Ok(run)
}

/// The run without its core.
fn without_core(run: &Simulation, core: &[bool], release: Option<Schedule>) -> Result<Simulation, String> {
    let text = |error: fdem_simulation::ModelError| error.to_string();
    let model = run.model().clone();
    let keep: Vec<bool> = core.iter().map(|core| !core).collect();
    let release = release.map(|release| ("release".to_owned(), release));
    let change = Change::excavating(&model, &keep, release).map_err(text)?;
    let (model, state) = run.state().changed(&model, change, 1).map_err(text)?;
    Simulation::resume(model, state, 1).map_err(text)
}

/// A quarter of a plate with `columns` cells along a quarter of the hole, under stresses along x and y, and
/// the list of elements of the core. The axes are held up to this radius.
fn plate(columns: usize, [x, y]: [f64; 2], held: f64) -> (Model, Vec<bool>) {
    // Cells are half as long as wide: stresses change more across the edge than along it.
    let rows = (2.0 * (PLATE / HOLE).ln() / (0.5 * PI) * columns as f64).round() as usize;
    let outer = quarter(HOLE, PLATE, rows, columns, (PLATE / HOLE).powf(1.0 / rows as f64));
    let inner = quarter(0.5 * HOLE, HOLE, columns.div_ceil(3), columns, 1.0);
    let mut nodes = inner.nodes;
    let mut elements = inner.elements;
    // The arc of the hole is the last of the core and the first of the plate.
    let shared = nodes.len() - columns - 1;
    nodes.truncate(shared);
    nodes.extend(outer.nodes);
    elements.extend(outer.elements.iter().map(|element| element.map(|node| node + shared as u32)));
    let middle = nodes.len() as u32;
    nodes.push([0.0, 0.0]);
    elements.extend((0..columns as u32).map(|column| [middle, column, column + 1]));
    let mesh: Mesh = one_body(nodes, elements);
    let core = (0..mesh.elements.len()).map(|element| {
        let [x, y] = centroid(&mesh, element);
        x.hypot(y) < HOLE
    });
    let core = core.collect();
    let on_axis =
        |axis: usize| nodes_where(&mesh, |node| node[axis].abs() < 1e-9 && node[0].hypot(node[1]) <= held);
    let boundaries = vec![
        moved("left", on_axis(0), [Some(0.0), None], Schedule::Constant),
        moved("bottom", on_axis(1), [None, Some(0.0)], Schedule::Constant),
    ];
    let model = Model {
        boundaries,
        stresses: vec![[[x, 0.0], [0.0, y]]; mesh.elements.len()],
        materials: vec![Material { poissons_ratio: POISSON, ..granite() }],
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        mesh,
        ..Model::default()
    };
    (model, core)
}

/// Stresses along the edge of the hole, in its first piece and in its last, Pa: from the stretch of the
/// pieces, and from the stress across the edge, which has vanished.
fn edge_stresses(run: &Simulation, columns: usize) -> [f64; 2] {
    let mesh = &run.model().mesh;
    let mut wall = nodes_where(mesh, |[x, y]| (x.hypot(y) - HOLE).abs() < 1e-9);
    wall.sort_by(|&a, &b| mesh.nodes[a as usize][1].total_cmp(&mesh.nodes[b as usize][1]));
    let stress = |[a, b]: [u32; 2], angle: f64| {
        let [from, to] = [a, b].map(|node| mesh.nodes[node as usize]);
        let moved = |node: u32| run.node(node).map_or([f64::NAN; 2], |(moved, _)| moved);
        let (u, v) = (moved(a), moved(b));
        let along = [to[0] - from[0], to[1] - from[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let strain = ((v[0] - u[0]) * along[0] + (v[1] - u[1]) * along[1]) / square;
        let [x, y] = STRESSES;
        let (sin, cos) = angle.sin_cos();
        let [across, hoop] = [x * cos * cos + y * sin * sin, x * sin * sin + y * cos * cos];
        hoop + granite().youngs_modulus * strain - POISSON * across
    };
    let half = 0.25 * PI / columns as f64;
    let last = columns;
    [stress([wall[0], wall[1]], half), stress([wall[last - 1], wall[last]], 0.5 * PI - half)]
}
