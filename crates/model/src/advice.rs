//! Warnings and advice about a model, and mass scaling.

pub(crate) mod amounts;
pub(crate) mod deforming;
pub(crate) mod parts;
pub(crate) mod connected;
pub(crate) mod joined;
pub mod locking;
pub(crate) mod ready;
pub(crate) mod slivers;
pub(crate) mod pressing;
pub(crate) mod process_zone;
pub(crate) mod compliance;
pub(crate) mod loading_rate;
pub(crate) mod fine;
pub(crate) mod coarse;
pub(crate) mod quasi_static;
pub(crate) mod plausible;
pub(crate) mod too_fast;
pub(crate) mod equilibrium;
pub(crate) mod warnings;
pub(crate) mod overlaps;
pub(crate) mod differences;
pub(crate) mod scaling;
pub(crate) mod on_ranks;
pub(crate) mod clock;
pub(crate) mod preflight;
pub(crate) mod rehearsal;
