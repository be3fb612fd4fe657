//! Quantities that a run records.

pub(crate) mod fluid_columns;
pub(crate) mod coarse;
pub(crate) mod probes;
pub(crate) mod settings;
pub(crate) mod curves;
