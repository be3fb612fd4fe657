//! Rigid as the limit of stiff: a heap of blocks that are rigid, and one of blocks a hundred times as stiff
//! as their contacts, with the same contacts.
//!
//! Heaps whose blocks change their places are no measure: small changes of the beginning, too, move their
//! centre of mass by some percent.

use fdem_simulation::{ContactOptions, Material, Model, Schedule};

use super::models::{advance_to, granite, moved, one_body, rectangle, start, together, turned};
use super::{Outcome, Size};

/// m/s².
const GRAVITY: f64 = 9.81;

/// Side of a block, m.
const SIDE: f64 = 0.1;

/// Number of blocks, and of those in the lowest row.
const COUNT: usize = 50;
const LOWEST: usize = 10;

/// Distance of neighbours at the beginning, over the side.
const APART: f64 = 1.1;

/// Penalty of the contacts, Pa.
const PENALTY: f64 = 2e7;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let (heaps, time) = size.choose((1, 1.0), (6, 2.0));
    let mut outcomes = Vec::new();
    for number in 0..heaps {
        let [before, rigid] = heap(true, number, time)?;
        let [_, stiff] = heap(false, number, time)?;
        let of = if heaps == 1 { String::new() } else { format!(", heap {}", number + 1) };
        // They fall by the gaps between the rows.
        let fallen = (before[1] - rigid[1]) / SIDE;
        if fallen < 0.2 {
            return Err(format!("the heap falls by {fallen} of a side"));
        }
        outcomes.push(Outcome::relative(
            format!("height of the centre of mass, rigid over stiff{of}"),
            1.0,
            rigid[1] / stiff[1],
            1e-3,
            "",
        ));
        let aside = (rigid[0] - stiff[0]) / (SIDE * LOWEST as f64);
        outcomes.push(Outcome::absolute(
            format!("way of it aside, over the width{of}"),
            0.0,
            aside,
            0.01,
            "",
        ));
    }
    Ok(outcomes)
}

/// Centres of mass of a heap on a plane before it falls and at a time, s. `number`: of its tilts.
fn heap(is_rigid: bool, number: u32, time: f64) -> Result<[[f64; 2]; 2], String> {
    let plane = rectangle([-1.5, -0.1], [1.5, 0.0], [15, 1]);
    let first = plane.nodes.len() as u32;
    let mut parts = vec![plane];
    let square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|corner| corner.map(|x| SIDE * x));
    let square = one_body(square.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    // Each row has one block less than that below it.
    let places = (0..LOWEST).flat_map(|row| (0..LOWEST - row).map(move |k| [k, row]));
    for (block, [k, row]) in places.take(COUNT).enumerate() {
        let across = k as f64 - 0.5 * (LOWEST - row - 1) as f64;
        let place = [APART * SIDE * across, SIDE * (0.65 + APART * row as f64)];
        let tilt = 0.05 * (2.4 * block as f64 + 1.7 * f64::from(number)).sin();
        parts.push(turned(&square, tilt, place));
    }
    let modulus = if is_rigid { PENALTY } else { 100.0 * PENALTY };
    let count = parts.len() as u32;
    let mut run = start(Model {
        mesh: together(&parts),
        materials: vec![Material { youngs_modulus: modulus, friction: 0.6, damping: 0.3, ..granite() }],
        contact: ContactOptions { penalty: PENALTY / modulus, damping: 0.3, ..ContactOptions::default() },
        gravity: [0.0, -GRAVITY],
        rigid: if is_rigid { (0..count).collect() } else { Vec::new() },
        boundaries: vec![moved("plane", (0..first).collect(), [Some(0.0); 2], Schedule::Constant)],
        ..Model::default()
    })?;
    // The blocks are equal: the mean of their corners is the centre of mass.
    let centre = |run: &fdem_simulation::Simulation| {
        let mesh = &run.model().mesh;
        let corners = first..mesh.nodes.len() as u32;
        let count = f64::from(mesh.nodes.len() as u32 - first);
        let mut sum = [0.0; 2];
        for node in corners {
            let ([u, v], _) = run.node(node).unwrap_or(([f64::NAN; 2], [f64::NAN; 2]));
            let [x, y] = mesh.nodes[node as usize];
            sum = [sum[0] + x + u, sum[1] + y + v];
        }
        sum.map(|x| x / count)
    };
    let before = centre(&run);
    advance_to(&mut run, time)?;
    Ok([before, centre(&run)])
}
