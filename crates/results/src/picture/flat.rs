//! Discs, triangles and lines drawn into pixels in order. The edges of discs and of lines with round ends are
//! antialiased; those of triangles and of lines with square ends are smooth if pixels have several samples.

use crate::arrays::each;
use crate::picture::capsule::Capsule;
use crate::picture::colour::Rgb;

/// A drawing area, initially white. Coordinates are in pixels from the upper left.
pub(crate) struct Flat {
    /// Samples along the side of a pixel.
    grid: usize,
    /// Width and height in samples.
    width: usize,
    height: usize,
    samples: Vec<Rgb>,
}

impl Flat {
    /// Creates an area of this width and height in pixels, each of which has `grid` times `grid` samples.
    pub(crate) fn new(size: [usize; 2], grid: usize) -> Self {
        let [width, height] = size.map(|pixels| pixels * grid);
        Self { grid, width, height, samples: vec![[255; 3]; width * height] }
    }

    /// Draws a disc with an outline.
    pub(crate) fn disc(&mut self, centre: [f64; 2], radius: f64, fill: Rgb, outline: Rgb, stroke: f64) {
        let ([x, y], [radius, stroke]) = (self.scaled(centre), self.scaled([radius, stroke]));
        // A disc smaller than a pixel covers a part of it.
        let outer = radius + stroke / 2.0;
        self.cover([x - outer, y - outer], [x + outer, y + outer], |u, v| {
            let distance = ((u - x) * (u - x) + (v - y) * (v - y)).sqrt();
            let inside = (radius - stroke / 2.0 - distance + 0.5).clamp(0.0, 1.0);
            let alpha = (outer - distance + 0.5).clamp(0.0, 1.0);
            let mixed =
                each(|c| f64::from(outline[c]) + (f64::from(fill[c]) - f64::from(outline[c])) * inside);
            (mixed, alpha * (2.0 * outer).min(1.0))
        });
    }

    /// Fills a triangle. A sample belongs to the triangle that contains its centre, so it belongs to only one
    /// of two adjacent triangles.
    pub(crate) fn triangle(&mut self, corners: [[f64; 2]; 3], colour: Rgb) {
        self.convex(&corners, colour);
    }

    /// Draws a line with round ends.
    pub(crate) fn line(&mut self, ends: [[f64; 2]; 2], width: f64, colour: Rgb) {
        let [a, b] = ends.map(|end| self.scaled(end));
        let width = width * self.grid as f64;
        let half = width / 2.0;
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        let paint = |u: f64, v: f64| {
            let [du, dv] = [u - a[0], v - a[1]];
            let share =
                if squared > 0.0 { ((du * along[0] + dv * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
            let [du, dv] = [du - share * along[0], dv - share * along[1]];
            let alpha = (half - (du * du + dv * dv).sqrt() + 0.5).clamp(0.0, 1.0);
            (colour.map(f64::from), alpha * width.min(1.0))
        };
        // Antialiasing reaches half a pixel beyond the edge.
        let covered = Capsule::new([a, b], half + 0.5);
        for row in covered.rows(self.height) {
            for column in covered.columns(row, self.width) {
                self.lay(row, column, &paint);
            }
        }
    }

    /// Draws a line with square ends.
    pub(crate) fn square_line(&mut self, [a, b]: [[f64; 2]; 2], width: f64, colour: Rgb) {
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

    /// Returns red, green and blue of each pixel, row by row from the top.
    pub(crate) fn into_pixels(self) -> Vec<u8> {
        let (grid, width) = (self.grid, self.width);
        if grid == 1 {
            return self.samples.into_flattened();
        }
        let count = (grid * grid) as u32;
        let mut pixels = Vec::with_capacity(3 * self.samples.len() / (grid * grid));
        for row in (0..self.height).step_by(grid) {
            for column in (0..width).step_by(grid) {
                for channel in 0..3 {
                    let mut sum = count / 2;
                    for of_row in row..row + grid {
                        for sample in &self.samples[of_row * width + column..][..grid] {
                            sum += u32::from(sample[channel]);
                        }
                    }
                    pixels.push((sum / count) as u8);
                }
            }
        }
        pixels
    }

    /// Lengths in samples.
    fn scaled(&self, pixels: [f64; 2]) -> [f64; 2] {
        pixels.map(|length| length * self.grid as f64)
    }

    /// Fills a convex polygon row by row, from the first crossing of its outline to the last.
    fn convex(&mut self, corners: &[[f64; 2]], colour: Rgb) {
        if !corners.iter().flatten().all(|x| x.is_finite()) {
            return;
        }
        let grid = self.grid as f64;
        let scaled = |axis: usize| corners.iter().map(move |corner| corner[axis] * grid);
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
                let [[x0, y0], [x1, y1]] = [a, b].map(|corner| self.scaled(corner));
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

    /// Blends a colour over the samples of a rectangle. `paint` returns colour and opacity at the middle of a
    /// sample.
    fn cover(&mut self, low: [f64; 2], high: [f64; 2], paint: impl Fn(f64, f64) -> ([f64; 3], f64)) {
        for row in range(low[1], high[1], self.height) {
            for column in range(low[0], high[0], self.width) {
                self.lay(row, column, &paint);
            }
        }
    }

    /// Blends a colour over a sample. `paint` returns colour and opacity at its middle.
    fn lay(&mut self, row: usize, column: usize, paint: &impl Fn(f64, f64) -> ([f64; 3], f64)) {
        let (colour, alpha) = paint(column as f64 + 0.5, row as f64 + 0.5);
        if alpha > 0.0 {
            for (old, new) in self.samples[row * self.width + column].iter_mut().zip(colour) {
                *old = (f64::from(*old) + (new - f64::from(*old)) * alpha).round() as u8;
            }
        }
    }
}

fn range(low: f64, high: f64, end: usize) -> std::ops::Range<usize> {
    ((low - 1.0).max(0.0) as usize).min(end)..((high + 2.0).max(0.0) as usize).min(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_covers_its_area_whatever_its_size() {
        for radius in [0.2, 0.5, 3.0, 11.3] {
            let mut flat = Flat::new([40, 40], 1);
            flat.disc([20.3, 19.6], radius, [0; 3], [0; 3], 0.0);
            let ink: f64 = flat.into_pixels().chunks(3).map(|pixel| 1.0 - f64::from(pixel[0]) / 255.0).sum();
            let area = std::f64::consts::PI * radius * radius;
            assert!(
                (ink / area - 1.0).abs() < if radius < 1.0 { 0.6 } else { 0.06 },
                "{radius}: {ink} for {area}"
            );
        }
    }

    /// Two halves cover a square, each pixel once.
    #[test]
    fn triangles_cover_their_area() {
        let halves = [[[2.0, 2.0], [12.0, 2.0], [12.0, 9.0]], [[2.0, 2.0], [12.0, 9.0], [2.0, 9.0]]];
        let count = |triangles: &[[[f64; 2]; 3]]| {
            let mut flat = Flat::new([20, 20], 1);
            for &corners in triangles {
                flat.triangle(corners, [0; 3]);
            }
            flat.into_pixels().chunks(3).filter(|pixel| *pixel == [0; 3]).count()
        };
        assert_eq!(count(&halves), 70);
        assert!((30..=40).contains(&count(&halves[..1])));
        assert_eq!(count(&[[[-9e9, -5.0], [9e9, -5.0], [0.0, -1.0]]]), 0);
    }

    #[test]
    fn what_is_outside_is_cut_off() {
        let mut flat = Flat::new([8, 8], 1);
        flat.line([[-1e9, 4.0], [1e9, 4.0]], 2.0, [9, 9, 9]);
        flat.disc([-1e12, 3.0], 5.0, [0; 3], [0; 3], 1.0);
        let pixels = flat.into_pixels();
        assert_eq!(&pixels[3 * (4 * 8)..][..3], &[9, 9, 9]);
        assert_eq!(&pixels[..3], &[255; 3]);
    }

    fn count(pixels: &[u8], colour: Rgb) -> usize {
        pixels.chunks_exact(3).filter(|pixel| **pixel == colour).count()
    }

    #[test]
    fn two_halves_of_a_square_leave_neither_a_gap_nor_a_trace_of_one_another() {
        for corner in [[3.0, 4.0], [3.3, 4.7]] {
            let [x, y] = corner;
            let mut fill = Flat::new([20, 20], 2);
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
        let mut fill = Flat::new([8, 8], 2);
        fill.triangle([[-50.0, -50.0], [-10.0, -50.0], [-10.0, -10.0]], [0; 3]);
        fill.triangle([[f64::NAN, 0.0], [5.0, 0.0], [5.0, 5.0]], [0; 3]);
        fill.square_line([[100.0, 3.0], [1e300, 3.0]], 2.0, [0; 3]);
        fill.square_line([[3.0, f64::INFINITY], [3.0, 3.0]], 2.0, [0; 3]);
        assert!(fill.into_pixels().iter().all(|&byte| byte == 255));
        let mut fill = Flat::new([8, 8], 2);
        fill.triangle([[-1e9, -1e9], [1e9, -1e9], [0.0, 1e9]], [7; 3]);
        assert!(fill.into_pixels().iter().all(|&byte| byte == 7), "larger than the area");
    }
}
