//! Bodies so far from the origin that their coordinates have too few digits for their shape.

use fdem_io::numbers::brief;

use crate::text::fault::Problem;

/// Distance from the origin over the width of a body up to which its shape is kept: of the 16 digits of a
/// coordinate, 4 are left for it there.
const FARTHEST: f64 = 1e12;

/// The problem of a body that is too far from the origin. `bounds`: its least and largest coordinates.
pub(crate) fn problem<const D: usize>(key: &str, name: &str, bounds: [[f64; D]; 2]) -> Option<Problem> {
    moved(key, name, bounds, [0.0; D])
}

/// Like [`problem`], for a body that is moved. Its width is that before: after it, rounding has changed it.
pub(crate) fn moved<const D: usize>(
    key: &str,
    name: &str,
    [low, high]: [[f64; D]; 2],
    by: [f64; D],
) -> Option<Problem> {
    let width = (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let farthest = (0..D).map(|axis| (low[axis] + by[axis]).abs().max((high[axis] + by[axis]).abs()));
    let distance = farthest.fold(0.0, f64::max);
    // A shape without any width has another fault, unless it has lost its width to rounding; one without a
    // mesh has another, too.
    if !distance.is_finite() || distance <= FARTHEST * width || width == 0.0 && distance <= FARTHEST {
        return None;
    }
    Some(Problem {
        help: Some("put the origin nearer to the bodies".to_owned()),
        ..Problem::new(
            key,
            format!(
                "[[body]] \"{name}\" is {} m wide and {} m from the origin: coordinates there have too few digits for its shape",
                brief(width),
                brief(distance)
            ),
        )
    })
}
