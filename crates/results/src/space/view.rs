//! The part of space that pictures show, and the direction from which it is seen.

use crate::arrays::each;
use crate::run::pictures::extent;
use crate::space::frame::SpaceFrame;

/// The visible parts of all pictures of a series in three dimensions, and the direction of view: in parallel
/// projection, with z upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceView {
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
    /// The latest time of the frames, which determines the unit and the decimals of times.
    pub(crate) last: f64,
    /// Directions to the right, upwards and to the eye.
    axes: [[f64; 3]; 3],
}

/// Angles of the usual view: from the front, to the right and above.
const AZIMUTH: f64 = 30.0;
const ELEVATION: f64 = 25.0;

impl SpaceView {
    /// Returns a view of all frames from the front right above. It reaches beyond the first frame that has
    /// half of all spheres by at most half of the longest side of that frame. Fragments that fly farther
    /// leave the picture.
    pub fn of<'a>(frames: impl IntoIterator<Item = &'a SpaceFrame>) -> Self {
        let (bounds, times): (Vec<_>, Vec<f64>) =
            frames.into_iter().map(|frame| ((frame.extent(), frame.counts()), frame.time)).unzip();
        let extent = extent(bounds);
        let [low, high] = [0, 1].map(|end| extent.map(|axis| axis[end]));
        let last = times.into_iter().fold(0.0, f64::max);
        Self::between(low, high, last)
    }

    /// Returns a view of a box.
    pub(crate) fn between(low: [f64; 3], high: [f64; 3], last: f64) -> Self {
        Self { low, high, last, axes: axes(AZIMUTH, ELEVATION) }
    }

    /// Returns the same part of space, seen from another direction.
    ///
    /// # Arguments
    /// Both in degrees. `azimuth`: 0 from the front, against the direction of y; 90 from the right, against
    /// that of x. `elevation`: 0 from the side, 90 from above, -90 from below. Angles that are not finite
    /// are 0.
    #[must_use]
    pub fn seen_from(self, azimuth: f64, elevation: f64) -> Self {
        Self { axes: axes(azimuth, elevation), ..self }
    }

    /// Returns the direction to the eye. Its length is 1.
    pub fn eye(&self) -> [f64; 3] {
        self.axes[2]
    }

    /// Returns the parts of a vector to the right, upwards and to the eye.
    pub(crate) fn turned(&self, vector: [f64; 3]) -> [f64; 3] {
        each(|k| {
            let axis = self.axes[k];
            axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2]
        })
    }

    /// Returns the least and the greatest coordinates of the box around the visible parts, to the right,
    /// upwards and to the eye.
    pub(crate) fn extent(&self) -> [[f64; 2]; 3] {
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for bits in 0..8 {
            let corner =
                [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] });
            for (ends, x) in extent.iter_mut().zip(self.turned(corner)) {
                *ends = [ends[0].min(x), ends[1].max(x)];
            }
        }
        extent
    }

    /// Returns the names of the axes and their directions in a drawing, with y downwards. An axis that points
    /// to the eye is left out.
    pub(crate) fn triad(&self) -> Vec<(&'static str, [f64; 2])> {
        let axis = |k: usize| {
            let [x, y, _] = self.turned(std::array::from_fn(|axis| f64::from(u8::from(axis == k))));
            (["x", "y", "z"][k], [x, -y])
        };
        (0..3).map(axis).filter(|(_, [x, y])| x * x + y * y > 0.01).collect()
    }
}

/// Returns the directions to the right, upwards and to the eye.
fn axes(azimuth: f64, elevation: f64) -> [[f64; 3]; 3] {
    let ([sin, cos], [above, level]) = (sine_and_cosine(azimuth), sine_and_cosine(elevation));
    [[cos, sin, 0.0], [-sin * above, cos * above, level], [sin * level, -cos * level, above]]
}

/// Returns sine and cosine of an angle in degrees, by their series: those of the standard library differ
/// between machines. The error is below 1e-15.
fn sine_and_cosine(degrees: f64) -> [f64; 2] {
    if !degrees.is_finite() {
        return [0.0, 1.0];
    }
    // The nearest quarter of a turn, and the rest, from -45° to 45°.
    let turn = degrees.rem_euclid(360.0);
    let quarter = (turn / 90.0 + 0.5).floor();
    let x = (turn - 90.0 * quarter) * (std::f64::consts::PI / 180.0);
    let (mut sin, mut cos, mut term) = (0.0, 0.0, 1.0);
    for k in 0..20_u32 {
        let sign = if k % 4 < 2 { 1.0 } else { -1.0 };
        if k % 2 == 0 {
            cos += sign * term;
        } else {
            sin += sign * term;
        }
        term *= x / f64::from(k + 1);
    }
    match quarter as u32 % 4 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_those_of_the_library() {
        for k in -1000..1000 {
            let degrees = 0.73 * f64::from(k);
            let [sin, cos] = sine_and_cosine(degrees);
            let turn = degrees.rem_euclid(360.0).to_radians();
            assert!((sin - turn.sin()).abs() < 2e-15 && (cos - turn.cos()).abs() < 2e-15, "{degrees}");
        }
        assert_eq!(sine_and_cosine(90.0), [1.0, 0.0]);
        assert_eq!(sine_and_cosine(-180.0).map(f64::abs), [0.0, 1.0]);
        assert_eq!(sine_and_cosine(f64::NAN), [0.0, 1.0]);
    }

    #[test]
    fn directions_are_those_of_the_angles() {
        let view = SpaceView::between([0.0; 3], [1.0, 2.0, 3.0], 0.0);
        assert_eq!(view.seen_from(0.0, 0.0).turned([1.0, 2.0, 3.0]), [1.0, 3.0, -2.0]);
        assert_eq!(view.seen_from(90.0, 0.0).turned([1.0, 2.0, 3.0]), [2.0, 3.0, 1.0]);
        assert_eq!(view.seen_from(0.0, 90.0).turned([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(view.seen_from(0.0, 0.0).extent(), [[0.0, 1.0], [0.0, 3.0], [-2.0, 0.0]]);
        let [x, y, z] = view.eye();
        assert!(x > 0.0 && y < 0.0 && z > 0.0, "front right above");
        let square = view.axes.map(|axis| axis.iter().map(|x| x * x).sum::<f64>());
        assert!(square.iter().all(|square| (square - 1.0).abs() < 1e-15));
        assert_eq!(view.seen_from(0.0, 90.0).triad().len(), 2);
        assert_eq!(view.triad().len(), 3);
    }
}
