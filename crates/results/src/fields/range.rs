//! Ranges of the values of fields, and of their scales of colours.

/// Range of the values of a field in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// The least and the greatest finite value.
    pub(crate) ends: [f64; 2],
    /// The 1st and the 99th percentile.
    pub(crate) usual: [f64; 2],
}

/// Ranges of the values of spheres in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SphereRanges {
    /// Those of the fields with a scale, in their order.
    pub(crate) scales: [Scale; 5],
    /// That of the normal forces of contacts.
    pub(crate) chains: Scale,
}

impl Scale {
    /// The range of no values.
    pub(crate) const NONE: Self = Self { ends: [0.0; 2], usual: [0.0; 2] };
}

impl SphereRanges {
    /// The ranges without spheres.
    pub(crate) const NONE: Self = Self { scales: [Scale::NONE; 5], chains: Scale::NONE };
}

/// The values at the two ends of a colour scale. Values beyond an end have the colour of that end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Value at the start.
    pub low: f64,
    /// Value at the end.
    pub high: f64,
}

impl Range {
    /// Returns the position of a value between the two ends: 0 at the low end, 1 at the high end.
    pub(crate) fn share(self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

impl Scale {
    /// Returns the range of values.
    pub(crate) fn of(values: &[f64]) -> Self {
        let mut finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
        let Some(last) = finite.len().checked_sub(1) else { return Self::NONE };
        let ends = finite
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)]);
        Self { ends, usual: [quantile(&mut finite, last / 100), quantile(&mut finite, last - last / 100)] }
    }
}

/// Returns the value that is at a place in the order of the values.
pub(crate) fn quantile(values: &mut [f64], place: usize) -> f64 {
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}
