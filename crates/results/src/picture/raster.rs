//! Spheres, rods and triangles drawn into pixels with a depth buffer, without a graphics card. The pixels are the same on every machine.
//!
//! The image is drawn at twice its size along each axis and averaged.

use crate::picture::capsule::Capsule;
use crate::picture::colour::Rgb;
use crate::picture::flat::across;

/// Number of samples along each axis of a pixel.
pub(crate) const SAMPLES: usize = 2;

/// Direction to the light: left, above and in front.
const LIGHT: [f32; 3] = [-0.42, 0.62, 0.662_4];

/// Depth and colour of each sample. Depths increase towards the eye.
pub(crate) struct Raster {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    colour: Vec<Rgb>,
}

impl Raster {
    /// Creates an empty image of the given size in pixels.
    pub(crate) fn new([width, height]: [usize; 2]) -> Self {
        let (width, height) = (width * SAMPLES, height * SAMPLES);
        Self {
            width,
            height,
            depth: vec![f32::NEG_INFINITY; width * height],
            colour: vec![[255; 3]; width * height],
        }
    }

    /// Draws a sphere. Coordinates are in samples: x to the right, y down, z towards the eye.
    ///
    /// The radius is at least 0.75 samples, so that no sphere falls between the samples.
    pub(crate) fn sphere(&mut self, [x, y, z]: [f64; 3], radius: f64, colour: Rgb) {
        let radius = radius.max(0.75);
        let (columns, rows) = (self.columns(x, radius), self.rows(y, radius));
        let inverse = 1.0 / radius;
        for row in rows {
            let v = (row as f64 + 0.5 - y) * inverse;
            for column in columns.clone() {
                let u = (column as f64 + 0.5 - x) * inverse;
                let rest = 1.0 - u * u - v * v;
                if rest < 0.0 {
                    continue;
                }
                let w = rest.sqrt();
                let depth = (z + w * radius) as f32;
                let place = row * self.width + column;
                if depth > self.depth[place] {
                    self.depth[place] = depth;
                    self.colour[place] = lit(colour, [u as f32, -v as f32, w as f32]);
                }
            }
        }
    }

    /// Draws a rod with round ends.
    pub(crate) fn rod(&mut self, [a, b]: [[f64; 3]; 2], radius: f64, colour: Rgb) {
        let radius = radius.max(0.75);
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        let covered = Capsule::new([[a[0], a[1]], [b[0], b[1]]], radius);
        for row in covered.rows(self.height) {
            let v = row as f64 + 0.5 - a[1];
            for column in covered.columns(row, self.width) {
                let u = column as f64 + 0.5 - a[0];
                let share = if squared > 0.0 {
                    ((u * along[0] + v * along[1]) / squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let (du, dv) = ((u - share * along[0]) / radius, (v - share * along[1]) / radius);
                let rest = 1.0 - du * du - dv * dv;
                if rest < 0.0 {
                    continue;
                }
                let w = rest.sqrt();
                let depth = (a[2] + share * (b[2] - a[2]) + w * radius) as f32;
                let place = row * self.width + column;
                if depth > self.depth[place] {
                    self.depth[place] = depth;
                    self.colour[place] = lit(colour, [du as f32, -dv as f32, w as f32]);
                }
            }
        }
    }

    /// Draws a flat triangle, lit from both sides.
    pub(crate) fn triangle(&mut self, [a, b, c]: [[f64; 3]; 3], colour: Rgb) {
        let [ab, ac] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let normal =
            [ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]];
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        // The triangle is seen from its edge.
        if length <= 0.0 || normal[2] == 0.0 || !length.is_finite() {
            return;
        }
        let toward = length.copysign(normal[2]);
        // Rows run downwards, but the light is given with y upwards.
        let [x, y, z] = normal.map(|x| (x / toward) as f32);
        let colour = lit(colour, [x, -y, z]);
        let (low, high) = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
        for row in range(f64::midpoint(low, high), (high - low) / 2.0, self.height) {
            let v = row as f64 + 0.5;
            let Some([from, to]) = across([[a[0], a[1]], [b[0], b[1]], [c[0], c[1]]], v) else { continue };
            for column in range(f64::midpoint(from, to), (to - from) / 2.0, self.width) {
                let u = column as f64 + 0.5;
                if from <= u && u <= to {
                    let depth = (a[2] - ((u - a[0]) * normal[0] + (v - a[1]) * normal[1]) / normal[2]) as f32;
                    let place = row * self.width + column;
                    if depth > self.depth[place] {
                        self.depth[place] = depth;
                        self.colour[place] = colour;
                    }
                }
            }
        }
    }

    /// Darkens samples in hollows (ambient occlusion) and fades distant samples. `reach`: length of shadows, in samples.
    pub(crate) fn shade(&mut self, reach: f64, haze: f32) {
        // Three rings of eight directions. Offsets are rounded to integers, so that the result is the same on every machine.
        const DIRECTIONS: [[f64; 2]; 8] = [
            [1.0, 0.0],
            [0.707, 0.707],
            [0.0, 1.0],
            [-0.707, 0.707],
            [-1.0, 0.0],
            [-0.707, -0.707],
            [0.0, -1.0],
            [0.707, -0.707],
        ];
        let reach = reach.clamp(2.0, 60.0);
        let rings = [0.45, 1.0, 2.2].map(|share| {
            let far = reach * share;
            (far as f32, DIRECTIONS.map(|[x, y]| [(x * far).round() as isize, (y * far).round() as isize]))
        });
        let drawn = || self.depth.iter().copied().filter(|depth| depth.is_finite());
        let (nearest, farthest) = drawn()
            .fold((f32::NEG_INFINITY, f32::INFINITY), |(near, far), depth| (near.max(depth), far.min(depth)));
        let range = (nearest - farthest).max(f32::MIN_POSITIVE);
        let (width, height) = (self.width.cast_signed(), self.height.cast_signed());
        for row in 0..height {
            for column in 0..width {
                let place = (row * width + column).cast_unsigned();
                let depth = self.depth[place];
                if !depth.is_finite() {
                    continue;
                }
                let mut hidden = 0.0;
                for (far, offsets) in &rings {
                    for [x, y] in offsets {
                        let (u, v) = (column + x, row + y);
                        if u < 0 || v < 0 || u >= width || v >= height {
                            continue;
                        }
                        let above = self.depth[(v * width + u).cast_unsigned()] - depth;
                        // The steeper the slope, the more light is hidden; a very steep one hides less, because it belongs to another layer.
                        if above > 0.0 {
                            let slope = above / far;
                            hidden += slope.min(1.0) * if slope > 3.0 { 0.75 } else { 1.0 };
                        }
                    }
                }
                let open = 1.0 - 0.68 * (hidden / 24.0);
                let pale = haze * (nearest - depth) / range;
                self.colour[place] = self.colour[place].map(|channel| {
                    let shaded = f32::from(channel) * open;
                    (shaded + (250.0 - shaded) * pale).round() as u8
                });
            }
        }
    }

    /// Red, green and blue of each pixel, row by row from the top.
    pub(crate) fn pixels(&self) -> Vec<u8> {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
        let mut pixels = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            for column in 0..width {
                for channel in 0..3 {
                    let mut sum = 0;
                    for sample in 0..SAMPLES * SAMPLES {
                        let (v, u) = (row * SAMPLES + sample / SAMPLES, column * SAMPLES + sample % SAMPLES);
                        sum += u32::from(self.colour[v * self.width + u][channel]);
                    }
                    let samples = (SAMPLES * SAMPLES) as u32;
                    pixels.push(((sum + samples / 2) / samples) as u8);
                }
            }
        }
        pixels
    }

    fn columns(&self, x: f64, radius: f64) -> std::ops::Range<usize> {
        range(x, radius, self.width)
    }

    fn rows(&self, y: f64, radius: f64) -> std::ops::Range<usize> {
        range(y, radius, self.height)
    }
}

fn range(middle: f64, radius: f64, end: usize) -> std::ops::Range<usize> {
    ((middle - radius).max(0.0) as usize).min(end)..((middle + radius + 1.0).max(0.0) as usize).min(end)
}

/// Colour of a lit surface. The rim is a little darker, so that neighbours of the same colour can be distinguished.
fn lit(colour: Rgb, normal: [f32; 3]) -> Rgb {
    let lambert = normal.iter().zip(LIGHT).map(|(n, l)| n * l).sum::<f32>().max(0.0);
    let rim = 0.80 + 0.20 * normal[2];
    let light = (0.62 + 0.50 * lambert) * rim;
    // A soft highlight by the half vector between light and eye.
    let shine = (normal[0] * -0.23 + normal[1] * 0.34 + normal[2] * 0.912).max(0.0).powi(24) * 26.0;
    colour.map(|channel| (f32::from(channel) * light + shine).min(255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn painted(raster: &Raster) -> usize {
        raster.pixels().chunks(3).filter(|pixel| *pixel != [255; 3]).count()
    }

    #[test]
    fn a_sphere_covers_its_disc_and_hides_what_is_behind() {
        let mut raster = Raster::new([100, 100]);
        raster.sphere([100.0, 100.0, 0.0], 80.0, [200, 0, 0]);
        let area = painted(&raster) as f64;
        assert!((area / (std::f64::consts::PI * 1600.0) - 1.0).abs() < 0.03, "{area}");
        let before = raster.pixels();
        raster.sphere([100.0, 100.0, -90.0], 70.0, [0, 200, 0]);
        assert_eq!(raster.pixels(), before);
        raster.sphere([100.0, 100.0, 90.0], 70.0, [0, 200, 0]);
        let middle = &raster.pixels()[3 * (50 * 100 + 50)..][..3];
        assert!(middle[1] > middle[0], "{middle:?}");
    }

    #[test]
    fn nothing_is_too_small_and_what_is_outside_is_cut_off() {
        let mut raster = Raster::new([10, 10]);
        raster.sphere([7.9, 7.9, 0.0], 0.0, [0; 3]);
        assert!(painted(&raster) > 0);
        raster.sphere([-50.0, 1e12, 0.0], 3.0, [0; 3]);
        raster.rod([[-1e9, 5.0, 0.0], [1e9, 5.0, 0.0]], 1.0, [0; 3]);
        raster.rod([[3.0, 3.0, 0.0], [3.0, 3.0, 9.0]], 1.0, [0; 3]);
        raster.shade(4.0, 0.3);
        assert_eq!(raster.pixels().len(), 300);
    }

    /// A triangle covers its area at the depth of its plane.
    #[test]
    fn a_triangle_hides_what_is_behind_its_plane() {
        let mut raster = Raster::new([100, 100]);
        raster.triangle([[0.0, 0.0, 0.0], [200.0, 0.0, 100.0], [0.0, 200.0, 0.0]], [200, 0, 0]);
        let area = painted(&raster) as f64;
        assert!((area / 5000.0 - 1.0).abs() < 0.03, "{area}");
        let before = raster.pixels();
        raster.sphere([120.0, 40.0, 0.0], 20.0, [0, 200, 0]);
        assert_eq!(raster.pixels(), before, "the plane is at a depth of 60 there");
        raster.sphere([120.0, 40.0, 90.0], 20.0, [0, 200, 0]);
        assert!(raster.pixels() != before);
        raster.triangle([[0.0, 0.0, 0.0], [200.0, 0.0, 100.0], [100.0, 0.0, 9.0]], [200, 0, 0]);
        raster.triangle([[1e9, -1e9, 0.0], [2e9, 0.0, 100.0], [1e9, 9e9, 9.0]], [200, 0, 0]);
    }

    #[test]
    fn a_rod_reaches_from_end_to_end() {
        let mut raster = Raster::new([60, 20]);
        raster.rod([[10.0, 20.0, 0.0], [110.0, 20.0, 5.0]], 4.0, [10, 10, 10]);
        let pixels = raster.pixels();
        let dark = |column: usize| pixels[3 * (10 * 60 + column)] < 255;
        assert!(dark(5) && dark(30) && dark(54) && !dark(1) && !dark(58));
    }
}
