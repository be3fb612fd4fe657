//! The common part of two edges.

use crate::vector::{Point, dot, length, minus};

/// Two Gauss points on the common part of two edges that run in opposite directions on one line.
pub(super) fn common(
    one: &[Point; 2],
    other: &[Point; 2],
    touch: f64,
    least: f64,
) -> Vec<([[f64; 2]; 2], f64)> {
    let along = minus(one[1], one[0]);
    let own = length(along);
    let tangent = along.map(|x| x / own);
    let normal = [tangent[1], -tangent[0]];
    let from = other.map(|end| minus(end, one[0]));
    let [start, end] = from.map(|from| dot(from, tangent));
    let off = from.map(|from| dot(from, normal).abs()).into_iter().fold(0.0, f64::max);
    let common = [end.max(0.0), start.min(own)];
    if off > touch || start <= end || common[1] - common[0] <= least {
        return Vec::new();
    }
    let long = common[1] - common[0];
    let at = [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()];
    at.map(|at| {
        let along = common[0] + at * long;
        let shares = [along / own, (start - along) / (start - end)];
        (shares.map(|share| [1.0 - share, share]), 0.5 * long)
    })
    .to_vec()
}
