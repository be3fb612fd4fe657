//! A rigid block that lands and slides on a rigid wall of two faces, and on one of many in the same plane.
//!
//! The potential of an element vanishes on all of its boundary, so that it is less where elements of the wall
//! meet, by a share that goes with the depth of the contact over the size of the elements. The motions on the
//! two walls differ by as much. Contact damping, and friction before it slips, count couples of elements,
//! and differ in any depth.

use fdem_simulation::{ContactOptions, Material, Model, Schedule, TimeOptions};

use super::bodies::{Point, Run, advance_to, cuboid, length, mean_motion, minus, start};
use crate::models::{DENSITY, granite, moved, nodes_where, together};
use crate::{Outcome, Size};

/// m/s².
const GRAVITY: f64 = 9.81;

/// Side of the block, m.
const SIDE: f64 = 0.1;

/// A block and its wall.
#[derive(Clone, Copy)]
struct Slide {
    /// Young's modulus, Pa.
    modulus: f64,
    friction: f64,
    /// Share of critical damping of the contacts.
    damping: f64,
    /// Velocity towards the wall at the beginning, m/s; 0 for a block that begins at rest in its depth.
    landing: f64,
    /// Time step over √(m/k), with the stiffness k of the contact.
    step: f64,
}

/// The difference of two motions, and the greatest depth, m.
struct Difference {
    /// Over the way along the wall.
    apart: f64,
    deepest: f64,
}

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let slides = Slide { modulus: 1e10, friction: 0.0, damping: 0.0, landing: 0.0, step: 0.3 };
    let lands = Slide { modulus: 1e7, landing: 0.05, step: 0.05, ..slides };
    for cells in size.choose(&[[7, 5, 1]][..], &[[2, 2, 1], [7, 5, 1], [15, 11, 1]][..]) {
        let faces = 2 * cells[0] * cells[1];
        let found = slides.compare(*cells)?.apart;
        let name = format!("slides without friction, {faces} faces: distance over the way");
        outcomes.push(Outcome::absolute(name, 0.0, found, 1e-10, ""));
        let found = Slide { friction: 0.3, ..slides }.compare(*cells)?.apart;
        let name = format!("slides with friction, {faces} faces: distance over the way");
        outcomes.push(Outcome::absolute(name, 0.0, found, 1e-9, ""));
        for modulus in [1e7, 1e9] {
            for (friction, kind) in [(0.0, "without"), (0.3, "with")] {
                let Difference { apart, deepest } = Slide { modulus, friction, ..lands }.compare(*cells)?;
                let name = format!(
                    "lands {kind} friction, {faces} faces, {:.1e} of its side deep: distance over the way",
                    deepest / SIDE
                );
                outcomes.push(Outcome::absolute(name, 0.0, apart, deepest / SIDE, ""));
            }
        }
        let found = Slide { friction: 0.3, damping: 0.3, ..lands }.compare(*cells)?.apart;
        let name = format!("lands with friction and contact damping, {faces} faces: distance over the way");
        outcomes.push(Outcome::absolute(name, 0.0, found, 0.05, ""));
    }
    Ok(outcomes)
}

impl Slide {
    /// Compares the motion on a wall of two faces with that on one of `cells`.
    fn compare(self, cells: [usize; 3]) -> Result<Difference, String> {
        let [two, many] = [self.motion([1, 1, 1])?, self.motion(cells)?];
        let (mut apart, mut way, mut deepest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (a, b) in two.iter().zip(&many) {
            apart = apart.max(length(minus(*a, *b)));
            way = way.max(length([a[0], a[1], 0.0]));
            deepest = deepest.max(-a[2]);
        }
        if !(way > 4e-3 && apart.is_finite()) {
            return Err("the block does not slide".to_owned());
        }
        Ok(Difference { apart: apart / way, deepest })
    }

    /// Displacements of a block in 10 ms from its first contact on, m, on a wall of `cells`.
    fn motion(self, cells: [usize; 3]) -> Result<Vec<Point>, String> {
        let wall = cuboid([-0.213, -0.307, -SIDE], [0.487, 0.293, 0.0], cells);
        let options = ContactOptions { damping: self.damping, ..ContactOptions::default() };
        // Flush faces of elements as high as the block: the potential grows by 4 times the penalty in each.
        let stiffness = options.penalty * self.modulus * SIDE * SIDE * 4.0 * (2.0 / SIDE);
        let mass = DENSITY * SIDE.powi(3);
        let depth = if self.landing > 0.0 { 0.0 } else { mass * GRAVITY / stiffness };
        let block = cuboid([0.0, 0.0, -depth], [SIDE, SIDE, SIDE - depth], [1, 1, 1]);
        let held = (0..wall.nodes.len() as u32).collect();
        let velocity = [0.5, 0.2, -self.landing];
        let velocities = [vec![[0.0; 3]; wall.nodes.len()], vec![velocity; block.nodes.len()]].concat();
        let model = Model {
            mesh: together(&[wall, block]),
            velocities,
            materials: vec![Material { youngs_modulus: self.modulus, friction: self.friction, ..granite() }],
            boundaries: vec![moved("wall", held, [Some(0.0); 3], Schedule::Constant)],
            gravity: [0.0, 0.0, -GRAVITY],
            rigid: vec![0, 1],
            contact: options,
            // The same for both walls: that of a simulation depends on the mesh.
            time: TimeOptions { step: Some(self.step * (mass / stiffness).sqrt()), ..TimeOptions::default() },
            ..Model::default()
        };
        let mut run: Run = start(model)?;
        let nodes = nodes_where(&run.model().mesh, |p: Point| p[2] > 0.0);
        let mut motion = Vec::new();
        for k in 1..=100 {
            advance_to(&mut run, 1e-4 * f64::from(k))?;
            let [[x, y, z], _] = mean_motion(&run, &nodes);
            motion.push([x, y, z - depth]);
        }
        Ok(motion)
    }
}
