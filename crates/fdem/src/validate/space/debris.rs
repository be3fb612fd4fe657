//! Debris: a block that breaks in a box that is shaken, and whose fragments strike each other and the walls again and again.
//!
//! Elements that a joint held together touch as soon as it breaks, often deeply, and the load of the joint passes to the contact. If the contact counted an overlap of the
//! beginning, or if the joint let go while it pressed, each transition would create or destroy energy.

use fdem_simulation::{FractureOptions, Insertion, Material, Model, Schedule, Strength, TimeOptions};

use super::bodies::{
    Body, Point, Turn, advance, centroid, cross, cuboid, jittered, on_box, one_body, plus, start, turned,
};
use crate::validate::models::{granite, moved, rock, together, worse};
use crate::validate::{Outcome, Size};

/// Width of a cell of the block, m.
const CELL: f64 = 0.01;

/// Speed of the block at the beginning, m/s.
const SPEED: f64 = 30.0;

/// Amplitude of the acceleration of the box, m/s².
const SHAKING: f64 = 4e4;

/// The sum of all energies stays what it was at the beginning plus the work of shaking, to 1e-4 of the most that was in the system. A transition is a joint that breaks, or a couple of
/// elements that begins or ceases to touch; as many couples may begin as cease in one step, so that there are more transitions than are counted.
pub(in crate::validate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let (cells, steps) = size.choose((2, 6000), (3, 20_000));
    let mut outcomes = Vec::new();
    let kinds = [
        ("adaptive", Insertion::Adaptive, 0.0),
        ("intrinsic", Insertion::Intrinsic, 0.0),
        ("adaptive, friction 0.4", Insertion::Adaptive, 0.4),
    ];
    for (name, insertion, friction) in &kinds[..size.choose(2, 3)] {
        let shaken = shake(*insertion, *friction, cells, steps)?;
        let name = format!(
            "energy error after {} joints broke, {} transitions, {name}",
            shaken.broken, shaken.transitions
        );
        outcomes.push(Outcome::absolute(name, 0.0, shaken.error, 1e-4, ""));
        if shaken.broken < 40 {
            return Err(format!("only {} joints broke", shaken.broken));
        }
    }
    Ok(outcomes)
}

struct Shaken {
    /// Worst error of the energy balance over the most energy that was in the system.
    error: f64,
    broken: usize,
    transitions: usize,
}

/// A hollow cube with walls of one cell.
fn hollow(inner: f64, cells: usize) -> Body {
    let cell = inner / cells as f64;
    let all = cuboid([-0.5 * inner - cell; 3], [0.5 * inner + cell; 3], [cells + 2; 3]);
    let is_wall = |element: &usize| centroid(&all, *element).iter().any(|x| x.abs() > 0.5 * inner);
    let walls = (0..all.elements.len()).filter(is_wall).map(|element| all.elements[element]);
    let mut number = vec![u32::MAX; all.nodes.len()];
    let mut nodes: Vec<Point> = Vec::new();
    let renumbered = walls.map(|corners| {
        corners.map(|node| {
            let known = &mut number[node as usize];
            if *known == u32::MAX {
                *known = nodes.len() as u32;
                nodes.push(all.nodes[node as usize]);
            }
            *known
        })
    });
    let elements = renumbered.collect();
    one_body(nodes, elements)
}

fn shake(insertion: Insertion, friction: f64, cells: usize, steps: u64) -> Result<Shaken, String> {
    let half = 0.5 * CELL * cells as f64;
    let block = cuboid([-half; 3], [half; 3], [cells; 3]);
    let block = jittered(&block, 0.2 * CELL, 1, on_box([-half; 3], [half; 3]));
    let block = turned(&block, &Turn::about([1.0, 2.0, 3.0], 0.5), [0.0; 3]);
    // Room for the turned block.
    let inner = 3.2 * half;
    let walls = hollow(inner, cells + 1);
    let count = walls.nodes.len();
    let held = (0..count as u32).collect();
    let spin = [0.3, 0.9, 0.2].map(|x| x * SPEED / inner);
    let own = |place: &Point| plus([0.6, -0.5, 0.7].map(|x| x * SPEED), cross(spin, *place));
    let velocities = [vec![[0.0; 3]; count], block.nodes.iter().map(own).collect()].concat();
    let mut mesh = together(&[walls, block]);
    mesh.materials.clone_from(&mesh.bodies);
    // In the frame of the box its shaking is a weight that changes its sign.
    let period = 2.0 * inner / SPEED;
    let row = |k: u32| {
        let time = period * f64::from(k) / 16.0;
        [time, (std::f64::consts::TAU * time / period).sin()]
    };
    let strength = Strength { tensile: 1e6, cohesion: 2e6, energy_i: 0.3, energy_ii: 1.0, ..rock() };
    let wall = Material { youngs_modulus: 3e9, friction, ..granite() };
    let model = Model {
        materials: vec![wall.clone(), Material { poissons_ratio: 0.2, strength: Some(strength), ..wall }],
        boundaries: vec![moved("box", held, [Some(0.0); 3], Schedule::Constant)],
        gravity: [0.5, 0.4, 0.77].map(|x| x * SHAKING),
        gravity_schedule: Schedule::Table((0..4000).map(row).collect()),
        velocities,
        mesh,
        fracture: FractureOptions { insertion, joint_penalty: 20.0, ..FractureOptions::default() },
        time: TimeOptions { safety: 0.2, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    let (mut shaken, mut touching) = (Shaken { error: 0.0, broken: 0, transitions: 0 }, 0);
    let (mut most, mut error) = (0.0_f64, 0.0);
    for step in 0..steps {
        advance(&mut run, 1)?;
        let counts = run.counts();
        shaken.transitions += counts.contacts.abs_diff(touching) + (counts.broken - shaken.broken);
        (touching, shaken.broken) = (counts.contacts, counts.broken);
        if step % 20 == 0 {
            let energies = run.energies();
            most = most.max(energies.kinetic + energies.strain + energies.contact);
            error = worse(energies.balance(), error);
        }
    }
    shaken.error = error / most;
    Ok(shaken)
}
