//! All that persists between steps of the flow in pores.

use serde::{Deserialize, Serialize};

/// State of a [`PorousMatrix`](crate::PorousMatrix): saved and restored, it continues with the same bits.
///
/// # Shapes
/// The first two columns have a row for each vertex, `inflow` one for each boundary in the order of the keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MatrixState {
    /// Liquid in the pores, m³ at the reference density: above zero pressure in the undeformed body.
    pub content: Vec<f64>,
    /// Pressure, Pa.
    pub pressure: Vec<f64>,
    /// Volume that has come in through each boundary, m³.
    pub inflow: Vec<f64>,
    /// Time, s.
    pub time: f64,
    /// Content at the beginning, m³.
    pub initial: f64,
    /// Volume that has come out of cracks, m³.
    pub exchanged: f64,
    /// Sum of the sizes of all volumes that have come in or gone out, m³.
    pub moved: f64,
}

impl MatrixState {
    /// Whether all columns have their lengths, and all numbers are finite.
    pub(crate) fn is_sound(&self, vertices: usize, boundaries: usize) -> bool {
        let totals = [self.time, self.initial, self.exchanged, self.moved];
        let columns = [&self.content[..], &self.pressure, &self.inflow, &totals];
        self.content.len() == vertices
            && self.pressure.len() == vertices
            && self.inflow.len() == boundaries
            && columns.iter().all(|column| column.iter().all(|value| value.is_finite()))
    }
}

/// Balance of the liquid in pores since the beginning, m³ at the reference density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreBalance {
    /// Content at the beginning.
    pub initial: f64,
    /// Volume that has come in through all boundaries, less the volume that has gone out.
    pub inflow: f64,
    /// Volume that has come out of cracks, less the volume that has gone into them.
    pub exchanged: f64,
    /// Content now.
    pub stored: f64,
    /// Sum of the sizes of all volumes that have come in or gone out.
    pub moved: f64,
}

impl PoreBalance {
    /// Volume that is not accounted for: `initial + inflow + exchanged - stored`, m³.
    pub fn error(&self) -> f64 {
        self.initial + self.inflow + self.exchanged - self.stored
    }
}
