//! Corners of a shape that are so near each other that they can only differ by rounding. Elements there would be as small, and without number.

/// Least distance of two corners over the width of their shape.
const NEAREST: f64 = 1e-9;

/// What is wrong, in messages.
pub(crate) const TOO_NEAR: &str = "nearer to each other than a billionth of the shape";

/// What helps, in messages.
pub(crate) const MERGE: &str = "they differ by rounding: make them one";

/// The first of these edges of a shape that is too short. `bounds`: least and largest coordinates of the shape.
pub(crate) fn find<const D: usize>(
    mut edges: impl Iterator<Item = [[f64; D]; 2]>,
    [low, high]: [[f64; D]; 2],
) -> Option<[[f64; D]; 2]> {
    let width = (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let is_long = |[a, b]: &[[f64; D]; 2]| (0..D).any(|axis| (a[axis] - b[axis]).abs() >= NEAREST * width);
    edges.find(|edge| !is_long(edge))
}
