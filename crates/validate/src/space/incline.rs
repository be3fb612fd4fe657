//! A block that rests or slides on an inclined plane, down along either horizontal direction and aslant to
//! both.

use fdem_simulation::{ContactOptions, Material, Model, Schedule};

use super::bodies::{
    Point, Run, advance, advance_to, cuboid, jittered, length, mean_motion, minus, on_box, start,
};
use crate::models::{granite, moved, nodes_where, together};
use crate::{Outcome, Size};

/// Coefficient of friction; its angle is 21.8°.
const FRICTION: f64 = 0.4;

/// Acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;

/// Width and height of the block, m.
const WIDTH: f64 = 0.2;
const HEIGHT: f64 = 0.1;

/// Below the angle of friction the block rests. Above, it slides down the plane with `g (sin θ - µ cos θ)`,
/// straight: friction is a vector against the motion.
pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let ways: &[(&str, f64)] = &[("x", 0.0), ("y", 90.0), ("37° to x", 37.0)];
    let rests: &[f64] = size.choose(&[20.0], &[10.0, 20.0, 21.0]);
    let slides: &[f64] = size.choose(&[30.0], &[25.0, 30.0, 45.0]);
    for (way, angle) in ways {
        for &degrees in rests {
            let mut block = SpaceBlock::on(degrees, *angle, size)?;
            advance_to(&mut block.run, 0.2)?;
            let from = mean_motion(&block.run, &block.nodes)[0];
            advance_to(&mut block.run, 0.3)?;
            let crept = length(minus(mean_motion(&block.run, &block.nodes)[0], from)) / WIDTH;
            let name = format!("creep in 0.1 s at {degrees}° along {way}, over the width");
            outcomes.push(Outcome::absolute(name, 0.0, crept, 1e-5, ""));
        }
        for &degrees in slides {
            let mut block = SpaceBlock::on(degrees, *angle, size)?;
            let [along, across] = block.acceleration()?;
            let (sin, cos) = degrees.to_radians().sin_cos();
            let expected = GRAVITY * (sin - FRICTION * cos);
            let name = format!("acceleration at {degrees}° along {way}");
            outcomes.push(Outcome::relative(name, expected, along, 0.01, "m/s²"));
            let name = format!("acceleration across it, over that along it, {degrees}° along {way}");
            outcomes.push(Outcome::absolute(name, 0.0, across / along, 0.01, ""));
        }
    }
    Ok(outcomes)
}

struct SpaceBlock {
    run: Run,
    /// Nodes of the block.
    nodes: Vec<u32>,
    /// Direction down the plane.
    down: [f64; 2],
}

impl SpaceBlock {
    /// A block on a plane that is inclined by the given number of degrees towards a direction: the plane is
    /// level and the weight is turned. The weight grows with a ramp, so that the block does not hop.
    fn on(degrees: f64, towards: f64, size: Size) -> Result<Self, String> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let down = [towards.to_radians().cos(), towards.to_radians().sin()];
        let fine = size.choose(1, 2);
        let far = 0.75;
        // Along the path, with room for the block.
        let end = down.map(|share| far * share + WIDTH + 0.1);
        let (low, high) = ([-0.1, -0.1, -0.06], [end[0], end[1], 0.0]);
        let cells = [0, 1].map(|axis| fine * ((high[axis] - low[axis]) / 0.1).ceil() as usize);
        let base =
            jittered(&cuboid(low, high, [cells[0], cells[1], 1]), 0.02 / fine as f64, 1, on_box(low, high));
        let top = [WIDTH, WIDTH, HEIGHT];
        let block = cuboid([0.0; 3], top, [2 * fine, 2 * fine, fine]);
        let block = jittered(&block, 0.02 / fine as f64, 2, on_box([0.0; 3], top));
        let held = nodes_where(&base, |p: Point| p[2] < -0.059);
        let first = base.nodes.len();
        let mesh = together(&[base, block]);
        let nodes: Vec<u32> = (first as u32..mesh.nodes.len() as u32).collect();
        let material = Material { youngs_modulus: 3e6, friction: FRICTION, damping: 0.5, ..granite() };
        let model = Model {
            mesh,
            materials: vec![material],
            // Stiff friction, so that the contacts of a slow block that hops slip immediately.
            contact: ContactOptions { tangential_stiffness: 2.0, ..ContactOptions::default() },
            boundaries: vec![moved("ground", held, [Some(0.0); 3], Schedule::Constant)],
            gravity: [sin * down[0], sin * down[1], -cos].map(|share| GRAVITY * share),
            gravity_schedule: Schedule::Ramp(0.05),
            ..Model::default()
        };
        Ok(Self { run: start(model)?, nodes, down })
    }

    /// Acceleration of the block down the plane and across that direction, m/s²: the slopes of lines through
    /// many velocities, after the block has settled and before it reaches the end of the plane.
    fn acceleration(&mut self) -> Result<[f64; 2], String> {
        advance_to(&mut self.run, 0.1)?;
        let mut points = Vec::new();
        while self.run.time() < 0.35 {
            advance(&mut self.run, 5)?;
            let [x, y, _] = mean_motion(&self.run, &self.nodes)[1];
            let [along, across] = self.down;
            points.push([self.run.time(), x * along + y * across, y * along - x * across]);
        }
        let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
        let slope = |k: usize| {
            let (time, speed) = (mean(0), mean(k));
            let both: f64 = points.iter().map(|point| (point[0] - time) * (point[k] - speed)).sum();
            both / points.iter().map(|point| (point[0] - time).powi(2)).sum::<f64>()
        };
        Ok([slope(1), slope(2)])
    }
}
