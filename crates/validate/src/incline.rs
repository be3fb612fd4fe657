//! A block that rests or slides on an inclined plane.

use fdem_simulation::{Boundary, ContactOptions, Load, Material, Model, Schedule, Simulation, Target};

use super::models::{
    DENSITY, advance, advance_to, granite, mean_velocity, moved, nodes_where, rectangle, start, together,
};
use super::{Outcome, Size};

/// Coefficient of friction; its angle is 21.8°.
const FRICTION: f64 = 0.4;

/// Acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;

/// Length and height of the block, m.
const LENGTH: f64 = 0.2;
const HEIGHT: f64 = 0.1;

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let rests: &[f64] = size.choose(&[15.0, 20.0], &[10.0, 20.0, 21.0]);
    for &degrees in rests {
        let mut block = FlatBlock::on(degrees, size)?;
        advance_to(&mut block.run, 0.2)?;
        let from = block.place();
        advance_to(&mut block.run, 0.5)?;
        let crept = (block.place() - from) / LENGTH;
        let name = format!("creep in 0.3 s at {degrees}°, over the length");
        outcomes.push(Outcome::absolute(name, 0.0, crept, 1e-5, ""));
    }
    let slides: &[f64] = size.choose(&[25.0, 30.0], &[25.0, 30.0, 45.0]);
    for &degrees in slides {
        let mut block = FlatBlock::on(degrees, size)?;
        let found = block.acceleration()?;
        let (sin, cos) = degrees.to_radians().sin_cos();
        let expected = GRAVITY * (sin - FRICTION * cos);
        outcomes.push(Outcome::relative(
            format!("acceleration at {degrees}°"),
            expected,
            found,
            0.01,
            "m/s²",
        ));
    }
    Ok(outcomes)
}

struct FlatBlock {
    run: Simulation,
    /// Nodes of the block.
    nodes: Vec<u32>,
}

impl FlatBlock {
    /// A block on a plane that is inclined by the given number of degrees: the plane is level and the weight
    /// is turned. The weight grows with a ramp, so that the block does not hop.
    fn on(degrees: f64, size: Size) -> Result<Self, String> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let fine = size.choose(1, 2);
        let base = rectangle([-0.2, -0.1], [1.2, 0.0], [28 * fine, 2 * fine]);
        let block = rectangle([0.0, 0.0], [LENGTH, HEIGHT], [5 * fine, 3 * fine]);
        let held = nodes_where(&base, |[_, y]| y < -0.099);
        let first = base.nodes.len();
        let mesh = together(&[base, block]);
        let nodes: Vec<u32> = (first as u32..mesh.nodes.len() as u32).collect();
        let weight = DENSITY * LENGTH * HEIGHT * GRAVITY;
        let model = Model {
            mesh,
            materials: vec![Material { youngs_modulus: 1e8, friction: FRICTION, damping: 0.5, ..granite() }],
            // Stiff friction, so that the contacts of a slow block that hops slip immediately.
            contact: ContactOptions { tangential_stiffness: 2.0, ..ContactOptions::default() },
            boundaries: vec![
                moved("ground", held, [Some(0.0); 2], Schedule::Constant),
                Boundary {
                    name: "weight".to_owned(),
                    target: Target::Nodes(nodes.clone()),
                    load: Load::Force([weight * sin, -weight * cos]),
                    schedule: Schedule::Ramp(0.05),
                },
            ],
            ..Model::default()
        };
        Ok(Self { run: start(model)?, nodes })
    }

    /// Velocity of the block along the plane, m/s.
    fn speed(&self) -> f64 {
        mean_velocity(&self.run, &self.nodes)[0]
    }

    /// Acceleration of the block, m/s²: the slope of a line through many velocities, after the block has
    /// settled and before it reaches the end of the plane. Elastic bodies hop a little as they slide, so that
    /// the difference of two velocities would scatter.
    fn acceleration(&mut self) -> Result<f64, String> {
        advance_to(&mut self.run, 0.1)?;
        let mut points = Vec::new();
        while self.run.time() < 0.5 {
            advance(&mut self.run, 5)?;
            points.push([self.run.time(), self.speed()]);
        }
        let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / points.len() as f64;
        let (time, speed) = (mean(0), mean(1));
        let (mut both, mut one) = (0.0, 0.0);
        for [t, v] in &points {
            both += (t - time) * (v - speed);
            one += (t - time) * (t - time);
        }
        Ok(both / one)
    }

    /// Displacement of the block along the plane, m.
    fn place(&self) -> f64 {
        let moved = self.nodes.iter().filter_map(|&node| self.run.node(node)).map(|([x, _], _)| x);
        moved.sum::<f64>() / self.nodes.len() as f64
    }
}
