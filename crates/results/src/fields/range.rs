//! Ranges of the values of fields, and of their scales of colours.

/// Range of the values of a field in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// The least and the greatest finite value.
    pub(crate) ends: [f64; 2],
    /// The 1st and the 99th percentile.
    pub(crate) usual: [f64; 2],
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
