//! Overlaps of elements, and gaps between them.

use serde::Serialize;

use crate::network::Network;

/// Overlaps of couples that touch, and gaps of couples that are only within the tolerance.
///
/// # Units
/// The length unit of the centres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overlaps {
    /// Overlaps of the couples that touch: sum of radii minus distance, at least 0. `None` if no couple
    /// touches.
    pub overlaps: Option<Spread>,
    /// Gaps of the other couples: distance minus sum of radii, above 0. `None` if there are no others.
    pub gaps: Option<Spread>,
    /// Mean radius of the elements; `None` for points and without elements.
    pub mean_radius: Option<f64>,
    /// Mean overlap of the couples that touch, over the mean radius.
    pub mean_over_radius: Option<f64>,
}

/// Statistics of lengths.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Number of lengths.
    pub count: u64,
    /// Smallest length.
    pub min: f64,
    /// Mean length.
    pub mean: f64,
    /// Largest length.
    pub max: f64,
    /// Histogram from 0 to the largest length.
    pub histogram: Histogram,
}

/// Histogram of lengths with bins of equal width.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Width of a bin. The first bin starts at 0.
    pub width: f64,
    /// Number of lengths in each bin. A bin includes its lower limit; the last bin also includes its upper
    /// limit.
    pub counts: Vec<u64>,
}

/// Number of bins of a histogram.
const BINS: usize = 20;

impl Overlaps {
    /// The statistics of the overlaps of parts of the couples.
    pub(crate) fn of<const D: usize>(network: &Network<'_, D>, parts: &[&[f64]]) -> Self {
        let overlaps = Spread::of(parts, |overlap| (overlap >= 0.0).then_some(overlap));
        let gaps = Spread::of(parts, |overlap| (overlap < 0.0).then_some(-overlap));
        let n = network.space.centres.len();
        let of_points = network.sizes.are_points();
        let mean_radius = (n > 0 && !of_points)
            .then(|| (0..n).fold(0.0, |sum, index| sum + network.sizes.radius(index)) / n as f64);
        let mean_over_radius = match (&overlaps, mean_radius) {
            (Some(overlaps), Some(radius)) if radius > 0.0 => Some(overlaps.mean / radius),
            _ => None,
        };
        Self { overlaps, gaps, mean_radius, mean_over_radius }
    }
}

impl Spread {
    /// The statistics of the lengths that `length` makes of some overlaps. They are summed part by part.
    pub(crate) fn of(parts: &[&[f64]], length: impl Fn(f64) -> Option<f64>) -> Option<Self> {
        let (mut count, mut total) = (0, 0.0);
        let (mut min, mut max) = (f64::INFINITY, 0.0_f64);
        for part in parts {
            let mut sum = 0.0;
            for &overlap in *part {
                let Some(length) = length(overlap) else { continue };
                count += 1;
                sum += length;
                (min, max) = (min.min(length), max.max(length));
            }
            total += sum;
        }
        if count == 0 {
            return None;
        }
        let mut counts = vec![0; BINS];
        for part in parts {
            for &overlap in *part {
                let Some(length) = length(overlap) else { continue };
                // All lengths may be 0.
                let place = if max > 0.0 { length / max * BINS as f64 } else { 0.0 };
                counts[(place as usize).min(BINS - 1)] += 1;
            }
        }
        let histogram = Histogram { width: max / BINS as f64, counts };
        Some(Self { count, min, mean: total / count as f64, max, histogram })
    }
}
