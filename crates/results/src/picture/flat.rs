//! Discs, triangles and lines drawn into pixels in order. The edges of discs and lines are antialiased.

use crate::arrays::each;
use crate::picture::capsule::Capsule;
use crate::picture::colour::Rgb;

/// Red, green and blue of each pixel, row by row from the top.
pub(crate) struct Flat {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Flat {
    /// Creates a white image.
    pub(crate) fn new([width, height]: [usize; 2]) -> Self {
        Self { width, height, pixels: vec![255; 3 * width * height] }
    }

    /// Draws a disc with an outline.
    pub(crate) fn disc(&mut self, [x, y]: [f64; 2], radius: f64, fill: Rgb, outline: Rgb, stroke: f64) {
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

    /// Draws a triangle without an outline.
    pub(crate) fn triangle(&mut self, corners: [[f64; 2]; 3], colour: Rgb) {
        let heights = corners.map(|[_, y]| y);
        let (top, bottom) = (
            heights.into_iter().fold(f64::INFINITY, f64::min),
            heights.into_iter().fold(f64::NEG_INFINITY, f64::max),
        );
        for row in range(top, bottom, self.height) {
            let Some([from, to]) = across(corners, row as f64 + 0.5) else { continue };
            for column in range(from, to, self.width) {
                let u = column as f64 + 0.5;
                if from <= u && u <= to {
                    let place = 3 * (row * self.width + column);
                    self.pixels[place..place + 3].copy_from_slice(&colour);
                }
            }
        }
    }

    /// Draws a line with round ends.
    pub(crate) fn line(&mut self, [a, b]: [[f64; 2]; 2], width: f64, colour: Rgb) {
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

    pub(crate) fn into_pixels(self) -> Vec<u8> {
        self.pixels
    }

    /// Blends a colour over the pixels of a rectangle. `paint` returns colour and opacity at the middle of a
    /// pixel.
    fn cover(&mut self, low: [f64; 2], high: [f64; 2], paint: impl Fn(f64, f64) -> ([f64; 3], f64)) {
        for row in range(low[1], high[1], self.height) {
            for column in range(low[0], high[0], self.width) {
                self.lay(row, column, &paint);
            }
        }
    }

    /// Blends a colour over a pixel. `paint` returns colour and opacity at its middle.
    fn lay(&mut self, row: usize, column: usize, paint: &impl Fn(f64, f64) -> ([f64; 3], f64)) {
        let (colour, alpha) = paint(column as f64 + 0.5, row as f64 + 0.5);
        if alpha > 0.0 {
            let place = 3 * (row * self.width + column);
            for (old, new) in self.pixels[place..place + 3].iter_mut().zip(colour) {
                *old = (f64::from(*old) + (new - f64::from(*old)) * alpha).round() as u8;
            }
        }
    }
}

fn range(low: f64, high: f64, end: usize) -> std::ops::Range<usize> {
    ((low - 1.0).max(0.0) as usize).min(end)..((high + 2.0).max(0.0) as usize).min(end)
}

/// Range in which a triangle covers the row at `v`.
pub(crate) fn across(corners: [[f64; 2]; 3], v: f64) -> Option<[f64; 2]> {
    let mut span: Option<[f64; 2]> = None;
    for k in 0..3 {
        let ([x, y], [to_x, to_y]) = (corners[k], corners[(k + 1) % 3]);
        if (y <= v) != (to_y <= v) {
            let u = x + (v - y) / (to_y - y) * (to_x - x);
            span = Some(span.map_or([u, u], |[low, high]| [low.min(u), high.max(u)]));
        }
    }
    span
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_covers_its_area_whatever_its_size() {
        for radius in [0.2, 0.5, 3.0, 11.3] {
            let mut flat = Flat::new([40, 40]);
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
            let mut flat = Flat::new([20, 20]);
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
        let mut flat = Flat::new([8, 8]);
        flat.line([[-1e9, 4.0], [1e9, 4.0]], 2.0, [9, 9, 9]);
        flat.disc([-1e12, 3.0], 5.0, [0; 3], [0; 3], 1.0);
        let pixels = flat.into_pixels();
        assert_eq!(&pixels[3 * (4 * 8)..][..3], &[9, 9, 9]);
        assert_eq!(&pixels[..3], &[255; 3]);
    }
}
