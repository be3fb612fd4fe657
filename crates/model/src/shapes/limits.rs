//! Limits of the number of elements.

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::MOST_ELEMENTS;

/// Elements above which a model is refused.
pub(crate) const MOST: f64 = MOST_ELEMENTS as f64;

/// Memory that the mesher needs for each element, bytes.
const BYTES: f64 = 600.0;

/// Memory of the program itself, bytes.
const PROGRAM: f64 = 5e7;

/// Volume of a tetrahedron over the cube of the mean edge.
pub(crate) const VOLUME: f64 = 0.1;

/// Number of elements in a square or a cube of their size, about.
pub(crate) fn per_cube<const D: usize>() -> f64 {
    if D == 2 { 4.0 / 3.0_f64.sqrt() } else { 1.0 / VOLUME }
}

/// The reason why a body with this number of elements is refused; `None` if it is not. `before`: elements of
/// the bodies before it.
pub(crate) fn too_many(before: f64, elements: f64, size: f64, memory: Option<f64>) -> Option<String> {
    let all = before + elements;
    if !(all.is_finite() && all <= MOST) {
        let gives = if all.is_finite() {
            format!("gives about {} elements", brief(elements))
        } else {
            "gives more elements than can be counted".to_owned()
        };
        let others = if elements > MOST || !all.is_finite() {
            String::new()
        } else {
            format!(", {} with the bodies before", brief(all))
        };
        return Some(format!(
            "a mesh size of {} m {gives}{others}; the most are {}",
            brief(size),
            grouped(MOST as u64)
        ));
    }
    let memory = memory?;
    let needs = PROGRAM + BYTES * all;
    (needs > memory).then(|| {
        format!(
            "a mesh size of {} m gives about {} elements: the mesh needs about {} MB of memory, and {} MB are free",
            brief(size),
            brief(all),
            grouped((needs / 1e6).ceil() as u64),
            grouped((memory / 1e6) as u64)
        )
    })
}
