//! Spheres, rods with round ends and facets, lit from the left, above and in front.

use crate::arrays::each;
use crate::picture::capsule::Capsule;
use crate::picture::colour::Rgb;
use crate::picture::raster::buffer::{PARTS, Paint, Raster, byte};
use crate::picture::raster::triangle::{Stroke, Triangle};

/// Direction to the light: left, above and in front.
const LIGHT: [f32; 3] = [-0.42, 0.62, 0.662_4];

/// Least radius of drawn spheres, pixels, so that no sphere falls between the samples.
const LEAST: f64 = 0.375;

impl<const S: usize> Raster<S> {
    /// Draws a sphere. Coordinates are in pixels: x to the right, y down, z towards the eye.
    pub(crate) fn sphere(&mut self, [x, y, z]: [f64; 3], radius: f64, colour: Rgb) {
        let radius = radius.max(LEAST);
        let inverse = 1.0 / radius;
        let rows = range(y, radius, self.top + self.height);
        for row in rows.start.max(self.top)..rows.end {
            for column in range(x, radius, self.width) {
                self.surface([column, row], z + radius, colour, |[column, row]| {
                    let [u, v] = [(column - x) * inverse, (row - y) * inverse];
                    let rest = 1.0 - u * u - v * v;
                    (rest >= 0.0).then(|| {
                        let w = rest.sqrt();
                        (z + w * radius, [u, -v, w])
                    })
                });
            }
        }
    }

    /// Draws a rod with round ends.
    pub(crate) fn rod(&mut self, [a, b]: [[f64; 3]; 2], radius: f64, colour: Rgb) {
        let radius = radius.max(LEAST);
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        // The samples of a pixel are at most half a pixel from its middle.
        let covered = Capsule::new([[a[0], a[1]], [b[0], b[1]]], radius + 0.5);
        let nearest = a[2].max(b[2]) + radius;
        let rows = covered.rows(self.top + self.height);
        for row in rows.start.max(self.top)..rows.end {
            for column in covered.columns(row, self.width) {
                self.surface([column, row], nearest, colour, |[column, row]| {
                    let [u, v] = [column - a[0], row - a[1]];
                    let share = if squared > 0.0 {
                        ((u * along[0] + v * along[1]) / squared).clamp(0.0, 1.0)
                    } else {
                        0.0
                    };
                    let (du, dv) = ((u - share * along[0]) / radius, (v - share * along[1]) / radius);
                    let rest = 1.0 - du * du - dv * dv;
                    (rest >= 0.0).then(|| {
                        let w = rest.sqrt();
                        (a[2] + share * (b[2] - a[2]) + w * radius, [du, -dv, w])
                    })
                });
            }
        }
    }

    /// Draws a flat triangle, lit from both sides.
    pub(crate) fn facet(&mut self, corners: [[f64; 3]; 3], colour: Rgb) {
        let [a, b, c] = corners;
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
        let paint = Paint::solid(lit(colour, [x, -y, z]));
        self.triangle(&Triangle { corners, paint, lines: [Stroke::NONE; 3] });
    }

    /// Draws the part of a curved surface in one pixel. `nearest`: its greatest depth. `at` returns its depth
    /// and its normal at a sample, if it is there.
    #[inline]
    fn surface(
        &mut self,
        [column, row]: [usize; 2],
        nearest: f64,
        colour: Rgb,
        at: impl Fn([f64; 2]) -> Option<(f64, [f64; 3])>,
    ) {
        let Some(place) = row.checked_sub(self.top).map(|row| row * self.width + column) else { return };
        if (nearest as f32) < self.hidden[place] {
            return;
        }
        let (depths, colours) = (&mut self.depths[place], &mut self.colours[place]);
        for k in 0..S {
            let [x, y] = [self.places[0][k] / PARTS, self.places[1][k] / PARTS];
            let Some((depth, [u, v, w])) = at([column as f64 + x, row as f64 + y]) else { continue };
            if depth as f32 > depths[k] {
                depths[k] = depth as f32;
                colours[k] = Paint::solid(lit(colour, [u as f32, v as f32, w as f32])).packed();
            }
        }
        self.hidden[place] = depths.iter().copied().fold(f32::INFINITY, f32::min);
    }
}

/// Numbers of the pixels of which a part may be within `radius` of `middle`, below `end`.
fn range(middle: f64, radius: f64, end: usize) -> std::ops::Range<usize> {
    ((middle - radius).max(0.0) as usize).min(end)..((middle + radius + 1.0).max(0.0) as usize).min(end)
}

/// Colour of a lit surface. The rim is a little darker, so that neighbours of the same colour can be
/// distinguished.
fn lit(colour: Rgb, normal: [f32; 3]) -> Rgb {
    let [x, y, z] = normal;
    let lambert = (x * LIGHT[0] + y * LIGHT[1] + z * LIGHT[2]).max(0.0);
    let rim = 0.80 + 0.20 * z;
    let light = (0.62 + 0.50 * lambert) * rim;
    // A soft highlight by the half vector between light and eye.
    let shine = (x * -0.23 + y * 0.34 + z * 0.912).max(0.0).powi(24) * 26.0;
    each(|k| byte(f32::from(colour[k]) * light + shine))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::raster::GRID;

    fn painted(raster: &Raster<4>) -> usize {
        raster.pixels().chunks(3).filter(|pixel| *pixel != [255; 3]).count()
    }

    #[test]
    fn a_sphere_covers_its_disc_and_hides_what_is_behind() {
        let mut raster = Raster::new(&GRID, [100, 100]);
        raster.sphere([50.0, 50.0, 0.0], 40.0, [200, 0, 0]);
        let area = painted(&raster) as f64;
        assert!((area / (std::f64::consts::PI * 1600.0) - 1.0).abs() < 0.03, "{area}");
        let before = raster.pixels();
        raster.sphere([50.0, 50.0, -45.0], 35.0, [0, 200, 0]);
        assert_eq!(raster.pixels(), before);
        raster.sphere([50.0, 50.0, 45.0], 35.0, [0, 200, 0]);
        let middle = &raster.pixels()[3 * (50 * 100 + 50)..][..3];
        assert!(middle[1] > middle[0], "{middle:?}");
    }

    #[test]
    fn nothing_is_too_small_and_what_is_outside_is_cut_off() {
        let mut raster = Raster::new(&GRID, [10, 10]);
        raster.sphere([3.9, 3.9, 0.0], 0.0, [0; 3]);
        assert!(painted(&raster) > 0);
        raster.sphere([-50.0, 1e12, 0.0], 3.0, [0; 3]);
        raster.rod([[-1e9, 5.0, 0.0], [1e9, 5.0, 0.0]], 1.0, [0; 3]);
        raster.rod([[3.0, 3.0, 0.0], [3.0, 3.0, 9.0]], 1.0, [0; 3]);
        raster.shade(2.0, 0.3);
        assert_eq!(raster.pixels().len(), 300);
    }

    /// A triangle covers its area at the depth of its plane.
    #[test]
    fn a_facet_hides_what_is_behind_its_plane() {
        let mut raster = Raster::new(&GRID, [100, 100]);
        raster.facet([[0.0, 0.0, 0.0], [100.0, 0.0, 50.0], [0.0, 100.0, 0.0]], [200, 0, 0]);
        let area = painted(&raster) as f64;
        assert!((area / 5000.0 - 1.0).abs() < 0.03, "{area}");
        let before = raster.pixels();
        raster.sphere([60.0, 20.0, 0.0], 10.0, [0, 200, 0]);
        assert_eq!(raster.pixels(), before, "the plane is at a depth of 30 there");
        raster.sphere([60.0, 20.0, 45.0], 10.0, [0, 200, 0]);
        assert!(raster.pixels() != before);
        raster.facet([[0.0, 0.0, 0.0], [100.0, 0.0, 50.0], [50.0, 0.0, 4.0]], [200, 0, 0]);
        raster.facet([[1e9, -1e9, 0.0], [2e9, 0.0, 100.0], [1e9, 9e9, 9.0]], [200, 0, 0]);
    }

    #[test]
    fn a_rod_reaches_from_end_to_end() {
        let mut raster = Raster::new(&GRID, [60, 20]);
        raster.rod([[5.0, 10.0, 0.0], [55.0, 10.0, 2.5]], 2.0, [10, 10, 10]);
        let pixels = raster.pixels();
        let dark = |column: usize| pixels[3 * (10 * 60 + column)] < 255;
        assert!(dark(5) && dark(30) && dark(54) && !dark(1) && !dark(58));
    }

    /// With 16 samples in a pixel, edges are finer, and spheres stand among triangles.
    #[test]
    fn a_sphere_may_have_any_samples() {
        let mut raster = Raster::new(&crate::picture::raster::buffer::SPREAD, [40, 40]);
        raster.facet([[0.0, 0.0, 0.0], [80.0, 0.0, 0.0], [0.0, 80.0, 0.0]], [200, 0, 0]);
        raster.sphere([20.0, 20.0, 0.0], 10.0, [0, 200, 0]);
        let pixels = raster.pixels();
        let green = pixels.chunks(3).map(|pixel| f64::from(u8::from(pixel[1] > pixel[0]))).sum::<f64>();
        assert!((green / (std::f64::consts::PI * 100.0) - 1.0).abs() < 0.05, "{green}");
    }
}
