//! The order in which points are inserted: successive points are near each other.

use super::vector::Point;
use crate::curve::place;

/// Bits of a coordinate.
const BITS: u32 = 20;

/// Points along Hilbert's curve through their bounding box.
pub(crate) fn along_curve(points: &[Point]) -> Vec<u32> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let most = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let per_length = if most > 0.0 { f64::from((1_u32 << BITS) - 1) / most } else { 0.0 };
    let mut keys: Vec<(u64, u32)> = points
        .iter()
        .zip(0..)
        .map(|(point, number)| {
            (place([0, 1, 2].map(|axis| ((point[axis] - low[axis]) * per_length) as u32), BITS), number)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, number)| number).collect()
}

/// An order in rounds: each has about twice the points of all before it, and runs along the curve. Then each
/// point meets a small neighbourhood that is near in memory.
///
/// # Source
/// N. Amenta, S. Choi, G. Rote, "Incremental constructions con BRIO", `SoCG` 2003; here each round takes
/// points at even distances along the curve.
pub(crate) fn rounds(along: &[u32]) -> Vec<u32> {
    let mut order = Vec::with_capacity(along.len());
    let mut step = (along.len() / 64).next_power_of_two();
    let mut skip = 0;
    while step > 0 {
        order.extend(
            along.iter().step_by(step).enumerate().filter(|(k, _)| skip == 0 || k % 2 == 1).map(|(_, &v)| v),
        );
        skip = step;
        step /= 2;
    }
    order
}

#[cfg(test)]
mod tests {
    use fdem_scenes::random::Random;

    use super::*;
    use crate::tetrahedra::vector::distance;

    #[test]
    fn points_along_the_curve_are_near_each_other_and_rounds_have_each_once() {
        let mut random = Random::new(1);
        let points: Vec<Point> = (0..4096).map(|_| [(); 3].map(|()| random.uniform())).collect();
        let along = along_curve(&points);
        let sum: f64 =
            along.windows(2).map(|pair| distance(points[pair[0] as usize], points[pair[1] as usize])).sum();
        assert!(sum / 4095.0 < 0.09, "{sum}");
        let mut all = rounds(&along);
        all.sort_unstable();
        assert!(all.into_iter().eq(0..4096));
    }
}
