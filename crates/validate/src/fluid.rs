//! Cases of fluid in cracks.

mod breakdown;
mod flow;
mod invariants;
mod kgd;
pub(crate) mod list;
mod models;
mod penny;
mod walls;
