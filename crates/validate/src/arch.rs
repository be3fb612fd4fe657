//! Couplet's arch: a semicircle of voussoirs without mortar that stands under its weight if it is thick
//! enough.
//!
//! With friction that keeps the voussoirs from sliding, the arch of the mean radius R falls by hinges at the
//! springings, at about 55° from the crown and at the crown once its thickness is below 0.1075 R.

use std::f64::consts::PI;

use fdem_simulation::{ContactOptions, Material, Mesh, Model, Schedule, Simulation};

use super::models::{DENSITY, advance_to, granite, moved, one_body, rectangle, start, together};
use super::{Outcome, Size};

/// Mean radius, m.
const RADIUS: f64 = 1.0;

/// Least thickness over the mean radius.
const LEAST: f64 = 0.1075;

/// m/s².
const GRAVITY: f64 = 9.81;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let shares: &[(f64, bool)] = size.choose(
        &[(0.95, false), (1.05, true)],
        &[(0.95, false), (0.975, false), (1.025, true), (1.05, true)],
    );
    let mut outcomes = Vec::new();
    for &(share, stands) in shares {
        let mut times = [None; 2];
        for (time, (is_rigid, kind)) in times.iter_mut().zip([(false, ""), (true, ", rigid")]) {
            *time = falls_at(share * LEAST, is_rigid, size.choose(2.0, 3.0))?;
            let found = f64::from(u8::from(time.is_none()));
            let name = format!("arch of {share} times the least thickness{kind}: 1 if it stands");
            outcomes.push(Outcome::absolute(name, f64::from(u8::from(stands)), found, 0.0, ""));
        }
        if let [Some(deforms), Some(rigid)] = times {
            let name = format!("time of the fall of {share} times, rigid over deforming");
            outcomes.push(Outcome::relative(name, 1.0, rigid / deforms, 0.02, ""));
        }
    }
    Ok(outcomes)
}

/// When an arch of this thickness, m, has fallen under its weight, s: its crown has sunk by a tenth of the
/// radius. `None` if it stands until the time `end`, s. `is_rigid`: whether all of its parts are.
fn falls_at(thickness: f64, is_rigid: bool, end: f64) -> Result<Option<f64>, String> {
    let count = 32;
    let bases = [-1.0, 1.0].map(|side: f64| {
        let middle = side * RADIUS;
        rectangle([middle - thickness, -0.1], [middle + thickness, 0.0], [2, 1])
    });
    let held: Vec<u32> = (0..bases.iter().map(|base| base.nodes.len() as u32).sum()).collect();
    let mut parts = bases.to_vec();
    parts.extend(
        (0..count).map(|k| voussoir(thickness, [k, k + 1].map(|k| PI * f64::from(k) / f64::from(count)))),
    );
    let rigid = if is_rigid { (0..parts.len() as u32).collect() } else { Vec::new() };
    let mesh = together(&parts);
    let crown = (0..mesh.nodes.len()).max_by(|&a, &b| mesh.nodes[a][1].total_cmp(&mesh.nodes[b][1]));
    let crown = crown.unwrap_or_default() as u32;
    let model = Model {
        mesh,
        materials: vec![Material {
            density: DENSITY,
            youngs_modulus: 1e9,
            friction: 1.0,
            damping: 0.3,
            ..granite()
        }],
        contact: ContactOptions { damping: 0.3, ..ContactOptions::default() },
        gravity: [0.0, -GRAVITY],
        gravity_schedule: Schedule::Ramp(0.2),
        rigid,
        boundaries: vec![moved("bases", held, [Some(0.0); 2], Schedule::Constant)],
        ..Model::default()
    };
    let mut run = start(model)?;
    let sinks = |run: &Simulation| run.node(crown).map_or(f64::NAN, |([_, y], _)| -y / RADIUS);
    while run.time() < end {
        let next = run.time() + 1e-3;
        advance_to(&mut run, next)?;
        if sinks(&run) > 0.1 {
            return Ok(Some(run.time()));
        }
    }
    // An arch that neither stands nor has fallen is reported: a falling one has moved by far more.
    if sinks(&run) < 0.01 {
        Ok(None)
    } else {
        Err(format!("an arch {thickness} m thick neither stands nor falls"))
    }
}

/// A voussoir between two angles, from the right: two elements.
fn voussoir(thickness: f64, [from, to]: [f64; 2]) -> Mesh {
    let corner = |outwards: f64, angle: f64| {
        let radius = RADIUS + outwards * 0.5 * thickness;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let nodes = vec![corner(-1.0, from), corner(1.0, from), corner(1.0, to), corner(-1.0, to)];
    one_body(nodes, vec![[0, 1, 2], [0, 2, 3]])
}
