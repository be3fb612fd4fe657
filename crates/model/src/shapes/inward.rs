//! Surfaces whose triangles point inward.

use fdem_mesh::Corners;

use crate::shapes::holes::{self, Corner};

/// Turns all triangles of a closed surface around if it encloses a negative volume: then they point inward.
/// Returns a note on that.
pub(crate) fn turn_outward(triangles: &mut [[Corner; 3]]) -> Option<String> {
    let [origin, ..] = *triangles.first()?;
    let volume: f64 = triangles.iter().map(|&[a, b, c]| [origin, a, b, c].measure()).sum();
    // The volume of an open surface depends on the origin.
    if volume >= 0.0 || holes::words(triangles).is_some() {
        return None;
    }
    for [_, b, c] in triangles {
        std::mem::swap(b, c);
    }
    Some("the triangles of its surface pointed inward: all of them are turned around".to_owned())
}
