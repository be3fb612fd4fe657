//! Discs and lines by pixel, each over those before it, with soft edges.

use crate::picture::colour::Rgb;

/// Red, green and blue of each pixel, row after row from the top.
pub(crate) struct Flat {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Flat {
    /// White.
    pub(crate) fn new([width, height]: [usize; 2]) -> Self {
        Self { width, height, pixels: vec![255; 3 * width * height] }
    }

    /// A disc with an outline on its rim.
    pub(crate) fn disc(&mut self, [x, y]: [f64; 2], radius: f64, fill: Rgb, outline: Rgb, stroke: f64) {
        // What is smaller than a pixel covers a part of it.
        let outer = radius + stroke / 2.0;
        self.cover([x - outer, y - outer], [x + outer, y + outer], |u, v| {
            let distance = ((u - x) * (u - x) + (v - y) * (v - y)).sqrt();
            let inside = (radius - stroke / 2.0 - distance + 0.5).clamp(0.0, 1.0);
            let alpha = (outer - distance + 0.5).clamp(0.0, 1.0);
            let mixed = std::array::from_fn(|c| {
                f64::from(outline[c]) + (f64::from(fill[c]) - f64::from(outline[c])) * inside
            });
            (mixed, alpha * (2.0 * outer).min(1.0))
        });
    }

    /// A line with round ends.
    pub(crate) fn line(&mut self, [a, b]: [[f64; 2]; 2], width: f64, colour: Rgb) {
        let half = width / 2.0;
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        let low = [a[0].min(b[0]) - half, a[1].min(b[1]) - half];
        let high = [a[0].max(b[0]) + half, a[1].max(b[1]) + half];
        self.cover(low, high, |u, v| {
            let [du, dv] = [u - a[0], v - a[1]];
            let share =
                if squared > 0.0 { ((du * along[0] + dv * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
            let [du, dv] = [du - share * along[0], dv - share * along[1]];
            let alpha = (half - (du * du + dv * dv).sqrt() + 0.5).clamp(0.0, 1.0);
            (colour.map(f64::from), alpha * width.min(1.0))
        });
    }

    pub(crate) fn into_pixels(self) -> Vec<u8> {
        self.pixels
    }

    /// Lays a colour over the pixels from one corner to the other, with the share that `paint` says at the middle of each.
    fn cover(&mut self, low: [f64; 2], high: [f64; 2], paint: impl Fn(f64, f64) -> ([f64; 3], f64)) {
        let range = |low: f64, high: f64, end: usize| {
            ((low - 1.0).max(0.0) as usize).min(end)..((high + 2.0).max(0.0) as usize).min(end)
        };
        for row in range(low[1], high[1], self.height) {
            for column in range(low[0], high[0], self.width) {
                let (colour, alpha) = paint(column as f64 + 0.5, row as f64 + 0.5);
                if alpha > 0.0 {
                    let place = 3 * (row * self.width + column);
                    for (old, new) in self.pixels[place..place + 3].iter_mut().zip(colour) {
                        *old = (f64::from(*old) + (new - f64::from(*old)) * alpha).round() as u8;
                    }
                }
            }
        }
    }
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
