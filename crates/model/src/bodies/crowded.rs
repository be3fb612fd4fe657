//! Bodies that lie in each other so much that their contacts have no room.

use std::ops::Range;

use fdem_io::numbers::grouped;

use crate::text::fault::Fault;

/// Allowed couples of elements of overlapping bodies: a number for every model, and a number for each
/// element.
const COUPLES: [f64; 2] = [2e7, 20.0];

/// A bounding box that is full of elements.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filled<const D: usize = 2> {
    /// Least and largest coordinates.
    pub(crate) bounds: [[f64; D]; 2],
    /// Number of elements.
    pub(crate) elements: f64,
    /// Mean extent of the elements along each axis, m.
    pub(crate) size: [f64; D],
}

/// The fault of bodies that lie in each other.
pub(crate) fn crowd(span: Range<usize>, first: &str, second: &str, couples: f64) -> Fault {
    let message = format!(
        "bodies lie in each other: more than {} couples of elements would touch, most of them of \"{first}\" and \"{second}\"",
        grouped(couples as u64)
    );
    Fault::at(span, message)
        .label("lies in another")
        .help("bodies may touch, but not overlap: look for copies in the same place")
}

/// The two bodies that lie in each other most, and how many couples there are at least, where these are too
/// many to be kept: about, from the bounding boxes.
pub(crate) fn crowded<const D: usize>(boxes: &[Filled<D>]) -> Option<([usize; 2], f64)> {
    let limit = COUPLES[0] + COUPLES[1] * boxes.iter().map(|body| body.elements).sum::<f64>();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].bounds[0][0].total_cmp(&boxes[b].bounds[0][0]));
    let mut open: Vec<usize> = Vec::new();
    let (mut sum, mut most, mut worst) = (0.0, 0.0, [0; 2]);
    for &body in &order {
        let start = boxes[body].bounds[0][0];
        open.retain(|&other| boxes[other].bounds[1][0] > start);
        for &other in &open {
            let couples = couples(&boxes[body], &boxes[other]);
            sum += couples;
            if couples > most {
                (most, worst) = (couples, [other, body]);
            }
        }
        if sum > limit {
            return Some((worst, sum));
        }
        open.push(body);
    }
    None
}

/// Couples of elements that two boxes have, if each is filled evenly.
fn couples<const D: usize>(one: &Filled<D>, other: &Filled<D>) -> f64 {
    let size = |of: &Filled<D>| (0..D).map(|axis| of.bounds[1][axis] - of.bounds[0][axis]).product::<f64>();
    let mut found = one.elements / size(one) * other.elements / size(other);
    for axis in 0..D {
        let low = one.bounds[0][axis].max(other.bounds[0][axis]);
        found *= (one.bounds[1][axis].min(other.bounds[1][axis]) - low).max(0.0);
        found *= one.size[axis] + other.size[axis];
    }
    // Boxes without area or volume, or beyond the range of numbers, count as 0.
    if found.is_finite() { found } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(x: f64, elements: f64) -> Filled {
        Filled { bounds: [[x, 0.0], [x + 1.0, 1.0]], elements, size: [(2.3 / elements).sqrt(); 2] }
    }

    #[test]
    fn copies_in_one_place_are_too_many_and_bodies_side_by_side_are_not() {
        let side_by_side: Vec<Filled> = (0..2000).map(|k| filled(0.9 * f64::from(k), 100.0)).collect();
        assert!(crowded(&side_by_side).is_none());
        let copies = vec![filled(0.0, 100.0); 1000];
        assert!(crowded(&copies).is_some());
        assert!(crowded(&copies[..20]).is_none());
    }
}
