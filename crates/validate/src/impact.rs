//! Bodies that collide: energy and momentum are the same before and after.

use std::f64::consts::{PI, TAU};

use fdem_simulation::{ContactOptions, Energies, Material, Mesh, Model, TimeOptions};

use super::models::{advance, disc, granite, momentum, one_body, rotated, start, together, turned, worse};
use super::{Outcome, Size};

/// Share of the critical time step. An impact of two triangles lasts a few critical steps only.
const SAFETY: f64 = 0.05;

/// Penalty of a contact that is much softer than the bodies, which therefore hardly vibrate.
const SOFT: f64 = 1e-4;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let orientations = size.choose(4, 24);
    let usual = ContactOptions::default().penalty;
    let mut outcomes = Vec::new();
    let mut change = 0.0;
    for blow in triangles() {
        let [mut total, mut kinetic] = [0.0; 2];
        for k in 0..orientations {
            let turn = TAU * (f64::from(k) + 0.05) / f64::from(orientations);
            let hard = collide(&blow, turn, usual)?;
            let soft = collide(&blow, turn, SOFT)?;
            total = worse(hard.energy(), total);
            kinetic = worse(soft.kinetic(), kinetic);
            change = [hard.momentum, soft.momentum].into_iter().fold(change, |change, m| worse(m, change));
        }
        let name = |what: &str| format!("{}: {what}, worst of {orientations}", blow.name);
        outcomes.push(Outcome::relative(name("energy after over before"), 1.0, 1.0 + total, 1e-3, ""));
        outcomes.push(Outcome::relative(name("kinetic energy, soft contact"), 1.0, 1.0 + kinetic, 1e-3, ""));
    }
    for blow in discs(size.choose(5, 10)) {
        let met = collide(&blow, 0.4, usual)?;
        change = worse(met.momentum, change);
        let name = format!("{}: energy after over before", blow.name);
        outcomes.push(Outcome::relative(name, 1.0, 1.0 + met.energy(), 1e-3, ""));
    }
    outcomes.push(Outcome::absolute("largest change of a momentum", 0.0, change, 1e-11, ""));
    Ok(outcomes)
}

/// A body at rest, and another with its velocity and its spin about the centroid of its nodes.
struct Blow {
    name: &'static str,
    bodies: [Mesh; 2],
    velocity: [f64; 2],
    spin: f64,
}

fn triangles() -> Vec<Blow> {
    let triangle = |at: [[f64; 2]; 3]| one_body(at.to_vec(), vec![[0, 1, 2]]);
    let target = triangle([[0.0, 0.0], [1.0, 0.0], [0.5, 0.8]]);
    let vertex_first = triangle([[0.0, 0.0], [0.5, 0.8], [-0.5, 0.8]]);
    let edge_first = triangle([[-0.5, 0.0], [0.5, 0.0], [0.1, 0.8]]);
    let edge_up = turned(&target, PI, [1.0, 0.0]);
    let down = [0.0, -1.0];
    let blow = |name, first: &Mesh, second, velocity| Blow {
        name,
        bodies: [first.clone(), second],
        velocity,
        spin: 0.0,
    };
    vec![
        blow("vertex on edge", &edge_up, turned(&vertex_first, 0.0, [0.45, 0.02]), down),
        blow("edge on edge", &edge_up, turned(&edge_first, 0.0, [0.5, 0.02]), down),
        blow("vertex on vertex", &target, turned(&vertex_first, 0.0, [0.52, 0.83]), down),
        blow("edge on vertex", &target, turned(&edge_first, 0.1, [0.5, 0.9]), down),
        blow("obliquely", &target, turned(&edge_first, 0.7, [1.0, 1.3]), [-0.4, -1.0]),
    ]
}

fn discs(rings: usize) -> [Blow; 2] {
    let body = disc(0.5, rings);
    let blow = |name, shift, spin| Blow {
        name,
        bodies: [body.clone(), turned(&body, 0.3, shift)],
        velocity: [0.0, -5.0],
        spin,
    };
    [blow("two discs, head-on", [0.0, 1.001], 0.0), blow("two discs, off centre, spinning", [0.3, 1.0], 20.0)]
}

/// Energies before and after a collision.
pub(crate) struct Met {
    pub(crate) before: Energies,
    pub(crate) after: Energies,
    /// Change of the momenta over the momentum before.
    pub(crate) momentum: f64,
}

impl Met {
    /// Relative change of the kinetic and elastic energy.
    pub(crate) fn energy(&self) -> f64 {
        (self.after.kinetic + self.after.strain + self.after.contact) / self.before.kinetic - 1.0
    }

    pub(crate) fn kinetic(&self) -> f64 {
        self.after.kinetic / self.before.kinetic - 1.0
    }
}

/// Runs two bodies, turned together, until they have met and parted.
fn collide(blow: &Blow, turn: f64, penalty: f64) -> Result<Met, String> {
    let [first, second] = blow.bodies.each_ref().map(|body| turned(body, turn, [0.0; 2]));
    let centre: [f64; 2] = std::array::from_fn(|axis| {
        second.nodes.iter().map(|node| node[axis]).sum::<f64>() / second.nodes.len() as f64
    });
    let [u, v] = rotated(blow.velocity, turn);
    let moving =
        second.nodes.iter().map(|[x, y]| [u - blow.spin * (y - centre[1]), v + blow.spin * (x - centre[0])]);
    let model = Model {
        velocities: vec![[0.0; 2]; first.nodes.len()].into_iter().chain(moving).collect(),
        mesh: together(&[first, second]),
        materials: vec![Material { poissons_ratio: 0.2, ..granite() }],
        contact: ContactOptions { penalty, ..ContactOptions::default() },
        time: TimeOptions { safety: SAFETY, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = start(model)?;
    advance(&mut run, 1)?;
    let (before, momenta) = (run.energies(), momentum(&run));
    if run.counts().contacts > 0 {
        return Err(format!("{}: the bodies touch at the beginning", blow.name));
    }
    let (mut met, mut apart) = (false, 0);
    while apart < 400 {
        advance(&mut run, 1)?;
        let touches = run.counts().contacts > 0;
        met |= touches;
        apart = if met && !touches { apart + 1 } else { 0 };
        if run.penetrated().is_some() {
            return Err(format!("{}: one body is inside the other", blow.name));
        }
        if run.steps() > 1_000_000 {
            return Err(format!("{}: the bodies do not meet, or do not part", blow.name));
        }
    }
    let after = momentum(&run);
    let scale = momenta[0].hypot(momenta[1]);
    let change = (0..3).fold(0.0, |change, k| worse((after[k] - momenta[k]) / scale, change));
    Ok(Met { before, after: run.energies(), momentum: change })
}
