//! Surfaces whose triangles point inward.

use crate::shapes::holes::{self, Corner};

/// Turns all triangles of a closed surface around if it encloses a negative volume: then they point inward.
/// Returns a note on that.
pub(crate) fn turn_outward(triangles: &mut [[Corner; 3]]) -> Option<String> {
    let [origin, ..] = *triangles.first()?;
    let volume: f64 =
        triangles.iter().map(|corners| product(corners.map(|corner| minus(corner, origin)))).sum();
    // The volume of an open surface depends on the origin.
    if volume >= 0.0 || holes::words(triangles).is_some() {
        return None;
    }
    for [_, b, c] in triangles {
        std::mem::swap(b, c);
    }
    Some("the triangles of its surface pointed inward: all of them are turned around".to_owned())
}

fn minus(a: Corner, b: Corner) -> Corner {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

/// Six times the volume of the tetrahedron between the origin and three corners.
fn product([a, b, c]: [Corner; 3]) -> f64 {
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)
}
