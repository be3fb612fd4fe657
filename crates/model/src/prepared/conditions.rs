//! Conditions on a column of the history, which end a run or a stage, and servos, which move a boundary by
//! it.

use serde::{Deserialize, Serialize};

/// A condition on a column of the history.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreparedUntil {
    /// Name of the column.
    pub column: String,
    /// Its place in a row of the history.
    pub place: usize,
    /// When the condition is met.
    pub bound: Bound,
}

/// The value at which a condition is met.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Bound {
    /// Above this.
    Above(f64),
    /// Below this.
    Below(f64),
    /// At this share of the largest magnitude so far, which counts from `least` on.
    ShareOfPeak {
        /// The share.
        share: f64,
        /// Smallest magnitude of a peak.
        least: f64,
    },
}

/// Peaks of the conditions of a run, and whether it is over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Reached {
    /// Whether the run is over before its end time.
    pub over: bool,
    /// Whether the `until` of `[model]` was met.
    pub met: bool,
    /// The largest magnitudes of the columns that end the run and the stage.
    pub peaks: [f64; 2],
}

/// Control of a velocity by a column of the history.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PreparedServo {
    /// Number of the boundary in the model.
    pub boundary: usize,
    /// Place of the column among those of the `[[history]]` tables.
    pub place: usize,
    /// Value that the column gets to, before the schedule of the boundary.
    pub target: f64,
    /// Distance from the target within which the velocity falls.
    pub band: f64,
    /// Time steps between two looks.
    pub steps: u32,
}

impl PreparedUntil {
    /// Why the condition is met by a row of the history; `None` if it is not. `peak`: the largest magnitude
    /// of its column so far, which goes up.
    pub fn met(&self, row: &[f64], peak: &mut f64) -> Option<String> {
        let value = row[self.place];
        *peak = peak.max(value.abs());
        let is_met = match self.bound {
            Bound::Above(bound) => value > bound,
            Bound::Below(bound) => value < bound,
            Bound::ShareOfPeak { share, least } => {
                *peak > 0.0 && *peak >= least && value.abs() <= share * *peak
            }
        };
        is_met.then(|| match self.bound {
            Bound::Above(bound) => format!("{} is {value:.4e}, above {bound:.4e}", self.column),
            Bound::Below(bound) => format!("{} is {value:.4e}, below {bound:.4e}", self.column),
            Bound::ShareOfPeak { share, .. } => {
                format!("{} has fallen to {value:.4e}, {share} of its peak of {:.4e}", self.column, *peak)
            }
        })
    }
}

impl PreparedServo {
    /// The factor of the velocity. `scale`: factor of the target now.
    pub fn factor(&self, measured: f64, scale: f64) -> f64 {
        let lacks = (self.target * scale - measured) * self.target.signum();
        // A probe of removed parts measures nothing, and the boundary is not moved.
        if lacks.is_nan() { 0.0 } else { (lacks / self.band).clamp(-1.0, 1.0) }
    }
}
