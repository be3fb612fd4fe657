//! Shadows in hollows (ambient occlusion), and haze.

use crate::arrays::each;
use crate::picture::raster::buffer::{Raster, byte};

/// Samples along each axis of a pixel with four samples, [`GRID`](crate::picture::raster::GRID).
const SIDE: isize = 2;

/// Directions from a sample in which others may hide the light.
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

/// Lengths of shadows, parts of their reach.
const RINGS: [f64; 3] = [0.45, 1.0, 2.2];

impl Raster<4> {
    /// Darkens samples in hollows and fades distant samples, `haze` of the colour at the farthest. `reach`:
    /// length of shadows, pixels.
    pub(crate) fn shade(&mut self, reach: f64, haze: f32) {
        let reach = reach.clamp(1.0, 30.0);
        // Offsets are rounded to integers, so that the result is the same on every machine.
        let rings = RINGS.map(|share| {
            let far = reach * share;
            let offset = |x: f64| (x * SIDE as f64 * far).round() as isize;
            (far as f32, DIRECTIONS.map(|direction| direction.map(offset)))
        });
        let wide = self.width.cast_signed();
        // Each offset with its distance in memory from the first, second, third and fourth sample of a pixel.
        let rings_of: [_; 4] = each(|k| {
            let k = k.cast_signed();
            let [column, row] = [k % SIDE, k / SIDE];
            rings.map(|(far, offsets)| {
                let distant = |[x, y]: [isize; 2]| {
                    [x, y, place_of(column + x, row + y, wide) - place_of(column, row, wide)]
                };
                (far, offsets.map(distant))
            })
        });
        let drawn = || self.depths.as_flattened().iter().copied().filter(|depth| depth.is_finite());
        let nearest = drawn().fold(f32::NEG_INFINITY, f32::max);
        let farthest = drawn().fold(f32::INFINITY, f32::min);
        let range = (nearest - farthest).max(f32::MIN_POSITIVE);
        let (width, height) = (SIDE * wide, SIDE * self.height.cast_signed());
        let depths = self.depths.as_flattened();
        let colours = self.colours.as_flattened_mut();
        for row in 0..height {
            for column in 0..width {
                let place = place_of(column, row, wide);
                let depth = depths[place.cast_unsigned()];
                if !depth.is_finite() {
                    continue;
                }
                let mut hidden = 0.0;
                for (far, offsets) in &rings_of[(place % 4).cast_unsigned()] {
                    for [x, y, distance] in offsets {
                        let (u, v) = (column + x, row + y);
                        if u < 0 || v < 0 || u >= width || v >= height {
                            continue;
                        }
                        let above = depths[(place + distance).cast_unsigned()] - depth;
                        // The steeper the slope, the more light is hidden; a very steep one hides less,
                        // because it belongs to another layer.
                        if above > 0.0 {
                            let slope = above / far;
                            hidden += slope.min(1.0) * if slope > 3.0 { 0.75 } else { 1.0 };
                        }
                    }
                }
                let open = 1.0 - 0.68 * (hidden / 24.0);
                let pale = haze * (nearest - depth) / range;
                let colour = &mut colours[place.cast_unsigned()];
                let [cover, channels @ ..] = colour.to_be_bytes();
                let [red, green, blue] = each(|k| {
                    let shaded = f32::from(channels[k]) * open;
                    byte(shaded + (250.0 - shaded) * pale)
                });
                *colour = u32::from_be_bytes([cover, red, green, blue]);
            }
        }
    }
}

/// Place in memory of a sample of the grid; also outside of the image, `wide` pixels wide.
#[inline]
fn place_of(column: isize, row: isize, wide: isize) -> isize {
    4 * (row.div_euclid(SIDE) * wide + column.div_euclid(SIDE))
        + SIDE * row.rem_euclid(SIDE)
        + column.rem_euclid(SIDE)
}
