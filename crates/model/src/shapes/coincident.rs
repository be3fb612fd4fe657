//! Corners of a shape that are so near each other that they can only differ by rounding. Elements between
//! them would be as small, and too many for any memory.

use crate::text::fault::Problem;

/// Least distance of two corners over the width of their shape.
const NEAREST: f64 = 1e-9;

/// The problem of a shape with these nodes that has an edge which is too short. `what`: the shape's corners,
/// as messages name them.
pub(crate) fn problem<const D: usize>(
    key: &str,
    what: &str,
    nodes: &[[f64; D]],
    mut edges: impl Iterator<Item = [usize; 2]>,
) -> Option<Problem> {
    let [low, high] = fdem_mesh::bounds(nodes.iter().copied());
    let width = (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let is_long =
        |[a, b]: [usize; 2]| (0..D).any(|axis| (nodes[a][axis] - nodes[b][axis]).abs() >= NEAREST * width);
    let [a, b] = edges.find(|edge| !is_long(*edge))?.map(|node| nodes[node]);
    Some(Problem {
        help: Some("they differ by rounding: make them one".to_owned()),
        ..Problem::new(
            key,
            format!("{what} {a:?} and {b:?} are nearer to each other than a billionth of the shape"),
        )
    })
}
