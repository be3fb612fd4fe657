//! A block of tetrahedra that breaks in a box that is shaken.

use super::bodies::{Body, Turn, centroid, cross, cuboid, jittered, on_box, one_body, plus, turned};
use crate::debris::{CELL, SPEED, kinds, model, shaken};
use crate::{Outcome, Size};

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let cells = size.choose(2, 3);
    let half = 0.5 * CELL * cells as f64;
    let block = cuboid([-half; 3], [half; 3], [cells; 3]);
    let block = jittered(&block, 0.2 * CELL, 1, on_box([-half; 3], [half; 3]));
    let block = turned(&block, &Turn::about([1.0, 2.0, 3.0], 0.3), [0.0; 3]);
    // Room for the turned block.
    let inner = 2.8 * half;
    let spin = [0.3, 0.9, 0.2].map(|x| x * SPEED / inner);
    let velocity = |place| plus([0.6, -0.5, 0.7].map(|x| x * SPEED), cross(spin, place));
    let bodies = [hollow(inner), block];
    kinds(size, 1_000_000, 0.15)
        .iter()
        .map(|kind| shaken(kind, model(kind, &bodies, inner, velocity, [0.5, 0.4, 0.77])))
        .collect()
}

/// A hollow cube with walls of one cell.
fn hollow(inner: f64) -> Body {
    let all = cuboid([-1.5 * inner; 3], [1.5 * inner; 3], [3; 3]);
    let is_wall = |element: &usize| centroid(&all, *element).iter().any(|x| x.abs() > 0.5 * inner);
    let walls = (0..all.elements.len()).filter(is_wall).map(|element| all.elements[element]);
    one_body(all.nodes.clone(), walls.collect())
}
