//! A shear box: peak and residual strength, fracture energy of sliding, and joints that contact replaces.

use fdem_simulation::{
    Boundary, FractureOptions, Insertion, Interface, Load, Material, Mesh, Model, Schedule, Simulation,
    Target,
};

use super::models::{
    DENSITY, advance, advance_to, centroid, force, granite, moved, nodes_where, one_body, rectangle, rock,
    start,
};
use super::{Outcome, Size};

/// Width and height of a cell, m. Cells are flat, so that the free ends of the blocks have little influence
/// on the stress.
const CELL: f64 = 0.002;
const HEIGHT: f64 = 0.0005;

/// Number of cells of the upper block along the joints.
const COLUMNS: usize = 12;

const LENGTH: f64 = CELL * COLUMNS as f64;

/// Time in which the pressure rises, s.
const PRESSING: f64 = 2e-4;

/// Speeds, m/s: up to the peak, while the joints break, and afterwards.
const SPEEDS: [f64; 3] = [0.004, 0.1, 0.5];

/// Time from one speed to the next, s.
const RAMP: f64 = 2e-4;

/// Displacement at the first speed, m: the peak is over then.
const SOFTENING: f64 = 1e-6;

/// Displacement at which the joints are broken and contact has not begun to replace them, m.
const BROKEN: f64 = 0.07 * CELL;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let both = [("adaptive", Insertion::Adaptive), ("intrinsic", Insertion::Intrinsic)];
    let stresses: &[f64] = size.choose(&[2e6, 6e6], &[1e6, 2e6, 4e6, 8e6]);
    for (name, insertion) in both {
        for &stress in stresses {
            let sheared = shear(insertion, stress)?;
            let case = |what: &str| format!("{what}, {} MPa, {name}", stress / 1e6);
            let residual = stress * rock().friction;
            outcomes.extend([
                Outcome::relative(case("peak"), rock().cohesion + residual, sheared.peak, 0.02, "Pa"),
                Outcome::relative(case("residual of joints"), residual, sheared.residual, 0.02, "Pa"),
                Outcome::relative(case("residual of contacts"), residual, sheared.contact, 0.02, "Pa"),
                Outcome::relative(case("energy of sliding"), rock().energy_ii, sheared.energy, 0.02, "J/m²"),
                Outcome::absolute(case("error of the energy balance"), 0.0, sheared.balance, 1e-3, ""),
            ]);
        }
    }
    Ok(outcomes)
}

struct ShearBox {
    /// Pa.
    peak: f64,
    residual: f64,
    contact: f64,
    /// J/m².
    energy: f64,
    /// A share.
    balance: f64,
}

/// Two blocks of two rows, the lower one longer, that share the nodes between them. The outer rows are
/// platens.
fn blocks() -> Mesh {
    let lower = rectangle([0.0, -2.0 * HEIGHT], [LENGTH, 0.0], [COLUMNS, 2]);
    let upper = rectangle([0.0, 0.0], [LENGTH, 2.0 * HEIGHT], [COLUMNS, 2]);
    let mut nodes = lower.nodes.clone();
    let numbers: Vec<u32> = upper
        .nodes
        .iter()
        .map(|&[x, y]| {
            let same = |&[u, v]: &[f64; 2]| (u - x).hypot(v - y) < 1e-3 * CELL;
            nodes.iter().position(same).unwrap_or_else(|| {
                nodes.push([x, y]);
                nodes.len() - 1
            }) as u32
        })
        .collect();
    let of_upper = upper.elements.iter().map(|corners| corners.map(|node| numbers[node as usize]));
    let triangles = lower.elements.iter().copied().chain(of_upper).collect();
    let mut mesh = one_body(nodes, triangles);
    for element in 0..mesh.elements.len() {
        let [_, y] = centroid(&mesh, element);
        mesh.materials[element] = match y {
            y if y.abs() > HEIGHT => 2,
            y if y > 0.0 => 1,
            _ => 0,
        };
    }
    mesh
}

fn model(insertion: Insertion, stress: f64) -> Model {
    let mesh = blocks();
    let held = nodes_where(&mesh, |[_, y]| y < -0.5 * HEIGHT);
    let pushed = nodes_where(&mesh, |[_, y]| y > 0.5 * HEIGHT);
    let top = nodes_where(&mesh, |[_, y]| y > 1.5 * HEIGHT);
    let edges = top.windows(2).map(|pair| [pair[1], pair[0]]).collect();
    let rock_of_blocks =
        Material { density: 16.0 * DENSITY, youngs_modulus: 30e9, damping: 0.1, ..granite() };
    // The platens are stiff and have the same wave speed. A block that tilts would carry another normal
    // stress at its ends than in its middle.
    let platen = Material {
        name: "platen".to_owned(),
        density: 100.0 * rock_of_blocks.density,
        youngs_modulus: 100.0 * rock_of_blocks.youngs_modulus,
        ..rock_of_blocks.clone()
    };
    let peak = 2.0 * PRESSING + RAMP + SOFTENING / SPEEDS[0];
    let broken = peak + RAMP + BROKEN / SPEEDS[1];
    let speeds = Schedule::Table(vec![
        [2.0 * PRESSING, 0.0],
        [2.0 * PRESSING + RAMP, SPEEDS[0]],
        [peak, SPEEDS[0]],
        [peak + RAMP, SPEEDS[1]],
        [broken, SPEEDS[1]],
        [broken + RAMP, SPEEDS[2]],
    ]);
    Model {
        mesh,
        materials: vec![rock_of_blocks.clone(), rock_of_blocks, platen],
        interfaces: vec![Interface {
            materials: [0, 1],
            friction: rock().friction,
            penalty: None,
            strength: Some(rock()),
        }],
        boundaries: vec![
            moved("lower", held, [Some(0.0), Some(0.0)], Schedule::Constant),
            moved("upper", pushed, [Some(1.0), None], speeds),
            Boundary {
                name: "pressure".to_owned(),
                target: Target::Facets(edges),
                load: Load::Pressure(stress),
                schedule: Schedule::Ramp(PRESSING),
            },
        ],
        fracture: FractureOptions { insertion, joint_penalty: 20.0, ..FractureOptions::default() },
        ..Model::default()
    }
}

fn shear(insertion: Insertion, stress: f64) -> Result<ShearBox, String> {
    let mut run = start(model(insertion, stress))?;
    advance_to(&mut run, 2.0 * PRESSING)?;
    let (mut peak, mut residual) = (0.0_f64, Mean::default());
    let mut moved = 0.0;
    while moved < BROKEN {
        let (traction, at) = step(&mut run)?;
        moved = at;
        peak = peak.max(traction);
        if moved > 0.9 * BROKEN {
            residual.add(traction);
        }
    }
    if run.counts().broken != COLUMNS {
        return Err(format!("{} of {COLUMNS} joints are broken", run.counts().broken));
    }
    let cracks = run.snapshot().cracks;
    let slid = cracks.iter().map(|crack| crack.sliding.abs()).sum::<f64>() / cracks.len() as f64;
    // Work without that of friction.
    let energies = run.energies();
    let energy = (energies.cohesive + energies.friction) / LENGTH - stress * rock().friction * slid;
    let mut contact = Mean::default();
    while moved < 0.45 * CELL {
        let (traction, at) = step(&mut run)?;
        moved = at;
        if moved > 0.4 * CELL {
            contact.add(traction);
        }
    }
    let balance = run.energies().error();
    Ok(ShearBox { peak, residual: residual.value(), contact: contact.value(), energy, balance })
}

/// One step: the mean shear stress, Pa, and how far the upper block has been moved, m.
fn step(run: &mut Simulation) -> Result<(f64, f64), String> {
    advance(run, 1)?;
    let node = run.model().mesh.nodes.len() as u32 - 1;
    let moved = run.node(node).map_or(f64::NAN, |([x, _], _)| x);
    if moved.is_nan() {
        return Err("the upper block is nowhere".to_owned());
    }
    // The force on the lower block, which does not move, contains no inertia.
    Ok((-force(run, 0)?[0] / LENGTH, moved))
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> f64 {
        self.sum / f64::from(self.count)
    }
}
