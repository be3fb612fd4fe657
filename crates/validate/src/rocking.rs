//! Housner's rocking block: a slender block that is released on one of its corners.
//!
//! With the half diagonal R and the angle α between it and the side, the block falls back from a tilt θ below
//! α and turns over above it. A rigid one comes back to its base after
//!
//! ```text
//! t = acosh(1/(1 − θ/α))/p,    p² = 3 g/(4 R),
//! ```
//! with sin θ taken as θ: of a slender block, an error of α²/6. A stiff block that deforms and a rigid one
//! give the same.

use fdem_simulation::{Material, Model, Schedule, Simulation};

use super::models::{advance, granite, moved, rectangle, rotated, start, together};
use super::{Outcome, Size};

/// m.
const WIDTH: f64 = 0.1;
const HEIGHT: f64 = 0.5;

/// m/s².
const GRAVITY: f64 = 9.81;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let alpha = (WIDTH / HEIGHT).atan();
    let rate = (0.75 * GRAVITY / (0.5 * WIDTH.hypot(HEIGHT))).sqrt();
    let mut outcomes = Vec::new();
    let tilts: &[f64] = size.choose(&[0.5], &[0.2, 0.5, 0.8]);
    for &share in tilts {
        let expected = (1.0 / (1.0 - share)).acosh() / rate;
        let mut times = [0.0; 2];
        for (time, (is_rigid, kind)) in times.iter_mut().zip([(false, ""), (true, ", rigid")]) {
            *time = fall(share * alpha, is_rigid, size)?.unwrap_or(f64::NAN);
            let name = format!("time to fall back from {share} α{kind}");
            outcomes.push(Outcome::relative(name, expected, *time, 0.02, "s"));
        }
        let [deforms, rigid] = times;
        let name = format!("the rigid one over the one that deforms, from {share} α");
        outcomes.push(Outcome::relative(name, 1.0, rigid / deforms, 0.02, ""));
    }
    for (share, expected) in [(0.95, 0.0), (1.05, 1.0)] {
        for (is_rigid, kind) in [(false, ""), (true, ", rigid")] {
            let turned = f64::from(u8::from(fall(share * alpha, is_rigid, size)?.is_none()));
            let name = format!("turns over from {share} α{kind}: 1 if it does");
            outcomes.push(Outcome::absolute(name, expected, turned, 0.0, ""));
        }
    }
    Ok(outcomes)
}

/// Lets the block go at a tilt. Returns when it is upright again, s, or `None` if it turns over.
fn fall(tilt: f64, is_rigid: bool, size: Size) -> Result<Option<f64>, String> {
    let fine = size.choose(1, 2);
    let base = rectangle([-0.1, -0.1], [0.3, 0.0], [4 * fine, fine]);
    let held = (0..base.nodes.len() as u32).collect();
    let mut block = rectangle([0.0, 0.0], [WIDTH, HEIGHT], [2 * fine, 10 * fine]);
    // Around its right corner, which rests on the base.
    for node in &mut block.nodes {
        let [x, y] = rotated([node[0] - WIDTH, node[1]], -tilt);
        *node = [x + WIDTH, y];
    }
    let (first, last) = (base.nodes.len() as u32, (base.nodes.len() + block.nodes.len()) as u32 - 1);
    let mesh = together(&[base, block]);
    // The ends of its right side.
    let (corner, top) = (first + 2 * fine as u32, last);
    let model = Model {
        mesh,
        materials: vec![Material { youngs_modulus: 1e9, friction: 1.0, damping: 0.1, ..granite() }],
        gravity: [0.0, -GRAVITY],
        rigid: if is_rigid { vec![0, 1] } else { Vec::new() },
        boundaries: vec![moved("base", held, [Some(0.0); 2], Schedule::Constant)],
        ..Model::default()
    };
    let mut run = start(model)?;
    let place = |run: &Simulation, node: u32| {
        let [x, y] = run.model().mesh.nodes[node as usize];
        run.node(node).map_or([f64::NAN; 2], |([u, v], _)| [x + u, y + v])
    };
    loop {
        advance(&mut run, 10)?;
        let ([x, y], [u, v]) = (place(&run, corner), place(&run, top));
        let angle = (u - x).atan2(v - y);
        if angle <= 0.0 {
            return Ok(Some(run.time()));
        }
        if angle > 0.5 {
            return Ok(None);
        }
        if run.time() > 5.0 || angle.is_nan() {
            return Err("the block neither falls back nor turns over".to_owned());
        }
    }
}
