//! Rasterization of triangles and lines, with four samples per pixel for smooth edges.

use crate::picture::colour::Rgb;

/// Samples along the side of a pixel.
const SAMPLES: usize = 2;

/// A drawing area, initially white.
pub(crate) struct Fill {
    /// Width in samples.
    width: usize,
    height: usize,
    samples: Vec<Rgb>,
}

impl Fill {
    /// Creates a white area of this width and height in pixels.
    pub(crate) fn new([width, height]: [usize; 2]) -> Self {
        let (width, height) = (width * SAMPLES, height * SAMPLES);
        Self { width, height, samples: vec![[255; 3]; width * height] }
    }

    /// Fills a triangle. Its corners are in pixels from the upper left. A sample belongs to the triangle that
    /// contains its centre, so it belongs to only one of two adjacent triangles.
    pub(crate) fn triangle(&mut self, corners: [[f64; 2]; 3], colour: Rgb) {
        self.convex(&corners, colour);
    }

    /// Draws a line with square ends.
    pub(crate) fn line(&mut self, [a, b]: [[f64; 2]; 2], width: f64, colour: Rgb) {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        if !length.is_finite() {
            return;
        }
        let half = width / 2.0;
        let [tx, ty] = if length > 0.0 { [dx / length * half, dy / length * half] } else { [half, 0.0] };
        // The line is slightly extended, so that cracks along neighbouring edges meet.
        let [a, b] = [[a[0] - tx / 2.0, a[1] - ty / 2.0], [b[0] + tx / 2.0, b[1] + ty / 2.0]];
        self.convex(
            &[[a[0] - ty, a[1] + tx], [b[0] - ty, b[1] + tx], [b[0] + ty, b[1] - tx], [a[0] + ty, a[1] - tx]],
            colour,
        );
    }

    /// Fills a convex polygon row by row, from the first crossing of its outline to the last.
    fn convex(&mut self, corners: &[[f64; 2]], colour: Rgb) {
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            return;
        }
        let scaled = |axis: usize| corners.iter().map(move |corner| corner[axis] * SAMPLES as f64);
        let (top, bottom) =
            (scaled(1).fold(f64::INFINITY, f64::min), scaled(1).fold(f64::NEG_INFINITY, f64::max));
        // Sample row k is at k + 0.5. A negative number is cast to 0.
        let first = (top - 0.5).ceil() as usize;
        let end = ((bottom - 0.5).ceil().max(0.0) as usize).min(self.height);
        for row in first..end {
            let y = row as f64 + 0.5;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for (k, corner) in corners.iter().enumerate() {
                let other = corners[(k + 1) % corners.len()];
                // The edge has the same direction in both of its triangles, so both get the same crossing.
                let (a, b) = if corner[1] <= other[1] { (*corner, other) } else { (other, *corner) };
                let [[x0, y0], [x1, y1]] = [scale(a), scale(b)];
                if y0 <= y && y < y1 {
                    let x = x0 + (y - y0) / (y1 - y0) * (x1 - x0);
                    (left, right) = (left.min(x), right.max(x));
                }
            }
            if left < right {
                let from = ((left - 0.5).ceil() as usize).min(self.width);
                let to = ((right - 0.5).ceil().max(0.0) as usize).min(self.width);
                if from < to {
                    self.samples[row * self.width + from..row * self.width + to].fill(colour);
                }
            }
        }
    }

    /// Returns red, green and blue of each pixel, row by row.
    pub(crate) fn into_pixels(self) -> Vec<u8> {
        let (columns, rows) = (self.width / SAMPLES, self.height / SAMPLES);
        let mut pixels = Vec::with_capacity(3 * columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let at = row * SAMPLES * self.width + column * SAMPLES;
                let [a, b] = [self.samples[at], self.samples[at + 1]];
                let [c, d] = [self.samples[at + self.width], self.samples[at + self.width + 1]];
                for channel in 0..3 {
                    let sum = [a, b, c, d].iter().fold(0, |sum, sample| sum + u32::from(sample[channel]));
                    pixels.push(((sum + 2) / 4) as u8);
                }
            }
        }
        pixels
    }
}

/// A point in samples.
fn scale([x, y]: [f64; 2]) -> [f64; 2] {
    [x * SAMPLES as f64, y * SAMPLES as f64]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(pixels: &[u8], colour: Rgb) -> usize {
        pixels.chunks_exact(3).filter(|pixel| **pixel == colour).count()
    }

    #[test]
    fn two_halves_of_a_square_leave_neither_a_gap_nor_a_trace_of_one_another() {
        for corner in [[3.0, 4.0], [3.3, 4.7]] {
            let [x, y] = corner;
            let mut fill = Fill::new([20, 20]);
            fill.triangle([[x, y], [x + 10.0, y], [x, y + 10.0]], [255, 0, 0]);
            fill.triangle([[x + 10.0, y], [x + 10.0, y + 10.0], [x, y + 10.0]], [255, 0, 0]);
            let pixels = fill.into_pixels();
            assert!((81..=100).contains(&count(&pixels, [255, 0, 0])), "{}", count(&pixels, [255, 0, 0]));
            let inner = |k: usize| (6..11).contains(&(k % 20)) && (6..13).contains(&(k / 20));
            assert!(pixels.chunks_exact(3).enumerate().all(|(k, pixel)| !inner(k) || pixel == [255, 0, 0]));
        }
    }

    #[test]
    fn what_is_outside_or_nowhere_is_not_drawn() {
        let mut fill = Fill::new([8, 8]);
        fill.triangle([[-50.0, -50.0], [-10.0, -50.0], [-10.0, -10.0]], [0; 3]);
        fill.triangle([[f64::NAN, 0.0], [5.0, 0.0], [5.0, 5.0]], [0; 3]);
        fill.line([[100.0, 3.0], [1e300, 3.0]], 2.0, [0; 3]);
        fill.line([[3.0, f64::INFINITY], [3.0, 3.0]], 2.0, [0; 3]);
        assert!(fill.into_pixels().iter().all(|&byte| byte == 255));
        let mut fill = Fill::new([8, 8]);
        fill.triangle([[-1e9, -1e9], [1e9, -1e9], [0.0, 1e9]], [7; 3]);
        assert!(fill.into_pixels().iter().all(|&byte| byte == 7), "larger than the area");
    }
}
