//! All that persists between steps, as plain columns.

use serde::{Deserialize, Serialize};

/// State of a [`Network`](crate::Network): saved and restored, it continues with the same bits.
///
/// # Shapes
/// Columns have a row for each cell, in the order of the keys, and then one for each source, in the order of
/// theirs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NetworkState {
    /// Keys of the cells, in rising order.
    pub cells: Vec<u64>,
    /// Keys of the sources, in rising order.
    pub sources: Vec<u64>,
    /// Mass of fluid, kg.
    pub mass: Vec<f64>,
    /// Pressure, Pa.
    pub pressure: Vec<f64>,
    /// Pressure when the shapes were given, Pa.
    pub reference: Vec<f64>,
    /// Time at which fluid has reached the place, s; infinite before.
    pub wet_since: Vec<f64>,
    /// Whether it was open to fluid before, so that its initial pressure is in its mass.
    pub was_wet: Vec<bool>,
    /// Mass that each source has injected, kg.
    pub injected: Vec<f64>,
    /// Rate of each source in the last step, kg/s.
    pub rate: Vec<f64>,
    /// Time, s.
    pub time: f64,
    /// Mass of initial pressures, kg.
    pub initial: f64,
    /// Mass that has leaked off, kg.
    pub leaked: f64,
    /// Mass that was taken out with cells that are no more, kg.
    pub drained: f64,
    /// Mass that sources with negative rates could not take out, kg.
    pub missed: f64,
}

impl NetworkState {
    /// A dry member.
    pub(crate) fn push_dry(&mut self, lowest_pressure: f64) {
        self.mass.push(0.0);
        self.pressure.push(lowest_pressure);
        self.reference.push(lowest_pressure);
        self.wet_since.push(f64::INFINITY);
        self.was_wet.push(false);
    }

    /// Copies a row of another state.
    pub(crate) fn push_row(&mut self, of: &Self, row: usize) {
        self.mass.push(of.mass[row]);
        self.pressure.push(of.pressure[row]);
        self.reference.push(of.reference[row]);
        self.wet_since.push(of.wet_since[row]);
        self.was_wet.push(of.was_wet[row]);
    }

    /// Whether all columns have their lengths, and all numbers are finite.
    pub(crate) fn is_sound(&self) -> bool {
        let rows = self.cells.len() + self.sources.len();
        let columns = [&self.mass, &self.pressure, &self.reference, &self.wet_since];
        let totals = [self.time, self.initial, self.leaked, self.drained, self.missed];
        let finite = [&self.mass[..], &self.pressure, &self.reference, &self.injected, &self.rate, &totals];
        columns.iter().all(|column| column.len() == rows)
            && self.was_wet.len() == rows
            && [&self.injected, &self.rate].iter().all(|column| column.len() == self.sources.len())
            && finite.iter().all(|column| column.iter().all(|value| value.is_finite()))
            && self.wet_since.iter().all(|time| !time.is_nan())
            && self.mass.iter().all(|mass| *mass >= 0.0)
    }
}

/// Balance of the mass since the beginning, kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Mass in cells and sources when they became wet, by their initial pressures.
    pub initial: f64,
    /// Mass that all sources have injected, less the mass that they have taken out.
    pub injected: f64,
    /// Mass that has leaked off through the walls, or into pores less the mass out of them.
    pub leaked: f64,
    /// Mass that was taken out with cells: [`Network::drain`](crate::Network::drain).
    pub drained: f64,
    /// Mass in all cells and sources.
    pub stored: f64,
    /// Mass that sources with negative rates could not take out, because there was none.
    pub missed: f64,
}

impl Balance {
    /// Mass that is not accounted for: `initial + injected - leaked - drained - stored`, kg.
    pub fn error(&self) -> f64 {
        self.initial + self.injected - self.leaked - self.drained - self.stored
    }
}
