//! A penny-shaped crack in a large block under tension, at rest.

use std::f64::consts::PI;

use fdem_simulation::{Load, Material, Model, Schedule, TimeOptions};

use super::bodies::{Body, Point, advance_to, faces_where, lattice, loaded, mapped, mean_motion, start};
use crate::models::{granite, moved, nodes_where};
use crate::{Outcome, Size};

/// Radius of the crack and half of the width of the block, m.
const RADIUS: f64 = 0.01;
const HALF: f64 = 0.035;

/// Pa.
const TENSION: f64 = 1e6;

const POISSON: f64 = 0.25;

/// The faces of a crack of radius `a` part by `w = 8 (1 - ν²) p √(a² - r²)/(π E)` (Sneddon 1946). It follows
/// from the potential of a crack under uniform pressure: a half space on whose surface the pressure `p` acts
/// within `a` while the rest does not move has there `u = 4 (1 - ν²) p √(a² - r²)/(π E)`, half of `w`; work
/// of the pressure `8 (1 - ν²) p² a³/(3 E)` over both faces, whose derivative by the area is
/// `4 (1 - ν²) p² a/(π E) = K² (1 - ν²)/E` with the known `K = 2 p √(a/π)`.
///
/// An eighth of the block. The crack's front is on nodes, which are held; the opening that a mesh loses near
/// its front makes it too small, by an amount in proportion to the size of the cells.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let (cells, bound) = size.choose((6, 0.08), (12, 0.05));
    let mesh = block(cells);
    let round = |p: Point| p[0].hypot(p[1]);
    let on = |axis: usize| nodes_where(&mesh, |p: Point| p[axis].abs() < 1e-9);
    let still = |axis: usize| std::array::from_fn(|k| (k == axis).then_some(0.0));
    let bonded = nodes_where(&mesh, |p: Point| p[2].abs() < 1e-9 && round(p) > RADIUS * (1.0 - 1e-6));
    let faces = faces_where(&mesh, |p| p[2] > HALF - 1e-9);
    let crack = nodes_where(&mesh, |p: Point| p[2].abs() < 1e-9 && round(p) < 0.75 * RADIUS);
    let material = Material { poissons_ratio: POISSON, ..granite() };
    let modulus = material.youngs_modulus / (1.0 - POISSON * POISSON);
    let places = mesh.nodes.clone();
    let model = Model {
        boundaries: vec![
            moved("x", on(0), still(0), Schedule::Constant),
            moved("y", on(1), still(1), Schedule::Constant),
            moved("bonded", bonded, still(2), Schedule::Constant),
            loaded("top", faces, Load::Traction([0.0, 0.0, TENSION]), Schedule::Ramp(2e-5)),
        ],
        mesh,
        materials: vec![material],
        time: TimeOptions { local_damping: 0.4, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance_to(&mut run, 1e-4)?;
    // A mean over the swing of the block that is left.
    let (mut centre, mut whole, mut expected) = (0.0, 0.0, 0.0);
    let samples = 40;
    for sample in 0..samples {
        advance_to(&mut run, 1e-4 + f64::from(sample + 1) * 5e-7)?;
        centre += 2.0 * mean_motion(&run, &crack[..1])[0][2] / f64::from(samples);
        whole += 2.0 * mean_motion(&run, &crack)[0][2] / f64::from(samples);
    }
    for &node in &crack {
        let squared = RADIUS * RADIUS - round(places[node as usize]).powi(2);
        expected += 8.0 * TENSION * squared.sqrt() / (PI * modulus) / crack.len() as f64;
    }
    let most = 8.0 * TENSION * RADIUS / (PI * modulus);
    Ok(vec![
        Outcome::relative("opening in the centre", most, centre, bound, "m"),
        Outcome::relative("mean opening within 0.75 of the radius", expected, whole, bound, "m"),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-4, ""),
    ])
}

/// An eighth of the block: a lattice whose squares around the crack are made round.
fn block(cells: usize) -> Body {
    let mut across: Vec<f64> = (0..=cells).map(|k| RADIUS * k as f64 / cells as f64).collect();
    let mut cell = RADIUS / cells as f64;
    while across[across.len() - 1] < HALF {
        let last = across[across.len() - 1];
        across.push(last + cell);
        cell *= 1.5;
    }
    stretched(&mut across, cells);
    let mut up = vec![0.0];
    let mut cell = RADIUS / cells as f64;
    while up[up.len() - 1] < HALF {
        let last = up[up.len() - 1];
        up.push(last + cell);
        cell *= 1.5;
    }
    stretched(&mut up, 0);
    mapped(&lattice(&[across.clone(), across, up]), |[x, y, z]| {
        let side = x.max(y);
        let round = side / x.hypot(y).max(1e-12);
        // Round up to the crack's front, square at the sides.
        let share = ((HALF - side) / (HALF - RADIUS)).min(1.0);
        let factor = 1.0 + share * (round - 1.0);
        if side == 0.0 { [0.0, 0.0, z] } else { [factor * x, factor * y, z] }
    })
}

/// Scales the places after one of them so that the last is at the side of the block.
fn stretched(places: &mut [f64], after: usize) {
    let (from, last) = (places[after], places[places.len() - 1]);
    for place in &mut places[after + 1..] {
        *place = from + (*place - from) * (HALF - from) / (last - from);
    }
}
