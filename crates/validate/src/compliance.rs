//! Compliance that joints add if they exist from the beginning.

use fdem_simulation::{
    Boundary, FractureOptions, Insertion, Interface, Load, Material, Model, Schedule, Target, TimeOptions,
};

use super::models::{advance_to, granite, moved, nodes_where, rectangle, rock, start};
use super::{Outcome, Size};

/// Width of a column, m, and the number of columns.
const WIDTH: f64 = 0.01;
const COLUMNS: usize = 12;

/// Strain of the strip.
const STRAIN: f64 = 1e-6;

pub(super) fn run(_size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for alpha in [10.0, 20.0, 50.0, 100.0] {
        let found = stiffness(Insertion::Intrinsic, alpha)?;
        let quantity = format!("stiffness with joints, α = {alpha}");
        outcomes.push(Outcome::relative(quantity, 1.0 / (1.0 + 1.0 / alpha), found, 0.001, "E"));
    }
    let found = stiffness(Insertion::Adaptive, 10.0)?;
    outcomes.push(Outcome::relative("stiffness with adaptive joints", 1.0, found, 0.001, "E"));
    Ok(outcomes)
}

/// Stiffness of a strip with joints between its columns: stress over strain over Young's modulus.
fn stiffness(insertion: Insertion, joint_penalty: f64) -> Result<f64, String> {
    let length = WIDTH * COLUMNS as f64;
    let mut mesh = rectangle([0.0, 0.0], [length, WIDTH], [COLUMNS, 1]);
    // Columns of two materials alternate: only the joints between the two can break.
    for element in 0..mesh.elements.len() {
        mesh.materials[element] = (element / 2 % 2) as u32;
    }
    let at = |place: f64| nodes_where(&mesh, |[x, _]| (x - place).abs() < 1e-9);
    let (left, right) = (at(0.0), at(length));
    let material = granite();
    let wave = length * (material.density / material.youngs_modulus).sqrt();
    let model = Model {
        materials: vec![Material { name: "odd".to_owned(), ..material.clone() }, material.clone()],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: 0.0,
            penalty: None,
            strength: Some(rock()),
        }],
        boundaries: vec![
            moved("left", left, [Some(0.0), None], Schedule::Constant),
            Boundary {
                name: "right".to_owned(),
                target: Target::Nodes(right),
                load: Load::Displacement([Some(STRAIN * length), None]),
                schedule: Schedule::Ramp(20.0 * wave),
            },
        ],
        fracture: FractureOptions { insertion, joint_penalty, ..FractureOptions::default() },
        time: TimeOptions { local_damping: 0.7, ..TimeOptions::default() },
        mesh,
        ..Model::default()
    };
    let mut run = start(model)?;
    advance_to(&mut run, 100.0 * wave)?;
    let snapshot = run.snapshot();
    let count = snapshot.stresses.len() as f64;
    let stress = snapshot.stresses.iter().map(|stress| stress[0]).sum::<f64>() / count;
    // The length from the left side of the second column to that of the last has one joint per column.
    let left_of = |column: usize| {
        let nodes = snapshot.elements[2 * column..2 * column + 2].iter().flatten();
        let corners: Vec<_> = nodes.map(|&node| node as usize).collect();
        let least = |node: &usize| snapshot.positions[*node][0];
        corners
            .into_iter()
            .min_by(|a, b| least(a).total_cmp(&least(b)))
            .map_or(f64::NAN, |node| snapshot.displacements[node][0])
    };
    let strain = (left_of(COLUMNS - 1) - left_of(1)) / (WIDTH * (COLUMNS - 2) as f64);
    Ok(stress / strain / material.youngs_modulus)
}
