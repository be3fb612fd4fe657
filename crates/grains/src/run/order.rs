//! The order of spheres in memory: along a curve through space, so that neighbours are close together.

use crate::vector::Vector;

/// Cells along each axis.
const CELLS: f64 = 1024.0;

/// Places of points along Morton's curve: the number of the point at each place.
pub(crate) fn along_curve(points: &[Vector]) -> Vec<u32> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let widest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let scale = if widest > 0.0 { CELLS / widest } else { 0.0 };
    let key = |point: &Vector| {
        (0..3).fold(0, |key, axis| {
            // The conversion ends at 0 and at the largest number.
            let cell = ((point[axis] - low[axis]) * scale) as u32;
            key | (spread(cell.min(CELLS as u32 - 1)) << axis)
        })
    };
    let mut keys: Vec<(u32, u32)> = (0..).zip(points).map(|(number, point)| (key(point), number)).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, number)| number).collect()
}

/// Ten bits with two zeros between each two of them.
fn spread(bits: u32) -> u32 {
    let bits = (bits | (bits << 16)) & 0x0300_00ff;
    let bits = (bits | (bits << 8)) & 0x0300_f00f;
    let bits = (bits | (bits << 4)) & 0x030c_30c3;
    (bits | (bits << 2)) & 0x0924_9249
}
