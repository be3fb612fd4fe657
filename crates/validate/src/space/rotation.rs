//! Rotation in space: it causes no strain, and a free body that tumbles keeps its energy and its momenta.

use std::f64::consts::TAU;

use fdem_simulation::{Boundary, Load, Material, Model, Schedule, Target, TimeOptions};

use super::bodies::{
    Point, Run, Turn, advance, change, cross, cuboid, jittered, length, mean_motion, minus, momentum, on_box,
    plus, start, volume_of,
};
use crate::models::{granite, nodes_where, worse};
use crate::{Outcome, Size};

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    for axis in [[0.0, 0.0, 1.0], [2.0, -1.0, 2.0], [0.3, 0.5, -0.7]] {
        let name = format!("largest strain in a turn about {axis:?}");
        outcomes.push(Outcome::absolute(name, 0.0, led(axis)?, 1e-12, ""));
    }
    outcomes.extend(tumbles(size)?);
    Ok(outcomes)
}

fn rock() -> Material {
    Material { poissons_ratio: 0.25, ..granite() }
}

/// Leads all nodes of a block through a full turn about an axis, by a degree in each step. Returns the
/// largest stress over Young's modulus.
fn led(axis: Point) -> Result<f64, String> {
    let (min, max) = ([0.2, -0.1, 0.3], [0.8, 0.2, 0.5]);
    let mesh = jittered(&cuboid(min, max, [3, 2, 2]), 0.02, 1, on_box(min, max));
    let (steps, step) = (360, 1e-3);
    let mut boundaries = Vec::new();
    for (node, &origin) in mesh.nodes.iter().enumerate() {
        for along in 0..3 {
            let row = |k: usize| {
                let turn = Turn::about(axis, TAU * k as f64 / f64::from(steps));
                [step * k as f64, turn.of(origin)[along] - origin[along]]
            };
            boundaries.push(Boundary {
                name: format!("node {node} along {along}"),
                target: Target::Nodes(vec![node as u32]),
                load: Load::Displacement(std::array::from_fn(|other| (other == along).then_some(1.0))),
                schedule: Schedule::Table((0..=steps as usize).map(row).collect()),
            });
        }
    }
    let time = TimeOptions { step: Some(step), ..TimeOptions::default() };
    let mut run = start(Model { mesh, materials: vec![rock()], boundaries, time, ..Model::default() })?;
    let mut largest = 0.0;
    // One more step, because stresses are those at the beginning of a step.
    for _ in 0..=steps {
        advance(&mut run, 1)?;
        let stresses = run.snapshot().stresses;
        largest = stresses.iter().flatten().fold(largest, |largest, &stress| worse(stress, largest));
    }
    Ok(largest.abs() / rock().youngs_modulus)
}

/// A free block with three unlike moments of inertia spins about the middle one, nearly: that axis turns over
/// repeatedly, while energy and both momenta stay constant.
///
/// Landau and Lifshitz, Mechanics (1976), 37: with the energies `2 E` and momenta `M²` of the beginning, the
/// spin about the middle axis swings between two values of opposite signs and the same size. The time step is
/// short against the spin: kinetic energy is computed from velocities half a step before and after, and for a
/// body that turns it differs from that of the motion by a share of `(ω h)²`.
fn tumbles(size: Size) -> Result<Vec<Outcome>, String> {
    let turns = size.choose(3, 12);
    let (min, max) = ([-0.05, -0.1, -0.15], [0.05, 0.1, 0.15]);
    let mesh = cuboid(min, max, [1, 1, 1]);
    // About y the moment is the middle one. The spin is so slow that inertia hardly strains the block.
    let spin = [0.0, 0.3, 0.03];
    let velocities = mesh.nodes.iter().map(|&node| cross(spin, node)).collect();
    // A soft material has a long time step.
    let soft = Material { youngs_modulus: 50e6, ..rock() };
    let mut run = start(Model { mesh, velocities, materials: vec![soft], ..Model::default() })?;
    advance(&mut run, 1)?;
    let (before, kinetic) = (momentum(&run), run.energies().kinetic);
    let steps = (TAU / spin[1] * f64::from(turns) / run.time_step()) as u64;
    let (mut drift, mut least) = (0.0, 1.0_f64);
    let parts = 200;
    for _ in 0..parts {
        advance(&mut run, steps / parts)?;
        drift = worse(run.energies().balance() / kinetic, drift);
        let axis = axis_of(&run, 0.1);
        least = least.min(axis[1]);
    }
    let after = momentum(&run);
    let scale = (2.0 * kinetic * volume_of(&run.model().mesh) * rock().density).sqrt();
    Ok(vec![
        Outcome::absolute("drift of the energy of a block that tumbles", 0.0, drift, 1e-9, ""),
        Outcome::absolute("change of its momenta", 0.0, change(&before, &after, scale, 0.1), 1e-11, ""),
        Outcome::absolute(
            "cosine of the angle through which its middle axis turns over",
            -1.0,
            least,
            0.02,
            "",
        ),
    ])
}

/// The direction now of the y axis of a block whose sides were at `half` and its opposite along it, m: from
/// the nodes of one side to those of the other.
pub(super) fn axis_of(run: &Run, half: f64) -> Point {
    let mesh = &run.model().mesh;
    let [low, high] = [-half, half].map(|at| {
        let nodes = nodes_where(mesh, |p: Point| (p[1] - at).abs() < 1e-9);
        plus([0.0, at, 0.0], mean_motion(run, &nodes)[0])
    });
    let along = minus(high, low);
    let long = length(along);
    along.map(|x| x / long)
}
